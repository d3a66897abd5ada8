//! Derivatives of elements side by side, by nodes of which the elements have some.
//!
//! Numbers go from the lanes to their places in memory at once. Four are written where three belong: the fourth is 0 and lies where a
//! later node, a later row or nothing but zeros belongs, since places ascend.

use std::marker::PhantomData;

use super::super::form::Blocks;
use super::super::packed_row;
use super::{MOST_LANES, Vector};

/// Places of each element's slave and nodes among its derivatives, first the slave's, 0: of the k-th one for each lane.
///
/// Elements may have fewer nodes than the widest of them. What belongs to nodes that they do not have goes nowhere.
#[derive(Clone, Debug, Default)]
pub struct Spread {
    columns: Vec<[u32; MOST_LANES]>,
    /// Numbers of nodes.
    counts: [usize; MOST_LANES],
    /// Whether derivatives are by other nodes, too.
    has_others: [bool; MOST_LANES],
    /// Where rows of nodes go that an element does not have.
    nowhere: Vec<f64>,
}

/// Where Hessians of elements side by side go, block by block.
#[derive(Debug)]
pub struct Placed<'a> {
    all_columns: &'a [[u32; MOST_LANES]],
    /// Those of the Hessian of the moment, for which there is room; none before the first.
    columns: &'a [[u32; MOST_LANES]],
    counts: &'a [usize; MOST_LANES],
    nowhere: *mut f64,
    lanes: usize,
    /// Where the Hessian of the moment begins, and what is left from there on.
    targets: [*mut f64; MOST_LANES],
    left: [usize; MOST_LANES],
    /// The node whose rows are written, and where these begin.
    node: usize,
    rows: [[*mut f64; MOST_LANES]; 3],
    borrowed: PhantomData<&'a mut f64>,
}

impl Spread {
    /// Of elements with up to `count` nodes: with how many, and their places among those of its derivatives, ascending; empty if these
    /// are all.
    ///
    /// # Panics
    /// If there are more elements than [`MOST_LANES`], places do not ascend, or there are not as many as nodes.
    pub fn set<'p>(&mut self, count: usize, elements: impl Iterator<Item = (usize, &'p [u32])>) {
        self.columns.clear();
        self.columns.resize(count + 1, [0; MOST_LANES]);
        for (lane, (own, places)) in elements.enumerate() {
            assert!(places.is_empty() || places.len() == own, "{} places of {own} nodes", places.len());
            assert!(own <= count, "{own} nodes of {count}");
            self.has_others[lane] = !places.is_empty();
            self.counts[lane] = own;
            let mut last = 0;
            for (node, column) in self.columns[1..].iter_mut().enumerate() {
                let place =
                    places.get(node).map_or(if places.is_empty() { node as u32 } else { last / 3 }, |x| *x);
                // A place that is no multiple of three after the last would have overflowed.
                let next = place.checked_add(1).and_then(|place| place.checked_mul(3));
                let next = next.filter(|next| *next > last).expect("places ascend");
                (column[lane], last) = (next, next);
            }
        }
    }

    /// Writes gradients, of slave and nodes, and zeros for the nodes that an element does not have.
    ///
    /// # Panics
    /// If a target is too short, or `source` is.
    #[inline(always)]
    pub fn store_gradients<T: Vector, O>(
        &self,
        source: &[T],
        outputs: &mut [O],
        target: impl Fn(&mut O) -> &mut [f64],
    ) {
        let (source, _) = source.as_chunks::<3>();
        for lane in 0..outputs.len() {
            let target = target(&mut outputs[lane]);
            if self.has_others[lane] {
                target.fill(0.0);
            }
            for node in 0..=self.counts[lane] {
                let place = self.columns[node][lane] as usize;
                let target = &mut target[place..place + 3];
                // Not `copy_from_slice`, which is a call for three numbers.
                for axis in 0..3 {
                    target[axis] = source[node][axis].lane(lane);
                }
            }
        }
    }

    /// Writes the packed lower triangle of the element in the first lane likewise.
    ///
    /// # Panics
    /// If the target is too short, or `source` is.
    pub fn store_packed(&self, source: &[f64], target: &mut [f64]) {
        if self.has_others[0] {
            target.fill(0.0);
        }
        for (node, column) in self.columns.iter().enumerate() {
            for axis in 0..3 {
                let source = &source[packed_row(3 * node + axis)..][..3 * node + axis + 1];
                let target = &mut target[packed_row(column[0] as usize + axis)..];
                for (numbers, place) in source.chunks(3).zip(&self.columns) {
                    target[place[0] as usize..][..numbers.len()].copy_from_slice(numbers);
                }
            }
        }
    }

    /// Where packed lower triangles go, one Hessian or several after another. Those of elements that do not have all nodes are filled with
    /// zeros first.
    ///
    /// # Panics
    /// If there are more outputs than lanes.
    #[inline(always)]
    pub fn hessians<'a, O>(
        &'a mut self,
        outputs: &'a mut [O],
        target: impl Fn(&mut O) -> &mut [f64],
    ) -> Placed<'a> {
        let lanes = outputs.len();
        let mut targets = [std::ptr::null_mut(); MOST_LANES];
        let mut left = [0; MOST_LANES];
        let mut longest = 0;
        for lane in 0..lanes {
            let target = target(&mut outputs[lane]);
            if self.has_others[lane] {
                target.fill(0.0);
            }
            (targets[lane], left[lane]) = (target.as_mut_ptr(), target.len());
            longest = longest.max(self.columns[self.columns.len() - 1][lane] as usize);
        }
        // A row of the last node, and the number that is written too many.
        if self.nowhere.len() < longest + 4 {
            self.nowhere.resize(longest + 4, 0.0);
        }
        let Self { columns, counts, nowhere, .. } = self;
        Placed {
            all_columns: columns,
            columns: &[],
            counts,
            nowhere: nowhere.as_mut_ptr(),
            lanes,
            targets,
            left,
            node: 0,
            rows: [targets; 3],
            borrowed: PhantomData,
        }
    }
}

