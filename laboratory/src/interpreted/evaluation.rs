//! Results of one kernel at one element.

use diffuse_contact::{Element, ElementError, Gap, SymmetricMatrix};
use diffuse_contact_codegen::interpret::Interpreter;
use diffuse_contact_codegen::structure::{Gradient, Hessian};
use diffuse_contact_codegen::{FrameRule, Kernel, KernelSpec};
use diffuse_contact_kernels::support::GapValues;

/// One element on its way through one kernel's graph.
pub struct Evaluation<'a, S = KernelSpec> {
    pub kernel: &'a Kernel<S>,
    pub interpreter: Interpreter<'a>,
    /// Number of master nodes.
    pub count: usize,
}

impl<S> Evaluation<'_, S> {
    /// All components; none if the kernel has no such value in its mode.
    pub fn values(&mut self, name: &str) -> Vec<f64> {
        let value = self.kernel.values.iter().find(|value| value.name == name);
        let components = value.map(|value| value.components.as_slice()).unwrap_or_default();
        components.iter().map(|&x| self.interpreter.element(x)).collect()
    }

    pub fn array<const SIZE: usize>(&mut self, name: &str) -> [f64; SIZE] {
        let values = self.values(name);
        values.try_into().unwrap_or_else(|values: Vec<f64>| {
            panic!("the kernel value {name} has {} components, not {SIZE}", values.len())
        })
    }

    pub fn scalar(&mut self, name: &str) -> f64 {
        self.array::<1>(name)[0]
    }
}

impl Evaluation<'_> {
    /// Gap, foot and normal, without derivatives.
    pub fn contact(&mut self, element: &Element<'_>) -> Result<Gap, ElementError> {
        let values = GapValues {
            gap: self.scalar("gap"),
            foot: self.array("foot"),
            normal: self.array("normal"),
            // The kernels' own; `Slip` has it.
            slip: 0.0,
            coefficients: self.padded("coefficients"),
            pivot_ratio: self.scalar("pivot_ratio"),
            plane_pivot_ratio: self.plane_pivot_ratio(),
            foot_residual: self.scalar("foot_residual"),
            foot_iterations: self.scalar("foot_iterations"),
            foot_distance: self.scalar("foot_distance"),
            jacobian_determinant: self.scalar("jacobian_determinant"),
            jacobian_trace: self.scalar("jacobian_trace"),
            checksum: self.scalar("checksum"),
        };
        ElementError::check(values.status())?;
        Ok(Gap {
            gap: values.gap,
            foot: values.foot,
            normal: values.normal,
            coefficients: values.coefficients[..element.basis.size()].to_vec(),
            ..Gap::default()
        })
    }

    /// 1 if the frame is held: then there is no plane whose turn has to be found.
    pub fn plane_pivot_ratio(&mut self) -> f64 {
        match self.kernel.spec.frame {
            FrameRule::Held => 1.0,
            FrameRule::CoMoving | FrameRule::Material => self.scalar("plane_pivot_ratio"),
        }
    }

    /// Coefficients of either basis; the linear one leaves the last three at 0.
    pub fn padded(&mut self, name: &str) -> [f64; diffuse_contact::Basis::MOST_COEFFICIENTS] {
        let mut padded = [0.0; diffuse_contact::Basis::MOST_COEFFICIENTS];
        let values = self.values(name);
        padded[..values.len()].copy_from_slice(&values);
        padded
    }

    pub fn gradients(&mut self) -> Vec<Vec<f64>> {
        let kernel = self.kernel;
        kernel.gradients.iter().map(|(_, gradient)| self.gradient(gradient)).collect()
    }

    fn gradient(&mut self, gradient: &Gradient) -> Vec<f64> {
        let mut entries = gradient.slave.map(|x| self.interpreter.element(x)).to_vec();
        for node in 0..self.count {
            entries.extend(gradient.node.map(|x| self.interpreter.node(x, node)));
        }
        entries.extend(gradient.point.into_iter().flatten().map(|x| self.interpreter.element(x)));
        entries
    }

    /// A derivative that is combined from the Hessian's rows, by slave and masters.
    pub fn combination(&mut self, name: &str) -> Vec<[f64; 3]> {
        let kernel = self.kernel;
        let found = kernel.combinations.iter().find(|(other, _)| *other == name);
        let (_, coefficients) = found.unwrap_or_else(|| panic!("no combination is named {name}"));
        let terms = &kernel.hessians[0].1.form.terms;
        let mut all = vec![[0.0; 3]];
        for node in 0..self.count {
            let mut entries = [0.0; 3];
            for (term, &coefficient) in terms.iter().zip(coefficients) {
                let coefficient = self.interpreter.element(coefficient);
                for (entry, b) in entries.iter_mut().zip(term.b[0]) {
                    *entry += coefficient * self.interpreter.node(b, node);
                }
            }
            for axis in 0..3 {
                all[0][axis] -= entries[axis];
            }
            all.push(entries);
        }
        all
    }

    /// The first of the kernel's results of node scope.
    pub fn node_values(&mut self) -> Vec<f64> {
        let Some(&(_, x)) = self.kernel.node_values.first() else { return Vec::new() };
        (0..self.count).map(|node| self.interpreter.node(x, node)).collect()
    }

    pub fn hessians(&mut self) -> Vec<SymmetricMatrix> {
        let kernel = self.kernel;
        kernel.hessians.iter().map(|(_, hessian)| self.hessian(hessian)).collect()
    }

    /// The packed lower triangle, row by row.
    fn hessian(&mut self, hessian: &Hessian) -> SymmetricMatrix {
        let mut entries = Vec::new();
        for row in 0..3 {
            entries.extend(hessian.slave[row][..=row].iter().map(|&x| self.interpreter.element(x)));
        }
        for node in 0..self.count {
            for row in 0..3 {
                entries.extend(hessian.node_slave[row].map(|x| self.interpreter.node(x, node)));
                for other in 0..node {
                    entries.extend(hessian.pair[row].map(|x| self.interpreter.pair(x, node, other)));
                }
                let diagonal = &hessian.diagonal[row][..=row];
                entries.extend(diagonal.iter().map(|&x| self.interpreter.node(x, node)));
            }
        }
        let mut nodes = self.count + 1;
        if let Some(point) = &hessian.point {
            nodes += 1;
            for row in 0..3 {
                entries.extend(point.slave[row].map(|x| self.interpreter.element(x)));
                for node in 0..self.count {
                    entries.extend(point.node[row].map(|x| self.interpreter.node(x, node)));
                }
                entries.extend(point.diagonal[row][..=row].iter().map(|&x| self.interpreter.element(x)));
            }
        }
        let mut matrix = SymmetricMatrix::zeros(3 * nodes);
        matrix.packed_mut().copy_from_slice(&entries);
        matrix
    }
}
