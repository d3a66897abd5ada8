//! What an interaction does with each of its passes, whatever contact is integrated over.

use std::collections::BTreeMap;

use diffuse_contact::Mode;
use diffuse_contact::Point;
use diffuse_contact::assembly::{AssemblyError, ContactLaw, DofMap, Tangent, TangentOperator};
use diffuse_contact::faces::IntegrationPoint;
use diffuse_contact::interface::{FrictionReport, InterfaceError, NoContact, Outcome};
use diffuse_contact::surface::MasterSurface;

use super::friction::{FrictionHistory, PassFriction};
use super::losses::Losses;
use super::tracks::{Finder, Tracks};
use super::{ContactError, InteractionOptions, LostContact, SlaveState, TangentRule, Way};
use crate::system::{BlockMatrix, Symmetry};

/// What contact exerts on each node, as slave and as master, in all passes.
#[derive(Clone, Debug)]
pub struct NodalForces {
    /// All of it: what enters equilibrium.
    pub forces: Vec<Point>,
    /// The part that is friction.
    pub friction: Vec<Point>,
}

/// A step of a pass that failed.
#[derive(Debug, thiserror::Error)]
pub enum PassError {
    #[error(transparent)]
    Interface(#[from] InterfaceError),
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
}

impl PassError {
    /// The error with the interaction's name.
    pub fn of(self, name: &str) -> ContactError {
        let interface = name.to_owned();
        match self {
            Self::Interface(source) => ContactError::Interface { interface, source },
            Self::Assembly(source) => ContactError::Assembly { interface, source },
        }
    }
}

/// What every pass has, whatever contact is integrated over.
#[derive(Debug)]
pub struct PassState {
    penalty: f64,
    /// Factor on the penalty, 1 but on the way to equilibrium.
    pub softness: f64,
    pub tangent: TangentRule,
    pub friction: Option<PassFriction>,
    /// What friction remembers besides the interface's history, which is left empty here.
    history: FrictionHistory,
    pub dofs: DofMap,
    /// λ, one per slave; none without augmentation.
    pub multipliers: Vec<f64>,
    /// Whether all axes of each node are prescribed.
    pub held: Vec<bool>,
    /// Whether those of all nodes of the master are.
    is_master_held: bool,
    /// Whether more nodes couple since somebody asked.
    pub has_grown: bool,
    losses: Losses,
}

impl PassState {
    /// Of so many slaves among so many nodes; the penalty, over faces per area, is that of the pass.
    pub fn new(
        options: &InteractionOptions,
        penalty: f64,
        slaves: usize,
        nodes: usize,
    ) -> Result<Self, ContactError> {
        Ok(Self {
            penalty,
            softness: 1.0,
            tangent: options.tangent,
            friction: PassFriction::new(options, penalty)?,
            history: FrictionHistory::default(),
            dofs: DofMap::standard(nodes),
            multipliers: if options.augmentation.is_some() { vec![0.0; slaves] } else { Vec::new() },
            held: vec![false; nodes],
            is_master_held: false,
            has_grown: false,
            losses: Losses::default(),
        })
    }

    /// The penalty of the moment.
    pub const fn penalty(&self) -> f64 {
        self.penalty * self.softness
    }

    /// The law of all slaves' normal forces.
    pub fn normal_law(&self) -> ContactLaw<'_> {
        let multipliers = (!self.multipliers.is_empty()).then_some(self.multipliers.as_slice());
        ContactLaw::penalty(self.penalty()).with_multipliers(multipliers).with_tangent(Tangent::Exact)
    }

    /// The law of all slaves, also of friction.
    pub fn law(&self) -> ContactLaw<'_> {
        self.with_friction(self.normal_law())
    }

    /// A law with the pass's friction.
    pub fn with_friction<'a>(&'a self, law: ContactLaw<'a>) -> ContactLaw<'a> {
        law.with_friction(self.friction.as_ref().map(PassFriction::law))
    }
}

/// Integration points that carry pressures of their own.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pressed {
    /// Of the slave's faces in the first configuration, length².
    pub area: f64,
    /// Energy.
    pub stored: f64,
}

