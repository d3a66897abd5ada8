//! Elements and what the generated kernels make of them, as JSON, for rivals in other languages:
//! `surface_elements NODES COUNT`.
//!
//! `{"nodes": n, "elements": [{"slave": [3], "masters": [[3], ...], "frame": [t1, t2, normal], "support_radius": R,
//! "point": [u1, u2], "surface": {"value": f, "gradient": [...], "hessian": [...]}, "gap": {...}}, ...]}`. Lengths are
//! those of the coordinates, `point` too; Hessians are packed lower triangles; the frame is held.

use std::error::Error;
use std::io::Write;

use diffuse_contact_benches::generated::{SURFACE_POINT, reference};
use diffuse_contact_benches::{Elements, Evaluation, Output};
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<usize> =
        std::env::args().skip(1).map(|text| text.parse()).collect::<Result<_, _>>()?;
    let [nodes, count] = arguments[..] else {
        return Err("usage: surface_elements NODES COUNT".into());
    };
    let elements = Elements::new(nodes, count)?;
    let entries = (0..count).map(|index| entry(&elements, index)).collect::<Result<Vec<_>, _>>()?;
    writeln!(std::io::stdout(), "{}", json!({ "nodes": nodes, "elements": entries }))?;
    Ok(())
}

/// One element with its results.
fn entry(elements: &Elements, index: usize) -> Result<Value, Box<dyn Error>> {
    let element = elements.held(index);
    let result = |output| -> Result<Value, Box<dyn Error>> {
        let Evaluation { value, gradient, hessian } = reference(elements, output, index)?;
        Ok(json!({ "value": value, "gradient": gradient, "hessian": hessian }))
    };
    Ok(json!({
        "slave": element.slave,
        "masters": element.masters,
        "frame": element.frame.rows(),
        "support_radius": element.support_radius,
        "point": SURFACE_POINT.map(|u| u * element.support_radius),
        "surface": result(Output::SurfaceHessian)?,
        "gap": result(Output::GapHessian)?,
    }))
}
