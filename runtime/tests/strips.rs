//! Strips of one row of cells: rims of plates, walls of holes. Fits take auxiliary points beside nodes.

use std::f64::consts::{FRAC_PI_2, TAU};

use diffuse_contact::ad::Ad;
use diffuse_contact::interface::{ContactElement, ContactRef, InterfaceOptions, Outcome, PairedElement};
use diffuse_contact::neighbourhood::{Fallback, SearchOptions};
use diffuse_contact::surface::{Facet, SymmetryPlane};
use diffuse_contact::{Backend, Basis, Mode, Point, Weight};

use crate::common::{Mesh, Scene, Uniform, worse};
use crate::interface_robustness::of_listed;

/// How a strip's cells are cut.
#[derive(Clone, Copy, Debug)]
enum Cells {
    Quadrilaterals,
    Triangles,
    Mixed,
}

/// A strip of so many cells with nodes at `place(s, t)`, s along and t across from 0 to 1; a closed one ends where it starts.
fn strip(along: usize, is_closed: bool, cells: Cells, place: impl Fn(f64, f64) -> Point) -> Mesh {
    let nodes = along + usize::from(!is_closed);
    let Mesh { positions, .. } = Mesh::grid([nodes, 2], [is_closed, false], place);
    let cut = |k: usize| match cells {
        Cells::Quadrilaterals => false,
        Cells::Triangles => true,
        Cells::Mixed => k.is_multiple_of(3),
    };
    let facets = (0..along).flat_map(|k| {
        let next = (k + 1) % nodes;
        let [a, b, c, d] = [k, next, next + nodes, k + nodes];
        if cut(k) {
            vec![Facet::Triangle([a, b, c]), Facet::Triangle([a, c, d])]
        } else {
            vec![Facet::Quadrilateral([a, b, c, d])]
        }
    });
    Mesh { facets: facets.collect(), positions }
}

/// The outside of a ring of radius 1 and height `height`, of so many cells around. `turn`: how much of it.
fn rim(around: usize, height: f64, turn: f64, cells: Cells) -> Mesh {
    strip(around, turn == TAU, cells, |s, t| {
        let (sin, cos) = (turn * s).sin_cos();
        [cos, sin, height * t]
    })
}

/// Points over such a rim, at random heights between these.
fn over(count: usize, height: f64, turn: f64, [low, high]: [f64; 2]) -> Vec<Point> {
    let mut random = Uniform(11);
    let point = |_| {
        let (sin, cos) = (turn * random.next()).sin_cos();
        let radius = 1.0 + low + (high - low) * random.next();
        [radius * cos, radius * sin, height * random.next()]
    };
    (0..count).map(point).collect()
}

/// A quarter of a rim of this height that goes on behind two planes, with slaves below its surface. Up to 0.6 it has ghost nodes, then middles.
pub(crate) fn quarter(weight: Weight, height: f64) -> Scene {
    let mesh = rim(6, height, FRAC_PI_2, Cells::Mixed);
    let element = ContactElement::diffuse(SearchOptions::domains()).with_weight(weight);
    let slaves = over(150, height, FRAC_PI_2, [-0.03, -0.005]);
    let mut scene = mesh.scene(&slaves, InterfaceOptions::default().with_element(element));
    let planes = [0, 1].map(|axis| SymmetryPlane::across(axis, [0.0; 3]));
    scene.interface.set_symmetry(&planes).unwrap();
    scene.refresh();
    scene
}

/// The largest error of the gap to the circle.
fn largest_error(scene: &mut Scene) -> f64 {
    let contacts = scene.interface.evaluate(Mode::Value).unwrap();
    let error = |contact: ContactRef<'_>| {
        assert!(contact.outcome.is_contact(), "{:?}", contact.outcome);
        let [x, y, _] = scene.positions[contact.slave];
        (contact.point.gap - (x.hypot(y) - 1.0)).abs()
    };
    contacts.iter().map(error).fold(0.0, worse)
}

/// Errors of facets are half the sagitta at least.
#[test]
fn one_row_of_cells_is_round() {
    for (around, height) in [(12, 0.02), (12, 0.17), (12, 0.3), (12, 2.0), (16, 0.1), (16, 0.5), (24, 0.3)] {
        let sagitta = 1.0 - (std::f64::consts::PI / around as f64).cos();
        for cells in [Cells::Quadrilaterals, Cells::Triangles, Cells::Mixed] {
            for weight in Weight::ALL {
                let element = ContactElement::diffuse(SearchOptions::domains()).with_weight(weight);
                let options = InterfaceOptions::default().with_element(element);
                let slaves = over(300, height, TAU, [0.01, 0.05]);
                let mut scene = rim(around, height, TAU, cells).scene(&slaves, options);
                let report = scene.refresh();
                assert_eq!((report.paired, report.fallbacks.linear), (300, 0), "{around} {height} {cells:?}");
                let error = largest_error(&mut scene);
                println!(
                    "{around} × 1, {height} high, {cells:?}, {weight:?}: {:.3} of the sagitta",
                    error / sagitta
                );
                assert!(error < 0.25 * sagitta, "{around} {height} {cells:?} {weight:?}: {error}");
            }
        }
    }
}

