//! Sheets end where their topology says so: sharp edges, thin plates, borders, corners, holes and slits, by either rule.

use diffuse_contact::interface::{InterfaceOptions, PairedElement};
use diffuse_contact::surface::Facet;
use diffuse_contact::{Mode, Point};

use crate::common::{Mesh, Scene, Uniform, hull_layers, worse};

/// The default, and hull layers.
fn rules() -> [(&'static str, InterfaceOptions); 2] {
    [("domains", InterfaceOptions::default()), ("hull layers", hull_layers())]
}

fn gap(scene: &mut Scene, k: usize) -> Option<f64> {
    let contact = scene.interface.evaluate(Mode::Value).unwrap().get(k);
    contact.outcome.is_contact().then_some(contact.point.gap)
}

/// A slave that slides: where it is, its gap, and by how much a refresh changes it there.
fn slide(mesh: &Mesh, options: InterfaceOptions, path: impl Fn(f64) -> Point, steps: u32) -> Vec<[f64; 3]> {
    let mut scene = mesh.paired(&[path(0.0)], options);
    let step = |k: u32| {
        let turn = f64::from(k) / f64::from(steps);
        scene.move_slaves(&[path(turn)]);
        scene.interface.follow(&scene.positions).unwrap();
        let before = gap(&mut scene, 0).unwrap_or_else(|| panic!("no contact at {:?}", path(turn)));
        scene.interface.renew_pairing(&scene.positions).unwrap();
        let after = gap(&mut scene, 0).unwrap();
        [turn, after, (after - before).abs()]
    };
    (0..=steps).map(step).collect()
}

/// The masters of a slave that have a weight, with domains.
fn weighted(scene: &Scene, k: usize) -> impl Iterator<Item = Point> {
    let Ok(PairedElement::Diffuse { pairing, .. }) = scene.interface.element(k) else { panic!("no pairing") };
    let is_near: Vec<bool> = pairing.material.iter().map(|node| node.distance() < 1.0).collect();
    pairing.positions.into_iter().zip(is_near).filter(|(_, is_near)| *is_near).map(|(x, _)| x)
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, worse)
}

#[test]
fn around_sharp_edges_masters_lie_on_one_face() {
    let cube = Mesh::cube(8);
    let mut random = Uniform(4);
    // Anywhere over the faces, up to their edges.
    let slaves: Vec<(Point, usize, f64)> = (0..600)
        .map(|k| {
            let (axis, side) = (k % 3, if k % 2 == 0 { 1.0 } else { -1.0 });
            let gap = 0.2 * random.next() - 0.02;
            let along = |random: &mut Uniform| random.signed() * if gap < 0.0 { 0.97 } else { 0.999 };
            let mut x = [along(&mut random), along(&mut random), along(&mut random)];
            x[axis] = side * (1.0 + gap);
            (x, axis, gap)
        })
        .collect();
    let places: Vec<Point> = slaves.iter().map(|(x, ..)| *x).collect();
    for (rule, options) in rules() {
        let mut scene = cube.paired(&places, options);
        assert_eq!(scene.refresh().fallbacks.linear, 0, "{rule}");
        for (contact, &(x, axis, gap)) in scene.interface.evaluate(Mode::Value).unwrap().iter().zip(&slaves) {
            assert!(contact.outcome.is_contact(), "{rule} {x:?} {:?}", contact.outcome);
            let face = x[axis].signum();
            let is_on_face = |&node: &u32| cube.positions[node as usize][axis] == face;
            assert!(contact.nodes.iter().all(is_on_face), "{rule} {x:?}");
            assert!((contact.point.gap - gap).abs() < 1e-12, "{rule} {x:?} {}", contact.point.gap);
        }
        // Without a feature angle the fit rounds the edge.
        let mut scene = cube.paired(&[[0.9, 0.9, 1.01]], options.with_feature_angle_degrees(180.0));
        assert!((gap(&mut scene, 0).unwrap() - 0.01).abs() < 1e-12, "{rule} {:?}", gap(&mut scene, 0));
        let nodes = scene.interface.evaluate(Mode::Value).unwrap().get(0).nodes.to_vec();
        let is_above = |&node: &u32| cube.positions[node as usize][2] == 1.0;
        assert!(nodes.iter().all(is_above), "{rule}: faces at 90° are beyond the turn");
    }
}

