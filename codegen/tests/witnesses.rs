//! What elements are compared with.
#![allow(non_snake_case)]

use diffuse_contact_codegen::expr::{Mat3, Vec3};
use diffuse_contact_codegen::interpret::element_results;
use diffuse_contact_codegen::{ElementKernels, ElementModel, Mode};
use num_dual::{DualNum, HyperDual};

/// Numbers of the energies that automatic differentiation evaluates.
pub trait Number: DualNum<Primitive = f64> + Copy {}
impl<D: DualNum<Primitive = f64> + Copy> Number for D {}

pub fn sum<D: Number>(terms: impl IntoIterator<Item = D>) -> D {
    terms.into_iter().fold(D::from(0.0), |sum, term| sum + term)
}

/// Gradient and packed Hessian by hyper-dual numbers.
pub fn by_hyper_dual(x: &[f64], f: impl Fn(&[HyperDual<f64>]) -> HyperDual<f64>) -> (Vec<f64>, Vec<f64>) {
    let at = |i: usize, j: usize| {
        let seeded = |(k, &x): (usize, &f64)| {
            let is = |other: usize| f64::from(u8::from(k == other));
            HyperDual::new(x, is(i), is(j), 0.0)
        };
        f(&x.iter().enumerate().map(seeded).collect::<Vec<_>>())
    };
    let gradient = (0..x.len()).map(|i| at(i, i).eps1).collect();
    (
        gradient,
        (0..x.len()).flat_map(|i| (0..=i).map(move |j| (i, j))).map(|(i, j)| at(i, j).eps1eps2).collect(),
    )
}

/// A number in (−0.5, 0.5) that looks random.
pub fn random(seed: &mut f64) -> f64 {
    *seed = (*seed * 7.3 + 0.17).fract();
    *seed - 0.5
}

/// As many of these.
pub fn numbers(count: usize, mut seed: f64) -> Vec<f64> {
    (0..count).map(|_| random(&mut seed)).collect()
}

/// Results of a kernel by the interpreter, by name.
pub fn interpreted(
    element: &ElementKernels,
    mode: Mode,
    inputs: &[&[f64]],
    nodes: &[&[f64]],
) -> impl Fn(&str) -> Vec<f64> + use<> {
    let kernel = element.kernels.iter().find(|kernel| kernel.spec.mode == mode).unwrap();
    let all = element_results(kernel, inputs, nodes);
    move |name| all.iter().find(|(other, _)| other == name).unwrap().1.clone()
}

/// Largest difference over the largest entry; a NaN is larger than anything.
pub fn difference(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let largest = expected.iter().fold(f64::MIN_POSITIVE, |largest: f64, x| largest.max(x.abs()));
    found.iter().zip(expected).fold(0.0, |worst: f64, (x, y)| {
        let difference = (x - y).abs() / largest;
        if worst.is_nan() || difference <= worst { worst } else { difference }
    })
}

/// The element whose texts are checked in.
pub fn spring(m: &ElementModel<'_>) {
    m.title("A spring between two points, linear in its stretch.");
    let x: [Vec3<'_>; 2] = m.variable("x");
    let [stiffness, length] = m.parameters(["stiffness", "length"]);
    m.describe("x", "Ends, length.");
    m.describe("length", "Length without force.");
    let stretch = m.define("stretch", (x[1] - x[0]).norm() - length);
    m.energy(0.5 * stiffness * stretch.powi(2));
    m.value("force", stiffness * stretch);
    m.describe("force", "Tension, positive when stretched.");
    m.product();
}

/// A tetrahedron of compressible neo-Hooke material, from its energy.
pub fn tet4(m: &ElementModel<'_>) {
    let (x, X): ([Vec3<'_>; 4], [Vec3<'_>; 4]) = (m.variable("x"), m.parameter("X"));
    let [lambda, mu] = m.parameters(["lambda", "mu"]);
    let [d, D] = [x, X].map(|x| Mat3::from_columns([1, 2, 3].map(|k| x[k] - x[0])));
    let F = m.define("F", d * D.inverse());
    let J = m.define("J", F.determinant());
    let W = 0.5 * mu * (F.double_dot(F) - 3.0) - mu * J.ln() + 0.5 * lambda * J.ln().powi(2);
    m.energy(D.determinant() / 6.0 * W);
}
