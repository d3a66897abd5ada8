//! Models from parts, mesh files, and what the shapes have in common. The geometry of each shape is tested beside it.

use std::path::{Path, PathBuf};

use diffuse_contact::surface::Facet;
use diffuse_contact_mesh::ElementKind;
use diffuse_contact_solver::material::Material;
use diffuse_contact_solver::model::shape::{Block, RigidPlane};
use diffuse_contact_solver::model::*;

const STEEL: Material = Material::elastic(200_000.0, 0.3);

fn block() -> Part {
    let block =
        Block { origin: [1.0, 2.0, 3.0], size: [2.0, 3.0, 4.0], divisions: [2, 3, 1], grading: [1.0; 3] };
    block.part(ElementKind::Hexahedron8).unwrap()
}

/// The elements with the nodes of one of them changed.
fn with_nodes(elements: &Cells, changed: usize, change: impl Fn(&mut [usize])) -> Cells {
    let mut cells = Cells::default();
    for (k, cell) in elements.iter().enumerate() {
        let mut nodes = cell.nodes.to_vec();
        if k == changed {
            change(&mut nodes);
        }
        cells.push(cell.kind, &nodes);
    }
    cells
}

fn plane() -> Part {
    RigidPlane { size: [1.0, 1.0], divisions: [1, 1], facets: Default::default() }.part().unwrap()
}

#[test]
fn parts_keep_their_nodes_apart_and_their_names() {
    let mut model = Model::default();
    model.add("block", block(), Some(STEEL)).unwrap();
    model.add("floor", plane(), None).unwrap();
    assert_eq!(model.nodes.len(), 3 * 4 * 2 + 4);
    assert_eq!(model.node_sets["floor"], [24, 25, 26, 27]);
    assert_eq!(model.surfaces["floor"], [Facet::Quadrilateral([24, 25, 27, 26])]);
    assert_eq!(model.surfaces["block"].len(), 2 * (2 * 3 + 3 + 2));
    assert_eq!(model.surfaces["block.z+"].len(), 6);
    assert_eq!(model.parts(), [("block", 0), ("floor", 24)]);
    let deformable = model.deformable();
    assert!(deformable[..24].iter().all(|&d| d) && deformable[24..].iter().all(|&d| !d));
    for (name, axis, value) in
        [("block.x-", 0, 1.0), ("block.x+", 0, 3.0), ("block.y+", 1, 5.0), ("block.z-", 2, 3.0)]
    {
        let expected: Vec<usize> = (0..24).filter(|&n| model.nodes[n][axis] == value).collect();
        assert_eq!(model.node_sets[name], expected, "{name}");
    }
}

#[test]
fn parts_that_are_not_sound_are_refused() {
    let mut model = Model::default();
    assert!(matches!(model.add("a.b", block(), Some(STEEL)), Err(ModelError::InvalidName { .. })));
    assert!(matches!(model.add("a", block(), None), Err(ModelError::NoMaterial { .. })));
    assert!(matches!(model.add("a", plane(), Some(STEEL)), Err(ModelError::RigidMaterial { .. })));
    assert!(matches!(model.add("a", Part::default(), None), Err(ModelError::EmptyPart { .. })));

    let mut inverted = block();
    inverted.elements = with_nodes(&inverted.elements, 3, |nodes| nodes.rotate_left(4));
    let error = model.add("a", inverted, Some(STEEL)).unwrap_err();
    assert!(
        matches!(error, ModelError::InvertedElement { element: 3, corner: 0, jacobian, .. } if jacobian < 0.0)
    );
    assert!(error.to_string().ends_with("have to turn counter-clockwise as seen from the others"), "{error}");

    let mut lost = block();
    lost.node_sets.insert("lost".into(), vec![24]);
    let error = model.add("a", lost, Some(STEEL)).unwrap_err();
    assert!(matches!(error, ModelError::NodeOutOfRange { node: 24, count: 24, .. }));

    let mut endless = block();
    endless.nodes[7][1] = f64::INFINITY;
    assert!(matches!(
        model.add("a", endless, Some(STEEL)),
        Err(ModelError::NonFinitePosition { node: 7, .. })
    ));

    assert!(model.nodes.is_empty() && model.node_sets.is_empty(), "nothing of a refused part is left");
    model.add("a", block(), Some(STEEL)).unwrap();
    assert!(matches!(model.add("a", block(), Some(STEEL)), Err(ModelError::RepeatedPart { .. })));
}

