//! `render`, `stats`, `bench`: looking at what is there.

use crate::args::{Bench, Measured, Reading, Render, Stats};
use crate::wording::CommandLine;
use crate::{Failure, print, report};
use eyot::analyse::TerrainOptions;
use eyot::formats::ReadOptions;
use eyot::remedy::Worded;
use eyot::store::Subject;
use eyot::view::ViewRequest;
use eyot::{EngineChoice, EngineOptions, store};
use eyot_bench::{cpu, gpu};
use serde_json::Value;
use std::path::Path;

/// Draws a picture of a run or a height map.
pub(crate) fn render(args: &Render) -> Result<(), Failure> {
    let opened = open(&args.from, &args.reading)?;
    let own = &opened.view;
    // As the run drew its preview, unless somebody says otherwise.
    let above = own.from_above && args.drape.is_none() && !args.look.has_camera();
    let flat = args.relief || args.layer.is_some() || above;
    let size = match args.size {
        None => own.size,
        Some((w, Some(h))) => [w, h],
        Some((w, None)) if flat => [w, w],
        Some((w, None)) => [w, (w * own.size[1] / own.size[0]).max(1)],
    };
    let view = args.look.over(own, size)?;
    let longer = size[0].max(size[1]);
    for (flag, layer) in [("layer", &args.layer), ("drape", &args.drape)] {
        if let Some(layer) = layer {
            known(&opened, &args.from, flag, layer)?;
        }
    }
    if args.layer.is_none() {
        has_ground(&opened, &args.from)?;
    }
    let engine = args.engine.options()?;
    if engine.choice == EngineChoice::Gpu && flat {
        let help = "leave out --engine gpu, or look at the layer on the land with --drape";
        return Err(report::usage("maps and reliefs are drawn by the processor", help));
    }
    let subject = match &args.layer {
        Some(layer) => args.size.map_or(Subject::Layer(layer), |_| Subject::LayerAt(layer, longer)),
        None if args.relief => args.size.map_or(Subject::Relief, |_| Subject::ReliefAt(longer)),
        None if above => Subject::ReliefAt(longer),
        None => Subject::View,
    };
    let out = args.out.clone().unwrap_or_else(|| {
        let name = match subject {
            Subject::View => args.drape.as_ref().map_or("render.png".to_owned(), |l| format!("render_{l}.png")),
            Subject::ReliefAt(_) if !args.relief => "render.png".to_owned(),
            Subject::Relief | Subject::ReliefAt(_) => "render_relief.png".to_owned(),
            Subject::Layer(l) | Subject::LayerAt(l, _) => format!("{l}_map.png"),
        };
        if args.from.is_dir() { args.from.join(name) } else { args.from.with_extension(format!("eyot.{name}")) }
    });
    let limits = args.reading.limits();
    if subject == Subject::View {
        let factor = view.vertical_exaggeration.unwrap_or(1.0);
        let request = ViewRequest { view, drape: args.drape.clone(), engine };
        let drawn = eyot::view::draw_view(&opened.world, &request, &out, &limits).map_err(|e| report::run(&e))?;
        drawn.notes.iter().for_each(|n| print::note(&format!("note: {}", n.worded(&CommandLine))));
        if opened.world.components.contains(eyot::process::COLONIES) {
            print::note(
                "note: a view shows the sea and its floor; single corals are in the pictures of an export with what = \"dive\"",
            );
        }
        let heights = if factor == 1.0 { "heights to scale".to_owned() } else { format!("heights times {factor}") };
        return print::line(&format!("wrote {}, drawn by {}, {heights}", out.display(), drawn.engine));
    }
    store::draw(&opened.world, &view, subject, &out, &limits).map_err(|e| report::run(&e))?;
    print::line(&format!("wrote {}", out.display()))
}

/// Fails if there is no land that a view could show.
pub(crate) fn has_ground(opened: &store::Opened, from: &Path) -> Result<(), Failure> {
    match opened.world.layers().iter().map(|l| &*l.spec.name).next() {
        Some(first) if opened.world.get("height").is_none() => {
            let help = format!("draw a map of a layer: eyot render {} --layer {first}", eyot::shell_word(from));
            Err(report::usage(
                &format!("`{}` has no layer `height`, so there is no land to view", from.display()),
                &help,
            ))
        }
        _ => Ok(()),
    }
}

