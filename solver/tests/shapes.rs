//! Each shape against its closed form: volumes, orientation, closed skins, names.

use std::collections::{BTreeMap, HashMap};
use std::f64::consts::PI;

use diffuse_contact::surface::{Facet, MasterSurface};
use diffuse_contact_mesh::ElementKind;
use diffuse_contact_solver::material::Material;
use diffuse_contact_solver::model::shape::*;
use diffuse_contact_solver::model::{Cell, MAX_NODES, Model, ModelError, Part, ShapeError};
use nalgebra::Vector3;

const SOFT: Material = Material::elastic(1.0, 0.0);

/// Whether a model takes it.
fn check(part: Part) -> Result<(), ModelError> {
    Model::default().add("ball", part, Some(SOFT))
}

/// Nodes of the two-point rule on [0, 1].
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// Volume of a trilinear hexahedron, exact.
fn volume(corners: [[f64; 3]; 8]) -> f64 {
    let at = |i: usize, j: usize, k: usize| {
        let [u, v, w] = [GAUSS[i], GAUSS[j], GAUSS[k]];
        let mut columns = [Vector3::zeros(); 3];
        for (corner, offset) in
            [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
                .iter()
                .enumerate()
        {
            let [(a, da), (b, db), (c, dc)] = [(u, offset[0]), (v, offset[1]), (w, offset[2])]
                .map(|(x, high)| if high == 1 { (x, 1.0) } else { (1.0 - x, -1.0) });
            let corner = Vector3::from(corners[corner]);
            columns[0] += corner * (da * b * c);
            columns[1] += corner * (a * db * c);
            columns[2] += corner * (a * b * dc);
        }
        columns[0].cross(&columns[1]).dot(&columns[2])
    };
    let points = (0..8).map(|n| at(n & 1, (n >> 1) & 1, n >> 2));
    points.inspect(|jacobian| assert!(*jacobian > 0.0)).sum::<f64>() / 8.0
}

/// ∫ x·n/3 over a facet, exact for triangles and bilinear quadrilaterals.
fn flux(facet: &Facet, nodes: &[[f64; 3]]) -> f64 {
    let p: Vec<Vector3<f64>> = facet.corners().iter().map(|&n| nodes[n].into()).collect();
    match p[..] {
        [a, b, c] => a.dot(&b.cross(&c)) / 6.0,
        _ => {
            let point = |u: f64, v: f64| {
                let x = p[0] * ((1.0 - u) * (1.0 - v))
                    + p[1] * (u * (1.0 - v))
                    + p[2] * (u * v)
                    + p[3] * ((1.0 - u) * v);
                let along_u = (p[1] - p[0]) * (1.0 - v) + (p[2] - p[3]) * v;
                let along_v = (p[3] - p[0]) * (1.0 - u) + (p[2] - p[1]) * u;
                x.dot(&along_u.cross(&along_v))
            };
            (0..4).map(|n| point(GAUSS[n & 1], GAUSS[n >> 1])).sum::<f64>() / 12.0
        }
    }
}

/// Checks what all solids have to be, and that the volume is that of the body within `tolerance`.
fn solid(shape: Shape, exact: f64, tolerance: f64, faces: &[&str]) -> Part {
    let part = shape.part(ElementKind::Hexahedron8).unwrap();
    let hexahedra = hexahedra(&part);
    let skin = part.outside();
    let enclosed: f64 = skin.iter().map(|facet| flux(facet, &part.nodes)).sum();
    assert!((enclosed / hexahedra - 1.0).abs() < 1e-12, "skin {enclosed}, hexahedra {hexahedra}");
    assert!((hexahedra / exact - 1.0).abs() < tolerance, "volume {hexahedra}, closed form {exact}");
    for (name, kind) in KINDS {
        let other = shape.part(kind).unwrap_or_else(|error| panic!("{name}: {error}"));
        let enclosed: f64 = other.outside().iter().map(|facet| flux(facet, &other.nodes)).sum();
        // The facets between the nodes of second order are flat, and closer to what is round.
        assert!(
            (enclosed / exact - 1.0).abs() < 2.0 * tolerance,
            "{name}: volume {enclosed}, closed form {exact}"
        );
        sound(other, faces);
    }
    sound(part, faces)
}

/// Volume of a part of trilinear hexahedra.
fn hexahedra(part: &Part) -> f64 {
    let corners = |cell: Cell<'_>| std::array::from_fn(|k| part.nodes[cell.nodes[k]]);
    part.elements.iter().map(|cell| volume(corners(cell))).sum()
}

/// Checks what solids of all kinds of element have to be.
fn sound(part: Part, faces: &[&str]) -> Part {
    let skin = part.outside();
    assert!(edges_shared_by_two(&skin));

    // The named faces make up the whole skin, each facet once.
    let mut count: HashMap<Facet, usize> = HashMap::new();
    part.surfaces.values().flatten().for_each(|&facet| *count.entry(facet).or_default() += 1);
    assert_eq!(part.surfaces.keys().collect::<Vec<_>>(), faces);
    assert_eq!(part.node_sets.keys().collect::<Vec<_>>(), faces);
    assert!(count.len() == skin.len() && count.values().all(|&uses| uses == 1));
    // A surface that the contact accepts, and a part that the model does.
    MasterSurface::new(&part.nodes, skin).unwrap();
    Model::default().add("part", part.clone(), Some(SOFT)).unwrap();
    part
}

/// Checks what all rigid surfaces have to be, and the volume below them, ∫ x·n/3.
fn rigid(shape: Shape, exact: f64, tolerance: f64, closed: bool, sets: &[&str]) -> Part {
    let part = shape.part(ElementKind::Hexahedron8).unwrap();
    assert!(shape.is_rigid() && part.elements.is_empty());
    let enclosed: f64 = part.facets.iter().map(|facet| flux(facet, &part.nodes)).sum();
    assert!((enclosed - exact).abs() < tolerance * exact.abs().max(1.0), "{enclosed}, closed form {exact}");
    assert_eq!(edges_shared_by_two(&part.facets), closed);
    assert_eq!(part.node_sets.keys().collect::<Vec<_>>(), sets);
    MasterSurface::new(&part.nodes, part.facets.clone()).unwrap();
    Model::default().add("part", part.clone(), None).unwrap();
    part
}

/// Whether each edge belongs to two facets, which run through it in opposite directions.
fn edges_shared_by_two(facets: &[Facet]) -> bool {
    let mut edges: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for facet in facets {
        let corners = facet.corners();
        for k in 0..corners.len() {
            *edges.entry((corners[k], corners[(k + 1) % corners.len()])).or_default() += 1;
        }
    }
    edges.iter().all(|(&(a, b), &uses)| uses == 1 && edges.get(&(b, a)) == Some(&1))
}

/// Checks that a set holds exactly the nodes for which `belongs`.
fn assert_set(part: &Part, name: &str, belongs: impl Fn([f64; 3]) -> bool) {
    let expected: Vec<usize> = (0..part.nodes.len()).filter(|&n| belongs(part.nodes[n])).collect();
    assert!(!expected.is_empty());
    assert_eq!(part.node_sets[name], expected, "{name}");
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-12 * (1.0 + b.abs())
}

#[test]
fn a_graded_block() {
    let block = Block {
        origin: [-1.0, 2.0, 0.5],
        size: [2.0, 3.0, 0.25],
        divisions: [5, 1, 3],
        grading: [10.0, 1.0, 0.2],
    };
    let part = solid(Shape::Block(block), 1.5, 1e-12, &["x+", "x-", "y+", "y-", "z+", "z-"]);
    assert_eq!((part.nodes.len(), part.elements.len()), (6 * 2 * 4, 15));
    for (axis, (low, high)) in [("x-", "x+"), ("y-", "y+"), ("z-", "z+")].into_iter().enumerate() {
        assert_set(&part, low, |x| near(x[axis], block.origin[axis]));
        assert_set(&part, high, |x| near(x[axis], block.origin[axis] + block.size[axis]));
    }
}

#[test]
fn a_pipe_and_its_sectors_along_each_axis() {
    for (k, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
        let whole = Pipe {
            axis,
            inner_radius: 2.0,
            outer_radius: 3.0,
            angles: [0.0, 360.0],
            length: 4.0,
            divisions: [64, 2, 3],
            grading: [1.0, 2.0, 3.0],
        };
        let radius = |x: [f64; 3]| x[(k + 1) % 3].hypot(x[(k + 2) % 3]);
        let part = solid(Shape::Pipe(whole), 20.0 * PI, 2e-3, &["bottom", "inner", "outer", "top"]);
        assert_eq!((part.nodes.len(), part.elements.len()), (64 * 3 * 4, 64 * 2 * 3));
        assert_set(&part, "inner", |x| near(radius(x), 2.0));
        assert_set(&part, "outer", |x| near(radius(x), 3.0));
        assert_set(&part, "bottom", |x| near(x[k], 0.0));
        assert_set(&part, "top", |x| near(x[k], 4.0));

        let quarter = Pipe { angles: [0.0, 90.0], divisions: [16, 2, 3], grading: [2.0, 1.0, 1.0], ..whole };
        let faces = ["bottom", "end", "inner", "outer", "start", "top"];
        let part = solid(Shape::Pipe(quarter), 5.0 * PI, 2e-3, &faces);
        // Planes of symmetry are met exactly.
        assert_set(&part, "start", |x| x[(k + 2) % 3] == 0.0);
        assert_set(&part, "end", |x| x[(k + 1) % 3] == 0.0);
    }
}

/// A serpentine and a coil: Pappus' volume, and ends where they belong.
#[test]
fn strips_follow_their_path() {
    let faces = ["bottom", "end", "left", "right", "start", "top"];
    let path = vec![
        StripPiece::straight(4.0),
        StripPiece::arc(2.0, 180.0),
        StripPiece::straight(4.0),
        StripPiece::arc(2.0, -180.0),
        StripPiece::straight(4.0),
    ];
    let length = 12.0 + 4.0 * PI;
    let bent = Strip { path, thickness: 1.0, width: 3.0, divisions: [120, 2, 3] };
    let part = solid(Shape::Strip(bent.clone()), 3.0 * length, 2e-3, &faces);
    assert_set(&part, "start", |x| x[0] == 0.0 && x[1].abs() <= 0.5);
    assert_set(&part, "end", |x| near(x[0], 4.0) && near(x[1].clamp(7.5, 8.5), x[1]));
    assert_set(&part, "top", |x| near(x[2], 3.0));

    // Two turns to the left around (0, 5), which rise by 8.
    let coil = Strip {
        path: vec![StripPiece::arc(5.0, 720.0).with_rise(8.0)],
        thickness: 1.0,
        width: 2.0,
        divisions: [96, 1, 2],
    };
    let part = solid(Shape::Strip(coil.clone()), 2.0 * 20.0 * PI, 4e-3, &faces);
    let radius = |x: [f64; 3]| x[0].hypot(x[1] - 5.0);
    assert_set(&part, "left", |x| near(radius(x), 4.5));
    assert_set(&part, "right", |x| near(radius(x), 5.5));
    assert_set(&part, "end", |x| near(x[0], 0.0) && x[2] > 7.9 && x[1] < 5.0);

    let refused_path = |path: Vec<StripPiece>| refused(Shape::Strip(Strip { path, ..bent.clone() }));
    assert_eq!(refused_path(vec![]), ("path", 0.0));
    assert_eq!(refused_path(vec![StripPiece::straight(-1.0)]), ("path", -1.0));
    let (field, radius) = refused_path(vec![StripPiece::arc(0.4, 90.0)]);
    assert!(field == "path" && near(radius, 0.4));
    assert_eq!(refused(Shape::Strip(Strip { divisions: [4, 1, 1], ..coil })), ("divisions", 4.0));
}

#[test]
fn cylinders_whole_half_and_quarter() {
    let whole = Cylinder {
        axis: Axis::Y,
        radius: 2.0,
        length: 3.0,
        keep: vec![],
        divisions: [4, 3, 2],
        core: 0.5,
        grading: [1.0; 3],
        layer_grading: 1.0,
    };
    let x_plus = HalfSpace { axis: Axis::X, positive: true };
    let z_minus = HalfSpace { axis: Axis::Z, positive: false };
    let part = solid(Shape::Cylinder(whole.clone()), 12.0 * PI, 8e-3, &["bottom", "outer", "top"]);
    assert_set(&part, "outer", |x| near(x[0].hypot(x[2]), 2.0));
    assert_set(&part, "top", |x| near(x[1], 3.0));
    let half =
        Cylinder { keep: vec![z_minus], grading: [6.0, 2.0, 1.0], layer_grading: 0.2, ..whole.clone() };
    let part = solid(Shape::Cylinder(half), 6.0 * PI, 3e-2, &["bottom", "outer", "top", "z0"]);
    assert_set(&part, "z0", |x| x[2] == 0.0);
    assert!(part.nodes.iter().all(|x| x[2] <= 0.0));
    let quarter = Cylinder { keep: vec![z_minus, x_plus], divisions: [8, 3, 1], ..whole };
    let part = solid(Shape::Cylinder(quarter), 3.0 * PI, 3e-3, &["bottom", "outer", "top", "x0", "z0"]);
    assert_set(&part, "x0", |x| x[0] == 0.0);
    assert!(part.nodes.iter().all(|x| x[0] >= 0.0 && x[2] <= 0.0));
    assert_eq!(part.elements.len(), 64 + 16 * 3);
}

#[test]
fn balls_whole_half_quarter_and_eighth() {
    let halves = [
        HalfSpace { axis: Axis::Z, positive: false },
        HalfSpace { axis: Axis::X, positive: true },
        HalfSpace { axis: Axis::Y, positive: true },
    ];
    let faces: [&[&str]; 4] =
        [&["outer"], &["outer", "z0"], &["outer", "x0", "z0"], &["outer", "x0", "y0", "z0"]];
    for (cuts, faces) in faces.into_iter().enumerate() {
        for (grading, layer_grading) in [([1.0; 3], 1.0), ([8.0, 8.0, 1.0], 0.1)] {
            let ball = Ball {
                radius: 5.0,
                keep: halves[..cuts].to_vec(),
                divisions: [6, 4],
                core: 0.5,
                grading,
                layer_grading,
            };
            let exact = 4.0 / 3.0 * PI * 125.0 / f64::from(1 << cuts);
            let part = solid(Shape::Ball(ball), exact, 6e-2, faces);
            assert_set(&part, "outer", |x| near(Vector3::from(x).norm(), 5.0));
            assert!(
                part.nodes.iter().any(|x| near(x[2], -5.0) && x[0] == 0.0 && x[1] == 0.0),
                "the pole is a node"
            );
        }
    }
    // Second order in the size of the cells.
    let error = |n: usize| {
        let ball = Ball {
            radius: 1.0,
            keep: halves.to_vec(),
            divisions: [n, n],
            core: 0.5,
            grading: [1.0; 3],
            layer_grading: 1.0,
        };
        let part = ball.part(ElementKind::Hexahedron8).unwrap();
        PI / 6.0 - hexahedra(&part)
    };
    let order = (error(4) / error(8)).log2();
    assert!((order - 2.0).abs() < 0.1, "order {order}");
}

/// Nodes in the middle of edges lie on the curved surface, too, and elements keep their orientation at all points.
#[test]
fn elements_of_second_order_follow_the_curve() {
    use diffuse_contact_solver::solid::Solid;
    let ball = Ball {
        radius: 2.0,
        keep: vec![],
        divisions: [2, 2],
        core: 0.5,
        grading: [1.0; 3],
        layer_grading: 1.0,
    };
    for (name, kind) in KINDS {
        let part = ball.part(kind).unwrap();
        let outer = &part.node_sets["outer"];
        let radius = |node: &usize| part.nodes[*node].iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!(outer.iter().all(|node| (radius(node) - 2.0).abs() < 1e-14), "{name}");
        // The whole ball but hex20's empty places: 4³ cells of the core, 2 layers on 6 × 16 faces.
        let cells = 4_usize.pow(3) + 2 * 6 * 16;
        let per_cell = if kind.corner_count() == 4 { 6 } else { 1 };
        assert_eq!(part.elements.len(), per_cell * cells, "{name}");
        let mut model = Model::default();
        model.add("ball", part, Some(Material::elastic(1.0, 0.3))).unwrap();
        Solid::new(&model.nodes, &model.bodies).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

#[test]
fn round_solids_have_no_poor_cells_for_any_core() {
    for core in [0.1, 0.35, 0.6] {
        for ratio in [0.05, 1.0, 20.0] {
            let ball = Ball {
                radius: 1.0,
                keep: vec![],
                divisions: [3, 2],
                core,
                grading: [ratio; 3],
                layer_grading: ratio,
            };
            let part = ball.part(ElementKind::Hexahedron8).unwrap();
            check(part).unwrap_or_else(|error| panic!("core {core}, grading {ratio}: {error}"));
            for (name, kind) in KINDS {
                let part = ball.part(kind).unwrap();
                check(part).unwrap_or_else(|error| panic!("{name}, core {core}, grading {ratio}: {error}"));
            }
        }
    }
}

#[test]
fn rigid_surfaces_face_the_side_that_is_touched() {
    let plane = RigidPlane { size: [2.0, 3.0], divisions: [2, 3], facets: Facets::Triangles };
    let part = rigid(Shape::RigidPlane(plane), 0.0, 1e-12, false, &["x+", "x-", "y+", "y-"]);
    assert_eq!(part.facets.len(), 12);
    let lifted = part.nodes.iter().map(|x| [x[0], x[1], 1.0]).collect::<Vec<_>>();
    assert!(near(part.facets.iter().map(|facet| flux(facet, &lifted)).sum(), 2.0), "the normal is +z");

    // ∫ (z − x z') dA / 3 below z = a sin kx over one wave.
    let wave = RigidWave {
        size: [2.0, 1.0],
        height: 0.3,
        wavelength: 2.0,
        divisions: [200, 1],
        facets: Facets::Quadrilaterals,
    };
    let part = rigid(Shape::RigidWave(wave), 0.0, 1e-3, false, &["x+", "x-", "y+", "y-"]);
    assert!(part.nodes.iter().any(|x| near(x[0], 0.5) && near(x[2], 0.3)));

    let cylinder = RigidCylinder {
        axis: Axis::X,
        radius: 2.0,
        angles: [0.0, 360.0],
        length: 3.0,
        divisions: [64, 2],
        facets: Facets::Triangles,
        side: Side::Outside,
    };
    // Without its ends ∫ x·n/3 is two thirds of the volume.
    let part = rigid(Shape::RigidCylinder(cylinder), 8.0 * PI, 2e-3, false, &["bottom", "top"]);
    assert!(part.nodes.iter().all(|x| near(x[1].hypot(x[2]), 2.0)));
    let bore = RigidCylinder { side: Side::Inside, angles: [-90.0, 90.0], divisions: [32, 2], ..cylinder };
    rigid(Shape::RigidCylinder(bore), -4.0 * PI, 2e-3, false, &["bottom", "end", "start", "top"]);

    let sphere = RigidSphere {
        radius: 2.0,
        keep: vec![],
        divisions: 10,
        grading: [1.0; 3],
        facets: Facets::Quadrilaterals,
        side: Side::Outside,
    };
    let exact = 32.0 / 3.0 * PI;
    rigid(Shape::RigidSphere(sphere.clone()), exact, 6e-3, true, &[]);
    rigid(
        Shape::RigidSphere(RigidSphere { facets: Facets::Triangles, ..sphere.clone() }),
        exact,
        8e-3,
        true,
        &[],
    );
    let cup = RigidSphere {
        keep: vec![HalfSpace { axis: Axis::Z, positive: false }],
        side: Side::Inside,
        ..sphere
    };
    let part = rigid(Shape::RigidSphere(cup), -exact / 2.0, 6e-3, false, &["z0"]);
    assert_set(&part, "z0", |x| x[2] == 0.0);

    let torus = RigidTorus {
        axis: Axis::Z,
        radius: 3.0,
        tube_radius: 1.0,
        angles: [0.0, 360.0],
        tube_angles: [0.0, 360.0],
        divisions: [96, 64],
        facets: Facets::Quadrilaterals,
        side: Side::Outside,
    };
    rigid(Shape::RigidTorus(torus), 6.0 * PI * PI, 3e-3, true, &[]);
    let crown = RigidTorus { angles: [0.0, 90.0], tube_angles: [0.0, 180.0], divisions: [24, 32], ..torus };
    let part = crown.part().unwrap();
    assert_eq!(part.node_sets.keys().collect::<Vec<_>>(), ["end", "start", "tube_end", "tube_start"]);
    assert!(part.nodes.iter().all(|x| x[2] >= 0.0));
}

/// The field and the value of the first number out of range.
fn refused(shape: Shape) -> (&'static str, f64) {
    match (shape.check(), shape.part(ElementKind::Hexahedron8).map(drop)) {
        (Err(error), Err(again)) => {
            assert_eq!(format!("{error:?}"), format!("{again:?}"));
            match error {
                ShapeError::OutOfRange { field, value, .. } => (field, value),
                ShapeError::TooManyNodes { count, limit } => {
                    assert_eq!(limit, MAX_NODES);
                    ("nodes", count)
                }
                ShapeError::NoMemory { .. } => panic!("{error}"),
            }
        }
        other => panic!("{shape:?} was accepted: {other:?}"),
    }
}

#[test]
fn numbers_out_of_range_are_refused() {
    let block = Block { origin: [0.0; 3], size: [1.0; 3], divisions: [1; 3], grading: [1.0; 3] };
    assert_eq!(refused(Shape::Block(Block { size: [1.0, -2.0, 1.0], ..block })), ("size", -2.0));
    assert_eq!(refused(Shape::Block(Block { divisions: [1, 0, 1], ..block })), ("divisions", 0.0));
    assert_eq!(refused(Shape::Block(Block { grading: [1.0, 1.0, 0.0], ..block })), ("grading", 0.0));
    assert_eq!(refused(Shape::Block(Block { divisions: [999, 999, 99], ..block })), ("nodes", 1e8));
    assert_eq!(refused(Shape::Block(Block { divisions: [usize::MAX; 3], ..block })).0, "nodes");
    assert!(refused(Shape::Block(Block { size: [f64::NAN, 1.0, 1.0], ..block })).1.is_nan());

    let pipe = Pipe {
        axis: Axis::Z,
        inner_radius: 2.0,
        outer_radius: 3.0,
        angles: [0.0, 90.0],
        length: 1.0,
        divisions: [2; 3],
        grading: [1.0; 3],
    };
    assert_eq!(refused(Shape::Pipe(Pipe { outer_radius: 2.0, ..pipe })), ("outer_radius", 2.0));
    assert_eq!(refused(Shape::Pipe(Pipe { angles: [0.0, 361.0], ..pipe })), ("angles", 361.0));
    assert_eq!(refused(Shape::Pipe(Pipe { angles: [90.0, 90.0], ..pipe })), ("angles", 0.0));
    assert_eq!(refused(Shape::Pipe(Pipe { angles: [0.0, 360.0], ..pipe })), ("divisions", 2.0));
    assert_eq!(
        refused(Shape::Pipe(Pipe { angles: [0.0, 180.0], divisions: [1; 3], ..pipe })),
        ("divisions", 1.0)
    );

    let both = vec![HalfSpace::ALL[0], HalfSpace::ALL[1]];
    let ball = Ball {
        radius: 1.0,
        keep: both.clone(),
        divisions: [2, 2],
        core: 0.5,
        grading: [1.0; 3],
        layer_grading: 1.0,
    };
    assert_eq!(refused(Shape::Ball(ball.clone())), ("keep", 2.0));
    assert_eq!(refused(Shape::Ball(Ball { keep: vec![], core: 0.9, ..ball.clone() })), ("core", 0.9));
    assert_eq!(refused(Shape::Ball(Ball { keep: vec![], divisions: [200, 200], ..ball })).0, "nodes");
    let cylinder = Cylinder {
        axis: Axis::X,
        radius: 1.0,
        length: 1.0,
        keep: both,
        divisions: [1; 3],
        core: 0.5,
        grading: [1.0; 3],
        layer_grading: 1.0,
    };
    assert_eq!(refused(Shape::Cylinder(cylinder)).0, "keep");

    let torus = RigidTorus {
        axis: Axis::Z,
        radius: 1.0,
        tube_radius: 1.0,
        angles: [0.0, 360.0],
        tube_angles: [0.0, 360.0],
        divisions: [8, 8],
        facets: Facets::Triangles,
        side: Side::Outside,
    };
    assert_eq!(refused(Shape::RigidTorus(torus)), ("tube_radius", 1.0));
    let sphere = RigidSphere {
        radius: 1.0,
        keep: vec![],
        divisions: 1000,
        grading: [1.0; 3],
        facets: Facets::Triangles,
        side: Side::Outside,
    };
    // The nodes of a cube's faces, 24 n² + 2, and of the half of them.
    assert_eq!(refused(Shape::RigidSphere(sphere.clone())), ("nodes", 24e6 + 2.0));
    let half = RigidSphere { keep: vec![HalfSpace::ALL[0]], divisions: 1500, ..sphere };
    assert_eq!(refused(Shape::RigidSphere(half)), ("nodes", 12.0 * 1500.0_f64.powi(2) + 6000.0 + 1.0));
    let wave = RigidWave {
        size: [1.0; 2],
        height: f64::INFINITY,
        wavelength: 1.0,
        divisions: [1; 2],
        facets: Facets::Triangles,
    };
    assert_eq!(refused(Shape::RigidWave(wave)).0, "height");
}
