//! Vectors, rotations, deterministic numbers.

use diffuse_contact::{Point, SymmetricMatrix};

/// Deterministic numbers.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence number `seed`.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A number in [−1, 1) (`SplitMix64`).
    pub fn signed(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// Three numbers in [−size, size).
    pub fn vector(&mut self, size: f64) -> Point {
        std::array::from_fn(|_| size * self.signed())
    }

    /// Rows of a rotation matrix, all rotations equally likely.
    pub fn rotation(&mut self) -> [Point; 3] {
        let [w, x, y, z] = loop {
            let q: [f64; 4] = std::array::from_fn(|_| self.signed());
            let square: f64 = q.iter().map(|x| x * x).sum();
            if (0.01..=1.0).contains(&square) {
                break q.map(|x| x / square.sqrt());
            }
        };
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }
}

/// x · y
#[must_use]
pub fn dot(x: Point, y: Point) -> f64 {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

/// x × y
#[must_use]
pub fn cross(x: Point, y: Point) -> Point {
    [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
}

/// x + y
#[must_use]
pub fn add(x: Point, y: Point) -> Point {
    std::array::from_fn(|k| x[k] + y[k])
}

/// `factor` x
#[must_use]
pub fn scale(factor: f64, x: Point) -> Point {
    x.map(|x| factor * x)
}

/// ‖x‖
#[must_use]
pub fn length(x: Point) -> f64 {
    dot(x, x).sqrt()
}

/// The rotation with rows `q`, applied to x.
#[must_use]
pub fn turn(q: &[Point; 3], x: Point) -> Point {
    q.map(|row| dot(row, x))
}

/// Q applied to every node's part of a vector over all coordinates.
#[must_use]
pub fn turned_vector(q: &[Point; 3], vector: &[f64]) -> Vec<f64> {
    vector.chunks_exact(3).flat_map(|x| turn(q, [x[0], x[1], x[2]])).collect()
}

/// Q M_ij Qᵀ for all blocks of a matrix, written out by rows.
#[must_use]
pub fn turned_rows(q: &[Point; 3], matrix: &SymmetricMatrix) -> Vec<Vec<f64>> {
    let half: Vec<Vec<f64>> = matrix.to_rows().iter().map(|row| turned_vector(q, row)).collect();
    let columns = (0..matrix.size()).map(|j| {
        let column: Vec<f64> = half.iter().map(|row| row[j]).collect();
        turned_vector(q, &column)
    });
    // The result is symmetric up to rounding: its columns serve as rows.
    columns.collect()
}
