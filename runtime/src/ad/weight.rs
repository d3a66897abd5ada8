//! Weights: functions of r = (in-plane distance from the slave) / (support radius), over any kind of number.
//!
//! r = √s has no derivative at s = 0, where the slave stands straight above a node; the weight, with
//! w'(0) = 0, has: it is a function of s = r² there. Near r = 0 it is therefore evaluated from its own Taylor
//! series, w = Σ c_k r^k, whose even terms are powers of s and whose odd terms begin with r³ = s√s, which is
//! twice differentiable with vanishing derivatives at s = 0.
//!
//! # Where the series ends
//! Outside, the chain rule multiplies w'(r) by ∂²r/∂a² of order 1/r. Where the formula lets w' cancel — the
//! derivative of (1−r)²(1+2r) is a difference of two numbers near 2 — the second derivative has the error ε/r:
//! 2e-12 at r = 1e-4, two digits only at r = 1e-14, long before anything underflows. A series cut after second
//! order, exact at r = 0, leaves an error r w''' and would meet ε/r at 1e-8 only. The series is taken through
//! order 8: at r = 1e-2 its second derivative is off by w⁽⁹⁾ 1e-14/7! and w⁽¹⁰⁾ 1e-16/8!, below 1e-13 for
//! weights that vary over the whole support (the polynomial weights are exact), and the chain rule outside by
//! 2e-14. A formula that varies faster, or has a branch closer to the centre, gets a smaller radius: the
//! largest power of ten at which series and formula agree.

use std::borrow::Cow;

use num_dual::{Dual2, Dual3, DualNum};

use super::linear::Scalar;
use crate::{ElementError, Weight};

/// A weight function of r, for 0 ≤ r < 1; it counts as zero outside.
///
/// It has to be finite and have a vanishing slope at r = 0, and it should be positive inside, else the fit may
/// be singular.
///
/// ```
/// use diffuse_contact::ad::{Ad, DualNum, RadialWeight};
///
/// /// (1 − r)⁴ (1 + 4r), twice differentiable at r = 1.
/// struct Wendland;
///
/// impl RadialWeight for Wendland {
///     fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, r: D) -> D {
///         (-r + 1.0).powi(4) * (r * 4.0 + 1.0)
///     }
/// }
///
/// let ad = Ad::with_weight(Wendland)?;
/// # Ok::<(), diffuse_contact::ad::WeightError>(())
/// ```
pub trait RadialWeight: Sync {
    /// w(r); of an interpolating weight ω(r).
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, r: D) -> D;

    /// Whether the weight is ω/(1 − ω) (Chamoret et al. 2008, eq. 16) with the ω that [`evaluate`](Self::evaluate) returns;
    /// ω(0) has to be 1.
    fn is_interpolating(&self) -> bool {
        false
    }
}

/// A weight ω made interpolating: ω/(1 − ω).
#[derive(Clone, Copy, Debug)]
pub struct Interpolating<W>(pub W);

impl<W: RadialWeight> RadialWeight for Interpolating<W> {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, r: D) -> D {
        self.0.evaluate(r)
    }

    fn is_interpolating(&self) -> bool {
        true
    }
}

impl RadialWeight for Weight {
    fn evaluate<D: DualNum<Primitive = f64> + Copy>(&self, r: D) -> D {
        match self {
            // 1 − 3r² + 2r³ (Chamoret et al. 2008, eq. 14)
            Self::Cubic => r * r * (r * 2.0 - 3.0) + 1.0,
            #[cfg(feature = "interpolating")]
            Self::CubicInterpolating => Self::Cubic.evaluate(r),
            Self::WendlandC2 => (-r + 1.0).powi(4) * (r * 4.0 + 1.0),
        }
    }

    fn is_interpolating(&self) -> bool {
        Self::is_interpolating(*self)
    }
}

/// Why a function of r cannot serve as a weight.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum WeightError {
    /// The function or one of its derivatives is not finite at r = 0. The `order` of the function itself is 0.
    #[error("the weight has no finite derivative of order {order} at r = 0")]
    NotFiniteAtCentre { order: usize },
    /// A weight to be made interpolating is not 1 at r = 0.
    #[error("the weight is {value} at r = 0, but has to be 1 there to be made interpolating")]
    NotOneAtCentre { value: f64 },
    /// The slope at r = 0 is not zero: a cone, which has no derivative when the slave is straight above a node.
    #[error("the weight has the slope {slope:e} at r = 0, where it has to be flat")]
    SlopeAtCentre { slope: f64 },
}

