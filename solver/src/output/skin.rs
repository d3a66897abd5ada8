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
        let sizes = |vectors: &[[f64; 3]]| -> Vec<f64> {
            vectors.iter().map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt()).collect()
        };
        let numbers = |status: &[i32]| -> Vec<f64> { status.iter().copied().map(f64::from).collect() };
        let mut of_skin = BTreeMap::new();
        let mut add = |name: &str, values: &[f64]| {
            of_skin.insert(name.to_owned(), self.nodes.iter().map(|&node| values[node]).collect());
        };
        add("displacement", &sizes(&fields.displacement));
        add("contact_pressure", &fields.contact_pressure);
        add("contact_gap", &fields.contact_gap);
        add("contact_status", &numbers(&fields.contact_status));
        if let Some(stresses) = &fields.stresses {
            add("von_mises", &stresses.von_mises);
            add("plastic_strain", &stresses.plastic_strain);
        }
        if let Some(friction) = &fields.friction {
            add("contact_slip", &friction.slip);
            add("contact_friction", &sizes(&friction.traction));
            add("friction_status", &numbers(&friction.status));
        }
        let positions = self.nodes.iter().map(|&node| positions[node]).collect();
        SkinFrame { increment, time, positions, fields: of_skin }
    }
}
