//! Runs the program's `evaluate` on good and on bad input.

use crate::elements::{bent, numbers, plane, rows};
use crate::runs::{Run, Scratch, run, run_with_input};
use diffuse_contact::interface::{ContactInterface, InterfaceOptions, PairedElement};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Backend, Generated, MaterialDomain, Mode, Point};
use serde_json::{Value, json};

pub fn evaluate(elements: Value) -> Vec<Value> {
    let Run { code, stdout, stderr } =
        run_with_input(&["evaluate", "-"], &json!({"elements": elements}).to_string());
    let answer: Value = serde_json::from_str(&stdout).unwrap();
    let answers = answer["elements"].as_array().unwrap().clone();
    let is_complete = answers.iter().all(|answer| answer["status"] == "ok");
    assert_eq!(code, i32::from(!is_complete), "{stderr}");
    answers
}

#[track_caller]
fn assert_close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-13, "{found} instead of {expected}");
}

#[test]
fn masters_may_have_domains_of_their_own() {
    let slave = [1.1, 0.9, -0.25];
    let with = |radii: &[f64]| {
        let mut element = bent(slave);
        element["support_radii"] = json!(radii);
        element
    };
    let radii: Vec<f64> = (0..9).map(|k| 1.7 + 0.1 * f64::from(k % 3)).collect();
    let answers = evaluate(json!([bent(slave), with(&radii), with(&radii[1..]), with(&[-1.0; 9])]));
    assert_eq!((&answers[0]["status"], &answers[1]["status"]), (&json!("ok"), &json!("ok")));
    assert_close(answers[1]["support_radius"].as_f64().unwrap(), 1.9);
    let gaps = [0, 1].map(|k| answers[k]["gap"].as_f64().unwrap());
    assert!((gaps[0] - gaps[1]).abs() > 1e-4, "{gaps:?}");
    // Forces and moments balance, also with a plane whose nodes are weighted.
    let n = numbers(&answers[1]["n"]);
    let points: Vec<Vec<f64>> =
        std::iter::once(slave.to_vec()).chain(rows(&bent(slave)["masters"])).collect();
    for axis in 0..3 {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        assert_close(n.iter().skip(axis).step_by(3).sum(), 0.0);
        assert_close(
            points.iter().enumerate().map(|(k, x)| x[i] * n[3 * k + j] - x[j] * n[3 * k + i]).sum(),
            0.0,
        );
    }
    assert_eq!(answers[2]["code"], "wrong-number-of-domains");
    assert_eq!(answers[3]["code"], "invalid-domain");
}

#[test]
fn a_plane_has_the_gap_of_a_plane() {
    let answers = evaluate(json!([plane([1.1, 0.9, 0.25]), plane([1.1, 0.9, -0.25])]));
    for (answer, height) in answers.iter().zip([0.25, -0.25]) {
        assert_eq!(answer["status"], "ok");
        assert_eq!(answer["active"], height < 0.0);
        assert_close(answer["gap"].as_f64().unwrap(), height);
        let foot = numbers(&answer["foot"]);
        for (found, expected) in foot.iter().zip([1.1, 0.9, 0.0]) {
            assert_close(*found, expected);
        }
        let normal = numbers(&answer["normal"]);
        for (found, expected) in normal.iter().zip([0.0, 0.0, 1.0]) {
            assert_close(*found, expected);
        }
        assert_eq!(numbers(&answer["coefficients"]).len(), 6);
        // The default radius: 1.25 × the farthest in-plane distance, here to the node (0, 2) or (2, 0)…
        assert_close(answer["support_radius"].as_f64().unwrap(), 1.25 * 1.1_f64.hypot(1.1));
    }
}

