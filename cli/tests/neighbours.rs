//! Runs the program's `neighbours` on good and on bad input.

use crate::runs::{Run, Scratch, run, run_with_input};
use diffuse_contact::neighbourhood::{NeighbourRule, NeighbourSearch, SearchOptions};
use diffuse_contact::pairing::NearestNodes;
use serde_json::{Value, json};

/// An n × n grid in the plane z = 0 with spacing 1.
fn grid(n: i32) -> Vec<[f64; 3]> {
    (0..n * n).map(|k| [f64::from(k % n), f64::from(k / n), 0.0]).collect()
}

fn over_grid(slave: [f64; 3]) -> Value {
    json!({"slave": slave, "masters": grid(9), "outward": [0, 0, 1]})
}

fn with(mut search: Value, field: &str, value: Value) -> Value {
    search[field] = value;
    search
}

fn neighbours(input: &Value) -> Value {
    let Run { code, stdout, stderr } = run_with_input(&["neighbours", "-"], &input.to_string());
    assert_eq!((code, stderr.as_str()), (0, ""), "{input}");
    serde_json::from_str(&stdout).unwrap()
}

#[test]
fn the_layers_around_a_grid_node_are_its_cells() {
    let answer = neighbours(&with(over_grid([4.0, 4.0, 0.25]), "layers", json!(1)));
    assert_eq!(answer["status"], "ok");
    assert_eq!(answer["rule"], "hull-layers");
    assert_eq!(answer["at_slave"], json!([40]));
    assert_eq!(answer["layers"], json!([[30, 31, 32, 39, 41, 48, 49, 50]]));
    assert_eq!(answer["basis"], "quadratic");
    assert_eq!(answer["nodes"].as_array().unwrap()[0], 40);
    assert_eq!(answer["nodes"].as_array().unwrap().len(), 9);
    assert_eq!((&answer["encloses_slave"], &answer["complete"]), (&json!(true), &json!(true)));
    assert_eq!(answer["fallback"], Value::Null);
    assert_eq!(answer["frame"]["normal"], json!([0.0, 0.0, 1.0]));
    let radius = answer["support_radius"].as_f64().unwrap();
    assert!((radius - 1.25 * 2.0_f64.sqrt()).abs() < 1e-14);
    assert!(answer["condition"].as_f64().unwrap() > 1.0);
}

/// One layer around the middle of a cell is its four corners, on a conic: no quadratic fit, so a number of layers is
/// taken as it is, and without a number there are more.
#[test]
fn layers_are_taken_as_asked_for_or_until_the_fit_is_good() {
    let middle = over_grid([3.5, 3.5, 0.1]);
    let one = neighbours(&with(middle.clone(), "layers", json!(1)));
    assert_eq!(one["layers"], json!([[30, 31, 39, 40]]));
    assert_eq!(one["basis"], "linear");
    let enough = neighbours(&middle);
    assert_eq!(enough["layers"].as_array().unwrap().len(), 2);
    assert_eq!(enough["basis"], "quadratic");
    assert!(enough["regularity"].as_f64().unwrap() > 0.01);

    // Six nodes on a circle around the slave are on a conic: singular, which JSON has no number for.
    let ring: Vec<[f64; 3]> = [[1.0, 0.0], [0.6, 0.8], [-0.6, 0.8], [-1.0, 0.0], [-0.6, -0.8], [0.6, -0.8]]
        .map(|[x, y]| [x, y, 0.0])
        .into();
    let ring = json!({"slave": [0, 0, 1], "masters": ring, "outward": [0, 0, 1], "layers": 4});
    let answer = neighbours(&ring);
    assert_eq!(answer["layers"], json!([[0, 1, 2, 3, 4, 5]]), "fewer where the nodes run out");
    assert!(answer["condition"].is_null() || answer["condition"].as_f64().unwrap() > 1e12, "{answer}");
    let fallback = neighbours(&without(ring, "layers"));
    assert_eq!(fallback["basis"], "linear");
    assert_eq!(fallback["fallback"]["kind"], "linear");
    assert!(fallback["fallback"]["quadratic_regularity"].as_f64().unwrap() < 1e-10);
}

