//! What a comparison found, as a table or as JSON.

use std::fmt;

use diffuse_contact_codegen::{Basis, Output};
use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::balance::BalanceRow;
use super::blocks::{Block, Subject, blocks};
use super::elements::{
    LARGEST_CHANGE, LARGEST_FOOT_DISTANCE, RandomElement, SMALLEST_DETERMINANT, SMALLEST_PIVOT,
};
use super::facets::{FACETS, FacetRow};
use super::plan::{Against, ELEMENTS, Plan, TOLERANCE, Tested};
use crate::emit::frame_name;

/// Width of the first column of the table.
const SUBJECT: usize = 16;
/// Failures listed before the rest is only counted.
const MOST_FAILURES: usize = 10;

/// A difference and where it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// As [`blocks`](super::blocks) measures it.
    pub difference: f64,
    /// Basis of the element.
    pub basis: Basis,
    /// Its number of master nodes.
    pub nodes: usize,
}

impl Worst {
    pub(super) fn passes(&self) -> bool {
        self.difference <= TOLERANCE
    }

    /// Puts a difference into its place if it is worse than the one there. A NaN stays.
    fn take(place: &mut Option<Self>, difference: f64, (basis, nodes): (Basis, usize)) {
        if place.is_none_or(|worst| !worst.difference.is_nan() && !(difference <= worst.difference)) {
            *place = Some(Self { difference, basis, nodes });
        }
    }
}

/// The worst differences of one block; nothing where nothing was compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// The block.
    pub block: Block,
    /// Of which results.
    pub tested: Tested,
    /// In the order of [`Against::ALL`].
    pub worst: [Option<Worst>; Against::ALL.len()],
}

impl Row {
    /// Automatic differentiation has every block, and the interpreter has those of the kernels.
    fn is_compared(&self) -> bool {
        let has = |against: Against| self.worst[against as usize].is_some();
        has(Against::Ad) && (self.tested == Tested::Interpreter || has(Against::Interpreter))
    }

    fn passes(&self) -> bool {
        self.is_compared() && self.worst.iter().flatten().all(Worst::passes)
    }
}

/// All that was found.
#[derive(Clone, Debug)]
pub struct Report {
    plan: Plan,
    rows: Vec<Row>,
    balance: Vec<BalanceRow>,
    facets: Vec<FacetRow>,
    elements: usize,
    /// The smallest relative pivot of a fit.
    smallest_pivot: f64,
    /// The smallest relative pivot of an average plane.
    smallest_plane_pivot: f64,
    /// Backends without a result.
    pub(super) failures: Vec<String>,
}

impl Report {
    /// An empty report.
    pub(super) fn new(plan: &Plan) -> Self {
        let row = |block: Block| {
            let tested = plan.tested(block.subject.output);
            Row { block, tested, worst: [None; Against::ALL.len()] }
        };
        Self {
            plan: plan.clone(),
            rows: blocks().map(row).collect(),
            balance: BalanceRow::all(),
            facets: Vec::new(),
            elements: 0,
            smallest_pivot: f64::INFINITY,
            smallest_plane_pivot: f64::INFINITY,
            failures: Vec::new(),
        }
    }

    pub(super) fn tested(&self, subject: Subject) -> Tested {
        self.plan.tested(subject.output)
    }

    pub(super) fn add_element(&mut self, random: &RandomElement) {
        self.elements += 1;
        for figures in &random.conditioning {
            self.smallest_pivot = self.smallest_pivot.min(figures.pivot_ratio);
            self.smallest_plane_pivot = self.smallest_plane_pivot.min(figures.plane_pivot_ratio);
        }
    }

    pub(super) fn add(&mut self, block: Block, against: Against, difference: f64, at: (Basis, usize)) {
        let row = self.rows.iter_mut().find(|row| row.block == block).expect("every block has a row");
        Worst::take(&mut row.worst[against as usize], difference, at);
    }

    /// Adds the sums of an element's N, in the order of [`SUMS`](super::balance::SUMS).
    pub(super) fn add_balance(&mut self, subject: Subject, sums: [f64; 2], at: (Basis, usize)) {
        let rows = self.balance.iter_mut().filter(|row| row.subject == subject);
        rows.zip(sums).for_each(|(row, sum)| Worst::take(&mut row.worst, sum, at));
    }

