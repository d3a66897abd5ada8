//! The feet of an interface: against its own differences, and against automatic differentiation of its elements.

use diffuse_contact::ad::Ad;
use diffuse_contact::interface::{FootRef, PairedElement};
use diffuse_contact::{Backend, Mode, Point, Weight};

use crate::common::{Scene, Uniform};
use crate::interface_where::{scene, variants};
use crate::operator::quarter;

/// Against automatic differentiation, of the largest entry.
const TOLERANCE: f64 = 1e-12;
/// Of differences, of the largest.
const OF_DIFFERENCES: f64 = 1e-7;
const STEP: f64 = 1e-6;

fn along(rows: &[f64], moves: &[Point]) -> Point {
    let row = |k: usize| rows[k * rows.len() / 3..][..rows.len() / 3].iter().zip(moves.as_flattened());
    [0, 1, 2].map(|k| row(k).map(|(x, v)| x * v).sum())
}

/// Gap, foot and normal of all slaves where everything has moved by `step`.
fn moved(scene: &mut Scene, moves: &[Point], step: f64) -> Vec<[Point; 2]> {
    let place = |(x, v): (&Point, &Point)| [0, 1, 2].map(|axis| x[axis] + step * v[axis]);
    let positions: Vec<Point> = scene.positions.iter().zip(moves).map(place).collect();
    scene.interface.update(&positions).unwrap();
    let contacts = scene.interface.evaluate(Mode::Value).unwrap();
    contacts.iter().map(|contact| [contact.point.foot, contact.point.normal]).collect()
}

fn check(scene: &mut Scene, what: &str) {
    let feet = scene.interface.foot_derivatives().unwrap();
    let contacts = scene.interface.evaluate(Mode::Value).unwrap();
    for (k, contact) in contacts.iter().enumerate() {
        let foot = feet.get(k);
        assert_eq!((foot.slave, foot.nodes, foot.outcome), (contact.slave, contact.nodes, contact.outcome));
        assert_eq!(foot.weights.is_empty(), !foot.outcome.is_contact());
    }
    let mut random = Uniform(3);
    let moves: Vec<Point> = scene.positions.iter().map(|_| [0; 3].map(|_| random.signed())).collect();
    let [behind, ahead] = [-STEP, STEP].map(|step| moved(scene, &moves, step));
    scene.interface.update(&scene.positions).unwrap();
    let present: Vec<(usize, FootRef<'_>)> =
        feet.iter().enumerate().filter(|(_, foot)| foot.outcome.is_contact()).collect();
    assert!(present.len() > 50, "{what}: {}", present.len());
    for (k, foot) in &present {
        let own = std::iter::once(foot.slave).chain(foot.nodes.iter().map(|&node| node as usize));
        let own: Vec<Point> = own.map(|node| moves[node]).collect();
        for (kind, rows) in [foot.foot, foot.normal].into_iter().enumerate() {
            let (found, size) = (along(rows, &own), rows.iter().fold(1.0_f64, |size, x| size.max(x.abs())));
            for axis in 0..3 {
                let expected = (ahead[*k][kind][axis] - behind[*k][kind][axis]) / (2.0 * STEP);
                assert!(
                    (found[axis] - expected).abs() < OF_DIFFERENCES * size,
                    "{what}, {k}: {found:?} {expected}"
                );
            }
        }
        assert!((foot.weights.iter().sum::<f64>() - 1.0).abs() < TOLERANCE, "{what}, {k}");
    }
    for (k, foot) in present.iter().step_by(40) {
        let Ok(PairedElement::Diffuse { slave, pairing }) = scene.interface.element(*k) else { continue };
        let expected = Ad.foot_derivatives(&pairing.element(slave)).unwrap();
        // Images and auxiliary points have the numbers of their nodes.
        let is_image = |place: usize| scene.positions[pairing.masters[place]] != pairing.positions[place];
        if (0..pairing.masters.len()).any(is_image) {
            continue;
        }
        let freedoms = 3 * (pairing.masters.len() + 1);
        let places: Vec<usize> = std::iter::once(0)
            .chain(
                pairing
                    .masters
                    .iter()
                    .map(|&node| 1 + foot.nodes.iter().position(|&other| other as usize == node).unwrap()),
            )
            .collect();
        for (found, expected) in [(foot.foot, &expected.foot), (foot.normal, &expected.normal)] {
            let size = expected.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            for (place, value) in expected.iter().enumerate() {
                let (row, column) = (place / freedoms, place % freedoms);
                let entry = found[row * found.len() / 3 + 3 * places[column / 3] + column % 3];
                assert!((entry - value).abs() < TOLERANCE * size, "{what}, {k}: {entry} {value}");
            }
        }
        for (value, place) in expected.weights.iter().zip(&places[1..]) {
            assert!((foot.weights[place - 1] - value).abs() < TOLERANCE, "{what}, {k}");
        }
    }
}

#[test]
fn derivatives_at_the_feet_are_differences_and_those_of_automatic_differentiation() {
    for (number, options) in variants().into_iter().enumerate() {
        check(&mut scene(options), &format!("variant {number}"));
    }
}

#[test]
fn images_give_their_part_to_their_nodes() {
    check(&mut quarter(Weight::Cubic), "a quarter");
}

#[cfg(feature = "ad")]
#[test]
fn auxiliary_points_give_their_part_to_their_nodes() {
    check(&mut crate::strips::quarter(Weight::Cubic, 0.8), "a rim");
    check(&mut crate::strips::quarter(Weight::Cubic, 0.05), "a narrow rim");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let scene = scene(variants()[0]);
    let of_threads = |count: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
        let feet = pool.install(|| scene.interface.foot_derivatives()).unwrap();
        feet.iter()
            .flat_map(|foot| [foot.weights, foot.foot, foot.normal].concat())
            .map(f64::to_bits)
            .collect::<Vec<_>>()
    };
    assert_eq!(of_threads(1), of_threads(3));
}
