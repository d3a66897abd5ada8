//! Contact forces at nodes, over the areas that carry them.
//!
//! A node may be the slave of several interfaces. Each presses on the part of the node's area that lies over its master, or on that of its
//! own surface. So what they exert together is over the area that they share: pressures of two that meet at a node do not add up.

use std::collections::{BTreeMap, HashMap, HashSet};

use diffuse_contact::surface::{Facet, tributary_areas};
use nalgebra::Vector3;

use crate::contact::{Integration, Interaction, SlaveState};
use crate::model::sorted;
use crate::statics::Problem;

/// What presses on nodes.
#[derive(Debug, Default)]
pub struct Loads {
    /// Interactions so far.
    count: usize,
    nodes: BTreeMap<usize, Vec<Share>>,
}

/// What one interaction exerts on a node.
#[derive(Clone, Copy, Debug)]
struct Share {
    interaction: usize,
    /// Normal force, > 0 where it presses.
    normal: f64,
    friction: [f64; 3],
    area: Area,
}

#[derive(Clone, Copy, Debug)]
enum Area {
    /// The part of the node's area over the master, length². What several interactions cover may be the same.
    Covered(f64),
    /// The same of a node of a face of second order, which has no tributary area to compare it with.
    CoveredByOrder(f64),
    /// That of the slave's nodes.
    Tributary,
    /// Over faces, where nothing lies over those around the node: what others of its faces carry.
    Beside,
}

/// Force per area.
#[derive(Clone, Copy, Debug)]
pub struct Load {
    pub normal: f64,
    pub friction: [f64; 3],
}

impl Loads {
    /// Adds those of an interaction at its last evaluation, of a model with `count` nodes.
    pub fn add(&mut self, interaction: &Interaction, count: usize) {
        let number = self.count;
        self.count += 1;
        let forces = interaction.nodal_forces(count);
        let options = interaction.options();
        let is_over_faces = options.integration != Integration::Nodes;
        let faces = &options.quadratic_faces;
        let on_quadratic: HashSet<usize> = faces.iter().flat_map(|face| face.nodes()).copied().collect();
        // With two passes a side has half of the penalty and so half of pressure and friction.
        let passes = if options.two_pass || options.self_contact { 2.0 } else { 1.0 };
        // Over faces a node on a sharp edge of the slave is there once for each sheet.
        let mut sheets: BTreeMap<usize, Vec<SlaveState>> = BTreeMap::new();
        interaction.slaves().for_each(|slave| sheets.entry(slave.node).or_default().push(slave));
        for (node, sheets) in sheets {
            let mut share = |normal: f64, friction: [f64; 3], area: Area| {
                if normal != 0.0 || friction != [0.0; 3] {
                    let share = Share { interaction: number, normal, friction, area };
                    self.nodes.entry(node).or_default().push(share);
                }
            };
            let covered = |slave: &SlaveState, of: fn(f64) -> Area| match slave.gap {
                Some(_) if slave.area > 0.0 => of(slave.area),
                _ => Area::Beside,
            };
            let own = |slave: &SlaveState| (passes * slave.force, slave.friction.map(|force| passes * force));
            if is_over_faces && on_quadratic.contains(&node) {
                // Forces of faces of second order are no pressures: corners may have none.
                for slave in &sheets {
                    let (normal, friction) = own(slave);
                    share(normal, friction, covered(slave, Area::CoveredByOrder));
                }
                continue;
            }
            let pressed = || sheets.iter().filter(|slave| slave.force > 0.0);
            if pressed().count() > 1 {
                // The node's force is that of all of them.
                let (mut sum, mut friction, mut area) = (0.0, [0.0; 3], 0.0);
                for slave in pressed() {
                    let (normal, along) = own(slave);
                    (sum, area) = (sum + normal, area + slave.area);
                    friction.iter_mut().zip(along).for_each(|(sum, force)| *sum += force);
                }
                share(sum, friction, Area::Covered(area));
                continue;
            }
            let gap = |slave: &&SlaveState| slave.gap.unwrap_or(f64::INFINITY);
            let closest = || sheets.iter().min_by(|one, other| gap(one).total_cmp(&gap(other)));
            let Some(slave) = pressed().next().or_else(closest) else { continue };
            let area = if is_over_faces { covered(slave, Area::Covered) } else { Area::Tributary };
            let friction = forces.friction[node];
            share(pressing(forces.forces[node], friction, slave.normal), friction, area);
        }
    }

