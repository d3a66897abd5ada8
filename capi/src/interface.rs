//! An interface: made, moved, paired and evaluated.

use std::mem::offset_of;
use std::sync::Arc;

use runtime::Point;
use runtime::assembly::{DofMap, Triplets};
use runtime::interface::{ContactInterface, Contacts, Cutback, InterfaceError, RefreshReport};
use runtime::surface::MasterSurface;

use crate::border::{self, Versioned, disjoint, input, wanted, wanted_report};
use crate::choice;
use crate::mesh::{
    self, check_nodes, equations_of, facet_rows, facets_of, points, slaves_of, symmetry_planes,
};
use crate::options::dc_options;
use crate::registry::Registry;
use crate::status::{DC_FROZEN, DC_NOT_EVALUATED, DC_OUT_OF_RANGE, Failure, dc_status};
use crate::threads;

/// A contact interface: a master surface, slave nodes and their pairing. One thread at a time may use it, any thread; a
/// second one gets DC_BUSY.
pub struct dc_interface;

/// What stands behind a handle.
#[derive(Debug)]
pub struct State {
    pub interface: ContactInterface,
    /// Shared with the patterns made with them.
    pub dofs: Arc<DofMap>,
    pub cutback: Cutback,
    /// Deepest penetration that is not too deep, in support radii.
    pub cutback_limit: f64,
    pub triplets: Triplets,
    pub(crate) nodes: usize,
    pub(crate) frozen: bool,
    pub(crate) evaluated: bool,
}

static INTERFACES: Registry<State> = Registry::new("interface", 1);

/// Runs a call on an interface.
pub fn with<R>(
    handle: *mut dc_interface,
    work: impl FnOnce(&mut State) -> Result<R, Failure>,
) -> Result<R, Failure> {
    INTERFACES.with(handle.addr(), work)
}

/// A call on an interface.
pub fn call(handle: *mut dc_interface, work: impl FnOnce(&mut State) -> Result<(), Failure>) -> dc_status {
    INTERFACES.call(handle, work)
}

/// The handle of a new interface.
pub fn insert(state: State) -> Result<usize, Failure> {
    INTERFACES.insert(state)
}

impl State {
    /// Of an interface of so many nodes that has not been paired.
    pub fn new(interface: ContactInterface, nodes: usize, cutback_limit: f64) -> Self {
        let (dofs, cutback) = (Arc::new(DofMap::standard(nodes)), Cutback::new(interface.slaves().len()));
        let (triplets, frozen, evaluated) = (Triplets::new(), false, false);
        Self { interface, dofs, cutback, cutback_limit, triplets, nodes, frozen, evaluated }
    }

    /// The results of the moment.
    pub fn contacts(&self) -> Result<&Contacts, Failure> {
        if self.evaluated {
            return Ok(self.interface.contacts());
        }
        let message = "not-evaluated: call dc_evaluate, after each dc_update, dc_follow and dc_refresh";
        Err(Failure::new(DC_NOT_EVALUATED, message))
    }

    /// The place of a slave.
    pub fn slave(&self, slave: usize) -> Result<usize, Failure> {
        let count = self.interface.slaves().len();
        if slave < count {
            return Ok(slave);
        }
        let message = format!("slave-out-of-range: there is no slave {slave}, but {count}, counted from 0");
        Err(Failure::new(DC_OUT_OF_RANGE, message))
    }

    /// An array with an entry for each slave.
    pub fn expect_slaves(&self, found: usize) -> Result<(), Failure> {
        mesh::expect_slaves(self.interface.slaves(), found)
    }
}