#[test]
fn a_part_is_placed_by_rotation_and_translation() {
    let mut part = block();
    part.rotate(&Rotation { axis: [0.0, 0.0, 1.0], point: [1.0, 2.0, 0.0], degrees: 90.0 });
    part.translate([10.0, 0.0, -3.0]);
    assert_eq!(part.nodes[0], [11.0, 2.0, 0.0]);
    assert_eq!(part.nodes[2], [11.0, 4.0, 0.0]);
    Model::default().add("turned", part, Some(STEEL)).unwrap();
}

/// The nodes of two cubes side by side along x, in the format of Abaqus.
pub const TWO_CUBES: &str = "*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
9, 2, 0, 0
10, 2, 1, 0
11, 2, 0, 1
12, 2, 1, 1
";

/// Two cubes in one file, a shell on top of the first one, seen from below, and a rigid square.
const INPUT: &str = "\
21, 0, 0, 5
22, 1, 0, 5
23, 1, 1, 5
24, 0, 1, 5
*ELEMENT, TYPE=C3D8, ELSET=LEFT
1, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=C3D8, ELSET=RIGHT
2, 2, 9, 10, 3, 6, 11, 12, 7
*ELEMENT, TYPE=S4, ELSET=LID
3, 5, 8, 7, 6
*ELEMENT, TYPE=R3D4, ELSET=PUNCH
4, 21, 24, 23, 22
*ELEMENT, TYPE=C3D4, ELSET=TET
5, 1, 2, 3, 5
*NSET, NSET=CORNERS
1, 9, 21
*SURFACE, NAME=END, TYPE=ELEMENT
RIGHT, S4
";

