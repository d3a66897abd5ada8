//! The results of all slaves.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::{InterfaceError, Outcome};
use crate::assembly::{AssemblyError, ContactView, ElementView, Elements, SlipView};
use crate::{ContactPoint, Mode};

/// The contact of every slave node, in the order of the slaves.
///
/// Numbers lie in flat buffers that an interface reuses from one evaluation to the next.
#[derive(Clone, Debug)]
pub struct Contacts {
    pub(super) layout: Arc<Layout>,
    slots: Results,
    /// Whether there can be slips.
    friction: Result<(), AssemblyError>,
}

/// The contact of one slave node.
#[derive(Clone, Copy, Debug)]
pub struct ContactRef<'a> {
    /// Index of the slave node in all positions.
    pub slave: usize,
    /// Indices of the master nodes 1 … n: of the pairing, also if there is no contact; empty if there is no
    /// pairing.
    pub nodes: &'a [u32],
    /// Whether there is a result; without one the fields below are zero or empty.
    pub outcome: Outcome,
    /// Gap, foot and normal.
    pub point: ContactPoint,
    /// Tributary area of the slave node, length²; 1 if the interface has none.
    pub area: f64,
    /// N, 3(n+1) entries ordered slave, master 1, …, master n; empty in value mode, and where
    /// [`evaluate_where`](super::ContactInterface::evaluate_where) was not to derive.
    pub gradient: &'a [f64],
    /// M, packed lower triangle row by row: entry (i, j ≤ i) at i(i+1)/2 + j; empty below Hessian mode, and where the gradient
    /// is.
    pub hessian: &'a [f64],
    /// The slip, if the interface has [anchors](super::ContactInterface::set_anchors).
    pub slip: Option<SlipView<'a>>,
}

impl<'a> ContactRef<'a> {
    /// What assembly takes of it, if there is contact.
    pub(crate) fn view(&self) -> Option<ContactView<'a>> {
        let Self { point, area, gradient, hessian, slip, .. } = *self;
        let view = ContactView { gap: point.gap, area, gradient, hessian, slip };
        self.outcome.is_contact().then_some(view)
    }
}

impl Contacts {
    pub(super) fn new(layout: Arc<Layout>, friction: Result<(), AssemblyError>) -> Self {
        Self { layout, slots: Results::default(), friction }
    }

    /// Number of slave nodes that have been evaluated.
    pub fn len(&self) -> usize {
        self.slots.outcomes.len()
    }

    /// Whether there are no slave nodes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many derivatives there are, where there are any.
    pub const fn mode(&self) -> Mode {
        self.slots.mode
    }

    /// The `k`-th slave node.
    ///
    /// # Panics
    /// If there is none.
    pub fn get(&self, k: usize) -> ContactRef<'_> {
        self.slots.get(&self.layout, k)
    }

    /// All slave nodes in their order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = ContactRef<'_>> {
        (0..self.len()).map(|k| self.get(k))
    }

    /// Room for all slaves of `layout`, to be filled.
    pub(super) fn start(
        &mut self,
        layout: &Arc<Layout>,
        mode: Mode,
        is_tracked: bool,
    ) -> Result<Slots<'_>, InterfaceError> {
        let slots = self.slots.start(layout, 0..layout.len(), mode, is_tracked)?;
        self.layout = Arc::clone(layout);
        Ok(slots)
    }
}

/// Residual and tangent of the interface: see [`assembly`](crate::assembly). A pattern made of contacts holds until the next
/// refresh of the pairing.
impl Elements for Contacts {
    fn len(&self) -> usize {
        self.len()
    }

    fn element(&self, k: usize) -> ElementView<'_> {
        let contact = self.get(k);
        ElementView { slave: contact.slave, masters: contact.nodes, contact: contact.view() }
    }

    fn check_friction(&self) -> Result<(), AssemblyError> {
        self.friction
    }

    fn stamp(&self) -> Option<u64> {
        Some(self.layout.stamp)
    }
}

