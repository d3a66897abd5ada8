//! Expressions, statements and outputs of one function in C.

use std::fmt::Write as _;

use super::super::derivatives::{DIRECTION, Derivative};
use super::super::expression::Strength;
use super::super::names::Names;
use super::{TAKEN, WORDS, places};
use crate::graph::{ExprId, Function, Graph, Iteration, Limits, Op, RootFigure, RootId};
use crate::kernel::ElementSpec;
use crate::schedule::{Layout, Program, Solved, Statement};

/// How inputs and outputs are written, from name, place and number.
pub(super) struct Access<'a> {
    pub input: &'a dyn Fn(&str, &str, usize) -> String,
    /// An entry of a product's vector, from its number.
    pub direction: &'a dyn Fn(usize) -> String,
    pub value: &'a dyn Fn(&str, &str, usize) -> String,
    pub derivative: &'a dyn Fn(&str, usize) -> String,
}

/// Writes one function.
pub(super) struct Writer<'a> {
    pub program: &'a Program<ElementSpec>,
    graph: &'a Graph,
    layout: &'a Layout,
    access: &'a Access<'a>,
    pub names: Names,
    pub trace: Trace,
}

/// Variables of a piece of code: a loop over lanes has to fetch what it uses and other loops define.
#[derive(Default)]
pub(super) struct Trace {
    /// Those that it defines.
    pub defined: Vec<ExprId>,
    /// Those that it uses, in the order in which it does.
    pub used: Vec<ExprId>,
}

impl<'a> Writer<'a> {
    pub fn new(program: &'a Program<ElementSpec>, access: &'a Access<'a>) -> Self {
        let mut names = Names::default();
        names.reserve(&WORDS);
        names.reserve(&TAKEN);
        let derivatives = Derivative::names(&program.kernel.spec);
        names.reserve(&derivatives.iter().map(String::as_str).collect::<Vec<_>>());
        if program.kernel.spec.direction.is_some() {
            names.reserve(&[DIRECTION]);
        }
        for &root in program.roots.keys() {
            let iteration = format!("{}_iteration", program.kernel.graph.root(root).name);
            names.reserve(
                &["", "_residual", "_jacobian"]
                    .map(|part| format!("{iteration}{part}"))
                    .each_ref()
                    .map(String::as_str),
            );
        }
        let trace = Trace::default();
        Self { program, graph: &program.kernel.graph, layout: &program.layout, access, names, trace }
    }

    pub fn reads(&mut self, indent: &str) -> String {
        let (program, access) = (self.program, self.access);
        let spec = &program.kernel.spec;
        let inputs = spec.signature.inputs.iter().flat_map(|input| {
            let places = places(&input.dimensions).into_iter();
            input.symbols.iter().zip(places.map(move |place| (&input.name, place)))
        });
        let inputs = inputs.enumerate().map(|(number, (symbol, (name, place)))| {
            (program.symbol(symbol), (access.input)(name, &place, number))
        });
        let direction = spec.direction.iter().flat_map(|symbols| &symbols.element).enumerate();
        let direction = direction.map(|(k, symbol)| (program.symbol(symbol), (access.direction)(k)));
        self.reads_from(indent, inputs.chain(direction))
    }

    pub fn point_reads(&mut self, indent: &str) -> String {
        let program = self.program;
        let symbols = program.kernel.spec.signature.points.symbols.iter().enumerate();
        self.reads_from(
            indent,
            symbols.map(|(k, symbol)| (program.symbol(symbol), format!("points[point][{k}]"))),
        )
    }

    /// Those of some variables that are used, from their places.
    pub fn reads_from(
        &mut self,
        indent: &str,
        all: impl IntoIterator<Item = (Option<ExprId>, String)>,
    ) -> String {
        all.into_iter().filter_map(|(expr, from)| Some(self.read(indent, expr?, &from))).collect()
    }

