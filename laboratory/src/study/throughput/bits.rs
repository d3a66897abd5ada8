//! Hashes of what slaves have: of 10⁶ slaves the bits themselves would take 10 GB.

use diffuse_contact::Mode;
use diffuse_contact::interface::{ContactInterface, ContactRef, InterfaceError, NoContact, Outcome};

/// What is kept of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlaveBits {
    /// Of outcome, masters by number, gap, foot, normal, N and M.
    hash: u64,
    pub is_contact: bool,
    pub is_beyond_window: bool,
}

impl SlaveBits {
    /// Masters are called by `number`.
    fn of(contact: &ContactRef<'_>, number: &impl Fn(u32) -> u64) -> Self {
        let mut hash = Hash(0);
        // `Debug` of a number is exact.
        format!("{:?}", contact.outcome).bytes().for_each(|byte| hash.word(byte.into()));
        contact.nodes.iter().for_each(|&node| hash.word(number(node)));
        let point = contact.point;
        hash.numbers(&[point.gap]);
        for numbers in [&point.foot, &point.normal, contact.gradient, contact.hessian] {
            hash.numbers(numbers);
        }
        Self {
            hash: hash.0,
            is_contact: contact.outcome.is_contact(),
            is_beyond_window: matches!(contact.outcome, Outcome::None(NoContact::BeyondWindow { .. })),
        }
    }

    /// Evaluates all slaves with N and M, and hashes them as they come.
    pub fn of_all(
        interface: &ContactInterface,
        number: impl Fn(u32) -> u64,
    ) -> Result<Vec<Self>, InterfaceError> {
        let mut all = Vec::with_capacity(interface.slaves().len());
        interface.for_each(Mode::Hessian, |contact| all.push(Self::of(&contact, &number)))?;
        Ok(all)
    }
}

/// Every word takes a hash to another one: a single word that differs always shows in the end.
struct Hash(u64);

impl Hash {
    fn word(&mut self, word: u64) {
        // An odd factor, so that the product can be undone.
        self.0 = (self.0.rotate_left(23) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    fn numbers(&mut self, numbers: &[f64]) {
        self.word(numbers.len() as u64);
        numbers.iter().for_each(|x| self.word(x.to_bits()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bit_and_the_order_show() {
        let hash = |numbers: &[f64]| {
            let mut hash = Hash(0);
            hash.numbers(numbers);
            hash.0
        };
        let next = f64::from_bits(1.0_f64.to_bits() + 1);
        let others: [&[f64]; 6] = [&[1.0, 2.0], &[next, 2.0], &[2.0, 1.0], &[1.0], &[-0.0], &[0.0]];
        for (k, one) in others.iter().enumerate() {
            assert!(others[..k].iter().all(|other| hash(one) != hash(other)), "{one:?}");
        }
    }
}
