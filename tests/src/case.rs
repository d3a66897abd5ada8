//! Random elements.

use std::f64::consts::PI;

use diffuse_contact::{
    Basis, Domains, Element, Frame, FrameDerivative, MaterialDomain, MaterialNode, MaterialPlace, Point,
    Weight,
};
use diffuse_contact_kernels::support::{ElementInputs, Masters};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::geometry::{Random, add, dot, scale, turn};

/// An element that owns its nodes.
#[derive(Clone, Debug)]
pub struct Case {
    /// Slave node.
    pub slave: Point,
    /// Master nodes.
    pub masters: Vec<Point>,
    /// Local frame.
    pub frame: Frame,
    /// R.
    pub support_radius: f64,
    /// R_k of each master node; none: R for all.
    pub radii: Vec<f64>,
    /// Where the nodes are in the first configuration, if their domains are there.
    pub material: Vec<MaterialNode>,
    /// Basis of the fit.
    pub basis: Basis,
    /// Weight of the fit.
    pub weight: Weight,
}

impl Case {
    /// A well-conditioned element of about unit size in general position: `n` masters spread over the unit disc
    /// and off every conic, on a bumpy surface with curvatures up to 0.4, the slave within 0.4 of it. With an odd seed the nodes
    /// have domains of their own, 0.9 to 1.3 R wide.
    #[must_use]
    pub fn random(n: usize, basis: Basis, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let surface = Quadric::random(&mut random);
        let mut nodes = vec![[0.2 * random.signed(), 0.2 * random.signed(), 0.0]];
        nodes[0][2] = surface.height(nodes[0][0], nodes[0][1]) + 0.4 * random.signed();
        for [a, b] in spread(n, &mut random) {
            nodes.push([a, b, surface.height(a, b) + 0.05 * random.signed()]);
        }
        let case = Self::from_local(&nodes, 1.3, basis, &mut random);
        if seed.is_multiple_of(2) {
            return case;
        }
        let radii = (0..n).map(|_| 1.3 * (1.1 + 0.2 * random.signed())).collect();
        Self { radii, ..case }
    }

    /// `n` masters on a quadric and the slave at `distance` from it, straight above the surface point at
    /// (a, b) = `foot`.
    #[must_use]
    pub fn on_quadric(surface: &Quadric, foot: [f64; 2], distance: f64, n: usize, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let [a, b] = foot;
        let mut nodes = vec![add([a, b, surface.height(a, b)], scale(distance, surface.normal(a, b)))];
        nodes.extend(spread(n, &mut random).into_iter().map(|[a, b]| [a, b, surface.height(a, b)]));
        Self::from_local(&nodes, 1.8, Basis::Quadratic, &mut random)
    }

    /// An element from local coordinates, slave first, turned at random.
    #[must_use]
    pub fn from_local(nodes: &[Point], support_radius: f64, basis: Basis, random: &mut Random) -> Self {
        let [t1, t2, normal] = random.rotation();
        let frame = Frame::given([0.0; 3], t1, t2, normal, None).expect("a rotation matrix");
        let centre = random.vector(2.0);
        let mut positions = nodes.iter().map(|x| {
            let local = add(add(scale(x[0], t1), scale(x[1], t2)), scale(x[2], normal));
            add(local, centre)
        });
        let slave = positions.next().expect("a slave");
        let masters = positions.collect();
        let (radii, material) = (Vec::new(), Vec::new());
        Self { slave, masters, frame, support_radius, radii, material, basis, weight: Weight::Cubic }
    }

    /// The element in the frame (x, y, z), from coordinates taken as they are, slave first.
    #[must_use]
    pub fn axis_aligned(nodes: &[Point], support_radius: f64, basis: Basis) -> Self {
        let [t1, t2, normal] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let frame = Frame::given([0.0; 3], t1, t2, normal, None).expect("axes");
        Self {
            slave: nodes[0],
            masters: nodes[1..].to_vec(),
            frame,
            support_radius,
            radii: Vec::new(),
            material: Vec::new(),
            basis,
            weight: Weight::Cubic,
        }
    }

