//! The machine and program that made a report.

use std::fs;
use std::time::{SystemTime, UNIX_EPOCH};

use adumbra_program::output::format_bytes;
use adumbra_render::{Gpu, GpuOptions};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::programs::REVISION;

/// The machine, its adapter and the program. Values that the system does not report are empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(super) struct Machine {
    /// Date in UTC.
    pub(super) date: String,
    /// Version of adumbra.
    pub(super) adumbra: String,
    /// Git revision of the sources that the program was built from.
    ///
    /// It has the suffix `-dirty` if they were modified, and is empty if git could not determine it.
    pub(super) revision: String,
    /// Model of the processor.
    pub(super) cpu: String,
    /// Hardware threads.
    pub(super) cores: usize,
    /// Memory of the machine; 0 if the system does not report it.
    pub(super) memory_bytes: u64,
    /// Operating system.
    pub(super) system: String,
    /// Name and driver of the adapter.
    pub(super) adapter: String,
    /// Whether the adapter is a software renderer.
    pub(super) software: bool,
    /// Features that the adapter lacks, each with its consequence.
    pub(super) missing_features: Vec<String>,
}

impl Machine {
    pub(super) fn here() -> Self {
        let gpu = Gpu::request(&GpuOptions::default());
        let (adapter, software, missing_features) = match &gpu {
            Ok(gpu) => (gpu.name(), gpu.is_software(), gpu.missing_features()),
            Err(e) => (format!("none: {e}"), false, Vec::new()),
        };
        Self {
            date: today(),
            adumbra: env!("CARGO_PKG_VERSION").to_owned(),
            revision: REVISION.to_owned(),
            cpu: line_of("/proc/cpuinfo", "model name").unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            cores: std::thread::available_parallelism().map_or(0, usize::from),
            memory_bytes: memory_bytes(),
            system: system(),
            adapter,
            software,
            missing_features: missing_features.into_iter().map(str::to_owned).collect(),
        }
    }

    /// Returns its table rows, without the date.
    pub(super) fn rows(&self) -> Vec<[String; 2]> {
        let memory = if self.memory_bytes == 0 { String::new() } else { format_bytes(self.memory_bytes) };
        let kind = if self.software { ", a software renderer" } else { "" };
        let mut rows = vec![
            ["adumbra", &self.version()],
            ["processor", &format!("{}, {} threads", self.cpu, self.cores)],
            ["memory", &memory],
            ["system", &self.system],
            ["adapter", &format!("{}{kind}", self.adapter)],
        ]
        .into_iter()
        .map(|row| row.map(str::to_owned))
        .collect::<Vec<_>>();
        rows.extend(self.missing_features.iter().map(|lacks| ["missing feature".to_owned(), lacks.clone()]));
        rows
    }

    /// Returns the program's version, with its revision if known.
    pub(super) fn version(&self) -> String {
        match self.revision.as_str() {
            "" => self.adumbra.clone(),
            revision => format!("{}, revision {revision}", self.adumbra),
        }
    }

    /// Returns the rows that differ from `other`'s as text, or `None` if machine and program are the same.
    pub(super) fn unlike(&self, other: &Self) -> Option<String> {
        let theirs = other.rows();
        let own: Vec<String> =
            self.rows().into_iter().filter(|row| !theirs.contains(row)).map(|row| row.join(" ")).collect();
        (!own.is_empty()).then(|| own.join("; "))
    }
}

/// Returns the value after `key` and its separator on the first line of a file that starts with `key`.
fn line_of(path: &str, key: &str) -> Option<String> {
    let text = fs::read_to_string(path).ok()?;
    let line = text.lines().find(|l| l.starts_with(key))?;
    let value = line[key.len()..].trim_start().trim_start_matches([':', '=']).trim();
    Some(value.trim_matches('"').to_owned())
}

fn memory_bytes() -> u64 {
    let kib = line_of("/proc/meminfo", "MemTotal").and_then(|l| l.split(' ').next()?.parse::<u64>().ok());
    kib.map_or(0, |kib| kib * 1024)
}

fn system() -> String {
    let name = line_of("/etc/os-release", "PRETTY_NAME").unwrap_or_else(|| std::env::consts::OS.to_owned());
    match fs::read_to_string("/proc/sys/kernel/osrelease") {
        Ok(kernel) => format!("{name}, kernel {}", kernel.trim()),
        Err(_) => name,
    }
}

/// Returns today's date in UTC in the form 2026-01-31.
fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    date((seconds / 86_400) as i64)
}

/// Returns the date `days` days after 1970-01-01.
///
/// Source: Hinnant, *chrono-compatible low-level date algorithms* (2013).
fn date(days: i64) -> String {
    let shifted = days + 719_468;
    let era = shifted.div_euclid(146_097);
    let day_of_era = shifted.rem_euclid(146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn machine_unlike_lists_differing_rows() {
        let here = Machine { adumbra: "1.0".to_owned(), adapter: "one".to_owned(), ..Machine::default() };
        let later = Machine { date: "2026-02-01".to_owned(), ..here.clone() };
        assert_eq!(later.unlike(&here), None);
        let there = Machine { revision: "abc".to_owned(), adapter: "two".to_owned(), ..here.clone() };
        assert_eq!(there.unlike(&here).unwrap(), "adumbra 1.0, revision abc; adapter two");
        assert_eq!(here.unlike(&there).unwrap(), "adumbra 1.0; adapter one");
    }

    #[test]
    fn date_handles_leap_days() {
        assert_eq!(date(0), "1970-01-01");
        assert_eq!(date(11_016), "2000-02-29");
        assert_eq!(date(20_454), "2026-01-01");
        assert_eq!(date(20_453), "2025-12-31");
    }
}
