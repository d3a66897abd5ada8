//! Friction over faces: tractions of the slave's nodes, as their pressures.
//!
//! ```text
//! x_A = ∫ N_A x dA / ∫ N_A dA        over the points of the faces around a node
//! y_A = ∫ N_A y dA / ∫ N_A dA        over the places of the facets where the lines along ∂g/∂x meet them
//! t_A = −c P_n d,   d = x_A − y_A    with the weights of the last accepted step, at the positions of today
//! ```
//!
//! x_A and y_A are affine combinations of nodes. Their weights, which follow from where the faces were cut, are the history: d is what the
//! nodes of both sides have moved since. It turns with the bodies. c is the factor of [`Coulomb`](crate::Coulomb), n the mean normal of the
//! node's points (docs/equations.md, section 18). Where points have pressures of their own, a node that carries one has p N_A in place of N_A.

use diffuse_contact_kernels::friction_over_pressure;
use rayon::prelude::*;

use super::block::place;
use super::contacts::NodeContact;
use super::evaluate::{Averages, PointStates};
use super::quadratic::Carrying;
use super::track::Track;
use super::window::Side;
use super::{FaceInterface, FacePressures};
use crate::affine::Carrier;
use crate::assembly::{AssemblyError, ContactLaw};
use crate::friction::{Coulomb, FaceTraction, FrictionState, Sliding};
use crate::interface::{
    Anchor, FrictionReport, InterfaceError, NoContact, Outcome, Results, from_numbers, to_numbers,
};
use crate::surface::{shape_of, sort};
use crate::vector::Vector3;
use crate::{AffinePoint, Mode, Point};

/// What a point without pressure counts for in the slip of a node that carries one, over the node's pressure.
const LITTLE: f64 = 1e-12;

/// The friction of a node and its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Traction {
    /// t_A, force per area.
    pub value: Point,
    /// By d, rows by component of the traction.
    pub by_way: [Point; 3],
    /// By the mean normal.
    pub by_normal: [Point; 3],
    /// By the pressure.
    pub by_pressure: Point,
    /// P_n d, length.
    slip: Vector3,
    sliding: Sliding,
}

impl Traction {
    /// τ = t/p by the same and by the pressure: what points of their own pressure have of it.
    pub fn over(&self, pressure: f64) -> Self {
        let inputs = friction_over_pressure::Inputs { traction: self.value, pressure };
        let found = friction_over_pressure::evaluate(Mode::Gradient, &inputs);
        // By the traction, then by the pressure: a row of four for each component.
        let row = |i: usize| &found.ratio_jacobian[4 * i..][..4];
        let by_traction =
            |i: usize, of: &dyn Fn(usize) -> f64| (0..3).map(|j| row(i)[j] * of(j)).sum::<f64>();
        let by = |all: &[Point; 3]| -> [Point; 3] {
            [0, 1, 2].map(|i| [0, 1, 2].map(|k| by_traction(i, &|j| all[j][k])))
        };
        Self {
            value: found.values.ratio,
            by_way: by(&self.by_way),
            by_normal: by(&self.by_normal),
            by_pressure: [0, 1, 2].map(|i| by_traction(i, &|j| self.by_pressure[j]) + row(i)[3]),
            ..self.clone()
        }
    }
}

/// What the points of a face have of x_A and y_A of its corners.
struct FaceTrack {
    /// ∫ N_A dA
    totals: [f64; 4],
    /// Of x_A by the nodes of the cut's rows.
    own: [Vec<f64>; 4],
    /// Of y_A.
    over: [Vec<f64>; 4],
}

impl FaceInterface {
    /// The traction of each node that carries pressure and has a history; empty without friction. Notes them with the nodes. `normals`: of
    /// the nodes, of any length.
    ///
    /// # Errors
    /// [`AssemblyError::NoSlip`] if a node carries pressure before any state was accepted; [`AssemblyError::InvalidCoefficient`]
    /// or [`AssemblyError::InvalidSlip`] for a traction that is not finite.
    pub(super) fn tractions(
        &self,
        law: &ContactLaw<'_>,
        nodes: &mut [NodeContact],
        normals: &[Vector3],
    ) -> Result<Vec<Option<Traction>>, AssemblyError> {
        let Some(friction) = law.friction else { return Ok(Vec::new()) };
        let Some(tracks) = self.present_history() else {
            let loaded = nodes.iter().position(|node| node.pressure > 0.0);
            return loaded.map_or(Ok(Vec::new()), |element| Err(AssemblyError::NoSlip { element }));
        };
        let all = nodes.iter_mut().zip(normals).zip(tracks);
        let tractions = all.enumerate().map(|(k, ((node, &normal), track))| {
            let Some(track) = track.as_ref().filter(|_| node.pressure > 0.0) else { return Ok(None) };
            let found = self.traction(law, &friction, (k, node), normal, track)?;
            node.friction = found.value;
            node.friction_state = found.sliding.state;
            // What a multiplier is worth is no slip.
            let slip = if track.anchor.origin.is_some() {
                self.since_stuck(node, normal, track)
            } else {
                found.slip
            };
            node.slip = found.sliding.share * slip.norm();
            Ok(Some(found))
        });
        tractions.collect()
    }

