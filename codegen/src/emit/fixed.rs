//! Kernels of fixed size: straight-line functions that read a struct, return a struct and write derivatives to arrays.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::count::OpCounts;
use super::function::FunctionWriter;
use crate::graph::{ExprId, Op};
use crate::model::{Input, Value};
use crate::schedule::Program;

/// An argument that a derivative is written to, and its number of entries.
pub(super) type Argument = (String, usize);

/// What surrounds a function's body.
pub(super) struct Head<'a> {
    pub name: Ident,
    /// Type of the struct that is read.
    pub inputs: TokenStream,
    /// Its fields.
    pub fields: &'a [Input],
    /// Name of the struct that is returned.
    pub values: Ident,
    /// Values that are no fields of it.
    pub arguments: &'a [Argument],
    /// What solves the equations of roots.
    pub solver: &'static str,
}

/// A function's pieces.
pub(super) struct Fixed {
    body: TokenStream,
    /// Operations, with one evaluation of the equations of roots.
    pub counts: OpCounts,
    /// Operations of one such evaluation.
    pub iteration: OpCounts,
    pub statements: usize,
}

impl Fixed {
    /// Writes the body. `shape` puts the components of a field together.
    pub fn new<S>(
        program: &Program<S>,
        head: &Head<'_>,
        shape: impl Fn(&Value, &[TokenStream]) -> TokenStream,
    ) -> Self {
        let mut function = FunctionWriter::new(program);
        let arguments: Vec<&str> = head.arguments.iter().map(|(name, _)| name.as_str()).collect();
        function.writer.names.reserve(&arguments);
        // Constants of a module are no patterns.
        function.writer.names.reserve(&["VARIABLES", "OPTIMISED"]);
        function.solver = head.solver;

        let body: Vec<TokenStream> =
            program.phases.iter().map(|phase| function.statements(&phase.statements)).collect();
        let (derivatives, values): (Vec<&Value>, Vec<&Value>) =
            program.kernel.values.iter().partition(|value| arguments.contains(&value.name.as_ref()));
        let mut outputs = Vec::new();
        for value in derivatives {
            let name = format_ident!("{}", value.name);
            for (k, &x) in value.components.iter().enumerate() {
                let entry = function.writer.used(x);
                outputs.push(quote!(#name[#k] = #entry;));
            }
        }
        let mut fields = Vec::new();
        for value in values {
            let field = format_ident!("{}", value.name);
            let components: Vec<TokenStream> =
                value.components.iter().map(|&x| function.writer.used(x)).collect();
            let whole = shape(value, &components);
            fields.push(quote!(#field: #whole));
        }
        function.counts.element += function.writer.take_counts();
        let reads = reads(&mut function, head.fields);
        let values = &head.values;
        Self {
            counts: function.counts.total(0),
            iteration: function.counts.iteration,
            statements: function.statements + outputs.len() + reads.len() + 1,
            body: quote! {
                #(#reads)*
                #(#body)*
                #(#outputs)*
                #values { #(#fields),* }
            },
        }
    }

    /// The function.
    pub fn tokens(&self, head: &Head<'_>, documentation: &[String]) -> TokenStream {
        let Head { name, inputs, values, .. } = head;
        let arguments = head.arguments.iter().map(|(name, length)| {
            let name = format_ident!("{name}");
            quote!(#name: &mut [E; #length],)
        });
        let body = &self.body;
        quote! {
            #(#[doc = #documentation])*
            #[inline(always)]
            pub fn #name<E: Lane>(
                inputs: &#inputs,
                #(#arguments)*
            ) -> #values<E> {
                #body
            }
        }
    }
}

/// `let`s for the inputs that are used.
fn reads<S>(function: &mut FunctionWriter<'_, S>, fields: &[Input]) -> Vec<TokenStream> {
    let graph = &function.program.kernel.graph;
    let symbols: Vec<(&str, ExprId)> = (0..graph.len())
        .map(|k| ExprId(k as u32))
        .filter_map(|expr| match graph.op(expr) {
            Op::Symbol(symbol) => Some((graph.symbol_data(symbol).name.as_str(), expr)),
            _ => None,
        })
        .filter(|(_, expr)| function.program.layout.bound.contains(expr))
        .collect();
    let mut all = Vec::new();
    for input in fields {
        let known = |name: &String| symbols.iter().find(|(other, _)| other == name).map(|(_, expr)| *expr);
        if input.symbols.iter().all(|name| known(name).is_none()) {
            continue;
        }
        let mut entry = |name: &String| {
            let ident = known(name).map_or_else(|| format_ident!("_"), |expr| function.writer.ident(expr));
            quote!(#ident)
        };
        let entries: Vec<TokenStream> = input.symbols.iter().map(&mut entry).collect();
        let (pattern, field) = (nested(&input.dimensions, &entries), format_ident!("{}", input.name));
        all.push(quote!(let #pattern = inputs.#field;));
    }
    all
}

/// `[[a, b], [c, d]]` of entries in order, the last dimension fastest.
pub(super) fn nested(dimensions: &[usize], entries: &[TokenStream]) -> TokenStream {
    let Some((&count, inner)) = dimensions.split_first() else { return quote!(#(#entries)*) };
    let parts = entries.chunks((entries.len() / count).max(1)).map(|part| nested(inner, part));
    quote!([#(#parts),*])
}

/// `[[E; 3]; 4]`
pub(super) fn array(dimensions: &[usize], of: &TokenStream) -> TokenStream {
    dimensions.iter().rev().fold(of.clone(), |inner, count| quote!([#inner; #count]))
}
