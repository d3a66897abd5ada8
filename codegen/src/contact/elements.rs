//! The contact kernels as elements with a signature, as an element of the caller's has one: what reads and writes them then knows no model.

use rustc_hash::FxHashSet;

use crate::expr::{AXES, Expr, Mat3, Sheet, Vec3, Vector};
use crate::graph::{ExprId, Op};
use crate::kernel::{
    Differentiated, ElementKernels, ElementSpec, Input, Kernel, Mode, NodeResult, Points, Returned, Role,
    Signature, Value,
};
use crate::model::{
    Basis, DOMAIN_RATIO, FacetShape, FrameRule, KernelSpec, MATERIAL_INPUTS, Output, PLANE_REACH,
    WEIGHT_NUMBER, Weight,
};
use crate::structure::{Gradient, LowRankForm, LowRankTerm};

/// Derivatives of a kernel by number of derivatives: a value with a Jacobian has no second ones.
const GRADIENT: &str = "gradient";
const HESSIAN: &str = "hessian";

/// An input of three axes.
fn vector(name: &str, role: Role, doc: &str) -> Input {
    let symbols = AXES.map(|axis| format!("{name}_{axis}")).to_vec();
    Input { name: name.to_owned(), doc: doc.to_owned(), role, dimensions: vec![3], symbols }
}

fn parameter(name: &str, symbols: Vec<String>, doc: &str) -> Input {
    let dimensions = if symbols.len() == 1 { Vec::new() } else { vec![symbols.len()] };
    Input { name: name.to_owned(), doc: doc.to_owned(), role: Role::Parameter, dimensions, symbols }
}

fn number(name: &str, doc: &str) -> Input {
    parameter(name, vec![name.to_owned()], doc)
}

fn returned(value: &Value, differentiated: Differentiated) -> Returned {
    let dimensions = if value.is_array { vec![value.components.len()] } else { Vec::new() };
    Returned { name: value.name.to_string(), doc: value.doc.to_string(), dimensions, differentiated }
}

impl ElementKernels {
    /// The kernels of contact on a facet: variables are the slave, then the corners.
    pub fn facet(shape: FacetShape) -> Self {
        Self::new(shape.gap_name(), |m| shape.gap(m)).expect("the formulas of a facet are sound")
    }

    /// The kernels of a fit to nodes of a number that is open: variables are the slave, with a slip the anchor, then the nodes.
    ///
    /// Coefficients, and slips, have first derivatives only: each of several quantities has second ones.
    pub fn contact(output: Output, basis: Basis, weight: &Weight, frame: FrameRule) -> Self {
        let modes = match output {
            Output::Coefficients | Output::Slip => &Mode::ALL[..2],
            Output::Surface | Output::Gap => &Mode::ALL[..],
        };
        let of =
            |&mode: &Mode| Kernel::new(KernelSpec { output, mode, basis, weight: weight.clone(), frame });
        let kernels: Vec<Kernel<KernelSpec>> = modes.iter().map(of).collect();
        let signature = contact_signature(&kernels[0]);
        let kernels: Vec<_> = kernels.into_iter().map(|kernel| as_element(kernel, &signature)).collect();
        Self::of_used(signature, kernels)
    }

    /// The kernels without the inputs that none of them reads.
    fn of_used(mut signature: Signature, mut kernels: Vec<Kernel<ElementSpec>>) -> Self {
        let used: FxHashSet<String> = kernels.iter().flat_map(symbols_read).collect();
        let is_used = |input: &Input| {
            input.role == Role::Variable || input.symbols.iter().any(|symbol| used.contains(symbol))
        };
        signature.inputs.retain(is_used);
        signature.nodes.retain(is_used);
        for kernel in &mut kernels {
            kernel.spec.signature = signature.clone();
        }
        Self { signature, kernels, product: None, written: None }
    }
}

/// Names of the symbols that a kernel's results depend on.
fn symbols_read(kernel: &Kernel<ElementSpec>) -> Vec<String> {
    let name = |x: ExprId| match kernel.graph.op(x) {
        Op::Symbol(symbol) => Some(kernel.graph.symbol_data(symbol).name.clone()),
        _ => None,
    };
    kernel.reachable().into_iter().filter_map(name).collect()
}

