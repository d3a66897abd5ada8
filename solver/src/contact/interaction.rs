//! One pair of surfaces.

use std::collections::HashMap;
use std::sync::Arc;

use diffuse_contact::assembly::{Tangent, TangentOperator};
use diffuse_contact::faces::{FaceRule, QuadraticFace};
use diffuse_contact::friction::{DecayingCoefficient, FrictionState, TabulatedCoefficient};
use diffuse_contact::interface::{FrictionReport, InterfaceOptions, NoContact};
use diffuse_contact::surface::{Facet, SymmetryPlane, tributary_areas};
use diffuse_contact::{Mode, Point};

use super::face_pass::FacePass;
use super::losses::is_failure;
use super::node_pass::NodePass;
use super::pass::{FrictionHistory, NodalForces, Pass, PassError};
use super::{ContactError, LostContact, Way};
use crate::system::{BlockMatrix, Symmetry};

/// What contact is integrated over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integration {
    /// The slave's nodes, one force each: the energy form, symmetric and conservative.
    #[default]
    Nodes,
    /// The slave's faces, with pressures averaged to their nodes: passes the patch test, its tangent is not symmetric.
    Faces(FaceRule),
}

/// When slaves are paired anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RefreshRule {
    /// At the beginning of an increment, at the positions the last one ended with.
    #[default]
    Increment,
    /// At the beginning of an increment and of every iteration.
    Iteration,
}

impl RefreshRule {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Increment, Self::Iteration];

    /// Name in decks.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Increment => "increment",
            Self::Iteration => "iteration",
        }
    }
}

/// Which tangent of contact a linear solution has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TangentRule {
    /// The exact one near equilibrium, ε N Nᵀ alone far from it: [`Tangent::adaptive`].
    #[default]
    Adaptive,
    /// Always ε N Nᵀ − f M (Chamoret et al. 2008, eq. 43).
    Exact,
    /// Always ε N Nᵀ.
    GaussNewton,
}

impl TangentRule {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Adaptive, Self::Exact, Self::GaussNewton];

    /// Name in decks.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Adaptive => "adaptive",
            Self::Exact => Tangent::Exact.name(),
            Self::GaussNewton => Tangent::GaussNewton.name(),
        }
    }

    /// The tangent at a state with these norms of the residual and of the forces.
    #[must_use]
    pub fn at(self, residual: f64, force: f64) -> Tangent {
        match self {
            Self::Adaptive => Tangent::adaptive(residual, force),
            Self::Exact => Tangent::Exact,
            Self::GaussNewton => Tangent::GaussNewton,
        }
    }
}

/// Rounds of Uzawa's iteration: when an increment has converged, λ ← max(0, λ − ε g), and it is solved again, until every contact
/// that carries force is closed and no other one penetrates. Those of friction: tractions become multipliers, until slips are those that
/// Coulomb's law allows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Augmentation {
    /// |g| of contacts that carry force, and −g of others, that ends the rounds, length; of friction the slip that should not be.
    pub tolerance: f64,
    /// Most rounds in an increment, at least 1.
    pub max_rounds: usize,
}

impl Augmentation {
    /// Up to ten rounds, until gaps are within a tolerance.
    #[must_use]
    pub const fn new(tolerance: f64) -> Self {
        Self { tolerance, max_rounds: 10 }
    }

    /// With so many rounds at most.
    #[must_use]
    pub const fn with_max_rounds(self, max_rounds: usize) -> Self {
        Self { max_rounds, ..self }
    }
}

/// μ
#[derive(Clone, Debug, PartialEq)]
pub enum Coefficient {
    /// The same for all contacts, ≥ 0; 0 is no friction.
    Constant(f64),
    /// It decays from rest to fast sliding.
    Decaying(DecayingCoefficient),
    /// By pressure and slip rate.
    Tabulated(Arc<TabulatedCoefficient>),
}

/// Coulomb friction between two surfaces.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Friction {
    /// μ
    pub coefficient: Coefficient,
    /// ε_T, force per slip of a slave node that sticks, with areas force per area and slip; `None`: as large as the penalty.
    pub stiffness: Option<f64>,
    /// τ > 0, which no slave node exceeds, force, with areas and over faces force per area; `None`: none.
    pub shear_limit: Option<f64>,
    /// Whether the tangent leaves out what is not symmetric: linear systems are solved in half of the time, and it takes more of them.
    pub is_symmetric: bool,
    /// Rounds that take the slip of slaves that stick away; `None`: they creep by their elastic slip.
    pub augmentation: Option<Augmentation>,
}

