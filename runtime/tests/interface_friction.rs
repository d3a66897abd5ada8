//! Friction of whole interfaces: forces against differences of the slip, balance, and its history.

mod history;

use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};

use diffuse_contact::affine::{AffinePoint, Carrier};
use diffuse_contact::assembly::{
    ContactLaw, DofMap, Tangent, TangentOperator, Triangle, Triplets, add_forces,
};
use diffuse_contact::friction::{Coulomb, DecayingCoefficient};
use diffuse_contact::interface::{Anchor, ContactInterface, FrictionReport, InterfaceOptions};
use diffuse_contact::neighbourhood::SearchOptions;
use diffuse_contact::surface::SymmetryPlane;
use diffuse_contact::{Mode, Point, Weight, interface::ContactElement};

use crate::common::{Mesh, Uniform, distance, worse};

const PENALTY: f64 = 400.0;
const STIFFNESS: f64 = 300.0;
const DEPTH: f64 = 0.02;

fn wave(x: f64, y: f64) -> f64 {
    0.3 * (x * FRAC_PI_6).sin() * (y * FRAC_PI_6).cos()
}

/// Slaves in contact with a wavy surface, and how they are pressed on it.
struct Pressed {
    interface: ContactInterface,
    positions: Vec<Point>,
    law: ContactLaw<'static>,
    /// The nodes of the slaves.
    slaves: Vec<usize>,
}

fn law(coefficient: f64) -> ContactLaw<'static> {
    ContactLaw::penalty(PENALTY).with_friction(Some(Coulomb::new(coefficient, STIFFNESS).unwrap()))
}

impl Pressed {
    /// On the smooth surface.
    fn new(coefficient: f64, weight: Weight, planes: &[SymmetryPlane]) -> Self {
        let element = ContactElement::diffuse(SearchOptions::domains()).with_weight(weight);
        Self::on(coefficient, element, planes)
    }

    /// Slaves over [1, 7]² of a surface of 8 × 8 cells of irregular shape, accepted where they touch.
    fn on(coefficient: f64, element: ContactElement, planes: &[SymmetryPlane]) -> Self {
        let mut random = Uniform(5);
        let moved: Vec<f64> = (0..200).map(|_| 0.15 * random.signed()).collect();
        let mesh = Mesh::grid([9, 9], [false; 2], |s, t| {
            let (x, y) = (8.0 * s, 8.0 * t);
            let inner = |t: f64| if t > 0.0 && t < 8.0 { 1.0 } else { 0.0 };
            let k = (9.0 * y + x) as usize;
            let (x, y) = (x + inner(x) * moved[2 * k], y + inner(y) * moved[2 * k + 1]);
            [x, y, wave(x, y)]
        });
        let slaves: Vec<Point> = [(1.7, 2.2), (3.1, 4.4), (4.6, 3.3), (6.2, 5.7), (0.3, 3.4)]
            .map(|(x, y)| [x, y, wave(x, y) - DEPTH])
            .to_vec();
        Self::over(&mesh, &slaves, coefficient, element, planes)
    }

    /// Slaves over one row of cells, whose fits take the middles between its nodes too.
    fn on_strip(coefficient: f64, weight: Weight) -> Self {
        let element = ContactElement::diffuse(SearchOptions::domains()).with_weight(weight);
        let mesh = Mesh::grid([9, 2], [false; 2], |s, t| {
            let (x, y) = (8.0 * s, 2.0 * t);
            [x + 0.1 * (5.0 * x + y).sin(), y, wave(x, y)]
        });
        let slaves: Vec<Point> = [(1.7, 0.4), (3.1, 1.6), (4.6, 1.0), (6.2, 0.7)]
            .map(|(x, y)| [x, y, wave(x, y) - 2.0 * DEPTH])
            .to_vec();
        Self::over(&mesh, &slaves, coefficient, element, &[])
    }

