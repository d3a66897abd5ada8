//! The law of contact.

use std::ffi::c_void;
use std::mem::offset_of;
use std::sync::atomic::{AtomicPtr, Ordering};

use runtime::assembly::{AssemblyError, ContactLaw, NormalLaw, NormalPressure, TabulatedPressure, Tangent};
use runtime::friction::{
    CoefficientValue, Coulomb, DecayingCoefficient, FrictionCoefficient, TabulatedCoefficient,
};

use crate::border::{self, Span, Versioned, input, read_sized, reserved};
use crate::choice::{self, Named, dc_coefficient};
use crate::status::{DC_BAD_OPTION, DC_BAD_SIZE, Failure};

/// A normal law of the caller's own. `pressure` has room for two numbers: p, force per area, or over nodes without areas force, and
/// dp/dg, at the signed gap of a slave. `slave` is its place among the slaves, counted from 0, and not its node: see dc_slaves and
/// dc_faces_slaves. A contact whose p is not positive is open. Friction of contacts that close in an increment takes p to begin at the
/// gap 0.
///
/// It is called from several threads at once, within any call that takes the law, and has to answer the same each time. It must return:
/// no exception and no longjmp. What is no number is refused as that of a law.
pub type dc_normal_law =
    Option<unsafe extern "C" fn(context: *mut c_void, slave: usize, gap: f64, pressure: *mut f64)>;

/// A coefficient of friction of the caller's own. `coefficient` has room for three numbers: mu, its derivative by the pressure and that by
/// the slip rate. It is called as a dc_normal_law; of contacts that stick with the slip rate 0.
pub type dc_friction_law =
    Option<unsafe extern "C" fn(context: *mut c_void, pressure: f64, rate: f64, coefficient: *mut f64)>;

/// The law of contact. With e = penalty x area:
///
///     f = lambda - e g          the contact is active if f > 0
///     R = f N                   force on the nodes
///     K = e N N^T - f M         = -dR/dx
///
/// With friction R has the traction besides, at most friction x f and against the slip, and K its derivative, which is not symmetric
/// where contacts slide or have just closed. Call dc_accept, or dc_faces_accept, before the first increment and after each that has
/// converged: else contacts that carry force are refused with DC_NOT_EVALUATED.
///
/// With a normal law by table, or of the caller's own, f = area x p(g), and -area x dp/dg stands in the place of e.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct dc_law {
    /// sizeof(dc_law), set by the caller.
    pub size: usize,
    /// Force per length, or per length^3 where contacts carry areas; positive.
    pub penalty: f64,
    /// lambda of each slave, at least 0: the forces of the augmented Lagrangian. NULL for the penalty method.
    pub multipliers: *const f64,
    /// Number of multipliers: of slaves, or 1 for a single element; 0 with NULL.
    pub multiplier_count: usize,
    /// dc_tangent; 0 is DC_EXACT.
    pub tangent: i32,
    /// 0.
    pub reserved: i32,
    /// Coefficient of Coulomb's friction; 0 for none. Over faces it needs nothing else. At nodes it needs DC_NODE_TO_FACET, or DC_DIFFUSE with
    /// DC_DOMAINS in a library built with it: see dc_accept. dc_element_system refuses it.
    pub friction: f64,
    /// Tangential stiffness of contacts that stick, in the unit of the penalty; 0 for that of the penalty.
    pub tangential_stiffness: f64,
    /// Traction that no contact exceeds, in the unit of the pressure: contacts slide at min(friction x f, shear_limit x area).
    /// 0 for none.
    pub shear_limit: f64,
    /// dc_coefficient; 0 is DC_CONSTANT, `friction`. A field of another coefficient that is set is DC_BAD_OPTION.
    pub coefficient: i32,
    /// Whether the history notes where contacts really stuck, so that dc_augment can take away what they creep by the tangential stiffness:
    /// 0 or 1. Tractions are the same.
    pub augmented: i32,
    /// A normal law by table, in the place of the penalty's: ascending gaps, at least two, ...
    pub normal_gaps: *const f64,
    /// ... and the pressure at each, force per area, or over nodes without areas force: linear between them and beyond them. Contacts whose
    /// pressure is not positive are open. NULL and 0 for the penalty's law; an array whose count is 0 is DC_BAD_SIZE. There are no
    /// multipliers then, and the penalty only estimates where contacts that close have touched: about the stiffness of the table in contact.
    /// They are open from the gap on at which the last falling line has no pressure any more.
    pub normal_pressures: *const f64,
    /// Number of gaps, and of pressures.
    pub normal_count: usize,
    /// How long the increment lasts, positive; for coefficients that depend on the slip rate.
    pub duration: f64,
    /// DC_DECAYING: the coefficient of fast sliding; `friction` is that of rest.
    pub friction_in_motion: f64,
    /// DC_DECAYING: how fast it decays, time per length.
    pub friction_decay: f64,
    /// DC_TABULATED: ascending pressures, one or more, ...
    pub friction_pressures: *const f64,
    /// ... and their number; ...
    pub friction_pressure_count: usize,
    /// ... ascending slip rates, one or more, length per time, ...
    pub friction_rates: *const f64,
    /// ... and their number; ...
    pub friction_rate_count: usize,
    /// ... and coefficients, for each rate at the first pressure, then for each at the next one: bilinear between them, constant beyond.
    /// `friction` is 0 then.
    pub friction_table: *const f64,
    /// A normal law of the caller's own, in the place of a table; NULL for none. What is said of the penalty beside a table holds.
    pub normal_law: dc_normal_law,
    /// DC_FUNCTION: the coefficient. `friction` is 0 then.
    pub friction_law: dc_friction_law,
    /// Handed to both.
    pub context: *mut c_void,
}

