//! Weight functions w(r) of compact support.

use crate::expr::Expr;
use crate::formula::{Formula, FormulaError};
use crate::graph::{Polynomial, Scope};

/// A weight function: a name for the emitted code and a formula ω in r = distance / support radius.
///
/// Or several of them, of which a kernel's input says which one it is: see [`either`](Self::either).
#[derive(Clone, Debug, PartialEq)]
pub struct Weight {
    name: String,
    text: String,
    formula: Formula,
    interpolating: bool,
    /// What the weight is if the input is not 0, but 1, 2, ….
    others: Vec<Formula>,
}

/// Name of the input of element scope that says which of several weights it is.
pub(crate) const WEIGHT_NUMBER: &str = "weight_number";
/// Name of the input of node scope R/R_k: the support radius over the radius of the node's domain of influence.
pub(crate) const DOMAIN_RATIO: &str = "domain_ratio";
/// Name of the input of element scope that scales the distances which weight nodes in the average plane: 0 weights all alike.
pub(crate) const PLANE_REACH: &str = "plane_reach";

/// A weight at a node.
#[derive(Clone, Copy, Debug)]
pub(super) enum NodeWeight<'g> {
    /// w = ω
    Fitting(Expr<'g>),
    /// w = ω/(1 − ω) (16), with 1/w, which is smooth where w has its pole.
    Interpolating {
        /// w, for r > 0.
        weight: Expr<'g>,
        /// 1/w, for r < 1.
        compliance: Expr<'g>,
    },
}

/// Why a formula cannot serve as a weight.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum WeightError {
    /// The formula cannot be read.
    #[error(transparent)]
    Formula(#[from] FormulaError),
    /// The weight has a kink at r = 0, where it must be differentiable.
    #[error("the weight \"{formula}\" has a kink at r = 0: its slope there is {slope}, not 0")]
    Kink { formula: String, slope: f64 },
    /// The weight has no expansion at r = 0.
    #[error(
        "the weight \"{formula}\" is not smooth at r = 0: coefficient {order} of its expansion is {value}"
    )]
    NotSmooth { formula: String, order: usize, value: f64 },
    /// The weight is not a positive number somewhere in 0 ≤ r < 1.
    #[error("the weight \"{formula}\" must be positive for 0 <= r < 1, but is {value} at r = {r}")]
    NotPositive { formula: String, r: f64, value: f64 },
    /// A weight to be made interpolating is not 1 at r = 0, or is not below 1 elsewhere.
    #[error(
        "the weight \"{formula}\" cannot be made interpolating: it is {value} at r = {r}, but has to be 1 at r = 0 and below 1 \
         elsewhere"
    )]
    NotInterpolating { formula: String, r: f64, value: f64 },
    /// The name cannot name a Rust module and a kernel set.
    #[error(
        "\"{name}\" cannot name a module and its kernel set: use lower-case letters, digits and _, a letter first, no \
         keyword, and no name of the support module"
    )]
    Name { name: String },
}

/// What is to be known of a weight that can be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum WeightNote {
    /// The weight does not end at r = 1 with value and slope 0. `value` is w(1), 0 where it is rounding; `slope` is w'(1).
    #[error(
        "the weight \"{formula}\" should end with value and slope 0 at r = 1, but has value {value} and slope {slope} there: where \
         a node enters or leaves the support, the {} of the surface jump{}",
        if *.value == 0.0 { "normals" } else { "points and normals" },
        if *.value == 0.0 { ", and with them the contact force" } else { ", and with them gap and contact force" }
    )]
    OpenRim { formula: String, value: f64, slope: f64 },
}

/// Distance from r = 1 over which the slope there is measured.
const RIM: f64 = 1.0 / (1 << 26) as f64;
/// Largest value and slope at r = 1, over the weight at r = 0, that count as 0.
const FLAT: [f64; 2] = [1e-10, 1e-4];

/// Coefficients of the expansion that replaces a formula near r = 0.
const TAYLOR_COEFFICIENTS: usize = 16;
/// Largest radius at which the expansion is used.
const TAYLOR_RADIUS: f64 = 1.0 / 64.0;
/// Points at which a weight is checked to be positive.
const SAMPLES: u32 = 256;

