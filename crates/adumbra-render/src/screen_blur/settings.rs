//! What a screen-space blur is asked for, and the passes that it comes to.

use adumbra_shaders::constants::MAX_BLUR_SIDE;
use adumbra_shaders::layout::{Array, BlurParams};

use crate::error::Result;
use crate::technique::{SpecReader, TechniqueSpec};

/// What the blur sees beside the factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BlurKind {
    /// Nothing: the notes' blur, with its halo.
    Plain,
    /// Nothing, and the shade is dilated first: the notes' attempt at the halo.
    Dilated {
        /// Texels.
        radius: u32,
    },
    /// Depth and normal: texels off the pixel's own surface do not count.
    WithinSurfaces {
        /// How far off a pixel's plane its surface may lie, in widths of a pixel there.
        tolerance_pixels: f64,
    },
}

/// Where the Gaussian's weights come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlurWeights {
    /// Computed once, on the CPU.
    Table,
    /// Computed for every texel of every pixel, as the notes have it.
    Shader,
}

/// A screen-space blur.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlurSettings {
    /// What it sees.
    pub kind: BlurKind,
    /// Neighbours of a pixel along a line, on both sides together: even, 8 to 64.
    pub samples: u32,
    /// Standard deviation in pixels.
    pub sigma_pixels: f64,
    /// Two lines, one after the other, in place of one square. Within surfaces that is an approximation.
    pub separable: bool,
    /// Where weights come from.
    pub weights: BlurWeights,
    /// Two neighbours a sample, by linear filtering.
    pub pairs: bool,
    /// Blurred at half the width and height.
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

/// One pass, and the axis that it runs along (0 or 1), where it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlurStep {
    /// Which.
    pub pass: BlurPass,
    /// 0 along x, 1 along y.
    pub axis: u32,
}

impl BlurStep {
    /// Whether it reads, and whether it writes the half-size picture.
    pub fn is_half(&self, settings: &BlurSettings) -> [bool; 2] {
        match self.pass {
            BlurPass::Dilate => [false, false],
            BlurPass::HalfDown | BlurPass::HalfDownEdges => [false, true],
            BlurPass::HalfUp | BlurPass::HalfUpEdges => [true, false],
            _ => [settings.half; 2],
        }
    }
}