/// Which open slaves are supposed to touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Nearest {
    /// Those whose gap is less than this part of their facets' size above the least one of the body.
    OfBody(f64),
    /// The same, above the least one of the body in each pass.
    OfPass(f64),
}

/// Added to the gap of a slave that is supposed to touch, over the facets' size: without any force it would not count.
const LITTLE: f64 = 1e-12;

/// Bodies that contact is supposed to hold, by node.
pub struct Bodies {
    of_node: Vec<u32>,
}

impl Bodies {
    /// The nodes of each of them; of a node in two the first counts.
    pub fn new<'a>(nodes: usize, bodies: impl IntoIterator<Item = (usize, &'a [usize])>) -> Self {
        let mut of_node = vec![u32::MAX; nodes];
        for (body, own) in bodies {
            for &node in own {
                of_node[node] = of_node[node].min(body as u32);
            }
        }
        Self { of_node }
    }

    /// All nodes as one.
    pub fn whole(nodes: usize) -> Self {
        Self { of_node: vec![0; nodes] }
    }

    fn of(&self, node: usize) -> Option<usize> {
        Some(self.of_node[node] as usize).filter(|&body| body != u32::MAX as usize)
    }
}

/// One side's surface against the other's.
pub trait Pass: std::fmt::Debug {
    /// What every pass has.
    fn state(&self) -> &PassState;

    /// The same, to be changed.
    fn state_mut(&mut self) -> &mut PassState;

    /// Pairs anew.
    fn refresh(&mut self, positions: &[Point]) -> Result<(), PassError>;

    /// Contact at these positions, with as many derivatives as the tangent needs.
    fn evaluate(&mut self, positions: &[Point], mode: Mode) -> Result<(), PassError>;

    /// Lists of nodes that couple.
    fn cliques(&self) -> Vec<Vec<usize>>;

    /// Subtracts the contact forces; the number of contacts that carry one.
    fn add_internal_forces(&mut self, forces: &mut [f64]) -> Result<usize, PassError>;

    /// Subtracts the part of the contact forces that moves nothing, as far as nodes tell it from the rest.
    fn add_held_forces(&self, forces: &mut [f64]);

    /// Adds the tangents of the contacts that carry force; whether they are symmetric.
    fn add_tangent(&mut self, matrix: &mut BlockMatrix, tangent: Tangent) -> Result<Symmetry, PassError>;

    /// From here on only ε N Nᵀ is added to a matrix, and the rest of the tangent is an operator; whether that is possible.
    fn operate(&mut self) -> bool {
        false
    }

    /// What is left of this tangent at the last evaluation, if it is an operator: −f M of the exact one, and friction.
    fn curvature(&self, _tangent: Tangent) -> Result<Option<TangentOperator>, PassError> {
        Ok(None)
    }

    /// Whether the interface has a history of friction.
    fn has_history(&self) -> bool;

    /// That history; empty before the first increment.
    fn anchors(&self) -> Vec<f64>;

    /// The same with the rounds of augmentation in the increment on its way.
    fn augmented_anchors(&self) -> Vec<f64>;

    /// Goes on from it.
    fn set_anchors(&mut self, anchors: &[f64]) -> Result<(), InterfaceError>;

    /// Accepts the positions of the moment in the interface's history.
    fn accept_anchors(&mut self) -> Result<FrictionReport, InterfaceError>;

    /// λ ← max(0, λ − ε g), but where nothing can move: there no multiplier closes the gap.
    fn augment(&mut self);

    /// The slip of each slave that Coulomb's law does not allow, length.
    fn slip_errors(&self) -> Result<Vec<f64>, InterfaceError>;

    /// The tractions of these slaves become multipliers.
    fn augment_friction_of(&mut self, moved: &[bool]) -> Result<(), InterfaceError>;

    /// Whether nothing moves whatever force the contact of the `k`-th slave exerts.
    fn is_held(&self, k: usize) -> bool;

    /// The multiplier that a gap of this slave takes all force from.
    fn multiplier_of(&self, slave: &SlaveState, gap: f64) -> f64;

