//! First and second derivatives of a function that is given through intermediate quantities.
//!
//! Intermediates v = f(z) come in levels: those of a level depend on variables and on intermediates of lower levels. A level is
//! eliminated at a time, from the last to the first. With the gradient a and the second derivative K of what is left, C = ∂f/∂z:
//!
//! ```text
//! a_z += Cᵀ a_v        K_zz += Cᵀ K_vv C + Cᵀ K_vz + K_zv C + Σ a_v ∂²f_v/∂z²
//! ```
//!
//! Unknowns v at the root of r(v, z) = 0 are not differentiated twice: with r_vᵀ μ = −a_v, the derivatives of μ·r take the place of
//! Cᵀ a_v and of Σ a_v ∂²f_v/∂z², those by v too.
//!
//! The middle term may stay a form Cᵀ B C of few rows instead, which lower levels see as rows C only. Vectors that are linear in the
//! positions of nodes may be eliminated by [`LinearImages`]. Which of these ways is taken is for the caller to choose,
//! [`Chain::ways`] lists them.
//!
//! Unknowns whose values are known and in which the function is stationary are one level of their own, see [`super::known`].

use super::definition::Intermediate;
use super::expansion::{Derivatives, Expansion};
use super::known::{Known, is_known};
use super::linear_images::{LinearImages, vectors_of_nodes};
use crate::expr::Expr;

/// Levels that are tried both ways.
const MOST_CHOICES: usize = 4;

/// Variables, and intermediates in levels, the lowest first.
#[derive(Clone, Debug, Default)]
pub struct Chain<'g> {
    variables: Vec<Expr<'g>>,
    levels: Vec<Vec<Intermediate<'g>>>,
    /// Which level is that of unknowns whose values are known.
    known: Option<usize>,
}

/// A way to eliminate the intermediates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Way {
    /// Levels whose bit is set stay forms.
    forms: usize,
    /// Whether the lowest level is eliminated as vectors that are linear in those of nodes.
    by_vectors: bool,
}

impl<'g> Chain<'g> {
    /// Intermediates in an order in which each comes after those it depends on.
    pub fn new(variables: Vec<Expr<'g>>, intermediates: &[Intermediate<'g>]) -> Self {
        let mut levels: Vec<Vec<Intermediate<'g>>> = Vec::new();
        let (known, others): (Vec<_>, Vec<_>) =
            intermediates.iter().copied().partition(|v| is_known(v.definition));
        let mut above: Vec<Intermediate<'g>> = Vec::new();
        for v in others {
            let contains = |w: &Intermediate<'g>| v.definition.contains(w.symbol);
            if known.iter().chain(&above).any(contains) {
                above.push(v);
            } else {
                add(&mut levels, 0, v);
            }
        }
        let place = (!known.is_empty()).then_some(levels.len());
        levels.extend(place.map(|_| known));
        let lowest = levels.len();
        above.into_iter().for_each(|v| add(&mut levels, lowest, v));
        Self { variables, levels, known: place }
    }

    /// The ways to eliminate the intermediates; that by vectors if there is one, which estimates of operations do not do justice to.
    pub fn ways(&self) -> Vec<Way> {
        if self.lowest_vectors().is_some() {
            return vec![Way { forms: 0, by_vectors: true }];
        }
        // What is above unknowns whose values are known is eliminated before them.
        let levels = self.known.unwrap_or(self.levels.len());
        (0..1 << levels.min(MOST_CHOICES)).map(|forms| Way { forms, by_vectors: false }).collect()
    }

    /// All intermediates, lower ones first.
    pub fn intermediates(&self) -> impl Iterator<Item = &Intermediate<'g>> {
        self.levels.iter().flatten()
    }

    /// The same intermediates with fewer variables.
    #[must_use]
    pub fn with_variables(&self, variables: Vec<Expr<'g>>) -> Self {
        Self { variables, levels: self.levels.clone(), known: self.known }
    }

    /// Unknowns whose values are known: their symbols with their values.
    pub fn known_values(&self) -> Vec<(Expr<'g>, Expr<'g>)> {
        self.known.map_or_else(Vec::new, |level| Known::new(&self.levels[level]).values())
    }

    /// The lowest level as vectors, if it is one of vectors that are linear in those of the nodes.
    fn lowest_vectors(&self) -> Option<(LinearImages<'g>, Vec<[usize; 3]>)> {
        let lowest = self.levels.first().filter(|_| self.known != Some(0))?;
        vectors_of_nodes(lowest, &self.variables)
    }

    /// Derivatives of a function.
    pub fn derivatives(&self, function: Expr<'g>, with_hessian: bool, way: Way) -> Derivatives<'g> {
        let symbols: Vec<Expr<'g>> =
            self.variables.iter().copied().chain(self.intermediates().map(|v| v.symbol)).collect();
        let mut expansion = Expansion::new(function, &symbols, with_hessian);
        let mut above = symbols.len();
        for (number, level) in self.levels.iter().enumerate().rev() {
            let first = above - level.len();
            let below = &symbols[..first];
            if self.known == Some(number) {
                let known = Known::new(level).without(self.levels[number + 1..].iter().flatten());
                expansion = expansion.without_known(&known, level.len(), below, with_hessian);
            } else {
                if number == 0
                    && way.by_vectors
                    && expansion.forms.is_empty()
                    && let Some((images, places)) = self.lowest_vectors()
                    && let Some(derivatives) = expansion.through(&images, &places, first, with_hessian)
                {
                    return derivatives;
                }
                let is_form = number < MOST_CHOICES && way.forms >> number & 1 == 1;
                expansion = expansion.without(level, first, below, with_hessian, is_form);
            }
            above = first;
        }
        expansion.finish(function.sheet(), above, with_hessian)
    }
}

/// Adds an intermediate to the first level after those it depends on, from `lowest` on.
fn add<'g>(levels: &mut Vec<Vec<Intermediate<'g>>>, lowest: usize, v: Intermediate<'g>) {
    let contains = |level: &Vec<Intermediate<'g>>| level.iter().any(|w| v.definition.contains(w.symbol));
    let level = levels.iter().rposition(contains).map_or(lowest, |below| (below + 1).max(lowest));
    if level == levels.len() {
        levels.push(Vec::new());
    }
    levels[level].push(v);
}
