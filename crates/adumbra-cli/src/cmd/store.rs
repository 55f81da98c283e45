//! Where objects are kept: a folder, or a store that a URL names.

use std::path::Path;
use std::sync::Arc;

use adumbra_bake::{CachedObjects, FolderObjects, FolderReport, Objects};
use adumbra_program::exit::Failure;
#[cfg(feature = "stores")]
use adumbra_store::StoreObjects;

/// A folder or a store.
pub(super) enum Store {
    Folder(FolderObjects),
    #[cfg(feature = "stores")]
    Remote(StoreObjects),
}

impl Store {
    /// Opens a folder that is there, or a store.
    pub(super) fn open(place: &Path) -> Result<Self, Failure> {
        match url_of(place) {
            Some(url) => Self::remote(url),
            None => Ok(Self::Folder(FolderObjects::open(place)?)),
        }
    }

    pub(super) fn contents(&self) -> Result<FolderReport, Failure> {
        Ok(match self {
            Self::Folder(folder) => folder.contents()?,
            #[cfg(feature = "stores")]
            Self::Remote(store) => store.contents()?,
        })
    }

    pub(super) fn prune(&self, most_bytes: u64) -> Result<FolderReport, Failure> {
        Ok(match self {
            Self::Folder(folder) => folder.prune(most_bytes)?,
            #[cfg(feature = "stores")]
            Self::Remote(store) => store.prune(most_bytes)?,
        })
    }

    #[cfg(feature = "stores")]
    fn remote(url: &str) -> Result<Self, Failure> {
        Ok(Self::Remote(StoreObjects::open(url)?))
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
    // One letter would be a drive.
    place.to_str().filter(|text| text.split_once("://").is_some_and(|(scheme, _)| scheme.len() > 1))
}

/// Opens a folder or a store. A folder is created if it is not there.
pub(super) fn objects(place: &Path) -> Result<Arc<dyn Objects>, Failure> {
    if url_of(place).is_none() {
        return Ok(Arc::new(FolderObjects::create(place)?));
    }
    Ok(match Store::open(place)? {
        Store::Folder(folder) => Arc::new(folder),
        #[cfg(feature = "stores")]
        Store::Remote(store) => Arc::new(store),
    })
}

/// Opens the folder or store of `--cache`, if it is given. Whatever fails later is said once, and the bake goes on without
/// it.
pub(super) fn cache(place: Option<&Path>) -> Result<Option<CachedObjects>, Failure> {
    let Some(place) = place else { return Ok(None) };
    let named = place.display().to_string();
    let opened = objects(place).map_err(|failure| Failure::Other {
        code: failure.code(),
        message: format!("--cache {named}: {failure}; give a folder of its own, or leave the option out"),
    });
    Ok(Some(CachedObjects::new(opened?, move |error| {
        adumbra_program::note!(
            "warning: --cache {named}: {error}; the bake goes on without what the cache cannot do"
        );
    })))
}
