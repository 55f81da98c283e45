//! Finished pages until they are linked: in memory as far as there is room, else in a temporary file.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

use adumbra::IoError;

use crate::error::{Error, Result};

/// Room for pages in memory and, beyond that, on disk.
///
/// All stores of a bake share it. A disk failure is recorded: users of the pages must call [`Spill::check`]
/// from time to time, and at the end.
pub(crate) struct Spill {
    folder: PathBuf,
    /// Bytes that pages may occupy in memory.
    room_bytes: AtomicU64,
    /// Bytes that pages do occupy in memory.
    resident_bytes: AtomicU64,
    spilled_bytes: AtomicU64,
    file: Mutex<Option<File>>,
    failure: Mutex<Option<(&'static str, io::Error)>>,
}

impl Spill {
    /// Creates a spill with `room_bytes` in memory. Further pages go to an unnamed file in `folder`, which is
    /// created when it is needed.
    pub(crate) fn new(room_bytes: u64, folder: PathBuf) -> Self {
        Self {
            folder,
            room_bytes: room_bytes.into(),
            resident_bytes: AtomicU64::new(0),
            spilled_bytes: AtomicU64::new(0),
            file: Mutex::default(),
            failure: Mutex::default(),
        }
    }

    /// Creates a spill that never writes to disk.
    pub(crate) fn unlimited() -> Self {
        Self::new(u64::MAX, PathBuf::new())
    }

    /// Bytes of pages in memory.
    pub(crate) fn resident_bytes(&self) -> u64 {
        self.resident_bytes.load(Ordering::Relaxed)
    }

    /// Bytes written to disk so far.
    pub(crate) fn spilled_bytes(&self) -> u64 {
        self.spilled_bytes.load(Ordering::Relaxed)
    }

    /// Limits the memory for pages to `room_bytes`. Pages that are in memory stay there until
    /// [`PageStore::shrink`].
    pub(crate) fn limit_to(&self, room_bytes: u64) {
        self.room_bytes.fetch_min(room_bytes, Ordering::Relaxed);
    }

    /// Whether the pages in memory exceed the room, because it was reduced.
    fn is_overfull(&self) -> bool {
        self.resident_bytes() > self.room_bytes.load(Ordering::Relaxed)
    }

    /// Counts this many more bytes as resident, if there is room for them.
    fn takes(&self, bytes: u64) -> bool {
        let room = self.room_bytes.load(Ordering::Relaxed);
        let more = |resident: u64| resident.checked_add(bytes).filter(|&sum| sum <= room);
        self.resident_bytes.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more).is_ok()
    }

    /// Checks that all pages could be kept.
    ///
    /// # Errors
    /// Returns [`Error::Spill`] with the folder. The first call has the cause; later calls only report that
    /// there was an error.
    pub(crate) fn check(&self) -> Result<()> {
        match lock(&self.failure).as_mut() {
            None => Ok(()),
            Some((action, source)) => {
                let cause = std::mem::replace(source, io::Error::other("an earlier write failed"));
                Err(Error::Spill(IoError { action, path: self.folder.clone(), source: cause }))
            }
        }
    }

    /// Returns the value. Records an error, unless there is one already.
    fn or_record<T>(&self, action: &'static str, result: io::Result<T>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(error) => {
                lock(&self.failure).get_or_insert((action, error));
                None
            }
        }
    }

    /// Appends words to the file, and returns their offset. `None` after a failure.
    fn write(&self, words: &[u32]) -> Option<u64> {
        let mut slot = lock(&self.file);
        let file = match slot.as_mut() {
            Some(file) => file,
            None => {
                let made = tempfile::tempfile_in(&self.folder);
                slot.insert(self.or_record("create a temporary file in", made)?)
            }
        };
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let offset = file.seek(SeekFrom::End(0)).and_then(|at| file.write_all(&bytes).map(|()| at));
        let offset = self.or_record("write a temporary file in", offset)?;
        self.spilled_bytes.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        Some(offset)
    }

    /// Reads words back. `None` after a failure.
    fn read(&self, offset: u64, words: usize) -> Option<Vec<u32>> {
        let mut bytes = vec![0; 4 * words];
        let found = match lock(&self.file).as_mut() {
            Some(file) => file.seek(SeekFrom::Start(offset)).and_then(|_| file.read_exact(&mut bytes)),
            None => Err(io::ErrorKind::NotFound.into()),
        };
        self.or_record("read a temporary file in", found)?;
        Some(bytes.as_chunks().0.iter().map(|&b| u32::from_le_bytes(b)).collect())
    }
}

