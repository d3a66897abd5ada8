//! Surfaces: the closest point against a scan of all facets, ties, tributary areas.

use std::f64::consts::PI;

use diffuse_contact::Point;
use diffuse_contact::surface::{Facet, MasterSurface, SurfaceError, tributary_areas};
use nalgebra::Vector3;

/// A small deterministic generator of numbers in [0, 1).
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A grid of m × n nodes at `place(s, t)`, s and t from 0 to 1; every third cell is cut in two triangles.
fn grid(m: usize, n: usize, place: impl Fn(f64, f64) -> Point) -> (Vec<Point>, Vec<Facet>) {
    let at = |k: usize, count: usize| k as f64 / (count - 1) as f64;
    let positions = (0..m * n).map(|k| place(at(k % m, m), at(k / m, n))).collect();
    let cells = (0..(m - 1) * (n - 1)).map(|k| k % (m - 1) + m * (k / (m - 1)));
    let facets = cells
        .enumerate()
        .flat_map(|(cell, k)| {
            let [a, b, c, d] = [k, k + 1, k + m + 1, k + m];
            if cell % 3 == 0 {
                vec![Facet::Triangle([a, b, c]), Facet::Triangle([a, c, d])]
            } else {
                vec![Facet::Quadrilateral([a, b, c, d])]
            }
        })
        .collect();
    (positions, facets)
}

/// Half a torus tube, strongly graded: cells from 1e-4 to 1.
fn graded_tube() -> (Vec<Point>, Vec<Facet>) {
    grid(24, 30, |s, t| {
        let (around, along) = (PI * (1.0 - s), 6.0 * (10f64.powf(4.0 * t) - 1.0) / 1e4);
        let radius = 3.0 + around.cos();
        [radius * along.cos(), radius * along.sin(), around.sin()]
    })
}

/// Distance to a triangle by its seven regions, or to a bilinear facet by refined sampling.
fn distance(facet: Facet, positions: &[Point], x: Vector3<f64>) -> f64 {
    let corners: Vec<Vector3<f64>> = facet.corners().iter().map(|&k| Vector3::from(positions[k])).collect();
    let point = |u: f64, v: f64| match corners.as_slice() {
        // Collapsed coordinates cover the triangle.
        [a, b, c] => a + (b - a) * u + (c - a) * (1.0 - u) * v,
        _ => {
            let (lower, upper) =
                (corners[0] * (1.0 - u) + corners[1] * u, corners[3] * (1.0 - u) + corners[2] * u);
            lower * (1.0 - v) + upper * v
        }
    };
    let (mut centre, mut width, mut best) = ([0.5, 0.5], 0.5, f64::INFINITY);
    for _ in 0..150 {
        let mut nearest = centre;
        for i in -4..=4 {
            for j in -4..=4 {
                let u = (centre[0] + width * f64::from(i) / 4.0).clamp(0.0, 1.0);
                let v = (centre[1] + width * f64::from(j) / 4.0).clamp(0.0, 1.0);
                let distance = (point(u, v) - x).norm();
                if distance < best {
                    (best, nearest) = (distance, [u, v]);
                }
            }
        }
        (centre, width) = (nearest, 0.8 * width);
    }
    best
}

#[test]
fn the_closest_point_is_that_of_a_scan_over_all_facets() {
    let (positions, facets) = graded_tube();
    let surface = MasterSurface::new(&positions, facets.clone()).unwrap();
    let index = surface.at(&positions).unwrap();
    let mut random = Uniform(3);
    for _ in 0..12 {
        let near = Vector3::from(positions[(random.next() * positions.len() as f64) as usize]);
        let x = near + Vector3::from_fn(|_, _| random.next() - 0.5);
        let found = index.closest(x.into()).unwrap();
        // A facet is no closer than its nearest corner less its diameter.
        let lower_bound = |facet: &Facet| {
            let offset = |k: &usize| Vector3::from(positions[*k]) - x;
            let corners: Vec<Vector3<f64>> = facet.corners().iter().map(offset).collect();
            let diameter = corners.iter().map(|c| (c - corners[0]).norm()).fold(0.0, f64::max);
            corners.iter().map(Vector3::norm).fold(f64::INFINITY, f64::min) - 2.0 * diameter
        };
        let near = facets.iter().filter(|facet| lower_bound(facet) <= found.distance);
        let scan = near.map(|&facet| distance(facet, &positions, x)).fold(f64::INFINITY, f64::min);
        assert!((found.distance - scan).abs() < 1e-9 * scan, "{} against {scan}", found.distance);
        assert!(((Vector3::from(found.point) - x).norm() - found.distance).abs() < 1e-14);
    }
}

