//! The places of many slaves, one per lane of the machine's vectors.
//!
//! What a lane gets does not depend on the others, nor on nodes that carry no weight: these add zeros to its sums. Lanes take the
//! steps that nearly all slaves need. Where they do not end, [`MaterialPlace::iterate`] begins again, number by number.

use std::marker::PhantomData;
use std::ops::Range;

use diffuse_contact_kernels::support::{KernelSet, Lane, Vector, WithLanes};

use super::{CLOSE, CONTRACTION, MaterialDomain, MaterialPlace, ROUNDING, STALLED};
use crate::frame::{LINE_TOLERANCE, THICKNESS_TOLERANCE};
use crate::generated::with_kernels;
use crate::vector::Vector3;
use crate::{ElementError, Frame, Point, Weight};

/// Evaluations of a lane after the first two.
const MOST_STEPS: usize = 12;
/// Steps to a normal.
const MOST_QUOTIENTS: usize = 8;
/// Square of the sine that a normal turns by, below which it is exact after the turn: the next error goes with the third power.
const SAME_DIRECTION: f64 = 1e-14;
/// Numbers of a node: its position and its first position, both from those of the nearest one, and its metric.
const VALUES: usize = 12;
/// What fills up lanes with fewer nodes: a node whose first position is out of every domain.
const NO_NODE: [f64; VALUES] = [0.0, 0.0, 0.0, 1e200, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0];

/// A slave whose place is sought.
#[derive(Clone, Debug)]
pub struct Sought {
    pub slave: Point,
    /// Towards its side.
    pub outward: Point,
    /// Its masters.
    pub range: Range<usize>,
}

/// Memory from one search to the next.
#[derive(Clone, Debug, Default)]
pub struct SearchScratch {
    /// Slaves by their number of masters.
    order: Vec<(usize, usize)>,
    numbers: Vec<f64>,
    weights: Vec<f64>,
}

/// The places of slaves over masters with these domains.
pub fn places(
    slaves: &[Sought],
    (masters, domains): (&[Point], &[MaterialDomain]),
    weight: Weight,
    scratch: &mut SearchScratch,
    found: &mut Vec<Result<MaterialPlace, ElementError>>,
) {
    let SearchScratch { order, numbers, weights } = scratch;
    order.clear();
    order.extend(slaves.iter().enumerate().map(|(k, slave)| (slave.range.len(), k)));
    order.sort_unstable();
    found.clear();
    found.resize(slaves.len(), Err(ElementError::TooFewNodes { found: 0, needed: 3 }));
    let without = order.partition_point(|&(count, _)| count == 0);
    let order = &order[without..];
    let nodes = (masters, domains);
    with_kernels!(weight, K => {
        K::best_isa().run(Search::<K> { slaves, order, nodes, numbers, found, kernels: PhantomData });
    });
    for &(_, k) in order {
        if found[k].is_err() {
            let Sought { slave, outward, range } = &slaves[k];
            let (masters, domains) = (&masters[range.clone()], &domains[range.clone()]);
            let fitting = |r| weight.fitting(r);
            found[k] = MaterialPlace::iterate(*slave, masters, domains, weights, fitting, *outward);
        }
    }
}

struct Search<'a, K> {
    slaves: &'a [Sought],
    order: &'a [(usize, usize)],
    nodes: (&'a [Point], &'a [MaterialDomain]),
    numbers: &'a mut Vec<f64>,
    /// What is not found stays an error.
    found: &'a mut [Result<MaterialPlace, ElementError>],
    kernels: PhantomData<K>,
}

