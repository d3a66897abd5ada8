//! The product M v of an element without M.
//!
//! M leaves the kernels as a form of low rank: products of rows, and each node's own block (`docs/equations.md`, section 5). Multiplied
//! out it has 3(n+1) rows. A solver that only multiplies it with vectors takes the rows as they are, the *factors* of M.
//!
//! The kernel is the one of [`Mode::Hessian`](crate::Mode) up to the products. With the quadratic basis and a frame that is held the
//! factors are 42 n numbers; the packed M has 9 n (n + 2) / 2 and more. With nodal domains they are 90 n: more than the packed M up to
//! n = 17.
//!
//! ```
//! use diffuse_contact::{Element, Frame, Generated};
//!
//! let masters: Vec<[f64; 3]> =
//!     (0..9).map(|k| [f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, 0.1 * f64::from(k % 2)]).collect();
//! let element = Element::new([0.1, 0.2, 0.25], &masters, Frame::average_plane(&masters, [0.0, 0.0, 1.0])?, 2.0);
//! let contact = Generated.gap_factors(&element)?;
//! // The slave moves along x by 1, nobody else does.
//! let (mut v, mut product) = (vec![0.0; 30], vec![0.0; 30]);
//! v[0] = 1.0;
//! contact.hessian.multiply(&v, &mut product);
//! // A column of M: translations change nothing.
//! let sum: f64 = product.iter().step_by(3).sum();
//! assert!(sum.abs() < 1e-14);
//! # Ok::<(), diffuse_contact::ElementError>(())
//! ```

use diffuse_contact_kernels::support::{FormRows, Isa, KernelSet, SecondKind};

use crate::batch::{Asked, contact_point, gap_batch};
use crate::kernels::{frame_rule, inputs, validate};
use crate::weight::with_kernels;
use crate::{BatchScratch, ContactPoint, Element, ElementError, GapSlot, Generated, GeneratedWith, Weight};

/// How the factors of M lie in a slice of numbers, and what multiplies them.
#[derive(Clone, Copy, Debug)]
pub struct HessianForm(FormRows);

/// M of an element as its factors.
#[derive(Clone, Debug)]
pub struct HessianFactors {
    form: HessianForm,
    numbers: Vec<f64>,
}

/// The contact quantities of one element, with M as its factors.
#[derive(Clone, Debug)]
pub struct GapFactors {
    /// Gap, foot and normal.
    pub point: ContactPoint,
    /// N = ∂g/∂x (32), 3(n+1) entries, dimensionless.
    pub gradient: Vec<f64>,
    /// M = ∂²g/∂x∂x (42), 3(n+1) square, 1/length.
    pub hessian: HessianFactors,
}

impl HessianForm {
    pub(crate) const fn rows(self) -> FormRows {
        self.0
    }

    pub(crate) const fn new(rows: FormRows) -> Self {
        Self(rows)
    }

    /// Rows and columns of M, 3(n+1).
    pub const fn degrees_of_freedom(self) -> usize {
        3 * (self.0.count + 1)
    }

    /// How many numbers the factors are.
    pub const fn numbers(self) -> usize {
        self.0.factors()
    }

    /// `product` = M v, 3(n+1) entries each, ordered slave, master 1, …, master n. Of v only the differences from the slave's part are
    /// looked at, as translations change no gap.
    ///
    /// # Panics
    /// If a slice is too short.
    pub fn multiply(self, factors: &[f64], v: &[f64], product: &mut [f64]) {
        self.0.multiply_factors(Isa::best(), factors, v, product);
    }

    /// The diagonal of M, 3(n+1) entries.
    ///
    /// # Panics
    /// If a slice is too short.
    pub fn diagonal(self, factors: &[f64], diagonal: &mut [f64]) {
        self.0.factors_diagonal(factors, diagonal);
    }
}

impl HessianFactors {
    /// How the numbers lie.
    pub const fn form(&self) -> HessianForm {
        self.form
    }

    /// The factors.
    pub fn numbers(&self) -> &[f64] {
        &self.numbers
    }

    /// `product` = M v, see [`HessianForm::multiply`].
    ///
    /// # Panics
    /// If a slice is too short.
    pub fn multiply(&self, v: &[f64], product: &mut [f64]) {
        self.form.multiply(&self.numbers, v, product);
    }

