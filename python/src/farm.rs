//! Bakes in steps that many machines can share: plans, their parts, and the files that are linked from them.
//!
//! A plan is written as the program `adumbra plan` writes it: the path of the scene, how to load it, and what
//! to bake.

use std::collections::HashMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf, absolute};
use std::sync::{Arc, Mutex, PoisonError};

use adumbra::IoError;
use adumbra_bake::{BakeCache, BakePlan, CacheKey, DiskCache, Fetched, PartBaker};
use adumbra_files::{StagedFile, check_output, replace_file, same_file};
use adumbra_scene::{Edits, LoadOptions, MoverPolicy, NameFilter, UpAxis, load};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use self_cell::self_cell;
use serde::{Deserialize, Serialize};

use crate::axes::up_axis;
use crate::bake::Options;
use crate::errors::Failure;
use crate::file::File;
use crate::pool::pool;
use crate::scene::Scene;
use crate::watch::watched;

/// How the scene of a plan is loaded.
#[derive(Deserialize, FromPyObject, Serialize)]
#[pyo3(from_item_all)]
#[serde(deny_unknown_fields)]
struct Loading {
    only: Vec<String>,
    exclude: Vec<String>,
    ignore_alpha: bool,
    include_animated: bool,
    #[pyo3(from_py_with = up_axis)]
    up: Option<UpAxis>,
    allow_outside: bool,
    edit: Option<PathBuf>,
    strict: bool,
}

impl Loading {
    fn options(&self) -> Result<LoadOptions, Failure> {
        Ok(LoadOptions {
            filter: NameFilter::new(&self.only, &self.exclude)?,
            ignore_alpha: self.ignore_alpha,
            movers: if self.include_animated { MoverPolicy::Freeze } else { MoverPolicy::Skip },
            up: self.up,
            allow_outside: self.allow_outside,
            edits: self.edit.as_deref().map_or_else(|| Ok(Edits::default()), Edits::read)?,
            strict: self.strict,
            ..LoadOptions::default()
        })
    }
}

/// The memory limit in bytes, and the number of threads.
type Limits = (Option<u64>, Option<usize>);

/// The file of a plan.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct PlanFile {
    scene: PathBuf,
    load: Loading,
    plan: BakePlan,
}

/// A planned bake.
#[pyclass(frozen, module = "adumbra._native")]
pub(crate) struct Plan {
    file: Arc<PlanFile>,
    /// The bytes of its file.
    text: Vec<u8>,
    digest: String,
}

impl Plan {
    fn of(file: PlanFile) -> Result<Self, Failure> {
        let text = serde_json::to_vec(&file)
            .map_err(|error| Failure::Value(format!("{:?} cannot be in a plan: {error}", file.scene)))?;
        let digest = blake3::hash(&text).to_string();
        Ok(Self { file: Arc::new(file), text, digest })
    }

    /// Rejects an output that cannot be written, or that is the scene.
    fn check(&self, output: &Path) -> Result<(), Failure> {
        if same_file(&self.file.scene, output) {
            let what = format!("output {:?} would overwrite the scene; give another path", output.display());
            return Err(Failure::Value(what));
        }
        Ok(check_output(output)?)
    }
}

#[pymethods]
impl Plan {
    /// Plans the bake of a scene that was loaded from `path`.
    #[staticmethod]
    fn new(
        py: Python<'_>,
        scene: &Scene,
        path: PathBuf,
        loading: Loading,
        options: Options,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let options = options.for_bake(scene)?;
        watched(py, None, |_| {
            let path = absolute(&path).map_err(IoError::at("find", &path))?;
            let plan = pool(threads)?.install(|| BakePlan::new(&scene.scene, &options))?;
            Self::of(PlanFile { scene: path, load: loading, plan })
        })
    }

