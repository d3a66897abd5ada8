//! The arm's tip.

use diffuse_contact_kernels::support::Mode;

use super::elements::arm;
use super::witnesses::{
    Found, Function, Number, check_by_hyper_dual, check_by_interpreter, difference, interpreted,
};
use crate::seven_axes::{Inputs, evaluate};

/// A component of the tip in a direction, by products of 4 × 4 matrices from the foot on.
struct Component([f64; 3]);

impl Function for Component {
    fn at<D: Number>(&self, angles: &[D]) -> D {
        let (zero, one) = (D::from(0.0), D::from(1.0));
        let offsets = [0.34, 0.0, 0.4, 0.0, 0.4, 0.0, 0.126];
        let turns = [-90_f64, 90.0, 90.0, -90.0, -90.0, 90.0, 0.0];
        let mut pose: [[D; 4]; 4] =
            [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| if i == j { one } else { zero }));
        for (k, &angle) in angles.iter().enumerate() {
            let (c, s) = (angle.cos(), angle.sin());
            let (ca, sa) = (turns[k].to_radians().cos(), turns[k].to_radians().sin());
            let link = [
                [c, -s * ca, s * sa, zero],
                [s, c * ca, -c * sa, zero],
                [zero, one * sa, one * ca, one * offsets[k]],
                [zero, zero, zero, one],
            ];
            pose =
                pose.map(|row| [0, 1, 2, 3].map(|j| (0..4).fold(zero, |sum, k| sum + row[k] * link[k][j])));
        }
        pose[0][3] * self.0[0] + pose[1][3] * self.0[1] + pose[2][3] * self.0[2]
    }
}

#[test]
fn the_tip_has_the_derivatives_of_both_witnesses() {
    let angle = [0.3, -0.7, 1.1, 0.9, -0.4, 0.6, 0.2];
    for direction in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.3, -0.8, 0.5]] {
        let results = evaluate(Mode::Hessian, &Inputs { angle, direction });
        let found =
            Found { value: results.values.energy, gradient: &results.gradient, hessian: &results.hessian };
        check_by_hyper_dual(&found, &angle, &Component(direction));
        check_by_interpreter(&found, arm::seven_axes, &[&angle, &direction], &[]);
        let jacobian = interpreted(arm::seven_axes, &[&angle, &direction], &[])("position_jacobian");
        assert!(difference(&results.position_jacobian, &jacobian) < 1e-12);
        // Rows of the Jacobian add up to the gradient.
        let rows: Vec<f64> = (0..7)
            .map(|j| (0..3).map(|i| direction[i] * results.position_jacobian[7 * i + j]).sum())
            .collect();
        assert!(difference(&results.gradient, &rows) < 1e-14);
    }
    // Stretched upwards.
    let straight = evaluate(Mode::Value, &Inputs { angle: [0.0; 7], direction: [0.0; 3] });
    assert!((straight.values.position[2] - 1.266).abs() < 1e-15);
}
