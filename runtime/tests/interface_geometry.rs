//! Interfaces over surfaces whose gap is known: plane, cylinder, sphere, torus, graded meshes; derivatives,
//! rigid motion, borders.

use std::f64::consts::{PI, TAU};

use crate::common::{Mesh, Uniform, distance, hull_layers, worse};
use diffuse_contact::interface::{ContactElement, InterfaceOptions, NoContact, Outcome};
use diffuse_contact::neighbourhood::{Fallback, SearchOptions};
use diffuse_contact::surface::Facet;
use diffuse_contact::{FrameDerivative, Mode, Point, Weight};
use nalgebra::{Rotation3, Vector3};

fn held() -> InterfaceOptions {
    let (weight, frame) = (Weight::Cubic, FrameDerivative::Held);
    let element = ContactElement::diffuse(SearchOptions::default()).with_weight(weight).with_frame(frame);
    InterfaceOptions::default().with_element(element)
}

#[test]
fn over_a_plane_the_gap_is_the_height() {
    let mut random = Uniform(1);
    let mut plane = Mesh::plane(10.0, 8.0, 1.0);
    for x in &mut plane.positions {
        x[0] += 0.2 * random.signed();
        x[1] += 0.2 * random.signed();
    }
    let slaves: Vec<Point> = (0..300)
        .map(|_| [0.4 + 9.2 * random.next(), 0.4 + 7.2 * random.next(), 1.5 * random.signed()])
        .collect();
    for options in [InterfaceOptions::default(), held()] {
        let mut scene = plane.paired(&slaves, options);
        let contacts = scene.interface.evaluate(Mode::Gradient).unwrap();
        assert_eq!(contacts.len(), 300);
        for (contact, slave) in contacts.iter().zip(&slaves) {
            // Slaves that are farther than half a domain's radius are contacts of a wider plane.
            assert!(contact.outcome.is_contact(), "{:?}", contact.outcome);
            assert!((contact.point.gap - slave[2]).abs() < 1e-13);
            assert!(distance(contact.point.foot, [slave[0], slave[1], 0.0]) < 1e-12);
            assert!(distance(contact.point.normal, [0.0, 0.0, 1.0]) < 1e-13);
            assert!(contact.nodes.is_sorted() && contact.nodes.len() >= 6 && contact.area == 1.0);
            // The force on the slave is along the normal, and that on the masters balances it.
            assert!(distance([0, 1, 2].map(|k| contact.gradient[k]), [0.0, 0.0, 1.0]) < 1e-12);
            for axis in 0..3 {
                let sum: f64 = contact.gradient.iter().skip(axis).step_by(3).sum();
                assert!(sum.abs() < 1e-12);
            }
        }
    }
}

/// A cylinder, a sphere's zone and a torus, `n` cells along the shorter way, with their gap.
fn curved(name: &str, n: usize) -> (Mesh, fn(Point) -> f64) {
    match name {
        "cylinder" => (
            Mesh::grid([4 * n, 2 * n], [true, false], |s, t| {
                let angle = TAU * s;
                [angle.cos(), angle.sin(), 3.0 * t - 1.5]
            }),
            |[x, y, _]| x.hypot(y) - 1.0,
        ),
        "sphere" => (
            Mesh::grid([4 * n, n], [true, false], |s, t| {
                let (around, up) = (TAU * s, 0.8 * (2.0 * t - 1.0));
                [up.cos() * around.cos(), up.cos() * around.sin(), up.sin()]
            }),
            |[x, y, z]| x.hypot(y).hypot(z) - 1.0,
        ),
        _ => (
            Mesh::grid([8 * n, 4 * n], [true, true], |s, t| {
                let (around, tube) = (TAU * s, TAU * t);
                let radius = 2.0 + tube.cos();
                [radius * around.cos(), radius * around.sin(), tube.sin()]
            }),
            |[x, y, z]| (x.hypot(y) - 2.0).hypot(z) - 1.0,
        ),
    }
}

