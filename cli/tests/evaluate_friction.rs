//! `evaluate` of elements with an anchor: the slip and Coulomb's friction.

use diffuse_contact::ad::Ad;
use diffuse_contact::{Backend, Element, ElementError, Frame, Generated, Mode, Point, Slip};
use serde_json::{Value, json};

use crate::elements::{bent, numbers, rows};
use crate::evaluate::evaluate;

const PENALTY: f64 = 50.0;
const STIFFNESS: f64 = 30.0;
const RADIUS: f64 = 2.1;
const SLAVE: Point = [1.1, 0.9, 0.05];
const ANCHOR: Point = [1.02, 0.93, 0.14];
/// 3(n + 2) of nine masters.
const FREEDOMS: usize = 33;

/// The bent element with an anchor, and with friction of this coefficient.
fn with_friction(slave: Point, coefficient: f64) -> Value {
    let mut element = bent(slave);
    element["support_radius"] = json!(RADIUS);
    element["penalty"] = json!(PENALTY);
    element["anchor"] = json!(ANCHOR);
    element["friction"] = json!({"coefficient": coefficient, "stiffness": STIFFNESS});
    element
}

/// The same element by the library.
fn slip_by(backend: &dyn Backend) -> Result<Slip, ElementError> {
    let masters: Vec<Point> =
        rows(&bent(SLAVE)["masters"]).iter().map(|x| [0, 1, 2].map(|axis| x[axis])).collect();
    let frame = Frame::average_plane(&masters, [0.0, 0.0, 1.0])?;
    backend.slip(&Element::new(SLAVE, &masters, frame, RADIUS), ANCHOR, Mode::Hessian)
}

/// Whether this build has kernels of friction.
fn has_kernels() -> bool {
    slip_by(&Generated) != Err(ElementError::NoFrictionKernels)
}

/// The numbers are those expected, over the largest of them.
#[track_caller]
fn assert_alike(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    let size = expected.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    let difference = found.iter().zip(expected).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    assert!(size > 0.0 && difference <= 1e-12 * size, "{difference:e} of {size:e}");
}

fn numbers_of_rows(value: &Value) -> Vec<f64> {
    let rows = rows(value);
    assert!(rows.iter().all(|row| row.len() == rows.len()));
    rows.concat()
}

#[test]
fn an_anchor_gives_the_slip() {
    let answer = &evaluate(json!([with_friction(SLAVE, 0.3)]))[0];
    if !has_kernels() {
        assert_eq!((&answer["status"], &answer["code"]), (&json!("error"), &json!("no-friction-kernels")));
        return;
    }
    let expected = slip_by(&Ad).unwrap();
    let (slip, gradient) = (&answer["slip"], numbers(&answer["slip"]["gradient"]));
    assert_eq!((gradient.len(), rows(&slip["hessian"]).len()), (FREEDOMS, FREEDOMS));
    assert_alike(&[slip["q"].as_f64().unwrap()], &[expected.half_square]);
    assert_alike(&gradient, &expected.gradient);
    assert_alike(&numbers_of_rows(&slip["hessian"]), &expected.hessian.to_rows().concat());
    assert_alike(&numbers(&slip["foot_weights"]), &expected.foot_weights);
    // Slave, masters, anchor: what the anchor has, slave and masters balance.
    for axis in 0..3 {
        let along: Vec<f64> = gradient.iter().skip(axis).step_by(3).copied().collect();
        assert!(along.iter().sum::<f64>().abs() < 1e-14, "{along:?}");
    }
    // Without an anchor the other numbers are the same.
    let without = &evaluate(json!([without(&["anchor", "friction"])]))[0];
    assert_eq!((&without["slip"], &without["friction"]), (&Value::Null, &Value::Null));
    for field in ["gap", "n", "m", "force", "tangent"] {
        assert_eq!(without[field], answer[field], "{field}");
    }
}

fn without(fields: &[&str]) -> Value {
    let mut element = with_friction(SLAVE, 0.3);
    fields.iter().for_each(|field| drop(element.as_object_mut().unwrap().remove(*field)));
    element
}

