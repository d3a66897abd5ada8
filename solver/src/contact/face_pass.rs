//! Contact over the slave's faces, from its points to the entries of the stiffness.

use diffuse_contact::assembly::Tangent;
use diffuse_contact::faces::{
    FaceCover, FaceInterface, FaceOptions, FacePressures, IntegrationPoint, NodeContact,
};
use diffuse_contact::interface::{FrictionReport, InterfaceError, Outcome};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Mode, Point};

use super::pass::{NodalForces, Pass, PassError, PassState, Pressed, by_interface};
use super::tracks::Finder;
use super::{ContactError, InteractionOptions, SlaveState, TangentRule};
use crate::system::{BlockMatrix, Symmetry};

/// Slave faces against one master surface, or those of a surface against itself.
#[derive(Debug)]
pub struct FacePass {
    interface: FaceInterface,
    /// What the faces lay over when the increment began.
    cover: FaceCover,
    /// Penalty, multipliers and stiffness of friction are per area.
    state: PassState,
    /// What contact exerts on each coordinate.
    forces: Vec<f64>,
}

impl FacePass {
    pub fn new(
        options: &InteractionOptions,
        face_options: FaceOptions,
        penalty: f64,
        (master, slave): (&[Facet], &[Facet]),
        positions: &[Point],
    ) -> Result<Self, ContactError> {
        let surface = MasterSurface::new(positions, master.to_vec())
            .map_err(|source| ContactError::Master { interface: options.name.clone(), source })?;
        let named = |source| ContactError::Interface { interface: options.name.clone(), source };
        let mut interface = if options.self_contact {
            FaceInterface::self_contact(surface, positions, face_options)
        } else {
            FaceInterface::new(surface, slave, positions, face_options)
        }
        .map_err(named)?;
        if !options.symmetry.is_empty() {
            interface.set_symmetry(&options.symmetry).map_err(named)?;
        }
        if !options.quadratic_faces.is_empty() {
            interface.set_quadratic_faces(&options.quadratic_faces).map_err(named)?;
        }
        let state = PassState::new(options, penalty, interface.slaves().len(), positions.len())?;
        let (cover, forces) = (FaceCover::default(), vec![0.0; 3 * positions.len()]);
        Ok(Self { interface, cover, state, forces })
    }

    fn contacts(&self) -> &[NodeContact] {
        self.interface.contacts().nodes()
    }
}

impl Pass for FacePass {
    by_interface!();

    fn refresh(&mut self, positions: &[Point]) -> Result<(), PassError> {
        self.interface.refresh(positions)?;
        Ok(())
    }

    fn evaluate(&mut self, positions: &[Point], mode: Mode) -> Result<(), PassError> {
        let needs_none = self.state.tangent == TangentRule::GaussNewton;
        let mode = if needs_none { mode.min(Mode::Gradient) } else { mode };
        self.state.has_grown |= self.interface.update(positions)?.grown;
        let contacts = self.interface.evaluate(&self.state.law(), mode)?;
        self.forces.fill(0.0);
        contacts.add_forces(&self.state.dofs, &mut self.forces)?;
        Ok(())
    }

    fn cliques(&self) -> Vec<Vec<usize>> {
        let nodes = |clique: &[u32]| clique.iter().map(|&node| node as usize).collect();
        self.interface.cliques().map(nodes).collect()
    }

    fn add_internal_forces(&mut self, forces: &mut [f64]) -> Result<usize, PassError> {
        for (force, contact) in forces.iter_mut().zip(&self.forces) {
            *force -= contact;
        }
        Ok(self.interface.contacts().active())
    }

    fn add_tangent(&mut self, matrix: &mut BlockMatrix, tangent: Tangent) -> Result<Symmetry, PassError> {
        let mut symmetry = Symmetry::Symmetric;
        self.interface.contacts().for_each_tangent(tangent, |block| {
            symmetry = Symmetry::General;
            matrix.add_rectangle(block.rows, block.columns, block.entries)
        })?;
        Ok(symmetry)
    }

    fn is_held(&self, k: usize) -> bool {
        self.interface.carriers(k).all(|node| self.state.held[node as usize])
    }

