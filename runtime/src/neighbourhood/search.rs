//! The search itself: candidates, layers, and the fallbacks until a set of nodes carries the fit.

use super::attempts::{Attempts, Layers, Local};
use super::candidates::{Candidates, Projection, Query, average_plane, in_plane};
use super::conditioning::regularity;
use super::hull::Point2;
use super::inversion::{Peeler, Site};
use super::{Fallback, NeighbourRule, Neighbourhood, NeighbourhoodError, Outward, SearchOptions, TOLERANCE};
use crate::pairing::NearestNodes;
use crate::{Basis, Point};

/// More candidates are taken only while their heights differ by at most this fraction of their in-plane
/// distance (a spherical cap of 53° from its middle): beyond, the surface turns away from their average plane.
const FLAT: f64 = 0.5;
/// Fewer candidates are taken while their heights differ by more than this fraction (half a sphere).
const STEEP: f64 = 1.0;
/// Candidates below which a set that is steep, or carries no fit, is not reduced further.
const FEWEST_CANDIDATES: usize = 6;
/// Nodes whose middle principal moment is below this fraction of the largest are too narrow for a
/// plane, rather than too thick.
const NARROW: f64 = 1e-6;
/// A node that a given support radius takes in counts for regularity up to this fraction of the radius: one at the
/// rim has next to no weight, and a fit that needs it is gone as soon as the slave moves away from it.
const RIM: f64 = 0.9;

/// Searches neighbourhoods. One object serves any number of slaves and clouds and keeps its scratch
/// memory from one search to the next; threads take a clone each.
#[derive(Clone, Debug)]
pub struct NeighbourSearch {
    options: SearchOptions,
    candidates: Candidates,
    fewer: Candidates,
    offsets: Vec<Point2>,
    peeler: Peeler,
}

/// Two thirds.
const fn reduced(candidates: usize) -> usize {
    2 * candidates / 3
}

impl NeighbourSearch {
    /// A search with these options.
    ///
    /// # Errors
    /// [`NeighbourhoodError::InvalidOption`].
    pub fn new(options: SearchOptions) -> Result<Self, NeighbourhoodError> {
        options.check()?;
        if options.rule == NeighbourRule::Domains {
            return Err(NeighbourhoodError::NeedsSurface);
        }
        Ok(Self::unchecked(options))
    }

    fn unchecked(options: SearchOptions) -> Self {
        let (candidates, fewer) = (Candidates::default(), Candidates::default());
        Self { options, candidates, fewer, offsets: Vec::new(), peeler: Peeler::default() }
    }

    /// The options of this search.
    pub const fn options(&self) -> &SearchOptions {
        &self.options
    }

