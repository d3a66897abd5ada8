//! First derivatives at the foot, as combinations of the rows that the factors of M hold (docs/equations.md, section 11).
//!
//! Whatever is a function of the unknowns changes along the rows b only. A kernel that is asked for
//! [`SecondKind::FactorsAndFoot`](super::SecondKind) leaves a coefficient for each product of the form: for x, y and z of the normal, and
//! for the height of the surface over the foot; then the normal n̂ of the frame.

use super::FormRows;

/// Where first derivatives at the foot go.
#[derive(Debug)]
pub struct AtFoot<'a> {
    /// φ, a number for each master: the foot is Σ φ_k x_k.
    pub weights: &'a mut [f64],
    /// ∂ν/∂x, a row of 3(n+1) entries for each component, the slave's first, 1/length.
    pub normal: &'a mut [f64],
}

impl FormRows {
    /// First derivatives at the foot, from the numbers of a kernel that was asked for factors and foot.
    ///
    /// # Panics
    /// If a slice is too short.
    pub fn foot_derivatives(self, numbers: &[f64], target: AtFoot<'_>) {
        let (factors, foot) = numbers.split_at(self.factors());
        let products = (self.varying + self.constant) / 2;
        let (combinations, frame_normal) = foot[..self.foot_numbers()].split_at(Self::FOOT * products);
        let constant = &factors[self.node_factors() * self.count..];
        let freedoms = 3 * (self.count + 1);
        let normal = &mut target.normal[..3 * freedoms];
        let weights = &mut target.weights[..self.count];
        for row in normal.chunks_exact_mut(freedoms) {
            row[..3].fill(0.0);
        }
        for node in 0..self.count {
            let own = &factors[self.node_factors() * node..];
            // Of each product the row b, then the row c.
            let along = |quantity: usize, axis: usize| -> f64 {
                let (varying, same) =
                    combinations[products * quantity..][..products].split_at(self.varying / 2);
                let varying = varying.iter().zip(own[self.varying * axis..].iter().step_by(2));
                let same = same.iter().zip(constant[self.constant * axis..].iter().step_by(2));
                varying.chain(same).map(|(c, b)| c * b).sum()
            };
            for (component, row) in normal.chunks_exact_mut(freedoms).enumerate() {
                for axis in 0..3 {
                    let entry = along(component, axis);
                    row[3 * (node + 1) + axis] = entry;
                    // Translations change nothing.
                    row[axis] -= entry;
                }
            }
            weights[node] = (0..3).map(|axis| frame_normal[axis] * along(3, axis)).sum();
        }
    }
}
