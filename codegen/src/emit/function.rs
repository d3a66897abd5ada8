//! Straight-line pieces of a function, and roots. Loops over the nodes: `node_loop`.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::count::KernelCounts;
use super::expression::Writer;
use super::fixed::entry;
use super::names::Names;
use crate::graph::{ExprId, Iteration, Limits, RootFigure, RootId};
use crate::schedule::{Program, Solved, Statement};

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
        let names = data.unknowns.iter().map(|&unknown| &graph.symbol_data(unknown).name);
        let unknowns: Vec<TokenStream> = names.map(|name| entry(self, name)).collect();
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
        let read = |(expr, solved): (ExprId, Solved)| {
            let name = self.writer.ident(expr);
            let field = match solved {
                Solved::Unknown(component) => {
                    let component = Literal::u32_unsuffixed(component);
                    quote!(unknowns[#component])
                }
                Solved::Figure(RootFigure::Residual) => quote!(residual),
                Solved::Figure(RootFigure::Iterations) => quote!(iterations),
            };
            quote!(let #name = #solution.#field;)
        };
        let lets: Vec<TokenStream> = program.solved(root).into_iter().map(read).collect();
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
