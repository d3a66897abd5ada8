//! The tangent as an operator: K v without K.
//!
//! What is held of a contact is N and the factors of M: 45 numbers for each of its points with a frame that is held, about 60 with the
//! default options. M itself is never there, nor a pattern. A product reads the numbers once. Where positions or forces change, another
//! operator is made.
//!
//! The slip of friction over nodes has no factors. With it the symmetric rest of the element's matrix is held as a packed triangle, and a
//! rank one of what is not symmetric: more memory, but no pattern either, and no rows that a rank would have to send.

use std::fmt;

use rayon::prelude::*;

use super::law::{Needs, Skew};
use super::{AssemblyError, ContactLaw, ContactView, DofMap, Tangent, reserve};
use crate::Mode;
use crate::affine::Carrier;
use crate::friction::NormalForce;
use crate::interface::{ContactInterface, ContactRef, InterfaceError, LinearContacts, Results, SecondForm};

/// Where there is no equation, or no image.
const NONE: usize = usize::MAX;

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
    /// Q of the images behind planes of symmetry, x' = Q x + t.
    rotations: Vec<[[f64; 3]; 3]>,
    /// Where the uses of each node begin, …
    starts: Vec<usize>,
    /// … and where its contributions are, in the order of the contacts.
    uses: Vec<usize>,
    /// Memory of a product: v of the nodes, what each point of each contact contributes, and the sums.
    moves: Vec<[f64; 3]>,
    contributions: Vec<[f64; 3]>,
    sums: Vec<[f64; 3]>,
}

/// Slaves with friction that one thread evaluates in a row.
const AT_ONCE: usize = 256;

/// A contact with friction: its slave, by place among the slaves, and its nodes, slave first.
struct Element {
    index: usize,
    nodes: Vec<usize>,
}

/// On which side of K the vector is: K v or vᵀ K.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Right,
    Left,
}

/// Contacts that one thread multiplies in a row.
#[derive(Clone, Default)]
struct Part {
    contacts: Vec<Contact>,
    /// Slave and points of each contact, by place among the nodes that take part.
    nodes: Vec<u32>,
    /// The image each of them is, if there is any.
    images: Vec<usize>,
    gradients: Vec<f64>,
    seconds: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
struct Contact {
    /// −∂f/∂g, force per length: of a penalty ε.
    stiffness: f64,
    /// f, force.
    force: f64,
    /// Slave and points.
    nodes: usize,
    gradient: usize,
    second: SecondForm,
    second_start: usize,
    /// Of friction whose size changes with the gap: a factor, and where ∇q begins among the gradients.
    skew: Option<(f64, usize)>,
}

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
        // A contact that the law has no number for is looked at again, and refused.
        let carries = |k, gap, area| law.checked_normal_force(k, gap, area).map_or(true, |at| at.force > 0.0);
        let found = interface.linearise(with_second, carries)?;
        let rotations = interface.rotations();
        let mut numbering = Numbering::new(dofs)?;
        let mut parts = Vec::with_capacity(found.len());
        for contacts in found {
            parts.push(Part::new(contacts, interface.slaves(), law, &mut numbering)?);
        }
        Ok(Self::of(parts, numbering, rotations)?)
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
            let is_loaded = |k: usize| {
                let ContactRef { outcome, point, area, .. } = gap(k);
                // A contact that the law has no number for is looked at again, and refused.
                outcome.is_contact()
                    && law.checked_normal_force(k, point.gap, area).map_or(true, |at| at.force > 0.0)
            };
            let contact =
                interface.evaluate_loaded(range.clone(), Mode::Hessian, &is_loaded, &mut results)?;
            let (mut part, mut elements) = (Part::default(), Vec::new());
            for k in range.filter(|&k| is_loaded(k)) {
                part.push(k, &contact(k), law, &mut elements)?;
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
        Ok(Self::of(parts, numbering, Vec::new())?)
    }

