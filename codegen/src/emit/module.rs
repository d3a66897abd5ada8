//! What the modules of all elements have: fields and their lanes, values, calls by mode, and what results are stored with.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::derivatives::Derivative;
use super::fixed::{array, nested};
use crate::kernel::{Input, Mode, Role, Signature};

/// A struct's field of numbers `of`, documented.
pub(super) fn field(
    name: &str,
    doc: &str,
    default: &str,
    dimensions: &[usize],
    of: &TokenStream,
) -> TokenStream {
    let (ident, of) = (format_ident!("{name}"), array(dimensions, of));
    let doc = format!(" {}", if doc.is_empty() { default } else { doc });
    quote! {
        #[doc = #doc]
        pub #ident: #of
    }
}

/// Fields of what kernels read; `of`: whose variables and parameters, ` of the node`.
pub(super) fn input_fields(inputs: &[Input], of: &str) -> Vec<TokenStream> {
    let field = |input: &Input| {
        let default = match input.role {
            Role::Variable => format!("A variable{of}."),
            Role::Parameter => format!("A parameter{of}: derivatives are not taken by it."),
        };
        field(&input.name, &input.doc, &default, &input.dimensions, &quote!(E))
    };
    inputs.iter().map(field).collect()
}

/// The struct `Values`.
pub(super) fn value_types(signature: &Signature) -> TokenStream {
    let lane = quote!(E);
    let values = signature.values.iter().map(|v| field(&v.name, &v.doc, "A value.", &v.dimensions, &lane));
    let value_names: Vec<_> = signature.values.iter().map(|value| format_ident!("{}", value.name)).collect();
    let zeros = signature.values.iter().map(|value| array(&value.dimensions, &quote!(E::ZERO)));
    let of_lane = signature.values.iter().map(|value| {
        let name = format_ident!("{}", value.name);
        entries(&value.dimensions, &|place| quote!(self.#name #place.lane(lane)))
    });
    quote! {
        /// Values of a kernel.
        #[derive(Clone, Copy, Debug)]
        pub struct Values<E> { #(#values),* }

        impl<E: Lane> Values<E> {
            /// Zeros.
            pub const ZERO: Self = Self { #(#value_names: #zeros),* };

            /// Those of the element in a lane.
            ///
            /// # Panics
            /// If there is no such lane.
            #[inline(always)]
            #[must_use]
            pub fn lane(&self, lane: usize) -> Values<f64> {
                Values { #(#value_names: #of_lane),* }
            }
        }
    }
}

/// A field of `Inputs` from those of several elements.
pub(super) fn gathered(input: &Input) -> TokenStream {
    let name = format_ident!("{}", input.name);
    let entries = entries(&input.dimensions, &|place| quote!(E::from_fn(|lane| of(lane).#name #place)));
    quote!(#name: #entries)
}

/// An array whose entries are made from their places, `[0][2]`.
fn entries(dimensions: &[usize], entry: &impl Fn(TokenStream) -> TokenStream) -> TokenStream {
    let all: Vec<TokenStream> = places(dimensions).into_iter().map(entry).collect();
    nested(dimensions, &all)
}

/// Places of all entries, `[0][2]`, the last dimension fastest.
pub(super) fn places(dimensions: &[usize]) -> Vec<TokenStream> {
    dimensions.iter().fold(vec![quote!()], |places, &size| {
        places.iter().flat_map(|place| (0..size).map(move |k| quote!(#place [#k]))).collect()
    })
}

/// A method of `Results`, of an element with a Hessian.
pub(super) fn hessian_at(last: Mode) -> Option<TokenStream> {
    (last == Mode::Hessian).then(|| {
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
    })
}

/// The kernel of a mode, called with `first` and where its derivatives, by name, go to.
pub(super) fn call_by_mode(
    signature: &Signature,
    last: Mode,
    first: impl Fn(Mode) -> TokenStream,
    target: impl Fn(&Ident) -> TokenStream,
) -> TokenStream {
    let arms = Mode::ALL[..=last as usize].iter().map(|&mode| {
        let variant = match mode {
            Mode::Value => quote!(Mode::Value),
            Mode::Gradient => quote!(Mode::Gradient),
            Mode::Hessian => quote!(Mode::Hessian),
        };
        // More derivatives than there are: all there are.
        let pattern = if mode == last { quote!(_) } else { variant };
        let (function, first) = (format_ident!("{}", mode.name()), first(mode));
        let targets = Derivative::all(signature, mode);
        let targets = targets.iter().map(|derivative| target(&derivative.ident()));
        quote!(#pattern => self::#function(#first, #(#targets),*),)
    });
    quote!(match mode { #(#arms)* })
}

/// The instructions of batches.
pub(super) fn best_isa() -> TokenStream {
    quote! {
        /// The instructions to run batches with: the widest that the machine has, or without optimisation one number at a time.
        #[must_use]
        pub fn best_isa() -> Isa {
            if OPTIMISED { Isa::best() } else { Isa::SCALAR }
        }
    }
}

/// Derivatives from lanes to the results they belong to, which `result` is the pattern of.
pub(super) fn stored(
    signature: &Signature,
    last: Mode,
    results: &TokenStream,
    result: &TokenStream,
) -> TokenStream {
    let stored = Derivative::all(signature, last).into_iter().map(|derivative| {
        let (least, name) = (derivative.least_mode(), derivative.ident());
        quote! {
            if mode >= #least {
                T::store_transposed(&#name, #results, |#result| &mut result.#name[..]);
            }
        }
    });
    quote!(#(#stored)*)
}

/// Products from lanes to those they belong to, which `result` is a pattern of that binds `product`.
pub(super) fn stored_products(
    all: &[Derivative],
    results: &TokenStream,
    result: &TokenStream,
) -> TokenStream {
    let stored = all.iter().map(|derivative| {
        let name = derivative.ident();
        quote!(T::store_transposed(&#name, #results, |#result| &mut product.#name[..]);)
    });
    quote!(#(#stored)*)
}
