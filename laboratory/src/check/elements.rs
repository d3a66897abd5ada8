//! Random elements on which results of different backends can be compared to nearly full precision.
//!
//! A fit can be as ill-conditioned as it likes: as its master nodes approach a conic (or, for the linear basis, a
//! line) every backend loses digits, each in its own way, and a comparison says nothing about the formulas. So the
//! elements are random and then selected. One is made like this, all numbers uniform unless said otherwise:
//!
//! * support radius R = 10^s, s in [−3, 3): the length unit must not matter;
//! * frame: a uniformly distributed rotation; slave: anywhere in a cube of half width 5 R about the origin;
//! * master nodes: uniform in the disc of radius 0.8 R about the slave, in the plane of the frame, as the default
//!   support radius has it: nodes of hardly any weight would cost digits like a conic. Of three elements the first
//!   has a node straight under the slave (r = 0, where derivatives of r do not exist), and the second, if there
//!   are nodes to spare, a node at 1.2 R, outside the support;
//! * heights over the slave: a quadratic polynomial of the position over R, its coefficients in [−0.3, 0.3) R, plus
//!   a wave of height 0.05 R, so that the surface is smooth and none that the basis reproduces;
//! * the point where the surface kernels are evaluated: uniform in the disc of radius 0.5 R;
//! * the anchor of the slip: uniform in the cube of half-edge 0.5 R around the slave.
//!
//! Its master nodes serve a third time with domains of influence in a first configuration, which differs from the positions by
//! a rotation, a stretch of up to a third and noise; the domains are ellipsoids with half axes of 0.9 R to 1.6 R.
//!
//! Its master nodes and support radius serve a second time, in the average plane of the nodes as a co-moving frame;
//! a slave straight over a node is moved there along the plane, so that it is straight over the node again.
//!
//! It is kept if its [`Conditioning`] in each frame is within the bounds of [`is_well_conditioned`], and if second derivatives change by
//! no more than [`LARGEST_CHANGE`] with the last digits of its nodes; if not, the next is made.
//! The same seed, node count and basis give the same elements on every machine.

use std::f64::consts::TAU;

use diffuse_contact::{
    Backend, CustomBasis, Domains, Element, ElementError, Frame, MaterialDomain, MaterialNode, MaterialPlace,
    Mode, Point, SymmetricMatrix, Weight,
};
use diffuse_contact_benches::Random;
use diffuse_contact_codegen::{Basis, FrameRule};

use super::blocks::worse;
use crate::interpreted::{Conditioning, Interpreted};

/// Smallest relative pivot of the moment matrix, about the slave and about the surface point, and of the equations
/// for the turn of the average plane.
pub const SMALLEST_PIVOT: f64 = 1e-2;
/// Smallest determinant of the foot equations' Jacobian, 1 on a flat surface.
pub const SMALLEST_DETERMINANT: f64 = 0.2;
/// Largest in-plane distance of the foot from the slave over R.
pub const LARGEST_FOOT_DISTANCE: f64 = 0.8;

/// Largest change of M, ∇²q and H_f, relative, with the last digits of the nodes' coordinates.
pub const LARGEST_CHANGE: f64 = 1e-13;

/// Elements tried before giving up.
const ATTEMPTS: usize = 5_000;
/// Radius of the disc of the master nodes over R.
const DISC: f64 = 0.8;
/// Distance of a node outside the support from the slave over R.
const OUTSIDE: f64 = 1.2;
/// Radius of the disc of the surface points over R.
const POINT_DISC: f64 = 0.5;
/// Half width of the cube of the slaves over R.
const CUBE: f64 = 5.0;
/// Largest coefficient of the heights over R.
const COEFFICIENT: f64 = 0.3;
/// Height and wave number of the wave.
const WAVE: (f64, f64) = (0.05, 3.0);

/// Where the first master node is put.
#[derive(Clone, Copy)]
enum FirstNode {
    /// Where the others are.
    Anywhere,
    /// Straight under the slave.
    UnderSlave,
    /// Outside the support.
    Outside,
}

impl FirstNode {
    fn of(index: usize, spare_nodes: bool) -> Self {
        match index % 3 {
            0 => Self::UnderSlave,
            1 if spare_nodes => Self::Outside,
            _ => Self::Anywhere,
        }
    }
}

