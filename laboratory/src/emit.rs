//! The `emit` job: the source of a kernel, or the operation counts of all of them.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::PathBuf;

use clap::{Args, ValueEnum, value_parser};
use diffuse_contact_codegen::contact::{emit_kernel, emit_single, emit_single_element};
use diffuse_contact_codegen::emit::{KernelCounts, OpCounts, emit_c, emit_element_kernel};
use diffuse_contact_codegen::{Basis, ElementKernels, FacetShape, FrameRule, KernelSpec, Mode, Output};
use diffuse_contact_program::arguments::named;

use crate::error::CliError;
use crate::output;
use crate::weight::{FORMULAS, FitArguments};

/// Numbers of master nodes in the table of all kernels.
const NODES: [usize; 5] = [6, 9, 12, 16, 20];

/// Most nodes that operations are counted for: their pairs are as many as half the square.
const MOST_NODES: i64 = 1_000;

/// Language of a kernel's source: Rust as the build script writes it, or C99 without any library.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Language {
    #[default]
    Rust,
    C,
}

/// Arguments of `emit`.
#[derive(Args, Clone, Debug)]
#[command(after_help = FORMULAS)]
pub struct EmitArguments {
    /// Master nodes that operations are counted for; the kernel serves any number, and in C they are counted for n
    #[arg(long, value_name = "N", required_unless_present_any = ["counts", "facet", "lang"], value_parser = value_parser!(u32).range(1..=MOST_NODES))]
    pub nodes: Option<u32>,
    /// What the kernel computes
    #[arg(long, value_parser = named(Output::ALL, Output::name), required_unless_present_any = ["counts", "facet"])]
    pub output: Option<Output>,
    /// Instead of a fit's kernel, that of contact on a facet of this shape
    #[arg(long, value_name = "SHAPE", value_parser = named(FacetShape::ALL, FacetShape::name), conflicts_with_all = ["nodes", "output", "frame_derivative", "counts", "basis", "weight"])]
    pub facet: Option<FacetShape>,
    /// Language of the kernel [default: rust]
    #[arg(long, value_name = "LANGUAGE", value_enum, conflicts_with = "counts")]
    pub lang: Option<Language>,
    /// With how many derivatives
    #[arg(long, value_parser = named(Mode::ALL, Mode::name), required_unless_present = "counts")]
    pub mode: Option<Mode>,
    /// Basis and weight.
    #[command(flatten)]
    pub fit: FitArguments,
    /// What the local frame does while differentiating the gap [default: held; both with --counts]
    #[arg(long, value_parser = named(FrameRule::ALL, frame_name))]
    pub frame_derivative: Option<FrameRule>,
    /// Instead of a kernel, print the operation counts of all kernels
    #[arg(long, conflicts_with_all = ["nodes", "output", "mode", "frame_derivative"])]
    pub counts: bool,
    /// File to write [default: standard output]
    #[arg(short = 'o', value_name = "FILE")]
    pub file: Option<PathBuf>,
}

/// Name of a frame rule, the same as in the JSON of `evaluate`.
pub const fn frame_name(frame: FrameRule) -> &'static str {
    match frame {
        FrameRule::Held => "held",
        FrameRule::CoMoving => "co-moving",
        FrameRule::Material => "material",
    }
}

/// Why there is no such kernel.
#[derive(Debug, thiserror::Error)]
pub enum EmitError {
    #[error("--nodes {nodes}: the {} basis needs at least {} master nodes", basis.name(), basis.size())]
    TooFewNodes { nodes: String, basis: Basis },
    #[error("--nodes: for how many master nodes are operations to be counted?")]
    NoNodes,
    /// Second derivatives of several quantities, in C.
    #[error("--lang c: there is no kernel for {} hessian; derivatives of it are first ones", output.name())]
    NoHessian { output: Output },
    #[error(
        "--frame-derivative {}: there is no such kernel for {} {}, only for gap and slip",
        frame_name(*frame),
        output.name(),
        mode.name()
    )]
    NoMovingFrame { frame: FrameRule, output: Output, mode: Mode },
}

impl From<EmitError> for CliError {
    fn from(error: EmitError) -> Self {
        Self::job(error)
    }
}

