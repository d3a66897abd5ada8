//! Kernels of elements with nodes of a number that is open, in C.

use std::fmt::Write as _;

use super::super::derivatives::{DIRECTION, Derivative};
use super::super::element::{scheduled, write_element_kernel};
use super::super::element_kernel::{function_name, title};
use super::super::node_element::Scratch;
use super::writer::{Access, Writer};
use super::{comment, field, inputs_of, lanes, places, structure, values_of};
use crate::graph::{ExprId, NODE_COUNT, NODE_INDEX, Op};
use crate::kernel::{DirectionSymbols, ElementKernels, ElementSpec, NodeResult};
use crate::schedule::{NodeLoop, NodeTarget, Program};

/// Names of the surrounding code.
const RESERVED: [&str; 10] =
    ["nodes", "node", "scratch", "form", "first", "elements", "start", "lanes", "lane", "shared"];

/// How many elements a function takes at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Width {
    /// One, whose numbers stand one after another.
    One,
    /// Several, whose numbers stand side by side.
    Lanes,
}

impl Width {
    /// An entry of an array of the caller's.
    pub fn entry(self, array: &str, index: &str) -> String {
        match self {
            Self::One => format!("{array}[{index}]"),
            Self::Lanes => format!("{array}[({index}) * elements + lane]"),
        }
    }

    /// An entry of the scratch, or of a part of it.
    fn scratch(self, array: &str, index: &str) -> String {
        match self {
            Self::One => format!("{array}[{index}]"),
            Self::Lanes => format!("{array}[({index}) * DIFFUSE_CONTACT_LANES + lane]"),
        }
    }

    /// The index of an input of node scope, by its field and number.
    fn node(self, field: &str, number: usize, fields: usize) -> String {
        match self {
            Self::One => format!("nodes[node].{field}"),
            Self::Lanes => self.entry("nodes", &format!("{fields} * node + {number}")),
        }
    }
}

/// Types and kernels of an element.
pub(super) fn element(element: &ElementKernels) -> String {
    let signature = &element.signature;
    let (name, upper) = (&signature.name, signature.name.to_uppercase());
    let mut text = format!("\n{}\n", comment(&title(signature)));
    if signature.inputs.is_empty() {
        let _ = writeln!(text, "typedef struct {{\n    char none;\n}} {name}_inputs;");
    } else {
        text += &structure(&format!("{name}_inputs"), inputs_of(&signature.inputs));
    }
    text += &structure(&format!("{name}_node"), inputs_of(&signature.nodes));
    text += &structure(&format!("{name}_values"), values_of(&signature.values));
    let (of_element, of_node) = (signature.variables(), signature.node_variables());
    let mut sizes =
        vec![format!("{upper}_VARIABLES = {of_element}"), format!("{upper}_NODE_VARIABLES = {of_node}")];
    let programs: Vec<Program<ElementSpec>> =
        element.kernels.iter().chain(&element.product).map(scheduled).collect();
    sizes.extend(programs.iter().map(|program| {
        format!("{} = {}", scratch_of(&program.kernel.spec), Scratch::new(program).per_node())
    }));
    let _ = writeln!(text, "enum {{ {} }};", sizes.join(", "));
    text + &programs.iter().map(kernel_text).collect::<String>()
}

/// Name of the scratch's size.
fn scratch_of(spec: &ElementSpec) -> String {
    format!("{}_{}_SCRATCH", spec.signature.name, function_name(spec)).to_uppercase()
}

/// All functions of a kernel.
fn kernel_text(program: &Program<ElementSpec>) -> String {
    let spec = &program.kernel.spec;
    let (name, mode_name) = (&spec.signature.name, function_name(spec));
    let derivatives = Derivative::names(spec);
    let parameters: String = derivatives.iter().map(|name| format!(", double *{name}")).collect();
    let emitted = write_element_kernel(program);
    let [per_node, per_pair] = emitted.per_node.map(|counts| counts.total());
    let scratch = scratch_of(spec);
    let second = match spec.direction {
        Some(_) => format!("const double *{DIRECTION}"),
        None => format!("{name}_values *values"),
    };
    let mut text = format!(
        "\n/* One element: {mode_name}. Variables are those of the element, then those of the nodes, node by node; Hessians are packed \
         lower triangles. scratch: {scratch} numbers for each node. Operations: {} + {per_node} n + {per_pair} n(n-1)/2. */\n",
        emitted.counts.total()
    );
    let _ = writeln!(
        text,
        "static inline void {name}_{mode_name}(size_t count, const {name}_inputs *inputs, const {name}_node *nodes, {second}\
         {parameters}, double *scratch) {{"
    );
    text += &body(program);
    text += "}\n";

    text + &lanes::functions(program, &derivatives, &scratch)
}

