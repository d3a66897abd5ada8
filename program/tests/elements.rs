//! Elements as `evaluate` reads them, and numbers as it writes them.

use serde_json::{Value, json};

/// Nine nodes of a plane grid with spacing 1, and a slave over them.
pub fn plane(slave: [f64; 3]) -> Value {
    let masters: Vec<[f64; 3]> = (0..9).map(|k| [f64::from(k % 3), f64::from(k / 3), 0.0]).collect();
    json!({"slave": slave, "masters": masters, "outward": [0, 0, 1]})
}

/// The same with two nodes out of the plane.
pub fn bent(slave: [f64; 3]) -> Value {
    let mut element = plane(slave);
    element["masters"][4] = json!([1.0, 1.1, 0.2]);
    element["masters"][7] = json!([1.0, 2.0, -0.1]);
    element
}

pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

pub fn rows(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}
