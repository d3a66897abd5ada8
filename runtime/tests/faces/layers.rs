//! Masters of several layers, of which faces touch the nearest.

use diffuse_contact::assembly::{ContactLaw, DofMap};
use diffuse_contact::faces::{FaceInterface, FaceOptions, NodeContact};
use diffuse_contact::interface::{ContactElement, InterfaceOptions};
use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact::{Mode, Point};

use super::{Grid, Pair, elements};
use crate::common::Mesh;
use crate::self_contact::both;

/// What the nodes have of these surfaces.
fn nodes_of(
    element: ContactElement,
    master: &[Facet],
    slave: &[Facet],
    positions: &[Point],
) -> Vec<NodeContact> {
    let surface = MasterSurface::new(positions, master.to_vec()).unwrap();
    let options = FaceOptions::new(InterfaceOptions::default().with_element(element));
    let mut interface = FaceInterface::new(surface, slave, positions, options).unwrap();
    interface.refresh(positions).unwrap();
    interface.evaluate(&ContactLaw::penalty(1.0), Mode::Value).unwrap().nodes().to_vec()
}

/// A wall with both of its skins as master, thinner than the faces' reach: its far skin carries nothing, however deep the slave is.
#[test]
fn of_layers_of_the_master_the_nearest_carries() {
    let pair = Pair::new([6, 4], false, |x, y| [x, y, 0.0], |x, y| [x, y, -0.12]);
    // The far skin, 0.2 below and looking down, and a layer 0.8 above the near one that looks up.
    let first = pair.positions.len();
    let down = Grid::new(6, first, false, |x, y| [x, y, -0.2]);
    let beyond = Grid::new(5, first + down.positions.len(), true, |x, y| [x, y, 0.8]);
    let positions = [pair.positions.clone(), down.positions, beyond.positions].concat();
    let master = [pair.master.clone(), down.facets, beyond.facets].concat();
    for element in elements() {
        let surface = MasterSurface::new(&positions, master.clone()).unwrap();
        let options = FaceOptions::new(InterfaceOptions::default().with_element(element));
        let mut interface = FaceInterface::new(surface, &pair.slave, &positions, options).unwrap();
        interface.refresh(&positions).unwrap();
        let areas = interface.areas().to_vec();
        let contacts = interface.evaluate(&ContactLaw::penalty(1.0), Mode::Gradient).unwrap();
        for (node, area) in contacts.nodes().iter().zip(areas) {
            assert!(
                (node.gap + 0.12).abs() < 1e-12 && (node.area - area).abs() < 1e-12,
                "{node:?} {element:?}"
            );
        }
        let mut forces = vec![0.0; 3 * positions.len()];
        contacts.add_forces(&DofMap::standard(positions.len()), &mut forces).unwrap();
        assert!(forces[3 * first..].iter().all(|&force| force == 0.0));
    }
}

/// A large facet elsewhere on the master makes others reach no farther: a face that lies deep below them touches nothing.
#[test]
fn a_face_reaches_as_far_as_itself_and_the_facet_over_it() {
    let mut pair = Pair::new([6, 4], false, |x, y| [x, y, 0.0], |x, y| [x, y, -3.5]);
    let first = pair.positions.len();
    pair.positions.extend([[20.0, 0.0, 0.0], [70.0, 0.0, 0.0], [70.0, 50.0, 0.0], [20.0, 50.0, 0.0]]);
    pair.master.push(Facet::Quadrilateral([0, 1, 2, 3].map(|k| first + k)));
    for element in elements() {
        let nodes = nodes_of(element, &pair.master, &pair.slave, &pair.positions);
        assert!(nodes.iter().all(|node| node.area == 0.0), "{element:?}");
    }
}

/// Two plates on one another, each with its whole skin: the far side of the upper one is inside nothing.
#[test]
fn nothing_is_touched_through_a_plate() {
    let lower = Mesh::block([6, 6, 1], [3.0, 3.0, 0.25]);
    let mut upper = Mesh::block([5, 5, 1], [2.5, 2.5, 0.25]);
    upper.positions.iter_mut().for_each(|x| x[2] += 0.48);
    let Mesh { positions, facets } = both(&lower, &upper);
    let (master, slave) = facets.split_at(lower.facets.len());
    for element in elements() {
        for node in nodes_of(element, master, slave, &positions) {
            let [x, y, z] = positions[node.slave];
            match z {
                z if z > 0.5 => assert!(node.pressure == 0.0, "{element:?} {node:?}"),
                _ if x.abs().max(y.abs()) < 2.0 => {
                    assert!((node.gap + 0.02).abs() < 1e-9, "{element:?} {node:?}")
                }
                _ => {}
            }
        }
    }
}

