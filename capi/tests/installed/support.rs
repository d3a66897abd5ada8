//! What the tests of other languages share: the installed library, compilers, numbers printed bit for bit.

use std::collections::HashMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// With this variable set a missing tool fails a test; without it the test says so and passes.
const REQUIRE: &str = "DIFFUSE_CONTACT_REQUIRE_TOOLS";
/// The variable that names the directory of the built library.
const BUILT: &str = "DIFFUSE_CONTACT_BUILT";

/// Whether a program is there.
pub fn has(tool: &str) -> bool {
    let found = Command::new(tool).arg("--version").output().is_ok_and(|output| output.status.success());
    assert!(found || std::env::var_os(REQUIRE).is_none(), "{tool} is missing");
    if !found {
        eprintln!("skipped: there is no {tool}");
    }
    found
}

/// What a command prints; the test fails with what it complains about.
pub fn run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {}\n{said}", output.status);
    String::from_utf8(output.stdout).expect("text")
}

/// The root of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// An installed library.
pub struct Installed {
    pub prefix: PathBuf,
}

impl Installed {
    /// Installs the built library in a directory of this name.
    pub fn new(name: &str) -> Self {
        let built = std::env::var_os(BUILT).unwrap_or_else(|| {
            panic!("{BUILT} does not name the directory of the built library; see main.rs for how to run these tests")
        });
        let prefix = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        run(Command::new(root().join("capi/install.sh")).arg(&prefix).arg(built));
        Self { prefix }
    }

    /// What pkg-config says.
    pub fn flags(&self, arguments: &[&str]) -> Vec<String> {
        let mut command = Command::new("pkg-config");
        command
            .env("PKG_CONFIG_PATH", self.prefix.join("lib/pkgconfig"))
            .args(arguments)
            .arg("diffuse_contact");
        run(&mut command).split_whitespace().map(str::to_owned).collect()
    }

    /// A program that finds the library.
    pub fn program(&self, name: &str) -> Command {
        let mut command = Command::new(self.prefix.join(name));
        command.env("LD_LIBRARY_PATH", self.prefix.join("lib"));
        command
    }
}

/// The C compiler.
pub fn c_compiler() -> OsString {
    std::env::var_os("CC").unwrap_or_else(|| "cc".into())
}

/// The numbers of the lines that open with a name, line by line.
pub fn records(text: &str, read: fn(&str) -> f64) -> Vec<(String, Vec<f64>)> {
    let record = |line: &str| {
        let mut words = line.split(' ');
        let name = words.next()?;
        let is_name = !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'-');
        let rest: Vec<&str> = words.collect();
        let is_record = is_name && rest.iter().all(|word| looks_hexadecimal(word));
        (is_record && !rest.is_empty()).then(|| (name.to_owned(), rest.into_iter().map(read).collect()))
    };
    text.lines().filter_map(record).collect()
}

fn looks_hexadecimal(word: &str) -> bool {
    let digits = word.trim_start_matches('-');
    digits.starts_with("0x") || (digits.len() == 16 && digits.bytes().all(|byte| byte.is_ascii_hexdigit()))
}

/// Records grouped: a group begins with the record `first`.
pub fn groups(records: Vec<(String, Vec<f64>)>, first: &str) -> Vec<HashMap<String, Vec<f64>>> {
    let mut groups: Vec<HashMap<String, Vec<f64>>> = Vec::new();
    for (name, values) in records {
        if name == first {
            groups.push(HashMap::new());
        }
        if let Some(group) = groups.last_mut() {
            group.insert(name, values);
        }
    }
    groups
}

/// A number as %a prints it, such as -0x1.8p+3.
pub fn from_hexadecimal(text: &str) -> f64 {
    let (sign, digits) = text.strip_prefix('-').map_or((1.0, text), |digits| (-1.0, digits));
    let digits = digits.strip_prefix("0x").expect("0x");
    let (mantissa, exponent) = digits.split_once('p').expect("an exponent");
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let bits = u64::from_str_radix(&format!("{whole}{fraction}"), 16).expect("digits");
    assert!(bits < 1 << 53, "a number of 53 bits");
    let exponent: i32 = exponent.parse().expect("an exponent");
    // In two steps, of which the first is exact, and the second one too where the number has all its bits.
    let scale = exponent - 4 * fraction.len() as i32;
    let half = scale / 2;
    sign * (bits as f64 * 2.0_f64.powi(half)) * 2.0_f64.powi(scale - half)
}

/// A number by its bits, as Fortran's z16.16 prints it.
pub fn from_bits(text: &str) -> f64 {
    f64::from_bits(u64::from_str_radix(text, 16).expect("16 hexadecimal digits"))
}

/// The same numbers, bit for bit; zeros of either sign are the same.
pub fn assert_same(what: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        let is_same = found.to_bits() == expected.to_bits() || (*found == 0.0 && *expected == 0.0);
        assert!(is_same, "{what} {k}: {found:e} instead of {expected:e}");
    }
}
