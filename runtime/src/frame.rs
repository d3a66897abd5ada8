//! The local frame: given by the caller, or the average plane of the master nodes.

use crate::vector::Vector3;

use crate::eigen::symmetric_eigen;
use crate::{ElementError, Point};

/// What the frame does while the element is differentiated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum FrameDerivative {
    /// It is held constant, as in the paper: conserves linear, but not angular momentum.
    #[default]
    Frozen,
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
}

/// Largest |Q Qᵀ − I| accepted of a given frame.
const ORTHONORMALITY_TOLERANCE: f64 = 1e-9;
/// Largest angle between a co-moving frame's normal and that of the average plane, roughly.
const AVERAGE_PLANE_TOLERANCE: f64 = 1e-6;
/// A middle principal moment below this fraction of the largest means a line of nodes.
const LINE_TOLERANCE: f64 = 1e-10;
/// The smallest and the middle principal moment must differ by this fraction of the largest.
const THICKNESS_TOLERANCE: f64 = 1e-8;
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
        let frame = Self { origin, t1, t2, normal, derivative: FrameDerivative::Frozen };
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
                // Written so that a NaN comes through.
                deviation = if error <= deviation { deviation } else { error };
            }
        }
        if !(deviation <= ORTHONORMALITY_TOLERANCE && self.origin.iter().all(|x| x.is_finite())) {
            return Err(ElementError::InvalidFrame { deviation });
        }
        Ok(())
    }

    /// Average plane of the master nodes: n̂ minimises Σ (n·(x_i − x̄))², oriented by `outward`. The frame moves with the
    /// nodes while differentiating; [`frozen`](Self::frozen) holds it.
    ///
    /// # Errors
    /// [`ElementError::NoAveragePlane`] if the nodes lie on a line or are as thick as wide,
    /// [`ElementError::AmbiguousOutward`] if `outward` lies in the plane or is zero.
    pub fn average_plane(masters: &[Point], outward: Point) -> Result<Self, ElementError> {
        for (index, master) in masters.iter().enumerate() {
            if !master.iter().all(|x| x.is_finite()) {
                return Err(ElementError::NonFiniteInput { what: "master", index });
            }
        }
        Self::average_plane_of(masters.iter().copied(), outward)
    }

    /// As [`average_plane`](Self::average_plane), of points that are known to be finite.
    pub(crate) fn average_plane_of(
        masters: impl ExactSizeIterator<Item = Point> + Clone,
        outward: Point,
    ) -> Result<Self, ElementError> {
        let no_plane = |smallest, middle| ElementError::NoAveragePlane { smallest, middle };
        let Some(first) = masters.clone().next() else { return Err(no_plane(0.0, 0.0)) };
        // Mean of differences from the first node: far from the origin the plain mean loses digits.
        let first = Vector3::from(first);
        let scale = masters.clone().map(|x| (Vector3::from(x) - first).largest()).fold(0.0, f64::max);
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(no_plane(0.0, 0.0));
        }
        let offsets = || masters.clone().map(|x| (Vector3::from(x) - first) / scale);
        let mean = offsets().sum::<Vector3>() / masters.len() as f64;
        let mut scatter = [[0.0; 3]; 3];
        for x in offsets() {
            let x = x - mean;
            for i in 0..3 {
                for j in i..3 {
                    scatter[i][j] += x[i] * x[j];
                }
            }
        }
        let [(smallest, direction), (middle, _), (largest, _)] = symmetric_eigen(scatter);
        let [smallest, middle, largest] = [smallest, middle, largest].map(|moment| moment.max(0.0));
        if !(middle > LINE_TOLERANCE * largest && middle - smallest > THICKNESS_TOLERANCE * largest) {
            return Err(no_plane(smallest / largest, middle / largest));
        }
        let normal = oriented(Vector3::from(direction).normalize(), outward)?;
        let (t1, t2) = tangents(&normal);
        Ok(Self {
            origin: (first + mean * scale).into(),
            t1: t1.into(),
            t2: t2.into(),
            normal: normal.into(),
            derivative: FrameDerivative::CoMoving,
        })
    }

    /// The same frame, held while differentiating.
    #[must_use]
    pub const fn frozen(self) -> Self {
        Self { derivative: FrameDerivative::Frozen, ..self }
    }

    /// Checks that a co-moving frame is the average plane of the nodes it moves with; a frame that is held may be
    /// any.
    ///
    /// # Errors
    /// [`ElementError::NotAveragePlane`] if the nodes' covariance of height and in-plane position is more than 1e-6 of
    /// their in-plane moment.
    pub fn check_average_plane(&self, masters: &[Point]) -> Result<(), ElementError> {
        let (FrameDerivative::CoMoving, Some(first)) = (self.derivative, masters.first()) else {
            return Ok(());
        };
        // Loops instead of maps over arrays, which are not always inlined: they took as long as all of the kernel.
        let [t1, t2, normal] = self.rows();
        let local = |x: &Point| {
            let offset = [x[0] - first[0], x[1] - first[1], x[2] - first[2]];
            let along = |row: Point| row[0] * offset[0] + row[1] * offset[1] + row[2] * offset[2];
            [along(t1), along(t2), along(normal)]
        };
        let mut scale = 0.0_f64;
        for x in masters {
            let [a, b, z] = local(x);
            scale = scale.max(a.abs()).max(b.abs()).max(z.abs());
        }
        let mut mean = [0.0; 3];
        for x in masters {
            let x = local(x);
            for axis in 0..3 {
                mean[axis] += x[axis] / scale;
            }
        }
        for sum in &mut mean {
            *sum /= masters.len() as f64;
        }
        let (mut moment, mut covariance) = (0.0, [0.0; 2]);
        for x in masters {
            let x = local(x);
            let [a, b, z] = [x[0] / scale - mean[0], x[1] / scale - mean[1], x[2] / scale - mean[2]];
            moment += a * a + b * b;
            covariance = [covariance[0] + a * z, covariance[1] + b * z];
        }
        let angle = covariance[0].hypot(covariance[1]) / moment;
        // A patch without extent is for the fit to refuse.
        if angle > AVERAGE_PLANE_TOLERANCE { Err(ElementError::NotAveragePlane { angle }) } else { Ok(()) }
    }

    /// The three directions as rows, in the order (t1, t2, n̂).
    #[must_use]
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
fn tangents(normal: &Vector3) -> (Vector3, Vector3) {
    let axis = Vector3::axis(normal.smallest_axis());
    let t1 = (axis - *normal * normal.dot(&axis)).normalize();
    (t1, normal.cross(&t1))
}
