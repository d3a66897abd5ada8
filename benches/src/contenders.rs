//! The ways to evaluate an element that are compared.

use diffuse_contact_kernels::support::Isa;

use crate::batch::GapInBatches;
use crate::contender::{Contender, GENERATED_BATCH, GENERATED_SINGLE, Output, Run};
use crate::generated::{GapOneByOne, SurfaceOneByOne};
use crate::{Elements, by_hand, dual};

type Prepare = for<'a> fn(&'a Elements, Isa) -> Option<Box<dyn Run + 'a>>;

const fn generated(kernel: &'static str, output: Output, prepare: Prepare) -> Contender {
    Contender { kernel, output, prepare, counted: true }
}

const fn rival(kernel: &'static str, prepare: Prepare) -> Contender {
    Contender { kernel, output: Output::GapHessian, prepare, counted: false }
}

/// All contenders. One more is one more entry here and its [`Run`].
pub const CONTENDERS: [Contender; 10] = [
    generated(GENERATED_SINGLE, Output::GapHessian, |elements, isa| {
        Some(Box::new(GapOneByOne::new(elements, Output::GapHessian, isa)))
    }),
    generated(GENERATED_SINGLE, Output::GapGradient, |elements, isa| {
        Some(Box::new(GapOneByOne::new(elements, Output::GapGradient, isa)))
    }),
    generated(GENERATED_SINGLE, Output::GapCoMovingHessian, |elements, isa| {
        Some(Box::new(GapOneByOne::new(elements, Output::GapCoMovingHessian, isa)))
    }),
    generated(GENERATED_SINGLE, Output::SurfaceHessian, |elements, _| {
        Some(Box::new(SurfaceOneByOne::new(elements)))
    }),
    generated(GENERATED_BATCH, Output::GapHessian, |elements, isa| {
        Some(Box::new(GapInBatches::new(elements, Output::GapHessian, isa)))
    }),
    generated(GENERATED_BATCH, Output::GapGradient, |elements, isa| {
        Some(Box::new(GapInBatches::new(elements, Output::GapGradient, isa)))
    }),
    generated(GENERATED_BATCH, Output::GapCoMovingHessian, |elements, isa| {
        Some(Box::new(GapInBatches::new(elements, Output::GapCoMovingHessian, isa)))
    }),
    rival("by-hand-nalgebra", |elements, _| by_hand::prepare(elements)),
    rival("num-dual-dual2-vec", |elements, _| dual::prepare_vectors(elements)),
    rival("num-dual-hyper-dual", |elements, _| dual::prepare_pairs(elements)),
];