fn without(mut search: Value, field: &str) -> Value {
    search.as_object_mut().unwrap().remove(field);
    search
}

#[test]
fn every_rule_answers_what_the_library_finds() {
    let slave = [3.3, 4.1, 0.2];
    let nodes = NearestNodes::new(grid(9)).unwrap();
    for (fields, rule) in [
        (json!({}), NeighbourRule::hull_layers(None)),
        (json!({"rule": "hull-radius"}), NeighbourRule::hull_radius(None)),
        (json!({"rule": "hull-radius", "layers": 2}), NeighbourRule::hull_radius(Some(2))),
        (json!({"rule": "nearest"}), NeighbourRule::nearest(12)),
        (json!({"rule": "nearest", "count": 7}), NeighbourRule::nearest(7)),
    ] {
        let mut search = over_grid(slave);
        search.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
        let answer = neighbours(&search);
        let options = SearchOptions::default().with_rule(rule);
        let found = NeighbourSearch::new(options).unwrap().find(&nodes, slave, [0.0, 0.0, 1.0]).unwrap();
        assert_eq!(answer["nodes"], json!(found.nodes), "{fields}");
        assert_eq!(answer["layers"], json!(found.layers), "{fields}");
        assert_eq!(answer["support_radius"], json!(found.support_radius), "{fields}");
        assert_eq!(answer["condition"], json!(found.condition), "{fields}");
        assert_eq!(answer["regularity"], json!(found.regularity), "{fields}");
        assert_eq!(answer["pivot_ratio"], json!(found.pivot_ratio), "{fields}");
    }
    // The nearest six of a cell's middle are two rows: one after the other is added.
    let search = with(with(over_grid([3.5, 3.45, 0.1]), "rule", json!("nearest")), "count", json!(6));
    let answer = neighbours(&search);
    let by = answer["fallback"]["by"].as_u64().unwrap();
    assert_eq!(answer["fallback"]["kind"], "extended");
    assert_eq!(answer["nodes"].as_array().unwrap().len() as u64, 6 + by);
    let linear = neighbours(&with(over_grid([3.5, 3.5, 0.1]), "basis", json!("linear")));
    assert_eq!((&linear["basis"], linear["layers"].as_array().unwrap().len()), (&json!("linear"), 1));
}

#[test]
fn inside_border_and_beyond_are_told_apart() {
    for (place, encloses_slave, on_border) in
        [([4.2, 4.1, 0.3], true, false), ([0.0, 4.3, 0.1], false, true), ([-2.0, 4.0, 0.0], false, false)]
    {
        let answer = neighbours(&over_grid(place));
        assert_eq!(answer["encloses_slave"], json!(encloses_slave), "{place:?}");
        assert_eq!(answer["on_border"], json!(on_border), "{place:?}");
    }
}

#[test]
fn a_list_is_answered_by_a_list() {
    assert_eq!(neighbours(&json!([])), json!([]));
    let (good, beyond) = (over_grid([4.2, 4.1, 0.3]), over_grid([-2.0, 4.0, 0.0]));
    let line: Vec<[f64; 3]> = (0..12).map(|k| [f64::from(k), 0.0, 0.0]).collect();
    let line = json!({"slave": [4, 0, 1], "masters": line, "outward": [0, 0, 1]});
    let sideways = with(good.clone(), "outward", json!([1, 0, 0]));
    let text = json!([good, line, beyond, sideways]).to_string();
    let Run { code, stdout, stderr } = run_with_input(&["neighbours", "-"], &text);
    assert_eq!(code, 1);
    assert_eq!(stderr, "note: 2 of 4 searches have no result (ambiguous-outward: 1, no-average-plane: 1)\n");
    let answers: Value = serde_json::from_str(&stdout).unwrap();
    let codes: Vec<&Value> = answers.as_array().unwrap().iter().map(|answer| &answer["code"]).collect();
    assert_eq!(codes, [&Value::Null, &json!("no-average-plane"), &Value::Null, &json!("ambiguous-outward")]);
    assert_eq!(answers[1].as_object().unwrap().len(), 3);
    assert_eq!(answers[0], neighbours(&good));
    assert_eq!((&answers[0]["encloses_slave"], &answers[2]["encloses_slave"]), (&json!(true), &json!(false)));
}

