//! Which nodes a neighbourhood consists of: against a Delaunay triangulation, on regular grids in any position and
//! order, around nodes that coincide, on thin and curved surfaces.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use crate::neighbourhood_cases::{PLACES, UP, Uniform, find, flat_cloud, hull, lattice, lattices};
use diffuse_contact::neighbourhood::{
    NeighbourRule, NeighbourSearch, NeighbourhoodError, Outward, SMALLEST_REGULARITY, SearchOptions,
    TOLERANCE, hull_layers,
};
use diffuse_contact::pairing::{NearestNodes, node_normals};
use diffuse_contact::{Basis, Point};
use nalgebra::Vector3;
use spade::{DelaunayTriangulation, Point2, Triangulation};

/// Neighbours of `slave` in the Delaunay triangulation of it and all points, seen from above.
fn delaunay_ring(points: &[Point], slave: Point) -> Vec<usize> {
    let mut triangulation = DelaunayTriangulation::<Point2<f64>>::new();
    let handles: Vec<_> =
        points.iter().map(|x| triangulation.insert(Point2::new(x[0], x[1])).unwrap()).collect();
    let centre = triangulation.insert(Point2::new(slave[0], slave[1])).unwrap();
    let ring: BTreeSet<_> = triangulation.vertex(centre).out_edges().map(|edge| edge.to().fix()).collect();
    (0..points.len()).filter(|&k| ring.contains(&handles[k])).collect()
}

#[test]
fn the_first_layer_is_the_delaunay_ring() {
    let mut random = Uniform(1);
    let (mut enclosed, mut certain, mut one_layer) = (0, 0, 0);
    for cloud in 0..200 {
        let points = flat_cloud(&mut random, 300);
        let nodes = NearestNodes::new(points.clone()).unwrap();
        let mut search = NeighbourSearch::new(hull(None)).unwrap();
        for _ in 0..10 {
            let slave = [0.05 + 0.9 * random.next(), 0.05 + 0.9 * random.next(), 0.05 * random.next()];
            let found = search.find(&nodes, slave, UP).unwrap();
            enclosed += usize::from(found.encloses_slave);
            certain += usize::from(found.complete);
            one_layer += usize::from(found.layers.len() == 1);
            if found.encloses_slave && found.complete {
                assert_eq!(found.layers[0], delaunay_ring(&points, slave), "cloud {cloud}, slave {slave:?}");
            }
            assert!(found.regularity > SMALLEST_REGULARITY && found.condition.is_finite(), "{found:?}");
        }
    }
    println!("of 2000: {enclosed} enclosed, {certain} certain, {one_layer} with one layer");
    assert!(enclosed >= 1990 && certain >= 1800, "{enclosed} enclosed, {certain} certain");
    assert!((200..1800).contains(&one_layer));
}

#[test]
fn beyond_the_border_the_layer_is_part_of_the_delaunay_ring() {
    let mut random = Uniform(2);
    for _ in 0..200 {
        let points = flat_cloud(&mut random, 120);
        let angle = 2.0 * PI * random.next();
        let distance = 0.72 + 0.5 * random.next();
        let slave = [0.5 + distance * angle.cos(), 0.5 + distance * angle.sin(), 0.1];
        let found = hull_layers(slave, &points, UP, 2).unwrap();
        assert!(!found.encloses_slave);
        assert!(found.layers[0].contains(&found.nodes[0]), "the nearest node belongs to the layer");
        let ring = delaunay_ring(&points, slave);
        for &node in found.layers[0].iter().filter(|k| !ring.contains(k)) {
            // Within the tolerance of a circle through the slave and two nodes of the layer.
            let image = |k: usize| {
                let [a, b] = [points[k][0] - slave[0], points[k][1] - slave[1]];
                [a / (a * a + b * b), b / (a * a + b * b)]
            };
            let q = image(node);
            let on_edge = |i: usize, j: usize| {
                let [[a, b], [c, d]] = [image(i), image(j)];
                let height = ((c - a) * (q[1] - b) - (d - b) * (q[0] - a)) / (c - a).hypot(d - b);
                height.abs() <= TOLERANCE * q[0].hypot(q[1])
            };
            let pairs = ring.iter().flat_map(|&i| ring.iter().map(move |&j| (i, j)));
            assert!(pairs.filter(|(i, j)| i < j).any(|(i, j)| on_edge(i, j)), "{node} not among {ring:?}");
        }
    }
}

