//! What `neighbours` answers for one search.

use diffuse_contact::Point;
use diffuse_contact::neighbourhood::{
    Fallback, NeighbourRule, NeighbourSearch, Neighbourhood, NeighbourhoodError, SearchOptions, hull_layers,
};
use diffuse_contact::pairing::{DEFAULT_NEIGHBOURS, NearestNodes};
use serde::Serialize;

use super::schema::{Count, Rule, SearchInput};
use crate::json::FrameOutput;
use crate::outcome::Outcome;

/// The nodes around one slave, by their place among the masters, counted from 0.
#[derive(Debug, Serialize)]
pub struct Found {
    /// Which nodes take part.
    rule: Rule,
    /// Nodes straight above or below the slave; they belong to no layer.
    at_slave: Vec<usize>,
    /// The layers, innermost first.
    layers: Vec<Vec<usize>>,
    /// All nodes that take part, by in-plane distance from the slave.
    nodes: Vec<usize>,
    /// Radius of the domain of influence.
    support_radius: f64,
    /// Basis that the nodes carry.
    basis: &'static str,
    /// Condition number of the moment matrix (Chamoret et al. 2008, eq. 13); `None` if it is singular to rounding.
    condition: Option<f64>,
    /// How well the nodes carry the fit, from 0 to 1.
    regularity: f64,
    /// Smallest relative pivot of the moment matrix.
    pivot_ratio: f64,
    /// Whether the nodes surround the slave.
    encloses_slave: bool,
    /// Whether the slave lies on their border.
    on_border: bool,
    /// Whether the candidates sufficed to be sure of the layers.
    complete: bool,
    /// What had to be given up.
    fallback: Option<FallbackOutput>,
    /// Average plane of the nodes, normal outward.
    frame: FrameOutput,
}

/// What a search had to give up.
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
enum FallbackOutput {
    /// More layers or nodes than asked for.
    Extended { by: usize },
    /// The linear instead of the quadratic basis.
    Linear { quadratic_regularity: f64 },
    /// Something this program does not know.
    Other,
}

/// Searches the neighbours of one slave.
pub fn search(input: &SearchInput) -> Outcome<Found> {
    let Some(outward) = input.outward() else {
        let message = "`outward` is missing: it tells which side of the masters is outside".to_owned();
        return Outcome::Error { code: "missing-outward", message };
    };
    match find(input, outward) {
        Ok(neighbourhood) => Outcome::Ok(Box::new(Found::new(input.rule, neighbourhood))),
        Err(error) => Outcome::Error { code: error.code(), message: error.to_string() },
    }
}

fn find(input: &SearchInput, outward: Point) -> Result<Neighbourhood, NeighbourhoodError> {
    let masters = input.masters();
    let slave = input.slave.0;
    let layers = input.layers.map(|Count(layers)| layers);
    let rule = match (input.rule, layers) {
        (Rule::HullLayers, Some(layers)) => return hull_layers(slave, &masters, outward, layers),
        (Rule::HullLayers, None) => NeighbourRule::hull_layers(None),
        (Rule::HullRadius, _) => NeighbourRule::hull_radius(layers),
        (Rule::Nearest, _) => {
            NeighbourRule::nearest(input.count.map_or(DEFAULT_NEIGHBOURS, |Count(count)| count))
        }
    };
    let options = SearchOptions::default().with_rule(rule).with_basis(input.basis());
    let nodes = NearestNodes::new(masters).map_err(|error| NeighbourhoodError::of_nodes(&error))?;
    NeighbourSearch::new(options)?.find(&nodes, slave, outward)
}

impl Found {
    fn new(rule: Rule, found: Neighbourhood) -> Self {
        Self {
            rule,
            at_slave: found.at_slave,
            layers: found.layers,
            nodes: found.nodes,
            support_radius: found.support_radius,
            basis: found.basis.name(),
            condition: Some(found.condition).filter(|condition| condition.is_finite()),
            regularity: found.regularity,
            pivot_ratio: found.pivot_ratio,
            encloses_slave: found.encloses_slave,
            on_border: found.on_border,
            complete: found.complete,
            fallback: match found.fallback {
                Fallback::None => None,
                Fallback::Extended { by } => Some(FallbackOutput::Extended { by }),
                Fallback::Linear { quadratic_regularity } => {
                    Some(FallbackOutput::Linear { quadratic_regularity })
                }
                _ => Some(FallbackOutput::Other),
            },
            frame: found.frame.into(),
        }
    }
}
