//! Kernels with elements or nodes side by side in vectors, a `Shape` of the support module: what surrounds their segments and loops.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::count::{KernelCounts, OpCounts};
use super::fixed::reads_and_count;
use super::function::FunctionWriter;
use super::node_loop::{NodeArray, Outputs};
use crate::graph::ExprId;
use crate::kernel::Input;
use crate::schedule::{FormRows, NodeTarget, Program};

/// What surrounds a function.
pub(crate) struct ShapeHead<'a> {
    /// Its name.
    pub name: Ident,
    /// The fields of its inputs.
    pub fields: &'a [Input],
    /// Arrays of nodes with the symbols of an entry. The first has as many entries as there are vectors of nodes.
    pub arrays: &'a [(&'static str, &'a [&'static str])],
    /// The struct that is returned.
    pub values: Ident,
    /// Fields of it that the kernel has no value for.
    pub constants: &'a [(&'static str, TokenStream)],
    /// Fields that are longer than the kernel's value, with their lengths; zeros follow.
    pub lengths: &'a [(&'static str, usize)],
    /// The value that what the Hessians' products write is added to, and that is not finite where an entry is not.
    pub checksum: &'static str,
    /// Where the kernel's combinations are written to.
    pub combined: Combined<'a>,
}

/// An array of a kernel's combinations.
pub(crate) struct Combined<'a> {
    /// Its name.
    pub name: &'static str,
    /// The kind of second derivatives that it belongs to.
    pub kind: &'static str,
    /// Inputs at its end.
    pub inputs: &'a [&'static str],
}

/// A kernel's source.
#[derive(Clone, Debug)]
pub struct EmittedKernel<S> {
    /// What it is.
    pub spec: S,
    /// The function, and the module with the places of node values.
    pub tokens: TokenStream,
    /// Operation counts.
    pub counts: KernelCounts,
    /// Statements of the function.
    pub statements: usize,
    /// Rows of the first Hessian's form, if there is one.
    pub rows: Option<usize>,
}

/// Writes the function of a kernel.
pub(crate) fn emit_shape<S: Clone>(
    program: &Program<S>,
    head: &ShapeHead<'_>,
    documentation: impl FnOnce(&KernelCounts) -> Vec<String>,
) -> EmittedKernel<S> {
    FunctionWriter::new(program).write(head, documentation)
}

/// Name of the module with the places of a function's values per node.
pub(crate) fn kept_name(function: &Ident) -> Ident {
    format_ident!("{function}_kept")
}

