//! What can be said to `neighbours`.

use std::path::PathBuf;

use clap::Args;

/// The formats of `neighbours`, for its help.
const NEIGHBOUR_FORMATS: &str = r#"IN.json, one search, a list [...] of them, or the same file as for evaluate, {"elements": [...]}:
  {"slave": [x, y, z],
   "masters": [[x, y, z], ...],     at least 3, or the file is refused
   "outward": [x, y, z],            direction to the outside of the master, any length; needed but for an element
                                    whose frame is given: its normal stands in
   "rule": "hull-layers",           the nodes of the first layers of convex hulls around the slave; the default
           "hull-radius",           the layers set the support radius, all nodes within take part
           "nearest",               the nearest nodes
   "layers": L,                     hull-layers: exactly so many, however well they carry the fit; hull-radius: at
                                    least so many. Default: as many as the fit needs to be well conditioned
   "count": C,                      nearest: at least so many nodes; default 12
   "basis": "quadratic"             or "linear": what the nodes have to carry; default quadratic, and linear where
                                    no nodes carry that; not with hull-layers and a number of layers
  }

OUT.json, laid out as IN.json, in the same order; nodes are places in "masters", counted from 0:
  {"status": "ok", "rule": "...", "at_slave": [...], "layers": [[...], ...], "nodes": [...],
   "support_radius": R, "basis": "...", "condition": c, "regularity": r, "pivot_ratio": p,
   "encloses_slave": true, "on_border": false, "complete": true, "fallback": null, "frame": {...}}
  {"status": "error", "code": "no-average-plane", "message": "..."}
at_slave         nodes straight above or below the slave; they belong to no layer
layers           innermost first; fewer than asked for if the nodes run out; one for "nearest"
nodes            those that take part, by in-plane distance from the slave
condition        condition number of the moment matrix; null if it is singular to rounding
regularity       how well the nodes carry the fit: 0 on one conic (linear basis: on one line), at most 1
encloses_slave   whether the nodes of the first layer surround the slave; not so on the border or beyond it
on_border        whether the slave lies on the border; beyond it the fit extrapolates
complete         whether the nodes looked at sufficed to be sure of the layers
fallback         null, {"kind": "extended", "by": layers or nodes more than asked for}, or
                 {"kind": "linear", "quadratic_regularity": of the best nodes tried}
A search without a result leaves the others theirs; the exit code then is 1."#;

/// Arguments of `neighbours`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = NEIGHBOUR_FORMATS)]
pub struct NeighboursArguments {
    /// Slave and master nodes as JSON; `-` reads standard input
    #[arg(value_name = "IN.json")]
    pub input: PathBuf,
    /// File to write [default: standard output]
    #[arg(short, long, visible_alias = "out", value_name = "OUT.json")]
    pub output: Option<PathBuf>,
}
