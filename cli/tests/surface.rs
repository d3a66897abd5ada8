//! Runs `surface` on the shipped meshes, on others, and on what is no interface.

use crate::runs::{Run, Scratch, run, run_in, run_with_input};
use serde_json::Value;

/// A shipped mesh.
fn shipped(name: &str) -> String {
    format!("{}/../mesh/meshes/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// A flat master of 4 × 4 unit quadrilaterals and one slave quadrilateral of side 1.5 that faces it, 0.5 above to 0.25 below.
fn plane() -> String {
    let mut text = String::from("*NODE\n");
    let number = |i: usize, j: usize| 1 + i + 5 * j;
    for j in 0..=4 {
        for i in 0..=4 {
            text += &format!("{}, {i}, {j}, 0\n", number(i, j));
        }
    }
    text += "101, 1, 1, 0.5\n102, 2.5, 1, 0.5\n103, 2.5, 2.5, -0.25\n104, 1, 2.5, -0.25\n";
    text += "*ELEMENT, TYPE=S4, ELSET=MASTER\n";
    for j in 0..4 {
        for i in 0..4 {
            let corners = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            text += &format!("{}, {}\n", 1 + i + 4 * j, corners.map(|k| k.to_string()).join(", "));
        }
    }
    text + "*ELEMENT, TYPE=S4, ELSET=SLAVE\n201, 101, 104, 103, 102\n*NSET, NSET=NODES\n101, 102, 103, 104\n"
}

/// The summary of a run that ends well and writes its file.
fn summary(arguments: &[&str]) -> Value {
    let Run { code, stdout, stderr } = run(arguments);
    assert_eq!((code, stderr.as_str()), (0, ""));
    serde_json::from_str(&stdout).unwrap()
}

/// The numbers of one array of a VTU file with appended binary data.
fn array(path: &str, name: &str) -> Vec<f64> {
    let bytes = std::fs::read(path).unwrap();
    let start = b"<AppendedData encoding=\"raw\">";
    let data = bytes.windows(start.len()).position(|window| window == start).unwrap() + start.len();
    let data = data + bytes[data..].iter().position(|&byte| byte == b'_').unwrap() + 1;
    let head = String::from_utf8_lossy(&bytes[..data]).into_owned();
    let tag = head.split('<').find(|tag| tag.contains(&format!("Name=\"{name}\""))).unwrap();
    let value =
        |key: &str| tag.split(&format!("{key}=\"")).nth(1).unwrap().split('"').next().unwrap().to_owned();
    let offset: usize = value("offset").parse().unwrap();
    let payload = &bytes[data + offset..];
    let length = u64::from_le_bytes(payload[..8].try_into().unwrap()) as usize;
    let payload = &payload[8..8 + length];
    match value("type").as_str() {
        "Float64" => payload.chunks(8).map(|x| f64::from_le_bytes(x.try_into().unwrap())).collect(),
        "Int32" => payload.chunks(4).map(|x| f64::from(i32::from_le_bytes(x.try_into().unwrap()))).collect(),
        other => panic!("{other}"),
    }
}

/// A new reason of the library has a number, or stands here because this job cannot meet it.
#[test]
fn every_outcome_has_a_number() {
    const NEVER_MET: [&str; 14] = [
        "too-many-nodes",
        "no-fit-kernels",
        "no-friction-kernels",
        "no-kernels",
        "anisotropic-basis",
        "invalid-domain",
        "wrong-number-of-domains",
        "held-frame",
        "material-domains",
        "invalid-reach",
        "not-average-plane",
        "facet-corners",
        // Without a window, and not over faces.
        "beyond-window",
        "nothing-over",
    ];
    let mut codes = Vec::new();
    for source in
        [include_str!("../../runtime/src/error.rs"), include_str!("../../runtime/src/interface/outcome.rs")]
    {
        let arms = source.lines().filter_map(|line| line.split_once(" => \"")?.1.strip_suffix("\","));
        codes.extend(arms);
    }
    assert!(codes.contains(&"not-material-place") && codes.contains(&"too-far"), "{codes:?}");
    let help = run(&["surface", "--help"]).stdout;
    let numbered: Vec<&str> = help
        .lines()
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            words.next()?.parse::<u8>().ok()?;
            words.next()
        })
        .collect();
    for code in codes {
        let is_numbered = numbered.contains(&code);
        assert!(is_numbered != NEVER_MET.contains(&code), "{code}: {is_numbered}");
    }
    assert_eq!(numbered.last(), Some(&"other"));
}

