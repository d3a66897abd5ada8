//! Slaves and masters paired anew, and lists of nodes that follow the positions.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::create::check_count;
use super::evaluator::Evaluator;
use super::nodal::planes_of;
use super::pairings::Pairings;
use super::refresh::{Compares, Refresh, RefreshScratch, Refreshed};
use super::scratch::ElementScratch;
use super::window::Knowledge;
use super::{ContactElement, ContactInterface, InterfaceError, Listed, RefreshReport};
use crate::Point;
use crate::neighbourhood::SearchOptions;
use crate::pairing::NearestNodes;
use crate::surface::{Creases, check_position};
use crate::vector::squared_distance;

/// What following has lost since the last refresh.
#[derive(Clone, Debug, Default)]
pub(super) struct Lost {
    /// Which slaves were paired at the refresh; `None` before following has made lists anew.
    paired: Option<Vec<bool>>,
    /// Those of them that lost a contact, each with its smallest gap then.
    contacts: BTreeMap<u32, f64>,
}

impl Lost {
    /// Adds contacts that were lost. `paired`: at the refresh, if that is not known yet. What an iteration gained and lost again is nobody's loss.
    fn add(&mut self, paired: Option<Vec<bool>>, lost: Vec<(u32, f64)>) {
        let paired = self.paired.get_or_insert_with(|| paired.unwrap_or_default());
        for (k, gap) in
            lost.into_iter().filter(|&(k, _)| paired.get(k as usize).is_some_and(|paired| *paired))
        {
            let deepest = self.contacts.entry(k).or_insert(gap);
            *deepest = deepest.min(gap);
        }
    }
}

/// A report, and which slaves lost a contact, each with its gap by the old pairing.
type Booked = (RefreshReport, Vec<(u32, f64)>);

/// Which slaves are paired, and how.
struct Pairs<'a> {
    /// Whether lists follow within an increment.
    follows: bool,
    compares: Compares,
    /// The facet of each slave, where it is known.
    facets: Option<&'a [u32]>,
    /// How far each may still move with the list it has, where lists are kept.
    slacks: Option<Vec<f64>>,
}

impl ContactInterface {
    /// Takes over the positions and pairs every slave anew. With nodal domains the list of a slave stays while slave and masters
    /// together have moved by less than half its skin, and not so far that another sheet may be the closest one.
    ///
    /// With nodal domains every node of the slave's sheet is listed that may come within reach, and a refresh changes the gap
    /// only where another sheet has come to be the closest.
    ///
    /// By the other rules a slave is paired with the masters that the neighbour search finds among the nodes on its side of sharp
    /// edges: those reached from the closest facet over facets that meet in no edge sharper than the feature
    /// angle, that do not turn away from it by 89° or more, and that are no farther from the slave than the
    /// node itself. If they do not carry the quadratic basis the search takes more, then the linear basis; else
    /// there is no candidate.
    ///
    /// # Errors
    /// As [`update`](Self::update). Pairing and positions of before then stay.
    pub fn refresh_pairing(&mut self, positions: &[Point]) -> Result<RefreshReport, InterfaceError> {
        self.check_positions(positions)?;
        let slacks = self.slacks_at(positions);
        let report = match self.kept_lists(slacks.as_deref()) {
            Some(report) => {
                self.positions.copy_from_slice(positions);
                (report, Vec::new())
            }
            None => self.pair(positions, Pairs { slacks, ..self.anew() })?,
        };
        Ok(self.with_lost_before(report))
    }

    /// As [`refresh_pairing`](Self::refresh_pairing), but with nodal domains lists are made anew wherever everybody is: what they are then
    /// follows from these positions alone. A run that has to go on from a saved state as if it had never stopped calls it at the
    /// beginning of its increments.
    ///
    /// # Errors
    /// As [`update`](Self::update). Pairing and positions of before then stay.
    pub fn renew_pairing(&mut self, positions: &[Point]) -> Result<RefreshReport, InterfaceError> {
        self.check_positions(positions)?;
        let report = self.pair(positions, self.anew())?;
        Ok(self.with_lost_before(report))
    }

    /// As [`update`](Self::update), but with nodal domains the lists follow: where something has moved by more than half their skin, or
    /// so far that another sheet may be the closest one, they are made anew. A slave stays with its side of the surface.
    /// Returns whether they are others now: a pattern made for the old ones is no longer theirs. To be called in every iteration. Contacts
    /// that are lost with the old lists are in the report of the next refresh.
    ///
    /// # Errors
    /// As [`update`](Self::update).
    pub fn follow(&mut self, positions: &[Point]) -> Result<bool, InterfaceError> {
        self.check_positions(positions)?;
        let slacks = self.slacks_at(positions);
        if self.listed.is_none() || self.kept_lists(slacks.as_deref()).is_some() {
            self.positions.copy_from_slice(positions);
            return Ok(false);
        }
        let before = Arc::clone(&self.pairings.layout);
        let paired = match &self.lost.paired {
            Some(_) => None,
            None => Some((0..before.slaves().len()).map(|k| self.pairings.get(k).is_ok()).collect()),
        };
        let (_, lost) = self.pair(positions, Pairs { follows: true, slacks, ..self.anew() })?;
        self.lost.add(paired, lost);
        Ok(!Arc::ptr_eq(&before, &self.pairings.layout))
    }

