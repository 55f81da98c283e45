//! Options of look-ups in a shadow file.

use adumbra::{Bias, Filter, Sampler, ShadowFile};

use crate::exit::Failure;

/// How a shadow file is looked up.
#[derive(clap::Args)]
pub struct LookupArgs {
    /// Filter width in texels: 1, 3, 5, 9 or 17
    #[arg(long, value_name = "K", default_value = "1")]
    pub filter: u32,
    /// The bias of the look-up.
    #[command(flatten)]
    pub bias: BiasArgs,
}

impl LookupArgs {
    /// Returns the look-up of a file.
    ///
    /// # Errors
    ///
    /// Returns [`Failure::Reader`] for a filter or a bias that does not exist.
    pub fn sampler(&self, file: &ShadowFile) -> Result<Sampler, Failure> {
        let filter = Filter::try_from(self.filter)?;
        Ok(file.sampler(filter).with_bias(self.bias.over(file.settings.bias)?)?)
    }
}

/// The bias of look-ups, in texels. Values that are not given come from the file.
#[derive(clap::Args)]
pub struct BiasArgs {
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
    pub fn parameters(&self) -> String {
        let given = [("bias", self.bias_constant), ("slope", self.bias_slope), ("normal", self.bias_normal)];
        given.iter().filter_map(|(key, value)| value.map(|v| format!(":{key}={v}"))).collect()
    }

    /// Returns the bias of a look-up in a file with the bias `file`.
    ///
    /// # Errors
    ///
    /// Returns [`Failure::Reader`] for a term that is out of its range.
    pub fn over(&self, file: Bias) -> Result<Bias, Failure> {
        let bias = Bias {
            constant_texels: self.bias_constant.unwrap_or(file.constant_texels),
            slope_texels: self.bias_slope.unwrap_or(file.slope_texels),
            normal_offset_texels: self.bias_normal.unwrap_or(file.normal_offset_texels),
        };
        bias.check()?;
        Ok(bias)
    }
}
