//! The VTU writer: what it writes is parsed back here, bit for bit, and what it must not write is refused.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use diffuse_contact_mesh::vtu::Attached;
use diffuse_contact_mesh::{ElementKind, Mesh, VtuError, VtuFile};

const POINTS: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, -0.0, 1e-300],
    [0.1, 1.0 / 3.0, f64::MIN_POSITIVE],
    [0.0, 1.0, f64::MAX],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];
const GAP: [f64; 8] = [0.1, -0.25, 1.0 / 3.0, 5e-324, -0.0, 1e22, 2.0 / 3.0, 123456789.0];
const STRESS: [[f64; 6]; 8] = [[1e-300, -2.5, 1.0 / 3.0, -0.0, 5e-324, f64::MAX]; 8];

fn grid() -> VtuFile<'static> {
    VtuFile::new()
        .points(&POINTS)
        .cell(ElementKind::Point1, &[3])
        .cell(ElementKind::Line2, &[0, 1])
        .cell(ElementKind::Triangle3, &[0, 1, 2])
        .cell(ElementKind::Quadrilateral4, &[0, 1, 2, 3])
        .cell(ElementKind::Hexahedron8, &[0, 1, 2, 3, 4, 5, 6, 7])
        .point_scalars("gap <\"g\"> & 'more'", &GAP)
        .point_vectors("force", POINTS.to_vec())
        .point_tensors("stress", &STRESS)
        .cell_i32("status", &[i32::MIN, i32::MAX, 0, 1, -1])
}

fn written(grid: &VtuFile) -> Vec<u8> {
    let mut bytes = Vec::new();
    grid.write_to(&mut bytes).unwrap();
    bytes
}

/// An array as the file describes it: type, number of components, and each number's bits.
#[derive(Debug, PartialEq)]
struct Parsed {
    kind: String,
    components: usize,
    bits: Vec<u64>,
}

fn reals(values: &[f64], components: usize) -> Parsed {
    Parsed { kind: "Float64".into(), components, bits: values.iter().map(|x| x.to_bits()).collect() }
}

fn integers(kind: &str, values: &[i64]) -> Parsed {
    Parsed { kind: kind.into(), components: 1, bits: values.iter().map(|&i| i as u64).collect() }
}

fn attribute<'t>(tag: &'t str, name: &str) -> Option<&'t str> {
    let rest = tag.split_once(&format!(" {name}=\""))?.1;
    rest.split_once('"').map(|(value, _)| value)
}

/// Every array of a file by section and name.
fn parse(bytes: &[u8]) -> HashMap<(String, String), Parsed> {
    let marker = b"<AppendedData encoding=\"raw\">\n_";
    let begin = bytes.windows(marker.len()).position(|window| window == marker).unwrap();
    let text = std::str::from_utf8(&bytes[..begin]).unwrap();
    let appended = &bytes[begin + marker.len()..];
    let mut arrays = HashMap::new();
    let mut section = "";
    for line in text.lines() {
        if !line.starts_with("<DataArray") {
            section = line.trim_matches(['<', '>']);
            continue;
        }
        let kind = attribute(line, "type").unwrap();
        let offset: usize = attribute(line, "offset").unwrap().parse().unwrap();
        let (head, data) = appended[offset..].split_at(8);
        let data = &data[..u64::from_le_bytes(head.try_into().unwrap()) as usize];
        let bits = match kind {
            "UInt8" => data.iter().map(|&byte| byte.into()).collect(),
            "Int32" => data
                .chunks(4)
                .map(|chunk| i64::from(i32::from_le_bytes(chunk.try_into().unwrap())) as u64)
                .collect(),
            _ => data.chunks(8).map(|chunk| u64::from_le_bytes(chunk.try_into().unwrap())).collect(),
        };
        let components = attribute(line, "NumberOfComponents").map_or(1, |count| count.parse().unwrap());
        let name = attribute(line, "Name").unwrap();
        let parsed = Parsed { kind: kind.into(), components, bits };
        assert!(arrays.insert((section.to_string(), name.to_string()), parsed).is_none());
    }
    arrays
}

