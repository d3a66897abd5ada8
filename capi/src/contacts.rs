//! Results of the last evaluation.

use runtime::interface::{ContactRef, Outcome};
use runtime::neighbourhood::Fallback;

use crate::border::{self, single, wanted};
use crate::interface::{dc_interface, with};
use crate::law::{self, dc_law};
use crate::outcome;
use crate::status::{DC_NO_CONTACT, DC_NOT_EVALUATED, DC_OVERFLOW, Failure, dc_status};

/// The contact of one slave. Without contact the numbers are 0, but for the area.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct dc_contact {
    /// The slave node.
    pub node: i32,
    /// Number n of its masters; 0 if it is not paired.
    pub master_count: i32,
    /// dc_outcome.
    pub outcome: i32,
    /// dc_fallback.
    pub fallback: i32,
    /// Signed gap, length: positive apart, negative penetrating.
    pub gap: f64,
    /// Foot on the master surface.
    pub foot: [f64; 3],
    /// Unit normal of the surface there, outward.
    pub normal: [f64; 3],
    /// Tributary area of the slave, length^2; 1 without areas.
    pub area: f64,
    /// Support radius of the pairing, length; node to facet: the extent of the facet; 0 if it is not paired.
    pub support_radius: f64,
}

impl dc_contact {
    fn new(contact: &ContactRef<'_>, support_radius: Option<f64>) -> Self {
        let fallback = match contact.outcome {
            Outcome::Contact { fallback } => fallback,
            Outcome::None(_) => Fallback::None,
        };
        Self {
            node: contact.slave as i32,
            master_count: contact.nodes.len() as i32,
            outcome: outcome::of(&contact.outcome) as i32,
            fallback: outcome::fallback_number(fallback),
            gap: contact.point.gap,
            foot: contact.point.foot,
            normal: contact.point.normal,
            area: contact.area,
            support_radius: support_radius.unwrap_or(0.0),
        }
    }
}

/// The contact of the `slave`-th slave, counted from 0. Where it has none, DC_NO_CONTACT, and dc_message() says why.
///
/// # Safety
/// `contact` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_contact_of(
    interface: *mut dc_interface,
    slave: usize,
    contact: *mut dc_contact,
) -> dc_status {
    border::call(|| {
        with(interface, |state| {
            let k = state.slave(slave)?;
            let found = state.contacts()?.get(k);
            // SAFETY: as the caller promises.
            *unsafe { single("contact", contact)? } =
                dc_contact::new(&found, state.interface.support_radius(k));
            match found.outcome {
                Outcome::Contact { .. } => Ok(()),
                Outcome::None(reason) => {
                    Err(Failure::new(DC_NO_CONTACT, format!("{}: {reason}", reason.code())))
                }
            }
        })
    })
}

/// Nodes and derivatives of the `slave`-th slave: `nodes`, slave first, n + 1 numbers; `gradient` N, 3(n+1) numbers, x, y, z
/// of each node in that order; `hessian` M, the lower triangle row by row, entry (i, j <= i) at i(i+1)/2 + j, 3(n+1)(3n+4)/2 numbers.
/// What is not wanted is NULL. The sizes are those of the arrays. DC_NO_CONTACT where there is none; the nodes are
/// there even so, if it is paired.
///
/// # Safety
/// The arrays have the given lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_derivatives(
    interface: *mut dc_interface,
    slave: usize,
    nodes: *mut i32,
    node_size: usize,
    gradient: *mut f64,
    gradient_size: usize,
    hessian: *mut f64,
    hessian_size: usize,
) -> dc_status {
    border::call(|| {
        with(interface, |state| {
            let k = state.slave(slave)?;
            let found = state.contacts()?.get(k);
            let count = if found.nodes.is_empty() { 0 } else { found.nodes.len() + 1 };
            let freedoms = 3 * count;
            // SAFETY: as the caller promises.
            let (nodes, gradient, hessian) = unsafe {
                (
                    wanted("nodes", nodes, node_size, count)?,
                    wanted("gradient", gradient, gradient_size, freedoms)?,
                    wanted("hessian", hessian, hessian_size, freedoms * (freedoms + 1) / 2)?,
                )
            };
            if let Some([first, others @ ..]) = nodes {
                *first = found.slave as i32;
                others.iter_mut().zip(found.nodes).for_each(|(target, &node)| *target = node as i32);
            }
            if let Outcome::None(reason) = found.outcome {
                return Err(Failure::new(DC_NO_CONTACT, format!("{}: {reason}", reason.code())));
            }
            for (target, source) in [(gradient, found.gradient), (hessian, found.hessian)] {
                let Some(target) = target else { continue };
                if target.len() != source.len() {
                    let message = "not-evaluated: evaluate with a mode that has these derivatives";
                    return Err(Failure::new(DC_NOT_EVALUATED, message));
                }
                target.copy_from_slice(source);
            }
            Ok(())
        })
    })
}

