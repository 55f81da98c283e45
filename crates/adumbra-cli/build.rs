//! Provides the program with the revision of its sources.

mod revision;

fn main() {
    revision::emit(&["adumbra-testing", "papers", "program"]);
}
