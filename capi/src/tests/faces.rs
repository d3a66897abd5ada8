//! Contact over faces: the numbers of the runtime bit for bit, and calls that are refused.

use std::collections::HashSet;
use std::ptr::{null, null_mut};

use runtime::Mode;
use runtime::assembly::{ContactLaw, DofMap, Tangent, add_forces};
use runtime::faces::{FaceInterface, FaceOptions, FacePressures, FaceRule, QuadraticFace};
use runtime::friction::Coulomb;
use runtime::interface::{ContactInterface, InterfaceOptions};
use runtime::surface::{Facet, MasterSurface};

use super::faces_points::assert_points;
use super::{message, options};
use crate::assembly::dc_add_forces;
use crate::choice::Named;
use crate::faces::*;
use crate::faces_assembly::*;
use crate::faces_friction::*;
use crate::faces_points::dc_faces_points;
use crate::interface::{dc_create_self_contact, dc_destroy, dc_evaluate, dc_refresh, dc_slaves};
use crate::law::dc_law;
use crate::options::dc_options;
use crate::status::{
    DC_BAD_HANDLE, DC_BAD_OPTION, DC_BAD_POINTER, DC_BAD_SIZE, DC_BAD_SURFACE, DC_NOT_EVALUATED, DC_OK,
    DC_OUT_OF_RANGE, dc_status,
};
use crate::window::dc_window_create;

/// A bumpy lattice of 9 × 9 nodes below a coarser one of 5 × 5, which dips into it, each by faces of 9 nodes.
pub(super) struct Pair {
    pub(super) positions: Vec<f64>,
    pub(super) master: Vec<i32>,
    pub(super) slave: Vec<i32>,
}

impl Pair {
    pub(super) fn new() -> Self {
        let height = |x: f64, y: f64| 0.1 * (0.7 * x).sin() * (0.9 * y).cos();
        let mut positions = Vec::new();
        for k in 0..81 {
            let (x, y) = (0.5 * f64::from(k % 9), 0.5 * f64::from(k / 9));
            positions.extend([x, y, height(x, y)]);
        }
        for k in 0..25 {
            let (x, y) = (0.6 + 0.7 * f64::from(k % 5), 0.5 + 0.7 * f64::from(k / 5));
            positions.extend([x, y, height(x, y) - 0.02 + 0.01 * x]);
        }
        let nine = |first: i32, side: i32, i: i32, j: i32, is_up: bool| {
            let at = |a: i32, b: i32| first + 2 * i + a + side * (2 * j + b);
            let [c, d] = if is_up { [1, 3] } else { [3, 1] };
            let corners = [at(0, 0), at(2, 0), at(2, 2), at(0, 2)];
            let middles = [at(1, 0), at(2, 1), at(1, 2), at(0, 1)];
            // Seen from the other side corners and middles run the other way round.
            let [m0, m1, m2, m3] = if is_up { [0, 1, 2, 3] } else { [3, 2, 1, 0] };
            let corners = [corners[0], corners[c], corners[2], corners[d]];
            [corners, [middles[m0], middles[m1], middles[m2], middles[m3]]]
                .concat()
                .into_iter()
                .chain([at(1, 1)])
                .collect::<Vec<i32>>()
        };
        let faces = |first: i32, side: i32, cells: i32, is_up: bool| {
            (0..cells * cells).flat_map(|k| nine(first, side, k % cells, k / cells, is_up)).collect()
        };
        Self { positions, master: faces(0, 9, 4, true), slave: faces(81, 5, 2, false) }
    }

    pub(super) fn nodes(&self) -> usize {
        self.positions.len() / 3
    }

    /// The same as the runtime has it.
    pub(super) fn runtime(&self) -> FaceInterface {
        let (positions, _) = self.positions.as_chunks::<3>();
        let rows = |faces: &[i32]| -> Vec<Facet> {
            let facets = flat(faces);
            let row = |row: &[i32; 4]| Facet::Quadrilateral(row.map(|node| node as usize));
            facets.as_chunks::<4>().0.iter().map(row).collect()
        };
        let surface = MasterSurface::new(positions, rows(&self.master)).unwrap();
        let options = FaceOptions::new(InterfaceOptions::default()).with_rule(FaceRule::Second);
        FaceInterface::new(surface, &rows(&self.slave), positions, options).unwrap()
    }

