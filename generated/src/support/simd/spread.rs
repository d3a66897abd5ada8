//! Derivatives of elements side by side, by nodes of which the elements have some.
//!
//! Numbers go from the lanes to their places in memory at once. Four are written where three belong: the fourth is 0 and lies where a
//! later node, a later row or nothing but zeros belongs, since places ascend.

use super::super::packed_row;
use super::{MOST_LANES, Vector};

/// Places of each element's slave and nodes in its gradient, first the slave's, 0: of the k-th one for each lane.
#[derive(Clone, Debug, Default)]
pub struct Spread {
    columns: Vec<[u32; MOST_LANES]>,
    /// Whether derivatives are by other nodes, too.
    has_others: [bool; MOST_LANES],
}

impl Spread {
    /// Of elements with `count` nodes. `places`: of an element's nodes among those of its derivatives, ascending; empty if these are all.
    ///
    /// # Panics
    /// If there are more elements than [`MOST_LANES`], places do not ascend, or there are not as many as nodes.
    pub fn set<'p>(&mut self, count: usize, places: impl Iterator<Item = &'p [u32]>) {
        self.columns.clear();
        self.columns.resize(count + 1, [0; MOST_LANES]);
        for (lane, places) in places.enumerate() {
            assert!(places.is_empty() || places.len() == count, "{} places of {count} nodes", places.len());
            self.has_others[lane] = !places.is_empty();
            let mut last = 0;
            for (node, column) in self.columns[1..].iter_mut().enumerate() {
                let place = places.get(node).map_or(node as u32, |place| *place);
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
        let targets = self.targets::<T, O>(|end| end, outputs, target);
        let (last, others) = self.columns.split_last().expect("the slave");
        let (source, _) = source.as_chunks::<3>();
        let targets = &targets[..outputs.len()];
        for (column, &[x, y, z]) in others.iter().zip(source) {
            // SAFETY: the three numbers of a later node follow, for which there is room.
            unsafe { T::store_fours([x, y, z, T::ZERO], targets, column) };
        }
        // SAFETY: there is room for the numbers of the last node.
        unsafe { store_block(&source[others.len()], targets, last) };
    }

    /// Writes packed lower triangles likewise.
    ///
    /// # Panics
    /// If a target is too short, or `source` is.
    #[inline(always)]
    pub fn store_packed<T: Vector, O>(
        &self,
        source: &[T],
        outputs: &mut [O],
        target: impl Fn(&mut O) -> &mut [f64],
    ) {
        let mut rows = self.targets::<T, O>(packed_row, outputs, target);
        let (columns, lanes) = (&self.columns[..], outputs.len());
        // Rows of the slave and of nodes so far.
        let mut done = [0; MOST_LANES];
        let mut place = 0;
        for node in 0..columns.len() {
            for axis in 0..3 {
                for lane in 0..lanes {
                    let row = packed_row(columns[node][lane] as usize + axis);
                    // SAFETY: the row begins before the end of the target.
                    rows[lane] = unsafe { rows[lane].add(row - done[lane]) };
                    done[lane] = row;
                }
                let row = &source[place..place + 3 * node + axis + 1];
                place += row.len();
                let (blocks, end) = row.split_at(3 * node);
                let (blocks, _) = blocks.as_chunks::<3>();
                let targets = &rows[..lanes];
                for (column, &[x, y, z]) in columns[..node].iter().zip(blocks) {
                    // SAFETY: the row goes on at least to the block of its own node, which comes after that of the column.
                    unsafe { T::store_fours([x, y, z, T::ZERO], targets, column) };
                }
                // SAFETY: the row ends with these numbers.
                unsafe { store_block(end, targets, &columns[node]) };
            }
        }
    }

    /// Where targets begin, filled with zeros where not everything will be written. `length`: of a target, from the number of coordinates.
    #[inline(always)]
    fn targets<T: Vector, O>(
        &self,
        length: impl Fn(usize) -> usize,
        outputs: &mut [O],
        target: impl Fn(&mut O) -> &mut [f64],
    ) -> [*mut f64; MOST_LANES] {
        const { assert!(T::WIDTH <= MOST_LANES) };
        assert!(outputs.len() <= T::WIDTH, "{} elements of {} lanes", outputs.len(), T::WIDTH);
        let last = self.columns[self.columns.len() - 1];
        let mut targets = [std::ptr::null_mut(); MOST_LANES];
        for lane in 0..outputs.len() {
            let target = target(&mut outputs[lane]);
            let end = length(last[lane] as usize + 3);
            assert!(target.len() >= end, "{} numbers of {end}", target.len());
            if self.has_others[lane] {
                target.fill(0.0);
            }
            targets[lane] = target.as_mut_ptr();
        }
        targets
    }
}

/// Writes lane l of the vectors to the l-th target from its place on.
///
/// # Safety
/// There is room for them there, and there are no more targets than lanes.
#[inline(always)]
unsafe fn store_block<T: Vector>(block: &[T], targets: &[*mut f64], places: &[u32; MOST_LANES]) {
    for k in 0..block.len() {
        for lane in 0..targets.len() {
            // SAFETY: as the caller says.
            unsafe { *targets[lane].add(places[lane] as usize + k) = block[k].lane(lane) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Isa, WithLanes};
    use super::*;

    /// Places of three nodes among up to seven; none: all of three.
    const PLACES: [&[u32]; 5] = [&[0, 2, 3], &[], &[1, 2, 6], &[0, 1, 2], &[4, 5, 6]];
    const COUNT: usize = 3;
    /// Numbers behind those that belong to an element: they stay.
    const BEHIND: usize = 2;

    /// Elements in all lanes but the last, if there are several.
    struct Elements;

    impl WithLanes for Elements {
        type Output = ();

        #[inline(always)]
        fn run<T: Vector>(self) {
            let lanes = (T::WIDTH - 1).max(1);
            let places = |lane: usize| PLACES[lane % PLACES.len()];
            let own = 3 * (COUNT + 1);
            let all = |lane: usize| 3 * (1 + places(lane).last().map_or(COUNT, |&last| last as usize + 1));
            let number = |k: usize, lane: usize| (100 * lane + k) as f64 + 0.5;
            let mut spread = Spread::default();
            spread.set(COUNT, (0..lanes).map(places));
            let source = |length: usize| -> Vec<T> {
                (0..length).map(|k| T::from_fn(|lane| number(k, lane))).collect()
            };
            // Where the rows of the element are found among all.
            let row = |k: usize, lane: usize| match k {
                0..3 => k,
                k => 3 * (1 + places(lane).get(k / 3 - 1).map_or(k / 3 - 1, |&place| place as usize)) + k % 3,
            };
            let room = |length: usize, lane: usize| {
                let behind = if places(lane).is_empty() { BEHIND } else { 0 };
                vec![f64::NAN; length + behind]
            };

            let mut gradients: Vec<Vec<f64>> = (0..lanes).map(|lane| room(all(lane), lane)).collect();
            spread.store_gradients::<T, _>(&source(own), &mut gradients, |gradient| gradient);
            let mut hessians: Vec<Vec<f64>> =
                (0..lanes).map(|lane| room(packed_row(all(lane)), lane)).collect();
            spread.store_packed::<T, _>(&source(packed_row(own)), &mut hessians, |hessian| hessian);
            for lane in 0..lanes {
                let mut expected = vec![0.0; all(lane)];
                (0..own).for_each(|k| expected[row(k, lane)] = number(k, lane));
                assert_eq!(gradients[lane][..all(lane)], expected, "lane {lane} of {}", T::WIDTH);
                let mut expected = vec![0.0; packed_row(all(lane))];
                for (i, j) in (0..own).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                    expected[packed_row(row(i, lane)) + row(j, lane)] = number(packed_row(i) + j, lane);
                }
                assert_eq!(hessians[lane][..expected.len()], expected, "lane {lane} of {}", T::WIDTH);
                for numbers in [&gradients[lane][all(lane)..], &hessians[lane][expected.len()..]] {
                    assert!(numbers.iter().all(|x| x.is_nan()), "lane {lane} of {}", T::WIDTH);
                }
            }
        }
    }

    #[test]
    fn derivatives_go_to_the_places_of_their_nodes_and_others_are_zero() {
        for isa in Isa::available() {
            isa.run(Elements);
        }
    }

    #[test]
    #[should_panic(expected = "places ascend")]
    fn places_have_to_ascend() {
        Spread::default().set(COUNT, [&[0, 2, 2][..]].into_iter());
    }
}
