//! The examples of the paper on their coarse meshes, with both elements: the numbers that the study of them rests on.

use std::path::Path;

use diffuse_contact_solver::deck::Deck;
use diffuse_contact_solver::statics::IncrementRecord;
use diffuse_contact_solver::verification::trace;

const CYLINDER: &str = include_str!("../../examples/plate_cylinder.toml");
const PINCH: &str = include_str!("../../examples/pipe_pinch.toml");
const PLASTIC_PINCH: &str = include_str!("../../examples/pipe_pinch_plastic.toml");

/// The increments of a run.
struct Course {
    records: Vec<IncrementRecord>,
    positions: Vec<Vec<[f64; 3]>>,
    /// Nodes that carry contact force at the end of each.
    loaded: Vec<Vec<usize>>,
}

/// Replaces each text, which is there.
fn with(deck: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(deck.to_owned(), |deck, (from, to)| {
        assert!(deck.contains(from), "`{from}` is not in the deck");
        deck.replace(from, to)
    })
}

fn classic(deck: &str) -> String {
    with(deck, &[("contact = \"diffuse\"", "contact = \"node-to-facet\"")])
}

/// The first increments of a deck, which has equal ones.
fn run(deck: &str, increments: usize) -> Course {
    let mut deck = Deck::parse(deck).unwrap();
    deck.time.end = increments as f64 * deck.time.increment;
    let mut course = Course { records: Vec::new(), positions: Vec::new(), loaded: Vec::new() };
    let run = trace(&deck, Path::new(""), 1, |snapshot| {
        course.records.push(snapshot.record.clone());
        course.positions.push(snapshot.state.positions.clone());
        let loaded = snapshot.slaves().filter(|slave| slave.force > 0.0);
        course.loaded.push(loaded.map(|slave| slave.node).collect());
        Ok(())
    });
    assert_eq!(run.unwrap().cutbacks, 0);
    assert_eq!(course.records.len(), increments);
    course
}

impl Course {
    fn iterations(&self) -> usize {
        self.records.iter().map(|record| record.iterations).sum()
    }

    /// Force between the bodies at the end, along the y-axis.
    fn force(&self) -> f64 {
        self.records.last().unwrap().contacts[0].force[1].abs()
    }

    /// How far loaded nodes are inside and outside the true cylinder of `plate_cylinder` at most.
    fn off_cylinder(&self) -> [f64; 2] {
        let depths = self.positions.iter().zip(&self.loaded).flat_map(|(positions, loaded)| {
            loaded.iter().map(|&node| {
                let [x, _, z] = positions[node];
                100.0 - x.hypot(z + 100.0)
            })
        });
        depths
            .fold([0.0, 0.0], |[inside, outside], depth| [f64::max(inside, depth), f64::max(outside, -depth)])
    }
}

#[test]
fn a_plate_penetrates_the_true_cylinder_as_deep_as_its_facets_let_it() {
    let facets = run(&classic(CYLINDER), 10);
    let cubic = run(CYLINDER, 10);
    let interpolating =
        with(CYLINDER, &[("[[interface]]", "[[interface]]\nweight = \"cubic-interpolating\"")]);
    let interpolating = run(&interpolating, 10);
    for course in [&facets, &cubic, &interpolating] {
        assert_eq!(course.records.len(), 10);
        assert!(course.iterations() < 50, "{}", course.iterations());
    }
    // No node gets deeper than the middle of a facet and what the penalty lets through; some get nearly as deep.
    let sagitta = 100.0 * (1.0 - 5_f64.to_radians().cos());
    let [inside, _] = facets.off_cylinder();
    assert!(inside > 0.75 * sagitta && inside < sagitta + 0.01, "{inside}");
    for (course, outside) in [(&cubic, 0.06), (&interpolating, 0.03)] {
        let [deepest, highest] = course.off_cylinder();
        assert!(inside > 100.0 * deepest, "{inside} over {deepest}");
        // Where the fit is off, it is off to the outside.
        assert!(highest < outside, "{highest}");
    }
}

#[test]
fn the_elastic_pinch_takes_hardly_more_than_three_iterations_an_increment() {
    let increments = 12;
    let diffuse = run(PINCH, increments);
    let facets = run(&classic(PINCH), increments);
    assert!(diffuse.iterations() <= 4 * increments, "{}", diffuse.iterations());
    assert!(diffuse.iterations() <= facets.iterations(), "{} {}", diffuse.iterations(), facets.iterations());
    // The same pipe under the same plate.
    assert!((diffuse.force() / facets.force() - 1.0).abs() < 0.02, "{} {}", diffuse.force(), facets.force());
    // Thin-ring theory for a quarter of a ring between smooth plates: F = E I δ / (r³ (π/4 − 2/π)), I = b t³ / 12.
    let first = diffuse.records[0].contacts[0].force[1].abs();
    let rigidity = 200_000.0 * 20.0 * 10_f64.powi(3) / 12.0;
    let ring =
        rigidity * 2.5 / (95_f64.powi(3) * (std::f64::consts::FRAC_PI_4 - std::f64::consts::FRAC_2_PI));
    // Hexahedra without rotations are stiffer, 16 around a quarter by a fifth.
    assert!(first > ring && first < 1.25 * ring, "{first} {ring}");
    // Quadratic at the end: the last residual is below the square of the one before, but for rounding.
    for record in &diffuse.records {
        let [.., before, last] = record.history.as_slice() else { panic!("two residuals") };
        assert!(last.relative < 50.0 * before.relative.powi(2) + 1e-10, "{record:?}");
    }
}

#[test]
fn the_plastic_pinch_goes_on_yielding_from_one_increment_to_the_next() {
    let increments = 12;
    let diffuse = run(PLASTIC_PINCH, increments);
    let elastic = with(PLASTIC_PINCH, &[("yield_stress = 400.0\nhardening = 3450.0\n", "")]);
    let elastic = run(&elastic, increments);
    assert!(diffuse.force() < 0.8 * elastic.force(), "{} {}", diffuse.force(), elastic.force());
    // Seen from the committed state every increment would begin elastic, which costs two iterations more.
    assert!(diffuse.iterations() <= 9 * increments / 2, "{}", diffuse.iterations());
}
