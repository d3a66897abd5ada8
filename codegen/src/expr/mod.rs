//! Formulas as they are written on paper: handles to expressions, with operators and functions.
//!
//! Promises:
//! * An [`Expr`] is a sheet and an id, copied freely. Every operation calls the constructor of the same name in
//!   [`Graph`], so formulas are simplified while they are written.
//! * Nothing is differentiated here: [`Expr::by`] asks the derivative engine.
//! * Expressions of two sheets cannot be combined: ids would mean something else.
//! * One type serves elements and nodes. The graph knows each expression's [`Scope`] and widens it; only
//!   [`Expr::sum`] leads back from a node to the element.

mod operators;
mod sheet;
mod small;
mod system;
mod vector;

use std::borrow::Borrow;
use std::fmt;

use crate::graph::{ExprId, Function, Graph, Op, Polynomial, Scope, SymbolId};
pub use sheet::Sheet;
pub(crate) use small::MOST_BY_CRAMER;
pub use small::{determinant, inverse, inverse_by_elimination, solve};
pub use system::System;
pub(crate) use vector::entry_name;
pub use vector::{Mat2, Mat3, Matrix, Vec2, Vec3, Vector};

/// An expression of a [`Sheet`].
#[derive(Clone, Copy)]
pub struct Expr<'g> {
    sheet: &'g Sheet,
    id: ExprId,
}

/// Symbols, with the values they take.
pub type Values<'g> = Vec<(Expr<'g>, Expr<'g>)>;

/// x < y, see [`Expr::less`].
#[derive(Clone, Copy, Debug)]
pub struct Less<'g>(Expr<'g>, Expr<'g>);

/// What a formula may contain: an expression or a number.
pub trait Term<'g>: Copy {
    /// As an expression of a sheet.
    fn on(self, sheet: &'g Sheet) -> Expr<'g>;
}

impl<'g> Term<'g> for Expr<'g> {
    fn on(self, sheet: &'g Sheet) -> Self {
        assert!(std::ptr::eq(self.sheet, sheet), "expressions of two sheets cannot be combined");
        self
    }
}

impl<'g> Term<'g> for f64 {
    fn on(self, sheet: &'g Sheet) -> Expr<'g> {
        sheet.number(self)
    }
}

/// Names of the global axes.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

impl<'g> Expr<'g> {
    /// Its sheet.
    pub const fn sheet(self) -> &'g Sheet {
        self.sheet
    }

    /// Its id in the graph.
    pub const fn id(self) -> ExprId {
        self.id
    }

    fn map(self, make: impl FnOnce(&mut Graph, ExprId) -> ExprId) -> Self {
        self.sheet.make(|g| make(g, self.id))
    }

    fn with(self, other: impl Term<'g>, make: impl FnOnce(&mut Graph, ExprId, ExprId) -> ExprId) -> Self {
        let other = other.on(self.sheet).id;
        self.sheet.make(|g| make(g, self.id, other))
    }

    /// Gives it a name in emitted code, see [`Graph::name`]. One that is no identifier of Rust is not taken there.
    #[must_use]
    pub fn named(self, name: &str) -> Self {
        self.map(|g, x| g.name(x, name))
    }

    /// A symbol bound to it: equal in value, but a variable of its own for differentiation.
    #[must_use]
    pub fn bind(self, name: &str) -> Self {
        self.map(|g, x| g.bind(name, x))
    }

    /// The same, of one name and value always the same symbol.
    pub(crate) fn bind_once(self, name: &str) -> Self {
        self.map(|g, x| g.bind_once(name, x))
    }

    /// Its scope.
    pub fn scope(self) -> Scope {
        self.sheet.graph().scope(self.id)
    }

    /// The symbol it is.
    ///
    /// # Panics
    /// If it is no symbol.
    #[track_caller]
    pub fn symbol(self) -> SymbolId {
        self.sheet.graph().symbol_of(self.id)
    }

    /// Name of the symbol it is.
    ///
    /// # Panics
    /// If it is no symbol.
    #[track_caller]
    pub fn symbol_name(self) -> String {
        let symbol = self.symbol();
        self.sheet.graph().symbol_data(symbol).name.clone()
    }

    /// What the symbol it is is bound to; nothing for an input.
    ///
    /// # Panics
    /// If it is no symbol.
    #[track_caller]
    pub fn definition(self) -> Option<Self> {
        let symbol = self.symbol();
        let definition = self.sheet.graph().symbol_data(symbol).definition;
        definition.map(|id| self.sheet.expr(id))
    }

    /// Its operation, by ids.
    pub fn operation(self) -> Op {
        self.sheet.graph().op(self.id)
    }

