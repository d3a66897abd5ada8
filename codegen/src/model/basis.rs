//! Polynomial bases of the fit.

use crate::expr::{Expr, total};

/// A polynomial basis p(a, b) (Chamoret et al. 2008, eq. 13).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Basis {
    /// (1, a, b, a², ab, b²)
    Quadratic,
    /// (1, a, b)
    Linear,
    /// One of the caller's.
    Custom(CustomBasis),
}

/// A basis given by its monomials.
///
/// ```
/// use diffuse_contact_codegen::CustomBasis;
///
/// let bilinear = CustomBasis::new("bilinear", &[(0, 0), (1, 0), (0, 1), (1, 1)]).unwrap();
/// assert_eq!(bilinear.name(), "bilinear");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct CustomBasis {
    name: &'static str,
    monomials: &'static [(u8, u8)],
}

/// Why monomials do not make a basis. Monomials are given by their exponents of a and b.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum BasisError {
    /// The name cannot name a Rust module, or is that of a built-in basis.
    #[error(
        "\"{name}\" cannot name a basis: use lower-case letters, digits and _, a letter first, no keyword, not \"quadratic\" or \"linear\""
    )]
    Name { name: String },
    /// The basis does not begin with 1, a, b.
    #[error("a basis begins with the monomials (0, 0), (1, 0), (0, 1)")]
    NotLinear,
    /// A monomial has too high a degree.
    #[error("a^{} b^{} has a degree above {MOST_DEGREE}", .monomial.0, .monomial.1)]
    Degree { monomial: (u8, u8) },
    /// Monomials are not in the order of their degrees, or one is there twice.
    #[error("a^{} b^{} comes after a monomial of higher degree, or twice", .monomial.0, .monomial.1)]
    Order { monomial: (u8, u8) },
    /// A derivative of a monomial is missing, so that the fit would depend on where the basis has its origin.
    #[error(
        "a^{} b^{} is in the basis, but its derivative a^{} b^{} is not",
        .monomial.0, .monomial.1, .derivative.0, .derivative.1
    )]
    Derivative { monomial: (u8, u8), derivative: (u8, u8) },
}

/// Highest degree of a monomial.
pub(crate) const MOST_DEGREE: u8 = 4;
/// Most basis functions there can be.
pub(crate) const MOST_COEFFICIENTS: usize = 15;

/// Exponents of (a, b), degrees ascending.
const MONOMIALS: [(u8, u8); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];

impl CustomBasis {
    /// A basis from the exponents of (a, b) of its functions, in the order of their degrees, at most 4. It has to begin with 1, a,
    /// b and to contain all derivatives of its functions. `name` names the emitted module.
    pub fn new(name: &'static str, monomials: &'static [(u8, u8)]) -> Result<Self, BasisError> {
        let built_in = Basis::ALL.iter().any(|basis| basis.name() == name);
        if built_in || !super::weight::is_module_name(name) {
            return Err(BasisError::Name { name: name.to_owned() });
        }
        if !monomials.starts_with(&MONOMIALS[..3]) {
            return Err(BasisError::NotLinear);
        }
        for (k, &monomial) in monomials.iter().enumerate() {
            let (i, j) = monomial;
            let degree = |(i, j): (u8, u8)| u16::from(i) + u16::from(j);
            if degree(monomial) > u16::from(MOST_DEGREE) {
                return Err(BasisError::Degree { monomial });
            }
            let before = &monomials[..k];
            if before.contains(&monomial) || before.iter().any(|&other| degree(other) > degree(monomial)) {
                return Err(BasisError::Order { monomial });
            }
            let by_a = (i > 0).then(|| (i - 1, j));
            let by_b = (j > 0).then(|| (i, j - 1));
            for derivative in by_a.into_iter().chain(by_b) {
                if !before.contains(&derivative) {
                    return Err(BasisError::Derivative { monomial, derivative });
                }
            }
        }
        Ok(Self { name, monomials })
    }

    /// Name in emitted code.
    pub const fn name(self) -> &'static str {
        self.name
    }
}

impl Basis {
    /// The built-in bases.
    pub const ALL: [Self; 2] = [Self::Quadratic, Self::Linear];

    /// Number of basis functions, the smallest number of master nodes too.
    pub const fn size(self) -> usize {
        self.monomials().len()
    }

