//! The module of an element of the caller's: types, kernels by mode, and what runs them.

use proc_macro2::{Group, Literal, TokenStream, TokenTree};
use quote::{format_ident, quote};

use super::count::OpCounts;
use super::element_kernel::{EmittedElementKernel, documentation, function_name, title};
use super::fixed::{Fixed, Head};
use super::function::solver_name;
use super::node_element::emit_node_kernel;
use super::tabulated::tabulated;
use super::{element_module, node_module, product_module};
use crate::graph::Iteration;
use crate::kernel::{ElementError, ElementKernels, ElementSpec, Kernel, Mode};
use crate::lower::lower;
use crate::schedule::Program;

/// Lowers, schedules and writes a kernel of an element.
pub fn emit_element_kernel(kernel: &Kernel<ElementSpec>) -> EmittedElementKernel {
    write_element_kernel(&scheduled(kernel))
}

/// The program of a kernel of an element.
pub(super) fn scheduled(kernel: &Kernel<ElementSpec>) -> Program<ElementSpec> {
    Program::new(tabulated(lower(kernel)))
}

/// Writes a kernel of an element.
pub(super) fn write_element_kernel(program: &Program<ElementSpec>) -> EmittedElementKernel {
    let spec = &program.kernel.spec;
    if !spec.signature.nodes.is_empty() {
        return emit_node_kernel(program);
    }
    let head = Head::new(spec);
    let function = Fixed::new(program, &head);
    let mut kernel = EmittedElementKernel {
        mode: spec.mode,
        tokens: TokenStream::new(),
        counts: function.counts,
        per_node: [OpCounts::default(); 2],
        scratch: 0,
        iteration: function.iteration,
        statements: function.statements,
    };
    let documentation = documentation(spec, &kernel);
    kernel.tokens = function.tokens(&head, &documentation);
    kernel
}

/// The module of an element. `optimised`: whether the crate it goes into is compiled with optimisation.
///
/// # Errors
/// [`ElementError::TooLong`].
pub fn emit_element(
    element: &ElementKernels,
    support: &syn::Path,
    optimised: bool,
) -> Result<TokenStream, ElementError> {
    let signature = &element.signature;
    let (mut kernels, mut iterations, mut scratch) = (Vec::new(), Vec::new(), Vec::new());
    for kernel in element.kernels.iter().chain(&element.product) {
        let EmittedElementKernel { tokens, statements, scratch: of_kernel, .. } = emit_element_kernel(kernel);
        scratch.push(of_kernel);
        if statements > super::MOST_STATEMENTS {
            let function = function_name(&kernel.spec).to_owned();
            return Err(ElementError::TooLong { function, statements });
        }
        iterations.extend(kernel.roots().into_iter().map(|root| kernel.graph.root(root).iteration));
        kernels.push(tokens);
    }
    let module = format_ident!("{}", signature.name);
    let last = element.kernels.last().map_or(Mode::Value, |kernel| kernel.spec.mode);
    let doc = format!(" {}", title(signature));
    let has_nodes = !signature.nodes.is_empty();
    let has_products = has_nodes && last == Mode::Hessian && signature.node_variables() > 0;
    let others = [
        ("packed_row", last == Mode::Hessian),
        ("Equations", iterations.iter().any(|iteration| matches!(iteration, Iteration::Within(_)))),
        (solver_name(Iteration::Newton), iterations.contains(&Iteration::Newton)),
        (solver_name(Iteration::Descent), iterations.contains(&Iteration::Descent)),
        ("multiply_node_rows", has_products),
        ("first_entries", last > Mode::Value && !has_nodes),
    ];
    let others = others.into_iter().filter(|(_, is_used)| *is_used).map(|(name, _)| format_ident!("{name}"));
    let (types, runners, unused) = if has_nodes {
        let types = node_module::types(signature, last, &scratch[..element.kernels.len()]);
        (types, node_module::runners(signature, last), Some(quote!(#[allow(unused_variables)])))
    } else {
        (element_module::types(signature, last), element_module::runners(signature, last), None)
    };
    let products = element.product.as_ref().map(|_| match scratch.last() {
        Some(&scratch) if has_nodes => product_module::with_nodes(signature, scratch),
        _ => product_module::of_fixed_size(signature),
    });
    Ok(without_suffixes(quote! {
        #[doc = #doc]
        #[allow(clippy::all, clippy::pedantic, non_snake_case)]
        #unused
        pub mod #module {
            use #support::{Isa, Lane, Mode, Vector, WithLanes};
            #(use #support::#others;)*

            /// Whether the kernels are compiled with optimisation. Without, they are compiled number by number only.
            const OPTIMISED: bool = #optimised;

            #types
            #(#kernels)*
            #runners
            #products
        }
    }))
}

/// `[E; 12usize]` → `[E; 12]`
pub(super) fn without_suffixes(tokens: TokenStream) -> TokenStream {
    let change = |tree: TokenTree| match tree {
        TokenTree::Group(group) => {
            TokenTree::Group(Group::new(group.delimiter(), without_suffixes(group.stream())))
        }
        TokenTree::Literal(literal) => {
            let number = literal.to_string().strip_suffix("usize").and_then(|number| number.parse().ok());
            TokenTree::Literal(number.map_or(literal, Literal::usize_unsuffixed))
        }
        other => other,
    };
    tokens.into_iter().map(change).collect()
}
