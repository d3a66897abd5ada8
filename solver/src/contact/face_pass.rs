//! Contact over the slave's faces, from its points to the entries of the stiffness.

use diffuse_contact::assembly::{ContactLaw, DofMap, Tangent};
use diffuse_contact::faces::{FaceInterface, FaceOptions, FaceRule, NodeContact};
use diffuse_contact::interface::{FrictionReport, Outcome};
use diffuse_contact::neighbourhood::Fallback;
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Mode, Point};

use super::losses::Losses;
use super::node_pass::normal_law;
use super::pass::{FrictionHistory, NodalForces, Pass, PassError, PassFriction, take_multipliers};
use super::{ContactError, InteractionOptions, SlaveState, TangentRule};
use crate::system::{BlockMatrix, Symmetry};

/// Slave faces against one master surface, or those of a surface against itself.
#[derive(Debug)]
pub struct FacePass {
    interface: FaceInterface,
    penalty: f64,
    tangent: TangentRule,
    /// Its stiffness is per area.
    friction: Option<PassFriction>,
    /// What friction remembers besides the interface's history, which is left empty here.
    history: FrictionHistory,
    dofs: DofMap,
    /// λ, one pressure per slave; none without augmentation.
    multipliers: Vec<f64>,
    /// Whether all axes of each node are prescribed.
    held: Vec<bool>,
    /// Whether more nodes couple since somebody asked.
    has_grown: bool,
    losses: Losses,
    /// The mode of the last evaluation.
    mode: Mode,
    /// What contact exerts on each coordinate.
    forces: Vec<f64>,
}

impl FacePass {
    pub fn new(
        options: &InteractionOptions,
        rule: FaceRule,
        penalty: f64,
        (master, slave): (&[Facet], &[Facet]),
        positions: &[Point],
    ) -> Result<Self, ContactError> {
        let surface = MasterSurface::new(positions, master.to_vec())
            .map_err(|source| ContactError::Master { interface: options.name.clone(), source })?;
        let named = |source| ContactError::Interface { interface: options.name.clone(), source };
        let face_options = FaceOptions::new(options.interface).with_rule(rule);
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
        let slaves = interface.slaves().len();
        Ok(Self {
            interface,
            penalty,
            tangent: options.tangent,
            friction: PassFriction::new(options, penalty)?,
            history: FrictionHistory::default(),
            dofs: DofMap::standard(positions.len()),
            multipliers: if options.augmentation.is_some() { vec![0.0; slaves] } else { Vec::new() },
            held: vec![false; positions.len()],
            has_grown: false,
            losses: Losses::new(options.self_contact),
            mode: Mode::Value,
            forces: vec![0.0; 3 * positions.len()],
        })
    }

    fn contacts(&self) -> &[NodeContact] {
        self.interface.contacts().nodes()
    }

    /// Whether nothing moves whatever force the faces around a node exert.
    fn is_held(&self, k: usize) -> bool {
        self.interface.carriers(k).all(|node| self.held[node as usize])
    }

    /// Gaps, pressures and forces by the law at the positions of the last update.
    fn apply_law(&mut self) -> Result<(), PassError> {
        let law = law(self.penalty, &self.multipliers, self.friction.as_ref());
        let contacts = self.interface.evaluate(&law, self.mode)?;
        self.forces.fill(0.0);
        contacts.add_forces(&self.dofs, &mut self.forces)?;
        Ok(())
    }
}

/// Penalty and multipliers are per area.
fn law<'a>(penalty: f64, multipliers: &'a [f64], friction: Option<&'a PassFriction>) -> ContactLaw<'a> {
    normal_law(penalty, multipliers).with_friction(friction.map(PassFriction::law))
}

impl Pass for FacePass {
    fn hold(&mut self, held: &[bool]) {
        self.held.copy_from_slice(held);
    }

    fn refresh(&mut self, positions: &[Point]) -> Result<(), PassError> {
        self.interface.refresh(positions)?;
        Ok(())
    }

    fn evaluate(&mut self, positions: &[Point], mode: Mode) -> Result<(), PassError> {
        let needs_none = self.tangent == TangentRule::GaussNewton;
        self.mode = if needs_none { mode.min(Mode::Gradient) } else { mode };
        self.has_grown |= self.interface.update(positions)?.grown;
        self.apply_law()
    }

    fn take_grown(&mut self) -> bool {
        std::mem::take(&mut self.has_grown)
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
        self.interface.contacts().for_each_tangent(tangent, |block| {
            matrix.add_rectangle(block.rows, block.columns, block.entries)
        });
        Ok(Symmetry::General)
    }

    fn begin_friction(&mut self) -> Result<(), PassError> {
        if self.friction.is_some() && !self.interface.has_history() {
            self.accept()?;
        }
        Ok(())
    }

