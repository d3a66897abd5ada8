//! Sets of cells of a grid as rectangles: counted and cut without looking at any cell.

/// Cells `from..to` along both axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect(pub [[i64; 2]; 2]);

impl Rect {
    /// So many cells along both axes, from 0.
    pub const fn square(side: i64) -> Self {
        Self([[0, side]; 2])
    }

    /// One cell.
    pub const fn cell([x, y]: [i64; 2]) -> Self {
        Self([[x, x + 1], [y, y + 1]])
    }

    fn length(self, axis: usize) -> i64 {
        self.0[axis][1] - self.0[axis][0]
    }

    /// Number of cells.
    pub fn count(self) -> u64 {
        (self.length(0) * self.length(1)) as u64
    }

    /// What both have.
    pub fn common(self, other: Self) -> Option<Self> {
        let common = [0, 1].map(|axis| {
            let ([a, b], [c, d]) = (self.0[axis], other.0[axis]);
            [a.max(c), b.min(d)]
        });
        common.iter().all(|[from, to]| from < to).then_some(Self(common))
    }

    /// So many cells more at each side.
    pub fn grown(self, before: i64, after: i64) -> Self {
        Self(self.0.map(|[from, to]| [from - before, to + after]))
    }

    /// All sums of a cell of this and of one of the other.
    fn plus(self, other: Self) -> Self {
        Self([0, 1].map(|axis| {
            let ([a, b], [c, d]) = (self.0[axis], other.0[axis]);
            [a + c, b + d - 1]
        }))
    }
}

/// The smallest rectangle around all; `None` for nothing.
pub fn bounds(rects: &[Rect]) -> Option<Rect> {
    rects.iter().copied().reduce(|one, other| {
        Rect([0, 1].map(|axis| {
            let ([a, b], [c, d]) = (one.0[axis], other.0[axis]);
            [a.min(c), b.max(d)]
        }))
    })
}

/// What lies within a rectangle.
pub fn within(rects: &[Rect], limits: Rect) -> Vec<Rect> {
    rects.iter().filter_map(|rect| rect.common(limits)).collect()
}

/// All sums of a cell of the one and of one of the other.
pub fn sums(rects: &[Rect], others: &[Rect]) -> Vec<Rect> {
    rects.iter().flat_map(|rect| others.iter().map(|other| rect.plus(*other))).collect()
}

/// Number of cells in any of them, which may overlap.
pub fn count(rects: &[Rect]) -> u64 {
    if let [rect] = rects {
        return rect.count();
    }
    let mut sorted = rects.to_vec();
    sorted.sort_unstable_by_key(|rect| rect.0[0][0]);
    let mut lines: Vec<i64> = rects.iter().flat_map(|rect| rect.0[1]).collect();
    lines.sort_unstable();
    lines.dedup();
    let mut all = 0;
    for pair in lines.windows(2) {
        let (mut covered, mut end) = (0, i64::MIN);
        for Rect([[from, to], [low, high]]) in &sorted {
            if *low <= pair[0] && pair[0] < *high && *to > end {
                covered += to - end.max(*from);
                end = *to;
            }
        }
        all += covered * (pair[1] - pair[0]);
    }
    all as u64
}

/// The first so many cells of rectangles that do not overlap, and the others, line by line along an axis.
pub fn split(rects: &[Rect], axis: usize, count: u64) -> [Vec<Rect>; 2] {
    let other = 1 - axis;
    let mut lines: Vec<i64> = rects.iter().flat_map(|rect| rect.0[axis]).collect();
    lines.sort_unstable();
    lines.dedup();
    let (mut first, mut rest, mut left) = (Vec::new(), Vec::new(), count as i64);
    for pair in lines.windows(2) {
        let mut slab = [[0; 2]; 2];
        slab[axis] = [pair[0], pair[1]];
        slab[other] = [i64::MIN / 4, i64::MAX / 4];
        let mut here = within(rects, Rect(slab));
        here.sort_unstable_by_key(|rect| rect.0[other][0]);
        let height: i64 = here.iter().map(|rect| rect.length(other)).sum();
        if height == 0 {
            continue;
        }
        let whole = (left / height).min(pair[1] - pair[0]);
        let mut partial = if whole < pair[1] - pair[0] { left - whole * height } else { 0 };
        left -= whole * height + partial;
        for rect in here {
            let [from, to] = rect.0[axis];
            let middle = from + whole;
            let put = |into: &mut Vec<Rect>, along: [i64; 2], across: [i64; 2]| {
                let mut own = rect;
                (own.0[axis], own.0[other]) = (along, across);
                if along[0] < along[1] && across[0] < across[1] {
                    into.push(own);
                }
            };
            let [low, high] = rect.0[other];
            put(&mut first, [from, middle], [low, high]);
            if partial > 0 {
                let cut = low + partial.min(high - low);
                partial -= cut - low;
                put(&mut first, [middle, middle + 1], [low, cut]);
                put(&mut rest, [middle, middle + 1], [cut, high]);
                put(&mut rest, [middle + 1, to], [low, high]);
            } else {
                put(&mut rest, [middle, to], [low, high]);
            }
        }
    }
    [joined(first), joined(rest)]
}

