//! Two blocks under a uniform pressure: what of it arrives.

use diffuse_contact::Weight;
use diffuse_contact_solver::deck::Contact;
use diffuse_contact_solver::solve::SolveError;
use diffuse_contact_solver::verification::{Trace, Uniformity};

use super::{Decks, Findings, Way, row};
use crate::study::markdown::Table;

/// Axis and size of the deck's pressure.
const AXIS: usize = 2;

/// The element, what it is integrated over, and the weight of its fit, which only the diffuse one has.
const SURFACES: [(Way, Weight); 8] = [
    (Way::FACETS, Weight::Cubic),
    (Way::DIFFUSE, Weight::Cubic),
    (Way::DIFFUSE, Weight::CubicInterpolating),
    (Way::DIFFUSE, Weight::WendlandC2),
    (Way::FACETS_OVER_FACES, Weight::Cubic),
    (Way::DIFFUSE_OVER_FACES, Weight::Cubic),
    (Way::DIFFUSE_OVER_FACES, Weight::CubicInterpolating),
    (Way::DIFFUSE_OVER_FACES, Weight::WendlandC2),
];
/// Of Newton's iteration: what remains is rounding.
const TOLERANCE: f64 = 1e-12;

/// Which side is slave.
const PASSES: [(&str, bool, bool); 3] = [
    ("one pass, coarse slave", false, false),
    ("one pass, fine slave", true, false),
    ("two-pass", false, true),
];

pub fn study(decks: &Decks) -> Result<Findings, SolveError> {
    let heading = "Patch test: deviations from the uniform stress −p, relative to p";
    let columns = "element | weight | passes | forces by area | largest, σ_zz | rms, σ_zz | \
                   largest of other components | largest, contact pressure | iterations";
    let mut table = Table::new(heading, columns);
    for (way, weight) in SURFACES {
        for (passes, exchange, two_pass) in PASSES {
            for areas in [true, false] {
                if !areas && (way.over_faces || weight != Weight::Cubic) {
                    continue;
                }
                let mut deck = decks.by(way)?;
                deck.newton.tolerance = TOLERANCE;
                let pressure = deck.pressures.first().map_or(1.0, |pressure| pressure.value);
                for interface in &mut deck.interfaces {
                    interface.surface.element = interface.surface.element.with_weight(weight);
                    interface.exchange = exchange;
                    interface.two_pass = two_pass;
                    if !areas {
                        // The mean area of a slave of the coarse side is 5 mm².
                        interface.surface.areas = false;
                        interface.penalty = interface.penalty.map(|penalty| 5.0 * penalty);
                    }
                }
                let run = decks.trace(&deck, |snapshot| Uniformity::of(snapshot, AXIS, pressure))?;
                let figures = run.map(|run| figures(&run, areas && !two_pass));
                let weight = if way.element == Contact::Diffuse { weight.name() } else { "–" };
                let by_area = if areas { "yes" } else { "no" };
                row(&mut table, &[way.name(), weight, passes, by_area], figures);
            }
        }
    }
    Ok(Findings { table, charts: Vec::new() })
}

/// The cells of a run, with what the contact pressure is off where it can be told.
fn figures(run: &Trace<Uniformity>, has_pressure: bool) -> [String; 5] {
    let last = run.measures.last();
    let of = |of: fn(&Uniformity) -> f64| last.map_or_else(String::new, |last| format!("{:.1e}", of(last)));
    let contact = if has_pressure { of(|u| u.contact) } else { "–".to_owned() };
    [of(|u| u.stress), of(|u| u.stress_rms), of(|u| u.other_stress), contact, run.iterations.to_string()]
}
