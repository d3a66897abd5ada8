//! Finds the quantities through which a function depends on its variables.
//!
//! Those that were bound by the caller are intermediates in any case, as derivatives do not see through them. Two kinds more are found in
//! the expressions:
//!
//! * **linear images**: the largest subexpressions that are linear in the variables and enter something that is not, such as the
//!   entries of a deformation gradient;
//! * **arguments**: what stands in a root, a logarithm, a power or a divisor and depends on several symbols, such as a determinant. The
//!   second derivative of f(u) is f″ ∇u ⊗ ∇u + f′ ∇²u, which has one product of rank one for all of f.

use std::collections::BTreeSet;

use rustc_hash::{FxHashMap, FxHashSet};

use super::chain::Chain;
use super::definition::Intermediate;
use crate::expr::{Expr, Sheet};
use crate::graph::{ExprId, Graph, Op};

/// Outputs, and the chain of intermediates that they are written in.
#[derive(Clone, Debug)]
pub struct Written<'g> {
    /// What depends on the variables through the chain.
    pub outputs: Vec<Expr<'g>>,
    /// The intermediates.
    pub chain: Chain<'g>,
}

/// The outputs as they are, with the intermediates that were bound in them.
pub fn as_bound<'g>(outputs: &[Expr<'g>], variables: &[Expr<'g>]) -> Written<'g> {
    let intermediates = bound(outputs, variables);
    Written { outputs: outputs.to_vec(), chain: Chain::new(variables.to_vec(), &intermediates) }
}

/// The outputs rewritten with the intermediates that are found in them besides those that were bound.
pub fn with_found<'g>(sheet: &'g Sheet, outputs: &[Expr<'g>], variables: &[Expr<'g>]) -> Written<'g> {
    let mut finder = Finder {
        sheet,
        symbols: variables.iter().map(|x| x.id()).collect(),
        replacements: Vec::new(),
        intermediates: Vec::new(),
    };
    for Intermediate { symbol, definition } in bound(outputs, variables) {
        let rewritten = finder.rewritten(definition);
        if rewritten == definition {
            finder.add(symbol, definition);
        } else {
            let other = sheet.make(|g| g.bind_again(symbol.id(), rewritten.id()));
            finder.replacements.push((symbol.id(), other.id()));
            finder.add(other, rewritten);
        }
    }
    let outputs: Vec<Expr<'g>> = outputs.iter().map(|&x| finder.rewritten(x)).collect();
    // The equations of roots keep the symbols they were written with: these follow the ones that stand for them.
    for Intermediate { symbol, .. } in bound(&outputs, variables) {
        let stands_for = finder.replacements.iter().find(|(old, _)| *old == symbol.id());
        let Some(&(_, new)) = stands_for else { continue };
        let place = finder.intermediates.iter().position(|intermediate| intermediate.symbol.id() == new);
        let definition = sheet.expr(new);
        finder.intermediates.insert(place.map_or(0, |place| place + 1), Intermediate { symbol, definition });
    }
    Written { outputs, chain: Chain::new(variables.to_vec(), &finder.intermediates) }
}

/// Bound symbols through which outputs depend on variables, each after those it depends on.
fn bound<'g>(outputs: &[Expr<'g>], variables: &[Expr<'g>]) -> Vec<Intermediate<'g>> {
    let Some(first) = outputs.first() else { return Vec::new() };
    let sheet = first.sheet();
    let graph = sheet.graph();
    let mut depends: FxHashMap<ExprId, bool> = variables.iter().map(|x| (x.id(), true)).collect();
    let mut order = Vec::new();
    for output in outputs {
        visit(&graph, output.id(), &mut depends, &mut order);
    }
    let intermediate = |(symbol, definition)| Intermediate {
        symbol: sheet.expr(symbol),
        definition: sheet.expr(definition),
    };
    order.into_iter().map(intermediate).collect()
}

/// Whether an expression depends on the variables; lists the bound symbols below it that do.
fn visit(
    graph: &Graph,
    expr: ExprId,
    depends: &mut FxHashMap<ExprId, bool>,
    order: &mut Vec<(ExprId, ExprId)>,
) -> bool {
    if let Some(&known) = depends.get(&expr) {
        return known;
    }
    let dependencies = graph.varying_dependencies(expr);
    let mut any = false;
    for &x in &dependencies {
        any |= visit(graph, x, depends, order);
    }
    depends.insert(expr, any);
    if let (Op::Symbol(_), true, [definition]) = (graph.op(expr), any, dependencies.as_slice()) {
        order.push((expr, *definition));
    }
    any
}

struct Finder<'g> {
    sheet: &'g Sheet,
    /// Variables and intermediates.
    symbols: BTreeSet<ExprId>,
    /// Expressions, and the symbols that stand for them.
    replacements: Vec<(ExprId, ExprId)>,
    intermediates: Vec<Intermediate<'g>>,
}

