//! The law of a material: the volumetric part by itself, the isochoric one in principal axes.

use diffuse_contact_kernels::support::Mode;
use diffuse_contact_kernels::{volumetric_hencky, volumetric_neo_hooke};
use nalgebra::{Matrix3, Vector3};

use super::eigen::symmetric_eigen;
use super::{Hencky, Material, MaterialError, MaterialModel, NeoHooke, PointState};

/// The law of one [`Material`]. Energies are per reference volume and stresses are those of Kirchhoff, force per reference area.
#[derive(Clone, Copy, Debug)]
pub struct Law {
    bulk: f64,
    shear: f64,
    model: Model,
}

#[derive(Clone, Copy, Debug)]
enum Model {
    Hencky(Hencky),
    NeoHooke(NeoHooke),
}

/// The isochoric answer of a point, in the principal axes of its trial strain b = F C_p⁻¹ Fᵀ.
#[derive(Clone, Copy, Debug)]
pub struct Isochoric {
    /// Principal axes as columns.
    pub axes: Matrix3<f64>,
    /// Principal values τ_A of the deviatoric Kirchhoff stress; they add up to 0.
    pub stress: Vector3<f64>,
    /// ∂τ_A/∂ε_B − 2 τ_A δ_AB by the principal logarithmic strains of the trial: the spatial tangent's components AABB. Symmetric.
    pub normal: Matrix3<f64>,
    /// (τ_A λ_B² − τ_B λ_A²)/(λ_A² − λ_B²), the spatial tangent's components ABAB, entry k for the axes A, B ≠ k. λ are
    /// the trial stretches; they may be equal.
    pub shear: Vector3<f64>,
    /// The state that the step ends in.
    pub state: PointState,
    /// The stored energy.
    pub energy: f64,
}

/// The volumetric answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volumetric {
    /// U.
    pub energy: f64,
    /// U': the mean Cauchy stress, positive in tension.
    pub pressure: f64,
    /// U''.
    pub stiffness: f64,
}

/// F C_p⁻¹ Fᵀ is not positive definite in floating point: a stretch is lost beside another or is no length any more, or
/// the state is no metric.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the squares of the principal stretches are {squares:?}")]
pub struct Unresolved {
    /// As far as they were computed.
    pub squares: [f64; 3],
}

impl Law {
    /// # Errors
    /// Those of [`Material::check`].
    pub fn new(material: &Material) -> Result<Self, MaterialError> {
        material.check()?;
        let (bulk, shear) = (material.bulk_modulus(), material.shear_modulus());
        let model = match material.model {
            MaterialModel::Hencky { plasticity } => Model::Hencky(Hencky::new(shear, plasticity)),
            MaterialModel::NeoHooke => Model::NeoHooke(NeoHooke::new(shear)),
        };
        Ok(Self { bulk, shear, model })
    }

    /// κ + 4/3 μ, force per area: the stiffness against a strain along one axis alone.
    pub fn longitudinal_modulus(&self) -> f64 {
        self.bulk + 4.0 / 3.0 * self.shear
    }

    /// E, force per area.
    pub fn young_modulus(&self) -> f64 {
        9.0 * self.bulk * self.shear / (3.0 * self.bulk + self.shear)
    }

    /// `volume_ratio` θ > 0.
    #[inline]
    pub fn volumetric(&self, volume_ratio: f64) -> Volumetric {
        let bulk_modulus = self.bulk;
        macro_rules! by {
            ($kernel:ident) => {{
                let results =
                    $kernel::evaluate(Mode::Hessian, &$kernel::Inputs { volume_ratio, bulk_modulus });
                let ([pressure], [stiffness]) = (results.gradient, results.hessian);
                Volumetric { energy: results.values.energy, pressure, stiffness }
            }};
        }
        match self.model {
            Model::Hencky(_) => by!(volumetric_hencky),
            Model::NeoHooke(_) => by!(volumetric_neo_hooke),
        }
    }

    /// Step from `committed` to the deformation gradient F, det F > 0.
    ///
    /// # Errors
    /// If a trial stretch is not a number between 1e-70 and 1e70.
    #[inline]
    pub fn isochoric(
        &self,
        deformation_gradient: &Matrix3<f64>,
        committed: &PointState,
    ) -> Result<Isochoric, Unresolved> {
        match &self.model {
            Model::Hencky(law) => law.isochoric(deformation_gradient, committed),
            Model::NeoHooke(law) => law.isochoric(deformation_gradient, committed),
        }
    }
}

impl Isochoric {
    /// The deviatoric Kirchhoff stress in global axes.
    #[inline]
    pub fn kirchhoff(&self) -> Matrix3<f64> {
        let scaled = Matrix3::from_columns(&[0, 1, 2].map(|a| self.axes.column(a) * self.stress[a]));
        scaled * self.axes.transpose()
    }
}

/// Squares of the principal stretches of F G Fᵀ for a metric G, and its axes as columns.
#[inline]
pub(super) fn principal_stretches(
    deformation_gradient: &Matrix3<f64>,
    metric: &Matrix3<f64>,
) -> Result<(Vector3<f64>, Matrix3<f64>), Unresolved> {
    let (squares, axes) = symmetric_eigen(&congruence(deformation_gradient, metric));
    if squares.iter().all(|&square| square > 1e-140 && square < 1e140) {
        Ok((squares, axes))
    } else {
        Err(Unresolved { squares: squares.into() })
    }
}

/// A S Aᵀ for symmetric S, symmetric to the last bit. Written out, as the products of matrices are not always inlined.
#[inline]
pub(super) fn congruence(a: &Matrix3<f64>, s: &Matrix3<f64>) -> Matrix3<f64> {
    let mut half = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            half[i][j] = a[(i, 0)] * s[(0, j)] + a[(i, 1)] * s[(1, j)] + a[(i, 2)] * s[(2, j)];
        }
    }
    let mut result = Matrix3::zeros();
    for i in 0..3 {
        for j in 0..=i {
            let entry = half[i][0] * a[(j, 0)] + half[i][1] * a[(j, 1)] + half[i][2] * a[(j, 2)];
            result[(i, j)] = entry;
            result[(j, i)] = entry;
        }
    }
    result
}
