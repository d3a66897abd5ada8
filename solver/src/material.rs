//! Hencky elasticity with multiplicative J2 plasticity.

/// Constants of an isotropic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus E, force per area.
    pub young: f64,
    /// Poisson's ratio ν, −1 < ν < 0.5.
    pub poisson: f64,
    /// `None`: elastic.
    pub plasticity: Option<Plasticity>,
}

/// Von Mises plasticity with linear isotropic hardening: the yield stress is σ_y + H p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plasticity {
    /// σ_y, force per area.
    pub yield_stress: f64,
    /// H ≥ 0, force per area.
    pub hardening: f64,
}
