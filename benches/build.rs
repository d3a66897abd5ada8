//! Generates the solids that are compared with their rivals.
#![allow(non_snake_case)]

use diffuse_contact_codegen::{Config, ConfigError};

mod formulas;

fn main() -> Result<(), ConfigError> {
    Config::new().element("tet4", formulas::tet4)?.element("hex8", formulas::hex8)?.compile()?;
    Ok(())
}