/// The body for one element.
fn body(program: &Program<ElementSpec>) -> String {
    let ElementSpec { signature, .. } = &program.kernel.spec;
    let input = |name: &str, place: &str, _: usize| format!("inputs->{}{place}", field(name));
    let value = |name: &str, place: &str, _: usize| format!("values->{}{place}", field(name));
    let (of_element, of_node) = (signature.variables(), signature.node_variables());
    let derivatives = Derivative::of(&program.kernel.spec);
    let derivative = |name: &str, k: usize| derivative_place(Width::One, &derivatives, (name, k), program);
    let direction = |k: usize| Width::One.entry(DIRECTION, &k.to_string());
    let access = Access { input: &input, direction: &direction, value: &value, derivative: &derivative };
    let mut writer = writer(program, &access);
    let scratch = Scratch::new(program);

    let mut text = "    (void)inputs;\n    (void)nodes;\n    (void)scratch;\n".to_owned();
    if scratch.form > 0 {
        let _ = writeln!(text, "    double *const form = scratch + {} * count;", scratch.kept);
    }
    text += &node_count(&mut writer);
    text += &writer.reads("    ");
    for phase in &program.phases {
        text += &writer.lets("    ", &phase.statements);
        text += &node_loop(&mut writer, &phase.nodes, scratch);
    }
    text += &writer.outputs("    ", "=");
    if scratch.form > 0 {
        let _ = writeln!(
            text,
            "    diffuse_contact_multiply_rows({of_element}, {of_node}, {}, count, form, hessian);",
            scratch.products
        );
    }
    text
}

/// Writes a function with names of the surrounding code taken.
pub(super) fn writer<'a>(program: &'a Program<ElementSpec>, access: &'a Access<'a>) -> Writer<'a> {
    let mut writer = Writer::new(program, access);
    writer.names.reserve(&RESERVED);
    writer
}

/// Where an entry of a derivative by variables of the element stands.
pub(super) fn derivative_place(
    width: Width,
    derivatives: &[Derivative],
    (name, k): (&str, usize),
    program: &Program<ElementSpec>,
) -> String {
    let signature = &program.kernel.spec.signature;
    let (of_element, of_node) = (signature.variables(), signature.node_variables());
    let derivative = derivatives.iter().find(|derivative| derivative.name == name);
    match derivative.and_then(|derivative| derivative.later_row(k, of_element)) {
        Some([row, column]) => {
            width.entry(name, &format!("{row} * ({of_element} + {of_node} * count) + {column}"))
        }
        None => width.entry(name, &k.to_string()),
    }
}

/// The number of nodes, where it is used.
pub(super) fn node_count(writer: &mut Writer<'_>) -> String {
    let count = writer.program.symbol(NODE_COUNT);
    count.map_or_else(String::new, |count| writer.read("    ", count, "(double)count"))
}

/// The number of a node, where it is used.
pub(super) fn node_index(writer: &mut Writer<'_>, nodes: &NodeLoop) -> Option<(ExprId, String)> {
    let program = writer.program;
    let expr = program.loop_reads(nodes, NODE_INDEX).then(|| program.node_input(NODE_INDEX))??;
    Some((expr, writer.read("        ", expr, "(double)node")))
}

fn node_loop(writer: &mut Writer<'_>, nodes: &NodeLoop, scratch: Scratch) -> String {
    if nodes.is_empty() {
        return String::new();
    }
    let (indent, mut text) = ("        ", String::new());
    for &sum in &nodes.sums {
        let _ = writeln!(text, "    double {} = 0.0;", writer.name(sum));
    }
    text += "    for (size_t node = 0; node < count; node++) {\n";
    text += &node_reads(writer, nodes, Width::One, indent);
    text += &node_index(writer, nodes).map_or_else(String::new, |(_, text)| text);
    text += &node_loads(writer, nodes, (Width::One, scratch), indent);
    text += &writer.lets(indent, &nodes.statements);
    for (sum, term) in terms(writer, nodes) {
        let _ = writeln!(text, "{indent}{} += {term};", writer.name(sum));
    }
    text += &results(writer, nodes, (Width::One, scratch), indent);
    text += &node_stores(writer, nodes, (Width::One, scratch), indent);
    text + "    }\n"
}