/// Makes an interface and writes its handle. Everything is copied.
///
/// `positions`: x, y, z of all `node_count` nodes; indices count from 0. `facets`: the master surface, 4 nodes for each
/// facet, counter-clockwise seen from outside; the fourth is -1 for a triangle. `slaves`: the slave nodes, none of them on
/// the master. `slave_facets`: as `facets`, for `areas` of `options`, and DC_BAD_OPTION where these are 0; NULL and 0 without. `options`: NULL
/// for the defaults, which have no areas.
///
/// There is no pairing yet: call dc_refresh. On failure the handle is NULL.
///
/// # Safety
/// The arrays have the given lengths, `options` as many bytes as its field `size` says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_create(
    positions: *const f64,
    node_count: usize,
    facets: *const i32,
    facet_count: usize,
    slaves: *const i32,
    slave_count: usize,
    slave_facets: *const i32,
    slave_facet_count: usize,
    options: *const dc_options,
    interface: *mut *mut dc_interface,
) -> dc_status {
    border::call(|| {
        let make = || {
            let (positions, master, slaves, areas, options) = unsafe {
                (
                    points(positions, node_count)?,
                    facet_rows("facets", facets, facet_count)?,
                    input("slaves", slaves, slave_count)?,
                    facet_rows("slave_facets", slave_facets, slave_facet_count)?,
                    dc_options::read(options)?,
                )
            };
            let state = threads::run(|| create(positions, master, slaves, areas, &options))?;
            INTERFACES.insert(state)
        };
        unsafe { border::hand_out("interface", interface, make) }
    })
}

fn create(
    positions: &[Point],
    master: &[i32],
    slaves: &[i32],
    slave_facets: &[i32],
    options: &dc_options,
) -> Result<State, Failure> {
    check_nodes(positions.len())?;
    let nodes = slaves_of(slaves)?;
    let slave_facets = facets_of(slave_facets)?;
    let limit = options.cutback_limit()?;
    let options = options.interface_beside(&slave_facets)?;
    let master = MasterSurface::new(positions, facets_of(master)?)?;
    let interface = ContactInterface::new(master, nodes, &slave_facets, positions, options)?;
    Ok(State::new(interface, positions.len(), limit))
}

/// Makes an interface of a surface in contact with itself: each of its nodes is a slave, and `facets` are all that it may touch. The surface
/// may be the skins of several bodies. Slaves are in ascending order. Both sides push: give the
/// law half of the penalty between two surfaces, of the tangential stiffness, of the shear limit and of normal pressures, and coefficients
/// at half of the pressure.
/// With `areas` of `options` they are those of `facets`; there are none by default, other than in Python. All else is as with dc_create;
/// dc_window_create is DC_BAD_OPTION.
///
/// # Safety
/// As dc_create.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_create_self_contact(
    positions: *const f64,
    node_count: usize,
    facets: *const i32,
    facet_count: usize,
    options: *const dc_options,
    interface: *mut *mut dc_interface,
) -> dc_status {
    border::call(|| {
        let make = || {
            let (positions, facets, options) = unsafe {
                (
                    points(positions, node_count)?,
                    facet_rows("facets", facets, facet_count)?,
                    dc_options::read(options)?,
                )
            };
            let state = threads::run(|| create_self_contact(positions, facets, &options))?;
            INTERFACES.insert(state)
        };
        unsafe { border::hand_out("interface", interface, make) }
    })
}

fn create_self_contact(positions: &[Point], facets: &[i32], options: &dc_options) -> Result<State, Failure> {
    check_nodes(positions.len())?;
    let own = options.interface()?;
    let surface = MasterSurface::new(positions, facets_of(facets)?)?;
    let interface = ContactInterface::self_contact(surface, positions, own)?;
    Ok(State::new(interface, positions.len(), options.cutback_limit()?))
}

/// Destroys an interface. NULL is DC_OK, a handle that was destroyed before is DC_BAD_HANDLE.
#[unsafe(no_mangle)]
pub extern "C" fn dc_destroy(interface: *mut dc_interface) -> dc_status {
    INTERFACES.destroy(interface)
}

/// Numbers of nodes and of slaves. Either may be NULL.
///
/// # Safety
/// Each is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_counts(
    interface: *mut dc_interface,
    node_count: *mut usize,
    slave_count: *mut usize,
) -> dc_status {
    call(interface, |state| unsafe {
        mesh::write_counts(state.nodes, state.interface.slaves(), node_count, slave_count)
    })
}

