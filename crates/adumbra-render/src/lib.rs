//! Draws a scene with baked and real-time shadows on any wgpu adapter, without a window.
//!
//! [`Gpu`] → [`Renderer`] (a scene on the device) → [`Renderer::draw`] with a [`Prepared`] technique → read
//! back. GPU work is timed per stage ([`FrameTimes`]):
//!
//! | stage | what happens |
//! |---|---|
//! | G-buffer | draws depth, normal and base colour of what the camera sees: [`frame`] |
//! | prepare | the [technique](technique::Technique) writes its uniforms and culled instance lists |
//! | depth | the technique draws depth from the light, and statistics of that depth |
//! | build | the technique derives from that depth what its look-ups need, such as a [hybrid map](hybrid) |
//! | look-up | its WGSL function `adumbra_shadow_factor` runs per pixel (passes/resolve.wgsl) or per listed point (passes/points.wgsl) |
//! | screen | the technique filters the factor in screen space |
//! | ambient | [ambient occlusion](occlusion), if any |
//! | composite | sun, sky, base colour, factor and ambient visibility become a picture |
//! | check | once the commands are submitted, the technique reports errors found on the device, such as a map out of room |
//!
//! Conventions:
//!
//! - Shadow factors and ambient occlusion are visibilities, 1 = unoccluded. A look-up can also return other
//!   quantities, such as a point's cascade: see [`Answer`].
//! - Camera depth is reversed: 1 is near; 0 is infinity or the far plane, and also the background. Light
//!   depth is linear: 0 is near the sun, 1 is far.
//! - Bind group 0 belongs to the pass, 1 to baked voxels, 2 to shadow maps.
//! - Lengths that affect the image come from cameras and texels, never from the size of the scene. A stray
//!   triangle far away therefore changes nothing near the camera.
//!
//! ```no_run
//! use adumbra_render::{Answer, Gpu, GpuOptions, Renderer, SceneOptions, Shot, TechniqueFiles, build};
//!
//! # fn draw(scene: adumbra_scene::Scene, camera: adumbra_scene::Camera) -> adumbra_render::Result<()> {
//! let mut renderer = Renderer::new(Gpu::request(&GpuOptions::default())?, &scene, SceneOptions::default())?;
//! let technique = build(renderer.gpu(), &"none".parse()?, TechniqueFiles::default())?;
//! let mut technique = renderer.prepare(technique)?;
//! let shot = Shot { camera, towards_sun: [0.0, 1.0, 0.0], number: 0 };
//! let times = renderer.draw(&shot, &mut technique, Answer::Visibility)?;
//! println!("{} ms of shadows", times.shadow());
//! let rgba = renderer.read_picture()?;
//! # Ok(()) }
//! ```

pub mod composite;
pub mod depth_image;
mod error;
pub mod frame;
pub mod gpu;
pub mod hybrid;
pub mod layers;
pub mod maps;
pub mod occlusion;
pub mod octahedral;
pub mod readback;
mod renderer;
pub mod scene;
pub mod screen_blur;
pub mod technique;
pub mod techniques;
mod timing;
pub mod voxel;
pub mod voxel_csm;

pub use error::{Fix, RenderError, Result};
pub use gpu::{Gpu, GpuOptions};
pub use renderer::{Prepared, Renderer, Shot, SurfaceImage, SurfacePoint};
pub use scene::SceneOptions;
pub use technique::{Answer, Given, SpecText};
pub use techniques::{
    Reads, TECHNIQUES, TechniqueEntry, TechniqueFiles, TechniqueSpec, Techniques, Truth, build,
};
pub use timing::{FrameTimes, Stage};
pub use wgpu::Features;