    /// The neighbours of `slave` among all nodes of the cloud.
    ///
    /// # Errors
    /// Every reason for which the slave has no neighbourhood, see [`NeighbourhoodError`].
    pub fn find<'a>(
        &mut self,
        nodes: &'a NearestNodes,
        slave: Point,
        outward: impl Into<Outward<'a>>,
    ) -> Result<Neighbourhood, NeighbourhoodError> {
        self.find_among(nodes, slave, outward, |_| true)
    }

    /// The neighbours of `slave` among the nodes for which `admits` holds, by their index in the cloud: a way to keep
    /// out the far face of a thin plate, or what lies around a sharp edge. If most of the nodes near the slave are
    /// not admitted, at most 16 times the number of candidates is looked at.
    ///
    /// # Errors
    /// Every reason for which the slave has no neighbourhood, see [`NeighbourhoodError`].
    pub fn find_among<'a>(
        &mut self,
        nodes: &'a NearestNodes,
        slave: Point,
        outward: impl Into<Outward<'a>>,
        admits: impl Fn(usize) -> bool,
    ) -> Result<Neighbourhood, NeighbourhoodError> {
        if !slave.iter().all(|x| x.is_finite()) {
            return Err(NeighbourhoodError::NonFiniteInput { what: "slave", index: 0 });
        }
        let query = Query { nodes, slave, outward: outward.into(), admits };
        query.outward.check(nodes.points().len())?;
        match self.options.rule {
            NeighbourRule::Domains => Err(NeighbourhoodError::NeedsSurface),
            NeighbourRule::Nearest { count, max_count } => self.nearest(&query, count, max_count),
            NeighbourRule::HullLayers { layers, max_layers }
            | NeighbourRule::HullRadius { layers, max_layers } => {
                let fewest = layers.unwrap_or(1);
                let mut found = self.by_hulls(&query, fewest, max_layers.max(fewest))?;
                if layers.is_none() && matches!(found.fallback, Fallback::Extended { .. }) {
                    found.fallback = Fallback::None;
                }
                Ok(found)
            }
        }
    }

    /// How many candidates there are: no fewer than an admitted fit needs.
    fn count_candidates(&self) -> Result<usize, NeighbourhoodError> {
        let basis = if self.options.linear_fallback { Basis::Linear } else { self.options.basis };
        let (found, needed) = (self.candidates.nodes.len(), basis.size());
        if found < needed { Err(NeighbourhoodError::NoCandidate { found, needed }) } else { Ok(found) }
    }

    /// Takes as many candidates as it needs to be sure of the layers.
    fn by_hulls<F: Fn(usize) -> bool>(
        &mut self,
        query: &Query<'_, F>,
        fewest: usize,
        most: usize,
    ) -> Result<Neighbourhood, NeighbourhoodError> {
        let mut wanted = self.options.candidates;
        let (mut projection, mut may_grow) = self.first_projection(query, &mut wanted)?;
        loop {
            may_grow &= wanted < self.options.max_candidates && !self.candidates.are_all();
            match self.by_layers(query, &projection, fewest, most, may_grow) {
                Some(Ok(found)) if found.basis == self.options.basis => return Ok(found),
                // A strip that bends may be wider across than along itself as seen in the plane of all candidates.
                Some(other) => {
                    let (basis, all) = (self.options.basis, self.candidates.nodes.len());
                    let fewer = self.by_fewer(query, all, fewest, most, |found| found.basis == basis);
                    return match (fewer, other) {
                        (Some(found), _) => Ok(found),
                        (None, Ok(lower)) => Ok(lower),
                        (None, Err(reason)) => {
                            self.by_fewer(query, all, fewest, most, |_| true).ok_or(reason)
                        }
                    };
                }
                None => {}
            }
            wanted = wanted.saturating_mul(2).min(self.options.max_candidates);
            std::mem::swap(&mut self.candidates, &mut self.fewer);
            self.candidates.gather(query, wanted);
            match Projection::new(query, &self.candidates, &mut self.offsets) {
                Ok(more) if more.steepness <= FLAT => projection = more,
                _ => {
                    std::mem::swap(&mut self.candidates, &mut self.fewer);
                    projection = Projection::new(query, &self.candidates, &mut self.offsets)?;
                    may_grow = false;
                }
            }
        }
    }

    /// What ever fewer candidates give that is good enough, if all together carry no fit of the basis asked for: on a narrow
    /// strip that bends, the plane of the near ones may still be one.
    fn by_fewer<F: Fn(usize) -> bool>(
        &mut self,
        query: &Query<'_, F>,
        all: usize,
        fewest: usize,
        most: usize,
        is_good: impl Fn(&Neighbourhood) -> bool,
    ) -> Option<Neighbourhood> {
        let mut fewer = reduced(all);
        while fewer >= FEWEST_CANDIDATES {
            self.candidates.gather(query, fewer);
            if let Ok(projection) = Projection::new(query, &self.candidates, &mut self.offsets)
                && let Some(Ok(found)) = self.by_layers(query, &projection, fewest, most, false)
                && is_good(&found)
            {
                return Some(found);
            }
            fewer = reduced(fewer);
        }
        None
    }

    /// The projection to start from, and whether more candidates may be of use: the number asked for, more if they
    /// lie on a line, fewer if they have no plane because the surface turns away under them.
    fn first_projection<F: Fn(usize) -> bool>(
        &mut self,
        query: &Query<'_, F>,
        wanted: &mut usize,
    ) -> Result<(Projection, bool), NeighbourhoodError> {
        self.candidates.gather(query, *wanted);
        self.count_candidates()?;
        let mut first = Projection::new(query, &self.candidates, &mut self.offsets);
        while let Err(NeighbourhoodError::NoAveragePlane { middle, .. }) = first
            && !(middle > NARROW)
            && *wanted < self.options.max_candidates
            && !self.candidates.are_all()
        {
            *wanted = wanted.saturating_mul(2).min(self.options.max_candidates);
            self.candidates.gather(query, *wanted);
            first = Projection::new(query, &self.candidates, &mut self.offsets);
        }
        let narrow =
            matches!(first, Err(NeighbourhoodError::NoAveragePlane { middle, .. }) if !(middle > NARROW));
        if narrow || first.as_ref().is_ok_and(|projection| projection.steepness <= STEEP) {
            return first.map(|projection| (projection, true));
        }
        let mut fewer = reduced(self.candidates.nodes.len());
        while fewer >= FEWEST_CANDIDATES {
            self.candidates.gather(query, fewer);
            match Projection::new(query, &self.candidates, &mut self.offsets) {
                Ok(projection) if projection.steepness <= STEEP => return Ok((projection, false)),
                _ => fewer = reduced(fewer),
            }
        }
        self.candidates.gather(query, *wanted);
        Projection::new(query, &self.candidates, &mut self.offsets).map(|projection| (projection, false))
    }

    /// Those that lie on the slave, and what they say; all others are to be peeled.
    fn start_layers(&mut self) -> (Vec<usize>, Layers) {
        let on_slave = |[a, b]: Point2| a.hypot(b) <= TOLERANCE;
        let offsets = self.offsets.iter().copied().enumerate();
        self.peeler.start(offsets.filter(|&(_, x)| !on_slave(x)));
        let members: Vec<usize> = (0..self.offsets.len()).filter(|&k| on_slave(self.offsets[k])).collect();
        let at_slave = self.candidates.sorted_nodes(&members);
        (members, Layers { at_slave, layers: Vec::new(), site: Site::Beyond, complete: true })
    }

    /// Takes layers off the candidates until they carry the fit; `None` if it takes more candidates to tell.
    fn by_layers<F>(
        &mut self,
        query: &Query<'_, F>,
        projection: &Projection,
        fewest: usize,
        most: usize,
        may_grow: bool,
    ) -> Option<Result<Neighbourhood, NeighbourhoodError>> {
        let (mut members, mut so_far) = self.start_layers();
        let mut attempts = Attempts::new(&self.options, &self.candidates);
        while so_far.layers.len() < most && !self.peeler.is_empty() {
            let before = members.len();
            let ring = self.peeler.peel(&mut members);
            so_far.complete &= ring.diameter <= projection.reach;
            if so_far.layers.is_empty() {
                so_far.site = Site::of(ring.free_angle);
            }
            so_far.layers.push(self.candidates.sorted_nodes(&members[before..]));
            if so_far.layers.len() < fewest && !self.peeler.is_empty() {
                continue;
            }
            let length = |k: &usize| self.offsets[*k][0].hypot(self.offsets[*k][1]);
            let farthest = members.iter().map(length).fold(0.0, f64::max);
            let radius = self.options.radius_factor * farthest;
            let inside: Vec<usize>;
            let (taking_part, given_radius) = match self.options.rule {
                NeighbourRule::HullRadius { .. } => {
                    so_far.complete &= radius <= projection.reach;
                    inside = (0..self.offsets.len()).filter(|k| length(k) < radius).collect();
                    (&inside, Some(radius * projection.scale))
                }
                _ => (&members, None),
            };
            if !so_far.complete && may_grow {
                return None;
            }
            // All members count.
            let rim = farthest.max(RIM * radius);
            let counted = taking_part.iter().filter(|k| length(k) <= rim);
            let regularity = regularity(counted.map(|&k| self.offsets[k]), radius);
            let extended = so_far.layers.len().saturating_sub(fewest);
            let local =
                Local { nodes: taking_part, given_radius, plane: projection.plane, regularity, extended };
            if let Some(found) = attempts.attempt(query, &so_far, &local) {
                return Some(Ok(found));
            }
        }
        if may_grow && so_far.layers.len() < most {
            return None;
        }
        Some(attempts.outcome())
    }

    /// The nearest nodes, one more at a time.
    fn nearest<F: Fn(usize) -> bool>(
        &mut self,
        query: &Query<'_, F>,
        count: usize,
        max_count: usize,
    ) -> Result<Neighbourhood, NeighbourhoodError> {
        let fewest = count.max(self.options.basis.size());
        self.candidates.gather(query, max_count.max(fewest));
        self.candidates.nodes.truncate(max_count.max(fewest));
        let found = self.count_candidates()?;
        let mut attempts = Attempts::new(&self.options, &self.candidates);
        let mut reason = None;
        for taken in fewest.min(found)..=found {
            let (nodes, positions) = (&self.candidates.nodes[..taken], &self.candidates.positions[..taken]);
            let plane = match average_plane(query, nodes, positions) {
                Ok(plane) => plane,
                Err(error) => {
                    reason = Some(error);
                    continue;
                }
            };
            self.offsets.clear();
            self.offsets.extend(positions.iter().map(|&x| in_plane(&plane, query.slave, x)));
            let farthest = self.offsets.iter().map(|[a, b]| a.hypot(*b)).fold(0.0, f64::max);
            let on_slave = |k: &usize| self.offsets[*k][0].hypot(self.offsets[*k][1]) <= TOLERANCE * farthest;
            let (at_slave, layer): (Vec<usize>, Vec<usize>) = (0..taken).partition(on_slave);
            // Only directions matter here, so that the inversion can be left out.
            self.peeler.start(layer.iter().map(|&k| (k, self.offsets[k].map(|x| x / farthest))));
            let so_far = Layers {
                site: Site::of(self.peeler.largest_free_angle()),
                at_slave: self.candidates.sorted_nodes(&at_slave),
                layers: vec![self.candidates.sorted_nodes(&layer)],
                complete: true,
            };
            let radius = self.options.radius_factor * farthest;
            let regularity = regularity(self.offsets.iter().copied(), radius);
            let everyone: Vec<usize> = (0..taken).collect();
            let extended = taken.saturating_sub(fewest);
            let local = Local { nodes: &everyone, given_radius: None, plane, regularity, extended };
            if let Some(found) = attempts.attempt(query, &so_far, &local) {
                return Ok(found);
            }
        }
        match reason {
            Some(reason) if attempts.largest == 0 => Err(reason),
            _ => attempts.outcome(),
        }
    }
}