/// The slave nodes, in the order of results and multipliers: that of dc_create, ascending for a surface in contact with itself.
///
/// # Safety
/// `slaves` has `slave_count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_slaves(
    interface: *mut dc_interface,
    slaves: *mut i32,
    slave_count: usize,
) -> dc_status {
    call(interface, |state| unsafe { mesh::write_slaves(state.interface.slaves(), slaves, slave_count) })
}

/// Makes these planes of symmetry, `plane_count` of them with 6 numbers each: x, y, z of a point of the plane, then of its unit normal
/// to the side of the model. The master surface goes on beyond them as its mirror image, so that masters near a plane have
/// neighbours on both sides, and where it ends in a plane is no border. Default: none; NULL and 0 take all away.
///
/// Call it before the first dc_refresh: no slave is paired afterwards. The history of friction ends, unless the planes are the same: call
/// dc_set_history after it. Planes lie still. They need DC_DOMAINS or DC_NODE_TO_FACET, else
/// DC_BAD_OPTION. DC_BAD_SURFACE for a normal that is no unit vector, and for planes that are neither
/// parallel nor at 180 degrees over a whole number.
///
/// # Safety
/// `planes` has 6 `plane_count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_set_symmetry(
    interface: *mut dc_interface,
    planes: *const f64,
    plane_count: usize,
) -> dc_status {
    call(interface, |state| {
        let planes = unsafe { symmetry_planes(planes, plane_count)? };
        let interface = &mut state.interface;
        threads::run(|| interface.set_symmetry(&planes))?;
        state.evaluated = false;
        Ok(())
    })
}

/// Takes over the positions of the next evaluation, x, y, z of all nodes. The pairing stays. Call dc_follow in every iteration: with
/// DC_DOMAINS a slave that slides by more than half the skin of its list, see dc_refresh, may lack nodes after a mere dc_update.
///
/// # Safety
/// `positions` has 3 `node_count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_update(
    interface: *mut dc_interface,
    positions: *const f64,
    node_count: usize,
) -> dc_status {
    call(interface, |state| {
        state.interface.update(unsafe { points(positions, node_count)? })?;
        state.evaluated = false;
        Ok(())
    })
}

/// What a refresh did, in numbers of slaves. paired = kept + renewed + changed + gained; with `without` it makes up all slaves.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct dc_report {
    /// sizeof(dc_report), set by the caller.
    pub size: usize,
    /// With a pairing now.
    pub paired: i32,
    /// Of these: with DC_DOMAINS, those whose list stays.
    pub kept: i32,
    /// Of these: paired anew with the same masters.
    pub renewed: i32,
    /// Of these: paired with other masters than before. The pattern of the tangent may be another one.
    pub changed: i32,
    /// Of these: without a pairing before.
    pub gained: i32,
    /// Without a pairing now, but with one before.
    pub lost: i32,
    /// Without a pairing now.
    pub without: i32,
    /// Pairings with more nodes than asked for.
    pub extended: i32,
    /// Pairings with the linear basis instead of the quadratic one.
    pub linear: i32,
    /// With a gap by the old pairing at these positions, but none by the new. Those that dc_follow lost in this way since the refresh before
    /// count too, unless they have a gap again.
    pub contacts_lost: i32,
    /// With a gap now, but none by the old pairing.
    pub contacts_gained: i32,
    /// The node whose gap the refresh changed most; -1 if none.
    pub jump_node: i32,
    /// Of the contacts lost, the node with the smallest gap; -1 if none.
    pub lost_node: i32,
    /// Of the contacts gained, the node with the smallest gap; -1 if none.
    pub gained_node: i32,
    /// The gap of jump_node by the old pairing and by the new one.
    pub jump_before: f64,
    pub jump_after: f64,
    /// The gap of lost_node by the old pairing, when it was lost.
    pub lost_gap: f64,
    /// The gap of gained_node by the new pairing.
    pub gained_gap: f64,
    /// Whether the pairings were made anew: 0 or 1. Patterns of before are still theirs where changed, gained and lost are 0. With DC_DOMAINS 0 while nothing has
    /// moved by more than half the skin of the lists, with other rules always 1; 0 of a frozen interface.
    pub rebuilt: i32,
    /// Of those paired: deeper below the closest facet than a tenth of its size, the root of its area, when they were paired. If most are,
    /// the master may be inside out.
    pub deep: i32,
}

