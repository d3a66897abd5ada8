//! Runs generated kernels: one element, or many of the same number of nodes.

use std::cell::Cell;
use std::marker::PhantomData;

use super::simd::{Block, ByNumber, Spread, Vector};
use super::{
    Batch, ElementInputs, FormRows, GapValues, Inputs, Isa, Lane, MATERIAL_VALUES, Mode, NODE_VALUES, Second,
    SecondKind, Shape, Single, WithLanes, packed_row,
};

/// A generated kernel for the gap.
pub trait GapKernel {
    /// How many derivatives it computes.
    const MODE: Mode;
    /// Whether it reads where nodes are in the first configuration.
    const MATERIAL: bool;
    /// Whether it has a slip from an anchor, whose derivatives come after those of the gap.
    const ANCHOR: bool;
    /// Values it keeps of a node between its loops.
    const KEPT: usize;
    /// What it is compiled for: less saves time and room.
    const WIDTHS: Widths;
    /// Rows of the form of the gap's Hessian, as of [`FormRows`](super::FormRows).
    const ROWS: usize = 0;

    /// Evaluates the elements of a [`Shape`].
    ///
    /// `scratch`: [`KEPT`](Self::KEPT) values for each vector of nodes and one more, two with an anchor, of any content. `gradients` and
    /// `second`: N, 3(n+1) entries, and the packed lower triangle of M or its factors, with what comes after them; empty if it does not
    /// compute them.
    fn evaluate<E: Lane, T: Lane, S: Shape<Element = E, Node = T>>(
        inputs: &Inputs<'_, E, T>,
        scratch: &mut [T],
        gradients: &mut [S::Output],
        second: Second<'_, S::Output>,
    ) -> GapValues<E>;
}

/// Vectors that a kernel is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Widths {
    /// Batches in vectors of every width, an element's nodes in vectors of four numbers.
    Every,
    /// Batches in vectors of four numbers only.
    Four,
    /// Batches in vectors of every width; one element number by number.
    EveryBatch,
    /// Number by number.
    One,
}

/// Room for the vectors of batches, reused from one to the next.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    blocks: Vec<Block>,
    spread: Spread,
    /// Derivatives of one element, before they go to their places.
    numbers: Vec<f64>,
}

/// One element of a batch, and where its results go. What the kernel does not compute may be empty and is not touched.
#[derive(Debug)]
pub struct BatchElement<'a> {
    /// What is read.
    pub inputs: ElementInputs<'a>,
    /// Values.
    pub values: GapValues<f64>,
    /// N, 3(n+1) entries ordered slave, master 1, …, master n, and what a kernel with an anchor has besides.
    pub gradient: &'a mut [f64],
    /// M, packed lower triangle of 3(n+1) rows, and the same; or the factors of M, if these are asked for.
    pub hessian: &'a mut [f64],
    /// Where derivatives by further nodes, which are zero, are wanted among those of N and M: the places of the masters among all nodes,
    /// ascending. N has 3(m+1) entries then and M as many rows, m as its slice says. Empty: N and M of the masters. To stay empty where
    /// factors or a slip are asked for.
    pub places: &'a [u32],
}

/// Values that a kernel reads of a node in the first configuration.
const fn material_values<K: GapKernel>() -> usize {
    if K::MATERIAL { MATERIAL_VALUES } else { 0 }
}

/// Vectors of nodes that a kernel has scratch for.
const fn scratch_vectors<K: GapKernel>(vectors: usize) -> usize {
    if K::ANCHOR { vectors + 2 } else { vectors + 1 }
}

/// Entries of the gradients and of the packed Hessians that a kernel computes, or of what it leaves in their place, see
/// [`KernelSet::gap`](super::KernelSet::gap) and [`KernelSet::slip`](super::KernelSet::slip).
const fn sizes<K: GapKernel>(nodes: usize, kind: SecondKind) -> (usize, usize) {
    let freedoms = 3 * (nodes + 1);
    let with_anchor = freedoms + 3;
    let (gradients, hessians) = if K::ANCHOR {
        (freedoms + with_anchor + nodes, packed_row(freedoms) + packed_row(with_anchor))
    } else {
        (freedoms, packed_row(freedoms))
    };
    match (K::MODE, kind) {
        (Mode::Value, _) => (0, 0),
        (Mode::Gradient, _) => (gradients, 0),
        (Mode::Hessian, SecondKind::Hessians) => (gradients, hessians),
        (Mode::Hessian, SecondKind::Factors) => (gradients, form::<K>(nodes).factors()),
        (Mode::Hessian, SecondKind::SlaveRows) => (gradients, form::<K>(nodes).slave_rows()),
        (Mode::Hessian, SecondKind::FactorsAndFoot) => {
            (gradients, form::<K>(nodes).factors() + form::<K>(nodes).foot_coefficients())
        }
    }
}