    /// Adds what was found on other elements. Of equal differences the earlier one stays.
    pub(super) fn merge(&mut self, other: Self) {
        self.elements += other.elements;
        self.smallest_pivot = self.smallest_pivot.min(other.smallest_pivot);
        self.smallest_plane_pivot = self.smallest_plane_pivot.min(other.smallest_plane_pivot);
        let rows = self.rows.iter_mut().zip(other.rows);
        let rows = rows.flat_map(|(row, other)| row.worst.iter_mut().zip(other.worst));
        let sums =
            self.balance.iter_mut().zip(other.balance).map(|(row, other)| (&mut row.worst, other.worst));
        for (place, worst) in rows.chain(sums) {
            if let Some(Worst { difference, basis, nodes }) = worst {
                Worst::take(place, difference, (basis, nodes));
            }
        }
        self.failures.extend(other.failures);
    }

    pub(super) fn add_facets(&mut self, (rows, failures): (Vec<FacetRow>, Vec<String>)) {
        self.facets = rows;
        self.failures.extend(failures);
    }

    /// Whether every block was compared, every backend had results, and all differences are within [`TOLERANCE`].
    pub fn passes(&self) -> bool {
        let rows = self.rows.iter().all(Row::passes)
            && self.balance.iter().all(BalanceRow::passes)
            && self.facets.iter().all(FacetRow::passes);
        self.elements > 0 && self.failures.is_empty() && rows
    }

    fn ranges(&self) -> String {
        let counts = |(basis, range): &(Basis, std::ops::RangeInclusive<usize>)| {
            let (first, last) = (range.start(), range.end());
            let counts = if first == last { first.to_string() } else { format!("{first} to {last}") };
            format!("{} basis n = {counts}", basis.name())
        };
        self.plan.ranges.iter().map(counts).collect::<Vec<_>>().join(", ")
    }

    fn head(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tested = match (self.plan.weight.as_built_in(), self.plan.tested(Output::Slip)) {
            (Some(_), Tested::Generated) => "the generated kernels, in the modes value, gradient and Hessian",
            (Some(_), Tested::Interpreter) => {
                "the generated kernels, in the modes value, gradient and Hessian
             but of the slip the interpreter of their graph: built without the feature `friction`"
            }
            (None, _) => {
                "the interpreter of the kernels' graph, in the modes value, gradient and Hessian:
             no kernels of this weight are compiled into the program; `emit --weight` prints them"
            }
        };
        let facets =
            format!("\nfacets       {FACETS} random triangles and {FACETS} quadrilaterals, flat and warped");
        let facets = if self.facets.is_empty() { "" } else { &facets };
        let Self { plan: Plan { weight, seed, .. }, elements, smallest_pivot, smallest_plane_pivot, .. } =
            self;
        let (weight, ranges) = (weight.description(), self.ranges());
        writeln!(
            f,
            "\
tested       {tested}
weight       {weight}
kernels      {ranges}; coefficients, surface, gap, slip
elements     {ELEMENTS} random ones per node count and basis, {elements} in all; seed {seed}
             (any unit, place and direction; some with a node straight under the slave, or beyond R){facets}
frame        held in any direction; for the gap also the average plane of the nodes, co-moving
conditioning relative pivot of the fits at least {SMALLEST_PIVOT:e} (smallest here {smallest_pivot:.1e}) and of the
             average planes too ({smallest_plane_pivot:.1e}), foot Jacobian at least {SMALLEST_DETERMINANT}, foot within {LARGEST_FOOT_DISTANCE} R
             and M, ∇²q and H_f change by {LARGEST_CHANGE:e} at most with the last digits of the nodes
difference   largest over the largest entry of the block; values that may vanish over at least
             their natural scale if that is larger: R for lengths, 1 for slopes, 1/R for curvatures"
        )
    }

