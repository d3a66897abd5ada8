//! Bodies against closed forms.

use std::collections::BTreeSet;

use crate::common::{ELEMENTS, INCOMPATIBLE, Problem, grid, meshed, numbers, set_middles};
use diffuse_contact_mesh::ElementKind;
use diffuse_contact_solver::material::{Material, Plasticity};

const STEEL: Material = Material::elastic(2e5, 0.3);
const PLASTIC: Material = STEEL.with_plasticity(Plasticity { yield_stress: 400.0, hardening: 3450.0 });

/// Linear displacements on the boundary of distorted elements: the same inside, and one stress everywhere.
#[test]
fn patch_test() {
    for kind in ELEMENTS {
        for material in [STEEL, Material { poisson: 0.4999, ..STEEL }, Material::neo_hooke(2e5, 0.499)] {
            patch(kind, material);
        }
    }
}

fn patch(kind: (ElementKind, bool), material: Material) {
    let mut next = numbers(2);
    let (mut nodes, elements) = meshed(kind, [3, 3, 3], |x| x);
    let inside = |x: &[f64; 3]| x.iter().all(|&x| x > 0.01 && x < 0.99);
    // The rule of a wedge with 15 nodes is exact for straight ones of any height, not for twisted ones.
    let size = match kind.0 {
        ElementKind::Hexahedron8 => [0.12; 3],
        ElementKind::Wedge15 => [0.1, 0.0, 0.0],
        // Half of a hexahedron turns inside out sooner.
        _ => [0.1; 3],
    };
    let interior: Vec<bool> = nodes.iter().map(inside).collect();
    for node in nodes.iter_mut().filter(|node| inside(node)) {
        *node = [0, 1, 2].map(|i| node[i] + size[i] * next());
    }
    set_middles(&mut nodes, &elements);
    let mut problem = Problem::new(&nodes, elements, material);
    problem.prescribed.iter_mut().zip(&interior).for_each(|(held, inside)| *held = [!inside; 3]);
    // Strains of about a tenth; with modes the pressure stays below the shear modulus.
    let share = if kind == INCOMPATIBLE && material.poisson > 0.49 { 1e-3 } else { 1.0 };
    let slope =
        [[0.1, 0.04, -0.02], [0.03, -0.06, 0.05], [0.02, 0.01, 0.08]].map(|row| row.map(|x| share * x));
    let affine =
        |x: &[f64; 3]| [0, 1, 2].map(|i| x[i] + slope[i][0] * x[0] + slope[i][1] * x[1] + slope[i][2] * x[2]);
    let target: Vec<_> = nodes.iter().map(affine).collect();
    problem.step(&target, 1e-7);
    for (position, expected) in problem.positions.iter().zip(&target) {
        for i in 0..3 {
            let error = (position[i] - expected[i]).abs();
            assert!(error < 1e-12, "{kind:?} {}: {position:?} {expected:?}", material.poisson);
        }
    }
    let recovery = problem.solid.recover(&problem.positions, &problem.states).unwrap();
    let first = recovery.points[0].stress;
    let scale = recovery.points[0].von_mises;
    assert!(scale > 1e3 * share);
    let nodal = &recovery.bodies[0].fields;
    for fields in recovery.points.iter().chain(nodal) {
        for k in 0..6 {
            // Where the volume has to be right to 1e-14 for the pressure to be right to 1e-10.
            let size = scale.max(first[0].abs());
            let error = (fields.stress[k] - first[k]).abs();
            assert!(error < 1e-10 * size, "{kind:?}: {:?} {first:?}", fields.stress);
        }
    }
}

/// A bar drawn out to 1.3 times its length; sides free.
#[test]
fn uniaxial_plastic_tension() {
    let (nodes, elements) = grid([2, 1, 1], |x| [10.0 * x[0], 2.0 * x[1], 2.0 * x[2]]);
    let mut problem = Problem::new(&nodes, elements, PLASTIC);
    problem.hold([true, false, false], |x| x[0] == 0.0 || x[0] == 10.0);
    problem.hold([false, true, false], |x| x[1] == 0.0);
    problem.hold([false, false, true], |x| x[2] == 0.0);
    let steps = 30;
    for step in 1..=steps {
        let length = 10.0 * (1.0 + 0.3 * f64::from(step) / f64::from(steps));
        let target: Vec<_> = nodes.iter().map(|x| [x[0] * length / 10.0, x[1], x[2]]).collect();
        problem.step(&target, 1e-8);
        // Kirchhoff's stress τ = σ_y + H p, ln λ = τ/E + p.
        let strain = (length / 10.0).ln();
        let tau = (400.0 + 3450.0 * strain) / (1.0 + 3450.0 / 2e5);
        let theta = (tau / (3.0 * PLASTIC.bulk_modulus())).exp();
        let recovery = problem.solid.recover(&problem.positions, &problem.states).unwrap();
        for point in &recovery.points {
            assert!(
                (point.stress[0] - tau / theta).abs() < 1e-8 * tau,
                "{} {}",
                point.stress[0],
                tau / theta
            );
            assert!(point.stress[1..].iter().all(|s| s.abs() < 1e-7));
            assert!((point.equivalent_plastic_strain - (strain - tau / 2e5)).abs() < 1e-11);
        }
    }
}

