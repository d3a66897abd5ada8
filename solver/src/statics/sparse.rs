//! Plastic states of all points on disk: those that yielded.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::material::PointState;

/// What is written: how many points there are, and those that are not virgin.
#[derive(Serialize, Deserialize)]
struct Sparse {
    count: usize,
    /// Their indices, ascending.
    yielded: Vec<usize>,
    /// C_p⁻¹ xx, yy, zz, xy, yz, xz, and p, of each.
    states: Vec<[f64; 7]>,
}

fn flat(state: &PointState) -> [f64; 7] {
    let [xx, yy, zz, xy, yz, xz] = state.inverse_plastic_metric;
    [xx, yy, zz, xy, yz, xz, state.equivalent_plastic_strain]
}

/// Bit by bit: a restart goes on from the same numbers.
fn is_virgin(state: &PointState) -> bool {
    flat(state).map(f64::to_bits) == flat(&PointState::VIRGIN).map(f64::to_bits)
}

pub fn serialize<S: Serializer>(points: &[PointState], serializer: S) -> Result<S::Ok, S::Error> {
    let yielded: Vec<usize> = (0..points.len()).filter(|&k| !is_virgin(&points[k])).collect();
    let states = yielded.iter().map(|&k| flat(&points[k])).collect();
    Sparse { count: points.len(), yielded, states }.serialize(serializer)
}

pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<PointState>, D::Error> {
    let Sparse { count, yielded, states } = Sparse::deserialize(deserializer)?;
    if yielded.len() != states.len() {
        return Err(D::Error::custom(format!("{} points and {} states", yielded.len(), states.len())));
    }
    let mut points = Vec::new();
    // The count is not backed by as many entries, so it may be anything.
    points.try_reserve_exact(count).map_err(|_| D::Error::custom(format!("{count} points")))?;
    points.resize(count, PointState::VIRGIN);
    for (k, [xx, yy, zz, xy, yz, xz, equivalent_plastic_strain]) in yielded.into_iter().zip(states) {
        let point =
            points.get_mut(k).ok_or_else(|| D::Error::custom(format!("point {k} of {count} points")))?;
        *point = PointState { inverse_plastic_metric: [xx, yy, zz, xy, yz, xz], equivalent_plastic_strain };
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    #[serde(transparent)]
    struct Points(#[serde(with = "super")] Vec<PointState>);

    #[test]
    fn only_points_that_yielded_are_written_and_all_come_back() {
        let yielded = PointState {
            inverse_plastic_metric: [1.0 + f64::EPSILON, 0.9, 1.1, 0.1, -0.0, 1.0 / 3.0],
            equivalent_plastic_strain: 1e-300,
        };
        let mut points = Points(vec![PointState::VIRGIN; 1000]);
        let virgin = serde_json::to_string(&points).unwrap();
        assert_eq!(virgin, r#"{"count":1000,"yielded":[],"states":[]}"#);
        points.0[0] = yielded;
        points.0[999] = PointState { equivalent_plastic_strain: -0.0, ..PointState::VIRGIN };
        let back: Points = serde_json::from_str(&serde_json::to_string(&points).unwrap()).unwrap();
        let bits = |points: &Points| points.0.iter().map(|p| flat(p).map(f64::to_bits)).collect::<Vec<_>>();
        assert_eq!(bits(&back), bits(&points));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        for (text, part) in [
            (r#"{"count":2,"yielded":[2],"states":[[1,1,1,0,0,0,0.1]]}"#, "point 2 of 2 points"),
            (r#"{"count":2,"yielded":[0,1],"states":[[1,1,1,0,0,0,0.1]]}"#, "2 points and 1 states"),
            (r#"{"count":18446744073709551615,"yielded":[],"states":[]}"#, "18446744073709551615 points"),
        ] {
            let refused = serde_json::from_str::<Points>(text).unwrap_err().to_string();
            assert!(refused.starts_with(part), "{refused}");
        }
    }
}
