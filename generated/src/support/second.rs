//! Second derivatives of an element, as a Hessian or as the factors it is made of, and the product of factors with a vector.
//!
//! A Hessian of 3(n+1) rows has low rank off its diagonal, M = Σ cᵀb + bᵀc plus the nodes' own blocks, and is invariant under
//! translations. So of v only the differences from the slave's part count, and the slave's part of M v is the negative sum of the nodes':
//! the factors are those of the nodes. They take 3 r + 6 numbers for each node, r rows, where the packed Hessian takes 9/2 n, and the
//! product 6 r + 9 multiplications instead of 9 n.
//!
//! # Order
//! For each node the x of all rows b₀, c₀, b₁, c₁, …, their y, their z; then the lower triangle of its own block.

use super::simd::{MOST_LANES, Placed, Vector, WithLanes};
use super::{FormRows, Isa};

/// What is asked for of a second derivative.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SecondKind {
    /// Packed lower triangles.
    Hessians,
    /// The factors that these are made of.
    Factors,
    /// First derivatives at the foot, [`FormRows::foot_numbers`]. A kernel leaves the factors, and coefficients that make them of these.
    FactorsAndFoot,
    /// The slave's rows of M, 3(n+1) entries each: the derivatives of ∂g/∂x of the slave, in whose direction forces act.
    SlaveRows,
}

/// Where second derivatives go, one after another.
#[derive(Debug)]
pub struct Second<'a, O> {
    kind: SecondKind,
    target: &'a mut [O],
    written: usize,
    /// Where Hessians go instead, of elements side by side.
    placed: Option<Placed<'a>>,
}

impl<'a, O> Second<'a, O> {
    /// To be written to `target`.
    #[inline(always)]
    pub const fn new(kind: SecondKind, target: &'a mut [O]) -> Self {
        Self { kind, target, written: 0, placed: None }
    }

    /// Hessians to be written to their places.
    #[inline(always)]
    pub(super) fn placed(placed: Placed<'a>) -> Self {
        Self { kind: SecondKind::Hessians, target: &mut [], written: 0, placed: Some(placed) }
    }

    /// The places of the next Hessian, over slave and `count` nodes.
    ///
    /// # Panics
    /// If Hessians do not go to places, or there is no room.
    #[inline(always)]
    pub(super) fn next_placed(&mut self, count: usize) -> Placed<'a> {
        self.placed.as_mut().expect("elements side by side have places").next(count)
    }

    /// What is asked for.
    #[inline(always)]
    pub const fn kind(&self) -> SecondKind {
        self.kind
    }

    /// The place of the next one.
    ///
    /// # Panics
    /// If it is too short.
    #[inline(always)]
    pub fn next(&mut self, length: usize) -> &mut [O] {
        let start = self.written;
        self.written += length;
        &mut self.target[start..start + length]
    }

    /// The places of the next two.
    ///
    /// # Panics
    /// If they are too short.
    #[inline(always)]
    pub(super) fn next_two(&mut self, [length, other]: [usize; 2]) -> [&mut [O]; 2] {
        let (first, second) = self.next(length + other).split_at_mut(length);
        [first, second]
    }

    /// The last numbers of all.
    ///
    /// # Panics
    /// If there are fewer.
    #[inline(always)]
    pub fn last(&mut self, length: usize) -> &mut [O] {
        let start = self.target.len() - length;
        &mut self.target[start..]
    }

    /// All of it.
    #[inline(always)]
    pub(super) fn into_target(self) -> &'a mut [O] {
        self.target
    }
}

/// Most vectors of rows whose sums stay in registers.
const GROUP: usize = 4;
/// Nodes whose rows are multiplied at once.
const NODES: usize = 4;
/// Rows of the largest basis with its outer unknowns, in full vectors.
pub(super) const MOST_ROWS: usize = 64;

impl FormRows {
    /// The factors of a node.
    #[inline(always)]
    fn of_node(self, node: usize, factors: &[f64]) -> &[f64] {
        &factors[self.node_factors() * node..][..self.node_factors()]
    }

    /// `product` = M v from the factors of M. Both have 3(n+1) entries, the slave's first. `isa`: [`Isa::best`] unless there is
    /// a reason for another.
    ///
    /// # Panics
    /// If a slice is shorter than the rows say, or there are more than 64 rows.
    pub fn multiply_factors(self, isa: Isa, factors: &[f64], v: &[f64], product: &mut [f64]) {
        let freedoms = 3 * (self.count + 1);
        let code = Product {
            rows: self,
            factors: &factors[..self.factors()],
            v: &v[..freedoms],
            product: &mut product[..freedoms],
        };
        match self.rows {
            // The quadratic basis: in a frame that is held, in one that moves, and with domains of nodes.
            12 => in_fours(isa, Unrolled::<12>(code)),
            18 => isa.run(Unrolled::<18>(code)),
            28 => isa.run(Unrolled::<28>(code)),
            // Vectors of eight are mostly empty.
            ..16 => in_fours(isa, Unrolled::<0>(code)),
            _ => isa.run(Unrolled::<0>(code)),
        }
    }