/// The signature of a fit's kernel; of its inputs those that there are with its basis, weight and frame.
pub(super) fn contact_signature(kernel: &Kernel<KernelSpec>) -> Signature {
    let KernelSpec { output, basis, weight, frame, .. } = &kernel.spec;
    let (name, moves) = match frame {
        FrameRule::Held => (output.name().to_owned(), ""),
        FrameRule::CoMoving => {
            (format!("{}_co_moving", output.name()), ", frame moving with the average plane")
        }
        FrameRule::Material => {
            (format!("{}_material", output.name()), ", domains of influence in the first configuration")
        }
    };
    let mut inputs = vec![vector("slave", Role::Variable, "Slave node.")];
    let frame =
        ["First in-plane direction.", "Second in-plane direction.", "Unit normal of the plane, outward."];
    let axes = ["t1", "t2", "normal"].into_iter().zip(frame);
    inputs.extend(axes.map(|(name, doc)| vector(name, Role::Parameter, doc)));
    if *output == Output::Surface {
        let symbols = vec!["point_1".to_owned(), "point_2".to_owned()];
        inputs.push(parameter("point", symbols, "In-plane offset from the slave."));
    }
    let others = [
        ("pole", "Index of the node nearest to the slave in the plane."),
        (WEIGHT_NUMBER, "Which of the weights it is."),
        (PLANE_REACH, "Multiple of the distance at which the average plane's weights are taken."),
    ];
    let graph = &kernel.graph;
    inputs.extend(
        others.into_iter().filter(|(name, _)| graph.has_input(name)).map(|(name, doc)| number(name, doc)),
    );
    if *output == Output::Slip {
        inputs.push(vector("anchor", Role::Variable, "Where the slip is measured from."));
    }
    inputs.push(number("support_radius", "The length that offsets are divided by."));
    let mut nodes = vec![vector("master", Role::Variable, "Position.")];
    if graph.has_input(DOMAIN_RATIO) {
        nodes.push(number(DOMAIN_RATIO, "Support radius over the radius of the node's domain."));
    }
    if graph.has_input(MATERIAL_INPUTS[0]) {
        nodes.push(vector("material", Role::Parameter, "First position, seen from the slave's place there."));
        let symbols = MATERIAL_INPUTS[3..].iter().map(|&name| name.to_owned()).collect();
        nodes.push(parameter(
            "metric",
            symbols,
            "Upper triangle of the metric, rows xx, xy, xz, yy, yz, zz.",
        ));
    }
    let values = kernel.values.iter().map(|value| returned(value, differentiated(*output, &value.name)));
    let doc = format!(
        "{} of a fit with the {} basis, weight {}{moves}.",
        ["Coefficients", "Height and slopes", "Gap", "Gap and slip"][*output as usize],
        basis.name(),
        weight.text().split_whitespace().collect::<Vec<_>>().join(" "),
    );
    Signature { name, doc, inputs, nodes, values: values.collect(), points: Points::default() }
}

fn differentiated(output: Output, value: &str) -> Differentiated {
    match (output, value) {
        (Output::Gap, "gap") | (Output::Surface, "value") => Differentiated::Twice,
        (Output::Coefficients, "coefficients") | (Output::Surface, "slopes") => Differentiated::Once,
        (Output::Slip, "gap" | "slip") => Differentiated::Once,
        _ => Differentiated::Not,
    }
}

/// What a kernel's gradients are written to, in their order, with the row.
fn places(output: Output, count: usize) -> Vec<(String, usize)> {
    let jacobian = |name: &str, row: usize| (format!("{name}_jacobian"), row);
    match output {
        Output::Gap => vec![(GRADIENT.to_owned(), 0)],
        Output::Surface => vec![(GRADIENT.to_owned(), 0), jacobian("slopes", 0), jacobian("slopes", 1)],
        Output::Coefficients => (0..count).map(|row| jacobian("coefficients", row)).collect(),
        Output::Slip => vec![jacobian("gap", 0), jacobian("slip", 0)],
    }
}

