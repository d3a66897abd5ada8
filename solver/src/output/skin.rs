//! What one sees: the outer faces of the bodies and the rigid surfaces.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Fields;
use crate::model::Model;

/// Faces that belong to one element only, and rigid facets.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Skin {
    /// Indices of the nodes in the model, ascending.
    pub nodes: Vec<usize>,
    /// Corners of each face, three or four, as places in `nodes`.
    pub faces: Vec<Vec<usize>>,
    /// Index of each face's part among the names.
    pub parts: Vec<usize>,
    /// Names of the deformable parts, then of the rigid ones.
    pub names: Vec<String>,
    /// Number of deformable parts.
    pub deformable: usize,
    /// Name of the field that is shown first.
    pub shown: String,
}

/// A skin at one time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SkinFrame {
    /// Number of the increment; 0: the start.
    pub increment: usize,
    /// Pseudo-time.
    pub time: f64,
    /// Positions of the skin's nodes.
    pub positions: Vec<[f64; 3]>,
    /// Fields at the skin's nodes by name.
    pub fields: BTreeMap<String, Vec<f64>>,
}

impl Skin {
    /// The skin of a model, and the field that is shown first.
    pub fn of(model: &Model, shown: &str) -> Self {
        let mut corners: Vec<Vec<usize>> = Vec::new();
        let mut parts = Vec::new();
        for (k, faces) in model.skins().into_iter().enumerate() {
            corners.extend(faces.iter().map(|face| face.corners().to_vec()));
            parts.resize(corners.len(), k);
        }
        let mut names: Vec<String> = model.bodies.iter().map(|body| body.name.clone()).collect();
        for (name, facets) in model.rigid_parts() {
            corners.extend(facets.iter().map(|facet| facet.corners().to_vec()));
            parts.resize(corners.len(), names.len());
            names.push(name.to_owned());
        }
        let mut nodes: Vec<usize> = corners.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut place = vec![0; model.nodes.len()];
        for (k, &node) in nodes.iter().enumerate() {
            place[node] = k;
        }
        let faces =
            corners.into_iter().map(|face| face.into_iter().map(|node| place[node]).collect()).collect();
        Self { nodes, faces, parts, names, deformable: model.bodies.len(), shown: shown.to_owned() }
    }

    /// The skin's part of positions and fields.
    pub fn frame(&self, increment: usize, time: f64, positions: &[[f64; 3]], fields: &Fields) -> SkinFrame {
        let size = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let displacement: Vec<f64> = fields.displacement.iter().map(size).collect();
        let status: Vec<f64> = fields.contact_status.iter().copied().map(f64::from).collect();
        let friction = fields.friction.as_ref().map(|friction| {
            let traction: Vec<f64> = friction.traction.iter().map(size).collect();
            let status: Vec<f64> = friction.status.iter().copied().map(f64::from).collect();
            (&friction.slip, traction, status)
        });
        let mut named: Vec<(&str, &[f64])> = vec![
            ("displacement", &displacement),
            ("contact_pressure", &fields.contact_pressure),
            ("contact_gap", &fields.contact_gap),
            ("contact_status", &status),
        ];
        if let Some(stresses) = &fields.stresses {
            named.push(("von_mises", &stresses.von_mises));
            named.push(("plastic_strain", &stresses.plastic_strain));
        }
        if let Some((slip, traction, status)) = &friction {
            named.push(("contact_slip", slip));
            named.push(("contact_friction", traction));
            named.push(("friction_status", status));
        }
        SkinFrame {
            increment,
            time,
            positions: self.nodes.iter().map(|&node| positions[node]).collect(),
            fields: named
                .into_iter()
                .map(|(name, values)| {
                    (name.to_owned(), self.nodes.iter().map(|&node| values[node]).collect())
                })
                .collect(),
        }
    }
}
