//! Friction in decks: closed forms.

use std::path::Path;

use diffuse_contact::FrictionState;
use diffuse_contact_solver::deck::{Contact, Deck};
use diffuse_contact_solver::verification::{Snapshot, Trace, trace};

fn deck(name: &str) -> Deck {
    Deck::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(name)).unwrap()
}

fn run<T>(deck: &Deck, mut measure: impl FnMut(&Snapshot<'_>) -> T) -> Trace<T> {
    trace(deck, Path::new(""), 1, |snapshot| Ok(measure(snapshot))).unwrap()
}

/// F/G = (tan α + μ)/(1 − μ tan α).
#[test]
fn a_block_slides_up_a_plane() {
    let deck = deck("inclined_block.toml");
    let run = run(&deck, |snapshot| {
        let all_slide = snapshot.slaves().all(|slave| slave.friction_state == FrictionState::Slip);
        (all_slide, -snapshot.contact_force()[0] / snapshot.contact_force()[2])
    });
    let &(all_slide, ratio) = run.measures.last().unwrap();
    assert!(all_slide);
    let exact = (0.1 + 0.3) / (1.0 - 0.3 * 0.1);
    assert!((ratio / exact - 1.0).abs() < 1e-8, "{ratio} {exact}");
    // With two passes each has half of the forces. The block's own face, a master now, is not quite flat.
    let mut both = deck.clone();
    both.interfaces[0].two_pass = true;
    let both = run_ratio(&both);
    assert!((both / exact - 1.0).abs() < 3e-4, "{both} {exact}");
    // Without friction the push has to hold the slope's part of the weight only.
    let mut deck = deck;
    deck.interfaces[0].friction = None;
    assert!((run_ratio(&deck) / 0.1 - 1.0).abs() < 1e-6);
}

/// Horizontal over vertical contact force at the end.
fn run_ratio(deck: &Deck) -> f64 {
    let run = run(deck, |snapshot| -snapshot.contact_force()[0] / snapshot.contact_force()[2]);
    *run.measures.last().unwrap()
}

/// T2/T1 = exp(μ θ r_i/r_m), on facets of 10°.
#[test]
fn a_belt_slides_over_a_drum() {
    let run = run(&deck("belt.toml"), |snapshot| snapshot.contact_force());
    let &[pulled, held, _] = run.measures.last().unwrap();
    let exact = (0.3 * std::f64::consts::FRAC_PI_2 * 9.9999 / 10.0249).exp();
    let ratio = pulled / held;
    println!("{ratio} for {exact}");
    assert!((ratio / exact - 1.0).abs() < 0.005, "{ratio} {exact}");
}

const SHAFT: &str = r#"
[materials.bush]
young = 1000.0
poisson = 0.3

[parts.bush]
shape = "pipe"
inner_radius = 9.99
outer_radius = 14.0
length = 2.0
divisions = [60, 2, 2]
material = "bush"

[parts.shaft]
shape = "rigid-cylinder"
radius = 10.0
length = 4.0
divisions = [40, 6]
translate = [0.0, 0.0, -1.0]

[[boundary]]
nodes = "bush.outer"
fix = ["x", "y", "z"]

[[boundary]]
nodes = "shaft"
rotate = { axis = [0.0, 0.0, 1.0], point = [0.0, 0.0, 0.0], degrees = 12.0 }

[[interface]]
name = "fit"
master = "shaft"
slave = "bush.inner"
penalty = 1e4
areas = true
friction = 0.2

[time]
increment = 0.05
fixed = true
"#;

/// Torque over μ N r, with 40 facets around, over more than a facet.
#[test]
fn a_shaft_turns_in_a_bush() {
    let run = run(&Deck::parse(SHAFT).unwrap(), |snapshot| {
        let pressed: f64 = snapshot.slaves().map(|slave| slave.force).sum();
        let torque = snapshot.moment("shaft", [0.0; 3]).unwrap()[2];
        let slides = snapshot.slaves().all(|slave| slave.friction_state == FrictionState::Slip);
        (slides, torque / (0.2 * pressed * 10.0))
    });
    let sliding: Vec<f64> =
        run.measures.iter().filter(|(slides, _)| *slides).map(|(_, ratio)| *ratio).collect();
    assert!(sliding.len() >= 15, "{}", sliding.len());
    let largest = sliding.iter().copied().fold(f64::MIN, f64::max);
    let smallest = sliding.iter().copied().fold(f64::MAX, f64::min);
    println!("torque from {smallest} to {largest} of μ N r");
    assert!((largest - 1.0).abs() < 0.01 && (smallest - 1.0).abs() < 0.01, "{smallest} {largest}");
    assert!(largest - smallest < 0.005, "{smallest} {largest}");
}

#[test]
fn a_facet_has_no_friction_yet_and_says_so() {
    let mut deck = deck("inclined_block.toml");
    deck.contact = Contact::NodeToFacet;
    let refused = trace(&deck, Path::new(""), 1, |_| Ok(())).unwrap_err();
    assert!(refused.to_string().contains("friction needs the diffuse element"), "{refused}");
}
