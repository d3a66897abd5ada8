//! The `bench` job: the generated kernels against the element written by hand and over dual numbers, in one thread.

use std::io::{IsTerminal, Write, stderr};

use clap::Args;
use diffuse_contact_benches::{Plan, isa_named, measure};
use diffuse_contact_kernels::support::Isa;

use crate::error::CliError;
use crate::output;

/// What the figures mean, for the help.
const FIGURES: &str = r#"All contenders evaluate the same elements (quadratic basis, cubic weight) and are first compared with the generated
kernels: a difference above 1e-10 ends the program with exit code 2. Then they run in turn; times are medians over the
rounds. Times of optimised programs only mean anything; with link-time optimisation:
  cargo run --profile bench -p diffuse-contact-laboratory -- bench

kernel   generated-single     the kernels of this library, one element at a time
         generated-batch      the same, many elements at a time
         by-hand-nalgebra     the same element and derivatives written by hand with nalgebra
         num-dual-dual2-vec   num-dual, Hessians of exactly the width needed; compiled for 6, 8, 9, 12, 16, 20, 24 nodes
         num-dual-hyper-dual  num-dual, one evaluation for each entry of the lower triangle
output   gap-hessian          g, foot, normal, N and the lower triangle of M, the frame held
         gap-gradient         g, foot, normal and N, the frame held
         gap-co-moving-hessian  as gap-hessian, the frame moving with the nodes
         surface-hessian      f, its gradient, T_1, T_2 and the lower triangle of H_f at a given point

JSON: {"machine": processor or null, "isa": vector instructions of the generated kernels,
 "compiled_for": those of the program, which the others and surface-hessian use,
 "peak_fma_per_ns": of a loop that does nothing else, in the same run and with "isa", "rounds": ..., "elements": ...,
 "rows": [{"nodes": n, "kernel": "...", "output": "...", "ns_per_element": t,
           "fma_per_element": operations, a fused multiply-add counting one; null where nobody counted,
           "fraction_of_peak": operations per time over the peak, or null}, ...],
 "absent": [{"nodes": n, "kernel": "...", "output": "..."}, ...]  contenders not compiled for a number of nodes}"#;

/// Arguments of `bench`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = FIGURES)]
pub struct BenchArguments {
    /// Numbers of master nodes, from 6 on
    #[arg(long, value_name = "N,N,...", value_delimiter = ',', default_values_t = Plan::default().nodes)]
    pub nodes: Vec<usize>,
    /// Rounds of which times are the median
    #[arg(long, value_name = "K", default_value_t = Plan::default().rounds, value_parser = at_least_one)]
    pub rounds: usize,
    /// Different elements for each number of nodes
    #[arg(long, value_name = "K", default_value_t = Plan::default().elements, value_parser = at_least_one)]
    pub elements: usize,
    /// Only kernels whose names contain one of these texts [default: all]
    #[arg(long, value_name = "TEXT,TEXT,...", value_delimiter = ',')]
    pub kernels: Vec<String>,
    /// Vector instructions the generated kernels are run with: scalar, avx2, avx512 or neon, as far as the
    /// machine has them [default: the widest]
    #[arg(long, value_name = "NAME", value_parser = isa_named)]
    pub isa: Option<Isa>,
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
}

/// Measures and prints.
pub fn run(arguments: &BenchArguments) -> Result<(), CliError> {
    let BenchArguments { nodes, rounds, elements, kernels, isa, json } = arguments.clone();
    let plan = Plan { nodes, rounds, elements, kernels, isa: isa.unwrap_or_default() };
    let terminal = stderr().is_terminal();
    let report = measure(&plan, |step| {
        // One line that is written over, on a terminal; nothing in a log. If standard error is closed, nobody waits.
        if terminal {
            let _ = write!(stderr(), "\r\x1b[K{step}");
        }
    });
    if terminal {
        let _ = write!(stderr(), "\r\x1b[K");
    }
    let report = report.map_err(CliError::job)?;
    if json {
        return output::write_json(&report);
    }
    output::write_stdout(|writer| write!(writer, "{report}"))
}

/// A whole number from 1 on.
fn at_least_one(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count) if count > 0 => Ok(count),
        _ => Err("not a whole number from 1 on".to_owned()),
    }
}