    /// Whether it has a name in emitted code.
    pub fn has_name(self) -> bool {
        self.sheet.graph().name_of(self.id).is_some()
    }

    /// A number and the other factors, in a fixed order; one factor if it is no product.
    pub fn factors(self) -> (f64, Vec<Self>) {
        let (coefficient, factors) = self.sheet.graph().coefficient_and_factors(self.id);
        (coefficient, self.sheet.exprs(factors))
    }

    /// The number it is, if it is one.
    pub fn value(self) -> Option<f64> {
        self.sheet.graph().constant_value(self.id)
    }

    /// Whether a symbol is among what it is made of; definitions of bound symbols are not entered.
    pub fn contains(self, symbol: Self) -> bool {
        self.sheet.graph().contains(self.id, symbol.id)
    }

    /// What the unknowns in it follow from, see [`Graph::equations`].
    pub(crate) fn equations(self) -> Vec<Self> {
        let equations = self.sheet.graph().equations(self.id);
        self.sheet.exprs(equations)
    }

    /// Whether it is the number 0.
    pub fn is_zero(self) -> bool {
        self.value() == Some(0.0)
    }

    /// Its derivative by a symbol, see [`Graph::derivative`]; in the formulas of an element also through what
    /// [`define`](crate::ElementModel::define) has named.
    ///
    /// # Panics
    /// If `symbol` is no symbol: neither a variable nor a parameter nor of [`define`](crate::ElementModel::define), which leaves numbers and
    /// quantities of nodes what they are.
    #[must_use]
    #[track_caller]
    pub fn by(self, symbol: Self) -> Self {
        let symbol = symbol.symbol();
        self.map(|g, x| g.derivative_of_formula(x, symbol))
    }

    /// Its value where symbols have other values, see [`Graph::substitute`]; in the formulas of an element also of what
    /// [`define`](crate::ElementModel::define) has named.
    ///
    /// # Panics
    /// If what is to be replaced is no symbol, or the unknowns of equations change with it: these are solved with the old values.
    #[must_use]
    #[track_caller]
    pub fn at(self, values: &[(Self, Self)]) -> Self {
        let values = values_on(self.sheet, values);
        self.map(|g, x| g.substitute_in_formulas(&[x], &values)[0])
    }

    /// The expression with symbols in the place of norms that change with the variables, see [`Graph::with_norm_symbols`].
    pub(crate) fn with_norm_symbols(self, variables: &[Self]) -> Self {
        self.map(|g, x| g.with_norm_symbols(x, &ids(variables)))
    }

    /// Whether it is the symbol of a norm, √q of a symbol q.
    pub(crate) fn is_norm_symbol(self) -> bool {
        self.sheet.graph().is_norm_symbol(self.id)
    }

    /// Makes mixed second derivatives by these symbols one expression, whichever symbol comes first.
    pub(crate) fn unite_mixed_derivatives(self, symbols: impl Iterator<Item = Self>) {
        let symbols: Vec<SymbolId> = symbols.map(Self::symbol).collect();
        self.sheet.edit(|g| g.unite_mixed_derivatives(self.id, &symbols));
    }

    /// Sum over the nodes.
    #[must_use]
    pub fn sum(self) -> Self {
        self.map(Graph::sum)
    }

    /// √x
    #[must_use]
    pub fn sqrt(self) -> Self {
        self.map(Graph::sqrt)
    }

    /// eˣ
    #[must_use]
    pub fn exp(self) -> Self {
        self.map(Graph::exp)
    }

    /// ln x
    #[must_use]
    pub fn ln(self) -> Self {
        self.map(|g, x| g.function(Function::Ln, x))
    }

    /// sin x
    #[must_use]
    pub fn sin(self) -> Self {
        self.map(|g, x| g.function(Function::Sin, x))
    }

    /// cos x
    #[must_use]
    pub fn cos(self) -> Self {
        self.map(|g, x| g.function(Function::Cos, x))
    }

    /// ∛x
    #[must_use]
    pub fn cbrt(self) -> Self {
        self.map(|g, x| g.function(Function::Cbrt, x))
    }

    /// Angle of the point (`x`, `self`).
    #[must_use]
    pub fn atan2(self, x: impl Term<'g>) -> Self {
        self.with(x, Graph::atan2)
    }

    /// xᵏ for an integer k
    #[must_use]
    pub fn powi(self, exponent: i32) -> Self {
        self.map(|g, x| g.power(x, exponent))
    }

    /// xʸ for x > 0
    #[must_use]
    pub fn powf(self, exponent: impl Term<'g>) -> Self {
        self.with(exponent, Graph::real_power)
    }