    fn over(
        mesh: &Mesh,
        slaves: &[Point],
        coefficient: f64,
        element: ContactElement,
        planes: &[SymmetryPlane],
    ) -> Self {
        let mut positions = mesh.positions.clone();
        let first = positions.len();
        positions.extend(slaves);
        let options = InterfaceOptions::default().with_element(element);
        let slaves: Vec<usize> = (first..positions.len()).collect();
        let mut interface =
            ContactInterface::new(mesh.surface(), slaves.clone(), &[], &positions, options).unwrap();
        interface.set_symmetry(planes).unwrap();
        interface.refresh_pairing(&positions).unwrap();
        let law = law(coefficient);
        interface.accept(&law).unwrap();
        interface.refresh_pairing(&positions).unwrap();
        Self { interface, positions, law, slaves }
    }

    /// Moves all slaves.
    fn slide(&mut self, step: Point) {
        for &slave in &self.slaves {
            for axis in 0..3 {
                self.positions[slave][axis] += step[axis];
            }
        }
        self.follow();
    }

    /// Facets are those below the slaves.
    fn follow(&mut self) {
        if self.interface.options().element == ContactElement::NodeToFacet {
            self.interface.refresh_pairing(&self.positions).unwrap();
        } else {
            self.interface.follow(&self.positions).unwrap();
        }
    }

    /// Moves all slaves, and the masters by what makes the surface another one.
    fn slide_and_deform(&mut self, step: Point) {
        let mut random = Uniform(11);
        for x in &mut self.positions[..self.slaves[0]] {
            *x = x.map(|x| x + 0.002 * random.signed());
        }
        self.slide(step);
    }

    /// Moves all slaves by more than a cell along x and y, to the same depth: their anchors are out of reach then.
    fn slide_far(&mut self) {
        for &slave in &self.slaves {
            let [x, y, _] = self.positions[slave];
            let place = |t: f64| if t > 4.0 { t - 2.6 } else { t + 2.6 };
            let (x, y) = (place(x), place(y));
            self.positions[slave] = [x, y, wave(x, y) - DEPTH];
        }
        self.follow();
    }

    fn forces(&mut self) -> Vec<f64> {
        let dofs = DofMap::standard(self.positions.len());
        let mut forces = vec![0.0; dofs.equations()];
        let contacts = self.interface.evaluate(Mode::Gradient).unwrap();
        add_forces(contacts, &self.law, &dofs, &mut forces).unwrap();
        forces
    }

    fn tangent(&mut self) -> Vec<Vec<f64>> {
        let size = 3 * self.positions.len();
        let dofs = DofMap::standard(self.positions.len());
        let mut triplets = Triplets::new();
        let contacts = self.interface.evaluate(Mode::Hessian).unwrap();
        triplets.fill(contacts, &self.law, &dofs, Triangle::Full).unwrap();
        let mut matrix = vec![vec![0.0; size]; size];
        for (row, column, value) in triplets.iter() {
            matrix[row][column] += value;
        }
        matrix
    }

    fn accept(&mut self) -> FrictionReport {
        let report = self.interface.accept(&self.law).unwrap();
        self.interface.refresh_pairing(&self.positions).unwrap();
        report
    }

    /// The tangential force on the `k`-th slave.
    fn traction(&mut self, k: usize) -> Point {
        let with = self.forces();
        let frictionless = self.law.with_friction(None);
        let law = std::mem::replace(&mut self.law, frictionless);
        let without = self.forces();
        self.law = law;
        [0, 1, 2].map(|axis| with[3 * self.slaves[k] + axis] - without[3 * self.slaves[k] + axis])
    }

    fn normal_force(&self, k: usize) -> f64 {
        self.law.force(k, self.interface.contacts().get(k).point.gap, 1.0)
    }
}

fn length(v: Point) -> f64 {
    distance(v, [0.0; 3])
}

fn largest(values: &[f64]) -> f64 {
    values.iter().map(|value| value.abs()).fold(0.0, worse)
}