#[test]
fn a_slave_over_a_sharp_edge_has_no_contact_until_it_comes_over_a_face() {
    for (rule, options) in rules() {
        let mut scene = Mesh::cube(8).paired(&[[1.05, 0.1, 1.06], [0.9, 0.1, 1.05]], options);
        let outcome = |scene: &mut Scene, k| scene.interface.evaluate(Mode::Value).unwrap().get(k).outcome;
        assert_eq!(outcome(&mut scene, 0).code(), "beyond-border", "{rule}");
        assert!(outcome(&mut scene, 1).is_contact(), "{rule}");
        // The face's fit extended past the edge would say that this slave penetrates by 0.3.
        scene.move_slaves(&[[0.96, 0.1, 1.05], [1.1, 0.1, 0.7]]);
        scene.update();
        assert!(outcome(&mut scene, 0).is_contact(), "{rule}");
        assert_eq!(outcome(&mut scene, 1).code(), "beyond-border", "{rule}");
        scene.refresh();
        assert!((gap(&mut scene, 1).unwrap() - 0.1).abs() < 1e-12, "{rule}: of the side face");
    }
}

#[test]
fn both_sides_of_a_thin_plate_are_told_apart() {
    let plate = Mesh::block([20, 20, 1], [1.0, 1.0, 0.01]);
    let mut random = Uniform(8);
    let slaves: Vec<Point> = (0..200)
        .map(|k| {
            let side = if k % 2 == 0 { 1.0 } else { -1.0 };
            [0.98 * random.signed(), 0.98 * random.signed(), side * (0.01 + 0.05 * random.next() - 0.004)]
        })
        .collect();
    for (rule, options) in rules() {
        let mut scene = plate.paired(&slaves, options);
        assert_eq!(scene.refresh().fallbacks.linear, 0, "{rule}");
        for (contact, x) in scene.interface.evaluate(Mode::Value).unwrap().iter().zip(&slaves) {
            assert!(contact.outcome.is_contact(), "{rule} {x:?} {:?}", contact.outcome);
            let error = contact.point.gap - (x[2].abs() - 0.01);
            assert!(error.abs() < 1e-12, "{rule} {x:?} {}", contact.point.gap);
            assert!(
                contact.nodes.iter().all(|&node| plate.positions[node as usize][2] * x[2] > 0.0),
                "{rule}"
            );
        }
    }
}

/// A node on a sharp edge has a domain of its own in each sheet: over a face all is as if there were no others.
#[test]
fn a_face_of_a_body_has_the_bits_of_the_face_alone() {
    let mut body = Mesh::block([10, 8, 1], [5.0, 4.0, 0.3]);
    let is_above: Vec<bool> = body.positions.iter().map(|x| x[2] > 0.0).collect();
    let wave = |x: f64, y: f64| 0.3 * (0.6 * x).sin() * (0.4 * y).cos();
    for x in &mut body.positions {
        x[2] += wave(x[0], x[1]);
    }
    let above = |facet: &&Facet| facet.corners().iter().all(|&node| is_above[node]);
    let facets = body.facets.iter().filter(above).copied().collect();
    let face = Mesh { positions: body.positions.clone(), facets };
    let mut random = Uniform(5);
    let slaves: Vec<Point> = (0..300)
        .map(|_| {
            let (x, y) = (4.9 * random.signed(), 3.9 * random.signed());
            [x, y, 0.35 + wave(x, y) + 0.1 * random.next()]
        })
        .collect();
    let [of_body, of_face] = [&body, &face].map(|mesh| {
        let mut scene = mesh.paired(&slaves, InterfaceOptions::default());
        let contacts = scene.interface.evaluate(Mode::Hessian).unwrap();
        let bits = |numbers: &[f64]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
        let numbers = contacts.iter().map(|contact| {
            assert!(contact.outcome.is_contact(), "{:?}", contact.outcome);
            let point = [&[contact.point.gap], &contact.point.normal[..]].concat();
            (contact.nodes.to_vec(), bits(&point), bits(contact.gradient), bits(contact.hessian))
        });
        numbers.collect::<Vec<_>>()
    });
    assert!(of_body == of_face);
}

/// A shallow bowl, z = (x² + y²)/40, and its unit normal.
fn bowl(x: f64, y: f64) -> (Point, Point) {
    let length = (1.0 + (x * x + y * y) / 400.0).sqrt();
    ([x, y, (x * x + y * y) / 40.0], [-x / 20.0, -y / 20.0, 1.0].map(|n| n / length))
}

