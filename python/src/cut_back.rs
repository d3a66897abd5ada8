//! Whether an increment went too far for its pairing.

use diffuse_contact::Point;
use diffuse_contact::interface::{ContactInterface, ContactRef, NoContact, Outcome, PairedElement};

/// Where an element with contact has lost its result, there is no depth to go by.
const LOST: f64 = 0.25;
/// No hint is below this.
const SMALLEST: f64 = 0.1;

/// By how much the increment should be shortened.
#[derive(Clone, Copy, Debug)]
pub struct CutBack {
    /// From 0.1 to 1; 1: not at all.
    pub factor: f64,
    /// The slave that asks for it, and the code of its outcome.
    pub slave: Option<(usize, &'static str)>,
}

/// The hint after an evaluation.
///
/// * A slave that penetrated at the evaluation before, `was_active`, and whose element now has no result asks for 0.25.
///   That it is too far or beyond the border is a result.
/// * A slave that is deeper than `limit` times the reach of its element, its support radius or the extent of its facet,
///   asks for that depth over its own.
///
/// The least of what is asked for counts; of equal ones that of the first slave.
pub fn cut_back(interface: &ContactInterface, was_active: &[bool], limit: f64) -> CutBack {
    let mut hint = CutBack { factor: 1.0, slave: None };
    for (k, contact) in interface.contacts().iter().enumerate() {
        let ContactRef { slave, outcome, point, .. } = contact;
        let factor = match outcome {
            Outcome::None(NoContact::Element { .. }) if was_active.get(k) == Some(&true) => LOST,
            Outcome::Contact { .. } if point.gap < 0.0 => match reach(interface, k) {
                Some(reach) => (limit * reach / -point.gap).clamp(SMALLEST, 1.0),
                None => 1.0,
            },
            _ => 1.0,
        };
        if factor < hint.factor {
            hint = CutBack { factor, slave: Some((slave, outcome.code())) };
        }
    }
    hint
}

/// Support radius of an element, or the largest side or diagonal of its facet.
fn reach(interface: &ContactInterface, k: usize) -> Option<f64> {
    match interface.element(k).ok()? {
        PairedElement::Diffuse { pairing, .. } => Some(pairing.support_radius),
        PairedElement::Facet { corners, .. } => {
            let distance = |x: &Point, y: &Point| (0..3).map(|axis| (x[axis] - y[axis]).powi(2)).sum::<f64>();
            let pairs = corners.iter().flat_map(|x| corners.iter().map(move |y| distance(x, y)));
            Some(pairs.fold(0.0, f64::max).sqrt())
        }
    }
}
