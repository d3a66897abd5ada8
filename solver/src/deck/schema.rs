//! The fields of every table of a deck. `docs/how-to/decks.md` explains them; a test compares the two.

/// Fields of the deck itself.
pub const DECK: &[&str] = &[
    "title",
    "contact",
    "materials",
    "parts",
    "boundary",
    "pressure",
    "interface",
    "time",
    "newton",
    "output",
];
/// Fields of a material.
pub const MATERIAL: &[&str] = &["young", "poisson", "model", "yield_stress", "hardening"];
/// Fields of any part.
pub const PART: &[&str] = &["shape", "file", "material", "translate", "rotate"];
/// Fields of a deformable part that is a shape.
pub const SOLID_SHAPE: &[&str] = &["element"];
/// Fields of a part from a mesh file.
pub const FILE: &[&str] = &["elements", "surface", "instance", "element"];
/// The shapes and their fields.
pub const SHAPES: &[(&str, &[&str])] = &[
    ("box", &["origin", "size", "divisions", "grading"]),
    ("plate", &["origin", "size", "divisions", "grading"]),
    ("pipe", &["axis", "inner_radius", "outer_radius", "angles", "length", "divisions", "grading"]),
    ("cylinder", &["axis", "radius", "length", "keep", "divisions", "core", "grading", "layer_grading"]),
    ("sphere", &["radius", "keep", "divisions", "core", "grading", "layer_grading"]),
    ("strip", &["path", "thickness", "width", "divisions"]),
    ("rigid-plane", &["size", "divisions", "facets"]),
    ("rigid-wave", &["size", "height", "wavelength", "divisions", "facets"]),
    ("rigid-cylinder", &["axis", "radius", "angles", "length", "divisions", "facets", "side"]),
    ("rigid-sphere", &["radius", "keep", "divisions", "grading", "facets", "side"]),
    (
        "rigid-torus",
        &["axis", "radius", "tube_radius", "angles", "tube_angles", "divisions", "facets", "side"],
    ),
];
/// Fields of a piece of a strip's path.
pub const PIECE: &[&str] = &["length", "radius", "degrees", "rise"];
/// Fields of a rotation that places a part.
pub const ROTATION: &[&str] = &["axis", "point", "degrees"];
/// Fields of a boundary condition.
pub const BOUNDARY: &[&str] = &["nodes", "fix", "translate", "rotate", "amplitude"];
/// Fields of a boundary condition's rotation.
pub const BOUNDARY_ROTATION: &[&str] = &["axis", "point", "degrees", "amplitude"];
/// Fields of a pressure.
pub const PRESSURE: &[&str] = &["surface", "value", "follower", "amplitude"];
/// Fields of an interface.
pub const INTERFACE: &[&str] = &[
    "name",
    "master",
    "slave",
    "self",
    "integration",
    "penalty",
    "adjust",
    "areas",
    "method",
    "augmentation",
    "two_pass",
    "exchange",
    "weight",
    "frame",
    "neighbours",
    "symmetry",
    "refresh",
    "tangent",
    "friction",
    "feature_angle",
    "border_tolerance",
    "distance_limit",
];
/// Fields of an augmentation.
pub const AUGMENTATION: &[&str] = &["max", "tolerance"];
/// Fields of friction.
pub const FRICTION: &[&str] = &["coefficient", "stiffness", "shear_limit", "symmetric", "augmentation"];
/// Fields of a coefficient of friction that varies.
pub const COEFFICIENT: &[&str] = &["static", "kinetic", "decay", "pressures", "rates", "values"];
/// Fields of an integration.
pub const INTEGRATION: &[&str] = &["over", "degree", "pressures"];
/// Fields of the neighbour search.
pub const NEIGHBOURS: &[&str] = &["rule", "count", "regularity"];
/// Fields of a symmetry plane.
pub const SYMMETRY: &[&str] = &["point", "normal"];
/// Fields of the time.
pub const TIME: &[&str] = &["end", "increment", "minimum", "maximum", "growth", "cutback", "fixed"];
/// Fields of the Newton iteration.
pub const NEWTON: &[&str] = &[
    "tolerance",
    "absolute",
    "max_iterations",
    "few_iterations",
    "line_search",
    "extrapolation",
    "stabilisation",
    "linear_solver",
    "contact_tangent",
];
/// Fields of the output.
pub const OUTPUT: &[&str] = &["every", "stress", "colour"];
