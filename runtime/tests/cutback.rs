//! The hint to cut an increment back.

use diffuse_contact::interface::{
    ContactInterface, Cutback, CutbackHint, InterfaceOptions, NoContact, Outcome,
};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Mode, Point};

/// A bowl of 9 × 9 nodes, outside above, its centre of curvature 10 over its bottom, and a slave at `slave`.
fn positions(slave: Point) -> Vec<Point> {
    let height = |x: f64, y: f64| 0.05 * ((x - 4.0).powi(2) + (y - 4.0).powi(2));
    let grid = (0..81).map(|k| [f64::from(k % 9), f64::from(k / 9)]).map(|[x, y]| [x, y, height(x, y)]);
    grid.chain([slave]).collect()
}

#[test]
fn the_hint_stays_until_the_slave_has_a_result() {
    let facets = (0..64).map(|k| k % 8 + 9 * (k / 8));
    let facets = facets.map(|k| Facet::Quadrilateral([k, k + 1, k + 10, k + 9])).collect();
    let start = positions([4.2, 3.9, -0.1]);
    let master = MasterSurface::new(&start, facets).unwrap();
    let mut interface =
        ContactInterface::new(master, vec![81], &[], &start, InterfaceOptions::default()).unwrap();
    let mut cutback = Cutback::new(1);
    let mut at = |slave: Point, refreshes: bool| {
        if refreshes {
            interface.refresh_pairing(&positions(slave)).unwrap();
            cutback.begin(&interface).unwrap();
        } else {
            interface.update(&positions(slave)).unwrap();
        }
        cutback.book(interface.evaluate(Mode::Value).unwrap());
        cutback.hint(&interface, 0.25)
    };
    let (far, beyond) = ([4.2, 3.9, 30.0], [90.0, 3.9, -0.1]);
    // Above at first: a slave that never penetrated has nothing to lose.
    assert_eq!(at([4.2, 3.9, 0.1], true).factor, 1.0);
    assert_eq!(at(far, false), CutbackHint { factor: 1.0, cause: None });
    assert_eq!(at(start[81], false).factor, 1.0);
    let lost = at(far, false);
    assert!(lost.factor < 1.0, "{lost:?}");
    let (slave, outcome) = lost.cause.unwrap();
    assert!(slave == 81 && matches!(outcome, Outcome::None(NoContact::Element { .. })), "{outcome:?}");
    // As often as it is asked for.
    assert_eq!(at(far, false), lost);
    assert_eq!(at(far, false), lost);
    // Cut back: paired at the accepted positions again, then again too far at once.
    assert_eq!(at(start[81], true).factor, 1.0);
    assert_eq!(at(far, false), lost);
    // An attempt pushes in a slave that was above when it was refreshed: going back forgets that.
    let above = [4.2, 3.9, 0.1];
    assert_eq!(at(above, true).factor, 1.0);
    assert_eq!(at(start[81], false).factor, 1.0);
    assert!(at(far, false).factor < 1.0);
    assert_eq!(at(above, true).factor, 1.0);
    assert_eq!(at(far, false).factor, 1.0);
    // Beyond the border there is no contact to be lost.
    assert_eq!(at(beyond, true).factor, 1.0);
    assert_eq!(at(beyond, false).factor, 1.0);
    // A slave that penetrates from the start, as after a restart, has contact to lose in the first evaluation.
    let mut restarted = Cutback::new(1);
    interface.refresh_pairing(&start).unwrap();
    restarted.begin(&interface).unwrap();
    interface.update(&positions(far)).unwrap();
    restarted.book(interface.evaluate(Mode::Value).unwrap());
    assert_eq!(restarted.hint(&interface, 0.25), lost);
}
