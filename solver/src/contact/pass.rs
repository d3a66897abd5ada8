//! One contact interface, from its pairing to the entries of the stiffness.

use std::collections::BTreeSet;

use diffuse_contact::assembly::{AssemblyError, ContactLaw, CsrPattern, DofMap, Tangent, add_residual};
use diffuse_contact::interface::{ContactInterface, ContactRef, Contacts, InterfaceError};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Mode, Point};

use super::{ContactError, InteractionOptions, SlavePairing, SlaveState};
use crate::system::{BlockMatrix, BlockPattern};

/// A step of a pass that failed.
#[derive(Debug)]
pub enum PassError {
    Interface(InterfaceError),
    Assembly(AssemblyError),
}

impl PassError {
    /// The error with the interaction's name.
    pub fn of(self, name: &str) -> ContactError {
        let interface = name.to_owned();
        match self {
            Self::Interface(source) => ContactError::Interface { interface, source },
            Self::Assembly(source) => ContactError::Assembly { interface, source },
        }
    }
}

impl From<InterfaceError> for PassError {
    fn from(error: InterfaceError) -> Self {
        Self::Interface(error)
    }
}

impl From<AssemblyError> for PassError {
    fn from(error: AssemblyError) -> Self {
        Self::Assembly(error)
    }
}

/// Slave nodes against one master surface.
#[derive(Debug)]
pub struct Pass {
    interface: ContactInterface,
    penalty: f64,
    tangent: Tangent,
    dofs: DofMap,
    /// λ, one per slave; none without augmentation.
    multipliers: Vec<f64>,
    /// The entries of the tangent for the pairing of the moment, and where they lie in the stiffness.
    entries: Option<(CsrPattern, Vec<usize>)>,
    values: Vec<f64>,
}

impl Pass {
    pub fn new(
        options: &InteractionOptions,
        penalty: f64,
        master: &[Facet],
        slave: &[Facet],
        positions: &[Point],
    ) -> Result<Self, ContactError> {
        let surface = MasterSurface::new(positions, master.to_vec())
            .map_err(|source| ContactError::Master { interface: options.name.clone(), source })?;
        let slaves: BTreeSet<usize> = slave.iter().flat_map(|facet| facet.corners()).copied().collect();
        let slaves: Vec<usize> = slaves.into_iter().collect();
        let multipliers = if options.augmentation.is_some() { vec![0.0; slaves.len()] } else { Vec::new() };
        let interface = ContactInterface::new(surface, slaves, slave, positions, options.interface)
            .map_err(|source| ContactError::Interface { interface: options.name.clone(), source })?;
        let dofs = DofMap::standard(positions.len());
        let tangent = options.tangent;
        Ok(Self { interface, penalty, tangent, dofs, multipliers, entries: None, values: Vec::new() })
    }

    fn contacts(&self) -> &Contacts {
        self.interface.contacts()
    }