impl Weight {
    /// The cubic weight of the paper, w = (1 − r)² (1 + 2r) (Chamoret et al. 2008, eq. 14).
    ///
    /// # Panics
    /// Never: the formula is valid.
    pub fn cubic() -> Self {
        Self::new("cubic", "(1 - r)^2 * (1 + 2*r)").expect("a valid weight")
    }

    /// A weight given by a formula for 0 ≤ r < 1; it is cut to 0 for r ≥ 1. `name` names the emitted module.
    ///
    /// The formula must be positive, and differentiable at r = 0 as a function of the position, w'(0) = 0. Let
    /// it and its first derivative vanish at r = 1, or the fit jumps when a node leaves the support.
    pub fn new(name: &str, formula: &str) -> Result<Self, WeightError> {
        if !is_module_name(name) {
            return Err(WeightError::Name { name: name.to_owned() });
        }
        let weight = Self {
            name: name.to_owned(),
            text: formula.trim().to_owned(),
            formula: Formula::parse(formula)?,
            interpolating: false,
            others: Vec::new(),
        };
        weight.check()?;
        Ok(weight)
    }

    /// One weight for several that are not interpolating, so that they share kernels: the input
    /// `weight_number` says which of them it is, counted from 0. `None` if there are none, or one is interpolating or
    /// several weights itself.
    pub fn either(weights: &[Self]) -> Option<Self> {
        let (first, others) = weights.split_first()?;
        if weights.iter().any(|weight| weight.interpolating || weight.is_several()) {
            return None;
        }
        let names: Vec<&str> = weights.iter().map(|weight| weight.name.as_str()).collect();
        let texts: Vec<&str> = weights.iter().map(|weight| weight.text.as_str()).collect();
        Some(Self {
            name: names.join("_or_"),
            text: texts.join(" or "),
            formula: first.formula.clone(),
            interpolating: false,
            others: others.iter().map(|weight| weight.formula.clone()).collect(),
        })
    }

    /// Whether this is several weights, made by [`either`](Self::either).
    pub const fn is_several(&self) -> bool {
        !self.others.is_empty()
    }

    /// The C² weight (1 − r)⁴ (1 + 4r) (Wendland 1995), in the module `wendland_c2`.
    ///
    /// # Panics
    /// Never: the formula is valid.
    pub fn wendland_c2() -> Self {
        Self::new("wendland_c2", "(1 - r)^4 * (1 + 4*r)").expect("a valid weight")
    }

    /// The weight ω/(1 − ω) made from a weight ω with ω(0) = 1 (Chamoret et al. 2008, eq. 16): it has a pole at the
    /// node, so the surface passes through the nodes.
    ///
    /// # Errors
    /// [`WeightError`]; [`WeightError::NotInterpolating`] if ω(0) is not 1 or ω is not below 1 for some r > 0.
    pub fn interpolating(name: &str, formula: &str) -> Result<Self, WeightError> {
        let weight = Self { interpolating: true, ..Self::new(name, formula)? };
        weight.check_pole()?;
        Ok(weight)
    }

    /// The paper's cubic weight made interpolating (16), in the module `cubic_interpolating`.
    ///
    /// # Panics
    /// Never: the formula is valid.
    pub fn cubic_interpolating() -> Self {
        Self::interpolating("cubic_interpolating", "(1 - r)^2 * (1 + 2*r)").expect("a valid weight")
    }

    /// Whether the weight has a pole at r = 0.
    pub const fn is_interpolating(&self) -> bool {
        self.interpolating
    }

    /// Name in emitted code.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The formula as it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// What is to be known of the weight, though it can be used.
    pub fn note(&self) -> Option<WeightNote> {
        let [origin, inside, rim] = [0.0, 1.0 - RIM, 1.0].map(|r| self.formula.evaluate(r));
        let flat = FLAT.map(|part| part * origin);
        let slope = (rim - inside) / RIM;
        if rim.abs() <= flat[0] && slope.abs() <= flat[1] {
            return None;
        }
        let formula = self.text.split_whitespace().collect::<Vec<_>>().join(" ");
        // As many digits as the difference has.
        let rounded = |x: f64| (x * 1e6).round() / 1e6;
        let value = if rim.abs() <= flat[0] { 0.0 } else { rounded(rim) };
        Some(WeightNote::OpenRim { formula, value, slope: rounded(slope) })
    }