    pub fn lets(&mut self, indent: &str, statements: &[Statement]) -> String {
        let mut text = String::new();
        for &statement in statements {
            match statement {
                Statement::Let(expr) => {
                    let (definition, _) = self.operation(expr);
                    self.trace.defined.push(expr);
                    let _ = writeln!(text, "{indent}const double {} = {definition};", self.name(expr));
                }
                Statement::Solve(root) => text += &self.root(indent, root),
            }
        }
        text
    }

    /// The iteration for a root, and what is used of it.
    fn root(&mut self, indent: &str, root: RootId) -> String {
        let (program, graph) = (self.program, self.graph);
        let data = graph.root(root);
        let iteration = format!("{}_iteration", data.name);
        let inner = format!("{indent}    ");
        let (advance, Limits { longest_step, evaluations }) = match data.iteration {
            Iteration::Newton => ("advance", Limits::default()),
            Iteration::Within(limits) => ("advance", limits),
            Iteration::Descent => ("descend", Limits::default()),
        };
        let (size, evaluations) = (data.unknowns.len(), evaluations.min(i32::MAX as u32));
        let longest =
            if longest_step.is_finite() { format!("{longest_step:?}") } else { "HUGE_VAL".to_owned() };
        let mut text = format!(
            "{indent}diffuse_contact_equations {iteration};\n\
             {indent}diffuse_contact_begin(&{iteration}, {size}, {longest}, {evaluations});\n{indent}for (;;) {{\n"
        );
        for (k, &unknown) in data.unknowns.iter().enumerate() {
            if let Some(expr) = program.symbol(&graph.symbol_data(unknown).name) {
                text += &self.read(&inner, expr, &format!("{iteration}.y[{k}] + {iteration}.step[{k}]"));
            }
        }
        text += &self.lets(&inner, &program.roots[&root]);
        let mut list = |all: &mut dyn Iterator<Item = &ExprId>| {
            all.map(|&x| self.operand(x).0).collect::<Vec<String>>().join(", ")
        };
        let residuals = list(&mut data.residuals.iter());
        let jacobian = list(&mut data.jacobian.iter().flatten());
        let _ = writeln!(
            text,
            "{inner}const double {iteration}_residual[] = {{{residuals}}}, {iteration}_jacobian[] = {{{jacobian}}};\n\
             {inner}if (diffuse_contact_{advance}(&{iteration}, {iteration}_residual, {iteration}_jacobian)) break;\n{indent}}}"
        );
        for (expr, solved) in program.solved(root) {
            let figure = match solved {
                Solved::Unknown(k) => format!("y[{k}]"),
                Solved::Figure(RootFigure::Residual) => "relative".to_owned(),
                Solved::Figure(RootFigure::Iterations) => "iterations".to_owned(),
            };
            text += &self.read(indent, expr, &format!("{iteration}.{figure}"));
        }
        text
    }

    /// Places that outputs are written to, with the expressions.
    pub fn targets(&self) -> Vec<(String, ExprId)> {
        let (mut targets, mut number) = (Vec::new(), 0);
        let kernel = &self.program.kernel;
        for value in &kernel.values {
            let returned = kernel.spec.signature.values.iter().find(|returned| returned.name == value.name);
            let places = returned.map(|returned| places(&returned.dimensions));
            for (k, &x) in value.components.iter().enumerate() {
                let to = match &places {
                    Some(places) => (self.access.value)(&value.name, &places[k], number),
                    None => (self.access.derivative)(&value.name, k),
                };
                number += 1;
                targets.push((to, x));
            }
        }
        targets
    }

    pub fn outputs(&mut self, indent: &str, operator: &str) -> String {
        let mut text = String::new();
        for (to, x) in self.targets() {
            let _ = writeln!(text, "{indent}{to} {operator} {};", self.operand(x).0);
        }
        text
    }

    pub fn zeros(&self, indent: &str) -> String {
        self.targets().into_iter().map(|(to, _)| format!("{indent}{to} = 0.0;\n")).collect()
    }

