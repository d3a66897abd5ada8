//! Integration points: slave faces cut along the edges of the master facets that lie over them.
//!
//! What a master facet carries is a polynomial on it, with kinks at its edges. So each slave face is cut, seen along its normal, into
//! pieces that lie over one facet each, and each piece has points of its own. Where the points lie follows from the positions, and
//! what they integrate does not change with them to the order of the rule: they are held while differentiating.

use super::carried::carried;
use super::quadratic::MOST_NODES;
use crate::surface::{Shape, SurfaceIndex};
use crate::vector::Vector3;
use crate::{Mode, Point};

/// Cosine of the angle between the normals of a face and of a facet that lie over one another, at most.
const OPPOSITE: f64 = -0.1;
/// A quadrilateral becomes a triangle as its smallest corner goes from this part of its area to nothing.
const SLENDER: f64 = 0.1;
/// Of two corners the later one is smaller only below this part of the other: rounding does not decide between equal ones.
const ALMOST: f64 = 0.99;
/// A corner is reflex if it turns by more than this part of what the edges at it span.
const REFLEX: f64 = 1e-9;
/// Pieces smaller than this part of the face are rounding.
const SMALLEST: f64 = 1e-12;

/// How many points a piece has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FaceRule {
    /// Three on a triangle, four on a quadrilateral: exact for uniform pressures on plane parallelograms and triangles.
    #[default]
    Second,
    /// Six on a triangle, nine on a quadrilateral: exact for products of two linear pressures, too.
    Fourth,
}

impl FaceRule {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Second, Self::Fourth];

    /// The degree of the polynomials that it integrates.
    pub const fn degree(self) -> usize {
        match self {
            Self::Second => 2,
            Self::Fourth => 4,
        }
    }
}

/// A point of a slave face over a master facet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacePoint {
    /// The facet that carries its force.
    pub facet: u32,
    /// Its natural coordinates on the face.
    pub natural: [f64; 2],
    /// Its area in the first configuration, length².
    pub weight: f64,
    /// What each node of the face, or of the face of second order that it is a part of, has of the point's force.
    pub functions: [f64; MOST_NODES],
}

type Polygon = Vec<[f64; 2]>;

/// Memory from one face to the next.
#[derive(Clone, Debug, Default)]
pub struct CutScratch {
    near: Vec<u32>,
    piece: Polygon,
    clipped: Polygon,
    /// The facets over a face.
    layers: Vec<Layer>,
}

/// A facet over a face.
#[derive(Clone, Debug)]
struct Layer {
    facet: u32,
    /// As it is seen.
    over: Polygon,
    /// The box around that.
    bounds: [[f64; 2]; 2],
    /// How far away it may be.
    limit: f64,
    /// How deep the face's points may lie below it; `None` if it looks the way the face does.
    deepest: Option<f64>,
}

/// A face seen along its normal.
struct View {
    origin: Vector3,
    axes: [Vector3; 2],
    normal: Vector3,
}

impl View {
    fn of(face: &Shape) -> Option<Self> {
        let corners = face.corners();
        let normal = face.normal();
        let first = (corners[1] - corners[0]) - normal * normal.dot(&(corners[1] - corners[0]));
        let first = first.try_normalize().filter(Vector3::is_finite)?;
        (normal != Vector3::zeros()).then(|| Self {
            origin: corners[0],
            axes: [first, normal.cross(&first)],
            normal,
        })
    }

    fn seen(&self, x: Vector3) -> [f64; 2] {
        self.axes.map(|axis| axis.dot(&(x - self.origin)))
    }

    fn point(&self, [a, b]: [f64; 2]) -> Vector3 {
        self.origin + self.axes[0] * a + self.axes[1] * b
    }
}

/// What a face is cut with.
#[derive(Clone, Copy)]
pub struct Cutting<'a> {
    /// Of the piece over a facet.
    pub rule: &'a dyn Fn(u32) -> FaceRule,
    /// The largest distance of any facet, length, and that of each.
    pub limit: f64,
    pub limit_of: &'a dyn Fn(u32) -> f64,
    /// How deep the face's points may lie below a facet, length; `None` if they do not touch it at all.
    pub depth: &'a dyn Fn(u32) -> Option<f64>,
    /// Whether facets that look the way the face does hide what lies behind them. Not where the face is a facet itself.
    pub hides_behind: bool,
}

