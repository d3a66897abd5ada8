//! What has to be in equilibrium, and its history.

use std::time::Instant;

use diffuse_contact::Mode;
use serde::{Deserialize, Serialize};

use super::{Failure, LinearEffort, NewtonSettings, Pressure, StaticsError, Timing};
use crate::contact::{ContactError, ContactSet, ContactTangent, FrictionHistory, RefreshRule};
use crate::material::PointState;
use crate::model::Supports;
use crate::solid::{Order, Solid, SolidResponse};
use crate::system::{BlockMatrix, BlockPattern, Equations, LinearSolver, LinearSolverChoice};

/// Forces of this many times their rounding are to be in equilibrium in each part.
const FAR_FROM_ROUNDING: f64 = 1e6;

/// All history: an increment starts from one and ends in one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Pseudo-time.
    pub time: f64,
    /// Length of the next increment; 0: the first one.
    pub length: f64,
    /// Increments so far.
    pub increments: usize,
    /// Linear solutions so far, those of failed increments among them.
    pub iterations: usize,
    /// Increments that failed so far.
    pub cutbacks: usize,
    /// Positions of all nodes, length.
    pub positions: Vec<[f64; 3]>,
    /// Where they were at the start of the last increment, if the next one extrapolates from there.
    pub past: Option<Past>,
    /// Plastic state of each integration point.
    #[serde(with = "super::sparse")]
    pub points: Vec<PointState>,
    /// The same at the start of the last increment: from there the tangent at `positions` goes on with the flow.
    #[serde(with = "super::sparse")]
    pub points_before: Vec<PointState>,
    /// Multipliers of each pass of each interaction, force.
    pub multipliers: Vec<Vec<f64>>,
    /// Slaves that carry force, by their places in each pass.
    pub loaded: Vec<Vec<u32>>,
    /// History of friction of each pass.
    pub friction: Vec<FrictionHistory>,
}

/// Positions in equilibrium at an earlier time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Past {
    /// Pseudo-time.
    pub time: f64,
    /// Positions of all nodes, length.
    pub positions: Vec<[f64; 3]>,
}

/// Solids, supports, loads and contacts, with forces and stiffness at the positions of the last evaluation.
pub struct Problem {
    pub(super) start: Vec<[f64; 3]>,
    pub(super) solid: Solid,
    pub(super) supports: Supports,
    pub(super) pressures: Vec<Pressure>,
    pub(super) contacts: ContactSet,
    pub(super) response: SolidResponse,
    /// Of the solid, f_int.
    internal: Vec<f64>,
    /// Of the loads, f_ext.
    external: Vec<f64>,
    /// −Σ f_k N_k
    pub(super) contact: Vec<f64>,
    /// The part of it that moves nothing.
    held: Vec<f64>,
    /// Whether all axes of each node are prescribed.
    is_held: Vec<bool>,
    /// f_int of the elements that have such nodes only.
    strained: Vec<f64>,
    active: usize,
    /// Residual that is small enough whatever the forces are.
    pub(super) negligible: f64,
    /// At the last evaluation.
    pub(super) balance: Balance,
    /// ε |K| |x|, what rounding of the positions makes of the residual, by the last stiffness of the increment; empty before it.
    pub(super) rounding: Vec<f64>,
    /// Linear solutions of the increment for which contacts were supposed to be closed.
    pub(super) supposed: usize,
    /// Whether to suppose contacts has held nothing in the increment.
    pub(super) is_in_vain: bool,
    /// Linear solutions in which nothing but the stabilisation held a part.
    pub(super) stabilised: usize,
    /// Part of the stiffness' diagonal that is added to it.
    pub(super) stabilisation: f64,
    pub(super) equations: Equations,
    pub(super) solver: LinearSolver,
    /// Of the linear solutions of the increment.
    pub(super) linear: LinearEffort,
    /// The size of the last right-hand side, if its solution was iterative.
    pub(super) size: Option<f64>,
    /// The residual of the last solution by factors, if it is small only beside rounding.
    pub(super) rounded: Option<f64>,
    /// Negative eigenvalues of the increment's last stiffness, if its factors tell.
    pub(super) negative: Option<usize>,
    /// Pairs of nodes that share an element.
    pub(super) links: BlockPattern,
    /// `None`: the pairing has changed, a new pattern is due.
    pub(super) stiffness: Option<BlockMatrix>,
    /// Nodes that contact couples by the pattern of the stiffness, ascending.
    pub(super) coupled: Vec<u32>,
    pub(super) timing: Timing,
}

