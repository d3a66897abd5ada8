//! Wedges in contact: parts of files, since no shape is made of them.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use diffuse_contact::Weight;
use diffuse_contact_mesh::ElementKind;
use diffuse_contact_solver::deck::Deck;
use diffuse_contact_solver::model::shape::Block;
use diffuse_contact_solver::verification::{Uniformity, trace};

/// Nodes of a hexahedron with 27 of the two wedges with 15 that it is cut into: corners, edges below, above and upright.
const HALVES: [[usize; 15]; 2] = [
    [0, 1, 2, 4, 5, 6, 8, 9, 24, 12, 13, 25, 16, 17, 18],
    [0, 2, 3, 4, 6, 7, 24, 10, 11, 25, 14, 15, 16, 18, 19],
];

/// The file of a block from height `z` on, cut into wedges whose triangles lie below and above.
fn file(name: &str, divisions: [usize; 3], z: f64, nodes_each: usize) -> String {
    let block = Block { origin: [0.0, 0.0, z], size: [10.0, 10.0, 5.0], divisions, grading: [1.0; 3] };
    let part = block.part(ElementKind::Hexahedron27).unwrap();
    let wedges: Vec<Vec<usize>> = part
        .elements
        .iter()
        .flat_map(|cell| HALVES.map(|half| half[..nodes_each].iter().map(|&k| cell.nodes[k]).collect()))
        .collect();
    let used: BTreeMap<usize, [f64; 3]> =
        wedges.iter().flatten().map(|&node| (node, part.nodes[node])).collect();
    let mut text = "*NODE\n".to_owned();
    for (node, [x, y, z]) in &used {
        writeln!(text, "{}, {x:?}, {y:?}, {z:?}", node + 1).unwrap();
    }
    writeln!(text, "*ELEMENT, TYPE=C3D{nodes_each}, ELSET=ALL").unwrap();
    for (k, wedge) in wedges.iter().enumerate() {
        let nodes: Vec<String> = wedge.iter().map(|node| (node + 1).to_string()).collect();
        writeln!(text, "{}, {}", k + 1, nodes.join(", ")).unwrap();
    }
    for (set, axis, place) in [("LEFT", 0, 0.0), ("FRONT", 1, 0.0), ("GROUND", 2, z)] {
        writeln!(text, "*NSET, NSET={set}").unwrap();
        for (node, _) in used.iter().filter(|(_, x)| (x[axis] - place).abs() < 1e-9) {
            writeln!(text, "{}", node + 1).unwrap();
        }
    }
    for (surface, face, place) in [("BELOW", "S1", z), ("ABOVE", "S2", z + 5.0)] {
        writeln!(text, "*SURFACE, NAME={surface}, TYPE=ELEMENT").unwrap();
        let corner = if face == "S1" { 0 } else { 3 };
        for (k, _) in
            wedges.iter().enumerate().filter(|(_, own)| (used[&own[corner]][2] - place).abs() < 1e-9)
        {
            writeln!(text, "{}, {face}", k + 1).unwrap();
        }
    }
    let directory = std::env::temp_dir().join(format!("diffuse-contact-wedges-{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    let path = directory.join(name);
    std::fs::write(&path, text).unwrap();
    path.display().to_string()
}

/// The patch test on meshes that do not match, of wedges with 6 and 15 nodes, with either side as slave.
#[test]
fn a_uniform_pressure_passes_between_wedges() {
    for (nodes_each, upper, weight) in [
        (6, [3, 4, 2], Weight::Cubic),
        (6, [2, 2, 1], Weight::WendlandC2),
        (15, [2, 3, 1], Weight::Cubic),
        (15, [3, 2, 1], Weight::CubicInterpolating),
    ] {
        let below = file(&format!("lower{nodes_each}.inp"), [3, 2, 1], 0.0, nodes_each);
        let above = file(&format!("upper{nodes_each}.inp"), upper, 5.0 - 1e-6, nodes_each);
        for (master, slave) in [("lower.ABOVE", "upper.BELOW"), ("upper.BELOW", "lower.ABOVE")] {
            let text = format!(
                "[materials.soft]\nyoung = 10000.0\npoisson = 0.0\n\
                 [parts.lower]\nfile = {below:?}\nmaterial = \"soft\"\n[parts.upper]\nfile = {above:?}\nmaterial = \"soft\"\n\
                 [[boundary]]\nnodes = \"lower.GROUND\"\nfix = [\"z\"]\n\
                 [[boundary]]\nnodes = [\"lower.LEFT\", \"upper.LEFT\"]\nfix = [\"x\"]\n\
                 [[boundary]]\nnodes = [\"lower.FRONT\", \"upper.FRONT\"]\nfix = [\"y\"]\n\
                 [[pressure]]\nsurface = \"upper.ABOVE\"\nvalue = 100.0\n\
                 [[interface]]\nname = \"joint\"\nmaster = \"{master}\"\nslave = \"{slave}\"\nintegration = \"faces\"\n\
                 weight = \"{}\"\npenalty = 1e6\n\
                 [time]\nincrement = 1.0\n[newton]\ntolerance = 1e-13\n",
                weight.name()
            );
            let deck = Deck::parse(&text).unwrap();
            let run = trace(&deck, Path::new(""), 1, |snapshot| Uniformity::of(snapshot, 2, 100.0)).unwrap();
            let Uniformity { stress, other_stress, .. } = *run.measures.last().unwrap();
            println!("{nodes_each} {upper:?} {slave}: {stress:e} {other_stress:e}");
            let error = crate::common::worse(stress, other_stress);
            assert!(error < 1e-9, "{nodes_each} {upper:?} {slave}: {stress:e} {other_stress:e}");
        }
    }
}