/// Order of the Taylor series about r = 0.
const ORDER: usize = 8;
/// |w'(0)| up to this times 1 + |w(0)| is rounding.
const SLOPE_TOLERANCE: f64 = 1e-12;
/// Difference of series and formula, relative to 1 + |w(0)| + |w''(0)|, up to which the series is used.
const AGREEMENT: f64 = 1e-12;
/// The largest and the smallest radius of the series; see the head of this file.
const RADII: [f64; 11] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12];
/// Below this s the odd terms, of order s√s, are far below rounding, and powers of 1/s may overflow.
const NO_ODD_TERMS: f64 = 1e-100;

/// Taylor series of a weight about r = 0, and the radius inside which it takes the formula's place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CentreSeries {
    coefficients: [f64; ORDER + 1],
    radius: f64,
}

impl CentreSeries {
    /// Expands a weight; fails if it is not finite or not flat at r = 0.
    pub(super) fn of<W: RadialWeight>(weight: &W) -> Result<Self, WeightError> {
        let derivatives = derivatives_at_centre(weight);
        if let Some(order) = derivatives.iter().position(|w| !w.is_finite()) {
            return Err(WeightError::NotFiniteAtCentre { order });
        }
        let slope = derivatives[1];
        if slope.abs() > SLOPE_TOLERANCE * (1.0 + derivatives[0].abs()) {
            return Err(WeightError::SlopeAtCentre { slope });
        }
        if weight.is_interpolating() && (derivatives[0] - 1.0).abs() > SLOPE_TOLERANCE {
            return Err(WeightError::NotOneAtCentre { value: derivatives[0] });
        }
        let mut coefficients = derivatives;
        let mut factorial = 1.0;
        for (order, coefficient) in coefficients.iter_mut().enumerate().skip(1) {
            factorial *= order as f64;
            *coefficient /= factorial;
        }
        let mut series = Self { coefficients, radius: 0.0 };
        let size = 1.0 + derivatives[0].abs() + derivatives[2].abs();
        let agrees =
            |radius: f64| [1.0, 0.75, 0.5, 0.25].iter().all(|f| series.agrees(weight, f * radius, size));
        series.radius = RADII.into_iter().find(|radius| agrees(*radius)).unwrap_or(RADII[10]);
        Ok(series)
    }

    /// The series at s = r².
    fn at_square<D: Scalar>(&self, s: D) -> D {
        self.change_at_square(s) + self.coefficients[0]
    }

    /// The series without its constant.
    fn change_at_square<D: Scalar>(&self, s: D) -> D {
        let c = &self.coefficients;
        let even = (((s * c[8] + c[6]) * s + c[4]) * s + c[2]) * s;
        if s.re() <= NO_ODD_TERMS {
            return even;
        }
        even + ((s * c[7] + c[5]) * s + c[3]) * s * s.sqrt()
    }

    /// Whether series and formula have the same value and second derivative at r.
    fn agrees<W: RadialWeight>(&self, weight: &W, r: f64, size: f64) -> bool {
        let r = Dual2::from_re(r).derivative();
        let difference = self.at_square(r * r) - weight.evaluate(r);
        difference.re.abs() <= AGREEMENT * size && difference.v2.abs() <= AGREEMENT * size
    }
}

/// w and its derivatives at r = 0: dual numbers of second and twice third order, one inside the other, give
/// orders up to eight.
fn derivatives_at_centre<W: RadialWeight>(weight: &W) -> [f64; ORDER + 1] {
    let inner = Dual2::from_re(0.0).derivative();
    let middle = Dual3::from_re(inner).derivative();
    let w = weight.evaluate(Dual3::from_re(middle).derivative());
    [
        w.re.re.re, w.re.re.v1, w.re.re.v2, w.re.v1.v2, w.re.v2.v2, w.re.v3.v2, w.v1.v3.v2, w.v2.v3.v2,
        w.v3.v3.v2,
    ]
}

/// The weight in force for an element, as a function of r².
pub(super) struct WeightFunction<'a, W> {
    weight: &'a W,
    series: Cow<'a, CentreSeries>,
}

impl<'a, W: RadialWeight> WeightFunction<'a, W> {
    /// A weight with its series.
    pub(super) const fn new(weight: &'a W, series: &'a CentreSeries) -> Self {
        Self { weight, series: Cow::Borrowed(series) }
    }

    /// A weight that is expanded now.
    pub(super) fn built_in(weight: &'a W) -> Result<Self, ElementError> {
        let series = CentreSeries::of(weight).map_err(|_| ElementError::Overflow { what: "weight" })?;
        Ok(Self { weight, series: Cow::Owned(series) })
    }

