//! Pairing by the nearest master nodes.

use diffuse_contact::pairing::*;
use diffuse_contact::{ElementError, Frame, Point};

/// n × n nodes of a unit grid in the plane z = 0.
fn grid(n: usize) -> Vec<Point> {
    (0..n * n).map(|k| [(k % n) as f64, (k / n) as f64, 0.0]).collect()
}

/// Its facets, counter-clockwise seen from above.
fn grid_facets(n: usize) -> Vec<[usize; 4]> {
    (0..(n - 1) * (n - 1))
        .map(|k| k % (n - 1) + n * (k / (n - 1)))
        .map(|k| [k, k + 1, k + n + 1, k + n])
        .collect()
}

/// A small deterministic generator of numbers in [0, 1).
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

#[test]
fn the_nearest_nodes_are_those_of_a_full_scan() {
    let mut state = 1;
    // A third of the coordinates snaps to a coarse grid: many equal distances, many duplicates.
    let mut coordinate = || {
        let x = uniform(&mut state);
        if uniform(&mut state) < 0.6 { (x * 4.0).floor() } else { x * 4.0 }
    };
    let points: Vec<Point> = (0..700).map(|_| [(); 3].map(|()| coordinate())).collect();
    let queries: Vec<Point> = (0..200).map(|_| [(); 3].map(|()| coordinate())).collect();
    let nodes = NearestNodes::new(points.clone()).unwrap();
    for slave in queries {
        let mut scan: Vec<usize> = (0..points.len()).collect();
        scan.sort_by(|&i, &j| {
            let d = |k: usize| (0..3).map(|i| (points[k][i] - slave[i]).powi(2)).sum::<f64>();
            d(i).total_cmp(&d(j)).then(i.cmp(&j))
        });
        for m in [0, 1, 6, 12, 24, 699] {
            assert_eq!(nodes.masters(slave, m), scan[..m]);
        }
        assert_eq!(nodes.masters(slave, 5000), scan);
    }
}

#[test]
fn duplicates_and_empty_sets_are_searched_too() {
    let nodes = NearestNodes::new(vec![[1.0, 2.0, 3.0]; 100]).unwrap();
    assert_eq!(nodes.masters([0.0; 3], 4), [0, 1, 2, 3]);
    let nodes = NearestNodes::new(Vec::new()).unwrap();
    assert!(nodes.masters([0.0; 3], 4).is_empty());
}

#[test]
fn a_coordinate_that_is_no_number_is_refused() {
    let error = NearestNodes::new(vec![[0.0; 3], [0.0, f64::NAN, 0.0]]).unwrap_err();
    assert_eq!(error, ElementError::NonFiniteInput { what: "master", index: 1 });
}

#[test]
fn the_radius_is_the_factor_times_the_farthest_in_plane_distance() {
    let masters = grid(3);
    let frame = Frame::average_plane(&masters, [0.0, 0.0, 1.0]).unwrap();
    let radius = support_radius(&frame, [0.0, 0.0, 7.0], &masters);
    assert!((radius - SUPPORT_RADIUS_FACTOR * 8.0_f64.sqrt()).abs() < 1e-15);
}

#[test]
fn normals_point_out_of_counter_clockwise_facets() {
    let points = grid(3);
    let normals = node_normals(&points, &grid_facets(3));
    assert_eq!(normals[4], [0.0, 0.0, 4.0], "four facets of area one");
    assert_eq!(normals[0], [0.0, 0.0, 1.0], "one facet of area one");
    assert_eq!(outward(&normals, &[0, 4]), [0.0, 0.0, 2.0], "both nodes count the same");
    let flipped: Vec<[usize; 4]> = grid_facets(3).iter().map(|&[a, b, c, d]| [d, c, b, a]).collect();
    assert_eq!(node_normals(&points, &flipped)[4], [0.0, 0.0, -4.0]);
}
