//! What a mesh file joins: elements of several materials stay joined, and what is not joined is told.

use std::fs;

use diffuse_contact_solver::deck::Deck;
use diffuse_contact_solver::solid::Solid;

use crate::warnings::{Scratch, run};

/// Two cubes, one on the other: joined by their nodes, or with nodes of their own.
fn cubes(is_joined: bool, more: &str) -> String {
    let (seam, upper) = if is_joined {
        ("", "5, 6, 7, 8")
    } else {
        ("11, 0, 0, 1\n12, 1, 0, 1\n13, 1, 1, 1\n14, 0, 1, 1\n", "11, 12, 13, 14")
    };
    format!(
        "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 0, 0, 1\n6, 1, 0, 1\n7, 1, 1, 1\n8, 0, 1, 1\n{seam}\
         15, 0, 0, 2\n16, 1, 0, 2\n17, 1, 1, 2\n18, 0, 1, 2\n\
         *ELEMENT, TYPE=C3D8, ELSET=A\n1, 1, 2, 3, 4, 5, 6, 7, 8\n\
         *ELEMENT, TYPE=C3D8, ELSET=B\n2, {upper}, 15, 16, 17, 18\n\
         *NSET, NSET=bot\n1, 2, 3, 4\n*NSET, NSET=top\n15, 16, 17, 18\n{more}"
    )
}

/// The warnings of a run, and the force that pulls the top up by 0.01.
fn pulled(name: &str, mesh: &str, parts: &str) -> (Vec<String>, f64) {
    let scratch = Scratch::new(name);
    fs::write(scratch.0.join("cubes.inp"), mesh).unwrap();
    let top = if parts.contains("parts.b") { "b.top" } else { "a.top" };
    let deck = format!(
        r#"
materials.steel = {{ young = 200000.0, poisson = 0.0 }}
{parts}
boundary = [{{ nodes = "a.bot", fix = ["x", "y", "z"] }}, {{ nodes = "{top}", translate = [0.0, 0.0, 0.01] }}]
time = {{ increment = 1.0 }}
"#
    );
    let (_, summary) = run(&scratch, &deck, false, None);
    let history = diffuse_contact_solver::output::read_history(&scratch.0.join("out/history.csv")).unwrap();
    let force = history.value(history.rows.last().unwrap(), &format!("reaction_z:{top}"));
    (summary.warnings, force)
}

const WHOLE: &str = "parts.a = { file = \"cubes.inp\", material = \"steel\" }";

#[test]
fn what_is_joined_needs_no_warning() {
    let (warnings, force) = pulled("joined", &cubes(true, ""), WHOLE);
    assert!(warnings.is_empty() && (force - 1000.0).abs() < 10.0, "{warnings:?} {force}");
}

#[test]
fn constraints_that_are_not_read_are_told_with_their_lines() {
    let more = "*SURFACE, NAME=SA\n1, S2\n*SURFACE, NAME=SB\n2, S1\n*Tie, name=glue\nSB, SA\n*RIGID BODY, REF NODE=1, ELSET=A\n\
                *equation\n2\n1, 1, 1.0, 2, 1, -1.0\n*MPC\nTIE, 5, 11\n";
    let (warnings, force) = pulled("constraints", &cubes(false, more), WHOLE);
    assert!(force.abs() < 1e-6, "nothing holds the upper cube: {force}");
    let [constraints, seams] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(
        constraints.contains("*TIE in line 30, *RIGID BODY in line 32, *EQUATION in line 33 and 1 more"),
        "{constraints}"
    );
    assert!(seams.contains("8 nodes of its elements lie where others do"), "{seams}");
}

#[test]
fn nodes_that_two_parts_share_in_their_file_are_told() {
    let parts = "parts.a = { file = \"cubes.inp\", elements = \"A\", material = \"steel\" }\n\
                 parts.b = { file = \"cubes.inp\", elements = \"B\", material = \"steel\" }";
    let (warnings, force) = pulled("shared", &cubes(true, ""), parts);
    assert!(force.abs() < 1e-6, "{force}");
    assert!(warnings.len() == 1 && warnings[0].contains("`a` and `b` share 4 nodes"), "{warnings:?}");
    let (warnings, _) = pulled("apart", &cubes(false, ""), parts);
    assert!(warnings.is_empty(), "{warnings:?}");
    // One body in two places.
    let twice = "parts.a = { file = \"cubes.inp\", material = \"steel\" }\n\
                 parts.b = { file = \"./cubes.inp\", material = \"steel\", translate = [2.0, 0.0, 0.0] }";
    let (warnings, _) = pulled("twice", &cubes(true, ""), twice);
    assert!(warnings.is_empty(), "{warnings:?}");
}