/// A finished page.
struct Stored {
    /// Address of the root.
    root: u32,
    words: Words,
}

enum Words {
    Here(Arc<[u32]>),
    OnDisk {
        offset: u64,
        count: u32,
    },
    /// The page was lost, or is not needed any more.
    Gone,
}

/// Pages, each under a number.
pub(crate) struct PageStore {
    spill: Arc<Spill>,
    pages: Mutex<Vec<Stored>>,
    /// Half-words of all pages.
    halves: AtomicU64,
}

impl PageStore {
    pub(crate) fn new(spill: Arc<Spill>) -> Self {
        Self { spill, pages: Mutex::default(), halves: AtomicU64::new(0) }
    }

    pub(crate) fn spill(&self) -> &Spill {
        &self.spill
    }

    /// Bytes of everything but the pages themselves.
    pub(crate) fn table_bytes(&self) -> u64 {
        (lock(&self.pages).capacity() * size_of::<Stored>()) as u64
    }

    /// Half-words of all pages.
    pub(crate) fn halves(&self) -> u64 {
        self.halves.load(Ordering::Relaxed)
    }

    /// Returns the bytes of a page's words. 0 if it was lost, or is not needed any more.
    pub(crate) fn page_bytes(&self, number: u32) -> u64 {
        4 * match &lock(&self.pages)[number as usize].words {
            Words::Here(words) => words.len() as u64,
            Words::OnDisk { count, .. } => u64::from(*count),
            Words::Gone => 0,
        }
    }

    /// Adds a page and returns its number. The numbers depend on the order of calls.
    pub(crate) fn add(&self, root: u32, words: Vec<u32>) -> u32 {
        self.halves.fetch_add(2 * words.len() as u64, Ordering::Relaxed);
        let words = if self.spill.takes(4 * words.len() as u64) {
            Words::Here(words.into())
        } else {
            self.spilled(&words)
        };
        let mut pages = lock(&self.pages);
        pages.push(Stored { root, words });
        pages.len() as u32 - 1
    }

    fn spilled(&self, words: &[u32]) -> Words {
        let count = words.len() as u32;
        self.spill.write(words).map_or(Words::Gone, |offset| Words::OnDisk { offset, count })
    }

    /// Moves pages to disk until they fit the room that the spill has.
    pub(crate) fn shrink(&self) {
        for page in lock(&self.pages).iter_mut() {
            if !self.spill.is_overfull() {
                break;
            }
            if let Words::Here(words) = &page.words {
                let bytes = 4 * words.len() as u64;
                page.words = self.spilled(words);
                self.spill.resident_bytes.fetch_sub(bytes, Ordering::Relaxed);
            }
        }
    }

    /// Returns a page's words and the address of its root. `None` if it was lost.
    pub(crate) fn get(&self, number: u32) -> Option<(Arc<[u32]>, u32)> {
        let (root, offset, count) = match lock(&self.pages).get(number as usize)? {
            Stored { root, words: Words::Here(words) } => return Some((Arc::clone(words), *root)),
            Stored { root, words: Words::OnDisk { offset, count } } => (*root, *offset, *count),
            Stored { words: Words::Gone, .. } => return None,
        };
        let words = self.spill.read(offset, count as usize)?;
        Some((words.into(), root))
    }

    /// Frees the memory of a page that is not needed any more.
    pub(crate) fn forget(&self, number: u32) {
        let page = &mut lock(&self.pages)[number as usize];
        if let Words::Here(words) = std::mem::replace(&mut page.words, Words::Gone) {
            self.spill.resident_bytes.fetch_sub(4 * words.len() as u64, Ordering::Relaxed);
        }
    }
}

fn lock<T>(slot: &Mutex<T>) -> MutexGuard<'_, T> {
    slot.lock().unwrap_or_else(|e| e.into_inner())
}
