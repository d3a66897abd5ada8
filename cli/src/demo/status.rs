//! What became of a slave node, as a number for ParaView and as words for people.

use diffuse_contact::ElementError;

/// The element was evaluated and its slave faces the master surface.
pub const OK: i32 = 0;
/// The slave lies beyond the border of the master surface: its gap is extrapolated, there is no contact.
pub const BEYOND_BORDER: i32 = 12;
/// A reason this list does not know yet.
const OTHER: i32 = 99;

/// Every code but `OTHER`: number, name, meaning.
const CODES: [(i32, &str, &str); 14] = [
    (OK, "ok", "gap and normal are valid"),
    (1, "too-few-nodes", "fewer master nodes than the fit needs"),
    (2, "non-finite-input", "a coordinate is not a finite number"),
    (3, "invalid-support-radius", "all master nodes lie straight above or below the slave"),
    (4, "invalid-frame", "the local frame is not orthonormal"),
    (5, "ambiguous-outward", "the facets around do not tell which side is outside"),
    (6, "no-average-plane", "the master nodes lie on a line or are as thick as wide"),
    (7, "singular-fit", "the master nodes do not determine a quadratic surface"),
    (8, "foot-diverged", "no foot point was found on the smooth surface"),
    (9, "foot-outside", "the foot point lies outside the domain of influence"),
    (10, "centre-of-curvature", "the foot point is not unique"),
    (11, "overflow", "the numbers overflow"),
    (BEYOND_BORDER, "beyond-border", "the slave does not face the master surface"),
    (13, "beyond-centre-of-curvature", "the slave is so far away that the foot is not the closest point"),
];

/// The number of an error.
pub fn of(error: &ElementError) -> i32 {
    CODES.iter().find(|(_, name, _)| *name == error.code()).map_or(OTHER, |(number, ..)| *number)
}

/// Name and meaning of a number.
pub fn describe(number: i32) -> (&'static str, &'static str) {
    CODES
        .iter()
        .find(|(known, ..)| *known == number)
        .map_or(("other", "a reason this table does not know"), |(_, name, meaning)| (name, meaning))
}

/// Every number but that of reasons this list does not know, with its name and meaning.
pub fn all() -> impl Iterator<Item = (i32, &'static str, &'static str)> {
    CODES.into_iter()
}

/// All numbers with their names and meanings, for the help.
pub fn table() -> String {
    let rows = CODES.iter().map(|(number, name, meaning)| format!("  {number:>2}  {name:<28}{meaning}"));
    let rows: Vec<String> = rows.collect();
    format!("The array `status` of the slave nodes:\n{}", rows.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_have_their_own_numbers() {
        let error = ElementError::SingularFit { pivot_ratio: 0.0, tolerance: 1e-12 };
        assert_eq!(describe(of(&error)).0, "singular-fit");
        assert_eq!(describe(of(&ElementError::Overflow { what: "gap" })).0, "overflow");
        for (k, (number, ..)) in CODES.iter().enumerate() {
            assert_eq!(*number, k as i32);
        }
    }
}
