//! Derivatives by the positions of a few nodes, with as few operations as the ways tried take.
//!
//! A function of the differences of positions does not change with a translation: Σ_k ∂E/∂x_k = 0. Rows of the first node then follow
//! from those of the others. That is found in the expressions, by moving all nodes by the position of the first: if nothing depends on it
//! any more, the function is one of differences.

use super::chain::Derivatives;
use super::direction::Direction;
use super::intermediates::{Written, as_bound, with_found};
use crate::expr::{Expr, Sheet, ids, total};
use crate::graph::ExprId;

/// Variables that are vectors of several nodes, one after another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeVectors {
    /// Place of the first one among all variables.
    pub first: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Components of each vector.
    pub components: usize,
}

/// Gradient and, if asked for, Hessian of a function of element scope by all variables, through the intermediates it has.
#[must_use]
pub fn total_derivatives<'g>(
    sheet: &'g Sheet,
    function: Expr<'g>,
    variables: &[Expr<'g>],
    nodes: &[NodeVectors],
    with_hessian: bool,
) -> Derivatives<'g> {
    let ways = [as_bound(&[function], variables), with_found(sheet, &[function], variables)];
    let invariant = invariant(&ways[0], variables, nodes);
    let free = free(variables.len(), &invariant);
    let cheapest = ways
        .iter()
        .flat_map(|way| {
            let chain = way.chain.with_variables(free.iter().map(|&place| variables[place]).collect());
            let forms = if with_hessian { 0..chain.choices() } else { 0..1 };
            forms.map(move |forms| (way.outputs[0], chain.clone(), forms)).collect::<Vec<_>>()
        })
        .map(|(function, chain, forms)| {
            let derivatives = chain.derivatives(function, with_hessian, forms);
            complete(sheet, &derivatives, &free, variables.len(), &invariant)
        })
        .min_by_key(|derivatives| {
            let roots: Vec<ExprId> =
                derivatives.gradient.iter().chain(&derivatives.hessian).map(|x| x.id()).collect();
            sheet.graph().operations(&roots)
        });
    cheapest.expect("there is a first way")
}

/// The product of the Hessian with a direction, without the Hessian.
///
/// It is the rate of the gradient in the direction, forward over reverse, and the gradient of the function's rate, reverse over forward.
/// What takes fewer operations depends on the function.
#[must_use]
pub fn hessian_product<'g>(
    sheet: &'g Sheet,
    function: Expr<'g>,
    variables: &[Expr<'g>],
    direction: &[Expr<'g>],
    nodes: &[NodeVectors],
) -> Vec<Expr<'g>> {
    let rates = || variables.iter().copied().zip(direction.iter().copied());
    let ways = [as_bound(&[function], variables), with_found(sheet, &[function], variables)];
    let invariant = invariant(&ways[0], variables, nodes);
    let free = free(variables.len(), &invariant);
    let forward_over_reverse = ways.iter().map(|way| {
        let chain = way.chain.with_variables(free.iter().map(|&place| variables[place]).collect());
        let gradient = chain.derivatives(way.outputs[0], false, 0).gradient;
        let mut along = Direction::new(sheet, rates());
        let rates = gradient.into_iter().map(|x| along.derivative(x)).collect();
        let derivatives = Derivatives { gradient: rates, hessian: Vec::new() };
        // The sum of the gradient's rows vanishes whatever the positions are, so that of their rates does.
        complete(sheet, &derivatives, &free, variables.len(), &invariant).gradient
    });
    let forward_over_reverse: Vec<_> = forward_over_reverse.collect();
    let rate = Direction::new(sheet, rates()).derivative(function);
    let reverse_over_forward = total_derivatives(sheet, rate, variables, nodes, false).gradient;
    let products = forward_over_reverse.into_iter().chain([reverse_over_forward]);
    products.min_by_key(|product| sheet.graph().operations(&ids(product))).expect("there is a first way")
}

/// The groups that the function does not depend on the place of.
fn invariant<'g>(way: &Written<'g>, variables: &[Expr<'g>], nodes: &[NodeVectors]) -> Vec<NodeVectors> {
    nodes.iter().copied().filter(|group| is_invariant(way, variables, group)).collect()
}

/// Places of variables whose derivatives do not follow from those of others.
fn free(count: usize, invariant: &[NodeVectors]) -> Vec<usize> {
    (0..count).filter(|&place| !invariant.iter().any(|group| group.of_first_node(place))).collect()
}

impl NodeVectors {
    const fn of_first_node(&self, place: usize) -> bool {
        place >= self.first && place < self.first + self.components
    }

    /// Places of a component of the nodes after the first.
    fn others(&self, component: usize) -> impl Iterator<Item = usize> {
        let (first, components) = (self.first, self.components);
        (1..self.nodes).map(move |node| first + node * components + component)
    }
}

/// Whether nothing changes when all nodes move by the position of the first.
fn is_invariant<'g>(way: &Written<'g>, variables: &[Expr<'g>], group: &NodeVectors) -> bool {
    if group.nodes < 2 {
        return false;
    }
    let first = &variables[group.first..group.first + group.components];
    let moved: Vec<(Expr<'g>, Expr<'g>)> = (0..group.components)
        .flat_map(|component| group.others(component).map(move |place| (component, place)))
        .map(|(component, place)| (variables[place], variables[place] + first[component]))
        .collect();
    let definitions = way.chain.intermediates().map(|v| v.definition);
    definitions.chain(way.outputs.iter().copied()).all(|piece| {
        let piece = piece.at(&moved);
        first.iter().all(|&x| !piece.contains(x))
    })
}

