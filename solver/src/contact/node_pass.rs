//! Contact at slave nodes, from its pairing to the entries of the stiffness.

use std::collections::BTreeSet;

use diffuse_contact::assembly::{
    AssemblyError, ContactLaw, ContactView, DofMap, Tangent, TangentOperator, add_forces,
};
use diffuse_contact::friction::{FrictionForce, FrictionState};
use diffuse_contact::interface::{ContactInterface, ContactRef, Contacts, FrictionReport, Outcome};
use diffuse_contact::neighbourhood::Fallback;
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Mode, Point};

use super::losses::Losses;
use super::pass::{FrictionHistory, NodalForces, Pass, PassError, PassFriction, take_multipliers};
use super::{ContactError, InteractionOptions, SlaveState, TangentRule};
use crate::system::{BlockMatrix, Symmetry};

/// The law of all slaves' normal forces; no multipliers without augmentation.
pub fn normal_law(penalty: f64, multipliers: &[f64]) -> ContactLaw<'_> {
    let multipliers = (!multipliers.is_empty()).then_some(multipliers);
    ContactLaw::penalty(penalty).with_multipliers(multipliers).with_tangent(Tangent::Exact)
}

/// Slave nodes against one master surface.
#[derive(Debug)]
pub struct NodePass {
    interface: ContactInterface,
    penalty: f64,
    tangent: TangentRule,
    friction: Option<PassFriction>,
    /// Whether the tangent leaves out what is not symmetric.
    is_symmetric: bool,
    /// Whether −f M is an operator.
    is_operator: bool,
    /// What friction remembers besides the interface's history, which is left empty here.
    history: FrictionHistory,
    dofs: DofMap,
    /// λ, one per slave; none without augmentation.
    multipliers: Vec<f64>,
    /// Whether all axes of each node are prescribed.
    held: Vec<bool>,
    /// Whether lists were made anew since somebody asked.
    is_listed_anew: bool,
    losses: Losses,
    /// Forces of all nodes, or the tangent of one contact.
    values: Vec<f64>,
}

impl NodePass {
    pub fn new(
        options: &InteractionOptions,
        penalty: f64,
        master: &[Facet],
        slave: &[Facet],
        positions: &[Point],
    ) -> Result<Self, ContactError> {
        let surface = MasterSurface::new(positions, master.to_vec())
            .map_err(|source| ContactError::Master { interface: options.name.clone(), source })?;
        let named = |source| ContactError::Interface { interface: options.name.clone(), source };
        let made = if options.self_contact {
            ContactInterface::self_contact(surface, positions, options.interface)
        } else {
            let slaves: BTreeSet<usize> = slave.iter().flat_map(|facet| facet.corners()).copied().collect();
            let slaves = slaves.into_iter().collect();
            ContactInterface::new(surface, slaves, slave, positions, options.interface)
        };
        let mut interface = made.map_err(named)?;
        let count = interface.slaves().len();
        let multipliers = if options.augmentation.is_some() { vec![0.0; count] } else { Vec::new() };
        if !options.symmetry.is_empty() {
            interface.set_symmetry(&options.symmetry).map_err(named)?;
        }
        let friction = PassFriction::new(options, penalty)?;
        if friction.is_some() {
            interface.check_friction().map_err(|error| named(error.into()))?;
        }
        let dofs = DofMap::standard(positions.len());
        let tangent = options.tangent;
        Ok(Self {
            interface,
            penalty,
            tangent,
            friction,
            is_symmetric: options.friction.as_ref().is_some_and(|friction| friction.is_symmetric),
            is_operator: false,
            history: FrictionHistory::default(),
            dofs,
            multipliers,
            held: vec![false; positions.len()],
            is_listed_anew: false,
            losses: Losses::new(options.self_contact),
            values: Vec::new(),
        })
    }

