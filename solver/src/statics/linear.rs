//! The linear step of an iteration, and what is done where the stiffness is singular.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use diffuse_contact::assembly::Tangent;

use super::loose::{Loose, loose_parts};
use super::{Failure, LinearEffort, Problem};
use crate::contact::{Bodies, ContactOperator, Nearest};
use crate::system::{
    Accuracy, BlockMatrix, BlockPattern, Geometry, LinearReport, LinearSystem, Operator, SavedRows, Symmetry,
    SystemError,
};

/// Linear solutions of an increment for which contacts may be supposed to be closed.
const MOST_SUPPOSED: usize = 6;

/// Slaves that are supposed to touch.
pub(super) const NEAR: Nearest = Nearest::OfPass(0.1);
/// Fewer, which are enough if they hold as much: contacts that do not close bend a slender body.
const NEARER: [Nearest; 4] =
    [Nearest::OfBody(1e-3), Nearest::OfBody(1e-2), Nearest::OfPass(1e-3), Nearest::OfPass(1e-2)];

/// K Δx = −imbalance.
pub(super) struct Assembled {
    pub matrix: BlockMatrix,
    /// What contact adds to it without being assembled.
    operator: Option<ContactOperator>,
    symmetry: Symmetry,
    /// Rows of the nodes that contact couples without it, if the solution may be iterative.
    before: SavedRows,
    imbalance: Vec<f64>,
}

/// What a linear solution is asked for.
#[derive(Clone, Copy)]
struct Step<'a> {
    positions: &'a [[f64; 3]],
    /// Changes of prescribed degrees of freedom.
    prescribed: &'a [(usize, f64)],
    accuracy: Accuracy,
}

impl LinearEffort {
    /// With another solution.
    fn take(&mut self, report: &LinearReport) {
        match *report {
            LinearReport::Iterative { iterations, bytes, .. } => {
                self.iterations += iterations;
                self.bytes = self.bytes.max(bytes);
            }
            LinearReport::Instead { iterations, .. } => {
                self.iterations += iterations;
                self.direct_instead += 1;
            }
            LinearReport::Direct { .. } => {}
        }
    }
}

impl Problem {
    /// Solves K Δx = r for the free degrees of freedom while the prescribed ones move by `prescribed`, with the stiffness at the last
    /// evaluation, which was one of [`Order::Tangent`](crate::solid::Order::Tangent).
    ///
    /// Where nothing holds a part, slaves near their masters are supposed to touch, if that holds it. The stabilisation, if there is any,
    /// is added in any case. An iterative solution is as accurate as asked. None of it changes a force: it is gone in equilibrium.
    pub(super) fn solve(
        &mut self,
        time: f64,
        positions: &[[f64; 3]],
        prescribed: &[(usize, f64)],
        accuracy: Accuracy,
    ) -> Result<Vec<f64>, Failure> {
        let step = Step { positions, prescribed, accuracy };
        let mut system = self.assemble(time, positions, None)?;
        self.take_rounding(&system.matrix, positions);
        let is_stabilised = self.stabilisation > 0.0;
        // A motion that costs next to nothing goes anywhere long before its stiffness counts as singular: there is no trying without.
        let plain = if is_stabilised { None } else { Some(self.solve_system(&system, step)) };
        let mut loose = match &plain {
            // Far from the origin rounding of positions gives a loose body some stiffness.
            Some(Ok(_)) if self.rounded.is_some() => self.loose(&system, positions),
            Some(Err(SystemError::Singular { .. })) | None => self.loose(&system, positions),
            _ => Vec::new(),
        };
        let is_singular = matches!(plain, Some(Err(SystemError::Singular { .. })));
        if let Some(solved) = plain
            && loose.is_empty()
            && !is_singular
        {
            self.stiffness = Some(system.matrix);
            return solved.map_err(|error| Failure::of_system(error, Vec::new()));
        }
        let is_due = !(is_stabilised && loose.is_empty() || self.contacts.are_none());
        if is_due && !self.is_in_vain && self.supposed < MOST_SUPPOSED {
            self.stiffness = Some(system.matrix);
            let (closed, held) = self.suppose(time, positions, &loose)?;
            if motions(&held) < motions(&loose) || loose.is_empty() && !is_stabilised {
                self.supposed += 1;
                (system, loose) = (closed, held);
            } else {
                // They hold nothing, and will not in this increment.
                self.is_in_vain = true;
                self.stiffness = Some(closed.matrix);
                system = self.assemble(time, positions, None)?;
            }
        }
        if is_stabilised {
            system.matrix.add_to_diagonal(self.stabilisation);
            self.stabilised += usize::from(!loose.is_empty());
        }
        let solved = self.solve_system(&system, step);
        self.stiffness = Some(system.matrix);
        // It is not that of the bodies and their contacts.
        self.negative = None;
        match (solved, self.rounded) {
            (Ok(_), Some(residual)) if !is_stabilised && !loose.is_empty() => {
                let (equations, condition) = (self.equations.len(), 1.0 / f64::EPSILON);
                Err(Failure::Singular {
                    error: SystemError::Singular { equations, residual, condition },
                    loose,
                })
            }
            (solved, _) => solved.map_err(|error| Failure::of_system(error, loose)),
        }
    }

