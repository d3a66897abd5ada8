//! One slave node, swept once around the path.

use diffuse_contact::interface::{ContactElement, ContactInterface, InterfaceOptions, Outcome};
use diffuse_contact::neighbourhood::NeighbourRule;
use diffuse_contact::surface::MasterSurface;
use diffuse_contact::{FrameDerivative, Mode, Point, Weight};

use super::scene::{self, Cells};
use crate::study::accuracy::angle;
use crate::study::patch::Patch;
use crate::study::{StudyError, dot, extremes, norm};
use diffuse_contact_cli::contact_options::{RULES, diffuse, rule_name};

/// What halving a part of a step may change of its work over the penalty, and how often it is halved at most.
const WORK_TOLERANCE: f64 = 1e-11;
const REFINEMENTS: u32 = 24;

/// The slave at one place of the path.
#[derive(Clone, Copy, Debug)]
pub struct State {
    /// Position.
    pub position: Point,
    /// Gap.
    pub gap: f64,
    /// Force on the slave over the penalty, −g N of its three coordinates; zero if it does not penetrate.
    pub force: Point,
    /// Unit normal.
    pub normal: Point,
}

/// What was met along the path.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// The element.
    pub element: ContactElement,
    /// State at every step, after its refresh.
    pub states: Vec<State>,
    /// Refreshes that gave the slave other masters.
    pub changes: usize,
    /// Steps at whose end the pairing of their beginning gave no contact: they take no part in what follows.
    pub lost: usize,
    /// Largest jump of the gap at a refresh.
    pub gap_jump: f64,
    /// Largest turn of the normal at a refresh, degrees.
    pub kink_degrees: f64,
    /// Work of the force on the slave around the loop over the penalty, by the trapezoidal rule with the pairing of each
    /// step's beginning. Jumps of the energy at refreshes are no work: the force never sees them. Where nothing jumps, steps are
    /// divided until the work no longer changes.
    pub work: f64,
    /// ∮ |F| |dx| over the penalty.
    pub effort: f64,
    /// Sum of the energy's jumps at refreshes over the penalty, ½ g² after less ½ g² before.
    pub energy_jumps: f64,
}

/// The rules as `surface` has them, and the hulls' radius from two layers on.
fn rules() -> impl Iterator<Item = NeighbourRule> {
    RULES.into_iter().chain([NeighbourRule::hull_radius(Some(2))])
}

/// All elements: the facets, then each rule with each weight.
pub fn elements() -> Vec<ContactElement> {
    let smooth = Weight::ALL
        .into_iter()
        .flat_map(|weight| rules().map(move |rule| diffuse(weight, FrameDerivative::CoMoving, rule)));
    std::iter::once(ContactElement::NodeToFacet).chain(smooth).collect()
}

/// Rule, or facets, and weight of an element.
pub fn names(element: &ContactElement) -> [String; 2] {
    match element {
        ContactElement::Diffuse { weight, search, .. } => {
            let layers = match search.rule {
                NeighbourRule::HullRadius { layers: Some(layers), .. } => {
                    format!(" from {layers} layers on")
                }
                _ => String::new(),
            };
            [rule_name(search.rule).to_owned() + &layers, weight.name().to_owned()]
        }
        ContactElement::NodeToFacet => ["facets", "–"].map(String::from),
    }
}

impl Curve {
    /// Smallest and largest gap.
    pub fn gaps(&self) -> [f64; 2] {
        extremes(self.states.iter().map(|state| state.gap))
    }
}