/// An element that owns its nodes.
#[derive(Clone, Debug)]
pub struct RandomElement {
    masters: Vec<Point>,
    /// R_k of each, or none: R for all.
    radii: Vec<f64>,
    support_radius: f64,
    basis: Basis,
    /// Weight that backends are asked for.
    weight: Weight,
    held: Place,
    co_moving: Place,
    material: Place,
    /// Where the nodes are in the first configuration.
    material_nodes: Vec<MaterialNode>,
    /// In-plane offset for the surface kernels, length.
    pub point: [f64; 2],
    /// Anchor of the slip.
    pub anchor: Point,
    /// What it was selected by, with each frame rule.
    pub conditioning: [Conditioning; 3],
}

/// What belongs to one frame.
#[derive(Clone, Copy, Debug)]
struct Place {
    slave: Point,
    frame: Frame,
}

/// No random element was well conditioned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no comparison for {nodes} master nodes, {} basis: none of {attempts} random elements is well conditioned",
    .basis.name()
)]
pub struct NoElement {
    /// Number of master nodes.
    pub nodes: usize,
    /// Basis of the fit.
    pub basis: Basis,
    /// Elements tried.
    pub attempts: usize,
}

/// Whether results are comparable: relative pivots of at least [`SMALLEST_PIVOT`], a Jacobian determinant of at
/// least [`SMALLEST_DETERMINANT`], and a foot within [`LARGEST_FOOT_DISTANCE`].
pub fn is_well_conditioned(figures: &Conditioning) -> bool {
    figures.pivot_ratio >= SMALLEST_PIVOT
        && figures.plane_pivot_ratio >= SMALLEST_PIVOT
        && figures.jacobian_determinant >= SMALLEST_DETERMINANT
        && figures.foot_distance <= LARGEST_FOOT_DISTANCE
}

impl RandomElement {
    /// Well-conditioned element number `index` for a seed; `interpreted` has the weight it is to be used with, and so has `backend`, if it
    /// is asked for `weight`. The nodes of every other element have domains of their own, and weights in its average plane.
    ///
    /// # Errors
    /// [`NoElement`] if none is found.
    pub fn new(
        basis: Basis,
        nodes: usize,
        seed: u64,
        index: usize,
        interpreted: &Interpreted,
        (weight, backend): (Weight, &dyn Backend),
    ) -> Result<Self, NoElement> {
        let mut random = Random::new(&[seed, basis.size() as u64, nodes as u64, index as u64]);
        for _ in 0..ATTEMPTS {
            let first = FirstNode::of(index, nodes > basis.size());
            let fitting = |r| interpreted.fitting_weight(r);
            let candidate = Self::candidate((basis, nodes), first, (fitting, index % 2 == 1), &mut random);
            let Ok(mut candidate) = candidate else {
                continue;
            };
            let figures = |frame, point| {
                let figures = interpreted.conditioning(&candidate.element(frame), point).ok();
                figures.filter(is_well_conditioned)
            };
            let Some(held) = figures(FrameRule::Held, candidate.point) else { continue };
            // The surface is compared in the held frame only.
            let Some(co_moving) = figures(FrameRule::CoMoving, [0.0; 2]) else { continue };
            let Some(material) = figures(FrameRule::Material, [0.0; 2]) else { continue };
            (candidate.conditioning, candidate.weight) = ([held, co_moving, material], weight);
            if candidate.change_with_last_digits(backend) <= LARGEST_CHANGE {
                return Ok(candidate);
            }
        }
        Err(NoElement { nodes, basis, attempts: ATTEMPTS })
    }