/// Slaves up to 0.05 off the surfaces of [`curved`], away from their borders.
fn around(name: &str, random: &mut Uniform) -> Point {
    let (angle, radius) = (TAU * random.next(), 1.0 + 0.05 * random.signed());
    match name {
        "cylinder" => [radius * angle.cos(), radius * angle.sin(), random.signed()],
        "sphere" => {
            let up = 0.4 * random.signed();
            [radius * up.cos() * angle.cos(), radius * up.cos() * angle.sin(), radius * up.sin()]
        }
        _ => {
            let tube = TAU * random.next();
            let out = 2.0 + radius * tube.cos();
            [out * angle.cos(), out * angle.sin(), radius * tube.sin()]
        }
    }
}

#[test]
fn on_curved_surfaces_the_gap_converges_with_the_third_power_of_the_mesh_size() {
    for name in ["cylinder", "sphere", "torus"] {
        let errors = [6, 12].map(|n| {
            let (mesh, gap) = curved(name, n);
            let mut random = Uniform(5);
            let slaves: Vec<Point> = (0..400).map(|_| around(name, &mut random)).collect();
            let mut scene = mesh.paired(&slaves, InterfaceOptions::default());
            let contacts = scene.interface.evaluate(Mode::Value).unwrap();
            let errors = contacts.iter().zip(&slaves).map(|(contact, &slave)| {
                assert!(contact.outcome.is_contact(), "{name} {slave:?} {:?}", contact.outcome);
                (contact.point.gap - gap(slave)).abs()
            });
            errors.fold(0.0, worse)
        });
        println!("{name}: {errors:?}");
        assert!(errors[0] < 1e-2 && errors[1] < errors[0] / 6.0, "{name}: {errors:?}");
    }
}

#[test]
fn inside_a_pipe_the_gap_is_measured_from_its_wall() {
    let (mut pipe, _) = curved("cylinder", 12);
    pipe.facets = diffuse_contact::surface::MasterSurface::flipped(&pipe.facets);
    let slaves: Vec<Point> =
        (0..60).map(|k| f64::from(k) * 0.7).map(|t| [0.9 * t.cos(), 0.9 * t.sin(), 0.02 * t - 0.5]).collect();
    let mut scene = pipe.paired(&slaves, InterfaceOptions::default());
    for contact in scene.interface.evaluate(Mode::Value).unwrap().iter() {
        assert!((contact.point.gap - 0.1).abs() < 1e-3, "{contact:?}");
    }
}

