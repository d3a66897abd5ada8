//! Solids of compressible neo-Hooke material, from their energies.

use diffuse_contact_codegen::ElementModel;
use diffuse_contact_codegen::expr::{Expr, Mat3, Vec3, total};

/// Corners of a hexahedron in natural coordinates.
const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Corners that the edges of a hexahedron with twenty nodes are between, nodes 9 to 20.
const HEX20_EDGES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

/// Corners that the edges of a tetrahedron with ten nodes are between, nodes 5 to 10.
const TET10_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// W = μ/2 (tr C − 3) − μ ln J + λ/2 (ln J)²
fn density<'g>(m: &ElementModel<'g>, F: Mat3<'g>) -> Expr<'g> {
    let [lambda, mu] = m.parameters(["lambda", "mu"]);
    let F = m.define("F", F);
    let J = m.define("J", F.determinant());
    m.describe("F", "∂x/∂X");
    m.describe("J", "det F");
    m.describe("lambda", "λ, Lamé's first constant, force per area");
    m.describe("mu", "μ, shear modulus, force per area");
    0.5 * mu * (F.double_dot(F) - 3.0) - mu * J.ln() + 0.5 * lambda * J.ln().powi(2)
}

/// Four nodes: the deformation gradient is the same everywhere.
pub fn tet4(m: &ElementModel<'_>) {
    m.title("A tetrahedron that stores W = μ/2 (tr C − 3) − μ ln J + λ/2 (ln J)² per volume.");
    let (x, X): ([Vec3<'_>; 4], [Vec3<'_>; 4]) = (m.variable("x"), m.parameter("X"));
    let [d, D] = [x, X].map(|x| Mat3::from_columns([1, 2, 3].map(|k| x[k] - x[0])));
    m.energy(D.determinant() / 6.0 * density(m, d * D.inverse()));
    m.product();
}

/// ∫ W dV over points ξ with weights, of nodes with these shape functions of ξ.
fn isoparametric<'g, const NODES: usize>(
    m: &ElementModel<'g>,
    points: &[([f64; 3], f64)],
    shape: impl Fn(Vec3<'g>) -> [Expr<'g>; NODES],
) {
    let (x, X): ([Vec3<'g>; NODES], [Vec3<'g>; NODES]) = (m.variable("x"), m.parameter("X"));
    let (at, weights): (Vec<[f64; 3]>, Vec<[f64; 1]>) = points.iter().map(|&(at, w)| (at, [w])).unzip();
    let (xi, weight): (Vec3<'g>, Expr<'g>) = (m.points("xi", &at), m.points("weight", &weights));
    let N = shape(xi);
    let [d, D] = [x, X].map(|x| Mat3::from_fn(|i, j| total((0..NODES).map(|k| x[k][i] * N[k].by(xi[j])))));
    m.energy(weight * D.determinant() * density(m, d * D.inverse()));
    m.product();
}

/// Ten nodes, four points.
pub fn tet10(m: &ElementModel<'_>) {
    let (a, b) = (0.25 + 0.15 * 5_f64.sqrt(), 0.25 - 0.05 * 5_f64.sqrt());
    let points = [[b, b, b], [a, b, b], [b, a, b], [b, b, a]].map(|point| (point, 1.0 / 24.0));
    isoparametric(m, &points, |xi| {
        let L = [1.0 - xi[0] - xi[1] - xi[2], xi[0], xi[1], xi[2]];
        let corners = L.map(|L| L * (2.0 * L - 1.0));
        let edges = TET10_EDGES.map(|[a, b]| 4.0 * L[a] * L[b]);
        std::array::from_fn::<_, 10, _>(|k| if k < 4 { corners[k] } else { edges[k - 4] })
    });
}

/// Eight nodes, eight points.
pub fn hex8(m: &ElementModel<'_>) {
    let points = CORNERS.map(|corner| (corner.map(|x| x / 3_f64.sqrt()), 1.0));
    isoparametric(m, &points, |xi| {
        CORNERS.map(|c| 0.125 * (1.0 + c[0] * xi[0]) * (1.0 + c[1] * xi[1]) * (1.0 + c[2] * xi[2]))
    });
}

/// Twenty nodes, 27 points.
pub fn hex20(m: &ElementModel<'_>) {
    let line = [(-0.6_f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6_f64.sqrt(), 5.0 / 9.0)];
    let points: [_; 27] = std::array::from_fn(|k| {
        let [(x, a), (y, b), (z, c)] = [line[k % 3], line[k / 3 % 3], line[k / 9]];
        ([x, y, z], a * b * c)
    });
    isoparametric(m, &points, |xi| {
        let corner = |c: [f64; 3]| {
            let [x, y, z] = [0, 1, 2].map(|axis| c[axis] * xi[axis]);
            0.125 * (1.0 + x) * (1.0 + y) * (1.0 + z) * (x + y + z - 2.0)
        };
        // Halfway between two corners: one coordinate is zero.
        let edge = |[a, b]: [usize; 2]| {
            let factors = [0, 1, 2].map(|axis| {
                let at = 0.5 * (CORNERS[a][axis] + CORNERS[b][axis]);
                if at == 0.0 { 1.0 - xi[axis] * xi[axis] } else { 1.0 + at * xi[axis] }
            });
            0.25 * factors[0] * factors[1] * factors[2]
        };
        let (corners, edges) = (CORNERS.map(corner), HEX20_EDGES.map(edge));
        std::array::from_fn::<_, 20, _>(|k| if k < 8 { corners[k] } else { edges[k - 8] })
    });
}