/// The symbols that an expression depends on.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Reach {
    None,
    One(ExprId),
    Many,
}

#[derive(Clone, Copy)]
struct Kind {
    reach: Reach,
    is_linear: bool,
}

impl<'g> Finder<'g> {
    fn add(&mut self, symbol: Expr<'g>, definition: Expr<'g>) {
        self.symbols.insert(symbol.id());
        self.intermediates.push(Intermediate { symbol, definition });
    }

    /// The expression written in intermediates, new ones where it has any.
    fn rewritten(&mut self, piece: Expr<'g>) -> Expr<'g> {
        // One at a time: ln det F depends on one symbol once the determinant is one.
        while let Some(found) = self.first_found_in(piece.id()) {
            let definition = self.replaced(found);
            let name = self.sheet.graph().name_of(found).map_or_else(|| "part".to_owned(), str::to_owned);
            let symbol = self.sheet.make(|g| g.bind_unique(&name, definition.id()));
            self.replacements.push((found, symbol.id()));
            self.add(symbol, definition);
        }
        self.replaced(piece.id())
    }

    fn replaced(&self, expr: ExprId) -> Expr<'g> {
        self.sheet.make(|g| g.replace(expr, &self.replacements))
    }

    /// A linear image or an argument that contains no other one.
    fn first_found_in(&self, piece: ExprId) -> Option<ExprId> {
        let graph = self.sheet.graph();
        let mut kinds = FxHashMap::default();
        self.kind(&graph, piece, &mut kinds);
        let left_out = graph.left_out(&[piece]);
        // By a symbol in its place a choice would not leave out its derivatives.
        let is_lost = |x: &ExprId| left_out.contains(x) && !graph.is_smooth(*x);
        let mut found: Option<ExprId> = None;
        for (&expr, kind) in &kinds {
            if kind.is_linear || self.is_symbol(expr) {
                continue;
            }
            let nonlinear = arguments(&graph, expr);
            for operand in graph.operands(expr).into_iter().map(|x| self.core(&graph, x, &kinds)) {
                let kind = kinds[&operand];
                let is_argument = nonlinear.contains(&operand) && !matches!(graph.op(operand), Op::Hypot(..));
                if kind.reach == Reach::Many && (kind.is_linear || is_argument) && !is_lost(&operand) {
                    found = found.into_iter().chain([operand]).min();
                }
            }
        }
        found
    }

    fn is_symbol(&self, expr: ExprId) -> bool {
        self.symbols.contains(&expr) || self.replacements.iter().any(|(from, _)| *from == expr)
    }

    /// An expression without factors that depend on no symbol.
    fn core(&self, graph: &Graph, expr: ExprId, kinds: &FxHashMap<ExprId, Kind>) -> ExprId {
        if self.is_symbol(expr) {
            return expr;
        }
        let is_free = |x: &ExprId| kinds[x].reach == Reach::None;
        match graph.op(expr) {
            Op::Neg(x) => self.core(graph, x, kinds),
            Op::Mul(x, y) if is_free(&x) && !is_free(&y) => self.core(graph, y, kinds),
            Op::Mul(x, y) if is_free(&y) && !is_free(&x) => self.core(graph, x, kinds),
            _ => expr,
        }
    }

    fn kind(&self, graph: &Graph, expr: ExprId, kinds: &mut FxHashMap<ExprId, Kind>) -> Kind {
        if let Some(&known) = kinds.get(&expr) {
            return known;
        }
        let kind = if self.is_symbol(expr) {
            Kind { reach: Reach::One(expr), is_linear: true }
        } else {
            let operands: Vec<Kind> =
                graph.varying_dependencies(expr).into_iter().map(|x| self.kind(graph, x, kinds)).collect();
            let reach = operands.iter().fold(Reach::None, |reach, kind| match (reach, kind.reach) {
                (Reach::None, other) | (other, Reach::None) => other,
                (one, other) if one == other => one,
                _ => Reach::Many,
            });
            Kind { reach, is_linear: reach == Reach::None || is_linear(graph.op(expr), &operands) }
        };
        kinds.insert(expr, kind);
        kind
    }
}

