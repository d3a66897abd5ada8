//! The example decks, and the page on decks.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::*;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

#[test]
fn the_example_decks_build() {
    let expected: BTreeMap<&str, (usize, usize, usize)> = BTreeMap::from([
        // Elements, master facets and slave facets.
        ("coaxial_cylinders", (36 * 4 + 40 * 4, 80, 72)),
        ("elastic_cylinder", (2 * 45 * 24 + 2 * (20 * 20 + 2 * 20 * 14), 80, 90)),
        ("hertz_cylinder", (20 * 20 + 40 * 16, 40, 40)),
        ("hertz_sphere", (9 * 9 * 9 + 3 * 81 * 8, 64, 3 * 81)),
        ("patch_test", (50 + 24, 25, 12)),
        ("pipe_pinch", (64 + 48, 32, 24)),
        ("pipe_pinch_plastic", (64 + 48, 32, 24)),
        ("plate_cylinder", (100, 32, 100)),
        ("ring_block", (128 + 360, 60, 64)),
        ("shrink_fit", (24 * 6 * 4 + 20 * 8 * 4, 80, 96)),
        ("sliding_block", (108, 150, 36)),
        ("inclined_block", (64, 65, 16)),
        ("belt", (144, 60, 144)),
        ("cattaneo_mindlin", (6400 + 5472, 160, 144)),
        ("press_fit", (24 * 6 * 2 + 20 * 8 * 2, 40, 48)),
        ("shaft_in_bush", (120, 160, 60)),
        ("shallow_ironing", (60 * 12 + 12 * 6, 60, 12 + 2 * 6)),
        ("snap_fit", (810, 198, 36 * 7)),
        ("squeezed_tube", (48, 72, 24)),
        ("crushed_serpentine", (128, 132, 132)),
        ("coil_spring", (320, 320, 320)),
        ("two_blocks", (14 * 14 * 7 + 10 * 10 * 5, 196, 100)),
    ]);
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir(root().join("examples")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let name = path.file_stem().unwrap().to_str().unwrap().to_string();
        let deck = Deck::read(&path).unwrap_or_else(|error| panic!("{error}"));
        let model = deck.model(path.parent().unwrap()).unwrap_or_else(|error| panic!("{error}"));
        assert!(!deck.title.is_empty() && deck.contact == Contact::Diffuse);
        let sides = deck.sides(&model, &deck.interfaces[0]).unwrap();
        let elements = model.bodies.iter().map(|body| body.elements.len()).sum::<usize>();
        assert_eq!((elements, sides.master.len(), sides.slave.len()), expected[name.as_str()], "{name}");
        found.insert(name);
    }
    assert!(expected.keys().all(|name| found.contains(*name)), "{found:?}");
}

/// The fields in the first columns of the tables below each heading of docs/how-to/decks.md.
fn documented() -> BTreeMap<String, BTreeSet<String>> {
    let page = std::fs::read_to_string(root().join("docs/how-to/decks.md")).unwrap();
    let (mut heading, mut fields) = (String::new(), BTreeMap::new());
    for line in page.lines() {
        if line.starts_with('#') {
            heading = line.trim_start_matches('#').trim().to_string();
        } else if let Some((field, _)) = line.strip_prefix("| `").and_then(|row| row.split_once("` |")) {
            let fresh = fields.entry(heading.clone()).or_insert_with(BTreeSet::new).insert(field.to_string());
            assert!(fresh, "{field} is documented twice under {heading}");
        }
    }
    fields
}

#[test]
fn every_field_is_documented_and_every_documented_field_exists() {
    let mut fields: BTreeMap<String, &[&str]> = BTreeMap::from([
        ("The deck", schema::DECK),
        ("`[materials.NAME]`", schema::MATERIAL),
        ("`[parts.NAME]`", schema::PART),
        ("`rotate`", schema::ROTATION),
        ("`path` of a strip", schema::PIECE),
        ("`file`", schema::FILE),
        ("`[[boundary]]`", schema::BOUNDARY),
        ("`rotate` of a boundary", schema::BOUNDARY_ROTATION),
        ("`[[pressure]]`", schema::PRESSURE),
        ("`[[interface]]`", schema::INTERFACE),
        ("`augmentation`", schema::AUGMENTATION),
        ("`friction`", schema::FRICTION),
        ("`coefficient`", schema::COEFFICIENT),
        ("`integration`", schema::INTEGRATION),
        ("`neighbours`", schema::NEIGHBOURS),
        ("`[time]`", schema::TIME),
        ("`[newton]`", schema::NEWTON),
        ("`[output]`", schema::OUTPUT),
    ])
    .into_iter()
    .map(|(heading, fields)| (heading.to_string(), fields))
    .collect();
    // A plate is a box by another name.
    let shapes = schema::SHAPES.iter().filter(|(name, _)| *name != "plate");
    fields.extend(shapes.map(|&(name, fields)| (format!("`shape = \"{name}\"`"), fields)));
    let mut known: BTreeMap<String, BTreeSet<String>> = fields
        .into_iter()
        .map(|(heading, fields)| (heading, fields.iter().map(|f| f.to_string()).collect()))
        .collect();
    let of_parts = known.get_mut("`[parts.NAME]`").unwrap();
    of_parts.extend(schema::SOLID_SHAPE.iter().map(|field| field.to_string()));
    assert_eq!(documented(), known);
}

/// A surface in contact with itself has no roles.
#[test]
fn self_stands_in_place_of_master_and_slave() {
    let text = std::fs::read_to_string(root().join("examples/squeezed_tube.toml")).unwrap();
    let own = "self = [\"tube.inner\", \"tube.outer\"]\n";
    let deck = Deck::parse(&text).unwrap();
    let (model, walls) = (deck.model(root()).unwrap(), &deck.interfaces[2]);
    let sides = deck.sides(&model, walls).unwrap();
    assert!(walls.self_contact && sides.master == sides.slave && sides.master.len() == 48);
    for more in
        ["master = \"below\"", "slave = \"tube.outer\"", "two_pass = true", "exchange = true", "adjust = 0.1"]
    {
        let error = Deck::parse(&text.replace(own, &format!("{own}{more}\n"))).unwrap_err().to_string();
        assert!(error.contains("with self"), "{error}");
    }
    let over_faces =
        text.replace("areas = true\n", "").replace(own, &format!("{own}integration = \"faces\"\n"));
    let faces = Deck::parse(&over_faces).unwrap();
    assert!(faces.interfaces[2].self_contact && faces.interfaces[2].integration != Integration::Nodes);
}
