//! The backend that runs the generated kernels.

use std::marker::PhantomData;

use diffuse_contact_kernels::support::{ElementInputs, FrameRule, GapValues, KernelSet, Masters, packed_row};

use crate::foot;
use crate::output::SymmetricMatrix;
use crate::{
    Backend, Coefficients, ContactPoint, Domains, Element, ElementError, FootDerivatives, FrameDerivative,
    Gap, Mode, Point, Slip, Surface, Weight,
};

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
    #[must_use]
    pub const fn new() -> Self {
        Self(PhantomData)
    }
}

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

impl Backend for Generated {
    fn coefficients(&self, element: &Element<'_>, mode: Mode) -> Result<Coefficients, ElementError> {
        with_kernels!(element.weight, K => GeneratedWith::<K>::new().coefficients(element, mode))
    }

    fn surface(&self, element: &Element<'_>, point: [f64; 2], mode: Mode) -> Result<Surface, ElementError> {
        with_kernels!(element.weight, K => GeneratedWith::<K>::new().surface(element, point, mode))
    }

    fn gap(&self, element: &Element<'_>, mode: Mode) -> Result<Gap, ElementError> {
        with_kernels!(element.weight, K => GeneratedWith::<K>::new().gap(element, mode))
    }

    fn foot_derivatives(&self, element: &Element<'_>) -> Result<FootDerivatives, ElementError> {
        foot::of_element(element)
    }

    fn slip(&self, element: &Element<'_>, anchor: Point, mode: Mode) -> Result<Slip, ElementError> {
        with_kernels!(element.weight, K => GeneratedWith::<K>::new().slip(element, anchor, mode))
    }
}

impl<K: KernelSet + Sync> Backend for GeneratedWith<K> {
    fn coefficients(&self, element: &Element<'_>, mode: Mode) -> Result<Coefficients, ElementError> {
        validate::<K>(element)?;
        refuse_material(element)?;
        let size = element.basis.size();
        let mut buffers = Buffers::new(element, mode, size, size);
        let inputs = inputs::<K>(element, [0.0; 2]);
        let (gradients, hessians) = (&mut buffers.gradients, &mut buffers.hessians);
        let values = K::coefficients(element.basis, mode, &inputs, gradients, hessians);
        ElementError::check(values.status())?;
        Ok(Coefficients {
            values: values.coefficients[..size].to_vec(),
            gradients: buffers.gradients(),
            hessians: buffers.hessians(),
        })
    }

    fn surface(&self, element: &Element<'_>, point: [f64; 2], mode: Mode) -> Result<Surface, ElementError> {
        validate::<K>(element)?;
        refuse_material(element)?;
        if let Some(index) = point.iter().position(|x| !x.is_finite()) {
            return Err(ElementError::NonFiniteInput { what: "point", index });
        }
        let mut buffers = Buffers::new(element, mode, 3, 1);
        let inputs = inputs::<K>(element, point);
        let (gradients, hessians) = (&mut buffers.gradients, &mut buffers.hessians);
        let values = K::surface(element.basis, mode, &inputs, gradients, hessians);
        ElementError::check(values.status())?;
        let mut gradients = buffers.gradients().into_iter();
        let mut next = || gradients.next().unwrap_or_default();
        Ok(Surface {
            value: values.value,
            slopes: values.slopes,
            curvatures: values.curvatures,
            gradient: next(),
            slope_gradients: [next(), next()],
            hessian: buffers.hessians().pop().unwrap_or_default(),
        })
    }

    fn gap(&self, element: &Element<'_>, mode: Mode) -> Result<Gap, ElementError> {
        validate::<K>(element)?;
        let mut buffers = Buffers::new(element, mode, 1, 1);
        let values = run_gap::<K>(element, mode, &mut buffers.gradients, &mut buffers.hessians)?;
        Ok(Gap {
            gap: values.gap,
            foot: values.foot,
            normal: values.normal,
            coefficients: values.coefficients[..element.basis.size()].to_vec(),
            gradient: buffers.gradients().pop().unwrap_or_default(),
            hessian: buffers.hessians().pop().unwrap_or_default(),
        })
    }

    fn foot_derivatives(&self, element: &Element<'_>) -> Result<FootDerivatives, ElementError> {
        foot::of_element_with::<K>(element)
    }

    fn slip(&self, element: &Element<'_>, anchor: Point, mode: Mode) -> Result<Slip, ElementError> {
        validate::<K>(element)?;
        check_anchor(anchor)?;
        if !K::FRICTION {
            return Err(ElementError::NoFrictionKernels);
        }
        let freedoms = element.degrees_of_freedom();
        let gradients = if mode >= Mode::Gradient { 2 * freedoms + 3 + element.masters.len() } else { 0 };
        let hessians =
            if mode >= Mode::Hessian { packed_row(freedoms) + packed_row(freedoms + 3) } else { 0 };
        let (mut gradients, mut hessians) = (vec![0.0; gradients], vec![0.0; hessians]);
        let inputs = ElementInputs { anchor, ..inputs::<K>(element, [0.0; 2]) };
        let kernel = (element.basis, frame_rule(element.frame.derivative, &element.domains), mode);
        let values = K::slip(K::best_isa(), kernel, &inputs, &mut gradients, &mut hessians);
        ElementError::check(values.status())?;
        Ok(slip_of(element, &values, mode, [&gradients, &hessians]))
    }
}