    /// ω at r, 0 where r ≥ 1; of several weights that of the first.
    pub fn fitting_value(&self, r: f64) -> f64 {
        if r < 1.0 { self.formula.evaluate(r) } else { 0.0 }
    }

    /// The formula of ω.
    pub(crate) const fn formula(&self) -> &Formula {
        &self.formula
    }

    fn check(&self) -> Result<(), WeightError> {
        let formula = || self.text.clone();
        let expansion = self.formula.taylor(TAYLOR_COEFFICIENTS);
        if let Some((order, &value)) = expansion.iter().enumerate().find(|(_, c)| !c.is_finite()) {
            return Err(WeightError::NotSmooth { formula: formula(), order, value });
        }
        if expansion[1].abs() > 1e-13 * expansion[0].abs() {
            return Err(WeightError::Kink { formula: formula(), slope: expansion[1] });
        }
        for r in (0..SAMPLES).map(|k| f64::from(k) / f64::from(SAMPLES)) {
            let value = self.formula.evaluate(r);
            if !(value > 0.0 && value.is_finite()) {
                return Err(WeightError::NotPositive { formula: formula(), r, value });
            }
        }
        Ok(())
    }

    /// 1 − ω has a simple zero in r² at r = 0 and no other.
    fn check_pole(&self) -> Result<(), WeightError> {
        let error = |r, value| Err(WeightError::NotInterpolating { formula: self.text.clone(), r, value });
        let expansion = self.formula.taylor(TAYLOR_COEFFICIENTS);
        if (expansion[0] - 1.0).abs() > 1e-15 || !(expansion[2] < 0.0) {
            return error(0.0, expansion[0]);
        }
        for r in (1..SAMPLES).map(|k| f64::from(k) / f64::from(SAMPLES)) {
            let value = self.formula.evaluate(r);
            if !(value < 1.0) {
                return error(r, value);
            }
        }
        Ok(())
    }

    /// ω at the norm `r`, an expression made by [`Expr::hypot`]; 0 where r ≥ 1.
    pub(super) fn fitting<'g>(&self, r: Expr<'g>) -> Expr<'g> {
        let mut inside = around_origin(&self.formula, r, false);
        for (number, formula) in self.others.iter().enumerate() {
            let chosen = r.sheet().input_once(WEIGHT_NUMBER, Scope::Element);
            inside = chosen.less(number as f64 + 0.5).select(inside, around_origin(formula, r, false));
        }
        r.less(1.0).select(inside, 0.0)
    }

    /// w at the norm `r`, an expression made by [`Expr::hypot`]; 0 where r ≥ 1.
    pub(super) fn evaluate<'g>(&self, r: Expr<'g>) -> NodeWeight<'g> {
        let omega = self.fitting(r);
        if !self.interpolating {
            return NodeWeight::Fitting(omega);
        }
        let omega = omega.named("omega");
        let inside = around_origin(&self.formula, r, true);
        let complement = r.less(1.0).select(inside, 1.0).named("one_minus_omega");
        NodeWeight::Interpolating { weight: omega / complement, compliance: complement / omega }
    }
}

/// Whether a module and, in camel case, a kernel set can have this name.
pub(super) fn is_module_name(name: &str) -> bool {
    /// Types of the support module in lower case, and its own name.
    const TAKEN: [&str; 36] = [
        "basis",
        "batch",
        "batchelement",
        "coefficientsvalues",
        "custombasis",
        "domains",
        "elementinputs",
        "equations",
        "facet",
        "facetfigures",
        "formrows",
        "framerule",
        "gapkernel",
        "gapvalues",
        "inputs",
        "isa",
        "kernelset",
        "lane",
        "masters",
        "materialnode",
        "mode",
        "rootsolution",
        "second",
        "secondkind",
        "shape",
        "single",
        "solution",
        "status",
        "support",
        "surfacevalues",
        "twoequations",
        "twovariables",
        "vector",
        "widths",
        "withlanes",
        "workspace",
    ];
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
        && syn::parse_str::<syn::Ident>(name).is_ok()
        && !TAKEN.contains(&name.replace('_', "").as_str())
}

