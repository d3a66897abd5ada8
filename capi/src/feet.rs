//! What a law of the host's needs at the feet.

use runtime::interface::FootRef;

use crate::border::{disjoint, wanted};
use crate::interface::{call, dc_interface};
use crate::outcome;
use crate::status::dc_status;
use crate::threads;

/// The feet x^d of all slaves and their derivatives, one slave after another, at the positions of the last dc_update, dc_follow or
/// dc_refresh, for laws of the host's own. No evaluation of these positions is needed. With n the master_count of dc_contact_of, and the
/// nodes of dc_derivatives, both of any dc_evaluate since the lists of nodes were made:
///
/// - `weights` phi, n numbers for each slave, their sum is 1: a field over the nodes is sum phi_k u_k at the foot, x^d = sum phi_k x_k.
///   Behind planes of symmetry the images of a node add to its number, and their positions to the foot;
/// - `foot` dx^d/dx, 3 rows of 3(n+1) numbers for each slave, ordered as the gradient of dc_derivatives, dimensionless;
/// - `normal` dnu/dx, the same, 1/length.
///
/// Without contact numbers are 0, and `outcomes`, a dc_outcome for each slave, says why; without a pairing n is 0. What is not
/// wanted is NULL. The sizes are those of the arrays. DC_BAD_SIZE names the number that is needed.
///
/// # Safety
/// The arrays have the given lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_feet(
    interface: *mut dc_interface,
    outcomes: *mut i32,
    slave_count: usize,
    weights: *mut f64,
    weight_size: usize,
    foot: *mut f64,
    foot_size: usize,
    normal: *mut f64,
    normal_size: usize,
) -> dc_status {
    call(interface, |state| {
        state.expect_slaves(slave_count)?;
        let outcomes = wanted("outcomes", outcomes, slave_count, slave_count)?;
        let feet = threads::run(|| state.interface.foot_derivatives())?;
        let masters: usize = feet.iter().map(|foot| foot.nodes.len()).sum();
        let rows = 9 * (masters + feet.len());
        let weights = wanted("weights", weights, weight_size, masters)?;
        let foot = wanted("foot", foot, foot_size, rows)?;
        let normal = wanted("normal", normal, normal_size, rows)?;
        disjoint([outcomes.span(), weights.span(), foot.span(), normal.span()])?;
        unsafe {
            outcomes.write(feet.iter().map(|foot| outcome::of(&foot.outcome) as i32));
            weights.write(feet.iter().flat_map(|foot| padded(foot.weights, foot.nodes.len())));
            foot.write(feet.iter().flat_map(|foot| padded(foot.foot, rows_of(&foot))));
            normal.write(feet.iter().flat_map(|foot| padded(foot.normal, rows_of(&foot))));
        }
        Ok(())
    })
}

const fn rows_of(foot: &FootRef<'_>) -> usize {
    9 * (foot.nodes.len() + 1)
}

/// The numbers, or as many zeros.
fn padded(numbers: &[f64], count: usize) -> impl Iterator<Item = f64> + '_ {
    numbers.iter().copied().chain(std::iter::repeat_n(0.0, count - numbers.len()))
}
