//! Kernels of fixed size: straight-line functions that read a struct, return a struct and write derivatives to arrays.

use proc_macro2::TokenStream;
use quote::{ToTokens, format_ident, quote};

use super::count::OpCounts;
use super::derivatives::{DIRECTION, arguments_of};
use super::element_kernel::function_name;
use super::function::FunctionWriter;
use crate::graph::{ExprId, NODE_COUNT, Op};
use crate::kernel::{ElementSpec, Input, Points, Signature, Value};
use crate::schedule::{Program, Statement};

/// An argument that a derivative is written to, and its number of entries.
pub(super) type Argument = (String, usize);

/// What surrounds a function's body.
pub(super) struct Head<'a> {
    spec: &'a ElementSpec,
    /// Values that are no fields of the struct that is returned.
    arguments: Vec<Argument>,
}

/// A function's pieces.
pub(super) struct Fixed {
    body: TokenStream,
    /// Operations, with one evaluation of the equations of roots.
    pub counts: OpCounts,
    /// Operations of one such evaluation.
    pub iteration: OpCounts,
    pub statements: usize,
}

impl Fixed {
    /// Writes the body.
    pub fn new(program: &Program<ElementSpec>, head: &Head<'_>) -> Self {
        let mut function = FunctionWriter::new(program);
        let arguments: Vec<&str> = head.arguments.iter().map(|(name, _)| name.as_str()).collect();
        function.writer.names.reserve(&arguments);
        if head.spec.direction.is_some() {
            function.writer.names.reserve(&[DIRECTION]);
        }
        // Constants of a module are no patterns.
        function.writer.names.reserve(&["VARIABLES", "OPTIMISED"]);

        if head.spec.signature.points.rows.is_empty() {
            return Self::straight(function, head);
        }
        function.writer.names.reserve(&["POINTS", "point", "sums", "entry"]);
        Self::summed(function, head)
    }

