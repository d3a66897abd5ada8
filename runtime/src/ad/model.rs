//! The weighted fit, over any kind of number: offsets from the slave, moment matrix and vector, coefficients.
//!
//! Lengths are divided by the support radius, so that the moment matrix has entries of order one whatever the
//! length unit. Nothing here knows whether it runs on reals or on dual numbers.

use num_dual::{Dual64, DualNum};

use super::foot::{Coefficients, Polynomial, basis_functions};
use super::plane::Turn;
use super::{RadialWeight, WeightFunction, material};
use crate::{Basis, Domains, Element, ElementError};

/// A real, dual or hyper-dual number.
pub(super) trait Scalar: DualNum<Primitive = f64> + Copy {}
impl<D: DualNum<Primitive = f64> + Copy> Scalar for D {}

/// A pivot of the Cholesky factorisation has to exceed this fraction of the diagonal entry it came from.
///
/// Layouts on a conic leave rounding here, up to about 1e-8.
const PIVOT_TOLERANCE: f64 = 1e-7;
/// Where all nodes are on a line or two along the axes, a diagonal entry is rounding itself: a pivot is compared with at
/// least this fraction, to the power of its degree, of the diagonal's sum over its degree.
const SMALLEST_PART: f64 = 1e-4;

/// Lower triangle of a matrix over the basis functions.
pub(super) type Matrix<D> = [Coefficients<D>; Basis::MOST_COEFFICIENTS];

/// One element with the weight function in force.
pub(super) struct Model<'a, W> {
    pub(super) element: &'a Element<'a>,
    pub(super) weight: WeightFunction<'a, W>,
}

impl<W: RadialWeight> Model<'_, W> {
    /// Offsets (a, b, z) = (t1, t2, n̂)·(x^i − x^c)/R of the masters; `coordinates` holds slave and masters.
    pub(super) fn offsets<D: Scalar>(&self, coordinates: &[[D; 3]]) -> Vec<[D; 3]> {
        let (slave, masters) = (coordinates[0], &coordinates[1..]);
        let rows = self.element.frame.rows();
        let radius = self.element.support_radius;
        masters
            .iter()
            .map(|master| {
                let [x, y, z] = std::array::from_fn(|k| (master[k] - slave[k]) / radius);
                rows.map(|row| x * row[0] + y * row[1] + z * row[2])
            })
            .collect()
    }

    /// The fit in the given frame, which is held.
    pub(super) fn fit<D: Scalar>(&self, coordinates: &[[D; 3]]) -> Result<Polynomial<D>, ElementError> {
        let offsets = self.offsets(coordinates);
        let squares = match self.element.domains {
            Domains::Material(_) => material::squares(self, [D::zero(); 3]),
            Domains::Shared | Domains::Each(_) => self.squares(&offsets),
        };
        self.fit_to(offsets, &squares)
    }

    /// The fit in the given frame as a function of the height of the k-th master, the dual part by it.
    pub(super) fn fit_with_raised_node(
        &self,
        coordinates: &[[f64; 3]],
        k: usize,
    ) -> Result<Polynomial<Dual64>, ElementError> {
        let mut offsets: Vec<[Dual64; 3]> =
            self.offsets(&coordinates.iter().map(|x| x.map(Dual64::from)).collect::<Vec<_>>());
        let squares = match self.element.domains {
            Domains::Material(_) => material::squares(self, [Dual64::from(0.0); 3]),
            Domains::Shared | Domains::Each(_) => self.squares(&offsets),
        };
        offsets[k][2].eps = 1.0;
        self.fit_to(offsets, &squares)
    }

    /// The fit in a frame that has turned away from the given one; `shift`: of the slave's place in the first configuration,
    /// where there is one.
    pub(super) fn fit_in<D: Scalar>(
        &self,
        coordinates: &[[D; 3]],
        turn: &Turn<D>,
        shift: Option<[D; 3]>,
    ) -> Result<Polynomial<D>, ElementError> {
        let mut offsets = self.offsets(coordinates);
        for offset in &mut offsets {
            let [a, b, z] = *offset;
            *offset = turn.map(|axis| axis[0] * a + axis[1] * b + axis[2] * z);
        }
        let squares = match shift {
            Some(shift) => material::squares(self, shift),
            None => self.squares(&offsets),
        };
        self.fit_to(offsets, &squares)
    }

    /// ω at r²; 0 outside.
    pub(super) fn fitting<D: Scalar>(&self, square: D) -> D {
        if square.re() < 1.0 { self.weight.at_square(square) } else { D::zero() }
    }

    /// R_k of the k-th master's domain of influence.
    fn domain(&self, k: usize) -> f64 {
        self.element.domains.radius(k, self.element.support_radius)
    }

    /// The nodes' weights in the average plane; `coordinates` holds slave and masters.
    pub(super) fn plane_weights<D: Scalar>(&self, coordinates: &[[D; 3]]) -> Vec<D> {
        if let Domains::Material(_) = self.element.domains {
            let squares = material::squares(self, [D::zero(); 3]);
            return squares.into_iter().map(|square| self.fitting(square)).collect();
        }
        let (slave, masters) = (coordinates[0], &coordinates[1..]);
        let reach = self.element.frame.reach;
        let weight = |(k, master): (usize, &[D; 3])| {
            let [x, y, z] =
                std::array::from_fn(|axis| (master[axis] - slave[axis]) * (reach / self.domain(k)));
            self.fitting(x * x + y * y + z * z)
        };
        masters.iter().enumerate().map(weight).collect()
    }

    /// r² of nodes with these offsets, r the in-plane distance over the radius of the node's domain.
    fn squares<D: Scalar>(&self, offsets: &[[D; 3]]) -> Vec<D> {
        let square = |(k, &[a, b, _]): (usize, &[D; 3])| {
            let ratio = self.element.support_radius / self.domain(k);
            (a * a + b * b) * (ratio * ratio)
        };
        offsets.iter().enumerate().map(square).collect()
    }

    /// The fit A α = β with A = Σ w p pᵀ, β = Σ w z p (Chamoret et al. 2008, eq. 13), lengths over R.
    fn fit_to<D: Scalar>(&self, offsets: Vec<[D; 3]>, squares: &[D]) -> Result<Polynomial<D>, ElementError> {
        let basis = self.element.basis;
        let size = basis.size();
        if self.weight.is_interpolating() {
            return super::interpolating::fit(&self.weight, basis, &offsets, squares);
        }
        let mut moment_matrix = [[D::zero(); Basis::MOST_COEFFICIENTS]; Basis::MOST_COEFFICIENTS];
        let mut moment_vector = [D::zero(); Basis::MOST_COEFFICIENTS];
        for ([a, b, z], &square) in offsets.into_iter().zip(squares) {
            super::finite("offset", [a.re(), b.re(), z.re()])?;
            // Outside the support the weight and all its derivatives vanish. The powers of a far node's offset
            // may overflow: it is left out, not multiplied by zero.
            if square.re() >= 1.0 {
                continue;
            }
            let weight = self.weight.at_square(square);
            super::finite("weight", [weight.re()])?;
            let p = basis_functions(basis, [a, b]);
            for k in 0..size {
                let weighted = weight * p[k];
                moment_vector[k] += weighted * z;
                for l in 0..=k {
                    moment_matrix[k][l] += weighted * p[l];
                }
            }
        }
        let diagonals = std::array::from_fn(|j| moment_matrix[j][j].re());
        let coefficients = solve_cholesky(basis.monomials(), diagonals, moment_matrix, moment_vector)?;
        super::finite("coefficient", coefficients.map(|x| x.re()))?;
        Ok(Polynomial { basis, coefficients })
    }
}

