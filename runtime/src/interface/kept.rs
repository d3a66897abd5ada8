//! What a refresh remembers of the one before, to be taken out and put back.

use super::contacts::Layout;
use super::evaluate::Evaluator;
use super::pairings::{Lists, Pairings, Record};
use super::{ContactElement, ContactInterface, InterfaceError, NoContact};
use crate::Basis;
use crate::neighbourhood::Fallback;

/// The pairing of one slave, as far as a refresh looks at it to decide whether to keep it
/// ([`InterfaceOptions::hysteresis`](super::InterfaceOptions::hysteresis)).
#[derive(Clone, Debug, PartialEq)]
pub struct KeptPairing {
    /// The masters, in the order of the slave's element.
    pub masters: Vec<u32>,
    /// The facet that was closest when the pairing was made.
    pub facet: u32,
    /// Natural coordinates of the closest point on it.
    pub natural: [f64; 2],
    /// Support radius R, length.
    pub support_radius: f64,
    /// Basis of the fit.
    pub basis: Basis,
    /// What the search had to give up.
    pub fallback: Fallback,
}

impl ContactInterface {
    /// The pairing of every slave, `None` without one and with nodal domains, which need none. With it and the same positions another interface of the same
    /// master, slaves and options pairs as this one would, bit for bit: see
    /// [`set_kept_pairings`](Self::set_kept_pairings).
    #[must_use]
    pub fn kept_pairings(&self) -> Vec<Option<KeptPairing>> {
        let kept = |k| {
            // With nodal domains nothing is kept: lists follow from positions.
            let paired = self.pairings.get(k).ok().filter(|_| self.nodal.is_none())?;
            let &Record { support_radius, basis, fallback, facet, natural, .. } = paired.record;
            Some(KeptPairing {
                masters: paired.masters.to_vec(),
                facet,
                natural,
                support_radius,
                basis,
                fallback,
            })
        };
        self.pairings.all().map(kept).collect()
    }

    /// Takes over pairings as [`kept_pairings`](Self::kept_pairings) gave them. They are what the next
    /// [`refresh_pairing`](Self::refresh_pairing) starts from, which has to come before the next evaluation.
    ///
    /// # Errors
    /// [`InterfaceError::WrongNumberOfPairings`], [`InterfaceError::ForeignPairing`]. The pairing of before then stays.
    pub fn set_kept_pairings(&mut self, kept: &[Option<KeptPairing>]) -> Result<(), InterfaceError> {
        let slaves = self.slaves();
        if kept.len() != slaves.len() {
            return Err(InterfaceError::WrongNumberOfPairings { found: kept.len(), expected: slaves.len() });
        }
        let foreign =
            kept.iter().zip(slaves).find(|(kept, _)| kept.as_ref().is_some_and(|kept| !self.fits(kept)));
        if let Some((_, &node)) = foreign {
            return Err(InterfaceError::ForeignPairing { node });
        }
        let record = |kept: &Option<KeptPairing>| {
            let kept = kept.as_ref().ok_or(NoContact::NotPaired)?;
            let &KeptPairing { facet, natural, support_radius, basis, fallback, .. } = kept;
            Ok(Record { support_radius, basis, fallback, facet, natural })
        };
        let masters_of =
            |kept: &Option<KeptPairing>| kept.as_ref().map_or(Vec::new(), |kept| kept.masters.clone());
        let lengths = kept.iter().map(|kept| kept.as_ref().map_or(0, |kept| kept.masters.len()));
        let layout = &self.pairings.layout;
        let masters = kept.iter().flat_map(masters_of).collect();
        let layout = Layout::new(layout.slaves().to_vec(), layout.areas().to_vec(), lengths, masters);
        let Self { master, options, positions, creases, .. } = &*self;
        let evaluator = Evaluator { surface: master, creases, positions, options, nodal: None };
        let frames = kept.iter().filter_map(|_| evaluator.stand_in_frame()).collect();
        let records = kept.iter().map(record).collect();
        self.listed = None;
        // The refresh asks anew where patches end. Until then there may be no edges to test.
        let patches = Lists::default();
        let images = Lists::default();
        self.pairings =
            Pairings { layout: layout.into(), records, frames, patches, places: Vec::new(), images };
        Ok(())
    }

    /// Whether a pairing can be one of this interface.
    fn fits(&self, kept: &KeptPairing) -> bool {
        let KeptPairing { masters, facet, natural, support_radius, basis, .. } = kept;
        let is_sound = natural.iter().all(|x| x.is_finite())
            && *support_radius > 0.0
            && support_radius.is_finite()
            && (*facet as usize) < self.master.facet_count();
        is_sound
            && match self.options.element {
                ContactElement::NodeToFacet => {
                    let corners = self.master.facet(*facet as usize);
                    corners.corners().iter().copied().eq(masters.iter().map(|&node| node as usize))
                }
                ContactElement::Diffuse { .. } => {
                    let known = |node: &u32| self.master.nodes().binary_search(node).is_ok();
                    // Hulls may hold more than a search of the nearest nodes returns.
                    masters.len() >= basis.size()
                        && masters.is_sorted_by(|one, next| one < next)
                        && masters.iter().all(known)
                }
            }
    }
}
