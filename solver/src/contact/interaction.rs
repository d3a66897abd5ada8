//! One pair of surfaces.

use std::collections::{BTreeMap, HashMap};

use diffuse_contact::assembly::{Tangent, TangentOperator};
use diffuse_contact::faces::{FaceOptions, IntegrationPoint};
use diffuse_contact::friction::FrictionState;
use diffuse_contact::interface::{FrictionReport, NoContact};
use diffuse_contact::neighbourhood::Fallback;
use diffuse_contact::surface::{Facet, tributary_areas};
use diffuse_contact::{Mode, Point};

use super::between::SlaveFaces;
use super::face_pass::FacePass;
use super::fallbacks::Fallbacks;
use super::losses::is_failure;
use super::node_pass::NodePass;
use super::pass::{Bodies, Nearest, NodalForces, Pass, PassError};
use super::penetration::Penetration;
use super::{Augmentation, ContactError, Integration, InteractionOptions, Way};
use crate::model::sorted;
use crate::system::{BlockMatrix, Symmetry};

/// Root of the mean area of facets, of which nodes have these tributary areas; 0 without any.
pub(crate) fn facet_size(areas: &[f64], facets: &[Facet]) -> f64 {
    (areas.iter().sum::<f64>() / facets.len().max(1) as f64).sqrt()
}

/// Root of the mean area of the facets around each node, of which nodes have these tributary areas: a node has a part of each of them.
fn sizes_around(areas: &[f64], facets: &[Facet]) -> HashMap<usize, f64> {
    let mut parts: HashMap<usize, f64> = HashMap::new();
    for corners in facets.iter().map(Facet::corners) {
        corners.iter().for_each(|&node| *parts.entry(node).or_default() += 1.0 / corners.len() as f64);
    }
    let size = |(node, part): (usize, f64)| (node, (areas.get(node).copied().unwrap_or(0.0) / part).sqrt());
    parts.into_iter().map(size).collect()
}

/// Contact of one slave node at the last evaluation. Over faces a node on a sharp edge has one of each sheet of the slave that meets there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlaveState {
    /// The slave node.
    pub node: usize,
    /// Its gap, length; `None` if it has no contact element. Over faces the average around it, or where integration points have pressures of
    /// their own the smallest one.
    pub gap: Option<f64>,
    /// The average around it over faces, else the same, length: 0 without a contact element.
    pub average_gap: f64,
    /// Contact force, ≥ 0.
    pub force: f64,
    /// Normal at the foot; zero without a gap.
    pub normal: Point,
    /// What the contact exerts on the slave node: force · N, nearly along the normal, and friction. The smooth surface follows the slave
    /// by its weights, so that a small part of force · N lies in the tangent plane. Of a node with several sheets the first has it all.
    pub nodal_force: Point,
    /// The part of it that is friction, −c ∇q.
    pub friction: Point,
    /// Whether it sticks or slides.
    pub friction_state: FrictionState,
    /// Its way from its anchor since it touched, length: of one that slides, what it slid in the increment and its elastic slip. With
    /// augmentation from where it stuck.
    pub slip: f64,
    /// Tributary area, length²; 1 if the interface carries none. Over faces, of a slave in contact, the part of it over the master.
    pub area: f64,
    /// What its masters made the smooth surface give up.
    pub fallback: Fallback,
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
            average_gap: 0.0,
            force: 0.0,
            normal: [0.0; 3],
            nodal_force: [0.0; 3],
            friction: [0.0; 3],
            friction_state: FrictionState::Open,
            slip: 0.0,
            area,
            fallback: Fallback::None,
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

/// A point of a face that lies deeper than the average by this factor is so by the faces' shape.
const DEEPER: f64 = 3.0;

/// A point whose gap is this part of the least average touches long before it.
const NEARER: f64 = 0.1;

