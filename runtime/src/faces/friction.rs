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
//! node's points (docs/equations.md, section 18).

use diffuse_contact_kernels::traction;

use super::contacts::NodeContact;
use super::quadratic::Carrying;
use super::{FaceInterface, sort};
use crate::assembly::{AssemblyError, ContactLaw};
use crate::friction::{Coulomb, FrictionForce, FrictionState, NormalForce};
use crate::interface::{Anchor, FrictionReport, InterfaceError, from_numbers, to_numbers};
use crate::vector::Vector3;
use crate::{AffinePoint, Mode, Point};

/// Carriers of an anchor on a line, to this part of their spread, do not tell how to move it across.
const ON_A_LINE: f64 = 1e-10;

/// The history of one node.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Track {
    /// x_A of the last accepted step.
    own: AffinePoint,
    /// y_A of then, and the gap if it was open.
    anchor: Anchor,
}

impl Track {
    /// Nodes of both combinations with what they have of d.
    pub fn terms(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        let own = self.own.terms().iter().map(|&(carrier, weight)| (carrier.node, weight));
        own.chain(self.anchor.point.terms().iter().map(|&(carrier, weight)| (carrier.node, -weight)))
    }

    /// d
    fn way(&self, positions: &[Point]) -> Vector3 {
        let at = |point: &AffinePoint| point.position(|carrier| positions[carrier.node as usize]);
        Vector3::from(at(&self.own)) - Vector3::from(at(&self.anchor.point))
    }
}

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
    force: FrictionForce,
}

impl FaceInterface {
    /// The traction of each node that carries pressure and has a history; empty without friction. Notes them with the nodes. `normals`: of
    /// the nodes, of any length.
    ///
    /// # Errors
    /// [`AssemblyError::NoSlip`] if a node carries pressure before any state was accepted.
    pub(super) fn tractions(
        &self,
        law: &ContactLaw<'_>,
        nodes: &mut [NodeContact],
        normals: &[Vector3],
    ) -> Result<Vec<Option<Traction>>, AssemblyError> {
        let Some(friction) = law.friction else { return Ok(Vec::new()) };
        let Some(tracks) = &self.tracks else {
            let loaded = nodes.iter().position(|node| node.pressure > 0.0);
            return loaded.map_or(Ok(Vec::new()), |element| Err(AssemblyError::NoSlip { element }));
        };
        let all = nodes.iter_mut().zip(normals).zip(tracks);
        let tractions = all.map(|((node, &normal), track)| {
            let track = track.as_ref().filter(|_| node.pressure > 0.0)?;
            let found = self.traction(law, &friction, node, normal, track);
            node.friction = found.value;
            node.friction_state = found.force.state;
            node.slip = found.force.share * found.slip.norm();
            Some(found)
        });
        Ok(tractions.collect())
    }

    fn traction(
        &self,
        law: &ContactLaw<'_>,
        friction: &Coulomb,
        node: &NodeContact,
        normal: Vector3,
        track: &Track,
    ) -> Traction {
        // In a plane of symmetry, what the images of a node's faces have beyond it takes away what points out of it.
        let within = |x: Vector3| self.skin.within_planes(self.first[node.slave], x);
        let (way, normal) = (within(track.way(&self.positions)), within(normal));
        let inputs = traction::Inputs {
            way: way.into(),
            normal: normal.into(),
            pressure: node.pressure,
            coefficient: friction.coefficient(),
            stiffness: friction.stiffness(),
            opening: law.penalty * track.anchor.opening,
        };
        let results = traction::evaluate(Mode::Gradient, &inputs);
        let row = |i: usize, first: usize| -> Point {
            let row = &results.traction_jacobian[7 * i..][..7];
            let by = |axis: usize| {
                let unit = within(Vector3::axis(axis));
                (0..3).map(|j| row[first + j] * unit[j]).sum()
            };
            [0, 1, 2].map(by)
        };
        let slip = Vector3::from(results.values.slip);
        let of_law = NormalForce { force: node.pressure, stiffness: law.penalty };
        Traction {
            value: results.values.traction,
            by_way: [0, 1, 2].map(|i| row(i, 0)),
            by_normal: [0, 1, 2].map(|i| row(i, 3)),
            by_pressure: [0, 1, 2].map(|i| results.traction_jacobian[7 * i + 6]),
            slip,
            force: friction.force_since(of_law, 0.5 * slip.norm_squared(), track.anchor.opening),
        }
    }