/// Sweeps the slave around the path in so many steps, with a refresh at each, over a mesh of such cells.
pub fn sweep(
    element: ContactElement,
    cells: Cells,
    steps: u32,
    mut step_done: impl FnMut(),
) -> Result<Curve, StudyError> {
    let mut slave = Slave::new(element, cells)?;
    let turn = |step: u32| f64::from(step) / f64::from(steps);
    slave.refresh_at(scene::path(0.0))?;
    let mut curve = Curve { element, ..Curve::default() };
    let mut from = slave.state()?;
    for step in 1..=steps {
        curve.states.push(from);
        let position = scene::path(turn(step));
        slave.move_to(position)?;
        let end = slave.state();
        if let Ok(to) = &end {
            let along: Point = std::array::from_fn(|axis| to.position[axis] - from.position[axis]);
            let rough = 0.5 * (dot(from.force, along) + dot(to.force, along));
            curve.work += if slave.is_continuous() {
                slave.work([turn(step - 1), turn(step)], [&from, to], rough, REFINEMENTS)?
            } else {
                rough
            };
            curve.effort += 0.5 * (norm(from.force) + norm(to.force)) * norm(along);
        }
        let is_changed = slave.refresh_at(position)?;
        from = slave.state()?;
        curve.changes += usize::from(is_changed);
        match end {
            Ok(to) => {
                curve.gap_jump = curve.gap_jump.max((from.gap - to.gap).abs());
                curve.kink_degrees = curve.kink_degrees.max(angle(to.normal, from.normal));
                curve.energy_jumps += energy(&from) - energy(&to);
            }
            Err(StudyError::NoContact { .. }) => curve.lost += 1,
            Err(error) => return Err(error),
        }
        step_done();
    }
    Ok(curve)
}

/// ½ g² in penetration.
fn energy(state: &State) -> f64 {
    0.5 * state.gap.min(0.0).powi(2)
}

/// The interface of a single slave node.
struct Slave {
    element: ContactElement,
    positions: Vec<Point>,
    interface: ContactInterface,
}

impl Slave {
    fn new(element: ContactElement, cells: Cells) -> Result<Self, StudyError> {
        let Patch { mut positions, facets } = cells.mesh();
        let master = MasterSurface::new(&positions, facets)?;
        let slave = positions.len();
        positions.push(scene::path(0.0));
        let options = InterfaceOptions::default().with_element(element);
        let interface = ContactInterface::new(master, vec![slave], &[], &positions, options)?;
        Ok(Self { element, positions, interface })
    }

    /// With domains the list follows a slave that leaves its skin.
    fn move_to(&mut self, position: Point) -> Result<(), StudyError> {
        if let Some(last) = self.positions.last_mut() {
            *last = position;
        }
        self.interface.follow(&self.positions)?;
        Ok(())
    }

    /// Whether the slave has other masters now.
    fn refresh_at(&mut self, position: Point) -> Result<bool, StudyError> {
        self.move_to(position)?;
        let report = self.interface.renew_pairing(&self.positions)?;
        Ok(report.changed > 0)
    }

    /// Whether the force is continuous along the path, whatever the pairing.
    fn is_continuous(&self) -> bool {
        matches!(self.element, ContactElement::Diffuse { search, .. } if search.rule == NeighbourRule::Domains)
    }

    /// The work of the force between two places of the path, by the trapezoidal rule on ever shorter parts, the last two
    /// extrapolated. `rough`: that of the rule on the whole.
    fn work(
        &mut self,
        [from, to]: [f64; 2],
        [start, end]: [&State; 2],
        rough: f64,
        refinements: u32,
    ) -> Result<f64, StudyError> {
        let halfway = 0.5 * (from + to);
        self.move_to(scene::path(halfway))?;
        let middle = self.state()?;
        let trapezoid = |one: &State, other: &State| {
            let along: Point = std::array::from_fn(|axis| other.position[axis] - one.position[axis]);
            0.5 * (dot(one.force, along) + dot(other.force, along))
        };
        let [first, second] = [trapezoid(start, &middle), trapezoid(&middle, end)];
        let change = first + second - rough;
        if change.abs() <= WORK_TOLERANCE || refinements == 0 {
            return Ok(first + second + change / 3.0);
        }
        let before = self.work([from, halfway], [start, &middle], first, refinements - 1)?;
        Ok(before + self.work([halfway, to], [&middle, end], second, refinements - 1)?)
    }

