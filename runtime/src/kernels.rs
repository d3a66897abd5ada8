//! Which kernels an element runs through, and with what input.

use std::marker::PhantomData;

use diffuse_contact_kernels::support::{ElementInputs, FrameRule, KernelSet, Masters};

use crate::{Domains, Element, ElementError, FrameDerivative};

/// Evaluates elements with the kernels that the build script of `diffuse-contact-kernels` generated.
///
/// ```
/// use diffuse_contact::{Backend, Basis, Element, Frame, Generated, Mode, Weight};
///
/// // A flat 3 × 3 patch of master nodes in the plane z = 0 and a slave 0.25 above it.
/// let masters: Vec<[f64; 3]> =
///     (0..9).map(|k| [f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, 0.0]).collect();
/// let element = Element::new([0.1, 0.2, 0.25], &masters, Frame::average_plane(&masters, [0.0, 0.0, 1.0])?, 2.0);
/// let contact = Generated.gap(&element, Mode::Hessian)?;
/// assert!((contact.gap - 0.25).abs() < 1e-14);
/// assert_eq!(contact.gradient.len(), 3 * (9 + 1));
/// # Ok::<(), diffuse_contact::ElementError>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Generated;

/// Evaluates elements with kernels generated for a weight of one's own; [`Element::weight`] is ignored.
///
/// `K` is the kernel set that [`diffuse_contact_codegen::Config`](https://docs.rs/diffuse-contact-codegen) made in
/// a build script.
#[derive(Clone, Copy, Debug, Default)]
pub struct GeneratedWith<K>(PhantomData<K>);

impl<K> GeneratedWith<K> {
    /// The backend of the kernel set `K`.
    pub const fn new() -> Self {
        Self(PhantomData)
    }
}

/// [`Element::validate`], and whether there are kernels for the basis.
pub(crate) fn validate<K: KernelSet>(element: &Element<'_>) -> Result<(), ElementError> {
    if !K::BASES.contains(&element.basis) {
        return Err(ElementError::NoKernels { basis: element.basis.name() });
    }
    element.validate_with(K::fitting_weight)
}

pub(crate) const fn frame_rule(derivative: FrameDerivative, domains: &Domains<'_>) -> FrameRule {
    match (derivative, domains) {
        (FrameDerivative::Held, _) => FrameRule::Held,
        (FrameDerivative::CoMoving, Domains::Material(_)) => FrameRule::Material,
        (FrameDerivative::CoMoving, Domains::Shared | Domains::Each(_)) => FrameRule::CoMoving,
    }
}

pub(crate) fn inputs<'a, K: KernelSet>(element: &Element<'a>, point: [f64; 2]) -> ElementInputs<'a> {
    let pole = if K::INTERPOLATING { element.nearest_in_plane() } else { 0 };
    ElementInputs {
        slave: element.slave,
        masters: Masters::Positions(element.masters),
        domains: element.domains,
        plane_reach: element.frame.reach,
        t1: element.frame.t1,
        t2: element.frame.t2,
        normal: element.frame.normal,
        support_radius: element.support_radius,
        point,
        anchor: [0.0; 3],
        pole,
    }
}
