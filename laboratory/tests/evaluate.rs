//! Runs the program's `evaluate`, by both backends.

use serde_json::{Value, json};

use crate::elements::{bent, numbers, rows};
use crate::runs::run_with_input;

#[test]
fn both_backends_agree_on_either_frame() {
    let frames = ["frozen", "co-moving"];
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
