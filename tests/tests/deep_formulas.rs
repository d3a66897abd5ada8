//! Formulas nested deeper than a stack: an error, never an abort. In a program of its own, since an overflowing
//! stack takes all tests of a program with it.

use diffuse_contact_codegen::model::WeightError;
use diffuse_contact_codegen::{Config, ConfigError};

fn assert_refused(formula: &str) {
    let result = Config::new().weight("deep", formula);
    assert!(matches!(result, Err(ConfigError::Weight(WeightError::Formula(_)))));
}

#[test]
fn parentheses() {
    assert_refused(&("(".repeat(100_000) + "1 - r^2" + &")".repeat(100_000)));
    assert_refused(&"(".repeat(100_000));
}

#[test]
fn signs() {
    assert_refused(&("-".repeat(100_000) + "r^2"));
}

#[test]
fn branches() {
    assert_refused(&("if r < 2 { 1 } else ".repeat(20_000) + "{ 1 }"));
}

/// Long is not deep: accepted or refused, the program goes on.
#[test]
fn a_long_sum() {
    let _ = Config::new().weight("long", &("1".to_owned() + &" + r^2".repeat(100_000)));
}
