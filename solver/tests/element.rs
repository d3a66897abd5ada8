//! Single elements: forces, tangent, stresses.

use crate::common::{ELEMENTS, INCOMPATIBLE, body, grid, meshed, numbers, one_of};
use diffuse_contact_mesh::ElementKind;
use diffuse_contact_solver::material::{Material, Plasticity, PointState};
use diffuse_contact_solver::solid::{Order, Solid, SolidError, SolidResponse};
use nalgebra::DMatrix;

const RUBBER: Material = Material::elastic(10.0, 0.45);
const SOFT_METAL: Material =
    Material::elastic(2000.0, 0.3).with_plasticity(Plasticity { yield_stress: 10.0, hardening: 50.0 });
const NEO_HOOKE: Material = Material::neo_hooke(10.0, 0.45);

/// A distorted element and a deformed state of it.
fn distorted(kind: (ElementKind, bool), material: Material, amplitude: f64) -> (Solid, Vec<[f64; 3]>) {
    let mut next = numbers(3);
    let (nodes, elements) = meshed(kind, [1, 1, 1], |x| x.map(|x| 2.0 * x + 0.3 * next_of(x)));
    let solid = Solid::new(&nodes, &[body(one_of(&elements, 0), material)]).unwrap();
    let deformed =
        nodes.iter().map(|x| [0, 1, 2].map(|i| 1.1 * x[(i + 1) % 3] + 5.0 + amplitude * next())).collect();
    (solid, deformed)
}

/// How far nodes of an edge of length 2 are moved: as far as the element keeps its orientation.
fn amplitude((kind, _): (ElementKind, bool)) -> f64 {
    if kind == ElementKind::Hexahedron8 { 0.25 } else { 0.15 }
}

/// The largest step of the differences; nodes of second order are closer to one another.
fn step((kind, _): (ElementKind, bool)) -> f64 {
    if kind.has_middles() { 4e-3 } else { 1e-2 }
}

/// Some number between −1 and 1 for a coordinate of the unit cube.
fn next_of(x: f64) -> f64 {
    (7.0 * x + 1.0).sin()
}

fn evaluate(solid: &Solid, positions: &[[f64; 3]], states: &[PointState]) -> SolidResponse {
    let mut response = SolidResponse::default();
    solid.evaluate(positions, states, Order::Tangent, &mut response).unwrap();
    response
}

/// Central differences with Richardson's extrapolation, sixth order.
fn derivative(step: f64, at: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let central = |h: f64| -> Vec<f64> {
        at(h).iter().zip(at(-h)).map(|(plus, minus)| (plus - minus) / (2.0 * h)).collect()
    };
    let (d1, d2, d4) = (central(step), central(step / 2.0), central(step / 4.0));
    let extrapolated = |i: usize| {
        let (e1, e2) = ((4.0 * d2[i] - d1[i]) / 3.0, (4.0 * d4[i] - d2[i]) / 3.0);
        (16.0 * e2 - e1) / 15.0
    };
    (0..d1.len()).map(extrapolated).collect()
}

fn moved(positions: &[[f64; 3]], coordinate: usize, by: f64) -> Vec<[f64; 3]> {
    let mut positions = positions.to_vec();
    positions[coordinate / 3][coordinate % 3] += by;
    positions
}

/// Coordinates of the element's nodes in the order of its forces.
fn coordinates(solid: &Solid) -> Vec<usize> {
    let nodes = solid.elements().next().unwrap();
    nodes.iter().flat_map(|node| (0..3).map(move |i| 3 * node + i)).collect()
}

#[test]
fn forces_are_the_gradient_of_the_energy() {
    for (kind, material) in
        ELEMENTS.into_iter().flat_map(|kind| [RUBBER, NEO_HOOKE].map(|material| (kind, material)))
    {
        let (solid, positions) = distorted(kind, material, amplitude(kind));
        let states = solid.states();
        let forces = evaluate(&solid, &positions, &states).forces;
        let largest = forces.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        assert!(largest > 0.1, "{kind:?}: {largest}");
        for (i, coordinate) in coordinates(&solid).into_iter().enumerate() {
            let numeric = derivative(step(kind), |h| {
                vec![solid.stored_energy(&moved(&positions, coordinate, h), &states).unwrap()]
            });
            let (numeric, force) = (numeric[0], forces[i]);
            assert!((numeric - force).abs() < 1e-9 * largest, "{kind:?} {i}: {numeric} {force}");
        }
    }
}