    pub(super) fn make(&self, degree: i32) -> (dc_status, *mut dc_faces) {
        let (master, slave) = (flat(&self.master), flat(&self.slave));
        let mut handle = std::ptr::dangling_mut();
        // SAFETY: the arrays have the lengths given.
        let status = unsafe {
            dc_faces_create(
                self.positions.as_ptr(),
                self.nodes(),
                master.as_ptr(),
                master.len() / 4,
                slave.as_ptr(),
                slave.len() / 4,
                null(),
                degree,
                &mut handle,
            )
        };
        assert_eq!(status == DC_OK, !handle.is_null());
        (status, handle)
    }
}

/// Pairs of nodes that couple, by cliques, which are those of the runtime.
fn coupled(handle: *mut dc_faces, expected: &[Vec<u32>]) -> HashSet<(usize, usize)> {
    let (mut cliques, mut entries) = (0, 0);
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let count = dc_faces_cliques(handle, null_mut(), 0, null_mut(), 0, &mut cliques, &mut entries);
        assert_eq!((count, cliques), (DC_OK, expected.len()), "{}", message());
        let (mut offsets, mut nodes) = (vec![-1; cliques + 1], vec![-1; entries]);
        let (places, list) = (offsets.as_mut_ptr(), nodes.as_mut_ptr());
        let read = |offsets: usize, nodes: usize| {
            dc_faces_cliques(handle, places, offsets, list, nodes, null_mut(), null_mut())
        };
        assert_eq!([read(cliques, entries), read(cliques + 1, entries - 1)], [DC_BAD_SIZE; 2]);
        assert_eq!(read(cliques + 1, entries), DC_OK, "{}", message());
        let same = dc_faces_cliques(handle, list, entries, list, entries, null_mut(), null_mut());
        assert_eq!(same, DC_BAD_POINTER);
        assert_eq!((offsets[0], offsets[cliques] as usize), (0, entries));
        let mut couples = HashSet::new();
        for (ends, expected) in offsets.windows(2).zip(expected) {
            let clique = &nodes[ends[0] as usize..ends[1] as usize];
            assert!(clique.iter().map(|&node| node as u32).eq(expected.iter().copied()));
            let pairs = clique.iter().flat_map(|&a| clique.iter().map(move |&b| (a as usize, b as usize)));
            couples.extend(pairs);
        }
        couples
    }
}

pub(super) fn flat(faces: &[i32]) -> Vec<i32> {
    let mut facets = vec![7; faces.len() / 9 * 16];
    // SAFETY: the arrays have the lengths given.
    let status =
        unsafe { dc_flat_facets(faces.as_ptr(), faces.len() / 9, 9, facets.as_mut_ptr(), facets.len() / 4) };
    assert_eq!(status, DC_OK);
    facets
}

pub(super) fn law(multipliers: &[f64]) -> dc_law {
    dc_law {
        size: size_of::<dc_law>(),
        penalty: 300.0,
        multipliers: if multipliers.is_empty() { null() } else { multipliers.as_ptr() },
        multiplier_count: multipliers.len(),
        tangent: 0,
        reserved: 0,
        friction: 0.0,
        tangential_stiffness: 0.0,
        shear_limit: 0.0,
        ..dc_law::NONE
    }
}

