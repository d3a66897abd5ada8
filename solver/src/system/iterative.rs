//! Krylov's methods for the free equations, preconditioned by [`Preconditioner`].

use super::multigrid::{add_scaled, dot, norm, scale_and_add};
use super::preconditioner::Preconditioner;
use super::{BlockMatrix, Equations, LinearSystem, Operator, Symmetry, SystemError};

/// Most iterations, of both methods together.
const MAX_ITERATIONS: usize = 500;
/// Directions that GMRES keeps before it starts again.
const RESTART: usize = 60;
/// GMRES has to gain at least this factor in a cycle.
const GAIN: f64 = 0.9;

/// The least size of a right-hand side, over its norm: what is less is rounding of stiff contact.
const LEAST_SIZE: f64 = 1e-5;

/// How accurate an iterative solution is to be: its residual over the *size* of the right-hand side, which is its norm without what stiff
/// contact takes up by itself.
///
/// A trial state penetrates, and a stiff penalty makes contact forces of it that are many times those of equilibrium. The next step
/// takes them away; how it moves the bodies depends on the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Accuracy {
    /// The residual may never be more than this part, …
    pub loosest: f64,
    /// … and need not be less than this one.
    pub tightest: f64,
    /// The size in the Newton iteration before. Of a gain in size the residual may be 0.9 times the square.
    pub before: Option<f64>,
}

impl Accuracy {
    /// This one.
    pub const fn fixed(tolerance: f64) -> Self {
        Self::between(tolerance, tolerance)
    }

    /// Never more than `loosest`, and no less than `tightest`.
    pub const fn between(loosest: f64, tightest: f64) -> Self {
        Self { loosest, tightest, before: None }
    }

    /// As accurate as the gain since a Newton iteration with a right-hand side of this size deserves.
    #[must_use]
    pub const fn after(self, before: Option<f64>) -> Self {
        Self { before, ..self }
    }

    /// Of a right-hand side of this size.
    fn of(&self, size: f64) -> f64 {
        let gain = self.before.map_or(1.0, |before| size / before);
        (0.9 * gain * gain).min(self.loosest).max(self.tightest)
    }
}

/// How an iterative solution went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IterativeReport {
    /// ‖b − K x‖ over the size of b, in the Euclidean norm.
    pub residual: f64,
    /// The size of b: its norm, or less where stiff contact takes up most of it.
    pub size: f64,
    /// Iterations, of conjugate gradients and GMRES together.
    pub iterations: usize,
    /// Whether GMRES was used: the matrix is not symmetric, or not definite.
    pub general: bool,
    /// Levels of the preconditioner.
    pub levels: usize,
    /// Memory of the matrix, the preconditioner and the vectors, bytes.
    pub bytes: usize,
}

/// A system on its way.
struct System<'a> {
    matrix: &'a BlockMatrix,
    operator: Option<&'a dyn Operator>,
    equations: &'a Equations,
    preconditioner: Preconditioner,
    x: Vec<[f64; 3]>,
    residual: Vec<[f64; 3]>,
    /// The norm that the residual has to reach.
    target: f64,
    iterations: usize,
}