/// c, ∂c/∂q and ∂c/∂g by the law as docs/equations.md has it.
fn factors(slip: &Slip, coefficient: f64) -> [f64; 3] {
    let (s, p) = (slip.length(), -PENALTY * slip.contact.gap);
    if STIFFNESS * s <= coefficient * p {
        [STIFFNESS, 0.0, 0.0]
    } else {
        [coefficient * p / s, -coefficient * p / s.powi(3), -coefficient * PENALTY / s]
    }
}

#[test]
fn friction_sticks_or_slides_with_its_tangent() {
    if !has_kernels() {
        return;
    }
    let slip = slip_by(&Ad).unwrap();
    assert!(slip.contact.is_penetrating());
    for (coefficient, state) in [(2.0, "stick"), (0.05, "slip")] {
        let answer = &evaluate(json!([with_friction(SLAVE, coefficient)]))[0];
        let friction = &answer["friction"];
        assert_eq!(friction["state"], state, "{answer}");
        let [c, by_q, by_g] = factors(&slip, coefficient);
        let force: Vec<f64> = slip.gradient.iter().map(|x| -c * x).collect();
        assert_alike(&numbers(&friction["force"]), &force);
        // K = c ∇²q + ∇q (∂c/∂q ∇q + ∂c/∂g N)ᵀ; the gap does not depend on the anchor.
        let hessian = slip.hessian.to_rows();
        let n = |j: usize| slip.contact.gradient.get(j).copied().unwrap_or(0.0);
        let entry = |i: usize, j: usize| {
            c * hessian[i][j] + slip.gradient[i] * (by_q * slip.gradient[j] + by_g * n(j))
        };
        let entries = (0..FREEDOMS).flat_map(|i| (0..FREEDOMS).map(move |j| (i, j)));
        let expected: Vec<f64> = entries.map(|(i, j)| entry(i, j)).collect();
        let found = rows(&friction["tangent"]);
        assert_alike(&numbers_of_rows(&friction["tangent"]), &expected);
        let asymmetry = (0..FREEDOMS).map(|j| (found[0][j] - found[j][0]).abs()).fold(0.0, f64::max);
        assert_eq!(asymmetry > 1e-3, state == "slip", "{asymmetry:e}");
    }
    let apart = &evaluate(json!([with_friction([1.1, 0.9, 0.4], 0.3)]))[0];
    assert_eq!((&apart["active"], &apart["friction"]["state"]), (&json!(false), &json!("open")));
    assert_eq!(numbers(&apart["friction"]["force"]), [0.0; FREEDOMS]);
}

/// A limit below μ p is what slides.
#[test]
fn a_shear_limit_holds() {
    if !has_kernels() {
        return;
    }
    let slip = slip_by(&Ad).unwrap();
    let mut element = with_friction(SLAVE, 2.0);
    let limit = 0.5 * STIFFNESS * slip.length();
    element["friction"]["shear_limit"] = json!(limit);
    let friction = &evaluate(json!([element]))[0]["friction"];
    assert_eq!(friction["state"], "slip");
    let force: Vec<f64> = slip.gradient.iter().map(|x| -limit / slip.length() * x).collect();
    assert_alike(&numbers(&friction["force"]), &force);
}

#[test]
fn friction_without_an_anchor_or_a_law_is_refused() {
    let changed = |field: &str, value: f64| {
        let mut element = with_friction(SLAVE, 0.3);
        element["friction"][field] = json!(value);
        element
    };
    let missing = &evaluate(json!([without(&["anchor"])]))[0];
    assert_eq!((&missing["status"], &missing["code"]), (&json!("error"), &json!("missing-anchor")));
    assert!(missing["message"].as_str().unwrap().starts_with("`anchor` is missing: "), "{missing}");
    let kernels = has_kernels();
    for (element, code) in [
        (changed("coefficient", -0.1), "invalid-friction-coefficient"),
        (changed("stiffness", 0.0), "invalid-friction-stiffness"),
        (changed("shear_limit", -1.0), "invalid-shear-limit"),
    ] {
        let answer = &evaluate(json!([element]))[0];
        let expected = if kernels { code } else { "no-friction-kernels" };
        assert_eq!((&answer["status"], &answer["code"]), (&json!("error"), &json!(expected)), "{answer}");
    }
}
