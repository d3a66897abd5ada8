//! Products of Hessians and Jacobians with a vector, by the interpreter, against automatic differentiation of the formulas; and their
//! operations.
#![allow(non_snake_case)]

use diffuse_contact_codegen::emit::emit_element_kernel;
use diffuse_contact_codegen::expr::{Expr, Matrix, Vec2, Vec3, Vector, dot};
use diffuse_contact_codegen::interpret::{element_derivatives, element_products};
use diffuse_contact_codegen::{ElementError, ElementKernels, ElementModel, Limits};

use crate::witnesses::{difference, numbers, spring, tet4};

/// Products of the element with vectors against the derivatives that automatic differentiation finds, times the vectors.
fn check(formulas: impl Fn(&ElementModel<'_>), inputs: &[&[f64]], nodes: &[&[f64]]) -> ElementKernels {
    let element = ElementKernels::new("test", |m| {
        formulas(m);
        m.product();
    });
    let element = element.unwrap();
    let kernel = element.product.as_ref().unwrap();
    let count = element.signature.variables() + element.signature.node_variables() * nodes.len();
    let derivatives = element_derivatives(&element, inputs, nodes);
    for seed in [0.37, 0.71] {
        let along = numbers(count, seed);
        let products = element_products(kernel, inputs, nodes, &along);
        let matrices = derivatives.iter().filter(|(name, _)| name != "gradient");
        assert_eq!(products.len(), matrices.clone().count());
        for ((name, found), (of, matrix)) in products.iter().zip(matrices) {
            assert_eq!(*name, format!("{of}_product"));
            let entry = |i: usize, j: usize| match of.as_str() {
                "hessian" => matrix[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)],
                _ => matrix[i * count + j],
            };
            let expected: Vec<f64> =
                (0..found.len()).map(|i| (0..count).map(|j| entry(i, j) * along[j]).sum()).collect();
            let worst = difference(found, &expected);
            assert!(worst < 1e-12, "{name}: {worst:e}");
        }
    }
    element
}

/// Operations of the Hessian's kernel and of the product's.
fn operations(element: &ElementKernels) -> [usize; 2] {
    [element.kernels.last().unwrap(), element.product.as_ref().unwrap()]
        .map(|kernel| emit_element_kernel(kernel).counts.total())
}

const CORNERS: [f64; 12] = [0.0, 0.0, 0.0, 1.0, 0.1, 0.0, 0.2, 1.1, 0.0, 0.1, 0.0, 0.9];
const MOVED: [f64; 12] = [0.0, 0.0, 0.0, 1.1, 0.1, -0.1, 0.3, 1.2, 0.1, 0.1, -0.1, 0.8];

#[test]
fn a_tetrahedron_takes_less_than_half_of_the_operations() {
    let element = check(tet4, &[&MOVED, &CORNERS, &[1.2], &[0.8]], &[]);
    let [hessian, product] = operations(&element);
    println!("Hessian {hessian}, product {product}");
    assert!(2 * product < hessian, "{product} of {hessian}");
}

#[test]
fn a_product_leaves_the_other_kernels_as_they_are() {
    let texts = |m: fn(&ElementModel<'_>)| {
        let kernels = ElementKernels::new("test", m).unwrap().kernels;
        kernels.iter().map(|kernel| emit_element_kernel(kernel).tokens.to_string()).collect::<Vec<_>>()
    };
    let with_product = |m: &ElementModel<'_>| {
        tet4(m);
        m.product();
    };
    assert_eq!(texts(tet4), texts(with_product));
}

#[test]
fn energies_and_residuals_have_products() {
    check(spring, &[&[0.1, 0.2, -0.3, 1.0, 0.4, 0.2], &[3.0], &[0.7]], &[]);
    let formulas = |m: &ElementModel<'_>| {
        let (x, k): (Vec3<'_>, Expr<'_>) = (m.variable("x"), m.parameter("k"));
        let length = m.define("length", x.norm());
        m.residual("force", (1.0 - (-length / k).exp()) * x);
        m.residual("stretch", length.ln());
        m.energy(length.powi(3) * x[0].max(0.2 * x[1]).atan2(x[2]));
        m.value("direction", x.unit());
    };
    check(formulas, &[&[0.4, -0.3, 0.6], &[0.7]], &[]);
}

