//! The distance from a facet, over any kind of number.
//!
//! A triangle has the closed form n·(x^c − x^1)/‖n‖ with n = (x^2 − x^1) × (x^3 − x^1). On a quadrilateral the foot
//! minimises the squared distance: it is found on reals by descent from the middle, and its derivatives come from
//! Newton steps over dual numbers taken there. Tangents and Jacobians are made by dual numbers too.

use num_dual::Dual;

use super::drive::{Quantity, differentiate_at};
use super::evaluate::slip_of;
use super::linear::{Scalar, determinant, dot, inverse};
use super::{Ad, finite};
use crate::{ContactPoint, ElementError, FacetElement, FacetPoint, FootDerivatives, Gap, Mode, Point, Slip};

/// Steps of the descent after which it gives up.
const MAX_ITERATIONS: usize = 200;
/// Steps are halved at most this often.
const MAX_HALVINGS: usize = 60;
/// Residual accepted, relative to the size of the terms it is made of.
const RESIDUAL_ACCEPTED: f64 = 1e-13;
/// Newton steps over dual numbers: each makes one more order of derivatives exact, the others wash out rounding.
const PROPAGATION_STEPS: usize = 4;
/// Bound on the area spanned at a corner or at the foot, relative to the squared size of the facet.
const AREA_TOLERANCE: f64 = 1e-7;
/// Bound on the Jacobian's determinant over that of a flat facet.
const DETERMINANT_TOLERANCE: f64 = 1e-7;
/// Natural coordinates of a quadrilateral's middle.
const MIDDLE: [f64; 2] = [0.0, 0.0];
/// Natural coordinates of a quadrilateral's corners.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

impl Ad {
    /// The gap on a facet, the counterpart of [`Generated::facet_gap`](crate::Generated::facet_gap).
    ///
    /// # Errors
    /// As there. Next to a tolerance one of the two may report an error where the other does not.
    pub fn facet_gap(&self, element: &FacetElement<'_>, mode: Mode) -> Result<Gap, ElementError> {
        self.facet_gap_near(element, MIDDLE, mode)
    }

    /// As [`facet_gap`](Self::facet_gap), with the search for the foot started at other natural coordinates than the
    /// middle. A strongly warped quadrilateral can have several feet: this confirms one that another backend found.
    ///
    /// # Errors
    /// As [`facet_gap`](Self::facet_gap); [`ElementError::NonFiniteInput`] if the start is not finite.
    pub fn facet_gap_near(
        &self,
        element: &FacetElement<'_>,
        natural: [f64; 2],
        mode: Mode,
    ) -> Result<Gap, ElementError> {
        if let Some(index) = natural.iter().position(|x| !x.is_finite()) {
            return Err(ElementError::NonFiniteInput { what: "natural coordinate", index });
        }
        let distance = Distance::of(element, natural)?;
        let FacetPoint { point, .. } = distance.point(element)?;
        let coordinates: Vec<Point> =
            std::iter::once(element.slave).chain(element.corners.iter().copied()).collect();
        let mut gap = differentiate_at(&distance, &coordinates, distance.size, mode)?;
        gap.scale(0, distance.size, 1)?;
        Ok(Gap {
            gap: gap.values[0],
            foot: point.foot,
            normal: point.normal,
            coefficients: Vec::new(),
            gradient: gap.gradients.into_iter().next().unwrap_or_default(),
            hessian: gap.hessians.into_iter().next().unwrap_or_default(),
        })
    }

