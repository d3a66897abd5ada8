//! Operation counts of emitted code.

use std::ops::{Add, AddAssign};

/// Arithmetic operations of a piece of emitted code. A fused multiply-add counts one, so does an unpaired
/// addition or multiplication.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpCounts {
    /// Fused multiply-adds and multiply-subtracts.
    pub fused: usize,
    /// Additions and subtractions.
    pub additions: usize,
    /// Multiplications.
    pub multiplications: usize,
    /// Changes of sign.
    pub negations: usize,
    /// Divisions.
    pub divisions: usize,
    /// Square roots, exponentials and other functions.
    pub functions: usize,
    /// Choices.
    pub selections: usize,
}

impl OpCounts {
    /// All operations.
    pub const fn total(&self) -> usize {
        self.fused
            + self.additions
            + self.multiplications
            + self.negations
            + self.divisions
            + self.functions
            + self.selections
    }

    /// The counts `times` over.
    #[must_use]
    pub const fn times(self, times: usize) -> Self {
        Self {
            fused: self.fused * times,
            additions: self.additions * times,
            multiplications: self.multiplications * times,
            negations: self.negations * times,
            divisions: self.divisions * times,
            functions: self.functions * times,
            selections: self.selections * times,
        }
    }
}

impl Add for OpCounts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            fused: self.fused + other.fused,
            additions: self.additions + other.additions,
            multiplications: self.multiplications + other.multiplications,
            negations: self.negations + other.negations,
            divisions: self.divisions + other.divisions,
            functions: self.functions + other.functions,
            selections: self.selections + other.selections,
        }
    }
}

impl AddAssign for OpCounts {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// Operation counts of a kernel, for any number of nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KernelCounts {
    /// Once per element.
    pub element: OpCounts,
    /// Once per iteration of a root's equations, besides the update of its unknowns.
    pub iteration: OpCounts,
    /// Once per master node.
    pub node: OpCounts,
    /// Once per unordered pair of different master nodes.
    pub pair: OpCounts,
}

impl KernelCounts {
    /// Operations for `nodes` master nodes, with one evaluation of the roots' equations.
    pub fn total(&self, nodes: usize) -> OpCounts {
        self.element
            + self.iteration
            + self.node.times(nodes)
            + self.pair.times(nodes * nodes.saturating_sub(1) / 2)
    }
}
