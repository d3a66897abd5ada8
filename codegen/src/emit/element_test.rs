//! The tests that stand beside an element's kernels: they have the results of the interpreter, and the derivatives of automatic
//! differentiation.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::element::without_suffixes;
use super::fixed::nested;
use super::module::places;
use crate::graph::{Op, RootFigure};
use crate::interpret::{differentiated_products, element_derivatives, element_products, element_results};
use crate::kernel::{ElementError, ElementKernels, ElementSpec, Input, Kernel, Signature};

/// Largest difference of a kernel from what it is compared with, relative to the largest entry.
const TOLERANCE: f64 = 1e-12;
/// The same over the largest entry of all results.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Name of the module of an element's tests.
pub(crate) fn test_module(element: &str) -> String {
    format!("{element}_tests")
}

/// Tests at these inputs, in the order of [`element_results`]: `evaluate` and `batch` have what the formulas' graph has in the interpreter,
/// which shares nothing with the emitter, and what it finds for the formulas as they are written, without the derivatives of the graph.
///
/// # Errors
/// [`ElementError::TestInputs`], [`ElementError::TestNumber`], [`ElementError::TestResult`], [`ElementError::TestDerivative`].
pub fn emit_element_test(
    element: &ElementKernels,
    support: &syn::Path,
    inputs: &[Vec<f64>],
    nodes: &[Vec<f64>],
) -> Result<TokenStream, ElementError> {
    let (signature, Some(kernel)) = (&element.signature, element.kernels.last()) else {
        return Err(ElementError::NoOutput);
    };
    check_numbers(signature, inputs, nodes)?;
    let interpreted = element_results(kernel, &slices(inputs), &slices(nodes));
    let interpreted = comparisons(kernel, &interpreted, |result| ElementError::TestResult { result })?;
    let values =
        element.written.as_ref().map(|kernel| element_results(kernel, &slices(inputs), &slices(nodes)));
    let is_finite = |(_, x): &(String, Vec<f64>)| x.iter().all(|x| x.is_finite());
    let mut differentiated = values.filter(|all| all.iter().all(is_finite)).unwrap_or_default();
    differentiated.extend(element_derivatives(element, &slices(inputs), &slices(nodes)));
    let differentiated =
        comparisons(kernel, &differentiated, |result| ElementError::TestDerivative { result })?;
    let differentiated = (!differentiated.is_empty()).then(|| {
        quote! {
            #[test]
            fn derivatives_are_those_of_automatic_differentiation() {
                for found in all() {
                    #(#differentiated)*
                }
            }
        }
    });
    let products =
        element.product.as_ref().map(|kernel| products(element, kernel, inputs, nodes)).transpose()?;
    let fields = fields(&signature.inputs, &inputs.concat());
    let of_nodes = (!signature.nodes.is_empty()).then(|| {
        let nodes = nodes.iter().map(|numbers| self::fields(&signature.nodes, numbers));
        quote!(nodes: &[#(Node { #nodes }),*])
    });
    let lifetime = of_nodes.is_some().then(|| quote!('static,));
    let module = format_ident!("{}", signature.name);
    let tests = format_ident!("{}", test_module(&signature.name));
    Ok(without_suffixes(quote! {
        #[cfg(test)]
        #[allow(clippy::all, clippy::pedantic, non_snake_case)]
        mod #tests {
            use #support::Mode;
            use super::#module::*;

            #[test]
            fn values_and_derivatives_are_those_of_the_interpreter() {
                for found in all() {
                    #(#interpreted)*
                }
            }

            #differentiated

            #products

            /// Of one element, and of several side by side.
            fn all() -> Vec<Results> {
                let inputs = inputs();
                let mut all = vec![evaluate(Mode::Value, &inputs); 3];
                batch(best_isa(), Mode::Hessian, &[inputs; 3], &mut all);
                all.push(evaluate(Mode::Hessian, &inputs));
                all
            }

            fn inputs() -> Inputs<#lifetime f64> {
                Inputs { #fields #of_nodes }
            }

            fn agree(name: &str, found: &[f64], expected: &[f64], tolerance: f64) {
                assert_eq!(found.len(), expected.len(), "{name}");
                for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
                    assert!(
                        (found - expected).abs() <= tolerance,
                        "{name}[{k}] is {found:e} instead of {expected:e}"
                    );
                }
            }
        }
    }))
}

/// The tests of products with a vector.
fn products(
    element: &ElementKernels,
    kernel: &Kernel<ElementSpec>,
    inputs: &[Vec<f64>],
    nodes: &[Vec<f64>],
) -> Result<TokenStream, ElementError> {
    let signature = &element.signature;
    let direction = direction(signature.variables() + signature.node_variables() * nodes.len());
    let (inputs, of_nodes) = (slices(inputs), slices(nodes));
    let interpreted = element_products(kernel, &inputs, &of_nodes, &direction);
    let interpreted = comparisons(kernel, &interpreted, |result| ElementError::TestResult { result })?;
    let differentiated = differentiated_products(element, &inputs, &of_nodes, &direction);
    let differentiated =
        comparisons(kernel, &differentiated, |result| ElementError::TestDerivative { result })?;
    let (none, vectors) = if signature.nodes.is_empty() {
        (quote!(Products::ZERO), quote!(&[DIRECTION; 3]))
    } else {
        (quote!(Products::default()), quote!(&[&DIRECTION[..]; 3]))
    };
    let count = direction.len();
    Ok(quote! {
        const DIRECTION: [f64; #count] = [#(#direction),*];

        #[test]
        fn products_are_those_of_the_interpreter() {
            for found in products() {
                #(#interpreted)*
            }
        }

        #[test]
        fn products_are_those_of_automatic_differentiation() {
            for found in products() {
                #(#differentiated)*
            }
        }

        /// Of one element, and of several side by side.
        fn products() -> Vec<Products> {
            let mut all = vec![#none; 3];
            multiply_batch(best_isa(), &[inputs(); 3], #vectors, &mut all);
            all.push(multiply(&inputs(), &DIRECTION));
            all
        }
    })
}

/// A vector whose entries look random, with few digits.
fn direction(count: usize) -> Vec<f64> {
    // Steps of the golden ratio never repeat.
    (1..=count).map(|k| ((0.618_034 * k as f64).fract() * 1e3).round() / 1e3 - 0.5).collect()
}

fn check_numbers(signature: &Signature, inputs: &[Vec<f64>], nodes: &[Vec<f64>]) -> Result<(), ElementError> {
    let wrong = |input: &str, expected: usize, found: usize| {
        let input = input.to_owned();
        if expected == found { Ok(()) } else { Err(ElementError::TestInputs { input, expected, found }) }
    };
    let check = |input: &str, expected: usize, numbers: &[f64]| {
        wrong(input, expected, numbers.len())?;
        let is_finite = numbers.iter().all(|x| x.is_finite());
        if is_finite { Ok(()) } else { Err(ElementError::TestNumber { input: input.to_owned() }) }
    };
    wrong("inputs", signature.inputs.len(), inputs.len())?;
    for (input, numbers) in signature.inputs.iter().zip(inputs) {
        check(&input.name, input.symbols.len(), numbers)?;
    }
    let per_node: usize = signature.nodes.iter().map(|input| input.symbols.len()).sum();
    nodes.iter().try_for_each(|node| check("node", per_node, node))
}

/// Statements for each result that compare it with the numbers of `expected`; all values have one tolerance.
///
/// How an iteration went is not compared: interpreter and kernel count other things. It has to have converged.
fn comparisons(
    kernel: &Kernel<ElementSpec>,
    expected: &[(String, Vec<f64>)],
    not_finite: impl Fn(String) -> ElementError,
) -> Result<Vec<TokenStream>, ElementError> {
    let signature = &kernel.spec.signature;
    // Tolerances follow from all of them.
    if let Some((name, _)) = expected.iter().find(|(_, x)| !x.iter().all(|x| x.is_finite())) {
        return Err(not_finite(name.clone()));
    }
    let largest = |x: &[f64]| x.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    let returned = |name: &str| signature.values.iter().find(|returned| returned.name == name);
    let figure = |name: &str, place: usize| {
        let value = kernel.values.iter().find(|value| value.name == name)?;
        match kernel.graph.op(value.components[place]) {
            Op::RootFigure(_, figure) => Some(figure),
            _ => None,
        }
    };
    let values = expected.iter().filter(|(name, _)| returned(name).is_some());
    let entries = values.flat_map(|(name, x)| x.iter().enumerate().map(move |(k, x)| (name, k, x)));
    let compared = entries.filter(|(name, k, _)| figure(name, *k).is_none());
    let of_values = compared.map(|(.., x)| x.abs()).fold(0.0, f64::max);
    // A derivative that is nothing but rounding, as at rest, has no digits.
    let derivatives = expected.iter().filter(|(name, _)| returned(name).is_none());
    let all = derivatives.map(|(_, x)| largest(x)).fold(of_values, f64::max);
    let floor = ROUNDING * all;
    let most = TOLERANCE * signature.points.rows.len().max(1) as f64;
    let comparison = |(name, expected): &(String, Vec<f64>)| {
        let field = format_ident!("{name}");
        let Some(returned) = returned(name) else {
            let tolerance = (TOLERANCE * largest(expected)).max(floor);
            return quote!(agree(#name, &found.#field[..], &[#(#expected),*], #tolerance););
        };
        let (mut compared, mut numbers, mut converged) = (Vec::new(), Vec::new(), Vec::new());
        for (k, place) in places(&returned.dimensions).into_iter().enumerate() {
            let found = quote!(found.values.#field #place);
            match figure(name, k) {
                Some(RootFigure::Residual) => {
                    converged.push(quote!(assert!(#found < #most, "{} shows no root", #name);));
                }
                Some(RootFigure::Iterations) => {}
                None => {
                    compared.push(found);
                    numbers.push(expected[k]);
                }
            }
        }
        let tolerance = (TOLERANCE * of_values).max(floor);
        let compared = (!compared.is_empty())
            .then(|| quote!(agree(#name, &[#(#compared),*][..], &[#(#numbers),*], #tolerance);));
        quote!(#compared #(#converged)*)
    };
    Ok(expected.iter().map(comparison).collect())
}

fn slices(rows: &[Vec<f64>]) -> Vec<&[f64]> {
    rows.iter().map(Vec::as_slice).collect()
}

/// Fields of a struct with these numbers.
fn fields(inputs: &[Input], numbers: &[f64]) -> TokenStream {
    let mut rest = numbers;
    let fields = inputs.iter().map(|input| {
        let (own, others) = rest.split_at(input.symbols.len());
        rest = others;
        let own: Vec<TokenStream> = own.iter().map(|x| quote!(#x)).collect();
        let (name, entries) = (format_ident!("{}", input.name), nested(&input.dimensions, &own));
        quote!(#name: #entries,)
    });
    quote!(#(#fields)*)
}
