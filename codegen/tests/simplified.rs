//! Programs of random operations: their graph, with all that its constructors simplify, against the same operations on numbers.

use diffuse_contact_codegen::expr::{Expr, Sheet};
use diffuse_contact_codegen::graph::Scope;
use diffuse_contact_codegen::interpret::{Interpreter, NodeInputs};
use num_dual::{DualNum, HyperDual};

const NODES: usize = 3;
/// Few, so that equal ones meet.
const CONSTANTS: [f64; 8] = [1.0, 2.0, 3.0, 0.5, 1.5, -1.0, -2.0, 0.25];
/// Programs with larger or smaller results of an operation are left out: their digits are those of rounding.
const RANGE: f64 = 1e3;

/// An instruction: what it does, and the places of its operands among the results before it.
#[derive(Clone, Copy, Debug)]
enum Step {
    X,
    Y,
    /// One of each node.
    A,
    Number(f64),
    Add(usize, usize),
    Sub(usize, usize),
    Mul(usize, usize),
    Div(usize, usize),
    Neg(usize),
    Power(usize, i32),
    Sqrt(usize),
    Exp(usize),
    Sin(usize),
    Sum(usize),
}

/// Numbers that look random (Marsaglia 2003).
struct Random(u64);

impl Random {
    fn below(&mut self, count: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % count
    }

    fn program(&mut self) -> Vec<Step> {
        let mut steps = vec![Step::X, Step::Y, Step::A];
        for _ in 0..8 + self.below(16) {
            // What was made last is used more often.
            let mut place = |count: usize| count - 1 - self.below(count).min(self.below(count));
            let (x, y) = (place(steps.len()), place(steps.len()));
            steps.push(match self.below(20) {
                0..5 => Step::Number(CONSTANTS[self.below(CONSTANTS.len())]),
                5..9 => Step::Add(x, y),
                9..11 => Step::Sub(x, y),
                11..14 => Step::Mul(x, y),
                14 => Step::Div(x, y),
                15 => Step::Neg(x),
                16 => Step::Power(x, [2, 3, -1, -2][self.below(4)]),
                17 => [Step::Sqrt(x), Step::Exp(x)][self.below(2)],
                18 => Step::Sin(x),
                _ => Step::Sum(x),
            });
        }
        steps
    }
}

fn graph<'g>(sheet: &'g Sheet, steps: &[Step]) -> Vec<Expr<'g>> {
    let mut all: Vec<Expr<'g>> = Vec::new();
    for &step in steps {
        all.push(match step {
            Step::X => sheet.input("x", Scope::Element),
            Step::Y => sheet.input("y", Scope::Element),
            Step::A => sheet.input("a", Scope::Node),
            Step::Number(value) => sheet.number(value),
            Step::Add(x, y) => all[x] + all[y],
            Step::Sub(x, y) => all[x] - all[y],
            Step::Mul(x, y) => all[x] * all[y],
            Step::Div(x, y) => all[x] / all[y],
            Step::Neg(x) => -all[x],
            Step::Power(x, exponent) => all[x].powi(exponent),
            Step::Sqrt(x) => all[x].sqrt(),
            Step::Exp(x) => all[x].exp(),
            Step::Sin(x) => all[x].sin(),
            Step::Sum(x) => all[x].sum(),
        });
    }
    all
}

type Dual = HyperDual<f64>;

