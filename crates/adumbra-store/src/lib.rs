//! A bake cache in a store that many machines share: S3, Google Cloud Storage, Azure Blob Storage, an HTTP
//! server, or any other store that the crate `object_store` supports.
//!
//! ```no_run
//! use adumbra_bake::Bake;
//! use adumbra_store::StoreCache;
//!
//! let scene = adumbra_scene::load("city.glb".as_ref(), &adumbra_scene::LoadOptions::default())?;
//! let sun = adumbra::Sun::from_direction([0.5, 0.8, 0.35])?;
//! let cache = StoreCache::open("s3://bucket/city")?;
//! Bake::new(&scene, sun).resolution(65_536).cache(cache).save("city.adumbra")?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::error::Error as _;
use std::fmt;
use std::future::Future;
use std::io::{self, ErrorKind};
use std::path::PathBuf;
use std::sync::Arc;

use adumbra::IoError;
use adumbra_bake::{BakeCache, CacheKey, CacheReport, ENTRY_MAGIC, Fetched};
use object_store::path::Path;
use object_store::{Error, ObjectMeta, ObjectStore, ObjectStoreExt, PutMode, PutOptions, PutPayload};
use tokio::runtime::{Builder, Runtime};
use url::Url;

/// Entries in a store, below a URL: `ab/cdef….entry` for the key `abcdef…`.
pub struct StoreCache {
    /// The store's name in messages: the URL without a password.
    name: String,
    store: Arc<dyn ObjectStore>,
    below: Path,
    runtime: Runtime,
}

impl fmt::Debug for StoreCache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("StoreCache").field(&self.name).finish()
    }
}

impl StoreCache {
    /// Opens a store: `s3://bucket/prefix`, `gs://bucket/prefix`, `az://container/prefix`,
    /// `https://server/folder` and so on. Other settings, such as `AWS_ACCESS_KEY_ID`, `AWS_ENDPOINT` and
    /// `AWS_ALLOW_HTTP`, come from the process's environment, under the names that the crate `object_store`
    /// defines. Nothing is read yet.
    ///
    /// # Errors
    /// Returns [`IoError`] if the URL does not name a store.
    pub fn open(url: &str) -> Result<Self, IoError> {
        let parsed = Url::parse(url);
        let mut shown = parsed.clone().map_or_else(|_| url.to_owned(), |url| url.to_string());
        if let Ok(mut url) = parsed.clone()
            && url.set_password(None).is_ok()
        {
            shown = url.to_string();
        }
        let refuse = |error: String| {
            let what = format!("{error}; give a folder, or a URL such as s3://bucket/prefix");
            IoError::at("open", &shown)(io::Error::new(ErrorKind::InvalidInput, what))
        };
        let parsed = parsed.map_err(|error| refuse(error.to_string()))?;
        // An error means that the process has already chosen a provider. That provider is used.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let environment = std::env::vars().map(|(name, value)| (name.to_ascii_lowercase(), value));
        let (store, below) =
            object_store::parse_url_opts(&parsed, environment).map_err(|error| refuse(error.to_string()))?;
        Self::new(shown, Arc::from(store), below)
    }

    /// Uses a store of the crate `object_store` as a cache, below a path. Messages call it `name`.
    ///
    /// # Errors
    /// Returns [`IoError`] if no threads can be started.
    pub fn new(name: String, store: Arc<dyn ObjectStore>, below: Path) -> Result<Self, IoError> {
        let runtime = Builder::new_multi_thread().worker_threads(2).enable_all().build();
        let runtime = runtime.map_err(IoError::at("open", &name))?;
        Ok(Self { name, store, below, runtime })
    }

    /// Counts the entries, by their names.
    ///
    /// # Errors
    /// Returns [`IoError`] if the store cannot be read.
    pub fn contents(&self) -> Result<CacheReport, IoError> {
        let mut found = CacheReport::default();
        for ObjectMeta { size, .. } in self.list()? {
            found.entries += 1;
            found.bytes += size;
        }
        Ok(found)
    }

    /// Removes entries until at most `most_bytes` remain. The entries that were written longest ago go first,
    /// because stores do not record reads. Returns the removed entries. Entries that cannot be removed stay.
    ///
    /// # Errors
    /// Returns [`IoError`] if the store cannot be read.
    pub fn prune(&self, most_bytes: u64) -> Result<CacheReport, IoError> {
        let mut list = self.list()?;
        list.sort_by(|a, b| (a.last_modified, &a.location).cmp(&(b.last_modified, &b.location)));
        let mut left: u64 = list.iter().map(|object| object.size).sum();
        let mut removed = CacheReport::default();
        for ObjectMeta { location, size, .. } in list {
            if left <= most_bytes {
                break;
            }
            match self.wait(self.remove(&location, size)) {
                Ok(true) => {
                    left -= size;
                    removed.entries += 1;
                    removed.bytes += size;
                }
                Ok(false) => left -= size,
                Err(error) => removed.failures.push(self.failed("remove", &location, error)),
            }
        }
        Ok(removed)
    }

