//! The sum of products Bᵀ C B over the points of an element, most of the work of a tangent.

use pulp::{Arch, Simd, WithSimd};

/// A row of strains, or stresses, in principal axes per coordinate of the nodes. A point has six: 11, 22, 33, then the shears 23, 31, 12.
pub(super) type Strains<const W: usize> = [f64; W];

/// Rows of a tile. A tile is one vector wide and stays in registers.
const ROWS: usize = 4;

/// Σ Bᵀ (C B) over the points with the widest vectors of the machine; right of the diagonal's tiles it is 0. Products are
/// added without being fused, in the same order, so that all machines find the same bits. `W` is a multiple of eight.
pub(super) fn product<const W: usize>(strains: &[Strains<W>], stresses: &[Strains<W>]) -> [[f64; W]; W] {
    Arch::new().dispatch(Product { strains, stresses })
}

struct Product<'a, const W: usize> {
    strains: &'a [Strains<W>],
    stresses: &'a [Strains<W>],
}

impl<const W: usize> WithSimd for Product<'_, W> {
    type Output = [[f64; W]; W];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut full = [[0.0; W]; W];
        let lanes = S::F64_LANES;
        for row in (0..W).step_by(ROWS) {
            for column in (0..row + ROWS).step_by(lanes) {
                let mut tile = [simd.splat_f64s(0.0); ROWS];
                for (b, s) in self.strains.iter().zip(self.stresses) {
                    // Vectors of all widths divide the row.
                    let s = S::as_simd_f64s(s).0[column / lanes];
                    let b = &b[row..row + ROWS];
                    for i in 0..ROWS {
                        tile[i] = simd.add_f64s(tile[i], simd.mul_f64s(simd.splat_f64s(b[i]), s));
                    }
                }
                for i in 0..ROWS {
                    S::as_mut_simd_f64s(&mut full[row + i]).0[column / lanes] = tile[i];
                }
            }
        }
        full
    }
}