/// The points of a face, appended to `points`. `first`: the face in the first configuration; `functions`: what its nodes have of a force
/// at a place, if it can be found. Returns the number of points whose place was not found on their face or facet.
pub fn cut(
    face: &Shape,
    first: &Shape,
    functions: impl Fn([f64; 2]) -> Option<[f64; MOST_NODES]>,
    index: &SurfaceIndex<'_>,
    Cutting { rule, limit, limit_of, depth, hides_behind }: Cutting<'_>,
    scratch: &mut CutScratch,
    points: &mut Vec<FacePoint>,
) -> usize {
    let Some(view) = View::of(face) else { return 0 };
    let corners: Polygon = face.corners().iter().map(|&x| view.seen(x)).collect();
    let own = area(&corners);
    // What the face sweeps along its normal.
    let [mut lower, mut upper] = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for x in corners.iter().map(|&corner| view.point(corner)) {
        for (axis, (x, way)) in Point::from(x).into_iter().zip(Point::from(view.normal * limit)).enumerate() {
            lower[axis] = lower[axis].min(x - way.abs());
            upper[axis] = upper[axis].max(x + way.abs());
        }
    }
    let parts = convex_parts(corners);
    let CutScratch { near, piece, clipped, layers } = scratch;
    layers.clear();
    index.facets_near(lower, upper, near);
    let start = points.len();
    let (mut seen, mut unplaced) = (Vec::new(), Vec::new());
    for &facet in near.iter() {
        let cosine = index.normals()[facet as usize].dot(&view.normal);
        let faces_it = cosine <= OPPOSITE;
        let deepest = if faces_it { depth(facet) } else { None };
        let hides = hides_behind && cosine >= -OPPOSITE;
        if deepest.is_none() && !hides {
            continue;
        }
        let (shape, own_limit) = (index.shape(facet), limit_of(facet));
        // It hides what any facet behind it could touch.
        let reach = if deepest.is_some() { own_limit } else { limit };
        let heights = || shape.corners().iter().map(|&x| view.normal.dot(&(x - view.origin)));
        if heights().all(|height| height > reach) || heights().all(|height| height < -reach) {
            continue;
        }
        let mut over: Polygon = shape.corners().iter().map(|&x| view.seen(x)).collect();
        if faces_it {
            // From outside its own surface it runs the other way round.
            over.reverse();
        }
        for over in convex_parts(over) {
            let places = places_under(&over, &parts, (rule(facet), SMALLEST * own), (piece, clipped));
            if places.is_empty() {
                continue;
            }
            layers.push(Layer { facet, bounds: bounds(&over), over, limit: own_limit, deepest });
            let Some(deepest) = deepest else { continue };
            // Corners in one line leave triangles without an area.
            for (place, weight) in places.into_iter().filter(|&(_, weight)| weight > 0.0) {
                let x = view.point(place);
                let height = height_over(&shape, x, view.normal);
                if height.is_some_and(|height| height.abs() > own_limit || height < -deepest) {
                    continue;
                }
                let placed = on_face(face, first, view.normal, (x, weight)).and_then(|(natural, weight)| {
                    Some(FacePoint { facet, natural, weight, functions: functions(natural)? })
                });
                match (placed, height) {
                    (Some(point), Some(height)) => {
                        points.push(point);
                        seen.push((place, height));
                    }
                    _ => unplaced.push((facet, place, height.unwrap_or(f64::INFINITY))),
                }
            }
        }
    }
    if layers.len() > 1 {
        let mut seen = seen.into_iter();
        let all = points.split_off(start);
        let is_first = |point: &FacePoint| {
            seen.next().is_some_and(|at| is_nearest(point.facet, at, layers, index, &view))
        };
        points.extend(all.into_iter().filter(is_first));
        unplaced.retain(|&(facet, place, height)| is_nearest(facet, (place, height), layers, index, &view));
    }
    unplaced.len()
}

/// Points of the parts of a face that lie under a convex polygon, with their areas. Pieces that are not larger than `smallest` have none.
fn places_under(
    over: &[[f64; 2]],
    parts: &[Polygon],
    (rule, smallest): (FaceRule, f64),
    (piece, clipped): (&mut Polygon, &mut Polygon),
) -> Weighted {
    let mut places = Weighted::new();
    for part in parts {
        piece.clone_from(part);
        clip(piece, over, clipped);
        if area(piece) > smallest {
            places.append(&mut rule_on(piece, rule));
        }
    }
    places
}

