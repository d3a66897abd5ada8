//! Laws of the normal force.

use std::fmt;

use diffuse_contact_kernels::interpolated;

use super::AssemblyError;
use crate::Mode;

/// The pressure of a contact by its gap, such as a law of the user's own.
///
/// It is asked from many threads at once, and has to answer the same each time. Contact over faces asks it for the average gap of each
/// node of the slave.
pub trait NormalLaw: fmt::Debug + Send + Sync {
    /// p(g) and ∂p/∂g of the `slave`-th slave at its signed gap: pressure, or over nodes without areas force. A contact whose
    /// pressure is not positive is open; both have to be finite.
    fn pressure(&self, slave: usize, gap: f64) -> NormalPressure;

    /// The gap c at which the pressure begins as the contact closes. Friction of a slave that was open by g₀ when a step was
    /// [accepted](crate::ContactInterface::accept) counts from its place of touch, which is estimated with g₀ − c. It has to be finite.
    fn onset(&self, _slave: usize) -> f64 {
        0.0
    }

    /// By how much ∂p/∂g differs from central differences of p over 2 `step`, relative to the larger of both: about
    /// `step`² where p is smooth. A check of a law of one's own.
    fn derivative_error(&self, slave: usize, gap: f64, step: f64) -> f64 {
        let at = |gap: f64| self.pressure(slave, gap);
        let slope = (at(gap + step).pressure - at(gap - step).pressure) / (2.0 * step);
        let by_gap = at(gap).by_gap;
        let largest = slope.abs().max(by_gap.abs());
        if largest == 0.0 { 0.0 } else { (slope - by_gap).abs() / largest }
    }
}

/// A pressure with its derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalPressure {
    /// p, force per area, or force.
    pub pressure: f64,
    /// ∂p/∂g, negative where contact gets stiffer as it closes.
    pub by_gap: f64,
}

/// A pressure by a table of gaps: linear between them and beyond them.
#[derive(Clone, Debug, PartialEq)]
pub struct TabulatedPressure(Table);

impl TabulatedPressure {
    /// The pressures at ascending gaps, of which there are at least two. Beyond its ends the table goes on along its outer lines; what
    /// is negative there is an open contact.
    ///
    /// # Errors
    /// [`AssemblyError::InvalidTable`] with the place of the first entry that is not finite or does not ascend, in gaps and pressures
    /// one after another, or of the first that is missing or too many.
    pub fn new(gaps: &[f64], pressures: &[f64]) -> Result<Self, AssemblyError> {
        if gaps.len() < 2 {
            return Err(AssemblyError::InvalidTable { place: gaps.len() });
        }
        let table = Table::new(gaps, &[0.0], pressures);
        // The axis that nothing depends on is none of the caller's numbers.
        let own = |place: usize| if place > gaps.len() { place - 1 } else { place };
        table.map(Self).map_err(|place| AssemblyError::InvalidTable { place: own(place) })
    }
}

impl NormalLaw for TabulatedPressure {
    fn pressure(&self, _slave: usize, gap: f64) -> NormalPressure {
        let (pressure, [by_gap, _]) = self.0.extended(gap, 0.0);
        NormalPressure { pressure, by_gap }
    }

    /// Of the lines that fall from pressure to none, the root of the one at the largest gap; 0 if there is none.
    fn onset(&self, _slave: usize) -> f64 {
        let ([gaps, _], pressures) = (&self.0.axes, &self.0.values);
        let last = gaps.len() - 2;
        let root = |k: usize| {
            let ([from, to], [before, after]) = ([gaps[k], gaps[k + 1]], [pressures[k], pressures[k + 1]]);
            let begins = before > 0.0 || k == 0;
            let ends = after <= 0.0 || k == last;
            // From the end without pressure: where that is 0 the root is its gap to the last bit.
            (before > after && begins && ends).then(|| to + (to - from) * (after / (before - after)))
        };
        (0..=last).rev().find_map(root).unwrap_or(0.0)
    }
}

/// Values over a grid of two numbers, bilinear in each cell.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Table {
    axes: [Vec<f64>; 2],
    values: Vec<f64>,
}

/// Two neighbours on an axis, and the places of their values.
struct Cell {
    ends: [f64; 2],
    places: [usize; 2],
}

