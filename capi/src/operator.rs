//! The tangent as an operator.

use runtime::assembly::{AssemblyError, TangentOperator};

use crate::border::{self, disjoint, input, sums, target, wanted};
use crate::interface::{dc_interface, with};
use crate::law::{self, dc_law};
use crate::registry::Registry;
use crate::status::{Failure, dc_status};
use crate::threads;

/// The tangent K of an interface as an operator, at the positions it was made for: products without a matrix. One thread at a time may use
/// it, any thread.
pub struct dc_operator;

static OPERATORS: Registry<TangentOperator> = Registry::new("operator", 5);

/// Makes the tangent K = -dR/dx at the positions of the last dc_update, dc_follow or dc_refresh, over the equations of the moment. It needs
/// no evaluation, but a dc_refresh: what carries force is evaluated for it. It stays what it is when the interface moves on, or is destroyed. With friction
/// K is not symmetric in general; without anchors it is DC_NOT_EVALUATED then.
///
/// Writes the handle and the number of slaves that carry force, which may be NULL. On failure the handle is NULL.
///
/// # Safety
/// `law` as in dc_add_forces; `tangent` may be written, `active_count` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_operator_create(
    interface: *mut dc_interface,
    law: *const dc_law,
    tangent: *mut *mut dc_operator,
    active_count: *mut usize,
) -> dc_status {
    border::call(|| {
        let active_count = wanted("active_count", active_count, 1, 1)?;
        unsafe { law::disjoint(law, [target("tangent", tangent, 1)?.span(), active_count.span()])? };
        let make = || {
            with(interface, |state| {
                let law = unsafe { law::read(law)? };
                let law = law.contact()?;
                let made = threads::run(|| TangentOperator::new(&state.interface, &law, &state.dofs))?;
                let contacts = made.contacts();
                let made = OPERATORS.insert(made)?;
                unsafe { active_count.write([contacts]) };
                Ok(made)
            })
        };
        unsafe { border::hand_out("tangent", tangent, make) }
    })
}

/// Destroys an operator. NULL is DC_OK. The interface may be gone already.
#[unsafe(no_mangle)]
pub extern "C" fn dc_operator_destroy(tangent: *mut dc_operator) -> dc_status {
    OPERATORS.destroy(tangent)
}

/// v, and the sums that K v is added to.
///
/// # Safety
/// Both have `count` entries.
pub unsafe fn factors<'a>(
    v: *const f64,
    product: *mut f64,
    count: usize,
) -> Result<(&'a [f64], &'a mut [f64]), Failure> {
    disjoint([border::read("v", v, count), border::written("product", product, count)])?;
    // SAFETY: as the caller promises; nothing overlaps.
    unsafe { Ok((input("v", v, count)?, sums("product", product, count)?)) }
}

/// Adds what an operator makes of v.
///
/// # Safety
/// The arrays have `count` entries each.
unsafe fn add(
    tangent: *mut dc_operator,
    v: *const f64,
    product: *mut f64,
    count: usize,
    work: impl Fn(&mut TangentOperator, &[f64], &mut [f64]) -> Result<(), AssemblyError> + Sync,
) -> dc_status {
    OPERATORS.call(tangent, |tangent| {
        let (v, product) = unsafe { factors(v, product, count)? };
        Ok(threads::run(|| work(tangent, v, product))?)
    })
}

/// Adds K v to `product`, one entry per equation, in parallel. It differs from the product of the assembled matrix by rounding, and does not
/// depend on the number of threads, bit for bit.
///
/// DC_OVERFLOW if a sum is not finite: the product then holds anything. With any other failure it is as it was.
///
/// # Safety
/// The arrays have `equation_count` entries each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_operator_product(
    tangent: *mut dc_operator,
    v: *const f64,
    product: *mut f64,
    equation_count: usize,
) -> dc_status {
    unsafe { add(tangent, v, product, equation_count, TangentOperator::add_product) }
}

/// Adds K^T v to `product`, as dc_operator_product adds K v: for methods that need both where friction makes K unsymmetric.
///
/// # Safety
/// The arrays have `equation_count` entries each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_operator_transposed_product(
    tangent: *mut dc_operator,
    v: *const f64,
    product: *mut f64,
    equation_count: usize,
) -> dc_status {
    unsafe { add(tangent, v, product, equation_count, TangentOperator::add_transposed_product) }
}

/// Adds the diagonal of K to `diagonal`, one entry per equation; failures as of dc_operator_product.
///
/// # Safety
/// `diagonal` has `equation_count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_operator_diagonal(
    tangent: *mut dc_operator,
    diagonal: *mut f64,
    equation_count: usize,
) -> dc_status {
    OPERATORS.call(tangent, |tangent| {
        let diagonal = unsafe { sums("diagonal", diagonal, equation_count)? };
        Ok(threads::run(|| tangent.add_diagonal(diagonal))?)
    })
}