impl Generated {
    /// [`Backend::gap`] without allocation: N into `gradient`, 3(n+1) entries, and the packed lower triangle of M into
    /// `hessian` (see [`SymmetricMatrix`] for its order). What the mode does not ask for may be empty and is not
    /// touched; on an error the contents are unspecified.
    ///
    /// # Errors
    /// As [`Backend::gap`].
    ///
    /// # Panics
    /// If a slice is shorter than its mode needs.
    pub fn gap_into(
        &self,
        element: &Element<'_>,
        mode: Mode,
        gradient: &mut [f64],
        hessian: &mut [f64],
    ) -> Result<ContactPoint, ElementError> {
        with_kernels!(element.weight, K => GeneratedWith::<K>::new().gap_into(element, mode, gradient, hessian))
    }
}

/// Whether an anchor is a point.
pub(crate) fn check_anchor(anchor: Point) -> Result<(), ElementError> {
    let is_finite = anchor.iter().all(|x| x.is_finite());
    if is_finite { Ok(()) } else { Err(ElementError::NonFiniteInput { what: "anchor", index: 0 }) }
}

/// What a kernel with an anchor wrote, cut into its parts.
fn slip_of(
    element: &Element<'_>,
    values: &GapValues<f64>,
    mode: Mode,
    [gradients, hessians]: [&[f64]; 2],
) -> Slip {
    let freedoms = element.degrees_of_freedom();
    let matrix = |size: usize, packed: &[f64]| {
        let mut matrix = SymmetricMatrix::zeros(size);
        matrix.packed_mut().copy_from_slice(packed);
        matrix
    };
    let mut slip = Slip {
        contact: Gap {
            gap: values.gap,
            foot: values.foot,
            normal: values.normal,
            coefficients: values.coefficients[..element.basis.size()].to_vec(),
            ..Gap::default()
        },
        half_square: values.slip,
        ..Slip::default()
    };
    if mode >= Mode::Gradient {
        let (gap, rest) = gradients.split_at(freedoms);
        let (of_slip, foot_weights) = rest.split_at(freedoms + 3);
        slip.contact.gradient = gap.to_vec();
        slip.gradient = of_slip.to_vec();
        slip.foot_weights = foot_weights.to_vec();
    }
    if mode >= Mode::Hessian {
        let (gap, of_slip) = hessians.split_at(packed_row(freedoms));
        slip.contact.hessian = matrix(freedoms, gap);
        slip.hessian = matrix(freedoms + 3, of_slip);
    }
    slip
}

impl<K: KernelSet> GeneratedWith<K> {
    /// As [`Generated::gap_into`], with the kernels of `K`.
    ///
    /// # Errors
    /// As [`Backend::gap`].
    ///
    /// # Panics
    /// If a slice is shorter than its mode needs.
    pub fn gap_into(
        &self,
        element: &Element<'_>,
        mode: Mode,
        gradient: &mut [f64],
        hessian: &mut [f64],
    ) -> Result<ContactPoint, ElementError> {
        validate::<K>(element)?;
        let values = run_gap::<K>(element, mode, gradient, hessian)?;
        Ok(ContactPoint { gap: values.gap, foot: values.foot, normal: values.normal })
    }
}

/// [`Element::validate`], and whether there are kernels for the basis.
pub(crate) fn validate<K: KernelSet>(element: &Element<'_>) -> Result<(), ElementError> {
    if !K::BASES.contains(&element.basis) {
        return Err(ElementError::NoKernels { basis: element.basis.name() });
    }
    element.validate_with(K::fitting_weight)
}

/// Coefficients and surfaces are derivatives with the frame held.
fn refuse_material(element: &Element<'_>) -> Result<(), ElementError> {
    match element.domains {
        Domains::Material(_) => Err(ElementError::MaterialDomains),
        Domains::Shared | Domains::Each(_) => Ok(()),
    }
}

/// Runs the gap kernel that the element's frame asks for.
fn run_gap<K: KernelSet>(
    element: &Element<'_>,
    mode: Mode,
    gradient: &mut [f64],
    hessian: &mut [f64],
) -> Result<GapValues<f64>, ElementError> {
    let inputs = inputs::<K>(element, [0.0; 2]);
    let kernel = (element.basis, frame_rule(element.frame.derivative, &element.domains), mode);
    let values = K::gap(K::best_isa(), kernel, &inputs, gradient, hessian);
    ElementError::check(values.status())?;
    Ok(values)
}

pub(crate) const fn frame_rule(derivative: FrameDerivative, domains: &Domains<'_>) -> FrameRule {
    match (derivative, domains) {
        (FrameDerivative::Frozen, _) => FrameRule::Frozen,
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

/// Room for the derivatives a mode asks for.
struct Buffers {
    freedoms: usize,
    gradients: Vec<f64>,
    hessians: Vec<f64>,
}

impl Buffers {
    fn new(element: &Element<'_>, mode: Mode, gradients: usize, hessians: usize) -> Self {
        let freedoms = element.degrees_of_freedom();
        let gradients = if mode >= Mode::Gradient { gradients * freedoms } else { 0 };
        let hessians = if mode >= Mode::Hessian { hessians * (freedoms * (freedoms + 1) / 2) } else { 0 };
        Self { freedoms, gradients: vec![0.0; gradients], hessians: vec![0.0; hessians] }
    }

    fn gradients(&self) -> Vec<Vec<f64>> {
        self.gradients.chunks_exact(self.freedoms).map(<[f64]>::to_vec).collect()
    }

    fn hessians(&self) -> Vec<SymmetricMatrix> {
        let packed = self.freedoms * (self.freedoms + 1) / 2;
        self.hessians
            .chunks_exact(packed)
            .map(|chunk| {
                let mut matrix = SymmetricMatrix::zeros(self.freedoms);
                matrix.packed_mut().copy_from_slice(chunk);
                matrix
            })
            .collect()
    }
}
