//! Iterative linear solutions within increments.

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