/// Fails if there is no such layer.
pub(crate) fn known(opened: &store::Opened, from: &Path, flag: &str, layer: &str) -> Result<(), Failure> {
    if opened.world.get(layer).is_some() {
        return Ok(());
    }
    let known: Vec<&str> = opened.world.layers().iter().map(|l| &*l.spec.name).collect();
    let help = match eyot::nearest(layer, known.iter().copied()) {
        Some(n) => format!("did you mean --{flag} {n}?"),
        None => format!("there is: {}", known.join(", ")),
    };
    Err(report::usage(&format!("`{}` has no layer `{layer}`", from.display()), &help))
}

/// Prints statistics of a run or a height map.
pub(crate) fn stats(args: &Stats) -> Result<(), Failure> {
    let (opened, limits) = (open(&args.from, &args.reading)?, args.reading.limits());
    let options = TerrainOptions { channel_area_m2: args.channel_area, ..TerrainOptions::default() };
    let stats = store::stats(&opened, &options, &limits).map_err(|e| report::run(&e))?;
    if let Some(folder) = &args.plots {
        std::fs::create_dir_all(folder)
            .map_err(|e| Failure::Failed(report::plain(&format!("cannot make `{}`: {e}", folder.display()), None)))?;
        let name = args.from.file_stem().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let files = store::plots(&opened, &options, &name, folder, &limits).map_err(|e| report::run(&e))?;
        files.iter().for_each(|f| print::note(&format!("wrote {}", f.display())));
    }
    if args.json {
        return print::line(&format!("{stats:#}"));
    }
    if args.csv {
        return print::line(store::stats_csv(&stats).trim_end());
    }
    let g = &opened.world.grid;
    print::line(&format!(
        "{}: {} x {} cells of {}",
        opened.file.display(),
        g.width,
        g.height,
        print::cell(g.cell_x_m, g.cell_y_m)
    ))?;
    table(&stats, 1)
}

/// Nested tables as indented lines.
fn table(value: &Value, depth: usize) -> Result<(), Failure> {
    for (key, v) in value.as_object().into_iter().flatten() {
        let pad = "  ".repeat(depth);
        match v {
            Value::Object(_) => {
                print::line(&format!("{pad}{key}"))?;
                table(v, depth + 1)?;
            }
            Value::Array(items) if items.iter().any(Value::is_object) => {
                print::line(&format!("{pad}{key}"))?;
                rows(items, &"  ".repeat(depth + 1))?;
            }
            Value::Array(items) if items.len() > PAIR => {
                print::line(&format!("{pad}{key}"))?;
                let of = |name: &str| value[name].as_f64();
                let (first, each) = of("lowest_m").zip(of("bin_m")).unwrap_or((0.0, 1.0));
                numbers(items, &"  ".repeat(depth + 1), first, each)?;
            }
            other => print::line(&format!("{pad}{key:<28} {}", plain(other)))?,
        }
    }
    Ok(())
}

/// Longest list that stands on the line of its name.
const PAIR: usize = 3;

/// Numbers on a line of a longer list.
const ON_A_LINE: usize = 8;

/// A list of things of one kind: a line each under the names of their values.
fn rows(items: &[Value], pad: &str) -> Result<(), Failure> {
    let names: Vec<&String> = items.first().and_then(Value::as_object).into_iter().flatten().map(|(k, _)| k).collect();
    let cells: Vec<Vec<String>> =
        items.iter().map(|item| names.iter().map(|name| plain(&item[name.as_str()])).collect()).collect();
    let width = |column: usize, name: &str| cells.iter().map(|row| row[column].len()).fold(name.len(), usize::max);
    let widths: Vec<usize> = names.iter().enumerate().map(|(i, name)| width(i, name)).collect();
    let line = |row: &mut dyn Iterator<Item = &str>| {
        let padded: Vec<String> = row.zip(&widths).map(|(text, &w)| format!("{text:>w$}")).collect();
        print::line(&format!("{pad}{}", padded.join("  ")))
    };
    line(&mut names.iter().map(|n| n.as_str()))?;
    cells.iter().try_for_each(|row| line(&mut row.iter().map(String::as_str)))
}