/// Whether an operation on operands that depend on symbols is linear in these.
fn is_linear(op: Op, operands: &[Kind]) -> bool {
    let is_free = |kind: &Kind| kind.reach == Reach::None;
    match (op, operands) {
        (Op::Add(..) | Op::Neg(_), operands) => operands.iter().all(|kind| kind.is_linear),
        (Op::Mul(..), [x, y]) => x.is_linear && y.is_linear && (is_free(x) || is_free(y)),
        (Op::Div(..) | Op::DivOrZero(..), [x, y]) => x.is_linear && is_free(y),
        _ => false,
    }
}

/// Operands that a function which is not linear is applied to.
fn arguments(graph: &Graph, expr: ExprId) -> FxHashSet<ExprId> {
    let arguments = match graph.op(expr) {
        // By a symbol in its place a norm would have no derivatives at zero, where its square has them.
        Op::Power(x, _) | Op::Polynomial(x, _) if graph.has_norm(x) => Vec::new(),
        Op::Sqrt(x) | Op::Exp(x) | Op::Function(_, x) | Op::Power(x, _) | Op::Polynomial(x, _) => vec![x],
        Op::Div(_, y) | Op::DivOrZero(_, y) => vec![y],
        Op::RealPower(x, y) => vec![x, y],
        Op::Mul(x, y) if x == y => vec![x],
        _ => Vec::new(),
    };
    arguments.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::{Mat3, Vec3};
    use crate::graph::Scope;

    fn names(written: &Written<'_>) -> Vec<String> {
        written.chain.intermediates().map(|v| v.symbol.symbol_name()).collect()
    }

    #[test]
    fn a_deformation_gradient_and_its_determinant_are_found() {
        let sheet = Sheet::new();
        let vector = |name: &str| sheet.vector(name, Scope::Element);
        let x: [Vec3<'_>; 3] = ["x_1", "x_2", "x_3"].map(vector);
        let g = ["g_1", "g_2", "g_3"].map(vector);
        let outer = |k: usize| x[k].outer(g[k]);
        let f = (outer(0) + outer(1) + outer(2)).named("F");
        let j = f.determinant().named("J");
        let energy = f.double_dot(f) + j.ln().powi(2);
        let variables: Vec<_> = x.iter().flat_map(|x| x.0).collect();

        let written = with_found(&sheet, &[energy], &variables);
        let entries = (1..=3).flat_map(|i| (1..=3).map(move |j| format!("F_{i}_{j}")));
        let mut expected: Vec<String> = entries.chain(["J".to_owned()]).collect();
        let mut found = names(&written);
        found.sort();
        expected.sort();
        assert_eq!(found, expected);
        assert_eq!(written.chain.ways().len(), 4);
        assert!(variables.iter().all(|&x| !written.outputs[0].contains(x)));
        assert!(names(&as_bound(&[energy], &variables)).is_empty());
    }

    #[test]
    fn what_was_bound_is_an_intermediate_and_so_is_what_it_hides() {
        let sheet = Sheet::new();
        let [x, y, k] = ["x", "y", "k"].map(|name| sheet.input(name, Scope::Element));
        let length = (x - y).hypot(x * k).bind("length");
        let energy = 0.5 * k * length * length;
        let constant = (k * k).bind("constant");
        let written = as_bound(&[energy, constant], &[x, y]);
        assert_eq!(names(&written), ["length"]);
        assert_eq!(names(&with_found(&sheet, &[energy], &[x, y])), ["part", "length_2"]);
    }

    #[test]
    fn what_is_found_in_one_place_stands_for_itself_in_all() {
        let sheet = Sheet::new();
        let [x, y, k] = ["x", "y", "k"].map(|name| sheet.input(name, Scope::Element));
        let stretch = k * (x - y);
        let energy = (stretch.exp() + stretch * stretch * stretch).sqrt();
        let written = with_found(&sheet, &[energy], &[x, y]);
        assert!([x, y].iter().all(|&x| !written.outputs[0].contains(x)));
    }

    #[test]
    fn a_matrix_that_is_used_as_it_is_needs_no_intermediate() {
        let sheet = Sheet::new();
        let f = Mat3::from_fn(|i, j| sheet.input(&format!("F_{i}{j}"), Scope::Element));
        let variables: Vec<_> = f.as_flattened().to_vec();
        assert!(names(&with_found(&sheet, &[f.determinant()], &variables)).is_empty());
    }
}