#[test]
fn bad_input_is_refused_as_a_whole() {
    let scratch = Scratch::new("neighbours-bad");
    let good = over_grid([4.0, 4.1, 0.3]);
    let two = with(good.clone(), "masters", json!([[0, 0, 0], [1, 0, 0]]));
    let nearest = with(good.clone(), "rule", json!("nearest"));
    let cases: Vec<(String, &str)> = vec![
        (json!([good, two]).to_string(), ": [1].masters: 2 nodes, but a surface needs at least 3"),
        (two.to_string(), ": masters: 2 nodes"),
        (with(good.clone(), "layers", json!(0)).to_string(), "layers: expected at least 1, found 0"),
        (with(good.clone(), "layers", json!(-1)).to_string(), "layers: invalid value: integer `-1`"),
        (with(good.clone(), "layers", json!(1.5)).to_string(), "layers: invalid type: floating point `1.5`"),
        (
            with(good.clone(), "rule", json!("hull")).to_string(),
            "rule: unknown variant `hull`, expected one of",
        ),
        (
            with(good.clone(), "count", json!(8)).to_string(),
            "count: has no meaning for the rule \"hull-layers\"",
        ),
        (
            with(with(good.clone(), "rule", json!("hull-radius")), "count", json!(8)).to_string(),
            "count: has no meaning for the rule \"hull-radius\"",
        ),
        (
            json!([with(nearest.clone(), "layers", json!(2))]).to_string(),
            "[0].layers: has no meaning for the rule \"nearest\"",
        ),
        (
            with(with(good.clone(), "layers", json!(2)), "basis", json!("linear")).to_string(),
            "basis: has no meaning for a number of hull layers",
        ),
        (without(good.clone(), "outward").to_string(), "missing field `outward`"),
        (json!([without(good.clone(), "outward")]).to_string(), "[0]: missing field `outward`"),
        (json!([without(good.clone(), "slave")]).to_string(), "[0]: missing field `slave`"),
        (with(good.clone(), "layer", json!(2)).to_string(), "layer: unknown field `layer`, expected one of"),
        (with(good.clone(), "layer", json!(2)).to_string(), "did you mean `layers`?"),
        (json!([good, 3]).to_string(), "[1]: invalid type: integer `3`, expected an object"),
        (json!([[good]]).to_string(), "[0]: invalid type: sequence, expected an object"),
        ("3".to_owned(), "expected an object with slave, masters and outward, a list of such objects, or"),
        ("{\"slave\": [0, 0,\n NaN]}".to_owned(), "line 2, column 2: slave[2]: NaN is no number in JSON"),
        ("[{\"masters\": [[0, 0]]}]".to_owned(), "[0].masters[0]: expected three coordinates"),
        ("[".to_owned(), "not valid JSON: EOF"),
        (format!("{good} x"), "not valid JSON: trailing characters"),
    ];
    let output = scratch.path("out.json");
    for (text, expected) in &cases {
        let input = scratch.file("in.json", text);
        run(&["neighbours", &input, "-o", &output]).assert_refused(&[&input, expected]);
        assert_eq!(scratch.names(), ["in.json"], "nothing is written");
    }
}