#[test]
fn the_tangent_is_the_derivative_of_the_forces() {
    let plane = SymmetryPlane { point: [0.0; 3], normal: [1.0, 0.0, 0.0] };
    let smooth = |weight| ContactElement::diffuse(SearchOptions::domains()).with_weight(weight);
    let cases = [
        (smooth(Weight::Cubic), &[plane][..]),
        (smooth(Weight::WendlandC2), &[]),
        (smooth(Weight::CubicInterpolating), &[]),
        (ContactElement::NodeToFacet, &[]),
    ];
    for (element, planes) in cases {
        // All stick, all slide.
        for coefficient in [30.0, 0.1] {
            let mut pressed = Pressed::on(coefficient, element, planes);
            pressed.slide_and_deform([0.03, 0.02, 0.001]);
            assert_tangent(&mut pressed, coefficient == 30.0);
        }
        // From anchors that no node within reach carries.
        let mut pressed = Pressed::on(0.1, element, planes);
        pressed.slide_far();
        assert_tangent(&mut pressed, false);
        // Slaves that were open.
        let mut pressed = Pressed::on(0.5, element, planes);
        pressed.slide([0.0, 0.0, 2.0 * DEPTH]);
        pressed.accept();
        pressed.slide([2e-4, 1e-4, -2.0 * DEPTH]);
        assert_tangent(&mut pressed, false);
    }
    for (weight, coefficient) in Weight::ALL.into_iter().flat_map(|weight| [(weight, 30.0), (weight, 0.1)]) {
        let mut pressed = Pressed::on_strip(coefficient, weight);
        pressed.slide_and_deform([0.03, 0.02, 0.001]);
        assert_tangent(&mut pressed, coefficient == 30.0);
    }
}

/// The tangent against central differences of the forces along a direction of all coordinates, and whether it is symmetric.
fn assert_tangent(pressed: &mut Pressed, is_symmetric: bool) {
    let matrix = pressed.tangent();
    let mut random = Uniform(3);
    let direction: Vec<f64> = (0..3 * pressed.positions.len()).map(|_| random.signed()).collect();
    let start = pressed.positions.clone();
    let mut at = |step: f64| {
        let moved = start.iter().zip(direction.as_chunks::<3>().0);
        pressed.positions = moved.map(|(x, d)| [0, 1, 2].map(|axis| x[axis] + step * d[axis])).collect();
        pressed.interface.follow(&pressed.positions).unwrap();
        pressed.forces()
    };
    let h = 1e-6;
    let (ahead, behind) = (at(h), at(-h));
    let product: Vec<f64> =
        matrix.iter().map(|row| row.iter().zip(&direction).map(|(k, d)| k * d).sum::<f64>()).collect();
    let differences = ahead.iter().zip(&behind).map(|(ahead, behind)| -(ahead - behind) / (2.0 * h));
    let errors: Vec<f64> =
        differences.zip(&product).map(|(difference, product)| difference - product).collect();
    let error = largest(&errors) / largest(&product);
    assert!(error < 1e-7, "{error:e}");
    let pairs = (0..matrix.len()).flat_map(|p| (0..p).map(move |q| (p, q)));
    let turned = pairs.map(|(p, q)| (matrix[p][q] - matrix[q][p]).abs()).fold(0.0, crate::common::worse);
    assert_eq!(turned < 1e-9, is_symmetric, "{turned:e}");
}

#[test]
fn forces_and_moments_balance_and_friction_has_an_effect() {
    let mut pressed = Pressed::new(0.1, Weight::Cubic, &[]);
    pressed.slide_far();
    assert_balance(&mut pressed);
    let mut pressed = Pressed::on_strip(0.1, Weight::Cubic);
    pressed.slide_and_deform([0.03, 0.02, 0.001]);
    assert_balance(&mut pressed);
    let mut pressed = Pressed::new(0.1, Weight::Cubic, &[]);
    pressed.slide_and_deform([0.03, 0.02, 0.001]);
    assert_balance(&mut pressed);
    for k in 0..4 {
        // Against the motion, and μ times the pressure.
        let traction = pressed.traction(k);
        let ratio = length(traction) / pressed.normal_force(k);
        assert!((ratio - 0.1).abs() < 0.001, "{ratio}");
        assert!(0.03 * traction[0] + 0.02 * traction[1] < 0.0);
    }
}

