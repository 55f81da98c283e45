//! Ambient occlusion on the CPU: the same passes on pictures in memory.

mod alchemy;
mod filter;
mod gtao;
mod half;
mod hbao;
mod history;
mod issao;
mod march;
mod normals;
mod ssao;

pub use filter::skipped;

use adumbra_shaders::constants::OCCLUSION_MAX_TAPS;
use adumbra_shaders::layout::{Frame, OcclusionParams, OcclusionTaps};

use super::estimator::Estimator;
use super::settings::{Normals, OcclusionSettings};
use super::taps::taps;

/// What the camera sees, as the G-buffer holds it; row 0 at the top.
pub struct Surfaces<'a> {
    /// The frame's uniform.
    pub frame: Frame,
    /// Stored depth, 0 where nothing is.
    pub depth: &'a [f32],
    /// World normals, zero where nothing is.
    pub normal: &'a [[f32; 3]],
}

/// Ambient visibility with view depth, 0 where nothing is.
pub type Ambient = [f32; 2];

/// Ambient visibility from frame to frame, as the GPU has it.
pub struct Twin {
    settings: OcclusionSettings,
    before: Option<(Frame, Vec<history::Seen>)>,
}

impl Twin {
    /// Before the first frame.
    pub fn new(settings: OcclusionSettings) -> Self {
        Self { settings, before: None }
    }

    /// Drops what is known of the frames before.
    pub fn forget(&mut self) {
        self.before = None;
    }

    /// Of the next frame. Cost: as many operations as the GPU's, on one thread.
    pub fn ambient(&mut self, surfaces: &Surfaces<'_>) -> Vec<Ambient> {
        let settings = &self.settings;
        let mut ambient = estimate(settings, surfaces);
        if settings.reuse {
            let seen = history::mean(settings, surfaces, &ambient, self.before.as_ref());
            ambient = seen.iter().map(|s| [s[0], s[1]]).collect();
            self.before = Some((surfaces.frame, seen));
        }
        let ambient = filter::filter(settings, &surfaces.frame, ambient);
        if settings.half { half::up(settings, surfaces, &ambient) } else { ambient }
    }
}

/// Ambient visibility of a first frame as the GPU has it. Cost: as many operations as the GPU's, on one thread.
pub fn ambient(settings: &OcclusionSettings, surfaces: &Surfaces<'_>) -> Vec<Ambient> {
    Twin::new(*settings).ambient(surfaces)
}

/// The estimator alone, of the size that it is estimated in.
pub fn estimate(settings: &OcclusionSettings, surfaces: &Surfaces<'_>) -> Vec<Ambient> {
    let params = settings.params(&surfaces.frame);
    let made = made_normals(settings, surfaces);
    let pass = Pass {
        view_depth: view_depth(&params, surfaces),
        taps: taps(settings),
        frame_width: if made.is_some() { params.size[0] } else { surfaces.frame.size[0] },
        normals: made.as_deref().unwrap_or(surfaces.normal),
        params,
    };
    texels([params.size[0], params.size[1]])
        .map(|texel| pass.occlude(settings, texel.map(|c| c as u32)))
        .collect()
}

/// World normals made from depth, of the size that occlusion is estimated in; none where the G-buffer's serve.
pub fn made_normals(settings: &OcclusionSettings, surfaces: &Surfaces<'_>) -> Option<Vec<[f32; 3]>> {
    (settings.normals == Normals::Depth)
        .then(|| normals::normals(&settings.params(&surfaces.frame), surfaces))
}

/// Row by row from the top.
fn texels([width, height]: [u32; 2]) -> impl Iterator<Item = [i32; 2]> {
    (0..height as i32).flat_map(move |y| (0..width as i32).map(move |x| [x, y]))
}

/// Where a texel stands among all; none beyond the picture.
fn index([width, height]: [u32; 2], [x, y]: [i32; 2]) -> Option<usize> {
    let is_inside = (0..width as i32).contains(&x) && (0..height as i32).contains(&y);
    is_inside.then(|| (y * width as i32 + x) as usize)
}

/// View depth of a stored depth; 0 where nothing is.
fn z_of(k: [f32; 4], depth: f32) -> f32 {
    if depth == 0.0 { 0.0 } else { (k[0] + k[1] * depth) / (k[2] + k[3] * depth) }
}