#[test]
fn every_slave_of_the_cylinder_has_its_gap() {
    let scratch = Scratch::new("surface-cylinder");
    let output = scratch.path("out.vtu");
    for rule in ["hull-layers", "hull-radius", "nearest"] {
        let mesh = shipped("plate_on_cylinder.msh");
        let found = summary(&["surface", &mesh, "-o", &output, "--json", "--rule", rule]);
        assert_eq!((&found["slaves"], &found["contacts"]), (&425.into(), &425.into()));
        assert_eq!(found["without"], serde_json::json!({}));
        // The distances from the true cylinder go from -0.5228 to 6.6336; the mesh is coarse.
        assert!((found["smallest_gap"].as_f64().unwrap() + 0.5228).abs() < 2e-2, "{found}");
        assert!((found["largest_gap"].as_f64().unwrap() - 6.6336).abs() < 2e-2, "{found}");
        assert_eq!(found["element"]["rule"], rule);
    }
    let gaps = array(&output, "gap");
    let (normals, feet) = (array(&output, "normal"), array(&output, "foot"));
    assert_eq!((gaps.len(), normals.len(), feet.len()), (425, 3 * 425, 3 * 425));
    assert!(array(&output, "outcome").iter().all(|&outcome| outcome == 0.0));
    // The foot is where the gap says: x = foot + g ν.
    let points = array(&output, "Points");
    for (k, gap) in gaps.iter().enumerate() {
        for axis in 3 * k..3 * k + 3 {
            assert!((feet[axis] + gap * normals[axis] - points[axis]).abs() < 1e-9);
        }
    }
    assert_eq!(scratch.names(), ["out.vtu"]);
}

#[test]
fn both_formats_hold_the_same_interface() {
    let scratch = Scratch::new("surface-formats");
    let output = scratch.path("out.vtu");
    let read = |name: &str| {
        let mut found = summary(&["surface", &shipped(name), "-o", &output, "--json", "--threads", "1"]);
        // Times are left out of the comparison.
        let times = found.as_object_mut().unwrap().remove("times_s").unwrap();
        let names: Vec<&str> = times.as_object().unwrap().keys().map(String::as_str).collect();
        assert_eq!(names, ["connect", "evaluate", "read", "refresh", "write"]);
        found
    };
    assert_eq!(read("plate_on_cylinder.msh"), read("plate_on_cylinder.inp"));
    let torus = read("torus_patch.msh");
    assert_eq!(torus["slaves"], torus["contacts"], "{torus}");
}

/// A mesh in units a million times as long has gaps that fixed decimals would show as zero.
#[test]
fn gaps_and_areas_have_digits_in_any_unit() {
    let scratch = Scratch::new("surface-units");
    let shipped = std::fs::read_to_string(shipped("plate_on_cylinder.inp")).unwrap();
    let mut is_node = false;
    let scaled = shipped.lines().map(|line| {
        if line.starts_with('*') {
            is_node = line.to_uppercase().starts_with("*NODE");
        } else if is_node {
            let (tag, coordinates) = line.split_once(',').unwrap();
            let small = |x: &str| format!("{:e}", 1e-6 * x.trim().parse::<f64>().unwrap());
            return format!("{tag}, {}\n", coordinates.split(',').map(small).collect::<Vec<_>>().join(", "));
        }
        format!("{line}\n")
    });
    let mesh = scratch.file("small.inp", &scaled.collect::<String>());
    let told = run(&["surface", &mesh, "-o", &scratch.path("out.vtu")]).stdout;
    for label in ["gap ", "slave area "] {
        let row = told.lines().find(|line| line.starts_with(label)).unwrap();
        let number: f64 = row[label.len()..].split_whitespace().next().unwrap().parse().unwrap();
        assert!(number != 0.0 && row.contains("e-"), "{row}");
    }
}

#[test]
fn weights_and_frames_are_those_asked_for() {
    let scratch = Scratch::new("surface-options");
    let output = scratch.path("out.vtu");
    let mesh = shipped("torus_patch.msh");
    let smallest = |options: &[&str]| {
        let all = [&["surface", &mesh, "-o", &output, "--json"], options].concat();
        summary(&all)["smallest_gap"].as_f64().unwrap()
    };
    let cubic = smallest(&[]);
    assert_eq!(cubic, smallest(&["--weight", "cubic", "--frame-derivative", "co-moving"]));
    // Held or moving, the frame of hull layers is the same when the pairing has just been refreshed.
    let layers = ["--rule", "hull-layers"];
    let moving = smallest(&layers);
    assert_eq!(moving, smallest(&[&layers[..], &["--frame-derivative", "held"]].concat()));
    for (options, sentence) in [
        (&["--frame-derivative", "held"][..], "--frame-derivative held needs another --rule"),
        (&["--rule", "hull-layers", "--symmetry", "x"], "--symmetry needs --rule domains"),
    ] {
        let all = [&["surface", &mesh, "-o", &output], options].concat();
        run(&all).assert_refused(&[sentence]);
    }
    for weight in ["cubic-interpolating", "wendland-c2"] {
        let other = smallest(&["--weight", weight]);
        assert!(other != cubic && (other - cubic).abs() < 0.05, "{weight}: {other} {cubic}");
    }
}

