//! The generated kernels of a weight behind one trait.

use super::{
    Basis, BatchElement, CoefficientsValues, ElementInputs, FormRows, FrameRule, GapValues, Isa, Lane, Mode,
    SecondKind, SurfaceValues, Workspace,
};

/// The generated kernels of one weight.
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

    /// Whether the weight is an interpolating one, which makes kernels read [`ElementInputs::pole`].
    const INTERPOLATING: bool;

    /// Whether there are kernels of the fit by itself.
    const FIT: bool = false;

    /// Whether there are kernels with the slip from an anchor.
    const FRICTION: bool = false;

    /// The bases there are kernels for. Any other gives values of which none is a number.
    const BASES: &'static [Basis];

    /// Whether the kernels were compiled with optimisation. Without, they are compiled number by number only.
    const OPTIMISED: bool;

    /// The instructions to run these kernels with: the widest that the machine has, or without optimisation one number
    /// at a time.
    fn best_isa() -> Isa {
        if Self::OPTIMISED { Isa::best() } else { Isa::SCALAR }
    }

    /// The weight at r, distance over the radius of the domain; of an interpolating weight ω/(1 − ω) that of ω. 0 where r ≥ 1.
    fn fitting_weight<T: Lane>(r: T) -> T;

    /// α with ∂α/∂x and ∂²α/∂x∂x of each coefficient, number by number. Values of which none is a number if the set has no such
    /// kernels.
    #[must_use]
    fn coefficients(
        basis: Basis,
        mode: Mode,
        inputs: &ElementInputs<'_>,
        gradients: &mut [f64],
        hessians: &mut [f64],
    ) -> CoefficientsValues<f64> {
        let _ = (basis, mode, inputs, gradients, hessians);
        CoefficientsValues::NONE
    }

    /// f, f_l, f_lm at `inputs.point` with the gradients ∇f, T_1, T_2 and the Hessian H_f, number by number. Values of which none is a
    /// number if the set has no such kernels.
    #[must_use]
    fn surface(
        basis: Basis,
        mode: Mode,
        inputs: &ElementInputs<'_>,
        gradients: &mut [f64],
        hessians: &mut [f64],
    ) -> SurfaceValues<f64> {
        let _ = (basis, mode, inputs, gradients, hessians);
        SurfaceValues::NONE
    }

    /// g, foot and ν with the gradient N and the Hessian M: one element, its nodes side by side. A frame that moves is
    /// the average plane of the masters. `isa`: [`best_isa`](Self::best_isa) unless there is a reason for another. Allocates
    /// only for the first element of a thread, and for a larger one than before.
    fn gap(
        isa: Isa,
        kernel: (Basis, FrameRule, Mode),
        inputs: &ElementInputs<'_>,
        gradient: &mut [f64],
        hessian: &mut [f64],
    ) -> GapValues<f64>;

    /// As [`gap`](Self::gap), with the slip from [`ElementInputs::anchor`]: `gradient` is N, 3(n+1) entries, then ∇q, 3(n+2) with
    /// the anchor's last, then the weights φ of the nodes in the foot, n; `hessian` is M, then the packed lower triangle of ∇²q, 3(n+2)
    /// rows. Values of which none is a number if the set has no such kernels.
    #[must_use]
    fn slip(
        isa: Isa,
        kernel: (Basis, FrameRule, Mode),
        inputs: &ElementInputs<'_>,
        gradient: &mut [f64],
        hessian: &mut [f64],
    ) -> GapValues<f64> {
        let _ = (isa, kernel, inputs, gradient, hessian);
        GapValues::NONE
    }

    /// [`slip`](Self::slip) of many elements, as [`gap_batch`](Self::gap_batch).
    ///
    /// # Panics
    /// Also if the numbers of nodes differ.
    fn slip_batch(
        isa: Isa,
        kernel: (Basis, FrameRule, Mode),
        elements: &mut [BatchElement<'_>],
        workspace: &mut Workspace,
    ) {
        let _ = (isa, kernel, workspace);
        elements.iter_mut().for_each(|element| element.values = GapValues::NONE);
    }

    /// As [`gap`](Self::gap), for elements of the same number of nodes, which are evaluated side by side. With domains in the first
    /// configuration numbers may differ; elements that follow one another take as long as the largest of them. What one of them gets does
    /// not depend on the others. Allocates only if `workspace` has to grow.
    ///
    /// # Panics
    /// Also if the numbers of nodes differ elsewhere.
    fn gap_batch(
        isa: Isa,
        kernel: (Basis, FrameRule, Mode),
        elements: &mut [BatchElement<'_>],
        workspace: &mut Workspace,
    );

    /// The rows of the form that M of an element with `count` nodes has: how many numbers its [factors](FormRows::factors) are, and what
    /// [multiplies](FormRows::multiply_factors) them.
    fn gap_form(kernel: (Basis, FrameRule), count: usize) -> FormRows;

    /// As [`gap`](Self::gap) in [`Mode::Hessian`], with what `kind` says in the place of M: the same kernel up to the products.
    fn gap_factors(
        isa: Isa,
        kernel: (Basis, FrameRule),
        kind: SecondKind,
        inputs: &ElementInputs<'_>,
        gradient: &mut [f64],
        factors: &mut [f64],
    ) -> GapValues<f64>;

    /// As [`gap_factors`](Self::gap_factors), for elements of the same number of nodes, with these numbers in the place of
    /// [`BatchElement::hessian`].
    ///
    /// # Panics
    /// Also if the numbers of nodes differ.
    fn gap_factors_batch(
        isa: Isa,
        kernel: (Basis, FrameRule),
        kind: SecondKind,
        elements: &mut [BatchElement<'_>],
        workspace: &mut Workspace,
    );
}