/// Solves A x = b for these basis functions by A = L Lᵀ; `matrix` holds the lower triangle, entries beyond the functions
/// stay zero. `diagonals` are what the pivots are compared with.
pub(super) fn solve_cholesky<D: Scalar>(
    monomials: &[(u8, u8)],
    diagonals: [f64; Basis::MOST_COEFFICIENTS],
    mut matrix: Matrix<D>,
    mut vector: Coefficients<D>,
) -> Result<Coefficients<D>, ElementError> {
    let size = monomials.len();
    let degree = |j: usize| i32::from(monomials[j].0 + monomials[j].1);
    for j in 0..size {
        super::finite("moment", [diagonals[j]])?;
        let same: f64 = (0..size).filter(|&k| degree(k) == degree(j)).map(|k| diagonals[k]).sum();
        let diagonal = diagonals[j].max(SMALLEST_PART.powi(degree(j)) * same);
        let mut pivot = matrix[j][j];
        for entry in &matrix[j][..j] {
            pivot -= *entry * *entry;
        }
        super::finite("pivot", [pivot.re()])?;
        let pivot_ratio = if diagonal > 0.0 { pivot.re() / diagonal } else { 0.0 };
        if pivot_ratio <= PIVOT_TOLERANCE {
            return Err(ElementError::SingularFit { pivot_ratio, tolerance: PIVOT_TOLERANCE });
        }
        let root = pivot.sqrt();
        matrix[j][j] = root;
        for i in j + 1..size {
            let products = (0..j).map(|k| matrix[i][k] * matrix[j][k]);
            let entry = products.fold(matrix[i][j], |entry, product| entry - product);
            matrix[i][j] = entry / root;
        }
    }
    for i in 0..size {
        for k in 0..i {
            let known = vector[k];
            vector[i] -= matrix[i][k] * known;
        }
        vector[i] /= matrix[i][i];
    }
    for i in (0..size).rev() {
        for k in i + 1..size {
            let known = vector[k];
            vector[i] -= matrix[k][i] * known;
        }
        vector[i] /= matrix[i][i];
    }
    Ok(vector)
}

