//! Contact on a facet itself: the slave's signed distance from a triangle or a quadrilateral of corner nodes.
//!
//! The foot is the point x(ξ, η) = Σ N_i(ξ, η) x^i where the slave lies on the facet's normal. It may lie beyond the
//! facet's border, on its extension: [`FacetPoint::natural`] tells, and [`FacetElement::contains`] with it. The normal
//! jumps from facet to facet; the diffuse element ([`Element`](crate::Element)) is there to avoid that.

use diffuse_contact_kernels::facet::{quadrilateral, triangle};
use diffuse_contact_kernels::support::{FacetInputs, FacetValues};

use crate::output::SymmetricMatrix;
use crate::{ContactPoint, ElementError, Gap, Generated, Mode, Point};

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
    #[must_use]
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
        if !self.slave.iter().all(|x| x.is_finite()) {
            return Err(ElementError::NonFiniteInput { what: "slave", index: 0 });
        }
        match self.corners.iter().position(|corner| !corner.iter().all(|x| x.is_finite())) {
            Some(index) => Err(ElementError::NonFiniteInput { what: "corner", index }),
            None => Ok(()),
        }
    }

    /// Whether natural coordinates lie on the facet, or within `tolerance` of it in their own measure. False for a NaN.
    #[must_use]
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
        let freedoms = element.degrees_of_freedom();
        let mut gradient = if mode >= Mode::Gradient { vec![0.0; freedoms] } else { Vec::new() };
        let size = if mode >= Mode::Hessian { freedoms } else { 0 };
        let mut hessian = SymmetricMatrix::zeros(size);
        let values = run(element, mode, &mut gradient, hessian.packed_mut())?;
        Ok(Gap {
            gap: values.gap,
            foot: values.foot,
            normal: values.normal,
            coefficients: Vec::new(),
            gradient,
            hessian,
        })
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
        let values = run(element, mode, gradient, hessian)?;
        let point = ContactPoint { gap: values.gap, foot: values.foot, normal: values.normal };
        Ok(FacetPoint { point, natural: values.natural })
    }

    /// Gap, foot, normal and natural coordinates, without derivatives.
    ///
    /// # Errors
    /// As [`facet_gap`](Self::facet_gap).
    pub fn facet_point(&self, element: &FacetElement<'_>) -> Result<FacetPoint, ElementError> {
        self.facet_gap_into(element, Mode::Value, &mut [], &mut [])
    }
}

/// Runs the kernel of a checked element.
fn run(
    element: &FacetElement<'_>,
    mode: Mode,
    gradient: &mut [f64],
    hessian: &mut [f64],
) -> Result<FacetValues<f64>, ElementError> {
    let slave = element.slave;
    let values = match *element.corners {
        [a, b, c] => triangle(mode, &FacetInputs { slave, corners: [a, b, c] }, gradient, hessian),
        [a, b, c, d] => quadrilateral(mode, &FacetInputs { slave, corners: [a, b, c, d] }, gradient, hessian),
        _ => return Err(ElementError::FacetCorners { found: element.corners.len() }),
    };
    ElementError::check(values.status())?;
    Ok(values)
}
