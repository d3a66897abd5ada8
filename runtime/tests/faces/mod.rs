//! Forces, balance and tangent of contact over faces.

mod edges;
mod friction;
mod input;
mod law;
mod layers;
mod points;
mod window;

use diffuse_contact::assembly::{AssemblyError, ContactLaw, DofMap, Tangent};
use diffuse_contact::faces::*;
use diffuse_contact::interface::{ContactElement, InterfaceError, InterfaceOptions};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Mode, Point, Weight};
use nalgebra::Vector3;

/// Nodes and facets of a grid over [0, 6]², its nodes placed by `place`, seen from above or from below.
struct Grid {
    positions: Vec<Point>,
    facets: Vec<Facet>,
}

impl Grid {
    fn new(cells: usize, first: usize, from_above: bool, place: impl Fn(f64, f64) -> Point) -> Self {
        let n = cells + 1;
        let size = 6.0 / cells as f64;
        let positions = (0..n * n).map(|k| place((k % n) as f64 * size, (k / n) as f64 * size)).collect();
        let corner = |k: usize| first + k % cells + n * (k / cells);
        let facets =
            (0..cells * cells).map(corner).map(|k| Facet::Quadrilateral([k, k + 1, k + n + 1, k + n]));
        let facets = facets.map(|facet| if from_above { facet } else { facet.flipped() }).collect();
        Self { positions, facets }
    }

    fn in_triangles(mut self) -> Self {
        let halves = |facet: &Facet| match *facet {
            Facet::Quadrilateral([a, b, c, d]) => {
                vec![Facet::Triangle([a, b, c]), Facet::Triangle([a, c, d])]
            }
            triangle @ Facet::Triangle(_) => vec![triangle],
        };
        self.facets = self.facets.iter().flat_map(halves).collect();
        self
    }
}

/// A slave above a master.
struct Pair {
    positions: Vec<Point>,
    master: Vec<Facet>,
    slave: Vec<Facet>,
    first_slave: usize,
}

impl Pair {
    fn new(
        [below, above]: [usize; 2],
        triangles: bool,
        low: impl Fn(f64, f64) -> Point,
        high: impl Fn(f64, f64) -> Point,
    ) -> Self {
        let first_slave = (below + 1) * (below + 1);
        let (mut master, mut slave) =
            (Grid::new(below, 0, true, low), Grid::new(above, first_slave, false, high));
        if triangles {
            (master, slave) = (master.in_triangles(), slave.in_triangles());
        }
        let positions = [master.positions, slave.positions].concat();
        Self { positions, master: master.facets, slave: slave.facets, first_slave }
    }

    fn interface(&self, element: ContactElement, rule: FaceRule) -> FaceInterface {
        self.try_interface(element, rule).unwrap()
    }

    fn try_interface(
        &self,
        element: ContactElement,
        rule: FaceRule,
    ) -> Result<FaceInterface, InterfaceError> {
        let master = MasterSurface::new(&self.positions, self.master.clone()).unwrap();
        let options = FaceOptions::new(InterfaceOptions::default().with_element(element)).with_rule(rule);
        FaceInterface::new(master, &self.slave, &self.positions, options)
    }

    fn forces(&self, contacts: &FaceContacts) -> Vec<Point> {
        let mut forces = vec![0.0; 3 * self.positions.len()];
        contacts.add_forces(&DofMap::standard(self.positions.len()), &mut forces).unwrap();
        forces.as_chunks::<3>().0.to_vec()
    }

    /// Forces and moments of contact add up to nothing.
    fn assert_balance(&self, forces: &[Point]) {
        self.assert_balance_of(forces, 5.0);
    }

