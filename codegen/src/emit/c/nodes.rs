//! Kernels of elements with nodes of a number that is open, in C.

use std::fmt::Write as _;

use super::super::element::title;
use super::super::node_element::Scratch;
use super::super::node_module::arguments;
use super::writer::{Access, Writer};
use super::{field, inputs_of, places, structure, values_of};
use crate::graph::{NODE_COUNT, NODE_INDEX, Op};
use crate::lower::lower;
use crate::model::{ElementKernels, ElementSpec, Kernel, Mode, NodeResult};
use crate::schedule::{NodeLoop, NodeTarget, Program};

/// Names of the surrounding code.
const RESERVED: [&str; 6] = ["nodes", "node", "scratch", "form", "first", "elements"];

/// Types and kernels of an element.
pub(super) fn element(element: &ElementKernels) -> String {
    let signature = &element.signature;
    let (name, upper) = (&signature.name, signature.name.to_uppercase());
    let mut text = format!("\n/* {} */\n", title(signature));
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
        element.kernels.iter().map(|kernel| Program::new(lower(kernel))).collect();
    sizes.extend(programs.iter().map(|program| {
        let mode = program.kernel.spec.mode.name().to_uppercase();
        format!("{upper}_{mode}_SCRATCH = {}", Scratch::new(program).per_node())
    }));
    let _ = writeln!(text, "enum {{ {} }};", sizes.join(", "));
    for (program, kernel) in programs.iter().zip(&element.kernels) {
        text += &kernel_text(program, kernel);
    }
    text
}

/// Both functions of a kernel.
fn kernel_text(program: &Program<ElementSpec>, kernel: &Kernel<ElementSpec>) -> String {
    let ElementSpec { signature, mode, .. } = &program.kernel.spec;
    let (name, mode_name, upper) = (&signature.name, mode.name(), signature.name.to_uppercase());
    let derivatives = arguments(signature, *mode);
    let parameters: String = derivatives.iter().map(|name| format!(", double *{name}")).collect();
    let emitted = super::super::emit_element_kernel(kernel);
    let [per_node, per_pair] = emitted.per_node.map(|counts| counts.total());
    let scratch = format!("{upper}_{}_SCRATCH", mode_name.to_uppercase());
    let mut text = format!(
        "\n/* One element: {mode_name}. Variables are those of the element, then those of the nodes, node by node; Hessians are packed \
         lower triangles. scratch: {scratch} numbers for each node. Operations: {} + {per_node} n + {per_pair} n(n-1)/2. */\n",
        emitted.counts.total()
    );
    let _ = writeln!(
        text,
        "static inline void {name}_{mode_name}(size_t count, const {name}_inputs *inputs, const {name}_node *nodes, {name}_values *values\
         {parameters}, double *scratch) {{"
    );
    text += &body(program, &derivatives);
    text += "}\n";

    let _ = writeln!(
        text,
        "\n/* Many elements with as many nodes each: {mode_name}. Arrays have one element after another, scratch is for one. */"
    );
    let _ = writeln!(
        text,
        "static inline void {name}_{mode_name}_batch(size_t elements, size_t count, const {name}_inputs *inputs, const {name}_node *nodes, \
         {name}_values *values{parameters}, double *scratch) {{"
    );
    let all = format!("({upper}_VARIABLES + {upper}_NODE_VARIABLES * count)");
    if *mode > Mode::Value {
        let _ = writeln!(text, "    const size_t variables = {all};");
    }
    let targets: String = derivatives
        .iter()
        .map(|name| {
            let length = match name.strip_suffix("_jacobian") {
                Some(value) => {
                    let value = signature.values.iter().find(|returned| returned.name == value);
                    let rows: usize = value.map_or(1, |value| value.dimensions.iter().product());
                    format!("{rows} * variables")
                }
                None if name == "hessian" => "diffuse_contact_packed_row(variables)".to_owned(),
                None => "variables".to_owned(),
            };
            format!(", {name} + {length} * k")
        })
        .collect();
    let _ = writeln!(
        text,
        "    for (size_t k = 0; k < elements; k++) {name}_{mode_name}(count, inputs + k, nodes + count * k, values + k{targets}, scratch);"
    );
    text + "}\n"
}

