//! Whether a neighbourhood carries the fit: regularity and pivots, the fallbacks of every degenerate layout, and
//! what is refused.

use std::collections::BTreeSet;

use crate::neighbourhood_cases::{PLACES, UP, Uniform, find, hull, lattice, lattices};
use diffuse_contact::neighbourhood::{
    Fallback, NeighbourRule, NeighbourSearch, NeighbourhoodError, Outward, SMALLEST_REGULARITY,
    SearchOptions, hull_layers,
};
use diffuse_contact::pairing::NearestNodes;
use diffuse_contact::{Backend, Basis, ElementError, Generated, Mode, Point, Weight};
use nalgebra::Vector3;

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
        let options = hull(None).with_max_candidates(candidates);
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
    let strict = hull(None).with_linear_fallback(false);
    let error = find(&strip, [20.3, 0.4, 0.1], strict).unwrap_err();
    assert!(
        matches!(error, NeighbourhoodError::IllConditioned { nodes, basis: Basis::Quadratic, .. } if nodes > 12),
        "{error:?}"
    );
}

#[test]
fn a_narrow_strip_that_bends_carries_a_quadratic_also_where_it_bulges() {
    // Three rows around a cylinder: the nodes far around it are wider apart across than along the axis, so that the plane of
    // all candidates is normal to the axis. Bulges keep the rows from lying exactly upon each other in it.
    let strip = |bulge: f64| -> Vec<Point> {
        let node = |row: usize, column: usize| {
            let (sin, cos) = (column as f64 * std::f64::consts::TAU / 40.0).sin_cos();
            let radius = 50.0 + bulge * [1.0, 0.8, 1.1][row] * (1.0 + 0.1 * cos);
            [radius * cos, radius * sin, 5.0 * row as f64]
        };
        (0..120).map(|k| node(k / 40, k % 40)).collect()
    };
    for bulge in [0.0, 1e-6, 1e-3, 0.01, 0.1] {
        let nodes = NearestNodes::new(strip(bulge)).unwrap();
        let mut search = NeighbourSearch::new(hull(None)).unwrap();
        for (angle, height) in [(0.026, 0.0), (0.2, 0.0), (0.1, 5.0), (0.13, 10.001), (0.0, 2.0)] {
            let (sin, cos) = f64::sin_cos(angle);
            let found = search.find(&nodes, [50.02 * cos, 50.02 * sin, height], [cos, sin, 0.0]);
            let found = found.unwrap_or_else(|error| panic!("{bulge} {angle}: {error}"));
            assert_eq!(found.basis, Basis::Quadratic, "{bulge} {angle} {height}: {found:?}");
            assert!(found.support_radius < 30.0, "{bulge} {angle} {height}: {}", found.support_radius);
        }
    }
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
            let strict = options.with_linear_fallback(false);
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
        SearchOptions::default().with_radius_factor(1.0),
        SearchOptions::default().with_radius_factor(f64::NAN),
        SearchOptions::default().with_smallest_regularity(-1.0),
        SearchOptions::default().with_smallest_regularity(f64::NAN),
        SearchOptions::default().with_candidates(2),
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
