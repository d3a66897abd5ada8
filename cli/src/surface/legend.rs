//! What became of a slave node, as a number for ParaView and as words for people.

use diffuse_contact::interface::Outcome;

/// A reason this list does not know.
const OTHER: i32 = 99;

/// Number, name, meaning.
const CODES: [(i32, &str, &str); 20] = [
    (0, "contact", "gap, normal and foot are valid"),
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
    (12, "beyond-border", "the slave does not face the master surface"),
    (13, "beyond-centre-of-curvature", "the slave is so far away that the foot is not the closest point"),
    (14, "not-paired", "no facet was found for the slave"),
    (15, "too-far", "the closest facet is farther away than the distance limit"),
    (16, "no-candidate", "no master nodes on its side of sharp edges carry a smooth surface"),
    (17, "degenerate-facet", "the closest facet has no normal at the foot"),
    (18, "not-material-place", "the slave's place in the first configuration was not found"),
    (OTHER, "other", "a reason this table does not know"),
];

/// The number of an outcome.
pub fn number(outcome: Outcome) -> i32 {
    describe(outcome.code()).0
}

/// Number and meaning of a code.
pub fn describe(code: &str) -> (i32, &'static str) {
    CODES
        .iter()
        .find(|(_, name, _)| *name == code)
        .map_or((OTHER, "see the library"), |(number, _, meaning)| (*number, meaning))
}

/// All numbers with their names and meanings, for the help.
pub fn table() -> String {
    let rows = CODES.iter().map(|(number, name, meaning)| format!("  {number:>2}  {name:<27}{meaning}"));
    rows.collect::<Vec<String>>().join("\n")
}

/// The arrays of the file, for the help.
pub fn help() -> String {
    format!(
        "Arrays of the nodes:
  gap      signed distance from the master surface, negative in penetration; NaN where there is no contact
  normal   unit normal of the master surface at the foot; zero where there is none
  foot     the point of the master surface the gap is measured from; NaN where there is none
  masters  number of master nodes
  basis    polynomial degree of the smooth surface: 2, 1 where the master nodes carry no more, 0 where there is none
  area     tributary area of the node, if the slave set has facets
  outcome  what became of the node:\n{}",
        table()
    )
}

#[cfg(test)]
mod tests {
    use diffuse_contact::ElementError;
    use diffuse_contact::interface::NoContact;
    use diffuse_contact::neighbourhood::Fallback;

    use super::*;

    #[test]
    fn every_number_has_one_meaning() {
        let numbers: Vec<i32> = CODES.map(|(number, ..)| number).to_vec();
        assert!(numbers.is_sorted_by(|a, b| a < b), "{numbers:?}");
    }

    #[test]
    fn outcomes_have_their_numbers() {
        assert_eq!(number(Outcome::Contact { fallback: Fallback::None }), 0);
        let singular = ElementError::SingularFit { pivot_ratio: 0.0, tolerance: 1e-12 };
        let cases = [
            (NoContact::Element { error: singular }, 7),
            (NoContact::BeyondBorder { distance: 1.0, tolerance: 0.0 }, 12),
            (NoContact::NotPaired, 14),
            (NoContact::TooFar { distance: 2.0, limit: 1.0 }, 15),
        ];
        for (reason, expected) in cases {
            assert_eq!(number(Outcome::None(reason)), expected, "{reason}");
            assert_eq!(describe(reason.code()).0, expected);
        }
    }
}
