//! Settings of screen-space blurs, and the passes that they require.

use adumbra_shaders::constants::MAX_BLUR_SIDE;
use adumbra_shaders::layout::{Array, BlurParams, BlurTap};

use crate::error::Result;
use crate::technique::SpecReader;

/// The technique that is blurred if none is named.
const DEFAULT_BASE: &str = "pcf/filter=2";

/// The three blur techniques.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BlurName {
    Plain,
    Dilated,
    Bilateral,
}

/// The inputs of a blur besides the factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BlurKind {
    /// No other input: the notes' blur, with its halo.
    Plain,
    /// No other input, but the shadow is dilated first: the notes' attempt to remove the halo.
    Dilated {
        /// Radius of the dilation, pixels.
        radius: u32,
    },
    /// Depth and normal: texels off the pixel's own surface do not count.
    WithinSurfaces {
        /// Largest distance of a surface from a pixel's plane, in widths of a pixel there.
        tolerance_pixels: f64,
    },
}

/// The source of the Gaussian's weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlurWeights {
    /// Computed once, on the CPU.
    Table,
    /// Computed for every texel of every pixel, as in the notes.
    Shader,
}

/// Settings of a screen-space blur.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlurSettings {
    /// The inputs besides the factor.
    pub kind: BlurKind,
    /// Number of a pixel's neighbours along a line, both sides together: even, 8 to 64.
    pub samples: u32,
    /// Standard deviation, pixels.
    pub sigma_pixels: f64,
    /// Whether to blur along two lines, one after the other, instead of over one square. Within surfaces this
    /// is an approximation.
    pub separable: bool,
    /// The source of the weights.
    pub weights: BlurWeights,
    /// Whether each sample covers two neighbours by linear filtering.
    pub pairs: bool,
    /// Whether to blur at half the width and height.
    pub half: bool,
}

/// A pass of the blur, by its entry point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlurPass {
    /// `dilate_line`
    Dilate,
    /// `half_down`
    HalfDown,
    /// `half_down_edges`
    HalfDownEdges,
    /// `blur_line_table`
    LineTable,
    /// `blur_line_shader`
    LineShader,
    /// `blur_line_pairs`
    LinePairs,
    /// `blur_line_edges`
    LineEdges,
    /// `blur_square_table`
    SquareTable,
    /// `blur_square_shader`
    SquareShader,
    /// `blur_square_edges`
    SquareEdges,
    /// `half_up`
    HalfUp,
    /// `half_up_edges`
    HalfUpEdges,
}

/// One pass, and the axis of passes that run along a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlurStep {
    /// The pass.
    pub pass: BlurPass,
    /// 0 along x, 1 along y.
    pub axis: u32,
}

impl BlurStep {
    /// Whether the step reads and whether it writes a half-size picture.
    pub(crate) fn is_half(&self, settings: &BlurSettings) -> [bool; 2] {
        match self.pass {
            BlurPass::Dilate => [false, false],
            BlurPass::HalfDown | BlurPass::HalfDownEdges => [false, true],
            BlurPass::HalfUp | BlurPass::HalfUpEdges => [true, false],
            _ => [settings.half; 2],
        }
    }
}

