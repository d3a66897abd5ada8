//! Reference elements: shape functions and integration points.
//!
//! The shape functions of a kind are the polynomials that are 1 at one of its nodes and 0 at the others, in the span of the monomials
//! that [`spans`] lists.

use std::array;
use std::sync::LazyLock;

use diffuse_contact_mesh::ElementKind;
use nalgebra::{DMatrix, Vector3};

/// A kind of element: its integration points with what is known there.
#[derive(Clone, Debug)]
pub(super) struct Reference {
    /// Points of the energy of distortion; they carry the states of the material.
    pub distortion: Points,
    /// Points of the energy of dilatation, as many or fewer.
    pub dilatation: Points,
    /// For each node what extrapolates values at the points of distortion to it; the entries add up to 1.
    pub extrapolation: Vec<Vec<f64>>,
    /// For each point of distortion what brings values there from those of dilatation; the entries add up to 1.
    pub pressure: Vec<Vec<f64>>,
}

/// Integration points.
#[derive(Clone, Debug)]
pub(super) struct Points {
    /// They add up to the reference volume.
    pub weights: Vec<f64>,
    /// Natural gradients of the shape functions of the nodes at each point, then those of incompatible modes.
    pub gradients: Vec<Vec<Vector3<f64>>>,
    /// Number of incompatible modes.
    pub modes: usize,
    /// With modes the gradients of the nodes' shape functions at the centre.
    pub centre: Vec<Vector3<f64>>,
}

/// A product of powers of the natural coordinates.
type Monomial = [i32; 3];

impl Reference {
    /// That of a solid kind, or of hexahedra with incompatible modes.
    pub fn of(kind: ElementKind, incompatible_modes: bool) -> &'static Self {
        static INCOMPATIBLE: LazyLock<Reference> = LazyLock::new(Reference::incompatible);
        if incompatible_modes && kind == ElementKind::Hexahedron8 {
            return &INCOMPATIBLE;
        }
        static ALL: LazyLock<[Reference; 7]> = LazyLock::new(|| ElementKind::SOLIDS.map(Reference::new));
        let place = ElementKind::SOLIDS.iter().position(|&solid| solid == kind);
        place.map_or_else(|| unreachable!("{kind:?} is no solid"), |place| &ALL[place])
    }

    fn new(kind: ElementKind) -> Self {
        Self::with_rules(kind, rules(kind), 0)
    }

    /// A hexahedron with 8 nodes and the modes 1 − ξ², 1 − η², 1 − ζ².
    ///
    /// The dilatation of the nodes' motion has the products ηζ, ζξ and ξη, which no mode takes away and which would lock as ν → 0.5. It
    /// is taken at the centres of the faces, where these are 0: with equal weights, exact to the third degree.
    fn incompatible() -> Self {
        let [distortion, _] = rules(ElementKind::Hexahedron8);
        let on_face =
            |k: usize| array::from_fn(|axis| if axis == k / 2 { 2.0 * (k % 2) as f64 - 1.0 } else { 0.0 });
        let dilatation = (0..6).map(|k| (on_face(k), 4.0 / 3.0)).collect();
        Self::with_rules(ElementKind::Hexahedron8, [distortion, dilatation], 3)
    }

    fn with_rules(kind: ElementKind, [distortion, dilatation]: [Rule; 2], modes: usize) -> Self {
        let nodes = nodes(kind);
        let monomials = monomials(|monomial| spans(kind, monomial));
        let coefficients = coefficients(&nodes, &monomials);
        let gradient = |point: &[f64; 3]| {
            let of_node = |node: usize| {
                Vector3::from_fn(|axis, _| {
                    let terms = monomials.iter().enumerate();
                    terms
                        .map(|(k, monomial)| coefficients[(k, node)] * derivative(monomial, axis, point))
                        .sum()
                })
            };
            let of_mode =
                |k: usize| Vector3::from_fn(|axis, _| if axis == k { -2.0 * point[axis] } else { 0.0 });
            (0..nodes.len()).map(of_node).chain((0..modes).map(of_mode)).collect::<Vec<_>>()
        };
        let [at, of_pressure] =
            [&distortion, &dilatation].map(|rule| rule.iter().map(|&(x, _)| x).collect::<Vec<_>>());
        let points = |rule: Rule| Points {
            weights: rule.iter().map(|&(_, weight)| weight).collect(),
            gradients: rule.iter().map(|(x, _)| gradient(x)).collect(),
            modes,
            centre: if modes == 0 { Vec::new() } else { gradient(&[0.0; 3])[..nodes.len()].to_vec() },
        };
        Self {
            extrapolation: carried_over(kind, &at, &nodes),
            pressure: carried_over(kind, &of_pressure, &at),
            distortion: points(distortion),
            dilatation: points(dilatation),
        }
    }
}

