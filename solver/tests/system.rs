//! Linear systems against dense algebra, and matrices that have no solution.

use std::sync::Arc;

use crate::common::numbers;
use diffuse_contact_solver::system::{
    BlockMatrix, BlockPattern, DirectSolver, Equations, Method, SolveReport, Symmetry, SystemError,
};
use nalgebra::{DMatrix, DVector};

/// Cliques of a chain of cells with a few wide ones across it.
fn cliques(nodes: usize) -> Vec<Vec<usize>> {
    let mut cliques: Vec<Vec<usize>> =
        (0..nodes - 3).map(|first| vec![first, first + 2, first + 1, first + 3]).collect();
    cliques.push((0..nodes).step_by(nodes / 8).collect());
    cliques.push(vec![nodes - 1, 0, 7, 7]);
    cliques
}

fn pattern(nodes: usize) -> Arc<BlockPattern> {
    Arc::new(BlockPattern::new(nodes, cliques(nodes).iter()))
}

/// A matrix of cliques: symmetric with `shift` on the diagonal, or not symmetric.
fn matrix(nodes: usize, symmetry: Symmetry, shift: f64) -> BlockMatrix {
    let mut next = numbers(17);
    let mut matrix = BlockMatrix::new(pattern(nodes));
    for clique in cliques(nodes) {
        let size = 3 * clique.len();
        match symmetry {
            Symmetry::Symmetric => {
                let packed: Vec<f64> = (0..size * (size + 1) / 2).map(|_| 0.5 * next()).collect();
                matrix.add_symmetric(&clique, &packed);
            }
            Symmetry::General => {
                let entries: Vec<f64> = (0..size * size).map(|_| 0.5 * next()).collect();
                matrix.add(&clique, &entries);
            }
        }
    }
    for node in 0..nodes {
        let mut diagonal = [[0.0; 3]; 3];
        for axis in 0..3 {
            diagonal[axis][axis] = shift;
        }
        matrix.add_block(node, node, &diagonal);
    }
    matrix
}

fn dense(matrix: &BlockMatrix) -> DMatrix<f64> {
    let nodes = matrix.pattern().nodes();
    DMatrix::from_fn(3 * nodes, 3 * nodes, |i, j| {
        matrix.block(i / 3, j / 3).map_or(0.0, |block| block[i % 3][j % 3])
    })
}

fn rhs(nodes: usize) -> Vec<[f64; 3]> {
    let mut next = numbers(23);
    (0..nodes).map(|_| [next(), next(), next()]).collect()
}

/// Every fourth node held in x, and one held altogether.
fn some_prescribed(nodes: usize) -> Vec<[bool; 3]> {
    (0..nodes).map(|node| [node % 4 == 0 || node == 5, node == 5, node == 5]).collect()
}

fn solve(
    matrix: &BlockMatrix,
    prescribed: &[[bool; 3]],
    symmetry: Symmetry,
) -> Result<(SolveReport, Vec<[f64; 3]>), SystemError> {
    let mut solver = DirectSolver::new(1);
    let mut x = Vec::new();
    solver.factorise(matrix, &Equations::new(prescribed), symmetry)?;
    let report = solver.solve(&rhs(prescribed.len()), &mut x)?;
    Ok((report, x))
}

/// The largest difference from the dense solution.
fn error(matrix: &BlockMatrix, prescribed: &[[bool; 3]], x: &[[f64; 3]]) -> f64 {
    let free: Vec<usize> = (0..3 * x.len()).filter(|&i| !prescribed[i / 3][i % 3]).collect();
    let full = dense(matrix);
    let b = rhs(x.len());
    let reduced = DMatrix::from_fn(free.len(), free.len(), |i, j| full[(free[i], free[j])]);
    let expected = reduced
        .lu()
        .solve(&DVector::from_iterator(free.len(), free.iter().map(|&i| b[i / 3][i % 3])))
        .unwrap();
    let held = (0..3 * x.len()).filter(|i| !free.contains(i)).map(|i| x[i / 3][i % 3].abs());
    free.iter()
        .zip(&expected)
        .map(|(&i, e)| (x[i / 3][i % 3] - e).abs())
        .chain(held)
        .fold(0.0, crate::common::worse)
}

#[test]
fn a_pattern_is_the_union_of_its_cliques() {
    let pattern = BlockPattern::new(6, [vec![0, 2, 3], vec![3, 1, 3]].iter());
    assert_eq!(pattern.row(0), [0, 2, 3]);
    assert_eq!(pattern.row(1), [1, 3]);
    assert_eq!(pattern.row(3), [0, 1, 2, 3]);
    assert_eq!(pattern.row(4), [4]);
    assert_eq!((pattern.nodes(), pattern.blocks()), (6, 3 + 2 + 3 + 4 + 1 + 1));
}