/// The same at each node; `None` if a number leaves the range.
fn numbers(steps: &[Step], [x, y]: [Dual; 2], a: [f64; NODES]) -> Option<[Dual; NODES]> {
    let mut all: Vec<[Dual; NODES]> = Vec::new();
    for &step in steps {
        let of = |k: usize, f: &dyn Fn(Dual) -> Dual| all[k].map(f);
        let both = |k: usize, l: usize, f: &dyn Fn(Dual, Dual) -> Dual| -> [Dual; NODES] {
            std::array::from_fn(|node| f(all[k][node], all[l][node]))
        };
        let result = match step {
            Step::X => [x; NODES],
            Step::Y => [y; NODES],
            Step::A => a.map(Dual::from),
            Step::Number(value) => [Dual::from(value); NODES],
            Step::Add(k, l) => both(k, l, &|x, y| x + y),
            Step::Sub(k, l) => both(k, l, &|x, y| x - y),
            Step::Mul(k, l) => both(k, l, &|x, y| x * y),
            Step::Div(k, l) => both(k, l, &|x, y| x / y),
            Step::Neg(k) => of(k, &|x| -x),
            Step::Power(k, exponent) => of(k, &|x| x.powi(exponent)),
            Step::Sqrt(k) => of(k, &|x| x.sqrt()),
            Step::Exp(k) => of(k, &|x| x.exp()),
            Step::Sin(k) => of(k, &|x| x.sin()),
            Step::Sum(k) => [all[k].into_iter().fold(Dual::from(0.0), |sum, x| sum + x); NODES],
        };
        let is_tame = |x: &Dual| {
            let derivatives = [x.eps1, x.eps2, x.eps1eps2];
            // Exact zeros are of terms that cancel, next to which others are of rounding.
            (1.0 / RANGE..RANGE).contains(&x.re.abs()) && derivatives.iter().all(|x| x.abs() < RANGE)
        };
        if !result.iter().all(is_tame) {
            return None;
        }
        all.push(result);
    }
    all.pop()
}

#[test]
fn what_constructors_simplify_is_what_was_written() {
    let (at, a) = ([0.7, -1.3], [0.4, 1.1, -0.6]);
    let mut random = Random(0x5eed);
    let mut compared = 0;
    for _ in 0..60_000 {
        let steps = random.program();
        let seeded = |i: usize, j: usize| {
            let is = |k: usize, other: usize| f64::from(u8::from(k == other));
            [0, 1].map(|k| Dual::new(at[k], is(k, i), is(k, j), 0.0))
        };
        let pairs = [(0, 0), (0, 1), (1, 1)];
        let found: Option<Vec<_>> = pairs.iter().map(|&(i, j)| numbers(&steps, seeded(i, j), a)).collect();
        let Some(expected) = found else { continue };
        let sheet = Sheet::new();
        let all = graph(&sheet, &steps);
        let (variables, result) = ([all[0], all[1]], all[all.len() - 1]);
        let derivatives = variables.map(|x| result.by(x));
        let of_graph = [0, 1, 2].map(|k| {
            let (i, j) = pairs[k];
            [result, derivatives[i], derivatives[j], derivatives[i].by(variables[j])].map(Expr::id)
        });
        let graph = sheet.into_graph();
        let mut inputs = NodeInputs::new(NODES);
        inputs.set_element("x", at[0]);
        inputs.set_element("y", at[1]);
        inputs.set_node("a", a.to_vec());
        let mut interpreter = Interpreter::new(&graph, &inputs);
        for (expressions, expected) in of_graph.iter().zip(&expected) {
            for (node, expected) in expected.iter().enumerate() {
                let found = expressions.map(|x| interpreter.node(x, node));
                let expected = [expected.re, expected.eps1, expected.eps2, expected.eps1eps2];
                for (found, expected) in found.into_iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-6, "{found} instead of {expected}: {steps:?}");
                }
            }
        }
        compared += 1;
    }
    assert!(compared > 12_000, "{compared}");
}

/// Equal numbers meet as terms of sums.
#[test]
fn numbers_written_twice_count_twice() {
    let sheet = Sheet::new();
    let x = sheet.input("x", Scope::Element);
    let (sum, square, cube) = (x.sin(), x * x, x.powi(3));
    let cases = [
        (x + 3.0 + 3.0 + x, 7.0),
        (x + 1.5 + 1.5 + 2.0, 5.5),
        ((x - 3.0) - 3.0 + x, -5.0),
        ((x + 2.0) + (square + 2.0) + (cube + 2.0), 6.875),
        ((sum + 0.5) + (x + 0.5) + (square + 0.5) + (cube + 0.5), 0.5_f64.sin() + 2.875),
    ]
    .map(|(x, expected)| (x.id(), expected));
    let graph = sheet.into_graph();
    let mut inputs = NodeInputs::new(0);
    inputs.set_element("x", 0.5);
    for (k, (x, expected)) in cases.into_iter().enumerate() {
        let found = Interpreter::new(&graph, &inputs).element(x);
        assert!((found - expected).abs() < 1e-15, "{k}: {found} instead of {expected}");
    }
}
