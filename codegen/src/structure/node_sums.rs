//! First and second derivatives of a function that is given through sums over the nodes and unknowns of equations.
//!
//! Variables are z of the element and x of each node. A function E(z, u) depends on intermediates u, one group after another:
//!
//! * u = f(z, u′), or u = Σᵢ f(xᵢ, z, u′), of those u′ before it;
//! * unknowns u of r(u, z, u′, x) = 0, r a sum over the nodes too.
//!
//! Groups are eliminated from the last to the first. With the adjoint a of u and ℓ = a·f, or ℓ = μ·r where r_uᵀ μ = −a,
//!
//! ```text
//! du = G dy + Σᵢ Bᵢ dxᵢ      y = (z, u′),  G = f_y, Bᵢ = ∂f/∂xᵢ,  or  G = −r_u⁻¹ r_y, Bᵢ = −r_u⁻¹ ∂r/∂xᵢ
//! ```
//!
//! What ℓ has of second derivatives is added to those of E; a sum's terms depend on one node each, so no ∂²ℓ/∂xᵢ∂xⱼ is left but for
//! i = j. Then du is put in. Products of Bᵢ stay products of low rank:
//!
//! ```text
//! d²E/dxᵢdxⱼ = δᵢⱼ Dᵢ + Σ_k b_kᵢᵀ c_kⱼ + c_kᵢᵀ b_kⱼ
//! ```
//!
//! with a row b_k for each sum, and for each unknown. The terms of sums that only enter equations have none.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use rustc_hash::FxHashMap;

use super::definition::Intermediate;
use super::elimination::Elimination;
use super::expansion::{ratio_to_norm, slope_of_norm, square_of_norm};
use crate::expr::{Expr, Sheet, dot};
use crate::graph::{ExprId, Graph, Op};

/// Unknowns of equations, the equations written in the unknowns.
#[derive(Clone, Debug)]
pub struct Implicit<'g> {
    /// Symbols that have the unknowns' values.
    pub unknowns: Vec<Expr<'g>>,
    /// r, linear in sums over the nodes.
    pub equations: Vec<Expr<'g>>,
    /// r_u
    pub jacobian: Elimination<'g>,
}

/// Derivatives of a function.
#[derive(Clone, Debug)]
pub struct NodeDerivatives<'g> {
    /// ∂E/∂z
    pub element: Vec<Expr<'g>>,
    /// ∂E/∂x of a node.
    pub node: Vec<Expr<'g>>,
    /// Second derivatives, if they were asked for.
    pub second: Option<NodeSecond<'g>>,
}

/// Second derivatives of a function.
#[derive(Clone, Debug)]
pub struct NodeSecond<'g> {
    /// By z, packed lower triangle.
    pub element: Vec<Expr<'g>>,
    /// Row of a node's variable, column of z.
    pub mixed: Vec<Vec<Expr<'g>>>,
    /// D, packed lower triangle.
    pub own: Vec<Expr<'g>>,
    /// b and c of each product.
    pub rows: Vec<[Vec<Expr<'g>>; 2]>,
}

/// Derivatives that are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// First ones.
    First,
    /// First ones, of which derivatives are taken.
    Differentiated,
    /// First and second ones.
    Second,
}

/// A function depends on the nodes in another way than through sums.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoSum {
    /// Name of the symbol, if it is not the function itself.
    pub symbol: Option<String>,
}

/// Intermediates that are eliminated at a time.
enum Group<'g> {
    Explicit { symbol: Expr<'g>, definition: Expr<'g> },
    Implicit(Implicit<'g>),
}

/// A function to second order in what is not eliminated yet, by places, and in the variables of a node.
struct Expansion<'g> {
    gradient: BTreeMap<usize, Expr<'g>>,
    node: Vec<Expr<'g>>,
    /// row ≥ column
    second: BTreeMap<(usize, usize), Expr<'g>>,
    /// ∂²/∂x∂y by the place of y.
    mixed: BTreeMap<usize, Vec<Expr<'g>>>,
    own: Vec<Expr<'g>>,
    products: Vec<Product<'g>>,
}

/// 2 (b·dx) (c·dx + c_y·dy)
struct Product<'g> {
    b: Vec<Expr<'g>>,
    c: Vec<Expr<'g>>,
    below: BTreeMap<usize, Expr<'g>>,
}

/// What is differentiated by.
struct Variables<'a, 'g> {
    sheet: &'g Sheet,
    node: &'a [Expr<'g>],
    with_second: bool,
}

