//! The law of contact.

use std::mem::offset_of;

use runtime::assembly::{ContactLaw, Tangent};
use runtime::friction::Coulomb;

use crate::border::{self, Span, Versioned, input, read_sized, reserved};
use crate::choice;
use crate::status::Failure;

/// The law of contact. With e = penalty x area:
///
///     f = lambda - e g          the contact is active if f > 0
///     R = f N                   force on the nodes
///     K = e N N^T - f M         = -dR/dx
///
/// With friction R has the traction besides, at most friction x f and against the slip, and K its derivative, which is not symmetric
/// where contacts slide or have just closed. Call dc_accept, or dc_faces_accept, before the first increment and after each that has
/// converged: else contacts that carry force are refused with DC_NOT_EVALUATED.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dc_law {
    /// sizeof(dc_law), set by the caller.
    pub size: usize,
    /// Force per length, or per length^3 where contacts carry areas; positive.
    pub penalty: f64,
    /// lambda of each slave, at least 0: the forces of the augmented Lagrangian. NULL for the penalty method.
    pub multipliers: *const f64,
    /// Number of multipliers: of slaves, 1 for a single element, or 0.
    pub multiplier_count: usize,
    /// dc_tangent; 0 is DC_EXACT.
    pub tangent: i32,
    /// 0.
    pub reserved: i32,
    /// Coefficient of Coulomb's friction; 0 for none. Over faces it needs nothing else. At nodes it needs DC_DIFFUSE with DC_DOMAINS, and a
    /// library that was built with it: see dc_accept. dc_element_system refuses it.
    pub friction: f64,
    /// Tangential stiffness of contacts that stick, in the unit of the penalty; 0 for that of the penalty.
    pub tangential_stiffness: f64,
    /// Traction that no contact exceeds, in the unit of the pressure: contacts slide at min(friction x f, shear_limit). 0 for none.
    pub shear_limit: f64,
}

// SAFETY: numbers and an address; the first one is the size.
unsafe impl Versioned for dc_law {
    const NAME: &'static str = "dc_law";
    const FIRST: usize = offset_of!(Self, reserved) + 4;
}

/// The structure itself.
///
/// # Safety
/// As [`read`].
unsafe fn structure(law: *const dc_law) -> Result<dc_law, Failure> {
    let defaults = dc_law {
        size: 0,
        penalty: 0.0,
        multipliers: std::ptr::null(),
        multiplier_count: 0,
        tangent: 0,
        reserved: 0,
        friction: 0.0,
        tangential_stiffness: 0.0,
        shear_limit: 0.0,
    };
    // SAFETY: as the caller promises.
    let law = unsafe { read_sized(law, || defaults)? };
    reserved("dc_law", law.reserved)?;
    Ok(law)
}

/// Where the multipliers lie.
///
/// # Safety
/// As [`read`].
pub unsafe fn span(law: *const dc_law) -> Result<Span, Failure> {
    // SAFETY: as the caller promises.
    let law = unsafe { structure(law)? };
    Ok(border::read("multipliers", law.multipliers, law.multiplier_count))
}

/// The law of the caller; the runtime checks its numbers.
///
/// # Safety
/// `law` is NULL or has as many bytes as its field `size` says, `multipliers` has `multiplier_count` entries.
pub unsafe fn read<'a>(law: *const dc_law) -> Result<ContactLaw<'a>, Failure> {
    // SAFETY: as the caller promises.
    let law = unsafe { structure(law)? };
    // SAFETY: as the caller promises.
    let multipliers = unsafe { input("multipliers", law.multipliers, law.multiplier_count)? };
    let friction = if law.friction == 0.0 {
        None
    } else {
        let given = law.tangential_stiffness;
        let stiffness = if given == 0.0 { law.penalty } else { given };
        let limit = Some(law.shear_limit).filter(|limit| *limit != 0.0);
        Some(Coulomb::new(law.friction, stiffness)?.with_shear_limit(limit)?)
    };
    Ok(ContactLaw::penalty(law.penalty)
        .with_friction(friction)
        .with_multipliers(Some(multipliers).filter(|_| !law.multipliers.is_null()))
        .with_tangent(choice::tangent(law.tangent)?))
}

/// The dc_tangent for the next linear solution of a Newton iteration, to be put into a law before the tangent is assembled:
/// DC_GAUSS_NEWTON far from equilibrium, where the exact tangent leads nowhere, DC_EXACT elsewhere.
///
/// `residual` is the norm of the residual over the free equations, contact included; `force` the largest of the norms of external
/// forces, contact forces and reactions at the same positions. Exact if residual / force <= 0.3 or the residual is 0, else
/// DC_GAUSS_NEWTON, as for NaN.
#[unsafe(no_mangle)]
pub extern "C" fn dc_adaptive_tangent(residual: f64, force: f64) -> i32 {
    choice::tangent_number(Tangent::adaptive(residual, force))
}
