//! The ways to evaluate an element that are compared.

use diffuse_contact_kernels::support::Isa;

use crate::batch::GapInBatches;
use crate::contender::{Contender, GENERATED_BATCH, GENERATED_SINGLE, Output, Run};
use crate::generated::one_by_one;
use crate::{Elements, by_hand, dual};

type Prepare = for<'a> fn(&'a Elements, Output, Isa) -> Option<Box<dyn Run + 'a>>;

const fn generated(kernel: &'static str, output: Output, prepare: Prepare) -> Contender {
    Contender { kernel, output, prepare, counted: true }
}

const fn rival(kernel: &'static str, prepare: Prepare) -> Contender {
    Contender { kernel, output: Output::GapHessian, prepare, counted: false }
}

const SINGLE: Prepare = |elements, output, isa| Some(one_by_one(elements, output, isa));
const BATCH: Prepare = |elements, output, isa| Some(Box::new(GapInBatches::new(elements, output, isa)));

/// All contenders. One more is one more entry here and its [`Run`].
pub const CONTENDERS: [Contender; 10] = [
    generated(GENERATED_SINGLE, Output::GapHessian, SINGLE),
    generated(GENERATED_SINGLE, Output::GapGradient, SINGLE),
    generated(GENERATED_SINGLE, Output::GapCoMovingHessian, SINGLE),
    generated(GENERATED_SINGLE, Output::SurfaceHessian, SINGLE),
    generated(GENERATED_BATCH, Output::GapHessian, BATCH),
    generated(GENERATED_BATCH, Output::GapGradient, BATCH),
    generated(GENERATED_BATCH, Output::GapCoMovingHessian, BATCH),
    rival("by-hand-nalgebra", |elements, _, _| by_hand::prepare(elements)),
    rival("num-dual-dual2-vec", |elements, _, _| dual::prepare_vectors(elements)),
    rival("num-dual-hyper-dual", |elements, _, _| dual::prepare_pairs(elements)),
];
