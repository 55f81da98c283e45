//! Gives the program the revision of its sources.

mod revision;

fn main() {
    revision::emit(&["adumbra-cli", "adumbra-testing", "adumbra-view"]);
}
