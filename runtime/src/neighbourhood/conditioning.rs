//! How well a set of nodes carries the fit, from the moment matrix A of Chamoret et al. (2008), eq. 13, with the
//! cubic weight (14).

use super::TOLERANCE;
use super::hull::Point2;
use crate::Basis;
use crate::eigen::extreme_eigenvalues;

/// A moment matrix. Only the upper triangle is filled.
type Matrix6 = [[f64; 6]; 6];

/// Eigenvalues below this fraction of the largest are rounding.
const EIGENVALUE_ROUNDING: f64 = 1e-15;

/// The regularity of a set of nodes for both bases: see [`regularity`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Regularity {
    /// For the linear basis.
    pub linear: f64,
    /// For the quadratic basis.
    pub quadratic: f64,
}

impl Regularity {
    /// For this basis.
    pub const fn of(self, basis: Basis) -> f64 {
        match basis {
            Basis::Linear => self.linear,
            Basis::Quadratic => self.quadratic,
            // Refused by `SearchOptions::check`.
            Basis::Custom(_) => 0.0,
        }
    }

    /// The larger of each.
    pub fn max(self, other: Self) -> Self {
        Self { linear: self.linear.max(other.linear), quadratic: self.quadratic.max(other.quadratic) }
    }
}

/// How well nodes at these in-plane offsets from the slave carry a fit, from 0 (not at all) to 1.
///
/// The smallest eigenvalue of the moment matrix of (1, x, y, x², √2 xy, y²), where (x, y) = L⁻¹(a, b) is chosen such
/// that the weighted nodes have unit second moments about the slave, and the constant, the linear and the quadratic
/// block each are divided by their mean diagonal. Neither a rotation nor a uniform stretch of the nodes changes it,
/// whereas the relative pivots of A depend on both: a pivot of nodes on the two axes (ab = 0, a conic) consists of
/// rounding only, and so does the diagonal entry it is compared with.
pub fn regularity(offsets: impl Iterator<Item = Point2> + Clone, support_radius: f64) -> Regularity {
    weighted_regularity(offsets.map(|offset| {
        let [a, b] = offset.map(|x| x / support_radius);
        (a.hypot(b), a, b)
    }))
}

/// The same of nodes at these distances in their own domains, with in-plane offsets in any unit.
pub fn weighted_regularity(nodes: impl Iterator<Item = (f64, f64, f64)> + Clone) -> Regularity {
    let weighted = nodes.filter_map(|(distance, a, b)| {
        let weight = weight(distance);
        (weight > 0.0).then_some((weight, a, b))
    });
    let [mut count, mut total, mut aa, mut ab, mut bb] = [0.0; 5];
    for (w, a, b) in weighted.clone() {
        count += 1.0;
        total += w;
        aa += w * a * a;
        ab += w * a * b;
        bb += w * b * b;
    }
    // The longer of the two axes first, so that a stretch along it does not cost digits.
    let swap = bb > aa;
    let (long, short) = if swap { (bb, aa) } else { (aa, bb) };
    let l_11 = (long / total).sqrt();
    let l_21 = ab / total / l_11;
    let l_22 = (short / total - l_21 * l_21).max(0.0).sqrt();
    if !(l_22 > TOLERANCE * l_11) {
        return Regularity::default();
    }
    let mut moments = Matrix6::default();
    for (w, a, b) in weighted {
        let (long, short) = if swap { (b, a) } else { (a, b) };
        let x = long / l_11;
        let y = (short - l_21 * x) / l_22;
        add_square(&mut moments, w / total, [1.0, x, y, x * x, x * y * std::f64::consts::SQRT_2, y * y]);
    }
    let scale = ((moments[3][3] + moments[4][4] + moments[5][5]) / 3.0).sqrt();
    let scales = [1.0, 1.0, 1.0, scale, scale, scale];
    for (row, x) in moments.iter_mut().zip(scales) {
        for (entry, y) in row.iter_mut().zip(scales) {
            *entry /= x * y;
        }
    }
    let with_nodes = |needed: f64, (smallest, largest): (f64, f64)| {
        if count < needed || smallest <= EIGENVALUE_ROUNDING * largest { 0.0 } else { smallest }
    };
    Regularity {
        linear: with_nodes(3.0, extreme_eigenvalues(linear_block(&moments))),
        quadratic: with_nodes(6.0, extreme_eigenvalues(moments)),
    }
}

/// The moment matrix itself: offsets divided by the support radius, quadratic basis; that of the linear one is its
/// leading 3×3 block.
#[derive(Clone, Copy, Debug)]
pub struct Moments(Matrix6);

impl Moments {
    /// Of nodes at these in-plane offsets from the slave.
    pub fn new(offsets: impl Iterator<Item = Point2>, support_radius: f64) -> Self {
        let mut moments = Matrix6::default();
        for offset in offsets {
            let [a, b] = offset.map(|x| x / support_radius);
            add_square(&mut moments, weight(a.hypot(b)), [1.0, a, b, a * a, a * b, b * b]);
        }
        Self(moments)
    }