/// Derivatives of a function of element scope by variables of the element and of a node.
pub fn node_derivatives<'g>(
    function: Expr<'g>,
    (element, node): (&[Expr<'g>], &[Expr<'g>]),
    implicit: &[Implicit<'g>],
    asked: Asked,
) -> Result<NodeDerivatives<'g>, NoSum> {
    let with_norms = match asked {
        Asked::First => function,
        _ => function.with_norm_symbols(&[element, node].concat()),
    };
    let found = derivatives_of(with_norms, (element, node), implicit, asked != Asked::First)?;
    if asked != Asked::Second || with_norms == function {
        return Ok(found);
    }
    // As without second derivatives, which may be infinite where the first ones are zero.
    let NodeDerivatives { element, node, .. } = derivatives_of(function, (element, node), implicit, false)?;
    Ok(NodeDerivatives { element, node, ..found })
}

fn derivatives_of<'g>(
    function: Expr<'g>,
    (element, node): (&[Expr<'g>], &[Expr<'g>]),
    implicit: &[Implicit<'g>],
    with_second: bool,
) -> Result<NodeDerivatives<'g>, NoSum> {
    let sheet = function.sheet();
    let variables = Variables { sheet, node, with_second };
    let groups = groups(function, element, node, implicit);
    if node.iter().any(|&x| !function.by(x).is_zero()) {
        return Err(NoSum { symbol: None });
    }
    let symbols: Vec<Expr<'g>> =
        element.iter().copied().chain(groups.iter().flat_map(Group::symbols)).collect();
    let mut expansion = Expansion::new(function, &symbols, &variables);
    let mut above = symbols.len();
    for group in groups.iter().rev() {
        let first = above - group.symbols().len();
        expansion.eliminate(group, (&symbols, first), &variables)?;
        above = first;
    }
    Ok(expansion.finish(&variables, element.len()))
}

/// The intermediates through which a function depends on variables, each group after those it depends on.
fn groups<'g>(
    function: Expr<'g>,
    element: &[Expr<'g>],
    node: &[Expr<'g>],
    implicit: &[Implicit<'g>],
) -> Vec<Group<'g>> {
    let sheet = function.sheet();
    let graph = sheet.graph();
    let mut order =
        Order { sheet, graph: &graph, implicit, varies: FxHashMap::default(), groups: Vec::new() };
    order.varies.extend(element.iter().chain(node).map(|x| (x.id(), true)));
    order.visit(function.id());
    order.groups
}

struct Order<'a, 'g> {
    sheet: &'g Sheet,
    graph: &'a Graph,
    implicit: &'a [Implicit<'g>],
    varies: FxHashMap<ExprId, bool>,
    groups: Vec<Group<'g>>,
}

impl Order<'_, '_> {
    /// Whether an expression depends on variables; lists the groups below it.
    fn visit(&mut self, expr: ExprId) -> bool {
        if let Some(&known) = self.varies.get(&expr) {
            return known;
        }
        let of = |group: &&Implicit<'_>| group.unknowns.iter().any(|x| x.id() == expr);
        let group = self.implicit.iter().find(of);
        let members =
            group.map_or_else(|| vec![expr], |group| group.unknowns.iter().map(|x| x.id()).collect());
        let mut any = false;
        for member in &members {
            for x in self.graph.varying_dependencies(*member) {
                any |= self.visit(x);
            }
        }
        self.varies.extend(members.into_iter().map(|member| (member, any)));
        let is_bound = matches!(self.graph.op(expr), Op::Symbol(symbol) if self.graph.symbol_data(symbol).definition.is_some());
        match group {
            Some(group) if any => self.groups.push(Group::Implicit(group.clone())),
            None if any && is_bound => {
                let definition = self.sheet.expr(self.graph.dependencies(expr)[0]);
                self.groups.push(Group::Explicit { symbol: self.sheet.expr(expr), definition });
            }
            _ => {}
        }
        any
    }
}

