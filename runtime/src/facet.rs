//! Contact on a facet itself: the slave's signed distance from a triangle or a quadrilateral of corner nodes.
//!
//! The foot is the point x(ξ, η) = Σ N_i(ξ, η) x^i where the slave lies on the facet's normal. It may lie beyond the
//! facet's border, on its extension: [`FacetPoint::natural`] tells, and [`FacetElement::contains`] with it. The normal
//! jumps from facet to facet; the diffuse element ([`Element`](crate::Element)) is there to avoid that.

use diffuse_contact_kernels::support::{FacetFigures, RootSolution, packed_row};
use diffuse_contact_kernels::{
    gap_over_quadrilateral, gap_over_triangle, slip_over_quadrilateral, slip_over_triangle,
};

use crate::output::SymmetricMatrix;
use crate::{ContactPoint, ElementError, Gap, Generated, Mode, Point, Slip};

/// A slave node and the corners of one facet, current positions.
///
/// ```
/// use diffuse_contact::{FacetElement, Generated, Mode};
///
/// // The unit square in the plane z = 0 with its outward side up, and a slave 0.1 below it.
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// let element = FacetElement { slave: [0.25, 0.5, -0.1], corners: &corners };
/// let gap = Generated.facet_gap(&element, Mode::Hessian)?;
/// assert!((gap.gap + 0.1).abs() < 1e-15);
/// assert_eq!(gap.gradient.len(), 3 * (4 + 1));
/// let foot = Generated.facet_point(&element)?;
/// assert_eq!(foot.natural, [-0.5, 0.0]);
/// assert!(element.contains(foot.natural, 0.0));
/// # Ok::<(), diffuse_contact::ElementError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetElement<'a> {
    /// Slave node x^c.
    pub slave: Point,
    /// Corners x^1 … x^n, n = 3 or 4, counter-clockwise seen from the outward side of the master.
    pub corners: &'a [Point],
}

/// The foot on a facet, without derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FacetPoint {
    /// Gap, foot and normal.
    pub point: ContactPoint,
    /// Natural coordinates (ξ, η) of the foot. On a triangle the area coordinates of the second and third corner, both
    /// and their sum 0 … 1 inside; on a quadrilateral −1 … 1 inside, with (−1, −1) at the first corner, (1, −1) at the
    /// second.
    pub natural: [f64; 2],
}

impl FacetElement<'_> {
    /// Number of global coordinates the gap depends on, 3(n+1).
    pub const fn degrees_of_freedom(&self) -> usize {
        3 * (self.corners.len() + 1)
    }

    /// Checks what no kernel can repair: three or four corners, finite input.
    ///
    /// # Errors
    /// [`ElementError::FacetCorners`], [`ElementError::NonFiniteInput`].
    pub fn validate(&self) -> Result<(), ElementError> {
        if !matches!(self.corners.len(), 3 | 4) {
            return Err(ElementError::FacetCorners { found: self.corners.len() });
        }
        ElementError::check_points("slave", &[self.slave])?;
        ElementError::check_points("corner", self.corners)
    }

    /// Whether natural coordinates lie on the facet, or within `tolerance` of it in their own measure. False for a NaN.
    pub fn contains(&self, natural: [f64; 2], tolerance: f64) -> bool {
        let [xi, eta] = natural;
        if self.corners.len() == 3 {
            xi >= -tolerance && eta >= -tolerance && xi + eta <= 1.0 + tolerance
        } else {
            xi.abs() <= 1.0 + tolerance && eta.abs() <= 1.0 + tolerance
        }
    }
}

impl Generated {
    /// The gap on a facet, with N and M over the coordinates of slave, corner 1, …, corner n. It has no
    /// [`coefficients`](Gap::coefficients).
    ///
    /// # Errors
    /// What [`FacetElement::validate`] finds; [`ElementError::DegenerateFacet`], [`ElementError::FootDiverged`],
    /// [`ElementError::CentreOfCurvature`], [`ElementError::Overflow`].
    pub fn facet_gap(&self, element: &FacetElement<'_>, mode: Mode) -> Result<Gap, ElementError> {
        element.validate()?;
        let mut room = Gap::room(mode, element.degrees_of_freedom());
        let found = run(element, mode, &mut room.gradient, room.hessian.packed_mut())?;
        let ContactPoint { gap, foot, normal } = found.point;
        Ok(Gap { gap, foot, normal, ..room })
    }

