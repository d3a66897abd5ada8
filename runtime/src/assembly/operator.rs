//! The tangent as an operator: K v without K.
//!
//! What is held of a contact is N and the factors of M: 45 numbers for each of its points with a frame that is held, 63 with one that
//! moves, 93 with nodal domains, the default. M itself is never there, nor a pattern. A product reads the numbers once. Where positions or
//! forces change, another operator is made.
//!
//! The slip of friction over nodes has no factors. With it the symmetric rest of the element's matrix is held as a packed triangle, and a
//! rank one of what is not symmetric: more memory, but no pattern either, and no rows that a rank would have to send.

mod part;

use std::fmt;

use part::{Contact, Element, NONE, Numbering, Part, Side};
use rayon::prelude::*;

use super::pattern::Lists;
use super::{AssemblyError, ContactLaw, DofMap, Tangent, add_entry, zeros};
use crate::Mode;
use crate::interface::{ContactInterface, InterfaceError, Results};
use crate::surface::Symmetry;

/// The tangent of an interface at the positions it was made for, K = Σ (ε N Nᵀ − f M) over the contacts that carry force; with friction
/// what this adds.
///
/// ```
/// use diffuse_contact::assembly::{ContactLaw, DofMap, TangentOperator};
/// use diffuse_contact::{ContactInterface, Facet, InterfaceOptions, MasterSurface};
///
/// // 8 × 8 master facets in the plane z = 0, outside above, and one slave node 0.1 deep.
/// let mut positions: Vec<[f64; 3]> = (0..81).map(|k| [f64::from(k % 9), f64::from(k / 9), 0.0]).collect();
/// let facets = (0..64).map(|k| k % 8 + 9 * (k / 8)).map(|k| Facet::Quadrilateral([k, k + 1, k + 10, k + 9]));
/// let master = MasterSurface::new(&positions, facets.collect())?;
/// positions.push([4.2, 3.9, -0.1]);
/// let mut interface = ContactInterface::new(master, vec![81], &[], &positions, InterfaceOptions::default())?;
/// interface.refresh_pairing(&positions)?;
///
/// let dofs = DofMap::standard(82);
/// let mut tangent = TangentOperator::new(&interface, &ContactLaw::penalty(1e3), &dofs)?;
/// assert_eq!(tangent.contacts(), 1);
/// // The slave moves along z by 1: ε on the slave, −ε on the masters together.
/// let (mut v, mut product) = (vec![0.0; 246], vec![0.0; 246]);
/// v[3 * 81 + 2] = 1.0;
/// tangent.add_product(&v, &mut product)?;
/// assert!((product[3 * 81 + 2] - 1e3).abs() < 1e-9);
/// assert!(product.iter().skip(2).step_by(3).sum::<f64>().abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct TangentOperator {
    equations: usize,
    /// The equations of each node that takes part.
    nodes: Vec<[usize; 3]>,
    parts: Vec<Part>,
    /// Images behind planes of symmetry.
    symmetry: Symmetry,
    /// Where the contributions of each node are, in the order of the contacts.
    uses: Lists<usize>,
    /// Memory of a product: v of the nodes, what each point of each contact contributes, and the sums.
    moves: Vec<[f64; 3]>,
    contributions: Vec<[f64; 3]>,
    sums: Vec<[f64; 3]>,
}

/// Whether a contact carries force. One that the law has no number for is looked at again, and refused.
fn may_carry(law: &ContactLaw<'_>, k: usize, gap: f64, area: f64) -> bool {
    law.checked_normal_force(k, gap, area).map_or(true, |at| at.force > 0.0)
}

/// Slaves with friction that one thread evaluates in a row.
const AT_ONCE: usize = 256;