#[test]
fn triangles_and_full_matrices_add_up_to_the_same() {
    let nodes = 8;
    let pattern = Arc::new(BlockPattern::new(nodes, [[6, 1, 4, 1]].iter()));
    let mut next = numbers(1);
    let packed: Vec<f64> = (0..78).map(|_| 2.0 * next()).collect();
    let full: Vec<f64> = (0..144)
        .map(|k| {
            let (i, j) = ((k / 12).max(k % 12), (k / 12).min(k % 12));
            packed[i * (i + 1) / 2 + j]
        })
        .collect();
    let (mut a, mut b) = (BlockMatrix::new(Arc::clone(&pattern)), BlockMatrix::new(pattern));
    a.add_symmetric(&[6, 1, 4, 1], &packed);
    b.add(&[6, 1, 4, 1], &full);
    let (a, b) = (dense(&a), dense(&b));
    assert!((&a - &b).amax() < 1e-15 && a.amax() > 1.0);
    assert_eq!(a, a.transpose());
    // Node 1 occurs twice: its block gathers four.
    let expected = full[3 * 12 + 4] + full[3 * 12 + 10] + full[9 * 12 + 4] + full[9 * 12 + 10];
    assert!((a[(3, 4)] - expected).abs() < 1e-14);
}

#[test]
fn products_are_those_of_the_dense_matrix() {
    let matrix = matrix(30, Symmetry::General, 0.0);
    let x = rhs(30);
    let mut y = vec![[0.0; 3]; 30];
    matrix.multiply(&x, &mut y);
    let expected = dense(&matrix) * DVector::from_column_slice(x.as_flattened());
    for (value, expected) in y.as_flattened().iter().zip(&expected) {
        assert!((value - expected).abs() < 1e-13);
    }
    // Rows of some nodes are those of all, bit for bit.
    let nodes = [7, 3, 29];
    assert_eq!(matrix.multiply_rows(&nodes, &x), nodes.map(|node| y[node]));
    matrix.multiply_moduli(&x, &mut y);
    assert_eq!(matrix.multiply_moduli_rows(&nodes, &x), nodes.map(|node| y[node]));
}

#[test]
fn definite_indefinite_and_general_systems() {
    for (symmetry, shift) in [
        (Symmetry::Symmetric, 20.0),
        (Symmetry::Symmetric, 0.3),
        (Symmetry::Symmetric, -0.1),
        (Symmetry::General, 0.5),
    ] {
        for nodes in [9, 40, 150] {
            let matrix = matrix(nodes, symmetry, shift);
            let prescribed = some_prescribed(nodes);
            let (report, x) = solve(&matrix, &prescribed, symmetry).unwrap();
            assert!(report.residual < 1e-12, "{report:?}");
            let error = error(&matrix, &prescribed, &x);
            assert!(error < 1e-8, "{symmetry:?} {shift} {nodes}: {error:e}");
            assert!(symmetry == Symmetry::Symmetric || report.method == Method::General);
        }
    }
}

/// The upper triangle is not that of the lower: the residual shows, and the general factors take over.
#[test]
fn a_matrix_wrongly_called_symmetric_is_solved_all_the_same() {
    let matrix = matrix(40, Symmetry::General, 3.0);
    let prescribed = some_prescribed(40);
    let (report, x) = solve(&matrix, &prescribed, Symmetry::Symmetric).unwrap();
    assert_eq!(report.method, Method::General);
    assert!(error(&matrix, &prescribed, &x) < 1e-8);
}

/// Nothing on the diagonal: pairs of nodes tied to each other only, as multipliers are to displacements.
#[test]
fn zero_diagonals() {
    let nodes = 40;
    let pairs: Vec<[usize; 2]> = (0..nodes / 2).map(|k| [k, nodes / 2 + (7 * k + 3) % (nodes / 2)]).collect();
    let mut matrix = BlockMatrix::new(Arc::new(BlockPattern::new(nodes, pairs.iter())));
    let mut next = numbers(9);
    for &[a, b] in &pairs {
        let block: [[f64; 3]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| next()));
        matrix.add_block(a, b, &block);
        matrix.add_block(b, a, &std::array::from_fn(|i| std::array::from_fn(|j| block[j][i])));
    }
    let prescribed = vec![[false; 3]; nodes];
    let (report, x) = solve(&matrix, &prescribed, Symmetry::Symmetric).unwrap();
    assert!(report.residual < 1e-12, "{report:?}");
    assert!(error(&matrix, &prescribed, &x) < 1e-9);
}

