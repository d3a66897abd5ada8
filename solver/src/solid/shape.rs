//! Trilinear shape functions and their integration points on the cube [−1, 1]³.

use super::POINTS;

/// Natural coordinates of the nodes: a quadrilateral, then the opposite one.
const NODES: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// 1/√3, where Gauss's two points lie. Their weight is 1.
const GAUSS: f64 = 0.577_350_269_189_625_8;

/// Natural coordinates of an integration point; it lies towards the node of the same index.
fn point(index: usize) -> [f64; 3] {
    NODES[index].map(|coordinate| GAUSS * coordinate)
}

/// Natural gradients of the shape functions of the nodes at an integration point.
pub(super) fn gradients(index: usize) -> [[f64; 3]; 8] {
    let at = point(index);
    NODES.map(|node| {
        let factor = [0, 1, 2].map(|axis| 1.0 + node[axis] * at[axis]);
        [
            0.125 * node[0] * factor[1] * factor[2],
            0.125 * node[1] * factor[0] * factor[2],
            0.125 * node[2] * factor[0] * factor[1],
        ]
    })
}

/// Values at a node of the trilinear functions that are 1 at one integration point and 0 at the others: what extrapolates
/// values at the points to the node. They add up to 1.
pub(super) fn extrapolation(node: usize) -> [f64; POINTS] {
    std::array::from_fn(|index| {
        let towards = point(index);
        (0..3).map(|axis| 0.5 * (1.0 + NODES[node][axis] * towards[axis] * 3.0)).product()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A trilinear function is found again from its values at the points.
    #[test]
    fn extrapolation_is_exact_for_trilinear_functions() {
        let f = |[x, y, z]: [f64; 3]| 1.0 + 2.0 * x - y + 0.5 * z + x * y - 3.0 * y * z + 0.7 * x * y * z;
        for node in 0..8 {
            let weights = extrapolation(node);
            let value: f64 = (0..POINTS).map(|q| weights[q] * f(point(q))).sum();
            assert!((value - f(NODES[node])).abs() < 1e-14, "{node}: {value}");
        }
    }

    /// The gradients reproduce linear functions and a constant.
    #[test]
    fn gradients_reproduce_linear_functions() {
        for q in 0..POINTS {
            let gradients = gradients(q);
            for i in 0..3 {
                for j in 0..3 {
                    let sum: f64 = (0..8).map(|a| NODES[a][i] * gradients[a][j]).sum();
                    assert!((sum - f64::from(u8::from(i == j))).abs() < 1e-15);
                }
                assert!((0..8).map(|a| gradients[a][i]).sum::<f64>().abs() < 1e-15);
            }
        }
    }
}
