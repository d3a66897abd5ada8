//! The MSH reader against files written by Gmsh (`data/make_fixtures.py`) and against damaged ones.

use std::path::{Path, PathBuf};

use diffuse_contact_mesh::{ElementKind, Facet, Mesh, MeshError, Place, Problem};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn block() -> Mesh {
    Mesh::read(data("block_ascii.msh")).unwrap()
}

/// The place and problem of a text that is not a mesh.
fn fault(text: impl AsRef<[u8]>) -> (Place, Problem) {
    match Mesh::from_gmsh(text.as_ref(), "bad.msh") {
        Err(MeshError::Invalid { place, problem, .. }) => (place, problem),
        other => panic!("expected a fault, got {other:?}"),
    }
}

/// Two triangles on four nodes; the parts can be replaced to damage it.
const SQUARE: &str = "\
$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
1
2 7 \"a square\"
$EndPhysicalNames
$Entities
0 0 1 0
1 0 0 0 1 1 0 1 7 0
$EndEntities
$Nodes
1 4 1 4
2 1 0 4
1
2
3
4
0 0 0
1 0 0
1 1 0
0 1 0
$EndNodes
$Elements
1 2 1 2
2 1 2 2
1 1 2 3
2 1 3 4
$EndElements
";

fn square_with(from: &str, to: &str) -> String {
    assert!(SQUARE.contains(from), "{from:?} is not in the file");
    SQUARE.replacen(from, to, 1)
}

#[test]
fn the_block_has_all_nodes_elements_and_groups() {
    let mesh = block();
    assert_eq!(mesh.nodes().len(), 12);
    assert_eq!(mesh.node_tags()[8], 9);
    assert_eq!(mesh.nodes()[8], [1.0, 0.0, 0.0]);
    let count = |kind| mesh.elements().iter().filter(|element| element.kind() == kind).count();
    assert_eq!(count(ElementKind::Point1), 1);
    assert_eq!(count(ElementKind::Line2), 1);
    assert_eq!(count(ElementKind::Quadrilateral4), 4);
    assert_eq!(count(ElementKind::Hexahedron8), 2);
    assert_eq!(mesh.set_names(), ["corner", "edge", "surface 4", "the block", "top", "top reversed"]);
    assert_eq!(mesh.elements_of("the block").unwrap(), [6, 7]);
    assert_eq!(mesh.elements()[6].tag(), 35);
    assert_eq!(mesh.nodes_of("the block").unwrap().len(), 12);
    assert_eq!(mesh.nodes_of("corner").unwrap(), [0]);
    assert_eq!(mesh.nodes_of("edge").unwrap(), [0, 1]);
    assert_eq!(mesh.facets("surface 4").unwrap().len(), 2);
}