    fn table(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown: Vec<Against> = Against::ALL.into_iter().filter(|&against| self.has(against)).collect();
        let line = |f: &mut fmt::Formatter<'_>, output: &str, block: &str, cells: &[String]| {
            let cells = cells.iter().map(|cell| format!("{cell:<26}")).collect::<String>();
            let line = format!("{output:<SUBJECT$}{block:<10}{cells}");
            writeln!(f, "{}", line.trim_end())
        };
        let titles: Vec<String> = shown.iter().map(|against| against.title().to_owned()).collect();
        line(f, "output", "block", &titles)?;
        for row in &self.rows {
            let cells: Vec<String> = shown.iter().map(|&against| cell(row.worst[against as usize])).collect();
            line(f, &row.block.subject.name(), row.block.name, &cells)?;
        }
        for row in &self.facets {
            let cells: Vec<String> = shown.iter().map(|&a| facet_cell(row.worst[a as usize])).collect();
            line(f, row.shape.name(), row.name, &cells)?;
        }
        writeln!(
            f,
            "\nsums that vanish, over the largest entry of N; moments about the slave over R times that"
        )?;
        for row in &self.balance {
            line(f, &row.subject.name(), row.name, &[cell(row.worst)])?;
        }
        Ok(())
    }

    fn has(&self, against: Against) -> bool {
        self.rows.iter().any(|row| row.worst[against as usize].is_some())
    }

    fn verdict(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for failure in self.failures.iter().take(MOST_FAILURES) {
            writeln!(f, "no result: {failure}")?;
        }
        if self.failures.len() > MOST_FAILURES {
            writeln!(f, "no result: {} more", self.failures.len() - MOST_FAILURES)?;
        }
        if self.passes() {
            return writeln!(f, "all within {TOLERANCE:e}");
        }
        let elements = self.rows.iter().filter(|row| !row.passes());
        let facets = self.facets.iter().filter(|row| !row.passes());
        let sums = self.balance.iter().filter(|row| !row.passes());
        // With whether there is a difference: without, nothing was compared.
        let (beyond, missing): (Vec<_>, Vec<_>) = elements
            .map(|row| (format!("{} {}", row.block.subject.name(), row.block.name), row.is_compared()))
            .chain(sums.map(|row| (format!("{} {}", row.subject.name(), row.name), row.worst.is_some())))
            .chain(facets.map(|row| (format!("{} {}", row.shape.name(), row.name), row.worst[0].is_some())))
            .partition(|(_, is_compared)| *is_compared);
        let names =
            |all: &[(String, bool)]| all.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join("; ");
        if !beyond.is_empty() {
            writeln!(f, "failed: beyond {TOLERANCE:e} are {}", names(&beyond))?;
        }
        if !missing.is_empty() {
            writeln!(f, "failed: nothing is compared of {}", names(&missing))?;
        }
        if beyond.is_empty() && missing.is_empty() {
            writeln!(f, "failed: not every element has a result")?;
        }
        Ok(())
    }
}

/// A difference and its place, with a mark if it is too large.
fn cell(worst: Option<Worst>) -> String {
    let Some(worst) = worst else { return String::new() };
    if worst.difference == 0.0 {
        return "0".to_owned();
    }
    let mark = if worst.passes() { "" } else { " !" };
    format!("{:.1e} {} {}{mark}", worst.difference, worst.basis.name(), worst.nodes)
}

/// A difference on facets, with a mark if it is too large.
fn facet_cell(worst: Option<f64>) -> String {
    match worst {
        None => String::new(),
        Some(0.0) => "0".to_owned(),
        Some(difference) => format!("{difference:.1e}{}", if difference <= TOLERANCE { "" } else { " !" }),
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.head(f)?;
        writeln!(f)?;
        self.table(f)?;
        writeln!(f)?;
        self.verdict(f)
    }
}

impl Serialize for Report {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut report = serializer.serialize_struct("Report", 11)?;
        report.serialize_field("weight", &self.plan.weight.description())?;
        report.serialize_field("seed", &self.plan.seed)?;
        report.serialize_field("elements", &self.elements)?;
        report.serialize_field("smallest_pivot", &self.smallest_pivot)?;
        report.serialize_field("smallest_plane_pivot", &self.smallest_plane_pivot)?;
        report.serialize_field("tolerance", &TOLERANCE)?;
        report.serialize_field("passes", &self.passes())?;
        report.serialize_field("blocks", &self.rows)?;
        report.serialize_field("balance", &self.balance)?;
        report.serialize_field("facets", &self.facets)?;
        report.serialize_field("failures", &self.failures)?;
        report.end()
    }
}

