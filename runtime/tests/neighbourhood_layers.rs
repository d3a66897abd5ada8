//! Which nodes a neighbourhood consists of: against a Delaunay triangulation, on regular grids in any position and
//! order, around nodes that coincide, on thin and curved surfaces.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use crate::neighbourhood_cases::{PLACES, UP, Uniform, find, flat_cloud, hull, lattice, lattices};
use diffuse_contact::neighbourhood::{
    NeighbourRule, NeighbourSearch, Neighbourhood, NeighbourhoodError, Outward, SMALLEST_REGULARITY,
    SearchOptions, TOLERANCE, hull_layers,
};
use diffuse_contact::pairing::{NearestNodes, node_normals};
use diffuse_contact::{Basis, Point};
use nalgebra::Vector3;
use spade::handles::FixedVertexHandle;
use spade::{DelaunayTriangulation, Point2, Triangulation};

/// The Delaunay triangulation of points seen from above.
struct Delaunay {
    of_points: DelaunayTriangulation<Point2<f64>>,
    handles: Vec<FixedVertexHandle>,
}

impl Delaunay {
    fn new(points: &[Point]) -> Self {
        let mut of_points = DelaunayTriangulation::new();
        let handles = points.iter().map(|x| of_points.insert(Point2::new(x[0], x[1])).unwrap()).collect();
        Self { of_points, handles }
    }

    /// Neighbours of `slave` in the triangulation of it and all points.
    fn ring(&self, slave: Point) -> Vec<usize> {
        let mut with_slave = self.of_points.clone();
        let centre = with_slave.insert(Point2::new(slave[0], slave[1])).unwrap();
        let ring: BTreeSet<_> = with_slave.vertex(centre).out_edges().map(|edge| edge.to().fix()).collect();
        (0..self.handles.len()).filter(|&k| ring.contains(&self.handles[k])).collect()
    }
}

/// The largest angle under which the slave sees none of its nearest nodes.
fn free_angle(points: &[Point], slave: Point, nearest: usize) -> f64 {
    let offset = |x: &Point| [x[0] - slave[0], x[1] - slave[1]];
    let mut offsets: Vec<[f64; 2]> = points.iter().map(offset).collect();
    offsets.sort_by(|x, y| x[0].hypot(x[1]).total_cmp(&y[0].hypot(y[1])));
    offsets.truncate(nearest);
    let mut angles: Vec<f64> = offsets.iter().map(|[a, b]| b.atan2(*a)).collect();
    angles.sort_by(f64::total_cmp);
    let around = angles[0] + 2.0 * PI - angles[angles.len() - 1];
    angles.windows(2).map(|pair| pair[1] - pair[0]).fold(around, f64::max)
}