    /// Name in emitted code.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quadratic => "quadratic",
            Self::Linear => "linear",
            Self::Custom(basis) => basis.name,
        }
    }

    /// Exponents of (a, b) of every basis function. With a function, all its derivatives are in the basis, so
    /// the fit does not depend on where the basis has its origin.
    pub const fn monomials(self) -> &'static [(u8, u8)] {
        match self {
            Self::Quadratic => &MONOMIALS,
            Self::Linear => MONOMIALS.split_at(3).0,
            Self::Custom(basis) => basis.monomials,
        }
    }

    /// Whether the basis spans the same functions when it is turned in the plane: with one monomial of a degree it has
    /// all. Otherwise the surface depends on the directions of t1 and t2, which the average plane does not
    /// determine, and there are no kernels for a moving frame.
    pub fn is_isotropic(self) -> bool {
        let of_degree = |degree: u8| self.monomials().iter().filter(|&&(i, j)| i + j == degree).count();
        (0..=MOST_DEGREE).all(|degree| [0, usize::from(degree) + 1].contains(&of_degree(degree)))
    }

    /// What the pivots of the moment matrix are compared with, from its diagonal: the diagonal entries, but at least
    /// 10⁻⁴ (degree 1), 10⁻⁸ (degree 2) and so on of their sum over the degree. For nodes on one or two lines along the axes
    /// a diagonal entry is nothing but rounding, and no measure for the pivot.
    pub(super) fn pivot_references<'g>(self, diagonal: &[Expr<'g>]) -> Vec<Expr<'g>> {
        let degrees: Vec<i32> = self.monomials().iter().map(|&(i, j)| i32::from(i + j)).collect();
        let with_degree = || diagonal.iter().copied().zip(degrees.iter().copied());
        let reference = |(entry, degree): (Expr<'g>, i32)| {
            if degree == 0 {
                return entry;
            }
            let same = total(with_degree().filter(|(_, other)| *other == degree).map(|(entry, _)| entry));
            let floor = 1e-4_f64.powi(degree) * same;
            entry.max(floor.named(&format!("smallest_reference_{degree}")))
        };
        with_degree().map(reference).collect()
    }

    /// p(a, b)
    pub fn evaluate<'g>(self, a: Expr<'g>, b: Expr<'g>) -> Vec<Expr<'g>> {
        self.monomials().iter().map(|&(i, j)| a.powi(i.into()) * b.powi(j.into())).collect()
    }

    /// Order in which the moment matrix is eliminated: highest degree first. The rows of the factorisation that
    /// belong to 1, a, b then come last, and a functional of those three alone has a 3 × 3 second derivative in
    /// the factor's coordinates.
    pub fn elimination_order(self) -> Vec<usize> {
        (0..self.size()).rev().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn monomials_that_make_no_basis_are_refused() {
        let error = |monomials| CustomBasis::new("own", monomials).unwrap_err();
        assert_eq!(error(&[(0, 0), (0, 1), (1, 0)]), BasisError::NotLinear);
        assert_eq!(
            error(&[(0, 0), (1, 0), (0, 1), (2, 1)]),
            BasisError::Derivative { monomial: (2, 1), derivative: (1, 1) }
        );
        assert_eq!(error(&[(0, 0), (1, 0), (0, 1), (1, 0)]), BasisError::Order { monomial: (1, 0) });
        assert_eq!(error(&[(0, 0), (1, 0), (0, 1), (5, 0)]), BasisError::Degree { monomial: (5, 0) });
        let cubic = &[(0, 0), (1, 0), (0, 1), (2, 0), (3, 0), (1, 1)];
        assert_eq!(error(cubic), BasisError::Order { monomial: (1, 1) });
        for name in ["linear", "Bilinear", "fn", ""] {
            assert!(matches!(CustomBasis::new(name, &MONOMIALS), Err(BasisError::Name { .. })), "{name}");
        }
    }

    #[test]
    fn the_largest_basis_has_all_monomials_up_to_the_highest_degree() {
        let count = (0..=MOST_DEGREE).map(|degree| usize::from(degree) + 1).sum::<usize>();
        assert_eq!(count, MOST_COEFFICIENTS);
    }
}