#[test]
fn force_and_tangent_follow_from_gap_n_and_m() {
    let mut element = plane([1.1, 0.9, -0.25]);
    element["penalty"] = json!(1e3);
    element["masters"][4] = json!([1.0, 1.0, 0.1]);
    let answer = &evaluate(json!([element]))[0];
    let gap = answer["gap"].as_f64().unwrap();
    let (n, m) = (numbers(&answer["n"]), rows(&answer["m"]));
    let (force, tangent) = (numbers(&answer["force"]), rows(&answer["tangent"]));
    assert_eq!((n.len(), m.len(), force.len(), tangent.len()), (30, 30, 30, 30));
    for i in 0..30 {
        assert_close(force[i] * 1e-3, -gap * n[i]);
        for j in 0..30 {
            assert_eq!(m[i][j], m[j][i]);
            assert_close(tangent[i][j] * 1e-3, gap * m[i][j] + n[i] * n[j]);
        }
    }
    for axis in 0..3 {
        assert_close(n.iter().skip(axis).step_by(3).sum(), 0.0);
    }
}

/// Σ x × ∂g/∂x over slave and masters: the moment of the contact forces for one unit of force.
fn moment(element: &Value, n: &[f64]) -> [f64; 3] {
    let masters = element["masters"].as_array().unwrap();
    let points = std::iter::once(&element["slave"]).chain(masters).map(numbers);
    points.zip(n.chunks(3)).fold([0.0; 3], |sum, (x, f)| {
        [
            sum[0] + x[1] * f[2] - x[2] * f[1],
            sum[1] + x[2] * f[0] - x[0] * f[2],
            sum[2] + x[0] * f[1] - x[1] * f[0],
        ]
    })
}

#[test]
fn the_average_plane_moves_unless_it_is_held() {
    let element = bent([1.3, 0.8, 0.4]);
    let mut moving = element.clone();
    moving["frame_derivative"] = json!("co-moving");
    let mut held = element.clone();
    held["frame_derivative"] = json!("held");
    let answers = evaluate(json!([element, moving, held]));
    assert_eq!(answers[0], answers[1]);
    assert_close(answers[0]["gap"].as_f64().unwrap(), answers[2]["gap"].as_f64().unwrap());
    // Only a gap that follows every motion of the nodes makes no moment.
    let largest = |answer: &Value| {
        moment(&element, &numbers(&answer["n"])).map(f64::abs).into_iter().fold(0.0, f64::max)
    };
    assert!(largest(&answers[0]) < 1e-13, "{}", largest(&answers[0]));
    assert!(largest(&answers[2]) > 1e-3, "{}", largest(&answers[2]));

    // The held average plane is the same as that plane, given.
    let mut given = held.clone();
    given["frame"] = answers[2]["frame"].clone();
    given.as_object_mut().unwrap().remove("frame_derivative");
    let given = &evaluate(json!([given]))[0];
    assert_eq!(given["frame_derivative"], "held");
    assert_eq!((&given["n"], &given["m"]), (&answers[2]["n"], &answers[2]["m"]));
}

#[test]
fn a_given_frame_does_not_move() {
    let mut element = plane([1.0, 1.0, 0.5]);
    element["frame"] = json!({"origin": [0, 0, 0], "t1": [1, 0, 0], "t2": [0, 1, 0], "normal": [0, 0, 1]});
    element["frame_derivative"] = json!("co-moving");
    let mut held = element.clone();
    held["frame_derivative"] = json!("held");
    let answers = evaluate(json!([element, held]));
    assert_eq!(answers[0]["code"], "co-moving-given-frame");
    let message = answers[0]["message"].as_str().unwrap();
    assert!(message.contains("which does not move with the nodes"), "{message}");
    assert_eq!(answers[1]["status"], "ok");
}

#[test]
fn a_given_frame_is_used_and_oriented() {
    let mut element = plane([1.0, 1.0, 0.5]);
    element["frame"] = json!({"origin": [0, 0, 0], "t1": [1, 0, 0], "t2": [0, 1, 0], "normal": [0, 0, -1]});
    let mut own_side = element.clone();
    own_side.as_object_mut().unwrap().remove("outward");
    let answers = evaluate(json!([element, own_side]));
    assert_close(answers[0]["gap"].as_f64().unwrap(), 0.5);
    assert_close(answers[1]["gap"].as_f64().unwrap(), -0.5);
    assert_eq!(numbers(&answers[1]["frame"]["normal"]), [0.0, 0.0, -1.0]);
}