/// The nodes in the middle of edges, faces and elements lie there: so they are in our order. The skins are closed, each node of them
/// belongs to a facet.
#[test]
fn elements_of_second_order_have_their_nodes_in_our_order() {
    let mut kinds = std::collections::BTreeSet::new();
    for (name, blocks) in [("serendipity.msh", 3), ("lagrange.msh", 2)] {
        let mesh = Mesh::read(data(name)).unwrap();
        for element in mesh.elements() {
            let (kind, nodes) = (element.kind(), element.nodes());
            kinds.insert(kind);
            let mean = |corners: &[usize]| {
                [0, 1, 2].map(|axis| {
                    corners.iter().map(|&corner| mesh.nodes()[nodes[corner]][axis]).sum::<f64>()
                        / corners.len() as f64
                })
            };
            let near = |k: usize, middle: [f64; 3]| {
                let found = mesh.nodes()[nodes[k]];
                (0..3).all(|axis| (found[axis] - middle[axis]).abs() < 1e-12)
            };
            let corners = kind.corner_count();
            for (k, ends) in kind.edges().iter().enumerate() {
                assert!(near(corners + k, mean(ends)), "{kind:?}, middle of {ends:?}");
            }
            if kind == ElementKind::Hexahedron27 {
                let faces =
                    [[0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 2, 6, 7], [0, 1, 2, 3], [4, 5, 6, 7]];
                for (k, face) in faces.iter().enumerate() {
                    assert!(near(20 + k, mean(face)), "centre of {face:?}");
                }
                assert!(near(26, mean(&[0, 1, 2, 3, 4, 5, 6, 7])));
            }
        }
        for block in 1..=blocks {
            let (name, skin) = (format!("skin {block}"), mesh.facets(&format!("skin {block}")).unwrap());
            let on_skin: std::collections::BTreeSet<usize> =
                skin.iter().flat_map(Facet::nodes).copied().collect();
            assert_eq!(mesh.nodes_of(&name).unwrap(), on_skin.iter().copied().collect::<Vec<_>>());
            // Cones over its triangles fill the unit cube, whichever way they are turned.
            let sum = |axis: usize| on_skin.iter().map(|&node| mesh.nodes()[node][axis]).sum::<f64>();
            let centre = [0, 1, 2].map(|axis| sum(axis) / on_skin.len() as f64);
            let triangles = skin.iter().flat_map(|facet| match *facet {
                Facet::Triangle(corners) => vec![corners],
                Facet::Quadrilateral([a, b, c, d]) => vec![[a, b, c], [a, c, d]],
            });
            let cone = |corners: [usize; 3]| {
                let [a, b, c] =
                    corners.map(|node| [0, 1, 2].map(|axis| mesh.nodes()[node][axis] - centre[axis]));
                let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
                (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]).abs() / 6.0
            };
            let volume: f64 = triangles.map(cone).sum();
            assert!((volume - 1.0).abs() < 1e-12, "{name}: {volume}");
        }
    }
    let solid = |kind: &&ElementKind| kind.dimension() == 3;
    let solids: Vec<ElementKind> = kinds.iter().filter(solid).copied().collect();
    use ElementKind::{Hexahedron20, Hexahedron27, Tetrahedron10, Wedge15};
    assert_eq!(solids, [Tetrahedron10, Wedge15, Hexahedron20, Hexahedron27]);
    for kind in [ElementKind::Triangle6, ElementKind::Quadrilateral8, ElementKind::Quadrilateral9] {
        assert!(kinds.contains(&kind));
    }
}

#[test]
fn a_negative_physical_tag_reverses_the_facets() {
    let mesh = block();
    let top = mesh.facets("top").unwrap();
    assert_eq!(top, [Facet::Quadrilateral([0, 9, 11, 2]), Facet::Quadrilateral([9, 4, 6, 11])]);
    let reversed: Vec<Facet> = top.into_iter().map(Facet::reversed).collect();
    assert_eq!(mesh.facets("top reversed").unwrap(), reversed);
    assert_eq!(mesh.nodes_of("top").unwrap(), mesh.nodes_of("top reversed").unwrap());
}

#[test]
fn binary_and_ascii_give_the_same_mesh() {
    // 1 - 2^-53 and the like: Gmsh writes 16 digits, which is one too few for some coordinates.
    let (ascii, binary) = (block(), Mesh::read(data("block_binary.msh")).unwrap());
    for (a, b) in ascii.nodes().iter().flatten().zip(binary.nodes().iter().flatten()) {
        assert!((a - b).abs() <= 4.0 * f64::EPSILON);
    }
    assert_eq!(ascii.node_tags(), binary.node_tags());
    assert_eq!(ascii.elements(), binary.elements());
    assert_eq!(ascii.element_sets(), binary.element_sets());
    assert_eq!(ascii.surfaces(), binary.surfaces());
}

/// Writes `SQUARE` as binary.
fn binary_square(int: fn(i32) -> [u8; 4], size: fn(u64) -> [u8; 8], real: fn(f64) -> [u8; 8]) -> Vec<u8> {
    let mut bytes = b"$MeshFormat\n4.1 1 8\n".to_vec();
    bytes.extend(int(1));
    bytes.extend(b"\n$EndMeshFormat\n$PhysicalNames\n1\n2 7 \"a square\"\n$EndPhysicalNames\n$Entities\n");
    [0, 0, 1, 0].into_iter().for_each(|count| bytes.extend(size(count)));
    bytes.extend(int(1));
    [0.0, 0.0, 0.0, 1.0, 1.0, 0.0].into_iter().for_each(|extent| bytes.extend(real(extent)));
    bytes.extend(size(1));
    bytes.extend(int(7));
    bytes.extend(size(0));
    bytes.extend(b"\n$EndEntities\n$Nodes\n");
    [1, 4, 1, 4].into_iter().for_each(|count| bytes.extend(size(count)));
    [2, 1, 0].into_iter().for_each(|number| bytes.extend(int(number)));
    [4, 1, 2, 3, 4].into_iter().for_each(|number| bytes.extend(size(number)));
    [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.].into_iter().for_each(|x| bytes.extend(real(x)));
    bytes.extend(b"\n$EndNodes\n$Elements\n");
    [1, 2, 1, 2].into_iter().for_each(|count| bytes.extend(size(count)));
    [2, 1, 2].into_iter().for_each(|number| bytes.extend(int(number)));
    [2, 1, 1, 2, 3, 2, 1, 3, 4].into_iter().for_each(|number| bytes.extend(size(number)));
    bytes.extend(b"\n$EndElements\n");
    bytes
}

