//! Extra layers by the names that users know.

use crate::film::Plane;

/// An extra layer of the EXR image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Aov {
    /// Reflectance at the first hit that is not a mirror or glass.
    Albedo,
    /// Shading normal there, world space.
    Normal,
    /// Distance from the camera along the ray in scene units.
    Depth,
    /// Position in the file's world space.
    Position,
    /// Number of the instance at the pixel's centre, from 0; −1 where there is none.
    Instance,
    /// Number of the material at the pixel's centre, from 0; −1 where there is none.
    Material,
    /// How many samples of the pixel were not finite.
    Invalid,
    /// 1 where most of the light was brought by a single chain of a Metropolis method: nothing is known of its error.
    ErrorUnknown,
}

/// Where a layer comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    /// A plane of the film.
    Plane(Plane),
    /// The instances seen through the pixel centres.
    InstanceIds,
    /// The materials seen through the pixel centres.
    MaterialIds,
    /// The tiles that one chain owns.
    OwnedTiles,
}

impl Aov {
    /// Where the layer comes from.
    pub(super) fn source(self) -> Source {
        match self {
            Aov::Albedo => Source::Plane(Plane::Albedo),
            Aov::Normal => Source::Plane(Plane::Normal),
            Aov::Depth => Source::Plane(Plane::Depth),
            Aov::Position => Source::Plane(Plane::Position),
            Aov::Invalid => Source::Plane(Plane::Invalid),
            Aov::Instance => Source::InstanceIds,
            Aov::Material => Source::MaterialIds,
            Aov::ErrorUnknown => Source::OwnedTiles,
        }
    }

    /// The names of the layer's channels in the EXR file.
    pub(super) fn channels(self) -> &'static [&'static str] {
        match self {
            Aov::Albedo => &["albedo.R", "albedo.G", "albedo.B"],
            Aov::Normal => &["normal.X", "normal.Y", "normal.Z"],
            Aov::Depth => &["depth.Z"],
            Aov::Position => &["position.X", "position.Y", "position.Z"],
            Aov::Instance => &["instance.id"],
            Aov::Material => &["material.id"],
            Aov::Invalid => &["invalid.count"],
            Aov::ErrorUnknown => &["error-unknown.is"],
        }
    }
}