impl<'g> Group<'g> {
    fn symbols(&self) -> Vec<Expr<'g>> {
        match self {
            Self::Explicit { symbol, .. } => vec![*symbol],
            Self::Implicit(implicit) => implicit.unknowns.clone(),
        }
    }

    /// The place of the square, if it is a norm.
    fn square_of_norm(&self, symbols: &[Expr<'g>]) -> Option<usize> {
        match self {
            Self::Explicit { symbol, definition } => {
                square_of_norm(&Intermediate { symbol: *symbol, definition: *definition }, symbols)
            }
            Self::Implicit(_) => None,
        }
    }

    /// a·f or μ·r, with a or μ a constant for the derivatives that follow.
    fn weighted(&self, adjoint: &[Expr<'g>]) -> Expr<'g> {
        let sheet = adjoint[0].sheet();
        let held = |x: Expr<'g>, name: &str| match x.value() {
            Some(_) => x,
            None => sheet.make(|g| g.bind_unique(name, x.id())),
        };
        match self {
            _ if adjoint.iter().all(|x| x.is_zero()) => sheet.zero(),
            Self::Explicit { symbol, definition } => {
                held(adjoint[0], &format!("by_{}", symbol.symbol_name())) * *definition
            }
            Self::Implicit(implicit) => {
                let minus: Vec<Expr<'g>> = adjoint.iter().map(|&x| -x).collect();
                let multipliers = implicit.jacobian.solve(&minus, true).into_iter();
                let name = |k: usize| format!("multiplier_{}", implicit.unknowns[k].symbol_name());
                let multipliers = multipliers.enumerate().map(|(k, x)| held(x, &name(k)));
                dot(multipliers, &implicit.equations)
            }
        }
    }

    /// du/dy for a variable y held neither in f nor in r.
    fn slope(&self, y: Expr<'g>) -> Vec<Expr<'g>> {
        match self {
            Self::Explicit { definition, .. } => vec![definition.by(y)],
            Self::Implicit(implicit) => {
                let minus: Vec<Expr<'g>> = implicit.equations.iter().map(|r| -r.by(y)).collect();
                implicit.jacobian.solve(&minus, false)
            }
        }
    }

    /// Whether the dependence on the nodes is that of one sum, or of equations that are linear in sums.
    fn check(&self, node: &[Expr<'g>]) -> Result<(), NoSum> {
        // A derivative by a node's variables is that of the terms that belong to it, which shows no sum within a sum.
        let varies = |sum: Expr<'_>| node.iter().any(|&x| sum.contains(x));
        let is_linear = |r: &Expr<'g>| {
            sums_in(*r).into_iter().all(|sum| !has_within(sum, varies))
                && node.iter().all(|&x| sums_in(r.by(x)).is_empty())
        };
        let (symbol, is_sum) = match self {
            Self::Explicit { symbol, definition } => {
                let is_free = node.iter().all(|&x| definition.by(x).is_zero());
                (symbol, is_free || (matches!(definition.operation(), Op::Sum(_)) && is_linear(definition)))
            }
            Self::Implicit(Implicit { unknowns, equations, .. }) => {
                (&unknowns[0], equations.iter().all(is_linear))
            }
        };
        if is_sum { Ok(()) } else { Err(NoSum { symbol: Some(symbol.symbol_name()) }) }
    }
}

/// The sums over the nodes that are part of an expression, definitions not entered, in ascending order.
pub(crate) fn sums_in(expr: Expr<'_>) -> Vec<Expr<'_>> {
    let graph = expr.sheet().graph();
    let mut sums = graph.reachable(expr.id(), Graph::operands);
    sums.retain(|&x| matches!(graph.op(x), Op::Sum(_)));
    sums.sort_unstable();
    expr.sheet().exprs(sums)
}

/// Whether a sum stands within this one that fulfils a condition.
pub(crate) fn has_within(sum: Expr<'_>, condition: impl Fn(Expr<'_>) -> bool) -> bool {
    sums_in(sum).into_iter().any(|inner| inner != sum && condition(inner))
}

impl<'g> Expansion<'g> {
    fn new(function: Expr<'g>, symbols: &[Expr<'g>], variables: &Variables<'_, 'g>) -> Self {
        let (zero, count) = (variables.sheet.zero(), variables.node.len());
        let mut expansion = Self {
            gradient: BTreeMap::new(),
            node: vec![zero; count],
            second: BTreeMap::new(),
            mixed: BTreeMap::new(),
            own: vec![zero; count * (count + 1) / 2],
            products: Vec::new(),
        };
        expansion.add_element(function, &symbols.iter().copied().enumerate().collect::<Vec<_>>(), variables);
        expansion
    }

    /// Adds the derivatives of a function by symbols, which have places.
    fn add_element(
        &mut self,
        function: Expr<'g>,
        symbols: &[(usize, Expr<'g>)],
        variables: &Variables<'_, 'g>,
    ) {
        for (k, &(i, x)) in symbols.iter().enumerate() {
            let by = function.by(x);
            add(&mut self.gradient, i, by);
            for &(j, y) in symbols[..=k].iter().filter(|_| variables.with_second) {
                add(&mut self.second, (i.max(j), i.min(j)), by.by(y));
            }
        }
    }

    /// Adds those by the variables of a node.
    fn add_node(&mut self, function: Expr<'g>, symbols: &[(usize, Expr<'g>)], variables: &Variables<'_, 'g>) {
        for (a, &x) in variables.node.iter().enumerate() {
            let by = function.by(x);
            self.node[a] += by;
            if !variables.with_second || by.is_zero() {
                continue;
            }
            for (b, &other) in variables.node[..=a].iter().enumerate() {
                self.own[a * (a + 1) / 2 + b] += by.by(other);
            }
            for &(j, y) in symbols {
                self.add_mixed(j, a, by.by(y), variables);
            }
        }
    }

    fn add_mixed(&mut self, place: usize, a: usize, x: Expr<'g>, variables: &Variables<'_, 'g>) {
        if !x.is_zero() {
            let zeros = || vec![variables.sheet.zero(); variables.node.len()];
            self.mixed.entry(place).or_insert_with(zeros)[a] += x;
        }
    }

    /// Puts the intermediates of a group, the last ones from the place `first` on, in terms of what is below them.
    fn eliminate(
        &mut self,
        group: &Group<'g>,
        (symbols, first): (&[Expr<'g>], usize),
        variables: &Variables<'_, 'g>,
    ) -> Result<(), NoSum> {
        group.check(variables.node)?;
        let members = group.symbols();
        let zero = variables.sheet.zero();
        let adjoint: Vec<Expr<'g>> =
            (0..members.len()).map(|k| self.gradient.remove(&(first + k)).unwrap_or(zero)).collect();
        if let Some(square) = group.square_of_norm(symbols) {
            self.eliminate_norm((members[0], first), adjoint[0], square, variables);
            return Ok(());
        }
        let weighted = group.weighted(&adjoint);
        let all: Vec<(usize, Expr<'g>)> =
            symbols[..first + members.len()].iter().copied().enumerate().collect();
        // What is below decides the gradient, the members themselves the second derivatives too.
        if !weighted.is_zero() {
            self.add_element(weighted, &all, variables);
            self.add_node(weighted, &all, variables);
            self.gradient.retain(|&place, _| place < first);
        }
        if !variables.with_second {
            return Ok(());
        }
        let slopes: BTreeMap<usize, Vec<Expr<'g>>> = all[..first]
            .iter()
            .map(|&(j, y)| (j, group.slope(y)))
            .filter(|(_, slope)| slope.iter().any(|x| !x.is_zero()))
            .collect();
        let direct: Vec<Vec<Expr<'g>>> = variables.node.iter().map(|&x| group.slope(x)).collect();
        let b: Vec<Vec<Expr<'g>>> = members
            .iter()
            .enumerate()
            .map(|(k, symbol)| {
                let name = format!("b_{}", symbol.symbol_name());
                direct.iter().map(|slope| slope[k].named(&name)).collect()
            })
            .collect();
        self.put_in(&Substitution { first, slopes, b, members }, variables);
        Ok(())
    }

    /// Puts a norm n = √q in terms of its square.
    fn eliminate_norm(
        &mut self,
        (norm, first): (Expr<'g>, usize),
        adjoint: Expr<'g>,
        place: usize,
        variables: &Variables<'_, 'g>,
    ) {
        let zero = variables.sheet.zero();
        let own = variables.with_second.then(|| self.second.get(&(first, first)).copied().unwrap_or(zero));
        let ratio = ratio_to_norm(adjoint, norm, own);
        add(&mut self.gradient, place, 0.5 * ratio);
        if !variables.with_second {
            return;
        }
        let slope = slope_of_norm(norm);
        add(&mut self.second, (place, place), -(ratio * (slope * slope)));
        let b = vec![vec![zero; variables.node.len()]];
        let slopes = BTreeMap::from([(place, vec![slope])]);
        self.put_in(&Substitution { first, slopes, b, members: vec![norm] }, variables);
    }

    /// du = G dy + b·dx
    fn put_in(&mut self, by: &Substitution<'g>, variables: &Variables<'_, 'g>) {
        let Substitution { first, slopes, b, members } = by;
        let (first, count, zero) = (*first, members.len(), variables.sheet.zero());
        let own = |k: usize, l: usize| (first + k.max(l), first + k.min(l));
        let k_uu: Vec<Vec<Expr<'g>>> = (0..count)
            .map(|k| (0..count).map(|l| self.second.get(&own(k, l)).copied().unwrap_or(zero)).collect())
            .collect();
        let c_u: Vec<Option<Vec<Expr<'g>>>> = (0..count).map(|k| self.mixed.remove(&(first + k))).collect();
        let k_uy: Vec<BTreeMap<usize, Expr<'g>>> = (0..count)
            .map(|k| {
                let row = self.second.range((first + k, 0)..(first + k, first));
                row.map(|(&(_, j), &x)| (j, x)).collect()
            })
            .collect();
        self.second.retain(|&(row, _), _| row < first);

        // K_uy + K_uu G
        let mut k_total = k_uy.clone();
        for (&j, slope) in slopes {
            for k in 0..count {
                add(&mut k_total[k], j, dot(&k_uu[k], slope));
            }
        }
        for (&i, slope) in slopes {
            for k in 0..count {
                for (&j, &x) in k_total[k].range(..=i) {
                    add(&mut self.second, (i, j), slope[k] * x);
                }
                for (&j, &x) in &k_uy[k] {
                    // Gᵀ K_uy has its transposed beside it.
                    if i <= j {
                        add(&mut self.second, (j, i), slope[k] * x);
                    }
                }
            }
            for (k, row) in c_u.iter().enumerate() {
                for (a, &x) in row.iter().flatten().enumerate() {
                    self.add_mixed(i, a, slope[k] * x, variables);
                }
            }
        }
        for product in &mut self.products {
            let of_members: Vec<Expr<'g>> =
                (0..count).map(|k| product.below.remove(&(first + k)).unwrap_or(zero)).collect();
            for (&j, slope) in slopes {
                add(&mut product.below, j, dot(&of_members, slope));
            }
            for (k, &x) in of_members.iter().enumerate() {
                product.c.iter_mut().zip(&b[k]).for_each(|(c, &b)| *c += x * b);
            }
        }
        for (k, row) in b.iter().enumerate().filter(|(_, row)| row.iter().any(|x| !x.is_zero())) {
            let mut c = c_u[k].clone().unwrap_or_else(|| vec![zero; row.len()]);
            for (l, other) in b[..=k].iter().enumerate() {
                let factor = if l == k { 0.5 * k_uu[k][k] } else { k_uu[k][l] };
                c.iter_mut().zip(other).for_each(|(c, &b)| *c += factor * b);
            }
            self.products.push(Product { b: row.clone(), c, below: k_total[k].clone() });
        }
    }

    fn finish(self, variables: &Variables<'_, 'g>, count: usize) -> NodeDerivatives<'g> {
        let zero = variables.sheet.zero();
        let element = (0..count).map(|k| self.gradient.get(&k).copied().unwrap_or(zero)).collect();
        if !variables.with_second {
            return NodeDerivatives { element, node: self.node, second: None };
        }
        let packed = (0..count).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let mixed_entry = |a: usize, j: usize| {
            let start = self.mixed.get(&j).map_or(zero, |column| column[a]);
            let products = self.products.iter().filter_map(|p| Some(*p.below.get(&j)? * p.b[a]));
            products.fold(start, |sum, product| sum + product)
        };
        let mixed = (0..variables.node.len()).map(|a| (0..count).map(|j| mixed_entry(a, j)).collect());
        let is_used = |p: &&Product<'g>| p.c.iter().any(|x| !x.is_zero());
        let rows = self.products.iter().filter(is_used).map(|p| [p.b.clone(), p.c.clone()]);
        let second = NodeSecond {
            element: packed.map(|place| self.second.get(&place).copied().unwrap_or(zero)).collect(),
            mixed: mixed.collect(),
            rows: rows.collect(),
            own: self.own,
        };
        NodeDerivatives { element, node: self.node, second: Some(second) }
    }
}

/// du of a group.
struct Substitution<'g> {
    first: usize,
    /// G, columns by place.
    slopes: BTreeMap<usize, Vec<Expr<'g>>>,
    /// Rows.
    b: Vec<Vec<Expr<'g>>>,
    members: Vec<Expr<'g>>,
}

fn add<'g, K: Ord>(into: &mut BTreeMap<K, Expr<'g>>, place: K, x: Expr<'g>) {
    if x.is_zero() {
        return;
    }
    match into.entry(place) {
        Entry::Vacant(entry) => {
            entry.insert(x);
        }
        Entry::Occupied(mut entry) => *entry.get_mut() += x,
    }
}
