//! Neighbourhoods by convex hulls: against a Delaunay triangulation, on regular grids in any position, and on
//! every degenerate layout.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use diffuse_contact::neighbourhood::{
    Fallback, NeighbourRule, NeighbourSearch, Neighbourhood, NeighbourhoodError, Outward,
    SMALLEST_REGULARITY, SearchOptions, TOLERANCE, hull_layers,
};
use diffuse_contact::pairing::{NearestNodes, node_normals};
use diffuse_contact::{Backend, Basis, ElementError, Generated, Mode, Point, Weight};
use nalgebra::{Rotation3, Vector3};
use spade::{DelaunayTriangulation, Point2, Triangulation};

const UP: Point = [0.0, 0.0, 1.0];

/// A small deterministic generator of numbers in [0, 1).
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn point(&mut self) -> Point {
        [self.next(), self.next(), self.next()]
    }

    fn rotation(&mut self) -> Rotation3<f64> {
        let axis = Vector3::from(self.point().map(|x| x - 0.5));
        Rotation3::new(axis.normalize() * (2.0 * PI * self.next()))
    }
}

fn find(points: &[Point], slave: Point, options: SearchOptions) -> Result<Neighbourhood, NeighbourhoodError> {
    let nodes = NearestNodes::new(points.to_vec()).unwrap();
    NeighbourSearch::new(options)?.find(&nodes, slave, UP)
}

fn hull(layers: Option<usize>) -> SearchOptions {
    SearchOptions::default().with_rule(NeighbourRule::hull_layers(layers))
}

/// Neighbours of `slave` in the Delaunay triangulation of it and all points, seen from above.
fn delaunay_ring(points: &[Point], slave: Point) -> Vec<usize> {
    let mut triangulation = DelaunayTriangulation::<Point2<f64>>::new();
    let handles: Vec<_> =
        points.iter().map(|x| triangulation.insert(Point2::new(x[0], x[1])).unwrap()).collect();
    let centre = triangulation.insert(Point2::new(slave[0], slave[1])).unwrap();
    let ring: BTreeSet<_> = triangulation.vertex(centre).out_edges().map(|edge| edge.to().fix()).collect();
    (0..points.len()).filter(|&k| ring.contains(&handles[k])).collect()
}

