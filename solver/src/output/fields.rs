//! Fields at the nodes.

use diffuse_contact::FrictionState;
use serde::{Deserialize, Serialize};

use super::loads::Loads;
use crate::contact::{Interaction, SlaveState};
use crate::solid::SolidError;
use crate::statics::{Problem, State};

/// What contact means at a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum ContactStatus {
    /// No slave.
    None = 0,
    /// A slave that faces no master: too far away, or beyond a border.
    Unpaired = 1,
    /// A slave without force.
    Open = 2,
    /// A slave that carries force.
    Closed = 3,
    /// A slave that faces masters but has no contact element: they carry no fit, or the fit has no foot.
    Failed = 4,
}

/// Friction at the nodes of slave surfaces, zero elsewhere.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrictionFields {
    /// Way from the anchor since the slave touched, length: of one that slides, what it slid in the increment and its elastic slip. With
    /// augmentation from where it stuck.
    pub slip: Vec<f64>,
    /// At the nodes of slave surfaces: friction on the node over the area of [`contact_pressure`](Fields::contact_pressure), force per area.
    /// On faces of second order: by its average slip.
    pub traction: Vec<[f64; 3]>,
    /// 0 open or no slave, 1 stick, 2 slip.
    pub status: Vec<i32>,
}

impl FrictionFields {
    fn zero(count: usize) -> Self {
        Self { slip: vec![0.0; count], traction: vec![[0.0; 3]; count], status: vec![0; count] }
    }

    fn add(&mut self, slave: &SlaveState) {
        let status = match slave.friction_state {
            FrictionState::Open => 0,
            FrictionState::Stick => 1,
            FrictionState::Slip => 2,
        };
        let node = slave.node;
        self.status[node] = self.status[node].max(status);
        self.slip[node] = self.slip[node].max(slave.slip);
    }

    fn at_nodes(&self, nodes: &[usize]) -> Self {
        Self {
            slip: nodes.iter().map(|&node| self.slip[node]).collect(),
            traction: nodes.iter().map(|&node| self.traction[node]).collect(),
            status: nodes.iter().map(|&node| self.status[node]).collect(),
        }
    }
}

/// Stresses and plastic strains at all nodes; at nodes that bodies share the mean.
#[derive(Clone, Debug, Default)]
pub struct Stresses {
    /// Cauchy stress xx, yy, zz, xy, yz, xz, force per area.
    pub stress: Vec<[f64; 6]>,
    /// Von Mises' stress, force per area.
    pub von_mises: Vec<f64>,
    /// Equivalent plastic strain.
    pub plastic_strain: Vec<f64>,
}

/// Fields at all nodes; zero where they do not exist.
#[derive(Clone, Debug, Default)]
pub struct Fields {
    /// Displacement, length.
    pub displacement: Vec<[f64; 3]>,
    /// Stresses and plastic strains, if they were asked for.
    pub stresses: Option<Stresses>,
    /// Gap of slaves, length: negative where they penetrate.
    pub contact_gap: Vec<f64>,
    /// At the nodes of slave surfaces (of both surfaces, with two passes): the normal part of the contact force on the node, as it
    /// enters equilibrium, over its area at the start; force per area. The area is the tributary one, over faces the part of it over the
    /// master. Where several interfaces press on a node it is what all of them share. On faces of second order: by its average gap.
    pub contact_pressure: Vec<f64>,
    /// A [`ContactStatus`].
    pub contact_status: Vec<i32>,
    /// Polynomial degree of the smooth surface under a slave: 2, 1 where its masters carry no more, 0 without one. Of several the least.
    pub contact_basis: Vec<i32>,
    /// If an interaction has friction.
    pub friction: Option<FrictionFields>,
}

impl Stresses {
    fn of(problem: &Problem, state: &State) -> Result<Self, SolidError> {
        let count = state.positions.len();
        let mut fields = Self {
            stress: vec![[0.0; 6]; count],
            von_mises: vec![0.0; count],
            plastic_strain: vec![0.0; count],
        };
        let recovery = problem.solid().recover(&state.positions, &state.points)?;
        let mut bodies_at = vec![0.0_f64; count];
        for body in &recovery.bodies {
            for (&node, field) in body.nodes.iter().zip(&body.fields) {
                bodies_at[node] += 1.0;
                let share = 1.0 / bodies_at[node];
                let mean = |old: &mut f64, new: f64| *old += share * (new - *old);
                for (old, new) in fields.stress[node].iter_mut().zip(field.stress) {
                    mean(old, new);
                }
                mean(&mut fields.von_mises[node], field.von_mises);
                mean(&mut fields.plastic_strain[node], field.equivalent_plastic_strain);
            }
        }
        Ok(fields)
    }
}