/// The slip of one slave at an evaluation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tracked {
    pub is_anchored: bool,
    /// q
    pub half_square: f64,
    pub since_stuck: f64,
    pub opening: f64,
}

/// Who is paired with whom, and where the numbers of each slave lie.
#[derive(Clone, Debug)]
pub struct Layout {
    slaves: Vec<usize>,
    /// One per slave, or none.
    areas: Vec<f64>,
    masters: Vec<u32>,
    /// Where the masters of each slave begin.
    offsets: Vec<usize>,
    /// Where its Hessian begins.
    hessians: Vec<usize>,
    /// No other layout of the process has this number.
    stamp: u64,
}

/// How many layouts there have been.
static LAYOUTS: AtomicU64 = AtomicU64::new(0);

impl Layout {
    /// `lengths` are the numbers of masters of the slaves, one after another in `masters`.
    pub fn new(
        slaves: Vec<usize>,
        areas: Vec<f64>,
        lengths: impl Iterator<Item = usize>,
        masters: Vec<u32>,
    ) -> Self {
        let (mut offset, mut hessian) = (0, 0);
        let mut offsets = Vec::with_capacity(slaves.len() + 1);
        let mut hessians = Vec::with_capacity(slaves.len() + 1);
        offsets.push(0);
        hessians.push(0);
        for length in lengths {
            offset += length;
            hessian += packed_size(length);
            offsets.push(offset);
            hessians.push(hessian);
        }
        let stamp = LAYOUTS.fetch_add(1, Ordering::Relaxed);
        Self { slaves, areas, masters, offsets, hessians, stamp }
    }

    /// Whether it has the same lists of nodes.
    pub fn is_same(&self, other: &Self) -> bool {
        (&self.slaves, &self.offsets, &self.masters) == (&other.slaves, &other.offsets, &other.masters)
            && self.areas == other.areas
    }

    pub fn len(&self) -> usize {
        self.slaves.len()
    }

    pub fn slaves(&self) -> &[usize] {
        &self.slaves
    }

    pub fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// Tributary area, length²; 1 if there are none.
    pub fn area(&self, k: usize) -> f64 {
        self.areas.get(k).copied().unwrap_or(1.0)
    }

    pub fn slave(&self, k: usize) -> usize {
        self.slaves[k]
    }

    pub fn masters(&self, k: usize) -> &[u32] {
        &self.masters[self.masters_range(k)]
    }

    /// Where the masters of the `k`-th slave lie among those of all.
    pub fn masters_range(&self, k: usize) -> Range<usize> {
        self.offsets[k]..self.offsets[k + 1]
    }

    /// Number of masters of all slaves before the `k`-th.
    pub fn offset(&self, k: usize) -> usize {
        self.offsets[k]
    }

    /// Numbers in the gradients and in the Hessians of these slaves, as far as a mode asks for them.
    fn numbers(&self, Range { start, end }: Range<usize>, mode: Mode) -> [usize; 2] {
        let gradients = self.gradient(end) - self.gradient(start);
        let hessians = self.hessians[end] - self.hessians[start];
        [if mode >= Mode::Gradient { gradients } else { 0 }, if mode >= Mode::Hessian { hessians } else { 0 }]
    }

    /// Where the gradient of the `k`-th slave begins: 3(n+1) numbers for each slave before.
    pub fn gradient(&self, k: usize) -> usize {
        3 * (self.offsets[k] + k)
    }
}

/// Entries of the packed Hessian of an element with so many masters; none without masters.
const fn packed_size(masters: usize) -> usize {
    let freedoms = 3 * (masters + 1);
    if masters == 0 { 0 } else { freedoms * (freedoms + 1) / 2 }
}

/// The numbers of some consecutive slaves.
#[derive(Clone, Debug)]
pub struct Results {
    mode: Mode,
    first: usize,
    outcomes: Vec<Outcome>,
    points: Vec<ContactPoint>,
    /// Whether the derivatives that the mode asks for were evaluated.
    derived: Vec<bool>,
    of_gap: Numbers,
    /// One per slave, or none.
    slips: Vec<Tracked>,
    of_slip: Numbers,
}