/// A flat cloud with a third of the nodes crowded in one quarter.
fn flat_cloud(random: &mut Uniform, size: usize) -> Vec<Point> {
    let node = |k: usize| {
        let crowd = if k.is_multiple_of(3) { 0.25 } else { 1.0 };
        [random.next() * crowd, random.next() * crowd, 0.0]
    };
    (0..size).map(node).collect()
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

/// The nodes of a plane lattice spanned by `u` and `v` around the origin, and their integer coordinates.
fn lattice(u: [f64; 2], v: [f64; 2], half: i32) -> (Vec<Point>, Vec<[i32; 2]>) {
    let row = |j: i32| (-half..=half).map(move |i| [i, j]);
    let integers: Vec<[i32; 2]> = (-half..=half).flat_map(row).collect();
    let point = |&[i, j]: &[i32; 2]| {
        let (i, j) = (f64::from(i), f64::from(j));
        [i * u[0] + j * v[0], i * u[1] + j * v[1], 0.0]
    };
    (integers.iter().map(point).collect(), integers)
}

fn lattices() -> [(&'static str, [f64; 2], [f64; 2]); 3] {
    [
        ("squares", [1.0, 0.0], [0.0, 1.0]),
        ("equilateral triangles", [1.0, 0.0], [0.5, 0.75_f64.sqrt()]),
        ("quads 3:1", [3.0, 0.0], [0.0, 1.0]),
    ]
}

/// On a node, in the middle of an edge, in the middle of a cell (of a quad, of a triangle), and in between.
const PLACES: [[f64; 2]; 6] =
    [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [0.5, 0.5], [1.0 / 3.0, 1.0 / 3.0], [0.21, 0.34]];

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
fn a_regular_set_does_not_enlarge_errors_in_the_heights() {
    let mut random = Uniform(5);
    let (mut one, mut worst) = (0, 0.0_f64);
    for _ in 0..100 {
        let points: Vec<Point> = (0..300).map(|_| [random.next(), random.next(), 0.0]).collect();
        let nodes = NearestNodes::new(points.clone()).unwrap();
        for _ in 0..20 {
            let slave = [0.2 + 0.6 * random.next(), 0.2 + 0.6 * random.next(), 0.0];
            let found = find(&points, slave, hull(None)).unwrap();
            assert!(found.basis == Basis::Quadratic && found.layers.len() <= 3, "{found:?}");
            one += usize::from(found.layers.len() == 1);
            let pairing = found.pairing(&nodes, Weight::Cubic);
            let surface = Generated.surface(&pairing.element(slave), [0.0; 2], Mode::Gradient).unwrap();
            let enlarged = surface.gradient[3..].chunks(3).map(|node| node[2].abs()).sum();
            worst = worst.max(enlarged);
        }
    }
    println!("{one} of 2000 with one layer, errors enlarged at most {worst:.1} times");
    assert!(worst < 8.0, "{worst}");
    assert!((200..1000).contains(&one), "{one}");
}

#[test]
fn nodes_on_two_crossing_lines_carry_no_quadratic() {
    // In the axes of the cross the product ab is rounding only, and so is its pivot.
    let mut random = Uniform(15);
    let arm = |k: i32| [[f64::from(k), 0.0, 0.0], [0.0, f64::from(k), 0.0]];
    let cross: Vec<Point> = (-8..=8).flat_map(arm).collect();
    for slave in [[0.0; 3], [0.2, 0.0, 0.1], [0.1, 0.3, 0.0]] {
        for _ in 0..20 {
            let rotation = random.rotation();
            let turn = |x: Point| Point::from(rotation * Vector3::from(x));
            let turned: Vec<Point> = cross.iter().map(|&x| turn(x)).collect();
            let nodes = NearestNodes::new(turned).unwrap();
            let mut search = NeighbourSearch::new(hull(None)).unwrap();
            let found = search.find(&nodes, turn(slave), turn(UP)).unwrap();
            let Fallback::Linear { quadratic_regularity } = found.fallback else { panic!("{found:?}") };
            assert!(quadratic_regularity < 1e-12, "{quadratic_regularity:e}");
        }
    }
}

#[test]
fn one_ring_of_a_structured_mesh_is_deficient_and_two_are_not() {
    for (name, u, v) in lattices() {
        let (grid, _) = lattice(u, v, 12);
        for [i, j] in PLACES {
            let slave = [i * u[0] + j * v[0], i * u[1] + j * v[1], 0.3];
            let one = hull_layers(slave, &grid, UP, 1).unwrap();
            let two = hull_layers(slave, &grid, UP, 2).unwrap();
            let place = format!("{name} at {i:.2} {j:.2}");
            assert!((12..=21).contains(&two.nodes.len()), "{place}: {} nodes", two.nodes.len());
            assert!(two.basis == Basis::Quadratic && two.regularity > 0.2, "{place}: {}", two.regularity);
            assert!(two.condition < 400.0, "{place}: {}", two.condition);
            // The ring of a grid node is regular together with the node; so are the six nodes around the middle of an
            // equilateral triangle, three near and three farther away.
            let triangle = name == "equilateral triangles" && i == 1.0 / 3.0;
            let regular = one.basis == Basis::Quadratic && one.regularity > 1e-12;
            assert_eq!(regular, [i, j] == [0.0, 0.0] || triangle, "{place}");

            // The search that looks at the fit stops there, too.
            assert_eq!(find(&grid, slave, hull(None)).unwrap().fallback, Fallback::None);
            let found = find(&grid, slave, hull(Some(1))).unwrap();
            assert_eq!(found.layers.len(), if regular { 1 } else { 2 }, "{place}");
            assert_eq!(found.fallback, if regular { Fallback::None } else { Fallback::Extended { by: 1 } });
        }
    }
}

#[test]
fn the_pivot_is_the_one_the_backend_judges_by() {
    let mut random = Uniform(6);
    let (grid, _) = lattice([3.0, 0.0], [0.0, 1.0], 8);
    let nodes = NearestNodes::new(grid.clone()).unwrap();
    let mut singular = 0;
    for trial in 0..200 {
        let slave = [6.0 * random.next(), 6.0 * random.next(), 0.3];
        let found = hull_layers(slave, &grid, UP, 1 + trial % 2).unwrap();
        if found.basis == Basis::Linear {
            continue;
        }
        let fit = Generated.coefficients(&found.pairing(&nodes, Weight::Cubic).element(slave), Mode::Value);
        match fit {
            Err(ElementError::SingularFit { pivot_ratio, .. }) => {
                singular += 1;
                assert!(pivot_ratio < 1e-12 && found.pivot_ratio < 1e-12, "{pivot_ratio} {found:?}");
            }
            Err(error) => panic!("{error}"),
            Ok(_) => assert!(found.pivot_ratio > 1e-7, "{found:?}"),
        }
    }
    assert!(singular > 50, "{singular}");
}

#[test]
fn stretched_and_graded_grids_get_two_columns_on_either_side() {
    for (stretch, candidates) in [(6.0, 192), (20.0, 768)] {
        let (grid, integers) = lattice([stretch, 0.0], [0.0, 1.0], 220);
        let slave = [0.3 * stretch, 0.2, 0.1];
        let options = SearchOptions { max_candidates: candidates, ..hull(None) };
        let found = find(&grid, slave, options).unwrap();
        let columns: BTreeSet<i32> = found.nodes.iter().map(|&k| integers[k][0]).collect();
        assert!(columns.len() >= 3 && found.basis == Basis::Quadratic, "{stretch}: {columns:?}");
        assert!(found.encloses_slave && found.regularity > SMALLEST_REGULARITY);
    }

    // Fine on the left, coarser on the right, the slave on the seam.
    for (step, certain) in [(2, true), (4, true), (7, false)] {
        let fine = (0..961).map(|k| [f64::from(k / 31 - 30), f64::from(k % 31 - 15), 0.0]);
        let coarse = (0..63).map(|k| [f64::from(step * (k / 9 + 1)), f64::from(step * (k % 9 - 4)), 0.0]);
        let seam: Vec<Point> = fine.chain(coarse).collect();
        let found = find(&seam, [0.2, 0.3, 0.1], hull(None)).unwrap();
        assert!(found.encloses_slave && found.nodes.iter().any(|&k| k >= 961), "{found:?}");
        assert_eq!(found.complete, certain, "{step}");
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
fn nodes_on_a_line_have_no_plane_and_two_rows_only_a_linear_fit() {
    let line: Vec<Point> = (0..100).map(|k| [f64::from(k), 2.0 * f64::from(k), 0.0]).collect();
    for slave in [[30.2, 60.4, 0.1], [30.0, 61.0, 0.1], [-5.0, 3.0, 0.0]] {
        assert_eq!(find(&line, slave, hull(None)).unwrap_err().code(), "no-average-plane");
    }
    let strip: Vec<Point> = (0..100).map(|k| [f64::from(k / 2), f64::from(k % 2), 0.0]).collect();
    let found = find(&strip, [20.3, 0.4, 0.1], hull(None)).unwrap();
    assert_eq!((found.basis, found.layers[0].len()), (Basis::Linear, 4));
    let Fallback::Linear { quadratic_regularity } = found.fallback else { panic!("{found:?}") };
    assert!(quadratic_regularity < 1e-12);
    let strict = SearchOptions { linear_fallback: false, ..hull(None) };
    let error = find(&strip, [20.3, 0.4, 0.1], strict).unwrap_err();
    assert!(
        matches!(error, NeighbourhoodError::IllConditioned { nodes, basis: Basis::Quadratic, .. } if nodes > 12),
        "{error:?}"
    );
}

#[test]
fn few_nodes_carry_a_linear_fit_and_fewer_than_three_none() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.4, 0.6, 0.0]];
    for count in 3..=5 {
        for rule in
            [NeighbourRule::hull_layers(Some(2)), NeighbourRule::hull_radius(None), NeighbourRule::nearest(8)]
        {
            let options = SearchOptions::default().with_rule(rule);
            let found = find(&corners[..count], [0.6, 0.3, 0.1], options).unwrap();
            assert_eq!((found.basis, found.nodes.len()), (Basis::Linear, count), "{rule:?}");
            assert_eq!(found.fallback, Fallback::Linear { quadratic_regularity: 0.0 });
            assert!(found.encloses_slave && found.complete);
            let strict = SearchOptions { linear_fallback: false, ..options };
            let error = find(&corners[..count], [0.6, 0.3, 0.1], strict).unwrap_err();
            assert_eq!(error, NeighbourhoodError::NoCandidate { found: count, needed: 6 });
        }
    }
    for count in 0..3 {
        let error = find(&corners[..count], [0.6, 0.3, 0.1], SearchOptions::default()).unwrap_err();
        assert_eq!(error, NeighbourhoodError::NoCandidate { found: count, needed: 3 });
        assert_eq!(error.code(), "no-candidate");
    }
    let (grid, _) = lattice([1.0, 0.0], [0.0, 1.0], 4);
    let nodes = NearestNodes::new(grid).unwrap();
    let mut search = NeighbourSearch::new(SearchOptions::default()).unwrap();
    let error = search.find_among(&nodes, [0.1, 0.1, 0.0], UP, |k| k < 2).unwrap_err();
    assert_eq!(error, NeighbourhoodError::NoCandidate { found: 2, needed: 3 });
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

/// Nodes at the rim of the radius have next to no weight; where a fit needed them it was gone after a small step.
#[test]
fn the_fit_within_the_hull_radius_outlives_a_small_step() {
    let (grid, _) = lattice([1.0, 0.0], [0.0, 1.0], 6);
    let nodes = NearestNodes::new(grid.clone()).unwrap();
    let options = SearchOptions::default().with_rule(NeighbourRule::hull_radius(None));
    for k in 0..400 {
        let [x, y] = [k % 20, k / 20].map(|place| f64::from(place) / 20.0);
        let found = find(&grid, [x, y, 0.0], options).unwrap();
        let pairing = found.pairing(&nodes, Weight::Cubic);
        for direction in 0..8 {
            let (sin, cos) = (f64::from(direction) * std::f64::consts::FRAC_PI_4).sin_cos();
            let step = 0.05 * found.support_radius;
            let slave = [x + step * cos, y + step * sin, 0.1];
            let gap = Generated.gap(&pairing.element(slave), Mode::Value).unwrap();
            assert!((gap.gap - 0.1).abs() < 1e-10, "{x} {y} {direction}: {}", gap.gap);
        }
    }
}

#[test]
fn the_nearest_nodes_are_extended_until_they_carry_the_fit() {
    let (grid, _) = lattice([1.0, 0.0], [0.0, 1.0], 5);
    let nodes = NearestNodes::new(grid.clone()).unwrap();
    let options = SearchOptions::default().with_rule(NeighbourRule::nearest(6));
    let slave = [0.5, 0.45, 0.2];
    let found = find(&grid, slave, options).unwrap();
    let Fallback::Extended { by } = found.fallback else { panic!("{found:?}") };
    assert_eq!(found.nodes.len(), 6 + by);
    let nearest: BTreeSet<usize> = nodes.masters(slave, 6 + by).into_iter().collect();
    assert_eq!(found.nodes.iter().copied().collect::<BTreeSet<_>>(), nearest);
    assert!(found.encloses_slave && found.regularity > SMALLEST_REGULARITY);
    let beyond = find(&grid, [5.4, 0.2, 0.1], SearchOptions::nearest()).unwrap();
    assert!(!beyond.encloses_slave);
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

#[test]
fn bad_input_is_a_named_error() {
    let (grid, _) = lattice([1.0, 0.0], [0.0, 1.0], 4);
    let code = |slave: Point, outward: Point| hull_layers(slave, &grid, outward, 2).unwrap_err().code();
    assert_eq!(code([f64::NAN, 0.0, 0.0], UP), "non-finite-input");
    assert_eq!(code([0.0, f64::INFINITY, 0.0], UP), "non-finite-input");
    assert_eq!(code([0.0; 3], [0.0, f64::NAN, 1.0]), "non-finite-input");
    assert_eq!(code([0.0; 3], [0.0; 3]), "ambiguous-outward");
    assert_eq!(code([0.0; 3], [1.0, 0.0, 0.0]), "ambiguous-outward");
    let mut broken = grid.clone();
    broken[7][1] = f64::NAN;
    let error = hull_layers([0.0; 3], &broken, UP, 2).unwrap_err();
    assert_eq!(error, NeighbourhoodError::NonFiniteInput { what: "master", index: 7 });

    let nodes = NearestNodes::new(grid.clone()).unwrap();
    let mut search = NeighbourSearch::new(SearchOptions::default()).unwrap();
    for (normals, code) in [
        (vec![[f64::NAN; 3]; 81], "non-finite-input"),
        (vec![[0.0; 3]; 81], "ambiguous-outward"),
        (vec![UP; 80], "invalid-option"),
    ] {
        let error = search.find(&nodes, [0.1, 0.2, 0.0], Outward::NodeNormals(&normals)).unwrap_err();
        assert_eq!(error.code(), code);
    }

    for options in [
        hull(Some(0)),
        SearchOptions::default().with_rule(NeighbourRule::HullLayers { layers: None, max_layers: 0 }),
        SearchOptions { radius_factor: 1.0, ..SearchOptions::default() },
        SearchOptions { radius_factor: f64::NAN, ..SearchOptions::default() },
        SearchOptions { smallest_regularity: -1.0, ..SearchOptions::default() },
        SearchOptions { smallest_regularity: f64::NAN, ..SearchOptions::default() },
        SearchOptions { candidates: 2, ..SearchOptions::default() },
    ] {
        assert_eq!(NeighbourSearch::new(options).unwrap_err().code(), "invalid-option", "{options:?}");
    }
}

#[test]
fn no_layout_and_no_scale_makes_it_panic() {
    let mut random = Uniform(13);
    let (mut found, mut refused) = (0, 0);
    for trial in 0..3000 {
        let scale = 10.0_f64.powi([0, 0, 0, -9, 9, -80, 80, -160, 160, 300][trial % 10]);
        let levels = [2.0, 3.0, 5.0, 1e9][trial % 4];
        let flat = [0.0, 0.1, 1.0][trial % 3];
        let mut coordinate = |size: f64| (random.next() * levels).floor() / levels * size * scale;
        let size = [1, 3, 6, 9, 30, 120][trial % 6];
        let points: Vec<Point> =
            (0..size).map(|_| [coordinate(1.0), coordinate(1.0), coordinate(flat)]).collect();
        let slave = [coordinate(1.0), coordinate(1.0), coordinate(1.0)];
        let rule = [
            NeighbourRule::hull_layers(None),
            NeighbourRule::hull_layers(Some(3)),
            NeighbourRule::hull_radius(Some(1)),
            NeighbourRule::nearest(7),
        ][trial / 7 % 4];
        match find(&points, slave, SearchOptions::default().with_rule(rule)) {
            Ok(set) => {
                found += 1;
                assert!(set.regularity > SMALLEST_REGULARITY && !(set.condition < 1.0), "{set:?}");
                assert!(set.support_radius.is_finite() && set.support_radius > 0.0);
                let distinct: BTreeSet<usize> = set.nodes.iter().copied().collect();
                assert_eq!(distinct.len(), set.nodes.len());
                assert!(set.nodes.len() >= set.basis.size());
            }
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty() && !error.code().is_empty());
            }
        }
        let _ = hull_layers(slave, &points, UP, 3);
    }
    println!("{found} found, {refused} refused");
    assert!(found > 600 && refused > 300, "{found} found, {refused} refused");
}
