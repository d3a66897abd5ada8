//! Contact integrated over the slave's faces: an object of its own.

use std::mem::offset_of;

use runtime::assembly::DofMap;
use runtime::faces::{
    FaceContacts, FaceInterface, FaceOptions, FaceReport, FaceRule, NodeContact, QuadraticFace,
};
use runtime::interface::InterfaceError;
use runtime::surface::{Facet, MasterSurface};

use crate::border::{self, Plain, Versioned, disjoint, input, reserve, roomy, wanted, wanted_report};
use crate::choice;
use crate::law::{self, dc_law};
use crate::mesh::{self, check_nodes, equations_of, facet_rows, facets_of, points, symmetry_planes};
use crate::options::dc_options;
use crate::outcome;
use crate::registry::Registry;
use crate::status::{DC_BAD_OPTION, DC_BAD_SIZE, DC_NOT_EVALUATED, DC_OUT_OF_RANGE, Failure, dc_status};
use crate::threads;

/// Contact over the faces of a slave: a master surface, slave faces, and the points that they are cut into. One thread at a time may use
/// it, any thread; a second one gets DC_BUSY.
pub struct dc_faces;

/// What stands behind a handle.
#[derive(Debug)]
pub struct State {
    pub interface: FaceInterface,
    pub dofs: DofMap,
    nodes: usize,
    /// Faces of second order so far, of all calls.
    pub quadratic: Vec<QuadraticFace>,
    /// Of windows: of the master and of the slave, by the numbers of their nodes.
    pub by_number: [Vec<QuadraticFace>; 2],
    pub evaluated: bool,
}

static FACES: Registry<State> = Registry::new("faces", 3);

/// A call on contact over faces.
pub fn call(handle: *mut dc_faces, work: impl FnOnce(&mut State) -> Result<(), Failure>) -> dc_status {
    FACES.call(handle, work)
}

impl State {
    /// Adds faces of second order by their nodes.
    pub fn add_quadratic(&mut self, more: Vec<QuadraticFace>) -> Result<(), Failure> {
        let all = joined(&self.quadratic, more)?;
        self.interface.set_quadratic_faces(&all)?;
        self.quadratic = all;
        self.evaluated = false;
        Ok(())
    }

    /// The results of the moment.
    pub fn contacts(&self) -> Result<&FaceContacts, Failure> {
        if self.evaluated {
            return Ok(self.interface.contacts());
        }
        let message =
            "not-evaluated: call dc_faces_evaluate, after each dc_faces_update and dc_faces_refresh";
        Err(Failure::new(DC_NOT_EVALUATED, message))
    }

    /// An array with an entry for each slave node.
    pub fn expect_slaves(&self, found: usize) -> Result<(), Failure> {
        mesh::expect_slaves(self.interface.slaves(), found)
    }
}

/// With the rule of this degree.
pub fn face_options(options: &dc_options, degree: i32) -> Result<FaceOptions, Failure> {
    let wanted = usize::try_from(degree).unwrap_or(0);
    let rule = FaceRule::ALL.into_iter().find(|rule| rule.degree() == wanted).ok_or_else(|| {
        Failure::new(DC_BAD_OPTION, format!("invalid-option: degree has to be 2 or 4, not {degree}"))
    })?;
    Ok(FaceOptions::new(options.interface()?).with_rule(rule))
}

/// The handle of a new object over so many nodes.
pub fn insert(interface: FaceInterface, nodes: usize) -> Result<usize, Failure> {
    let dofs = DofMap::standard(nodes);
    let (quadratic, by_number) = Default::default();
    FACES.insert(State { interface, dofs, nodes, quadratic, by_number, evaluated: false })
}