/// Solves K x = b for the free equations as accurately as asked. Conjugate gradients are tried where K is symmetric; where it is
/// not, or shows not to be definite, GMRES goes on. The preconditioner is that of the assembled matrix, also where an operator is added
/// to it. `rhs` and `x` are over all nodes; prescribed ones are not read, and 0 in `x`.
///
/// # Errors
/// An entry that is not finite; a preconditioner that is singular; [`SystemError::NotConverged`].
pub fn solve_iteratively(
    system: &LinearSystem<'_>,
    rhs: &[[f64; 3]],
    accuracy: Accuracy,
    x: &mut Vec<[f64; 3]>,
) -> Result<IterativeReport, SystemError> {
    let &LinearSystem { matrix, operator, equations, symmetry, geometry, .. } = system;
    let residual = checked(matrix, equations, rhs)?;
    let nodes = rhs.len();
    let scale = norm(&residual);
    x.clear();
    x.resize(nodes, [0.0; 3]);
    if scale == 0.0 || equations.is_empty() {
        return Ok(IterativeReport {
            residual: 0.0,
            size: scale,
            iterations: 0,
            general: false,
            levels: 0,
            bytes: 0,
        });
    }
    let mut preconditioner = Preconditioner::new(matrix, equations, symmetry, geometry)?;
    let size = preconditioner.left(equations, &residual)?.max(LEAST_SIZE * scale).min(scale);
    let tolerance = accuracy.of(size);
    let target = tolerance * size;
    let x_start = std::mem::take(x);
    let mut system =
        System { matrix, operator, equations, preconditioner, x: x_start, residual, target, iterations: 0 };
    let is_done = symmetry == Symmetry::Symmetric && system.conjugate_gradients()?;
    if !is_done {
        system.gmres()?;
    }
    // What the methods carry along has drifted.
    let mut product = vec![[0.0; 3]; nodes];
    system.multiply(&system.x, &mut product)?;
    system.residual.copy_from_slice(rhs);
    equations.clear_prescribed(&mut system.residual);
    add_scaled(&mut system.residual, -1.0, &product);
    let report = IterativeReport {
        residual: norm(&system.residual) / size,
        size,
        iterations: system.iterations,
        general: !is_done,
        levels: system.preconditioner.levels(),
        bytes: system.bytes(!is_done),
    };
    if !(report.residual <= 2.0 * tolerance) {
        let IterativeReport { residual, iterations, .. } = report;
        return Err(SystemError::NotConverged {
            equations: equations.len(),
            residual,
            iterations,
            tolerance,
        });
    }
    *x = system.x;
    Ok(report)
}

/// The free part of a right-hand side, if all fits together and is finite.
fn checked(
    matrix: &BlockMatrix,
    equations: &Equations,
    rhs: &[[f64; 3]],
) -> Result<Vec<[f64; 3]>, SystemError> {
    let nodes = matrix.pattern().nodes();
    for (what, given) in [("nodes with equations", equations.nodes()), ("right-hand sides", rhs.len())] {
        if given != nodes {
            return Err(SystemError::WrongCount { what, given, expected: nodes });
        }
    }
    matrix.check_finite(equations)?;
    let mut residual = rhs.to_vec();
    equations.clear_prescribed(&mut residual);
    if let Some(free) = residual.as_flattened().iter().position(|value| !value.is_finite()) {
        let (node, axis, value) = (free / 3, free % 3, residual[free / 3][free % 3]);
        let equation = equations.number(node, axis).unwrap_or(0);
        return Err(SystemError::NotFinite { equation, node, axis, value });
    }
    Ok(residual)
}

impl System<'_> {
    /// y = K x among the free equations.
    fn multiply(&self, x: &[[f64; 3]], y: &mut [[f64; 3]]) -> Result<(), SystemError> {
        self.matrix.multiply(x, y);
        if let Some(operator) = self.operator {
            operator.add_product(x, y).map_err(|(entry, value)| {
                let (node, axis) = (entry / 3, entry % 3);
                let equation = self.equations.number(node, axis).unwrap_or(0);
                SystemError::NotFinite { equation, node, axis, value }
            })?;
        }
        self.equations.clear_prescribed(y);
        Ok(())
    }

    /// r ← r − K Δx for a step Δx, which is added to x.
    fn take(&mut self, step: &[[f64; 3]]) -> Result<(), SystemError> {
        add_scaled(&mut self.x, 1.0, step);
        let mut product = vec![[0.0; 3]; step.len()];
        self.multiply(step, &mut product)?;
        add_scaled(&mut self.residual, -1.0, &product);
        Ok(())
    }

    /// Whether the residual is small enough; else the matrix is not definite, or there are no more iterations. Leaves the best there is.
    fn conjugate_gradients(&mut self) -> Result<bool, SystemError> {
        let mut direction: Vec<[f64; 3]> = Vec::new();
        let mut product = vec![[0.0; 3]; self.x.len()];
        let mut before = 0.0;
        while self.iterations < MAX_ITERATIONS {
            if norm(&self.residual) <= self.target {
                return Ok(true);
            }
            let z = self.preconditioner.apply(self.matrix, self.equations, &self.residual)?;
            let now = dot(&self.residual, &z);
            if direction.is_empty() {
                direction = z;
            } else {
                scale_and_add(&mut direction, now / before, &z);
            }
            self.multiply(&direction, &mut product)?;
            let curvature = dot(&direction, &product);
            if !(now > 0.0 && curvature > 0.0) {
                return Ok(false);
            }
            let length = now / curvature;
            add_scaled(&mut self.x, length, &direction);
            add_scaled(&mut self.residual, -length, &product);
            before = now;
            self.iterations += 1;
        }
        Ok(false)
    }
}