    /// What the backends take.
    #[must_use]
    pub fn element(&self) -> Element<'_> {
        Element::new(self.slave, &self.masters, self.frame, self.support_radius)
            .with_domains(self.domains())
            .with_basis(self.basis)
            .with_weight(self.weight)
    }

    fn domains(&self) -> Domains<'_> {
        if !self.material.is_empty() {
            Domains::Material(&self.material)
        } else if self.radii.is_empty() {
            Domains::Shared
        } else {
            Domains::Each(&self.radii)
        }
    }

    /// What the kernels read; surfaces are evaluated below the slave.
    #[must_use]
    pub fn inputs(&self) -> ElementInputs<'_> {
        ElementInputs {
            slave: self.slave,
            masters: Masters::Positions(&self.masters),
            domains: self.domains(),
            plane_reach: self.frame.reach,
            t1: self.frame.t1,
            t2: self.frame.t2,
            normal: self.frame.normal,
            support_radius: self.support_radius,
            point: [0.0; 2],
            anchor: [0.0; 3],
            pole: self.element().nearest_in_plane(),
        }
    }

    /// The element with another weight, which also weights the nodes in a moving plane.
    #[must_use]
    pub fn with_weight(self, weight: Weight) -> Self {
        let case = Self { weight, ..self };
        if !case.material.is_empty() {
            case.material()
        } else if case.frame.reach > 0.0 {
            case.co_moving()
        } else {
            case
        }
    }

    /// The element in the average plane of its masters, moving with it, on the same side; nodes with domains of their own are
    /// weighted.
    ///
    /// # Panics
    /// If there is no such plane.
    #[must_use]
    pub fn co_moving(self) -> Self {
        let frame = if self.radii.is_empty() {
            Frame::average_plane(&self.masters, self.frame.normal)
        } else {
            let weight = |r| self.weight.fitting(r);
            Frame::moving_plane(self.slave, &self.masters, &self.radii, weight, 1.0, self.frame.normal)
        };
        Self { frame: frame.expect("an average plane"), ..self }
    }

    /// The element with domains in a first configuration, from which the nodes have been stretched and moved, in the plane that moves
    /// with them. Nodes that have no place there are seen from the slave.
    #[must_use]
    pub fn material(self) -> Self {
        let mut random = Random::new(self.masters.len() as u64);
        let radius = self.support_radius;
        let metric = [0.9, 0.15, -0.1, 0.8, 0.1, 0.7].map(|entry| entry / radius);
        let domains: Vec<MaterialDomain> = self
            .masters
            .iter()
            .map(|x| {
                let offset = add(*x, scale(-1.0, self.slave));
                let stretched = [0.9 * offset[0], 1.15 * offset[1], 1.05 * offset[2]];
                let noise = random.vector(0.02 * radius);
                MaterialDomain { position: add(stretched, noise), metric }
            })
            .collect();
        let weight = |r| self.weight.fitting(r);
        let found = MaterialPlace::find(self.slave, &self.masters, &domains, weight, self.frame.normal);
        let (material, frame) = match found {
            Ok(found) => (found.nodes(&domains), found.frame),
            Err(_) => {
                let nodes = domains.iter().map(|domain| domain.from([0.0; 3])).collect();
                (nodes, Frame { derivative: FrameDerivative::CoMoving, ..self.frame })
            }
        };
        Self { material, frame, ..self }
    }

    /// Every position replaced by `f` of it.
    #[must_use]
    pub fn mapped(&self, f: impl Fn(Point) -> Point) -> Self {
        let masters = self.masters.iter().map(|x| f(*x)).collect();
        Self { slave: f(self.slave), masters, ..self.clone() }
    }

    /// In another unit of length.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let support_radius = factor * self.support_radius;
        let radii = self.radii.iter().map(|radius| factor * radius).collect();
        Self { support_radius, radii, ..self.mapped(|x| scale(factor, x)) }
    }

    /// With R doing the measuring: the same coordinates, a support radius of 1.
    #[must_use]
    pub fn with_radius_as_unit(&self) -> Self {
        Self { support_radius: 1.0, ..self.clone() }
    }

    /// Nodes and frame turned by the rotation with rows `q`.
    #[must_use]
    pub fn turned(&self, q: &[Point; 3]) -> Self {
        let [t1, t2, normal] = self.frame.rows().map(|row| turn(q, row));
        let frame = Frame { t1, t2, normal, origin: turn(q, self.frame.origin), ..self.frame };
        Self { frame, ..self.mapped(|x| turn(q, x)) }
    }

    /// Global components of a vector given in local ones.
    #[must_use]
    pub fn global(&self, local: Point) -> Point {
        let [t1, t2, normal] = self.frame.rows();
        add(add(scale(local[0], t1), scale(local[1], t2)), scale(local[2], normal))
    }

    /// Local offset (a, b, z) of a point from the slave.
    #[must_use]
    pub fn local_offset(&self, x: Point) -> Point {
        let offset = add(x, scale(-1.0, self.slave));
        self.frame.rows().map(|row| dot(row, offset))
    }
}

