//! Gaps and pressures of the nodes, forces and tangent of the faces.

use std::sync::Mutex;

use rayon::prelude::*;

use super::block::{FaceBlock, FaceLoad, FacePlaces, FaceView, PointContact, PointScratch, place};
use super::contacts::{FaceContacts, FacePart, FrictionBlock, NodeBlock, NodeContact};
use super::cut::{FacePoint, height_over};
use super::friction::Traction;
use super::track::Track;
use super::{FaceCut, FaceInterface, FacePressures};
use crate::Mode;
use crate::assembly::{AssemblyError, ContactLaw};
use crate::friction::NormalForce;
use crate::interface::{ContactRef, InterfaceError, NoContact, Outcome, Results, Second};
use crate::neighbourhood::Fallback;
use crate::surface::{shape_of, sort};
use crate::vector::Vector3;

/// Nodes with less than this part of their area over the master carry nothing.
pub(super) const SMALLEST_AREA: f64 = 1e-9;
/// Points that one thread evaluates in a row.
const CHUNK: usize = 256;
/// Points whose results are held at once.
const AT_ONCE: usize = 1 << 16;

/// What the first look at all points gives.
pub(super) struct Averages {
    /// Gap and pressure of each node.
    pub nodes: Vec<NodeContact>,
    /// The average of ∂g/∂x of each node's points, if asked for.
    pub normals: Vec<Vector3>,
    pub points: PointStates,
    /// Points of loaded faces without a place, and those below their facet whose element has no result.
    pub missed: usize,
}

/// What the first look finds at each point.
#[derive(Default)]
pub(super) struct PointStates {
    /// Whether it has a contact.
    pub is_contact: Vec<bool>,
    /// Its own pressure and −∂p/∂g; empty where pressures are those of the nodes.
    pub pressures: Vec<NormalForce>,
}

impl PointStates {
    /// Whether it takes part in what a face adds. `counts`: even without pressure, with its gap and its normal.
    fn takes_part(&self, k: usize, counts: bool) -> bool {
        self.is_contact[k] && (counts || self.pressures.get(k).is_none_or(|own| own.force > 0.0))
    }
}

impl FaceInterface {
    /// The places of a face's corners among the slaves.
    pub(super) fn places_of(&self, face: usize) -> impl Iterator<Item = usize> + Clone {
        self.slaves.of_face(face, &self.faces[face])
    }

