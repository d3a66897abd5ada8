//! Elements summed over quadrature points: the loop's body by the interpreter, point by point, against automatic differentiation.
#![allow(non_snake_case)]

use diffuse_contact_codegen::emit::emit_element_kernel;
use diffuse_contact_codegen::expr::{Expr, Mat3, Vec3, Vector, total};
use diffuse_contact_codegen::interpret::{element_derivatives, element_results};
use diffuse_contact_codegen::{Config, ConfigError, ElementError, ElementKernels, ElementModel};
use num_dual::{DualNum, HyperDual};

use crate::witnesses::random;

/// Corners of the cube in natural coordinates.
const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

fn points() -> [[f64; 3]; 8] {
    CORNERS.map(|corner| corner.map(|x| x / 3.0_f64.sqrt()))
}

/// A hexahedron of compressible neo-Hooke material with eight points.
fn hex8(m: &ElementModel<'_>) {
    let (x, X): ([Vec3<'_>; 8], [Vec3<'_>; 8]) = (m.variable("x"), m.parameter("X"));
    let [lambda, mu] = m.parameters(["lambda", "mu"]);
    let xi: Vec3<'_> = m.points("xi", &points());
    let N = CORNERS.map(|c| 0.125 * (1.0 + c[0] * xi[0]) * (1.0 + c[1] * xi[1]) * (1.0 + c[2] * xi[2]));
    let [d, D] = [x, X].map(|x| Mat3::from_fn(|i, j| total((0..8).map(|k| x[k][i] * N[k].by(xi[j])))));
    let F = m.define("F", d * D.inverse());
    let J = m.define("J", F.determinant());
    let W = 0.5 * mu * (F.double_dot(F) - 3.0) - mu * J.ln() + 0.5 * lambda * J.ln().powi(2);
    m.energy(D.determinant() * W);
}

/// The same energy for numbers of any kind, with W(F) from nowᵀ = F beforeᵀ and determinants.
fn energy<D: DualNum<Primitive = f64> + Copy>(x: &[D], X: &[f64], [lambda, mu]: [f64; 2]) -> D {
    let sum = |terms: &mut dyn Iterator<Item = D>| terms.fold(D::from(0.0), |sum, term| sum + term);
    let det = |a: &[[D; 3]; 3]| {
        let minor = |i: usize, j: usize| a[1][i] * a[2][j] - a[1][j] * a[2][i];
        a[0][0] * minor(1, 2) - a[0][1] * minor(0, 2) + a[0][2] * minor(0, 1)
    };
    let of_point = |xi: [f64; 3]| {
        let slope = |k: usize, j: usize| {
            let factor =
                |axis: usize| if axis == j { CORNERS[k][axis] } else { 1.0 + CORNERS[k][axis] * xi[axis] };
            factor(0) * factor(1) * factor(2) / 8.0
        };
        // Rows belong to natural coordinates, columns to axes.
        let rows = |x: &dyn Fn(usize) -> D| {
            [0, 1, 2].map(|j| [0, 1, 2].map(|i| sum(&mut (0..8).map(|k| x(3 * k + i) * slope(k, j)))))
        };
        let (now, before) = (rows(&|k| x[k]), rows(&|k| D::from(X[k])));
        let mut trace = D::from(0.0);
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let mut replaced = before;
            (0..3).for_each(|row| replaced[row][j] = now[row][i]);
            let f = det(&replaced) / det(&before);
            trace += f * f;
        }
        let log = (det(&now) / det(&before)).ln();
        det(&before) * ((trace - 3.0) * (0.5 * mu) - log * mu + log * log * (0.5 * lambda))
    };
    sum(&mut points().into_iter().map(of_point))
}

#[test]
fn a_hexahedron_has_the_derivatives_of_automatic_differentiation() {
    let element = ElementKernels::new("hex8", hex8).unwrap();
    let mut seed = 0.37;
    let mut moved =
        |by: f64| -> Vec<f64> { CORNERS.as_flattened().iter().map(|x| x + by * random(&mut seed)).collect() };
    let (x, X, constants) = (moved(0.5), moved(0.3), [1.7, 0.9]);
    let inputs: [&[f64]; 4] = [&x, &X, &constants[..1], &constants[1..]];
    let found = element_results(element.kernels.last().unwrap(), &inputs, &[]);
    let found: Vec<f64> = found.into_iter().flat_map(|(_, x)| x).collect();
    let at = |i: usize, j: usize| {
        let is = |k: usize, other: usize| f64::from(u8::from(k == other));
        let seeded = |(k, &x): (usize, &f64)| HyperDual::new(x, is(k, i), is(k, j), 0.0);
        energy(&x.iter().enumerate().map(seeded).collect::<Vec<_>>(), &X, constants)
    };
    let gradient: Vec<f64> = (0..24).map(|i| at(i, i).eps1).collect();
    let pairs = (0..24).flat_map(|i| (0..=i).map(move |j| (i, j)));
    let hessian: Vec<f64> = pairs.map(|(i, j)| at(i, j).eps1eps2).collect();
    let parts = [vec![energy(&x, &X, constants)], gradient, hessian];
    let (mut place, mut worst) = (0, 0.0_f64);
    for expected in parts {
        let largest = expected.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        for y in expected {
            worst = worst.max((found[place] - y).abs() / largest);
            place += 1;
        }
    }
    let expanded: Vec<f64> =
        element_derivatives(&element, &inputs, &[]).into_iter().flat_map(|(_, x)| x).collect();
    assert_eq!(expanded.len(), 24 + 300);
    for (part, expected) in [(&expanded[..24], &found[1..25]), (&expanded[24..], &found[25..])] {
        worst = worst.max(crate::witnesses::difference(part, expected));
    }
    println!("largest relative difference {worst:.1e}");
    assert!(place == found.len() && worst < 1e-12, "{worst:e}");
}