impl<K: KernelSet> WithLanes for Search<'_, K> {
    type Output = ();

    #[inline(always)]
    fn run<T: Vector>(self) {
        let Self { slaves, order, nodes, numbers, found, .. } = self;
        for group in order.chunks(T::WIDTH) {
            let most = group[group.len() - 1].0;
            let size = VALUES * T::WIDTH;
            if numbers.len() < most * size {
                numbers.resize(most * size, 0.0);
            }
            let mut nearest = [0; MOST_LANES];
            let numbers = &mut numbers[..most * size];
            for lane in 0..T::WIDTH {
                // The last slave also fills the lanes beyond.
                let slave = &slaves[group[lane.min(group.len() - 1)].1];
                nearest[lane] = fill_lane(slave, nodes, numbers, (lane, T::WIDTH));
            }
            let lanes = Lanes::<T> {
                numbers,
                near: splits(|lane| nodes.1[nearest[lane]].metric),
                slave: splits(|lane| {
                    let slave = &slaves[group[lane.min(group.len() - 1)].1];
                    difference(slave.slave, nodes.0[nearest[lane]])
                }),
            };
            let searched = lanes.search::<K>();
            for (lane, &(_, k)) in group.iter().enumerate() {
                if searched.is_found.lane(lane) > 0.5 {
                    let of = |vector: &[T; 3]| {
                        Vector3::from([vector[0].lane(lane), vector[1].lane(lane), vector[2].lane(lane)])
                    };
                    let (position, first) = (nodes.0[nearest[lane]], nodes.1[nearest[lane]].position);
                    let origin = Vector3::from(position) + of(&searched.mean);
                    let place = (Vector3::from(first) + of(&searched.place)).into();
                    found[k] = Frame::of_average_plane(origin, of(&searched.normal), slaves[k].outward)
                        .map(|frame| MaterialPlace { place, frame, steps: searched.evaluations });
                }
            }
        }
    }
}

/// Numbers in the widest vector.
const MOST_LANES: usize = 8;

/// Writes the nodes of a slave into its lane, and returns which of all is the nearest.
fn fill_lane(
    Sought { slave, range, .. }: &Sought,
    (masters, domains): (&[Point], &[MaterialDomain]),
    numbers: &mut [f64],
    (lane, width): (usize, usize),
) -> usize {
    let (mut nearest, mut least) = (range.start, f64::INFINITY);
    for k in range.clone() {
        let [x, y, z] = difference(masters[k], *slave);
        let square = x * x + y * y + z * z;
        if square < least {
            (nearest, least) = (k, square);
        }
    }
    let (master, first) = (masters[nearest], domains[nearest].position);
    for (place, node) in numbers.chunks_exact_mut(VALUES * width).enumerate() {
        let mut values = NO_NODE;
        if place < range.len() {
            let k = range.start + place;
            let ([x, y, z], [a, b, c]) =
                (difference(masters[k], master), difference(domains[k].position, first));
            let [xx, xy, xz, yy, yz, zz] = domains[k].metric;
            values = [x, y, z, a, b, c, xx, xy, xz, yy, yz, zz];
        }
        for (value, number) in values.into_iter().enumerate() {
            node[width * value + lane] = number;
        }
    }
    nearest
}

#[inline(always)]
fn difference(x: Point, y: Point) -> Point {
    [x[0] - y[0], x[1] - y[1], x[2] - y[2]]
}

/// Numbers of each lane as vectors.
#[inline(always)]
fn splits<T: Lane, const N: usize>(of_lane: impl Fn(usize) -> [f64; N]) -> [T; N] {
    let mut vectors = [T::ZERO; N];
    for k in 0..N {
        vectors[k] = T::from_fn(|lane| of_lane(lane)[k]);
    }
    vectors
}

/// Slaves side by side. All places and positions are seen from their nearest nodes.
struct Lanes<'a, T> {
    /// Of each node.
    numbers: &'a [f64],
    /// The metric of the nearest node.
    near: [T; 6],
    slave: [T; 3],
}

/// What was found.
struct Searched<T> {
    /// 1, or 0.
    is_found: T,
    place: [T; 3],
    normal: [T; 3],
    mean: [T; 3],
    evaluations: usize,
}

