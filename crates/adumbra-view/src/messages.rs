//! What the view says to its user: in the window for a while, and wherever the program says things.

use std::time::{Duration, Instant};

/// What gets a line of what the view says.
pub type Say = Box<dyn Fn(&str)>;

/// How long a message stays.
const NOTE_STAYS: Duration = Duration::from_secs(5);
const ERROR_STAYS: Duration = Duration::from_secs(15);

pub(crate) struct Message {
    pub(crate) text: String,
    pub(crate) is_error: bool,
    until: Instant,
}

pub(crate) struct Messages {
    shown: Vec<Message>,
    said: Vec<String>,
    say: Say,
}

impl Messages {
    pub(crate) fn new(say: Say) -> Self {
        Self { shown: Vec::new(), said: Vec::new(), say }
    }

    pub(crate) fn note(&mut self, text: String) {
        self.add(text, false);
    }

    pub(crate) fn error(&mut self, text: String) {
        self.add(text, true);
    }

    fn add(&mut self, text: String, is_error: bool) {
        (self.say)(&format!("{}: {text}", if is_error { "error" } else { "note" }));
        self.shown.retain(|m| m.text != text);
        let until = Instant::now() + if is_error { ERROR_STAYS } else { NOTE_STAYS };
        self.said.push(text.clone());
        self.shown.push(Message { text, is_error, until });
    }

    /// What is to be seen now.
    pub(crate) fn shown(&self) -> impl Iterator<Item = &Message> {
        let now = Instant::now();
        self.shown.iter().filter(move |m| m.until > now)
    }

    /// Forgets what has been seen long enough; whether there was any.
    pub(crate) fn has_gone(&mut self) -> bool {
        let (now, before) = (Instant::now(), self.shown.len());
        self.shown.retain(|m| m.until > now);
        self.shown.len() < before
    }

    /// When the next one goes.
    pub(crate) fn until(&self) -> Option<Instant> {
        self.shown().map(|m| m.until).min()
    }

    /// Everything that was said.
    pub(crate) fn said(&self) -> &[String] {
        &self.said
    }
}