/// Once around there is one function: its steps are those of its slope.
#[test]
fn a_slide_around_a_rim_meets_no_jump() {
    for cells in [Cells::Quadrilaterals, Cells::Triangles, Cells::Mixed] {
        let mesh = rim(12, 0.4, TAU, cells);
        let steps = 4000;
        let slaves: Vec<Point> = (0..=steps)
            .map(|k| {
                let angle = TAU * f64::from(k) / f64::from(steps);
                let (sin, cos) = angle.sin_cos();
                [1.02 * cos, 1.02 * sin, 0.2 + 0.15 * (3.0 * angle).sin()]
            })
            .collect();
        let mut scene = mesh.paired(&slaves, InterfaceOptions::default());
        let contacts = scene.interface.evaluate(Mode::Value).unwrap();
        let gaps: Vec<f64> = contacts.iter().map(|contact| contact.point.gap).collect();
        let change = gaps.windows(3).map(|x| (x[2] - 2.0 * x[1] + x[0]).abs()).fold(0.0, worse);
        assert!(change < 1e-5, "{cells:?}: {change:e}");
    }
}

/// A quarter between planes of symmetry is the quarter of the whole.
#[test]
fn a_quarter_of_a_rim_is_that_of_the_whole() {
    for (height, cells) in
        [(0.8, Cells::Quadrilaterals), (0.8, Cells::Triangles), (0.05, Cells::Quadrilaterals)]
    {
        let slaves = over(200, height, FRAC_PI_2, [0.0, 0.05]);
        // The diagonals of an image lean the other way, so that triangles are those of half the ring.
        let mut whole = match cells {
            Cells::Quadrilaterals => rim(24, height, TAU, cells),
            _ => rim(6, height, FRAC_PI_2, cells),
        };
        whole = if matches!(cells, Cells::Quadrilaterals) { whole } else { mirrored(&whole) };
        let mut whole = whole.paired(&slaves, InterfaceOptions::default());
        let mut quarter = rim(6, height, FRAC_PI_2, cells).scene(&slaves, InterfaceOptions::default());
        let planes = [0, 1].map(|axis| SymmetryPlane::across(axis, [0.0; 3]));
        quarter.interface.set_symmetry(&planes).unwrap();
        quarter.refresh();
        let of = |scene: &mut Scene| -> Vec<f64> {
            scene.interface.evaluate(Mode::Value).unwrap().iter().map(|contact| contact.point.gap).collect()
        };
        for (k, (one, other)) in of(&mut whole).iter().zip(of(&mut quarter)).enumerate() {
            assert!((one - other).abs() < 1e-12, "{cells:?}, {k}: {one} {other}");
        }
    }
}

/// A quarter of a rim with its three images.
fn mirrored(quarter: &Mesh) -> Mesh {
    let mut mesh = Mesh { positions: Vec::new(), facets: Vec::new() };
    let same = |x: &Point, y: &Point| (0..3).all(|k| (x[k] - y[k]).abs() < 1e-12);
    for [a, b] in [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]] {
        let places: Vec<usize> = quarter
            .positions
            .iter()
            .map(|&[x, y, z]| {
                let image = [a * x, b * y, z];
                let known = mesh.positions.iter().position(|other| same(other, &image));
                known.unwrap_or_else(|| {
                    mesh.positions.push(image);
                    mesh.positions.len() - 1
                })
            })
            .collect();
        let image = |facet: &Facet| match *facet {
            Facet::Triangle(corners) => Facet::Triangle(corners.map(|node| places[node])),
            Facet::Quadrilateral(corners) => Facet::Quadrilateral(corners.map(|node| places[node])),
        };
        let facets = quarter.facets.iter().map(image);
        mesh.facets.extend(facets.map(|facet| if a * b < 0.0 { facet.flipped() } else { facet }));
    }
    mesh
}