impl TangentOperator {
    /// The tangent of an interface by a law, at the positions of its last update, as an operator over the equations of `dofs`. Only what
    /// carries force is derived. A law with friction takes an interface with [anchors](ContactInterface::accept).
    ///
    /// # Errors
    /// [`InterfaceError::NotRefreshed`] before the first refresh; every reason for which the law is refused, [`AssemblyError::NoSlip`] where friction has no anchors, and
    /// [`AssemblyError::UnknownNode`], as [`InterfaceError::Law`]; [`InterfaceError::OutOfMemory`].
    pub fn new(
        interface: &ContactInterface,
        law: &ContactLaw<'_>,
        dofs: &DofMap,
    ) -> Result<Self, InterfaceError> {
        law.validate(interface.slaves().len())?;
        if law.friction.is_some() {
            interface.check_friction()?;
            return Self::with_friction(interface, law, dofs);
        }
        let with_second = law.tangent == Tangent::Exact;
        let found = interface.linearise(with_second, |k, gap, area| may_carry(law, k, gap, area))?;
        let mut numbering = Numbering::new(dofs)?;
        let mut parts = Vec::with_capacity(found.len());
        for contacts in found {
            parts.push(Part::new(contacts, interface.slaves(), law, &mut numbering)?);
        }
        Ok(Self::of(parts, numbering, interface.images())?)
    }

    fn with_friction(
        interface: &ContactInterface,
        law: &ContactLaw<'_>,
        dofs: &DofMap,
    ) -> Result<Self, InterfaceError> {
        interface.check_refreshed()?;
        let count = interface.slaves().len();
        let starts: Vec<usize> = (0..count).step_by(AT_ONCE).collect();
        let of_range = |start: usize| -> Result<(Part, Vec<Element>), InterfaceError> {
            let range = start..count.min(start + AT_ONCE);
            let (mut gaps, mut results) = (Results::default(), Results::default());
            let gap = interface.evaluate_loaded(range.clone(), Mode::Value, &|_| true, &mut gaps)?;
            let is_loaded =
                |k: usize| gap(k).view().is_some_and(|found| may_carry(law, k, found.gap, found.area));
            let contact =
                interface.evaluate_loaded(range.clone(), Mode::Hessian, &is_loaded, &mut results)?;
            let (mut part, mut elements) = (Part::default(), Vec::new());
            for k in range.filter(|&k| is_loaded(k)) {
                part.push(k, &contact(k), law, dofs, &mut elements)?;
            }
            Ok((part, elements))
        };
        let found: Vec<Result<_, InterfaceError>> = starts.into_par_iter().map(of_range).collect();
        let mut numbering = Numbering::new(dofs)?;
        let mut parts = Vec::with_capacity(found.len());
        for found in found {
            let (mut part, elements) = found?;
            for Element { index, nodes } in elements {
                for node in nodes {
                    part.nodes.push(numbering.number(index, node)?);
                }
            }
            parts.push(part);
        }
        Ok(Self::of(parts, numbering, Symmetry::default())?)
    }

    fn of(parts: Vec<Part>, numbering: Numbering<'_>, symmetry: Symmetry) -> Result<Self, AssemblyError> {
        let Numbering { dofs, equations: nodes, .. } = numbering;
        let points = parts.iter().flat_map(|part| part.nodes.iter().copied());
        let uses = Lists::by(nodes.len(), points.clone().zip(0..))?;
        let (moves, sums) = (zeros("nodes", nodes.len())?, zeros("nodes", nodes.len())?);
        let contributions = zeros("points", points.count())?;
        let equations = dofs.equations();
        Ok(Self { equations, nodes, parts, symmetry, uses, moves, contributions, sums })
    }

    /// Its part −f M, with what friction adds: all that the tangent has beside ε N Nᵀ. For hosts that assemble ε N Nᵀ, such as for a
    /// preconditioner, and take the rest as an operator.
    #[must_use]
    pub fn curvature(mut self) -> Self {
        let contacts = self.parts.iter_mut().flat_map(|part| &mut part.contacts);
        contacts.for_each(|contact| contact.stiffness = 0.0);
        self
    }

    /// Number of equations: rows and columns.
    pub const fn equations(&self) -> usize {
        self.equations
    }

    /// Number of contacts that carry force.
    pub fn contacts(&self) -> usize {
        self.parts.iter().map(|part| part.contacts.len()).sum()
    }

    /// Memory of the operator, bytes.
    pub fn bytes(&self) -> usize {
        let part = |part: &Part| {
            8 * (part.gradients.capacity() + part.seconds.capacity() + part.images.capacity())
                + 4 * part.nodes.capacity()
                + size_of::<part::Role>() * part.roles.capacity()
                + size_of::<Contact>() * part.contacts.capacity()
        };
        let nodes = self.nodes.capacity() + self.moves.capacity() + self.sums.capacity();
        self.parts.iter().map(part).sum::<usize>()
            + 24 * (nodes + self.contributions.capacity())
            + self.uses.memory()
    }

