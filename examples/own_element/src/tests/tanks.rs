//! A step of the coupled tanks.

use diffuse_contact_kernels::support::{Isa, Mode};

use super::elements::tanks;
use super::witnesses::{
    Found, Function, Number, check_by_hyper_dual, check_by_interpreter, difference, interpreted,
};
use crate::four_tanks::{Inputs, Results, batch, evaluate};

const SPLIT: [f64; 2] = [0.7, 0.6];

/// The cost, levels before first, then pumps: √h of each tank by the formula for a quadratic equation, the upper tanks first.
struct Cost(Inputs<f64>);

impl Function for Cost {
    fn at<D: Number>(&self, x: &[D]) -> D {
        let Inputs { area, outlet, target, dt, .. } = self.0;
        let (before, pumps) = x.split_at(4);
        // A s² + dt a √(2g) s = A h before + dt q
        let flow_and_level = |k: usize, inflow: D| {
            let slope = dt * outlet[k] * (2.0 * 9.81_f64).sqrt();
            let known = before[k] * area[k] + inflow * dt;
            let root = ((known * (4.0 * area[k]) + slope * slope).sqrt() - slope) / (2.0 * area[k]);
            (root * (slope / dt), root * root)
        };
        let (third, level_3) = flow_and_level(2, pumps[1] * (1.0 - SPLIT[1]));
        let (fourth, level_4) = flow_and_level(3, pumps[0] * (1.0 - SPLIT[0]));
        let (_, first) = flow_and_level(0, pumps[0] * SPLIT[0] + third);
        let (_, second) = flow_and_level(1, pumps[1] * SPLIT[1] + fourth);
        let levels = [first, second, level_3, level_4];
        let squares =
            levels.into_iter().zip(target).map(|(level, target)| (level - target) * (level - target));
        squares.fold(D::from(0.0), |sum, square| sum + square) * 0.5
    }
}

/// A step dt from levels that a factor tells apart.
fn step(factor: f64, dt: f64) -> Inputs<f64> {
    Inputs {
        before: [0.12, 0.13, 0.02, 0.014].map(|level| factor * level),
        pumps: [3e-6, 2.5e-6],
        area: [2.8e-3, 3.2e-3, 2.8e-3, 3.2e-3],
        outlet: [7.1e-6, 5.7e-6, 7.1e-6, 5.7e-6],
        target: [0.14, 0.12, 0.03, 0.02],
        split: SPLIT,
        dt,
    }
}

#[test]
fn a_step_has_the_derivatives_of_both_witnesses() {
    for inputs in [step(1.0, 20.0), step(1.3, 5.0), step(0.5, 100.0)] {
        let results = evaluate(Mode::Hessian, &inputs);
        assert!(results.values.levels_residual < 1e-12, "{:?}", results.values);
        let found =
            Found { value: results.values.energy, gradient: &results.gradient, hessian: &results.hessian };
        let x = [&inputs.before[..], &inputs.pumps].concat();
        check_by_hyper_dual(&found, &x, &Cost(inputs));
        let all: [&[f64]; 7] = [
            &inputs.before,
            &inputs.pumps,
            &inputs.area,
            &inputs.outlet,
            &inputs.target,
            &inputs.split,
            &[inputs.dt],
        ];
        check_by_interpreter(&found, tanks::four_tanks, &all, &[]);
        let jacobian = interpreted(tanks::four_tanks, &all, &[])("levels_jacobian");
        assert!(difference(&results.levels_jacobian, &jacobian) < 1e-12);
    }
}

#[test]
fn steps_side_by_side_are_those_of_single_tanks() {
    let steps: Vec<_> = (0..11).map(|k| step(0.7 + 0.1 * f64::from(k), 3.0 * f64::from(k + 1))).collect();
    for isa in Isa::available() {
        let mut results = vec![Results::ZERO; steps.len()];
        batch(isa, Mode::Hessian, &steps, &mut results);
        for (found, step) in results.iter().zip(&steps) {
            let single = evaluate(Mode::Hessian, step);
            assert!(difference(&found.gradient, &single.gradient) < 1e-12, "{isa}");
            assert!(difference(&found.hessian, &single.hessian) < 1e-12, "{isa}");
        }
    }
}
