//! Code shared by the programs `adumbra` and `adumbra-lab`. It depends only on the core crates, so that a
//! program without GPU support links no graphics library.
//!
//! | module | contents |
//! |---|---|
//! | [`start`] | the course of a program, from its arguments to its exit code |
//! | [`exit`] | exit codes, and the errors that lead to them |
//! | [`args`], [`lookup`] | groups of options that several verbs share |
//! | [`scene`], [`sun`], [`bounds`] | loading a scene, with its warnings; the sun, and where it comes from; the box of `--bounds` |
//! | [`glance`] | a description of a scene as a person would see it, and warnings about unusual scenes |
//! | [`moment`] | moments of sun paths |
//! | [`query`], [`verify`] | verbs that several programs offer for their own kinds of files |
//! | [`console`] | stdout and stderr |
//! | [`output`] | files that are written completely or not at all, and never over an input |
//! | [`mod@format`], [`text`] | names and numbers as text; captions in pictures |
//! | [`schemas`], [`mirrors`] | the verb `schema`; schemas of the reader's types |
//! | [`progress`], [`signals`], [`memory`], [`threads`] | progress, interruption, memory use and threads of long runs |

// These macros panic if writing fails.
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod advice;
mod allocator;
pub mod args;
pub mod bounds;
pub mod console;
mod environment;
pub mod exit;
mod files;
pub mod format;
pub mod glance;
pub mod lookup;
pub mod memory;
pub mod mirrors;
pub mod moment;
pub mod output;
pub mod progress;
pub mod query;
pub mod scene;
pub mod schemas;
pub mod signals;
pub mod start;
pub mod sun;
pub mod text;
pub mod threads;
pub mod verify;

/// Prints a line on stdout. If it cannot be written, the program fails at its end: see [`start::main`].
#[macro_export]
macro_rules! say {
    () => {
        $crate::say!("")
    };
    ($($words:tt)*) => {
        $crate::console::say(format_args!($($words)*))
    };
}

/// Prints a line on stderr. A line that cannot be written is dropped.
#[macro_export]
macro_rules! note {
    ($($words:tt)*) => {
        $crate::console::note(format_args!($($words)*))
    };
}
