//! How a run ended, in a few numbers.

use std::collections::{BTreeMap, HashSet};

use diffuse_contact_mesh::names::shown;
use serde::{Deserialize, Serialize};

use crate::contact::{Beginning, Fallbacks, Penetration};
use crate::deck::Deck;
use crate::material::Material;
use crate::model::{Body, Model};
use crate::statics::{Effort, ShownTime};

/// Above this part of the elastic energy in their springs penalties are worth a warning.
const SOFT: f64 = 0.05;
/// Interfaces with less than this part of that are not named.
const SOFT_PART: f64 = 0.05;
/// Above this part of μ p that friction lacks it is worth a warning.
const SHORT_FRICTION: f64 = 0.01;

/// `summary.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Title of the deck.
    pub title: String,
    /// Whether the end of time was reached.
    pub converged: bool,
    /// Why not, in a sentence; empty if it was.
    pub reason: String,
    /// Pseudo-time reached.
    pub time: f64,
    /// Converged increments.
    pub increments: usize,
    /// Increments that failed and were tried again with a shorter one.
    pub cutbacks: usize,
    /// Linear solutions, those of failed increments among them.
    pub newton_iterations: usize,
    /// Increments whose rounds of augmentation were over before the gaps were within the tolerance.
    #[serde(default)]
    pub augmentations_short: usize,
    /// Increments whose last residual is above what the tolerances allow in any increment, and small enough only since rounding of the
    /// positions explains the rest.
    #[serde(default)]
    pub increments_rounded: usize,
    /// Contacts that carried force and ended an increment without an element, and slaves that went through their masters in one.
    #[serde(default)]
    pub contacts_lost: usize,
    /// Points of loaded faces that carried no force although they had a gap, over all increments.
    #[serde(default)]
    pub points_missed: usize,
    /// Slaves that carried force without friction although their interface has it, over all increments.
    #[serde(default)]
    pub slaves_unanchored: usize,
    /// Linear solutions in which slaves near their masters were taken to touch, over all increments.
    #[serde(default)]
    pub solutions_supposed: usize,
    /// Increments whose contact was found with softer penalties first, as a body came loose from it on the way.
    #[serde(default)]
    pub increments_softened: usize,
    /// Increments whose last stiffness that was solved with has negative eigenvalues.
    #[serde(default)]
    pub increments_unstable: usize,
    /// Linear solutions in which nothing but the stabilisation held a part, over all increments.
    #[serde(default)]
    pub solutions_stabilised: usize,
    /// Iterations of all iterative linear solutions of finished increments.
    #[serde(default)]
    pub linear_iterations: usize,
    /// Linear solutions by factors since the iterative one did not converge, over all increments.
    #[serde(default)]
    pub solutions_direct_instead: usize,
    /// The most memory of matrix, preconditioner and vectors of an iterative linear solution in the last run, bytes; 0 if there was none.
    #[serde(default)]
    pub linear_bytes: usize,
    /// Interfaces that carried no force, above what equilibrium is known to, at the end of any increment.
    #[serde(default)]
    pub interfaces_without_force: Vec<String>,
    /// Interfaces whose force vanished although slaves that carried it have not risen from their masters, with the time of the first such
    /// increment.
    #[serde(default)]
    pub interfaces_vanished: BTreeMap<String, f64>,
    /// Of each interface the most slaves at the end of an increment whose masters do not carry the fit that was asked for; of the start
    /// it is in [`interfaces`](Self::interfaces).
    #[serde(default)]
    pub fallbacks: BTreeMap<String, Fallbacks>,
    /// Of each interface the most slaves that were deeper below their masters than 5 % of the size of their facets at the end of an increment,
    /// and the deepest of any; interfaces without any are left out.
    #[serde(default)]
    pub penetrations: BTreeMap<String, Penetration>,
    /// How the slaves of each interface lay at the start, with its penalty.
    #[serde(default)]
    pub interfaces: Vec<Beginning>,
    /// What the model is made of.
    #[serde(default)]
    pub parts: Vec<PartSummary>,
    /// What may be wrong with the start, and what went wrong on the way, in sentences.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// Deepest penetration at the end, length.
    pub max_penetration: f64,
    /// Deepest penetration at the end of any increment, length.
    pub max_penetration_ever: f64,
    /// Sum of the contact forces on the slaves of all interactions at the end.
    pub contact_force: [f64; 3],
    /// Each interface at the end.
    #[serde(default)]
    pub contacts: BTreeMap<String, ContactSummary>,
    /// Friction at the end, of each interface that has any.
    #[serde(default)]
    pub friction: BTreeMap<String, FrictionSummary>,
    /// Seconds of the run; of all runs, if it was restarted.
    pub wall_s: f64,
    /// Share of the last run's time in evaluating contacts, 0 to 1.
    pub contact_share: f64,
    /// Share of the last run's time in pairing, 0 to 1.
    pub pairing_share: f64,
    /// Share of the last run's time in the linear solver, 0 to 1.
    pub linear_share: f64,
    /// Element of the interfaces: `diffuse`, `node-to-facet` or `none`.
    pub element: String,
    /// Nodes, elements.
    pub size: [usize; 2],
}

