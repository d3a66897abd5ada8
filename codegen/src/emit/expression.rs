//! Expressions as tokens, with their operation counts.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{ToTokens, format_ident, quote};

use super::count::OpCounts;
use super::names::Names;
use crate::graph::{ExprId, Graph, Op, Scope};
use crate::schedule::Layout;

/// Binding strength of rendered tokens.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Strength {
    Sum,
    Product,
    Atom,
}

/// Which of a kernel's two kinds of vectors code computes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Vectors {
    /// `E`, values of element scope.
    Element,
    /// `T`, values of node scope.
    Node,
}

/// What the lanes of vectors are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lanes {
    /// Elements or nodes, as a `Shape` says: node code computes with `T`.
    Shape,
    /// Elements: node code computes with `E`, too.
    Elements,
}

/// Writes expressions of one function.
pub(super) struct Writer<'a> {
    graph: &'a Graph,
    layout: &'a Layout,
    pub names: Names,
    pub lanes: Lanes,
    vectors: Vectors,
    /// Element values that node code has used since it began.
    spread: Vec<Ident>,
    /// Operations written since the last [`take_counts`](Self::take_counts).
    counts: OpCounts,
}

impl<'a> Writer<'a> {
    pub fn new(graph: &'a Graph, layout: &'a Layout, names: Names) -> Self {
        let (vectors, spread) = (Vectors::Element, Vec::new());
        Self { graph, layout, names, lanes: Lanes::Shape, vectors, spread, counts: OpCounts::default() }
    }

    /// What follows is node code, until [`end_nodes`](Self::end_nodes).
    pub fn begin_nodes(&mut self) {
        self.vectors = Vectors::Node;
    }

    /// What follows is element code again. Returns the names of element values that the node code has used.
    pub fn end_nodes(&mut self) -> Vec<Ident> {
        self.vectors = Vectors::Element;
        std::mem::take(&mut self.spread)
    }

    /// Operations written since the last call.
    pub fn take_counts(&mut self) -> OpCounts {
        std::mem::take(&mut self.counts)
    }

    /// The identifier of a bound expression.
    pub fn ident(&mut self, expr: ExprId) -> Ident {
        self.names.of(self.graph, expr)
    }

    /// The constant that names a node value's place among those kept.
    pub fn place(&mut self, expr: ExprId) -> Ident {
        format_ident!("{}", self.ident(expr).to_string().to_ascii_uppercase())
    }

    /// The expression where it is used: its name, or its operation.
    pub fn used(&mut self, expr: ExprId) -> TokenStream {
        self.operand(expr).0
    }

    /// The operation of an expression, for its `let`.
    pub fn definition(&mut self, expr: ExprId) -> TokenStream {
        self.operation(expr).0
    }

