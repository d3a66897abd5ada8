//! Contact interfaces among the solver's forces and stiffnesses.
//!
//! An [`Interaction`] is one pair of surfaces of the deck: one pass, or two with the roles exchanged (two-pass). A pass is a
//! [`ContactInterface`](diffuse_contact::interface::ContactInterface) over nodes or a
//! [`FaceInterface`](diffuse_contact::faces::FaceInterface) over faces. It is a host of the contact surface like any other: refresh,
//! update the positions, evaluate, and add residual and tangent. Forces of a pair sum up to nothing.

mod adjust;
mod beginning;
mod between;
mod error;
mod face_pass;
mod fallbacks;
mod friction;
mod interaction;
mod losses;
mod node_pass;
mod operator;
mod options;
mod pass;
mod penetration;
mod proposal;
mod resultant;
mod tracks;

pub use adjust::{AdjustError, Adjusted, adjust};
pub use beginning::Beginning;
pub use error::ContactError;
pub use fallbacks::Fallbacks;
pub use friction::FrictionHistory;
pub(crate) use interaction::facet_size;
pub use interaction::{Augmented, Interaction, SlaveState};
pub use losses::{Loss, LostContact};
pub use operator::{ContactOperator, ContactTangent};
pub use options::{
    Augmentation, Coefficient, Friction, Integration, InteractionOptions, RefreshRule, TangentRule,
};
pub use pass::NodalForces;
pub(crate) use pass::{Bodies, Nearest};
use pass::{Pass, PassError};
pub use penetration::Penetration;
pub use resultant::Resultant;
pub use tracks::Way;

use std::collections::BTreeMap;

use diffuse_contact::assembly::Tangent;
use diffuse_contact::interface::FrictionReport;
use diffuse_contact::{Mode, Point};

use crate::system::{BlockMatrix, Symmetry};

/// All interactions of a problem.
#[derive(Debug, Default)]
pub struct ContactSet {
    interactions: Vec<Interaction>,
}

impl ContactSet {
    /// The interactions in the order of the deck.
    pub fn new(interactions: Vec<Interaction>) -> Self {
        Self { interactions }
    }

    /// The interactions in the order of the deck.
    pub fn interactions(&self) -> &[Interaction] {
        &self.interactions
    }

    /// Pairs the slaves of the interactions that `rule` is asked of anew; whether any did.
    ///
    /// # Errors
    /// [`ContactError::Interface`].
    pub fn refresh(&mut self, rule: RefreshRule, positions: &[[f64; 3]]) -> Result<bool, ContactError> {
        let mut any = false;
        for interaction in &mut self.interactions {
            if interaction.options().refresh == rule || rule == RefreshRule::Increment {
                interaction.refresh(positions)?;
                any = true;
            }
        }
        Ok(any)
    }

    /// Tells which nodes have all axes prescribed, one entry per node of the problem.
    pub fn hold(&mut self, held: &[bool]) {
        self.passes_mut().for_each(|pass| pass.hold(held));
    }

    /// Evaluates all contacts at these positions, those that carry force with their derivatives as far as `mode` asks and their
    /// tangent needs.
    ///
    /// # Errors
    /// [`ContactError::Interface`].
    pub fn evaluate(&mut self, positions: &[[f64; 3]], mode: Mode) -> Result<(), ContactError> {
        self.interactions.iter_mut().try_for_each(|interaction| interaction.evaluate(positions, mode))
    }

    /// Subtracts the contact forces from the internal forces, three entries per node. Returns the number of active
    /// contacts.
    ///
    /// # Errors
    /// [`ContactError::Assembly`].
    pub fn add_internal_forces(&mut self, forces: &mut [f64]) -> Result<usize, ContactError> {
        let mut active = 0;
        self.each(|pass| pass.add_internal_forces(forces).map(|count| active += count))?;
        Ok(active)
    }

    /// The part of what [`add_internal_forces`](Self::add_internal_forces) subtracts that moves nothing: slave and masters have all axes
    /// prescribed. Over faces that on nodes without any other contact.
    pub(crate) fn add_held_forces(&self, forces: &mut [f64]) {
        self.passes().for_each(|pass| pass.add_held_forces(forces));
    }

    /// The nodes that each slave couples that was paired at the last evaluation, for the pattern of the stiffness.
    pub fn cliques(&self) -> impl Iterator<Item = Vec<usize>> {
        self.passes().flat_map(|pass| pass.cliques())
    }

