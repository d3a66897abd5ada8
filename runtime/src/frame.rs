//! The local frame: given by the caller, or the average plane of the master nodes.

use crate::vector::Vector3;

use crate::eigen::symmetric_eigen;
use crate::{ElementError, Point};

/// What the frame does while the element is differentiated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum FrameDerivative {
    /// It is held constant, as in the paper: conserves linear, but not angular momentum.
    #[default]
    Held,
    /// It is the average plane of the master nodes and moves with them: N and M are the exact derivatives of the gap,
    /// angular momentum is conserved, and Newton's method converges quadratically.
    CoMoving,
}

/// Orthonormal local frame (t1, t2, n̂). Only the directions matter to the element: it works in offsets
/// from the slave node. `origin` is kept for reporting local coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// A point of the plane.
    pub origin: Point,
    /// First in-plane direction.
    pub t1: Point,
    /// Second in-plane direction.
    pub t2: Point,
    /// Unit normal n̂, towards the outward side of the master surface: the gap is positive on this side.
    pub normal: Point,
    /// What the frame does while the gap is differentiated; coefficients and surfaces are always differentiated
    /// with the frame held.
    pub derivative: FrameDerivative,
    /// Where it moves, how nodes are weighted in the average plane: by ω(reach · |x^k − x^c| / R_k), ω the fitting weight, R_k the
    /// radius of the node's domain. 0 weights all alike, as in the paper.
    pub reach: f64,
}

/// Largest |Q Qᵀ − I| accepted of a given frame.
const ORTHONORMALITY_TOLERANCE: f64 = 1e-9;
/// Largest angle between a co-moving frame's normal and that of the average plane, roughly.
const AVERAGE_PLANE_TOLERANCE: f64 = 1e-6;
/// A middle principal moment below this fraction of the largest means a line of nodes.
pub(crate) const LINE_TOLERANCE: f64 = 1e-10;
/// The smallest and the middle principal moment must differ by this fraction of the largest.
pub(crate) const THICKNESS_TOLERANCE: f64 = 1e-8;
/// An outward direction closer to the plane than this cosine does not tell its sides apart.
const OUTWARD_TOLERANCE: f64 = 1e-6;

impl Frame {
    /// A frame given by the caller, held while differentiating. Checks it and, if `outward` is given, turns the normal to that side.
    ///
    /// # Errors
    /// [`ElementError::InvalidFrame`] if the vectors are not orthonormal to 1e-9,
    /// [`ElementError::AmbiguousOutward`] if `outward` lies in the plane.
    pub fn given(
        origin: Point,
        t1: Point,
        t2: Point,
        normal: Point,
        outward: Option<Point>,
    ) -> Result<Self, ElementError> {
        let frame = Self { origin, t1, t2, normal, derivative: FrameDerivative::Held, reach: 0.0 };
        frame.check()?;
        let normal = match outward {
            Some(outward) => oriented(Vector3::from(normal), outward)?.into(),
            None => normal,
        };
        Ok(Self { normal, ..frame })
    }

    /// Checks that the directions are orthonormal.
    ///
    /// # Errors
    /// [`ElementError::InvalidFrame`] if they are not to 1e-9, or if a number is not finite.
    pub fn check(&self) -> Result<(), ElementError> {
        let mut deviation: f64 = 0.0;
        let rows = self.rows();
        for (i, x) in rows.iter().enumerate() {
            for (j, y) in rows[..=i].iter().enumerate() {
                let product = x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
                let error = (product - f64::from(u8::from(i == j))).abs();
                // A NaN replaces a number, and no number replaces it.
                deviation = if deviation.is_nan() || error <= deviation { deviation } else { error };
            }
        }
        if !(deviation <= ORTHONORMALITY_TOLERANCE && self.origin.iter().all(|x| x.is_finite())) {
            return Err(ElementError::InvalidFrame { deviation });
        }
        Ok(())
    }