    /// The master's facets.
    fn master(&self) -> &MasterSurface;

    /// How what slaves were over is found.
    fn finder(&self) -> Finder<'_>;

    /// Remembers what slaves are over, where nothing else tells it later.
    fn remember(&mut self) {}

    /// Open slaves that may be supposed to touch, by the bodies that they are on or face: place, state and gap.
    fn open(&self, bodies: &Bodies) -> BTreeMap<usize, Vec<(usize, SlaveState, f64)>> {
        let mut open: BTreeMap<usize, Vec<_>> = BTreeMap::new();
        // They face one of the bodies, whichever it is.
        let faces_one = self.master().nodes().iter().any(|&node| bodies.of(node as usize).is_some());
        for (k, slave) in self.slaves().enumerate().filter(|(_, slave)| slave.force == 0.0 && !slave.is_held)
        {
            let Some(gap) = slave.gap else { continue };
            for body in bodies.of(slave.node).into_iter().chain(faces_one.then_some(usize::MAX)) {
                open.entry(body).or_default().push((k, slave, gap));
            }
        }
        open
    }

    /// Lowers `least` to the least gap of open slaves, by the bodies that they are on or face.
    fn lower(&self, bodies: &Bodies, least: &mut BTreeMap<usize, f64>) {
        for (body, open) in self.open(bodies) {
            let least = least.entry(body).or_insert(f64::INFINITY);
            *least = open.iter().map(|&(.., gap)| gap).fold(*least, f64::min);
        }
    }

    /// Multipliers by which the open slaves of each body, and those that face it, push with ε g, if their gap is less than the part `near`
    /// of `size` above the least one, and less than `size`; its own for other slaves. Empty if there are none.
    fn supposed(&self, bodies: &Bodies, size: f64, near: f64, least: &BTreeMap<usize, f64>) -> Vec<f64> {
        let mut multipliers = Vec::new();
        for (body, open) in self.open(bodies) {
            let least = least.get(&body).copied().unwrap_or(size).min(size);
            for (k, slave, gap) in &open {
                if !(*gap < (least + near * size).min(size)) {
                    continue;
                }
                if multipliers.is_empty() {
                    multipliers.extend_from_slice(&self.state().multipliers);
                    multipliers.resize(self.slave_count(), 0.0);
                }
                multipliers[*k] = self.multiplier_of(slave, 2.0 * gap.max(0.0) + LITTLE * size);
            }
        }
        multipliers
    }

    /// Number of slave nodes.
    fn slave_count(&self) -> usize;

    /// Each slave node, and whether the last evaluation found contact for it.
    fn outcomes(&self) -> Vec<(usize, Outcome)>;

    /// The contact of every slave node at the last evaluation.
    fn slaves(&self) -> Box<dyn Iterator<Item = SlaveState> + '_>;

    /// The integration points over the master; none over nodes.
    fn integration_points(&self) -> Result<Vec<IntegrationPoint>, InterfaceError> {
        Ok(Vec::new())
    }

    /// Whether integration points have pressures of their own.
    fn has_point_pressures(&self) -> bool {
        false
    }

    /// Area under pressure and what the springs of the penalty store, by these points.
    fn pressed(&self) -> Pressed {
        Pressed::default()
    }

    /// Adds what each contact exerts on its slave and its masters at the last evaluation.
    fn add_nodal_forces(&self, all: &mut NodalForces);

    /// Edge middles and centres of slave faces that have no smooth surface of their own although one is asked for.
    fn straight(&self) -> usize {
        0
    }

    /// Points of loaded faces that carry no force at the last evaluation although they have a gap.
    fn missed(&self) -> usize {
        0
    }

    /// Takes over which nodes have all axes prescribed.
    fn hold(&mut self, held: &[bool]) {
        let is_master_held = self.master().nodes().iter().all(|&node| held[node as usize]);
        let state = self.state_mut();
        state.held.copy_from_slice(held);
        state.is_master_held = is_master_held;
    }

    /// Whether nodes couple that did not when this was asked last: the stiffness then needs another pattern.
    fn take_grown(&mut self) -> bool {
        std::mem::take(&mut self.state_mut().has_grown)
    }

