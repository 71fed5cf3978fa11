//! Integrators: what one pass of a method does. An integrator has no hidden state: a pass is a pure function of
//! (scene, settings, seed, pass). To add one, write its file, implement [`Integrator`] and give it a name in [`Method`].

mod method;
mod path;

pub use method::Method;
pub use path::{Integrator, Options, Prelude, build, ids, prelude};

/// How many rays of each kind were traced.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct RayCounts {
    /// From the camera.
    pub camera: u64,
    /// From a scattering event.
    pub bounce: u64,
    /// Visibility tests.
    pub shadow: u64,
}

/// How often each guard dropped or changed something. All zero in a healthy render.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Guards {
    /// Samples that were not finite and count as black.
    pub nonfinite: u64,
    /// Hits that could not be recomputed from their triangle (slivers) and were passed through.
    pub bad_hits: u64,
    /// Paths cut at the emergency length limit.
    pub overlong_paths: u64,
    /// Samples that `--clamp` reduced: the image is biased.
    pub clamped: u64,
    /// Sum over lanes of what was clamped away, in radiance × samples.
    pub clamped_energy: f64,
}

/// A sample that was not finite, so that it can be replayed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct InvalidSample {
    /// The pass it belongs to.
    pub pass: u64,
    /// Column of its pixel.
    pub x: u32,
    /// Row of its pixel.
    pub y: u32,
}

/// What a pass did besides its samples.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PassReport {
    /// Rays traced.
    pub rays: RayCounts,
    /// Guards that fired.
    pub guards: Guards,
    /// The first samples that were not finite, at most [`PassReport::MAX_INVALID`].
    pub invalid: Vec<InvalidSample>,
}

impl PassReport {
    /// How many invalid samples are kept by address.
    pub const MAX_INVALID: usize = 16;

    /// Adds what another part or pass did. Sums are order-free but for the rounding of `clamped_energy`.
    pub fn absorb(&mut self, other: PassReport) {
        let (r, o) = (&mut self.rays, other.rays);
        r.camera += o.camera;
        r.bounce += o.bounce;
        r.shadow += o.shadow;
        let (g, o) = (&mut self.guards, other.guards);
        g.nonfinite += o.nonfinite;
        g.bad_hits += o.bad_hits;
        g.overlong_paths += o.overlong_paths;
        g.clamped += o.clamped;
        g.clamped_energy += o.clamped_energy;
        self.invalid.extend(other.invalid);
        self.invalid.truncate(Self::MAX_INVALID);
    }
}
