//! Sparse matrices of small blocks in compressed rows. Every row is computed by one thread in one order: results are the same bits for
//! any number of threads.

use rayon::prelude::*;

/// A block of R × C.
pub type Block<const R: usize, const C: usize> = [[f64; C]; R];

/// Rows or entries of vectors that one task takes.
pub const CHUNK: usize = 1024;

/// A matrix that owns its blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Sparse<const R: usize, const C: usize> {
    /// Where the row of each node begins, and the end.
    pub starts: Vec<usize>,
    /// Columns of the blocks.
    pub columns: Vec<u32>,
    /// The blocks.
    pub blocks: Vec<Block<R, C>>,
    /// Number of columns.
    pub width: usize,
}

/// A matrix of somebody else's.
#[derive(Clone, Copy, Debug)]
pub struct View<'a, const R: usize, const C: usize> {
    /// Where the row of each node begins, and the end.
    pub starts: &'a [usize],
    /// Columns of the blocks.
    pub columns: &'a [u32],
    /// The blocks.
    pub blocks: &'a [Block<R, C>],
    /// Number of columns.
    pub width: usize,
}

impl<const R: usize, const C: usize> Sparse<R, C> {
    /// To be read.
    pub fn view(&self) -> View<'_, R, C> {
        let Self { starts, columns, blocks, width } = self;
        View { starts, columns, blocks, width: *width }
    }

    /// Rows given one after the other.
    pub fn from_rows(width: usize, rows: impl Iterator<Item = Vec<(u32, Block<R, C>)>>) -> Self {
        let mut new = Self { starts: vec![0], columns: Vec::new(), blocks: Vec::new(), width };
        for row in rows {
            for (column, block) in row {
                new.columns.push(column);
                new.blocks.push(block);
            }
            new.starts.push(new.columns.len());
        }
        new
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        self.starts.len() * size_of::<usize>() + self.columns.len() * (4 + size_of::<Block<R, C>>())
    }
}

impl<'a, const R: usize, const C: usize> View<'a, R, C> {
    /// Number of rows.
    pub fn height(&self) -> usize {
        self.starts.len() - 1
    }

    /// The blocks of a row with their columns.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, &'a Block<R, C>)> + use<'a, R, C> {
        let own = self.starts[row]..self.starts[row + 1];
        self.columns[own.clone()].iter().map(|&column| column as usize).zip(&self.blocks[own])
    }

    /// The block of a pair in a row with ascending columns.
    pub fn block(&self, row: usize, column: usize) -> Option<&'a Block<R, C>> {
        let start = self.starts[row];
        let place = self.columns[start..self.starts[row + 1]].binary_search(&(column as u32)).ok()?;
        Some(&self.blocks[start + place])
    }

    /// y = A x
    pub fn multiply(&self, x: &[[f64; C]], y: &mut [[f64; R]]) {
        y.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, y)| {
            for (k, y) in y.iter_mut().enumerate() {
                let mut sum = [0.0; R];
                for (column, block) in self.row(chunk * CHUNK + k) {
                    add_product(&mut sum, block, &x[column]);
                }
                *y = sum;
            }
        });
    }

    /// Aᵀ, the columns of each row ascending.
    pub fn transposed(&self) -> Sparse<C, R> {
        let mut starts = vec![0; self.width + 1];
        self.columns.iter().for_each(|&column| starts[column as usize + 1] += 1);
        for column in 0..self.width {
            starts[column + 1] += starts[column];
        }
        let mut next = starts.clone();
        let mut columns = vec![0; self.columns.len()];
        let mut blocks = vec![[[0.0; R]; C]; self.columns.len()];
        for row in 0..self.height() {
            for (column, block) in self.row(row) {
                let place = next[column];
                next[column] += 1;
                columns[place] = row as u32;
                for i in 0..R {
                    for j in 0..C {
                        blocks[place][j][i] = block[i][j];
                    }
                }
            }
        }
        Sparse { starts, columns, blocks, width: self.height() }
    }

    /// A B, the columns of each row ascending.
    pub fn product<const D: usize>(&self, other: View<'_, C, D>) -> Sparse<R, D> {
        let chunks = self.height().div_ceil(CHUNK);
        let parts: Vec<_> = (0..chunks).into_par_iter().map(|chunk| self.product_of(chunk, other)).collect();
        let mut product =
            Sparse { starts: vec![0], columns: Vec::new(), blocks: Vec::new(), width: other.width };
        let total = parts.iter().map(|(_, columns, _)| columns.len()).sum();
        product.starts.reserve_exact(self.height());
        product.columns.reserve_exact(total);
        product.blocks.reserve_exact(total);
        for (ends, columns, blocks) in parts {
            let before = product.columns.len();
            product.starts.extend(ends.into_iter().map(|end| before + end));
            product.columns.extend(columns);
            product.blocks.extend(blocks);
        }
        product
    }

    /// The rows of one chunk of A B: their ends, columns and blocks.
    fn product_of<const D: usize>(
        &self,
        chunk: usize,
        other: View<'_, C, D>,
    ) -> (Vec<usize>, Vec<u32>, Vec<Block<R, D>>) {
        let (mut ends, mut columns, mut blocks) = (Vec::new(), Vec::new(), Vec::<Block<R, D>>::new());
        let mut place_of = vec![u32::MAX; other.width];
        let mut touched: Vec<u32> = Vec::new();
        for row in chunk * CHUNK..self.height().min((chunk + 1) * CHUNK) {
            touched.clear();
            for (middle, _) in self.row(row) {
                for &column in &other.columns[other.starts[middle]..other.starts[middle + 1]] {
                    if place_of[column as usize] == u32::MAX {
                        place_of[column as usize] = 0;
                        touched.push(column);
                    }
                }
            }
            touched.sort_unstable();
            let first = columns.len();
            for (k, &column) in touched.iter().enumerate() {
                place_of[column as usize] = k as u32;
            }
            columns.extend_from_slice(&touched);
            blocks.resize(first + touched.len(), [[0.0; D]; R]);
            for (middle, left) in self.row(row) {
                for (column, right) in other.row(middle) {
                    let sum = &mut blocks[first + place_of[column] as usize];
                    for i in 0..R {
                        for k in 0..C {
                            for j in 0..D {
                                sum[i][j] += left[i][k] * right[k][j];
                            }
                        }
                    }
                }
            }
            touched.iter().for_each(|&column| place_of[column as usize] = u32::MAX);
            ends.push(columns.len());
        }
        (ends, columns, blocks)
    }
}