    /// Whether the weight has a pole at r = 0.
    pub(super) fn is_interpolating(&self) -> bool {
        self.weight.is_interpolating()
    }

    /// 1 − ω at s = r² < 1 for ω(0) = 1, without cancellation near r = 0.
    pub(super) fn complement_at_square<D: Scalar>(&self, s: D) -> D {
        if s.re() < self.series.radius * self.series.radius {
            return -self.series.change_at_square(s);
        }
        -self.weight.evaluate(s.sqrt()) + 1.0
    }

    /// w, or ω of an interpolating weight, at s = r² < 1.
    pub(super) fn at_square<D: Scalar>(&self, s: D) -> D {
        if s.re() < self.series.radius * self.series.radius {
            return self.series.at_square(s);
        }
        self.weight.evaluate(s.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use num_dual::HyperDual;

    use super::super::Formula;
    use super::*;

    fn formula(text: &str) -> Formula {
        text.parse().unwrap()
    }

    #[test]
    fn the_cubic_is_its_own_series() {
        let series = CentreSeries::of(&Weight::Cubic).unwrap();
        assert_eq!(series.coefficients, [1.0, 0.0, -3.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(series.radius, 1e-2);
    }

    #[test]
    fn the_exponential_has_the_known_series() {
        let series = CentreSeries::of(&formula("exp(-r^2)")).unwrap();
        let expected = [1.0, 0.0, -1.0, 0.0, 0.5, 0.0, -1.0 / 6.0, 0.0, 1.0 / 24.0];
        for (found, expected) in series.coefficients.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-15, "{series:?}");
        }
        assert_eq!(series.radius, 1e-2);
    }

    /// ∂²w/∂a², ∂²w/∂a∂b of the cubic weight by the chain rule, exact.
    fn cubic_reference(a: f64, b: f64) -> [f64; 2] {
        let r = a.hypot(b);
        let (w_r_over_r, w_rr) = (-6.0 + 6.0 * r, -6.0 + 12.0 * r);
        let (c, s) = if r == 0.0 { (1.0, 0.0) } else { (a / r, b / r) };
        [w_rr * c * c + w_r_over_r * s * s, (w_rr - w_r_over_r) * c * s]
    }

    #[test]
    fn second_derivatives_hold_at_every_distance() {
        let formula = formula("(1 - r)^2 * (1 + 2*r)");
        let series = CentreSeries::of(&formula).unwrap();
        let weight = WeightFunction::new(&formula, &series);
        let distances =
            [0.0, 1e-300, 1e-160, 1e-120, 1e-60, 1e-49, 1e-20, 1e-8, 1e-4, 9e-3, 1.1e-2, 0.3, 0.99];
        for r in distances {
            let (a, b) = (0.6 * r, 0.8 * r);
            let a = HyperDual::from_re(a).derivative1().derivative2();
            let w = weight.at_square(a * a + b * b);
            let [w_aa, _] = cubic_reference(a.re, b);
            assert!((w.eps1eps2 - w_aa).abs() < 2e-13, "r = {r:e}: {} {w_aa}", w.eps1eps2);
            let a = HyperDual::from_re(a.re).derivative1();
            let b = HyperDual::from_re(b).derivative2();
            let w = weight.at_square(a * a + b * b);
            let [_, w_ab] = cubic_reference(a.re, b.re);
            assert!((w.eps1eps2 - w_ab).abs() < 2e-13, "r = {r:e}: {} {w_ab}", w.eps1eps2);
        }
    }

    #[test]
    fn a_branch_near_the_centre_is_kept() {
        let guarded = formula("if r < 0.00001 { 1 } else { 1 - 3*r^2 + 2*r^3 }");
        let series = CentreSeries::of(&guarded).unwrap();
        assert_eq!(series.radius, 1e-6);
        let fast = CentreSeries::of(&formula("exp(-10000*r^2)")).unwrap();
        assert!(fast.radius < 1e-2);
    }

    #[test]
    fn cones_and_poles_are_refused() {
        assert_eq!(
            CentreSeries::of(&formula("1 - r")).unwrap_err(),
            WeightError::SlopeAtCentre { slope: -1.0 }
        );
        assert_eq!(
            CentreSeries::of(&formula("1/r - 1")).unwrap_err(),
            WeightError::NotFiniteAtCentre { order: 0 }
        );
        assert!(matches!(
            CentreSeries::of(&formula("1 - r*sqrt(r)")).unwrap_err(),
            WeightError::NotFiniteAtCentre { .. }
        ));
    }
}
