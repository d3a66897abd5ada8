//! Hessians from their form of low rank: M = Σ cᵀb + bᵀc over slave and nodes, plus the nodes' own blocks.
//!
//! The own block O of a node stands at (node, node), −O at (node, slave).
//! Rows are ordered b₀, c₀, b₁, c₁, …; first those that differ between nodes, then those that are the same for all.
//!
//! A product may overflow though others that it cancels with hide it: what multiplies also returns 0 times sums of entries it wrote: 0 if all
//! are finite, NaN if not, or if their sum is within a factor of nine of overflow. The slave's rows are the negative sums of the nodes', and
//! so is its own block.

use super::second::MOST_ROWS;
use super::simd::Vector;
use super::{Lane, packed_row};

/// How many rows a form has.
#[derive(Clone, Copy, Debug)]
pub struct FormRows {
    /// Rows that differ between nodes, two for each product.
    pub varying: usize,
    /// Rows that are the same for all nodes.
    pub constant: usize,
    /// Number of master nodes.
    pub count: usize,
}

impl FormRows {
    /// Room for a node's own block, and for a sum of blocks.
    pub const OWN: usize = 15;

    /// Numbers of the [factors](super::Second) that a form leaves.
    #[inline(always)]
    #[must_use]
    pub const fn factors(self) -> usize {
        self.node_factors() * self.count + 3 * self.constant
    }

    /// Numbers of the slave's [rows](super::SecondKind::SlaveRows) of M.
    #[inline(always)]
    #[must_use]
    pub const fn slave_rows(self) -> usize {
        9 * (self.count + 1)
    }

    /// Factors of one node.
    #[inline(always)]
    #[must_use]
    pub(super) const fn node_factors(self) -> usize {
        3 * self.varying + 6
    }

    const fn all(self) -> usize {
        self.varying + self.constant
    }
}

/// Writes values one after another. (`copy_from_slice` is not always inlined.)
#[allow(clippy::manual_memcpy)]
#[inline(always)]
pub(super) fn write<T: Copy, const VALUES: usize>(values: [T; VALUES], target: &mut [T], start: usize) {
    let target = &mut target[start..start + VALUES];
    for k in 0..VALUES {
        target[k] = values[k];
    }
}

/// Where the blocks of a Hessian go, as [`batch::multiply`] writes them: node after node from the last one on, of each the blocks with nodes
/// before it, ascending, then its own and the one with the slave.
pub(super) trait Blocks<T> {
    /// Goes on to the rows of a node, counted from 1.
    fn begin(&mut self, node: usize);

    /// The block with a node before this one.
    fn write_block(&mut self, column: usize, block: &[[T; 3]; 3]);

    /// The node's own block, of which the lower triangle is read, and the one with the slave.
    fn write_ends(&mut self, own: &[[T; 3]; 3], with_slave: &[[T; 3]; 3]);

    /// The slave's own block, last of all.
    fn write_slave(&mut self, block: &[[T; 3]; 3]);
}

/// A packed lower triangle, and the node whose rows are written.
pub(super) struct Packed<'a, T> {
    pub target: &'a mut [T],
    pub node: usize,
}

impl<T: Lane> Packed<'_, T> {
    #[inline(always)]
    fn write_lower(&mut self, node: usize, block: &[[T; 3]; 3]) {
        for i in 0..3 {
            for j in 0..=i {
                self.target[packed_row(3 * node + i) + 3 * node + j] = block[i][j];
            }
        }
    }
}

impl<T: Lane> Blocks<T> for Packed<'_, T> {
    #[inline(always)]
    fn begin(&mut self, node: usize) {
        self.node = node;
    }

    #[inline(always)]
    fn write_block(&mut self, column: usize, block: &[[T; 3]; 3]) {
        for i in 0..3 {
            write(block[i], self.target, packed_row(3 * self.node + i) + 3 * column);
        }
    }

    #[inline(always)]
    fn write_ends(&mut self, own: &[[T; 3]; 3], with_slave: &[[T; 3]; 3]) {
        self.write_lower(self.node, own);
        self.write_block(0, with_slave);
    }

    #[inline(always)]
    fn write_slave(&mut self, block: &[[T; 3]; 3]) {
        self.write_lower(0, block);
    }
}

/// Elements side by side: of the nodes, one after another, the varying rows and the own block; then room for a block of each node.
pub(super) mod batch {
    use super::*;

    /// Numbers of an own block, and of a block.
    const OWN: usize = 6;
    const BLOCK: usize = 9;
    const _: () = assert!(OWN + BLOCK <= FormRows::OWN);