/// Norms of the forces at an evaluation.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Balance {
    /// ‖r‖ over the free degrees of freedom.
    pub residual: f64,
    /// The largest of the norms of external forces, reactions and contact forces, without what can move nothing: loads on prescribed
    /// degrees of freedom, elements and contact among nodes that are prescribed along all axes.
    pub scale: f64,
    /// ‖max(0, |r| − ε |K| |x|)‖ over the free degrees of freedom: what rounding of the positions does not explain. Before the
    /// increment's first linear solution it is all of the residual.
    pub excess: f64,
}

impl Balance {
    /// The residual over the forces; 0 without any.
    pub fn relative(&self) -> f64 {
        if self.residual == 0.0 { 0.0 } else { self.residual / self.scale }
    }
}

impl Problem {
    /// Everything in equilibrium from `start` on. Indices of nodes in the parts are in range. `threads`: those of the linear
    /// solver.
    pub fn new(
        start: Vec<[f64; 3]>,
        solid: Solid,
        supports: Supports,
        pressures: Vec<Pressure>,
        mut contacts: ContactSet,
        threads: usize,
    ) -> Self {
        let freedoms = 3 * start.len();
        let prescribed = supports.prescribed();
        let is_held: Vec<bool> = prescribed.iter().map(|axes| axes.iter().all(|&axis| axis)).collect();
        contacts.hold(&is_held);
        let equations = Equations::new(&prescribed);
        let links = BlockPattern::new(start.len(), solid.elements());
        Self {
            start,
            solid,
            supports,
            pressures,
            contacts,
            response: SolidResponse::default(),
            internal: vec![0.0; freedoms],
            external: vec![0.0; freedoms],
            contact: vec![0.0; freedoms],
            held: vec![0.0; freedoms],
            is_held,
            strained: vec![0.0; freedoms],
            active: 0,
            negligible: 0.0,
            balance: Balance::default(),
            rounding: Vec::new(),
            supposed: 0,
            is_in_vain: false,
            stabilised: 0,
            stabilisation: 0.0,
            equations,
            solver: LinearSolver::new(threads),
            linear: LinearEffort::default(),
            links,
            size: None,
            rounded: None,
            negative: None,
            stiffness: None,
            coupled: Vec::new(),
            timing: Timing::default(),
        }
    }

    /// The state at time 0.
    pub fn start(&self) -> State {
        State {
            time: 0.0,
            length: 0.0,
            increments: 0,
            iterations: 0,
            cutbacks: 0,
            positions: self.start.clone(),
            past: None,
            points: self.solid.states(),
            points_before: self.solid.states(),
            multipliers: self.contacts.multipliers(),
            loaded: vec![Vec::new(); self.contacts.pass_count()],
            friction: vec![FrictionHistory::default(); self.contacts.pass_count()],
        }
    }

    /// Whether a state can be gone on from.
    ///
    /// # Errors
    /// [`StaticsError::ForeignState`], [`StaticsError::Contact`].
    pub fn check_state(&mut self, state: &State) -> Result<(), StaticsError> {
        let counts = [
            ("nodes", state.positions.len(), self.start.len()),
            ("integration points", state.points.len(), self.solid.states().len()),
            ("integration points before", state.points_before.len(), self.solid.states().len()),
        ];
        let past = state.past.iter().map(|past| ("nodes before", past.positions.len(), self.start.len()));
        for (what, found, expected) in counts.into_iter().chain(past) {
            if found != expected {
                return Err(StaticsError::ForeignState { what, found, expected });
            }
        }
        Ok(self.take_history(state)?)
    }

    /// Goes back to the history of contact of a state: nothing of what came after it is left.
    pub(super) fn take_history(&mut self, state: &State) -> Result<(), ContactError> {
        self.rounding.clear();
        (self.supposed, self.is_in_vain, self.stabilised) = (0, false, 0);
        self.linear = LinearEffort::default();
        self.negative = None;
        self.contacts.set_multipliers(&state.multipliers)?;
        self.contacts.set_friction_history(&state.friction)?;
        self.contacts.begin(&state.loaded)
    }