#[test]
fn a_plane_is_met_exactly() {
    let scratch = Scratch::new("surface-plane");
    let mesh = scratch.file("plane.inp", &plane());
    let output = scratch.path("out.vtu");
    let found =
        summary(&["surface", &mesh, "--master", "MASTER", "--slave", "SLAVE", "-o", &output, "--json"]);
    assert_eq!((&found["contacts"], &found["penetrating"]), (&4.into(), &2.into()));
    assert!((found["smallest_gap"].as_f64().unwrap() + 0.25).abs() < 1e-13);
    assert!((found["largest_gap"].as_f64().unwrap() - 0.5).abs() < 1e-13);
    let area: f64 = array(&output, "area").iter().sum();
    assert!((area - 1.5 * (1.5_f64.powi(2) + 0.75_f64.powi(2)).sqrt()).abs() < 1e-12, "{area}");
    // A set of nodes has no areas.
    let Run { code, stdout, .. } = run(&["surface", &mesh, "--slave", "NODES", "-o", &output]);
    assert_eq!(code, 0);
    assert!(stdout.contains("4 of 4 slave nodes") && stdout.contains("area            none"), "{stdout}");
    assert!(!String::from_utf8_lossy(&std::fs::read(&output).unwrap()).contains("Name=\"area\""));
}

#[test]
fn a_slave_beyond_the_border_has_a_number() {
    let scratch = Scratch::new("surface-border");
    let mesh = scratch.file("plane.inp", &plane().replace("101, 1, 1,", "101, -0.3, 1,"));
    let output = scratch.path("out.vtu");
    let found = summary(&["surface", &mesh, "-o", &output, "--json"]);
    assert_eq!(found["without"], serde_json::json!({"beyond-border": 1}));
    assert_eq!(array(&output, "outcome"), [12.0, 0.0, 0.0, 0.0]);
    let gaps = array(&output, "gap");
    assert!(gaps[0].is_nan() && gaps[1..].iter().all(|gap| gap.is_finite()));
}

#[test]
fn bad_input_is_one_sentence_and_no_file() {
    let scratch = Scratch::new("surface-bad");
    let mesh = scratch.file("plane.inp", &plane());
    let flipped = scratch.file("flipped.inp", &plane().replace("6, 7, 8, 13, 12", "6, 7, 12, 13, 8"));
    let flat = scratch
        .file("flat.inp", &plane().replace("13, 2, 2, 0", "13, 1, 2, 0").replace("8, 2, 1, 0", "8, 1, 1, 0"));
    let third = "*ELEMENT, TYPE=S3, ELSET=MASTER\n99, 7, 8, 101\n";
    let branching = scratch.file("branching.inp", &(plane() + third));
    let before = scratch.names();
    let refused = |arguments: &[&str], parts: &[&str]| {
        let all = [&["surface"], arguments, &["-o", "out.vtu"]].concat();
        run_in(&scratch, &all).assert_refused(parts);
        assert_eq!(scratch.names(), before);
    };
    refused(&["none.msh"], &["none.msh"]);
    refused(&[&mesh, "--master", "drum"], &["plane.inp", "\"drum\""]);
    refused(&[&mesh, "--slave", "MASTER"], &["set \"MASTER\"", "node 1 ", "too"]);
    let at_the_edge = "facets 2 (nodes 2, 3, 8, 7) and 6 (nodes 7, 12, 13, 8) run through the edge from node 8 to node 7 in the \
                       same direction";
    refused(&[&flipped], &["flipped.inp", "set \"master\"", at_the_edge, "flipped"]);
    let at_three = "facets 2 (nodes 2, 3, 8, 7), 6 (nodes 7, 8, 13, 12) and 17 (nodes 7, 8, 101), and perhaps more, share the edge \
                    between the nodes 7 and 8";
    refused(&[&branching], &["branching.inp", "set \"master\"", at_three]);
    refused(&[&flat], &["flat.inp", "2, 3, 8, 7", "not convex at node 8"]);
    refused(&[&mesh, "--element", "node-to-facet", "--rule", "nearest"], &["--rule", "no meaning"]);
    refused(&[&mesh, "--feature-angle", "200"], &["'200'", "0 to 180"]);
    refused(&[&mesh, "--weight", "quartic"], &["'quartic'", "cubic-interpolating"]);
    refused(&[&mesh, "--threads", "0"], &["'0'", "from 1"]);
    run_in(&scratch, &["surface", &mesh]).assert_refused(&["--output"]);
    run_in(&scratch, &["surface", &mesh, "-o", &mesh]).assert_refused(&["input file"]);
    assert_eq!(scratch.names(), before);
}