#[test]
fn faces_give_what_the_runtime_gives() {
    let pair = Pair::new();
    let (positions, _) = pair.positions.as_chunks::<3>();
    let quadratic = |rows: &[i32]| -> Vec<QuadraticFace> {
        let row = |row: &[i32; 9]| QuadraticFace::new(&row.map(|node| node as usize)).unwrap();
        rows.as_chunks::<9>().0.iter().map(row).collect()
    };
    let (master, slave) = (quadratic(&pair.master), quadratic(&pair.slave));
    let facets =
        |faces: &[QuadraticFace]| faces.iter().flat_map(QuadraticFace::facets).collect::<Vec<Facet>>();
    let surface = MasterSurface::new(positions, facets(&master)).unwrap();
    let options = FaceOptions::new(InterfaceOptions::default()).with_rule(FaceRule::Fourth);
    let mut expected = FaceInterface::new(surface, &facets(&slave), positions, options).unwrap();
    expected.set_quadratic_faces(&[master, slave].concat()).unwrap();
    let report = expected.refresh(positions).unwrap();

    let (status, handle) = pair.make(4);
    assert_eq!(status, DC_OK, "{}", message());
    let multipliers: Vec<f64> = (0..25).map(|k| 0.1 * f64::from(k)).collect();
    let (slaves, dofs) = (expected.slaves().to_vec(), DofMap::standard(pair.nodes()));
    let own_law = ContactLaw::penalty(300.0).with_multipliers(Some(&multipliers));
    expected.evaluate(&own_law, Mode::Hessian).unwrap();
    let own_points = expected.integration_points().unwrap();
    let own_cliques: Vec<Vec<u32>> = expected.cliques().map(<[u32]>::to_vec).collect();
    let expected = expected.contacts();
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_faces_add_quadratic(handle, pair.master.as_ptr(), 16, 9), DC_OK);
        assert_eq!(dc_faces_add_quadratic(handle, pair.slave.as_ptr(), 4, 9), DC_OK);
        let mut found = dc_faces_report { size: size_of::<dc_faces_report>(), ..std::mem::zeroed() };
        assert_eq!(dc_faces_refresh(handle, pair.positions.as_ptr(), pair.nodes(), &mut found), DC_OK);
        assert_eq!(found.points as usize, report.points);
        assert_eq!((found.paired as usize, found.faces as usize), (report.paired, report.faces));
        let (mut nodes, mut count) = (0, 0);
        assert_eq!(dc_faces_counts(handle, &mut nodes, &mut count), DC_OK);
        assert_eq!((nodes, count), (pair.nodes(), 25));
        let mut own = vec![0; count];
        assert_eq!(dc_faces_slaves(handle, own.as_mut_ptr(), count), DC_OK);
        assert!(own.iter().zip(&slaves).all(|(own, node)| *own as usize == *node));

        assert_eq!(dc_faces_evaluate(handle, &law(&multipliers), 2), DC_OK, "{}", message());
        let (mut outcomes, mut gaps, mut pressures) = (vec![9; 25], vec![0.0; 25], vec![0.0; 25]);
        let (mut areas, mut normals) = (vec![0.0; 25], vec![0.0; 75]);
        let status = dc_faces_contacts(
            handle,
            outcomes.as_mut_ptr(),
            gaps.as_mut_ptr(),
            pressures.as_mut_ptr(),
            areas.as_mut_ptr(),
            normals.as_mut_ptr(),
            25,
        );
        assert_eq!(status, DC_OK);
        for (k, node) in expected.nodes().iter().enumerate() {
            assert_eq!((outcomes[k], gaps[k], areas[k]), (0, node.gap, node.area));
            assert_eq!((pressures[k], &normals[3 * k..3 * k + 3]), (node.pressure, &node.normal[..]));
        }
        assert!(pressures.iter().filter(|&&pressure| pressure > 0.0).count() > 10);
        assert_points(handle, &own_points);

        let size = 3 * pair.nodes();
        let (mut residual, mut sum) = (vec![0.0; size], vec![0.0; size]);
        let (mut active, mut missed) = (0, 9);
        let status = dc_faces_add_forces(handle, residual.as_mut_ptr(), size, &mut active, &mut missed);
        assert_eq!((status, missed), (DC_OK, expected.missed()));
        assert_eq!(active, expected.add_forces(&dofs, &mut sum).unwrap());
        assert_eq!(residual, sum);

        let couples = coupled(handle, &own_cliques);
        for (tangent, own) in [(0, Tangent::Exact), (1, Tangent::GaussNewton)] {
            let triplets = expected.triplets(own, &dofs).unwrap();
            let mut count = 0;
            let status =
                dc_faces_triplets(handle, tangent, null_mut(), null_mut(), null_mut(), 0, &mut count);
            assert_eq!((status, count), (DC_OK, triplets.len()));
            let (mut rows, mut columns, mut values) = (vec![0; count], vec![0; count], vec![0.0; count]);
            let status = dc_faces_triplets(
                handle,
                tangent,
                rows.as_mut_ptr(),
                columns.as_mut_ptr(),
                values.as_mut_ptr(),
                count,
                &mut count,
            );
            assert_eq!(status, DC_OK);
            assert_eq!(values, triplets.values());
            assert!(rows.iter().zip(triplets.rows()).all(|(found, row)| *found as usize == *row));
            assert!(columns.iter().zip(triplets.columns()).all(|(found, column)| *found as usize == *column));
            // A pattern of all that couples has room for them.
            let pair = |(row, column): (&i32, &i32)| (*row as usize / 3, *column as usize / 3);
            assert!(rows.iter().zip(&columns).all(|entry| couples.contains(&pair(entry))));
            let v: Vec<f64> = (0..size).map(|k| (k as f64).sin()).collect();
            let (mut product, mut sums) = (vec![0.5; size], vec![0.5; size]);
            let status = dc_faces_product(handle, tangent, v.as_ptr(), product.as_mut_ptr(), size);
            assert_eq!(status, DC_OK, "{}", message());
            expected.add_product(own, &dofs, &v, &mut sums).unwrap();
            assert!(product == sums && product.iter().any(|&entry| entry != 0.5));
        }
    }
    assert_eq!(dc_faces_destroy(handle), DC_OK);
}

