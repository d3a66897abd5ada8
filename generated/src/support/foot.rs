//! First derivatives at the foot, as combinations of the rows that the factors of M hold (docs/equations.md, section 11).
//!
//! Whatever is a function of the unknowns changes along the rows b only. A kernel that is asked for
//! [`SecondKind::FactorsAndFoot`](super::SecondKind) leaves a coefficient for each product of the form: for x, y and z of the normal, and
//! for the height of the surface over the foot; then the normal n̂ of the frame.

use super::form::write;
use super::second::MOST_ROWS;
use super::{FormRows, Lane};

impl FormRows {
    /// Numbers of the derivatives at the foot: φ and ∂ν/∂x.
    #[inline(always)]
    pub const fn foot_numbers(self) -> usize {
        self.count + 9 * (self.count + 1)
    }

    /// First derivatives at the foot, of what a kernel leaves that was asked for factors and foot: φ, a number for each master, so that
    /// the foot is Σ φ_k x_k; then ∂ν/∂x, a row of 3(n+1) entries for each component, the slave's first, 1/length.
    ///
    /// # Panics
    /// If a slice is too short, or there are more than 64 rows.
    #[inline(always)]
    pub(super) fn foot_derivatives<T: Lane>(self, factors: &[T], target: &mut [T]) {
        let coefficients = &factors[self.factors()..][..self.foot_coefficients()];
        // Of each product the four coefficients side by side.
        let mut of_products = [[T::ZERO; Self::FOOT]; MOST_ROWS / 2];
        let products = self.rows / 2;
        for product in 0..products {
            for quantity in 0..Self::FOOT {
                of_products[product][quantity] = coefficients[products * quantity + product];
            }
        }
        let frame_normal = &coefficients[Self::FOOT * products..];
        let freedoms = 3 * (self.count + 1);
        let (weights, normal) = target[..self.foot_numbers()].split_at_mut(self.count);
        let mut slave = [[T::ZERO; 3]; 3];
        for node in 0..self.count {
            let own = &factors[self.node_factors() * node..];
            let mut weight = T::ZERO;
            for axis in 0..3 {
                let mut sums = [T::ZERO; Self::FOOT];
                add_rows(&of_products[..products], &own[self.rows * axis..], &mut sums);
                for component in 0..3 {
                    normal[freedoms * component + 3 * (node + 1) + axis] = sums[component];
                    // Translations change nothing.
                    slave[component][axis] = slave[component][axis] - sums[component];
                }
                weight = frame_normal[axis].mul_add(sums[3], weight);
            }
            weights[node] = weight;
        }
        for component in 0..3 {
            write(slave[component], normal, freedoms * component);
        }
    }

    /// [`foot_derivatives`](Self::foot_derivatives) of one element: compiled once, not for every kernel.
    #[inline(never)]
    pub(super) fn foot_derivatives_of_one(self, factors: &[f64], target: &mut [f64]) {
        self.foot_derivatives(factors, target);
    }

    /// Numbers that follow the [factors](Self::factors) where the foot is asked for too: four for each product, and n̂.
    #[inline(always)]
    pub(super) const fn foot_coefficients(self) -> usize {
        Self::FOOT * (self.rows / 2) + 3
    }

    /// Quantities that are combined from rows: x, y and z of the normal, and the height.
    const FOOT: usize = 4;
}

/// Adds the combinations of the rows b, each of which a row c follows.
#[inline(always)]
fn add_rows<T: Lane, const QUANTITIES: usize>(
    coefficients: &[[T; QUANTITIES]],
    rows: &[T],
    sums: &mut [T; QUANTITIES],
) {
    for product in 0..coefficients.len() {
        let b = rows[2 * product];
        for quantity in 0..QUANTITIES {
            sums[quantity] = coefficients[product][quantity].mul_add(b, sums[quantity]);
        }
    }
}
