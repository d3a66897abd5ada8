//! Contact at slave nodes, from its pairing to the entries of the stiffness.

use std::collections::BTreeSet;

use diffuse_contact::assembly::{
    AssemblyError, ContactLaw, ContactView, Tangent, TangentOperator, add_forces,
};
use diffuse_contact::friction::{FrictionForce, FrictionState};
use diffuse_contact::interface::{
    ContactInterface, ContactRef, Contacts, FrictionReport, InterfaceError, Outcome,
};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Mode, Point};

use super::pass::{NodalForces, Pass, PassError, PassState, by_interface};
use super::tracks::Finder;
use super::{ContactError, InteractionOptions, SlaveState, TangentRule};
use crate::system::{BlockMatrix, Symmetry};

/// Slave nodes against one master surface.
#[derive(Debug)]
pub struct NodePass {
    interface: ContactInterface,
    state: PassState,
    /// Whether the slaves are the master's own nodes.
    is_own: bool,
    /// Whether the tangent leaves out what is not symmetric.
    is_symmetric: bool,
    /// Whether all of the tangent but ε N Nᵀ is an operator.
    is_operator: bool,
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
        if !options.symmetry.is_empty() {
            interface.set_symmetry(&options.symmetry).map_err(named)?;
        }
        let state = PassState::new(options, penalty, interface.slaves().len(), positions.len())?;
        if state.friction.is_some() {
            interface.check_friction().map_err(|error| named(error.into()))?;
        }
        let is_symmetric = options.friction.as_ref().is_some_and(|friction| friction.is_symmetric);
        let is_own = options.self_contact;
        Ok(Self { interface, state, is_own, is_symmetric, is_operator: false, values: Vec::new() })
    }

    fn contacts(&self) -> &Contacts {
        self.interface.contacts()
    }

    /// What the contact of the `k`-th slave exerts on it and on its masters, and the part of it that is friction.
    fn for_each_force(&self, law: &ContactLaw<'_>, k: usize, mut f: impl FnMut(usize, Point, Point)) {
        let contact = self.contacts().get(k);
        if !contact.outcome.is_contact() {
            return;
        }
        let force = law.force(k, contact.point.gap, contact.area);
        let (friction, of_slip) = friction_of(law, k, &contact);
        let factor = friction.map_or(0.0, |friction| friction.factor);
        let nodes = std::iter::once(contact.slave).chain(contact.nodes.iter().map(|&node| node as usize));
        for (local, (node, gradient)) in nodes.zip(contact.gradient.as_chunks::<3>().0).enumerate() {
            let friction = of_slip.get(local).map_or([0.0; 3], |slip| slip.map(|slip| -factor * slip));
            f(node, [0, 1, 2].map(|axis| force * gradient[axis] + friction[axis]), friction);
        }
    }
}

impl Pass for NodePass {
    by_interface!();

    fn refresh(&mut self, positions: &[Point]) -> Result<(), PassError> {
        self.interface.renew_pairing(positions)?;
        Ok(())
    }

    fn evaluate(&mut self, positions: &[Point], mode: Mode) -> Result<(), PassError> {
        // ε N Nᵀ needs no Hessians; friction does.
        let is_gauss_newton = self.state.tangent == TangentRule::GaussNewton && self.state.friction.is_none();
        let needs_none = self.is_operator || is_gauss_newton;
        let mode = if needs_none { mode.min(Mode::Gradient) } else { mode };
        self.state.has_grown |= self.interface.follow(positions)?;
        let law = self.state.normal_law();
        self.interface.evaluate_where(mode, |k, gap, area| law.force(k, gap, area) > 0.0)?;
        Ok(())
    }

    fn add_internal_forces(&mut self, forces: &mut [f64]) -> Result<usize, PassError> {
        self.values.clear();
        self.values.resize(self.state.dofs.equations(), 0.0);
        let Self { interface, state, values, .. } = self;
        let active = add_forces(interface.contacts(), &state.law(), &state.dofs, values)?;
        for (force, contact) in forces.iter_mut().zip(values) {
            *force -= *contact;
        }
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
        self.is_operator = !self.is_symmetric;
        self.is_operator
    }

    fn curvature(&self, tangent: Tangent) -> Result<Option<TangentOperator>, PassError> {
        let is_some = tangent == Tangent::Exact || self.state.friction.is_some();
        if !(self.is_operator && is_some) {
            return Ok(None);
        }
        let law = self.state.law().with_tangent(tangent);
        let operator = TangentOperator::new(&self.interface, &law, &self.state.dofs)?;
        Ok((operator.contacts() > 0).then(|| operator.curvature()))
    }

