//! A function to second order in variables and intermediates, of which one level is eliminated at a time.

use std::collections::BTreeMap;

use super::definition::Intermediate;
use super::known::Known;
use super::linear_images::LinearImages;
use crate::expr::{Expr, Mat3, Sheet, Vector, dot};
use crate::graph::{Op, RootId};

/// Derivatives by the variables.
#[derive(Clone, Debug)]
pub struct Derivatives<'g> {
    /// ∂E/∂x
    pub gradient: Vec<Expr<'g>>,
    /// ∂²E/∂x², packed lower triangle; empty if it was not asked for.
    pub hessian: Vec<Expr<'g>>,
}

/// Entries that are not zero, by the place of the symbol they belong to.
type Row<'g> = BTreeMap<usize, Expr<'g>>;

/// Σ q_k b_kl q_lᵀ
pub(super) struct Form<'g> {
    rows: Vec<Row<'g>>,
    matrix: Vec<Vec<Expr<'g>>>,
}

/// A function to second order: by variables, then by the intermediates that are left.
pub(super) struct Expansion<'g> {
    gradient: Row<'g>,
    /// row ≥ column; below unknowns whose values are known, all.
    second: BTreeMap<(usize, usize), Expr<'g>>,
    pub forms: Vec<Form<'g>>,
}

/// Products that add up to an entry.
type Terms<'g, K> = BTreeMap<K, Vec<(Expr<'g>, Expr<'g>)>>;

