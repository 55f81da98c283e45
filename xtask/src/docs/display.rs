//! A display without a screen, so that documents may open windows.

use std::io::{self, BufRead, BufReader};
use std::process::{Child, Command, Stdio};

/// An X server of its own, gone with this.
pub(crate) struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// Starts one; none on systems whose windows are not X's.
    pub(crate) fn start() -> io::Result<Option<Self>> {
        if !cfg!(target_os = "linux") {
            return Ok(None);
        }
        // -noreset: else the server begins anew after each window's end, and drops the next that comes just then.
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-noreset", "-screen", "0", "1920x1200x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|e| io::Error::new(e.kind(), format!("Xvfb, for windows without a screen: {e}")))?;
        let mut number = String::new();
        if let Some(out) = server.stdout.take() {
            BufReader::new(out).read_line(&mut number)?;
        }
        Ok(Some(Self { server, name: format!(":{}", number.trim()) }))
    }

    /// As `DISPLAY` has it.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        // Where it is gone already there is nothing to end.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}
