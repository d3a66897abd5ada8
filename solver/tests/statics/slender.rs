//! Slender bodies on rollers, and a column that buckles.

use super::*;

/// Pressures of points, over faces.
pub(super) const POINTS: &str = "integration = { over = \"faces\", pressures = \"points\" }";

/// Half of a strip of thickness 1 under its load, on a roller at nine tenths of its half.
fn on_a_roller(length: f64, cells: usize, integration: &str) -> String {
    format!(
        r#"
[materials.steel]
young = 210000.0
poisson = 0.3
[parts.strip]
shape = "box"
size = [{:?}, 2.0, 1.0]
divisions = [{cells}, 1, 1]
element = "hex8i"
material = "steel"
[parts.roller]
shape = "rigid-cylinder"
axis = "y"
radius = 5.0
angles = [-90.0, 90.0]
length = 4.0
divisions = [24, 1]
translate = [{:?}, -1.0, -5.0]
[[boundary]]
nodes = "strip.x-"
fix = ["x"]
[[boundary]]
nodes = "strip.y-"
fix = ["y"]
[[boundary]]
nodes = "roller"
fix = ["x", "y", "z"]
[[pressure]]
surface = "strip.z+"
value = {:?}
[[interface]]
name = "support"
master = "roller"
slave = "strip.z-"
{integration}
"#,
        0.5 * length,
        0.45 * length,
        pressure_on(length),
    )
}

/// It bends a strip by about a fiftieth of its length.
fn pressure_on(length: f64) -> f64 {
    0.02 * length * 384.0 * 210_000.0 / 12.0 / (5.0 * length.powi(4))
}

/// The penetration by default is a ten-thousandth of what a slender strip bends by: gaps that are not linear open all contact.
#[test]
fn slender_strips_on_a_line_bend_as_beams_do() {
    let faces = "integration = \"faces\"";
    for (length, cells, integration) in [
        (100.0, 50, faces),
        (100.0, 50, ""),
        (100.0, 50, POINTS),
        (100.0, 10, POINTS),
        (200.0, 100, faces),
        (200.0, 100, ""),
        (200.0, 100, POINTS),
        (1000.0, 250, faces),
        (1000.0, 250, ""),
        (1000.0, 250, POINTS),
    ] {
        let (notes, state, _) = run(&on_a_roller(length, cells, integration), "[time]\nincrement = 0.25");
        assert!(notes.cuts.is_empty(), "{length} {integration}: {:?}", notes.cuts);
        let iterations: usize = notes.increments.iter().map(|record| record.iterations).sum();
        assert!(iterations <= 36, "{length} {integration}: {iterations}");
        let last = notes.increments.last().unwrap();
        let load = pressure_on(length) * length;
        assert!((last.contacts[0].force[2] / load - 1.0).abs() < 1e-3, "{:?}", last.contacts[0].force);
        // Of a beam with free ends on two supports.
        let (span, end, bending) = (0.9 * length, 0.05 * length, 2.0 * 210_000.0 / 12.0);
        let theory = 2.0 * pressure_on(length) / bending
            * (5.0 * span.powi(4) / 384.0 - end.powi(2) * span.powi(2) / 16.0);
        let (middle, support) = (state.positions[0], state.positions[cells * 9 / 10]);
        assert!(
            (support[2] - middle[2]) / theory > 0.98 && (support[2] - middle[2]) / theory < 1.03,
            "{length} {integration}: {middle:?} {support:?} {theory}"
        );
    }
}

/// No row of nodes is above the roller.
#[test]
fn contact_that_opens_again_and_again_is_found_with_softer_penalties() {
    let (notes, ..) = run(&on_a_roller(500.0, 125, "integration = \"faces\""), "[time]\nincrement = 0.1");
    assert!(notes.cuts.is_empty(), "{:?}", notes.cuts);
    assert!(notes.increments.iter().any(|record| record.softened));
    let last = notes.increments.last().unwrap();
    let load = pressure_on(500.0) * 500.0;
    assert!((last.contacts[0].force[2] / load - 1.0).abs() < 1e-3, "{:?}", last.contacts[0].force);
}

/// Euler's column whose ends do not turn, free to move sideways above: π² E I / L² in two directions.
#[test]
fn a_column_under_more_than_its_critical_load_is_told_to_be_unstable() {
    let column = |shortening: f64| {
        format!(
            "[materials.steel]\nyoung = 210000.0\npoisson = 0.0\n[parts.column]\nshape = \"box\"\nsize = [1.0, 1.0, 50.0]\n\
             divisions = [1, 1, 50]\nelement = \"hex8i\"\nmaterial = \"steel\"\n[[boundary]]\nnodes = \"column.z-\"\n\
             fix = [\"x\", \"y\", \"z\"]\n[[boundary]]\nnodes = \"column.z+\"\ntranslate = [\"free\", \"free\", {:?}]\n",
            -shortening
        )
    };
    let critical = std::f64::consts::PI.powi(2) / 12.0 / 50.0;
    for (part, negative) in [(0.97, 0), (1.04, 2), (3.8, 2), (4.2, 4)] {
        // The last increment's stiffness is that at its beginning.
        let time = "[time]\nincrement = 0.01";
        let (notes, ..) = run(&column(part * critical), time);
        let last = notes.increments.last().unwrap();
        assert_eq!((last.negative, last.is_unstable()), (Some(negative), negative > 0), "{part}");
    }
}

/// Averages over faces of half the roller's radius close a sixtieth of it late: a tenth of what the strip moves.
#[test]
fn faces_that_touch_late_are_told() {
    let late = |cells: usize| {
        let (notes, ..) =
            run(&on_a_roller(50.0, cells, "integration = \"faces\""), "[time]\nincrement = 0.5");
        let penetrations = &notes.increments.last().unwrap().penetrations;
        penetrations.iter().map(|(_, found)| found.part_of_motion).fold(0.0, f64::max)
    };
    assert!(late(10) > 0.05 && late(10) < 0.3, "{}", late(10));
    assert!(late(100) == 0.0, "{}", late(100));
}

