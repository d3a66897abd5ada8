//! What a singular stiffness leaves free: rigid motions of a part that cost no force.

use std::fmt::{self, Display, Formatter};

use diffuse_contact_mesh::names::{list, shown};
use nalgebra::{Matrix6, SymmetricEigen, Vector3, Vector6};

use crate::system::{BlockMatrix, Equations};

/// A motion costs nothing if its stiffness is below this part of the moduli it is a sum of.
const NOTHING: f64 = 1e-11;
/// An entry of a motion that is none.
const ROUNDING: f64 = 1e-6;

/// A part that nothing holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Loose {
    /// Its name in the deck; `None`: all parts together, each of which holds the others.
    pub part: Option<String>,
    /// The motions that are free.
    pub motions: Vec<RigidMotion>,
}

/// A small motion of a body as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigidMotion {
    /// Along a direction of length 1.
    Translation([f64; 3]),
    /// About an axis: a direction of length 1 through a point.
    Rotation {
        /// The direction.
        axis: [f64; 3],
        /// The point.
        point: [f64; 3],
    },
}

impl Display for Loose {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let motions = list(self.motions.iter().map(RigidMotion::to_string));
        match &self.part {
            Some(part) => write!(f, "nothing holds `{}` against {motions}", shown(part)),
            None => write!(f, "nothing holds all parts together against {motions}"),
        }
    }
}

impl Display for RigidMotion {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Translation(direction) => write!(f, "moving along {}", Direction(*direction)),
            Self::Rotation { axis, point: [x, y, z] } => {
                write!(f, "turning about {} through ({x:.4}, {y:.4}, {z:.4})", Direction(*axis))
            }
        }
    }
}

/// An axis by its name, or three numbers.
struct Direction([f64; 3]);

impl Display for Direction {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0;
        match self.0.iter().position(|component| component.abs() > 1.0 - ROUNDING) {
            Some(axis) => write!(f, "{}", ["x", "y", "z"][axis]),
            None => write!(f, "({x:.3}, {y:.3}, {z:.3})"),
        }
    }
}

/// The parts of which the stiffness resists some rigid motion with nothing; if there is none, all of them together.
pub fn loose_parts(
    matrix: &BlockMatrix,
    equations: &Equations,
    positions: &[[f64; 3]],
    parts: &[(&str, Vec<usize>)],
) -> Vec<Loose> {
    let find = |part: Option<&str>, nodes: &[usize]| {
        let motions = free_motions(matrix, equations, positions, nodes);
        (!motions.is_empty()).then(|| Loose { part: part.map(str::to_owned), motions })
    };
    let found: Vec<Loose> = parts.iter().filter_map(|(name, nodes)| find(Some(name), nodes)).collect();
    if !found.is_empty() {
        return found;
    }
    let all: Vec<usize> = parts.iter().flat_map(|(_, nodes)| nodes).copied().collect();
    find(None, &all).into_iter().collect()
}

/// The rigid motions of some nodes that cost no force.
fn free_motions(
    matrix: &BlockMatrix,
    equations: &Equations,
    positions: &[[f64; 3]],
    nodes: &[usize],
) -> Vec<RigidMotion> {
    let at = |node: usize| Vector3::from(positions[node]);
    let centre = nodes.iter().map(|&node| at(node)).sum::<Vector3<f64>>() / nodes.len().max(1) as f64;
    let mode = |k: usize| {
        let mut mode = vec![[0.0; 3]; positions.len()];
        let axis = Vector3::ith(k % 3, 1.0);
        for &node in nodes {
            let moved = if k < 3 { axis } else { axis.cross(&(at(node) - centre)) };
            for i in (0..3).filter(|&i| equations.number(node, i).is_some()) {
                mode[node][i] = moved[i];
            }
        }
        mode
    };
    let modes: [Vec<[f64; 3]>; 6] = std::array::from_fn(mode);
    let dot = |a: &[[f64; 3]], b: &[[f64; 3]]| -> f64 {
        nodes.iter().map(|&n| Vector3::from(a[n]).dot(&Vector3::from(b[n]))).sum()
    };
    let mut product = vec![[0.0; 3]; positions.len()];
    // Each mode is scaled by the moduli of what it sums up.
    let scales: [f64; 6] = std::array::from_fn(|k| {
        matrix.multiply_moduli(&modes[k], &mut product);
        nodes
            .iter()
            .map(|&n| (0..3).map(|i| modes[k][n][i].abs() * product[n][i]).sum::<f64>())
            .sum::<f64>()
            .sqrt()
    });
    let mut reduced = Matrix6::zeros();
    for column in 0..6 {
        if scales[column] == 0.0 {
            // Held as a whole.
            reduced[(column, column)] = 1.0;
            continue;
        }
        matrix.multiply(&modes[column], &mut product);
        for row in (0..6).filter(|&row| scales[row] > 0.0) {
            reduced[(row, column)] = dot(&modes[row], &product) / (scales[row] * scales[column]);
        }
    }
    let eigen = SymmetricEigen::new(0.5 * (reduced + reduced.transpose()));
    let free = (0..6).filter(|&k| eigen.eigenvalues[k].abs() < NOTHING);
    let mut free: Vec<Vector6<f64>> = free.map(|k| eigen.eigenvectors.column(k).into()).collect();
    reduce(&mut free);
    let motion = |vector: &Vector6<f64>| {
        let of = |k: usize| if scales[k] > 0.0 { vector[k] / scales[k] } else { 0.0 };
        let (along, about) = (Vector3::new(of(0), of(1), of(2)), Vector3::new(of(3), of(4), of(5)));
        if (3..6).all(|k| vector[k].abs() < ROUNDING) {
            return RigidMotion::Translation(direction(along));
        }
        let point = centre + about.cross(&along) / about.norm_squared();
        RigidMotion::Rotation { axis: direction(about), point: point.into() }
    };
    free.iter().map(motion).collect()
}

/// Of length 1, without what is rounding.
fn direction(vector: Vector3<f64>) -> [f64; 3] {
    let unit = vector.normalize();
    unit.map(|component| if component.abs() < ROUNDING { 0.0 } else { component }).normalize().into()
}

/// The same space by vectors with as many zeros as can be, by elimination: translations along axes come first.
fn reduce(vectors: &mut [Vector6<f64>]) {
    let mut done = 0;
    for column in 0..6 {
        let rest = done..vectors.len();
        let Some(pivot) = rest.max_by(|&a, &b| vectors[a][column].abs().total_cmp(&vectors[b][column].abs()))
        else {
            return;
        };
        if vectors[pivot][column].abs() < ROUNDING {
            continue;
        }
        vectors.swap(done, pivot);
        let scaled = vectors[done] / vectors[done][column];
        for (k, vector) in vectors.iter_mut().enumerate() {
            *vector = if k == done { scaled } else { *vector - scaled * vector[column] };
        }
        done += 1;
    }
}