    /// All slaves.
    const fn anew(&self) -> Pairs<'static> {
        let compares = if self.nodal.is_some() { Compares::OtherSheets } else { Compares::All };
        Pairs { follows: false, compares, facets: None, slacks: None }
    }

    /// Pairs slaves at positions that have been checked. Returns the report, and which slaves lost a contact, each with its gap by the old
    /// pairing.
    fn pair(&mut self, positions: &[Point], pairs: Pairs<'_>) -> Result<Booked, InterfaceError> {
        let Pairs { follows, compares, facets, slacks } = pairs;
        // Everything that may fail comes first; nothing of `self` changes before.
        let index = self.master.at(positions)?;
        let (search, cloud) = match self.options.element {
            ContactElement::Diffuse { search, .. } if self.nodal.is_none() => {
                (search, index.positions().to_vec())
            }
            _ => (SearchOptions::default(), Vec::new()),
        };
        let blank = RefreshScratch::new(search)?;
        let cloud = NearestNodes::new(cloud).map_err(InterfaceError::MasterNodes)?;
        let creases = match &self.nodal {
            Some(nodal) => nodal.creases.clone(),
            None => {
                let symmetry = planes_of(&index, &self.planes)?;
                Creases::new(&index, self.options.feature_angle_degrees.to_radians(), &symmetry)
            }
        };
        let evaluator = Evaluator { creases: &creases, positions, ..self.evaluator() };
        let refresh = Refresh {
            index: &index,
            cloud: &cloud,
            evaluator,
            old: &self.pairings,
            old_creases: &self.creases,
            compares,
            facets,
            follows,
            slacks: slacks.as_deref(),
            knowledge: self.known.as_ref().map(|known| Knowledge::new(known, positions)),
        };
        let Refreshed { mut pairings, report, lost } = refresh.run(&self.refreshes, &blank);
        if pairings.layout.is_same(&self.pairings.layout) {
            // Maps of entries know the lists by the number of their layout.
            pairings.layout = Arc::clone(&self.pairings.layout);
        }
        let report = RefreshReport { rebuilt: true, ..report };
        self.pairings = pairings;
        self.creases = creases;
        self.positions.copy_from_slice(positions);
        if self.nodal.is_some() {
            self.listed = Some(Listed { positions: positions.to_vec(), report: report.clone() });
        }
        Ok((report, lost))
    }

    /// The report of a refresh with the contacts that following has lost since the one before and that are not there again.
    fn with_lost_before(&mut self, (mut report, lost): Booked) -> RefreshReport {
        let mut before = std::mem::take(&mut self.lost).contacts;
        // These are in the report.
        for (k, _) in &lost {
            before.remove(k);
        }
        let evaluator = self.evaluator();
        let mut scratch = ElementScratch::default();
        for (k, gap) in before {
            let paired = self.pairings.get(k as usize);
            if !paired.is_ok_and(|paired| evaluator.gap(&paired, &mut scratch).is_ok()) {
                report.count_lost(self.pairings.layout.slave(k as usize), gap);
            }
        }
        report
    }

    /// Makes other points the slaves and pairs them: those that follow the nodes in `positions`, each over its facet. On an error points
    /// and pairing of before stay.
    pub(crate) fn pair_points(
        &mut self,
        positions: Vec<Point>,
        nodes: usize,
        facets: &[u32],
    ) -> Result<RefreshReport, InterfaceError> {
        check_count("positions", positions.len())?;
        self.master.check_positions(&positions)?;
        (nodes..positions.len()).try_for_each(|point| check_position(&positions, point))?;
        let blank = Pairings::none((nodes..positions.len()).collect(), Vec::new());
        let pairings = std::mem::replace(&mut self.pairings, blank);
        let before = std::mem::replace(&mut self.positions, positions.clone());
        let (listed, lost) = (self.listed.take(), std::mem::take(&mut self.lost));
        let pairs = Pairs { follows: false, compares: Compares::None, facets: Some(facets), slacks: None };
        match self.pair(&positions, pairs) {
            Ok((report, _)) => Ok(report),
            Err(error) => {
                (self.pairings, self.positions) = (pairings, before);
                (self.listed, self.lost) = (listed, lost);
                Err(error)
            }
        }
    }

    /// How far each slave and the masters together may still move before its list has to be made anew: it has to be where that is not
    /// positive. `None`: everywhere.
    fn slacks_at(&self, positions: &[Point]) -> Option<Vec<f64>> {
        let listed = self.listed.as_ref()?;
        if self.known.as_ref().is_some_and(|known| !known.holds_at(positions)) {
            return None;
        }
        let square = |node: usize| squared_distance(positions[node], listed.positions[node]);
        let masters =
            self.master.nodes().iter().map(|&node| square(node as usize)).fold(0.0, f64::max).sqrt();
        let Pairings { layout, slacks, .. } = &self.pairings;
        let moved = |k: usize| masters + square(layout.slave(k)).sqrt();
        Some((0..).zip(slacks).map(|(k, slack)| slack - moved(k)).collect())
    }

    /// The report of a refresh that leaves all lists of nodal domains as they are, as nobody has moved so far that another one is possible.
    fn kept_lists(&self, slacks: Option<&[f64]>) -> Option<RefreshReport> {
        let listed = self.listed.as_ref()?;
        slacks?.iter().all(|&slack| slack > 0.0).then(|| {
            let paired = listed.report.paired;
            let without = listed.report.without.clone();
            let (fallbacks, deep) = (listed.report.fallbacks, listed.report.deep);
            RefreshReport { paired, kept: paired, without, fallbacks, deep, ..RefreshReport::default() }
        })
    }
}