#[test]
fn one_bad_element_does_not_stop_the_others() {
    let corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]];
    let four_nodes =
        json!({"slave": [0, 0, 1], "masters": corners, "outward": [0, 0, 1], "basis": "quadratic"});
    let with = |field: &str, value: Value| {
        let mut element = plane([1.0, 1.0, 0.5]);
        element[field] = value;
        element
    };
    let mut no_outward = plane([1.0, 1.0, 0.5]);
    no_outward.as_object_mut().unwrap().remove("outward");
    let strip: Vec<[i32; 3]> = (0..8).map(|k| [k / 2, k % 2, 0]).collect();
    let skew = json!({"origin": [0, 0, 0], "t1": [1, 0, 0], "t2": [1, 1, 0], "normal": [0, 0, 1]});
    let elements = [
        ("too-few-nodes", four_nodes),
        ("missing-outward", no_outward),
        ("ambiguous-outward", with("outward", json!([1, 0, 0]))),
        ("ambiguous-outward", with("outward", json!([0, 0, 0]))),
        ("invalid-support-radius", with("support_radius", json!(-1))),
        ("invalid-penalty", with("penalty", json!(0))),
        ("invalid-frame", with("frame", skew)),
        ("singular-fit", with("masters", json!(strip))),
        ("overflow", with("penalty", json!(1.7e308))),
    ];
    let mut input: Vec<Value> = elements.iter().map(|(_, element)| element.clone()).collect();
    // A steep surface, so that products with the penalty leave the range of numbers.
    let last = input.len() - 1;
    input[last]["slave"] = json!([1.0, 1.0, 20.0]);
    input.push(plane([1.0, 1.0, 0.5]));
    let answers = evaluate(json!(input));
    for ((code, _), answer) in elements.iter().zip(&answers) {
        assert_eq!(answer["status"], "error", "{code}: {answer}");
        assert_eq!(answer["code"], *code, "{answer}");
        assert!(!answer["message"].as_str().unwrap().is_empty());
        assert_eq!(answer.as_object().unwrap().len(), 3);
    }
    assert_eq!(answers[elements.len()]["status"], "ok");
}

#[test]
fn the_numbers_survive_the_text() {
    let scratch = Scratch::new("round-trip");
    let elements = json!({"elements": [plane([1.1, 0.9, 0.1 + 0.2])]});
    let input = scratch.file("in.json", &elements.to_string());
    let output = scratch.path("out.json");
    let Run { code, stdout, stderr } = run(&["evaluate", &input, "-o", &output]);
    assert_eq!((code, stdout.as_str(), stderr.as_str()), (0, "", ""));
    let text = std::fs::read_to_string(&output).unwrap();
    let answer: Value = serde_json::from_str(&text).unwrap();
    let again: Value = serde_json::from_str(&answer.to_string()).unwrap();
    assert_eq!(answer, again);
    assert_eq!(scratch.names(), ["in.json", "out.json"]);
}

