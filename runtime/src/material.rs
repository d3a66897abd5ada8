//! The slave's place in the master's first configuration, where domains of influence stay what they are
//! (`docs/equations.md`, \[T18\]).

mod side_by_side;

pub(crate) use side_by_side::{SearchScratch, Sought, places};

use crate::vector::Vector3;
use crate::{ElementError, Frame, MaterialNode, Point};

/// Steps for the place.
const MOST_STEPS: usize = 60;
/// A step below this fraction of a domain is rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Where steps no longer shrink, they have to be below this fraction of a domain.
const STALLED: f64 = 1e-11;
/// Nodes are close to another where each is in the domain of the other, shrunk by this factor.
const CLOSE: f64 = 1.35;
/// A step has to leave less than this part of the residual, or the derivative is measured.
const CONTRACTION: f64 = 0.5;
/// Shortest part of a step.
const SHORTEST: f64 = 1e-3;
/// Differences are taken over this part of a domain.
const DIFFERENCE: f64 = 1e-4;
/// A pivot of an ellipsoid's matrix below this part of its diagonal is rounding.
const SINGULAR: f64 = 1e-14;
/// Largest step that a given place may be off its equations, as a fraction of a domain.
const PLACE_TOLERANCE: f64 = 1e-6;

/// The domain of influence of a master node: an ellipsoid around its first position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialDomain {
    /// First position X_k of the node.
    pub position: Point,
    /// Upper triangle U of the metric, rows xx, xy, xz, yy, yz, zz, 1/length: the domain is where |U (X − X_k)| < 1.
    pub metric: [f64; 6],
}

/// The place Ξ in the first configuration that the slave has now, and the average plane of the nodes as they are weighted there.
///
/// Ξ is the affine fit of the nodes' first positions by their positions in the plane, taken at the slave, with the weights
/// ω(|U_k (X_k − Ξ)|).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialPlace {
    /// Ξ
    pub place: Point,
    /// The plane, which moves with the nodes.
    pub frame: Frame,
    /// Steps of the iteration.
    pub steps: usize,
}

impl MaterialPlace {
    /// The place of a slave over these masters. The iteration starts at the first position of the master nearest to the slave.
    ///
    /// `fitting_weight`: ω, see [`Weight::fitting`](crate::Weight::fitting). `outward`: towards the side of the slave.
    ///
    /// # Errors
    /// [`ElementError::WrongNumberOfDomains`], [`ElementError::NonFiniteInput`]; as [`Frame::average_plane`] for the nodes
    /// within reach; [`ElementError::NotMaterialPlace`] if the iteration does not converge.
    pub fn find(
        slave: Point,
        masters: &[Point],
        domains: &[MaterialDomain],
        fitting_weight: impl Fn(f64) -> f64,
        outward: Point,
    ) -> Result<Self, ElementError> {
        if domains.len() != masters.len() {
            return Err(ElementError::WrongNumberOfDomains { found: domains.len(), expected: masters.len() });
        }
        let is_finite = |x: &[f64]| x.iter().all(|x| x.is_finite());
        let bad = |(x, domain): (&Point, &MaterialDomain)| {
            !(is_finite(x) && is_finite(&domain.position) && is_finite(&domain.metric))
        };
        if let Some(index) = masters.iter().zip(domains).position(bad) {
            return Err(ElementError::NonFiniteInput { what: "master", index });
        }
        let mut weights = Vec::new();
        Self::iterate(slave, masters, domains, &mut weights, fitting_weight, outward)
    }

