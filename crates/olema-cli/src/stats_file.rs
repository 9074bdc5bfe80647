//! `--stats FILE.json`: what a run did, picture by picture. docs/stats.md says what each field means.

use std::path::{Path, PathBuf};

use olema::{Settings, Stats};
use serde::Serialize;

use crate::exit::{self, Failure};
use crate::output;

/// The file.
#[derive(Debug, Serialize)]
pub struct StatsFile {
    olema: &'static str,
    frames: Vec<FrameRecord>,
}

/// One picture.
#[derive(Debug, Serialize)]
pub struct FrameRecord {
    /// The scene, as the user named it.
    pub scene: String,
    /// Number of the frame.
    pub frame: i32,
    /// Where the picture was written.
    pub picture: String,
    /// How it was made.
    pub settings: SettingsRecord,
    /// What it took.
    pub stats: Stats,
}

/// [`Settings`], spelled for the file.
#[derive(Debug, Serialize)]
pub struct SettingsRecord {
    resolution: [u32; 2],
    crop_px: Option<[u32; 4]>,
    samples: [u32; 2],
    filter: String,
    filter_width: [f32; 2],
    shading_rate: Option<f32>,
    shading_rate_scale: f32,
    motion_factor: Option<f32>,
    focus_factor: Option<f32>,
    motion_tolerance_px: f32,
    shading_time: f32,
    exposure: [f32; 2],
    background: Option<[f32; 3]>,
    seed: u32,
    jitter: bool,
    pattern_tile: Option<u32>,
    permutations: u32,
    grid_size: u32,
    eye_splits: u32,
    rasterizer: String,
    cull: String,
    cull_at: String,
    cull_leaf_px: u32,
    cull_slices: u32,
    cull_order: String,
    shade: String,
    threads: usize,
    bucket: [u32; 2],
    raster_tile: Option<u32>,
    memory: u64,
    picture_memory: u64,
    transparency_records: usize,
    grid_cache: u64,
}

impl SettingsRecord {
    /// The record of these settings; `shading_rate` is the option of that name, `memory` the whole budget in bytes.
    pub fn new(settings: &Settings, shading_rate: Option<f32>, memory: u64) -> Self {
        // Taken apart in full, so that no new setting is forgotten here.
        let &Settings {
            resolution,
            crop_px,
            samples,
            filter,
            shading_rate_scale,
            motion_factor,
            focus_factor,
            motion_tolerance_px,
            shading_time,
            exposure,
            background,
            seed,
            jitter,
            pattern_tile,
            permutations,
            grid_size,
            eye_splits,
            rasterizer,
            cull,
            shade,
            threads,
            bucket,
            tile: raster_tile,
            picture_memory,
            transparency_records,
            grid_cache,
        } = settings;
        SettingsRecord {
            resolution,
            crop_px,
            samples,
            filter: format!("{:?}", filter.kind),
            filter_width: filter.width,
            shading_rate,
            shading_rate_scale,
            motion_factor,
            focus_factor,
            motion_tolerance_px,
            shading_time,
            exposure,
            background,
            seed,
            jitter,
            pattern_tile,
            permutations,
            grid_size,
            eye_splits,
            rasterizer: rasterizer.to_string(),
            cull: cull.kind.to_string(),
            cull_at: cull.at.to_string(),
            cull_leaf_px: cull.leaf_px,
            cull_slices: cull.num_slices(),
            cull_order: cull.order.to_string(),
            shade: shade.to_string(),
            threads,
            bucket,
            raster_tile,
            memory,
            picture_memory,
            transparency_records,
            grid_cache,
        }
    }
}

impl StatsFile {
    /// A file without frames.
    pub fn new() -> Self {
        StatsFile { olema: env!("CARGO_PKG_VERSION"), frames: Vec::new() }
    }

    /// Adds a picture.
    pub fn push(&mut self, record: FrameRecord) {
        self.frames.push(record);
    }

    /// Writes the file under a temporary name and renames it, so that a reader never sees half of it.
    ///
    /// # Errors
    /// A render failure with the system's word.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        let fail = |error: &dyn std::fmt::Display| {
            Failure::new(exit::RENDER, format!("--stats {}: {error}", path.display()))
        };
        output::check_place(path).map_err(|e| fail(&e))?;
        let mut text = serde_json::to_string_pretty(self).map_err(|e| fail(&e))?;
        text.push('\n');
        let temporary = temporary_name(path);
        let written = std::fs::write(&temporary, text).and_then(|()| std::fs::rename(&temporary, path));
        written.map_err(|error| {
            let _ = std::fs::remove_file(&temporary);
            fail(&error)
        })
    }
}

fn temporary_name(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    PathBuf::from(name)
}

/// Peak resident memory of this process in bytes; 0 where the system does not tell.
pub fn peak_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:")).unwrap_or_default();
    let kib = line.trim().trim_end_matches("kB").trim().parse().unwrap_or(0u64);
    kib.saturating_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    fn example() -> StatsFile {
        let mut file = StatsFile::new();
        file.push(FrameRecord {
            scene: "teapot.rib".to_owned(),
            frame: 1,
            picture: "teapot.png".to_owned(),
            settings: SettingsRecord::new(&Settings::default(), None, 0),
            stats: Stats::default(),
        });
        file
    }

    /// Dotted names of all fields; the elements of an array of objects share theirs.
    fn fields(value: &Value, prefix: &str, out: &mut Vec<String>) {
        match value {
            Value::Object(map) => {
                for (key, value) in map {
                    let name = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
                    out.push(name.clone());
                    fields(value, &name, out);
                }
            }
            Value::Array(items) => items.iter().for_each(|item| fields(item, prefix, out)),
            _ => {}
        }
    }

    #[test]
    fn docs_and_file_have_the_same_fields() {
        let mut written = Vec::new();
        fields(&serde_json::to_value(example()).unwrap(), "", &mut written);
        let docs = include_str!("../../../docs/stats.md");
        let documented: Vec<String> = docs
            .lines()
            .filter_map(|line| line.strip_prefix("| `")?.split_once('`'))
            .map(|(name, _)| name.to_owned())
            .collect();
        for name in &written {
            assert!(documented.contains(name), "docs/stats.md lacks {name}");
        }
        for name in &documented {
            assert!(written.contains(name), "docs/stats.md documents {name}, which is not written");
        }
    }

    #[test]
    fn the_file_is_whole_or_absent() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("s.json");
        example().write(&path).unwrap();
        example().write(&path).unwrap();
        let value: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        assert_eq!(value["frames"][0]["scene"], "teapot.rib");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
        let failure = example().write(&dir.path().join("no/s.json")).unwrap_err();
        assert_eq!(failure.code, exit::RENDER);
        assert!(failure.message.starts_with("--stats "));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn linux_tells_the_peak_memory() {
        assert!(peak_memory() > 100_000);
    }
}
