//! Draws a scene with baked and real-time shadows on any wgpu adapter, without a window.
//!
//! [`Gpu`] → [`Renderer`] (a scene on the device) → [`Renderer::draw`] with a [`Prepared`] technique → read back. A frame is
//! G-buffer → the technique's depth passes → what it builds of them → its look-up into the shadow factor → its passes on the
//! screen → composite.
//! One polarity: visibility, 1 = unoccluded. Depth conventions stand in [`adumbra_shaders::layout`].
//!
//! ```no_run
//! use adumbra_render::{Answer, Baked, Gpu, GpuOptions, Renderer, SceneOptions, Shot, build};
//!
//! # fn draw(scene: adumbra::scene::Scene, camera: adumbra::camera::Camera) -> adumbra_render::Result<()> {
//! let mut renderer = Renderer::new(Gpu::request(&GpuOptions::default())?, &scene, SceneOptions::default())?;
//! let technique = build(renderer.gpu(), &"none".parse()?, Baked::default())?;
//! let mut technique = renderer.prepare(technique)?;
//! let shot = Shot { camera, towards_sun: [0.0, 1.0, 0.0], number: 0 };
//! let times = renderer.draw(&shot, &mut technique, Answer::Visibility)?;
//! println!("{} ms of shadows", times.shadow());
//! let rgba = renderer.read_picture()?;
//! # Ok(()) }
//! ```

pub mod composite;
mod error;
pub mod frame;
pub mod gpu;
pub mod hybrid;
pub mod layers;
pub mod maps;
pub mod movers;
pub mod occlusion;
pub mod octahedral;
pub mod readback;
mod renderer;
pub mod scene;
pub mod screen_blur;
pub mod technique;
mod timing;
pub mod voxel;
pub mod voxel_csm;

pub use error::{RenderError, Result};
pub use gpu::{Gpu, GpuOptions};
pub use renderer::{Prepared, Renderer, Shot, SurfaceImage, SurfacePoint};
pub use scene::SceneOptions;
pub use technique::{Answer, Baked, Given, TECHNIQUES, TechniqueSpec, build, parameters};
pub use timing::{FrameTimes, Stage};
pub use wgpu::Features;
