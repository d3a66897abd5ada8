//! The kernels of an element with nodes of a number that is open: functions with loops over the nodes.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::count::OpCounts;
use super::derivatives::{DIRECTION, Derivative};
use super::element_kernel::{EmittedElementKernel, documentation, function_name};
use super::expression::Lanes;
use super::fixed::{self, nested, reads_and_count, reads_by_place};
use super::function::FunctionWriter;
use super::node_loop::{NodeArray, Outputs};
use crate::kernel::{DirectionSymbols, ElementSpec, Input, NodeResult, Signature, Value};
use crate::schedule::{NodeTarget, Program};

/// Names of what surrounds a kernel.
const RESERVED: &[&str] = &[
    "Node",
    "Inputs",
    "Values",
    "VARIABLES",
    "NODE_VARIABLES",
    "OPTIMISED",
    "SCRATCH",
    "PRODUCT_SCRATCH",
    "packed_row",
    "kept",
    "first",
];

/// Numbers of a kernel's scratch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Scratch {
    /// Values of a node that are kept between loops.
    pub kept: usize,
    /// Those of a node's rows and own block, for the Hessian.
    pub form: usize,
    /// Products of the Hessian.
    pub products: usize,
}

impl Scratch {
    /// Of a scheduled kernel.
    pub fn new(program: &Program<ElementSpec>) -> Self {
        let spec = &program.kernel.spec;
        let of_form =
            |result: &&NodeResult| matches!(result, NodeResult::Row { .. } | NodeResult::Own { .. });
        let rows = spec.node_results.iter().filter_map(|result| match result {
            NodeResult::Row { row, .. } => Some(row + 1),
            _ => None,
        });
        Self {
            kept: program.kept().len(),
            form: spec.node_results.iter().filter(of_form).count(),
            products: rows.max().unwrap_or(0) / 2,
        }
    }

    /// Numbers for each node.
    pub const fn per_node(self) -> usize {
        self.kept + self.form
    }