    /// √(x² + y²). Its direction is 0 at the origin, where energies that are smooth have their derivatives all the same.
    #[must_use]
    pub fn hypot(self, other: impl Term<'g>) -> Self {
        self.with(other, Graph::hypot)
    }

    /// P(x)
    #[must_use]
    pub fn polynomial(self, polynomial: Polynomial) -> Self {
        self.map(|g, x| g.polynomial(x, polynomial))
    }

    /// 1/x, and 0 for x = 0.
    #[must_use]
    pub fn reciprocal_or_zero(self) -> Self {
        self.sheet.one().with(self, Graph::div_or_zero)
    }

    /// x/y, and 0 for y = 0 and a finite x.
    #[must_use]
    pub fn div_or_zero(self, divisor: impl Term<'g>) -> Self {
        self.with(divisor, Graph::div_or_zero)
    }

    /// |x|
    #[must_use]
    pub fn abs(self) -> Self {
        self.less(0.0).select(-self, self)
    }

    /// The smaller of the two; the other one if this is not smaller.
    #[must_use]
    pub fn min(self, other: impl Term<'g>) -> Self {
        let other = other.on(self.sheet);
        self.less(other).select(self, other)
    }

    /// The larger of the two; this one if it is not smaller.
    #[must_use]
    pub fn max(self, other: impl Term<'g>) -> Self {
        let other = other.on(self.sheet);
        self.less(other).select(other, self)
    }

    /// The condition x < y.
    pub fn less(self, other: impl Term<'g>) -> Less<'g> {
        Less(self, other.on(self.sheet))
    }
}

impl<'g> Less<'g> {
    /// `then` where the condition holds, `otherwise` elsewhere.
    pub fn select(self, then: impl Term<'g>, otherwise: impl Term<'g>) -> Expr<'g> {
        let Self(x, y) = self;
        let (then, otherwise) = (then.on(x.sheet).id, otherwise.on(x.sheet).id);
        x.sheet.make(|g| g.select_less(x.id, y.id, then, otherwise))
    }
}

/// x · y for two vectors of equal length, see [`Graph::dot`].
///
/// # Panics
/// If the vectors are empty or have different lengths.
#[track_caller]
pub fn dot<'g>(
    x: impl IntoIterator<Item = impl Borrow<Expr<'g>>>,
    y: impl IntoIterator<Item = impl Borrow<Expr<'g>>>,
) -> Expr<'g> {
    let ((sheet, x), (_, y)) = (on_sheet(x), on_sheet(y));
    assert_eq!(x.len(), y.len(), "a dot product needs vectors of equal length");
    sheet.make(|g| g.dot(&x, &y))
}

/// Sum of several terms, added from the left.
///
/// # Panics
/// If there are none.
#[track_caller]
pub fn total<'g>(terms: impl IntoIterator<Item = impl Borrow<Expr<'g>>>) -> Expr<'g> {
    let (sheet, terms) = on_sheet(terms);
    sheet.make(|g| g.total(&terms))
}

/// Several expressions where symbols have other values, see [`Expr::at`].
#[track_caller]
pub fn all_at<'g>(exprs: &[Expr<'g>], values: &[(Expr<'g>, Expr<'g>)]) -> Vec<Expr<'g>> {
    let (sheet, exprs) = on_sheet(exprs);
    let values = values_on(sheet, values);
    sheet.exprs(sheet.edit(|g| g.substitute_in_formulas(&exprs, &values)))
}

#[track_caller]
fn values_on<'g>(sheet: &'g Sheet, values: &[(Expr<'g>, Expr<'g>)]) -> Vec<(SymbolId, ExprId)> {
    values.iter().map(|(symbol, value)| (symbol.on(sheet).symbol(), value.on(sheet).id)).collect()
}

/// Binds expressions to symbols `name_0`, ….
#[must_use]
pub fn bind_all<'g>(name: &str, exprs: &[Expr<'g>]) -> Vec<Expr<'g>> {
    exprs.iter().enumerate().map(|(k, x)| x.bind(&format!("{name}_{k}"))).collect()
}

/// Ids of expressions.
pub fn ids(exprs: &[Expr<'_>]) -> Vec<ExprId> {
    exprs.iter().map(|x| x.id()).collect()
}

/// The sheet of terms, and their ids.
#[track_caller]
fn on_sheet<'g>(exprs: impl IntoIterator<Item = impl Borrow<Expr<'g>>>) -> (&'g Sheet, Vec<ExprId>) {
    let exprs: Vec<Expr<'g>> = exprs.into_iter().map(|x| *x.borrow()).collect();
    let sheet = exprs.first().expect("at least one term").sheet;
    (sheet, exprs.into_iter().map(|x| x.on(sheet).id).collect())
}

