//! How the slaves of an interaction lie before the first increment.

use std::collections::{BTreeSet, HashSet};

use diffuse_contact::Point;
use diffuse_contact::faces::QuadraticFace;
use diffuse_contact::interface::Outcome;
use diffuse_contact_mesh::names::shown;
use serde::{Deserialize, Serialize};

use super::proposal::{crossed_planes, free_planes, idle_planes, symmetry_line};
use super::tracks::all_behind;
use super::{Fallbacks, Integration, Interaction};
use crate::model::Model;
use crate::statics::Problem;

/// A slave that starts deeper below its master than this part of its facets' size is more than a mesh that does not quite fit.
const DEEP: f64 = 0.1;

/// A penalty so many times as stiff as the bodies' facets leaves their forces 7 of 16 digits.
const STIFF: f64 = 1e9;

/// A face over more facets than this, ten by ten, is too coarse to say where they touch, and couples all of their nodes.
const FACETS_UNDER: f64 = 100.0;

/// The slaves of an interaction at the last evaluation, which is that of the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Beginning {
    /// Name of the interface in the deck.
    pub interface: String,
    /// ε: force per length, or per length³ with areas and over faces.
    pub penalty: f64,
    /// ε over the stiffness of the stiffest body's facets, E/h with areas and over faces, else E h.
    #[serde(default)]
    pub stiffness_ratio: f64,
    /// Slaves that were moved onto their masters, and the longest way, length; `None` if that was not asked for.
    pub adjusted: Option<(usize, f64)>,
    /// Slaves that were to be moved, too, but are free along the master alone.
    #[serde(default)]
    pub not_adjusted: usize,
    /// Slaves, of both passes if there are two.
    pub slaves: usize,
    /// Those that have a contact element.
    pub paired: usize,
    /// The deepest penetration, length, as [`Interaction::max_penetration`].
    pub overlap: f64,
    /// Slaves that are deeper below the master than a tenth of their facets' size; those that nothing moves are the deck's and left out.
    pub deep: usize,
    /// Slaves behind the master, deeper than masters are looked for, if all are there but for those beside it.
    #[serde(default)]
    pub behind: usize,
    /// The first interface before it with the same two surfaces.
    #[serde(default)]
    pub repeats: Option<String>,
    /// Slaves whose masters do not carry the fit that was asked for.
    #[serde(flatten)]
    pub fallbacks: Fallbacks,
    /// Edge middles and centres of slave faces where they stay flat, as the slave's nodes carry no smooth surface.
    pub straight: usize,
    /// Faces of a slave with 8 nodes, over nodes: their corners would have to pull.
    #[serde(default)]
    pub serendipity: usize,
    /// Faces of a slave with 6 nodes, over nodes: their corners carry no part of a uniform pressure.
    #[serde(default)]
    pub quadratic_triangles: usize,
    /// Faces of a slave with 9 nodes, over nodes: their corners carry 4/9 of a uniform pressure, their middles 16/9.
    #[serde(default)]
    pub lagrange: usize,
    /// Over faces in one pass: how many facets of the master have the area of a face of the slave, by their mean sizes; else 0.
    #[serde(default)]
    pub facets_under: f64,
    /// The line of the deck that names the planes of symmetry that the boundary conditions speak of, if the interface does not name all of
    /// them.
    #[serde(default)]
    pub symmetry: Option<String>,
    /// Planes of symmetry, as the deck has them, in which no surface of the interface ends.
    #[serde(default)]
    pub idle_planes: Vec<String>,
    /// Planes of symmetry across an axis, as the deck has them, and how many nodes in them are free to move along it.
    #[serde(default)]
    pub free_planes: Vec<(String, usize)>,
    /// Planes in which the slave ends where boundary conditions are those of symmetry, as decks have them, and which a rigid master crosses;
    /// over faces.
    #[serde(default)]
    pub crossed_planes: Vec<String>,
}

/// Of the first pass; 0 where a slave has contact.
fn behind(interaction: &Interaction, positions: &[Point]) -> usize {
    let Some(pass) = interaction.passes().next().filter(|_| !interaction.options().self_contact) else {
        return 0;
    };
    let outcomes = pass.outcomes();
    let is_paired = outcomes.iter().any(|(_, outcome)| matches!(outcome, Outcome::Contact { .. }));
    let slaves: Vec<usize> = outcomes.into_iter().map(|(node, _)| node).collect();
    if is_paired { 0 } else { all_behind(&slaves, pass.master(), positions) }
}

