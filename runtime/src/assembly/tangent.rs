//! Which tangent is assembled.

/// Which tangent is assembled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tangent {
    /// K = ε N Nᵀ − f M, the exact derivative −∂R/∂x (Chamoret et al. 2008, eq. 43). It is indefinite in general: in
    /// penetration −f M is negative along the directions in which the master surface is convex.
    #[default]
    Exact,
    /// K = ε N Nᵀ, positive semidefinite. Newton's method then converges linearly; no Hessian is needed. With friction
    /// c ∇²q + ∂c/∂q ∇q ∇qᵀ is added, which is symmetric but may be indefinite, and takes Hessians.
    GaussNewton,
}

impl Tangent {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Exact, Self::GaussNewton];
    /// Residual over force up to which [`adaptive`](Self::adaptive) gives the exact tangent.
    pub const ADAPTIVE_RATIO: f64 = 0.3;

    /// Name in options.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::GaussNewton => "gauss-newton",
        }
    }

    /// The tangent for the next linear solution of a Newton iteration.
    ///
    /// * `residual`: norm of the residual over the free degrees of freedom, contact included.
    /// * `force`: the largest norm among external forces, contact forces and reactions, at the same positions.
    ///
    /// [`Exact`](Self::Exact) if residual / force ≤ 0.3 or the residual is 0, else [`GaussNewton`](Self::GaussNewton); so it is for NaN.
    ///
    /// Contact forces of a trial state are ε times whatever penetrates, many times those of equilibrium. There −f M makes the stiffness
    /// indefinite, the more so the larger ε is, and steps lead nowhere. Near equilibrium −f M makes the iteration converge quadratically.
    /// A tangent is chosen when it is assembled: no evaluation is repeated.
    ///
    /// ```
    /// use diffuse_contact::assembly::{ContactLaw, Tangent};
    ///
    /// let law = ContactLaw::penalty(1e5);
    /// // In each iteration, between the residual and the stiffness:
    /// let (residual, force) = (4.0, 5.0);
    /// let law = law.with_tangent(Tangent::adaptive(residual, force));
    /// assert_eq!(law.tangent, Tangent::GaussNewton);
    /// ```
    pub fn adaptive(residual: f64, force: f64) -> Self {
        if residual == 0.0 || residual / force <= Self::ADAPTIVE_RATIO {
            Self::Exact
        } else {
            Self::GaussNewton
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_adaptive_tangent_is_exact_up_to_its_ratio() {
        let ratio = Tangent::ADAPTIVE_RATIO;
        for force in [1e-300, 0.7, 1.0, 3e5, 1e300] {
            assert_eq!(Tangent::adaptive(0.0, force), Tangent::Exact);
            assert_eq!(Tangent::adaptive(0.999 * ratio * force, force), Tangent::Exact);
            assert_eq!(Tangent::adaptive(1.001 * ratio * force, force), Tangent::GaussNewton);
        }
        assert_eq!(Tangent::adaptive(ratio, 1.0), Tangent::Exact);
        assert_eq!(Tangent::adaptive(ratio.next_up(), 1.0), Tangent::GaussNewton);
    }

    #[test]
    fn without_forces_or_numbers_the_adaptive_tangent_has_no_hessian() {
        assert_eq!(Tangent::adaptive(0.0, 0.0), Tangent::Exact);
        for [residual, force] in [
            [1.0, 0.0],
            [f64::INFINITY, 1.0],
            [f64::INFINITY, f64::INFINITY],
            [f64::NAN, 1.0],
            [1.0, f64::NAN],
            [f64::NAN, f64::NAN],
        ] {
            assert_eq!(Tangent::adaptive(residual, force), Tangent::GaussNewton, "{residual} {force}");
        }
    }
}