    fn law(&self) -> ContactLaw<'_> {
        let multipliers = (!self.multipliers.is_empty()).then_some(&self.multipliers[..]);
        ContactLaw { penalty: self.penalty, multipliers, tangent: self.tangent }
    }

    pub fn refresh(&mut self, positions: &[Point]) -> Result<(), PassError> {
        self.interface.refresh_pairing(positions)?;
        self.entries = None;
        Ok(())
    }

    pub fn evaluate(&mut self, positions: &[Point], mode: Mode) -> Result<(), PassError> {
        self.interface.update(positions)?;
        self.interface.evaluate(mode)?;
        Ok(())
    }

    /// Subtracts the contact forces; the number of contacts that carry one.
    pub fn add_internal_forces(&mut self, forces: &mut [f64]) -> Result<usize, PassError> {
        self.values.clear();
        self.values.resize(self.dofs.equations(), 0.0);
        let mut contact_forces = std::mem::take(&mut self.values);
        let active = add_residual(self.contacts(), &self.law(), &self.dofs, &mut contact_forces)?;
        for (force, contact) in forces.iter_mut().zip(&contact_forces) {
            *force -= contact;
        }
        self.values = contact_forces;
        Ok(active)
    }

    /// The nodes of each paired slave's element.
    pub fn cliques(&self) -> impl Iterator<Item = Vec<usize>> {
        self.contacts().iter().filter(|contact| !contact.nodes.is_empty()).map(|contact| {
            let masters = contact.nodes.iter().map(|&node| node as usize);
            std::iter::once(contact.slave).chain(masters).collect()
        })
    }

    /// Looks up the places of the tangent's entries.
    pub fn bind(&mut self, pattern: &BlockPattern) -> Result<(), PassError> {
        let own = CsrPattern::union(self.contacts(), &self.dofs)?;
        let mut places = Vec::with_capacity(own.entries());
        for (row, ends) in own.row_offsets().windows(2).enumerate() {
            for &column in &own.columns()[ends[0]..ends[1]] {
                let block = pattern.block(row / 3, column / 3).expect("the pattern holds the cliques");
                places.push(9 * block + 3 * (row % 3) + column % 3);
            }
        }
        self.entries = Some((own, places));
        Ok(())
    }

    pub fn add_tangent(&mut self, matrix: &mut BlockMatrix) -> Result<(), PassError> {
        let Some((pattern, places)) = &self.entries else { return Ok(()) };
        let mut values = std::mem::take(&mut self.values);
        values.resize(pattern.entries(), 0.0);
        pattern.fill(self.contacts(), &self.law(), &mut values)?;
        let entries = matrix.entries_mut();
        for (&place, value) in places.iter().zip(&values) {
            entries[place] += value;
        }
        self.values = values;
        Ok(())
    }

    /// λ ← max(0, λ − ε g)
    pub fn augment(&mut self) {
        let law = self.law();
        let forces = |k| {
            let contact = self.contacts().get(k);
            if contact.outcome.is_contact() { law.force(k, contact.point.gap, contact.area) } else { 0.0 }
        };
        self.multipliers = (0..self.multipliers.len()).map(forces).collect();
    }

    pub fn multipliers(&self) -> &[f64] {
        &self.multipliers
    }

    pub fn set_multipliers(&mut self, multipliers: &[f64]) -> Result<(), ContactError> {
        let (found, expected) = (multipliers.len(), self.multipliers.len());
        if found != expected {
            return Err(ContactError::OtherPasses { found, expected });
        }
        self.multipliers.copy_from_slice(multipliers);
        Ok(())
    }

    /// What the next refresh may keep, slave by slave; nothing where every refresh pairs anew.
    pub fn pairings(&self) -> Vec<Option<SlavePairing>> {
        if self.interface.options().hysteresis == 0.0 {
            return Vec::new();
        }
        self.interface.kept_pairings().into_iter().map(|kept| kept.map(SlavePairing::from)).collect()
    }

    pub fn set_pairings(&mut self, pairings: &[Option<SlavePairing>]) -> Result<(), PassError> {
        if self.interface.options().hysteresis == 0.0 {
            return Ok(());
        }
        let kept: Vec<_> = pairings.iter().map(|saved| saved.as_ref().map(Into::into)).collect();
        self.entries = None;
        Ok(self.interface.set_kept_pairings(&kept)?)
    }

    /// Adds what each contact exerts on its slave and its masters, f N, at the last evaluation.
    pub fn add_nodal_forces(&self, forces: &mut [Point]) {
        let law = self.law();
        for (k, contact) in
            self.contacts().iter().enumerate().filter(|(_, contact)| contact.outcome.is_contact())
        {
            let force = law.force(k, contact.point.gap, contact.area);
            let nodes = std::iter::once(contact.slave).chain(contact.nodes.iter().map(|&node| node as usize));
            for (node, gradient) in nodes.zip(contact.gradient.chunks_exact(3)) {
                for (sum, n) in forces[node].iter_mut().zip(gradient) {
                    *sum += force * n;
                }
            }
        }
    }

    /// The contact of every slave node at the last evaluation.
    pub fn slaves(&self) -> impl Iterator<Item = SlaveState> {
        let law = self.law();
        self.contacts().iter().enumerate().map(move |(k, contact)| {
            let ContactRef { slave: node, outcome, point, area, gradient, .. } = contact;
            if outcome.is_contact() {
                let force = law.force(k, point.gap, area);
                let [x, y, z] = [0, 1, 2].map(|axis| gradient.get(axis).map_or(0.0, |n| force * n));
                SlaveState {
                    node,
                    gap: Some(point.gap),
                    force,
                    normal: point.normal,
                    nodal_force: [x, y, z],
                    area,
                }
            } else {
                SlaveState { node, gap: None, force: 0.0, normal: [0.0; 3], nodal_force: [0.0; 3], area }
            }
        })
    }
}