    /// Accepts the state at the positions of the moment as the end of a step: friction of the next one is measured from here. Without
    /// friction in the law nothing happens.
    ///
    /// To be called as [`ContactInterface::accept`](crate::ContactInterface::accept): once before the first step, after a refresh, and whenever
    /// a step has converged. Nodes that carry pressure without a history, as they had nothing over them when the step before was accepted, are
    /// counted as unanchored.
    ///
    /// # Errors
    /// [`InterfaceError::Law`], [`InterfaceError::NotRefreshed`], [`InterfaceError::OutOfMemory`]. The history then stays.
    pub fn accept(&mut self, law: &ContactLaw<'_>) -> Result<FrictionReport, InterfaceError> {
        let Some(friction) = law.friction else { return Ok(FrictionReport::default()) };
        law.validate(self.nodes.len())?;
        if self.cut_at.is_none() {
            return Err(InterfaceError::NotRefreshed);
        }
        let (mut nodes, normals) = self.averages(law)?;
        let present = self.present_tracks()?;
        let mut report = FrictionReport::default();
        let mut tracks = Vec::with_capacity(nodes.len());
        for (k, (node, present)) in nodes.iter_mut().zip(present).enumerate() {
            let old = self.tracks.as_ref().and_then(|tracks| tracks[k].as_ref());
            let Some(present) = present.filter(|_| node.outcome.is_contact()) else {
                report.dropped += usize::from(old.is_some_and(|old| old.anchor.opening == 0.0));
                tracks.push(None);
                continue;
            };
            let is_open = !(node.pressure > 0.0);
            let closed = old.filter(|_| !is_open);
            report.unanchored += usize::from(!is_open && closed.is_none());
            let traction = closed.map(|old| self.traction(law, &friction, node, normals[k], old));
            if let Some(Traction { force, slip, .. }) = &traction {
                report.stuck += usize::from(force.state == FrictionState::Stick);
                report.sliding += usize::from(force.state == FrictionState::Slip);
                report.dissipated += node.area * force.dissipated(slip.norm());
            }
            let track = match (closed, &traction) {
                (Some(old), Some(Traction { force, .. })) if force.kept == 1.0 => old.clone(),
                (old, traction) => {
                    let (kept, slip) =
                        traction.as_ref().map_or((0.0, Vector3::zeros()), |of| (of.force.kept, of.slip));
                    let drawn = old.map_or(present.clone(), |old| old.towards(&present, 1.0 - kept));
                    let opening = if is_open { node.gap.max(0.0) } else { 0.0 };
                    drawn.with_slip(slip * kept, normals[k], &self.positions).with_opening(opening)
                }
            };
            tracks.push(Some(track));
        }
        self.tracks = Some(tracks);
        Ok(report)
    }

    /// x_A and y_A of all nodes, as the faces are cut now.
    fn present_tracks(&self) -> Result<Vec<Option<Track>>, InterfaceError> {
        type Terms = Vec<(u32, f64)>;
        let mut sums: Vec<(f64, Terms, Terms)> = vec![Default::default(); self.nodes.len()];
        self.for_each_point(Mode::Gradient, |face, point, functions, contact| {
            if !contact.outcome.is_contact() {
                return;
            }
            let own: &Carrying = &self.carriers.faces[face];
            let over: &Carrying = &self.carriers.facets[point.facet as usize];
            let x = own.point(&point.functions, &self.positions);
            let [a, b, c, ..] = *contact.gradient else { return };
            let Some(along) = Vector3::from([a, b, c]).try_normalize() else { return };
            let Some(carried) = over.carried(&self.positions, x, along.into(), Mode::Value) else { return };
            for (corner, n) in self.faces[face].corners().iter().zip(functions) {
                let Ok(place) = self.nodes.binary_search(corner) else { continue };
                let (total, of_slave, of_master) = &mut sums[place];
                let weight = point.weight * n;
                *total += weight;
                let nodes = own.nodes().iter().zip(point.functions);
                of_slave.extend(nodes.map(|(&node, n)| (node as u32, weight * n)));
                let nodes = over.nodes().iter().zip(&carried.forces[1..]);
                let part = |part: Point| weight * Vector3::from(part).dot(&along);
                of_master.extend(nodes.map(|(&node, &force)| (node as u32, part(force))));
            }
        })?;
        let point = |terms: Terms, total: f64| {
            AffinePoint::new(terms.into_iter().map(|(node, weight)| (node, weight / total))).ok()
        };
        let tracks = sums.into_iter().map(|(total, own, of_master)| {
            let anchor = Anchor { point: point(of_master, total)?, opening: 0.0 };
            Some(Track { own: point(own, total)?, anchor })
        });
        Ok(tracks.collect())
    }

    /// The history of friction as plain numbers, for a restart; empty before a state was [accepted](Self::accept).
    #[must_use]
    pub fn history(&self) -> Vec<f64> {
        let point = |track: &Option<Track>| {
            let Some(Track { own, anchor }) = track else { return [None, None] };
            [Some(Anchor { point: own.clone(), opening: 0.0 }), Some(anchor.clone())]
        };
        self.tracks.as_deref().map_or_else(Vec::new, |tracks| {
            to_numbers(&tracks.iter().flat_map(point).collect::<Vec<Option<Anchor>>>())
        })
    }

