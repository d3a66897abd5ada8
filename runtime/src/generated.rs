//! The backend that runs the generated kernels.

use diffuse_contact_kernels::support::{ElementInputs, GapValues, KernelSet, packed_row};

use crate::batch::contact_point;
use crate::foot;
pub use crate::kernels::{Generated, GeneratedWith};
use crate::kernels::{frame_rule, inputs, validate};
use crate::output::SymmetricMatrix;
use crate::weight::with_kernels;
use crate::{
    Backend, Coefficients, ContactPoint, Domains, Element, ElementError, FootDerivatives, Gap, Mode, Point,
    Slip, Surface, Weight,
};

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
        with_kernels!(element.weight, K => GeneratedWith::<K>::new().foot_derivatives(element))
    }

    fn slip(&self, element: &Element<'_>, anchor: Point, mode: Mode) -> Result<Slip, ElementError> {
        with_kernels!(element.weight, K => GeneratedWith::<K>::new().slip(element, anchor, mode))
    }
}

impl<K: KernelSet + Sync> Backend for GeneratedWith<K> {
    fn coefficients(&self, element: &Element<'_>, mode: Mode) -> Result<Coefficients, ElementError> {
        check_fit::<K>(element)?;
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
        check_fit::<K>(element)?;
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
        let Gap { mut gradient, mut hessian, .. } = Gap::room(mode, element.degrees_of_freedom());
        let values = run_gap::<K>(element, mode, &mut gradient, hessian.packed_mut())?;
        Ok(Gap { gradient, hessian, ..gap_of(element, &values) })
    }

    fn foot_derivatives(&self, element: &Element<'_>) -> Result<FootDerivatives, ElementError> {
        foot::of_element::<K>(element)
    }

    fn slip(&self, element: &Element<'_>, anchor: Point, mode: Mode) -> Result<Slip, ElementError> {
        validate::<K>(element)?;
        ElementError::check_points("anchor", &[anchor])?;
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

/// The gap without derivatives.
fn gap_of(element: &Element<'_>, values: &GapValues<f64>) -> Gap {
    let &GapValues { gap, foot, normal, ref coefficients, .. } = values;
    Gap { gap, foot, normal, coefficients: coefficients[..element.basis.size()].to_vec(), ..Gap::default() }
}

/// What a kernel with an anchor wrote, cut into its parts.
fn slip_of(
    element: &Element<'_>,
    values: &GapValues<f64>,
    mode: Mode,
    [gradients, hessians]: [&[f64]; 2],
) -> Slip {
    let freedoms = element.degrees_of_freedom();
    let mut slip = Slip { contact: gap_of(element, values), half_square: values.slip, ..Slip::default() };
    if mode >= Mode::Gradient {
        let (gap, rest) = gradients.split_at(freedoms);
        let (of_slip, foot_weights) = rest.split_at(freedoms + 3);
        slip.contact.gradient = gap.to_vec();
        slip.gradient = of_slip.to_vec();
        slip.foot_weights = foot_weights.to_vec();
    }
    if mode >= Mode::Hessian {
        let (gap, of_slip) = hessians.split_at(packed_row(freedoms));
        slip.contact.hessian = SymmetricMatrix::of(freedoms, gap);
        slip.hessian = SymmetricMatrix::of(freedoms + 3, of_slip);
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
        contact_point(&run_gap::<K>(element, mode, gradient, hessian)?)
    }
}

/// Coefficients and surfaces are derivatives with the frame held, by kernels of their own.
fn check_fit<K: KernelSet>(element: &Element<'_>) -> Result<(), ElementError> {
    validate::<K>(element)?;
    match element.domains {
        Domains::Material(_) => Err(ElementError::MaterialDomains),
        Domains::Shared | Domains::Each(_) if !K::FIT => Err(ElementError::NoFitKernels),
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
        let hessians = if mode >= Mode::Hessian { hessians * packed_row(freedoms) } else { 0 };
        Self { freedoms, gradients: vec![0.0; gradients], hessians: vec![0.0; hessians] }
    }

    fn gradients(&self) -> Vec<Vec<f64>> {
        self.gradients.chunks_exact(self.freedoms).map(<[f64]>::to_vec).collect()
    }

    fn hessians(&self) -> Vec<SymmetricMatrix> {
        let packed = self.hessians.chunks_exact(packed_row(self.freedoms));
        packed.map(|packed| SymmetricMatrix::of(self.freedoms, packed)).collect()
    }
}