#[test]
fn sums_over_points_have_products() {
    let formulas = |m: &ElementModel<'_>| {
        let (x, k): (Vec3<'_>, Expr<'_>) = (m.variable("x"), m.parameter("k"));
        let (xi, weight): (Expr<'_>, Expr<'_>) =
            (m.points("point", &[[-0.5], [0.5]]), m.points("weight", &[[2.0], [3.0]]));
        let length = m.define("length", x.norm());
        m.energy(weight * (0.3 * k * length * (1.0 + xi)).exp());
        m.residual("flow", weight * xi * length * x);
    };
    check(formulas, &[&[0.4, -0.3, 0.6], &[0.7]], &[]);
}

/// Height of a curved surface over a plane.
fn surface<'g>(u: Vec2<'g>) -> Expr<'g> {
    0.3 * u[0] * u[0] - 0.2 * u[0] * u[1] + 0.1 * u[1].powi(3)
}

#[test]
fn roots_and_linear_equations_have_products() {
    let formulas = |m: &ElementModel<'_>| {
        let (x, scale): (Vector<'_, 4>, Expr<'_>) = (m.variable("x"), m.parameter("scale"));
        let limits = Limits { longest_step: 2.0, evaluations: 40 };
        let root = m.root_from("u", x, limits, |u| {
            Vector::from_fn(|k| u[k] + 0.1 * scale * u[(k + 1) % 4].powi(2) - 2.0 * x[k])
        });
        let matrix =
            Matrix::from_fn(|i, j| if i == j { m.sheet().zero() } else { x[i] + (1.0 + j as f64) * x[3] });
        let solution = m.solve("v", matrix, Vec3::from_fn(|k| root.unknowns[k]));
        m.energy(solution.unknowns.dot(solution.unknowns) * root.unknowns[3]);
        m.residual("both", Vector([solution.unknowns[1], root.unknowns[0]]));
    };
    check(formulas, &[&[0.9, 1.2, 0.7, 1.1], &[0.8]], &[]);
    let foot = |m: &ElementModel<'_>| {
        let x: Vec3<'_> = m.variable("x");
        let foot = m.minimum("foot", |u| {
            0.5 * ((x[0] - u[0]).powi(2) + (x[1] - u[1]).powi(2) + (x[2] - surface(u)).powi(2))
        });
        m.energy((x[2] - surface(foot.unknowns)).powi(2));
    };
    check(foot, &[&[0.2, -0.1, 0.4]], &[]);
}

/// Positions around the origin, with a weight each.
const CLOUD: [&[f64]; 7] = [
    &[0.1, 0.2, 0.05, 1.1],
    &[1.0, -0.1, 0.2, 0.8],
    &[0.2, 0.9, -0.1, 1.3],
    &[-0.9, 0.1, 0.15, 0.7],
    &[-0.1, -1.0, 0.1, 0.9],
    &[0.8, 0.7, 0.3, 1.2],
    &[-0.7, 0.8, 0.1, 0.6],
];

#[test]
fn sums_over_nodes_have_products() {
    let formulas = |m: &ElementModel<'_>| {
        let (x, stiffness): (Vec3<'_>, Expr<'_>) = (m.variable("x"), m.parameter("stiffness"));
        let (X, w): (Vec3<'_>, Expr<'_>) = (m.node_variable("X"), m.node_parameter("w"));
        let mean = m.define("mean", X.map(|X| (w * X).sum() / w.sum()));
        let scatter = (w * (X - mean).dot(X - mean).powi(2)).sum();
        m.energy(0.5 * stiffness * (x - mean).dot(x - mean) + 0.3 * scatter.sqrt() * x[0]);
        m.residual("gap", (x - mean) * scatter);
    };
    check(formulas, &[&[0.2, -0.4, 0.9], &[1.7]], &CLOUD);
    check(formulas, &[&[0.2, -0.4, 0.9], &[1.7]], &CLOUD[..2]);
}