/// The same of a plate whose far side is one large facet: it reaches farther than the small ones that hide it.
#[test]
fn nothing_is_touched_through_a_plate_with_a_coarse_back() {
    let mut lower = Mesh::block([6, 6, 1], [3.0, 3.0, 0.25]);
    let upper = {
        let mut upper = Mesh::block([5, 5, 3], [2.5, 2.5, 1.5]);
        upper.positions.iter_mut().for_each(|x| x[2] += 1.73);
        upper
    };
    let is_back = |facet: &Facet| facet.corners().iter().all(|&node| lower.positions[node][2] < 0.0);
    let mut facets: Vec<Facet> = lower.facets.iter().copied().filter(|facet| !is_back(facet)).collect();
    let corner = |x: [f64; 3]| lower.positions.iter().position(|other| *other == x).unwrap();
    let back = [[-3.0, -3.0], [-3.0, 3.0], [3.0, 3.0], [3.0, -3.0]];
    facets.push(Facet::Quadrilateral(back.map(|[x, y]| corner([x, y, -0.25]))));
    lower.facets = facets;
    let Mesh { positions, facets } = both(&lower, &upper);
    let (master, slave) = facets.split_at(lower.facets.len());
    for element in elements() {
        for node in nodes_of(element, master, slave, &positions) {
            let [_, _, z] = positions[node.slave];
            assert!(z < 3.0 || node.pressure == 0.0, "{element:?} {node:?}");
            assert_eq!(node.pressure > 0.0, z < 0.5 && node.area > 0.0, "{element:?} {node:?}");
        }
    }
}

/// Layers that leave a part of the face uncovered.
#[test]
fn the_nearest_of_layers_carries_at_their_rim_too() {
    let pair = Pair::new([4, 1], false, |x, y| [0.4 * x, y, 0.0], |x, y| [x, y, -0.01]);
    let first = pair.positions.len();
    let deeper = Grid::new(4, first, true, |x, y| [0.4 * x, y, -0.5]);
    let positions = [pair.positions.clone(), deeper.positions].concat();
    let master = [pair.master.clone(), deeper.facets].concat();
    for element in elements() {
        let nodes = nodes_of(element, &master, &pair.slave, &positions);
        let covered: Vec<&NodeContact> = nodes.iter().filter(|node| node.area > 0.0).collect();
        assert!(!covered.is_empty());
        covered.iter().for_each(|node| assert!((node.gap + 0.01).abs() < 1e-9, "{element:?} {node:?}"));
    }
}

/// A layer that is farther than its own reach carries nothing, and hides nothing behind it.
#[test]
fn a_layer_beyond_its_reach_hides_nothing() {
    // Facets of 0.5 lie 1.6 above the slave's faces, one of 6 lies 1.8 above them.
    let mut pair = Pair::new([12, 12], false, |x, y| [x, y, 0.0], |x, y| [x, y, -1.6]);
    let first = pair.positions.len();
    pair.positions.extend([[0.0, 0.0, 0.2], [6.0, 0.0, 0.2], [6.0, 6.0, 0.2], [0.0, 6.0, 0.2]]);
    let near = pair.master.clone();
    pair.master.push(Facet::Quadrilateral([0, 1, 2, 3].map(|k| first + k)));
    let node_to_facet = elements().into_iter().filter(|element| *element == ContactElement::NodeToFacet);
    for element in node_to_facet {
        let alone = nodes_of(element, &near, &pair.slave, &pair.positions);
        assert!(alone.iter().all(|node| node.area == 0.0), "{element:?}");
        let both = nodes_of(element, &pair.master, &pair.slave, &pair.positions);
        assert!(both.iter().all(|node| (node.gap + 1.8).abs() < 1e-12), "{element:?} {both:?}");
    }
}