/// Points with pressures of their own have those of the runtime.
#[test]
fn points_may_have_pressures_of_their_own() {
    let pair = Pair::new();
    let mut own = pair.runtime();
    let (positions, _) = pair.positions.as_chunks::<3>();
    own.refresh(positions).unwrap();
    own.set_pressures(FacePressures::Points);
    let expected = own.evaluate(&ContactLaw::penalty(law(&[]).penalty), Mode::Gradient).unwrap();
    let (dofs, size) = (DofMap::standard(pair.nodes()), 3 * pair.nodes());
    let mut sum = vec![0.0; size];
    expected.add_forces(&dofs, &mut sum).unwrap();
    let (_, handle) = pair.make(2);
    let mut forces = [vec![0.0; size], vec![0.0; size]];
    for (forces, pressures) in forces.iter_mut().zip([0, 1]) {
        // SAFETY: the arrays have the lengths given.
        unsafe {
            assert_eq!(dc_faces_set_pressures(handle, pressures), DC_OK);
            assert_eq!(dc_faces_refresh(handle, pair.positions.as_ptr(), pair.nodes(), null_mut()), DC_OK);
            assert_eq!(dc_faces_evaluate(handle, &law(&[]), 1), DC_OK);
            let forces = forces.as_mut_ptr();
            assert_eq!(dc_faces_add_forces(handle, forces, size, null_mut(), null_mut()), DC_OK);
        }
    }
    assert!(forces[1] == sum && forces[0] != sum);
    assert_eq!(dc_faces_set_pressures(handle, 2), DC_BAD_OPTION);
    assert_eq!(dc_faces_destroy(handle), DC_OK);
}

