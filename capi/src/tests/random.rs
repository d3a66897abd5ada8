//! Numbers in no order, the same ones every time.

/// SplitMix64 (Steele, Lea, Flood 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// Below `end`, which is positive.
    pub fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }

    pub fn one_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }

    pub fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }

    /// From 0 to 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A number that nobody expects, any bits now and then.
    pub fn odd_number(&mut self) -> f64 {
        let bits = f64::from_bits(self.bits());
        let choices = [
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            0.0,
            -0.0,
            -1.0,
            1e-300,
            1e70,
            1e80,
            1e300,
            f64::MAX,
            f64::MIN_POSITIVE / 4.0,
            bits,
        ];
        self.pick(&choices)
    }

    /// An integer that nobody expects.
    pub fn odd_integer(&mut self) -> i32 {
        let bits = self.bits() as i32;
        self.pick(&[-1, -2, i32::MIN, i32::MAX, 0, 1, 5, 40, 1 << 20, bits])
    }
}
