//! Reads buffers and textures back from the GPU.

use std::sync::mpsc;

use wgpu::{BufferUsages, TextureFormat};

use crate::error::{RenderError, Result};
use crate::gpu::Gpu;

/// Reads all bytes of a buffer, which must have the usage `COPY_SRC`.
///
/// # Errors
/// Returns whatever error the device reports.
pub fn read_buffer(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u8>> {
    let copy = landing(gpu, buffer.size());
    let mut encoder = gpu.encoder("readback");
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    gpu.queue.submit([encoder.finish()]);
    land(gpu, &copy)
}

/// Reads one layer of one mip level of a texture, row by row without padding.
///
/// # Errors
/// Returns whatever error the device reports.
pub fn read_texture(gpu: &Gpu, texture: &wgpu::Texture, mip_level: u32, layer: u32) -> Result<Vec<u8>> {
    let (width, height) = ((texture.width() >> mip_level).max(1), (texture.height() >> mip_level).max(1));
    let aspect = if texture.format().is_depth_stencil_format() {
        wgpu::TextureAspect::DepthOnly
    } else {
        wgpu::TextureAspect::All
    };
    let row = width * bytes_per_texel(texture.format());
    let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let copy = landing(gpu, u64::from(padded) * u64::from(height));
    let mut encoder = gpu.encoder("readback");
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level,
            origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
            aspect,
        },
        wgpu::TexelCopyBufferInfo {
            buffer: &copy,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded),
                rows_per_image: None,
            },
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
    gpu.queue.submit([encoder.finish()]);
    let bytes = land(gpu, &copy)?;
    Ok(bytes.chunks_exact(padded as usize).flat_map(|line| &line[..row as usize]).copied().collect())
}

/// Reads one layer of one mip level of a texture of 32-bit floats, row by row, as [`read_texture`] does.
///
/// # Errors
/// Returns whatever error the device reports.
pub fn read_floats(gpu: &Gpu, texture: &wgpu::Texture, mip_level: u32, layer: u32) -> Result<Vec<f32>> {
    let bytes = read_texture(gpu, texture, mip_level, layer)?;
    Ok(bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect())
}

/// Reads one layer of a depth map, row by row. 32-bit depth is returned as stored, 16-bit depth as
/// `k / 65535`.
///
/// # Errors
/// Returns whatever error the device reports.
pub(crate) fn read_depth(gpu: &Gpu, texture: &wgpu::Texture, layer: u32) -> Result<Vec<f32>> {
    if texture.format() != TextureFormat::Depth16Unorm {
        return read_floats(gpu, texture, 0, layer);
    }
    let bytes = read_texture(gpu, texture, 0, layer)?;
    let depth = |b: &[u8; 2]| (f64::from(u16::from_le_bytes(*b)) / 65535.0) as f32;
    Ok(bytes.as_chunks::<2>().0.iter().map(depth).collect())
}

fn bytes_per_texel(format: TextureFormat) -> u32 {
    format.block_copy_size(None).unwrap_or(4)
}

fn landing(gpu: &Gpu, size: u64) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size,
        usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn land(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u8>> {
    let (sender, receiver) = mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver is dropped only if the wait has already failed; ignore the error.
        let _ = sender.send(result);
    });
    gpu.wait()?;
    let lost = |reason: String| RenderError::Lost { reason };
    receiver.try_recv().map_err(|e| lost(e.to_string()))?.map_err(|e| lost(e.to_string()))?;
    let bytes = buffer.get_mapped_range(..).map_err(|e| lost(e.to_string()))?.to_vec();
    Ok(bytes)
}
