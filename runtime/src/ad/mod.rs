//! The element evaluated by forward-mode automatic differentiation.
//!
//! What this backend promises:
//!
//! * It states the element as the paper defines it — weighted fit, foot point, gap — and nothing else. Every
//!   derivative is made by dual numbers; no differentiated formula of the element stands in this folder, so an
//!   error of derivation elsewhere cannot be repeated here.
//! * It exploits nothing that the theory says about the result: all 3(n+1) coordinates are seeded, the slave's
//!   too. That Σ N_i vanishes or that M is symmetric is an outcome, and therefore a test.
//! * A frame that moves with the nodes ([`FrameDerivative::CoMoving`](crate::FrameDerivative)) is the average plane
//!   of the dual masters, found by iteration on dual numbers. The given frame has to be that plane on reals, to 1e-6
//!   radians: [`ElementError::NotAveragePlane`] if it is not, [`ElementError::UnstableAveragePlane`] if there is none.
//! * Any number of master nodes, either basis, and any radial weight, built in or the caller's own.
//! * An `Ok` holds finite numbers only.
//!
//! Speed is no aim: the Hessian of a gap over 24 master nodes takes milliseconds, three times as many if the frame
//! moves. The backend is meant for checking others and for trying out weights.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `weight.rs` | weights as functions of r, and of r² where r has no derivative |
//! | `formula.rs` | weights written as text |
//! | `plane.rs` | the average plane, where the frame moves with it |
//! | `material.rs` | the slave's place in the first configuration, where domains of influence are there |
//! | `linear.rs` | the numbers, and the solution of small systems over them |
//! | `model.rs` | offsets, moment matrix, coefficients (Chamoret et al. 2008, eq. 13) |
//! | `facet.rs` | the distance from a triangle or a quadrilateral |
//! | `foot.rs` | the fitted polynomial, the foot point, the gap (Chamoret et al. 2008, eq. 19) |
//! | `evaluate.rs` | which functions are differentiated, units of the results |
//! | `drive.rs` | which dual numbers are pushed through the model, and how the parts are collected |

mod drive;
mod evaluate;
mod facet;
mod foot;
mod formula;
mod interpolating;
mod linear;
mod material;
mod model;
mod plane;
mod weight;

use crate::{Backend, Coefficients, Element, ElementError, FootDerivatives, Gap, Mode, Point, Slip, Surface};

use model::Model;
use weight::{CentreSeries, WeightFunction};

pub use formula::{Formula, FormulaError};
pub use num_dual::DualNum;
pub use weight::{Interpolating, RadialWeight, WeightError};

/// The automatic differentiation backend.
///
/// `Ad` uses the weight each element names; [`Ad::with_weight_formula`] and [`Ad::with_weight`] make a backend
/// that uses a weight of the caller's instead, whatever the element names.
///
/// ```
/// use diffuse_contact::ad::Ad;
/// use diffuse_contact::{Backend, Basis, Element, Frame, Mode, Weight};
///
/// // Nine master nodes on the plane z = 0, a slave a quarter above it.
/// let masters: Vec<[f64; 3]> = (0..9).map(|i| [f64::from(i % 3), f64::from(i / 3), 0.0]).collect();
/// let element = Element::new([1.1, 0.9, 0.25], &masters, Frame::average_plane(&masters, [0.0, 0.0, 1.0])?, 2.0);
/// let gap = Ad.gap(&element, Mode::Hessian)?;
/// assert!((gap.gap - 0.25).abs() < 1e-14);
/// assert!((gap.gradient[2] - 1.0).abs() < 1e-13); // ∂g/∂z of the slave
///
/// // The same weight as a formula of the user's own.
/// let ad = Ad::with_weight_formula("(1 - r)^2 * (1 + 2*r)")?;
/// let again = ad.gap(&element, Mode::Hessian)?;
/// let difference = gap.hessian.get(5, 2) - again.hessian.get(5, 2);
/// assert!(difference.abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Ad;

