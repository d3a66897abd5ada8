//! Elements of one's own beside rivals, as JSON, for `rivals/own_elements.py`: `own_elements SECONDS`, or `own_elements c` for the C header.
//!
//! Inputs and results of 256 tetrahedra (inputs in the order of their struct; energy, gradient, packed Hessian), nanoseconds an element of
//! each way, operations, and the time to differentiate and to write the source.
#![allow(non_snake_case)]

use std::error::Error;
use std::hint::black_box;
use std::io::Write;
use std::time::Instant;

use diffuse_contact_benches::peak::fma_per_ns;
use diffuse_contact_benches::tetrahedron::{by_dual_numbers, by_hand, elements, hex8, hexahedra, tet4};
use diffuse_contact_codegen::emit::emit_element_kernel;
use diffuse_contact_codegen::{Config, ElementKernels, ElementModel};
use diffuse_contact_kernels::support::{Isa, Mode};
use serde_json::{Map, Value, json};
use tet4::{Inputs, Results};

#[path = "../formulas.rs"]
mod formulas;

/// Different elements, which stay in the cache with their results.
const ELEMENTS: usize = 256;

fn main() -> Result<(), Box<dyn Error>> {
    let argument = std::env::args().nth(1).ok_or("usage: own_elements SECONDS | c")?;
    let config = || Config::new().element("tet4", formulas::tet4);
    if argument == "c" {
        std::io::stdout().write_all(config()?.c_source()?.as_bytes())?;
        return Ok(());
    }
    let seconds: f64 = argument.parse()?;

    let start = Instant::now();
    black_box(config()?.source()?);
    let generate_s = start.elapsed().as_secs_f64();

    let all = elements(ELEMENTS);
    let expected: Vec<Results> = all.iter().map(|element| tet4::evaluate(Mode::Hessian, element)).collect();
    let flat = |x: &Inputs<f64>| [x.x.as_flattened(), x.X.as_flattened(), &[x.lambda, x.mu]].concat();
    let results = |r: &Results| [&[r.values.energy], &r.gradient[..], &r.hessian].concat();
    let answer = json!({
        "inputs": all.iter().map(flat).collect::<Vec<_>>(),
        "results": expected.iter().map(results).collect::<Vec<_>>(),
        "ns": times(&all, seconds),
        "isa": Isa::best().to_string(),
        "peak_fma_per_ns": fma_per_ns(Isa::best()),
        "operations": { "tet4": operations(formulas::tet4)?, "hex8": operations(formulas::hex8)? },
        "generate_s": generate_s,
    });
    writeln!(std::io::stdout(), "{answer}")?;
    Ok(())
}

/// Operations of energy, gradient and Hessian.
fn operations(formulas: fn(&ElementModel<'_>)) -> Result<usize, Box<dyn Error>> {
    let element = ElementKernels::new("element", formulas)?;
    let kernel = element.kernels.last().ok_or("no kernel")?;
    Ok(emit_element_kernel(kernel).counts.total())
}

/// Nanoseconds an element.
fn times(all: &[Inputs<f64>], seconds: f64) -> Map<String, Value> {
    let mut results = vec![Results::ZERO; all.len()];
    let mut times = Map::new();
    for (name, one) in [
        ("by hand, nalgebra", by_hand as fn(&Inputs<f64>) -> Results),
        ("num-dual", by_dual_numbers),
        ("generated, single", |element| tet4::evaluate(Mode::Hessian, element)),
    ] {
        let mut run =
            || all.iter().zip(&mut results).for_each(|(element, result)| *result = one(black_box(element)));
        times.insert(name.to_owned(), ns_per_element(&mut run, all.len(), seconds).into());
    }
    let hexahedra = hexahedra(ELEMENTS);
    let mut of_hexahedra = vec![hex8::Results::ZERO; ELEMENTS];
    for isa in Isa::available() {
        let mut run = || tet4::batch(isa, Mode::Hessian, black_box(all), black_box(&mut results));
        times.insert(format!("generated, batch, {isa}"), ns_per_element(&mut run, all.len(), seconds).into());
        let mut run = || hex8::batch(isa, Mode::Hessian, black_box(&hexahedra), black_box(&mut of_hexahedra));
        times.insert(format!("hex8, batch, {isa}"), ns_per_element(&mut run, ELEMENTS, seconds).into());
    }
    times
}

/// The quickest of many rounds.
fn ns_per_element(run: &mut dyn FnMut(), elements: usize, seconds: f64) -> f64 {
    let (start, mut best) = (Instant::now(), f64::INFINITY);
    while start.elapsed().as_secs_f64() < seconds {
        let round = Instant::now();
        run();
        best = best.min(round.elapsed().as_secs_f64());
    }
    1e9 * best / elements as f64
}
