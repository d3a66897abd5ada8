//! The built-in weights and their kernels.

use diffuse_contact_kernels::support::KernelSet;

/// Runs an expression with `$kernels` as the kernel set of a weight.
macro_rules! with_kernels {
    ($weight:expr, $kernels:ident => $call:expr) => {
        match $weight {
            Weight::Cubic => {
                type $kernels = diffuse_contact_kernels::cubic::Cubic;
                $call
            }
            #[cfg(feature = "interpolating")]
            Weight::CubicInterpolating => {
                type $kernels = diffuse_contact_kernels::cubic_interpolating::CubicInterpolating;
                $call
            }
            Weight::WendlandC2 => {
                type $kernels = diffuse_contact_kernels::wendland_c2::WendlandC2;
                $call
            }
        }
    };
}

pub(crate) use with_kernels;

/// Weight function of the fit, a function of r = (in-plane distance from the slave) / (support radius).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Weight {
    /// 1 − 3r² + 2r³ inside the support radius, 0 outside (Chamoret et al. 2008, eq. 14).
    #[default]
    Cubic = 0,
    /// ω/(1 − ω) with ω the cubic weight (Chamoret et al. 2008, eq. 16): infinite at a node, so that the surface
    /// passes through the master nodes. With the Cargo feature `interpolating`, which is on by default.
    #[cfg(feature = "interpolating")]
    CubicInterpolating = 1,
    /// (1 − r)⁴ (1 + 4r) inside the support radius, 0 outside (Wendland 1995): twice differentiable at r = 1, where
    /// the cubic weight's second derivative jumps.
    WendlandC2 = 2,
}

impl Weight {
    /// All weights.
    #[cfg(feature = "interpolating")]
    pub const ALL: [Self; 3] = [Self::Cubic, Self::CubicInterpolating, Self::WendlandC2];

    /// All weights.
    #[cfg(not(feature = "interpolating"))]
    pub const ALL: [Self; 2] = [Self::Cubic, Self::WendlandC2];

    /// Names of weights that this build does without: they need the Cargo feature `interpolating`.
    pub const LEFT_OUT: &'static [&'static str] =
        if cfg!(feature = "interpolating") { &[] } else { &["cubic-interpolating"] };

    /// Whether the surface passes through the master nodes.
    pub const fn is_interpolating(self) -> bool {
        match self {
            #[cfg(feature = "interpolating")]
            Self::CubicInterpolating => true,
            Self::Cubic | Self::WendlandC2 => false,
        }
    }

    /// Name in input and output files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cubic => "cubic",
            #[cfg(feature = "interpolating")]
            Self::CubicInterpolating => "cubic-interpolating",
            Self::WendlandC2 => "wendland-c2",
        }
    }

    /// The weight at r; of an interpolating weight ω/(1 − ω) that of ω. 0 where r ≥ 1.
    pub fn fitting(self, r: f64) -> f64 {
        with_kernels!(self, K => K::fitting_weight(r))
    }
}