    fn of(
        parts: Vec<Part>,
        numbering: Numbering<'_>,
        rotations: Vec<[[f64; 3]; 3]>,
    ) -> Result<Self, AssemblyError> {
        let Numbering { dofs, equations: nodes, .. } = numbering;
        let points = parts.iter().map(|part| part.nodes.len()).sum();
        let mut starts = reserve("nodes", nodes.len() + 1)?;
        starts.resize(nodes.len() + 1, 0);
        for &node in parts.iter().flat_map(|part| &part.nodes) {
            starts[node as usize + 1] += 1;
        }
        for node in 0..nodes.len() {
            starts[node + 1] += starts[node];
        }
        let mut uses = reserve("points", points)?;
        uses.resize(points, 0);
        let mut next = starts.clone();
        for (place, &node) in parts.iter().flat_map(|part| &part.nodes).enumerate() {
            uses[next[node as usize]] = place;
            next[node as usize] += 1;
        }
        let zeros = |what, count| -> Result<Vec<[f64; 3]>, AssemblyError> {
            let mut zeros = reserve(what, count)?;
            zeros.resize(count, [0.0; 3]);
            Ok(zeros)
        };
        let (moves, sums) = (zeros("nodes", nodes.len())?, zeros("nodes", nodes.len())?);
        let contributions = zeros("points", points)?;
        let equations = dofs.equations();
        Ok(Self { equations, nodes, parts, rotations, starts, uses, moves, contributions, sums })
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
    #[must_use]
    pub const fn equations(&self) -> usize {
        self.equations
    }

    /// Number of contacts that carry force.
    #[must_use]
    pub fn contacts(&self) -> usize {
        self.parts.iter().map(|part| part.contacts.len()).sum()
    }

    /// Memory of the operator, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let part = |part: &Part| {
            8 * (part.gradients.capacity() + part.seconds.capacity() + part.images.capacity())
                + 4 * part.nodes.capacity()
                + size_of::<Contact>() * part.contacts.capacity()
        };
        let nodes = self.nodes.capacity() + self.moves.capacity() + self.sums.capacity();
        self.parts.iter().map(part).sum::<usize>()
            + 24 * (nodes + self.contributions.capacity())
            + 8 * (self.starts.capacity() + self.uses.capacity())
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
        self.check_length("entries of v", v.len())?;
        self.check_length("products", product.len())?;
        AssemblyError::check_finite("v", v)?;
        let entry = |&equation: &usize| if equation == NONE { 0.0 } else { v[equation] };
        self.moves
            .par_iter_mut()
            .zip(&self.nodes)
            .with_min_len(MIN_NODES)
            .for_each(|(moves, equations)| *moves = equations.each_ref().map(entry));
        let (moves, rotations) = (&self.moves, &self.rotations);
        let slots = split(&self.parts, &mut self.contributions);
        slots.into_par_iter().for_each(|(part, target)| part.multiply(side, moves, rotations, target));
        self.add_sums("products", product)
    }

    /// Adds the diagonal of K to `diagonal`: one entry per equation.
    ///
    /// # Errors
    /// As [`add_product`](Self::add_product).
    pub fn add_diagonal(&mut self, diagonal: &mut [f64]) -> Result<(), AssemblyError> {
        self.check_length("diagonal entries", diagonal.len())?;
        let rotations = &self.rotations;
        let slots = split(&self.parts, &mut self.contributions);
        slots.into_par_iter().for_each(|(part, target)| part.diagonal(rotations, target));
        self.add_sums("diagonal entries", diagonal)
    }

    fn check_length(&self, what: &'static str, found: usize) -> Result<(), AssemblyError> {
        let expected = self.equations;
        if found == expected { Ok(()) } else { Err(AssemblyError::OutputLength { what, found, expected }) }
    }

    /// Adds what all points contribute.
    fn add_sums(&mut self, what: &'static str, target: &mut [f64]) -> Result<(), AssemblyError> {
        let Self { starts, uses, contributions, sums, nodes, .. } = self;
        sums.par_iter_mut().enumerate().with_min_len(MIN_NODES).for_each(|(node, sum)| {
            *sum = [0.0; 3];
            for &place in &uses[starts[node]..starts[node + 1]] {
                for (sum, x) in sum.iter_mut().zip(contributions[place]) {
                    *sum += x;
                }
            }
        });
        for (equations, sum) in nodes.iter().zip(sums) {
            for (&equation, x) in equations.iter().zip(sum) {
                if equation == NONE {
                    continue;
                }
                target[equation] += *x;
                if !target[equation].is_finite() {
                    return Err(AssemblyError::Overflow { what, equation });
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

/// Gives the nodes that take part consecutive numbers.
struct Numbering<'a> {
    dofs: &'a DofMap,
    /// Of all nodes, or `u32::MAX`.
    numbers: Vec<u32>,
    /// Of those that take part.
    equations: Vec<[usize; 3]>,
}

impl<'a> Numbering<'a> {
    fn new(dofs: &'a DofMap) -> Result<Self, AssemblyError> {
        let mut numbers = reserve("nodes", dofs.nodes())?;
        numbers.resize(dofs.nodes(), u32::MAX);
        Ok(Self { dofs, numbers, equations: Vec::new() })
    }

    fn number(&mut self, element: usize, node: usize) -> Result<u32, AssemblyError> {
        let nodes = self.numbers.len();
        let Some(number) = self.numbers.get_mut(node) else {
            return Err(AssemblyError::UnknownNode { element, node, nodes });
        };
        if *number == u32::MAX {
            // An interface has fewer nodes than u32 has numbers.
            *number = self.equations.len() as u32;
            self.equations.push(self.dofs.of_node(node).map(|equation| equation.unwrap_or(NONE)));
        }
        Ok(*number)
    }
}

impl Part {
    fn new(
        found: LinearContacts,
        slaves: &[usize],
        law: &ContactLaw<'_>,
        numbering: &mut Numbering<'_>,
    ) -> Result<Self, AssemblyError> {
        let LinearContacts { contacts: all, points, gradients, seconds } = found;
        let mut contacts = reserve("contacts", all.len())?;
        let mut nodes = reserve("points", points.len() + all.len())?;
        let mut images = Vec::new();
        let mut rest = &points[..];
        for contact in all {
            let (own, others) = rest.split_at(contact.points);
            rest = others;
            let (k, freedoms) = (contact.index, 3 * (own.len() + 1));
            if contact.point.gap.is_nan() {
                continue;
            }
            let gradient = &gradients[contact.gradient..][..freedoms];
            let view = ContactView {
                gap: contact.point.gap,
                area: contact.area,
                gradient,
                hessian: &[],
                slip: None,
            };
            law.check_contact(k, &view, freedoms, Needs::Residual)?;
            let NormalForce { force, stiffness } = law.normal_force(k, contact.point.gap, contact.area);
            if !(force > 0.0) {
                continue;
            }
            contacts.push(Contact {
                stiffness,
                force,
                nodes: own.len() + 1,
                gradient: contact.gradient,
                second: contact.second,
                second_start: contact.second_start,
                skew: None,
            });
            nodes.push(numbering.number(k, slaves[k])?);
            for &Carrier { node, image } in own {
                nodes.push(numbering.number(k, node as usize)?);
                if let Some(image) = image {
                    images.resize(nodes.len() - 1, NONE);
                    images.push(image as usize);
                }
            }
        }
        Ok(Self { contacts, nodes, images, gradients, seconds })
    }

    /// Appends a contact with friction that carries force, all but its nodes.
    fn push(
        &mut self,
        k: usize,
        contact: &ContactRef<'_>,
        law: &ContactLaw<'_>,
        elements: &mut Vec<Element>,
    ) -> Result<(), AssemblyError> {
        let &ContactRef { slave, nodes, point, area, gradient, hessian, slip, .. } = contact;
        let view = ContactView { gap: point.gap, area, gradient, hessian, slip };
        law.check_contact(k, &view, 3 * (nodes.len() + 1), Needs::Tangent)?;
        let Some(active) = law.active_contact(k, &view) else { return Ok(()) };
        let (stiffness, rest, skew) = active.split();
        let (first, second_start) = (self.gradients.len(), self.seconds.len());
        self.gradients.extend_from_slice(gradient);
        let skew = skew.map(|Skew { factor, slip }| {
            self.gradients.extend_from_slice(slip);
            (factor, first + gradient.len())
        });
        for p in 0..gradient.len() {
            let row = self.seconds.len();
            self.seconds.resize(row + p + 1, 0.0);
            if !rest.tangent_row(p, &mut self.seconds[row..]) {
                let node = if p < 3 { slave } else { nodes[p / 3 - 1] as usize };
                return Err(AssemblyError::Overflow { what: "values", equation: 3 * node + p % 3 });
            }
        }
        // The rest stands for −f M.
        self.contacts.push(Contact {
            stiffness,
            force: -1.0,
            nodes: nodes.len() + 1,
            gradient: first,
            second: SecondForm::Packed,
            second_start,
            skew,
        });
        let nodes = std::iter::once(slave).chain(nodes.iter().map(|&node| node as usize)).collect();
        elements.push(Element { index: k, nodes });
        Ok(())
    }

    /// The contacts with where their points begin.
    fn placed(&self) -> impl Iterator<Item = (usize, &Contact)> {
        self.contacts.iter().scan(0, |start, contact| {
            let own = *start;
            *start += contact.nodes;
            Some((own, contact))
        })
    }

    /// Room for a vector over the freedoms of any contact.
    fn room(&self) -> Vec<f64> {
        vec![0.0; 3 * self.contacts.iter().map(|contact| contact.nodes).max().unwrap_or(0)]
    }

    /// Q of the point at a place, if it is an image.
    fn rotation<'r>(&self, rotations: &'r [[[f64; 3]; 3]], place: usize) -> Option<&'r [[f64; 3]; 3]> {
        self.images.get(place).and_then(|&image| rotations.get(image))
    }

    /// What each point contributes to K v or Kᵀ v, v given for all nodes.
    fn multiply(&self, side: Side, moves: &[[f64; 3]], rotations: &[[[f64; 3]; 3]], target: &mut [[f64; 3]]) {
        let (mut v, mut product) = (self.room(), self.room());
        for (start, contact) in self.placed() {
            let freedoms = 3 * contact.nodes;
            for (k, v) in v[..freedoms].as_chunks_mut::<3>().0.iter_mut().enumerate() {
                let node = moves[self.nodes[start + k] as usize];
                *v = forth(self.rotation(rotations, start + k), node);
            }
            self.element(side, contact, &v[..freedoms], &mut product[..freedoms]);
            for (k, product) in product[..freedoms].as_chunks::<3>().0.iter().enumerate() {
                target[start + k] = back(self.rotation(rotations, start + k), *product);
            }
        }
    }

    /// (ε N Nᵀ − f M) v of one contact, and what of friction is not symmetric, q Nᵀ v or N qᵀ v.
    fn element(&self, side: Side, contact: &Contact, v: &[f64], product: &mut [f64]) {
        let gradient = &self.gradients[contact.gradient..][..v.len()];
        let second = &self.seconds[contact.second_start..];
        match contact.second {
            SecondForm::None => product.fill(0.0),
            SecondForm::Factors(form) => form.multiply(second, v, product),
            SecondForm::Packed => multiply_packed(second, v, product),
        }
        let along: f64 = gradient.iter().zip(v).map(|(n, v)| n * v).sum();
        let stiff = contact.stiffness * along;
        for (entry, n) in product.iter_mut().zip(gradient) {
            *entry = stiff * n - contact.force * *entry;
        }
        if let Some((factor, start)) = contact.skew {
            let slip = &self.gradients[start..][..v.len()];
            let (out, along) = match side {
                Side::Right => (slip, along),
                Side::Left => (gradient, slip.iter().zip(v).map(|(q, v)| q * v).sum()),
            };
            product.iter_mut().zip(out).for_each(|(entry, x)| *entry += factor * along * x);
        }
    }

    /// What each point contributes to the diagonal of K.
    fn diagonal(&self, rotations: &[[[f64; 3]; 3]], target: &mut [[f64; 3]]) {
        let (mut v, mut product) = (self.room(), self.room());
        for (start, contact) in self.placed() {
            let nodes = &self.nodes[start..][..contact.nodes];
            let freedoms = 3 * contact.nodes;
            let (v, product) = (&mut v[..freedoms], &mut product[..freedoms]);
            self.element_diagonal(contact, product);
            for (k, entries) in product.as_chunks::<3>().0.iter().enumerate() {
                target[start + k] = *entries;
            }
            // Of a node that takes part more than once, or as an image, the entries are those of products with its own moves.
            for k in 1..nodes.len() {
                let same = || (0..nodes.len()).filter(|&other| nodes[other] == nodes[k]);
                let is_plain = same().count() == 1 && self.rotation(rotations, start + k).is_none();
                if is_plain {
                    continue;
                }
                let first = same().next() == Some(k);
                target[start + k] = [0.0; 3];
                for axis in (0..3).filter(|_| first) {
                    let mut unit = [0.0; 3];
                    unit[axis] = 1.0;
                    v.fill(0.0);
                    for place in same() {
                        let moved = forth(self.rotation(rotations, start + place), unit);
                        v[3 * place..][..3].copy_from_slice(&moved);
                    }
                    self.element(Side::Right, contact, v, product);
                    for place in same() {
                        let own = [0, 1, 2].map(|axis| product[3 * place + axis]);
                        target[start + k][axis] += back(self.rotation(rotations, start + place), own)[axis];
                    }
                }
            }
        }
    }

    fn element_diagonal(&self, contact: &Contact, diagonal: &mut [f64]) {
        let gradient = &self.gradients[contact.gradient..][..diagonal.len()];
        let second = &self.seconds[contact.second_start..];
        match contact.second {
            SecondForm::None => diagonal.fill(0.0),
            SecondForm::Factors(form) => form.diagonal(second, diagonal),
            SecondForm::Packed => {
                for (row, entry) in diagonal.iter_mut().enumerate() {
                    *entry = second[row * (row + 1) / 2 + row];
                }
            }
        }
        for (entry, n) in diagonal.iter_mut().zip(gradient) {
            *entry = contact.stiffness * (n * n) - contact.force * *entry;
        }
        if let Some((factor, start)) = contact.skew {
            let slip = &self.gradients[start..][..diagonal.len()];
            let pairs = slip.iter().zip(gradient);
            diagonal.iter_mut().zip(pairs).for_each(|(entry, (q, n))| *entry += factor * q * n);
        }
    }
}

/// `product` = M v of a packed lower triangle.
fn multiply_packed(packed: &[f64], v: &[f64], product: &mut [f64]) {
    product.fill(0.0);
    let mut start = 0;
    for row in 0..v.len() {
        let entries = &packed[start..=start + row];
        start += row + 1;
        let mut sum = entries[row] * v[row];
        for column in 0..row {
            sum += entries[column] * v[column];
            product[column] += entries[column] * v[row];
        }
        product[row] += sum;
    }
}

/// Q v
fn forth(rotation: Option<&[[f64; 3]; 3]>, v: [f64; 3]) -> [f64; 3] {
    rotation.map_or(v, |q| q.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]))
}

/// Qᵀ v
fn back(rotation: Option<&[[f64; 3]; 3]>, v: [f64; 3]) -> [f64; 3] {
    rotation.map_or(v, |q| [0, 1, 2].map(|j| q[0][j] * v[0] + q[1][j] * v[1] + q[2][j] * v[2]))
}
