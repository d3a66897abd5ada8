//! The pairing of one slave by itself, for user elements whose nodes are fixed by the input.

use std::mem::offset_of;

use runtime::Point;
use runtime::neighbourhood::{NeighbourSearch, NeighbourhoodError};
use runtime::pairing::NearestNodes;

use crate::border::{self, Versioned, disjoint, input, reserve, sized_target, target};
use crate::choice::Named;
use crate::options::dc_options;
use crate::outcome;
use crate::status::{DC_BAD_SIZE, Failure, dc_status};

/// What stays fixed for one slave until it is paired anew.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct dc_pairing {
    /// sizeof(dc_pairing), set by the caller.
    pub size: usize,
    /// Number n of masters.
    pub master_count: i32,
    /// dc_basis.
    pub basis: i32,
    /// dc_fallback.
    pub fallback: i32,
    /// Whether the slave lies within the masters or on their border; 0 beyond it, where the fit extrapolates.
    pub encloses_slave: i32,
    /// Length.
    pub support_radius: f64,
    /// Normal of the masters' average plane, outward: the direction to give next time, when they have turned.
    pub normal: [f64; 3],
}

// SAFETY: numbers, the first one is the size.
unsafe impl Versioned for dc_pairing {
    const NAME: &'static str = "dc_pairing";
    const FIRST: usize = offset_of!(Self, normal) + 24;
}

/// Which of the candidates take part in the fit around a slave: the neighbour search of the options, as an interface does
/// it, but without facets, so without sharp edges, borders and domains of influence: DC_DOMAINS, the default rule, is DC_HULL_LAYERS
/// here, with the same layers as if that had been asked for. `slave` has 3 numbers, `candidates` 3 each, `outward` is a
/// direction to the outward side of the master. `masters` gets the numbers of those chosen, counted from 0, ascending; it has
/// room for `capacity` of them.
///
/// DC_NO_CONTACT if the candidates carry no fit; nothing is written then.
///
/// # Safety
/// The arrays have the given lengths; `options` is NULL or has as many bytes as its field `size` says, as has `pairing`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_pair(
    options: *const dc_options,
    slave: *const f64,
    candidates: *const f64,
    candidate_count: usize,
    outward: *const f64,
    masters: *mut i32,
    capacity: usize,
    pairing: *mut dc_pairing,
) -> dc_status {
    border::call(|| {
        let too_many =
            || Failure::new(DC_BAD_SIZE, format!("bad-size: there cannot be {candidate_count} candidates"));
        let count = candidate_count.checked_mul(3).filter(|_| i32::try_from(candidate_count).is_ok());
        let (options, slave, candidates, outward) = unsafe {
            (
                dc_options::read(options)?,
                input("slave", slave, 3)?,
                input("candidates", candidates, count.ok_or_else(too_many)?)?,
                input("outward", outward, 3)?,
            )
        };
        let pairing = unsafe { sized_target(pairing)? };
        let chosen = border::written("masters", masters, capacity);
        let given = [border::read("slave", slave.as_ptr(), 3), border::read("outward", outward.as_ptr(), 3)];
        disjoint([
            given[0],
            given[1],
            border::read("candidates", candidates.as_ptr(), candidates.len()),
            chosen,
            pairing.span(),
        ])?;
        let mut search = NeighbourSearch::new(options.search_in_nodes()?)?;
        let mut points: Vec<Point> = reserve("candidates", candidate_count)?;
        points.extend_from_slice(candidates.as_chunks::<3>().0);
        let cloud = NearestNodes::new(points).map_err(|error| NeighbourhoodError::of_nodes(&error))?;
        let (slave, outward) = ([slave[0], slave[1], slave[2]], [outward[0], outward[1], outward[2]]);
        let found = search.find(&cloud, slave, outward)?;
        let mut nodes = found.nodes;
        nodes.sort_unstable();
        if nodes.len() > capacity {
            let message = format!("bad-size: masters has room for {capacity} numbers, needs {}", nodes.len());
            return Err(Failure::new(DC_BAD_SIZE, message));
        }
        let result = dc_pairing {
            size: 0,
            master_count: nodes.len() as i32,
            basis: found.basis.number(),
            fallback: outcome::fallback_number(found.fallback),
            encloses_slave: i32::from(found.encloses_slave || found.on_border),
            support_radius: found.support_radius,
            normal: found.frame.normal,
        };
        let masters = target("masters", masters, nodes.len())?;
        unsafe {
            pairing.write(&result);
            masters.write(nodes.into_iter().map(|node| node as i32));
        }
        Ok(())
    })
}