    /// As [`find`](Self::find) without its checks. `weights` is memory; it ends up with ω of each master.
    pub(crate) fn iterate(
        slave: Point,
        masters: &[Point],
        domains: &[MaterialDomain],
        weights: &mut Vec<f64>,
        fitting_weight: impl Fn(f64) -> f64,
        outward: Point,
    ) -> Result<Self, ElementError> {
        let square = |x: &Point| (Vector3::from(*x) - Vector3::from(slave)).norm_squared();
        let nearest = masters.iter().zip(domains).min_by(|x, y| square(x.0).total_cmp(&square(y.0)));
        let Some((_, nearest)) = nearest else {
            return Err(ElementError::TooFewNodes { found: 0, needed: 3 });
        };
        let start = Vector3::from(nearest.position);
        let small = DIFFERENCE / nearest.metric.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
        let mut evaluated = 0;
        let mut normal = None;
        let mut weighted_at = |place: Vector3, weight: &dyn Fn(&MaterialDomain) -> f64| {
            evaluated += 1;
            weights.clear();
            weights.extend(domains.iter().map(weight));
            let weighted = masters.iter().copied().zip(weights.iter().copied()).filter(|x| x.1 > 0.0);
            let frame = Frame::average_plane_near(weighted, 1.0, outward, normal)?;
            normal = Some(frame.normal);
            let residual = step(slave, masters, domains, weights, &frame, place);
            let deviation = reach(domains, weights, residual);
            if deviation.is_finite() {
                Ok((Self { place: place.into(), frame, steps: evaluated }, residual, deviation))
            } else {
                Err(ElementError::NotMaterialPlace { deviation })
            }
        };
        // The first step is taken with the nodes close to the nearest one: lists hold these wherever they were made.
        let close = |domain: &MaterialDomain| {
            let offset = Vector3::from(domain.position) - start;
            let square = nearest.square(offset).max(domain.square(offset));
            fitting_weight(CLOSE * square.sqrt())
        };
        let start = weighted_at(start, &close).map_or(start, |(_, step, _)| start + step);
        let mut at = |place: Vector3| weighted_at(place, &|domain| fitting_weight(domain.distance(place)));
        let (mut found, mut residual, mut deviation) = at(start)?;
        // Broyden's method: `inverse` becomes the inverse of the residual's derivative, up to its sign. Close to the surface
        // the residual changes as the place does.
        let mut inverse = IDENTITY;
        let mut is_measured = false;
        for _ in 0..MOST_STEPS {
            if deviation <= ROUNDING {
                return Ok(found);
            }
            let moved = times(&inverse, residual);
            let place = Vector3::from(found.place);
            let next = at(place + moved);
            if let Ok((there, after, smaller)) = next
                && (smaller < CONTRACTION * deviation || (deviation <= STALLED && is_measured))
            {
                if deviation <= STALLED && smaller >= deviation {
                    return Ok(found);
                }
                let change = times(&inverse, after - residual);
                let row = transposed_times(&inverse, moved);
                let divisor = moved.dot(&change);
                if divisor != 0.0 {
                    let correction = (moved + change) / divisor;
                    for i in 0..3 {
                        for j in 0..3 {
                            inverse[i][j] -= correction[i] * row[j];
                        }
                    }
                }
                (found, residual, deviation) = (there, after, smaller);
                continue;
            }
            if deviation <= STALLED {
                return Ok(found);
            }
            if is_measured {
                // A shorter step with what is known here.
                let mut shorter = 0.5;
                loop {
                    if let Ok((there, after, smaller)) = at(place + moved * shorter)
                        && smaller < deviation
                    {
                        (found, residual, deviation) = (there, after, smaller);
                        break;
                    }
                    shorter *= 0.5;
                    if shorter < SHORTEST {
                        return Err(ElementError::NotMaterialPlace { deviation });
                    }
                }
            }
            // Far from the surface a place moves the projection by more than itself: the derivative is measured.
            let mut jacobian = [[0.0; 3]; 3];
            let place = Vector3::from(found.place);
            for k in 0..3 {
                let (_, beside, _) = at(place + Vector3::axis(k) * small)?;
                for (row, change) in jacobian.iter_mut().zip(Point::from((residual - beside) / small)) {
                    row[k] = change;
                }
            }
            inverse = inverted(&jacobian).ok_or(ElementError::NotMaterialPlace { deviation })?;
            is_measured = true;
        }
        if deviation <= STALLED { Ok(found) } else { Err(ElementError::NotMaterialPlace { deviation }) }
    }

    /// The masters as an element takes them.
    #[must_use]
    pub fn nodes(&self, domains: &[MaterialDomain]) -> Vec<MaterialNode> {
        domains.iter().map(|domain| domain.from(self.place)).collect()
    }
}

impl MaterialDomain {
    /// The domain of all X with (X − X_k)ᵀ C⁻¹ (X − X_k) < 1: the eigenvalues of C are the squares of its half axes, along the
    /// eigenvectors. Of C the upper triangle is read. `None` if C is not positive definite to rounding.
    ///
    /// ```
    /// use diffuse_contact::MaterialDomain;
    ///
    /// // Half axes 2, 1 and 0.5.
    /// let squares = [[4.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.25]];
    /// let domain = MaterialDomain::of_ellipsoid([1.0, 0.0, 0.0], squares).unwrap();
    /// assert_eq!(domain.from([3.0, 0.0, 0.0]).distance(), 1.0);
    /// assert_eq!(domain.ellipsoid(), squares);
    /// ```
    #[must_use]
    pub fn of_ellipsoid(position: Point, squares: [[f64; 3]; 3]) -> Option<Self> {
        let [[c_xx, c_xy, c_xz], [_, c_yy, c_yz], [_, _, c_zz]] = squares;
        let root = |square: f64, whole: f64| {
            (square > SINGULAR * whole && square.is_finite()).then(|| square.sqrt())
        };
        // C = R Rᵀ with R an upper triangle; U = R⁻¹.
        let zz = root(c_zz, 0.0)?;
        let (yz, xz) = (c_yz / zz, c_xz / zz);
        let yy = root(c_yy - yz * yz, c_yy)?;
        let xy = (c_xy - xz * yz) / yy;
        let xx = root(c_xx - xy * xy - xz * xz, c_xx)?;
        let [u_xx, u_yy, u_zz] = [xx, yy, zz].map(f64::recip);
        let u_yz = -yz * u_zz * u_yy;
        let metric = [u_xx, -xy * u_yy * u_xx, -(xy * u_yz + xz * u_zz) * u_xx, u_yy, u_yz, u_zz];
        metric.iter().all(|x| x.is_finite()).then_some(Self { position, metric })
    }

