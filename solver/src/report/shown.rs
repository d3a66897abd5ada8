//! What of the results is in the page: as much as a browser opens at once, in as many digits as one sees.

use serde::Serialize;

use super::SurfaceSample;
use crate::output::{OutputError, Skin, SkinFrame};

/// Most frames of a run that a page holds; of more, evenly spaced ones are taken.
const MOST_FRAMES: usize = 41;
/// Bytes of all shapes in a page.
const SHAPE_BYTES: usize = 5_000_000;
/// Bytes of all sampled surfaces in a page.
const SURFACE_BYTES: usize = 2_500_000;

/// A sampled master surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Surface {
    name: String,
    flat: Vec<[f64; 3]>,
    smooth: Vec<[f64; 3]>,
    /// Between the points of both.
    distance: Vec<f64>,
    triangles: Vec<[usize; 3]>,
    edges: Vec<[usize; 2]>,
}

/// Seven digits: about what a screen resolves a thousand times over.
fn rounded(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

fn rounded_points(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    points.iter().map(|point| point.map(rounded)).collect()
}

fn bytes(document: &impl Serialize) -> usize {
    serde_json::to_vec(document).map_or(0, |text| text.len())
}

/// A frame in as many digits as one sees.
pub fn short(mut frame: SkinFrame) -> SkinFrame {
    frame.positions = rounded_points(&frame.positions);
    frame.fields.values_mut().flatten().for_each(|value| *value = rounded(*value));
    frame
}

impl Surface {
    fn of(sample: &SurfaceSample) -> Self {
        let apart = |(a, b): (&[f64; 3], &[f64; 3])| {
            rounded((0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt())
        };
        Self {
            name: sample.name.clone(),
            distance: sample.flat.iter().zip(&sample.smooth).map(apart).collect(),
            flat: rounded_points(&sample.flat),
            smooth: rounded_points(&sample.smooth),
            triangles: sample.triangles.clone(),
            edges: sample.edges.clone(),
        }
    }
}

/// The skin and frames that a page of `runs` runs shows of `count` frames, those of the first and the last increment among them if there
/// is room for two. No frames and no skin: there is no room for one. What is left out is noted.
pub fn frames(
    skin: Skin,
    count: usize,
    runs: usize,
    mut read: impl FnMut(usize) -> Result<SkinFrame, OutputError>,
    notes: &mut Vec<String>,
) -> Result<(Skin, Vec<SkinFrame>), OutputError> {
    let last = short(read(count - 1)?);
    let room = (SHAPE_BYTES / runs).saturating_sub(bytes(&skin));
    // Others may have a little more to write than the last one.
    let most = (room / (bytes(&last) * 5 / 4)).min(MOST_FRAMES).min(count);
    if most == 0 {
        notes.push(format!("The shape is not shown: its skin has {} nodes.", skin.nodes.len()));
        return Ok((Skin::default(), Vec::new()));
    }
    if most < count {
        notes.push(format!("{most} of {count} pictures of the shape are shown."));
    }
    let places = (0..most - 1).map(|k| k * (count - 1) / (most - 1));
    let mut frames = places.map(|k| Ok(short(read(k)?))).collect::<Result<Vec<_>, OutputError>>()?;
    frames.push(last);
    Ok((skin, frames))
}

/// The sampled surfaces that a page of `runs` runs shows. What is left out is noted.
pub fn surfaces(samples: &[SurfaceSample], runs: usize, notes: &mut Vec<String>) -> Vec<Surface> {
    let mut room = SURFACE_BYTES / runs;
    let mut shown = Vec::new();
    for sample in samples {
        let surface = Surface::of(sample);
        let size = bytes(&surface);
        if sample.flat.is_empty() || size > room {
            let SurfaceSample { name, facets, .. } = sample;
            notes.push(format!(
                "The smooth surface of the master of {name} is not shown: it has {facets} facets."
            ));
        } else {
            room -= size;
            shown.push(surface);
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame of a skin with so many nodes, in numbers with all digits.
    fn frame(nodes: usize, increment: usize) -> SkinFrame {
        let value = |k: usize| -1e-5 * ((k + increment) as f64 + 0.1).sqrt();
        let fields = ["displacement", "von_mises", "contact_gap"];
        SkinFrame {
            increment,
            time: increment as f64,
            positions: (0..nodes).map(|k| [value(k), value(2 * k), value(3 * k)]).collect(),
            fields: fields.map(|name| (name.to_owned(), (0..nodes).map(value).collect())).into(),
        }
    }

    fn skin(nodes: usize) -> Skin {
        let faces = (0..nodes).map(|k| vec![k, (k + 1) % nodes, (k + 2) % nodes, (k + 3) % nodes]).collect();
        Skin { nodes: (0..nodes).collect(), faces, parts: vec![0; nodes], ..Skin::default() }
    }

    #[test]
    fn shapes_of_any_size_fit_into_a_page() {
        for (nodes, count, expected) in [
            (100, 30, 30..31),
            (100, 1000, 41..42),
            (10_000, 100, 4..20),
            (35_000, 7, 1..3),
            (400_000, 2, 0..1),
        ] {
            let mut notes = Vec::new();
            let (skin, frames) = frames(skin(nodes), count, 1, |k| Ok(frame(nodes, k)), &mut notes).unwrap();
            assert!(expected.contains(&frames.len()), "{nodes} nodes: {} frames", frames.len());
            assert!(bytes(&(&skin, &frames)) <= SHAPE_BYTES, "{nodes} nodes");
            assert_eq!(notes.is_empty(), frames.len() == count, "{notes:?}");
            if let [first, .., last] = &frames[..] {
                assert_eq!((first.increment, last.increment), (0, count - 1));
            }
        }
    }

    #[test]
    fn numbers_keep_seven_digits() {
        assert_eq!(rounded(-12.345_678_912), -12.345_68);
        assert_eq!(rounded(1e-300 / 3.0), 3.333_333e-301);
        assert_eq!(rounded(0.0), 0.0);
    }
}
