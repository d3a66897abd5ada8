//! Modules of kernels: for each weight its kernels by basis, and what chooses among them.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::file::{EmitOptions, TooLong, basis_constant};
use super::formula::formula;
use super::kernels::{emit_kernel, function_name, values_name};
use crate::emit::{EmittedKernel, MOST_STATEMENTS, kept_name};
use crate::kernel::Mode;
use crate::model::{Basis, FrameRule, KernelSpec, Output, Weight};

/// The kernels of weights that share them, and a module for each weight.
pub(super) fn weight_modules(weights: &[Weight], options: EmitOptions<'_>) -> Result<TokenStream, TooLong> {
    let [weight] = weights else {
        let both = Weight::either(weights).expect("no interpolating weights are put together");
        let module = format_ident!("{}", both.name());
        let kernels = basis_modules(&both, options)?;
        let sets = weights.iter().enumerate().map(|(number, weight)| {
            weight_module(weight, (&both, number), &quote!(super::#module), &quote!(), options)
        });
        let doc = format!(" Kernels with one of the weights `{}`.", both.text());
        return Ok(quote! {
            #[doc = #doc]
            #[allow(clippy::all, clippy::pedantic)]
            mod #module {
                #(#kernels)*
            }
            #(#sets)*
        });
    };
    let kernels = basis_modules(weight, options)?;
    Ok(weight_module(weight, (weight, 0), &quote!(self), &quote!(#(#kernels)*), options))
}

fn basis_modules(weight: &Weight, options: EmitOptions<'_>) -> Result<Vec<TokenStream>, TooLong> {
    options.bases.iter().map(|basis| basis_module(weight, *basis, options)).collect()
}

/// The module of a weight: the set of its kernels, which are those of another weight with a number, in the module
/// `place`; and what else it has.
fn weight_module(
    weight: &Weight,
    (of, number): (&Weight, usize),
    place: &TokenStream,
    kernels: &TokenStream,
    EmitOptions { support, bases, fit, friction, optimised }: EmitOptions<'_>,
) -> TokenStream {
    let module = format_ident!("{}", weight.name());
    let set = format_ident!("{}", camel_case(weight.name()));
    let all_bases = bases.iter().map(|basis| match basis {
        Basis::Custom(_) => {
            let constant = basis_constant(*basis);
            quote!(super::#constant)
        }
        _ => {
            let name = format_ident!("{}", camel_case(basis.name()));
            quote!(Basis::#name)
        }
    });
    let of_fit = [Output::Coefficients, Output::Surface].into_iter().filter(|_| fit);
    let scalar = of_fit.map(|output| scalar_method(output, (of, number), place, bases));
    let gap = gap_methods(Output::Gap, (of, number), place, bases);
    let slip = friction.then(|| gap_methods(Output::Slip, (of, number), place, bases));
    let description = match weight.is_interpolating() {
        true => format!("ω/(1 − ω), ω = `{}`", weight.text()),
        false => format!("`{}`", weight.text()),
    };
    let (module_doc, set_doc) = (
        format!(" Kernels with the weight {description}."),
        format!(" The kernels of this module as a [`KernelSet`]; weight {description}."),
    );
    let (text, interpolating) = (weight.text(), weight.is_interpolating());
    let value = formula(weight.formula());
    quote! {
        #[doc = #module_doc]
        #[allow(clippy::all, clippy::pedantic)]
        pub mod #module {
            use #support::*;

            #kernels

            #[doc = #set_doc]
            #[derive(Clone, Copy, Debug, Default)]
            pub struct #set;

            impl KernelSet for #set {
                const WEIGHT: &'static str = #text;
                const INTERPOLATING: bool = #interpolating;
                const OPTIMISED: bool = #optimised;
                const FIT: bool = #fit;
                const FRICTION: bool = #friction;
                const BASES: &'static [Basis] = &[#(#all_bases),*];
                #[allow(unused_parens)]
                #[inline(always)]
                fn fitting_weight<T: Lane>(r: T) -> T {
                    T::select_less(r, T::ONE, #value, T::ZERO)
                }

                #(#scalar)*
                #gap
                #slip
            }
        }
    }
}

/// `adaptive_cubic` → `AdaptiveCubic`
fn camel_case(name: &str) -> String {
    name.split('_')
        .map(|word| {
            let mut characters = word.chars();
            characters.next().map_or_else(String::new, |first| {
                first.to_ascii_uppercase().to_string() + characters.as_str()
            })
        })
        .collect()
}

fn basis_module(weight: &Weight, basis: Basis, options: EmitOptions<'_>) -> Result<TokenStream, TooLong> {
    let EmitOptions { support, fit, friction, optimised, .. } = options;
    let module = format_ident!("{}", basis.name());
    let mut kernels = Vec::new();
    let is_wanted = |spec: &KernelSpec| match spec.output {
        Output::Coefficients | Output::Surface => fit,
        Output::Gap => true,
        Output::Slip => friction,
    };
    for spec in KernelSpec::all(basis, weight).into_iter().filter(is_wanted) {
        let kernel = emit_kernel(&spec);
        if !matches!(basis, Basis::Custom(_)) && kernel.statements > MOST_STATEMENTS {
            let (weight, function) = (weight.name().to_owned(), function_name(&spec).to_string());
            return Err(TooLong { weight, function, statements: kernel.statements });
        }
        kernels.extend(gap_kernel(&kernel, optimised));
        kernels.extend(scalar_kernel(&spec));
        kernels.push(kernel.tokens);
    }
    let doc = format!(" {} basis, {} coefficients.", camel_case(basis.name()), basis.size());
    Ok(quote! {
        #[doc = #doc]
        pub(super) mod #module {
            use #support::*;
            #(#kernels)*
        }
    })
}

/// Derivatives of a mode, as arguments.
fn derivative_arguments(mode: Mode, second: &TokenStream) -> TokenStream {
    match mode {
        Mode::Value => quote!(),
        Mode::Gradient => quote!(gradients),
        Mode::Hessian => quote!(gradients, #second),
    }
}

/// A kernel for coefficients or surface, compiled for numbers: once for all weights that share it.
fn scalar_kernel(spec: &KernelSpec) -> Option<TokenStream> {
    if spec.output.has_gap() {
        return None;
    }
    let (function, name, kept) = (function_name(spec), scalar_name(spec), kept_name(&function_name(spec)));
    let values = values_name(spec.output);
    let arguments = derivative_arguments(spec.mode, &quote!(Second::new(SecondKind::Hessians, hessians)));
    let gradients = (spec.mode >= Mode::Gradient).then(|| quote!(gradients: &mut [f64],));
    let hessians = (spec.mode >= Mode::Hessian).then(|| quote!(hessians: &mut [f64],));
    let doc = format!(" [`{function}`] of one element, number by number.");
    Some(quote! {
        #[doc = #doc]
        pub fn #name(
            inputs: &ElementInputs<'_>,
            weight_number: usize,
            #gradients
            #hessians
        ) -> #values<f64> {
            scalar(inputs, weight_number, #kept::COUNT, |inputs, scratch| {
                #function::<f64, f64, Batch<f64>>(inputs, scratch, #arguments)
            })
        }
    })
}

fn scalar_name(spec: &KernelSpec) -> proc_macro2::Ident {
    format_ident!("{}_by_number", function_name(spec))
}

/// A kernel for the gap as a type. Without optimisation it is compiled once, number by number.
pub(super) fn gap_kernel(kernel: &EmittedKernel<KernelSpec>, optimised: bool) -> Option<TokenStream> {
    let spec = &kernel.spec;
    if !spec.output.has_gap() {
        return None;
    }
    let function = function_name(spec);
    let name = format_ident!("{}", camel_case(&function.to_string()));
    let kept = kept_name(&function);
    let arguments = derivative_arguments(spec.mode, &quote!(second));
    let mode = format_ident!("{}", camel_case(spec.mode.name()));
    let doc = format!(" [`{function}`]");
    let widths = format_ident!("{}", if optimised { widths(spec) } else { "One" });
    let is_material = spec.frame == FrameRule::Material;
    let has_anchor = spec.output == Output::Slip;
    let parameter = |name: &str, is_used: bool| {
        let name = format_ident!("{name}");
        if is_used { quote!(#name) } else { quote!(_) }
    };
    let gradients = parameter("gradients", spec.mode >= Mode::Gradient);
    let second = parameter("second", spec.mode >= Mode::Hessian);
    let rows = kernel.rows.map(|rows| quote!(const ROWS: usize = #rows;));
    Some(quote! {
        #[doc = #doc]
        #[derive(Clone, Copy, Debug)]
        pub struct #name;

        impl GapKernel for #name {
            const MODE: Mode = Mode::#mode;
            const MATERIAL: bool = #is_material;
            const ANCHOR: bool = #has_anchor;
            const KEPT: usize = #kept::COUNT;
            const WIDTHS: Widths = Widths::#widths;
            #rows

            #[inline(always)]
            fn evaluate<E: Lane, T: Lane, S: Shape<Element = E, Node = T>>(
                inputs: &Inputs<'_, E, T>,
                scratch: &mut [T],
                #gradients: &mut [S::Output],
                #second: Second<'_, S::Output>,
            ) -> GapValues<E> {
                #function::<E, T, S>(inputs, scratch, #arguments)
            }
        }
    })
}

/// The quadratic basis with a fitting weight is what most elements have. Batches with another basis (a fallback) or an
/// interpolating weight are compiled for vectors of four numbers only. Kernels with a slip are twice as long: of them only the common ones
/// have batches, and the others are evaluated number by number.
fn widths(spec: &KernelSpec) -> &'static str {
    let is_common = spec.basis == Basis::Quadratic && !spec.weight.is_interpolating();
    match spec.output {
        Output::Slip if is_common => "EveryBatch",
        Output::Slip => "One",
        _ if is_common => "Every",
        _ => "Four",
    }
}

/// A basis as a pattern; with it a condition, as the constant of a caller's basis is no pattern.
fn basis_pattern(basis: Basis) -> (TokenStream, Option<TokenStream>) {
    if let Basis::Custom(_) = basis {
        let constant = basis_constant(basis);
        return (quote!(basis), Some(quote!(if basis == super::#constant)));
    }
    let name = format_ident!("{}", camel_case(basis.name()));
    (quote!(Basis::#name), None)
}

/// The method of `KernelSet` for coefficients or surface.
fn scalar_method(
    output: Output,
    (weight, number): (&Weight, usize),
    place: &TokenStream,
    bases: &[Basis],
) -> TokenStream {
    let method = format_ident!("{}", output.name());
    let values = values_name(output);
    let arms = bases.iter().flat_map(|&basis| {
        let (pattern, condition) = basis_pattern(basis);
        let module = format_ident!("{}", basis.name());
        Mode::ALL.map(|mode| {
            let spec =
                KernelSpec { output, mode, basis, weight: weight.clone(), frame: FrameRule::Held };
            let name = scalar_name(&spec);
            let arguments = derivative_arguments(mode, &quote!(hessians));
            let mode_name = format_ident!("{}", camel_case(mode.name()));
            quote! {
                (#pattern, Mode::#mode_name) #condition => #place::#module::#name(inputs, #number, #arguments),
            }
        })
    });
    quote! {
        fn #method(
            basis: Basis,
            mode: Mode,
            inputs: &ElementInputs<'_>,
            gradients: &mut [f64],
            hessians: &mut [f64],
        ) -> #values<f64> {
            match (basis, mode) {
                #(#arms)*
                (Basis::Custom(_), _) => #values::NONE,
            }
        }
    }
}

/// The methods of `KernelSet` for the gap, or for gap and slip.
fn gap_methods(
    output: Output,
    (weight, number): (&Weight, usize),
    place: &TokenStream,
    bases: &[Basis],
) -> TokenStream {
    let kernels = gap_kernels(output, weight, place, bases).into_iter().map(|kernel| {
        let GapKernelName { basis, condition, frame, mode, name } = kernel;
        let mode = format_ident!("{}", camel_case(mode.name()));
        (quote!((#basis, #frame, Mode::#mode) #condition), name)
    });
    let (patterns, types): (Vec<TokenStream>, Vec<TokenStream>) = kernels.unzip();
    let factors = (output == Output::Gap).then(|| factor_methods((weight, number), place, bases));
    let (one, many) = (format_ident!("{}", output.name()), format_ident!("{}_batch", output.name()));
    quote! {
        fn #one(
            isa: Isa,
            kernel: (Basis, FrameRule, Mode),
            inputs: &ElementInputs<'_>,
            gradient: &mut [f64],
            hessian: &mut [f64],
        ) -> GapValues<f64> {
            let second = Second::new(SecondKind::Hessians, hessian);
            match kernel {
                #(#patterns => single::<#types>(isa, #number, inputs, gradient, second),)*
                (Basis::Custom(_), _, _) => GapValues::NONE,
            }
        }

        fn #many(
            isa: Isa,
            kernel: (Basis, FrameRule, Mode),
            elements: &mut [BatchElement<'_>],
            workspace: &mut Workspace,
        ) {
            match kernel {
                #(#patterns => batch::<#types>(isa, #number, SecondKind::Hessians, elements, workspace),)*
                (Basis::Custom(_), _, _) => elements.iter_mut().for_each(|element| element.values = GapValues::NONE),
            }
        }

        #factors
    }
}

/// The methods of `KernelSet` for the factors of the gap's Hessian: the same kernels as for the Hessian itself.
fn factor_methods((weight, number): (&Weight, usize), place: &TokenStream, bases: &[Basis]) -> TokenStream {
    let kernels = gap_kernels(Output::Gap, weight, place, bases).into_iter();
    let kernels = kernels.filter(|kernel| kernel.mode == Mode::Hessian).map(|kernel| {
        let GapKernelName { basis, condition, frame, name, .. } = kernel;
        (quote!((#basis, #frame) #condition), name)
    });
    let (patterns, types): (Vec<TokenStream>, Vec<TokenStream>) = kernels.unzip();
    quote! {
        fn gap_form((basis, frame): (Basis, FrameRule), count: usize) -> FormRows {
            let rows = match (basis, frame) {
                #(#patterns => <#types as GapKernel>::ROWS,)*
                (Basis::Custom(_), _) => 0,
            };
            FormRows { rows, count }
        }

        fn gap_factors(
            isa: Isa,
            (basis, frame): (Basis, FrameRule),
            kind: SecondKind,
            inputs: &ElementInputs<'_>,
            gradient: &mut [f64],
            factors: &mut [f64],
        ) -> GapValues<f64> {
            let second = Second::new(kind, factors);
            match (basis, frame) {
                #(#patterns => single::<#types>(isa, #number, inputs, gradient, second),)*
                (Basis::Custom(_), _) => GapValues::NONE,
            }
        }

        fn gap_factors_batch(
            isa: Isa,
            (basis, frame): (Basis, FrameRule),
            kind: SecondKind,
            elements: &mut [BatchElement<'_>],
            workspace: &mut Workspace,
        ) {
            match (basis, frame) {
                #(#patterns => batch::<#types>(isa, #number, kind, elements, workspace),)*
                (Basis::Custom(_), _) => elements.iter_mut().for_each(|element| element.values = GapValues::NONE),
            }
        }
    }
}

/// A kernel for the gap by its type, and the patterns that choose it.
struct GapKernelName {
    basis: TokenStream,
    condition: Option<TokenStream>,
    frame: TokenStream,
    mode: Mode,
    name: TokenStream,
}

fn gap_kernels(output: Output, weight: &Weight, place: &TokenStream, bases: &[Basis]) -> Vec<GapKernelName> {
    let of_basis = |&basis: &Basis| {
        let module = format_ident!("{}", basis.name());
        let specs = KernelSpec::all(basis, weight).into_iter().filter(move |spec| spec.output == output);
        specs.map(move |spec| {
            let (basis, condition) = basis_pattern(basis);
            let frame = match spec.frame {
                FrameRule::Held => quote!(FrameRule::Held),
                FrameRule::CoMoving => quote!(FrameRule::CoMoving),
                FrameRule::Material => quote!(FrameRule::Material),
            };
            let name = format_ident!("{}", camel_case(&function_name(&spec).to_string()));
            let name = quote!(#place::#module::#name);
            GapKernelName { basis, condition, frame, mode: spec.mode, name }
        })
    };
    bases.iter().flat_map(of_basis).collect()
}
