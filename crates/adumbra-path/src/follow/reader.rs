//! Plays a baked path: reads its keys in the background when they are needed.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

use adumbra::{ShadowFile, SunPath};

use super::moment::{Followed, Shown};
use crate::error::{Error, Result};

/// Reads the keys of a path file while its day plays: those around the moment, and the one after them.
///
/// Cost: a call of [`PathReader::follow`] takes microseconds. At most three keys are kept, and one thread
/// decodes.
pub struct PathReader {
    path: SunPath,
    jobs: Sender<usize>,
    done: Receiver<(usize, adumbra::Result<ShadowFile>)>,
    asked: Option<usize>,
    read: Vec<(usize, Arc<ShadowFile>)>,
    shown: Shown,
    fault: Option<Error>,
}

impl PathReader {
    /// Starts to read. `on_key` is called on the reader's thread when a key has been read, for example to
    /// wake a sleeping event loop.
    ///
    /// # Errors
    /// Returns an error if the operating system gives no thread.
    pub fn start(path: SunPath, on_key: impl Fn() + Send + 'static) -> Result<Self> {
        let (jobs, asked) = channel::<usize>();
        let (send, done) = channel();
        let source = path.clone();
        thread::Builder::new().name("adumbra-keys".to_owned()).spawn(move || {
            for index in asked {
                if send.send((index, source.key(index))).is_err() {
                    return;
                }
                on_key();
            }
        })?;
        Ok(Self { path, jobs, done, asked: None, read: Vec::new(), shown: Shown::default(), fault: None })
    }

    /// Returns the path.
    pub fn path(&self) -> &SunPath {
        &self.path
    }

    /// Returns the keys that answer at a moment, in the path's seconds, and continues reading. Until both
    /// keys around the moment have been read, a key that is available answers.
    pub fn follow(&mut self, seconds: f64) -> Followed {
        if let Ok((index, read)) = self.done.try_recv() {
            self.asked = None;
            match read {
                Ok(file) => self.read.push((index, Arc::new(file))),
                Err(error) => self.fault = Some(error.into()),
            }
        }
        let (Some(towards_sun), Some(around)) = (self.path.sun_at(seconds), self.path.keys_at(seconds))
        else {
            return Followed::Night;
        };
        let times = self.path.key_seconds();
        let later = around[0].max(around[1]);
        let next = if times[later] > seconds { later + 1 } else { later }.min(times.len() - 1);
        let wanted = [around[0], around[1], next];
        let missing = wanted.into_iter().find(|index| self.key(*index).is_none());
        if let Some(index) = missing.filter(|_| self.asked.is_none() && self.fault.is_none())
            && self.jobs.send(index).is_ok()
        {
            self.asked = Some(index);
        }
        let keys = match around.map(|index| self.key(index)) {
            [Some(first), Some(second)] => [first, second],
            [Some(key), None] | [None, Some(key)] => [Arc::clone(&key), key],
            [None, None] => {
                let distance = |index: usize| (times[index] - seconds).abs();
                let nearest = self.read.iter().min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)));
                let Some((_, key)) = nearest else { return Followed::Waiting };
                [Arc::clone(key), Arc::clone(key)]
            }
        };
        if around.iter().all(|index| self.key(*index).is_some()) {
            self.read.retain(|(index, _)| wanted.contains(index));
        }
        Followed::Moment(self.shown.moment(keys, towards_sun, 1))
    }

    /// Returns the error of a key that could not be read since the last call, and allows another try. Until
    /// this call, no more keys are read; those already read stay.
    pub fn take_fault(&mut self) -> Option<Error> {
        self.fault.take()
    }

    /// Whether a key is being read.
    pub fn is_reading(&self) -> bool {
        self.asked.is_some()
    }

    fn key(&self, index: usize) -> Option<Arc<ShadowFile>> {
        self.read.iter().find(|(known, _)| *known == index).map(|(_, file)| Arc::clone(file))
    }
}