/// Whether no other facet lies between a point and its facet: where layers of the master lie over one another, the nearest carries.
/// Behind a facet that looks the way the face does there is none that does.
fn is_nearest(
    facet: u32,
    (place, height): ([f64; 2], f64),
    layers: &[Layer],
    index: &SurfaceIndex<'_>,
    view: &View,
) -> bool {
    let is_before = |&Layer { facet: other, ref over, bounds, limit, deepest }: &Layer| {
        let before = |found: f64| match deepest {
            Some(deepest) => {
                let carries = found.abs() <= limit && found >= -deepest;
                carries && (found.abs(), other) < (height.abs(), facet)
            }
            None => found * height > 0.0 && found.abs() < height.abs(),
        };
        let [low, high] = bounds;
        let is_within = (0..2).all(|axis| low[axis] <= place[axis] && place[axis] <= high[axis]);
        other != facet
            && is_within
            && contains(over, place)
            && height_over(&index.shape(other), view.point(place), view.normal).is_some_and(before)
    };
    !layers.iter().any(is_before)
}

/// Where a point with an area as it is seen along the normal is on its face, and its area in the first configuration; nothing where the
/// face is folded.
fn on_face(
    face: &Shape,
    first: &Shape,
    normal: Vector3,
    (x, area): (Vector3, f64),
) -> Option<([f64; 2], f64)> {
    let natural = carried(face, x.into(), normal.into(), Mode::Value)?.natural;
    let seen = face.area_element(natural).dot(&normal);
    let weight = area * first.area_element(natural).norm() / seen;
    (weight.is_finite() && weight > 0.0).then_some((natural, weight))
}

/// How far a facet is from a point along the normal of the point's face: negative where the point lies below the facet.
pub fn height_over(shape: &Shape, x: Vector3, normal: Vector3) -> Option<f64> {
    let over = carried(shape, x.into(), normal.into(), Mode::Value)?;
    Some((shape.point(over.natural) - x).dot(&normal))
}

/// How far behind a facet, against its normal at its middle, the nearest one that looks the other way is; infinite if there is none. Deeper
/// than that nothing is touched through it.
pub fn far_side(index: &SurfaceIndex<'_>, facet: u32) -> f64 {
    let shape = index.shape(facet);
    let Some(view) = View::of(&shape) else { return f64::INFINITY };
    let middle = shape.middle();
    let mut nearest = f64::INFINITY;
    index.for_each_along(middle, view.normal * -1.0, |other| {
        if index.normals()[other as usize].dot(&view.normal) > OPPOSITE {
            return;
        }
        let shape = index.shape(other);
        let mut behind: Polygon = shape.corners().iter().map(|&x| view.seen(x)).collect();
        behind.reverse();
        if convex_parts(behind).iter().any(|part| contains(part, view.seen(middle)))
            && let Some(height) = height_over(&shape, middle, view.normal).filter(|height| *height < 0.0)
        {
            nearest = nearest.min(-height);
        }
    });
    nearest
}

/// The box around a polygon.
fn bounds(polygon: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let start = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    polygon.iter().fold(start, |[[a, b], [c, d]], &[x, y]| [[a.min(x), b.min(y)], [c.max(x), d.max(y)]])
}

/// Whether a point lies in a convex polygon that runs counter-clockwise.
fn contains(polygon: &[[f64; 2]], x: [f64; 2]) -> bool {
    let count = polygon.len();
    (0..count).all(|k| cross(minus(polygon[(k + 1) % count], polygon[k]), minus(x, polygon[k])) >= 0.0)
}

/// A triangle or quadrilateral that runs counter-clockwise, cut at its reflex corner if it has one: clipping needs convex ones.
fn convex_parts(polygon: Polygon) -> Vec<Polygon> {
    let [a, b, c, d] = polygon[..] else { return vec![polygon] };
    let is_reflex = |[before, corner, after]: [[f64; 2]; 3]| {
        let (to, from) = (minus(corner, before), minus(after, corner));
        cross(to, from) < -REFLEX * to[0].hypot(to[1]) * from[0].hypot(from[1])
    };
    if is_reflex([d, a, b]) || is_reflex([b, c, d]) {
        vec![vec![a, b, c], vec![a, c, d]]
    } else if is_reflex([a, b, c]) || is_reflex([c, d, a]) {
        vec![vec![b, c, d], vec![b, d, a]]
    } else {
        vec![polygon]
    }
}