/// The equations of a place.
struct Evaluated<T> {
    /// From the place to the affine fit at the slave.
    step: [T; 3],
    /// Its length in the metric of the nearest node; NaN without an average plane.
    deviation: T,
    normal: [T; 3],
    /// Of the weighted nodes.
    mean: [T; 3],
}

/// Σ ω, Σ ω x, Σ ω x xᵀ, Σ ω (X − Ξ), Σ ω (X − Ξ) xᵀ
struct Sums<T> {
    total: T,
    first: [T; 3],
    /// xx, xy, xz, yy, yz, zz
    second: [T; 6],
    material: [T; 3],
    /// One for each axis of x.
    products: [[T; 3]; 3],
}

/// Writes out what maps over arrays would say, which are not always inlined.
macro_rules! each {
    ($k:ident => $value:expr) => {
        [
            {
                let $k = 0;
                $value
            },
            {
                let $k = 1;
                $value
            },
            {
                let $k = 2;
                $value
            },
        ]
    };
}

impl<T: Vector> Lanes<'_, T> {
    #[inline(always)]
    fn search<K: KernelSet>(&self) -> Searched<T> {
        let zero = [T::ZERO; 3];
        // The first step is taken with the nodes close to the nearest one, as number by number.
        let first = self.evaluate::<K, true>(zero, None);
        let is_step = T::select_less(first.deviation, T::splat(f64::INFINITY), T::ONE, T::ZERO);
        let start = choose(is_step, first.step, zero);
        let mut now = self.evaluate::<K, false>(start, None);
        let mut place = start;
        let mut inverse = [T::ONE, T::ZERO, T::ZERO, T::ZERO, T::ONE, T::ZERO, T::ZERO, T::ZERO, T::ONE];
        let converged = T::splat(ROUNDING);
        let mut is_found = T::select_less(now.deviation, converged, T::ONE, T::ZERO);
        let mut is_open = T::select_less(now.deviation, converged, T::ZERO, T::ONE);
        let mut evaluations = 2;
        while evaluations < MOST_STEPS + 2 && !T::all_less(is_open, T::splat(0.5)) {
            evaluations += 1;
            let moved = each!(i => dot(
                [inverse[3 * i], inverse[3 * i + 1], inverse[3 * i + 2]],
                now.step,
            ));
            let next = each!(i => place[i] + moved[i]);
            let after = self.evaluate::<K, false>(next, Some(now.normal));
            // Accepted where it is much closer; else the place stays, as an answer if it is close.
            let bound = now.deviation * T::splat(CONTRACTION);
            let is_closer = T::select_less(after.deviation, bound, is_open, T::ZERO);
            let is_close = T::select_less(now.deviation, T::splat(STALLED), is_open, T::ZERO);
            is_found = T::select_less(T::splat(0.5), is_close - is_closer, T::ONE, is_found);
            let is_root = T::select_less(after.deviation, converged, is_closer, T::ZERO);
            is_found = T::select_less(T::splat(0.5), is_root, T::ONE, is_found);
            is_open = is_closer - is_root;
            // Broyden's correction of what becomes the inverse of the derivative, up to its sign.
            let change = each!(i => after.step[i] - now.step[i]);
            let change = each!(i => dot(
                [inverse[3 * i], inverse[3 * i + 1], inverse[3 * i + 2]],
                change,
            ));
            let row = each!(j => dot([inverse[j], inverse[3 + j], inverse[6 + j]], moved));
            let divisor = dot(moved, change);
            let correction = each!(i => (moved[i] + change[i]).div_or_zero(divisor));
            for i in 0..3 {
                for j in 0..3 {
                    inverse[3 * i + j] = correction[i].neg_mul_add(row[j], inverse[3 * i + j]);
                }
            }
            place = choose(is_closer, next, place);
            now = Evaluated {
                step: choose(is_closer, after.step, now.step),
                deviation: T::select_less(T::splat(0.5), is_closer, after.deviation, now.deviation),
                normal: choose(is_closer, after.normal, now.normal),
                mean: choose(is_closer, after.mean, now.mean),
            };
        }
        Searched { is_found, place, normal: now.normal, mean: now.mean, evaluations }
    }

    /// `IS_START`: with the weights of the nodes close to the nearest one.
    #[inline(always)]
    fn evaluate<K: KernelSet, const IS_START: bool>(
        &self,
        place: [T; 3],
        near: Option<[T; 3]>,
    ) -> Evaluated<T> {
        let sums = self.sums::<K, IS_START>(place);
        let mean = each!(i => sums.first[i] / sums.total);
        let [xx, xy, xz, yy, yz, zz] = sums.second;
        let [x, y, z] = sums.first;
        let scatter = [
            x.neg_mul_add(mean[0], xx),
            x.neg_mul_add(mean[1], xy),
            x.neg_mul_add(mean[2], xz),
            y.neg_mul_add(mean[1], yy),
            y.neg_mul_add(mean[2], yz),
            z.neg_mul_add(mean[2], zz),
        ];
        let (normal, is_plane) = smallest_direction(scatter, near);
        let step = self.affine_step(&sums, normal);
        let deviation = square(self.near, step).sqrt();
        let deviation = T::select_less(T::splat(0.5), is_plane, deviation, T::splat(f64::NAN));
        Evaluated { step, deviation, normal, mean }
    }

    #[inline(always)]
    fn sums<K: KernelSet, const IS_START: bool>(&self, place: [T; 3]) -> Sums<T> {
        let zero = [T::ZERO; 3];
        let mut sums =
            Sums { total: T::ZERO, first: zero, second: [T::ZERO; 6], material: zero, products: [zero; 3] };
        for node in self.numbers.chunks_exact(VALUES * T::WIDTH) {
            macro_rules! load {
                ($($k:literal),*) => { [$(T::load(node, $k * T::WIDTH)),*] };
            }
            let x: [T; 3] = load!(0, 1, 2);
            let first: [T; 3] = load!(3, 4, 5);
            let metric: [T; 6] = load!(6, 7, 8, 9, 10, 11);
            let material = each!(i => first[i] - place[i]);
            let mut r = square(metric, material);
            if IS_START {
                let from_near = square(self.near, material);
                r = T::select_less(from_near, r, r, from_near);
            }
            let mut r = r.sqrt();
            if IS_START {
                r = r * T::splat(CLOSE);
            }
            let weight = K::fitting_weight(r);
            let weighted = each!(i => weight * x[i]);
            sums.total = sums.total + weight;
            sums.first = each!(i => sums.first[i] + weighted[i]);
            let [xx, xy, xz, yy, yz, zz] = sums.second;
            sums.second = [
                weighted[0].mul_add(x[0], xx),
                weighted[0].mul_add(x[1], xy),
                weighted[0].mul_add(x[2], xz),
                weighted[1].mul_add(x[1], yy),
                weighted[1].mul_add(x[2], yz),
                weighted[2].mul_add(x[2], zz),
            ];
            sums.material = each!(i => weight.mul_add(material[i], sums.material[i]));
            sums.products =
                each!(axis => each!(i => weighted[axis].mul_add(material[i], sums.products[axis][i])));
        }
        sums
    }

    /// The affine fit of the nodes' first positions by their positions in the plane, at the slave.
    #[inline(always)]
    fn affine_step(&self, sums: &Sums<T>, normal: [T; 3]) -> [T; 3] {
        let [t1, t2] = tangents(normal);
        let [s1, s2] = [dot(t1, self.slave), dot(t2, self.slave)];
        let [xx, xy, xz, yy, yz, zz] = sums.second;
        let images = [
            [dot([xx, xy, xz], t1), dot([xy, yy, yz], t1), dot([xz, yz, zz], t1)],
            [dot([xx, xy, xz], t2), dot([xy, yy, yz], t2), dot([xz, yz, zz], t2)],
        ];
        let [x1, x2] = [dot(t1, sums.first), dot(t2, sums.first)];
        // Offsets from the slave, in the plane.
        let [a, b] = [sums.total.neg_mul_add(s1, x1), sums.total.neg_mul_add(s2, x2)];
        // Σ ω (x₁ − s₁)(x₂ − s₂) = Σ ω x₁ x₂ − s₂ Σ ω x₁ − s₁ Σ ω (x₂ − s₂)
        let aa = s1.neg_mul_add(a, s1.neg_mul_add(x1, dot(t1, images[0])));
        let ab = s1.neg_mul_add(b, s2.neg_mul_add(x1, dot(t2, images[0])));
        let bb = s2.neg_mul_add(b, s2.neg_mul_add(x2, dot(t2, images[1])));
        let determinant = aa * bb - ab * ab;
        let beta = [(ab * b - bb * a) / determinant, (ab * a - aa * b) / determinant];
        let divisor = beta[1].mul_add(b, beta[0].mul_add(a, sums.total));
        // Σ ω (X − Ξ) (β·(x − s)) with β·x = (β₁ t₁ + β₂ t₂)·x
        let along = each!(i => beta[1].mul_add(t2[i], beta[0] * t1[i]));
        let less = T::ONE - beta[1].mul_add(s2, beta[0] * s1);
        each!(i => {
            let products = [sums.products[0][i], sums.products[1][i], sums.products[2][i]];
            less.mul_add(sums.material[i], dot(along, products)) / divisor
        })
    }
}