    /// The foot on a facet with first derivatives, the counterpart of
    /// [`Generated::facet_foot_derivatives`](crate::Generated::facet_foot_derivatives).
    ///
    /// # Errors
    /// As [`facet_gap`](Self::facet_gap).
    pub fn facet_foot_derivatives(
        &self,
        element: &FacetElement<'_>,
    ) -> Result<FootDerivatives, ElementError> {
        let distance = Distance::of(element, MIDDLE)?;
        let size = distance.size;
        let FacetPoint { point, natural } = distance.point(element)?;
        let coordinates: Vec<Point> =
            std::iter::once(element.slave).chain(element.corners.iter().copied()).collect();
        let mut all = differentiate_at(&FootQuantity(distance), &coordinates, size, Mode::Gradient)?;
        for k in 0..3 {
            all.scale(k, size, 1)?;
            all.scale(3 + k, size, 0)?;
        }
        let weights = shape_functions(element, natural);
        let (foot, normal) = all.gradients.split_at(3);
        Ok(FootDerivatives { point, weights, foot: foot.concat(), normal: normal.concat() })
    }

    /// The slip on a facet, the counterpart of [`Generated::facet_slip`](crate::Generated::facet_slip).
    ///
    /// # Errors
    /// As there.
    pub fn facet_slip(
        &self,
        element: &FacetElement<'_>,
        anchor: Point,
        mode: Mode,
    ) -> Result<Slip, ElementError> {
        ElementError::check_points("anchor", &[anchor])?;
        let contact = self.facet_gap(element, mode)?;
        let distance = Distance::of(element, MIDDLE)?;
        let (size, natural) = (distance.size, distance.point(element)?.natural);
        let points = std::iter::once(element.slave).chain(element.corners.iter().copied());
        let coordinates: Vec<Point> = points.chain([anchor]).collect();
        let mut slip = differentiate_at(&SlipQuantity(distance), &coordinates, size, mode)?;
        slip.scale(0, size, 2)?;
        let foot_weights = if mode > Mode::Value { shape_functions(element, natural) } else { Vec::new() };
        Ok(slip_of(contact, slip, foot_weights))
    }

    /// Gap, foot, normal and natural coordinates on a facet, without derivatives.
    ///
    /// # Errors
    /// As [`facet_gap`](Self::facet_gap).
    pub fn facet_point(&self, element: &FacetElement<'_>) -> Result<FacetPoint, ElementError> {
        Distance::of(element, MIDDLE)?.point(element)
    }
}

/// The distance from a facet over its size, which is held.
struct Distance {
    size: f64,
    foot: Option<Foot>,
}

impl Distance {
    fn of(element: &FacetElement<'_>, start: [f64; 2]) -> Result<Self, ElementError> {
        element.validate()?;
        let first = element.corners[0];
        let size = element.corners.iter().flat_map(|x| (0..3).map(|k| (x[k] - first[k]).abs()));
        let size = size.fold(0.0, f64::max);
        finite("size", [size])?;
        if size == 0.0 {
            return Err(ElementError::DegenerateFacet { area: 0.0 });
        }
        let offsets = offsets(element.slave, element.corners, size);
        finite("offset", offsets.iter().flatten().copied())?;
        let foot = match *offsets {
            [a, b, c] => {
                let area = length(cross(minus(b, a), minus(c, a)));
                if !(area > AREA_TOLERANCE) {
                    return Err(ElementError::DegenerateFacet { area });
                }
                None
            }
            [a, b, c, d] => Some(Foot::find(&Bilinear([a, b, c, d]), start)?),
            _ => return Err(ElementError::FacetCorners { found: element.corners.len() }),
        };
        Ok(Self { size, foot })
    }

    fn point(&self, element: &FacetElement<'_>) -> Result<FacetPoint, ElementError> {
        let offsets = offsets(element.slave, element.corners, self.size);
        let (normal, gap, natural) = match (&self.foot, &*offsets) {
            (Some(foot), &[a, b, c, d]) => {
                let facet = Bilinear([a, b, c, d]);
                (facet.normal(foot.natural), facet.gap(foot.natural), foot.natural)
            }
            (_, corners) => {
                let (normal, gap) = plane(corners);
                let [e, f] = [minus(corners[1], corners[0]), minus(corners[2], corners[0])];
                let area = cross(e, f);
                let square = dot(area, area);
                let from_first = corners[0].map(|x| -x);
                let part = |x| dot(x, area) / square;
                (normal, gap, [part(cross(from_first, f)), part(cross(e, from_first))])
            }
        };
        let foot = std::array::from_fn(|k| element.slave[k] - self.size * gap * normal[k]);
        let point = ContactPoint { gap: self.size * gap, foot, normal };
        finite("foot", foot)?;
        finite("normal", normal)?;
        finite("natural coordinate", natural)?;
        Ok(FacetPoint { point, natural })
    }
}

