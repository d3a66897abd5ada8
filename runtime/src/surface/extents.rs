//! How large a surface is.

use super::index::SurfaceIndex;
use crate::Point;
use crate::vector::bounds;

/// How large a whole surface is in its first configuration. Of several parts they are [joined](Self::joined), in any order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extents {
    /// Lowest coordinates of a node, length.
    pub low: Point,
    /// Highest coordinates, length.
    pub high: Point,
    /// The longest edge of a facet, length.
    pub facet: f64,
}

impl Extents {
    /// Of nothing.
    pub const NONE: Self = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3], facet: 0.0 };

    /// Of a surface at these positions.
    pub(crate) fn of(index: &SurfaceIndex<'_>) -> Self {
        let [low, high] = bounds(index.positions().iter().copied());
        let facets = 0..index.surface().facet_count() as u32;
        let facet = facets.map(|facet| index.shape(facet).extent()).fold(0.0, f64::max);
        Self { low, high, facet }
    }

    /// The extent of the smallest facet at each node, in the order of the surface's nodes; infinite without one.
    pub(crate) fn at_nodes(index: &SurfaceIndex<'_>) -> Vec<f64> {
        let mut smallest = vec![f64::INFINITY; index.positions().len()];
        for facet in 0..index.surface().facet_count() as u32 {
            let extent = index.shape(facet).extent();
            for &place in index.surface().corners_of(facet as usize) {
                let smallest = &mut smallest[place as usize];
                *smallest = smallest.min(extent);
            }
        }
        smallest
    }

    /// Those of two parts together.
    #[must_use]
    pub fn joined(self, other: Self) -> Self {
        Self {
            low: [0, 1, 2].map(|axis| self.low[axis].min(other.low[axis])),
            high: [0, 1, 2].map(|axis| self.high[axis].max(other.high[axis])),
            facet: self.facet.max(other.facet),
        }
    }
}