#[test]
fn every_bit_is_kept() {
    let bytes = written(&grid());
    let arrays = parse(&bytes);
    let array = |section: &str, name: &str| &arrays[&(section.to_string(), name.to_string())];
    assert_eq!(*array("Points", "Points"), reals(POINTS.as_flattened(), 3));
    assert_eq!(*array("PointData", "gap &lt;&quot;g&quot;&gt; &amp; &apos;more&apos;"), reals(&GAP, 1));
    assert_eq!(*array("PointData", "force"), reals(POINTS.as_flattened(), 3));
    // xx, yy, zz, xy, yz, xz, as ParaView reads six components.
    assert_eq!(*array("PointData", "stress"), reals(STRESS.as_flattened(), 6));
    assert_eq!(
        *array("CellData", "status"),
        integers("Int32", &[i32::MIN.into(), i32::MAX.into(), 0, 1, -1])
    );
    assert_eq!(
        *array("Cells", "connectivity"),
        integers("Int64", &[3, 0, 1, 0, 1, 2, 0, 1, 2, 3, 0, 1, 2, 3, 4, 5, 6, 7])
    );
    assert_eq!(*array("Cells", "offsets"), integers("Int64", &[1, 3, 6, 10, 18]));
    assert_eq!(*array("Cells", "types"), integers("UInt8", &[1, 3, 5, 9, 12]));
    assert_eq!(arrays.len(), 8);
}

#[test]
fn the_header_tells_sizes_and_byte_order() {
    let bytes = written(&grid());
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.contains("byte_order=\"LittleEndian\" header_type=\"UInt64\""));
    assert!(text.contains("<Piece NumberOfPoints=\"8\" NumberOfCells=\"5\">"));
    assert!(text.contains("</Piece>\n</UnstructuredGrid>\n<AppendedData"));
}

/// With the attribute some readers make n × 1 numbers of n.
#[test]
fn arrays_of_scalars_name_no_number_of_components() {
    let bytes = written(&grid());
    let text = String::from_utf8_lossy(&bytes);
    let arrays = text.lines().filter(|line| line.starts_with("<DataArray"));
    let named = arrays.filter(|line| line.contains("NumberOfComponents"));
    let names: Vec<&str> = named.map(|line| attribute(line, "Name").unwrap()).collect();
    assert_eq!(names, ["force", "stress", "Points"]);
}

#[test]
fn binary_arrays_fill_the_file_without_gaps() {
    let bytes = written(&grid());
    assert!(bytes.ends_with(b"\n</AppendedData>\n</VTKFile>\n"));
    let nan = written(&VtuFile::new().points(&[[0.0; 3]]).point_scalars("gap", &[f64::NAN]));
    let arrays = parse(&nan);
    assert!(f64::from_bits(arrays[&("PointData".to_string(), "gap".to_string())].bits[0]).is_nan());
}

#[test]
fn a_mesh_is_written_with_all_its_cells() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/block_ascii.msh");
    let mesh = Mesh::read(path).unwrap();
    let arrays = parse(&written(&VtuFile::new().points(mesh.nodes()).cells(mesh.elements())));
    let array = |section: &str, name: &str| &arrays[&(section.to_string(), name.to_string())];
    assert_eq!(*array("Cells", "types"), integers("UInt8", &[1, 3, 9, 9, 9, 9, 12, 12]));
    assert_eq!(*array("Points", "Points"), reals(mesh.nodes().as_flattened(), 3));
    let top = parse(&written(&VtuFile::new().points(mesh.nodes()).cells(mesh.facets("top").unwrap())));
    assert_eq!(
        top[&("Cells".to_string(), "connectivity".to_string())],
        integers("Int64", &[0, 9, 11, 2, 9, 4, 6, 11])
    );
}

