//! Identifiers for expressions: their names in the formulas, made unique.

use rustc_hash::FxHashSet;

use proc_macro2::Ident;
use quote::format_ident;

use crate::graph::{ExprId, Function, Graph, Op};
use crate::kernel::is_identifier;
use crate::table::Table;

/// Longest name put together from operands.
const MOST_CHARACTERS: usize = 14;

/// Names given so far in one function.
#[derive(Default)]
pub(super) struct Names {
    given: Table<ExprId, Ident>,
    taken: FxHashSet<String>,
}

impl Names {
    /// Keeps identifiers of the surrounding code from being given to expressions.
    pub fn reserve(&mut self, names: &[&str]) {
        self.taken.extend(names.iter().map(|&name| name.to_owned()));
    }

    /// The identifier of an expression, the same at every call.
    pub fn of(&mut self, graph: &Graph, expr: ExprId) -> Ident {
        if let Some(known) = self.given.get(&expr) {
            return known.clone();
        }
        // Formulas may give any name.
        let own = graph.name_of(expr).filter(|name| is_identifier(name));
        let wanted = own.map_or_else(|| self.descriptive(graph, expr), str::to_owned);
        let mut name = wanted.clone();
        let mut suffix = 2;
        while !self.taken.insert(name.clone()) {
            name = format!("{wanted}_v{suffix}");
            suffix += 1;
        }
        let ident = format_ident!("{name}");
        self.given.insert(expr, ident.clone());
        ident
    }

    /// The identifier of an expression that has one.
    pub fn known(&self, expr: ExprId) -> Option<Ident> {
        self.given.get(&expr).cloned()
    }

    /// A name from the operands' names where that stays short, or else from the operation.
    fn descriptive(&self, graph: &Graph, expr: ExprId) -> String {
        let part = |x: ExprId| -> Option<String> {
            match graph.op(x) {
                Op::Neg(inner) => Some(format!("minus_{}", self.given.get(&inner)?)),
                Op::Constant(bits) => {
                    let value = f64::from_bits(bits);
                    (value.fract() == 0.0 && value.abs() < 1e3)
                        .then(|| format!("{}{}", if value < 0.0 { "m" } else { "c" }, value.abs()))
                }
                _ => self.given.get(&x).map(ToString::to_string),
            }
        };
        let joined = |x: ExprId, word: &str, y: ExprId| {
            let name = format!("{}_{word}{}", part(x)?, part(y)?);
            (name.len() <= MOST_CHARACTERS).then_some(name)
        };
        let (short, general) = match graph.op(expr) {
            Op::Mul(x, y) if x == y => (part(x).map(|x| format!("{x}_squared")), "product"),
            Op::Mul(x, y) => (joined(x, "", y), "product"),
            Op::Add(x, y) => (joined(x, "plus_", y), "sum"),
            Op::Div(x, y) | Op::DivOrZero(x, y) => (joined(x, "over_", y), "quotient"),
            Op::Neg(x) => (part(x).map(|x| format!("minus_{x}")), "negative"),
            Op::Sqrt(_) => (None, "root"),
            Op::Exp(_) => (None, "exponential"),
            Op::Function(Function::Ln, _) => (None, "logarithm"),
            Op::Function(Function::Sin, _) => (None, "sine"),
            Op::Function(Function::Cos, _) => (None, "cosine"),
            Op::Function(Function::Cbrt, _) => (None, "cube_root"),
            Op::Atan2(..) => (None, "angle"),
            Op::RealPower(..) => (None, "power"),
            Op::Select { .. } => (None, "choice"),
            Op::Sum(_) => (None, "total"),
            _ => (None, "term"),
        };
        short
            .filter(|name| name.starts_with(|c: char| c.is_ascii_lowercase()))
            .unwrap_or_else(|| general.to_owned())
    }
}
