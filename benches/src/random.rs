//! Numbers, discs and rotations at random, the same in every run and on every machine.

use diffuse_contact::Point;

/// A deterministic source of numbers (SplitMix64).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The sequence number `seed`.
    pub const fn seeded(seed: u64) -> Self {
        Self(seed)
    }

    /// A source of its own for every sequence of keys.
    pub fn new(keys: &[u64]) -> Self {
        let mut random = Self(0);
        for key in keys {
            random.0 ^= key;
            random.0 = random.next();
        }
        random
    }

    /// A number in [−1, 1).
    pub fn signed(&mut self) -> f64 {
        self.between(-1.0, 1.0)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        // 53 bits, exactly representable.
        let unit = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// Uniform in a disc about the origin.
    pub fn in_disc(&mut self, radius: f64) -> [f64; 2] {
        loop {
            let [a, b] = [self.between(-1.0, 1.0), self.between(-1.0, 1.0)];
            if a * a + b * b < 1.0 {
                return [radius * a, radius * b];
            }
        }
    }

    /// Rows of a uniformly distributed rotation: that of a quaternion uniform on the unit sphere.
    pub fn rotation(&mut self) -> [Point; 3] {
        let (w, x, y, z) = loop {
            let q: [f64; 4] = std::array::from_fn(|_| self.between(-1.0, 1.0));
            let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
            if (0.1..1.0).contains(&norm) {
                let [w, x, y, z] = q.map(|c| c / norm);
                break (w, x, y, z);
            }
        };
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }
}
