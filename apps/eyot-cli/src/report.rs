//! Errors as people read them: the source, the place, the remedy.

use crate::Failure;
use crate::excerpt::{clipped, excerpt};
use crate::print::clean;
use crate::wording::CommandLine;
use eyot::remedy::Worded;
use eyot::{Problems, RunError, Source};
use miette::{Diagnostic, LabeledSpan, MietteHandlerOpts, NamedSource, Report, SourceCode};
use std::fmt;
use std::io::IsTerminal;

/// Messages quote names, and a name may be a whole book, characters.
const LONGEST_MESSAGE: usize = 1500;

/// Chooses how reports look.
pub(crate) fn install() {
    // Fails only if it is called twice.
    let _ = miette::set_hook(Box::new(|_| {
        let plain = !std::io::stderr().is_terminal() || std::env::var_os("NO_COLOR").is_some();
        let options = MietteHandlerOpts::new().context_lines(1).terminal_links(false);
        Box::new(if plain { options.unicode(false).color(false).width(120) } else { options }.build())
    }));
}

/// Prints a report to the standard error.
pub(crate) fn show(report: &Report) {
    crate::print::drawn(format!("{report:?}").trim_end());
}

/// One sentence and a remedy, without a place.
pub(crate) fn plain(message: &str, help: Option<String>) -> Report {
    Report::new(One::new(message, help))
}

/// Wrong usage.
pub(crate) fn usage(message: &str, help: &str) -> Failure {
    Failure::Usage(plain(message, Some(help.to_owned())))
}

/// Everything that is wrong with a recipe, drawn one after the other.
pub(crate) fn recipe(problems: &Problems) -> Failure {
    let mut all: Vec<One> = problems
        .diagnostics
        .iter()
        .map(|d| {
            let place = d.span.as_ref().and_then(|s| Some((s, problems.source(s)?)));
            let (label, source) = place
                .map(|(s, source)| {
                    let (text, at, column) = excerpt(&clean(&source.text), s.start..s.end);
                    let label = match column {
                        Some(c) => format!("{} (column {c} of a long line)", d.label),
                        None => d.label.clone(),
                    };
                    let label = LabeledSpan::new(Some(clean(&label).into_owned()), at.start, at.len());
                    (label, NamedSource::new(clean(source_name(source)), text).with_language("TOML"))
                })
                .unzip();
            let message = clipped(&d.message.worded(&CommandLine), LONGEST_MESSAGE).into_owned();
            let help = d.help.as_ref().map(|h| clipped(&h.worded(&CommandLine), LONGEST_MESSAGE).into_owned());
            One { label, source, ..One::new(&message, help) }
        })
        .collect();
    let name = problems.sources.first().map_or("the recipe", source_name);
    let message = match all.len() {
        1 => format!("{name} cannot be run"),
        n if problems.more == 0 => format!("{name} cannot be run: {n} problems"),
        n => format!("{name} cannot be run: {n} problems and more"),
    };
    all.extend(problems.rest().map(|message| One::new(&message, None)));
    Failure::Usage(Report::new(Many { message: clean(&message).into_owned(), all }))
}

/// The file, or the flag that a text was given with.
fn source_name(source: &Source) -> &str {
    if source.name == Source::SET { "--set" } else { &source.name }
}

/// An error of the facade with its exit code.
pub(crate) fn run(e: &RunError) -> Failure {
    let report = plain(&e.worded(&CommandLine), e.help().map(|h| h.worded(&CommandLine)));
    match e {
        RunError::Recipe(p) => recipe(p),
        _ if e.is_refusal() => Failure::Usage(report),
        _ => Failure::Failed(report),
    }
}

/// What is shown of a mistake, [`clean`].
#[derive(Debug)]
struct One {
    message: String,
    help: Option<String>,
    label: Option<LabeledSpan>,
    source: Option<NamedSource<String>>,
}

impl One {
    fn new(message: &str, help: Option<String>) -> Self {
        let help = help.map(|h| clean(&h).into_owned());
        Self { message: clean(message).into_owned(), help, label: None, source: None }
    }
}

impl fmt::Display for One {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for One {}

impl Diagnostic for One {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|h| Box::new(h) as Box<dyn fmt::Display>)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.label.clone().map(|l| Box::new(std::iter::once(l)) as Box<dyn Iterator<Item = LabeledSpan>>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|s| s as &dyn SourceCode)
    }
}

#[derive(Debug)]
struct Many {
    message: String,
    all: Vec<One>,
}

impl fmt::Display for Many {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Many {}

impl Diagnostic for Many {
    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.all.iter().map(|d| d as &dyn Diagnostic)))
    }
}