/// A function of the caller's with its context.
#[derive(Debug)]
struct Own<F> {
    function: F,
    context: AtomicPtr<c_void>,
}

impl<F> Own<F> {
    fn new(function: F, law: &dc_law) -> Self {
        Self { function, context: AtomicPtr::new(law.context) }
    }

    fn context(&self) -> *mut c_void {
        self.context.load(Ordering::Relaxed)
    }
}

impl NormalLaw for Own<unsafe extern "C" fn(*mut c_void, usize, f64, *mut f64)> {
    fn pressure(&self, slave: usize, gap: f64) -> NormalPressure {
        // What is not written is no number.
        let mut found = [f64::NAN; 2];
        // SAFETY: as the caller of [`read`] promises; there is room for two numbers.
        unsafe { (self.function)(self.context(), slave, gap, found.as_mut_ptr()) };
        let [pressure, by_gap] = found;
        NormalPressure { pressure, by_gap }
    }
}

impl FrictionCoefficient for Own<unsafe extern "C" fn(*mut c_void, f64, f64, *mut f64)> {
    fn coefficient(&self, pressure: f64, rate: f64) -> CoefficientValue {
        let mut found = [f64::NAN; 3];
        // SAFETY: as the caller of [`read`] promises; there is room for three numbers.
        unsafe { (self.function)(self.context(), pressure, rate, found.as_mut_ptr()) };
        let [value, by_pressure, by_rate] = found;
        CoefficientValue { value, by_pressure, by_rate }
    }
}

// SAFETY: numbers and addresses, of which those of functions may be NULL; the first one is the size.
unsafe impl Versioned for dc_law {
    const NAME: &'static str = "dc_law";
    const FIRST: usize = offset_of!(Self, reserved) + 4;
}

impl dc_law {
    /// What fields are that a caller does not know.
    pub(crate) const NONE: Self = Self { size: size_of::<Self>(), ..border::zeros() };

    /// The structure itself.
    ///
    /// # Safety
    /// As [`read`].
    unsafe fn copy(law: *const Self) -> Result<Self, Failure> {
        let law = unsafe { read_sized(law, || Self::NONE)? };
        reserved("dc_law", law.reserved)?;
        Ok(law)
    }

    /// Refuses tables whose count was forgotten: the law would be another one.
    fn check_counts(&self) -> Result<(), Failure> {
        let Self { normal_count, friction_pressure_count, friction_rate_count, .. } = *self;
        for (name, array, count_name, count) in [
            ("normal_gaps", self.normal_gaps, "normal_count", normal_count),
            ("normal_pressures", self.normal_pressures, "normal_count", normal_count),
            (
                "friction_pressures",
                self.friction_pressures,
                "friction_pressure_count",
                friction_pressure_count,
            ),
            ("friction_rates", self.friction_rates, "friction_rate_count", friction_rate_count),
        ] {
            if !array.is_null() && count == 0 {
                let message = format!("bad-size: there is an array {name}, but {count_name} is 0");
                return Err(Failure::new(DC_BAD_SIZE, message));
            }
        }
        Ok(())
    }

