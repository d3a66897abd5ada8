//! What the slave's faces lay over at one time: whether they went through it later is asked of these places.

use std::ops::Range;

use super::cut::far_side;
use super::evaluate::SMALLEST_AREA;
use super::{FaceInterface, FacePoint};
use crate::Point;
use crate::surface::{SurfaceIndex, connected_parts, shape_of};

/// The places of all faces that lay over a facet when it was [asked for](FaceInterface::cover).
#[derive(Clone, Debug, Default)]
pub struct FaceCover {
    points: Vec<FacePoint>,
    /// Of each face.
    ranges: Vec<Range<usize>>,
    /// Which connected part of the master each facet is of; in a window, of what it holds of the master.
    parts: Vec<u32>,
}

/// A place of a slave face that lay over a facet of the master.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoveredPlace {
    /// The number of its face among the slave's.
    pub face: usize,
    /// The facet.
    pub facet: usize,
    natural: [f64; 2],
}

impl FaceInterface {
    /// The places of the faces that lie over the master at the positions of the last update.
    pub fn cover(&self) -> FaceCover {
        let ranges = self.cuts.iter().map(|cut| cut.points.clone()).collect();
        FaceCover { points: self.points.clone(), ranges, parts: connected_parts(self.master()) }
    }

    /// The places around the `k`-th node that lay over a connected part of the master then with which their face has no contact at the last
    /// evaluation.
    ///
    /// # Panics
    /// If there is no such node, or the cover is that of other faces.
    pub fn uncovered<'a>(
        &'a self,
        cover: &'a FaceCover,
        k: usize,
    ) -> impl Iterator<Item = CoveredPlace> + 'a {
        let part = |point: &FacePoint| cover.parts[point.facet as usize];
        let found = |&point: &usize| self.contacts.found.get(point).copied().unwrap_or(false);
        self.slaves.around[k].iter().map(|&face| face as usize).flat_map(move |face| {
            let least = SMALLEST_AREA * shape_of(&self.faces[face], &self.first).area_vector().norm();
            let mut touched: Vec<(u32, f64)> = Vec::new();
            for point in self.cuts[face].points.clone().filter(found).map(|point| &self.points[point]) {
                match touched.iter_mut().find(|(own, _)| *own == part(point)) {
                    Some((_, area)) => *area += point.weight,
                    None => touched.push((part(point), point.weight)),
                }
            }
            touched.retain(|&(_, area)| area > least);
            let points = cover.ranges.get(face).map_or(&[][..], |own| &cover.points[own.clone()]);
            let is_bare = move |point: &&FacePoint| touched.iter().all(|&(own, _)| own != part(point));
            points.iter().filter(is_bare).map(move |&FacePoint { facet, natural, .. }| CoveredPlace {
                face,
                facet: facet as usize,
                natural,
            })
        })
    }

    /// Where a place of a face is at these positions of all nodes, length.
    ///
    /// # Panics
    /// If there is no such face or position.
    pub fn position_of(&self, place: &CoveredPlace, positions: &[Point]) -> Point {
        self.skin.position(place.face, place.natural, positions)
    }

    /// The unit normal of a place's face at these positions, zero of one without an area.
    ///
    /// # Panics
    /// If there is no such face or position.
    pub fn normal_of(&self, place: &CoveredPlace, positions: &[Point]) -> Point {
        shape_of(&self.faces[place.face], positions).normal().into()
    }

    /// How deep the face may lie below the facet and still touch it, at the positions of the master's index, length: half of the body's
    /// thickness in self contact, else up to the far side of the body.
    ///
    /// # Panics
    /// If the index is that of another surface.
    pub fn deepest(&self, place: &CoveredPlace, index: &SurfaceIndex<'_>) -> f64 {
        let facet = place.facet as u32;
        match &self.own {
            Some(own) => own
                .depth_below(self.master(), self.interface.domains(), place.face as u32, facet)
                .unwrap_or(f64::INFINITY),
            None => far_side(index, facet),
        }
    }
}
