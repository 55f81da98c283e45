//! The shadow file of a view: whole, or streamed if it needs more than the budget.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use adumbra::stream::{FileSource, StreamOptions, Streamer};
use adumbra::{FileSettings, LightGrid, ShadowFile, Sun};
use adumbra_render::TechniqueFiles;
use adumbra_render::voxel::{LightFile, MovingLight, StreamedFile};

use crate::error::Result;
use crate::settings::Settings;

/// Largest number of bytes of a streamed file that a frame uploads.
const UPLOAD_BYTES: usize = 1 << 20;
/// How long to wait for the beginning of a streamed file.
const OPENING: Duration = Duration::from_secs(30);

/// A shadow file that a view shows.
#[derive(Clone)]
pub(crate) enum ShownFile {
    Whole(Arc<ShadowFile>),
    Streamed(Arc<StreamedFile>),
    /// The keys around a moving sun.
    Moving(Arc<MovingLight>),
}

impl ShownFile {
    /// Reads a file, or its beginning if its words need more than the budget.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read or is not valid.
    pub(crate) fn read(path: &Path, stream: StreamOptions) -> Result<Self> {
        let streamer = Streamer::new(FileSource::open(path)?, stream);
        if let Ok(file) = StreamedFile::open(streamer, UPLOAD_BYTES, OPENING) {
            // The file of a region must be placed in the world. Only whole files support that.
            if file.counts().decoded_bytes > stream.budget_bytes && file.settings().region.is_none() {
                return Ok(Self::Streamed(Arc::new(file)));
            }
        }
        // Reading the whole file reports any fault of the file.
        Ok(Self::whole(ShadowFile::read(path)?.in_world()))
    }

    pub(crate) fn whole(file: ShadowFile) -> Self {
        Self::Whole(Arc::new(file))
    }

    pub(crate) fn streamed(&self) -> Option<&Arc<StreamedFile>> {
        match self {
            Self::Whole(_) | Self::Moving(_) => None,
            Self::Streamed(file) => Some(file),
        }
    }

    /// Whether the last frame had everything it needed. If not, the next frame has more.
    pub(crate) fn is_settled(&self) -> bool {
        match self {
            Self::Whole(_) => true,
            Self::Streamed(file) => file.is_settled(),
            Self::Moving(light) => light.is_settled(),
        }
    }

    pub(crate) fn grid(&self) -> LightGrid {
        match self {
            Self::Whole(file) => file.grid,
            Self::Streamed(file) => *file.grid(),
            Self::Moving(light) => light.first_key().grid,
        }
    }

    pub(crate) fn settings(&self) -> FileSettings {
        match self {
            Self::Whole(file) => file.settings,
            Self::Streamed(file) => *file.settings(),
            Self::Moving(light) => light.first_key().settings,
        }
    }

    pub(crate) fn sun(&self) -> Sun {
        self.grid().sun
    }

    /// Returns the file for techniques.
    pub(crate) fn baked(&self) -> TechniqueFiles<'_> {
        let light = match self {
            Self::Whole(file) => LightFile::Whole(file),
            Self::Streamed(file) => LightFile::Streamed(file),
            Self::Moving(light) => LightFile::Moving(light),
        };
        TechniqueFiles { light: Some(light), other: None }
    }

    /// Whether the file fits the settings: it was baked for their sun, or follows the sun.
    pub(crate) fn serves(&self, settings: &Settings) -> bool {
        matches!(self, Self::Moving(_)) || is_same_sun(&self.sun(), &settings.sun)
    }

    /// Whether a world point is inside the file's space.
    pub(crate) fn contains(&self, p_world: [f64; 3]) -> bool {
        let grid = self.grid();
        let p = grid.to_grid(p_world);
        (0..3).all(|a| (0.0..=f64::from(grid.size[a])).contains(&p[a]))
    }

    /// Describes the contents of the file, one line each.
    pub(crate) fn lines(&self) -> Vec<String> {
        let voxels =
            format!("{} voxels of {:.3} world units", self.settings().resolution, self.grid().voxel_size);
        let mega = |bytes: u64| format!("{:.2} MB", bytes as f64 * 1e-6);
        match self {
            Self::Whole(file) => vec![format!("{voxels}, {}", mega(file.encoded_len()))],
            Self::Moving(_) => vec![voxels],
            Self::Streamed(file) => {
                let counts = file.counts();
                vec![
                    format!("{voxels}, {}, streamed", mega(counts.file_bytes)),
                    format!("{} read in {} requests", mega(counts.bytes), counts.requests),
                    format!(
                        "{} resident, {} of {} bundles missing",
                        mega(counts.resident_bytes),
                        counts.missing_bundles,
                        counts.chosen_bundles
                    ),
                ]
            }
        }
    }
}

/// Whether two suns are equal, up to rounding by file formats and conversion to angles.
pub(crate) fn is_same_sun(a: &Sun, b: &Sun) -> bool {
    (0..3).all(|i| (a.towards()[i] - b.towards()[i]).abs() < 1e-9)
}