    /// Refuses fields of another coefficient than the law's: it would not be the one that was meant.
    fn check_coefficient(&self, kind: dc_coefficient) -> Result<(), Failure> {
        use dc_coefficient::{DC_DECAYING, DC_FUNCTION, DC_TABULATED};
        for (name, is_set, of) in [
            ("friction_in_motion", self.friction_in_motion != 0.0, DC_DECAYING),
            ("friction_decay", self.friction_decay != 0.0, DC_DECAYING),
            ("friction_pressures", !self.friction_pressures.is_null(), DC_TABULATED),
            ("friction_rates", !self.friction_rates.is_null(), DC_TABULATED),
            ("friction_table", !self.friction_table.is_null(), DC_TABULATED),
            ("friction_law", self.friction_law.is_some(), DC_FUNCTION),
        ] {
            if is_set && kind != of {
                let message =
                    format!("invalid-option: {name} belongs to {of:?}, and coefficient is {kind:?}");
                return Err(Failure::new(DC_BAD_OPTION, message));
            }
        }
        Ok(())
    }

    /// Number of coefficients in the table.
    fn table_count(&self) -> Result<usize, Failure> {
        let Self { friction_pressure_count: pressures, friction_rate_count: rates, .. } = *self;
        pressures.checked_mul(rates).ok_or_else(|| {
            let message = format!("bad-size: there cannot be {pressures} x {rates} coefficients");
            Failure::new(DC_BAD_SIZE, message)
        })
    }

    /// Where its arrays lie, the multipliers first.
    fn arrays(&self) -> Result<[Span; 6], Failure> {
        Ok([
            border::read("multipliers", self.multipliers, self.multiplier_count),
            border::read("normal_gaps", self.normal_gaps, self.normal_count),
            border::read("normal_pressures", self.normal_pressures, self.normal_count),
            border::read("friction_pressures", self.friction_pressures, self.friction_pressure_count),
            border::read("friction_rates", self.friction_rates, self.friction_rate_count),
            border::read("friction_table", self.friction_table, self.table_count()?),
        ])
    }
}

/// Refuses arrays that overlap, of the law or of those that are given, if one of them is written.
///
/// # Safety
/// As [`read`].
pub unsafe fn disjoint<const N: usize>(law: *const dc_law, spans: [Span; N]) -> Result<(), Failure> {
    let arrays = unsafe { dc_law::copy(law)? }.arrays()?;
    border::disjoint(spans)?;
    spans.iter().try_for_each(|&span| arrays.iter().try_for_each(|&array| border::disjoint([array, span])))
}

/// The same, but `span` may be the array of the multipliers.
///
/// # Safety
/// As [`read`].
pub unsafe fn disjoint_but_multipliers(law: *const dc_law, span: Span) -> Result<(), Failure> {
    let [multipliers, tables @ ..] = unsafe { dc_law::copy(law)? }.arrays()?;
    if !multipliers.is_same(&span) {
        border::disjoint([multipliers, span])?;
    }
    tables.into_iter().try_for_each(|array| border::disjoint([array, span]))
}

/// A law with the tables that it refers to.
#[derive(Debug)]
pub struct Law<'a> {
    given: dc_law,
    multipliers: Option<&'a [f64]>,
    tangent: Tangent,
    /// A normal law that is not the penalty's.
    normal: Option<Box<dyn NormalLaw>>,
    /// A coefficient that is no constant.
    coefficient: Option<Box<dyn FrictionCoefficient>>,
    augmented: bool,
}

/// The law of the caller.
///
/// # Safety
/// `law` is NULL or has as many bytes as its field `size` says, its arrays have their numbers of entries, and its functions may be called
/// while the law is used.
pub unsafe fn read<'a>(law: *const dc_law) -> Result<Law<'a>, Failure> {
    let given = unsafe { dc_law::copy(law)? };
    given.check_counts()?;
    let (multipliers, gaps, pressures) = unsafe {
        (
            input("multipliers", given.multipliers, given.multiplier_count)?,
            input("normal_gaps", given.normal_gaps, given.normal_count)?,
            input("normal_pressures", given.normal_pressures, given.normal_count)?,
        )
    };
    let normal: Option<Box<dyn NormalLaw>> = match given.normal_law {
        Some(_) if !gaps.is_empty() => {
            let message =
                "invalid-option: normal_law stands in the place of a table, and there are normal_gaps";
            return Err(Failure::new(DC_BAD_OPTION, message.to_owned()));
        }
        Some(function) => Some(Box::new(Own::new(function, &given))),
        None if gaps.is_empty() => None,
        None => Some(Box::new(TabulatedPressure::new(gaps, pressures)?)),
    };
    Ok(Law {
        // Where a count was forgotten it is not that of the slaves, and told so.
        multipliers: Some(multipliers).filter(|_| !given.multipliers.is_null()),
        tangent: choice::read(given.tangent)?,
        normal,
        coefficient: unsafe { variable(&given)? },
        augmented: choice::flag("augmented", given.augmented)?,
        given,
    })
}

