//! Derivatives only where there is force: what is read of them is what all contacts would give.

use crate::common::{Mesh, Scene, Uniform};
use diffuse_contact::assembly::{ContactLaw, CsrPattern, DofMap, Triangle, Triplets, add_forces};
use diffuse_contact::interface::{ContactElement, Contacts, InterfaceOptions};
use diffuse_contact::neighbourhood::SearchOptions;
use diffuse_contact::{FrameDerivative, Mode, Point, Weight};

/// Slaves about a wavy master, some beyond its border and some far above; enough for several chunks.
pub(crate) fn scene(options: InterfaceOptions) -> Scene {
    let height = |x: f64, y: f64| (0.4 * x).sin() * (0.3 * y).cos();
    let mesh = Mesh::grid([30, 30], [false; 2], |s, t| {
        let [x, y] = [10.0 * s, 10.0 * t];
        [x, y, height(x, y)]
    });
    let mut random = Uniform(11);
    let mut place = |_| {
        let [x, y] = [10.4 * random.next() - 0.2, 10.4 * random.next() - 0.2];
        let lift = if random.next() < 0.1 { 30.0 } else { 0.05 * random.signed() };
        [x, y, height(x, y) + lift]
    };
    let slaves: Vec<Point> = (0..700).map(&mut place).collect();
    mesh.paired(&slaves, options)
}

pub(crate) fn variants() -> [InterfaceOptions; 4] {
    let base = InterfaceOptions::default().with_distance_limit(Some(5.0));
    let with = |weight, frame| {
        // Domains of influence have frames that move.
        let search = match frame {
            FrameDerivative::CoMoving => SearchOptions::domains(),
            FrameDerivative::Held => SearchOptions::default(),
        };
        base.with_element(ContactElement::diffuse(search).with_weight(weight).with_frame(frame))
    };
    [
        with(Weight::Cubic, FrameDerivative::CoMoving),
        with(Weight::CubicInterpolating, FrameDerivative::CoMoving),
        with(Weight::WendlandC2, FrameDerivative::Held),
        InterfaceOptions::node_to_facet().with_distance_limit(Some(5.0)),
    ]
}

/// Residual, matrix by pattern and matrix by triplets.
fn system(contacts: &Contacts, law: &ContactLaw<'_>, nodes: usize) -> (Vec<f64>, Vec<f64>, Triplets) {
    let dofs = DofMap::standard(nodes);
    let mut residual = vec![0.0; dofs.equations()];
    add_forces(contacts, law, &dofs, &mut residual).unwrap();
    let pattern = CsrPattern::union(contacts, &dofs).unwrap();
    let mut values = vec![0.0; pattern.entries()];
    pattern.fill(contacts, law, &mut values).unwrap();
    let mut triplets = Triplets::new();
    triplets.fill(contacts, law, &dofs, Triangle::Full).unwrap();
    (residual, values, triplets)
}

#[test]
fn contacts_with_force_have_the_bits_of_a_full_evaluation_and_others_no_derivatives() {
    for options in variants() {
        let mut scene = scene(options);
        let multipliers: Vec<f64> = (0..700).map(|k| f64::from(k % 5) * 0.01).collect();
        let law = ContactLaw::penalty(1.5).with_multipliers(Some(&multipliers));
        for mode in [Mode::Hessian, Mode::Gradient] {
            let all = scene.interface.evaluate(mode).unwrap().clone();
            let is_loaded = |k, gap, area| law.force(k, gap, area) > 0.0;
            let some = scene.interface.evaluate_where(mode, is_loaded).unwrap();
            assert_eq!((some.len(), some.mode()), (700, mode));
            let mut counts = [0; 3];
            for (k, (one, other)) in some.iter().zip(all.iter()).enumerate() {
                assert_eq!((one.slave, one.nodes), (other.slave, other.nodes));
                assert_eq!(one.outcome.code(), other.outcome.code());
                if !other.outcome.is_contact() {
                    counts[0] += 1;
                    assert!(one.gradient.is_empty() && one.hessian.is_empty());
                } else if law.force(k, other.point.gap, other.area) > 0.0 {
                    counts[1] += 1;
                    assert_eq!((one.point, one.gradient), (other.point, other.gradient));
                    assert_eq!(one.hessian, other.hessian);
                    assert_eq!(one.gradient.len(), 3 * (one.nodes.len() + 1));
                } else {
                    counts[2] += 1;
                    assert!(one.gradient.is_empty() && one.hessian.is_empty());
                    assert!((one.point.gap - other.point.gap).abs() < 1e-13, "{one:?} {other:?}");
                }
            }
            assert!(counts.iter().all(|&count| count > 50), "{counts:?}");
            if mode == Mode::Hessian {
                let nodes = scene.positions.len();
                let reference = system(&all, &law, nodes);
                assert_eq!(system(scene.interface.contacts(), &law, nodes), reference);
            }
        }
    }
}

