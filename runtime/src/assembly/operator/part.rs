//! The contacts that one thread multiplies in a row.

use crate::affine::Carrier;
use crate::assembly::active::Skew;
use crate::assembly::law::Needs;
use crate::assembly::{AssemblyError, ContactLaw, ContactView, DofMap, reserve};
use crate::friction::NormalForce;
use crate::interface::{ContactRef, LinearContacts, SecondForm, back};
use crate::surface::{Image, Symmetry};

/// Where there is no equation.
pub(super) const NONE: usize = usize::MAX;

/// A contact with friction: its slave, by place among the slaves, and its nodes, slave first.
pub(super) struct Element {
    pub index: usize,
    pub nodes: Vec<usize>,
}

/// On which side of K the vector is: K v or vᵀ K.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Right,
    Left,
}

/// Contacts that one thread multiplies in a row.
#[derive(Clone, Default)]
pub(super) struct Part {
    pub contacts: Vec<Contact>,
    /// Slave and points of each contact, by place among the nodes that take part: of an auxiliary point both its ends.
    pub nodes: Vec<u32>,
    /// The image each of them is, if there is any.
    pub images: Vec<Option<u32>>,
    /// What each of them has of its point, up to the last that is an end.
    pub roles: Vec<Role>,
    pub gradients: Vec<f64>,
    pub seconds: Vec<f64>,
}

/// What a node has of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Role {
    /// It is the point.
    Whole,
    /// Its part of a point that this node carries …
    First(f64),
    /// … and the one after it.
    Second(f64),
}

/// A node of a contact: where it is among all, its point, and what it has of that.
struct Share {
    place: usize,
    point: usize,
    part: f64,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// −∂f/∂g, force per length: of a penalty ε.
    pub stiffness: f64,
    /// f, force.
    pub force: f64,
    /// Slave and points.
    pub points: usize,
    /// Nodes of these.
    pub nodes: usize,
    pub gradient: usize,
    pub second: SecondForm,
    pub second_start: usize,
    /// Of friction whose size changes with the gap: a factor, and where ∇q begins among the gradients.
    pub skew: Option<(f64, usize)>,
}

/// Gives the nodes that take part consecutive numbers.
pub(super) struct Numbering<'a> {
    pub dofs: &'a DofMap,
    /// Of all nodes, or `u32::MAX`.
    numbers: Vec<u32>,
    /// Of those that take part.
    pub equations: Vec<[usize; 3]>,
}

impl<'a> Numbering<'a> {
    pub fn new(dofs: &'a DofMap) -> Result<Self, AssemblyError> {
        let mut numbers = reserve("nodes", dofs.nodes())?;
        numbers.resize(dofs.nodes(), u32::MAX);
        Ok(Self { dofs, numbers, equations: Vec::new() })
    }

    pub fn number(&mut self, element: usize, node: usize) -> Result<u32, AssemblyError> {
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
    pub fn new(
        found: LinearContacts,
        slaves: &[usize],
        law: &ContactLaw<'_>,
        numbering: &mut Numbering<'_>,
    ) -> Result<Self, AssemblyError> {
        let LinearContacts { contacts: all, points, gradients, seconds } = found;
        let mut contacts = reserve("contacts", all.len())?;
        let mut nodes = reserve("points", points.len() + all.len())?;
        let (mut images, mut roles) = (Vec::new(), Vec::new());
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
            let start = nodes.len();
            nodes.push(numbering.number(k, slaves[k])?);
            for point in own {
                let is_auxiliary = point.carriers().count() > 1;
                for ((Carrier { node, image }, part), role) in
                    point.carriers().zip([Role::First, Role::Second])
                {
                    nodes.push(numbering.number(k, node as usize)?);
                    if is_auxiliary {
                        roles.resize(nodes.len() - 1, Role::Whole);
                        roles.push(role(part));
                    }
                    if image.is_some() {
                        images.resize(nodes.len() - 1, None);
                        images.push(image);
                    }
                }
            }
            contacts.push(Contact {
                stiffness,
                force,
                points: own.len() + 1,
                nodes: nodes.len() - start,
                gradient: contact.gradient,
                second: contact.second,
                second_start: contact.second_start,
                skew: None,
            });
        }
        Ok(Self { contacts, nodes, images, roles, gradients, seconds })
    }