/// Gradients and packed Hessians of a quantity, slave after slave.
#[derive(Clone, Debug, Default)]
struct Numbers {
    gradients: Vec<f64>,
    hessians: Vec<f64>,
}

impl Numbers {
    fn reserve(&mut self, [gradients, hessians]: [usize; 2]) -> Result<(), InterfaceError> {
        reserve(&mut self.gradients, gradients)?;
        reserve(&mut self.hessians, hessians)
    }

    fn resize(&mut self, [gradients, hessians]: [usize; 2]) -> NumberSlots<'_> {
        self.gradients.resize(gradients, 0.0);
        self.hessians.resize(hessians, 0.0);
        NumberSlots { gradients: &mut self.gradients, hessians: &mut self.hessians }
    }
}

impl Default for Results {
    fn default() -> Self {
        Self {
            mode: Mode::Value,
            first: 0,
            outcomes: Vec::new(),
            points: Vec::new(),
            derived: Vec::new(),
            of_gap: Numbers::default(),
            slips: Vec::new(),
            of_slip: Numbers::default(),
        }
    }
}

impl Results {
    /// Room for these slaves. Memory of earlier results is reused; if there is not enough, these stay.
    pub fn start(
        &mut self,
        layout: &Layout,
        range: Range<usize>,
        mode: Mode,
        is_tracked: bool,
    ) -> Result<Slots<'_>, InterfaceError> {
        let Range { start, end } = range;
        let count = end - start;
        let slips = if is_tracked { count } else { 0 };
        let numbers = layout.numbers(start..end, mode);
        let of_slip = if is_tracked { numbers } else { [0; 2] };
        reserve(&mut self.outcomes, count)?;
        reserve(&mut self.points, count)?;
        reserve(&mut self.derived, count)?;
        reserve(&mut self.slips, slips)?;
        self.of_gap.reserve(numbers)?;
        self.of_slip.reserve(of_slip)?;
        (self.mode, self.first) = (mode, start);
        self.outcomes.resize(count, Outcome::None(super::NoContact::NotPaired));
        self.points.resize(count, ContactPoint::default());
        self.derived.resize(count, false);
        self.slips.resize(slips, Tracked::default());
        Ok(Slots {
            mode,
            range: start..end,
            outcomes: &mut self.outcomes,
            points: &mut self.points,
            derived: &mut self.derived,
            of_gap: self.of_gap.resize(numbers),
            slips: &mut self.slips,
            of_slip: self.of_slip.resize(of_slip),
        })
    }

    pub fn get<'a>(&'a self, layout: &'a Layout, k: usize) -> ContactRef<'a> {
        let outcome = self.outcomes[k - self.first];
        let of = |numbers: &'a [f64], wanted: bool, position: &dyn Fn(usize) -> usize| {
            let wanted = wanted && outcome.is_contact() && self.derived[k - self.first];
            let base = position(self.first);
            if wanted { &numbers[position(k) - base..position(k + 1) - base] } else { &[] }
        };
        let derivatives = |numbers: &'a Numbers, are_there: bool| {
            let gradient =
                of(&numbers.gradients, are_there && self.mode >= Mode::Gradient, &|k| layout.gradient(k));
            let hessian =
                of(&numbers.hessians, are_there && self.mode >= Mode::Hessian, &|k| layout.hessians[k]);
            (gradient, hessian)
        };
        let (gradient, hessian) = derivatives(&self.of_gap, true);
        let slip = self.slips.get(k - self.first).map(|slip| {
            let (gradient, hessian) = derivatives(&self.of_slip, slip.is_anchored);
            let Tracked { half_square, since_stuck, opening, .. } = *slip;
            SlipView { half_square, since_stuck, opening, gradient, hessian }
        });
        ContactRef {
            slave: layout.slaves[k],
            nodes: layout.masters(k),
            outcome,
            point: self.points[k - self.first],
            area: layout.area(k),
            gradient,
            hessian,
            slip,
        }
    }
}