#[test]
fn faces_refuse_what_is_none() {
    let pair = Pair::new();
    assert_eq!(pair.make(3).0, DC_BAD_OPTION);
    assert!(message().contains("degree has to be 2 or 4, not 3"));
    let (_, handle) = pair.make(2);
    let size = 3 * pair.nodes();
    let mut residual = vec![0.0; size];
    // SAFETY: the arrays have the lengths given, or are refused.
    unsafe {
        let none = |status: dc_status| assert_eq!(status, DC_NOT_EVALUATED, "{}", message());
        none(dc_faces_add_forces(handle, residual.as_mut_ptr(), size, null_mut(), null_mut()));
        let (mut offset, mut cliques, mut entries) = (9, 9, 9);
        let found = dc_faces_cliques(handle, &mut offset, 1, null_mut(), 0, &mut cliques, &mut entries);
        assert_eq!((found, offset, cliques, entries), (DC_OK, 0, 0, 0));
        assert_eq!(dc_faces_refresh(handle, pair.positions.as_ptr(), 5, null_mut()), DC_BAD_SIZE);
        assert_eq!(dc_faces_refresh(handle, pair.positions.as_ptr(), pair.nodes(), null_mut()), DC_OK);
        assert_eq!(dc_faces_evaluate(handle, null(), 2), DC_BAD_POINTER);
        assert_eq!(dc_faces_evaluate(handle, &law(&[0.1; 3]), 2), DC_BAD_SIZE, "{}", message());
        assert_eq!(dc_faces_evaluate(handle, &law(&[-1.0; 25]), 2), DC_BAD_OPTION, "{}", message());
        assert_eq!(dc_faces_evaluate(handle, &law(&[]), 7), DC_BAD_OPTION);
        // Friction begins with a state that was accepted.
        let with_friction = dc_law { friction: 0.3, ..law(&[]) };
        assert_eq!(dc_faces_evaluate(handle, &with_friction, 2), DC_NOT_EVALUATED, "{}", message());
        assert!(message().starts_with("no-slip: "), "{}", message());
        let accept =
            |law| dc_faces_accept(handle, law, null_mut(), null_mut(), null_mut(), null_mut(), null_mut());
        assert_eq!(accept(null()), DC_BAD_POINTER);
        assert_eq!(accept(&dc_law { friction: -0.3, ..law(&[]) }), DC_BAD_OPTION);
        assert_eq!(accept(&dc_law { shear_limit: -1.0, ..with_friction }), DC_BAD_OPTION);
        assert_eq!(dc_faces_set_history(handle, [0.5].as_ptr(), 1), DC_BAD_OPTION);
        assert!(message().starts_with("invalid-history: "), "{}", message());
        none(dc_faces_friction(handle, null_mut(), null_mut(), null_mut(), 25));
        none(dc_faces_add_forces(handle, residual.as_mut_ptr(), size, null_mut(), null_mut()));
        assert_eq!(dc_faces_evaluate(handle, &law(&[]), 1), DC_OK);
        let residual = residual.as_mut_ptr();
        assert_eq!(dc_faces_add_forces(handle, residual, size - 1, null_mut(), null_mut()), DC_BAD_SIZE);
        assert_eq!(dc_faces_add_forces(handle, null_mut(), size, null_mut(), null_mut()), DC_BAD_POINTER);
        let v = vec![1.0; size];
        let product = |tangent, size| dc_faces_product(handle, tangent, v.as_ptr(), residual, size);
        assert_eq!((product(1, size - 1), product(7, size)), (DC_BAD_SIZE, DC_BAD_OPTION));
        none(product(0, size));
        assert_eq!(dc_faces_product(handle, 1, residual, residual, size), DC_BAD_POINTER);
        let mut count = 0;
        let triplets = |count| dc_faces_triplets(handle, 0, null_mut(), null_mut(), null_mut(), 0, count);
        // The exact tangent needs more than the gradient.
        none(triplets(&mut count));
        assert_eq!(
            dc_faces_triplets(handle, 9, null_mut(), null_mut(), null_mut(), 0, &mut count),
            DC_BAD_OPTION
        );
        // Positions of the moment have no results yet.
        assert_eq!(dc_faces_update(handle, pair.positions.as_ptr(), pair.nodes(), null_mut()), DC_OK);
        none(dc_faces_contacts(handle, null_mut(), null_mut(), null_mut(), null_mut(), null_mut(), 25));
        let [no, nothing] = [(); 2].map(|()| null_mut());
        none(dc_faces_points(handle, null_mut(), no, no, no, no, nothing, nothing, 0, &mut count));

        let faces = pair.master.as_ptr();
        assert_eq!(dc_faces_add_quadratic(handle, faces, 16, 7), DC_BAD_SIZE);
        assert_eq!(dc_faces_add_quadratic(handle, null(), 16, 9), DC_BAD_POINTER);
        let outside = [1000; 9];
        assert_eq!(dc_faces_add_quadratic(handle, outside.as_ptr(), 1, 9), DC_OUT_OF_RANGE);
        let negative = [-1; 9];
        assert_eq!(dc_faces_add_quadratic(handle, negative.as_ptr(), 1, 9), DC_OUT_OF_RANGE);
        let twice = [0; 6];
        assert_eq!(dc_faces_add_quadratic(handle, twice.as_ptr(), 1, 6), DC_BAD_SURFACE, "{}", message());
        let mut facets = [0; 12];
        assert_eq!(dc_flat_facets(faces, 1, 9, facets.as_mut_ptr(), 3), DC_BAD_SIZE);
        assert_eq!(dc_flat_facets(faces, 1, 9, null_mut(), 4), DC_BAD_POINTER);
        let plane = [0.0, 0.0, 0.0, 2.0, 0.0, 0.0];
        assert_eq!(dc_faces_set_symmetry(handle, plane.as_ptr(), 1), DC_BAD_SURFACE, "{}", message());
        assert_eq!(dc_faces_set_equations(handle, null(), 3, 9), DC_BAD_POINTER);
    }
    assert_eq!(dc_faces_destroy(null_mut()), DC_OK);
    assert_eq!(dc_faces_destroy(handle), DC_OK);
    assert_eq!(dc_faces_destroy(handle), DC_BAD_HANDLE);
    // SAFETY: refused.
    assert_eq!(unsafe { dc_faces_counts(handle, null_mut(), null_mut()) }, DC_BAD_HANDLE);
}