impl Serialize for Row {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut row = serializer.serialize_struct("Row", 6)?;
        row.serialize_field("output", self.block.subject.output.name())?;
        row.serialize_field("frame_derivative", frame_name(self.block.subject.frame))?;
        row.serialize_field("block", self.block.name)?;
        row.serialize_field("tested", self.tested.name())?;
        row.serialize_field("passes", &self.passes())?;
        let worst: std::collections::BTreeMap<&str, &Worst> = Against::ALL
            .iter()
            .filter_map(|&against| Some((against.name(), self.worst[against as usize].as_ref()?)))
            .collect();
        row.serialize_field("against", &worst)?;
        row.end()
    }
}

impl Serialize for Worst {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut worst = serializer.serialize_struct("Worst", 3)?;
        worst.serialize_field("difference", &self.difference)?;
        worst.serialize_field("basis", self.basis.name())?;
        worst.serialize_field("nodes", &self.nodes)?;
        worst.end()
    }
}

#[cfg(test)]
mod tests {
    use diffuse_contact_codegen::{FacetShape, FrameRule};

    use super::*;

    const GAP_HESSIAN: Block =
        Block { subject: Subject { output: Output::Gap, frame: FrameRule::Held }, name: "M" };

    /// Everything compared, without a difference but in M.
    fn with(difference: f64) -> Report {
        let mut report = Report::new(&Plan::default());
        report.elements = 1;
        let at = (Basis::Linear, 5);
        for block in blocks() {
            let own = if block == GAP_HESSIAN { 1e-15 } else { 0.0 };
            report.add(block, Against::Ad, own, at);
            report.add(block, Against::Interpreter, 0.0, at);
        }
        Subject::ALL.into_iter().for_each(|subject| report.add_balance(subject, [0.0; 2], at));
        report.add(GAP_HESSIAN, Against::Ad, difference, (Basis::Quadratic, 9));
        report
    }

    #[test]
    fn the_worst_difference_decides() {
        let report = with(1e-14);
        assert!(report.passes());
        assert!(
            report.to_string().contains("gap             M         1.0e-14 quadratic 9       0\n"),
            "{report}"
        );
        assert!(report.to_string().ends_with("all within 1e-12\n"), "{report}");
        for difference in [2e-11, f64::INFINITY, f64::NAN] {
            let mut report = with(difference);
            report.add(GAP_HESSIAN, Against::Ad, 1e-15, (Basis::Linear, 7));
            assert!(!report.passes());
            assert!(report.to_string().ends_with("failed: beyond 1e-12 are gap M\n"), "{report}");
        }
    }

    #[test]
    fn facets_decide_too() {
        let mut report = with(1e-14);
        let row = |difference| FacetRow {
            shape: FacetShape::Triangle,
            name: "M",
            worst: [Some(difference), None, None],
        };
        report.add_facets((vec![row(1e-15)], Vec::new()));
        assert!(report.passes());
        assert!(report.to_string().contains("triangle        M         1.0e-15\n"), "{report}");
        report.add_facets((vec![row(1e-9)], Vec::new()));
        assert!(report.to_string().ends_with("failed: beyond 1e-12 are triangle M\n"), "{report}");
    }

    #[test]
    fn nothing_compared_is_no_pass() {
        assert!(!Report::new(&Plan::default()).passes());
        let mut report = with(1e-14);
        for missing in [Against::Ad, Against::Interpreter] {
            let before = report.rows[0].worst[missing as usize].take();
            assert!(!report.passes());
            assert!(
                report.to_string().ends_with("failed: nothing is compared of coefficients α\n"),
                "{report}"
            );
            report.rows[0].worst[missing as usize] = before;
        }
        let mut report = with(1e-14);
        report.balance[1].worst = None;
        assert!(!report.passes());
        let mut report = with(1e-14);
        let nothing = FacetRow { shape: FacetShape::Triangle, name: "M", worst: [None; Against::ALL.len()] };
        report.add_facets((vec![nothing], Vec::new()));
        assert!(!report.passes());
        let mut report = with(1e-14);
        report.failures.push("AD gap hessian, linear n = 3: singular".to_owned());
        assert!(!report.passes());
        assert!(report.to_string().contains("no result: AD gap hessian"), "{report}");
    }
}
