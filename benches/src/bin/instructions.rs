//! A fixed amount of work for counting instructions: `instructions SHAPE ISA NODES ROUNDS` evaluates gap, N and M, with a frame that moves, of
//! the same 16 elements so many times over, `single` one after another or `batch` all at once. With 0 rounds it makes the elements and warms up only, so that the difference of
//! two runs is the kernel alone. Exits with 2 on whatever goes wrong.
//!
//! ISA, for instance `scalar` or `avx2`, is what the kernels are run with; tools that count instructions do not know all
//! that processors do.

use std::error::Error;
use std::process::ExitCode;

use diffuse_contact_benches::batch::GapInBatches;
use diffuse_contact_benches::generated::one_by_one;
use diffuse_contact_benches::{Elements, Output, Run, isa_named};

/// Elements of a round.
const ELEMENTS: usize = 16;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match work(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn work(arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let [shape, isa, nodes, rounds] = arguments else {
        return Err("usage: instructions SHAPE ISA NODES ROUNDS".into());
    };
    let (isa, output) = (isa_named(isa)?, Output::GapCoMovingHessian);
    let elements = Elements::new(nodes.parse()?, ELEMENTS)?;
    let mut run: Box<dyn Run> = match shape.as_str() {
        "single" => one_by_one(&elements, output, isa),
        "batch" => Box::new(GapInBatches::new(&elements, output, isa)),
        _ => return Err(format!("the shapes are single and batch, not {shape}").into()),
    };
    run.run(ELEMENTS)?;
    for _ in 0..rounds.parse::<usize>()? {
        run.run(ELEMENTS)?;
    }
    Ok(())
}