/// `n` points of the unit disc along a spiral by golden angles, each moved a little.
fn spread(n: usize, random: &mut Random) -> Vec<[f64; 2]> {
    let golden = PI * (3.0 - 5.0f64.sqrt());
    let start = PI * random.signed();
    let step = 0.1 / (n as f64).sqrt();
    (0..n)
        .map(|i| {
            let r = ((i as f64 + 0.5) / n as f64).sqrt();
            let (s, c) = (golden * i as f64 + start).sin_cos();
            [r * c + step * random.signed(), r * s + step * random.signed()]
        })
        .collect()
}

/// The surface z = c·(1, a, b, a², ab, b²).
#[derive(Clone, Copy, Debug)]
pub struct Quadric(pub [f64; 6]);

impl Quadric {
    /// Slopes up to 0.2 and curvatures up to 0.4.
    #[must_use]
    pub fn random(random: &mut Random) -> Self {
        Self([0.1, 0.2, 0.2, 0.15, 0.1, 0.15].map(|size| size * random.signed()))
    }

    /// z(a, b)
    #[must_use]
    pub fn height(&self, a: f64, b: f64) -> f64 {
        let c = &self.0;
        c[0] + c[1] * a + c[2] * b + c[3] * a * a + c[4] * a * b + c[5] * b * b
    }

    /// ∂z/∂a, ∂z/∂b
    #[must_use]
    pub fn slopes(&self, a: f64, b: f64) -> [f64; 2] {
        let c = &self.0;
        [c[1] + 2.0 * c[3] * a + c[4] * b, c[2] + c[4] * a + 2.0 * c[5] * b]
    }

    /// Second derivatives z_aa, z_ab, z_bb.
    #[must_use]
    pub const fn curvatures(&self) -> [f64; 3] {
        [2.0 * self.0[3], self.0[4], 2.0 * self.0[5]]
    }

    /// Unit normal, upwards.
    #[must_use]
    pub fn normal(&self, a: f64, b: f64) -> Point {
        let [z_a, z_b] = self.slopes(a, b);
        let length = (1.0 + z_a * z_a + z_b * z_b).sqrt();
        [-z_a / length, -z_b / length, 1.0 / length]
    }
}

/// Elements by [`Case::random`], of either basis, with up to 14 masters.
pub fn cases() -> impl Strategy<Value = Case> {
    let quadratic = (6usize..=14, any::<u64>()).prop_map(|(n, seed)| Case::random(n, Basis::Quadratic, seed));
    let linear = (3usize..=14, any::<u64>()).prop_map(|(n, seed)| Case::random(n, Basis::Linear, seed));
    prop_oneof![quadratic, linear]
}

/// `cases` cases, the same in every run.
#[must_use]
pub fn fixed(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(2008), failure_persistence: None, ..Default::default() }
}