// SAFETY: numbers, the first one is the size.
unsafe impl Versioned for dc_report {
    const NAME: &'static str = "dc_report";
    const FIRST: usize = offset_of!(Self, gained_gap) + 8;
}

impl dc_report {
    fn new(report: &RefreshReport) -> Self {
        let count = |x: usize| i32::try_from(x).unwrap_or(i32::MAX);
        let node = |slave: Option<usize>| slave.map_or(-1, |node| node as i32);
        let RefreshReport { largest_gap_jump: jump, smallest_gap_lost: lost, .. } = report;
        let gained = &report.smallest_gap_gained;
        Self {
            size: size_of::<Self>(),
            paired: count(report.paired),
            kept: count(report.kept),
            renewed: count(report.renewed),
            changed: count(report.changed),
            gained: count(report.gained),
            lost: count(report.lost),
            without: count(report.without.values().sum()),
            extended: count(report.fallbacks.extended),
            linear: count(report.fallbacks.linear),
            contacts_lost: count(report.contacts_lost),
            contacts_gained: count(report.contacts_gained),
            jump_node: node(jump.map(|jump| jump.slave)),
            lost_node: node(lost.map(|lost| lost.slave)),
            gained_node: node(gained.map(|gained| gained.slave)),
            jump_before: jump.map_or(0.0, |jump| jump.before),
            jump_after: jump.map_or(0.0, |jump| jump.after),
            lost_gap: lost.map_or(0.0, |lost| lost.gap),
            gained_gap: gained.map_or(0.0, |gained| gained.gap),
            rebuilt: i32::from(report.rebuilt),
            deep: count(report.deep),
        }
    }
}

/// As dc_update, but with DC_DOMAINS the lists of nodes follow: where something has moved too far for them, see dc_refresh, they are made
/// anew. A slave stays with its side of the surface. `rebuilt`, which may be NULL, gets whether they are others now, 0 or 1: patterns of
/// before are no longer theirs then. Contacts that are lost with the old lists are in the report of the next dc_refresh, contacts_lost and
/// lost_gap.
///
/// DC_FROZEN while the interface is frozen: it did what dc_update does.
///
/// # Safety
/// `positions` has 3 `node_count` entries; `rebuilt` is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_follow(
    interface: *mut dc_interface,
    positions: *const f64,
    node_count: usize,
    rebuilt: *mut i32,
) -> dc_status {
    call(interface, |state| {
        let positions = unsafe { points(positions, node_count)? };
        let rebuilt = wanted("rebuilt", rebuilt, 1, 1)?;
        disjoint([border::read("positions", positions.as_ptr(), positions.len()), rebuilt.span()])?;
        let interface = &mut state.interface;
        let was_rebuilt = if state.frozen {
            interface.update(positions)?;
            false
        } else {
            threads::run(|| interface.follow(positions))?
        };
        state.evaluated = false;
        unsafe { rebuilt.write([i32::from(was_rebuilt)]) };
        if state.frozen { Err(frozen()) } else { Ok(()) }
    })
}

fn frozen() -> Failure {
    Failure::new(DC_FROZEN, "frozen: the positions were taken over, the pairing is held until dc_thaw")
}

/// Takes over the positions and pairs every slave. Call it once an increment. `report` may be NULL; its field `size` has to be set.
///
/// With DC_DOMAINS the list of a slave stays while slave and masters together have moved by less than half its skin, 0.06 of the
/// shortest half axis of its domains, and not so far that another sheet may be the closest one. Another list changes no gap, unless the
/// slave comes to where the old one does not reach, such as another sheet: jump_node, lost_node and gained_node tell of that. Domains lie
/// in the configuration of dc_create and are never renewed: they turn and stretch with the master. The first refresh of an increment is
/// followed by dc_follow in its iterations.
///
/// DC_FROZEN while the interface is frozen: it did what dc_update does, and the report is empty.
///
/// # Safety
/// `positions` has 3 `node_count` entries; `report` is NULL or has as many bytes as its field `size` says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_refresh(
    interface: *mut dc_interface,
    positions: *const f64,
    node_count: usize,
    report: *mut dc_report,
) -> dc_status {
    call(interface, |state| unsafe {
        refresh(state, (positions, node_count), report, ContactInterface::refresh_pairing)
    })
}