/// How far the tip of Cook's membrane moves in plane strain with E = 250, for a load of 100 by proportion to a small one.
fn cook(kind: (ElementKind, bool), divisions: usize, poisson: f64) -> f64 {
    let (nodes, elements) = meshed(kind, [divisions, divisions, 1], |[x, y, z]| {
        [48.0 * x, 44.0 * x + y * (44.0 - 28.0 * x), 48.0 / divisions as f64 * z]
    });
    let thickness = 48.0 / divisions as f64;
    let material = Material::elastic(250.0, poisson);
    let mut problem = Problem::new(&nodes, elements, material);
    problem.hold([true; 3], |x| x[0] == 0.0);
    problem.hold([false, false, true], |_| true);
    // Shares of the edge's nodes by their distance; those in the middle of second order carry two thirds.
    let heights: BTreeSet<i64> =
        nodes.iter().filter(|x| x[0] == 48.0).map(|x| (1e6 * x[1]).round() as i64).collect();
    let heights: Vec<f64> = heights.iter().map(|&y| y as f64 / 1e6).collect();
    let count = heights.len() - 1;
    for (k, y) in heights.iter().enumerate() {
        let share = match (kind.0.has_middles(), k == 0 || k == count) {
            (false, true) => 0.5,
            (true, true) => 1.0 / 3.0,
            (true, false) if k % 2 == 0 => 2.0 / 3.0,
            (true, false) => 4.0 / 3.0,
            (false, false) => 1.0,
        };
        let on = |x: &&[f64; 3]| x[0] == 48.0 && (x[1] - y).abs() < 1e-5;
        let alike = nodes.iter().filter(on).count() as f64;
        for (node, _) in nodes.iter().enumerate().filter(|(_, x)| on(x)) {
            problem.loads[node][1] = 0.1 * thickness * share / (count as f64 * alike);
        }
    }
    problem.step(&nodes, 1e-11 * material.bulk_modulus());
    let tip = nodes.iter().position(|x| x[0] == 48.0 && (x[1] - 60.0).abs() < 1e-9).unwrap();
    (problem.positions[tip][1] - nodes[tip][1]) * 1e3
}

/// 7.77 is the value under refinement for an incompressible material at small strains.
#[test]
fn no_locking_as_the_material_becomes_incompressible() {
    let tips = [4, 8, 16].map(|divisions| cook((ElementKind::Hexahedron8, false), divisions, 0.4999));
    println!("{tips:?}");
    assert!(tips[1] > 0.935 * 7.77 && tips[2] > 0.97 * 7.77 && tips[2] < 7.77, "{tips:?}");
    // Aitken's extrapolation.
    let (d1, d2) = (tips[1] - tips[0], tips[2] - tips[1]);
    let extrapolated = tips[2] + d2 * d2 / (d1 - d2);
    assert!((extrapolated / 7.77 - 1.0).abs() < 0.01, "{extrapolated}");
    // As the limit is approached nothing changes any more.
    let limit = cook((ElementKind::Hexahedron8, false), 8, 0.499_99);
    assert!((limit / tips[1] - 1.0).abs() < 1e-3, "{limit} {tips:?}");
    // Modes, and second order on meshes half as fine.
    for (kind, least) in [
        (INCOMPATIBLE, 0.95),
        ((ElementKind::Hexahedron20, false), 0.97),
        ((ElementKind::Tetrahedron10, false), 0.92),
        ((ElementKind::Wedge15, false), 0.92),
    ] {
        let tip = cook(kind, 8, 0.4999) / 7.77;
        println!("{kind:?} {tip}");
        assert!(tip > least && tip < 1.01, "{kind:?} {tip}");
    }
}