    /// The same of more force than this.
    fn assert_balance_of(&self, forces: &[Point], least: f64) {
        let size: f64 = forces.iter().map(|&force| Vector3::from(force).norm()).sum();
        let zero = Vector3::zeros();
        let force = forces.iter().fold(zero, |sum, &force| sum + Vector3::from(force));
        let moments = forces.iter().zip(&self.positions);
        let moment = moments.fold(zero, |sum, (&f, &x)| sum + Vector3::from(x).cross(&Vector3::from(f)));
        assert!(
            size > least && force.norm() < 1e-13 * size && moment.norm() < 1e-12 * size,
            "{force:?} {moment:?}"
        );
    }
}

/// Each of one with each of the other.
fn pairs<T: Copy, U: Copy>(
    one: impl IntoIterator<Item = T>,
    other: impl IntoIterator<Item = U> + Clone,
) -> impl Iterator<Item = (T, U)> {
    one.into_iter().flat_map(move |a| other.clone().into_iter().map(move |b| (a, b)))
}

fn elements() -> Vec<ContactElement> {
    let smooth = Weight::ALL.map(|weight| ContactElement::default().with_weight(weight));
    smooth.into_iter().chain([ContactElement::NodeToFacet]).collect()
}

/// Every node of both sides carries the part of a uniform pressure that its own shape function says, whatever the meshes.
#[test]
fn a_uniform_pressure_arrives_at_both_sides() {
    for [below, above] in [[6, 4], [5, 8], [6, 6]] {
        for triangles in [false, true] {
            let flat = |z: f64| move |x: f64, y: f64| [x, y, z];
            let pair = Pair::new([below, above], triangles, flat(0.0), flat(-0.02));
            let areas = |facets: &[Facet]| {
                diffuse_contact::surface::tributary_areas(&pair.positions, facets).unwrap()
            };
            let (of_master, of_slave) = (areas(&pair.master), areas(&pair.slave));
            for element in elements() {
                for (rule, pressures) in pairs(FaceRule::ALL, FacePressures::ALL) {
                    let mut interface = pair.interface(element, rule);
                    interface.set_pressures(pressures);
                    let report = interface.refresh(&pair.positions).unwrap();
                    assert_eq!((report.faces, report.paired), (pair.slave.len(), report.points));
                    let contacts = interface.evaluate(&ContactLaw::penalty(50.0), Mode::Gradient).unwrap();
                    assert_eq!(contacts.missed(), 0);
                    for (node, force) in pair.forces(contacts).into_iter().enumerate() {
                        let expected = [0.0, 0.0, of_slave[node] - of_master[node]];
                        for axis in 0..3 {
                            assert!(
                                (force[axis] - expected[axis]).abs() < 1e-12,
                                "{node} {force:?} {expected:?} {element:?} {rule:?} {pressures:?}"
                            );
                        }
                    }
                }
            }
        }
    }
}

/// Two bumps, the upper one smaller than the lower one and pressed into it.
fn bumps(triangles: bool) -> Pair {
    let height = |x: f64, y: f64| 0.3 * (0.6 * x + 0.2).sin() * (0.5 * y).cos();
    let low = move |x: f64, y: f64| [x + 0.05 * (2.0 * y).sin(), y, height(x, y)];
    let high = move |x: f64, y: f64| {
        let (x, y) = (0.8 + 0.7 * x, 0.7 + 0.75 * y + 0.04 * (3.0 * x).sin());
        [x, y, height(x, y) - 0.12 + 0.04 * x]
    };
    Pair::new([7, 5], triangles, low, high)
}

/// One row of each: fits take auxiliary points between their nodes.
fn strips() -> Pair {
    let mut pair = bumps(false);
    (pair.master, pair.slave) = (pair.master[21..28].to_vec(), pair.slave[10..15].to_vec());
    pair
}

