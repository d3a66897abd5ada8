//! The defaults that the header states are those that dc_options_default sets.

use std::collections::BTreeMap;

use super::options;
use crate::options::dc_options;

const HEADER: &str = include_str!("../../include/diffuse_contact.h");

/// Each field of dc_options in the header with its comment.
fn documented() -> Vec<(String, String)> {
    let (_, from) = HEADER.split_once("typedef struct dc_options {").expect("dc_options");
    let (body, _) = from.split_once("} dc_options;").expect("its end");
    let mut comment = String::new();
    let mut fields = Vec::new();
    for line in body.lines().map(str::trim).filter(|line| !line.is_empty()) {
        if let Some(said) = line.strip_prefix("//") {
            comment.push_str(said);
            continue;
        }
        let (_, name) = line.trim_end_matches(';').rsplit_once(' ').expect("type and name");
        fields.push((name.to_owned(), std::mem::take(&mut comment)));
    }
    fields
}

/// What an enumerator of the header stands for.
fn enumerator(name: &str) -> Option<f64> {
    let lines = HEADER.lines().filter_map(|line| line.trim().strip_suffix(',')?.split_once(" = "));
    lines.into_iter().find(|(found, _)| *found == name).and_then(|(_, value)| value.parse().ok())
}

/// The fields of a structure by name, as numbers.
macro_rules! fields {
    ($structure:expr, $($field:ident),* $(,)?) => {{
        // Without `..`, so that none is forgotten.
        let dc_options { size: _, reserved: _, $($field),* } = $structure;
        BTreeMap::from([$((stringify!($field).to_owned(), f64::from($field))),*])
    }};
}

#[test]
fn the_header_states_the_defaults() {
    let mut set = fields!(
        options(),
        element,
        weight,
        frame,
        rule,
        layers,
        max_layers,
        nearest,
        max_nearest,
        candidates,
        max_candidates,
        basis,
        linear_fallback,
        areas,
        smallest_regularity,
        radius_factor,
        feature_angle_degrees,
        border_tolerance,
        distance_limit,
        cutback_penetration,
    );
    for (name, comment) in documented() {
        if name == "size" || name == "reserved" {
            continue;
        }
        let (_, stated) = comment.split_once("Default: ").unwrap_or_else(|| panic!("{name}: {comment}"));
        let stated = stated.trim_end_matches('.');
        let value = enumerator(stated).or_else(|| stated.parse().ok());
        assert_eq!(value, set.remove(&name), "{name}: the header says {stated}");
    }
    assert!(set.is_empty(), "not in the header: {set:?}");
}
