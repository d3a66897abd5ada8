//! Nodal domains of influence: the gap is one smooth function of all positions, whatever is listed, at borders and symmetry
//! planes, too.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_6};

use diffuse_contact::interface::{
    ContactElement, ContactInterface, InterfaceError, InterfaceOptions, Outcome, PairedElement,
};
use diffuse_contact::neighbourhood::{Fallback, SearchOptions};
use diffuse_contact::surface::{Facet, MasterSurface, SurfaceError, SymmetryPlane};
use diffuse_contact::{Backend, Generated, Mode, Point, Weight, ad::Ad};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// A grid of cells over [0, columns] × [0, rows], mapped.
fn grid(columns: usize, rows: usize, map: impl Fn(f64, f64) -> Point) -> (Vec<Point>, Vec<Facet>) {
    let wide = columns + 1;
    let node = |k: usize| map((k % wide) as f64, (k / wide) as f64);
    let corner = |cell: usize| cell % columns + wide * (cell / columns);
    let facet = |k: usize| Facet::Quadrilateral([k, k + 1, k + wide + 1, k + wide]);
    (
        (0..wide * (rows + 1)).map(node).collect(),
        (0..columns * rows).map(|cell| facet(corner(cell))).collect(),
    )
}

/// A deterministic number in [−1, 1].
fn noise(k: usize) -> f64 {
    let x = (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ x >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((x ^ x >> 32) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

fn wave(x: f64, y: f64) -> f64 {
    (x * FRAC_PI_6).sin() * (y * FRAC_PI_6).cos()
}

/// The wavy surface with nodes moved by a fraction of a cell.
fn wavy(cells: usize, moved: f64) -> (Vec<Point>, Vec<Facet>) {
    grid(cells, cells, |x, y| {
        let k = (x * 1000.0 + y) as usize;
        let inner = |t: f64| if t > 0.0 && t < cells as f64 { moved } else { 0.0 };
        let (x, y) = (x + inner(x) * noise(2 * k), y + inner(y) * noise(2 * k + 1));
        [x, y, wave(x, y)]
    })
}

fn options(weight: Weight) -> InterfaceOptions {
    let element = ContactElement::diffuse(SearchOptions::domains()).with_weight(weight);
    InterfaceOptions::default().with_element(element)
}

/// The interface of slaves at these points over a surface, refreshed.
fn interface(
    (nodes, facets): &(Vec<Point>, Vec<Facet>),
    slaves: &[Point],
    options: InterfaceOptions,
    planes: &[SymmetryPlane],
) -> ContactInterface {
    let mut positions = nodes.clone();
    positions.extend(slaves);
    let master = MasterSurface::new(&positions, facets.clone()).unwrap();
    let own = (nodes.len()..positions.len()).collect();
    let mut interface = ContactInterface::new(master, own, &[], &positions, options).unwrap();
    interface.set_symmetry(planes).unwrap();
    interface.refresh_pairing(&positions).unwrap();
    interface
}

fn gaps(interface: &mut ContactInterface) -> Vec<f64> {
    let contacts = interface.evaluate(Mode::Value).unwrap();
    contacts
        .iter()
        .map(|contact| {
            assert!(contact.outcome.is_contact(), "{:?}", contact.outcome);
            contact.point.gap
        })
        .collect()
}

/// Largest second difference of the gap on a path over the wavy surface, and the gap's range about 0.05.
fn roughness(mesh: &(Vec<Point>, Vec<Facet>), weight: Weight, steps: u32) -> (f64, f64) {
    let path: Vec<Point> = (0..steps)
        .map(|k| {
            let t = f64::from(k) / f64::from(steps - 1);
            let (x, y) = (3.0 + 10.0 * t, 4.0 + 7.0 * t + (6.0 * t).sin());
            [x, y, wave(x, y) + 0.05]
        })
        .collect();
    let g = gaps(&mut interface(mesh, &path, options(weight), &[]));
    let second = g.windows(3).map(|g| (g[0] - 2.0 * g[1] + g[2]).abs()).fold(0.0, crate::common::worse);
    (second, g.iter().fold(0.0_f64, |m, x| m.max((x - 0.05).abs())))
}

#[test]
fn a_slave_that_slides_meets_no_jump() {
    for moved in [0.0, 0.2] {
        let mesh = wavy(16, moved);
        for weight in Weight::ALL {
            // A jump, or a kink of the gap, would not shrink with the square of the step.
            let (coarse, range) = roughness(&mesh, weight, 3000);
            let (fine, _) = roughness(&mesh, weight, 12_000);
            assert!(fine < coarse / 12.0, "{moved} {weight:?}: {coarse:e} {fine:e}");
            assert!(fine < 1e-3 * range, "{moved} {weight:?}: {fine:e} of {range:e}");
        }
    }
}

#[test]
fn on_a_flat_surface_borders_and_corners_are_flat() {
    let mesh = grid(9, 5, |x, y| [x, y + 0.1 * (x * 1.3).sin(), 0.0]);
    let slaves: Vec<Point> = (0..200)
        .map(|k| {
            let (x, y) = (9.0 * (0.5 + 0.5 * noise(2 * k)), 5.0 * (0.5 + 0.5 * noise(2 * k + 1)));
            let (x, y) = if k % 4 == 0 { (x.round(), y.round()) } else { (x, y) };
            [x, y + 0.1 * (x * 1.3).sin(), 0.1]
        })
        .collect();
    for weight in Weight::ALL {
        let mut interface = interface(&mesh, &slaves, options(weight), &[]);
        for gap in gaps(&mut interface) {
            assert!((gap - 0.1).abs() < 1e-12, "{weight:?}: {gap}");
        }
    }
}

#[test]
fn what_is_listed_makes_no_difference_to_a_bit() {
    let mesh = wavy(10, 0.2);
    let slaves: Vec<Point> = (0..150)
        .map(|k| (5.0 + 4.9 * noise(2 * k), 5.0 + 4.9 * noise(2 * k + 1)))
        .map(|(x, y)| [x, y, wave(x, y) - 0.02])
        .collect();
    let mut at_home = interface(&mesh, &slaves, options(Weight::Cubic), &[]);
    // Lists made a little beside, with other nodes near their skin, and then kept.
    let aside: Vec<Point> = slaves.iter().map(|[x, y, z]| [x + 0.03, y - 0.02, z + 0.01]).collect();
    let mut kept = interface(&mesh, &aside, options(Weight::Cubic), &[]);
    let mut positions = mesh.0.clone();
    positions.extend(&slaves);
    let report = kept.refresh_pairing(&positions).unwrap();
    assert!(!report.rebuilt && report.kept == 150, "{report:?}");
    let listed = |interface: &ContactInterface| -> Vec<Vec<u32>> {
        interface.contacts().iter().map(|contact| contact.nodes.to_vec()).collect()
    };
    at_home.evaluate(Mode::Hessian).unwrap();
    kept.evaluate(Mode::Hessian).unwrap();
    assert_ne!(listed(&at_home), listed(&kept), "the lists are the same anyway");
    for (one, other) in at_home.contacts().iter().zip(kept.contacts().iter()) {
        assert_eq!(one.point, other.point);
        for node in one.nodes.iter().chain(other.nodes) {
            let of = |contact: &diffuse_contact::interface::ContactRef<'_>| {
                contact
                    .nodes
                    .binary_search(node)
                    .map_or([0.0; 3], |k| contact.gradient[3 * (k + 1)..3 * (k + 2)].try_into().unwrap())
            };
            assert_eq!(of(&one), of(&other));
        }
        let total =
            |hessian: &[f64]| hessian.iter().filter(|x| **x != 0.0).map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(total(one.hessian), total(other.hessian));
    }
    // Moved by more than half the skin, they are made anew.
    positions.iter_mut().skip(mesh.0.len()).for_each(|x| x[0] += 0.3);
    assert!(kept.refresh_pairing(&positions).unwrap().rebuilt);
}

/// On a master pressed together in its plane a slave's place moves by more than the slave.
#[test]
fn lists_of_a_master_pressed_together_are_complete() {
    // Steep facets are listed anew at every place, flat ones are not.
    pressed_together(1.0);
    let [kept, made] = pressed_together(0.1);
    assert!(kept > 20 && made > 1, "{kept} {made}");
}

/// How often lists were kept and made, with the waves so much lower.
fn pressed_together(flat: f64) -> [usize; 2] {
    let mesh = wavy(10, 0.2);
    let slaves: Vec<Point> = (0..60)
        .map(|k| (5.0 + 4.0 * noise(2 * k), 5.0 + 4.0 * noise(2 * k + 1)))
        .map(|(x, y)| [x, y, wave(x, y)])
        .collect();
    let [mut followed, mut anew] = [(); 2].map(|()| interface(&mesh, &slaves, options(Weight::Cubic), &[]));
    // The gap of each slave, and the nodes that have a part in it.
    let of_all = |interface: &mut ContactInterface| -> Vec<(f64, Vec<u32>)> {
        let contacts = interface.evaluate(Mode::Gradient).unwrap();
        contacts
            .iter()
            .map(|contact| {
                let parts = contact.nodes.iter().zip(contact.gradient[3..].chunks(3));
                let nodes = parts.filter(|(_, part)| **part != [0.0; 3]).map(|(&node, _)| node).collect();
                (contact.point.gap, nodes)
            })
            .collect()
    };
    let (mut kept, mut made) = (0, 0);
    for step in 0..40 {
        let pressed = |(k, &[x, y, z]): (usize, &Point)| {
            let way = if k < mesh.0.len() { 0.0 } else { 0.01 * f64::from(step) };
            [0.2 * (x + way), y, flat * z]
        };
        let positions: Vec<Point> = mesh.0.iter().chain(&slaves).enumerate().map(pressed).collect();
        if followed.follow(&positions).unwrap() {
            made += 1
        } else {
            kept += 1
        }
        anew.renew_pairing(&positions).unwrap();
        for ((gap, nodes), (exact, all)) in of_all(&mut followed).into_iter().zip(of_all(&mut anew)) {
            assert_eq!(nodes, all, "step {step}: {gap} {exact}");
            assert!((gap - exact).abs() < 1e-15);
        }
    }
    [kept, made]
}

#[test]
fn the_gap_between_symmetry_planes_is_that_of_the_whole() {
    // A quarter and a strip of a curved surface, and the whole.
    let height = |x: f64, y: f64| 0.05 * x * x - 0.01 * y * y * y.abs();
    let whole = grid(12, 12, |x, y| [x - 6.0, y - 6.0, height(x - 6.0, y - 6.0)]);
    let quarter = grid(6, 6, |x, y| [x, y, height(x, y)]);
    let slaves: Vec<Point> =
        [[0.0, 0.0], [0.3, 0.0], [0.0, 1.7], [0.4, 0.2], [1.3, 0.9], [2.0, 0.0], [0.1, 2.9]]
            .map(|[x, y]| [x, y, height(x, y) + 0.04])
            .to_vec();
    let planes = [SymmetryPlane::across(0, [0.0; 3]), SymmetryPlane::across(1, [0.0; 3])];
    for weight in Weight::ALL {
        let mut all = interface(&whole, &slaves, options(weight), &[]);
        let mut part = interface(&quarter, &slaves, options(weight), &planes);
        all.evaluate(Mode::Hessian).unwrap();
        part.evaluate(Mode::Hessian).unwrap();
        for (k, (one, other)) in all.contacts().iter().zip(part.contacts().iter()).enumerate() {
            assert!(other.outcome.is_contact(), "{:?}", other.outcome);
            assert!(
                (one.point.gap - other.point.gap).abs() < 1e-13,
                "{weight:?} {k} {:?} {:?}",
                one.point,
                other.point
            );
            for axis in 0..3 {
                assert!((one.point.normal[axis] - other.point.normal[axis]).abs() < 1e-13);
                if axis < 2 && slaves[k][axis] == 0.0 {
                    assert!(other.point.normal[axis].abs() < 1e-15, "the normal lies in the plane");
                }
                assert!((one.gradient[axis] - other.gradient[axis]).abs() < 1e-12);
            }
            // N of a node is the sum over its images of N mirrored back.
            for (local, &node) in other.nodes.iter().enumerate() {
                let [x, y, _] = quarter.0[node as usize];
                let mut total = [0.0; 3];
                for (place, &node) in one.nodes.iter().enumerate() {
                    let [u, v, _] = whole.0[node as usize];
                    if u.abs() == x && v.abs() == y {
                        let n = &one.gradient[3 * (place + 1)..3 * (place + 2)];
                        let sign = |t: f64, s: f64| if t != s { -1.0 } else { 1.0 };
                        let mirrored = [sign(u, x) * n[0], sign(v, y) * n[1], n[2]];
                        total.iter_mut().zip(mirrored).for_each(|(t, n)| *t += n);
                    }
                }
                for axis in 0..3 {
                    let found = other.gradient[3 * (local + 1) + axis];
                    assert!((found - total[axis]).abs() < 1e-12, "{weight:?} {k} {node} {axis}");
                }
            }
        }
    }
}

#[test]
fn derivatives_of_loaded_slaves_alone_are_those_of_all() {
    let mesh = wavy(8, 0.2);
    let planes = [SymmetryPlane::across(0, [0.0; 3])];
    let slaves: Vec<Point> = (0..40)
        .map(|k| (2.0 + 1.9 * noise(2 * k), 4.0 + 3.9 * noise(2 * k + 1), 0.03 * noise(k + 90)))
        .map(|(x, y, z)| [x, y, wave(x, y) + z])
        .collect();
    let mut interface = interface(&mesh, &slaves, options(Weight::Cubic), &planes);
    let all: Vec<_> = interface
        .evaluate(Mode::Hessian)
        .unwrap()
        .iter()
        .map(|contact| (contact.point.gap, contact.gradient.to_vec(), contact.hessian.to_vec()))
        .collect();
    let some = interface.evaluate_where(Mode::Hessian, |_, gap, _| gap < 0.0).unwrap();
    assert!(some.iter().any(|contact| contact.gradient.is_empty()));
    for (contact, (gap, gradient, hessian)) in some.iter().zip(&all) {
        if *gap < 0.0 {
            assert_eq!((contact.gradient, contact.hessian), (&gradient[..], &hessian[..]));
        } else {
            assert!(contact.gradient.is_empty() && contact.hessian.is_empty());
        }
    }
}

#[test]
fn one_layer_between_two_planes_is_as_smooth_as_the_whole() {
    let arc = |x: f64| {
        let angle = (x - 9.0) * 10_f64.to_radians();
        [10.0 * angle.sin(), 10.0 * angle.cos()]
    };
    let layer = grid(18, 1, |x, y| [arc(x)[0], 1.7 * y, arc(x)[1]]);
    let planes = [
        SymmetryPlane::across(1, [0.0; 3]),
        SymmetryPlane { point: [0.0, 1.7, 0.0], normal: [0.0, -1.0, 0.0] },
    ];
    let slaves: Vec<Point> = (0..60)
        .map(|k| {
            let angle = (-30.0 + f64::from(k)).to_radians();
            [10.02 * angle.sin(), if k % 2 == 0 { 0.0 } else { 1.7 }, 10.02 * angle.cos()]
        })
        .collect();
    let mut found = interface(&layer, &slaves, options(Weight::Cubic), &planes);
    for contact in found.evaluate(Mode::Gradient).unwrap().iter() {
        assert_eq!(contact.outcome, Outcome::Contact { fallback: Fallback::None });
        assert!(contact.point.normal[1].abs() < 1e-15);
    }
    let largest_error = |mut interface: ContactInterface| {
        let contacts = interface.evaluate(Mode::Value).unwrap();
        contacts.iter().fold(0.0_f64, |most, contact| most.max((contact.point.gap - 0.02).abs()))
    };
    let facets = interface(&layer, &slaves, InterfaceOptions::node_to_facet(), &planes);
    let [smooth, facets] = [found, facets].map(largest_error);
    println!("largest error of the gap to the true cylinder: {smooth:.2e}, on facets {facets:.2e}");
    assert!(smooth <= 0.1 * facets, "{smooth} {facets}");
    // Alone it carries the quadratic surface by auxiliary points.
    let alone = largest_error(interface(&layer, &slaves, options(Weight::Cubic), &[]));
    assert!(alone <= 0.1 * facets, "{alone} {facets}");
    // One facet carries no quadratic surface, and says so.
    let (nodes, facets) = (&layer.0, &layer.1[..1]);
    let corners = facets[0].corners().iter().map(|&node| nodes[node]);
    let middle = corners.fold([0.0; 3], |sum, x| [0, 1, 2].map(|k| sum[k] + 0.25 * x[k]));
    let mut found = interface(&(nodes.clone(), facets.to_vec()), &[middle], options(Weight::Cubic), &[]);
    let outcome = found.evaluate(Mode::Value).unwrap().get(0).outcome;
    assert!(matches!(outcome, Outcome::Contact { fallback: Fallback::Linear { .. } }), "{outcome:?}");
}

#[test]
fn elements_taken_out_are_those_of_the_interface_and_of_ad() {
    let mesh = wavy(8, 0.2);
    let planes = [SymmetryPlane::across(0, [0.0; 3])];
    let slaves: Vec<Point> = (0..12)
        .map(|k| (2.0 + 1.9 * noise(2 * k), 4.0 + 3.9 * noise(2 * k + 1)))
        .map(|(x, y)| [x, y, wave(x, y) - 0.02])
        .collect();
    for weight in Weight::ALL {
        let mut interface = interface(&mesh, &slaves, options(weight), &planes);
        interface.evaluate(Mode::Hessian).unwrap();
        for (k, contact) in interface.contacts().iter().enumerate() {
            let PairedElement::Diffuse { slave, pairing } = interface.element(k).unwrap() else {
                unreachable!()
            };
            let element = pairing.element(slave);
            let (own, witness) =
                (Generated.gap(&element, Mode::Hessian).unwrap(), Ad.gap(&element, Mode::Hessian).unwrap());
            assert!((own.gap - contact.point.gap).abs() < 1e-13);
            assert!((witness.gap - own.gap).abs() < 1e-13);
            let scale = witness.hessian.packed().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            for (x, y) in own.hessian.packed().iter().zip(witness.hessian.packed()) {
                assert!((x - y).abs() <= 1e-11 * scale, "{weight:?} {k}: {x} {y}");
            }
            // Linear and angular momentum, exactly.
            let mut force = [0.0; 3];
            let mut moment = [0.0; 3];
            let points: Vec<Point> =
                std::iter::once(slave).chain(pairing.positions.iter().copied()).collect();
            for (x, n) in points.iter().zip(own.gradient.as_chunks::<3>().0) {
                for axis in 0..3 {
                    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
                    force[axis] += n[axis];
                    moment[axis] += x[i] * n[j] - x[j] * n[i];
                }
            }
            for axis in 0..3 {
                assert!(force[axis].abs() < 1e-13 && moment[axis].abs() < 1e-12, "{force:?} {moment:?}");
            }
        }
    }
}

/// Domains lie in the first configuration, whenever planes are given.
#[test]
fn planes_given_later_find_the_same_domains() {
    let mesh = grid(6, 6, |x, y| [x, y, 0.05 * x * x]);
    let slaves: Vec<Point> = (0..20).map(|k| [0.2 * f64::from(k), 0.15 * f64::from(k), 0.9]).collect();
    let planes = [SymmetryPlane::across(0, [0.0; 3])];
    let stretched = |x: &Point| [1.3 * x[0], 0.8 * x[1], x[2]];
    let positions: Vec<Point> = mesh.0.iter().chain(&slaves).map(stretched).collect();
    let [mut before, mut after] =
        [&planes[..], &[]].map(|planes| interface(&mesh, &slaves, options(Weight::Cubic), planes));
    after.update(&positions).unwrap();
    after.set_symmetry(&planes).unwrap();
    for interface in [&mut before, &mut after] {
        interface.renew_pairing(&positions).unwrap();
    }
    assert_eq!(gaps(&mut before), gaps(&mut after));
}

#[test]
fn planes_through_the_surface_are_refused() {
    let mesh = wavy(5, 0.0);
    let mut positions = mesh.0.clone();
    positions.push([2.0, 2.0, 1.0]);
    let master = MasterSurface::new(&positions, mesh.1).unwrap();
    let options = InterfaceOptions::default();
    let mut interface = ContactInterface::new(master, vec![36], &[], &positions, options).unwrap();
    let at = |x| [SymmetryPlane::across(1, [0.0; 3]), SymmetryPlane::across(0, [x, 0.0, 0.0])];
    let error = interface.set_symmetry(&at(2.0)).unwrap_err();
    let expected = SurfaceError::CutBySymmetry { plane: 1, low: -2.0, high: 3.0 };
    assert_eq!(error, InterfaceError::Surface(expected));
    interface.set_symmetry(&at(0.001)).unwrap();
}

/// Their forces would go to mirrored places of the master.
#[test]
fn slaves_behind_a_plane_are_refused() {
    let mesh = wavy(5, 0.0);
    let positions = [&mesh.0[..], &[[2.0, 2.0, 1.0], [2.0, -0.3, 1.0], [-0.2, 1.0, 1.0]]].concat();
    let planes = [SymmetryPlane::across(0, [0.0; 3]), SymmetryPlane::across(1, [0.0; 3])];
    let with = |slaves: Vec<usize>| {
        let master = MasterSurface::new(&positions, mesh.1.clone()).unwrap();
        ContactInterface::new(master, slaves, &[], &positions, InterfaceOptions::default())
            .and_then(|mut interface| interface.set_symmetry(&planes))
    };
    with(vec![36]).unwrap();
    let expected = InterfaceError::SlaveBehindSymmetry { node: 37, plane: 1, distance: 0.3 };
    assert_eq!(with(vec![36, 38, 37]).unwrap_err(), expected);
    // The plane at the other end, whose normal points away from the surface.
    let far = SymmetryPlane::across(0, [5.0, 0.0, 0.0]);
    let beyond = [&mesh.0[..], &[[5.5, 2.0, 1.0]]].concat();
    let master = MasterSurface::new(&beyond, mesh.1.clone()).unwrap();
    let mut interface =
        ContactInterface::new(master, vec![36], &[], &beyond, InterfaceOptions::default()).unwrap();
    let error = interface.set_symmetry(&[far]).unwrap_err();
    assert_eq!(error, InterfaceError::SlaveBehindSymmetry { node: 36, plane: 0, distance: 0.5 });
}

#[test]
fn normals_of_nine_digits_are_unit_vectors() {
    let turned = |[x, y, z]: Point| [FRAC_1_SQRT_2 * (x - y), FRAC_1_SQRT_2 * (x + y), z];
    let mesh = grid(6, 6, |x, y| turned([x, y, wave(x, y)]));
    let slaves = [(0.3, 2.2), (2.6, 3.1)].map(|(x, y)| turned([x, y, wave(x, y) + 0.1]));
    let of = |digits: f64| {
        let plane = SymmetryPlane { point: [0.0; 3], normal: [digits, digits, 0.0] };
        gaps(&mut interface(&mesh, &slaves, options(Weight::Cubic), &[plane]))
    };
    let nine_digits = (FRAC_1_SQRT_2 * 1e9).round() * 1e-9;
    for (few, all) in of(nine_digits).into_iter().zip(of(FRAC_1_SQRT_2)) {
        assert!((few - all).abs() < 1e-14, "{few} {all}");
    }
}

/// How far nodes and slaves may be off a plane is by the cells there: images would lie among them. Far away cells are a hundred times as long.
#[test]
fn planes_off_by_a_fine_cell_are_refused_on_graded_surfaces() {
    let graded = |x: f64| if x <= 4.0 { x } else { 4.0 + 100.0 * (x - 4.0) };
    let (nodes, facets) = grid(6, 6, |x, y| [graded(x), y, 0.0]);
    let with = |plane: SymmetryPlane, slave: Point| {
        let positions = [&nodes[..], &[slave]].concat();
        let master = MasterSurface::new(&positions, facets.clone()).unwrap();
        ContactInterface::new(master, vec![nodes.len()], &[], &positions, InterfaceOptions::default())
            .and_then(|mut interface| interface.set_symmetry(&[plane]))
    };
    let at = |x: f64| SymmetryPlane::across(0, [x, 0.0, 0.0]);
    let slave = [50.0, 3.0, 0.1];
    for (x, is_accepted) in [(0.0, true), (0.009, true), (0.011, false), (0.5, false), (0.99, false)] {
        match with(at(x), slave) {
            Err(InterfaceError::Surface(SurfaceError::CutBySymmetry { plane: 0, low, high })) => {
                assert!(!is_accepted && low == -x && high == 204.0 - x, "{x} {low} {high}");
            }
            found => assert!(is_accepted && found == Ok(()), "{x} {found:?}"),
        }
    }
    for (x, is_accepted) in [(0.0, true), (-0.009, true), (-0.011, false), (-0.5, false)] {
        let expected = InterfaceError::SlaveBehindSymmetry { node: nodes.len(), plane: 0, distance: -x };
        assert_eq!(with(at(0.0), [x, 3.0, 0.1]), if is_accepted { Ok(()) } else { Err(expected) }, "{x}");
    }
    // At the coarse end a hundredth of a coarse cell is allowed.
    let far = |slave: Point| with(at(204.5), slave);
    assert_eq!((far(slave), far([204.9, 3.0, 0.1])), (Ok(()), Ok(())));
    assert!(matches!(far([206.0, 3.0, 0.1]), Err(InterfaceError::SlaveBehindSymmetry { .. })));
}

#[test]
fn other_rules_have_no_symmetry() {
    let mesh = wavy(5, 0.0);
    let mut positions = mesh.0.clone();
    positions.push([2.0, 2.0, 1.0]);
    let master = MasterSurface::new(&positions, mesh.1).unwrap();
    let element = ContactElement::diffuse(SearchOptions::default());
    let options = InterfaceOptions::default().with_element(element);
    let mut interface = ContactInterface::new(master, vec![36], &[], &positions, options).unwrap();
    let planes = [SymmetryPlane::across(0, [0.0; 3])];
    assert_eq!(interface.set_symmetry(&planes), Err(InterfaceError::NoSymmetry));
}

/// A small facet in the middle of a cell, the lowest or the highest in number: its neighbours' nodes are beyond its first reach.
#[test]
fn a_small_facet_among_large_ones_carries_a_quadratic_surface() {
    for is_first in [true, false] {
        let height = |x: f64, y: f64| 0.2 * (0.6 * x).sin() * (0.5 * y).cos();
        let (mut nodes, mut facets) = grid(9, 9, |x, y| [x, y, height(x, y)]);
        let cell = facets.remove(40);
        let around: Vec<usize> = cell.corners().to_vec();
        let first = nodes.len();
        let [x, y] = [0, 1].map(|axis| around.iter().map(|&k| nodes[k][axis]).sum::<f64>() / 4.0);
        let small = [[-0.05, -0.05], [0.05, -0.05], [0.05, 0.05], [-0.05, 0.05]];
        nodes.extend(small.map(|[a, b]| [x + a, y + b, height(x + a, y + b)]));
        let beside = (0..4).map(|k| {
            let next = (k + 1) % 4;
            Facet::Quadrilateral([around[k], around[next], first + next, first + k])
        });
        facets.extend(beside);
        let small = Facet::Quadrilateral([first, first + 1, first + 2, first + 3]);
        facets.insert(if is_first { 0 } else { facets.len() }, small);
        let at = |a: f64, b: f64| [x + a, y + b, height(x + a, y + b) + 0.01];
        let slaves = [at(0.0, 0.0), at(0.03, -0.02), at(0.2, 0.1), at(-0.3, 0.0)];
        let mut interface = interface(&(nodes.clone(), facets), &slaves, options(Weight::Cubic), &[]);
        let all: Vec<Point> = nodes.into_iter().chain(slaves).collect();
        let report = interface.renew_pairing(&all).unwrap();
        assert_eq!((report.paired, report.fallbacks.linear), (4, 0), "{is_first}");
        assert!(
            gaps(&mut interface).iter().all(|gap| (gap - 0.01).abs() < 2e-3),
            "{:?}",
            gaps(&mut interface)
        );
    }
}

/// A mesh that is turned or mirrored in space.
fn moved((nodes, facets): &(Vec<Point>, Vec<Facet>), map: &Matrix3<f64>) -> (Vec<Point>, Vec<Facet>) {
    // A mirror image is seen from the other side.
    let facet = |facet: &Facet| match *facet {
        Facet::Triangle([a, b, c]) if map.determinant() < 0.0 => Facet::Triangle([a, c, b]),
        Facet::Quadrilateral([a, b, c, d]) if map.determinant() < 0.0 => Facet::Quadrilateral([a, d, c, b]),
        _ => *facet,
    };
    (nodes.iter().map(|x| placed(map, *x)).collect(), facets.iter().map(facet).collect())
}

fn placed(map: &Matrix3<f64>, x: Point) -> Point {
    (map * Vector3::from(x) + Vector3::new(0.7, -2.0, 0.3)).into()
}

/// The volumes of the domains that reach each slave's place over that of an ellipsoid with half axes of one, and its distances in them.
fn domains(interface: &ContactInterface, slaves: usize) -> Vec<Vec<[f64; 2]>> {
    let of_slave = |k: usize| {
        let Ok(PairedElement::Diffuse { pairing, .. }) = interface.element(k) else { panic!("{k}") };
        let mut order: Vec<usize> = (0..pairing.masters.len()).collect();
        order.sort_by_key(|&k| (pairing.masters[k], pairing.others.get(k).map(|other| other.0)));
        let sizes = order.into_iter().map(|k| &pairing.material[k]).map(|node| {
            let [xx, _, _, yy, _, zz] = node.metric;
            [1.0 / (xx * yy * zz), node.distance()]
        });
        sizes.filter(|[_, distance]| *distance < 1.0 - 1e-9).collect()
    };
    (0..slaves).map(of_slave).collect()
}

/// Which nodes count, how large their domains are, and where auxiliary points lie does not depend on how the model lies in space.
#[test]
fn domains_turn_with_the_surface() {
    // Long and short cells with corners and borders, bent both ways; and triangles.
    let uneven = |x: f64, y: f64| {
        let k = (x * 1000.0 + y) as usize;
        let [by, on] = [0.22 * noise(2 * k), 0.22 * noise(2 * k + 1)];
        let along = 1.7 * x + if x > 4.0 { 1.5 * (x - 4.0) } else { 0.0 };
        let [x, y] = [along + 1.7 * by, y + on];
        [x, y, 0.03 * x * x - 0.05 * y * y + 0.02 * x * y]
    };
    let irregular = grid(8, 6, uneven);
    let halves = |facet: &Facet| match *facet {
        Facet::Quadrilateral([a, b, c, d]) => vec![Facet::Triangle([a, b, c]), Facet::Triangle([a, c, d])],
        Facet::Triangle(_) => vec![*facet],
    };
    let triangles = (irregular.0.clone(), irregular.1.iter().flat_map(halves).collect());
    // A strip of one row around a bend: rungs are as long as facets, by whose lengths ghost nodes lie outside.
    let turn = 0.3_f64;
    let chord = 2.0 * (0.5 * turn).sin();
    let strip = grid(9, 1, |x, y| [(turn * x).sin(), chord * y, (turn * x).cos()]);
    let over = |(nodes, facets): &(Vec<Point>, Vec<Facet>), by: f64| -> Vec<Point> {
        let at = |k: usize| Vector3::from(nodes[k]);
        let place = |facet: &Facet| {
            let corners = facet.corners();
            let [one, two, three] = [0, 1, 2].map(|k| at(corners[k]));
            let last = at(corners[corners.len() - 1]);
            let normal = (two - one).cross(&(last - one)).normalize();
            one * 0.45 + two * 0.2 + three * 0.25 + last * 0.1 + normal * by
        };
        facets.iter().map(|facet| place(facet).into()).collect()
    };
    let turn = Rotation3::from_euler_angles(0.4, -1.1, 2.3).into_inner();
    let mirror = turn * Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0));
    for (mesh, by) in [(irregular, 0.05), (triangles, 0.05), (strip, 0.01)] {
        let slaves = over(&mesh, by);
        for weight in [Weight::Cubic, Weight::WendlandC2] {
            let mut as_it_is = interface(&mesh, &slaves, options(weight), &[]);
            let expected = (domains(&as_it_is, slaves.len()), gaps(&mut as_it_is));
            for map in [turn, mirror] {
                let own: Vec<Point> = slaves.iter().map(|x| placed(&map, *x)).collect();
                let mut other = interface(&moved(&mesh, &map), &own, options(weight), &[]);
                for (one, two) in expected.0.iter().zip(domains(&other, slaves.len())) {
                    assert_eq!(one.len(), two.len(), "{weight:?}");
                    for (one, two) in one.iter().flatten().zip(two.iter().flatten()) {
                        assert!((one - two).abs() <= 1e-9 * one.abs().max(1.0), "{weight:?}: {one} {two}");
                    }
                }
                for (one, two) in expected.1.iter().zip(gaps(&mut other)) {
                    assert!((one - two).abs() < 1e-9, "{weight:?}: {one} {two}");
                }
            }
        }
    }
}
