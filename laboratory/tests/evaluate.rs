//! Runs the program's `evaluate`, by both backends.

use serde_json::{Value, json};

use crate::elements::{bent, numbers, rows};
use crate::runs::run_with_input;

#[test]
fn both_backends_agree_on_either_frame() {
    let frames = ["held", "co-moving"];
    let weights = ["cubic", "cubic-interpolating", "wendland-c2"];
    let mut gaps = Vec::new();
    for (derivative, weight) in frames.into_iter().flat_map(|frame| weights.map(|weight| (frame, weight))) {
        let mut element = bent([1.3, 0.8, 0.4]);
        element["frame_derivative"] = json!(derivative);
        element["weight"] = json!(weight);
        let text = json!({"elements": [element]}).to_string();
        let answers = ["generated", "ad"].map(|backend| {
            let run = run_with_input(&["evaluate", "-", "--backend", backend], &text);
            let answer: Value = serde_json::from_str(&run.stdout).unwrap();
            assert_eq!(answer["elements"][0]["frame_derivative"], derivative);
            gaps.push(answer["elements"][0]["gap"].as_f64().unwrap());
            (numbers(&answer["elements"][0]["n"]), rows(&answer["elements"][0]["m"]))
        });
        let [(n, m), (n_ad, m_ad)] = &answers;
        for (a, b) in n.iter().zip(n_ad).chain(m.iter().flatten().zip(m_ad.iter().flatten())) {
            assert!((a - b).abs() < 1e-11, "{derivative} {weight}: {a} and {b}");
        }
    }
    gaps.sort_by(f64::total_cmp);
    gaps.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
    assert_eq!(gaps.len(), weights.len(), "every weight has a surface of its own: {gaps:?}");
}

/// An element over cells of 1 × 1 that have been stretched to 1.3 × 0.9 and bent.
#[test]
fn both_backends_agree_on_domains_in_the_first_configuration() {
    let first: Vec<[f64; 3]> = (0..36).map(|k| [f64::from(k % 6), f64::from(k / 6), 0.0]).collect();
    let masters: Vec<[f64; 3]> =
        first.iter().map(|[x, y, _]| [1.3 * x, 0.9 * y + 0.1 * x, 0.1 * (x * y).sin()]).collect();
    let metrics = vec![[[4.0, 0.5, 0.0], [0.5, 3.5, 0.1], [0.0, 0.1, 3.0]]; 36];
    for weight in ["cubic", "cubic-interpolating", "wendland-c2"] {
        let element = json!({"slave": [3.4, 2.5, 0.3], "masters": masters, "outward": [0, 0, 1], "weight": weight,
            "first_positions": first, "metrics": metrics});
        let text = json!({"elements": [element]}).to_string();
        let [own, ad] = ["generated", "ad"].map(|backend| {
            let run = run_with_input(&["evaluate", "-", "--backend", backend], &text);
            let answer: Value = serde_json::from_str(&run.stdout).unwrap();
            let answer = answer["elements"][0].clone();
            assert_eq!(answer["status"], "ok", "{answer}");
            let mut all = numbers(&answer["n"]);
            all.extend(rows(&answer["m"]).concat());
            all.push(answer["gap"].as_f64().unwrap());
            all
        });
        assert_eq!(own.len(), ad.len());
        for (a, b) in own.iter().zip(&ad) {
            assert!((a - b).abs() < 1e-11, "{weight}: {a} and {b}");
        }
    }
}