#[test]
fn derivatives_are_those_of_the_gap() {
    let (mesh, _) = curved("torus", 6);
    let mut random = Uniform(9);
    let slaves: Vec<Point> = (0..40).map(|_| around("torus", &mut random)).collect();
    let mut scene = mesh.paired(&slaves, InterfaceOptions::default());
    let direction: Vec<Point> =
        scene.positions.iter().map(|_| [random.signed(), random.signed(), random.signed()]).collect();
    let along = |nodes: &[u32], slave: usize| -> Vec<f64> {
        let nodes = std::iter::once(slave).chain(nodes.iter().map(|&node| node as usize));
        nodes.flat_map(|node| direction[node]).collect()
    };
    let at_rest = scene.positions.clone();
    let mut evaluated = |step: f64, mode: Mode| {
        let moved = at_rest.iter().zip(&direction).map(|(x, d)| [0, 1, 2].map(|k| x[k] + step * d[k]));
        scene.positions = moved.collect();
        scene.update();
        scene.interface.evaluate(mode).unwrap().clone()
    };
    // The error of the differences goes with the square of the step.
    let h = 1e-6;
    let [before, after] = [-h, h].map(|step| evaluated(step, Mode::Gradient));
    let contacts = evaluated(0.0, Mode::Hessian);
    for (k, contact) in contacts.iter().enumerate() {
        let d = along(contact.nodes, contact.slave);
        let slope: f64 = contact.gradient.iter().zip(&d).map(|(n, d)| n * d).sum();
        let difference = (after.get(k).point.gap - before.get(k).point.gap) / (2.0 * h);
        assert!((slope - difference).abs() < 1e-8, "{slope} {difference}");
        for i in 0..d.len() {
            let entry = |j: usize| contact.hessian[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
            let product: f64 = (0..d.len()).map(|j| entry(j) * d[j]).sum();
            let difference = (after.get(k).gradient[i] - before.get(k).gradient[i]) / (2.0 * h);
            assert!((product - difference).abs() < 1e-6, "{product} {difference}");
        }
    }
}

#[test]
fn a_rigid_motion_of_everything_changes_nothing() {
    let (mesh, _) = curved("torus", 6);
    let mut random = Uniform(11);
    let slaves: Vec<Point> = (0..100).map(|_| around("torus", &mut random)).collect();
    for options in [InterfaceOptions::default(), held()] {
        let mut scene = mesh.paired(&slaves, options);
        let first = scene.interface.evaluate(Mode::Gradient).unwrap().clone();
        let at_rest = scene.positions.clone();
        // Upside down first: the sides must not be taken from where the surface was.
        let upside_down = Rotation3::new(Vector3::new(PI, 0.0, 0.0));
        for rotation in [upside_down, random.rotation(), random.rotation()] {
            let shift = Vector3::new(3.0, -40.0, 0.7);
            scene.positions = at_rest.iter().map(|&x| (rotation * Vector3::from(x) + shift).into()).collect();
            if options == held() {
                let report = scene.refresh();
                assert_eq!((report.renewed, report.changed), (100, 0), "{report:?}");
            } else {
                scene.update();
            }
            let contacts = scene.interface.evaluate(Mode::Gradient).unwrap();
            for (now, then) in contacts.iter().zip(first.iter()) {
                assert_eq!((now.nodes, now.outcome), (then.nodes, then.outcome));
                assert!((now.point.gap - then.point.gap).abs() < 1e-11, "{now:?} {then:?}");
                let normal = rotation * Vector3::from(then.point.normal);
                assert!(distance(now.point.normal, normal.into()) < 1e-11);
            }
        }
    }
}

#[test]
fn where_the_mesh_is_graded_the_gap_is_right_on_every_scale() {
    // A bowl z = (x² + y²)/4 meshed in polar coordinates, cells growing from 3e-5 to 0.3 with the distance from its
    // middle.
    let rings = 41;
    let radius = |t: f64| 1e-4 * 10f64.powf(4.0 * t);
    let mesh = Mesh::grid([24, rings], [true, false], |s, t| {
        let (angle, r) = (TAU * s, radius(1.0 - t));
        [r * angle.cos(), r * angle.sin(), r * r / 4.0]
    });
    let mut random = Uniform(21);
    let scenes: Vec<(Point, f64, f64)> = (0..400)
        .map(|_| {
            let (angle, r) = (TAU * random.next(), radius(0.05 + 0.85 * random.next()));
            let (x, y, gap) = (r * angle.cos(), r * angle.sin(), 0.05 * r * random.signed());
            let normal = Vector3::new(-0.5 * x, -0.5 * y, 1.0).normalize();
            ((Vector3::new(x, y, r * r / 4.0) + normal * gap).into(), gap, r)
        })
        .collect();
    let slaves: Vec<Point> = scenes.iter().map(|(slave, ..)| *slave).collect();
    let mut scene = mesh.paired(&slaves, InterfaceOptions::default());
    for (contact, (slave, gap, r)) in scene.interface.evaluate(Mode::Value).unwrap().iter().zip(&scenes) {
        assert_eq!(contact.outcome, Outcome::Contact { fallback: Fallback::None }, "{slave:?}");
        // The surface is a quadratic in its own coordinates; tilted it differs from one by a third order.
        assert!(
            (contact.point.gap - gap).abs() < 2e-2 * r.powi(3) + 1e-9 * r,
            "{slave:?}: {} {gap}",
            contact.point.gap
        );
    }
}

#[test]
fn a_foot_beyond_the_border_is_no_contact() {
    let plane = Mesh::plane(4.0, 4.0, 0.5);
    // Inside, on an edge, on a corner, less beyond than the tolerance of 1 % of 0.5, more beyond, beyond a corner.
    let places = [
        ([2.0, 3.9], true),
        ([2.0, 4.0], true),
        ([0.0, 0.0], true),
        ([4.0, 1.25], true),
        ([2.0, 4.004], true),
        ([2.0, 4.02], false),
        ([-0.1, 1.1], false),
        ([4.2, 4.2], false),
        ([-0.3, -0.01], false),
        ([2.0, 4.7], false),
        ([90.0, 2.0], false),
    ];
    let slaves: Vec<Point> = places.iter().map(|([x, y], _)| [*x, *y, -0.2]).collect();
    let mut scene = plane.paired(&slaves, InterfaceOptions::default());
    let contacts = scene.interface.evaluate(Mode::Value).unwrap();
    for (contact, (place, inside)) in contacts.iter().zip(&places) {
        assert_eq!(contact.outcome.is_contact(), *inside, "{place:?}: {:?}", contact.outcome);
        if *inside {
            assert!((contact.point.gap + 0.2).abs() < 1e-12);
        } else {
            assert_eq!(contact.outcome.code(), "beyond-border");
        }
    }
    // A slave within a facet of the border is paired, and has contact once it is inside.
    let beyond = |k: usize| contacts.get(k).outcome;
    assert!(
        matches!(beyond(5), Outcome::None(NoContact::BeyondBorder { distance, .. }) if (distance - 0.04).abs() < 1e-9)
    );
    assert!(contacts.get(9).nodes.is_empty() && !contacts.get(5).nodes.is_empty());
    scene.positions[scene.first + 5][1] = 3.99;
    scene.update();
    assert!(scene.interface.evaluate(Mode::Value).unwrap().get(5).outcome.is_contact());
}

#[test]
fn one_facet_is_a_surface() {
    let triangle = Mesh {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        facets: vec![Facet::Triangle([0, 1, 2])],
    };
    let quadrilateral = Mesh::grid([2, 2], [false; 2], |s, t| [s, t, 0.0]);
    let quadrilateral = Mesh { facets: vec![Facet::Quadrilateral([0, 1, 3, 2])], ..quadrilateral };
    for mesh in [triangle, quadrilateral] {
        let mut scene = mesh.paired(&[[0.3, 0.25, 0.1], [0.6, -0.3, 0.1]], InterfaceOptions::default());
        let contacts = scene.interface.evaluate(Mode::Hessian).unwrap();
        let [inside, outside] = [contacts.get(0), contacts.get(1)];
        assert!(matches!(inside.outcome, Outcome::Contact { fallback: Fallback::Linear { .. } }));
        assert!((inside.point.gap - 0.1).abs() < 1e-14);
        assert_eq!(outside.outcome.code(), "beyond-border");
        assert!(outside.gradient.is_empty() && outside.hessian.is_empty());
    }
}

#[test]
fn beyond_a_centre_of_curvature_there_is_no_nearest_foot() {
    // A groove of radius 1 and a bowl of curvature 1, seen from inside. Slaves rise from below the centre to
    // beyond it.
    let groove = Mesh::grid([25, 25], [false; 2], |s, t| {
        let angle = 1.2 * (2.0 * s - 1.0);
        [angle.sin(), 2.0 * t - 1.0, 1.0 - angle.cos()]
    });
    let bowl = Mesh::grid([31, 31], [false; 2], |s, t| {
        let [x, y] = [s, t].map(|s| 1.2 * s - 0.6);
        [x, y, 1.0 - (1.0 - x * x - y * y).sqrt()]
    });
    for mesh in [groove, bowl] {
        let mut scene = mesh.paired(&[[0.0, 0.0, 0.3]], hull_layers());
        for (height, contact) in [(0.3, true), (0.8, true), (1.3, false), (2.0, false)] {
            scene.move_slaves(&[[1e-3, 0.0, height]]);
            scene.update();
            let outcome = scene.interface.evaluate(Mode::Value).unwrap().get(0).outcome;
            assert_eq!(outcome.is_contact(), contact, "{height} {outcome:?}");
            assert!(contact || outcome.code() == "beyond-centre-of-curvature", "{height} {outcome:?}");
        }
    }
}