    /// [`facet_gap`](Self::facet_gap) without allocation: N into `gradient`, 3(n+1) entries, and the packed lower
    /// triangle of M into `hessian` (see [`SymmetricMatrix`] for its order). What the mode does not ask for may be empty
    /// and is not touched; on an error the contents are unspecified.
    ///
    /// # Errors
    /// As [`facet_gap`](Self::facet_gap).
    ///
    /// # Panics
    /// If a slice is shorter than its mode needs.
    pub fn facet_gap_into(
        &self,
        element: &FacetElement<'_>,
        mode: Mode,
        gradient: &mut [f64],
        hessian: &mut [f64],
    ) -> Result<FacetPoint, ElementError> {
        element.validate()?;
        run(element, mode, gradient, hessian)
    }

    /// The slip from an anchor on a facet, with the gap: q = ½ |P_ν d|² with d from `anchor` to the slave
    /// (docs/equations.md, T16). Derivatives of q are over the coordinates of slave, corner 1, …, corner n, anchor.
    ///
    /// # Errors
    /// As [`facet_gap`](Self::facet_gap); [`ElementError::NonFiniteInput`] for an anchor that is no point.
    ///
    /// ```
    /// use diffuse_contact::{FacetElement, Generated, Mode};
    ///
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    /// let element = FacetElement { slave: [0.25, 0.5, -0.1], corners: &corners };
    /// // The way along the normal is no slip.
    /// let slip = Generated.facet_slip(&element, [0.25, 0.2, 0.7], Mode::Hessian)?;
    /// assert!((slip.length() - 0.3).abs() < 1e-15);
    /// assert_eq!(slip.gradient.len(), 3 * (4 + 2));
    /// # Ok::<(), diffuse_contact::ElementError>(())
    /// ```
    pub fn facet_slip(
        &self,
        element: &FacetElement<'_>,
        anchor: Point,
        mode: Mode,
    ) -> Result<Slip, ElementError> {
        ElementError::check_points("anchor", &[anchor])?;
        let contact = self.facet_gap(element, mode)?;
        let mut numbers = SlipNumbers::default();
        let half_square = facet_slip(element, anchor, mode, &mut numbers)?;
        let freedoms = 3 * (element.corners.len() + 2);
        let mut slip = Slip { half_square, ..Slip::default() };
        if mode >= Mode::Gradient {
            slip.gradient = numbers.gradient[..freedoms].to_vec();
            slip.foot_weights = foot_weights(&contact.gradient, contact.normal).collect();
        }
        if mode >= Mode::Hessian {
            slip.hessian = SymmetricMatrix::of(freedoms, &numbers.hessian[..packed_row(freedoms)]);
        }
        Ok(Slip { contact, ..slip })
    }

    /// Gap, foot, normal and natural coordinates, without derivatives.
    ///
    /// # Errors
    /// As [`facet_gap`](Self::facet_gap).
    pub fn facet_point(&self, element: &FacetElement<'_>) -> Result<FacetPoint, ElementError> {
        self.facet_gap_into(element, Mode::Value, &mut [], &mut [])
    }
}

/// Most coordinates of a slip over a facet: slave, corners, anchor.
const MOST: usize = 3 * (4 + 2);

/// Derivatives of q, those that a mode asks for: the first entries of either.
pub(crate) struct SlipNumbers {
    pub gradient: [f64; MOST],
    /// Packed lower triangle.
    pub hessian: [f64; MOST * (MOST + 1) / 2],
}

impl Default for SlipNumbers {
    fn default() -> Self {
        Self { gradient: [0.0; MOST], hessian: [0.0; MOST * (MOST + 1) / 2] }
    }
}