    /// The diagonal of M from its factors, 3(n+1) entries.
    ///
    /// # Panics
    /// If a slice is shorter than the rows say.
    pub fn factors_diagonal(self, factors: &[f64], diagonal: &mut [f64]) {
        let pairs = |rows: &[f64]| 2.0 * rows.chunks_exact(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
        let mut sums = vec![0.0; 3 * self.rows];
        let mut own_sum = [0.0; 3];
        for node in 0..self.count {
            let factors = &factors[self.node_factors() * node..][..self.node_factors()];
            let own = &factors[3 * self.rows..];
            for axis in 0..3 {
                let rows = &factors[self.rows * axis..][..self.rows];
                let block = own[[0, 2, 5][axis]];
                diagonal[3 * (node + 1) + axis] = block + pairs(rows);
                own_sum[axis] += block;
                for (sum, row) in sums[self.rows * axis..].iter_mut().zip(rows) {
                    *sum += row;
                }
            }
        }
        for axis in 0..3 {
            diagonal[axis] = own_sum[axis] + pairs(&sums[self.rows * axis..][..self.rows]);
        }
    }
}

/// Runs code with vectors of four numbers at most.
fn in_fours<W: WithLanes>(isa: Isa, code: W) -> W::Output {
    isa.run_four(code).unwrap_or_else(|code| code.run::<f64>())
}

struct Product<'a> {
    rows: FormRows,
    factors: &'a [f64],
    v: &'a [f64],
    product: &'a mut [f64],
}

/// A product whose number of rows the compiler knows; 0: any.
struct Unrolled<'a, const ROWS: usize>(Product<'a>);

impl<const ROWS: usize> WithLanes for Unrolled<'_, ROWS> {
    type Output = ();

    #[inline(always)]
    fn run<T: Vector>(self) {
        let Self(mut code) = self;
        if ROWS > 0 {
            code.rows.rows = ROWS;
        }
        code.multiply::<T>();
    }
}

impl Product<'_> {
    #[inline(always)]
    fn multiply<T: Vector>(self) {
        let Self { rows, factors, v, product } = self;
        let (v, product) = (v.as_chunks::<3>().0, product.as_chunks_mut::<3>().0);
        let (slave, v) = (v[0], &v[1..=rows.count]);
        let (of_slave, product) = product.split_at_mut(1);
        let product = &mut product[..rows.count];
        for node in 0..rows.count {
            for axis in 0..3 {
                product[node][axis] = v[node][axis] - slave[axis];
            }
        }
        let mut swapped = [0.0; MOST_ROWS + MOST_LANES];
        swapped_sums::<T>(rows, factors, product, &mut swapped);
        let mut total = [0.0; 3];
        let mut node = 0;
        while node < rows.count {
            // The last nodes are computed again rather than fewer at once; what they get is the same.
            let of_node = |k: usize| rows.of_node((node + k).min(rows.count - 1), factors);
            let of_nodes = [of_node(0), of_node(1), of_node(2), of_node(3)];
            let blocks = blocks::<T>(rows, of_nodes, &swapped);
            for k in 0..NODES.min(rows.count - node) {
                let own = &of_nodes[k][3 * rows.rows..][..6];
                let [x, y, z] = product[node + k];
                let own = [
                    own[0] * x + own[1] * y + own[3] * z,
                    own[1] * x + own[2] * y + own[4] * z,
                    own[3] * x + own[4] * y + own[5] * z,
                ];
                for axis in 0..3 {
                    let entry = blocks[axis][k] + own[axis];
                    product[node + k][axis] = entry;
                    total[axis] -= entry;
                }
            }
            node += NODES;
        }
        of_slave[0] = total;
    }
}

/// Products of the rows with v, those of b where those of c belong and the other way round.
#[inline(always)]
fn swapped_sums<T: Vector>(
    rows: FormRows,
    factors: &[f64],
    differences: &[[f64; 3]],
    swapped: &mut [f64; MOST_ROWS + MOST_LANES],
) {
    assert!(rows.rows <= MOST_ROWS, "{} rows", rows.rows);
    let mut first = 0;
    while first < rows.rows {
        let vectors = (rows.rows - first).div_ceil(T::WIDTH);
        first += T::WIDTH
            * match vectors {
                1 => sums::<T, 1>(rows, factors, differences, first, swapped),
                2 => sums::<T, 2>(rows, factors, differences, first, swapped),
                3 => sums::<T, 3>(rows, factors, differences, first, swapped),
                _ => sums::<T, GROUP>(rows, factors, differences, first, swapped),
            };
    }
    for place in rows.rows..rows.rows + MOST_LANES {
        swapped[place] = 0.0;
    }
    for pair in 0..rows.rows / 2 {
        swapped.swap(2 * pair, 2 * pair + 1);
    }
}

