//! Resident memory of this process, as Linux counts it.

/// The largest since the start, or since it was forgotten, MiB.
pub fn peak_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes / 1024.0)
}

/// Forgets the largest so far: what is resident now is the largest. Says whether the system does so.
pub fn forget_peak() -> bool {
    std::fs::write("/proc/self/clear_refs", "5").is_ok()
}

/// For a table.
pub fn in_words(mib: Option<f64>) -> String {
    mib.map_or("n/a".into(), |mib| format!("{mib:.0} MiB"))
}