#[test]
fn what_does_not_follow_the_schema_is_refused_as_a_whole() {
    let scratch = Scratch::new("schema");
    for (text, expected) in [
        (
            "{\"elements\": [\n {\"slave\": [0, 0, 0], \"master\": []}]}",
            "line 2, column 30: elements[0].master: unknown field `master`, expected one of",
        ),
        (
            r#"{"elements": [{"slave": [0, 0, 1e999], "masters": []}]}"#,
            "elements[0].slave[2]: number out of range",
        ),
        (
            r#"{"elements": [{"slave": [0, 0, NaN], "masters": []}]}"#,
            "elements[0].slave[2]: NaN is no number in JSON",
        ),
        (
            r#"{"elements": [{"slave": [0, 0, 0], "masters": [[0, 0, 0], [1, "x", 0]]}]}"#,
            "elements[0].masters[1][1]: invalid type: string",
        ),
        (
            r#"{"elements": [{"slave": [0, 0, 0], "masters": [], "weight": "bell"}]}"#,
            "elements[0].weight: unknown variant `bell`",
        ),
        (
            r#"{"elements": [{"slave": [0, 0, 0], "masters": [], "frame_derivative": "moving"}]}"#,
            "elements[0].frame_derivative: unknown variant `moving`, expected `held` or `co-moving`",
        ),
        (r#"{"elements": [{"slave": [0, 0, 0]"#, "not valid JSON: EOF while parsing"),
    ] {
        let input = scratch.file("in.json", text);
        let output = scratch.path("out.json");
        let run = run(&["evaluate", &input, "-o", &output]);
        run.assert_refused(&[&input, expected]);
        assert_eq!(scratch.names(), ["in.json"], "nothing is written");
    }
}

#[test]
fn files_that_cannot_be_used_are_named() {
    let scratch = Scratch::new("files");
    let input = scratch.file("in.json", &json!({"elements": [plane([1.0, 1.0, 1.0])]}).to_string());
    run(&["evaluate", &scratch.path("none.json")])
        .assert_refused(&["none.json: cannot be read: there is no such file"]);
    run(&["evaluate", &scratch.path("")]).assert_refused(&["it is a directory"]);
    run(&["evaluate", &input, "-o", &scratch.path("none/out.json")])
        .assert_refused(&["there is no directory", "none"]);
    run(&["evaluate", &input, "-o", &scratch.path("")]).assert_refused(&["cannot be written"]);
    run(&["evaluate", &input, "--backend", "guess"]).assert_refused(&["'guess'", "generated, ad"]);
    run(&["evaluate"]).assert_refused(&["<IN.json>"]);
}

#[test]
fn an_existing_file_is_kept_when_the_input_is_bad() {
    let scratch = Scratch::new("kept");
    let input = scratch.file("in.json", "{}");
    let output = scratch.file("out.json", "old");
    run(&["evaluate", &input, "-o", &output]).assert_refused(&["missing field `elements`"]);
    assert_eq!(std::fs::read_to_string(&output).unwrap(), "old");
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let elements: Vec<Value> = (0..200).map(|_| plane([1.1, 0.9, 0.25])).collect();
    let scratch = Scratch::new("pipe");
    let input = scratch.file("in.json", &json!({"elements": elements}).to_string());
    let run = crate::runs::run_and_close_stdout(&["evaluate", &input]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""));
    // But for elements without a result.
    let line =
        json!({"slave": [0, 0, 1], "masters": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "outward": [0, 0, 1]});
    let input = scratch.file("in.json", &json!({"elements": vec![line; 2000]}).to_string());
    let run = crate::runs::run_and_close_stdout(&["evaluate", &input]);
    assert!(
        run.code == 1 && run.stderr.contains("note: at least ") && run.stderr.contains("of 2000"),
        "{run:?}"
    );
}

#[test]
fn an_input_is_not_replaced_by_its_results() {
    let scratch = Scratch::new("same-file");
    let text = r#"{"elements": []}"#;
    let input = scratch.file("in.json", text);
    let name = input.as_str();
    run(&["evaluate", name, "-o", name]).assert_refused(&["in.json", "is the input file"]);
    assert_eq!(std::fs::read_to_string(&input).unwrap(), text);
}

