//! What a law of the host's needs at the feet: the masters' weights, and first derivatives of foot and normal.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::contacts::{Layout, front, resize};
use super::fill::CHUNK;
use super::linearise::{LinearContact, Second, SecondForm};
use super::{ContactInterface, FitPoint, InterfaceError, NoContact, Outcome, back};
use crate::foot::facet_foot_derivatives;
use crate::surface::Image;
use crate::{ContactPoint, ElementError, FootDerivatives};

/// The feet of all slaves with first derivatives, in the order of the slaves.
#[derive(Clone, Debug)]
pub struct ContactFeet {
    layout: Arc<Layout>,
    outcomes: Vec<Outcome>,
    points: Vec<ContactPoint>,
    weights: Vec<f64>,
    foot: Vec<f64>,
    normal: Vec<f64>,
}

/// The foot of one slave node.
#[derive(Clone, Copy, Debug)]
pub struct FootRef<'a> {
    /// Index of the slave node in all positions.
    pub slave: usize,
    /// Indices of the master nodes 1 … n, those of the pairing.
    pub nodes: &'a [u32],
    /// Whether there is a result; without one the fields below are zero or empty.
    pub outcome: Outcome,
    /// Gap, foot and normal.
    pub point: ContactPoint,
    /// φ, a number for each master, Σ φ_k = 1: what a field over the nodes is at the foot. The foot itself is Σ φ_k x_k; behind planes of
    /// symmetry the images of a node add to its number, and their positions to the foot.
    pub weights: &'a [f64],
    /// ∂x^d/∂x, a row of 3(n+1) entries for each component, ordered slave, master 1, …, master n; dimensionless.
    pub foot: &'a [f64],
    /// ∂ν/∂x, the same, 1/length.
    pub normal: &'a [f64],
}

impl ContactFeet {
    /// Number of slave nodes.
    pub fn len(&self) -> usize {
        self.outcomes.len()
    }

    /// Whether there are no slave nodes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The foot of the `k`-th slave node.
    ///
    /// # Panics
    /// If there is none.
    pub fn get(&self, k: usize) -> FootRef<'_> {
        let outcome = self.outcomes[k];
        let end = if outcome.is_contact() { k + 1 } else { k };
        let weights = self.layout.offset(k)..self.layout.offset(end);
        let rows = 3 * self.layout.gradient(k)..3 * self.layout.gradient(end);
        FootRef {
            slave: self.layout.slave(k),
            nodes: self.layout.masters(k),
            outcome,
            point: self.points[k],
            weights: &self.weights[weights],
            foot: &self.foot[rows.clone()],
            normal: &self.normal[rows],
        }
    }

    /// All slave nodes in their order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = FootRef<'_>> {
        (0..self.len()).map(|k| self.get(k))
    }
}

/// Room for the feet of consecutive slaves.
struct Slots<'a> {
    range: Range<usize>,
    outcomes: &'a mut [Outcome],
    points: &'a mut [ContactPoint],
    weights: &'a mut [f64],
    foot: &'a mut [f64],
    normal: &'a mut [f64],
}

impl ContactInterface {
    /// The masters' weights in the foot of every slave, and the first derivatives of foot and normal, at the positions of the last
    /// [`update`](Self::update) or [`refresh_pairing`](Self::refresh_pairing), with the pairing held: what a law of the host's at
    /// the foot needs beside [`evaluate`](Self::evaluate). The same for any number of threads.
    ///
    /// # Errors
    /// [`InterfaceError::NotRefreshed`] before the first refresh; [`InterfaceError::OutOfMemory`]: 18 (n + 1) + n numbers for each slave.
    pub fn foot_derivatives(&self) -> Result<ContactFeet, InterfaceError> {
        self.check_refreshed()?;
        let layout = &self.pairings.layout;
        let all = self.pairings.all();
        let (weights, rows) = (layout.offset(all.end), 3 * layout.gradient(all.end));
        let mut feet = ContactFeet {
            layout: Arc::clone(layout),
            outcomes: filled(all.len(), Outcome::None(NoContact::NotPaired))?,
            points: filled(all.len(), ContactPoint::default())?,
            weights: filled(weights, 0.0)?,
            foot: filled(rows, 0.0)?,
            normal: filled(rows, 0.0)?,
        };
        let mut rest = Slots {
            range: all.clone(),
            outcomes: &mut feet.outcomes,
            points: &mut feet.points,
            weights: &mut feet.weights,
            foot: &mut feet.foot,
            normal: &mut feet.normal,
        };
        let mut chunks = Vec::new();
        while !rest.range.is_empty() {
            let (chunk, others) = rest.split(layout);
            chunks.push(chunk);
            rest = others;
        }
        chunks.into_par_iter().try_for_each(|chunk| self.feet_of(chunk))?;
        Ok(feet)
    }