impl Quantity for Distance {
    fn evaluate<D: Scalar>(&self, coordinates: &[[D; 3]]) -> Result<Vec<D>, ElementError> {
        let corners = offsets(coordinates[0], &coordinates[1..], self.size);
        Ok(vec![match (&self.foot, &*corners) {
            (Some(foot), &[a, b, c, d]) => {
                let facet = Bilinear([a, b, c, d]);
                facet.gap(foot.propagate(&facet))
            }
            (_, corners) => plane(corners).1,
        }])
    }
}

fn shape_functions(element: &FacetElement<'_>, [xi, eta]: [f64; 2]) -> Vec<f64> {
    match element.corners.len() {
        3 => vec![1.0 - xi - eta, xi, eta],
        _ => CORNERS.map(|[a, b]| (xi * a + 1.0) * (eta * b + 1.0) * 0.25).to_vec(),
    }
}

/// Half the square of the way from the anchor that is left without its part along the normal. The anchor comes last.
struct SlipQuantity(Distance);

impl Quantity for SlipQuantity {
    fn evaluate<D: Scalar>(&self, coordinates: &[[D; 3]]) -> Result<Vec<D>, ElementError> {
        let Distance { size, foot } = &self.0;
        let (slave, anchor) = (coordinates[0], coordinates[coordinates.len() - 1]);
        let corners = offsets(slave, &coordinates[1..coordinates.len() - 1], *size);
        let normal = match (foot, &*corners) {
            (Some(foot), &[a, b, c, d]) => {
                let facet = Bilinear([a, b, c, d]);
                facet.normal(foot.propagate(&facet))
            }
            (_, corners) => plane(corners).0,
        };
        let way = minus(slave, anchor).map(|x| x / *size);
        let along = dot(way, normal);
        let left: [D; 3] = std::array::from_fn(|k| way[k] - normal[k] * along);
        Ok(vec![dot(left, left) * 0.5])
    }
}

/// The foot over the size and the normal.
struct FootQuantity(Distance);

impl Quantity for FootQuantity {
    fn evaluate<D: Scalar>(&self, coordinates: &[[D; 3]]) -> Result<Vec<D>, ElementError> {
        let Distance { size, foot } = &self.0;
        let corners = offsets(coordinates[0], &coordinates[1..], *size);
        let (normal, from_slave) = match (foot, &*corners) {
            (Some(foot), &[a, b, c, d]) => {
                let facet = Bilinear([a, b, c, d]);
                let natural = foot.propagate(&facet);
                (facet.normal(natural), facet.point(natural))
            }
            (_, corners) => {
                let (normal, gap) = plane(corners);
                (normal, normal.map(|x| -gap * x))
            }
        };
        let foot = (0..3).map(|k| coordinates[0][k] / *size + from_slave[k]);
        Ok(foot.chain(normal).collect())
    }
}

/// Corners as seen from the slave, over the size.
fn offsets<D: Scalar>(slave: [D; 3], corners: &[[D; 3]], size: f64) -> Vec<[D; 3]> {
    corners.iter().map(|corner| minus(*corner, slave).map(|x| x / size)).collect()
}

/// Normal of the plane through the first three corners, and the origin's distance from it.
fn plane<D: Scalar>(corners: &[[D; 3]]) -> ([D; 3], D) {
    let area = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
    let length = length(area);
    let normal = area.map(|x| x / length);
    (normal, -dot(normal, corners[0]))
}

