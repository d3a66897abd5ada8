//! Blocks of linear elasticity, alone and one on the other, iteratively and directly.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use diffuse_contact_solver::system::{
    Accuracy, BlockMatrix, BlockPattern, Equations, Geometry, IterativeReport, LinearReport, LinearSolver,
    LinearSolverChoice, LinearSystem, SavedRows, Symmetry, SystemError, solve_iteratively,
};

const LAMBDA: f64 = 576.9;
const MU: f64 = 384.6;

/// A system with all that belongs to it.
struct Example {
    matrix: BlockMatrix,
    links: BlockPattern,
    positions: Vec<[f64; 3]>,
    before: SavedRows,
    equations: Equations,
    symmetry: Symmetry,
}

/// A number in [−1, 1) without visible order.
fn irregular(index: usize) -> f64 {
    let mut bits = (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Stiffness between two corners of a cube with edges of length h, by corner; 2 × 2 × 2 points of Gauss.
fn stiffness(h: f64) -> Vec<Vec<Matrix3<f64>>> {
    let corner = |a: usize| [0, 1, 2].map(|i| if (a >> i) & 1 == 1 { 1.0 } else { -1.0 });
    let gradient = |a: usize, point: [f64; 3]| {
        let one = |i: usize| 1.0 + corner(a)[i] * point[i];
        Vector3::from_fn(|i, _| corner(a)[i] * one((i + 1) % 3) * one((i + 2) % 3) / (4.0 * h))
    };
    let points = (0..8).map(|q| corner(q).map(|x| x / 3.0_f64.sqrt()));
    let pair = |a: usize, b: usize| {
        let at = |point| {
            let (a, b) = (gradient(a, point), gradient(b, point));
            LAMBDA * a * b.transpose() + MU * (b * a.transpose() + a.dot(&b) * Matrix3::identity())
        };
        points.clone().map(at).sum::<Matrix3<f64>>() * (h.powi(3) / 8.0)
    };
    (0..8).map(|a| (0..8).map(|b| pair(a, b)).collect()).collect()
}

/// Nodes and elements of a unit cube of n × n × n cells, added to those there are.
fn cube(n: usize, origin: [f64; 3], positions: &mut Vec<[f64; 3]>, cells: &mut Vec<Vec<usize>>) {
    let first = positions.len();
    let size = n + 1;
    for k in 0..size.pow(3) {
        let place = [k % size, k / size % size, k / size / size];
        positions.push([0, 1, 2].map(|i| origin[i] + place[i] as f64 / n as f64));
    }
    for k in 0..n.pow(3) {
        let base = first + k % n + size * (k / n % n) + size * size * (k / n / n);
        let corner = |a: usize| base + (a & 1) + size * (a >> 1 & 1) + size * size * (a >> 2);
        cells.push((0..8).map(corner).collect());
    }
}

/// Two cubes, the upper one pressed on the lower one by contacts of this stiffness; with friction μ between them. The lower one's bottom
/// is held if `is_held`, and the sides of the upper one's top.
fn stacked(n: usize, penalty: f64, friction: f64, is_held: bool) -> Example {
    in_contact(n, penalty, friction, is_held, false)
}

/// The same; with `two_pass` nodes of the lower one are slaves of the upper one, too.
fn in_contact(n: usize, penalty: f64, friction: f64, is_held: bool, two_pass: bool) -> Example {
    let (mut positions, mut cells) = (Vec::new(), Vec::new());
    let size = n + 1;
    cube(n, [0.0; 3], &mut positions, &mut cells);
    let lower = positions.len();
    // No node lies on another one.
    let shift = 0.3 / n as f64;
    cube(n, [shift, shift, 1.0], &mut positions, &mut cells);
    let mut contacts = Vec::new();
    for k in 0..n * n {
        let (i, j) = (k % n, k / n);
        let master = size * size * n + i + size * j;
        let weights = [0.49, 0.21, 0.21, 0.09];
        let masters = [master, master + 1, master + size, master + size + 1];
        let mut nodes = vec![(lower + i + size * j, 1.0)];
        nodes.extend(masters.into_iter().zip(weights.map(|weight| -weight)));
        contacts.push(nodes);
        if two_pass {
            let (slave, first) = (master + 1 + size, lower + i + size * j);
            let masters = [first, first + 1, first + size, first + size + 1];
            let mut nodes = vec![(slave, 1.0)];
            nodes.extend(masters.into_iter().zip([0.09, 0.21, 0.21, 0.49].map(|weight| -weight)));
            contacts.push(nodes);
        }
    }
    let cliques: Vec<Vec<usize>> =
        contacts.iter().map(|nodes| nodes.iter().map(|&(node, _)| node).collect()).collect();
    let pattern = BlockPattern::new(positions.len(), cells.iter().chain(&cliques));
    let mut matrix = BlockMatrix::new(Arc::new(pattern));
    add_elements(&mut matrix, &cells, n);
    let mut coupled: Vec<u32> = cliques.iter().flatten().map(|&node| node as u32).collect();
    coupled.sort_unstable();
    coupled.dedup();
    let before = matrix.rows_of(&coupled);
    for (a, b) in
        contacts.iter().flat_map(|nodes| nodes.iter().flat_map(|a| nodes.iter().map(move |b| (a, b))))
    {
        let mut block = [[0.0; 3]; 3];
        block[2][2] = penalty * a.1 * b.1;
        block[0][2] = friction * block[2][2];
        matrix.add_block(a.0, b.0, &block);
    }
    let is_end = |z: f64| z == 0.0 || (z - 2.0).abs() < 1e-12;
    let prescribed: Vec<[bool; 3]> = positions
        .iter()
        .map(|&[_, _, z]| [is_held && is_end(z), is_held && is_end(z), is_held && z == 0.0])
        .collect();
    Example {
        matrix,
        links: BlockPattern::new(positions.len(), cells.iter()),
        positions,
        before,
        equations: Equations::new(&prescribed),
        symmetry: if friction == 0.0 { Symmetry::Symmetric } else { Symmetry::General },
    }
}

/// A cube whose bottom is held.
fn block(n: usize) -> Example {
    beside_a_free_one(n, 0)
}

/// A cube whose bottom is held, and beside it one of m cells of the same size, if that is more than none, that nothing holds.
fn beside_a_free_one(n: usize, m: usize) -> Example {
    let (mut positions, mut cells) = (Vec::new(), Vec::new());
    cube(n, [0.0; 3], &mut positions, &mut cells);
    let held = positions.len();
    if m > 0 {
        cube(m, [0.0; 3], &mut positions, &mut cells);
        let size = m as f64 / n as f64;
        positions[held..].iter_mut().for_each(|x| *x = [3.0 + size * x[0], size * x[1], size * x[2]]);
    }
    let mut matrix = BlockMatrix::new(Arc::new(BlockPattern::new(positions.len(), cells.iter())));
    add_elements(&mut matrix, &cells, n);
    let is_held = |(node, x): (usize, &[f64; 3])| [node < held && x[2] == 0.0; 3];
    let prescribed: Vec<[bool; 3]> = positions.iter().enumerate().map(is_held).collect();
    Example {
        matrix,
        links: BlockPattern::new(positions.len(), cells.iter()),
        before: SavedRows::default(),
        equations: Equations::new(&prescribed),
        positions,
        symmetry: Symmetry::Symmetric,
    }
}

fn add_elements(matrix: &mut BlockMatrix, cells: &[Vec<usize>], n: usize) {
    let stiffness = stiffness(1.0 / n as f64);
    for cell in cells {
        for (a, b) in (0..64).map(|k| (k / 8, k % 8)) {
            let block = &stiffness[a][b];
            matrix.add_block(cell[a], cell[b], &[0, 1, 2].map(|i| [0, 1, 2].map(|j| block[(i, j)])));
        }
    }
}

impl Example {
    fn rhs(&self) -> Vec<[f64; 3]> {
        (0..self.positions.len()).map(|node| [0, 1, 2].map(|i| irregular(3 * node + i))).collect()
    }

    fn geometry(&self) -> Geometry<'_> {
        Geometry { positions: &self.positions, links: &self.links, before: &self.before }
    }

    fn system(&self) -> LinearSystem<'_> {
        let Self { matrix, equations, symmetry, .. } = self;
        LinearSystem {
            matrix,
            operator: None,
            equations,
            symmetry: *symmetry,
            has_friction: *symmetry == Symmetry::General,
            geometry: self.geometry(),
        }
    }

    fn iterative(&self, tolerance: f64) -> Result<(IterativeReport, Vec<[f64; 3]>), SystemError> {
        let mut x = Vec::new();
        let report = solve_iteratively(&self.system(), &self.rhs(), Accuracy::fixed(tolerance), &mut x)?;
        Ok((report, x))
    }

    fn solve(
        &self,
        choice: LinearSolverChoice,
        tolerance: f64,
    ) -> Result<(LinearReport, Vec<[f64; 3]>), SystemError> {
        let mut x = Vec::new();
        let mut solver = LinearSolver::new(1);
        solver.choose(choice, &self.links, &self.equations);
        let report = solver.solve(&self.system(), &self.rhs(), Accuracy::fixed(tolerance), &mut x)?;
        Ok((report, x))
    }

    /// Iterations, after the solution was compared with that of factors.
    fn compared(&self) -> IterativeReport {
        let (report, x) = self.iterative(1e-11).unwrap();
        assert!(report.residual <= 2e-11, "{report:?}");
        let (how, exact) = self.solve(LinearSolverChoice::Direct, f64::NAN).unwrap();
        assert!(matches!(how, LinearReport::Direct { .. }));
        let largest = exact.as_flattened().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (x, exact) in x.as_flattened().iter().zip(exact.as_flattened()) {
            assert!((x - exact).abs() <= 1e-7 * largest, "{x} {exact} {report:?}");
        }
        report
    }
}

