//! Derivatives of an element's outputs by automatic differentiation of its formulas.

use super::{Expansion, Interpreter, NodeInputs, Number};
use crate::kernel::{Differentiated, ElementKernels, ElementSpec, Input, Kernel, Returned, Role, Signature};

/// Derivatives of an element's outputs by name, in the layout of [`element_results`](super::element_results), whose arguments these are:
/// `gradient`, `hessian`, Jacobians.
///
/// They come from the outputs as they are written, evaluated in [`Expansion`]s: a mistake in the rules of simplification or of differentiation
/// does not show here. Where these have no finite derivatives, as a root has none at 0, they come from the simplified outputs. Only the
/// equations of unknowns that make a function stationary are derivatives of the graph's.
///
/// # Panics
/// If there is a number too few or too many.
pub fn element_derivatives(
    element: &ElementKernels,
    inputs: &[&[f64]],
    nodes: &[&[f64]],
) -> Vec<(String, Vec<f64>)> {
    let is_finite = |found: &[(String, Vec<f64>)]| found.iter().all(|(_, x)| x.iter().all(|x| x.is_finite()));
    let of = |kernel: &Kernel<ElementSpec>| derivatives_of(kernel, &element.signature, inputs, nodes);
    let written = element.written.as_ref().map(of).filter(|found| is_finite(found));
    written.or_else(|| element.kernels.first().map(of)).unwrap_or_default()
}

/// The same of the outputs of one of the element's kernels.
fn derivatives_of(
    kernel: &Kernel<ElementSpec>,
    signature: &Signature,
    inputs: &[&[f64]],
    nodes: &[&[f64]],
) -> Vec<(String, Vec<f64>)> {
    let count = signature.variables() + signature.node_variables() * nodes.len();
    let once = [Vec::new()];
    let points = &signature.points;
    let rows: &[Vec<f64>] = if points.rows.is_empty() { &once } else { &points.rows };
    let mut sums: Vec<(&Returned, Vec<Expansion>)> = Vec::new();
    for row in rows {
        let mut seeded = seeded_inputs(signature, inputs, nodes);
        points.symbols.iter().zip(row).for_each(|(name, &x)| seeded.set_element(name, Number::constant(x)));
        let mut interpreter = Interpreter::new(&kernel.graph, &seeded);
        let mut outputs = Vec::new();
        for returned in signature.values.iter().filter(|of| of.differentiated != Differentiated::Not) {
            let value = kernel.values.iter().find(|value| value.name == returned.name);
            let components = value.map_or(&[][..], |value| &value.components);
            outputs.push((returned, components.iter().map(|&x| interpreter.element(x)).collect()));
        }
        if sums.is_empty() {
            sums = outputs;
            continue;
        }
        for ((_, sums), (_, outputs)) in sums.iter_mut().zip(outputs) {
            sums.iter_mut().zip(outputs).for_each(|(sum, x)| *sum = sum.clone() + x);
        }
    }
    sums.iter().flat_map(|(returned, entries)| of_output(returned, entries, count)).collect()
}

/// Products of these derivatives with a vector, by the names that [`element_products`](super::element_products) has.
pub(crate) fn differentiated_products(
    element: &ElementKernels,
    inputs: &[&[f64]],
    nodes: &[&[f64]],
    direction: &[f64],
) -> Vec<(String, Vec<f64>)> {
    let product = |(name, matrix): (String, Vec<f64>)| {
        let row = |i: usize| -> Vec<f64> {
            let entry = |j: usize| match name.as_str() {
                "hessian" => matrix[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)],
                _ => matrix[i * direction.len() + j],
            };
            (0..direction.len()).map(entry).collect()
        };
        // Without nodes there may be nothing to differentiate by.
        let values = &element.signature.values;
        let of = values.iter().find(|of| name.strip_suffix("_jacobian") == Some(&of.name));
        let rows = of.map_or(direction.len(), |of| of.dimensions.iter().product());
        let dot = |row: Vec<f64>| row.iter().zip(direction).map(|(x, v)| x * v).sum();
        (format!("{name}_product"), (0..rows).map(|i| dot(row(i))).collect())
    };
    let all = element_derivatives(element, inputs, nodes).into_iter();
    all.filter(|(name, _)| name != "gradient").map(product).collect()
}

fn of_output(returned: &Returned, entries: &[Expansion], count: usize) -> Vec<(String, Vec<f64>)> {
    let rows: Vec<f64> = entries.iter().flat_map(|x| x.gradient(count)).collect();
    match (returned.differentiated, entries) {
        (Differentiated::Twice, [x]) => {
            vec![("gradient".to_owned(), rows), ("hessian".to_owned(), x.hessian(count))]
        }
        _ => vec![(format!("{}_jacobian", returned.name), rows)],
    }
}

/// The inputs, variables as such: those of the element first, then node by node.
fn seeded_inputs(signature: &Signature, inputs: &[&[f64]], nodes: &[&[f64]]) -> NodeInputs<Expansion> {
    let (element, of_node) = (signature.variables(), signature.node_variables());
    let count = element + of_node * nodes.len();
    let mut seeded = NodeInputs::with_nodes(nodes.len());
    assert_eq!(signature.inputs.len(), inputs.len(), "inputs of {}", signature.name);
    let lengths = signature.inputs.iter().zip(inputs).map(|(input, x)| (input.symbols.len(), x.len()));
    lengths.for_each(|(expected, found)| assert_eq!(expected, found, "inputs of {}", signature.name));
    let all = expansions(&signature.inputs, &inputs.concat(), (0, count));
    all.into_iter().for_each(|(name, x)| seeded.set_element(name, x));

    let mut of_nodes: Vec<(&str, Vec<Expansion>)> = Vec::new();
    for (node, numbers) in nodes.iter().enumerate() {
        let all = expansions(&signature.nodes, numbers, (element + of_node * node, count));
        if node == 0 {
            of_nodes = all.into_iter().map(|(name, x)| (name, vec![x])).collect();
        } else {
            of_nodes.iter_mut().zip(all).for_each(|((_, values), (_, x))| values.push(x));
        }
    }
    of_nodes.into_iter().for_each(|(name, values)| seeded.set_node(name, values));
    seeded
}

/// Symbols with their numbers, variables counted from `first` of `count`.
fn expansions<'a>(
    inputs: &'a [Input],
    numbers: &[f64],
    (first, count): (usize, usize),
) -> Vec<(&'a str, Expansion)> {
    let symbols = inputs.iter().flat_map(|input| input.symbols.iter().map(move |name| (input.role, name)));
    let symbols: Vec<(Role, &String)> = symbols.collect();
    assert_eq!(symbols.len(), numbers.len(), "numbers of the inputs");
    let mut next = first;
    let expansion = |((role, name), &x): ((Role, &'a String), &f64)| {
        let is_variable = role == Role::Variable;
        let seeded = if is_variable { Expansion::variable(x, next, count) } else { Number::constant(x) };
        next += usize::from(is_variable);
        (name.as_str(), seeded)
    };
    symbols.into_iter().zip(numbers).map(expansion).collect()
}