/// Results and the history are those of the runtime bit for bit, and go on in another object.
#[test]
fn faces_have_friction() {
    let pair = Pair::new();
    let (positions, _) = pair.positions.as_chunks::<3>();
    let mut expected = pair.runtime();
    let own_law = ContactLaw::penalty(300.0).with_friction(Some(Coulomb::new(0.3, 300.0).unwrap()));
    let law = dc_law { friction: 0.3, ..law(&[]) };
    let moved: Vec<f64> = pair
        .positions
        .iter()
        .enumerate()
        .map(|(k, x)| x + 0.002 * f64::from(k >= 243 && k % 3 == 0))
        .collect();
    let (moved_points, _) = moved.as_chunks::<3>();
    expected.refresh(positions).unwrap();
    expected.accept(&own_law).unwrap();
    expected.refresh(moved_points).unwrap();
    let nodes = expected.evaluate(&own_law, Mode::Hessian).unwrap().nodes().to_vec();
    let report = expected.accept(&own_law).unwrap();

    let size = moved.len();
    let refresh = |handle, positions: &[f64]| {
        // SAFETY: the array has the length given.
        assert_eq!(unsafe { dc_faces_refresh(handle, positions.as_ptr(), pair.nodes(), null_mut()) }, DC_OK);
    };
    let forces = |handle| {
        let mut forces = vec![0.0; size];
        // SAFETY: the array has the length given.
        unsafe {
            assert_eq!(dc_faces_evaluate(handle, &law, 2), DC_OK, "{}", message());
            assert_eq!(dc_faces_add_forces(handle, forces.as_mut_ptr(), size, null_mut(), null_mut()), DC_OK);
        }
        forces
    };
    let (_, handle) = pair.make(2);
    refresh(handle, &pair.positions);
    let mut count = 9;
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_faces_history(handle, null_mut(), 0, &mut count), DC_OK);
        assert_eq!(count, 0);
        assert_eq!(
            dc_faces_accept(handle, &law, null_mut(), null_mut(), null_mut(), null_mut(), null_mut()),
            DC_OK
        );
        refresh(handle, &moved);
        forces(handle);
        let (mut states, mut tractions, mut slips) = (vec![9; 25], vec![9.0; 75], vec![9.0; 25]);
        let (a, b, c) = (states.as_mut_ptr(), tractions.as_mut_ptr(), slips.as_mut_ptr());
        assert_eq!(dc_faces_friction(handle, a, b, c, 24), DC_BAD_SIZE);
        assert_eq!(dc_faces_friction(handle, a, b, c, 25), DC_OK);
        for (k, node) in nodes.iter().enumerate() {
            assert_eq!((states[k], slips[k]), (node.friction_state.number(), node.slip));
            assert_eq!(tractions[3 * k..3 * k + 3], node.friction);
        }
        assert!(states.contains(&1) && states.contains(&2), "{states:?}");
        let (mut stuck, mut sliding, mut unanchored, mut dropped, mut dissipated) = (9, 9, 9, 9, 0.0);
        let status = dc_faces_accept(
            handle,
            &law,
            &mut stuck,
            &mut sliding,
            &mut unanchored,
            &mut dropped,
            &mut dissipated,
        );
        assert_eq!(status, DC_OK);
        assert_eq!((stuck, sliding), (report.stuck, report.sliding));
        assert_eq!((unanchored, dropped), (report.unanchored, report.dropped));
        assert_eq!(dissipated, report.dissipated);
        assert!(dissipated > 0.0);
        assert_eq!(dc_faces_add_forces(handle, [].as_mut_ptr(), 0, null_mut(), null_mut()), DC_NOT_EVALUATED);
        assert_eq!(dc_faces_history(handle, null_mut(), 0, &mut count), DC_OK);
    }
    let mut history = vec![0.0; count];
    // SAFETY: the arrays have the lengths given.
    unsafe {
        assert_eq!(dc_faces_history(handle, history.as_mut_ptr(), count - 1, &mut count), DC_BAD_SIZE);
        assert_eq!(dc_faces_history(handle, history.as_mut_ptr(), count, &mut count), DC_OK);
    }
    assert_eq!(history, expected.history());
    let further: Vec<f64> = pair.positions.iter().zip(&moved).map(|(x, y)| 1.5 * y - 0.5 * x).collect();
    refresh(handle, &further);
    let found = forces(handle);
    assert_eq!(dc_faces_destroy(handle), DC_OK);

    let (_, handle) = pair.make(2);
    // SAFETY: the array has the length given.
    assert_eq!(unsafe { dc_faces_set_history(handle, history.as_ptr(), count) }, DC_OK);
    refresh(handle, &further);
    assert_eq!(forces(handle), found);
    assert_eq!(dc_faces_destroy(handle), DC_OK);
}