fn assert_tangent(solid: &Solid, positions: &[[f64; 3]], states: &[PointState], step: f64, tolerance: f64) {
    let tangent = evaluate(solid, positions, states).tangents;
    let largest = tangent.iter().fold(0.0, |m: f64, k| m.max(k.abs()));
    let nodes = solid.elements().next().map_or(0, <[usize]>::len);
    for (j, coordinate) in coordinates(solid).into_iter().enumerate() {
        let column = derivative(step, |h| evaluate(solid, &moved(positions, coordinate, h), states).forces);
        for (i, numeric) in column.into_iter().enumerate() {
            // Both halves are compared: the tangent is symmetric only if the forces' derivative is.
            let (row, col) = (i.max(j), i.min(j));
            let exact = tangent[row * (row + 1) / 2 + col];
            assert!(
                (numeric - exact).abs() < tolerance * largest,
                "{nodes} nodes ({i}, {j}): {numeric} {exact}"
            );
        }
    }
}

#[test]
fn tangent_is_the_derivative_of_the_forces() {
    for kind in ELEMENTS {
        let (solid, positions) = distorted(kind, RUBBER, amplitude(kind));
        assert_tangent(&solid, &positions, &solid.states(), step(kind), 1e-9);
        let (rubber, positions) = distorted(kind, NEO_HOOKE, amplitude(kind));
        assert_tangent(&rubber, &positions, &rubber.states(), step(kind), 1e-9);
        let (nearly, positions) =
            distorted(kind, Material { poisson: 0.4999, ..RUBBER }, 0.4 * amplitude(kind));
        if kind == INCOMPATIBLE {
            // The pressure is a thousand times the shear modulus.
            let mut response = SolidResponse::default();
            let found = nearly.evaluate(&positions, &nearly.states(), Order::Residual, &mut response);
            assert!(matches!(found, Err(SolidError::UnstableModes { element: 0, .. })), "{found:?}");
        } else {
            assert_tangent(&nearly, &positions, &nearly.states(), step(kind), 1e-9);
        }
        // At rest principal stretches are equal everywhere.
        let (nodes, elements) = meshed(kind, [1, 1, 1], |x| x);
        let solid = Solid::new(&nodes, &[body(one_of(&elements, 0), RUBBER)]).unwrap();
        assert_tangent(&solid, &nodes, &solid.states(), step(kind), 1e-9);
    }
}

#[test]
fn plastic_tangent_is_the_derivative_of_the_forces() {
    for kind in [(ElementKind::Hexahedron8, false), INCOMPATIBLE, (ElementKind::Tetrahedron10, false)] {
        assert_plastic_tangent(kind);
    }
}

fn assert_plastic_tangent(kind: (ElementKind, bool)) {
    let (solid, positions) = distorted(kind, SOFT_METAL, 0.2);
    let virgin = solid.states();
    let first = evaluate(&solid, &positions, &virgin);
    assert!(first.states.iter().all(|state| state.equivalent_plastic_strain > 0.05));
    assert_tangent(&solid, &positions, &virgin, 2e-3, 1e-8);
    // On from there, in another direction.
    let mut next = numbers(11);
    let further: Vec<_> = positions.iter().map(|x| x.map(|x| x + 0.15 * next())).collect();
    let second = evaluate(&solid, &further, &first.states);
    let flowing = second.states.iter().zip(&first.states);
    assert!(flowing.clone().all(|(b, a)| b.equivalent_plastic_strain > a.equivalent_plastic_strain + 0.01));
    assert_tangent(&solid, &further, &first.states, 1e-3, 1e-8);
    for state in &second.states {
        let determinant = state.inverse_plastic_metric().determinant();
        assert!((determinant - 1.0).abs() < 1e-14);
    }
}

