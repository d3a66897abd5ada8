//! What a singular stiffness leaves free: rigid motions of a part that cost no force.

use std::fmt::{self, Display, Formatter};

use diffuse_contact_mesh::names::{list, shown};
use nalgebra::{Dyn, Matrix6, OMatrix, SymmetricEigen, U6, Vector3, Vector6};

use crate::system::{BlockMatrix, Equations};

/// A motion costs nothing if its stiffness is below this part of the moduli it is a sum of.
const NOTHING: f64 = 1e-11;
/// An entry of a motion that is none.
const ROUNDING: f64 = 1e-6;

/// A part that nothing holds, or several that hold one another and nothing else does.
#[derive(Clone, Debug, PartialEq)]
pub struct Loose {
    /// Their names in the deck, with a node of pieces that are not connected.
    pub parts: Vec<String>,
    /// The motions that are free.
    pub motions: Vec<RigidMotion>,
    /// Interfaces over faces whose average gaps are all open, while points of the faces are far nearer: pressures of points would hold.
    pub averaged: Vec<String>,
}

/// A small motion of a body as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigidMotion {
    /// Along a direction of length 1.
    Translation([f64; 3]),
    /// About an axis: a direction of length 1 through a point. Lengths have some five digits of the extent of the parts.
    Rotation {
        /// The direction.
        axis: [f64; 3],
        /// The point.
        point: [f64; 3],
        /// The way along the axis, length per radian: of a screw it is not 0.
        pitch: f64,
    },
}

impl Display for Loose {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let motions = list(self.motions.iter().map(RigidMotion::to_string));
        let together = if self.parts.len() > 1 { " together" } else { "" };
        let parts = list(self.parts.iter().map(|part| format!("`{}`", shown(part))));
        write!(f, "nothing holds {parts}{together} against {motions}")
    }
}