#[test]
fn forces_and_moments_balance() {
    let pair = strips();
    let mut interface = pair.interface(ContactElement::default(), FaceRule::Second);
    interface.refresh(&pair.positions).unwrap();
    let law = ContactLaw::penalty(200.0);
    pair.assert_balance(&pair.forces(interface.evaluate(&law, Mode::Gradient).unwrap()));
    for (element, pressures) in pairs(elements(), FacePressures::ALL) {
        for triangles in [false, true] {
            let pair = bumps(triangles);
            let mut interface = pair.interface(element, FaceRule::Second);
            interface.set_pressures(pressures);
            interface.refresh(&pair.positions).unwrap();
            let contacts = interface.evaluate(&ContactLaw::penalty(50.0), Mode::Gradient).unwrap();
            assert!(contacts.active() > 8 && contacts.active() < pair.positions.len() - pair.first_slave);
            pair.assert_balance(&pair.forces(contacts));
        }
    }
}

/// How nine nodes become faces of second order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Second {
    Triangle6,
    Quadrilateral8,
    Quadrilateral9,
}

impl Second {
    const ALL: [Self; 3] = [Self::Triangle6, Self::Quadrilateral8, Self::Quadrilateral9];

    /// Facets and faces of three by three nodes, row by row, seen from above.
    fn of(self, [a, b, c, d, e, f, g, h, i]: [usize; 9]) -> (Vec<Facet>, Vec<QuadraticFace>) {
        let (triangle, quadrilateral) = (Facet::Triangle, Facet::Quadrilateral);
        let face = |nodes: &[usize]| QuadraticFace::new(nodes).unwrap();
        match self {
            Self::Triangle6 => {
                let lower = [[a, b, e], [b, c, f], [f, i, e], [b, f, e]].map(triangle);
                let upper = [[a, e, d], [e, i, h], [h, g, d], [e, h, d]].map(triangle);
                ([lower, upper].concat(), vec![face(&[a, c, i, b, f, e]), face(&[a, i, g, e, h, d])])
            }
            Self::Quadrilateral8 => {
                let corners = [[a, b, d], [c, f, b], [i, h, f], [g, d, h]].map(triangle);
                let facets = [&corners[..], &[quadrilateral([b, f, h, d])]].concat();
                (facets, vec![face(&[a, c, i, g, b, f, h, d])])
            }
            Self::Quadrilateral9 => {
                let facets = [[a, b, e, d], [b, c, f, e], [e, f, i, h], [d, e, h, g]].map(quadrilateral);
                (facets.to_vec(), vec![face(&[a, c, i, g, b, f, h, d, e])])
            }
        }
    }

    /// The faces of a grid over [0, 6]² with an even number of cells.
    fn grid(self, cells: usize, first: usize, from_above: bool) -> (Vec<Facet>, Vec<QuadraticFace>) {
        let n = cells + 1;
        let (mut facets, mut faces) = (Vec::new(), Vec::new());
        for (i, j) in (0..cells / 2).flat_map(|j| (0..cells / 2).map(move |i| (2 * i, 2 * j))) {
            let (own, of) = self.of(std::array::from_fn(|k| first + i + k % 3 + n * (j + k / 3)));
            facets.extend(own.into_iter().map(|facet| if from_above { facet } else { facet.flipped() }));
            faces.extend(of);
        }
        (facets, faces)
    }
}

/// The bumps with faces of second order on both sides.
fn bumps_of_second_order(second: Second) -> (Pair, Vec<QuadraticFace>) {
    let height = |x: f64, y: f64| 0.3 * (0.6 * x + 0.2).sin() * (0.5 * y).cos();
    let low = move |x: f64, y: f64| [x + 0.05 * (2.0 * y).sin(), y, height(x, y)];
    let high = move |x: f64, y: f64| {
        let (x, y) = (0.8 + 0.7 * x, 0.7 + 0.75 * y + 0.04 * (3.0 * x).sin());
        [x, y, height(x, y) - 0.12 + 0.04 * x]
    };
    let mut pair = Pair::new([6, 4], false, low, high);
    let (master, mut faces) = second.grid(6, 0, true);
    let (slave, others) = second.grid(4, pair.first_slave, false);
    (pair.master, pair.slave) = (master, slave);
    faces.extend(others);
    (pair, faces)
}

