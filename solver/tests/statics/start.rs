//! Starts: bodies exactly in touch or a little apart, a penalty that nobody gave, parts that nothing holds.

use super::slender::POINTS;
use super::*;
use diffuse_contact_solver::contact::{AdjustError, Beginning};
use diffuse_contact_solver::deck::{DeckError, Problem as Wrong};
use diffuse_contact_solver::model::AdjustedNode;

/// A block on another, pressed, held sideways; between them a gap.
fn stacked(gap: f64, interface: &str, element: &str) -> String {
    format!(
        r#"
[materials.soft]
young = 1000.0
poisson = 0.3
[materials.stiff]
young = 3000.0
poisson = 0.2
[parts.lower]
shape = "box"
size = [4.0, 4.0, 1.0]
divisions = [4, 4, 1]
material = "stiff"
[parts.upper]
shape = "box"
origin = [0.0, 0.0, {:?}]
size = [4.0, 4.0, 1.0]
divisions = [3, 3, 1]
element = "{element}"
material = "soft"
[[boundary]]
nodes = "lower.z-"
fix = ["z"]
[[boundary]]
nodes = ["lower.x-", "upper.x-"]
fix = ["x"]
[[boundary]]
nodes = ["lower.y-", "upper.y-"]
fix = ["y"]
[[pressure]]
surface = "upper.z+"
value = 10.0
[[interface]]
name = "joint"
master = "lower.z+"
slave = "upper.z-"
{interface}
"#,
        1.0 + gap
    )
}

pub const TIME: &str = "[time]\nincrement = 1.0";

/// Nothing but contact holds the upper block: it does so from the first linear solution on, whatever the gap below a facet's size.
#[test]
fn a_body_that_only_contact_holds_is_held() {
    for (interface, element) in [
        ("", "hex8"),
        ("integration = \"faces\"", "hex8"),
        ("integration = \"faces\"\ntwo_pass = true", "hex20"),
    ] {
        let heights = [0.0, 0.3, 0.5].map(|gap| {
            let (notes, state, statics) = run(&stacked(gap, interface, element), TIME);
            let record = &notes.increments[0];
            assert_eq!((record.supposed, record.stabilised), (1, 0), "{gap} {interface}");
            assert!(
                notes.cuts.is_empty() && record.iterations <= 4,
                "{gap} {interface}: {}",
                record.iterations
            );
            let force: f64 = record.contacts[0].force[2];
            assert!((force / 160.0 - 1.0).abs() < 1e-6, "{gap} {interface}: {force}");
            // Multipliers that were supposed are gone.
            assert!(statics.problem().contacts().multipliers().iter().all(Vec::is_empty));
            state.positions.iter().map(|x| x[2]).fold(0.0, f64::max)
        });
        // The same end from wherever the block began.
        assert!(heights.iter().all(|height| (height - heights[0]).abs() < 1e-7), "{interface}: {heights:?}");
    }
}

/// A deck over nodes as it is, and over faces with pressures of nodes and of points.
fn all_ways(deck: &str) -> [String; 3] {
    let over_faces = ["integration = \"faces\"", POINTS].map(|way| deck.replace("areas = true", way));
    let [of_nodes, of_points] = over_faces;
    [deck.to_owned(), of_nodes, of_points]
}

/// Gaps of exactly 0 and a load: the block stays, and each increment carries its part of 100 × 36.
#[test]
fn a_block_exactly_in_touch_carries_its_load() {
    for deck in all_ways(include_str!("hanging.toml")) {
        let (notes, ..) = run(&deck, "");
        assert!(notes.cuts.is_empty() && notes.increments.len() == 10, "{:?}", notes.reasons);
        assert_eq!(notes.increments.iter().map(|record| record.stabilised).sum::<usize>(), 0);
        for record in &notes.increments {
            let [contact] = record.contacts[..] else { panic!("one interface") };
            assert!((contact.force[2] / (3600.0 * record.time) - 1.0).abs() < 1e-4, "{contact:?}");
        }
    }
}