/// A point so far above the bowl.
fn above_bowl([x, y]: [f64; 2], height: f64) -> Point {
    let (foot, normal) = bowl(x, y);
    [0, 1, 2].map(|axis| foot[axis] + height * normal[axis])
}

/// Along both borders that meet in a corner, and across it.
#[test]
fn a_corner_of_a_curved_sheet_is_as_smooth_as_its_inside() {
    let sheet = Mesh::grid([11, 11], [false; 2], |s, t| bowl(10.0 * s, 10.0 * t).0);
    let path = |turn: f64| {
        let place = if turn < 0.5 { [5.0 - 9.8 * turn, 0.1] } else { [0.1, 0.1 + 9.8 * (turn - 0.5)] };
        above_bowl(place, 0.1)
    };
    let across = |turn: f64| above_bowl([4.0 * turn + 0.05; 2], 0.1);
    let walked = [
        slide(&sheet, InterfaceOptions::default(), path, 400),
        slide(&sheet, InterfaceOptions::default(), across, 200),
    ]
    .concat();
    let (jump, error) = (largest(walked.iter().map(|s| s[2])), largest(walked.iter().map(|s| s[1] - 0.1)));
    println!("domains: jump {jump:e}, error {error:e}");
    assert!(jump < 1e-13 && error < 2e-4, "{jump:e} {error:e}");
    let facets =
        largest(slide(&sheet, InterfaceOptions::node_to_facet(), path, 400).iter().map(|s| s[1] - 0.1));
    println!("facets: error {facets:e}");
    assert!(error < 0.02 * facets, "{error:e} {facets:e}");
}

/// A ring around a hole: its rim is a border like another.
#[test]
fn around_a_hole_the_rim_is_a_border() {
    let ring = Mesh::grid([24, 6], [true, false], |s, t| {
        let (sin, cos) = (std::f64::consts::TAU * s).sin_cos();
        // Outside above: s × t points there when t goes inward.
        let radius = 6.0 - 4.0 * t;
        bowl(radius * cos, radius * sin).0
    });
    let around = |radius: f64| {
        move |turn: f64| {
            let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
            above_bowl([radius * cos, radius * sin], 0.1)
        }
    };
    for (radius, bound) in [(2.1, 1e-3), (4.0, 2e-3)] {
        let walked = slide(&ring, InterfaceOptions::default(), around(radius), 300);
        let (jump, error) =
            (largest(walked.iter().map(|s| s[2])), largest(walked.iter().map(|s| s[1] - 0.1)));
        println!("radius {radius}: jump {jump:e}, error {error:e}");
        assert!(jump < 1e-13 && error < bound, "{radius}: {jump:e} {error:e}");
    }
    let mut scene =
        ring.paired(&[above_bowl([2.1, 0.3], 0.1), [0.3, -0.2, 0.2]], InterfaceOptions::default());
    let contacts = scene.interface.evaluate(Mode::Value).unwrap();
    assert!(contacts.get(0).outcome.is_contact());
    assert_eq!(contacts.get(1).outcome.code(), "beyond-border", "over the hole");
}

/// A plate of 20 × 20 cells with a slit along y = 10 up to its middle. The upper side, whose lip has nodes of its own, is lifted towards
/// x = 0, by `lift` there.
fn slit(lift: f64) -> Mesh {
    let mut mesh = Mesh::plane(20.0, 20.0, 1.0);
    let lip: Vec<usize> = (0..mesh.positions.len())
        .filter(|&node| mesh.positions[node][1] == 10.0 && mesh.positions[node][0] < 10.0)
        .collect();
    let first = mesh.positions.len();
    mesh.positions.extend(lip.iter().map(|&node| mesh.positions[node]).collect::<Vec<_>>());
    let middle = |facet: &Facet| {
        facet.corners().iter().map(|&node| mesh.positions[node][1]).sum::<f64>()
            / facet.corners().len() as f64
    };
    let is_upper: Vec<bool> = mesh.facets.iter().map(|facet| middle(facet) > 10.0).collect();
    let own = |node: usize| lip.iter().position(|&other| other == node).map_or(node, |k| first + k);
    for (facet, _) in mesh.facets.iter_mut().zip(is_upper).filter(|(_, is_upper)| *is_upper) {
        *facet = match facet {
            Facet::Triangle(corners) => Facet::Triangle(corners.map(own)),
            Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners.map(own)),
        };
    }
    for (node, x) in mesh.positions.iter_mut().enumerate() {
        if x[1] > 10.0 || node >= first {
            x[2] = lifted(lift, x[0]);
        }
    }
    mesh
}

