//! From the model to the outputs of a backend: which functions are differentiated, and in which units the
//! results are handed out.

use num_dual::Dual64;

use super::drive::{Derivatives, Quantity, differentiate, differentiate_at};
use super::foot::{Foot, Polynomial};
use super::linear::Scalar;
use super::material::Place;
use super::model::Model;
use super::plane::{AveragePlane, Turn};
use super::{RadialWeight, coordinates_of, finite};
use crate::{
    Basis, Coefficients, Domains, Element, ElementError, FootDerivatives, FrameDerivative, Gap, Mode, Point,
    Slip, Surface,
};

/// [`Backend::coefficients`](crate::Backend::coefficients).
pub(super) fn coefficients<W: RadialWeight>(
    model: Model<'_, W>,
    mode: Mode,
) -> Result<Coefficients, ElementError> {
    let element = model.element;
    let mut fit = differentiate(&FitQuantity(model), element, mode)?;
    scale_coefficients(&mut fit, element.basis, element.support_radius)?;
    Ok(Coefficients { values: fit.values, gradients: fit.gradients, hessians: fit.hessians })
}

/// [`Backend::surface`](crate::Backend::surface).
pub(super) fn surface<W: RadialWeight>(
    model: Model<'_, W>,
    point: [f64; 2],
    mode: Mode,
) -> Result<Surface, ElementError> {
    if let Some(index) = point.iter().position(|u| !u.is_finite()) {
        return Err(ElementError::NonFiniteInput { what: "point", index });
    }
    let element = model.element;
    let radius = element.support_radius;
    let scaled = point.map(|u| u / radius);
    let curvatures = model.fit(&coordinates_of(element))?.curvatures(scaled).map(|f_kl| f_kl / radius);
    finite("curvature", curvatures)?;
    let quantity = SurfaceQuantity { model, point: scaled };
    let mut surface = differentiate(&quantity, element, mode)?;
    surface.scale(0, radius, 1)?;
    surface.scale(1, radius, 0)?;
    surface.scale(2, radius, 0)?;
    let mut gradients = surface.gradients.into_iter();
    let mut next = || gradients.next().unwrap_or_default();
    let (gradient, slope_gradients) = (next(), [next(), next()]);
    Ok(Surface {
        value: surface.values[0],
        slopes: [surface.values[1], surface.values[2]],
        curvatures,
        gradient,
        slope_gradients,
        hessian: surface.hessians.into_iter().next().unwrap_or_default(),
    })
}

/// [`Backend::gap`](crate::Backend::gap).
pub(super) fn gap<W: RadialWeight>(model: Model<'_, W>, mode: Mode) -> Result<Gap, ElementError> {
    Ok(at_foot(model, mode)?.0)
}

/// [`Backend::slip`](crate::Backend::slip).
pub(super) fn slip<W: RadialWeight>(
    model: Model<'_, W>,
    anchor: Point,
    mode: Mode,
) -> Result<Slip, ElementError> {
    ElementError::check_points("anchor", &[anchor])?;
    let element = model.element;
    let radius = element.support_radius;
    let (contact, quantity) = at_foot(model, mode)?;
    let foot_weights = if mode > Mode::Value { quantity.foot_weights()? } else { Vec::new() };
    let coordinates: Vec<Point> = coordinates_of(element).into_iter().chain([anchor]).collect();
    let mut slip = differentiate_at(&SlipQuantity(quantity), &coordinates, radius, mode)?;
    slip.scale(0, radius, 2)?;
    Ok(slip_of(contact, slip, foot_weights))
}

/// Of the derivatives of q.
pub(super) fn slip_of(contact: Gap, q: Derivatives, foot_weights: Vec<f64>) -> Slip {
    Slip {
        contact,
        half_square: q.values[0],
        gradient: q.gradients.into_iter().next().unwrap_or_default(),
        hessian: q.hessians.into_iter().next().unwrap_or_default(),
        foot_weights,
    }
}

/// [`Backend::foot_derivatives`](crate::Backend::foot_derivatives).
pub(super) fn foot_derivatives<W: RadialWeight>(
    model: Model<'_, W>,
) -> Result<FootDerivatives, ElementError> {
    let element = model.element;
    let (contact, quantity) = at_foot(model, Mode::Gradient)?;
    let weights = quantity.foot_weights()?;
    let mut all = differentiate(&FootQuantity(quantity), element, Mode::Gradient)?;
    for k in 0..3 {
        all.scale(k, element.support_radius, 1)?;
        all.scale(3 + k, element.support_radius, 0)?;
    }
    let (foot, normal) = all.gradients.split_at(3);
    Ok(FootDerivatives { point: contact.point(), weights, foot: foot.concat(), normal: normal.concat() })
}