/// A round cord between plates that both touch it along a line: squeezed by a quarter of its height from the first increment on.
#[test]
fn an_o_ring_exactly_in_touch_is_squeezed() {
    for deck in all_ways(include_str!("o_ring.toml")) {
        let (notes, ..) = run(&deck, "");
        assert!(notes.cuts.is_empty() && notes.increments.len() == 20, "{:?}", notes.reasons);
        assert_eq!(notes.increments.iter().map(|record| record.stabilised).sum::<usize>(), 0);
        let mut before = 0.0;
        for record in &notes.increments {
            let [lower, upper] = [0, 1].map(|k| record.contacts[k].force[2]);
            assert!(
                lower > before && (lower + upper).abs() < 1e-4 * lower,
                "{}: {lower} {upper}",
                record.time
            );
            before = lower;
        }
    }
}

/// A gap larger than a facet is none that contact closes, and the message says what is free.
#[test]
fn a_body_far_from_its_master_is_named() {
    let (notes, error, ..) = fail(&stacked(1.5, "", "hex8"), TIME);
    assert!(notes.cuts.is_empty(), "{:?}", notes.cuts);
    assert!(
        error.to_string().contains("nothing holds `upper` against moving along z; a `boundary` can hold it"),
        "{error}"
    );
}

/// What is free is found for a part that turns, and for parts that hold one another.
#[test]
fn free_motions_are_found() {
    let of = |text: &str| match fail(text, TIME).1 {
        StaticsError::Singular { loose, .. } => loose,
        error => panic!("{error}"),
    };
    let base = stacked(0.0, "", "hex8");
    // Without its supports along x and y the upper block slides and turns on the lower one.
    let free = base.replace("[\"lower.x-\", \"upper.x-\"]", "\"lower.x-\"");
    let free = free.replace("[\"lower.y-\", \"upper.y-\"]", "\"lower.y-\"");
    let text = of(&free).iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
    assert_eq!(
        text,
        "nothing holds `upper` against moving along x, moving along y, turning about z through (2, 2, 1.5)"
    );
    // Pinned along an edge, it turns about the edge.
    let pinned =
        base.replace("[[pressure]]", "[[boundary]]\nnodes = \"upper.z-\"\nfix = [\"z\"]\n[[pressure]]");
    let pinned = pinned.replace("[\"lower.y-\", \"upper.y-\"]", "\"lower.y-\"");
    let [Loose { parts, motions, .. }] = &of(&pinned)[..] else { panic!("one part") };
    assert_eq!(
        (&parts[..], &motions[..]),
        (&["upper".to_owned()][..], &[RigidMotion::Translation([0.0, 1.0, 0.0])][..])
    );
    // Each block holds the other along z, and nothing both of them.
    let both = base.replace("nodes = \"lower.z-\"\nfix = [\"z\"]", "nodes = \"lower.x+\"\nfix = [\"x\"]");
    let [Loose { parts, motions, .. }] = &of(&both)[..] else { panic!("both parts") };
    assert_eq!(parts[..], ["lower".to_owned(), "upper".to_owned()]);
    assert_eq!(motions[..], [RigidMotion::Translation([0.0, 0.0, 1.0])]);
}

/// Blocks at `places` with a free motion each, on one rigid floor and one interface.
fn scattered(blocks: &[(&str, [f64; 3])], more: &str) -> String {
    let mut text = "[materials.m]\nyoung = 1000.0\npoisson = 0.3\n[parts.floor]\nshape = \"rigid-plane\"\nsize = [20.0, 4.0]\n\
                    divisions = [20, 4]\ntranslate = [-1.0, -1.0, 0.0]\n[[boundary]]\nnodes = \"floor\"\nfix = [\"x\", \"y\", \"z\"]\n"
        .to_owned();
    for (name, [x, y, z]) in blocks {
        text += &format!(
            "[parts.{name}]\nshape = \"box\"\norigin = [{x:?}, {y:?}, {z:?}]\nsize = [1.0, 1.0, 1.0]\ndivisions = [1, 1, 1]\n\
             material = \"m\"\n"
        );
    }
    text + more
}