/// What an earlier evaluation left in the buffers is not shown.
#[test]
fn derivatives_of_before_are_not_seen() {
    for options in variants() {
        let mut scene = scene(options);
        scene.interface.evaluate(Mode::Hessian).unwrap();
        let contacts = scene.interface.evaluate_where(Mode::Hessian, |_, _, _| false).unwrap();
        assert!(contacts.iter().any(|contact| contact.outcome.is_contact()));
        assert!(contacts.iter().all(|contact| contact.gradient.is_empty() && contact.hessian.is_empty()));
        let again = scene.interface.evaluate(Mode::Hessian).unwrap();
        assert!(again.iter().all(|contact| contact.outcome.is_contact() != contact.hessian.is_empty()));
    }
}

#[test]
fn the_number_of_threads_makes_no_difference() {
    let law = ContactLaw::penalty(2.0);
    let evaluated = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut scene = scene(InterfaceOptions::default());
        let is_loaded = |k, gap, area| law.force(k, gap, area) > 0.0;
        pool.install(|| scene.interface.evaluate_where(Mode::Hessian, is_loaded).unwrap().clone())
    };
    let (one, many) = (evaluated(1), evaluated(3));
    for (one, other) in one.iter().zip(many.iter()) {
        assert_eq!((one.outcome, one.point), (other.outcome, other.point));
        assert_eq!((one.gradient, one.hessian), (other.gradient, other.hessian));
    }
}

/// M of what carries force, evaluated in passing: more slaves than are held at once.
#[test]
fn a_tangent_whose_hessians_nobody_holds_has_the_same_bits() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for options in variants() {
        let mut scene = scene(options);
        let dofs = DofMap::standard(scene.positions.len());
        // All of the first ones carry force, and none of the last ones.
        let multipliers: Vec<f64> = (0..700).map(|k| if k < 520 { 3.0 } else { 0.0 }).collect();
        for multipliers in [None, Some(&multipliers[..])] {
            let law = ContactLaw::penalty(1.5).with_multipliers(multipliers);
            let contacts = scene.interface.evaluate(Mode::Hessian).unwrap();
            let pattern = CsrPattern::union(contacts, &dofs).unwrap();
            let mut expected = vec![0.0; pattern.entries()];
            let active = pattern.fill(contacts, &law, &mut expected).unwrap();
            let entries = pattern.entries();
            let (_, _, map) = pattern.into_parts();
            let mut found = vec![f64::NAN; entries];
            let refused = |scene: &mut Scene| {
                scene.interface.evaluate(Mode::Value).unwrap();
                map.add_from(&scene.interface, &law, &mut vec![0.0; entries]).unwrap_err().code()
            };
            assert_eq!(refused(&mut scene), "derivative-length");
            let contacts = scene.interface.evaluate(Mode::Gradient).unwrap();
            assert!(map.fits(contacts) && contacts.iter().all(|contact| contact.hessian.is_empty()));
            let (interface, law) = (&scene.interface, &law);
            assert_eq!(pool.install(|| map.fill_from(interface, law, &mut found)), Ok(active));
            assert!(found == expected);
            assert_eq!(map.add_from(interface, law, &mut found), Ok(active));
            assert!(found.iter().zip(&expected).all(|(found, half)| (found - 2.0 * half).abs() <= 1e-13));
            // Lists made anew after the evaluation are not those of the pattern.
            let [before, moved] = [0.0, 0.7].map(|way| {
                let slaves = scene.positions.iter().enumerate();
                let of_slave =
                    |(k, x): (usize, &Point)| [x[0] + if k < scene.first { 0.0 } else { way }, x[1], x[2]];
                slaves.map(of_slave).collect::<Vec<_>>()
            });
            scene.interface.refresh_pairing(&moved).unwrap();
            let stale = map.fill_from(&scene.interface, law, &mut vec![0.0; entries]).unwrap_err();
            assert_eq!(stale.code(), "pattern-mismatch");
            scene.interface.refresh_pairing(&before).unwrap();
        }
    }
}
