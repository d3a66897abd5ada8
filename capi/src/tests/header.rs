//! The header that is checked in is the one that the sources make.

use std::path::Path;

/// In the order in which the header has them.
const SOURCES: [&str; 25] = [
    "status",
    "outcome",
    "choice",
    "version",
    "threads",
    "options",
    "interface",
    "contacts",
    "feet",
    "law",
    "friction",
    "assembly",
    "pattern",
    "map",
    "operator",
    "window",
    "part",
    "faces",
    "faces_friction",
    "faces_points",
    "faces_assembly",
    "faces_window",
    "neighbours",
    "element",
    "batch",
];

#[test]
fn the_header_is_fresh() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).expect("cbindgen.toml");
    let mut builder = cbindgen::Builder::new().with_config(config);
    for source in SOURCES {
        builder = builder.with_src(root.join(format!("src/{source}.rs")));
    }
    let mut made = Vec::new();
    builder.generate().expect("the sources").write(&mut made);
    let made = String::from_utf8(made).expect("text");
    let path = root.join("include/diffuse_contact.h");
    if std::env::var_os("UPDATE_HEADER").is_some() {
        std::fs::write(&path, &made).expect("the header");
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == made,
        "{} is stale: run UPDATE_HEADER=1 cargo test -p diffuse-contact-capi --lib header",
        path.display()
    );
}
