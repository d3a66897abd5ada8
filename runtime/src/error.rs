//! Why an element has no result.

use diffuse_contact_kernels::support::{PIVOT_TOLERANCE, Status};

use crate::Point;

/// Every reason for which an element yields no numbers. Each carries the figures that led to it.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum ElementError {
    /// Fewer master nodes than the basis has coefficients.
    #[error("{found} master nodes, but the basis needs at least {needed}")]
    TooFewNodes { found: usize, needed: usize },
    /// More master nodes than 32-bit indices can name.
    #[error("{found} master nodes are more than a search tree can name")]
    TooManyNodes { found: usize },
    /// The kernels were generated without coefficients and surfaces: the Cargo feature `fit`, or `Config::fit` for a weight of one's own.
    #[error(
        "coefficients and surfaces are not compiled in: build with the Cargo feature `fit`, a weight of one's own with `Config::fit`"
    )]
    NoFitKernels,
    /// The kernels were generated without the slip from an anchor.
    #[error(
        "friction is not compiled in: build with the Cargo feature `friction`, as in `cargo run --release --features friction`"
    )]
    NoFrictionKernels,
    /// The backend has no kernels for the basis.
    #[error("there are no kernels for the basis \"{basis}\": generate them with `Config::basis`")]
    NoKernels { basis: &'static str },
    /// A frame cannot move with the average plane if the basis depends on the in-plane directions.
    #[error(
        "the basis \"{basis}\" depends on the directions t1 and t2, which a co-moving frame does not have: hold the frame"
    )]
    AnisotropicBasis { basis: &'static str },
    /// A coordinate or parameter is NaN or infinite. `what` is `"slave"`, `"master"` or the name of a parameter; `index` counts from 0.
    #[error("{what} {index} has a coordinate that is not a finite number")]
    NonFiniteInput { what: &'static str, index: usize },
    /// The support radius is not a positive finite number.
    #[error("the support radius must be positive and finite, not {value:?}")]
    InvalidSupportRadius { value: f64 },
    /// The radius of a node's domain of influence is not a positive finite number.
    #[error("the domain of master {index} must have a positive and finite radius, not {value:?}")]
    InvalidDomain { index: usize, value: f64 },
    /// There is not one domain of influence for each master node.
    #[error("{found} radii of domains for {expected} master nodes")]
    WrongNumberOfDomains { found: usize, expected: usize },
    /// Domains of influence in the first configuration need a frame that moves with the average plane.
    #[error("domains of influence in the first configuration need a frame that moves with the average plane")]
    HeldFrame,
    /// Coefficients and surfaces have no kernels for domains of influence in the first configuration.
    #[error("coefficients and surfaces cannot be had with domains of influence in the first configuration")]
    MaterialDomains,
    /// The slave's place in the first configuration is not a root of its equations, or their iteration does not converge. `deviation` is
    /// the iteration's next step over the size of the smallest domain that it leads through.
    #[error("the slave's place in the first configuration is off its equations by {deviation:e} of a domain")]
    NotMaterialPlace { deviation: f64 },
    /// The reach of the average plane's weights is not above 0 and at most 1.
    #[error("the reach of the average plane must be above 0 and at most 1, not {value:?}")]
    InvalidReach { value: f64 },
    /// The frame's vectors are not orthonormal. `deviation` is the largest entry of |Q Qᵀ − I|.
    #[error("the frame is not orthonormal: its Gram matrix differs from the identity by {deviation:e}")]
    InvalidFrame { deviation: f64 },
    /// The outward direction is missing where it is needed, zero, or lies in the average plane.
    #[error(
        "the outward direction does not tell the sides of the plane apart: its cosine with the normal is {cosine:e}"
    )]
    AmbiguousOutward { cosine: f64 },
    /// The master nodes lie (nearly) on a line or a point, or are as thick as they are wide.
    #[error(
        "the master nodes have no average plane: the two smallest principal moments are {smallest:e} and {middle:e} of the largest"
    )]
    NoAveragePlane { smallest: f64, middle: f64 },
    /// A frame that is to move with the average plane of the masters is not that plane.
    #[error(
        "the frame is co-moving but not the average plane of the masters: its normal is about {angle:e} rad off"
    )]
    NotAveragePlane { angle: f64 },
    /// The average plane, whose motion is differentiated, is not unique to working precision. `pivot_ratio` is the smallest pivot of
    /// ∂²E/∂θ∂θ, E = Σ (n·(x_i − x̄))²/2, over the diagonal entry it came from.
    #[error(
        "the average plane is not unique: smallest relative pivot {pivot_ratio:e} of the equations for its turn"
    )]
    UnstableAveragePlane { pivot_ratio: f64 },
    /// The moment matrix A of (13) is singular to working precision: the nodes that carry weight lie on one conic (quadratic basis) or on
    /// one line (linear basis). `pivot_ratio` is the smallest pivot of the Cholesky factorisation relative to the diagonal of the basis
    /// functions of its degree; 0 if there is none.
    #[error("the fit is singular: smallest relative pivot {pivot_ratio:e}, tolerance {tolerance:e}")]
    SingularFit { pivot_ratio: f64, tolerance: f64 },
    /// Newton's iteration for the foot point did not converge. `residual` is the largest component of the foot residual, relative to the
    /// starting residual or the support radius, whichever is larger.
    #[error("the foot point did not converge: relative residual {residual:e} after {iterations} iterations")]
    FootDiverged { residual: f64, iterations: usize },
    /// The foot point lies outside the domain of influence, where the fit extrapolates. `distance` is measured in the plane.
    #[error(
        "the foot point lies {distance:.6} support radii from the slave's projection, outside the domain of influence"
    )]
    FootOutside { distance: f64 },
    /// The foot is a stationary point of the distance, but not the nearest: the slave is farther from a concave surface than a centre of
    /// its curvature. The figures are those of the Jacobian J of the foot's equations; −J is positive definite where the foot is the
    /// nearest point around it.
    #[error(
        "the slave lies beyond a centre of curvature of the surface: the foot's Jacobian has determinant {determinant:e} and trace {trace:e}"
    )]
    BeyondCentreOfCurvature { determinant: f64, trace: f64 },
    /// The slave lies on a centre of curvature of the surface: the foot point is not unique. For a facet also: beyond one, where the foot
    /// is no minimum of the distance. `determinant` is that of the foot equations' Jacobian: 1 + f_1² + f_2² ≥ 1 on a flat surface, 1 on a
    /// flat facet.
    #[error(
        "the slave lies on or beyond a centre of curvature of the surface: Jacobian determinant {determinant:e}"
    )]
    CentreOfCurvature { determinant: f64 },
    /// A facet that is neither a triangle nor a quadrilateral.
    #[error("a facet has 3 or 4 corners, not {found}")]
    FacetCorners { found: usize },
    /// A facet without area, folded or not convex (corners coincide, lie on a line or are out of order), or a foot where the facet's
    /// extension is folded. `area` is the smallest area element, relative to the square of the facet's size and to its direction at the
    /// centre.
    #[error("the facet is degenerate: its area element at a corner or at the foot is {area:e} of a square's")]
    DegenerateFacet { area: f64 },
    /// The numbers overflowed although the input was finite (coordinates beyond about 1e75 support radii).
    #[error("the result overflows: a {what} is not a finite number")]
    Overflow { what: &'static str },
}

