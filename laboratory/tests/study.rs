//! Runs the studies and looks at what they find.

use crate::runs::{Run, Scratch, run, run_in};
use serde_json::Value;

/// What is said on standard error besides how far a study is, which a log is told every ten seconds.
fn without_progress(stderr: &str) -> String {
    let is_progress = |line: &str| {
        let numbers = line.split_once(": ").and_then(|(_, numbers)| numbers.split_once(" of "));
        numbers.is_some_and(|(done, all)| done.parse::<usize>().is_ok() && all.parse::<usize>().is_ok())
    };
    stderr.lines().filter(|line| !is_progress(line)).collect()
}

fn json(arguments: &[&str]) -> Value {
    let Run { code, stdout, stderr } = run(arguments);
    assert_eq!((code, without_progress(&stderr).as_str()), (0, ""));
    serde_json::from_str(&stdout).unwrap()
}

/// One number of `study accuracy --json`.
fn error(all: &Value, shape: &str, degrees: f64, element: &str, what: &str) -> f64 {
    let mut found = all["patches"].as_array().unwrap().iter().filter(|found| {
        found["shape"] == shape && found["cell_degrees"] == degrees && found["element"] == element
    });
    found.next().unwrap()[what].as_f64().unwrap()
}

#[test]
fn errors_fall_at_their_orders() {
    let all = json(&["study", "accuracy", "--json"]);
    assert_eq!(all["patches"].as_array().unwrap().len(), 3 * 5 * 4);
    bodies_are_no_worse_than_with_facets(&all["bodies"]);
    let order = |shape: &str, element: &str, what: &str| {
        let [coarse, fine] = [10.0, 5.0].map(|size| error(&all, shape, size, element, what));
        (coarse / fine).log2()
    };
    for shape in ["cylinder", "sphere", "torus"] {
        assert!((order(shape, "facets", "gap_max") - 2.0).abs() < 0.15, "{shape}");
        assert!((order(shape, "facets", "normal_max_degrees") - 1.0).abs() < 0.15, "{shape}");
        for weight in ["cubic", "cubic-interpolating", "wendland-c2"] {
            // A quadratic fit: third order at least, fourth where the mesh is nearly symmetric; its slope one less.
            assert!(order(shape, weight, "gap_max") > 2.9, "{shape}, {weight}");
            assert!(order(shape, weight, "normal_max_degrees") > 1.9, "{shape}, {weight}");
        }
    }
    // The sagitta of a facet, in closed form.
    for degrees in [22.5_f64, 10.0] {
        let sagitta = 100.0 * (1.0 - (0.5 * degrees).to_radians().cos());
        assert!((error(&all, "cylinder", degrees, "facets", "gap_max") - sagitta).abs() < 1e-9);
    }
    // The figures of the manual.
    for (degrees, element, largest, mean) in [
        (22.5, "cubic", 0.179, 0.0717),
        (22.5, "cubic-interpolating", 0.179, 0.0642),
        (22.5, "facets", 1.92, 1.28),
        (10.0, "cubic", 0.00661, 0.00237),
        (10.0, "cubic-interpolating", 0.00661, 0.00227),
        (10.0, "facets", 0.381, 0.253),
    ] {
        for (what, expected) in [("gap_max", largest), ("gap_mean", mean)] {
            let found = error(&all, "cylinder", degrees, element, what);
            assert!((found / expected - 1.0).abs() < 0.02, "{degrees}°, {element}, {what}: {found}");
        }
    }
}

/// Beside sharp edges, on rims of one row of cells and in small holes, too.
fn bodies_are_no_worse_than_with_facets(all: &Value) {
    let all = all.as_array().unwrap();
    assert!(all.len() > 100, "{}", all.len());
    let gap = |found: &Value| found["gap_max"].as_f64().unwrap();
    let of = |element: &'static str| all.iter().filter(move |found| found["element"] == element);
    for (facets, smooth) in of("facets").zip(of("smooth")) {
        assert_eq!(["body", "face", "triangles"].map(|what| facets[what] == smooth[what]), [true; 3]);
        // The edges of the hole across are too short for what its cells drop around it: the basis is linear there.
        let is_narrow = facets["body"] == "hole of 12 cells" && facets["face"] == "outside";
        let most = if is_narrow { 1.002 } else { 0.7 };
        assert!(gap(smooth) < most * gap(facets) + 1e-12, "{facets} {smooth}");
    }
    let smooth = |body: &str, face: &str| {
        let found = of("smooth").find(|found| found["body"] == body && found["face"] == face).unwrap();
        gap(found)
    };
    assert!(smooth("disc with a small hole", "inside") < 0.004);
    assert!(smooth("tube of 16 cells", "inside") < 0.01);
    assert!(smooth("ring of 24 cells", "inside") < 0.005);
    // One row of cells.
    assert!(smooth("ring of 12 cells", "inside") < 0.015);
    assert!(smooth("hole of 12 cells", "inside") < 0.012);
}

