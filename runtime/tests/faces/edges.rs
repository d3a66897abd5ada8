//! Slaves with sharp edges: what lies beyond an edge does not change what the pressed face carries.

use diffuse_contact::Coulomb;
use diffuse_contact::interface::split_history;

use super::*;
use crate::common::Mesh;

/// A frustum that widens upwards, its lower face 0.02 below a plane. Its sides lean by 27°, towards the plane.
fn frustum() -> (Pair, Vec<Facet>) {
    let Grid { mut positions, facets: master } = Grid::new(7, 0, true, |x, y| [x, y, 0.0]);
    let first_slave = positions.len();
    let block = Mesh::block([4, 4, 2], [1.0; 3]);
    let place = |&[x, y, z]: &Point| {
        let wide = 1.0 + 0.5 * (1.0 + z);
        [3.1 + wide * x, 2.9 + wide * y, 1.0 + z - 0.02 + 0.003 * x]
    };
    positions.extend(block.positions.iter().map(place));
    let moved = |facet: &Facet| match *facet {
        Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners.map(|node| first_slave + node)),
        Facet::Triangle(corners) => Facet::Triangle(corners.map(|node| first_slave + node)),
    };
    let slave: Vec<Facet> = block.facets.iter().map(moved).collect();
    let is_lower =
        |facet: &Facet| facet.corners().iter().all(|&node| block.positions[node - first_slave][2] < -0.9);
    let lower = slave.iter().copied().filter(is_lower).collect();
    (Pair { positions, master, slave, first_slave }, lower)
}

#[test]
fn the_whole_skin_presses_as_its_lower_face_alone() {
    let (skin, lower) = frustum();
    let alone = Pair { slave: lower, positions: skin.positions.clone(), master: skin.master.clone(), ..skin };
    let dofs = DofMap::standard(skin.positions.len());
    let v: Vec<f64> = (0..dofs.equations()).map(|k| (0.7 * k as f64).sin()).collect();
    let law = ContactLaw::penalty(100.0).with_friction(Some(Coulomb::new(0.2, 50.0).unwrap()));
    let mut slid = skin.positions.clone();
    slid[skin.first_slave..].iter_mut().for_each(|x| x[0] += 0.03);
    // With pressures of points the sides touch a little beside the edge.
    for element in elements() {
        let results = |pair: &Pair| {
            let mut interface = pair.interface(element, FaceRule::Second);
            interface.refresh(&pair.positions).unwrap();
            interface.accept(&law).unwrap();
            interface.refresh(&slid).unwrap();
            let contacts = interface.evaluate(&law, Mode::Hessian).unwrap();
            let mut product = vec![0.0; v.len()];
            contacts.add_product(Tangent::Exact, &dofs, &v, &mut product).unwrap();
            [pair.forces(contacts).concat(), product]
        };
        let (found, expected) = (results(&skin), results(&alone));
        for (found, expected) in found.iter().zip(&expected) {
            let largest = expected.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
            let error = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(largest > 0.1 && error < 1e-12 * largest, "{element:?}: {error:e} of {largest:e}");
        }
    }
}

/// A node of the block's edges is there for each face of the block that it is on, and areas are those of the faces.
#[test]
fn nodes_on_edges_have_a_place_for_each_sheet() {
    let (skin, _) = frustum();
    let mut interface = skin.interface(ContactElement::default(), FaceRule::Second);
    let count = |node: usize| interface.slaves().iter().filter(|&&slave| slave == node).count();
    let block = Mesh::block([4, 4, 2], [1.0; 3]);
    for (k, x) in block.positions.iter().enumerate() {
        let faces = x.iter().filter(|x| x.abs() == 1.0).count();
        assert_eq!(count(skin.first_slave + k), faces, "{x:?}");
    }
    assert!(interface.slaves().is_sorted());
    let sum: f64 = interface.areas().iter().sum();
    let of_nodes = diffuse_contact::surface::tributary_areas(&skin.positions, &skin.slave).unwrap();
    assert!((sum - of_nodes.iter().sum::<f64>()).abs() < 1e-12 * sum);
    // Two points of each.
    let law = ContactLaw::penalty(100.0).with_friction(Some(Coulomb::new(0.2, 50.0).unwrap()));
    interface.refresh(&skin.positions).unwrap();
    interface.accept(&law).unwrap();
    let history = interface.history();
    assert_eq!(split_history(&history).unwrap().len(), 2 * interface.slaves().len());
    interface.set_history(&history).unwrap();
    assert_eq!(interface.history(), history);
}

/// With a feature angle of 180° there are no edges: the sides hold the average open.
#[test]
fn the_feature_angle_says_which_edges_are_sharp() {
    let (skin, lower) = frustum();
    let force = |slave: &[Facet], angle: f64| {
        let master = MasterSurface::new(&skin.positions, skin.master.clone()).unwrap();
        let options = InterfaceOptions::default().with_feature_angle_degrees(angle);
        let mut interface =
            FaceInterface::new(master, slave, &skin.positions, FaceOptions::new(options)).unwrap();
        interface.refresh(&skin.positions).unwrap();
        let contacts = interface.evaluate(&ContactLaw::penalty(100.0), Mode::Gradient).unwrap();
        skin.forces(contacts)[skin.first_slave..].iter().map(|force| force[2]).sum::<f64>()
    };
    let expected = force(&lower, 45.0);
    assert!((force(&skin.slave, 45.0) / expected - 1.0).abs() < 1e-12);
    assert!(force(&skin.slave, 180.0) < 0.8 * expected);
}