#[test]
fn the_first_layer_is_the_delaunay_ring() {
    let mut random = Uniform(1);
    let (mut enclosed, mut certain, mut one_layer) = (0, 0, 0);
    for cloud in 0..200 {
        let points = flat_cloud(&mut random, 300);
        let nodes = NearestNodes::new(points.clone()).unwrap();
        let delaunay = Delaunay::new(&points);
        let mut search = NeighbourSearch::new(hull(None)).unwrap();
        for _ in 0..10 {
            let slave = [0.05 + 0.9 * random.next(), 0.05 + 0.9 * random.next(), 0.05 * random.next()];
            let found = search.find(&nodes, slave, UP).unwrap();
            enclosed += usize::from(found.encloses_slave);
            if !found.encloses_slave {
                // Only in a bay of the cloud's border, which the ring around all nodes would span.
                assert!(free_angle(&points, slave, 192) > 0.75 * PI, "cloud {cloud}, slave {slave:?}");
            }
            certain += usize::from(found.complete);
            one_layer += usize::from(found.layers.len() == 1);
            if found.encloses_slave && found.complete {
                assert_eq!(found.layers[0], delaunay.ring(slave), "cloud {cloud}, slave {slave:?}");
            }
            assert!(found.regularity > SMALLEST_REGULARITY && found.condition.is_finite(), "{found:?}");
        }
    }
    println!("of 2000: {enclosed} enclosed, {certain} certain, {one_layer} with one layer");
    assert!(enclosed >= 1980 && certain >= 1800, "{enclosed} enclosed, {certain} certain");
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
        let ring = Delaunay::new(&points).ring(slave);
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
        assert_eq!(expected.encloses_slave, slave[0] > -6.0, "{slave:?}");
        assert_eq!(expected.on_border, slave[0] == -6.0, "{slave:?}");
        let farthest = expected.nodes.last().map(|&k| integers[k]).unwrap();
        assert!(f64::from(farthest[0]) - slave[0] < 5.0 && (f64::from(farthest[1]) - slave[1]).abs() < 6.0);
        for _ in 0..25 {
            let rotation = random.rotation();
            let turn = |x: Point| Point::from(rotation * Vector3::from(x));
            let turned: Vec<Point> = grid.iter().map(|&x| turn(x)).collect();
            let found = hull_layers(turn(slave), &turned, turn(UP), 2).unwrap();
            assert_eq!(found.layers, expected.layers, "{slave:?}");
            assert_eq!(
                (found.encloses_slave, found.on_border),
                (expected.encloses_slave, expected.on_border)
            );
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

/// Largest over median distance of each layer's nodes.
fn spread(found: &Neighbourhood, points: &[Point], slave: Point) -> Vec<f64> {
    let distance = |&k: &usize| (points[k][0] - slave[0]).hypot(points[k][1] - slave[1]);
    let of_layer = |layer: &Vec<usize>| {
        let mut distances: Vec<f64> = layer.iter().map(distance).collect();
        distances.sort_by(f64::total_cmp);
        distances[distances.len() - 1] / distances[distances.len() / 2]
    };
    found.layers.iter().map(of_layer).collect()
}

/// Nodes (i, j) of a grid of 41 × 21 under a map.
fn mapped(map: impl Fn(f64, f64) -> [f64; 2]) -> Vec<Point> {
    let at = |k: usize| map((k % 41) as f64, (k / 41) as f64);
    (0..41 * 21).map(at).map(|[x, y]| [x, y, 0.0]).collect()
}

type Map = fn(f64, f64) -> [f64; 2];

/// Borders that are straight, stretched, graded, that bow outward and inward.
const BORDERS: [(&str, Map); 8] = [
    ("square", |x, y| [x, y]),
    ("3:1", |x, y| [3.0 * x, y]),
    ("1:3", |x, y| [x, 3.0 * y]),
    ("10:1", |x, y| [10.0 * x, y]),
    ("1:10", |x, y| [x, 10.0 * y]),
    ("graded", |x, y| [1.2_f64.powf(x - 20.0), y]),
    ("disc", |x, y| [(25.0 - y) * (x / 25.0).cos(), (25.0 - y) * (x / 25.0).sin()]),
    ("bore", |x, y| [(60.0 + y) * (x / 60.0).cos(), (60.0 + y) * (x / 60.0).sin()]),
];

/// Rows from the border outward, in cells; negative: beyond.
const ROWS: [f64; 9] = [0.3, 0.1, 1e-2, 1e-6, 0.0, -1e-6, -1e-2, -0.1, -0.3];

#[test]
fn at_a_border_no_node_is_several_times_farther_than_its_layer() {
    for (name, map) in BORDERS {
        let points = mapped(map);
        for column in [0.0, 0.4, 3.0, 20.0, 20.13, 20.5, 20.81] {
            for row in ROWS {
                let [x, y] = map(column, row);
                let slave = [x, y, 0.05];
                let found = hull_layers(slave, &points, UP, 4).unwrap();
                if found.encloses_slave {
                    continue;
                }
                let spread = spread(&found, &points, slave);
                assert!(spread.iter().all(|x| *x <= 3.0 + 1e-5), "{name} {column} {row}: {spread:?}");
            }
        }
    }
}

/// Four layers on a border reach 4 cells along it, as they do on a straight one. On the bore they reached 11, all nodes looked at.
#[test]
fn layers_do_not_run_along_a_border() {
    for (name, map) in [BORDERS[0], BORDERS[2], BORDERS[6], BORDERS[7]] {
        let points = mapped(map);
        for column in [20.0, 20.13, 20.5, 20.81] {
            for row in [1e-2, 1e-6, 0.0, -1e-6, -1e-2] {
                let [x, y] = map(column, row);
                let found = hull_layers([x, y, 0.05], &points, UP, 4).unwrap();
                for (number, layer) in found.layers.iter().enumerate() {
                    let along = layer.iter().map(|k| ((k % 41) as f64 - column).abs()).fold(0.0, f64::max);
                    assert!(
                        along <= (number + 1) as f64 + 0.01,
                        "{name} {column} {row}, layer {number}: {along}"
                    );
                }
            }
        }
    }
}

/// Inside, layers are the rings of the Delaunay triangulation, far nodes included.
#[test]
fn inside_stretched_and_stepped_grids_rings_are_complete() {
    let inside: [(&str, Map); 6] = [
        ("square", |x, y| [x, y]),
        ("3:1", |x, y| [3.0 * x, y]),
        ("1:10", |x, y| [x, 10.0 * y]),
        ("graded", |x, y| [1.2_f64.powf(x - 20.0), 0.2 * y]),
        ("stepped 1:4", |x, y| [if x < 20.0 { x } else { 4.0 * x - 60.0 }, y]),
        ("sheared", |x, y| [x + 0.7 * y, y]),
    ];
    let mut random = Uniform(21);
    let mut farthest: f64 = 0.0;
    for (name, map) in inside {
        let points = mapped(map);
        let delaunay = Delaunay::new(&points);
        for _ in 0..100 {
            let [x, y] = map(19.0 + 2.0 * random.next(), 9.0 + 2.0 * random.next());
            let slave = [x, y, 0.05];
            let found = hull_layers(slave, &points, UP, 1).unwrap();
            assert!(found.encloses_slave && !found.on_border, "{name} {x} {y}");
            if found.complete {
                assert_eq!(found.layers[0], delaunay.ring(slave), "{name} {x} {y}");
            }
            farthest = farthest.max(spread(&found, &points, slave)[0]);
        }
    }
    assert!(farthest > 3.0, "the bound of open rings does not hold inside: {farthest}");
}

/// On a plate bent to a cylinder the border bows in the layers' plane as soon as that is tilted. Far border nodes made it tilt more.
#[test]
fn far_nodes_do_not_tilt_the_plane_at_a_border() {
    // A quarter of a disc with a bore, on a paraboloid.
    let surface = |x: f64, y: f64| [x, y, -0.004 * (x * x + y * y)];
    let points: Vec<Point> = mapped(|x, y| BORDERS[7].1(x, y)).iter().map(|p| surface(p[0], p[1])).collect();
    let mut largest: f64 = 0.0;
    for column in 0..=40 {
        let [x, y] = BORDERS[7].1(20.0 + 0.025 * f64::from(column), 0.0);
        let normal = Vector3::new(0.008 * x, 0.008 * y, 1.0).normalize();
        let found = hull_layers(surface(x, y), &points, UP, 1).unwrap();
        largest = largest.max(Vector3::from(found.frame.normal).angle(&normal).to_degrees());
    }
    assert!(largest < 1.0, "{largest}°");
}
