//! The jobs `solve` and `report`: statics with contact from a deck, and its page.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind, IsTerminal, Write, stderr};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use diffuse_contact_mesh::names::shown;
use diffuse_contact_solver::contact::{Beginning, Fallbacks};
use diffuse_contact_solver::output::{Summary, Watcher, is_result, names};
use diffuse_contact_solver::report::report as page;
use diffuse_contact_solver::solve::{SolveError, SolveOptions, solve_text};
use diffuse_contact_solver::statics::{Control, Failure, IncrementRecord, IterationRecord, ShownTime};

use crate::error::{self, CliError, say};
use crate::input;
use crate::output;
use crate::threads::{self, with_threads};
use crate::words::counted;

/// Exit code of a run that ended before the end of time.
const ENDED_EARLY: u8 = 1;
/// Exit code of a run that was stopped from the keyboard.
const STOPPED: u8 = 130;

/// What is written, for the help.
const FILES: &str = "\
DIR/summary.json    how the run ended: converged, increments, cut-backs, Newton iterations, penetration, force, time
DIR/report.html     the same to look at, offline: force over displacement, iterations, convergence, deformed shape
DIR/results.pvd     for ParaView: displacement, stress, plastic strain, contact gap and pressure over time
DIR/history.csv     a line per increment: penetration, contact forces, displacements and reactions of the supports
DIR/iterations.csv  a line per residual
DIR/state.json      what --restart goes on from

Every finished increment is on disk before the next begins. Ctrl-C ends the run after the increment on its way, a second one
at once. With the same deck, number of threads and vector instructions --restart leads to the same result, bit for bit, as a run that was not
interrupted.

Exit code 0: the end of time was reached; 1: it was not, or the disk is full: what there is is whole; 130: stopped by
Ctrl-C; 2: bad input, nothing was written.

