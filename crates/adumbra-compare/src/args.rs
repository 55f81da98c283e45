//! Command-line options that need the renderer, shared by the verbs of several programs.

use std::path::{Path, PathBuf};

use adumbra_program::args::parse_bytes;
use adumbra_render::{Features, GpuOptions};
use clap::ValueEnum;

use crate::truth::Cache;

/// The device that draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DeviceArg {
    /// The GPU, or the CPU if there is no adapter; rays alone (`--diff`, and a plain picture with `--truth`)
    /// run on the CPU
    Auto,
    /// The GPU; an error if there is none
    Gpu,
    /// The CPU
    Cpu,
}

/// Features that a device may lack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum WithoutArg {
    /// GPU timestamps
    Timestamps,
    /// Filtering of 32-bit float textures
    Float32Filtering,
    /// Depth clip control
    DepthClipControl,
}

/// The options that select the device.
#[derive(clap::Args)]
pub struct DeviceArgs {
    /// Device to draw on
    #[arg(long, value_enum, default_value = "auto")]
    pub device: DeviceArg,
    /// Part of the GPU adapter's name [default: the first real GPU, or else a software adapter]
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Behave as if the device lacked this feature; may be repeated
    #[arg(long, value_enum, value_name = "FEATURE")]
    pub without: Vec<WithoutArg>,
}

impl DeviceArgs {
    /// Whether the CPU may draw if there is no adapter: the device is `auto` and no adapter was named.
    pub fn may_fall_back(&self) -> bool {
        self.device == DeviceArg::Auto && self.adapter.is_none()
    }

    /// Whether a GPU is required.
    pub fn wants_gpu(&self) -> bool {
        self.device == DeviceArg::Gpu || self.device == DeviceArg::Auto && self.adapter.is_some()
    }

    /// Returns the requested adapter and the excluded features as command-line arguments.
    pub fn words(&self) -> Vec<String> {
        let adapter = self.adapter.iter().map(|name| format!("--adapter '{}'", name.replace('\'', "'\\''")));
        let without = self.without.iter().filter_map(ValueEnum::to_possible_value);
        adapter.chain(without.map(|v| format!("--without {}", v.get_name()))).collect()
    }

    /// Returns the GPU options with the requested adapter and without the excluded features.
    pub fn gpu_options(&self) -> GpuOptions {
        let without = self.without.iter().map(|w| match w {
            WithoutArg::Timestamps => Features::TIMESTAMP_QUERY | Features::TIMESTAMP_QUERY_INSIDE_ENCODERS,
            WithoutArg::Float32Filtering => Features::FLOAT32_FILTERABLE,
            WithoutArg::DepthClipControl => Features::DEPTH_CLIP_CONTROL,
        });
        GpuOptions {
            adapter: self.adapter.clone(),
            without: without.fold(Features::empty(), |a, b| a | b),
            ..GpuOptions::default()
        }
    }
}

/// The options of the cache of ray-traced truth.
#[derive(clap::Args)]
pub struct CacheArgs {
    /// Folder that caches ray-traced truth between runs [default: truth-cache in the output folder]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Size limit of that cache, such as 200MiB or 4GiB; the least recently used entries are removed first
    /// [default: 1GiB]
    #[arg(long, value_name = "SIZE", value_parser = parse_bytes)]
    cache_limit: Option<u64>,
}

impl CacheArgs {
    /// Returns the cache for a verb that writes into the folder `output`.
    pub fn cache(&self, output: &Path) -> Cache {
        let folder = self.cache.clone().unwrap_or_else(|| output.join("truth-cache"));
        Cache::in_folder(folder, self.cache_limit.unwrap_or(Cache::DEFAULT_LIMIT_BYTES))
    }
}

/// The resolution of a shadow file that is baked as needed.
#[derive(clap::Args)]
pub struct ResolutionArgs {
    /// Resolution of a shadow file that is baked as needed: texels on the longest side
    #[arg(long, value_name = "N", default_value = "16384")]
    pub resolution: u64,
}

/// The truth that techniques are compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ReferenceArg {
    /// The sun's disc for pcss, voxel:soft and the screen-space blurs, its centre for all others
    Technique,
    /// The sun's centre: hard shadows
    Hard,
    /// The sun's disc: soft shadows
    Disc,
}