#[test]
fn tables_are_markdown() {
    let Run { code, stdout, .. } = run(&["study", "accuracy"]);
    assert_eq!(code, 0);
    assert!(stdout.contains("| cell | facets | cubic | cubic-interpolating | wendland-c2 |"), "{stdout}");
    assert!(stdout.contains("| 10° | facets | 0.381 | 0.381 |"), "{stdout}");
    // Element, reference, largest, mean, then the error at three places of the cell, of which the first is (0.2, 0.5).
    for (start, expected) in [
        ("| 22.5° | cubic | 0.441 |", 0.0198),
        ("| 22.5° | cubic-interpolating | 0.112 |", 0.0198),
        ("| 22.5° | facets | 1.92 |", 1.23),
        ("| 10° | cubic | 0.0176 |", 0.000848),
        ("| 10° | cubic-interpolating | 0.0055 |", 0.000848),
        ("| 10° | facets | 0.381 |", 0.243),
    ] {
        let row = stdout.lines().find_map(|line| line.strip_prefix(start)).unwrap();
        let found: f64 = row.split('|').nth(2).unwrap().trim().parse().unwrap();
        assert!((found / expected - 1.0).abs() < 0.02, "{start} {found}");
    }
}

#[test]
fn domains_carry_fits_on_meshes_of_all_kinds() {
    let found = json(&["study", "domains", "--slaves", "500", "--json"]);
    let rows = found.as_array().unwrap();
    assert_eq!(rows.len(), 8 * 3);
    let mean = |row: &Value| row["masters_mean"].as_f64().unwrap();
    for row in rows {
        assert_eq!((&row["slaves"], &row["linear"]), (&500.into(), &0.into()), "{row}");
        assert!(row["singular_value"].as_f64().unwrap() > 0.1, "{row}");
        assert!(row["error_over_facets"].as_f64().unwrap() < 0.6, "{row}");
        assert!(row["masters_max"].as_u64().unwrap() < 36 && mean(row) < 20.0, "{row}");
    }
    // Long cells take no more masters than square ones.
    let of = |mesh: &str| rows.iter().find(|row| row["mesh"] == mesh && row["weight"] == "cubic").unwrap();
    assert!(mean(of("cells 10:1")) < 1.02 * mean(of("regular, 12 × 12")));
    assert!(mean(of("regular, 12 × 12")) < 13.0);
}

/// A larger bound keeps errors of the heights smaller, and takes the quadratic basis from slaves at the border. The default takes it from none.
#[test]
fn the_default_bounds_errors_and_gives_up_no_quadratic_fit() {
    let found = json(&["study", "regularity", "--meshes", "1", "--json"]);
    let rows = found.as_array().unwrap();
    assert_eq!(rows.len(), 5 * 4);
    let enlarged = |row: &Value| row["enlarged_by"][1].as_f64().unwrap();
    let mut largest = [0.0_f64; 2];
    for kind in rows.chunks(4) {
        let [default, more, _, much_more] = kind else { unreachable!("four bounds") };
        assert_eq!((&default["bound"], &default["linear_percent"]), (&0.01.into(), &vec![0.0, 0.0].into()));
        assert!(enlarged(default) < 7.0, "{default}");
        assert!(much_more["linear_percent"][1].as_f64().unwrap() > 0.0, "{much_more}");
        largest = [largest[0].max(enlarged(default)), largest[1].max(enlarged(more))];
    }
    assert!(largest[0] > 1.2 * largest[1], "{largest:?}");
}

#[test]
fn a_sweep_leaves_its_files() {
    let scratch = Scratch::new("sweep");
    let (picture, csv) = (scratch.path("sweep.svg"), scratch.path("sweep.csv"));
    let Run { code, stdout, stderr } =
        run(&["study", "sweep", "-o", &picture, "--csv", &csv, "--steps", "100", "--moved", "0.2"]);
    assert_eq!((code, without_progress(&stderr).as_str()), (0, ""));
    assert!(stdout.contains("cells of side 1/1, nodes moved by 20 %, a loop of 100 steps"), "{stdout}");
    // Facets, and five rules with three weights.
    let cases = 1 + 5 * 3;
    assert_eq!(stdout.lines().filter(|line| line.contains('°')).count(), cases, "{stdout}");
    let picture = std::fs::read_to_string(&picture).unwrap();
    assert!(picture.starts_with("<svg") && picture.trim_end().ends_with("</svg>"));
    // Four curves in both panels, and in their legends.
    for colour in ["#D55E00", "#56B4E9", "#E69F00", "#0072B2"] {
        assert_eq!(picture.matches(colour).count(), 4, "{colour}");
    }
    let csv = std::fs::read_to_string(&csv).unwrap();
    assert_eq!(csv.lines().count(), 1 + 100 * cases);
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().all(|line| line.split(',').count() == columns));
    run_in(&scratch, &["study", "sweep", "-o", "none/sweep.svg"])
        .assert_refused(&["there is no directory none"]);
    run(&["study", "sweep", "--steps", "5"]).assert_refused(&["'5'", "100"]);
    run(&["study", "sweep", "--moved", "0.4"]).assert_refused(&["'0.4'", "between 0 and 0.35"]);
}

