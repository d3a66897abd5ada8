//! Fields at the nodes.

use diffuse_contact::surface::tributary_areas;

use crate::model::Model;
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
    /// Contact force over tributary area of slaves at the start, force per area.
    pub contact_pressure: Vec<f64>,
    /// A [`ContactStatus`].
    pub contact_status: Vec<i32>,
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
    /// The fields at the end of an increment. `areas`: of the nodes of each interaction's slaves at the start, by
    /// [`slave_areas`](Self::slave_areas). `stress`: whether stresses are asked for.
    ///
    /// # Errors
    /// Those of [`Solid::recover`](crate::solid::Solid::recover).
    pub fn of(problem: &Problem, state: &State, areas: &[f64], stress: bool) -> Result<Self, SolidError> {
        let count = state.positions.len();
        let mut fields = Self {
            displacement: displacement(problem.start_positions(), &state.positions),
            stresses: if stress { Some(Stresses::of(problem, state)?) } else { None },
            contact_gap: vec![0.0; count],
            contact_pressure: vec![0.0; count],
            contact_status: vec![ContactStatus::None as i32; count],
        };
        let mut has_gap = vec![false; count];
        for slave in problem.contacts().interactions().iter().flat_map(|interaction| interaction.slaves()) {
            let node = slave.node;
            let status = match slave.gap {
                None if slave.has_failed => ContactStatus::Failed,
                None => ContactStatus::Unpaired,
                Some(_) if slave.force > 0.0 => ContactStatus::Closed,
                Some(_) => ContactStatus::Open,
            };
            // A node may be the slave of several: the closest contact is shown, and all forces.
            if let Some(gap) = slave.gap {
                let is_closest = !has_gap[node] || gap < fields.contact_gap[node];
                fields.contact_gap[node] = if is_closest { gap } else { fields.contact_gap[node] };
                has_gap[node] = true;
            }
            fields.contact_status[node] = fields.contact_status[node].max(status as i32);
            if areas[node] > 0.0 {
                fields.contact_pressure[node] += slave.force / areas[node];
            }
        }
        Ok(fields)
    }

    /// Tributary areas of all nodes of the named surfaces, zero elsewhere.
    #[must_use]
    pub fn slave_areas(model: &Model, surfaces: &[Vec<diffuse_contact::surface::Facet>]) -> Vec<f64> {
        let mut areas = vec![0.0; model.nodes.len()];
        for facets in surfaces {
            // Checked when the interface was made.
            for (sum, area) in areas.iter_mut().zip(tributary_areas(&model.nodes, facets).unwrap_or_default())
            {
                *sum = f64::max(*sum, area);
            }
        }
        areas
    }
}

fn displacement(start: &[[f64; 3]], positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    start.iter().zip(positions).map(|(from, to)| [0, 1, 2].map(|axis| to[axis] - from[axis])).collect()
}