#[test]
fn facets_draw_anchors_along_from_one_to_the_next() {
    let mut pressed = Pressed::on(0.1, ContactElement::NodeToFacet, &[]);
    let mut facets: Vec<Vec<u32>> = Vec::new();
    for _ in 0..20 {
        pressed.slide([0.05, 0.02, -0.001]);
        assert_balance(&mut pressed);
        for k in 0..4 {
            let (traction, normal) = (pressed.traction(k), pressed.normal_force(k));
            if normal > 0.0 {
                // That of the force itself, over its part along the slave's normal: it turns with the slip across a facet that is not flat.
                let ratio = length(traction) / normal;
                assert!((ratio - 0.1).abs() < 0.002, "{k} {ratio}");
                assert!(0.05 * traction[0] + 0.02 * traction[1] < 0.0, "{traction:?}");
            }
        }
        let report = pressed.accept();
        assert!(report.sliding >= 3 && report.dissipated > 0.0, "{report:?}");
        facets.push(pressed.interface.contacts().get(0).nodes[..3].to_vec());
        assert!(pressed.interface.anchors().unwrap().iter().flatten().all(|a| a.point.terms().len() <= 40));
    }
    facets.dedup();
    assert!(facets.len() > 1, "{facets:?}");
    // A restart from the numbers of the history has the same bits.
    let history = pressed.interface.history();
    let mut other = Pressed::on(0.1, ContactElement::NodeToFacet, &[]);
    other.interface.set_history(&history).unwrap();
    other.positions = pressed.positions.clone();
    for pressed in [&mut pressed, &mut other] {
        pressed.slide_and_deform([-1e-4, 2e-4, 0.0]);
    }
    assert_eq!(other.forces(), pressed.forces());
    // Facets have no images.
    let point = AffinePoint::new([(Carrier { node: 0, image: Some(0) }, 1.0)]).unwrap();
    let anchor = Some(Anchor::new(point));
    let refused = other.interface.set_anchors(Some(vec![anchor; 5])).unwrap_err();
    assert_eq!(refused.code(), "foreign-carrier");
}

fn assert_balance(pressed: &mut Pressed) {
    let forces = pressed.forces();
    let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
    for (f, x) in forces.as_chunks::<3>().0.iter().zip(&pressed.positions) {
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            force[axis] += f[axis];
            moment[axis] += x[next] * f[last] - x[last] * f[next];
        }
    }
    assert!(length(force) < 1e-13 * largest(&forces), "{force:?}");
    assert!(length(moment) < 8.0 * 1e-13 * largest(&forces), "{moment:?}");
}

#[test]
fn a_stuck_pair_keeps_its_traction_when_it_turns() {
    let mut pressed = Pressed::new(3.0, Weight::Cubic, &[]);
    pressed.slide_and_deform([0.03, 0.02, 0.001]);
    let before: Vec<Point> = (0..4).map(|k| pressed.traction(k)).collect();
    let (sine, cosine) = FRAC_PI_2.sin_cos();
    let turned = |[x, y, z]: Point| [cosine * x - sine * z, y, sine * x + cosine * z];
    for x in &mut pressed.positions {
        *x = turned(*x);
    }
    pressed.interface.refresh_pairing(&pressed.positions).unwrap();
    for (k, before) in before.into_iter().enumerate() {
        let after = pressed.traction(k);
        assert!(distance(after, turned(before)) < 1e-12 * length(before), "{after:?}");
    }
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|number| number.to_bits()).collect()
}

#[test]
fn without_a_coefficient_every_bit_is_frictionless() {
    let none: &'static DecayingCoefficient =
        Box::leak(Box::new(DecayingCoefficient::new(0.0, 0.0, 1.0).unwrap()));
    let varying = law(0.0).with_friction(Some(Coulomb::variable(none, 0.1, STIFFNESS).unwrap()));
    let facets = ContactElement::NodeToFacet;
    for element in
        Weight::ALL.map(|weight| ContactElement::default().with_weight(weight)).into_iter().chain([facets])
    {
        let mut pressed = Pressed::on(0.0, element, &[]);
        assert_eq!((pressed.law, pressed.interface.anchors()), (ContactLaw::penalty(PENALTY), None));
        let mut sliding = Pressed::on(0.1, element, &[]);
        for pressed in [&mut pressed, &mut sliding] {
            pressed.slide_and_deform([0.03, 0.02, 0.001]);
        }
        // An interface that never heard of friction.
        pressed.law = ContactLaw::penalty(PENALTY);
        let (forces, tangent) = (pressed.forces(), pressed.tangent().concat());
        pressed.law = law(0.0);
        assert_eq!(
            (bits(&pressed.forces()), bits(&pressed.tangent().concat())),
            (bits(&forces), bits(&tangent))
        );
        // With anchors of a step that had friction, too, and where a coefficient that may vary is 0.
        let with = sliding.forces();
        assert!(distance([forces[243], 0.0, 0.0], [with[243], 0.0, 0.0]) > 1e-3 * largest(&forces));
        for none in [law(0.0), varying] {
            sliding.law = none;
            assert!(sliding.interface.anchors().unwrap().iter().any(Option::is_some));
            assert_eq!(bits(&sliding.forces()), bits(&forces), "{element:?}");
            assert_eq!(bits(&sliding.tangent().concat()), bits(&tangent), "{element:?}");
        }
    }
}