/// An integration point of a face.
#[derive(Clone, Debug)]
pub struct FacePoint {
    /// Its reference area.
    pub weight: f64,
    /// N, N,ξ, N,η of each node.
    pub functions: Vec<[f64; 3]>,
}

/// The integration points of a face by its number of nodes: a triangle with 3 or 6, a quadrilateral with 4, 8 or 9.
///
/// # Panics
/// For another number.
pub fn face_points(nodes: usize) -> &'static [FacePoint] {
    const FACES: [ElementKind; 5] = [
        ElementKind::Triangle3,
        ElementKind::Quadrilateral4,
        ElementKind::Triangle6,
        ElementKind::Quadrilateral8,
        ElementKind::Quadrilateral9,
    ];
    static ALL: LazyLock<[Vec<FacePoint>; 5]> = LazyLock::new(|| FACES.map(points_of_face));
    let place = FACES.iter().position(|kind| kind.node_count() == nodes);
    place.map_or_else(|| panic!("no face has {nodes} nodes"), |place| &ALL[place])
}

fn points_of_face(kind: ElementKind) -> Vec<FacePoint> {
    // The face of a solid in the plane of the first two coordinates.
    let (is_triangle, second) = (kind.corner_count() == 3, kind.has_middles());
    let solid = match (is_triangle, kind.node_count()) {
        (true, 3) => ElementKind::Wedge6,
        (true, _) => ElementKind::Wedge15,
        (false, 4) => ElementKind::Hexahedron8,
        (false, 8) => ElementKind::Hexahedron20,
        (false, _) => ElementKind::Hexahedron27,
    };
    let mut nodes: Vec<[f64; 3]> =
        nodes(solid)[..kind.corner_count()].iter().map(|&[x, y, _]| [x, y, 0.0]).collect();
    let between = kind.edges().iter().map(|&[a, b]| [0, 1, 2].map(|k| 0.5 * (nodes[a][k] + nodes[b][k])));
    let middles: Vec<[f64; 3]> = between.collect();
    nodes.extend(middles);
    nodes.resize(kind.node_count(), [0.0; 3]);
    let monomials = monomials(|[a, b, c]| c == 0 && spans(solid, [a, b, 0]));
    let coefficients = coefficients(&nodes, &monomials);
    let line = if second { LINE3.as_slice() } else { &LINE2 };
    let rule: Rule = if is_triangle && second {
        // A follower on a curved triangle is a polynomial of the fourth degree.
        let orbit = |(a, w): (f64, f64)| {
            let b = 1.0 - 2.0 * a;
            [[a, a], [a, b], [b, a]].map(|[x, y]| ([x, y, 0.0], 0.5 * w))
        };
        DUNAVANT4.into_iter().flat_map(orbit).collect()
    } else if is_triangle {
        TRIANGLE.iter().map(|&[x, y]| ([x, y, 0.0], 1.0 / 6.0)).collect()
    } else {
        line.iter().flat_map(|&(x, u)| line.iter().map(move |&(y, v)| ([x, y, 0.0], u * v))).collect()
    };
    let point = |(x, weight): ([f64; 3], f64)| {
        let at = |node: usize| {
            let sum = |of: &dyn Fn(&Monomial) -> f64| -> f64 {
                monomials.iter().enumerate().map(|(k, monomial)| coefficients[(k, node)] * of(monomial)).sum()
            };
            [sum(&|m| value(m, &x)), sum(&|m| derivative(m, 0, &x)), sum(&|m| derivative(m, 1, &x))]
        };
        FacePoint { weight, functions: (0..nodes.len()).map(at).collect() }
    };
    rule.into_iter().map(point).collect()
}

