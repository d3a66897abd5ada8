//! Files as programs write them: with what is not of the mesh that is asked for.

use std::path::PathBuf;

use diffuse_contact_mesh::{ElementKind, Facet, Mesh, MeshError};

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn instance(name: &str) -> Mesh {
    Mesh::read_instance(data("cae.inp"), name).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn an_instance_has_its_part_and_its_share_of_the_assembly() {
    let block = instance("BLOCK-1");
    assert_eq!((block.nodes().len(), block.elements().len()), (14, 2));
    assert!(block.elements().iter().all(|element| element.kind() == ElementKind::Hexahedron8));
    assert_eq!(block.nodes_of("bottom").unwrap(), [0, 1, 2, 3, 4, 5]);
    assert_eq!(block.nodes_of("dots_CNS_").unwrap(), [0, 1, 2, 3, 4, 5]);
    assert_eq!(block.nodes_of("both").unwrap(), [6, 7], "not those of the other instance");
    assert_eq!(block.elements_of("Set-1").unwrap(), [0, 1]);
    let top = [Facet::Quadrilateral([6, 7, 10, 9]), Facet::Quadrilateral([7, 8, 11, 10])];
    assert_eq!(block.facets("top").unwrap(), top);
    // Reference points have numbers that nodes of the part have, too.
    for set in ["m_Set-9", "Set-10", "refs"] {
        assert!(block.nodes_of(set).unwrap().is_empty(), "{set}");
    }
    assert!(block.elements_of("Wire-1-Set-1").unwrap().is_empty());
    assert!(matches!(block.facets("face"), Err(MeshError::NoFacets { .. })));
}

#[test]
fn an_element_that_is_not_supported_matters_where_it_is_asked_for() {
    let block = instance("block-1");
    let unread: Vec<_> = block.unread_elements().iter().map(|e| (e.tag, e.kind.as_str())).collect();
    assert_eq!(unread, [(3, "C3D5")]);
    for error in [
        block.elements_of("all").unwrap_err(),
        block.facets("All").unwrap_err(),
        block.nodes_of("ALL").unwrap_err(),
        block.facets("side").unwrap_err(),
        block.nodes_of("side").unwrap_err(),
    ] {
        assert!(
            error
                .to_string()
                .contains("holds element 3 of type C3D5 (line 29 of the mesh file), which is not supported"),
            "{error}"
        );
    }
    let punch = instance("punch-1");
    assert!(punch.elements_of("heavy").unwrap_err().to_string().contains("element 2 of type MASS"));
    assert_eq!(punch.facets("shell").unwrap(), [Facet::Quadrilateral([0, 1, 2, 3])]);
}

#[test]
fn an_instance_lies_where_the_assembly_has_it() {
    // Turned over, about an axis along x through its middle.
    let punch = instance("punch-1");
    let expected = [[0.0, 1.0, 2.0], [1.0, 1.0, 2.0], [1.0, 0.0, 2.0], [0.0, 0.0, 2.0]];
    for (node, expected) in punch.nodes().iter().zip(expected) {
        assert!((0..3).all(|k| (node[k] - expected[k]).abs() < 1e-15), "{node:?} {expected:?}");
    }
    assert_eq!(punch.facets("face").unwrap(), [Facet::Quadrilateral([0, 1, 2, 3])]);
    assert_eq!(punch.nodes_of("refs").unwrap(), [5]);
    let other = instance("punch-2");
    assert_eq!(other.nodes()[2], [2.0, 1.0, 3.0]);
    assert_eq!(other.nodes_of("both").unwrap(), [0, 1]);
    assert!(other.facets("face").is_err());
}

#[test]
fn the_instance_has_to_be_named_and_to_be_there() {
    let message = |error: MeshError| error.to_string();
    let several = message(Mesh::read(data("cae.inp")).unwrap_err());
    assert!(
        several.contains("line 67: the file has several instances, and one has to be named"),
        "{several}"
    );
    assert!(several.contains(r#"there are "block-1", "punch-1", "punch-2""#), "{several}");
    let none = message(Mesh::read_instance(data("cae.inp"), "block").unwrap_err());
    assert!(none.contains(r#"no instance is named "block"; there are "block-1""#), "{none}");
    let flat = message(Mesh::read_instance(data("block_gmsh.inp"), "block").unwrap_err());
    assert!(flat.contains(r#"no instance is named "block"; there are none"#), "{flat}");
    let gmsh = Mesh::read_instance(data("block_ascii.msh"), "block").unwrap_err();
    assert!(matches!(gmsh, MeshError::NoInstances { .. }), "{gmsh}");
}

/// What `make_fixtures.py` had Gmsh write, in both of its formats.
#[test]
fn gmsh_writes_the_same_mesh_in_both_formats() {
    let (inp, msh) =
        (Mesh::read(data("block_gmsh.inp")).unwrap(), Mesh::read(data("block_ascii.msh")).unwrap());
    assert_eq!(inp.nodes(), msh.nodes());
    let hexahedra = |mesh: &Mesh| {
        let all = mesh.elements().iter().filter(|element| element.kind() == ElementKind::Hexahedron8);
        all.map(|element| element.nodes().to_vec()).collect::<Vec<_>>()
    };
    assert_eq!(hexahedra(&inp), hexahedra(&msh));
    assert_eq!(inp.facets("top").unwrap().len(), msh.facets("top").unwrap().len());
    assert_eq!(inp.elements_of("the_block").unwrap().len(), 2);
}
