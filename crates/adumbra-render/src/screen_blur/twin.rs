//! The blur on the CPU: the same passes on pictures in memory.

use adumbra_shaders::layout::{BlurParams, Frame};

use super::settings::{BlurKind, BlurPass, BlurSettings, BlurWeights};

/// What the camera sees, as the G-buffer holds it; row 0 at the top.
pub struct Surfaces<'a> {
    /// The frame's uniform.
    pub frame: Frame,
    /// Stored depth, 0 where nothing is.
    pub depth: &'a [f32],
    /// World normals, zero where nothing is.
    pub normal: &'a [[f32; 3]],
}

/// Blurs a factor as the GPU does. Cost: as many operations as the GPU's, on one thread.
pub fn blur(settings: &BlurSettings, factor: &[f32], surfaces: &Surfaces<'_>) -> Vec<f32> {
    let frame = [surfaces.frame.size[0], surfaces.frame.size[1]];
    let mut picture = factor.to_vec();
    for step in settings.steps() {
        let twin = Twin { params: settings.params(step, frame), from: &picture, whole: factor, surfaces };
        let [_, half] = step.is_half(settings);
        let [width, height] = if half { settings.size(frame) } else { frame };
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| [x as i32, y as i32]));
        picture = texels.map(|texel| twin.answer(step.pass, texel)).collect();
    }
    picture
}

/// What a blur spoils: pixels that it changes by more than 0.02 though no pixel within reach on their own surface has another factor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bleeding {
    /// Lit pixels made darker: a halo about shade on another surface.
    pub halo: u32,
    /// Shadowed pixels made lighter: a gap between an object and its shadow.
    pub gap: u32,
    /// The largest change of such a pixel.
    pub largest: f32,
}

/// Counts what a blur of `factor`, which is 0 or 1 but for soft borders, has spoilt. A pixel's own surface is what lies within five
/// pixels' width of its plane and faces about the same way; `reach` is how far the blur sees, pixels. Cost: `reach²` a pixel.
pub fn bleeding(factor: &[f32], blurred: &[f32], surfaces: &Surfaces<'_>, reach: u32) -> Bleeding {
    const TOLERANCE_PIXELS: f64 = 5.0;
    let frame = [surfaces.frame.size[0], surfaces.frame.size[1]];
    let settings = BlurSettings {
        kind: BlurKind::WithinSurfaces { tolerance_pixels: TOLERANCE_PIXELS },
        samples: 8,
        sigma_pixels: 1.0,
        separable: false,
        weights: BlurWeights::Table,
        pairs: false,
        half: false,
    };
    let step = settings.steps()[0];
    let twin = Twin { params: settings.params(step, frame), from: factor, whole: factor, surfaces };
    let size = twin.size();
    let reach = reach as i32;
    let mut found = Bleeding::default();
    for (at, (&before, &after)) in factor.iter().zip(blurred).enumerate() {
        let change = (before - after).abs();
        let texel = [at as i32 % size[0], at as i32 / size[0]];
        if change <= 0.0 || !(before == 0.0 || before == 1.0) || twin.surface(texel).is_none() {
            continue;
        }
        let around = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [x, y]));
        let around = around.map(|d| add(texel, d)).filter(|&other| twin.is_inside(other));
        let own_border = around
            .filter(|&other| factor[index(other, size)] != before)
            .any(|other| twin.share(texel, other, 1.0) > 0.0);
        if !own_border {
            found.largest = found.largest.max(change);
            if change > 0.02 {
                *(if before == 1.0 { &mut found.halo } else { &mut found.gap }) += 1;
            }
        }
    }
    found
}

struct Twin<'a> {
    params: BlurParams,
    from: &'a [f32],
    whole: &'a [f32],
    surfaces: &'a Surfaces<'a>,
}