/// The same cells in fewer rectangles, where two that do not overlap have a side in common.
pub fn joined(mut rects: Vec<Rect>) -> Vec<Rect> {
    for axis in [0, 1] {
        rects.sort_unstable_by_key(|rect| (rect.0[1 - axis], rect.0[axis]));
        rects.dedup_by(|next, kept| {
            let is_one = next.0[1 - axis] == kept.0[1 - axis] && next.0[axis][0] == kept.0[axis][1];
            if is_one {
                kept.0[axis][1] = next.0[axis][1];
            }
            is_one
        });
    }
    rects
}

/// Boxes around groups of points of a grid, at most so many, as `boxes_around` of the library finds them: groups are halved across their
/// longest side, the longest first.
pub fn boxes(points: &[Rect], most: usize) -> Vec<Rect> {
    let group = |points: Vec<Rect>| bounds(&points).map(|bounds| (points, bounds));
    let longest = |bounds: &Rect| {
        let axis = usize::from(bounds.length(1) >= bounds.length(0));
        (axis, bounds.length(axis) - 1)
    };
    let mut groups: Vec<(Vec<Rect>, Rect)> = group(points.to_vec()).into_iter().collect();
    while !groups.is_empty() && groups.len() < most {
        let place = (0..groups.len()).max_by_key(|&k| longest(&groups[k].1).1);
        let Some(place) = place.filter(|&k| longest(&groups[k].1).1 > 0) else { break };
        let (points, bounds) = groups.swap_remove(place);
        let (axis, _) = longest(&bounds);
        let [from, to] = bounds.0[axis];
        let middle = (from + to - 1).div_euclid(2) + 1;
        for half in [[from, middle], [middle, to]] {
            let mut limits = bounds;
            limits.0[axis] = half;
            groups.extend(group(within(&points, limits)));
        }
    }
    groups.into_iter().map(|(_, bounds)| bounds).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use diffuse_contact::Point;
    use diffuse_contact::surface::window::boxes_around;

    use super::*;

    fn cells(rects: &[Rect]) -> Vec<[i64; 2]> {
        let of = |Rect([[a, b], [c, d]]): Rect| (a..b).flat_map(move |x| (c..d).map(move |y| [x, y]));
        rects.iter().flat_map(|rect| of(*rect)).collect()
    }

    fn set(rects: &[Rect]) -> BTreeSet<[i64; 2]> {
        cells(rects).into_iter().collect()
    }

    const SHAPE: [Rect; 4] =
        [Rect([[0, 3], [0, 5]]), Rect([[3, 9], [2, 4]]), Rect([[5, 7], [4, 9]]), Rect([[5, 12], [-3, 2]])];

    #[test]
    fn cells_are_counted_once() {
        let stencil = [Rect([[-1, 2], [0, 1]]), Rect([[0, 1], [-2, 3]])];
        let grown = sums(&SHAPE, &stencil);
        let expected: BTreeSet<[i64; 2]> = cells(&SHAPE)
            .iter()
            .flat_map(|a| cells(&stencil).into_iter().map(|b| [a[0] + b[0], a[1] + b[1]]))
            .collect();
        assert_eq!(set(&grown), expected);
        assert_eq!(count(&grown), expected.len() as u64);
        assert_eq!(count(&[]), 0);
    }

    #[test]
    fn a_split_goes_line_by_line() {
        for axis in [0, 1] {
            let mut all = cells(&SHAPE);
            assert_eq!(all.len(), set(&SHAPE).len());
            all.sort_unstable_by_key(|cell| (cell[axis], cell[1 - axis]));
            for n in 0..=all.len() {
                let [first, rest] = split(&SHAPE, axis, n as u64);
                assert_eq!(cells(&first).len(), n);
                assert_eq!(set(&first), all[..n].iter().copied().collect(), "{axis} {n}");
                assert_eq!(set(&rest), all[n..].iter().copied().collect(), "{axis} {n}");
            }
        }
    }

    #[test]
    fn boxes_are_those_of_the_library() {
        let points: Vec<Point> = cells(&SHAPE).iter().map(|&[x, y]| [x as f64, y as f64, 0.0]).collect();
        for most in [1, 2, 5, 8, 300] {
            let expected = boxes_around(&points, 0.0, most);
            let found = boxes(&SHAPE, most).into_iter().map(|Rect([[a, b], [c, d]])| {
                [[a, c, 0].map(|x| x as f64), [b - 1, d - 1, 0].map(|x| x as f64)]
            });
            assert!(found.eq(expected), "{most}");
        }
    }
}