#[test]
fn on_regular_grids_the_answer_does_not_depend_on_rotation_and_position() {
    let mut random = Uniform(3);
    for (name, u, v) in lattices() {
        let (grid, _) = lattice(u, v, 12);
        for [i, j] in PLACES {
            let slave = [i * u[0] + j * v[0], i * u[1] + j * v[1], 0.3];
            for layers in 1..=3 {
                let expected = hull_layers(slave, &grid, UP, layers).unwrap();
                assert!(expected.encloses_slave && expected.complete, "{name} {i} {j} {layers}");
                for trial in 0..25 {
                    let rotation = random.rotation();
                    let far = if trial % 5 == 0 { 0.0 } else { 10.0_f64.powi(trial % 5 + 2) };
                    let shift = Vector3::from(random.point().map(|x| (x - 0.5) * far));
                    let place = |x: Point| Point::from(rotation * Vector3::from(x) + shift);
                    let moved: Vec<Point> = grid.iter().map(|&x| place(x)).collect();
                    let outward = Point::from(rotation * Vector3::from(UP));
                    let found = hull_layers(place(slave), &moved, outward, layers).unwrap();
                    assert_eq!(found.at_slave, expected.at_slave, "{name} {i} {j} {far}");
                    assert_eq!(found.layers, expected.layers, "{name} {i} {j} {far}");
                    assert!((found.support_radius / expected.support_radius - 1.0).abs() < 1e-8);
                }
            }
        }
    }
}

#[test]
fn on_a_rotated_grid_the_borders_are_the_same_too() {
    let mut random = Uniform(4);
    let (grid, integers) = lattice([1.0, 0.0], [0.0, 1.0], 6);
    // The middle of a border, between two of its nodes, a corner, and off each of them.
    for slave in [[-6.0, 0.0], [-6.0, 0.5], [-6.0, -6.0], [-6.3, 0.2], [-6.2, -6.1], [-9.0, 0.3], [-5.9, 0.3]]
    {
        let slave = [slave[0], slave[1], 0.2];
        let expected = hull_layers(slave, &grid, UP, 2).unwrap();
        assert_eq!(expected.encloses_slave, slave[0] >= -6.0, "{slave:?}");
        let farthest = expected.nodes.last().map(|&k| integers[k]).unwrap();
        assert!(f64::from(farthest[0]) - slave[0] < 5.0 && (f64::from(farthest[1]) - slave[1]).abs() < 6.0);
        for _ in 0..25 {
            let rotation = random.rotation();
            let turn = |x: Point| Point::from(rotation * Vector3::from(x));
            let turned: Vec<Point> = grid.iter().map(|&x| turn(x)).collect();
            let found = hull_layers(turn(slave), &turned, turn(UP), 2).unwrap();
            assert_eq!(found.layers, expected.layers, "{slave:?}");
            assert_eq!(found.encloses_slave, expected.encloses_slave);
        }
    }
}

#[test]
fn a_node_on_the_slave_takes_part_outside_the_layers() {
    let (grid, _) = lattice([1.0, 0.0], [0.0, 1.0], 6);
    let middle = 6 * 13 + 6;
    let expected = hull_layers([0.0, 0.0, 0.5], &grid, UP, 2).unwrap();
    assert_eq!((expected.at_slave.as_slice(), expected.nodes[0]), ([middle].as_slice(), middle));
    assert_eq!(expected.layers.iter().map(Vec::len).collect::<Vec<_>>(), [8, 12]);
    for off in [1e-300, 1e-14, -1e-9, 1e-7] {
        let found = hull_layers([off, -off, 0.5], &grid, UP, 2).unwrap();
        assert_eq!((&found.at_slave, &found.layers), (&expected.at_slave, &expected.layers), "{off:e}");
    }
    let found = hull_layers([1e-3, 1e-3, 0.5], &grid, UP, 2).unwrap();
    assert_eq!(found.layers[0], [middle, middle + 1, middle + 13, middle + 14], "the corners of the cell");
}

