//! A deck of the repository with changes, and its run.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use diffuse_contact::surface::Facet;
use diffuse_contact_solver::deck::Deck;
use diffuse_contact_solver::solve::{SolveError, statics};
use diffuse_contact_solver::statics::{
    Control, Effort, IncrementRecord, Observer, Problem, State, StaticsError, Timing,
};
use toml::{Table, Value};

use crate::error::CliError;
use crate::output;

/// A deck with changes.
#[derive(Clone, Debug)]
pub struct Case {
    /// File name of the deck without its ending, if it is written out.
    name: String,
    table: Table,
    /// The run ends after so many increments.
    limit: Option<usize>,
}

/// How a run went.
#[derive(Debug)]
pub struct Outcome {
    /// The converged increments.
    pub increments: Vec<IncrementRecord>,
    /// Positions of all nodes at the end of each.
    pub positions: Vec<Vec<[f64; 3]>>,
    /// Contact force of each node at the end of each increment.
    pub forces: Vec<BTreeMap<usize, f64>>,
    /// Surfaces of the model by name.
    pub surfaces: BTreeMap<String, Vec<Facet>>,
    /// Positions at the start.
    pub start: Vec<[f64; 3]>,
    /// Linear solutions, those of failed increments among them.
    pub iterations: usize,
    /// Increments that failed and were tried again shorter.
    pub cutbacks: usize,
    /// Why the end of time was not reached.
    pub failure: Option<String>,
    /// From the first increment to the last.
    pub wall: Duration,
    /// What of that was spent on what.
    pub timing: Timing,
}

impl Case {
    /// A deck as it stands in the repository. The files are part of the program, and its tests read them: they are sound.
    pub fn new(name: &str, text: &str) -> Self {
        let table = text.parse().expect("a deck of the repository is TOML");
        Self { name: name.into(), table, limit: None }
    }

    /// With a suffix on its name.
    pub fn named(mut self, suffix: &str) -> Self {
        self.name = format!("{}-{suffix}", self.name);
        self
    }

    /// With another value of a field, such as `interface.penalty`; of a list of tables the first is meant, and one that is missing
    /// is added.
    pub fn with(mut self, field: &str, value: impl Into<Value>) -> Self {
        let mut parts: Vec<&str> = field.split('.').collect();
        let last = parts.pop().unwrap_or_default();
        let mut table = &mut self.table;
        for part in parts {
            table = match table.entry(part).or_insert_with(|| Table::new().into()) {
                Value::Table(inner) => inner,
                Value::Array(list) => match list.first_mut() {
                    Some(Value::Table(inner)) => inner,
                    _ => panic!("`{part}` holds no table"),
                },
                _ => panic!("`{part}` is no table"),
            };
        }
        table.insert(last.into(), value.into());
        self
    }

    /// The classic element in place of the diffuse one.
    pub fn classic(self) -> Self {
        self.with("contact", "node-to-facet").named("facets")
    }

    /// Layers of hulls in place of nodal domains.
    pub fn hull_layers(self) -> Self {
        self.with("interface.neighbours.rule", "hull-layers").named("hull-layers")
    }

    /// Ends after so many increments.
    pub fn up_to(mut self, increments: Option<usize>) -> Self {
        self.limit = increments;
        self
    }

    /// Writes the deck into a directory, so that anyone can run it with `solve`.
    pub fn write_to(&self, directory: &Path) -> Result<(), CliError> {
        fs::create_dir_all(directory).map_err(|reason| CliError::Write { path: directory.into(), reason })?;
        let path = directory.join(format!("{}.toml", self.name));
        output::write_file(&path, |writer| writer.write_all(self.text().as_bytes()))
    }

    fn text(&self) -> String {
        toml::to_string(&self.table).expect("what was read as TOML can be written as TOML")
    }

    /// Runs it. A run that does not converge has an outcome, too.
    pub fn run(&self) -> Result<Outcome, SolveError> {
        let deck = Deck::parse_named(&self.text(), format!("{}.toml", self.name))?;
        let model = deck.model(Path::new(""))?;
        let mut statics = statics(&deck, &model, 1)?;
        let start = statics.problem().start();
        let mut watch = Watch { limit: self.limit, ..Watch::default() };
        let begin = Instant::now();
        let failure = match statics.run(start, &mut watch) {
            Ok(_) => None,
            Err(reason @ StaticsError::NoConvergence { .. }) => Some(reason.to_string()),
            Err(reason) => return Err(reason.into()),
        };
        let wall = begin.elapsed();
        let Effort { iterations, cutbacks } = statics.effort();
        let Watch { increments, positions, forces, .. } = watch;
        let timing = increments.last().map(|record| record.timing).unwrap_or_default();
        Ok(Outcome {
            increments,
            positions,
            forces,
            surfaces: model.surfaces,
            start: model.nodes,
            iterations,
            cutbacks,
            failure,
            wall,
            timing,
        })
    }
}

/// Keeps what a run tells.
#[derive(Default)]
struct Watch {
    limit: Option<usize>,
    increments: Vec<IncrementRecord>,
    positions: Vec<Vec<[f64; 3]>>,
    forces: Vec<BTreeMap<usize, f64>>,
}

impl Observer for Watch {
    fn increment(
        &mut self,
        record: &IncrementRecord,
        state: &State,
        problem: &Problem,
    ) -> Result<Control, Box<dyn std::error::Error + Send + Sync>> {
        self.increments.push(record.clone());
        self.positions.push(state.positions.clone());
        let slaves = problem.contacts().interactions().iter().flat_map(|interaction| interaction.slaves());
        self.forces.push(slaves.map(|slave| (slave.node, slave.force)).collect());
        let is_over = self.limit.is_some_and(|limit| self.increments.len() >= limit);
        Ok(if is_over { Control::Stop } else { Control::Continue })
    }
}

impl Outcome {
    /// Iterations for a table: with the cut-backs, or how far it came.
    pub fn count(&self) -> String {
        let Self { iterations, cutbacks, .. } = self;
        match (&self.failure, cutbacks) {
            (Some(_), _) => {
                let reached = self.increments.last().map_or(0.0, |record| record.time);
                format!("ends at {:.0} %", 100.0 * reached)
            }
            (None, 0) => iterations.to_string(),
            (None, _) => format!("{iterations} ({cutbacks} cut back)"),
        }
    }

    /// Deepest penetration at the end of any increment.
    pub fn penetration(&self) -> f64 {
        self.increments.iter().map(|record| record.max_penetration).fold(0.0, f64::max)
    }

    /// Whether the end was reached.
    pub fn converged(&self) -> bool {
        self.failure.is_none()
    }
}

/// How many iterations fewer `one` takes than `other`, in percent, if both have come to the end.
pub fn saving(one: &Outcome, other: &Outcome) -> String {
    if !(one.converged() && other.converged()) {
        return "–".into();
    }
    let percent = 100.0 * (1.0 - one.iterations as f64 / other.iterations as f64);
    format!("{percent:.1} %")
}
