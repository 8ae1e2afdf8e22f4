//! Pictures on their way back from the card.

use eyot_gpu::{Gpu, Reading, Result};
use std::pin::Pin;
use std::task::{Context, Poll};
use wgpu::BufferUsages;

/// What becomes of rows of pixels.
type Make<T> = Box<dyn Fn(&[u8]) -> T + Send>;

/// A picture, or another thing made of pixels, on its way back from the card: a future, or something to look at with
/// [`Shot::is_ready`].
pub struct Shot<T> {
    bytes: Reading,
    /// Bytes of a row as it arrives, and without its padding.
    rows: [usize; 2],
    make: Make<T>,
}

impl<T> Shot<T> {
    /// Begins to read a texture of `texel` bytes a pixel; `make` gets its rows without padding.
    pub(crate) fn new(
        gpu: &Gpu,
        texture: &wgpu::Texture,
        texel: u32,
        make: impl Fn(&[u8]) -> T + Send + 'static,
    ) -> Result<Self> {
        let row = texture.width() * texel;
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let usage = BufferUsages::COPY_DST | BufferUsages::MAP_READ;
        let staging = gpu.buffer("picture", u64::from(padded) * u64::from(texture.height()), usage)?;
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &staging, layout },
            texture.size(),
        );
        gpu.queue().submit([encoder.finish()]);
        let bytes = gpu.read_mapped(staging);
        Ok(Self { bytes, rows: [padded as usize, row as usize], make: Box::new(make) })
    }

    /// True once it is there. Does not wait.
    ///
    /// # Errors
    /// If the device was lost.
    pub fn is_ready(&self) -> Result<bool> {
        self.bytes.is_ready()
    }

    /// The picture; waits for it if need be.
    ///
    /// # Errors
    /// If the device was lost, and in a browser, which does not wait, if it is not there yet.
    pub fn take(self, gpu: &Gpu) -> Result<T> {
        gpu.complete(self)
    }
}

impl<T> Future for Shot<T> {
    type Output = Result<T>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        let [padded, row] = self.rows;
        Pin::new(&mut self.bytes).poll(context).map_ok(|bytes| {
            let packed: Vec<u8> = bytes.chunks_exact(padded).flat_map(|line| &line[..row]).copied().collect();
            (self.make)(&packed)
        })
    }
}