/// The gap, and what follows plane and foot through dual numbers.
fn at_foot<W: RadialWeight>(
    model: Model<'_, W>,
    mode: Mode,
) -> Result<(Gap, GapQuantity<'_, W>), ElementError> {
    let element = model.element;
    let radius = element.support_radius;
    let polynomial = model.fit(&coordinates_of(element))?;
    let moves = element.frame.derivative == FrameDerivative::CoMoving;
    let plane = if moves {
        Some(AveragePlane::find(element, &model.plane_weights(&coordinates_of(element)))?)
    } else {
        None
    };
    let place = match (&plane, element.domains) {
        (Some(plane), Domains::Material(_)) => Some(Place::find(&model, plane, &coordinates_of(element))?),
        _ => None,
    };
    let plane = plane.filter(|_| mode > Mode::Value);
    let foot = Foot::find(&polynomial)?;
    let (foot_point, normal) = global_foot(element, &polynomial, foot.position());
    finite("foot", foot_point)?;
    finite("normal", normal)?;
    let mut fit = Derivatives::of_values(polynomial.coefficients[..element.basis.size()].to_vec());
    scale_coefficients(&mut fit, element.basis, radius)?;

    let quantity = GapQuantity { model, plane, place, foot };
    let mut gap = differentiate(&quantity, element, mode)?;
    gap.scale(0, radius, 1)?;
    let gap = Gap {
        gap: gap.values[0],
        foot: foot_point,
        normal,
        coefficients: fit.values,
        gradient: gap.gradients.into_iter().next().unwrap_or_default(),
        hessian: gap.hessians.into_iter().next().unwrap_or_default(),
    };
    Ok((gap, quantity))
}

/// The six coefficients α as functions of the coordinates.
struct FitQuantity<'a, W>(Model<'a, W>);

impl<W: RadialWeight> Quantity for FitQuantity<'_, W> {
    fn evaluate<D: Scalar>(&self, coordinates: &[[D; 3]]) -> Result<Vec<D>, ElementError> {
        let polynomial = self.0.fit(coordinates)?;
        Ok(polynomial.coefficients[..self.0.element.basis.size()].to_vec())
    }
}

/// f, f_1 and f_2 at a fixed in-plane point as functions of the coordinates.
struct SurfaceQuantity<'a, W> {
    model: Model<'a, W>,
    point: [f64; 2],
}

impl<W: RadialWeight> Quantity for SurfaceQuantity<'_, W> {
    fn evaluate<D: Scalar>(&self, coordinates: &[[D; 3]]) -> Result<Vec<D>, ElementError> {
        let polynomial = self.model.fit(coordinates)?;
        let u = self.point.map(D::from);
        let [f_1, f_2] = polynomial.slopes(u);
        Ok(vec![polynomial.value(u), f_1, f_2])
    }
}

/// The gap as a function of the coordinates, followed through Newton's iterations from the average plane, if the
/// frame moves with it, and from the converged foot.
struct GapQuantity<'a, W> {
    model: Model<'a, W>,
    plane: Option<AveragePlane>,
    place: Option<Place>,
    foot: Foot,
}

impl<W: RadialWeight> GapQuantity<'_, W> {
    /// The fit in the frame that has moved with the nodes, and how far that has turned.
    fn fit<D: Scalar>(&self, coordinates: &[[D; 3]]) -> Result<(Polynomial<D>, Turn<D>), ElementError> {
        let (turn, shift) = match (&self.plane, &self.place) {
            (None, _) => return Ok((self.model.fit(coordinates)?, identity())),
            (Some(plane), None) => {
                let weights = self.model.plane_weights(coordinates);
                (plane.propagate(&coordinates[1..], &weights), None)
            }
            (Some(plane), Some(place)) => {
                let (shift, turn) = place.propagate(&self.model, plane, coordinates);
                (turn, Some(shift))
            }
        };
        Ok((self.model.fit_in(coordinates, &turn, shift)?, turn))
    }

    /// φ_k = ∂f(u)/∂z_k at the foot: heights are seeded, in-plane offsets and frame held.
    fn foot_weights(&self) -> Result<Vec<f64>, ElementError> {
        let u = self.foot.position().map(Dual64::from);
        let coordinates = coordinates_of(self.model.element);
        let weight = |k: usize| {
            let fit = self.model.fit_with_raised_node(&coordinates, k)?;
            Ok(fit.value(u).eps)
        };
        (0..self.model.element.masters.len()).map(weight).collect()
    }
}

impl<W: RadialWeight> Quantity for GapQuantity<'_, W> {
    fn evaluate<D: Scalar>(&self, coordinates: &[[D; 3]]) -> Result<Vec<D>, ElementError> {
        let (polynomial, _) = self.fit(coordinates)?;
        let u = self.foot.propagate(&polynomial);
        Ok(vec![polynomial.gap(u)])
    }
}