    /// P_n of the way since the node stuck.
    fn since_stuck(&self, node: &NodeContact, normal: Vector3, track: &Track) -> Vector3 {
        let way = self.within_planes(node, track.way_since_stuck(&self.positions));
        let along = self.within_planes(node, normal).try_normalize().unwrap_or_default();
        way - along * along.dot(&way)
    }

    fn traction(
        &self,
        law: &ContactLaw<'_>,
        friction: &Coulomb<'_>,
        (element, node): (usize, &NodeContact),
        normal: Vector3,
        track: &Track,
    ) -> Result<Traction, AssemblyError> {
        // In a plane of symmetry, what the images of a node's faces have beyond it takes away what points out of it.
        let within = |x| self.within_planes(node, x);
        let (way, normal) = (within(track.way(&self.positions)), within(normal));
        let opening = track.anchor.opening;
        let FaceTraction { slip, traction, jacobian, sliding } =
            friction.traction((way.into(), normal.into()), node.pressure, law.penalty * opening);
        let slip = Vector3::from(slip);
        let numbers = traction.iter().chain(&jacobian);
        if !numbers.chain([&sliding.kept]).all(|x| x.is_finite()) {
            let touched = (node.pressure, sliding.share);
            let slip = (0.5 * slip.norm_squared(), opening);
            return Err(ContactLaw::invalid_friction(friction, element, touched, slip));
        }
        let row = |i: usize, first: usize| -> Point {
            let row = &jacobian[7 * i..][..7];
            let by = |axis: usize| {
                let unit = within(Vector3::axis(axis));
                (0..3).map(|j| row[first + j] * unit[j]).sum()
            };
            [0, 1, 2].map(by)
        };
        Ok(Traction {
            value: traction,
            by_way: [0, 1, 2].map(|i| row(i, 0)),
            by_normal: [0, 1, 2].map(|i| row(i, 3)),
            by_pressure: [0, 1, 2].map(|i| jacobian[7 * i + 6]),
            slip,
            sliding,
        })
    }

    /// Accepts the state at the positions of the moment as the end of a step: friction of the next one is measured from here.
    ///
    /// To be called as [`ContactInterface::accept`](crate::ContactInterface::accept): once before the first step, after a refresh, and
    /// whenever a step has converged. Nodes that carry pressure without a history, as they had nothing over them when the step before was
    /// accepted, are counted as unanchored. A node whose result is not known, [`NoContact::BeyondWindow`], keeps what it had.
    ///
    /// # Errors
    /// [`InterfaceError::Law`], [`InterfaceError::NotRefreshed`], [`InterfaceError::OutOfMemory`]. The history then stays.
    pub fn accept(&mut self, law: &ContactLaw<'_>) -> Result<FrictionReport, InterfaceError> {
        if law.friction.is_none() && self.tracks.is_none() {
            return Ok(FrictionReport::default());
        }
        self.check_law(law)?;
        let history = self.present_history();
        let Averages { mut nodes, normals, points, .. } = self.averages(law, true)?;
        let present = self.present_tracks(&nodes, &points)?;
        let mut report = FrictionReport::default();
        let mut tracks = Vec::with_capacity(nodes.len());
        for (k, (node, present)) in nodes.iter_mut().zip(present).enumerate() {
            let old = history.and_then(|tracks| tracks[k].as_ref());
            let committed = self.tracks.as_ref().and_then(|tracks| tracks[k].as_ref());
            if let Outcome::None(NoContact::BeyondWindow { .. }) = node.outcome {
                tracks.push(committed.cloned());
                continue;
            }
            let Some(present) = present.filter(|_| node.outcome.is_contact()) else {
                report.dropped += usize::from(committed.is_some_and(|old| old.anchor.opening == 0.0));
                tracks.push(None);
                continue;
            };
            let closed = old.filter(|_| node.pressure > 0.0);
            let traction = match (&law.friction, closed) {
                (Some(friction), Some(old)) => {
                    Some(self.traction(law, friction, (k, node), normals[k], old)?)
                }
                _ => None,
            };
            self.count(&mut report, (node, normals[k]), old, traction.as_ref());
            tracks.push(Some(self.next_track(
                law,
                (k, node, normals[k]),
                (closed, present),
                traction.as_ref(),
            )?));
        }
        self.tracks = Some(tracks);
        self.augmented = None;
        Ok(if law.friction.is_some() { report } else { FrictionReport::default() })
    }

