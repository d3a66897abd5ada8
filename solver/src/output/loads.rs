//! Contact forces at nodes, over the areas that carry them.
//!
//! A node may be the slave of several interfaces. Each presses on the part of the node's area that lies over its master, or on that of its
//! own surface. So what they exert together is over the area that they share: pressures of two that meet at a node do not add up.

use std::collections::{BTreeMap, HashMap, HashSet};

use diffuse_contact::surface::{Facet, tributary_areas};

use crate::contact::{Integration, Interaction, SlaveState};
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

#[derive(Clone, Copy, Debug, PartialEq)]
enum Area {
    /// The part of the node's area over the master, length².
    Covered(f64),
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
        for slave in interaction.slaves() {
            let SlaveState { node, area, .. } = slave;
            let covered = match slave.gap {
                Some(_) if area > 0.0 => Area::Covered(area),
                _ => Area::Beside,
            };
            let (normal, friction, area) = if is_over_faces && on_quadratic.contains(&node) {
                // Forces of faces of second order are no pressures: corners may have none.
                (passes * slave.force, slave.friction.map(|force| passes * force), covered)
            } else {
                let area = if is_over_faces { covered } else { Area::Tributary };
                (pressing(forces.forces[node], slave.normal), forces.friction[node], area)
            };
            if normal != 0.0 || friction != [0.0; 3] {
                let share = Share { interaction: number, normal, friction, area };
                self.nodes.entry(node).or_default().push(share);
            }
        }
    }

    /// Hands over the loads of all nodes that something presses on.
    pub fn for_each(&self, problem: &Problem, mut f: impl FnMut(usize, Load)) {
        let interactions = problem.contacts().interactions();
        let mut unions = Unions { interactions, start: problem.start_positions(), found: HashMap::new() };
        for (&node, shares) in &self.nodes {
            let of = |area: Area| -> Vec<usize> {
                shares.iter().filter(|share| share.area == area).map(|share| share.interaction).collect()
            };
            let covered = |share: &Share| if let Area::Covered(area) = share.area { area } else { 0.0 };
            let mut area: f64 = shares.iter().map(covered).sum();
            area += unions.area(of(Area::Tributary), node);
            if area == 0.0 {
                area = unions.area(of(Area::Beside), node);
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
            let mut is_new = |facet: &&Facet| {
                let mut corners = facet.corners().to_vec();
                corners.sort_unstable();
                known.insert(corners)
            };
            let facets = interactions.iter().flat_map(|&k| all[k].facets());
            let facets: Vec<Facet> = facets.filter(&mut is_new).copied().collect();
            // Checked when the interactions were made.
            tributary_areas(start, &facets).unwrap_or_default()
        });
        areas.get(node).copied().unwrap_or(0.0)
    }
}

/// The part of a node's contact force along its normal. A slave that faces no master has no normal; what it receives as a master
/// of the other pass is pressure then.
fn pressing(force: [f64; 3], normal: [f64; 3]) -> f64 {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    if normal == [0.0; 3] { dot(force, force).sqrt() } else { dot(force, normal) }
}
