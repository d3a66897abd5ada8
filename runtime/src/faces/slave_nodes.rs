//! The slave's nodes as its sheets have them. What is averaged belongs to one face of a body: a node on a sharp edge has an average for each
//! of the sheets that meet there, so that what lies beyond the edge does not hold it open.

use crate::Point;
use crate::interface::InterfaceError;
use crate::surface::{Creases, Facet, MasterSurface, SheetNodes, Symmetry, shape_of, sort};

/// The nodes in the order of all results.
#[derive(Debug, Default)]
pub struct SlaveNodes {
    /// Ascending. One on a sharp edge stands here once for each sheet, in the order of their lowest faces.
    pub nodes: Vec<usize>,
    /// Of the corners of each face: their places in `nodes`.
    of_corners: Vec<[u32; 4]>,
    /// The faces of each.
    pub around: Vec<Vec<u32>>,
    /// ∫ N_A dA over these faces in the first configuration, length².
    pub areas: Vec<f64>,
}

impl SlaveNodes {
    /// Of faces, by number among those of their surface, which end a sheet at edges sharper than the angle in the first configuration.
    pub fn new(
        surface: &MasterSurface,
        faces: &[u32],
        first: &[Point],
        feature_angle_degrees: f64,
    ) -> Result<Self, InterfaceError> {
        // Planes of symmetry part no faces of one side.
        let index = surface.at(first)?;
        let creases = Creases::new(&index, feature_angle_degrees.to_radians(), &Symmetry::default());
        let sheets = SheetNodes::without_auxiliary(surface, &creases);
        let of_face = |&face: &u32| sheets.of_facet(surface, face);
        let mut all: Vec<u32> = faces.iter().flat_map(of_face).copied().collect();
        sort(&mut all);
        let mut slaves = Self {
            nodes: all.iter().map(|&own| surface.nodes()[sheets.place(own)] as usize).collect(),
            of_corners: vec![[0; 4]; faces.len()],
            around: vec![Vec::new(); all.len()],
            areas: vec![0.0; all.len()],
        };
        for (k, face) in faces.iter().enumerate() {
            let shares = shape_of(&surface.facet(*face as usize), first).shares();
            for ((own, at), share) in of_face(face).iter().zip(&mut slaves.of_corners[k]).zip(shares) {
                let place = all.partition_point(|other| other < own);
                *at = place as u32;
                slaves.around[place].push(k as u32);
                slaves.areas[place] += share;
            }
        }
        match slaves.areas.iter().position(|&area| !(area > 0.0)) {
            Some(place) => Err(InterfaceError::SlaveWithoutArea { node: slaves.nodes[place] }),
            None => Ok(slaves),
        }
    }

    /// The places of the corners of a face.
    pub fn of_face(&self, k: usize, face: &Facet) -> impl Iterator<Item = usize> + Clone {
        self.of_corners[k].iter().take(face.corners().len()).map(|&place| place as usize)
    }
}
