//! Many elements at once, side by side in the machine's vectors.

use std::cell::RefCell;

use runtime::{BatchScratch, GapSlot, Generated, Mode};

use crate::border::{self, input, output};
use crate::choice;
use crate::element::{dc_element, dc_point, sizes};
use crate::outcome::dc_outcome;
use crate::status::{DC_BAD_POINTER, DC_BAD_SIZE, DC_OUT_OF_RANGE, Failure, dc_status};

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
        let mode = choice::mode(mode)?;
        // SAFETY: as the caller promises.
        let element = unsafe { dc_element::read(element)? };
        if element_count == 0 {
            return Ok(());
        }
        let too_many =
            || Failure::new(DC_BAD_SIZE, format!("bad-size: there cannot be {element_count} elements"));
        let coordinates = element_count.checked_mul(3).ok_or_else(too_many)?;
        let optional = |pointer: *const f64, count| if pointer.is_null() { 0 } else { count };
        // SAFETY: as the caller promises.
        let (offsets, slaves, outwards, radii) = unsafe {
            (
                input("offsets", offsets, element_count.checked_add(1).ok_or_else(too_many)?)?,
                input("slaves", slaves, coordinates)?.as_chunks::<3>().0,
                input("outwards", outwards, optional(outwards, coordinates))?.as_chunks::<3>().0,
                input("support_radii", support_radii, optional(support_radii, element_count))?,
            )
        };
        let lengths = lengths(offsets)?;
        let [freedoms, packed] = total(&lengths, mode)?;
        for (name, size, needed) in
            [("gradients", gradient_size, freedoms), ("hessians", hessian_size, packed)]
        {
            if size < needed {
                let message = format!("bad-size: {name} has room for {size} numbers, needs {needed}");
                return Err(Failure::new(DC_BAD_SIZE, message));
            }
        }
        let nodes = offsets[element_count].checked_mul(3).ok_or_else(too_many)?;
        if points.is_null() {
            return Err(Failure::new(DC_BAD_POINTER, "bad-pointer: points is NULL"));
        }
        // SAFETY: as the caller promises.
        let (masters, points, gradients, hessians) = unsafe {
            (
                input("masters", masters, nodes)?.as_chunks::<3>().0,
                output("points", points, element_count)?,
                output("gradients", gradients, freedoms)?,
                output("hessians", hessians, packed)?,
            )
        };
        // Of elements that are refused nothing is written.
        gradients.fill(0.0);
        hessians.fill(0.0);
        let mut places = Vec::with_capacity(element_count);
        let mut elements = Vec::with_capacity(element_count);
        let mut slots = Vec::with_capacity(element_count);
        let (mut gradients, mut hessians) = (gradients, hessians);
        for k in 0..element_count {
            let own = dc_element {
                outward: outwards.get(k).copied().unwrap_or(element.outward),
                support_radius: radii.get(k).copied().unwrap_or(element.support_radius),
                ..element
            };
            let [freedoms, packed] = sizes(lengths[k], mode).ok_or_else(too_many)?;
            let (gradient, rest) = gradients.split_at_mut(freedoms);
            gradients = rest;
            let (hessian, rest) = hessians.split_at_mut(packed);
            hessians = rest;
            match own.with_nodes(slaves[k], &masters[offsets[k]..offsets[k + 1]])? {
                Ok(element) => {
                    places.push(k);
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
        for ((place, result), (gradient, hessian)) in places.into_iter().zip(results).zip(slots) {
            points[place] = dc_point::new(result);
            if points[place].outcome != dc_outcome::DC_CONTACT as i32 {
                gradient.fill(0.0);
                hessian.fill(0.0);
            }
        }
        Ok(())
    })
}

/// Numbers of masters.
fn lengths(offsets: &[usize]) -> Result<Vec<usize>, Failure> {
    let wrong = |k: usize| {
        let message = format!("offset-out-of-range: offset {k} is {}; they ascend from 0", offsets[k]);
        Failure::new(DC_OUT_OF_RANGE, message)
    };
    if offsets[0] != 0 {
        return Err(wrong(0));
    }
    let length = |(k, pair): (usize, &[usize])| pair[1].checked_sub(pair[0]).ok_or_else(|| wrong(k + 1));
    offsets.windows(2).enumerate().map(length).collect()
}

/// Numbers that all elements have.
fn total(lengths: &[usize], mode: Mode) -> Result<[usize; 2], Failure> {
    let sum = |[freedoms, packed]: [usize; 2], &length: &usize| {
        let [more, more_packed] = sizes(length, mode)?;
        Some([freedoms.checked_add(more)?, packed.checked_add(more_packed)?])
    };
    let too_many = || Failure::new(DC_BAD_SIZE, "bad-size: there cannot be so many masters");
    lengths.iter().try_fold([0; 2], sum).ok_or_else(too_many)
}