#[test]
fn a_large_interface_is_timed() {
    let found = json(&["study", "throughput", "--nodes", "900", "--threads", "2", "--assembly", "--json"]);
    assert_eq!(
        (&found["nodes"], &found["contacts"], &found["threads"]),
        (&900.into(), &900.into(), &2.into())
    );
    for time in ["connect_s", "domains_s", "refresh_s", "refresh_kept_s", "evaluate_s"] {
        assert!(found[time].as_f64().unwrap() > 0.0, "{time}");
    }
    assert!(found["masters"].as_f64().unwrap() > 6.0);
    run(&["study", "throughput", "--nodes", "3"]).assert_refused(&["'3'", "64"]);
}

#[test]
fn windows_of_a_large_interface_have_the_bits_of_the_whole() {
    let found = json(&["study", "throughput", "--nodes", "2500", "--windows", "6", "--json"]);
    for (what, expected) in [("contacts", 2500), ("windows", 6), ("different", 0), ("beyond_window", 0)] {
        assert_eq!(found[what], expected, "{what}");
    }
    let sizes = |what: &str| ["sum", "largest"].map(|size| found[what][size].as_u64().unwrap());
    let ([nodes, most], [halo, _]) = (sizes("window_nodes"), sizes("halo_nodes"));
    // A node more than once for each that another window holds, too.
    assert!(0 < halo && halo < nodes && 2500 + halo / 2 <= nodes + 2500 / 5 && most < 2500, "{found}");
    for times in ["whole", "parts"] {
        assert!(found[times]["refresh_s"].as_f64().unwrap() > 0.0, "{times}");
    }
    let both = ["study", "throughput", "--nodes", "100", "--windows", "2", "--assembly"];
    run(&both).assert_refused(&["--windows", "--assembly"]);
}

#[test]
fn the_examples_of_the_paper_are_run() {
    let scratch = Scratch::new("paper");
    std::fs::create_dir_all(scratch.path("docs")).unwrap();
    let Run { code, stdout, stderr } =
        run_in(&scratch, &["study", "paper", "--quick", "-o", "docs/paper.md", "--decks", "decks"]);
    assert_eq!((code, stdout.as_str(), without_progress(&stderr).as_str()), (0, "", ""));
    let document = std::fs::read_to_string(scratch.path("docs/paper.md")).unwrap();
    // Facets let nodes in more than a hundred times deeper than the fit.
    let deepest = |element: &str| -> f64 {
        let start = format!("| {element} | 0.");
        let row = document.lines().find(|line| line.starts_with(&start)).unwrap();
        row.split('|').nth(2).unwrap().trim().parse().unwrap()
    };
    let (facets, fit) = (deepest("facets"), deepest("diffuse, cubic weight"));
    assert!(facets > 100.0 * fit, "{facets} {fit}");
    // Every picture that is shown is there.
    let links = document.split("](").skip(1).map(|rest| rest.split(')').next().unwrap());
    let pictures: Vec<&str> = links.filter(|link| link.starts_with("pictures/")).collect();
    assert!(pictures.len() >= 4, "{pictures:?}");
    for picture in &pictures {
        let svg = std::fs::read_to_string(scratch.path(&format!("docs/{picture}"))).unwrap();
        assert!(svg.starts_with("<svg") && !svg.contains("NaN"), "{picture}");
    }
    assert!(!document.split_whitespace().any(|word| ["NaN", "inf", "-inf"].contains(&word)));
    // The pictures alone are the same ones.
    let arguments = ["study", "paper", "--quick", "--pictures", "figures"];
    let Run { code, stdout, stderr } = run_in(&scratch, &arguments);
    assert_eq!((code, stdout.as_str(), without_progress(&stderr).as_str()), (0, "", ""));
    for picture in pictures {
        let name = picture.trim_start_matches("pictures/");
        let [alone, other] = [format!("figures/{name}"), format!("docs/{picture}")]
            .map(|path| std::fs::read_to_string(scratch.path(&path)).unwrap());
        assert_eq!(alone, other, "{name}");
    }
    // The decks are ones that `solve` takes.
    let deck = scratch.path("decks/pipe_pinch-coarse-2e6-pipe-facets.toml");
    assert!(std::fs::read_to_string(&deck).unwrap().contains("node-to-facet"));
    run_in(&scratch, &["study", "paper", "--quick", "-o", "none/paper.md"])
        .assert_refused(&["there is no directory none"]);
}

