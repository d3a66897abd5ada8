//! Derivatives by an element's points, as derivatives by the listed nodes of its slave.
//!
//! An element of nodal domains has the listed nodes that are within reach at the moment, and images of them. Derivatives by the
//! others are zero; those by an image x' = Q x + t go back to its node: N += Qᵀ N', M += Qᵀ M' Q.

use std::cmp::Ordering;

use crate::surface::{Image, Symmetry};

/// A point of an element.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// Its node, by place among the listed ones.
    pub listed: u32,
    /// The number of the image, if it is one of it.
    pub image: Option<u32>,
}

/// A carrier of an anchor.
#[derive(Clone, Copy, Debug)]
pub struct AnchorSource {
    pub source: Source,
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
    let image_of = |source: &Source| source.image.map(|number| symmetry.image(number));
    let target = |part: &AnchorSource| 3 * (part.source.listed as usize + 1);
    let own = 3 * (sources.len() + 1);
    let (of_points, [a, b, c]) = (&by_points[..own], [0, 1, 2].map(|axis| by_points[own + axis]));
    fold_gradient(of_points, gradient, sources, image_of);
    for part in anchor {
        let values = back(image_of(&part.source), [a, b, c].map(|value| part.weight * value));
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
        let (image, place) = (image_of(&part.source), target(part));
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
                add(hessian, (place, target(other)), left.map(|row| back(image_of(&other.source), row)));
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
        let place = 3 * (source.listed as usize + 1);
        for (axis, value) in back(image_of(source), *own).into_iter().enumerate() {
            gradient[place + axis] += value;
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
        let (row, target) = (3 * (own + 1), 3 * (source.listed as usize + 1));
        let block = |column: usize| [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(row + i, column + j)));
        let by_slave = transposed(transposed(block(0)).map(|column| back(image_of(source), column)));
        add(hessian, (target, 0), by_slave);
        // A block and its transpose are met from either side, so that each is added where it belongs to the lower triangle.
        for (other, second) in sources.iter().enumerate() {
            let place = 3 * (second.listed as usize + 1);
            if place > target {
                continue;
            }
            let left =
                transposed(transposed(block(3 * (other + 1))).map(|column| back(image_of(source), column)));
            add(hessian, (target, place), left.map(|row| back(image_of(second), row)));
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
                    jacobian[3 * own + i][3 * (source.listed as usize + 1) + j] += weight * rows[i][j];
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
    fn derivatives_by_an_image_go_back_to_its_node() {
        let plane = SymmetryPlane { point: [0.2, 0.1, 0.0], normal: [0.6, 0.8, 0.0] };
        let symmetry = Symmetry::new(&[plane], 9.0, [[0.0; 3], [1.0; 3]]).unwrap();
        let sources = [(0, None), (0, Some(0)), (2, Some(0)), (2, None)]
            .map(|(listed, image)| Source { listed, image });
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
        let source = |(listed, image)| Source { listed, image };
        let sources = [(0, None), (0, Some(0)), (2, None)].map(source);
        let anchor = [((0, None), 0.5), ((0, Some(0)), -0.25), ((1, None), 0.5), ((2, Some(0)), 0.25)]
            .map(|(of, weight)| AnchorSource { source: source(of), weight });
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
        let carriers = anchor.iter().map(|part| (4, part.source, part.weight));
        let jacobian = jacobian(points.chain(carriers), &symmetry);
        assert_chain_rule((&n, &m), (&gradient, &hessian), &jacobian);
    }
}