/// No force and no torque on the whole, no force from a translation; a rotation of the body rotates the forces.
#[test]
fn rigid_motions() {
    for kind in ELEMENTS {
        let (solid, positions) = distorted(kind, RUBBER, amplitude(kind));
        let states = solid.states();
        let response = evaluate(&solid, &positions, &states);
        let (forces, tangent) = (&response.forces, &response.tangents);
        let nodes = solid.elements().next().unwrap();
        let count = nodes.len();
        let x: Vec<f64> = nodes.iter().flat_map(|&node| positions[node]).collect();
        let entry = |i: usize, j: usize| tangent[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
        let largest = tangent.iter().fold(0.0, |m: f64, k| m.max(k.abs()));
        for axis in 0..3 {
            let force: f64 = (0..count).map(|a| forces[3 * a + axis]).sum();
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            let torque: f64 =
                (0..count).map(|a| x[3 * a + i] * forces[3 * a + j] - x[3 * a + j] * forces[3 * a + i]).sum();
            assert!(force.abs() < 1e-13 * largest, "{kind:?} {force:e}");
            assert!(torque.abs() < 1e-12 * largest, "{kind:?} {torque:e}");
            // e_axis × v
            let turned = |v: &[f64]| -> Vec<f64> {
                let mut w = vec![0.0; 3 * count];
                for a in 0..count {
                    w[3 * a + i] = -v[3 * a + j];
                    w[3 * a + j] = v[3 * a + i];
                }
                w
            };
            let (rotation, rotated_force) = (turned(&x), turned(forces));
            for row in 0..3 * count {
                let translation: f64 = (0..count).map(|a| entry(row, 3 * a + axis)).sum();
                assert!(translation.abs() < 1e-13 * largest, "{kind:?} {translation:e}");
                let spin: f64 = (0..3 * count).map(|col| entry(row, col) * rotation[col]).sum();
                assert!((spin - rotated_force[row]).abs() < 1e-12 * largest, "{kind:?}");
            }
        }
    }
}

#[test]
fn a_quarter_turn_has_no_stress() {
    let (nodes, elements) = grid([2, 2, 2], |x| x.map(|x| 3.0 * x + 0.2 * next_of(x)));
    let solid = Solid::new(&nodes, &[body(elements, SOFT_METAL)]).unwrap();
    let turned: Vec<_> = nodes.iter().map(|x| [100.0 - x[1], x[0] - 50.0, x[2]]).collect();
    let response = evaluate(&solid, &turned, &solid.states());
    assert!(response.forces.iter().all(|f| f.abs() < 1e-10));
    let recovery = solid.recover(&turned, &response.states).unwrap();
    assert!(recovery.points.iter().all(|point| point.von_mises < 1e-10));
    assert_eq!(response.states, solid.states());
}

/// Recovery gives back the stress that was put in, at points and nodes, in each body by its own material.
#[test]
fn recovery_of_a_uniform_state() {
    let (nodes, elements) = grid([2, 1, 1], |x| [2.0 * x[0], x[1], x[2]]);
    let stiff = Material { young: 30.0, ..RUBBER };
    let bodies = [body(one_of(&elements, 0), RUBBER), body(one_of(&elements, 1), stiff)];
    let solid = Solid::new(&nodes, &bodies).unwrap();
    let stretched: Vec<_> = nodes.iter().map(|x| [1.2 * x[0], 0.9 * x[1], x[2] + 0.1 * x[0]]).collect();
    let response = evaluate(&solid, &stretched, &solid.states());
    let recovery = solid.recover(&stretched, &response.states).unwrap();
    assert_eq!(recovery.points.len(), 16);
    assert_eq!(recovery.bodies.len(), 2);
    for (body, points) in recovery.bodies.iter().zip(recovery.points.chunks(8)) {
        assert_eq!(body.nodes.len(), 8);
        for fields in body.fields.iter().chain(points) {
            for k in 0..6 {
                assert!((fields.stress[k] - points[0].stress[k]).abs() < 1e-12);
            }
            assert!((fields.von_mises - points[0].von_mises).abs() < 1e-12);
        }
    }
    let (soft, hard) = (recovery.points[0], recovery.points[8]);
    assert!((hard.stress[0] - 3.0 * soft.stress[0]).abs() < 1e-12 && soft.stress[0] > 0.5);
    // The mean stress is κ ln θ / θ.
    let theta: f64 = 1.2 * 0.9;
    let mean = (soft.stress[0] + soft.stress[1] + soft.stress[2]) / 3.0;
    assert!((mean - RUBBER.bulk_modulus() * theta.ln() / theta).abs() < 1e-12);
    // Nodes between the bodies are in both.
    assert!(
        recovery.bodies[0].nodes.iter().filter(|node| recovery.bodies[1].nodes.contains(node)).count() == 4
    );
}

/// The same bits for any number of threads.
#[test]
fn threads_make_no_difference() {
    let (nodes, elements) = grid([5, 5, 4], |x| x.map(|x| 3.0 * x + 0.1 * next_of(x)));
    let solid = Solid::new(&nodes, &[body(elements, SOFT_METAL)]).unwrap();
    let mut next = numbers(5);
    let positions: Vec<_> = nodes.iter().map(|x| x.map(|x| x + 0.05 * next())).collect();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| evaluate(&solid, &positions, &solid.states()))
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(one.forces, three.forces);
    assert_eq!(one.tangents, three.tangents);
    assert_eq!(one.states, three.states);
}