    /// The element as the backends take it, in a frame that is held or in the average plane.
    pub fn element(&self, rule: FrameRule) -> Element<'_> {
        let Place { slave, frame } = match rule {
            FrameRule::Held => self.held,
            FrameRule::CoMoving => self.co_moving,
            FrameRule::Material => self.material,
        };
        let domains = match rule {
            FrameRule::Material => Domains::Material(&self.material_nodes),
            FrameRule::Held | FrameRule::CoMoving if self.radii.is_empty() => Domains::Shared,
            FrameRule::Held | FrameRule::CoMoving => Domains::Each(&self.radii),
        };
        Element::new(slave, &self.masters, frame, self.support_radius)
            .with_domains(domains)
            .with_basis(match self.basis {
                Basis::Quadratic => diffuse_contact::Basis::Quadratic,
                Basis::Linear => diffuse_contact::Basis::Linear,
                Basis::Custom(_) => {
                    let (name, monomials) = (self.basis.name(), self.basis.monomials());
                    diffuse_contact::Basis::Custom(CustomBasis { name, monomials })
                }
            })
            .with_weight(self.weight)
    }

    /// How much M and ∇²q in all frames, and H_f, change over their largest entries when the nodes move by one unit in the last digits of
    /// their coordinates, to and fro; infinite if there is no result.
    fn change_with_last_digits(&self, backend: &dyn Backend) -> f64 {
        let mut other = self.clone();
        for (k, x) in other.masters.as_flattened_mut().iter_mut().enumerate() {
            *x = if k % 2 == 0 { x.next_up() } else { x.next_down() };
        }
        let hessians = |random: &Self| -> Result<Vec<SymmetricMatrix>, ElementError> {
            let surface = backend.surface(&random.element(FrameRule::Held), self.point, Mode::Hessian)?;
            let mut all = vec![surface.hessian];
            for rule in [FrameRule::Held, FrameRule::CoMoving, FrameRule::Material] {
                // With that of the gap.
                let slip = backend.slip(&random.element(rule), random.anchor, Mode::Hessian)?;
                all.extend([slip.contact.hessian, slip.hessian]);
            }
            Ok(all)
        };
        let (Ok(before), Ok(after)) = (hessians(self), hessians(&other)) else { return f64::INFINITY };
        before
            .iter()
            .zip(&after)
            .map(|(before, after)| change(before.packed(), after.packed()))
            .fold(0.0, worse)
    }

    /// `weight`: the fitting weight, and whether nodes have domains of their own.
    fn candidate(
        (basis, nodes): (Basis, usize),
        first: FirstNode,
        (weight, has_domains): (impl Fn(f64) -> f64 + Copy, bool),
        random: &mut Random,
    ) -> Result<Self, ElementError> {
        let radius = 10_f64.powf(random.between(-3.0, 3.0));
        let [t1, t2, normal] = random.rotation();
        let slave: Point = std::array::from_fn(|_| radius * random.between(-CUBE, CUBE));
        let masters = masters(nodes, first, (slave, radius), [t1, t2, normal], random);
        let point = random.in_disc(POINT_DISC).map(|x| radius * x);
        let anchor = std::array::from_fn(|k| slave[k] + radius * random.between(-POINT_DISC, POINT_DISC));
        let held = Place { slave, frame: Frame::given(slave, t1, t2, normal, None)? };
        let radii: Vec<f64> = if has_domains {
            masters.iter().map(|_| radius * random.between(0.9, 1.3)).collect()
        } else {
            Vec::new()
        };
        let plane = |slave| {
            if has_domains {
                Frame::moving_plane(slave, &masters, &radii, weight, 1.0, normal)
            } else {
                Frame::average_plane(&masters, normal)
            }
        };
        let over = match first {
            FirstNode::UnderSlave => straight_over(masters[0], slave, &plane(slave)?),
            FirstNode::Anywhere | FirstNode::Outside => slave,
        };
        let co_moving = Place { slave: over, frame: plane(over)? };
        let domains = material_domains(slave, &masters, radius, random);
        let found = MaterialPlace::find(slave, &masters, &domains, weight, normal)?;
        let material = Place { slave, frame: found.frame };
        let material_nodes = found.nodes(&domains);
        let unknown = Conditioning {
            pivot_ratio: 0.0,
            plane_pivot_ratio: 0.0,
            jacobian_determinant: 0.0,
            foot_distance: f64::INFINITY,
        };
        Ok(Self {
            masters,
            radii,
            support_radius: radius,
            basis,
            weight: Weight::default(),
            held,
            co_moving,
            material,
            material_nodes,
            point,
            anchor,
            conditioning: [unknown; 3],
        })
    }
}

/// Largest change of an entry over the largest entry; NaN if one is.
fn change(before: &[f64], after: &[f64]) -> f64 {
    let largest = before.iter().map(|x| x.abs()).fold(0.0, worse);
    before.iter().zip(after).map(|(x, y)| (x - y).abs()).fold(0.0, worse) / largest
}

/// Nodes of a curved and wavy surface around the slave.
fn masters(
    nodes: usize,
    first: FirstNode,
    (slave, radius): (Point, f64),
    [t1, t2, normal]: [Point; 3],
    random: &mut Random,
) -> Vec<Point> {
    let coefficients: [f64; 6] = std::array::from_fn(|_| random.between(-COEFFICIENT, COEFFICIENT));
    let (direction, phase) = (random.between(0.0, TAU), random.between(0.0, TAU));
    let height = |a: f64, b: f64| {
        let [c0, c1, c2, c3, c4, c5] = coefficients;
        let along = direction.cos() * a + direction.sin() * b;
        let wave = WAVE.0 * (WAVE.1 * along + phase).sin();
        c0 + c1 * a + c2 * b + c3 * a * a + c4 * a * b + c5 * b * b + wave
    };
    (0..nodes)
        .map(|node| {
            let [a, b] = match first {
                FirstNode::UnderSlave if node == 0 => [0.0; 2],
                FirstNode::Outside if node == 0 => {
                    let direction = random.between(0.0, TAU);
                    [OUTSIDE * direction.cos(), OUTSIDE * direction.sin()]
                }
                _ => random.in_disc(DISC),
            };
            let z = height(a, b);
            std::array::from_fn(|k| slave[k] + radius * (a * t1[k] + b * t2[k] + z * normal[k]))
        })
        .collect()
}

