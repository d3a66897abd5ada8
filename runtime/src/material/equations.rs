//! The equations of a slave's place, for slaves side by side, one per lane, or for one.
//!
//! What a lane gets does not depend on the others, nor on nodes that carry no weight: these add zeros to its sums.

use std::marker::PhantomData;

use diffuse_contact_kernels::support::{KernelSet, Lane, Vector};

use crate::frame::{LINE_TOLERANCE, THICKNESS_TOLERANCE};

/// Steps to a normal.
const MOST_QUOTIENTS: usize = 8;
/// Square of the sine that a normal turns by, below which it is exact after the turn: the next error goes with the third power.
const SAME_DIRECTION: f64 = 1e-14;
/// Nodes are close to another where each is in the domain of the other, shrunk by this factor.
const CLOSE: f64 = 1.6;
/// Numbers of a node: its position and its first position, both from those of the nearest one, and its metric.
pub const VALUES: usize = 12;

/// The weight ω of the nodes.
pub trait Fitting {
    /// ω(r)
    fn weight<T: Lane>(&self, r: T) -> T;
}

/// That of the kernels.
pub struct OfKernels<K>(pub PhantomData<K>);

impl<K: KernelSet> Fitting for OfKernels<K> {
    #[inline(always)]
    fn weight<T: Lane>(&self, r: T) -> T {
        K::fitting_weight(r)
    }
}

/// Any function.
pub struct Function<F>(pub F);

impl<F: Fn(f64) -> f64> Fitting for Function<F> {
    #[inline(always)]
    fn weight<T: Lane>(&self, r: T) -> T {
        T::from_fn(|lane| (self.0)(r.lane(lane)))
    }
}

/// Slaves side by side. All places and positions are seen from their nearest nodes.
pub struct Lanes<'a, T> {
    /// Of each node.
    pub numbers: &'a [f64],
    /// The metric of the nearest node.
    pub near: [T; 6],
    pub slave: [T; 3],
}

/// The equations of a place.
#[derive(Clone, Copy)]
pub struct Evaluated<T> {
    /// From the place to the affine fit at the slave.
    pub step: [T; 3],
    /// Its length in the metric of the nearest node; NaN without an average plane.
    pub deviation: T,
    pub normal: [T; 3],
    /// Of the weighted nodes.
    pub mean: [T; 3],
}

/// Σ ω, Σ ω x, Σ ω x xᵀ, Σ ω (X − Ξ), Σ ω (X − Ξ) xᵀ
pub struct Sums<T> {
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

pub(super) use each;

impl<T: Vector> Lanes<'_, T> {
    /// `IS_START`: with the weights of the nodes close to the nearest one.
    #[inline(always)]
    pub fn evaluate<const IS_START: bool>(
        &self,
        place: [T; 3],
        near: Option<[T; 3]>,
        fitting: &impl Fitting,
    ) -> Evaluated<T> {
        let sums = self.sums::<IS_START>(place, fitting);
        let (normal, is_plane) = smallest_direction(sums.scatter(), near);
        let found = self.with_normal(&sums, normal);
        let deviation = T::select_less(T::splat(0.5), is_plane, found.deviation, T::splat(f64::NAN));
        Evaluated { deviation, ..found }
    }

    /// With the average plane as it is given.
    #[inline(always)]
    pub fn with_normal(&self, sums: &Sums<T>, normal: [T; 3]) -> Evaluated<T> {
        let step = self.affine_step(sums, normal);
        Evaluated { step, deviation: square(self.near, step).sqrt(), normal, mean: sums.mean() }
    }

    #[inline(always)]
    pub fn sums<const IS_START: bool>(&self, place: [T; 3], fitting: &impl Fitting) -> Sums<T> {
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
            let weight = fitting.weight(r);
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
        let inverse = T::ONE / (aa * bb - ab * ab);
        let beta = [(ab * b - bb * a) * inverse, (ab * a - aa * b) * inverse];
        let inverse = T::ONE / beta[1].mul_add(b, beta[0].mul_add(a, sums.total));
        // Σ ω (X − Ξ) (β·(x − s)) with β·x = (β₁ t₁ + β₂ t₂)·x
        let along = each!(i => beta[1].mul_add(t2[i], beta[0] * t1[i]));
        let less = T::ONE - beta[1].mul_add(s2, beta[0] * s1);
        each!(i => {
            let products = [sums.products[0][i], sums.products[1][i], sums.products[2][i]];
            less.mul_add(sums.material[i], dot(along, products)) * inverse
        })
    }
}

impl<T: Vector> Sums<T> {
    /// The weighted mean of the positions.
    #[inline(always)]
    fn mean(&self) -> [T; 3] {
        let inverse = T::ONE / self.total;
        each!(i => self.first[i] * inverse)
    }

    /// Σ ω (x − mean) (x − mean)ᵀ: xx, xy, xz, yy, yz, zz.
    #[inline(always)]
    pub fn scatter(&self) -> [T; 6] {
        let (mean, [x, y, z]) = (self.mean(), self.first);
        let [xx, xy, xz, yy, yz, zz] = self.second;
        [
            x.neg_mul_add(mean[0], xx),
            x.neg_mul_add(mean[1], xy),
            x.neg_mul_add(mean[2], xz),
            y.neg_mul_add(mean[1], yy),
            y.neg_mul_add(mean[2], yz),
            z.neg_mul_add(mean[2], zz),
        ]
    }
}

/// x in the lanes where `is_first` is 1, y where it is 0.
#[inline(always)]
pub fn choose<T: Lane>(is_first: T, x: [T; 3], y: [T; 3]) -> [T; 3] {
    each!(i => T::select_less(T::splat(0.5), is_first, x[i], y[i]))
}

#[inline(always)]
pub fn dot<T: Lane>(x: [T; 3], y: [T; 3]) -> T {
    x[0].mul_add(y[0], x[1].mul_add(y[1], x[2] * y[2]))
}

#[inline(always)]
fn cross<T: Lane>(x: [T; 3], y: [T; 3]) -> [T; 3] {
    [x[1].mul_sub(y[2], x[2] * y[1]), x[2].mul_sub(y[0], x[0] * y[2]), x[0].mul_sub(y[1], x[1] * y[0])]
}

/// |U v|²
#[inline(always)]
pub fn square<T: Lane>(metric: [T; 6], v: [T; 3]) -> T {
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
    let inverse = T::ONE / dot(across, across).sqrt();
    let t1 = each!(i => across[i] * inverse);
    [t1, cross(normal, t1)]
}

/// A unit eigenvector of the smallest eigenvalue of a scatter, and 1 if it is found and the only one: Rayleigh's quotient iteration, whose
/// error goes with the third power of the one before, from nearby or from the adjugate.
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
            let inverse = T::ONE / dot(row, row).sqrt();
            each!(i => row[i] * inverse)
        }
    };
    let (mut is_open, mut is_plane) = (T::ONE, T::ZERO);
    for _ in 0..MOST_QUOTIENTS {
        let image = [dot([xx, xy, xz], normal), dot([xy, yy, yz], normal), dot([xz, yz, zz], normal)];
        let value = dot(image, normal);
        let rows = adjugate([xx - value, xy, xz, yy - value, yz, zz - value]);
        let next = each!(i => dot(rows[i], normal));
        let inverse = T::ONE / dot(next, next).sqrt();
        let next = each!(i => next[i] * inverse);
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