/// The coefficient of friction, if it is no constant.
///
/// # Safety
/// As [`read`].
unsafe fn variable(law: &dc_law) -> Result<Option<Box<dyn FrictionCoefficient>>, Failure> {
    let table_count = law.table_count()?;
    let without_constant = |kind: &str| {
        if law.friction == 0.0 {
            return Ok(());
        }
        let message =
            format!("invalid-option: with {kind} friction is 0, and not {}: it has its own", law.friction);
        Err(Failure::new(DC_BAD_OPTION, message))
    };
    let kind = choice::read(law.coefficient)?;
    law.check_coefficient(kind)?;
    Ok(match kind {
        dc_coefficient::DC_CONSTANT => None,
        dc_coefficient::DC_DECAYING => {
            let made = DecayingCoefficient::new(law.friction, law.friction_in_motion, law.friction_decay)?;
            Some(Box::new(made))
        }
        dc_coefficient::DC_TABULATED => {
            without_constant("DC_TABULATED")?;
            let (pressures, rates, table) = unsafe {
                (
                    input("friction_pressures", law.friction_pressures, law.friction_pressure_count)?,
                    input("friction_rates", law.friction_rates, law.friction_rate_count)?,
                    input("friction_table", law.friction_table, table_count)?,
                )
            };
            Some(Box::new(TabulatedCoefficient::new(pressures, rates, table)?))
        }
        dc_coefficient::DC_FUNCTION => {
            without_constant("DC_FUNCTION")?;
            let Some(function) = law.friction_law else {
                let message =
                    "invalid-option: DC_FUNCTION is the coefficient of friction_law, and that is NULL";
                return Err(Failure::new(DC_BAD_OPTION, message.to_owned()));
            };
            Some(Box::new(Own::new(function, law)))
        }
    })
}

impl Law<'_> {
    /// As the runtime takes it, which checks its numbers.
    pub fn contact(&self) -> Result<ContactLaw<'_>, Failure> {
        let dc_law { penalty, friction, tangential_stiffness, shear_limit, duration, .. } = self.given;
        // Before it is called a tangential stiffness, which nobody gave.
        if tangential_stiffness == 0.0 && !(penalty > 0.0 && penalty.is_finite()) {
            return Err(AssemblyError::InvalidPenalty { value: penalty }.into());
        }
        let stiffness = if tangential_stiffness == 0.0 { penalty } else { tangential_stiffness };
        let limit = Some(shear_limit).filter(|limit| *limit != 0.0);
        let made = match &self.coefficient {
            None if friction == 0.0 => None,
            None => Some(Coulomb::new(friction, stiffness)?),
            Some(coefficient) => Some(Coulomb::variable(&**coefficient, duration, stiffness)?),
        };
        let made = made.map(|made| made.with_shear_limit(limit)).transpose()?;
        Ok(ContactLaw::penalty(penalty)
            .with_normal(self.normal.as_deref())
            .with_friction(made.map(|made| made.with_augmentation(self.augmented)))
            .with_multipliers(self.multipliers)
            .with_tangent(self.tangent))
    }
}

/// The dc_tangent for the next linear solution of a Newton iteration, to be put into a law before the tangent is assembled:
/// DC_GAUSS_NEWTON far from equilibrium, where the exact tangent leads nowhere, DC_EXACT elsewhere.
///
/// `residual` is the norm of the residual over the free equations, contact included; `force` the largest of the norms of external
/// forces, contact forces and reactions at the same positions. Exact if residual / force <= 0.3 or the residual is 0, else
/// DC_GAUSS_NEWTON, as for NaN.
#[unsafe(no_mangle)]
pub extern "C" fn dc_adaptive_tangent(residual: f64, force: f64) -> i32 {
    Tangent::adaptive(residual, force).number()
}
