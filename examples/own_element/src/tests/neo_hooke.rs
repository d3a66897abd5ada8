//! The solids of all numbers of nodes.

use diffuse_contact_kernels::support::{Isa, Mode};

use super::elements::neo_hooke;
use super::witnesses::{
    Found, Function, Number, check_by_hyper_dual, check_by_interpreter, difference, random,
};

const LAMBDA: f64 = 1.2;
const MU: f64 = 0.8;

/// ∫ W dV of nodes X at x, by interpolating polynomials: none of the kernel's shape functions is used.
struct Solid {
    X: Vec<[f64; 3]>,
    /// Slopes of the nodal values by natural coordinates, with the weight, at each point.
    points: Vec<(Vec<[f64; 3]>, f64)>,
}

/// An interpolation between values at nodes in natural coordinates.
struct Interpolation {
    /// Exponents.
    monomials: Vec<[u8; 3]>,
    nodes: Vec<[f64; 3]>,
}

impl Interpolation {
    /// Slopes by nodal values at ξ: those of the monomials times the inverse of their values at the nodes.
    fn slopes(&self, xi: [f64; 3]) -> Vec<[f64; 3]> {
        let power = |x: f64, k: u8| x.powi(i32::from(k));
        let slope = |x: f64, k: u8| if k == 0 { 0.0 } else { f64::from(k) * x.powi(i32::from(k) - 1) };
        // Rows of Vᵀ N' = p', V with a row per node and a column per monomial.
        let mut rows: Vec<Vec<f64>> = self
            .monomials
            .iter()
            .map(|&[a, b, c]| {
                let at = |node: &[f64; 3]| power(node[0], a) * power(node[1], b) * power(node[2], c);
                let [x, y, z] = xi;
                let slopes = [
                    slope(x, a) * power(y, b) * power(z, c),
                    power(x, a) * slope(y, b) * power(z, c),
                    power(x, a) * power(y, b) * slope(z, c),
                ];
                self.nodes.iter().map(at).chain(slopes).collect()
            })
            .collect();
        let size = rows.len();
        for k in 0..size {
            let pivot = (k..size).max_by(|&i, &j| rows[i][k].abs().total_cmp(&rows[j][k].abs())).unwrap();
            rows.swap(k, pivot);
            let scaled: Vec<f64> = rows[k].iter().map(|x| x / rows[k][k]).collect();
            for row in rows.iter_mut().enumerate().filter_map(|(i, row)| (i != k).then_some(row)) {
                let factor = row[k];
                row.iter_mut().zip(&scaled).for_each(|(x, y)| *x -= factor * y);
            }
            rows[k] = scaled;
        }
        rows.iter().map(|row| [0, 1, 2].map(|axis| row[size + axis])).collect()
    }
}

fn determinant<D: Number>(a: &[[D; 3]; 3]) -> D {
    let minor = |i: usize, j: usize| a[1][i] * a[2][j] - a[1][j] * a[2][i];
    a[0][0] * minor(1, 2) - a[0][1] * minor(0, 2) + a[0][2] * minor(0, 1)
}

impl Function for Solid {
    /// With F_ij det D = det(D with its row j replaced), rows by natural coordinates.
    fn at<D: Number>(&self, x: &[D]) -> D {
        let mut energy = D::from(0.0);
        for &(ref slopes, weight) in &self.points {
            let (mut now, mut before) = ([[D::from(0.0); 3]; 3], [[0.0; 3]; 3]);
            for (k, slope) in slopes.iter().enumerate() {
                for (direction, axis) in (0..9).map(|n| (n / 3, n % 3)) {
                    now[direction][axis] += x[3 * k + axis] * slope[direction];
                    before[direction][axis] += self.X[k][axis] * slope[direction];
                }
            }
            let volume = determinant(&before);
            let before = before.map(|row| row.map(D::from));
            let mut trace = D::from(0.0);
            for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
                let mut replaced = before;
                (0..3).for_each(|row| replaced[row][j] = now[row][i]);
                let f = determinant(&replaced) / volume;
                trace += f * f;
            }
            let log = (determinant(&now) / volume).ln();
            energy +=
                ((trace - 3.0) * (0.5 * MU) - log * MU + log * log * (0.5 * LAMBDA)) * (weight * volume);
        }
        energy
    }
}

/// Exponents of x, y, z up to 2 for which `holds`.
fn monomials(holds: impl Fn(&[u8; 3]) -> bool) -> Vec<[u8; 3]> {
    let all = (0..27).map(|k| [k % 3, k / 3 % 3, k / 9]);
    all.filter(|exponents| holds(exponents)).collect()
}

/// Nodes in natural coordinates where they are at first, a little off.
fn shaped(nodes: &[[f64; 3]], by: f64, seed: f64) -> Vec<[f64; 3]> {
    let mut random = random(seed);
    nodes.iter().map(|node| node.map(|x| x + by * random())).collect()
}