/// The least squares problem of GMRES, kept triangular by rotations.
#[derive(Default)]
struct LeastSquares {
    /// Columns of the triangle.
    columns: Vec<Vec<f64>>,
    rotations: Vec<[f64; 2]>,
    right: Vec<f64>,
}

impl LeastSquares {
    /// With another column; the norm of the residual then.
    fn push(&mut self, mut column: Vec<f64>, below: f64) -> f64 {
        for (k, &[c, s]) in self.rotations.iter().enumerate() {
            let (a, b) = (column[k], column[k + 1]);
            (column[k], column[k + 1]) = (c * a + s * b, c * b - s * a);
        }
        let last = column.len() - 1;
        let size = column[last].hypot(below);
        let [c, s] = if size > 0.0 { [column[last] / size, below / size] } else { [1.0, 0.0] };
        column[last] = size;
        self.columns.push(column);
        self.rotations.push([c, s]);
        let right = self.right[last];
        self.right[last] = c * right;
        self.right.push(-s * right);
        (s * right).abs()
    }

    /// The coefficients of the directions.
    fn solution(&self) -> Vec<f64> {
        let count = self.columns.len();
        let mut y = self.right[..count].to_vec();
        for k in (0..count).rev() {
            let pivot = self.columns[k][k];
            y[k] = if pivot == 0.0 { 0.0 } else { y[k] / pivot };
            let value = y[k];
            (0..k).for_each(|row| y[row] -= self.columns[k][row] * value);
        }
        y
    }
}

impl System<'_> {
    /// With the preconditioner on the right, so that the residual it minimises is that of the equations. Leaves the best there is.
    fn gmres(&mut self) -> Result<(), SystemError> {
        loop {
            let before = norm(&self.residual);
            if before <= self.target || self.iterations >= MAX_ITERATIONS || !before.is_finite() {
                return Ok(());
            }
            self.gmres_cycle(before)?;
            if !(norm(&self.residual) < GAIN * before) {
                return Ok(());
            }
        }
    }

    fn gmres_cycle(&mut self, size: f64) -> Result<(), SystemError> {
        let mut least = LeastSquares { right: vec![size], ..LeastSquares::default() };
        let mut directions = vec![scaled(&self.residual, 1.0 / size)];
        let mut product = vec![[0.0; 3]; self.x.len()];
        while self.iterations < MAX_ITERATIONS && least.columns.len() < RESTART {
            let z =
                self.preconditioner.apply(self.matrix, self.equations, &directions[directions.len() - 1])?;
            self.multiply(&z, &mut product)?;
            let mut column = Vec::with_capacity(directions.len());
            for direction in &directions {
                let part = dot(direction, &product);
                add_scaled(&mut product, -part, direction);
                column.push(part);
            }
            let below = norm(&product);
            self.iterations += 1;
            let reached = least.push(column, below);
            if !(reached > self.target && below > 0.0) {
                break;
            }
            directions.push(scaled(&product, 1.0 / below));
        }
        let mut sum = vec![[0.0; 3]; self.x.len()];
        for (factor, direction) in least.solution().iter().zip(&directions) {
            add_scaled(&mut sum, *factor, direction);
        }
        let step = self.preconditioner.apply(self.matrix, self.equations, &sum)?;
        self.take(&step)
    }

    /// Memory of matrix, operator, preconditioner and vectors, bytes.
    fn bytes(&self, general: bool) -> usize {
        let vectors = if general { RESTART.min(self.iterations) + 5 } else { 5 };
        self.matrix.bytes()
            + self.operator.map_or(0, Operator::bytes)
            + self.preconditioner.bytes()
            + vectors * self.x.len() * size_of::<[f64; 3]>()
    }
}

fn scaled(x: &[[f64; 3]], factor: f64) -> Vec<[f64; 3]> {
    x.iter().map(|x| x.map(|x| factor * x)).collect()
}