/// Room for so many numbers.
pub(crate) fn reserve<T>(numbers: &mut Vec<T>, length: usize) -> Result<(), InterfaceError> {
    let more = length.saturating_sub(numbers.len());
    numbers.try_reserve_exact(more).map_err(|_| InterfaceError::OutOfMemory { numbers: length })
}

/// New entries are `value`, old ones keep what they hold.
pub(super) fn resize<T: Clone>(numbers: &mut Vec<T>, length: usize, value: T) -> Result<(), InterfaceError> {
    reserve(numbers, length)?;
    numbers.resize(length, value);
    Ok(())
}

/// Room for the results of some consecutive slaves, which can be split for parallel work.
#[derive(Debug)]
pub struct Slots<'a> {
    mode: Mode,
    range: Range<usize>,
    outcomes: &'a mut [Outcome],
    points: &'a mut [ContactPoint],
    derived: &'a mut [bool],
    of_gap: NumberSlots<'a>,
    slips: &'a mut [Tracked],
    of_slip: NumberSlots<'a>,
}

/// Room for the derivatives of a quantity.
#[derive(Debug)]
struct NumberSlots<'a> {
    gradients: &'a mut [f64],
    hessians: &'a mut [f64],
}

impl<'a> NumberSlots<'a> {
    fn front(&mut self, [gradients, hessians]: [usize; 2]) -> Self {
        Self {
            gradients: front(&mut self.gradients, gradients),
            hessians: front(&mut self.hessians, hessians),
        }
    }
}

/// Room for the results of one slave.
#[derive(Debug)]
pub struct Slot<'a> {
    pub index: usize,
    pub outcome: &'a mut Outcome,
    pub point: &'a mut ContactPoint,
    /// Whether gradient and Hessian are filled as the mode asks.
    pub derived: &'a mut bool,
    pub gradient: &'a mut [f64],
    pub hessian: &'a mut [f64],
    /// If slips are tracked.
    pub slip: Option<SlipSlot<'a>>,
}

/// Room for the slip of one slave.
#[derive(Debug)]
pub struct SlipSlot<'a> {
    pub tracked: &'a mut Tracked,
    pub gradient: &'a mut [f64],
    pub hessian: &'a mut [f64],
}

impl<'a> Slots<'a> {
    pub fn len(&self) -> usize {
        self.range.len()
    }

    /// The first `count` slaves and the others.
    pub fn split(mut self, layout: &Layout, count: usize) -> (Self, Self) {
        let Range { start, end } = self.range;
        let middle = start + count;
        let numbers = layout.numbers(start..middle, self.mode);
        let of_slip = if self.slips.is_empty() { [0; 2] } else { numbers };
        let tracked = count.min(self.slips.len());
        let first = Self {
            mode: self.mode,
            range: start..middle,
            outcomes: front(&mut self.outcomes, count),
            points: front(&mut self.points, count),
            derived: front(&mut self.derived, count),
            of_gap: self.of_gap.front(numbers),
            slips: front(&mut self.slips, tracked),
            of_slip: self.of_slip.front(of_slip),
        };
        (first, Self { range: middle..end, ..self })
    }

    /// One slave after the other.
    pub fn for_each(self, layout: &Layout, mut fill: impl FnMut(Slot<'a>)) {
        let mut rest = self;
        while rest.len() > 0 {
            let (one, others) = rest.split(layout, 1);
            let Slots { of_gap, slips, of_slip, .. } = one;
            let slip = slips.first_mut().map(|tracked| {
                let NumberSlots { gradients: gradient, hessians: hessian } = of_slip;
                SlipSlot { tracked, gradient, hessian }
            });
            if let ([outcome], [point], [derived]) = (one.outcomes, one.points, one.derived) {
                let NumberSlots { gradients: gradient, hessians: hessian } = of_gap;
                fill(Slot { index: one.range.start, outcome, point, derived, gradient, hessian, slip });
            }
            rest = others;
        }
    }
}

/// Takes the first `count` out.
pub(super) fn front<'a, T>(slots: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    slots.split_off_mut(..count).unwrap_or_default()
}
