//! Stresses for output: at the points, and averaged to the nodes.

use nalgebra::Matrix3;
use rayon::prelude::*;

use super::{Element, PIECE, Solid, SolidError};
use crate::material::PointState;

/// What is known of the material at an integration point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointFields {
    /// Cauchy stress xx, yy, zz, xy, yz, xz, force per current area; its mean is the pressure U' of the element or the point.
    pub stress: [f64; 6],
    /// √(3/2 s·s) of its deviator.
    pub von_mises: f64,
    /// p.
    pub equivalent_plastic_strain: f64,
}

/// Fields at the nodes of one body: extrapolated from the points to the nodes of each element, then averaged over the
/// elements of the body at a node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodalFields {
    /// The nodes of the body, ascending.
    pub nodes: Vec<usize>,
    /// The fields at each. Von Mises' stress is that of the averaged tensor; a plastic strain extrapolated below 0 is 0.
    pub fields: Vec<PointFields>,
}

/// Stresses and plastic strains.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recovery {
    /// One for each point of each element, in the order of [`Solid::elements`]; [`Solid::points`] finds them.
    pub points: Vec<PointFields>,
    /// One entry a body, because stresses jump where materials meet.
    pub bodies: Vec<NodalFields>,
}

impl Solid {
    /// Stresses at `positions` with `states`, those at the end of the step that led there.
    ///
    /// # Errors
    /// Those of [`Solid::evaluate`].
    pub fn recover(&self, positions: &[[f64; 3]], states: &[PointState]) -> Result<Recovery, SolidError> {
        self.check(positions, states)?;
        let of_piece = |(piece, elements): (usize, &[Element])| {
            let mut points = Vec::new();
            for (own, element) in elements.iter().enumerate() {
                let step = self.step(piece * PIECE + own, positions, states);
                let found = element.for_each_point(step, |point, pressure| {
                    let s: Matrix3<f64> = point.answer.kirchhoff() / point.jacobian;
                    let stress = [
                        s[(0, 0)] + pressure,
                        s[(1, 1)] + pressure,
                        s[(2, 2)] + pressure,
                        s[(1, 0)],
                        s[(2, 1)],
                        s[(2, 0)],
                    ];
                    points.push(PointFields::new(stress, point.answer.state.equivalent_plastic_strain));
                });
                found.map_err(|error| self.named(error))?;
            }
            Ok(points)
        };
        let pieces: Vec<Result<_, SolidError>> =
            self.elements.par_chunks(PIECE).enumerate().map(of_piece).collect();
        let mut points = Vec::with_capacity(states.len());
        for piece in pieces {
            points.append(&mut piece?);
        }
        let bodies = (0..self.bodies.len()).into_par_iter().map(|body| self.average(body, &points)).collect();
        Ok(Recovery { points, bodies })
    }

    fn average(&self, body: usize, points: &[PointFields]) -> NodalFields {
        let own = || self.body(body).flat_map(|index| self.elements[index].nodes());
        let (Some(&first), Some(&last)) = (own().min(), own().max()) else { return NodalFields::default() };
        // Seven sums and a count by node; nodes of other bodies between its own stay empty.
        let mut sums = vec![([0.0; 7], 0_u32); last - first + 1];
        for index in self.body(body) {
            let (element, points) = (&self.elements[index], &points[self.points(index)]);
            let extrapolation = &element.reference().extrapolation;
            for (weights, &node) in extrapolation.iter().zip(element.nodes()) {
                let (sum, count) = &mut sums[node - first];
                *count += 1;
                for (weight, point) in weights.iter().zip(points) {
                    for k in 0..6 {
                        sum[k] += weight * point.stress[k];
                    }
                    sum[6] += weight * point.equivalent_plastic_strain;
                }
            }
        }
        let mut nodal = NodalFields::default();
        for (node, (sum, count)) in sums.into_iter().enumerate().filter(|(_, (_, count))| *count > 0) {
            let mean = sum.map(|value| value / f64::from(count));
            let [stress @ .., plastic] = mean;
            nodal.nodes.push(first + node);
            nodal.fields.push(PointFields::new(stress, plastic.max(0.0)));
        }
        nodal
    }
}

impl PointFields {
    fn new(stress: [f64; 6], equivalent_plastic_strain: f64) -> Self {
        let [xx, yy, zz, xy, yz, xz] = stress;
        let apart = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
        let von_mises = (0.5 * apart + 3.0 * (xy * xy + yz * yz + xz * xz)).sqrt();
        Self { stress, von_mises, equivalent_plastic_strain }
    }
}
