//! An adapter and a device, without a window.
//!
//! No optional feature is required: [`Gpu::missing_features`] lists what this device lacks and what that
//! costs. Errors that the device reports asynchronously are kept and returned by the next [`Gpu::check`]. A
//! device that is lost, or does not respond for [`SUBMIT_TIMEOUT`], gives [`RenderError::Lost`].

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use wgpu::{Features, Limits};

use crate::error::{RenderError, Result};

/// How long a submission may take.
pub const SUBMIT_TIMEOUT: Duration = Duration::from_secs(600);

/// Optional features, used if available.
const WANTED: Features = Features::TIMESTAMP_QUERY
    .union(Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)
    .union(Features::FLOAT32_FILTERABLE)
    .union(Features::DEPTH_CLIP_CONTROL);

/// Which adapter to use, and which of its features to avoid.
#[derive(Clone, Debug, Default)]
pub struct GpuOptions {
    /// Part of the adapter's name, case-insensitive. `None` takes the first real GPU, or else a software
    /// adapter.
    pub adapter: Option<String>,
    /// Optional features not to use, as if the device lacked them.
    pub without: Features,
    /// Largest storage binding to use, bytes, if less than the device's limit.
    pub max_binding_bytes: Option<u64>,
}

/// A device with its queue. A clone refers to the same device.
#[derive(Clone)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// The device's queue.
    pub queue: wgpu::Queue,
    /// Largest storage binding that may be used, bytes.
    pub max_binding_bytes: u64,
    features: Features,
    info: wgpu::AdapterInfo,
    pending_error: Arc<Mutex<Option<RenderError>>>,
}

impl Gpu {
    /// Opens the best adapter that fits `options`: a discrete GPU, else an integrated one, else a virtual
    /// one, else a software adapter.
    ///
    /// # Errors
    /// Returns [`RenderError::NoAdapter`] if no adapter fits, [`RenderError::NoDevice`] if it gives no
    /// device.
    pub fn request(options: &GpuOptions) -> Result<Self> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        pollster::block_on(Self::request_async(&instance, None, options)).map(|(gpu, _)| gpu)
    }

    /// Opens the best adapter that can present to `surface`, as [`Gpu::request`] does, and returns the
    /// adapter too.
    ///
    /// # Errors
    /// Returns the errors of [`Gpu::request`].
    pub fn request_for(
        instance: &wgpu::Instance,
        surface: &wgpu::Surface<'_>,
        options: &GpuOptions,
    ) -> Result<(Self, wgpu::Adapter)> {
        pollster::block_on(Self::request_async(instance, Some(surface), options))
    }

    /// Wraps an engine's own device and queue. The device's errors go to the engine's own handlers, so
    /// [`Gpu::check`] never sees them.
    pub fn sharing(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self {
            max_binding_bytes: device.limits().max_storage_buffer_binding_size,
            features: WANTED.intersection(device.features()),
            info: device.adapter_info(),
            pending_error: Arc::new(Mutex::new(None)),
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
            return Err(RenderError::NoAdapter { reason: format!("requested {asked}, found {found:?}") });
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
        let pending_error = Arc::new(Mutex::new(None));
        let (lost, refused) = (pending_error.clone(), pending_error.clone());
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
        Ok((Self { device, queue, max_binding_bytes, features, info, pending_error }, adapter))
    }

    /// The adapter's name and driver, as used to label figures.
    pub fn name(&self) -> String {
        let i = &self.info;
        format!("{} ({:?}; {} {})", i.name, i.backend, i.driver, i.driver_info)
    }

    /// Whether the adapter runs in software, not on a GPU.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Whether the device has an optional feature and may use it.
    pub fn has(&self, feature: Features) -> bool {
        self.features.contains(feature)
    }

    /// Returns what this device lacks and what that costs, as messages for the user.
    pub fn missing_features(&self) -> Vec<&'static str> {
        let notes = [
            (
                Features::TIMESTAMP_QUERY | Features::TIMESTAMP_QUERY_INSIDE_ENCODERS,
                "no timestamps: times are wall times that include submission",
            ),
            (
                Features::FLOAT32_FILTERABLE,
                "no filtering of 32-bit floats: moments are interpolated in the shader, from the first mip level only",
            ),
            (
                Features::DEPTH_CLIP_CONTROL,
                "no depth clip control: casters sunward of a shadow map are kept by a closer near plane, at some cost in depth precision",
            ),
        ];
        notes.into_iter().filter(|(feature, _)| !self.has(*feature)).map(|(_, text)| text).collect()
    }

    /// Checks that no error has occurred since the last call.
    ///
    /// # Errors
    /// Returns [`RenderError::Lost`], [`RenderError::OutOfMemory`] or [`RenderError::Refused`].
    pub fn check(&self) -> Result<()> {
        let take = || self.pending_error.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(error) = take() else { return Ok(()) };
        // A lost device refuses commands before it reports the loss itself. Polling makes it report the loss.
        let polled = self.poll(wgpu::PollType::Poll).err();
        let lost = take().filter(|later| matches!(later, RenderError::Lost { .. }));
        Err(lost.or(polled).unwrap_or(error))
    }

    /// Submits `commands` and waits until they are done.
    ///
    /// # Errors
    /// Returns the errors of [`Gpu::check`].
    pub fn finish(&self, commands: wgpu::CommandBuffer) -> Result<()> {
        self.queue.submit([commands]);
        self.wait()
    }

    /// Waits until everything submitted is done.
    ///
    /// # Errors
    /// Returns the errors of [`Gpu::check`].
    pub fn wait(&self) -> Result<()> {
        let waited =
            self.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(SUBMIT_TIMEOUT) });
        match (self.check(), waited) {
            (Err(lost @ RenderError::Lost { .. }), _) | (_, Err(lost)) => Err(lost),
            (checked, Ok(())) => checked,
        }
    }

    fn poll(&self, how: wgpu::PollType) -> Result<()> {
        answered(|| self.device.poll(how))
    }

    /// Creates a uniform buffer with these bytes.
    pub fn uniform(&self, label: &str, bytes: &[u8]) -> wgpu::Buffer {
        self.buffer(label, bytes, wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST)
    }

    /// Creates a buffer with these bytes, padded with zeros to a multiple of 4 bytes. Without bytes, the
    /// buffer has four zero bytes.
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

    /// Creates a 2-D texture with one mip level.
    pub fn texture(
        &self,
        label: &str,
        [width, height]: [u32; 2],
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    }

    /// Creates an R32Float texture to load from. `texels` are row-major and match its size.
    pub(crate) fn float_texture(&self, label: &str, size: [u32; 2], texels: &[f32]) -> wgpu::Texture {
        let usage = wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_DST
            | wgpu::TextureUsages::COPY_SRC;
        let texture = self.texture(label, size, wgpu::TextureFormat::R32Float, usage);
        let rows =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * size[0]), rows_per_image: None };
        let texels = bytemuck::cast_slice(texels);
        self.queue.write_texture(texture.as_image_copy(), texels, rows, texture.size());
        texture
    }

    /// Begins a render pass that draws to one colour target, without depth.
    pub fn color_pass<'a>(
        encoder: &'a mut wgpu::CommandEncoder,
        label: &str,
        view: &wgpu::TextureView,
        load: wgpu::LoadOp<wgpu::Color>,
    ) -> wgpu::RenderPass<'a> {
        let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
        let color = wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(color)],
            ..Default::default()
        })
    }

    /// Creates a shader module from WGSL.
    pub fn shader(&self, label: &str, text: String) -> wgpu::ShaderModule {
        self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(label),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        })
    }

    /// Creates a bind group layout whose bindings are numbered in order.
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

    /// Creates a bind group whose bindings are numbered in order.
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

    /// Creates a compute pipeline with these bind group layouts.
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

    /// Creates a pipeline layout with these bind group layouts.
    pub(crate) fn pipeline_layout(
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

    /// Creates a command encoder.
    pub fn encoder(&self, label: &str) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(label) })
    }

    /// Largest side of a 2-D texture, texels.
    pub fn max_texture_side(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
    }
}