impl BlurSettings {
    /// Reads `base`, `samples`, `sigma`, `passes`, `weights`, `pairs` and `half`, as well as `radius` of a
    /// blur that dilates and `tolerance` of one within surfaces.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] if a value does not exist or values are incompatible.
    pub(crate) fn from_reader(r: &mut SpecReader<'_>, name: BlurName) -> Result<Self> {
        r.technique("base", "the technique whose factor is blurred", None, DEFAULT_BASE)?;
        let dilation = "radius of the dilation, pixels";
        let tolerance = "largest distance of a surface from a pixel's plane, widths of a pixel there";
        let kind = match name {
            BlurName::Dilated => BlurKind::Dilated { radius: r.count("radius", dilation, 2, 1..=16)? },
            BlurName::Bilateral => BlurKind::WithinSurfaces {
                tolerance_pixels: r.number("tolerance", tolerance, 1.5, 0.1..=100.0)?,
            },
            BlurName::Plain => BlurKind::Plain,
        };
        let samples =
            r.count("samples", "neighbours along a line, rounded up to even", 16, 8..=2 * MAX_BLUR_SIDE)?;
        let sigma = "standard deviation, pixels; a quarter of samples by default";
        let sigma_pixels = r.number("sigma", sigma, f64::from(samples) / 4.0, 0.1..=64.0)?;
        let separable = r.choice("passes", "two lines, or one square", &["2", "1"])? == "2";
        let mut weights = BlurWeights::Table;
        let mut pairs = false;
        // A blur that depends on surfaces weights each texel individually.
        if !matches!(kind, BlurKind::WithinSurfaces { .. }) {
            let what = "how weights are computed: once, or for every texel";
            if r.choice("weights", what, &["table", "shader"])? == "shader" {
                weights = BlurWeights::Shader;
            } else if separable {
                let what = "with passes=2, weights=table: two neighbours per sample, by linear filtering";
                pairs = r.choice("pairs", what, &["off", "on"])? == "on";
            }
        }
        let half = r.choice("half", "blur at half the width and height", &["off", "on"])? == "on";
        let samples = samples.next_multiple_of(2);
        Ok(Self { kind, samples, sigma_pixels, separable, weights, pairs, half })
    }

    /// The passes, in order.
    pub fn steps(&self) -> Vec<BlurStep> {
        let within = matches!(self.kind, BlurKind::WithinSurfaces { .. });
        let both = |pass| [0, 1].map(|axis| BlurStep { pass, axis });
        let one = |pass| BlurStep { pass, axis: 0 };
        let mut steps = Vec::new();
        if matches!(self.kind, BlurKind::Dilated { .. }) {
            steps.extend(both(BlurPass::Dilate));
        }
        if self.half {
            steps.push(one(if within { BlurPass::HalfDownEdges } else { BlurPass::HalfDown }));
        }
        let shader = self.weights == BlurWeights::Shader;
        match (self.separable, within) {
            (true, true) => steps.extend(both(BlurPass::LineEdges)),
            (true, false) if self.pairs => steps.extend(both(BlurPass::LinePairs)),
            (true, false) if shader => steps.extend(both(BlurPass::LineShader)),
            (true, false) => steps.extend(both(BlurPass::LineTable)),
            (false, true) => steps.push(one(BlurPass::SquareEdges)),
            (false, false) if shader => steps.push(one(BlurPass::SquareShader)),
            (false, false) => steps.push(one(BlurPass::SquareTable)),
        }
        if self.half {
            steps.push(one(if within { BlurPass::HalfUpEdges } else { BlurPass::HalfUp }));
        }
        steps
    }

    /// Width and height of the blurred picture.
    pub fn size(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        if self.half { [width.div_ceil(2), height.div_ceil(2)] } else { [width, height] }
    }