/// A chain of springs: with its ends free it has three rigid motions.
fn springs(nodes: usize) -> BlockMatrix {
    let pairs: Vec<[usize; 2]> = (1..nodes).map(|k| [k - 1, k]).collect();
    let mut matrix = BlockMatrix::new(Arc::new(BlockPattern::new(nodes, pairs.iter())));
    let mut next = numbers(4);
    for pair in &pairs {
        let stiffness = 1.5 + next();
        let mut packed = vec![0.0; 21];
        for i in 0..6 {
            packed[i * (i + 1) / 2 + i] = stiffness;
            if i >= 3 {
                packed[i * (i + 1) / 2 + i - 3] = -stiffness;
            }
        }
        matrix.add_symmetric(pair, &packed);
    }
    matrix
}

#[test]
fn singular_matrices_are_errors_with_numbers() {
    let nodes = 30;
    let mut held = vec![[false; 3]; nodes];
    held[0] = [true; 3];
    let matrix = springs(nodes);
    let mut loads = rhs(nodes);
    for symmetry in [Symmetry::Symmetric, Symmetry::General] {
        assert!(solve(&matrix, &held, symmetry).is_ok());
        let free = solve(&matrix, &vec![[false; 3]; nodes], symmetry);
        assert!(
            matches!(free, Err(SystemError::Singular { equations: 90, condition, .. }) if condition > 1e14),
            "{free:?}"
        );
        // Loads in equilibrium make no difference: the position is not determined.
        for axis in 0..3 {
            let sum: f64 = loads.iter().map(|load| load[axis]).sum();
            loads[7][axis] -= sum;
        }
        let mut solver = DirectSolver::new(1);
        let free = solver
            .factorise(&matrix, &Equations::new(&vec![[false; 3]; nodes]), symmetry)
            .and_then(|()| solver.solve(&loads, &mut Vec::new()));
        assert!(matches!(free, Err(SystemError::Singular { .. })), "{free:?}");
        // A node without any stiffness.
        let empty = BlockMatrix::new(Arc::new(BlockPattern::new(3, [[0, 1]].iter())));
        assert!(matches!(
            solve(&empty, &[[false; 3]; 3], symmetry),
            Err(SystemError::Singular { equations: 9, .. })
        ));
    }
}

/// Soft and stiff springs by turns: rounding leaves a pivot of 1e-11 of its diagonal entry where there should be none, and loads in
/// equilibrium leave no residual.
#[test]
fn a_rigid_motion_that_rounding_hides_from_the_pivots_is_found() {
    let nodes = 41;
    let pairs: Vec<[usize; 2]> = (1..nodes).map(|k| [k - 1, k]).collect();
    let mut matrix = BlockMatrix::new(Arc::new(BlockPattern::new(nodes, pairs.iter())));
    for (k, pair) in pairs.iter().enumerate() {
        let stiffness = if k % 2 == 0 { 1.1e-5 } else { 1.3 };
        let mut packed = vec![0.0; 21];
        for i in 0..6 {
            packed[i * (i + 1) / 2 + i] = stiffness;
            if i >= 3 {
                packed[i * (i + 1) / 2 + i - 3] = -stiffness;
            }
        }
        matrix.add_symmetric(pair, &packed);
    }
    let mut next = numbers(9);
    let moves: Vec<[f64; 3]> = (0..nodes).map(|_| [next(), next(), next()]).collect();
    let mut loads = vec![[0.0; 3]; nodes];
    matrix.multiply(&moves, &mut loads);
    let mut held = vec![[false; 3]; nodes];
    for is_held in [true, false] {
        held[0] = [is_held; 3];
        let mut solver = DirectSolver::new(1);
        let solved = solver
            .factorise(&matrix, &Equations::new(&held), Symmetry::Symmetric)
            .and_then(|()| solver.solve(&loads, &mut Vec::new()));
        assert_eq!(solved.is_ok(), is_held, "{solved:?}");
        assert!(is_held || matches!(solved, Err(SystemError::Singular { .. })), "{solved:?}");
    }
}

/// A beam of bending stiffness 1 along each axis.
fn beam(nodes: usize) -> BlockMatrix {
    let triples: Vec<[usize; 3]> = (2..nodes).map(|k| [k - 2, k - 1, k]).collect();
    let mut matrix = BlockMatrix::new(Arc::new(BlockPattern::new(nodes, triples.iter())));
    let bending = [1.0, -2.0, 1.0];
    let mut packed = vec![0.0; 45];
    for i in 0..9 {
        for j in (i % 3..=i).step_by(3) {
            packed[i * (i + 1) / 2 + j] = bending[i / 3] * bending[j / 3];
        }
    }
    for triple in &triples {
        matrix.add_symmetric(triple, &packed);
    }
    matrix
}

