//! Iterative linear solutions within increments.

use diffuse_contact_solver::contact::ContactTangent;

use super::*;

fn with(solver: &str) -> String {
    format!("[time]\nend = 1.0\nincrement = 0.5\n\n[newton]\nlinear_solver = \"{solver}\"\n")
}

#[test]
fn the_linear_solver_does_not_change_equilibrium() {
    let (direct, exact, _) = run(PRESSED, &with("direct"));
    let (iterative, state, _) = run(PRESSED, &with("iterative"));
    assert_eq!(direct.increments.len(), iterative.increments.len());
    assert!(direct.increments.iter().all(|record| record.linear == LinearEffort::default()));
    for (record, exact) in iterative.increments.iter().zip(&direct.increments) {
        assert!(record.linear.iterations > 0 && record.linear.bytes > 0, "{:?}", record.linear);
        assert_eq!(record.linear.direct_instead, 0);
        for (own, exact) in record.contacts.iter().zip(&exact.contacts) {
            let difference = [0, 1, 2].map(|i| own.force[i] - exact.force[i]);
            assert!(size(difference) <= 1e-4 * size(exact.force), "{difference:?} of {:?}", exact.force);
        }
    }
    for (own, exact) in state.positions.iter().zip(&exact.positions) {
        assert!(size([0, 1, 2].map(|i| own[i] - exact[i])) < 1e-5, "{own:?} {exact:?}");
    }
}

#[test]
fn a_continued_run_with_the_iterative_solver_has_the_same_bits() {
    let (notes, end, _) = run(PRESSED, &with("iterative"));
    assert!(notes.states.len() > 1);
    let (deck, model) = deck(PRESSED, &with("iterative"));
    let continued = statics(&deck, &model).run(notes.states[0].clone(), &mut Notes::default()).unwrap();
    assert_eq!(continued, end);
}

/// The example of two blocks, small, with other lines in the interface and the material.
fn two_blocks(solver: &str, interface: &str, material: &str) -> (Notes, State) {
    let mut text = include_str!("../../../examples/two_blocks.toml").to_owned();
    for (line, own) in [
        ("divisions = [14, 14, 7]", "divisions = [7, 7, 3]"),
        ("divisions = [10, 10, 5]", "divisions = [4, 4, 2]"),
        ("penalty = 1e7 ", &format!("{interface}\n#")),
        ("\nareas = true\n\n", "\n\n"),
        ("poisson = 0.3", &format!("poisson = 0.3\n{material}")),
        ("linear_solver = \"auto\"\n\n", &format!("linear_solver = \"{solver}\"\n\n")),
    ] {
        assert!(text.contains(line), "{line}");
        text = text.replace(line, own);
    }
    let (notes, state, _) = run(&text, "");
    (notes, state)
}

#[test]
fn every_kind_of_contact_and_yielding_lead_where_factors_do() {
    let cases = [
        ("areas = true\npenalty = 1e7", ""),
        ("areas = true\npenalty = 1e9", ""),
        ("areas = true\ntwo_pass = true\npenalty = 1e6", ""),
        ("areas = true\ntwo_pass = true\npenalty = 1e9", ""),
        ("integration = \"faces\"\npenalty = 1e6", ""),
        ("integration = \"faces\"\npenalty = 1e8", ""),
        ("integration = \"faces\"\npenalty = 1e6\nfriction = 0.3", ""),
        ("areas = true\npenalty = 1e7", "yield_stress = 150.0\nhardening = 1000.0"),
    ];
    for (interface, material) in cases {
        let (direct, expected) = two_blocks("direct", interface, material);
        let (iterative, found) = two_blocks("iterative", interface, material);
        let (direct, iterative) = (&direct.increments[0], &iterative.increments[0]);
        assert_eq!(direct.linear, LinearEffort::default());
        assert!(iterative.linear.iterations > 0 && iterative.linear.direct_instead == 0, "{interface}");
        assert_eq!(direct.active, iterative.active, "{interface} {material}");
        // However stiff contact is, steps are as good as those of factors, and take few iterations.
        let [steps, iterations] = [iterative.iterations, iterative.linear.iterations];
        assert!(steps <= direct.iterations + 1, "{steps}, {}: {interface}", direct.iterations);
        assert!(iterations <= 10 * steps, "{iterations} in {steps}: {interface}");
        let yielded = expected.points.iter().any(|point| point.equivalent_plastic_strain > 0.0);
        assert_eq!(yielded, !material.is_empty());
        let pairs = expected.positions.as_flattened().iter().zip(found.positions.as_flattened());
        let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, crate::common::worse);
        // The upper block moves down by 0.02, to a tolerance of 1e-6 of the forces.
        assert!(error < 1e-6, "{error:e}: {interface} {material}");
    }
}

