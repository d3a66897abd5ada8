//! From facet to facet without crossing a sharp edge: the nodes that make up one sheet with the closest
//! facet.
//!
//! Only distance decides which way around the end of a slit counts: a node beyond the slit belongs to the patch as soon as
//! the way there is over facets no farther from the slave than the node. How far a search goes for its nodes is for the
//! search to say.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::vector::Vector3;

use super::topology::NONE;
use super::{Creases, SurfaceIndex};
use crate::Point;

/// A patch ends where its facets turn away from the closest one by more than 89°: a height function over
/// its plane reaches no farther, whatever the feature angle.
const SMALLEST_COSINE: f64 = 0.017_452_406_437_283_51;

/// Walks over the facets around a slave, the nearest first, and only as far as it is asked to. Marks carry the
/// number of the walk, so that nothing is cleared between slaves.
#[derive(Clone, Debug, Default)]
pub struct Walk {
    generation: u32,
    /// Number of the last walk that saw the facet.
    seen: Vec<u32>,
    /// Number of the last walk that reached the node, over which facet, and its level then.
    reached: Vec<(u32, u32, u64)>,
    /// The farthest facet stepped on: the largest key popped from `next`.
    level: u64,
    /// Facets to go to, by the square of their edges' distance (the bits of a number that is not
    /// negative are ordered like it).
    next: BinaryHeap<Reverse<(u64, u32)>>,
    /// Nodes in the order in which they were reached.
    corners: Vec<u32>,
    /// Facets in the order in which they were stepped on, with the level then.
    steps: Vec<(u32, u64)>,
    /// Whether a facet was stepped on that the surface is cut at.
    met_cut: bool,
    from: Vector3,
    up: Vector3,
}

impl Walk {
    /// Starts at `facet`, for the slave at `slave`.
    pub fn start(&mut self, index: &SurfaceIndex<'_>, facet: u32, slave: Point) {
        self.seen.resize(index.surface().facet_count(), 0);
        self.reached.resize(index.surface().nodes().len(), (0, 0, 0));
        self.generation = self.generation.wrapping_add(1);
        if self.generation == 0 {
            self.seen.fill(0);
            self.reached.fill((0, 0, 0));
            self.generation = 1;
        }
        self.next.clear();
        self.corners.clear();
        self.steps.clear();
        self.level = 0;
        self.met_cut = false;
        self.from = slave.into();
        self.up = index.normals()[facet as usize];
        self.seen[facet as usize] = self.generation;
        self.next.push(Reverse((0, facet)));
    }

    /// Whether what was found since the start may depend on what lies beyond a cut.
    pub const fn met_cut(&self) -> bool {
        self.met_cut
    }

    /// Whether the node at `place` belongs to the patch: whether it is reached over facets none of which is
    /// farther from the slave, by its edges, than the node is. The answer does not depend on what has been
    /// asked before, however far the walk went for it.
    pub fn reaches(&mut self, index: &SurfaceIndex<'_>, creases: &Creases, place: usize) -> bool {
        let distance = self.square_distance(index, place as u32).to_bits();
        self.go_on(index, creases, distance);
        let (generation, _, level) = self.reached[place];
        generation == self.generation && level <= distance
    }

    /// The nodes of the patch nearer to the slave than `reach`, ascending, each with the facet over which it was reached. To be asked
    /// once after a start. Returns whether there are no others, however far away.
    pub fn nodes_within(
        &mut self,
        index: &SurfaceIndex<'_>,
        creases: &Creases,
        reach: f64,
        found: &mut Vec<(u32, u32)>,
    ) -> bool {
        let limit = (reach * reach).to_bits();
        self.go_on(index, creases, limit);
        found.clear();
        let mut is_all = self.next.is_empty();
        for &place in &self.corners {
            let square = self.square_distance(index, place).to_bits();
            let (_, facet, level) = self.reached[place as usize];
            is_all &= square < limit;
            if square < limit && level <= square {
                found.push((place, facet));
            }
        }
        found.sort_unstable_by_key(|&(place, _)| place);
        is_all
    }

    /// The facets stepped on since the start. `f` gets each with the question whether a point of it belongs to what was asked for: it is
    /// nearer to the slave than `reach`, and reached over facets none of which is farther than it.
    pub fn facets_within(&self, reach: f64, mut f: impl FnMut(u32, &dyn Fn(Vector3) -> bool)) {
        for &(facet, level) in &self.steps {
            f(facet, &|point| {
                let square = (point - self.from).norm_squared();
                square < reach * reach && level <= square.to_bits()
            });
        }
    }