    #[inline(always)]
    pub fn length(rows: FormRows) -> usize {
        (node_length(rows) + BLOCK) * rows.count
    }

    #[inline(always)]
    const fn node_length(rows: FormRows) -> usize {
        3 * rows.varying + OWN
    }

    #[inline(always)]
    pub fn keep_row<T: Lane>(form: &mut [T], rows: FormRows, row: usize, node: usize, values: [T; 3]) {
        write(values, form, node_length(rows) * node + 3 * row);
    }

    #[inline(always)]
    pub fn keep_own<T: Lane>(form: &mut [T], rows: FormRows, node: usize, own: [T; 6]) {
        write(own, form, node_length(rows) * node + 3 * rows.varying);
    }

    /// Writes the Hessian, from the last row to the first: then the sum of a node's blocks with later ones is known when its own are, and the
    /// block with the slave is what is left to zero.
    ///
    /// Returns 0 or, if an entry is not finite, NaN.
    #[inline(always)]
    #[must_use]
    pub fn multiply<T: Vector>(
        form: &mut [T],
        rows: FormRows,
        constant: &[[T; 3]],
        target: &mut impl Blocks<T>,
    ) -> T {
        let all_nodes = products([[T::ZERO; 3]; 3], [constant; 2], [constant; 2]);
        let mut hessian = Unfinished::new(form, rows);
        let of_b = hessian.nodes;
        hessian.write_rows(all_nodes, of_b, rows.count, target);
        hessian.end(target)
    }

    /// Writes two Hessians: the second has the rows b of the first, its own rows c, and a last node that the first does not have, whose
    /// rows b are zero. Neither has constant rows. (Blocks of the first and of the second by turns took longer.)
    ///
    /// Returns of each 0 or, if an entry is not finite, NaN.
    #[inline(always)]
    #[must_use]
    pub fn multiply_pair<T: Vector>(
        [form, other]: [&mut [T]; 2],
        [rows, other_rows]: [FormRows; 2],
        [target, other_target]: [&mut impl Blocks<T>; 2],
    ) -> [T; 2] {
        let zero = [[T::ZERO; 3]; 3];
        let mut hessian = Unfinished::new(form, rows);
        let of_b = hessian.nodes;
        hessian.write_rows(zero, of_b, rows.count, target);
        let first = hessian.end(target);

        let mut other = Unfinished::new(other, other_rows);
        let point = other.row(other.nodes, rows.count);
        let mut with_slave = other.begin(rows.count, other_target);
        for column in 0..rows.count {
            let block = products_of_c(point, other.row(of_b, column));
            other.write_block(column, &block, &mut with_slave, other_target);
        }
        other.end_row(rows.count, zero, zero, with_slave, other_target);
        other.write_rows(zero, of_b, rows.count, other_target);
        [first, other.end(other_target)]
    }