    /// Adds what a node in contact did in the step to a report. `old`: its history before; `traction`: its friction if it was closed and is.
    fn count(
        &self,
        report: &mut FrictionReport,
        (node, normal): (&NodeContact, Vector3),
        old: Option<&Track>,
        traction: Option<&Traction>,
    ) {
        let is_open = !(node.pressure > 0.0);
        let Some(old) = old else {
            report.unanchored += usize::from(!is_open);
            return;
        };
        let before = old.anchor.before_step();
        let work = match traction {
            Some(Traction { sliding, slip, .. }) => {
                report.stuck += usize::from(sliding.state == FrictionState::Stick);
                report.sliding += usize::from(sliding.state == FrictionState::Slip);
                sliding.dissipated(slip.norm(), before)
            }
            None if is_open => Sliding::OPEN.dissipated(self.since_stuck(node, normal, old).norm(), before),
            None => 0.0,
        };
        report.dissipated += node.area * work;
    }

    /// The history of a node in contact from now on. `closed`: that of before if the node carries pressure; `present`: one that begins
    /// here.
    fn next_track(
        &self,
        law: &ContactLaw<'_>,
        (k, node, normal): (usize, &NodeContact, Vector3),
        (closed, present): (Option<&Track>, Track),
        traction: Option<&Traction>,
    ) -> Result<Track, InterfaceError> {
        let is_augmented = law.friction.is_some_and(|friction| friction.is_augmented());
        let sliding = traction.filter(|of| of.sliding.state == FrictionState::Slip);
        let limit = match sliding {
            Some(of) => Vector3::from(of.value).norm(),
            None => law.friction.as_ref().map_or(0.0, |friction| friction.limit(node.pressure)),
        };
        let (kept, slip) = traction.map_or((0.0, Vector3::zeros()), |of| (of.sliding.kept, of.slip));
        if let Some(old) = closed.filter(|_| kept == 1.0) {
            // It has not moved.
            let origin = old.anchor.origin.clone().filter(|_| is_augmented);
            let track = old.clone().with_opening(0.0).with_origin(origin);
            return Ok(track.with_limit(limit, sliding.is_some()));
        }
        let drawn = closed.map_or(present.clone(), |old| old.towards(&present, 1.0 - kept));
        // Of what touches first.
        let gap = match self.options.pressures {
            FacePressures::Nodes => node.gap,
            FacePressures::Points => node.smallest_gap,
        };
        let opening = if node.pressure > 0.0 { 0.0 } else { law.opening(k, gap)? };
        // Where it sticks from now on: without any slip.
        let stuck = || drawn.clone().with_slip(Vector3::zeros(), normal, &self.positions);
        let origin = (sliding.is_some() && is_augmented).then(|| stuck().anchor.point);
        let drawn = drawn.with_slip(slip * kept, normal, &self.positions);
        Ok(drawn.with_opening(opening).with_limit(limit, sliding.is_some()).with_origin(origin))
    }

    /// The history that friction is measured from: that of the last accepted step, or what augmentation made of it.
    pub(super) fn present_history(&self) -> Option<&[Option<Track>]> {
        self.augmented.as_deref().or(self.tracks.as_deref())
    }

    /// What planes of symmetry leave of a vector of a node.
    fn within_planes(&self, node: &NodeContact, x: Vector3) -> Vector3 {
        self.skin.within_planes(self.first[node.slave], x)
    }