/// The bilinear surface through four corners, as seen from the slave at the origin.
struct Bilinear<D>([[D; 3]; 4]);

impl<D: Scalar> Bilinear<D> {
    fn point(&self, [xi, eta]: [D; 2]) -> [D; 3] {
        let weights = CORNERS.map(|[a, b]| (xi * a + 1.0) * (eta * b + 1.0) * 0.25);
        std::array::from_fn(|k| {
            let terms: [D; 4] = std::array::from_fn(|i| weights[i] * self.0[i][k]);
            (terms[0] + terms[1]) + (terms[2] + terms[3])
        })
    }

    /// ∂x/∂ξ and ∂x/∂η, by dual numbers over `D`.
    fn tangents(&self, [xi, eta]: [D; 2]) -> [[D; 3]; 2] {
        let lifted = Bilinear(self.0.map(|corner| corner.map(Dual::from_re)));
        [[1.0, 0.0], [0.0, 1.0]].map(|[a, b]| {
            lifted.point([Dual::new(xi, D::from(a)), Dual::new(eta, D::from(b))]).map(|x| x.eps)
        })
    }

    /// Half the derivative of the squared distance.
    fn residual(&self, natural: [D; 2]) -> [D; 2] {
        let point = self.point(natural);
        self.tangents(natural).map(|tangent| dot(point, tangent))
    }

    fn normal(&self, natural: [D; 2]) -> [D; 3] {
        let [t_1, t_2] = self.tangents(natural);
        let area = cross(t_1, t_2);
        let length = length(area);
        area.map(|x| x / length)
    }

    fn gap(&self, natural: [D; 2]) -> D {
        -dot(self.normal(natural), self.point(natural))
    }
}

impl Bilinear<f64> {
    /// Jacobian of the residual, by dual numbers.
    fn jacobian(&self, natural: [f64; 2]) -> [[f64; 2]; 2] {
        let lifted = Bilinear(self.0.map(|corner| corner.map(Dual::from_re)));
        let [xi, eta] = natural;
        let columns = [[1.0, 0.0], [0.0, 1.0]]
            .map(|[a, b]| lifted.residual([Dual::new(xi, a), Dual::new(eta, b)]).map(|r| r.eps));
        [[columns[0][0], columns[1][0]], [columns[0][1], columns[1][1]]]
    }

    fn metric(&self, natural: [f64; 2]) -> [[f64; 2]; 2] {
        let [a, b] = self.tangents(natural);
        [[dot(a, a), dot(a, b)], [dot(a, b), dot(b, b)]]
    }

    fn square(&self, natural: [f64; 2]) -> f64 {
        let point = self.point(natural);
        dot(point, point) / 2.0
    }

    /// The area spanned at (ξ, η), seen along the normal of the diagonals.
    fn area(&self, natural: [f64; 2]) -> f64 {
        let [a, b, c, d] = self.0;
        let diagonals = cross(minus(c, a), minus(d, b));
        let [t_1, t_2] = self.tangents(natural);
        let size = length(diagonals);
        // The natural coordinates run over 2.
        if size == 0.0 { 0.0 } else { 4.0 * dot(cross(t_1, t_2), diagonals) / size }
    }
}

/// Where the projection lies on reals, with what dual numbers need to follow it.
struct Foot {
    natural: [f64; 2],
    inverse_jacobian: [[f64; 2]; 2],
}

