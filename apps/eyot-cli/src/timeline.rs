//! `timeline`, `rewind`, `branch`: recordings of runs.

use crate::args::{Branch, Rewind, Timeline};
use crate::wording::CommandLine;
use crate::{Failure, print, report};
use eyot::core::remedy::Worded;
use eyot::timeline::{Branching, Damaged, Frame};
use eyot::{Limits, Registry, shell_word};
use serde_json::json;

/// Lists the frames of a recording.
pub(crate) fn list(args: &Timeline) -> Result<(), Failure> {
    let timeline = eyot::Timeline::open(&args.folder, &Limits::default()).map_err(|e| report::run(&e))?;
    let (record, frames) = (timeline.record(), timeline.frames());
    let bytes: u64 = frames.iter().map(|f| f.bytes).sum();
    if args.json {
        let object = json!({
            "every": record.every, "max_bytes": record.max_bytes, "bytes": bytes, "frames": frames,
            "damaged": in_words(timeline.damaged().to_vec()),
        });
        return print::line(&object.to_string());
    }
    print::line(&format!(
        "{} frames{}, one each {} steps, {} of {}",
        frames.len(),
        if timeline.damaged().is_empty() {
            String::new()
        } else {
            format!(" and {} damaged", timeline.damaged().len())
        },
        record.every,
        size(bytes),
        size(record.max_bytes)
    ))?;
    print::line("  frame  steps done  step of the recipe          size")?;
    for f in frames {
        let place = format!("{} after {}", f.recipe_step, f.step);
        print::line(&format!("  {:>5}  {:>10}  {place:<18}  {:>12}", f.frame, f.steps_done, size(f.bytes)))?;
    }
    tell(timeline.damaged());
    Ok(())
}

/// Sets a run back.
pub(crate) fn rewind(args: &Rewind) -> Result<(), Failure> {
    let done =
        eyot::timeline::rewind(&args.folder, args.moment.get(), args.forget, &Registry::standard(), &Limits::default());
    let mut done = done.map_err(|e| report::run(&e))?;
    if args.json {
        done.damaged = in_words(done.damaged);
        return print::line(&json!(done).to_string());
    }
    tell(&done.damaged);
    let dropped = match done.dropped {
        0 => String::new(),
        1 => "; one later frame was dropped".to_owned(),
        n => format!("; {n} later frames were dropped"),
    };
    print::line(&format!("{}{dropped}", moment(&done.frame)))?;
    if done.has_results {
        print::line("the results in the folder are those of the run as it was, until it has new ones")?;
    }
    print::line(&format!("continue with: eyot resume {}", shell_word(&args.folder)))
}

/// Begins another run at a recorded moment.
pub(crate) fn branch(args: &Branch) -> Result<(), Failure> {
    let how = Branching { set: args.set.clone(), forget: args.forget };
    let (moment_of, registry) = (args.moment.get(), Registry::standard());
    let done = eyot::timeline::branch(&args.folder, moment_of, &args.out, &how, &registry, &Limits::default());
    let mut done = done.map_err(|e| report::run(&e))?;
    if args.json {
        done.damaged = in_words(done.damaged);
        return print::line(&json!(done).to_string());
    }
    tell(&done.damaged);
    print::line(&format!("{}; continue with: eyot resume {}", moment(&done.frame), shell_word(&args.out)))
}

/// Says which frames are lost.
fn tell(damaged: &[Damaged]) {
    damaged.iter().for_each(|d| print::note(&format!("warning: {}", d.worded(&CommandLine))));
}

/// The same in the words of the command line.
fn in_words(mut damaged: Vec<Damaged>) -> Vec<Damaged> {
    damaged.iter_mut().for_each(|d| d.reason = d.reason.worded(&CommandLine).into());
    damaged
}

fn moment(frame: &Frame) -> String {
    format!("at frame {}, {} steps done", frame.frame, frame.steps_done)
}

/// Bytes in the unit that suits them.
fn size(bytes: u64) -> String {
    const UNITS: [&str; 4] = ["bytes", "KiB", "MiB", "GiB"];
    let unit = (0..3).take_while(|i| bytes >> (10 * (i + 1)) > 0).count();
    let places = usize::from(unit > 0);
    format!("{:.places$} {}", bytes as f64 / (1_u64 << (10 * unit)) as f64, UNITS[unit])
}

#[cfg(test)]
mod tests {
    use super::size;

    #[test]
    fn sizes_have_their_unit() {
        assert_eq!(size(0), "0 bytes");
        assert_eq!(size(1023), "1023 bytes");
        assert_eq!(size(1536), "1.5 KiB");
        assert_eq!(size(2 << 30), "2.0 GiB");
        assert_eq!(size(5 << 40), "5120.0 GiB");
    }
}
