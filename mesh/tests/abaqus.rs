//! The Abaqus reader against decks written by hand, good and bad.

use diffuse_contact_mesh::{ElementKind, Facet, Mesh, MeshError, Place, Problem};

fn read(deck: &str) -> Mesh {
    Mesh::from_abaqus(deck.as_bytes(), "deck.inp").unwrap_or_else(|error| panic!("{error}"))
}

fn fault(deck: &str) -> (usize, Problem) {
    match Mesh::from_abaqus(deck.as_bytes(), "deck.inp") {
        Err(MeshError::Invalid { place: Place::Line(line), problem, .. }) => (line, problem),
        other => panic!("expected a fault, got {other:?}"),
    }
}

fn message(deck: &str) -> String {
    Mesh::from_abaqus(deck.as_bytes(), "deck.inp").unwrap_err().to_string()
}

/// A brick below a plate of one quadrilateral and one triangle.
const FLAT: &str = "\
*Heading
 A brick, a plate, and what surrounds them
** nodes of the brick
*NODE, NSET=brick_nodes
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.

5, 0., 0., 1.D0
6, 1., 0., 1.
7, 1., 1., 1.
** in the middle of a block
8, 0., 1., 1.
*node
11, 0., 0., 1.5
12, 1., 0., 1.5
13, 1., 1., 1.5
14, 0., 1., 1.5
15, 2., .5, 15.e-1
*Element, type=C3D8R, elset=Brick
100, 1, 2, 3, 4,
 5, 6, 7, 8
*ELEMENT, TYPE=S4R,
 ELSET=Plate
201, 11, 12, 13, 14
*Element, type=s3, elset=plate
202, 12, 15, 13
*NSET, NSET=Corners, GENERATE
 1, 7, 2
 11, 12
*NSET, NSET=Many
 corners, 8,
 14,
*ELSET, ELSET=Everything
 brick, plate
*ELSET, ELSET=shells, generate
 201, 202, 1
*Material, name=Steel
*Elastic
 210000., 0.3
*Surface, type=ELEMENT, name=TOP
 Brick, S2
*Surface, name=Under
 plate, sneg
*Surface, name=Mixed
 201, SPOS
 Brick, S4
 201, SPOS
*Surface, type=node, name=Dots
 Corners, 1.
 15
*Node Output
 U
*Element Output, directions=YES
 S
";