    /// Adds K v to `product`: one entry per equation. Every sum is formed in the order of the contacts: the result is the same for any
    /// number of threads, bit for bit. It differs from that of the assembled matrix by rounding.
    ///
    /// # Errors
    /// [`AssemblyError::OutputLength`], and [`AssemblyError::NonFiniteEntry`] for an entry of `v` that is not finite; `product` is then
    /// unchanged. [`AssemblyError::Overflow`] if a sum is not finite; its contents are then unspecified.
    pub fn add_product(&mut self, v: &[f64], product: &mut [f64]) -> Result<(), AssemblyError> {
        self.add_product_of(Side::Right, v, product)
    }

    /// Adds Kᵀ v. It is K v, bit for bit, unless friction is there, whose tangent is not symmetric.
    ///
    /// # Errors
    /// As [`add_product`](Self::add_product).
    pub fn add_transposed_product(&mut self, v: &[f64], product: &mut [f64]) -> Result<(), AssemblyError> {
        self.add_product_of(Side::Left, v, product)
    }

    fn add_product_of(&mut self, side: Side, v: &[f64], product: &mut [f64]) -> Result<(), AssemblyError> {
        AssemblyError::check_length("entries of v", v.len(), self.equations)?;
        AssemblyError::check_length("products", product.len(), self.equations)?;
        AssemblyError::check_finite("v", v)?;
        let entry = |&equation: &usize| if equation == NONE { 0.0 } else { v[equation] };
        self.moves
            .par_iter_mut()
            .zip(&self.nodes)
            .with_min_len(MIN_NODES)
            .for_each(|(moves, equations)| *moves = equations.each_ref().map(entry));
        let (moves, symmetry) = (&self.moves, &self.symmetry);
        let slots = split(&self.parts, &mut self.contributions);
        slots.into_par_iter().for_each(|(part, target)| part.multiply(side, moves, symmetry, target));
        self.add_sums("products", product)
    }

    /// Adds the diagonal of K to `diagonal`: one entry per equation.
    ///
    /// # Errors
    /// As [`add_product`](Self::add_product).
    pub fn add_diagonal(&mut self, diagonal: &mut [f64]) -> Result<(), AssemblyError> {
        AssemblyError::check_length("diagonal entries", diagonal.len(), self.equations)?;
        let symmetry = &self.symmetry;
        let slots = split(&self.parts, &mut self.contributions);
        slots.into_par_iter().for_each(|(part, target)| part.diagonal(symmetry, target));
        self.add_sums("diagonal entries", diagonal)
    }

    /// Adds what all points contribute.
    fn add_sums(&mut self, what: &'static str, target: &mut [f64]) -> Result<(), AssemblyError> {
        let Self { uses, contributions, sums, nodes, .. } = self;
        sums.par_iter_mut().enumerate().with_min_len(MIN_NODES).for_each(|(node, sum)| {
            *sum = [0.0; 3];
            for &place in uses.get(node) {
                for (sum, x) in sum.iter_mut().zip(contributions[place]) {
                    *sum += x;
                }
            }
        });
        for (equations, sum) in nodes.iter().zip(sums) {
            for (&equation, x) in equations.iter().zip(sum) {
                if equation != NONE {
                    add_entry(what, target, equation, *x)?;
                }
            }
        }
        Ok(())
    }
}

impl fmt::Debug for TangentOperator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (equations, contacts) = (self.equations, self.contacts());
        write!(
            f,
            "TangentOperator {{ equations: {equations}, contacts: {contacts}, bytes: {} }}",
            self.bytes()
        )
    }
}

/// Nodes that one thread works on at least.
const MIN_NODES: usize = 1024;

/// Each part with the places of what its points contribute.
fn split<'a>(
    parts: &'a [Part],
    mut contributions: &'a mut [[f64; 3]],
) -> Vec<(&'a Part, &'a mut [[f64; 3]])> {
    let front = |part: &'a Part| (part, contributions.split_off_mut(..part.nodes.len()).unwrap_or_default());
    parts.iter().map(front).collect()
}
