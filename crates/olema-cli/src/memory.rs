//! `--memory`: how much may be used.
//!
//! In: an amount, or nothing. Out: the shares of it ([`olema::settings::Memory`]). Nothing stands for half of the
//! machine's memory, or of what the group of processes may use where that is less.

use olema::Settings;
use olema::settings::Memory;

/// What is taken for the machine's memory where the system does not tell.
const UNKNOWN: u64 = 8 << 30;

/// Bytes in words like `512M`.
///
/// # Errors
/// What is expected.
pub fn parse(s: &str) -> Result<u64, String> {
    let expected =
        || "expected bytes, at least 1M, with K, M, G or T behind for powers of 1024, e.g. 512M".to_owned();
    let (number, power) = match s.char_indices().last() {
        Some((at, unit @ ('k' | 'K' | 'm' | 'M' | 'g' | 'G' | 't' | 'T'))) => {
            (&s[..at], 1 + "KMGT".find(unit.to_ascii_uppercase()).unwrap_or(0) as u32)
        }
        _ => (s, 0),
    };
    let bytes = number.parse::<u64>().ok().and_then(|n| n.checked_mul(1024u64.pow(power)));
    bytes.filter(|&bytes| bytes >= 1 << 20).ok_or_else(expected)
}

/// A budget in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget(pub u64);

impl Budget {
    /// What was asked for, or half of what there is.
    pub fn new(asked: Option<u64>) -> Self {
        let file = |name: &str| std::fs::read_to_string(name).unwrap_or_default();
        Budget(
            asked.unwrap_or_else(|| machine(&file("/proc/meminfo"), &file("/sys/fs/cgroup/memory.max")) / 2),
        )
    }

    /// What a reader may hold.
    pub fn reader(self) -> u64 {
        Memory::divide(self.0).reader
    }

    /// Puts the shares into settings, whose `threads` are known.
    pub fn limit(self, settings: &mut Settings) {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let workers = if settings.threads == 0 { cores } else { settings.threads };
        Memory::divide(self.0).limit(settings, workers);
    }
}

/// Bytes of the machine's memory, by the two files in which Linux tells them.
fn machine(meminfo: &str, group: &str) -> u64 {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemTotal:")).unwrap_or_default();
    let kib = line.trim().trim_end_matches("kB").trim().parse::<u64>();
    let total = kib.map_or(UNKNOWN, |kib| kib.saturating_mul(1024));
    // "max" where there is no limit.
    group.trim().parse().map_or(total, |most: u64| most.min(total))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_have_units() {
        assert_eq!(parse("1048576"), Ok(1 << 20));
        assert_eq!(
            ["512M", "1g", "2048K", "3T"].map(parse),
            [Ok(512 << 20), Ok(1 << 30), Ok(2 << 20), Ok(3 << 40)]
        );
        for bad in ["", "M", "0", "1023K", "-1G", "1.5G", "1GB", "99999999T", "1\u{e9}", "G1"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn the_smaller_of_machine_and_group_counts() {
        let meminfo = "MemTotal:       2048 kB\nMemFree:         100 kB\n";
        assert_eq!(machine(meminfo, "max\n"), 2 << 20);
        assert_eq!(machine(meminfo, "1048576\n"), 1 << 20);
        assert_eq!(machine(meminfo, ""), 2 << 20);
        assert_eq!(machine("", ""), UNKNOWN);
    }

    #[test]
    fn without_a_word_there_is_a_budget() {
        assert!(Budget::new(None).0 > 1 << 20);
        assert_eq!(Budget::new(Some(5 << 20)).reader(), 5 << 19);
    }
}