    /// Whether nothing moves whatever force a contact exerts.
    fn is_held(&self, contact: &ContactRef<'_>) -> bool {
        self.held[contact.slave] && contact.nodes.iter().all(|&node| self.held[node as usize])
    }

    fn contacts(&self) -> &Contacts {
        self.interface.contacts()
    }

    /// For forces: which tangent it has makes no difference.
    fn law(&self) -> ContactLaw<'_> {
        self.with_friction(normal_law(self.penalty, &self.multipliers))
    }

    fn with_friction<'a>(&'a self, law: ContactLaw<'a>) -> ContactLaw<'a> {
        law.with_friction(self.friction.as_ref().map(PassFriction::law))
    }
}

impl Pass for NodePass {
    fn hold(&mut self, held: &[bool]) {
        self.held.copy_from_slice(held);
    }

    fn begin_friction(&mut self) -> Result<(), PassError> {
        if self.friction.is_some() && self.interface.anchors().is_none() {
            self.accept()?;
        }
        Ok(())
    }

    fn accept(&mut self) -> Result<FrictionReport, PassError> {
        let before = self.interface.history();
        let Self { interface, penalty, multipliers, friction, .. } = self;
        let friction = friction.as_ref().map(PassFriction::law);
        let report = interface.accept(&normal_law(*penalty, multipliers).with_friction(friction))?;
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

    fn refresh(&mut self, positions: &[Point]) -> Result<(), PassError> {
        self.interface.renew_pairing(positions)?;
        Ok(())
    }

    fn take_grown(&mut self) -> bool {
        std::mem::take(&mut self.is_listed_anew)
    }

    fn evaluate(&mut self, positions: &[Point], mode: Mode) -> Result<(), PassError> {
        // ε N Nᵀ needs no Hessians; friction does.
        let is_gauss_newton = self.tangent == TangentRule::GaussNewton && self.friction.is_none();
        let needs_none = self.is_operator || is_gauss_newton;
        let mode = if needs_none { mode.min(Mode::Gradient) } else { mode };
        let Self { interface, penalty, multipliers, is_listed_anew, .. } = self;
        let law = normal_law(*penalty, multipliers);
        *is_listed_anew |= interface.follow(positions)?;
        interface.evaluate_where(mode, |k, gap, area| law.force(k, gap, area) > 0.0)?;
        Ok(())
    }

    fn add_internal_forces(&mut self, forces: &mut [f64]) -> Result<usize, PassError> {
        self.values.clear();
        self.values.resize(self.dofs.equations(), 0.0);
        let mut contact_forces = std::mem::take(&mut self.values);
        let active = add_forces(self.contacts(), &self.law(), &self.dofs, &mut contact_forces)?;
        for (force, contact) in forces.iter_mut().zip(&contact_forces) {
            *force -= contact;
        }
        self.values = contact_forces;
        Ok(active)
    }

    /// The nodes of each paired slave's element.
    fn cliques(&self) -> Vec<Vec<usize>> {
        let paired = self.contacts().iter().filter(|contact| !contact.nodes.is_empty());
        let of_element = |contact: ContactRef<'_>| {
            let masters = contact.nodes.iter().map(|&node| node as usize);
            std::iter::once(contact.slave).chain(masters).collect()
        };
        paired.map(of_element).collect()
    }

    fn operate(&mut self) -> bool {
        self.is_operator = self.friction.is_none();
        self.is_operator
    }

    fn curvature(&self) -> Result<Option<TangentOperator>, PassError> {
        if !self.is_operator {
            return Ok(None);
        }
        let operator = TangentOperator::new(&self.interface, &self.law(), &self.dofs)?;
        Ok((operator.contacts() > 0).then(|| operator.curvature()))
    }

