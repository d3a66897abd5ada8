//! Batches of elements with nodes of a number that is open: several elements side by side.
//!
//! Compilers turn an innermost loop into vector instructions, and only that. So each piece of straight-line code has a loop over the lanes
//! of its own around it, inside of the loop over the nodes if there is one. What several pieces use has an entry for each lane.

use rustc_hash::FxHashMap;
use std::fmt::Write as _;

use super::super::derivatives::{DIRECTION, Derivative};
use super::super::element_kernel::function_name;
use super::super::node_element::Scratch;
use super::nodes::{
    Width, derivative_place, node_count, node_index, node_loads, node_reads, node_stores, results, terms,
    writer,
};
use super::writer::{Access, Writer};
use crate::graph::{ExprId, NODE_COUNT};
use crate::kernel::{ElementSpec, Mode};
use crate::schedule::{NodeLoop, Program, Statement};

/// A part of a function's body.
enum Part {
    /// Text around loops over lanes.
    Plain(String),
    /// A loop over lanes.
    Lanes(Piece),
}

/// What stands in a loop over lanes.
struct Piece {
    indent: &'static str,
    body: String,
    /// Variables that it defines.
    defined: Vec<ExprId>,
    /// Variables of other pieces that it uses.
    fetched: Vec<ExprId>,
    /// Whether a compiler can vectorise it: it finds no root.
    is_straight: bool,
}

/// Both functions of a batch: one for elements side by side, one for all.
pub(super) fn functions(program: &Program<ElementSpec>, derivatives: &[String], scratch: &str) -> String {
    let spec = &program.kernel.spec;
    let name = format!("{}_{}", spec.signature.name, function_name(spec));
    let (second, entries) = match spec.direction {
        Some(_) => (format!("const double *DIFFUSE_CONTACT_RESTRICT {DIRECTION}"), DIRECTION),
        None => ("double *DIFFUSE_CONTACT_RESTRICT values".to_owned(), "values"),
    };
    let parameters: String =
        derivatives.iter().map(|name| format!(", double *DIFFUSE_CONTACT_RESTRICT {name}")).collect();
    let arrays = format!(
        "const double *DIFFUSE_CONTACT_RESTRICT inputs, const double *DIFFUSE_CONTACT_RESTRICT nodes, {second}{parameters}, double *DIFFUSE_CONTACT_RESTRICT scratch"
    );
    let mut text = format!(
        "\n/* Elements side by side, at most DIFFUSE_CONTACT_LANES: part of the batch. */\n\
         DIFFUSE_CONTACT_WHOLE_LOOPS\n\
         static inline void {name}_lanes(size_t lanes, size_t elements, size_t count, {arrays}) {{\n"
    );
    text += &body(program);
    let _ = writeln!(
        text,
        "}}\n\n/* Many elements with as many nodes each: {}. Entry i of element k is at i * elements + k of each array; entries of inputs, \
         nodes and values are in the order of the structs, node by node. scratch: DIFFUSE_CONTACT_LANES * {scratch} numbers for each \
         node. */",
        function_name(spec)
    );
    let _ = writeln!(
        text,
        "DIFFUSE_CONTACT_WHOLE_LOOPS\nstatic inline void {name}_batch(size_t elements, size_t count, {arrays}) {{\n    \
         const size_t lanes = elements < DIFFUSE_CONTACT_LANES ? elements : DIFFUSE_CONTACT_LANES;\n    \
         for (size_t k = 0; k < elements; k += lanes) {{\n        \
         /* The last ones are full too: some of the elements before are taken again. */\n        \
         const size_t start = elements - k < lanes ? elements - lanes : k;"
    );
    let shifted: String = derivatives.iter().map(|name| format!(", {name} + start")).collect();
    let _ = writeln!(
        text,
        "        {name}_lanes(lanes, elements, count, inputs + start, nodes + start, {entries} + start{shifted}, scratch);\n    }}\n}}"
    );
    text
}

/// The body for elements side by side.
fn body(program: &Program<ElementSpec>) -> String {
    let ElementSpec { signature, mode, .. } = &program.kernel.spec;
    let sizes = (signature.variables(), signature.node_variables());
    let input = |_: &str, _: &str, number: usize| Width::Lanes.entry("inputs", &number.to_string());
    let value = |_: &str, _: &str, number: usize| Width::Lanes.entry("values", &number.to_string());
    let derivatives = Derivative::of(&program.kernel.spec);
    let derivative = |name: &str, k: usize| derivative_place(Width::Lanes, &derivatives, (name, k), program);
    let direction = |k: usize| Width::Lanes.entry(DIRECTION, &k.to_string());
    let access = Access { input: &input, direction: &direction, value: &value, derivative: &derivative };
    let mut lanes = LanesWriter::new(writer(program, &access));
    let scratch = Scratch::new(program);

    for phase in &program.phases {
        // A root's iteration keeps nothing but itself from being vectorised.
        for statements in phase.statements.chunk_by(|x, y| is_let(x) && is_let(y)) {
            let is_straight = statements.iter().all(is_let);
            lanes.piece("    ", is_straight, |writer| writer.lets("        ", statements));
        }
        lanes.node_loop(&phase.nodes, scratch);
    }
    lanes.piece("    ", true, |writer| writer.outputs("        ", "="));
    if scratch.form > 0 {
        lanes.parts.push(Part::Plain(format!(
            "    diffuse_contact_multiply_rows_of_lanes({}, {}, {}, count, lanes, elements, form, hessian);\n",
            sizes.0, sizes.1, scratch.products
        )));
    }
    let mut head = "    (void)inputs;\n    (void)nodes;\n    (void)scratch;\n".to_owned();
    if scratch.form > 0 && *mode == Mode::Hessian {
        let _ = writeln!(
            head,
            "    double *const form = scratch + {} * count * DIFFUSE_CONTACT_LANES;",
            scratch.kept
        );
    }
    head += &node_count(&mut lanes.writer);
    head + &lanes.text()
}

