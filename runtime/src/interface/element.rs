//! One element of an interface, taken out.

use super::evaluator::Evaluator;
use super::fold::FitPoint;
use super::pairings::Paired;
use super::scratch::ElementScratch;
use super::{ContactElement, NoContact};
use crate::Point;
use crate::pairing::Pairing;

/// A slave node and what it is paired with, at the positions of the moment. `slave` is the position of the slave node.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "one at a time is taken out, to be looked at")]
#[allow(missing_docs)] // The names say what the fields are.
pub enum PairedElement {
    /// A diffuse element, by masters with their positions, frame, support radius, basis and weight. [`Pairing::element`] makes the element
    /// that a [`Backend`](crate::Backend) evaluates.
    Diffuse { slave: Point, pairing: Pairing },
    /// An element of slave and facet, a [`FacetElement`](crate::FacetElement), by the positions of the facet's corners.
    Facet { slave: Point, corners: Vec<Point> },
}

impl Evaluator<'_> {
    /// A copy of a paired element.
    pub fn paired_element(
        &self,
        paired: &Paired<'_>,
        scratch: &mut ElementScratch,
    ) -> Result<PairedElement, NoContact> {
        let slave = self.positions[paired.slave];
        let ContactElement::Diffuse { weight, .. } = self.options.element else {
            let corners = self.gather_corners(paired, scratch).to_vec();
            return Ok(PairedElement::Facet { slave, corners });
        };
        let basis = paired.record.basis;
        let pairing = if self.nodal.is_some() {
            let points = self.points_within_reach(paired, weight, scratch)?;
            let other = |point: &FitPoint| {
                let (node, part) = point.other();
                (node as usize, part)
            };
            let mut others: Vec<(usize, f64)> = points.sources.iter().map(other).collect();
            if others.iter().all(|&(_, part)| part == 0.0) {
                others.clear();
            }
            Pairing {
                masters: points.sources.iter().map(|point| point.node() as usize).collect(),
                others,
                positions: points.positions,
                frame: points.frame,
                support_radius: points.unit,
                material: points.nodes,
                basis,
                weight,
            }
        } else {
            Pairing {
                masters: paired.masters.iter().map(|&node| node as usize).collect(),
                others: Vec::new(),
                frame: self.current_frame(paired)?,
                positions: self.gather(paired, scratch).to_vec(),
                support_radius: paired.record.support_radius,
                material: Vec::new(),
                basis,
                weight,
            }
        };
        Ok(PairedElement::Diffuse { slave, pairing })
    }
}