#[test]
fn stiff_contact_takes_hardly_more_iterations() {
    let alone = block(6).compared();
    assert!(!alone.general && alone.levels >= 2 && alone.bytes > 0, "{alone:?}");
    // As stiff as the elements beside it, and 10,000 times over; also where nodes are slaves and masters.
    for two_pass in [false, true] {
        let [soft, stiff] = [1e2, 1e6].map(|penalty| in_contact(6, penalty, 0.0, true, two_pass).compared());
        for report in [soft, stiff] {
            assert!(!report.general && report.bytes > alone.bytes, "{report:?}");
        }
        let [coarse, fine] = [6, 12].map(|n| {
            [1e4, 1e6].map(|penalty| in_contact(n, penalty, 0.0, true, two_pass).iterative(1e-8).unwrap().0)
        });
        let all = [soft.iterations, stiff.iterations];
        assert!(2 * stiff.iterations <= 3 * soft.iterations, "{two_pass}: {all:?}");
        let all = [coarse, fine].as_flattened().iter().map(|report| report.iterations).collect::<Vec<_>>();
        let (least, most) = all.iter().fold((500, 0), |(least, most), &k| (k.min(least), k.max(most)));
        assert!(2 * most <= 3 * least, "{two_pass}: {all:?}");
    }
}