/// Makes an object for contact over faces and writes its handle. Everything is copied.
///
/// `positions`: x, y, z of all `node_count` nodes in the first configuration; indices count from 0. `facets`: the master surface,
/// `slave_facets`: the faces of the slave, none of their nodes on the master; of both 4 nodes for each facet, counter-clockwise
/// seen from outside, the fourth -1 for a triangle. NULL and 0 where there are no slave facets, as on a rank of MPI. `options`: NULL for the
/// defaults; `rule` has to be DC_DOMAINS unless `element` is DC_NODE_TO_FACET, `areas` and `cutback_penetration` have no meaning. `degree`: 2 or 4, of the polynomials that are
/// integrated exactly on each piece of a face.
///
/// On failure the handle is NULL.
///
/// # Safety
/// The arrays have the given lengths, `options` as many bytes as its field `size` says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_create(
    positions: *const f64,
    node_count: usize,
    facets: *const i32,
    facet_count: usize,
    slave_facets: *const i32,
    slave_facet_count: usize,
    options: *const dc_options,
    degree: i32,
    faces: *mut *mut dc_faces,
) -> dc_status {
    border::call(|| {
        let make = || {
            let (positions, master, slave, options) = unsafe {
                (
                    points(positions, node_count)?,
                    facet_rows("facets", facets, facet_count)?,
                    facet_rows("slave_facets", slave_facets, slave_facet_count)?,
                    dc_options::read(options)?,
                )
            };
            check_nodes(positions.len())?;
            let options = face_options(&options, degree)?;
            let (master, slave) = (facets_of(master)?, facets_of(slave)?);
            let interface = threads::run(|| -> Result<FaceInterface, Failure> {
                let master = MasterSurface::new(positions, master)?;
                Ok(FaceInterface::new(master, &slave, positions, options)?)
            })?;
            insert(interface, positions.len())
        };
        unsafe { border::hand_out("faces", faces, make) }
    })
}

/// Makes an object for contact over faces of a surface with itself: each of its facets is a face of the slave, and `facets` are all that it
/// may touch. The surface may be the skins of several bodies, and its nodes are the slaves. Give the law half of everything
/// between two surfaces, as with dc_create_self_contact. All else is as with dc_faces_create.
///
/// # Safety
/// As dc_faces_create.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_create_self_contact(
    positions: *const f64,
    node_count: usize,
    facets: *const i32,
    facet_count: usize,
    options: *const dc_options,
    degree: i32,
    faces: *mut *mut dc_faces,
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
            check_nodes(positions.len())?;
            let (options, facets) = (face_options(&options, degree)?, facets_of(facets)?);
            let interface = threads::run(|| -> Result<FaceInterface, Failure> {
                let surface = MasterSurface::new(positions, facets)?;
                Ok(FaceInterface::self_contact(surface, positions, options)?)
            })?;
            insert(interface, positions.len())
        };
        unsafe { border::hand_out("faces", faces, make) }
    })
}

/// Destroys it. NULL is DC_OK, a handle that was destroyed before is DC_BAD_HANDLE.
#[unsafe(no_mangle)]
pub extern "C" fn dc_faces_destroy(faces: *mut dc_faces) -> dc_status {
    FACES.destroy(faces)
}

/// Numbers of nodes and of slave nodes, those of the slave facets. Either may be NULL.
///
/// # Safety
/// Each is NULL or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_counts(
    faces: *mut dc_faces,
    node_count: *mut usize,
    slave_count: *mut usize,
) -> dc_status {
    call(faces, |state| unsafe {
        mesh::write_counts(state.nodes, state.interface.slaves(), node_count, slave_count)
    })
}

/// The slave nodes, ascending: the order of results and multipliers. A node on an edge of the slave sharper than the feature angle is
/// there once for each sheet that meets there.
///
/// # Safety
/// `slaves` has `slave_count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_slaves(
    faces: *mut dc_faces,
    slaves: *mut i32,
    slave_count: usize,
) -> dc_status {
    call(faces, |state| unsafe { mesh::write_slaves(state.interface.slaves(), slaves, slave_count) })
}