/// The automatic differentiation backend with a weight of the caller's, made by [`Ad::with_weight`] or
/// [`Ad::with_weight_formula`]. What [`Element::weight`] names is ignored.
#[derive(Clone, Debug)]
pub struct AdWith<W> {
    weight: W,
    series: CentreSeries,
}

impl Ad {
    /// A backend whose weight is a formula in `r`, such as `"(1 - r)^4 * (1 + 4*r)"`; see [`Formula`] for what
    /// may be written.
    ///
    /// # Errors
    /// [`FormulaError`] with the position of what cannot be read, or with the reason why the formula is no
    /// weight ([`FormulaError::Weight`]).
    pub fn with_weight_formula(text: &str) -> Result<AdWith<Formula>, FormulaError> {
        Ok(Self::with_weight(text.parse::<Formula>()?)?)
    }

    /// A backend whose weight is ω/(1 − ω) for a formula ω in `r` with ω(0) = 1.
    ///
    /// # Errors
    /// As [`with_weight_formula`](Self::with_weight_formula).
    pub fn with_interpolating_formula(text: &str) -> Result<AdWith<Interpolating<Formula>>, FormulaError> {
        Ok(Self::with_weight(Interpolating(text.parse::<Formula>()?))?)
    }

    /// A backend with a weight of the caller's.
    ///
    /// # Errors
    /// [`WeightError`] if the weight is not finite at r = 0 or has a slope there: its derivatives with respect
    /// to the coordinates would not exist when the slave stands straight above a node.
    pub fn with_weight<W: RadialWeight>(weight: W) -> Result<AdWith<W>, WeightError> {
        let series = CentreSeries::of(&weight)?;
        Ok(AdWith { weight, series })
    }

    /// The model of a checked element with the weight it names.
    fn model<'a>(&self, element: &'a Element<'a>) -> Result<Model<'a, crate::Weight>, ElementError> {
        element.validate()?;
        Ok(Model { element, weight: WeightFunction::built_in(&element.weight)? })
    }
}

impl<W: RadialWeight> AdWith<W> {
    /// The model of a checked element with the caller's weight.
    fn model<'a>(&'a self, element: &'a Element<'a>) -> Result<Model<'a, W>, ElementError> {
        element.validate_with(|r| if r < 1.0 { self.weight.evaluate(r) } else { 0.0 })?;
        Ok(Model { element, weight: WeightFunction::new(&self.weight, &self.series) })
    }
}

/// A backend that evaluates its own model of the element.
macro_rules! backend {
    ($($backend:tt)+) => {
        $($backend)+ {
            fn coefficients(&self, element: &Element<'_>, mode: Mode) -> Result<Coefficients, ElementError> {
                evaluate::coefficients(self.model(element)?, mode)
            }

            fn surface(
                &self,
                element: &Element<'_>,
                point: [f64; 2],
                mode: Mode,
            ) -> Result<Surface, ElementError> {
                evaluate::surface(self.model(element)?, point, mode)
            }

            fn gap(&self, element: &Element<'_>, mode: Mode) -> Result<Gap, ElementError> {
                evaluate::gap(self.model(element)?, mode)
            }

            fn foot_derivatives(&self, element: &Element<'_>) -> Result<FootDerivatives, ElementError> {
                evaluate::foot_derivatives(self.model(element)?)
            }

            fn slip(&self, element: &Element<'_>, anchor: Point, mode: Mode) -> Result<Slip, ElementError> {
                evaluate::slip(self.model(element)?, anchor, mode)
            }
        }
    };
}

backend!(impl Backend for Ad);
backend!(impl<W: RadialWeight> Backend for AdWith<W>);

/// Slave and masters, in the order of the degrees of freedom.
fn coordinates_of(element: &Element<'_>) -> Vec<Point> {
    std::iter::once(element.slave).chain(element.masters.iter().copied()).collect()
}

/// An error if one of the numbers is not finite.
fn finite(what: &'static str, numbers: impl IntoIterator<Item = f64>) -> Result<(), ElementError> {
    let sound = numbers.into_iter().all(f64::is_finite);
    if sound { Ok(()) } else { Err(ElementError::Overflow { what }) }
}
