//! Which vector instructions there are, found out at run time.

use std::fmt;
use std::sync::OnceLock;

/// A set of vector instructions that this machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Isa(pub(super) Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Kind {
    Scalar,
    #[cfg(target_arch = "x86_64")]
    Sse2,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "aarch64")]
    Neon,
}

/// What [`Isa::best`] returns from its first call on.
static BEST: OnceLock<Isa> = OnceLock::new();
/// Names the instructions to use, for instance under a tool that does not know all of them.
const VARIABLE: &str = "DIFFUSE_CONTACT_ISA";

impl Isa {
    /// One number at a time: on every machine.
    pub const SCALAR: Self = Self(Kind::Scalar);

    /// All that this machine has, the widest last.
    pub fn available() -> impl DoubleEndedIterator<Item = Self> {
        #[cfg(target_arch = "x86_64")]
        let kinds = [
            (Kind::Scalar, true),
            (Kind::Sse2, true),
            (Kind::Avx2, is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")),
            (
                Kind::Avx512,
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma"),
            ),
        ];
        #[cfg(target_arch = "aarch64")]
        let kinds = [(Kind::Scalar, true), (Kind::Neon, true)];
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        let kinds = [(Kind::Scalar, true)];
        kinds.into_iter().filter(|(_, is_there)| *is_there).map(|(kind, _)| Self(kind))
    }

    /// The widest that this machine has, unless [`prefer`](Self::prefer) or the environment variable
    /// `DIFFUSE_CONTACT_ISA`, read once, names another one that it has. Where this crate is compiled without
    /// optimisation, one number at a time: nothing is gained by vectors there, and what is inlined for them takes
    /// megabytes of stack.
    #[must_use]
    pub fn best() -> Self {
        if cfg!(unoptimised) {
            return Self::SCALAR;
        }
        *BEST.get_or_init(|| {
            let wanted = std::env::var(VARIABLE).ok().and_then(|name| Self::named(&name));
            wanted.or_else(|| Self::available().next_back()).unwrap_or(Self::SCALAR)
        })
    }

    /// Makes these instructions the [`best`](Self::best), for the whole process.
    ///
    /// # Errors
    /// The best, if it is another one and has been asked for before: all results of one process are made with the same
    /// instructions.
    pub fn prefer(self) -> Result<(), Self> {
        let best = if cfg!(unoptimised) { Self::SCALAR } else { *BEST.get_or_init(|| self) };
        if best == self { Ok(()) } else { Err(best) }
    }

    /// The one of this name, if this machine has it.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::available().find(|isa| isa.name() == name)
    }

    /// `scalar`, `sse2`, `avx2`, `avx512` or `neon`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self.0 {
            Kind::Scalar => "scalar",
            #[cfg(target_arch = "x86_64")]
            Kind::Sse2 => "sse2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx512",
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => "neon",
        }
    }

    /// Numbers in a vector.
    #[must_use]
    pub const fn width(self) -> usize {
        match self.0 {
            Kind::Scalar => 1,
            #[cfg(target_arch = "x86_64")]
            Kind::Sse2 => 2,
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => 4,
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => 8,
            #[cfg(target_arch = "aarch64")]
            Kind::Neon => 2,
        }
    }
}

impl Default for Isa {
    fn default() -> Self {
        Self::best()
    }
}

impl fmt::Display for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
