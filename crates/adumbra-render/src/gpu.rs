//! An adapter and a device, without a window.
//!
//! Nothing optional is required: [`Gpu::left_out`] says what this device lacks and what that costs. Errors that the device
//! reports on its own are kept, and given by the next [`Gpu::check`]; a device that is lost, or does not answer for
//! [`PATIENCE`], is [`RenderError::Lost`].

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use wgpu::{Features, Limits};

use crate::error::{RenderError, Result};

/// How long a submission may take.
pub const PATIENCE: Duration = Duration::from_secs(600);

/// Optional features that are used where they are there.
const WANTED: Features = Features::TIMESTAMP_QUERY
    .union(Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)
    .union(Features::FLOAT32_FILTERABLE)
    .union(Features::DEPTH_CLIP_CONTROL);

/// Which adapter, and what of it is not to be used.
#[derive(Clone, Debug, Default)]
pub struct GpuOptions {
    /// Part of the adapter's name, in any case; none takes the first real GPU, or else a software adapter.
    pub adapter: Option<String>,
    /// Optional features to do without, as if the device lacked them.
    pub without: Features,
    /// Largest storage binding in bytes to use, if less than the device's.
    pub max_binding_bytes: Option<u64>,
}

/// A device with its queue; a clone is the same device.
#[derive(Clone)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Largest storage binding that may be used, bytes.
    pub max_binding_bytes: u64,
    features: Features,
    info: wgpu::AdapterInfo,
    trouble: Arc<Mutex<Option<RenderError>>>,
}

