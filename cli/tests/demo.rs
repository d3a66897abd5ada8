//! Runs the program's main job on the shipped mesh, on others, and on what is no mesh.

use crate::runs::{Run, Scratch, run, run_in};

/// The number after `from` in the row of the table that begins with `label`.
fn number_in(table: &str, label: &str, from: &str) -> f64 {
    let row = table.lines().find(|line| line.starts_with(label)).unwrap();
    let (_, rest) = row.split_once(from).unwrap();
    let number = rest.trim_start().split([' ', ',']).next().unwrap();
    number.parse().unwrap()
}

/// A flat master of `n` × `n` unit quadrilaterals and two slave nodes 0.5 above, −0.25 below it, as Abaqus text.
fn plane(n: usize) -> String {
    let mut text = String::from("*NODE\n");
    let number = |i: usize, j: usize| 1 + i + (n + 1) * j;
    for j in 0..=n {
        for i in 0..=n {
            text += &format!("{}, {i}, {j}, 0\n", number(i, j));
        }
    }
    let slave = number(n, n) + 1;
    text += &format!("{slave}, 2.2, 1.9, 0.5\n{}, 1.7, 2.1, -0.25\n", slave + 1);
    text += "*ELEMENT, TYPE=S4, ELSET=MASTER\n";
    for j in 0..n {
        for i in 0..n {
            let corners = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            text += &format!("{}, {}\n", 1 + i + n * j, corners.map(|k| k.to_string()).join(", "));
        }
    }
    text + &format!("*NSET, NSET=SLAVE\n{slave}, {}\n", slave + 1)
}