/// Numbers of second derivatives that an element gets.
const fn second_numbers<K: GapKernel>(nodes: usize, kind: SecondKind) -> usize {
    if is_foot::<K>(kind) { form::<K>(nodes).foot_numbers() } else { sizes::<K>(nodes, kind).1 }
}

/// Whether what the kernel leaves is combined to derivatives at the foot.
const fn is_foot<K: GapKernel>(kind: SecondKind) -> bool {
    matches!((K::MODE, kind), (Mode::Hessian, SecondKind::FactorsAndFoot))
}

/// Whether derivatives are those of N and M, which may have places.
fn may_have_places<K: GapKernel>(kind: SecondKind) -> bool {
    !K::ANCHOR && (K::MODE < Mode::Hessian || kind == SecondKind::Hessians)
}

/// Whether elements side by side may differ in their number of nodes.
fn may_differ<K: GapKernel>(kind: SecondKind) -> bool {
    K::MATERIAL && may_have_places::<K>(kind)
}

/// The form of the gap's Hessian.
const fn form<K: GapKernel>(nodes: usize) -> FormRows {
    assert!(!K::ANCHOR, "no factors of a slip's Hessian");
    FormRows { rows: K::ROWS, count: nodes }
}

/// Runs a kernel of any output for one element, number by number. `kept`: values it keeps of a node between its loops.
pub fn scalar<V>(
    inputs: &ElementInputs<'_>,
    weight_number: usize,
    kept: usize,
    kernel: impl FnOnce(&Inputs<'_, f64>, &mut [f64]) -> V,
) -> V {
    let count = inputs.masters.len();
    let needed = Block::count::<f64>(NODE_VALUES * count + kept * (count + 1));
    let mut blocks = memory(needed);
    let (masters, scratch) = Block::vectors::<f64>(&mut blocks).split_at_mut(NODE_VALUES * count);
    let (masters, _) = masters.as_chunks_mut::<NODE_VALUES>();
    for (k, master) in masters.iter_mut().enumerate() {
        *master = inputs.node(k);
    }
    let values = kernel(&Inputs::gather(|_| inputs, weight_number, masters, &[]), scratch);
    BLOCKS.set(blocks);
    values
}

/// Evaluates one element, its nodes side by side. Allocates only for the first element of a thread, and for a larger one than
/// before.
///
/// # Panics
/// If a slice is shorter than the kernel needs.
pub fn single<K: GapKernel>(
    isa: Isa,
    weight_number: usize,
    inputs: &ElementInputs<'_>,
    gradient: &mut [f64],
    second: Second<'_, f64>,
) -> GapValues<f64> {
    let kind = second.kind();
    let count = inputs.masters.len();
    let (gradients, _) = sizes::<K>(count, kind);
    let code = SingleElement::<K> {
        inputs,
        weight_number,
        gradient: &mut gradient[..gradients],
        kind,
        second: &mut second.into_target()[..second_numbers::<K>(count, kind)],
        kernel: PhantomData,
    };
    // Constants, not patterns: what a constant rules out is not compiled.
    if const { matches!(K::WIDTHS, Widths::EveryBatch | Widths::One) } {
        K::run_by_number(code)
    } else {
        isa.run_four_beside::<K, _>(code).unwrap_or_else(|code| K::run_by_number(code))
    }
}

struct SingleElement<'a, K> {
    inputs: &'a ElementInputs<'a>,
    weight_number: usize,
    gradient: &'a mut [f64],
    kind: SecondKind,
    second: &'a mut [f64],
    kernel: PhantomData<K>,
}

impl<K: GapKernel> WithLanes for SingleElement<'_, K> {
    type Output = GapValues<f64>;

    #[inline(always)]
    fn run<T: Vector>(self) -> GapValues<f64> {
        let Self { inputs, weight_number, gradient, kind, second, .. } = self;
        let count = inputs.masters.len();
        let vectors = count.div_ceil(T::WIDTH);
        let read = material_values::<K>();
        let left = if is_foot::<K>(kind) { sizes::<K>(count, kind).1 } else { 0 };
        let kept = K::KEPT * scratch_vectors::<K>(vectors);
        let needed = (NODE_VALUES + read) * vectors + kept + left.div_ceil(T::WIDTH);
        let mut blocks = memory(Block::count::<T>(needed));
        let (masters, scratch) = Block::vectors::<T>(&mut blocks).split_at_mut(NODE_VALUES * vectors);
        let (masters, _) = masters.as_chunks_mut::<NODE_VALUES>();
        let (material, scratch) = scratch.split_at_mut(read * vectors);
        let (scratch, numbers) = scratch.split_at_mut(kept);
        let (material, _) = material.as_chunks_mut::<MATERIAL_VALUES>();
        for (k, master) in masters.iter_mut().enumerate() {
            // The last node also fills the rest of the last vector.
            let node = |lane: usize| inputs.node((k * T::WIDTH + lane).min(count - 1));
            for (value, vector) in master.iter_mut().enumerate() {
                *vector = T::from_fn(|lane| node(lane)[value]);
            }
        }
        for (k, node) in material.iter_mut().enumerate() {
            let of = |lane: usize| inputs.material((k * T::WIDTH + lane).min(count - 1));
            for (value, vector) in node.iter_mut().enumerate() {
                *vector = T::from_fn(|lane| of(lane)[value]);
            }
        }
        let inputs = Inputs::gather(|_| inputs, weight_number, masters, material);
        let numbers = &mut T::numbers(numbers)[..left];
        let target = if is_foot::<K>(kind) { &mut *numbers } else { &mut *second };
        let target = Second::new(kind, target);
        let values = K::evaluate::<T::Scalar, T, Single<T>>(&inputs, scratch, gradient, target).lane(0);
        if is_foot::<K>(kind) {
            form::<K>(count).foot_derivatives_of_one(numbers, second);
        }
        BLOCKS.set(blocks);
        values
    }
}

