//! The smooth master surface beside its facets, sampled.

use diffuse_contact::Mode;
use diffuse_contact::interface::{ContactElement, ContactInterface, InterfaceOptions};
use diffuse_contact::surface::{Facet, MasterSurface, SymmetryPlane};
use serde::{Deserialize, Serialize};

/// Most samples along each edge of a facet.
const SAMPLES: usize = 7;
/// Most points of all surfaces of a run.
const MOST_POINTS: usize = 12_000;

/// A master surface: its facets and what the diffuse element sees in their place. One that has too many nodes has no points.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SurfaceSample {
    /// Name of the interface.
    pub name: String,
    /// How many facets it has.
    pub facets: usize,
    /// Points on the facets: [`grid`](Self::grid)² or for triangles half of that for each facet, or their nodes if that would be too many.
    pub flat: Vec<[f64; 3]>,
    /// The foot of each point on the smooth surface; the point itself where there is none.
    pub smooth: Vec<[f64; 3]>,
    /// Triangles between the points.
    pub triangles: Vec<[usize; 3]>,
    /// Edges of the facets, as pairs of points of `flat`.
    pub edges: Vec<[usize; 2]>,
    /// Samples along an edge; the more facets, the fewer.
    pub grid: usize,
}

impl SurfaceSample {
    /// Whether triangles and edges are between points that there are.
    pub(super) fn is_sound(&self) -> bool {
        let known = |&point: &usize| point < self.flat.len();
        self.smooth.len() == self.flat.len()
            && self.triangles.iter().flatten().all(known)
            && self.edges.iter().flatten().all(known)
    }
}

/// A master surface to be sampled.
#[derive(Clone, Debug)]
pub struct Master<'a> {
    /// What it is called.
    pub name: String,
    /// Its facets.
    pub facets: Vec<Facet>,
    /// Those of its interface. The element is replaced by the diffuse one if it is another.
    pub options: InterfaceOptions,
    /// Planes in which it goes on as its mirror image.
    pub symmetry: &'a [SymmetryPlane],
}

/// Samples of each surface at `positions`, with the domains of influence that it has at the `start`. Surfaces that have no contact
/// interface are left out.
pub fn sample_surfaces(
    masters: &[Master<'_>],
    start: &[[f64; 3]],
    positions: &[[f64; 3]],
) -> Vec<SurfaceSample> {
    let most = MOST_POINTS / masters.len().max(1);
    masters.iter().filter_map(|master| sample(master, start, positions, most)).collect()
}

/// Points on facets with `grid` samples along an edge.
fn point_count(facets: &[Facet], grid: usize) -> usize {
    let points = |facet: &Facet| if facet.corners().len() == 4 { grid * grid } else { grid * (grid + 1) / 2 };
    facets.iter().map(points).sum()
}

/// At most `most` points on facets, with triangles and edges between them.
fn flat_points(name: &str, facets: &[Facet], positions: &[[f64; 3]], most: usize) -> SurfaceSample {
    let mut result =
        SurfaceSample { name: name.to_owned(), facets: facets.len(), grid: 2, ..SurfaceSample::default() };
    if let Some(grid) = (3..=SAMPLES).rev().find(|&grid| point_count(facets, grid) <= most) {
        result.grid = grid;
        facets.iter().for_each(|facet| add_samples(facet, positions, &mut result));
        return result;
    }
    let mut nodes: Vec<usize> = facets.iter().flat_map(|facet| facet.corners()).copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    if nodes.len() > most {
        return result;
    }
    for facet in facets {
        let corners: Vec<usize> =
            facet.corners().iter().map(|node| nodes.partition_point(|other| other < node)).collect();
        result.triangles.extend((2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]]));
        result.edges.extend((0..corners.len()).map(|k| [corners[k], corners[(k + 1) % corners.len()]]));
    }
    result.flat = nodes.iter().map(|&node| positions[node]).collect();
    result
}

fn sample(
    master: &Master<'_>,
    start: &[[f64; 3]],
    positions: &[[f64; 3]],
    most: usize,
) -> Option<SurfaceSample> {
    let Master { name, facets, options, symmetry } = master;
    let mut result = flat_points(name, facets, positions, most);
    if result.flat.is_empty() {
        return Some(result);
    }
    let element = match options.element {
        ContactElement::NodeToFacet => ContactElement::default(),
        diffuse => diffuse,
    };
    let options = options.with_element(element).with_areas(false).with_distance_limit(None);
    let first = [start, &flat_points(name, facets, start, most).flat].concat();
    let surface = MasterSurface::new(start, facets.clone()).ok()?;
    let slaves = (start.len()..first.len()).collect();
    let mut interface = ContactInterface::new(surface, slaves, &[], &first, options).ok()?;
    if !symmetry.is_empty() {
        // Rules without domains know no planes: beside the other element a deck may have both.
        let _ = interface.set_symmetry(symmetry);
    }
    interface.refresh_pairing(&[positions, &result.flat].concat()).ok()?;
    let contacts = interface.evaluate(Mode::Value).ok()?;
    result.smooth = contacts
        .iter()
        .zip(&result.flat)
        .map(|(contact, &point)| if contact.outcome.is_contact() { contact.point.foot } else { point })
        .collect();
    Some(result)
}

