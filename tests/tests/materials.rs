//! The laws of the solver's materials: emitted kernel, interpreter and automatic differentiation of energies written independently.

use crate::elements::{assert_close, formulas, results_of_graph};
use diffuse_contact_codegen::Mode;
use diffuse_contact_kernels::{isochoric_neo_hooke, support, volumetric_hencky, volumetric_neo_hooke};
use num_dual::{DualNum, HyperDual64};

/// A number with a first derivative by each of two variables, which may be the same.
fn seeded(x: f64, first: bool, second: bool) -> HyperDual64 {
    HyperDual64::new(x, f64::from(u8::from(first)), f64::from(u8::from(second)), 0.0)
}

/// Value, gradient and Hessian of an energy of strains at zero.
fn at_rest(energy: impl Fn([HyperDual64; 6]) -> HyperDual64) -> (f64, [f64; 6], [[f64; 6]; 6]) {
    let by = |i: usize, j: usize| energy(std::array::from_fn(|k| seeded(0.0, k == i, k == j)));
    let gradient = std::array::from_fn(|i| by(i, i).eps1);
    (by(0, 0).re, gradient, std::array::from_fn(|i| std::array::from_fn(|j| by(i, j).eps1eps2)))
}

/// Stretches that differ, that are nearly and exactly equal, and far from one.
#[test]
fn isochoric_neo_hooke_elasticity_has_three_witnesses() {
    let shear_modulus = 0.7;
    for squares in [[1.7, 0.8, 0.5], [1.2, 1.2 + 1e-9, 0.9], [1.0; 3], [30.0, 0.2, 1e-3], [1e40, 1e40, 1e40]]
    {
        let (energy, gradient, hessian) = at_rest(|[x, y, z, yz, zx, xy]| {
            let one = HyperDual64::from(1.0);
            let [a, b, c] = [x, y, z].map(|e| one + e * 2.0);
            let determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * zx) + zx * (xy * yz - b * zx);
            let trace = a * squares[0] + b * squares[1] + c * squares[2];
            let ratio = squares.iter().fold(1.0, |ratio: f64, x| ratio * x.cbrt());
            (trace / (determinant.ln() / 3.0).exp() / ratio - 3.0) * (0.5 * shear_modulus)
        });
        let expected = [
            vec![energy],
            gradient[..3].to_vec(),
            (0..3).flat_map(|i| hessian[i][..3].to_vec()).collect(),
            (3..6).map(|k| hessian[k][k]).collect(),
        ];
        let inputs = isochoric_neo_hooke::Inputs { squares, shear_modulus };
        let found = isochoric_neo_hooke::evaluate(support::Mode::Value, &inputs).values;
        let of_kernel = [
            vec![found.energy],
            found.stress.to_vec(),
            found.normal.as_flattened().to_vec(),
            found.shear.to_vec(),
        ];
        let inputs = [squares[0], squares[1], squares[2], shear_modulus];
        let names = ["energy", "stress", "normal", "shear"];
        let of_graph = results_of_graph(formulas::isochoric_neo_hooke, Mode::Value, &inputs, names);
        for (k, what) in names.into_iter().enumerate() {
            assert_close(&of_kernel[k], &expected[k], what);
            assert_close(&of_graph[k], &expected[k], what);
        }
        // In principal axes normal strains cause no shear stresses.
        assert!(gradient[3..].iter().chain(hessian[..3].iter().flat_map(|row| &row[3..])).all(|&x| x == 0.0));
    }
}

#[test]
fn volumetric_energies_have_three_witnesses() {
    let bulk_modulus = 2.3;
    let names = ["energy", "gradient", "hessian"];
    for volume_ratio in [0.2, 0.999, 1.0, 1.3, 5.0] {
        let theta = seeded(volume_ratio, true, true);
        macro_rules! compare {
            ($kernel:ident, $energy:expr) => {
                let HyperDual64 { re, eps1, eps1eps2, .. } = $energy;
                let inputs = $kernel::Inputs { volume_ratio, bulk_modulus };
                let found = $kernel::evaluate(support::Mode::Hessian, &inputs);
                let of_kernel = [found.values.energy, found.gradient[0], found.hessian[0]];
                let inputs = [volume_ratio, bulk_modulus];
                let of_graph = results_of_graph(formulas::$kernel, Mode::Hessian, &inputs, names);
                for (k, expected) in [re, eps1, eps1eps2].into_iter().enumerate() {
                    assert_close(&[of_kernel[k]], &[expected], stringify!($kernel));
                    assert_close(&of_graph[k], &[expected], stringify!($kernel));
                }
            };
        }
        compare!(volumetric_hencky, theta.ln() * theta.ln() * (0.5 * bulk_modulus));
        compare!(volumetric_neo_hooke, (theta * theta - theta * 2.0 + 1.0) * (0.5 * bulk_modulus));
    }
}
