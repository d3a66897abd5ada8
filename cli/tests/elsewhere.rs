//! Jobs of other programs.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;

use crate::PROGRAM;
use crate::runs::{Run, Scratch};

/// The program alone in a directory, with this search path.
fn alone(scratch: &Scratch, arguments: &[&str], path: &str) -> Run {
    let program = scratch.path("diffuse-contact");
    if fs::metadata(&program).is_err() {
        fs::copy(PROGRAM, &program).unwrap();
    }
    Command::new(program).args(arguments).env("PATH", path).output().unwrap().into()
}

/// A program that prints its arguments and ends with 7.
fn write_script(path: &str, word: &str) {
    fs::write(path, format!("#!/bin/sh\necho {word} \"$@\"\nexit 7\n")).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn a_job_of_a_program_that_is_not_there_says_how_to_get_it() {
    let scratch = Scratch::new("elsewhere-missing");
    for (job, name, package) in [
        ("solve", "diffuse-contact-solve", "diffuse-contact-solver"),
        ("report", "diffuse-contact-solve", "diffuse-contact-solver"),
        ("emit", "diffuse-contact-laboratory", "diffuse-contact-laboratory"),
        ("check", "diffuse-contact-laboratory", "diffuse-contact-laboratory"),
        ("study", "diffuse-contact-laboratory", "diffuse-contact-laboratory"),
        ("bench", "diffuse-contact-laboratory", "diffuse-contact-laboratory"),
    ] {
        let build = format!("cargo build --release -p {package}");
        for arguments in [&[job][..], &[job, "--help"], &[job, "-x", "y", "--z"]] {
            alone(&scratch, arguments, "").assert_refused(&[&format!("`{job}`"), name, &build]);
        }
    }
    let elements = scratch.file("in.json", r#"{"elements": []}"#);
    alone(&scratch, &["evaluate", &elements, "--backend", "ad"], "")
        .assert_refused(&["`evaluate --backend ad`", "diffuse-contact-laboratory"]);
}

#[test]
fn arguments_and_exit_code_are_passed_on() {
    let scratch = Scratch::new("elsewhere-there");
    let folder = scratch.path("bin");
    fs::create_dir(&folder).unwrap();
    write_script(&format!("{folder}/diffuse-contact-solve"), "path");
    let run = alone(&scratch, &["solve", "a deck.toml", "--out", "-"], &folder);
    assert_eq!((run.code, run.stdout.as_str()), (7, "path solve a deck.toml --out -\n"));
    // The one beside the program comes before those on the path.
    write_script(&scratch.path("diffuse-contact-solve"), "beside");
    let run = alone(&scratch, &["solve", "--help"], &folder);
    assert_eq!((run.code, run.stdout.as_str()), (7, "beside solve --help\n"));
}
