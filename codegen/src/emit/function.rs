//! Straight-line pieces of a function, and roots. Loops over the nodes: `node_loop`.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::count::KernelCounts;
use super::expression::Writer;
use super::names::Names;
use crate::graph::{ExprId, Iteration, Limits, Op, RootFigure, RootId};
use crate::schedule::{Program, Statement};

/// Writes the function of a program.
pub(super) struct FunctionWriter<'a, S> {
    pub program: &'a Program<S>,
    pub writer: Writer<'a>,
    pub counts: KernelCounts,
    pub statements: usize,
}

impl<'a, S> FunctionWriter<'a, S> {
    pub fn new(program: &'a Program<S>) -> Self {
        let mut names = Names::default();
        names.reserve(&[
            "inputs",
            "scratch",
            "gradients",
            "second",
            "count",
            "freedoms",
            "packed",
            "index",
            "node",
            "nodes",
            "master",
            "vector",
            "at",
            "forms",
            "form",
            "presence",
            "type",
            "in",
            "if",
            "fn",
            "do",
            "None",
            "Some",
            "Ok",
            "Err",
        ]);
        for &root in program.roots.keys() {
            let name = &program.kernel.graph.root(root).name;
            names.reserve(
                &[format!("{name}_iteration"), format!("{name}_solution")].each_ref().map(String::as_str),
            );
        }
        let writer = Writer::new(&program.kernel.graph, &program.layout, names);
        let counts = KernelCounts::default();
        Self { program, writer, counts, statements: 0 }
    }

    pub fn statements(&mut self, statements: &[Statement]) -> TokenStream {
        let all: Vec<TokenStream> = statements.iter().map(|&statement| self.statement(statement)).collect();
        quote!(#(#all)*)
    }

    fn statement(&mut self, statement: Statement) -> TokenStream {
        self.statements += 1;
        match statement {
            Statement::Let(expr) => {
                let definition = self.writer.definition(expr);
                let name = self.writer.ident(expr);
                quote!(let #name = #definition;)
            }
            Statement::Solve(root) => self.root(root),
        }
    }

    /// The iteration for a root.
    fn root(&mut self, root: RootId) -> TokenStream {
        let program = self.program;
        let graph = &program.kernel.graph;
        let data = graph.root(root);
        let before = self.writer.take_counts();
        let unknowns: Vec<Ident> =
            data.unknowns.iter().map(|&u| format_ident!("{}", graph.symbol_data(u).name)).collect();
        let body = self.statements(&program.roots[&root]);
        let residuals: Vec<TokenStream> = data.residuals.iter().map(|&r| self.writer.used(r)).collect();
        let jacobian: Vec<Vec<TokenStream>> =
            data.jacobian.iter().map(|row| row.iter().map(|&x| self.writer.used(x)).collect()).collect();
        self.counts.iteration += self.writer.take_counts();
        self.counts.element += before;

        let (solution, solver) =
            (format_ident!("{}_solution", data.name), format_ident!("{}", solver_name(data.iteration)));
        let (start, jacobian) = match data.iteration {
            Iteration::Newton | Iteration::Descent => {
                (quote!(#solver::<E>::start()), quote!(#(#(#jacobian),*),*))
            }
            Iteration::Within(Limits { longest_step, evaluations }) => {
                let size = Literal::usize_unsuffixed(unknowns.len());
                let evaluations = Literal::u32_unsuffixed(evaluations);
                let longest =
                    if longest_step.is_finite() { quote!(#longest_step) } else { quote!(f64::INFINITY) };
                (quote!(#solver::<E, #size>::within(#longest, #evaluations)), quote!(#([#(#jacobian),*]),*))
            }
        };
        let figures = graph_roots(graph, root).into_iter().filter(|(x, _)| program.layout.bound.contains(x));
        let lets: Vec<TokenStream> = figures
            .map(|(expr, field)| {
                let name = self.writer.ident(expr);
                quote!(let #name = #solution.#field;)
            })
            .collect();
        self.statements += lets.len();
        let iteration = format_ident!("{}_iteration", data.name);
        quote! {
            let mut #iteration = #start;
            let #solution = loop {
                let [#(#unknowns),*] = #iteration.point();
                #body
                if let Some(solution) = #iteration.advance([#(#residuals),*], [#jacobian]) {
                    break solution;
                }
            };
            #(#lets)*
        }
    }
}

/// What solves the equations of a root: a type of the support module.
pub(super) const fn solver_name(iteration: Iteration) -> &'static str {
    match iteration {
        Iteration::Newton => "TwoEquations",
        Iteration::Within(_) => "Equations",
        Iteration::Descent => "TwoVariables",
    }
}

/// The figures of a root that the graph holds, with the field of the solution each is read from.
fn graph_roots(graph: &crate::graph::Graph, root: RootId) -> Vec<(ExprId, TokenStream)> {
    (0..graph.len())
        .map(|k| ExprId(k as u32))
        .filter_map(|expr| match graph.op(expr) {
            Op::RootValue(r, component) if r == root => {
                let component = proc_macro2::Literal::u32_unsuffixed(component);
                Some((expr, quote!(unknowns[#component])))
            }
            Op::RootFigure(r, RootFigure::Residual) if r == root => Some((expr, quote!(residual))),
            Op::RootFigure(r, RootFigure::Iterations) if r == root => Some((expr, quote!(iterations))),
            _ => None,
        })
        .collect()
}
