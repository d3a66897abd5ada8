//! A tetrahedron of compressible neo-Hooke material: from its energy by the generator, and by hand with nalgebra.
#![allow(non_snake_case)]

use nalgebra::{Matrix3, Vector3};

use crate::Random;

include!(concat!(env!("OUT_DIR"), "/diffuse_contact_kernels.rs"));

use tet4::{Inputs, Results};

/// So many different elements, with shapes and deformations at random.
#[must_use]
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
#[must_use]
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

#[cfg(test)]
mod tests {
    use diffuse_contact_kernels::support::Mode;

    use super::*;

    #[test]
    fn the_element_by_hand_is_the_generated_one() {
        for element in elements(50) {
            let (found, expected) = (by_hand(&element), tet4::evaluate(Mode::Hessian, &element));
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
