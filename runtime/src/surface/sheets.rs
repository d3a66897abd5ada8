//! Sheets in their first configuration, which domains are found on.

use super::border::Creases;
use super::index::SurfaceIndex;
use super::symmetry::Symmetry;
use super::walk::Walk;

/// Centres that one thread works on in a row.
pub(super) const CHUNK: usize = 64;

/// Sheets in their first configuration, of a whole surface or of a part.
#[derive(Clone, Copy)]
pub(crate) struct Sheets<'a> {
    pub index: &'a SurfaceIndex<'a>,
    pub creases: &'a Creases,
    pub symmetry: &'a Symmetry,
    /// Of a part of a surface: by place whether all facets at the node are there, and domains of it follow from the part.
    pub complete: Option<&'a [bool]>,
}

impl Sheets<'_> {
    /// Whether nodes that a walk has found may not be all, or not what they are.
    pub(super) fn is_open(&self, walk: &Walk, found: &[(u32, f64)]) -> bool {
        self.complete.is_some_and(|complete| {
            walk.met_cut() || found.iter().any(|&(place, _)| !complete[place as usize])
        })
    }
}

/// A node of a facet's list, or one of its images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Listed {
    pub place: u32,
    /// The number of the image, or [`NONE`].
    pub image: u32,
}

/// What the nodes around a facet carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Carried {
    Nothing,
    Linear,
    Quadratic,
}

impl Carried {
    pub const fn of(number: u8) -> Self {
        match number {
            0 => Self::Nothing,
            1 => Self::Linear,
            _ => Self::Quadratic,
        }
    }

    /// The number of functions.
    pub(super) const fn size(self) -> usize {
        match self {
            Self::Nothing => 0,
            Self::Linear => 3,
            Self::Quadratic => 6,
        }
    }
}
