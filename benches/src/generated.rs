//! The generated kernels one element at a time as contenders, and how many operations they do.

use diffuse_contact::{Basis, Element, Mode};
use diffuse_contact_kernels::cubic::Cubic;
use diffuse_contact_kernels::support::{
    ElementInputs, FrameRule, GapValues, Isa, KernelSet, Masters, Status, SurfaceValues,
};

use crate::Elements;
use crate::contender::{Evaluation, NoResult, Output, Run};
use crate::one_by_one::OneByOne;

/// There is no set of vector instructions of a name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("this machine has {}, not {name}", .available.join(", "))]
pub struct UnknownIsa {
    /// What was asked for.
    pub name: String,
    /// Those this machine has.
    pub available: Vec<&'static str>,
}

/// The set of vector instructions of a name, for the generated kernels to be run with.
pub fn isa_named(name: &str) -> Result<Isa, UnknownIsa> {
    Isa::named(name).ok_or_else(|| UnknownIsa {
        name: name.to_owned(),
        available: Isa::available().map(Isa::name).collect(),
    })
}

/// Name of the instruction set the program is compiled for, which all but the generated kernels use.
pub const fn compiled_for() -> &'static str {
    if cfg!(target_feature = "avx512f") {
        "avx512"
    } else if cfg!(all(target_feature = "avx2", target_feature = "fma")) {
        "avx2"
    } else if cfg!(target_feature = "sse2") {
        "sse2"
    } else {
        "portable"
    }
}

/// In-plane offset from the slave at which surfaces are evaluated, over the support radius.
pub const SURFACE_POINT: [f64; 2] = [0.05, -0.08];

/// One element after another, a gap with the checks of [`Generated::gap_into`](diffuse_contact::Generated::gap_into).
pub fn one_by_one(elements: &Elements, output: Output, isa: Isa) -> Box<dyn Run + '_> {
    if output == Output::SurfaceHessian {
        return Box::new(OneByOne::new(elements, output, |elements, index, gradients, hessian| {
            let element = elements.held(index);
            let inputs = inputs(&element, SURFACE_POINT.map(|u| u * element.support_radius));
            let values: SurfaceValues<f64> =
                Cubic::surface(Basis::Quadratic, Mode::Hessian, &inputs, gradients, hessian);
            (values.status() == Status::Ok).then(|| std::hint::black_box(values).value)
        }));
    }
    let kernel = gap_kernel(output);
    Box::new(OneByOne::new(elements, output, move |elements, index, gradient, hessian| {
        let element = element(elements, output, index);
        element.validate().ok()?;
        let values = Cubic::gap(isa, kernel, &inputs(&element, [0.0; 2]), gradient, hessian);
        // Foot and normal count as used, too.
        (values.status() == Status::Ok).then(|| std::hint::black_box(values).gap)
    }))
}

#[cfg(feature = "rivals")]
/// Operations of the generated kernel for one element: fused multiply-adds, and whatever else counts like one (an
/// unpaired addition, a division, a root, a choice). The foot's equations count as often as these elements evaluate
/// them on average.
pub fn operations(output: Output, elements: &Elements) -> f64 {
    use codegen::{FrameRule, Mode, Output as Kernel};
    use diffuse_contact_codegen as codegen;
    let (kernel, mode, frame) = match output {
        Output::GapGradient => (Kernel::Gap, Mode::Gradient, FrameRule::Held),
        Output::GapHessian => (Kernel::Gap, Mode::Hessian, FrameRule::Held),
        Output::GapCoMovingHessian => (Kernel::Gap, Mode::Hessian, FrameRule::CoMoving),
        Output::SurfaceHessian => (Kernel::Surface, Mode::Hessian, FrameRule::Held),
    };
    let spec = codegen::KernelSpec {
        output: kernel,
        mode,
        basis: codegen::Basis::Quadratic,
        weight: codegen::Weight::cubic(),
        frame,
    };
    let counts = codegen::contact::emit_kernel(&spec).counts;
    let once = counts.total(elements.nodes()).total() - counts.iteration.total();
    once as f64 + counts.iteration.total() as f64 * foot_iterations(elements)
}

/// Evaluations of the foot's equations for one element, the mean.
pub fn foot_iterations(elements: &Elements) -> f64 {
    let iterations = |index| {
        let inputs = inputs(&elements.held(index), [0.0; 2]);
        let kernel = (Basis::Quadratic, FrameRule::Held, Mode::Value);
        let values: GapValues<f64> = Cubic::gap(Isa::SCALAR, kernel, &inputs, &mut [], &mut []);
        values.foot_iterations
    };
    (0..elements.len()).map(iterations).sum::<f64>() / elements.len() as f64
}

/// Element `index` with the frame rule of the output.
pub(crate) fn element(elements: &Elements, output: Output, index: usize) -> Element<'_> {
    match output {
        Output::GapCoMovingHessian => elements.co_moving(index),
        _ => elements.held(index),
    }
}

/// The kernel of one of the gap's outputs.
///
/// # Panics
/// If the output is a surface.
pub(crate) fn gap_kernel(output: Output) -> (Basis, FrameRule, Mode) {
    match output {
        Output::GapGradient => (Basis::Quadratic, FrameRule::Held, Mode::Gradient),
        Output::GapHessian => (Basis::Quadratic, FrameRule::Held, Mode::Hessian),
        Output::GapCoMovingHessian => (Basis::Quadratic, FrameRule::CoMoving, Mode::Hessian),
        Output::SurfaceHessian => panic!("a surface has no gap"),
    }
}

/// Entries of an element's packed Hessian, as far as the output has one.
pub(crate) fn hessian_size(elements: &Elements, output: Output) -> usize {
    let freedoms = elements.degrees_of_freedom();
    if output == Output::GapGradient { 0 } else { freedoms * (freedoms + 1) / 2 }
}

/// What kernels read of an element; `point` is where a surface is evaluated.
pub fn inputs<'a>(element: &Element<'a>, point: [f64; 2]) -> ElementInputs<'a> {
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
        pole: 0,
    }
}

/// The result all contenders are held against: that of the generated kernels, one element at a time.
///
/// # Errors
/// [`NoResult`] if the element has none.
pub fn reference(elements: &Elements, output: Output, index: usize) -> Result<Evaluation, NoResult> {
    one_by_one(elements, output, Isa::best()).evaluation(index)
}
