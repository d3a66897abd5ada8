//! The nodes of one element side by side: every row over all coordinates, the slave's first; then the own blocks, four
//! numbers for each coordinate, the fourth 0.

use super::*;

/// Numbers of an own block: three rows of four.
const OWN: usize = 12;
const _: () = assert!(OWN <= FormRows::OWN);

#[inline(always)]
pub fn length<T: Vector>(rows: FormRows) -> usize {
    (3 * rows.rows + OWN) * (stride::<T>(rows) / 3)
}

/// Numbers in a row: for full vectors of nodes, and for the slave.
#[inline(always)]
fn stride<T: Vector>(rows: FormRows) -> usize {
    3 * T::WIDTH * (rows.count.div_ceil(T::WIDTH) + 1)
}

#[inline(always)]
pub fn keep_row<T: Vector>(form: &mut [f64], rows: FormRows, row: usize, vector: usize, values: [T; 3]) {
    let start = stride::<T>(rows) * row + 3 + 3 * T::WIDTH * vector;
    T::store_interleaved(values, &mut form[start..start + 3 * T::WIDTH]);
}

#[inline(always)]
pub fn keep_own<T: Vector>(form: &mut [f64], rows: FormRows, vector: usize, own: [T; 6]) {
    let [xx, yx, yy, zx, zy, zz] = own;
    let nodes = &mut form[stride::<T>(rows) * rows.rows..].as_chunks_mut::<OWN>().0[1 + T::WIDTH * vector..];
    let nodes = &mut nodes[..T::WIDTH];
    for (axis, row) in [[xx, yx, zx], [yx, yy, zy], [zx, zy, zz]].into_iter().enumerate() {
        let [x, y, z] = row;
        T::store_transposed(&[x, y, z, T::ZERO], nodes, |node| &mut node[4 * axis..4 * axis + 4]);
    }
}

/// The row of the last node.
#[inline(always)]
pub fn keep_last_row<T: Vector>(form: &mut [f64], rows: FormRows, row: usize, values: [T::Scalar; 3]) {
    let [x, y, z] = values;
    write([x.lane(0), y.lane(0), z.lane(0)], form, stride::<T>(rows) * row + 3 * rows.count);
}

/// The own block of the last node.
#[inline(always)]
pub fn keep_last_own<T: Vector>(form: &mut [f64], rows: FormRows, own: [T::Scalar; 6]) {
    let [xx, yx, yy, zx, zy, zz] = own;
    let start = stride::<T>(rows) * rows.rows + OWN * rows.count;
    for (axis, row) in [[xx, yx, zx], [yx, yy, zy], [zx, zy, zz]].into_iter().enumerate() {
        let [x, y, z] = row;
        write([x.lane(0), y.lane(0), z.lane(0), 0.0], form, start + 4 * axis);
    }
}

/// Returns 0 or, if an entry is not finite, NaN.
#[inline(always)]
pub fn multiply<T: Vector>(form: &mut [f64], rows: FormRows, target: &mut [f64]) -> f64 {
    const { assert!(T::WIDTH <= 4) };
    let mut not_finite = T::ZERO;
    let stride = stride::<T>(rows);
    let (form, own) = form.split_at_mut(stride * rows.rows);
    complete::<T>(form, rows);
    for node in 1..=rows.count {
        let mut end = 3 * node + 3;
        let strip = Strip { form, own, stride, node };
        // From right to left: what a vector writes beyond its row, and where the last two overlap, is written again.
        while end > 2 * T::WIDTH {
            let columns = [end.saturating_sub(3 * T::WIDTH), end - 2 * T::WIDTH, end - T::WIDTH];
            not_finite = strip.write_3::<T>(columns, target, not_finite);
            end = columns[0];
        }
        if end > T::WIDTH {
            not_finite = strip.write_2::<T>([0, end - T::WIDTH], target, not_finite);
        } else if end > 0 {
            not_finite = strip.write_1::<T>([0], target, not_finite);
        }
        if node == 1 {
            // The own block and its negative are side by side: no vector begins with one of them only.
            for axis in 0..3 {
                let own = &own[OWN + 4 * axis..][..3];
                let row = &mut target[packed_row(3 + axis)..][..4 + axis];
                for column in 0..3 {
                    row[column] -= own[column];
                }
                for column in 0..=axis {
                    row[3 + column] += own[column];
                }
                let mut sum = 0.0;
                for column in 0..4 + axis {
                    sum += row[column];
                }
                not_finite = T::splat(sum).mul_add(T::ZERO, not_finite);
            }
        }
    }
    for i in 0..3 {
        for j in 0..=i {
            let mut entry = 0.0;
            for node in 1..=rows.count {
                entry -= target[packed_row(3 * node + i) + j];
            }
            target[packed_row(i) + j] = entry;
            not_finite = T::splat(entry).mul_add(T::ZERO, not_finite);
        }
    }
    not_finite.sum()
}

