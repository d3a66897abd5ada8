//! The chain of links.

use diffuse_contact_kernels::support::Mode;

use super::elements::joint;
use super::witnesses::{Found, Function, Number, check_by_hyper_dual, check_by_interpreter};
use crate::chain::{Inputs, evaluate};

/// The energy by the moments in the joints: each spring turns by the moment of the force about it, from the foot on, again and again.
struct Energy(Inputs<f64>);

impl Function for Energy {
    fn at<D: Number>(&self, force: &[D]) -> D {
        let Inputs { length, stiffness, .. } = self.0;
        let mut angle = [D::from(0.0); 5];
        for _ in 0..400 {
            let mut turned = D::from(0.0);
            let before = angle;
            for k in 0..5 {
                // From the joint to the tip.
                let arm =
                    (k..5).fold([D::from(0.0); 2], |[x, y], j| [x + before[j].cos(), y + before[j].sin()]);
                let moment = (force[1] * arm[0] - force[0] * arm[1]) * length;
                turned += moment / stiffness[k];
                angle[k] = (turned + angle[k]) * 0.5;
            }
        }
        let mut energy = D::from(0.0);
        for k in 0..5 {
            let turn = if k == 0 { angle[0] } else { angle[k] - angle[k - 1] };
            energy += turn * turn * (0.5 * stiffness[k]);
            energy -= (force[0] * angle[k].cos() + force[1] * angle[k].sin()) * length;
        }
        energy
    }
}

#[test]
fn an_equilibrium_has_the_derivatives_of_both_witnesses() {
    for force in [[0.4, 0.7], [0.1, -0.5], [-0.2, 0.3]] {
        let inputs = Inputs { force, length: 0.3, stiffness: [2.0, 1.5, 1.0, 0.7, 0.5], start: [0.1; 5] };
        let results = evaluate(Mode::Hessian, &inputs);
        assert!(results.values.angles_residual < 1e-12, "{:?}", results.values);
        let found =
            Found { value: results.values.energy, gradient: &results.gradient, hessian: &results.hessian };
        check_by_hyper_dual(&found, &force, &Energy(inputs));
        let all: [&[f64]; 4] = [&force, &[inputs.length], &inputs.stiffness, &inputs.start];
        check_by_interpreter(&found, joint::chain, &all, &[]);
        // The gradient is minus the tip's position.
        let tip: [f64; 2] = results.values.angles.iter().fold([0.0; 2], |[x, y], angle| {
            [x + inputs.length * angle.cos(), y + inputs.length * angle.sin()]
        });
        assert!((0..2).all(|k| (results.gradient[k] + tip[k]).abs() < 1e-12), "{tip:?}");
    }
}
