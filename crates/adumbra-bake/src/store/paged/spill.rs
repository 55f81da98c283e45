//! Pages of vectors that may outgrow memory. The most recently used pages stay in memory; the others are in temporary
//! files.
//!
//! Pages are dealt to eight banks in turn. Each bank has its own lock and its own unnamed file, which disappears with
//! the bank. A bank's resident pages are in one allocation, so that memory it gives up returns to the system. The page
//! to evict is chosen by second chance (Corbató, *A Paging Experiment with the Multics System*, 1968).

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard};

use adumbra::IoError;

use crate::error::{Error, Result};

pub(crate) const PAGE_BYTES: usize = 1 << 14;
const BANKS: usize = 8;
/// No frame, or no page.
const NONE: u32 = u32::MAX;

/// Room for pages in memory and, beyond that, on disk.
///
/// A disk failure is recorded, and lost pages read as zeros. Users of the pages must call [`Spill::check`] from time to
/// time.
pub(crate) struct Spill {
    banks: [Mutex<Bank>; BANKS],
    next_page: AtomicU32,
    /// Bytes that pages may occupy in memory.
    room_bytes: AtomicU64,
    spilled_bytes: AtomicU64,
    folder: PathBuf,
    failed: AtomicBool,
    failure: Mutex<Option<(&'static str, io::Error)>>,
}

#[derive(Default)]
struct Bank {
    /// Bytes that frames may occupy.
    room: usize,
    frames: Vec<u8>,
    /// For each frame that was ever used: the index of its page in this bank, or [`NONE`].
    owners: Vec<u32>,
    marks: Vec<Marks>,
    /// Frames whose pages have been dropped.
    free: Vec<u32>,
    hand: usize,
    /// For each page: its frame, or [`NONE`].
    places: Vec<u32>,
    file: Option<File>,
}

#[derive(Clone, Copy, Default)]
struct Marks {
    /// Whether the page was used since the clock hand last passed.
    used: bool,
    /// Whether the file does not have the page's present content.
    dirty: bool,
}

impl Spill {
    /// The minimum memory that pages occupy.
    pub(crate) const MIN_BYTES: u64 = (BANKS * PAGE_BYTES) as u64;

    /// Creates a spill with `room_bytes` in memory, at least [`Spill::MIN_BYTES`]. The rest goes to files in `folder`,
    /// which are created when needed.
    pub(crate) fn new(room_bytes: u64, folder: PathBuf) -> Self {
        let room_bytes = room_bytes.max(Self::MIN_BYTES);
        let bank = || {
            let mut bank = Bank { room: bank_bytes(room_bytes), ..Bank::default() };
            // Reserves address space, not memory, so that frames never move. If the system refuses, they do move.
            let _ = bank.frames.try_reserve_exact(bank.room);
            bank
        };
        Self {
            banks: std::array::from_fn(|_| Mutex::new(bank())),
            next_page: AtomicU32::new(0),
            room_bytes: room_bytes.into(),
            spilled_bytes: AtomicU64::new(0),
            folder,
            failed: AtomicBool::new(false),
            failure: Mutex::default(),
        }
    }

    /// Bytes of pages in memory.
    pub(crate) fn resident_bytes(&self) -> u64 {
        let frames = |bank: &Mutex<Bank>| {
            let bank = lock(bank);
            bank.owners.len() - bank.free.len()
        };
        self.banks.iter().map(frames).sum::<usize>() as u64 * PAGE_BYTES as u64
    }

    /// Bytes written to disk so far; a page counts each time it is written.
    pub(crate) fn spilled_bytes(&self) -> u64 {
        self.spilled_bytes.load(Ordering::Relaxed)
    }

    /// Reduces the memory for pages by `bytes`, which are needed elsewhere, as far as it goes.
    pub(crate) fn give_up(&self, bytes: u64) {
        let less = |room: u64| Some(room.saturating_sub(bytes).max(Self::MIN_BYTES));
        let before = self.room_bytes.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less);
        self.shrink_to(before.unwrap_or_else(|room| room).saturating_sub(bytes));
    }

    /// Limits the memory for pages to `room_bytes`, or to [`Spill::MIN_BYTES`] if that is more.
    pub(crate) fn shrink_to(&self, room_bytes: u64) {
        let room_bytes = room_bytes.max(Self::MIN_BYTES);
        self.room_bytes.fetch_min(room_bytes, Ordering::Relaxed);
        for bank in &self.banks {
            lock(bank).shrink(bank_bytes(room_bytes), self);
        }
    }

    pub(crate) fn has_failed(&self) -> bool {
        self.failed.load(Ordering::Relaxed)
    }

    /// Checks that all pages could be kept.
    ///
    /// # Errors
    /// Returns [`Error::Spill`] with the folder. The first call has the cause; later calls only report that there was
    /// an error.
    pub(crate) fn check(&self) -> Result<()> {
        if !self.has_failed() {
            return Ok(());
        }
        let failure = self.failure.lock().unwrap_or_else(|e| e.into_inner()).take();
        let (action, source) =
            failure.unwrap_or_else(|| ("write", io::Error::other("an earlier write failed")));
        Err(Error::Spill(IoError { action, path: self.folder.clone(), source }))
    }

    /// Allocates a page of zeros.
    pub(crate) fn new_page(&self) -> u32 {
        let page = self.next_page.fetch_add(1, Ordering::Relaxed);
        let (bank, index) = place(page);
        let mut bank = lock(&self.banks[bank]);
        if bank.places.len() <= index {
            bank.places.resize(index + 1, NONE);
        }
        let frame = bank.take_frame(self);
        bank.bytes(frame).fill(0);
        bank.place(index, frame, Marks { used: true, dirty: true });
        page
    }

