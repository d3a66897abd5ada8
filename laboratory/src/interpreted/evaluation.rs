//! Results of one kernel at one element.

use diffuse_contact::{Element, ElementError, Gap, SymmetricMatrix};
use diffuse_contact_codegen::graph::ExprId;
use diffuse_contact_codegen::interpret::Interpreter;
use diffuse_contact_codegen::structure::{Gradient, LowRankForm};
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
        let terms = &kernel.hessians[0].1.terms;
        let mut all = vec![[0.0; 3]];
        for node in 0..self.count {
            let mut entries = [0.0; 3];
            for (term, &coefficient) in terms.iter().zip(coefficients) {
                let coefficient = self.interpreter.element(coefficient);
                for (entry, b) in entries.iter_mut().zip(term.b) {
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

    /// The products of the form's rows, one by one: slave, nodes, and a point if there is one.
    fn hessian(&mut self, form: &LowRankForm) -> SymmetricMatrix {
        let vector = |of: [ExprId; 3], at: &mut dyn FnMut(ExprId) -> f64| of.map(at);
        let (mut b, mut c, mut own) = (Vec::new(), Vec::new(), Vec::new());
        for node in 0..self.count {
            let mut at = |x| self.interpreter.node(x, node);
            b.push(form.terms.iter().map(|term| vector(term.b, &mut at)).collect::<Vec<_>>());
            c.push(form.terms.iter().map(|term| vector(term.c, &mut at)).collect::<Vec<_>>());
            own.push(form.own.map(|row| vector(row, &mut at)));
        }
        if let Some(point) = &form.point {
            let mut at = |x| self.interpreter.element(x);
            b.push(vec![[0.0; 3]; form.terms.len()]);
            c.push(point.c.iter().map(|&row| vector(row, &mut at)).collect());
            own.push(point.own.map(|row| vector(row, &mut at)));
        }
        // The slave's rows and its own block follow from those of all others.
        let slave = |rows: &[Vec<[f64; 3]>], term: usize| {
            [0, 1, 2].map(|axis| -rows.iter().map(|row| row[term][axis]).sum::<f64>())
        };
        let of_slave = |rows: &[Vec<[f64; 3]>]| (0..form.terms.len()).map(|term| slave(rows, term)).collect();
        let (b_slave, c_slave) = (of_slave(&b), of_slave(&c));
        b.insert(0, b_slave);
        c.insert(0, c_slave);
        let own_block = |row: usize, column: usize, i: usize, j: usize| match (row, column) {
            (0, 0) => own.iter().map(|block| block[i][j]).sum(),
            (node, 0) => -own[node - 1][i][j],
            (node, other) if node == other => own[node - 1][i][j],
            _ => 0.0,
        };
        let mut entries = Vec::new();
        for (row, i) in (0..b.len()).flat_map(|row| [0, 1, 2].map(|i| (row, i))) {
            for (column, j) in (0..=row).flat_map(|column| [0, 1, 2].map(|j| (column, j))) {
                if column < row || j <= i {
                    let products = (0..form.terms.len())
                        .map(|k| c[row][k][i] * b[column][k][j] + b[row][k][i] * c[column][k][j]);
                    entries.push(own_block(row, column, i, j) + products.sum::<f64>());
                }
            }
        }
        let mut matrix = SymmetricMatrix::zeros(3 * b.len());
        matrix.packed_mut().copy_from_slice(&entries);
        matrix
    }
}