    /// Takes the slaves' feet for their anchors, if there is friction without a history.
    fn begin_friction(&mut self) -> Result<(), PassError> {
        if self.state().friction.is_some() && !self.has_history() {
            self.accept()?;
        }
        Ok(())
    }

    /// Accepts the positions of the moment as the end of an increment.
    fn accept(&mut self) -> Result<FrictionReport, PassError> {
        // What the increment was solved with: without its rounds its end would not be found again.
        let before = self.augmented_anchors();
        let report = self.accept_anchors()?;
        let PassState { history, friction, .. } = self.state_mut();
        if let Some(friction) = friction {
            history.anchors_before = before;
            history.lasted = friction.duration;
            history.dissipated += report.dissipated;
        }
        Ok(report)
    }

    /// From here on without friction, if there is any, or with it again; the next evaluation sees it.
    fn leave_out_friction(&mut self, is_left_out: bool) {
        self.state_mut().friction.iter_mut().for_each(|friction| friction.is_left_out = is_left_out);
    }

    /// What friction remembers.
    fn friction_history(&self) -> FrictionHistory {
        FrictionHistory { anchors: self.anchors(), ..self.state().history.clone() }
    }

    /// Goes on from it.
    fn set_friction_history(&mut self, history: &FrictionHistory) -> Result<(), PassError> {
        self.set_anchors(&history.anchors)?;
        self.state_mut().history = FrictionHistory { anchors: Vec::new(), ..history.clone() };
        Ok(())
    }

    /// Goes back to the start of the last increment, so that its end is evaluated as it was found; whether there was one.
    fn look_back(&mut self, history: &FrictionHistory) -> Result<bool, PassError> {
        if history.anchors_before.is_empty() {
            return Ok(false);
        }
        self.set_anchors(&history.anchors_before)?;
        self.lasts(history.lasted);
        Ok(true)
    }

    /// Work of friction so far, energy.
    fn dissipated(&self) -> f64 {
        self.state().history.dissipated
    }

    /// How long the increment lasts that is to be solved.
    fn lasts(&mut self, duration: f64) {
        self.state_mut().friction.iter_mut().for_each(|friction| friction.duration = duration);
    }

    /// The slip that Coulomb's law does not allow, of slaves that can move, length; 0 without augmentation of friction.
    fn slip_error(&self) -> Result<f64, PassError> {
        if !self.has_augmented_friction() {
            return Ok(0.0);
        }
        let moved = self.slip_errors()?.into_iter().enumerate().filter(|&(k, _)| !self.is_held(k));
        Ok(moved.map(|(_, error)| error).fold(0.0, f64::max))
    }

    /// Whether its friction has multipliers: a coefficient of 0 has none, whatever the options say.
    fn has_augmented_friction(&self) -> bool {
        self.state().friction.as_ref().is_some_and(|friction| friction.is_augmented)
    }

    /// Tractions become multipliers, if there are any, but where nothing can move.
    fn augment_friction(&mut self) -> Result<(), PassError> {
        if !self.has_augmented_friction() {
            return Ok(());
        }
        let moved: Vec<bool> = (0..self.slave_count()).map(|k| !self.is_held(k)).collect();
        Ok(self.augment_friction_of(&moved)?)
    }

    /// Goes on from multipliers, as many as it has.
    fn set_multipliers(&mut self, multipliers: &[f64]) -> Result<(), ContactError> {
        let own = &mut self.state_mut().multipliers;
        let (found, expected) = (multipliers.len(), own.len());
        if found != expected {
            return Err(ContactError::OtherPasses { what: "multipliers", found, expected });
        }
        own.copy_from_slice(multipliers);
        Ok(())
    }

    /// Begins to watch for losses; `loaded` as [`loaded`](Self::loaded) gave it.
    fn begin(&mut self, loaded: &[u32]) -> Result<(), ContactError> {
        let slaves = self.slave_count();
        self.state_mut().losses.begin(slaves, loaded)
    }