/// Derivatives by auxiliary points are those of the nodes that carry them: middles in a wide strip, ghost nodes in a narrow one.
#[test]
fn derivatives_by_auxiliary_points_go_to_their_nodes() {
    for (weight, (height, part)) in
        Weight::ALL.into_iter().flat_map(|weight| [(weight, (2.0, 0.5)), (weight, (0.17, -4.0))])
    {
        let element = ContactElement::diffuse(SearchOptions::domains()).with_weight(weight);
        let options = InterfaceOptions::default().with_element(element);
        let slaves = over(40, height, TAU, [-0.02, 0.05]);
        let mut scene = rim(12, height, TAU, Cells::Mixed).paired(&slaves, options);
        scene.interface.evaluate(Mode::Hessian).unwrap();
        for k in 0..slaves.len() {
            let element = scene.interface.element(k).unwrap();
            let PairedElement::Diffuse { pairing, slave } = &element else { panic!("a diffuse element") };
            assert_eq!(pairing.basis, Basis::Quadratic);
            assert!(pairing.others.iter().any(|(_, own)| *own == part), "{k}");
            assert!(pairing.others.iter().all(|(_, own)| *own == part || *own == 0.0), "{k}");
            let contact = scene.interface.contacts().get(k);
            assert_eq!(contact.outcome, Outcome::Contact { fallback: Fallback::None });
            let expected = Ad.gap(&pairing.element(*slave), Mode::Hessian).unwrap();
            let expected = of_listed(expected, pairing, contact.nodes);
            let both =
                [(contact.gradient, &expected.gradient[..]), (contact.hessian, expected.hessian.packed())];
            for (found, expected) in both {
                let size = expected.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
                let error = found.iter().zip(expected).map(|(x, y)| (x - y).abs()).fold(0.0, worse);
                assert!(error < 1e-12 * size, "{weight:?}, {k}: {error:e} of {size}");
            }
        }
    }
}

/// Where strips turn in their own surface ghost nodes would come to lie in one another's way: gaps are about those of facets at worst.
#[test]
fn strips_that_turn_are_hardly_worse_than_facets() {
    let cells = |all: &[[usize; 2]], place: &dyn Fn(f64, f64) -> Point| {
        let mut mesh = Mesh { positions: Vec::new(), facets: Vec::new() };
        let mut numbers = std::collections::BTreeMap::new();
        for &[i, j] in all {
            let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|at| {
                *numbers.entry(at).or_insert_with(|| {
                    mesh.positions.push(place(at[0] as f64, at[1] as f64));
                    mesh.positions.len() - 1
                })
            });
            mesh.facets.push(Facet::Quadrilateral(corners));
        }
        mesh
    };
    let ell: Vec<[usize; 2]> = (0..8).map(|i| [i, 0]).chain((1..6).map(|j| [0, j])).collect();
    let frame: Vec<[usize; 2]> =
        (0..10).flat_map(|i| (0..7).map(move |j| [i, j])).filter(|[i, j]| i % 9 == 0 || j % 6 == 0).collect();
    let plus: Vec<[usize; 2]> =
        (0..9).map(|i| [i, 4]).chain((0..9).filter(|j| *j != 4).map(|j| [4, j])).collect();
    // z of a point, what facets are off by, and the mesh.
    let cylinder = |x: f64, _: f64| (100.0 - (x - 4.5) * (x - 4.5)).sqrt() - 10.0;
    let sphere = |x: f64, y: f64| (100.0 - (x - 4.5).powi(2) - (y - 4.5).powi(2)).sqrt() - 10.0;
    let cone = |x: f64, y: f64| 0.5 * x.hypot(y);
    type Height = fn(f64, f64) -> f64;
    let on = |height: Height| move |x: f64, y: f64| [x, y, height(x, y)];
    let mut all: Vec<(String, Height, f64, Mesh)> = Vec::new();
    for (name, list) in [("ell", &ell), ("frame", &frame), ("plus", &plus)] {
        for (on_name, height, facets) in [("cylinder", cylinder as Height, 0.0125), ("sphere", sphere, 0.025)]
        {
            all.push((format!("{name} on a {on_name}"), height, facets, cells(list, &on(height))));
        }
    }
    for around in [10, 12, 16] {
        let half = std::f64::consts::PI / around as f64;
        let facets = 0.5 * 1.25 * (1.0 - half.cos()) / 1.25_f64.sqrt();
        let mesh = strip(around, true, Cells::Quadrilaterals, |s, t| {
            let (sin, cos) = (TAU * s).sin_cos();
            let radius = 1.25 - 0.5 * t;
            [radius * cos, radius * sin, 0.5 * radius]
        });
        all.push((format!("washer of {around}"), cone, facets, mesh));
    }
    for (name, height, facets, mesh) in all {
        let slaves = inside(&mesh, 400, |x, y| height(x, y) + 0.03);
        let mut scene = mesh.paired(&slaves, InterfaceOptions::default());
        let contacts = scene.interface.evaluate(Mode::Value).unwrap();
        let error = |contact: ContactRef<'_>| {
            let slave = scene.positions[contact.slave];
            assert!(contact.outcome.is_contact(), "{name}, {slave:?}: {:?}", contact.outcome);
            let slope = 1e-6;
            let dz =
                |a: f64, b: f64| (height(slave[0] + a, slave[1] + b) - height(slave[0], slave[1])) / slope;
            let exact = 0.03 / (1.0 + dz(slope, 0.0).powi(2) + dz(0.0, slope).powi(2)).sqrt();
            (contact.point.gap - exact).abs()
        };
        let error = contacts.iter().map(error).fold(0.0, worse) / facets;
        println!("{name}: {error:.3} of the largest error of facets");
        assert!(error < 1.3, "{name}: {error}");
    }
}