    /// Pairs and evaluates the contacts at a state, to be looked at; [`Statics::run`](super::Statics::run) pairs on its own.
    ///
    /// # Errors
    /// [`StaticsError::Contact`].
    pub fn look_at_contacts(&mut self, state: &State) -> Result<(), StaticsError> {
        self.take_history(state)?;
        self.contacts.refresh(RefreshRule::Increment, &state.positions)?;
        self.contacts.begin_friction()?;
        self.stiffness = None;
        self.contacts.evaluate(&state.positions, Mode::Gradient)?;
        Ok(())
    }

    /// Positions of the nodes at the start.
    pub fn start_positions(&self) -> &[[f64; 3]] {
        &self.start
    }

    /// The longest way of a node from the start to these positions, length.
    pub(super) fn largest_motion(&self, positions: &[[f64; 3]]) -> f64 {
        let way = |(x, start): (&[f64; 3], &[f64; 3])| {
            (0..3).map(|axis| (x[axis] - start[axis]).powi(2)).sum::<f64>().sqrt()
        };
        positions.iter().zip(&self.start).map(way).fold(0.0, f64::max)
    }

    /// The solid.
    pub fn solid(&self) -> &Solid {
        &self.solid
    }

    /// The prescribed motions.
    pub fn supports(&self) -> &Supports {
        &self.supports
    }

    /// The contacts at the last evaluation.
    pub fn contacts(&self) -> &ContactSet {
        &self.contacts
    }

    /// Contacts that carry force at the last evaluation.
    pub fn active(&self) -> usize {
        self.active
    }

    /// f_int − f_ext − Σ f_k N_k of the last evaluation, three entries per node: where prescribed, the reaction of the support; else minus
    /// the residual.
    pub fn imbalance(&self) -> impl Iterator<Item = f64> {
        self.internal.iter().zip(&self.external).zip(&self.contact).map(|((i, e), c)| i + c - e)
    }

    /// From here on with these settings. By default residuals up to what rounding makes of forces are none; where the tangent of contact is
    /// an operator, linear systems are solved iteratively.
    pub(super) fn set(&mut self, newton: &NewtonSettings) -> Result<(), ContactError> {
        self.negligible = newton.absolute.unwrap_or_else(|| self.solid.rounding_of_forces(&self.start));
        self.stabilisation = newton.stabilisation;
        let choice = match newton.contact_tangent {
            ContactTangent::Assembled => newton.linear_solver,
            ContactTangent::Operator => LinearSolverChoice::Iterative,
        };
        self.solver.choose(choice, &self.links, &self.equations);
        if newton.contact_tangent == ContactTangent::Operator { self.contacts.operate() } else { Ok(()) }
    }

    /// Plastic states of the points at the last evaluation.
    pub fn last_points(&self) -> &[PointState] {
        &self.response.states
    }

    pub(super) fn response(&self) -> &SolidResponse {
        &self.response
    }

    pub(super) fn contacts_mut(&mut self) -> &mut ContactSet {
        &mut self.contacts
    }

    /// Pairs anew; the stiffness then needs a new pattern.
    pub(super) fn refresh(&mut self, rule: RefreshRule, positions: &[[f64; 3]]) -> Result<(), Failure> {
        let begin = Instant::now();
        let any = self.contacts.refresh(rule, positions).map_err(Failure::Contact)?;
        if any {
            self.stiffness = None;
        }
        self.timing.pairing += begin.elapsed();
        Ok(())
    }

    /// Excuses the slaves without an element at these positions, where the increment begins: a shorter one does not keep them.
    pub(super) fn excuse(&mut self, positions: &[[f64; 3]]) -> Result<(), Failure> {
        let begin = Instant::now();
        self.contacts.evaluate(positions, Mode::Gradient).map_err(Failure::Contact)?;
        self.contacts.excuse();
        self.timing.contact += begin.elapsed();
        Ok(())
    }

    /// Whether there are slaves that are paired anew in every iteration.
    pub(super) fn pairs_in_iterations(&self) -> bool {
        let interactions = self.contacts.interactions();
        interactions.iter().any(|interaction| interaction.options().refresh == RefreshRule::Iteration)
    }