/// Deflection of a cantilever's tip over Timoshenko's, ν = 0.
fn cantilever(through: usize) -> f64 {
    let (length, height) = (10.0, 1.0);
    let (nodes, elements) = grid([10 * through, 1, through], |x| [length * x[0], x[1], height * x[2]]);
    let material = Material { poisson: 0.0, ..STEEL };
    let mut problem = Problem::new(&nodes, elements, material);
    problem.hold([true; 3], |x| x[0] == 0.0);
    let force = 1.0;
    for (node, x) in nodes.iter().enumerate().filter(|(_, x)| x[0] == length) {
        let ends = x[2] == 0.0 || x[2] == height;
        problem.loads[node][2] = force / (2 * through) as f64 * if ends { 0.5 } else { 1.0 };
    }
    problem.step(&nodes, 1e-7);
    let tip = nodes.iter().position(|x| x[0] == length).unwrap();
    let inertia = height.powi(3) / 12.0;
    let bending = force * length.powi(3) / (3.0 * material.young * inertia);
    let shear = force * length / (5.0 / 6.0 * material.shear_modulus() * height);
    (problem.positions[tip][2] - nodes[tip][2]) / (bending + shear)
}

/// The full integration of shear makes coarse elements stiff in bending; the error falls with the square of their size.
#[test]
fn bending_converges_to_beam_theory() {
    let [e2, e4, e8] = [2, 4, 8].map(|through| 1.0 - cantilever(through));
    println!("{e2} {e4} {e8}");
    assert!(e8 > 0.0 && e8 < 0.005, "{e8}");
    assert!(e2 / e4 > 3.3 && e4 / e8 > 3.3, "{e2} {e4} {e8}");
    // What is left after extrapolation is the difference between beam and solid at the clamped end.
    let extrapolated = e8 - (e4 - e8) / 3.0;
    assert!(extrapolated.abs() < 2e-3, "{extrapolated}");
}

/// Deflection of a thin strip over Timoshenko's, ν = 0.3, with 40 cells along and one or two through: second order and incompatible modes bend, and the
/// first order of bricks and tetrahedra shows why one takes it.
#[test]
fn a_strip_bends_like_a_beam() {
    let (length, height) = (20.0, 1.0);
    let ratio = |kind: (ElementKind, bool), through: usize| {
        let map = |x: [f64; 3]| [length * x[0], x[1], height * x[2]];
        let (nodes, elements) = meshed(kind, [40, 1, through], map);
        let mut problem = Problem::new(&nodes, elements, STEEL);
        problem.hold([true, false, false], |x| x[0] == 0.0);
        problem.hold([false, true, false], |x| x[0] == 0.0 && x[1] == 0.0);
        problem.hold([false, false, true], |x| x[0] == 0.0 && x[2] == 0.0);
        let end: Vec<usize> = (0..nodes.len()).filter(|&node| nodes[node][0] == length).collect();
        for &node in &end {
            problem.loads[node][2] = 0.1 / end.len() as f64;
        }
        problem.step(&nodes, 1e-8);
        let moved: f64 = end.iter().map(|&node| problem.positions[node][2] - nodes[node][2]).sum();
        let inertia = height.powi(3) / 12.0;
        let bending = 0.1 * length.powi(3) / (3.0 * STEEL.young * inertia);
        let shear = 0.1 * length / (5.0 / 6.0 * STEEL.shear_modulus() * height);
        moved / end.len() as f64 / (bending + shear)
    };
    for kind in ELEMENTS {
        let found = [1, 2].map(|through| ratio(kind, through));
        println!("{kind:?} {found:?}");
        if kind.0.has_middles() || kind == INCOMPATIBLE {
            assert!(found.iter().all(|found| (0.97..1.02).contains(found)), "{kind:?} {found:?}");
        } else {
            assert!(!(0.97..1.02).contains(&found[0]), "{kind:?} {found:?}");
        }
    }
}

/// The elastica with P L² / EI = 5: the tip moves by 0.71379 L across and 0.38763 L back.
#[test]
fn a_strip_bends_like_the_elastica() {
    let (length, height, through) = (10.0, 0.5, 4);
    let along = 80;
    let (nodes, elements) = grid([along, 1, through], |x| [length * x[0], x[1], height * (x[2] - 0.5)]);
    let material = Material { poisson: 0.0, ..STEEL };
    let mut problem = Problem::new(&nodes, elements, material);
    problem.hold([true; 3], |x| x[0] == 0.0);
    let force = 5.0 * material.young * height.powi(3) / 12.0 / (length * length);
    for step in 1..=10 {
        for (node, x) in nodes.iter().enumerate().filter(|(_, x)| x[0] == length) {
            let share = if x[2].abs() < 0.24 { 0.125 } else { 0.0625 };
            problem.loads[node][2] = share * force * f64::from(step) / 10.0;
        }
        let target = problem.positions.clone();
        problem.step(&target, 1e-7 * force);
    }
    let tip = nodes.iter().position(|x| x[0] == length && x[2] == 0.0).unwrap();
    let across = problem.positions[tip][2] / length;
    let back = 1.0 - problem.positions[tip][0] / length;
    println!("{across} {back}");
    assert!((across - 0.71379).abs() < 0.005, "{across}");
    assert!((back - 0.38763).abs() < 0.005, "{back}");
}