    /// Hands over each point with the number of its face, the shape functions of the face's corners, and its contact.
    pub(super) fn for_each_point(
        &self,
        mode: Mode,
        mut f: impl FnMut(usize, &FacePoint, [f64; 4], &ContactRef<'_>),
    ) -> Result<(), InterfaceError> {
        let mut face = 0;
        let mut results = Results::default();
        let count = self.points.len();
        for start in (0..count).step_by(AT_ONCE) {
            let range = start..(start + AT_ONCE).min(count);
            self.interface.evaluate_range(range, mode, &mut results, |contact| {
                let k = contact.slave - self.positions.len();
                while !self.cuts[face].points.contains(&k) {
                    face += 1;
                }
                let point = &self.points[k];
                let functions = shape_of(&self.faces[face], &self.positions).functions(point.natural);
                f(face, point, functions, &contact);
            })?;
        }
        Ok(())
    }

    /// The average gap at each node, and its pressure; `has_normals`: the mean normals, too, which friction needs.
    pub(super) fn averages(
        &self,
        law: &ContactLaw<'_>,
        has_normals: bool,
    ) -> Result<Averages, InterfaceError> {
        let blank = |(k, &slave): (usize, &usize)| {
            NodeContact::without(slave, NoContact::NothingOver { limit: self.limit_around(k) })
        };
        let mut nodes: Vec<NodeContact> = self.slaves().iter().enumerate().map(blank).collect();
        let (mode, normals) = if has_normals { (Mode::Gradient, nodes.len()) } else { (Mode::Value, 0) };
        let mut normals = vec![Vector3::zeros(); normals];
        let is_by_points = self.options.pressures == FacePressures::Points;
        let mut points = PointStates::default();
        points.is_contact.reserve(self.points.len());
        let (mut failed, mut without_result) = (None, Vec::new());
        self.for_each_point(mode, |face, point, functions, contact| {
            let is_contact = contact.outcome.is_contact();
            points.is_contact.push(is_contact);
            if let Outcome::None(NoContact::Element { .. } | NoContact::NoCandidate { .. }) = contact.outcome
                && self.is_below_facet(face, point)
            {
                without_result.push(face);
            }
            let mut own = NormalForce { force: 0.0, stiffness: 0.0 };
            if is_by_points {
                if is_contact {
                    match point_pressure(law, self.places_of(face).zip(functions), contact.point.gap) {
                        Ok(found) => own = found,
                        Err(error) => failed = failed.take().or(Some(error)),
                    }
                }
                points.pressures.push(own);
            }
            for (place, n) in self.places_of(face).zip(functions) {
                let node = &mut nodes[place];
                match (contact.outcome, node.outcome) {
                    (Outcome::Contact { .. }, _) => {
                        let weight = point.weight * n;
                        // Of several the one that gave up most.
                        if !matches!(node.outcome, Outcome::Contact { fallback: Fallback::Linear { .. } }) {
                            node.outcome = contact.outcome;
                        }
                        node.area += weight;
                        node.gap += weight * contact.point.gap;
                        node.smallest_gap = node.smallest_gap.min(contact.point.gap);
                        node.pressure += weight * own.force;
                        node.stiffness += weight * own.stiffness;
                        for axis in 0..3 {
                            node.normal[axis] += weight * contact.point.normal[axis];
                        }
                        if let (Some(normal), &[a, b, c, ..]) = (normals.get_mut(place), contact.gradient) {
                            *normal += Vector3::from([a, b, c]) * weight;
                        }
                    }
                    (reason, Outcome::None(NoContact::NothingOver { .. })) => node.outcome = reason,
                    (Outcome::None(_), _) => {}
                }
            }
        })?;
        if let Some(error) = failed {
            return Err(error.into());
        }
        for (k, node) in nodes.iter_mut().enumerate() {
            *node = self.average(k, *node, normals.get_mut(k), law)?;
        }
        let is_loaded = |face: usize| self.places_of(face).any(|place| nodes[place].pressure > 0.0);
        let unplaced =
            self.unplaced.iter().enumerate().filter(|&(face, &count)| count > 0 && is_loaded(face));
        let missed = unplaced.map(|(_, count)| count).sum::<usize>()
            + without_result.into_iter().filter(|&face| is_loaded(face)).count();
        Ok(Averages { nodes, normals, points, missed })
    }

    /// Whether a point of a face lies below its facet, seen along the face's normal.
    fn is_below_facet(&self, face: usize, point: &FacePoint) -> bool {
        let x = Vector3::from(self.skin.position(face, point.natural, &self.positions));
        let facet = shape_of(&self.master().facet(point.facet as usize), &self.positions);
        let normal = shape_of(&self.faces[face], &self.positions).normal();
        height_over(&facet, x, normal).is_none_or(|height| height < 0.0)
    }

    /// The average at a node from the sums over its points, and its pressure. `normal`: the sum of ∂g/∂x.
    fn average(
        &self,
        k: usize,
        sums: NodeContact,
        normal: Option<&mut Vector3>,
        law: &ContactLaw<'_>,
    ) -> Result<NodeContact, InterfaceError> {
        let unknown = self.window.as_ref().and_then(|window| window.of_node(k, &self.slaves.around[k]));
        if let Some(reason) = unknown {
            return Ok(NodeContact::without(sums.slave, reason));
        }
        if !(sums.area > SMALLEST_AREA * self.areas()[k]) {
            let reason = match sums.outcome {
                Outcome::Contact { .. } => NoContact::NothingOver { limit: self.limit_around(k) },
                Outcome::None(reason) => reason,
            };
            return Ok(NodeContact::without(sums.slave, reason));
        }
        if let Some(normal) = normal {
            *normal = *normal / sums.area;
        }
        let gap = sums.gap / sums.area;
        let normal = Vector3::from(sums.normal).try_normalize().filter(Vector3::is_finite);
        let normal = normal.unwrap_or_default().into();
        let (pressure, stiffness) = match self.options.pressures {
            FacePressures::Nodes => {
                let NormalForce { force, stiffness } = law.checked_normal_force(k, gap, 1.0)?;
                (force, stiffness)
            }
            FacePressures::Points => (sums.pressure / sums.area, sums.stiffness / sums.area),
        };
        Ok(NodeContact { gap, normal, pressure, stiffness, ..sums })
    }

    /// Forces and tangents of the faces around nodes that carry pressure. `earlier`: what was found before, for its memory.
    pub(super) fn derive(
        &self,
        mode: Mode,
        (points, tractions): (&PointStates, &[Option<Traction>]),
        contacts: &mut FaceContacts,
        earlier: Vec<FacePart>,
    ) -> Result<(), InterfaceError> {
        let is_by_points = self.options.pressures == FacePressures::Points;
        let load = |face: usize| {
            let mut load = FaceLoad::default();
            for (corner, place) in self.places_of(face).enumerate() {
                let pressure = contacts.nodes[place].pressure;
                load.pressures[corner] = pressure;
                if let Some(Some(traction)) = tractions.get(place) {
                    let value =
                        if is_by_points { traction.value.map(|t| t / pressure) } else { traction.value };
                    load.tractions.get_or_insert_default()[corner] = value;
                }
            }
            load
        };
        let loads: Vec<FaceLoad> = (0..self.faces.len()).map(load).collect();
        let is_loaded = |k: &usize| {
            let own = &self.cuts[*k].points;
            let is_pressed = loads[*k].pressures.iter().any(|&p| p > 0.0);
            // Without a traction no other point of the face counts.
            let counts = loads[*k].tractions.is_some() || points.pressures.is_empty();
            is_pressed && own.clone().any(|point| points.takes_part(point, counts))
        };
        let loaded: Vec<usize> = (0..self.faces.len()).filter(is_loaded).collect();
        let memory = Mutex::new(earlier.into_iter().rev().flat_map(FacePart::into_memory).collect());
        let blocks: Vec<Vec<FaceBlock>> = self
            .runs(&loaded)
            .into_par_iter()
            .map(|faces| self.blocks(faces, mode, (&loads, points), &memory))
            .collect::<Result<_, _>>()?;
        let mut of_face: Vec<Option<FaceBlock>> = vec![None; self.faces.len()];
        for (&k, block) in loaded.iter().zip(blocks.into_iter().flatten()) {
            contacts.missed += block.missed;
            of_face[k] = Some(block);
        }
        // What points press with is the faces'.
        let has_block = |k: usize| !is_by_points || matches!(tractions.get(k), Some(Some(_)));
        let nodes = contacts.nodes.iter().copied().enumerate();
        let carrying: Vec<(usize, NodeContact)> =
            nodes.filter(|(k, node)| node.pressure > 0.0 && has_block(*k)).collect();
        contacts.blocks = carrying
            .into_par_iter()
            .map(|(k, node)| {
                let traction = tractions.get(k).and_then(Option::as_ref);
                let by_pressure = traction.filter(|_| is_by_points).map(|own| own.over(node.pressure));
                self.node_block(k, &node, mode, by_pressure.as_ref().or(traction), &of_face)
            })
            .collect();
        if mode >= Mode::Hessian || is_by_points {
            contacts.faces = loaded
                .iter()
                .filter_map(|&face| {
                    let FaceCut { rows, columns, .. } = self.cuts[face].clone();
                    let FaceBlock { pressed, by_gaps, directions, .. } = of_face[face].take()?;
                    Some(FacePart { face, rows, columns, pressed, by_gaps, directions })
                })
                .collect();
        }
        Ok(())
    }

    /// Faces one after another whose points are evaluated together.
    pub(super) fn runs<'s>(&self, loaded: &'s [usize]) -> Vec<&'s [usize]> {
        let mut count = 0;
        loaded
            .chunk_by(|&one, &next| {
                count += self.cuts[one].points.len();
                let goes_on = self.cuts[one].points.end == self.cuts[next].points.start && count < CHUNK;
                if !goes_on {
                    count = 0;
                }
                goes_on
            })
            .collect()
    }

    fn view<'a>(&'a self, face: usize, load: FaceLoad, pressures: &'a [NormalForce]) -> FaceView<'a> {
        let (FaceCut { rows, columns, .. }, carrying) = (&self.cuts[face], &self.carriers.faces[face]);
        FaceView {
            facet: &self.faces[face],
            shape: shape_of(&self.faces[face], &self.positions),
            carrying,
            positions: &self.positions,
            skin: &self.skin,
            interface: &self.interface,
            face,
            rows,
            columns,
            load,
            pressures,
            places: FacePlaces::new(&self.skin, face, carrying, rows, columns),
        }
    }

    /// The sums of consecutive faces.
    fn blocks(
        &self,
        faces: &[usize],
        mode: Mode,
        (loads, states): (&[FaceLoad], &PointStates),
        memory: &Mutex<Vec<Vec<f64>>>,
    ) -> Result<Vec<FaceBlock>, InterfaceError> {
        let views: Vec<FaceView<'_>> =
            faces.iter().map(|&k| self.view(k, loads[k], &states.pressures)).collect();
        let mut blocks: Vec<FaceBlock> =
            views.iter().map(|view| FaceBlock::new(view, mode, memory)).collect::<Result<_, _>>()?;
        let mut scratch = PointScratch::default();
        // The normal of a traction is that of all points around its node.
        let turns = |&face: &usize| mode >= Mode::Hessian && loads[face].tractions.is_some();
        let points =
            faces.iter().flat_map(|face| self.cuts[*face].points.clone().map(move |k| (k, turns(face))));
        let present: Vec<usize> =
            points.filter(|&(k, counts)| states.takes_part(k, counts)).map(|(k, _)| k).collect();
        let second = if mode >= Mode::Hessian { Second::SlaveRows } else { Second::None };
        let found = self.interface.linearise_slaves(&present, second)?;
        let (mut own, mut rest) = (0, &found.points[..]);
        for contact in &found.contacts {
            let (points, others) = rest.split_at(contact.points);
            rest = others;
            while !self.cuts[faces[own]].points.contains(&contact.index) {
                own += 1;
            }
            if contact.point.gap.is_nan() {
                // Derivatives that overflow, of a gap that does not.
                blocks[own].missed += 1;
                continue;
            }
            let freedoms = 3 * (points.len() + 1);
            let rows = if second == Second::SlaveRows { 3 * freedoms } else { 0 };
            let by_contact = PointContact {
                points,
                gradient: &found.gradients[contact.gradient..][..freedoms],
                slave_rows: &found.seconds[contact.second_start..][..rows],
            };
            let point = &self.points[contact.index];
            let over = &self.carriers.facets[point.facet as usize];
            blocks[own].add(&views[own], (contact.index, point), over, &by_contact, &mut scratch);
        }
        Ok(blocks)
    }

    /// Hands over the points of consecutive faces that have a contact, each with its face's place in the list.
    pub(super) fn for_each_contact_of(
        &self,
        faces: &[usize],
        mode: Mode,
        results: &mut Results,
        mut f: impl FnMut(usize, &FacePoint, &ContactRef<'_>),
    ) -> Result<(), InterfaceError> {
        let (Some(&first), Some(&last)) = (faces.first(), faces.last()) else { return Ok(()) };
        let range = self.cuts[first].points.start..self.cuts[last].points.end;
        let mut own = 0;
        self.interface.evaluate_range(range, mode, results, |contact| {
            let k = contact.slave - self.positions.len();
            while !self.cuts[faces[own]].points.contains(&k) {
                own += 1;
            }
            if contact.outcome.is_contact() {
                f(own, &self.points[k], &contact);
            }
        })
    }

    /// The sums of the faces around a node.
    fn node_block(
        &self,
        k: usize,
        node: &NodeContact,
        mode: Mode,
        traction: Option<&Traction>,
        of_face: &[Option<FaceBlock>],
    ) -> NodeBlock {
        let is_by_points = self.options.pressures == FacePressures::Points;
        let faces = || {
            let around = self.slaves.around[k].iter().map(|&face| face as usize);
            around.filter_map(|face| Some((face, of_face[face].as_ref()?)))
        };
        let all = |of: fn(&FaceCut) -> &[u32]| {
            let mut nodes: Vec<u32> = faces().flat_map(|(face, _)| of(&self.cuts[face])).copied().collect();
            sort(&mut nodes);
            nodes
        };
        let (rows, mut columns) = (all(|cut| &cut.rows), all(|cut| &cut.columns));
        let track = self.present_history().and_then(|tracks| tracks[k].as_ref());
        let track = track.filter(|_| traction.is_some());
        columns.extend(track.into_iter().flat_map(Track::terms).map(|(node, _)| node));
        sort(&mut columns);
        let of = |count: usize| vec![0.0; 3 * count];
        let mut sums = NodeBlock {
            forces: of(rows.len()),
            gradient: of(columns.len()),
            friction: traction.map(|traction| FrictionBlock {
                traction: traction.value,
                forces: std::array::from_fn(|_| of(rows.len())),
                gradients: std::array::from_fn(|_| of(columns.len())),
                turning: Default::default(),
            }),
            node: k,
            rows,
            columns,
            pressure: if is_by_points { 0.0 } else { node.pressure },
            stiffness: if is_by_points { 0.0 } else { node.stiffness },
        };
        // ∂n/∂x, three rows.
        let turns = traction.is_some() && mode >= Mode::Hessian;
        let mut normals = vec![of(sums.columns.len()); if turns { 3 } else { 0 }];
        for (face, block) in faces() {
            let corner = self.faces[face].corners().iter().position(|&corner| corner == node.slave);
            let Some(corner) = corner else { continue };
            let cut = &self.cuts[face];
            if !is_by_points {
                add(&sums.rows, &mut sums.forces, &cut.rows, &block.forces[corner], 1.0);
            }
            add(&sums.columns, &mut sums.gradient, &cut.columns, &block.gradients[corner], 1.0 / node.area);
            if let Some(friction) = &mut sums.friction {
                for (sum, own) in friction.forces.iter_mut().zip(&block.friction[corner]) {
                    add(&sums.rows, sum, &cut.rows, own, 1.0);
                }
                let own = block.normals[corner].chunks_exact((3 * cut.columns.len()).max(1));
                for (sum, own) in normals.iter_mut().zip(own) {
                    add(&sums.columns, sum, &cut.columns, own, 1.0 / node.area);
                }
            }
        }
        if let (Some(traction), Some(track)) = (traction, track) {
            // By points G is −∂p_A/∂x.
            sums.derive_friction(traction, track, if is_by_points { 1.0 } else { node.stiffness }, &normals);
        }
        sums
    }
}