    /// From here on tangents are ε N Nᵀ in [`add_tangent`](Self::add_tangent), and the rest is an [`operator`](Self::operator).
    ///
    /// # Errors
    /// [`ContactError::NoOperator`] of an interaction over faces, or with a symmetric tangent of friction; some interactions may then
    /// have changed.
    pub fn operate(&mut self) -> Result<(), ContactError> {
        self.interactions.iter_mut().try_for_each(Interaction::operate)
    }

    /// What [`add_tangent`](Self::add_tangent) leaves out of the tangents it is asked for by the same arguments; `None` if nothing.
    ///
    /// # Errors
    /// [`ContactError::Interface`].
    pub fn operator(
        &self,
        norms: [f64; 2],
        tangent: Option<Tangent>,
    ) -> Result<Option<ContactOperator>, ContactError> {
        let mut passes = Vec::new();
        for interaction in &self.interactions {
            interaction.add_curvature(asked(interaction, norms, tangent), &mut passes)?;
        }
        Ok((!passes.is_empty()).then(|| ContactOperator::new(passes)))
    }

    /// Adds the contact tangents to a stiffness whose pattern holds the [`cliques`](Self::cliques),
    /// at a state with these norms of the residual and of the forces, or all with the same tangent. Returns whether they are symmetric.
    ///
    /// # Errors
    /// [`ContactError::Assembly`].
    pub fn add_tangent(
        &mut self,
        matrix: &mut BlockMatrix,
        norms: [f64; 2],
        tangent: Option<Tangent>,
    ) -> Result<Symmetry, ContactError> {
        let mut symmetry = Symmetry::Symmetric;
        for interaction in &mut self.interactions {
            let tangent = asked(interaction, norms, tangent);
            if interaction.add_tangent(matrix, tangent)? == Symmetry::General {
                symmetry = Symmetry::General;
            }
        }
        Ok(symmetry)
    }

    /// Evaluates the contacts as if open slaves touched, so that a part that only contact can hold is held. They push with ε g until
    /// [`recall`](Self::recall), which is due even after an error. Of the slaves of each body that is to be held, and of those that face
    /// it, the ones nearest to their masters are meant, and none farther away than the size of its facets.
    ///
    /// # Errors
    /// [`ContactError::Interface`].
    pub(crate) fn suppose(
        &mut self,
        positions: &[[f64; 3]],
        bodies: &Bodies,
        nearest: Nearest,
    ) -> Result<(), ContactError> {
        let mut least = BTreeMap::new();
        self.passes().for_each(|pass| pass.lower(bodies, &mut least));
        self.interactions.iter_mut().for_each(|interaction| interaction.suppose(bodies, nearest, &least));
        self.evaluate(positions, Mode::Hessian)
    }

    /// Ends what [`suppose`](Self::suppose) began, and evaluates the contacts as they are.
    ///
    /// # Errors
    /// [`ContactError::Interface`].
    pub(crate) fn recall(&mut self, positions: &[[f64; 3]]) -> Result<(), ContactError> {
        self.interactions.iter_mut().for_each(Interaction::recall);
        self.evaluate(positions, Mode::Hessian)
    }

    /// From here on with this part of all normal penalties; the next evaluation sees it.
    pub(crate) fn soften(&mut self, softness: f64) {
        self.passes_mut().for_each(|pass| pass.state_mut().softness = softness);
    }

    /// Whether there are any interactions.
    pub(crate) fn are_none(&self) -> bool {
        self.interactions.is_empty()
    }

    /// From here on without any friction, or with it again; the next evaluation sees it.
    pub(crate) fn leave_out_friction(&mut self, is_left_out: bool) {
        self.passes_mut().for_each(|pass| pass.leave_out_friction(is_left_out));
    }

    /// Whether any interaction has friction.
    pub(crate) fn has_friction(&self) -> bool {
        self.interactions.iter().any(|interaction| interaction.options().friction.is_some())
    }

    /// Takes the feet of all slaves with friction for their anchors where there is no history yet. To be called before the first
    /// increment, after a refresh.
    ///
    /// # Errors
    /// [`ContactError::Interface`].
    pub fn begin_friction(&mut self) -> Result<(), ContactError> {
        self.each(|pass| pass.begin_friction())
    }

    /// Accepts the last evaluation as the end of an increment; what friction did in each interaction that has any.
    ///
    /// # Errors
    /// [`ContactError::Interface`].
    pub fn accept(&mut self) -> Result<Vec<Option<FrictionReport>>, ContactError> {
        self.interactions.iter_mut().map(Interaction::accept).collect()
    }