impl PartialEq for Expr<'_> {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.sheet, other.sheet) && self.id == other.id
    }
}

impl Eq for Expr<'_> {}

impl fmt::Debug for Expr<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let graph = self.sheet.graph();
        write!(f, "{:?} = {:?}", self.id, graph.op(self.id))?;
        graph.name_of(self.id).map_or(Ok(()), |name| write!(f, " ({name})"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpret::{Interpreter, NodeInputs};

    fn value(expr: Expr<'_>, x: f64) -> f64 {
        let mut inputs = NodeInputs::new(0);
        inputs.set_element("x", x);
        Interpreter::new(&expr.sheet().graph(), &inputs).element(expr.id())
    }

    #[test]
    fn every_function_has_its_value_and_its_derivative() {
        type Of = (fn(Expr<'_>) -> Expr<'_>, fn(f64) -> f64, fn(f64) -> f64);
        let all: [Of; 13] = [
            (|x| 2.0 * x - 1.0 / x + x / 4.0, |x| 2.0 * x - 1.0 / x + x / 4.0, |x| 2.25 + 1.0 / (x * x)),
            (|x| -(1.0 - x) * x + 3.0, |x| (x - 1.0) * x + 3.0, |x| 2.0 * x - 1.0),
            (|x| x.sqrt(), f64::sqrt, |x| 0.5 / x.sqrt()),
            (|x| x.exp(), f64::exp, f64::exp),
            (|x| x.ln(), f64::ln, f64::recip),
            (|x| x.sin(), f64::sin, f64::cos),
            (|x| x.cos(), f64::cos, |x| -x.sin()),
            (|x| x.cbrt(), f64::cbrt, |x| 1.0 / (3.0 * x.cbrt().powi(2))),
            (|x| (2.0 * x).atan2(3.0), |x| (2.0 * x).atan2(3.0), |x| 6.0 / (9.0 + 4.0 * x * x)),
            (|x| x.powi(-3), |x| x.powi(-3), |x| -3.0 * x.powi(-4)),
            (|x| x.powf(1.7), |x| x.powf(1.7), |x| 1.7 * x.powf(0.7)),
            (|x| (-x).abs().max(0.1).min(x * x), |x| x * x, |x| 2.0 * x),
            (|x| x.less(1.0).select(x.hypot(1.0), 0.0), |x| x.hypot(1.0), |x| x / x.hypot(1.0)),
        ];
        for (k, (expr, f, slope)) in all.into_iter().enumerate() {
            let sheet = Sheet::new();
            let x = sheet.input("x", Scope::Element);
            for at in [0.3, 0.8] {
                let (found, derivative) = (value(expr(x), at), value(expr(x).by(x), at));
                assert!((found - f(at)).abs() < 1e-14 * (1.0 + f(at).abs()), "{k}: {found}");
                assert!(
                    (derivative - slope(at)).abs() < 1e-14 * (1.0 + slope(at).abs()),
                    "{k}: {derivative}"
                );
            }
        }
    }

    #[test]
    fn a_sum_over_the_nodes_is_a_value_of_the_element() {
        let sheet = Sheet::new();
        let (x, scale) = (sheet.input("x_k", Scope::Node), sheet.input("scale", Scope::Element));
        let total = (scale * x.sin()).sum();
        assert_eq!((x.scope(), total.scope()), (Scope::Node, Scope::Element));
        let mut inputs = NodeInputs::new(2);
        inputs.set_element("scale", 3.0);
        inputs.set_node("x_k", vec![0.5, 1.5]);
        let found = Interpreter::new(&sheet.graph(), &inputs).element(total.id());
        assert!((found - 3.0 * (0.5_f64.sin() + 1.5_f64.sin())).abs() < 1e-15);
    }

    #[test]
    fn a_bound_symbol_is_a_variable_of_its_own() {
        let sheet = Sheet::new();
        let x = sheet.input("x", Scope::Element);
        let y = (x * x).bind("y");
        assert!((3.0 * y).by(x).is_zero());
        assert_eq!((y * y).by(y).at(&[(y, sheet.number(3.0))]).value(), Some(6.0));
    }

    #[test]
    #[should_panic(expected = "two sheets")]
    fn two_sheets_are_not_mixed() {
        let sheets = [Sheet::new(), Sheet::new()];
        let [x, y] = [0, 1].map(|k| sheets[k].input("x", Scope::Element));
        let _ = x + y;
    }
}
