//! The foot of a contact: the masters' weights in it, and first derivatives of foot and normal.
//!
//! The foot is an affine combination of the masters, x^d = Σ φ_k x^k (docs/equations.md, T15). Hosts with a law of their own at the foot
//! (wear, heat, adhesion, friction, mortar sums) need φ, ∂x^d/∂x and ∂ν/∂x beside N and M.
//!
//! ```
//! use diffuse_contact::{Backend, Element, Frame, Generated};
//!
//! let masters: Vec<[f64; 3]> =
//!     (0..9).map(|k| [f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, 0.1 * f64::from(k % 2)]).collect();
//! let element = Element::new([0.1, 0.2, 0.25], &masters, Frame::average_plane(&masters, [0.0, 0.0, 1.0])?, 2.0);
//! let at_foot = Generated.foot_derivatives(&element)?;
//! let combined: f64 = masters.iter().zip(&at_foot.weights).map(|(x, weight)| x[2] * weight).sum();
//! assert!((combined - at_foot.point.foot[2]).abs() < 1e-14);
//! // All nodes move along x by 1, and so does the foot; the normal stays.
//! let sum = |row: &[f64]| row.iter().step_by(3).sum::<f64>();
//! assert!((sum(&at_foot.foot[..30]) - 1.0).abs() < 1e-14 && sum(&at_foot.normal[..30]).abs() < 1e-14);
//! # Ok::<(), diffuse_contact::ElementError>(())
//! ```

use diffuse_contact_kernels::foot_of_gap;
use diffuse_contact_kernels::support::{Isa, KernelSet, SecondKind, Vector, WithLanes};

use crate::batch::{Asked, gap_batch};
use crate::facet::foot_weights;
use crate::{
    BatchScratch, ContactPoint, Element, ElementError, FacetElement, GapFactors, GapSlot, Generated,
    GeneratedWith, HessianForm, Mode,
};

/// The foot of one element with first derivatives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FootDerivatives {
    /// Gap, foot and normal.
    pub point: ContactPoint,
    /// φ, one number per master: the foot is Σ φ_k x^k, Σ φ_k = 1.
    pub weights: Vec<f64>,
    /// ∂x^d/∂x: for each component of the foot a row of 3(n+1) entries, ordered slave, master 1, …, master n; dimensionless.
    pub foot: Vec<f64>,
    /// ∂ν/∂x, the same, 1/length.
    pub normal: Vec<f64>,
}

/// Where the first derivatives at the foot of one element go.
#[derive(Debug, Default)]
pub struct FootSlot<'a> {
    /// φ, n numbers.
    pub weights: &'a mut [f64],
    /// ∂x^d/∂x, 9(n+1) numbers, see [`FootDerivatives::foot`].
    pub foot: &'a mut [f64],
    /// ∂ν/∂x, the same.
    pub normal: &'a mut [f64],
}

impl FootDerivatives {
    /// Room for so many masters.
    pub(crate) fn zeros(point: ContactPoint, masters: usize) -> Self {
        let rows = vec![0.0; 9 * (masters + 1)];
        Self { point, weights: vec![0.0; masters], foot: rows.clone(), normal: rows }
    }

    pub(crate) fn slot(&mut self) -> FootSlot<'_> {
        FootSlot { weights: &mut self.weights, foot: &mut self.foot, normal: &mut self.normal }
    }
}

impl FootSlot<'_> {
    /// Fills ∂x^d/∂x from N and ∂ν/∂x.
    fn complete(&mut self, point: &ContactPoint, gradient: &[f64]) -> Result<(), ElementError> {
        let &ContactPoint { gap, normal, .. } = point;
        // The foot is linear in the slave, of which only the derivative is read.
        let inputs = foot_of_gap::Inputs { slave: [0.0; 3], gap, normal };
        let by = foot_of_gap::evaluate(Mode::Gradient, &inputs).foot_jacobian;
        let freedoms = gradient.len();
        let (by, _) = by.as_chunks::<7>();
        let (normal, foot) = (&self.normal[..3 * freedoms], &mut self.foot[..3 * freedoms]);
        let rows = FootRows { by, gradient, normal, foot: &mut *foot };
        let mut not_finite = Isa::best().run(rows);
        for (row, by) in foot.chunks_exact_mut(freedoms).zip(by) {
            for axis in 0..3 {
                row[axis] += by[axis];
                not_finite += 0.0 * row[axis];
            }
        }
        not_finite += self.weights.iter().map(|x| x * 0.0).sum::<f64>();
        let is_finite = not_finite == 0.0;
        if is_finite { Ok(()) } else { Err(ElementError::Overflow { what: "derivative at the foot" }) }
    }
}

/// Rows of the foot, as far as they follow from gap and normal.
struct FootRows<'a> {
    /// Derivatives of each component by the slave, gap and normal.
    by: &'a [[f64; 7]],
    gradient: &'a [f64],
    normal: &'a [f64],
    foot: &'a mut [f64],
}