impl Friction {
    /// With this coefficient, a stiffness as large as the penalty, the exact tangent, and without augmentation.
    #[must_use]
    pub const fn new(coefficient: Coefficient) -> Self {
        Self { coefficient, stiffness: None, shear_limit: None, is_symmetric: false, augmentation: None }
    }

    /// With augmentation, or without.
    #[must_use]
    pub fn with_augmentation(self, augmentation: Option<Augmentation>) -> Self {
        Self { augmentation, ..self }
    }

    /// With this tangential stiffness, or the penalty's.
    #[must_use]
    pub fn with_stiffness(self, stiffness: Option<f64>) -> Self {
        Self { stiffness, ..self }
    }

    /// With this shear limit, or none.
    #[must_use]
    pub fn with_shear_limit(self, shear_limit: Option<f64>) -> Self {
        Self { shear_limit, ..self }
    }

    /// With the symmetric part of the tangent only, or all of it.
    #[must_use]
    pub fn with_symmetric_tangent(self, is_symmetric: bool) -> Self {
        Self { is_symmetric, ..self }
    }
}

/// How two surfaces interact.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct InteractionOptions {
    /// Its name in the deck.
    pub name: String,
    /// ε > 0: force per length and slave node, or force per length³ if the interface carries areas. In a two-pass interaction each
    /// pass gets half of it.
    pub penalty: f64,
    /// Augmented Lagrangian; `None`: penalty alone.
    pub augmentation: Option<Augmentation>,
    /// When slaves are paired anew.
    pub refresh: RefreshRule,
    /// The exact tangent, ε N Nᵀ alone, or the one or the other by the residual.
    pub tangent: TangentRule,
    /// Whether the surfaces are also paired the other way round.
    pub two_pass: bool,
    /// Whether master and slave are one surface, in contact with itself. Its nodes get half of the penalty each, as those of two passes.
    pub self_contact: bool,
    /// Element and pairing.
    pub interface: InterfaceOptions,
    /// Planes in which the master goes on as its mirror image.
    pub symmetry: Vec<SymmetryPlane>,
    /// Coulomb friction.
    pub friction: Option<Friction>,
    /// What contact is integrated over. Over faces, which are cut in every iteration, the penalty is per area.
    pub integration: Integration,
    /// Faces of second order that facets of either surface are parts of: over faces they carry the forces.
    pub quadratic_faces: Vec<QuadraticFace>,
    /// The gap up to which slaves were moved into touch before the start, length; only told on.
    pub adjust: Option<f64>,
}

impl InteractionOptions {
    /// Penalty alone, paired at the beginning of an increment, with the adaptive tangent, one pass, the default element and no
    /// planes of symmetry.
    #[must_use]
    pub fn new(name: impl Into<String>, penalty: f64) -> Self {
        Self {
            name: name.into(),
            penalty,
            augmentation: None,
            refresh: RefreshRule::default(),
            tangent: TangentRule::default(),
            two_pass: false,
            self_contact: false,
            interface: InterfaceOptions::default(),
            symmetry: Vec::new(),
            friction: None,
            integration: Integration::default(),
            quadratic_faces: Vec::new(),
            adjust: None,
        }
    }

    /// With slaves that were adjusted, or without.
    #[must_use]
    pub fn with_adjust(self, adjust: Option<f64>) -> Self {
        Self { adjust, ..self }
    }

    /// With augmentation, or without.
    #[must_use]
    pub fn with_augmentation(self, augmentation: Option<Augmentation>) -> Self {
        Self { augmentation, ..self }
    }

    /// With this rule of pairing anew.
    #[must_use]
    pub fn with_refresh(self, refresh: RefreshRule) -> Self {
        Self { refresh, ..self }
    }

    /// With this tangent.
    #[must_use]
    pub fn with_tangent(self, tangent: TangentRule) -> Self {
        Self { tangent, ..self }
    }

    /// Paired the other way round, too, or not.
    #[must_use]
    pub fn with_two_pass(self, two_pass: bool) -> Self {
        Self { two_pass, ..self }
    }

    /// With one surface in contact with itself, or with two.
    #[must_use]
    pub fn with_self_contact(self, self_contact: bool) -> Self {
        Self { self_contact, ..self }
    }

