//! Screen-space ambient occlusion. All estimators share one chain of passes, so that they differ in nothing
//! else.
//!
//! The result is ambient visibility, 1 = unoccluded. It multiplies only the sky's light, never the sun's.
//! Source of `issao` and its filter: Qiu, Li, Wu, Shi, Zhang, *Improved Screen Space Ambient Occlusion*,
//! Chinese Journal of Computers 37(3), 2014.
//!
//! | stage | pass | output | input |
//! |---|---|---|---|
//! | surfaces | `occlusion_surface` | view depth; at half size, that of every second pixel | depth |
//! | | `occlusion_normals`, with `normals=depth` | world normals | depth |
//! | estimate | `occlude`, with the file of an [`Estimator`] | visibility and view depth in one texture, because filters read both | view depth, normals, noise |
//! | history | `occlusion_history`, with `reuse=on` | the mean with previous frames, where they are still valid | the estimate, the previous history |
//! | filter | `bilateral_line` or `gauss_line` twice, `bilateral_square`, or none ([`Filter`]) | smooth visibility | the estimate or the mean |
//! | | `occlusion_up`, with `half=on` | visibility at the frame's size, upsampled along surfaces | depth, the filter's result |
//!
//! - *View space*: x right, y up, z the view depth, in world units from the eye. Estimators receive lengths
//!   divided by the radius. So a scene in other units gives the same picture if its radius is in those units
//!   too.
//! - *Noise* is one tile of 4 × 4 texels, each with its own [`taps()`], the same on GPU and CPU. The filter
//!   averages over the tile. With `reuse`, the assignment of taps to the tile's texels rotates from frame to
//!   frame.
//! - *The radius* on the screen is capped. A texel beyond the cap is evaluated with a smaller radius as a
//!   whole, so there is no discontinuity where the cap begins.
//! - *Parameters* of each estimator are in one list, with their ranges, defaults and search ranges:
//!   [`Estimator::parameters`].
//! - *[`twin`]* is the whole chain on the CPU, with one file per shader.
//!
//! Departures from the paper's filter: it runs as two lines unless `filter=square` selects the square.
//! Differences of depth are measured from the centre's surface, extrapolated to the tap (`depth=plane`),
//! instead of from the centre's depth (`depth=plain`). That leaves less noise, especially if the filter is
//! sharp in depth.
//!
//! The history follows only the camera. A pixel reuses what was seen in its plane before, or begins anew, as
//! at surfaces that a moving object uncovers. But occlusion that a moving object leaves behind on static
//! surfaces looks valid: it fades over the number of frames in the mean.
//!
//! [`crate::Renderer`] runs the passes in its frames. An engine can run them in its own, with its own device,
//! depth and normals:
//!
//! ```no_run
//! use adumbra::grid::Bounds;
//! use adumbra_render::occlusion::{Estimator, OcclusionInput, OcclusionPasses, OcclusionSettings};
//! use adumbra_render::{Gpu, frame::frame};
//! use adumbra_scene::Camera;
//!
//! # fn engine(device: wgpu::Device, queue: wgpu::Queue, camera: Camera, bounds: Bounds, number: u32,
//! #     depth: wgpu::TextureView, normal: wgpu::TextureView) {
//! // Once: pipelines, for a radius of half a metre.
//! let gpu = Gpu::sharing(&device, &queue);
//! let settings = OcclusionSettings { reuse: true, ..OcclusionSettings::new(Estimator::Issao, 0.5) };
//! let mut occlusion = OcclusionPasses::new(&gpu, settings);
//!
//! // Each frame: the camera, a depth texture, and world normals in any float format. Without normals,
//! // `Normals::Depth` computes them, and the texture passed in their place is not read. Depth is reversed:
//! // 1 near, 0 where there is no surface. For another projection, overwrite `frame.depth_to_z`: view depth
//! // is (k.x + k.y d) / (k.z + k.w d).
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
//! // After a camera cut, the history of previous frames is useless.
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
pub use passes::{OcclusionInput, OcclusionPasses};
pub use settings::{DEFAULT_RADIUS_SHARE, Filter, Normals, OcclusionSettings};
pub use spec::{AmbientSettings, TracedSettings, change, describe};
pub use taps::taps;