#[test]
fn bad_input_is_named() {
    let (nodes, elements) = grid([2, 1, 1], |x| x);
    let solid = Solid::new(&nodes, &[body(elements.clone(), RUBBER)]).unwrap();
    let states = solid.states();
    let mut out = SolidResponse::default();
    let mut evaluate = |positions: &[[f64; 3]], states: &[PointState]| {
        solid.evaluate(positions, states, Order::Residual, &mut out).unwrap_err()
    };

    let mut flipped = nodes.clone();
    for position in &mut flipped {
        position[0] = -position[0];
    }
    assert!(
        matches!(evaluate(&flipped, &states), SolidError::Inverted { element: 0, point: 0, jacobian, .. } if (jacobian + 1.0).abs() < 1e-12)
    );
    // Only the second element is bad.
    let mut second = nodes.clone();
    for position in second.iter_mut().filter(|position| position[0] == 1.0) {
        position[0] = 0.2;
    }
    let error = evaluate(&second, &states);
    assert!(matches!(error, SolidError::Inverted { element: 1, .. }));
    assert!(error.to_string().starts_with("element 2 of the part \"body\" is turned inside out"), "{error}");
    let flat: Vec<_> = nodes.iter().map(|x| [x[0], x[1], 0.0]).collect();
    assert!(matches!(evaluate(&flat, &states), SolidError::Inverted { jacobian: 0.0, .. }));
    let huge: Vec<_> = nodes.iter().map(|x| x.map(|x| 1e150 * x)).collect();
    assert!(matches!(evaluate(&huge, &states), SolidError::Inverted { .. } | SolidError::Unresolved { .. }));
    let needle: Vec<_> =
        nodes.iter().map(|x| [1e12 * (x[0] + x[1]), 1e12 * (x[0] + x[1]) + 1e-6 * x[1], x[2]]).collect();
    assert!(matches!(
        evaluate(&needle, &states),
        SolidError::Inverted { .. } | SolidError::Unresolved { .. }
    ));

    let mut nan = nodes.clone();
    nan[3][1] = f64::NAN;
    assert!(matches!(evaluate(&nan, &states), SolidError::NotFinite { node: 3, .. }));
    assert!(matches!(
        evaluate(&nodes[1..], &states),
        SolidError::WrongCount { what: "positions", given: 11, expected: 12 }
    ));
    assert!(matches!(
        evaluate(&nodes, &states[1..]),
        SolidError::WrongCount { what: "states", given: 15, expected: 16 }
    ));
    let mut broken = states.clone();
    broken[9].inverse_plastic_metric = [f64::NAN; 6];
    assert!(matches!(evaluate(&nodes, &broken), SolidError::Unresolved { element: 1, point: 1, .. }));

    assert!(matches!(
        Solid::new(&flipped, &[body(elements.clone(), RUBBER)]).unwrap_err(),
        SolidError::BadElement { element: 0, point: 0, jacobian, .. } if jacobian < 0.0
    ));
    assert!(matches!(
        Solid::new(&nodes[..11], &[body(elements.clone(), RUBBER)]).unwrap_err(),
        SolidError::NodeOutOfRange { element: 1, node: 11, count: 11, .. }
    ));
    assert!(matches!(
        Solid::new(&nodes, &[body(elements, Material { poisson: 0.5, ..RUBBER })]).unwrap_err(),
        SolidError::Material { body: 0, .. }
    ));
}

