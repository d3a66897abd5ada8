//! Whether fits are well conditioned, and how large domains have to be for that (`docs/equations.md`, [T18]).

use super::sheets::Carried;
use crate::Weight;

/// What the fits at the centres have to reach; 0.25 is out of reach for one-sided fits.
pub(crate) const SMALLEST_SINGULAR_VALUE: f64 = 0.13;
/// Factors are tried in steps of this one, then halved in between so many times.
const STEP: f64 = 1.04;
const BISECTIONS: usize = 8;

/// A node, an auxiliary point, or an image of one, seen from a centre.
#[derive(Clone, Copy)]
pub(super) struct Near {
    /// The number of the sheet node, or of the auxiliary point.
    pub node: u32,
    /// In the plane of the centre, length.
    pub offset: [f64; 2],
    /// t1ᵀG t1, t1ᵀG t2, t2ᵀG t2 over the trace, with the axes t1, t2 of the plane and the metric G of the node's cells.
    pub cells: [f64; 3],
    /// Distance in the metric of the node's cells, or of its domain.
    pub distance: f64,
}

/// The smallest factor up to `largest` for which the nodes within reach carry the basis.
pub(super) fn smallest_factor(nodes: &[Near], weight: Weight, carried: Carried, largest: f64) -> Option<f64> {
    let size = carried.size();
    // Images in a plane along the surface stand above one another: steps from zero would lead nowhere.
    let first =
        nodes.get(size.checked_sub(1)?..)?.iter().map(|node| node.distance).find(|x| x.is_normal())?;
    let is_enough =
        |factor: f64| is_well_conditioned(nodes, weight, carried, SMALLEST_SINGULAR_VALUE, factor);
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

/// Whether no singular value of the weighted design matrix of the functions that are carried, columns scaled to length one, is below the
/// smallest one wanted, with functions of the coordinates along the centre's axes or of those in which the cells are as long in all
/// directions: the columns of long cells at an angle to the axes are all but parallel, however many nodes there are.
pub(super) fn is_well_conditioned(
    nodes: &[Near],
    weight: Weight,
    carried: Carried,
    smallest: f64,
    factor: f64,
) -> bool {
    match carried {
        Carried::Nothing => true,
        Carried::Linear => is_well::<3>(nodes, weight, smallest, factor),
        Carried::Quadratic => is_well::<6>(nodes, weight, smallest, factor),
    }
}

/// The same of the first `N` of the functions 1, a, b, a², ab, b².
fn is_well<const N: usize>(nodes: &[Near], weight: Weight, smallest: f64, factor: f64) -> bool {
    // Columns are scaled in the end: this is for their powers.
    let unit = nodes.last().map_or(1.0, |node| node.offset[0].abs().max(node.offset[1].abs()));
    let within = || {
        nodes
            .iter()
            .take_while(|node| node.distance < factor)
            .map(|node| (node, weight.fitting(node.distance / factor)))
    };
    let gram_of = |rows: [[f64; 2]; 2]| {
        let mut gram = [[0.0; N]; N];
        for (node, w) in within() {
            let [a, b] = rows.map(|row| (row[0] * node.offset[0] + row[1] * node.offset[1]) / unit);
            let p = [1.0, a, b, a * a, a * b, b * b];
            for i in 0..N {
                let weighted = w * p[i];
                for j in 0..=i {
                    gram[i][j] += weighted * p[j];
                }
            }
        }
        gram
    };
    if is_far_from_singular(gram_of([[1.0, 0.0], [0.0, 1.0]]), smallest) {
        return true;
    }
    let mean = within().fold([0.0; 3], |sums, (node, w)| [0, 1, 2].map(|k| sums[k] + w * node.cells[k]));
    // The root of the mean metric, up to a factor.
    let [xx, xy, yy] = mean.map(|entry| entry / (mean[0] + mean[2]));
    let root = (xx * yy - xy * xy).sqrt();
    is_far_from_singular(gram_of([[xx + root, xy], [xy, yy + root]]), smallest)
}

/// Whether the Gram matrix of columns, scaled to length one, less the square of the smallest singular value wanted on the diagonal, is
/// positive definite.
fn is_far_from_singular<const N: usize>(mut gram: [[f64; N]; N], smallest: f64) -> bool {
    let lengths: [f64; N] = std::array::from_fn(|k| gram[k][k].sqrt());
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
