//! The history of friction: where each slave stuck to the master.
//!
//! An anchor's nodes are listed with the slave's masters, so that derivatives by the anchor become derivatives by listed nodes, and the
//! assembly of forces and tangents has no more to know. Anchors change in [`accept`](super::ContactInterface::accept) alone.

use super::InterfaceError;
use super::fold::AnchorSource;
use super::pairings::Paired;
use crate::AffinePoint;
use crate::affine::Carrier;
use crate::friction::BeforeStep;
use crate::surface::window::LARGEST_NUMBER;
use crate::surface::{MasterSurface, NONE, Symmetry};

/// Where a slave was on the master when the last step was accepted.
#[derive(Clone, Debug, PartialEq)]
pub struct Anchor {
    /// The material point of the master that the slip is measured from: where the slave stuck, or its foot if it was open.
    pub point: AffinePoint,
    /// How far the contact was from carrying force if it was open, length: the gap, but for [normal laws](crate::assembly::NormalLaw::onset)
    /// whose pressure begins elsewhere; else 0. The slip of a contact that closes begins at the place of touch.
    pub opening: f64,
    /// The friction of a contact that slid then, and the largest that one that stuck could bear, min(μ p, τ A): force, over faces force per
    /// area. The work of the next step begins with it.
    pub limit: f64,
    /// Whether it slid then.
    pub slid: bool,
    /// With augmentation: where the slave stuck. The way from here to `point` is the tangential multiplier over ε_T. `None`: at `point`.
    pub origin: Option<AffinePoint>,
}

impl Anchor {
    /// Of a slave that stuck at this point.
    pub const fn new(point: AffinePoint) -> Self {
        Self { point, opening: 0.0, limit: 0.0, slid: false, origin: None }
    }

    /// What the work of the next step begins with.
    pub(crate) const fn before_step(&self) -> BeforeStep {
        match (self.opening > 0.0, self.slid) {
            (true, _) => BeforeStep::Open,
            (false, true) => BeforeStep::Slid(self.limit),
            (false, false) => BeforeStep::Stuck(self.limit),
        }
    }

    /// Whether opening and limit are finite and not negative, and not both more than 0.
    pub(crate) fn check(&self, index: usize) -> Result<(), InterfaceError> {
        let Self { opening, limit, .. } = *self;
        for (value, other) in [(opening, limit), (limit, opening)] {
            if !(value >= 0.0 && value.is_finite() && (value == 0.0 || other == 0.0)) {
                return Err(InterfaceError::InvalidOpening { index, value });
            }
        }
        if self.slid && opening > 0.0 {
            return Err(InterfaceError::InvalidOpening { index, value: opening });
        }
        Ok(())
    }

    /// Where the slave stuck.
    pub(crate) fn stuck_at(&self) -> &AffinePoint {
        self.origin.as_ref().unwrap_or(&self.point)
    }

    fn carriers(&self) -> impl Iterator<Item = Carrier> + '_ {
        let origin = self.origin.iter().flat_map(AffinePoint::terms);
        self.point.terms().iter().chain(origin).map(|&(carrier, _)| carrier)
    }
}

/// What the number of carriers of an anchor that slid has more.
const SLID: f64 = 0.5;

/// Anchors as plain numbers, slave after slave, −1 for a slave without one:
///
/// * the number of carriers, and a half more if the contact slid;
/// * the opening less the limit, of which one is 0;
/// * of each carrier its node, the number of its image (−1: none), and its weight.
///
/// Before an anchor with an origin there are −2 and the origin: the number of its carriers, and the carriers. `number_of`: what a node is
/// called.
pub fn to_numbers(anchors: &[Option<Anchor>], number_of: impl Fn(u32) -> f64) -> Vec<f64> {
    let mut numbers = Vec::new();
    for anchor in anchors {
        let Some(Anchor { point, opening, limit, slid, origin }) = anchor else {
            numbers.push(-1.0);
            continue;
        };
        if let Some(origin) = origin {
            numbers.extend([-2.0, origin.terms().len() as f64]);
            push_terms(origin, &number_of, &mut numbers);
        }
        let slid = if *slid { SLID } else { 0.0 };
        numbers.extend([point.terms().len() as f64 + slid, opening - limit]);
        push_terms(point, &number_of, &mut numbers);
    }
    numbers
}

fn push_terms(point: &AffinePoint, number_of: impl Fn(u32) -> f64, numbers: &mut Vec<f64>) {
    for &(Carrier { node, image }, weight) in point.terms() {
        numbers.extend([number_of(node), image.map_or(-1.0, f64::from), weight]);
    }
}

