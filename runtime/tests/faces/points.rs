//! Gaps, pressures and tractions of the integration points.

use super::*;
use diffuse_contact::Coulomb;

/// Of points and of nodes: areas, gaps, pressures and tractions over them.
fn integrals(interface: &FaceInterface) -> [Vec<f64>; 2] {
    let points = interface.integration_points().unwrap();
    let of_point = |p: &IntegrationPoint| {
        let [x, y, z] = p.friction;
        [1.0, p.gap, p.pressure, x, y, z].map(|value| p.area * value)
    };
    let of_node = |node: &NodeContact| {
        let [x, y, z] = node.friction;
        [1.0, node.gap, node.pressure, x, y, z].map(|value| node.area * value)
    };
    let sum = |terms: Vec<[f64; 6]>| (0..6).map(|k| terms.iter().map(|term| term[k]).sum()).collect();
    let nodes = interface.contacts().nodes();
    [sum(points.iter().map(of_point).collect()), sum(nodes.iter().map(of_node).collect())]
}

#[test]
fn points_of_flat_faces_have_the_uniform_pressure() {
    let flat = |z: f64| move |x: f64, y: f64| [x, y, z];
    let pair = Pair::new([6, 4], false, flat(0.0), flat(-0.02));
    for element in elements() {
        let mut interface = pair.interface(element, FaceRule::Second);
        assert_eq!(interface.integration_points(), Err(InterfaceError::NotRefreshed));
        let report = interface.refresh(&pair.positions).unwrap();
        assert!(interface.integration_points().unwrap().iter().all(|point| point.pressure == 0.0));
        interface.evaluate(&ContactLaw::penalty(50.0), Mode::Value).unwrap();
        let points = interface.integration_points().unwrap();
        assert_eq!(points.len(), report.points);
        for point in &points {
            let inside = |corner: &usize| {
                let x = pair.positions[*corner];
                (0..2).all(|axis| (x[axis] - point.position[axis]).abs() < 1.5)
            };
            assert!(pair.slave[point.face].corners().iter().all(inside), "{point:?}");
            assert!(
                (point.position[2] + 0.02).abs() < 1e-14 && (point.gap + 0.02).abs() < 1e-14,
                "{point:?}"
            );
            assert!((point.pressure - 1.0).abs() < 1e-12 && point.friction == [0.0; 3], "{point:?}");
            assert!((Vector3::from(point.normal) - Vector3::z()).norm() < 1e-14, "{point:?}");
        }
        assert!((points.iter().map(|point| point.area).sum::<f64>() - 36.0).abs() < 1e-12);
    }
}

/// Shape functions add up to one: what the points integrate is what the nodes do.
#[test]
fn points_integrate_to_what_nodes_carry() {
    for (element, pressures) in pairs(elements(), FacePressures::ALL) {
        for triangles in [false, true] {
            let pair = bumps(triangles);
            let mut interface = pair.interface(element, FaceRule::Fourth);
            interface.set_pressures(pressures);
            let law = ContactLaw::penalty(50.0).with_friction(Some(Coulomb::new(0.3, 60.0).unwrap()));
            interface.refresh(&pair.positions).unwrap();
            interface.accept(&law).unwrap();
            let mut moved = pair.positions.clone();
            moved[pair.first_slave..].iter_mut().for_each(|x| x[0] += 0.01);
            interface.refresh(&moved).unwrap();
            interface.evaluate(&law, Mode::Gradient).unwrap();
            let [points, nodes] = integrals(&interface);
            assert!(nodes[2] > 1.0 && nodes[3] < -0.1, "{nodes:?}");
            // Of friction by points the part across their normals counts.
            let same = if pressures == FacePressures::Nodes { 6 } else { 3 };
            for (point, node) in points.iter().zip(&nodes).take(same) {
                assert!((point - node).abs() < 1e-12 * nodes[0], "{points:?} {nodes:?}");
            }
            for point in interface.integration_points().unwrap() {
                let normal = Vector3::from(point.normal).dot(&Vector3::from(point.friction));
                assert!(pressures == FacePressures::Nodes || normal.abs() < 1e-14, "{point:?}");
            }
        }
    }
}

/// A cylinder that touches a face in its middle only: the average gap is open, while its points carry what the penalty says of a
/// parabola.
#[test]
fn points_of_their_own_pressure_carry_what_averages_miss() {
    const RADIUS: f64 = 30.0;
    const DEPTH: f64 = 0.01;
    let low = |x: f64, y: f64| [x, y, (RADIUS * RADIUS - (x - 3.0) * (x - 3.0)).sqrt() - RADIUS];
    let high = |x: f64, y: f64| [x, 0.5 + 0.8 * y, -DEPTH];
    let mut pair = Pair::new([60, 1], false, low, high);
    // One layer of cells below is enough.
    pair.master.truncate(2400);
    let law = ContactLaw::penalty(50.0);
    let mut interface = pair.interface(ContactElement::default(), FaceRule::Second);
    interface.refresh(&pair.positions).unwrap();
    let averages = interface.evaluate(&law, Mode::Gradient).unwrap();
    assert_eq!(averages.active(), 0);
    interface.set_pressures(FacePressures::Points);
    let contacts = interface.evaluate(&law, Mode::Gradient).unwrap();
    // ∫ ε (δ − x²/2R) dx over |x| < √(2Rδ), and as long as the master's facets go on over the face.
    let length = 4.0 - 0.5;
    let expected = 50.0 * 4.0 / 3.0 * DEPTH * (2.0 * RADIUS * DEPTH).sqrt() * length;
    let found: f64 = pair.forces(contacts)[pair.first_slave..].iter().map(|force| force[2]).sum();
    assert!((found - expected).abs() < 0.01 * expected, "{found} {expected}");
    for node in contacts.nodes() {
        assert!(node.gap > 0.0 && (node.smallest_gap + DEPTH).abs() < 0.01 * DEPTH, "{node:?}");
        assert!(node.pressure > 0.0 && node.stiffness > 0.0 && node.stiffness < 50.0, "{node:?}");
    }
    pair.assert_balance_of(&pair.forces(contacts), 0.5 * expected);
    // A multiplier of all nodes is one of all points, as if they lay deeper by λ/ε.
    let multipliers = vec![50.0 * DEPTH; interface.slaves().len()];
    let contacts = interface.evaluate(&law.with_multipliers(Some(&multipliers)), Mode::Gradient).unwrap();
    let expected = expected * 2.0_f64.powf(1.5);
    let found: f64 = pair.forces(contacts)[pair.first_slave..].iter().map(|force| force[2]).sum();
    assert!((found - expected).abs() < 0.01 * expected, "{found} {expected}");
}