    /// `sum + body` for the nodes that are present, fused where the body is a product without a name.
    pub fn accumulated(&mut self, sum: &Ident, body: ExprId) -> TokenStream {
        if let Op::Mul(x, y) = self.graph.op(body)
            && !self.layout.bound.contains(&body)
        {
            self.counts.fused += 1;
            if self.lanes == Lanes::Elements {
                let (x, y) = (self.receiver(x), self.used(y));
                return quote!(#x.mul_add(#y, #sum));
            }
            let (x, y) = (self.used(x), self.used(y));
            return quote!(S::add_product(presence, #x, #y, #sum));
        }
        self.counts.additions += 1;
        if self.lanes == Lanes::Elements {
            let body = self.at_least(body, Strength::Product);
            return quote!(#sum + #body);
        }
        let body = self.used(body);
        quote!(S::add(presence, #body, #sum))
    }

    fn operand(&mut self, expr: ExprId) -> (TokenStream, Strength) {
        match self.graph.op(expr) {
            Op::Constant(bits) => (self.constant(f64::from_bits(bits)), Strength::Atom),
            _ if self.layout.bound.contains(&expr) => {
                let ident = self.ident(expr);
                if self.vectors == Vectors::Node
                    && self.graph.scope(expr) == Scope::Element
                    && !self.spread.contains(&ident)
                {
                    self.spread.push(ident.clone());
                }
                (quote!(#ident), Strength::Atom)
            }
            _ => self.operation(expr),
        }
    }

    fn at_least(&mut self, expr: ExprId, strength: Strength) -> TokenStream {
        let (tokens, own) = self.operand(expr);
        if own >= strength { tokens } else { quote!((#tokens)) }
    }

    /// An expression before a method call.
    fn receiver(&mut self, expr: ExprId) -> TokenStream {
        self.at_least(expr, Strength::Atom)
    }

    fn operation(&mut self, expr: ExprId) -> (TokenStream, Strength) {
        match self.graph.op(expr) {
            Op::Add(x, y) => self.addition(expr, x, y),
            Op::Neg(x) => {
                self.counts.negations += 1;
                let x = self.at_least(x, Strength::Atom);
                (quote!(-#x), Strength::Product)
            }
            Op::Mul(x, y) => {
                self.counts.multiplications += 1;
                let (x, y) = (self.at_least(x, Strength::Product), self.at_least(y, Strength::Atom));
                (quote!(#x * #y), Strength::Product)
            }
            Op::Div(x, y) => {
                self.counts.divisions += 1;
                let (x, y) = (self.at_least(x, Strength::Product), self.at_least(y, Strength::Atom));
                (quote!(#x / #y), Strength::Product)
            }
            Op::DivOrZero(x, y) => {
                self.counts.divisions += 1;
                self.counts.selections += 1;
                let (x, y) = (self.receiver(x), self.used(y));
                (quote!(#x.div_or_zero(#y)), Strength::Atom)
            }
            Op::Sqrt(x) => self.function("sqrt", x, None),
            Op::Exp(x) => self.function("exp", x, None),
            Op::Function(function, x) => self.function(function.name(), x, None),
            Op::Atan2(y, x) => self.function("atan2", y, Some(x)),
            Op::RealPower(x, y) => self.function("powf", x, Some(y)),
            Op::Select { x, y, then, otherwise } => {
                self.counts.selections += 1;
                let [x, y, then, otherwise] = [x, y, then, otherwise].map(|e| self.used(e));
                let vector = self.vector();
                (quote!(#vector::select_less(#x, #y, #then, #otherwise)), Strength::Atom)
            }
            op => unreachable!("{op:?} is always bound"),
        }
    }

    /// A function of one number, or of two, as a method of the first.
    fn function(&mut self, name: &str, x: ExprId, y: Option<ExprId>) -> (TokenStream, Strength) {
        self.counts.functions += 1;
        let (name, x) = (format_ident!("{name}"), self.receiver(x));
        let y = y.map(|y| self.used(y));
        (quote!(#x.#name(#y)), Strength::Atom)
    }

    fn addition(&mut self, sum: ExprId, x: ExprId, y: ExprId) -> (TokenStream, Strength) {
        let Some(&fused) = self.layout.fused.get(&sum) else {
            self.counts.additions += 1;
            for (positive, other) in [(x, y), (y, x)] {
                if let Some(negative) = self.free_negative(other) {
                    let positive = self.at_least(positive, Strength::Sum);
                    let negative = self.at_least(negative, Strength::Product);
                    return (quote!(#positive - #negative), Strength::Sum);
                }
            }
            let (x, y) = (self.at_least(x, Strength::Sum), self.at_least(y, Strength::Product));
            return (quote!(#x + #y), Strength::Sum);
        };
        self.counts.fused += 1;
        let other = if fused == x { y } else { x };
        let (factors, negative) = match self.graph.op(fused) {
            Op::Neg(product) => (self.graph.operands(product), true),
            _ => (self.graph.operands(fused), false),
        };
        // A number is no receiver to read: it goes second.
        let (p, q) = match self.graph.constant_value(factors[0]) {
            Some(_) => (factors[1], factors[0]),
            None => (factors[0], factors[1]),
        };
        let (p, q) = (self.receiver(p), self.used(q));
        let tokens = match (negative, self.free_negative(other)) {
            (false, Some(subtracted)) => {
                let subtracted = self.used(subtracted);
                quote!(#p.mul_sub(#q, #subtracted))
            }
            (false, None) => {
                let other = self.used(other);
                quote!(#p.mul_add(#q, #other))
            }
            (true, _) => {
                let other = self.used(other);
                quote!(#p.neg_mul_add(#q, #other))
            }
        };
        (tokens, Strength::Atom)
    }

    /// x of an expression −x that has no name of its own.
    fn free_negative(&self, expr: ExprId) -> Option<ExprId> {
        match self.graph.op(expr) {
            Op::Neg(inner) if !self.layout.bound.contains(&expr) => Some(inner),
            _ => None,
        }
    }

    /// The type of the vectors.
    fn vector(&self) -> TokenStream {
        match (self.vectors, self.lanes) {
            (Vectors::Element, _) | (_, Lanes::Elements) => quote!(E),
            (Vectors::Node, Lanes::Shape) => quote!(T),
        }
    }

    fn constant(&self, value: f64) -> TokenStream {
        let vector = self.vector();
        if value == 0.0 {
            quote!(#vector::ZERO)
        } else if value == 1.0 {
            quote!(#vector::ONE)
        } else if value.is_nan() {
            quote!(#vector::splat(f64::NAN))
        } else {
            let magnitude = if value.is_infinite() {
                quote!(f64::INFINITY)
            } else if value == f64::MIN_POSITIVE {
                // Written out it has hundreds of digits.
                quote!(f64::MIN_POSITIVE)
            } else {
                Literal::f64_unsuffixed(value.abs()).into_token_stream()
            };
            if value < 0.0 { quote!(#vector::splat(-#magnitude)) } else { quote!(#vector::splat(#magnitude)) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Sheet;

    #[test]
    fn functions_are_methods_of_numbers_and_lanes() {
        let sheet = Sheet::new();
        let [x, y] = ["x", "y"].map(|name| sheet.input(name, Scope::Element));
        let layout =
            Layout { bound: [x, y].into_iter().map(|symbol| symbol.id()).collect(), ..Layout::default() };
        let cases = [
            (x.ln(), "x.ln()"),
            (x.sin() + y, "y + x.sin()"),
            ((x + y).cos(), "(x + y).cos()"),
            (x.cbrt(), "x.cbrt()"),
            (x.atan2(-y), "x.atan2(-y)"),
            (x.powf(y), "x.powf(y)"),
        ];
        let graph = sheet.graph();
        let mut writer = Writer::new(&graph, &layout, Names::default());
        for (expr, expected) in cases {
            assert_eq!(writer.definition(expr.id()).to_string().replace(' ', ""), expected.replace(' ', ""));
        }
        assert_eq!(writer.take_counts().functions, cases.len());
    }
}