#[test]
fn a_sum_over_points_is_a_loop() {
    let element = ElementKernels::new("hex8", hex8).unwrap();
    let kernels: Vec<_> = element.kernels.iter().map(emit_element_kernel).collect();
    let operations: Vec<usize> = kernels.iter().map(|kernel| kernel.counts.total()).collect();
    let statements: Vec<usize> = kernels.iter().map(|kernel| kernel.statements).collect();
    let text = kernels[2].tokens.to_string();
    println!(
        "{operations:?} operations, {statements:?} statements, {} bytes of the Hessian's kernel",
        text.len()
    );
    assert!(text.contains("for point in 0 .. 8usize"), "{text}");
    assert!(operations[2] <= 20_000 && statements[2] < 1_700, "{operations:?} {statements:?}");
    assert!(text.len() < 100_000, "{}", text.len());
}

/// What is the same at all points is computed before the loop.
#[test]
fn what_does_not_depend_on_the_point_is_before_the_loop() {
    let element = ElementKernels::new("test", |m| {
        let (x, k): (Vec3<'_>, Expr<'_>) = (m.variable("x"), m.parameter("k"));
        let [xi, weight] =
            [m.points::<Expr<'_>>("xi", &[[-0.5], [0.5]]), m.points("weight", &[[2.0], [3.0]])];
        let length = m.define("length", x.norm());
        m.energy(weight * (k * length * (1.0 + xi)).exp());
    });
    let text = emit_element_kernel(&element.unwrap().kernels[0]).tokens.to_string();
    let (before, inside) = text.split_once("for point").unwrap();
    assert!(before.contains("let length") && !inside.contains("sqrt") && inside.contains("exp"), "{text}");
    // 1 + ξ is another number of the points.
    let table = "[[- 0.5f64 , 2f64 , 0.5f64] , [0.5f64 , 3f64 , 1.5f64]]";
    assert!(before.contains(table) || before.contains(&table.replace("- ", "-")), "{before}");
}

#[test]
fn tables_that_do_not_fit_are_named() {
    let tables: [fn(&ElementModel<'_>); 3] = [
        |m| drop(m.points::<Vector<'_, 2>>("xi", &[vec![0.1], vec![0.2]]).0.to_vec()),
        |m| drop(m.points::<Vector<'_, 1>>("xi", &[[0.0; 1]; 0]).0.to_vec()),
        |m| {
            let _: Expr<'_> = m.points("zeta", &[[0.1], [0.2]]);
            let _: Expr<'_> = m.points("xi", &[[0.1]]);
        },
    ];
    for table in tables {
        let error = Config::new().element("shell", table).unwrap_err();
        let text = error.to_string();
        let ConfigError::Element { source, .. } = error else { panic!("{text}") };
        assert_eq!(source, ElementError::Points { name: "xi".to_owned() });
        assert!(text.contains("\"shell\"") && text.contains("`xi`"), "{text}");
    }
}

/// Operations before a root, and of its iteration, are counted, and no more than there are.
#[test]
fn roots_at_points_are_counted() {
    let element = ElementKernels::new("test", |m| {
        let (x, xi): (Expr<'_>, Expr<'_>) = (m.variable("x"), m.points("xi", &[[-0.5], [0.5]]));
        let u = m.root("u", |u: Vector<'_, 1>| Vector([u[0].exp() * u[0].sin() + xi * u[0].cos() - x.exp()]));
        m.value("total", u.unknowns[0]);
    });
    let element = element.unwrap();
    for kernel in &element.kernels {
        let emitted = emit_element_kernel(kernel);
        let (total, iteration) = (emitted.counts.total(), emitted.iteration.total());
        assert!(iteration >= 6 && total > iteration && total < 100, "{total} {iteration}");
    }
}
