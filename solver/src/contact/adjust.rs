//! Slaves that start in touch: moved onto the master before there is any strain.

use std::collections::BTreeSet;

use diffuse_contact::{Mode, Point};
use thiserror::Error;

use super::{ContactError, Interaction, SlaveState};
use crate::solid::SolidError;

/// A slave follows the fit of its own masters: each round leaves a small part of the gap.
const ROUNDS: usize = 30;
/// A gap is closed when it is below this part of the limit, or what the last digits of positions make of it.
const CLOSED: f64 = 1e-9;
const LAST_DIGITS: f64 = 64.0 * f64::EPSILON;
/// A slave is moved up to this part of the size of the facets around it.
const FARTHEST: f64 = 0.25;
/// Of a unit normal the square of its part along free axes, at least: a slave with less slides far along the surface to close its gap.
const LEAST_FREE: f64 = 0.1;

/// Why slaves cannot start in touch.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum AdjustError {
    #[error(transparent)]
    Contact(#[from] ContactError),
    #[error(
        "{count} slaves lie within {limit:e} of the master, but none of them can be moved: they are rigid or prescribed, or free \
         along its surface alone; exchange master and slave"
    )]
    Rigid { count: usize, limit: f64 },
    /// Slaves would move far beyond what a mesh leaves open.
    #[error(
        "the limit of {limit:e} is more than a quarter of {size:e}, the size of the facets around slave node {node}"
    )]
    Far { node: usize, limit: f64, size: f64 },
    /// An element does not stand that its nodes are moved.
    #[error(transparent)]
    Solid(#[from] SolidError),
    #[error("slave node {node} has no gap where it is moved to")]
    Lost { node: usize },
    #[error("slave node {node} still has a gap of {gap:e} after {ROUNDS} rounds")]
    Open { node: usize, gap: f64 },
}

/// Slaves that start in touch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Adjusted {
    /// Those that were moved, with their new positions.
    pub moved: Vec<(usize, Point)>,
    /// How many stay where they are, as the axes along which they are free lie all but along the surface.
    pub held: usize,
}

/// New positions of the slaves whose gap is at most `limit` either way: onto the surface along what axes that are `free` leave of the normal
/// at their foot.
pub fn adjust(
    interaction: &mut Interaction,
    start: &[Point],
    free: &[[bool; 3]],
    limit: f64,
) -> Result<Adjusted, AdjustError> {
    evaluate(interaction, start)?;
    let (nodes, held) = within(interaction, free, limit)?;
    let mut positions = start.to_vec();
    let mut worst = (0, 0.0);
    for _ in 0..ROUNDS {
        let (mut extent, mut largest): (f64, f64) = (0.0, 0.0);
        for slave in interaction.slaves().filter(|slave| nodes.contains(&slave.node)) {
            let node = slave.node;
            let Some(gap) = slave.gap.map(|_| slave.average_gap) else {
                return Err(AdjustError::Lost { node });
            };
            if gap.abs() >= largest {
                (largest, worst) = (gap.abs(), (node, gap));
            }
            // Along n' = n on free axes a step of s n' closes s |n'|² of the gap.
            let step = gap / free_part(&slave, free).max(LEAST_FREE);
            for axis in (0..3).filter(|&axis| free[node][axis]) {
                positions[node][axis] -= step * slave.normal[axis];
            }
            extent = positions[node].iter().fold(extent, |extent, x| extent.max(x.abs()));
        }
        if largest <= (CLOSED * limit).max(LAST_DIGITS * extent) {
            let moved = nodes.into_iter().map(|node| (node, positions[node])).collect();
            return Ok(Adjusted { moved, held });
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

/// The square of what free axes leave of a slave's unit normal.
fn free_part(slave: &SlaveState, free: &[[bool; 3]]) -> f64 {
    (0..3).filter(|&axis| free[slave.node][axis]).map(|axis| slave.normal[axis].powi(2)).sum()
}

/// The slave nodes within the limit that can be moved, and how many others have free axes, but hardly any along the normal.
fn within(
    interaction: &Interaction,
    free: &[[bool; 3]],
    limit: f64,
) -> Result<(BTreeSet<usize>, usize), AdjustError> {
    let (mut movable, mut held, mut count) = (BTreeSet::new(), 0, 0);
    let is_near = |slave: &SlaveState| slave.gap.is_some() && slave.average_gap.abs() <= limit;
    for slave in interaction.slaves().filter(is_near) {
        let (node, size) = (slave.node, interaction.facet_size_at(slave.node));
        count += 1;
        if free_part(&slave, free) >= LEAST_FREE {
            if !(limit <= FARTHEST * size) {
                return Err(AdjustError::Far { node, limit, size });
            }
            movable.insert(node);
        } else if free[node].contains(&true) {
            held += 1;
        }
    }
    if movable.is_empty() && count > 0 {
        Err(AdjustError::Rigid { count, limit })
    } else {
        Ok((movable, held))
    }
}
