//! The kernels of the diffuse element: what surrounds their segments and loops.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::count::{KernelCounts, OpCounts};
use super::function::FunctionWriter;
use super::node_loop::{NodeArray, Outputs};
use crate::graph::{ExprId, NODE_COUNT};
use crate::lower::lower;
use crate::model::{
    CHECKSUM, DOMAIN_RATIO, FrameRule, Kernel, KernelSpec, MATERIAL_INPUTS, MOST_COEFFICIENTS, Mode, Output,
    PLANE_REACH, WEIGHT_NUMBER,
};
use crate::schedule::{FormRows, NodeTarget, Program};

/// A kernel's source.
#[derive(Clone, Debug)]
pub struct EmittedKernel {
    /// What it is.
    pub spec: KernelSpec,
    /// The function, and the module with the places of node values.
    pub tokens: TokenStream,
    /// Operation counts.
    pub counts: KernelCounts,
    /// Statements of the function.
    pub statements: usize,
    /// Rows of the first Hessian's form, if there is one: those that differ between nodes, and those that are the same for all.
    pub form: Option<[usize; 2]>,
}

/// Lowers, schedules and writes a kernel.
#[must_use]
pub fn emit_kernel(spec: &KernelSpec) -> EmittedKernel {
    let program = Program::new(lower(&Kernel::new(spec.clone())));
    FunctionWriter::new(&program).write()
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
        FrameRule::Frozen => "",
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

/// Name of the module with the places of a kernel's values per node.
pub(super) fn kept_name(spec: &KernelSpec) -> Ident {
    format_ident!("{}_kept", function_name(spec))
}

const AXES: [&str; 3] = ["x", "y", "z"];
/// Inputs of node scope, in the order of `support::NODE_VALUES`.
const NODE_INPUTS: [&str; 4] = ["master_x", "master_y", "master_z", DOMAIN_RATIO];

/// Arrays of nodes.
fn arrays() -> [NodeArray<'static>; 2] {
    let array = |name, symbols: Vec<&'static str>| {
        let all = symbols.clone();
        let pattern = move |used: &dyn Fn(&str) -> Option<Ident>| {
            let names = all.iter().map(|name| used(name).unwrap_or_else(|| format_ident!("_")));
            quote!([#(#names),*])
        };
        NodeArray { name, symbols, pattern: Box::new(pattern) }
    };
    [array("masters", NODE_INPUTS.to_vec()), array("material", MATERIAL_INPUTS.to_vec())]
}

impl FunctionWriter<'_> {
    fn write(mut self) -> EmittedKernel {
        let spec = &self.program.kernel.spec;
        let inputs = self.inputs();
        let arrays = arrays();
        let phases: Vec<TokenStream> = (0..self.program.phases.len())
            .map(|k| self.phase(k, &arrays, |function, outputs| function.node_outputs(outputs)))
            .collect();
        let outputs = self.element_outputs();
        let combinations = self.combinations();
        let updates = self.updates();
        let values = self.values();
        let kept = self.program.kept();
        let kept_module = self.kept_module(&kept);

        let function = function_name(spec);
        let returned = values_name(spec.output);
        let documentation = self.documentation();
        let has_gradients = !self.program.kernel.gradients.is_empty();
        let has_hessians = !self.program.kernel.hessians.is_empty();
        let gradients = has_gradients.then(|| quote!(gradients: &mut [S::Output],));
        let second = has_hessians.then(|| quote!(mut second: Second<'_, S::Output>,));
        let nodes = if kept.is_empty() && !has_hessians {
            quote!(let _ = scratch;)
        } else {
            let kept = kept_name(spec);
            // The forms have the scratch of one vector of nodes more, for the slave's rows, which the multiplication sums.
            let split = if has_hessians {
                quote!(let (scratch, forms) = scratch.split_at_mut(at::PLACES * inputs.masters.len());)
            } else {
                quote!()
            };
            quote! {
                use #kept as at;
                #split
                let nodes = &mut scratch.as_chunks_mut::<{ at::PLACES }>().0[..inputs.masters.len()];
            }
        };
        let forms = self.forms();
        let many_gradients = self.program.kernel.gradients.len() > 1;
        let freedoms = many_gradients.then(|| quote!(let freedoms = 3 * (count + 1);));
        let tokens = quote! {
            #kept_module

            #(#[doc = #documentation])*
            #[inline(always)]
            pub fn #function<E: Lane, T: Lane, S: Shape<Element = E, Node = T>>(
                inputs: &Inputs<'_, E, T>,
                scratch: &mut [T],
                #gradients
                #second
            ) -> #returned<E> {
                #nodes
                let count = inputs.count;
                #freedoms
                #forms
                #inputs
                #(#phases)*
                #outputs
                #combinations
                #updates
                #values
            }
        };
        let form = self.program.forms.first().map(|rows| [rows.varying.len(), rows.constant.len()]);
        EmittedKernel { spec: spec.clone(), tokens, counts: self.counts, statements: self.statements, form }
    }

    /// `let`s for the inputs of element scope.
    fn inputs(&mut self) -> TokenStream {
        let mut arrays = Vec::new();
        for (field, prefix) in [("slave", "slave"), ("t1", "t1"), ("t2", "t2"), ("normal", "normal")] {
            let field = format_ident!("{field}");
            let names = AXES.map(|axis| format_ident!("{prefix}_{axis}"));
            arrays.push(quote!(let [#(#names),*] = inputs.#field;));
        }
        if self.program.kernel.spec.output == Output::Surface {
            arrays.push(quote!(let [point_1, point_2] = inputs.point;));
        }
        for name in ["pole", WEIGHT_NUMBER, PLANE_REACH] {
            if self.program.kernel.graph.has_input(name) {
                let name = format_ident!("{name}");
                arrays.push(quote!(let #name = inputs.#name;));
            }
        }
        if self.program.kernel.spec.output == Output::Slip {
            let names = AXES.map(|axis| format_ident!("anchor_{axis}"));
            arrays.push(quote!(let [#(#names),*] = inputs.anchor;));
        }
        if self.program.kernel.graph.has_input(NODE_COUNT) {
            arrays.push(quote!(let node_count = E::splat(count as f64);));
        }
        self.statements += arrays.len() + 1;
        quote! {
            #(#arrays)*
            let support_radius = inputs.support_radius;
        }
    }

    /// Writes the results of a loop, if it has any.
    fn node_outputs(&mut self, outputs: &Outputs) -> Option<TokenStream> {
        if outputs.is_empty() {
            return None;
        }
        let outputs = outputs.iter().map(|(target, values)| {
            let values: Vec<TokenStream> = values.iter().map(|&x| self.writer.used(x)).collect();
            match *target {
                NodeTarget::Gradient { gradient } => {
                    let offset = times_offset(gradient, &quote!(freedoms));
                    quote!(S::write_nodes([#(#values),*], vector, &mut gradients[#offset 3..#offset 3 * count + 3]);)
                }
                NodeTarget::Row { hessian, row } => {
                    let (form, rows) = (form_name(hessian), rows_name(hessian));
                    quote!(S::keep_row(#form, #rows, #row, vector, [#(#values),*]);)
                }
                NodeTarget::Value { value } => {
                    let (offset, size) = (self.node_value_offset(), quote!(count));
                    let offset = match times_offset(value, &size) {
                        none if none.is_empty() => offset,
                        further => quote!(#further #offset),
                    };
                    quote!(S::write_values(#(#values)*, vector, &mut gradients[#offset..#offset + count]);)
                }
                NodeTarget::Own { hessian } => {
                    let (form, rows) = (form_name(hessian), rows_name(hessian));
                    quote!(S::keep_own(#form, #rows, vector, [#(#values),*]);)
                }
            }
        });
        let outputs: Vec<TokenStream> = outputs.collect();
        Some(quote!(#(#outputs)*))
    }

    /// Places for the Hessians' forms.
    fn forms(&mut self) -> Option<TokenStream> {
        if self.program.forms.is_empty() {
            return None;
        }
        let forms = self.program.forms.iter().enumerate().map(|(hessian, rows)| {
            let (form, name) = (form_name(hessian), rows_name(hessian));
            let (varying, constant) = (rows.varying.len(), rows.constant.len());
            let point = rows.point.is_some().then(|| quote!(: count + 1));
            quote! {
                let #name = FormRows { varying: #varying, constant: #constant, count #point };
                let (#form, forms) = forms.split_at_mut(S::form_length(#name));
            }
        });
        let forms: Vec<TokenStream> = forms.collect();
        self.statements += 2 * forms.len() + 2;
        Some(quote! {
            let forms = S::outputs(forms);
            #(#forms)*
            let _ = forms;
        })
    }

    /// Finishes the forms of the Hessians: as products, or as they are.
    fn updates(&mut self) -> TokenStream {
        let program = self.program;
        let updates = program.forms.iter().enumerate().map(|(hessian, rows)| {
            let (form, name) = (form_name(hessian), rows_name(hessian));
            let mut row = |x: &[ExprId; 3]| {
                let entries = x.map(|x| self.writer.used(x));
                quote!([#(#entries),*])
            };
            let constant: Vec<TokenStream> = rows.constant.iter().map(&mut row).collect();
            let (per_node, per_pair) = form_counts(rows);
            self.counts.node += per_node;
            self.counts.pair += per_pair;
            let not_finite = not_finite_name(hessian);
            let mut point = TokenStream::new();
            if let Some((c, own)) = &rows.point {
                let c = c.iter().enumerate().map(|(k, c)| {
                    let (place, entries) = (2 * k, row(c));
                    quote!(S::keep_point_rows(#form, #name, #place, [E::ZERO; 3], #entries);)
                });
                let c: Vec<TokenStream> = c.collect();
                let own = own.map(|x| self.writer.used(x));
                point = quote!(#(#c)* S::keep_point_own(#form, #name, [#(#own),*]););
            }
            quote! {
                #point
                let #not_finite = S::finish_form(
                    #form,
                    #name,
                    &[#(#constant),*],
                    &mut second,
                );
            }
        });
        let updates: Vec<TokenStream> = updates.collect();
        self.counts.element += self.writer.take_counts();
        self.statements += updates.len();
        quote!(#(#updates)*)
    }

    /// What is combined from the first Hessian's rows, if it is asked for. Its operations are not counted.
    fn combinations(&mut self) -> Option<TokenStream> {
        let program = self.program;
        let (statements, combinations) = &program.combinations;
        if combinations.is_empty() {
            return None;
        }
        let body = self.statements(statements);
        let coefficients: Vec<TokenStream> =
            combinations.iter().flatten().map(|&x| self.writer.used(x)).collect();
        let normal = AXES.map(|axis| format_ident!("normal_{axis}"));
        self.statements += coefficients.len() + normal.len();
        let _ = self.writer.take_counts();
        Some(quote! {
            if second.kind() == SecondKind::FactorsAndFoot {
                #body
                let foot = [#(#coefficients,)* #(#normal),*];
                let target = second.last(foot.len());
                for k in 0..foot.len() {
                    target[k] = S::element_output(foot[k]);
                }
            }
        })
    }

    /// The slave's parts of gradients.
    fn element_outputs(&mut self) -> TokenStream {
        let kernel = &self.program.kernel;
        let mut all = Vec::new();
        for (k, (_, gradient)) in kernel.gradients.iter().enumerate() {
            let offset = times_offset(k, &quote!(freedoms));
            for (axis, &x) in gradient.slave.iter().enumerate() {
                let value = self.writer.used(x);
                all.push(quote!(gradients[#offset #axis] = S::element_output(#value);));
            }
            for (axis, &x) in gradient.point.iter().flatten().enumerate() {
                let value = self.writer.used(x);
                all.push(quote!(gradients[#offset freedoms + #axis] = S::element_output(#value);));
            }
        }
        self.counts.element += self.writer.take_counts();
        self.statements += all.len();
        quote!(#(#all)*)
    }

    fn values(&mut self) -> TokenStream {
        let kernel = &self.program.kernel;
        let name = values_name(kernel.spec.output);
        let fields: Vec<TokenStream> = kernel
            .values
            .iter()
            .map(|value| {
                let field = format_ident!("{}", value.name);
                let components: Vec<TokenStream> =
                    value.components.iter().map(|&x| self.writer.used(x)).collect();
                if !value.is_array {
                    // What the Hessians' forms say of the entries they wrote.
                    let forms = if value.name == CHECKSUM { kernel.hessians.len() } else { 0 };
                    let not_finite = (0..forms).map(not_finite_name);
                    return quote!(#field: #(#components)* #(+ #not_finite)*);
                }
                // A basis leaves the coefficients of the largest one that it does not have at zero.
                let missing =
                    if value.name == "coefficients" { MOST_COEFFICIENTS - components.len() } else { 0 };
                let zeros = std::iter::repeat_n(quote!(E::ZERO), missing);
                let components = components.into_iter().chain(zeros);
                quote!(#field: [#(#components),*])
            })
            .collect();
        let held = kernel.spec.output.has_gap() && kernel.spec.frame == FrameRule::Frozen;
        let held = held.then(|| quote!(plane_pivot_ratio: E::ONE,));
        let sticks = (kernel.spec.output == Output::Gap).then(|| quote!(slip: E::ZERO,));
        self.counts.element += self.writer.take_counts();
        quote!(#name { #held #sticks #(#fields),* })
    }

    /// Where values of nodes begin among the gradients: after them.
    fn node_value_offset(&self) -> TokenStream {
        let kernel = &self.program.kernel;
        let gradients = proc_macro2::Literal::usize_unsuffixed(kernel.gradients.len());
        let points = kernel.gradients.iter().filter(|(_, gradient)| gradient.point.is_some()).count();
        let points = 3 * points;
        quote!(#gradients * freedoms + #points)
    }

    fn kept_module(&mut self, kept: &[ExprId]) -> TokenStream {
        let name = kept_name(&self.program.kernel.spec);
        let places: Vec<Ident> = kept.iter().map(|&x| self.writer.place(x)).collect();
        let indices = 0..kept.len();
        let places_count = kept.len();
        // x, y and z of the rows, and room for a node's own block.
        let forms = self.program.forms.iter().map(|rows| {
            let numbers = 3 * (rows.varying.len() + rows.constant.len());
            quote!(+ #numbers + super::FormRows::OWN)
        });
        let doc = format!(
            " Places of what `{}` keeps of a node between its loops.",
            function_name(&self.program.kernel.spec)
        );
        quote! {
            #[doc = #doc]
            pub mod #name {
                #(pub(super) const #places: usize = #indices;)*
                pub(super) const PLACES: usize = #places_count;
                /// Number of values, those of the Hessian's form included.
                pub const COUNT: usize = PLACES #(#forms)*;
            }
        }
    }

    fn documentation(&self) -> Vec<String> {
        let kernel = &self.program.kernel;
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
            kept_name(spec)
        ));
        if !kernel.gradients.is_empty() {
            let names: Vec<&str> = kernel.gradients.iter().map(|(name, _)| *name).collect();
            lines.push(format!(" `gradients`: {} × 3(n+1) entries, of {}.", names.len(), names.join(", ")));
            if spec.output == Output::Slip {
                lines.push(" Those of the slip are 3(n+2), the anchor's last; then the nodes' weights in the foot, n.".to_owned());
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
        let c = &self.counts;
        let formula = |counts: &OpCounts| counts.total();
        lines.push(format!(
            " Operations: {} + {} n + {} n(n−1)/2, and {} for each Newton iteration.",
            formula(&c.element),
            formula(&c.node),
            formula(&c.pair),
            formula(&c.iteration),
        ));
        if !kernel.gradients.is_empty() {
            lines.push(String::new());
            lines.push(" # Panics".to_owned());
            lines.push(" If a slice is shorter than stated.".to_owned());
        }
        lines
    }
}

fn form_name(hessian: usize) -> Ident {
    format_ident!("form_{hessian}")
}

fn not_finite_name(hessian: usize) -> Ident {
    format_ident!("form_{hessian}_not_finite")
}

fn rows_name(hessian: usize) -> Ident {
    format_ident!("form_rows_{hessian}")
}

/// Operations of a form's products: per node, with the slave and with itself, and per pair of nodes.
fn form_counts(rows: &FormRows) -> (OpCounts, OpCounts) {
    let products = 9 * rows.varying.len();
    // The diagonal block is symmetric: half the products, twice, and the own block added.
    let fused = products + 3 * rows.varying.len() + 6;
    // The slave's rows and its own block are sums over the nodes.
    let additions = 3 * rows.varying.len() + 6;
    let node = OpCounts { fused, additions, ..OpCounts::default() };
    (node, OpCounts { fused: products, ..OpCounts::default() })
}

/// `k * size +`, or nothing for k = 0.
fn times_offset(k: usize, size: &TokenStream) -> TokenStream {
    match k {
        0 => TokenStream::new(),
        1 => quote!(#size +),
        _ => quote!(#k * #size +),
    }
}