/// ε over E/h, or over E h without areas.
fn stiffness_ratio(interaction: &Interaction, model: &Model) -> f64 {
    let options = interaction.options();
    let young = model.bodies.iter().map(|body| body.material.young).fold(0.0, f64::max);
    let is_over_area = options.interface.areas || options.integration != Integration::Nodes;
    let size = interaction.facet_size();
    let stiffness = if is_over_area { young / size } else { young * size };
    // A slave without facets has no size.
    if size > 0.0 { options.penalty / stiffness } else { 0.0 }
}

/// How many facets of the master have the area of a face of the slave, over faces in one pass.
fn facets_under(interaction: &Interaction) -> f64 {
    let options = interaction.options();
    let is_one_sided = !options.two_pass && !options.self_contact;
    let [slave, master] = interaction.facet_sizes();
    let count = (slave / master).powi(2);
    if options.integration != Integration::Nodes && is_one_sided && count.is_finite() { count } else { 0.0 }
}

/// Faces with 8 nodes, with 6 and with 9, all of them slaves that something moves, over nodes.
fn unsuited_faces(interaction: &Interaction, model: &Model) -> [usize; 3] {
    if interaction.options().integration != Integration::Nodes {
        return [0; 3];
    }
    let slaves: HashSet<usize> =
        interaction.slaves().filter(|slave| !slave.is_held).map(|slave| slave.node).collect();
    let faces = model.quadratic_faces();
    let is_slave = |face: &&QuadraticFace| face.nodes().iter().all(|node| slaves.contains(node));
    [8, 6, 9].map(|count| faces.iter().filter(|face| face.nodes().len() == count).filter(is_slave).count())
}

/// The name of the first interaction before this one that presses the same two surfaces together.
fn repeated(interaction: &Interaction, problem: &Problem) -> Option<String> {
    let all = problem.contacts().interactions().iter();
    let mut before = all.take_while(|other| other.options().name != interaction.options().name);
    let first = before.find(|other| interaction.is_of_the_surfaces_of(other))?;
    Some(first.options().name.clone())
}

impl Beginning {
    /// Of the slaves of a model's interaction, one of the problem's.
    pub fn of(interaction: &Interaction, model: &Model, problem: &Problem) -> Self {
        let options = interaction.options();
        let is_deep = |node: usize, gap: f64| gap < -DEEP * interaction.facet_size_at(node);
        let moved = interaction.slaves().filter(|slave| !slave.is_held);
        let deep = moved.filter(|slave| slave.gap.is_some_and(|gap| is_deep(slave.node, gap)));
        let way = |node: usize| {
            let adjusted = model.adjusted.get(&node)?;
            let (from, to) = (&adjusted.before, &model.nodes[node]);
            (adjusted.interface == options.name)
                .then(|| (0..3).map(|axis| (to[axis] - from[axis]).powi(2)).sum::<f64>().sqrt())
        };
        let nodes: BTreeSet<usize> = interaction.slaves().map(|slave| slave.node).collect();
        let ways: Vec<f64> = nodes.into_iter().filter_map(way).filter(|&way| way > 0.0).collect();
        let [serendipity, quadratic_triangles, lagrange] = unsuited_faces(interaction, model);
        Self {
            penalty: options.penalty,
            stiffness_ratio: stiffness_ratio(interaction, model),
            adjusted: options.adjust.map(|_| (ways.len(), ways.into_iter().fold(0.0, f64::max))),
            not_adjusted: model.not_adjusted.get(&options.name).copied().unwrap_or(0),
            interface: options.name.clone(),
            slaves: interaction.slaves().count(),
            paired: interaction.slaves().filter(|slave| slave.gap.is_some()).count(),
            overlap: interaction.max_penetration(),
            deep: deep.count(),
            behind: behind(interaction, problem.start_positions()),
            repeats: repeated(interaction, problem),
            fallbacks: interaction.fallbacks(),
            straight: interaction.straight(),
            serendipity,
            quadratic_triangles,
            lagrange,
            facets_under: facets_under(interaction),
            symmetry: symmetry_line(interaction, problem, &model.deformable()),
            idle_planes: idle_planes(interaction, problem.start_positions()),
            free_planes: free_planes(interaction, problem, &model.deformable()),
            crossed_planes: crossed_planes(interaction, problem, &model.deformable()),
        }
    }

