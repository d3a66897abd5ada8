//! Hertz' contact of a cylinder or a ball with a plane, and the pressure that a run finds.

use std::f64::consts::PI;

use super::Snapshot;

/// A long cylinder on a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineContact {
    /// Force per length of the whole cylinder, force per length.
    pub force: f64,
    /// Its radius, length.
    pub radius: f64,
    /// E* = E / (1 − ν²) if the plane is rigid, force per area.
    pub modulus: f64,
}

impl LineContact {
    /// a = √(4 F R / (π E*)), length.
    pub fn half_width(&self) -> f64 {
        (4.0 * self.force * self.radius / (PI * self.modulus)).sqrt()
    }

    /// p₀ = 2 F / (π a), force per area.
    pub fn peak_pressure(&self) -> f64 {
        2.0 * self.force / (PI * self.half_width())
    }
}

/// A ball on a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointContact {
    /// Force on the whole ball.
    pub force: f64,
    /// Its radius, length.
    pub radius: f64,
    /// E* = E / (1 − ν²) if the plane is rigid, force per area.
    pub modulus: f64,
}

impl PointContact {
    /// a = (3 F R / (4 E*))^⅓, length.
    pub fn half_width(&self) -> f64 {
        (3.0 * self.force * self.radius / (4.0 * self.modulus)).cbrt()
    }

    /// p₀ = 3 F / (2 π a²), force per area.
    pub fn peak_pressure(&self) -> f64 {
        1.5 * self.force / (PI * self.half_width().powi(2))
    }
}

/// Pressure of a slave node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodalPressure {
    /// Distance from the line or the point of first touch at the start, length.
    pub distance: f64,
    /// Contact force over tributary area at the start, force per area.
    pub pressure: f64,
}

/// The pressures of a contact around a line or a point.
#[derive(Clone, Debug, PartialEq)]
pub struct PressureProfile {
    /// All slaves that carry force, by distance.
    pub nodes: Vec<NodalPressure>,
}

impl PressureProfile {
    /// Pressures of the slaves, whose interfaces carry areas; `distance` of a position at the start.
    pub fn of(snapshot: &Snapshot<'_>, distance: impl Fn([f64; 3]) -> f64) -> Self {
        let pressed = snapshot.slaves().filter(|slave| slave.force > 0.0);
        let mut nodes: Vec<NodalPressure> = pressed
            .map(|slave| NodalPressure {
                distance: distance(snapshot.problem.start_positions()[slave.node]),
                pressure: slave.force / slave.area,
            })
            .collect();
        nodes.sort_by(|one, other| one.distance.total_cmp(&other.distance));
        Self { nodes }
    }

    /// The largest pressure of any node; 0 without contact.
    pub fn largest(&self) -> f64 {
        self.nodes.iter().map(|node| node.pressure).fold(0.0, f64::max)
    }

    /// Peak p₀ and half width a of p² = p₀² (1 − x²/a²), the form that Hertz' pressure has in both cases, by least squares over the nodes
    /// with at least half of the largest pressure: the outer ones lie on elements that touch only in part. `None`: fewer than three
    /// such nodes, or they lie on no ellipse.
    pub fn ellipse(&self) -> Option<[f64; 2]> {
        let limit = 0.5 * self.largest();
        let points: Vec<[f64; 2]> = self
            .nodes
            .iter()
            .filter(|node| node.pressure >= limit)
            .map(|node| [node.distance.powi(2), node.pressure.powi(2)])
            .collect();
        if points.len() < 3 {
            return None;
        }
        let count = points.len() as f64;
        let mean = [0, 1].map(|k| points.iter().map(|point| point[k]).sum::<f64>() / count);
        let (mut variance, mut covariance) = (0.0, 0.0);
        for [x, y] in points {
            variance += (x - mean[0]).powi(2);
            covariance += (x - mean[0]) * (y - mean[1]);
        }
        let slope = covariance / variance;
        let top = mean[1] - slope * mean[0];
        (slope < 0.0 && top > 0.0).then(|| [top.sqrt(), (-top / slope).sqrt()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pressures over the contact add up to the force.
    #[test]
    fn pressure_balances_the_force() {
        let line = LineContact { force: 300.0, radius: 10.0, modulus: 2e5 };
        let (a, p0) = (line.half_width(), line.peak_pressure());
        assert!((0.5 * PI * a * p0 / line.force - 1.0).abs() < 1e-14);
        // Curvature of the surface that the elliptic pressure makes plane: a = 2 p₀ R / E*.
        assert!((2.0 * p0 * line.radius / line.modulus / a - 1.0).abs() < 1e-14);

        let point = PointContact { force: 300.0, radius: 10.0, modulus: 2e5 };
        let (a, p0) = (point.half_width(), point.peak_pressure());
        assert!((2.0 / 3.0 * PI * a * a * p0 / point.force - 1.0).abs() < 1e-14);
        // a = π p₀ R / (2 E*)
        assert!((0.5 * PI * p0 * point.radius / point.modulus / a - 1.0).abs() < 1e-14);
    }

    #[test]
    fn an_ellipse_is_found() {
        let node = |x: f64| NodalPressure { distance: x, pressure: 50.0 * (1.0 - (x / 2.0).powi(2)).sqrt() };
        let profile = PressureProfile { nodes: [0.1, 0.5, 0.9, 1.4, 1.9].map(node).to_vec() };
        let [p0, a] = profile.ellipse().unwrap();
        assert!((p0 - 50.0).abs() < 1e-12 && (a - 2.0).abs() < 1e-12, "{p0} {a}");
        let flat = PressureProfile { nodes: vec![NodalPressure { distance: 1.0, pressure: 3.0 }; 4] };
        assert_eq!(flat.ellipse(), None);
        assert_eq!(PressureProfile { nodes: Vec::new() }.ellipse(), None);
    }
}