    /// A Hessian whose rows are written from the last to the first.
    struct Unfinished<'a, T> {
        rows: FormRows,
        /// The form.
        nodes: &'a [T],
        /// Sums of each node's blocks with later ones.
        sums: &'a mut [[T; BLOCK]],
        /// The slave's own block, as far as it is known.
        slave: [[T; 3]; 3],
        not_finite: T,
    }

    impl<'a, T: Vector> Unfinished<'a, T> {
        #[inline(always)]
        fn new(form: &'a mut [T], rows: FormRows) -> Self {
            let (nodes, sums) = form.split_at_mut(node_length(rows) * rows.count);
            let sums = &mut sums.as_chunks_mut::<BLOCK>().0[..rows.count];
            for node in 0..rows.count {
                sums[node] = [T::ZERO; BLOCK];
            }
            Self { rows, nodes, sums, slave: [[T::ZERO; 3]; 3], not_finite: T::ZERO }
        }

        /// The varying rows of a node in a form of as many.
        #[inline(always)]
        fn row<'b>(&self, form: &'b [T], node: usize) -> &'b [[T; 3]] {
            form[node_length(self.rows) * node..][..3 * self.rows.varying].as_chunks::<3>().0
        }

        /// Goes on to the rows of a node. Returns its block with the slave, as far as it is known.
        #[inline(always)]
        fn begin(&self, node: usize, target: &mut impl Blocks<T>) -> [[T; 3]; 3] {
            target.begin(node + 1);
            let sum = &self.sums[node];
            [[-sum[0], -sum[1], -sum[2]], [-sum[3], -sum[4], -sum[5]], [-sum[6], -sum[7], -sum[8]]]
        }

        /// Writes the rows of the first `count` nodes. `of_b`: the form whose rows b they have. `all_nodes`: what every block begins with.
        #[inline(always)]
        fn write_rows(
            &mut self,
            all_nodes: [[T; 3]; 3],
            of_b: &[T],
            count: usize,
            target: &mut impl Blocks<T>,
        ) {
            let of_c = self.nodes;
            for node in (0..count).rev() {
                let row = [self.row(of_b, node), self.row(of_c, node)];
                let mut with_slave = self.begin(node, target);
                for column in 0..node {
                    let block = products(all_nodes, row, [self.row(of_b, column), self.row(of_c, column)]);
                    self.write_block(column, &block, &mut with_slave, target);
                }
                self.end_row(node, all_nodes, half_products(row), with_slave, target);
            }
        }

        #[inline(always)]
        fn write_block(
            &mut self,
            column_node: usize,
            block: &[[T; 3]; 3],
            with_slave: &mut [[T; 3]; 3],
            target: &mut impl Blocks<T>,
        ) {
            let of_column = &mut self.sums[column_node];
            for i in 0..3 {
                for j in 0..3 {
                    with_slave[i][j] = with_slave[i][j] - block[i][j];
                    of_column[3 * j + i] = of_column[3 * j + i] + block[i][j];
                }
            }
            target.write_block(column_node + 1, block);
        }

        /// Writes a node's own block, `half` its products, and the one with the slave.
        #[inline(always)]
        fn end_row(
            &mut self,
            node: usize,
            all_nodes: [[T; 3]; 3],
            half: [[T; 3]; 3],
            mut with_slave: [[T; 3]; 3],
            target: &mut impl Blocks<T>,
        ) {
            let own = &self.nodes[node_length(self.rows) * node + 3 * self.rows.varying..][..OWN];
            let own = [[own[0], own[1], own[3]], [own[1], own[2], own[4]], [own[3], own[4], own[5]]];
            let mut diagonal = [[T::ZERO; 3]; 3];
            for i in 0..3 {
                for j in 0..=i {
                    let entry = half[i][j] + (all_nodes[i][j] + own[i][j]);
                    diagonal[i][j] = entry;
                    with_slave[i][j] = with_slave[i][j] - entry;
                    if i != j {
                        with_slave[j][i] = with_slave[j][i] - entry;
                    }
                }
            }
            for i in 0..3 {
                let [x, y, z] = with_slave[i];
                // An entry of the row that is not finite does not leave its sum finite.
                self.not_finite = (x + y + z).mul_add(T::ZERO, self.not_finite);
                for j in 0..3 {
                    self.slave[i][j] = self.slave[i][j] - with_slave[i][j];
                }
            }
            target.write_ends(&diagonal, &with_slave);
        }

        /// Writes the slave's own block.
        #[inline(always)]
        fn end(self, target: &mut impl Blocks<T>) -> T {
            let [x, y, z] = self.slave;
            target.write_slave(&self.slave);
            (x[0] + (y[0] + y[1]) + (z[0] + z[1] + z[2])).mul_add(T::ZERO, self.not_finite)
        }
    }

    /// Writes the factors. Returns 0 or, if one is not finite, NaN.
    #[inline(always)]
    #[must_use]
    pub fn write_factors<T: Lane>(form: &[T], rows: FormRows, constant: &[[T; 3]], target: &mut [T]) -> T {
        let (size, own) = (node_length(rows), 3 * rows.varying);
        let mut not_finite = T::ZERO;
        for node in 0..rows.count {
            let form = &form[size * node..][..size];
            let target = &mut target[rows.node_factors() * node..][..rows.node_factors()];
            for row in 0..rows.varying {
                for axis in 0..3 {
                    target[rows.varying * axis + row] = form[3 * row + axis];
                }
                let sum = form[3 * row] + form[3 * row + 1] + form[3 * row + 2];
                not_finite = sum.mul_add(T::ZERO, not_finite);
            }
            let block = &form[own..own + 6];
            write([block[0], block[1], block[2], block[3], block[4], block[5]], target, own);
            let sum = block[0] + block[1] + block[2] + block[3] + block[4] + block[5];
            not_finite = sum.mul_add(T::ZERO, not_finite);
        }
        for row in 0..constant.len() {
            for axis in 0..3 {
                target[rows.node_factors() * rows.count + rows.constant * axis + row] = constant[row][axis];
                not_finite = constant[row][axis].mul_add(T::ZERO, not_finite);
            }
        }
        not_finite
    }

    /// Writes the slave's three rows of the Hessian: the negative sums of the nodes' rows, made of the sums of the form's. Returns 0 or, if
    /// an entry is not finite, NaN.
    ///
    /// # Panics
    /// If a slice is too short, or there are more than 64 rows.
    #[inline(always)]
    #[must_use]
    pub fn write_slave_rows<T: Lane>(form: &[T], rows: FormRows, constant: &[[T; 3]], target: &mut [T]) -> T {
        let (size, own, freedoms) = (node_length(rows), 3 * rows.varying, 3 * (rows.count + 1));
        let mut negative_sums = [[T::ZERO; 3]; MOST_ROWS];
        let negative_sums = &mut negative_sums[..rows.varying];
        for node in 0..rows.count {
            let of_node = form[size * node..][..own].as_chunks::<3>().0;
            for row in 0..rows.varying {
                for axis in 0..3 {
                    negative_sums[row][axis] = negative_sums[row][axis] - of_node[row][axis];
                }
            }
        }
        let mut start = products([[T::ZERO; 3]; 3], [constant; 2], [constant; 2]);
        for i in 0..3 {
            for j in 0..3 {
                start[i][j] = T::splat(-(rows.count as f64)) * start[i][j];
            }
        }
        let mut slave = [[T::ZERO; 3]; 3];
        let mut not_finite = T::ZERO;
        for node in 0..rows.count {
            let form = &form[size * node..][..size];
            let (of_node, block) = (form[..own].as_chunks::<3>().0, &form[own..own + OWN]);
            let block = [
                [block[0], block[1], block[3]],
                [block[1], block[2], block[4]],
                [block[3], block[4], block[5]],
            ];
            let sums = products(start, [&*negative_sums; 2], [of_node; 2]);
            for i in 0..3 {
                let entries = [sums[i][0] - block[i][0], sums[i][1] - block[i][1], sums[i][2] - block[i][2]];
                for j in 0..3 {
                    slave[i][j] = slave[i][j] - entries[j];
                }
                not_finite = (entries[0] + entries[1] + entries[2]).mul_add(T::ZERO, not_finite);
                write(entries, target, freedoms * i + 3 * (node + 1));
            }
        }
        for i in 0..3 {
            not_finite = (slave[i][0] + slave[i][1] + slave[i][2]).mul_add(T::ZERO, not_finite);
            write(slave[i], target, freedoms * i);
        }
        not_finite
    }

    /// start + Σ cᵀb + bᵀc, the rows b and c of both nodes among those of any form.
    #[inline(always)]
    fn products<T: Lane>(start: [[T; 3]; 3], row: [&[[T; 3]]; 2], column: [&[[T; 3]]; 2]) -> [[T; 3]; 3] {
        let mut block = start;
        let ([row_b, row_c], [column_b, column_c]) = (pairs(row), pairs(column));
        for k in 0..row_b.len().min(row_c.len()).min(column_b.len().min(column_c.len())) {
            let ([b, _], [_, c]) = (&row_b[k], &row_c[k]);
            let ([column_b, _], [_, column_c]) = (&column_b[k], &column_c[k]);
            for i in 0..3 {
                for j in 0..3 {
                    block[i][j] = c[i].mul_add(column_b[j], b[i].mul_add(column_c[j], block[i][j]));
                }
            }
        }
        block
    }

    /// Σ cᵀb for a node whose rows b are zero.
    #[inline(always)]
    fn products_of_c<T: Lane>(row: &[[T; 3]], column: &[[T; 3]]) -> [[T; 3]; 3] {
        let mut block = [[T::ZERO; 3]; 3];
        let [row, column] = pairs([row, column]);
        for k in 0..row.len().min(column.len()) {
            let ([_, c], [b, _]) = (&row[k], &column[k]);
            for i in 0..3 {
                for j in 0..3 {
                    block[i][j] = c[i].mul_add(b[j], block[i][j]);
                }
            }
        }
        block
    }

    /// The lower triangle of Σ cᵀb + bᵀc for a node with itself, its rows b and c among those of any form.
    #[inline(always)]
    fn half_products<T: Lane>(row: [&[[T; 3]]; 2]) -> [[T; 3]; 3] {
        let mut block = [[T::ZERO; 3]; 3];
        let [of_b, of_c] = pairs(row);
        for k in 0..of_b.len().min(of_c.len()) {
            let ([b, _], [_, c]) = (&of_b[k], &of_c[k]);
            for i in 0..3 {
                for j in 0..=i {
                    block[i][j] = c[i].mul_add(b[j], b[i].mul_add(c[j], block[i][j]));
                }
            }
        }
        block
    }

    /// Rows b and c of each product.
    #[inline(always)]
    fn pairs<T>([x, y]: [&[[T; 3]]; 2]) -> [&[[[T; 3]; 2]]; 2] {
        [x.as_chunks::<2>().0, y.as_chunks::<2>().0]
    }
}