#[test]
fn both_byte_orders_are_read() {
    let ascii = Mesh::from_gmsh(SQUARE.as_bytes(), "square.msh").unwrap();
    assert_eq!(ascii.facets("a square").unwrap(), [Facet::Triangle([0, 1, 2]), Facet::Triangle([0, 2, 3])]);
    let little = binary_square(i32::to_le_bytes, u64::to_le_bytes, f64::to_le_bytes);
    let big = binary_square(i32::to_be_bytes, u64::to_be_bytes, f64::to_be_bytes);
    assert_eq!(Mesh::from_gmsh(&little, "square.msh").unwrap(), ascii);
    assert_eq!(Mesh::from_gmsh(&big, "square.msh").unwrap(), ascii);
}

#[test]
fn windows_line_ends_and_foreign_sections_do_not_matter() {
    let mesh = Mesh::from_gmsh(SQUARE.as_bytes(), "square.msh").unwrap();
    let windows = SQUARE.replace('\n', "\r\n");
    assert_eq!(Mesh::from_gmsh(windows.as_bytes(), "square.msh").unwrap(), mesh);
    let commented = square_with("$Nodes", "$Comments\n$Nodes is next\n$EndComments\n$Nodes");
    assert_eq!(Mesh::from_gmsh(commented.as_bytes(), "square.msh").unwrap(), mesh);
}

#[test]
fn the_content_tells_the_format_where_the_extension_does_not() {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("by_content");
    std::fs::create_dir_all(&directory).unwrap();
    let read = |name: &str, text: &str| {
        let path = directory.join(name);
        std::fs::write(&path, text).unwrap();
        Mesh::read(path)
    };
    assert_eq!(read("square.dat", SQUARE).unwrap().nodes().len(), 4);
    assert_eq!(read("SQUARE.MSH", SQUARE).unwrap().nodes().len(), 4);
    let deck = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n*ELEMENT,TYPE=S3\n1,1,2,3\n";
    assert_eq!(read("deck", deck).unwrap().nodes().len(), 3);
    assert!(matches!(read("notes.txt", "hello"), Err(MeshError::UnknownFormat { .. })));
    let missing = Mesh::read(directory.join("absent.msh")).unwrap_err();
    assert!(missing.to_string().contains("absent.msh: cannot be read"), "{missing}");
}

#[test]
fn a_missing_set_lists_names_and_suggests_one() {
    let mesh = Mesh::from_gmsh(SQUARE.as_bytes(), "square.msh").unwrap();
    let message = mesh.facets("a sqaure").unwrap_err().to_string();
    assert_eq!(
        message,
        "no set is named \"a sqaure\" (did you mean \"a square\"?); the mesh has \"a square\""
    );
    assert!(matches!(mesh.nodes_of("x"), Err(MeshError::UnknownSet { nearest: None, .. })));
    assert_eq!(mesh.facets("A SQUARE").unwrap().len(), 2);
    let message = block().facets("the block").unwrap_err().to_string();
    assert_eq!(
        message,
        "the set \"the block\" has no triangles or quadrilaterals to serve as facets: it holds 2 hexahedra"
    );
}