/// q of an element that has a gap, and its derivatives.
pub(crate) fn facet_slip(
    element: &FacetElement<'_>,
    anchor: Point,
    mode: Mode,
    numbers: &mut SlipNumbers,
) -> Result<f64, ElementError> {
    // Seen from the slave and over the facet's size: powers of lengths would leave the range of numbers.
    let origin = element.slave;
    let edges =
        element.corners.iter().flat_map(|x| (0..3).map(|axis| (x[axis] - element.corners[0][axis]).abs()));
    let size = edges.fold(0.0, f64::max);
    let seen = |x: Point| [0, 1, 2].map(|axis| (x[axis] - origin[axis]) / size);
    let (slave, anchor) = ([0.0; 3], seen(anchor));
    let SlipNumbers { gradient, hessian } = numbers;
    let half_square = match *element.corners {
        [a, b, c] => {
            let inputs = slip_over_triangle::Inputs { slave, corners: [a, b, c].map(seen), anchor };
            let found = slip_over_triangle::evaluate(mode, &inputs);
            gradient[..found.gradient.len()].copy_from_slice(&found.gradient);
            hessian[..found.hessian.len()].copy_from_slice(&found.hessian);
            found.values.energy
        }
        [a, b, c, d] => {
            let corners = [a, b, c, d].map(seen);
            let inputs = slip_over_quadrilateral::Inputs { slave, corners, anchor };
            let found = slip_over_quadrilateral::evaluate(mode, &inputs);
            let slip_over_quadrilateral::Values { residual, iterations, energy } = found.values;
            if !(residual < RootSolution::<f64>::TOLERANCE) {
                return Err(ElementError::FootDiverged { residual, iterations: iterations as usize });
            }
            (*gradient, *hessian) = (found.gradient, found.hessian);
            energy
        }
        _ => return Err(ElementError::FacetCorners { found: element.corners.len() }),
    };
    let half_square = size * size * half_square;
    gradient.iter_mut().for_each(|by| *by *= size);
    // The sum is finite only if each of them is.
    let sum: f64 = gradient.iter().chain(&*hessian).map(|x| 0.0 * x).sum();
    if half_square.is_finite() && sum == 0.0 {
        Ok(half_square)
    } else {
        Err(ElementError::Overflow { what: "slip" })
    }
}

/// The corners' parts in the foot, their shape functions: ∂g/∂x is −φ_k ν for a corner.
pub(crate) fn foot_weights(gradient: &[f64], normal: Point) -> impl Iterator<Item = f64> + '_ {
    let along = move |by: &Point| -(0..3).map(|axis| by[axis] * normal[axis]).sum::<f64>();
    gradient.as_chunks::<3>().0.iter().skip(1).map(along)
}

/// Runs the kernel of a checked element.
fn run(
    element: &FacetElement<'_>,
    mode: Mode,
    gradient: &mut [f64],
    hessian: &mut [f64],
) -> Result<FacetPoint, ElementError> {
    let slave = element.slave;
    // The kernels of both shapes return values of the same names.
    macro_rules! run {
        ($kernel:ident, $corners:expr) => {{
            let inputs = $kernel::Inputs { slave, corners: $corners };
            let $kernel::Values {
                gap,
                foot,
                normal,
                natural,
                corner_area,
                foot_area,
                foot_residual,
                foot_iterations,
                jacobian_determinant,
            } = $kernel::evaluate_to(mode, &inputs, gradient, hessian);
            let figures =
                FacetFigures { corner_area, foot_area, foot_residual, foot_iterations, jacobian_determinant };
            (FacetPoint { point: ContactPoint { gap, foot, normal }, natural }, figures)
        }};
    }
    let (found, figures) = match *element.corners {
        [a, b, c] => run!(gap_over_triangle, [a, b, c]),
        [a, b, c, d] => run!(gap_over_quadrilateral, [a, b, c, d]),
        _ => return Err(ElementError::FacetCorners { found: element.corners.len() }),
    };
    let freedoms = element.degrees_of_freedom();
    let gradient = if mode >= Mode::Gradient { &gradient[..freedoms] } else { &[] };
    let hessian = if mode >= Mode::Hessian { &hessian[..freedoms * (freedoms + 1) / 2] } else { &[] };
    let ContactPoint { gap, foot, normal } = found.point;
    let values = [gap].into_iter().chain(foot).chain(normal).chain(found.natural);
    // The sum is finite only if each of them is.
    let sum: f64 = values.chain(gradient.iter().chain(hessian).copied()).map(|x| 0.0 * x).sum();
    ElementError::check(figures.status(sum == 0.0))?;
    Ok(found)
}
