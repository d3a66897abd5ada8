//! Attempts at a neighbourhood: whether a set of candidates carries the fit.

use super::candidates::{Candidates, Query, average_plane, in_plane};
use super::conditioning::{Moments, Regularity, regularity};
use super::hull::Point2;
use super::inversion::Site;
use super::{Fallback, Neighbourhood, NeighbourhoodError, SearchOptions};
use crate::{Basis, Frame, Point};

/// A regular set may yet be stretched so far across the axes of its frame that the factorisation loses its digits:
/// the relative pivots of A have to exceed this, ten times what a [`Backend`](crate::Backend) tolerates.
const SMALLEST_PIVOT: f64 = 1e-6;

/// What the layers taken so far say.
pub struct Layers {
    pub at_slave: Vec<usize>,
    pub layers: Vec<Vec<usize>>,
    pub site: Site,
    pub complete: bool,
}

/// A set of candidates that may become a neighbourhood.
pub struct Local<'a> {
    /// Which candidates.
    pub nodes: &'a [usize],
    /// The support radius, where it does not follow from the nodes.
    pub given_radius: Option<f64>,
    /// The plane of the candidates.
    pub plane: Frame,
    /// Of those that count.
    pub regularity: Regularity,
    /// More than were asked for, in layers or nodes.
    pub extended: usize,
}

/// The sets tried so far.
pub struct Attempts<'a> {
    options: &'a SearchOptions,
    candidates: &'a Candidates,
    /// The first that carries the linear basis, if that may stand in.
    linear: Option<Neighbourhood>,
    /// Size of the largest.
    pub largest: usize,
    /// The best regularity.
    best: Regularity,
}

impl<'a> Attempts<'a> {
    pub fn new(options: &'a SearchOptions, candidates: &'a Candidates) -> Self {
        Self { options, candidates, linear: None, largest: 0, best: Regularity::default() }
    }

    /// The neighbourhood if these nodes carry the basis asked for. If they only carry the linear basis, and it may
    /// stand in, it is kept.
    pub fn attempt<F>(
        &mut self,
        query: &Query<'_, F>,
        so_far: &Layers,
        local: &Local<'_>,
    ) -> Option<Neighbourhood> {
        let &Local { regularity, extended, .. } = local;
        self.largest = self.largest.max(local.nodes.len());
        self.best = self.best.max(regularity);
        let enough = |basis: Basis| {
            local.nodes.len() >= basis.size() && regularity.of(basis) > self.options.smallest_regularity
        };
        let basis = self.options.basis;
        if enough(basis)
            && let Some(mut found) = self.finish(query, so_far, local, basis)
        {
            if extended > 0 {
                found.fallback = Fallback::Extended { by: extended };
            }
            return Some(found);
        }
        if basis != Basis::Linear
            && self.options.linear_fallback
            && self.linear.is_none()
            && enough(Basis::Linear)
        {
            self.linear = self.finish(query, so_far, local, Basis::Linear);
        }
        None
    }

    /// The neighbourhood in the frame of its own nodes, if they carry the fit there too.
    fn finish<F>(
        &self,
        query: &Query<'_, F>,
        so_far: &Layers,
        local: &Local<'_>,
        basis: Basis,
    ) -> Option<Neighbourhood> {
        let nodes: Vec<usize> = local.nodes.iter().map(|&k| self.candidates.nodes[k]).collect();
        let positions: Vec<Point> = local.nodes.iter().map(|&k| self.candidates.positions[k]).collect();
        let unconditional = self.options.smallest_regularity < 0.0;
        let frame = match average_plane(query, &nodes, &positions) {
            Ok(frame) => frame,
            Err(_) if unconditional => local.plane,
            Err(_) => return None,
        };
        let offsets: Vec<Point2> = positions.iter().map(|&x| in_plane(&frame, query.slave, x)).collect();
        let length = |k: usize| offsets[k][0].hypot(offsets[k][1]);
        let farthest = (0..nodes.len()).map(length).fold(0.0, f64::max);
        let support_radius = local.given_radius.unwrap_or(self.options.radius_factor * farthest);
        if !(support_radius > 0.0 && support_radius.is_finite()) {
            return None;
        }
        let regularity = regularity(offsets.iter().copied(), support_radius).of(basis);
        let moments = Moments::new(offsets.iter().copied(), support_radius);
        let pivot_ratio = moments.pivot_ratio(basis);
        if !(regularity > self.options.smallest_regularity && (unconditional || pivot_ratio > SMALLEST_PIVOT))
        {
            return None;
        }
        let mut order: Vec<usize> = (0..nodes.len()).collect();
        order.sort_unstable_by(|&i, &j| length(i).total_cmp(&length(j)).then(nodes[i].cmp(&nodes[j])));
        Some(Neighbourhood {
            at_slave: so_far.at_slave.clone(),
            layers: so_far.layers.clone(),
            nodes: order.into_iter().map(|k| nodes[k]).collect(),
            support_radius,
            basis,
            frame,
            plane: local.plane,
            regularity,
            condition: moments.condition(basis),
            pivot_ratio,
            encloses_slave: so_far.site == Site::Inside,
            on_border: so_far.site == Site::Border
                || (so_far.site == Site::Beyond && !so_far.at_slave.is_empty()),
            complete: so_far.complete,
            fallback: Fallback::None,
        })
    }

    /// The linear fallback, or why there is none.
    pub fn outcome(self) -> Result<Neighbourhood, NeighbourhoodError> {
        if let Some(found) = self.linear {
            let fallback = Fallback::Linear { quadratic_regularity: self.best.quadratic };
            return Ok(Neighbourhood { fallback, ..found });
        }
        let Self { options, .. } = self;
        let basis = if options.linear_fallback { Basis::Linear } else { options.basis };
        Err(NeighbourhoodError::IllConditioned {
            nodes: self.largest,
            basis,
            regularity: self.best.of(basis),
            wanted: options.smallest_regularity,
        })
    }
}