#[test]
fn two_master_nodes_are_bad_input() {
    let scratch = Scratch::new("two-nodes");
    let good = r#"{"slave": [0, 0, 1], "masters": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "outward": [0, 0, 1]}"#;
    let two = r#"{"slave": [0, 0, 1], "masters": [[0, 0, 0], [1, 0, 0]], "outward": [0, 0, 1]}"#;
    let input = scratch.file("in.json", &format!(r#"{{"elements": [{good}, {two}]}}"#));
    let output = scratch.path("out.json");
    run(&["evaluate", &input, "-o", &output])
        .assert_refused(&["in.json: elements[1].masters: 2 nodes", "at least 3"]);
    assert!(!std::path::Path::new(&output).exists());
}

/// One of them too large is an entry with an error, and no end of the others.
#[test]
fn an_element_that_is_too_large_leaves_the_others_unharmed() {
    let mut large = plane([1.1, 0.9, 0.25]);
    large["masters"] = (0..30_000).map(|k| json!([f64::from(k % 173), f64::from(k / 173), 0.0])).collect();
    let answers = evaluate(json!([plane([1.1, 0.9, 0.25]), large, plane([1.1, 0.9, -0.25])]));
    assert_eq!((&answers[0]["status"], &answers[2]["status"]), (&json!("ok"), &json!("ok")));
    assert_eq!(answers[1]["code"], "too-many-masters");
    assert!(answers[1]["message"].as_str().unwrap().contains("1000 masters at most, not 30000"));
}

/// Within a limit of memory too.
#[cfg(target_os = "linux")]
#[test]
fn an_element_without_memory_leaves_the_others_unharmed() {
    let scratch = Scratch::new("evaluate-memory");
    let mut large = plane([1.1, 0.9, 0.25]);
    large["masters"] = (0..1000).map(|k| json!([f64::from(k % 33), f64::from(k / 33), 0.0])).collect();
    let input = scratch.file("in.json", &json!({"elements": [large, plane([1.1, 0.9, 0.25])]}).to_string());
    let script = format!("ulimit -v 200000; exec '{}' evaluate '{input}'", crate::PROGRAM);
    let Run { code, stdout, stderr } =
        std::process::Command::new("sh").args(["-c", &script]).output().unwrap().into();
    assert_eq!(code, 1, "{stderr}");
    let answer: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(answer["elements"][0]["code"], "no-memory", "{stderr}");
    assert_eq!(answer["elements"][1]["status"], "ok");
}

/// Users of single elements are told how well conditioned the fit is, in the measure of `neighbours`.
#[test]
fn the_regularity_of_the_fit_is_told() {
    let sound = evaluate(json!([plane([1.1, 0.9, 0.25])]))[0]["regularity"].as_f64().unwrap();
    assert!(sound > 0.1 && sound <= 1.0, "{sound}");
    // Eight nodes near a circle about the slave carry a quadratic fit badly.
    let masters: Vec<[f64; 3]> = (0..8)
        .map(|k| {
            let angle = std::f64::consts::TAU * f64::from(k) / 8.0 + 0.1;
            let radius = if k % 2 == 0 { 1.0 } else { 1.02 };
            [radius * angle.cos(), radius * angle.sin(), 0.0]
        })
        .collect();
    let circle = json!({"slave": [0.05, 0.02, 0.1], "masters": masters, "outward": [0, 0, 1]});
    let answer = &evaluate(json!([circle]))[0];
    assert_eq!(answer["status"], "ok", "{answer}");
    assert!(answer["regularity"].as_f64().unwrap() < 1e-2, "{}", answer["regularity"]);
}

/// A file can forge no message of its own, nor speak to the terminal; and what is long is neither compared for a minute nor printed.
#[test]
fn names_in_a_file_are_shown_in_one_line_of_limited_length() {
    let scratch = Scratch::new("evaluate-names");
    let hostile = "\u{1b}]0;title\u{7}\nerror: forged";
    for long in ["", &"x".repeat(10_000_000)] {
        let name = format!("{hostile}{long}");
        let mut key = plane([0.0; 3]);
        key[&name] = json!(1);
        let mut word = plane([0.0; 3]);
        word["weight"] = json!(name);
        let mut frame = plane([0.0; 3]);
        frame["frame"] = json!(name);
        for element in [key, word, frame] {
            let input = scratch.file("in.json", &json!({"elements": [element]}).to_string());
            let refused = run(&["evaluate", &input]);
            refused.assert_refused(&["forged", ", expected "]);
            assert!(refused.stderr.len() < 1500, "{}", refused.stderr.len());
            assert!(!refused.stderr.trim_end().contains(char::is_control), "{refused:?}");
        }
    }
}

/// An element as `evaluate` takes it, and what its interface makes of it.
struct Exported {
    element: Value,
    gap: f64,
    n: Vec<f64>,
    m: Vec<Vec<f64>>,
}

/// The elements of an interface over a wavy surface that has been stretched and bent since.
fn exported() -> Vec<Exported> {
    let first: Vec<Point> = (0..49)
        .map(|k| (f64::from(k % 7), f64::from(k / 7)))
        .map(|(x, y)| [x + 0.1 * (3.0 * y).sin(), 0.6 * y + 0.1 * (2.0 * x).cos(), 0.2 * (x + y).sin()])
        .collect();
    let facets: Vec<Facet> = (0..36)
        .map(|k| k % 6 + 7 * (k / 6))
        .map(|k| Facet::Quadrilateral([k, k + 1, k + 8, k + 7]))
        .collect();
    let mut positions = first.clone();
    let slaves: Vec<Point> =
        (0..6).map(|k| [1.3 + 0.6 * f64::from(k), 1.1 + 0.3 * f64::from(k), 0.3]).collect();
    positions.extend(&slaves);
    let master = MasterSurface::new(&positions, facets).unwrap();
    let own = (first.len()..positions.len()).collect();
    let mut interface =
        ContactInterface::new(master, own, &[], &positions, InterfaceOptions::default()).unwrap();
    for x in &mut positions {
        *x = [1.2 * x[0], 0.9 * x[1] + 0.1 * x[0], x[2] + 0.03 * x[0] * x[0]];
    }
    interface.refresh_pairing(&positions).unwrap();
    interface.evaluate(Mode::Hessian).unwrap();
    let mut elements = Vec::new();
    for (k, contact) in interface.contacts().iter().enumerate() {
        let PairedElement::Diffuse { slave, pairing } = interface.element(k).unwrap() else { panic!() };
        let gap = Generated.gap(&pairing.element(slave), Mode::Hessian).unwrap();
        let ellipsoid = |(&node, material): (&usize, &diffuse_contact::MaterialNode)| {
            MaterialDomain { position: first[node], metric: material.metric }.ellipsoid()
        };
        let metrics: Vec<_> = pairing.masters.iter().zip(&pairing.material).map(ellipsoid).collect();
        let first_positions: Vec<Point> = pairing.masters.iter().map(|&node| first[node]).collect();
        let element = json!({
            "slave": slave, "masters": pairing.positions, "outward": pairing.frame.normal,
            "first_positions": first_positions, "metrics": metrics, "basis": pairing.basis.name(),
        });
        elements.push(Exported {
            element,
            gap: contact.point.gap,
            n: gap.gradient,
            m: gap.hessian.to_rows(),
        });
    }
    elements
}

#[test]
fn an_element_of_an_interface_has_the_interfaces_gap() {
    let exported = exported();
    assert_eq!(exported.len(), 6);
    let answers = evaluate(exported.iter().map(|x| x.element.clone()).collect());
    let mut largest = [0.0_f64; 3];
    for (Exported { gap, n, m, .. }, answer) in exported.iter().zip(&answers) {
        assert_eq!(answer["status"], "ok", "{answer}");
        // Over the largest entry.
        let differences = |x: Vec<f64>, y: &[f64]| {
            assert_eq!(x.len(), y.len());
            let size = y.iter().fold(0.0, |size: f64, y| size.max(y.abs()));
            x.iter().zip(y).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max) / size
        };
        largest[0] = largest[0].max((answer["gap"].as_f64().unwrap() - gap).abs());
        largest[1] = largest[1].max(differences(numbers(&answer["n"]), n));
        largest[2] = largest[2].max(differences(rows(&answer["m"]).concat(), &m.concat()));
        assert!(answer["regularity"].as_f64().unwrap() > 0.01);
    }
    assert!(largest.iter().all(|x| *x < 1e-14), "{largest:?}");
}

#[test]
fn a_rigid_motion_leaves_gap_and_place() {
    let Exported { element, .. } = &exported()[2];
    let (sin, cos) = 0.7_f64.sin_cos();
    let turn = |x: &Value, shift: [f64; 3]| {
        let x = numbers(x);
        let (y, z) = (cos * x[1] - sin * x[2], sin * x[1] + cos * x[2]);
        json!([cos * x[0] - sin * y + shift[0], sin * x[0] + cos * y + shift[1], z + shift[2]])
    };
    let mut moved = element.clone();
    let shift = [3.0, -2.0, 5.0];
    moved["slave"] = turn(&element["slave"], shift);
    moved["outward"] = turn(&element["outward"], [0.0; 3]);
    moved["masters"] = element["masters"].as_array().unwrap().iter().map(|x| turn(x, shift)).collect();
    let answers = evaluate(json!([element, moved]));
    assert_close(answers[1]["gap"].as_f64().unwrap(), answers[0]["gap"].as_f64().unwrap());
    for (x, y) in numbers(&answers[1]["place"]).iter().zip(numbers(&answers[0]["place"])) {
        assert_close(*x, y);
    }
    // The place lies among the first positions, wherever the masters are now.
    let place = numbers(&answers[0]["place"]);
    let first = rows(&element["first_positions"]);
    let nearest =
        first.iter().map(|x| (x[0] - place[0]).hypot(x[1] - place[1])).fold(f64::INFINITY, f64::min);
    assert!(nearest < 0.8, "{nearest}");
    assert_eq!(evaluate(json!([plane([1.1, 0.9, 0.25])]))[0]["place"], Value::Null);
}

#[test]
fn domains_in_the_first_configuration_are_complete_or_refused() {
    let Exported { element, .. } = &exported()[0];
    let with = |field: &str, value: Value| {
        let mut element = element.clone();
        element[field] = value;
        element
    };
    let without = |field: &str| {
        let mut element = element.clone();
        element.as_object_mut().unwrap().remove(field);
        element
    };
    let shorter = |field: &str| json!(element[field].as_array().unwrap()[1..]);
    let metric = |rows: Value| {
        let mut metrics = element["metrics"].clone();
        metrics[1] = rows;
        with("metrics", metrics)
    };
    let far = [1e3, 1e3, 0.0];
    for (element, code, words) in [
        (without("metrics"), "incomplete-domains", "`metrics` is missing"),
        (without("first_positions"), "incomplete-domains", "`first_positions` is missing"),
        (with("support_radius", json!(2.0)), "radius-with-domains", "`support_radius` cannot be given with"),
        (with("support_radii", json!([2.0])), "radius-with-domains", "`support_radii` cannot be given with"),
        (with("metrics", shorter("metrics")), "wrong-number-of-domains", "`metrics` has"),
        (
            with("first_positions", shorter("first_positions")),
            "wrong-number-of-domains",
            "`first_positions` has",
        ),
        (metric(json!([[1, 0, 0], [0, -1, 0], [0, 0, 1]])), "invalid-metric", "`metrics[1]` is no ellipsoid"),
        (metric(json!([[1, 1, 0], [1, 1, 0], [0, 0, 1]])), "invalid-metric", "positive definite"),
        (metric(json!([[0, 0, 0], [0, 0, 0], [0, 0, 0]])), "invalid-metric", "positive definite"),
        (metric(json!([[1, 0.5, 0], [0, 1, 0], [0, 0, 1]])), "invalid-metric", "symmetric"),
        (with("frame_derivative", json!("held")), "held-frame", "moves with the average plane"),
        (without("outward"), "missing-outward", "`outward` is missing"),
        (with("slave", json!(far)), "not-material-place", "place in the first configuration"),
    ] {
        let answer = &evaluate(json!([element]))[0];
        assert_eq!((&answer["status"], &answer["code"]), (&json!("error"), &json!(code)), "{answer}");
        assert!(answer["message"].as_str().unwrap().contains(words), "{answer}");
    }
    let scratch = Scratch::new("metrics");
    let text = json!({"elements": [with("metrics", json!([[[1, 0, 0], [0, 1, 0]]]))]}).to_string();
    let input = scratch.file("in.json", &text);
    run(&["evaluate", &input]).assert_refused(&["elements[0].metrics[0]: expected three rows", "found 2"]);
}

/// The file of `evaluate` is one of `neighbours` too, whatever its domains.
#[test]
fn neighbours_reads_an_element_with_domains() {
    let Exported { element, .. } = &exported()[0];
    let text = json!({"elements": [element]}).to_string();
    let Run { code, stderr, .. } = run_with_input(&["neighbours", "-"], &text);
    assert_eq!(code, 0, "{stderr}");
}