docs/how-to/decks.md lists the fields of a deck, docs/solver.md says how it is solved; examples/*.toml are decks.";

/// Arguments of `solve`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = FILES)]
pub struct SolveArguments {
    /// Deck in TOML; `-` reads standard input
    pub deck: PathBuf,
    /// Directory of results [default: the deck's name, or `deck`, with `.results`, in the current directory]
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Go on from the last finished increment in DIR, to the same result
    #[arg(long, conflicts_with = "overwrite")]
    pub restart: bool,
    /// Replace results in DIR
    #[arg(long)]
    pub overwrite: bool,
    /// Threads [default: as many as the machine has]
    #[arg(long, value_name = "K", value_parser = threads::parse)]
    pub threads: Option<usize>,
    /// Print a line for each iteration, not only for each increment
    #[arg(short, long)]
    pub verbose: bool,
}

/// Arguments of `report`.
#[derive(Args, Clone, Debug)]
pub struct ReportArguments {
    /// Directories of results that are shown together, such as those of both elements
    #[arg(required = true, value_name = "DIR")]
    pub directories: Vec<PathBuf>,
    /// Page to write
    #[arg(short, long, visible_alias = "out", value_name = "OUT.html", default_value = "report.html")]
    pub output: PathBuf,
}

/// Solves a deck.
pub fn run(arguments: &SolveArguments) -> Result<ExitCode, CliError> {
    let (name, text) = input::read(&arguments.deck)?;
    let text = String::from_utf8(text).map_err(|_| CliError::Read {
        path: name.as_str().into(),
        reason: io::Error::new(ErrorKind::InvalidData, "it is no text in UTF-8"),
    })?;
    let is_named = arguments.deck != Path::new("-");
    let deck = if is_named { arguments.deck.clone() } else { PathBuf::from(name) };
    let stem = if is_named { arguments.deck.file_stem().unwrap_or_default() } else { "deck".as_ref() };
    let stem = stem.to_string_lossy();
    let out = arguments.out.clone().unwrap_or_else(|| PathBuf::from(format!("{stem}.results")));
    let stop = Arc::new(AtomicBool::new(false));
    stop_on_interrupt(&stop);
    let options = SolveOptions::new(&out)
        .with_restart(arguments.restart)
        .with_overwrite(arguments.overwrite)
        .with_threads(arguments.threads.unwrap_or_else(rayon::current_num_threads));
    let mut progress = Progress {
        stop: Arc::clone(&stop),
        verbose: arguments.verbose,
        iterations: 0,
        fallbacks: BTreeMap::new(),
    };
    let outcome = with_threads(arguments.threads, || Ok(solve_text(text, &deck, &options, &mut progress)))?;
    match outcome {
        Ok(summary) => {
            tell(&summary, &out);
            let stopped = !summary.converged;
            Ok(if stopped { ExitCode::from(STOPPED) } else { ExitCode::SUCCESS })
        }
        Err(reason) if is_no_fault_of_the_input(&reason) => {
            error::report(&reason);
            Ok(ExitCode::from(ENDED_EARLY))
        }
        Err(reason) => Err(CliError::job(reason)),
    }
}

/// Whether a run ended that had begun, or could not begin for want of space.
fn is_no_fault_of_the_input(reason: &SolveError) -> bool {
    match reason {
        SolveError::EndedEarly { .. } => true,
        SolveError::Output(reason) => reason.is_full_disk(),
        _ => false,
    }
}

/// Writes the page for directories of results.
pub fn report(arguments: &ReportArguments) -> Result<(), CliError> {
    for directory in &arguments.directories {
        if is_result(directory, &arguments.output) {
            return Err(CliError::OutputIsInput { path: arguments.output.clone() });
        }
    }
    output::check_target(&arguments.output)?;
    output::check_page(&arguments.output)?;
    let directories: Vec<&Path> = arguments.directories.iter().map(PathBuf::as_path).collect();
    let page = page(&directories).map_err(|reason| CliError::job(SolveError::from(reason)))?;
    output::write_file(&arguments.output, |writer| writer.write_all(page.as_bytes()))?;
    say(&format!("wrote {}", arguments.output.display()));
    Ok(())
}

/// The first interrupt asks the run to end, the second ends the program.
fn stop_on_interrupt(stop: &Arc<AtomicBool>) {
    let stop = Arc::clone(stop);
    let handler = move || {
        if stop.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(STOPPED));
        }
        say("\nending after this increment; Ctrl-C again ends at once");
    };
    // Without a handler an interrupt ends the program at once, and what is on disk is whole all the same.
    let _ = ctrlc::set_handler(handler);
}

/// Tells how a run goes.
struct Progress {
    stop: Arc<AtomicBool>,
    verbose: bool,
    /// Residuals of the increment on its way.
    iterations: usize,
    /// Of each interface its slaves and the most fallbacks that were told.
    fallbacks: BTreeMap<String, (usize, Fallbacks)>,
}

impl Watcher for Progress {
    fn model(&mut self, warnings: &[String]) {
        warnings.iter().for_each(|warning| say(&format!("warning: {warning}")));
    }

    fn warning(&mut self, warning: &str) {
        say(&format!("  warning: {warning}"));
    }

    fn start(&mut self, interfaces: &[Beginning]) {
        for beginning in interfaces {
            let Beginning { interface, penalty, adjusted, slaves, paired, overlap, .. } = beginning;
            say(&format!(
                "interface `{}`: {paired} of {} paired, deepest overlap {overlap:.3e}, penalty {penalty:.3e}",
                shown(interface),
                counted(*slaves, "slave")
            ));
            match adjusted {
                Some((0, _)) => say("  no slave was to be moved into touch"),
                Some((moved, way)) => {
                    say(&format!("  {} moved into touch, by up to {way:.3e}", counted(*moved, "slave")));
                }
                None => {}
            }
            beginning.notes().iter().for_each(|note| say(&format!("  note: {note}")));
            beginning.warnings().iter().for_each(|warning| say(&format!("  warning: {warning}")));
            self.fallbacks.insert(interface.clone(), (*slaves, beginning.fallbacks));
        }
    }

    fn resume(&mut self, interfaces: &[Beginning], fallbacks: &BTreeMap<String, Fallbacks>) {
        for Beginning { interface, slaves, fallbacks: at_start, .. } in interfaces {
            let most = fallbacks.get(interface).map_or(*at_start, |most| most.max(*at_start));
            self.fallbacks.insert(interface.clone(), (*slaves, most));
        }
    }

    fn other_instructions(&mut self, before: &str, now: &str) {
        say(&format!(
            "note: the run was made with {} instructions so far and goes on with {now}: it ends as one without interruption does but for \
             rounding; DIFFUSE_CONTACT_ISA chooses them",
            shown(before)
        ));
    }

    fn iteration(&mut self, record: &IterationRecord) {
        self.iterations += 1;
        let IterationRecord { time, iteration, relative, active, step, .. } = record;
        let time = ShownTime(*time);
        if self.verbose {
            let line = format!("  time {time:<8}  iteration {iteration:2}  relative residual {relative:.3e}");
            say(&format!("{line}  contacts {active}  step {step:.3}"));
        } else if stderr().is_terminal() {
            let _ = write!(
                stderr().lock(),
                "\r  time {time:<8}  iteration {iteration:2}  relative residual {relative:.3e}\x1b[K"
            );
        }
    }

    fn cut_back(&mut self, end: f64, length: f64, reason: &Failure) -> Control {
        self.clear();
        say(&format!(
            "cut back: no equilibrium at time {} (increment {length:.3e}): {reason}",
            ShownTime(end)
        ));
        self.control()
    }

    fn increment(&mut self, record: &IncrementRecord) -> Control {
        self.clear();
        let residual = record.history.last().map_or_else(String::new, decision);
        say(&format!(
            "increment {:4}  time {:<8}  {:2} {:<10}  {residual}  contacts {}  penetration {:.3e}",
            record.number,
            ShownTime(record.time),
            record.iterations,
            if record.iterations == 1 { "iteration" } else { "iterations" },
            record.active,
            record.max_penetration
        ));
        self.tell_warnings(record);
        self.control()
    }
}

/// What decided that an increment is in equilibrium: the residual, force, beside what it may be by both tolerances, or the rounding of
/// the positions that makes it larger.
fn decision(last: &IterationRecord) -> String {
    let IterationRecord { residual, allowed, .. } = last;
    let why = if last.is_rounded() { "rounding of positions; " } else { "" };
    format!("residual {residual:.1e} ({why}allowed {allowed:.1e})")
}

impl Progress {
    fn control(&self) -> Control {
        if self.stop.load(Ordering::SeqCst) { Control::Stop } else { Control::Continue }
    }

    /// Tells what of an increment is to be looked at.
    fn tell_warnings(&mut self, record: &IncrementRecord) {
        if record.is_short {
            say("  warning: the rounds of augmentation are over, the tolerance is not met");
        }
        if record.lost > 0 {
            say(&format!(
                "  warning: lost {}: slaves went through their masters, or have no element any more",
                counted(record.lost, "contact")
            ));
        }
        for (interface, slaves) in &record.vanished {
            let interface = shown(interface);
            say(&format!(
                "  warning: the interface `{interface}` carries no force any more, although {} that carried it did not rise",
                counted(*slaves, "slave")
            ));
        }
        self.tell_fallbacks(&record.fallbacks);
        if record.supposed > 0 {
            say(&format!(
                "  note: nothing but contact can hold a body: slaves near their masters were taken to touch in {}",
                counted(record.supposed, "linear solution")
            ));
        }
        if record.softened {
            say(
                "  note: a body came loose from its contact on the way: contact was found with softer penalties first",
            );
        }
        if let Some(count) = record.negative.filter(|_| record.is_unstable()) {
            say(&format!(
                "  note: the last stiffness that was solved with has {}: equilibrium is not stable",
                counted(count, "negative eigenvalue")
            ));
        }
        if record.stabilised > 0 {
            say(&format!(
                "  note: nothing but the stabilisation holds a body in {}",
                counted(record.stabilised, "linear solution")
            ));
        }
        if record.linear.bytes > 0 {
            say(&format!(
                "  linear solver: {}, {:.2} GB",
                counted(record.linear.iterations, "iteration"),
                record.linear.bytes as f64 / 1e9
            ));
        }
        if record.linear.direct_instead > 0 {
            say(&format!(
                "  warning: solved {} directly: the iterative solution did not converge",
                counted(record.linear.direct_instead, "linear system")
            ));
        }
        if record.missed > 0 {
            say(&format!(
                "  warning: {} points of loaded faces carry no force: their element has no result, or their line of force meets no place of the facet",
                record.missed
            ));
        }
        if record.unanchored() > 0 {
            say(&format!(
                "  warning: {} slaves carry force without friction: they had no gap at the end of the increment before",
                record.unanchored()
            ));
        }
    }

    /// Tells of fallbacks where they are more than ever before.
    fn tell_fallbacks(&mut self, now: &[(String, Fallbacks)]) {
        for (interface, now) in now {
            let Some((slaves, most)) = self.fallbacks.get_mut(interface) else { continue };
            now.warnings(*most, interface, *slaves)
                .iter()
                .for_each(|warning| say(&format!("  warning: {warning}")));
            *most = most.max(*now);
        }
    }

    /// Removes the line of the last iteration from a terminal.
    fn clear(&mut self) {
        if self.iterations > 0 && !self.verbose && stderr().is_terminal() {
            let _ = write!(stderr().lock(), "\r\x1b[K");
        }
        self.iterations = 0;
    }
}

/// How it ended, and where to look.
fn tell(summary: &Summary, out: &Path) {
    let end = if summary.converged { "converged" } else { "stopped" };
    say(&format!(
        "{end} at time {}: {}, {}, {}, {:.2} s; {}",
        ShownTime(summary.time),
        counted(summary.increments, "increment"),
        counted(summary.cutbacks, "cut-back"),
        counted(summary.newton_iterations, "Newton iteration"),
        summary.wall_s,
        out.join(names::REPORT).display()
    ));
    summary.shortcomings().iter().for_each(|warning| say(&format!("warning: {warning}")));
}
