//! The tangent as an operator: K v from the vectors that it is a sum of products of.

use rayon::prelude::*;

use super::contacts::{FaceContacts, FacePart, NodeBlock};
use crate::Mode;
use crate::assembly::{AssemblyError, DofMap, Tangent, add_entry};

/// What a part of the tangent adds to a product: an entry per coordinate of its rows' nodes.
struct Part<'a> {
    rows: &'a [u32],
    sums: Vec<f64>,
}

impl FaceContacts {
    /// Adds K v to `product`, one entry per equation, with the K of [`for_each_tangent`](Self::for_each_tangent). Of each node that carries
    /// pressure the vectors F and G are multiplied, with friction those of its traction, too, and not the block that they stand for. The
    /// result is the same for any number of threads, bit for bit, and differs from that of the assembled matrix by rounding.
    ///
    /// # Errors
    /// [`AssemblyError::OutputLength`], [`AssemblyError::UnknownNode`], [`AssemblyError::NotDerived`], and
    /// [`AssemblyError::NonFiniteEntry`] for an entry of `v` that is not finite: `product` is then unchanged.
    /// [`AssemblyError::Overflow`] if a sum is not finite; the contents of `product` are then unspecified.
    pub fn add_product(
        &self,
        tangent: Tangent,
        dofs: &DofMap,
        v: &[f64],
        product: &mut [f64],
    ) -> Result<(), AssemblyError> {
        AssemblyError::check_length("entries of v", v.len(), dofs.equations())?;
        AssemblyError::check_length("products", product.len(), dofs.equations())?;
        AssemblyError::check_finite("v", v)?;
        self.check(dofs, if tangent == Tangent::Exact { Mode::Hessian } else { Mode::Gradient })?;
        let moves = |nodes: &[u32]| -> Vec<f64> {
            let of_node = |&node: &u32| [0, 1, 2].map(|axis| dofs.equation(node as usize, axis));
            nodes
                .iter()
                .flat_map(of_node)
                .map(|equation| equation.map_or(0.0, |equation| v[equation]))
                .collect()
        };
        let of_nodes = self
            .blocks
            .par_iter()
            .map(|block| Part { rows: &block.rows, sums: block.multiply(tangent, &moves(&block.columns)) });
        let of_faces = self
            .faces
            .par_iter()
            .map(|part| Part { rows: &part.rows, sums: part.multiply(tangent, &moves(&part.columns)) });
        let parts: Vec<Part<'_>> = of_nodes.chain(of_faces).collect();
        for Part { rows, sums } in parts {
            for (&node, sums) in rows.iter().zip(sums.as_chunks::<3>().0) {
                for (axis, sum) in sums.iter().enumerate() {
                    if let Some(equation) = dofs.equation(node as usize, axis) {
                        add_entry("products", product, equation, *sum)?;
                    }
                }
            }
        }
        Ok(())
    }
}

impl NodeBlock {
    /// (ε F Gᵀ − Σ W_i ∂t_i/∂x) v
    fn multiply(&self, tangent: Tangent, v: &[f64]) -> Vec<f64> {
        let along = self.stiffness * dot(&self.gradient, v);
        let mut sums: Vec<f64> = self.forces.iter().map(|force| along * force).collect();
        let Some(friction) = &self.friction else { return sums };
        for axis in 0..3 {
            let turning = if tangent == Tangent::Exact { &friction.turning[axis][..] } else { &[] };
            let by = dot(&friction.gradients[axis], v) + dot(turning, v);
            sums.iter_mut().zip(&friction.forces[axis]).for_each(|(sum, force)| *sum -= force * by);
        }
        sums
    }
}

impl FacePart {
    fn multiply(&self, tangent: Tangent, v: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; 3 * self.rows.len()];
        for entries in self.tangents(tangent) {
            let rows = sums.iter_mut().zip(entries.chunks_exact(v.len().max(1)));
            rows.for_each(|(sum, row)| *sum += dot(row, v));
        }
        sums
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