    /// Removes an entry. Returns `false` if the path holds something else, or another process has removed the
    /// entry.
    async fn remove(&self, path: &Path, size: u64) -> Result<bool, Error> {
        let length = size.min(ENTRY_MAGIC.len() as u64);
        if length > 0 {
            match self.store.get_range(path, 0..length).await {
                Ok(magic) if *magic == ENTRY_MAGIC[..] => {}
                Ok(_) | Err(Error::NotFound { .. }) => return Ok(false),
                Err(error) => return Err(error),
            }
        }
        match self.store.delete(path).await {
            Ok(()) => Ok(true),
            // Another process has removed the entry already.
            Err(Error::NotFound { .. }) => Ok(false),
            Err(error) => Err(error),
        }
    }

    fn list(&self) -> Result<Vec<ObjectMeta>, IoError> {
        let mut folders = vec![self.below.clone()];
        let mut found = Vec::new();
        // Entries are two levels below the root. Ignore everything else in the store.
        for _ in 0..2 {
            for folder in std::mem::take(&mut folders) {
                let listed = self.wait(self.store.list_with_delimiter(Some(&folder)));
                let listed = listed.map_err(|error| self.failed("list", &folder, error))?;
                folders.extend(listed.common_prefixes);
                let is_entry = |object: &ObjectMeta| self.key_of(&object.location).is_some();
                found.extend(listed.objects.into_iter().filter(is_entry));
            }
        }
        Ok(found)
    }

    fn path(&self, key: &CacheKey) -> Path {
        let name = key.to_string();
        let (folder, rest) = name.split_at(2);
        self.below.clone().join(folder).join(format!("{rest}.entry"))
    }

    /// Returns the key of the entry at a path.
    fn key_of(&self, path: &Path) -> Option<CacheKey> {
        let parts: Vec<_> = path.prefix_match(&self.below)?.collect();
        let [first, rest] = &parts[..] else { return None };
        let rest = rest.as_ref().strip_suffix(".entry")?;
        (first.as_ref().len() == 2).then(|| format!("{}{rest}", first.as_ref()).parse().ok())?
    }

    fn wait<T>(&self, work: impl Future<Output = T>) -> T {
        self.runtime.block_on(work)
    }

    async fn read(&self, path: &Path, most_bytes: u64) -> Result<Fetched, Error> {
        let found = self.store.get(path).await?;
        // The contents are fetched only when they are read.
        if found.meta.size > most_bytes {
            return Ok(Fetched::TooLong(found.meta.size));
        }
        Ok(Fetched::Whole(found.bytes().await?.to_vec()))
    }

    /// Writes an entry if there is none. An entry with the same bytes is kept. An entry with other bytes is
    /// damaged, and is replaced.
    async fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), Error> {
        let payload = || PutPayload::from(bytes.to_vec());
        let create = PutOptions { mode: PutMode::Create, ..PutOptions::default() };
        match self.store.put_opts(path, payload(), create).await {
            Ok(_) => return Ok(()),
            Err(Error::AlreadyExists { .. } | Error::Precondition { .. }) => {
                let found = self.read(path, bytes.len() as u64).await;
                if matches!(found, Ok(Fetched::Whole(found)) if found == bytes) {
                    return Ok(());
                }
            }
            Err(Error::NotImplemented { .. } | Error::NotSupported { .. }) => {}
            Err(error) => return Err(error),
        }
        self.store.put(path, payload()).await.map(|_| ())
    }

    fn failed(&self, action: &'static str, path: &Path, error: Error) -> IoError {
        let kind = match &error {
            Error::NotFound { .. } => ErrorKind::NotFound,
            Error::PermissionDenied { .. } | Error::Unauthenticated { .. } => ErrorKind::PermissionDenied,
            Error::NotImplemented { .. } | Error::NotSupported { .. } => ErrorKind::Unsupported,
            _ => kind_of_cause(&error),
        };
        let place = format!("{}/{}", self.name.trim_end_matches('/'), path.filename().unwrap_or_default());
        IoError::at(action, PathBuf::from(place))(io::Error::new(kind, error))
    }
}

/// Returns the kind of the I/O error that caused another error. Without such a cause, the request has failed
/// repeatedly on its way to the store, and may succeed later.
fn kind_of_cause(error: &Error) -> ErrorKind {
    let mut cause = error.source();
    while let Some(inner) = cause {
        if let Some(found) = inner.downcast_ref::<io::Error>() {
            return found.kind();
        }
        cause = inner.source();
    }
    ErrorKind::TimedOut
}

impl BakeCache for StoreCache {
    fn get(&self, key: &CacheKey, most_bytes: u64) -> Result<Fetched, IoError> {
        let path = self.path(key);
        match self.wait(self.read(&path, most_bytes)) {
            Ok(found) => Ok(found),
            Err(Error::NotFound { .. }) => Ok(Fetched::Nothing),
            Err(error) => Err(self.failed("read", &path, error)),
        }
    }

    fn put(&self, key: &CacheKey, bytes: &[u8]) -> Result<(), IoError> {
        let path = self.path(key);
        self.wait(self.write(&path, bytes)).map_err(|error| self.failed("write", &path, error))
    }
}
