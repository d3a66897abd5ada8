//! Prescribed motion as a function of time, and rotations.

use nalgebra::Vector3;

/// Rotation about an axis in space, right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    /// Direction of the axis; its length does not matter, but is positive.
    pub axis: [f64; 3],
    /// A point of the axis, length.
    pub point: [f64; 3],
    /// Angle in degrees, of either sign and any size.
    pub degrees: f64,
}

impl Rotation {
    /// Where `position` comes to, turned by `factor` times the angle. Exactly `position` where that is zero.
    pub fn turned(&self, position: [f64; 3], factor: f64) -> [f64; 3] {
        let axis = Vector3::from(self.axis);
        // The largest component first: the axis may be too short or too long to be squared.
        let axis = (axis / axis.amax()).normalize();
        let arm = Vector3::from(position) - Vector3::from(self.point);
        let (sine, cosine) = sine_cosine(self.degrees * factor);
        let across = axis.cross(&arm);
        (Vector3::from(position) + across * sine + axis.cross(&across) * (1.0 - cosine)).into()
    }
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90.
pub(super) fn sine_cosine(degrees: f64) -> (f64, f64) {
    let quarters = (degrees / 90.0).round();
    let (sine, cosine) = (degrees - 90.0 * quarters).to_radians().sin_cos();
    match quarters.rem_euclid(4.0) as u8 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// A factor over time, linear between points and constant outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Amplitude {
    /// Time and factor; times ascend strictly.
    points: Vec<[f64; 2]>,
}

impl Amplitude {
    /// From 0 at time 0 to 1 at `end`, a positive time.
    pub fn ramp(end: f64) -> Self {
        Self { points: vec![[0.0, 0.0], [end, 1.0]] }
    }

    /// The factor through these points of time and factor.
    ///
    /// # Errors
    /// The index of the first point that is not finite or not later than the one before; 0 if there is none at all.
    pub fn new(points: Vec<[f64; 2]>) -> Result<Self, usize> {
        if points.is_empty() {
            return Err(0);
        }
        for (k, &[time, factor]) in points.iter().enumerate() {
            if !(time.is_finite() && factor.is_finite()) || (k > 0 && !(time > points[k - 1][0])) {
                return Err(k);
            }
        }
        Ok(Self { points })
    }

    /// The points of time and factor.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// The times of the points, ascending.
    pub fn times(&self) -> impl Iterator<Item = f64> {
        self.points.iter().map(|point| point[0])
    }

    /// The factor at a time.
    pub fn at(&self, time: f64) -> f64 {
        let after = self.points.partition_point(|point| point[0] <= time);
        match (after.checked_sub(1).map(|before| self.points[before]), self.points.get(after)) {
            (Some([t0, f0]), Some([t1, f1])) => f0 + (f1 - f0) * ((time - t0) / (t1 - t0)),
            (Some([_, factor]), None) | (None, Some(&[_, factor])) => factor,
            (None, None) => 0.0,
        }
    }
}

/// Where prescribed nodes are at a time: turned about an axis, then moved.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Displacement at amplitude 1, length.
    pub translation: [f64; 3],
    /// Factor of `translation`.
    pub amplitude: Amplitude,
    /// Rotation at factor 1 and its factor.
    pub rotation: Option<(Rotation, Amplitude)>,
}

impl Motion {
    /// At rest.
    pub fn fixed() -> Self {
        Self { translation: [0.0; 3], amplitude: Amplitude { points: vec![[0.0, 0.0]] }, rotation: None }
    }

    /// Position at time `time` of a node that is at `reference` at the start.
    pub fn position(&self, time: f64, reference: [f64; 3]) -> [f64; 3] {
        let turned = match &self.rotation {
            Some((rotation, amplitude)) => rotation.turned(reference, amplitude.at(time)),
            None => reference,
        };
        let factor = self.amplitude.at(time);
        std::array::from_fn(|k| turned[k] + factor * self.translation[k])
    }

    /// Whether nothing moves along an axis at any time.
    pub const fn rests_along(&self, axis: usize) -> bool {
        self.rotation.is_none() && self.translation[axis] == 0.0
    }

    /// The times of the points of its amplitudes, in no order.
    pub fn times(&self) -> impl Iterator<Item = f64> {
        let turning = self.rotation.iter().flat_map(|(_, amplitude)| amplitude.times());
        self.amplitude.times().chain(turning)
    }

    /// Whether both move every node alike along an axis.
    pub(super) fn agrees(&self, other: &Self, axis: usize) -> bool {
        let (here, there) = (self.translation[axis], other.translation[axis]);
        let translations = here == there && (here == 0.0 || self.amplitude == other.amplitude);
        // A rotation about the axis itself moves nothing along it.
        let turns = |rotation: &Rotation| (0..3).any(|k| k != axis && rotation.axis[k] != 0.0);
        let [one, two] = [self, other].map(|own| own.rotation.as_ref().filter(|(own, _)| turns(own)));
        translations && one == two
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amplitudes_are_linear_between_points_and_constant_outside() {
        let amplitude = Amplitude::new(vec![[1.0, 2.0], [2.0, 4.0], [4.0, 0.0]]).unwrap();
        for (time, factor) in
            [(0.0, 2.0), (1.0, 2.0), (1.5, 3.0), (2.0, 4.0), (3.0, 2.0), (4.0, 0.0), (9.0, 0.0)]
        {
            assert_eq!(amplitude.at(time), factor, "at {time}");
        }
        assert_eq!(Amplitude::ramp(4.0).at(1.0), 0.25);
    }

    #[test]
    fn amplitudes_ascend() {
        assert_eq!(Amplitude::new(vec![]), Err(0));
        assert_eq!(Amplitude::new(vec![[0.0, 0.0], [0.0, 1.0]]), Err(1));
        assert_eq!(Amplitude::new(vec![[0.0, 0.0], [1.0, f64::NAN]]), Err(1));
    }

    #[test]
    fn a_rotation_is_exact_and_right_handed() {
        let rotation = Rotation { axis: [0.0, 0.0, 1e-200], point: [1.0, 0.0, 0.0], degrees: 180.0 };
        assert_eq!(rotation.turned([3.0, 0.0, 5.0], 0.0), [3.0, 0.0, 5.0]);
        assert_eq!(rotation.turned([3.0, 0.0, 5.0], 0.5), [1.0, 2.0, 5.0]);
        assert_eq!(rotation.turned([3.0, 0.0, 5.0], 1.0), [-1.0, 0.0, 5.0]);
        let oblique = Rotation { axis: [1.0, 2.0, -0.5], point: [0.3, 0.1, 0.7], degrees: 137.0 };
        let there = oblique.turned([2.0, 3.0, 4.0], 1.0);
        let back = Rotation { degrees: -137.0, ..oblique }.turned(there, 1.0);
        (0..3).for_each(|k| assert!((back[k] - [2.0, 3.0, 4.0][k]).abs() < 1e-14));
    }

    #[test]
    fn a_motion_turns_first() {
        let rotation = Rotation { axis: [0.0, 0.0, 1.0], point: [0.0; 3], degrees: 90.0 };
        let motion = Motion {
            translation: [10.0, 0.0, 0.0],
            amplitude: Amplitude::ramp(2.0),
            rotation: Some((rotation, Amplitude::ramp(1.0))),
        };
        assert_eq!(motion.position(0.0, [1.0, 0.0, 0.0]), [1.0, 0.0, 0.0]);
        assert_eq!(motion.position(1.0, [1.0, 0.0, 0.0]), [5.0, 1.0, 0.0]);
        assert_eq!(Motion::fixed().position(7.0, [1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
    }
}
