//! A picture that any browser shows: on the left the smooth surface with the facets as lines, on the right the slave surface
//! coloured by its gap. Both are seen from outside the master surface, farther parts painted first.

use std::io::{self, Write};
use std::path::Path;

use diffuse_contact::Point;

use super::sampling::SmoothSurface;
use crate::error::CliError;
use crate::output;
use crate::surface::nodes::SlaveNodes;
use crate::surface::slaves::Surfaces;
use crate::words::number;

/// Width and height of each of the two drawings, pixels.
const SIZE: [f64; 2] = [560.0, 400.0];
/// Space around a drawing.
const MARGIN: f64 = 40.0;
/// Height of the line of text above a drawing.
const HEAD: f64 = 30.0;
/// Width of the colour bar with its numbers.
const BAR: f64 = 90.0;
/// The camera in the frame of the surface: two directions along it, one outward.
const CAMERA: [f64; 3] = [0.35, -0.6, 0.72];

/// Colours: of the smooth surface in full light, of its facets' edges, of nodes without contact.
const SURFACE: [f64; 3] = [222.0, 226.0, 232.0];
const EDGE: &str = "#1f3a5f";
const NO_CONTACT: [f64; 3] = [160.0, 160.0, 160.0];
/// Of the largest, of no and of the smallest gap.
const APART: [f64; 3] = [33.0, 102.0, 172.0];
const TOUCHING: [f64; 3] = [247.0, 247.0, 247.0];
const PENETRATING: [f64; 3] = [178.0, 24.0, 43.0];

/// Writes the file.
pub fn write(
    path: &Path,
    surfaces: &Surfaces,
    nodes: &SlaveNodes,
    smooth: &SmoothSurface,
) -> Result<(), CliError> {
    let camera = Camera::outside(&smooth.node_normals);
    let [left, right] = [master(&camera, surfaces, smooth), slaves(&camera, surfaces, nodes)];
    output::write_file(path, |writer| {
        let [width, height] = SIZE.map(|side| side + 2.0 * MARGIN);
        let (width, height) = (2.0 * width + BAR, height + HEAD);
        writeln!(
            writer,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
             style=\"max-width:100%;height:auto\" font-family=\"sans-serif\" font-size=\"15\">"
        )?;
        writeln!(writer, "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>")?;
        left.write(writer, 0.0, "smooth master surface, its facets as lines")?;
        right.write(
            writer,
            SIZE[0] + 2.0 * MARGIN,
            "slave surface, coloured by its gap: where it is red it penetrates",
        )?;
        if let Some(range) = nodes.counts().gaps {
            write_bar(writer, range)?;
        }
        writeln!(writer, "</svg>")
    })
}

/// Where one looks from, infinitely far away.
struct Camera {
    right: Point,
    up: Point,
    /// Towards the camera.
    towards: Point,
}

impl Camera {
    /// Above the side of the surface that the normals of its nodes show to.
    fn outside(normals: &[Point]) -> Self {
        let mean = normals.iter().fold([0.0; 3], |sum, n| [0, 1, 2].map(|k| sum[k] + n[k]));
        let outward = unit(mean).unwrap_or([0.0, 0.0, 1.0]);
        let least = (0..3).min_by(|&i, &j| outward[i].abs().total_cmp(&outward[j].abs())).unwrap_or(0);
        let axis = [0, 1, 2].map(|k| if k == least { 1.0 } else { 0.0 });
        let along = unit(cross(axis, outward)).unwrap_or(axis);
        let across = cross(outward, along);
        let [a, b, c] = CAMERA;
        let towards =
            unit([0, 1, 2].map(|k| a * along[k] + b * across[k] + c * outward[k])).unwrap_or(outward);
        let right = unit(cross(outward, towards)).unwrap_or(along);
        Self { right, up: cross(towards, right), towards }
    }

    /// To the right, down, towards the camera.
    fn see(&self, x: Point) -> Point {
        [dot(x, self.right), -dot(x, self.up), dot(x, self.towards)]
    }
}

/// Shapes to be painted, and what frames them.
struct Drawing {
    /// Outline, colour; the farthest first.
    patches: Vec<(Vec<Point>, [f64; 3])>,
    lines: Vec<[Point; 2]>,
}