/// y ← y + A x
#[inline]
pub fn add_product<const R: usize, const C: usize>(y: &mut [f64; R], block: &Block<R, C>, x: &[f64; C]) {
    for i in 0..R {
        for j in 0..C {
            y[i] += block[i][j] * x[j];
        }
    }
}

/// The scalar product: sums of chunks in their order.
pub fn dot<const N: usize>(a: &[[f64; N]], b: &[[f64; N]]) -> f64 {
    let of_chunk = |(a, b): (&[[f64; N]], &[[f64; N]])| -> f64 {
        a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a * b).sum()
    };
    let sums: Vec<f64> = a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK)).map(of_chunk).collect();
    sums.iter().sum()
}

/// The Euclidean norm.
pub fn norm<const N: usize>(a: &[[f64; N]]) -> f64 {
    dot(a, a).sqrt()
}

/// y ← y + a x
pub fn add_scaled<const N: usize>(y: &mut [[f64; N]], a: f64, x: &[[f64; N]]) {
    y.par_chunks_mut(CHUNK).zip(x.par_chunks(CHUNK)).for_each(|(y, x)| {
        y.as_flattened_mut().iter_mut().zip(x.as_flattened()).for_each(|(y, x)| *y += a * x);
    });
}

/// y ← x + b y
pub fn scale_and_add<const N: usize>(y: &mut [[f64; N]], b: f64, x: &[[f64; N]]) {
    y.par_chunks_mut(CHUNK).zip(x.par_chunks(CHUNK)).for_each(|(y, x)| {
        y.as_flattened_mut().iter_mut().zip(x.as_flattened()).for_each(|(y, x)| *y = x + b * *y);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix of 5 × 4 blocks whose entries are small integers: sums are exact.
    fn example() -> Sparse<2, 3> {
        let entry = |row: usize, column: usize| {
            [0, 1].map(|i| [0, 1, 2].map(|j| ((7 * row + 5 * column + 3 * i + j) % 11) as f64 - 5.0))
        };
        let row = move |row: usize| {
            (0..4_u32)
                .filter(move |&column| (row as u32 + column).is_multiple_of(2))
                .map(move |column| (column, entry(row, column as usize)))
                .collect()
        };
        Sparse::from_rows(4, (0..5).map(row))
    }

    fn dense<const R: usize, const C: usize>(matrix: &Sparse<R, C>) -> nalgebra::DMatrix<f64> {
        let view = matrix.view();
        nalgebra::DMatrix::from_fn(R * view.height(), C * matrix.width, |i, j| {
            view.block(i / R, j / C).map_or(0.0, |block| block[i % R][j % C])
        })
    }

    #[test]
    fn products_and_transposes_are_those_of_dense_matrices() {
        let a = example();
        let transposed = a.view().transposed();
        assert_eq!(dense(&transposed), dense(&a).transpose());
        let product = transposed.view().product(a.view());
        assert_eq!(dense(&product), dense(&a).transpose() * dense(&a));
        for row in 0..4 {
            assert!(product.columns[product.starts[row]..product.starts[row + 1]].is_sorted());
        }
        let x: Vec<[f64; 3]> = (0..4).map(|k| [k as f64, 1.0, -2.0]).collect();
        let mut y = vec![[f64::NAN; 2]; 5];
        a.view().multiply(&x, &mut y);
        let expected = dense(&a) * nalgebra::DVector::from_column_slice(x.as_flattened());
        assert_eq!(y.as_flattened(), expected.as_slice());
    }

    #[test]
    fn sums_do_not_depend_on_the_number_of_threads() {
        let a: Vec<[f64; 3]> =
            (0..5 * CHUNK + 7).map(|k| [(k as f64).sin(), 1.0 / (k + 1) as f64, 0.1]).collect();
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| norm(&a))
        };
        assert_eq!(with(1).to_bits(), with(3).to_bits());
    }
}
