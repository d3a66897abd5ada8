//! Data of structured nodes: symmetric systems, their right-hand sides, small nonlinear systems.

use super::{ExprId, SymbolId, SystemId};

/// A symmetric matrix of element expressions, factorised as L S Lᵀ with signs S = diag(±1) that are known beforehand: all
/// positive where the matrix is positive definite; a multiplier's row, whose pivot is negative, has the other sign.
#[derive(Clone, Debug)]
pub struct SymmetricSystem {
    /// Name, used for the emitted factor's entries.
    pub name: String,
    /// Rows of the lower triangle.
    lower: Vec<Vec<ExprId>>,
    /// Elimination order: position in the factorisation → row of the matrix.
    order: Vec<usize>,
    /// What a row's pivot is compared with; the diagonal where empty.
    references: Vec<ExprId>,
    /// Rows whose pivots are negative.
    negative: Vec<usize>,
}

impl SymmetricSystem {
    /// A system from the rows of its lower triangle and the order in which its rows are eliminated.
    ///
    /// # Panics
    /// If the rows do not form a lower triangle or `order` is not a permutation.
    pub fn new(name: &str, lower: Vec<Vec<ExprId>>, order: Vec<usize>) -> Self {
        assert!(lower.iter().enumerate().all(|(i, row)| row.len() == i + 1), "{name}: not a lower triangle");
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..lower.len()), "{name}: the elimination order is not a permutation");
        Self { name: name.to_owned(), lower, order, references: Vec::new(), negative: Vec::new() }
    }

    /// Compares pivots with these values, one per row, instead of with the diagonal entries they came from. The rows of
    /// multipliers come after the others and have none.
    ///
    /// # Panics
    /// If there is not one per row.
    #[must_use]
    pub fn with_references(mut self, references: Vec<ExprId>) -> Self {
        assert!(
            references.len() + self.negative.len() == self.size(),
            "{}: one reference per row",
            self.name
        );
        self.references = references;
        self
    }

    /// Makes these rows those of multipliers: their pivots are negative, and tell nothing about whether the matrix is
    /// regular unless all rows have references.
    #[must_use]
    pub fn with_multipliers(mut self, rows: Vec<usize>) -> Self {
        self.negative = rows;
        self
    }

    /// What the pivot of a row is compared with; nothing for a multiplier's.
    pub fn reference(&self, row: usize) -> Option<ExprId> {
        if self.negative.contains(&row) {
            return None;
        }
        Some(self.references.get(row).copied().unwrap_or_else(|| self.entry(row, row)))
    }

    /// Whether the pivot of a multiplier's row tells whether its condition is one of its own: where references are given for all rows.
    /// It is then compared with what the rows before, but for those of multipliers, take from the diagonal.
    pub fn is_compared(&self, row: usize) -> bool {
        self.negative.contains(&row) && self.references.len() == self.size()
    }

    /// Whether the pivot at a position of the factorisation is negative.
    pub fn is_negative(&self, position: usize) -> bool {
        self.negative.contains(&self.order[position])
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.lower.len()
    }

    /// Entry (row, column) of the matrix.
    pub fn entry(&self, row: usize, column: usize) -> ExprId {
        if row >= column { self.lower[row][column] } else { self.lower[column][row] }
    }

    /// Row of the matrix that is eliminated at `position`.
    pub fn eliminated(&self, position: usize) -> usize {
        self.order[position]
    }

    /// All entries of the lower triangle.
    pub fn entries(&self) -> Vec<ExprId> {
        self.lower.iter().flatten().copied().collect()
    }
}

/// A right-hand side of a system.
#[derive(Clone, Debug)]
pub struct Solve {
    /// The system.
    pub system: SystemId,
    /// One expression per row.
    pub right_hand_side: Vec<ExprId>,
}

/// Bounds of an iteration for the root of equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Most that an unknown changes in one step.
    pub longest_step: f64,
    /// Most evaluations of the equations.
    pub evaluations: u32,
}

impl Limits {
    /// Of equations that are linear: the first step leads to the solution.
    pub const LINEAR: Self = Self { longest_step: f64::INFINITY, evaluations: 5 };
}

impl Default for Limits {
    /// Steps of at most ½, for unknowns of order one, and 60 evaluations.
    fn default() -> Self {
        Self { longest_step: 0.5, evaluations: 60 }
    }
}

/// How a small system of equations is solved, from y = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Iteration {
    /// By Newton's steps for two unknowns, within the default [`Limits`], and halved until they reduce the residual.
    Newton,
    /// The same for up to eight unknowns within chosen limits.
    Within(Limits),
    /// The two equations are the negative derivatives of a function: by steps down to a minimum of it, Newton's where it is convex.
    Descent,
}

impl Iteration {
    /// Most equations that a kernel can solve.
    pub const MOST_EQUATIONS: usize = 8;

    /// Whether kernels solve as many equations by it.
    pub const fn takes(self, equations: usize) -> bool {
        match self {
            Self::Newton | Self::Descent => equations == 2,
            Self::Within(_) => 1 <= equations && equations <= Self::MOST_EQUATIONS,
        }
    }
}

/// A small system of equations r(y) = 0, solved by an iteration from y = 0.
#[derive(Clone, Debug)]
pub struct Root {
    /// Name, used in the emitted code.
    pub name: String,
    /// The unknowns y, free variables of the residuals.
    pub unknowns: Vec<SymbolId>,
    /// The residuals r.
    pub residuals: Vec<ExprId>,
    /// ∂r/∂y, made by the derivative engine.
    pub jacobian: Vec<Vec<ExprId>>,
    /// How it is solved.
    pub iteration: Iteration,
    /// The unknowns' values where they are known beforehand, so that nothing is solved for them; otherwise none.
    pub known: Vec<ExprId>,
}

impl Root {
    /// Whether its unknowns' values are known beforehand.
    pub const fn is_known(&self) -> bool {
        !self.known.is_empty()
    }
}
