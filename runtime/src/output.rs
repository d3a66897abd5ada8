//! What an element returns.

use crate::{Mode, Point};

/// A symmetric matrix of which the lower triangle is stored row by row: entry (i, j ≤ i) at i(i+1)/2 + j.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SymmetricMatrix {
    size: usize,
    packed: Vec<f64>,
}

impl SymmetricMatrix {
    /// A zero matrix with `size` rows.
    pub fn zeros(size: usize) -> Self {
        Self { size, packed: vec![0.0; size * (size + 1) / 2] }
    }

    /// The matrix with this lower triangle.
    pub(crate) fn of(size: usize, packed: &[f64]) -> Self {
        Self { size, packed: packed.to_vec() }
    }

    /// Number of rows; 0 when no Hessian was asked for.
    pub const fn size(&self) -> usize {
        self.size
    }

    /// Entry (row, column), either triangle.
    ///
    /// # Panics
    /// If an index is not below [`size`](Self::size).
    pub fn get(&self, row: usize, column: usize) -> f64 {
        assert!(row < self.size && column < self.size, "({row}, {column}) outside {0} × {0}", self.size);
        let (i, j) = if row >= column { (row, column) } else { (column, row) };
        self.packed[i * (i + 1) / 2 + j]
    }

    /// The packed lower triangle.
    pub fn packed(&self) -> &[f64] {
        &self.packed
    }

    /// The packed lower triangle, to be filled.
    pub fn packed_mut(&mut self) -> &mut [f64] {
        &mut self.packed
    }

    /// All rows written out.
    pub fn to_rows(&self) -> Vec<Vec<f64>> {
        (0..self.size).map(|i| (0..self.size).map(|j| self.get(i, j)).collect()).collect()
    }
}

/// Coefficients of the fit about the slave: height over the slave z(a, b) = α·(1, a, b, a², ab, b²), with a, b in
/// length units along t1, t2 and z along n̂, all measured from the slave. α has units length, 1, 1, 1/length, ….
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coefficients {
    /// α, one per basis function.
    pub values: Vec<f64>,
    /// ∂α_k/∂x: one vector of 3(n+1) per coefficient (empty in value mode).
    pub gradients: Vec<Vec<f64>>,
    /// ∂²α_k/∂x∂x: one symmetric matrix per coefficient (empty below Hessian mode).
    pub hessians: Vec<SymmetricMatrix>,
}

/// The fitted surface at one in-plane point: height f over the slave along n̂ and its derivatives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// f, length.
    pub value: f64,
    /// Slopes f_1, f_2 along t1, t2, dimensionless.
    pub slopes: [f64; 2],
    /// Second derivatives f_11, f_12, f_22, 1/length.
    pub curvatures: [f64; 3],
    /// ∇f = ∂f/∂x, 3(n+1) entries, dimensionless.
    pub gradient: Vec<f64>,
    /// T_1, T_2 of (38): ∂f_l/∂x, 3(n+1) entries each, 1/length.
    pub slope_gradients: [Vec<f64>; 2],
    /// H_f = ∂²f/∂x∂x, 3(n+1) square, 1/length.
    pub hessian: SymmetricMatrix,
}

/// Where an element touches, without derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactPoint {
    /// Signed gap g (19), length: positive apart, negative penetrating.
    pub gap: f64,
    /// Foot point on the master surface, global axes.
    pub foot: Point,
    /// Unit normal ν (22) of the surface at the foot, towards the outward side.
    pub normal: Point,
}

/// The contact quantities of one element.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gap {
    /// Signed gap g (19), length: positive apart, negative penetrating.
    pub gap: f64,
    /// Foot point x^d on the smooth surface, global axes.
    pub foot: Point,
    /// Unit normal ν (22) of the surface at the foot, towards the outward side.
    pub normal: Point,
    /// Coefficients α of the fit about the slave, as in [`Coefficients::values`].
    pub coefficients: Vec<f64>,
    /// N = ∂g/∂x (32), 3(n+1) entries, dimensionless.
    pub gradient: Vec<f64>,
    /// M = ∂²g/∂x∂x (42), 3(n+1) square, 1/length.
    pub hessian: SymmetricMatrix,
}

/// The contact quantities of one element with friction.
///
/// The *anchor* x^a is a material point of the master that the slave stuck to: an affine combination of master nodes. With
/// d = x^c − x^a and the unit normal ν at the foot of today, q = ½ |P_ν d|², P_ν = 1 − ν νᵀ, is half the square of the slip
/// (docs/equations.md, T16). Coordinates are ordered slave, masters, anchor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slip {
    /// Gap, foot and normal, N and M.
    pub contact: Gap,
    /// q, length². The slip is √(2q).
    pub half_square: f64,
    /// ∇q = ∂q/∂x, 3(n+2) entries, length.
    pub gradient: Vec<f64>,
    /// ∇²q = ∂²q/∂x∂x, 3(n+2) square, dimensionless.
    pub hessian: SymmetricMatrix,
    /// φ, one number per master: the foot is Σ φ_k x^k with Σ φ_k = 1 (T15). Empty in value mode.
    pub foot_weights: Vec<f64>,
}

impl Slip {
    /// The slip √(2q), length.
    pub fn length(&self) -> f64 {
        (2.0 * self.half_square).sqrt()
    }
}

impl Gap {
    /// Room for the derivatives that a mode asks for, by so many coordinates.
    pub(crate) fn room(mode: Mode, freedoms: usize) -> Self {
        let gradient = vec![0.0; if mode >= Mode::Gradient { freedoms } else { 0 }];
        let hessian = SymmetricMatrix::zeros(if mode >= Mode::Hessian { freedoms } else { 0 });
        Self { gradient, hessian, ..Self::default() }
    }

    /// Without derivatives.
    pub(crate) const fn point(&self) -> ContactPoint {
        ContactPoint { gap: self.gap, foot: self.foot, normal: self.normal }
    }

    /// Whether the slave penetrates, g < 0. Penalty forces act only then; [`contact_force`](Self::contact_force) and
    /// [`tangent`](Self::tangent) evaluate (33) and (43) for either sign and leave the choice to the caller.
    pub fn is_penetrating(&self) -> bool {
        self.gap < 0.0
    }

    /// Contact force of a penalty, −ε g N (Chamoret et al. 2008, eq. 33: R_c), on each node, 3(n+1) entries.
    ///
    /// `penalty` is ε, force per length. Without N, in value mode, it is empty.
    pub fn contact_force(&self, penalty: f64) -> Vec<f64> {
        self.gradient.iter().map(|n| -penalty * self.gap * n).collect()
    }

    /// Penalty tangent K_c = −∂R_c/∂x = ε (g M + N Nᵀ) (43), 3(n+1) square. Without M, below Hessian mode, it is 0 × 0.
    pub fn tangent(&self, penalty: f64) -> SymmetricMatrix {
        let mut tangent = SymmetricMatrix::zeros(self.hessian.size());
        let mut entries = tangent.packed.iter_mut().zip(&self.hessian.packed);
        for i in 0..self.hessian.size {
            for (j, (k, m)) in entries.by_ref().take(i + 1).enumerate() {
                *k = penalty * (self.gap * m + self.gradient[i] * self.gradient[j]);
            }
        }
        tangent
    }
}
