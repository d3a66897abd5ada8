//! Direct solution for the free equations.

use std::sync::Arc;

use faer::Par;
use faer::sparse::linalg::LuError;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};

use super::condition::{norm, scale, weakness};
use super::factor::{GeneralFactor, SymmetricFactor};
use super::{BlockMatrix, BlockPattern, Equations, SystemError};

/// Below this many equations threads cost more than they bring.
const PARALLEL_FROM: usize = 6000;
/// A residual, relative to the right-hand side, that needs no refinement.
const REFINED: f64 = 1e-10;
const MAX_REFINEMENTS: usize = 2;
/// A relative residual above this is no solution, unless rounding of K x explains it.
const ACCEPTABLE: f64 = 1e-6;
/// Rounding of K x is at most this part of |K| |x|. A slender body that bends answers small loads with large forces that cancel.
const ROUNDING: f64 = 100.0 * f64::EPSILON;
/// Ratio of a pivot to its diagonal entry below which it may be a zero that rounding hides.
const SMALL_PIVOT: f64 = 1e-13;
/// A direction that the matrix makes less of is one of rounding: nine times the machine's precision.
const SINGULAR: f64 = 2e-15;

/// What is known of the matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// It is symmetric, definite or not; the lower triangle is read.
    Symmetric,
    /// Only its pattern is symmetric.
    General,
}

/// Which factorisation a solution comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// L B Lᵀ, pivots chosen within supernodes.
    Symmetric,
    /// L U with partial pivoting.
    General,
}

/// How a solution went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveReport {
    /// ‖D (b − K x)‖ / ‖D b‖ in the Euclidean norm, with the D that makes rows and columns of D K D about the same size.
    pub residual: f64,
    /// The factorisation that was used: General for a symmetric matrix if the other was not good enough.
    pub method: Method,
    /// Eigenvalues of the matrix below 0; `None` where only general factors are known.
    pub negative: Option<usize>,
}

impl SolveReport {
    /// The residual if it is small only beside rounding of K x: the matrix may be of a loose body, far from the origin.
    pub fn rounded(&self) -> Option<f64> {
        (!(self.residual <= ACCEPTABLE)).then_some(self.residual)
    }
}

/// Factorises matrices and solves systems with them, one after the other: what depends on the pattern only is kept while
/// pattern and equations stay the same. With a given number of threads results are the same always.
#[derive(Default)]
pub struct DirectSolver {
    threads: usize,
    structure: Option<Structure>,
    symmetric: Option<SymmetricFactor>,
    general: Option<GeneralFactor>,
    /// Entries of the free part, column by column, of D K D.
    values: Vec<f64>,
    /// D, for rows and columns of about the same size.
    scale: Vec<f64>,
    /// The least that the matrix makes of a direction.
    weakness: f64,
    /// The factors that are those of `values`.
    current: Option<Method>,
    rhs: Vec<f64>,
    solution: Vec<f64>,
    residual: Vec<f64>,
    candidate: Vec<f64>,
}

/// The free part's pattern in compressed columns.
struct Structure {
    pattern: Arc<BlockPattern>,
    equations: Equations,
    starts: Vec<u32>,
    rows: Vec<u32>,
    /// Where each entry is among those of the block matrix: block, row axis, column axis.
    sources: Vec<(u32, u8, u8)>,
}

impl DirectSolver {
    /// `threads` at most, those of rayon's global pool; 0 and 1 are one. Small systems are solved by one.
    pub fn new(threads: usize) -> Self {
        Self { threads, ..Self::default() }
    }

