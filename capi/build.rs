//! The name by which programs find the shared library: that of the versions they can do with.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let of = |name: &str| std::env::var(name).unwrap_or_default();
    let (major, minor) = (of("CARGO_PKG_VERSION_MAJOR"), of("CARGO_PKG_VERSION_MINOR"));
    // Before version 1 each minor version may change the interface.
    let version = if major == "0" { format!("0.{minor}") } else { major };
    if matches!(of("CARGO_CFG_TARGET_OS").as_str(), "linux" | "freebsd" | "android") {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libdiffuse_contact.so.{version}");
    }
}