impl Table {
    /// The error is a place among the numbers, one slice after another.
    pub fn new(x: &[f64], y: &[f64], values: &[f64]) -> Result<Self, usize> {
        let mut start = 0;
        for axis in [x, y] {
            let is_bad = |k: &usize| !axis[*k].is_finite() || (*k > 0 && !(axis[*k] > axis[*k - 1]));
            if let Some(k) = (0..axis.len()).find(is_bad) {
                return Err(start + k);
            }
            if axis.is_empty() {
                return Err(start);
            }
            start += axis.len();
        }
        let expected = x.len() * y.len();
        if values.len() != expected {
            return Err(start + expected.min(values.len()));
        }
        match values.iter().position(|value| !value.is_finite()) {
            Some(k) => Err(start + k),
            None => Ok(Self { axes: [x.to_vec(), y.to_vec()], values: values.to_vec() }),
        }
    }

    /// The value and its derivatives, constant beyond the ends.
    pub fn value(&self, x: f64, y: f64) -> (f64, [f64; 2]) {
        let within = |axis: usize, x: f64| {
            let axis = &self.axes[axis];
            let (first, last) = (axis[0], axis[axis.len() - 1]);
            (x.max(first).min(last), first <= x && x < last)
        };
        let ((x_in, x_counts), (y_in, y_counts)) = (within(0, x), within(1, y));
        let (value, [by_x, by_y]) = self.extended(x_in, y_in);
        (value, [if x_counts { by_x } else { 0.0 }, if y_counts { by_y } else { 0.0 }])
    }

    /// The same, linear beyond the ends.
    pub fn extended(&self, x: f64, y: f64) -> (f64, [f64; 2]) {
        let [along_x, along_y] = [self.cell(0, x), self.cell(1, y)];
        let at = |i: usize, j: usize| self.values[along_x.places[i] * self.axes[1].len() + along_y.places[j]];
        let inputs = interpolated::Inputs {
            x,
            y,
            first_x: along_x.ends[0],
            last_x: along_x.ends[1],
            first_y: along_y.ends[0],
            last_y: along_y.ends[1],
            value_00: at(0, 0),
            value_10: at(1, 0),
            value_11: at(1, 1),
            value_01: at(0, 1),
        };
        let results = interpolated::evaluate(Mode::Gradient, &inputs);
        (results.values.value, results.value_jacobian)
    }

    /// Of an axis with one number the values are the same at both ends.
    fn cell(&self, axis: usize, x: f64) -> Cell {
        let axis = &self.axes[axis];
        if axis.len() < 2 {
            return Cell { ends: [axis[0], axis[0] + axis[0].abs().max(1.0)], places: [0, 0] };
        }
        let k = axis.partition_point(|&end| end <= x).clamp(1, axis.len() - 1);
        Cell { ends: [axis[k - 1], axis[k]], places: [k - 1, k] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_begin_where_their_last_line_falls_to_no_pressure() {
        for (gaps, pressures, onset) in [
            (&[-0.1, -0.02, 0.0][..], &[41.0, 1.0, 0.0][..], 0.0),
            (&[-0.1, 0.3], &[4.0, 0.0], 0.3),
            (&[-0.1, 0.3, 0.5, 1.0], &[4.0, 0.0, 0.0, -1.0], 0.3),
            // Between two gaps, beyond the last and before the first.
            (&[-1.0, 1.0], &[3.0, -1.0], 0.5),
            (&[-2.0, -1.0], &[2.0, 1.0], 0.0),
            (&[0.0, 1.0], &[-1.0, -2.0], -1.0),
            // Of two branches the one at the larger gap; pressure that ends nowhere.
            (&[-2.0, -1.0, 0.0, 1.0], &[1.0, 0.0, 1.0, 0.0], 1.0),
            (&[-1.0, 0.0], &[1.0, 2.0], 0.0),
        ] {
            let table = TabulatedPressure::new(gaps, pressures).unwrap();
            assert_eq!(table.onset(0), onset, "{gaps:?} {pressures:?}");
            assert!(table.pressure(0, onset).pressure.abs() < 1e-15 || onset == 0.0);
        }
    }
}