impl Gpu {
    /// The best adapter that fits `options`: discrete before integrated before virtual before software.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`], [`RenderError::NoDevice`].
    pub fn request(options: &GpuOptions) -> Result<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        pollster::block_on(Self::request_async(&instance, None, options)).map(|(gpu, _)| gpu)
    }

    /// As [`Gpu::request`], of the adapters that can show pictures on `surface`, with the adapter.
    ///
    /// # Errors
    /// As [`Gpu::request`].
    pub fn request_for(
        instance: &wgpu::Instance,
        surface: &wgpu::Surface<'_>,
        options: &GpuOptions,
    ) -> Result<(Self, wgpu::Adapter)> {
        pollster::block_on(Self::request_async(instance, Some(surface), options))
    }

    /// An engine's own device and queue. What the device reports stays the engine's to hear: [`Gpu::check`] knows nothing of it.
    pub fn sharing(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self {
            max_binding_bytes: device.limits().max_storage_buffer_binding_size,
            features: WANTED.intersection(device.features()),
            info: device.adapter_info(),
            trouble: Arc::new(Mutex::new(None)),
            device: device.clone(),
            queue: queue.clone(),
        }
    }

    async fn request_async(
        instance: &wgpu::Instance,
        surface: Option<&wgpu::Surface<'_>>,
        options: &GpuOptions,
    ) -> Result<(Self, wgpu::Adapter)> {
        let mut adapters = instance.enumerate_adapters(wgpu::Backends::PRIMARY).await;
        let found: Vec<String> = adapters.iter().map(|a| a.get_info().name).collect();
        if let Some(part) = &options.adapter {
            let part = part.to_lowercase();
            adapters.retain(|a| a.get_info().name.to_lowercase().contains(&part));
        }
        adapters.retain(|a| surface.is_none_or(|s| a.is_surface_supported(s)));
        adapters.sort_by_key(|a| match a.get_info().device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu => 2,
            wgpu::DeviceType::Cpu => 3,
            wgpu::DeviceType::Other => 4,
        });
        let Some(adapter) = adapters.into_iter().next() else {
            let asked = options.adapter.as_ref().map_or_else(|| "any".to_owned(), |n| format!("{n:?}"));
            return Err(RenderError::NoAdapter { reason: format!("asked for {asked}, found {found:?}") });
        };
        let info = adapter.get_info();
        let features = WANTED.difference(options.without).intersection(adapter.features());
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("adumbra"),
            required_features: features,
            required_limits: Limits { ..adapter.limits() },
            ..Default::default()
        };
        let (device, queue) = adapter
            .request_device(&descriptor)
            .await
            .map_err(|e| RenderError::NoDevice { adapter: info.name.clone(), reason: e.to_string() })?;
        let trouble = Arc::new(Mutex::new(None));
        let (lost, refused) = (trouble.clone(), trouble.clone());
        device.set_device_lost_callback(move |reason, message| {
            note(&lost, RenderError::Lost { reason: format!("{reason:?}: {message}") });
        });
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let reason = error.to_string();
            note(
                &refused,
                match error {
                    wgpu::Error::OutOfMemory { .. } => RenderError::OutOfMemory { reason },
                    _ => RenderError::Refused { reason },
                },
            );
        }));
        let most = device.limits().max_storage_buffer_binding_size;
        let max_binding_bytes = options.max_binding_bytes.map_or(most, |b| b.min(most));
        Ok((Self { device, queue, max_binding_bytes, features, info, trouble }, adapter))
    }

    /// The adapter's name and driver, as figures are labelled with them.
    pub fn name(&self) -> String {
        let i = &self.info;
        format!("{} ({:?}; {} {})", i.name, i.backend, i.driver, i.driver_info)
    }

    /// Whether the adapter is a program, not a GPU.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Whether the device has an optional feature, and may use it.
    pub fn has(&self, feature: Features) -> bool {
        self.features.contains(feature)
    }

    /// What this device lacks, and what that costs: sentences for the user.
    pub fn left_out(&self) -> Vec<&'static str> {
        let notes = [
            (
                Features::TIMESTAMP_QUERY | Features::TIMESTAMP_QUERY_INSIDE_ENCODERS,
                "no timestamps: times are wall times, with the submission in them",
            ),
            (
                Features::FLOAT32_FILTERABLE,
                "no filtering of 32-bit floats: moments are blended in the shader, from the first mip level",
            ),
            (
                Features::DEPTH_CLIP_CONTROL,
                "no depth clip control: casters sunward of a shadow map are kept by a nearer near plane, at some depth precision",
            ),
        ];
        notes.into_iter().filter(|(feature, _)| !self.has(*feature)).map(|(_, text)| text).collect()
    }

    /// What went wrong since the last call, if anything did.
    ///
    /// # Errors
    /// [`RenderError::Lost`], [`RenderError::OutOfMemory`], [`RenderError::Refused`].
    pub fn check(&self) -> Result<()> {
        let take = || self.trouble.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(error) = take() else { return Ok(()) };
        // What a lost device refuses is refused before the loss itself is told; polling tells it.
        let polled = self.poll(wgpu::PollType::Poll).err();
        let told = take().filter(|later| matches!(later, RenderError::Lost { .. }));
        Err(told.or(polled).unwrap_or(error))
    }

    /// Submits and waits until it is done.
    ///
    /// # Errors
    /// As [`Gpu::check`].
    pub fn finish(&self, commands: wgpu::CommandBuffer) -> Result<()> {
        self.queue.submit([commands]);
        self.wait()
    }

    /// Waits until everything submitted is done.
    ///
    /// # Errors
    /// As [`Gpu::check`].
    pub fn wait(&self) -> Result<()> {
        let waited = self.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(PATIENCE) });
        match (self.check(), waited) {
            (Err(lost @ RenderError::Lost { .. }), _) | (_, Err(lost)) => Err(lost),
            (checked, Ok(())) => checked,
        }
    }

    fn poll(&self, how: wgpu::PollType) -> Result<()> {
        answered(|| self.device.poll(how))
    }

    /// A uniform buffer with these bytes.
    pub fn uniform(&self, label: &str, bytes: &[u8]) -> wgpu::Buffer {
        self.buffer(label, bytes, wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST)
    }

    /// A buffer with these bytes; an empty one gets four zero bytes.
    pub fn buffer(&self, label: &str, bytes: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: (bytes.len() as u64).next_multiple_of(4).max(4),
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        if bytes.len().is_multiple_of(4) {
            self.queue.write_buffer(&buffer, 0, bytes);
        } else {
            let mut padded = bytes.to_vec();
            padded.resize(bytes.len().next_multiple_of(4), 0);
            self.queue.write_buffer(&buffer, 0, &padded);
        }
        buffer
    }

    /// A texture of 32-bit floats to load from, row by row; `texels` are as many as its size says.
    pub fn float_texture(&self, label: &str, [width, height]: [u32; 2], texels: &[f32]) -> wgpu::Texture {
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_DST
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let rows =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: None };
        self.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(texels), rows, size);
        texture
    }

    /// A shader module from WGSL.
    pub fn shader(&self, label: &str, text: String) -> wgpu::ShaderModule {
        self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(label),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        })
    }

    /// A bind group layout whose bindings are numbered in order.
    pub fn layout(
        &self,
        label: &str,
        visibility: wgpu::ShaderStages,
        bindings: &[wgpu::BindingType],
    ) -> wgpu::BindGroupLayout {
        let entries: Vec<_> = (0..)
            .zip(bindings)
            .map(|(binding, &ty)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None })
            .collect();
        self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(label),
            entries: &entries,
        })
    }

    /// A bind group whose bindings are numbered in order.
    pub fn bind(
        &self,
        label: &str,
        layout: &wgpu::BindGroupLayout,
        resources: Vec<wgpu::BindingResource<'_>>,
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(label),
            layout,
            entries: &entries,
        })
    }

    /// A compute pipeline over these groups.
    pub fn compute(
        &self,
        label: &str,
        text: String,
        entry_point: &str,
        groups: &[Option<&wgpu::BindGroupLayout>],
    ) -> wgpu::ComputePipeline {
        let module = self.shader(label, text);
        let layout = self.pipeline_layout(label, groups);
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(label),
            layout: Some(&layout),
            module: &module,
            entry_point: Some(entry_point),
            compilation_options: Default::default(),
            cache: None,
        })
    }

    /// A pipeline layout over these groups.
    pub fn pipeline_layout(
        &self,
        label: &str,
        groups: &[Option<&wgpu::BindGroupLayout>],
    ) -> wgpu::PipelineLayout {
        self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(label),
            bind_group_layouts: groups,
            immediate_size: 0,
        })
    }

    /// An encoder.
    pub fn encoder(&self, label: &str) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(label) })
    }

    /// The largest 2-D texture, texels a side.
    pub fn max_texture_side(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
    }
}