impl<'g> Expansion<'g> {
    pub fn new(function: Expr<'g>, symbols: &[Expr<'g>], with_second: bool) -> Self {
        let mut gradient = Row::new();
        let mut second = BTreeMap::new();
        for (row, &symbol) in symbols.iter().enumerate() {
            let by = function.by(symbol);
            insert(&mut gradient, row, by);
            for (column, &other) in symbols[..=row].iter().enumerate().filter(|_| with_second) {
                insert(&mut second, (row, column), by.by(other));
            }
        }
        Self { gradient, second, forms: Vec::new() }
    }

    /// The function of the symbols below a level, which begins at the place `first`.
    pub fn without(
        mut self,
        level: &[Intermediate<'g>],
        first: usize,
        below: &[Expr<'g>],
        with_second: bool,
        is_form: bool,
    ) -> Self {
        let sheet = level[0].symbol.sheet();
        let one = sheet.one();
        let c: Vec<Row<'g>> = level
            .iter()
            .map(|v| {
                let mut row = Row::new();
                match square_of_norm(v, below) {
                    // √q
                    Some(place) => insert(&mut row, place, slope_of_norm(v.symbol)),
                    None => {
                        below.iter().enumerate().for_each(|(j, &z)| insert(&mut row, j, v.definition.by(z)));
                    }
                }
                row
            })
            .collect();
        let adjoint = |k: usize| {
            let by = self.gradient.get(&(first + k)).copied().unwrap_or_else(|| sheet.zero());
            by.named(&format!("by_{}", level[k].symbol.symbol_name()))
        };
        let mut adjoints: Vec<Expr<'g>> = (0..level.len()).map(adjoint).collect();

        let mut gradient = Terms::new();
        for (&j, &by) in self.gradient.range(..first) {
            gradient.entry(j).or_default().push((by, one));
        }
        for (root, places) in roots(level) {
            let Some(equations) = weighted_equations(root, &places, level, &mut adjoints) else { continue };
            for (j, &z) in below.iter().enumerate() {
                gradient.entry(j).or_default().push((equations.by(z), one));
            }
            if with_second {
                self.add_second(equations, &places, level, first, below);
            }
        }
        let mut norms = Vec::new();
        for (k, v) in level.iter().enumerate() {
            let Some(place) = square_of_norm(v, below).filter(|_| !adjoints[k].is_zero()) else { continue };
            let limit = self.second_by(first + k).filter(|_| with_second);
            let ratio = ratio_to_norm(adjoints[k], v.symbol, limit);
            gradient.entry(place).or_default().push((ratio, sheet.number(0.5)));
            norms.push((place, ratio, c[k][&place]));
            adjoints[k] = sheet.zero();
        }
        for (row, &by) in c.iter().zip(&adjoints).filter(|(_, by)| !by.is_zero()) {
            for (&j, &x) in row {
                gradient.entry(j).or_default().push((by, x));
            }
        }
        let gradient = summed(gradient);
        if !with_second {
            return Self { gradient, second: BTreeMap::new(), forms: Vec::new() };
        }

        let mut forms: Vec<Form<'g>> = self.forms.iter().map(|form| form.below(&c, first)).collect();
        if is_form {
            forms.extend(self.form(&c, level, first));
        }
        let second = self.second_below(&c, (&adjoints, &norms), first, below, is_form);
        Self { gradient, second, forms }
    }

    /// The function of the symbols below unknowns whose values are known, in which it is stationary: its derivatives are the partial
    /// ones, of which the second ones are the total derivatives.
    pub fn without_known(
        self,
        known: &Known<'g>,
        unknowns: usize,
        below: &[Expr<'g>],
        with_second: bool,
    ) -> Self {
        let first = below.len();
        let gradient: Row<'g> = self.gradient.range(..first).map(|(&i, &x)| (i, x)).collect();
        if !with_second {
            return Self { gradient, second: BTreeMap::new(), forms: Vec::new() };
        }
        let values = known.values();
        let rates = known.rates(below);
        let entry = |i: usize, j: usize| self.second.get(&(i.max(j), i.min(j))).map(|x| x.at(&values));
        let mut terms = Terms::new();
        for i in 0..first {
            for j in 0..first {
                if let Some(own) = entry(i, j) {
                    terms.entry((i, j)).or_default().push((own, own.sheet().one()));
                }
            }
            for (k, rates) in (first..first + unknowns).zip(&rates) {
                let Some(mixed) = entry(k, i) else { continue };
                for (j, &rate) in rates.iter().enumerate().filter(|(_, rate)| !rate.is_zero()) {
                    terms.entry((i, j)).or_default().push((mixed, rate));
                }
            }
        }
        let gradient = gradient.into_iter().map(|(i, x)| (i, x.at(&values))).collect();
        Self { gradient, second: summed(terms), forms: Vec::new() }
    }

    /// Derivatives by the variables through vectors, whose entries have these places after `first`; none if something depends on the
    /// variables otherwise.
    pub fn through(
        &self,
        images: &LinearImages<'g>,
        vectors: &[[usize; 3]],
        first: usize,
        with_second: bool,
    ) -> Option<Derivatives<'g>> {
        let is_free = |&place: &usize| place >= first;
        if !self.gradient.keys().all(is_free) || !self.second.keys().all(|(i, j)| is_free(i) && is_free(j)) {
            return None;
        }
        let sheet = self.gradient.values().next()?.sheet();
        let by = |place: usize| self.gradient.get(&(first + place)).copied().unwrap_or_else(|| sheet.zero());
        let by_vector: Vec<_> = vectors.iter().map(|v| Vector(v.map(by))).collect();
        let gradient = images.gradient(&by_vector);
        if !with_second {
            return Some(Derivatives { gradient, hessian: Vec::new() });
        }
        let entry = |i: usize, j: usize| {
            let (i, j) = (first + i, first + j);
            let entry = self.second.get(&(i, j)).or_else(|| self.second.get(&(j, i)));
            entry.copied().unwrap_or_else(|| sheet.zero())
        };
        let block = |m: &[usize; 3], l: &[usize; 3]| Mat3::from_fn(|a, b| entry(m[a], l[b]));
        let second = vectors.iter().map(|m| vectors.iter().map(|l| block(m, l)).collect()).collect();
        Some(Derivatives { gradient, hessian: images.hessian(&second) })
    }

    /// Adds the second derivatives of μ·r by symbols below a level and by a root's unknowns, at these places of the level.
    fn add_second(
        &mut self,
        equations: Expr<'g>,
        places: &[usize],
        level: &[Intermediate<'g>],
        first: usize,
        below: &[Expr<'g>],
    ) {
        let own = places.iter().map(|&k| (first + k, level[k].symbol));
        let symbols: Vec<(usize, Expr<'g>)> = below.iter().copied().enumerate().chain(own).collect();
        for (row, &(i, x)) in symbols.iter().enumerate() {
            let by = equations.by(x);
            for &(j, y) in &symbols[..=row] {
                let (place, more) = ((i.max(j), i.min(j)), by.by(y));
                let entry = self.second.remove(&place).map_or(more, |entry| entry + more);
                insert(&mut self.second, place, entry);
            }
        }
    }

    /// K_zz + Cᵀ K_vv C + Cᵀ K_vz + K_zv C + Σ a_v ∂²f_v/∂z², the second term unless it is a form. `norms`: for each the place of its
    /// square, a/n and C.
    fn second_below(
        &self,
        c: &[Row<'g>],
        (adjoints, norms): (&[Expr<'g>], &[(usize, Expr<'g>, Expr<'g>)]),
        first: usize,
        below: &[Expr<'g>],
        is_form: bool,
    ) -> BTreeMap<(usize, usize), Expr<'g>> {
        let one = below[0].sheet().one();
        let entry = |i: usize, j: usize| self.second.get(&(i.max(j), i.min(j))).copied();
        // K_vz + K_vv C, by intermediate.
        let products: Vec<Row<'g>> = (0..c.len())
            .map(|k| {
                let mut terms = Terms::new();
                for j in 0..first {
                    if let Some(mixed) = entry(first + k, j) {
                        terms.entry(j).or_default().push((mixed, one));
                    }
                }
                for (l, row) in c.iter().enumerate().filter(|_| !is_form) {
                    let Some(own) = entry(first + k, first + l) else { continue };
                    for (&j, &x) in row {
                        terms.entry(j).or_default().push((own, x));
                    }
                }
                summed(terms)
            })
            .collect();
        let mut terms = Terms::new();
        let mut add = |i: usize, j: usize, x: Expr<'g>, y: Expr<'g>| {
            if i >= j && !x.is_zero() && !y.is_zero() {
                terms.entry((i, j)).or_default().push((x, y));
            }
        };
        for (&(i, j), &x) in self.second.iter().filter(|((i, _), _)| *i < first) {
            add(i, j, x, one);
        }
        for &(place, ratio, slope) in norms {
            add(place, place, -ratio, slope * slope);
        }
        for (k, row) in c.iter().enumerate() {
            for (&i, &x) in row {
                products[k].iter().for_each(|(&j, &y)| add(i, j, x, y));
                for (j, &z) in below[..=i].iter().enumerate().filter(|_| !adjoints[k].is_zero()) {
                    add(i, j, adjoints[k], x.by(z));
                }
            }
            for i in 0..first {
                let Some(mixed) = entry(first + k, i) else { continue };
                row.iter().for_each(|(&j, &x)| add(i, j, mixed, x));
            }
        }
        summed(terms)
    }

    /// The second derivative by the symbol at a place.
    fn second_by(&self, place: usize) -> Option<Expr<'g>> {
        let of_forms = self.forms.iter().flat_map(|form| {
            let scaled = form.scaled_rows();
            let at = |(row, scaled): (&Row<'g>, Row<'g>)| Some((*row.get(&place)?, *scaled.get(&place)?));
            form.rows.iter().zip(scaled).filter_map(at).collect::<Vec<_>>()
        });
        let of_forms = of_forms.map(|(x, y)| x * y);
        self.second.get(&(place, place)).copied().into_iter().chain(of_forms).reduce(|sum, x| sum + x)
    }

    /// K_vv and C as a form of their own.
    fn form(&self, c: &[Row<'g>], level: &[Intermediate<'g>], first: usize) -> Option<Form<'g>> {
        let entry = |k: usize, l: usize| {
            let (k, l) = (k.max(l), k.min(l));
            let zero = level[k].symbol.sheet().zero();
            let entry = self.second.get(&(first + k, first + l)).copied().unwrap_or(zero);
            let [k, l] = [k, l].map(|k| level[k].symbol.symbol_name());
            entry.named(&format!("by_{k}_{l}"))
        };
        let matrix: Vec<Vec<Expr<'g>>> =
            (0..c.len()).map(|k| (0..c.len()).map(|l| entry(k, l)).collect()).collect();
        let is_zero = matrix.iter().flatten().all(|x| x.is_zero());
        (!is_zero).then(|| Form { rows: c.to_vec(), matrix })
    }

    pub fn finish(self, sheet: &'g Sheet, variables: usize, with_second: bool) -> Derivatives<'g> {
        let zero = sheet.zero();
        let gradient = (0..variables).map(|i| self.gradient.get(&i).copied().unwrap_or(zero)).collect();
        if !with_second {
            return Derivatives { gradient, hessian: Vec::new() };
        }
        let mut terms = Terms::new();
        for (&place, &x) in self.second.iter().filter(|((i, j), _)| i >= j) {
            terms.entry(place).or_default().push((x, sheet.one()));
        }
        for form in &self.forms {
            for (row, scaled) in form.rows.iter().zip(form.scaled_rows()) {
                for (&i, &x) in row {
                    for (&j, &y) in scaled.range(..=i) {
                        terms.entry((i, j)).or_default().push((x, y));
                    }
                }
            }
        }
        let second = summed(terms);
        let places = (0..variables).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let hessian = places.map(|place| second.get(&place).copied().unwrap_or(zero)).collect();
        Derivatives { gradient, hessian }
    }
}

/// The place of the square that a norm is the root of, if it is one.
pub(super) fn square_of_norm(v: &Intermediate<'_>, below: &[Expr<'_>]) -> Option<usize> {
    match v.definition.operation() {
        Op::Sqrt(square) if v.symbol.is_norm_symbol() => below.iter().position(|z| z.id() == square),
        _ => None,
    }
}

/// Norms below are zero: the square of their reciprocal overflows.
const NO_NORM: f64 = 1e-150;

/// ∂n/∂q of n = √q, 0 where it is zero.
pub(super) fn slope_of_norm(norm: Expr<'_>) -> Expr<'_> {
    norm.sheet().number(NO_NORM).less(norm).select(0.5 * norm.reciprocal_or_zero(), 0.0)
}

/// a/n for the derivative a by a norm n. Where the norm is zero it is the limit, ∂a/∂n, held; without one 0.
pub(super) fn ratio_to_norm<'g>(adjoint: Expr<'g>, norm: Expr<'g>, limit: Option<Expr<'g>>) -> Expr<'g> {
    let sheet = norm.sheet();
    let or_zero = adjoint.div_or_zero(norm);
    limit.map_or(or_zero, |limit| {
        let limit = match limit.value() {
            Some(_) => limit,
            None => sheet.make(|g| g.bind_held("limit", limit.id())),
        };
        sheet.number(NO_NORM).less(norm).select(or_zero, limit)
    })
}

impl<'g> Form<'g> {
    /// q_z + Cᵀ q_v
    fn below(&self, c: &[Row<'g>], first: usize) -> Self {
        let below = |row: &Row<'g>| {
            let mut terms = Terms::new();
            for (&j, &x) in row {
                if j < first {
                    terms.entry(j).or_default().push((x, x.sheet().one()));
                } else if let Some(own) = c.get(j - first) {
                    own.iter().for_each(|(&j, &y)| terms.entry(j).or_default().push((x, y)));
                }
            }
            summed(terms)
        };
        Self { rows: self.rows.iter().map(below).collect(), matrix: self.matrix.clone() }
    }

    /// Σ_l b_kl q_l
    fn scaled_rows(&self) -> Vec<Row<'g>> {
        let scaled = |matrix: &Vec<Expr<'g>>| {
            let mut terms = Terms::new();
            for (&b, row) in matrix.iter().zip(&self.rows).filter(|(b, _)| !b.is_zero()) {
                for (&j, &x) in row {
                    terms.entry(j).or_default().push((b, x));
                }
            }
            summed(terms)
        };
        self.matrix.iter().map(scaled).collect()
    }
}

/// The roots all of whose unknowns are in a level, with the unknowns' places.
fn roots(level: &[Intermediate<'_>]) -> Vec<(RootId, Vec<usize>)> {
    let mut roots: BTreeMap<RootId, BTreeMap<u32, usize>> = BTreeMap::new();
    for (place, intermediate) in level.iter().enumerate() {
        if let Op::RootValue(root, component) = intermediate.definition.operation() {
            roots.entry(root).or_default().insert(component, place);
        }
    }
    let places =
        |(root, places): (RootId, BTreeMap<u32, usize>)| (root, places.into_values().collect::<Vec<_>>());
    let is_whole = |(root, places): &(RootId, Vec<usize>)| {
        let graph = level[0].symbol.sheet().graph();
        places.len() == graph.root(*root).unknowns.len()
    };
    roots.into_iter().map(places).filter(is_whole).collect()
}

/// μ·r of a root with its unknowns at these places of a level, with r_vᵀ μ = −a; sets their adjoints a to zero.
fn weighted_equations<'g>(
    root: RootId,
    places: &[usize],
    level: &[Intermediate<'g>],
    adjoints: &mut [Expr<'g>],
) -> Option<Expr<'g>> {
    if places.iter().all(|&k| adjoints[k].is_zero()) {
        return None;
    }
    let sheet = level[0].symbol.sheet();
    let root = sheet.graph().root(root).clone();
    let unknowns = root.unknowns.iter().map(|&unknown| sheet.symbol(unknown));
    let at: Vec<_> = unknowns.zip(places.iter().map(|&k| level[k].symbol)).collect();
    let transposed: Vec<Vec<Expr<'g>>> = (0..places.len())
        .map(|k| root.jacobian.iter().map(|row| sheet.expr(row[k]).at(&at)).collect())
        .collect();
    let minus: Vec<Expr<'g>> = places.iter().map(|&k| -adjoints[k]).collect();
    places.iter().for_each(|&k| adjoints[k] = sheet.zero());
    // Bound: constants of the derivatives that follow.
    let name = format!("by_equation_of_{}", root.name);
    let multipliers = sheet.solve_general(&name, &transposed, &minus);
    let multipliers = multipliers.iter().map(|x| sheet.make(|g| g.bind_unique(&name, x.id())));
    Some(dot(multipliers, root.residuals.iter().map(|&r| sheet.expr(r).at(&at))))
}

/// Sums of products; zeros are left out.
fn summed<'g, K: Ord + Copy>(terms: Terms<'g, K>) -> BTreeMap<K, Expr<'g>> {
    let mut sums = BTreeMap::new();
    for (place, products) in terms {
        let (x, y): (Vec<_>, Vec<_>) = products.into_iter().unzip();
        insert(&mut sums, place, dot(x, y));
    }
    sums
}

fn insert<'g, K: Ord>(into: &mut BTreeMap<K, Expr<'g>>, place: K, x: Expr<'g>) {
    if !x.is_zero() {
        into.insert(place, x);
    }
}