    /// A round of Uzawa's iteration for friction, as [`ContactInterface::augment`](crate::ContactInterface::augment): tractions become
    /// multipliers. Nodes of which `moves` says no stay as they are.
    ///
    /// # Errors
    /// As [`accept`](Self::accept); [`AssemblyError::NoAugmentation`] for friction without
    /// [augmentation](crate::Coulomb::with_augmentation). Nothing is changed then.
    pub fn augment(
        &mut self,
        law: &ContactLaw<'_>,
        moves: impl Fn(usize) -> bool,
    ) -> Result<(), InterfaceError> {
        let (tracks, _) = self.augmented(law, moves)?;
        if let Some(tracks) = tracks {
            self.augmented = Some(tracks);
        }
        Ok(())
    }

    /// How far each node is from Coulomb's law without ε_T, length, as
    /// [`ContactInterface::slip_errors`](crate::ContactInterface::slip_errors).
    ///
    /// # Errors
    /// As [`augment`](Self::augment).
    pub fn slip_errors(&self, law: &ContactLaw<'_>) -> Result<Vec<f64>, InterfaceError> {
        self.augmented(law, |_| true).map(|(_, errors)| errors)
    }

    /// Forgets what [`augment`](Self::augment) did since the last accepted step. If that is anything, there is no contact until the next
    /// [`refresh`](Self::refresh).
    pub fn roll_back(&mut self) {
        if self.augmented.take().is_some() {
            self.forget();
        }
    }

    #[allow(clippy::type_complexity)]
    fn augmented(
        &self,
        law: &ContactLaw<'_>,
        moves: impl Fn(usize) -> bool,
    ) -> Result<(Option<Vec<Option<Track>>>, Vec<f64>), InterfaceError> {
        let Some(friction) = law.friction else {
            law.validate(self.slaves().len())?;
            return Ok((None, vec![0.0; self.slaves().len()]));
        };
        if !friction.is_augmented() {
            return Err(AssemblyError::NoAugmentation.into());
        }
        self.check_law(law)?;
        let Averages { nodes, normals, .. } = self.averages(law, true)?;
        let mut errors = vec![0.0; nodes.len()];
        let (Some(committed), Some(present)) = (&self.tracks, self.present_history()) else {
            return Ok((None, errors));
        };
        let mut tracks = committed.clone();
        for (k, node) in nodes.iter().enumerate().filter(|(_, node)| node.pressure > 0.0) {
            let Some(old) = &present[k] else { continue };
            if !moves(k) {
                tracks[k] = Some(old.clone());
                continue;
            }
            let Traction { slip, sliding, .. } = self.traction(law, &friction, (k, node), normals[k], old)?;
            let stuck = old.clone().at_origin();
            let since_stuck = self.since_stuck(node, normals[k], old);
            errors[k] = sliding.error(slip, since_stuck);
            let slid = since_stuck * sliding.share;
            let with_slip = |track: Track, slip: Vector3| track.with_slip(slip, normals[k], &self.positions);
            // From the place of touch on the contact is one that was closed.
            let stuck = if sliding.share == 1.0 { stuck } else { with_slip(stuck, slid) };
            let origin = Some(stuck.anchor.point.clone());
            let next = with_slip(stuck, slid + slip * sliding.kept);
            tracks[k] = Some(next.with_opening(0.0).with_origin(origin));
        }
        Ok((Some(tracks), errors))
    }

    /// x_A and y_A of all nodes, as the faces are cut now. Where points have pressures, they count by these for a node that carries one:
    /// what slides is what touches, and tractions work on the mean slip of what they act on.
    fn present_tracks(
        &self,
        nodes: &[NodeContact],
        points: &PointStates,
    ) -> Result<Vec<Option<Track>>, InterfaceError> {
        let cut: Vec<usize> = (0..self.faces.len()).filter(|&k| !self.cuts[k].points.is_empty()).collect();
        let tracks: Vec<Vec<FaceTrack>> = self
            .runs(&cut)
            .into_par_iter()
            .map_init(Results::default, |results, faces| self.face_tracks(faces, (nodes, points), results))
            .collect::<Result<_, _>>()?;
        let mut of_face: Vec<Option<FaceTrack>> = (0..self.faces.len()).map(|_| None).collect();
        cut.into_iter().zip(tracks.into_iter().flatten()).for_each(|(k, track)| of_face[k] = Some(track));
        let around = self.slaves().par_iter().zip(&self.slaves.around);
        Ok(around.map(|(&node, around)| self.track_of(node, around, &of_face)).collect())
    }