/// A list of numbers in lines, each after what its first number belongs to: `first` for the first of the list, and `each` more for
/// every other. Lines of zeros at both ends are left out.
fn numbers(items: &[Value], pad: &str, first: f64, each: f64) -> Result<(), Failure> {
    let of: Vec<f64> = items.iter().map(|v| v.as_f64().unwrap_or(f64::NAN)).collect();
    let shares = of.iter().all(|x| (0.0..=1.0).contains(x));
    let texts: Vec<String> = of.iter().map(|&x| if shares { format!("{x:.4}") } else { short(x) }).collect();
    let width = texts.iter().map(String::len).fold(0, usize::max);
    let lines: Vec<usize> = (0..of.len()).step_by(ON_A_LINE).collect();
    let has = |i: &usize| of[*i..].iter().take(ON_A_LINE).any(|x| *x != 0.0);
    let Some((from, to)) = lines.iter().position(has).zip(lines.iter().rposition(has)) else {
        return print::line(&format!("{pad}all 0"));
    };
    for &i in &lines[from..=to] {
        let line: Vec<String> = texts[i..].iter().take(ON_A_LINE).map(|t| format!("{t:>width$}")).collect();
        print::line(&format!("{pad}{:>7}:  {}", first + each * i as f64, line.join("  ")))?;
    }
    Ok(())
}

/// A value for people.
fn plain(value: &Value) -> String {
    match value {
        Value::Null => "unknown".to_owned(),
        Value::Number(n) if n.is_f64() => short(n.as_f64().unwrap_or(f64::NAN)),
        Value::Array(items) => items.iter().map(plain).collect::<Vec<_>>().join(", "),
        other => other.to_string(),
    }
}

/// Five significant digits.
fn short(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let places = 4 - x.abs().log10().floor() as i32;
    if (0..=9).contains(&places) { format!("{x:.0$}", places as usize) } else { format!("{x:.4e}") }
}

/// Measures how fast this machine works.
pub(crate) fn measure(args: &Bench) -> Result<(), Failure> {
    let engine = args.engine.options()?.unwrap_or_default();
    let auto = engine.choice == EngineChoice::Auto;
    if engine.choice != EngineChoice::Cpu {
        match gpu::run(&gpu_options(args, engine)) {
            Ok(r) => return print_gpu(args, &r),
            Err(e) if auto && args.what.0.is_some() && e.is_refusal() => {
                print::note(&format!("note: {e}; the processor is measured"));
            }
            Err(e) => return Err(report::run(&e)),
        }
    }
    let Measured(Some(what)) = args.what else {
        let help = "measure hydraulic, thermal or reef, or add --engine gpu";
        return Err(report::usage("the island as a whole is measured on graphics cards only", help));
    };
    let threads = args.threads.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
    let options = cpu::BenchOptions {
        what,
        size: args.size.map_or(what.usual_size(), |n| n as usize),
        threads,
        isa: args.isa,
        classic: args.classic,
        seconds: args.seconds,
    };
    let r = cpu::run(&options).map_err(|e| report::usage(&e.worded(&CommandLine), "see `eyot bench --help`"))?;
    if args.json {
        let json = serde_json::to_value(&r).map_err(|e| Failure::Failed(report::plain(&e.to_string(), None)))?;
        return print::line(&format!("{json:#}"));
    }
    if let Some(c) = &r.community {
        let (side, individuals) = (r.size, c.colonies + c.algae);
        print::line(&format!("{}, {side} x {side} m, {} threads", r.what, r.threads))?;
        return print::line(&format!(
            "  {:>10.3} ms a month with {} colonies and {} algae (best of {}; median {:.3} ms)\n  {:>10.2} million individuals/s",
            1e3 * c.seconds_per_month,
            c.colonies,
            c.algae,
            r.samples,
            1e3 * r.seconds_per_step_median,
            1e-6 * individuals as f64 / c.seconds_per_month
        ));
    }
    if let Some(b) = &r.bodies {
        print::line(&format!("{}, {} x {} m, {} threads", r.what, r.size, r.size, r.threads))?;
        return print::line(&format!(
            "  {:>10.1} ms for {} bodies with {} triangles (best of {}; median {:.1} ms)\n  {:>10.1} ms for those that changed in a month (median)\n  {:>10.2} million triangles/s",
            1e3 * b.seconds_per_plot,
            b.colonies,
            b.triangles,
            r.samples,
            1e3 * r.seconds_per_step_median,
            1e3 * b.seconds_per_month,
            1e-6 * b.triangles_per_second
        ));
    }
    print::line(&format!("{}, {} x {} cells, {} threads, {}", r.what, r.size, r.size, r.threads, r.isa))?;
    print::line(&format!(
        "  {:>10.3} ms a step (best of {}; median {:.3} ms)",
        1e3 * r.seconds_per_step,
        r.samples,
        1e3 * r.seconds_per_step_median
    ))?;
    print::line(&format!(
        "  {:>10.0} million cell-steps/s (median {:.0})",
        1e-6 * r.cell_steps_per_second,
        1e-6 * r.cell_steps_per_second_median
    ))?;
    if let Some(d) = &r.drift {
        print::line(&format!(
            "  {:>10.3} ms a step between turns of the plates, and {:.3} ms for which the world stops at a turn (medians, {} turns); a step of \
             plates alone takes {:.3} ms",
            1e3 * d.seconds_between_turns,
            1e3 * d.seconds_of_turn,
            d.turns,
            1e3 * d.seconds_of_plates
        ))?;
    }
    let moved = r.bytes_moved_per_cell_step.map_or_else(|| "not known how many".to_owned(), |n| n.to_string());
    print::line(&format!(
        "  {:>10.1} bytes held per cell, {moved} bytes read and written per cell and step",
        r.bytes_per_cell
    ))
}