/// The nodes of one element side by side: every row over all coordinates, the slave's first; then the own blocks, four
/// numbers for each coordinate, the fourth 0.
pub(super) mod single {
    use super::*;

    /// Numbers of an own block: three rows of four.
    const OWN: usize = 12;
    const _: () = assert!(OWN <= FormRows::OWN);

    #[inline(always)]
    pub fn length<T: Vector>(rows: FormRows) -> usize {
        (3 * rows.all() + OWN) * (stride::<T>(rows) / 3)
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
        let nodes =
            &mut form[stride::<T>(rows) * rows.all()..].as_chunks_mut::<OWN>().0[1 + T::WIDTH * vector..];
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
        let start = stride::<T>(rows) * rows.all() + OWN * rows.count;
        for (axis, row) in [[xx, yx, zx], [yx, yy, zy], [zx, zy, zz]].into_iter().enumerate() {
            let [x, y, z] = row;
            write([x.lane(0), y.lane(0), z.lane(0), 0.0], form, start + 4 * axis);
        }
    }

    /// Returns 0 or, if an entry is not finite, NaN.
    #[inline(always)]
    #[must_use]
    pub fn multiply<T: Vector>(
        form: &mut [f64],
        rows: FormRows,
        constant: &[[T::Scalar; 3]],
        target: &mut [f64],
    ) -> f64 {
        const { assert!(T::WIDTH <= 4) };
        let mut not_finite = T::ZERO;
        let stride = stride::<T>(rows);
        let (form, own) = form.split_at_mut(stride * rows.all());
        complete::<T>(form, rows, constant);
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

    /// Fills in the slave's part of all rows, and those that are the same for all nodes.
    #[inline(always)]
    fn complete<T: Vector>(form: &mut [f64], rows: FormRows, constant: &[[T::Scalar; 3]]) {
        let stride = stride::<T>(rows);
        for row in 0..rows.varying {
            let (slave, nodes) = form[stride * row..][..3 * (rows.count + 1)].split_at_mut(3);
            write(negative_sum::<T>(nodes), slave, 0);
        }
        for row in 0..constant.len() {
            let [x, y, z] = &constant[row];
            let values = [x.lane(0), y.lane(0), z.lane(0)];
            for node in 1..stride / 3 {
                write(values, form, stride * (rows.varying + row) + 3 * node);
            }
            let times = -(rows.count as f64);
            let slave = [times * values[0], times * values[1], times * values[2]];
            write(slave, form, stride * (rows.varying + row));
        }
    }

    /// Writes the slave's three rows of the Hessian. Returns 0 or, if an entry is not finite, NaN.
    ///
    /// # Panics
    /// If a slice is too short.
    #[inline(always)]
    #[must_use]
    pub fn write_slave_rows<T: Vector>(
        form: &mut [f64],
        rows: FormRows,
        constant: &[[T::Scalar; 3]],
        target: &mut [f64],
    ) -> f64 {
        let (stride, freedoms) = (stride::<T>(rows), 3 * (rows.count + 1));
        let (form, own) = form.split_at_mut(stride * rows.all());
        complete::<T>(form, rows, constant);
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
    #[must_use]
    pub fn write_factors<T: Vector>(
        form: &[f64],
        rows: FormRows,
        constant: &[[T::Scalar; 3]],
        target: &mut [f64],
    ) -> f64 {
        let stride = stride::<T>(rows);
        let (form, own) = form.split_at(stride * rows.all());
        for node in 0..rows.count {
            let target = &mut target[rows.node_factors() * node..][..rows.node_factors()];
            for row in 0..rows.varying {
                for axis in 0..3 {
                    target[rows.varying * axis + row] = form[stride * row + 3 * (node + 1) + axis];
                }
            }
            let own = &own[OWN * (node + 1)..][..OWN];
            for (k, place) in [0, 4, 5, 8, 9, 10].into_iter().enumerate() {
                target[3 * rows.varying + k] = own[place];
            }
        }
        for row in 0..constant.len() {
            let [x, y, z] = &constant[row];
            let values = [x.lane(0), y.lane(0), z.lane(0)];
            for axis in 0..3 {
                target[rows.node_factors() * rows.count + rows.constant * axis + row] = values[axis];
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
}

#[cfg(test)]
mod tests;