    /// The diagonal of M, 3(n+1) entries.
    pub fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.form.degrees_of_freedom()];
        self.form.diagonal(&self.numbers, &mut diagonal);
        diagonal
    }
}

impl Generated {
    /// Gap, N and the factors of M.
    ///
    /// # Errors
    /// As [`Backend::gap`](crate::Backend::gap).
    pub fn gap_factors(&self, element: &Element<'_>) -> Result<GapFactors, ElementError> {
        with_kernels!(element.weight, K => GeneratedWith::<K>::new().gap_factors(element))
    }

    /// How the factors of M of an element lie: its [`numbers`](HessianForm::numbers) are the room that
    /// [`gap_factors_batch`](Self::gap_factors_batch) needs for them.
    ///
    /// # Errors
    /// As [`Backend::gap`](crate::Backend::gap), for input that is refused.
    pub fn hessian_form(&self, element: &Element<'_>) -> Result<HessianForm, ElementError> {
        with_kernels!(element.weight, K => GeneratedWith::<K>::new().hessian_form(element))
    }

    /// As [`gap_batch`](Self::gap_batch) in [`Mode::Hessian`](crate::Mode), with the factors of M in the place of M:
    /// [`hessian_form`](Self::hessian_form) says how many numbers they are.
    ///
    /// # Errors
    /// An entry for each element, as [`gap_into`](Self::gap_into).
    ///
    /// # Panics
    /// If there are not as many slots as elements, or a slice is too short.
    pub fn gap_factors_batch<'a>(
        &self,
        elements: &[Element<'_>],
        slots: impl IntoIterator<Item = GapSlot<'a>>,
        scratch: &mut BatchScratch,
    ) -> Vec<Result<ContactPoint, ElementError>> {
        gap_batch(self, elements, Asked::Second(SecondKind::Factors), slots, scratch)
    }
}

impl<K: KernelSet> GeneratedWith<K> {
    /// As [`Generated::gap_factors`], with the kernels of `K`.
    ///
    /// # Errors
    /// As [`Backend::gap`](crate::Backend::gap).
    pub fn gap_factors(&self, element: &Element<'_>) -> Result<GapFactors, ElementError> {
        self.with_numbers(element, SecondKind::Factors, HessianForm::numbers)
    }

    /// Gap, N and numbers of this kind for M; `count`: how many a form has.
    pub(crate) fn with_numbers(
        &self,
        element: &Element<'_>,
        kind: SecondKind,
        count: fn(HessianForm) -> usize,
    ) -> Result<GapFactors, ElementError> {
        let form = self.hessian_form(element)?;
        let (mut gradient, mut numbers) = (vec![0.0; form.degrees_of_freedom()], vec![0.0; count(form)]);
        let kernel = (element.basis, frame_rule(element.frame.derivative, &element.domains));
        let inputs = inputs::<K>(element, [0.0; 2]);
        let values = K::gap_factors(K::best_isa(), kernel, kind, &inputs, &mut gradient, &mut numbers);
        let point = contact_point(&values)?;
        Ok(GapFactors { point, gradient, hessian: HessianFactors { form, numbers } })
    }

    /// As [`Generated::hessian_form`], with the kernels of `K`.
    ///
    /// # Errors
    /// As [`Backend::gap`](crate::Backend::gap), for input that is refused.
    pub fn hessian_form(&self, element: &Element<'_>) -> Result<HessianForm, ElementError> {
        validate::<K>(element)?;
        let frame = frame_rule(element.frame.derivative, &element.domains);
        Ok(HessianForm(K::gap_form((element.basis, frame), element.masters.len())))
    }

    /// As [`Generated::gap_factors_batch`], with the kernels of `K` for all elements.
    ///
    /// # Errors
    /// An entry for each element, as [`gap_into`](Self::gap_into).
    ///
    /// # Panics
    /// If there are not as many slots as elements, or a slice is too short.
    pub fn gap_factors_batch<'a>(
        &self,
        elements: &[Element<'_>],
        slots: impl IntoIterator<Item = GapSlot<'a>>,
        scratch: &mut BatchScratch,
    ) -> Vec<Result<ContactPoint, ElementError>> {
        gap_batch(self, elements, Asked::Second(SecondKind::Factors), slots, scratch)
    }
}