fn gpu_options(args: &Bench, engine: EngineOptions) -> gpu::GpuBenchOptions {
    gpu::GpuBenchOptions {
        what: args.what.0,
        size: args.size.map_or(512, |n| n as usize),
        classic: args.classic,
        seconds: args.seconds,
        most_passes: args.passes.map_or(0, usize::from),
        engine,
    }
}

fn print_gpu(args: &Bench, r: &gpu::GpuBenchReport) -> Result<(), Failure> {
    if args.json {
        let json = serde_json::to_value(r).map_err(|e| Failure::Failed(report::plain(&e.to_string(), None)))?;
        return print::line(&format!("{json:#}"));
    }
    print::line(&format!("{}, {} x {} cells, {}", r.what, r.size, r.size, r.adapter))?;
    if args.what.0.is_none() {
        let phases: Vec<String> = r.phases.iter().map(|p| format!("{} {}", p.steps, p.name)).collect();
        print::line(&format!("  steps of the recipe `island` that were timed: {}", phases.join(", ")))?;
        match &r.whole {
            Some(w) => print::line(&format!(
                "  {:>10.3} s for all {} steps, of which the card's own time is {:.3} s",
                w.seconds, w.steps, w.card_seconds
            ))?,
            None => print::line(&format!(
                "  too few seconds for all {} steps; give more with --seconds",
                gpu::ISLAND_STEPS
            ))?,
        }
    }
    print::line(&format!(
        "  {:>10.3} ms a step, of which the card's own time is {:.3} ms",
        1e3 * r.seconds_per_step,
        1e3 * r.card_seconds_per_step
    ))?;
    print::line(&format!("  {:>10.0} million cell-steps/s", 1e-6 * r.cell_steps_per_second))?;
    print::line(&format!(
        "  {:>10.2} dispatches a step, {:.0} steps a submission",
        r.dispatches_per_step, r.steps_per_submission
    ))?;
    print::line(&format!(
        "  {:>10.1} bytes moved per cell and step; a copy moves {:.1} GB/s, so this is {:.0} % of the bound",
        r.bytes_per_cell_step,
        1e-9 * r.copy_bandwidth,
        1e2 * r.share_of_bandwidth
    ))
}

pub(crate) fn open(path: &Path, reading: &Reading) -> Result<store::Opened, Failure> {
    let options = ReadOptions { bare_numbers: true, ..reading.options() };
    let opened = store::open_with(path, &options, &reading.limits()).map_err(|e| report::run(&e))?;
    opened.notes.iter().for_each(|n| print::note(&format!("note: {}", n.worded(&CommandLine))));
    Ok(opened)
}
