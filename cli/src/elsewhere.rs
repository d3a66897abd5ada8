//! Jobs of the other programs: the solver's and the laboratory's, which take longer to build than what most users need.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use crate::error::CliError;

/// A program beside this one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Program {
    /// Name of its file.
    name: &'static str,
    /// Package that it is built from.
    package: &'static str,
}

/// `solve` and `report`.
pub const SOLVER: Program = Program { name: "diffuse-contact-solve", package: "diffuse-contact-solver" };
/// `check`, `study`, `bench` and `emit`.
pub const LABORATORY: Program =
    Program { name: "diffuse-contact-laboratory", package: "diffuse-contact-laboratory" };

/// Why a job of another program is not done.
#[derive(Debug, thiserror::Error)]
pub enum ElsewhereError {
    #[error(
        "`{job}` is a job of the program {name}, which is neither beside this one nor on the PATH; \
         cargo build --release -p {package} builds it"
    )]
    Missing { job: String, name: &'static str, package: &'static str },
    #[error("{}: cannot be run: {reason}", path.display())]
    Run { path: PathBuf, reason: std::io::Error },
}

impl From<ElsewhereError> for CliError {
    fn from(error: ElsewhereError) -> Self {
        Self::job(error)
    }
}

/// Runs the other program with the arguments of this one. Its exit code is this program's; on Unix it takes this one's place, so
/// that signals reach it, too.
pub fn run(program: Program) -> Result<ExitCode, CliError> {
    let job = env::args_os().nth(1).map_or_else(String::new, |job| job.to_string_lossy().into_owned());
    run_for(program, job)
}

/// The same for a job that a message calls `job`.
pub fn run_for(program: Program, job: String) -> Result<ExitCode, CliError> {
    let arguments: Vec<OsString> = env::args_os().skip(1).collect();
    let Program { name, package } = program;
    let Some(path) = find(name) else {
        return Err(ElsewhereError::Missing { job, name, package }.into());
    };
    let mut command = Command::new(&path);
    command.args(arguments);
    Ok(replace(&mut command).map_err(|reason| ElsewhereError::Run { path, reason })?)
}

#[cfg(unix)]
fn replace(command: &mut Command) -> std::io::Result<ExitCode> {
    Err(std::os::unix::process::CommandExt::exec(command))
}

#[cfg(not(unix))]
fn replace(command: &mut Command) -> std::io::Result<ExitCode> {
    let code = command.status()?.code().unwrap_or(1);
    Ok(ExitCode::from(u8::try_from(code).unwrap_or(1)))
}

/// The program's file: beside the one that runs, or else on the PATH.
fn find(name: &str) -> Option<PathBuf> {
    let file = format!("{name}{}", env::consts::EXE_SUFFIX);
    let own = env::current_exe().ok();
    let beside = own.as_deref().and_then(Path::parent).map(Path::to_path_buf);
    let path = env::var_os("PATH").unwrap_or_default();
    let mut candidates = beside.into_iter().chain(env::split_paths(&path)).map(|folder| folder.join(&file));
    candidates.find(|candidate| candidate.is_file())
}
