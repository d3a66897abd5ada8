//! What is assembled: contact elements as a list.

use super::AssemblyError;
use crate::Gap;

/// A list of contact elements, one per slave node or any other number.
///
/// Nodes of slave and master have one common numbering, that of the [`DofMap`](super::DofMap).
pub trait Elements: Sync {
    /// Number of elements.
    fn len(&self) -> usize;

    /// Whether there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The element `k < len()`. It has to be the same each time it is asked for.
    fn element(&self, k: usize) -> ElementView<'_>;

    /// Whether a law may have friction, before any element is looked at.
    ///
    /// # Errors
    /// [`AssemblyError::NoAnchors`] or [`AssemblyError::NoFrictionKernels`] for elements that can have no slip.
    fn check_friction(&self) -> Result<(), AssemblyError> {
        Ok(())
    }

    /// A number that only lists with the same nodes in the same order share, if that is known: a map of their entries then need not
    /// compare them.
    fn stamp(&self) -> Option<u64> {
        None
    }
}

/// One element: its nodes, and its contact quantities if it has any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementView<'a> {
    /// Slave node.
    pub slave: usize,
    /// Master nodes 1 … n; none if the slave is not paired. A node may occur more than once.
    pub masters: &'a [u32],
    /// What the evaluation of the element gave; `None` if there is no contact.
    pub contact: Option<ContactView<'a>>,
}

/// The contact quantities of one element. Derivatives are over the 3(n+1) coordinates ordered slave, master 1, …,
/// master n, x before y before z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactView<'a> {
    /// Signed gap g, length: positive apart, negative penetrating.
    pub gap: f64,
    /// Tributary area of the slave node; 1 if the penalty is one per node.
    pub area: f64,
    /// N = ∂g/∂x, 3(n+1) entries, dimensionless.
    pub gradient: &'a [f64],
    /// M = ∂²g/∂x∂x, packed lower triangle row by row, 1/length. Only looked at for
    /// [`Tangent::Exact`](super::Tangent).
    pub hessian: &'a [f64],
    /// The slip, if it is tracked. Only looked at for a law with friction.
    pub slip: Option<SlipView<'a>>,
}

/// The slip of one element, with derivatives over the same coordinates as those of the gap: derivatives by an anchor have gone to the
/// nodes that carry it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlipView<'a> {
    /// q, half the square of the slip, length²; 0 without a gradient.
    pub half_square: f64,
    /// The slip from where the slave stuck, length: √(2q) without [augmentation](crate::Coulomb::with_augmentation), whose multipliers are
    /// no slip. For results only.
    pub since_stuck: f64,
    /// How far an open contact was from carrying force when the last step was accepted, length: its gap, less the
    /// [onset](super::NormalLaw::onset) of a law of one's own; else 0.
    pub opening: f64,
    /// ∇q, 3(n+1) entries, length; empty of a slave without an anchor, which has no friction yet, and where nothing was derived.
    pub gradient: &'a [f64],
    /// ∇²q, packed lower triangle row by row, dimensionless; empty of a slave without an anchor.
    pub hessian: &'a [f64],
}

impl<'a> ElementView<'a> {
    /// The element with these nodes and what a [`Backend`](crate::Backend) returned for it; area 1.
    pub fn new(slave: usize, masters: &'a [u32], gap: &'a Gap) -> Self {
        let (gradient, hessian) = (&gap.gradient, gap.hessian.packed());
        let contact = ContactView { gap: gap.gap, area: 1.0, gradient, hessian, slip: None };
        Self { slave, masters, contact: Some(contact) }
    }

    /// The nodes of a paired element, slave first; none if the slave is not paired.
    pub(super) fn nodes(&self) -> impl Iterator<Item = usize> + use<'a> {
        let slave = (!self.masters.is_empty()).then_some(self.slave);
        slave.into_iter().chain(self.masters.iter().map(|&node| node as usize))
    }

    /// Number of nodes, n + 1 or none.
    pub(super) fn node_count(&self) -> usize {
        if self.masters.is_empty() { 0 } else { self.masters.len() + 1 }
    }
}

impl Elements for [ElementView<'_>] {
    fn len(&self) -> usize {
        self.len()
    }

    fn element(&self, k: usize) -> ElementView<'_> {
        self[k]
    }
}
