//! Parts of mesh files, and files that cannot be read.

use std::path::{Path, PathBuf};

use super::*;
use crate::model::TWO_CUBES;
use diffuse_contact_solver::output::Summary;

/// A folder with a file of two cubes with these elements.
fn two_cubes(name: &str, elements: &str) -> PathBuf {
    let directory = std::env::temp_dir().join(format!("diffuse-contact-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    std::fs::write(directory.join("two.inp"), format!("{TWO_CUBES}{elements}")).unwrap();
    directory
}

#[test]
fn broken_texts_and_files_are_errors() {
    let text = message("title = \"a\nb\"");
    assert!(text.starts_with("deck, line 1: not valid TOML"), "{text}");
    assert!(message("[time]\nincrement = 0.1\nincrement = 0.2").starts_with("deck, line 3: not valid TOML"));
    assert!(message("\n# nothing yet\n").contains("nothing in the deck"));
    assert!(message("title = \"\"").contains("the deck needs a table \"time\""));
    assert!(
        message("boundary = 3\n[time]\nincrement = 1")
            .contains("boundary must be a list of tables: write [[boundary]], not 3")
    );
    assert!(message("parts = 3\n[time]\nincrement = 1").contains("parts must be a table, not 3"));
    let missing = Deck::read("/nowhere/deck.toml").unwrap_err();
    assert!(missing.to_string().starts_with("/nowhere/deck.toml: cannot be read"));
    let text =
        changed("shape = \"box\"\nsize = [1.0, 1.0, 1.0]\ndivisions = [2, 2, 2]", "file = \"nowhere.msh\"");
    assert!(
        message(&text).contains("line 10: parts.block: ./nowhere.msh: cannot be read"),
        "{}",
        message(&text)
    );
    // Whatever is cut off, there is an answer.
    for end in 0..DECK.len() {
        if let Ok(deck) = Deck::parse(&DECK[..end]) {
            let _ = deck.model(".");
        }
    }
}

#[test]
fn parts_come_from_mesh_files() {
    let meshes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../mesh/meshes");
    let text = changed(
        "shape = \"rigid-plane\"\nsize = [3.0, 3.0]\ndivisions = [3, 3]",
        "file = \"plate_on_cylinder.msh\"\nsurface = \"master\"",
    );
    let model = Deck::parse(&text).unwrap().model(&meshes).unwrap();
    assert_eq!(model.surfaces["floor"], model.surfaces["floor.master"]);
    assert!(!model.surfaces.contains_key("floor.slave"));
    let solid = changed(
        "shape = \"box\"\nsize = [1.0, 1.0, 1.0]\ndivisions = [2, 2, 2]",
        "file = \"plate_on_cylinder.msh\"",
    );
    let error = Deck::parse(&solid).unwrap().model(&meshes).unwrap_err().to_string();
    assert!(error.contains("parts.block: the mesh file has no solid elements"), "{error}");
}

/// Abaqus does not tell case apart in the names of sets.
#[test]
fn sets_are_found_in_other_letter_case() {
    let deck = Deck::parse(&changed("nodes = [\"block.z+\"]", "nodes = [\"block.Z+\"]")).unwrap();
    let model = deck.model(".").unwrap();
    let prescribed = |deck: &Deck| deck.supports(&model).unwrap().prescribed();
    assert_eq!(prescribed(&deck), prescribed(&Deck::parse(DECK).unwrap()));
    refused("\"block.z+\"", "\"Block.z+\"", "no node set is named \"Block.z+\"");
}

/// What a mesh file counts to a surface although it lies inside the part would carry neither contact nor pressure.
#[test]
fn surfaces_with_facets_inside_their_part_are_refused() {
    const ELEMENTS: &str = "\
*ELEMENT, TYPE=C3D8, ELSET=ALL
1, 1, 2, 3, 4, 5, 6, 7, 8
2, 2, 9, 10, 3, 6, 11, 12, 7
*SURFACE, NAME=BOTH, TYPE=ELEMENT
1, S2
1, S4
*SURFACE, NAME=WITHIN, TYPE=ELEMENT
1, S4
";
    let directory = two_cubes("deck", ELEMENTS);
    let deck = |surface: &str| {
        let text = format!(
            "[materials.m]\nyoung = 1.0\npoisson = 0.3\n[parts.two]\nfile = \"two.inp\"\nmaterial = \"m\"\n[[boundary]]\n\
             nodes = \"two\"\nfix = [\"x\"]\n[[pressure]]\nsurface = \"two.{surface}\"\nvalue = 1.0\n[time]\nincrement = 1.0\n"
        );
        Deck::parse(&text).unwrap().model(&directory).map(drop).unwrap_err().to_string()
    };
    assert!(
        deck("BOTH").contains("line 11: 1 of the 2 facets of the surface \"two.BOTH\" are not on the skin"),
        "{}",
        deck("BOTH")
    );
    assert!(deck("WITHIN").contains("1 of the 1 facets of the surface"), "{}", deck("WITHIN"));
    // By another letter case too.
    for (name, count) in [("both", 2), ("within", 1)] {
        let refused = deck(name);
        let expected = format!("1 of the {count} facets of the surface \"two.{name}\" are not on the skin");
        assert!(refused.contains(&expected), "{refused}");
    }
    std::fs::remove_dir_all(&directory).unwrap();
}

/// Abaqus' C3D8I has incompatible modes, and `element` of a part says otherwise or the same of what has none.
#[test]
fn incompatible_modes_come_from_the_file_or_the_deck() {
    const ELEMENTS: &str = "\
*ELEMENT, TYPE=C3D8I
1, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=C3D8
2, 2, 9, 10, 3, 6, 11, 12, 7
";
    let directory = two_cubes("modes", ELEMENTS);
    let text = |part: &str| {
        format!(
            "[materials.m]\nyoung = 1.0\npoisson = 0.3\n[parts.two]\n{part}\nmaterial = \"m\"\n[[boundary]]\n\
             nodes = \"two\"\nfix = [\"x\"]\n[time]\nincrement = 1.0\n"
        )
    };
    let model = |part: &str| Deck::parse(&text(part)).unwrap().model(&directory).unwrap();
    let modes = |part: &str| -> Vec<bool> {
        model(part).bodies[0].elements.iter().map(|cell| cell.incompatible_modes).collect()
    };
    assert_eq!(modes("file = \"two.inp\""), [true, false]);
    assert_eq!(modes("file = \"two.inp\"\nelement = \"hex8i\""), [true, true]);
    assert_eq!(modes("file = \"two.inp\"\nelement = \"hex8\""), [false, false]);
    let shape = "shape = \"box\"\nsize = [1.0, 1.0, 1.0]\ndivisions = [2, 1, 1]";
    assert_eq!(modes(shape), [false, false]);
    assert_eq!(modes(&format!("{shape}\nelement = \"hex8i\"")), [true, true]);
    // A run goes on with the elements it began with.
    let fingerprint = |part: &str| model(part).fingerprint();
    assert_ne!(fingerprint("file = \"two.inp\""), fingerprint("file = \"two.inp\"\nelement = \"hex8\""));
    // Among elements of several kinds those that are meant are counted.
    let wedges =
        ["2, 2, 9, 10, 6, 11, 12", "3, 2, 10, 3, 6, 12, 7", "4, 1, 2, 3, 5, 6, 7", "5, 1, 3, 4, 5, 7, 8"];
    let file = |elements: &str| {
        std::fs::write(directory.join("wedges.inp"), format!("{TWO_CUBES}{elements}")).unwrap();
        "file = \"wedges.inp\"\nelement = \"hex8i\""
    };
    let mixed =
        ["*ELEMENT, TYPE=C3D8\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*ELEMENT, TYPE=C3D6", wedges[0], wedges[1], ""];
    let part = file(&mixed.join("\n"));
    assert_eq!(modes(part), [true, false, false]);
    let summary = Summary::new(&Deck::parse(&text(part)).unwrap(), &model(part));
    assert_eq!((summary.parts[0].elements, summary.parts[0].incompatible_modes), (3, 1));
    // A part without any would be left as it is, without a word.
    let part = file(&format!("*ELEMENT, TYPE=C3D6\n{}\n", wedges.join("\n")));
    let error = Deck::parse(&text(part)).unwrap().model(&directory).unwrap_err().to_string();
    assert!(error.contains("parts.two.element says what hexahedra with 8 nodes are"), "{error}");
    let error = Deck::parse(&text("file = \"two.inp\"\nelement = \"hex20\"")).unwrap_err().to_string();
    assert!(error.contains("hex8i"), "{error}");
    std::fs::remove_dir_all(&directory).unwrap();
}

/// Sets that are not read are no unknown names: the error says what they hold, and where.
#[test]
fn sets_that_hold_what_is_not_read_say_so() {
    let directory = two_cubes(
        "unread-sets",
        "*ELEMENT, TYPE=C3D8, ELSET=Volume1\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*ELEMENT, TYPE=M3D9, ELSET=Low\n7, 1, 2, 3\n\
         *ELEMENT, TYPE=CPE4, ELSET=Surface5\n8, 5, 6, 7, 8\n*ELSET, ELSET=top\n8\n*ELSET, ELSET=gmsh:bounding_entities\n-30\n\
         *NSET, NSET=low_nodes\n1, 2, 3, 4\n*SURFACE, NAME=rim\nVolume1, EDGE1\n",
    );
    let line = 1 + TWO_CUBES.matches('\n').count() + 3;
    let text = |table: &str| {
        format!(
            "[materials.m]\nyoung = 1.0\npoisson = 0.3\n[parts.two]\nfile = \"two.inp\"\nmaterial = \"m\"\n{table}\n\
             [time]\nincrement = 1.0\n"
        )
    };
    let error = |table: &str| {
        let deck = Deck::parse(&text(table)).unwrap();
        deck.model(&directory).unwrap_err().to_string()
    };
    let boundary = |set: &str| error(&format!("[[boundary]]\nnodes = \"two.{set}\"\nfix = [\"x\"]"));
    let pressure = |set: &str| error(&format!("[[pressure]]\nsurface = \"two.{set}\"\nvalue = 1.0"));
    for said in [boundary("Low"), pressure("Low"), boundary("LOW"), pressure("low")] {
        let begin = format!(
            "deck, line 8: parts.two: the set \"Low\" holds element 7 of type M3D9 (line {line} of the mesh file), which is not supported; "
        );
        assert!(said.starts_with(&begin), "{said}");
    }
    let said = boundary("gmsh:bounding_entities");
    let part =
        format!("the set \"gmsh:bounding_entities\" has the member -30 (line {} of the mesh file)", line + 6);
    assert!(said.contains(&part), "{said}");
    let said = pressure("rim");
    assert!(said.contains("the surface \"rim\" has the face identifier \"EDGE1\""), "{said}");
    // What is read is found, and what Gmsh names by itself comes last.
    let said = pressure("tap");
    assert!(said.ends_with("no surface is named \"two.tap\" (did you mean \"two.top\"?); there are two.top, two, two.Surface5"), "{said}");
    std::fs::remove_dir_all(&directory).unwrap();
}
