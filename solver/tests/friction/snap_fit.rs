//! A hook snaps over a nose.

use std::path::Path;

use diffuse_contact_solver::deck::Deck;
use diffuse_contact_solver::verification::{Snapshot, Trace, trace};

use super::deck;

const COEFFICIENT: f64 = 0.2;
/// tan α of the ramp before it is bent.
const RAMP: f64 = 1.1 / 3.6;

#[derive(Clone, Copy, Debug)]
struct Climb {
    /// Along the motion and across it.
    push: f64,
    transverse: f64,
    /// tan α by the normal forces: the ramp turns with the hook.
    slope: f64,
}

impl Climb {
    fn of(snapshot: &Snapshot<'_>) -> Self {
        let [push, transverse, _] = snapshot.contact_force();
        let mut normal = [0.0; 2];
        for slave in snapshot.slaves() {
            for axis in 0..2 {
                normal[axis] += slave.nodal_force[axis] - slave.friction[axis];
            }
        }
        Self { push, transverse, slope: normal[0] / normal[1] }
    }

    /// F over P (μ + tan α)/(1 − μ tan α).
    fn ratio(&self, coefficient: f64, slope: f64) -> f64 {
        self.push / (self.transverse * (coefficient + slope) / (1.0 - coefficient * slope))
    }
}

/// The nose climbs the ramp until then, without a cut-back.
fn climb(deck: &Deck) -> Trace<Climb> {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let run = trace(deck, &examples, 1, |snapshot| Ok(Climb::of(snapshot))).unwrap();
    println!("{} increments, {} iterations", run.measures.len(), run.iterations);
    assert_eq!(run.cutbacks, 0);
    run
}

#[test]
fn the_push_onto_a_hook_is_that_of_its_ramp() {
    let mut deck = deck("snap_fit.toml");
    deck.time.end = 0.42;
    let with = climb(&deck);
    deck.interfaces[0].friction = None;
    let without = climb(&deck);
    for (run, coefficient) in [(&with, COEFFICIENT), (&without, 0.0)] {
        // From where the nose lies on the ramp, no longer on its edge at the tip.
        for climb in &run.measures[7..] {
            let [bent, ramp] = [climb.slope, RAMP].map(|slope| climb.ratio(coefficient, slope));
            println!("{climb:?} by the bent ramp {bent:.4}, by the ramp at the start {ramp:.4}");
            assert!((bent - 1.0).abs() < 1e-3, "{bent}");
            // It turns by up to 4 degrees.
            assert!((RAMP..RAMP + 0.075).contains(&climb.slope.abs()), "{climb:?}");
        }
    }
    let [with, without] = [with, without].map(|run| *run.measures.last().unwrap());
    assert!((with.push / without.push).abs() > 1.4, "{with:?} {without:?}");
}
