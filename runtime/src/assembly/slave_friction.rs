//! What friction does at each slave, for results.

use super::law::Needs;
use super::{AssemblyError, ContactLaw, ContactView, Elements};
use crate::Point;
use crate::friction::FrictionState;

/// Friction of a slave node; open, with zeros, where it carries no force and where it has no anchor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SlaveFriction {
    /// Stick, slip or neither.
    pub state: FrictionState,
    /// On the slave, force per area; force where contacts carry no areas.
    pub traction: Point,
    /// From the anchor, or of a slave that was open from its place of touch, length: the elastic slip, and where it slides what it has
    /// slid in the step besides. With [augmentation](crate::Coulomb::with_augmentation) from where it stuck, without its multiplier.
    pub slip: f64,
}

/// The friction of all elements by a law, one entry each. Without friction in the law all are open.
///
/// # Errors
/// As [`add_forces`](super::add_forces), but for what concerns equations; [`AssemblyError::ForceOverflow`] also for a traction.
pub fn slave_friction<E: Elements + ?Sized>(
    elements: &E,
    law: &ContactLaw<'_>,
) -> Result<Vec<SlaveFriction>, AssemblyError> {
    law.validate_for(elements)?;
    let mut found = super::reserve("slaves", elements.len())?;
    for k in 0..elements.len() {
        let element = elements.element(k);
        law.check_element(k, &element, Needs::Residual)?;
        found.push(element.contact.map_or(Ok(SlaveFriction::default()), |contact| of(law, k, &contact))?);
    }
    Ok(found)
}

/// Of an element that passes the law's check.
fn of(law: &ContactLaw<'_>, k: usize, contact: &ContactView<'_>) -> Result<SlaveFriction, AssemblyError> {
    let ContactView { gap, area, slip, .. } = *contact;
    let (Some(slip), Some(friction)) = (slip, law.friction_of(k, gap, area, slip)) else {
        return Ok(SlaveFriction::default());
    };
    if friction.state == FrictionState::Open {
        return Ok(SlaveFriction::default());
    }
    // R = −c ∇q, of which the slave's entries are the first.
    let traction = [0, 1, 2].map(|axis| -friction.factor * slip.gradient[axis] / area);
    if traction.iter().any(|t| !t.is_finite()) {
        return Err(AssemblyError::ForceOverflow { element: k, penalty: law.penalty, area, gap });
    }
    let slip = friction.share * slip.since_stuck;
    Ok(SlaveFriction { state: friction.state, traction, slip })
}
