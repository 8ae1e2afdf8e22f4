//! Progress on the terminal: one bar for the step of the recipe, one for the whole run.

use crate::print;
use crate::wording::CommandLine;
use eyot::Event;
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Whatever ends sooner is not worth a bar.
const PATIENCE: Duration = Duration::from_secs(1);
/// Without a terminal a line is enough now and then.
const LINE_TIME: Duration = Duration::from_secs(10);

/// The bars of a run.
pub(crate) struct Bars {
    all: MultiProgress,
    step: Option<ProgressBar>,
    whole: Option<ProgressBar>,
    terminal: bool,
    begun: Instant,
    last_line: Instant,
    title: String,
    steps: usize,
    first: usize,
    overall_before: Option<(Instant, f64)>,
}

impl Bars {
    pub(crate) fn new() -> Self {
        let now = Instant::now();
        Self {
            all: MultiProgress::new(),
            step: None,
            whole: None,
            terminal: std::io::stderr().is_terminal(),
            begun: now,
            last_line: now,
            title: String::new(),
            steps: 0,
            first: 0,
            overall_before: None,
        }
    }

    /// Shows an event.
    pub(crate) fn show(&mut self, event: &Event) {
        match event {
            Event::Started { name, size, cell_m, seed, steps, engine, threads, resumed, .. } => {
                self.steps = *steps;
                let again = if *resumed { ", resumed" } else { "" };
                let cell = print::cell(cell_m[0], cell_m[1]);
                self.say(&format!(
                    "{name}: {} x {} cells of {cell}, seed {seed}, {engine}, {threads} threads{again}",
                    size[0], size[1]
                ));
            }
            Event::StepBegun { number, name, .. } => {
                self.first += 1;
                self.title = format!("{number}. {name}");
                self.end_step();
            }
            Event::Long { seconds, timed, rough } => self.say(&format!("  {}", announcement(*seconds, *timed, *rough))),
            Event::Progress(p) => {
                let title = self.title.clone();
                let mut speed = match (p.steps_per_s, p.eta_s) {
                    (r, Some(eta)) if r > 0.0 => format!("{} steps/s, {} left", rate(r), time(eta)),
                    _ => String::new(),
                };
                if let Some(score) = p.erosion_score {
                    let comma = if speed.is_empty() { "" } else { ", " };
                    speed += &format!("{comma}erosion score {score:.4}");
                }
                let comma = if speed.is_empty() { "" } else { ", " };
                if !self.terminal {
                    if self.last_line.elapsed() >= LINE_TIME {
                        self.last_line = Instant::now();
                        self.say(&format!(
                            "  {title}: {} of {}{comma}{speed} ({:.0} % of all)",
                            p.step,
                            p.total,
                            p.overall * 100.0
                        ));
                    }
                    return;
                }
                if self.begun.elapsed() < PATIENCE {
                    return;
                }
                let (at, before) = *self.overall_before.get_or_insert((Instant::now(), p.overall));
                let gained = p.overall - before;
                let left = if gained > 1e-4 {
                    time(at.elapsed().as_secs_f64() * (1.0 - p.overall) / gained) + " left"
                } else {
                    String::new()
                };
                let step = self.step.get_or_insert_with(|| {
                    self.all.insert(0, bar("{prefix:<20!} {bar:20.cyan/black} {pos}/{len} {msg}", p.total))
                });
                step.set_prefix(print::clean(&title).into_owned());
                step.set_length(p.total);
                step.set_position(p.step);
                step.set_message(speed);
                let whole = self.whole.get_or_insert_with(|| {
                    self.all.add(bar("{prefix:<20!} {bar:20.green/black} {percent:>3} % {msg}", 1000))
                });
                whole.set_prefix("whole run");
                whole.set_position((p.overall * 1000.0) as u64);
                whole.set_message(left);
            }
            Event::StepDone { number, name, seconds } => {
                self.end_step();
                self.say(&format!("  {number}. {name}: {}", time(*seconds)));
            }
            Event::Paused { recipe_step, step } => {
                self.say(&format!("  paused in step {recipe_step} after {step} steps"))
            }
            Event::Rewound { steps_done, .. } => self.say(&format!("  back at {steps_done} steps")),
            Event::Branched { out, steps_done } => {
                self.say(&format!("  {} begins at {steps_done} steps", out.display()));
            }
            Event::Changed(e) => self.say(&format!("  {} from step {} on", e.set.replace('\n', ", "), e.step)),
            Event::NotChanged { set, reason } => {
                let set = set.replace('\n', ", ");
                self.say(&format!("  not changed: `{set}`: {}", reason.worded(&CommandLine)));
            }
            Event::Warning { message } => self.say(&format!("warning: {}", message.worded(&CommandLine))),
            Event::Joined { client, address } => self.say(&format!("  client {client} at {address} has connected")),
            Event::Left { client, reason, .. } => self.say(&format!("  client {client} is gone: {reason}")),
            Event::Refused { address, reason } => self.say(&format!("  {address} was not let in: {reason}")),
            Event::Writing { path } => {
                self.title = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
                self.say(&format!("  writing {}", path.display()));
            }
            Event::Done { fingerprint, seconds, .. } => {
                self.end_all();
                self.say(&format!("done in {} (fingerprint {fingerprint})", time(*seconds)));
            }
            Event::Stopped { .. } | Event::Failed { .. } => self.end_all(),
            _ => {}
        }
    }

    fn say(&self, text: &str) {
        self.all.suspend(|| print::note(text));
    }

    fn end_step(&mut self) {
        if let Some(bar) = self.step.take() {
            bar.finish_and_clear();
        }
    }

    fn end_all(&mut self) {
        self.end_step();
        if let Some(bar) = self.whole.take() {
            bar.finish_and_clear();
        }
    }
}

impl Drop for Bars {
    fn drop(&mut self) {
        self.end_all();
    }
}

/// How long a run will take.
fn announcement(seconds: f64, timed: u64, rough: bool) -> String {
    let about = match seconds {
        s if s < 90.0 * 60.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    };
    let how = if rough { "very roughly" } else { "about" };
    let steps = if timed == 1 { "step" } else { "steps" };
    format!(
        "this will take {how} {about}, by the first {timed} {steps}; Ctrl-C keeps what is done, --size makes it smaller"
    )
}

pub(crate) fn bar(template: &str, length: u64) -> ProgressBar {
    // A template that does not parse would be a slip in this file; the plain bar shows as much.
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(length).with_style(style)
}

fn rate(r: f64) -> String {
    if r >= 100.0 { format!("{r:.0}") } else { format!("{r:.1}") }
}

pub(crate) fn time(seconds: f64) -> String {
    match seconds {
        s if s < 0.0995 => format!("{:.0} ms", s * 1e3),
        s if s < 60.0 => format!("{s:.1} s"),
        s if s < 3600.0 => format!("{:.0} min {:02.0} s", (s / 60.0).floor(), s % 60.0),
        s => format!("{:.0} h {:02.0} min", (s / 3600.0).floor(), (s % 3600.0) / 60.0),
    }
}

#[cfg(test)]
mod tests {
    use super::announcement;

    #[test]
    fn long_runs_are_announced_in_minutes_or_hours() {
        assert!(announcement(437.0, 3, false).starts_with("this will take about 7 min, by the first 3 steps"));
        assert!(announcement(9000.0, 1, true).starts_with("this will take very roughly 2.5 h, by the first 1 step;"));
    }
}
