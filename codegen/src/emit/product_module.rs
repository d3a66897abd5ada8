//! What runs the kernel of an element's products with a vector.

use proc_macro2::{Ident, TokenStream};
use quote::quote;

use super::derivatives::Derivative;
use super::module::{field, stored_products};
use crate::kernel::Signature;

/// Of an element of fixed size.
pub(super) fn of_fixed_size(signature: &Signature) -> TokenStream {
    let all = Derivative::products(signature);
    let names: Vec<Ident> = all.iter().map(Derivative::ident).collect();
    let lengths: Vec<usize> = all.iter().map(|product| product.length(signature.variables())).collect();
    let fields = all.iter().zip(&lengths).map(|(product, &length)| {
        let doc = format!("{}.", product.meaning(signature));
        field(&product.name, &doc, "", &[length], &quote!(f64))
    });
    let stored = stored_products(&all, &quote!(products), &quote!(product));
    quote! {
        /// Products of the derivatives of one element with a vector v.
        #[derive(Clone, Copy, Debug)]
        pub struct Products { #(#fields),* }

        impl Products {
            /// Zeros.
            pub const ZERO: Self = Self { #(#names: [0.0; #lengths]),* };
        }

        /// Multiplies the derivatives of one element by a vector, which has an entry for each variable.
        #[must_use]
        pub fn multiply(inputs: &Inputs<f64>, direction: &[f64; VARIABLES]) -> Products {
            let mut products = Products::ZERO;
            multiply_into(inputs, direction, &mut products);
            products
        }

        fn multiply_into(inputs: &Inputs<f64>, direction: &[f64; VARIABLES], products: &mut Products) {
            self::product(inputs, direction, #(&mut products.#names),*);
        }

        /// Multiplies the derivatives of many elements, each by a vector of its own, as many side by side as the instructions have lanes:
        /// [`best_isa`] unless there is a reason for others. What an element gets does not depend on its neighbours.
        ///
        /// # Panics
        /// If there are not as many vectors and products as inputs.
        pub fn multiply_batch(
            isa: Isa,
            inputs: &[Inputs<f64>],
            directions: &[[f64; VARIABLES]],
            products: &mut [Products],
        ) {
            assert_eq!(inputs.len(), directions.len(), "as many vectors as inputs");
            assert_eq!(inputs.len(), products.len(), "as many products as inputs");
            let factors = Factors { inputs, directions, products };
            // What a constant rules out is not compiled.
            let left = if OPTIMISED { isa.run_vectors(factors) } else { Err(factors) };
            if let Err(Factors { inputs, directions, products }) = left {
                for ((inputs, direction), products) in inputs.iter().zip(directions).zip(products) {
                    multiply_into(inputs, direction, products);
                }
            }
        }

        struct Factors<'a> {
            inputs: &'a [Inputs<f64>],
            directions: &'a [[f64; VARIABLES]],
            products: &'a mut [Products],
        }

        impl WithLanes for Factors<'_> {
            type Output = ();

            #[inline(always)]
            fn run<T: Vector>(self) {
                let Self { inputs, directions, products } = self;
                let mut direction = [T::ZERO; VARIABLES];
                #(let mut #names = [T::ZERO; #lengths];)*
                let many = inputs.chunks(T::WIDTH).zip(directions.chunks(T::WIDTH));
                for ((inputs, directions), products) in many.zip(products.chunks_mut(T::WIDTH)) {
                    let last = inputs.len() - 1;
                    let lanes = Inputs::<T>::gather(|lane| &inputs[lane.min(last)]);
                    for (k, entry) in direction.iter_mut().enumerate() {
                        *entry = T::from_fn(|lane| directions[lane.min(last)][k]);
                    }
                    self::product(&lanes, &direction, #(&mut #names),*);
                    #stored
                }
            }
        }
    }
}

/// Of an element with nodes of a number that is open, whose kernel needs so many numbers of scratch for each.
pub(super) fn with_nodes(signature: &Signature, scratch: usize) -> TokenStream {
    let all = Derivative::products(signature);
    let names: Vec<Ident> = all.iter().map(Derivative::ident).collect();
    let docs = all.iter().map(|product| format!(" {}.", product.meaning(signature)));
    let lengths: Vec<TokenStream> = all.iter().map(Derivative::length_by_count).collect();
    let stored = stored_products(&all, &quote!(lanes), &quote!((_, _, product)));
    quote! {
        /// Numbers of scratch that [`product`] needs for each node.
        pub const PRODUCT_SCRATCH: usize = #scratch;

        /// Products of the derivatives of one element with a vector v, which have room for as many nodes as it has.
        #[derive(Clone, Debug, Default)]
        pub struct Products { #(#[doc = #docs] pub #names: Vec<f64>),* }

        impl Products {
            /// Room for so many nodes.
            fn reserve(&mut self, count: usize) {
                #(self.#names.resize(#lengths, 0.0);)*
            }
        }

        /// Multiplies the derivatives of one element by a vector, which has an entry for each variable.
        ///
        /// # Panics
        /// If it has too few.
        #[must_use]
        pub fn multiply(inputs: &Inputs<'_, f64>, direction: &[f64]) -> Products {
            let mut products = Products::default();
            multiply_into(inputs, direction, &mut Vec::new(), &mut products);
            products
        }

        /// The same with memory that is used again: nothing is allocated once scratch and products were as large before.
        ///
        /// # Panics
        /// If the vector has too few entries.
        pub fn multiply_into(
            inputs: &Inputs<'_, f64>,
            direction: &[f64],
            scratch: &mut Vec<f64>,
            products: &mut Products,
        ) {
            let count = inputs.nodes.len();
            products.reserve(count);
            scratch.resize(scratch.len().max(PRODUCT_SCRATCH * count), 0.0);
            self::product(
                inputs,
                &direction[..variables(count)],
                &mut scratch[..PRODUCT_SCRATCH * count],
                #(&mut products.#names),*
            );
        }

        /// Multiplies the derivatives of many elements, each by a vector of its own, as many of the same number of nodes side by side as
        /// the instructions have lanes: [`best_isa`] unless there is a reason for others. What an element gets does not depend on its
        /// neighbours.
        ///
        /// # Panics
        /// If there are not as many vectors and products as inputs, or if a vector has too few entries.
        pub fn multiply_batch(
            isa: Isa,
            inputs: &[Inputs<'_, f64>],
            directions: &[&[f64]],
            products: &mut [Products],
        ) {
            assert_eq!(inputs.len(), directions.len(), "as many vectors as inputs");
            assert_eq!(inputs.len(), products.len(), "as many products as inputs");
            let mut scratch = Vec::new();
            let pairs = inputs.iter().zip(directions);
            let mut factors: Vec<Factor<'_>> =
                pairs.zip(products).map(|((inputs, direction), product)| (inputs, *direction, product)).collect();
            factors.sort_by_key(|(inputs, ..)| inputs.nodes.len());
            for group in factors.chunk_by_mut(|(x, ..), (y, ..)| x.nodes.len() == y.nodes.len()) {
                let factors = Factors { factors: group };
                // What a constant rules out is not compiled.
                let left = if OPTIMISED { isa.run_vectors(factors) } else { Err(factors) };
                if let Err(Factors { factors }) = left {
                    for (inputs, direction, products) in factors {
                        multiply_into(inputs, direction, &mut scratch, products);
                    }
                }
            }
        }

        type Factor<'a> = (&'a Inputs<'a, f64>, &'a [f64], &'a mut Products);

        /// Elements of the same number of nodes.
        struct Factors<'a, 'e> {
            factors: &'a mut [Factor<'e>],
        }

        impl WithLanes for Factors<'_, '_> {
            type Output = ();

            #[inline(always)]
            fn run<T: Vector>(self) {
                let Self { factors } = self;
                let count = factors[0].0.nodes.len();
                let mut nodes: Vec<Node<T>> = Vec::with_capacity(count);
                let mut scratch = vec![T::ZERO; PRODUCT_SCRATCH * count];
                let mut direction = vec![T::ZERO; variables(count)];
                #(let mut #names: Vec<T> = Vec::new();)*
                #(#names.resize(#lengths, T::ZERO);)*
                for lanes in factors.chunks_mut(T::WIDTH) {
                    let last = lanes.len() - 1;
                    nodes.clear();
                    for node in 0..count {
                        nodes.push(Node::gather(|lane| &lanes[lane.min(last)].0.nodes[node]));
                    }
                    for (k, entry) in direction.iter_mut().enumerate() {
                        *entry = T::from_fn(|lane| lanes[lane.min(last)].1[k]);
                    }
                    let gathered = Inputs::gather(|lane| lanes[lane.min(last)].0, &nodes);
                    self::product(&gathered, &direction, &mut scratch, #(&mut #names),*);
                    for (.., product) in lanes.iter_mut() {
                        product.reserve(count);
                    }
                    #stored
                }
            }
        }
    }
}