/// Fills in the slave's part of all rows.
#[inline(always)]
fn complete<T: Vector>(form: &mut [f64], rows: FormRows) {
    let stride = stride::<T>(rows);
    for row in 0..rows.rows {
        let (slave, nodes) = form[stride * row..][..3 * (rows.count + 1)].split_at_mut(3);
        write(negative_sum::<T>(nodes), slave, 0);
    }
}

/// Writes the slave's three rows of the Hessian. Returns 0 or, if an entry is not finite, NaN.
///
/// # Panics
/// If a slice is too short.
#[inline(always)]
pub fn write_slave_rows<T: Vector>(form: &mut [f64], rows: FormRows, target: &mut [f64]) -> f64 {
    let (stride, freedoms) = (stride::<T>(rows), 3 * (rows.count + 1));
    let (form, own) = form.split_at_mut(stride * rows.rows);
    complete::<T>(form, rows);
    let mut vector = 0;
    while vector < freedoms {
        // The last vector writes some entries once more.
        let column = vector.min(freedoms - T::WIDTH);
        let mut entries = Entries { column, x: T::ZERO, y: T::ZERO, z: T::ZERO };
        for pair in form.chunks_exact(2 * stride) {
            let (b, c) = pair.split_at(stride);
            entries.add(T::splat(c[0]), T::splat(c[1]), T::splat(c[2]), b);
            entries.add(T::splat(b[0]), T::splat(b[1]), T::splat(b[2]), c);
        }
        entries.x.store(target, column);
        entries.y.store(target, freedoms + column);
        entries.z.store(target, 2 * freedoms + column);
        vector += T::WIDTH;
    }
    let mut not_finite = 0.0;
    for axis in 0..3 {
        let row = &mut target[freedoms * axis..][..freedoms];
        for node in 1..=rows.count {
            for column in 0..3 {
                let own = own[OWN * node + 4 * axis + column];
                row[3 * node + column] -= own;
                row[column] += own;
            }
        }
        for column in 0..freedoms {
            not_finite += 0.0 * row[column];
        }
    }
    not_finite
}

/// The negative sums of x, y and z of the nodes.
#[inline(always)]
fn negative_sum<T: Vector>(nodes: &[f64]) -> [f64; 3] {
    let mut sums = [T::ZERO; 3];
    let whole = nodes.len() / (3 * T::WIDTH);
    for vector in 0..whole {
        for k in 0..3 {
            sums[k] = sums[k] - T::load(nodes, T::WIDTH * (3 * vector + k));
        }
    }
    let mut total = [0.0; 3];
    for k in 0..3 {
        for lane in 0..T::WIDTH {
            total[(T::WIDTH * k + lane) % 3] += sums[k].lane(lane);
        }
    }
    for place in 3 * T::WIDTH * whole..nodes.len() {
        total[place % 3] -= nodes[place];
    }
    total
}

