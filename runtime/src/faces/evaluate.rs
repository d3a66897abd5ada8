//! Gaps and pressures of the nodes, forces and tangent of the faces.

use rayon::prelude::*;

use super::block::{FaceBlock, FaceView};
use super::contacts::{DirectionBlock, FaceContacts, NodeBlock, NodeContact};
use super::{FaceCut, FaceInterface, sort};
use crate::Mode;
use crate::assembly::ContactLaw;
use crate::interface::{InterfaceError, NoContact, Outcome, Results};
use crate::neighbourhood::Fallback;
use crate::surface::shape_of;
use crate::vector::Vector3;

/// Nodes with less than this part of their area over the master carry nothing.
const SMALLEST_AREA: f64 = 1e-9;
/// Points that one thread evaluates in a row.
const CHUNK: usize = 256;

impl FaceInterface {
    /// The average gap at each node, and its pressure.
    pub(super) fn averages(&self, law: &ContactLaw<'_>) -> Result<Vec<NodeContact>, InterfaceError> {
        let blank = |(k, &slave): (usize, &usize)| {
            let outcome = Outcome::None(NoContact::NothingOver { limit: self.limit_around(k) });
            NodeContact { slave, outcome, gap: 0.0, area: 0.0, normal: [0.0; 3], pressure: 0.0 }
        };
        let mut nodes: Vec<NodeContact> = self.nodes.iter().enumerate().map(blank).collect();
        let mut face = 0;
        let mut results = Results::default();
        self.interface.evaluate_range(0..self.points.len(), Mode::Value, &mut results, |contact| {
            let k = contact.slave - self.positions.len();
            while !self.cuts[face].points.contains(&k) {
                face += 1;
            }
            let point = &self.points[k];
            let functions = shape_of(&self.faces[face], &self.positions).functions(point.natural);
            for (corner, n) in self.faces[face].corners().iter().zip(functions) {
                let Ok(place) = self.nodes.binary_search(corner) else { continue };
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
                        for axis in 0..3 {
                            node.normal[axis] += weight * contact.point.normal[axis];
                        }
                    }
                    (reason, Outcome::None(NoContact::NothingOver { .. })) => node.outcome = reason,
                    (Outcome::None(_), _) => {}
                }
            }
        })?;
        for (k, (node, area)) in nodes.iter_mut().zip(&self.areas).enumerate() {
            if !(node.area > SMALLEST_AREA * area) {
                let outcome = match node.outcome {
                    Outcome::Contact { .. } => {
                        Outcome::None(NoContact::NothingOver { limit: self.limit_around(k) })
                    }
                    reason => reason,
                };
                *node = NodeContact { outcome, gap: 0.0, area: 0.0, normal: [0.0; 3], ..*node };
                continue;
            }
            node.gap /= node.area;
            let normal = Vector3::from(node.normal).try_normalize().filter(Vector3::is_finite);
            node.normal = normal.unwrap_or_default().into();
            node.pressure = law.force(k, node.gap, 1.0);
        }
        Ok(nodes)
    }

    /// Forces and tangents of the faces around nodes that carry pressure.
    pub(super) fn derive(
        &self,
        law: &ContactLaw<'_>,
        mode: Mode,
        contacts: &mut FaceContacts,
    ) -> Result<(), InterfaceError> {
        let pressure = |node: &usize| {
            let place = self.nodes.binary_search(node).ok()?;
            let node = &contacts.nodes[place];
            (node.pressure > 0.0).then_some(node.pressure)
        };
        let pressures: Vec<[f64; 4]> = self
            .faces
            .iter()
            .map(|face| {
                let mut own = [0.0; 4];
                for (own, node) in own.iter_mut().zip(face.corners()) {
                    *own = pressure(node).unwrap_or(0.0);
                }
                own
            })
            .collect();
        let is_loaded =
            |k: &usize| !self.cuts[*k].points.is_empty() && pressures[*k].iter().any(|&p| p > 0.0);
        let loaded: Vec<usize> = (0..self.faces.len()).filter(is_loaded).collect();
        let blocks: Vec<Vec<FaceBlock>> = self
            .runs(&loaded)
            .into_par_iter()
            .map_init(Results::default, |results, faces| self.blocks(faces, mode, &pressures, results))
            .collect::<Result<_, _>>()?;
        let mut of_face: Vec<Option<FaceBlock>> = vec![None; self.faces.len()];
        for (&k, block) in loaded.iter().zip(blocks.into_iter().flatten()) {
            contacts.missed += block.missed;
            of_face[k] = Some(block);
        }
        let carrying: Vec<(usize, NodeContact)> =
            contacts.nodes.iter().copied().enumerate().filter(|(_, node)| node.pressure > 0.0).collect();
        contacts.blocks =
            carrying.into_par_iter().map(|(k, node)| self.node_block(k, &node, law, &of_face)).collect();
        if mode >= Mode::Hessian {
            contacts.directions = loaded
                .iter()
                .filter_map(|&k| {
                    let FaceCut { rows, columns, .. } = self.cuts[k].clone();
                    Some(DirectionBlock { rows, columns, entries: of_face[k].take()?.directions })
                })
                .collect();
        }
        Ok(())
    }

    /// Faces one after another whose points are evaluated together.
    fn runs<'s>(&self, loaded: &'s [usize]) -> Vec<&'s [usize]> {
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

    /// The sums of consecutive faces.
    fn blocks(
        &self,
        faces: &[usize],
        mode: Mode,
        pressures: &[[f64; 4]],
        results: &mut Results,
    ) -> Result<Vec<FaceBlock>, InterfaceError> {
        let views: Vec<FaceView<'_>> = faces
            .iter()
            .map(|&k| FaceView {
                facet: &self.faces[k],
                shape: shape_of(&self.faces[k], &self.positions),
                carrying: &self.carriers.faces[k],
                positions: &self.positions,
                skin: &self.skin,
                face: k,
                rows: &self.cuts[k].rows,
                columns: &self.cuts[k].columns,
            })
            .collect();
        let mut blocks: Vec<FaceBlock> = views.iter().map(|view| FaceBlock::new(view, mode)).collect();
        let (Some(&first), Some(&last)) = (faces.first(), faces.last()) else { return Ok(blocks) };
        let range = self.cuts[first].points.start..self.cuts[last].points.end;
        let mut own = 0;
        self.interface.evaluate_range(range, mode, results, |contact| {
            let k = contact.slave - self.positions.len();
            while !self.cuts[faces[own]].points.contains(&k) {
                own += 1;
            }
            if contact.outcome.is_contact() {
                let point = &self.points[k];
                let over = &self.carriers.facets[point.facet as usize];
                blocks[own].add(&views[own], point, over, &contact, &pressures[faces[own]]);
            }
        })?;
        Ok(blocks)
    }

    /// The sums of the faces around a node.
    fn node_block(
        &self,
        k: usize,
        node: &NodeContact,
        law: &ContactLaw<'_>,
        of_face: &[Option<FaceBlock>],
    ) -> NodeBlock {
        let faces = || {
            self.around[k].iter().filter_map(|&face| Some((face as usize, of_face[face as usize].as_ref()?)))
        };
        let all = |of: fn(&FaceCut) -> &[u32]| {
            let mut nodes: Vec<u32> = faces().flat_map(|(face, _)| of(&self.cuts[face])).copied().collect();
            sort(&mut nodes);
            nodes
        };
        let (rows, columns) = (all(|cut| &cut.rows), all(|cut| &cut.columns));
        let mut sums = NodeBlock {
            forces: vec![0.0; 3 * rows.len()],
            gradient: vec![0.0; 3 * columns.len()],
            rows,
            columns,
            pressure: node.pressure,
            stiffness: law.penalty,
        };
        for (face, block) in faces() {
            let corner = self.faces[face].corners().iter().position(|&corner| corner == node.slave);
            let Some(corner) = corner else { continue };
            let cut = &self.cuts[face];
            add(&sums.rows, &mut sums.forces, &cut.rows, &block.forces[corner], 1.0);
            add(&sums.columns, &mut sums.gradient, &cut.columns, &block.gradients[corner], 1.0 / node.area);
        }
        sums
    }
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