    /// The sums of consecutive faces.
    fn face_tracks(
        &self,
        faces: &[usize],
        (nodes, points): (&[NodeContact], &PointStates),
        results: &mut Results,
    ) -> Result<Vec<FaceTrack>, InterfaceError> {
        let blank = |&k: &usize| {
            let of_corners = || std::array::from_fn(|_| vec![0.0; self.cuts[k].rows.len()]);
            FaceTrack { totals: [0.0; 4], own: of_corners(), over: of_corners() }
        };
        let mut tracks: Vec<FaceTrack> = faces.iter().map(blank).collect();
        let pressure_of = |place: usize| Some(nodes[place].pressure).filter(|&pressure| pressure > 0.0);
        let of_corners = |&face: &usize| self.places_of(face).map(pressure_of).collect();
        let pressed: Vec<Vec<Option<f64>>> = faces.iter().map(of_corners).collect();
        self.for_each_contact_of(faces, Mode::Gradient, results, |k, point, contact| {
            let face = faces[k];
            let own: &Carrying = &self.carriers.faces[face];
            let over: &Carrying = &self.carriers.facets[point.facet as usize];
            let x = own.point(&point.functions, &self.positions);
            let [a, b, c, ..] = *contact.gradient else { return };
            let Some(along) = Vector3::from([a, b, c]).try_normalize() else { return };
            let Some(carried) = over.carried(&self.positions, x, along.into(), Mode::Value) else { return };
            let place = |node: usize| place(&self.cuts[face].rows, node as u32);
            let functions = shape_of(&self.faces[face], &self.positions).functions(point.natural);
            let pressure = points.pressures.get(contact.slave - self.positions.len()).map(|own| own.force);
            for (corner, n) in functions.into_iter().enumerate().take(self.faces[face].corners().len()) {
                // Those that are not pressed count if no other has a place.
                let share = match (pressure, pressed[k][corner]) {
                    (Some(own), Some(of_node)) => own.max(LITTLE * of_node),
                    _ => 1.0,
                };
                let weight = point.weight * n * share;
                tracks[k].totals[corner] += weight;
                for (&node, part) in own.nodes().iter().zip(point.functions) {
                    tracks[k].own[corner][place(node)] += weight * part;
                }
                for (&node, &force) in over.nodes().iter().zip(&carried.forces[1..]) {
                    tracks[k].over[corner][place(node)] += weight * Vector3::from(force).dot(&along);
                }
            }
        })?;
        Ok(tracks)
    }

    /// The sums of the faces around a node; `None` if nothing lies over them.
    fn track_of(&self, node: usize, around: &[u32], of_face: &[Option<FaceTrack>]) -> Option<Track> {
        let (mut total, mut own, mut over) = (0.0, Vec::new(), Vec::new());
        for &face in around {
            let Some(track) = &of_face[face as usize] else { continue };
            let Some(corner) = self.faces[face as usize].corners().iter().position(|&own| own == node) else {
                continue;
            };
            let rows = &self.cuts[face as usize].rows;
            let terms = |weights: &[f64]| -> Vec<(u32, f64)> {
                rows.iter().copied().zip(weights.iter().copied()).filter(|term| term.1 != 0.0).collect()
            };
            total += track.totals[corner];
            own.extend(terms(&track.own[corner]));
            over.extend(terms(&track.over[corner]));
        }
        let point = |terms: Vec<(u32, f64)>| {
            AffinePoint::new(terms.into_iter().map(|(node, weight)| (node, weight / total))).ok()
        };
        Some(Track { own: point(own)?, anchor: Anchor::new(point(over)?) })
    }

    /// Whether a state was [accepted](Self::accept) since the history began.
    pub const fn has_history(&self) -> bool {
        self.tracks.is_some()
    }

    /// The history of friction as plain numbers, for a restart; empty before a state was [accepted](Self::accept). Each slave has two
    /// points, its own and its anchor. In [windows](crate::surface::window) their nodes have their numbers in the whole surfaces, too: two
    /// parts of [`split_history`](crate::interface::split_history) go with a slave from window to window.
    pub fn history(&self) -> Vec<f64> {
        self.numbers_of(self.tracks.as_deref())
    }

    /// The history that friction is measured from at the moment: [`history`](Self::history) with the rounds of [`augment`](Self::augment)
    /// since the last accepted step.
    pub fn augmented_history(&self) -> Vec<f64> {
        self.numbers_of(self.present_history())
    }

