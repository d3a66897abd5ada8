//! One pair of surfaces.

use diffuse_contact::assembly::Tangent;
use diffuse_contact::interface::InterfaceOptions;
use diffuse_contact::surface::Facet;
use diffuse_contact::{Mode, Point};

use super::pass::Pass;
use super::{ContactError, SlavePairing};
use crate::system::{BlockMatrix, BlockPattern};

/// When slaves are paired anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RefreshRule {
    /// At the beginning of an increment, at the positions the last one ended with.
    #[default]
    Increment,
    /// At the beginning of an increment and of every iteration.
    Iteration,
}

/// Rounds of Uzawa's iteration: when an increment has converged, λ ← max(0, λ − ε g), and it is solved again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Augmentation {
    /// Penetration that ends the rounds, length.
    pub tolerance: f64,
    /// Most rounds in an increment.
    pub max_rounds: usize,
}

/// How two surfaces interact.
#[derive(Clone, Debug, PartialEq)]
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
    /// The exact tangent, or ε N Nᵀ alone.
    pub tangent: Tangent,
    /// Whether the surfaces are also paired the other way round.
    pub two_pass: bool,
    /// Element and pairing.
    pub interface: InterfaceOptions,
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
    /// What the contact exerts on the slave node, force · N: nearly along the normal. The smooth surface follows the slave by its
    /// weights, so that a small part of it lies in the tangent plane.
    pub nodal_force: Point,
    /// Tributary area, length²; 1 if the interface carries none.
    pub area: f64,
}

/// Two surfaces that do not penetrate each other.
#[derive(Debug)]
pub struct Interaction {
    options: InteractionOptions,
    passes: Vec<Pass>,
}

impl Interaction {
    /// The nodes of `slave` against the facets of `master`; with [`two_pass`](InteractionOptions::two_pass) also the
    /// other way round.
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
        let pass = |master, slave, penalty| Pass::new(&options, penalty, master, slave, positions);
        let passes = if options.two_pass {
            vec![pass(master, slave, 0.5 * penalty)?, pass(slave, master, 0.5 * penalty)?]
        } else {
            vec![pass(master, slave, penalty)?]
        };
        Ok(Self { options, passes })
    }

    /// The options.
    #[must_use]
    pub fn options(&self) -> &InteractionOptions {
        &self.options
    }

    /// The contact of every slave node at the last evaluation, pass by pass.
    pub fn slaves(&self) -> impl Iterator<Item = SlaveState> {
        self.passes.iter().flat_map(Pass::slaves)
    }

    /// Force on each of `count` nodes at the last evaluation, as slave and as master, in all passes: what enters equilibrium.
    #[must_use]
    pub fn nodal_forces(&self, count: usize) -> Vec<Point> {
        let mut forces = vec![[0.0; 3]; count];
        self.passes.iter().for_each(|pass| pass.add_nodal_forces(&mut forces));
        forces
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

    pub(super) fn cliques(&self) -> impl Iterator<Item = Vec<usize>> {
        self.passes.iter().flat_map(Pass::cliques)
    }

    pub(super) fn bind(&mut self, pattern: &BlockPattern) -> Result<(), ContactError> {
        self.each(|pass| pass.bind(pattern))
    }

    pub(super) fn add_tangent(&mut self, matrix: &mut BlockMatrix) -> Result<(), ContactError> {
        self.each(|pass| pass.add_tangent(matrix))
    }

    /// Whether no further round is needed or allowed.
    pub(super) fn is_augmented(&self, round: usize) -> bool {
        self.options.augmentation.is_none_or(|augmentation| {
            round >= augmentation.max_rounds || self.max_penetration() <= augmentation.tolerance
        })
    }

    pub(super) fn augment(&mut self, round: usize) {
        if self.options.augmentation.is_some_and(|augmentation| round < augmentation.max_rounds) {
            self.passes.iter_mut().for_each(Pass::augment);
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

    pub(super) fn pairings(&self) -> impl Iterator<Item = Vec<Option<SlavePairing>>> {
        self.passes.iter().map(Pass::pairings)
    }

    pub(super) fn set_pairings(
        &mut self,
        pairings: &[Vec<Option<SlavePairing>>],
    ) -> Result<(), ContactError> {
        let mut own = pairings.iter();
        self.each(|pass| own.next().map_or(Ok(()), |own| pass.set_pairings(own)))
    }

    /// Deepest penetration at the last evaluation, length; 0 without any.
    #[must_use]
    pub fn max_penetration(&self) -> f64 {
        self.slaves().filter_map(|slave| slave.gap).map(|gap| -gap).fold(0.0, f64::max)
    }

    /// Sum of the contact forces on the slaves of the first pass less those of the second: what the master's surface exerts on the
    /// slave's, exactly as it enters equilibrium.
    pub(super) fn force(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (sign, pass) in [1.0, -1.0].into_iter().zip(&self.passes) {
            for slave in pass.slaves() {
                for axis in 0..3 {
                    sum[axis] += sign * slave.nodal_force[axis];
                }
            }
        }
        sum
    }

    /// Does the same with each pass; an error gets the interaction's name.
    fn each(
        &mut self,
        mut step: impl FnMut(&mut Pass) -> Result<(), super::pass::PassError>,
    ) -> Result<(), ContactError> {
        let name = &self.options.name;
        self.passes.iter_mut().try_for_each(|pass| step(pass).map_err(|error| error.of(name)))
    }
}
