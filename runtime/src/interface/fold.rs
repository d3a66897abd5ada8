//! Derivatives by an element's points, as derivatives by the listed nodes of its slave.
//!
//! An element of nodal domains has the listed nodes that are within reach at the moment, auxiliary points on the line through two of them, and images of
//! these. Derivatives by the others are zero; those by an image x' = Q x + t go back to its node: N += Qᵀ N', M += Qᵀ M' Q. Those by an
//! auxiliary point p x + (1 − p) y go to both its ends, by their parts.

use std::cmp::Ordering;

use crate::affine::Carrier;
use crate::surface::{Image, Symmetry};

/// A point of an element.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// The nodes that carry it, by place among the listed ones; twice the same: the node itself.
    pub ends: [u32; 2],
    /// The first one's part of it; the second has what is missing to 1. Of a node itself 1.
    pub part: f64,
    /// The number of the image, if it is one of it.
    pub image: Option<u32>,
}

impl Source {
    /// A listed node, or an image of it.
    pub const fn node(listed: u32, image: Option<u32>) -> Self {
        Self { ends: [listed; 2], part: 1.0, image }
    }

    /// The listed nodes that carry it, each with its part.
    pub fn parts(self) -> impl Iterator<Item = (u32, f64)> + Clone {
        let count = if self.part == 1.0 { 1 } else { 2 };
        self.ends.into_iter().zip([self.part, 1.0 - self.part]).take(count)
    }

    /// As a point by numbers of nodes.
    pub fn point(&self, listed: &[u32]) -> FitPoint {
        FitPoint { ends: self.ends.map(|place| listed[place as usize]), part: self.part, image: self.image }
    }
}

/// A point of an element, by numbers of nodes.
#[derive(Clone, Copy, Debug)]
pub struct FitPoint {
    /// The nodes that carry it; twice the same: the node itself.
    ends: [u32; 2],
    /// As of a [`Source`].
    part: f64,
    /// The number of the image, if it is one of it.
    image: Option<u32>,
}

impl FitPoint {
    /// The first of the nodes that carry it.
    pub const fn node(&self) -> u32 {
        self.ends[0]
    }

    /// The second one, and its part of the point: of a node itself that node, and 0.
    pub const fn other(&self) -> (u32, f64) {
        (self.ends[1], 1.0 - self.part)
    }

    /// The nodes that carry it, or images of them, each with its part.
    pub fn carriers(self) -> impl Iterator<Item = (Carrier, f64)> + Clone {
        let Self { ends, part, image } = self;
        Source { ends, part, image }.parts().map(move |(node, part)| (Carrier { node, image }, part))
    }
}

impl From<u32> for FitPoint {
    fn from(node: u32) -> Self {
        Self { ends: [node; 2], part: 1.0, image: None }
    }
}

/// A carrier of an anchor.
#[derive(Clone, Copy, Debug)]
pub struct AnchorSource {
    /// Its node, by place among the listed ones.
    pub listed: u32,
    /// The number of the image, if it is one of it.
    pub image: Option<u32>,
    /// Its part of the anchor.
    pub weight: f64,
}

