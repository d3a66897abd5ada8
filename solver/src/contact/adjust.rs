//! Slaves that start in touch: moved onto the master before there is any strain.

use std::collections::BTreeSet;

use diffuse_contact::{Mode, Point};
use thiserror::Error;

use super::{ContactError, Interaction};
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
        "{count} slaves lie within {limit:e} of the master, but none of them can be moved: they are rigid or prescribed; exchange \
         master and slave"
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

/// New positions of the slaves whose gap is at most `limit` either way: along the normal at their foot onto the surface, but not along
/// axes that are not `free`.
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
    evaluate(interaction, start)?;
    let nodes = within(interaction, free, limit)?;
    let mut positions = start.to_vec();
    let mut worst = (0, 0.0);
    for _ in 0..ROUNDS {
        let (mut extent, mut largest): (f64, f64) = (0.0, 0.0);
        for slave in interaction.slaves().filter(|slave| nodes.contains(&slave.node)) {
            let node = slave.node;
            let Some(gap) = slave.gap else { return Err(AdjustError::Lost { node }) };
            if gap.abs() >= largest {
                (largest, worst) = (gap.abs(), (node, gap));
            }
            for axis in (0..3).filter(|&axis| free[node][axis]) {
                positions[node][axis] -= gap * slave.normal[axis];
            }
            extent = positions[node].iter().fold(extent, |extent, x| extent.max(x.abs()));
        }
        if largest <= (CLOSED * limit).max(LAST_DIGITS * extent) {
            return Ok(nodes.into_iter().map(|node| (node, positions[node])).collect());
        }
        evaluate(interaction, &positions)?;
    }
    let (node, gap) = worst;
    Err(AdjustError::Open { node, gap })
}

fn evaluate(interaction: &mut Interaction, positions: &[Point]) -> Result<(), ContactError> {
    interaction.refresh(positions)?;
    interaction.evaluate(positions, Mode::Value)
}

/// The slave nodes within the limit that can be moved.
fn within(interaction: &Interaction, free: &[[bool; 3]], limit: f64) -> Result<BTreeSet<usize>, AdjustError> {
    let near = interaction.slaves().filter(|slave| slave.gap.is_some_and(|gap| gap.abs() <= limit));
    let near: BTreeSet<usize> = near.map(|slave| slave.node).collect();
    let count = near.len();
    let movable: BTreeSet<usize> = near.into_iter().filter(|&node| free[node].contains(&true)).collect();
    if movable.is_empty() && count > 0 { Err(AdjustError::Rigid { count, limit }) } else { Ok(movable) }
}