    /// Whether the stiffness is the same for a shorter increment: no force of contact or of a follower is in it.
    pub(super) fn is_of_the_bodies_alone(&self) -> bool {
        self.active() == 0 && !self.pressures.iter().any(|pressure| pressure.follower)
    }

    /// With contacts of loose parts supposed to be closed, and what they leave loose: the fewest that hold as much as any.
    fn suppose(
        &mut self,
        time: f64,
        positions: &[[f64; 3]],
        loose: &[Loose],
    ) -> Result<(Assembled, Vec<Loose>), Failure> {
        let (mut best, mut fewest) = (NEAR, motions(loose));
        // What is free and no rigid motion is not asked for.
        let fewer = if loose.is_empty() { &[][..] } else { &NEARER[..] };
        for &nearest in fewer {
            let (closed, held) = self.closed(time, positions, loose, nearest)?;
            if held.is_empty() {
                return Ok((closed, held));
            }
            if motions(&held) < fewest {
                (best, fewest) = (nearest, motions(&held));
            }
            self.stiffness = Some(closed.matrix);
        }
        let (all, held) = self.closed(time, positions, loose, NEAR)?;
        if best == NEAR || motions(&held) < fewest {
            return Ok((all, held));
        }
        self.stiffness = Some(all.matrix);
        self.closed(time, positions, loose, best)
    }

    /// With these contacts of loose parts supposed to be closed, and what they leave loose: what they push with is what has to pull them
    /// onto their masters.
    fn closed(
        &mut self,
        time: f64,
        positions: &[[f64; 3]],
        loose: &[Loose],
        nearest: Nearest,
    ) -> Result<(Assembled, Vec<Loose>), Failure> {
        let closed = self.assemble_closed(time, positions, loose, nearest);
        self.contacts.recall(positions).map_err(Failure::Contact)?;
        let closed = closed?;
        let held = self.loose(&closed, positions);
        Ok((closed, held))
    }

    fn assemble_closed(
        &mut self,
        time: f64,
        positions: &[[f64; 3]],
        loose: &[Loose],
        nearest: Nearest,
    ) -> Result<Assembled, Failure> {
        let bodies = if loose.is_empty() {
            // What is free is no rigid motion: any contact may hold it.
            Bodies::whole(positions.len())
        } else {
            let names =
                loose.iter().enumerate().flat_map(|(k, loose)| loose.parts.iter().map(move |part| (part, k)));
            let of_name: HashMap<&String, usize> = names.collect();
            let parts = self.solid.parts().iter();
            let own = parts.filter_map(|(name, nodes)| Some((*of_name.get(name)?, &nodes[..])));
            Bodies::new(positions.len(), own)
        };
        self.contacts.suppose(positions, &bodies, nearest).map_err(Failure::Contact)?;
        let mut pushed = vec![0.0; self.contact.len()];
        self.contacts.add_internal_forces(&mut pushed).map_err(Failure::Contact)?;
        // Without the curvature of forces that are not there.
        let mut system = self.assemble(time, positions, Some(Tangent::GaussNewton))?;
        let pull = self.contact.iter().zip(&pushed).map(|(own, pushed)| own - pushed);
        system.imbalance.iter_mut().zip(pull).for_each(|(force, pull)| *force += pull);
        Ok(system)
    }

    /// The parts that nothing holds.
    pub(super) fn loose(&self, system: &Assembled, positions: &[[f64; 3]]) -> Vec<Loose> {
        let mut loose = loose_parts(&system.matrix, &self.equations, positions, self.solid.parts());
        if !loose.is_empty() {
            let averaged: Vec<String> = self.contacts.late().collect();
            loose.iter_mut().for_each(|own| own.averaged.clone_from(&averaged));
        }
        loose
    }