/// Without variables of the element itself.
#[test]
fn nodes_alone_have_products() {
    let formulas = |m: &ElementModel<'_>| {
        let (X, w): (Vec3<'_>, Expr<'_>) = (m.node_variable("X"), m.node_parameter("w"));
        let inertia = m.define("inertia", (w * X.dot(X)).sum());
        m.energy(inertia.ln() * (w * X[0]).sum());
        m.residual("height", (w * X[2]).sum() / inertia);
    };
    check(formulas, &[], &CLOUD);
}

#[test]
fn fits_have_products_with_and_without_conditions() {
    let formulas = |m: &ElementModel<'_>| {
        let x: Vec3<'_> = m.variable("x");
        let (X, scale): (Vec3<'_>, Expr<'_>) = (m.node_variable("X"), m.node_parameter("scale"));
        let [a, b, z] = m.define("local", X - x).0;
        let w = m.define("w", scale * (1.0 - (a * a + b * b) / 4.0).powi(3));
        let fit = m.stationary("alpha", |alpha: Vec3<'_>| {
            let e = z - dot([m.sheet().one(), a, b], alpha.0);
            0.5 * w * e * e
        });
        let [height, slope, _] = fit.unknowns.0;
        m.energy(0.5 * height * height + 0.2 * slope.exp());
        m.residual("plane", fit.unknowns);
    };
    check(formulas, &[&[0.02, -0.05, 0.3]], &CLOUD);
    let conditioned = |m: &ElementModel<'_>| {
        let (X, w): (Vec3<'_>, Expr<'_>) = (m.node_variable("X"), m.node_parameter("w"));
        let mass = m.define("mass", (w * X[0] * X[0]).sum());
        let fit = m.stationary("c", |c: Vec3<'_>| {
            let e = X[1] - c[0] - c[1] * X[0];
            (0.5 * w * e * e).sum() + 0.05 * c[0] * c[0] + c[2] * (c[0] + c[1] - mass)
        });
        m.energy(fit.unknowns[0] * fit.unknowns[1] + mass.ln());
    };
    check(conditioned, &[], &CLOUD);
}

/// Four unknowns of equations that depend on the nodes: their derivatives come from equations that the kernel solves.
#[test]
fn roots_of_sums_have_products() {
    let formulas = |m: &ElementModel<'_>| {
        let x: Vec3<'_> = m.variable("x");
        let (X, w): (Vec3<'_>, Expr<'_>) = (m.node_variable("X"), m.node_parameter("w"));
        let mean = m.define("mean", X.map(|X| (w * X).sum() / w.sum()));
        let root = m.root("u", |u: Vector<'_, 4>| {
            Vector::from_fn(|k| u[k] + 0.2 * u[(k + 1) % 4].powi(2) - 0.3 * (mean[k % 3] - x[k % 3]))
        });
        m.energy(root.unknowns.dot(root.unknowns) + root.unknowns[0] * mean[1]);
    };
    check(formulas, &[&[0.5, -0.6, 0.9]], &CLOUD);
}

#[test]
fn a_product_of_nothing_is_refused() {
    let error = ElementKernels::new("test", |m| {
        let x: Vec3<'_> = m.variable("x");
        m.value("length", x.norm());
        m.product();
    });
    assert_eq!(error.unwrap_err(), ElementError::NoProduct);
    let error = ElementKernels::new("test", |m| {
        let x: Vec3<'_> = m.variable("x");
        m.energy(x.norm());
        m.value("hessian_product", x);
        m.product();
    });
    assert_eq!(error.unwrap_err(), ElementError::Duplicate { name: "hessian_product".to_owned() });
}