    fn numbers_of(&self, tracks: Option<&[Option<Track>]>) -> Vec<f64> {
        let point = |track: &Option<Track>| {
            let Some(Track { own, anchor }) = track else { return [None, None] };
            [Some(Anchor::new(own.clone())), Some(anchor.clone())]
        };
        tracks.map_or_else(Vec::new, |tracks| {
            to_numbers(&tracks.iter().flat_map(point).collect::<Vec<Option<Anchor>>>(), |node| {
                self.number_of(node)
            })
        })
    }

    /// Goes on from a [`history`](Self::history), bit for bit; no numbers are no history. If it is another one than the present, there is
    /// no contact until the next [`refresh`](Self::refresh). In windows nodes at which faces may be missing have no result, and no history.
    ///
    /// # Errors
    /// [`InterfaceError::InvalidHistory`]; [`InterfaceError::CarrierBeyondWindow`] for a node that is not in the windows;
    /// [`InterfaceError::AnchorCount`], [`InterfaceError::InvalidOpening`], [`InterfaceError::ForeignCarrier`]. The history of before then
    /// stays.
    pub fn set_history(&mut self, history: &[f64]) -> Result<(), InterfaceError> {
        let tracks = if history.is_empty() { None } else { Some(self.tracks_of(history)?) };
        if self.tracks != tracks || self.augmented.is_some() {
            self.forget();
            self.tracks = tracks;
        }
        Ok(())
    }

    /// Whether faces at the k-th slave may be missing: which of its node's sheets a history belongs to is not known then.
    fn is_beside(&self, k: usize) -> bool {
        self.window.as_ref().is_some_and(|window| window.is_beside(k))
    }

    fn tracks_of(&self, history: &[f64]) -> Result<Vec<Option<Track>>, InterfaceError> {
        let side = |point: usize| if point.is_multiple_of(2) { Side::Slave } else { Side::Master };
        let points = from_numbers(history, |point, number| match self.node_of(side(point), number) {
            // Any node stands for those of a history that is left out.
            None if self.is_beside(point / 2) => Ok(Some(0)),
            None if self.is_in_window() => {
                Err(InterfaceError::CarrierBeyondWindow { index: point / 2, node: number })
            }
            node => Ok(node),
        })?;
        let (pairs, rest) = points.as_chunks::<2>();
        if !rest.is_empty() {
            return Err(InterfaceError::InvalidHistory { place: history.len() });
        }
        let (found, expected) = (pairs.len(), self.slaves().len());
        if found != expected {
            return Err(InterfaceError::AnchorCount { found, expected });
        }
        let known = |carriers: &[Carrying]| {
            let mut nodes: Vec<u32> =
                carriers.iter().flat_map(|own| own.nodes()).map(|&node| node as u32).collect();
            sort(&mut nodes);
            nodes
        };
        let (of_faces, of_facets) = (known(&self.carriers.faces), known(&self.carriers.facets));
        let track = |(index, pair): (usize, &[Option<Anchor>; 2])| {
            if self.is_beside(index) {
                return Ok(None);
            }
            let (own, anchor) = match pair {
                [Some(own), Some(anchor)] => (own, anchor),
                [None, None] => return Ok(None),
                _ => {
                    let place = to_numbers(&points[..2 * index + 1], f64::from).len();
                    return Err(InterfaceError::InvalidHistory { place });
                }
            };
            if own.origin.is_some() || own.slid {
                let place = to_numbers(&points[..2 * index], f64::from).len();
                return Err(InterfaceError::InvalidHistory { place });
            }
            anchor.check(index)?;
            if let Some(&value) = [own.opening, own.limit].iter().find(|&&value| value != 0.0) {
                return Err(InterfaceError::InvalidOpening { index, value });
            }
            let origin = (anchor.stuck_at(), &of_facets);
            for (point, known) in [(&own.point, &of_faces), (&anchor.point, &of_facets), origin] {
                // In windows nodes beside the faces belong to histories of the rim, and have been looked for.
                let is_foreign = |(carrier, _): &&(Carrier, f64)| {
                    let is_known = self.is_in_window() || known.binary_search(&carrier.node).is_ok();
                    carrier.image.is_some() || !is_known
                };
                if let Some(&(Carrier { node, .. }, _)) = point.terms().iter().find(is_foreign) {
                    return Err(InterfaceError::ForeignCarrier { index, node });
                }
            }
            Ok(Some(Track { own: own.point.clone(), anchor: anchor.clone() }))
        };
        pairs.iter().enumerate().map(track).collect()
    }
}
