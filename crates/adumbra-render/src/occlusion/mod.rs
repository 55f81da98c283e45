//! Ambient occlusion on the screen: one chain of passes for every estimator, so that they differ in nothing else.
//!
//! depth → view depth (at half size, if asked) → normals, from the G-buffer or made of depth → an [`Estimator`] → the frame before, where
//! it is still valid → filter → full size. The result is ambient visibility, 1 = unoccluded, for the light of the sky alone, never the
//! sun's. Source of `issao` and its filter: Qiu, Li, Wu, Shi, Zhang, *Improved Screen Space Ambient Occlusion*, Chinese Journal of
//! Computers 37(3), 2014.
//!
//! Departures from its filter: two lines stand for the square unless that is asked for, and differences of depth are taken
//! from the centre's own surface, drawn on to the tap (`depth=plane`), not from the centre's depth (`depth=plain`): what is
//! left of the noise is then less, the more so the sharper depth is judged.
//!
//! The frames before are known by the camera's way alone. What moves in the scene is met by what was seen in its plane, or
//! begins anew; what it uncovers begins anew. But what it occluded was seen then as it is seen now: the occlusion that it
//! leaves behind on surfaces that stand still fades over the frames that count.
//!
//! [`crate::Renderer`] runs the passes in its frames. An engine runs them in its own, on its own device, depth and normals:
//!
//! ```no_run
//! use adumbra::{camera::Camera, scene::Bounds};
//! use adumbra_render::occlusion::{Estimator, OcclusionInput, OcclusionPasses, OcclusionSettings};
//! use adumbra_render::{Gpu, frame::frame};
//!
//! # fn engine(device: wgpu::Device, queue: wgpu::Queue, camera: Camera, bounds: Bounds, number: u32,
//! #     depth: wgpu::TextureView, normal: wgpu::TextureView) {
//! // Once: pipelines, for a radius of half a metre.
//! let gpu = Gpu::sharing(&device, &queue);
//! let settings = OcclusionSettings { reuse: true, ..OcclusionSettings::new(Estimator::Issao, 0.5) };
//! let mut occlusion = OcclusionPasses::new(&gpu, settings);
//!
//! // Each frame: the camera, a depth texture, and world normals in any float format; without any, `Normals::Depth`
//! // makes them, and whatever texture stands in for them is not read. Depth is reversed, 1 near and 0 where nothing
//! // is; of another projection, overwrite `frame.depth_to_z`: view depth is (k.x + k.y d) / (k.z + k.w d).
//! let frame = frame(&camera, &bounds, [0.0, 1.0, 0.0], number);
//! let input = OcclusionInput { frame: &frame, depth: &depth, normal: &normal };
//! occlusion.prepare(&gpu, &frame);
//! let mut encoder = device.create_command_encoder(&Default::default());
//! occlusion.encode_surfaces(&gpu, &mut encoder, &input);
//! occlusion.encode_estimate(&gpu, &mut encoder, &input);
//! occlusion.encode_history(&gpu, &mut encoder, &input);
//! occlusion.encode_filter(&gpu, &mut encoder, &input);
//! queue.submit([encoder.finish()]);
//!
//! // Its red channel multiplies the light of the sky: 1 = unoccluded. Green is view depth.
//! if let Some(ambient) = occlusion.result() {
//!     shade(&ambient.view);
//! }
//! // After a cut to another camera, what is known of the frames before is of no use.
//! occlusion.forget();
//! # }
//! # fn shade(_: &wgpu::TextureView) {}
//! ```

mod ambient;
mod estimator;
mod history;
mod parameters;
mod passes;
mod pictures;
mod settings;
mod spec;
mod taps;
pub mod twin;

pub use ambient::{AmbientSource, GivenAmbient};
pub use estimator::{Estimator, MAX_PARAMETERS, Search, ShapeParameter};
pub use parameters::{OCCLUSIONS, occlusion_options, occlusion_parameters};
pub use passes::{AMBIENT_FORMAT, OcclusionInput, OcclusionPasses};
pub use settings::{DEFAULT_RADIUS_SHARE, Filter, Normals, OcclusionSettings};
pub use spec::{TracedSettings, change, describe};
pub use taps::taps;