impl Drawing {
    fn new(mut patches: Vec<(Vec<Point>, [f64; 3])>, lines: Vec<[Point; 2]>) -> Self {
        let depth = |points: &[Point]| points.iter().map(|x| x[2]).sum::<f64>() / points.len() as f64;
        patches.sort_by(|(one, _), (other, _)| depth(one).total_cmp(&depth(other)));
        Self { patches, lines }
    }

    /// Fills its part of the picture, `left` pixels from the border.
    fn write(&self, writer: &mut dyn Write, left: f64, title: &str) -> io::Result<()> {
        let text = left + MARGIN;
        writeln!(writer, "<text x=\"{text}\" y=\"{}\">{title}</text>", HEAD)?;
        let points = || self.patches.iter().flat_map(|(outline, _)| outline);
        let range = |axis: usize| {
            points().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                [low.min(x[axis]), high.max(x[axis])]
            })
        };
        let ranges = [range(0), range(1)];
        let scale = [0, 1].map(|axis| SIZE[axis] / (ranges[axis][1] - ranges[axis][0]));
        // A single node has no extent.
        let scale = Some(scale[0].min(scale[1])).filter(|scale| scale.is_finite()).unwrap_or(1.0);
        let place = |x: &Point| {
            let [right, down] = [0, 1].map(|axis| {
                let middle = 0.5 * (ranges[axis][0] + ranges[axis][1]);
                MARGIN + 0.5 * SIZE[axis] + scale * (x[axis] - middle)
            });
            format!("{:.1} {:.1}", left + right, HEAD + down)
        };
        // A stroke of the same colour closes the seams between patches.
        writeln!(
            writer,
            "<g fill=\"currentColor\" stroke=\"currentColor\" stroke-width=\"0.6\" stroke-linecap=\"round\">"
        )?;
        for (outline, colour) in &self.patches {
            let outline: Vec<String> = outline.iter().map(place).collect();
            let (width, end) = if outline.len() > 1 { ("", "z") } else { (" stroke-width=\"6\"", "h0") };
            writeln!(writer, "<path color=\"{}\"{width} d=\"M{}{end}\"/>", hex(*colour), outline.join("L"))?;
        }
        writeln!(writer, "</g>\n<path fill=\"none\" stroke=\"{EDGE}\" stroke-width=\"0.8\" d=\"")?;
        for [from, to] in &self.lines {
            writeln!(writer, "M{}L{}", place(from), place(to))?;
        }
        writeln!(writer, "\"/>")
    }
}

/// The smooth surface in the camera's light, and the edges of the facets that face the camera.
fn master(camera: &Camera, surfaces: &Surfaces, smooth: &SmoothSurface) -> Drawing {
    let patches = smooth.pieces.iter().map(|piece| {
        let corners = piece.corners().iter().map(|&k| smooth.samples[k]);
        let outline = corners.clone().map(|sample| camera.see(sample.position)).collect();
        let facing = corners.clone().map(|sample| dot(sample.normal, camera.towards)).sum::<f64>();
        let light = (facing / corners.count() as f64).max(0.0);
        (outline, SURFACE.map(|x| x * (0.25 + 0.75 * light)))
    });
    let lines = surfaces.master.iter().flat_map(|facet| {
        let corners: Vec<Point> =
            facet.corners().iter().map(|&node| camera.see(surfaces.mesh.nodes()[node])).collect();
        let count = if is_seen(&corners) { corners.len() } else { 0 };
        (0..count).map(move |k| [corners[k], corners[(k + 1) % corners.len()]]).collect::<Vec<_>>()
    });
    Drawing::new(patches.collect(), lines.collect())
}

/// Whether a facet shows its front to the camera: its corners run against the clock there.
fn is_seen(corners: &[Point]) -> bool {
    let next = corners.iter().cycle().skip(1);
    // Downwards is positive.
    corners.iter().zip(next).map(|(a, b)| a[1] * b[0] - a[0] * b[1]).sum::<f64>() > 0.0
}

