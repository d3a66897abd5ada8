//! The weighted fit, over any kind of number: offsets from the slave, moment matrix and vector, coefficients.
//!
//! Lengths are divided by the support radius, so that the moment matrix has entries of order one whatever the
//! length unit. Nothing here knows whether it runs on reals or on dual numbers.

use num_dual::Dual64;

use super::foot::{Polynomial, basis_functions};
use super::linear::{Scalar, solve_cholesky};
use super::plane::Turn;
use super::{RadialWeight, WeightFunction};
use crate::{Basis, Domains, Element, ElementError, MaterialNode};

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
        let squares = self.squares(&offsets);
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
        let squares = self.squares(&offsets);
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
            Some(shift) => self.material_squares(shift),
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
            let squares = self.material_squares([D::zero(); 3]);
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

    /// X_k − Ξ, if domains are those of the first configuration.
    pub(super) fn material_nodes(&self) -> &[MaterialNode] {
        match self.element.domains {
            Domains::Material(nodes) => nodes,
            Domains::Shared | Domains::Each(_) => &[],
        }
    }

    /// r² of each of them where Ξ has moved by `shift`.
    pub(super) fn material_squares<D: Scalar>(&self, shift: [D; 3]) -> Vec<D> {
        let square = |node: &MaterialNode| {
            let [x, y, z]: [D; 3] = std::array::from_fn(|k| -shift[k] + node.offset[k]);
            let [xx, xy, xz, yy, yz, zz] = node.metric;
            let along = [x * xx + y * xy + z * xz, y * yy + z * yz, z * zz];
            along[0] * along[0] + along[1] * along[1] + along[2] * along[2]
        };
        self.material_nodes().iter().map(square).collect()
    }

    /// r² of nodes with these offsets, r the in-plane distance over the radius of the node's domain.
    fn squares<D: Scalar>(&self, offsets: &[[D; 3]]) -> Vec<D> {
        if let Domains::Material(_) = self.element.domains {
            return self.material_squares([D::zero(); 3]);
        }
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
