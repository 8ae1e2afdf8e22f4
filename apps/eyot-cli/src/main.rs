//! `eyot`: makes, ages and looks at landscapes from the command line.
//!
//! A client of the facade's runs and of nothing else. Exit codes: 0 done, 1 failed, 2 wrong usage or recipe, 130 stopped by
//! Ctrl-C and ready to resume.

mod args;
mod convert;
mod look;
mod made;
mod print;
mod progress;
mod report;
mod runs;
mod words;

use args::{Cli, Verb};
use clap::Parser;
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
    let cli = Cli::parse();
    report::install();
    let result = match cli.verb {
        Verb::Run(a) => runs::run(&a),
        Verb::Resume(a) => runs::resume(&a),
        Verb::List(a) => words::list(&a),
        Verb::New(a) => made::new(&a),
        Verb::Check(a) => made::check(&a),
        Verb::Describe(a) => words::describe(&a),
        Verb::Schema => words::schema(),
        Verb::Render(a) => look::render(&a),
        Verb::Stats(a) => look::stats(&a),
        Verb::Convert(a) => convert::convert(&a),
        Verb::Bench(a) => look::measure(&a),
    };
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