/// What a poll came to. A device that is really lost makes wgpu's own poll panic.
fn answered<T, E: std::fmt::Display>(poll: impl FnOnce() -> std::result::Result<T, E>) -> Result<()> {
    let reason = match catch_unwind(AssertUnwindSafe(poll)) {
        Ok(Ok(_)) => return Ok(()),
        Ok(Err(error)) => error.to_string(),
        Err(payload) => {
            let text = payload.downcast_ref::<String>().map(String::as_str);
            text.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("polling failed").to_owned()
        }
    };
    Err(RenderError::Lost { reason })
}

fn note(trouble: &Mutex<Option<RenderError>>, error: RenderError) {
    let mut kept = trouble.lock().unwrap_or_else(PoisonError::into_inner);
    // The first is the cause; but a lost device outweighs what followed from it.
    if kept.is_none() || matches!(error, RenderError::Lost { .. }) {
        *kept = Some(error);
    }
}

/// Binding types that the passes share.
pub mod binding {
    use wgpu::{
        BindingType, BufferBindingType, SamplerBindingType, StorageTextureAccess, TextureFormat,
        TextureSampleType, TextureViewDimension,
    };

    const fn buffer(ty: BufferBindingType) -> BindingType {
        BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
    }

    /// `var<uniform>`.
    pub const UNIFORM: BindingType = buffer(BufferBindingType::Uniform);
    /// `var<storage, read>`.
    pub const STORAGE: BindingType = buffer(BufferBindingType::Storage { read_only: true });
    /// `var<storage, read_write>`.
    pub const STORAGE_OUT: BindingType = buffer(BufferBindingType::Storage { read_only: false });
    /// `texture_depth_2d`.
    pub const DEPTH: BindingType = texture(TextureSampleType::Depth, TextureViewDimension::D2);
    /// `texture_depth_2d_array`.
    pub const DEPTH_ARRAY: BindingType = texture(TextureSampleType::Depth, TextureViewDimension::D2Array);
    /// `texture_2d<f32>`, loaded.
    pub const LOADED: BindingType =
        texture(TextureSampleType::Float { filterable: false }, TextureViewDimension::D2);
    /// `texture_2d_array<f32>`, loaded.
    pub const LOADED_ARRAY: BindingType =
        texture(TextureSampleType::Float { filterable: false }, TextureViewDimension::D2Array);
    /// `texture_2d<f32>`, sampled.
    pub const SAMPLED: BindingType =
        texture(TextureSampleType::Float { filterable: true }, TextureViewDimension::D2);
    /// `texture_2d_array<f32>`, sampled.
    pub const SAMPLED_ARRAY: BindingType =
        texture(TextureSampleType::Float { filterable: true }, TextureViewDimension::D2Array);
    /// `sampler`.
    pub const SAMPLER: BindingType = BindingType::Sampler(SamplerBindingType::Filtering);
    /// `sampler_comparison`.
    pub const COMPARISON: BindingType = BindingType::Sampler(SamplerBindingType::Comparison);

    /// Any texture that is read.
    pub const fn texture(
        sample_type: TextureSampleType,
        view_dimension: TextureViewDimension,
    ) -> BindingType {
        BindingType::Texture { sample_type, view_dimension, multisampled: false }
    }

    /// `texture_storage_2d<FORMAT, write>`.
    pub const fn written(format: TextureFormat) -> BindingType {
        BindingType::StorageTexture {
            access: StorageTextureAccess::WriteOnly,
            format,
            view_dimension: TextureViewDimension::D2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poll_that_panics_is_a_lost_device() {
        let lost = |outcome| match outcome {
            Err(RenderError::Lost { reason }) => reason,
            other => panic!("{other:?}"),
        };
        assert!(answered(|| Ok::<_, String>(7)).is_ok());
        assert_eq!(lost(answered(|| Err::<(), _>("too slow"))), "too slow");
        assert_eq!(lost(answered(|| -> std::result::Result<(), String> { panic!("gone") })), "gone");
        let reason = |n: u32| lost(answered(|| -> std::result::Result<(), String> { panic!("gone {n}") }));
        assert_eq!(reason(3), "gone 3");
    }
}