    /// Reads a plan.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        watched(py, None, |_| {
            let text = fs::read(&path).map_err(IoError::at("read", &path))?;
            let wrong = |error| Failure::Plan(format!("{}: {error}", path.display()));
            Self::of(serde_json::from_slice(&text).map_err(wrong)?)
        })
    }

    /// Decodes the bytes of its file.
    #[staticmethod]
    fn from_bytes(data: &[u8]) -> PyResult<Self> {
        let file = serde_json::from_slice(data).map_err(|error| Failure::Plan(error.to_string()))?;
        Ok(Self::of(file)?)
    }

    /// Writes it, and returns the length in bytes.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<u64> {
        watched(py, None, |_| {
            Ok(replace_file(&path, |out| out.write_all(&self.text).map(|()| self.text.len() as u64))?)
        })
    }

    /// The bytes of its file.
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.text)
    }

    /// The BLAKE3 of its file.
    #[getter]
    fn digest(&self) -> &str {
        &self.digest
    }

    /// The path of the scene.
    #[getter]
    fn scene(&self) -> PathBuf {
        self.file.scene.clone()
    }

    /// The level and the cost of each part, the most costly first.
    #[getter]
    fn parts(&self) -> Vec<(u32, u64)> {
        self.file.plan.parts().iter().map(|part| (part.level(), part.cost())).collect()
    }

    /// The ids of one of `count` shares of the parts with about the same cost each.
    fn shard(&self, index: usize, count: usize) -> Vec<usize> {
        self.file.plan.shard(index, count)
    }

    /// Loads the scene, and prepares to bake parts.
    fn baker(
        &self,
        py: Python<'_>,
        scene: Option<PathBuf>,
        spill: PathBuf,
        limits: Limits,
    ) -> PyResult<Baker> {
        let (max_memory_bytes, threads) = limits;
        watched(py, None, |_| {
            let path = scene.as_ref().unwrap_or(&self.file.scene);
            let plan = &self.file.plan;
            let limits = plan.options().with(|o| {
                o.max_memory_bytes = max_memory_bytes;
                o.spill_folder = Some(spill);
            });
            let prepared = pool(threads)?.install(|| -> Result<_, Failure> {
                let scene = load(path, &self.file.load.options()?)?;
                let owner = (scene, Arc::clone(&self.file));
                Ok(Prepared::try_new(owner, |(scene, file)| PartBaker::new(scene, &file.plan, &limits))?)
            })?;
            Ok(Baker { prepared })
        })
    }

    /// Rejects an output that a link would reject.
    fn check_path(&self, py: Python<'_>, output: PathBuf) -> PyResult<()> {
        watched(py, None, |_| self.check(&output))
    }

    /// Makes the file from the entries in `cache`. `sums` holds the BLAKE3 hashes of some parts' entries. An
    /// entry with another hash counts as missing.
    fn link(
        &self,
        py: Python<'_>,
        cache: PathBuf,
        output: PathBuf,
        sums: HashMap<usize, String>,
        limits: Limits,
        report: Option<Py<PyAny>>,
    ) -> PyResult<File> {
        let (max_memory_bytes, threads) = limits;
        watched(py, report, |watch| {
            let plan = &self.file.plan;
            self.check(&output)?;
            let key = |id: usize| plan.parts().get(id).map(|part| *part.key());
            let sums = sums.into_iter().filter_map(|(id, sum)| Some((key(id)?, sum))).collect();
            let cache: Arc<dyn BakeCache> = Arc::new(Checked { cache: DiskCache::open(cache)?, sums });
            let limits = plan.options().with(|o| o.max_memory_bytes = max_memory_bytes);
            pool(threads)?.install(|| {
                let (staged, _) = plan.stage_link(&cache, &limits, watch, &output)?;
                StagedFile::place([staged])?;
                File::read_back(&output)
            })
        })
    }
}

/// A scene, and the plan of its bake.
type Planned = (adumbra_scene::Scene, Arc<PlanFile>);

self_cell!(
    /// A scene with a plan, and the baker of its parts.
    struct Prepared {
        owner: Planned,
        #[not_covariant]
        dependent: PartBaker,
    }
);

/// A scene that is ready for bakes of its parts.
#[pyclass(frozen, module = "adumbra._native")]
pub(crate) struct Baker {
    prepared: Prepared,
}

#[pymethods]
impl Baker {
    /// Bakes the parts with these ids whose entries are not in `cache`. Creates the folder if it does not
    /// exist. Returns for each part its id, the BLAKE3 of its entry, and whether it was baked; and the
    /// seconds.
    #[allow(clippy::type_complexity, reason = "what became of the parts")]
    fn bake(
        &self,
        py: Python<'_>,
        ids: Vec<usize>,
        cache: PathBuf,
        threads: Option<usize>,
        report: Option<Py<PyAny>>,
    ) -> PyResult<(Vec<(usize, String, bool)>, f64)> {
        watched(py, report, |watch| {
            let recorded = Arc::new(Recorded { cache: DiskCache::create(cache)?, last: Mutex::default() });
            let cache = Arc::clone(&recorded) as Arc<dyn BakeCache>;
            let pool = pool(threads)?;
            let bake = || self.prepared.with_dependent(|_, baker| baker.bake(&ids, &cache, watch));
            let done = pool.install(bake)?;
            let last = recorded.last.lock().unwrap_or_else(PoisonError::into_inner);
            let parts = self.prepared.borrow_owner().1.plan.parts();
            let of = |id: usize| {
                let (sum, is_made) = last.get(parts[id].key())?;
                Some((id, sum.to_string(), *is_made))
            };
            Ok((ids.iter().filter_map(|&id| of(id)).collect(), done.seconds))
        })
    }
}

/// A cache that records, for each key, the hash of the entry that was last read or written, and whether it
/// was written.
#[derive(Debug)]
struct Recorded {
    cache: DiskCache,
    last: Mutex<HashMap<CacheKey, (blake3::Hash, bool)>>,
}

impl Recorded {
    fn tell(&self, key: &CacheKey, bytes: &[u8], is_made: bool) {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        last.insert(*key, (blake3::hash(bytes), is_made));
    }
}

impl BakeCache for Recorded {
    fn get(&self, key: &CacheKey, most_bytes: u64) -> Result<Fetched, IoError> {
        let found = self.cache.get(key, most_bytes)?;
        if let Fetched::Whole(bytes) = &found {
            self.tell(key, bytes, false);
        }
        Ok(found)
    }

    fn put(&self, key: &CacheKey, bytes: &[u8]) -> Result<(), IoError> {
        self.cache.put(key, bytes)?;
        self.tell(key, bytes, true);
        Ok(())
    }
}

/// A cache in which some entries must have a known hash. An entry with another hash counts as missing.
#[derive(Debug)]
struct Checked {
    cache: DiskCache,
    sums: HashMap<CacheKey, String>,
}

impl BakeCache for Checked {
    fn get(&self, key: &CacheKey, most_bytes: u64) -> Result<Fetched, IoError> {
        let found = self.cache.get(key, most_bytes)?;
        match (&found, self.sums.get(key)) {
            (Fetched::Whole(bytes), Some(sum)) if *sum != blake3::hash(bytes).to_string() => {
                Ok(Fetched::Nothing)
            }
            _ => Ok(found),
        }
    }

    fn put(&self, key: &CacheKey, bytes: &[u8]) -> Result<(), IoError> {
        self.cache.put(key, bytes)
    }
}
