//! A fixed amount of work for counting instructions: `instructions KERNEL ISA NODES ROUNDS` evaluates gap, N and M of
//! the same 16 elements so many times over. With 0 rounds it makes the elements and warms up only, so that the difference of
//! two runs is the kernel alone. Exits with 2 on whatever goes wrong.
//!
//! ISA is what the kernels are to be run with; tools that count instructions do not know all that processors do.

use std::error::Error;
use std::process::ExitCode;

use diffuse_contact_benches::generated::isa;
use diffuse_contact_benches::{CONTENDERS, Elements, Output};

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
    let [kernel, set, nodes, rounds] = arguments else {
        return Err("usage: instructions KERNEL ISA NODES ROUNDS".into());
    };
    // Kernels have one instruction set today, that of the program; here a choice at run time takes its place.
    if set != isa() {
        return Err(format!("the kernels are compiled for {}, not {set}", isa()).into());
    }
    let elements = Elements::new(nodes.parse()?, ELEMENTS)?;
    let contender = CONTENDERS
        .iter()
        .find(|contender| contender.kernel == kernel.as_str() && contender.output == Output::GapHessian)
        .ok_or_else(|| format!("there is no kernel {kernel}"))?;
    let mut run = (contender.prepare)(&elements).ok_or("not compiled for this number of nodes")?;
    run.run(ELEMENTS)?;
    for _ in 0..rounds.parse::<usize>()? {
        run.run(ELEMENTS)?;
    }
    Ok(())
}