/// Curved faces carry what is on their line of force.
#[test]
fn forces_and_moments_of_faces_of_second_order_balance() {
    for (element, second) in pairs(elements(), Second::ALL) {
        let (pair, faces) = bumps_of_second_order(second);
        let mut interface = pair.interface(element, FaceRule::Second);
        let of_facets = interface.refresh(&pair.positions).map(|_| ()).and_then(|()| {
            let contacts = interface.evaluate(&ContactLaw::penalty(50.0), Mode::Gradient)?;
            Ok(pair.forces(contacts))
        });
        interface.set_quadratic_faces(&faces).unwrap();
        interface.refresh(&pair.positions).unwrap();
        let contacts = interface.evaluate(&ContactLaw::penalty(50.0), Mode::Gradient).unwrap();
        assert!(contacts.active() > 8 && contacts.missed() == 0);
        let forces = pair.forces(contacts);
        assert_ne!(of_facets.unwrap(), forces);
        pair.assert_balance(&forces);
        interface.set_pressures(FacePressures::Points);
        let of_points = interface.evaluate(&ContactLaw::penalty(50.0), Mode::Gradient).unwrap();
        pair.assert_balance(&pair.forces(of_points));
    }
    let (pair, _) = bumps_of_second_order(Second::Triangle6);
    let mut interface = pair.interface(ContactElement::default(), FaceRule::Second);
    let beyond = QuadraticFace::new(&[0, 1, 2, 3, 4, 10_000]).unwrap();
    assert!(matches!(interface.set_quadratic_faces(&[beyond]), Err(InterfaceError::Surface(_))));
    let twice = QuadraticFace::new(&[0, 1, 2, 3, 4, 1]).unwrap();
    assert!(matches!(interface.set_quadratic_faces(&[twice]), Err(InterfaceError::Surface(_))));
    assert_eq!(QuadraticFace::new(&[0, 1, 2, 3]), None);
}

/// K by the positions of all nodes, against differences of the forces with the points held.
#[test]
fn the_tangent_is_exact_with_the_points_held() {
    for (k, element) in elements().into_iter().enumerate() {
        assert_tangent(&bumps(k % 2 == 1), element, &[]);
    }
    assert_tangent(&bumps(false), ContactElement::NodeToFacet, &[]);
    assert_tangent(&strips(), ContactElement::default(), &[]);
    for second in Second::ALL {
        let (pair, faces) = bumps_of_second_order(second);
        assert_tangent(&pair, ContactElement::default(), &faces);
    }
}

fn assert_tangent(pair: &Pair, element: ContactElement, faces: &[QuadraticFace]) {
    let mut interface = pair.interface(element, FaceRule::Second);
    interface.set_quadratic_faces(faces).unwrap();
    interface.refresh(&pair.positions).unwrap();
    for pressures in FacePressures::ALL {
        interface.set_pressures(pressures);
        assert_tangent_at(pair, &mut interface, &ContactLaw::penalty(50.0), &pair.positions, 31);
    }
}

/// Both bumps as one surface in contact with itself, made while they were apart: each is integrated over the other.
#[test]
fn the_tangent_of_self_contact_is_exact_with_the_points_held() {
    for (element, triangles) in [(ContactElement::default(), false), (ContactElement::NodeToFacet, true)] {
        let pair = bumps(triangles);
        let surface = [&pair.master[..], &pair.slave].concat();
        let mut apart = pair.positions.clone();
        apart[pair.first_slave..].iter_mut().for_each(|x| x[2] += 0.5);
        let surface = MasterSurface::new(&apart, surface).unwrap();
        let options = FaceOptions::new(InterfaceOptions::default().with_element(element));
        let mut interface = FaceInterface::self_contact(surface, &apart, options).unwrap();
        interface.refresh(&pair.positions).unwrap();
        let law = ContactLaw::penalty(50.0);
        let pressed = interface.evaluate(&law, Mode::Gradient).unwrap().nodes().to_vec();
        let sides =
            pressed.iter().filter(|node| node.pressure > 0.0).map(|node| node.slave < pair.first_slave);
        let (low, high): (Vec<bool>, Vec<bool>) = sides.partition(|&is_low| is_low);
        assert!(low.len() > 8 && high.len() > 8);
        pair.assert_balance(&pair.forces(interface.contacts()));
        for pressures in FacePressures::ALL {
            interface.set_pressures(pressures);
            assert_tangent_at(&pair, &mut interface, &law, &pair.positions, 13);
        }
    }
}

