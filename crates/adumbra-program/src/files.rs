//! Reading of whole files within a limit on memory.

use std::path::Path;

use adumbra::file::FileMemory;
use adumbra::regions::Regions;
use adumbra::{Encoding, IoError, ShadowFile, SunPath};

use crate::exit::Failure;
use crate::memory::MemoryLimit;

impl MemoryLimit {
    /// Reads the shadow file at `path`.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] if the file cannot be read or does not fit into the limit.
    pub fn read_shadow_file(&self, path: &Path) -> Result<ShadowFile, Failure> {
        self.check_shadow_file(path)?;
        Ok(ShadowFile::read(path)?)
    }

    /// Checks that the shadow file at `path` fits into the limit. Reads only its first bytes.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] if it does not, or cannot be read.
    pub fn check_shadow_file(&self, path: &Path) -> Result<(), Failure> {
        self.check_files("the shadow file", || Ok(ShadowFile::memory(path)?.peak_bytes))
    }

    /// Reads the shadow file at `path`, to store it again in this encoding.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] if the file cannot be read, or if the file or its coding does not fit into the
    /// limit.
    pub fn read_to_store(&self, path: &Path, encoding: Encoding) -> Result<ShadowFile, Failure> {
        self.check_files("storing the shadow file", || {
            let FileMemory { peak_bytes, writing_bytes, .. } = ShadowFile::memory(path)?;
            Ok(if encoding == Encoding::Coded { peak_bytes.max(writing_bytes) } else { peak_bytes })
        })?;
        Ok(ShadowFile::read(path)?)
    }

    /// Reads a key of a sun path.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] if the key cannot be read or does not fit into the limit.
    pub fn read_key(&self, path: &SunPath, index: usize) -> Result<ShadowFile, Failure> {
        self.check_files("a key of the sun path", || Ok(path.key_memory(index)?.peak_bytes))?;
        Ok(path.key(index)?)
    }

    /// Checks that any two successive keys of a sun path fit into the limit.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] if they do not, or if one of them cannot be read.
    pub fn check_keys(&self, path: &SunPath) -> Result<(), Failure> {
        self.check_files("two keys of the sun path", || {
            let keys = 0..path.key_seconds().len();
            let keys = keys.map(|index| path.key_memory(index)).collect::<adumbra::Result<Vec<_>>>()?;
            let two = keys.iter().zip(keys.iter().skip(1)).map(|(first, second)| first.then(*second));
            Ok(two.chain(keys.first().copied()).map(|memory| memory.peak_bytes).max().unwrap_or_default())
        })
    }

    /// Checks that the files of all regions fit into the limit. `manifest` is the path that the manifest was
    /// read from.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] if they do not, or if one of them cannot be read.
    pub fn check_regions(&self, regions: &Regions, manifest: &Path) -> Result<(), Failure> {
        self.check_files("the regions' files", || Ok(regions.memory(manifest)?.peak_bytes))
    }

    /// Checks that the file at `path` fits into the limit, if its contents take as much memory as its bytes,
    /// and both are held at the same time.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] if it does not, or cannot be found.
    pub fn check_plain_file(&self, path: &Path) -> Result<(), Failure> {
        let bytes = std::fs::metadata(path).map_err(IoError::at("read", path))?.len();
        self.check_files("the file", || Ok(2 * bytes))
    }

    /// Without a limit, nothing is read twice, so a pipe can be given as a file.
    fn check_files(
        &self,
        what: &'static str,
        needed_bytes: impl FnOnce() -> adumbra::Result<u64>,
    ) -> Result<(), Failure> {
        if !self.is_given() {
            return Ok(());
        }
        match self.share(0).excess(needed_bytes()?) {
            Some([needed_bytes, limit_bytes]) => Err(Failure::FileMemory { what, needed_bytes, limit_bytes }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_shadow_file_only_within_the_memory_limit() {
        let path = adumbra_testing::vectors("valid/many_pages_depths.adumbra");
        let file = ShadowFile::read(&path).unwrap();
        assert!(MemoryLimit::new(None).read_shadow_file(&path).unwrap() == file);
        assert!(MemoryLimit::new(Some(1 << 40)).read_shadow_file(&path).unwrap() == file);
        let refused = MemoryLimit::new(Some(1)).read_shadow_file(&path);
        let Err(Failure::FileMemory { what, needed_bytes, .. }) = refused else { panic!("{refused:?}") };
        let least = ShadowFile::memory(&path).unwrap().peak_bytes;
        assert!(what == "the shadow file" && needed_bytes > least, "{what}: {needed_bytes}, not {least}");
    }
}