/// A tube of radii 1 and 2 whose bore is widened by half in plane strain. Without a change of volume r² = R² + a² − 1, and the pressure is
/// ∫ μ (λ² − 1/λ²) dr/r with λ = r/R.
#[test]
fn a_tube_of_rubber_is_inflated() {
    let material = Material::neo_hooke(3.0, 0.4999);
    let pressure = |around: usize, kind| {
        let quarter = std::f64::consts::FRAC_PI_2;
        let (nodes, elements) = meshed(kind, [around, around, 1], |[r, angle, z]| {
            let (sine, cosine) = (quarter * angle).sin_cos();
            [(1.0 + r) * cosine, (1.0 + r) * sine, 0.1 * z]
        });
        let radius = |x: &[f64; 3]| x[0].hypot(x[1]);
        let is_inside = |x: &[f64; 3]| radius(x) < 1.0 + 1e-9;
        let mut problem = Problem::new(&nodes, elements, material);
        problem.hold([false, false, true], |_| true);
        problem.hold([true, false, false], |x| x[0] < 1e-9);
        problem.hold([false, true, false], |x| x[1] < 1e-9);
        problem.hold([true, true, false], is_inside);
        for step in 1..=5 {
            let widened = 1.0 + 0.1 * f64::from(step);
            let target: Vec<_> = nodes
                .iter()
                .map(|x| if is_inside(x) { [widened * x[0], widened * x[1], x[2]] } else { *x })
                .collect();
            problem.step(&target, 1e-9);
        }
        // Radial reactions: those of the planes lie across.
        let held = nodes.iter().zip(problem.residual()).filter(|(x, _)| is_inside(x));
        let outward: f64 =
            held.map(|(x, residual)| -(x[0] * residual[0] + x[1] * residual[1]) / radius(x)).sum();
        outward / (quarter * 1.5 * 0.1)
    };
    // Simpson's rule.
    let (inner, outer): (f64, f64) = (1.5, (4.0 + 1.25_f64).sqrt());
    let slope = |r: f64| {
        let square = r * r / (r * r - 1.25);
        material.shear_modulus() * (square - 1.0 / square) / r
    };
    let steps = 2000;
    let width = (outer - inner) / f64::from(steps);
    let weight = |k: i32| if k == 0 || k == steps { 1.0 } else { 2.0 + 2.0 * f64::from(k % 2) };
    let exact =
        (0..=steps).map(|k| weight(k) * slope(inner + width * f64::from(k))).sum::<f64>() * width / 3.0;
    for (kind, around, limit) in [
        ((ElementKind::Hexahedron8, false), 16, 2e-3),
        (INCOMPATIBLE, 16, 2e-3),
        // Edges are straight: that is their error.
        ((ElementKind::Hexahedron20, false), 12, 3e-3),
        ((ElementKind::Tetrahedron10, false), 12, 3e-3),
    ] {
        let found = pressure(around, kind);
        println!("{kind:?}: {found} {exact} {:e}", found / exact - 1.0);
        assert!((found / exact - 1.0).abs() < limit, "{kind:?}: {found} {exact}");
    }
}

/// Upsetting of a plastic block between rough plates: residuals fall quadratically until rounding.
#[test]
fn newton_converges_quadratically() {
    let nearly_incompressible = [Material { poisson: 0.4999, ..STEEL }, Material::neo_hooke(2e5, 0.4999)];
    for material in [PLASTIC, STEEL].into_iter().chain(nearly_incompressible) {
        let (nodes, elements) = grid([3, 3, 3], |x| x);
        let mut problem = Problem::new(&nodes, elements, material);
        problem.hold([true; 3], |x| x[2] == 0.0 || x[2] == 1.0);
        let mut deepest = 0;
        for step in 1..=4 {
            let height = 1.0 - 0.03 * f64::from(step);
            let target: Vec<_> =
                nodes.iter().map(|x| [x[0] + 0.02 * f64::from(step) * x[2], x[1], x[2] * height]).collect();
            let floor = 1e-6;
            let history = problem.step(&target, floor);
            println!("{history:?}");
            let mut quadratic = 0;
            for pair in history.windows(2).filter(|pair| pair[0] < 100.0) {
                // r / E a² is the measure of a strain; C is that of the material's nonlinearity.
                let (r, next) = (pair[0] / material.young, pair[1] / material.young);
                assert!(next < 500.0 * r * r + floor / material.young, "{history:?}");
                quadratic += usize::from(pair[0] > 1e-3);
            }
            deepest = deepest.max(quadratic);
        }
        assert!(deepest >= 1, "no step came close enough to see");
    }
}
