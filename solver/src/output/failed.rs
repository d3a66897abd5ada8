//! The increment that a run ended with: where it got stuck.

use serde::{Deserialize, Serialize};

use super::{Fields, RecorderOptions, Skin, SkinFrame};
use crate::model::Model;
use crate::statics::{FailedIncrement, Failure, Problem, State};

/// Nodes that are named.
const WORST: usize = 10;

/// `failed.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Failed {
    /// Time at which it would have ended.
    pub time: f64,
    /// Its length.
    pub length: f64,
    /// Why it failed, in a sentence.
    pub reason: String,
    /// Its residuals over the forces; `None` where that is no number, as without any force.
    pub residuals: Vec<Option<f64>>,
    /// Linear solutions before each of them; empty in what an earlier version wrote.
    #[serde(default)]
    pub iterations: Vec<usize>,
    /// The nodes with the largest residuals at its last evaluation, the worst first; none where forces could not be evaluated after its
    /// beginning.
    pub worst: Vec<WorstNode>,
    /// The skin where it was left; `None` if a position is no number.
    pub frame: Option<SkinFrame>,
}

/// A node that is out of balance.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorstNode {
    /// Its part in the deck.
    pub part: String,
    /// Its number in the results, from 0.
    pub node: usize,
    /// Where it was left, length.
    pub position: [f64; 3],
    /// What is left of the forces on it where nothing is prescribed, force.
    pub residual: [f64; 3],
}

/// An increment that failed, which may be tried again with a shorter one.
pub(super) struct FailedTry {
    failed: Failed,
    /// Whether forces are known of where it was left, and not only of where it began.
    has_forces: bool,
    /// Where the nodes were left.
    positions: Vec<[f64; 3]>,
}

impl FailedTry {
    /// As far as it changes when the increment is tried again.
    pub fn of(failed: &FailedIncrement<'_>) -> Self {
        let relative = failed.history.iter().map(|record| record.relative);
        let failed_so_far = Failed {
            time: failed.end,
            length: failed.length,
            reason: failed.reason.to_string(),
            residuals: relative
                .map(|residual| Some(residual).filter(|residual| residual.is_finite()))
                .collect(),
            iterations: failed.history.iter().map(|record| record.iteration).collect(),
            ..Failed::default()
        };
        let is_evaluated = !matches!(failed.reason, Failure::Inverted(_) | Failure::Contact(_));
        let has_forces = is_evaluated || failed.history.len() > 1;
        Self { failed: failed_so_far, has_forces, positions: failed.positions.to_vec() }
    }

    /// With its shape and worst nodes, for which it has to be the last evaluation of `problem`. `committed`: where the increment began.
    pub fn written(
        self,
        problem: &Problem,
        model: &Model,
        skin: &Skin,
        options: &RecorderOptions,
        committed: &State,
    ) -> Failed {
        let Self { failed, has_forces, positions } = self;
        let is_finite = positions.iter().flatten().all(|x| x.is_finite());
        let frame = is_finite.then(|| {
            let points = problem.last_points().to_vec();
            let state = State { positions: positions.clone(), points, ..committed.clone() };
            let mut fields = Fields::of(problem, &state);
            if options.output.stress {
                // An element that is inside out has none: then the field is left out.
                let _ = fields.recover(problem, &state);
            }
            let mut frame = skin.frame(committed.increments + 1, failed.time, &positions, &fields);
            frame.fields.retain(|_, values| values.iter().all(|value| value.is_finite()));
            frame
        });
        let worst = if has_forces { worst(problem, model, &positions) } else { Vec::new() };
        Failed { worst, frame, ..failed }
    }
}

fn worst(problem: &Problem, model: &Model, positions: &[[f64; 3]]) -> Vec<WorstNode> {
    let forces: Vec<f64> = problem
        .imbalance()
        .enumerate()
        .map(|(freedom, force)| if problem.supports().is_free(freedom) { -force } else { 0.0 })
        .collect();
    let size = |force: &[f64; 3]| force.iter().map(|f| f * f).sum::<f64>();
    let is_known = |&(node, force): &(usize, [f64; 3])| {
        size(&force).is_finite() && size(&force) > 0.0 && positions[node].iter().all(|x| x.is_finite())
    };
    let mut nodes: Vec<(usize, [f64; 3])> =
        forces.as_chunks::<3>().0.iter().copied().enumerate().filter(is_known).collect();
    nodes.sort_by(|(_, a), (_, b)| size(b).total_cmp(&size(a)));
    let parts = model.parts();
    let part = |node: usize| {
        let at = parts.partition_point(|&(_, first)| first <= node);
        at.checked_sub(1).map_or_else(String::new, |at| parts[at].0.to_owned())
    };
    let named = |(node, residual)| WorstNode { part: part(node), node, position: positions[node], residual };
    nodes.into_iter().take(WORST).map(named).collect()
}
