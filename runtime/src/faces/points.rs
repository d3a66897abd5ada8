//! What contact is at the integration points of the faces.

use super::FaceInterface;
use crate::interface::InterfaceError;
use crate::vector::Vector3;
use crate::{Mode, Point};

/// An integration point that lies over the master.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct IntegrationPoint {
    /// The number of its face among the slave's.
    pub face: usize,
    /// Where it lies on the slave's own smooth surface, length.
    pub position: Point,
    /// What it stands for of its face in the first configuration, length².
    pub area: f64,
    /// g, length.
    pub gap: f64,
    /// Unit normal of the master.
    pub normal: Point,
    /// p = Σ N_A p_A ≥ 0, or its own where [points](super::FacePressures::Points) have one, force per area.
    pub pressure: f64,
    /// t = Σ N_A t_A, or what of p Σ N_A t_A / p_A lies across the normal, friction on the slave, force per area.
    pub friction: Point,
}

impl FaceInterface {
    /// The points with a contact at the positions of the last update, face by face. Pressures and tractions are those that the last
    /// [`evaluate`](Self::evaluate) gave the nodes, zero before: what is averaged is the pressure, while gaps and normals are each point's
    /// own. They are found anew by each call.
    ///
    /// # Errors
    /// [`InterfaceError::NotRefreshed`] before the first refresh or update.
    pub fn integration_points(&self) -> Result<Vec<IntegrationPoint>, InterfaceError> {
        if self.cut_at.is_none() {
            return Err(InterfaceError::NotRefreshed);
        }
        let mut points = Vec::with_capacity(self.report.paired);
        let mut own = self.contacts.pressures.iter();
        self.for_each_point(Mode::Value, |face, point, functions, contact| {
            let own = own.next().copied();
            if !contact.outcome.is_contact() {
                return;
            }
            let (mut pressure, mut friction) = (0.0, Vector3::zeros());
            for (place, n) in self.places_of(face).zip(functions) {
                if let Some(node) = self.contacts.nodes().get(place) {
                    let share = if own.is_some() && node.pressure > 0.0 { 1.0 / node.pressure } else { 1.0 };
                    pressure += n * node.pressure;
                    friction += Vector3::from(node.friction) * (n * share);
                }
            }
            if let Some(own) = own {
                let normal = Vector3::from(contact.point.normal);
                (pressure, friction) = (own, (friction - normal * normal.dot(&friction)) * own);
            }
            points.push(IntegrationPoint {
                face,
                position: self.skin.position(face, point.natural, &self.positions),
                area: point.weight,
                gap: contact.point.gap,
                normal: contact.point.normal,
                pressure,
                friction: friction.into(),
            });
        })?;
        Ok(points)
    }
}