/// Entry (i, j ≤ i) of a packed lower triangle.
const fn packed(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

/// N and M by the listed nodes, from those by the points of an element, as far as there are any.
pub fn fold(
    (by_points, hessian_by_points): (&[f64], &[f64]),
    (gradient, hessian): (&mut [f64], &mut [f64]),
    sources: &[Source],
    symmetry: &Symmetry,
) {
    let image_of = |source: &Source| source.image.map(|number| symmetry.image(number));
    // Room for derivatives says nothing of whether they were asked for: gaps come first where only loaded slaves are derived.
    if !by_points.is_empty() {
        fold_gradient(by_points, gradient, sources, image_of);
    }
    if !hessian_by_points.is_empty() {
        fold_hessian(hessian_by_points, hessian, sources, image_of);
    }
}

/// As [`fold`], for a quantity that depends on an anchor, whose coordinates come after those of the points: derivatives by it go
/// to its carriers. `rows`: memory.
pub fn fold_with_anchor(
    (by_points, hessian_by_points): (&[f64], &[f64]),
    (gradient, hessian): (&mut [f64], &mut [f64]),
    (sources, anchor): (&[Source], &[AnchorSource]),
    symmetry: &Symmetry,
    rows: &mut Vec<f64>,
) {
    let of_number = |image: Option<u32>| image.map(|number| symmetry.image(number));
    let image_of = |source: &Source| of_number(source.image);
    let target = |part: &AnchorSource| 3 * (part.listed as usize + 1);
    let own = 3 * (sources.len() + 1);
    let (of_points, [a, b, c]) = (&by_points[..own], [0, 1, 2].map(|axis| by_points[own + axis]));
    fold_gradient(of_points, gradient, sources, image_of);
    for part in anchor {
        let values = back(of_number(part.image), [a, b, c].map(|value| part.weight * value));
        for (entry, value) in gradient[target(part)..].iter_mut().zip(values) {
            *entry += value;
        }
    }
    if hessian_by_points.is_empty() {
        return;
    }
    fold_hessian(&hessian_by_points[..packed(own, 0)], hessian, sources, image_of);
    // Rows of the anchor, by the listed nodes.
    let row = |axis: usize| &hessian_by_points[packed(own + axis, 0)..];
    let freedoms = gradient.len();
    rows.resize(3 * freedoms, 0.0);
    for (axis, listed) in rows.chunks_exact_mut(freedoms).enumerate() {
        fold_gradient(&row(axis)[..own], listed, sources, image_of);
    }
    let own_block = [0, 1, 2].map(|i: usize| [0, 1, 2].map(|j: usize| row(i.max(j))[own + i.min(j)]));
    for part in anchor {
        let (image, place) = (of_number(part.image), target(part));
        for column in (0..freedoms).step_by(3) {
            let block = [0, 1, 2].map(|i| [0, 1, 2].map(|j| part.weight * rows[i * freedoms + column + j]));
            let block = transposed(transposed(block).map(|column| back(image, column)));
            add_pair(hessian, (place, column), block);
        }
        for other in anchor {
            let block = own_block.map(|row| row.map(|value| part.weight * other.weight * value));
            let left = transposed(transposed(block).map(|column| back(image, column)));
            // Of a pair of carriers either order is met, and each adds to the lower triangle where it belongs there.
            if target(other) <= place {
                add(hessian, (place, target(other)), left.map(|row| back(of_number(other.image), row)));
            }
        }
    }
}

/// Adds a block and its transpose on the other side of the diagonal: of both what belongs to the lower triangle.
fn add_pair(hessian: &mut [f64], (row, column): (usize, usize), block: [[f64; 3]; 3]) {
    match row.cmp(&column) {
        Ordering::Greater => add(hessian, (row, column), block),
        Ordering::Less => add(hessian, (column, row), transposed(block)),
        Ordering::Equal => {
            add(hessian, (row, column), block);
            add(hessian, (row, column), transposed(block));
        }
    }
}

fn fold_gradient<'a>(
    by_points: &[f64],
    gradient: &mut [f64],
    sources: &[Source],
    image_of: impl Fn(&Source) -> Option<&'a Image>,
) {
    gradient[..3].copy_from_slice(&by_points[..3]);
    gradient[3..].fill(0.0);
    for (source, own) in sources.iter().zip(by_points[3..].as_chunks::<3>().0) {
        let values = back(image_of(source), *own);
        for (listed, part) in source.parts() {
            let place = 3 * (listed as usize + 1);
            for (axis, value) in values.into_iter().enumerate() {
                gradient[place + axis] += part * value;
            }
        }
    }
}

fn fold_hessian<'a>(
    by_points: &[f64],
    hessian: &mut [f64],
    sources: &[Source],
    image_of: impl Fn(&Source) -> Option<&'a Image>,
) {
    hessian[..packed(3, 0)].copy_from_slice(&by_points[..packed(3, 0)]);
    hessian[packed(3, 0)..].fill(0.0);
    let entry = |i: usize, j: usize| if i >= j { by_points[packed(i, j)] } else { by_points[packed(j, i)] };
    for (own, source) in sources.iter().enumerate() {
        let row = 3 * (own + 1);
        let block = |column: usize| [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(row + i, column + j)));
        let turned = |block| transposed(transposed(block).map(|column| back(image_of(source), column)));
        for (listed, part) in source.parts() {
            let target = 3 * (listed as usize + 1);
            add(hessian, (target, 0), times(turned(block(0)), part));
            // A block and its transpose are met from either side, so that each is added where it belongs to the lower triangle.
            for (other, second) in sources.iter().enumerate() {
                for (listed, other_part) in second.parts() {
                    let place = 3 * (listed as usize + 1);
                    if place > target {
                        continue;
                    }
                    let both = turned(block(3 * (other + 1))).map(|row| back(image_of(second), row));
                    add(hessian, (target, place), times(both, part * other_part));
                }
            }
        }
    }
}

/// Adds a block to the lower triangle; of one on the diagonal its lower part.
fn add(hessian: &mut [f64], (row, column): (usize, usize), block: [[f64; 3]; 3]) {
    for (i, values) in block.into_iter().enumerate() {
        for (j, value) in values.into_iter().enumerate() {
            if column + j <= row + i {
                hessian[packed(row + i, column + j)] += value;
            }
        }
    }
}

/// Qᵀ v, or v of a node itself.
pub fn back(image: Option<&Image>, v: [f64; 3]) -> [f64; 3] {
    match image {
        None => v,
        Some(image) => [0, 1, 2].map(|j| (0..3).map(|i| image.rows[i][j] * v[i]).sum()),
    }
}