#[test]
fn a_flat_deck_is_read_in_full() {
    let mesh = read(FLAT);
    assert_eq!(mesh.nodes().len(), 13);
    assert_eq!(mesh.nodes()[4], [0.0, 0.0, 1.0]);
    assert_eq!(mesh.nodes()[12], [2.0, 0.5, 1.5]);
    assert_eq!(mesh.node_tags()[8..], [11, 12, 13, 14, 15]);
    let kinds: Vec<ElementKind> = mesh.elements().iter().map(|element| element.kind()).collect();
    assert_eq!(kinds, [ElementKind::Hexahedron8, ElementKind::Quadrilateral4, ElementKind::Triangle3]);
    assert_eq!(mesh.elements()[0].nodes(), [0, 1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(mesh.elements()[2].tag(), 202);
    assert_eq!(
        mesh.set_names(),
        [
            "Brick",
            "Corners",
            "Dots",
            "Everything",
            "Many",
            "Mixed",
            "Plate",
            "TOP",
            "Under",
            "brick_nodes",
            "shells"
        ]
    );
}

#[test]
fn sets_are_united_and_found_in_any_case() {
    let mesh = read(FLAT);
    let plate = [Facet::Quadrilateral([8, 9, 10, 11]), Facet::Triangle([9, 12, 10])];
    assert_eq!(mesh.facets("PLATE").unwrap(), plate);
    assert_eq!(mesh.facets("shells").unwrap(), plate);
    assert_eq!(mesh.facets("everything").unwrap(), plate);
    assert_eq!(mesh.elements_of("everything").unwrap(), [0, 1, 2]);
    assert_eq!(mesh.nodes_of("Corners").unwrap(), [0, 2, 4, 6, 8, 9]);
    assert_eq!(mesh.nodes_of("many").unwrap(), [0, 2, 4, 6, 7, 8, 9, 11]);
    assert_eq!(mesh.nodes_of("brick_nodes").unwrap(), (0..8).collect::<Vec<_>>());
    assert_eq!(mesh.nodes_of("plate").unwrap(), [8, 9, 10, 11, 12]);
    assert_eq!(mesh.nodes_of("Dots").unwrap(), [0, 2, 4, 6, 8, 9, 12]);
}

#[test]
fn a_name_as_it_is_written_comes_before_other_letter_case() {
    let deck = "\
*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
*ELEMENT, TYPE=S3, ELSET=skin
1, 1, 2, 3
*ELEMENT, TYPE=S3, ELSET=other
2, 1, 3, 4
*ELEMENT, TYPE=S9R5, ELSET=dish
3, 1, 2, 3
*SURFACE, TYPE=ELEMENT, NAME=SKIN
other, SPOS
*SURFACE, TYPE=ELEMENT, NAME=DISH
other, SPOS
*NSET, NSET=Skin
4
";
    let mesh = read(deck);
    let [first, second] = [Facet::Triangle([0, 1, 2]), Facet::Triangle([0, 2, 3])];
    assert_eq!(mesh.facets("skin").unwrap(), [first]);
    assert_eq!(mesh.facets("SKIN").unwrap(), [second]);
    assert_eq!(mesh.nodes_of("skin").unwrap(), [0, 1, 2]);
    assert_eq!(mesh.nodes_of("SKIN").unwrap(), [0, 2, 3]);
    assert_eq!(mesh.nodes_of("sKIN").unwrap(), [3], "node sets come first");
    // What was not read is refused under its own spelling alone.
    assert_eq!(mesh.facets("DISH").unwrap(), [second]);
    assert!(matches!(mesh.facets("dish"), Err(MeshError::UnreadElement { tag: 3, .. })));
}

#[test]
fn surfaces_are_faces_of_solids_and_sides_of_shells() {
    let mesh = read(FLAT);
    assert_eq!(mesh.facets("Top").unwrap(), [Facet::Quadrilateral([4, 5, 6, 7])]);
    assert_eq!(mesh.nodes_of("Top").unwrap(), [4, 5, 6, 7]);
    assert_eq!(
        mesh.facets("Under").unwrap(),
        [Facet::Quadrilateral([8, 11, 10, 9]), Facet::Triangle([9, 10, 12])]
    );
    assert_eq!(
        mesh.facets("Mixed").unwrap(),
        [Facet::Quadrilateral([8, 9, 10, 11]), Facet::Quadrilateral([1, 2, 6, 5])]
    );
    assert!(matches!(mesh.facets("Dots"), Err(MeshError::NoFacets { holds, .. }) if holds == "7 nodes"));
    assert!(matches!(mesh.facets("Brick"), Err(MeshError::NoFacets { holds, .. }) if holds == "1 hexahedra"));
    assert!(
        matches!(mesh.elements_of("Top"), Err(MeshError::NoElements { holds, .. }) if holds == "1 facets")
    );
}

/// As Abaqus/CAE writes it: the assembly and the part both have a set named `Set-1`.
const ASSEMBLED: &str = "\
*Heading
*Preprint, echo=NO, model=NO
*Part, name=Part-1
*Node
 1, 0., 0., 0.
 2, 1., 0., 0.
 3, 1., 1., 0.
 4, 0., 1., 0.
*Element, type=R3D4
1, 1, 2, 3, 4
*Nset, nset=Set-1
 1,
*Nset, nset=only-part
 4,
*End Part
**
*Assembly, name=Assembly
*Instance, name=Part-1-1, part=Part-1
 0., 0., 0.
*End Instance
*Nset, nset=Set-1, instance=Part-1-1, generate
 2, 3
*Nset, nset=Set-2
 Part-1-1.4, Part-1-1.Set-1, Set-1
*Elset, elset=_Surf-1_SNEG, internal, instance=PART-1-1
 1,
*Surface, type=ELEMENT, name=Surf-1
_Surf-1_SNEG, SNEG
*End Assembly
*Step
*Static
*End Step
";

#[test]
fn one_part_with_one_instance_is_read() {
    let mesh = read(ASSEMBLED);
    assert_eq!(mesh.nodes_of("Set-1").unwrap(), [1, 2]);
    assert_eq!(mesh.nodes_of("Part-1-1.Set-1").unwrap(), [0]);
    assert_eq!(mesh.nodes_of("only-part").unwrap(), [3]);
    assert_eq!(mesh.nodes_of("Set-2").unwrap(), [0, 1, 2, 3]);
    assert_eq!(mesh.facets("surf-1").unwrap(), [Facet::Quadrilateral([0, 3, 2, 1])]);
}

#[test]
fn parts_without_an_instance_and_reference_points_are_passed_over() {
    let more = ASSEMBLED
        .replace("*End Part", "*End Part\n*Part, name=Part-2\n*Node\n1, 9., 9., 9.\n*Ngen\n1, 2\n*End Part");
    let more = more.replace("*End Instance", "*End Instance\n*Node, nset=Point\n1, 0., 0., 0.");
    let mesh = read(&more.replace(" 0., 0., 0.\n*End Instance", " 0., 0., 5.\n*End Instance"));
    assert_eq!(mesh.nodes(), [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [1.0, 1.0, 5.0], [0.0, 1.0, 5.0]]);
    assert!(mesh.nodes_of("Point").unwrap().is_empty());
    assert_eq!(mesh.nodes_of("Set-2").unwrap(), [0, 1, 2, 3]);
}

/// Lines of nodes and of small elements may end with a comma.
#[test]
fn reference_points_and_masses_are_one_a_line() {
    let points = "*End Instance\n*Node, nset=Points\n1, 0., 0., 0.,\n2, 0., 0., 1.,\n*Element, type=MASS\n1, 1,\n2, 2,";
    let sets = "*Nset, nset=Second\n2,\n*Elset, elset=Masses\n1, 2\n*End Assembly";
    let mesh = read(&ASSEMBLED.replace("*End Instance", points).replace("*End Assembly", sets));
    assert!(mesh.nodes_of("Second").unwrap().is_empty(), "not node 2 of the instance");
    assert!(mesh.elements_of("Masses").unwrap().is_empty());
    let within = read(&ASSEMBLED.replace("*End Part", "*Element, type=MASS\n7, 1,\n8, 2,\n*End Part"));
    assert_eq!(within.unread_elements().iter().map(|element| element.tag).collect::<Vec<_>>(), [7, 8]);
}

/// A line of `*NODE` is a node, whatever is left out of it.
#[test]
fn coordinates_that_are_left_out_are_zero() {
    let deck = "*NODE\n1, 1., 2., 3.\n2, , , 5.\n3, 6., ,\n4, 7.,\n5,\n6\n7, 1., , 2., 0., 0., 1.\n\
                *ELEMENT, TYPE=S4\n1, 1, 2, 3, 4\n";
    let nodes = [
        [1.0, 2.0, 3.0],
        [0.0, 0.0, 5.0],
        [6.0, 0.0, 0.0],
        [7.0, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 2.0],
    ];
    let mesh = read(deck);
    assert_eq!(mesh.nodes(), nodes);
    assert_eq!(mesh.node_tags(), [1, 2, 3, 4, 5, 6, 7]);
    assert!(
        message(&deck.replace("0., 0., 1.", "0., 0., 1., 4."))
            .contains("line 8: expected a node: number, x, y, z")
    );
    assert!(message(&deck.replace("2, ,", ", ,")).contains("line 3: expected a node number"));
}

#[test]
fn what_would_need_several_instances_is_refused() {
    let twice = ASSEMBLED.replace("*End Instance", "*End Instance\n*Instance, name=Part-1-2, part=Part-1");
    assert!(
        message(&twice).starts_with("deck.inp, line 21: the file has several instances"),
        "{}",
        message(&twice)
    );
    let loose = ASSEMBLED.replace("*End Part", "*End Part\n*Part, name=Part-2\n*End Part");
    let loose = loose.replace("*Instance, name=Part-1-1, part=Part-1", "** ").replace("*End Instance", "**");
    assert!(message(&loose).starts_with("deck.inp, line 16: *PART"), "{}", message(&loose));
    let unknown = ASSEMBLED.replace("part=Part-1", "part=Part-3");
    assert!(message(&unknown).contains("\"Part-1-1\" refers to part \"Part-3\""), "{}", message(&unknown));
    for axis in ["0., 0., 0., 0., 0., 0., 90.", "0., 0., 0., 1., nan, 0., 90.", "0., 0., 0., 1., x, 0., 90."]
    {
        let turned = ASSEMBLED.replace("*End Instance", &format!("{axis}\n*End Instance"));
        let expected =
            "deck.inp, line 20: expected a rotation: two different points of its axis, and degrees";
        assert!(message(&turned).starts_with(expected), "{}", message(&turned));
    }
    let far = ASSEMBLED
        .replace(" 4, 0., 1., 0.", " 4, 0., 1.e308, 0.")
        .replace(" 0., 0., 0.\n*End Instance", " 0., 1.7e308\n*End Instance");
    assert!(message(&far).contains("node 4 has the y coordinate inf"), "{}", message(&far));
    let (line, problem) = fault(&ASSEMBLED.replace("instance=PART-1-1", "instance=Other"));
    assert_eq!(line, 25);
    assert!(matches!(problem, Problem::Unexpected { found, .. } if found == "Other"));
}

#[test]
fn keywords_that_would_change_the_mesh_are_refused() {
    for (line, at) in [
        ("*INCLUDE, INPUT=more.inp", "INCLUDE"),
        ("*NGEN\n1, 2, 1", "NGEN"),
        ("*ELGEN\n1, 2", "ELGEN"),
        ("*SYSTEM\n0,0,0", "SYSTEM"),
        ("*IMPERFECTION, FILE=buckled, STEP=1\n1, 0.1", "IMPERFECTION"),
        ("*ADJUST, NODE SET=tips, SURFACE=top", "ADJUST"),
        ("*IMPORT, STATE=YES\npart-1", "IMPORT"),
        ("*Symmetric Model Generation, revolve", "SYMMETRICMODELGENERATION"),
        ("*NODE, INPUT=nodes.txt", "NODE"),
        ("*NODE, SYSTEM=C\n1, 1., 0., 0.", "NODE"),
        ("*NSET, NSET=a, ELSET=b", "NSET"),
    ] {
        let message = message(&format!("*HEADING\nx\n{line}\n"));
        assert!(
            message.starts_with(&format!("deck.inp, line 3: *{at} as used here is not supported")),
            "{message}"
        );
    }
}

/// Passed over, they would leave something out. Blanks do not count.
#[test]
fn misspelt_keywords_are_refused() {
    assert_fault("*Element, type=C3D8R", "*Elemnt, type=C3D8R", "expected *ELEMENT, found \"*ELEMNT\"");
    assert_fault("*Element, type=C3D8R", "*Elem, type=C3D8R", "expected *ELEMENT, found \"*ELEM\"");
    assert_fault("*NSET, NSET=Many", "*NSETS, NSET=Many", "expected *NSET, found \"*NSETS\"");
    let end = message(&ASSEMBLED.replace("*End Part", "*EndPrat"));
    assert!(end.contains("line 15: expected *ENDPART, found \"*ENDPRAT\""), "{end}");
    let blanks = ASSEMBLED.replace("*End Instance", "*EndInstance").replace("*Nset", "*N set");
    assert_eq!(read(&blanks), read(ASSEMBLED));
}

/// One that is passed over could change what is meant: a range would be read as three nodes.
#[test]
fn parameters_may_be_abbreviated_and_have_to_be_known() {
    let short =
        FLAT.replace("NSET=Corners, GENERATE", "NS=Corners, gen").replace("elset=Brick", "els = Brick");
    assert_eq!(read(&short), read(FLAT));
    assert_eq!(read(&ASSEMBLED.replace("instance=Part-1-1", "inst=Part-1-1")), read(ASSEMBLED));
    assert_eq!(read(&FLAT.replace("*NSET, NSET=Corners", "*NSET, UN SORTED, NSET=Corners")), read(FLAT));
    let cylindrical = message("*HEADING\nx\n*NODE, SYS=C\n1, 1., 0., 0.\n");
    assert!(cylindrical.contains("line 3: *NODE as used here is not supported"), "{cylindrical}");
    let nset = "expected parameters of *NSET (ELSET, GENERATE, INSTANCE, INTERNAL, NSET, UNSORTED), found";
    assert_fault(
        "*NSET, NSET=Corners, GENERATE",
        "*NSET, NSET=Corners, GENRATE",
        &format!("{nset} \"GENRATE\""),
    );
    assert_fault("*NSET, NSET=Corners, GENERATE", "*NSET, NSET=Corners, IN", &format!("{nset} \"IN\""));
    // The first data line continues a keyword line that ends with a comma.
    assert_fault("*NSET, NSET=Many\n", "*NSET, NSET=Many,\n", &format!("{nset} \"CORNERS\""));
    assert_fault(
        "*Surface, name=Under",
        "*Surface, name=Under, colour=red",
        "expected parameters of *SURFACE (",
    );
    let library = message(&ASSEMBLED.replace("part=Part-1", "library=old, instance=Part-1"));
    assert!(library.contains("line 18: expected parameters of *INSTANCE (NAME, PART)"), "{library}");
    let unread =
        ASSEMBLED.replace("*End Part", "*End Part\n*Part, name=Part-2\n*Node, colour=red\n*End Part");
    assert_eq!(read(&unread), read(ASSEMBLED));
}

/// Replaces `from` in the flat deck by `to` and checks that the error is in that line and says `text`.
fn assert_fault(from: &str, to: &str, text: &str) {
    let before = FLAT.find(from).unwrap_or_else(|| panic!("{from:?} is not in the deck"));
    let line = 1 + FLAT[..before].matches('\n').count();
    let message = message(&FLAT.replacen(from, to, 1));
    assert!(message.starts_with(&format!("deck.inp, line {line}: ")), "line {line} expected: {message}");
    assert!(message.contains(text), "{text:?} expected: {message}");
}

#[test]
fn bad_elements_and_nodes_are_found_in_their_line() {
    // Asked for, an element that is not supported is an error.
    let unread = read(&FLAT.replace("*Element, type=C3D8R", "*Element, type=CIN3D8"));
    for set in ["Brick", "Top", "Everything", "Mixed"] {
        let error = unread.facets(set).unwrap_err().to_string();
        assert!(
            error.contains("holds element 100 of type CIN3D8 (line 22 of the mesh file), which is not supported; supported are"),
            "{error}"
        );
    }
    assert!(unread.facets("Plate").is_ok());
    let twice = FLAT.replace("202, 12, 15, 13", "202, 12, 15, 13\n*ELEMENT, TYPE=MASS\n202, 12");
    assert!(message(&twice).contains("element 202 is defined twice"), "{}", message(&twice));
    let alone = "*NODE\n1, 0, 0, 0\n*ELEMENT, TYPE=MASS\n1, 1\n";
    let said = message(alone);
    assert!(
        said.starts_with(
            "deck.inp: none of the mesh's elements is of a type that is supported: they are of type MASS; "
        ),
        "{said}"
    );
    assert_fault("*Element, type=C3D8R", "*Element, elset=C3D8R", "expected *ELEMENT with TYPE=");
    let last = "202, 12, 15, 13";
    assert_fault(last, "202, 12, 15, 99", "element 202 refers to node 99, which does not exist");
    assert_fault(last, "201, 12, 15, 13", "element 201 is defined twice");
    assert_fault(last, "202, 12, 15, 12", "element 202 uses node 12 more than once");
    let form =
        "expected an element S3: number and 3 nodes (a line that goes on has to end with a comma), found";
    assert_fault(last, "202, 12, 15", &format!("{form} \"202, 12, 15\""));
    assert_fault(last, "202, 12, 15, 13, 14", "expected an element S3: number and 3 nodes");
    assert_fault(" 5, 6, 7, 8", " 5, 6, x, 8", "expected a node number, found \"x\"");
    assert_fault(last, "202, 12, 15, x", "expected a node number, found \"x\"");
    let node = "15, 2., .5, 15.e-1";
    assert_fault(node, "14, 2., .5, 1.5", "node 14 is defined twice");
    assert_fault(node, "15, 2., NaN, 1.5", "node 15 has the y coordinate NaN, which is not a finite number");
    assert_fault(node, "15, 2., 1.e999, 1.5", "node 15 has the y coordinate inf");
    assert_fault(node, "15, 2., x, 1.5", "expected a coordinate, found \"x\"");
    assert_fault(node, "-5, 2., .5, 1.5", "expected a node number, found \"-5\"");
    assert_fault("*Heading\n", "1, 2, 3\n", "expected a keyword line (begins with *), found \"1, 2, 3\"");
}

#[test]
fn bad_sets_and_surfaces_are_found_in_their_line() {
    let everything = " brick, plate\n";
    assert_fault(everything, " brick, plat\n", "\"Everything\" refers to element set \"plat\"");
    assert_fault(everything, " brick, 999\n", "\"Everything\" refers to element 999, which does not exist");
    assert_fault(" 1, 7, 2", " 7, 1, 2", "expected first, last and increment");
    assert_fault(" 1, 7, 2", " 1, 7, 0", "expected first, last and increment");
    assert_fault(" Brick, S2", " Brick, S7", "expected a face identifier");
    assert_fault(
        " Brick, S2",
        " Brick, SPOS",
        "face \"SPOS\" does not belong to element 100, a hexahedron; its faces are S1 to S6",
    );
    assert_fault(" 15\n*Node Output", " 16\n*Node Output", "\"Dots\" refers to node 16");
    assert_fault("*Surface, type=node", "*Surface, type=cylinder", "expected *SURFACE of TYPE=");
    let message = message(&FLAT.replace("name=Dots", "name=Many"));
    assert!(message.contains("with the name \"Many\" of a different *NSET"), "{message}");
}

/// Nodes and a brick, as sets of meshio follow them.
const MESHIO: &str = "\
*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
*ELEMENT, TYPE=CAX4P
1, 1, 4, 3, 2
*ELEMENT, TYPE=C3D8RH
2, 1, 2, 3, 4, 5, 6, 7, 8
*ELSET, ELSET=bottom
1
*ELSET, ELSET=gmsh:bounding_entities
-30, 99
*ELSET, ELSET=solid
2
*ELSET, ELSET=gmsh:bounding_entities
1, -7
";

/// Its numbers are those of Gmsh's entities, with signs.
#[test]
fn a_set_with_wrong_labels_is_refused_where_it_is_asked_for() {
    let mesh = read(MESHIO);
    assert_eq!(mesh.facets("bottom").unwrap(), [Facet::Quadrilateral([0, 3, 2, 1])]);
    assert_eq!(mesh.elements_of("solid").unwrap(), [1]);
    let name = "gmsh:bounding_entities";
    for error in [
        mesh.facets(name).unwrap_err(),
        mesh.nodes_of(name).unwrap_err(),
        mesh.elements_of(name).unwrap_err(),
    ] {
        assert_eq!(
            error.to_string(),
            "the set \"gmsh:bounding_entities\" has the member -30 (line 17 of the mesh file), but labels of elements are positive whole \
             numbers"
        );
    }
    // So are sets and surfaces of it.
    let around = read(&format!(
        "{MESHIO}*ELSET, ELSET=around\n{name}, 1\n*SURFACE, NAME=skin\n{name}, SPOS\n*SURFACE, NAME=one\n1, SPOS\n"
    ));
    for name in ["around", "skin"] {
        let error = around.facets(name).unwrap_err();
        assert!(matches!(error, MeshError::WrongLabel { line: 17, .. }), "{error}");
    }
    assert_eq!(around.facets("one").unwrap().len(), 1);
    let refused: Vec<&str> = around.unread_sets().into_keys().collect();
    assert_eq!(refused, ["around", name, "skin"]);
    // Surfaces and node sets have no such members.
    let end = MESHIO.matches('\n').count();
    for (block, what) in [("*SURFACE, NAME=s\n-3, S1", "element"), ("*NSET, NSET=s\n1, -3", "node")] {
        let error = message(&format!("{MESHIO}{block}\n"));
        let expected = format!(
            "deck.inp, line {}: \"s\" has the member -3, but labels of {what}s are positive whole numbers",
            end + 2
        );
        assert_eq!(error, expected);
    }
}

/// A facet with a section carries something in Abaqus.
#[test]
fn elements_in_a_plane_are_facets() {
    for (nodes, first, kind) in [
        (3, "1, 2, 3", ElementKind::Triangle3),
        (4, "1, 2, 3, 4", ElementKind::Quadrilateral4),
        (6, "1, 2, 3, 4, 5, 6", ElementKind::Triangle6),
        (8, "1, 2, 3, 4, 5, 6, 7, 8", ElementKind::Quadrilateral8),
    ] {
        for family in ["CPS", "CPE", "CAX"] {
            for formulation in ["", "R", "H", "I", "M", "T", "P", "RH", "MH", "IH", "RP", "RHT"] {
                let name = format!("{family}{nodes}{formulation}");
                let deck = MESHIO.replace("TYPE=CAX4P\n1, 1, 4, 3, 2", &format!("TYPE={name}\n1, {first}"));
                let mesh = read(&deck);
                assert_eq!(mesh.elements()[0].kind(), kind, "{name}");
                assert!(
                    !mesh.facets("bottom").unwrap().is_empty() && mesh.stiff_lines_and_facets().is_empty()
                );
                let stiff = read(&format!("{deck}*SOLID SECTION, ELSET=bottom\n"));
                assert_eq!(stiff.stiff_lines_and_facets(), [(0, name)]);
            }
        }
    }
    // Another number of nodes, those of a reference point, twist.
    for name in ["CPE5", "CPS", "CPEG4", "CGAX4", "CAXA41", "CPE4X"] {
        let mesh = read(&MESHIO.replace("CAX4P", name));
        assert_eq!(
            mesh.facets("bottom").unwrap_err().to_string().split(" is not").next().unwrap(),
            format!("the set \"bottom\" holds element 1 of type {name} (line 11 of the mesh file), which"),
        );
    }
}

/// Gmsh writes them by default.
#[test]
fn hexahedra_with_27_nodes_name_the_option_that_avoids_them() {
    let deck = "*NODE\n1, 0, 0, 0\n*ELEMENT, TYPE=M3D9, ELSET=s\n1, 1, 2, 3, 4, 5, 6, 7, 8, 9\n*ELEMENT, TYPE=C3D27, ELSET=v\n2, 1, 2\n";
    let said = message(deck);
    let supported = "hexahedra of first and second order, except 18-node wedges and, in Abaqus files, 9-node quadrilaterals and 27-node \
                     hexahedra; Gmsh's option Mesh.SecondOrderIncomplete = 1 writes C3D20 instead, and .msh 4.1 files may have 27-node \
                     hexahedra";
    assert!(said.contains("they are of type C3D27, M3D9; supported are"), "{said}");
    assert!(said.ends_with(supported), "{said}");
    let mixed = read(&format!(
        "{MESHIO}*ELEMENT, TYPE=C3D27, ELSET=v\n3, 1, 2\n*ELEMENT, TYPE=M3D9, ELSET=s\n4, 1\n"
    ));
    let said = mixed.elements_of("v").unwrap_err().to_string();
    assert!(said.ends_with(supported), "{said}");
    let said = mixed.facets("s").unwrap_err().to_string();
    assert!(said.contains("Mesh.SecondOrderIncomplete = 1 writes 8-node quadrilaterals"), "{said}");
}

#[test]
fn empty_and_truncated_decks_are_errors() {
    assert_eq!(message(""), "deck.inp: the mesh has no nodes");
    assert_eq!(message("*NODE\n1, 0, 0, 0\n"), "deck.inp: the mesh has no elements");
    let end = FLAT.find("\n 5, 6, 7, 8").unwrap();
    let line = 1 + FLAT[..end].matches('\n').count();
    assert_eq!(
        message(&FLAT[..end]),
        format!("deck.inp, line {line}: the file ends before an element C3D8R: number and 8 nodes")
    );
}

#[test]
fn exports_of_gmsh_are_read() {
    let mesh = read(
        "\
*Heading
 square.inp
*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
******* E L E M E N T S *************
*ELEMENT, type=T3D2, ELSET=Line1
4, 1, 2
*ELEMENT, type=CPS3, ELSET=Surface1
1, 1, 2, 3
*ELSET,ELSET=a_b
1, 4,
",
    );
    assert_eq!(mesh.facets("a_b").unwrap(), [Facet::Triangle([0, 1, 2])]);
}

/// The beam's second node is its middle; a line's middle is its last.
#[test]
fn lines_of_three_nodes_end_with_the_middle() {
    for kind in ["B32", "T3D3"] {
        let mesh =
            read(&format!("*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 2, 0, 0\n*ELEMENT, TYPE={kind}\n7, 1, 2, 3\n"));
        let line = &mesh.elements()[0];
        assert_eq!((line.kind(), line.nodes()), (ElementKind::Line3, &[0, 2, 1][..]));
    }
}

/// What orients a section is not read.
#[test]
fn beams_may_have_a_node_of_orientation() {
    for (kind, nodes) in [("B31", "1, 2, 3"), ("B32", "1, 2, 3, 1")] {
        let deck = format!("*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 2, 0, 0\n*ELEMENT, TYPE={kind}\n7, {nodes}\n");
        let own = read(&deck).elements()[0].nodes().len();
        assert_eq!(own, nodes.split(',').count() - 1);
        assert!(
            message(&deck.replace(nodes, &format!("{nodes}, 1"))).contains("line 6: expected an element B3")
        );
    }
    assert!(
        message("*NODE\n1, 0, 0, 0\n*ELEMENT, TYPE=T3D2\n7, 1, 2, 3\n").contains("expected an element T3D2")
    );
}

/// Edges of shells and free faces matter where they are asked for.
#[test]
fn surfaces_that_are_not_supported_do_not_stand_in_the_way_of_others() {
    for (line, face) in [
        (" plate, E1", "E1"),
        (" plate, s1", "S1"),
        (" Brick,", ""),
        (" 201, SPOS\n 202, e3", "E3"),
        (" plate, EDGE", "EDGE"),
    ] {
        let mesh = read(&FLAT.replace(" plate, sneg", line));
        assert!(mesh.facets("Top").is_ok());
        for error in [mesh.facets("under").unwrap_err(), mesh.nodes_of("Under").unwrap_err()] {
            assert!(
                matches!(&error, MeshError::UnsupportedFace { face: found, .. } if found == face),
                "{error}"
            );
        }
    }
}

/// Numbers of a range that stand for nothing are passed over, as long as some stand for something.
#[test]
fn ranges_have_gaps_and_go_beyond_the_last_number() {
    let set = |range: &str| {
        let mesh = read(&FLAT.replace(" 1, 7, 2", &format!(" {range}")));
        mesh.nodes_of("Corners").unwrap().len()
    };
    let all = read(FLAT).nodes().len();
    assert_eq!(set("1, 999999999"), all);
    assert_eq!(set("1, 18446744073709551615, 1"), all);
    assert_eq!(set("8, 10"), 3);
    assert_fault(" 1, 7, 2", " 900, 901", "\"Corners\" refers to node 900, which does not exist");
    // One far away would make a range long.
    let far = FLAT.replace("15, 2., .5", "99999999, 2., .5").replace("12, 15, 13", "12, 99999999, 13");
    let far = far.replace("\n 15\n", "\n 99999999\n").replace(" 1, 7, 2", " 1, 99999999");
    assert!(message(&far).contains("\"Corners\" refers to node 9, which"), "{}", message(&far));
}

/// A node may stand there twice; another one may not have its number.
#[test]
fn the_same_node_twice_is_one() {
    let line = FLAT.lines().find(|line| line.trim_start().starts_with("15,")).unwrap();
    let twice = read(&FLAT.replace(line, &format!("{line}\n{line}")));
    assert_eq!(twice.nodes().len(), read(FLAT).nodes().len());
    let other = line.replace("15, 2.", "15, 3.");
    let message = message(&FLAT.replace(line, &format!("{line}\n{other}")));
    assert!(message.contains("node 15 is defined twice"), "{message}");
}

/// A few megabytes could ask for any number of members.
#[test]
fn what_sets_hold_altogether_is_bounded() {
    let mut deck = "*NODE\n".to_owned();
    for tag in 1..=20_000 {
        deck += &format!("{tag}, {tag}.0, 0.0, 0.0\n");
    }
    deck += "*ELEMENT, TYPE=S3\n1, 1, 2, 3\n*NSET, NSET=all, GENERATE\n";
    let repeated = "1, 20000\n".repeat(5_000);
    assert_eq!(read(&format!("{deck}{repeated}")).node_sets()["all"].len(), 20_000);
    let ranges: String = (0..5_000).map(|k| format!("1, {}\n", 20_000 - k)).collect();
    let (_, problem) = fault(&format!("{deck}{ranges}"));
    assert!(matches!(problem, Problem::SetsTooLarge { what: "nodes", .. }), "{problem}");
}

#[test]
fn what_surfaces_hold_altogether_is_bounded() {
    let mut deck = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n*ELEMENT, TYPE=S3, ELSET=all\n".to_owned();
    for tag in 1..=20_000 {
        deck += &format!("{tag}, 1, 2, 3\n");
    }
    // The same once more adds nothing and takes no time.
    let repeated = "all, SPOS\n".repeat(200_000);
    let mesh = read(&format!("{deck}*SURFACE, TYPE=ELEMENT, NAME=skin\n{repeated}"));
    assert_eq!(mesh.facets("skin").unwrap().len(), 20_000);
    let repeated = "tips\n".repeat(200_000);
    let tips = "*NSET, NSET=tips\n1, 2\n*SURFACE, TYPE=NODE, NAME=dots\n";
    assert_eq!(read(&format!("{deck}{tips}{repeated}")).nodes_of("dots").unwrap(), [0, 1]);
    let surfaces: String =
        (0..3_000).map(|k| format!("*SURFACE, TYPE=ELEMENT, NAME=skin{k}\nall, SPOS\n")).collect();
    let (_, problem) = fault(&format!("{deck}{surfaces}"));
    assert!(matches!(problem, Problem::SetsTooLarge { what: "elements", .. }), "{problem}");
}