fn lifted(lift: f64, x: f64) -> f64 {
    lift * ((10.0 - x).max(0.0) / 10.0).powi(2)
}

/// Both lips of a slit are told apart. Within two cells of its end distance decides, not topology: there masters of the other lip come
/// and go, and a refresh changes the gap. That is a limit of what there is, stated with its size.
#[test]
fn the_lips_of_a_slit_are_told_apart_but_near_its_end() {
    let mesh = slit(1.0);
    let place = |turn: f64| 1.0 + 18.0 * turn;
    let above = |turn: f64| {
        let x = place(turn);
        [x, 10.3, lifted(1.0, x) + 0.1]
    };
    let walked = slide(&mesh, InterfaceOptions::default(), above, 720);
    let jump = |from: f64, to: f64| {
        let inside = walked.iter().filter(|step| (from..to).contains(&place(step[0])));
        largest(inside.map(|step| step[2]))
    };
    let near = jump(8.0, 10.0);
    println!("jump near the end {near}, gaps off by {}", largest(walked.iter().map(|step| step[1] - 0.1)));
    assert_eq!((jump(0.0, 8.0), jump(10.0, 20.0)), (0.0, 0.0));
    assert!((1e-3..0.01).contains(&near), "{near}");
    // The height over the parabola is not the distance from it: they differ by 2 % at most.
    assert!(walked.iter().all(|step| (step[1] - 0.1).abs() < 6e-3));
    // Away from the end none is of the other lip, which is lower by 0.1 at least.
    let places: Vec<Point> = (0..20).map(|k| above(f64::from(k) / 120.0)).collect();
    let scene = mesh.paired(&places, InterfaceOptions::default());
    let is_own = |k: usize| weighted(&scene, k).all(|x| x[1] >= 10.0 && x[2] == lifted(1.0, x[0]));
    let others: Vec<usize> = (0..20).filter(|&k| !is_own(k)).collect();
    assert!(others.is_empty(), "{others:?}");
}

/// A quarter of a drawing die: a wall, a rounding of radius 6 and a flat ring z = 0 from radius 33 on, in 18 sectors.
fn die() -> Mesh {
    let profile = |k: usize| match k {
        0..=3 => [27.0, -26.0 + 5.0 * k as f64],
        4..=10 => {
            let (sin, cos) = (15.0 * (k - 4) as f64).to_radians().sin_cos();
            [33.0 - 6.0 * cos, 6.0 * (sin - 1.0)]
        }
        _ => [33.0 + 29.0 / 6.0 * (k - 10) as f64, 0.0],
    };
    let node = |k: usize| {
        let ([radius, z], angle) = (profile(k % 17), (5.0 * (k / 17) as f64).to_radians());
        [radius * angle.cos(), radius * angle.sin(), z]
    };
    let corner = |cell: usize| cell % 16 + 17 * (cell / 16);
    let facet = |k: usize| Facet::Quadrilateral([k, k + 1, k + 18, k + 17]);
    Mesh {
        positions: (0..17 * 19).map(node).collect(),
        facets: (0..16 * 18).map(|cell| facet(corner(cell))).collect(),
    }
}

/// The flat part of the die is flat up to its border. The first row of its cells ends where the rounding begins, and there domains reach
/// across: that is a limit of what there is, stated with its size.
#[test]
fn the_flat_part_of_a_die_is_flat_but_beside_its_rounding() {
    let places = [0.0, 2.5, 5.0, 10.0, 22.5, 45.0, 67.5, 90.0_f64];
    let slaves: Vec<Point> = (34..60)
        .flat_map(|radius| places.map(|angle| (f64::from(radius), angle.to_radians())))
        .map(|(radius, angle)| [radius * angle.cos(), radius * angle.sin(), 0.0])
        .collect();
    let mut scene = die().paired(&slaves, InterfaceOptions::default());
    let gaps: Vec<f64> = (0..slaves.len()).map(|k| gap(&mut scene, k).unwrap()).collect();
    let (beside, flat) = gaps.split_at(places.len());
    println!("{:e} {:e}", largest(beside.iter().copied()), largest(flat.iter().copied()));
    assert!(largest(flat.iter().copied()) <= 1e-9, "{flat:?}");
    let off = largest(beside.iter().copied());
    assert!((0.01..0.07).contains(&off), "{beside:?}");
}