/// Of every so many columns. All blocks lie within what the interface says that couples.
fn assert_tangent_at(
    pair: &Pair,
    interface: &mut FaceInterface,
    law: &ContactLaw<'_>,
    positions: &[Point],
    every: usize,
) {
    let dofs = DofMap::standard(positions.len());
    let size = dofs.equations();
    let mut dense = vec![0.0; size * size];
    interface.update(positions).unwrap();
    let contacts = interface.evaluate(law, Mode::Hessian).unwrap().clone();
    contacts
        .for_each_tangent(Tangent::Exact, |block| {
            let holds = |clique: &[u32]| block.columns.iter().all(|node| clique.binary_search(node).is_ok());
            assert!(interface.cliques().any(holds));
        })
        .unwrap();
    assert_products(&contacts, &dofs);
    assert_products(
        &contacts,
        &DofMap::numbering(positions.len(), |node, axis| (node + axis) % 5 != 0).unwrap(),
    );
    for (row, column, value) in contacts.triplets(Tangent::Exact, &dofs).unwrap().iter() {
        dense[row * size + column] += value;
    }
    let largest = dense.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    assert!(largest > 1.0);
    for column in (0..size).step_by(every) {
        let mut at = |step: f64| {
            let mut moved = positions.to_vec();
            moved[column / 3][column % 3] += step;
            // So near to where the faces were cut their pieces stay, and what they are cut into is not differentiated.
            interface.update(&moved).unwrap();
            let forces = pair.forces(interface.evaluate(law, Mode::Gradient).unwrap());
            forces.as_flattened().to_vec()
        };
        let (after, before) = (at(1e-6), at(-1e-6));
        for row in 0..size {
            let expected = -(after[row] - before[row]) / 2e-6;
            let found = dense[row * size + column];
            assert!((found - expected).abs() < 2e-7 * largest, "{row} {column}: {found} {expected}");
        }
    }
}

/// The operator is the assembled matrix.
fn assert_products(contacts: &FaceContacts, dofs: &DofMap) {
    let v: Vec<f64> = (0..dofs.equations()).map(|k| (0.37 * k as f64 + 0.1).sin()).collect();
    for tangent in Tangent::ALL {
        let mut expected = vec![1.0; v.len()];
        let mut sizes = vec![1.0; v.len()];
        for (row, column, value) in contacts.triplets(tangent, dofs).unwrap().iter() {
            expected[row] += value * v[column];
            sizes[row] += (value * v[column]).abs();
        }
        let mut found = vec![1.0; v.len()];
        contacts.add_product(tangent, dofs, &v, &mut found).unwrap();
        let largest = sizes.iter().fold(0.0_f64, |largest, x| largest.max(*x));
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() <= 1e-13 * largest, "{tangent:?}: {found} {expected}");
        }
    }
}