fn as_element(mut kernel: Kernel<KernelSpec>, signature: &Signature) -> Kernel<ElementSpec> {
    let (output, mode) = (kernel.spec.output, kernel.spec.mode);
    let zero = kernel.graph.zero();
    let mut values = std::mem::take(&mut kernel.values);
    let mut of_nodes = Vec::new();
    let has_anchor = output == Output::Slip;
    for ((argument, row), (_, gradient)) in
        places(output, kernel.gradients.len()).into_iter().zip(&kernel.gradients)
    {
        let Gradient { slave, node, point } = gradient;
        let mut entries = slave.to_vec();
        if has_anchor {
            entries.extend(point.unwrap_or([zero; 3]));
        }
        match values.iter_mut().find(|value| value.name == argument) {
            Some(value) => value.components.extend(entries),
            None => values.push(derivative(&argument, entries)),
        }
        for (component, &x) in node.iter().enumerate() {
            of_nodes.push((NodeResult::First { argument: argument.clone(), row, component }, x));
        }
    }
    if let Some((_, form)) = kernel.hessians.first() {
        let [slave, with_slave] = kernel.graph.write(|sheet| blocks_of_slave(sheet, form));
        values.push(derivative(HESSIAN, (0..3).flat_map(|row| slave[row][..=row].to_vec()).collect()));
        for (component, variable) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            of_nodes.push((NodeResult::Mixed { component, variable }, with_slave[component][variable]));
        }
        let rows = form.terms.iter().flat_map(|term| [term.b, term.c]).enumerate();
        for (row, x) in rows {
            let entries = x.into_iter().enumerate();
            of_nodes.extend(entries.map(|(component, x)| (NodeResult::Row { row, component }, x)));
        }
        let own = (0..3).flat_map(|row| form.own[row][..=row].to_vec()).enumerate();
        of_nodes.extend(own.map(|(place, x)| (NodeResult::Own { place }, x)));
    }
    let (signature, quantities) = (signature.clone(), Vec::new());
    let (node_results, of_nodes) = of_nodes.into_iter().unzip();
    let spec = ElementSpec { signature, mode, quantities, node_results, direction: None };
    Kernel::of_element(spec, kernel.graph, values, of_nodes)
}

/// The blocks of a Hessian that the slave takes part in: its own, and that of a node with it.
fn blocks_of_slave<'g>(sheet: &'g Sheet, form: &LowRankForm) -> [[[ExprId; 3]; 3]; 2] {
    let own = |i: usize, j: usize| sheet.expr(form.own[i][j]);
    let rows = |letter: &str, of: fn(&LowRankTerm) -> [ExprId; 3]| -> [Vec<Vec3<'g>>; 2] {
        let nodes: Vec<Vec3<'g>> =
            form.terms.iter().map(|term| Vector(of(term).map(|x| sheet.expr(x)))).collect();
        let slave =
            |(k, row): (usize, &Vec3<'g>)| row.map(|x| -x.sum()).named(&format!("{letter}_slave_{k}"));
        let slave = nodes.iter().enumerate().map(slave).collect();
        [nodes, slave]
    };
    let ([b, b_slave], [c, c_slave]) = (rows("b", |term| term.b), rows("c", |term| term.c));
    let product = |start: Expr<'g>, b: &[Vec3<'g>], c: &[Vec3<'g>], i: usize, j: usize| {
        let first = c.iter().zip(&b_slave).map(|(c, b)| c[i] * b[j]);
        let second = b.iter().zip(&c_slave).map(|(b, c)| b[i] * c[j]);
        first.chain(second).fold(start, |sum, product| sum + product)
    };
    let slave = Mat3::symmetric(|i, j| product(own(i, j).sum(), &b_slave, &c_slave, i, j));
    [slave.ids(), Mat3::from_fn(|i, j| product(-own(i, j), &b, &c, i, j)).ids()]
}

fn derivative(name: &str, components: Vec<ExprId>) -> Value {
    Value { name: name.to_owned().into(), doc: "".into(), is_array: true, components }
}