/// Two surfaces that do not penetrate each other.
#[derive(Debug)]
pub struct Interaction {
    options: InteractionOptions,
    passes: Vec<Box<dyn Pass>>,
    /// Mean size of the slaves' facets of each pass at the start, length.
    sizes: Vec<f64>,
    /// Tributary areas of the nodes of both sides at the start, length².
    areas: HashMap<usize, f64>,
    /// Root of the mean area of the facets around each of these nodes at the start, length.
    local_sizes: HashMap<usize, f64>,
    /// Facets of both sides.
    facets: Vec<Facet>,
    /// How many of them, the first, are the slave's.
    slave_facets: usize,
    /// The multipliers of each pass from before others were supposed.
    before: Vec<Vec<f64>>,
    /// Over nodes in one pass: what tells nodes of the master between slaves.
    between: Option<SlaveFaces>,
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
                Integration::Faces { rule, pressures } => {
                    let how = FaceOptions::new(options.interface).with_rule(rule).with_pressures(pressures);
                    Box::new(FacePass::new(&options, how, penalty, (master, slave), positions)?)
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
        let (mut sizes, mut areas, mut local_sizes) = (Vec::new(), HashMap::new(), HashMap::new());
        for side in [slave, master] {
            // The facets were checked when the passes were made.
            let of_nodes = tributary_areas(positions, side).unwrap_or_default();
            sizes.push(facet_size(&of_nodes, side));
            local_sizes.extend(sizes_around(&of_nodes, side));
            areas.extend(of_nodes.into_iter().enumerate().filter(|&(_, area)| area > 0.0));
        }
        // One side is both where a surface is in contact with itself.
        let other = if options.self_contact { &[] } else { master };
        let facets = [slave, other].concat();
        let (slave_facets, before) = (slave.len(), Vec::new());
        let is_one_sided =
            options.integration == Integration::Nodes && !options.two_pass && !options.self_contact;
        let between = is_one_sided.then(|| SlaveFaces::new(positions, slave)).flatten();
        Ok(Self { options, passes, sizes, areas, local_sizes, facets, slave_facets, before, between })
    }

    /// The options.
    pub fn options(&self) -> &InteractionOptions {
        &self.options
    }

    /// The contact of every slave node at the last evaluation, pass by pass.
    pub fn slaves(&self) -> impl Iterator<Item = SlaveState> {
        self.passes.iter().flat_map(|pass| pass.slaves())
    }

    /// The integration points over the master at the last evaluation, pass by pass; `None` over nodes.
    ///
    /// # Errors
    /// [`ContactError::Interface`] before the first evaluation.
    pub fn integration_points(&self) -> Result<Option<Vec<IntegrationPoint>>, ContactError> {
        if self.options.integration == Integration::Nodes {
            return Ok(None);
        }
        let named = |source| ContactError::Interface { interface: self.options.name.clone(), source };
        let of_passes: Result<Vec<_>, _> = self.passes.iter().map(|pass| pass.integration_points()).collect();
        Ok(Some(of_passes.map_err(named)?.concat()))
    }

    /// What the masters of its slaves made the smooth surface give up at the last evaluation.
    pub fn fallbacks(&self) -> Fallbacks {
        let mut all = Fallbacks::default();
        self.slaves().for_each(|slave| all.count(slave.fallback));
        all
    }