/// An array of nodes as the loops read it.
fn array<'a>(&(name, symbols): &(&'static str, &'a [&'static str])) -> NodeArray<'a> {
    let pattern = move |used: &dyn Fn(&str) -> Option<Ident>| {
        let names = symbols.iter().map(|name| used(name).unwrap_or_else(|| format_ident!("_")));
        quote!([#(#names),*])
    };
    NodeArray { name, symbols: symbols.to_vec(), entry: None, pattern: Box::new(pattern) }
}

impl<S: Clone> FunctionWriter<'_, S> {
    fn write(
        mut self,
        head: &ShapeHead<'_>,
        documentation: impl FnOnce(&KernelCounts) -> Vec<String>,
    ) -> EmittedKernel<S> {
        let spec = &self.program.kernel.spec;
        let inputs = self.inputs(head);
        let arrays: Vec<NodeArray<'_>> = head.arrays.iter().map(array).collect();
        let phases: Vec<TokenStream> = (0..self.program.phases.len())
            .map(|k| self.phase(k, &arrays, |function, outputs| function.node_outputs(outputs)))
            .collect();
        let outputs = self.element_outputs();
        let combinations = self.combinations(&head.combined);
        let updates = self.updates();
        let values = self.values(head);
        let kept = self.program.kept();
        let kept_module = self.kept_module(&head.name, &kept);

        let ShapeHead { name: function, values: returned, .. } = head;
        let nodes = self.split_scratch(head, &kept);
        let documentation = documentation(&self.counts);
        let kernel = &self.program.kernel;
        let gradients = (!kernel.gradients.is_empty()).then(|| quote!(gradients: &mut [S::Output],));
        let second = (!kernel.hessians.is_empty()).then(|| quote!(mut second: Second<'_, S::Output>,));
        let forms = self.forms();
        let many_gradients = self.program.kernel.gradients.len() > 1;
        let freedoms = many_gradients.then(|| quote!(let freedoms = 3 * (count + 1);));
        let tokens = quote! {
            #kept_module

            #(#[doc = #documentation])*
            #[inline(always)]
            pub fn #function<E: Lane, T: Lane, S: Shape<Element = E, Node = T>>(
                inputs: &Inputs<'_, E, T>,
                scratch: &mut [T],
                #gradients
                #second
            ) -> #returned<E> {
                #nodes
                let count = inputs.count;
                #freedoms
                #forms
                #inputs
                #(#phases)*
                #outputs
                #combinations
                #updates
                #values
            }
        };
        let rows = self.program.forms.first().map(|form| form.rows.len());
        EmittedKernel { spec: spec.clone(), tokens, counts: self.counts, statements: self.statements, rows }
    }

    /// Scratch as what is kept of each node, and the forms'.
    fn split_scratch(&self, head: &ShapeHead<'_>, kept: &[ExprId]) -> TokenStream {
        let has_hessians = !self.program.kernel.hessians.is_empty();
        if kept.is_empty() && !has_hessians {
            return quote!(let _ = scratch;);
        }
        let (kept, nodes) = (kept_name(&head.name), format_ident!("{}", head.arrays[0].0));
        // The forms have the scratch of one vector of nodes more, for rows that the multiplication sums.
        let split = has_hessians
            .then(|| quote!(let (scratch, forms) = scratch.split_at_mut(at::PLACES * inputs.#nodes.len());));
        quote! {
            use #kept as at;
            #split
            let nodes = &mut scratch.as_chunks_mut::<{ at::PLACES }>().0[..inputs.#nodes.len()];
        }
    }

    /// `let`s for the inputs of element scope.
    fn inputs(&mut self, head: &ShapeHead<'_>) -> TokenStream {
        let reads = reads_and_count(self, head.fields);
        self.statements += reads.len();
        quote!(#(#reads)*)
    }

    /// Writes the results of a loop, if it has any.
    fn node_outputs(&mut self, outputs: &Outputs) -> Option<TokenStream> {
        if outputs.is_empty() {
            return None;
        }
        let outputs = outputs.iter().map(|(target, values)| {
            let values: Vec<TokenStream> = values.iter().map(|&x| self.writer.used(x)).collect();
            match *target {
                NodeTarget::Gradient { gradient } => {
                    let offset = times_offset(gradient, &quote!(freedoms));
                    quote!(S::write_nodes([#(#values),*], vector, &mut gradients[#offset 3..#offset 3 * count + 3]);)
                }
                NodeTarget::Row { hessian, row } => {
                    let (form, rows) = (form_name(hessian), rows_name(hessian));
                    // Rows b of a pair's second form are those of the first.
                    let is_common = hessian == 1 && row % 2 == 0 && self.program.has_pair();
                    let keep = format_ident!("{}", if is_common { "keep_common_row" } else { "keep_row" });
                    quote!(S::#keep(#form, #rows, #row, vector, [#(#values),*]);)
                }
                NodeTarget::Value { value } => {
                    let (offset, size) = (self.node_value_offset(), quote!(count));
                    let offset = match times_offset(value, &size) {
                        none if none.is_empty() => offset,
                        further => quote!(#further #offset),
                    };
                    quote!(S::write_values(#(#values)*, vector, &mut gradients[#offset..#offset + count]);)
                }
                NodeTarget::Own { hessian } => {
                    let (form, rows) = (form_name(hessian), rows_name(hessian));
                    quote!(S::keep_own(#form, #rows, vector, [#(#values),*]);)
                }
            }
        });
        let outputs: Vec<TokenStream> = outputs.collect();
        Some(quote!(#(#outputs)*))
    }

    /// Places for the Hessians' forms.
    fn forms(&mut self) -> Option<TokenStream> {
        if self.program.forms.is_empty() {
            return None;
        }
        let forms = self.program.forms.iter().enumerate().map(|(hessian, rows)| {
            let (form, name) = (form_name(hessian), rows_name(hessian));
            let (count, point) = (rows.rows.len(), rows.point.is_some().then(|| quote!(: count + 1)));
            quote! {
                let #name = FormRows { rows: #count, count #point };
                let (#form, forms) = forms.split_at_mut(S::form_length(#name));
            }
        });
        let forms: Vec<TokenStream> = forms.collect();
        self.statements += 2 * forms.len() + 2;
        Some(quote! {
            let forms = S::outputs(forms);
            #(#forms)*
            let _ = forms;
        })
    }

    /// Finishes the forms of the Hessians: as products, or as they are.
    fn updates(&mut self) -> TokenStream {
        let program = self.program;
        let is_pair = program.has_pair();
        let updates = program.forms.iter().enumerate().map(|(hessian, rows)| {
            let (form, name) = (form_name(hessian), rows_name(hessian));
            let mut row = |x: &[ExprId; 3]| {
                let entries = x.map(|x| self.writer.used(x));
                quote!([#(#entries),*])
            };
            let (per_node, per_pair) = form_counts(rows);
            self.counts.node += per_node;
            self.counts.pair += per_pair;
            let mut point = TokenStream::new();
            if let Some((c, own)) = &rows.point {
                let c = c.iter().enumerate().map(|(k, c)| {
                    let (place, entries) = (2 * k, row(c));
                    quote!(S::keep_point_rows(#form, #name, #place, [E::ZERO; 3], #entries);)
                });
                let c: Vec<TokenStream> = c.collect();
                let own = own.map(|x| self.writer.used(x));
                point = quote!(#(#c)* S::keep_point_own(#form, #name, [#(#own),*]););
            }
            if is_pair {
                return point;
            }
            let not_finite = not_finite_name(hessian);
            quote!(#point let #not_finite = S::finish_form(#form, #name, &mut second);)
        });
        let updates: Vec<TokenStream> = updates.collect();
        self.counts.element += self.writer.take_counts();
        self.statements += updates.len();
        let pair = is_pair.then(|| {
            let [not_finite, forms, rows] =
                [not_finite_name, form_name, rows_name].map(|name| [0, 1].map(name));
            quote! {
                let [#(#not_finite),*] = S::finish_pair([#(#forms),*], [#(#rows),*], &mut second);
            }
        });
        quote!(#(#updates)* #pair)
    }

    /// What is combined from the first Hessian's rows, if it is asked for. Its operations are not counted.
    fn combinations(&mut self, combined: &Combined<'_>) -> Option<TokenStream> {
        let program = self.program;
        let (statements, combinations) = &program.combinations;
        if combinations.is_empty() {
            return None;
        }
        let body = self.statements(statements);
        let coefficients: Vec<TokenStream> =
            combinations.iter().flatten().map(|&x| self.writer.used(x)).collect();
        let [name, kind] = [combined.name, combined.kind].map(|name| format_ident!("{name}"));
        let inputs: Vec<Ident> = combined.inputs.iter().map(|name| format_ident!("{name}")).collect();
        self.statements += coefficients.len() + inputs.len();
        let _ = self.writer.take_counts();
        Some(quote! {
            if second.kind() == SecondKind::#kind {
                #body
                let #name = [#(#coefficients,)* #(#inputs),*];
                let target = second.last(#name.len());
                for k in 0..#name.len() {
                    target[k] = S::element_output(#name[k]);
                }
            }
        })
    }

    /// The slave's parts of gradients.
    fn element_outputs(&mut self) -> TokenStream {
        let kernel = &self.program.kernel;
        let mut all = Vec::new();
        for (k, (_, gradient)) in kernel.gradients.iter().enumerate() {
            let offset = times_offset(k, &quote!(freedoms));
            for (axis, &x) in gradient.slave.iter().enumerate() {
                let value = self.writer.used(x);
                all.push(quote!(gradients[#offset #axis] = S::element_output(#value);));
            }
            for (axis, &x) in gradient.point.iter().flatten().enumerate() {
                let value = self.writer.used(x);
                all.push(quote!(gradients[#offset freedoms + #axis] = S::element_output(#value);));
            }
        }
        self.counts.element += self.writer.take_counts();
        self.statements += all.len();
        quote!(#(#all)*)
    }

    fn values(&mut self, head: &ShapeHead<'_>) -> TokenStream {
        let kernel = &self.program.kernel;
        let name = &head.values;
        let fields: Vec<TokenStream> = kernel
            .values
            .iter()
            .map(|value| {
                let field = format_ident!("{}", value.name);
                let components: Vec<TokenStream> =
                    value.components.iter().map(|&x| self.writer.used(x)).collect();
                if !value.is_array {
                    // What the Hessians' forms say of the entries they wrote.
                    let forms = if value.name == head.checksum { kernel.hessians.len() } else { 0 };
                    let not_finite = (0..forms).map(not_finite_name);
                    return quote!(#field: #(#components)* #(+ #not_finite)*);
                }
                let length = head.lengths.iter().find(|(name, _)| value.name == *name);
                let missing = length.map_or(0, |(_, length)| length - components.len());
                let zeros = std::iter::repeat_n(quote!(E::ZERO), missing);
                let components = components.into_iter().chain(zeros);
                quote!(#field: [#(#components),*])
            })
            .collect();
        let constants = head.constants.iter().map(|(field, value)| {
            let field = format_ident!("{field}");
            quote!(#field: #value,)
        });
        self.counts.element += self.writer.take_counts();
        quote!(#name { #(#constants)* #(#fields),* })
    }

    /// Where values of nodes begin among the gradients: after them.
    fn node_value_offset(&self) -> TokenStream {
        let kernel = &self.program.kernel;
        let gradients = proc_macro2::Literal::usize_unsuffixed(kernel.gradients.len());
        let points = kernel.gradients.iter().filter(|(_, gradient)| gradient.point.is_some()).count();
        let points = 3 * points;
        quote!(#gradients * freedoms + #points)
    }

    fn kept_module(&mut self, function: &Ident, kept: &[ExprId]) -> TokenStream {
        let name = kept_name(function);
        let places: Vec<Ident> = kept.iter().map(|&x| self.writer.place(x)).collect();
        let indices = 0..kept.len();
        let places_count = kept.len();
        // x, y and z of the rows, and room for a node's own block.
        let forms = self.program.forms.iter().map(|rows| {
            let numbers = 3 * rows.rows.len();
            quote!(+ #numbers + super::FormRows::OWN)
        });
        let doc = format!(" Places of what `{function}` keeps of a node between its loops.");
        quote! {
            #[doc = #doc]
            pub mod #name {
                #(pub(super) const #places: usize = #indices;)*
                pub(super) const PLACES: usize = #places_count;
                /// Number of values, those of the Hessian's form included.
                pub const COUNT: usize = PLACES #(#forms)*;
            }
        }
    }
}

fn form_name(hessian: usize) -> Ident {
    format_ident!("form_{hessian}")
}

fn not_finite_name(hessian: usize) -> Ident {
    format_ident!("form_{hessian}_not_finite")
}

fn rows_name(hessian: usize) -> Ident {
    format_ident!("form_rows_{hessian}")
}

/// Operations of a form's products: per node, with the slave and with itself, and per pair of nodes.
fn form_counts(rows: &FormRows) -> (OpCounts, OpCounts) {
    let products = 9 * rows.rows.len();
    // The diagonal block is symmetric: half the products, twice, and the own block added.
    let fused = products + 3 * rows.rows.len() + 6;
    // The slave's rows and its own block are sums over the nodes.
    let additions = 3 * rows.rows.len() + 6;
    let node = OpCounts { fused, additions, ..OpCounts::default() };
    (node, OpCounts { fused: products, ..OpCounts::default() })
}

/// `k * size +`, or nothing for k = 0.
fn times_offset(k: usize, size: &TokenStream) -> TokenStream {
    match k {
        0 => TokenStream::new(),
        1 => quote!(#size +),
        _ => quote!(#k * #size +),
    }
}