/// The first triangle of VTK_WEDGE looks away from the other one, that of VTK_QUADRATIC_WEDGE towards it.
#[test]
fn wedges_are_not_inside_out() {
    let nodes: Vec<usize> = (1..16).collect();
    let grid = VtuFile::new()
        .points(vec![[0.0; 3]; 16])
        .cell(ElementKind::Point1, &[0])
        .cell(ElementKind::Wedge6, &nodes[..6])
        .cell(ElementKind::Wedge15, &nodes);
    let arrays = parse(&written(&grid));
    let array = |name: &str| &arrays[&("Cells".to_string(), name.to_string())];
    assert_eq!(
        *array("connectivity"),
        integers("Int64", &[0, 1, 3, 2, 4, 6, 5, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15])
    );
    assert_eq!(*array("types"), integers("UInt8", &[1, 13, 26]));
}

#[test]
fn what_does_not_fit_is_refused() {
    let error = |grid: VtuFile| grid.write_to(&mut Vec::new()).unwrap_err();
    let three = || VtuFile::new().points(vec![[0.0; 3]; 3]);
    let mismatch = error(three().point_scalars("gap", &[1.0]));
    assert_eq!(mismatch.to_string(), "\"gap\" has 1 values for 3 points");
    let mismatch = error(three().point_tensors("stress", vec![[0.0; 6]; 4]));
    assert_eq!(mismatch.to_string(), "\"stress\" has 4 values for 3 points");
    assert!(matches!(
        error(three().cell(ElementKind::Point1, &[0]).cell_i32("status", &[1; 2])),
        VtuError::LengthMismatch { attached: Attached::Cells, expected: 1, found: 2, .. }
    ));
    assert_eq!(
        error(three().cell(ElementKind::Triangle3, &[0, 1])).to_string(),
        "cell 0, a triangle, has 2 nodes in place of 3"
    );
    assert_eq!(
        error(three().cell(ElementKind::Point1, &[0]).cell(ElementKind::Line2, &[0, 3])).to_string(),
        "cell 1 refers to point 3, but there are only 3 points"
    );
    assert!(matches!(
        error(three().point_scalars("a", &[0.0; 3]).point_i32("a", &[0; 3])),
        VtuError::DuplicateName { attached: Attached::Points, .. }
    ));
    assert!(matches!(error(three().point_i32("a\nb", &[0; 3])), VtuError::InvalidName { .. }));
    assert!(matches!(error(three().point_i32("", &[0; 3])), VtuError::InvalidName { .. }));
    assert!(matches!(
        error(VtuFile::new().points(&[[0.0; 3], [0.0, f64::NAN, 0.0]])),
        VtuError::NonFinitePoint { point: 1 }
    ));
}

/// An empty directory of its own for a test.
fn directory(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn names_in(directory: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(directory).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn files_are_replaced_whole_and_nothing_else_is_left() {
    let directory = directory("vtu_whole");
    let path = directory.join("grid.vtu");
    std::fs::write(&path, "old").unwrap();
    grid().write(&path).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), written(&grid()));
    let failed = grid().point_scalars("short", &[1.0]).write(&path);
    assert!(matches!(failed, Err(VtuError::LengthMismatch { .. })));
    assert_eq!(std::fs::read(&path).unwrap(), written(&grid()));
    assert_eq!(names_in(&directory), ["grid.vtu"]);
}

#[test]
fn a_failed_rename_leaves_nothing_behind() {
    let directory = directory("vtu_failed");
    let occupied = directory.join("grid.vtu");
    std::fs::create_dir_all(occupied.join("inside")).unwrap();
    let error = grid().write(&occupied).unwrap_err();
    assert!(matches!(error, VtuError::Write { .. }));
    assert!(error.to_string().contains("grid.vtu: cannot write the file"), "{error}");
    assert_eq!(names_in(&directory), ["grid.vtu"]);
    assert!(matches!(grid().write(directory.join("absent/grid.vtu")), Err(VtuError::Write { .. })));
    assert!(matches!(grid().write(".."), Err(VtuError::Write { .. })));
}
