//! Bases, modes and results of kernels.
//!
//! The generator has bases, modes and frame rules of its own, which it derives from: it is a build dependency, and a program that runs
//! kernels does without it. Generated code names those of here.

use super::Lane;

/// Polynomial basis of the moving least squares fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Basis {
    /// (1, a, b, a², ab, b²): six coefficients, at least six master nodes.
    Quadratic,
    /// (1, a, b): three coefficients, at least three master nodes.
    Linear,
    /// A basis of the caller's, for which kernels were generated.
    Custom(CustomBasis),
}

/// A basis of the caller's. Generated code has a constant for each: only kernel sets made for it know it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CustomBasis {
    /// Name, that of the kernels' module.
    pub name: &'static str,
    /// Exponents of (a, b) of the basis functions.
    pub monomials: &'static [(u8, u8)],
}

/// Exponents of (a, b) of the quadratic basis; the first three are those of the linear one.
const MONOMIALS: [(u8, u8); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];

impl Basis {
    /// Largest number of coefficients of any basis.
    pub const MOST_COEFFICIENTS: usize = 15;

    /// Number of coefficients, which is also the smallest number of master nodes.
    pub const fn size(self) -> usize {
        self.monomials().len()
    }

    /// Exponents of (a, b) of the basis functions.
    pub const fn monomials(self) -> &'static [(u8, u8)] {
        match self {
            Self::Quadratic => &MONOMIALS,
            Self::Linear => MONOMIALS.split_at(3).0,
            Self::Custom(basis) => basis.monomials,
        }
    }

    /// Whether the basis is one that kernels can be generated for: 1, a, b first, at most
    /// [`MOST_COEFFICIENTS`](Self::MOST_COEFFICIENTS) functions of degree 4 at most.
    pub fn is_sound(self) -> bool {
        let monomials = self.monomials();
        monomials.starts_with(&MONOMIALS[..3])
            && monomials.len() <= Self::MOST_COEFFICIENTS
            && monomials.iter().all(|&(i, j)| i <= 4 && j <= 4 && i + j <= 4)
    }

    /// Whether the basis spans the same functions when it is turned in the plane: with one monomial of a degree it has
    /// all. Otherwise the surface depends on the directions of t1 and t2, which the average plane does not
    /// determine, and there are no kernels for a moving frame.
    pub fn is_isotropic(self) -> bool {
        let degrees = self.monomials().iter().map(|&(i, j)| i + j);
        degrees
            .clone()
            .all(|degree| degrees.clone().filter(|&d| d == degree).count() == usize::from(degree) + 1)
    }

    /// Name, as in the modules of the kernels.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quadratic => "quadratic",
            Self::Linear => "linear",
            Self::Custom(basis) => basis.name,
        }
    }
}

/// How many derivatives are asked for. Each mode contains the ones before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Mode {
    /// Values only; gradients and Hessians of the output stay empty.
    Value,
    /// Values and first derivatives; Hessians stay empty.
    Gradient,
    /// Values, first and second derivatives.
    Hessian,
}

/// What the local frame does while differentiating.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FrameRule {
    /// It is held, as in the paper.
    Held,
    /// It is the average plane of the master nodes and moves with them.
    CoMoving,
    /// It is that plane, and domains of influence are those of [`Domains::Material`](super::Domains::Material).
    Material,
}

/// Values of the coefficient kernels.
#[derive(Clone, Copy, Debug)]
pub struct CoefficientsValues<T> {
    /// α (13), one per basis function; the rest is 0.
    pub coefficients: [T; Basis::MOST_COEFFICIENTS],
    /// Smallest pivot of A relative to its diagonal entry.
    pub pivot_ratio: T,
    /// Finite only if every result is.
    pub checksum: T,
}

/// Values of the surface kernels.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceValues<T> {
    /// Height f over the slave, length.
    pub value: T,
    /// f_1, f_2.
    pub slopes: [T; 2],
    /// f_11, f_12, f_22, 1/length.
    pub curvatures: [T; 3],
    /// Smallest pivot of A relative to its diagonal entry.
    pub pivot_ratio: T,
    /// Finite only if every result is.
    pub checksum: T,
}

