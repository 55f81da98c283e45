//! The place of a bake cache: a folder, or a store that a URL names.

use std::path::Path;
use std::sync::Arc;

use adumbra_bake::{BakeCache, BestEffortCache, CacheReport, DiskCache};
use adumbra_program::exit::Failure;
#[cfg(feature = "stores")]
use adumbra_store::StoreCache;

/// A folder or a store.
pub(super) enum Store {
    Folder(DiskCache),
    #[cfg(feature = "stores")]
    Remote(StoreCache),
}

impl Store {
    /// Opens an existing folder, or a store.
    pub(super) fn open(place: &Path) -> Result<Self, Failure> {
        match url_of(place) {
            Some(url) => Self::remote(url),
            None => Ok(Self::Folder(DiskCache::open(place)?)),
        }
    }

    pub(super) fn contents(&self) -> Result<CacheReport, Failure> {
        Ok(match self {
            Self::Folder(folder) => folder.contents()?,
            #[cfg(feature = "stores")]
            Self::Remote(store) => store.contents()?,
        })
    }

    pub(super) fn prune(&self, most_bytes: u64) -> Result<CacheReport, Failure> {
        Ok(match self {
            Self::Folder(folder) => folder.prune(most_bytes)?,
            #[cfg(feature = "stores")]
            Self::Remote(store) => store.prune(most_bytes)?,
        })
    }

    #[cfg(feature = "stores")]
    fn remote(url: &str) -> Result<Self, Failure> {
        Ok(Self::Remote(StoreCache::open(url)?))
    }

    #[cfg(not(feature = "stores"))]
    fn remote(url: &str) -> Result<Self, Failure> {
        Err(Failure::Usage(format!(
            "{url}: this program was built without the feature stores; give a folder, or build it with that feature"
        )))
    }
}

/// Returns a place as a URL, if it is one.
pub(super) fn url_of(place: &Path) -> Option<&str> {
    // A single letter is a drive of Windows, not a scheme.
    place.to_str().filter(|text| text.split_once("://").is_some_and(|(scheme, _)| scheme.len() > 1))
}

/// Opens a cache. A folder is created if it does not exist.
pub(super) fn open_or_create(place: &Path) -> Result<Arc<dyn BakeCache>, Failure> {
    if url_of(place).is_none() {
        return Ok(Arc::new(DiskCache::create(place)?));
    }
    Ok(match Store::open(place)? {
        Store::Folder(folder) => Arc::new(folder),
        #[cfg(feature = "stores")]
        Store::Remote(store) => Arc::new(store),
    })
}

/// Opens the cache of `--cache`, if the option is given. The first failure of the cache is reported as a
/// warning; the bake goes on without it.
pub(super) fn best_effort_cache(place: Option<&Path>) -> Result<Option<BestEffortCache>, Failure> {
    let Some(place) = place else { return Ok(None) };
    let named = place.display().to_string();
    let opened = open_or_create(place).map_err(|failure| Failure::Other {
        code: failure.code(),
        message: format!("--cache {named}: {failure}; give a folder of its own, or leave the option out"),
    });
    Ok(Some(BestEffortCache::new(opened?, move |error| {
        adumbra_program::note!(
            "warning: --cache {named}: {error}; the bake goes on without what the cache cannot do"
        );
    })))
}
