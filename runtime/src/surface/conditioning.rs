//! Whether fits are well conditioned, and how large domains have to be for that (`docs/equations.md`, [T18]).

use std::f64::consts::SQRT_2;
use std::ops::Range;

use super::sheets::Carried;
use crate::Weight;

/// What the fits at the centres have to reach; 0.25 is out of reach for one-sided fits.
pub(super) const SMALLEST_SINGULAR_VALUE: f64 = 0.13;
/// Factors are tried in steps of this one, then halved in between so many times.
const STEP: f64 = 1.04;
const BISECTIONS: usize = 8;
/// Nodes are on a line where their moments across it are less than this fraction of those along it.
const ON_A_LINE: f64 = 1e-12;

/// A node, an auxiliary point, or an image of one, seen from a centre.
#[derive(Clone, Copy)]
pub(super) struct Near {
    /// The number of the sheet node, or of the auxiliary point.
    pub node: u32,
    /// In the plane of the centre, length.
    pub offset: [f64; 2],
    /// Distance in the metric of the node's cells, or of its domain.
    pub distance: f64,
}

/// The smallest factor up to `largest` for which the nodes within reach carry the basis.
pub(super) fn smallest_factor(nodes: &[Near], weight: Weight, carried: Carried, largest: f64) -> Option<f64> {
    let size = carried.size();
    // Images in a plane along the surface stand above one another: steps from zero would lead nowhere.
    let first =
        nodes.get(size.checked_sub(1)?..)?.iter().map(|node| node.distance).find(|x| x.is_normal())?;
    let mut within = Vec::new();
    let mut is_enough = |factor: f64| {
        is_well_conditioned((nodes, factor), weight, carried, SMALLEST_SINGULAR_VALUE, &mut within)
    };
    let (mut below, mut factor) = (first, first * STEP);
    while !is_enough(factor) {
        below = factor;
        factor *= STEP;
        if !(factor <= largest) {
            return None;
        }
    }
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (below + factor);
        if is_enough(middle) { factor = middle } else { below = middle }
    }
    (factor <= largest).then_some(factor)
}

/// Whether no singular value of the weighted design matrix of the functions that are carried is below the smallest one wanted, with
/// functions of coordinates (x, y) in which the weighted nodes spread as far in all directions about their mean, and columns
/// scaled in groups: 1; x, y; x², √2 xy, y². In-plane axes turn, and cells are long in any direction, without a difference.
///
/// Of nodes nearest first those nearer than `factor` count. `within`: memory.
pub(super) fn is_well_conditioned(
    (nodes, factor): (&[Near], f64),
    weight: Weight,
    carried: Carried,
    smallest: f64,
    within: &mut Vec<([f64; 2], f64)>,
) -> bool {
    let near = &nodes[..nodes.partition_point(|node| node.distance < factor)];
    // Groups are scaled in the end: this is for their powers.
    let unit = near.iter().flat_map(|node| node.offset).fold(0.0, |unit: f64, x| unit.max(x.abs()));
    within.clear();
    let seen = |node: &Near| (node.offset.map(|x| x / unit), weight.fitting(node.distance / factor));
    within.extend(near.iter().map(seen));
    match carried {
        Carried::Nothing => true,
        Carried::Linear => is_well::<3>(within, smallest),
        Carried::Quadratic => is_well::<6>(within, smallest),
    }
}

/// The same of the first `N` of these functions, of offsets with weights.
fn is_well<const N: usize>(within: &[([f64; 2], f64)], smallest: f64) -> bool {
    let mut sums = [0.0; 6];
    for &([a, b], w) in within {
        let (wa, wb) = (w * a, w * b);
        let terms = [w, wa, wb, wa * a, wa * b, wb * b];
        sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
    }
    let [total, a, b, aa, ab, bb] = sums;
    let [aa, ab, bb] = [aa - a * a / total, ab - a * b / total, bb - b * b / total];
    let determinant = aa * bb - ab * ab;
    if !(determinant > ON_A_LINE * (aa + bb) * (aa + bb)) {
        return false;
    }
    // The inverse root of these moments about the mean, up to a factor.
    let root = determinant.sqrt();
    let rows = [[bb + root, -ab], [-ab, aa + root]].map(|row| row.map(|entry| entry / (aa + bb)));
    // Products of two functions are moments, most of them several times.
    let (mut low, mut high) = ([0.0; 6], [0.0; 9]);
    for &(offset, w) in within {
        let [x, y] = rows.map(|row| row[0] * offset[0] + row[1] * offset[1]);
        let (wx, wy) = (w * x, w * y);
        let [xx, xy, yy] = [wx * x, wx * y, wy * y];
        low.iter_mut().zip([w, wx, wy, xx, xy, yy]).for_each(|(sum, term)| *sum += term);
        if N > 3 {
            let [xxx, xxy, xyy, yyy] = [xx * x, xx * y, xy * y, yy * y];
            let terms = [xxx, xxy, xyy, yyy, xxx * x, xxx * y, xxy * y, xyy * y, yyy * y];
            high.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
    }
    let [w, x, y, xx, xy, yy] = low;
    let [xxx, xxy, xyy, yyy, x4, x3y, x2y2, xy3, y4] = high;
    // The lower triangle, row by row.
    let r = SQRT_2;
    let rows: [[f64; 6]; 6] = [
        [w, 0.0, 0.0, 0.0, 0.0, 0.0],
        [x, xx, 0.0, 0.0, 0.0, 0.0],
        [y, xy, yy, 0.0, 0.0, 0.0],
        [xx, xxx, xxy, x4, 0.0, 0.0],
        [r * xy, r * xxy, r * xyy, r * x3y, 2.0 * x2y2, 0.0],
        [yy, xyy, yyy, x2y2, r * xy3, y4],
    ];
    let gram: [[f64; N]; N] = std::array::from_fn(|i| std::array::from_fn(|j| rows[i][j]));
    is_far_from_singular(gram, smallest)
}

/// Whether the Gram matrix of columns, each group scaled to a mean square length of one, less the square of the smallest singular value
/// wanted on the diagonal, is positive definite.
fn is_far_from_singular<const N: usize>(mut gram: [[f64; N]; N], smallest: f64) -> bool {
    let length = |group: Range<usize>| {
        let count = group.len() as f64;
        (group.map(|k| gram[k][k]).sum::<f64>() / count).sqrt()
    };
    let mut lengths = [0.0; N];
    for group in [0..1, 1..3, 3..6] {
        if group.end <= N {
            lengths[group.clone()].fill(length(group));
        }
    }
    for i in 0..N {
        for j in 0..=i {
            let mut entry = gram[i][j] / (lengths[i] * lengths[j]);
            if i == j {
                entry -= smallest * smallest;
            }
            for k in 0..j {
                entry -= gram[i][k] * gram[j][k];
            }
            // The factor overwrites the matrix row by row; a row reads factors of earlier columns only.
            gram[i][j] = if i == j {
                if !(entry > 0.0) {
                    return false;
                }
                entry.sqrt()
            } else {
                entry / gram[j][j]
            };
        }
    }
    true
}
