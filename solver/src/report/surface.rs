//! The smooth master surface beside its facets, sampled.

use diffuse_contact::Mode;
use diffuse_contact::interface::{ContactElement, ContactInterface, InterfaceOptions};
use diffuse_contact::surface::{Facet, MasterSurface};
use serde::{Deserialize, Serialize};

/// Samples along each edge of a facet.
const SAMPLES: usize = 7;

/// A master surface: its facets and what the diffuse element sees in their place.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SurfaceSample {
    /// Name of the interface.
    pub name: String,
    /// Points on the facets, [`grid`](Self::grid)² or for triangles half of that for each facet.
    pub flat: Vec<[f64; 3]>,
    /// The foot of each point on the smooth surface; the point itself where there is none.
    pub smooth: Vec<[f64; 3]>,
    /// Triangles between the points.
    pub triangles: Vec<[usize; 3]>,
    /// Edges of the facets, as pairs of points of `flat`.
    pub edges: Vec<[usize; 2]>,
    /// Samples along an edge.
    pub grid: usize,
}

/// Samples of each surface at `positions`: its name, its facets and the options of its interface, whose element is replaced by the
/// diffuse one if it is another. Surfaces that have no contact interface are left out.
#[must_use]
pub fn sample_surfaces<'a>(
    surfaces: impl IntoIterator<Item = (&'a str, &'a [Facet], InterfaceOptions)>,
    positions: &[[f64; 3]],
) -> Vec<SurfaceSample> {
    surfaces
        .into_iter()
        .filter_map(|(name, facets, options)| sample(name, facets, options, positions))
        .collect()
}

fn sample(
    name: &str,
    facets: &[Facet],
    options: InterfaceOptions,
    positions: &[[f64; 3]],
) -> Option<SurfaceSample> {
    let mut result = SurfaceSample { name: name.to_owned(), grid: SAMPLES, ..SurfaceSample::default() };
    for facet in facets {
        add_samples(facet, positions, &mut result);
    }
    let element = match options.element {
        ContactElement::NodeToFacet => ContactElement::default(),
        diffuse => diffuse,
    };
    let options = InterfaceOptions { element, areas: false, distance_limit: None, ..options };
    let all: Vec<[f64; 3]> = positions.iter().chain(&result.flat).copied().collect();
    let master = MasterSurface::new(positions, facets.to_vec()).ok()?;
    let slaves = (positions.len()..all.len()).collect();
    let mut interface = ContactInterface::new(master, slaves, &[], &all, options).ok()?;
    interface.refresh_pairing(&all).ok()?;
    let contacts = interface.evaluate(Mode::Value).ok()?;
    result.smooth = contacts
        .iter()
        .zip(&result.flat)
        .map(|(contact, &point)| if contact.outcome.is_contact() { contact.point.foot } else { point })
        .collect();
    Some(result)
}

/// Points, triangles and edges of a facet.
fn add_samples(facet: &Facet, positions: &[[f64; 3]], result: &mut SurfaceSample) {
    let last = SAMPLES - 1;
    let first = result.flat.len();
    let corners: Vec<[f64; 3]> = facet.corners().iter().map(|&node| positions[node]).collect();
    let part = |k: usize| k as f64 / last as f64;
    let mix = |weights: &[f64]| {
        [0, 1, 2].map(|axis| weights.iter().zip(&corners).map(|(weight, corner)| weight * corner[axis]).sum())
    };
    match facet {
        Facet::Quadrilateral(_) => {
            for (row, column) in pairs(SAMPLES, |_| SAMPLES) {
                let (u, v) = (part(column), part(row));
                result.flat.push(mix(&[(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v]));
            }
            let at = |row: usize, column: usize| first + row * SAMPLES + column;
            for (row, column) in pairs(last, |_| last) {
                let [a, b, c, d] =
                    [at(row, column), at(row, column + 1), at(row + 1, column + 1), at(row + 1, column)];
                result.triangles.extend([[a, b, c], [a, c, d]]);
            }
            for k in 0..last {
                result.edges.extend([
                    [at(0, k), at(0, k + 1)],
                    [at(last, k), at(last, k + 1)],
                    [at(k, 0), at(k + 1, 0)],
                    [at(k, last), at(k + 1, last)],
                ]);
            }
        }
        Facet::Triangle(_) => {
            for (row, column) in pairs(SAMPLES, |row| SAMPLES - row) {
                let (u, v) = (part(column), part(row));
                result.flat.push(mix(&[1.0 - u - v, u, v]));
            }
            let at =
                |row: usize, column: usize| first + row * SAMPLES - row * row.saturating_sub(1) / 2 + column;
            for (row, column) in pairs(last, |row| last - row) {
                result.triangles.push([at(row, column), at(row, column + 1), at(row + 1, column)]);
                if column + 1 < last - row {
                    result.triangles.push([
                        at(row, column + 1),
                        at(row + 1, column + 1),
                        at(row + 1, column),
                    ]);
                }
            }
            for k in 0..last {
                result.edges.extend([
                    [at(0, k), at(0, k + 1)],
                    [at(k, 0), at(k + 1, 0)],
                    [at(k, last - k), at(k + 1, last - k - 1)],
                ]);
            }
        }
    }
}

/// (row, column) for `rows` rows of a length each.
fn pairs(rows: usize, length: impl Fn(usize) -> usize) -> impl Iterator<Item = (usize, usize)> {
    (0..rows).flat_map(move |row| (0..length(row)).map(move |column| (row, column)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_lie_on_the_facet_and_triangles_cover_it() {
        let positions = [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [0.0, 3.0, 0.0]];
        for (facet, area) in [(Facet::Quadrilateral([0, 1, 2, 3]), 6.0), (Facet::Triangle([0, 1, 2]), 3.0)] {
            let mut found = SurfaceSample::default();
            add_samples(&facet, &positions, &mut found);
            let covered: f64 = found
                .triangles
                .iter()
                .map(|triangle| {
                    let [a, b, c] = triangle.map(|k| found.flat[k]);
                    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
                })
                .inspect(|&area| assert!(area > 0.0))
                .sum();
            assert!((covered - area).abs() < 1e-12, "{covered} of {area}");
        }
    }
}