fn times(block: [[f64; 3]; 3], factor: f64) -> [[f64; 3]; 3] {
    block.map(|row| row.map(|value| factor * value))
}

fn transposed(block: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| block[j][i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::SymmetryPlane;

    fn number(k: usize) -> f64 {
        (k as f64 + 0.3).sin()
    }

    /// N and M of `count` points.
    fn derivatives(count: usize) -> (Vec<f64>, Vec<f64>) {
        let rows = 3 * (count + 1);
        let numbers = |entries: usize| (0..entries).map(number).collect();
        (numbers(rows), numbers(packed(rows, 0)))
    }

    /// J of an element's coordinates by the listed ones: each of its points, by number, with what it takes from listed nodes.
    fn jacobian(points: impl Iterator<Item = (usize, Source, f64)>, symmetry: &Symmetry) -> [[f64; 12]; 15] {
        let itself = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut jacobian = [[0.0; 12]; 15];
        for axis in 0..3 {
            jacobian[axis][axis] = 1.0;
        }
        for (own, source, weight) in points {
            let rows = source.image.map_or(itself, |number| symmetry.image(number).rows);
            for i in 0..3 {
                for j in 0..3 {
                    for (listed, part) in source.parts() {
                        jacobian[3 * own + i][3 * (listed as usize + 1) + j] += part * weight * rows[i][j];
                    }
                }
            }
        }
        jacobian
    }

    /// N = Jᵀ N', M = Jᵀ M' J.
    fn assert_chain_rule(
        (n, m): (&[f64], &[f64]),
        (gradient, hessian): (&[f64], &[f64]),
        jacobian: &[[f64; 12]; 15],
    ) {
        let full = |i: usize, j: usize| m[packed(i.max(j), i.min(j))];
        for p in 0..12 {
            let expected: f64 = (0..15).map(|i| jacobian[i][p] * n[i]).sum();
            assert!((gradient[p] - expected).abs() < 1e-14);
            for q in 0..=p {
                let expected: f64 = (0..15)
                    .flat_map(|i| (0..15).map(move |j| (i, j)))
                    .map(|(i, j)| jacobian[i][p] * full(i, j) * jacobian[j][q])
                    .sum();
                assert!((hessian[packed(p, q)] - expected).abs() < 1e-13, "{p} {q}");
            }
        }
    }

    #[test]
    fn derivatives_by_images_and_auxiliary_points_go_back_to_their_nodes() {
        let plane = SymmetryPlane { point: [0.2, 0.1, 0.0], normal: [0.6, 0.8, 0.0] };
        let symmetry = Symmetry::new(&[plane], 9.0, [[0.0; 3], [1.0; 3]]).unwrap();
        let sources = [(0, 0, 1.0, None), (0, 2, 0.5, None), (2, 2, 1.0, Some(0)), (2, 1, 2.0, Some(0))]
            .map(|(one, other, part, image)| Source { ends: [one, other], part, image });
        let (n, m) = derivatives(4);
        let (mut gradient, mut hessian) = (vec![9.0; 12], vec![9.0; packed(12, 0)]);
        fold((&n, &m), (&mut gradient, &mut hessian), &sources, &symmetry);
        let points = sources.iter().enumerate().map(|(own, source)| (own + 1, *source, 1.0));
        let jacobian = jacobian(points, &symmetry);
        assert_chain_rule((&n, &m), (&gradient, &hessian), &jacobian);
    }

    #[test]
    fn derivatives_by_an_anchor_go_to_its_carriers() {
        let plane = SymmetryPlane { point: [0.2, 0.1, 0.0], normal: [0.6, 0.8, 0.0] };
        let symmetry = Symmetry::new(&[plane], 9.0, [[0.0; 3], [1.0; 3]]).unwrap();
        let sources = [
            Source::node(0, None),
            Source::node(0, Some(0)),
            Source { ends: [1, 2], part: 0.5, image: None },
        ];
        let anchor = [(0, None, 0.5), (0, Some(0), -0.25), (1, None, 0.5), (2, Some(0), 0.25)]
            .map(|(listed, image, weight)| AnchorSource { listed, image, weight });
        // Three points of the element and the anchor: as many coordinates as an element of four points has.
        let (n, m) = derivatives(4);
        let (mut gradient, mut hessian) = (vec![9.0; 12], vec![9.0; packed(12, 0)]);
        fold_with_anchor(
            (&n, &m),
            (&mut gradient, &mut hessian),
            (&sources, &anchor),
            &symmetry,
            &mut Vec::new(),
        );
        let points = sources.iter().enumerate().map(|(own, source)| (own + 1, *source, 1.0));
        let carriers = anchor.iter().map(|part| (4, Source::node(part.listed, part.image), part.weight));
        let jacobian = jacobian(points.chain(carriers), &symmetry);
        assert_chain_rule((&n, &m), (&gradient, &hessian), &jacobian);
    }
}