/// x in the lanes where `is_first` is 1, y where it is 0.
#[inline(always)]
fn choose<T: Lane>(is_first: T, x: [T; 3], y: [T; 3]) -> [T; 3] {
    each!(i => T::select_less(T::splat(0.5), is_first, x[i], y[i]))
}

#[inline(always)]
fn dot<T: Lane>(x: [T; 3], y: [T; 3]) -> T {
    x[0].mul_add(y[0], x[1].mul_add(y[1], x[2] * y[2]))
}

#[inline(always)]
fn cross<T: Lane>(x: [T; 3], y: [T; 3]) -> [T; 3] {
    [x[1].mul_sub(y[2], x[2] * y[1]), x[2].mul_sub(y[0], x[0] * y[2]), x[0].mul_sub(y[1], x[1] * y[0])]
}

/// |U v|²
#[inline(always)]
fn square<T: Lane>(metric: [T; 6], v: [T; 3]) -> T {
    let [xx, xy, xz, yy, yz, zz] = metric;
    let image = [dot([xx, xy, xz], v), yy.mul_add(v[1], yz * v[2]), zz * v[2]];
    dot(image, image)
}

/// Two unit vectors across `normal`, from the global axis least aligned with it.
#[inline(always)]
fn tangents<T: Lane>(normal: [T; 3]) -> [[T; 3]; 2] {
    let [x, y, z] = each!(i => normal[i].abs());
    let least = T::select_less(y, x, y, x);
    let is_y = T::select_less(y, x, T::ONE, T::ZERO);
    let is_z = T::select_less(z, least, T::ONE, T::ZERO);
    let axis = [(T::ONE - is_y) * (T::ONE - is_z), is_y * (T::ONE - is_z), is_z];
    let along = dot(axis, normal);
    let across = each!(i => normal[i].neg_mul_add(along, axis[i]));
    let length = dot(across, across).sqrt();
    let t1 = each!(i => across[i] / length);
    [t1, cross(normal, t1)]
}

