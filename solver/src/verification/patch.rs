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
        let (mut stress, mut squares, mut other_stress) = (0.0_f64, 0.0, 0.0_f64);
        for point in &recovery.points {
            for (component, value) in point.stress.into_iter().enumerate() {
                if component == axis {
                    let deviation = (value + p) / p;
                    stress = stress.max(deviation.abs());
                    squares += deviation * deviation;
                } else {
                    other_stress = other_stress.max((value / p).abs());
                }
            }
        }
        let contact = snapshot.slaves().map(|slave| (slave.force / slave.area / p - 1.0).abs());
        Ok(Self {
            stress,
            stress_rms: (squares / recovery.points.len() as f64).sqrt(),
            other_stress,
            // A deviation that is no number stays one.
            contact: contact.fold(0.0, |most, own| if own <= most { most } else { own }),
        })
    }
}
