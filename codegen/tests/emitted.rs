//! The emitted text of all kernels, held by hashes: a change of the generator's insides leaves every byte as it is.
//!
//! A piece is a function, a type or a module head of an emitted file, by its path. Its line in `emitted.txt` has its hash
//! and its length, so that a difference names the kernels that changed.

use std::fmt::Write;

use diffuse_contact_codegen::Config;

#[path = "../../examples/own_element/elements/mod.rs"]
#[allow(dead_code, non_snake_case, clippy::many_single_char_names, clippy::similar_names)]
mod elements;
#[path = "../../generated/elements.rs"]
mod laws;

const STORED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/emitted.txt");

/// What the product's own build script asks for.
fn product() -> Config {
    let config = Config::new()
        .cubic()
        .wendland_c2()
        .cubic_interpolating()
        .share_kernels()
        .facets()
        .fit()
        .friction()
        .support("crate::support");
    laws::all(config).unwrap()
}

/// Weights that are no polynomials, and a basis of the caller's: what the product has none of.
fn others() -> Config {
    Config::new()
        .fit()
        .weight("exponential", "exp(-r)*(1 + r)*(1 - r^2)^2/sqrt(1 + r^4)")
        .and_then(|config| config.weight("spline", "if r < 0.5 { 2/3-4*r^2+4*r^3 } else { 4/3*(1 - r)^3 }"))
        .map(Config::share_kernels)
        .and_then(|config| {
            config.interpolating("pole", "if r < 0.5 { exp(-4*r^2) } else { exp(-4*r^2) - 0*r }")
        })
        .and_then(|config| config.interpolating("bell", "exp(-4*r^2) * (1 - r^2)^2"))
        .and_then(|config| config.basis("bilinear", &[(0, 0), (1, 0), (0, 1), (1, 1)]))
        .unwrap()
}

/// A weight that shares its kernels with none.
fn alone() -> Config {
    Config::new().cubic().fit()
}

/// Elements of the caller's: of fixed size, with points, with roots, and with nodes.
fn own() -> Config {
    elements::all(Config::new()).unwrap()
}

/// FNV-1a, which is the same everywhere.
fn hash(text: &str) -> u64 {
    text.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// One line per piece: path, length, hash.
fn digest(name: &str, source: &str) -> String {
    let mut lines = String::new();
    let mut path: Vec<(usize, &str)> = Vec::new();
    let mut piece = String::new();
    let mut finish = |path: &[(usize, &str)], piece: &mut String| {
        let path: Vec<&str> = path.iter().map(|(_, name)| *name).collect();
        writeln!(lines, "{name}::{} {} {:016x}", path.join("::"), piece.len(), hash(piece)).unwrap();
        piece.clear();
    };
    for line in source.split_inclusive('\n') {
        let indent = line.len() - line.trim_start().len();
        let words = line.trim().trim_start_matches("pub(super) ").trim_start_matches("pub ");
        let head = ["mod ", "fn ", "struct "].iter().find_map(|keyword| words.strip_prefix(keyword));
        if let Some(head) = head {
            finish(&path, &mut piece);
            path.retain(|(outer, _)| *outer < indent);
            path.push((
                indent,
                head.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or(head),
            ));
        }
        piece.push_str(line);
    }
    finish(&path, &mut piece);
    lines
}

#[test]
fn every_kernel_is_emitted_byte_for_byte() {
    type Emit = fn() -> String;
    let emitted: [(&str, Emit); 5] = [
        ("own", || own().source().unwrap()),
        ("own_c", || own().c_source().unwrap()),
        ("product", || product().source().unwrap()),
        ("alone", || alone().source().unwrap()),
        ("others", || others().source().unwrap()),
    ];
    let running = emitted.map(|(name, source)| (name, std::thread::spawn(source)));
    let sources = running.map(|(name, source)| (name, source.join().unwrap()));
    let found: String = sources.iter().map(|(name, source)| digest(name, source)).collect();
    if let Some(folder) = std::env::var_os("EMITTED_TEXT") {
        for (name, source) in &sources {
            std::fs::write(std::path::Path::new(&folder).join(format!("{name}.rs")), source).unwrap();
        }
    }
    if std::env::var_os("UPDATE_EMITTED").is_some() {
        std::fs::write(STORED, &found).unwrap();
    }
    let stored = std::fs::read_to_string(STORED).unwrap_or_default();
    let changed: Vec<&str> =
        found.lines().filter(|line| !stored.lines().any(|other| other == *line)).collect();
    assert!(
        found == stored,
        "the emitted text has changed, {} pieces of {}, of which the first are\n    {}\n\
         EMITTED_TEXT=<folder> writes it, to compare it with that of before. Where the change is meant, refresh the hashes:\n    \
         UPDATE_EMITTED=1 cargo test -p diffuse-contact-codegen --test all -- emitted",
        changed.len(),
        found.lines().count(),
        changed.iter().take(12).copied().collect::<Vec<_>>().join("\n    ")
    );
}