impl ElementError {
    /// The error that a kernel's status stands for.
    ///
    /// # Errors
    /// For every status but [`Status::Ok`].
    pub fn check(status: Status) -> Result<(), Self> {
        Err(match status {
            Status::Ok => return Ok(()),
            Status::SingularFit { pivot_ratio } => {
                Self::SingularFit { pivot_ratio, tolerance: PIVOT_TOLERANCE }
            }
            Status::FootDiverged { residual, iterations } => {
                Self::FootDiverged { residual, iterations: iterations as usize }
            }
            Status::FootOutside { distance } => Self::FootOutside { distance },
            Status::NoAveragePlane { pivot_ratio } => Self::UnstableAveragePlane { pivot_ratio },
            Status::DegenerateFacet { area } => Self::DegenerateFacet { area },
            Status::CentreOfCurvature { determinant } => Self::CentreOfCurvature { determinant },
            Status::BeyondCentreOfCurvature { determinant, trace } => {
                Self::BeyondCentreOfCurvature { determinant, trace }
            }
            _ => Self::Overflow { what: "result" },
        })
    }

    /// Whether all coordinates of these points are finite.
    pub(crate) fn check_points(what: &'static str, points: &[Point]) -> Result<(), Self> {
        let index = points.iter().position(|point| !point.iter().all(|x| x.is_finite()));
        index.map_or(Ok(()), |index| Err(Self::NonFiniteInput { what, index }))
    }

    /// Stable machine-readable code, used by the command-line program and the language bindings.
    pub const fn code(&self) -> &'static str {
        match self {
            Self::TooFewNodes { .. } => "too-few-nodes",
            Self::TooManyNodes { .. } => "too-many-nodes",
            Self::NoFitKernels => "no-fit-kernels",
            Self::NoFrictionKernels => "no-friction-kernels",
            Self::NoKernels { .. } => "no-kernels",
            Self::AnisotropicBasis { .. } => "anisotropic-basis",
            Self::NonFiniteInput { .. } => "non-finite-input",
            Self::InvalidSupportRadius { .. } => "invalid-support-radius",
            Self::InvalidDomain { .. } => "invalid-domain",
            Self::WrongNumberOfDomains { .. } => "wrong-number-of-domains",
            Self::HeldFrame => "held-frame",
            Self::MaterialDomains => "material-domains",
            Self::NotMaterialPlace { .. } => "not-material-place",
            Self::InvalidReach { .. } => "invalid-reach",
            Self::InvalidFrame { .. } => "invalid-frame",
            Self::AmbiguousOutward { .. } => "ambiguous-outward",
            Self::NoAveragePlane { .. } | Self::UnstableAveragePlane { .. } => "no-average-plane",
            Self::NotAveragePlane { .. } => "not-average-plane",
            Self::SingularFit { .. } => "singular-fit",
            Self::FootDiverged { .. } => "foot-diverged",
            Self::FootOutside { .. } => "foot-outside",
            Self::CentreOfCurvature { .. } => "centre-of-curvature",
            Self::BeyondCentreOfCurvature { .. } => "beyond-centre-of-curvature",
            Self::FacetCorners { .. } => "facet-corners",
            Self::DegenerateFacet { .. } => "degenerate-facet",
            Self::Overflow { .. } => "overflow",
        }
    }
}