/// A long slender beam on a stiff support is as badly conditioned as its bending, not by the support's stiffness times that.
#[test]
fn a_stiff_support_of_a_slender_beam_is_not_singular() {
    let nodes = 3000;
    let mut matrix = beam(nodes);
    matrix.add_symmetric(&[nodes - 1], &[1e7, 0.0, 1e7, 0.0, 0.0, 1e7]);
    let mut held = vec![[false; 3]; nodes];
    held[..2].fill([true; 3]);
    let mut expected = vec![[0.0; 3]; nodes];
    let span = (nodes - 1) as f64;
    // Nothing moves at the ends.
    for (k, at) in expected.iter_mut().enumerate().skip(2) {
        let s = (k - 1) as f64 / span;
        *at = [s * s * (1.0 - s), s * s * (1.0 - s).powi(2), (s * s - s).powi(3)];
    }
    let mut loads = vec![[0.0; 3]; nodes];
    matrix.multiply(&expected, &mut loads);
    for symmetry in [Symmetry::Symmetric, Symmetry::General] {
        let mut solver = DirectSolver::new(1);
        let mut x = Vec::new();
        solver.factorise(&matrix, &Equations::new(&held), symmetry).unwrap();
        let report = solver.solve(&loads, &mut x).unwrap();
        assert!(report.residual <= 1e-6, "{report:?}");
        // Relative to the load, the bending answers with 1e11 of it.
        let worst = x.iter().zip(&expected).flat_map(|(x, e)| (0..3).map(|a| (x[a] - e[a]).abs()));
        let worst = worst.fold(0.0, crate::common::worse);
        assert!(worst < 1e-3, "{worst:e}");
    }
}

/// The tip of a slender beam moves so far that rounding of K x is more than the load.
#[test]
fn a_slender_beam_carries_a_load_at_its_tip() {
    let nodes = 2500;
    let matrix = beam(nodes);
    let mut held = vec![[false; 3]; nodes];
    held[..2].fill([true; 3]);
    let mut loads = vec![[0.0; 3]; nodes];
    loads[nodes - 1] = [1.0, -2.0, 0.5];
    // Σ m² of the moments m at the joints
    let flexibility = (1..nodes - 1).map(|m| (m * m) as f64).sum::<f64>();
    for symmetry in [Symmetry::Symmetric, Symmetry::General] {
        let mut solver = DirectSolver::new(1);
        let mut x = Vec::new();
        solver.factorise(&matrix, &Equations::new(&held), symmetry).unwrap();
        solver.solve(&loads, &mut x).unwrap();
        for axis in 0..3 {
            assert!((x[nodes - 1][axis] / flexibility / loads[nodes - 1][axis] - 1.0).abs() < 1e-3);
        }
    }
}

/// Matrices that are singular in many ways end in an answer or an error, and never in a NaN or a panic.
#[test]
fn rank_deficient_matrices_never_panic() {
    let mut next = numbers(31);
    let (mut solved, mut refused) = (0, 0);
    for trial in 0..300 {
        let nodes = 4 + trial % 20;
        let all: Vec<usize> = (0..nodes).collect();
        let wide: Vec<&[usize]> = all.windows(3).collect();
        let mut matrix = BlockMatrix::new(Arc::new(BlockPattern::new(nodes, wide.iter())));
        // Entries of 0 and ±1 make exact cancellations.
        for clique in &wide {
            let scale = if trial % 7 == 0 { 1e200 } else { 1.0 };
            let mut packed = || if next() < 0.3 { 0.0 } else { scale * next().signum() };
            let packed: Vec<f64> = (0..45).map(|_| packed()).collect();
            if trial % 3 != 0 || clique[0] % 2 == 0 {
                matrix.add_symmetric(clique, &packed);
            }
        }
        for symmetry in [Symmetry::Symmetric, Symmetry::General] {
            match solve(&matrix, &vec![[false; 3]; nodes], symmetry) {
                Ok((report, x)) => {
                    assert!(report.residual <= 1e-6);
                    assert!(x.as_flattened().iter().all(|x| x.is_finite()));
                    solved += 1;
                }
                Err(SystemError::Singular { residual, condition, .. }) => {
                    assert!(!residual.is_nan() && !condition.is_nan());
                    refused += 1;
                }
                Err(other) => panic!("{other}"),
            }
        }
    }
    assert!(solved > 50 && refused > 50, "{solved} {refused}");
}

