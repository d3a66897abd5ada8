//! Inputs and results of kernels.

/// Polynomial basis of the moving least squares fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Basis {
    /// (1, a, b, a², ab, b²): six coefficients, at least six master nodes.
    Quadratic,
    /// (1, a, b): three coefficients, at least three master nodes.
    Linear,
    /// A basis of the caller's, for which kernels were generated.
    Custom(CustomBasis),
}

/// A basis of the caller's. Generated code has a constant for each: only kernel sets made for it know it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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
    #[must_use]
    pub const fn size(self) -> usize {
        self.monomials().len()
    }

    /// Exponents of (a, b) of the basis functions.
    #[must_use]
    pub const fn monomials(self) -> &'static [(u8, u8)] {
        match self {
            Self::Quadratic => &MONOMIALS,
            Self::Linear => MONOMIALS.split_at(3).0,
            Self::Custom(basis) => basis.monomials,
        }
    }

    /// Whether the basis is one that kernels can be generated for: 1, a, b first, at most
    /// [`MOST_COEFFICIENTS`](Self::MOST_COEFFICIENTS) functions of degree 4 at most.
    #[must_use]
    pub fn is_sound(self) -> bool {
        let monomials = self.monomials();
        monomials.starts_with(&MONOMIALS[..3])
            && monomials.len() <= Self::MOST_COEFFICIENTS
            && monomials.iter().all(|&(i, j)| i <= 4 && j <= 4 && i + j <= 4)
    }

    /// Whether the basis spans the same functions when it is turned in the plane: with one monomial of a degree it has
    /// all. Otherwise the surface depends on the directions of t1 and t2, which the average plane does not
    /// determine, and there are no kernels for a moving frame.
    #[must_use]
    pub fn is_isotropic(self) -> bool {
        let degrees = self.monomials().iter().map(|&(i, j)| i + j);
        degrees
            .clone()
            .all(|degree| degrees.clone().filter(|&d| d == degree).count() == usize::from(degree) + 1)
    }

    /// Name, as in the modules of the kernels.
    #[must_use]
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

/// What a kernel reads. Positions are in global axes.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a, T> {
    /// Slave node x^c.
    pub slave: [T; 3],
    /// Master nodes x^1 … x^n.
    pub masters: &'a [[T; 3]],
    /// First in-plane direction of the local frame.
    pub t1: [T; 3],
    /// Second in-plane direction.
    pub t2: [T; 3],
    /// Unit normal n̂ of the plane, outward.
    pub normal: [T; 3],
    /// Support radius R.
    pub support_radius: T,
    /// In-plane offset from the slave at which the surface kernels evaluate, length; others ignore it.
    pub point: [T; 2],
    /// Index of the master node nearest to the slave in the plane (t1, t2), a whole number; only kernels with an
    /// interpolating weight use it. Their results do not depend on it in exact arithmetic: another node costs digits
    /// when the slave is close to the nearest one.
    pub anchor: T,
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

/// The generated kernels of one weight, for one element at a time. The kernels themselves are generic over
/// [`Lane`](super::Lane).
///
/// `gradients` and `hessians` hold, one after another, the derivatives with respect to the 3(n+1) global
/// coordinates ordered slave, master 1, …, master n; a Hessian is its packed lower triangle. What the mode does
/// not ask for is not touched and may be empty.
///
/// # Panics
/// The methods panic if a slice is shorter than their mode needs.
pub trait KernelSet {
    /// The weight's formula; of an interpolating weight ω/(1 − ω) that of ω.
    const WEIGHT: &'static str;

    /// Whether the weight is an interpolating one, which makes kernels read [`Inputs::anchor`].
    const INTERPOLATING: bool;

    /// The bases there are kernels for. Any other gives values of which none is a number.
    const BASES: &'static [Basis];

    /// α with ∂α/∂x and ∂²α/∂x∂x of each coefficient.
    fn coefficients(
        basis: Basis,
        mode: Mode,
        inputs: &Inputs<'_, f64>,
        gradients: &mut [f64],
        hessians: &mut [f64],
    ) -> CoefficientsValues<f64>;

    /// f, f_l, f_lm at `inputs.point` with the gradients ∇f, T_1, T_2 and the Hessian H_f.
    fn surface(
        basis: Basis,
        mode: Mode,
        inputs: &Inputs<'_, f64>,
        gradients: &mut [f64],
        hessians: &mut [f64],
    ) -> SurfaceValues<f64>;

    /// g, foot and ν with the gradient N and the Hessian M.
    fn gap(
        basis: Basis,
        mode: Mode,
        inputs: &Inputs<'_, f64>,
        gradients: &mut [f64],
        hessians: &mut [f64],
    ) -> GapValues<f64>;

    /// As [`gap`](Self::gap), for a frame that is the average plane of the masters and moves with them.
    fn gap_co_moving(
        basis: Basis,
        mode: Mode,
        inputs: &Inputs<'_, f64>,
        gradients: &mut [f64],
        hessians: &mut [f64],
    ) -> GapValues<f64>;
}
