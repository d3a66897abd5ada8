//! The one trait behind which the element is evaluated, whatever computes it.

use crate::{Coefficients, Element, ElementError, FootDerivatives, Gap, Mode, Point, Slip, Surface};

/// Something that evaluates the element: the generated kernels, or automatic differentiation.
///
/// All derivatives are with respect to the 3(n+1) global coordinates, ordered slave, master 1, …,
/// master n, x before y before z. The support radius is held constant; so is the frame, except for the gap of an
/// element whose frame is [`FrameDerivative::CoMoving`](crate::FrameDerivative).
pub trait Backend: Sync {
    /// Coefficients α of the fit about the slave and their derivatives.
    ///
    /// # Errors
    /// Every reason for which the element has no fit; see [`ElementError`].
    fn coefficients(&self, element: &Element<'_>, mode: Mode) -> Result<Coefficients, ElementError>;

    /// The fitted surface at a fixed in-plane offset `point` = (u1, u2) from the slave's projection,
    /// in length units along t1 and t2. The offset is held constant while differentiating.
    ///
    /// # Errors
    /// Every reason for which the element has no fit; see [`ElementError`].
    fn surface(&self, element: &Element<'_>, point: [f64; 2], mode: Mode) -> Result<Surface, ElementError>;

    /// Gap, foot point and unit normal, the gap's gradient N and Hessian M.
    ///
    /// # Errors
    /// Every reason for which the element has no gap; see [`ElementError`].
    fn gap(&self, element: &Element<'_>, mode: Mode) -> Result<Gap, ElementError>;

    /// The foot with the masters' weights in it, and first derivatives of foot and normal.
    ///
    /// # Errors
    /// Every reason for which the element has no gap; see [`ElementError`].
    fn foot_derivatives(&self, element: &Element<'_>) -> Result<FootDerivatives, ElementError>;

    /// Gap and normal with the slip from an anchor: q, ∇q and ∇²q with respect to the 3(n+2) coordinates of slave, masters and anchor, and
    /// the masters' weights in the foot. `anchor` is where the anchor is today, global axes, length.
    ///
    /// # Errors
    /// Every reason for which the element has no gap, and [`ElementError::NonFiniteInput`] for an anchor that is no point.
    fn slip(&self, element: &Element<'_>, anchor: Point, mode: Mode) -> Result<Slip, ElementError>;
}
