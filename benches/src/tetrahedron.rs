//! A tetrahedron of compressible neo-Hooke material: from its energy by the generator, by hand with nalgebra, and over the dual numbers of
//! num-dual. A hexahedron from its energy.
#![allow(non_snake_case)]

use nalgebra::{Const, Matrix3, U1, Vector3};
use num_dual::{Dual2SVec64, DualNum};

use crate::Random;

include!(concat!(env!("OUT_DIR"), "/diffuse_contact_kernels.rs"));

use tet4::{Inputs, Results};

/// So many different elements, with shapes and deformations at random.
pub fn elements(count: usize) -> Vec<Inputs<f64>> {
    const CORNERS: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut random = Random::seeded(1);
    let mut moved = |x: [[f64; 3]; 4], by: f64| x.map(|x| x.map(|x| x + by * random.signed()));
    (0..count)
        .map(|_| {
            let X = moved(CORNERS, 0.15);
            Inputs { x: moved(X, 0.1), X, lambda: 1.2, mu: 0.8 }
        })
        .collect()
}

/// Energy, gradient and Hessian by the closed form: with G = F⁻ᵀ, V the volume and g_k the gradients of the shape functions,
///
/// P = μ (F − G) + λ ln J G and K_kl = V (μ (g_k·g_l) 1 + λ (G g_k)(G g_l)ᵀ + (μ − λ ln J) (G g_l)(G g_k)ᵀ).
pub fn by_hand(inputs: &Inputs<f64>) -> Results {
    let Inputs { lambda, mu, .. } = *inputs;
    let edges = |x: &[[f64; 3]; 4]| {
        let x = x.map(Vector3::from);
        Matrix3::from_columns(&[x[1] - x[0], x[2] - x[0], x[3] - x[0]])
    };
    let (d, D) = (edges(&inputs.x), edges(&inputs.X));
    let inverse = D.try_inverse().unwrap_or_else(Matrix3::zeros);
    let F = d * inverse;
    let volume = D.determinant() / 6.0;
    let log = F.determinant().ln();
    let G = F.try_inverse().unwrap_or_else(Matrix3::zeros).transpose();

    let mut results = Results::ZERO;
    results.values.energy =
        volume * (0.5 * mu * (F.norm_squared() - 3.0) - mu * log + 0.5 * lambda * log * log);
    let rows = [0, 1, 2].map(|k| inverse.row(k).transpose());
    let g = [-(rows[0] + rows[1] + rows[2]), rows[0], rows[1], rows[2]];
    let stress = volume * (mu * (F - G) + lambda * log * G);
    let q = g.map(|g| G * g);
    let mut place = 0;
    for k in 0..4 {
        let force = stress * g[k];
        let blocks: [Matrix3<f64>; 4] = std::array::from_fn(|l| {
            if l > k {
                return Matrix3::zeros();
            }
            let diagonal = Matrix3::from_diagonal_element(mu * g[k].dot(&g[l]));
            volume
                * (diagonal
                    + lambda * q[k] * q[l].transpose()
                    + (mu - lambda * log) * q[l] * q[k].transpose())
        });
        for row in 0..3 {
            results.gradient[3 * k + row] = force[row];
            for l in 0..=k {
                let columns = if l == k { row + 1 } else { 3 };
                for column in 0..columns {
                    results.hessian[place] = blocks[l][(row, column)];
                    place += 1;
                }
            }
        }
    }
    results
}

/// The energy for numbers of any kind.
fn energy<N: DualNum<Primitive = f64> + Copy>(x: &[[N; 3]; 4], inputs: &Inputs<f64>) -> N {
    let Inputs { X, lambda, mu, .. } = *inputs;
    let D = Matrix3::from_fn(|i, j| X[j + 1][i] - X[0][i]);
    let inverse = D.try_inverse().unwrap_or_else(Matrix3::zeros);
    let d: [[N; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| x[j + 1][i] - x[0][i]));
    let F = d
        .map(|d| [0, 1, 2].map(|j| d[0] * inverse[(0, j)] + d[1] * inverse[(1, j)] + d[2] * inverse[(2, j)]));
    let minor = |i: usize, j: usize| F[1][i] * F[2][j] - F[1][j] * F[2][i];
    let log = (F[0][0] * minor(1, 2) - F[0][1] * minor(0, 2) + F[0][2] * minor(0, 1)).ln();
    let trace = F.as_flattened().iter().fold(N::from(0.0), |trace, &f| trace + f * f);
    ((trace - 3.0) * (0.5 * mu) - log * mu + log * log * (0.5 * lambda)) * (D.determinant() / 6.0)
}

/// Energy, gradient and Hessian by one evaluation over numbers with a gradient of 12 entries and a Hessian of 144.
pub fn by_dual_numbers(inputs: &Inputs<f64>) -> Results {
    let seed = |k: usize, i: usize| Dual2SVec64::<12>::from_re(inputs.x[k][i]).derivative(3 * k + i);
    let x = [0, 1, 2, 3].map(|k| [0, 1, 2].map(|i| seed(k, i)));
    let energy = energy(&x, inputs);
    let mut results = Results::ZERO;
    results.values.energy = energy.re;
    results.gradient.copy_from_slice(energy.v1.unwrap_generic(U1, Const::<12>).as_slice());
    let hessian = energy.v2.unwrap_generic(Const::<12>, Const::<12>);
    let places = (0..12).flat_map(|i| (0..=i).map(move |j| (i, j)));
    results.hessian.iter_mut().zip(places).for_each(|(entry, place)| *entry = hessian[place]);
    results
}

/// So many different hexahedra, with shapes and deformations at random.
pub fn hexahedra(count: usize) -> Vec<hex8::Inputs<f64>> {
    let mut random = Random::seeded(2);
    let corner = |k: usize| [k & 1 ^ (k >> 1 & 1), k >> 1 & 1, k >> 2].map(|x| 2.0 * x as f64 - 1.0);
    let mut moved = |x: [[f64; 3]; 8], by: f64| x.map(|x| x.map(|x| x + by * random.signed()));
    (0..count)
        .map(|_| {
            let X = moved(std::array::from_fn(corner), 0.15);
            hex8::Inputs { x: moved(X, 0.1), X, lambda: 1.2, mu: 0.8 }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use diffuse_contact_kernels::support::Mode;

    use super::*;

    #[test]
    fn the_element_by_hand_and_over_dual_numbers_is_the_generated_one() {
        for element in elements(50) {
            let expected = tet4::evaluate(Mode::Hessian, &element);
            for found in [by_hand(&element), by_dual_numbers(&element)] {
                let pairs = found
                    .gradient
                    .iter()
                    .chain(&found.hessian)
                    .zip(expected.gradient.iter().chain(&expected.hessian));
                for (x, y) in pairs.chain([(&found.values.energy, &expected.values.energy)]) {
                    assert!((x - y).abs() < 1e-12, "{x} {y}");
                }
            }
        }
    }

    #[test]
    fn no_hexahedron_is_turned_inside_out() {
        for element in hexahedra(50) {
            assert!(hex8::evaluate(Mode::Value, &element).values.energy > 0.0);
        }
    }
}
