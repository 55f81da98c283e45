//! Ambient occlusion on the CPU: the passes on pictures in memory.

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
use adumbra_shaders::layout::{DepthToZ, Frame, OcclusionParams, OcclusionTaps, OcclusionView};

use super::estimator::Estimator;
use super::settings::{Normals, OcclusionSettings};
use super::taps::taps;

/// The camera's view as the G-buffer holds it, row 0 at the top.
pub struct Surfaces<'a> {
    /// The frame's uniform.
    pub frame: Frame,
    /// Stored depth, 0 where there is no surface.
    pub depth: &'a [f32],
    /// World normals, zero where there is no surface.
    pub normal: &'a [[f32; 3]],
}

/// Ambient visibility and view depth. The depth is 0 where there is no surface.
pub type Ambient = [f32; 2];

/// Ambient visibility over successive frames, matching the GPU.
pub struct Twin {
    settings: OcclusionSettings,
    before: Option<(Frame, Vec<history::HistoryTexel>)>,
}

impl Twin {
    /// Creates a twin without history.
    pub fn new(settings: OcclusionSettings) -> Self {
        Self { settings, before: None }
    }

    /// Discards the history of previous frames.
    pub fn forget(&mut self) {
        self.before = None;
    }

    /// Computes the next frame. Cost: as many operations as on the GPU, on one thread.
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

/// Computes ambient visibility of a first frame, matching the GPU. Cost: as many operations as on the GPU, on
/// one thread.
pub fn ambient(settings: &OcclusionSettings, surfaces: &Surfaces<'_>) -> Vec<Ambient> {
    Twin::new(*settings).ambient(surfaces)
}

/// Runs only the estimator, at the size in which occlusion is estimated.
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
    texels(params.size).map(|texel| pass.occlude(settings, texel.map(|c| c as u32))).collect()
}

/// World normals computed from depth, at the size in which occlusion is estimated. `None` if the G-buffer's
/// are used.
pub fn made_normals(settings: &OcclusionSettings, surfaces: &Surfaces<'_>) -> Option<Vec<[f32; 3]>> {
    (settings.normals == Normals::Depth)
        .then(|| normals::normals(&settings.params(&surfaces.frame), surfaces))
}

/// All texels, row by row from the top.
fn texels([width, height]: [u32; 2]) -> impl Iterator<Item = [i32; 2]> {
    (0..height as i32).flat_map(move |y| (0..width as i32).map(move |x| [x, y]))
}

/// Index of a texel. `None` outside the picture.
fn index([width, height]: [u32; 2], [x, y]: [i32; 2]) -> Option<usize> {
    let is_inside = (0..width as i32).contains(&x) && (0..height as i32).contains(&y);
    is_inside.then(|| (y * width as i32 + x) as usize)
}

/// View depth of a stored depth, 0 where there is no surface.
fn z_of(depth_to_z: DepthToZ, depth: f32) -> f32 {
    if depth == 0.0 { 0.0 } else { depth_to_z.view_depth(depth) }
}

/// Twin of `adumbra_occlusion_ndc`.
fn ndc(view: &OcclusionView, texel: [i32; 2]) -> [f32; 2] {
    [0, 1].map(|a| view.ndc_per_texel[a] * texel[a] as f32 + view.ndc_of_first_texel[a])
}

/// Twin of `adumbra_occlusion_point`.
fn point_at(view: &OcclusionView, texel: [i32; 2], z: f32) -> [f32; 3] {
    let ndc = ndc(view, texel);
    let at = |a: usize| ndc[a] * (view.half_view[a] + view.half_view_per_depth[a] * z);
    [at(0), at(1), z]
}

/// Twin of `adumbra_occlusion_texel`.
fn texel_of(view: &OcclusionView, p: [f32; 3]) -> [f32; 2] {
    [0, 1].map(|a| {
        let ndc = p[a] / (view.half_view[a] + view.half_view_per_depth[a] * p[2]);
        (ndc - view.ndc_of_first_texel[a]) / view.ndc_per_texel[a]
    })
}

/// Twin of `adumbra_occlusion_direction`.
fn direction(view: &OcclusionView, n_world: [f32; 3]) -> [f32; 3] {
    [dot(n_world, view.right), dot(n_world, view.up), dot(n_world, view.forward)]
}

fn view_depth(params: &OcclusionParams, surfaces: &Surfaces<'_>) -> Vec<f32> {
    let scale = params.pixels_per_texel;
    let frame_width = surfaces.frame.size[0];
    texels(params.size)
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

/// Twin of `OcclusionCenter`.
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

    /// View depth, 0 where there is no surface. `None` outside the picture.
    fn z_at(&self, [x, y]: [i32; 2]) -> Option<f32> {
        let [width, height] = self.params.size.map(|s| s as i32);
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        inside.then(|| self.view_depth[(y * width + x) as usize])
    }

    fn point(&self, texel: [i32; 2], z: f32) -> [f32; 3] {
        point_at(&self.params.view, texel, z)
    }

    /// Position of a view-space point in texels. Whole numbers are texel centres.
    fn texel(&self, p: [f32; 3]) -> [f32; 2] {
        texel_of(&self.params.view, p)
    }

    /// Vector from the centre to the surface at a texel, in radii.
    fn reach(&self, c: &Center, texel: [i32; 2], z: f32, inverse_radius: f32) -> [f32; 3] {
        let s = self.point(texel, z);
        std::array::from_fn(|a| (s[a] - c.p[a]) * inverse_radius)
    }

    fn center(&self, texel: [u32; 2], z: f32) -> Center {
        let o = &self.params;
        let scale = o.pixels_per_normal;
        let n = self.normals[(texel[1] * scale * self.frame_width + texel[0] * scale) as usize];
        let n = direction(&o.view, n);
        let length = dot(n, n).sqrt();
        let texels = o.radius_world / (o.texel_world + o.texel_world_per_depth * z);
        let share = (o.max_radius_texels / texels).min(1.0);
        let tile = (tile_index(texel) + o.tile_offset) & 15;
        let texel = texel.map(|c| c as i32);
        Center {
            texel,
            p: self.point(texel, z),
            n: n.map(|c| c / length),
            radius_world: o.radius_world * share,
            radius_texels: texels * share,
            first_tap: (tile * OCCLUSION_MAX_TAPS) as usize,
        }
    }
}

/// A texel's index in the noise tile: twin of `adumbra_occlusion_tile_index`.
fn tile_index(texel: [u32; 2]) -> u32 {
    let [x, y] = texel.map(|c| c & 3);
    let d = x ^ y;
    (d & 1) << 3 | (y & 1) << 2 | d & 2 | y >> 1
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