    fn augment(&mut self) {
        let pressures = |(k, node): (usize, &NodeContact)| if self.is_held(k) { 0.0 } else { node.pressure };
        self.state.multipliers = self.contacts().iter().enumerate().map(pressures).collect();
    }

    fn finder(&self) -> Finder<'_> {
        Finder::Faces(&self.interface, &self.cover)
    }

    fn remember(&mut self) {
        self.cover = self.interface.cover();
    }

    fn multiplier_of(&self, _slave: &SlaveState, gap: f64) -> f64 {
        self.state.penalty() * gap
    }

    fn has_point_pressures(&self) -> bool {
        self.interface.options().pressures == FacePressures::Points
    }

    fn pressed(&self) -> Pressed {
        let mut sum = Pressed::default();
        for point in self.interface.integration_points().unwrap_or_default() {
            if point.pressure > 0.0 {
                sum.area += point.area;
                sum.stored += 0.5 * point.area * point.pressure * (-point.gap).max(0.0);
            }
        }
        sum
    }

    fn outcomes(&self) -> Vec<(usize, Outcome)> {
        self.contacts().iter().map(|node| (node.slave, node.outcome)).collect()
    }

    fn straight(&self) -> usize {
        self.interface.straight()
    }

    fn missed(&self) -> usize {
        self.interface.contacts().missed()
    }

    fn slaves(&self) -> Box<dyn Iterator<Item = SlaveState> + '_> {
        Box::new(self.contacts().iter().enumerate().map(|(k, contact)| {
            let NodeContact { slave: node, outcome, area, normal, friction, friction_state, slip, .. } =
                *contact;
            let force = contact.force();
            let is_again = k > 0 && self.contacts()[k - 1].slave == node;
            let of_node = || [0, 1, 2].map(|axis| self.forces[3 * node + axis]);
            let nodal_force = if is_again { [0.0; 3] } else { of_node() };
            match outcome {
                // A node with nothing over its own facets may carry what is over others of its face.
                Outcome::None(reason) => {
                    SlaveState { nodal_force, ..SlaveState::without(node, self.interface.areas()[k], reason) }
                }
                Outcome::Contact { fallback } => SlaveState {
                    node,
                    gap: Some(if self.has_point_pressures() { contact.smallest_gap } else { contact.gap }),
                    average_gap: contact.gap,
                    force,
                    normal,
                    nodal_force,
                    friction: friction.map(|traction| traction * area),
                    friction_state,
                    slip,
                    area,
                    fallback,
                    has_failed: false,
                    is_held: self.is_held(k),
                },
            }
        }))
    }

    fn integration_points(&self) -> Result<Vec<IntegrationPoint>, InterfaceError> {
        self.interface.integration_points()
    }

    /// Of the nodes that no contact acts on but those that can move nothing.
    fn add_held_forces(&self, forces: &mut [f64]) {
        let places = || (0..self.slave_count()).filter(|&k| self.contacts()[k].pressure > 0.0);
        let mut held: Vec<bool> = Vec::new();
        for k in places().filter(|&k| self.is_held(k)) {
            held.resize(self.state.held.len(), false);
            self.interface.carriers(k).for_each(|node| held[node as usize] = true);
        }
        if held.is_empty() {
            return;
        }
        for k in places().filter(|&k| !self.is_held(k)) {
            self.interface.carriers(k).for_each(|node| held[node as usize] = false);
        }
        for (k, _) in held.iter().enumerate().filter(|(_, is_held)| **is_held) {
            (3 * k..3 * k + 3).for_each(|freedom| forces[freedom] -= self.forces[freedom]);
        }
    }

    fn add_nodal_forces(&self, all: &mut NodalForces) {
        for (sum, force) in all.forces.iter_mut().zip(self.forces.as_chunks::<3>().0) {
            for axis in 0..3 {
                sum[axis] += force[axis];
            }
        }
        self.interface.contacts().for_each_friction(|node, force| {
            let sum = &mut all.friction[node as usize];
            (0..3).for_each(|axis| sum[axis] += force[axis]);
        });
    }
}