/// As dc_refresh, but all lists of DC_DOMAINS are made anew, so that they follow from the positions alone: after a restart patterns, and with
/// them the bits of a direct solver, are those of a run that makes them anew there, too.
///
/// # Safety
/// As dc_refresh.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_renew(
    interface: *mut dc_interface,
    positions: *const f64,
    node_count: usize,
    report: *mut dc_report,
) -> dc_status {
    call(interface, |state| unsafe {
        refresh(state, (positions, node_count), report, ContactInterface::renew_pairing)
    })
}

/// # Safety
/// As [`dc_refresh`].
unsafe fn refresh(
    state: &mut State,
    (positions, node_count): (*const f64, usize),
    report: *mut dc_report,
    pair: fn(&mut ContactInterface, &[Point]) -> Result<RefreshReport, InterfaceError>,
) -> Result<(), Failure> {
    let positions = unsafe { points(positions, node_count)? };
    let report = unsafe { wanted_report(report, positions)? };
    let State { interface, cutback, .. } = state;
    let result = if state.frozen {
        interface.update(positions)?;
        RefreshReport::default()
    } else {
        threads::run(|| pair(interface, positions))?
    };
    state.evaluated = false;
    if let Some(report) = report {
        unsafe { report.write(&dc_report::new(&result)) };
    }
    if state.frozen {
        return Err(frozen());
    }
    Ok(threads::run(|| cutback.begin(interface))?)
}

/// Holds the pairing, for instance over the iterations of an increment: dc_refresh and dc_follow do what dc_update does, and return
/// DC_FROZEN.
#[unsafe(no_mangle)]
pub extern "C" fn dc_freeze(interface: *mut dc_interface) -> dc_status {
    set_frozen(interface, true)
}

/// Ends what dc_freeze began.
#[unsafe(no_mangle)]
pub extern "C" fn dc_thaw(interface: *mut dc_interface) -> dc_status {
    set_frozen(interface, false)
}

fn set_frozen(interface: *mut dc_interface, frozen: bool) -> dc_status {
    call(interface, |state| {
        state.frozen = frozen;
        Ok(())
    })
}

/// Evaluates all slaves at the positions of the last dc_update, dc_follow or dc_refresh, in parallel. `mode` is a dc_mode: DC_GRADIENT
/// for forces and tangent, DC_HESSIAN to keep every M, which dc_derivatives and the exact dc_triplets need. The result does not depend on
/// the number of threads, bit for bit.
///
/// DC_NOT_EVALUATED before the first dc_refresh. DC_TOO_LARGE if there is no memory for the results: there are none then, and the pairing stays.
#[unsafe(no_mangle)]
pub extern "C" fn dc_evaluate(interface: *mut dc_interface, mode: i32) -> dc_status {
    call(interface, |state| {
        let mode = choice::read(mode)?;
        // Until it is done there is nothing.
        state.evaluated = false;
        let State { interface, cutback, .. } = state;
        threads::run(|| interface.evaluate(mode).map(drop))?;
        cutback.book(interface.contacts());
        state.evaluated = true;
        Ok(())
    })
}

/// Which equations the displacements of the nodes have: 3 entries for each node, numbers below `equation_count`, none twice, -1
/// for a displacement that is prescribed. NULL with both counts 0 for 3 node + axis, as it is at the beginning; NULL with any other count
/// is an array that is missing, DC_BAD_POINTER. Patterns made before belong to the equations of before.
///
/// # Safety
/// `equations` is NULL or has 3 `node_count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_set_equations(
    interface: *mut dc_interface,
    equations: *const i32,
    node_count: usize,
    equation_count: usize,
) -> dc_status {
    call(interface, |state| {
        let dofs = unsafe { equations_of(equations, (node_count, equation_count), state.nodes)? };
        state.dofs = Arc::new(dofs);
        Ok(())
    })
}