#[test]
fn coincident_nodes_are_all_kept() {
    let mut random = Uniform(7);
    let mut once = flat_cloud(&mut random, 80);
    once.push([0.5, 0.5, 0.0]);
    let twice: Vec<Point> = once.iter().chain(&once).copied().collect();
    let both =
        |nodes: &[usize]| -> BTreeSet<usize> { nodes.iter().flat_map(|&k| [k, k + once.len()]).collect() };
    for slave in [[0.5, 0.5, 0.1], [0.5001, 0.5, 0.1], [0.3, 0.7, 0.0]] {
        let expected = hull_layers(slave, &once, UP, 2).unwrap();
        let found = hull_layers(slave, &twice, UP, 2).unwrap();
        assert_eq!(found.at_slave, both(&expected.at_slave).into_iter().collect::<Vec<_>>());
        for (found, expected) in found.layers.iter().zip(&expected.layers) {
            assert_eq!(*found, both(expected).into_iter().collect::<Vec<_>>());
        }
        assert_eq!(found.nodes.len(), 2 * expected.nodes.len());
        assert!(expected.pivot_ratio == 0.0 || (found.pivot_ratio / expected.pivot_ratio - 1.0).abs() < 1e-6);
    }
    // Five hundred copies of each corner of a square: ties without end.
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let heap: Vec<Point> = (0..2000).map(|k| corners[k % 4]).collect();
    let found = find(&heap, [0.4, 0.4, 0.1], hull(None)).map(|found| found.basis);
    assert!(matches!(
        found,
        Ok(Basis::Linear)
            | Err(NeighbourhoodError::NoAveragePlane { .. } | NeighbourhoodError::IllConditioned { .. })
    ));
}

#[test]
fn more_layers_begin_with_the_same_layers() {
    let mut random = Uniform(8);
    for _ in 0..50 {
        let points = flat_cloud(&mut random, 400);
        let slave = [0.1 + 0.8 * random.next(), 0.1 + 0.8 * random.next(), 0.0];
        let all = hull_layers(slave, &points, UP, 5).unwrap();
        assert_eq!(all.layers.len(), 5);
        for layers in 1..5 {
            let fewer = hull_layers(slave, &points, UP, layers).unwrap();
            assert_eq!(fewer.layers, all.layers[..layers]);
            assert!(fewer.support_radius <= all.support_radius * (1.0 + 1e-12));
        }
        let mut members: Vec<usize> = all.layers.concat();
        let mut nodes = all.nodes.clone();
        members.sort_unstable();
        nodes.sort_unstable();
        assert_eq!(nodes, members, "every node in one layer, and in one only");
    }
}

#[test]
fn the_order_of_the_nodes_does_not_matter() {
    let mut random = Uniform(9);
    let (grid, _) = lattice([1.0, 0.0], [0.0, 1.0], 8);
    for trial in 0..60 {
        let points = if trial % 2 == 0 { grid.clone() } else { flat_cloud(&mut random, 200) };
        let slave = match trial % 4 {
            0 => [0.0, 0.0, 0.2],
            2 => [0.5, 0.5, 0.2],
            _ => [random.next(), random.next(), 0.2],
        };
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by_cached_key(|_| (random.next() * 1e9) as u64);
        let shuffled: Vec<Point> = order.iter().map(|&k| points[k]).collect();
        for rule in [NeighbourRule::hull_layers(None), NeighbourRule::hull_radius(Some(2))] {
            let options = SearchOptions::default().with_rule(rule);
            let expected = find(&points, slave, options).unwrap();
            let found = find(&shuffled, slave, options).unwrap();
            let sorted = |nodes: &[usize]| -> BTreeSet<usize> { nodes.iter().map(|&k| order[k]).collect() };
            assert_eq!(sorted(&found.nodes), expected.nodes.iter().copied().collect());
            assert_eq!(found.layers.len(), expected.layers.len());
            for (found, expected) in found.layers.iter().zip(&expected.layers) {
                assert_eq!(sorted(found), expected.iter().copied().collect());
            }
        }
    }
}

#[test]
fn one_search_object_serves_many_slaves() {
    let mut random = Uniform(10);
    let points = flat_cloud(&mut random, 500);
    let nodes = NearestNodes::new(points.clone()).unwrap();
    let mut search = NeighbourSearch::new(SearchOptions::default()).unwrap();
    for _ in 0..100 {
        let slave = [1.2 * random.next() - 0.1, 1.2 * random.next() - 0.1, 0.0];
        assert_eq!(search.find(&nodes, slave, UP), find(&points, slave, SearchOptions::default()));
    }
}

