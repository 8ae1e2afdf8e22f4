//! `eyot`: makes, ages and looks at landscapes from the command line.
//!
//! A client of the facade's runs and of nothing else. Exit codes: 0 done, 1 failed, 2 refused before anything was begun (wrong
//! usage, recipe or input), 130 stopped by Ctrl-C and ready to resume.

mod args;
mod convert;
mod doctor;
mod excerpt;
mod film;
mod info;
mod inspect;
mod print;
mod progress;
mod recipe_cmd;
mod report;
mod runs;
mod section;
mod serve;
mod sweep;
mod timeline;
mod wording;

use args::{Cli, Verb};
use clap::Parser;
use eyot::engines::Isa;
use std::io::IsTerminal;
use std::process::ExitCode;

/// Why a command did not succeed.
enum Failure {
    /// Wrong usage or a wrong recipe: exit code 2.
    Usage(miette::Report),
    /// Anything else: exit code 1.
    Failed(miette::Report),
    /// Stopped on request: exit code 130.
    Stopped,
    /// The reader of our output has gone; nobody is left to tell.
    Closed,
}

fn main() -> ExitCode {
    report::install();
    survive_small_files();
    let cli = match parse() {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    let result = choose_isa().and_then(|()| work(cli.verb));
    match result {
        Ok(()) | Err(Failure::Closed) => ExitCode::SUCCESS,
        Err(Failure::Usage(r)) => {
            report::show(&r);
            ExitCode::from(2)
        }
        Err(Failure::Failed(r)) => {
            report::show(&r);
            ExitCode::from(1)
        }
        Err(Failure::Stopped) => ExitCode::from(130),
    }
}

/// A file that grows beyond a limit of the shell (`ulimit -f`) would end the program without a word. With somebody who listens
/// to the signal, the write fails instead, and says why.
fn survive_small_files() {
    #[cfg(unix)]
    {
        /// The same number on every system that has the signal.
        const SIGXFSZ: i32 = 25;
        // Without it the program is as fragile as most others.
        let _ = signal_hook::flag::register(SIGXFSZ, std::sync::Arc::default());
    }
}

/// The command line; help and version are printed as everything else, so that it shows if they cannot be.
fn parse() -> Result<Cli, ExitCode> {
    Cli::try_parse().map_err(|e| {
        if e.use_stderr() || std::io::stdout().is_terminal() {
            e.exit();
        }
        match print::line(&e.render().to_string()) {
            Ok(()) | Err(Failure::Closed) => ExitCode::SUCCESS,
            Err(Failure::Usage(r) | Failure::Failed(r)) => {
                report::show(&r);
                ExitCode::from(1)
            }
            Err(Failure::Stopped) => ExitCode::from(130),
        }
    })
}

/// `EYOT_ISA=scalar|baseline|avx2|avx512` asks for a lesser instruction set than the processor has.
fn choose_isa() -> Result<(), Failure> {
    let Some(name) = std::env::var_os("EYOT_ISA").filter(|n| !n.is_empty()) else { return Ok(()) };
    let known: Vec<Isa> = Isa::ALL.into_iter().filter(|i| i.is_available()).collect();
    let names: Vec<&str> = known.iter().map(|i| i.name()).collect();
    match known.iter().find(|i| name == i.name()) {
        Some(isa) => isa.use_at_most(),
        None => {
            let message = format!("EYOT_ISA is \"{}\", which this processor does not have", name.to_string_lossy());
            return Err(report::usage(&message, &format!("unset it, or choose one of: {}", names.join(", "))));
        }
    }
    Ok(())
}

fn work(verb: Verb) -> Result<(), Failure> {
    match verb {
        Verb::Run(a) => runs::run(&a),
        Verb::Resume(a) => runs::resume(&a),
        Verb::Serve(a) => serve::serve(&a),
        Verb::Timeline(a) => timeline::list(&a),
        Verb::Rewind(a) => timeline::rewind(&a),
        Verb::Branch(a) => timeline::branch(&a),
        Verb::List(a) => info::list(&a),
        Verb::New(a) => recipe_cmd::new(&a),
        Verb::Check(a) => recipe_cmd::check(&a),
        Verb::Describe(a) => info::describe(&a),
        Verb::Cite(a) => recipe_cmd::cite(&a),
        Verb::Schema => info::schema(),
        Verb::Render(a) => inspect::render(&a),
        Verb::Film(a) => film::film(&a),
        Verb::Section(a) => section::section(&a),
        Verb::Stats(a) => inspect::stats(&a),
        Verb::Sweep(a) => sweep::sweep(&a),
        Verb::Convert(a) => convert::convert(&a),
        Verb::Bench(a) => inspect::measure(&a),
        Verb::Doctor(a) => doctor::doctor(&a),
    }
}