/// The formula ω on an interval that contains r = 0, in a form whose derivatives by position are finite and exact
/// there: a polynomial of r without r¹ ([`Expr::polynomial`]), exactly or, if the formula is none, its expansion.
///
/// As `complement`, 1 − ω from the expansion of ω without its 1: no digits are lost near r = 0, where 1 − ω vanishes.
fn around_origin<'g>(formula: &Formula, r: Expr<'g>, complement: bool) -> Expr<'g> {
    let series = |mut coefficients: Vec<f64>| {
        if complement {
            coefficients.iter_mut().for_each(|c| *c = -*c);
            coefficients[0] = 0.0;
        }
        power_sum(coefficients, r)
    };
    let plain_part = |f: &Formula| if complement { 1.0 - plain(f, r) } else { plain(f, r) };
    if let Some(coefficients) = formula.polynomial() {
        return series(coefficients);
    }
    if let Formula::If { x, y, then, otherwise } = formula {
        let (then, otherwise) = if x.evaluate(0.0) < y.evaluate(0.0) {
            (around_origin(then, r, complement), plain_part(otherwise))
        } else {
            (plain_part(then), around_origin(otherwise, r, complement))
        };
        return plain(x, r).less(plain(y, r)).select(then, otherwise);
    }
    let coefficients = formula.taylor(TAYLOR_COEFFICIENTS);
    let radius = expansion_radius(formula, &coefficients);
    let (near, far) = (series(coefficients), plain_part(formula));
    r.less(radius).select(near, far)
}

/// Largest radius, at most [`TAYLOR_RADIUS`], up to which the expansion agrees with the formula.
fn expansion_radius(formula: &Formula, coefficients: &[f64]) -> f64 {
    let agrees = |r: f64| {
        let sum = coefficients.iter().rev().fold(0.0, |total, c| total * r + c);
        let value = formula.evaluate(r);
        // The last terms bound what is cut off, also in the second derivative.
        let cut_off: f64 = (coefficients.len() - 2..coefficients.len())
            .map(|k| (coefficients[k] * (k * k) as f64 * r.powi(k as i32 - 2)).abs())
            .sum();
        (sum - value).abs() <= 4.0 * f64::EPSILON * value.abs() && cut_off <= f64::EPSILON * value.abs()
    };
    let mut radius = TAYLOR_RADIUS;
    while radius > f64::MIN_POSITIVE && !(1..=8).all(|k| agrees(radius * f64::from(k) / 8.0)) {
        radius /= 2.0;
    }
    radius
}

