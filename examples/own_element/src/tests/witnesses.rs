//! What the kernels are compared with: the interpreter of the same formulas, and automatic differentiation of functions written again.

use diffuse_contact_codegen::interpret::element_results;
use diffuse_contact_codegen::{ElementKernels, ElementModel};
use num_dual::{DualNum, HyperDual};

/// Numbers of the functions that automatic differentiation evaluates.
pub trait Number: DualNum<Primitive = f64> + Copy {}
impl<D: DualNum<Primitive = f64> + Copy> Number for D {}

/// A function of variables, for numbers of any kind.
pub trait Function {
    fn at<D: Number>(&self, x: &[D]) -> D;
}

/// Results of a kernel as lists of numbers.
pub struct Found<'a> {
    pub value: f64,
    pub gradient: &'a [f64],
    pub hessian: &'a [f64],
}

/// Numbers in (−½, ½) that look random, always the same ones.
pub fn random(seed: f64) -> impl FnMut() -> f64 {
    let mut value = seed;
    move || {
        value = (value * 7.3 + 0.17).fract();
        value - 0.5
    }
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

/// Value, gradient, and the Hessian's product with two vectors, against hyper-dual numbers: by each variable once and along the vector.
/// An entry that is wrong shows in the product with almost any vector.
pub fn check_by_hyper_dual(found: &Found<'_>, x: &[f64], function: &impl Function) {
    for seed in [0.37, 0.71] {
        let mut random = random(seed);
        let along: Vec<f64> = x.iter().map(|_| random()).collect();
        let by = |i: usize| {
            let seeded =
                |(k, &x): (usize, &f64)| HyperDual::new(x, f64::from(u8::from(k == i)), along[k], 0.0);
            function.at(&x.iter().enumerate().map(seeded).collect::<Vec<_>>())
        };
        let expected: Vec<HyperDual<f64>> = (0..x.len()).map(by).collect();
        let of = |part: fn(&HyperDual<f64>) -> f64| expected.iter().map(part).collect::<Vec<f64>>();
        let entry = |i: usize, j: usize| found.hessian[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
        let product: Vec<f64> =
            (0..x.len()).map(|i| (0..x.len()).map(|j| entry(i, j) * along[j]).sum()).collect();
        let worst = difference(&[found.value], &[expected[0].re])
            .max(difference(found.gradient, &of(|x| x.eps1)))
            .max(difference(&product, &of(|x| x.eps1eps2)));
        assert!(worst < 1e-12, "automatic differentiation: {worst:e}");
    }
}

/// Results with all derivatives by name, from the formulas by the interpreter; `inputs` in the order of their declaration, then those of
/// each node.
pub fn interpreted(
    formulas: fn(&ElementModel<'_>),
    inputs: &[&[f64]],
    nodes: &[&[f64]],
) -> impl Fn(&str) -> Vec<f64> + use<> {
    let element = ElementKernels::new("interpreted", formulas).unwrap();
    let all = element_results(element.kernels.last().unwrap(), inputs, nodes);
    move |name| all.iter().find(|(other, _)| other == name).unwrap().1.clone()
}

/// Energy, gradient and Hessian against the interpreter.
pub fn check_by_interpreter(
    found: &Found<'_>,
    formulas: fn(&ElementModel<'_>),
    inputs: &[&[f64]],
    nodes: &[&[f64]],
) {
    let expected = interpreted(formulas, inputs, nodes);
    let worst = difference(&[found.value], &expected("energy"))
        .max(difference(found.gradient, &expected("gradient")))
        .max(difference(found.hessian, &expected("hessian")));
    assert!(worst < 1e-12, "interpreter: {worst:e}");
}
