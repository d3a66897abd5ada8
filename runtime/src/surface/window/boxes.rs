//! Boxes around slaves.

use std::collections::BinaryHeap;

use super::{Box3, widened};
use crate::Point;
use crate::vector::bounds;

/// Boxes around groups of points, `reach` wide around each point, at most so many: groups are halved across their longest side, the
/// longest first. A box for each group leaves out what lies between.
///
/// Points that are not finite belong to no box.
pub fn boxes_around(points: &[Point], reach: f64, most: usize) -> Vec<Box3> {
    let points: Vec<Point> = points.iter().copied().filter(|x| x.iter().all(|x| x.is_finite())).collect();
    if points.is_empty() || most == 0 {
        return Vec::new();
    }
    let mut groups = vec![Group::of(points)];
    // Lengths are not negative, so that their bits have their order. A place whose group has changed since is passed over.
    let key = |groups: &[Group], k: usize| (groups[k].length.to_bits(), k);
    let mut longest = BinaryHeap::from([key(&groups, 0)]);
    while groups.len() < most {
        let Some((length, place)) = longest.pop().filter(|&(length, _)| length > 0) else { break };
        if groups[place].length.to_bits() != length {
            continue;
        }
        let halves = groups.swap_remove(place).halved();
        groups.extend(halves);
        let last = groups.len() - 1;
        longest.extend([place, last - 1, last].map(|k| key(&groups, k)));
    }
    groups.into_iter().map(|group| widened(group.bounds, reach)).collect()
}

struct Group {
    points: Vec<Point>,
    bounds: Box3,
    axis: usize,
    /// Along the axis.
    length: f64,
}

impl Group {
    fn of(points: Vec<Point>) -> Self {
        let [low, high] = bounds(points.iter().copied());
        let lengths = [0, 1, 2].map(|k: usize| high[k] - low[k]);
        let axis = (0..3).max_by(|&i, &j| lengths[i].total_cmp(&lengths[j])).unwrap_or(0);
        Self { points, bounds: [low, high], axis, length: lengths[axis] }
    }

    /// Both halves; neither is empty, as there is a length.
    fn halved(self) -> [Self; 2] {
        let Self { points, bounds: [low, high], axis, .. } = self;
        let middle = 0.5 * low[axis] + 0.5 * high[axis];
        let (one, two): (Vec<Point>, Vec<Point>) = points.into_iter().partition(|x| x[axis] <= middle);
        if two.is_empty() {
            // The middle is the highest to rounding: that goes alone.
            let (one, two) = one.into_iter().partition(|x| x[axis] < high[axis]);
            return [Self::of(one), Self::of(two)];
        }
        [Self::of(one), Self::of(two)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_has_its_reach_in_one_box() {
        let number = |k: u32| f64::from(k * 7919 % 1000) / 100.0;
        let mut points: Vec<Point> = (0..200).map(|k| [number(k), 0.1 * number(3 * k + 1), 1.0]).collect();
        for most in [1, 3, 8, 500] {
            let boxes = boxes_around(&points, 0.25, most);
            assert!(!boxes.is_empty() && boxes.len() <= most);
            for x in &points {
                let holds = |[low, high]: &Box3| {
                    (0..3).all(|k| low[k] <= x[k] - 0.25 + 1e-12 && x[k] + 0.25 - 1e-12 <= high[k])
                };
                assert!(boxes.iter().any(holds), "{most} {x:?}");
            }
        }
        // The time is not that of the square of the number.
        let many: Vec<Point> = (0..200_000).map(|k| [f64::from(k), 0.0, 0.0]).collect();
        assert_eq!(boxes_around(&many, 0.25, usize::MAX).len(), many.len());
        points = vec![[1.0, 2.0, 3.0]; 4];
        assert_eq!(boxes_around(&points, 0.5, 9), [[[0.5, 1.5, 2.5], [1.5, 2.5, 3.5]]]);
        assert!(boxes_around(&[[f64::NAN; 3]], 1.0, 4).is_empty());
        let next = f64::from_bits(1.0_f64.to_bits() + 1);
        assert_eq!(boxes_around(&[[1.0, 0.0, 0.0], [next, 0.0, 0.0]], 0.0, 2).len(), 2);
    }
}