    /// Slaves that carry force deep below the master, beside the size of their facets, at the last evaluation, which was at these positions, and
    /// nodes of the master deep in the slave's faces. Where slave and masters are all prescribed it is the deck's, and left out. `longest`: the
    /// longest way of a node.
    pub fn penetration(&self, positions: &[Point], longest: f64) -> Penetration {
        let (mut all, mut deepest) = (Penetration::default(), 0.0_f64);
        for slave in self.slaves().filter(|slave| slave.force > 0.0 && !slave.is_held) {
            let part = slave.gap.map_or(0.0, |gap| -gap / self.facet_size_at(slave.node));
            deepest = deepest.max(part);
            all.count(part);
        }
        if self.slaves().all(|slave| slave.is_held) {
            return all;
        }
        if let Some(between) = &self.between {
            let sizes = &self.local_sizes;
            let size_at = |node: usize| sizes.get(&node).copied().unwrap_or(0.0);
            let depths = between.depths(self.passes[0].master(), positions, size_at);
            depths.into_iter().for_each(|part| all.count_master(part, deepest));
        }
        for (pass, size) in self.passes.iter().zip(&self.sizes) {
            let (penalty, multipliers) = (pass.state().penalty(), &pass.state().multipliers);
            let has_none = multipliers.iter().all(|&force| force == 0.0);
            // Points with pressures of their own are as deep as the slaves.
            if pass.has_point_pressures() {
                continue;
            }
            // Before the first update there are none.
            for point in pass.integration_points().unwrap_or_default() {
                // Of a soft penalty all points are as deep as the average.
                let average = if has_none { point.pressure / penalty } else { 0.0 };
                if point.pressure > 0.0 && -point.gap > DEEPER * average {
                    all.count_point(-point.gap / size, (-point.gap - average) / longest);
                }
            }
        }
        all
    }

    /// Whether all average gaps over the faces of a pass are open, while points of the faces are far nearer to the master, at the last evaluation:
    /// pressures of points close them. With multipliers there are none.
    pub(super) fn is_late(&self) -> bool {
        if self.options.augmentation.is_some() {
            return false;
        }
        self.passes().filter(|pass| !pass.has_point_pressures()).any(|pass| {
            let least = |gaps: &mut dyn Iterator<Item = f64>| gaps.fold(f64::INFINITY, f64::min);
            let average = least(&mut pass.slaves().filter_map(|slave| slave.gap));
            // Over nodes there are none.
            let points = pass.integration_points().unwrap_or_default();
            average > 0.0
                && average.is_finite()
                && least(&mut points.iter().map(|point| point.gap)) < NEARER * average
        })
    }

    /// Forces on each of `count` nodes at the last evaluation.
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

    /// Work of friction so far, energy.
    pub fn dissipated(&self) -> f64 {
        self.passes.iter().map(|pass| pass.dissipated()).sum()
    }

    /// From here on ε N Nᵀ alone is assembled.
    pub(super) fn operate(&mut self) -> Result<(), ContactError> {
        match self.passes.iter_mut().all(|pass| pass.operate()) {
            true => Ok(()),
            false => Err(ContactError::NoOperator { interface: self.options.name.clone() }),
        }
    }

