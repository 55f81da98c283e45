//! Full or closed stdout and stderr: a failed write is an error, never a panic.

use std::fs::File;
use std::process::{Command, Output, Stdio};

use adumbra_testing::{Folder, adumbra, program, stderr};

fn full() -> Stdio {
    File::options().write(true).open("/dev/full").unwrap().into()
}

fn run(words: &[&str], stdout: Stdio, stderr: Stdio) -> Output {
    Command::new(program()).args(words).stdout(stdout).stderr(stderr).output().unwrap()
}

#[test]
fn results_that_cannot_be_printed_are_errors() {
    let folder = Folder::new();
    let (scene, file) = (folder.generate("primitives"), folder.path("p.adumbra"));
    let bake = ["bake", &scene, "--resolution", "256", "-o", &file];
    let output = run(&bake, full(), Stdio::piped());
    assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
    assert!(file_is_whole(&file), "the file is written all the same");
    for words in [
        &["info", &file, "--json"][..],
        &["info", &file],
        &["inspect", &scene],
        &["schema", "bake"],
        &["--help"],
        &["bake", "--help"],
        &["--version"],
    ] {
        let output = run(words, full(), Stdio::piped());
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(4), "{words:?}: {said}");
        assert!(said.contains("cannot write") && said.contains("standard output"), "{words:?}: {said}");
    }
}

fn file_is_whole(path: &str) -> bool {
    adumbra(&["info", path]).0 == 0
}

#[test]
fn exit_codes_stay_when_stderr_cannot_be_written() {
    let folder = Folder::new();
    let (scene, file) = (folder.generate("primitives"), folder.path("p.adumbra"));
    let missing = folder.path("none.adumbra");
    for (words, code) in [
        (&["info", &missing][..], 3),
        (&["bake", &scene, "--resolution", "100"], 2),
        (&["bake", &scene, "--no-such-option"], 2),
        // A warning.
        (&["bake", &scene, "--resolution", "64", "--sun", "1,0.01,0", "-o", &file], 0),
    ] {
        assert_eq!(run(words, Stdio::null(), full()).status.code(), Some(code), "{words:?}");
        assert_eq!(run(words, Stdio::null(), closed()).status.code(), Some(code), "{words:?}");
    }
}

/// A pipe whose other end is closed.
fn closed() -> Stdio {
    std::io::pipe().unwrap().1.into()
}

/// `head` closes its end when it has read enough.
#[test]
fn reader_that_closes_stdout_early_is_no_error() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let output = run(&["inspect", &scene, "--json"], closed(), Stdio::piped());
    assert_eq!(
        (output.status.code(), stderr(&output).contains("error")),
        (Some(0), false),
        "{}",
        stderr(&output)
    );
}

/// A number such as 1e300 has 301 digits when it is written in full.
#[test]
fn messages_have_no_numbers_of_hundreds_of_digits() {
    let folder = Folder::new();
    let (scene, file) = (folder.generate("primitives"), folder.path("p.adumbra"));
    let bake = ["bake", &scene, "-o", &file];
    for more in [
        &["--resolution", "64", "--thickness", "-1e300"][..],
        &["--resolution", "64", "--azimuth", "1e300", "--elevation", "1e300"],
        &["--resolution", "64", "--frame", "oblique", "--yaw", "1e300"],
        &["--resolution", "64", "--sun", "1e300,1e299,0"],
        &["--resolution", "64", "--bounds", "0,0,0,1e300,1,1"],
        &["--voxel-size", "1e300"],
        &["--voxel-size", "1e-300"],
    ] {
        let output = run(&[&bake[..], more].concat(), Stdio::piped(), Stdio::piped());
        let said = String::from_utf8_lossy(&output.stdout).into_owned() + &stderr(&output);
        assert!(said.split_whitespace().all(|word| word.len() < 100), "{more:?}: {said}");
    }
}

/// Links of the system, such as `/dev/stdout`, do not resolve to a path if they lead to a pipe.
#[test]
fn rejects_stdout_as_output() {
    let folder = Folder::new();
    let scene = folder.generate("primitives");
    let output =
        run(&["bake", &scene, "--resolution", "64", "-o", "/dev/stdout"], Stdio::piped(), Stdio::piped());
    let said = stderr(&output);
    assert!(output.status.code() == Some(3) && said.contains("a device or a pipe"), "{said}");
    assert!(output.stdout.is_empty());
}