    /// Factorises the part of `matrix` that belongs to the free equations.
    ///
    /// # Errors
    /// An entry that is not finite, a matrix that is singular, factors too large.
    pub fn factorise(
        &mut self,
        matrix: &BlockMatrix,
        equations: &Equations,
        symmetry: Symmetry,
    ) -> Result<(), SystemError> {
        self.current = None;
        if equations.nodes() != matrix.pattern().nodes() {
            let (given, expected) = (equations.nodes(), matrix.pattern().nodes());
            return Err(SystemError::WrongCount { what: "nodes with equations", given, expected });
        }
        if !self.structure.as_ref().is_some_and(|structure| structure.is_of(matrix.pattern(), equations)) {
            self.symmetric = None;
            self.general = None;
            self.structure = Some(Structure::new(matrix.pattern(), equations)?);
        }
        let Some(structure) = &self.structure else { unreachable!("it was made above") };
        structure.gather(matrix, &mut self.values)?;
        self.scale = scale(structure.matrix(&self.values));
        structure.scale(&mut self.values, &self.scale);
        if equations.is_empty() {
            self.current = Some(Method::Symmetric);
            return Ok(());
        }
        match symmetry {
            Symmetry::Symmetric => {
                if !self.factorise_symmetric()? {
                    self.factorise_general(1.0)?;
                }
            }
            Symmetry::General => self.factorise_general(1.0)?,
        }
        Ok(())
    }

    /// Solves K x = b with the matrix factorised last, with up to two steps of iterative refinement. `rhs` and `solution` are
    /// over all nodes; prescribed ones are not read, and 0 in the solution.
    ///
    /// If the symmetric factors are not good enough the general ones are made and used.
    ///
    /// # Errors
    /// A right-hand side that is not finite; no factors; a matrix found to be singular. Then `solution` is of no use.
    pub fn solve(
        &mut self,
        rhs: &[[f64; 3]],
        solution: &mut Vec<[f64; 3]>,
    ) -> Result<SolveReport, SystemError> {
        let Some(structure) = &self.structure else { return Err(SystemError::NotFactorised) };
        let nodes = structure.equations.nodes();
        if rhs.len() != nodes {
            return Err(SystemError::WrongCount {
                what: "right-hand sides",
                given: rhs.len(),
                expected: nodes,
            });
        }
        structure.equations.gather(rhs, &mut self.rhs);
        if let Some(equation) = self.rhs.iter().position(|value| !value.is_finite()) {
            return Err(structure.not_finite(equation, self.rhs[equation]));
        }
        let Some(mut method) = self.current else { return Err(SystemError::NotFactorised) };
        if self.rhs.is_empty() {
            structure.equations.scatter(&[], solution);
            return Ok(SolveReport { residual: 0.0, method, negative: Some(0) });
        }
        self.rhs.iter_mut().zip(&self.scale).for_each(|(b, d)| *b *= d);
        let mut report = self.solve_refined(method)?;
        if method == Method::Symmetric && !self.is_acceptable(report.residual) {
            self.factorise_general(report.residual)?;
            method = Method::General;
            report = self.solve_refined(method)?;
        }
        if !self.is_acceptable(report.residual) {
            self.current = None;
            return Err(self.singular(report.residual));
        }
        self.solution.iter_mut().zip(&self.scale).for_each(|(x, d)| *x *= d);
        if let Some(structure) = &self.structure {
            structure.equations.scatter(&self.solution, solution);
        }
        Ok(report)
    }

    /// Whether the symmetric factors are made and may be used.
    fn factorise_symmetric(&mut self) -> Result<bool, SystemError> {
        let par = self.parallelism();
        let Some(structure) = &self.structure else { unreachable!("it was made before its factors") };
        let too_large = SystemError::TooLarge { equations: structure.equations.len() };
        // There need not be memory for both.
        self.general.iter_mut().for_each(GeneralFactor::release);
        let factor = match &mut self.symmetric {
            Some(factor) => factor,
            none => none.insert(SymmetricFactor::new(structure.symbolic()).map_err(|_| too_large)?),
        };
        factor.factorise(structure.matrix(&self.values), par).map_err(|_| too_large)?;
        if factor.smallest_pivot(&structure.diagonal(&self.values)) < SMALL_PIVOT {
            return Ok(false);
        }
        // Rounding may leave a pivot larger than that where there should be none.
        let matrix = structure.matrix(&self.values);
        self.weakness = weakness(matrix, |x| factor.solve(x, par)).map_err(|_| too_large)?;
        // What is no number says something of the factors only.
        if self.weakness <= SINGULAR {
            return Err(self.singular(1.0));
        }
        let is_sound = self.weakness.is_finite();
        self.current = is_sound.then_some(Method::Symmetric);
        Ok(is_sound)
    }

