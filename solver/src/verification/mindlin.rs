//! Two cylinders pressed together and pushed tangentially, less than it takes to slide: Cattaneo and Mindlin, and the tractions that a run
//! finds.

use diffuse_contact::friction::FrictionState;

use super::{LineContact, Snapshot};

/// Places of the same column of nodes differ by less, over their size.
const SAME_PLACE: f64 = 1e-9;

/// A line contact whose middle sticks. The bodies are of one material, so that pressing them causes no traction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartialSlip {
    /// The contact without friction.
    pub line: LineContact,
    /// Coefficient of friction μ.
    pub coefficient: f64,
    /// Tangential force Q < μ P per length of the cylinder, force per length.
    pub push: f64,
}

impl PartialSlip {
    /// c = a √(1 − Q/(μ P)), length.
    pub fn half_width(&self) -> f64 {
        self.line.half_width() * (1.0 - self.push / (self.coefficient * self.line.force)).sqrt()
    }

    /// q = μ p₀/a (√(a² − x²) − √(c² − x²)) at a distance from the middle, force per area; roots of negative numbers are 0.
    pub fn traction(&self, x: f64) -> f64 {
        let (a, c) = (self.line.half_width(), self.half_width());
        let arc = |half: f64| (half * half - x * x).max(0.0).sqrt();
        self.coefficient * self.line.peak_pressure() / a * (arc(a) - arc(c))
    }

    /// The traction in the mean over the hat that is 1 at the middle one of three ascending places and 0 at the others, force per area.
    pub fn mean_traction(&self, [left, place, right]: [f64; 3]) -> f64 {
        let (a, c) = (self.line.half_width(), self.half_width());
        let sums = |half: f64| {
            // Of √(half² − x²) and x √(half² − x²) between two places.
            let primitives = |x: f64| {
                let x = x.clamp(-half, half);
                let arc = (half * half - x * x).max(0.0).sqrt();
                let angle = if half > 0.0 { (x / half).asin() } else { 0.0 };
                [0.5 * (x * arc + half * half * angle), -arc * arc * arc / 3.0]
            };
            let [l, m, r] = [left, place, right].map(primitives);
            let rising = (m[1] - l[1] - left * (m[0] - l[0])) / (place - left);
            let falling = (right * (r[0] - m[0]) - (r[1] - m[1])) / (right - place);
            rising + falling
        };
        let peak = self.coefficient * self.line.peak_pressure() / a;
        peak * (sums(a) - sums(c)) / (0.5 * (right - left))
    }
}

/// A slave node that carries pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodalTraction {
    /// Its place along the push at the start, length.
    pub place: f64,
    /// The places next to its own on either side, of slaves that carry pressure or not; its own where there are none.
    pub beside: [f64; 2],
    /// Its area, length².
    pub area: f64,
    /// Pressure, force per area.
    pub pressure: f64,
    /// Friction against the push over the area, force per area.
    pub traction: f64,
    /// Whether it sticks.
    pub sticks: bool,
}

/// The tractions of a contact across its middle at x = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct TractionProfile {
    /// All slaves that carry pressure, by place.
    pub nodes: Vec<NodalTraction>,
}

impl TractionProfile {
    /// The tractions along an axis, 0 to 2, of a run with one interface.
    pub fn of(snapshot: &Snapshot<'_>, axis: usize) -> Self {
        let positions = snapshot.problem.start_positions();
        let interactions = snapshot.problem.contacts().interactions();
        let forces =
            interactions.iter().map(|interaction| interaction.nodal_forces(positions.len()).friction);
        let friction =
            |node: usize, all: &[Vec<[f64; 3]>]| all.iter().map(|own| own[node][axis]).sum::<f64>();
        let forces: Vec<Vec<[f64; 3]>> = forces.collect();
        let mut places: Vec<f64> = snapshot.slaves().map(|slave| positions[slave.node][axis]).collect();
        places.sort_by(f64::total_cmp);
        let beside = |place: f64| {
            let is_another = |other: &f64| (other - place).abs() > SAME_PLACE * place.abs().max(1.0);
            let (below, above) = places.split_at(places.partition_point(|&other| other < place));
            let below = below.iter().copied().rfind(is_another);
            [below, above.iter().copied().find(is_another)].map(|next| next.unwrap_or(place))
        };
        let mut nodes: Vec<NodalTraction> = snapshot
            .slaves()
            .filter(|slave| slave.force > 0.0)
            .map(|slave| NodalTraction {
                place: positions[slave.node][axis],
                beside: beside(positions[slave.node][axis]),
                area: slave.area,
                pressure: slave.force / slave.area,
                traction: -friction(slave.node, &forces) / slave.area,
                sticks: slave.friction_state == FrictionState::Stick,
            })
            .collect();
        nodes.sort_by(|one, other| one.place.total_cmp(&other.place));
        Self { nodes }
    }

