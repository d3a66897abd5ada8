//! K v without K, against the assembled K.

use diffuse_contact::assembly::{
    AssemblyError, ContactLaw, CsrPattern, DofMap, NormalLaw, NormalPressure, TabulatedPressure, Tangent,
    TangentOperator,
};
use diffuse_contact::interface::{ContactElement, ContactInterface, InterfaceError, InterfaceOptions};
use diffuse_contact::neighbourhood::SearchOptions;
use diffuse_contact::surface::SymmetryPlane;
use diffuse_contact::{Coulomb, Mode, Point, Weight};

use crate::common::{Mesh, Scene, Uniform};
use crate::interface_where::{scene, variants};

const TOLERANCE: f64 = 1e-13;

fn vector(length: usize) -> Vec<f64> {
    (0..length).map(|k| (0.37 * k as f64 + 0.1).sin()).collect()
}

/// K v, |K| |v| and the diagonal of K of the assembled tangent.
fn assembled(
    interface: &mut ContactInterface,
    law: &ContactLaw<'_>,
    dofs: &DofMap,
    v: &[f64],
) -> [Vec<f64>; 3] {
    let contacts = interface.evaluate(Mode::Hessian).unwrap();
    let pattern = CsrPattern::union(contacts, dofs).unwrap();
    let mut values = vec![0.0; pattern.entries()];
    pattern.fill(contacts, law, &mut values).unwrap();
    let mut all = [vec![0.0; v.len()], vec![0.0; v.len()], vec![0.0; v.len()]];
    for row in 0..v.len() {
        for place in pattern.row_offsets()[row]..pattern.row_offsets()[row + 1] {
            let (column, value) = (pattern.columns()[place], values[place]);
            all[0][row] += value * v[column as usize];
            all[1][row] += (value * v[column as usize]).abs();
            if column as usize == row {
                all[2][row] += value;
            }
        }
    }
    all
}

fn check(scene: &mut Scene, law: &ContactLaw<'_>, dofs: &DofMap, what: &str) {
    let v = vector(dofs.equations());
    let [expected, sizes, diagonal] = assembled(&mut scene.interface, law, dofs, &v);
    let mut operator = TangentOperator::new(&scene.interface, law, dofs).unwrap();
    assert!(operator.contacts() > 20, "{what}: {}", operator.contacts());
    let mut found = vec![0.0; v.len()];
    operator.add_product(&v, &mut found).unwrap();
    let largest = |x: &[f64]| x.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let worst =
        |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - y).abs()).fold(0.0, crate::common::worse);
    let error = worst(&found, &expected) / largest(&sizes);
    assert!(error < TOLERANCE, "{what}: {error:e}");
    // The same again, added.
    operator.add_product(&v, &mut found).unwrap();
    assert!(worst(&found, &expected.iter().map(|x| 2.0 * x).collect::<Vec<_>>()) < 3e-13 * largest(&sizes));
    let mut found = vec![0.0; v.len()];
    operator.add_diagonal(&mut found).unwrap();
    let error = worst(&found, &diagonal) / largest(&diagonal);
    assert!(error < TOLERANCE, "{what}, diagonal: {error:e}");
}

#[test]
fn products_are_those_of_the_assembled_tangent() {
    for (number, options) in variants().into_iter().enumerate() {
        let mut scene = scene(options);
        let nodes = scene.positions.len();
        let held = DofMap::numbering(nodes, |node, axis| (node + axis) % 5 != 0).unwrap();
        let multipliers: Vec<f64> = (0..700).map(|k| f64::from(k % 5) * 0.01).collect();
        let law = ContactLaw::penalty(1.5);
        check(&mut scene, &law, &DofMap::standard(nodes), &format!("variant {number}"));
        // A law of one's own is as stiff as its table is steep.
        let stiffer = TabulatedPressure::new(&[-1.0, -0.05, 0.0, 1.0], &[4.0, 0.1, 0.0, 0.0]).unwrap();
        let own = law.with_normal(Some(&stiffer));
        check(&mut scene, &own, &held, &format!("variant {number}, a law of one's own"));
        let law = law.with_multipliers(Some(&multipliers));
        check(&mut scene, &law, &held, &format!("variant {number}, multipliers"));
        let law = law.with_tangent(Tangent::GaussNewton);
        check(&mut scene, &law, &held, &format!("variant {number}, Gauss-Newton"));
    }
}

/// Slaves about a quarter of a wavy master that goes on behind two planes.
pub(crate) fn quarter(weight: Weight) -> Scene {
    let height = |x: f64, y: f64| 0.3 * (0.5 * x).cos() * (0.4 * y).cos();
    let mesh = Mesh::grid([14, 14], [false; 2], |s, t| [5.0 * s, 5.0 * t, height(5.0 * s, 5.0 * t)]);
    let mut random = Uniform(5);
    let slaves: Vec<Point> = (0..150)
        .map(|_| {
            let [x, y] = [random.next(), random.next()].map(|x| 2.0 * x * x);
            [x, y, height(x, y) - 0.02 - 0.02 * random.next()]
        })
        .collect();
    let element = ContactElement::diffuse(SearchOptions::domains()).with_weight(weight);
    let mut scene = mesh.scene(&slaves, InterfaceOptions::default().with_element(element));
    let planes = [0, 1].map(|axis| SymmetryPlane::across(axis, [0.0; 3]));
    scene.interface.set_symmetry(&planes).unwrap();
    scene.refresh();
    scene
}