/// The foot over R and the normal, in global axes, as functions of the coordinates.
struct FootQuantity<'a, W>(GapQuantity<'a, W>);

impl<W: RadialWeight> Quantity for FootQuantity<'_, W> {
    fn evaluate<D: Scalar>(&self, coordinates: &[[D; 3]]) -> Result<Vec<D>, ElementError> {
        let Self(contact) = self;
        let (polynomial, turn) = contact.fit(coordinates)?;
        let u = contact.foot.propagate(&polynomial);
        let [f_1, f_2] = polynomial.slopes(u);
        let length = (f_1 * f_1 + f_2 * f_2 + 1.0).sqrt();
        let nu = [-f_1 / length, -f_2 / length, length.recip()];
        let element = contact.model.element;
        // The turn leads into the frame that has moved, its transpose back.
        let global = |local: [D; 3]| -> [D; 3] {
            let held: [D; 3] =
                std::array::from_fn(|k| (0..3).map(|row| turn[row][k] * local[row]).sum::<D>());
            let rows = element.frame.rows();
            std::array::from_fn(|k| (0..3).map(|row| held[row] * rows[row][k]).sum::<D>())
        };
        let from_slave = global([u[0], u[1], polynomial.value(u)]);
        let foot = (0..3).map(|k| coordinates[0][k] / element.support_radius + from_slave[k]);
        Ok(foot.chain(global(nu)).collect())
    }
}

/// q = ½ |P_ν d|² over R² (docs/equations.md, T16) as a function of the coordinates of slave, masters and anchor, the last ones.
struct SlipQuantity<'a, W>(GapQuantity<'a, W>);

impl<W: RadialWeight> Quantity for SlipQuantity<'_, W> {
    fn evaluate<D: Scalar>(&self, coordinates: &[[D; 3]]) -> Result<Vec<D>, ElementError> {
        let Self(contact) = self;
        let (anchor, coordinates) = coordinates.split_last().expect("slave, masters and anchor");
        let (polynomial, turn) = contact.fit(coordinates)?;
        let u = contact.foot.propagate(&polynomial);
        let element = contact.model.element;
        let offset: [D; 3] =
            std::array::from_fn(|k| (coordinates[0][k] - anchor[k]) / element.support_radius);
        let local = element.frame.rows().map(|[x, y, z]| offset[0] * x + offset[1] * y + offset[2] * z);
        let d = turn.map(|[x, y, z]| x * local[0] + y * local[1] + z * local[2]);
        let [f_1, f_2] = polynomial.slopes(u);
        let length = (f_1 * f_1 + f_2 * f_2 + 1.0).sqrt();
        let nu = [-f_1 / length, -f_2 / length, length.recip()];
        let along = nu[0] * d[0] + nu[1] * d[1] + nu[2] * d[2];
        let square = (0..3).map(|k| (d[k] - nu[k] * along).powi(2)).sum::<D>();
        Ok(vec![square * 0.5])
    }
}

/// No turn.
fn identity<D: Scalar>() -> Turn<D> {
    std::array::from_fn(|i| std::array::from_fn(|j| D::from(if i == j { 1.0 } else { 0.0 })))
}

/// Foot x^d and normal ν = (−f_1, −f_2, 1)/ℓ (Chamoret et al. 2008, eq. 22) in global axes.
fn global_foot(element: &Element<'_>, polynomial: &Polynomial<f64>, u: [f64; 2]) -> (Point, Point) {
    let to_global = |local: [f64; 3]| {
        let [t1, t2, n] = element.frame.rows();
        std::array::from_fn::<f64, 3, _>(|k| t1[k] * local[0] + t2[k] * local[1] + n[k] * local[2])
    };
    let offset = to_global([u[0], u[1], polynomial.value(u)]);
    let foot = std::array::from_fn(|k| element.slave[k] + element.support_radius * offset[k]);
    let [f_1, f_2] = polynomial.slopes(u);
    let length = (1.0 + f_1 * f_1 + f_2 * f_2).sqrt();
    (foot, to_global([-f_1 / length, -f_2 / length, 1.0 / length]))
}

/// From coefficients of lengths over R to coefficients of lengths: α of a monomial of degree d has the unit
/// length^(1 − d).
fn scale_coefficients(fit: &mut Derivatives, basis: Basis, radius: f64) -> Result<(), ElementError> {
    let degrees = basis.monomials().iter().map(|&(i, j)| i32::from(i) + i32::from(j));
    degrees.enumerate().try_for_each(|(k, degree)| fit.scale(k, radius, 1 - degree))
}