    /// A variable that is read.
    pub fn read(&mut self, indent: &str, expr: ExprId, from: &str) -> String {
        self.trace.defined.push(expr);
        format!("{indent}const double {} = {from};\n", self.name(expr))
    }

    pub fn name(&mut self, expr: ExprId) -> String {
        self.names.of(self.graph, expr).to_string()
    }

    pub fn operand(&mut self, expr: ExprId) -> (String, Strength) {
        match self.graph.op(expr) {
            Op::Constant(bits) => {
                let value = f64::from_bits(bits);
                let magnitude = match value.abs() {
                    x if x.is_nan() => "NAN".to_owned(),
                    f64::INFINITY => "INFINITY".to_owned(),
                    x => format!("{x:?}"),
                };
                (if value < 0.0 { format!("(-{magnitude})") } else { magnitude }, Strength::Atom)
            }
            _ if self.layout.bound.contains(&expr) => {
                self.trace.used.push(expr);
                (self.name(expr), Strength::Atom)
            }
            _ => self.operation(expr),
        }
    }

    pub fn at_least(&mut self, expr: ExprId, strength: Strength) -> String {
        let (text, own) = self.operand(expr);
        if own >= strength { text } else { format!("({text})") }
    }

    fn call(&mut self, function: &str, arguments: &[ExprId]) -> (String, Strength) {
        let arguments: Vec<String> = arguments.iter().map(|&x| self.operand(x).0).collect();
        (format!("{function}({})", arguments.join(", ")), Strength::Atom)
    }

    fn operation(&mut self, expr: ExprId) -> (String, Strength) {
        match self.graph.op(expr) {
            Op::Add(x, y) => self.addition(x, y),
            Op::Neg(x) => (format!("-{}", self.at_least(x, Strength::Atom)), Strength::Product),
            Op::Mul(x, y) => self.binary(x, "*", y),
            Op::Div(x, y) => self.binary(x, "/", y),
            Op::DivOrZero(x, y) => {
                let divisor = self.at_least(y, Strength::Atom);
                let (quotient, _) = self.binary(x, "/", y);
                (format!("({divisor} == 0.0 ? 0.0 : {quotient})"), Strength::Atom)
            }
            Op::Sqrt(x) => self.call("sqrt", &[x]),
            Op::Exp(x) => self.call("exp", &[x]),
            Op::Function(function, x) => {
                let name = match function {
                    Function::Ln => "log",
                    Function::Sin | Function::Cos | Function::Cbrt => function.name(),
                };
                self.call(name, &[x])
            }
            Op::Atan2(y, x) => self.call("atan2", &[y, x]),
            Op::RealPower(x, y) => self.call("pow", &[x, y]),
            Op::Select { x, y, then, otherwise } => {
                let [x, y, then, otherwise] =
                    [x, y, then, otherwise].map(|e| self.at_least(e, Strength::Atom));
                (format!("({x} < {y} ? {then} : {otherwise})"), Strength::Atom)
            }
            op => unreachable!("{op:?} is always bound"),
        }
    }

    fn binary(&mut self, x: ExprId, operator: &str, y: ExprId) -> (String, Strength) {
        let (x, y) = (self.at_least(x, Strength::Product), self.at_least(y, Strength::Atom));
        (format!("{x} {operator} {y}"), Strength::Product)
    }

    fn addition(&mut self, x: ExprId, y: ExprId) -> (String, Strength) {
        for (positive, other) in [(x, y), (y, x)] {
            if let Op::Neg(negative) = self.graph.op(other)
                && !self.layout.bound.contains(&other)
            {
                let (positive, negative) =
                    (self.at_least(positive, Strength::Sum), self.at_least(negative, Strength::Product));
                return (format!("{positive} - {negative}"), Strength::Sum);
            }
        }
        let (x, y) = (self.at_least(x, Strength::Sum), self.at_least(y, Strength::Product));
        (format!("{x} + {y}"), Strength::Sum)
    }
}