/// Hencky's dilatation loses its stiffness beyond e times the volume, and with it the modes. Then there is no answer, and it says why.
#[test]
fn modes_without_stable_equilibrium_are_refused() {
    let (nodes, elements) = meshed(INCOMPATIBLE, [1, 1, 1], |x| x);
    let solid = Solid::new(&nodes, &[body(elements, RUBBER)]).unwrap();
    let mut response = SolidResponse::default();
    let mut at = |stretch: f64| {
        let grown: Vec<_> = nodes.iter().map(|x| x.map(|x| stretch * x)).collect();
        solid.evaluate(&grown, &solid.states(), Order::Tangent, &mut response)
    };
    assert_eq!(at(1.2), Ok(()));
    let error = at(1.6).unwrap_err();
    assert!(matches!(error, SolidError::UnstableModes { element: 0, .. }), "{error}");
    assert!(error.to_string().contains("element 1 of the part \"body\""), "{error}");
}

/// The least stiffness of the twelve hourglass motions of a cube of one element, over the shear modulus and the length of its edge; uniform
/// deformations are orthogonal to them. `None` if there is no answer.
fn least_hourglass(kind: (ElementKind, bool), material: Material, stretches: [f64; 3]) -> Option<f64> {
    let (nodes, elements) = meshed(kind, [1, 1, 1], |x| x);
    let solid = Solid::new(&nodes, &[body(elements, material)]).unwrap();
    let moved: Vec<_> = nodes.iter().map(|x| [0, 1, 2].map(|i| stretches[i] * x[i])).collect();
    let mut response = SolidResponse::default();
    solid.evaluate(&moved, &solid.states(), Order::Tangent, &mut response).ok()?;
    let own = solid.elements().next().unwrap();
    let centred = |a: usize| nodes[own[a]].map(|x| 2.0 * x - 1.0);
    let vector = |k: usize, a: usize| {
        let [x, y, z] = centred(a);
        [y * z, z * x, x * y, x * y * z][k] / 8.0_f64.sqrt()
    };
    let entry = |i: usize, j: usize| response.tangents[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
    let projected = DMatrix::from_fn(12, 12, |row, column| {
        let terms = (0..64).map(|pair| {
            let (a, b) = (pair / 8, pair % 8);
            vector(row / 3, a) * entry(3 * a + row % 3, 3 * b + column % 3) * vector(column / 3, b)
        });
        terms.sum::<f64>()
    });
    Some(projected.symmetric_eigenvalues().min() / material.shear_modulus())
}

/// Elements with modes lose the stiffness of hourglass motions under compression and pressure (Wriggers and Reese 1996); as far as is said
/// on the solver's page they have it.
#[test]
fn hourglass_motions_are_stiff_within_bounds() {
    let steel = Material { poisson: 0.3, ..RUBBER };
    for (name, material) in
        [("0.3", steel), ("0.45", RUBBER), ("0.4999", Material { poisson: 0.4999, ..RUBBER })]
    {
        for percent in (20..=100).rev().step_by(5) {
            // Free sides: stress along one axis alone.
            let (along, ratio) = (f64::from(percent) / 100.0, material.poisson);
            let stretches = [along.powf(-ratio), along.powf(-ratio), along];
            let [plain, modes] = [(ElementKind::Hexahedron8, false), INCOMPATIBLE]
                .map(|kind| least_hourglass(kind, material, stretches));
            println!("nu {name}, stretch {along}: {plain:?} {modes:?}");
            assert!(percent < 80 || modes.is_some_and(|modes| modes > 0.0), "{name} {along}: {modes:?}");
        }
        for tenths in (-40_i32..=40).step_by(4) {
            // U' J = kappa ln J.
            let over = f64::from(tenths) / 10.0;
            let stretch = (over * material.shear_modulus() / material.bulk_modulus() / 3.0).exp();
            let [plain, modes] = [(ElementKind::Hexahedron8, false), INCOMPATIBLE]
                .map(|kind| least_hourglass(kind, material, [stretch; 3]));
            println!("nu {name}, pressure over shear modulus {over}: {plain:?} {modes:?}");
            assert!(
                !(-8..=16).contains(&tenths) || modes.is_some_and(|modes| modes > 0.0),
                "{name} {over}: {modes:?}"
            );
        }
    }
}
