//! Slaves that start in touch: moved onto the master before there is any strain.

use diffuse_contact::{Mode, Point};
use thiserror::Error;

use super::{ContactError, Interaction, SlaveState};
use crate::solid::SolidError;

/// A slave follows the fit of its own masters: each round leaves a small part of the gap.
const ROUNDS: usize = 30;
/// A gap is closed when it is below this part of the limit, or what the last digits of positions make of it.
const CLOSED: f64 = 1e-9;
const LAST_DIGITS: f64 = 64.0 * f64::EPSILON;

/// Why slaves cannot start in touch.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AdjustError {
    /// Contact could not be evaluated.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The slaves within reach belong to a rigid part, whose shape is given, or are prescribed.
    #[error(
        "{count} slaves lie within {limit:e} of the master, but none of them can be moved: they are rigid or prescribed; exchange master and slave"
    )]
    Rigid {
        /// How many.
        count: usize,
        /// The largest distance either way, length.
        limit: f64,
    },
    /// Slaves would move far beyond what a mesh leaves open.
    #[error("the limit of {limit:e} is more than a quarter of {size:e}, the mean size of the slave's facets")]
    Far {
        /// The limit, length.
        limit: f64,
        /// The size, length.
        size: f64,
    },
    /// An element does not stand that its nodes are moved.
    #[error(transparent)]
    Solid(#[from] SolidError),
    /// A slave has left its master on its way.
    #[error("slave node {node} has no gap where it is moved to")]
    Lost {
        /// The node.
        node: usize,
    },
    /// A gap does not close.
    #[error("slave node {node} still has a gap of {gap:e} after {ROUNDS} rounds")]
    Open {
        /// The node.
        node: usize,
        /// Its gap, length.
        gap: f64,
    },
}

/// New positions of the slaves whose gap is at most `limit` either way: along the normal at their foot onto the surface. `movable`: whether
/// a node belongs to a deformable body.
///
/// # Errors
/// [`AdjustError`].
pub fn adjust(
    interaction: &mut Interaction,
    start: &[Point],
    free: &[[bool; 3]],
    limit: f64,
) -> Result<Vec<(usize, Point)>, AdjustError> {
    let size = interaction.facet_size();
    if !(limit <= 0.25 * size) {
        return Err(AdjustError::Far { limit, size });
    }
    let mut positions = start.to_vec();
    let mut moved: Option<Vec<bool>> = None;
    for _ in 0..ROUNDS {
        interaction.refresh(&positions)?;
        interaction.evaluate(&positions, Mode::Value)?;
        let near: Vec<SlaveState> = interaction
            .slaves()
            .filter(|slave| match &moved {
                // Who moves is decided at the start.
                Some(moved) => moved[slave.node],
                None => slave.gap.is_some_and(|gap| gap.abs() <= limit),
            })
            .collect();
        let count = near.len();
        let near: Vec<SlaveState> =
            near.into_iter().filter(|slave| free[slave.node].contains(&true)).collect();
        if near.is_empty() && count > 0 {
            return Err(AdjustError::Rigid { count, limit });
        }
        moved.get_or_insert_with(|| {
            let mut moved = vec![false; start.len()];
            near.iter().for_each(|slave| moved[slave.node] = true);
            moved
        });
        let (mut largest, mut size): (f64, f64) = (0.0, 0.0);
        for slave in &near {
            let Some(gap) = slave.gap else { return Err(AdjustError::Lost { node: slave.node }) };
            largest = largest.max(gap.abs());
            let position = &mut positions[slave.node];
            for axis in (0..3).filter(|&axis| free[slave.node][axis]) {
                position[axis] -= gap * slave.normal[axis];
            }
            size = position.iter().fold(size, |size, x| size.max(x.abs()));
        }
        if largest <= (CLOSED * limit).max(LAST_DIGITS * size) {
            return Ok(near.iter().map(|slave| (slave.node, positions[slave.node])).collect());
        }
    }
    let open = interaction.slaves().filter(|slave| moved.as_ref().is_some_and(|moved| moved[slave.node]));
    let worst = open.max_by(|a, b| a.gap.unwrap_or(0.0).abs().total_cmp(&b.gap.unwrap_or(0.0).abs()));
    let (node, gap) = worst.map_or((0, 0.0), |slave| (slave.node, slave.gap.unwrap_or(0.0)));
    Err(AdjustError::Open { node, gap })
}