/// ε N Nᵀ is assembled, −f M is an operator: the same K in other parts.
#[test]
fn the_tangent_as_an_operator_takes_the_same_steps() {
    let cases = [
        ("areas = true\npenalty = 1e7", ""),
        ("areas = true\npenalty = 1e9", ""),
        ("areas = true\ntwo_pass = true\npenalty = 1e6", ""),
        (
            "areas = true\npenalty = 1e6\nmethod = \"augmented-lagrangian\"\naugmentation = { tolerance = 1e-6, max = 5 }",
            "",
        ),
        ("areas = true\npenalty = 1e7", "yield_stress = 150.0\nhardening = 1000.0"),
    ];
    for (interface, material) in cases {
        let (assembled, expected) = two_blocks("iterative", interface, material);
        let (operator, found) = two_blocks("iterative\"\ncontact_tangent = \"operator", interface, material);
        let (assembled, operator) = (&assembled.increments[0], &operator.increments[0]);
        assert_eq!(operator.iterations, assembled.iterations, "{interface} {material}");
        assert_eq!(operator.augmentations, assembled.augmentations, "{interface} {material}");
        assert_eq!((operator.active, operator.linear.direct_instead), (assembled.active, 0));
        let [own, other] = [operator, assembled].map(|record| record.linear.iterations);
        assert!(own.abs_diff(other) <= 2, "{own} {other}: {interface} {material}");
        for (own, other) in operator.contacts.iter().zip(&assembled.contacts) {
            let difference = [0, 1, 2].map(|i| own.force[i] - other.force[i]);
            assert!(size(difference) <= 1e-6 * size(other.force), "{difference:?} of {:?}", other.force);
        }
        let pairs = expected.positions.as_flattened().iter().zip(found.positions.as_flattened());
        let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, crate::common::worse);
        assert!(error < 1e-7, "{error:e}: {interface} {material}");
    }
}

/// All of friction is in the operator, and its stiffness that of contact: products are as exact, but the preconditioner does not know it.
#[cfg(feature = "friction")]
#[test]
fn the_operator_of_friction_takes_the_same_steps() {
    let interface = "areas = true\npenalty = 1e6\nfriction = 0.3";
    let (direct, _) = two_blocks("direct", interface, "");
    let (assembled, expected) = two_blocks("iterative", interface, "");
    let (operator, found) = two_blocks("iterative\"\ncontact_tangent = \"operator", interface, "");
    let [direct, assembled, operator] = [&direct, &assembled, &operator].map(|notes| &notes.increments[0]);
    assert_eq!([operator.iterations; 2], [assembled.iterations, direct.iterations]);
    assert_eq!((operator.active, operator.linear.direct_instead), (assembled.active, 0));
    assert!(operator.linear.iterations > assembled.linear.iterations);
    assert!(operator.linear.iterations <= 40 * operator.iterations, "{:?}", operator.linear);
    for (own, other) in operator.contacts.iter().zip(&assembled.contacts) {
        let difference = [0, 1, 2].map(|i| own.force[i] - other.force[i]);
        assert!(size(difference) <= 1e-5 * size(other.force), "{difference:?} of {:?}", other.force);
        // The upper block is pushed aside.
        assert!(other.force[0].abs() > 0.01 * other.force[2].abs(), "{:?}", other.force);
    }
    let pairs = expected.positions.as_flattened().iter().zip(found.positions.as_flattened());
    let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, crate::common::worse);
    assert!(error < 1e-6, "{error:e}");
}

/// A curved master under a stiff penalty, over increments: here −f M is what makes the last iterations quadratic.
#[test]
fn the_tangent_as_an_operator_is_as_exact_as_the_assembled_one() {
    let with = |form: &str| format!("{}contact_tangent = \"{form}\"\ntolerance = 1e-9\n", with("iterative"));
    let (assembled, expected, _) = run(PRESSED, &with("assembled"));
    let (operator, found, _) = run(PRESSED, &with("operator"));
    assert_eq!(assembled.increments.len(), operator.increments.len());
    for (own, other) in operator.increments.iter().zip(&assembled.increments) {
        assert_eq!(own.iterations, other.iterations);
        let [.., before, last] = &own.history[..] else { panic!("{own:?}") };
        assert!(last.relative < 1e-2 * before.relative, "{own:?}");
    }
    for (own, other) in found.positions.iter().zip(&expected.positions) {
        assert!(size([0, 1, 2].map(|i| own[i] - other[i])) < 1e-8, "{own:?} {other:?}");
    }
}

#[test]
fn factors_of_an_operator_are_refused() {
    let (mut deck, model) = deck(PRESSED, &with("direct"));
    deck.newton.contact_tangent = ContactTangent::Operator;
    let refused = solve::statics(&deck, &model, 1).err().unwrap().to_string();
    assert!(refused.contains("newton.linear_solver has to be iterative or auto"), "{refused}");
}