/// Exactly `layers` hull layers around a slave, however well or badly they carry a fit: what the command-line
/// program's `neighbours` prints.
///
/// The basis of the condition number is the quadratic one if there are six nodes, else the linear one. Fewer layers
/// if the nodes run out.
///
/// ```
/// use diffuse_contact::neighbourhood::hull_layers;
///
/// let grid: Vec<[f64; 3]> = (0..49).map(|k| [f64::from(k % 7), f64::from(k / 7), 0.0]).collect();
/// let found = hull_layers([3.5, 3.5, 0.1], &grid, [0.0, 0.0, 1.0], 2)?;
/// assert_eq!(found.layers[0], [24, 25, 31, 32]);
/// assert_eq!(found.layers[1], [17, 18, 23, 26, 30, 33, 38, 39]);
/// # Ok::<(), diffuse_contact::neighbourhood::NeighbourhoodError>(())
/// ```
///
/// # Errors
/// [`NeighbourhoodError::NonFiniteInput`], [`NeighbourhoodError::InvalidOption`] for no layers,
/// [`NeighbourhoodError::NoCandidate`] for fewer than three nodes, and every reason for which the nearest nodes have
/// no average plane.
pub fn hull_layers(
    slave: Point,
    masters: &[Point],
    outward: Point,
    layers: usize,
) -> Result<Neighbourhood, NeighbourhoodError> {
    let rule = NeighbourRule::HullLayers { layers: Some(layers), max_layers: layers };
    let options = SearchOptions::default().with_rule(rule);
    options.check()?;
    let nodes = NearestNodes::new(masters.to_vec()).map_err(|error| NeighbourhoodError::of_nodes(&error))?;
    // Everything is more regular than this.
    let unconditional = SearchOptions { smallest_regularity: f64::NEG_INFINITY, ..options };
    NeighbourSearch::unchecked(unconditional).find(&nodes, slave, outward)
}