/// As dc_set_symmetry, for both surfaces, in the first configuration. The history of friction ends, unless the planes are the same: call
/// dc_faces_set_history after it. There is no contact until the next dc_faces_refresh.
///
/// # Safety
/// `planes` has 6 `plane_count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_set_symmetry(
    faces: *mut dc_faces,
    planes: *const f64,
    plane_count: usize,
) -> dc_status {
    call(faces, |state| {
        let planes = unsafe { symmetry_planes(planes, plane_count)? };
        let interface = &mut state.interface;
        threads::run(|| interface.set_symmetry(&planes))?;
        state.evaluated = false;
        Ok(())
    })
}

/// Where the pressure follows from the gap: `pressures` is a dc_face_pressures, DC_NODE_PRESSURES before the first call. Take
/// DC_POINT_PRESSURES where faces are coarse beside the master's curvature: an average gap closes late there. Multipliers are
/// interpolated between the nodes then. The next dc_faces_evaluate sees it.
#[unsafe(no_mangle)]
pub extern "C" fn dc_faces_set_pressures(faces: *mut dc_faces, pressures: i32) -> dc_status {
    call(faces, |state| {
        state.interface.set_pressures(choice::read(pressures)?);
        state.evaluated = false;
        Ok(())
    })
}

/// Some faces, and more of them.
pub fn joined(some: &[QuadraticFace], more: Vec<QuadraticFace>) -> Result<Vec<QuadraticFace>, Failure> {
    let mut all = reserve("faces", some.len() + more.len())?;
    all.extend_from_slice(some);
    all.extend(more);
    Ok(all)
}

/// Faces of 6, 8 or 9 nodes.
///
/// # Safety
/// As [`input`].
pub unsafe fn quadratic_faces<T: Plain + std::fmt::Display + TryInto<usize>>(
    rows: *const T,
    face_count: usize,
    nodes_per_face: usize,
) -> Result<Vec<QuadraticFace>, Failure> {
    if !matches!(nodes_per_face, 6 | 8 | 9) {
        let message = format!("bad-size: faces of second order have 6, 8 or 9 nodes, not {nodes_per_face}");
        return Err(Failure::new(DC_BAD_SIZE, message));
    }
    let too_many = || Failure::new(DC_BAD_SIZE, format!("bad-size: there cannot be {face_count} faces"));
    let count = face_count.checked_mul(nodes_per_face).ok_or_else(too_many)?;
    let numbers = unsafe { input("faces", rows, count)? };
    let mut made = reserve("faces", face_count)?;
    for (k, row) in numbers.chunks(nodes_per_face).enumerate() {
        let mut nodes = [0; 9];
        for (node, &number) in nodes.iter_mut().zip(row) {
            *node = number.try_into().map_err(|_| {
                Failure::new(DC_OUT_OF_RANGE, format!("node-out-of-range: face {k} has node {number}"))
            })?;
        }
        made.extend(QuadraticFace::new(&nodes[..nodes_per_face]));
    }
    Ok(made)
}

/// The flat facets between all nodes of faces of second order, as dc_faces_create takes them: 4 for each face with 6 nodes, 5 for one
/// with 8, 4 for one with 9. `quadratic`: `nodes_per_face` nodes for each face, corners counter-clockwise seen from outside, then the middles
/// of the edges from the first corner on, then the centre. `facets` has room for `facet_capacity` facets of 4 nodes.
///
/// # Safety
/// The arrays have the given lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_flat_facets(
    quadratic: *const i32,
    face_count: usize,
    nodes_per_face: usize,
    facets: *mut i32,
    facet_capacity: usize,
) -> dc_status {
    border::call(|| {
        let faces = unsafe { quadratic_faces(quadratic, face_count, nodes_per_face)? };
        let row = |facet: Facet| match facet {
            Facet::Triangle([a, b, c]) => [a as i32, b as i32, c as i32, -1],
            Facet::Quadrilateral(corners) => corners.map(|node| node as i32),
        };
        let rows: Vec<i32> = faces.iter().flat_map(QuadraticFace::facets).flat_map(row).collect();
        let room = facet_capacity.saturating_mul(4);
        disjoint([
            border::read("quadratic", quadratic, face_count * nodes_per_face),
            border::written("facets", facets, room),
        ])?;
        let facets = roomy("facets", facets, room, rows.len())?;
        unsafe { facets.write(rows) };
        Ok(())
    })
}