/// The body for one element.
fn body(program: &Program<ElementSpec>, derivatives: &[String]) -> String {
    let ElementSpec { signature, .. } = &program.kernel.spec;
    let input = |name: &str, place: &str, _: usize| format!("inputs->{}{place}", field(name));
    let value = |name: &str, place: &str, _: usize| format!("values->{}{place}", field(name));
    let (of_element, of_node) = (signature.variables(), signature.node_variables());
    let derivative = |name: &str, k: usize| {
        if name.ends_with("_jacobian") && k >= of_element {
            let (row, column) = (k / of_element, k % of_element);
            return format!("{name}[{row} * ({of_element} + {of_node} * count) + {column}]");
        }
        format!("{name}[{k}]")
    };
    let access = Access { input: &input, value: &value, derivative: &derivative };
    let reserved: Vec<(String, usize)> = derivatives.iter().map(|name| (name.clone(), 0)).collect();
    let mut writer = Writer::new(program, &reserved, &access);
    writer.names.reserve(&RESERVED);
    let scratch = Scratch::new(program);

    let mut text = "    (void)inputs;\n    (void)nodes;\n    (void)scratch;\n".to_owned();
    if scratch.form > 0 {
        let _ = writeln!(text, "    double *const form = scratch + {} * count;", scratch.kept);
    }
    if program.kernel.graph.has_input(NODE_COUNT)
        && let Some(count) = writer.symbol(NODE_COUNT)
    {
        let _ = writeln!(text, "    const double {} = (double)count;", writer.name(count));
    }
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

fn node_loop(writer: &mut Writer<'_>, nodes: &NodeLoop, scratch: Scratch) -> String {
    if nodes.sums.is_empty() && nodes.stores.is_empty() && nodes.outputs.is_empty() {
        return String::new();
    }
    let program = writer.program;
    let graph = &program.kernel.graph;
    let mut text = String::new();
    for &sum in &nodes.sums {
        let _ = writeln!(text, "    double {} = 0.0;", writer.name(sum));
    }
    text += "    for (size_t node = 0; node < count; node++) {\n";
    let indent = "        ";
    for input in &program.kernel.spec.signature.nodes {
        for (symbol, place) in input.symbols.iter().zip(places(&input.dimensions)) {
            if program.loop_reads(nodes, symbol)
                && let Some(expr) = program.node_input(symbol)
            {
                let (name, of) = (writer.name(expr), field(&input.name));
                let _ = writeln!(text, "{indent}const double {name} = nodes[node].{of}{place};");
            }
        }
    }
    if program.loop_reads(nodes, NODE_INDEX)
        && let Some(expr) = program.node_input(NODE_INDEX)
    {
        let _ = writeln!(text, "{indent}const double {} = (double)node;", writer.name(expr));
    }
    let kept = program.kept();
    let place = |x| {
        let place = kept.iter().position(|&other| other == x).unwrap_or(0);
        format!("scratch[{} * node + {place}]", scratch.kept)
    };
    for &load in &nodes.loads {
        let _ = writeln!(text, "{indent}const double {} = {};", writer.name(load), place(load));
    }
    text += &writer.lets(indent, &nodes.statements);
    for &sum in &nodes.sums {
        let Op::Sum(term) = graph.op(sum) else { continue };
        let _ = writeln!(text, "{indent}{} += {};", writer.name(sum), writer.operand(term).0);
    }
    text += &results(writer, nodes, scratch);
    for &store in &nodes.stores {
        let _ = writeln!(text, "{indent}{} = {};", place(store), writer.name(store));
    }
    text + "    }\n"
}

/// Results of a loop.
fn results(writer: &mut Writer<'_>, nodes: &NodeLoop, scratch: Scratch) -> String {
    let spec = &writer.program.kernel.spec;
    let (of_element, of_node) = (spec.signature.variables(), spec.signature.node_variables());
    let all = format!("({of_element} + {of_node} * count)");
    let first = format!("{of_element} + {of_node} * node");
    let mut text = String::new();
    for (target, values) in &nodes.outputs {
        let NodeTarget::Value { value } = *target else { unreachable!("values of nodes only") };
        let x = writer.operand(values[0]).0;
        let to = match &spec.node_results[value] {
            NodeResult::First { argument, row: 0, component } => format!("{argument}[{first} + {component}]"),
            NodeResult::First { argument, row, component } => {
                format!("{argument}[{row} * {all} + {first} + {component}]")
            }
            NodeResult::Mixed { component, variable } => {
                format!("hessian[diffuse_contact_packed_row({first} + {component}) + {variable}]")
            }
            NodeResult::Row { row, component } => {
                format!("form[{} * node + {}]", scratch.form, of_node * row + component)
            }
            NodeResult::Own { place } => {
                let place = 2 * scratch.products * of_node + place;
                format!("form[{} * node + {place}]", scratch.form)
            }
        };
        let _ = writeln!(text, "        {to} = {x};");
    }
    text
}