/// The page on the command line shows one file, for both jobs.
#[test]
fn the_file_of_evaluate_is_read_too() {
    let page = include_str!("../../docs/how-to/command-line.md");
    let begin = page.find(r#"{"elements": ["#).unwrap();
    let text = &page[begin..begin + page[begin..].find("```").unwrap()];
    let scratch = Scratch::new("neighbours-elements");
    let input = scratch.file("in.json", text);
    let answers = |input: &str| -> Value {
        let Run { code, stdout, stderr } = run(&["neighbours", input]);
        assert_eq!((code, stderr.as_str()), (0, ""));
        serde_json::from_str(&stdout).unwrap()
    };
    let answer = answers(&input);
    assert_eq!(answer["elements"][0]["status"], "ok", "{answer}");
    // What only an element has makes no difference here, and is refused where it cannot be for an element.
    let mut whole: Value = serde_json::from_str(text).unwrap();
    for (field, value) in [
        ("weight", json!("cubic")),
        ("penalty", json!(3.0)),
        ("frame", json!("average-plane")),
        ("anchor", json!([0.1, 0.2, 0.0])),
        ("friction", json!({"coefficient": 0.3, "stiffness": 1.0})),
    ] {
        whole["elements"][0][field] = value.clone();
        let mut alone = whole["elements"][0].clone();
        alone
            .as_object_mut()
            .unwrap()
            .retain(|name, _| ["slave", "masters", "outward", field].contains(&name.as_str()));
        run(&["neighbours", &scratch.file("one.json", &alone.to_string())])
            .assert_refused(&[&format!("{field}: has no meaning for a search")]);
    }
    assert_eq!(answers(&scratch.file("whole.json", &whole.to_string())), answer);
    // The normal of a given frame tells what is outside, too; without either the element alone has no result, as in `evaluate`.
    let first = whole["elements"][0].as_object_mut().unwrap();
    first.remove("outward");
    first["frame"] = json!({"origin": [0, 0, 0], "t1": [1, 0, 0], "t2": [0, 1, 0], "normal": [0, 0, 1]});
    assert_eq!(answers(&scratch.file("given.json", &whole.to_string())), answer);
    let both = json!({"elements": [without(whole["elements"][0].clone(), "frame"), whole["elements"][0]]});
    let input = scratch.file("both.json", &both.to_string());
    for job in ["neighbours", "evaluate"] {
        let Run { code, stdout, .. } = run(&[job, &input]);
        let found: Value = serde_json::from_str(&stdout).unwrap();
        assert_eq!((code, &found["elements"][0]["code"]), (1, &json!("missing-outward")), "{job}: {found}");
    }
    let more = json!({"elements": [], "more": 1}).to_string();
    run(&["neighbours", &scratch.file("more.json", &more)]).assert_refused(&["unknown field `more`"]);
}

#[test]
fn files_are_handled_with_care() {
    let scratch = Scratch::new("neighbours-files");
    let text = over_grid([4.0, 4.1, 0.3]).to_string();
    let input = scratch.file("in.json", &text);
    run(&["neighbours", &scratch.path("none.json")])
        .assert_refused(&["none.json: cannot be read: there is no such file"]);
    run(&["neighbours", &input, "--out", &scratch.path("none/out.json")])
        .assert_refused(&["there is no directory"]);
    run(&["neighbours", &input, "-o", &input]).assert_refused(&["is the input file"]);
    run(&["neighbours"]).assert_refused(&["<IN.json>"]);
    for option in ["-o", "--output", "--out"] {
        let output = scratch.path(&format!("out{option}.json"));
        let Run { code, stdout, stderr } = run(&["neighbours", &input, option, &output]);
        assert_eq!((code, stdout.as_str(), stderr.as_str()), (0, "", ""));
        let answer: Value = serde_json::from_str(&std::fs::read_to_string(&output).unwrap()).unwrap();
        assert_eq!(answer, neighbours(&serde_json::from_str(&text).unwrap()));
    }
}

/// Some editors begin a file with a mark.
#[test]
fn a_file_of_elements_may_begin_with_a_byte_order_mark() {
    let element = json!({"slave": [4.0, 4.0, 0.25], "masters": grid(9), "outward": [0, 0, 1]});
    let text = json!({"elements": [element]}).to_string();
    let [plain, marked] =
        [text.clone(), format!("\u{feff}{text}")].map(|text| run_with_input(&["neighbours", "-"], &text));
    assert_eq!((marked.code, marked.stdout), (0, plain.stdout));
}