    /// Returns a step's uniform for a frame of this size.
    pub fn params(&self, step: BlurStep, frame: [u32; 2]) -> BlurParams {
        let scale = if self.half { 2 } else { 1 };
        let side = self.samples / 2 / scale;
        let sigma = self.sigma_pixels / f64::from(scale);
        let gauss: Vec<f64> = (0..=side).map(|i| (-0.5 * (f64::from(i) / sigma).powi(2)).exp()).collect();
        let sum = 2.0 * gauss.iter().sum::<f64>() - gauss[0];
        let weights: Vec<f64> = gauss.iter().map(|g| g / sum).collect();
        let none = BlurTap { weight: 0.0, pair_offset_texels: 0.0, pair_weight: 0.0 };
        let mut taps = [none; MAX_BLUR_SIDE as usize + 1];
        for (tap, weight) in taps.iter_mut().zip(&weights) {
            tap.weight = *weight as f32;
        }
        let pairs = weights[1..].chunks(2);
        let pair_count = pairs.len() as u32;
        for (i, pair) in pairs.enumerate() {
            let weight: f64 = pair.iter().sum();
            let near = (2 * i + 1) as f64;
            // Very small weights may underflow to 0.
            let beyond = if weight > 0.0 { pair.get(1).map_or(0.0, |w| w / weight) } else { 0.0 };
            taps[i].pair_offset_texels = (near + beyond) as f32;
            taps[i].pair_weight = weight as f32;
        }
        let (radius, tolerance) = match self.kind {
            BlurKind::Plain => (0, 0.0),
            BlurKind::Dilated { radius } => (radius, 0.0),
            BlurKind::WithinSurfaces { tolerance_pixels } => (0, tolerance_pixels),
        };
        // A dilation runs before the picture is halved.
        let size = if step.pass == BlurPass::Dilate { frame } else { self.size(frame) };
        BlurParams {
            taps: Array(taps),
            size,
            frame_size: frame,
            taps_per_side: side,
            pair_count,
            pixels_per_texel: scale,
            axis: step.axis,
            dilation_texels: radius,
            sigma_texels: sigma as f32,
            tolerance_pixels: tolerance as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::technique::SpecText;

    fn read(name: BlurName, text: &str) -> Result<BlurSettings> {
        let spec: SpecText = text.parse()?;
        spec.read(|reader| BlurSettings::from_reader(reader, name))
    }

    #[test]
    fn blur_weights_sum_to_one_and_pairs_match_single_taps() {
        for samples in (8..=64).step_by(2) {
            for half in ["off", "on"] {
                let text = format!("blur:samples={samples}:half={half}:pairs=on");
                let settings = read(BlurName::Plain, &text).unwrap();
                let params = settings.params(settings.steps()[0], [64, 64]);
                let side = params.taps_per_side as usize;
                let weights: Vec<f64> = params.taps.0.iter().map(|t| t.weight.into()).collect();
                let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
                assert!((sum - 1.0).abs() < 1e-6, "{samples}: {sum}");
                assert_eq!(params.taps.0.iter().filter(|t| t.weight > 0.0).count(), side + 1);
                // A pair at its offset has the zeroth and first moments of its two texels.
                let pairs = params.pair_count as usize;
                assert_eq!(pairs, side.div_ceil(2));
                let moment = |power: i32| -> (f64, f64) {
                    let single = (1..=side).map(|i| weights[i] * (i as f64).powi(power)).sum();
                    let paired = params.taps.0[..pairs].iter();
                    (
                        single,
                        paired
                            .map(|t| f64::from(t.pair_weight) * f64::from(t.pair_offset_texels).powi(power))
                            .sum(),
                    )
                };
                for (single, paired) in [moment(0), moment(1)] {
                    assert!((single - paired).abs() < 1e-5, "{samples}: {single} {paired}");
                }
            }
        }
    }

    #[test]
    fn blur_reads_its_parameters() {
        let text = "blur:samples=8:sigma=3:passes=1:base=csm/cascades=2/filter=3";
        let settings = read(BlurName::Plain, text).unwrap();
        assert_eq!((settings.samples, settings.sigma_pixels, settings.separable), (8, 3.0, false));
        let dilated = read(BlurName::Dilated, "blur-dilate:radius=3").unwrap();
        assert_eq!(dilated.kind, BlurKind::Dilated { radius: 3 });
        for (name, wrong) in [
            (BlurName::Plain, "blur:samples=7"),
            (BlurName::Plain, "blur:passes=1:pairs=on"),
            (BlurName::Plain, "blur:radius=2"),
            (BlurName::Bilateral, "blur-bilateral:weights=shader"),
        ] {
            assert!(read(name, wrong).is_err(), "{wrong}");
        }
    }
}