/// First positions of nodes, and ellipsoids around them.
fn material_domains(
    slave: Point,
    masters: &[Point],
    radius: f64,
    random: &mut Random,
) -> Vec<MaterialDomain> {
    let rotation = random.rotation();
    let stretch: [f64; 3] = std::array::from_fn(|_| random.between(0.75, 1.33));
    let shift: Point = std::array::from_fn(|_| radius * random.between(-CUBE, CUBE));
    masters
        .iter()
        .map(|x| {
            let offset: [f64; 3] = std::array::from_fn(|k| stretch[k] * (x[k] - slave[k]));
            let position = std::array::from_fn(|k| {
                let turned: f64 = (0..3).map(|l| rotation[k][l] * offset[l]).sum();
                shift[k] + turned + radius * random.between(-0.03, 0.03)
            });
            // U of a random ellipsoid: its diagonal dominates.
            let mut entry = |low: f64, high: f64| random.between(low, high) / radius;
            let metric = [
                entry(0.6, 1.1),
                entry(-0.2, 0.2),
                entry(-0.2, 0.2),
                entry(0.6, 1.1),
                entry(-0.2, 0.2),
                entry(0.6, 1.1),
            ];
            MaterialDomain { position, metric }
        })
        .collect()
}

/// `slave` moved along the plane to where it is straight over a node.
fn straight_over(node: Point, slave: Point, plane: &Frame) -> Point {
    let height: f64 = (0..3).map(|k| (slave[k] - node[k]) * plane.normal[k]).sum();
    std::array::from_fn(|k| node[k] + height * plane.normal[k])
}

#[cfg(test)]
mod tests {
    use diffuse_contact::FrameDerivative;
    use diffuse_contact::ad::Ad;

    use super::*;

    const CUBIC: (Weight, &dyn Backend) = (Weight::Cubic, &Ad);

    #[test]
    fn elements_are_reproducible_and_different() {
        let interpreted = Interpreted::default();
        let element = |seed, index| {
            RandomElement::new(Basis::Linear, 5, seed, index, &interpreted, CUBIC).unwrap().masters
        };
        assert_eq!(element(1, 0), element(1, 0));
        assert_ne!(element(1, 0), element(1, 1));
        assert_ne!(element(1, 0), element(2, 0));
    }

    #[test]
    fn a_change_that_is_no_number_is_not_small() {
        assert_eq!(change(&[1.0, -4.0], &[1.0, -3.0]), 0.25);
        assert!(change(&[1.0, f64::NAN, 2.0], &[1.0, 1.0, 2.0]).is_nan());
        assert!(change(&[1.0, 1.0, 2.0], &[1.0, f64::NAN, 2.0]).is_nan());
    }

    #[test]
    fn elements_keep_what_they_promise() {
        let interpreted = Interpreted::default();
        for (basis, nodes) in [(Basis::Linear, 3), (Basis::Quadratic, 6), (Basis::Quadratic, 10)] {
            let random = RandomElement::new(basis, nodes, 7, 0, &interpreted, CUBIC).unwrap();
            assert!(random.change_with_last_digits(CUBIC.1) <= LARGEST_CHANGE);
            assert!(random.conditioning.iter().all(is_well_conditioned));
            for (frame, derivative) in [
                (FrameRule::Held, FrameDerivative::Held),
                (FrameRule::CoMoving, FrameDerivative::CoMoving),
                (FrameRule::Material, FrameDerivative::CoMoving),
            ] {
                let element = random.element(frame);
                element.validate().unwrap();
                assert_eq!(element.masters.len(), nodes);
                assert_eq!(element.frame.derivative, derivative);
                if frame == FrameRule::Material {
                    continue;
                }
                let offset = |k: usize| element.masters[0][k] - element.slave[k];
                let in_plane =
                    |t: Point| (0..3).map(|k| offset(k) * t[k]).sum::<f64>() / element.support_radius;
                assert!(in_plane(element.frame.t1).hypot(in_plane(element.frame.t2)) < 1e-14);
            }
        }
    }
}