#[test]
fn ties_do_not_depend_on_the_position_in_the_tree() {
    // Over edges and nodes of a flat grid the lowest index wins.
    let (positions, facets) = grid(8, 8, |s, t| [7.0 * s, 7.0 * t, 0.0]);
    let surface = MasterSurface::new(&positions, facets.clone()).unwrap();
    let index = surface.at(&positions).unwrap();
    for &node in surface.nodes() {
        let [x, y, _] = positions[node as usize];
        let found = index.closest([x, y, 0.3]).unwrap();
        assert_eq!(Some(found.facet), surface.facets_at(node as usize).next());
        assert!((Vector3::from(found.point) - Vector3::new(x, y, 0.0)).norm() < 1e-14);
        assert!((found.distance - 0.3).abs() < 1e-15);
        let on_border = x == 0.0 || y == 0.0 || x == 7.0 || y == 7.0;
        assert_eq!(found.on_border, on_border, "{x} {y}");
    }
}

#[test]
fn over_a_convex_edge_the_facet_that_faces_the_point_is_closest() {
    // Two walls of a box meet in the edge x = y = 0; the closest point of all these slaves lies on the edge.
    let positions = [
        [0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        [-1.0, 0.0, 0.0],
        [-1.0, 0.0, 1.0],
        [0.0, -1.0, 0.0],
        [0.0, -1.0, 1.0],
    ];
    let facets = vec![Facet::Quadrilateral([2, 3, 1, 0]), Facet::Quadrilateral([0, 1, 5, 4])];
    let surface = MasterSurface::new(&positions, facets).unwrap();
    let index = surface.at(&positions).unwrap();
    assert_eq!((index.normal(0), index.normal(1)), ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0]));
    for (slave, facet) in [([0.1, 0.3, 0.5], 0), ([0.3, 0.1, 0.5], 1), ([0.2, 0.2, 0.5], 0)] {
        let found = index.closest(slave).unwrap();
        assert_eq!(found.facet, facet, "{slave:?}");
        assert!(!found.on_border);
        assert_eq!(found.point, [0.0, 0.0, 0.5]);
    }
}

#[test]
fn a_point_that_is_not_finite_has_no_closest_one() {
    let (positions, facets) = grid(3, 3, |s, t| [s, t, 0.0]);
    let surface = MasterSurface::new(&positions, facets).unwrap();
    let index = surface.at(&positions).unwrap();
    for x in [f64::NAN, f64::INFINITY, 1e80] {
        assert_eq!(index.closest([0.0, x, 0.0]), None);
    }
    assert!(index.closest([1e70, -1e70, 1e70]).is_some());
    let error = surface.at(&positions[..8]).unwrap_err();
    assert_eq!(error, SurfaceError::TooFewPositions { found: 8, needed: 9 });
    let mut broken = positions.clone();
    broken[4][2] = f64::NAN;
    assert_eq!(surface.at(&broken).unwrap_err().code(), "non-finite-position");
    assert_eq!(surface.node_normals(&broken).unwrap_err().code(), "non-finite-position");
}

#[test]
fn tributary_areas_sum_up_to_the_area() {
    // A unit sphere's cap of 60°, whose area is π.
    let (positions, facets) = grid(40, 120, |s, t| {
        let (polar, around) = ((PI / 3.0) * (0.01 + 0.99 * s), 2.0 * PI * t);
        [polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos()]
    });
    let areas = tributary_areas(&positions, &facets).unwrap();
    let total: f64 = areas.iter().sum();
    assert!((total / PI - 1.0).abs() < 2e-3, "{total}");
    assert!(areas.iter().all(|&area| area > 0.0));
    // A flat surface whose nodes are moved about: exact.
    let (positions, facets) = grid(9, 7, |s, t| {
        let bump = 0.05 * (9.0 * s * (1.0 - s) * (3.0 * t).sin());
        [3.0 * s, 2.0 * (t + bump * t * (1.0 - t)), 5.0]
    });
    let total: f64 = tributary_areas(&positions, &facets).unwrap().iter().sum();
    assert!((total - 6.0).abs() < 1e-13, "{total}");
}