/// A unit eigenvector of the smallest eigenvalue of a scatter, and 1 if it is the only one, as
/// [`smallest_eigenvector_near`](crate::eigen::smallest_eigenvector_near) finds it: from nearby, or from the adjugate.
#[inline(always)]
fn smallest_direction<T: Lane>(scatter: [T; 6], near: Option<[T; 3]>) -> ([T; 3], T) {
    let [xx, xy, xz, yy, yz, zz] = scatter;
    let mut normal = match near {
        Some(near) => near,
        None => {
            let [x, y, z] = adjugate(scatter);
            let is_y = T::select_less(x[0], y[1], T::ONE, T::ZERO);
            let largest = choose(is_y, y, x);
            let of_largest = T::select_less(x[0], y[1], y[1], x[0]);
            let is_z = T::select_less(of_largest, z[2], T::ONE, T::ZERO);
            let row = choose(is_z, z, largest);
            let length = dot(row, row).sqrt();
            each!(i => row[i] / length)
        }
    };
    let (mut is_open, mut is_plane) = (T::ONE, T::ZERO);
    for _ in 0..MOST_QUOTIENTS {
        let image = [dot([xx, xy, xz], normal), dot([xy, yy, yz], normal), dot([xz, yz, zz], normal)];
        let value = dot(image, normal);
        let rows = adjugate([xx - value, xy, xz, yy - value, yz, zz - value]);
        let next = each!(i => dot(rows[i], normal));
        let length = dot(next, next).sqrt();
        let next = each!(i => next[i] / length);
        let turn = cross(next, normal);
        let turned = dot(turn, turn);
        // The other eigenvalues less this one, from their sum and their product.
        let sum = (xx + yy + zz) - T::splat(3.0) * value;
        let product = rows[0][0] + rows[1][1] + rows[2][2];
        let root = sum * sum - T::splat(4.0) * product;
        let root = T::select_less(T::ZERO, root, root, T::ZERO).sqrt();
        let largest = T::splat(0.5) * (sum + root);
        let middle = product / largest;
        let greatest = largest + value;
        let is_line = T::splat(LINE_TOLERANCE) * greatest - (middle + value);
        let is_thick = T::splat(THICKNESS_TOLERANCE) * greatest - middle;
        let mut is_sound = T::select_less(is_line, T::ZERO, T::ONE, T::ZERO);
        is_sound = T::select_less(is_thick, T::ZERO, is_sound, T::ZERO);
        is_sound = T::select_less(T::ZERO, sum, is_sound, T::ZERO);
        is_sound = T::select_less(T::ZERO, product, is_sound, T::ZERO);
        normal = choose(is_open, next, normal);
        let is_done = T::select_less(turned, T::splat(SAME_DIRECTION), is_open, T::ZERO);
        is_plane = T::select_less(T::splat(0.5), is_done, is_sound, is_plane);
        is_open = is_open - is_done;
        if T::all_less(is_open, T::splat(0.5)) {
            break;
        }
    }
    (normal, is_plane)
}