/// What is read of a node.
pub(super) fn node_reads(writer: &mut Writer<'_>, nodes: &NodeLoop, width: Width, indent: &str) -> String {
    let program = writer.program;
    let ElementSpec { signature, direction, .. } = &program.kernel.spec;
    let fields: usize = signature.nodes.iter().map(|input| input.symbols.len()).sum();
    let read = |symbol: &str| program.loop_reads(nodes, symbol).then(|| program.node_input(symbol))?;
    let inputs = signature.nodes.iter().flat_map(|input| {
        let places = places(&input.dimensions).into_iter();
        input.symbols.iter().zip(places.map(|place| format!("{}{place}", field(&input.name))))
    });
    let inputs = inputs
        .enumerate()
        .map(|(number, (symbol, place))| (read(symbol), width.node(&place, number, fields)));
    let direction = direction.iter().flat_map(|DirectionSymbols { element, node }| {
        let place = |k: usize| format!("{} + {} * node", element.len() + k, node.len());
        node.iter().enumerate().map(move |(k, symbol)| (symbol, width.entry(DIRECTION, &place(k))))
    });
    let direction = direction.map(|(symbol, place)| (read(symbol), place));
    writer.reads_from(indent, inputs.chain(direction))
}

/// Where a value of a node is kept.
fn kept_place(writer: &Writer<'_>, x: ExprId, (width, scratch): (Width, Scratch)) -> String {
    let place = writer.program.place(x);
    width.scratch("scratch", &format!("{} * node + {place}", scratch.kept))
}

/// What earlier loops kept of a node.
pub(super) fn node_loads(
    writer: &mut Writer<'_>,
    nodes: &NodeLoop,
    at: (Width, Scratch),
    indent: &str,
) -> String {
    let mut text = String::new();
    for &load in &nodes.loads {
        let place = kept_place(writer, load, at);
        text += &writer.read(indent, load, &place);
    }
    text
}

/// What later loops need of a node.
pub(super) fn node_stores(
    writer: &mut Writer<'_>,
    nodes: &NodeLoop,
    at: (Width, Scratch),
    indent: &str,
) -> String {
    let mut text = String::new();
    for &store in &nodes.stores {
        let _ = writeln!(text, "{indent}{} = {};", kept_place(writer, store, at), writer.name(store));
    }
    text
}

/// The sums of a loop, and what a node adds to them.
pub(super) fn terms(writer: &mut Writer<'_>, nodes: &NodeLoop) -> Vec<(ExprId, String)> {
    let graph = &writer.program.kernel.graph;
    let term = |&sum: &ExprId| match graph.op(sum) {
        Op::Sum(term) => Some((sum, writer.operand(term).0)),
        _ => None,
    };
    nodes.sums.iter().filter_map(term).collect()
}

/// Results of a loop.
pub(super) fn results(
    writer: &mut Writer<'_>,
    nodes: &NodeLoop,
    (width, scratch): (Width, Scratch),
    indent: &str,
) -> String {
    let spec = &writer.program.kernel.spec;
    let (of_element, of_node) = (spec.signature.variables(), spec.signature.node_variables());
    let all = format!("({of_element} + {of_node} * count)");
    let first = format!("{of_element} + {of_node} * node");
    let mut text = String::new();
    for (target, values) in &nodes.outputs {
        let NodeTarget::Value { value } = *target else { unreachable!("values of nodes only") };
        let x = writer.operand(values[0]).0;
        let form = |place: usize| width.scratch("form", &format!("{} * node + {place}", scratch.form));
        let to = match &spec.node_results[value] {
            NodeResult::First { argument, row: 0, component } => {
                width.entry(argument, &format!("{first} + {component}"))
            }
            NodeResult::First { argument, row, component } => {
                width.entry(argument, &format!("{row} * {all} + {first} + {component}"))
            }
            NodeResult::Mixed { component, variable } => width
                .entry("hessian", &format!("diffuse_contact_packed_row({first} + {component}) + {variable}")),
            NodeResult::Row { row, component } => form(of_node * row + component),
            NodeResult::Own { place } => form(2 * scratch.products * of_node + place),
        };
        let _ = writeln!(text, "{indent}{to} = {x};");
    }
    text
}
