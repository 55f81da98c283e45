//! A stream from a plain static server that is 50 ms away, through a client that a program brings itself.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::ops::Range;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use adumbra::stream::{ShadowSource, SourceError, StreamOptions, Streamer, View};
use adumbra::{Filter, ShadowFile};

use crate::kit::{LIMIT, city, compare, faults_of, points};

const LATENCY: Duration = Duration::from_millis(50);

/// How the server answers.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Manner {
    Ranges,
    /// The whole file, whatever the range.
    NoRanges,
    /// The connection closes in the middle.
    Drops,
    /// Bytes of another place.
    WrongRange,
}

struct Served {
    bytes: Vec<u8>,
    etag: &'static str,
    manner: Manner,
}

/// Serves a file to any number of clients, until the program ends.
fn serve(bytes: Vec<u8>) -> (SocketAddr, Arc<Mutex<Served>>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let served = Arc::new(Mutex::new(Served { bytes, etag: "\"one\"", manner: Manner::Ranges }));
    let all = Arc::clone(&served);
    thread::spawn(move || {
        for stream in listener.incoming() {
            let served = Arc::clone(&all);
            thread::spawn(move || answer(&mut stream.unwrap(), &served));
        }
    });
    (address, served)
}

fn answer(stream: &mut TcpStream, served: &Mutex<Served>) {
    let mut asked = None;
    for line in BufReader::new(stream.try_clone().unwrap()).lines().map_while(Result::ok) {
        if line.is_empty() {
            break;
        }
        if let Some(range) = line.to_ascii_lowercase().strip_prefix("range: bytes=") {
            let (first, last) = range.split_once('-').unwrap();
            asked = Some(first.parse::<usize>().unwrap()..last.parse::<usize>().unwrap() + 1);
        }
    }
    thread::sleep(LATENCY);
    let served = served.lock().unwrap();
    let length = served.bytes.len();
    let mut range = asked.unwrap_or(0..length);
    range.end = range.end.min(length);
    let status = if served.manner == Manner::NoRanges { "200 OK" } else { "206 Partial Content" };
    match served.manner {
        Manner::NoRanges => range = 0..length,
        Manner::WrongRange => range.start = (range.start + 64).min(range.end),
        Manner::Ranges | Manner::Drops => {}
    }
    let head = format!(
        "HTTP/1.1 {status}\r\nETag: {}\r\nContent-Range: bytes {}-{}/{length}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
        served.etag,
        range.start,
        range.end - 1,
        range.len(),
    );
    let sent = if served.manner == Manner::Drops { range.len() / 2 } else { range.len() };
    // Ignore a client that has disconnected.
    let _ = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(&served.bytes[range][..sent]));
}

/// A minimal client, with only the checks that every program needs.
struct Client {
    server: SocketAddr,
    etag: Mutex<Option<String>>,
}

impl ShadowSource for Client {
    fn read(&self, range: Range<u64>) -> Result<Vec<u8>, SourceError> {
        let mut stream = TcpStream::connect(self.server)?;
        let (first, last) = (range.start, range.end - 1);
        write!(stream, "GET /city.adumbra HTTP/1.1\r\nHost: city\r\nRange: bytes={first}-{last}\r\n\r\n")?;
        let mut reader = BufReader::new(stream);
        let mut status = String::new();
        reader.read_line(&mut status)?;
        let (mut etag, mut length, mut from) = (None, 0, None);
        loop {
            let mut line = String::new();
            reader.read_line(&mut line)?;
            let Some((name, value)) = line.trim().split_once(": ") else { break };
            match name.to_ascii_lowercase().as_str() {
                "etag" => etag = Some(value.to_owned()),
                "content-length" => length = value.parse().unwrap_or(0),
                "content-range" => {
                    from = value.strip_prefix("bytes ").and_then(|v| v.split('-').next()?.parse().ok());
                }
                _ => {}
            }
        }
        if !status.contains(" 206 ") || from != Some(first) {
            let what = format!("the server does not give the range that was asked for: {}", status.trim());
            return Err(std::io::Error::other(what).into());
        }
        let mut known = self.etag.lock().unwrap();
        if known.get_or_insert_with(|| etag.clone().unwrap_or_default()) != &etag.unwrap_or_default() {
            return Err(SourceError::Changed);
        }
        drop(known);
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes)?;
        if bytes.len() != length {
            return Err(std::io::Error::other("the connection was closed").into());
        }
        Ok(bytes)
    }
}

fn stream(server: SocketAddr) -> Streamer {
    Streamer::new(Client { server, etag: Mutex::default() }, StreamOptions::default())
}

/// Checks the answers at some points. Returns how many each level gave.
fn check(streamer: &Streamer) -> Vec<u32> {
    let file = ShadowFile::from_bytes(city()).unwrap();
    compare(streamer, &file, &points(&file, 2000, 1), Filter::Box5)
}

#[test]
fn first_answers_come_after_two_requests() {
    let (server, _) = serve(city().to_vec());
    let begun = Instant::now();
    let mut streamer = stream(server);
    assert!(streamer.settle(&[], LIMIT, |_| ()));
    assert!(streamer.counts().requests <= 2 && begun.elapsed() >= LATENCY, "{:?}", streamer.counts());
    assert!(check(&streamer)[2] > 1000);
    assert!(streamer.settle(&[View::everything()], LIMIT, |_| ()));
    assert_eq!(check(&streamer)[0], 2000);
}

#[test]
fn failing_server_leaves_resident_levels_usable() {
    for manner in [Manner::NoRanges, Manner::Drops, Manner::WrongRange] {
        for opens in [false, true] {
            let (server, served) = serve(city().to_vec());
            let mut streamer = stream(server);
            assert!(!opens || streamer.settle(&[], LIMIT, |_| ()));
            served.lock().unwrap().manner = manner;
            let faults = faults_of(&mut streamer, &[View::everything()]);
            let part = if opens { "level" } else { "beginning" };
            assert!(!faults.is_empty() && faults[0].part.contains(part), "{manner:?}: {faults:?}");
            assert!(!opens || check(&streamer)[2] > 1000, "{manner:?}");
            served.lock().unwrap().manner = Manner::Ranges;
            streamer.retry();
            assert!(
                streamer.settle(&[View::everything()], LIMIT, |_| ()),
                "{manner:?}: {:?}",
                streamer.counts()
            );
            assert_eq!(check(&streamer)[0], 2000);
        }
    }
}

#[test]
fn replaced_file_is_reported_as_changed() {
    let (server, served) = serve(city().to_vec());
    let mut streamer = stream(server);
    assert!(streamer.settle(&[], LIMIT, |_| ()));
    served.lock().unwrap().etag = "\"two\"";
    let faults = faults_of(&mut streamer, &[View::everything()]);
    assert!(faults.iter().any(|fault| fault.to_string().contains("has changed")), "{faults:?}");
    assert!(check(&streamer)[2] > 1000);
}