#[test]
fn an_unsymmetric_system_is_solved_by_whichever_way_is_reported() {
    for penalty in [1e3, 1e5] {
        let example = stacked(5, penalty, 0.3, true);
        let (report, x) = example.solve(LinearSolverChoice::Iterative, 1e-8).unwrap();
        assert!(!matches!(report, LinearReport::Direct { .. }), "{report:?}");
        let mut product = vec![[0.0; 3]; x.len()];
        example.matrix.multiply(&x, &mut product);
        let (mut left, mut whole) = (0.0_f64, 0.0_f64);
        for (node, (b, product)) in example.rhs().iter().zip(&product).enumerate() {
            for axis in (0..3).filter(|&axis| example.equations.number(node, axis).is_some()) {
                left += (b[axis] - product[axis]).powi(2);
                whole += b[axis].powi(2);
            }
        }
        assert!(left.sqrt() <= 2.1e-8 * whole.sqrt(), "{report:?}");
        let (by_size, _) = example.solve(LinearSolverChoice::Auto, 1e-8).unwrap();
        assert!(matches!(by_size, LinearReport::Direct { .. }), "{by_size:?}");
    }
}

#[test]
fn iterations_hardly_grow_with_the_number_of_equations() {
    let [coarse, middle, fine] = [5, 10, 20].map(|n| block(n).iterative(1e-8).unwrap().0);
    assert!(2 * middle.iterations <= 3 * coarse.iterations.max(8), "{coarse:?} {middle:?}");
    assert!(2 * fine.iterations <= 3 * middle.iterations, "{middle:?} {fine:?}");
    assert!(fine.levels > coarse.levels, "{fine:?}");
}