/// A rigid tool beside the solids is no constraint of theirs.
#[test]
fn a_rigid_body_of_other_elements_is_not_told() {
    let tool = "*NODE\n21, 0, 0, 5\n22, 1, 0, 5\n23, 1, 1, 5\n24, 0, 1, 5\n*ELEMENT, TYPE=R3D4, ELSET=TOOL\n9, 21, 22, 23, 24\n\
                *RIGID BODY, ELSET=TOOL, REF NODE=21\n";
    let (warnings, _) = pulled("tool", &cubes(true, tool), WHOLE);
    assert!(warnings.is_empty(), "{warnings:?}");
    let own = "*RIGID BODY, ELSET=b, REF NODE=21\n";
    let (warnings, _) = pulled("own", &cubes(true, own), WHOLE);
    assert!(warnings.len() == 1 && warnings[0].contains("*RIGID BODY"), "{warnings:?}");
}

/// A body on springs that nobody reads is another structure.
#[test]
fn elements_that_are_not_read_are_told() {
    let more = "*ELEMENT, TYPE=SPRINGA, ELSET=S\n21, 1, 15\n22, 2, 16\n*ELEMENT, TYPE=B33, ELSET=S\n23, 1, 2\n\
                *ELEMENT, TYPE=MASS, ELSET=M\n24, 1\n";
    let (warnings, _) = pulled("springs", &cubes(true, more), WHOLE);
    let [springs] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(springs.contains("have no stiffness here: 1 of type B33, 2 of type SPRINGA;"), "{springs}");
    // Beams and shells are lines and facets. They carry something if they have a section, which files of meshers such as Gmsh do not give.
    let more = "*ELEMENT, TYPE=B31, ELSET=S\n21, 1, 2\n*ELEMENT, TYPE=S4R, ELSET=L\n22, 1, 2, 4, 3\n23, 1, 2, 4, 3\n\
                *ELEMENT, TYPE=T3D2, ELSET=Line1\n24, 1, 2\n*ELEMENT, TYPE=CPS4, ELSET=M\n25, 1, 2, 4, 3\n";
    let (warnings, _) = pulled("facets", &cubes(true, more), WHOLE);
    assert!(warnings.is_empty(), "{warnings:?}");
    let sections = "*BEAM SECTION, ELSET=s, SECTION=CIRC, MATERIAL=STEEL\n0.1\n*Shell Section, Elset=L, Material=Steel\n0.01, 5\n";
    // Those of another body are its own.
    let tool = "*NODE\n21, 0, 0, 5\n22, 1, 0, 5\n23, 1, 1, 5\n24, 0, 1, 5\n*ELEMENT, TYPE=S4, ELSET=L\n31, 21, 22, 23, 24\n";
    let (warnings, _) = pulled("beams", &cubes(true, &format!("{more}{tool}{sections}")), WHOLE);
    let [beams] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(beams.contains("have no stiffness here: 1 of type B31, 2 of type S4R;"), "{beams}");
}

/// As a series of two springs.
#[test]
fn elements_of_two_materials_share_their_nodes() {
    let parts = "materials.soft = { young = 100000.0, poisson = 0.0 }\n\
                 parts.a = { file = \"cubes.inp\", material = { A = \"steel\", b = \"soft\" } }";
    let (warnings, force) = pulled("materials", &cubes(true, ""), parts);
    let series = 0.01 / (1.0 / 200_000.0 + 1.0 / 100_000.0);
    assert!(warnings.is_empty() && (force - series).abs() < 0.01 * series, "{warnings:?} {force} {series}");
}