const fn is_let(statement: &Statement) -> bool {
    matches!(statement, Statement::Let(_))
}

/// Writes pieces, and keeps account of what they share.
struct LanesWriter<'a> {
    writer: Writer<'a>,
    /// Inputs that each loop reads for itself, and where they stand.
    inputs: FxHashMap<ExprId, String>,
    /// What is defined outside the loops over lanes: numbers that are the same in all.
    common: Vec<ExprId>,
    parts: Vec<Part>,
    /// Variables with an entry for each lane, by their row.
    shared: FxHashMap<ExprId, usize>,
}

impl<'a> LanesWriter<'a> {
    fn new(writer: Writer<'a>) -> Self {
        let spec = &writer.program.kernel.spec;
        let inputs = spec.signature.inputs.iter().flat_map(|input| &input.symbols).enumerate();
        let direction = spec.direction.iter().flat_map(|symbols| &symbols.element).enumerate();
        let all = inputs.map(|entry| ("inputs", entry)).chain(direction.map(|entry| (DIRECTION, entry)));
        let place = |(array, (number, symbol)): (&str, (usize, &String))| {
            writer.program.symbol(symbol).map(|expr| (expr, Width::Lanes.entry(array, &number.to_string())))
        };
        let inputs = all.filter_map(place).collect();
        let common = writer.program.symbol(NODE_COUNT).into_iter().collect();
        Self { writer, inputs, common, parts: Vec::new(), shared: FxHashMap::default() }
    }

    /// A loop over lanes around what `write` writes.
    fn piece(
        &mut self,
        indent: &'static str,
        is_straight: bool,
        write: impl FnOnce(&mut Writer<'a>) -> String,
    ) {
        self.writer.trace = super::writer::Trace::default();
        let body = write(&mut self.writer);
        if body.is_empty() {
            return;
        }
        let trace = std::mem::take(&mut self.writer.trace);
        let mut fetched: Vec<ExprId> = Vec::new();
        for x in trace.used {
            if !trace.defined.contains(&x) && !self.common.contains(&x) && !fetched.contains(&x) {
                fetched.push(x);
            }
        }
        for &x in &fetched {
            if !self.inputs.contains_key(&x) {
                self.share(x);
            }
        }
        self.parts.push(Part::Lanes(Piece { indent, body, defined: trace.defined, fetched, is_straight }));
    }

    /// The row of a variable with an entry for each lane.
    fn share(&mut self, x: ExprId) -> usize {
        let next = self.shared.len();
        *self.shared.entry(x).or_insert(next)
    }

    fn node_loop(&mut self, nodes: &NodeLoop, scratch: Scratch) {
        if nodes.is_empty() {
            return;
        }
        let sums: Vec<usize> = nodes.sums.iter().map(|&sum| self.share(sum)).collect();
        if !sums.is_empty() {
            let zeros = sums.iter().map(|row| format!("        shared[{row}][lane] = 0.0;\n")).collect();
            self.piece("    ", true, |_| zeros);
        }
        self.parts.push(Part::Plain("    for (size_t node = 0; node < count; node++) {\n".to_owned()));
        if let Some((expr, text)) = node_index(&mut self.writer, nodes) {
            self.common.push(expr);
            self.parts.push(Part::Plain(text));
        }
        let (at, indent) = ((Width::Lanes, scratch), "            ");
        self.piece("        ", true, |writer| {
            let mut text = node_reads(writer, nodes, Width::Lanes, indent);
            text += &node_loads(writer, nodes, at, indent);
            text += &writer.lets(indent, &nodes.statements);
            for (row, (_, term)) in sums.iter().zip(terms(writer, nodes)) {
                let _ = writeln!(text, "{indent}shared[{row}][lane] += {term};");
            }
            text += &results(writer, nodes, at, indent);
            text + &node_stores(writer, nodes, at, indent)
        });
        self.parts.push(Part::Plain("    }\n".to_owned()));
    }

    /// All parts, with what they fetch and what they leave to others.
    fn text(mut self) -> String {
        let mut text = String::new();
        if !self.shared.is_empty() {
            let _ = writeln!(text, "    double shared[{}][DIFFUSE_CONTACT_LANES];", self.shared.len());
        }
        for part in std::mem::take(&mut self.parts) {
            let Piece { indent, body, defined, fetched, is_straight } = match part {
                Part::Plain(plain) => {
                    text += &plain;
                    continue;
                }
                Part::Lanes(piece) => piece,
            };
            if is_straight {
                let _ = writeln!(text, "{indent}DIFFUSE_CONTACT_INDEPENDENT");
            }
            let _ = writeln!(text, "{indent}for (size_t lane = 0; lane < lanes; lane++) {{");
            for x in fetched {
                let shared = || format!("shared[{}][lane]", self.shared[&x]);
                let place = self.inputs.get(&x).cloned().unwrap_or_else(shared);
                let _ = writeln!(text, "{indent}    const double {} = {place};", self.writer.name(x));
            }
            text += &body;
            for x in defined {
                if let Some(row) = self.shared.get(&x) {
                    let _ = writeln!(text, "{indent}    shared[{row}][lane] = {};", self.writer.name(x));
                }
            }
            let _ = writeln!(text, "{indent}}}");
        }
        text
    }
}