    /// Steps on the facets that are as near as this, the bits of a square.
    fn go_on(&mut self, index: &SurfaceIndex<'_>, creases: &Creases, limit: u64) {
        while let Some(&Reverse((nearest, facet))) = self.next.peek()
            && nearest <= limit
        {
            self.next.pop();
            self.level = self.level.max(nearest);
            self.step_on(index, creases, facet as usize);
        }
    }

    /// Marks the corners of a facet, and sees its neighbours across edges that are not sharp.
    fn step_on(&mut self, index: &SurfaceIndex<'_>, creases: &Creases, facet: usize) {
        let surface = index.surface();
        self.steps.push((facet as u32, self.level));
        for &corner in surface.corners_of(facet) {
            let reached = &mut self.reached[corner as usize];
            // The nearest facets come first, so that the first level is the lowest.
            if reached.0 != self.generation {
                *reached = (self.generation, facet as u32, self.level);
                self.corners.push(corner);
            }
        }
        for (edge, &other) in surface.across(facet).iter().enumerate() {
            self.met_cut |= other == NONE && surface.is_cut(facet, edge);
            let seen = |other: u32| self.seen[other as usize] == self.generation;
            if other == NONE || creases.ends_at(facet, edge) || seen(other) {
                continue;
            }
            self.seen[other as usize] = self.generation;
            if index.normals()[other as usize].dot(&self.up) > SMALLEST_COSINE {
                // By corners alone a way straight over long facets would be farther than the node that it leads to.
                let nearest = index.shape(other).square_from_edges(self.from);
                self.next.push(Reverse((nearest.to_bits(), other)));
            }
        }
    }

    fn square_distance(&self, index: &SurfaceIndex<'_>, place: u32) -> f64 {
        (Vector3::from(index.positions()[place as usize]) - self.from).norm_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Facet, MasterSurface, Symmetry};

    /// Facets of a grid of `columns` × `rows` nodes, row by row, seen from the side to which columns × rows points.
    fn grid(columns: usize, rows: usize, first: usize) -> Vec<Facet> {
        (0..(rows - 1) * (columns - 1))
            .map(|k| first + k % (columns - 1) + columns * (k / (columns - 1)))
            .map(|k| Facet::Quadrilateral([k, k + 1, k + columns + 1, k + columns]))
            .collect()
    }

    /// The nodes reached by a walk from the facet closest to `slave`, asked in the order of distance and against it.
    fn reached(positions: &[Point], facets: Vec<Facet>, slave: Point, feature_angle: f64) -> Vec<usize> {
        let surface = MasterSurface::new(positions, facets).unwrap();
        let index = surface.at(positions).unwrap();
        let creases = Creases::new(&index, feature_angle.to_radians(), &Symmetry::default());
        let facet = index.closest_among_ties(slave, &mut Vec::new()).unwrap().facet;
        let mut walk = Walk::default();
        let square = |k: usize| (Vector3::from(positions[k]) - Vector3::from(slave)).norm_squared();
        let mut order: Vec<usize> = (0..positions.len()).collect();
        order.sort_by(|&i, &j| square(i).total_cmp(&square(j)));
        let mut found = Vec::new();
        for round in 0..2 {
            walk.start(&index, facet, slave);
            let before = std::mem::take(&mut found);
            found = order.iter().copied().filter(|&k| walk.reaches(&index, &creases, k)).collect();
            found.sort_unstable();
            assert_eq!(walk.generation, round + 1);
            assert!(round == 0 || found == before, "the order of the questions counts");
            order.reverse();
        }
        let again: Vec<usize> = (0..positions.len()).filter(|&k| walk.reaches(&index, &creases, k)).collect();
        assert_eq!(again, found, "asked again");
        found
    }

    /// A strip of width 1 along y whose cross section is a polygon in the plane (x, z).
    fn profile(points: &[[f64; 2]]) -> (Vec<Point>, Vec<Facet>) {
        let row = |y: f64| points.iter().map(move |[x, z]| [*x, y, *z]);
        (row(0.0).chain(row(1.0)).collect(), grid(points.len(), 2, 0))
    }