/// Both lattices as one surface, apart at first: a sheet right behind another would be the back of one body.
fn itself(pair: &Pair) -> (Vec<[f64; 3]>, Vec<i32>, MasterSurface) {
    let (positions, _) = pair.positions.as_chunks::<3>();
    let mut apart = positions.to_vec();
    apart[81..].iter_mut().for_each(|position| position[2] += 0.1);
    let facets = [flat(&pair.master), flat(&pair.slave)].concat();
    let row = |row: &[i32; 4]| Facet::Quadrilateral(row.map(|node| node as usize));
    let rows = facets.as_chunks::<4>().0.iter().map(row).collect();
    let surface = MasterSurface::new(&apart, rows).unwrap();
    (apart, facets, surface)
}

/// The force on the upper side of one body is that on the lower side of the other.
fn assert_sides(forces: &[f64]) {
    let along = |nodes: std::ops::Range<usize>| nodes.map(|node| forces[3 * node + 2]).sum::<f64>();
    let (below, above) = (along(0..81), along(81..forces.len() / 3));
    assert!(above.abs() > 1.0 && (below + above).abs() < 1e-12 * above.abs(), "{below} {above}");
}

/// Over nodes: what the runtime has, bit for bit.
#[test]
fn nodes_of_a_surface_touch_it() {
    let pair = Pair::new();
    let (positions, _) = pair.positions.as_chunks::<3>();
    let (apart, facets, surface) = itself(&pair);
    let own = InterfaceOptions::default().with_areas(true);
    let mut expected = ContactInterface::self_contact(surface, &apart, own).unwrap();
    expected.refresh_pairing(positions).unwrap();
    let of_runtime = ContactLaw::penalty(300.0);
    let expected = expected.evaluate(Mode::Gradient).unwrap();
    let size = 3 * pair.nodes();
    let (mut sum, mut forces, mut handle) = (vec![0.0; size], vec![0.0; size], null_mut());
    add_forces(expected, &of_runtime, &DofMap::standard(pair.nodes()), &mut sum).unwrap();
    let options = dc_options { areas: 1, ..options() };
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let (nodes, count) = (pair.nodes(), facets.len() / 4);
        let (start, moved) = (apart.as_flattened().as_ptr(), pair.positions.as_ptr());
        let (list, narrow) = (facets.as_ptr(), dc_options { border_tolerance: -1.0, ..options });
        assert_eq!(dc_create_self_contact(start, nodes, list, count, &narrow, &mut handle), DC_BAD_OPTION);
        assert_eq!(
            dc_create_self_contact(start, nodes, null(), count, &options, &mut handle),
            DC_BAD_POINTER
        );
        let status = dc_create_self_contact(start, nodes, list, count, &options, &mut handle);
        assert_eq!(status, DC_OK, "{}", message());
        let mut slaves = vec![-1; nodes];
        assert_eq!(dc_slaves(handle, slaves.as_mut_ptr(), nodes), DC_OK);
        assert!(slaves.iter().enumerate().all(|(k, &node)| node as usize == k), "each node, ascending");
        assert_eq!(dc_slaves(handle, slaves.as_mut_ptr(), nodes - 1), DC_BAD_SIZE);
        assert_eq!(dc_slaves(handle, null_mut(), nodes), DC_BAD_POINTER);
        assert_eq!(dc_refresh(handle, moved, nodes, null_mut()), DC_OK);
        assert_eq!(dc_evaluate(handle, 1), DC_OK, "{}", message());
        let status = dc_add_forces(handle, &law(&[]), forces.as_mut_ptr(), size, null_mut());
        assert_eq!(status, DC_OK, "{}", message());
        let (mut window, boxes) = (null_mut(), [-9.0, -9.0, -9.0, 9.0, 9.0, 9.0]);
        assert_eq!(dc_window_create(handle, boxes.as_ptr(), 1, 0.0, &mut window), DC_BAD_OPTION);
        assert!(message().starts_with("self-contact: "), "{}", message());
        assert_eq!(dc_destroy(handle), DC_OK);
    }
    assert_eq!(forces, sum);
    assert_sides(&forces);
}

