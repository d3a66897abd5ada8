//! Running a program, [`crate::PROGRAM`], and looking at what it leaves behind. The tests of every program include this file.
#![allow(dead_code, reason = "the tests of each program use a part")]

use std::fs;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

/// What one run of the program left.
#[derive(Debug)]
pub struct Run {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Run {
    /// Exit code 2, nothing on standard output, and one sentence that contains all of `parts`.
    #[track_caller]
    pub fn assert_refused(&self, parts: &[&str]) {
        assert_eq!(self.code, 2, "{self:?}");
        assert_eq!(self.stdout, "", "{self:?}");
        assert!(self.stderr.starts_with("error: "), "{self:?}");
        assert_eq!(self.stderr.lines().count(), 1, "{self:?}");
        for part in parts {
            assert!(self.stderr.contains(part), "{part:?} is not in {:?}", self.stderr);
        }
    }
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Self { code: output.status.code().unwrap(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}

fn program() -> Command {
    Command::new(crate::PROGRAM)
}

pub fn run(arguments: &[&str]) -> Run {
    program().args(arguments).output().unwrap().into()
}

pub fn run_in(scratch: &Scratch, arguments: &[&str]) -> Run {
    program().args(arguments).current_dir(&scratch.0).output().unwrap().into()
}

pub fn run_with_input(arguments: &[&str], input: &str) -> Run {
    let mut child = program()
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    child.wait_with_output().unwrap().into()
}

/// Runs with a limit on the size of files, in blocks of 512 or 1024 bytes as the shell has it.
#[cfg(unix)]
pub fn run_limited(blocks: usize, arguments: &str) -> Run {
    let script = format!("ulimit -f {blocks}; exec '{}' {arguments}", crate::PROGRAM);
    Command::new("sh").args(["-c", &script]).output().unwrap().into()
}

/// Runs where no thread can be started: stacks that no address space has room for do what a limit on processes does to users other
/// than root.
pub fn run_without_threads(arguments: &[&str]) -> Run {
    program().args(arguments).env("RUST_MIN_STACK", (1_usize << 60).to_string()).output().unwrap().into()
}

/// Runs with the vector instructions of this name.
pub fn run_with_instructions(name: &str, arguments: &[&str]) -> Run {
    program().args(arguments).env("DIFFUSE_CONTACT_ISA", name).output().unwrap().into()
}

/// Runs the program, reads a few bytes of its output and closes the pipe.
pub fn run_and_close_stdout(arguments: &[&str]) -> Run {
    let mut child = program().args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stdout = child.stdout.take().unwrap();
    stdout.read_exact(&mut [0; 8]).unwrap();
    drop(stdout);
    child.wait_with_output().unwrap().into()
}

/// A directory of one test, removed at its end.
pub struct Scratch(PathBuf);

impl Scratch {
    pub fn new(name: &str) -> Self {
        let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn path(&self, name: &str) -> String {
        self.0.join(name).to_str().unwrap().to_owned()
    }

    /// Writes a file and returns its path.
    pub fn file(&self, name: &str, text: &str) -> String {
        fs::write(self.0.join(name), text).unwrap();
        self.path(name)
    }

    /// Names of everything in the directory, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
