//! Files of the integration points.

use std::fs;
use std::path::Path;

use crate::decks::files;
use crate::runs::{Scratch, run};

/// The numbers of an array of a VTU file.
fn array(bytes: &[u8], name: &str) -> Vec<f64> {
    let marker = b"<AppendedData encoding=\"raw\">\n_";
    let start = bytes.windows(marker.len()).position(|window| window == marker).unwrap();
    let text = std::str::from_utf8(&bytes[..start]).unwrap();
    let tag = text.lines().find(|line| line.contains(&format!("Name=\"{name}\""))).unwrap();
    let offset = tag.split("offset=\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
    let (length, data) = bytes[start + marker.len() + offset.parse::<usize>().unwrap()..].split_at(8);
    let data = &data[..u64::from_le_bytes(length.try_into().unwrap()) as usize];
    data.chunks(8).map(|number| f64::from_le_bytes(number.try_into().unwrap())).collect()
}

/// Integration points have files of their own, which a run that replaces another one takes away with the rest.
#[test]
fn points_of_faces_are_written() {
    let scratch = Scratch::new("output-points");
    let over_faces = include_str!("partial_overlap.toml");
    let over_nodes = over_faces.replace("integration = \"faces\"", "areas = true");
    let (faces, nodes) = (scratch.file("faces.toml", over_faces), scratch.file("nodes.toml", &over_nodes));
    let out = scratch.path("out");
    assert_eq!(run(&["solve", &faces, "--out", &out]).code, 0);
    let series = fs::read_to_string(Path::new(&out).join("points.pvd")).unwrap();
    assert!(series.contains("timestep=\"1.0\" part=\"0\" file=\"points/00001.vtu\""), "{series}");
    let file = fs::read(Path::new(&out).join("points/00001.vtu")).unwrap();
    let [area, gap, pressure] = ["area", "contact_gap", "contact_pressure"].map(|name| array(&file, name));
    assert!((area.iter().sum::<f64>() / 40.0 - 1.0).abs() < 1e-9);
    assert!(gap.iter().zip(&pressure).all(|(gap, p)| *gap < 0.0 && (p / 10.0 - 1.0).abs() < 1e-6));
    let (places, normals) = (array(&file, "Points"), array(&file, "normal"));
    assert_eq!((places.len(), normals.len()), (3 * area.len(), 3 * area.len()));
    assert!(normals.chunks(3).all(|normal| (normal[2] - 1.0).abs() < 1e-9));

    // A run that was killed may have left a list that knows of more, or of less.
    let list = Path::new(&out).join("points.pvd");
    fs::write(&list, "").unwrap();
    fs::remove_file(Path::new(&out).join("report.html")).unwrap();
    assert_eq!(run(&["solve", &faces, "--out", &out, "--restart"]).code, 0);
    assert_eq!(fs::read_to_string(&list).unwrap(), series);

    assert_eq!(run(&["solve", &nodes, "--out", &out, "--overwrite"]).code, 0);
    let left = files(Path::new(&out));
    assert!(!left.iter().any(|path| path.starts_with("points") || path.ends_with("points.pvd")), "{left:?}");
}