    /// Hands over the loads of all nodes that something presses on.
    pub fn for_each(&self, problem: &Problem, mut f: impl FnMut(usize, Load)) {
        let interactions = problem.contacts().interactions();
        let mut unions = Unions { interactions, start: problem.start_positions(), found: HashMap::new() };
        for (&node, shares) in &self.nodes {
            let (mut area, mut covered) = (0.0, 0.0);
            let [mut covering, mut tributary, mut beside] = [const { Vec::new() }; 3];
            for &Share { interaction, area: own, .. } in shares {
                match own {
                    Area::Covered(own) => {
                        covered += own;
                        covering.push(interaction);
                    }
                    Area::CoveredByOrder(own) => area += own,
                    Area::Tributary => tributary.push(interaction),
                    Area::Beside => beside.push(interaction),
                }
            }
            area += if covering.len() > 1 { covered.min(unions.area(covering, node)) } else { covered };
            area += unions.area(tributary, node);
            if area == 0.0 {
                area = unions.area(beside, node);
            }
            if area > 0.0 {
                let normal = shares.iter().map(|share| share.normal).sum::<f64>() / area;
                let friction =
                    [0, 1, 2].map(|axis| shares.iter().map(|share| share.friction[axis]).sum::<f64>() / area);
                f(node, Load { normal, friction });
            }
        }
    }
}

/// Areas of nodes of several interactions' surfaces, which may have facets in common.
struct Unions<'a> {
    interactions: &'a [Interaction],
    start: &'a [[f64; 3]],
    found: HashMap<Vec<usize>, Vec<f64>>,
}

impl Unions<'_> {
    fn area(&mut self, mut interactions: Vec<usize>, node: usize) -> f64 {
        interactions.sort_unstable();
        interactions.dedup();
        if interactions.is_empty() {
            return 0.0;
        }
        if let [one] = interactions[..] {
            return self.interactions[one].tributary_area(node);
        }
        let Self { interactions: all, start, found } = self;
        let areas = found.entry(interactions).or_insert_with_key(|interactions| {
            let mut known = HashSet::new();
            let mut is_new = |facet: &&Facet| known.insert(sorted(facet.corners()));
            let facets = interactions.iter().flat_map(|&k| all[k].facets());
            let facets: Vec<Facet> = facets.filter(&mut is_new).copied().collect();
            // Checked when the interactions were made.
            tributary_areas(start, &facets).unwrap_or_default()
        });
        areas.get(node).copied().unwrap_or(0.0)
    }
}

/// The part of a node's contact force along its normal. A slave that faces no master has no normal; what it receives besides friction, as
/// a master of the other pass or by others of its faces, is pressure then.
fn pressing(force: [f64; 3], friction: [f64; 3], normal: [f64; 3]) -> f64 {
    let [force, friction, direction] = [force, friction, normal].map(Vector3::from);
    if normal == [0.0; 3] { (force - friction).norm() } else { force.dot(&direction) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_is_no_pressure_where_there_is_no_normal() {
        assert_eq!(pressing([3.0, 0.0, 4.0], [3.0, 0.0, 0.0], [0.0; 3]), 4.0);
        assert_eq!(pressing([3.0, 0.0, 4.0], [3.0, 0.0, 0.0], [0.0, 0.0, 1.0]), 4.0);
    }
}
