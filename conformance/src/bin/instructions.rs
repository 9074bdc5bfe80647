//! Guards the kernels against getting slower: counts their instructions with callgrind (valgrind) and compares them with
//! the stored baselines. Counts do not depend on what else the machine does.
//!
//! ```text
//! instructions          compares with conformance/instructions.txt; exit status 1 where a kernel takes more
//! instructions bless    writes that file
//! instructions run NAME TIMES    what is counted
//! ```

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

use conformance::kernels::{ALL, Ready};
use olema::math::simd::SimdLevel;
use olema::sampling::Kernels;

/// More instructions than this times the baseline are too many: another compiler shifts them a little.
const MOST: f64 = 1.05;
/// What is counted is the difference between these numbers of draws, over it: starting up costs nothing then.
const TIMES: [u32; 2] = [2, 10];

type Counts = BTreeMap<String, u64>;

fn baselines() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("instructions.txt")
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["run", name, times] => {
            let case =
                ALL.iter().find(|case| case.name == name).ok_or_else(|| format!("no kernel {name}"))?;
            let mut ready = Ready::new(case);
            for _ in 0..times.parse::<u32>()? {
                ready.draw(Kernels::default());
            }
            println!("level {}", SimdLevel::best().name());
            Ok(ExitCode::SUCCESS)
        }
        ["bless"] => {
            let (level, counts) = count_all()?;
            let mut text = format!("level {level}\n");
            for (name, count) in &counts {
                let _ = writeln!(text, "{name} {count}");
            }
            std::fs::write(baselines(), text)?;
            Ok(ExitCode::SUCCESS)
        }
        [] => check(),
        _ => Err("usage: instructions [bless | run NAME TIMES]".into()),
    }
}

fn check() -> Result<ExitCode, Box<dyn Error>> {
    let (baseline_level, expected) = parse(&std::fs::read_to_string(baselines())?)?;
    let (level, counts) = count_all()?;
    if level != baseline_level {
        println!(
            "not compared: the baselines are of {baseline_level}, under valgrind this processor has {level}"
        );
        return Ok(ExitCode::SUCCESS);
    }
    let mut is_slower = false;
    println!("{:24} {:>12} {:>12} {:>7}", "kernel", "baseline", "now", "ratio");
    for (name, &count) in &counts {
        let Some(&baseline) = expected.get(name) else {
            return Err(format!("{}: no baseline of {name}", baselines().display()).into());
        };
        let ratio = count as f64 / baseline as f64;
        let verdict = if is_too_many(count, baseline) { "  TOO MANY" } else { "" };
        is_slower |= is_too_many(count, baseline);
        println!("{name:24} {baseline:12} {count:12} {ratio:7.3}{verdict}");
    }
    Ok(if is_slower { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn is_too_many(count: u64, baseline: u64) -> bool {
    count as f64 > MOST * baseline as f64
}

/// The level and the counts of a file of baselines.
fn parse(text: &str) -> Result<(String, Counts), Box<dyn Error>> {
    let mut level = None;
    let mut counts = Counts::new();
    for (number, line) in (1..).zip(text.lines()) {
        let wrong = || format!("{}:{number}: expected \"NAME COUNT\": {line:?}", baselines().display());
        let (name, value) = line.split_once(' ').ok_or_else(wrong)?;
        if name == "level" {
            level = Some(value.to_owned());
        } else {
            counts.insert(name.to_owned(), value.parse().map_err(|_| wrong())?);
        }
    }
    Ok((level.ok_or("the baselines tell no level")?, counts))
}

/// Instructions of one draw of each kernel, and the level they are of.
fn count_all() -> Result<(String, Counts), Box<dyn Error>> {
    let mut level = String::new();
    let mut counts = Counts::new();
    for case in &ALL {
        let [few, many] = [count(case.name, TIMES[0])?, count(case.name, TIMES[1])?];
        level = few.0;
        counts.insert(case.name.to_owned(), (many.1 - few.1) / u64::from(TIMES[1] - TIMES[0]));
    }
    Ok((level, counts))
}

/// The level, and all instructions of a process that draws a kernel so many times.
fn count(name: &str, times: u32) -> Result<(String, u64), Box<dyn Error>> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe()?)
        .args(["run", name, &times.to_string()])
        .output()
        .map_err(|e| format!("valgrind does not start (Debian package valgrind): {e}"))?;
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let level = out.lines().find_map(|line| line.strip_prefix("level "));
    let collected = err.lines().find_map(|line| line.split_once("Collected : "));
    let (Some(level), Some((_, collected))) = (level, collected) else {
        return Err(format!("valgrind tells no count of {name}: {err}").into());
    };
    Ok((level.to_owned(), collected.trim().parse()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_twentieth_more_is_allowed_and_no_more() {
        assert!(!is_too_many(1_050, 1_000) && !is_too_many(10, 1_000));
        assert!(is_too_many(1_051, 1_000) && is_too_many(u64::MAX, u64::MAX / 2));
    }

    #[test]
    fn every_kernel_has_a_baseline_and_a_broken_file_tells_its_line() {
        let text = std::fs::read_to_string(baselines()).expect("baselines");
        let (level, counts) = parse(&text).expect("well formed");
        assert!(!level.is_empty());
        assert!(ALL.iter().all(|case| counts.get(case.name).is_some_and(|&count| count > 0)));
        let error = parse("level avx2\nnomotion_1spp many\n").expect_err("no number").to_string();
        assert!(
            error.ends_with("instructions.txt:2: expected \"NAME COUNT\": \"nomotion_1spp many\""),
            "{error}"
        );
    }
}