    /// With this element and pairing.
    #[must_use]
    pub fn with_interface(self, interface: InterfaceOptions) -> Self {
        Self { interface, ..self }
    }

    /// With these planes of symmetry.
    #[must_use]
    pub fn with_symmetry(self, symmetry: Vec<SymmetryPlane>) -> Self {
        Self { symmetry, ..self }
    }

    /// With friction, or without.
    #[must_use]
    pub fn with_friction(self, friction: Option<Friction>) -> Self {
        Self { friction, ..self }
    }

    /// Integrated over nodes or faces.
    #[must_use]
    pub fn with_integration(self, integration: Integration) -> Self {
        Self { integration, ..self }
    }

    /// With faces of second order.
    #[must_use]
    pub fn with_quadratic_faces(self, quadratic_faces: Vec<QuadraticFace>) -> Self {
        Self { quadratic_faces, ..self }
    }
}

/// Root of the mean area of facets, of which nodes have these tributary areas; 0 without any.
pub(crate) fn facet_size(areas: &[f64], facets: &[Facet]) -> f64 {
    (areas.iter().sum::<f64>() / facets.len().max(1) as f64).sqrt()
}

/// Contact of one slave node at the last evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlaveState {
    /// The slave node.
    pub node: usize,
    /// Its gap, length; `None` if it has no contact element.
    pub gap: Option<f64>,
    /// Contact force, ≥ 0.
    pub force: f64,
    /// Normal at the foot; zero without a gap.
    pub normal: Point,
    /// What the contact exerts on the slave node: force · N, nearly along the normal, and friction. The smooth surface follows the slave
    /// by its weights, so that a small part of force · N lies in the tangent plane.
    pub nodal_force: Point,
    /// The part of it that is friction, −c ∇q.
    pub friction: Point,
    /// Whether it sticks or slides.
    pub friction_state: FrictionState,
    /// Its way from its anchor since it touched, length: of one that slides, what it slid in the increment and its elastic slip.
    pub slip: f64,
    /// Tributary area, length²; 1 if the interface carries none. Over faces, of a slave in contact, the part of it over the master.
    pub area: f64,
    /// Whether its masters carry no quadratic surface, so that it has the linear basis.
    pub is_linear: bool,
    /// Whether it should have a contact element but has none: no masters carry a fit, or the fit no foot.
    pub has_failed: bool,
    /// Whether slave and masters are prescribed along all axes, so that no force moves anything.
    pub is_held: bool,
}

impl SlaveState {
    /// A slave that has no contact element.
    pub(super) fn without(node: usize, area: f64, reason: NoContact) -> Self {
        Self {
            node,
            gap: None,
            force: 0.0,
            normal: [0.0; 3],
            nodal_force: [0.0; 3],
            friction: [0.0; 3],
            friction_state: FrictionState::Open,
            slip: 0.0,
            area,
            is_linear: false,
            has_failed: is_failure(reason),
            is_held: false,
        }
    }
}

/// How far an interaction is from what its augmentation asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Augmented {
    /// Every gap is within the tolerance, or there is no augmentation.
    Met,
    /// Some gaps are not, but the rounds are over.
    Short,
    /// Another round is due.
    Due,
}

/// Two surfaces that do not penetrate each other.
#[derive(Debug)]
pub struct Interaction {
    options: InteractionOptions,
    passes: Vec<Box<dyn Pass>>,
    /// Mean size of the slaves' facets of each pass at the start, length.
    sizes: Vec<f64>,
    /// Tributary areas of the nodes of both sides at the start, length².
    areas: HashMap<usize, f64>,
    /// Facets of both sides.
    facets: Vec<Facet>,
    /// The multipliers of each pass from before others were supposed.
    before: Vec<Vec<f64>>,
}

