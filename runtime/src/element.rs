//! One contact element: a slave node, its master nodes, and the data held fixed between updates.

use crate::{Basis, ElementError, Frame, FrameDerivative, Point};

/// Weight function of the fit, a function of r = (in-plane distance from the slave) / (support radius).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Weight {
    /// 1 − 3r² + 2r³ inside the support radius, 0 outside (Chamoret et al. 2008, eq. 14).
    #[default]
    Cubic,
    /// ω/(1 − ω) with ω the cubic weight (Chamoret et al. 2008, eq. 16): infinite at a node, so that the surface
    /// passes through the master nodes.
    CubicInterpolating,
    /// (1 − r)⁴ (1 + 4r) inside the support radius, 0 outside (Wendland 1995): twice differentiable at r = 1, where
    /// the cubic weight's second derivative jumps.
    WendlandC2,
}

impl Weight {
    /// All weights.
    pub const ALL: [Self; 3] = [Self::Cubic, Self::CubicInterpolating, Self::WendlandC2];

    /// Name in input and output files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cubic => "cubic",
            Self::CubicInterpolating => "cubic-interpolating",
            Self::WendlandC2 => "wendland-c2",
        }
    }
}

/// What one evaluation needs: current positions, and the pairing data that stays fixed while differentiating.
#[derive(Clone, Copy, Debug)]
pub struct Element<'a> {
    /// Slave node x^c.
    pub slave: Point,
    /// Master nodes x^1 … x^n.
    pub masters: &'a [Point],
    /// Local frame (t1, t2, n̂); n̂ points to the outward side of the master surface.
    pub frame: Frame,
    /// Radius R of the domain of influence around the slave, measured in the plane (t1, t2).
    pub support_radius: f64,
    /// Polynomial basis of the fit.
    pub basis: Basis,
    /// Weight function of the fit.
    pub weight: Weight,
}

impl Element<'_> {
    /// Number of global coordinates the gap depends on, 3(n+1).
    #[must_use]
    pub const fn degrees_of_freedom(&self) -> usize {
        3 * (self.masters.len() + 1)
    }

    /// Index of the master node nearest to the slave in the plane (t1, t2), the first of several; 0 if there are none.
    #[must_use]
    pub fn nearest_in_plane(&self) -> usize {
        nearest_in_plane(self.slave, self.masters.iter().copied(), &self.frame, self.support_radius)
    }

    /// Checks what no kernel can repair: enough master nodes, finite input, positive support radius, orthonormal
    /// frame.
    ///
    /// # Errors
    /// [`ElementError::NoKernels`] for a custom basis that can have none, [`ElementError::TooFewNodes`],
    /// [`ElementError::NonFiniteInput`], [`ElementError::InvalidSupportRadius`],
    /// [`ElementError::InvalidFrame`], [`ElementError::NotAveragePlane`], [`ElementError::AnisotropicBasis`].
    pub fn validate(&self) -> Result<(), ElementError> {
        if !self.basis.is_sound() {
            return Err(ElementError::NoKernels { basis: self.basis.name() });
        }
        let needed = self.basis.size();
        if self.masters.len() < needed {
            return Err(ElementError::TooFewNodes { found: self.masters.len(), needed });
        }
        if !self.slave.iter().all(|x| x.is_finite()) {
            return Err(ElementError::NonFiniteInput { what: "slave", index: 0 });
        }
        for (index, master) in self.masters.iter().enumerate() {
            if !master.iter().all(|x| x.is_finite()) {
                return Err(ElementError::NonFiniteInput { what: "master", index });
            }
        }
        if !(self.support_radius.is_finite() && self.support_radius > 0.0) {
            return Err(ElementError::InvalidSupportRadius { value: self.support_radius });
        }
        if self.frame.derivative == FrameDerivative::CoMoving && !self.basis.is_isotropic() {
            return Err(ElementError::AnisotropicBasis { basis: self.basis.name() });
        }
        self.frame.check()?;
        self.frame.check_average_plane(self.masters)
    }
}

/// As [`Element::nearest_in_plane`].
pub(crate) fn nearest_in_plane(
    slave: Point,
    masters: impl Iterator<Item = Point>,
    frame: &Frame,
    support_radius: f64,
) -> usize {
    let square = |master: Point| {
        let offset = [master[0] - slave[0], master[1] - slave[1], master[2] - slave[2]];
        let along = |t: Point| (t[0] * offset[0] + t[1] * offset[1] + t[2] * offset[2]) / support_radius;
        let (a, b) = (along(frame.t1), along(frame.t2));
        a * a + b * b
    };
    let squares = masters.map(square).enumerate();
    squares.min_by(|x, y| x.1.total_cmp(&y.1)).map_or(0, |(index, _)| index)
}