#[cfg(test)]
mod tests {
    use super::super::Ad;
    use super::*;
    use crate::{Backend, Basis, Frame, Mode};

    #[test]
    fn cholesky_solves_a_known_system() {
        // A = L Lᵀ with L = [[2], [1, 3], [-1, 2, 1]], x = (1, -2, 3).
        let mut matrix = [[0.0; 15]; 15];
        matrix[0][0] = 4.0;
        matrix[1][..2].copy_from_slice(&[2.0, 10.0]);
        matrix[2][..3].copy_from_slice(&[-2.0, 5.0, 6.0]);
        let (mut vector, mut diagonals) = ([0.0; 15], [0.0; 15]);
        vector[..3].copy_from_slice(&[4.0 - 4.0 - 6.0, 2.0 - 20.0 + 15.0, -2.0 - 10.0 + 18.0]);
        diagonals[..3].copy_from_slice(&[4.0, 10.0, 6.0]);
        let x: [f64; 15] = solve_cholesky(Basis::Linear.monomials(), diagonals, matrix, vector).unwrap();
        for (found, expected) in x.iter().zip([1.0, -2.0, 3.0, 0.0, 0.0, 0.0]) {
            assert!((found - expected).abs() < 1e-14, "{x:?}");
        }
    }

    #[test]
    fn an_indefinite_matrix_is_singular() {
        let mut matrix = [[0.0; 15]; 15];
        matrix[0][0] = 1.0;
        matrix[1][..2].copy_from_slice(&[1.0, 1.0]);
        let error = solve_cholesky(&[(1, 0), (0, 1)], [1.0; 15], matrix, [1.0; 15]).unwrap_err();
        assert_eq!(error, ElementError::SingularFit { pivot_ratio: 0.0, tolerance: PIVOT_TOLERANCE });
    }

    /// The three outputs of an element with masters in the plane z = 0 and a slave a little above it, or the
    /// errors they end in.
    fn outcomes(
        masters: &[[f64; 2]],
        slave: [f64; 2],
        basis: Basis,
        mode: Mode,
    ) -> [Result<(), ElementError>; 3] {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let masters: Vec<_> = masters.iter().map(|[a, b]| [*a, *b, 0.0]).collect();
        let element = Element::new(
            [slave[0], slave[1], 0.1],
            &masters,
            Frame::given([0.0; 3], axes[0], axes[1], axes[2], None).unwrap(),
            3.0,
        )
        .with_basis(basis);
        [
            Ad.gap(&element, mode).map(|_| ()),
            Ad.coefficients(&element, mode).map(|_| ()),
            Ad.surface(&element, [0.0; 2], mode).map(|_| ()),
        ]
    }

    #[test]
    fn degenerate_layouts_are_singular() {
        let hexagon: Vec<_> = (0..6)
            .map(|i| {
                let (s, c) = (f64::from(i) * std::f64::consts::FRAC_PI_3).sin_cos();
                [c, s]
            })
            .collect();
        let strip: Vec<_> = (0..8).map(|i| [0.5 * f64::from(i % 4), f64::from(i / 4)]).collect();
        let line: Vec<_> = (0..5).map(|i| [0.3 * f64::from(i), 0.1 + 0.2 * f64::from(i)]).collect();
        for (masters, basis) in [
            (&hexagon, Basis::Quadratic),
            (&strip, Basis::Quadratic),
            (&line, Basis::Linear),
            (&vec![[10.0, 0.0]; 6], Basis::Quadratic),
            (&vec![[0.2, 0.1]; 4], Basis::Linear),
        ] {
            for slave in [[0.0, 0.0], [0.31, 0.17]] {
                for mode in [Mode::Value, Mode::Hessian] {
                    for outcome in outcomes(masters, slave, basis, mode) {
                        let Err(ElementError::SingularFit { pivot_ratio, tolerance }) = outcome else {
                            panic!("{outcome:?}")
                        };
                        assert!(pivot_ratio.abs() < 1e-13 && tolerance == PIVOT_TOLERANCE);
                    }
                }
            }
        }
        // The same nodes carry the linear basis.
        for masters in [hexagon, strip] {
            let outcomes = outcomes(&masters, [0.1, 0.2], Basis::Linear, Mode::Hessian);
            assert!(outcomes.iter().all(Result::is_ok));
        }
    }
}