    /// Appends a contact with friction that carries force, all but its nodes.
    pub fn push(
        &mut self,
        k: usize,
        contact: &ContactRef<'_>,
        law: &ContactLaw<'_>,
        dofs: &DofMap,
        elements: &mut Vec<Element>,
    ) -> Result<(), AssemblyError> {
        let &ContactRef { slave, nodes, gradient, .. } = contact;
        // Beside a border rounding may end a contact in the second evaluation.
        let Some(view) = contact.view() else { return Ok(()) };
        law.check_contact(k, &view, 3 * (nodes.len() + 1), Needs::Tangent)?;
        let Some(active) = law.active_contact(k, &view) else { return Ok(()) };
        let (stiffness, rest, skew) = active.split();
        let (first, second_start) = (self.gradients.len(), self.seconds.len());
        self.gradients.extend_from_slice(gradient);
        let skew = skew.map(|Skew { factor, slip }| {
            self.gradients.extend_from_slice(slip);
            (factor, first + gradient.len())
        });
        let equation = |p: usize| {
            let node = if p < 3 { slave } else { nodes[p / 3 - 1] as usize };
            // A node that is none has no equation; it is refused where nodes get their numbers.
            if node < dofs.nodes() { dofs.equation(node, p % 3) } else { None }
        };
        for p in 0..gradient.len() {
            let row = self.seconds.len();
            self.seconds.resize(row + p + 1, 0.0);
            if rest.tangent_row(p, &mut self.seconds[row..]) {
                continue;
            }
            // An entry between displacements that are prescribed is in no product.
            let entries = self.seconds[row..].iter().enumerate().filter(|(_, entry)| !entry.is_finite());
            if let Some(equation) = entries.filter_map(|(q, _)| equation(p).or_else(|| equation(q))).next() {
                return Err(AssemblyError::Overflow { what: "values", equation });
            }
        }
        // The rest stands for −f M.
        self.contacts.push(Contact {
            stiffness,
            force: -1.0,
            points: nodes.len() + 1,
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

    /// The nodes of a contact whose first one is at `start`.
    fn shares(&self, start: usize, contact: &Contact) -> impl Iterator<Item = Share> + Clone {
        let mut points = 0;
        (start..start + contact.nodes).map(move |place| {
            let role = self.roles.get(place).copied().unwrap_or(Role::Whole);
            let (is_next, part) = match role {
                Role::Whole => (true, 1.0),
                Role::First(part) => (true, part),
                Role::Second(part) => (false, part),
            };
            points += usize::from(is_next);
            Share { place, point: points - 1, part }
        })
    }

    /// Room for a vector over the freedoms of any contact.
    fn room(&self) -> Vec<f64> {
        vec![0.0; 3 * self.contacts.iter().map(|contact| contact.points).max().unwrap_or(0)]
    }

    /// The image that the point at a place is, if it is one.
    fn image<'s>(&self, symmetry: &'s Symmetry, place: usize) -> Option<&'s Image> {
        self.images.get(place).copied().flatten().map(|number| symmetry.image(number))
    }

    /// What each point contributes to K v or Kᵀ v, v given for all nodes.
    pub fn multiply(&self, side: Side, moves: &[[f64; 3]], symmetry: &Symmetry, target: &mut [[f64; 3]]) {
        let (mut v, mut product) = (self.room(), self.room());
        for (start, contact) in self.placed() {
            let (v, product) = (&mut v[..3 * contact.points], &mut product[..3 * contact.points]);
            v.fill(0.0);
            for Share { place, point, part } in self.shares(start, contact) {
                let moved = forth(self.image(symmetry, place), moves[self.nodes[place] as usize]);
                v[3 * point..].iter_mut().zip(moved).for_each(|(v, x)| *v += part * x);
            }
            self.element(side, contact, v, product);
            let product = product.as_chunks::<3>().0;
            for Share { place, point, part } in self.shares(start, contact) {
                target[place] = back(self.image(symmetry, place), product[point]).map(|x| part * x);
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
    pub fn diagonal(&self, symmetry: &Symmetry, target: &mut [[f64; 3]]) {
        let (mut v, mut product) = (self.room(), self.room());
        for (start, contact) in self.placed() {
            let (v, product) = (&mut v[..3 * contact.points], &mut product[..3 * contact.points]);
            self.element_diagonal(contact, product);
            for Share { place, point, .. } in self.shares(start, contact) {
                target[place] = product.as_chunks::<3>().0[point];
            }
            // Of a node that takes part more than once, as an image or with a part of a point, the entries are those of products with its own
            // moves.
            let shares = || self.shares(start, contact);
            for own in shares() {
                let same = || shares().filter(|other| self.nodes[other.place] == self.nodes[own.place]);
                let is_whole = own.part == 1.0 && self.image(symmetry, own.place).is_none();
                if is_whole && same().count() == 1 {
                    continue;
                }
                let first = same().next().is_some_and(|first| first.place == own.place);
                target[own.place] = [0.0; 3];
                for axis in (0..3).filter(|_| first) {
                    let mut unit = [0.0; 3];
                    unit[axis] = 1.0;
                    v.fill(0.0);
                    for Share { place, point, part } in same() {
                        let moved = forth(self.image(symmetry, place), unit);
                        v[3 * point..].iter_mut().zip(moved).for_each(|(v, x)| *v += part * x);
                    }
                    self.element(Side::Right, contact, v, product);
                    for Share { place, point, part } in same() {
                        let by = [0, 1, 2].map(|axis| product[3 * point + axis]);
                        target[own.place][axis] += part * back(self.image(symmetry, place), by)[axis];
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

/// Q v, for an image x' = Q x + t.
fn forth(image: Option<&Image>, v: [f64; 3]) -> [f64; 3] {
    image.map_or(v, |image| image.rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ContactPoint;
    use crate::interface::Outcome;
    use crate::neighbourhood::Fallback;

    #[test]
    fn the_diagonal_of_a_slave_among_its_own_masters_is_that_of_products() {
        let contact = Contact {
            stiffness: 2.0,
            force: 0.0,
            points: 2,
            nodes: 2,
            gradient: 0,
            second: SecondForm::None,
            second_start: 0,
            skew: None,
        };
        let part = Part {
            contacts: vec![contact],
            nodes: vec![0, 0],
            gradients: vec![0.0, 0.0, 1.0, 0.0, 0.0, -0.5],
            ..Part::default()
        };
        let [mut product, mut diagonal] = [[[0.0; 3]; 2]; 2];
        part.multiply(Side::Right, &[[0.0, 0.0, 1.0]], &Symmetry::default(), &mut product);
        part.diagonal(&Symmetry::default(), &mut diagonal);
        let sum = |all: [[f64; 3]; 2]| all[0][2] + all[1][2];
        assert_eq!((sum(product), sum(diagonal)), (0.5, 0.5));
    }

    #[test]
    fn an_overflow_names_the_equation_of_the_caller() {
        let mut hessian = [0.0; 21];
        hessian[0] = 1e308;
        let point = ContactPoint { gap: -1.0, ..ContactPoint::default() };
        let contact = ContactRef {
            slave: 0,
            nodes: &[1],
            outcome: Outcome::Contact { fallback: Fallback::None },
            point,
            area: 1.0,
            gradient: &[0.0, 0.0, 1.0, 0.0, 0.0, -1.0],
            hessian: &hessian,
            slip: None,
        };
        let pushed = |is_free: fn(usize, usize) -> bool| {
            let dofs = DofMap::numbering(2, is_free).unwrap();
            Part::default().push(0, &contact, &ContactLaw::penalty(100.0), &dofs, &mut Vec::new())
        };
        // The equations of the master come first.
        let dofs = DofMap::from_first(6, [Some(3), Some(0)]).unwrap();
        let found = Part::default().push(0, &contact, &ContactLaw::penalty(100.0), &dofs, &mut Vec::new());
        assert_eq!(found, Err(AssemblyError::Overflow { what: "values", equation: 3 }));
        assert_eq!(pushed(|node, axis| (node, axis) != (0, 0)), Ok(()));
    }
}
