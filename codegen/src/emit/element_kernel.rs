//! A kernel of an element of the caller's: its source, its name and its documentation.

use proc_macro2::TokenStream;

use super::count::OpCounts;
use super::derivatives::Derivative;
use crate::kernel::{Defined, ElementSpec, Mode, Signature};

/// A kernel of an element as source.
#[derive(Clone, Debug)]
pub struct EmittedElementKernel {
    /// With how many derivatives.
    pub mode: Mode,
    /// The function.
    pub tokens: TokenStream,
    /// Operations, with one evaluation of the equations of roots, without those of nodes.
    pub counts: OpCounts,
    /// Operations for each node, and for each pair of nodes; none of an element of fixed size.
    pub per_node: [OpCounts; 2],
    /// Numbers of scratch for each node; none of an element of fixed size.
    pub scratch: usize,
    /// Operations of one evaluation of the equations of roots.
    pub iteration: OpCounts,
    /// Statements of the function.
    pub statements: usize,
}

/// The first line of an element's documentation.
pub(super) fn title(signature: &Signature) -> String {
    if signature.doc.is_empty() {
        format!("The element `{}`.", signature.name)
    } else {
        signature.doc.clone()
    }
}

/// Name of a kernel's function.
pub(super) const fn function_name(spec: &ElementSpec) -> &'static str {
    if spec.direction.is_some() { "product" } else { spec.mode.name() }
}

/// Lines of a kernel's documentation.
pub(super) fn documentation(spec: &ElementSpec, kernel: &EmittedElementKernel) -> Vec<String> {
    let ElementSpec { signature, mode, quantities, direction, .. } = spec;
    let with = match mode {
        _ if direction.is_some() => {
            "Products of derivatives with a vector v, `direction`, without the derivatives"
        }
        Mode::Value => "Values",
        Mode::Gradient => "Values and first derivatives",
        Mode::Hessian => "Values, first and second derivatives",
    };
    let mut lines = vec![format!(" {}", title(signature)), String::new(), format!(" {with}:"), String::new()];
    for value in signature.values.iter().filter(|_| direction.is_none()) {
        lines.push(format!(
            " * `{}`{}",
            value.name,
            if value.doc.is_empty() { String::new() } else { format!(": {}", value.doc) }
        ));
    }
    for derivative in Derivative::of(spec) {
        lines.push(format!(" * `{}`: {}", derivative.name, derivative.meaning(signature)));
    }
    if !quantities.is_empty() {
        let described = |of: &Defined| {
            let separator = if of.doc.is_empty() { "" } else { " = " };
            format!("`{}{separator}{}`", of.name, of.doc)
        };
        lines.push(String::new());
        lines.push(format!(" Made of {}.", quantities.iter().map(described).collect::<Vec<_>>().join(", ")));
    }
    if !signature.points.rows.is_empty() {
        lines.push(String::new());
        lines.push(format!(" Sums over {} points.", signature.points.rows.len()));
    }
    lines.push(String::new());
    let (total, iteration) = (kernel.counts.total(), kernel.iteration.total());
    let of_nodes = match (signature.nodes.is_empty(), kernel.per_node.map(|counts| counts.total())) {
        (true, _) => String::new(),
        (false, [node, 0]) => format!(" + {node} n"),
        (false, [node, pair]) => format!(" + {node} n + {pair} n(n−1)/2"),
    };
    lines.push(match iteration {
        0 => format!(" Operations: {total}{of_nodes}."),
        each => {
            let place = if signature.points.rows.is_empty() { "" } else { " at a point" };
            format!(" Operations: {}{of_nodes}, and {each} for each Newton iteration{place}.", total - each)
        }
    });
    if !signature.nodes.is_empty() {
        lines.push(String::new());
        let scratch = match direction {
            Some(_) => "[`PRODUCT_SCRATCH`]".to_owned(),
            None => format!("[`SCRATCH`]`[{}]`", *mode as usize),
        };
        lines.push(format!(" `scratch`: {scratch} numbers for each of the n nodes, of any content."));
        lines.push(String::new());
        lines.push(" # Panics".to_owned());
        lines.push(" If a slice is shorter than the nodes need.".to_owned());
    }
    lines
}
