//! The laboratory's program; everything is in the library.
#![forbid(unsafe_code)]

fn main() -> std::process::ExitCode {
    diffuse_contact_laboratory::main()
}