    /// Forces at `positions`, and what the stiffness is made of if `order` asks for it.
    pub(super) fn evaluate(
        &mut self,
        time: f64,
        positions: &[[f64; 3]],
        committed: &[PointState],
        order: Order,
    ) -> Result<Balance, Failure> {
        let begin = Instant::now();
        self.solid.evaluate(positions, committed, order, &mut self.response).map_err(Failure::of_solid)?;
        self.add_internal_forces();
        self.external.fill(0.0);
        for pressure in &self.pressures {
            pressure.add_forces(time, &self.start, positions, &mut self.external);
        }
        let solid = Instant::now();
        self.timing.solid += solid - begin;
        let mode = match order {
            Order::Residual => Mode::Gradient,
            Order::Tangent => Mode::Hessian,
        };
        self.contacts.evaluate(positions, mode).map_err(Failure::Contact)?;
        self.contact.fill(0.0);
        self.active = self.contacts.add_internal_forces(&mut self.contact).map_err(Failure::Contact)?;
        self.held.fill(0.0);
        self.contacts.add_held_forces(&mut self.held);
        self.timing.contact += solid.elapsed();
        self.balance = self.norms();
        Ok(self.balance)
    }

    fn add_internal_forces(&mut self) {
        self.internal.fill(0.0);
        self.strained.fill(0.0);
        for element in self.solid.responses(&self.response) {
            let moves_nothing = element.nodes.iter().all(|&node| self.is_held[node]);
            for (node, force) in element.nodes.iter().zip(element.forces.as_chunks::<3>().0) {
                for axis in 0..3 {
                    self.internal[3 * node + axis] += force[axis];
                    if moves_nothing {
                        self.strained[3 * node + axis] += force[axis];
                    }
                }
            }
        }
    }

    /// Of the parts that carry force the one farthest from equilibrium: the excess of its forces over the largest of the norms of
    /// external forces, contact forces and reactions on its nodes. Without external forces a part counts if the others are far from
    /// rounding. 0 if there are none, or a single part.
    pub(super) fn worst_part(&self) -> f64 {
        let parts = self.solid.parts();
        if parts.len() < 2 {
            return 0.0;
        }
        let imbalance: Vec<f64> = self.imbalance().collect();
        let of_part = |(_, nodes): &(String, Vec<usize>)| {
            let (mut excess, mut external, mut others, mut noise) = (0.0, 0.0, 0.0, 0.0);
            for freedom in nodes.iter().flat_map(|&node| 3 * node..3 * node + 3) {
                let contact = self.contact[freedom] - self.held[freedom];
                if self.supports.is_free(freedom) {
                    let rounding = self.rounding.get(freedom).copied().unwrap_or(0.0);
                    excess += (imbalance[freedom].abs() - rounding).max(0.0).powi(2);
                    noise += rounding * rounding;
                    external += self.external[freedom].powi(2);
                    others += contact.powi(2);
                } else {
                    others += (self.internal[freedom] - self.strained[freedom] + contact).powi(2);
                }
            }
            let excess = (excess.sqrt() - self.negligible).max(0.0);
            let is_judged = external > 0.0 || noise > 0.0 && others.sqrt() > FAR_FROM_ROUNDING * noise.sqrt();
            if is_judged { excess / external.max(others).sqrt() } else { 0.0 }
        };
        parts.iter().map(of_part).fold(0.0, f64::max)
    }

    fn norms(&self) -> Balance {
        let norm = |sum: f64| sum.sqrt();
        let (mut residual, mut excess, mut reaction, mut external) = (0.0, 0.0, 0.0, 0.0);
        for (freedom, force) in self.imbalance().enumerate() {
            if self.supports.is_free(freedom) {
                residual += force * force;
                external += self.external[freedom].powi(2);
                let rounding = self.rounding.get(freedom).copied().unwrap_or(0.0);
                // A force that is no number is in excess.
                if !(force.abs() <= rounding) {
                    excess += (force.abs() - rounding).powi(2);
                }
            } else {
                // The deck makes any force of strains and penetrations between prescribed nodes, and loads them as it likes.
                let of_elements = self.internal[freedom] - self.strained[freedom];
                reaction += (of_elements + self.contact[freedom] - self.held[freedom]).powi(2);
            }
        }
        let contact: f64 = self.contact.iter().zip(&self.held).map(|(all, held)| (all - held).powi(2)).sum();
        let scale = external.max(contact).max(reaction);
        Balance { residual: norm(residual), scale: norm(scale), excess: norm(excess) }
    }
}