/// Points, triangles and edges of a facet with the result's samples along an edge.
fn add_samples(facet: &Facet, positions: &[[f64; 3]], result: &mut SurfaceSample) {
    let samples = result.grid;
    let last = samples - 1;
    let first = result.flat.len();
    let corners: Vec<[f64; 3]> = facet.corners().iter().map(|&node| positions[node]).collect();
    let part = |k: usize| k as f64 / last as f64;
    let mix = |weights: &[f64]| {
        [0, 1, 2].map(|axis| weights.iter().zip(&corners).map(|(weight, corner)| weight * corner[axis]).sum())
    };
    match facet {
        Facet::Quadrilateral(_) => {
            for (row, column) in pairs(samples, |_| samples) {
                let (u, v) = (part(column), part(row));
                result.flat.push(mix(&[(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v]));
            }
            let at = |row: usize, column: usize| first + row * samples + column;
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
            for (row, column) in pairs(samples, |row| samples - row) {
                let (u, v) = (part(column), part(row));
                result.flat.push(mix(&[1.0 - u - v, u, v]));
            }
            let at =
                |row: usize, column: usize| first + row * samples - row * row.saturating_sub(1) / 2 + column;
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

    fn master(facets: Vec<Facet>, symmetry: &[SymmetryPlane]) -> Master<'_> {
        Master { name: "master".to_owned(), facets, options: InterfaceOptions::default(), symmetry }
    }

    /// Nodes and facets of a sheet over −`columns` ≤ x ≤ `columns`, or its half at x ≥ 0, and 0 ≤ y ≤ 4, by where nodes are.
    fn sheet(first: i32, columns: i32, place: impl Fn(f64, f64) -> [f64; 3]) -> (Vec<[f64; 3]>, Vec<Facet>) {
        let rows = 4;
        let along = || first..=columns;
        let nodes = (0..=rows).flat_map(|j| along().map(move |i| (f64::from(i), f64::from(j))));
        let width = (columns - first + 1) as usize;
        let cells = pairs(rows as usize, |_| width - 1).map(|(j, i)| {
            let corner = j * width + i;
            Facet::Quadrilateral([corner, corner + 1, corner + width + 1, corner + width])
        });
        (nodes.map(|(x, y)| place(x, y)).collect(), cells.collect())
    }

    /// Half of a sheet that bends symmetrically is the half of the whole, with the domains of the start: a plane of symmetry is no border,
    /// and stretching is no reason for other masters.
    #[test]
    fn half_of_a_symmetric_surface_is_that_of_the_whole() {
        let flat = |x: f64, y: f64| [x, y, 0.0];
        // Symmetric in x, stretched unevenly.
        let bent = |x: f64, y: f64| [x * (1.0 + 0.15 * x * x), y, 0.3 * (0.8 * x).cos() + 0.05 * y * y];
        let plane = [SymmetryPlane { point: [0.0; 3], normal: [1.0, 0.0, 0.0] }];
        let (start, facets) = sheet(0, 4, flat);
        let (now, _) = sheet(0, 4, bent);
        let samples = |planes, start: &[[f64; 3]]| {
            let mut found = sample_surfaces(&[master(facets.clone(), planes)], start, &now);
            found.pop().unwrap()
        };
        let half = samples(&plane, &start);
        let (whole_start, whole_facets) = sheet(-4, 4, flat);
        let (whole_now, _) = sheet(-4, 4, bent);
        let whole = sample_surfaces(&[master(whole_facets, &[])], &whole_start, &whole_now).pop().unwrap();
        assert_eq!(half.grid, whole.grid);
        let distance = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
        let off = |found: &SurfaceSample| {
            let of = |(flat, smooth): (&[f64; 3], &[f64; 3])| {
                let same = whole.flat.iter().position(|other| distance(flat, other) < 1e-12).unwrap();
                distance(smooth, &whole.smooth[same])
            };
            found.flat.iter().zip(&found.smooth).map(of).fold(0.0, f64::max)
        };
        assert!(off(&half) < 1e-9, "{}", off(&half));
        for other in [samples(&[], &start), samples(&plane, &now)] {
            assert!(off(&other) > 1e-4, "{}", off(&other));
        }
    }

    /// Areas of the triangles, all in the plane of x and y.
    fn areas(sample: &SurfaceSample) -> impl Iterator<Item = f64> {
        sample.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|k| sample.flat[k]);
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        })
    }

    #[test]
    fn samples_lie_on_the_facet_and_triangles_cover_it() {
        let positions = [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [0.0, 3.0, 0.0]];
        for (facet, area) in [(Facet::Quadrilateral([0, 1, 2, 3]), 6.0), (Facet::Triangle([0, 1, 2]), 3.0)] {
            let mut found = SurfaceSample { grid: SAMPLES, ..SurfaceSample::default() };
            add_samples(&facet, &positions, &mut found);
            let covered: f64 = areas(&found).inspect(|&area| assert!(area > 0.0)).sum();
            assert!((covered - area).abs() < 1e-12, "{covered} of {area}");
        }
    }

    #[test]
    fn surfaces_of_any_size_have_few_points() {
        for (cells, grid, points) in
            [(4, 7, 784), (20, 5, 10_000), (34, 3, 10_404), (60, 2, 3_721), (200, 2, 0)]
        {
            let node = |i: usize, j: usize| j * (cells + 1) + i;
            let positions: Vec<[f64; 3]> =
                (0..=cells).flat_map(|j| (0..=cells).map(move |i| [i as f64, j as f64, 0.0])).collect();
            let facets: Vec<Facet> = pairs(cells, |_| cells)
                .map(|(j, i)| [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)])
                .map(Facet::Quadrilateral)
                .collect();
            let [found] = &sample_surfaces(&[master(facets, &[])], &positions, &positions)[..] else {
                panic!("one surface")
            };
            assert_eq!((found.grid, found.flat.len(), found.facets), (grid, points, cells * cells));
            assert!(found.is_sound());
            if points > 0 {
                let covered: f64 = areas(found).sum();
                assert!((covered / (cells * cells) as f64 - 1.0).abs() < 1e-12, "{covered}");
                // A plane is fitted exactly.
                assert!(found.smooth.iter().all(|point| point[2].abs() < 1e-9));
            }
        }
    }
}