/// Whether the shape functions of a kind span a monomial: all up to the first or the second degree in what belongs together, of which
/// elements without nodes in the middle of faces leave out what has two squares or more.
fn spans(kind: ElementKind, [a, b, c]: Monomial) -> bool {
    let largest = a.max(b).max(c);
    match kind {
        ElementKind::Tetrahedron4 => a + b + c <= 1,
        ElementKind::Tetrahedron10 => a + b + c <= 2,
        ElementKind::Wedge6 => a + b <= 1 && c <= 1,
        ElementKind::Wedge15 => a + b <= if c == 2 { 1 } else { 2 },
        ElementKind::Hexahedron8 => largest <= 1,
        ElementKind::Hexahedron20 => [a, b, c].iter().filter(|&&power| power == 2).count() <= 1,
        _ => largest <= 2,
    }
}

fn monomials(belongs: impl Fn(Monomial) -> bool) -> Vec<Monomial> {
    let all = (0..27).map(|k| [k % 3, k / 3 % 3, k / 9]);
    all.filter(|&monomial| belongs(monomial)).collect()
}

fn value(monomial: &Monomial, x: &[f64; 3]) -> f64 {
    (0..3).map(|axis| x[axis].powi(monomial[axis])).product()
}

fn derivative(monomial: &Monomial, axis: usize, x: &[f64; 3]) -> f64 {
    let mut lower = *monomial;
    lower[axis] -= 1;
    if lower[axis] < 0 { 0.0 } else { f64::from(monomial[axis]) * value(&lower, x) }
}

fn vandermonde(points: &[[f64; 3]], monomials: &[Monomial]) -> DMatrix<f64> {
    DMatrix::from_fn(points.len(), monomials.len(), |row, column| value(&monomials[column], &points[row]))
}

/// The coefficients of each node's shape function, a column each. They are multiples of 1/8, to which they are rounded.
fn coefficients(nodes: &[[f64; 3]], monomials: &[Monomial]) -> DMatrix<f64> {
    let inverse = vandermonde(nodes, monomials).try_inverse();
    let Some(inverse) = inverse else { unreachable!("the nodes of all kinds determine their polynomials") };
    inverse.map(|entry| (8.0 * entry).round() / 8.0)
}

/// Natural coordinates of a kind's nodes: tetrahedra and triangles have the corners 0 and the unit vectors, other directions reach from
/// −1 to 1.
fn nodes(kind: ElementKind) -> Vec<[f64; 3]> {
    const TRIANGLE: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    const SQUARE: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let layers = |base: &[[f64; 2]]| -> Vec<[f64; 3]> {
        [-1.0, 1.0].iter().flat_map(|&z| base.iter().map(move |&[x, y]| [x, y, z])).collect()
    };
    let mut nodes = match kind.corner_count() {
        4 => vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        6 => layers(&TRIANGLE),
        _ => layers(&SQUARE),
    };
    let mean = |corners: &[usize], nodes: &[[f64; 3]]| -> [f64; 3] {
        array::from_fn(|k| corners.iter().map(|&corner| nodes[corner][k]).sum::<f64>() / corners.len() as f64)
    };
    let between = kind.edges().iter().map(|ends| mean(ends, &nodes));
    let middles: Vec<[f64; 3]> =
        between.chain(kind.centres().iter().map(|around| mean(around, &nodes))).collect();
    nodes.extend(middles);
    if nodes.len() < kind.node_count() {
        nodes.push([0.0; 3]);
    }
    nodes
}

