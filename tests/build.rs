//! Kernels for weights of one's own; see `tests/custom_weight.rs`.
use diffuse_contact_codegen::{Basis, Config, ConfigError};

fn main() -> Result<(), ConfigError> {
    Config::new()
        .weight("wendland", "(1 - r)^4 * (1 + 4*r)")?
        .weight("matern", "exp(-r) * (1 + r) * (1 - r^2)^2 / sqrt(1 + 3*r^2)")?
        .weight("spline", "if r < 0.5 { 2/3 - 4*r^2 + 4*r^3 } else { 4/3*(1 - r)^3 }")?
        .nodes(Basis::Quadratic, 7..=7)?
        .nodes(Basis::Linear, 4..=4)?
        .compile()
        .map(|_| ())
}