/// K = ε N Nᵀ − f M
#[test]
fn the_curvature_is_what_gauss_newton_leaves_out() {
    for (number, options) in variants().into_iter().enumerate() {
        let scene = scene(options);
        let dofs = DofMap::standard(scene.positions.len());
        let v = vector(dofs.equations());
        let law = ContactLaw::penalty(1.5);
        let product = |law: &ContactLaw<'_>, is_rest: bool| {
            let operator = TangentOperator::new(&scene.interface, law, &dofs).unwrap();
            let mut operator = if is_rest { operator.curvature() } else { operator };
            let mut product = vec![0.0; v.len()];
            operator.add_product(&v, &mut product).unwrap();
            product
        };
        let (whole, rest) = (product(&law, false), product(&law, true));
        let law = law.with_tangent(Tangent::GaussNewton);
        let gauss_newton = product(&law, false);
        let largest = whole.iter().chain(&gauss_newton).fold(0.0_f64, |largest, x| largest.max(x.abs()));
        for ((whole, rest), other) in whole.iter().zip(&rest).zip(&gauss_newton) {
            let error = (whole - rest - other).abs();
            assert!(error <= TOLERANCE * largest, "variant {number}: {error:e} of {largest:e}");
        }
        assert!(rest.iter().any(|&x| x != 0.0) && product(&law, true).iter().all(|&x| x == 0.0));
    }
}

#[test]
fn what_images_contribute_goes_back_to_their_nodes() {
    for weight in [Weight::Cubic, Weight::CubicInterpolating, Weight::WendlandC2] {
        let mut scene = quarter(weight);
        let dofs = DofMap::standard(scene.positions.len());
        check(&mut scene, &ContactLaw::penalty(3.0), &dofs, &format!("{weight:?}"));
    }
}

#[cfg(feature = "ad")]
#[test]
fn what_auxiliary_points_contribute_goes_to_their_nodes() {
    for (weight, height) in Weight::ALL.into_iter().flat_map(|weight| [(weight, 0.8), (weight, 0.05)]) {
        let mut scene = crate::strips::quarter(weight, height);
        let dofs = DofMap::standard(scene.positions.len());
        check(&mut scene, &ContactLaw::penalty(3.0), &dofs, &format!("{weight:?}"));
    }
}

#[test]
fn the_number_of_threads_makes_no_difference() {
    let law = ContactLaw::penalty(2.0);
    let products = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let scene = scene(InterfaceOptions::default());
        let dofs = DofMap::standard(scene.positions.len());
        pool.install(|| {
            let mut operator = TangentOperator::new(&scene.interface, &law, &dofs).unwrap();
            let mut found = vec![0.0; dofs.equations()];
            operator.add_product(&vector(dofs.equations()), &mut found).unwrap();
            operator.add_diagonal(&mut found).unwrap();
            found
        })
    };
    assert_eq!(products(1), products(3));
}

/// A law with a hole.
#[derive(Debug)]
struct NoNumber;

impl NormalLaw for NoNumber {
    fn pressure(&self, _slave: usize, _gap: f64) -> NormalPressure {
        NormalPressure { pressure: f64::NAN, by_gap: 0.0 }
    }
}

#[test]
fn what_cannot_be_multiplied_is_refused() {
    let scene = scene(InterfaceOptions::default());
    let nodes = scene.positions.len();
    let dofs = DofMap::standard(nodes);
    let law = ContactLaw::penalty(1.0);
    let refused = TangentOperator::new(&scene.interface, &law.with_normal(Some(&NoNumber)), &dofs);
    assert!(
        matches!(refused, Err(InterfaceError::Law(AssemblyError::InvalidPressure { .. }))),
        "{refused:?}"
    );
    let operator = |law: &ContactLaw<'_>, dofs: &DofMap| TangentOperator::new(&scene.interface, law, dofs);
    let friction = law.with_friction(Some(Coulomb::new(0.3, 1.0).unwrap()));
    let refused = |result: Result<TangentOperator, InterfaceError>| result.unwrap_err().code();
    // Nothing was accepted; without kernels there is nothing that could be.
    let expected = if cfg!(feature = "friction") { "no-slip" } else { "no-friction-kernels" };
    assert_eq!(refused(operator(&friction, &dofs)), expected);
    assert_eq!(refused(operator(&ContactLaw::penalty(-1.0), &dofs)), "invalid-penalty");
    assert_eq!(refused(operator(&law.with_multipliers(Some(&[0.0])), &dofs)), "multiplier-count");
    assert_eq!(refused(operator(&law, &DofMap::standard(10))), "unknown-node");

    let mut operator = operator(&law, &dofs).unwrap();
    assert!(operator.bytes() > 8 * 45 * operator.contacts());
    let (v, mut product) = (vector(3 * nodes), vec![7.0; 3 * nodes]);
    let short = AssemblyError::OutputLength { what: "entries of v", found: 4, expected: 3 * nodes };
    assert_eq!(operator.add_product(&v[..4], &mut product), Err(short));
    assert!(operator.add_product(&v, &mut product[1..]).is_err());
    assert!(operator.add_diagonal(&mut product[1..]).is_err());
    let mut endless = v.clone();
    endless[1] = f64::INFINITY;
    let refused = AssemblyError::NonFiniteEntry { what: "v", equation: 1, value: f64::INFINITY };
    assert_eq!(operator.add_product(&endless, &mut product), Err(refused));
    assert!(product.iter().all(|x| *x == 7.0));
    let largest: Vec<f64> = v.iter().map(|x| 1e308 * x).collect();
    assert_eq!(operator.add_product(&largest, &mut product).unwrap_err().code(), "overflow");
}
