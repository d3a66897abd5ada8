//! The meshes shipped in `meshes/` are what their script says.

use std::path::Path;

use diffuse_contact_mesh::{ElementKind, Facet, Mesh};

fn shipped(name: &str) -> Mesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes").join(name);
    Mesh::read(path).unwrap_or_else(|error| panic!("{error}"))
}

fn count(mesh: &Mesh, kind: ElementKind) -> usize {
    mesh.elements().iter().filter(|element| element.kind() == kind).count()
}

/// The z components of twice the facets' area vectors, by their diagonals or edges.
fn heights_of_normals(mesh: &Mesh, facets: &[Facet]) -> Vec<f64> {
    let between = |a: usize, b: usize| [0, 1].map(|k| mesh.nodes()[b][k] - mesh.nodes()[a][k]);
    let cross = |u: [f64; 2], v: [f64; 2]| u[0] * v[1] - u[1] * v[0];
    facets
        .iter()
        .map(|facet| match *facet {
            Facet::Triangle([a, b, c]) => cross(between(a, b), between(a, c)),
            Facet::Quadrilateral([a, b, c, d]) => cross(between(a, c), between(b, d)),
        })
        .collect()
}

/// Checks the orientations, and the smallest and largest distance of slave nodes from the true master surface.
fn check(mesh: &Mesh, distance: impl Fn([f64; 3]) -> f64, farthest: f64) {
    let master = mesh.facets("master").unwrap();
    let slave = mesh.facets("slave").unwrap();
    assert!(heights_of_normals(mesh, &master).iter().all(|&z| z > 0.0));
    assert!(heights_of_normals(mesh, &slave).iter().all(|&z| z < 0.0));
    for node in mesh.nodes_of("master").unwrap() {
        assert!(distance(mesh.nodes()[node]).abs() < 1e-9);
    }
    let gaps: Vec<f64> =
        mesh.nodes_of("slave").unwrap().into_iter().map(|node| distance(mesh.nodes()[node])).collect();
    let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = gaps.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert!((-0.6..-0.4).contains(&least), "{least}");
    assert!((farthest - 0.5..farthest + 0.5).contains(&largest), "{largest}");
    assert_eq!(mesh.set_names(), ["master", "slave"]);
}

#[test]
fn plate_on_cylinder() {
    let mesh = shipped("plate_on_cylinder.msh");
    check(&mesh, |[x, _, z]| x.hypot(z) - 100.0, 6.6);
    assert_eq!(mesh.nodes().len(), 604);
    assert_eq!(mesh.nodes_of("master").unwrap().len(), 179);
    assert_eq!(mesh.nodes_of("slave").unwrap().len(), 425);
    assert_eq!(count(&mesh, ElementKind::Quadrilateral4), 70);
    assert_eq!(count(&mesh, ElementKind::Triangle3), 166 + 776);
}

#[test]
fn the_abaqus_deck_is_the_same_mesh() {
    let (gmsh, abaqus) = (shipped("plate_on_cylinder.msh"), shipped("plate_on_cylinder.inp"));
    assert_eq!(gmsh.nodes(), abaqus.nodes());
    assert_eq!(gmsh.node_tags(), abaqus.node_tags());
    assert_eq!(gmsh.elements(), abaqus.elements());
    assert_eq!(gmsh.element_sets(), abaqus.element_sets());
    assert_eq!(abaqus.facets("master_surface").unwrap(), gmsh.facets("master").unwrap());
    assert_eq!(abaqus.facets("slave_surface").unwrap(), gmsh.facets("slave").unwrap());
}

#[test]
fn torus_patch() {
    let mesh = shipped("torus_patch.msh");
    check(&mesh, |[x, y, z]| ((x + 120.0).hypot(y) - 120.0).hypot(z + 50.0) - 50.0, 2.8);
    assert_eq!(count(&mesh, ElementKind::Quadrilateral4), 100);
    assert_eq!(mesh.nodes().len(), 220);
}