    /// The history of friction of all passes, for a restart.
    pub fn friction_history(&self) -> Vec<FrictionHistory> {
        self.passes().map(|pass| pass.friction_history()).collect()
    }

    /// Goes on from a history as [`friction_history`](Self::friction_history) gave it.
    ///
    /// # Errors
    /// [`ContactError::OtherPasses`] and [`ContactError::Interface`] if it belongs to other interactions.
    pub fn set_friction_history(&mut self, history: &[FrictionHistory]) -> Result<(), ContactError> {
        self.check_count("histories of friction", history.len())?;
        let mut own = history.iter();
        self.each(|pass| own.next().map_or(Ok(()), |own| pass.set_friction_history(own)))
    }

    /// Measures friction as in the increment that led to this history, so that slaves that slid at its end slide on; whether there was
    /// one. [`set_friction_history`](Self::set_friction_history) and [`lasts`](Self::lasts) end that. A refresh has to follow.
    ///
    /// # Errors
    /// As [`set_friction_history`](Self::set_friction_history).
    pub(crate) fn look_back(&mut self, history: &[FrictionHistory]) -> Result<bool, ContactError> {
        let (mut own, mut any) = (history.iter(), false);
        self.each(|pass| {
            any |= own.next().map_or(Ok(false), |own| pass.look_back(own))?;
            Ok(())
        })?;
        Ok(any)
    }

    /// Updates the multipliers of the augmented Lagrangian interactions, normal and tangential, if another round is
    /// [`Due`](Augmented::Due) for one of them. Otherwise, with all gaps and slips within their tolerances or all rounds over, the
    /// multipliers stay.
    ///
    /// # Errors
    /// [`ContactError::Interface`].
    pub fn augment(&mut self, round: usize) -> Result<Augmented, ContactError> {
        let mut augmented = Augmented::Met;
        for interaction in &self.interactions {
            augmented = augmented.max(interaction.augmented(round)?);
        }
        if augmented == Augmented::Due {
            self.interactions.iter_mut().try_for_each(|interaction| interaction.augment(round))?;
        }
        Ok(augmented)
    }

    /// Tells how long the increment lasts that is to be solved: slip rates are by this time.
    pub fn lasts(&mut self, duration: f64) {
        self.passes_mut().for_each(|pass| pass.lasts(duration));
    }

    /// The slaves of each pass that carry force, by their places in it: like the multipliers a part of the history.
    pub fn loaded(&self) -> Vec<Vec<u32>> {
        self.passes().map(|pass| pass.loaded()).collect()
    }

    /// Begins an increment from where [`loaded`](Self::loaded) gave this: [`lost`](Self::lost) are then those of the increment.
    ///
    /// # Errors
    /// [`ContactError::OtherPasses`] if they belong to other interactions.
    pub fn begin(&mut self, loaded: &[Vec<u32>]) -> Result<(), ContactError> {
        self.check_count("loaded slaves", loaded.len())?;
        self.passes_mut().zip(loaded).try_for_each(|(pass, own)| pass.begin(own))
    }

    /// Notes which contacts carry force at the last evaluation.
    pub fn note(&mut self) {
        self.passes_mut().for_each(|pass| pass.note());
    }

    /// Excuses the slaves without an element at the last evaluation, one at the beginning of the increment, and remembers what faces lie
    /// over there.
    pub fn excuse(&mut self) {
        self.passes_mut().for_each(|pass| pass.excuse());
    }

    /// The slaves that have no contact at the last evaluation although they carried force in the increment or right before it and have not
    /// left the master, or were over it and went through. With the interaction's name. `way`: from
    /// where the increment began to the positions of the last evaluation.
    pub fn lost(&self, way: Way<'_>) -> impl Iterator<Item = (&str, LostContact)> {
        self.interactions.iter().flat_map(move |interaction| {
            let name = interaction.options().name.as_str();
            interaction.passes().flat_map(move |pass| pass.lost(way)).map(move |lost| (name, lost))
        })
    }

    /// Names of the interactions with slaves that carried force in the increment or right before it and are beyond the master's border at
    /// the last evaluation, and how many these are.
    pub fn left(&self) -> impl Iterator<Item = (String, usize)> {
        let left = |own: &Interaction| own.passes().map(|pass| pass.left()).sum();
        self.named(left).filter(|&(_, count)| count > 0)
    }

    /// Names of the interactions that carried force when the increment began and carry none at the last evaluation although slaves that
    /// carried it have not risen from their masters, and how many these are. They went through them, beyond their borders, or have elements
    /// without a result.
    pub fn vanished(&self, way: Way<'_>) -> impl Iterator<Item = (String, usize)> {
        self.named(move |own| own.vanished(way)).filter(|&(_, count)| count > 0)
    }

