//! Streams: files of any size within a budget.

mod answers;
mod fading;
mod http;
mod kit;