/// Products of the rows of four nodes with the numbers of the rows: x, y and z of each.
#[inline(always)]
fn blocks<T: Vector>(rows: FormRows, factors: [&[f64]; NODES], of_rows: &[f64]) -> [[f64; NODES]; 3] {
    let mut sums = [[T::ZERO; NODES]; 3];
    let mut row = 0;
    while row < rows.rows {
        let of_rows = T::load(of_rows, row);
        for axis in 0..3 {
            for node in 0..NODES {
                let entries = T::load(factors[node], rows.rows * axis + row);
                sums[axis][node] = entries.mul_add(of_rows, sums[axis][node]);
            }
        }
        row += T::WIDTH;
    }
    [T::sums(sums[0]), T::sums(sums[1]), T::sums(sums[2])]
}

/// Products with v, given as differences from the slave's part, of some vectors of rows from `first` on. The last vector may reach beyond
/// the rows, into numbers of the same node. Returns the number of vectors.
#[inline(always)]
fn sums<T: Vector, const VECTORS: usize>(
    rows: FormRows,
    factors: &[f64],
    differences: &[[f64; 3]],
    first: usize,
    target: &mut [f64],
) -> usize {
    // A sum for each axis: one addition would wait for the other.
    let mut sums = [[T::ZERO; VECTORS]; 3];
    for node in 0..differences.len() {
        let factors = rows.of_node(node, factors);
        for axis in 0..3 {
            let difference = T::splat(differences[node][axis]);
            for k in 0..VECTORS {
                let row = T::load(factors, rows.rows * axis + first + T::WIDTH * k);
                sums[axis][k] = row.mul_add(difference, sums[axis][k]);
            }
        }
    }
    for k in 0..VECTORS {
        (sums[0][k] + sums[1][k] + sums[2][k]).store(target, first + T::WIDTH * k);
    }
    VECTORS
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(count: usize, seed: usize) -> Vec<f64> {
        (0..count).map(|k| ((7 * k + 13 * seed) % 17) as f64 - 8.0).collect()
    }

    /// Entry (3 i + a, 3 j + b) of M, from factors.
    fn entry(rows: FormRows, factors: &[f64], [i, j]: [usize; 2], [a, b]: [usize; 2]) -> f64 {
        if i == 0 || j == 0 {
            // −Σ over the nodes.
            let nodes = |k: usize| if k == 0 { 1..=rows.count } else { k..=k };
            let sign = if (i == 0) == (j == 0) { 1.0 } else { -1.0 };
            let pairs = nodes(i).flat_map(|i| nodes(j).map(move |j| [i, j]));
            return sign * pairs.map(|pair| entry(rows, factors, pair, [a, b])).sum::<f64>();
        }
        let node = |k: usize| &factors[rows.node_factors() * (k - 1)..];
        let products = |x: &[f64], y: &[f64], count: usize| -> f64 {
            (0..count).map(|row| x[count * a + row] * y[count * b + (row ^ 1)]).sum()
        };
        let own =
            if i == j { node(i)[3 * rows.rows + super::super::packed_row(a.max(b)) + a.min(b)] } else { 0.0 };
        products(node(i), node(j), rows.rows) + own
    }

    #[test]
    fn factors_times_a_vector_are_the_hessian_times_the_vector() {
        for rows in [0, 2, 6, 8, 12, 14, 16, 18, 28, 38, 64] {
            for count in [1, 2, 3, 7, 12] {
                let rows = FormRows { rows, count };
                let freedoms = 3 * (count + 1);
                // Behind the factors nothing may be read, and nothing be written behind the product.
                let factors = numbers(rows.factors(), 1);
                let v = numbers(freedoms, 2);
                let place = |k: usize| (k / 3, k % 3);
                let at = |p: usize, q: usize| {
                    let ((i, a), (j, b)) = (place(p), place(q));
                    entry(rows, &factors, [i, j], [a, b])
                };
                let expected: Vec<f64> =
                    (0..freedoms).map(|p| (0..freedoms).map(|q| at(p, q) * v[q]).sum()).collect();
                for isa in Isa::available() {
                    let mut product = vec![f64::NAN; freedoms];
                    rows.multiply_factors(isa, &factors, &v, &mut product);
                    // Whole numbers: any order of additions gives the same.
                    assert_eq!(product, expected, "{rows:?} {isa}");
                }
                let mut diagonal = vec![f64::NAN; freedoms];
                rows.factors_diagonal(&factors, &mut diagonal);
                assert_eq!(diagonal, (0..freedoms).map(|p| at(p, p)).collect::<Vec<_>>(), "{rows:?}");
            }
        }
    }
}