/// Outcomes and gaps of all slaves, one entry each; the gap is 0 without contact. Either may be NULL.
///
/// # Safety
/// The arrays have `slave_count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_gaps(
    interface: *mut dc_interface,
    outcomes: *mut i32,
    gaps: *mut f64,
    slave_count: usize,
) -> dc_status {
    border::call(|| {
        with(interface, |state| {
            state.expect_slaves(slave_count)?;
            let contacts = state.contacts()?;
            // SAFETY: as the caller promises.
            let (outcomes, gaps) = unsafe {
                (
                    wanted("outcomes", outcomes, slave_count, slave_count)?,
                    wanted("gaps", gaps, slave_count, slave_count)?,
                )
            };
            for (target, contact) in outcomes.into_iter().flatten().zip(contacts.iter()) {
                *target = outcome::of(&contact.outcome) as i32;
            }
            for (target, contact) in gaps.into_iter().flatten().zip(contacts.iter()) {
                *target = contact.point.gap;
            }
            Ok(())
        })
    })
}

/// What a post-processor shows, for all slaves: `penetrations` max(0, -g), length; `forces` f = max(0, lambda - e g);
/// `pressures` f over the area, a force where the interface has no areas. 0 without contact. Each may be NULL. With
/// lambda <- f it is also the update of the augmented Lagrangian: `forces` may be the array of the multipliers.
///
/// # Safety
/// The arrays have `slave_count` entries, `law` as in dc_residual.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_forces(
    interface: *mut dc_interface,
    law: *const dc_law,
    penetrations: *mut f64,
    forces: *mut f64,
    pressures: *mut f64,
    slave_count: usize,
) -> dc_status {
    border::call(|| {
        with(interface, |state| {
            state.expect_slaves(slave_count)?;
            let contacts = state.contacts()?;
            // SAFETY: as the caller promises.
            let law = unsafe { law::read(law)? };
            law.validate(slave_count)?;
            let mut values = Vec::with_capacity(slave_count);
            for (k, contact) in contacts.iter().enumerate() {
                if !contact.outcome.is_contact() {
                    values.push([0.0; 3]);
                    continue;
                }
                let force = law.force(k, contact.point.gap, contact.area);
                let pressure = if contact.area > 0.0 { force / contact.area } else { 0.0 };
                if !(force.is_finite() && pressure.is_finite()) {
                    let message = format!("overflow: the contact force of slave {k} is {force}");
                    return Err(Failure::new(DC_OVERFLOW, message));
                }
                values.push([(-contact.point.gap).max(0.0), force, pressure]);
            }
            for (which, pointer) in [penetrations, forces, pressures].into_iter().enumerate() {
                // SAFETY: as the caller promises.
                let target = unsafe { wanted("forces", pointer, slave_count, slave_count)? };
                for (target, values) in target.into_iter().flatten().zip(&values) {
                    *target = values[which];
                }
            }
            Ok(())
        })
    })
}

/// A factor for the increment, from 0.1 to 1, like PNEWDT: below 1 the increment had better be cut back by it. The smallest of
///
/// - cutback_penetration R/(-g), for a slave that penetrates deeper than cutback_penetration x R, the support radius;
/// - 0.5, if the last refresh lost a contact with a penetration deeper than cutback_lost x R;
/// - 0.5, if the foot of a slave that penetrated lies outside its domain of influence in the last evaluation;
/// - 0.25, if the element of such a slave failed otherwise: no foot, singular fit, overflow.
///
/// A slave penetrated if its gap was negative when it last had one. `factor` is 1 before the first evaluation.
///
/// # Safety
/// `factor` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_cutback(interface: *mut dc_interface, factor: *mut f64) -> dc_status {
    border::call(|| {
        with(interface, |state| {
            // SAFETY: as the caller promises.
            *unsafe { single("factor", factor)? } = state.cutback.factor();
            Ok(())
        })
    })
}
