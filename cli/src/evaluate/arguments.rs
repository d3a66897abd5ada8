//! What can be said to `evaluate`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// The formats of `evaluate`, for its help.
const JSON_FORMATS: &str = r#"IN.json:
  {"elements": [{
    "slave": [x, y, z],
    "masters": [[x, y, z], ...],     at least 3, or the file is refused
    "outward": [x, y, z],            direction to the outside of the master, any length;
                                     may be left out if a frame is given
    "frame": "average-plane",        the default, or
             {"origin": [x, y, z], "t1": [x, y, z], "t2": [x, y, z], "normal": [x, y, z]}
    "frame_derivative": "co-moving", the average plane moves with the nodes while differentiating: N and M are
                                     exact; the default, but not for a given frame, which cannot move
                        "held",      the frame is held; the default for a given frame
    "support_radius": R,             default 1.25 x the farthest in-plane distance of a master, or the largest of
                                     support_radii; held while differentiating: give it explicitly to compare with differences
    "support_radii": [R_1, ...],     one for each master: radii of their own domains of influence; the average plane
                                     then weights its nodes; default: all are R, and the plane weights none
    "first_positions": [[x, y, z], ...], and
    "metrics": [[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], ...],
                                     one of both for each master, in place of radii: domains of influence as interfaces have
                                     them, ellipsoids about the masters' first positions X_k. The matrix is C in
                                     (X - X_k)^T C^-1 (X - X_k) < 1: its eigenvalues are the half axes squared, its eigenvectors
                                     their directions. The slave's place in the first configuration is found as interfaces find
                                     it; the frame is the average plane, weighted there, and moves
    "basis": "quadratic",            or "linear"; default quadratic from 6 masters on
    "weight": "cubic",               the default, (1 - r)^2 (1 + 2 r), or
              "cubic-interpolating", the same made interpolating: the surface passes through the masters (in a program
                                     built with --features interpolating), or
              "wendland-c2",         (1 - r)^4 (1 + 4 r)
    "penalty": 1.0,                  the default
    "anchor": [x, y, z],             where the place is that the slip is measured from; without it there is no slip
    "friction": {"coefficient": 0.3, "stiffness": 1.0, "shear_limit": 2.0}
                                     Coulomb's, force per length in stick; needs the anchor and a program built with
                                     --features friction; no limit if left out
  }, ...]}

OUT.json, in the same order; vectors and rows over slave, master 1, ... master n, global axes:
  {"elements": [
    {"status": "ok", "active": gap < 0, "gap": g, "foot": [3], "normal": [3], "coefficients": [6 or 3],
     "frame": {...}, "frame_derivative": "...", "support_radius": R, "regularity": r, "place": [3],
     "n": [3(n+1)], "m": [[...], ...], "force": [...], "tangent": [[...], ...],
     "slip": {"q": q, "gradient": [3(n+2)], "hessian": [[...], ...], "foot_weights": [n]},
     "friction": {"state": "open", "stick" or "slip", "force": [3(n+2)], "tangent": [[...], ...]}},
    {"status": "error", "code": "singular-fit", "message": "..."}
  ]}
A file that does not follow this form is refused: exit code 2, nothing written. An element whose geometry or parameters have
no result is an entry with status "error": the others have theirs, and the exit code is 1.
place: the slave's in the first configuration, null without first_positions; support_radius then is the distance of the farthest
master within reach, which lengths are divided by.
slip: of an element with an anchor, over slave, master 1, ... master n, anchor; friction beside it, on top of force and tangent.
regularity: how well the masters carry the fit, 0 on one conic (linear basis: on one line), at most 1; near 0 the entries
of n and m may be large. An element has 1000 masters at most.
Force -penalty g N and tangent penalty (g M + N N^T) are given for either sign of the gap."#;

/// Arguments of `evaluate`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = JSON_FORMATS)]
pub struct EvaluateArguments {
    /// Elements as JSON; `-` reads standard input
    #[arg(value_name = "IN.json")]
    pub input: PathBuf,
    /// File to write [default: standard output]
    #[arg(short, long, visible_alias = "out", value_name = "OUT.json")]
    pub output: Option<PathBuf>,
    /// What computes the derivatives
    #[arg(long, value_enum, default_value_t = BackendKind::Generated)]
    pub backend: BackendKind,
}

/// The implementations of the element that can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BackendKind {
    /// The generated kernels.
    Generated,
    /// Forward-mode automatic differentiation of an independent model: slow, for comparison. The laboratory computes it.
    Ad,
}