#[test]
fn other_versions_and_unsupported_files_are_refused_by_name() {
    let message = |name: &str| Mesh::read(data(name)).unwrap_err().to_string();
    let version_2 = message("version_2.msh");
    assert!(version_2.contains("version_2.msh, line 2: MSH version 2.2 is not supported"), "{version_2}");
    assert!(version_2.contains("-format msh41"), "{version_2}");
    let third_order = message("third_order.msh");
    assert!(third_order.contains("element type 36 (unknown) is not supported"), "{third_order}");
    let wedges =
        std::fs::read_to_string(data("block_ascii.msh")).unwrap().replace("\n3 1 5 2\n", "\n3 1 13 2\n");
    let wedges = Mesh::from_gmsh(wedges.as_bytes(), "wedges.msh").unwrap_err().to_string();
    assert!(
        wedges.ends_with("; Gmsh's option Mesh.SecondOrderIncomplete = 1 writes 15-node wedges instead"),
        "{wedges}"
    );
    let partitioned = message("partitioned.msh");
    assert!(partitioned.contains("$PartitionedEntities) is not supported"), "{partitioned}");
}

#[test]
fn damaged_numbers_are_found_in_their_line() {
    let unexpected = |expected: &str, found: &str| Problem::Unexpected {
        expected: expected.to_string(),
        found: found.to_string(),
    };
    assert_eq!(
        fault(square_with("1 1 0\n0 1 0", "1 1x 0\n0 1 0")),
        (Place::Line(21), unexpected("a coordinate of a node", "1x"))
    );
    assert_eq!(
        fault(square_with("1 1 2 3", "1 1 -2 3")),
        (Place::Line(27), unexpected("the tag of an element's node", "-2"))
    );
    assert_eq!(fault("$NOD\n"), (Place::Line(1), unexpected("$MeshFormat", "$NOD")));
    assert_eq!(
        fault(square_with("$EndNodes", "0 0 0\n$EndNodes")),
        (Place::Line(23), unexpected("$EndNodes", "0 0 0"))
    );
    assert_eq!(
        fault(square_with("2 7 \"a square\"", "2 7 a square")),
        (Place::Line(6), unexpected("a physical name: dimension, tag, \"name\"", "2 7 a square"))
    );
    assert_eq!(
        fault(square_with("2 1 0 4", "4 1 0 4")),
        (Place::Line(14), unexpected("a dimension from 0 to 3", "4"))
    );
    assert_eq!(
        fault(square_with("2 1 0 4", "2 1 5 4")),
        (Place::Line(14), unexpected("0 or 1 (parametric nodes)", "5"))
    );
}

#[test]
fn unsound_meshes_are_refused() {
    let (place, problem) = fault(square_with("1 1 0\n0 1 0", "1 nan 0\n0 1 0"));
    assert_eq!(place, Place::Line(21));
    assert!(matches!(problem, Problem::NonFiniteCoordinate { tag: 3, axis: 'y', .. }));
    let (place, problem) = fault(square_with("1 1 0\n0 1 0", "1 1 -inf\n0 1 0"));
    assert_eq!(place, Place::Line(21));
    assert!(matches!(problem, Problem::NonFiniteCoordinate { tag: 3, axis: 'z', .. }));
    assert_eq!(
        fault(square_with("\n3\n4\n", "\n3\n3\n")),
        (Place::Line(18), Problem::DuplicateNode { tag: 3 })
    );
    assert_eq!(
        fault(square_with("2 1 3 4", "1 1 3 4")),
        (Place::Line(28), Problem::DuplicateElement { tag: 1 })
    );
    assert_eq!(
        fault(square_with("2 1 3 4", "2 1 3 9")),
        (Place::Line(28), Problem::MissingNode { element: 2, node: 9 })
    );
    assert_eq!(
        fault(square_with("2 1 3 4", "2 1 3 1")),
        (Place::Line(28), Problem::RepeatedNode { element: 2, node: 1 })
    );
}

#[test]
fn headers_are_not_trusted() {
    let huge = u64::MAX;
    assert_eq!(
        fault(square_with("2 1 0 4", &format!("2 1 0 {huge}"))),
        (Place::Line(14), Problem::CountTooLarge { what: "nodes", declared: huge })
    );
    assert_eq!(
        fault(square_with("2 1 2 2", "2 1 2 1000000000000")),
        (Place::Line(26), Problem::CountTooLarge { what: "elements", declared: 1_000_000_000_000 })
    );
    assert_eq!(
        fault(square_with("0 0 1 0\n", "0 0 9000000 0\n")),
        (Place::Line(9), Problem::CountTooLarge { what: "entities", declared: 9_000_000 })
    );
    assert_eq!(
        fault(square_with("1 4 1 4", "1 5 1 4")),
        (Place::Line(13), Problem::CountMismatch { what: "nodes", declared: 5, found: 4 })
    );
    assert_eq!(
        fault(square_with("1 2 1 2", "1 3 1 2")),
        (Place::Line(25), Problem::CountMismatch { what: "elements", declared: 3, found: 2 })
    );
    let (place, _) = fault(square_with("1 4 1 4", "77777777777 4 1 4"));
    assert_eq!(place, Place::Line(23));
    let mut binary = binary_square(i32::to_le_bytes, u64::to_le_bytes, f64::to_le_bytes);
    let nodes = binary.windows(7).position(|window| window == b"$Nodes\n").unwrap() + 7;
    binary[nodes + 44..nodes + 52].copy_from_slice(&huge.to_le_bytes());
    assert_eq!(
        fault(&binary),
        (Place::Byte(nodes + 52), Problem::CountTooLarge { what: "nodes", declared: huge })
    );
}