/// What [`to_numbers`] made numbers of. Of weights that do not add up to one the first is said to be none of a history. `node_of`: the node
/// of a number in the k-th anchor; `None` for a number that names none, and an error for a node that is not there.
///
/// # Errors
/// [`InterfaceError::InvalidHistory`], and those of `node_of`.
pub fn from_numbers(
    numbers: &[f64],
    node_of: impl Fn(usize, u64) -> Result<Option<u32>, InterfaceError>,
) -> Result<Vec<Option<Anchor>>, InterfaceError> {
    let none = |place: usize| InterfaceError::InvalidHistory { place };
    let number = |place: usize| {
        let value = numbers.get(place).copied().ok_or_else(|| none(place))?;
        let is_number = value >= 0.0 && value < LARGEST_NUMBER as f64 && value.fract() == 0.0;
        if is_number { Ok(value as u64) } else { Err(none(place)) }
    };
    let index = |place: usize| u32::try_from(number(place)?).map_err(|_| none(place));
    let point = |anchor: usize, start: usize, count: usize| {
        let mut terms = Vec::new();
        for at in (0..count).map(|k| start + 3 * k) {
            let image = if numbers.get(at + 1) == Some(&-1.0) { None } else { Some(index(at + 1)?) };
            let weight = numbers.get(at + 2).copied().filter(|weight| weight.is_finite());
            let weight = weight.ok_or_else(|| none(at + 2))?;
            let node = node_of(anchor, number(at)?)?.ok_or_else(|| none(at))?;
            terms.push((Carrier { node, image }, weight));
        }
        // Of weights that do not add up to one any may be wrong.
        AffinePoint::new(terms).map_err(|_| none(start + 2))
    };
    let mut anchors = Vec::new();
    let mut place = 0;
    while place < numbers.len() {
        if numbers[place] == -1.0 {
            anchors.push(None);
            place += 1;
            continue;
        }
        let mut origin = None;
        if numbers[place] == -2.0 {
            let count = index(place + 1)? as usize;
            origin = Some(point(anchors.len(), place + 2, count)?);
            place += 2 + 3 * count;
        }
        let (count, slid) = match numbers.get(place) {
            Some(&number) if number.fract() == SLID => ((number - SLID) as usize, true),
            _ => (index(place)? as usize, false),
        };
        let difference = numbers.get(place + 1).copied().ok_or_else(|| none(place + 1))?;
        let point = point(anchors.len(), place + 2, count)?;
        let (opening, limit) = if difference < 0.0 { (0.0, -difference) } else { (difference, 0.0) };
        anchors.push(Some(Anchor { point, opening, limit, slid, origin }));
        place += 2 + 3 * count;
    }
    Ok(anchors)
}

/// The numbers of each slave in a [history](super::ContactInterface::history): one after another they are the history again. So histories go with
/// slaves from one interface to another.
///
/// # Errors
/// [`InterfaceError::InvalidHistory`].
pub fn split_history(history: &[f64]) -> Result<Vec<&[f64]>, InterfaceError> {
    let mut parts = Vec::new();
    let (mut rest, mut place) = (history, 0);
    // A count that is missing is none of a length.
    let terms = |count: Option<&f64>| 2.0 + 3.0 * count.copied().unwrap_or(f64::NAN);
    while let Some(&first) = rest.first() {
        let anchor = |start: usize| {
            let count =
                rest.get(start).map(|&count| if count.fract() == SLID { count - SLID } else { count });
            terms(count.as_ref())
        };
        let length = if first == -1.0 {
            1.0
        } else if first == -2.0 {
            let origin = terms(rest.get(1));
            origin + anchor(origin as usize)
        } else {
            anchor(0)
        };
        if !(length >= 1.0 && length <= rest.len() as f64 && length.fract() == 0.0) {
            return Err(InterfaceError::InvalidHistory { place });
        }
        let (own, after) = rest.split_at(length as usize);
        parts.push(own);
        (rest, place) = (after, place + own.len());
    }
    Ok(parts)
}

/// Checks anchors that were kept elsewhere.
pub fn check_anchors(
    anchors: &[Option<Anchor>],
    slaves: usize,
    surface: &MasterSurface,
    symmetry: &Symmetry,
) -> Result<(), InterfaceError> {
    if anchors.len() != slaves {
        return Err(InterfaceError::AnchorCount { found: anchors.len(), expected: slaves });
    }
    for (index, anchor) in anchors.iter().enumerate() {
        let Some(anchor) = anchor else { continue };
        anchor.check(index)?;
        for Carrier { node, image } in anchor.carriers() {
            let is_there = image.is_none_or(|number| number < symmetry.count());
            if !is_there || surface.nodes().binary_search(&node).is_err() {
                return Err(InterfaceError::ForeignCarrier { index, node });
            }
        }
    }
    Ok(())
}

/// Nodes that carry anchors of a slave and are not among its masters join them, without a sheet node: they take no part in its fit.
pub fn list_carriers<'a>(
    anchors: impl IntoIterator<Item = &'a Anchor>,
    masters: &mut Vec<u32>,
    sheet_nodes: &mut Vec<u32>,
    images: &mut [u32],
) {
    for Carrier { node, .. } in anchors.into_iter().flat_map(Anchor::carriers) {
        join(node, masters, sheet_nodes, images);
    }
}

/// Lists a node that is not listed, without a sheet node.
pub fn join(node: u32, masters: &mut Vec<u32>, sheet_nodes: &mut Vec<u32>, images: &mut [u32]) {
    if let Err(place) = masters.binary_search(&node) {
        masters.insert(place, node);
        sheet_nodes.insert(place, NONE);
        for [listed, _] in images.as_chunks_mut::<2>().0 {
            *listed += u32::from(*listed as usize >= place);
        }
    }
}

/// The same of a node-to-facet element: they follow the corners.
pub fn append_carriers<'a>(anchors: impl IntoIterator<Item = &'a Anchor>, masters: &mut Vec<u32>) {
    for Carrier { node, .. } in anchors.into_iter().flat_map(Anchor::carriers) {
        if !masters.contains(&node) {
            masters.push(node);
        }
    }
}

/// The carriers of an anchor among the nodes listed for its slave.
pub fn anchor_sources(paired: &Paired<'_>, anchor: &Anchor, sources: &mut Vec<AnchorSource>) {
    sources.clear();
    sources.extend(anchor.point.terms().iter().map(|&(Carrier { node, image }, weight)| {
        // With nodal domains they are in ascending order.
        let listed = if paired.sheet_nodes.is_empty() {
            paired.masters.iter().position(|&master| master == node)
        } else {
            paired.masters.binary_search(&node).ok()
        };
        // A refresh lists the carriers of all anchors, what is accepted has no others, and other anchors end the pairing.
        let listed = listed.unwrap_or_else(|| unreachable!("node {node} carries an anchor and is listed"));
        AnchorSource { listed: listed as u32, image, weight }
    }));
}