/// Each loose part is held by its own slaves, however near those of others are; parts that are held keep their gaps.
#[test]
fn every_loose_part_finds_its_own_contact() {
    let mut more = String::new();
    for name in ["near", "far", "held"] {
        more += &format!("[[boundary]]\nnodes = [\"{name}.x-\", \"{name}.x+\"]\nfix = [\"x\"]\n");
        more += &format!("[[boundary]]\nnodes = [\"{name}.y-\", \"{name}.y+\"]\nfix = [\"y\"]\n");
        more += &format!("[[pressure]]\nsurface = \"{name}.z+\"\nvalue = 1.0\n");
    }
    more += "[[boundary]]\nnodes = \"held.z-\"\nfix = [\"z\"]\n[[interface]]\nname = \"joint\"\nmaster = \"floor\"\n\
             slave = [\"near.z-\", \"far.z-\", \"held.z-\"]\n";
    let blocks = [("near", [0.0, 0.0, 0.1]), ("far", [4.0, 0.0, 0.7]), ("held", [8.0, 0.0, 0.05])];
    let (notes, state, _) = run(&scattered(&blocks, &more), TIME);
    let record = &notes.increments[0];
    assert!(record.supposed == 1 && notes.cuts.is_empty() && record.iterations <= 4, "{record:?}");
    let lowest =
        |range: std::ops::Range<usize>| state.positions[range].iter().map(|x| x[2]).fold(9.0, f64::min);
    let floor = 21 * 5;
    for block in 0..2 {
        let height = lowest(floor + 8 * block..floor + 8 * (block + 1));
        assert!(height < 0.0 && height > -1e-3, "{block}: {height}");
    }
    assert!((lowest(floor + 16..floor + 24) - 0.05).abs() < 1e-12);
}

/// Only what is free is named: not a part that is held as far as it has free nodes, and parts that hold one another as one.
#[test]
fn parts_that_are_held_are_not_named() {
    let text = |more: &str| scattered(&[("held", [0.0, 0.0, 5.0]), ("loose", [4.0, 0.0, 5.0])], more);
    // Of `held` only the nodes at one end move, and only along y.
    let held = "[[boundary]]\nnodes = \"held.x-\"\nfix = [\"x\", \"y\", \"z\"]\n[[boundary]]\nnodes = \"held.x+\"\nfix = [\"x\", \"z\"]\n";
    let (_, StaticsError::Singular { loose, .. }, _) = fail(&text(held), TIME) else { panic!("singular") };
    assert_eq!((loose.len(), &loose[0].parts[..]), (1, &["loose".to_owned()][..]), "{loose:?}");
    assert_eq!(loose[0].motions.len(), 6);
}

