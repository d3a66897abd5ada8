//! The tangent of an element under construction: Bᵀ C B over all points, and what the directions of the forces add.

use nalgebra::Vector3;

use super::{Deformed, Scratch};
use crate::solid::product::{Strains, product};

impl Scratch {
    /// Room for an element.
    pub(super) fn clear<const N: usize, const P: usize, const Q: usize, const W: usize>(&mut self) {
        self.strains.resize((6 * P + Q) * W, 0.0);
        self.stresses.resize((6 * P + Q) * W, 0.0);
        self.geometric.clear();
        self.geometric.resize(N * (N + 1) / 2, 0.0);
        self.area.clear();
        self.area.resize(N * (N + 1) / 2, Vector3::zeros());
    }

    /// Adds a point of distortion. `forces`: the point's, w τ ∇N.
    #[inline]
    pub(super) fn add_distortion<const N: usize, const W: usize>(
        &mut self,
        point: usize,
        deformed: &Deformed,
        gradients: &[Vector3<f64>; N],
        forces: &[Vector3<f64>; N],
        weight: f64,
    ) {
        let mut pairs = self.geometric.iter_mut();
        for a in 0..N {
            for (gradient, geometric) in gradients[..=a].iter().zip(pairs.by_ref()) {
                *geometric += forces[a].dot(gradient);
            }
        }
        let rows = 6 * point..6 * (point + 1);
        let strains = &mut self.strains.as_chunks_mut::<W>().0[rows.clone()];
        deformed.strains(gradients, strains);
        deformed.stresses(weight, strains, &mut self.stresses.as_chunks_mut::<W>().0[rows]);
    }

    /// Adds p ∂²v/∂x∂x of a point; `load`: w J p.
    #[inline]
    pub(super) fn add_area<const N: usize>(&mut self, gradients: &[Vector3<f64>; N], load: f64) {
        let mut pairs = self.area.iter_mut();
        for a in 0..N {
            let area = gradients[a] * load;
            for (gradient, sum) in gradients[..=a].iter().zip(pairs.by_ref()) {
                *sum += area.cross(gradient);
            }
        }
    }

    /// Adds a row for the dilatation of a point: w J² U″ times its square.
    #[inline]
    pub(super) fn add_dilatation<const N: usize, const W: usize>(
        &mut self,
        row: usize,
        gradients: &[Vector3<f64>; N],
        stiffness: f64,
    ) {
        let strain = &mut self.strains.as_chunks_mut::<W>().0[row];
        let stress = &mut self.stresses.as_chunks_mut::<W>().0[row];
        for (a, gradient) in gradients.iter().enumerate() {
            for i in 0..3 {
                strain[3 * a + i] = gradient[i];
                stress[3 * a + i] = stiffness * gradient[i];
            }
        }
        strain[3 * N..].fill(0.0);
        stress[3 * N..].fill(0.0);
    }

    /// Σ Bᵀ C B.
    pub(super) fn product<const W: usize>(&self) -> [[f64; W]; W] {
        product(self.strains.as_chunks().0, self.stresses.as_chunks().0)
    }

    /// Adds what is not Bᵀ C B.
    pub(super) fn scatter<const N: usize, const W: usize>(&self, pressure: f64, full: &mut [[f64; W]; W]) {
        let mut pairs = self.geometric.iter().zip(&self.area);
        for a in 0..N {
            for (b, (geometric, area)) in (0..=a).zip(pairs.by_ref()) {
                let area = area * pressure;
                for k in 0..3 {
                    let (l, m) = ((k + 1) % 3, (k + 2) % 3);
                    full[3 * a + k][3 * b + k] += geometric;
                    full[3 * a + l][3 * b + m] += area[k];
                    full[3 * a + m][3 * b + l] -= area[k];
                }
            }
        }
    }
}

impl Deformed {
    /// B: the strains of a unit displacement of each coordinate.
    #[inline]
    pub(super) fn strains<const N: usize, const W: usize>(
        &self,
        gradients: &[Vector3<f64>; N],
        strains: &mut [Strains<W>],
    ) {
        let axes = &self.answer.axes;
        for a in 0..N {
            let along = axes.tr_mul(&gradients[a]);
            for i in 0..3 {
                let column = 3 * a + i;
                let axis = [axes[(i, 0)], axes[(i, 1)], axes[(i, 2)]];
                for k in 0..3 {
                    let (l, m) = ((k + 1) % 3, (k + 2) % 3);
                    strains[k][column] = along[k] * axis[k];
                    strains[3 + k][column] = along[l] * axis[m] + along[m] * axis[l];
                }
            }
        }
        for row in strains {
            row[3 * N..].fill(0.0);
        }
    }

    /// C B, times the point's volume.
    #[inline]
    pub(super) fn stresses<const W: usize>(
        &self,
        weight: f64,
        strains: &[Strains<W>],
        stresses: &mut [Strains<W>],
    ) {
        let normal = self.answer.normal * weight;
        let shear = self.answer.shear * weight;
        for k in 0..3 {
            for column in 0..W {
                stresses[k][column] = normal[(k, 0)] * strains[0][column]
                    + normal[(k, 1)] * strains[1][column]
                    + normal[(k, 2)] * strains[2][column];
                stresses[3 + k][column] = shear[k] * strains[3 + k][column];
            }
        }
    }
}