/// Prints or writes what the arguments ask for.
pub fn run(arguments: &EmitArguments) -> Result<(), CliError> {
    if let Some(path) = &arguments.file {
        output::check_target(path)?;
    }
    let weight = arguments.fit.weight()?.unwrap_or_default().for_generator();
    let language = arguments.lang.unwrap_or_default();
    let text = match (arguments.facet, arguments.output, arguments.mode) {
        (Some(shape), _, Some(mode)) => facet_source(shape, mode, language),
        (None, Some(output), Some(mode)) => {
            let basis = arguments.fit.basis.unwrap_or(Basis::Quadratic);
            let frame = arguments.frame_derivative.unwrap_or_default();
            let spec = KernelSpec { output, mode, basis, weight, frame };
            match (language, arguments.nodes) {
                (Language::Rust, Some(nodes)) => source(&spec, nodes as usize)?,
                (Language::Rust, None) => return Err(EmitError::NoNodes.into()),
                (Language::C, _) => c_source(&spec)?,
            }
        }
        // The parser lets only `--counts` go without them.
        _ => counts_of_all(arguments.fit.basis, &weight) + &counts_of_facets(),
    };
    let write = |writer: &mut dyn Write| -> io::Result<()> { writer.write_all(text.as_bytes()) };
    match &arguments.file {
        Some(path) => output::write_file(path, write),
        None => output::write_stdout(write),
    }
}

/// A kernel as a Rust file that starts with its operation counts. It serves any number of nodes: `nodes` are what the
/// operations are counted for.
fn source(spec: &KernelSpec, nodes: usize) -> Result<String, CliError> {
    if nodes < spec.basis.size() {
        return Err(EmitError::TooFewNodes { nodes: nodes.to_string(), basis: spec.basis }.into());
    }
    check(spec)?;
    let support = syn::parse_quote!(::diffuse_contact_kernels::support);
    let (text, kernel) = emit_single(spec, &support);
    Ok(counts_comment(spec, &kernel.counts, nodes) + &text)
}

fn check(spec: &KernelSpec) -> Result<(), EmitError> {
    if KernelSpec::all(spec.basis, &spec.weight).contains(spec) {
        return Ok(());
    }
    let &KernelSpec { output, mode, frame, .. } = spec;
    Err(EmitError::NoMovingFrame { frame, output, mode })
}

/// A kernel as a C header.
fn c_source(spec: &KernelSpec) -> Result<String, EmitError> {
    check(spec)?;
    let &KernelSpec { output, mode, basis, ref weight, frame } = spec;
    let mut element = ElementKernels::contact(output, basis, weight, frame);
    element.kernels.retain(|kernel| kernel.spec.mode == mode);
    if element.kernels.is_empty() {
        return Err(EmitError::NoHessian { output });
    }
    Ok(emit_c(&[element]))
}

/// A kernel of contact on facets.
fn facet_source(shape: FacetShape, mode: Mode, language: Language) -> String {
    let mut element = ElementKernels::facet(shape);
    match language {
        Language::Rust => {
            let support = syn::parse_quote!(::diffuse_contact_kernels::support);
            emit_single_element(&element.kernels[mode as usize], &support).0
        }
        Language::C => {
            element.kernels.retain(|kernel| kernel.spec.mode == mode);
            emit_c(&[element])
        }
    }
}

/// The operation counts of a kernel as a comment.
fn counts_comment(spec: &KernelSpec, counts: &KernelCounts, nodes: usize) -> String {
    const COLUMNS: [&str; 7] = ["fused", "add", "mul", "neg", "div", "functions", "selections"];
    let mut text = format!(
        "// {} {}, {} basis, weight {}, {} frame: operations.\n\
         // A fused multiply-add counts one, so does an unpaired addition or multiplication.\n//\n",
        spec.output.name(),
        spec.mode.name(),
        spec.basis.name(),
        weight_text(&spec.weight),
        frame_name(spec.frame),
    );
    let mut line = |label: &str, figures: &[String]| {
        let figures = figures.iter().map(|figure| format!("{figure:>11}")).collect::<String>();
        let _ = writeln!(text, "// {label:<24}{figures}");
    };
    let header: Vec<String> = std::iter::once("total").chain(COLUMNS).map(str::to_owned).collect();
    line("", &header);
    let rows = [
        ("per element".to_owned(), counts.element),
        ("per Newton iteration".to_owned(), counts.iteration),
        ("per node".to_owned(), counts.node),
        ("per pair of nodes".to_owned(), counts.pair),
        // What `KernelCounts::total` adds up.
        (format!("{nodes} nodes, 1 iteration"), counts.total(nodes)),
    ];
    for (label, counts) in rows {
        line(&label, &figures(&counts).map(|figure| figure.to_string()));
    }
    text.push('\n');
    text
}