/// Makes faces of second order carry the forces on the facets that they are made of, on both sides: by all of their shape functions, so
/// that a uniform pressure is in equilibrium with a uniform stress inside. `quadratic` as in dc_flat_facets. A call for each
/// number of nodes adds to those before. The history of friction ends, and there is no contact until the next dc_faces_refresh.
///
/// # Safety
/// `quadratic` has `face_count` times `nodes_per_face` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_add_quadratic(
    faces: *mut dc_faces,
    quadratic: *const i32,
    face_count: usize,
    nodes_per_face: usize,
) -> dc_status {
    call(faces, |state| {
        let more = unsafe { quadratic_faces(quadratic, face_count, nodes_per_face)? };
        state.add_quadratic(more)
    })
}

/// As dc_set_equations.
///
/// # Safety
/// `equations` is NULL or has 3 `node_count` entries.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_set_equations(
    faces: *mut dc_faces,
    equations: *const i32,
    node_count: usize,
    equation_count: usize,
) -> dc_status {
    call(faces, |state| {
        state.dofs = unsafe { equations_of(equations, (node_count, equation_count), state.nodes)? };
        Ok(())
    })
}

/// What the cutting of the faces gave.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct dc_faces_report {
    /// sizeof(dc_faces_report), set by the caller.
    pub size: usize,
    /// Integration points.
    pub points: i32,
    /// Of these: paired with masters.
    pub paired: i32,
    /// Faces with points.
    pub faces: i32,
    /// Middles of edges and faces where the slave's own nodes carry no smooth surface: its faces are flat there.
    pub straight: i32,
    /// Whether nodes couple that did not since the last dc_faces_refresh, so that a sparsity pattern of before is too small: 0 or 1.
    pub grown: i32,
    /// 0.
    pub reserved: i32,
}

// SAFETY: numbers, the first one is the size.
unsafe impl Versioned for dc_faces_report {
    const NAME: &'static str = "dc_faces_report";
    const FIRST: usize = offset_of!(Self, reserved) + 4;
}

/// Takes over the positions and cuts the faces anew. Call it once an increment. `report` may be NULL; its field `size` has to be set.
///
/// # Safety
/// `positions` has 3 `node_count` entries; `report` is NULL or has as many bytes as its field `size` says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_refresh(
    faces: *mut dc_faces,
    positions: *const f64,
    node_count: usize,
    report: *mut dc_faces_report,
) -> dc_status {
    unsafe { take(faces, positions, node_count, report, true) }
}

/// As dc_faces_refresh, in every iteration: near equilibrium faces stay cut as they are, and the pattern does not shrink.
///
/// # Safety
/// As dc_faces_refresh.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_update(
    faces: *mut dc_faces,
    positions: *const f64,
    node_count: usize,
    report: *mut dc_faces_report,
) -> dc_status {
    unsafe { take(faces, positions, node_count, report, false) }
}

