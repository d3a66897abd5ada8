//! Elements side by side: of the nodes, one after another, the rows and the own block; then room for a block of each node.

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
    3 * rows.rows + OWN
}

#[inline(always)]
pub fn keep_row<T: Lane>(form: &mut [T], rows: FormRows, row: usize, node: usize, values: [T; 3]) {
    write(values, form, node_length(rows) * node + 3 * row);
}

#[inline(always)]
pub fn keep_own<T: Lane>(form: &mut [T], rows: FormRows, node: usize, own: [T; 6]) {
    write(own, form, node_length(rows) * node + 3 * rows.rows);
}

/// Writes the Hessian, from the last row to the first: then the sum of a node's blocks with later ones is known when its own are, and the
/// block with the slave is what is left to zero.
///
/// Returns 0 or, if an entry is not finite, NaN.
#[inline(always)]
pub fn multiply<T: Vector>(form: &mut [T], rows: FormRows, target: &mut impl Blocks<T>) -> T {
    let mut hessian = Unfinished::new(form, rows);
    let of_b = hessian.nodes;
    hessian.write_rows(of_b, rows.count, target);
    hessian.end(target)
}

/// Writes two Hessians: the second has the rows b of the first, its own rows c, and a last node that the first does not have, whose
/// rows b are zero. (Blocks of the first and of the second by turns took longer.)
///
/// Returns of each 0 or, if an entry is not finite, NaN.
#[inline(always)]
pub fn multiply_pair<T: Vector>(
    [form, other]: [&mut [T]; 2],
    [rows, other_rows]: [FormRows; 2],
    [target, other_target]: [&mut impl Blocks<T>; 2],
) -> [T; 2] {
    let mut hessian = Unfinished::new(form, rows);
    let of_b = hessian.nodes;
    hessian.write_rows(of_b, rows.count, target);
    let first = hessian.end(target);

    let mut other = Unfinished::new(other, other_rows);
    let point = other.row(other.nodes, rows.count);
    let mut with_slave = other.begin(rows.count, other_target);
    for column in 0..rows.count {
        let block = products_of_c(point, other.row(of_b, column));
        other.write_block(column, &block, &mut with_slave, other_target);
    }
    other.end_row(rows.count, [[T::ZERO; 3]; 3], with_slave, other_target);
    other.write_rows(of_b, rows.count, other_target);
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

    /// The rows of a node in a form of as many.
    #[inline(always)]
    fn row<'b>(&self, form: &'b [T], node: usize) -> &'b [[T; 3]] {
        form[node_length(self.rows) * node..][..3 * self.rows.rows].as_chunks::<3>().0
    }

    /// Goes on to the rows of a node. Returns its block with the slave, as far as it is known.
    #[inline(always)]
    fn begin(&self, node: usize, target: &mut impl Blocks<T>) -> [[T; 3]; 3] {
        target.begin(node + 1);
        let sum = &self.sums[node];
        [[-sum[0], -sum[1], -sum[2]], [-sum[3], -sum[4], -sum[5]], [-sum[6], -sum[7], -sum[8]]]
    }

    /// Writes the rows of the first `count` nodes. `of_b`: the form whose rows b they have.
    #[inline(always)]
    fn write_rows(&mut self, of_b: &[T], count: usize, target: &mut impl Blocks<T>) {
        let of_c = self.nodes;
        for node in (0..count).rev() {
            let row = [self.row(of_b, node), self.row(of_c, node)];
            let mut with_slave = self.begin(node, target);
            for column in 0..node {
                let block = products(row, [self.row(of_b, column), self.row(of_c, column)]);
                self.write_block(column, &block, &mut with_slave, target);
            }
            self.end_row(node, half_products(row), with_slave, target);
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
        half: [[T; 3]; 3],
        mut with_slave: [[T; 3]; 3],
        target: &mut impl Blocks<T>,
    ) {
        let own = &self.nodes[node_length(self.rows) * node + 3 * self.rows.rows..][..OWN];
        let own = [[own[0], own[1], own[3]], [own[1], own[2], own[4]], [own[3], own[4], own[5]]];
        let mut diagonal = [[T::ZERO; 3]; 3];
        for i in 0..3 {
            for j in 0..=i {
                let entry = half[i][j] + own[i][j];
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
pub fn write_factors<T: Lane>(form: &[T], rows: FormRows, target: &mut [T]) -> T {
    let (size, own) = (node_length(rows), 3 * rows.rows);
    let mut not_finite = T::ZERO;
    for node in 0..rows.count {
        let form = &form[size * node..][..size];
        let target = &mut target[rows.node_factors() * node..][..rows.node_factors()];
        for row in 0..rows.rows {
            for axis in 0..3 {
                target[rows.rows * axis + row] = form[3 * row + axis];
            }
            let sum = form[3 * row] + form[3 * row + 1] + form[3 * row + 2];
            not_finite = sum.mul_add(T::ZERO, not_finite);
        }
        let block = &form[own..own + 6];
        write([block[0], block[1], block[2], block[3], block[4], block[5]], target, own);
        let sum = block[0] + block[1] + block[2] + block[3] + block[4] + block[5];
        not_finite = sum.mul_add(T::ZERO, not_finite);
    }
    not_finite
}

/// Writes the slave's three rows of the Hessian: the negative sums of the nodes' rows, made of the sums of the form's. Returns 0 or, if
/// an entry is not finite, NaN.
///
/// # Panics
/// If a slice is too short, or there are more than 64 rows.
#[inline(always)]
pub fn write_slave_rows<T: Lane>(form: &[T], rows: FormRows, target: &mut [T]) -> T {
    let (size, own, freedoms) = (node_length(rows), 3 * rows.rows, 3 * (rows.count + 1));
    let mut negative_sums = [[T::ZERO; 3]; MOST_ROWS];
    let negative_sums = &mut negative_sums[..rows.rows];
    for node in 0..rows.count {
        let of_node = form[size * node..][..own].as_chunks::<3>().0;
        for row in 0..rows.rows {
            for axis in 0..3 {
                negative_sums[row][axis] = negative_sums[row][axis] - of_node[row][axis];
            }
        }
    }
    let mut slave = [[T::ZERO; 3]; 3];
    let mut not_finite = T::ZERO;
    for node in 0..rows.count {
        let form = &form[size * node..][..size];
        let (of_node, block) = (form[..own].as_chunks::<3>().0, &form[own..own + OWN]);
        let block =
            [[block[0], block[1], block[3]], [block[1], block[2], block[4]], [block[3], block[4], block[5]]];
        let sums = products([&*negative_sums; 2], [of_node; 2]);
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

/// Σ cᵀb + bᵀc, the rows b and c of both nodes among those of any form.
#[inline(always)]
fn products<T: Lane>(row: [&[[T; 3]]; 2], column: [&[[T; 3]]; 2]) -> [[T; 3]; 3] {
    let mut block = [[T::ZERO; 3]; 3];
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
