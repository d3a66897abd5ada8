//! The module of an element with nodes of a number that is open: types, kernels by mode, and what runs them.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::element::{field, gathered, meaning, value_types};
use super::node_element::Scratch;
use crate::lower::lower;
use crate::model::{Differentiated, ElementKernels, Mode, Role, Signature};
use crate::schedule::Program;

/// Entries of what derivatives are written to, for `count` nodes.
fn lengths(signature: &Signature, mode: Mode) -> Vec<(String, TokenStream)> {
    let all = quote!(variables(count));
    let mut lengths = Vec::new();
    for value in signature.values.iter().filter(|_| mode > Mode::Value) {
        match value.differentiated {
            Differentiated::Twice => {
                lengths.push(("gradient".to_owned(), all.clone()));
                if mode == Mode::Hessian {
                    lengths.push(("hessian".to_owned(), quote!(packed_row(variables(count)))));
                }
            }
            Differentiated::Once => {
                let rows: usize = value.dimensions.iter().product();
                lengths.push((format!("{}_jacobian", value.name), quote!(#rows * variables(count))));
            }
            Differentiated::Not => {}
        }
    }
    lengths
}

/// Names of what derivatives of a mode are written to.
pub(super) fn arguments(signature: &Signature, mode: Mode) -> Vec<String> {
    lengths(signature, mode).into_iter().map(|(name, _)| name).collect()
}

/// The structs, and what is known of sizes.
pub(super) fn types(element: &ElementKernels, last: Mode) -> TokenStream {
    let signature = &element.signature;
    let lane = quote!(E);
    let inputs = signature.inputs.iter().map(|input| {
        let default = match input.role {
            Role::Variable => "A variable.",
            Role::Parameter => "A parameter: derivatives are not taken by it.",
        };
        field(&input.name, &input.doc, default, &input.dimensions, &lane)
    });
    let nodes = signature.nodes.iter().map(|input| {
        let default = match input.role {
            Role::Variable => "A variable of the node.",
            Role::Parameter => "A parameter of the node: derivatives are not taken by it.",
        };
        field(&input.name, &input.doc, default, &input.dimensions, &lane)
    });
    let gathered_inputs = signature.inputs.iter().map(gathered);
    let gathered_node = signature.nodes.iter().map(gathered);
    let values = value_types(signature);
    let derivatives = lengths(signature, last).into_iter().map(|(name, _)| {
        let doc = format!(" {}.", meaning(signature, &name));
        let name = format_ident!("{name}");
        quote! {
            #[doc = #doc]
            pub #name: Vec<f64>
        }
    });
    let names: Vec<Ident> =
        lengths(signature, last).iter().map(|(name, _)| format_ident!("{name}")).collect();
    let reserved = lengths(signature, last).into_iter().map(|(name, length)| {
        let (least, name) = (least(&name), format_ident!("{name}"));
        quote! {
            if mode >= #least {
                self.#name.resize(#length, 0.0);
            }
        }
    });
    let at = (last == Mode::Hessian).then(|| {
        quote! {
            /// An entry of the Hessian, of either triangle.
            ///
            /// # Panics
            /// If there is no such row or column.
            #[must_use]
            pub fn hessian_at(&self, row: usize, column: usize) -> f64 {
                self.hessian[packed_row(row.max(column)) + row.min(column)]
            }
        }
    });
    let (of_element, of_node) = (signature.variables(), signature.node_variables());
    let scratch: Vec<usize> =
        element.kernels.iter().map(|kernel| Scratch::new(&Program::new(lower(kernel))).per_node()).collect();
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

        #values

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

/// The mode from which on there is a derivative.
fn least(name: &str) -> TokenStream {
    if name == "hessian" { quote!(Mode::Hessian) } else { quote!(Mode::Gradient) }
}

/// `evaluate`, `evaluate_into`, `batch` and what they need.
pub(super) fn runners(signature: &Signature, last: Mode) -> TokenStream {
    let modes = &Mode::ALL[..=last as usize];
    let arms = |inputs: &TokenStream, scratch: &TokenStream, target: &dyn Fn(&Ident) -> TokenStream| {
        let arms = modes.iter().map(|&mode| {
            let (function, index) = (format_ident!("{}", mode.name()), mode as usize);
            let variant = [quote!(Mode::Value), quote!(Mode::Gradient), quote!(Mode::Hessian)];
            // More derivatives than there are: all there are.
            let pattern = if mode == last { quote!(_) } else { variant[index].clone() };
            let targets = arguments(signature, mode).into_iter().map(|name| target(&format_ident!("{name}")));
            quote!(#pattern => self::#function(#inputs, &mut #scratch[..SCRATCH[#index] * count], #(#targets),*),)
        });
        quote!(#(#arms)*)
    };
    let single = arms(&quote!(inputs), &quote!(scratch), &|name| quote!(&mut results.#name));
    let lanes = arms(&quote!(&gathered), &quote!(scratch), &|name| quote!(&mut #name));
    let all = lengths(signature, last);
    let names: Vec<Ident> = all.iter().map(|(name, _)| format_ident!("{name}")).collect();
    let resized = all.iter().map(|(name, length)| {
        let name = format_ident!("{name}");
        quote!(#name.resize(#length, T::ZERO);)
    });
    let stored = all.iter().map(|(name, _)| {
        let (least, name) = (least(name), format_ident!("{name}"));
        quote! {
            if mode >= #least {
                T::store_transposed(&#name, lanes, |(_, result)| &mut result.#name[..]);
            }
        }
    });
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
            results.values = match mode { #single };
        }

        /// The instructions to run batches with: the widest that the machine has, or without optimisation one number at a time.
        #[must_use]
        pub fn best_isa() -> Isa {
            if OPTIMISED { Isa::best() } else { Isa::SCALAR }
        }

        /// Evaluates many elements, as many of the same number of nodes side by side as the instructions have lanes: [`best_isa`] unless
        /// there is a reason for others. What an element gets does not depend on its neighbours.
        ///
        /// # Panics
        /// If there are not as many results as inputs.
        pub fn batch(isa: Isa, mode: Mode, inputs: &[Inputs<'_, f64>], results: &mut [Results]) {
            assert_eq!(inputs.len(), results.len(), "as many results as inputs");
            let mut elements: Vec<Element<'_>> = inputs.iter().zip(results).collect();
            elements.sort_by_key(|(inputs, _)| inputs.nodes.len());
            for group in elements.chunk_by_mut(|(x, _), (y, _)| x.nodes.len() == y.nodes.len()) {
                let elements = Elements { mode, elements: group };
                // What a constant rules out is not compiled.
                if OPTIMISED {
                    isa.run(elements);
                } else {
                    elements.run::<f64>();
                }
            }
        }

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
                #(#resized)*
                for lanes in elements.chunks_mut(T::WIDTH) {
                    let last = lanes.len() - 1;
                    nodes.clear();
                    for node in 0..count {
                        nodes.push(Node::gather(|lane| &lanes[lane.min(last)].0.nodes[node]));
                    }
                    let gathered = Inputs::gather(|lane| lanes[lane.min(last)].0, &nodes);
                    let values = match mode { #lanes };
                    for (lane, (_, result)) in lanes.iter_mut().enumerate() {
                        result.values = values.lane(lane);
                        result.reserve(mode, count);
                    }
                    #(#stored)*
                }
            }
        }
    }
}