/// Total and kinds, in the order of the comment's columns.
const fn figures(counts: &OpCounts) -> [usize; 8] {
    [
        counts.total(),
        counts.fused,
        counts.additions,
        counts.multiplications,
        counts.negations,
        counts.divisions,
        counts.functions,
        counts.selections,
    ]
}

/// The totals of all kernels as a table in Markdown.
fn counts_of_all(basis: Option<Basis>, weight: &diffuse_contact_codegen::Weight) -> String {
    let mut text = format!(
        "Operations by number of master nodes n, weight `{}`, one Newton iteration for a gap.\n\
         A fused multiply-add counts one, so does an unpaired addition or multiplication.\n\n",
        weight_text(weight)
    );
    let columns = NODES.map(|nodes| format!(" {:>6} |", format!("n = {nodes}"))).concat();
    let _ = writeln!(text, "| basis     | output       | mode     | frame     |{columns}");
    let rule = " -----: |".repeat(NODES.len());
    let _ = writeln!(text, "| --------- | ------------ | -------- | --------- |{rule}");
    for basis in Basis::ALL.into_iter().filter(|&candidate| basis.is_none_or(|basis| basis == candidate)) {
        for spec in KernelSpec::all(basis, weight) {
            let kernel = emit_kernel(&spec);
            let totals = NODES.map(|nodes| format!(" {:>6} |", kernel.counts.total(nodes).total())).concat();
            let (basis, output, mode, frame) =
                (basis.name(), spec.output.name(), spec.mode.name(), frame_name(spec.frame));
            let _ = writeln!(text, "| {basis:<9} | {output:<12} | {mode:<8} | {frame:<9} |{totals}");
        }
    }
    text
}

/// The totals of the kernels of contact on facets as a table in Markdown.
fn counts_of_facets() -> String {
    let mut text = "\n| facet         |  value | gradient | hessian |\n".to_owned();
    text += "| ------------- | -----: | -------: | ------: |\n";
    for shape in FacetShape::ALL {
        let kernels = ElementKernels::facet(shape).kernels;
        let [value, gradient, hessian] =
            Mode::ALL.map(|mode| emit_element_kernel(&kernels[mode as usize]).counts.total());
        let name = shape.name();
        let _ = writeln!(text, "| {name:<13} | {value:>6} | {gradient:>8} | {hessian:>7} |");
    }
    text
}

/// A weight without line breaks, which would end a comment or a table.
fn weight_text(weight: &diffuse_contact_codegen::Weight) -> String {
    let formula = weight.text().split_whitespace().collect::<Vec<_>>().join(" ");
    if weight.is_interpolating() { format!("w/(1 - w), w = {formula}") } else { formula }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_formula_over_two_lines_stays_in_its_comment() {
        let weight = crate::weight::Weight::new("(1 - r)^2\n * (1 + 2*r)", false).unwrap().for_generator();
        let (output, mode, basis, frame) =
            (Output::Coefficients, Mode::Value, Basis::Linear, FrameRule::Held);
        let spec = KernelSpec { output, mode, basis, weight, frame };
        let text = counts_comment(&spec, &KernelCounts::default(), 3);
        assert!(text.contains("weight (1 - r)^2 * (1 + 2*r), held frame: operations"), "{text}");
        assert!(text.lines().all(|line| line.is_empty() || line.starts_with("//")), "{text}");
    }

    #[test]
    fn the_columns_add_up_to_the_total() {
        let counts = OpCounts {
            fused: 1,
            additions: 2,
            multiplications: 4,
            negations: 8,
            divisions: 16,
            functions: 32,
            selections: 64,
        };
        let [total, kinds @ ..] = figures(&counts);
        assert_eq!((total, kinds.iter().sum::<usize>()), (127, 127));
    }
}
