//! Messages to the user: shown in the window for a while, and passed on to the program.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Receives each message as a line.
pub type Say = Box<dyn Fn(&str)>;

/// How long messages are shown.
const NOTE_STAYS: Duration = Duration::from_secs(5);
const ERROR_STAYS: Duration = Duration::from_secs(15);
/// Number of messages that are kept for scripts that wait for one.
const MAX_REPORTED: usize = 1000;

pub(crate) struct Message {
    pub(crate) text: String,
    pub(crate) is_error: bool,
    until: Instant,
}

pub(crate) struct Messages {
    shown: Vec<Message>,
    said: VecDeque<String>,
    say: Say,
}

impl Messages {
    pub(crate) fn new(say: Say) -> Self {
        Self { shown: Vec::new(), said: VecDeque::new(), say }
    }

    pub(crate) fn note(&mut self, text: String) {
        self.add(text, false);
    }

    pub(crate) fn error(&mut self, text: String) {
        self.add(text, true);
    }

    /// Adds a message. An error that is already shown, for example because it recurs with every frame, is
    /// only shown for longer.
    fn add(&mut self, text: String, is_error: bool) {
        let until = Instant::now() + if is_error { ERROR_STAYS } else { NOTE_STAYS };
        if is_error && let Some(same) = self.shown.iter_mut().find(|m| m.is_error && m.text == text) {
            same.until = until;
            return;
        }
        (self.say)(&format!("{}: {text}", if is_error { "error" } else { "note" }));
        self.shown.retain(|m| m.text != text);
        if self.said.len() == MAX_REPORTED {
            self.said.pop_front();
        }
        self.said.push_back(text.clone());
        self.shown.push(Message { text, is_error, until });
    }

    /// Returns the messages to show now.
    pub(crate) fn shown(&self) -> impl Iterator<Item = &Message> {
        let now = Instant::now();
        self.shown.iter().filter(move |m| m.until > now)
    }

    /// Drops messages that have been shown long enough. Returns whether there were any.
    pub(crate) fn has_gone(&mut self) -> bool {
        let (now, before) = (Instant::now(), self.shown.len());
        self.shown.retain(|m| m.until > now);
        self.shown.len() < before
    }

    /// Returns when the next message disappears.
    pub(crate) fn until(&self) -> Option<Instant> {
        self.shown().map(|m| m.until).min()
    }

    /// Returns all messages that are kept, the latest last.
    pub(crate) fn said(&self) -> &VecDeque<String> {
        &self.said
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;

    use super::*;

    #[test]
    fn recurring_error_is_reported_once() {
        let lines = Rc::new(RefCell::new(Vec::new()));
        let seen = lines.clone();
        let mut messages = Messages::new(Box::new(move |line| seen.borrow_mut().push(line.to_owned())));
        for _ in 0..3 {
            messages.error("too large".to_owned());
            messages.note("saved".to_owned());
        }
        assert_eq!(*lines.borrow(), ["error: too large", "note: saved", "note: saved", "note: saved"]);
        assert_eq!(messages.said().len(), 4);
        assert_eq!(messages.shown().count(), 2);
    }

    #[test]
    fn kept_messages_are_limited() {
        let mut messages = Messages::new(Box::new(|_| {}));
        (0..2 * MAX_REPORTED).for_each(|i| messages.note(i.to_string()));
        assert_eq!(messages.said().len(), MAX_REPORTED);
        assert_eq!(messages.said().back().unwrap(), &(2 * MAX_REPORTED - 1).to_string());
    }
}