/// Area of a polygon, positive if it runs counter-clockwise.
fn area(polygon: &[[f64; 2]]) -> f64 {
    let Some((&first, rest)) = polygon.split_first() else { return 0.0 };
    rest.windows(2).map(|pair| 0.5 * cross(minus(pair[0], first), minus(pair[1], first))).sum()
}

fn minus([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a - c, b - d]
}

fn cross([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    a * d - b * c
}

/// Cuts off what lies outside a convex polygon that runs counter-clockwise (Sutherland and Hodgman 1974).
fn clip(piece: &mut Polygon, over: &[[f64; 2]], clipped: &mut Polygon) {
    for (k, &from) in over.iter().enumerate() {
        let edge = minus(over[(k + 1) % over.len()], from);
        let inside = |x: [f64; 2]| cross(edge, minus(x, from));
        clipped.clear();
        for (k, &x) in piece.iter().enumerate() {
            let next = piece[(k + 1) % piece.len()];
            let (here, there) = (inside(x), inside(next));
            if here >= 0.0 {
                clipped.push(x);
            }
            if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                let t = here / (here - there);
                clipped.push([x[0] + t * (next[0] - x[0]), x[1] + t * (next[1] - x[1])]);
            }
        }
        std::mem::swap(piece, clipped);
        if piece.len() < 3 {
            piece.clear();
            return;
        }
    }
}

type Weighted = Vec<([f64; 2], f64)>;

/// Points of a convex polygon with their areas. They are continuous where corners appear on an edge or fall together: forces would
/// else jump by the error of the rule whenever edges of faces and facets that lie on one another cross.
fn rule_on(polygon: &[[f64; 2]], rule: FaceRule) -> Weighted {
    let (mut points, mut rest) = (Weighted::new(), polygon.to_vec());
    while rest.len() > 4 {
        let (k, ear) = smallest_ear(&rest);
        triangle(ear, (rule, 1.0), &mut points);
        rest.remove(k);
    }
    if let [a, b, c, d] = rest[..] {
        let (k, ear) = smallest_ear(&rest);
        let share = (area(&ear) / (SLENDER * area(&rest))).clamp(0.0, 1.0);
        if share > 0.0 {
            quadrilateral([a, b, c, d], (rule, share), &mut points);
        }
        if share < 1.0 {
            triangle(ear, (rule, 1.0 - share), &mut points);
            rest.remove(k);
        }
        if let [a, b, c] = rest[..] {
            triangle([a, b, c], (rule, 1.0 - share), &mut points);
        }
    } else if let [a, b, c] = rest[..] {
        triangle([a, b, c], (rule, 1.0), &mut points);
    }
    points
}

/// The corner whose triangle with its neighbours is the smallest, and the triangle. Of almost equal ones the first.
fn smallest_ear(polygon: &[[f64; 2]]) -> (usize, [[f64; 2]; 3]) {
    let count = polygon.len();
    let ear = |k: usize| [polygon[(k + count - 1) % count], polygon[k], polygon[(k + 1) % count]];
    let (mut best, mut least) = (0, area(&ear(0)));
    for k in 1..count {
        let own = area(&ear(k));
        if own < ALMOST * least {
            (best, least) = (k, own);
        }
    }
    (best, ear(best))
}

/// The rules of degrees 2 and 4 with three and six points (Dunavant 1985), in closed form: area coordinates and weights.
fn triangle([a, b, c]: [[f64; 2]; 3], (rule, factor): (FaceRule, f64), points: &mut Weighted) {
    let area = 0.5 * factor * cross(minus(b, a), minus(c, a));
    let mut orbit = |x: f64, weight: f64| {
        let y = 1.0 - 2.0 * x;
        for [p, q, r] in [[y, x, x], [x, y, x], [x, x, y]] {
            let place = [0, 1].map(|axis| p * a[axis] + q * b[axis] + r * c[axis]);
            points.push((place, weight * area));
        }
    };
    match rule {
        FaceRule::Second => orbit(1.0 / 6.0, 1.0 / 3.0),
        FaceRule::Fourth => {
            let ten = 10.0_f64.sqrt();
            let spread = (38.0 - 44.0 * 0.4_f64.sqrt()).sqrt();
            let share = (213_125.0 - 53_320.0 * ten).sqrt();
            orbit((8.0 - ten + spread) / 18.0, (620.0 + share) / 3720.0);
            orbit((8.0 - ten - spread) / 18.0, (620.0 - share) / 3720.0);
        }
    }
}