    /// The statement that splits it.
    fn split(self) -> TokenStream {
        let Self { kept, form, .. } = self;
        match (kept, form) {
            (0, 0) => quote!(let _ = scratch;),
            (0, _) => quote!(let form = scratch;),
            (_, 0) => quote!(let nodes = scratch.as_chunks_mut::<#kept>().0;),
            _ => quote! {
                let (nodes, form) = scratch.split_at_mut(#kept * count);
                let nodes = nodes.as_chunks_mut::<#kept>().0;
            },
        }
    }

    /// Operations of the products: for each node, and for each pair of nodes.
    fn counts(self, variables: usize) -> [OpCounts; 2] {
        let fused = |fused| OpCounts { fused, ..OpCounts::default() };
        let products = 2 * self.products * variables;
        [fused(products * (variables + 1) / 2), fused(products * variables)]
    }
}

/// Writes the function of a kernel.
pub(super) fn emit_node_kernel(program: &Program<ElementSpec>) -> EmittedElementKernel {
    let spec = &program.kernel.spec;
    let ElementSpec { signature, mode, direction, .. } = spec;
    let scratch = Scratch::new(program);
    let mut function = FunctionWriter::new(program);
    // What derivatives are written to.
    let arguments = Derivative::of(spec);
    let names: Vec<&str> = arguments.iter().map(|argument| argument.name.as_str()).collect();
    function.writer.names.reserve(&names);
    function.writer.names.reserve(RESERVED);
    function.writer.lanes = Lanes::Elements;

    let mut arrays = vec![array(signature)];
    if let Some(direction) = direction {
        function.writer.names.reserve(&[DIRECTION]);
        arrays.push(direction_array(direction));
    }
    let phases: Vec<TokenStream> = (0..program.phases.len())
        .map(|k| function.phase(k, &arrays, |function, outputs| node_outputs(function, outputs, scratch)))
        .collect();
    let (outputs, fields) = element_outputs(&mut function, &arguments);
    function.counts.element += function.writer.take_counts();
    let mut reads = reads_and_count(&mut function, &signature.inputs);
    if let Some(direction) = direction {
        let vector = format_ident!("{DIRECTION}");
        reads.extend(reads_by_place(&mut function, &direction.element, |k| quote!(#vector[#k])));
    }
    let [per_node, per_pair] = scratch.counts(signature.node_variables());
    let mut emitted = EmittedElementKernel {
        mode: *mode,
        tokens: TokenStream::new(),
        counts: function.counts.total(0),
        per_node: [function.counts.node + per_node, per_pair],
        scratch: scratch.per_node(),
        iteration: function.counts.iteration,
        statements: function.statements + outputs.len() + reads.len() + 8,
    };
    let documentation = documentation(spec, &emitted);

    let name = format_ident!("{}", function_name(spec));
    let (vector, returns, returned) = match direction {
        Some(_) => {
            let direction = format_ident!("{DIRECTION}");
            (Some(quote!(#direction: &[E],)), None, None)
        }
        None => (None, Some(quote!(-> Values<E>)), Some(quote!(Values { #(#fields),* }))),
    };
    let arguments = arguments.iter().map(Derivative::ident);
    let (split, products) = (scratch.split(), scratch.products);
    let (element, of_node) = (signature.variables(), signature.node_variables());
    let multiply = (scratch.form > 0)
        .then(|| quote!(multiply_node_rows::<E, #of_node>(#element, #products, count, form, hessian);));
    emitted.tokens = quote! {
        #(#[doc = #documentation])*
        #[inline(always)]
        pub fn #name<E: Lane>(
            inputs: &Inputs<'_, E>,
            #vector
            scratch: &mut [E],
            #(#arguments: &mut [E],)*
        ) #returns {
            let count = inputs.nodes.len();
            #split
            #(#reads)*
            #(#phases)*
            #(#outputs)*
            #multiply
            #returned
        }
    };
    emitted
}

/// The nodes of the inputs.
fn array(signature: &Signature) -> NodeArray<'_> {
    let symbols: Vec<&str> =
        signature.nodes.iter().flat_map(|input| &input.symbols).map(String::as_str).collect();
    let pattern = |used: &dyn Fn(&str) -> Option<proc_macro2::Ident>| {
        let is_used = |input: &&Input| input.symbols.iter().any(|symbol| used(symbol).is_some());
        let field = |input: &Input| {
            let entries: Vec<TokenStream> = input
                .symbols
                .iter()
                .map(|symbol| used(symbol).map_or_else(|| quote!(_), |name| quote!(#name)))
                .collect();
            let (name, entries) = (format_ident!("{}", input.name), nested(&input.dimensions, &entries));
            if entries.to_string() == input.name { quote!(#name) } else { quote!(#name: #entries) }
        };
        let fields: Vec<TokenStream> = signature.nodes.iter().filter(is_used).map(field).collect();
        let others = (fields.len() < signature.nodes.len()).then(|| quote!(..));
        quote!(Node { #(#fields,)* #others })
    };
    NodeArray { name: "nodes", symbols, entry: None, pattern: Box::new(pattern) }
}

/// A node's entries of the vector of a product.
fn direction_array(symbols: &DirectionSymbols) -> NodeArray<'_> {
    let (of_element, of_node) = (symbols.element.len(), symbols.node.len());
    let (direction, places) = (format_ident!("{DIRECTION}"), (0..of_node).map(|k| of_element + k));
    let entry = quote!([#(#direction[#places + #of_node * index]),*]);
    let pattern = |used: &dyn Fn(&str) -> Option<proc_macro2::Ident>| {
        let entry = |symbol: &String| used(symbol).map_or_else(|| quote!(_), |name| quote!(#name));
        let entries = symbols.node.iter().map(entry);
        quote!([#(#entries),*])
    };
    let names = symbols.node.iter().map(String::as_str).collect();
    NodeArray { name: DIRECTION, symbols: names, entry: Some(entry), pattern: Box::new(pattern) }
}

/// Results of a loop.
fn node_outputs(
    function: &mut FunctionWriter<'_, ElementSpec>,
    outputs: &Outputs,
    scratch: Scratch,
) -> Option<TokenStream> {
    if outputs.is_empty() {
        return None;
    }
    let spec = &function.program.kernel.spec;
    let (element, of_node) = (spec.signature.variables(), spec.signature.node_variables());
    let (form, products) = (scratch.form, scratch.products);
    let results = outputs.iter().map(|(target, values)| {
        let NodeTarget::Value { value } = *target else { unreachable!("values of nodes only") };
        let x = function.writer.used(values[0]);
        match &spec.node_results[value] {
            NodeResult::First { argument, row, component } => {
                let argument = format_ident!("{argument}");
                let row = (*row > 0).then(|| quote!(#row * (#element + #of_node * count) +));
                quote!(#argument[#row first + #component] = #x;)
            }
            NodeResult::Mixed { component, variable } => {
                quote!(hessian[packed_row(first + #component) + #variable] = #x;)
            }
            NodeResult::Row { row, component } => {
                let place = of_node * row + component;
                quote!(form[#form * index + #place] = #x;)
            }
            NodeResult::Own { place } => {
                let place = 2 * products * of_node + place;
                quote!(form[#form * index + #place] = #x;)
            }
        }
    });
    let results: Vec<TokenStream> = results.collect();
    Some(quote! {
        let first = #element + #of_node * index;
        #(#results)*
    })
}

/// Derivatives by variables of the element, and the fields of the values.
fn element_outputs(
    function: &mut FunctionWriter<'_, ElementSpec>,
    arguments: &[Derivative],
) -> (Vec<TokenStream>, Vec<TokenStream>) {
    let program = function.program;
    let signature = &program.kernel.spec.signature;
    let (element, of_node) = (signature.variables(), signature.node_variables());
    let argument = |value: &Value| arguments.iter().find(|argument| argument.name == value.name);
    let (derivatives, values): (Vec<&Value>, Vec<&Value>) =
        program.kernel.values.iter().partition(|value| argument(value).is_some());
    let mut outputs = Vec::new();
    for (value, argument) in derivatives.into_iter().filter_map(|value| Some((value, argument(value)?))) {
        let name = argument.ident();
        for (k, &x) in value.components.iter().enumerate() {
            let x = function.writer.used(x);
            let place = match argument.later_row(k, element) {
                Some([row, column]) => quote!(#row * (#element + #of_node * count) + #column),
                None => quote!(#k),
            };
            outputs.push(quote!(#name[#place] = #x;));
        }
    }
    let fields = fixed::fields(signature, &values, |x| function.writer.used(x));
    (outputs, fields)
}