/// Gauss' points on a line from −1 to 1: ±1/√3.
const LINE2: [(f64, f64); 2] = [(-0.577_350_269_189_625_8, 1.0), (0.577_350_269_189_625_8, 1.0)];
/// ±√(3/5) and the middle.
const LINE3: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
/// The points of a triangle, of weight 1/6 each.
const TRIANGLE: [[f64; 2]; 3] = [[1.0 / 6.0, 1.0 / 6.0], [2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0]];

/// Six points of a triangle, exact for the fourth degree (Dunavant 1985): a coordinate that two area coordinates share, and the weight
/// relative to the area.
const DUNAVANT4: [(f64, f64); 2] = [
    (0.445_948_490_915_964_9, 0.223_381_589_678_011_47),
    (0.091_576_213_509_770_74, 0.109_951_743_655_321_87),
];

/// Natural coordinates and weights.
type Rule = Vec<([f64; 3], f64)>;

/// The points of distortion and of dilatation. On hexahedra of second order the volume is kept at 2 × 2 × 2 points: more of them lock as
/// ν → 0.5. Distortion needs 3 × 3 × 3, since a row of elements with fewer has motions without energy.
fn rules(kind: ElementKind) -> [Rule; 2] {
    let over_triangle = |line: &[(f64, f64)]| -> Rule {
        line.iter().flat_map(|&(z, w)| TRIANGLE.map(|[x, y]| ([x, y, z], w / 6.0))).collect()
    };
    let cube = |line: &[(f64, f64)]| -> Rule {
        let count = line.len();
        let at = |k: usize| [line[k % count], line[k / count % count], line[k / count / count]];
        (0..count.pow(3)).map(|k| (at(k).map(|(x, _)| x), at(k).iter().map(|(_, w)| w).product())).collect()
    };
    let alike = |rule: Rule| [rule.clone(), rule];
    match kind {
        ElementKind::Tetrahedron4 => alike(vec![([0.25; 3], 1.0 / 6.0)]),
        ElementKind::Tetrahedron10 => {
            let near = (5.0 - 5.0_f64.sqrt()) / 20.0;
            let towards =
                |k: usize| array::from_fn(|axis| if axis + 1 == k { 1.0 - 3.0 * near } else { near });
            alike((0..4).map(|k| (towards(k), 1.0 / 24.0)).collect())
        }
        ElementKind::Wedge6 => alike(over_triangle(&LINE2)),
        ElementKind::Wedge15 => [over_triangle(&LINE3), over_triangle(&LINE2)],
        ElementKind::Hexahedron20 | ElementKind::Hexahedron27 => [cube(&LINE3), cube(&LINE2)],
        _ => alike(cube(&LINE2)),
    }
}