    /// Names of the interactions with slaves whose masters do not carry the fit that was asked for, at the last evaluation.
    pub fn fallbacks(&self) -> impl Iterator<Item = (String, Fallbacks)> {
        self.named(Interaction::fallbacks).filter(|(_, fallbacks)| !fallbacks.is_none())
    }

    /// Names of the interfaces with slaves that lie deep below their masters, beside the size of their facets or the longest way of a node,
    /// at the last evaluation, which was at these positions, or with nodes of the master in the slave's faces.
    pub fn penetrations(
        &self,
        positions: &[Point],
        longest: f64,
    ) -> impl Iterator<Item = (String, Penetration)> {
        self.named(move |own| own.penetration(positions, longest)).filter(|(_, found)| !found.is_none())
    }

    /// Names of the interfaces over faces whose average gaps are open, but points of whose faces nearly touch, at the last evaluation.
    pub fn late(&self) -> impl Iterator<Item = String> {
        self.named(Interaction::is_late).filter(|(_, is_late)| *is_late).map(|(name, _)| name)
    }

    /// What is found of each interaction, with its name.
    fn named<T>(&self, find: impl Fn(&Interaction) -> T) -> impl Iterator<Item = (String, T)> {
        self.interactions.iter().map(move |own| (own.options().name.clone(), find(own)))
    }

    /// Integration points of loaded faces that carry no force at the last evaluation although they have a gap: their line of force
    /// meets no place of the facet over them.
    pub fn missed(&self) -> usize {
        self.passes().map(|pass| pass.missed()).sum()
    }

    /// The multipliers of all interactions, for a restart.
    pub fn multipliers(&self) -> Vec<Vec<f64>> {
        self.passes().map(|pass| pass.state().multipliers.clone()).collect()
    }

    /// Takes over multipliers as [`multipliers`](Self::multipliers) gave them.
    ///
    /// # Errors
    /// [`ContactError::OtherPasses`] if they belong to other interactions.
    pub fn set_multipliers(&mut self, multipliers: &[Vec<f64>]) -> Result<(), ContactError> {
        self.check_count("multipliers", multipliers.len())?;
        self.passes_mut().zip(multipliers).try_for_each(|(pass, own)| pass.set_multipliers(own))
    }

    /// Whether nodes couple that did not when this was asked last: the stiffness then needs another pattern.
    pub fn take_grown(&mut self) -> bool {
        self.passes_mut().fold(false, |any, pass| pass.take_grown() | any)
    }

    /// Passes of all interactions.
    pub fn pass_count(&self) -> usize {
        self.passes().count()
    }

    /// Refuses a history with other than one entry for each pass.
    fn check_count(&self, what: &'static str, found: usize) -> Result<(), ContactError> {
        let expected = self.pass_count();
        if found == expected { Ok(()) } else { Err(ContactError::OtherPasses { what, found, expected }) }
    }

    fn passes(&self) -> impl Iterator<Item = &dyn Pass> {
        self.interactions.iter().flat_map(Interaction::passes)
    }

    fn passes_mut(&mut self) -> impl Iterator<Item = &mut Box<dyn Pass>> {
        self.interactions.iter_mut().flat_map(Interaction::passes_mut)
    }

    /// Does the same with each pass; an error gets the interaction's name.
    fn each(
        &mut self,
        mut step: impl FnMut(&mut dyn Pass) -> Result<(), PassError>,
    ) -> Result<(), ContactError> {
        self.interactions.iter_mut().try_for_each(|interaction| interaction.each(&mut step))
    }

    /// What each interaction exerts in all.
    pub fn resultants(&self, positions: &[[f64; 3]]) -> Vec<Resultant> {
        self.interactions.iter().map(|interaction| interaction.resultant(positions)).collect()
    }

    /// Deepest penetration of any slave at the last evaluation, as [`Interaction::max_penetration`], length; 0 without any.
    pub fn max_penetration(&self) -> f64 {
        self.interactions.iter().map(Interaction::max_penetration).fold(0.0, f64::max)
    }
}

/// The tangent of an interaction at a state with these norms of the residual and of the forces, if it is not given.
fn asked(interaction: &Interaction, [residual, force]: [f64; 2], given: Option<Tangent>) -> Tangent {
    given.unwrap_or_else(|| interaction.options().tangent.at(residual, force))
}
