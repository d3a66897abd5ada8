//! The module of an element of the caller's: types, kernels by mode, and what runs them.

use proc_macro2::{Group, Ident, Literal, TokenStream, TokenTree};
use quote::{format_ident, quote};

use super::count::OpCounts;
use super::fixed::{Argument, Fixed, Head, array, nested};
use super::function::solver_name;
use super::node_element::emit_node_kernel;
use super::node_module;
use crate::graph::Iteration;
use crate::lower::lower;
use crate::model::{
    Differentiated, ElementError, ElementKernels, ElementSpec, Input, Kernel, Mode, Role, Signature,
};
use crate::schedule::Program;

/// A kernel of an element as source.
#[derive(Clone, Debug)]
pub struct EmittedElementKernel {
    /// With how many derivatives.
    pub mode: Mode,
    /// The function.
    pub tokens: TokenStream,
    /// Operations, with one evaluation of the equations of roots, without those of nodes.
    pub counts: OpCounts,
    /// Operations for each node, and for each pair of nodes; none of an element of fixed size.
    pub per_node: [OpCounts; 2],
    /// Operations of one evaluation of the equations of roots.
    pub iteration: OpCounts,
    /// Statements of the function.
    pub statements: usize,
}

/// Lowers, schedules and writes a kernel of an element.
#[must_use]
pub fn emit_element_kernel(kernel: &Kernel<ElementSpec>) -> EmittedElementKernel {
    let program = Program::new(lower(kernel));
    let ElementSpec { signature, mode, .. } = &program.kernel.spec;
    if !signature.nodes.is_empty() {
        let arguments = node_module::arguments(signature, *mode);
        return emit_node_kernel(&program, &arguments, |kernel| {
            documentation(&program.kernel.spec, &arguments, kernel)
        });
    }
    let arguments = arguments(signature, *mode);
    let head = Head {
        name: function_name(*mode),
        inputs: quote!(Inputs<E>),
        fields: &signature.inputs,
        values: format_ident!("Values"),
        arguments: &arguments,
        points: &signature.points,
    };
    let function = Fixed::new(&program, &head, |value, components| {
        let returned = signature.values.iter().find(|returned| returned.name == value.name);
        nested(returned.map_or(&[], |returned| &returned.dimensions), components)
    });
    let mut kernel = EmittedElementKernel {
        mode: *mode,
        tokens: TokenStream::new(),
        counts: function.counts,
        per_node: [OpCounts::default(); 2],
        iteration: function.iteration,
        statements: function.statements,
    };
    let arguments: Vec<String> = arguments.iter().map(|(name, _)| name.clone()).collect();
    let documentation = documentation(&program.kernel.spec, &arguments, &kernel);
    kernel.tokens = function.tokens(&head, &documentation);
    kernel
}