/// Points that move with the cuts add what the rule does not integrate: the finer rule the less. Pieces stay while nobody has moved far.
#[test]
fn cutting_anew_changes_forces_by_the_error_of_the_rule() {
    const FAR: f64 = 1e-4;
    let law = ContactLaw::penalty(50.0);
    let pair = bumps(false);
    let moved = |(k, &[x, y, z]): (usize, &Point)| {
        let by = if k < pair.first_slave { 0.0 } else { FAR };
        [x + 0.03 * by, y - 0.02 * by, z + 0.01 * by]
    };
    let moved: Vec<Point> = pair.positions.iter().enumerate().map(moved).collect();
    let error = |rule| {
        let forces_of = |cut_at: &[Point]| {
            let mut interface = pair.interface(ContactElement::default(), rule);
            interface.refresh(cut_at).unwrap();
            interface.update(&moved).unwrap();
            pair.forces(interface.evaluate(&law, Mode::Gradient).unwrap())
        };
        let (held, anew) = (forces_of(&pair.positions), forces_of(&moved));
        let sizes = held.iter().zip(&anew).map(|(a, b)| (Vector3::from(*a) - Vector3::from(*b)).norm());
        let all: f64 = anew.iter().map(|force| Vector3::from(*force).norm()).sum();
        sizes.sum::<f64>() / all
    };
    let [second, fourth] = FaceRule::ALL.map(error);
    assert!(second < 5e-3 * FAR && fourth < second && fourth > 1e-12, "{second:e} {fourth:e}");
}

/// A slave that hangs over the master's end: half of its area carries.
#[test]
fn what_lies_beyond_the_master_carries_nothing() {
    let low = |x: f64, y: f64| [0.5 * x, y, 0.0];
    let high = |x: f64, y: f64| [x, y, -0.01];
    let pair = Pair::new([6, 6], false, low, high);
    for element in elements() {
        let mut interface = pair.interface(element, FaceRule::Second);
        interface.refresh(&pair.positions).unwrap();
        let contacts = interface.evaluate(&ContactLaw::penalty(100.0), Mode::Gradient).unwrap();
        let sum: f64 = contacts.nodes().iter().map(NodeContact::force).sum();
        assert!((sum - 18.0).abs() < 1e-10, "{sum}");
        let moment: f64 = pair.forces(contacts)[pair.first_slave..]
            .iter()
            .zip(&pair.positions[pair.first_slave..])
            .map(|(force, x)| force[2] * x[0])
            .sum();
        assert!((moment - 27.0).abs() < 1e-10, "{moment}");
        assert!(contacts.nodes().iter().any(|node| !node.outcome.is_contact()));
    }
}

/// A ball's faces against a ball: with the slave's own smooth surface the gap is that of the balls, with flat faces h²/8R off.
#[test]
fn points_lie_on_the_slaves_own_smooth_surface() {
    let cap = |radius: f64, sign: f64| {
        move |x: f64, y: f64| {
            let (x, y) = (0.4 * (x - 3.0), 0.4 * (y - 3.0));
            [x, y, sign * (radius - (radius * radius - x * x - y * y).sqrt())]
        }
    };
    // The slave lies in the hollow of the master, touching everywhere.
    let pair = Pair::new([9, 6], false, cap(5.0, 1.0), cap(5.0, 1.0));
    let worst = |element| {
        let mut interface = pair.interface(element, FaceRule::Second);
        assert_eq!(interface.straight(), 0);
        interface.refresh(&pair.positions).unwrap();
        let contacts = interface.evaluate(&ContactLaw::penalty(1.0), Mode::Value).unwrap();
        assert!(contacts.nodes().iter().all(|node| node.outcome.is_contact()));
        contacts.nodes().iter().map(|node| node.gap.abs()).fold(0.0, crate::common::worse)
    };
    let (smooth, flat) = (worst(ContactElement::default()), worst(ContactElement::NodeToFacet));
    // h²/8R is 4e-3 for faces of 0.4.
    assert!(smooth < 2e-4 && flat > 2e-3, "{smooth:e} {flat:e}");
}