/// Points over random places of the facets, at this height.
fn inside(mesh: &Mesh, count: usize, height: impl Fn(f64, f64) -> f64) -> Vec<Point> {
    let mut random = Uniform(3);
    (0..count)
        .map(|k| {
            let Facet::Quadrilateral(corners) = mesh.facets[k % mesh.facets.len()] else { unreachable!() };
            let [s, t] = [0.02 + 0.96 * random.next(), 0.02 + 0.96 * random.next()];
            let parts = [(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t];
            let at = |axis: usize| (0..4).map(|c| parts[c] * mesh.positions[corners[c]][axis]).sum::<f64>();
            [at(0), at(1), height(at(0), at(1))]
        })
        .collect()
}

/// A plane strip has middles. A corner that is cut into triangles has no rung, although both its ends are on the border.
#[test]
fn rungs_are_where_there_is_one_row() {
    let points = |mesh: &Mesh, slave: Point| {
        let scene = mesh.paired(&[slave], InterfaceOptions::default());
        let Ok(PairedElement::Diffuse { pairing, .. }) = scene.interface.element(0) else {
            panic!("no pairing")
        };
        pairing.others.iter().filter(|(_, part)| *part != 0.0).count()
    };
    assert!(points(&Mesh::grid([9, 2], [false; 2], |s, t| [8.0 * s, t, 0.0]), [4.2, 0.3, 0.1]) >= 2);
    for slave in [[0.2, 0.3, 0.1], [1.8, 1.7, 0.1], [0.3, 1.8, 0.1]] {
        assert_eq!(points(&Mesh::plane(2.0, 2.0, 1.0), slave), 0);
    }
}

/// Along a parabola of eight cells: the steeper, the farther facets at its ends lean. Errors of facets are up to a quarter of the factor.
#[test]
fn open_strips_that_bend_have_contact_at_any_width() {
    for (steep, largest) in [(0.1, 0.25), (0.2, 1.4), (0.25, 4.0)] {
        let z = |x: f64| steep * (x - 4.0) * (x - 4.0);
        for width in [0.05, 0.25, 0.5, 1.0, 2.0, 4.0] {
            let mut random = Uniform(5);
            let slave = |_| {
                let x = 0.3 + 7.4 * random.next();
                let slope = 2.0 * steep * (x - 4.0);
                let scale = 0.02 / slope.hypot(1.0);
                [x - slope * scale, width * random.next(), z(x) + scale]
            };
            let slaves: Vec<Point> = (0..200).map(slave).collect();
            for cells in [Cells::Quadrilaterals, Cells::Triangles, Cells::Mixed] {
                let mesh = strip(8, false, cells, |s, t| [8.0 * s, width * t, z(8.0 * s)]);
                let mut scene = mesh.scene(&slaves, InterfaceOptions::default());
                let report = scene.refresh();
                // Wide triangles that lean by 28° to one another carry the quadratic basis nearly everywhere.
                let linear = if steep < 0.25 { 0 } else { 20 };
                assert_eq!(report.paired, 200, "{steep} {width} {cells:?}");
                assert!(
                    report.fallbacks.linear <= linear,
                    "{steep} {width} {cells:?}: {:?}",
                    report.fallbacks
                );
                let contacts = scene.interface.evaluate(Mode::Value).unwrap();
                let error = |contact: ContactRef<'_>| {
                    assert!(contact.outcome.is_contact(), "{steep} {width} {cells:?}: {:?}", contact.outcome);
                    (contact.point.gap - 0.02).abs()
                };
                let error = contacts.iter().map(error).fold(0.0, worse) / (steep / 4.0);
                println!("{steep} x², {width} wide, {cells:?}: {error:.3} of the largest error of facets");
                assert!(error < largest, "{steep} {width} {cells:?}: {error}");
            }
        }
    }
}
