//! The kernels of contact on facets: functions of fixed size for each shape.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use crate::emit::{Fixed, Head, MOST_STATEMENTS, OpCounts, arguments};
use crate::lower::lower;
use crate::model::{FacetShape, FacetSpec, Kernel, Mode, facet_signature};
use crate::schedule::Program;

/// A facet kernel's source.
#[derive(Clone, Debug)]
pub struct EmittedFacetKernel {
    /// What it is.
    pub spec: FacetSpec,
    /// The function.
    pub tokens: TokenStream,
    /// Operations, with one evaluation of the foot equations.
    pub counts: OpCounts,
    /// Statements of the function.
    pub statements: usize,
}

/// Lowers, schedules and writes a facet kernel.
#[must_use]
pub fn emit_facet_kernel(spec: FacetSpec) -> EmittedFacetKernel {
    let program = Program::new(lower(&Kernel::facet(spec)));
    write(&program)
}

/// All facet kernels as a module.
pub(super) fn facet_module(support: &syn::Path) -> TokenStream {
    let kernels: Vec<TokenStream> = FacetSpec::all()
        .into_iter()
        .map(|spec| {
            let kernel = emit_facet_kernel(spec);
            let name = function_name(spec);
            assert!(kernel.statements <= MOST_STATEMENTS, "{name} has {} statements", kernel.statements);
            kernel.tokens
        })
        .collect();
    let dispatches = FacetShape::ALL.map(dispatch);
    quote! {
        /// Kernels of contact on the facets themselves: the distance of a slave from a triangle or a quadrilateral.
        #[allow(clippy::all, clippy::pedantic)]
        pub mod facet {
            use #support::*;

            #(#kernels)*
            #(#dispatches)*
        }
    }
}

fn function_name(spec: FacetSpec) -> Ident {
    format_ident!("{}_{}", spec.shape.name(), spec.mode.name())
}

/// Number of coordinates, and of entries of the packed lower triangle.
const fn sizes(shape: FacetShape) -> (usize, usize) {
    let freedoms = 3 * (shape.corners() + 1);
    (freedoms, freedoms * (freedoms + 1) / 2)
}

fn write(program: &Program<FacetSpec>) -> EmittedFacetKernel {
    let spec = program.kernel.spec;
    let corners = spec.shape.corners();
    let signature = facet_signature(&program.kernel);
    let head = Head {
        name: function_name(spec),
        inputs: quote!(FacetInputs<E, #corners>),
        fields: &signature.inputs,
        direction: None,
        values: format_ident!("FacetValues"),
        arguments: &arguments(&signature, spec.mode),
        points: &signature.points,
    };
    let function = Fixed::new(program, &head, |value, components| {
        if value.is_array { quote!([#(#components),*]) } else { quote!(#(#components)*) }
    });
    let Fixed { counts, iteration, statements, .. } = function;
    let documentation = documentation(&program.kernel, counts, iteration);
    EmittedFacetKernel { spec, tokens: function.tokens(&head, &documentation), counts, statements }
}

fn documentation(kernel: &Kernel<FacetSpec>, counts: OpCounts, iteration: OpCounts) -> Vec<String> {
    let FacetSpec { shape, mode } = kernel.spec;
    let with = match mode {
        Mode::Value => "",
        Mode::Gradient => " with first derivatives",
        Mode::Hessian => " with first and second derivatives",
    };
    let mut lines = vec![
        format!(" Distance of the slave from a {}{with}.", shape.name()),
        String::new(),
        format!(" Coordinates are ordered slave, corner 1, …, corner {}.", shape.corners()),
    ];
    if mode >= Mode::Gradient {
        lines.push(" `gradient`: N.".to_owned());
    }
    if mode >= Mode::Hessian {
        lines.push(" `hessian`: the packed lower triangle of M.".to_owned());
    }
    lines.push(String::new());
    lines.extend(kernel.equations.iter().map(|e| format!(" * `{}` ({})", e.formula, e.source)));
    lines.push(String::new());
    lines.push(match iteration.total() {
        0 => format!(" Operations: {}.", counts.total()),
        each => {
            format!(" Operations: {}, and {each} for each Newton iteration.", counts.total() - each)
        }
    });
    lines
}

/// The kernels of a shape for `f64`, compiled in the crate they are emitted into.
fn dispatch(shape: FacetShape) -> TokenStream {
    let name = format_ident!("{}", shape.name());
    let corners = shape.corners();
    let (freedoms, packed) = sizes(shape);
    let [value, gradient, hessian] = Mode::ALL.map(|mode| function_name(FacetSpec { shape, mode }));
    let doc = format!(" The kernels of the {} for `f64`, by mode.", shape.name());
    let doc_slices = format!(
        " `gradient` has {freedoms} entries, `hessian` {packed}; what the mode does not ask for is not touched and may be empty."
    );
    let panics = " If a slice is shorter than its mode needs.";
    quote! {
        #[doc = #doc]
        ///
        #[doc = #doc_slices]
        ///
        /// # Panics
        #[doc = #panics]
        #[must_use]
        pub fn #name(
            mode: Mode,
            inputs: &FacetInputs<f64, #corners>,
            gradient: &mut [f64],
            hessian: &mut [f64],
        ) -> FacetValues<f64> {
            match mode {
                Mode::Value => #value(inputs),
                Mode::Gradient => #gradient(inputs, first_entries(gradient)),
                Mode::Hessian => #hessian(inputs, first_entries(gradient), first_entries(hessian)),
            }
        }
    }
}
