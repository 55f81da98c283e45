//! A virtual display, and views on it.

use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use adumbra_testing::{Folder, program};

/// Time limit of a view.
pub(crate) const TIMEOUT: Duration = Duration::from_secs(240);

/// A virtual display, which ends when it is dropped.
pub(crate) struct Display {
    server: Child,
    name: String,
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// A running view, which is killed when it is dropped.
pub(crate) struct View(Child);

impl Drop for View {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn has(tool: &str, argument: &str) -> bool {
    Command::new(tool).arg(argument).stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
}

/// Starts a display. If its programs are missing, prints a note and returns `None`.
pub(crate) fn display() -> Option<Display> {
    if !has("Xvfb", "-help") || !has("xdotool", "version") {
        let reason = "Xvfb or xdotool is missing (Debian, Ubuntu: apt-get install xvfb xdotool)";
        adumbra_testing::left_out(reason, "ADUMBRA_REQUIRE_TOOLS");
        return None;
    }
    // Without -noreset the server resets whenever its last client has disconnected, and drops clients that
    // connect at that moment. Repeated searches for the window would cost the view its connection.
    let mut server = Command::new("Xvfb")
        .args(["-displayfd", "1", "-noreset", "-screen", "0", "1280x1024x24", "-nolisten", "tcp"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut number = String::new();
    let mut out = server.stdout.take().unwrap();
    let mut byte = [0];
    while out.read(&mut byte).unwrap() == 1 && byte[0] != b'\n' {
        number.push(byte[0].into());
    }
    assert!(!number.is_empty(), "Xvfb did not start");
    Some(Display { server, name: format!(":{number}") })
}

impl Display {
    /// Starts a view that can reach no other display.
    pub(crate) fn begin(&self, arguments: &[&str]) -> View {
        let view = Command::new(program())
            .arg("view")
            .args(arguments)
            .env("DISPLAY", &self.name)
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .stderr(Stdio::piped())
            .spawn();
        View(view.unwrap())
    }

    /// Runs a view that plays a script to its end. Returns its exit code and stderr.
    pub(crate) fn play(&self, folder: &Folder, arguments: &[&str], steps: &Value) -> (i32, String) {
        let script = folder.write("script.json", steps.to_string().as_bytes());
        finish(self.begin(&[arguments, &["--script", &script]].concat()))
    }

    pub(crate) fn xdotool(&self, arguments: &[&str]) -> String {
        let output = Command::new("xdotool").args(arguments).env("DISPLAY", &self.name).output().unwrap();
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    }

    /// Presses a key in the window that has the focus.
    pub(crate) fn press(&self, key: &str) {
        self.xdotool(&["key", key]);
    }

    /// Waits for the view's window and returns its id.
    pub(crate) fn window(&self, view: &mut View) -> String {
        let start = Instant::now();
        while start.elapsed() < TIMEOUT {
            view.must_run("its window was there");
            let found = self.xdotool(&["search", "--onlyvisible", "--name", "^adumbra: "]);
            if let Some(id) = found.lines().next() {
                return id.to_owned();
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        panic!("no window was opened");
    }
}

impl View {
    /// Panics with the view's stderr if it has ended.
    pub(crate) fn must_run(&mut self, until: &str) {
        if let Some(status) = self.0.try_wait().unwrap() {
            let mut said = String::new();
            let _ = self.0.stderr.take().unwrap().read_to_string(&mut said);
            panic!("the view ended before {until}: {status}: {said}");
        }
    }
}

/// Waits until a view ends by itself. Returns its exit code and stderr.
pub(crate) fn finish(mut view: View) -> (i32, String) {
    let mut said = String::new();
    let mut stderr = view.0.stderr.take().unwrap();
    let reader = std::thread::spawn(move || {
        let _ = stderr.read_to_string(&mut said);
        said
    });
    let start = Instant::now();
    loop {
        if let Some(status) = view.0.try_wait().unwrap() {
            return (status.code().unwrap_or(-1), reader.join().unwrap());
        }
        if start.elapsed() > TIMEOUT {
            drop(view);
            panic!("the view did not end: {}", reader.join().unwrap());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}