/// The derivatives by all variables from those by the free ones.
fn complete<'g>(
    sheet: &'g Sheet,
    derivatives: &Derivatives<'g>,
    free: &[usize],
    count: usize,
    invariant: &[NodeVectors],
) -> Derivatives<'g> {
    let mut gradient = vec![sheet.zero(); count];
    free.iter().zip(&derivatives.gradient).for_each(|(&place, &x)| gradient[place] = x);
    let held: Vec<(NodeVectors, usize)> = invariant
        .iter()
        .flat_map(|&group| (0..group.components).map(move |component| (group, component)))
        .collect();
    for (group, component) in &held {
        gradient[group.first + component] = -total(group.others(*component).map(|other| gradient[other]));
    }
    if derivatives.hessian.is_empty() {
        return Derivatives { gradient, hessian: Vec::new() };
    }

    let mut matrix = vec![vec![sheet.zero(); count]; count];
    let mut entries = derivatives.hessian.iter();
    for (row, &i) in free.iter().enumerate() {
        for (&j, &x) in free[..=row].iter().zip(&mut entries) {
            (matrix[i][j], matrix[j][i]) = (x, x);
        }
    }
    let mut known = free.to_vec();
    for (group, component) in &held {
        let place = group.first + component;
        known.push(place);
        for &j in &known {
            // In its own column the sums of the other rows are there already, as its row is symmetric.
            let x = -total(group.others(*component).map(|other| matrix[other][j]));
            (matrix[place][j], matrix[j][place]) = (x, x);
        }
    }
    let hessian = (0..count).flat_map(|i| matrix[i][..=i].to_vec()).collect();
    Derivatives { gradient, hessian }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::{Mat3, Vec3};
    use crate::graph::Scope;
    use crate::interpret::{Interpreter, NodeInputs};

    /// A neo-Hooke tetrahedron; what is bound of it is for the test to say.
    fn energy<'g>(x: [Vec3<'g>; 4], reference: [Vec3<'g>; 4], bind: bool) -> Expr<'g> {
        let edges = |x: [Vec3<'g>; 4]| Mat3::from_columns([1, 2, 3].map(|k| x[k] - x[0]));
        let f = edges(x) * edges(reference).inverse();
        let f = if bind { f.bind("F") } else { f };
        let j = f.determinant();
        let j = if bind { j.bind("J") } else { j };
        f.double_dot(f) - 2.0 * j.ln() + 0.7 * j.ln().powi(2)
    }

    #[test]
    fn all_ways_have_the_derivatives_of_plain_differentiation() {
        let sheet = Sheet::new();
        let vectors = |name: &str| [1, 2, 3, 4].map(|k| sheet.vector(&format!("{name}_{k}"), Scope::Element));
        let (x, reference) = (vectors("x"), vectors("X"));
        let variables: Vec<Expr<'_>> = x.iter().flat_map(|x| x.0).collect();
        let nodes = NodeVectors { first: 0, nodes: 4, components: 3 };
        let plain = energy(x, reference, false);
        let (bound, loose) = (energy(x, reference, true), plain);
        assert!(is_invariant(&as_bound(&[plain], &variables), &variables, &nodes));

        let mut inputs = NodeInputs::new(0);
        let mut value = 0.3_f64;
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (k, axis) in (0..4).flat_map(|k| [0, 1, 2].map(|axis| (k, axis))) {
            for vector in [x[k], reference[k]] {
                value = (value * 7.3 + 0.17).fract();
                inputs.set_element(&vector[axis].symbol_name(), corners[k][axis] + 0.3 * (value - 0.5));
            }
        }
        let first: Vec<Expr<'_>> = variables.iter().map(|&v| plain.by(v)).collect();
        let second: Vec<Expr<'_>> = (0..12)
            .flat_map(|i| (0..=i).map(move |j| (i, j)))
            .map(|(i, j)| first[i].by(variables[j]))
            .collect();
        for (function, groups) in [(bound, &[nodes][..]), (loose, &[nodes]), (bound, &[]), (loose, &[])] {
            let found = total_derivatives(&sheet, function, &variables, groups, true);
            let gradient = total_derivatives(&sheet, function, &variables, groups, false).gradient;
            let graph = sheet.graph();
            let mut interpreter = Interpreter::new(&graph, &inputs);
            let pairs = found.gradient.iter().zip(&first).chain(gradient.iter().zip(&first));
            for (found, expected) in pairs.chain(found.hessian.iter().zip(&second)) {
                let [found, expected] = [found, expected].map(|x| interpreter.element(x.id()));
                assert!((found - expected).abs() < 1e-12 * (1.0 + expected.abs()), "{found} {expected}");
            }
            let roots: Vec<ExprId> = found.gradient.iter().chain(&found.hessian).map(|x| x.id()).collect();
            assert!(graph.operations(&roots) < 900, "{}", graph.operations(&roots));
        }
    }

    #[test]
    fn a_function_of_positions_themselves_is_not_invariant() {
        let sheet = Sheet::new();
        let x = ["x_1", "x_2"].map(|name| sheet.vector(name, Scope::Element));
        let variables: Vec<Expr<'_>> = x.iter().flat_map(|x| x.0).collect();
        let nodes = NodeVectors { first: 0, nodes: 2, components: 3 };
        let is = |f: Expr<'_>| is_invariant(&as_bound(&[f], &variables), &variables, &nodes);
        assert!(is((x[1] - x[0]).norm()) && !is(x[1].dot(x[0])));
    }
}
