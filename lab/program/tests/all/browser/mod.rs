//! A headless browser driven by the DevTools protocol.
//!
//! It opens a page, evaluates expressions in it, and records the page's requests, errors and warnings.

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
/// Generous, because the page is read from disk and its pictures may be decoded on a busy machine.
const TIMEOUT: Duration = Duration::from_secs(60);

pub(crate) struct Browser {
    process: Child,
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    session: Option<String>,
    last_id: u64,
    /// Method and parameters of the events since navigation to the page began.
    events: Vec<(String, Value)>,
    _profile: tempfile::TempDir,
}

impl Browser {
    /// Starts the browser, or returns `None` if the machine has none.
    ///
    /// Panics instead of returning `None` if `ADUMBRA_REQUIRE_TOOLS` is set.
    pub(crate) fn start() -> Option<Self> {
        let profile = tempfile::tempdir().unwrap();
        let Some(process) = NAMES.iter().find_map(|name| spawn(name, &profile)) else {
            let reason = format!("none of {NAMES:?} is there; Debian: apt-get install chromium");
            adumbra_testing::left_out(&reason, "ADUMBRA_REQUIRE_TOOLS");
            return None;
        };
        Some(Self::attach(process, profile))
    }

    fn attach(mut process: Child, profile: tempfile::TempDir) -> Self {
        let stderr = BufReader::new(process.stderr.take().unwrap());
        let mut lines = stderr.lines().map_while(Result::ok);
        let address = lines
            .find_map(|l| l.strip_prefix("DevTools listening on ").map(str::to_owned))
            .expect("the browser tells where it listens");
        // The pipe must be drained: the browser would block on a full one.
        std::thread::spawn(move || lines.for_each(drop));
        let (socket, _) = tungstenite::connect(address).unwrap();
        if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
            stream.set_read_timeout(Some(TIMEOUT)).unwrap();
        }
        let mut browser =
            Self { process, socket, session: None, last_id: 0, events: Vec::new(), _profile: profile };
        let target = browser.call("Target.createTarget", &json!({"url": "about:blank"}));
        let attached =
            browser.call("Target.attachToTarget", &json!({"targetId": target["targetId"], "flatten": true}));
        browser.session = attached["sessionId"].as_str().map(str::to_owned);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), &json!({}));
        }
        browser
    }

    /// Calls a method and waits for its result. Events that arrive before it are kept.
    pub(crate) fn call(&mut self, method: &str, parameters: &Value) -> Value {
        self.last_id += 1;
        let mut command = json!({"id": self.last_id, "method": method, "params": parameters});
        if let Some(session) = &self.session {
            command["sessionId"] = json!(session);
        }
        self.socket.send(Message::text(command.to_string())).unwrap();
        let id = self.last_id;
        loop {
            let answer = self.read();
            if answer["id"] == id {
                assert!(answer.get("error").is_none(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
        }
    }

    fn read(&mut self) -> Value {
        let message = self.socket.read().expect("the browser answers");
        let value: Value = serde_json::from_str(message.to_text().unwrap_or("null")).unwrap_or_default();
        if let Some(method) = value["method"].as_str() {
            self.events.push((method.to_owned(), value["params"].clone()));
        }
        value
    }

    /// Opens a file and waits until it is fully loaded.
    pub(crate) fn open(&mut self, path: &str) {
        self.events.clear();
        self.call("Page.navigate", &json!({"url": format!("file://{path}")}));
        let start = Instant::now();
        while !self.events.iter().any(|(method, _)| method == "Page.loadEventFired") {
            assert!(start.elapsed() < TIMEOUT, "{path} does not load");
            self.read();
        }
    }

    /// Returns the value of an expression, awaited if it is a promise.
    pub(crate) fn eval(&mut self, expression: &str) -> Value {
        let parameters = json!({"expression": expression, "returnByValue": true, "awaitPromise": true});
        let result = self.call("Runtime.evaluate", &parameters);
        assert!(result.get("exceptionDetails").is_none(), "{expression}: {result}");
        result["result"]["value"].clone()
    }

    /// Resizes the viewport.
    pub(crate) fn resize(&mut self, width: u32, height: u32, mobile: bool) {
        let metrics = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile});
        self.call("Emulation.setDeviceMetricsOverride", &metrics);
    }

    /// Returns the URLs requested since the page was opened, except embedded `data:` URLs.
    pub(crate) fn requests(&self) -> Vec<String> {
        let asked = self.events.iter().filter(|(method, _)| method == "Network.requestWillBeSent");
        let urls = asked.filter_map(|(_, p)| p["request"]["url"].as_str());
        urls.filter(|url| !url.starts_with("data:")).map(str::to_owned).collect()
    }

    /// Returns errors and warnings on the console, and uncaught exceptions.
    pub(crate) fn complaints(&self) -> Vec<String> {
        let bad = |(method, p): &&(String, Value)| match method.as_str() {
            "Runtime.exceptionThrown" => true,
            "Runtime.consoleAPICalled" => matches!(p["type"].as_str(), Some("error" | "warning" | "assert")),
            "Log.entryAdded" => matches!(p["entry"]["level"].as_str(), Some("error" | "warning")),
            _ => false,
        };
        self.events.iter().filter(bad).map(|(method, p)| format!("{method}: {p}")).collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It may have exited by itself already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn spawn(name: &str, profile: &tempfile::TempDir) -> Option<Child> {
    let mut command = Command::new(name);
    command.args([
        "--headless=new",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-dev-shm-usage",
        "--disable-background-networking",
        "--disable-component-update",
        "--disable-sync",
        "--no-first-run",
        "--remote-debugging-port=0",
    ]);
    command.arg(format!("--user-data-dir={}", profile.path().display())).arg("about:blank");
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    command.spawn().ok()
}
