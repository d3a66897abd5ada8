//! The history of friction, as states hold it.

use diffuse_contact::AffinePoint;
use diffuse_contact::affine::{Carrier, NotAffine};
use diffuse_contact::interface::Anchor;
use serde::{Deserialize, Serialize};

/// What a pass with friction remembers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrictionHistory {
    /// Of each slave, if it has one; `None` before the first increment.
    anchors: Option<Vec<Option<AnchorRecord>>>,
    /// Work of friction so far, energy.
    pub dissipated: f64,
}

/// An anchor as plain numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct AnchorRecord {
    opening: f64,
    /// Node, number of the image if it is one, weight.
    terms: Vec<(u32, Option<u32>, f64)>,
}

impl FrictionHistory {
    pub(super) fn new(anchors: Option<&[Option<Anchor>]>, dissipated: f64) -> Self {
        let record = |anchor: &Anchor| AnchorRecord {
            opening: anchor.opening,
            terms: anchor
                .point
                .terms()
                .iter()
                .map(|&(Carrier { node, image }, weight)| (node, image, weight))
                .collect(),
        };
        let anchors = anchors.map(|all| all.iter().map(|anchor| anchor.as_ref().map(record)).collect());
        Self { anchors, dissipated }
    }

    /// The anchors; the error is that of the slave with this place.
    pub(super) fn anchors(&self) -> Result<Option<Vec<Option<Anchor>>>, (usize, NotAffine)> {
        let anchor = |(k, record): (usize, &Option<AnchorRecord>)| {
            let Some(AnchorRecord { opening, terms }) = record else { return Ok(None) };
            let terms = terms.iter().map(|&(node, image, weight)| (Carrier { node, image }, weight));
            let point = AffinePoint::new(terms).map_err(|error| (k, error))?;
            Ok(Some(Anchor { point, opening: *opening }))
        };
        self.anchors.as_ref().map(|all| all.iter().enumerate().map(anchor).collect()).transpose()
    }
}
