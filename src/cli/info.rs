//! `etendue info`: the content of a scene, and the resources that rendering it takes.

use super::args::{SceneArgs, ThreadArgs};
use super::{Console, startup};
use crate::error::Result;
use crate::film::Film;
use crate::integrator::{self, Execution};
use crate::named::Named;
use crate::scene::SceneInfo;
use crate::session::{RenderSettings, megabytes};
use serde::Serialize;

/// Arguments of `info`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    console: Console,
}

#[derive(Serialize)]
struct Document {
    path: String,
    hash: String,
    #[serde(flatten)]
    info: SceneInfo,
    cameras: Vec<String>,
    blind_spots: Vec<String>,
    /// How `path` is executed.
    execution: Execution,
    settings: RenderSettings,
    memory: Memory,
    load_seconds: f64,
    build_seconds: f64,
}

/// Memory of a render in bytes, by purpose.
#[derive(Serialize)]
struct Memory {
    film_bytes: u64,
    geometry_bytes: u64,
    accel_bytes: u64,
    texture_bytes: u64,
    light_tree_bytes: u64,
    density_bytes: u64,
    total_bytes: u64,
}

/// Describes a scene.
pub(super) fn run(args: Args) -> Result<()> {
    let choices = args.scene.choices()?;
    let threads = startup::start_threads(args.threads)?;
    let (stage, job) = args.scene.load(&choices, threads)?;
    let settings = job.settings;
    let document = Document {
        path: stage.path.display().to_string(),
        hash: stage.scene.hash().to_owned(),
        cameras: stage.scene.cameras(),
        blind_spots: integrator::missing_light(settings.method.kind(), &stage.scene),
        execution: Execution::chosen(settings.execution, &stage.scene),
        memory: Memory::estimate(&settings, &stage.info),
        settings,
        load_seconds: stage.preparation.load_seconds,
        build_seconds: stage.preparation.build_seconds,
        info: stage.info,
    };
    args.console.document(&document)?;
    document.lines().iter().try_for_each(|line| args.console.line(line))
}

impl Memory {
    fn estimate(settings: &RenderSettings, info: &SceneInfo) -> Self {
        let layout = settings.layout();
        let film_bytes = Film::bytes_per_pixel(&layout, settings.replicates) as u64 * layout.pixels() as u64;
        Memory {
            film_bytes,
            geometry_bytes: info.geometry_bytes as u64,
            accel_bytes: info.accel_bytes as u64,
            texture_bytes: info.texture_bytes as u64,
            light_tree_bytes: info.light_tree_bytes as u64,
            density_bytes: info.density_bytes as u64,
            total_bytes: film_bytes + info.bytes() as u64,
        }
    }
}

impl Document {
    fn lines(&self) -> Vec<String> {
        let (info, memory, settings) = (&self.info, &self.memory, &self.settings);
        let mut lines = vec![
            format!("scene      {} ({})", self.path, self.hash),
            format!("triangles  {} in {} meshes, {} instances", info.triangles, info.meshes, info.instances),
            format!("materials  {}", info.materials),
            format!(
                "lights     {}{}",
                info.lights,
                if info.light_tree_bytes > 0 { ", selected by a light tree" } else { "" }
            ),
            format!("images     {}", info.images),
            format!("cameras    {}", list(&self.cameras)),
            format!("animations {}", list(&info.animations)),
            format!("features   {}", list(&info.features)),
            format!("execution  {} for path", self.execution.name()),
            format!("extent     centre {:?}, scale {}", info.centre.to_array(), info.scale),
            format!(
                "memory     {} in all: film {} ({}x{}, {} replicates), geometry {}, ray tracing {}, textures {}, light tree {}, densities {}",
                megabytes(memory.total_bytes),
                megabytes(memory.film_bytes),
                settings.width,
                settings.height,
                settings.replicates,
                megabytes(memory.geometry_bytes),
                megabytes(memory.accel_bytes),
                megabytes(memory.texture_bytes),
                megabytes(memory.light_tree_bytes),
                megabytes(memory.density_bytes)
            ),
            format!("loading    {:.3} s, building {:.3} s", self.load_seconds, self.build_seconds),
        ];
        lines.extend(info.ignored.iter().map(|text| format!("ignored    {text}")));
        lines.extend(self.blind_spots.iter().map(|text| format!("blind      {text}")));
        lines.extend(info.warnings.iter().map(|text| format!("warning    {text}")));
        lines
    }
}

fn list(items: &[String]) -> String {
    if items.is_empty() { "none".into() } else { items.join(", ") }
}