/// Gauss points, two or three each way.
fn quadrilateral(corners: [[f64; 2]; 4], (rule, factor): (FaceRule, f64), points: &mut Weighted) {
    let [two, three] = [(1.0_f64 / 3.0).sqrt(), 0.6_f64.sqrt()];
    let gauss: &[(f64, f64)] = match rule {
        FaceRule::Second => &[(-two, 1.0), (two, 1.0)],
        FaceRule::Fourth => &[(-three, 5.0 / 9.0), (0.0, 8.0 / 9.0), (three, 5.0 / 9.0)],
    };
    let shape = Shape::Quadrilateral(corners.map(|[x, y]| Vector3::from([x, y, 0.0])));
    for &(xi, first) in gauss {
        for &(eta, second) in gauss {
            let [x, y, _] = Point::from(shape.point([xi, eta]));
            points.push(([x, y], factor * first * second * shape.area_element([xi, eta]).norm()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Facet, MasterSurface};

    fn nothing(_: [f64; 2]) -> Option<[f64; MOST_NODES]> {
        Some([0.0; MOST_NODES])
    }

    #[test]
    fn rules_integrate_their_degree() {
        let pentagon = [[0.0, 0.0], [1.0, -0.2], [1.4, 0.6], [0.7, 1.2], [-0.1, 0.8]];
        // ∫ xᵃ yᵇ by splitting into triangles and a rule of higher degree: Gauss points on each, collapsed.
        let exact = |a: i32, b: i32| {
            let gauss = [
                (-0.906_179_845_938_664, 0.236_926_885_056_189),
                (-0.538_469_310_105_683, 0.478_628_670_499_366),
                (0.0, 0.568_888_888_888_889),
                (0.538_469_310_105_683, 0.478_628_670_499_366),
                (0.906_179_845_938_664, 0.236_926_885_056_189),
            ];
            let mut sum = 0.0;
            for k in 1..4 {
                let (p, q, r) = (pentagon[0], pentagon[k], pentagon[k + 1]);
                for (s, first) in gauss {
                    for (t, second) in gauss {
                        let (u, v) = (0.5 * (1.0 + s), 0.25 * (1.0 - s) * (1.0 + t));
                        let x = [0, 1].map(|i| p[i] + u * (q[i] - p[i]) + v * (r[i] - p[i]));
                        let area = cross(minus(q, p), minus(r, p)) * 0.125 * (1.0 - s);
                        sum += first * second * area * x[0].powi(a) * x[1].powi(b);
                    }
                }
            }
            sum
        };
        for rule in FaceRule::ALL {
            for a in 0..=rule.degree() as i32 {
                for b in 0..=rule.degree() as i32 - a {
                    let points = rule_on(&pentagon, rule);
                    let sum: f64 = points.iter().map(|(x, w)| w * x[0].powi(a) * x[1].powi(b)).sum();
                    assert!((sum - exact(a, b)).abs() < 1e-13, "{rule:?} {a} {b}: {sum} {}", exact(a, b));
                }
            }
        }
    }

    /// A corner on an edge, or close to another one, changes what is integrated by as much as it changes the polygon.
    #[test]
    fn points_are_continuous_where_corners_appear() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        // Of a degree that the rule does not integrate.
        let integral = |polygon: &[[f64; 2]], rule| -> f64 {
            rule_on(polygon, rule).iter().map(|(x, w)| w * (3.0 * x[0] + 2.0 * x[1]).powi(6)).sum()
        };
        let tiny = 1e-7;
        let on_edge = [square[0], square[1], [1.0 + tiny, 0.4], square[2], square[3]];
        let cut_off = [square[0], [1.0 - tiny, 0.0], [1.0, tiny], square[2], square[3]];
        let triangle = [square[0], square[1], square[2]];
        let almost = [square[0], square[1], square[2], [1.0 - tiny, 1.0]];
        for rule in FaceRule::ALL {
            for (one, other) in [(&square[..], &on_edge[..]), (&square, &cut_off), (&triangle, &almost)] {
                let [one, other] = [one, other].map(|polygon| integral(polygon, rule));
                assert!((one - other).abs() < 1e-5 * one.abs(), "{one} {other}");
            }
            let split = integral(&triangle, rule) + integral(&[square[0], square[2], square[3]], rule);
            let jump = (integral(&square, rule) - split).abs() / split.abs();
            assert!(jump > 1e-4, "elsewhere rules differ by what they do not integrate: {jump:e}");
        }
    }

    #[test]
    fn polygons_are_cut_to_what_they_share() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let shared = |over: &[[f64; 2]]| {
            let mut piece = square.to_vec();
            clip(&mut piece, over, &mut Vec::new());
            area(&piece)
        };
        assert_eq!(shared(&square), 1.0);
        assert_eq!(shared(&square.map(|[x, y]| [x + 0.5, y + 0.25])), 0.375);
        assert_eq!(shared(&square.map(|[x, y]| [x + 1.0, y])), 0.0);
        assert_eq!(shared(&square.map(|[x, y]| [x + 2.0, y])), 0.0);
        assert_eq!(shared(&[[0.5, -0.5], [1.5, 0.5], [0.5, 1.5], [-0.5, 0.5]]), 1.0);
        assert_eq!(shared(&[[0.5, 0.0], [1.0, 0.5], [0.5, 1.0], [0.0, 0.5]]), 0.5);
    }

    #[test]
    fn a_quadrilateral_is_cut_at_its_reflex_corner() {
        let dart = [[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]];
        for turn in 0..4 {
            let mut corners = dart.to_vec();
            corners.rotate_left(turn);
            let parts = convex_parts(corners);
            assert_eq!(parts.iter().map(|part| area(part)).collect::<Vec<_>>(), [2.0; 2], "{parts:?}");
            assert!(parts.iter().all(|part| contains(part, [0.3; 2]) || contains(part, [0.2, 0.1])));
        }
        let square = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(convex_parts(square.clone()), [square]);
        let flat = vec![[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.0, 1.0]];
        assert_eq!(convex_parts(flat.clone()), [flat], "a straight corner is none");
    }

    /// Faces over a grid of other facets: all of their area is found, each part over its own facet.
    #[test]
    fn the_pieces_of_a_face_make_up_its_area() {
        let grid: Vec<Point> =
            (0..16).map(|k| [f64::from(k % 4) * 0.7, f64::from(k / 4) * 0.7, 0.0]).collect();
        let facets = (0..9).map(|k| k % 3 + 4 * (k / 3));
        let facets = facets.map(|k| Facet::Quadrilateral([k, k + 1, k + 5, k + 4])).collect();
        let surface = MasterSurface::new(&grid, facets).unwrap();
        let index = surface.at(&grid).unwrap();
        // Seen from its own outside, below, it runs the other way.
        let corners = [[0.2, 0.3, 0.1], [0.3, 1.7, 0.1], [1.9, 1.8, 0.1], [1.6, 0.2, 0.1]].map(Vector3::from);
        let face = Shape::Quadrilateral(corners);
        for rule in FaceRule::ALL {
            let mut points = Vec::new();
            let anywhere = |_| Some(f64::INFINITY);
            let everywhere = |_| rule;
            let within = |limit, limit_of| Cutting {
                rule: &everywhere,
                limit,
                limit_of,
                depth: &anywhere,
                hides_behind: true,
            };
            let (scratch, wide) = (&mut CutScratch::default(), within(0.5, &|_| 0.5));
            cut(&face, &face, nothing, &index, wide, scratch, &mut points);
            let sum: f64 = points.iter().map(|point| point.weight).sum();
            assert!((sum - face.area_vector().norm()).abs() < 1e-12, "{sum}");
            for point in &points {
                let x = Point::from(face.point(point.natural));
                let cell = |x: f64| (x / 0.7).floor() as u32;
                assert_eq!(point.facet, cell(x[0]) + 3 * cell(x[1]));
            }
            let mut none = Vec::new();
            cut(&face, &face, nothing, &index, within(0.05, &|_| 0.05), scratch, &mut none);
            assert!(none.is_empty(), "beyond the limit");
            let of_one = |facet| if facet == 4 { 0.5 } else { 0.05 };
            cut(&face, &face, nothing, &index, within(0.5, &of_one), scratch, &mut none);
            assert!(!none.is_empty() && none.iter().all(|point| point.facet == 4), "each has its own");
        }
    }
}