    fn add_tangent(&mut self, matrix: &mut BlockMatrix, tangent: Tangent) -> Result<Symmetry, PassError> {
        let tangent = if self.is_operator { Tangent::GaussNewton } else { tangent };
        let mut entries = std::mem::take(&mut self.values);
        let law = self.with_friction(ContactLaw::penalty(self.penalty).with_tangent(tangent));
        let mut symmetry = Symmetry::Symmetric;
        let mut nodes = Vec::new();
        for (k, contact) in self.contacts().iter().enumerate() {
            let ContactRef { slave, point, area, gradient, hessian, slip, .. } = contact;
            // One law for one contact: with its own multiplier.
            let law = law.with_multipliers(self.multipliers.get(k..=k));
            if !(contact.outcome.is_contact() && law.force(0, point.gap, area) > 0.0) {
                continue;
            }
            nodes.clear();
            nodes.push(slave);
            nodes.extend(contact.nodes.iter().map(|&node| node as usize));
            let size = gradient.len();
            let view = ContactView { gap: point.gap, area, gradient, hessian, slip };
            let friction = law.friction_of(0, point.gap, area, slip);
            let is_full = !law.is_symmetric() && friction.is_some_and(|force| force.factor_by_gap != 0.0);
            let made = if is_full {
                entries.resize(size * size, 0.0);
                law.element_system(&view, &mut [], &mut entries)
            } else {
                entries.resize(size * (size + 1) / 2, 0.0);
                law.element_tangent(&view, &mut entries)
            };
            made.map_err(|error| match error {
                // The equation is that of the element.
                AssemblyError::Overflow { what, equation: own } => {
                    AssemblyError::Overflow { what, equation: 3 * nodes[own / 3] + own % 3 }
                }
                other => other,
            })?;
            match (is_full, self.is_symmetric) {
                (false, _) => matrix.add_symmetric(&nodes, &entries, 1.0),
                (true, true) => matrix.add_symmetric(&nodes, &symmetric_part(&entries, size), 1.0),
                (true, false) => {
                    matrix.add(&nodes, &entries, 1.0);
                    symmetry = Symmetry::General;
                }
            }
        }
        self.values = entries;
        Ok(symmetry)
    }

    fn augment(&mut self) {
        let law = self.law();
        let forces = |k| {
            let contact = self.contacts().get(k);
            let is_moved = contact.outcome.is_contact() && !self.is_held(&contact);
            if is_moved { law.force(k, contact.point.gap, contact.area) } else { 0.0 }
        };
        self.multipliers = (0..self.multipliers.len()).map(forces).collect();
    }

    fn lasts(&mut self, duration: f64) {
        self.friction.iter_mut().for_each(|friction| friction.duration = duration);
    }

    fn slip_error(&self) -> Result<f64, PassError> {
        if !self.friction.as_ref().is_some_and(PassFriction::is_augmented) {
            return Ok(0.0);
        }
        let errors = self.interface.slip_errors(&self.law())?;
        let moved = errors.into_iter().enumerate().filter(|&(k, _)| !self.is_held(&self.contacts().get(k)));
        Ok(moved.map(|(_, error)| error).fold(0.0, f64::max))
    }

    fn augment_friction(&mut self) -> Result<(), PassError> {
        let moves: Vec<bool> = self.contacts().iter().map(|contact| !self.is_held(&contact)).collect();
        let Self { interface, penalty, multipliers, friction, .. } = self;
        let friction = friction.as_ref().map(PassFriction::law);
        let law = normal_law(*penalty, multipliers).with_friction(friction);
        Ok(interface.augment(&law, |k| moves[k])?)
    }

    fn master(&self) -> &MasterSurface {
        self.interface.master()
    }

    fn multiplier_of(&self, slave: &SlaveState, gap: f64) -> f64 {
        self.penalty * slave.area * gap
    }

    fn exchange_multipliers(&mut self, multipliers: &mut Vec<f64>) {
        std::mem::swap(&mut self.multipliers, multipliers);
    }

    fn slave_count(&self) -> usize {
        self.interface.slaves().len()
    }

