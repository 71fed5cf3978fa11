//! Renders by the binary, and means over parts of them.

use etendue::io::exr::{self, ExrImage};
use std::path::Path;
use std::process::Command;

/// A picture, and the console output.
pub(crate) struct Picture {
    pub(crate) image: ExrImage,
    pub(crate) console: String,
    /// Whether its pixels share chains.
    chains: bool,
}

/// Mean of a part of a picture, and a bound of its standard error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mean {
    pub(crate) value: [f64; 3],
    pub(crate) error: [f64; 3],
}

/// Standard errors that a mean may be off: 6e-7 for a normal one, and little for a skewed one.
const SIGMAS: f64 = 5.0;

/// By how much splats that several pixels share may make the variance of a mean larger (docs/measurements.md).
const SHARED: f64 = 1.5;

/// `etendue render` of scenes/met/`file` with more options, by `backend`, which succeeds.
pub(crate) fn render(file: &str, options: &str, backend: &str) -> Picture {
    try_render(file, options, backend).unwrap_or_else(|console| panic!("{file} {options}: {console}"))
}

/// The same, or the console output of a failure.
pub(crate) fn try_render(file: &str, options: &str, backend: &str) -> Result<Picture, String> {
    let place = tempfile::tempdir().expect("a folder");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/met").join(file);
    let out = place.path().join("x.exr");
    let mut command = Command::new(env!("CARGO_BIN_EXE_etendue"));
    command.current_dir(scene.parent().expect("a folder")).arg("render").arg(&scene);
    command.args(options.split_whitespace()).args(["--filter", "box", "--backend", backend, "-o"]).arg(&out);
    let ran = command.output().expect("the binary");
    let console = String::from_utf8_lossy(&ran.stderr).into_owned();
    if ran.status.success() {
        Ok(Picture { image: exr::read(&out).expect("an image"), console, chains: options.contains("mlt") })
    } else {
        Err(console)
    }
}

/// The backends of this build.
pub(crate) fn backends() -> impl Iterator<Item = &'static str> {
    etendue::accel::Backend::AVAILABLE.iter().map(|&backend| etendue::named::Named::name(backend))
}

impl Picture {
    /// The mean over the pixels of `[left, top, right, bottom]`, as shares of the picture.
    pub(crate) fn mean(&self, part: [f64; 4]) -> Mean {
        let (width, height) = (self.image.width as usize, self.image.height as usize);
        let at = |share: f64, size: usize| (share * size as f64).round() as usize;
        let columns = at(part[0], width)..at(part[2], width);
        let rows = at(part[1], height)..at(part[3], height);
        let count = (rows.len() * columns.len()) as f64;
        let mean = |name: &str, power: i32| {
            let values = self.image.channel(name).expect("a layer");
            let pixels = rows.clone().flat_map(|y| columns.clone().map(move |x| f64::from(values[y * width + x])));
            pixels.map(|v| v.powi(power)).sum::<f64>() / count
        };
        let error = |name: &str| match self.chains {
            true => mean(name, 1), // of pixels that agree in their noise: a bound
            false => (SHARED * mean(name, 2) / count).sqrt(),
        };
        let value = ["R", "G", "B"].map(|lane| mean(lane, 1));
        Mean { value, error: ["stderr.R", "stderr.G", "stderr.B"].map(error) }
    }
}

impl Mean {
    /// Whether it is `right`, which is known within `within`.
    pub(crate) fn is(&self, right: [f64; 3], within: f64) -> bool {
        (0..3).all(|lane| (self.value[lane] - right[lane]).abs() <= within + SIGMAS * self.error[lane])
    }

    /// Whether no lane is above `most` but by noise.
    pub(crate) fn is_at_most(&self, most: [f64; 3]) -> bool {
        (0..3).all(|lane| self.value[lane] <= most[lane] + SIGMAS * self.error[lane])
    }
}