impl Fields {
    /// The fields at the end of an increment, without stresses.
    pub fn of(problem: &Problem, state: &State) -> Self {
        let mut fields = Self::without_contact(problem.start_positions(), state);
        let mut has_gap = vec![false; state.positions.len()];
        let mut loads = Loads::default();
        for interaction in problem.contacts().interactions() {
            fields.add_contact(interaction, &mut has_gap);
            loads.add(interaction, state.positions.len());
        }
        loads.for_each(problem, |node, load| {
            fields.contact_pressure[node] = load.normal;
            if let Some(friction) = &mut fields.friction {
                friction.traction[node] = load.friction;
            }
        });
        fields
    }

    fn without_contact(start: &[[f64; 3]], state: &State) -> Self {
        let count = state.positions.len();
        Self {
            displacement: displacement(start, &state.positions),
            stresses: None,
            contact_gap: vec![0.0; count],
            contact_pressure: vec![0.0; count],
            contact_status: vec![ContactStatus::None as i32; count],
            contact_basis: vec![0; count],
            friction: None,
        }
    }

    /// Adds stresses and plastic strains.
    ///
    /// # Errors
    /// Those of [`Solid::recover`](crate::solid::Solid::recover).
    pub fn recover(&mut self, problem: &Problem, state: &State) -> Result<(), SolidError> {
        self.stresses = Some(Stresses::of(problem, state)?);
        Ok(())
    }

    /// Gaps, slips and what contact means; pressures and tractions come from all interactions together.
    fn add_contact(&mut self, interaction: &Interaction, has_gap: &mut [bool]) {
        if interaction.options().friction.is_some() {
            let friction = self.friction.get_or_insert_with(|| FrictionFields::zero(has_gap.len()));
            interaction.slaves().for_each(|slave| friction.add(&slave));
        }
        for slave in interaction.slaves() {
            let node = slave.node;
            let status = match slave.gap {
                None if slave.has_failed => ContactStatus::Failed,
                None => ContactStatus::Unpaired,
                Some(_) if slave.force > 0.0 => ContactStatus::Closed,
                Some(_) => ContactStatus::Open,
            };
            // A node may be the slave of several: the closest contact is shown, and all forces.
            if let Some(gap) = slave.gap {
                if !has_gap[node] || gap < self.contact_gap[node] {
                    self.contact_gap[node] = gap;
                }
                has_gap[node] = true;
            }
            self.contact_status[node] = self.contact_status[node].max(status as i32);
            let degree = interaction.options().interface.element.degree(slave.fallback);
            if slave.gap.is_some() && degree > 0 {
                let least = &mut self.contact_basis[node];
                *least = if *least == 0 { degree.into() } else { (*least).min(degree.into()) };
            }
        }
    }
}

/// The contact fields at the slaves: what cannot be found again from a [`State`], because it takes the pairing of the increment that
/// led there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SlaveFields {
    nodes: Vec<usize>,
    gap: Vec<f64>,
    pressure: Vec<f64>,
    status: Vec<i32>,
    basis: Vec<i32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    friction: Option<FrictionFields>,
}

impl SlaveFields {
    pub(super) fn of(fields: &Fields) -> Self {
        let is_slave = |&node: &usize| fields.contact_status[node] != ContactStatus::None as i32;
        let nodes: Vec<usize> = (0..fields.contact_status.len()).filter(is_slave).collect();
        let at = |values: &[f64]| nodes.iter().map(|&node| values[node]).collect();
        Self {
            gap: at(&fields.contact_gap),
            pressure: at(&fields.contact_pressure),
            status: nodes.iter().map(|&node| fields.contact_status[node]).collect(),
            basis: nodes.iter().map(|&node| fields.contact_basis[node]).collect(),
            friction: fields.friction.as_ref().map(|friction| friction.at_nodes(&nodes)),
            nodes,
        }
    }

    /// Whether they are those of a model with so many nodes.
    pub(super) fn fits(&self, count: usize) -> bool {
        let mut lengths = vec![self.gap.len(), self.pressure.len(), self.status.len(), self.basis.len()];
        if let Some(friction) = &self.friction {
            lengths.extend([friction.slip.len(), friction.traction.len(), friction.status.len()]);
        }
        lengths.iter().all(|&length| length == self.nodes.len())
            && self.nodes.iter().all(|&node| node < count)
    }

    /// The fields that they came from. They [fit](Self::fits).
    pub(super) fn at(&self, start: &[[f64; 3]], state: &State) -> Fields {
        let mut fields = Fields::without_contact(start, state);
        for (k, &node) in self.nodes.iter().enumerate() {
            fields.contact_gap[node] = self.gap[k];
            fields.contact_pressure[node] = self.pressure[k];
            fields.contact_status[node] = self.status[k];
            fields.contact_basis[node] = self.basis[k];
        }
        fields.friction = self.friction.as_ref().map(|own| {
            let mut all = FrictionFields::zero(start.len());
            for (k, &node) in self.nodes.iter().enumerate() {
                (all.slip[node], all.traction[node], all.status[node]) =
                    (own.slip[k], own.traction[k], own.status[k]);
            }
            all
        });
        fields
    }
}

fn displacement(start: &[[f64; 3]], positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    start.iter().zip(positions).map(|(from, to)| [0, 1, 2].map(|axis| to[axis] - from[axis])).collect()
}