impl Interaction {
    /// The nodes, or the faces, of `slave` against the facets of `master`; with [`two_pass`](InteractionOptions::two_pass) also the
    /// other way round. With [`self_contact`](InteractionOptions::self_contact) the nodes of `master` against its own facets.
    ///
    /// # Errors
    /// [`ContactError::Penalty`], [`ContactError::Master`], [`ContactError::Interface`].
    pub fn new(
        options: InteractionOptions,
        master: &[Facet],
        slave: &[Facet],
        positions: &[Point],
    ) -> Result<Self, ContactError> {
        let (name, penalty) = (&options.name, options.penalty);
        if !(penalty > 0.0 && penalty.is_finite()) {
            return Err(ContactError::Penalty { interface: name.clone(), value: penalty });
        }
        let pass = |master, slave, penalty| -> Result<Box<dyn Pass>, ContactError> {
            Ok(match options.integration {
                Integration::Nodes => Box::new(NodePass::new(&options, penalty, master, slave, positions)?),
                Integration::Faces(rule) => {
                    Box::new(FacePass::new(&options, rule, penalty, (master, slave), positions)?)
                }
            })
        };
        let passes = if options.self_contact {
            vec![pass(master, master, 0.5 * penalty)?]
        } else if options.two_pass {
            vec![pass(master, slave, 0.5 * penalty)?, pass(slave, master, 0.5 * penalty)?]
        } else {
            vec![pass(master, slave, penalty)?]
        };
        let (mut sizes, mut areas) = (Vec::new(), HashMap::new());
        for side in [slave, master] {
            // The facets were checked when the passes were made.
            let of_nodes = tributary_areas(positions, side).unwrap_or_default();
            sizes.push(facet_size(&of_nodes, side));
            areas.extend(of_nodes.into_iter().enumerate().filter(|&(_, area)| area > 0.0));
        }
        // One side is both where a surface is in contact with itself.
        let other = if options.self_contact { &[] } else { master };
        let facets = [slave, other].concat();
        Ok(Self { options, passes, sizes, areas, facets, before: Vec::new() })
    }

    /// The options.
    #[must_use]
    pub fn options(&self) -> &InteractionOptions {
        &self.options
    }

    /// The contact of every slave node at the last evaluation, pass by pass.
    pub fn slaves(&self) -> impl Iterator<Item = SlaveState> {
        self.passes.iter().flat_map(|pass| pass.slaves())
    }

    /// Forces on each of `count` nodes at the last evaluation.
    #[must_use]
    pub fn nodal_forces(&self, count: usize) -> NodalForces {
        let mut all = NodalForces { forces: vec![[0.0; 3]; count], friction: vec![[0.0; 3]; count] };
        self.passes.iter().for_each(|pass| pass.add_nodal_forces(&mut all));
        all
    }

    pub(super) fn refresh(&mut self, positions: &[Point]) -> Result<(), ContactError> {
        self.each(|pass| pass.refresh(positions))
    }

    pub(super) fn evaluate(&mut self, positions: &[Point], mode: Mode) -> Result<(), ContactError> {
        self.each(|pass| pass.evaluate(positions, mode))
    }

    pub(super) fn add_internal_forces(&mut self, forces: &mut [f64]) -> Result<usize, ContactError> {
        let mut active = 0;
        self.each(|pass| pass.add_internal_forces(forces).map(|count| active += count))?;
        Ok(active)
    }

    /// Takes the slaves' feet for their anchors, if there is friction without a history.
    pub(super) fn begin_friction(&mut self) -> Result<(), ContactError> {
        self.each(|pass| pass.begin_friction())
    }

    /// Accepts the last evaluation as the end of an increment; what friction did in it.
    pub(super) fn accept(&mut self) -> Result<Option<FrictionReport>, ContactError> {
        let mut sum = self.options.friction.as_ref().map(|_| FrictionReport::default());
        self.each(|pass| {
            let report = pass.accept()?;
            if let Some(sum) = &mut sum {
                *sum += report;
            }
            Ok(())
        })?;
        Ok(sum)
    }

    pub(super) fn leave_out_friction(&mut self, is_left_out: bool) {
        self.passes.iter_mut().for_each(|pass| pass.leave_out_friction(is_left_out));
    }

    pub(super) fn friction_history(&self) -> impl Iterator<Item = FrictionHistory> {
        self.passes.iter().map(|pass| pass.friction_history())
    }

    pub(super) fn set_friction_history(&mut self, history: &[FrictionHistory]) -> Result<(), ContactError> {
        let mut own = history.iter();
        self.each(|pass| own.next().map_or(Ok(()), |own| pass.set_friction_history(own)))
    }

    /// Goes back to the start of the last increment; whether any pass had one.
    pub(super) fn look_back(&mut self, history: &[FrictionHistory]) -> Result<bool, ContactError> {
        let (mut own, mut any) = (history.iter(), false);
        self.each(|pass| {
            any |= own.next().map_or(Ok(false), |own| pass.look_back(own))?;
            Ok(())
        })?;
        Ok(any)
    }