    fn outcomes(&self) -> Vec<(usize, Outcome)> {
        self.contacts().iter().map(|contact| (contact.slave, contact.outcome)).collect()
    }

    fn losses(&self) -> &Losses {
        &self.losses
    }

    fn losses_mut(&mut self) -> &mut Losses {
        &mut self.losses
    }

    fn multipliers(&self) -> &[f64] {
        &self.multipliers
    }

    fn set_multipliers(&mut self, multipliers: &[f64]) -> Result<(), ContactError> {
        take_multipliers(&mut self.multipliers, multipliers)
    }

    fn add_nodal_forces(&self, all: &mut NodalForces) {
        let law = self.law();
        for (k, contact) in
            self.contacts().iter().enumerate().filter(|(_, contact)| contact.outcome.is_contact())
        {
            let force = law.force(k, contact.point.gap, contact.area);
            let (friction, of_slip) = friction_of(&law, k, &contact);
            let factor = friction.map_or(0.0, |friction| friction.factor);
            let nodes = std::iter::once(contact.slave).chain(contact.nodes.iter().map(|&node| node as usize));
            let gradients = contact.gradient.as_chunks::<3>().0;
            for (local, (node, gradient)) in nodes.zip(gradients).enumerate() {
                let slip = of_slip.get(local).copied().unwrap_or([0.0; 3]);
                for axis in 0..3 {
                    let friction = -factor * slip[axis];
                    all.forces[node][axis] += force * gradient[axis] + friction;
                    all.friction[node][axis] += friction;
                }
            }
        }
    }

    fn slaves(&self) -> Box<dyn Iterator<Item = SlaveState> + '_> {
        let law = self.law();
        Box::new(self.contacts().iter().enumerate().map(move |(k, contact)| {
            let ContactRef { slave: node, outcome, point, area, gradient, .. } = contact;
            match outcome {
                Outcome::Contact { fallback } => {
                    let is_linear = matches!(fallback, Fallback::Linear { .. });
                    let force = law.force(k, point.gap, area);
                    let (known, of_slip) = friction_of(&law, k, &contact);
                    let factor = known.map_or(0.0, |known| known.factor);
                    let friction = of_slip.first().map_or([0.0; 3], |slip| slip.map(|slip| -factor * slip));
                    let nodal_force =
                        [0, 1, 2].map(|axis| gradient.get(axis).map_or(0.0, |n| force * n) + friction[axis]);
                    let slipped = contact.slip.map_or(0.0, |slip| (2.0 * slip.half_square).sqrt());
                    let slip = known.map_or(0.0, |known| known.share * slipped);
                    let friction_state = known.map_or(FrictionState::Open, |known| known.state);
                    let (gap, is_held) = (Some(point.gap), self.is_held(&contact));
                    let normal = point.normal;
                    let has_failed = false;
                    SlaveState {
                        node,
                        gap,
                        force,
                        normal,
                        nodal_force,
                        friction,
                        friction_state,
                        slip,
                        area,
                        is_linear,
                        has_failed,
                        is_held,
                    }
                }
                Outcome::None(reason) => SlaveState::without(node, area, reason),
            }
        }))
    }
}

/// The friction of a contact, −c ∇q, with ∇q by node; nothing without.
fn friction_of<'a>(
    law: &ContactLaw<'_>,
    k: usize,
    contact: &ContactRef<'a>,
) -> (Option<FrictionForce>, &'a [[f64; 3]]) {
    let force = law.friction_of(k, contact.point.gap, contact.area, contact.slip);
    (force, contact.slip.map_or(&[], |slip| slip.gradient.as_chunks().0))
}

/// The packed lower triangle of ½ (K + Kᵀ).
fn symmetric_part(matrix: &[f64], size: usize) -> Vec<f64> {
    let entry = |p: usize, q: usize| 0.5 * (matrix[p * size + q] + matrix[q * size + p]);
    (0..size).flat_map(|p| (0..=p).map(move |q| entry(p, q))).collect()
}
