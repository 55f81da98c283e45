//! Shadow files and look-ups in them.

use std::fs;
use std::path::{Path, PathBuf};

use adumbra::file::sections::read_file;
use adumbra::file::{HEADER_BYTES, Header};
use adumbra::{Bias, Encoding, Filter, Frame, IoError, Receivers, Sampler, ShadowFile};
use adumbra_files::replace_file;
use adumbra_scene::{LoadedAs, UpAxis};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::ThreadPool;
use rayon::prelude::*;

use crate::arrays::{GivenPlaces, Places, Rooms, zeros};
use crate::axes::{bounds_in_file, name_of};
use crate::errors::Failure;
use crate::pool::pool;
use crate::watch::watched;

/// Number of points per batch. They are looked up one after another, because a look-up starts from the
/// position of the previous one.
const BATCH: usize = 1 << 12;
/// Number of points between checks whether Python was interrupted.
const BLOCK: usize = 1 << 20;

/// A shadow file in memory. Numbers from Python and for Python are of the axes of the scene's file.
#[pyclass(frozen, module = "adumbra._native")]
pub(crate) struct File {
    pub(crate) file: ShadowFile,
    encoding: Encoding,
    /// Length of the file that it was read from or baked into; `None` for a level of detail, which was never
    /// a file by itself.
    stored_bytes: Option<u64>,
}

/// A bias in texels: constant, per unit of slope, along the normal. Missing values are those of the file.
pub(crate) type GivenBias = (Option<f64>, Option<f64>, Option<f64>);

/// How a look-up filters, and the bias that it was given.
pub(crate) type LookUp = (u32, GivenBias);

impl File {
    /// Decodes the bytes of a file.
    pub(crate) fn decode(bytes: &[u8]) -> Result<Self, adumbra::FormatError> {
        let file = ShadowFile::from_bytes(bytes)?;
        let encoding = Header::parse(bytes)?.encoding;
        Ok(Self { file, encoding, stored_bytes: Some(bytes.len() as u64) })
    }

    /// Reads a file that was just written.
    pub(crate) fn read_back(path: &Path) -> Result<Self, Failure> {
        let bytes = fs::read(path).map_err(IoError::at("read", path))?;
        Ok(Self::decode(&bytes)?)
    }

    /// Returns a sampler.
    pub(crate) fn sampler(&self, (filter, (constant, slope, normal)): LookUp) -> Result<Sampler, Failure> {
        let of_file = self.file.settings.bias;
        let bias = Bias {
            constant_texels: constant.unwrap_or(of_file.constant_texels),
            slope_texels: slope.unwrap_or(of_file.slope_texels),
            normal_offset_texels: normal.unwrap_or(of_file.normal_offset_texels),
        };
        Ok(self.file.sampler(Filter::try_from(filter)?).with_bias(bias)?)
    }
}

/// Returns an encoding by its name.
pub(crate) fn encoding(name: &str) -> Result<Encoding, Failure> {
    match name {
        "coded" => Ok(Encoding::Coded),
        "raw" => Ok(Encoding::Raw),
        _ => Err(Failure::Value(format!("encoding: {name:?} must be \"coded\" or \"raw\""))),
    }
}