    /// Work of friction so far, energy.
    #[must_use]
    pub fn dissipated(&self) -> f64 {
        self.passes.iter().map(|pass| pass.dissipated()).sum()
    }

    pub(super) fn cliques(&self) -> impl Iterator<Item = Vec<usize>> {
        self.passes.iter().flat_map(|pass| pass.cliques())
    }

    /// From here on −f M is not assembled.
    pub(super) fn operate(&mut self) -> Result<(), ContactError> {
        match self.passes.iter_mut().all(|pass| pass.operate()) {
            true => Ok(()),
            false => Err(ContactError::NoOperator { interface: self.options.name.clone() }),
        }
    }

    /// Adds −f M of the passes that do not assemble it.
    pub(super) fn add_curvature(&self, all: &mut Vec<TangentOperator>) -> Result<(), ContactError> {
        for pass in &self.passes {
            all.extend(pass.curvature().map_err(|error| error.of(&self.options.name))?);
        }
        Ok(())
    }

    pub(super) fn add_tangent(
        &mut self,
        matrix: &mut BlockMatrix,
        tangent: Tangent,
    ) -> Result<Symmetry, ContactError> {
        let mut symmetry = Symmetry::Symmetric;
        self.each(|pass| {
            if pass.add_tangent(matrix, tangent)? == Symmetry::General {
                symmetry = Symmetry::General;
            }
            Ok(())
        })?;
        Ok(symmetry)
    }

    /// What is there to do after so many rounds.
    pub(super) fn augmented(&self, round: usize) -> Result<Augmented, ContactError> {
        let judge = |augmentation: Augmentation, error: f64| match error <= augmentation.tolerance {
            true => Augmented::Met,
            false if round < augmentation.max_rounds => Augmented::Due,
            false => Augmented::Short,
        };
        let normal = self.options.augmentation.map(|augmentation| judge(augmentation, self.gap_error()));
        let of_friction = match self.friction_augmentation() {
            Some(augmentation) => Some(judge(augmentation, self.slip_error()?)),
            None => None,
        };
        Ok(normal.max(of_friction).unwrap_or(Augmented::Met))
    }

    fn friction_augmentation(&self) -> Option<Augmentation> {
        self.options.friction.as_ref().and_then(|friction| friction.augmentation)
    }

    /// How far the contacts are from Coulomb's law without an elastic slip, length: the largest slip of those that stick, and part across
    /// the traction of those that slide. Those that can move nothing are left out; 0 without augmentation of friction.
    ///
    /// # Errors
    /// [`ContactError`].
    pub fn slip_error(&self) -> Result<f64, ContactError> {
        let named = |error: PassError| error.of(&self.options.name);
        let mut errors = self.passes.iter().map(|pass| pass.slip_error().map_err(named));
        errors.try_fold(0.0, |largest: f64, error| Ok(largest.max(error?)))
    }

    /// How far the contacts are from f ≥ 0, g ≥ 0, f g = 0, length: the largest |g| of those that carry force and −g of the
    /// others. Those that can move nothing are left out.
    #[must_use]
    pub fn gap_error(&self) -> f64 {
        let moved = self.slaves().filter(|slave| !slave.is_held);
        let error =
            |slave: SlaveState| slave.gap.map_or(0.0, |gap| if slave.force > 0.0 { gap.abs() } else { -gap });
        moved.map(error).fold(0.0, f64::max)
    }

    pub(super) fn hold(&mut self, held: &[bool]) {
        self.passes.iter_mut().for_each(|pass| pass.hold(held));
    }

    pub(super) fn loaded(&self) -> impl Iterator<Item = Vec<u32>> {
        self.passes.iter().map(|pass| pass.loaded())
    }

    pub(super) fn begin(&mut self, loaded: &[Vec<u32>]) -> Result<(), ContactError> {
        self.passes.iter_mut().zip(loaded).try_for_each(|(pass, own)| pass.begin(own))
    }

    pub(super) fn note(&mut self) {
        self.passes.iter_mut().for_each(|pass| pass.note());
    }

    pub(super) fn excuse(&mut self) {
        self.passes.iter_mut().for_each(|pass| pass.excuse());
    }

