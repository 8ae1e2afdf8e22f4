//! Graphics adapters: which there are, and what they are good for.

use wgpu::{DeviceType, Features};

/// What kind of hardware an adapter is, the best kind first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum AdapterKind {
    /// A card with memory of its own.
    Discrete,
    /// Part of the processor, whose memory it shares.
    Integrated,
    /// Hardware that a virtual machine shows.
    Virtual,
    /// Nobody knows. Browsers do not tell.
    Other,
    /// A program on the processor: right, but slower than the CPU engine.
    Software,
}

impl AdapterKind {
    /// One word for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Discrete => "discrete",
            Self::Integrated => "integrated",
            Self::Virtual => "virtual",
            Self::Other => "other",
            Self::Software => "software",
        }
    }
}

impl From<DeviceType> for AdapterKind {
    fn from(t: DeviceType) -> Self {
        match t {
            DeviceType::DiscreteGpu => Self::Discrete,
            DeviceType::IntegratedGpu => Self::Integrated,
            DeviceType::VirtualGpu => Self::Virtual,
            DeviceType::Other => Self::Other,
            DeviceType::Cpu => Self::Software,
        }
    }
}

/// What an adapter is and can do, or a device that was opened on it.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct AdapterReport {
    /// Its name. Browsers may give none.
    pub name: String,
    /// Its kind.
    pub kind: AdapterKind,
    /// The interface to it: `Vulkan`, `Metal`, `Dx12`, `Gl` or `BrowserWebGpu`.
    pub backend: String,
    /// Name of the driver.
    pub driver: String,
    /// Version of the driver.
    pub driver_info: String,
    /// Number of the maker.
    pub vendor: u32,
    /// Number of the model.
    pub device: u32,
    /// Largest buffer, bytes.
    pub max_buffer: u64,
    /// Largest buffer that a shader can read, bytes.
    pub max_binding: u64,
    /// Memory of a workgroup, bytes.
    pub workgroup_memory: u32,
    /// Largest side of a picture, pixels.
    pub max_picture: u32,
    /// Whether it measures its own time.
    pub timestamps: bool,
    /// Whether its driver gives compiled pipelines away.
    pub pipeline_cache: bool,
}

impl AdapterReport {
    pub(crate) fn new(info: wgpu::AdapterInfo, limits: &wgpu::Limits, features: Features) -> Self {
        Self {
            kind: info.device_type.into(),
            backend: format!("{:?}", info.backend),
            name: info.name,
            driver: info.driver,
            driver_info: info.driver_info,
            vendor: info.vendor,
            device: info.device,
            max_buffer: limits.max_buffer_size,
            max_binding: limits.max_storage_buffer_binding_size,
            workgroup_memory: limits.max_compute_workgroup_storage_size,
            max_picture: limits.max_texture_dimension_2d,
            timestamps: features.contains(Features::TIMESTAMP_QUERY),
            pipeline_cache: features.contains(Features::PIPELINE_CACHE),
        }
    }

    fn of(adapter: &wgpu::Adapter) -> Self {
        Self::new(adapter.get_info(), &adapter.limits(), adapter.features())
    }

    /// True for hardware, false for a software renderer, which is right but slower than the CPU engine.
    pub fn is_hardware(&self) -> bool {
        self.kind < AdapterKind::Software
    }
}

/// All adapters, the best one first. Browsers show one.
pub async fn adapters() -> Vec<AdapterReport> {
    sorted().await.into_iter().map(|(_, report)| report).collect()
}

/// As [`adapters`], with what opens them.
pub(crate) async fn sorted() -> Vec<(wgpu::Adapter, AdapterReport)> {
    // Those that were compiled in; OpenGL only where nothing better is there.
    for backends in [wgpu::Backends::PRIMARY, wgpu::Backends::SECONDARY] {
        let descriptor =
            wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() };
        let found = wgpu::Instance::new(descriptor).enumerate_adapters(backends).await;
        if !found.is_empty() {
            let mut all: Vec<_> = found.into_iter().map(|a| (AdapterReport::of(&a), a)).map(|(r, a)| (a, r)).collect();
            all.sort_by_key(|(_, r)| r.kind);
            return all;
        }
    }
    Vec::new()
}

/// Which adapter to open.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Choice {
    /// The best one, a software renderer if there is nothing else.
    #[default]
    Best,
    /// The best one that is hardware.
    Hardware,
    /// The first one whose name contains this, in any case.
    Named(String),
}

impl Choice {
    /// The adapter of that name; without one the best, or the best that is `hardware`.
    pub fn of(name: Option<&str>, hardware: bool) -> Self {
        match name {
            Some(name) => Self::Named(name.to_owned()),
            None if hardware => Self::Hardware,
            None => Self::Best,
        }
    }

    pub(crate) fn fits(&self, adapter: &AdapterReport) -> bool {
        match self {
            Self::Best => true,
            Self::Hardware => adapter.is_hardware(),
            Self::Named(name) => adapter.name.to_lowercase().contains(&name.to_lowercase()),
        }
    }

    /// As "that ...", for people.
    pub(crate) fn wanted(&self) -> String {
        match self {
            Self::Best => "that this program can use".to_owned(),
            Self::Hardware => "that is hardware".to_owned(),
            Self::Named(name) => format!("whose name contains `{name}`"),
        }
    }
}