impl NodeBlock {
    /// The chain rule: the traction by pressure, normal and way; those by the nodes. `normals`: ∂n/∂x, if the tangent needs it.
    /// `stiffness`: −∂p_A/∂ḡ_A of the gap that G is the gradient of.
    fn derive_friction(&mut self, traction: &Traction, track: &Track, stiffness: f64, normals: &[Vec<f64>]) {
        let Some(friction) = &mut self.friction else { return };
        for (i, row) in friction.gradients.iter_mut().enumerate() {
            let by_gap = -stiffness * traction.by_pressure[i];
            row.iter_mut().zip(&self.gradient).for_each(|(sum, by)| *sum += by_gap * by);
            if !normals.is_empty() {
                let row = &mut friction.turning[i];
                *row = vec![0.0; 3 * self.columns.len()];
                for (factor, by) in traction.by_normal[i].iter().zip(normals) {
                    row.iter_mut().zip(by).for_each(|(sum, by)| *sum += factor * by);
                }
            }
            for (node, weight) in track.terms() {
                let place = place(&self.columns, node);
                for axis in 0..3 {
                    row[3 * place + axis] += weight * traction.by_way[i][axis];
                }
            }
        }
    }
}

/// The pressure at a point of a face; a law of one's own is asked for that of the nearest corner.
fn point_pressure(
    law: &ContactLaw<'_>,
    corners: impl Iterator<Item = (usize, f64)> + Clone,
    gap: f64,
) -> Result<NormalForce, AssemblyError> {
    let nearest = corners.clone().max_by(|(_, one), (_, other)| one.total_cmp(other));
    let multiplier = corners.map(|(place, n)| n * law.multiplier(place)).sum();
    let found = law.checked_force_with(multiplier, nearest.map_or(0, |(place, _)| place), gap, 1.0)?;
    Ok(NormalForce { stiffness: if found.force > 0.0 { found.stiffness } else { 0.0 }, ..found })
}

/// Adds a vector over some of the nodes.
fn add(nodes: &[u32], sums: &mut [f64], own: &[u32], values: &[f64], factor: f64) {
    let mut place = 0;
    for (node, values) in own.iter().zip(values.as_chunks::<3>().0) {
        while nodes[place] != *node {
            place += 1;
        }
        for axis in 0..3 {
            sums[3 * place + axis] += factor * values[axis];
        }
    }
}
