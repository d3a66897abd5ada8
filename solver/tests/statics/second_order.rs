//! Slave faces of second order over nodes and over faces: what a run says of them, and what their pressures are.

use super::start::TIME;
use super::*;
use diffuse_contact_solver::contact::Beginning;

/// A block that is pressed evenly onto a floor: over nodes forces of faces with 6 and 9 nodes are right, where corners carry too little, and
/// those of faces with 8 too low. A warning says which it is.
#[test]
fn faces_of_second_order_over_nodes_are_told_by_what_is_wrong_with_them() {
    const CORNERS: &str =
        "18 faces of the slave have 6 nodes: their corners carry no part of a uniform pressure";
    const MIDDLES: &str = "9 faces of the slave have 9 nodes: their corners carry 4/9 of a uniform pressure and their middles 16/9";
    const PULL: &str = "9 faces of the slave have 8 nodes: under a pressure their corners would pull";
    const NODES: &str = "areas = true";
    const FACES: &str = "integration = \"faces\"";
    // The force over E A s/h, with the pressures' standard deviation over their mean.
    for (element, interface, told, force_within, scatter_within) in [
        ("tet10", NODES, Some(CORNERS), 0.97..1.03, 0.4..0.7),
        ("hex20", NODES, Some(PULL), 0.8..0.95, 0.4..2.0),
        ("hex27", NODES, Some(MIDDLES), 0.97..1.03, 0.4..0.7),
        ("hex8", NODES, None, 0.97..1.03, 0.0..0.1),
        ("tet10", FACES, None, 0.97..1.03, 0.0..0.1),
        ("hex20", FACES, None, 0.97..1.03, 0.0..0.1),
        ("hex27", FACES, None, 0.97..1.03, 0.0..0.1),
    ] {
        let text = format!(
            r#"
[materials.soft]
young = 1000.0
poisson = 0.0
[parts.floor]
shape = "rigid-plane"
size = [5.0, 5.0]
divisions = [5, 5]
[parts.block]
shape = "box"
origin = [1.0, 1.0, 0.0]
size = [3.0, 3.0, 1.0]
divisions = [3, 3, 1]
element = "{element}"
material = "soft"
[[boundary]]
nodes = "floor"
fix = ["x", "y", "z"]
[[boundary]]
nodes = "block.z+"
translate = [0.0, 0.0, -0.01]
[[interface]]
name = "floor"
master = "floor"
slave = "block.z-"
penalty = 1e6
{interface}
"#
        );
        let (notes, _, statics) = run(&text, TIME);
        let contact = &statics.problem().contacts().interactions()[0];
        let pressures: Vec<f64> = contact.slaves().map(|slave| slave.force / slave.area).collect();
        let mean = pressures.iter().sum::<f64>() / pressures.len() as f64;
        let squares: f64 = pressures.iter().map(|pressure| (pressure / mean - 1.0).powi(2)).sum();
        let scatter = (squares / pressures.len() as f64).sqrt();
        let force = notes.increments[0].contacts[0].force[2].abs() / 90.0;
        assert!(
            force_within.contains(&force) && scatter_within.contains(&scatter),
            "{element} {interface}: {force} {scatter}"
        );
        let warnings = Beginning::of(contact, &deck(&text, TIME).1, statics.problem()).warnings();
        let found: Vec<&String> =
            warnings.iter().filter(|text| text.contains("faces of the slave")).collect();
        assert_eq!(found.len(), usize::from(told.is_some()), "{element} {interface}: {warnings:?}");
        assert!(told.is_none_or(|told| found[0].contains(told)), "{found:?}");
    }
}
