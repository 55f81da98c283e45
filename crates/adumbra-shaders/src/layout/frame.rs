//! Data that all passes share for a frame: camera, materials and queried points.

use crate::gpu_struct;

gpu_struct! {
    /// Coefficients that convert a stored depth d to view depth z, measured along [`Frame::forward`]: `z =
    /// (numerator + numerator_slope · d) / (denominator + denominator_slope · d)`.
    pub struct DepthToZ {
        /// Numerator at d = 0.
        pub numerator: f32,
        /// Coefficient of d in the numerator; zero for perspective.
        pub numerator_slope: f32,
        /// Denominator at d = 0.
        pub denominator: f32,
        /// Coefficient of d in the denominator; zero for orthographic cameras only.
        pub denominator_slope: f32,
    }
}

impl DepthToZ {
    /// Converts a stored depth to view depth exactly as the shaders do.
    pub fn view_depth(&self, depth: f32) -> f32 {
        (self.numerator + self.numerator_slope * depth) / (self.denominator + self.denominator_slope * depth)
    }

    /// Whether the camera is perspective.
    pub fn is_perspective(&self) -> bool {
        self.denominator_slope != 0.0
    }
}

gpu_struct! {
    /// A camera's frame, for all passes that draw or read the scene.
    ///
    /// Depth convention of cameras: reversed, 1 at the near plane, 0 at infinity (perspective) or at the far
    /// plane (orthographic). 0 also means that no surface is visible.
    ///
    /// The visible point of pixel (x, y) at view depth z, with `ndc` from -1 to 1 and y up, is
    /// `p_relative = origin + ndc.x·origin_x + ndc.y·origin_y + z·(ray + ndc.x·ray_x + ndc.y·ray_y)`.
    pub struct Frame {
        /// Transform from relative position to clip space.
        pub clip_from_relative: [[f32; 4]; 4],
        /// Ray origin at the picture's centre; zero for a perspective camera whose anchor is its eye.
        pub origin: [f32; 3],
        /// Change of the ray origin over half a picture width to the right; zero for perspective.
        pub origin_x: [f32; 3],
        /// Change of the ray origin over half a picture height upwards; zero for perspective.
        pub origin_y: [f32; 3],
        /// Direction of the central ray, which is forward.
        pub ray: [f32; 3],
        /// Change of the ray direction over half a picture width to the right; zero for orthographic.
        pub ray_x: [f32; 3],
        /// Change of the ray direction over half a picture height upwards; zero for orthographic.
        pub ray_y: [f32; 3],
        /// Conversion from stored depth to view depth.
        pub depth_to_z: DepthToZ,
        /// World position that relative positions are measured from, usually the eye, rounded to floats. No
        /// shader needs it, because all relative values were computed in doubles.
        pub anchor_world: [f32; 3],
        /// Rounding remainder of [`Frame::anchor_world`].
        pub anchor_rest_world: [f32; 3],
        /// Unit vector towards the sun.
        pub towards_sun: [f32; 3],
        /// Unit vector along which view depth is measured.
        pub forward: [f32; 3],
        /// Width and height of the frame, in pixels.
        pub size: [u32; 2],
        /// Frame number.
        pub number: u32,
    }
}

gpu_struct! {
    /// Bias applied to a look-up's receiver, in texels: see `adumbra::Bias`.
    pub struct ReceiverBias {
        /// Constant offset along the light.
        pub constant_texels: f32,
        /// Offset along the light per unit of slope, the tangent of the angle between normal and light.
        pub slope_texels: f32,
        /// Offset along the normal.
        pub normal_offset_texels: f32,
        /// Factor of all three offsets for the filter's width; 1 for baked voxels.
        pub width_factor: f32,
    }
}

gpu_struct! {
    /// A query point, for the pass that evaluates lists of points.
    pub struct PointQuery {
        /// Relative position.
        pub p_relative: [f32; 3],
        /// Distance along the camera's forward direction.
        pub view_depth: f32,
        /// Unit normal, or zero if there is none.
        pub normal: [f32; 3],
        /// Pixel at which the point appears, for techniques that vary per pixel.
        pub pixel: [u32; 2],
    }
}

gpu_struct! {
    /// Material of a triangle.
    pub struct MaterialParams {
        /// Linear colour factor, 0 to 1.
        pub base_color: [f32; 3],
        /// Alpha factor, 0 to 1.
        pub alpha: f32,
        /// Smallest alpha that counts as opaque.
        pub alpha_cutoff: f32,
    }
}