/// An interface at the end of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactSummary {
    /// Sum of the contact forces on its slaves.
    pub force: [f64; 3],
    /// Sum of the moduli of the normal forces.
    pub normal_force: f64,
    /// Area of the slave that carries force.
    pub area: f64,
    /// Half of its normal forces times penetrations, over that of all interfaces and the elastic energy of all bodies, 0 to 1, in the increment
    /// in which these together are largest. About as much softer than the bodies alone is the whole.
    pub penalty_share: f64,
}

/// Friction of an interface at the end of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrictionSummary {
    /// Slaves that stick.
    pub stuck: usize,
    /// Slaves that slide.
    pub sliding: usize,
    /// Mean traction: the sum of the moduli of friction over the area that carries force, force per area.
    pub traction: f64,
    /// Work of friction so far, energy.
    pub dissipated: f64,
    /// The largest part of μ p, in any increment, that slaves which slide over nodes lack, as their surface turns under them.
    #[serde(default)]
    pub short: f64,
}

/// A part of the model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PartSummary {
    /// Its name in the deck; `part.set` for each element set with a material of its own.
    pub name: String,
    /// Its nodes; those between two materials count in both.
    pub nodes: usize,
    /// Its elements; 0 if it is rigid.
    pub elements: usize,
    /// Those with incompatible modes: in a mesh of several kinds hexahedra with 8 nodes alone have them.
    #[serde(default)]
    pub incompatible_modes: usize,
    /// Its material; `None` if it is rigid.
    pub material: Option<Material>,
}

impl Summary {
    /// That of a deck's run before its first increment.
    pub fn new(deck: &Deck, model: &Model) -> Self {
        let elements = model.bodies.iter().map(|body| body.elements.len()).sum();
        Self {
            title: deck.title.clone(),
            element: deck.contact.name().to_owned(),
            size: [model.nodes.len(), elements],
            parts: parts(model),
            ..Self::default()
        }
    }

    /// Takes over what a run took.
    pub fn take(&mut self, effort: Effort) {
        self.cutbacks = effort.cutbacks;
        self.newton_iterations = effort.iterations;
    }

    /// Fallbacks of some increment that are more than those of the start, which has warnings of its own, in sentences.
    fn new_fallbacks(&self) -> impl Iterator<Item = String> {
        self.interfaces.iter().flat_map(|start| {
            let most = self.fallbacks.get(&start.interface).copied().unwrap_or_default();
            let slaves = start.slaves;
            most.warnings(start.fallbacks, &start.interface, slaves)
                .into_iter()
                .map(|one| format!("in an increment, {one}"))
        })
    }

    /// Slaves that were deep below their masters, in sentences.
    fn deep_slaves(&self) -> impl Iterator<Item = String> {
        self.interfaces.iter().flat_map(|start| {
            let found = self.penetrations.get(&start.interface).copied().unwrap_or_default();
            found.warnings(&start.interface, start.penalty)
        })
    }

    /// Interfaces whose penalties give way beside the bodies, in a sentence. Where bodies yield, forces follow from their strength.
    fn soft_penalties(&self) -> Option<String> {
        let yields =
            |part: &PartSummary| part.material.is_some_and(|material| material.plasticity().is_some());
        let share: f64 = self.contacts.values().map(|contact| contact.penalty_share).sum();
        if share <= SOFT || self.parts.iter().any(yields) {
            return None;
        }
        let soft = self.contacts.iter().filter(|(_, contact)| contact.penalty_share > SOFT_PART * share);
        let named: Vec<String> = soft.map(|(name, _)| format!("`{}`", shown(name))).collect();
        Some(format!(
            "contact takes {:.0} % of the elastic energy, by penetration at {}: where motions are prescribed forces are too low by about \
             that. A stiffer penalty or augmentation takes less",
            100.0 * share,
            named.join(", ")
        ))
    }