impl Twin<'_> {
    fn answer(&self, pass: BlurPass, texel: [i32; 2]) -> f32 {
        let side = self.params.counts[0] as i32;
        let square = || (-side..=side).flat_map(|y| (-side..=side).map(move |x| [x, y]));
        let table = |d: i32| self.params.taps.0[d.unsigned_abs() as usize][0];
        let gauss = |d: f32| (-0.5 * (d / self.params.shape[0]).powi(2)).exp();
        match pass {
            BlurPass::Dilate => {
                let radius = self.params.counts[3] as i32;
                self.line(radius).map(|(_, d)| self.at(add(texel, d))).fold(f32::INFINITY, f32::min)
            }
            BlurPass::HalfDown => self.half_down(texel),
            BlurPass::HalfUp => self.half_up(texel),
            BlurPass::HalfDownEdges => self.half_down_edges(texel),
            BlurPass::HalfUpEdges => self.half_up_edges(texel),
            BlurPass::LineTable => self.blind(texel, self.line(side).map(|(i, d)| (table(i), d)), false),
            BlurPass::LinePairs => self.blind(texel, self.line(side).map(|(i, d)| (table(i), d)), false),
            BlurPass::LineShader => {
                self.blind(texel, self.line(side).map(|(i, d)| (gauss(i as f32), d)), true)
            }
            BlurPass::SquareTable => {
                self.blind(texel, square().map(|d| (table(d[0]) * table(d[1]), d)), false)
            }
            BlurPass::SquareShader => {
                let length = |d: [i32; 2]| (d[0] as f32).hypot(d[1] as f32);
                self.blind(texel, square().map(|d| (gauss(length(d)), d)), true)
            }
            BlurPass::LineEdges => self.seeing(texel, self.line(side).map(|(i, d)| (table(i), d))),
            BlurPass::SquareEdges => self.seeing(texel, square().map(|d| (table(d[0]) * table(d[1]), d))),
        }
    }

    /// Distances of a line with the steps to them.
    fn line(&self, side: i32) -> impl Iterator<Item = (i32, [i32; 2])> {
        let along_y = self.params.counts[2] == 1;
        (-side..=side).map(move |i| (i, if along_y { [0, i] } else { [i, 0] }))
    }

    fn blind(&self, texel: [i32; 2], taps: impl Iterator<Item = (f32, [i32; 2])>, normalise: bool) -> f32 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (weight, step) in taps {
            sum += weight * self.at(add(texel, step));
            weights += weight;
        }
        if normalise { sum / weights } else { sum }
    }

    fn seeing(&self, texel: [i32; 2], taps: impl Iterator<Item = (f32, [i32; 2])>) -> f32 {
        let scale = self.params.counts[1] as i32;
        let pixel = |t: [i32; 2]| t.map(|c| c * scale);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (weight, step) in taps {
            let other = add(texel, step);
            let share = match step {
                [0, 0] => 1.0,
                _ if !self.is_inside(other) => 0.0,
                _ => self.share(pixel(texel), pixel(other), 1.0),
            };
            if share > 0.0 {
                sum += weight * share * self.at(other);
                weights += weight * share;
            }
        }
        sum / weights
    }

    fn half_down(&self, [x, y]: [i32; 2]) -> f32 {
        let of = |dx, dy| self.at_of([2 * x + dx, 2 * y + dy], self.frame_size());
        0.25 * (of(0, 0) + of(1, 0) + of(0, 1) + of(1, 1))
    }

    fn half_down_edges(&self, [x, y]: [i32; 2]) -> f32 {
        let first = [2 * x, 2 * y];
        let (mut sum, mut weights) = (0.0, 0.0);
        for step in CORNERS {
            let other = add(first, step);
            let inside = (0..2).all(|a| other[a] < self.frame_size()[a]);
            let weight = match step {
                [0, 0] => 1.0,
                _ if inside => self.share(first, other, 2.0),
                _ => 0.0,
            };
            sum += weight * self.at_of(other, self.frame_size());
            weights += weight;
        }
        sum / weights
    }

    fn half_up(&self, texel: [i32; 2]) -> f32 {
        self.between(texel).map(|(other, weight)| weight * self.at(other)).sum()
    }

    fn half_up_edges(&self, texel: [i32; 2]) -> f32 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (other, linear) in self.between(texel) {
            let clamped = clamp(other, self.size());
            let weight = linear * self.share(texel, clamped.map(|c| 2 * c), 2.0);
            sum += weight * self.at(other);
            weights += weight;
        }
        if weights > 0.01 { sum / weights } else { self.whole[index(texel, self.frame_size())] }
    }

    /// The four texels about a pixel of twice the size, with their linear weights.
    fn between(&self, [x, y]: [i32; 2]) -> impl Iterator<Item = ([i32; 2], f32)> {
        let at = [0.5 * (x as f32 - 0.5), 0.5 * (y as f32 - 0.5)];
        let first = at.map(f32::floor);
        CORNERS.into_iter().map(move |step| {
            let part = |a: usize| {
                let t = at[a] - first[a];
                if step[a] == 1 { t } else { 1.0 - t }
            };
            (add(first.map(|c| c as i32), step), part(0) * part(1))
        })
    }

    /// `blur_same_surface` of two pixels, 0 where either is sky.
    fn share(&self, pixel: [i32; 2], other: [i32; 2], tolerance: f32) -> f32 {
        let (Some(a), Some(b)) = (self.surface(pixel), self.surface(other)) else { return 0.0 };
        let f = &self.surfaces.frame;
        let length = |v: [f32; 4]| dot([v[0], v[1], v[2]], [v[0], v[1], v[2]]).sqrt();
        let pixel_world = 2.0 * (a.view_depth * length(f.ray_y) + length(f.origin_y)) / f.size[1] as f32;
        let between = std::array::from_fn(|i| b.p_relative[i] - a.p_relative[i]);
        let off = dot(a.normal, between).abs().max(dot(b.normal, between).abs());
        let cosine = dot(a.normal, b.normal).max(0.0);
        (1.0 - off / (tolerance * self.params.shape[1] * pixel_world)).max(0.0) * cosine.powi(8)
    }

    fn surface(&self, pixel: [i32; 2]) -> Option<Surface> {
        let f = &self.surfaces.frame;
        let at = index(pixel, self.frame_size());
        let depth = self.surfaces.depth[at];
        if depth == 0.0 {
            return None;
        }
        let k = f.depth_to_z;
        let z = (k[0] + k[1] * depth) / (k[2] + k[3] * depth);
        let uv: [f32; 2] = std::array::from_fn(|a| (pixel[a] as f32 + 0.5) / f.size[a] as f32);
        let ndc = [2.0 * uv[0] - 1.0, 1.0 - 2.0 * uv[1]];
        let p_relative = std::array::from_fn(|i| {
            let origin = f.origin[i] + ndc[0] * f.origin_x[i] + ndc[1] * f.origin_y[i];
            origin + z * (f.ray[i] + ndc[0] * f.ray_x[i] + ndc[1] * f.ray_y[i])
        });
        let n = self.surfaces.normal[at];
        let length = dot(n, n).sqrt();
        Some(Surface { p_relative, normal: n.map(|c| c / length), view_depth: z })
    }

    fn at(&self, texel: [i32; 2]) -> f32 {
        self.at_of(texel, self.size())
    }

    fn at_of(&self, texel: [i32; 2], size: [i32; 2]) -> f32 {
        self.from[index(clamp(texel, size), size)]
    }

    fn is_inside(&self, texel: [i32; 2]) -> bool {
        clamp(texel, self.size()) == texel
    }

    fn size(&self) -> [i32; 2] {
        [self.params.size[0] as i32, self.params.size[1] as i32]
    }

    fn frame_size(&self) -> [i32; 2] {
        [self.params.size[2] as i32, self.params.size[3] as i32]
    }
}

const CORNERS: [[i32; 2]; 4] = [[0, 0], [1, 0], [0, 1], [1, 1]];

struct Surface {
    p_relative: [f32; 3],
    normal: [f32; 3],
    view_depth: f32,
}

fn add(a: [i32; 2], b: [i32; 2]) -> [i32; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

fn clamp(texel: [i32; 2], size: [i32; 2]) -> [i32; 2] {
    std::array::from_fn(|a| texel[a].clamp(0, size[a] - 1))
}

fn index([x, y]: [i32; 2], size: [i32; 2]) -> usize {
    (y * size[0] + x) as usize
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