#[test]
fn the_hull_radius_takes_in_every_node_inside() {
    let mut random = Uniform(11);
    for _ in 0..50 {
        let points = flat_cloud(&mut random, 400);
        let slave = [0.2 + 0.6 * random.next(), 0.2 + 0.6 * random.next(), 0.0];
        let options = SearchOptions::default().with_rule(NeighbourRule::hull_radius(Some(1)));
        let found = find(&points, slave, options).unwrap();
        let distance = |k: usize| (points[k][0] - slave[0]).hypot(points[k][1] - slave[1]);
        let inside: BTreeSet<usize> =
            (0..points.len()).filter(|&k| distance(k) < found.support_radius).collect();
        assert!(found.complete);
        assert_eq!(found.nodes.iter().copied().collect::<BTreeSet<_>>(), inside);
        let farthest = found.layers.concat().into_iter().map(distance).fold(0.0, f64::max);
        assert!((found.support_radius / farthest / options.radius_factor - 1.0).abs() < 1e-12);
    }
}

#[test]
fn the_far_face_of_a_plate_is_kept_out() {
    let face = |z: f64| (0..121).map(move |k| [f64::from(k % 11), f64::from(k / 11), z]);
    let plate: Vec<Point> = face(0.0).chain(face(-0.3)).collect();
    let cell = |k: usize| k % 10 + 11 * (k / 10);
    let upper = (0..100).map(cell).map(|k| [k, k + 1, k + 12, k + 11]);
    let lower = (0..100).map(cell).map(|k| [k + 121, k + 132, k + 133, k + 122]);
    let facets: Vec<[usize; 4]> = upper.chain(lower).collect();
    let normals = node_normals(&plate, &facets);
    let nodes = NearestNodes::new(plate).unwrap();
    let mut search = NeighbourSearch::new(SearchOptions::default()).unwrap();
    for (z, range) in [(0.1, 0..121), (-0.4, 121..242)] {
        let side = if z > 0.0 { 1.0 } else { -1.0 };
        let admits = |k: usize| normals[k][2] * side > 0.0;
        let found = search.find_among(&nodes, [4.3, 5.2, z], Outward::NodeNormals(&normals), admits).unwrap();
        assert!(found.nodes.iter().all(|k| range.contains(k)));
        assert!((found.frame.normal[2] - side).abs() < 1e-12);
    }
}

#[test]
fn coarse_curved_surfaces_are_searched_on_the_near_side() {
    // Sixteen nodes around a cylinder.
    let cylinder: Vec<Point> = (0..16 * 9)
        .map(|k| {
            let angle = f64::from(k % 16) * PI / 8.0;
            [angle.cos(), angle.sin(), f64::from(k / 16 - 4) * 0.4]
        })
        .collect();
    // And two hundred spread over a sphere.
    let sphere: Vec<Point> = (0..200)
        .map(|k| {
            let z = (f64::from(k) + 0.5) / 100.0 - 1.0;
            let (r, angle) = ((1.0 - z * z).sqrt(), f64::from(k) * 2.399_963_229_728_653);
            [r * angle.cos(), r * angle.sin(), z]
        })
        .collect();
    let mut random = Uniform(12);
    for (surface, is_sphere) in [(&cylinder, false), (&sphere, true)] {
        for _ in 0..100 {
            let slave = Vector3::from(random.point().map(|x| x - 0.5));
            let radial = if is_sphere { slave } else { Vector3::new(slave.x, slave.y, 0.0) }.normalize();
            let slave =
                radial * 1.02 + (slave - radial * slave.dot(&radial)) * if is_sphere { 0.0 } else { 1.0 };
            let nodes = NearestNodes::new(surface.clone()).unwrap();
            let found = NeighbourSearch::new(SearchOptions::default())
                .unwrap()
                .find(&nodes, slave.into(), Point::from(radial))
                .unwrap();
            assert!(found.encloses_slave && found.basis == Basis::Quadratic, "{found:?}");
            let tilt = Vector3::from(found.frame.normal).dot(&radial);
            assert!(tilt > 0.97, "{tilt}");
            let near = |&k: &usize| Vector3::from(surface[k]).dot(&radial) > 0.0;
            assert!(found.nodes.iter().all(near), "{} nodes", found.nodes.len());
        }
    }
}
