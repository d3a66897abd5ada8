//! Derivatives by the positions of a few nodes, with as few operations as the ways tried take.
//!
//! A function of the differences of positions does not change with a translation: Σ_k ∂E/∂x_k = 0. Rows of one node then follow
//! from those of the others. That is found in the expressions, by moving all nodes by the position of the first: if nothing depends on it
//! any more, the function is one of differences. Vectors of several inputs may be nodes of one group, such as a slave and its masters. The
//! node that is left out is the one whose own rows take most operations.

use super::chain::{Chain, Way};
use super::direction::Direction;
use super::expansion::Derivatives;
use super::intermediates::{Written, as_bound, with_found};
use crate::expr::{Expr, Sheet, all_at, ids, total};
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

/// A group of nodes that the function does not depend on the place of, without one of them.
#[derive(Clone, Copy, Debug)]
struct Invariant {
    nodes: NodeVectors,
    left_out: usize,
}

/// A way to write a function, with its groups and the places of the variables that derivatives are taken by.
struct Writing<'g> {
    written: Written<'g>,
    invariant: Vec<Invariant>,
    free: Vec<usize>,
}

/// Gradient and, if asked for, Hessian of a function of element scope by all variables, through the intermediates it has.
pub fn total_derivatives<'g>(
    sheet: &'g Sheet,
    function: Expr<'g>,
    variables: &[Expr<'g>],
    nodes: &[NodeVectors],
    with_hessian: bool,
) -> Derivatives<'g> {
    let with_norms = if with_hessian { function.with_norm_symbols(variables) } else { function };
    let writings = writings(sheet, with_norms, variables, nodes);
    let cheapest = writings.iter().flat_map(|writing| {
        let ways = writing.ways(with_hessian);
        ways.into_iter()
            .map(|way| writing.derivatives(sheet, variables, with_hessian, way))
            .collect::<Vec<_>>()
    });
    let cheapest = cheapest.min_by_key(|derivatives| {
        let roots: Vec<ExprId> =
            derivatives.gradient.iter().chain(&derivatives.hessian).map(|x| x.id()).collect();
        sheet.graph().operations(&roots)
    });
    let mut cheapest = cheapest.expect("there is a first way");
    if with_norms != function {
        // As without the Hessian, which may be infinite where the gradient is zero.
        cheapest.gradient = total_derivatives(sheet, function, variables, nodes, false).gradient;
    }
    cheapest
}

/// The product of the Hessian with a direction, without the Hessian.
///
/// It is the rate of the gradient in the direction, forward over reverse, and the gradient of the function's rate, reverse over forward.
/// What takes fewer operations depends on the function. That of a function which is stationary in something has a rate for the first way
/// only: the second one would need what the first knows to be zero.
pub fn hessian_product<'g>(
    sheet: &'g Sheet,
    function: Expr<'g>,
    variables: &[Expr<'g>],
    direction: &[Expr<'g>],
    nodes: &[NodeVectors],
) -> Vec<Expr<'g>> {
    let rates = || variables.iter().copied().zip(direction.iter().copied());
    let with_norms = function.with_norm_symbols(variables);
    let has_norms = with_norms != function;
    let writings = writings(sheet, with_norms, variables, nodes);
    let forward_over_reverse = writings.iter().map(|writing| {
        // What is zero with a norm has a second derivative as its rate.
        let (chain, function) = (writing.chain(variables), writing.written.outputs[0]);
        let gradient = chain.derivatives(function, has_norms, Way::default()).gradient;
        let mut along = Direction::new(sheet, rates());
        let rates = gradient.into_iter().map(|x| along.derivative(x)).collect();
        // The sum of the gradient's rows vanishes whatever the positions are, so that of their rates does.
        writing.complete(sheet, rates, Vec::new(), variables.len()).gradient
    });
    let mut products: Vec<Vec<Expr<'g>>> = forward_over_reverse.collect();
    if writings[0].written.chain.known_values().is_empty() && !has_norms {
        let rate = Direction::new(sheet, rates()).derivative(function);
        products.push(total_derivatives(sheet, rate, variables, nodes, false).gradient);
    }
    let cheapest = products.into_iter().min_by_key(|product| sheet.graph().operations(&ids(product)));
    cheapest.expect("there is a first way")
}

/// The function as it is and with the intermediates that are found in it, with vectors of adjacent inputs as nodes of one group and
/// without.
fn writings<'g>(
    sheet: &'g Sheet,
    function: Expr<'g>,
    variables: &[Expr<'g>],
    nodes: &[NodeVectors],
) -> Vec<Writing<'g>> {
    let bound = as_bound(&[function], variables);
    let mut groupings = vec![invariant(&bound, variables, nodes)];
    let joined = joined(nodes);
    if joined != nodes {
        let joined = invariant(&bound, variables, &joined);
        // Groups that do not change one by one do not change together.
        if !joined.is_empty() {
            groupings.push(joined);
        }
    }
    let ways = [bound, with_found(sheet, &[function], variables)];
    let writing = |written: &Written<'g>, groups: &Vec<NodeVectors>| {
        let mut writing = Writing::new(written.clone(), variables.len(), groups);
        writing.leave_out_costliest(sheet, variables);
        writing
    };
    ways.iter().flat_map(|way| groupings.iter().map(move |groups| writing(way, groups))).collect()
}

/// Adjacent groups as one each.
fn joined(nodes: &[NodeVectors]) -> Vec<NodeVectors> {
    let mut joined: Vec<NodeVectors> = Vec::new();
    for &group in nodes {
        match joined.last_mut() {
            Some(last) if last.components == group.components && last.end() == group.first => {
                last.nodes += group.nodes;
            }
            _ => joined.push(group),
        }
    }
    joined
}