/// Writes the factors. Returns 0 or, if one is not finite, NaN.
#[inline(always)]
pub fn write_factors<T: Vector>(form: &[f64], rows: FormRows, target: &mut [f64]) -> f64 {
    let stride = stride::<T>(rows);
    let (form, own) = form.split_at(stride * rows.rows);
    for node in 0..rows.count {
        let target = &mut target[rows.node_factors() * node..][..rows.node_factors()];
        for row in 0..rows.rows {
            for axis in 0..3 {
                target[rows.rows * axis + row] = form[stride * row + 3 * (node + 1) + axis];
            }
        }
        let own = &own[OWN * (node + 1)..][..OWN];
        for (k, place) in [0, 4, 5, 8, 9, 10].into_iter().enumerate() {
            target[3 * rows.rows + k] = own[place];
        }
    }
    let mut not_finite = 0.0;
    for k in 0..rows.factors() {
        not_finite += 0.0 * target[k];
    }
    not_finite
}

/// Rows of one node.
#[derive(Clone, Copy)]
struct Strip<'a> {
    form: &'a [f64],
    own: &'a [f64],
    stride: usize,
    node: usize,
}

/// Entries of a node's three rows, side by side from a column on.
struct Entries<T> {
    column: usize,
    x: T,
    y: T,
    z: T,
}

/// Writes vectors of the three rows that begin at the columns, which ascend; adds 0 times the sum of their entries,
/// all of which are entries of M by symmetry, to `not_finite`. Written out for each number of columns, so that all sums
/// stay in registers at any level of optimisation.
macro_rules! strip {
    ($name:ident, $count:literal, $($entries:ident),+; $($from_last:ident),+) => {
        #[inline(always)]
        fn $name<T: Vector>(
            self,
            [$($entries),+]: [usize; $count],
            target: &mut [f64],
            not_finite: T,
        ) -> T {
            let first = 3 * self.node;
            $(let mut $entries = self.own_entries::<T>($entries);)+
            for pair in self.form.chunks_exact(2 * self.stride) {
                let (b, c) = pair.split_at(self.stride);
                let row = &c[first..first + 3];
                let (x, y, z) = (T::splat(row[0]), T::splat(row[1]), T::splat(row[2]));
                $($entries.add(x, y, z, b);)+
                let row = &b[first..first + 3];
                let (x, y, z) = (T::splat(row[0]), T::splat(row[1]), T::splat(row[2]));
                $($entries.add(x, y, z, c);)+
            }
            let mut sum = T::ZERO;
            $(sum = sum + ($entries.x + $entries.y + $entries.z);)+
            let row = packed_row(first);
            $($from_last.x.store(target, row + $from_last.column);)+
            let row = packed_row(first + 1);
            $($from_last.y.store(target, row + $from_last.column);)+
            let row = packed_row(first + 2);
            $($from_last.z.store(target, row + $from_last.column);)+
            sum.mul_add(T::ZERO, not_finite)
        }
    };
}

impl Strip<'_> {
    strip!(write_3, 3, left, middle, right; right, middle, left);
    strip!(write_2, 2, left, right; right, left);
    strip!(write_1, 1, left; left);

    /// The part of the node's own block.
    #[inline(always)]
    fn own_entries<T: Vector>(self, column: usize) -> Entries<T> {
        let Self { own, node, .. } = self;
        let (row, first) = (OWN * node, 3 * node);
        let (x, y, z) = if node == 1 {
            (T::ZERO, T::ZERO, T::ZERO)
        } else if column + T::WIDTH > first {
            let start = row + column - first;
            (T::load(own, start), T::load(own, start + 4), T::load(own, start + 8))
        } else if column + T::WIDTH <= 4 {
            let start = row + column;
            (-T::load(own, start), -T::load(own, start + 4), -T::load(own, start + 8))
        } else {
            (T::ZERO, T::ZERO, T::ZERO)
        };
        Entries { column, x, y, z }
    }
}

impl<T: Vector> Entries<T> {
    /// Adds the products of numbers of the rows with a row of the form.
    #[inline(always)]
    fn add(&mut self, x: T, y: T, z: T, row: &[f64]) {
        let row = T::load(row, self.column);
        self.x = x.mul_add(row, self.x);
        self.y = y.mul_add(row, self.y);
        self.z = z.mul_add(row, self.z);
    }
}