/// Values of the gap kernels.
#[derive(Clone, Copy, Debug)]
pub struct GapValues<T> {
    /// Signed gap g (19), length.
    pub gap: T,
    /// Foot point x^d, global axes.
    pub foot: [T; 3],
    /// Unit normal ν (22) at the foot, global axes.
    pub normal: [T; 3],
    /// q, half the square of the slip from the anchor, length²; 0 of a kernel without an anchor.
    pub slip: T,
    /// α about the slave (13), one per basis function; the rest is 0.
    pub coefficients: [T; Basis::MOST_COEFFICIENTS],
    /// Smallest pivot of A relative to its diagonal entry.
    pub pivot_ratio: T,
    /// Smallest pivot of the average plane's system relative to its diagonal entry; 1 where the frame is held.
    pub plane_pivot_ratio: T,
    /// Largest foot residual, relative to the starting residual or R.
    pub foot_residual: T,
    /// Evaluations of the foot equations.
    pub foot_iterations: T,
    /// In-plane distance of the foot from the slave over R.
    pub foot_distance: T,
    /// Determinant of the foot equations' Jacobian, 0 on a centre of curvature.
    pub jacobian_determinant: T,
    /// Trace of the same Jacobian J. The distance has a minimum at the foot if −J is positive definite.
    pub jacobian_trace: T,
    /// Finite only if every result is.
    pub checksum: T,
}

impl<T: Lane> GapValues<T> {
    /// The values in lane k.
    #[inline(always)]
    pub fn lane(&self, k: usize) -> GapValues<f64> {
        let numbers = |x: &[T; 3]| [x[0].lane(k), x[1].lane(k), x[2].lane(k)];
        let mut coefficients = [0.0; Basis::MOST_COEFFICIENTS];
        for (place, number) in coefficients.iter_mut().enumerate() {
            *number = self.coefficients[place].lane(k);
        }
        GapValues {
            gap: self.gap.lane(k),
            foot: numbers(&self.foot),
            normal: numbers(&self.normal),
            slip: self.slip.lane(k),
            coefficients,
            pivot_ratio: self.pivot_ratio.lane(k),
            plane_pivot_ratio: self.plane_pivot_ratio.lane(k),
            foot_residual: self.foot_residual.lane(k),
            foot_iterations: self.foot_iterations.lane(k),
            foot_distance: self.foot_distance.lane(k),
            jacobian_determinant: self.jacobian_determinant.lane(k),
            jacobian_trace: self.jacobian_trace.lane(k),
            checksum: self.checksum.lane(k),
        }
    }
}

impl CoefficientsValues<f64> {
    /// No values.
    pub const NONE: Self = Self {
        coefficients: [f64::NAN; Basis::MOST_COEFFICIENTS],
        pivot_ratio: f64::NAN,
        checksum: f64::NAN,
    };
}

impl SurfaceValues<f64> {
    /// No values.
    pub const NONE: Self = Self {
        value: f64::NAN,
        slopes: [f64::NAN; 2],
        curvatures: [f64::NAN; 3],
        pivot_ratio: f64::NAN,
        checksum: f64::NAN,
    };
}

impl GapValues<f64> {
    /// No values.
    pub const NONE: Self = Self {
        gap: f64::NAN,
        foot: [f64::NAN; 3],
        normal: [f64::NAN; 3],
        slip: f64::NAN,
        coefficients: [f64::NAN; Basis::MOST_COEFFICIENTS],
        pivot_ratio: f64::NAN,
        plane_pivot_ratio: f64::NAN,
        foot_residual: f64::NAN,
        foot_iterations: f64::NAN,
        foot_distance: f64::NAN,
        jacobian_determinant: f64::NAN,
        jacobian_trace: f64::NAN,
        checksum: f64::NAN,
    };
}
