//! The module of an element of fixed size: its types, and what runs its kernels.

use proc_macro2::{Ident, TokenStream};
use quote::quote;

use super::derivatives::Derivative;
use super::module::{best_isa, call_by_mode, field, gathered, hessian_at, input_fields, stored, value_types};
use crate::kernel::{Mode, Signature};

/// The structs `Inputs`, `Values` and `Results`.
pub(super) fn types(signature: &Signature, last: Mode) -> TokenStream {
    let inputs = input_fields(&signature.inputs, "");
    let gathered = signature.inputs.iter().map(gathered);
    let (variables, values, results) =
        (signature.variables(), value_types(signature), results(signature, last));
    quote! {
        /// Number of variables: entries of a gradient.
        pub const VARIABLES: usize = #variables;

        /// What a kernel reads.
        #[derive(Clone, Copy, Debug)]
        pub struct Inputs<E> { #(#inputs),* }

        impl<E: Lane> Inputs<E> {
            /// Elements side by side, one in each lane.
            #[inline(always)]
            #[must_use]
            pub fn gather<'a>(of: impl Fn(usize) -> &'a Inputs<f64>) -> Self {
                Self { #(#gathered),* }
            }
        }

        #values
        #results
    }
}

fn results(signature: &Signature, last: Mode) -> TokenStream {
    let all = Derivative::all(signature, last);
    let length = |derivative: &Derivative| derivative.length(signature.variables());
    let derivatives = all.iter().map(|derivative| {
        let doc = format!("{}.", derivative.meaning(signature));
        field(&derivative.name, &doc, "", &[length(derivative)], &quote!(f64))
    });
    let zeros = all.iter().map(|derivative| {
        let (name, length) = (derivative.ident(), length(derivative));
        quote!(#name: [0.0; #length])
    });
    let at = hessian_at(last);
    quote! {
        /// Values of one element and their derivatives; those that were not asked for stay as they were.
        #[derive(Clone, Copy, Debug)]
        pub struct Results {
            /// Values.
            pub values: Values<f64>,
            #(#derivatives),*
        }

        impl Results {
            /// Zeros.
            pub const ZERO: Self = Self { values: Values::ZERO, #(#zeros),* };
            #at
        }
    }
}

/// `evaluate`, `batch` and what they need.
pub(super) fn runners(signature: &Signature, last: Mode) -> TokenStream {
    let target = |name: &Ident| quote!(&mut results.#name);
    let single = call_by_mode(signature, last, |_| quote!(inputs), target);
    let (best_isa, lanes, evaluate_to) = (best_isa(), lanes(signature, last), evaluate_to(signature, last));
    quote! {
        /// Evaluates one element.
        #[must_use]
        pub fn evaluate(mode: Mode, inputs: &Inputs<f64>) -> Results {
            let mut results = Results::ZERO;
            evaluate_into(mode, inputs, &mut results);
            results
        }

        #evaluate_to

        fn evaluate_into(mode: Mode, inputs: &Inputs<f64>, results: &mut Results) {
            results.values = #single;
        }

        #best_isa

        /// Evaluates many elements, as many side by side as the instructions have lanes: [`best_isa`] unless there is a reason for
        /// others. What an element gets does not depend on its neighbours.
        ///
        /// # Panics
        /// If there are not as many results as inputs.
        pub fn batch(isa: Isa, mode: Mode, inputs: &[Inputs<f64>], results: &mut [Results]) {
            assert_eq!(inputs.len(), results.len(), "as many results as inputs");
            let elements = Elements { mode, inputs, results };
            // What a constant rules out is not compiled.
            let left = if OPTIMISED { isa.run_vectors(elements) } else { Err(elements) };
            if let Err(Elements { mode, inputs, results }) = left {
                for (inputs, results) in inputs.iter().zip(results) {
                    evaluate_into(mode, inputs, results);
                }
            }
        }

        #lanes
    }
}

/// `evaluate_to`, of an element that has derivatives.
fn evaluate_to(signature: &Signature, last: Mode) -> Option<TokenStream> {
    let all = Derivative::all(signature, last);
    let names: Vec<_> = all.iter().map(Derivative::ident).collect();
    let lengths = all.iter().map(|of| format!("`{}` {}", of.name, of.length(signature.variables())));
    let lengths = format!(" Entries of the slices: {}.", lengths.collect::<Vec<_>>().join(", "));
    let target = |name: &Ident| quote!(first_entries(#name));
    let values = call_by_mode(signature, last, |_| quote!(inputs), target);
    (!all.is_empty()).then(|| {
        quote! {
            /// Evaluates one element, its derivatives to slices. Those that the mode does not ask for are not touched, and may be empty.
            ///
            #[doc = #lengths]
            ///
            /// # Panics
            /// If a slice is shorter than the mode needs.
            #[must_use]
            pub fn evaluate_to(
                mode: Mode,
                inputs: &Inputs<f64>,
                #(#names: &mut [f64]),*
            ) -> Values<f64> {
                #values
            }
        }
    })
}

/// Elements in lanes.
fn lanes(signature: &Signature, last: Mode) -> TokenStream {
    let declared = Derivative::all(signature, last).into_iter().map(|derivative| {
        let (name, length) = (derivative.ident(), derivative.length(signature.variables()));
        quote!(let mut #name = [T::ZERO; #length];)
    });
    let values = call_by_mode(signature, last, |_| quote!(&lanes), |name| quote!(&mut #name));
    let stored = stored(signature, last, &quote!(results), &quote!(result));
    quote! {
        struct Elements<'a> {
            mode: Mode,
            inputs: &'a [Inputs<f64>],
            results: &'a mut [Results],
        }

        impl WithLanes for Elements<'_> {
            type Output = ();

            #[inline(always)]
            fn run<T: Vector>(self) {
                let Self { mode, inputs, results } = self;
                #(#declared)*
                for (inputs, results) in inputs.chunks(T::WIDTH).zip(results.chunks_mut(T::WIDTH)) {
                    let last = inputs.len() - 1;
                    let lanes = Inputs::<T>::gather(|lane| &inputs[lane.min(last)]);
                    let values = #values;
                    for (lane, result) in results.iter_mut().enumerate() {
                        result.values = values.lane(lane);
                    }
                    #stored
                }
            }
        }
    }
}