/// The slave facets by their mean gap, or the slave nodes if there are no facets.
fn slaves(camera: &Camera, surfaces: &Surfaces, nodes: &SlaveNodes) -> Drawing {
    let seen: Vec<Point> =
        surfaces.slaves.iter().map(|&node| camera.see(surfaces.mesh.nodes()[node])).collect();
    let range = nodes.counts().gaps;
    let colour_of = |places: &[usize]| {
        let gaps = places.iter().map(|&place| &nodes.nodes[place]).filter(|node| node.outcome.is_contact());
        let (sum, count) = gaps.fold((0.0, 0), |(sum, count), node| (sum + node.point.gap, count + 1));
        match range {
            Some(range) if count > 0 => colour(sum / f64::from(count), range),
            _ => NO_CONTACT,
        }
    };
    let place = |node: &usize| surfaces.slaves.partition_point(|other| other < node);
    let facets: Vec<Vec<usize>> = if surfaces.has_areas {
        surfaces.slave_facets.iter().map(|facet| facet.corners().iter().map(place).collect()).collect()
    } else {
        (0..seen.len()).map(|place| vec![place]).collect()
    };
    let patches =
        facets.iter().map(|places| (places.iter().map(|&place| seen[place]).collect(), colour_of(places)));
    Drawing::new(patches.collect(), Vec::new())
}

/// The colour of a gap between the smallest and the largest.
fn colour(gap: f64, [smallest, largest]: [f64; 2]) -> [f64; 3] {
    let (end, share) = if gap < 0.0 { (PENETRATING, gap / smallest) } else { (APART, gap / largest) };
    let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
    [0, 1, 2].map(|k| TOUCHING[k] + share * (end[k] - TOUCHING[k]))
}

/// The colour bar at the right border: the smallest gap below, the largest above, none where they meet.
fn write_bar(writer: &mut dyn Write, [smallest, largest]: [f64; 2]) -> io::Result<()> {
    const STEPS: usize = 60;
    let left = 2.0 * (SIZE[0] + 2.0 * MARGIN);
    let (top, height) = (HEAD + MARGIN, SIZE[1] / STEPS as f64);
    for step in 0..STEPS {
        let gap = largest + (smallest - largest) * (step as f64 + 0.5) / STEPS as f64;
        let (y, colour) = (top + height * step as f64, hex(colour(gap, [smallest, largest])));
        writeln!(
            writer,
            "<rect x=\"{left}\" y=\"{y:.1}\" width=\"18\" height=\"{:.1}\" fill=\"{colour}\"/>",
            height + 0.5
        )?;
    }
    let mut labels = vec![largest];
    if smallest < largest {
        labels.push(smallest);
    }
    if smallest < 0.0 && largest > 0.0 {
        labels.push(0.0);
    }
    for gap in labels {
        let below = (largest - gap) / (largest - smallest).max(f64::MIN_POSITIVE);
        let y = top + SIZE[1] * below + 5.0;
        writeln!(writer, "<text x=\"{}\" y=\"{y:.1}\">{}</text>", left + 24.0, number(gap, 3))?;
    }
    Ok(())
}

fn hex(colour: [f64; 3]) -> String {
    let [r, g, b] = colour.map(|x| x.round().clamp(0.0, 255.0) as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The vector at length one, if it has a direction.
pub fn unit(x: Point) -> Option<Point> {
    let length = dot(x, x).sqrt();
    (length > 0.0).then(|| x.map(|x| x / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_camera_is_right_handed_and_above_the_surface() {
        for normal in [[0.0, 0.0, 2.0], [-1.0, 0.0, 0.0], [1.0, 2.0, -0.5]] {
            let camera = Camera::outside(&[normal]);
            assert!(dot(camera.towards, normal) > 0.0);
            for k in 0..3 {
                assert!((cross(camera.right, camera.up)[k] - camera.towards[k]).abs() < 1e-15);
            }
            assert!(camera.see(normal)[1] < 0.0, "outward is up");
        }
    }

    #[test]
    fn facets_are_seen_from_outside_only() {
        let camera = Camera::outside(&[[0.0, 0.0, 1.0]]);
        let mut corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|x| camera.see(x));
        assert!(is_seen(&corners));
        corners.reverse();
        assert!(!is_seen(&corners));
    }

    #[test]
    fn gaps_have_the_colours_of_their_side() {
        let range = [-0.5, 6.0];
        assert_eq!(colour(-0.5, range), PENETRATING);
        assert_eq!(colour(0.0, range), TOUCHING);
        assert_eq!(colour(6.0, range), APART);
        assert_eq!(colour(0.0, [0.0, 0.0]), TOUCHING);
        assert_eq!(hex(PENETRATING), "#b2182b");
    }
}
