//! What is compared, with what, and how well it has to agree.

use std::ops::RangeInclusive;

use diffuse_contact::Mode;
use diffuse_contact_codegen::{Basis, Output};

use crate::weight::Weight;

/// Largest difference that passes.
pub const TOLERANCE: f64 = 1e-12;

/// Elements per node count and basis.
pub const ELEMENTS: usize = 3;

/// The modes, fewest derivatives first, and their names.
pub(super) const MODES: [(Mode, &str); 3] =
    [(Mode::Value, "value"), (Mode::Gradient, "gradient"), (Mode::Hessian, "hessian")];

/// What is to be compared.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Bases and numbers of master nodes.
    pub ranges: Vec<(Basis, RangeInclusive<usize>)>,
    /// The weight. Of a formula no kernels are compiled into this program: the interpreter stands in for them.
    pub weight: Weight,
    /// Seed of the random elements.
    pub seed: u64,
}

impl Default for Plan {
    /// The node counts of pairings in either basis, the generated kernels, seed 1.
    fn default() -> Self {
        let ranges = Basis::ALL.map(|basis| (basis, Self::default_nodes(basis))).to_vec();
        Self { ranges, weight: Weight::default(), seed: 1 }
    }
}

impl Plan {
    /// The node counts that pairings have with a basis.
    pub const fn default_nodes(basis: Basis) -> RangeInclusive<usize> {
        basis.size()..=24
    }

    /// Replaces the node counts of a basis.
    #[must_use]
    pub fn nodes(mut self, basis: Basis, range: RangeInclusive<usize>) -> Self {
        self.ranges.retain(|(other, _)| *other != basis);
        self.ranges.push((basis, range));
        self
    }

    /// What is tested of an output. Kernels with a slip are a feature of their own; without it the interpreter of their formulas stands in.
    pub const fn tested(&self, output: Output) -> Tested {
        let has_kernels = self.weight.as_built_in().is_some()
            && (!matches!(output, Output::Slip) || cfg!(feature = "friction"));
        if has_kernels { Tested::Generated } else { Tested::Interpreter }
    }

    /// Number of elements.
    pub fn elements(&self) -> usize {
        self.ranges.iter().map(|(_, range)| range.clone().count() * ELEMENTS).sum()
    }
}

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tested {
    /// The kernels.
    Generated,
    /// The interpreter of their graph.
    Interpreter,
}

impl Tested {
    /// Name in JSON.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Generated => "generated",
            Self::Interpreter => "interpreter",
        }
    }
}

/// What a result is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// Automatic differentiation of the independent model.
    Ad,
    /// The interpreter of the same graph, in the same mode.
    Interpreter,
    /// The same backend in Hessian mode.
    HessianMode,
}

impl Against {
    /// All comparisons, in the order of the report.
    pub const ALL: [Self; 3] = [Self::Ad, Self::Interpreter, Self::HessianMode];

    /// Column title.
    pub(super) const fn title(self) -> &'static str {
        match self {
            Self::Ad => "against AD",
            Self::Interpreter => "against interpreter",
            Self::HessianMode => "between modes",
        }
    }

    /// Name in JSON.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Ad => "ad",
            Self::Interpreter => "interpreter",
            Self::HessianMode => "hessian-mode",
        }
    }
}