    /// Makes the general factors and looks for the weakest direction. `residual` is what was achieved without them.
    fn factorise_general(&mut self, residual: f64) -> Result<(), SystemError> {
        self.current = None;
        let par = self.parallelism();
        let Some(structure) = &self.structure else { unreachable!("it was made before its factors") };
        let too_large = SystemError::TooLarge { equations: structure.equations.len() };
        self.symmetric.iter_mut().for_each(SymmetricFactor::release);
        let factor = match &mut self.general {
            Some(factor) => factor,
            none => none.insert(GeneralFactor::new(structure.symbolic()).map_err(|_| too_large)?),
        };
        match factor.factorise(structure.matrix(&self.values), par) {
            Ok(()) => {}
            Err(LuError::SymbolicSingular { .. }) => {
                self.weakness = 0.0;
                return Err(self.singular(residual));
            }
            Err(LuError::Generic(_)) => return Err(too_large),
        }
        let matrix = structure.matrix(&self.values);
        self.weakness = weakness(matrix, |x| factor.solve(x, par)).map_err(|_| too_large)?;
        if !(self.weakness > SINGULAR && self.weakness.is_finite()) {
            return Err(self.singular(residual));
        }
        self.current = Some(Method::General);
        Ok(())
    }

    /// Solves into `solution`, refines while that helps.
    fn solve_refined(&mut self, method: Method) -> Result<SolveReport, SystemError> {
        let par = self.parallelism();
        let Some(structure) = &self.structure else { unreachable!("there are factors of this structure") };
        let too_large = SystemError::TooLarge { equations: structure.equations.len() };
        let scale = norm(&self.rhs);
        self.solution.clear();
        self.solution.resize(self.rhs.len(), 0.0);
        if scale == 0.0 {
            return Ok(SolveReport { residual: 0.0, method, negative: self.negative(method) });
        }
        let mut best = f64::INFINITY;
        self.residual.clone_from(&self.rhs);
        for _ in 0..=MAX_REFINEMENTS {
            match (method, &mut self.symmetric, &mut self.general) {
                (Method::Symmetric, Some(factor), _) => factor.solve(&mut self.residual, par),
                (Method::General, _, Some(factor)) => factor.solve(&mut self.residual, par),
                _ => unreachable!("there are factors of this method"),
            }
            .map_err(|_| too_large)?;
            self.candidate.clear();
            self.candidate
                .extend(self.solution.iter().zip(&self.residual).map(|(x, correction)| x + correction));
            structure.residual(&self.values, &self.candidate, &self.rhs, &mut self.residual);
            let residual = norm(&self.residual) / scale;
            // The first candidate is kept in any case, others if they are better; a NaN is not.
            if !(residual < best) {
                break;
            }
            best = residual;
            std::mem::swap(&mut self.solution, &mut self.candidate);
            if residual <= REFINED {
                break;
            }
        }
        Ok(SolveReport { residual: best, method, negative: self.negative(method) })
    }

    fn negative(&self, method: Method) -> Option<usize> {
        match method {
            Method::Symmetric => self.symmetric.as_ref().and_then(SymmetricFactor::negative),
            Method::General => None,
        }
    }

    /// Whether a relative residual is one of a solution.
    fn is_acceptable(&self, residual: f64) -> bool {
        if residual <= ACCEPTABLE {
            return true;
        }
        let Some(structure) = &self.structure else { return false };
        let moduli = structure.moduli(&self.values, &self.solution);
        residual * norm(&self.rhs) <= ROUNDING * norm(&moduli)
    }

    fn singular(&self, residual: f64) -> SystemError {
        let equations = self.structure.as_ref().map_or(0, |structure| structure.equations.len());
        let condition = if self.weakness.is_finite() { 1.0 / self.weakness } else { f64::INFINITY };
        SystemError::Singular { equations, residual, condition }
    }

    fn parallelism(&self) -> Par {
        let equations = self.structure.as_ref().map_or(0, |structure| structure.equations.len());
        match self.threads {
            0 | 1 => Par::Seq,
            _ if equations < PARALLEL_FROM => Par::Seq,
            threads => Par::rayon(threads),
        }
    }
}

