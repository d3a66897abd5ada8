//! Quantities through which a function depends on its variables.

use crate::expr::Expr;

/// An intermediate quantity: a symbol, and what it is in terms of variables and lower intermediates.
#[derive(Clone, Copy, Debug)]
pub struct Intermediate<'g> {
    /// The symbol that functions of it contain.
    pub symbol: Expr<'g>,
    /// Its definition.
    pub definition: Expr<'g>,
}