/// Corners, then nodes halfway between two of them.
fn with_edges(corners: &[[f64; 3]], edges: &[[usize; 2]]) -> Vec<[f64; 3]> {
    let half = |&[a, b]: &[usize; 2]| [0, 1, 2].map(|axis| 0.5 * (corners[a][axis] + corners[b][axis]));
    corners.iter().copied().chain(edges.iter().map(half)).collect()
}

fn cube() -> Vec<[f64; 3]> {
    let around = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    [-1.0, 1.0].into_iter().flat_map(|z| around.map(|[x, y]| [x, y, z])).collect()
}

/// Points of a cube, from those of a line.
fn cubed(line: &[(f64, f64)]) -> Vec<([f64; 3], f64)> {
    let mut points = Vec::new();
    for &(x, a) in line {
        for &(y, b) in line {
            points.extend(line.iter().map(|&(z, c)| ([x, y, z], a * b * c)));
        }
    }
    points
}

fn solid(nodes: Vec<[f64; 3]>, monomials: Vec<[u8; 3]>, points: Vec<([f64; 3], f64)>) -> Solid {
    let X = shaped(&nodes, 0.1, 0.13);
    let interpolation = Interpolation { monomials, nodes };
    Solid { X, points: points.into_iter().map(|(xi, weight)| (interpolation.slopes(xi), weight)).collect() }
}

/// Kernel, interpreter and automatic differentiation of one element; then a batch of elements against single ones.
macro_rules! check {
    ($module:ident, $solid:expr) => {{
        use crate::$module::{Inputs, Results, batch, evaluate};
        let solid = $solid;
        let nodes = |x: &[[f64; 3]]| std::array::from_fn(|k| x[k]);
        let element = |seed: f64| Inputs {
            x: nodes(&shaped(&solid.X, 0.1, seed)),
            X: nodes(&solid.X),
            lambda: LAMBDA,
            mu: MU,
        };
        let inputs = element(0.41);
        let results = evaluate(Mode::Hessian, &inputs);
        let found =
            Found { value: results.values.energy, gradient: &results.gradient, hessian: &results.hessian };
        let x = inputs.x.as_flattened();
        check_by_hyper_dual(&found, x, &solid);
        let numbers: [&[f64]; 4] = [x, inputs.X.as_flattened(), &[LAMBDA], &[MU]];
        check_by_interpreter(&found, neo_hooke_of::$module, &numbers, &[]);

        let elements: Vec<_> = (0..5).map(|k| element(0.2 + 0.1 * f64::from(k))).collect();
        let mut batched = vec![Results::ZERO; elements.len()];
        for isa in Isa::available() {
            batch(isa, Mode::Hessian, &elements, &mut batched);
            for (found, element) in batched.iter().zip(&elements) {
                let expected = evaluate(Mode::Hessian, element);
                let worst = difference(&found.hessian, &expected.hessian)
                    .max(difference(&found.gradient, &expected.gradient));
                assert!(worst < 1e-13, "{isa}: {worst:e}");
            }
        }
    }};
}

/// The formulas under the modules' names.
mod neo_hooke_of {
    pub use super::neo_hooke::{
        hex8 as hex8_neo_hooke, hex20 as hex20_neo_hooke, tet4 as tet4_neo_hooke, tet10 as tet10_neo_hooke,
    };
}

const TETRAHEDRON: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

#[test]
fn tetrahedra_have_the_derivatives_of_both_witnesses() {
    let up_to = |degree: u8| monomials(|exponents| exponents.iter().sum::<u8>() <= degree);
    check!(tet4_neo_hooke, solid(TETRAHEDRON.to_vec(), up_to(1), vec![([0.25; 3], 1.0 / 6.0)]));
    let edges = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
    // The rule's points: a quarter of the way from the centre … to each corner.
    let towards = |corner: &[f64; 3]| corner.map(|x| 0.25 + (x - 0.25) / 5_f64.sqrt());
    let points = TETRAHEDRON.iter().map(|corner| (towards(corner), 1.0 / 24.0)).collect();
    check!(tet10_neo_hooke, solid(with_edges(&TETRAHEDRON, &edges), up_to(2), points));
}

#[test]
fn hexahedra_have_the_derivatives_of_both_witnesses() {
    let two = 3_f64.sqrt().recip();
    let trilinear = monomials(|exponents| exponents.iter().all(|&k| k < 2));
    check!(hex8_neo_hooke, solid(cube(), trilinear, cubed(&[(-two, 1.0), (two, 1.0)])));
    let edges =
        [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];
    // Serendipity: no more than one square in a product.
    let serendipity = monomials(|exponents| exponents.iter().filter(|&&k| k == 2).count() <= 1);
    let three = 0.6_f64.sqrt();
    let points = cubed(&[(-three, 5.0 / 9.0), (0.0, 8.0 / 9.0), (three, 5.0 / 9.0)]);
    check!(hex20_neo_hooke, solid(with_edges(&cube(), &edges), serendipity, points));
}
