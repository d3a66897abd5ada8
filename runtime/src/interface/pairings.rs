//! The pairing of all slaves, flat.

use std::ops::Range;
use std::sync::Arc;

use super::{NoContact, contacts::Layout};
use crate::neighbourhood::Fallback;
use crate::{Basis, Frame};

/// What stays fixed for one paired slave until the next refresh, besides its masters.
#[derive(Clone, Copy, Debug)]
pub struct Record {
    /// Support radius R; with nodal domains the shortest half axis of a listed one, or less where a short one is near; of a node-to-facet element the facet's extent.
    pub support_radius: f64,
    pub basis: Basis,
    pub fallback: Fallback,
    /// The facet closest to the slave: the one whose side is outside.
    pub facet: u32,
}

/// Pairing data of all slaves.
#[derive(Clone, Debug)]
pub struct Pairings {
    /// Whether they are of a refresh: slaves may be none.
    pub is_made: bool,
    /// Slaves and their masters. Masters are ascending; those of a node-to-facet element are in the facet's order, and after them come
    /// carriers of its anchors that are no corners.
    pub layout: Arc<Layout>,
    pub records: Vec<Result<Record, NoContact>>,
    /// With nodal domains: while the slave and the masters together have moved by less than this, its pairing is the same, length.
    pub slacks: Vec<f64>,
    /// One frame per slave if frames are held, else none.
    pub frames: Vec<Frame>,
    /// The patch of each slave's masters, where it ends somewhere, so that a foot may lie beyond it. A node-to-facet element has
    /// none: it needs one only once the foot is off its facet.
    pub patches: Lists,
    /// With nodal domains the sheet node of each master, as masters are; else none.
    pub sheet_nodes: Vec<u32>,
    /// Images of each slave's masters: place of the master among them and number of the image, alternating, ascending.
    pub images: Lists,
    /// Auxiliary points between each slave's masters: the places of both ends among them, number of the point among the domains, and that of
    /// the image or [`NONE`](crate::surface::NONE).
    pub auxiliary: Lists,
}

/// Lists one after another.
#[derive(Clone, Debug, Default)]
pub struct Lists {
    numbers: Vec<u32>,
    ends: Vec<usize>,
}

impl Lists {
    /// Appends a list.
    pub fn push(&mut self, list: &[u32]) {
        self.numbers.extend_from_slice(list);
        self.ends.push(self.numbers.len());
    }

    /// The `k`-th list; empty if there is none.
    pub fn get(&self, k: usize) -> &[u32] {
        if k < self.ends.len() { &self.numbers[self.range(k)] } else { &[] }
    }

    /// Where the numbers of the `k`-th list are.
    pub fn range(&self, k: usize) -> Range<usize> {
        let start = k.checked_sub(1).map_or(0, |before| self.ends[before]);
        start..self.ends[k]
    }

    /// How many numbers there are.
    pub fn count(&self) -> usize {
        self.numbers.len()
    }
}

/// One paired slave.
#[derive(Clone, Copy, Debug)]
pub struct Paired<'a> {
    pub slave: usize,
    pub masters: &'a [u32],
    pub record: &'a Record,
    /// If frames are held.
    pub frame: Option<&'a Frame>,
    /// The facets of the masters' patch if that ends somewhere.
    pub patch: &'a [u32],
    /// Of the masters; none without nodal domains.
    pub sheet_nodes: &'a [u32],
    /// Place and number of image, alternating.
    pub images: &'a [u32],
    /// Places of both ends, number, and image, four after four.
    pub auxiliary: &'a [u32],
}

impl Paired<'_> {
    /// Whether its element has other points than nodes.
    pub const fn has_others(&self) -> bool {
        !self.images.is_empty() || !self.auxiliary.is_empty()
    }
}

impl Pairings {
    /// Nobody is paired.
    pub fn none(slaves: Vec<usize>, areas: Vec<f64>) -> Self {
        let records = vec![Err(NoContact::NotPaired); slaves.len()];
        let slacks = vec![0.0; slaves.len()];
        let lengths = std::iter::repeat_n(0, slaves.len());
        let layout = Arc::new(Layout::new(slaves, areas, lengths, Vec::new()));
        let [patches, images, auxiliary] = <[Lists; 3]>::default();
        Self {
            is_made: false,
            layout,
            records,
            slacks,
            frames: Vec::new(),
            patches,
            sheet_nodes: Vec::new(),
            images,
            auxiliary,
        }
    }

    /// The `k`-th slave.
    pub fn get(&self, k: usize) -> Result<Paired<'_>, NoContact> {
        let record = self.records[k].as_ref().map_err(|reason| *reason)?;
        Ok(Paired {
            slave: self.layout.slave(k),
            masters: self.layout.masters(k),
            record,
            frame: self.frames.get(k),
            patch: self.patches.get(k),
            sheet_nodes: self.sheet_nodes.get(self.layout.masters_range(k)).unwrap_or(&[]),
            images: self.images.get(k),
            auxiliary: self.auxiliary.get(k),
        })
    }

    pub fn all(&self) -> Range<usize> {
        0..self.records.len()
    }
}