    /// The slaves that carried force since the beginning of the increment, or at it, and have no contact although they have not left
    /// the master.
    pub fn lost(&self, way: Way<'_>) -> impl Iterator<Item = LostContact> {
        self.passes.iter().flat_map(move |pass| pass.lost(way))
    }

    /// As [`ContactSet::vanished`](super::ContactSet::vanished).
    pub(super) fn vanished(&self, way: Way<'_>) -> usize {
        if self.slaves().any(|slave| slave.force > 0.0) {
            return 0;
        }
        self.passes.iter().map(|pass| pass.vanished(way)).sum()
    }

    pub(super) fn straight(&self) -> usize {
        self.passes.iter().map(|pass| pass.straight()).sum()
    }

    pub(super) fn missed(&self) -> usize {
        self.passes.iter().map(|pass| pass.missed()).sum()
    }

    pub(super) fn augment(&mut self, round: usize) -> Result<(), ContactError> {
        let goes_on = |augmentation: Augmentation| round < augmentation.max_rounds;
        // With the multipliers of the equilibrium: before they are updated.
        if self.friction_augmentation().is_some_and(goes_on) {
            self.each(|pass| pass.augment_friction())?;
        }
        if self.options.augmentation.is_some_and(goes_on) {
            self.passes.iter_mut().for_each(|pass| pass.augment());
        }
        Ok(())
    }

    pub(super) fn lasts(&mut self, duration: f64) {
        self.passes.iter_mut().for_each(|pass| pass.lasts(duration));
    }

    /// From here on the open slaves of these parts that are nearest to the master push with ε g. Their tangent is that of contact, and
    /// minus their force would pull them onto the master.
    pub(super) fn suppose(&mut self, parts: &[Vec<bool>]) {
        for (pass, size) in self.passes.iter_mut().zip(&self.sizes) {
            let supposed = parts.iter().fold(Vec::new(), |all, part| pass.supposed(part, *size, all));
            let mut multipliers = if supposed.is_empty() { pass.multipliers().to_vec() } else { supposed };
            pass.exchange_multipliers(&mut multipliers);
            self.before.push(multipliers);
        }
    }

    /// Ends what [`suppose`](Self::suppose) began.
    pub(super) fn recall(&mut self) {
        for (pass, mut before) in self.passes.iter_mut().zip(self.before.drain(..)) {
            pass.exchange_multipliers(&mut before);
        }
    }

    pub(super) fn pass_count(&self) -> usize {
        self.passes.len()
    }

    pub(super) fn multipliers(&self) -> impl Iterator<Item = Vec<f64>> {
        self.passes.iter().map(|pass| pass.multipliers().to_vec())
    }

    pub(super) fn set_multipliers(&mut self, multipliers: &[Vec<f64>]) -> Result<(), ContactError> {
        self.passes.iter_mut().zip(multipliers).try_for_each(|(pass, own)| pass.set_multipliers(own))
    }

    pub(super) fn take_grown(&mut self) -> bool {
        self.passes.iter_mut().fold(false, |any, pass| pass.take_grown() | any)
    }

    /// Deepest penetration at the last evaluation, length, whether it carries force or not; 0 without any. Where slave and masters
    /// are all prescribed it is the deck's, and left out.
    #[must_use]
    pub fn max_penetration(&self) -> f64 {
        let moved = self.slaves().filter(|slave| !slave.is_held);
        moved.filter_map(|slave| slave.gap).map(|gap| -gap).fold(0.0, f64::max)
    }

    pub(super) fn passes(&self) -> impl Iterator<Item = &dyn Pass> {
        self.passes.iter().map(AsRef::as_ref)
    }

    /// Mean size of the slave's facets at the start, length.
    pub(super) fn facet_size(&self) -> f64 {
        self.sizes[0]
    }

    /// Facets of both sides.
    pub(crate) fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// Area that belongs to a node of either side at the start, length².
    pub(crate) fn tributary_area(&self, node: usize) -> f64 {
        self.areas.get(&node).copied().unwrap_or(0.0)
    }

    /// Does the same with each pass; an error gets the interaction's name.
    fn each(
        &mut self,
        mut step: impl FnMut(&mut dyn Pass) -> Result<(), PassError>,
    ) -> Result<(), ContactError> {
        let name = &self.options.name;
        self.passes.iter_mut().try_for_each(|pass| step(pass.as_mut()).map_err(|error| error.of(name)))
    }
}