    /// What the deck could say more, in sentences.
    pub fn notes(&self) -> Vec<String> {
        let note = |line: &String| {
            format!(
                "interface `{}`: the master ends where boundary conditions are those of a plane of symmetry; if it goes on beyond as its \
                 mirror image, add `{line}` to the interface",
                shown(&self.interface)
            )
        };
        let mut notes: Vec<String> = self.symmetry.iter().map(note).collect();
        if !self.crossed_planes.is_empty() {
            notes.push(format!(
                "interface `{}`: the slave ends where boundary conditions are those of a plane of symmetry, but the rigid master crosses it, \
                 so that over faces the slave's surface ends there as at a border; cut the master at the plane and add `symmetry = [{}]` to \
                 the interface",
                shown(&self.interface),
                self.crossed_planes.join(", ")
            ));
        }
        notes
    }

    /// What may be wrong with the start, in sentences.
    pub fn warnings(&self) -> Vec<String> {
        let interface = shown(&self.interface);
        let twice = |other: &String| {
            format!(
                "interface `{interface}`: its two surfaces are those of the interface `{}`, too: the stiffnesses of both add up",
                shown(other)
            )
        };
        let mut warnings: Vec<String> = self.repeats.iter().map(twice).collect();
        let mut warn = |count: usize, what: &str| {
            if count > 0 {
                warnings.push(format!("interface `{interface}`: {count} {what}"));
            }
        };
        warn(
            self.not_adjusted,
            "slaves near the master are not moved onto it: their boundary conditions leave them free along its surface, and hardly across it",
        );
        warn(
            self.deep,
            "slaves start deeper below the master than a tenth of their facets' size: do the parts overlap, or does the master face \
             the wrong way?",
        );
        warn(
            self.behind,
            "slaves, all that are not beside the master, lie behind it and deeper than it is looked for, so that nothing touches: do the \
             parts overlap, or does the master face the wrong way?",
        );
        warn(
            self.straight,
            "edge middles or centres of the slave's faces are flat: its nodes carry no smooth surface of their own there",
        );
        warn(
            self.serendipity,
            "faces of the slave have 8 nodes: under a pressure their corners would pull, so that forces over nodes are too low; \
             integration = \"faces\" has them right",
        );
        warn(
            self.quadratic_triangles,
            "faces of the slave have 6 nodes: their corners carry no part of a uniform pressure, so that pressures of single nodes are of \
             no use over nodes, while forces are right; integration = \"faces\" has both right",
        );
        warn(
            self.lagrange,
            "faces of the slave have 9 nodes: their corners carry 4/9 of a uniform pressure and their middles 16/9, so that pressures of \
             single nodes are of no use over nodes, while forces are right; integration = \"faces\" has both right",
        );
        if self.facets_under > FACETS_UNDER {
            warnings.push(format!(
                "interface `{interface}`: each face of the slave has the area of some {:.0} facets of the master: averages over it say little, \
                 and its tangent couples all of their nodes; master and slave the other way round are better",
                self.facets_under
            ));
        }
        if self.stiffness_ratio > STIFF {
            warnings.push(format!(
                "interface `{interface}`: its penalty is {:.1e} times as stiff as facets of the bodies, whose forces are lost in \
                 its rounding; 1e3 times is enough",
                self.stiffness_ratio
            ));
        }
        let idle = |plane: &String| {
            format!(
                "interface `{interface}`: no edge of the master's or the slave's border lies in its plane of symmetry {plane}: is it where \
                 the model ends?"
            )
        };
        warnings.extend(self.idle_planes.iter().map(idle));
        let free = |(plane, count): &(String, usize)| {
            format!(
                "interface `{interface}`: {count} nodes in its plane of symmetry {plane} are free to move out of it: a `boundary` with `fix` \
                 holds them there"
            )
        };
        warnings.extend(self.free_planes.iter().map(free));
        warnings.extend(self.fallbacks.warnings(Fallbacks::default(), &self.interface, self.slaves));
        warnings
    }
}