/// Cells of a ring lie at all angles to the axes; however long they are, a slave needs no more masters for it.
#[test]
fn the_cells_of_a_ring_may_be_as_long_as_they_like() {
    for (around, across) in [(24, 6), (24, 12), (36, 6), (48, 12)] {
        let ring = Mesh::grid([around, across], [true, false], |s, t| {
            let (sin, cos) = (std::f64::consts::TAU * s).sin_cos();
            let radius = 6.0 - 4.0 * t;
            bowl(radius * cos, radius * sin).0
        });
        let slaves: Vec<Point> = (0..400)
            .map(|k| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 400.0).sin_cos();
                let radius = 2.1 + 3.8 * (0.618_034 * f64::from(k)).fract();
                above_bowl([radius * cos, radius * sin], 0.1)
            })
            .collect();
        let scene = ring.paired(&slaves, InterfaceOptions::default());
        let masters: Vec<usize> = (0..slaves.len())
            .map(|slave| {
                let Ok(PairedElement::Diffuse { pairing, .. }) = scene.interface.element(slave) else {
                    panic!("{slave}")
                };
                pairing.material.iter().filter(|node| node.distance() < 1.0).count()
            })
            .collect();
        let (mean, largest) =
            (masters.iter().sum::<usize>() as f64 / slaves.len() as f64, *masters.iter().max().unwrap());
        println!("{around} × {across}: {mean} masters, at most {largest}");
        assert!(mean < 14.0 && largest <= 24, "{around} × {across}: {mean}, {largest}");
    }
}

/// A thin plate, waved: its rim is a row of two cells that bends in its plane, and asks for nodes from end to end.
#[test]
fn the_rim_of_a_wavy_plate_does_not_reach_into_its_faces() {
    let wave = |[x, y, z]: Point| [x, y, z + 0.2 * (0.8 * x).sin()];
    let mut plate = Mesh::block([12, 8, 2], [6.0, 4.0, 0.25]);
    plate.positions = plate.positions.into_iter().map(wave).collect();
    let mut random = Uniform(12);
    let slaves: Vec<Point> =
        (0..400).map(|_| wave([4.5 * random.signed(), 2.5 * random.signed(), 0.25])).collect();
    let mut scene = plate.paired(&slaves, InterfaceOptions::default());
    let contacts = scene.interface.evaluate(Mode::Value).unwrap();
    assert!(contacts.iter().all(|contact| contact.outcome.is_contact()));
    let error = largest(contacts.iter().map(|contact| contact.point.gap));
    let most = (0..slaves.len()).map(|k| weighted(&scene, k).count()).max().unwrap();
    assert!(error < 6e-3 && most <= 24, "{error} {most}");
}

/// Long triangles of different shapes: a straight way to a node is over facets whose corners are all farther than the node.
#[test]
fn over_long_triangles_lists_are_complete() {
    let height = |x: f64, y: f64| 0.3 * (0.7 * x).sin() * (0.6 * y).cos();
    let mut random = Uniform(3);
    let mut triangles = Mesh::grid([13, 4], [false; 2], |s, t| [s, t, 0.0]);
    for x in &mut triangles.positions {
        let mut moved = |x: f64, cells: f64| {
            let by = 0.3 * random.signed();
            12.0 * if x > 0.0 && x < 1.0 { x + by / cells } else { x }
        };
        let (a, b) = (moved(x[0], 12.0), moved(x[1], 3.0));
        *x = [a, b, height(a, b)];
    }
    let halves = |facet: &Facet| match *facet {
        Facet::Quadrilateral([a, b, c, d]) => vec![Facet::Triangle([a, b, d]), Facet::Triangle([b, c, d])],
        triangle @ Facet::Triangle(_) => vec![triangle],
    };
    triangles.facets = triangles.facets.iter().flat_map(halves).collect();
    for start in [3.2, 5.1, 7.4] {
        let path = |t: f64| {
            let (x, y) = (2.0 + 8.0 * t, start + 1.3 * t);
            [x, y, height(x, y) + 0.02]
        };
        let steps = slide(&triangles, InterfaceOptions::default(), path, 2000);
        let jump = largest(steps.windows(3).map(|steps| steps[0][1] - 2.0 * steps[1][1] + steps[2][1]));
        assert!(jump < 1e-4, "{start}: {jump}");
    }
}