    /// Average plane of the master nodes: n̂ minimises Σ (n·(x_i − x̄))², oriented by `outward`. The frame moves with the
    /// nodes while differentiating; [`held`](Self::held) holds it.
    ///
    /// # Errors
    /// [`ElementError::NoAveragePlane`] if the nodes lie on a line or are as thick as wide,
    /// [`ElementError::AmbiguousOutward`] if `outward` lies in the plane or is zero.
    pub fn average_plane(masters: &[Point], outward: Point) -> Result<Self, ElementError> {
        ElementError::check_points("master", masters)?;
        Self::average_plane_of(masters.iter().map(|&x| (x, 1.0)), 0.0, outward)
    }

    /// Moving average plane of the master nodes: n̂ minimises Σ ω_k (n·(x_k − x̄))² with ω_k = ω(reach · |x_k − x^c| / R_k) and x̄ the
    /// mean so weighted (`docs/equations.md`, \[T14\]), oriented by `outward`. A node joins with weight zero, so the plane is a
    /// continuous function of all positions. The frame moves with the nodes while differentiating;
    /// [`held`](Self::held) holds it.
    ///
    /// `radii`: R_k of each master. `fitting_weight`: ω, see [`Weight::fitting`](crate::Weight::fitting). `reach`: 1, less where the
    /// slave is far from the nodes.
    ///
    /// # Errors
    /// As [`average_plane`](Self::average_plane), also for nodes out of reach; [`ElementError::WrongNumberOfDomains`],
    /// [`ElementError::InvalidDomain`], [`ElementError::InvalidReach`].
    pub fn moving_plane(
        slave: Point,
        masters: &[Point],
        radii: &[f64],
        fitting_weight: impl Fn(f64) -> f64,
        reach: f64,
        outward: Point,
    ) -> Result<Self, ElementError> {
        if radii.len() != masters.len() {
            return Err(ElementError::WrongNumberOfDomains { found: radii.len(), expected: masters.len() });
        }
        if let Some(index) = radii.iter().position(|&radius| !(radius > 0.0 && radius.is_finite())) {
            return Err(ElementError::InvalidDomain { index, value: radii[index] });
        }
        if !(reach > 0.0 && reach <= 1.0) {
            return Err(ElementError::InvalidReach { value: reach });
        }
        ElementError::check_points("master", masters)?;
        let slave = Vector3::from(slave);
        let weighted = masters
            .iter()
            .zip(radii)
            .map(|(&x, radius)| (x, fitting_weight(reach * (Vector3::from(x) - slave).norm() / radius)));
        Self::average_plane_of(weighted.filter(|&(_, weight)| weight > 0.0), reach, outward)
    }