/// The adjugate of a symmetric matrix.
#[inline(always)]
fn adjugate<T: Lane>([xx, xy, xz, yy, yz, zz]: [T; 6]) -> [[T; 3]; 3] {
    let rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    [cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])]
}

#[cfg(test)]
mod tests {
    use diffuse_contact_kernels::cubic::Cubic;
    use diffuse_contact_kernels::support::Isa;

    use super::*;

    /// Sheets of nodes, each with a slave over it.
    #[derive(Default)]
    struct Scene {
        slaves: Vec<Sought>,
        masters: Vec<Point>,
        domains: Vec<MaterialDomain>,
    }

    impl Scene {
        /// A sheet with the slave's height and `rings` of nodes around those within reach.
        fn add(&mut self, number: usize, height: f64, rings: i32) {
            let (phase, start) = (0.7 * number as f64, self.masters.len());
            let side = -3 - rings..4 + rings;
            for (i, j) in side.clone().flat_map(|i| side.clone().map(move |j| (f64::from(i), f64::from(j)))) {
                let noise = |k: f64| 0.1 * (3.1 * i + 1.7 * j + k + phase).sin();
                let position = [i + noise(0.0), j + noise(1.0), 0.5 * noise(2.0)];
                let radius = 1.9 + 2.0 * noise(3.0);
                let metric = [1.0 / radius, 0.05, 0.0, 0.9 / radius, 0.02, 1.0 / radius];
                self.domains.push(MaterialDomain { position, metric });
                let [x, y, z] = position;
                self.masters.push([1.1 * x + 40.0, 0.2 * x + 0.9 * y - 3.0, z + 0.06 * x * x - 0.04 * x * y]);
            }
            let slave = [40.0 + 0.4 * phase.sin(), 0.4 * phase.cos() - 3.0, height];
            let (outward, range) = ([0.0, 0.1, 1.0], start..self.masters.len());
            self.slaves.push(Sought { slave, outward, range });
        }

