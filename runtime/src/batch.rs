//! Many elements at once: those with the same kernel and number of nodes are evaluated side by side.

use diffuse_contact_kernels::support::{
    Basis, BatchElement, ElementInputs, FrameRule, GapValues, KernelSet, SecondKind, Workspace,
};

use crate::kernels::{frame_rule, inputs, validate};
use crate::scratch::recycled;
use crate::weight::with_kernels;
use crate::{ContactPoint, Domains, Element, ElementError, Generated, GeneratedWith, Mode, Weight};

/// Room that batches use, kept from one to the next.
#[derive(Debug, Default)]
pub struct BatchScratch {
    workspace: Workspace,
    /// Which elements go through which kernel, those with the same one after another.
    order: Vec<(Key, usize)>,
    /// Memory of the elements of a group: empty.
    elements: Vec<BatchElement<'static>>,
    /// Memory of the elements that wait: empty.
    waiting: Vec<Waiting<'static, 'static>>,
}

/// A copy has no memory yet.
impl Clone for BatchScratch {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// What elements that go side by side have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    weight: Weight,
    frame: FrameRule,
    basis: Basis,
    nodes: usize,
    has_slip: bool,
}

/// Where the results of one element go. What the mode does not ask for may be empty and is not touched.
#[derive(Debug, Default)]
pub struct GapSlot<'a> {
    /// N, 3(n+1) entries.
    pub gradient: &'a mut [f64],
    /// M, packed lower triangle: see [`SymmetricMatrix`](crate::SymmetricMatrix).
    pub hessian: &'a mut [f64],
}

impl Key {
    /// Whether an element goes side by side with the one before it.
    fn goes_beside(&self, other: &Self, asked: Asked) -> bool {
        let may_differ =
            self.frame == FrameRule::Material && !self.has_slip && matches!(asked, Asked::Mode(_));
        let nodes = if may_differ { self.nodes } else { other.nodes };
        *self == Self { nodes, ..*other }
    }
}

impl Generated {
    /// [`gap_into`](Self::gap_into) for many elements, which may differ in everything: those that share weight, basis,
    /// frame rule and number of nodes, or with domains in the first configuration have nearly as many, are evaluated side by
    /// side, one per lane of the machine's vectors. What an element gets does not depend on the others; it differs from what `gap_into`
    /// gives by rounding. Allocates the vector it returns, and more only where `scratch` has to grow.
    ///
    /// # Errors
    /// An entry for each element, as [`gap_into`](Self::gap_into).
    ///
    /// # Panics
    /// If there are not as many slots as elements, or a slice is shorter than its mode needs.
    ///
    /// ```
    /// use diffuse_contact::{BatchScratch, Basis, Element, Frame, GapSlot, Generated, Mode, Weight};
    ///
    /// let masters: Vec<[f64; 3]> =
    ///     (0..9).map(|k| [f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, 0.0]).collect();
    /// let frame = Frame::average_plane(&masters, [0.0, 0.0, 1.0])?;
    /// let (basis, weight) = (Basis::Quadratic, Weight::Cubic);
    /// let heights = [0.25, 0.5, -0.125];
    /// let elements = heights.map(|z| Element::new([0.1, 0.2, z], &masters, frame, 2.0).with_basis(basis).with_weight(weight));
    /// // N of all elements, 3(n+1) entries each.
    /// let mut gradients = vec![0.0; 3 * 30];
    /// let slots = gradients.chunks_mut(30).map(|gradient| GapSlot { gradient, ..GapSlot::default() });
    /// let mut scratch = BatchScratch::default();
    /// let contacts = Generated.gap_batch(&elements, Mode::Gradient, slots, &mut scratch);
    /// for (contact, z) in contacts.into_iter().zip(heights) {
    ///     assert!((contact?.gap - z).abs() < 1e-14);
    /// }
    /// # Ok::<(), diffuse_contact::ElementError>(())
    /// ```
    pub fn gap_batch<'a>(
        &self,
        elements: &[Element<'_>],
        mode: Mode,
        slots: impl IntoIterator<Item = GapSlot<'a>>,
        scratch: &mut BatchScratch,
    ) -> Vec<Result<ContactPoint, ElementError>> {
        gap_batch(self, elements, Asked::Mode(mode), slots, scratch)
    }
}

impl<K: KernelSet> GeneratedWith<K> {
    /// As [`Generated::gap_batch`], with the kernels of `K` for all elements.
    ///
    /// # Errors
    /// An entry for each element, as [`gap_into`](Self::gap_into).
    ///
    /// # Panics
    /// If there are not as many slots as elements, or a slice is shorter than its mode needs.
    pub fn gap_batch<'a>(
        &self,
        elements: &[Element<'_>],
        mode: Mode,
        slots: impl IntoIterator<Item = GapSlot<'a>>,
        scratch: &mut BatchScratch,
    ) -> Vec<Result<ContactPoint, ElementError>> {
        gap_batch(self, elements, Asked::Mode(mode), slots, scratch)
    }
}

/// Which derivatives are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Asked {
    /// Those of a mode.
    Mode(Mode),
    /// N, and this in the place of M; of elements without a slip.
    Second(SecondKind),
}