fn written(name: &str) -> PathBuf {
    let directory = std::env::temp_dir().join(format!("diffuse-contact-model-{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    let path = directory.join(name);
    std::fs::write(&path, format!("{TWO_CUBES}{INPUT}")).unwrap();
    path
}

#[test]
fn a_solid_part_of_a_file_has_its_nodes_and_sets_only() {
    let path = written("solid.inp");
    let part = read_solid_part(&path, None, Some("LEFT")).unwrap();
    assert_eq!((part.nodes.len(), part.elements.len()), (8, 1));
    assert_eq!(part.node_sets["CORNERS"], [0]);
    // The shell looks down, the skin up.
    let lid = &part.surfaces["LID"];
    assert!(matches!(lid[..], [Facet::Quadrilateral([4, 5, 6, 7])]), "{lid:?}");
    // What the other cube has there is inside, or not on this part.
    assert!(!part.surfaces.contains_key("END") && !part.node_sets.contains_key("PUNCH"));

    let mut model = Model::default();
    model.add("left", part, Some(STEEL)).unwrap();
    model.add("right", read_solid_part(&path, None, Some("right")).unwrap(), Some(STEEL)).unwrap();
    assert_eq!(model.nodes.len(), 16);
    let end: Vec<[f64; 3]> =
        model.surfaces["right.END"][0].corners().iter().map(|&n| model.nodes[n]).collect();
    assert!(end.iter().all(|node| node[0] == 2.0), "{end:?}");
}

/// Elements of several kinds make one part; nodes in the middle of edges belong to its surface.
#[test]
fn a_part_of_a_file_may_have_elements_of_all_kinds() {
    let path = written("solid.inp");
    let part = read_solid_part(&path, None, None).unwrap();
    let kinds: Vec<ElementKind> = part.elements.iter().map(|cell| cell.kind).collect();
    assert_eq!(kinds, [ElementKind::Hexahedron8, ElementKind::Hexahedron8, ElementKind::Tetrahedron4]);

    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../mesh/tests/data");
    for (name, kinds) in [
        (
            "serendipity.msh",
            [ElementKind::Tetrahedron10, ElementKind::Wedge15, ElementKind::Hexahedron20].as_slice(),
        ),
        ("lagrange.msh", &[ElementKind::Tetrahedron10, ElementKind::Hexahedron27]),
    ] {
        for (k, &kind) in kinds.iter().enumerate() {
            let part = read_solid_part(&data.join(name), None, Some(&format!("solid {}", k + 1))).unwrap();
            assert!(part.elements.iter().all(|cell| cell.kind == kind), "{kind:?}");
            // The file's skin is all of it, and goes through all nodes of the faces.
            let surface = &part.surfaces[&format!("skin {}", k + 1)];
            assert_eq!(surface.len(), part.outside().len(), "{kind:?}");
            let nodes: std::collections::BTreeSet<usize> =
                surface.iter().flat_map(|facet| facet.corners()).copied().collect();
            let on_skin = |node: &&[f64; 3]| {
                let local = [node[0] - part.nodes[0][0].floor(), node[1], node[2]];
                local.iter().any(|x| x.abs() < 1e-9 || (x - 1.0).abs() < 1e-9)
            };
            assert_eq!(nodes.len(), part.nodes.iter().filter(on_skin).count(), "{kind:?}");
            Model::default().add("part", part, Some(STEEL)).unwrap();
        }
    }
}

/// An element that is there twice would have no outside, and one of second order on one of first order a face that gapes.
#[test]
fn elements_that_do_not_fit_together_are_refused() {
    let with = |order: &dyn Fn(&mut Cells, &Part)| {
        let mut part = block();
        let mut cells = part.elements.clone();
        order(&mut cells, &part);
        part.elements = cells;
        Model::default().add("a", part, Some(STEEL)).unwrap_err()
    };
    let twice = with(&|cells, part| cells.push(ElementKind::Hexahedron8, part.elements.get(2).nodes));
    assert!(
        matches!(twice, ModelError::OverlappingElements { element: 6, other: 2, shared: 8, .. }),
        "{twice}"
    );
    assert!(
        twice.to_string().starts_with("elements 7 and 3 of the part \"a\" lie on one another"),
        "{twice}"
    );

    let block = Block { origin: [0.0; 3], size: [1.0; 3], divisions: [2, 1, 1], grading: [1.0; 3] };
    let mut part = block.part(ElementKind::Hexahedron20).unwrap();
    let mut cells = Cells::default();
    cells.push(ElementKind::Hexahedron20, part.elements.get(0).nodes);
    cells.push(ElementKind::Hexahedron8, &part.elements.get(1).nodes[..8]);
    part.elements = cells;
    let error = Model::default().add("a", part, Some(STEEL)).unwrap_err();
    assert!(matches!(error, ModelError::HangingNodes { element: 1, other: 0, .. }), "{error}");
}

#[test]
fn a_rigid_part_of_a_file_keeps_its_orientation() {
    let part = read_rigid_part(&written("rigid.inp"), None, "PUNCH").unwrap();
    assert_eq!(part.facets, [Facet::Quadrilateral([0, 3, 2, 1])]);
    assert_eq!(part.node_sets["CORNERS"], [0]);
    let mut model = Model::default();
    model.add("punch", part, None).unwrap();
    assert_eq!(model.surfaces["punch.PUNCH"], model.surfaces["punch"]);
}

#[test]
fn files_without_what_is_asked_for_are_refused() {
    let path = written("refused.inp");
    assert!(matches!(read_solid_part(&path, None, Some("LID")), Err(ModelError::NoSolids { .. })));
    assert!(matches!(read_solid_part(&path, None, Some("LEVT")), Err(ModelError::Mesh(_))));
    assert!(matches!(read_rigid_part(&path, None, "LEFT"), Err(ModelError::Mesh(_))));
    assert!(matches!(read_rigid_part(Path::new("/nowhere.inp"), None, "LEFT"), Err(ModelError::Mesh(_))));
}

/// What a program wrote: two bodies as instances, a reference point, a mass, a connector and a pyramid.
#[test]
fn instances_of_a_file_become_parts() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../mesh/tests/data/cae.inp");
    let block = read_solid_part(&path, Some("block-1"), Some("Set-1")).unwrap();
    assert_eq!((block.nodes.len(), block.elements.len()), (12, 2));
    assert_eq!(block.surfaces["top"].len(), 2);
    assert_eq!(block.node_sets["bottom"], [0, 1, 2, 3, 4, 5]);
    // The pyramid is in these.
    assert!(!block.node_sets.contains_key("All") && !block.surfaces.contains_key("side"));
    let error = read_solid_part(&path, Some("block-1"), None).unwrap_err().to_string();
    assert!(
        error.contains("element 3 (line 29 of the mesh file) is of type C3D5")
            && error.contains("`elements` can name a set"),
        "{error}"
    );
    let punch = read_rigid_part(&path, Some("punch-1"), "face").unwrap();
    assert_eq!((punch.nodes.len(), punch.facets.len()), (4, 1));
    assert!(punch.nodes.iter().all(|node| (node[2] - 2.0).abs() < 1e-12));
    assert!(matches!(read_rigid_part(&path, None, "face"), Err(ModelError::Mesh(_))));
}

/// A solid that is left out is a hole; a type that is not known may be one.
#[test]
fn files_with_solids_that_are_not_read_are_refused() {
    let corners = "1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n";
    let read = |kind: &str| {
        let path = std::env::temp_dir().join(format!("diffuse-contact-{kind}-{}.inp", std::process::id()));
        let elements = format!("*ELEMENT, TYPE=C3D8R\n1,1,2,3,4,5,6,7,8\n*ELEMENT, TYPE={kind}\n2,1,2\n");
        std::fs::write(&path, format!("*NODE\n{corners}{elements}")).unwrap();
        let part = read_solid_part(&path, None, None);
        std::fs::remove_file(&path).unwrap();
        part
    };
    for kind in ["C3D27", "GK3D8", "Q3D8", "EC3D8R", "CCL12", "SC8R", "CSS8", "COH3D8", "FC3D8", "D3D8"] {
        let error = read(kind).unwrap_err();
        assert!(matches!(error, ModelError::UnreadSolid { tag: 2, line: 13, .. }), "{error}");
        assert_eq!(error.to_string().contains("Mesh.SecondOrderIncomplete = 1"), kind == "C3D27", "{error}");
    }
    for kind in [
        "MASS", "CONN3D2", "SPRINGA", "DCOUP3D", "S9R5", "B33", "PIPE31", "CPEG4", "CGAX8", "F3D4", "U1", "D",
    ] {
        assert!(read(kind).is_ok(), "{kind}");
    }
}

/// Whoever has the file open finds the element by its number there; of a shape they count from 1, body by body.
#[test]
fn elements_are_called_by_their_part_and_their_number_in_the_file() {
    use diffuse_contact_solver::solid::{Order, Solid, SolidResponse};
    let path = std::env::temp_dir().join(format!("diffuse-contact-labels-{}.inp", std::process::id()));
    let corners = "1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n9,0,0,2\n10,1,0,2\n11,1,1,2\n12,0,1,2\n";
    let elements = "*ELEMENT, TYPE=C3D8R\n4711,1,2,3,4,5,6,7,8\n4712,5,6,7,8,9,10,11,12\n";
    std::fs::write(&path, format!("*NODE\n{corners}{elements}")).unwrap();
    let part = read_solid_part(&path, None, None);
    std::fs::remove_file(&path).unwrap();
    let part = part.unwrap();
    assert_eq!(part.labels, [4711, 4712]);

    let mut flat = part.clone();
    flat.nodes[8..].iter_mut().for_each(|node| node[2] = 1.0);
    let error = Model::default().add("flat", flat, Some(STEEL)).unwrap_err().to_string();
    assert!(error.starts_with("element 4712 (in the mesh file) of the part \"flat\""), "{error}");
    let mut bent = block();
    bent.elements = with_nodes(&bent.elements, 3, |nodes| nodes.rotate_left(4));
    let error = Model::default().add("bent", bent, Some(STEEL)).unwrap_err().to_string();
    assert!(error.starts_with("element 4 of the part \"bent\""), "{error}");

    let mut model = Model::default();
    model.add("made", block(), Some(STEEL)).unwrap();
    let shift = model.nodes.len();
    model.add("read", part, Some(STEEL)).unwrap();
    let solid = Solid::new(&model.nodes, &model.bodies).unwrap();
    let error = |moved: &[usize]| {
        let mut positions = model.nodes.clone();
        // Through the opposite face.
        moved.iter().for_each(|&node| positions[node][2] -= 5.0);
        let mut out = SolidResponse::default();
        solid.evaluate(&positions, &solid.states(), Order::Residual, &mut out).unwrap_err().to_string()
    };
    let top = [8, 9, 10, 11].map(|node| node + shift);
    assert!(
        error(&top).starts_with("element 4712 of the mesh file (part \"read\") is turned"),
        "{}",
        error(&top)
    );
    let count = model.bodies[0].elements.len();
    let found = error(&model.bodies[0].elements.get(count - 1).nodes[4..]);
    assert!(found.contains("of the part \"made\" is turned inside out"), "{found}");
    assert!((1..=count).any(|k| found.starts_with(&format!("element {k} of"))), "{found}");
}
