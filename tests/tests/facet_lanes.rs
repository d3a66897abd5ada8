//! The facet kernels are generic over the number they compute with: several facets side by side, each the same as alone.

use std::ops::{Add, Div, Mul, Neg, Sub};

use diffuse_contact_kernels::gap_over_quadrilateral::{Inputs, Values, hessian};
use diffuse_contact_kernels::support::{FacetFigures, Lane, Status, Vector, WithLanes};
use diffuse_contact_tests::{FacetCase, instructions};

/// Four numbers, one element each.
#[derive(Clone, Copy, Debug)]
struct Lanes4([f64; 4]);

impl Lanes4 {
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }

    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|k| f(self.0[k], other.0[k])))
    }
}

impl Add for Lanes4 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.zip(other, |x, y| x + y)
    }
}

impl Sub for Lanes4 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.zip(other, |x, y| x - y)
    }
}

impl Mul for Lanes4 {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.zip(other, |x, y| x * y)
    }
}

impl Div for Lanes4 {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        self.zip(other, |x, y| x / y)
    }
}

impl Neg for Lanes4 {
    type Output = Self;
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}

impl Lane for Lanes4 {
    const WIDTH: usize = 4;
    const ZERO: Self = Self([0.0; 4]);
    const ONE: Self = Self([1.0; 4]);

    fn splat(value: f64) -> Self {
        Self([value; 4])
    }

    fn from_fn(value: impl FnMut(usize) -> f64) -> Self {
        Self(std::array::from_fn(value))
    }

    fn lane(&self, k: usize) -> f64 {
        self.0[k]
    }

    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(std::array::from_fn(|k| Lane::mul_add(self.0[k], factor.0[k], term.0[k])))
    }

    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    fn exp(self) -> Self {
        self.map(f64::exp)
    }

    fn abs(self) -> Self {
        self.map(f64::abs)
    }

    fn select_less(x: Self, y: Self, then: Self, otherwise: Self) -> Self {
        Self(std::array::from_fn(|k| if x.0[k] < y.0[k] { then.0[k] } else { otherwise.0[k] }))
    }

    fn all_less(x: Self, y: Self) -> bool {
        (0..4).all(|k| x.0[k] < y.0[k])
    }
}

/// What the kernel made of a facet: values, then N and M.
struct Found {
    values: Values<f64>,
    derivatives: Vec<f64>,
}

/// Evaluates facets side by side, as many as a number has lanes, and again from the first.
fn evaluate<T: Lane>(cases: &[FacetCase]) -> Vec<Found> {
    let lanes = |of: &dyn Fn(&FacetCase) -> f64| T::from_fn(|k| of(&cases[k % cases.len()]));
    let axes = [0, 1, 2];
    let inputs = Inputs {
        slave: axes.map(|axis| lanes(&|case| case.slave[axis])),
        corners: [0, 1, 2, 3].map(|corner| axes.map(|axis| lanes(&|case| case.corners[corner][axis]))),
    };
    let (mut first, mut second) = ([T::ZERO; 15], [T::ZERO; 120]);
    let values = hessian(&inputs, &mut first, &mut second);
    let lane = |k: usize| Found {
        values: values.lane(k),
        derivatives: first.iter().chain(&second).map(|x| x.lane(k)).collect(),
    };
    (0..T::WIDTH).map(lane).collect()
}

impl Found {
    fn status(&self) -> Status {
        let Values { corner_area, foot_area, foot_residual, foot_iterations, jacobian_determinant, .. } =
            self.values;
        let are_finite = self.derivatives.iter().all(|x| x.is_finite());
        FacetFigures { corner_area, foot_area, foot_residual, foot_iterations, jacobian_determinant }
            .status(are_finite)
    }

    /// Everything as bits; NaNs are one whatever their sign and payload.
    fn bits(&self) -> Vec<u64> {
        let x = &self.values;
        let figures = [
            x.gap,
            x.natural[0],
            x.natural[1],
            x.corner_area,
            x.foot_area,
            x.foot_residual,
            x.foot_iterations,
            x.jacobian_determinant,
        ];
        let all = [&figures[..], &x.foot, &x.normal, &self.derivatives].concat();
        all.into_iter().map(|x| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() }).collect()
    }
}

/// [`evaluate`] with the vectors of the machine.
struct Vectors<'a>(&'a [FacetCase]);

impl WithLanes for Vectors<'_> {
    type Output = Vec<Found>;

    #[inline(always)]
    fn run<T: Vector>(self) -> Vec<Found> {
        evaluate::<T>(self.0)
    }
}

/// A flat one, two without a result, a warped one.
fn cases() -> [FacetCase; 4] {
    let flat = FacetCase { natural: [0.0; 2], ..FacetCase::random(4, 0.0, 1) };
    let mut degenerate = FacetCase::random(4, 0.2, 2);
    degenerate.corners[1] = degenerate.corners[0];
    let mut not_a_number = FacetCase::random(4, 0.2, 3);
    not_a_number.corners[2][1] = f64::NAN;
    [flat, degenerate, not_a_number, FacetCase::random(4, 0.3, 4)]
}

#[test]
fn facets_converge_each_in_its_own_lane() {
    let cases = cases();
    for (k, (found, case)) in evaluate::<Lanes4>(&cases).iter().zip(&cases).enumerate() {
        let alone = &evaluate::<f64>(std::slice::from_ref(case))[0];
        assert_eq!(alone.status() == Status::Ok, k % 3 == 0, "{:?}", alone.values);
        assert_eq!(found.bits(), alone.bits(), "lane {k}");
    }
}

/// The same with the vectors of the machine, which may have fused multiply-adds: alone is alone in all lanes.
#[test]
fn facets_in_vectors_of_the_machine_are_what_they_are_alone() {
    let cases = cases();
    for isa in instructions() {
        let found = isa.run(Vectors(&cases));
        assert_eq!(found.len(), isa.width());
        for (k, found) in found.iter().enumerate() {
            let case = &cases[k % 4];
            let alone = &isa.run(Vectors(std::slice::from_ref(case)))[k];
            assert_eq!(found.bits(), alone.bits(), "{isa}, lane {k}");
            let number_by_number = &evaluate::<f64>(std::slice::from_ref(case))[0];
            let is_sound = number_by_number.status() == Status::Ok;
            assert_eq!(found.status() == Status::Ok, is_sound, "{isa}, lane {k}");
            if is_sound {
                let largest = number_by_number.derivatives.iter().fold(0.0, |x: f64, y| x.max(y.abs()));
                for (x, y) in found.derivatives.iter().zip(&number_by_number.derivatives) {
                    assert!((x - y).abs() <= 1e-12 * largest, "{isa}, lane {k}");
                }
            }
        }
    }
}