#[test]
fn truncated_files_say_what_is_missing() {
    let end = SQUARE.find("$EndElements").unwrap();
    let (place, problem) = fault(&SQUARE[..end]);
    assert_eq!(problem, Problem::Truncated { expected: "$EndElements".into() });
    assert_eq!(place, Place::Line(29));
    let nodes = SQUARE.find("$Elements").unwrap();
    let message = Mesh::from_gmsh(&SQUARE.as_bytes()[..nodes], "half.msh").unwrap_err().to_string();
    assert_eq!(message, "half.msh: the mesh has no elements");
    let message = Mesh::from_gmsh(b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", "empty.msh").unwrap_err();
    assert_eq!(message.to_string(), "empty.msh: the mesh has no nodes");
    let message = Mesh::from_gmsh(b"", "empty.msh").unwrap_err().to_string();
    assert_eq!(message, "empty.msh, line 1: the file ends before $MeshFormat");
    let binary = binary_square(i32::to_le_bytes, u64::to_le_bytes, f64::to_le_bytes);
    let (_, problem) = fault(&binary[..binary.len() - 20]);
    assert_eq!(problem, Problem::CountTooLarge { what: "elements", declared: 2 });
    let half_a_count = binary.windows(10).position(|window| window == b"$Elements\n").unwrap() + 14;
    let (place, problem) = fault(&binary[..half_a_count]);
    assert_eq!(problem, Problem::Truncated { expected: "the number of element blocks".into() });
    assert_eq!(place, Place::Byte(half_a_count));
}

#[test]
fn a_wrong_byte_order_mark_is_shown() {
    let (place, problem) = fault(b"$MeshFormat\n4.1 1 8\n\x02\x00\x00\x00\n$EndMeshFormat\n");
    assert_eq!(place, Place::Line(3));
    assert!(problem.to_string().contains("02, 00, 00, 00"), "{problem}");
}

/// Every group of an entity holds all of its elements, so their number is a product.
#[test]
fn what_groups_hold_altogether_is_bounded() {
    let text = |groups: usize, elements: usize| {
        let tags: String = (1..=groups).map(|tag| format!("{tag} ")).collect();
        let members: String = (1..=elements).map(|tag| format!("{tag} 1 2 3\n")).collect();
        format!(
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n1 0 0 0 1 1 0 {groups} {tags}0\n$EndEntities\n$Nodes\n1 3 1 3\n\
             2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n$Elements\n1 {elements} 1 {elements}\n2 1 2 {elements}\n\
             {members}$EndElements\n"
        )
    };
    let mesh = Mesh::from_gmsh(text(100, 50).as_bytes(), "groups.msh").unwrap();
    assert!((1..=100).all(|k| mesh.element_sets()[&format!("surface {k}")].len() == 50));
    let error = Mesh::from_gmsh(text(20_000, 5_000).as_bytes(), "groups.msh").unwrap_err();
    assert!(
        matches!(error, MeshError::Invalid { problem: Problem::SetsTooLarge { what: "elements", .. }, .. }),
        "{error}"
    );
}

#[test]
fn names_of_a_file_are_shown_in_one_line_of_limited_length() {
    let hostile = "\u{1b}[2J".to_owned() + &"x".repeat(100_000);
    let mesh = Mesh::from_gmsh(SQUARE.as_bytes(), "square.msh").unwrap();
    let message = mesh.facets(&format!("{hostile}\nerror: forged")).unwrap_err().to_string();
    assert!(message.len() < 300 && !message.contains(['\u{1b}', '\n']), "{message}");
}
