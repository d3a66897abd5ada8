//! The cohesive law.

use diffuse_contact_kernels::support::{Isa, Mode};
use num_dual::{DualNum, HyperDual};

use super::elements;
use super::witnesses::{difference, interpreted};
use crate::cohesive;

/// Traction (1 − d) k δ with the damage d = max(1 − exp(−|δ|/l), d before), with one of its components.
fn traction(opening: [HyperDual<f64>; 3], axis: usize, before: f64) -> (HyperDual<f64>, HyperDual<f64>) {
    let norm = (opening[0] * opening[0] + opening[1] * opening[1] + opening[2] * opening[2]).sqrt();
    let now = -(-norm / 0.7).exp() + 1.0;
    let damage = if now.re < before { HyperDual::from(before) } else { now };
    ((-damage + 1.0) * opening[axis] * 3.0, damage)
}

#[test]
fn a_cohesive_law_has_its_jacobian_and_its_new_state_in_all_lanes() {
    let law = |k: i32| {
        let opening = [0.1 * f64::from(k), -0.2, 0.05 * f64::from(k)];
        cohesive::Inputs { opening, stiffness: 3.0, length: 0.7, damage_before: 0.5 }
    };
    let laws: Vec<_> = (0..11).map(law).collect();
    for isa in Isa::available() {
        let mut results = vec![cohesive::Results::ZERO; laws.len()];
        // There is no Hessian: all derivatives there are.
        cohesive::batch(isa, Mode::Hessian, &laws, &mut results);
        for (law, found) in laws.iter().zip(&results) {
            let [stiffness, length, before] = [[law.stiffness], [law.length], [law.damage_before]];
            let inputs: [&[f64]; 4] = [&law.opening, &stiffness, &length, &before];
            let expected = interpreted(elements::cohesive::exponential, &inputs, &[]);
            assert!(difference(&found.values.traction, &expected("traction")) < 1e-12);
            assert!(difference(&found.traction_jacobian, &expected("traction_jacobian")) < 1e-12);
            for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
                let seeded =
                    |k: usize| HyperDual::new(law.opening[k], f64::from(u8::from(k == column)), 0.0, 0.0);
                let (traction, damage) = traction([0, 1, 2].map(seeded), row, law.damage_before);
                assert!((found.values.traction[row] - traction.re).abs() < 1e-14);
                assert!((found.values.damage - damage.re).abs() < 1e-15);
                assert!((found.traction_jacobian[3 * row + column] - traction.eps1).abs() < 1e-12);
            }
        }
    }
    let damages: Vec<f64> =
        laws.iter().map(|law| cohesive::evaluate(Mode::Value, law).values.damage).collect();
    assert!(damages[0] == 0.5 && damages[10] > 0.5, "both branches");
}