        fn found(&self, isa: Isa, slaves: &[Sought]) -> Vec<Result<MaterialPlace, ElementError>> {
            let mut found = vec![Err(ElementError::TooFewNodes { found: 0, needed: 3 }); slaves.len()];
            let mut order: Vec<_> =
                slaves.iter().enumerate().map(|(k, slave)| (slave.range.len(), k)).collect();
            order.sort_unstable();
            isa.run(Search::<Cubic> {
                slaves,
                order: &order,
                nodes: (&self.masters, &self.domains),
                numbers: &mut Vec::new(),
                found: &mut found,
                kernels: PhantomData,
            });
            found
        }
    }

    #[test]
    fn lanes_find_what_is_found_number_by_number() {
        let mut scene = Scene::default();
        for k in 0..13 {
            scene.add(k, [-0.2, 0.0, 0.3][k % 3], (k % 2) as i32);
        }
        for isa in Isa::available() {
            for (slave, found) in scene.slaves.iter().zip(scene.found(isa, &scene.slaves)) {
                let (masters, domains) =
                    (&scene.masters[slave.range.clone()], &scene.domains[slave.range.clone()]);
                let fitting = |r| Weight::Cubic.fitting(r);
                let (found, expected) = (
                    found.unwrap(),
                    MaterialPlace::find(slave.slave, masters, domains, fitting, slave.outward).unwrap(),
                );
                for axis in 0..3 {
                    assert!((found.place[axis] - expected.place[axis]).abs() < 1e-12, "{isa}");
                    assert!((found.frame.normal[axis] - expected.frame.normal[axis]).abs() < 1e-12, "{isa}");
                }
                assert!(found.steps <= 9, "{isa}: {} evaluations", found.steps);
            }
        }
    }

    #[test]
    fn neither_other_lanes_nor_nodes_out_of_reach_change_a_bit() {
        let (mut few, mut many) = (Scene::default(), Scene::default());
        for k in 0..9 {
            few.add(k, 0.1, 0);
            many.add(k, 0.1, 1 + (k % 3) as i32);
        }
        let bits = |found: &Result<MaterialPlace, ElementError>| {
            let MaterialPlace { place, frame, .. } = (*found).unwrap();
            [place, frame.t1, frame.t2, frame.normal].map(|vector| vector.map(f64::to_bits))
        };
        for isa in Isa::available() {
            let [few_found, many_found] = [&few, &many].map(|scene| scene.found(isa, &scene.slaves));
            for (k, found) in few_found.iter().enumerate() {
                assert_eq!(bits(found), bits(&many_found[k]), "{isa}");
                let alone = few.found(isa, &few.slaves[k..=k]);
                assert_eq!(bits(found), bits(&alone[0]), "{isa}");
            }
        }
    }

    /// Nodes on a line have no plane.
    #[test]
    fn what_lanes_do_not_find_has_the_error_of_the_search_by_numbers() {
        let mut scene = Scene::default();
        scene.add(0, 0.1, 0);
        scene.add(1, 0.1, 0);
        for k in scene.slaves[0].range.clone() {
            scene.masters[k] = [k as f64, 0.0, 0.0];
        }
        let mut found = Vec::new();
        let nodes = (&scene.masters[..], &scene.domains[..]);
        places(&scene.slaves, nodes, Weight::Cubic, &mut SearchScratch::default(), &mut found);
        assert!(matches!(found[0], Err(ElementError::NoAveragePlane { .. })), "{:?}", found[0]);
        assert!(found[1].is_ok());
    }
}
