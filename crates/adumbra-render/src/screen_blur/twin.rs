//! The blur on the CPU: its passes on pictures in memory.

use adumbra_shaders::layout::{BlurParams, Frame};

use super::settings::{BlurKind, BlurPass, BlurSettings, BlurWeights};

/// The camera's view as the G-buffer holds it, row 0 at the top.
pub struct Surfaces<'a> {
    /// The frame's uniform.
    pub frame: Frame,
    /// Stored depth, 0 where there is no surface.
    pub depth: &'a [f32],
    /// World normals, zero where there is no surface.
    pub normal: &'a [[f32; 3]],
}

/// Blurs a factor as on the GPU. Cost: as many operations as on the GPU, on one thread.
pub fn blur(settings: &BlurSettings, factor: &[f32], surfaces: &Surfaces<'_>) -> Vec<f32> {
    let frame = surfaces.frame.size;
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

/// Errors of a blur: pixels of factor 0 or 1 that it changes by more than 0.02 although no pixel within reach
/// on their own surface has a different factor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bleeding {
    /// Lit pixels that became darker: a halo around a shadow on another surface.
    pub halo: u32,
    /// Shadowed pixels that became lighter: a gap between an object and its shadow.
    pub gap: u32,
    /// The largest change of a pixel without such a neighbour, also if it is 0.02 or less.
    pub largest: f32,
}

/// Counts the errors of a blur of `factor`, which is 0 or 1 except at soft borders. A pixel's own surface is
/// everything within five pixels' width of its plane that faces about the same way. `reach` is the blur's
/// reach in pixels. Cost: `reach²` per pixel.
pub fn bleeding(factor: &[f32], blurred: &[f32], surfaces: &Surfaces<'_>, reach: u32) -> Bleeding {
    const TOLERANCE_PIXELS: f64 = 5.0;
    let frame = surfaces.frame.size;
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
        let side = self.params.taps_per_side as i32;
        let square = || (-side..=side).flat_map(|y| (-side..=side).map(move |x| [x, y]));
        let table = |d: i32| self.params.taps.0[d.unsigned_abs() as usize].weight;
        let gauss = |d: f32| (-0.5 * (d / self.params.sigma_texels).powi(2)).exp();
        match pass {
            BlurPass::Dilate => {
                let radius = self.params.dilation_texels as i32;
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

    /// The texels of a line: distance, and offset in x and y.
    fn line(&self, side: i32) -> impl Iterator<Item = (i32, [i32; 2])> {
        let along_y = self.params.axis == 1;
        (-side..=side).map(move |i| (i, if along_y { [0, i] } else { [i, 0] }))
    }

    fn blind(&self, texel: [i32; 2], taps: impl Iterator<Item = (f32, [i32; 2])>, normalise: bool) -> f32 {
        let (sum, weights) = weighted(taps.map(|(weight, step)| (weight, self.at(add(texel, step)))));
        if normalise { sum / weights } else { sum }
    }

    fn seeing(&self, texel: [i32; 2], taps: impl Iterator<Item = (f32, [i32; 2])>) -> f32 {
        let scale = self.params.pixels_per_texel as i32;
        let pixel = |t: [i32; 2]| t.map(|c| c * scale);
        let (sum, weights) = weighted(taps.map(|(weight, step)| {
            let other = add(texel, step);
            let share = match step {
                [0, 0] => 1.0,
                _ if !self.is_inside(other) => 0.0,
                _ => self.share(pixel(texel), pixel(other), 1.0),
            };
            (weight * share, self.at(other))
        }));
        sum / weights
    }

    fn half_down(&self, [x, y]: [i32; 2]) -> f32 {
        let of = |dx, dy| self.at_of([2 * x + dx, 2 * y + dy], self.frame_size());
        0.25 * (of(0, 0) + of(1, 0) + of(0, 1) + of(1, 1))
    }

    fn half_down_edges(&self, [x, y]: [i32; 2]) -> f32 {
        let first = [2 * x, 2 * y];
        let (sum, weights) = weighted(CORNERS.into_iter().map(|step| {
            let other = add(first, step);
            let inside = (0..2).all(|a| other[a] < self.frame_size()[a]);
            let weight = match step {
                [0, 0] => 1.0,
                _ if inside => self.share(first, other, 2.0),
                _ => 0.0,
            };
            (weight, self.at_of(other, self.frame_size()))
        }));
        sum / weights
    }

    fn half_up(&self, texel: [i32; 2]) -> f32 {
        self.between(texel).map(|(other, weight)| weight * self.at(other)).sum()
    }

    fn half_up_edges(&self, texel: [i32; 2]) -> f32 {
        let (sum, weights) = weighted(self.between(texel).map(|(other, linear)| {
            let clamped = clamp(other, self.size());
            (linear * self.share(texel, clamped.map(|c| 2 * c), 2.0), self.at(other))
        }));
        if weights > 0.01 { sum / weights } else { self.whole[index(texel, self.frame_size())] }
    }

    /// The four texels around a pixel of twice the size, with their linear weights.
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

    /// Twin of `adumbra_blur_same_surface` for two pixels. 0 if either is sky.
    fn share(&self, pixel: [i32; 2], other: [i32; 2], tolerance: f32) -> f32 {
        let (Some(a), Some(b)) = (self.surface(pixel), self.surface(other)) else { return 0.0 };
        let f = &self.surfaces.frame;
        let length = |v: [f32; 3]| dot(v, v).sqrt();
        let pixel_world = 2.0 * (a.view_depth * length(f.ray_y) + length(f.origin_y)) / f.size[1] as f32;
        let between = std::array::from_fn(|i| b.p_relative[i] - a.p_relative[i]);
        let off = dot(a.normal, between).abs().max(dot(b.normal, between).abs());
        let cosine = dot(a.normal, b.normal).max(0.0);
        (1.0 - off / (tolerance * self.params.tolerance_pixels * pixel_world)).max(0.0) * cosine.powi(8)
    }

    fn surface(&self, pixel: [i32; 2]) -> Option<Surface> {
        let f = &self.surfaces.frame;
        let at = index(pixel, self.frame_size());
        let depth = self.surfaces.depth[at];
        if depth == 0.0 {
            return None;
        }
        let z = f.depth_to_z.view_depth(depth);
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
        self.params.size.map(|s| s as i32)
    }

    fn frame_size(&self) -> [i32; 2] {
        self.params.frame_size.map(|s| s as i32)
    }
}

const CORNERS: [[i32; 2]; 4] = [[0, 0], [1, 0], [0, 1], [1, 1]];

struct Surface {
    p_relative: [f32; 3],
    normal: [f32; 3],
    view_depth: f32,
}

/// The sum of weighted values, and the sum of the weights.
fn weighted(taps: impl Iterator<Item = (f32, f32)>) -> (f32, f32) {
    taps.fold((0.0, 0.0), |(sum, weights), (weight, value)| (sum + weight * value, weights + weight))
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
