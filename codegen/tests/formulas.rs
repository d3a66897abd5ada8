//! An element that is none of ours, written with the public formulas: a tetrahedron of neo-Hooke material.

use diffuse_contact_codegen::expr::{Expr, Mat3, Sheet, Vec3};
use diffuse_contact_codegen::graph::Scope;
use diffuse_contact_codegen::interpret::{Interpreter, NodeInputs};

/// Positions and references of the corners, and the energy W(F) V with F = D_x D_X⁻¹.
#[expect(non_snake_case, reason = "the usual symbols")]
fn tetrahedron(sheet: &Sheet) -> ([Vec3<'_>; 4], Expr<'_>) {
    let [x, X] =
        ["x", "X"].map(|name| [0, 1, 2, 3].map(|k| sheet.vector(&format!("{name}{k}"), Scope::Element)));
    let [lambda, mu] = ["lambda", "mu"].map(|name| sheet.input(name, Scope::Element));
    let [D_x, D_X] = [x, X].map(|x| Mat3::from_fn(|row, column| x[column + 1][row] - x[0][row]));
    let F = D_x * D_X.inverse();
    let J = F.determinant();
    let density = 0.5 * mu * (F.double_dot(F) - 3.0 - 2.0 * J.ln()) + 0.5 * lambda * J.ln().powi(2);
    (x, density * D_X.determinant() / 6.0)
}

fn inputs(shift: f64) -> NodeInputs {
    let mut inputs = NodeInputs::new(0);
    for k in 0..4_u8 {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let reference = f64::from(u8::from(usize::from(k) == axis + 1));
            let moved = reference * 1.1 + 0.05 * f64::from(k) * (axis as f64 - 0.7);
            let shifted = if (k, axis) == (2, 0) { moved + shift } else { moved };
            inputs.set_element(&format!("X{k}_{name}"), reference);
            inputs.set_element(&format!("x{k}_{name}"), shifted);
        }
    }
    inputs.set_element("lambda", 1.5);
    inputs.set_element("mu", 0.8);
    inputs
}

#[test]
fn forces_and_stiffness_of_a_tetrahedron_follow_from_its_energy() {
    let sheet = Sheet::new();
    let (x, energy) = tetrahedron(&sheet);
    let all: Vec<Expr<'_>> = x.iter().flat_map(|x| x.0).collect();
    let forces: Vec<_> = all.iter().map(|&x| energy.by(x)).collect();
    let column: Vec<_> = forces.iter().map(|force| force.by(x[2][0]).id()).collect();
    let row: Vec<_> = all.iter().map(|&x| forces[6].by(x).id()).collect();
    let forces: Vec<_> = forces.into_iter().map(Expr::id).collect();
    let graph = sheet.into_graph();
    let values = |ids: &[_], shift: f64| -> Vec<f64> {
        let inputs = inputs(shift);
        let mut interpreter = Interpreter::new(&graph, &inputs);
        ids.iter().map(|&id| interpreter.element(id)).collect()
    };

    // No force on the whole, and a symmetric stiffness that is the change of the forces.
    let at_rest = values(&forces, 0.0);
    for axis in 0..3 {
        assert!((0..4).map(|k| at_rest[3 * k + axis]).sum::<f64>().abs() < 1e-15);
    }
    let (column, row) = (values(&column, 0.0), values(&row, 0.0));
    let h = 1e-5;
    for (k, (after, before)) in values(&forces, h).into_iter().zip(values(&forces, -h)).enumerate() {
        assert!((column[k] - row[k]).abs() < 1e-14, "{k}: {} {}", column[k], row[k]);
        assert!((column[k] - (after - before) / (2.0 * h)).abs() < 1e-9, "{k}: {}", column[k]);
    }
}
