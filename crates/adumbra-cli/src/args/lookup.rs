//! Options of look-ups in a shadow file.

use adumbra::Bias;
use adumbra_program::exit::Failure;

use super::tree::WeightsArg;

/// How a shadow file is looked up.
#[derive(clap::Args)]
pub(crate) struct LookupArgs {
    /// Filter width in texels: 1, 3, 5, 9 or 17; for a world-aligned file K × K × K voxels: 1, 3 or 5
    #[arg(long, value_name = "K", default_value = "1")]
    pub(crate) filter: u32,
    /// How the taps of a world-aligned file are weighted
    #[arg(long, value_enum, default_value = "mean")]
    pub(crate) weights: WeightsArg,
    #[command(flatten)]
    pub(crate) bias: BiasArgs,
}

/// The bias of look-ups, in texels. Values that are not given come from the file.
#[derive(clap::Args)]
pub(crate) struct BiasArgs {
    /// Bias along the light, everywhere [default: the file's]
    #[arg(long, value_name = "TEXELS")]
    bias_constant: Option<f64>,
    /// Bias along the light per unit of slope [default: the file's]
    #[arg(long, value_name = "TEXELS")]
    bias_slope: Option<f64>,
    /// Offset along the normal [default: the file's]
    #[arg(long, value_name = "TEXELS")]
    bias_normal: Option<f64>,
}

impl BiasArgs {
    /// Returns the options that were given, as parameters of a technique.
    #[cfg(feature = "render")]
    pub(crate) fn parameters(&self) -> String {
        let given = [("bias", self.bias_constant), ("slope", self.bias_slope), ("normal", self.bias_normal)];
        given.iter().filter_map(|(key, value)| value.map(|v| format!(":{key}={v}"))).collect()
    }

    pub(crate) fn over(&self, file: Bias) -> Result<Bias, Failure> {
        let bias = Bias {
            constant_texels: self.bias_constant.unwrap_or(file.constant_texels),
            slope_texels: self.bias_slope.unwrap_or(file.slope_texels),
            normal_offset_texels: self.bias_normal.unwrap_or(file.normal_offset_texels),
        };
        bias.check()?;
        Ok(bias)
    }
}