    fn straight(mut function: FunctionWriter<'_, ElementSpec>, head: &Head<'_>) -> Self {
        let program = function.program;
        let body: Vec<TokenStream> =
            program.phases.iter().map(|phase| function.statements(&phase.statements)).collect();
        let (derivatives, values) = head.outputs(program);
        let mut outputs = Vec::new();
        for value in derivatives {
            let name = format_ident!("{}", value.name);
            for (k, &x) in value.components.iter().enumerate() {
                let entry = function.writer.used(x);
                outputs.push(quote!(#name[#k] = #entry;));
            }
        }
        let fields = fields(&head.spec.signature, &values, |x| function.writer.used(x));
        function.counts.element += function.writer.take_counts();
        let reads = head.reads(&mut function);
        let returned = head.returned(&fields);
        Self {
            counts: function.counts.total(0),
            iteration: function.counts.iteration,
            statements: function.statements + outputs.len() + reads.len() + 1,
            body: quote! {
                #(#reads)*
                #(#body)*
                #(#outputs)*
                #returned
            },
        }
    }

    /// A loop over points, after what is the same at all of them.
    fn summed(mut function: FunctionWriter<'_, ElementSpec>, head: &Head<'_>) -> Self {
        let program = function.program;
        let points = &head.spec.signature.points;
        let (same, varying) = split(program, points);
        let before = function.statements(&same);
        let mut counts = std::mem::take(&mut function.counts.element) + function.writer.take_counts();
        let body = function.statements(&varying);
        let (outputs, fields, count) = sums(&mut function, head);
        let of_point = std::mem::take(&mut function.counts.element) + function.writer.take_counts();
        let additions = OpCounts { additions: outputs.len(), ..OpCounts::default() };
        counts += (of_point + additions).times(points.rows.len());
        // Each root counts once, as without points.
        counts += function.counts.iteration;
        let reads = head.reads(&mut function);
        let number = |k: usize| quote!(E::splat(POINTS[point][#k]));
        let point_reads = reads_by_place(&mut function, &points.symbols, number);
        let (table, count_of_points) = (table(points), points.rows.len());
        let zeros = head.arguments.iter().map(|(name, length)| {
            let name = format_ident!("{name}");
            quote!(for entry in 0..#length { #name[entry] = E::ZERO; })
        });
        let returned = head.returned(&fields);
        let sums = (count > 0).then(|| quote!(let mut sums = [E::ZERO; #count];));
        Self {
            counts,
            iteration: function.counts.iteration,
            statements: function.statements + outputs.len() + reads.len() + point_reads.len() + 4,
            body: quote! {
                #table
                #(#reads)*
                #before
                #(#zeros)*
                #sums
                for point in 0..#count_of_points {
                    #(#point_reads)*
                    #body
                    #(#outputs)*
                }
                #returned
            },
        }
    }

    /// The function.
    pub fn tokens(&self, head: &Head<'_>, documentation: &[String]) -> TokenStream {
        let name = format_ident!("{}", function_name(head.spec));
        let direction = head.spec.direction.as_ref().map(|symbols| {
            let (name, length) = (format_ident!("{DIRECTION}"), symbols.element.len());
            quote!(#name: &[E; #length],)
        });
        let returns = head.spec.direction.is_none().then(|| quote!(-> Values<E>));
        let arguments = head.arguments.iter().map(|(name, length)| {
            let name = format_ident!("{name}");
            quote!(#name: &mut [E; #length],)
        });
        let body = &self.body;
        quote! {
            #(#[doc = #documentation])*
            #[inline(always)]
            pub fn #name<E: Lane>(
                inputs: &Inputs<E>,
                #direction
                #(#arguments)*
            ) #returns {
                #body
            }
        }
    }
}

impl<'a> Head<'a> {
    pub fn new(spec: &'a ElementSpec) -> Self {
        Self { spec, arguments: arguments_of(spec) }
    }

    /// Values that are written to arguments, and the others.
    fn outputs<'k>(&self, program: &'k Program<ElementSpec>) -> (Vec<&'k Value>, Vec<&'k Value>) {
        let is_argument = |value: &&Value| self.arguments.iter().any(|(name, _)| *name == value.name);
        program.kernel.values.iter().partition(is_argument)
    }

    /// The struct that is returned, if one is.
    fn returned(&self, fields: &[TokenStream]) -> Option<TokenStream> {
        self.spec.direction.is_none().then(|| quote!(Values { #(#fields),* }))
    }

    /// `let`s for what is used of the inputs and of the vector.
    fn reads(&self, function: &mut FunctionWriter<'_, ElementSpec>) -> Vec<TokenStream> {
        let mut all = reads(function, &self.spec.signature.inputs);
        if let Some(names) = &self.spec.direction {
            let entries: Vec<TokenStream> = names.element.iter().map(|name| entry(function, name)).collect();
            let direction = format_ident!("{DIRECTION}");
            all.push(quote!(let [#(#entries),*] = *#direction;));
        }
        all
    }
}

/// Additions of a point's part to the outputs, the fields of the struct that is returned, and the number of numbers in them.
fn sums(
    function: &mut FunctionWriter<'_, ElementSpec>,
    head: &Head<'_>,
) -> (Vec<TokenStream>, Vec<TokenStream>, usize) {
    let (derivatives, values) = head.outputs(function.program);
    let mut outputs = Vec::new();
    let mut add = |to: TokenStream, x: ExprId| {
        let entry = function.writer.used(x);
        outputs.push(quote!(#to = #to + #entry;));
    };
    for value in derivatives {
        let name = format_ident!("{}", value.name);
        value.components.iter().enumerate().for_each(|(k, &x)| add(quote!(#name[#k]), x));
    }
    let mut count = 0_usize;
    let fields = fields(&head.spec.signature, &values, |x| {
        let to = quote!(sums[#count]);
        count += 1;
        add(to.clone(), x);
        to
    });
    (outputs, fields, count)
}

/// Statements whose values are the same at all points, and the others.
pub(super) fn split<S>(program: &Program<S>, points: &Points) -> (Vec<Statement>, Vec<Statement>) {
    let graph = &program.kernel.graph;
    let mut varies: Vec<bool> = Vec::with_capacity(graph.len());
    // Operands come before what is made of them.
    for k in 0..graph.len() {
        let expr = ExprId(k as u32);
        let own = match graph.op(expr) {
            Op::Symbol(symbol) => points.symbols.contains(&graph.symbol_data(symbol).name),
            _ => false,
        };
        varies.push(own || graph.dependencies(expr).iter().any(|x| varies[x.index()]));
    }
    let statements = program.phases.iter().flat_map(|phase| phase.statements.iter().copied());
    statements.partition(|statement| match statement {
        Statement::Let(expr) => !varies[expr.index()],
        Statement::Solve(root) => !graph.dependencies_of_root(*root).iter().any(|x| varies[x.index()]),
    })
}

/// The points as a constant.
fn table(points: &Points) -> TokenStream {
    let (count, columns) = (points.rows.len(), points.symbols.len());
    let rows = points.rows.iter().map(|row| quote!([#(#row),*]));
    quote!(const POINTS: [[f64; #columns]; #count] = [#(#rows),*];)
}

/// `let`s for those of some symbols that are used, from their places.
pub(super) fn reads_by_place<S>(
    function: &mut FunctionWriter<'_, S>,
    names: &[String],
    number: impl Fn(usize) -> TokenStream,
) -> Vec<TokenStream> {
    let program = function.program;
    let used = names.iter().enumerate().filter_map(|(k, name)| Some((number(k), program.symbol(name)?)));
    used.map(|(number, expr)| {
        let name = function.writer.ident(expr);
        quote!(let #name = #number;)
    })
    .collect()
}

/// `let`s for the inputs that are used.
fn reads<S>(function: &mut FunctionWriter<'_, S>, fields: &[Input]) -> Vec<TokenStream> {
    let mut all = Vec::new();
    for input in fields {
        if input.symbols.iter().all(|name| function.program.symbol(name).is_none()) {
            continue;
        }
        let entries: Vec<TokenStream> = input.symbols.iter().map(|name| entry(function, name)).collect();
        let (pattern, field) = (nested(&input.dimensions, &entries), format_ident!("{}", input.name));
        all.push(quote!(let #pattern = inputs.#field;));
    }
    all
}

/// The identifier of a symbol, `_` if it is not used.
pub(super) fn entry<S>(function: &mut FunctionWriter<'_, S>, name: &str) -> TokenStream {
    match function.program.symbol(name) {
        Some(expr) => function.writer.ident(expr).to_token_stream(),
        None => quote!(_),
    }
}

/// `let`s for the inputs that are used, and for the number of nodes where it is one.
pub(super) fn reads_and_count<S>(function: &mut FunctionWriter<'_, S>, fields: &[Input]) -> Vec<TokenStream> {
    let mut reads = reads(function, fields);
    if function.program.kernel.graph.has_input(NODE_COUNT) {
        reads.push(quote!(let node_count = E::splat(count as f64);));
    }
    reads
}

/// Fields of the struct `Values`; `component` writes a component of one.
pub(super) fn fields(
    signature: &Signature,
    values: &[&Value],
    mut component: impl FnMut(ExprId) -> TokenStream,
) -> Vec<TokenStream> {
    let field = |value: &&Value| {
        let name = format_ident!("{}", value.name);
        let components: Vec<TokenStream> = value.components.iter().map(|&x| component(x)).collect();
        let returned = signature.values.iter().find(|returned| returned.name == value.name);
        let whole = nested(returned.map_or(&[], |returned| &returned.dimensions), &components);
        quote!(#name: #whole)
    };
    values.iter().map(field).collect()
}

/// `[[a, b], [c, d]]` of entries in order, the last dimension fastest.
pub(super) fn nested(dimensions: &[usize], entries: &[TokenStream]) -> TokenStream {
    let Some((&count, inner)) = dimensions.split_first() else { return quote!(#(#entries)*) };
    let parts =
        entries.chunks(entries.len().checked_div(count).unwrap_or(0).max(1)).map(|part| nested(inner, part));
    quote!([#(#parts),*])
}

/// `[[E; 3]; 4]`
pub(super) fn array(dimensions: &[usize], of: &TokenStream) -> TokenStream {
    dimensions.iter().rev().fold(of.clone(), |inner, count| quote!([#inner; #count]))
}