/// The groups that the function does not depend on the place of.
fn invariant<'g>(way: &Written<'g>, variables: &[Expr<'g>], nodes: &[NodeVectors]) -> Vec<NodeVectors> {
    nodes.iter().copied().filter(|group| is_invariant(way, variables, group)).collect()
}

impl NodeVectors {
    const fn end(&self) -> usize {
        self.first + self.nodes * self.components
    }
}

impl Invariant {
    const fn leaves_out(&self, place: usize) -> bool {
        let first = self.place(self.left_out, 0);
        place >= first && place < first + self.nodes.components
    }

    const fn place(&self, node: usize, component: usize) -> usize {
        self.nodes.first + node * self.nodes.components + component
    }

    /// Places of a component of the other nodes.
    fn others(&self, component: usize) -> impl Iterator<Item = usize> {
        let nodes = (0..self.nodes.nodes).filter(|&node| node != self.left_out);
        nodes.map(move |node| self.place(node, component))
    }
}

/// Whether nothing changes when all nodes move by the position of the first.
fn is_invariant<'g>(way: &Written<'g>, variables: &[Expr<'g>], group: &NodeVectors) -> bool {
    if group.nodes < 2 {
        return false;
    }
    let first = &variables[group.first..group.first + group.components];
    let moved: Vec<(Expr<'g>, Expr<'g>)> = (group.first + group.components..group.end())
        .map(|place| (variables[place], variables[place] + first[(place - group.first) % group.components]))
        .collect();
    let stays = |piece: Expr<'g>| {
        let piece = piece.at(&moved);
        first.iter().all(|&x| !piece.contains(x))
    };
    let definitions = way.chain.intermediates().map(|v| v.definition);
    // Nodes are not moved within equations: these are pieces of their own.
    definitions
        .chain(way.outputs.iter().copied())
        .all(|piece| stays(piece) && piece.equations().into_iter().all(stays))
}

impl<'g> Writing<'g> {
    fn new(written: Written<'g>, count: usize, groups: &[NodeVectors]) -> Self {
        let invariant = groups.iter().map(|&nodes| Invariant { nodes, left_out: 0 }).collect();
        let mut writing = Self { written, invariant, free: Vec::new() };
        writing.set_free(count);
        writing
    }

    fn set_free(&mut self, count: usize) {
        let is_free = |place: &usize| !self.invariant.iter().any(|group| group.leaves_out(*place));
        self.free = (0..count).filter(is_free).collect();
    }

    /// Leaves the node out of each group whose rows of the gradient take most operations by themselves.
    fn leave_out_costliest(&mut self, sheet: &'g Sheet, variables: &[Expr<'g>]) {
        if self.invariant.is_empty() {
            return;
        }
        let chain = self.written.chain.with_variables(variables.to_vec());
        let gradient = chain.derivatives(self.written.outputs[0], false, Way::default()).gradient;
        for group in &mut self.invariant {
            let cost = |&node: &usize| {
                let places = (0..group.nodes.components).map(|component| group.place(node, component));
                let rows: Vec<ExprId> = places.map(|place| gradient[place].id()).collect();
                sheet.graph().operations(&rows)
            };
            // The first of several, for the order of the result.
            group.left_out = (0..group.nodes.nodes).rev().max_by_key(cost).unwrap_or(0);
        }
        self.set_free(variables.len());
    }

    /// The ways to eliminate its intermediates: of a gradient, those that differ for one.
    fn ways(&self, with_hessian: bool) -> Vec<Way> {
        let ways = self.written.chain.ways();
        if with_hessian { ways } else { vec![Way::default()] }
    }

    fn chain(&self, variables: &[Expr<'g>]) -> Chain<'g> {
        self.written.chain.with_variables(self.free.iter().map(|&place| variables[place]).collect())
    }

    /// The derivatives by all variables.
    fn derivatives(
        &self,
        sheet: &'g Sheet,
        variables: &[Expr<'g>],
        with_hessian: bool,
        way: Way,
    ) -> Derivatives<'g> {
        let chain = self.chain(variables);
        let Derivatives { gradient, hessian } = chain.derivatives(self.written.outputs[0], with_hessian, way);
        let gradient = all_at(&gradient, &chain.known_values());
        self.complete(sheet, gradient, hessian, variables.len())
    }

    /// The derivatives by all variables from those by the free ones.
    fn complete(
        &self,
        sheet: &'g Sheet,
        by_free: Vec<Expr<'g>>,
        hessian: Vec<Expr<'g>>,
        count: usize,
    ) -> Derivatives<'g> {
        let free = &self.free;
        let mut gradient = vec![sheet.zero(); count];
        free.iter().zip(by_free).for_each(|(&place, x)| gradient[place] = x);
        let components =
            |group: &Invariant| (0..group.nodes.components).map(|c| (*group, c)).collect::<Vec<_>>();
        let held: Vec<(Invariant, usize)> = self.invariant.iter().flat_map(components).collect();
        for (group, component) in &held {
            let others = group.others(*component).map(|other| gradient[other]);
            gradient[group.place(group.left_out, *component)] = -total(others);
        }
        if hessian.is_empty() {
            return Derivatives { gradient, hessian };
        }

        let mut matrix = vec![vec![sheet.zero(); count]; count];
        let mut entries = hessian.iter();
        for (row, &i) in free.iter().enumerate() {
            for (&j, &x) in free[..=row].iter().zip(&mut entries) {
                (matrix[i][j], matrix[j][i]) = (x, x);
            }
        }
        let mut known = free.clone();
        for (group, component) in &held {
            let place = group.place(group.left_out, *component);
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