/// For each of `places` weights of values at `points`: the polynomials of first order of the corners, fitted by least squares; linear ones
/// through fewer points than corners, a constant through one.
fn carried_over(kind: ElementKind, points: &[[f64; 3]], places: &[[f64; 3]]) -> Vec<Vec<f64>> {
    let of_first_order = match kind.corner_count() {
        6 => ElementKind::Wedge6,
        8 if points.len() >= 8 => ElementKind::Hexahedron8,
        _ => ElementKind::Tetrahedron4,
    };
    let basis =
        if points.len() == 1 { vec![[0; 3]] } else { monomials(|monomial| spans(of_first_order, monomial)) };
    let at_points = vandermonde(points, &basis);
    let Some(inverse) = (at_points.transpose() * &at_points).try_inverse() else {
        unreachable!("the points of all kinds determine a polynomial of first order")
    };
    let weights = vandermonde(places, &basis) * inverse * at_points.transpose();
    weights.row_iter().map(|row| row.iter().copied().collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The gradients are those of all monomials that the kind spans, from values at the nodes.
    #[test]
    fn gradients_reproduce_the_polynomials_of_the_kind() {
        for kind in ElementKind::SOLIDS {
            let (reference, nodes) = (Reference::of(kind, false), nodes(kind));
            let monomials = monomials(|monomial| spans(kind, monomial));
            assert_eq!(monomials.len(), kind.node_count(), "{kind:?}");
            let [distortion, dilatation] = rules(kind);
            let known = reference.distortion.gradients.iter().chain(&reference.dilatation.gradients);
            for ((point, _), gradients) in distortion.iter().chain(&dilatation).zip(known) {
                for monomial in &monomials {
                    let sum: Vector3<f64> = gradients
                        .iter()
                        .zip(&nodes)
                        .map(|(gradient, node)| gradient * value(monomial, node))
                        .sum();
                    for axis in 0..3 {
                        let exact = derivative(monomial, axis, point);
                        assert!(
                            (sum[axis] - exact).abs() < 1e-14,
                            "{kind:?} {monomial:?} {axis}: {}",
                            sum[axis]
                        );
                    }
                }
            }
        }
    }

    /// The rules are exact as far as the mass of a linear element, or the stiffness of a straight quadratic one, needs them to be.
    #[test]
    fn points_integrate_polynomials() {
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        let symmetric = |n: i32| if n % 2 == 0 { 2.0 / f64::from(n + 1) } else { 0.0 };
        let simplex = |powers: &[i32]| {
            let (sum, count) = (powers.iter().sum::<i32>(), powers.len() as i32);
            powers.iter().map(|&n| factorial(n)).product::<f64>() / factorial(sum + count)
        };
        for kind in ElementKind::SOLIDS {
            let degree = match kind {
                ElementKind::Tetrahedron4 => 1,
                ElementKind::Hexahedron8 | ElementKind::Hexahedron20 | ElementKind::Hexahedron27 => 3,
                _ => 2,
            };
            for (rule, monomial) in rules(kind).iter().flat_map(|rule| {
                monomials(|monomial| monomial.iter().sum::<i32>() <= degree)
                    .into_iter()
                    .map(move |own| (rule, own))
            }) {
                let [a, b, c] = monomial;
                let exact = match kind.corner_count() {
                    4 => simplex(&[a, b, c]),
                    6 => simplex(&[a, b]) * symmetric(c),
                    _ => symmetric(a) * symmetric(b) * symmetric(c),
                };
                let sum: f64 = rule.iter().map(|(x, w)| w * value(&monomial, x)).sum();
                assert!((sum - exact).abs() < 4e-15, "{kind:?} {monomial:?}: {sum} {exact}");
            }
        }
    }

    /// What the first order of the corners spans is found again at the nodes; a constant from a single point.
    #[test]
    fn extrapolation_is_exact_for_fields_of_first_order() {
        for kind in ElementKind::SOLIDS.into_iter().filter(|&kind| kind != ElementKind::Tetrahedron4) {
            let f = |[x, y, z]: &[f64; 3]| {
                let linear = 1.0 + 2.0 * x - y + 0.5 * z;
                match kind.corner_count() {
                    4 => linear,
                    6 => linear + x * z - 3.0 * y * z,
                    _ => linear + x * y - 3.0 * y * z + 0.7 * x * y * z,
                }
            };
            let at = |rule: &Rule| rule.iter().map(|&(x, _)| x).collect::<Vec<_>>();
            let [points, of_pressure] = rules(kind).each_ref().map(at);
            let Reference { extrapolation, pressure, .. } = Reference::of(kind, false);
            for (places, weights, from) in
                [(nodes(kind), extrapolation, &points), (points.clone(), pressure, &of_pressure)]
            {
                for (place, weights) in places.iter().zip(weights) {
                    let value: f64 = weights.iter().zip(from).map(|(weight, point)| weight * f(point)).sum();
                    assert!((value - f(place)).abs() < 2e-14, "{kind:?}: {value}");
                }
            }
        }
        assert_eq!(Reference::of(ElementKind::Tetrahedron4, false).extrapolation, vec![vec![1.0]; 4]);
    }
}