    /// Interfaces whose friction over nodes is too small, as surfaces turn far within an increment, in sentences.
    fn short_friction(&self) -> impl Iterator<Item = String> {
        let short = self.friction.iter().filter(|(_, friction)| friction.short > SHORT_FRICTION);
        short.map(|(name, friction)| {
            format!(
                "friction of the interface `{}` is up to {:.1} % too small: the surface turns under its slaves within an increment. Shorter \
                 increments, or `integration = \"faces\"`, have all of it",
                shown(name),
                100.0 * friction.short
            )
        })
    }

    /// What went wrong on the way, in sentences.
    pub fn shortcomings(&self) -> Vec<String> {
        let increments = self.increments;
        let counted = [
            (
                self.augmentations_short,
                format!(
                    "of {increments} increments ended their rounds of augmentation before the tolerance was met: a stiffer penalty or more \
                     rounds (augmentation.max) help"
                ),
            ),
            (
                self.increments_rounded,
                format!(
                    "of {increments} increments ended with a residual above what the tolerances allow, as rounding of the positions explains \
                     the rest: a model nearer to the origin, or a part less stiff, has less of it"
                ),
            ),
            (
                self.increments_unstable,
                format!(
                    "of {increments} increments had negative eigenvalues in the last stiffness that was solved with: equilibrium near there \
                     is not stable, as beyond buckling, or one of several"
                ),
            ),
            (
                self.contacts_lost,
                "contacts were lost: slaves went through the master, or carried force and their elements have no result, contact_status is 4 \
                 there; shorter increments or a stiffer penalty help"
                    .to_owned(),
            ),
            (
                self.points_missed,
                "points of loaded faces carried no force, over all increments: their element had no result, or their line of force met no place of the facet"
                    .to_owned(),
            ),
            (
                self.slaves_unanchored,
                "slaves carried force without friction for an increment: they had no gap at the end of the one before; a larger \
                 distance_limit or shorter increments help"
                    .to_owned(),
            ),
            (
                self.solutions_direct_instead,
                "linear systems were solved directly: the iterative solution did not converge; newton.linear_solver = \"direct\" saves the \
                 time that it takes in vain"
                    .to_owned(),
            ),
        ];
        let counted = counted.into_iter().filter(|&(count, _)| count > 0);
        let idle = self.interfaces_without_force.iter().map(|interface| {
            format!(
                "the interface `{}` never carried force at the end of an increment: is it out of reach, or does its master face the \
                 wrong way?",
                shown(interface)
            )
        });
        let vanished = self.interfaces_vanished.iter().map(|(interface, time)| {
            format!(
                "the force of the interface `{}` vanished in the increment to time {}, although slaves that carried it have not \
                 risen from the master: they went through it or beyond its border",
                shown(interface),
                ShownTime(*time)
            )
        });
        let counted = counted.map(|(count, what)| format!("{count} {what}"));
        let contacts = self.deep_slaves().chain(self.soft_penalties()).chain(self.short_friction());
        counted.chain(idle).chain(vanished).chain(contacts).chain(self.new_fallbacks()).collect()
    }
}

fn parts(model: &Model) -> Vec<PartSummary> {
    let body = |body: &Body| PartSummary {
        name: body.name.clone(),
        nodes: body.elements.nodes().iter().collect::<HashSet<_>>().len(),
        elements: body.elements.len(),
        incompatible_modes: body.elements.iter().filter(|cell| cell.incompatible_modes).count(),
        material: Some(body.material),
    };
    let part = |(name, _): (&str, usize)| {
        let bodies: Vec<PartSummary> =
            model.bodies.iter().filter(|body| body.part == name).map(body).collect();
        let nodes = model.node_sets.get(name).map_or(0, Vec::len);
        match &bodies[..] {
            [] => vec![PartSummary { name: name.to_owned(), nodes, ..PartSummary::default() }],
            [one] => vec![PartSummary { nodes, ..one.clone() }],
            _ => bodies,
        }
    };
    model.parts().into_iter().flat_map(part).collect()
}
