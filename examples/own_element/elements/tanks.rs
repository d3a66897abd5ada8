//! Outside mechanics: one implicit step of four coupled tanks, whose levels are the root of four equations, with all sensitivities.

use diffuse_contact_codegen::expr::{Expr, Vec2, Vector};
use diffuse_contact_codegen::{ElementModel, Limits};

/// Two pumps fill four tanks, two of which run into the other two (Johansson's process). A step dt of implicit Euler,
/// A_i (h_i − h_i before) / dt = Σ inflows − a_i √(2 g h_i), and what a controller minimises: squares of the levels' distance from
/// their targets.
pub fn four_tanks<'g>(m: &ElementModel<'g>) {
    m.title("A step of four coupled tanks.");
    let (before, pumps): (Vector<'g, 4>, Vec2<'g>) = (m.variable("before"), m.variable("pumps"));
    let (area, outlet, target): (Vector<'g, 4>, Vector<'g, 4>, Vector<'g, 4>) =
        (m.parameter("area"), m.parameter("outlet"), m.parameter("target"));
    let (split, dt): (Vec2<'g>, Expr<'g>) = (m.parameter("split"), m.parameter("dt"));

    // Levels change by a few of their own size at most.
    let limits = Limits { longest_step: 10.0, evaluations: 60 };
    let levels = m.root_from("level", before, limits, |h| {
        let flow = Vector::<4>::from_fn(|k| outlet[k] * (2.0 * 9.81 * h[k]).sqrt());
        let [p, q] = pumps.0;
        let inflow =
            [split[0] * p + flow[2], split[1] * q + flow[3], (1.0 - split[1]) * q, (1.0 - split[0]) * p];
        Vector::from_fn(|k| area[k] * (h[k] - before[k]) - dt * (inflow[k] - flow[k]))
    });
    let off = levels.unknowns - target;
    m.energy(0.5 * off.dot(off));
    m.residual("levels", levels.unknowns);
    m.value("levels_residual", levels.residual);
    m.describe(
        "before",
        "Levels before the step, m: two lower tanks, then the upper ones that run into them.",
    );
    m.describe("split", "Parts of the pumps' flows that go to the lower tanks.");
    m.describe("levels_residual", "Below 1e-12, or there are no such levels.");
}
