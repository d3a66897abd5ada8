//! Interfaces of node-to-facet elements.

use crate::common::{Mesh, Scene, Uniform, distance};
use diffuse_contact::interface::{InterfaceOptions, Outcome};
use diffuse_contact::neighbourhood::Fallback;
use diffuse_contact::surface::Facet;
use diffuse_contact::{Mode, Point};
use nalgebra::Vector3;

/// A roof over the square from 0 to 4: its ridge along y at x = 2, both sides fall by `slope`. Outside above.
fn roof(slope: f64) -> Mesh {
    let mut mesh = Mesh::plane(4.0, 4.0, 1.0);
    for x in &mut mesh.positions {
        x[2] = -slope * (x[0] - 2.0).abs();
    }
    mesh
}

#[test]
fn the_gap_is_that_of_the_closest_facet() {
    let mesh = Mesh::grid([20, 16], [false; 2], |s, t| {
        let [x, y] = [8.0 * s, 6.0 * t];
        [x, y, 0.4 * (0.8 * x).sin() * (0.7 * y).cos()]
    });
    let mut random = Uniform(6);
    let slaves: Vec<Point> = (0..300)
        .map(|_| [0.3 + 7.4 * random.next(), 0.3 + 5.4 * random.next(), 0.5 * random.signed()])
        .collect();
    let mut scene = mesh.paired(&slaves, InterfaceOptions::node_to_facet());
    let surface = mesh.surface();
    let index = surface.at(&mesh.positions).unwrap();
    let contacts = scene.interface.evaluate(Mode::Gradient).unwrap();
    for (contact, &slave) in contacts.iter().zip(&slaves) {
        let closest = index.closest(slave).unwrap();
        assert_eq!(contact.outcome, Outcome::Contact { fallback: Fallback::None }, "{slave:?}");
        let corners: Vec<usize> = contact.nodes.iter().map(|&node| node as usize).collect();
        assert_eq!(corners, surface.facet(closest.facet).corners());
        // Over an edge the foot on the facet extended is nearer than the closest point.
        assert!(contact.point.gap.abs() <= closest.distance + 1e-12);
        let inside = match surface.facet(closest.facet) {
            Facet::Triangle(_) => {
                closest.natural.iter().all(|&x| x > 1e-9) && closest.natural.iter().sum::<f64>() < 1.0 - 1e-9
            }
            Facet::Quadrilateral(_) => closest.natural.iter().all(|x| x.abs() < 1.0 - 1e-9),
        };
        if inside {
            assert!((contact.point.gap.abs() - closest.distance).abs() < 1e-12);
            assert!(distance(contact.point.foot, closest.point) < 1e-9);
        }
        let up = Vector3::from(index.normal(closest.facet)).dot(&Vector3::from(contact.point.normal));
        assert!(up > 0.9, "outward");
    }
}

#[test]
fn a_slave_that_slides_off_its_facet_goes_on_over_its_extension() {
    let slope: f64 = 0.3;
    let mut scene = roof(slope).paired(&[[1.7, 1.5, 0.2]], InterfaceOptions::node_to_facet());
    // The left side extended to x = 2.6, although the right one falls away from it.
    scene.move_slaves(&[[2.6, 1.5, 0.2]]);
    scene.update();
    let height = |sign: f64| (0.2 + sign * slope * (2.0 - 2.6)) / slope.hypot(1.0);
    let gap = |scene: &mut Scene| {
        let contact = scene.interface.evaluate(Mode::Value).unwrap().get(0);
        assert!(contact.outcome.is_contact(), "{:?}", contact.outcome);
        contact.point.gap
    };
    assert!((gap(&mut scene) - height(1.0)).abs() < 1e-12);
    let report = scene.refresh();
    assert_eq!(report.changed, 1);
    assert!((gap(&mut scene) - height(-1.0)).abs() < 1e-12);
    let jump = report.largest_gap_jump.unwrap();
    assert!((jump.before - height(1.0)).abs() < 1e-12 && (jump.after - height(-1.0)).abs() < 1e-12);
}

#[test]
fn past_a_border_or_a_sharp_edge_there_is_no_contact() {
    let plane = Mesh::plane(4.0, 4.0, 1.0);
    let mut scene = plane.paired(&[[3.6, 1.5, -0.1], [1.5, 3.6, -0.1]], InterfaceOptions::node_to_facet());
    for (beyond, contact) in [(-0.1, true), (0.0, true), (0.005, true), (0.02, false), (0.7, false)] {
        scene.move_slaves(&[[4.0 + beyond, 1.5, -0.1], [1.5, 4.0 + beyond, -0.1]]);
        scene.update();
        for slave in scene.interface.evaluate(Mode::Value).unwrap().iter() {
            assert_eq!(slave.outcome.is_contact(), contact, "{beyond} {:?}", slave.outcome);
            assert!(contact || slave.outcome.code() == "beyond-border");
        }
    }
    // The sides of this ridge meet at 90°.
    let mut scene = roof(1.0).paired(&[[1.7, 1.5, -0.4]], InterfaceOptions::node_to_facet());
    assert!(scene.interface.evaluate(Mode::Value).unwrap().get(0).outcome.is_contact());
    scene.move_slaves(&[[2.8, 1.5, 0.0]]);
    scene.update();
    assert_eq!(scene.interface.evaluate(Mode::Value).unwrap().get(0).outcome.code(), "beyond-border");
}

/// A strip along x of facets between these x, 1 wide.
fn strip(x: &[f64]) -> Mesh {
    let count = x.len();
    let positions = [0.0, 1.0].into_iter().flat_map(|y| x.iter().map(move |&x| [x, y, 0.0])).collect();
    let facets = (1..count).map(|k| Facet::Quadrilateral([k - 1, k, k + count, k + count - 1])).collect();
    Mesh { positions, facets }
}

#[test]
fn past_the_border_of_a_neighbour_there_is_no_contact() {
    let mesh = strip(&[-1.0, 0.0, 1.0, 1.08]);
    for (x, expected) in [(1.05, "contact"), (1.15, "beyond-border")] {
        let mut scene = mesh.paired(&[[0.9, 0.5, -0.05]], InterfaceOptions::node_to_facet());
        scene.move_slaves(&[[x, 0.5, -0.05]]);
        scene.update();
        let code = |scene: &mut Scene| scene.interface.evaluate(Mode::Value).unwrap().get(0).outcome.code();
        assert_eq!(code(&mut scene), expected, "{x} before a refresh");
        scene.refresh();
        assert_eq!(code(&mut scene), expected, "{x} after a refresh");
    }
}

#[test]
fn the_border_is_seen_in_any_unit_of_length() {
    for unit in [1e-60, 1e60] {
        let mut mesh = strip(&[-1.0, 0.0, 1.0, 2.0]);
        mesh.positions.iter_mut().for_each(|x| *x = x.map(|x| unit * x));
        let slaves = [[1.9, 0.5, -0.05], [2.1, 0.5, -0.05]].map(|x: Point| x.map(|x| unit * x));
        let mut scene = mesh.paired(&slaves, InterfaceOptions::node_to_facet());
        let contacts = scene.interface.evaluate(Mode::Gradient).unwrap();
        let codes: Vec<&str> = contacts.iter().map(|contact| contact.outcome.code()).collect();
        assert_eq!(codes, ["contact", "beyond-border"], "{unit:e}");
    }
}
