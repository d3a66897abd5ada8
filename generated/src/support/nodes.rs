//! Hessians of elements with nodes of a number that is open, from their products of low rank.

use super::form::write;
use super::{Lane, packed_row};

/// Writes the entries of a packed Hessian that belong to two nodes: d²E/dxᵢdxⱼ = δᵢⱼ Dᵢ + Σ bᵢᵀ cⱼ + cᵢᵀ bⱼ, `products` of them. Before
/// the nodes' rows there are `first` others.
///
/// `form` has for each of the `count` nodes b and c of all products, one after another, then the packed lower triangle of D.
///
/// # Panics
/// If a slice is too short.
#[inline(always)]
pub fn multiply_node_rows<E: Lane, const COMPONENTS: usize>(
    first: usize,
    products: usize,
    count: usize,
    form: &[E],
    hessian: &mut [E],
) {
    let size = 2 * products * COMPONENTS + packed_row(COMPONENTS);
    // Loops by index: iterators are not always inlined, see `simd`.
    for i in 0..count {
        let of_node = &form[size * i..][..size];
        let (rows, own) = of_node.split_at(2 * products * COMPONENTS);
        let (rows, _) = rows.as_chunks::<COMPONENTS>();
        for j in 0..=i {
            let (others, _) = form[size * j..][..2 * products * COMPONENTS].as_chunks::<COMPONENTS>();
            let mut block = [[E::ZERO; COMPONENTS]; COMPONENTS];
            for row in 0..2 * products {
                // b with c, c with b
                let (x, y) = (&rows[row], &others[row ^ 1]);
                for a in 0..COMPONENTS {
                    for b in 0..COMPONENTS {
                        block[a][b] = x[a].mul_add(y[b], block[a][b]);
                    }
                }
            }
            for a in 0..COMPONENTS {
                let place = packed_row(first + COMPONENTS * i + a) + first + COMPONENTS * j;
                if i == j {
                    for b in 0..=a {
                        hessian[place + b] = block[a][b] + own[packed_row(a) + b];
                    }
                } else {
                    write(block[a], hessian, place);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_nodes_with_two_components_and_one_product() {
        // b, c, D of each node.
        let form = [[1.0, 2.0, 3.0, 5.0, 7.0, 11.0, 13.0], [-1.0, 0.5, 2.0, 4.0, 1.0, 0.0, 6.0]].concat();
        let mut hessian = vec![0.0; packed_row(5)];
        multiply_node_rows::<f64, 2>(1, 1, 2, &form, &mut hessian);
        let (b, c) = ([[1.0, 2.0], [-1.0, 0.5]], [[3.0, 5.0], [2.0, 4.0]]);
        let own = [[7.0, 11.0, 13.0], [1.0, 0.0, 6.0]];
        for (i, j) in (0..4).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            let ((p, a), (q, d)) = ((i / 2, i % 2), (j / 2, j % 2));
            let product = b[p][a] * c[q][d] + c[p][a] * b[q][d];
            let expected = if p == q { product + own[p][packed_row(a) + d] } else { product };
            assert_eq!(hessian[packed_row(1 + i) + 1 + j], expected, "{i} {j}");
        }
        assert_eq!(
            (hessian[0], hessian[1], hessian[3]),
            (0.0, 0.0, 0.0),
            "rows of the element are not touched"
        );
    }
}
