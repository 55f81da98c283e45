//! A virtual display, so that commands of the documents can open windows.

use std::io::{self, BufRead, BufReader};
use std::process::{Child, Command, Stdio};

/// An X server. Dropping the value ends the server.
pub(crate) struct Display {
    server: Child,
    name: String,
}

impl Display {
    /// Starts an X server. `None` on systems whose windows do not use X.
    pub(crate) fn start() -> io::Result<Option<Self>> {
        if !cfg!(target_os = "linux") {
            return Ok(None);
        }
        // Without -noreset the server resets after each window closes, and drops a client that connects at
        // that moment.
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-noreset", "-screen", "0", "1920x1200x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|e| {
                io::Error::new(
                    e.kind(),
                    format!("cannot start Xvfb, which provides a display without a screen: {e}"),
                )
            })?;
        let mut number = String::new();
        if let Some(out) = server.stdout.take() {
            BufReader::new(out).read_line(&mut number)?;
        }
        let mut display = Self { server, name: String::new() };
        display.name = name(&number).ok_or_else(|| {
            io::Error::other("Xvfb ended before it had a display, or could not open one; try it by hand: Xvfb -displayfd 1")
        })?;
        Ok(Some(display))
    }

    /// Returns the name for the variable `DISPLAY`.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }
}

/// Returns the name for `DISPLAY` from the number that the server prints. `None` if it prints none.
fn name(number: &str) -> Option<String> {
    number.trim().parse::<u32>().ok().map(|number| format!(":{number}"))
}

impl Drop for Display {
    fn drop(&mut self) {
        // If the server has already ended, there is nothing to do.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn display_name_comes_from_server_output() {
        assert_eq!(name("99\n"), Some(":99".to_owned()));
        assert_eq!([name(""), name("\n"), name(":1")], [None, None, None]);
    }
}