    #[test]
    fn a_walk_stops_at_edges_sharper_than_the_feature_angle() {
        // Level, up by 40°, up by another 40°.
        let (s, c) = 40f64.to_radians().sin_cos();
        let (s2, c2) = 80f64.to_radians().sin_cos();
        let bend = [[-1.0, 0.0], [0.0, 0.0], [c, s], [c + c2, s + s2]];
        let (positions, facets) = profile(&bend);
        let at = |feature| reached(&positions, facets.clone(), [-0.5, 0.5, 0.1], feature);
        assert_eq!(at(45.0), [0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(at(40.0), [0, 1, 2, 3, 4, 5, 6, 7], "the feature angle itself does not stop it");
        assert_eq!(at(39.9), [0, 1, 4, 5]);
    }

    #[test]
    fn a_walk_does_not_turn_back() {
        // An octagon's outline: every edge is 45°.
        let octagon: Vec<[f64; 2]> = (0..=8)
            .map(|k| (std::f64::consts::FRAC_PI_8 * f64::from(2 * k - 1)).sin_cos())
            .map(|(s, c)| [s, c])
            .collect();
        let (positions, facets) = profile(&octagon);
        let found = reached(&positions, facets, [0.0, 0.5, 1.0], 45.0);
        assert_eq!(
            found,
            [0, 1, 2, 9, 10, 11],
            "the facet above, one to the right; the outline is open to the left"
        );
    }

    #[test]
    fn the_far_face_of_a_plate_is_out_of_reach_although_near() {
        // Two layers 0.01 apart, joined at x = 3 by a rounded rim of 30° steps.
        let rim = (1..6).map(|k| (30.0 * f64::from(k)).to_radians().sin_cos());
        let mut points: Vec<[f64; 2]> = (0..4).map(|k| [f64::from(k), 0.005]).collect();
        points.extend(rim.map(|(s, c)| [3.0 + 0.005 * s, 0.005 * c]));
        points.extend((0..4).rev().map(|k| [f64::from(k), -0.005]));
        let (positions, facets) = profile(&points);
        let found = reached(&positions, facets, [2.5, 0.5, 0.006], 45.0);
        let upper = |k: &usize| positions[*k][2] > 0.0;
        assert!(found.iter().filter(|k| positions[**k][0] <= 3.0).all(upper), "{found:?}");
        assert!(found.contains(&0) && found.contains(&3));
    }

    #[test]
    fn across_a_slit_a_node_is_reached_only_if_the_way_around_is_no_farther() {
        // Unit squares over |x| ≤ 6, 0 ≤ y ≤ 5, whose left and right half have a column of nodes each along x = 0,
        // joined above y = 3 only: nodes are numbered forwards and backwards.
        let node = |x: i32, y: i32, right: bool| {
            if right && x == 0 && y < 3 { 78 + y } else { 13 * y + x + 6 }
        };
        let mut positions: Vec<Point> =
            (0..78).map(|k| [f64::from(k % 13) - 6.0, f64::from(k / 13), 0.0]).collect();
        positions.extend((0..3).map(|y| [0.0, f64::from(y), 0.0]));
        let corners = (0..60).map(|k| (k % 12 - 6, k / 12)).map(|(x, y)| {
            [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)].map(|(i, j)| node(i, j, x >= 0) as usize)
        });
        let facets: Vec<Facet> = corners.map(Facet::Quadrilateral).collect();
        let slave = [-0.6, 0.4, 0.1];
        let found = reached(&positions, facets.clone(), slave, 45.0);
        // The way around is over the facets at (0, 3), which is 2.67 away.
        let around = 0.6f64.hypot(2.6).hypot(0.1);
        for (k, &[x, y, z]) in positions.iter().enumerate() {
            let right = x > 0.0 || k >= 78;
            let distance = (x - slave[0]).hypot(y - slave[1]).hypot(z - slave[2]);
            assert_eq!(found.contains(&k), !right || distance >= around - 1e-12, "{x} {y} {distance}");
        }
        let last = positions.len() - 1;
        let backwards: Vec<Point> = positions.iter().rev().copied().collect();
        let renumbered = facets.iter().map(|facet| match facet {
            Facet::Triangle(corners) => Facet::Triangle(corners.map(|k| last - k)),
            Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners.map(|k| last - k)),
        });
        let mut other = reached(&backwards, renumbered.collect(), slave, 45.0);
        other.iter_mut().for_each(|k| *k = last - *k);
        other.sort_unstable();
        assert_eq!(other, found);
    }
}