    /// Goes on from a [`history`](Self::history), bit for bit; no numbers are no history. If it is another one than the present, there is no
    /// contact until the next [`refresh`](Self::refresh).
    ///
    /// # Errors
    /// [`InterfaceError::InvalidHistory`], [`InterfaceError::AnchorCount`], [`InterfaceError::InvalidOpening`],
    /// [`InterfaceError::ForeignCarrier`]. The history of before then stays.
    pub fn set_history(&mut self, history: &[f64]) -> Result<(), InterfaceError> {
        let tracks = if history.is_empty() { None } else { Some(self.tracks_of(history)?) };
        if self.tracks != tracks {
            self.forget();
            self.tracks = tracks;
        }
        Ok(())
    }

    fn tracks_of(&self, history: &[f64]) -> Result<Vec<Option<Track>>, InterfaceError> {
        let points = from_numbers(history).map_err(|place| InterfaceError::InvalidHistory { place })?;
        let (found, expected) = (points.len().div_ceil(2), self.nodes.len());
        if found != expected || points.len() % 2 != 0 {
            return Err(InterfaceError::AnchorCount { found, expected });
        }
        let carriers = self.carriers.faces.iter().chain(&self.carriers.facets);
        let mut known: Vec<u32> = carriers.flat_map(|own| own.nodes()).map(|&node| node as u32).collect();
        sort(&mut known);
        let track = |(index, pair): (usize, &[Option<Anchor>; 2])| {
            let [Some(own), Some(anchor)] = pair else { return Ok(None) };
            if !(anchor.opening >= 0.0 && anchor.opening.is_finite()) {
                return Err(InterfaceError::InvalidOpening { index, value: anchor.opening });
            }
            let mut terms = own.point.terms().iter().chain(anchor.point.terms());
            let is_foreign = |(carrier, _): &&(crate::affine::Carrier, f64)| {
                carrier.image.is_some() || known.binary_search(&carrier.node).is_err()
            };
            match terms.find(is_foreign) {
                Some(&(carrier, _)) => Err(InterfaceError::ForeignCarrier { index, node: carrier.node }),
                None => Ok(Some(Track { own: own.point.clone(), anchor: anchor.clone() })),
            }
        };
        points.as_chunks::<2>().0.iter().enumerate().map(track).collect()
    }
}

impl Track {
    /// (1 − t) of this and t of another one.
    fn towards(&self, other: &Self, t: f64) -> Self {
        let point = self.anchor.point.towards(&other.anchor.point, t);
        Self { own: self.own.towards(&other.own, t), anchor: Anchor { point, ..self.anchor } }
    }

    fn with_opening(mut self, opening: f64) -> Self {
        self.anchor.opening = opening;
        self
    }

    /// The anchor moved along the master until the slip is this one: the faces of a curved body lie at different distances from their
    /// facets, whose mean is not along the mean normal.
    fn with_slip(mut self, slip: Vector3, normal: Vector3, positions: &[Point]) -> Self {
        let Some(normal) = normal.try_normalize() else { return self };
        let first = normal.cross(&Vector3::axis(normal.smallest_axis())).normalize();
        let axes = [first, normal.cross(&first)];
        let terms = self.anchor.point.terms();
        let place = |node: u32| Vector3::from(positions[node as usize]);
        let Some(&(origin, _)) = terms.first() else { return self };
        let origin = place(origin.node);
        let total: f64 = terms.iter().map(|(_, weight)| weight.abs()).sum();
        let offset = |node: u32| place(node) - origin;
        let centre = terms.iter().fold(Vector3::zeros(), |sum, &(carrier, weight)| {
            sum + offset(carrier.node) * (weight.abs() / total)
        });
        let seen = |x: Vector3| axes.map(|axis| axis.dot(&x));
        let arms: Vec<([f64; 2], f64)> = terms
            .iter()
            .map(|&(carrier, weight)| (seen(offset(carrier.node) - centre), weight.abs()))
            .collect();
        let moment =
            |i: usize, j: usize| arms.iter().map(|(arm, weight)| weight * arm[i] * arm[j]).sum::<f64>();
        let (xx, xy, yy) = (moment(0, 0), moment(0, 1), moment(1, 1));
        let determinant = xx * yy - xy * xy;
        if !(determinant > ON_A_LINE * (xx + yy) * (xx + yy)) {
            return self;
        }
        let [a, b] = seen(self.way(positions) - slip);
        let by_arm = [(yy * a - xy * b) / determinant, (xx * b - xy * a) / determinant];
        let moved = terms.iter().zip(&arms).map(|(&(carrier, weight), (arm, size))| {
            (carrier, weight + size * (arm[0] * by_arm[0] + arm[1] * by_arm[1]))
        });
        if let Ok(point) = AffinePoint::new(moved) {
            self.anchor.point = point;
        }
        self
    }
}
