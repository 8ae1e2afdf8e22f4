//! `doctor`: what this machine can simulate on.

use crate::args::Doctor;
use crate::wording::CommandLine;
use crate::{Failure, print, report};
use eyot::core::remedy::Worded;
use eyot_bench::doctor::{Examination, examine};

/// Looks at the machine and tests it.
pub(crate) fn doctor(args: &Doctor) -> Result<(), Failure> {
    let mut found =
        examine(args.adapter.as_deref()).map_err(|e| Failure::Failed(report::plain(&e.worded(&CommandLine), None)))?;
    found.test.failure = found.test.failure.map(|f| f.worded(&CommandLine).into());
    if args.json {
        let json = serde_json::to_value(&found).map_err(|e| Failure::Failed(report::plain(&e.to_string(), None)))?;
        print::line(&format!("{json:#}"))?;
    } else {
        text(&found)?;
    }
    if found.test.passed {
        return Ok(());
    }
    let message = found.test.failure.map_or_else(|| "the engines do not agree".to_owned(), |f| f.to_string());
    let help = "--engine cpu works without a graphics card; a driver that gives other results is worth a report";
    Err(Failure::Failed(report::plain(&message, Some(help.to_owned()))))
}

fn text(e: &Examination) -> Result<(), Failure> {
    print::line(&format!("Processor: {} threads, {}", e.threads, e.isa))?;
    if e.adapters.is_empty() {
        print::line("Graphics adapters: none")?;
    } else {
        print::line("Graphics adapters:")?;
    }
    for a in &e.adapters {
        print::line(&format!("  {} ({}, {}; {})", a.name, a.kind, a.backend, a.driver))?;
        print::line(&format!(
            "      buffers up to {} MiB, {} MiB of one at a time; {} KiB a workgroup; {}",
            a.max_buffer >> 20,
            a.max_binding >> 20,
            a.workgroup_memory >> 10,
            if a.timestamps { "times its own work" } else { "has no clock" }
        ))?;
    }
    print::line(&format!("--engine auto takes: {}, since {}", e.auto, e.because))?;
    let t = &e.test;
    print::line(&format!("Self-test: {} steps of erosion on {} x {} cells", t.steps, t.size, t.size))?;
    let ms = |s: f64| format!("{:.0} ms", 1e3 * s);
    print::line(&format!("  processor: {}", ms(t.processor_s)))?;
    match (t.other_s, t.difference) {
        (Some(s), Some(d)) => print::line(&format!(
            "  {}: {}; heights differ by {d:.1e} of the relief, {:.0e} are allowed: {}",
            t.compared,
            ms(s),
            t.tolerance,
            if t.passed { "passed" } else { "FAILED" }
        )),
        _ => print::line(&format!("  {}: FAILED", t.compared)),
    }
}
