//! External work is stored and dissipated, to the order of the integration over time.

use diffuse_contact_solver::contact::{Integration, SlaveState};
use diffuse_contact_solver::deck::{Contact, Deck};
use diffuse_contact_solver::statics::TimeSettings;
use diffuse_contact_solver::verification::Snapshot;

use super::{dragged, run};

const PENALTY: f64 = 2e4;

/// The end of an increment.
struct Balance {
    /// Of each support, where it is and what it exerts.
    supports: Vec<([f64; 3], [f64; 3])>,
    /// Of the solid and of both penalties.
    stored: f64,
    dissipated: f64,
    /// Contacts that stick and that slide.
    states: [usize; 2],
}

/// ½ p |g| and ½ t²/ε_T: the energy of both penalties.
fn of_penalties(slave: &SlaveState) -> f64 {
    let friction: f64 = slave.friction.iter().map(|f| f * f).sum();
    let normal = slave.gap.map_or(0.0, |gap| -slave.force * gap);
    0.5 * (normal + friction / (PENALTY * slave.area))
}

fn balance(snapshot: &Snapshot<'_>) -> Balance {
    let Snapshot { record, state, problem } = *snapshot;
    let groups = problem.supports().groups().iter();
    let moved = groups.map(|group| group.displacement(record.time, problem.start_positions()));
    let solid = problem.solid().stored_energy(&state.positions, &problem.solid().states()).unwrap();
    let loaded = snapshot.slaves().filter(|slave| slave.force > 0.0);
    let friction = record.friction[0].unwrap();
    Balance {
        supports: moved.zip(record.reactions.iter().copied()).collect(),
        stored: solid + loaded.map(|slave| of_penalties(&slave)).sum::<f64>(),
        dissipated: problem.contacts().interactions()[0].dissipated(),
        states: [friction.stuck, friction.sliding],
    }
}

/// Work, stored energy, dissipated energy, and what is left of the work, at the end. The work is that of the reactions by trapezia.
fn energies(deck: &Deck, increments: usize) -> [f64; 4] {
    let mut deck = deck.clone();
    deck.time = TimeSettings::fixed(1.0, 1.0 / increments as f64);
    deck.newton.tolerance = 1e-10;
    let run = run(&deck, balance);
    assert_eq!((run.cutbacks, run.measures.len()), (0, increments));
    // Most stick at first, all slide at the end.
    let [sticks, slides] = [increments / 5, increments - 1].map(|k| run.measures[k].states);
    assert!(sticks[0] > sticks[1] && slides[0] == 0 && slides[1] > 0, "{sticks:?} {slides:?}");
    let mut work = 0.0;
    let mut before = vec![([0.0; 3], [0.0; 3]); run.measures[0].supports.len()];
    for balance in &run.measures {
        for ((from, first), (to, last)) in before.iter().zip(&balance.supports) {
            work +=
                (0..3).map(|axis| 0.5 * (first[axis] + last[axis]) * (to[axis] - from[axis])).sum::<f64>();
        }
        before.clone_from(&balance.supports);
    }
    let Balance { stored, dissipated, .. } = run.measures.last().unwrap();
    [work, *stored, *dissipated, work - stored - dissipated]
}

/// A block pressed on a strip and pushed along it until all of it slides.
fn pressed_and_pushed(contact: Contact, integration: Integration) -> Deck {
    let mut deck = Deck { contact, ..dragged(1, 0.3, PENALTY) };
    let interface = &mut deck.interfaces[0];
    interface.integration = integration;
    interface.surface.areas = true;
    deck
}

/// What is left over the work, with Δt, Δt/2 and Δt/4.
fn parts(contact: Contact, integration: Integration) -> [f64; 3] {
    let deck = pressed_and_pushed(contact, integration);
    let parts = [20, 40, 80].map(|increments| {
        let [work, stored, dissipated, rest] = energies(&deck, increments);
        println!("work {work}, stored {stored}, dissipated {dissipated}, left {rest}");
        assert!(dissipated > 0.3 * work && stored > 0.3 * work);
        (rest / work).abs()
    });
    println!("{contact:?} {integration:?}: left over work {parts:?}");
    parts
}

/// The remainder falls by the order of the integration over time: 1, as tractions are those of the increments' ends.
pub fn assert_first_order(contact: Contact) {
    let [coarse, middle, fine] = parts(contact, Integration::Nodes);
    assert!(middle < 0.65 * coarse && fine < 0.65 * middle, "{coarse} {middle} {fine}");
    assert!(fine < 0.28 * coarse && fine < 3e-4, "{coarse} {fine}");
}

#[test]
fn the_work_is_stored_and_dissipated() {
    assert_first_order(Contact::NodeToFacet);
}

/// Forces over faces have no potential: what is left does not fall to nothing.
#[test]
fn the_work_over_faces_is_stored_and_dissipated_but_for_a_little() {
    let parts = parts(Contact::Diffuse, Integration::FACES);
    assert!(parts.iter().all(|&part| part < 6e-4), "{parts:?}");
}
