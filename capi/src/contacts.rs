//! Results of the last evaluation.

use runtime::Mode;
use runtime::assembly::AssemblyError;
use runtime::interface::{ContactRef, Outcome};
use runtime::neighbourhood::Fallback;

use crate::border::{Plain, disjoint, reserve, target, wanted};
use crate::interface::{call, dc_interface};
use crate::law::{self, dc_law};
use crate::outcome;
use crate::status::{DC_NO_CONTACT, DC_NOT_EVALUATED, Failure, dc_status};

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
    /// Support radius of the pairing, length; with DC_DOMAINS the shortest half axis of the domains of its list; node to facet: the extent
    /// of the facet; 0 if it is not paired.
    pub support_radius: f64,
}

// SAFETY: numbers, no padding.
unsafe impl Plain for dc_contact {}

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
    call(interface, |state| {
        let k = state.slave(slave)?;
        let found = state.contacts()?.get(k);
        let contact = target("contact", contact, 1)?;
        unsafe { contact.write([dc_contact::new(&found, state.interface.support_radius(k))]) };
        match found.outcome {
            Outcome::Contact { .. } => Ok(()),
            Outcome::None(reason) => Err(Failure::new(DC_NO_CONTACT, format!("{}: {reason}", reason.code()))),
        }
    })
}

/// Nodes and derivatives of the `slave`-th slave: `nodes`, slave first, n + 1 numbers; `gradient` N, 3(n+1) numbers, x, y, z
/// of each node in that order; `hessian` M, the lower triangle row by row, entry (i, j <= i) at i(i+1)/2 + j, 3(n+1)(3n+4)/2 numbers.
/// What is not wanted is NULL. The sizes are those of the arrays. DC_NO_CONTACT where there is none; the nodes are
/// there even so, if it is paired. DC_NOT_EVALUATED for derivatives that the mode of dc_evaluate did not ask for.
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
    call(interface, |state| {
        let k = state.slave(slave)?;
        let contacts = state.contacts()?;
        let found = contacts.get(k);
        let count = if found.nodes.is_empty() { 0 } else { found.nodes.len() + 1 };
        let freedoms = 3 * count;
        let nodes = wanted("nodes", nodes, node_size, count)?;
        let gradient = wanted("gradient", gradient, gradient_size, freedoms)?;
        let hessian = wanted("hessian", hessian, hessian_size, freedoms * (freedoms + 1) / 2)?;
        disjoint([nodes.span(), gradient.span(), hessian.span()])?;
        let result = match found.outcome {
            Outcome::Contact { .. } => {
                let wanted =
                    [("gradient", gradient.len(), found.gradient), ("hessian", hessian.len(), found.hessian)];
                for (name, wanted, there) in wanted {
                    if wanted > there.len() {
                        let mode = mode_name(contacts.mode());
                        let message =
                            format!("not-evaluated: there is no {name}, the last evaluation was with {mode}");
                        return Err(Failure::new(DC_NOT_EVALUATED, message));
                    }
                }
                Ok(())
            }
            Outcome::None(reason) => Err(Failure::new(DC_NO_CONTACT, format!("{}: {reason}", reason.code()))),
        };
        let own = std::iter::once(found.slave as i32).chain(found.nodes.iter().map(|&node| node as i32));
        unsafe {
            nodes.write(own);
            if result.is_ok() {
                gradient.write(found.gradient.iter().copied());
                hessian.write(found.hessian.iter().copied());
            }
        }
        result
    })
}

const fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Value => "DC_VALUE",
        Mode::Gradient => "DC_GRADIENT",
        _ => "DC_HESSIAN",
    }
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
    call(interface, |state| {
        state.expect_slaves(slave_count)?;
        let contacts = state.contacts()?;
        let outcomes = wanted("outcomes", outcomes, slave_count, slave_count)?;
        let gaps = wanted("gaps", gaps, slave_count, slave_count)?;
        disjoint([outcomes.span(), gaps.span()])?;
        unsafe {
            outcomes.write(contacts.iter().map(|contact| outcome::of(&contact.outcome) as i32));
            gaps.write(contacts.iter().map(|contact| contact.point.gap));
        }
        Ok(())
    })
}

/// What a post-processor shows, for all slaves: `penetrations` max(0, -g), length; `forces` f = max(0, lambda - e g);
/// `pressures` f over the area, a force where the interface has no areas. 0 without contact. Each may be NULL. With
/// lambda <- f it is also the update of the augmented Lagrangian: `forces` may be the array of the multipliers.
///
/// # Safety
/// The arrays have `slave_count` entries, `law` as in dc_add_forces.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_forces(
    interface: *mut dc_interface,
    law: *const dc_law,
    penetrations: *mut f64,
    forces: *mut f64,
    pressures: *mut f64,
    slave_count: usize,
) -> dc_status {
    call(interface, |state| {
        state.expect_slaves(slave_count)?;
        let contacts = state.contacts()?;
        let arrays = [("penetrations", penetrations), ("forces", forces), ("pressures", pressures)];
        let [penetrations, forces, pressures] =
            arrays.map(|(name, pointer)| wanted(name, pointer, slave_count, slave_count));
        let (penetrations, forces, pressures) = (penetrations?, forces?, pressures?);
        disjoint([penetrations.span(), forces.span(), pressures.span()])?;
        unsafe {
            law::disjoint(law, [penetrations.span(), pressures.span()])?;
            law::disjoint_but_multipliers(law, forces.span())?;
        }
        let mut values = reserve("forces", slave_count)?;
        // SAFETY: as the caller promises. The multipliers are not looked at once the forces are written.
        let law = unsafe { law::read(law)? };
        let law = law.contact()?;
        law.validate_for(contacts)?;
        for (k, contact) in contacts.iter().enumerate() {
            if !contact.outcome.is_contact() {
                values.push([0.0; 3]);
                continue;
            }
            let (gap, area) = (contact.point.gap, contact.area);
            let force = law.checked_normal_force(k, gap, area)?.force;
            let pressure = if area > 0.0 { force / area } else { 0.0 };
            if !pressure.is_finite() {
                return Err(
                    AssemblyError::ForceOverflow { element: k, penalty: law.penalty, area, gap }.into()
                );
            }
            values.push([(-gap).max(0.0), force, pressure]);
        }
        for (which, target) in [penetrations, forces, pressures].into_iter().enumerate() {
            unsafe { target.write(values.iter().map(|values| values[which])) };
        }
        Ok(())
    })
}

/// A factor for the increment, from 0.1 to 1, like PNEWDT: below 1 the increment had better be cut back by it. The smallest of
///
/// - cutback_penetration R/(-g), for a slave that penetrates deeper than cutback_penetration x R, the support radius;
/// - 0.5, for a slave that penetrated and whose foot lies outside its domain of influence in the last evaluation;
/// - 0.25, for one whose element failed otherwise: no foot, singular fit, overflow.
///
/// A slave penetrated if its gap was negative when it last had one since dc_refresh, or there; that it is not paired, too far, without a
/// candidate or a facet over it, or beyond the border ends it. Contacts that a refresh loses are in dc_report (contacts_lost, lost_gap).
///
/// # Safety
/// `factor` may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_cutback(interface: *mut dc_interface, factor: *mut f64) -> dc_status {
    call(interface, |state| {
        state.contacts()?;
        let factor = target("factor", factor, 1)?;
        unsafe { factor.write([state.cutback.hint(&state.interface, state.cutback_limit).factor]) };
        Ok(())
    })
}