#[test]
fn derivatives_that_were_not_evaluated_are_refused() {
    let pair = bumps(false);
    let mut interface = pair.interface(ContactElement::default(), FaceRule::Second);
    interface.refresh(&pair.positions).unwrap();
    let (law, dofs) = (ContactLaw::penalty(50.0), DofMap::standard(pair.positions.len()));
    let refused = |found, needed| AssemblyError::NotDerived { needed, found };
    let contacts = interface.evaluate(&law, Mode::Value).unwrap();
    let mut forces = vec![0.0; dofs.equations()];
    let error = contacts.add_forces(&dofs, &mut forces).unwrap_err();
    assert_eq!(error, refused(Mode::Value, Mode::Gradient));
    let contacts = interface.evaluate(&law, Mode::Gradient).unwrap();
    assert!(!contacts.triplets(Tangent::GaussNewton, &dofs).unwrap().is_empty());
    let error = contacts.triplets(Tangent::Exact, &dofs).unwrap_err();
    assert_eq!(error, refused(Mode::Gradient, Mode::Hessian));
    let (v, mut product) = (vec![1.0; dofs.equations()], vec![7.0; dofs.equations()]);
    let error = contacts.add_product(Tangent::Exact, &dofs, &v, &mut product).unwrap_err();
    assert_eq!(error, refused(Mode::Gradient, Mode::Hessian));
    let error = contacts.add_product(Tangent::GaussNewton, &dofs, &v[1..], &mut product).unwrap_err();
    assert_eq!(error.code(), "output-length");
    let error = contacts.add_product(Tangent::GaussNewton, &dofs, &v, &mut product[1..]).unwrap_err();
    assert_eq!(error.code(), "output-length");
    let mut endless = v.clone();
    endless[5] = f64::NAN;
    let error = contacts.add_product(Tangent::GaussNewton, &dofs, &endless, &mut product).unwrap_err();
    assert_eq!(error.code(), "non-finite-input");
    assert!(product.iter().all(|&x| x == 7.0));
    let largest: Vec<f64> = (0..v.len()).map(|k| 1e308 * (0.7 * k as f64).sin()).collect();
    let error = contacts.add_product(Tangent::GaussNewton, &dofs, &largest, &mut product).unwrap_err();
    assert_eq!(error.code(), "overflow");
}

#[test]
fn other_rules_than_domains_are_refused() {
    let pair = bumps(false);
    let master = MasterSurface::new(&pair.positions, pair.master.clone()).unwrap();
    let element = ContactElement::diffuse(diffuse_contact::neighbourhood::SearchOptions::default());
    let options = FaceOptions::new(InterfaceOptions::default().with_element(element));
    let error = FaceInterface::new(master, &pair.slave, &pair.positions, options).unwrap_err();
    assert_eq!(error, InterfaceError::FacesNeedDomains);
}

/// Whatever came before, results are those of the positions.
#[test]
fn there_is_no_history() {
    let pair = bumps(false);
    let law = ContactLaw::penalty(50.0);
    let mut fresh = pair.interface(ContactElement::default(), FaceRule::Second);
    fresh.refresh(&pair.positions).unwrap();
    let expected = pair.forces(fresh.evaluate(&law, Mode::Gradient).unwrap());
    let mut used = pair.interface(ContactElement::default(), FaceRule::Second);
    let shifted: Vec<Point> = pair
        .positions
        .iter()
        .enumerate()
        .map(|(k, &[x, y, z])| if k < pair.first_slave { [x, y, z] } else { [x + 0.4, y - 0.3, z] })
        .collect();
    assert!(used.refresh(&shifted).unwrap().grown);
    used.evaluate(&law, Mode::Hessian).unwrap();
    assert!(used.update(&pair.positions).unwrap().grown);
    let report = used.update(&shifted).unwrap();
    assert!(!report.grown, "it has been there");
    let nearly: Vec<Point> = shifted.iter().map(|x| x.map(|x| x + 1e-6)).collect();
    assert_eq!(used.update(&nearly).unwrap(), report);
    used.update(&pair.positions).unwrap();
    assert_eq!(pair.forces(used.evaluate(&law, Mode::Gradient).unwrap()), expected);
}