impl WithLanes for FootRows<'_> {
    /// 0, or NaN if an entry is not finite.
    type Output = f64;

    #[inline(always)]
    fn run<T: Vector>(self) -> f64 {
        let Self { by, gradient, normal, foot } = self;
        let freedoms = gradient.len();
        let mut not_finite = T::ZERO;
        for vector in 0..freedoms.div_ceil(T::WIDTH) {
            // The last vector writes some entries once more.
            let place = (T::WIDTH * vector).min(freedoms - T::WIDTH);
            let by_nodes = [
                T::load(gradient, place),
                T::load(normal, place),
                T::load(normal, freedoms + place),
                T::load(normal, 2 * freedoms + place),
            ];
            let mut sum = by_nodes[1] + by_nodes[2] + by_nodes[3];
            for component in 0..3 {
                let by = &by[component];
                let mut entry = T::splat(by[3]) * by_nodes[0];
                for k in 1..4 {
                    entry = T::splat(by[3 + k]).mul_add(by_nodes[k], entry);
                }
                entry.store(foot, freedoms * component + place);
                sum = sum + entry;
            }
            not_finite = sum.mul_add(T::ZERO, not_finite);
        }
        not_finite.sum()
    }
}

impl HessianForm {
    /// How many numbers [`gap_foot_batch`](Generated::gap_foot_batch) gives.
    pub const fn foot_numbers(self) -> usize {
        self.rows().foot_numbers()
    }

    /// The derivatives at the foot, from what [`gap_foot_batch`](Generated::gap_foot_batch) gave: gap, foot and normal, N, and `numbers`.
    ///
    /// # Errors
    /// [`ElementError::Overflow`].
    ///
    /// # Panics
    /// If a slice is too short.
    pub fn foot_derivatives(
        self,
        point: &ContactPoint,
        gradient: &[f64],
        numbers: &[f64],
        target: &mut FootSlot<'_>,
    ) -> Result<(), ElementError> {
        let masters = self.rows().count;
        let (weights, normal) = numbers[..self.foot_numbers()].split_at(masters);
        target.weights[..masters].copy_from_slice(weights);
        target.normal[..normal.len()].copy_from_slice(normal);
        target.complete(point, &gradient[..self.degrees_of_freedom()])
    }
}

impl Generated {
    /// As [`gap_factors_batch`](Self::gap_factors_batch), with φ and ∂ν/∂x in the place of the factors of M:
    /// [`foot_numbers`](HessianForm::foot_numbers) numbers, which [`foot_derivatives`](HessianForm::foot_derivatives) completes.
    ///
    /// # Errors
    /// An entry for each element, as [`gap_into`](Self::gap_into).
    ///
    /// # Panics
    /// If there are not as many slots as elements, or a slice is too short.
    pub fn gap_foot_batch<'a>(
        &self,
        elements: &[Element<'_>],
        slots: impl IntoIterator<Item = GapSlot<'a>>,
        scratch: &mut BatchScratch,
    ) -> Vec<Result<ContactPoint, ElementError>> {
        gap_batch(self, elements, Asked::Second(SecondKind::FactorsAndFoot), slots, scratch)
    }

    /// The foot on a facet with first derivatives. The weights are the facet's shape functions.
    ///
    /// # Errors
    /// As [`facet_gap`](Self::facet_gap).
    pub fn facet_foot_derivatives(
        &self,
        element: &FacetElement<'_>,
    ) -> Result<FootDerivatives, ElementError> {
        let gap = self.facet_gap(element, Mode::Hessian)?;
        let point = gap.point();
        let mut all = FootDerivatives::zeros(point, element.corners.len());
        facet_foot_derivatives(&point, &gap.gradient, gap.hessian.packed(), &mut all.slot())?;
        Ok(all)
    }
}

/// The derivatives at the foot on a facet, from N and the packed lower triangle of M.
pub(crate) fn facet_foot_derivatives(
    point: &ContactPoint,
    gradient: &[f64],
    hessian: &[f64],
    target: &mut FootSlot<'_>,
) -> Result<(), ElementError> {
    let freedoms = gradient.len();
    // The gap is stationary in foot and normal: ∂g/∂x is ν for the slave.
    for (weight, found) in target.weights.iter_mut().zip(foot_weights(gradient, point.normal)) {
        *weight = found;
    }
    for component in 0..3 {
        for k in 0..freedoms {
            let (row, column) = (component.max(k), component.min(k));
            target.normal[freedoms * component + k] = hessian[row * (row + 1) / 2 + column];
        }
    }
    target.complete(point, gradient)
}

/// [`Backend::foot_derivatives`](crate::Backend::foot_derivatives) with the kernels of `K`.
pub(crate) fn of_element<K: KernelSet>(element: &Element<'_>) -> Result<FootDerivatives, ElementError> {
    let (kernels, kind) = (GeneratedWith::<K>::new(), SecondKind::FactorsAndFoot);
    let GapFactors { point, gradient, hessian } =
        kernels.with_numbers(element, kind, HessianForm::foot_numbers)?;
    let mut all = FootDerivatives::zeros(point, element.masters.len());
    hessian.form().foot_derivatives(&point, &gradient, hessian.numbers(), &mut all.slot())?;
    Ok(all)
}