    fn accept(&mut self) -> Result<FrictionReport, PassError> {
        let before = self.interface.history();
        let law = law(self.penalty, &self.multipliers, self.friction.as_ref());
        let report = self.interface.accept(&law)?;
        self.history.take(before, self.friction.as_ref(), &report);
        Ok(report)
    }

    fn leave_out_friction(&mut self, is_left_out: bool) {
        self.friction.iter_mut().for_each(|friction| friction.is_left_out = is_left_out);
    }

    fn friction_history(&self) -> FrictionHistory {
        FrictionHistory { anchors: self.interface.history(), ..self.history.clone() }
    }

    fn set_friction_history(&mut self, history: &FrictionHistory) -> Result<(), PassError> {
        self.interface.set_history(&history.anchors)?;
        self.history = FrictionHistory { anchors: Vec::new(), ..history.clone() };
        Ok(())
    }

    fn look_back(&mut self, history: &FrictionHistory) -> Result<bool, PassError> {
        if history.anchors_before.is_empty() {
            return Ok(false);
        }
        self.interface.set_history(&history.anchors_before)?;
        self.lasts(history.lasted);
        Ok(true)
    }

    fn dissipated(&self) -> f64 {
        self.history.dissipated
    }

    fn augment(&mut self) {
        let pressures = |(k, node): (usize, &NodeContact)| if self.is_held(k) { 0.0 } else { node.pressure };
        self.multipliers = self.contacts().iter().enumerate().map(pressures).collect();
    }

    fn lasts(&mut self, duration: f64) {
        self.friction.iter_mut().for_each(|friction| friction.duration = duration);
    }

    fn slip_error(&self) -> Result<f64, PassError> {
        let Some(friction) = self.friction.as_ref().filter(|friction| friction.is_augmented()) else {
            return Ok(0.0);
        };
        let errors = self.interface.slip_errors(&law(self.penalty, &self.multipliers, Some(friction)))?;
        let moved = errors.into_iter().enumerate().filter(|&(k, _)| !self.is_held(k));
        Ok(moved.map(|(_, error)| error).fold(0.0, f64::max))
    }

    fn augment_friction(&mut self) -> Result<(), PassError> {
        let moves: Vec<bool> = (0..self.slave_count()).map(|k| !self.is_held(k)).collect();
        let law = law(self.penalty, &self.multipliers, self.friction.as_ref());
        Ok(self.interface.augment(&law, |k| moves[k])?)
    }

    fn multipliers(&self) -> &[f64] {
        &self.multipliers
    }

    fn set_multipliers(&mut self, multipliers: &[f64]) -> Result<(), ContactError> {
        take_multipliers(&mut self.multipliers, multipliers)
    }

    fn master(&self) -> &MasterSurface {
        self.interface.master()
    }

    fn multiplier_of(&self, _slave: &SlaveState, gap: f64) -> f64 {
        self.penalty * gap
    }

    fn exchange_multipliers(&mut self, multipliers: &mut Vec<f64>) {
        std::mem::swap(&mut self.multipliers, multipliers);
    }

    fn slave_count(&self) -> usize {
        self.interface.slaves().len()
    }

    fn outcomes(&self) -> Vec<(usize, Outcome)> {
        self.contacts().iter().map(|node| (node.slave, node.outcome)).collect()
    }

    fn losses(&self) -> &Losses {
        &self.losses
    }

    fn losses_mut(&mut self) -> &mut Losses {
        &mut self.losses
    }

    fn straight(&self) -> usize {
        self.interface.straight()
    }

    fn missed(&self) -> usize {
        self.interface.contacts().missed()
    }

    fn slaves(&self) -> Box<dyn Iterator<Item = SlaveState> + '_> {
        Box::new(self.contacts().iter().enumerate().map(|(k, contact)| {
            let NodeContact {
                slave: node, outcome, gap, area, normal, friction, friction_state, slip, ..
            } = *contact;
            let force = contact.force();
            match outcome {
                // A node with nothing over its own facets may carry what is over others of its face.
                Outcome::None(reason) => SlaveState {
                    nodal_force: [0, 1, 2].map(|axis| self.forces[3 * node + axis]),
                    ..SlaveState::without(node, self.interface.areas()[k], reason)
                },
                Outcome::Contact { fallback } => SlaveState {
                    node,
                    gap: Some(gap),
                    force,
                    normal,
                    nodal_force: [0, 1, 2].map(|axis| self.forces[3 * node + axis]),
                    friction: friction.map(|traction| traction * area),
                    friction_state,
                    slip,
                    area,
                    is_linear: matches!(fallback, Fallback::Linear { .. }),
                    has_failed: false,
                    is_held: self.is_held(k),
                },
            }
        }))
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