#[test]
fn the_main_job_finds_the_cylinder() {
    let scratch = Scratch::new("main-job");
    let Run { code, stdout, stderr } = run_in(&scratch, &[]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    assert!(stdout.contains("frame co-moving"), "{stdout}");
    assert!(stdout.contains("contact               425 of 425 slave nodes"), "{stdout}");
    // The distances of the slave nodes from the true cylinder, radius 100, go from -0.5228 to 6.6336.
    assert!((number_in(&stdout, "gap", " ") + 0.5228).abs() < 5e-3, "{stdout}");
    assert!((number_in(&stdout, "gap", " to ") - 6.6336).abs() < 5e-3, "{stdout}");
    assert_eq!(number_in(&stdout, "penetrating", " "), 70.0);
    let bytes = std::fs::read(scratch.path("diffuse-contact.vtu")).unwrap();
    assert!(bytes.starts_with(b"<?xml"));
    assert!(bytes.ends_with(b"</VTKFile>\n"));
    let picture = std::fs::read_to_string(scratch.path("diffuse-contact.svg")).unwrap();
    assert!(picture.starts_with("<svg ") && picture.ends_with("</svg>\n"));
    // All of it is seen in a narrow window.
    assert!(picture.lines().next().is_some_and(|line| line.contains("max-width:100%")), "{picture:.200}");
    // 36 pieces of each facet, and the slave facets.
    assert!(picture.matches("<path color=").count() > 8000 && !picture.contains("NaN"));
    assert_eq!(scratch.names(), ["diffuse-contact.svg", "diffuse-contact.vtu"]);
}

#[test]
fn one_slave_node_has_a_place_in_the_picture() {
    let scratch = Scratch::new("one-slave");
    let text = plane(4);
    let (text, _) = text.split_once("*NSET").unwrap();
    let mesh = scratch.file("one.inp", &format!("{text}*NSET, NSET=SLAVE\n26\n"));
    let sets = ["--master", "MASTER", "--slave", "SLAVE"];
    let Run { code, stderr, .. } = run_in(&scratch, &[&["demo", "--mesh", &mesh], &sets[..]].concat());
    assert_eq!((code, stderr.as_str()), (0, ""));
    let picture = std::fs::read_to_string(scratch.path("diffuse-contact.svg")).unwrap();
    assert!(!picture.contains("NaN") && !picture.contains("inf"), "{picture}");
}

#[test]
fn the_picture_does_not_replace_the_output() {
    let scratch = Scratch::new("one-target");
    for picture in ["both.vtu", "./both.vtu"] {
        run_in(&scratch, &["demo", "-o", "both.vtu", "--picture", picture])
            .assert_refused(&[picture, "is to hold two results"]);
    }
    assert!(scratch.names().is_empty());
}

#[test]
fn a_plane_is_met_exactly() {
    let scratch = Scratch::new("plane");
    let mesh = scratch.file("plane.inp", &plane(4));
    let output = scratch.path("plane.vtu");
    let Run { code, stdout, stderr } = run(&["demo", "--mesh", &mesh, "-o", &output]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    assert_eq!(number_in(&stdout, "gap", " "), -0.25);
    assert_eq!(number_in(&stdout, "gap", " to "), 0.5);
    assert_eq!(number_in(&stdout, "penetrating", " "), 1.0);
    assert!(stdout.contains("16 facets, 25 nodes"), "{stdout}");
    assert!(std::path::Path::new(&output).exists());
}

#[test]
fn nodes_that_do_not_face_the_master_are_told_apart() {
    let scratch = Scratch::new("border");
    let mesh = scratch.file("plane.inp", &plane(4).replace("2.2, 1.9, 0.5", "4.8, 1.9, 0.5"));
    let Run { code, stdout, .. } = run_in(&scratch, &["demo", "--mesh", &mesh]);
    assert_eq!(code, 0);
    assert!(stdout.contains("contact               1 of 2 slave nodes"), "{stdout}");
    assert!(stdout.contains("1 with outcome 12, beyond-border"), "{stdout}");
    assert_eq!(number_in(&stdout, "gap", " to "), -0.25);
}

#[test]
fn slaves_beside_a_narrow_master_are_reported_node_by_node() {
    let scratch = Scratch::new("strip");
    // Nine nodes, three of them in each of three rows: keep the first row of quadrilaterals only.
    let text: String = plane(2)
        .lines()
        .filter(|line| !line.starts_with("3, 4, 5, ") && !line.starts_with("4, 5, 6, "))
        .map(|line| format!("{line}\n"))
        .collect();
    let mesh = scratch.file("strip.inp", &text);
    let Run { code, stdout, .. } = run_in(&scratch, &["demo", "--mesh", &mesh]);
    assert_eq!(code, 0);
    assert!(stdout.contains("contact               0 of 2 slave nodes"), "{stdout}");
    assert!(stdout.contains("with outcome 12, beyond-border"), "{stdout}");
    assert!(stdout.contains("gap                   none"), "{stdout}");
}

#[test]
fn bad_input_is_one_sentence_and_no_file() {
    let scratch = Scratch::new("bad-mesh");
    let mesh = scratch.file("plane.inp", &plane(4));
    let text = scratch.file("text.msh", "this is no mesh\n");
    let unknown = scratch.file("unknown.dat", "this is no mesh\n");
    let infinite = scratch.file("infinite.inp", &plane(4).replace("2.2, 1.9, 0.5", "2.2, nan, 0.5"));
    let before = scratch.names();
    let refused = |arguments: &[&str], parts: &[&str]| {
        run_in(&scratch, arguments).assert_refused(parts);
        assert_eq!(scratch.names(), before);
    };
    refused(&["demo", "--mesh", "none.msh"], &["none.msh"]);
    refused(&["demo", "--mesh", "."], &["."]);
    refused(&["demo", "--mesh", &text], &["text.msh, line 1"]);
    refused(&["demo", "--mesh", &unknown], &["unknown.dat"]);
    refused(&["demo", "--mesh", &infinite], &["infinite.inp, line 27", "not a finite number"]);
    refused(&["demo", "--mesh", &mesh, "--slave", "plate"], &["plane.inp", "\"plate\"", "MASTER", "SLAVE"]);
    refused(&["demo", "--mesh", &mesh, "--master", "SLAVE"], &["plane.inp", "\"SLAVE\"", "2 nodes"]);
    refused(&["demo", "--master", "cylinder"], &["plate_on_cylinder.msh", "\"cylinder\"", "\"master\""]);
    refused(&["demo", "-o", "none/out.vtu"], &["none/out.vtu", "there is no directory none"]);
    refused(&["demo", "-o", "."], &["it is a directory"]);
}
