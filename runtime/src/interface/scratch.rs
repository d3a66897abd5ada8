//! Memory kept from one element to the next.

use super::NoContact;
use super::contacts::Slot;
use super::fold::AnchorSource;
use super::pairings::Paired;
use super::within_reach::WithinReach;
use crate::batch::{BatchScratch, Waiting};
use crate::neighbourhood::Fallback;
use crate::surface::BorderScratch;
use crate::{ContactPoint, Point};

/// Memory kept from one element to the next.
#[derive(Clone, Debug, Default)]
pub struct ElementScratch {
    pub masters: Vec<Point>,
    /// Nodes of a facet, ascending.
    pub corners: Vec<u32>,
    /// Facets around it.
    pub patch: Vec<u32>,
    pub border: BorderScratch,
    pub batch: BatchScratch,
    pub lists: Lists,
    pub within_reach: WithinReach,
    /// Which slots are evaluated.
    pub chosen: Vec<bool>,
    /// Derivatives by points some of which are images, or by an anchor.
    pub by_points: Vec<f64>,
    pub carriers: Vec<AnchorSource>,
    /// Rows of an anchor in a Hessian.
    pub rows: Vec<f64>,
}

/// Memory of lists that are empty between evaluations.
#[derive(Debug, Default)]
pub struct Lists {
    pub slots: Vec<Slot<'static>>,
    pub waiting: Vec<Waiting<'static, 'static>>,
    pub places: Vec<(usize, Paired<'static>)>,
    pub results: Vec<Result<(ContactPoint, Fallback), NoContact>>,
}

/// A copy has no memory yet.
impl Clone for Lists {
    fn clone(&self) -> Self {
        Self::default()
    }
}
