//! `olema bench`: the standard scenes, on the path that `olema render` takes, and what each of them took.
//!
//! In: names of scenes. Out: a line a scene, or JSON ([`report`]). No picture is kept, and no file is written.
//!
//! Each run is a process of its own, the same executable with `--alone`, so that its peak memory is that of the
//! scene, and no run finds what another left in the allocator. Scenes are written in memory before the clock starts
//! (see [`scenes`]); the peak has in it what is not yet read of that text.

mod report;
mod rib;
mod scenes;
mod text;

use std::process::{Command, Stdio};
use std::time::Instant;

use olema::{Hooks, Renderer, Scene, Settings};
use olema_formats::rib::{ReadOptions, RibReader};

use crate::args::BenchArgs;
use crate::exit::{self, Failure};
use crate::memory::Budget;
use crate::{report as messages, stats_file, values};
use report::Run;
use scenes::{ALL, Source, Standard};
use text::Text;

/// Runs what was asked for. Returns the exit code.
pub fn run(args: &BenchArgs) -> u8 {
    let mut reporter = messages::Reporter::new(messages::Options::default());
    match bench(args) {
        Ok(()) => exit::OK,
        Err(failure) => reporter.failure(&failure),
    }
}

fn bench(args: &BenchArgs) -> Result<(), Failure> {
    let chosen = chosen(&args.names)?;
    if args.alone {
        for scene in chosen {
            let run = draw(if args.quick { scene.quick() } else { scene }, args.threads)?;
            messages::print(&format!("{}\n", report::to_line(&run)?))?;
        }
        return Ok(());
    }
    let mut results = Vec::new();
    if !args.json {
        messages::print(&report::header())?;
    }
    for scene in chosen {
        let runs = (0..args.runs).map(|_| in_child(&scene, args)).collect::<Result<Vec<Run>, Failure>>()?;
        let result = report::median(&runs);
        if !args.json {
            messages::print(&report::row(&result))?;
        }
        results.push(result);
    }
    if args.json { messages::print(&report::json(args.runs, &results)?) } else { Ok(()) }
}

/// The scenes that were named, all if none was.
fn chosen(names: &[String]) -> Result<Vec<Standard>, Failure> {
    if names.is_empty() {
        return Ok(ALL.to_vec());
    }
    let mut chosen = Vec::new();
    for name in names {
        let found = scenes::named(name);
        if found.is_empty() {
            let known: Vec<&str> = ALL.iter().map(|scene| scene.name).collect();
            let message = format!(
                "there is no scene {name:?}; expected one of {}, or how several of them begin, as torus does",
                known.join(", ")
            );
            return Err(Failure::new(exit::USAGE, message));
        }
        chosen.extend(found);
    }
    Ok(chosen)
}

/// Draws a scene in a process of its own.
fn in_child(scene: &Standard, args: &BenchArgs) -> Result<Run, Failure> {
    let fail = |problem: &dyn std::fmt::Display| {
        Failure::new(exit::RENDER, format!("scene {}: {problem}", scene.name))
    };
    let mut command = Command::new(std::env::current_exe().map_err(|e| fail(&e))?);
    command.args(["bench", "--alone", scene.name, &format!("--threads={}", args.threads)]);
    command.args(args.quick.then_some("--quick"));
    let output = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output().map_err(|e| fail(&e))?;
    if !output.status.success() {
        return Err(fail(&output.status));
    }
    report::from_line(&String::from_utf8_lossy(&output.stdout)).map_err(|e| fail(&e.message))
}

/// Draws a scene once, as `olema render` does.
fn draw(standard: Standard, threads: i32) -> Result<Run, Failure> {
    let (source, memory) = (standard.source(), Budget::new(None));
    let began = Instant::now();
    let (scene, mut settings) = match source {
        Source::Built(built) => *built,
        Source::Rib(text) => read(standard.name, text, memory)?,
    };
    let read_seconds = began.elapsed().as_secs_f64();
    settings.threads = values::threads(threads, std::thread::available_parallelism().map_or(1, usize::from));
    memory.limit(&mut settings);
    let clock = || began.elapsed().as_secs_f64();
    let hooks = Hooks { clock: Some(&clock), ..Hooks::default() };
    let renderer = Renderer::new(settings)?;
    let mut stats = renderer.render_rows(scene, &hooks, &mut |_| {})?;
    stats.seconds.read = read_seconds;
    stats.peak_memory = stats_file::peak_memory();
    Ok(Run::new(standard.name, renderer.settings(), &stats))
}

/// Reads a scene. A standard scene about which the reader has anything to say is a mistake in this program.
fn read(name: &str, text: Text, memory: Budget) -> Result<(Scene, Settings), Failure> {
    let fail = |problem: String| Failure::new(exit::SCENE, format!("scene {name}: {problem}"));
    let options = ReadOptions { memory: memory.reader(), ..ReadOptions::default() };
    let mut reader = RibReader::from_stream(name, Box::new(text), options);
    let frame = reader.next_frame().map_err(|error| fail(error.to_string()))?;
    if let Some(said) = reader.take_diagnostics().first() {
        return Err(fail(said.message.clone()));
    }
    let frame = frame.ok_or_else(|| fail("there is no world in it".to_owned()))?;
    Ok((frame.scene, frame.settings))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_name_lists_the_known_ones() {
        let failure = chosen(&["teapot".to_owned(), "kettle".to_owned()]).expect_err("unknown");
        assert_eq!(failure.code, exit::USAGE);
        assert!(failure.message.contains("\"kettle\""), "{}", failure.message);
        assert!(ALL.iter().all(|scene| failure.message.contains(scene.name)), "{}", failure.message);
    }

    #[test]
    fn models_have_the_counts_that_they_stand_for() {
        for (name, patches) in
            [("creature", 11_532), ("teapot-blur", 32), ("torus-both-16-800", 24 * 10 * 64)]
        {
            let run = draw(scenes::named(name)[0].quick(), 1).expect("a run");
            assert_eq!(run.patches, patches, "{name}");
        }
        let Source::Rib(text) = scenes::named("creased")[0].source() else { panic!("not a text") };
        let (scene, _) = read("creased", text, Budget::new(None)).expect("a scene");
        let olema::scene::Geometry::Subdivision(mesh) = &scene.primitives[0].geometry else {
            panic!("no mesh")
        };
        assert_eq!(mesh.face_vertex_counts.len(), 1575);
        assert_eq!(mesh.creases.iter().map(|crease| crease.vertices.len() - 1).sum::<usize>(), 315);
    }
}