    /// The stiffness of everything at the last evaluation, contacts with this tangent or with their own.
    pub(super) fn assemble(
        &mut self,
        time: f64,
        positions: &[[f64; 3]],
        tangent: Option<Tangent>,
    ) -> Result<Assembled, Failure> {
        let begin = Instant::now();
        // Also by evaluations elsewhere than at the last residual.
        if self.contacts.take_grown() {
            self.stiffness = None;
        }
        let mut matrix = match self.stiffness.take() {
            Some(matrix) => matrix,
            None => BlockMatrix::new(self.new_pattern()),
        };
        let linear = Instant::now();
        self.timing.linear += linear - begin;
        matrix.clear();
        for element in self.solid.responses(&self.response) {
            matrix.add_symmetric(element.nodes, element.tangent);
        }
        for pressure in &self.pressures {
            pressure.add_tangent(time, positions, &mut matrix);
        }
        let solid = Instant::now();
        self.timing.solid += solid - linear;
        let before = matrix.rows_of(if self.solver.may_iterate() { &self.coupled } else { &[] });
        let norms = [self.balance.residual, self.balance.scale];
        let of_contact = self.contacts.add_tangent(&mut matrix, norms, tangent).map_err(Failure::Contact)?;
        let operator = self.contacts.operator(norms, tangent).map_err(Failure::Contact)?;
        self.timing.contact += solid.elapsed();
        let has_followers = self.pressures.iter().any(|pressure| pressure.follower);
        let symmetry = if has_followers { Symmetry::General } else { of_contact };
        Ok(Assembled { matrix, operator, symmetry, before, imbalance: self.imbalance().collect() })
    }

    /// The step of all degrees of freedom, the prescribed ones among them.
    fn solve_system(
        &mut self,
        system: &Assembled,
        Step { positions, prescribed, accuracy }: Step<'_>,
    ) -> Result<Vec<f64>, SystemError> {
        let begin = Instant::now();
        let mut step = vec![[0.0; 3]; self.start.len()];
        for &(freedom, change) in prescribed {
            step[freedom / 3][freedom % 3] = change;
        }
        let mut right = vec![[0.0; 3]; self.start.len()];
        system.matrix.multiply(&step, &mut right);
        if let Some(operator) = &system.operator {
            operator.add_product(&step, &mut right).map_err(|(entry, value)| {
                let (node, axis) = (entry / 3, entry % 3);
                let equation = self.equations.number(node, axis).unwrap_or(0);
                SystemError::NotFinite { equation, node, axis, value }
            })?;
        }
        for (right, force) in right.as_flattened_mut().iter_mut().zip(&system.imbalance) {
            *right = -force - *right;
        }
        let mut solution = Vec::new();
        let geometry = Geometry { positions, links: &self.links, before: &system.before };
        let Assembled { matrix, symmetry, .. } = system;
        let operator = system.operator.as_ref().map(|operator| operator as &dyn Operator);
        let (equations, symmetry) = (&self.equations, *symmetry);
        let has_friction = self.contacts.has_friction();
        let whole = LinearSystem { matrix, operator, equations, symmetry, has_friction, geometry };
        let solved = self.solver.solve(&whole, &right, accuracy, &mut solution);
        self.timing.linear += begin.elapsed();
        let report = solved?;
        self.linear.take(&report);
        (self.size, self.rounded, self.negative) = match report {
            LinearReport::Iterative { size, .. } => (Some(size), None, None),
            LinearReport::Instead { rounded, .. } => (None, rounded, None),
            LinearReport::Direct { rounded, negative } => (None, rounded, negative),
        };
        for (sum, part) in step.as_flattened_mut().iter_mut().zip(solution.as_flattened()) {
            *sum += part;
        }
        Ok(step.into_flattened())
    }

    /// ε |K| |x| by this stiffness.
    fn take_rounding(&mut self, matrix: &BlockMatrix, positions: &[[f64; 3]]) {
        let mut moduli = vec![[0.0; 3]; positions.len()];
        matrix.multiply_moduli(positions, &mut moduli);
        // Where it overflows it excuses nothing.
        let rounding = |&modulus: &f64| if modulus.is_finite() { f64::EPSILON * modulus } else { 0.0 };
        self.rounding.clear();
        self.rounding.extend(moduli.as_flattened().iter().map(rounding));
    }

    /// The pattern for the pairing of the moment.
    fn new_pattern(&mut self) -> Arc<BlockPattern> {
        let followers = self.pressures.iter().filter(|pressure| pressure.follower);
        let faces = followers.flat_map(|pressure| &pressure.faces).map(Vec::as_slice);
        let of_contact: Vec<Vec<usize>> = self.contacts.cliques().collect();
        let mut is_coupled = vec![false; self.start.len()];
        of_contact.iter().flatten().for_each(|&node| is_coupled[node] = true);
        self.coupled =
            (0_u32..).zip(&is_coupled).filter(|&(_, &is_coupled)| is_coupled).map(|(node, _)| node).collect();
        let cliques = self.solid.elements().chain(faces).chain(of_contact.iter().map(Vec::as_slice));
        Arc::new(BlockPattern::new(self.start.len(), cliques))
    }
}

pub(super) fn motions(loose: &[Loose]) -> usize {
    loose.iter().map(|loose| loose.motions.len()).sum()
}