    /// Calls `read` with the bytes of a page.
    pub(crate) fn read<R>(&self, page: u32, read: impl FnOnce(&[u8]) -> R) -> R {
        let (bank, index) = place(page);
        let mut bank = lock(&self.banks[bank]);
        let frame = bank.frame_of(index, self);
        read(bank.bytes(frame))
    }

    /// Calls `write` with the bytes of a page, to change them.
    pub(crate) fn write(&self, page: u32, write: impl FnOnce(&mut [u8])) {
        let (bank, index) = place(page);
        let mut bank = lock(&self.banks[bank]);
        let frame = bank.frame_of(index, self);
        bank.marks[frame].dirty = true;
        write(bank.bytes(frame));
    }

    /// Releases a page, which must not be used afterwards.
    pub(crate) fn drop_page(&self, page: u32) {
        let (bank, index) = place(page);
        let mut bank = lock(&self.banks[bank]);
        let frame = std::mem::replace(&mut bank.places[index], NONE);
        if frame != NONE {
            bank.owners[frame as usize] = NONE;
            bank.free.push(frame);
        }
    }

    fn fail(&self, action: &'static str, error: io::Error) {
        self.failure.lock().unwrap_or_else(|e| e.into_inner()).get_or_insert((action, error));
        self.failed.store(true, Ordering::Relaxed);
    }
}

impl Bank {
    fn bytes(&mut self, frame: usize) -> &mut [u8] {
        &mut self.frames[frame * PAGE_BYTES..][..PAGE_BYTES]
    }

    fn place(&mut self, index: usize, frame: usize, marks: Marks) {
        self.places[index] = frame as u32;
        self.owners[frame] = index as u32;
        self.marks[frame] = marks;
    }

    /// Returns the frame of a page, and reads the page from disk if it has none.
    fn frame_of(&mut self, index: usize, spill: &Spill) -> usize {
        let frame = self.places[index];
        if frame != NONE {
            self.marks[frame as usize].used = true;
            return frame as usize;
        }
        let frame = self.take_frame(spill);
        let Self { frames, file, .. } = self;
        let bytes = &mut frames[frame * PAGE_BYTES..][..PAGE_BYTES];
        let found = match file {
            // After a loss nothing is read back: what was read as zeros stays zero.
            _ if spill.has_failed() => Err(io::ErrorKind::Other.into()),
            Some(file) => seek(file, index).and_then(|file| file.read_exact(bytes)),
            None => Err(io::ErrorKind::NotFound.into()),
        };
        if let Err(error) = found {
            bytes.fill(0);
            spill.fail("read", error);
        }
        self.place(index, frame, Marks { used: true, dirty: false });
        frame
    }

    /// Returns a frame without a page.
    fn take_frame(&mut self, spill: &Spill) -> usize {
        if let Some(frame) = self.free.pop() {
            return frame as usize;
        }
        let next = self.frames.len() + PAGE_BYTES;
        if next <= self.room {
            self.frames.resize(next, 0);
            self.owners.push(NONE);
            self.marks.push(Marks::default());
            return self.owners.len() - 1;
        }
        loop {
            self.hand = (self.hand + 1) % self.owners.len();
            if !std::mem::take(&mut self.marks[self.hand].used) {
                self.evict(self.hand, spill);
                return self.hand;
            }
        }
    }

    /// Removes the page from a frame, and writes it to disk if it is dirty.
    fn evict(&mut self, frame: usize, spill: &Spill) {
        let index = std::mem::replace(&mut self.owners[frame], NONE);
        if index == NONE {
            return;
        }
        self.places[index as usize] = NONE;
        if !self.marks[frame].dirty || spill.has_failed() {
            return;
        }
        let bytes = &self.frames[frame * PAGE_BYTES..][..PAGE_BYTES];
        let file = match &mut self.file {
            Some(file) => file,
            None => match tempfile::tempfile_in(&spill.folder) {
                Ok(file) => self.file.insert(file),
                Err(error) => return spill.fail("create a temporary file in", error),
            },
        };
        match seek(file, index as usize).and_then(|file| file.write_all(bytes)) {
            Ok(()) => {
                spill.spilled_bytes.fetch_add(PAGE_BYTES as u64, Ordering::Relaxed);
            }
            Err(error) => spill.fail("write a temporary file in", error),
        }
    }

    /// Reduces the frames to this many bytes.
    fn shrink(&mut self, bytes: usize, spill: &Spill) {
        if bytes >= self.room {
            return;
        }
        self.room = bytes;
        let frames = bytes / PAGE_BYTES;
        for frame in frames..self.owners.len() {
            self.evict(frame, spill);
        }
        self.owners.truncate(frames);
        self.marks.truncate(frames);
        self.free.retain(|&frame| (frame as usize) < frames);
        self.frames.truncate(bytes);
        self.frames.shrink_to(bytes);
    }
}

/// Bytes of each bank.
fn bank_bytes(room_bytes: u64) -> usize {
    (room_bytes as usize / BANKS / PAGE_BYTES).max(1) * PAGE_BYTES
}

/// Returns a page's bank and its index there.
fn place(page: u32) -> (usize, usize) {
    (page as usize % BANKS, page as usize / BANKS)
}

fn seek(file: &mut File, index: usize) -> io::Result<&mut File> {
    file.seek(SeekFrom::Start(index as u64 * PAGE_BYTES as u64))?;
    Ok(file)
}

fn lock(bank: &Mutex<Bank>) -> MutexGuard<'_, Bank> {
    bank.lock().unwrap_or_else(|e| e.into_inner())
}
