//! What the pairing remembers, as part of the state.

use diffuse_contact::Basis;
use diffuse_contact::interface::KeptPairing;
use diffuse_contact::neighbourhood::Fallback;
use serde::{Deserialize, Serialize};

/// The pairing of one slave node, which the next refresh may keep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SlavePairing {
    /// Its masters, in the order of the element.
    pub masters: Vec<u32>,
    /// The facet that was closest when the pairing was made.
    pub facet: u32,
    /// Natural coordinates of the closest point on it.
    pub natural: [f64; 2],
    /// Support radius, length.
    pub support_radius: f64,
    /// Whether the basis is the quadratic one; else the linear one.
    pub quadratic: bool,
    /// Layers or nodes that were needed beyond those asked for.
    pub extended_by: usize,
    /// Where the linear basis had to do: how regular the quadratic fit would have been.
    pub quadratic_regularity: Option<f64>,
}

impl From<KeptPairing> for SlavePairing {
    fn from(kept: KeptPairing) -> Self {
        let KeptPairing { masters, facet, natural, support_radius, basis, fallback } = kept;
        let (extended_by, quadratic_regularity) = match fallback {
            Fallback::Extended { by } => (by, None),
            Fallback::Linear { quadratic_regularity } => (0, Some(quadratic_regularity)),
            _ => (0, None),
        };
        let quadratic = basis == Basis::Quadratic;
        Self { masters, facet, natural, support_radius, quadratic, extended_by, quadratic_regularity }
    }
}

impl From<&SlavePairing> for KeptPairing {
    fn from(saved: &SlavePairing) -> Self {
        let &SlavePairing {
            facet,
            natural,
            support_radius,
            quadratic,
            extended_by,
            quadratic_regularity,
            ..
        } = saved;
        let fallback = match (extended_by, quadratic_regularity) {
            (_, Some(quadratic_regularity)) => Fallback::Linear { quadratic_regularity },
            (0, None) => Fallback::None,
            (by, None) => Fallback::Extended { by },
        };
        let basis = if quadratic { Basis::Quadratic } else { Basis::Linear };
        Self { masters: saved.masters.clone(), facet, natural, support_radius, basis, fallback }
    }
}