#[test]
fn materials_of_a_part_have_names_numbers_and_results_of_their_own() {
    let scratch = Scratch::new("materials-summary");
    fs::write(scratch.0.join("cubes.inp"), cubes(true, "")).unwrap();
    let deck = r#"
materials.steel = { young = 200000.0, poisson = 0.3 }
materials.soft = { young = 100000.0, poisson = 0.3 }
parts.a = { file = "cubes.inp", element = "hex8i", material = { B = "soft", A = "steel" } }
boundary = [{ nodes = "a.bot", fix = ["x", "y", "z"] }, { nodes = "a.top", translate = [0.0, 0.0, 0.01] }]
time = { increment = 1.0 }
"#;
    let model = Deck::parse(deck).unwrap().model(&scratch.0).unwrap();
    let solid = Solid::new(&model.nodes, &model.bodies).unwrap();
    assert_eq!(
        solid.parts(),
        [("a".to_owned(), (0..12).collect::<Vec<_>>())],
        "their nodes hold them together"
    );
    let (_, summary) = run(&scratch, deck, false, None);
    let parts: Vec<_> = summary
        .parts
        .iter()
        .map(|part| {
            (
                part.name.as_str(),
                part.nodes,
                part.elements,
                part.incompatible_modes,
                part.material.unwrap().young,
            )
        })
        .collect();
    assert_eq!(parts, [("a.B", 8, 1, 1, 1e5), ("a.A", 8, 1, 1, 2e5)]);
}

#[test]
fn each_element_has_one_material() {
    let scratch = Scratch::new("materials-refused");
    fs::write(scratch.0.join("cubes.inp"), cubes(true, "*ELSET, ELSET=BOTH\n1, 2\n")).unwrap();
    for (materials, expected) in [
        ("{ A = \"steel\" }", "in no set that has a material: 1, the first is element 2"),
        (
            "{ A = \"steel\", BOTH = \"steel\" }",
            "element 1 (in the mesh file) of the part \"a\" is in the sets \"A\" and \"BOTH\"",
        ),
        ("{ A = \"steel\", a = \"steel\" }", "is in the sets \"A\" and \"a\""),
        ("{ A = \"steel\", C = \"steel\" }", "has no element set \"C\""),
        ("{ A = \"steel\", B = \"steal\" }", "no material is named \"steal\" (did you mean \"steel\"?)"),
        ("{}", "needs a material"),
    ] {
        let text = format!(
            "materials.steel = {{ young = 2e5, poisson = 0.3 }}\nparts.a = {{ file = \"cubes.inp\", material = {materials} }}\n\
             time = {{ increment = 1.0 }}\n"
        );
        let error = Deck::parse(&text).unwrap().model(&scratch.0).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let shape = "materials.steel = { young = 2e5, poisson = 0.3 }\ntime = { increment = 1.0 }\n\
                 parts.a = { shape = \"box\", size = [1.0, 1.0, 1.0], divisions = [1, 1, 1], material = { all = \"steel\" } }";
    let error = Deck::parse(shape).unwrap().model(&scratch.0).unwrap_err().to_string();
    assert!(error.contains("no element set \"all\"; it has none"), "{error}");
}

/// Faces between materials are on no skin, and contact finds the part's as if it were of one.
#[test]
fn several_materials_make_one_skin() {
    let deck = |element: &str, material: &str| {
        format!(
            r#"
materials.steel = {{ young = 200000.0, poisson = 0.3 }}
parts.a = {{ file = "cubes.inp", element = "{element}", material = {material} }}
parts.floor = {{ shape = "rigid-plane", size = [4.0, 4.0], divisions = [2, 2], translate = [-1.0, -1.0, 0.0] }}
boundary = [{{ nodes = "floor", fix = ["x", "y", "z"] }}, {{ nodes = "a.top", translate = [0.0, 0.0, -0.01] }}]
interface = [{{ name = "floor", master = "floor", slave = "a" }}]
time = {{ increment = 1.0 }}
"#
        )
    };
    for element in ["hex8", "hex8i"] {
        let scratch = Scratch::new(&format!("skin-{element}"));
        fs::write(scratch.0.join("cubes.inp"), cubes(true, "")).unwrap();
        let [one, two] = ["\"steel\"", "{ A = \"steel\", B = \"steel\" }"].map(|material| {
            let text = deck(element, material);
            let model = Deck::parse(&text).unwrap().model(&scratch.0).unwrap();
            let facets: usize = model.skins().iter().map(Vec::len).sum();
            let (_, summary) = run(&scratch, &text, false, None);
            (facets, model.surfaces["a"].len(), summary.contact_force, summary.warnings)
        });
        assert_eq!((one.0, one.1), (10, 10));
        assert_eq!(one, two, "{element}");
    }
}