/// What the runtime has, bit for bit.
#[test]
fn a_surface_touches_itself() {
    let pair = Pair::new();
    let (positions, _) = pair.positions.as_chunks::<3>();
    let (apart, facets, surface) = itself(&pair);
    let options = FaceOptions::new(InterfaceOptions::default());
    let mut expected = FaceInterface::self_contact(surface, &apart, options).unwrap();
    expected.refresh(positions).unwrap();
    let expected = expected.evaluate(&ContactLaw::penalty(300.0), Mode::Gradient).unwrap();
    let size = 3 * pair.nodes();
    let (mut sum, mut residual, mut handle) = (vec![0.0; size], vec![0.0; size], null_mut());
    expected.add_forces(&DofMap::standard(pair.nodes()), &mut sum).unwrap();
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let (nodes, count) = (pair.nodes(), facets.len() / 4);
        let (start, moved) = (apart.as_flattened().as_ptr(), pair.positions.as_ptr());
        let create = |facets: *const i32, degree: i32, handle: &mut *mut dc_faces| {
            dc_faces_create_self_contact(start, nodes, facets, count, null(), degree, handle)
        };
        assert_eq!(create(null(), 2, &mut handle), DC_BAD_POINTER);
        assert_eq!(create(facets.as_ptr(), 3, &mut handle), DC_BAD_OPTION);
        assert!(handle.is_null());
        assert_eq!(create(facets.as_ptr(), 2, &mut handle), DC_OK, "{}", message());
        let mut slaves = 0;
        assert_eq!(dc_faces_counts(handle, null_mut(), &mut slaves), DC_OK);
        assert_eq!(slaves, nodes);
        assert_eq!(dc_faces_refresh(handle, moved, nodes, null_mut()), DC_OK);
        assert_eq!(dc_faces_evaluate(handle, &law(&[]), 1), DC_OK, "{}", message());
        let status = dc_faces_add_forces(handle, residual.as_mut_ptr(), size, null_mut(), null_mut());
        assert_eq!(status, DC_OK);
    }
    assert_eq!(residual, sum);
    assert_sides(&residual);
    assert_eq!(dc_faces_destroy(handle), DC_OK);
}

/// Of a rank that has none.
#[test]
fn without_slave_facets_there_are_no_faces() {
    let pair = Pair::new();
    let (facets, positions) = (flat(&pair.master), pair.positions.as_ptr());
    let (nodes, count, size) = (pair.nodes(), facets.len() / 4, pair.positions.len());
    let (mut handle, mut slaves, mut points, mut active) = (null_mut(), 9, 9, 9);
    let mut residual = vec![0.0; size];
    let [no, none] = [(); 2].map(|()| null_mut());
    // SAFETY: the arrays have the lengths given.
    unsafe {
        let create = |slaves: usize, handle: &mut *mut dc_faces| {
            dc_faces_create(positions, nodes, facets.as_ptr(), count, null(), slaves, null(), 2, handle)
        };
        assert_eq!(create(1, &mut handle), DC_BAD_POINTER);
        assert_eq!(create(0, &mut handle), DC_OK, "{}", message());
        assert_eq!(dc_faces_counts(handle, null_mut(), &mut slaves), DC_OK);
        assert_eq!(dc_faces_slaves(handle, null_mut(), 0), DC_OK);
        assert_eq!(dc_faces_refresh(handle, positions, nodes, null_mut()), DC_OK, "{}", message());
        assert_eq!(dc_faces_evaluate(handle, &law(&[]), 2), DC_OK, "{}", message());
        let status = dc_faces_add_forces(handle, residual.as_mut_ptr(), size, &mut active, null_mut());
        assert_eq!(status, DC_OK);
        let asked = dc_faces_points(handle, null_mut(), no, no, no, no, none, none, 0, &mut points);
        assert_eq!(asked, DC_OK);
    }
    assert_eq!((slaves, points, active), (0, 0, 0));
    assert!(residual.iter().all(|&force| force == 0.0));
    assert_eq!(dc_faces_destroy(handle), DC_OK);
}
