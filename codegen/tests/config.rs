//! What build scripts ask for.

use diffuse_contact_codegen::emit::MOST_STATEMENTS;
use diffuse_contact_codegen::expr::Expr;
use diffuse_contact_codegen::{Config, ConfigError, ElementModel};

#[test]
fn three_weights_share_kernels() {
    let config = Config::new()
        .cubic()
        .weight("quartic", "(1 - r)^3 * (1 + 3*r)")
        .unwrap()
        .cubic_interpolating()
        .wendland_c2()
        .share_kernels();
    let source = config.source().unwrap();
    assert!(source.contains("mod cubic_or_quartic_or_wendland_c2"));
    for module in
        ["pub mod cubic ", "pub mod quartic ", "pub mod wendland_c2 ", "pub mod cubic_interpolating "]
    {
        assert!(source.contains(module), "{module}");
    }
}

/// Two modules of one name would be code that does not compile.
#[test]
fn modules_that_the_generator_names_have_names_of_their_own() {
    let square = |m: &ElementModel<'_>| m.energy(m.variable::<Expr<'_>>("x").powi(2));
    let tested = |config: Config| config.element("a", square).unwrap().test("a", &[&[1.0]], &[]);
    let weight = |name| Config::new().weight(name, "(1 - r)^2 * (1 + 2*r)").unwrap();
    let shared = Config::new().cubic().wendland_c2().share_kernels();
    let both = |name| shared.clone().weight(name, "(1 - r)^3 * (1 + 3*r)").unwrap();
    for (config, expected) in [
        (tested(Config::new().element("a_tests", square).unwrap()), "a_tests"),
        (tested(weight("a_tests")), "a_tests"),
        (shared.clone().element("cubic_or_wendland_c2", square).unwrap(), "cubic_or_wendland_c2"),
        (both("cubic_or_wendland_c2"), "cubic_or_wendland_c2"),
    ] {
        let error = config.source().unwrap_err();
        assert!(matches!(&error, ConfigError::DuplicateModule { name } if name == expected), "{error}");
    }
    assert!(tested(weight("cubic_or_wendland_c2")).source().is_ok());
}

#[test]
fn a_weight_that_is_too_long_to_compile_is_named() {
    let long = |factor: &str| {
        let terms: Vec<String> =
            (10..38).map(|k| format!("exp(-{k}*r^2/{factor})/sqrt(1 + r^{k})")).collect();
        format!("(1 - r^2)^2 * ({})", terms.join(" + "))
    };
    let error = Config::new()
        .weight("long", &long("7"))
        .and_then(|config| config.weight("longer", &long("3")))
        .unwrap()
        .share_kernels()
        .source()
        .unwrap_err();
    let ConfigError::WeightTooLong { weight, statements, .. } = &error else { panic!("{error}") };
    assert!(weight == "long_or_longer" && *statements > MOST_STATEMENTS, "{error}");
}

/// `main` of a build script prints the error by `Debug`.
#[test]
fn an_error_of_a_build_script_points_at_the_character() {
    let error = Config::new().weight("quartic", "(1 - r)^3 * (1 + 3*r").unwrap_err();
    assert_eq!(format!("{error:?}"), error.to_string());
    let text = format!("{:?}", Box::<dyn std::error::Error>::from(error));
    assert!(text.contains("(1 - r)^3 * (1 + 3*r\n") && text.trim_end().ends_with('^'), "{text}");
}

/// A weight's kernel set would hide a type of the support module that has its name.
#[test]
fn no_weight_has_the_name_of_a_type_of_the_support_module() {
    let support = include_str!("../../generated/src/support/mod.rs");
    let exports = support.lines().filter_map(|line| line.strip_prefix("pub use "));
    let names = exports.flat_map(|line| line.split(|c: char| !c.is_alphanumeric()));
    let is_type = |name: &&str| name.starts_with(char::is_uppercase) && name.chars().any(char::is_lowercase);
    let types: Vec<&str> = names.filter(is_type).collect();
    assert!(types.contains(&"Second") && types.contains(&"KernelSet"));
    for name in types {
        let result = Config::new().weight(&name.to_lowercase(), "(1 - r)^2");
        assert!(matches!(result, Err(ConfigError::Weight(_))), "{name}");
    }
}