impl Structure {
    fn new(pattern: &Arc<BlockPattern>, equations: &Equations) -> Result<Self, SystemError> {
        let mut starts = Vec::with_capacity(equations.len() + 1);
        let mut rows = Vec::new();
        let mut sources = Vec::new();
        starts.push(0);
        // The pattern is symmetric, so the nodes of a column are those of the row; the blocks are looked up.
        for equation in 0..equations.len() {
            let (column, axis) = equations.place(equation);
            for &node in pattern.row(column) {
                let node = node as usize;
                let block =
                    pattern.block(node, column).unwrap_or_else(|| unreachable!("patterns are symmetric"));
                for row_axis in 0..3 {
                    if let Some(row) = equations.number(node, row_axis) {
                        rows.push(row as u32);
                        sources.push((block as u32, row_axis as u8, axis as u8));
                    }
                }
            }
            starts.push(rows.len() as u32);
        }
        if u32::try_from(rows.len()).is_err() || u32::try_from(pattern.blocks()).is_err() {
            return Err(SystemError::TooLarge { equations: equations.len() });
        }
        Ok(Self { pattern: Arc::clone(pattern), equations: equations.clone(), starts, rows, sources })
    }

    fn is_of(&self, pattern: &Arc<BlockPattern>, equations: &Equations) -> bool {
        (Arc::ptr_eq(&self.pattern, pattern) || self.pattern == *pattern) && self.equations == *equations
    }

    fn symbolic(&self) -> SymbolicSparseColMatRef<'_, u32> {
        let size = self.equations.len();
        SymbolicSparseColMatRef::new_checked(size, size, &self.starts, None, &self.rows)
    }

    fn matrix<'a>(&'a self, values: &'a [f64]) -> SparseColMatRef<'a, u32, f64> {
        SparseColMatRef::new(self.symbolic(), values)
    }

    fn gather(&self, matrix: &BlockMatrix, values: &mut Vec<f64>) -> Result<(), SystemError> {
        let blocks = matrix.blocks();
        values.clear();
        values
            .extend(self.sources.iter().map(|&(block, i, j)| blocks[block as usize][i as usize][j as usize]));
        match values.iter().position(|value| !value.is_finite()) {
            Some(entry) => Err(self.not_finite(self.rows[entry] as usize, values[entry])),
            None => Ok(()),
        }
    }

    /// K ← D K D
    fn scale(&self, values: &mut [f64], scale: &[f64]) {
        for (column, entries) in self.columns() {
            for (value, &row) in values[entries.clone()].iter_mut().zip(&self.rows[entries]) {
                *value *= scale[row as usize] * scale[column];
            }
        }
    }

    fn not_finite(&self, equation: usize, value: f64) -> SystemError {
        let (node, axis) = self.equations.place(equation);
        SystemError::NotFinite { equation, node, axis, value }
    }

    fn columns(&self) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> {
        self.starts.windows(2).map(|ends| ends[0] as usize..ends[1] as usize).enumerate()
    }

    fn diagonal(&self, values: &[f64]) -> Vec<f64> {
        self.columns()
            .map(|(column, entries)| {
                let place = self.rows[entries.clone()].binary_search(&(column as u32));
                place.map_or(0.0, |place| values[entries.start + place])
            })
            .collect()
    }

    /// |K| |x|
    fn moduli(&self, values: &[f64], x: &[f64]) -> Vec<f64> {
        let mut moduli = vec![0.0; x.len()];
        for (column, entries) in self.columns() {
            for entry in entries {
                moduli[self.rows[entry] as usize] += (values[entry] * x[column]).abs();
            }
        }
        moduli
    }

    /// b − K x
    fn residual(&self, values: &[f64], x: &[f64], b: &[f64], residual: &mut Vec<f64>) {
        residual.clear();
        residual.extend_from_slice(b);
        for (column, entries) in self.columns() {
            for entry in entries {
                residual[self.rows[entry] as usize] -= values[entry] * x[column];
            }
        }
    }
}