/// # Safety
/// As [`dc_faces_refresh`].
unsafe fn take(
    faces: *mut dc_faces,
    positions: *const f64,
    node_count: usize,
    report: *mut dc_faces_report,
    is_refresh: bool,
) -> dc_status {
    call(faces, |state| {
        let positions = unsafe { points(positions, node_count)? };
        let report = unsafe { wanted_report(report, positions)? };
        let interface = &mut state.interface;
        let FaceReport { points, paired, faces, grown } = threads::run(|| {
            if is_refresh { interface.refresh(positions) } else { interface.update(positions) }
        })?;
        state.evaluated = false;
        let count = |x: usize| i32::try_from(x).unwrap_or(i32::MAX);
        if let Some(report) = report {
            unsafe {
                report.write(&dc_faces_report {
                    size: size_of::<dc_faces_report>(),
                    points: count(points),
                    paired: count(paired),
                    faces: count(faces),
                    straight: count(state.interface.straight()),
                    grown: i32::from(grown),
                    reserved: 0,
                });
            }
        }
        Ok(())
    })
}

/// Gaps, pressures and forces at the positions of the last dc_faces_update or dc_faces_refresh, in parallel. The penalty of `law` is per
/// area, its multipliers are pressures, one for each slave node; its tangent is not looked at. `mode` is a dc_mode: DC_GRADIENT for forces
/// and e F G^T, DC_HESSIAN for the exact tangent. DC_NOT_EVALUATED before the first dc_faces_refresh or dc_faces_update, and for a law
/// with friction where nodes carry pressure before dc_faces_accept. The result does not depend on the number of threads, bit for bit.
/// DC_TOO_LARGE if there is no memory for the results: there are none then. After any other refusal those of before stay.
///
/// # Safety
/// `law` is a dc_law with its `size` set, its multipliers have their number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_evaluate(faces: *mut dc_faces, law: *const dc_law, mode: i32) -> dc_status {
    call(faces, |state| {
        let mode = choice::read(mode)?;
        let law = unsafe { law::read(law)? };
        let law = law.contact()?;
        let interface = &mut state.interface;
        let evaluated = threads::run(|| interface.evaluate(&law, mode).map(drop));
        // Without memory there are no contacts; any other refusal leaves those of before.
        state.evaluated = match &evaluated {
            Ok(()) => true,
            Err(error) => state.evaluated && !matches!(error, InterfaceError::OutOfMemory { .. }),
        };
        Ok(evaluated?)
    })
}

/// Contact of all slave nodes, one entry each: `outcomes` dc_outcome; `gaps` the average gap, length; `pressures` max(0, lambda - e g),
/// force per area, which are the multipliers of the next round of the augmented Lagrangian; `areas` over the master in the first
/// configuration, length^2; `normals` the mean unit normal of the master, 3 numbers each. Where nothing lies over a node gap and normal
/// are 0. Each may be NULL.
///
/// # Safety
/// The arrays have `slave_count` entries, `normals` three times as many.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dc_faces_contacts(
    faces: *mut dc_faces,
    outcomes: *mut i32,
    gaps: *mut f64,
    pressures: *mut f64,
    areas: *mut f64,
    normals: *mut f64,
    slave_count: usize,
) -> dc_status {
    call(faces, |state| {
        state.expect_slaves(slave_count)?;
        let nodes = state.contacts()?.nodes();
        let outcomes = wanted("outcomes", outcomes, slave_count, slave_count)?;
        let gaps = wanted("gaps", gaps, slave_count, slave_count)?;
        let pressures = wanted("pressures", pressures, slave_count, slave_count)?;
        let areas = wanted("areas", areas, slave_count, slave_count)?;
        let three = slave_count.saturating_mul(3);
        let normals = wanted("normals", normals, three, three)?;
        disjoint([outcomes.span(), gaps.span(), pressures.span(), areas.span(), normals.span()])?;
        let gap = |node: &NodeContact| if node.outcome.is_contact() { node.gap } else { 0.0 };
        unsafe {
            outcomes.write(nodes.iter().map(|node| outcome::of(&node.outcome) as i32));
            gaps.write(nodes.iter().map(gap));
            pressures.write(nodes.iter().map(|node| node.pressure));
            areas.write(nodes.iter().map(|node| node.area));
            normals.write(nodes.iter().flat_map(|node| node.normal));
        }
        Ok(())
    })
}