    fn feet_of(&self, slots: Slots<'_>) -> Result<(), InterfaceError> {
        let layout = &self.pairings.layout;
        let values = self.values_of(slots.range.clone())?;
        let first = slots.range.start;
        for k in slots.range.clone() {
            slots.outcomes[k - first] = values.get(layout, k).outcome;
        }
        let present: Vec<usize> =
            slots.range.clone().filter(|&k| slots.outcomes[k - first].is_contact()).collect();
        let found = self.linearise_slaves(&present, Second::AtFoot)?;
        // Without a reason of its own a result is missing where numbers overflowed.
        let overflow =
            Outcome::None(NoContact::from(ElementError::Overflow { what: "derivative at the foot" }));
        present.iter().for_each(|k| slots.outcomes[k - first] = overflow);
        let mut rest = &found.points[..];
        for contact in &found.contacts {
            let (points, others) = rest.split_at(contact.points);
            rest = others;
            let (gradient, second) =
                (&found.gradients[contact.gradient..], &found.seconds[contact.second_start..]);
            let freedoms = 3 * (points.len() + 1);
            let Ok(by_points) = by_points(contact, &gradient[..freedoms], second) else { continue };
            let k = contact.index;
            let (weight, row) = (layout.offset(first), 3 * layout.gradient(first));
            let weights = layout.offset(k) - weight..layout.offset(k + 1) - weight;
            let rows = 3 * layout.gradient(k) - row..3 * layout.gradient(k + 1) - row;
            let target =
                [&mut slots.weights[weights], &mut slots.foot[rows.clone()], &mut slots.normal[rows]];
            self.fold_foot(&by_points, points, layout.masters(k), target);
            (slots.outcomes[k - first], slots.points[k - first]) =
                (values.get(layout, k).outcome, contact.point);
        }
        Ok(())
    }

    /// Derivatives by the points of an element, as those by the listed nodes of its slave.
    fn fold_foot(
        &self,
        by_points: &FootDerivatives,
        points: &[FitPoint],
        listed: &[u32],
        [weights, foot, normal]: [&mut [f64]; 3],
    ) {
        let (own, freedoms) = (3 * (points.len() + 1), 3 * (listed.len() + 1));
        // Nodes are in the order of the listed ones, auxiliary points come after them.
        let mut last = 0;
        let mut place = |node: u32| {
            let next = (last..listed.len()).chain(0..last).find(|&place| listed[place] == node);
            last = next.unwrap_or_else(|| unreachable!("points are of listed nodes"));
            last
        };
        let parts = (0..).zip(points).flat_map(|(k, point)| point.carriers().map(move |part| (k, part)));
        let parts: Vec<(usize, usize, Option<&Image>, f64)> = parts
            .map(|(k, (carrier, part))| (k, place(carrier.node), self.image_of(carrier), part))
            .collect();
        for &(k, place, _, part) in &parts {
            weights[place] += part * by_points.weights[k];
        }
        for (target, rows) in [(foot, &by_points.foot), (normal, &by_points.normal)] {
            for (target, row) in target.chunks_exact_mut(freedoms).zip(rows.chunks_exact(own)) {
                let (slave, by) = row.split_at(3);
                target[..3].copy_from_slice(slave);
                for &(k, place, image, part) in &parts {
                    let by_node = back(image, by.as_chunks::<3>().0[k]);
                    for (entry, value) in target[3 * (place + 1)..].iter_mut().zip(by_node) {
                        *entry += part * value;
                    }
                }
            }
        }
    }
}

impl<'a> Slots<'a> {
    /// The first slaves, as many as a thread takes at once, and the others.
    fn split(mut self, layout: &Layout) -> (Self, Self) {
        let Range { start, end } = self.range;
        let middle = end.min(start + CHUNK);
        let weights = layout.offset(middle) - layout.offset(start);
        let rows = 3 * (layout.gradient(middle) - layout.gradient(start));
        let first = Self {
            range: start..middle,
            outcomes: front(&mut self.outcomes, middle - start),
            points: front(&mut self.points, middle - start),
            weights: front(&mut self.weights, weights),
            foot: front(&mut self.foot, rows),
            normal: front(&mut self.normal, rows),
        };
        (first, Self { range: middle..end, ..self })
    }
}

/// The derivatives by the points of a contact.
fn by_points(
    contact: &LinearContact,
    gradient: &[f64],
    second: &[f64],
) -> Result<FootDerivatives, ElementError> {
    let mut all = FootDerivatives::zeros(contact.point, contact.points);
    let point = &contact.point;
    match contact.second {
        SecondForm::Factors(form) => form.foot_derivatives(point, gradient, second, &mut all.slot())?,
        SecondForm::Packed | SecondForm::None => {
            facet_foot_derivatives(point, gradient, second, &mut all.slot())?;
        }
    }
    Ok(all)
}

fn filled<T: Clone>(count: usize, value: T) -> Result<Vec<T>, InterfaceError> {
    let mut all = Vec::new();
    resize(&mut all, count, value)?;
    Ok(all)
}
