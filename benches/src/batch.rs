//! The generated kernels for many elements at once as a contender.

use diffuse_contact_kernels::cubic::Cubic;
use diffuse_contact_kernels::support::{BatchElement, GapValues, Isa, KernelSet, Status, Workspace};

use crate::Elements;
use crate::contender::{Evaluation, NoResult, Output, Run};
use crate::generated::{element, gap_kernel, hessian_size, inputs};

/// Elements of a batch: enough for several of the widest vectors, few enough for their results to stay in the cache.
const BATCH: usize = 16;

/// One batch after another, with the checks that [`one_by_one`](crate::generated::one_by_one) makes, too. Results are
/// written element by element.
pub struct GapInBatches<'a> {
    elements: &'a Elements,
    output: Output,
    isa: Isa,
    next: usize,
    workspace: Workspace,
    /// N of each element of a batch.
    gradients: Vec<f64>,
    /// Packed lower triangle of M of each.
    hessians: Vec<f64>,
}

impl<'a> GapInBatches<'a> {
    /// For these elements; `output` is one of the gap's.
    ///
    /// # Panics
    /// If the output is a surface.
    pub fn new(elements: &'a Elements, output: Output, isa: Isa) -> Self {
        let gradients = vec![0.0; BATCH * elements.degrees_of_freedom()];
        let hessians = vec![0.0; BATCH * hessian_size(elements, output)];
        let mut batches =
            Self { elements, output, isa, next: 0, workspace: Workspace::default(), gradients, hessians };
        // The workspace has its size from now on.
        let _ = batches.evaluate(0, BATCH);
        batches
    }

    /// Evaluates the elements from `first` on, after the last one again the first; their gaps.
    #[inline]
    fn evaluate(&mut self, first: usize, count: usize) -> Result<[f64; BATCH], NoResult> {
        let Self { elements, output, isa, workspace, gradients, hessians, .. } = self;
        let (elements, output) = (*elements, *output);
        let mut gradients = gradients.chunks_exact_mut(elements.degrees_of_freedom());
        // A chunk of no entries would be none.
        let mut hessians = hessians.chunks_exact_mut(hessian_size(elements, output).max(1));
        let mut unsound = None;
        let mut batch: [BatchElement<'_>; BATCH] = std::array::from_fn(|place| {
            let index = (first + place) % elements.len();
            let element = element(elements, output, index);
            if place < count && element.validate().is_err() {
                unsound = unsound.or(Some(NoResult { element: index }));
            }
            BatchElement {
                inputs: inputs(&element, [0.0; 2]),
                values: GapValues::NONE,
                gradient: gradients.next().unwrap_or_default(),
                hessian: hessians.next().unwrap_or_default(),
                places: &[],
            }
        });
        unsound.map_or(Ok(()), Err)?;
        let batch = &mut batch[..count];
        Cubic::gap_batch(*isa, gap_kernel(output), batch, workspace);
        let mut gaps = [0.0; BATCH];
        for (place, (gap, element)) in gaps.iter_mut().zip(batch).enumerate() {
            if element.values.status() != Status::Ok {
                return Err(NoResult { element: (first + place) % elements.len() });
            }
            // Foot and normal count as used, too.
            *gap = std::hint::black_box(element.values).gap;
        }
        Ok(gaps)
    }
}

impl Run for GapInBatches<'_> {
    fn run(&mut self, count: usize) -> Result<(), NoResult> {
        let mut left = count;
        while left > 0 {
            let size = left.min(BATCH);
            std::hint::black_box(self.evaluate(self.next, size)?);
            std::hint::black_box((&mut self.gradients, &mut self.hessians));
            self.next = (self.next + size) % self.elements.len();
            left -= size;
        }
        Ok(())
    }

    fn evaluation(&mut self, element: usize) -> Result<Evaluation, NoResult> {
        self.gradients.fill(f64::NAN);
        self.hessians.fill(f64::NAN);
        // Every place of a batch has its turn.
        let place = element % BATCH;
        let first = element - place;
        let value = self.evaluate(first, BATCH)?[place];
        let (freedoms, packed) =
            (self.elements.degrees_of_freedom(), hessian_size(self.elements, self.output));
        Ok(Evaluation {
            value,
            gradient: self.gradients[place * freedoms..][..freedoms].to_vec(),
            hessian: self.hessians[place * packed..][..packed].to_vec(),
        })
    }
}