#[test]
fn scaling_is_counted() {
    let arguments = ["study", "scaling", "--facets", "250000", "--ranks", "1,64,1000"];
    let found = json(&[&arguments[..], &["--json"]].concat());
    let cases = found["cases"].as_array().unwrap();
    // Three partitions of two kinds of slaves; a strip of less than one facet is none.
    assert_eq!((cases.len(), &found["facets"], &found["slaves"]), (16, &250_000.into(), &62_500.into()));
    let of = |case: &Value, what: &str, which: &str| case[what][which].as_f64().unwrap();
    for case in cases {
        let ranks = case["ranks"].as_f64().unwrap();
        assert!((of(case, "facets", "mean") * ranks - 250_000.0).abs() < 1e-6);
        let share = case["bytes_over_share"].as_f64().unwrap();
        let efficiency = case["efficiency"][0].as_f64().unwrap();
        if ranks == 1.0 {
            assert_eq!((share, efficiency, of(case, "window_bytes", "max")), (1.0, 1.0, 0.0));
            continue;
        }
        assert!(share > 1.0 && (0.0..1.0).contains(&efficiency), "{case}");
        let balance = of(case, "slaves", "max") / of(case, "slaves", "mean");
        let is_dealt = case["dealt"].as_bool().unwrap();
        assert!(if is_dealt { balance < 1.02 } else { balance > 1.5 }, "{case}");
    }
    // Parts of 500 × 500 facets, nine more than the own ones all around: a block of 63 × 63, a strip of 8.
    let part = |partition: &str| {
        let of_64 = |case: &&Value| case["partition"] == partition && case["ranks"] == 64;
        of(cases.iter().find(of_64).unwrap(), "part_facets", "max")
    };
    assert_eq!([part("blocks"), part("strips")], [81.0 * 81.0, 26.0 * 500.0]);

    let scratch = Scratch::new("scaling");
    let Run { code, stdout, stderr } = run_in(&scratch, &[&arguments[..], &["-o", "scaling.md"]].concat());
    assert_eq!((code, stdout.as_str(), stderr.as_str()), (0, "", ""));
    let document = std::fs::read_to_string(scratch.path("scaling.md")).unwrap();
    let rows = document.lines().filter(|line| line.starts_with("| blocks, dealt out |")).count();
    assert!(rows == 9 && document.contains("## Measured") && !document.contains("NaN"), "{document}");
    run(&["study", "scaling", "--facets", "5000", "--ranks", "100"]).assert_refused(&["5041", "100", "64"]);
    run(&["study", "scaling", "--contact", "0.9"]).assert_refused(&["0.9", "between 0.1 and 0.8"]);
    run(&["study", "scaling", "--bandwidth", "0"]).assert_refused(&["above zero"]);
}

/// Little in all ways; how little is a matter of steps.
#[test]
fn contact_does_next_to_no_work_around_a_closed_path() {
    let Run { code, stdout, .. } = run(&["study", "closed-path", "--steps", "200"]);
    assert_eq!(code, 0);
    let rows: Vec<Vec<&str>> = stdout
        .lines()
        .filter(|line| line.starts_with("| smooth") || line.starts_with("| facets"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    assert_eq!(rows.len(), 4, "{stdout}");
    for row in &rows {
        let [_, force, work, _] = row[..] else { panic!("{row:?}") };
        let largest: f64 = force.split(" to ").nth(1).unwrap().parse().unwrap();
        let work: f64 = work.parse().unwrap();
        assert!(largest > 0.03 && work.abs() < 5e-4, "{row:?}");
    }
}

/// Pressures of an elastic cylinder on an elastic block are Hertz', whichever is the slave.
#[test]
fn bodies_of_hertz_reach_beyond_their_equally_long_cells() {
    for extent in ["0.5", "1.3", "1.5"] {
        run(&["study", "hertz", "--extent", extent])
            .assert_refused(&[&format!("--extent {extent}:"), "above 1.500"]);
    }
}

#[test]
fn pressures_of_a_cylinder_are_those_of_hertz() {
    let Run { code, stdout, .. } = run(&["study", "hertz", "cylinder", "--finest", "4", "--meshes", "1"]);
    assert_eq!(code, 0);
    let rows: Vec<Vec<&str>> = stdout
        .lines()
        .filter(|line| line.starts_with("| block") || line.starts_with("| cylinder"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    assert_eq!(rows.len(), 2, "{stdout}");
    for row in &rows {
        let percent = |column: usize| row[column].trim_end_matches(" %").parse::<f64>().unwrap();
        assert!(percent(6) < 1.0 && percent(8).abs() < 1.5 && percent(10).abs() < 1.0, "{row:?}");
    }
}