impl BlurSettings {
    /// Reads `samples`, `sigma`, `passes`, `weights`, `pairs`, `half`, and of `blur-dilate` `radius`, of `blur-bilateral`
    /// `tolerance`; and the technique under it, `base`, with `/` between its parameters (`base=pcf/filter=3`).
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] for values that do not exist or do not go together.
    pub fn read(spec: &TechniqueSpec) -> Result<(Self, TechniqueSpec)> {
        let mut reader = spec.reader();
        let read = Self::from_reader(&mut reader)?;
        reader.finish()?;
        Ok(read)
    }

    pub(crate) fn from_reader(r: &mut SpecReader<'_>) -> Result<(Self, TechniqueSpec)> {
        let name = r.spec().name();
        let base = r.technique("base", "whose factor is blurred", None, "pcf/filter=2")?;
        if base.name().starts_with("blur") {
            return Err(r.spec().wrong("base: a blur over a blur".to_owned()));
        }
        let dilation = "of the dilation, pixels";
        let tolerance = "how far off a pixel's plane its surface may lie, widths of a pixel there";
        let kind = match name {
            "blur-dilate" => BlurKind::Dilated { radius: r.count("radius", dilation, 2, 1..=16)? },
            "blur-bilateral" => BlurKind::WithinSurfaces {
                tolerance_pixels: r.number("tolerance", tolerance, 1.5, 0.1..=100.0)?,
            },
            _ => BlurKind::Plain,
        };
        let samples = r.count("samples", "neighbours along a line, made even", 16, 8..=2 * MAX_BLUR_SIDE)?;
        let sigma = "standard deviation, pixels; a quarter of samples by default";
        let sigma_pixels = r.number("sigma", sigma, f64::from(samples) / 4.0, 0.1..=64.0)?;
        let separable = r.choice("passes", "two lines, or one square", &["2", "1"])? == "2";
        let mut weights = BlurWeights::Table;
        let mut pairs = false;
        // What sees surfaces weighs every texel by itself.
        if !matches!(kind, BlurKind::WithinSurfaces { .. }) {
            let what = "where they are computed: once, or for every texel";
            if r.choice("weights", what, &["table", "shader"])? == "shader" {
                weights = BlurWeights::Shader;
            } else if separable {
                let what = "of passes=2, weights=table: two neighbours a sample, by linear filtering";
                pairs = r.choice("pairs", what, &["off", "on"])? == "on";
            }
        }
        let half = r.choice("half", "blurred at half the width and height", &["off", "on"])? == "on";
        let samples = samples.next_multiple_of(2);
        Ok((Self { kind, samples, sigma_pixels, separable, weights, pairs, half }, base))
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

    /// Width and height of the picture that is blurred.
    pub fn size(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        if self.half { [width.div_ceil(2), height.div_ceil(2)] } else { [width, height] }
    }

    /// A step's uniform in a frame of this size.
    pub fn params(&self, step: BlurStep, frame: [u32; 2]) -> BlurParams {
        let scale = if self.half { 2 } else { 1 };
        let side = self.samples / 2 / scale;
        let sigma = self.sigma_pixels / f64::from(scale);
        let gauss: Vec<f64> = (0..=side).map(|i| (-0.5 * (f64::from(i) / sigma).powi(2)).exp()).collect();
        let sum = 2.0 * gauss.iter().sum::<f64>() - gauss[0];
        let weights: Vec<f64> = gauss.iter().map(|g| g / sum).collect();
        let mut taps = [[0.0; 4]; MAX_BLUR_SIDE as usize + 1];
        for (tap, weight) in taps.iter_mut().zip(&weights) {
            tap[0] = *weight as f32;
        }
        let pairs = weights[1..].chunks(2);
        let pair_count = pairs.len() as u32;
        for (i, pair) in pairs.enumerate() {
            let weight: f64 = pair.iter().sum();
            let near = (2 * i + 1) as f64;
            // Weights may be so small that they are 0.
            let beyond = if weight > 0.0 { pair.get(1).map_or(0.0, |w| w / weight) } else { 0.0 };
            (taps[i][1], taps[i][2]) = ((near + beyond) as f32, weight as f32);
        }
        let (radius, tolerance) = match self.kind {
            BlurKind::Plain => (0, 0.0),
            BlurKind::Dilated { radius } => (radius, 0.0),
            BlurKind::WithinSurfaces { tolerance_pixels } => (0, tolerance_pixels),
        };
        // A dilation comes before the half size.
        let size = if step.pass == BlurPass::Dilate { frame } else { self.size(frame) };
        BlurParams {
            counts: [side, scale, step.axis, radius],
            size: [size[0], size[1], frame[0], frame[1]],
            shape: [sigma as f32, tolerance as f32, 0.0, 0.0],
            pairs: [pair_count, 0, 0, 0],
            taps: Array(taps),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<(BlurSettings, TechniqueSpec)> {
        BlurSettings::read(&text.parse()?)
    }

    #[test]
    fn blur_weights_add_to_one_and_pairs_hold_the_same() {
        for samples in (8..=64).step_by(2) {
            for half in ["off", "on"] {
                let (settings, _) = read(&format!("blur:samples={samples}:half={half}:pairs=on")).unwrap();
                let params = settings.params(settings.steps()[0], [64, 64]);
                let side = params.counts[0] as usize;
                let weights: Vec<f64> = params.taps.0.iter().map(|t| t[0].into()).collect();
                let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
                assert!((sum - 1.0).abs() < 1e-6, "{samples}: {sum}");
                assert_eq!(params.taps.0.iter().filter(|t| t[0] > 0.0).count(), side + 1);
                // A pair at its offset weighs and pulls as its two texels do.
                let pairs = params.pairs[0] as usize;
                assert_eq!(pairs, side.div_ceil(2));
                let moment = |power: i32| -> (f64, f64) {
                    let single = (1..=side).map(|i| weights[i] * (i as f64).powi(power)).sum();
                    let paired = params.taps.0[..pairs].iter();
                    (single, paired.map(|t| f64::from(t[2]) * f64::from(t[1]).powi(power)).sum())
                };
                for (single, paired) in [moment(0), moment(1)] {
                    assert!((single - paired).abs() < 1e-5, "{samples}: {single} {paired}");
                }
            }
        }
    }

    #[test]
    fn blur_reads_its_parameters() {
        let (settings, base) = read("blur:samples=8:sigma=3:passes=1:base=csm/cascades=2/filter=3").unwrap();
        assert_eq!((settings.samples, settings.sigma_pixels, settings.separable), (8, 3.0, false));
        assert_eq!(base.to_string(), "csm:cascades=2:filter=3");
        assert_eq!(read("blur-dilate:radius=3").unwrap().0.kind, BlurKind::Dilated { radius: 3 });
        for wrong in
            ["blur:samples=7", "blur:passes=1:pairs=on", "blur:radius=2", "blur-bilateral:weights=shader"]
        {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
