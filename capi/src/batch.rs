//! Many elements at once, side by side in the machine's vectors.

use std::cell::RefCell;

use runtime::{BatchScratch, GapSlot, Generated, Mode};

use crate::border::{self, disjoint, input, reserve, roomy, target};
use crate::choice;
use crate::element::{dc_element, dc_point, sizes};
use crate::outcome::dc_outcome;
use crate::status::{DC_BAD_SIZE, DC_OUT_OF_RANGE, Failure, dc_status};

thread_local! {
    /// Memory that goes from one batch to the next.
    static SCRATCH: RefCell<BatchScratch> = RefCell::default();
}

/// dc_gap for `element_count` elements that share what `element` says, but for its outward direction: `outwards` has 3 numbers for
/// each, or is NULL for element->outward. `slaves` has 3 numbers for each; the masters of element k are those from `offsets[k]` to
/// `offsets[k + 1]` - 1 of `masters`; `offsets` ascends from 0 and has element_count + 1 entries. `support_radii` has one number for
/// each, or is NULL for element->support_radius.
///
/// One after another without gaps: `points`, one each; `gradients`, 3(n+1) numbers each; `hessians`, 3(n+1)(3n+4)/2 numbers each; their
/// sizes are those of the arrays. What the mode does not ask for may be NULL. Elements without result are told by their outcome, with
/// derivatives of 0; the status is that of the call. Results differ from those of dc_gap by rounding.
///
/// Runs in the calling thread: several may call at once.
///
/// # Safety
/// The arrays have the given lengths, `element` as many bytes as its field `size` says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_gap_batch(
    element: *const dc_element,
    element_count: usize,
    outwards: *const f64,
    support_radii: *const f64,
    slaves: *const f64,
    masters: *const f64,
    offsets: *const usize,
    mode: i32,
    points: *mut dc_point,
    gradients: *mut f64,
    gradient_size: usize,
    hessians: *mut f64,
    hessian_size: usize,
) -> dc_status {
    border::call(|| {
        let mode: Mode = choice::read(mode)?;
        let element = unsafe { dc_element::read(element)? };
        let kind = element.kind()?;
        if element_count == 0 {
            return Ok(());
        }
        let too_many =
            || Failure::new(DC_BAD_SIZE, format!("bad-size: there cannot be {element_count} elements"));
        let coordinates = element_count.checked_mul(3).ok_or_else(too_many)?;
        let ends = element_count.checked_add(1).ok_or_else(too_many)?;
        let optional = |pointer: *const f64, count| if pointer.is_null() { 0 } else { count };
        let (outward_size, radius_count) =
            (optional(outwards, coordinates), optional(support_radii, element_count));
        // SAFETY: as the caller promises; nothing is written before it is known to lie elsewhere.
        let places = unsafe { input("offsets", offsets, ends)? };
        let [freedoms, packed] = total(places, mode)?;
        let nodes = places[element_count].checked_mul(3).ok_or_else(too_many)?;
        let points = target("points", points, element_count)?;
        let gradients = roomy("gradients", gradients, gradient_size, freedoms)?;
        let hessians = roomy("hessians", hessians, hessian_size, packed)?;
        disjoint([
            border::read("offsets", offsets, ends),
            border::read("slaves", slaves, coordinates),
            border::read("masters", masters, nodes),
            border::read("outwards", outwards, outward_size),
            border::read("support_radii", support_radii, radius_count),
            points.span(),
            gradients.span(),
            hessians.span(),
        ])?;
        // SAFETY: as the caller promises; nothing overlaps.
        let (slaves, masters, outwards, radii) = unsafe {
            (
                input("slaves", slaves, coordinates)?.as_chunks::<3>().0,
                input("masters", masters, nodes)?.as_chunks::<3>().0,
                input("outwards", outwards, outward_size)?.as_chunks::<3>().0,
                input("support_radii", support_radii, radius_count)?,
            )
        };
        let mut sound = reserve("elements", element_count)?;
        let mut elements = reserve("elements", element_count)?;
        let mut slots = reserve("elements", element_count)?;
        // SAFETY: as the caller promises; nothing overlaps. From here on nothing is refused.
        let (points, mut gradients, mut hessians) =
            unsafe { (points.zeroed(), gradients.zeroed(), hessians.zeroed()) };
        for k in 0..element_count {
            let own = dc_element {
                outward: outwards.get(k).copied().unwrap_or(element.outward),
                support_radius: radii.get(k).copied().unwrap_or(element.support_radius),
                ..element
            };
            let masters = &masters[places[k]..places[k + 1]];
            // They have been counted by `total`.
            let [freedoms, packed] = sizes(masters.len(), mode).unwrap_or_default();
            let (gradient, rest) = gradients.split_at_mut(freedoms);
            gradients = rest;
            let (hessian, rest) = hessians.split_at_mut(packed);
            hessians = rest;
            match own.with_nodes(&kind, slaves[k], masters) {
                Ok(element) => {
                    sound.push(k);
                    elements.push(element);
                    slots.push((gradient, hessian));
                }
                Err(error) => points[k] = dc_point::new(Err(error)),
            }
        }
        let results = SCRATCH.with_borrow_mut(|scratch| {
            let slots = slots.iter_mut().map(|(gradient, hessian)| GapSlot { gradient, hessian });
            Generated.gap_batch(&elements, mode, slots, scratch)
        });
        for ((place, result), (gradient, hessian)) in sound.into_iter().zip(results).zip(slots) {
            points[place] = dc_point::new(result);
            if points[place].outcome != dc_outcome::DC_CONTACT as i32 {
                gradient.fill(0.0);
                hessian.fill(0.0);
            }
        }
        Ok(())
    })
}

/// Numbers that the derivatives of all elements have. Offsets ascend from 0.
fn total(offsets: &[usize], mode: Mode) -> Result<[usize; 2], Failure> {
    let wrong = |k: usize| {
        let before = if k == 0 { 0 } else { offsets[k - 1] };
        let message =
            format!("offset-out-of-range: offset {k} is {} after {before}; they ascend from 0", offsets[k]);
        Failure::new(DC_OUT_OF_RANGE, message)
    };
    if offsets[0] != 0 {
        return Err(wrong(0));
    }
    let mut sum = [0_usize; 2];
    for k in 1..offsets.len() {
        let length = offsets[k].checked_sub(offsets[k - 1]).ok_or_else(|| wrong(k))?;
        let more = sizes(length, mode);
        let added = more.and_then(|[n, m]| Some([sum[0].checked_add(n)?, sum[1].checked_add(m)?]));
        sum = added.ok_or_else(|| {
            let message = format!("bad-size: element {} cannot have {length} masters", k - 1);
            Failure::new(DC_BAD_SIZE, message)
        })?;
    }
    Ok(sum)
}