    /// Deviation from the closed form at the nodes over it, in the mean square. A nodal traction is a mean over the faces around the node:
    /// beside the ends of contact and of what sticks, where the closed form falls like a root, the mean is another value than that at the
    /// node by the root of the faces' size, on a part as wide as they are. So this falls in proportion to the size at best.
    pub fn deviation(&self, exact: &PartialSlip) -> f64 {
        self.deviation_from(|node| exact.traction(node.place))
    }

    /// Deviation from the closed form's mean over the faces around each node, which is what nodal tractions stand for.
    pub fn mean_deviation(&self, exact: &PartialSlip) -> f64 {
        self.deviation_from(|node| {
            let [left, right] = node.beside;
            exact.mean_traction([left, node.place, right])
        })
    }

    fn deviation_from(&self, exact: impl Fn(&NodalTraction) -> f64) -> f64 {
        let sum = |term: &dyn Fn(&NodalTraction) -> f64| -> f64 {
            self.nodes.iter().map(|node| node.area * term(node).powi(2)).sum()
        };
        (sum(&|node| node.traction - exact(node)) / sum(&exact)).sqrt()
    }

    /// The largest place that sticks and the smallest that slides, length.
    pub fn border(&self) -> [f64; 2] {
        let places = |sticks: bool| {
            self.nodes.iter().filter(move |node| node.sticks == sticks).map(|node| node.place.abs())
        };
        [places(true).fold(0.0, f64::max), places(false).fold(f64::INFINITY, f64::min)]
    }

    /// c by the tractions of the nodes within 0.9 of the closed form's c: where contacts stick, 1 − q/(μ p) = √(c² − x²)/√(a² − x²).
    /// NaN without such nodes.
    pub fn half_width(&self, exact: &PartialSlip) -> f64 {
        let (a, c) = (exact.line.half_width(), exact.half_width());
        let squares = self.nodes.iter().filter(|node| node.place.abs() < 0.9 * c).map(|node| {
            let rest = 1.0 - node.traction / (exact.coefficient * node.pressure);
            rest * rest * (a * a - node.place * node.place) + node.place * node.place
        });
        let (count, sum) = squares.fold((0.0, 0.0), |(count, sum), square| (count + 1.0, sum + square));
        (sum / count).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXACT: PartialSlip = PartialSlip {
        line: LineContact { force: 10.0, radius: 4.0, modulus: 200.0 / 1.82 },
        coefficient: 0.2,
        push: 0.936,
    };

    /// Figures of NAFEMS' benchmark of this contact; tractions add up to the push.
    #[test]
    fn tractions_balance_the_push() {
        let (a, c) = (EXACT.line.half_width(), EXACT.half_width());
        assert!((a - 0.6808).abs() < 1e-4 && (c / a - 0.7294).abs() < 1e-4, "{a} {c}");
        let count = 100_000;
        let step = 2.0 * a / f64::from(count);
        let sum: f64 = (0..count).map(|k| EXACT.traction((f64::from(k) + 0.5) * step - a) * step).sum();
        assert!((sum / EXACT.push - 1.0).abs() < 1e-6, "{sum}");
    }

    #[test]
    fn the_closed_form_is_found_again() {
        let a = EXACT.line.half_width();
        let pressure = |x: f64| EXACT.line.peak_pressure() * (1.0 - x * x / (a * a)).sqrt();
        let node = |k: i32| {
            let place = a * f64::from(k) / 20.0;
            NodalTraction {
                place,
                beside: [place - 0.05 * a, place + 0.05 * a],
                area: 0.1,
                pressure: pressure(place),
                traction: EXACT.traction(place),
                sticks: place.abs() < EXACT.half_width(),
            }
        };
        let profile = TractionProfile { nodes: (-19..20).map(node).collect() };
        assert!(profile.deviation(&EXACT) < 1e-14);
        // Means over 40 faces are other values, beside the ends most of all, and found again as well.
        assert!((0.01..0.1).contains(&profile.mean_deviation(&EXACT)));
        let mean = |node: &NodalTraction| {
            let [left, right] = node.beside;
            let count = 10_000;
            let at = |k: i32| {
                let s = (f64::from(k) + 0.5) / f64::from(count);
                let weights = [s * (node.place - left), (1.0 - s) * (right - node.place)];
                weights[0] * EXACT.traction(left + s * (node.place - left))
                    + weights[1] * EXACT.traction(node.place + s * (right - node.place))
            };
            (0..count).map(at).sum::<f64>() / f64::from(count) / (0.5 * (right - left))
        };
        let means = profile.nodes.iter().map(|node| NodalTraction { traction: mean(node), ..*node });
        let means = TractionProfile { nodes: means.collect() };
        assert!(means.mean_deviation(&EXACT) < 1e-5, "{}", means.mean_deviation(&EXACT));
        assert!((profile.half_width(&EXACT) / EXACT.half_width() - 1.0).abs() < 1e-12);
        let [sticks, slides] = profile.border();
        assert!(sticks < EXACT.half_width() && slides > EXACT.half_width());
        assert!(TractionProfile { nodes: Vec::new() }.half_width(&EXACT).is_nan());
    }
}