    fn add_tangent(&mut self, matrix: &mut BlockMatrix, tangent: Tangent) -> Result<Symmetry, PassError> {
        let entries = &mut self.values;
        let whole = self.state.with_friction(ContactLaw::penalty(self.state.penalty()).with_tangent(tangent));
        let law = if self.is_operator {
            whole.with_friction(None).with_tangent(Tangent::GaussNewton)
        } else {
            whole
        };
        let mut symmetry = Symmetry::Symmetric;
        let mut nodes = Vec::new();
        for (k, contact) in self.interface.contacts().iter().enumerate() {
            let ContactRef { slave, point, area, gradient, hessian, slip, .. } = contact;
            // One law for one contact: with its own multiplier.
            let law = law.with_multipliers(self.state.multipliers.get(k..=k));
            if !(contact.outcome.is_contact() && law.force(0, point.gap, area) > 0.0) {
                continue;
            }
            nodes.clear();
            nodes.push(slave);
            nodes.extend(contact.nodes.iter().map(|&node| node as usize));
            let size = gradient.len();
            let view = ContactView { gap: point.gap, area, gradient, hessian, slip };
            let whole = whole.with_multipliers(self.state.multipliers.get(k..=k));
            let friction = whole.friction_of(0, point.gap, area, slip);
            let is_skew = !whole.is_symmetric() && friction.is_some_and(|force| force.factor_by_gap != 0.0);
            if is_skew && !self.is_symmetric {
                symmetry = Symmetry::General;
            }
            let is_full = is_skew && !self.is_operator;
            let made = if is_full {
                entries.resize(size * size, 0.0);
                law.element_system(&view, &mut [], entries)
            } else {
                entries.resize(size * (size + 1) / 2, 0.0);
                law.element_tangent(&view, entries)
            };
            made.map_err(|error| match error {
                // The equation is that of the element.
                AssemblyError::Overflow { what, equation: own } => {
                    AssemblyError::Overflow { what, equation: 3 * nodes[own / 3] + own % 3 }
                }
                other => other,
            })?;
            match (is_full, self.is_symmetric) {
                (false, _) => matrix.add_symmetric(&nodes, entries),
                (true, true) => matrix.add_symmetric(&nodes, &symmetric_part(entries, size)),
                (true, false) => matrix.add(&nodes, entries),
            }
        }
        Ok(symmetry)
    }

    fn is_held(&self, k: usize) -> bool {
        let contact = self.contacts().get(k);
        self.state.held[contact.slave] && contact.nodes.iter().all(|&node| self.state.held[node as usize])
    }

    fn augment(&mut self) {
        let law = self.state.law();
        let forces = |k| {
            let contact = self.contacts().get(k);
            let is_moved = contact.outcome.is_contact() && !self.is_held(k);
            if is_moved { law.force(k, contact.point.gap, contact.area) } else { 0.0 }
        };
        self.state.multipliers = (0..self.state.multipliers.len()).map(forces).collect();
    }

    fn finder(&self) -> Finder<'_> {
        if self.is_own { Finder::ClosestOwn } else { Finder::Closest }
    }

    fn multiplier_of(&self, slave: &SlaveState, gap: f64) -> f64 {
        self.state.penalty() * slave.area * gap
    }

    fn outcomes(&self) -> Vec<(usize, Outcome)> {
        self.contacts().iter().map(|contact| (contact.slave, contact.outcome)).collect()
    }

    fn add_nodal_forces(&self, all: &mut NodalForces) {
        let law = self.state.law();
        for k in 0..self.slave_count() {
            self.for_each_force(&law, k, |node, force, friction| {
                for axis in 0..3 {
                    all.forces[node][axis] += force[axis];
                    all.friction[node][axis] += friction[axis];
                }
            });
        }
    }

    fn add_held_forces(&self, forces: &mut [f64]) {
        let law = self.state.law();
        for k in (0..self.slave_count()).filter(|&k| self.is_held(k)) {
            self.for_each_force(&law, k, |node, force, _| {
                (0..3).for_each(|axis| forces[3 * node + axis] -= force[axis]);
            });
        }
    }

    fn slaves(&self) -> Box<dyn Iterator<Item = SlaveState> + '_> {
        let law = self.state.law();
        Box::new(self.contacts().iter().enumerate().map(move |(k, contact)| {
            let ContactRef { slave: node, outcome, point, area, gradient, .. } = contact;
            match outcome {
                Outcome::Contact { fallback } => {
                    let force = law.force(k, point.gap, area);
                    let (known, of_slip) = friction_of(&law, k, &contact);
                    let factor = known.map_or(0.0, |known| known.factor);
                    let friction = of_slip.first().map_or([0.0; 3], |slip| slip.map(|slip| -factor * slip));
                    let nodal_force =
                        [0, 1, 2].map(|axis| gradient.get(axis).map_or(0.0, |n| force * n) + friction[axis]);
                    let slipped = contact.slip.map_or(0.0, |slip| slip.since_stuck);
                    let slip = known.map_or(0.0, |known| known.share * slipped);
                    let friction_state = known.map_or(FrictionState::Open, |known| known.state);
                    SlaveState {
                        node,
                        gap: Some(point.gap),
                        average_gap: point.gap,
                        force,
                        normal: point.normal,
                        nodal_force,
                        friction,
                        friction_state,
                        slip,
                        area,
                        fallback,
                        has_failed: false,
                        is_held: self.is_held(k),
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
