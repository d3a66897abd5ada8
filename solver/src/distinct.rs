//! Names that have to differ.

use std::collections::{HashMap, HashSet};

/// The names, with a number where there are several of one.
pub fn distinct(names: impl IntoIterator<Item = String>) -> Vec<String> {
    let (mut all, mut known, mut numbers) = (Vec::new(), HashSet::new(), HashMap::new());
    for given in names {
        let mut name = given.clone();
        // Goes on where the last of this name ended.
        let number = numbers.entry(given.clone()).or_insert(1);
        while !known.insert(name.clone()) {
            *number += 1;
            name = format!("{given} ({number})");
        }
        all.push(name);
    }
    all
}