    /// The average plane of points, each with its weight; all are known to be finite, and weights to be positive.
    pub(crate) fn average_plane_of(
        masters: impl Iterator<Item = (Point, f64)> + Clone,
        reach: f64,
        outward: Point,
    ) -> Result<Self, ElementError> {
        let no_plane = |smallest, middle| ElementError::NoAveragePlane { smallest, middle };
        let Some((first, _)) = masters.clone().next() else { return Err(no_plane(0.0, 0.0)) };
        // Mean of differences from the first node: far from the origin the plain mean loses digits.
        let first = Vector3::from(first);
        let scale = masters.clone().map(|(x, _)| (Vector3::from(x) - first).largest()).fold(0.0, f64::max);
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(no_plane(0.0, 0.0));
        }
        let offsets = || masters.clone().map(|(x, weight)| ((Vector3::from(x) - first) / scale, weight));
        let total: f64 = masters.clone().map(|(_, weight)| weight).sum();
        let mean = offsets().map(|(x, weight)| x * weight).sum::<Vector3>() / total;
        let mut scatter = [[0.0; 3]; 3];
        for (x, weight) in offsets() {
            let x = x - mean;
            for i in 0..3 {
                for j in i..3 {
                    scatter[i][j] += weight * x[i] * x[j];
                }
            }
        }
        let [(smallest, direction), (middle, _), (largest, _)] = symmetric_eigen(scatter);
        let [smallest, middle, largest] = [smallest, middle, largest].map(|moment| moment.max(0.0));
        if !(middle > LINE_TOLERANCE * largest && middle - smallest > THICKNESS_TOLERANCE * largest) {
            return Err(no_plane(smallest / largest, middle / largest));
        }
        let direction = Vector3::from(direction).normalize();
        let frame = Self::of_average_plane(first + mean * scale, direction, outward)?;
        Ok(Self { reach, ..frame })
    }

    /// The frame of an average plane with this unit normal or its opposite.
    pub(crate) fn of_average_plane(
        origin: Vector3,
        direction: Vector3,
        outward: Point,
    ) -> Result<Self, ElementError> {
        let normal = oriented(direction, outward)?;
        let (t1, t2) = tangents(&normal);
        Ok(Self {
            origin: origin.into(),
            t1: t1.into(),
            t2: t2.into(),
            normal: normal.into(),
            derivative: FrameDerivative::CoMoving,
            reach: 1.0,
        })
    }

    /// The same frame, held while differentiating.
    #[must_use]
    pub const fn held(self) -> Self {
        Self { derivative: FrameDerivative::Held, ..self }
    }

    /// Checks that a co-moving frame is the average plane of the nodes it moves with, given with their weights; a frame that is
    /// held may be any.
    ///
    /// # Errors
    /// [`ElementError::NotAveragePlane`] if the nodes' covariance of height and in-plane position is more than 1e-6 of
    /// their in-plane moment.
    pub(crate) fn check_average_plane(
        &self,
        masters: impl Iterator<Item = (Point, f64)> + Clone,
    ) -> Result<(), ElementError> {
        let (FrameDerivative::CoMoving, Some((first, _))) = (self.derivative, masters.clone().next()) else {
            return Ok(());
        };
        // Loops instead of maps over arrays, which are not always inlined: they took as long as all of the kernel.
        let [t1, t2, normal] = self.rows();
        let local = |x: Point| {
            let offset = [x[0] - first[0], x[1] - first[1], x[2] - first[2]];
            let along = |row: Point| row[0] * offset[0] + row[1] * offset[1] + row[2] * offset[2];
            [along(t1), along(t2), along(normal)]
        };
        let mut scale = 0.0_f64;
        for (x, weight) in masters.clone() {
            if weight > 0.0 {
                let [a, b, z] = local(x);
                scale = scale.max(a.abs()).max(b.abs()).max(z.abs());
            }
        }
        let (mut mean, mut total) = ([0.0; 3], 0.0);
        for (x, weight) in masters.clone() {
            let x = local(x);
            total += weight;
            for axis in 0..3 {
                mean[axis] += weight * (x[axis] / scale);
            }
        }
        for sum in &mut mean {
            *sum /= total;
        }
        let (mut moment, mut covariance) = (0.0, [0.0; 2]);
        for (x, weight) in masters {
            let x = local(x);
            let [a, b, z] = [x[0] / scale - mean[0], x[1] / scale - mean[1], x[2] / scale - mean[2]];
            moment += weight * (a * a + b * b);
            covariance = [covariance[0] + weight * (a * z), covariance[1] + weight * (b * z)];
        }
        let angle = covariance[0].hypot(covariance[1]) / moment;
        // A patch without extent is for the fit to refuse.
        if angle > AVERAGE_PLANE_TOLERANCE { Err(ElementError::NotAveragePlane { angle }) } else { Ok(()) }
    }

    /// The three directions as rows, in the order (t1, t2, n̂).
    pub const fn rows(&self) -> [Point; 3] {
        [self.t1, self.t2, self.normal]
    }
}

/// `normal` or its opposite, whichever points to the side of `outward`.
fn oriented(normal: Vector3, outward: Point) -> Result<Vector3, ElementError> {
    let outward = Vector3::from(outward);
    if outward == Vector3::zeros() {
        return Err(ElementError::AmbiguousOutward { cosine: 0.0 });
    }
    let cosine = normal.dot(&(outward / outward.largest())) / (outward / outward.largest()).norm();
    if !(cosine.abs() > OUTWARD_TOLERANCE) {
        return Err(ElementError::AmbiguousOutward { cosine });
    }
    Ok(normal * cosine.signum())
}

/// Two unit vectors that complete `normal` to a right-handed frame, from the global axis least aligned with it.
pub(crate) fn tangents(normal: &Vector3) -> (Vector3, Vector3) {
    let axis = Vector3::axis(normal.smallest_axis());
    let t1 = (axis - *normal * normal.dot(&axis)).normalize();
    (t1, normal.cross(&t1))
}