#[pymethods]
impl File {
    /// Reads a file.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        watched(py, None, |_| {
            // Read the header first, so that a large file of another kind is rejected without reading it.
            let bytes = read_file(&path, HEADER_BYTES, |front| Ok(Header::parse(front)?.file_bytes))?;
            let file = pool(None)?.install(|| Self::decode(&bytes));
            file.map_err(|source| {
                Failure::Reader(adumbra::Error::Format { path: Some(path), source: Box::new(source) })
            })
        })
    }

    /// Decodes the bytes of a file.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: &[u8]) -> PyResult<Self> {
        watched(py, None, |_| Ok(pool(None)?.install(|| Self::decode(data))?))
    }

    /// Returns the bytes of the file.
    fn to_bytes<'py>(&self, py: Python<'py>, stored: &str) -> PyResult<Bound<'py, PyBytes>> {
        let encoding = encoding(stored)?;
        let bytes = watched(py, None, |_| Ok(pool(None)?.install(|| self.file.to_bytes(encoding))?))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Writes the file. An earlier file is replaced as a whole.
    fn write(&self, py: Python<'_>, path: PathBuf, stored: &str) -> PyResult<u64> {
        let encoding = encoding(stored)?;
        watched(py, None, |_| {
            let write = || replace_file(&path, |out| self.file.write_to(out, encoding));
            Ok(pool(None)?.install(write)?)
        })
    }

    /// Returns a level of detail and all coarser ones, or `None` if there is no such level.
    fn level(&self, level: u32) -> Option<Self> {
        let file = self.file.level(level)?;
        Some(Self { file, encoding: self.encoding, stored_bytes: self.stored_bytes.filter(|_| level == 0) })
    }

    /// Returns the visibility of points.
    fn visibility<'py>(
        &self,
        py: Python<'py>,
        places: GivenPlaces<'py>,
        given: LookUp,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let sampler = self.sampler(given)?;
        let places = Places::new(&places, up_of(&self.file))?;
        look_up(py, &*pool(threads)?, places, |points, normals, out| {
            sampler.visibilities(points, normals, out)
        })
    }

    /// The unit vector towards the sun.
    #[getter]
    fn to_sun(&self) -> [f64; 3] {
        up_of(&self.file).to_file(self.file.sun().towards())
    }

    /// Texels on the longest side of the scene in the light's plane.
    #[getter]
    fn resolution(&self) -> u32 {
        self.file.settings.resolution
    }

    /// Voxels along x, y and z of the grid.
    #[getter]
    fn size(&self) -> [u32; 3] {
        self.file.grid.size
    }

    /// Edge of a voxel, world units.
    #[getter]
    fn voxel_size(&self) -> f64 {
        self.file.grid.voxel_size
    }

    /// Number of levels of detail.
    #[getter]
    fn levels(&self) -> u32 {
        self.file.level_count()
    }

    /// Length of the file in bytes, in its encoding.
    #[getter]
    fn stored_bytes(&self, py: Python<'_>) -> PyResult<u64> {
        match self.stored_bytes {
            Some(bytes) => Ok(bytes),
            None => watched(py, None, |_| {
                Ok(pool(None)?.install(|| self.file.to_bytes(self.encoding))?.len() as u64)
            }),
        }
    }

    /// How the file was stored: "coded" or "raw".
    #[getter]
    fn encoding(&self) -> &'static str {
        match self.encoding {
            Encoding::Coded => "coded",
            Encoding::Raw => "raw",
        }
    }

    /// "light" or "oblique".
    #[getter]
    fn frame(&self) -> &'static str {
        self.file.grid.frame.name()
    }

    /// Turn of an oblique grid, degrees.
    #[getter]
    fn yaw(&self) -> Option<f64> {
        match self.file.grid.frame {
            Frame::Light => None,
            Frame::Oblique { yaw_radians } => Some(yaw_radians.to_degrees()),
        }
    }

    /// The box that was given to the bake.
    #[getter]
    fn bounds(&self) -> Option<([f64; 3], [f64; 3])> {
        self.file.settings.bounds.map(|bounds| bounds_in_file(up_of(&self.file), &bounds))
    }

    /// The bias in texels: constant, per unit of slope, along the normal.
    #[getter]
    fn bias(&self) -> (f64, f64, f64) {
        let bias = self.file.settings.bias;
        (bias.constant_texels, bias.slope_texels, bias.normal_offset_texels)
    }

    /// Number of triangles that were baked.
    #[getter]
    fn triangles(&self) -> u64 {
        self.file.settings.triangles
    }

    /// Depth below open surfaces at which shadows may begin, world units.
    #[getter]
    fn thickness(&self) -> f64 {
        self.file.settings.thickness_world
    }

    /// Whether shadows below the last surface of a column are left out.
    #[getter]
    fn assume_ground(&self) -> bool {
        self.file.settings.assume_ground
    }

    /// Whether points inside closed solids may be lit or shadowed.
    #[getter]
    fn closed_regions(&self) -> bool {
        self.file.settings.closed_regions
    }

    /// Whether masked materials count as opaque.
    #[getter]
    fn ignore_alpha(&self) -> bool {
        self.file.settings.ignore_alpha
    }

    /// The axis that points up in the scene's own file: "y" or "z".
    #[getter]
    fn up(&self) -> &'static str {
        name_of(up_of(&self.file))
    }

    /// Which points the file answers: "all" or "static".
    #[getter]
    fn receivers(&self) -> &'static str {
        match self.file.settings.receivers {
            Receivers::All => "all",
            Receivers::Static => "static",
        }
    }

    /// Voxels within which a column switches to shadow; 0 is no limit.
    #[getter]
    fn switch_within(&self) -> u32 {
        self.file.settings.switch_within_voxels
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.file == other.file
    }
}

/// Returns the axis that points up in the scene's file.
pub(crate) fn up_of(file: &ShadowFile) -> UpAxis {
    LoadedAs::from(&file.settings).up.unwrap_or_default()
}

/// Looks up the visibility of points on the threads of a pool. `fill` looks up consecutive points.
pub(crate) fn look_up<'py>(
    py: Python<'py>,
    pool: &ThreadPool,
    places: Places<'_>,
    fill: impl Fn(&[[f64; 3]], Option<&[[f64; 3]]>, &mut [f32]) -> adumbra::Result<()> + Sync,
) -> PyResult<Bound<'py, PyArray1<f32>>> {
    let array: Bound<'py, PyArray1<f32>> = zeros(py, places.len())?;
    let mut out = array.readwrite();
    for (block, out) in out.as_slice_mut()?.chunks_mut(BLOCK).enumerate() {
        let batches = out.par_chunks_mut(BATCH).enumerate();
        let work = || {
            batches.try_for_each_init(Rooms::default, |rooms, (batch, out)| {
                let start = block * BLOCK + batch * BATCH;
                let (points, normals) = places.range(start..start + out.len(), rooms);
                fill(points, normals, out)
            })
        };
        py.detach(|| pool.install(work)).map_err(Failure::from)?;
        py.check_signals()?;
    }
    Ok(array)
}
