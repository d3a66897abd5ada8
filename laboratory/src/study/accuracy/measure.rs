//! Errors of gap and normal over one cell.

use diffuse_contact::interface::{ContactElement, InterfaceOptions, Outcome, PairedElement};
use diffuse_contact::neighbourhood::NeighbourRule;
use diffuse_contact::{FrameDerivative, Mode, Point, Weight};
use serde::Serialize;

use super::shapes::Shape;
use crate::study::domains::weighted;
use crate::study::patch::Patch;
use crate::study::{StudyError, paired};
use diffuse_contact_cli::contact_options::diffuse;

/// Places across the cell in each direction: multiples of 1/20 from a node on, half of the cell among them.
pub const PLACES: usize = 20;
/// Sizes of the cells, degrees.
pub const SIZES: [f64; 5] = [22.5, 15.0, 10.0, 7.5, 5.0];

/// The elements under study with their names.
pub fn elements() -> Vec<(&'static str, ContactElement)> {
    let smooth = Weight::ALL
        .map(|weight| (weight.name(), diffuse(weight, FrameDerivative::CoMoving, NeighbourRule::Domains)));
    std::iter::once(("facets", ContactElement::NodeToFacet)).chain(smooth).collect()
}

/// What was measured on one mesh with one element.
#[derive(Clone, Debug, Serialize)]
pub struct Measurement {
    /// The surface.
    pub shape: Shape,
    /// Size of a cell, degrees.
    pub cell_degrees: f64,
    /// Name of the element.
    pub element: &'static str,
    /// Largest |gap error|, length.
    pub gap_max: f64,
    /// Mean |gap error|, length.
    pub gap_mean: f64,
    /// Largest angle between the normal and the exact one, degrees.
    pub normal_max_degrees: f64,
    /// Mean angle, degrees.
    pub normal_mean_degrees: f64,
    /// Masters of a slave that have a weight, on average; none on facets.
    pub masters_mean: Option<f64>,
    /// The most of them.
    pub masters_max: Option<usize>,
    /// Gap error by place: entry i + 20 j at (i/20, j/20) of the cell.
    #[serde(skip)]
    errors: Vec<f64>,
}

impl Measurement {
    /// |gap error| at (s, t) of the cell, both multiples of 1/20.
    pub fn gap_at(&self, [s, t]: [f64; 2]) -> f64 {
        let [i, j] = [s, t].map(|s| (s * PLACES as f64).round() as usize);
        self.errors[i + PLACES * j].abs()
    }
}

/// Puts slaves on the exact surface all over one cell. Their gap ought to be zero.
pub fn measure(
    shape: Shape,
    cell_degrees: f64,
    (name, element): (&'static str, ContactElement),
) -> Result<Measurement, StudyError> {
    let h = cell_degrees.to_radians();
    let Patch { positions, facets } = shape.mesh(h);
    let place = |k: usize| k as f64 / PLACES as f64;
    let exact: Vec<(Point, Point)> =
        (0..PLACES * PLACES).map(|k| shape.at(h, [place(k % PLACES), place(k / PLACES)])).collect();
    let options = InterfaceOptions::default().with_element(element);
    let slaves = exact.iter().map(|(position, _)| *position);
    let (mut interface, _) = paired(positions, facets, slaves, options)?;
    let contacts = interface.evaluate(Mode::Value)?;
    let (mut errors, mut angles) = (Vec::new(), Vec::new());
    for (slave, (contact, (_, normal))) in contacts.iter().zip(&exact).enumerate() {
        if let Outcome::None(reason) = contact.outcome {
            let case = format!("{}, cells of {cell_degrees}°, {name}", shape.description());
            return Err(StudyError::NoContact { case, slave, reason });
        }
        errors.push(contact.point.gap);
        angles.push(angle(contact.point.normal, *normal));
    }
    let masters: Vec<usize> = (0..exact.len())
        .filter_map(|slave| match interface.element(slave) {
            Ok(PairedElement::Diffuse { pairing, .. }) => Some(weighted(&pairing).count()),
            _ => None,
        })
        .collect();
    let mean = |numbers: &[f64]| numbers.iter().map(|x| x.abs()).sum::<f64>() / numbers.len() as f64;
    let most = |numbers: &[f64]| numbers.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    Ok(Measurement {
        shape,
        cell_degrees,
        element: name,
        gap_max: most(&errors),
        gap_mean: mean(&errors),
        normal_max_degrees: most(&angles),
        normal_mean_degrees: mean(&angles),
        masters_mean: (!masters.is_empty())
            .then(|| masters.iter().sum::<usize>() as f64 / masters.len() as f64),
        masters_max: masters.iter().copied().max(),
        errors,
    })
}

/// Angle between unit vectors, degrees; by the chord, so that small angles keep their digits.
pub fn angle(a: Point, b: Point) -> f64 {
    let chord = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    (2.0 * (0.5 * chord).min(1.0).asin()).to_degrees()
}

/// Order of an error between two sizes; `None` if there is none.
pub fn order(errors: [f64; 2], sizes: [f64; 2]) -> Option<f64> {
    let order = (errors[0] / errors[1]).ln() / (sizes[0] / sizes[1]).ln();
    order.is_finite().then_some(order)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_keep_their_digits() {
        let small = 1e-9_f64;
        assert!((angle([0.0, 0.0, 1.0], [small.sin(), 0.0, small.cos()]) - small.to_degrees()).abs() < 1e-20);
        assert!((angle([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]) - 90.0).abs() < 1e-12);
    }

    #[test]
    fn the_order_of_a_parabola_is_two() {
        assert!((order([4.0, 1.0], [2.0, 1.0]).unwrap() - 2.0).abs() < 1e-15);
        assert_eq!(order([0.0, 0.0], [2.0, 1.0]), None);
    }

    /// Any quadratic through four columns of nodes symmetric about the middle of the facet has the same value there.
    #[test]
    fn in_the_middle_of_a_cylinders_facet_the_weight_makes_no_difference() {
        let h = 10_f64.to_radians();
        // Through (h/2, c₁), (3h/2, c₂), even: the value at 0 of the parabola in the chord's coordinate.
        let point = |angle: f64| [100.0 * angle.sin(), 100.0 * angle.cos()];
        let [[x1, z1], [x2, z2]] = [point(0.5 * h), point(1.5 * h)];
        let expected = 100.0 - (z1 + (z1 - z2) * x1 * x1 / (x2 * x2 - x1 * x1));
        for weight in Weight::ALL {
            let element = (weight.name(), diffuse(weight, FrameDerivative::CoMoving, Default::default()));
            let found = measure(Shape::Cylinder, 10.0, element).unwrap().gap_at([0.5, 0.5]);
            assert!((found - expected.abs()).abs() < 1e-9, "{}: {found} {expected}", weight.name());
        }
    }
}
