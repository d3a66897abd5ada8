//! The kernels of the diffuse element: what surrounds the functions that are emitted from them.

use proc_macro2::Ident;
use quote::{format_ident, quote};

use super::elements::contact_signature;
use crate::emit::{Combined, EmittedKernel, KernelCounts, ShapeHead, emit_shape, kept_name};
use crate::kernel::{CHECKSUM, Kernel, Mode};
use crate::lower::lower;
use crate::model::{DOMAIN_RATIO, FrameRule, KernelSpec, MATERIAL_INPUTS, MOST_COEFFICIENTS, Output};
use crate::schedule::Program;

/// Inputs of a node, in the order of `support::NODE_VALUES`.
const NODE_INPUTS: [&str; 4] = ["master_x", "master_y", "master_z", DOMAIN_RATIO];

/// Lowers, schedules and writes a kernel.
pub fn emit_kernel(spec: &KernelSpec) -> EmittedKernel<KernelSpec> {
    let program = Program::new(lower(&Kernel::new(spec.clone())));
    let held = (spec.output.has_gap() && spec.frame == FrameRule::Held)
        .then(|| ("plane_pivot_ratio", quote!(E::ONE)));
    let sticks = (spec.output == Output::Gap).then(|| ("slip", quote!(E::ZERO)));
    let constants: Vec<_> = held.into_iter().chain(sticks).collect();
    let head = ShapeHead {
        name: function_name(spec),
        fields: &contact_signature(&program.kernel).inputs,
        arrays: &[("masters", &NODE_INPUTS), ("material", &MATERIAL_INPUTS)],
        values: values_name(spec.output),
        constants: &constants,
        // A basis leaves the coefficients of the largest one that it does not have at zero.
        lengths: &[("coefficients", MOST_COEFFICIENTS)],
        checksum: CHECKSUM,
        combined: Combined {
            name: "foot",
            kind: "FactorsAndFoot",
            inputs: &["normal_x", "normal_y", "normal_z"],
        },
    };
    emit_shape(&program, &head, |counts| documentation(&program.kernel, counts))
}

/// Name of a kernel's function.
pub(super) fn function_name(spec: &KernelSpec) -> Ident {
    format_ident!(
        "{}{}_{}",
        spec.output.name(),
        frame_word(spec.frame, ["_co_moving", "_material"]),
        spec.mode.name()
    )
}

fn frame_word(frame: FrameRule, [co_moving, material]: [&'static str; 2]) -> &'static str {
    match frame {
        FrameRule::Held => "",
        FrameRule::CoMoving => co_moving,
        FrameRule::Material => material,
    }
}

/// Name of the struct a kernel returns.
pub(super) fn values_name(output: Output) -> Ident {
    match output {
        Output::Coefficients => format_ident!("CoefficientsValues"),
        Output::Surface => format_ident!("SurfaceValues"),
        Output::Gap | Output::Slip => format_ident!("GapValues"),
    }
}

fn documentation(kernel: &Kernel<KernelSpec>, counts: &KernelCounts) -> Vec<String> {
    let spec = &kernel.spec;
    let m = spec.basis.size();
    let what = match spec.output {
        Output::Coefficients => "Coefficients of the fit about the slave",
        Output::Surface => "The fitted surface at `inputs.point`",
        Output::Gap => "Gap, foot point and normal",
        Output::Slip => "Gap, foot point, normal, and slip from the anchor",
    };
    let with = match spec.mode {
        Mode::Value => "",
        Mode::Gradient => " with first derivatives",
        Mode::Hessian => " with first and second derivatives",
    };
    let frame = frame_word(
        spec.frame,
        [", frame moving with the average plane", ", domains of influence in the first configuration"],
    );
    let mut lines = vec![
        format!(
            " {what}{with}{frame}; {} basis ({m} coefficients), weight `{}`.",
            spec.basis.name(),
            spec.weight.text()
        ),
        String::new(),
        " Coordinates are ordered slave, master 1, …, master n.".to_owned(),
    ];
    lines.push(format!(
        " `scratch`: [`{}::COUNT`] for each vector of nodes and one more, of any content.",
        kept_name(&function_name(spec))
    ));
    if !kernel.gradients.is_empty() {
        let names: Vec<&str> = kernel.gradients.iter().map(|(name, _)| *name).collect();
        lines.push(format!(" `gradients`: {} × 3(n+1) entries, of {}.", names.len(), names.join(", ")));
        if spec.output == Output::Slip {
            lines.push(
                " Those of the slip are 3(n+2), the anchor's last; then the nodes' weights in the foot, n."
                    .to_owned(),
            );
        }
    }
    if !kernel.hessians.is_empty() {
        let names: Vec<&str> = kernel.hessians.iter().map(|(name, _)| *name).collect();
        lines.push(format!(
            " `second`: {} × the packed lower triangle of 3(n+1) rows, or its factors, of {}.",
            names.len(),
            names.join(", ")
        ));
    }
    lines.push(String::new());
    for equation in &kernel.equations {
        lines.push(format!(" * `{}` ({})", equation.formula, equation.source));
    }
    lines.push(String::new());
    lines.push(format!(
        " Operations: {} + {} n + {} n(n−1)/2, and {} for each Newton iteration.",
        counts.element.total(),
        counts.node.total(),
        counts.pair.total(),
        counts.iteration.total(),
    ));
    if !kernel.gradients.is_empty() {
        lines.push(String::new());
        lines.push(" # Panics".to_owned());
        lines.push(" If a slice is shorter than stated.".to_owned());
    }
    lines
}