    /// Adds what the passes do not assemble of this tangent.
    pub(super) fn add_curvature(
        &self,
        tangent: Tangent,
        all: &mut Vec<TangentOperator>,
    ) -> Result<(), ContactError> {
        for pass in &self.passes {
            all.extend(pass.curvature(tangent).map_err(|error| error.of(&self.options.name))?);
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
    pub fn slip_error(&self) -> Result<f64, ContactError> {
        let named = |error: PassError| error.of(&self.options.name);
        let mut errors = self.passes.iter().map(|pass| pass.slip_error().map_err(named));
        errors.try_fold(0.0, |largest: f64, error| Ok(largest.max(error?)))
    }

    /// How far the contacts are from f ≥ 0, g ≥ 0, f g = 0, length: the largest |g| of those that carry force and −g of the
    /// others. Those that can move nothing are left out.
    pub fn gap_error(&self) -> f64 {
        let moved = self.slaves().filter(|slave| !slave.is_held);
        let error =
            |slave: SlaveState| slave.gap.map_or(0.0, |gap| if slave.force > 0.0 { gap.abs() } else { -gap });
        moved.map(error).fold(0.0, f64::max)
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

    /// From here on the open slaves of these bodies that are nearest to the master push with ε g; `least` are the least gaps of the bodies.
    /// Their tangent is that of contact, and minus their force would pull them onto the master.
    pub(super) fn suppose(&mut self, bodies: &Bodies, nearest: Nearest, least: &BTreeMap<usize, f64>) {
        for (pass, size) in self.passes.iter_mut().zip(&self.sizes) {
            let supposed = match nearest {
                Nearest::OfBody(near) => pass.supposed(bodies, *size, near, least),
                Nearest::OfPass(near) => {
                    let mut least = BTreeMap::new();
                    pass.lower(bodies, &mut least);
                    pass.supposed(bodies, *size, near, &least)
                }
            };
            let mut multipliers =
                if supposed.is_empty() { pass.state().multipliers.clone() } else { supposed };
            std::mem::swap(&mut pass.state_mut().multipliers, &mut multipliers);
            self.before.push(multipliers);
        }
    }

    /// Ends what [`suppose`](Self::suppose) began.
    pub(super) fn recall(&mut self) {
        for (pass, before) in self.passes.iter_mut().zip(self.before.drain(..)) {
            pass.state_mut().multipliers = before;
        }
    }

    /// Deepest penetration at the last evaluation, length, whether it carries force or not; 0 without any. Where slave and masters
    /// are all prescribed it is the deck's, and left out.
    pub fn max_penetration(&self) -> f64 {
        let moved = self.slaves().filter(|slave| !slave.is_held);
        moved.filter_map(|slave| slave.gap).map(|gap| -gap).fold(0.0, f64::max)
    }

    pub(super) fn passes(&self) -> impl Iterator<Item = &dyn Pass> {
        self.passes.iter().map(AsRef::as_ref)
    }

    pub(super) fn passes_mut(&mut self) -> &mut [Box<dyn Pass>] {
        &mut self.passes
    }

    /// Facets of both sides.
    pub(crate) fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// Facets of the slave and of the master; of a surface in contact with itself there are no others.
    pub(super) fn sides(&self) -> (&[Facet], &[Facet]) {
        self.facets.split_at(self.slave_facets)
    }

    /// Whether it presses the same two surfaces together as another one, in whichever roles.
    pub(super) fn is_of_the_surfaces_of(&self, other: &Self) -> bool {
        // The least node of each side tells nearly all others apart.
        let least = |own: &Self| {
            let (slave, master) = own.facets.split_at(own.slave_facets);
            let of = |side: &[Facet]| side.iter().flat_map(Facet::corners).min().copied();
            let (one, two) = (of(slave), of(master));
            (one.min(two), one.max(two))
        };
        let sides = |own: &Self| {
            let (slave, master) = own.facets.split_at(own.slave_facets);
            let mut sides = [slave, master].map(|side| {
                let mut side: Vec<Vec<usize>> = side.iter().map(|facet| sorted(facet.corners())).collect();
                side.sort_unstable();
                side
            });
            sides.sort_unstable();
            sides
        };
        self.facets.len() == other.facets.len() && least(self) == least(other) && sides(self) == sides(other)
    }

    /// Mean size of the slave's and of the master's facets at the start, length.
    pub(super) fn facet_sizes(&self) -> [f64; 2] {
        [self.sizes[0], self.sizes[1]]
    }

    /// Mean size of the slave's facets at the start, length.
    pub(super) fn facet_size(&self) -> f64 {
        self.sizes[0]
    }

    /// Size of the facets around a node of either side at the start, length.
    pub(crate) fn facet_size_at(&self, node: usize) -> f64 {
        self.local_sizes.get(&node).copied().unwrap_or(0.0)
    }

    /// Area that belongs to a node of either side at the start, length².
    pub(crate) fn tributary_area(&self, node: usize) -> f64 {
        self.areas.get(&node).copied().unwrap_or(0.0)
    }

    /// Does the same with each pass; an error gets the interaction's name.
    pub(super) fn each(
        &mut self,
        mut step: impl FnMut(&mut dyn Pass) -> Result<(), PassError>,
    ) -> Result<(), ContactError> {
        let name = &self.options.name;
        self.passes.iter_mut().try_for_each(|pass| step(pass.as_mut()).map_err(|error| error.of(name)))
    }
}