/// `occlusion_point` of the shaders.
fn point_of(ndc_from_texel: [f32; 4], half_view: [f32; 4], texel: [i32; 2], z: f32) -> [f32; 3] {
    let at = |a: usize| {
        let ndc = ndc_from_texel[a] * texel[a] as f32 + ndc_from_texel[a + 2];
        ndc * (half_view[a] + half_view[a + 2] * z)
    };
    [at(0), at(1), z]
}

fn view_depth(params: &OcclusionParams, surfaces: &Surfaces<'_>) -> Vec<f32> {
    let [width, height, scale, _] = params.size;
    let frame_width = surfaces.frame.size[0];
    texels([width, height])
        .map(|[x, y]| {
            let pixel = (y as u32 * scale * frame_width + x as u32 * scale) as usize;
            z_of(params.depth_to_z, surfaces.depth[pixel])
        })
        .collect()
}

/// The pass around an estimator.
struct Pass<'a> {
    params: OcclusionParams,
    taps: OcclusionTaps,
    view_depth: Vec<f32>,
    frame_width: u32,
    normals: &'a [[f32; 3]],
}

/// `OcclusionCenter` of the shaders.
struct Center {
    texel: [i32; 2],
    p: [f32; 3],
    n: [f32; 3],
    radius_world: f32,
    radius_texels: f32,
    first_tap: usize,
}

impl Pass<'_> {
    fn occlude(&self, settings: &OcclusionSettings, texel: [u32; 2]) -> Ambient {
        let z = self.z_at(texel.map(|c| c as i32)).unwrap_or(0.0);
        if z <= 0.0 {
            return [1.0, z];
        }
        let c = self.center(texel, z);
        if c.radius_texels < 0.5 {
            return [1.0, z];
        }
        let visibility = match settings.estimator {
            Estimator::Ssao => ssao::visibility(self, &c),
            Estimator::Hbao => hbao::visibility(self, &c),
            Estimator::Alchemy => alchemy::visibility(self, &c),
            Estimator::Issao => issao::visibility(self, &c, settings.term()),
            Estimator::Gtao => gtao::visibility(self, &c),
        };
        [visibility, z]
    }

    /// View depth, 0 where nothing is; none beyond the picture.
    fn z_at(&self, [x, y]: [i32; 2]) -> Option<f32> {
        let [width, height] = [self.params.size[0] as i32, self.params.size[1] as i32];
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        inside.then(|| self.view_depth[(y * width + x) as usize])
    }

    fn point(&self, texel: [i32; 2], z: f32) -> [f32; 3] {
        point_of(self.params.ndc_from_texel, self.params.half_view, texel, z)
    }

    /// Where a view-space point lies, in texels; whole numbers are centres.
    fn texel(&self, p: [f32; 3]) -> [f32; 2] {
        let o = &self.params;
        [0, 1].map(|a| {
            let ndc = p[a] / (o.half_view[a] + o.half_view[a + 2] * p[2]);
            (ndc - o.ndc_from_texel[a + 2]) / o.ndc_from_texel[a]
        })
    }

    /// From P to what is seen at a texel, in radii.
    fn reach(&self, c: &Center, texel: [i32; 2], z: f32, inverse_radius: f32) -> [f32; 3] {
        let s = self.point(texel, z);
        std::array::from_fn(|a| (s[a] - c.p[a]) * inverse_radius)
    }

    fn center(&self, texel: [u32; 2], z: f32) -> Center {
        let o = &self.params;
        let scale = o.size[3];
        let n = self.normals[(texel[1] * scale * self.frame_width + texel[0] * scale) as usize];
        let axis = |a: [f32; 4]| dot(n, [a[0], a[1], a[2]]);
        let n = [axis(o.right), axis(o.up), axis(o.forward)];
        let length = dot(n, n).sqrt();
        let texels = o.region[0] / (o.region[2] + o.region[3] * z);
        let share = (o.region[1] / texels).min(1.0);
        let place = (place(texel) + o.counts[2]) & 15;
        let texel = texel.map(|c| c as i32);
        Center {
            texel,
            p: self.point(texel, z),
            n: n.map(|c| c / length),
            radius_world: o.region[0] * share,
            radius_texels: texels * share,
            first_tap: (place * OCCLUSION_MAX_TAPS) as usize,
        }
    }
}

/// A texel's place in the tile of noise.
fn place(texel: [u32; 2]) -> u32 {
    let [x, y] = texel.map(|c| c & 3);
    let d = x ^ y;
    (d & 1) << 3 | (y & 1) << 2 | d & 2 | y >> 1
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
