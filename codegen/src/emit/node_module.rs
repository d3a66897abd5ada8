//! The module of an element with nodes of a number that is open: its types, and what runs its kernels.

use proc_macro2::{Ident, TokenStream};
use quote::quote;

use super::derivatives::Derivative;
use super::module::{best_isa, call_by_mode, gathered, hessian_at, input_fields, stored, value_types};
use crate::kernel::{Mode, Signature};

/// The structs, and what is known of sizes; `scratch` by mode.
pub(super) fn types(signature: &Signature, last: Mode, scratch: &[usize]) -> TokenStream {
    let pieces =
        [sizes(signature, scratch), inputs(signature), value_types(signature), results(signature, last)];
    quote!(#(#pieces)*)
}

fn sizes(signature: &Signature, scratch: &[usize]) -> TokenStream {
    let (of_element, of_node) = (signature.variables(), signature.node_variables());
    let modes = scratch.len();
    quote! {
        /// Number of variables of the element itself. Those of the nodes follow, node by node.
        pub const VARIABLES: usize = #of_element;

        /// Number of variables of a node.
        pub const NODE_VARIABLES: usize = #of_node;

        /// Numbers of scratch that a kernel needs for each node, by mode.
        pub const SCRATCH: [usize; #modes] = [#(#scratch),*];

        /// Number of variables of an element with so many nodes: entries of a gradient.
        #[inline(always)]
        #[must_use]
        pub const fn variables(count: usize) -> usize {
            VARIABLES + NODE_VARIABLES * count
        }
    }
}

fn inputs(signature: &Signature) -> TokenStream {
    let (inputs, nodes) =
        (input_fields(&signature.inputs, ""), input_fields(&signature.nodes, " of the node"));
    let gathered_inputs = signature.inputs.iter().map(gathered);
    let gathered_node = signature.nodes.iter().map(gathered);
    quote! {
        /// What a kernel reads.
        #[derive(Clone, Copy, Debug)]
        pub struct Inputs<'a, E> {
            #(#inputs,)*
            /// The nodes.
            pub nodes: &'a [Node<E>],
        }

        /// What a kernel reads of a node.
        #[derive(Clone, Copy, Debug)]
        pub struct Node<E> { #(#nodes),* }

        impl<'n, E: Lane> Inputs<'n, E> {
            /// Elements side by side, one in each lane; `nodes` are theirs.
            #[inline(always)]
            #[must_use]
            pub fn gather<'a>(of: impl Fn(usize) -> &'a Inputs<'a, f64>, nodes: &'n [Node<E>]) -> Self {
                Self { #(#gathered_inputs,)* nodes }
            }
        }

        impl<E: Lane> Node<E> {
            /// Nodes side by side, one in each lane.
            #[inline(always)]
            #[must_use]
            pub fn gather<'a>(of: impl Fn(usize) -> &'a Node<f64>) -> Self {
                Self { #(#gathered_node),* }
            }
        }
    }
}

fn results(signature: &Signature, last: Mode) -> TokenStream {
    let all = Derivative::all(signature, last);
    let derivatives = all.iter().map(|derivative| {
        let (doc, name) = (format!(" {}.", derivative.meaning(signature)), derivative.ident());
        quote! {
            #[doc = #doc]
            pub #name: Vec<f64>
        }
    });
    let names: Vec<Ident> = all.iter().map(Derivative::ident).collect();
    let reserved = all.iter().map(|derivative| {
        let (least, name, length) =
            (derivative.least_mode(), derivative.ident(), derivative.length_by_count());
        quote! {
            if mode >= #least {
                self.#name.resize(#length, 0.0);
            }
        }
    });
    let at = hessian_at(last);
    quote! {
        /// Values of one element and their derivatives, which have room for as many nodes as it has; those that were not asked for stay
        /// as they were.
        #[derive(Clone, Debug)]
        pub struct Results {
            /// Values.
            pub values: Values<f64>,
            #(#derivatives),*
        }

        impl Default for Results {
            fn default() -> Self {
                Self { values: Values::ZERO, #(#names: Vec::new()),* }
            }
        }

        impl Results {
            /// Room for so many nodes.
            fn reserve(&mut self, mode: Mode, count: usize) {
                #(#reserved)*
            }

            #at
        }
    }
}

/// What a kernel is called with besides derivatives.
fn inputs_and_scratch(inputs: &TokenStream, mode: Mode) -> TokenStream {
    let index = mode as usize;
    quote!(#inputs, &mut scratch[..SCRATCH[#index] * count])
}

/// `evaluate`, `evaluate_into`, `batch` and what they need.
pub(super) fn runners(signature: &Signature, last: Mode) -> TokenStream {
    let pieces = [single(signature, last), batch(), lanes(signature, last)];
    quote!(#(#pieces)*)
}

fn single(signature: &Signature, last: Mode) -> TokenStream {
    let target = |name: &Ident| quote!(&mut results.#name);
    let values = call_by_mode(signature, last, |mode| inputs_and_scratch(&quote!(inputs), mode), target);
    let most = last as usize;
    quote! {
        /// Evaluates one element.
        #[must_use]
        pub fn evaluate(mode: Mode, inputs: &Inputs<'_, f64>) -> Results {
            let mut results = Results::default();
            evaluate_into(mode, inputs, &mut Vec::new(), &mut results);
            results
        }

        /// The same with memory that is used again: nothing is allocated once scratch and results were as large before.
        pub fn evaluate_into(
            mode: Mode,
            inputs: &Inputs<'_, f64>,
            scratch: &mut Vec<f64>,
            results: &mut Results,
        ) {
            let count = inputs.nodes.len();
            results.reserve(mode, count);
            scratch.resize(scratch.len().max(SCRATCH[#most] * count), 0.0);
            results.values = #values;
        }
    }
}

fn batch() -> TokenStream {
    let best_isa = best_isa();
    quote! {
        #best_isa

        /// Evaluates many elements, as many of the same number of nodes side by side as the instructions have lanes: [`best_isa`] unless
        /// there is a reason for others. What an element gets does not depend on its neighbours.
        ///
        /// # Panics
        /// If there are not as many results as inputs.
        pub fn batch(isa: Isa, mode: Mode, inputs: &[Inputs<'_, f64>], results: &mut [Results]) {
            assert_eq!(inputs.len(), results.len(), "as many results as inputs");
            let mut scratch = Vec::new();
            let mut elements: Vec<Element<'_>> = inputs.iter().zip(results).collect();
            elements.sort_by_key(|(inputs, _)| inputs.nodes.len());
            for group in elements.chunk_by_mut(|(x, _), (y, _)| x.nodes.len() == y.nodes.len()) {
                let elements = Elements { mode, elements: group };
                // What a constant rules out is not compiled.
                let left = if OPTIMISED { isa.run_vectors(elements) } else { Err(elements) };
                if let Err(Elements { mode, elements }) = left {
                    for (inputs, results) in elements {
                        evaluate_into(mode, inputs, &mut scratch, results);
                    }
                }
            }
        }
    }
}

/// Elements in lanes.
fn lanes(signature: &Signature, last: Mode) -> TokenStream {
    let all = Derivative::all(signature, last);
    let names: Vec<Ident> = all.iter().map(Derivative::ident).collect();
    let lengths = all.iter().map(Derivative::length_by_count);
    let target = |name: &Ident| quote!(&mut #name);
    let values = call_by_mode(signature, last, |mode| inputs_and_scratch(&quote!(&gathered), mode), target);
    let stored = stored(signature, last, &quote!(lanes), &quote!((_, result)));
    let most = last as usize;
    quote! {
        type Element<'a> = (&'a Inputs<'a, f64>, &'a mut Results);

        /// Elements of the same number of nodes.
        struct Elements<'a, 'e> {
            mode: Mode,
            elements: &'a mut [Element<'e>],
        }

        impl WithLanes for Elements<'_, '_> {
            type Output = ();

            #[inline(always)]
            fn run<T: Vector>(self) {
                let Self { mode, elements } = self;
                let count = elements[0].0.nodes.len();
                let mut nodes: Vec<Node<T>> = Vec::with_capacity(count);
                let mut scratch = vec![T::ZERO; SCRATCH[#most] * count];
                #(let mut #names: Vec<T> = Vec::new();)*
                #(#names.resize(#lengths, T::ZERO);)*
                for lanes in elements.chunks_mut(T::WIDTH) {
                    let last = lanes.len() - 1;
                    nodes.clear();
                    for node in 0..count {
                        nodes.push(Node::gather(|lane| &lanes[lane.min(last)].0.nodes[node]));
                    }
                    let gathered = Inputs::gather(|lane| lanes[lane.min(last)].0, &nodes);
                    let values = #values;
                    for (lane, (_, result)) in lanes.iter_mut().enumerate() {
                        result.values = values.lane(lane);
                        result.reserve(mode, count);
                    }
                    #stored
                }
            }
        }
    }
}