#[test]
fn bodies_that_nothing_holds_have_a_singular_matrix() {
    let loose = stacked(5, 1e3, 0.0, false);
    let error = loose.solve(LinearSolverChoice::Iterative, 1e-8).unwrap_err();
    assert!(matches!(error, SystemError::Singular { .. }), "{error}");
}

/// A free body that comes down to one coarse node has nothing but rounding there.
#[test]
fn a_small_body_that_nothing_holds_is_found_beside_a_large_one() {
    for (n, m) in [(12, 1), (12, 2), (16, 3)] {
        let error = beside_a_free_one(n, m).iterative(1e-8).unwrap_err();
        assert!(matches!(error, SystemError::Singular { .. }), "{n} {m}: {error}");
    }
}

/// Factors that are not symmetric tell it by themselves only where a column is empty.
#[test]
fn bodies_in_friction_that_nothing_holds_have_a_singular_matrix() {
    let error = stacked(5, 1e3, 0.3, false).iterative(1e-8).unwrap_err();
    assert!(matches!(error, SystemError::Singular { .. }), "{error}");
    // Stiff contact alone is no reason.
    for penalty in [1e3, 1e6, 1e9] {
        let held = stacked(5, penalty, 0.3, true).iterative(1e-6);
        assert!(!matches!(held, Err(SystemError::Singular { .. })), "{held:?}");
    }
}

#[test]
fn the_bits_are_the_same_with_any_number_of_threads() {
    let example = stacked(7, 1e4, 0.0, true);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| example.iterative(1e-6)).unwrap()
    };
    let (one, two) = (with(1), with(2));
    assert_eq!(one.0, two.0);
    assert_eq!(one.1, two.1);
}

#[test]
fn what_is_not_reached_is_an_error_and_then_solved_directly() {
    let example = stacked(3, 1e4, 0.3, true);
    let error = example.iterative(1e-30).unwrap_err();
    let SystemError::NotConverged { iterations, residual, tolerance, .. } = error else { panic!("{error}") };
    assert!(iterations > 0 && residual > tolerance && tolerance == 1e-30);
    let (report, x) = example.solve(LinearSolverChoice::Iterative, 1e-30).unwrap();
    assert_eq!(report, LinearReport::Instead { iterations, rounded: None });
    assert_eq!(x, example.solve(LinearSolverChoice::Direct, 1e-30).unwrap().1);
}

#[test]
fn a_number_that_is_not_finite_is_refused() {
    let mut example = block(3);
    example.matrix.add_block(40, 41, &[[0.0, f64::NAN, 0.0], [0.0; 3], [0.0; 3]]);
    let error = example.iterative(1e-6).unwrap_err();
    assert!(matches!(error, SystemError::NotFinite { node: 40, axis: 0, .. }), "{error}");
}