#[test]
fn a_symmetric_tangent_is_symmetric() {
    let mut pressed = Pressed::new(0.1, Weight::Cubic, &[]);
    pressed.slide_and_deform([0.03, 0.02, 0.001]);
    pressed.law = pressed.law.with_tangent(Tangent::GaussNewton);
    let matrix = pressed.tangent();
    for p in 0..matrix.len() {
        for q in 0..p {
            assert!((matrix[p][q] - matrix[q][p]).abs() < 1e-10);
        }
    }
}

/// K v, Kᵀ v, the diagonal, and what is beside ε N Nᵀ, of slaves that stick, slip and have anchors out of reach, on both elements.
#[test]
fn the_tangent_with_friction_is_an_operator() {
    let planes = [SymmetryPlane::across(0, [0.0; 3])];
    let cubic = ContactElement::diffuse(SearchOptions::domains()).with_weight(Weight::Cubic);
    let cases: [(ContactElement, &[SymmetryPlane]); 3] =
        [(cubic, &[]), (cubic, &planes), (ContactElement::NodeToFacet, &[])];
    let mut unsymmetric = 0;
    for (element, planes) in cases {
        for (coefficient, is_far) in [(0.9, false), (0.05, false), (0.05, true)] {
            let mut pressed = Pressed::on(coefficient, element, planes);
            pressed.slide_and_deform([0.03, 0.02, 0.001]);
            if is_far {
                pressed.slide_far();
            }
            let matrix = pressed.tangent();
            let size = matrix.len();
            let dofs = DofMap::standard(size / 3);
            let v: Vec<f64> = (0..size).map(|k| (0.37 * k as f64).sin()).collect();
            let product = |law: &ContactLaw<'_>, is_rest: bool| {
                let made = TangentOperator::new(&pressed.interface, law, &dofs).unwrap();
                let mut made = if is_rest { made.curvature() } else { made };
                assert!(made.contacts() > 2);
                let [mut product, mut transposed, mut diagonal] = [(); 3].map(|()| vec![0.0; size]);
                made.add_product(&v, &mut product).unwrap();
                made.add_transposed_product(&v, &mut transposed).unwrap();
                made.add_diagonal(&mut diagonal).unwrap();
                [product, transposed, diagonal]
            };
            let [found, transposed, diagonal] = product(&pressed.law, false);
            let [rest, ..] = product(&pressed.law, true);
            let [normal, of_left, _] =
                product(&ContactLaw::penalty(PENALTY).with_tangent(Tangent::GaussNewton), false);
            assert_eq!(normal, of_left);
            let largest = matrix.iter().flatten().fold(0.0_f64, |largest, x| largest.max(x.abs()));
            for (row, entries) in matrix.iter().enumerate() {
                let expected: f64 = entries.iter().zip(&v).map(|(entry, v)| entry * v).sum();
                let of_column: f64 = (0..size).map(|k| matrix[k][row] * v[k]).sum();
                let tolerance = 1e-13 * largest;
                assert!((transposed[row] - of_column).abs() <= 10.0 * tolerance, "{}", transposed[row]);
                assert!((found[row] - expected).abs() <= 10.0 * tolerance, "{} {expected}", found[row]);
                assert!((diagonal[row] - entries[row]).abs() <= tolerance);
                assert!((found[row] - rest[row] - normal[row]).abs() <= 10.0 * tolerance);
                unsymmetric +=
                    (0..row).filter(|&k| (entries[k] - matrix[k][row]).abs() > 1e-6 * largest).count();
            }
        }
    }
    assert!(unsymmetric > 100, "{unsymmetric}");
}