/// The kernel sets of a backend.
pub(crate) trait KernelSets {
    /// Whether an element can be evaluated, and what its kernel reads.
    fn prepare<'a>(&self, element: &Element<'a>) -> (Result<(), ElementError>, ElementInputs<'a>);

    /// Evaluates elements of as many nodes with the kernels of a weight, with a slip or without.
    fn run(
        &self,
        weight: Weight,
        has_slip: bool,
        kernel: (Basis, FrameRule, Asked),
        elements: &mut [BatchElement<'_>],
        workspace: &mut Workspace,
    );
}

impl KernelSets for Generated {
    fn prepare<'a>(&self, element: &Element<'a>) -> (Result<(), ElementError>, ElementInputs<'a>) {
        with_kernels!(element.weight, K => GeneratedWith::<K>::new().prepare(element))
    }

    fn run(
        &self,
        weight: Weight,
        has_slip: bool,
        kernel: (Basis, FrameRule, Asked),
        elements: &mut [BatchElement<'_>],
        workspace: &mut Workspace,
    ) {
        with_kernels!(weight, K => GeneratedWith::<K>::new().run(weight, has_slip, kernel, elements, workspace));
    }
}

impl<K: KernelSet> KernelSets for GeneratedWith<K> {
    fn prepare<'a>(&self, element: &Element<'a>) -> (Result<(), ElementError>, ElementInputs<'a>) {
        let sound = validate::<K>(element);
        // One that is not sound may have fewer domains than masters, of which a weight with a pole seeks the nearest one.
        let domains = if sound.is_ok() { element.domains } else { Domains::Shared };
        let inputs = inputs::<K>(&Element { domains, ..*element }, [0.0; 2]);
        (sound, inputs)
    }

    fn run(
        &self,
        _: Weight,
        has_slip: bool,
        kernel: (Basis, FrameRule, Asked),
        elements: &mut [BatchElement<'_>],
        workspace: &mut Workspace,
    ) {
        let (isa, (basis, frame, asked)) = (K::best_isa(), kernel);
        match asked {
            Asked::Mode(mode) if has_slip => K::slip_batch(isa, (basis, frame, mode), elements, workspace),
            Asked::Mode(mode) => K::gap_batch(isa, (basis, frame, mode), elements, workspace),
            Asked::Second(kind) => K::gap_factors_batch(isa, (basis, frame), kind, elements, workspace),
        }
    }
}

pub(crate) fn gap_batch<'a>(
    sets: &impl KernelSets,
    elements: &[Element<'_>],
    asked: Asked,
    slots: impl IntoIterator<Item = GapSlot<'a>>,
    scratch: &mut BatchScratch,
) -> Vec<Result<ContactPoint, ElementError>> {
    let mut results = Vec::with_capacity(elements.len());
    let mut waiting = recycled(std::mem::take(&mut scratch.waiting));
    let mut slots = slots.into_iter();
    for element in elements {
        let slot = slots.next().expect("a slot for each element");
        let (sound, inputs) = sets.prepare(element);
        results.push(sound.map(|()| ContactPoint::default()));
        waiting.push(Waiting {
            weight: element.weight,
            frame: frame_rule(element.frame.derivative, &element.domains),
            basis: element.basis,
            inputs,
            has_slip: false,
            slot,
            places: &[],
            is_sound: sound.is_ok(),
        });
    }
    assert!(slots.next().is_none(), "a slot for each element");
    evaluate(sets, asked, &mut waiting, scratch, |index, element| {
        results[index] = contact_point(&element.values)
    });
    scratch.waiting = recycled(waiting);
    results
}

/// Gap, foot and normal, if there are any.
pub(crate) fn contact_point(values: &GapValues<f64>) -> Result<ContactPoint, ElementError> {
    ElementError::check(values.status())?;
    Ok(ContactPoint { gap: values.gap, foot: values.foot, normal: values.normal })
}

/// An element before it is evaluated.
#[derive(Debug)]
pub(crate) struct Waiting<'a, 's> {
    pub weight: Weight,
    pub frame: FrameRule,
    pub basis: Basis,
    pub inputs: ElementInputs<'a>,
    /// Whether it has a slip from an anchor: its slot then has room for the derivatives of both.
    pub has_slip: bool,
    pub slot: GapSlot<'s>,
    /// As of a [`BatchElement`].
    pub places: &'a [u32],
    /// Others are left out.
    pub is_sound: bool,
}

/// Evaluates the elements, which need no further check, and hands over each with its place among them.
pub(crate) fn evaluate<'a>(
    sets: &impl KernelSets,
    asked: Asked,
    waiting: &mut [Waiting<'a, 'a>],
    scratch: &mut BatchScratch,
    mut result: impl FnMut(usize, &mut BatchElement<'a>),
) {
    let BatchScratch { workspace, order, elements: memory, .. } = scratch;
    order.clear();
    order.extend(waiting.iter().enumerate().filter(|(_, element)| element.is_sound).map(
        |(index, element)| {
            let &Waiting { weight, frame, basis, ref inputs, has_slip, .. } = element;
            (Key { weight, frame, basis, nodes: inputs.masters.len(), has_slip }, index)
        },
    ));
    order.sort_unstable();
    let mut elements = recycled(std::mem::take(memory));
    for group in order.chunk_by(|x, y| x.0.goes_beside(&y.0, asked)) {
        let Key { weight, frame, basis, has_slip, .. } = group[0].0;
        for group in group.chunks(MOST_AT_ONCE) {
            elements.clear();
            elements.extend(group.iter().map(|&(_, index)| {
                let &mut Waiting { inputs, places, ref mut slot, .. } = &mut waiting[index];
                let GapSlot { gradient, hessian } = std::mem::take(slot);
                BatchElement { inputs, values: GapValues::NONE, gradient, hessian, places }
            }));
            sets.run(weight, has_slip, (basis, frame, asked), &mut elements, workspace);
            for (element, &(_, index)) in elements.iter_mut().zip(group) {
                result(index, element);
            }
        }
    }
    *memory = recycled(elements);
}

/// Elements handed to a kernel at once: a multiple of the widest vector.
const MOST_AT_ONCE: usize = 32;