    /// Smallest pivot of the Cholesky factorisation over the diagonal entry it came from; 0 if the factorisation
    /// breaks down.
    pub fn pivot_ratio(&self, basis: Basis) -> f64 {
        let mut lower = Matrix6::default();
        let mut smallest = f64::INFINITY;
        for i in 0..basis.size() {
            for j in 0..i {
                let rest = self.0[j][i] - (0..j).map(|k| lower[i][k] * lower[j][k]).sum::<f64>();
                lower[i][j] = rest / lower[j][j];
            }
            let pivot = self.0[i][i] - (0..i).map(|k| lower[i][k] * lower[i][k]).sum::<f64>();
            let ratio = pivot / self.0[i][i];
            if !(ratio > 0.0) {
                return 0.0;
            }
            smallest = smallest.min(ratio);
            lower[i][i] = pivot.sqrt();
        }
        smallest
    }

    /// Largest over smallest eigenvalue; infinite if the matrix is singular to rounding.
    pub fn condition(&self, basis: Basis) -> f64 {
        let (smallest, largest) = match basis {
            Basis::Linear => extreme_eigenvalues(linear_block(&self.0)),
            Basis::Quadratic => extreme_eigenvalues(self.0),
            Basis::Custom(_) => return f64::INFINITY,
        };
        if smallest > EIGENVALUE_ROUNDING * largest { largest / smallest } else { f64::INFINITY }
    }
}

/// The cubic weight (14) at distance r, in support radii.
fn weight(r: f64) -> f64 {
    if r < 1.0 { 1.0 - r * r * (3.0 - 2.0 * r) } else { 0.0 }
}

/// Adds w p pᵀ to the upper triangle.
fn add_square(moments: &mut Matrix6, w: f64, p: [f64; 6]) {
    for i in 0..6 {
        for j in i..6 {
            moments[i][j] += w * p[i] * p[j];
        }
    }
}

fn linear_block(moments: &Matrix6) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| moments[i][j]))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn circle(nodes: u32) -> Vec<Point2> {
        (0..nodes).map(|k| f64::from(k) * TAU / f64::from(nodes)).map(|t| [t.cos(), t.sin()]).collect()
    }

    /// Offsets turned by an angle.
    fn turned(offsets: &[Point2], angle: f64) -> Vec<Point2> {
        let (sin, cos) = angle.sin_cos();
        offsets.iter().map(|[a, b]| [a * cos - b * sin, a * sin + b * cos]).collect()
    }

    /// Of offsets inside a radius that does not bite, so that stretching them does not change the weights much.
    fn of(offsets: &[Point2], support_radius: f64) -> Regularity {
        regularity(offsets.iter().copied(), support_radius)
    }

    #[test]
    fn nodes_on_a_conic_carry_a_linear_fit_only() {
        let cross: Vec<Point2> = (-3..=3).map(f64::from).flat_map(|x| [[x, 0.0], [0.0, x]]).collect();
        let rows: Vec<Point2> = (-3..=3).map(f64::from).flat_map(|x| [[x, 0.4], [x, -0.6]]).collect();
        for (conic, support_radius) in [(circle(8), 1.25), (cross, 4.0), (rows, 4.0)] {
            for turn in [0.0, 1e-9, 0.4, 1.0, 1.3] {
                let regularity = of(&turned(&conic, turn), support_radius);
                assert!(regularity.linear > 0.8 && regularity.quadratic < 1e-14, "{regularity:?}");
                let moments = Moments::new(turned(&conic, turn).into_iter(), support_radius);
                assert!(moments.condition(Basis::Linear) < 1e3);
                assert!(moments.condition(Basis::Quadratic) > 1e14);
            }
        }
    }

    #[test]
    fn neither_rotation_nor_stretch_changes_the_regularity() {
        let block: Vec<Point2> = (0..16)
            .map(|k| [f64::from(k % 4) - 1.2, f64::from(k / 4) - 1.7 + 0.1 * f64::from(k % 3)])
            .collect();
        let expected = of(&block, 1e6);
        assert!(expected.quadratic > 0.05 && expected.linear > expected.quadratic, "{expected:?}");
        for stretch in [1.0, 3.0, 1e2, 1e4] {
            let stretched: Vec<Point2> = block.iter().map(|[a, b]| [a * stretch, *b]).collect();
            for turn in [0.0, 0.3, 0.785, 1.5, 2.9] {
                let found = of(&turned(&stretched, turn), 1e9);
                assert!(
                    (found.quadratic / expected.quadratic - 1.0).abs() < 1e-3,
                    "{stretch} {turn} {found:?}"
                );
                assert!((found.linear / expected.linear - 1.0).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn nodes_on_a_line_or_out_of_reach_carry_nothing() {
        let line: Vec<Point2> = (0..9).map(|k| [0.3 * f64::from(k), 0.1 * f64::from(k) - 0.2]).collect();
        assert_eq!(of(&line, 4.0), Regularity::default());
        assert_eq!(of(&circle(8), 1.0), Regularity::default());
        assert_eq!(of(&[], 1.0), Regularity::default());
        let moments = Moments::new(circle(8).into_iter(), 1.0);
        assert_eq!(moments.pivot_ratio(Basis::Linear), 0.0);
        assert_eq!(moments.condition(Basis::Linear), f64::INFINITY);
    }

    #[test]
    fn condition_is_that_of_a_diagonal_matrix() {
        // On a circle of radius r around the slave the linear block is n w diag(1, r²/2, r²/2).
        let moments = Moments::new(circle(8).into_iter(), 2.0);
        assert!((moments.condition(Basis::Linear) - 8.0).abs() < 1e-13);
        assert!((moments.pivot_ratio(Basis::Linear) - 1.0).abs() < 1e-13);
    }
}