/// The module of an element. `optimised`: whether the crate it goes into is compiled with optimisation.
///
/// # Errors
/// [`ElementError::TooLong`].
pub fn emit_element(
    element: &ElementKernels,
    support: &syn::Path,
    optimised: bool,
) -> Result<TokenStream, ElementError> {
    let signature = &element.signature;
    let (mut kernels, mut iterations) = (Vec::new(), Vec::new());
    for kernel in &element.kernels {
        let EmittedElementKernel { mode, tokens, statements, .. } = emit_element_kernel(kernel);
        if statements > super::MOST_STATEMENTS {
            return Err(ElementError::TooLong { function: function_name(mode).to_string(), statements });
        }
        iterations.extend(kernel.roots().into_iter().map(|root| kernel.graph.root(root).iteration));
        kernels.push(tokens);
    }
    let module = format_ident!("{}", signature.name);
    let last = element.kernels.last().map_or(Mode::Value, |kernel| kernel.spec.mode);
    let doc = format!(" {}", title(signature));
    let has_nodes = !signature.nodes.is_empty();
    let has_products = has_nodes && last == Mode::Hessian && signature.node_variables() > 0;
    let others = [
        ("packed_row", last == Mode::Hessian),
        ("Equations", iterations.iter().any(|iteration| matches!(iteration, Iteration::Within(_)))),
        (solver_name(Iteration::Newton), iterations.contains(&Iteration::Newton)),
        (solver_name(Iteration::Descent), iterations.contains(&Iteration::Descent)),
        ("multiply_node_rows", has_products),
    ];
    let others = others.into_iter().filter(|(_, is_used)| *is_used).map(|(name, _)| format_ident!("{name}"));
    let (types, runners, unused) = if has_nodes {
        let types = node_module::types(element, last);
        (types, node_module::runners(signature, last), Some(quote!(#[allow(unused_variables)])))
    } else {
        (types(signature, last), runners(signature, last), None)
    };
    Ok(without_suffixes(quote! {
        #[doc = #doc]
        #[allow(clippy::all, clippy::pedantic, non_snake_case)]
        #unused
        pub mod #module {
            use #support::{Isa, Lane, Mode, Vector, WithLanes};
            #(use #support::#others;)*

            /// Whether the kernels are compiled with optimisation. Without, they are compiled number by number only.
            const OPTIMISED: bool = #optimised;

            #types
            #(#kernels)*
            #runners
        }
    }))
}

/// `[E; 12usize]` → `[E; 12]`
pub(super) fn without_suffixes(tokens: TokenStream) -> TokenStream {
    let change = |tree: TokenTree| match tree {
        TokenTree::Group(group) => {
            TokenTree::Group(Group::new(group.delimiter(), without_suffixes(group.stream())))
        }
        TokenTree::Literal(literal) => {
            let number = literal.to_string().strip_suffix("usize").and_then(|number| number.parse().ok());
            TokenTree::Literal(number.map_or(literal, Literal::usize_unsuffixed))
        }
        other => other,
    };
    tokens.into_iter().map(change).collect()
}

pub(super) fn title(signature: &Signature) -> String {
    if signature.doc.is_empty() {
        format!("The element `{}`.", signature.name)
    } else {
        signature.doc.clone()
    }
}

fn function_name(mode: Mode) -> Ident {
    format_ident!("{}", mode.name())
}

/// What derivatives of a mode are written to.
pub(crate) fn arguments(signature: &Signature, mode: Mode) -> Vec<Argument> {
    let count = signature.variables();
    let mut arguments = Vec::new();
    for value in signature.values.iter().filter(|_| mode > Mode::Value) {
        match value.differentiated {
            Differentiated::Twice => {
                arguments.push(("gradient".to_owned(), count));
                if mode == Mode::Hessian {
                    arguments.push(("hessian".to_owned(), count * (count + 1) / 2));
                }
            }
            Differentiated::Once => {
                let entries: usize = value.dimensions.iter().product();
                arguments.push((format!("{}_jacobian", value.name), entries * count));
            }
            Differentiated::Not => {}
        }
    }
    arguments
}

/// What an argument holds, for the documentation.
pub(super) fn meaning(signature: &Signature, argument: &str) -> String {
    let variables: Vec<String> = signature
        .inputs
        .iter()
        .chain(&signature.nodes)
        .filter(|input| input.role == Role::Variable)
        .map(|input| format!("`{}`", input.name))
        .collect();
    let by = variables.join(", ");
    let by = if signature.nodes.is_empty() { by } else { format!("{by}, those of the nodes node by node") };
    match argument {
        "gradient" => format!("∂energy/∂x, x: {by}"),
        "hessian" => format!("∂²energy/∂x∂x, packed lower triangle, row by row, x: {by}"),
        _ => {
            let of = argument.trim_end_matches("_jacobian");
            format!("∂{of}/∂x, a row per entry, x: {by}")
        }
    }
}

fn documentation(spec: &ElementSpec, arguments: &[String], kernel: &EmittedElementKernel) -> Vec<String> {
    let ElementSpec { signature, mode, quantities, .. } = spec;
    let with = match mode {
        Mode::Value => "Values",
        Mode::Gradient => "Values and first derivatives",
        Mode::Hessian => "Values, first and second derivatives",
    };
    let mut lines = vec![format!(" {}", title(signature)), String::new(), format!(" {with}:"), String::new()];
    for value in &signature.values {
        lines.push(format!(
            " * `{}`{}",
            value.name,
            if value.doc.is_empty() { String::new() } else { format!(": {}", value.doc) }
        ));
    }
    for argument in arguments {
        lines.push(format!(" * `{argument}`: {}", meaning(signature, argument)));
    }
    if !quantities.is_empty() {
        let names: Vec<String> = quantities.iter().map(|name| format!("`{name}`")).collect();
        lines.push(String::new());
        lines.push(format!(" Made of {}.", names.join(", ")));
    }
    if !signature.points.rows.is_empty() {
        lines.push(String::new());
        lines.push(format!(" Sums over {} points.", signature.points.rows.len()));
    }
    lines.push(String::new());
    let (total, iteration) = (kernel.counts.total(), kernel.iteration.total());
    let of_nodes = match (signature.nodes.is_empty(), kernel.per_node.map(|counts| counts.total())) {
        (true, _) => String::new(),
        (false, [node, 0]) => format!(" + {node} n"),
        (false, [node, pair]) => format!(" + {node} n + {pair} n(n−1)/2"),
    };
    lines.push(match iteration {
        0 => format!(" Operations: {total}{of_nodes}."),
        each => format!(" Operations: {}{of_nodes}, and {each} for each Newton iteration.", total - each),
    });
    if !signature.nodes.is_empty() {
        lines.push(String::new());
        lines.push(format!(
            " `scratch`: [`SCRATCH`]`[{}]` numbers for each of the n nodes, of any content.",
            *mode as usize
        ));
        lines.push(String::new());
        lines.push(" # Panics".to_owned());
        lines.push(" If a slice is shorter than the nodes need.".to_owned());
    }
    lines
}

/// A struct's field of numbers `of`, documented.
pub(super) fn field(
    name: &str,
    doc: &str,
    default: &str,
    dimensions: &[usize],
    of: &TokenStream,
) -> TokenStream {
    let (ident, of) = (format_ident!("{name}"), array(dimensions, of));
    let doc = format!(" {}", if doc.is_empty() { default } else { doc });
    quote! {
        #[doc = #doc]
        pub #ident: #of
    }
}

/// The structs `Inputs`, `Values` and `Results`.
fn types(signature: &Signature, last: Mode) -> TokenStream {
    let (lane, number) = (quote!(E), quote!(f64));
    let inputs = signature.inputs.iter().map(|input| {
        let default = match input.role {
            Role::Variable => "A variable.",
            Role::Parameter => "A parameter: derivatives are not taken by it.",
        };
        field(&input.name, &input.doc, default, &input.dimensions, &lane)
    });
    let values = value_types(signature);
    let derivatives = arguments(signature, last).into_iter().map(|(name, length)| {
        field(&name, &format!("{}.", meaning(signature, &name)), "", &[length], &number)
    });
    let gathered = signature.inputs.iter().map(gathered);
    let zero_derivatives = arguments(signature, last).into_iter().map(|(name, length)| {
        let name = format_ident!("{name}");
        quote!(#name: [0.0; #length])
    });
    let variables = signature.variables();
    let at = (last == Mode::Hessian).then(|| {
        quote! {
            /// An entry of the Hessian, of either triangle.
            ///
            /// # Panics
            /// If there is no such row or column.
            #[must_use]
            pub fn hessian_at(&self, row: usize, column: usize) -> f64 {
                self.hessian[packed_row(row.max(column)) + row.min(column)]
            }
        }
    });
    quote! {
        /// Number of variables: entries of a gradient.
        pub const VARIABLES: usize = #variables;

        /// What a kernel reads.
        #[derive(Clone, Copy, Debug)]
        pub struct Inputs<E> { #(#inputs),* }

        impl<E: Lane> Inputs<E> {
            /// Elements side by side, one in each lane.
            #[inline(always)]
            #[must_use]
            pub fn gather<'a>(of: impl Fn(usize) -> &'a Inputs<f64>) -> Self {
                Self { #(#gathered),* }
            }
        }

        #values

        /// Values of one element and their derivatives; those that were not asked for stay as they were.
        #[derive(Clone, Copy, Debug)]
        pub struct Results {
            /// Values.
            pub values: Values<f64>,
            #(#derivatives),*
        }

        impl Results {
            /// Zeros.
            pub const ZERO: Self = Self { values: Values::ZERO, #(#zero_derivatives),* };
            #at
        }
    }
}

/// The struct `Values`.
pub(super) fn value_types(signature: &Signature) -> TokenStream {
    let lane = quote!(E);
    let values = signature.values.iter().map(|v| field(&v.name, &v.doc, "A value.", &v.dimensions, &lane));
    let value_names: Vec<Ident> =
        signature.values.iter().map(|value| format_ident!("{}", value.name)).collect();
    let zeros = signature.values.iter().map(|value| array(&value.dimensions, &quote!(E::ZERO)));
    let of_lane = signature.values.iter().map(|value| {
        let name = format_ident!("{}", value.name);
        entries(&value.dimensions, &|place| quote!(self.#name #place.lane(lane)))
    });
    quote! {
        /// Values of a kernel.
        #[derive(Clone, Copy, Debug)]
        pub struct Values<E> { #(#values),* }

        impl<E: Lane> Values<E> {
            /// Zeros.
            pub const ZERO: Self = Self { #(#value_names: #zeros),* };

            /// Those of the element in a lane.
            ///
            /// # Panics
            /// If there is no such lane.
            #[inline(always)]
            #[must_use]
            pub fn lane(&self, lane: usize) -> Values<f64> {
                Values { #(#value_names: #of_lane),* }
            }
        }
    }
}

/// A field of `Inputs` from those of several elements.
pub(super) fn gathered(input: &Input) -> TokenStream {
    let name = format_ident!("{}", input.name);
    let entries = entries(&input.dimensions, &|place| quote!(E::from_fn(|lane| of(lane).#name #place)));
    quote!(#name: #entries)
}

/// An array whose entries are made from their places, `[0][2]`.
pub(super) fn entries(dimensions: &[usize], entry: &impl Fn(TokenStream) -> TokenStream) -> TokenStream {
    let all: Vec<TokenStream> = places(dimensions).into_iter().map(entry).collect();
    nested(dimensions, &all)
}

/// Places of all entries, `[0][2]`, the last dimension fastest.
pub(super) fn places(dimensions: &[usize]) -> Vec<TokenStream> {
    dimensions.iter().fold(vec![quote!()], |places, &size| {
        places.iter().flat_map(|place| (0..size).map(move |k| quote!(#place [#k]))).collect()
    })
}

/// `evaluate`, `batch` and what they need.
fn runners(signature: &Signature, last: Mode) -> TokenStream {
    let modes = &Mode::ALL[..=last as usize];
    let call = |mode: Mode, inputs: TokenStream, target: &dyn Fn(&Ident) -> TokenStream| {
        let name = function_name(mode);
        let targets =
            arguments(signature, mode).into_iter().map(|(name, _)| target(&format_ident!("{name}")));
        quote!(self::#name(#inputs, #(#targets),*))
    };
    let arms = |inputs: &TokenStream, target: &dyn Fn(&Ident) -> TokenStream| {
        let arms = modes.iter().map(|&mode| {
            let variant = match mode {
                Mode::Value => quote!(Mode::Value),
                Mode::Gradient => quote!(Mode::Gradient),
                Mode::Hessian => quote!(Mode::Hessian),
            };
            // More derivatives than there are: all there are.
            let pattern = if mode == last { quote!(_) } else { variant };
            let call = call(mode, inputs.clone(), target);
            quote!(#pattern => #call,)
        });
        quote!(#(#arms)*)
    };
    let single = arms(&quote!(inputs), &|name| quote!(&mut results.#name));
    let lanes = arms(&quote!(&lanes), &|name| quote!(&mut #name));
    let all = arguments(signature, last);
    let declared = all.iter().map(|(name, length)| {
        let name = format_ident!("{name}");
        quote!(let mut #name = [T::ZERO; #length];)
    });
    let stored = all.iter().map(|(name, _)| {
        let is_second = name == "hessian";
        let least = if is_second { quote!(Mode::Hessian) } else { quote!(Mode::Gradient) };
        let name = format_ident!("{name}");
        quote! {
            if mode >= #least {
                T::store_transposed(&#name, results, |result| &mut result.#name[..]);
            }
        }
    });
    quote! {
        /// Evaluates one element.
        #[must_use]
        pub fn evaluate(mode: Mode, inputs: &Inputs<f64>) -> Results {
            let mut results = Results::ZERO;
            results.values = match mode { #single };
            results
        }

        /// The instructions to run batches with: the widest that the machine has, or without optimisation one number at a time.
        #[must_use]
        pub fn best_isa() -> Isa {
            if OPTIMISED { Isa::best() } else { Isa::SCALAR }
        }

        /// Evaluates many elements, as many side by side as the instructions have lanes: [`best_isa`] unless there is a reason for
        /// others. What an element gets does not depend on its neighbours.
        ///
        /// # Panics
        /// If there are not as many results as inputs.
        pub fn batch(isa: Isa, mode: Mode, inputs: &[Inputs<f64>], results: &mut [Results]) {
            assert_eq!(inputs.len(), results.len(), "as many results as inputs");
            let elements = Elements { mode, inputs, results };
            // What a constant rules out is not compiled.
            if OPTIMISED {
                isa.run(elements);
            } else {
                elements.run::<f64>();
            }
        }

        struct Elements<'a> {
            mode: Mode,
            inputs: &'a [Inputs<f64>],
            results: &'a mut [Results],
        }

        impl WithLanes for Elements<'_> {
            type Output = ();

            #[inline(always)]
            fn run<T: Vector>(self) {
                let Self { mode, inputs, results } = self;
                #(#declared)*
                for (inputs, results) in inputs.chunks(T::WIDTH).zip(results.chunks_mut(T::WIDTH)) {
                    let last = inputs.len() - 1;
                    let lanes = Inputs::<T>::gather(|lane| &inputs[lane.min(last)]);
                    let values = match mode { #lanes };
                    for (lane, result) in results.iter_mut().enumerate() {
                        result.values = values.lane(lane);
                    }
                    #(#stored)*
                }
            }
        }
    }
}