impl<'a> Placed<'a> {
    /// Goes on to a Hessian over slave and `count` nodes, of elements that have as many.
    ///
    /// # Panics
    /// If there is no room for it.
    #[inline(always)]
    pub fn next(&mut self, count: usize) -> Self {
        let mut this = Self { columns: &self.all_columns[..=count], ..*self };
        for lane in 0..self.lanes {
            let own = self.counts[lane].min(count);
            let length = packed_row(this.columns[own][lane] as usize + 3);
            assert!(length <= self.left[lane], "{length} numbers of {}", self.left[lane]);
            this.left[lane] = length;
            self.left[lane] -= length;
            // SAFETY: there are as many numbers (above).
            self.targets[lane] = unsafe { self.targets[lane].add(length) };
        }
        this
    }
}

impl<T: Vector> Blocks<T> for Placed<'_> {
    #[inline(always)]
    fn begin(&mut self, node: usize) {
        let columns = self.columns[node];
        for lane in 0..self.lanes {
            let has = node <= self.counts[lane];
            for axis in 0..3 {
                // SAFETY: the rows of a node that the element has begin before its end.
                self.rows[axis][lane] = if has {
                    unsafe { self.targets[lane].add(packed_row(columns[lane] as usize + axis)) }
                } else {
                    self.nowhere
                };
            }
        }
        self.node = node;
    }

    #[inline(always)]
    fn write_slave(&mut self, block: &[[T; 3]; 3]) {
        assert!(!self.columns.is_empty(), "no Hessian yet");
        for lane in 0..self.lanes {
            for i in 0..3 {
                for j in 0..=i {
                    // SAFETY: every Hessian has as many numbers.
                    unsafe { *self.targets[lane].add(packed_row(i) + j) = block[i][j].lane(lane) };
                }
            }
        }
    }

    #[inline(always)]
    fn write_block(&mut self, column: usize, block: &[[T; 3]; 3]) {
        assert!(column < self.node, "a node before this one");
        let places = &self.columns[column];
        for axis in 0..3 {
            let [x, y, z] = block[axis];
            // SAFETY: the row goes on at least to the block of its own node, which comes after that of the column.
            unsafe { T::store_fours([x, y, z, T::ZERO], &self.rows[axis][..self.lanes], places) };
        }
    }

    #[inline(always)]
    fn write_ends(&mut self, own: &[[T; 3]; 3], with_slave: &[[T; 3]; 3]) {
        assert!(self.node > 0, "a node");
        let places = &self.columns[self.node];
        let slave = &[0; MOST_LANES];
        let [[xx, ..], [yx, yy, _], [zx, zy, zz]] = *own;
        let o = T::ZERO;
        let [x_rows, y_rows, z_rows] = &self.rows;
        // SAFETY: what is written too much of the own block lies where the block with the slave belongs, of the next row.
        unsafe {
            T::store_fours([xx, o, o, o], &x_rows[..self.lanes], places);
            T::store_fours([yx, yy, o, o], &y_rows[..self.lanes], places);
            T::store_threes([zx, zy, zz], &z_rows[..self.lanes], places);
            for axis in 0..3 {
                T::store_threes(with_slave[axis], &self.rows[axis][..self.lanes], slave);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Isa, WithLanes};
    use super::*;

    /// Places of up to three nodes among up to seven; none: of all three, or of the first two.
    const PLACES: [(usize, &[u32]); 7] = [
        (3, &[0, 2, 3]),
        (3, &[]),
        (3, &[1, 2, 6]),
        (2, &[1, 4]),
        (3, &[0, 1, 2]),
        (2, &[]),
        (3, &[4, 5, 6]),
    ];
    const COUNT: usize = 3;
    /// Numbers behind those that belong to an element: they stay.
    const BEHIND: usize = 2;

    /// Elements in all lanes but the last, if there are several; the places from `first` on.
    struct Elements {
        first: usize,
    }

    impl WithLanes for Elements {
        type Output = ();

        #[inline(always)]
        fn run<T: Vector>(self) {
            let lanes = (T::WIDTH - 1).max(1);
            let element = |lane: usize| PLACES[(lane + self.first) % PLACES.len()];
            // Where a coordinate of the element is found among all.
            let row = |k: usize, lane: usize| match k {
                0..3 => k,
                k => {
                    3 * (1 + element(lane).1.get(k / 3 - 1).map_or(k / 3 - 1, |&place| place as usize))
                        + k % 3
                }
            };
            let own = |lane: usize| 3 * (element(lane).0 + 1);
            let all = |lane: usize| row(own(lane) - 1, lane) + 1;
            let number = |k: usize, lane: usize| (100 * lane + k) as f64 + 0.5;
            let mut spread = Spread::default();
            spread.set(COUNT, (0..lanes).map(element));
            let vector = |k: usize| T::from_fn(|lane| number(k, lane));
            let room = |length: usize, lane: usize| {
                let behind = if element(lane).1.is_empty() { BEHIND } else { 0 };
                vec![f64::NAN; length + behind]
            };

            let mut gradients: Vec<Vec<f64>> = (0..lanes).map(|lane| room(all(lane), lane)).collect();
            let source: Vec<T> = (0..3 * (COUNT + 1)).map(vector).collect();
            spread.store_gradients::<T, _>(&source, &mut gradients, |gradient| gradient);

            let entry = |row: usize, column: usize| vector(packed_row(row) + column);
            let block = |row: usize, column: usize| {
                [0, 1, 2].map(|i| {
                    [0, 1, 2].map(|j| {
                        let (i, j) = (3 * row + i, 3 * column + j);
                        entry(i.max(j), i.min(j))
                    })
                })
            };
            let mut hessians: Vec<Vec<f64>> =
                (0..lanes).map(|lane| room(packed_row(all(lane)), lane)).collect();
            let mut all_placed = spread.hessians(&mut hessians, |hessian| hessian);
            let mut placed = all_placed.next(COUNT);
            for node in (1..=COUNT).rev() {
                Blocks::<T>::begin(&mut placed, node);
                for column in 1..node {
                    placed.write_block(column, &block(node, column));
                }
                placed.write_ends(&block(node, node), &block(node, 0));
            }
            placed.write_slave(&block(0, 0));

            for lane in 0..lanes {
                let mut expected = vec![0.0; all(lane)];
                (0..own(lane)).for_each(|k| expected[row(k, lane)] = number(k, lane));
                assert_eq!(gradients[lane][..all(lane)], expected, "lane {lane} of {}", T::WIDTH);
                let mut expected = vec![0.0; packed_row(all(lane))];
                for (i, j) in (0..own(lane)).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                    expected[packed_row(row(i, lane)) + row(j, lane)] = number(packed_row(i) + j, lane);
                }
                assert_eq!(hessians[lane][..expected.len()], expected, "lane {lane} of {}", T::WIDTH);
                for numbers in [&gradients[lane][all(lane)..], &hessians[lane][expected.len()..]] {
                    assert!(numbers.iter().all(|x| x.is_nan()), "lane {lane} of {}", T::WIDTH);
                }
            }
            if T::WIDTH == 1 && element(0).0 == COUNT {
                let source: Vec<f64> = (0..packed_row(3 * (COUNT + 1))).map(|k| number(k, 0)).collect();
                let mut target = room(packed_row(all(0)), 0);
                spread.store_packed(&source, &mut target);
                assert_eq!(target[..packed_row(all(0))], hessians[0][..packed_row(all(0))]);
            }
        }
    }

    #[test]
    fn derivatives_go_to_the_places_of_their_nodes_and_others_are_zero() {
        for isa in Isa::available() {
            for first in 0..PLACES.len() {
                isa.run(Elements { first });
            }
        }
    }

    #[test]
    #[should_panic(expected = "places ascend")]
    fn places_have_to_ascend() {
        Spread::default().set(COUNT, [(COUNT, &[0, 2, 2][..])].into_iter());
    }

    #[test]
    #[should_panic(expected = "78 numbers of 77")]
    fn a_hessian_needs_room() {
        let mut spread = Spread::default();
        spread.set(COUNT, [(COUNT, &[][..])].into_iter());
        let _ = spread.hessians(&mut [[0.0; 77]], |hessian| &mut hessian[..]).next(COUNT);
    }
}