/// Elements of a part that share no node with the others are named by a node.
#[test]
fn pieces_of_a_part_are_told_apart() {
    let directory = std::env::temp_dir().join(format!("diffuse-contact-pieces-{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    let mut mesh = "*NODE\n".to_owned();
    for (first, x) in [(1, 0.0), (9, 5.0)] {
        for (k, [a, b, c]) in
            [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
                .into_iter()
                .enumerate()
        {
            mesh += &format!("{}, {}, {b}, {c}\n", first + k, x + f64::from(a));
        }
    }
    mesh += "*ELEMENT, TYPE=C3D8, ELSET=ALL\n1, 1, 2, 3, 4, 5, 6, 7, 8\n2, 9, 10, 11, 12, 13, 14, 15, 16\n*NSET, NSET=HELD\n1, 4, 5, 8\n";
    std::fs::write(directory.join("two.inp"), mesh).unwrap();
    let text = format!(
        "[materials.m]\nyoung = 1.0\npoisson = 0.3\n[parts.two]\nfile = \"two.inp\"\nmaterial = \"m\"\n[[boundary]]\n\
         nodes = \"two.HELD\"\nfix = [\"x\", \"y\", \"z\"]\n{TIME}"
    );
    let deck = Deck::parse(&text).unwrap();
    let mut statics = statics(&deck, &deck.model(&directory).unwrap());
    let start = statics.problem().start();
    let StaticsError::Singular { loose, .. } = statics.run(start, &mut Notes::default()).unwrap_err() else {
        panic!("singular")
    };
    std::fs::remove_dir_all(&directory).unwrap();
    assert_eq!((loose.len(), loose[0].motions.len()), (1, 6));
    assert_eq!(loose[0].parts, ["two, the piece of node 8 of the results"]);
}

/// Points are told in digits of the model, whatever its unit of length.
#[test]
fn axes_of_small_and_large_parts_are_told() {
    for (edge, axis) in [("2e-5", "(0.00002, 0.00001, 0.00001)"), ("2e5", "(200000, 100000, 100000)")] {
        let origin = edge.replace('2', "1");
        let block = format!(
            "[materials.m]\nyoung = 1.0\npoisson = 0.3\n[parts.block]\nshape = \"box\"\norigin = [{origin}, 0.0, 0.0]\n\
             size = [{edge}, {edge}, {edge}]\ndivisions = [1, 1, 1]\nmaterial = \"m\"\n"
        );
        let (_, error, _) = fail(&block, TIME);
        let text = format!("turning about x through {axis}");
        assert!(error.to_string().contains(&text), "{error}");
    }
}

/// A screw is told from a turn.
#[test]
fn a_screw_has_a_pitch() {
    let turn = RigidMotion::Rotation { axis: [0.0, 0.0, 1.0], point: [0.5, -0.0, 0.0], pitch: 0.0 };
    assert_eq!(turn.to_string(), "turning about z through (0.5, 0, 0)");
    let screw = RigidMotion::Rotation { axis: [0.6, 0.0, 0.8], point: [0.5, 0.0, 0.0], pitch: 0.25 };
    assert_eq!(
        screw.to_string(),
        "turning about (0.600, 0.000, 0.800) through (0.5, 0, 0) while moving along it by 0.25 a radian"
    );
}

/// A block in touch, pushed down by so much at once that it is through before it ever carried a force: a shorter increment has to do. A
/// failure says so, too, if slaves left the master over its border.
#[test]
fn a_block_that_goes_through_another_or_over_its_border_is_told() {
    let deck = |way: &str, integration: &str| {
        format!(
            r#"
[materials.steel]
young = 200000.0
poisson = 0.3
[parts.lower]
shape = "box"
size = [2.0, 1.0, 1.0]
divisions = [6, 3, 3]
material = "steel"
[parts.upper]
shape = "box"
origin = [0.0, 0.0, 1.0]
size = [1.0, 1.0, 1.0]
divisions = [4, 4, 4]
material = "steel"
[[boundary]]
nodes = "lower.z-"
fix = ["x", "y", "z"]
[[boundary]]
nodes = ["upper.x-"]
fix = ["x"]
[[boundary]]
nodes = ["upper.z+"]
translate = ["free", 0.0, {way}]
[[interface]]
name = "joint"
master = "lower.z+"
slave = "upper.z-"
integration = "{integration}"
"#
        )
    };
    let time = "[time]\nincrement = 1.0\nminimum = 0.4";
    let (notes, _, _) = run(&deck("-3.0", "faces"), time);
    assert!(notes.cuts.len() == 1 && notes.reasons[0].contains("Through"), "{:?}", notes.reasons);
    // Where no increment may be shorter it is counted and told.
    assert_eq!(notes.increments[0].lost, 25);
    fail(&deck("-3.0", "nodes"), time);
    // Sides that are flush: nodes leave the border as the block bulges.
    let (_, error, _) = fail(&deck("-0.2", "nodes"), "[time]\nincrement = 0.25\nminimum = 0.1");
    let text = error.to_string();
    assert!(text.contains("beyond the master's border") && text.contains("border_tolerance"), "{text}");
}

/// Plates of a fifth of a facet's size: one moves beyond the other at once, by less than half of a facet. A shorter increment bends it.
#[test]
fn a_plate_does_not_go_through_a_thin_one() {
    let deck = |sides: &str| {
        format!(
            r#"
[materials.steel]
young = 200000.0
poisson = 0.3
[parts.lower]
shape = "box"
size = [6.0, 3.0, 0.2]
divisions = [6, 3, 1]
element = "hex8i"
material = "steel"
[parts.upper]
shape = "box"
origin = [2.0, 1.0, 0.22]
size = [2.0, 1.0, 0.2]
divisions = [2, 1, 1]
material = "steel"
[[boundary]]
nodes = ["lower.x-", "lower.x+"]
fix = ["x", "y", "z"]
[[boundary]]
nodes = "upper"
translate = [0.0, 0.0, -0.3]
[[interface]]
name = "joint"
{sides}
integration = "faces"
"#
        )
    };
    for sides in ["master = \"lower\"\nslave = \"upper.z-\"", "self = [\"lower\", \"upper\"]"] {
        let (notes, state, _) = run(&deck(sides), "[time]\nincrement = 1.0\nminimum = 0.01");
        assert!(
            notes.reasons.first().is_some_and(|reason| reason.contains("Through")),
            "{:?}",
            notes.reasons
        );
        let last = notes.increments.last().unwrap();
        assert!(last.active > 0 && last.lost == 0 && state.time == 1.0, "{last:?}");
        // The middle goes along with the upper plate.
        let down = state.positions.iter().map(|x| x[2]).fold(f64::INFINITY, f64::min);
        assert!((-0.35..-0.25).contains(&down), "{down}");
    }
}

/// With a stabilisation what no load moves stays where it is, and forces are what they are without.
#[test]
fn stabilisation_holds_what_no_load_moves() {
    const BLOCK: &str = r#"
[materials.m]
young = 1000.0
poisson = 0.3
[parts.floor]
shape = "rigid-plane"
size = [4.0, 4.0]
divisions = [4, 4]
translate = [-1.5, -1.5, 0.0]
[parts.block]
shape = "box"
size = [1.0, 1.0, 1.0]
divisions = [2, 2, 2]
material = "m"
[[boundary]]
nodes = "floor"
fix = ["x", "y", "z"]
[[pressure]]
surface = "block.z+"
value = 100.0
[[interface]]
name = "joint"
master = "floor"
slave = "block.z-"
[time]
increment = 1.0
"#;
    let held = BLOCK.replace("[[pressure]]", "[[boundary]]\nnodes = \"block.x-\"\nfix = [\"x\"]\n[[boundary]]\nnodes = \"block.y-\"\nfix = [\"y\"]\n[[pressure]]");
    let (notes, held, _) = run(&held, "");
    assert_eq!(notes.increments[0].stabilised, 0);
    for part in ["1e-8", "1e-4"] {
        let (notes, free, _) = run(BLOCK, &format!("[newton]\nstabilisation = {part}\ntolerance = 1e-9"));
        let record = &notes.increments[0];
        assert!(record.stabilised > 0 && record.supposed == 1 && notes.cuts.is_empty(), "{part}");
        let force = record.contacts[0].force;
        assert!((force[2] - 100.0).abs() < 1e-5 && force[0].hypot(force[1]) < 1e-5, "{force:?}");
        let widest = |state: &State, axis: usize| {
            let xs = state.positions[25..].iter().map(|x| x[axis]);
            xs.clone().fold(f64::MIN, f64::max) - xs.fold(f64::MAX, f64::min)
        };
        for axis in 0..3 {
            let (found, expected) = (widest(&free, axis), widest(&held, axis));
            assert!((found - expected).abs() < 1e-6, "{part} {axis}: {found} {expected}");
        }
        // Its centre is where it was.
        for axis in 0..2 {
            let centre = free.positions[25..].iter().map(|x| x[axis]).sum::<f64>() / 27.0;
            assert!((centre - 0.5).abs() < 1e-6, "{centre}");
        }
    }
}

/// Five times E/h of the softer side, per area, and what it gives is what the same number gives.
#[test]
fn a_penalty_follows_from_the_softer_body() {
    let (automatic, by_itself, statics) = run(&stacked(0.0, "", "hex8"), TIME);
    let options = statics.problem().contacts().interactions()[0].options();
    let expected = 5.0 * 1000.0 / (4.0 / 3.0);
    assert!((options.penalty / expected - 1.0).abs() < 1e-14, "{}", options.penalty);
    assert!(options.interface.areas);
    let (given, by_hand, _) =
        run(&stacked(0.0, &format!("penalty = {:?}\nareas = true", options.penalty), "hex8"), TIME);
    assert_eq!(by_itself.positions, by_hand.positions);
    assert_eq!(automatic.iterations, given.iterations);
    // p = 10 on E = 1000 of the softer block.
    assert!(automatic.increments[0].max_penetration < 3e-3, "{}", automatic.increments[0].max_penetration);
}

/// A cylinder whose facets lie on both sides of the surface they are to touch starts in touch all around, without strain.
#[test]
fn adjusted_slaves_start_in_touch() {
    const RINGS: &str = r#"
[materials.m]
young = 1000.0
poisson = 0.3
[parts.inner]
shape = "pipe"
axis = "z"
inner_radius = 4.0
outer_radius = 5.0
angles = [0.0, 90.0]
length = 1.0
divisions = [9, 2, 2]
material = "m"
[parts.outer]
shape = "pipe"
axis = "z"
inner_radius = 5.003
outer_radius = 6.0
angles = [0.0, 90.0]
length = 1.0
divisions = [5, 2, 2]
material = "m"
[[boundary]]
nodes = "outer"
fix = ["x", "y", "z"]
[[interface]]
name = "fit"
master = "outer.inner"
slave = "inner.outer"
symmetry = ["x", "y"]
adjust = 0.02
"#;
    let given = deck(&RINGS.replace("adjust = 0.02", ""), TIME).1;
    let (deck, model) = deck(RINGS, TIME);
    assert!(
        model.adjusted.len() == 30
            && model.adjusted.iter().all(|(&node, before)| given.nodes[node] == before.before)
    );
    let way = model.adjusted.iter().map(|(&node, AdjustedNode { before: x, .. })| {
        (model.nodes[node][0] - x[0]).hypot(model.nodes[node][1] - x[1])
    });
    let way = way.fold(0.0, f64::max);
    assert!((1e-3..1e-2).contains(&way), "{way}");
    // A restart finds the model it was begun with, whatever the last digits of the adjusted nodes.
    assert_eq!(model.fingerprint(), given.fingerprint());
    let mut statics = statics(&deck, &model);
    let start = statics.problem().start();
    statics.look_at_contacts(&start).unwrap();
    let contacts = statics.problem().contacts();
    let gaps: Vec<f64> = contacts.interactions()[0].slaves().map(|slave| slave.gap.unwrap()).collect();
    assert!(gaps.len() == 30 && gaps.iter().all(|gap| gap.abs() < 1e-10), "{gaps:?}");
    let solid = statics.problem().solid();
    let energy = solid.stored_energy(&start.positions, &solid.states()).unwrap();
    assert!(energy.abs() < 1e-20, "{energy}");
    // Farther than a mesh leaves open.
    let far = format!("{}\n{TIME}", RINGS.replace("adjust = 0.02", "adjust = 0.4"));
    let error = Deck::parse(&far).unwrap().model("").unwrap_err().to_string();
    assert!(error.contains("the limit of 4e-1 is more than a quarter of"), "{error}");
    // Nothing is that near.
    let far = format!("{}\n{TIME}", RINGS.replace("adjust = 0.02", "adjust = 1e-4"));
    assert!(Deck::parse(&far).unwrap().model("").unwrap().adjusted.is_empty());
}

/// Blocks on a slope, 0.01 apart, one with a side that a plane of symmetry holds: slaves are moved by what is free of the normal. The slaves of
/// that side have half of it on a slope of 60°; on one of 80° they would slide far, and stay.
#[test]
fn slaves_that_are_held_in_part_are_adjusted_along_what_is_free() {
    let blocks = |degrees: f64| {
        let turned =
            format!("material = \"m\"\nrotate = {{ axis = [0.0, 1.0, 0.0], degrees = {degrees:?} }}");
        format!(
            r#"
[materials.m]
young = 1000.0
poisson = 0.3
[parts.lower]
shape = "box"
size = [2.0, 2.0, 1.0]
divisions = [2, 2, 1]
{turned}
[parts.upper]
shape = "box"
origin = [0.5, 0.5, 1.01]
size = [1.0, 1.0, 1.0]
divisions = [2, 2, 1]
{turned}
[[boundary]]
nodes = "lower"
fix = ["x", "y", "z"]
[[boundary]]
nodes = "upper.x-"
fix = ["x"]
[[interface]]
name = "slope"
master = "lower.z+"
slave = "upper.z-"
adjust = 0.05
"#
        )
    };
    for (degrees, moved) in [(60.0, 9), (80.0, 6)] {
        let (deck, model) = deck(&blocks(degrees), TIME);
        let found = (model.adjusted.len(), model.not_adjusted["slope"]);
        assert_eq!(found, (moved, 9 - moved));
        let mut statics = statics(&deck, &model);
        let start = statics.problem().start();
        statics.look_at_contacts(&start).unwrap();
        let contact = &statics.problem().contacts().interactions()[0];
        for slave in contact.slaves() {
            let gap = if model.adjusted.contains_key(&slave.node) { 0.0 } else { 0.01 };
            assert!((slave.gap.unwrap() - gap).abs() < 1e-9, "{slave:?}");
        }
        let warnings = Beginning::of(contact, &model, statics.problem()).warnings();
        let told = warnings.iter().any(|warning| warning.contains("3 slaves near the master are not moved"));
        assert_eq!(told, moved == 6, "{warnings:?}");
    }
}

/// A limit that is little beside the mean facet, and much beside the smallest, under which mesh gaps are as small.
#[test]
fn slaves_are_adjusted_by_little_beside_their_own_facets() {
    const GRADED: &str = r#"
[materials.m]
young = 1000.0
poisson = 0.3
[parts.lower]
shape = "box"
size = [6.0, 3.0, 1.0]
divisions = [6, 3, 1]
material = "m"
[parts.upper]
shape = "box"
origin = [1.0, 1.0, 1.01]
size = [4.0, 1.0, 1.0]
divisions = [4, 1, 1]
grading = [16.0, 1.0, 1.0]
material = "m"
[[boundary]]
nodes = "lower"
fix = ["x", "y", "z"]
[[interface]]
name = "fit"
master = "lower.z+"
slave = "upper.z-"
"#;
    let adjusted = |limit: &str| {
        let text = format!("{GRADED}adjust = {limit}\n{TIME}");
        Deck::parse(&text).unwrap().model("").map(|model| model.adjusted.len())
    };
    assert_eq!(adjusted("0.05").unwrap(), 10);
    let error = adjusted("0.2").unwrap_err().to_string();
    assert!(error.contains("the limit of 2e-1 is more than a quarter of"), "{error}");
}

#[test]
fn rigid_slaves_are_not_adjusted() {
    let text = PRESSED.replace("penalty = 2000.0", "penalty = 2000.0\nadjust = 0.15\nexchange = true");
    let error = Deck::parse(&format!("{text}\n{TIME}")).unwrap().model("").unwrap_err();
    let DeckError::Invalid { problem, .. } = &error else { panic!("{error}") };
    assert!(matches!(**problem, Wrong::Adjust { error: AdjustError::Rigid { .. }, .. }), "{error}");
}

/// Many boundaries of one set: their names are numbered without a look at all those before.
#[test]
fn many_boundaries_of_one_set_are_numbered_in_time() {
    let begin = std::time::Instant::now();
    let head = "[materials.a]\nyoung = 1.0\npoisson = 0.3\n[parts.b]\nshape = \"box\"\nsize = [1.0, 1.0, 1.0]\n\
                divisions = [1, 1, 1]\nmaterial = \"a\"\n";
    const COUNT: usize = 5000;
    let boundaries = "[[boundary]]\nnodes = \"b\"\nfix = [\"x\"]\n".repeat(COUNT);
    let (deck, model) = deck(head, &format!("{boundaries}[time]\nincrement = 1.0\n"));
    let statics = statics(&deck, &model);
    let names: Vec<&str> =
        statics.problem().supports().groups().iter().map(|group| group.name.as_str()).collect();
    assert_eq!((names[0], names[1], names[COUNT - 1]), ("b", "b (2)", "b (5000)"));
    assert_eq!(names.iter().collect::<std::collections::HashSet<_>>().len(), COUNT);
    assert!(begin.elapsed() < std::time::Duration::from_secs(30), "{:?}", begin.elapsed());
}

/// A block on a floor that moves, over faces with friction, and what else there is.
fn carried(gap: f64, more: &str) -> String {
    format!(
        r#"
[materials.m]
young = 1000.0
poisson = 0.3
[parts.floor]
shape = "rigid-plane"
size = [4.0, 4.0]
divisions = [4, 4]
translate = [-1.5, -1.5, 0.0]
[parts.block]
shape = "box"
origin = [0.0, 0.0, {gap:?}]
size = [1.0, 1.0, 1.0]
divisions = [2, 2, 2]
material = "m"
[[boundary]]
nodes = "floor"
translate = [0.5, 0.0, 0.0]
[[interface]]
name = "joint"
master = "floor"
slave = "block.z-"
integration = "faces"
friction = 0.3
{more}
[time]
increment = 0.1
"#
    )
}

/// Friction comes from a force: where contact carries none, the part is named that only friction would hold, as without friction.
#[test]
fn friction_without_a_force_holds_nothing() {
    for gap in [0.0, -1e-3, 0.01] {
        let (notes, error, ..) = fail(&carried(gap, ""), "");
        assert!(notes.cuts.is_empty() && notes.increments.is_empty(), "{gap}: {error}");
        let StaticsError::Unloaded { time, loose, force, noise } = &error else { panic!("{gap}: {error}") };
        assert!(*time == 0.0 && *force > 0.0 && force <= noise && *noise < 1e-7, "{gap}: {error}");
        let [Loose { parts, motions, .. }] = &loose[..] else { panic!("{error}") };
        assert_eq!((&parts[..], motions.len()), (&["block".to_owned()][..], 3), "{error}");
        let text = "nothing holds `block` against moving along x, moving along y, turning about z through (";
        assert!(error.to_string().contains(text), "{error}");
    }
}

/// It is held by a load, by supports, or by a stabilisation; and what is unloaded at the end of the run is where friction left it.
#[test]
fn friction_with_a_force_holds() {
    const LOAD: &str = "[[pressure]]\nsurface = \"block.z+\"\nvalue = 10.0\n";
    let held = "[[boundary]]\nnodes = \"block.x-\"\nfix = [\"x\"]\n[[boundary]]\nnodes = \"block.y-\"\nfix = [\"y\"]\n";
    let unloaded = format!("{LOAD}amplitude = [[0.0, 0.0], [0.5, 1.0], [1.0, 0.0]]\n");
    let stabilised = "[newton]\nstabilisation = 1e-8\n";
    for (gap, more) in [(0.01, LOAD), (0.01, held), (0.0, &unloaded), (0.0, stabilised)] {
        let (notes, state, _) = run(&carried(gap, more), "");
        assert_eq!((state.time, notes.cuts.len()), (1.0, 0), "{gap} {more}");
    }
    let (_, state, _) = run(&carried(0.0, LOAD), "");
    let centre = state.positions[25..].iter().map(|x| x[0]).sum::<f64>() / 27.0;
    assert!((centre - 1.0).abs() < 1e-3, "{centre}");
}