/// Turns the outcome of a poll into a result. wgpu's poll panics if the device is lost, so a panic becomes
/// [`RenderError::Lost`].
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

fn note(pending_error: &Mutex<Option<RenderError>>, error: RenderError) {
    let mut kept = pending_error.lock().unwrap_or_else(PoisonError::into_inner);
    // The first error is the cause, but the loss of the device outranks the errors that it causes.
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
    pub(crate) const DEPTH_ARRAY: BindingType =
        texture(TextureSampleType::Depth, TextureViewDimension::D2Array);
    /// `texture_2d<f32>`, loaded.
    pub(crate) const LOADED: BindingType =
        texture(TextureSampleType::Float { filterable: false }, TextureViewDimension::D2);
    /// `texture_2d_array<f32>`, loaded.
    pub(crate) const LOADED_ARRAY: BindingType =
        texture(TextureSampleType::Float { filterable: false }, TextureViewDimension::D2Array);
    /// `texture_2d<f32>`, sampled.
    pub(crate) const SAMPLED: BindingType =
        texture(TextureSampleType::Float { filterable: true }, TextureViewDimension::D2);
    /// `texture_2d_array<f32>`, sampled.
    pub(crate) const SAMPLED_ARRAY: BindingType =
        texture(TextureSampleType::Float { filterable: true }, TextureViewDimension::D2Array);
    /// `sampler`.
    pub(crate) const SAMPLER: BindingType = BindingType::Sampler(SamplerBindingType::Filtering);
    /// `sampler_comparison`.
    pub(crate) const COMPARISON: BindingType = BindingType::Sampler(SamplerBindingType::Comparison);

    /// A texture that is read, not multisampled.
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
