//! Two cylinders pressed together and pushed: how far the middle sticks, and the traction, against Cattaneo and Mindlin.

use diffuse_contact_solver::deck::Contact;
use diffuse_contact_solver::solve::SolveError;
use diffuse_contact_solver::verification::{LineContact, PartialSlip, Trace, TractionProfile};

use super::plot::chart;
use super::{Decks, Findings, Way, divide, row};
use crate::study::markdown::Table;
use crate::study::plot::{COLOURS, Curve, Mark};

/// Cells of the cores of the lower and the upper cylinder, and layers around them; whether they take minutes. The second one is the deck's.
const MESHES: [([usize; 3], bool); 3] = [([20, 18, 12], false), ([40, 36, 20], false), ([60, 54, 24], true)];
/// Length of the cylinders, one over the sum of their curvatures, E* of both.
const LENGTH: f64 = 0.5;
const RADIUS: f64 = 4.0;
const MODULUS: f64 = 200.0 / (2.0 * (1.0 - 0.3 * 0.3));
const COEFFICIENT: f64 = 0.2;

/// At the end: the closed form at the forces that the run found, and tractions.
type Pushed = (PartialSlip, TractionProfile);

pub fn study(decks: &Decks) -> Result<Findings, SolveError> {
    let columns = "element | cells of the cores, layers | nodes across | Q/(μ P) | c/a, closed form | \
                   c/a by the tractions | nodes stick to, slide from, x/a | traction at nodes, rms | \
                   means over faces, rms | iterations | cut-backs";
    let mut table = Table::new("Cattaneo and Mindlin: cylinders that stick in the middle", columns);
    let mut curves = Vec::new();
    for way in [Way::FACETS_OVER_FACES, Way::DIFFUSE_OVER_FACES] {
        for (cells, fine) in MESHES.into_iter().filter(|mesh| mesh.1 == decks.fine) {
            let [lower, upper, layers] = cells;
            let mut deck = decks.by(way)?;
            divide(&mut deck, "lower", &[lower, layers, 1]);
            divide(&mut deck, "upper", &[upper, layers, 1]);
            let run = decks.trace(&deck, |snapshot| {
                let [push, _, force] = snapshot.contact_force().map(|sum| sum.abs() / LENGTH);
                let line = LineContact { force, radius: RADIUS, modulus: MODULUS };
                let exact = PartialSlip { line, coefficient: COEFFICIENT, push };
                Ok((exact, TractionProfile::of(snapshot, 0)))
            })?;
            if let (Ok(run), false, Contact::Diffuse) = (&run, fine, way.element)
                && cells == MESHES[1].0
            {
                curves = charted(run, way);
            }
            let name = format!("{lower} and {upper}, {layers}");
            row(&mut table, &[way.name(), &name], run.map(|run| figures(&run)));
        }
    }
    let title = "Cylinders that stick in the middle: traction over μ p₀";
    let charts =
        if curves.is_empty() { vec![] } else { vec![chart(title, ["x / a", "q / (μ p₀)"], curves)] };
    Ok(Findings { table, charts })
}

fn figures(run: &Trace<Pushed>) -> [String; 9] {
    let Some((exact, profile)) = run.measures.last() else { return Default::default() };
    let a = exact.line.half_width();
    let [sticks, slides] = profile.border();
    [
        // There is one layer of cells along the cylinders.
        (profile.nodes.len() / 2).to_string(),
        format!("{:.4}", exact.push / (COEFFICIENT * exact.line.force)),
        format!("{:.4}", exact.half_width() / a),
        format!("{:.4}", profile.half_width(exact) / a),
        format!("{:.3}, {:.3}", sticks / a, slides / a),
        format!("{:.2} %", 100.0 * profile.deviation(exact)),
        format!("{:.2} %", 100.0 * profile.mean_deviation(exact)),
        run.iterations.to_string(),
        run.cutbacks.to_string(),
    ]
}

/// Tractions of the nodes, and the closed form.
fn charted(run: &Trace<Pushed>, way: Way) -> Vec<Curve> {
    let Some((exact, profile)) = run.measures.last() else { return Vec::new() };
    let (a, unit) = (exact.line.half_width(), COEFFICIENT * exact.line.peak_pressure());
    let exact = (-500..=500).map(|k| f64::from(k) / 500.0).map(|x| (x, exact.traction(a * x) / unit));
    let nodes = profile.nodes.iter().map(|node| (node.place / a, node.traction / unit));
    let nodes = Curve::new(way.name(), way.colour(), Mark::Dots, nodes);
    vec![nodes, Curve::new("closed form", COLOURS.other, Mark::Line, exact)]
}