/// c₀ + c₂ r² + c₃ r³ + …; a kink c₁ r was refused before, what is left of it is rounding.
fn power_sum(mut coefficients: Vec<f64>, r: Expr<'_>) -> Expr<'_> {
    if let Some(slope) = coefficients.get_mut(1) {
        *slope = 0.0;
    }
    r.polynomial(Polynomial::new(coefficients))
}

/// The formula as it stands, for r > 0.
fn plain<'g>(formula: &Formula, r: Expr<'g>) -> Expr<'g> {
    if let Some(coefficients) = formula.polynomial() {
        return r.polynomial(Polynomial::new(coefficients));
    }
    let of = |x: &Formula| plain(x, r);
    match formula {
        Formula::Number(value) => r.sheet().number(*value),
        Formula::Radius => r,
        Formula::Neg(x) => -of(x),
        Formula::Add(x, y) => of(x) + of(y),
        Formula::Sub(x, y) => of(x) - of(y),
        Formula::Mul(x, y) => of(x) * of(y),
        Formula::Div(x, y) => of(x) / of(y),
        Formula::Power(x, k) => of(x).powi(*k),
        Formula::Exp(x) => of(x).exp(),
        Formula::Sqrt(x) => of(x).sqrt(),
        Formula::If { x, y, then, otherwise } => of(x).less(of(y)).select(of(then), of(otherwise)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unfit_formulas_are_refused_with_a_reason() {
        let error = |formula: &str| Weight::new("test", formula).unwrap_err();
        assert!(matches!(error("1 - r"), WeightError::Kink { slope, .. } if slope == -1.0));
        assert!(matches!(error("sqrt(r)"), WeightError::NotSmooth { order: 1, .. }));
        assert!(matches!(error("1 / r^2"), WeightError::NotSmooth { order: 0, .. }));
        assert!(matches!(error("1 - 4*r^2"), WeightError::NotPositive { r, .. } if r == 0.5));
        assert!(matches!(error("1 - q"), WeightError::Formula(_)));
        assert!(matches!(Weight::new("My weight", "1"), Err(WeightError::Name { .. })));
    }

    #[test]
    fn a_weight_made_interpolating_is_one_at_the_node_only() {
        let error = |formula: &str| Weight::interpolating("test", formula).unwrap_err();
        assert!(matches!(
            error("2*(1-r)^2*(1+2*r)"),
            WeightError::NotInterpolating { r: 0.0, value: 2.0, .. }
        ));
        assert!(matches!(error("1+r^2"), WeightError::NotInterpolating { r: 0.0, .. }));
        assert!(matches!(error("1-r^2+9*r^4"), WeightError::NotInterpolating { r, .. } if r > 0.3));
        for formula in ["(1-r)^4*(1+4*r)", "exp(-4*r^2)", "if r < 0.5 { 1-r^2 } else { 1.5*(1-r) }"] {
            assert!(Weight::interpolating("test", formula).unwrap().is_interpolating());
        }
    }

    #[test]
    fn interpolating_weights_are_not_put_together() {
        assert!(Weight::either(&[]).is_none());
        assert!(Weight::either(&[Weight::cubic(), Weight::cubic_interpolating()]).is_none());
        let both = Weight::either(&[Weight::cubic(), Weight::wendland_c2()]).unwrap();
        assert!(both.is_several() && both.name() == "cubic_or_wendland_c2");
        assert!(Weight::either(&[both, Weight::cubic()]).is_none());
    }

    #[test]
    fn a_weight_that_does_not_end_flat_has_a_note() {
        let note = |formula: &str| Weight::new("test", formula).unwrap().note();
        for flat in [
            "(1 - r)^2 * (1 + 2*r)",
            "1 - 3*r^2 + 2*r^3",
            "(1 - r)^4 * (1 + 4*r)",
            "exp(-r) * (1 + r) * (1 - r^2)^2",
            "1e9 * (1 - r^2)^2",
            "if r < 0.5 { 2/3 - 4*r^2 + 4*r^3 } else { 4/3*(1 - r)^3 }",
        ] {
            assert_eq!(note(flat), None, "{flat}");
        }
        let Some(WeightNote::OpenRim { formula, value, slope }) = note(" 1 -\n r^2") else {
            panic!("no note")
        };
        assert_eq!((formula.as_str(), value, slope), ("1 - r^2", 0.0, -2.0));
        let Some(WeightNote::OpenRim { value, slope, .. }) = note("exp(-4*r^2)") else { panic!("no note") };
        assert!((value - (-4.0_f64).exp()).abs() < 1e-6 && (slope + 8.0 * (-4.0_f64).exp()).abs() < 1e-5);
        assert!(note("1 - 0.9999*r^2").unwrap().to_string().contains("gap and contact force"));
        assert!(Weight::interpolating("test", "1 - r^2").unwrap().note().is_some());
    }

    #[test]
    fn formulas_without_a_kink_are_accepted() {
        for formula in [
            "exp(-r)*(1 + r)",
            "(1-r)^4*(1+4*r)",
            "exp(-4*r^2)",
            "if r < 0.5 { 2/3-4*r^2+4*r^3 } else { 4/3-4*r+4*r^2-4/3*r^3 }",
        ] {
            Weight::new("test", formula).unwrap();
        }
    }
}