#[test]
fn a_mesh_comes_from_standard_input_too() {
    let scratch = Scratch::new("surface-stdin");
    let mesh = concat!(env!("CARGO_MANIFEST_DIR"), "/../mesh/meshes/plate_on_cylinder.msh");
    let (named, piped) = (scratch.path("named.vtu"), scratch.path("piped.vtu"));
    assert_eq!(run(&["surface", mesh, "-o", &named]).code, 0);
    let text = std::fs::read_to_string(mesh).unwrap();
    let found = run_with_input(&["surface", "-", "-o", &piped], &text);
    assert!(found.code == 0 && found.stdout.contains("standard input"), "{found:?}");
    assert_eq!(std::fs::read(named).unwrap(), std::fs::read(piped).unwrap());
    run_with_input(&["surface", "-", "-o", &scratch.path("no.vtu")], "neither")
        .assert_refused(&["standard input"]);
}

/// A master that faces away from its slaves takes all of them for penetration, and every element is sound.
#[test]
fn a_master_that_faces_the_wrong_way_is_told() {
    let scratch = Scratch::new("surface-inside-out");
    let surface = |text: &str| {
        let mesh = scratch.file("plane.inp", text);
        let output = scratch.path("out.vtu");
        let sets = ["--master", "MASTER", "--slave", "SLAVE"];
        let json: Value = summary(&[&["surface", &mesh, "-o", &output, "--json"], &sets[..]].concat());
        (json["deep"].clone(), run(&[&["surface", &mesh, "-o", &output], &sets[..]].concat()).stdout)
    };
    let apart = plane().replace("-0.25\n", "0.25\n");
    let (deep, said) = surface(&apart);
    assert!(deep == 0 && !said.contains("warning"), "{said}");
    let turned: String = apart
        .lines()
        .map(|line| match line.split(", ").collect::<Vec<_>>()[..] {
            [tag, a, b, c, d] if tag.len() < 3 => format!("{tag}, {d}, {c}, {b}, {a}\n"),
            _ => format!("{line}\n"),
        })
        .collect();
    let (deep, said) = surface(&turned);
    assert!(deep == 4 && said.contains("does the master face the wrong way?"), "{deep} {said}");
    // Slaves without facets are compared with the master's.
    let (deep, said) =
        surface(&turned.replace("ELSET=SLAVE", "ELSET=OTHER").replace("NSET=NODES", "NSET=SLAVE"));
    assert!(deep == 4 && said.contains("does the master face the wrong way?"), "{deep} {said}");
}

#[test]
fn planes_of_symmetry_through_the_master_name_it() {
    let scratch = Scratch::new("surface-cut");
    let mesh = scratch.file("plane.inp", &plane().replace(", 0, 0\n", ", -1, 0\n"));
    let output = scratch.path("out.vtu");
    run(&["surface", &mesh, "-o", &output, "--master", "MASTER", "--slave", "SLAVE", "--symmetry", "y"])
        .assert_refused(&["set \"MASTER\"", "from y = -1 to 4", "plane of symmetry y = 0"]);
}

#[test]
fn names_of_other_kinds_of_files_are_refused() {
    let scratch = Scratch::new("surface-name");
    let mesh = scratch.file("plane.inp", &plane());
    for name in ["out.svg", "out.STL", "out.json", "out.vtk"] {
        let output = scratch.path(name);
        run(&["surface", &mesh, "-o", &output, "--master", "MASTER", "--slave", "SLAVE"])
            .assert_refused(&[name, "ends with .vtu"]);
        run(&["demo", "-o", &output]).assert_refused(&[name, "ends with .vtu"]);
    }
    assert_eq!(scratch.names(), ["plane.inp"]);
}

#[test]
fn corners_out_of_order_are_told_an_order() {
    let scratch = Scratch::new("surface-crossed");
    let crossed = plane().replace("1, 1, 2, 7, 6\n", "1, 1, 2, 6, 7\n");
    assert_ne!(crossed, plane());
    let mesh = scratch.file("plane.inp", &crossed);
    run(&["surface", &mesh, "-o", &scratch.path("out.vtu"), "--master", "MASTER", "--slave", "SLAVE"])
        .assert_refused(&["the facet with the nodes 1, 2, 6, 7 crosses itself", "1, 2, 7, 6"]);
}
