//! Graphics cards as engines of runs.

use eyot_core::Limits;
use eyot_core::engine::{DeviceError, Engine};
use eyot_core::remedy;
use eyot_gpu::{Choice, Gpu, GpuEngine, GpuError, Options, blocking};
use eyot_session::{EngineChoice, EngineOptions, OpenEngine, Opened};
use std::any::Any;
use std::io::Write;
use std::path::PathBuf;

/// Opens the processor or a graphics card.
#[derive(Clone, Copy, Debug, Default)]
pub struct Engines;

impl eyot_session::Engines for Engines {
    fn open(&self, options: &EngineOptions, limits: Limits) -> Result<Opened, DeviceError> {
        if options.choice == EngineChoice::Cpu {
            return Ok(Opened::processor(limits, None));
        }
        // The card's own time stands in the run's report.
        match card(options, Options::default().limits(limits).timed(true)) {
            Ok(engine) => Ok(Opened { engine: Box::new(Card(engine)), warning: None }),
            Err(e) if options.choice == EngineChoice::Auto => {
                Ok(Opened::processor(limits, Some(remedy![e, "; the processor works instead"])))
            }
            Err(e) => Err(e.into()),
        }
    }
}

/// An engine on a device that is open already, such as a window's or a browser's, for hosts that must not wait for it: sessions answer
/// [`Status::Waiting`](eyot_session::Status::Waiting) meanwhile.
///
/// # Errors
/// If the device fails.
pub fn polled(gpu: Gpu, limits: Limits) -> Result<Opened, DeviceError> {
    let engine = GpuEngine::new(gpu, Options::default().limits(limits).timed(true).polled(true), None)?;
    Ok(Opened { engine: Box::new(Card(engine)), warning: None })
}

/// The engine of a session that works on a graphics card, so that a window can draw the layers that lie there
/// (`eyot::view::Scene::follow`); `None` if the processor works.
pub fn on_card(engine: &dyn OpenEngine) -> Option<&GpuEngine> {
    engine.as_any()?.downcast_ref::<Card>().map(|card| &card.0)
}

struct Card(GpuEngine);

impl OpenEngine for Card {
    fn engine(&self) -> &dyn Engine {
        &self.0
    }

    fn engine_mut(&mut self) -> &mut dyn Engine {
        &mut self.0
    }

    fn device_seconds(&self) -> f64 {
        self.0.work().card_s
    }

    fn keep(&self) {
        keep_pipelines(&self.0);
    }

    fn as_any(&self) -> Option<&dyn Any> {
        Some(self)
    }

    fn lose_device(&mut self) {
        self.0.gpu().destroy();
    }
}

/// The adapter that these options mean.
pub fn adapter(options: &EngineOptions) -> Choice {
    Choice::of(options.adapter.as_deref(), options.choice == EngineChoice::Auto)
}

/// A graphics card, with the pipelines that earlier processes compiled.
///
/// # Errors
/// If there is no such adapter, or it cannot run the engine.
pub fn card(options: &EngineOptions, how: Options) -> Result<GpuEngine, GpuError> {
    let gpu = blocking::open(&adapter(options))?;
    let cache = cache_file(&gpu).and_then(|path| std::fs::read(path).ok());
    GpuEngine::new(gpu, how, cache.as_deref())
}

/// Keeps compiled pipelines for the next process. Only a convenience: what cannot be kept is compiled again.
pub fn keep_pipelines(e: &GpuEngine) {
    let (Some(path), Some(data)) = (cache_file(e.gpu()), e.cache_data()) else { return };
    if std::fs::metadata(&path).is_ok_and(|m| m.len() == data.len() as u64) {
        return;
    }
    let Some(folder) = path.parent() else { return };
    if std::fs::create_dir_all(folder).is_ok() {
        let fail = |source| eyot_io::Error::Io { path: path.clone(), action: "write", source };
        // Nobody misses it but the next run's first second.
        let _ = eyot_io::write_atomically(&path, |w| w.write_all(&data).map_err(fail));
    }
}

/// Where compiled pipelines of an adapter lie; a driver's cache is of no use to another one.
fn cache_file(gpu: &Gpu) -> Option<PathBuf> {
    let from = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let folder = from("XDG_CACHE_HOME")
        .or_else(|| from("LOCALAPPDATA"))
        .or_else(|| from("HOME").map(|home| home.join(".cache")))?;
    let info = &gpu.report;
    let name: String = format!("{}-{}-{:x}-{:x}", info.driver, info.driver_info, info.vendor, info.device)
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' })
        .collect();
    Some(folder.join("eyot").join(format!("pipelines-{name}.bin")))
}