#[test]
fn a_solver_is_used_again() {
    let nodes = 40;
    let mut solver = DirectSolver::new(1);
    let mut x = Vec::new();
    let free = Equations::new(&vec![[false; 3]; nodes]);
    let some = Equations::new(&some_prescribed(nodes));
    let none = Equations::new(&vec![[true; 3]; nodes]);
    let mut all_but_one = vec![[true; 3]; nodes];
    all_but_one[3][1] = false;
    let one = Equations::new(&all_but_one);
    for (equations, symmetry, shift) in [
        (&free, Symmetry::Symmetric, 2.0),
        (&free, Symmetry::Symmetric, 5.0),
        (&some, Symmetry::General, 2.0),
        (&none, Symmetry::Symmetric, 2.0),
        (&one, Symmetry::General, 2.0),
        (&one, Symmetry::Symmetric, 2.0),
        (&some, Symmetry::Symmetric, 7.0),
        (&free, Symmetry::Symmetric, 2.0),
    ] {
        let matrix = matrix(nodes, symmetry, shift);
        solver.factorise(&matrix, equations, symmetry).unwrap();
        let report = solver.solve(&rhs(nodes), &mut x).unwrap();
        assert!(report.residual < 1e-12);
        let mut fresh = DirectSolver::new(1);
        let mut y = Vec::new();
        fresh.factorise(&matrix, equations, symmetry).unwrap();
        fresh.solve(&rhs(nodes), &mut y).unwrap();
        assert_eq!(x, y);
        // Another right-hand side with the same factors; nothing for nothing.
        solver.solve(&vec![[0.0; 3]; nodes], &mut x).unwrap();
        assert_eq!(x, vec![[0.0; 3]; nodes]);
    }
}

/// Enough equations for threads; twice the same.
#[test]
fn threads_give_the_same_solution() {
    let nodes = 2500;
    let matrix = matrix(nodes, Symmetry::Symmetric, 12.0);
    let equations = Equations::new(&some_prescribed(nodes));
    let run = |threads| {
        let mut solver = DirectSolver::new(threads);
        let mut x = Vec::new();
        solver.factorise(&matrix, &equations, Symmetry::Symmetric).unwrap();
        let report = solver.solve(&rhs(nodes), &mut x).unwrap();
        assert!(report.residual < 1e-12 && report.method == Method::Symmetric);
        x
    };
    assert!(equations.len() > 6000);
    let (one, two, again) = (run(1), run(2), run(2));
    assert_eq!(two, again);
    for (a, b) in one.as_flattened().iter().zip(two.as_flattened()) {
        assert!((a - b).abs() < 1e-10);
    }
}

#[test]
fn bad_input_is_named() {
    let nodes = 12;
    let mut broken = matrix(nodes, Symmetry::Symmetric, 9.0);
    let sound = broken.clone();
    broken.add_block(6, 7, &[[0.0, 0.0, f64::NAN], [0.0; 3], [0.0; 3]]);
    let equations = Equations::new(&some_prescribed(nodes));
    let mut solver = DirectSolver::new(1);
    let error = solver.factorise(&broken, &equations, Symmetry::Symmetric).unwrap_err();
    assert!(matches!(error, SystemError::NotFinite { .. }));
    let error = solver.factorise(&sound, &Equations::new(&[[false; 3]; 3]), Symmetry::General).unwrap_err();
    assert!(matches!(error, SystemError::WrongCount { given: 3, expected: 12, .. }));

    // What failed leaves nothing to solve with.
    assert_eq!(solver.solve(&rhs(nodes), &mut Vec::new()), Err(SystemError::NotFactorised));
    let unused = DirectSolver::new(1).solve(&rhs(nodes), &mut Vec::new());
    assert_eq!(unused, Err(SystemError::NotFactorised));

    solver.factorise(&sound, &equations, Symmetry::Symmetric).unwrap();
    let mut loads = rhs(nodes);
    let error = solver.solve(&loads[1..], &mut Vec::new()).unwrap_err();
    assert!(matches!(error, SystemError::WrongCount { what: "right-hand sides", given: 11, expected: 12 }));
    loads[6][2] = f64::INFINITY;
    let error = solver.solve(&loads, &mut Vec::new()).unwrap_err();
    assert!(matches!(error, SystemError::NotFinite { node: 6, axis: 2, value: f64::INFINITY, .. }));
    // Prescribed entries are not read.
    let mut loads = rhs(nodes);
    loads[5][0] = f64::NAN;
    assert!(solver.solve(&loads, &mut Vec::new()).is_ok());
}
