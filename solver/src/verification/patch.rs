//! Whether a uniform pressure passes an interface.

use super::Snapshot;
use crate::solid::SolidError;

/// Deviations from a uniform uniaxial state of stress, all relative to the pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uniformity {
    /// Largest deviation of the normal stress from −p at any integration point.
    pub stress: f64,
    /// Its root mean square over the integration points.
    pub stress_rms: f64,
    /// Largest other component of the stress at any integration point.
    pub other_stress: f64,
    /// Largest deviation of any slave's pressure, force over area, from p. In a two-pass interface both sides have slaves, and forces of
    /// a side are only a part of the whole: then it says how unevenly.
    pub contact: f64,
}

impl Uniformity {
    /// Against the pressure `p` > 0 along `axis`; the interfaces carry areas.
    ///
    /// # Errors
    /// Those of [`Solid::recover`](crate::solid::Solid::recover).
    pub fn of(snapshot: &Snapshot<'_>, axis: usize, p: f64) -> Result<Self, SolidError> {
        let Snapshot { state, problem, .. } = snapshot;
        let recovery = problem.solid().recover(&state.positions, &state.points)?;
        let contact = snapshot.slaves().map(|slave| slave.force / slave.area);
        Ok(Self::between(recovery.points.iter().map(|point| point.stress), contact, axis, p))
    }

    /// Of the stresses at the points and of the slaves' pressures.
    fn between(
        stresses: impl ExactSizeIterator<Item = [f64; 6]>,
        pressures: impl Iterator<Item = f64>,
        axis: usize,
        p: f64,
    ) -> Self {
        let points = stresses.len() as f64;
        let (mut stress, mut squares, mut other_stress) = (0.0_f64, 0.0, 0.0_f64);
        for point in stresses {
            for (component, value) in point.into_iter().enumerate() {
                if component == axis {
                    let deviation = (value + p) / p;
                    stress = worse(stress, deviation.abs());
                    squares += deviation * deviation;
                } else {
                    other_stress = worse(other_stress, (value / p).abs());
                }
            }
        }
        Self {
            stress,
            stress_rms: (squares / points).sqrt(),
            other_stress,
            contact: pressures.map(|pressure| (pressure / p - 1.0).abs()).fold(0.0, worse),
        }
    }
}

/// The larger of two deviations; NaN if one is.
fn worse(x: f64, y: f64) -> f64 {
    if x.is_nan() || x > y { x } else { y }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deviation_that_is_no_number_stays() {
        let of = |stresses: [[f64; 6]; 3], pressures: [f64; 3]| {
            Uniformity::between(stresses.into_iter(), pressures.into_iter(), 2, 4.0)
        };
        let uniform = [[0.0, 0.0, -4.0, 0.0, 0.0, 0.0]; 3];
        let found = of(uniform, [4.0, 5.0, 4.0]);
        assert_eq!(found, Uniformity { stress: 0.0, stress_rms: 0.0, other_stress: 0.0, contact: 0.25 });
        let mut broken = uniform;
        broken[0][2] = f64::NAN;
        broken[1][4] = f64::NAN;
        let found = of(broken, [4.0, f64::NAN, 4.0]);
        assert!(
            [found.stress, found.stress_rms, found.other_stress, found.contact].iter().all(|x| x.is_nan())
        );
    }
}
