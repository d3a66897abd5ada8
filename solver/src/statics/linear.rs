//! The linear step of an iteration, and what is done where the stiffness is singular.

use std::sync::Arc;
use std::time::Instant;

use super::loose::{Loose, loose_parts};
use super::{Failure, Problem};
use crate::system::{BlockMatrix, BlockPattern, Symmetry, SystemError};

/// Linear solutions of an increment for which contacts may be supposed to be closed.
const MOST_SUPPOSED: usize = 4;

/// K Δx = −imbalance.
struct LinearSystem {
    matrix: BlockMatrix,
    symmetry: Symmetry,
    imbalance: Vec<f64>,
}

impl Problem {
    /// Solves K Δx = r for the free degrees of freedom while the prescribed ones move by `prescribed`, with the stiffness at the last
    /// evaluation, which was one of [`Order::Tangent`](crate::solid::Order::Tangent).
    ///
    /// If it is singular, slaves near their masters are supposed to touch them, if contact holds something then that nothing else does. The
    /// stabilisation, if there is any, is added in any case. Neither changes a force: they are gone in equilibrium.
    pub(super) fn solve(
        &mut self,
        time: f64,
        positions: &[[f64; 3]],
        prescribed: &[(usize, f64)],
    ) -> Result<Vec<f64>, Failure> {
        let mut system = self.assemble(time, positions)?;
        self.take_rounding(&system.matrix, positions);
        let mut solved = self.solve_system(&system, prescribed);
        if is_singular(&solved) && self.supposed < MOST_SUPPOSED {
            let free = self.free_motions(&system, positions);
            self.stiffness = Some(system.matrix);
            let closed = self.closed(time, positions);
            self.contacts.recall(positions)?;
            system = closed?;
            solved = self.solve_system(&system, prescribed);
            if solved.is_ok() || self.free_motions(&system, positions) < free {
                self.supposed += 1;
            } else {
                // They hold nothing.
                self.stiffness = Some(system.matrix);
                system = self.assemble(time, positions)?;
            }
        }
        // A motion that costs next to nothing goes anywhere long before its stiffness counts as singular.
        if self.stabilisation > 0.0 {
            system.matrix.add_to_diagonal(self.stabilisation);
            solved = self.solve_system(&system, prescribed);
            self.stabilised += usize::from(solved.is_ok());
        }
        let solved = solved.map_err(|error| Failure::of_system(error, self.loose(&system, positions)));
        self.stiffness = Some(system.matrix);
        solved
    }

    /// With contacts that are supposed to be closed: what they push with is what has to pull them onto their masters.
    fn closed(&mut self, time: f64, positions: &[[f64; 3]]) -> Result<LinearSystem, Failure> {
        self.contacts.suppose(positions)?;
        let mut pushed = vec![0.0; self.contact.len()];
        self.contacts.add_internal_forces(&mut pushed)?;
        let mut system = self.assemble(time, positions)?;
        let pull = self.contact.iter().zip(&pushed).map(|(own, pushed)| own - pushed);
        system.imbalance.iter_mut().zip(pull).for_each(|(force, pull)| *force += pull);
        Ok(system)
    }

    /// The parts that nothing holds.
    fn loose(&self, system: &LinearSystem, positions: &[[f64; 3]]) -> Vec<Loose> {
        loose_parts(&system.matrix, &self.equations, positions, &self.solid.parts())
    }

    /// How many rigid motions are free.
    fn free_motions(&self, system: &LinearSystem, positions: &[[f64; 3]]) -> usize {
        self.loose(system, positions).iter().map(|loose| loose.motions.len()).sum()
    }

    /// The stiffness of everything at the last evaluation.
    fn assemble(&mut self, time: f64, positions: &[[f64; 3]]) -> Result<LinearSystem, Failure> {
        let begin = Instant::now();
        let mut matrix = match self.stiffness.take() {
            Some(matrix) => matrix,
            None => BlockMatrix::new(self.new_pattern()),
        };
        let linear = Instant::now();
        self.timing.linear += linear - begin;
        matrix.clear();
        for element in self.solid.responses(&self.response) {
            matrix.add_symmetric(element.nodes, element.tangent, 1.0);
        }
        for pressure in &self.pressures {
            pressure.add_tangent(time, positions, &mut matrix);
        }
        let solid = Instant::now();
        self.timing.solid += solid - linear;
        let norms = [self.balance.residual, self.balance.scale];
        let of_contact = self.contacts.add_tangent(&mut matrix, norms)?;
        self.timing.contact += solid.elapsed();
        let has_followers = self.pressures.iter().any(|pressure| pressure.follower);
        let symmetry = if has_followers { Symmetry::General } else { of_contact };
        Ok(LinearSystem { matrix, symmetry, imbalance: self.imbalance().collect() })
    }

    /// The step of all degrees of freedom, the prescribed ones among them.
    fn solve_system(
        &mut self,
        system: &LinearSystem,
        prescribed: &[(usize, f64)],
    ) -> Result<Vec<f64>, SystemError> {
        let begin = Instant::now();
        let mut step = vec![[0.0; 3]; self.start.len()];
        for &(freedom, change) in prescribed {
            step[freedom / 3][freedom % 3] = change;
        }
        let mut right = vec![[0.0; 3]; self.start.len()];
        system.matrix.multiply(&step, &mut right);
        for (right, force) in right.as_flattened_mut().iter_mut().zip(&system.imbalance) {
            *right = -force - *right;
        }
        let mut solution = Vec::new();
        let solved = self
            .solver
            .factorise(&system.matrix, &self.equations, system.symmetry)
            .and_then(|()| self.solver.solve(&right, &mut solution));
        self.timing.linear += begin.elapsed();
        solved?;
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
    fn new_pattern(&self) -> Arc<BlockPattern> {
        let mut cliques: Vec<Vec<usize>> = self.solid.elements().map(<[usize]>::to_vec).collect();
        let followers = self.pressures.iter().filter(|pressure| pressure.follower);
        cliques.extend(followers.flat_map(|pressure| &pressure.faces).cloned());
        cliques.extend(self.contacts.cliques());
        Arc::new(BlockPattern::new(self.start.len(), cliques.iter()))
    }
}

fn is_singular<T>(solved: &Result<T, SystemError>) -> bool {
    matches!(solved, Err(SystemError::Singular { .. }))
}