    /// Notes which slaves carry force.
    fn note(&mut self) {
        for k in self.loaded() {
            self.state_mut().losses.note(k as usize);
        }
    }

    /// At an increment's start: slaves without an element need not get one.
    fn excuse(&mut self) {
        self.remember();
        for (k, (_, outcome)) in self.outcomes().into_iter().enumerate() {
            match outcome {
                Outcome::None(reason) => self.state_mut().losses.excuse(k, reason),
                Outcome::Contact { .. } if self.state().is_master_held && self.is_held(k) => (),
                Outcome::Contact { .. } => self.state_mut().losses.starts_over(k),
            }
        }
    }

    /// The slaves that have no contact although they carried force and have not left the master, or were over it and went through.
    fn lost(&self, way: Way<'_>) -> Vec<LostContact> {
        let mut tracks = Tracks::new(way, self.master(), self.finder());
        // Over faces, one of those around a slave may have gone through while others have not.
        let is_whole =
            |outcome: &Outcome| outcome.is_contact() && !matches!(self.finder(), Finder::Faces(..));
        let outcomes = self.outcomes().into_iter().enumerate().filter(|(_, (_, outcome))| !is_whole(outcome));
        let judge = |(k, (node, outcome))| self.state().losses.judge(k, node, outcome, &mut tracks);
        outcomes.filter_map(judge).collect()
    }

    /// How many slaves carried force since the increment began, or right before it, and are beyond the master's border now.
    fn left(&self) -> usize {
        let outcomes = self.outcomes().into_iter().enumerate();
        let is_beyond = |outcome| matches!(outcome, Outcome::None(NoContact::BeyondBorder { .. }));
        outcomes.filter(|&(k, (_, outcome))| is_beyond(outcome) && self.state().losses.carried(k)).count()
    }

    /// How many slaves carried force when the increment began, and have neither a contact now nor risen from the master.
    fn vanished(&self, way: Way<'_>) -> usize {
        let mut tracks = Tracks::new(way, self.master(), self.finder());
        let outcomes = self.outcomes().into_iter().enumerate();
        let vanished = outcomes.filter(|&(k, (node, outcome))| match outcome {
            Outcome::None(reason) => self.state().losses.vanished(k, node, reason, &mut tracks),
            Outcome::Contact { .. } => false,
        });
        vanished.count()
    }

    /// The places of the slaves that carry force, ascending. Those that can move nothing on any part of the master are left out: without
    /// their contact equilibrium is the same.
    fn loaded(&self) -> Vec<u32> {
        let is_master_held = self.state().is_master_held;
        let is_one = |slave: &SlaveState| slave.force > 0.0 && !(slave.is_held && is_master_held);
        let places = self.slaves().enumerate().filter(|(_, slave)| is_one(slave));
        places.map(|(k, _)| k as u32).collect()
    }
}

/// What passes over nodes and over faces do alike, each with its own kind of interface.
macro_rules! by_interface {
    () => {
        fn state(&self) -> &PassState {
            &self.state
        }

        fn state_mut(&mut self) -> &mut PassState {
            &mut self.state
        }

        fn has_history(&self) -> bool {
            self.interface.has_history()
        }

        fn anchors(&self) -> Vec<f64> {
            self.interface.history()
        }

        fn augmented_anchors(&self) -> Vec<f64> {
            self.interface.augmented_history()
        }

        fn set_anchors(&mut self, anchors: &[f64]) -> Result<(), InterfaceError> {
            self.interface.set_history(anchors)
        }

        fn accept_anchors(&mut self) -> Result<FrictionReport, InterfaceError> {
            self.interface.accept(&self.state.law())
        }

        fn slip_errors(&self) -> Result<Vec<f64>, InterfaceError> {
            self.interface.slip_errors(&self.state.law())
        }

        fn augment_friction_of(&mut self, moved: &[bool]) -> Result<(), InterfaceError> {
            self.interface.augment(&self.state.law(), |k| moved[k])
        }

        fn master(&self) -> &MasterSurface {
            self.interface.master()
        }

        fn slave_count(&self) -> usize {
            self.interface.slaves().len()
        }
    };
}

pub(super) use by_interface;
