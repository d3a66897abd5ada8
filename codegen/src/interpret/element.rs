//! All results of an element's kernel.

use super::{Interpreter, NodeInputs};
use crate::kernel::{DirectionSymbols, ElementSpec, Kernel, NodeResult};

/// Results of a kernel by name, derivatives after the others, as the emitted kernel has them: sums over points, Jacobians row by row,
/// the Hessian as its packed lower triangle.
///
/// `inputs`: an element's, in the order of their declaration, each with its last dimension fastest. `nodes`: of each node all its
/// inputs, in the same order.
///
/// # Panics
/// If there is a number too few or too many.
pub fn element_results(
    kernel: &Kernel<ElementSpec>,
    inputs: &[&[f64]],
    nodes: &[&[f64]],
) -> Vec<(String, Vec<f64>)> {
    results(kernel, inputs, nodes, &[])
}

/// Results of a kernel of products with a vector, in the order of the variables it belongs to, by name.
///
/// # Panics
/// If there is a number too few or too many, or if the kernel is none of products.
pub fn element_products(
    kernel: &Kernel<ElementSpec>,
    inputs: &[&[f64]],
    nodes: &[&[f64]],
    direction: &[f64],
) -> Vec<(String, Vec<f64>)> {
    assert!(kernel.spec.direction.is_some(), "no kernel of products");
    results(kernel, inputs, nodes, direction)
}

fn results(
    kernel: &Kernel<ElementSpec>,
    inputs: &[&[f64]],
    nodes: &[&[f64]],
    direction: &[f64],
) -> Vec<(String, Vec<f64>)> {
    let signature = &kernel.spec.signature;
    let once = vec![Vec::new()];
    let points = &signature.points;
    let mut sums: Vec<(String, Vec<f64>)> = Vec::new();
    for point in if points.rows.is_empty() { &once } else { &points.rows } {
        let mut numbers = NodeInputs::new(nodes.len());
        assert_eq!(signature.inputs.len(), inputs.len(), "inputs of {}", signature.name);
        for (input, values) in signature.inputs.iter().zip(inputs) {
            assert_eq!(input.symbols.len(), values.len(), "{}", input.name);
            input.symbols.iter().zip(*values).for_each(|(name, &x)| numbers.set_element(name, x));
        }
        points.symbols.iter().zip(point).for_each(|(name, &x)| numbers.set_element(name, x));
        let symbols: Vec<&String> = signature.nodes.iter().flat_map(|input| &input.symbols).collect();
        assert!(nodes.iter().all(|node| node.len() == symbols.len()), "inputs of the nodes");
        for (k, name) in symbols.into_iter().enumerate() {
            numbers.set_node(name, nodes.iter().map(|node| node[k]).collect());
        }
        if let Some(symbols) = &kernel.spec.direction {
            set_direction(&mut numbers, symbols, nodes.len(), direction);
        }
        let results = at_point(kernel, &mut Interpreter::new(&kernel.graph, &numbers), nodes.len());
        if sums.is_empty() {
            sums = results;
        } else {
            let pairs = sums.iter_mut().zip(results);
            pairs.for_each(|((_, sums), (_, x))| sums.iter_mut().zip(x).for_each(|(sum, x)| *sum += x));
        }
    }
    sums
}

/// The vector of a product.
fn set_direction(numbers: &mut NodeInputs, symbols: &DirectionSymbols, count: usize, direction: &[f64]) {
    let DirectionSymbols { element, node } = symbols;
    assert_eq!(direction.len(), element.len() + node.len() * count, "entries of the vector");
    let (of_element, of_nodes) = direction.split_at(element.len());
    element.iter().zip(of_element).for_each(|(name, &x)| numbers.set_element(name, x));
    for (k, name) in node.iter().enumerate() {
        numbers.set_node(name, of_nodes.iter().skip(k).step_by(node.len()).copied().collect());
    }
}

fn at_point(
    kernel: &Kernel<ElementSpec>,
    interpreter: &mut Interpreter<'_>,
    count: usize,
) -> Vec<(String, Vec<f64>)> {
    let signature = &kernel.spec.signature;
    let (element, of_node) = (signature.variables(), signature.node_variables());
    let all = element + of_node * count;
    let values = kernel.values.iter().map(|value| {
        let of_element: Vec<f64> = value.components.iter().map(|&x| interpreter.element(x)).collect();
        let name = value.name.to_string();
        // A product with a Jacobian has no entries by variables.
        let is_whole = name.ends_with("_jacobian_product");
        let is_value = signature.values.iter().any(|returned| returned.name == name);
        if signature.nodes.is_empty() || is_value || is_whole {
            return (name, of_element);
        }
        let (rows, is_hessian) = (of_element.len() / element.max(1), name == "hessian");
        let rows = if element == 0 { rows_of(kernel, &name) } else { rows };
        let mut whole = vec![0.0; if is_hessian { all * (all + 1) / 2 } else { rows * all }];
        for (k, x) in of_element.into_iter().enumerate() {
            let place = if is_hessian { k } else { k / element * all + k % element };
            whole[place] = x;
        }
        (name, whole)
    });
    let mut results: Vec<(String, Vec<f64>)> = values.collect();
    let mut rows = vec![vec![vec![0.0; of_node]; count]; 2 * kernel.spec.node_results.len()];
    let mut products = 0;
    for (result, &(_, x)) in kernel.spec.node_results.iter().zip(&kernel.node_values) {
        for node in 0..count {
            let (first, x) = (element + of_node * node, interpreter.node(x, node));
            let mut whole = |name: &str| results.iter_mut().position(|(other, _)| other == name);
            match result {
                NodeResult::First { argument, row, component } => {
                    let place = whole(argument).unwrap_or_default();
                    results[place].1[row * all + first + component] = x;
                }
                NodeResult::Mixed { component, variable } => {
                    let place = whole("hessian").unwrap_or_default();
                    let row = first + component;
                    results[place].1[row * (row + 1) / 2 + variable] = x;
                }
                NodeResult::Row { row, component } => {
                    rows[*row][node][*component] = x;
                    products = products.max(row / 2 + 1);
                }
                NodeResult::Own { place: entry } => {
                    let place = whole("hessian").unwrap_or_default();
                    let (a, b) = (0..of_node)
                        .flat_map(|a| (0..=a).map(move |b| (a, b)))
                        .nth(*entry)
                        .unwrap_or_default();
                    let row = first + a;
                    results[place].1[row * (row + 1) / 2 + first + b] = x;
                }
            }
        }
    }
    if let Some((_, hessian)) = results.iter_mut().find(|(name, _)| name == "hessian") {
        for row in element..all {
            for column in element..=row {
                let place = |k: usize| ((k - element) / of_node, (k - element) % of_node);
                let ((i, a), (j, b)) = (place(row), place(column));
                hessian[row * (row + 1) / 2 + column] += (0..products)
                    .map(|k| {
                        let (b_row, c_row) = (&rows[2 * k], &rows[2 * k + 1]);
                        b_row[i][a] * c_row[j][b] + c_row[i][a] * b_row[j][b]
                    })
                    .sum::<f64>();
            }
        }
    }
    results
}

/// Rows of a first derivative of an element without variables of its own.
fn rows_of(kernel: &Kernel<ElementSpec>, name: &str) -> usize {
    let rows = kernel.spec.node_results.iter().filter_map(|result| match result {
        NodeResult::First { argument, row, .. } if argument == name => Some(row + 1),
        _ => None,
    });
    rows.max().unwrap_or(0)
}