thread_local! {
    /// Memory of the last element of a thread: new memory would have to be filled before it can be used.
    static BLOCKS: Cell<Vec<Block>> = const { Cell::new(Vec::new()) };
}

/// At least so many blocks, to be given back to [`BLOCKS`].
#[inline]
fn memory(count: usize) -> Vec<Block> {
    let mut blocks = BLOCKS.take();
    at_least(&mut blocks, count);
    blocks
}

/// So many blocks of a vector that grows where it has fewer.
#[inline]
fn at_least(blocks: &mut Vec<Block>, count: usize) -> &mut [Block] {
    if blocks.len() < count {
        blocks.resize(count, Block::ZERO);
    }
    &mut blocks[..count]
}

/// Evaluates elements side by side. What one of them gets does not depend on the others.
///
/// Those with domains in the first configuration may differ in their number of nodes, unless a slip or factors are asked for: others beside
/// them get nodes that carry no weight. So elements that follow one another should have nearly as many.
///
/// # Panics
/// If other numbers of nodes differ, or a slice is shorter than the kernel needs.
pub fn batch<K: GapKernel>(
    isa: Isa,
    weight_number: usize,
    kind: SecondKind,
    elements: &mut [BatchElement<'_>],
    workspace: &mut Workspace,
) {
    let Some(first) = elements.first() else { return };
    let count = first.inputs.masters.len();
    assert!(
        may_differ::<K>(kind) || elements.iter().all(|element| element.inputs.masters.len() == count),
        "elements of as many nodes"
    );
    let code = Elements::<K> { elements, weight_number, kind, workspace, kernel: PhantomData };
    let left = if const { matches!(K::WIDTHS, Widths::Every | Widths::EveryBatch) } {
        isa.run_vectors_beside::<K, _>(code)
    } else if const { matches!(K::WIDTHS, Widths::One) } {
        Err(code)
    } else {
        isa.run_four_beside::<K, _>(code)
    };
    if let Err(Elements { elements, workspace, .. }) = left {
        one_by_one::<K>(isa, weight_number, kind, elements, workspace);
    }
}

/// As [`batch`] where there are no vectors for it.
fn one_by_one<K: GapKernel>(
    isa: Isa,
    weight_number: usize,
    kind: SecondKind,
    elements: &mut [BatchElement<'_>],
    workspace: &mut Workspace,
) {
    let Workspace { spread, numbers, .. } = workspace;
    for element in elements {
        let BatchElement { inputs, gradient, hessian, places, .. } = element;
        if places.is_empty() {
            let second = Second::new(kind, hessian);
            element.values = single::<K>(isa, weight_number, inputs, gradient, second);
            continue;
        }
        let (gradients, hessians) = sizes::<K>(inputs.masters.len(), kind);
        numbers.resize(gradients + hessians, 0.0);
        let (gradient, hessian) = numbers.split_at_mut(gradients);
        let second = Second::new(kind, hessian);
        element.values = single::<K>(isa, weight_number, inputs, gradient, second);
        assert!(!K::ANCHOR && kind == SecondKind::Hessians, "places are those of N and M");
        let elements = std::slice::from_mut(element);
        let count = elements[0].inputs.masters.len();
        spread.set(count, elements.iter().map(|element| (count, element.places)));
        if gradients > 0 {
            spread.store_gradients(gradient, elements, |element| element.gradient);
        }
        if hessians > 0 {
            spread.store_packed(hessian, elements[0].hessian);
        }
    }
}

/// Writes the values of an element's nodes into its lane. Number by number: vectors put together from numbers that have just been stored
/// wait for them.
#[inline(always)]
fn fill_lane<T: Vector, const VALUES: usize>(
    nodes: &mut [[T; VALUES]],
    lane: usize,
    of_node: impl Fn(usize) -> [f64; VALUES],
) {
    for k in 0..nodes.len() {
        let numbers = T::numbers(&mut nodes[k]);
        let values = of_node(k);
        for value in 0..VALUES {
            numbers[T::WIDTH * value + lane] = values[value];
        }
    }
}

struct Elements<'a, 'e, K> {
    elements: &'a mut [BatchElement<'e>],
    weight_number: usize,
    kind: SecondKind,
    workspace: &'a mut Workspace,
    kernel: PhantomData<K>,
}

impl<K: GapKernel> WithLanes for Elements<'_, '_, K> {
    type Output = ();

    #[inline(always)]
    fn run<T: Vector>(self) {
        let most = most_nodes(self.elements);
        let has_hessians = K::MODE == Mode::Hessian && self.kind == SecondKind::Hessians;
        let (gradients, factors) = sizes::<K>(most, self.kind);
        let factors = if has_hessians { 0 } else { factors };
        let is_foot = is_foot::<K>(self.kind);
        let at_foot = if is_foot { second_numbers::<K>(most, self.kind) } else { 0 };
        let read = material_values::<K>();
        let kept = K::KEPT * scratch_vectors::<K>(most);
        let needed = (NODE_VALUES + read) * most + kept + gradients + factors + at_foot;
        let Workspace { blocks, spread, .. } = self.workspace;
        let blocks = at_least(blocks, Block::count::<T>(needed));
        let vectors = Block::vectors::<T>(blocks);
        let (masters, vectors) = vectors.split_at_mut(NODE_VALUES * most);
        let (masters, _) = masters.as_chunks_mut::<NODE_VALUES>();
        let (material, vectors) = vectors.split_at_mut(read * most);
        let (material, _) = material.as_chunks_mut::<MATERIAL_VALUES>();
        let (scratch, vectors) = vectors.split_at_mut(kept);
        let (gradient, vectors) = vectors.split_at_mut(gradients);
        let (factors, vectors) = vectors.split_at_mut(factors);
        let at_foot = &mut vectors[..at_foot];
        for elements in self.elements.chunks_mut(T::WIDTH) {
            let count = most_nodes(elements);
            let (gradients, _) = sizes::<K>(count, self.kind);
            let masters = &mut masters[..count];
            let material = &mut material[..if K::MATERIAL { count } else { 0 }];
            // The last element also fills the lanes beyond.
            let last = elements.len() - 1;
            for lane in 0..T::WIDTH {
                let inputs = &elements[lane.min(last)].inputs;
                let own = inputs.masters.len();
                fill_lane::<T, _>(masters, lane, |k| inputs.node(k.min(own - 1)));
                fill_lane::<T, _>(material, lane, |k| if k < own { inputs.material(k) } else { NO_WEIGHT });
            }
            let of = |lane: usize| &elements[lane.min(last)].inputs;
            let inputs = Inputs { count, ..Inputs::gather(of, self.weight_number, masters, material) };
            let has_all = |element: &BatchElement<'_>| {
                element.places.is_empty() && element.inputs.masters.len() == count
            };
            let have_all = elements.iter().all(has_all);
            assert!(have_all || may_have_places::<K>(self.kind), "places are those of N and M");
            if has_hessians || !have_all {
                let anchor = usize::from(K::ANCHOR);
                let own = |element: &BatchElement<'_>| element.inputs.masters.len() + anchor;
                let all = elements.iter().map(|element| (own(element), element.places));
                spread.set(count + anchor, all);
            }
            let second = if has_hessians {
                Second::placed(spread.hessians(elements, |element| element.hessian))
            } else {
                Second::new(self.kind, &mut factors[..])
            };
            let values = K::evaluate::<T, T, Batch<T>>(&inputs, scratch, gradient, second);
            for (lane, element) in elements.iter_mut().enumerate() {
                element.values = values.lane(lane);
            }
            let gradient = &gradient[..gradients];
            if have_all {
                T::store_transposed(gradient, elements, |element| element.gradient);
            } else if gradients > 0 {
                spread.store_gradients(gradient, elements, |element| element.gradient);
            }
            if is_foot {
                form::<K>(count).foot_derivatives(factors, at_foot);
                T::store_transposed(at_foot, elements, |element| element.hessian);
            } else if !has_hessians {
                T::store_transposed(factors, elements, |element| element.hessian);
            }
        }
    }
}

/// The largest number of nodes.
fn most_nodes(elements: &[BatchElement<'_>]) -> usize {
    elements.iter().fold(0, |most, element| most.max(element.inputs.masters.len()))
}

/// A node out of its own domain, as a kernel reads it.
const NO_WEIGHT: [f64; MATERIAL_VALUES] = [2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0];
