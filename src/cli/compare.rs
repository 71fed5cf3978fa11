//! `etendue compare`: the error of an image against a reference, and a test for equal means.

use super::args::ThreadArgs;
use super::{Console, startup};
use crate::error::Result;
use crate::lab::compare::maps::{self, Map};
use crate::lab::compare::{CompareOutcome, Comparison, ImagePair, MeanDifference, Metrics, Origin, Rejection};
use crate::session::writable;
use std::path::PathBuf;

/// Default family-wise level: the probability that images of the same mean are reported as different.
const LEVEL: f64 = 1e-3;

/// Arguments of `compare`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Exit code 7 if the means differ, 0 if they are identical, no difference was found or nothing \
    could be tested (the verdict says which). The test: Welch's t of each channel of the image and of its tiles, \
    Holm-corrected, with errors made of what the pixels of the method share; both images need three replicates or more \
    and seeds of their own, as two renders with different --seed have.")]
pub(super) struct Args {
    /// The image, an .exr file
    image: PathBuf,
    /// The reference, an .exr file
    reference: PathBuf,
    /// Probability that images of the same mean are reported as different
    #[arg(long, default_value_t = LEVEL, value_parser = level)]
    level: f64,
    /// The ε of relMSE, in squared units of the image [default: (0.1 × mean of the reference)²]
    #[arg(long, value_name = "E", value_parser = epsilon)]
    epsilon: Option<f64>,
    #[command(flatten)]
    maps: MapArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    console: Console,
}

/// Maps to write, each an .exr with the values or a .png in colours.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Maps (.exr or .png)")]
struct MapArgs {
    /// Write the difference, image less reference
    #[arg(long, value_name = "PATH")]
    difference: Option<PathBuf>,
    /// Write the difference over its standard error
    #[arg(long, value_name = "PATH")]
    z: Option<PathBuf>,
    /// Write HDR FLIP, the visibility of the difference, from 0 to 1
    #[arg(long, value_name = "PATH")]
    flip: Option<PathBuf>,
}

fn level(text: &str) -> std::result::Result<f64, String> {
    let level = text.parse().ok().filter(|&level| level > 0.0 && level < 1.0);
    level.ok_or_else(|| "a level is a probability between 0 and 1".into())
}

fn epsilon(text: &str) -> std::result::Result<f64, String> {
    let epsilon = text.parse().ok().filter(|&e: &f64| e >= 0.0 && e.is_finite());
    epsilon.ok_or_else(|| "ε is a number and not negative".into())
}

/// Compares two images.
pub(super) fn run(args: Args) -> Result<()> {
    let console = args.console;
    for path in [&args.maps.difference, &args.maps.z, &args.maps.flip].into_iter().flatten() {
        maps::check_ending(path)?;
        writable(path)?;
    }
    startup::start_threads(args.threads)?;
    let pair = ImagePair::read(&args.image, &args.reference)?;
    let comparison = pair.compare(args.level, args.epsilon);
    console.document(&comparison)?;
    lines(&comparison).iter().try_for_each(|line| console.line(line))?;
    write(&pair, "difference", args.maps.difference, console, || Ok(pair.difference()))?;
    if args.maps.z.is_some() && comparison.verdict.outcome == CompareOutcome::Untested {
        console.warn(&format!("the z-scores mean little: {}", comparison.verdict.sentence()));
    }
    write(&pair, "z-scores", args.maps.z, console, || pair.z_scores())?;
    write(&pair, "flip", args.maps.flip, console, || Ok(pair.flip()))?;
    comparison.require_agreement()
}

fn write(
    pair: &ImagePair,
    what: &str,
    path: Option<PathBuf>,
    console: Console,
    map: impl FnOnce() -> Result<Map>,
) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    let scale = pair.write(&map()?, &path)?.map(|scale| format!(" ({scale})")).unwrap_or_default();
    console.line(&format!("{what}: {}{scale}", path.display()))
}

fn lines(comparison: &Comparison) -> Vec<String> {
    let Comparison { image, reference, size: [width, height], metrics, verdict } = comparison;
    let mut lines = vec![format!("image      {}", origin(image)), format!("reference  {}", origin(reference))];
    lines.push(format!(
        "size       {width}x{height}, {} of {} values not finite",
        metrics.non_finite,
        3 * width * height
    ));
    lines.extend(figures(metrics));
    lines.extend(verdict.means.iter().map(mean));
    lines.extend(verdict.rejections.iter().map(rejection));
    lines.push(format!("verdict    {}", verdict.sentence()));
    lines
}

fn origin(origin: &Origin) -> String {
    let mut text = format!("{}:", origin.path);
    let mut add = |part: Option<String>| part.into_iter().for_each(|part| text.push_str(&format!(" {part},")));
    add(origin.method.clone());
    add(origin.spp.map(|spp| format!("{spp} spp")));
    add(origin.seed.map(|seed| format!("seed {seed}")));
    add(origin.relmse.map(|[value, low, high]| format!("relMSE {value:.3e} 95% [{low:.3e}, {high:.3e}]")));
    let hash = &origin.pixel_hash[..16.min(origin.pixel_hash.len())];
    let known = match origin.hash_matches {
        Some(true) => "as in its header",
        Some(false) => "NOT those in its header: changed after rendering",
        None => "no hash in its header",
    };
    format!("{text} pixels {hash} ({known})")
}

fn figures(metrics: &Metrics) -> [String; 2] {
    let Metrics { mse, mae, relmse, relmse_epsilon, smape, psnr, flip_ldr, flip_hdr, flip_steps, .. } = metrics;
    let ([low, high], ppd) = (metrics.flip_exposures, metrics.flip_pixels_per_degree);
    [
        format!(
            "error      MSE {mse:.4e}, MAE {mae:.4e}, relMSE {relmse:.4e} (ε = {relmse_epsilon:.3e}), SMAPE \
             {smape:.4e}, PSNR {psnr:.2} dB (sRGB, peak 1)"
        ),
        format!(
            "FLIP       LDR {flip_ldr:.6}, HDR {flip_hdr:.6} ({flip_steps} exposures from {low:.2} to {high:.2} \
             stops), at {ppd:.2} pixels per degree"
        ),
    ]
}

fn mean(mean: &MeanDifference) -> String {
    let MeanDifference { channel, difference, interval: [low, high], reference } = mean;
    let percent = 100.0 * difference / reference;
    format!("mean {channel}     {difference:+.3e} 95% [{low:+.3e}, {high:+.3e}], {percent:+.3} % of {reference:.6}")
}

fn rejection(rejection: &Rejection) -> String {
    let Rejection { channel, tile, size: [width, height], difference, standard_error, p } = rejection;
    let place = tile.map_or_else(|| "image".into(), |[x, y]| format!("{width}x{height} tile at {x},{y}"));
    format!("differs    {channel} of the {place}: {difference:+.3e} ± {standard_error:.1e}, corrected p {p:.2e}")
}
