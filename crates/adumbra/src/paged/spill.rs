//! Pages of vectors that may outgrow memory: the most recently used stay, the others lie in temporary files.
//!
//! Pages are dealt to eight banks in turn, each behind a lock and with a file of its own, which has no name and goes away
//! with it. A bank's resident pages stand in one allocation, so that what it gives up goes back to the system. Which page
//! leaves is chosen by second chance (Corbató, *A Paging Experiment with the Multics System*, 1968).

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard};

use crate::error::{Error, Result};

pub(crate) const PAGE_BYTES: usize = 1 << 14;
const BANKS: usize = 8;
/// No frame, or no page.
const NONE: u32 = u32::MAX;

/// Room for pages, in memory and, beyond that, on disk.
///
/// A failure of the disk is kept, and lost pages read as zeros: whoever uses the pages asks [`Spill::check`] now and then.
pub(crate) struct Spill {
    banks: [Mutex<Bank>; BANKS],
    next_page: AtomicU32,
    /// Bytes that pages may take in memory.
    room_bytes: AtomicU64,
    spilled_bytes: AtomicU64,
    folder: PathBuf,
    failed: AtomicBool,
    failure: Mutex<Option<(&'static str, io::Error)>>,
}

#[derive(Default)]
struct Bank {
    /// Bytes that frames may take.
    room: usize,
    frames: Vec<u8>,
    /// By frame that was ever in use: its page in this bank, or [`NONE`].
    owners: Vec<u32>,
    marks: Vec<Marks>,
    /// Frames whose pages are gone.
    free: Vec<u32>,
    hand: usize,
    /// By page: its frame, or [`NONE`].
    places: Vec<u32>,
    file: Option<File>,
}

#[derive(Clone, Copy, Default)]
struct Marks {
    /// Used since the hand last passed.
    used: bool,
    /// The file has something else, or nothing.
    dirty: bool,
}

impl Spill {
    /// The least that pages take in memory.
    pub(crate) const LEAST_BYTES: u64 = (BANKS * PAGE_BYTES) as u64;

    /// Room for `room_bytes` in memory, [`Spill::LEAST_BYTES`] at least, and for the rest in files in `folder`, made when
    /// they are needed.
    pub(crate) fn new(room_bytes: u64, folder: PathBuf) -> Self {
        let room_bytes = room_bytes.max(Self::LEAST_BYTES);
        let bank = || {
            let mut bank = Bank { room: bank_bytes(room_bytes), ..Bank::default() };
            // Address space, not memory, so that frames never move; where the system has not so much, they do.
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

    /// Bytes written to disk so far, a page as often as it was written.
    pub(crate) fn spilled_bytes(&self) -> u64 {
        self.spilled_bytes.load(Ordering::Relaxed)
    }

    /// Pages get so much less room in memory, as long as there is any: something else needs it.
    pub(crate) fn give_up(&self, bytes: u64) {
        let less = |room: u64| Some(room.saturating_sub(bytes).max(Self::LEAST_BYTES));
        let before = self.room_bytes.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less);
        self.shrink_to(before.unwrap_or_else(|room| room).saturating_sub(bytes));
    }

    /// Pages get no more room in memory than this, or [`Spill::LEAST_BYTES`].
    pub(crate) fn shrink_to(&self, room_bytes: u64) {
        let room_bytes = room_bytes.max(Self::LEAST_BYTES);
        self.room_bytes.fetch_min(room_bytes, Ordering::Relaxed);
        for bank in &self.banks {
            lock(bank).shrink(bank_bytes(room_bytes), self);
        }
    }

    pub(crate) fn has_failed(&self) -> bool {
        self.failed.load(Ordering::Relaxed)
    }

    /// Whether all pages could be kept.
    ///
    /// # Errors
    /// [`Error::Io`] with the folder, the first time; later calls say that there was an error.
    pub(crate) fn check(&self) -> Result<()> {
        if !self.has_failed() {
            return Ok(());
        }
        let failure = self.failure.lock().unwrap_or_else(|e| e.into_inner()).take();
        let (action, source) = failure.unwrap_or_else(|| ("write", io::Error::other("it failed before")));
        let what = format!("{source}; the bake keeps there what --max-memory has no room for");
        let source = io::Error::new(source.kind(), what);
        Err(Error::Io { action, path: self.folder.clone(), source })
    }

    /// A new page of zeros.
    pub(super) fn new_page(&self) -> u32 {
        let page = self.next_page.fetch_add(1, Ordering::Relaxed);
        let (bank, index) = place(page);
        let mut bank = lock(&self.banks[bank]);
        if bank.places.len() <= index {
            bank.places.resize(index + 1, NONE);
        }
        let frame = bank.take_frame(self);
        bank.bytes(frame).fill(0);
        bank.settle(index, frame, Marks { used: true, dirty: true });
        page
    }

    /// Has `read` look at the bytes of a page.
    pub(super) fn read<R>(&self, page: u32, read: impl FnOnce(&[u8]) -> R) -> R {
        let (bank, index) = place(page);
        let mut bank = lock(&self.banks[bank]);
        let frame = bank.frame_of(index, self);
        read(bank.bytes(frame))
    }

    /// Has `write` change the bytes of a page.
    pub(super) fn write(&self, page: u32, write: impl FnOnce(&mut [u8])) {
        let (bank, index) = place(page);
        let mut bank = lock(&self.banks[bank]);
        let frame = bank.frame_of(index, self);
        bank.marks[frame].dirty = true;
        write(bank.bytes(frame));
    }

    /// Nothing will ask for the page any more.
    pub(super) fn drop_page(&self, page: u32) {
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

    fn settle(&mut self, index: usize, frame: usize, marks: Marks) {
        self.places[index] = frame as u32;
        self.owners[frame] = index as u32;
        self.marks[frame] = marks;
    }

    /// The frame of a page, which is read if it has none.
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
            // Once something is lost, nothing comes back: what was read as zeros stays so.
            _ if spill.has_failed() => Err(io::ErrorKind::Other.into()),
            Some(file) => seek(file, index).and_then(|file| file.read_exact(bytes)),
            None => Err(io::ErrorKind::NotFound.into()),
        };
        if let Err(error) = found {
            bytes.fill(0);
            spill.fail("read", error);
        }
        self.settle(index, frame, Marks { used: true, dirty: false });
        frame
    }

    /// A frame without a page.
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

    /// Takes the page from a frame, written if need be.
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

    /// No more frames than this.
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

/// A page's bank, and its number there.
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