    /// C of [`of_ellipsoid`](Self::of_ellipsoid).
    #[must_use]
    pub fn ellipsoid(&self) -> [[f64; 3]; 3] {
        let [u_xx, u_xy, u_xz, u_yy, u_yz, u_zz] = self.metric;
        let [xx, yy, zz] = [u_xx, u_yy, u_zz].map(f64::recip);
        let yz = -u_yz * zz * yy;
        let rows = [[xx, -u_xy * yy * xx, -(u_xy * yz + u_xz * zz) * xx], [0.0, yy, yz], [0.0, 0.0, zz]];
        rows.map(|row| rows.map(|other| Vector3::from(row).dot(&Vector3::from(other))))
    }

    /// The node seen from a place.
    #[must_use]
    pub fn from(&self, place: Point) -> MaterialNode {
        let offset = [0, 1, 2].map(|k| self.position[k] - place[k]);
        MaterialNode { offset, metric: self.metric }
    }

    /// |U v|²
    fn square(&self, v: Vector3) -> f64 {
        let [xx, xy, xz, yy, yz, zz] = self.metric;
        Vector3::from([xx * v[0] + xy * v[1] + xz * v[2], yy * v[1] + yz * v[2], zz * v[2]]).norm_squared()
    }

    fn distance(&self, place: Vector3) -> f64 {
        self.from(place.into()).distance()
    }
}

/// Checks that the place that nodes are seen from is a root of its equations in this frame.
pub(crate) fn check_place(
    slave: Point,
    masters: &[Point],
    nodes: &[MaterialNode],
    frame: &Frame,
    fitting_weight: impl Fn(f64) -> f64,
) -> Result<(), ElementError> {
    let weights: Vec<f64> = nodes.iter().map(|node| fitting_weight(node.distance())).collect();
    let domains: Vec<MaterialDomain> =
        nodes.iter().map(|node| MaterialDomain { position: node.offset, metric: node.metric }).collect();
    let residual = step(slave, masters, &domains, &weights, frame, Vector3::zeros());
    let deviation = reach(&domains, &weights, residual);
    if deviation <= PLACE_TOLERANCE { Ok(()) } else { Err(ElementError::NotMaterialPlace { deviation }) }
}

/// The affine fit at the slave, less the place.
fn step(
    slave: Point,
    masters: &[Point],
    domains: &[MaterialDomain],
    weights: &[f64],
    frame: &Frame,
    place: Vector3,
) -> Vector3 {
    let slave = Vector3::from(slave);
    let axes = [frame.t1, frame.t2].map(Vector3::from);
    let (mut total, mut first, mut second) = (0.0, [0.0; 2], [0.0; 3]);
    let (mut mean, mut products) = (Vector3::zeros(), [Vector3::zeros(); 2]);
    for ((&x, domain), &weight) in masters.iter().zip(domains).zip(weights) {
        if weight == 0.0 {
            continue;
        }
        let offset = Vector3::from(x) - slave;
        let [a, b] = axes.map(|axis| offset.dot(&axis));
        let material = Vector3::from(domain.position) - place;
        total += weight;
        first = [first[0] + weight * a, first[1] + weight * b];
        second = [second[0] + weight * a * a, second[1] + weight * a * b, second[2] + weight * b * b];
        mean += material * weight;
        products = [products[0] + material * (weight * a), products[1] + material * (weight * b)];
    }
    let determinant = second[0] * second[2] - second[1] * second[1];
    let beta = [
        (second[1] * first[1] - second[2] * first[0]) / determinant,
        (second[1] * first[0] - second[0] * first[1]) / determinant,
    ];
    let divisor = total + beta[0] * first[0] + beta[1] * first[1];
    (mean + products[0] * beta[0] + products[1] * beta[1]) / divisor
}

/// The largest length of a step in a metric of the nodes that carry weight.
fn reach(domains: &[MaterialDomain], weights: &[f64], step: Vector3) -> f64 {
    let square = |domain: &MaterialDomain| domain.square(step);
    let carrying = domains.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
    carrying.map(|(domain, _)| square(domain)).fold(0.0, |x: f64, y| if y <= x { x } else { y }).sqrt()
}

const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn inverted(matrix: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let [x, y, z] = matrix.map(Vector3::from);
    let columns = [y.cross(&z), z.cross(&x), x.cross(&y)];
    let determinant = x.dot(&columns[0]);
    let inverse = [0, 1, 2].map(|i| columns.map(|column| column[i] / determinant));
    inverse.as_flattened().iter().all(|x| x.is_finite()).then_some(inverse)
}

fn times(matrix: &[[f64; 3]; 3], x: Vector3) -> Vector3 {
    Vector3::from(matrix.map(|row| Vector3::from(row).dot(&x)))
}

fn transposed_times(matrix: &[[f64; 3]; 3], x: Vector3) -> Vector3 {
    Vector3::from([0, 1, 2].map(|j| Vector3::from(matrix.map(|row| row[j])).dot(&x)))
}
