//! EXR layers beyond colour (AOVs), under the names that users know.

use crate::film::Plane;

/// An extra layer of the EXR image.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    PartialOrd,
    Ord,
    serde::Serialize,
    serde::Deserialize,
    strum::VariantArray,
    strum::IntoStaticStr,
    strum::EnumMessage,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum Aov {
    /// Albedo at the first hit that is not a mirror or glass.
    Albedo,
    /// Shading normal at that hit, in world space.
    Normal,
    /// Distance from the camera along the ray in scene units.
    Depth,
    /// Position in the file's world space.
    Position,
    /// Index of the instance at the pixel's centre, from 0; −1 where there is none.
    Instance,
    /// Index of the material at the pixel's centre, from 0; −1 where there is none.
    Material,
    /// Number of non-finite samples of the pixel.
    Invalid,
    /// 1 where a single chain of a Metropolis method brought most of the light: the error is unknown there.
    ErrorUnknown,
}

/// Source of a layer's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    /// A plane of the film.
    Plane(Plane),
    /// Instance indices at the pixel centres.
    InstanceIds,
    /// Material indices at the pixel centres.
    MaterialIds,
    /// Mask of the tiles that owe most of their light to one chain.
    OwnedTiles,
}

impl Aov {
    /// Returns the source of the layer's values.
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

    /// Returns the names of the layer's channels in the EXR file.
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