    fn state(&mut self) -> Result<State, StudyError> {
        let contact = self.interface.evaluate(Mode::Gradient)?.get(0);
        if let Outcome::None(reason) = contact.outcome {
            let case = names(&self.element).join(", ");
            return Err(StudyError::NoContact { case, slave: contact.slave, reason });
        }
        let gap = contact.point.gap;
        // The slave's own rows come first.
        let force = std::array::from_fn(|axis| -gap.min(0.0) * contact.gradient[axis]);
        Ok(State { position: self.positions[contact.slave], gap, force, normal: contact.point.normal })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use super::*;

    const REGULAR: Cells = Cells { refine: 1, moved: 0.0 };

    /// On the smooth surface with domains, whose work takes the longest.
    static SMOOTH: LazyLock<Curve> =
        LazyLock::new(|| sweep(cubic(NeighbourRule::Domains), REGULAR, 600, || ()).unwrap());

    fn cubic(rule: NeighbourRule) -> ContactElement {
        diffuse(Weight::Cubic, FrameDerivative::CoMoving, rule)
    }

    /// The force is the derivative of an energy as long as the pairing stays, so all work comes from the refreshes.
    #[test]
    fn the_work_is_what_the_energy_jumps_by_at_refreshes() {
        let elements = [RULES[1], RULES[3], NeighbourRule::hull_radius(Some(2))].map(cubic);
        for element in elements.into_iter().chain([ContactElement::NodeToFacet]) {
            let curve = sweep(element, REGULAR, 2400, || ()).unwrap();
            assert!(curve.changes > 20, "{element:?}");
            assert_eq!(curve.lost, 0, "{element:?}");
            // The loop ends with the pairing it began with.
            let difference = (curve.work - curve.energy_jumps).abs();
            assert!(difference < 1e-5 * curve.effort, "{element:?} {} {}", curve.work, curve.energy_jumps);
            assert!(curve.gap_jump > 0.0);
        }
    }

    fn assert_smooth(curve: &Curve) {
        let Curve { changes, gap_jump, work, effort, .. } = curve;
        assert!(*changes > 20 && *gap_jump < 1e-14, "{changes} {gap_jump:e}");
        assert!(work.abs() < 1e-9 * effort, "{work:e} of {effort}");
    }

    #[test]
    fn with_domains_neither_gap_nor_energy_jumps() {
        assert_smooth(&SMOOTH);
    }

    #[test]
    fn neither_do_they_by_any_weight_where_nodes_are_moved() {
        for weight in Weight::ALL {
            let element = diffuse(weight, FrameDerivative::CoMoving, NeighbourRule::Domains);
            assert_smooth(&sweep(element, Cells { refine: 1, moved: 0.2 }, 100, || ()).unwrap());
        }
    }

    #[test]
    fn the_smooth_surface_bends_where_facets_kink() {
        let (facets, smooth) = (&sweep(ContactElement::NodeToFacet, REGULAR, 600, || ()).unwrap(), &*SMOOTH);
        assert!(
            smooth.kink_degrees < 0.2 * facets.kink_degrees,
            "{} {}",
            smooth.kink_degrees,
            facets.kink_degrees
        );
        let range = |curve: &Curve| {
            let [low, high] = curve.gaps();
            high - low
        };
        assert!(range(smooth) < 0.5 * range(facets), "{} {}", range(smooth), range(facets));
    }

    #[test]
    fn every_step_has_a_state_and_gaps_err_to_both_sides() {
        let curve = sweep(cubic(RULES[1]), REGULAR, 600, || ()).unwrap();
        assert_eq!(curve.states.len(), 600);
        let [low, high] = curve.gaps();
        assert!(low < -scene::DEPTH && high > -scene::DEPTH, "{low} {high}");
    }
}