impl Foot {
    /// Descent of the squared distance: Newton's direction where the Jacobian is positive
    /// definite, else that of the metric.
    fn find(facet: &Bilinear<f64>, start: [f64; 2]) -> Result<Self, ElementError> {
        let smallest = CORNERS.map(|corner| facet.area(corner)).into_iter().fold(f64::INFINITY, f64::min);
        if !(smallest > AREA_TOLERANCE) {
            return Err(ElementError::DegenerateFacet { area: smallest });
        }
        let mut natural = start;
        for iterations in 0..MAX_ITERATIONS {
            let residual = facet.residual(natural);
            finite("foot residual", residual)?;
            let Some(next) = descend(facet, natural, residual) else {
                return Self::checked(facet, natural, iterations);
            };
            natural = next;
        }
        Self::checked(facet, natural, MAX_ITERATIONS)
    }

    fn checked(facet: &Bilinear<f64>, natural: [f64; 2], iterations: usize) -> Result<Self, ElementError> {
        let residual = facet.residual(natural);
        let [tangents, point] = [facet.tangents(natural).map(length), [length(facet.point(natural)); 2]];
        let moved = 1.0 + length2(natural);
        let relative = |k: usize| residual[k].abs() / (tangents[k] * (point[k] + tangents[k] * moved));
        let largest = relative(0).max(relative(1));
        if !(largest < RESIDUAL_ACCEPTED) {
            return Err(ElementError::FootDiverged { residual: largest, iterations });
        }
        let area = facet.area(natural);
        if !(area > AREA_TOLERANCE) {
            return Err(ElementError::DegenerateFacet { area });
        }
        let jacobian = facet.jacobian(natural);
        let determinant = determinant(&jacobian) / determinant(&facet.metric(natural));
        if !(determinant > DETERMINANT_TOLERANCE) {
            return Err(ElementError::CentreOfCurvature { determinant });
        }
        Ok(Self { natural, inverse_jacobian: inverse(&jacobian) })
    }

    /// The foot on a facet of dual corners: Newton steps from the real foot.
    fn propagate<D: Scalar>(&self, facet: &Bilinear<D>) -> [D; 2] {
        let mut natural = self.natural.map(D::from);
        for _ in 0..PROPAGATION_STEPS {
            let [r_1, r_2] = facet.residual(natural);
            for (x, [j_1, j_2]) in natural.iter_mut().zip(self.inverse_jacobian) {
                *x -= r_1 * j_1 + r_2 * j_2;
            }
        }
        natural
    }
}

/// A point with a smaller squared distance or, where rounding hides that, with a smaller residual; none at the foot.
fn descend(facet: &Bilinear<f64>, natural: [f64; 2], residual: [f64; 2]) -> Option<[f64; 2]> {
    let jacobian = facet.jacobian(natural);
    let convex = jacobian[0][0] > 0.0 && determinant(&jacobian) > 0.0;
    let matrix = if convex { jacobian } else { facet.metric(natural) };
    let [[a, b], [c, d]] = inverse(&matrix);
    let direction = [-(a * residual[0] + b * residual[1]), -(c * residual[0] + d * residual[1])];
    let slope = direction[0] * residual[0] + direction[1] * residual[1];
    let square = facet.square(natural);
    let longest = 1.0 + length2(natural);
    let mut factor = (longest / length2(direction)).min(1.0);
    for _ in 0..MAX_HALVINGS {
        let next = [0, 1].map(|k| natural[k] + factor * direction[k]);
        let decrease = square - facet.square(next);
        let hidden = -factor * slope < 1e-8 * square;
        if decrease > -1e-4 * factor * slope
            || (hidden && length2(facet.residual(next)) < 0.5 * length2(residual))
        {
            return Some(next);
        }
        factor *= 0.5;
    }
    None
}

fn length2([a, b]: [f64; 2]) -> f64 {
    a.hypot(b)
}

fn minus<D: Scalar>(x: [D; 3], y: [D; 3]) -> [D; 3] {
    std::array::from_fn(|k| x[k] - y[k])
}

fn cross<D: Scalar>(x: [D; 3], y: [D; 3]) -> [D; 3] {
    [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
}

fn length<D: Scalar>(x: [D; 3]) -> D {
    dot(x, x).sqrt()
}