impl Display for RigidMotion {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Translation(direction) => write!(f, "moving along {}", Direction(*direction)),
            Self::Rotation { axis, point, pitch } => {
                // Without the sign of a zero.
                let [x, y, z] = point.map(|x| x + 0.0);
                write!(f, "turning about {} through ({x}, {y}, {z})", Direction(*axis))?;
                if *pitch != 0.0 { write!(f, " while moving along it by {pitch} a radian") } else { Ok(()) }
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

/// The parts of which the stiffness resists some rigid motion with nothing; if there is none, the groups of parts that are coupled.
pub fn loose_parts(
    matrix: &BlockMatrix,
    equations: &Equations,
    positions: &[[f64; 3]],
    parts: &[(String, Vec<usize>)],
) -> Vec<Loose> {
    let mut whole = vec![[0.0; 3]; positions.len()];
    let mut find = |group: &[usize]| {
        let nodes: Vec<usize> = group.iter().flat_map(|&part| &parts[part].1).copied().collect();
        let motions = free_motions(matrix, equations, positions, &nodes, &mut whole);
        let parts = group.iter().map(|&part| parts[part].0.clone()).collect();
        (!motions.is_empty()).then_some(Loose { parts, motions, averaged: Vec::new() })
    };
    let alone: Vec<Loose> = (0..parts.len()).filter_map(|part| find(&[part])).collect();
    if !alone.is_empty() {
        return alone;
    }
    groups(matrix, parts).iter().filter(|group| group.len() > 1).filter_map(|group| find(group)).collect()
}

/// Parts that have a stiffness between their nodes, of contact, in groups.
fn groups(matrix: &BlockMatrix, parts: &[(String, Vec<usize>)]) -> Vec<Vec<usize>> {
    let pattern = matrix.pattern();
    let mut part_of = vec![None; pattern.nodes()];
    for (part, (_, nodes)) in parts.iter().enumerate() {
        nodes.iter().for_each(|&node| part_of[node] = Some(part));
    }
    // The least part of each group, by the parts.
    let mut group: Vec<usize> = (0..parts.len()).collect();
    for node in 0..pattern.nodes() {
        for &other in pattern.row(node) {
            let (Some(a), Some(b)) = (part_of[node], part_of[other as usize]) else { continue };
            let is_coupled =
                || matrix.block(node, other as usize).is_some_and(|block| *block != [[0.0; 3]; 3]);
            if group[a] != group[b] && is_coupled() {
                let (least, last) = (group[a].min(group[b]), group[a].max(group[b]));
                group.iter_mut().filter(|group| **group == last).for_each(|group| *group = least);
            }
        }
    }
    (0..parts.len()).map(|least| (0..parts.len()).filter(|&part| group[part] == least).collect()).collect()
}

/// The rigid motions of some nodes that cost no force. `whole`: zeros for all nodes, before and after.
fn free_motions(
    matrix: &BlockMatrix,
    equations: &Equations,
    positions: &[[f64; 3]],
    nodes: &[usize],
    whole: &mut [[f64; 3]],
) -> Vec<RigidMotion> {
    let rigid = RigidModes::of(equations, positions, nodes);
    let modes = &rigid.modes;
    // Where much is prescribed, modes may be the same motion of what is free.
    let (mut gram, mut stiffness, mut largest) = (Matrix6::zeros(), Matrix6::zeros(), 0.0_f64);
    for column in 0..6 {
        nodes.iter().zip(&modes[column]).for_each(|(&node, moved)| whole[node] = *moved);
        let moduli = matrix.multiply_moduli_rows(nodes, whole);
        let products = modes[column].iter().zip(&moduli);
        let moduli = products.map(|(moved, row)| (0..3).map(|i| moved[i].abs() * row[i]).sum::<f64>());
        largest = largest.max(moduli.sum());
        let product = matrix.multiply_rows(nodes, whole);
        for row in 0..6 {
            gram[(row, column)] = dot(&modes[row], &modes[column]);
            stiffness[(row, column)] = dot(&modes[row], &product);
        }
    }
    nodes.iter().for_each(|&node| whole[node] = [0.0; 3]);
    if !(largest > 0.0 && largest.is_finite()) {
        return Vec::new();
    }
    let distinct = SymmetricEigen::new(gram);
    let basis: Vec<Vector6<f64>> = (0..6)
        .filter(|&k| distinct.eigenvalues[k] > ROUNDING)
        .map(|k| distinct.eigenvectors.column(k) / distinct.eigenvalues[k].sqrt())
        .collect();
    let basis = OMatrix::<f64, U6, Dyn>::from_columns(&basis);
    let reduced = basis.transpose() * (0.5 * (stiffness + stiffness.transpose())) * &basis;
    let eigen = SymmetricEigen::new(reduced);
    let is_free = |k: &usize| eigen.eigenvalues[*k].abs() < NOTHING * largest;
    let mut free: Vec<Vector6<f64>> =
        (0..basis.ncols()).filter(is_free).map(|k| &basis * eigen.eigenvectors.column(k)).collect();
    reduce(&mut free);
    let extent = nodes.iter().map(|&node| (Vector3::from(positions[node]) - rigid.centre).norm());
    let extent = extent.fold(0.0, f64::max);
    free.iter().map(|vector| rigid.motion(vector, extent)).collect()
}

fn dot(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).map(|(&a, &b)| Vector3::from(a).dot(&Vector3::from(b))).sum()
}

/// The rigid motions of some nodes: three along axes, three about axes through their centre.
struct RigidModes {
    centre: Vector3<f64>,
    /// What each moves the unknowns of these nodes by, of length 1; nothing of one that is held as a whole.
    modes: [Vec<[f64; 3]>; 6],
    /// Their lengths before.
    sizes: [f64; 6],
}

impl RigidModes {
    fn of(equations: &Equations, positions: &[[f64; 3]], nodes: &[usize]) -> Self {
        let at = |node: usize| Vector3::from(positions[node]);
        let centre = nodes.iter().map(|&node| at(node)).sum::<Vector3<f64>>() / nodes.len().max(1) as f64;
        let mut sizes = [0.0; 6];
        let mut modes: [Vec<[f64; 3]>; 6] = std::array::from_fn(|_| vec![[0.0; 3]; nodes.len()]);
        for (k, mode) in modes.iter_mut().enumerate() {
            let axis = Vector3::ith(k % 3, 1.0);
            for (&node, own) in nodes.iter().zip(mode.iter_mut()) {
                let moved = if k < 3 { axis } else { axis.cross(&(at(node) - centre)) };
                for i in (0..3).filter(|&i| equations.number(node, i).is_some()) {
                    own[i] = moved[i];
                }
            }
            sizes[k] = dot(mode, mode).sqrt();
            let factor = if sizes[k] > 0.0 { 1.0 / sizes[k] } else { 0.0 };
            mode.iter_mut().flatten().for_each(|x| *x *= factor);
        }
        Self { centre, modes, sizes }
    }

    /// The motion with these parts of the modes. `extent`: of the nodes from the centre.
    fn motion(&self, parts: &Vector6<f64>, extent: f64) -> RigidMotion {
        let of = |k: usize| if self.sizes[k] > 0.0 { parts[k] / self.sizes[k] } else { 0.0 };
        let (along, about) = (Vector3::new(of(0), of(1), of(2)), Vector3::new(of(3), of(4), of(5)));
        if (3..6).all(|k| parts[k].abs() < ROUNDING) {
            return RigidMotion::Translation(direction(along));
        }
        let point = self.centre + about.cross(&along) / about.norm_squared();
        let pitch = along.dot(&about) / about.norm_squared();
        let pitch = if pitch.abs() < ROUNDING * extent { 0.0 } else { rounded(pitch, extent) };
        let point = [point.x, point.y, point.z].map(|x| rounded(x, extent));
        RigidMotion::Rotation { axis: direction(about), point, pitch }
    }
}

/// To a ten-thousandth of the largest power of ten that is no more than `extent`, which is positive.
fn rounded(x: f64, extent: f64) -> f64 {
    let decimals = 4 - extent.log10().floor() as i32;
    let power = 10_f64.powi(decimals.abs());
    if decimals >= 0 { (x * power).round() / power } else { (x / power).round() * power }
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
