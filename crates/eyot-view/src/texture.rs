//! Textures that fail with an error instead of a fault.

use eyot_gpu::{Gpu, Result};
use wgpu::{TextureFormat, TextureUsages};

/// What a texture is.
pub(crate) struct Kind {
    pub(crate) what: &'static str,
    pub(crate) size: [u32; 2],
    pub(crate) mips: u32,
    pub(crate) samples: u32,
    pub(crate) format: TextureFormat,
    pub(crate) usage: TextureUsages,
}

impl Kind {
    pub(crate) fn new(what: &'static str, size: [u32; 2], format: TextureFormat, usage: TextureUsages) -> Self {
        Self { what, size, mips: 1, samples: 1, format, usage }
    }

    /// Makes the texture.
    ///
    /// # Errors
    /// If it is larger than the device allows, or there is no memory for it.
    pub(crate) fn make(&self, gpu: &Gpu) -> Result<wgpu::Texture> {
        let descriptor = wgpu::TextureDescriptor {
            label: Some(self.what),
            size: extent(self.size),
            mip_level_count: self.mips,
            sample_count: self.samples,
            dimension: wgpu::TextureDimension::D2,
            format: self.format,
            usage: self.usage,
            view_formats: &[],
        };
        gpu.texture(self.what, &descriptor)
    }
}

pub(crate) fn extent([width, height]: [u32; 2]) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers: 1 }
}

/// Mip levels down to one texel.
pub(crate) fn mip_count([width, height]: [u32; 2]) -> u32 {
    32 - width.max(height).leading_zeros()
}

/// A view of one mip level.
pub(crate) fn mip(texture: &wgpu::Texture, level: u32) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        base_mip_level: level,
        mip_level_count: Some(1),
        ..Default::default()
    })
}

/// Writes a whole texture from rows of bytes.
pub(crate) fn write(gpu: &Gpu, texture: &wgpu::Texture, bytes: &[u8]) {
    let (size, rows) = (texture.size(), texture.height() as usize);
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some((bytes.len() / rows) as u32),
        rows_per_image: Some(texture.height()),
    };
    gpu.queue().write_texture(texture.as_image_copy(), bytes, layout, size);
}