/// A strip whose middle is moved down onto a roller below the middle of a face of twice its radius. An average gap closes a sixth of the
/// face's size late, a point when it touches.
#[test]
fn points_of_coarse_faces_carry_what_a_beam_does() {
    // A cantilever from the middle of the strip, which goes down by 2, to the roller.
    let theory = 3.0 * 210_000.0 * (2.0 / 12.0) * 2.0 / 45.0_f64.powi(3);
    let moved = "nodes = \"strip.x-\"\ntranslate = [0.0, \"free\", -2.0]";
    let deck = on_a_roller(100.0, 5, POINTS)
        .replace("nodes = \"strip.x-\"\nfix = [\"x\"]", moved)
        .replace(&format!("value = {:?}", pressure_on(100.0)), "value = 0.0");
    let (notes, ..) = run(&deck, "[time]\nincrement = 0.25");
    let iterations: usize = notes.increments.iter().map(|record| record.iterations).sum();
    assert!(iterations <= 44 && notes.cuts.len() <= 1, "{iterations}");
    let last = notes.increments.last().unwrap();
    let found = &last.contacts[0];
    assert!((found.force[2] / found.normal - 1.0).abs() < 0.01, "{found:?}");
    // A face whose middle is loaded goes straight from node to node: too stiff.
    assert!(found.force[2] > theory && found.force[2] < 1.08 * theory, "{found:?}");
    // What touches is narrow beside the face.
    assert!(found.area < 4.0 && last.max_penetration > 0.0 && last.max_penetration < 0.05, "{found:?}");
}

/// A strip between four rollers in touch with it: where its faces are wide beside them, all average gaps are open, and nothing is said to be
/// closed. The message names the interfaces and what closes them.
#[test]
fn averages_that_hide_a_touch_are_named_where_a_part_is_loose() {
    let roller = |name: &str, [x, z]: [f64; 2], angles: &str, way: f64| {
        format!(
            "[parts.{name}]\nshape = \"rigid-cylinder\"\naxis = \"y\"\nradius = 1.5\nangles = {angles}\nlength = 6.0\n\
             divisions = [24, 3]\ntranslate = [{x:?}, -1.0, {z:?}]\n[[boundary]]\nnodes = \"{name}\"\ntranslate = [0.0, 0.0, {way:?}]\n"
        )
    };
    let [above, below] = ["[-90.0, 90.0]", "[90.0, 270.0]"];
    let rollers = [
        roller("a", [12.0, -1.5], above, 0.0),
        roller("b", [18.0, -1.5], above, 0.0),
        roller("c", [90.0, -1.5], above, 0.0),
        roller("p", [50.0, 2.5], below, -2.0),
    ]
    .concat();
    let deck = format!(
        "[materials.steel]\nyoung = 200000.0\npoisson = 0.3\n[parts.strip]\nshape = \"box\"\nsize = [100.0, 4.0, 1.0]\n\
         divisions = [40, 1, 1]\nelement = \"hex8i\"\nmaterial = \"steel\"\n{rollers}[[boundary]]\nnodes = \"strip.y-\"\nfix = [\"y\"]\n\
         [[boundary]]\nnodes = \"strip.x-\"\nfix = [\"x\"]\n[[interface]]\nname = \"below\"\nmaster = [\"a\", \"b\", \"c\"]\n\
         slave = \"strip.z-\"\nintegration = \"faces\"\n[[interface]]\nname = \"above\"\nmaster = \"p\"\nslave = \"strip.z+\"\n\
         integration = \"faces\"\n"
    );
    let (_, error, ..) = fail(&deck, "[time]\nincrement = 0.1");
    let said = error.to_string();
    assert!(
        said.contains("nothing holds `strip` against moving along z")
            && said.contains("pressures = \"points\""),
        "{said}"
    );
}

/// A strip that points of its coarse faces hold on a roller, and a block that is loose above a floor: what is supposed for the block leaves the
/// strip's contact as it is.
#[test]
fn points_that_touch_go_on_while_another_body_is_caught() {
    let strip = on_a_roller(100.0, 5, POINTS);
    let deck = format!(
        r#"{strip}
[parts.floor]
shape = "rigid-plane"
size = [3.0, 3.0]
divisions = [3, 3]
translate = [0.0, 20.0, 0.0]
[parts.block]
shape = "box"
size = [1.0, 1.0, 1.0]
divisions = [2, 2, 2]
material = "steel"
translate = [1.0, 21.0, 0.01]
[[boundary]]
nodes = "floor"
fix = ["x", "y", "z"]
[[boundary]]
nodes = "block.x-"
fix = ["x"]
[[boundary]]
nodes = "block.y-"
fix = ["y"]
[[pressure]]
surface = "block.z+"
value = 1.0
[[interface]]
name = "floor"
master = "floor"
slave = "block.z-"
integration = "faces"
"#
    );
    let (notes, ..) = run(&deck, "[time]\nincrement = 0.25");
    assert!(notes.cuts.is_empty(), "{:?}", notes.reasons);
    assert!(notes.increments[0].supposed > 0);
    let last = notes.increments.last().unwrap();
    let load = pressure_on(100.0) * 100.0;
    assert!((last.contacts[0].force[2] / load - 1.0).abs() < 1e-3, "{:?}", last.contacts[0].force);
    assert!((last.contacts[1].force[2] - 1.0).abs() < 1e-3, "{:?}", last.contacts[1].force);
}
