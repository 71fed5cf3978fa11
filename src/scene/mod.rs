//! The scene that integrators see: geometry behind a backend, materials, lights. It answers what a ray meets, what scatters
//! there, what emits there, and how much light passes between two points.

mod assemble;
mod bodies;
mod build;
mod coincident;
mod contact;
pub mod description;
mod edge;
mod extent;
mod info;
mod material;
mod query;
mod rebase;
mod surroundings;
mod touching;
mod usage;
mod view;

pub use build::BuildOptions;
pub use edge::{Edge, Passage};
pub use info::SceneInfo;
pub use rebase::Rebase;

use crate::accel::{Accel, Backend};
use crate::geometry::Geometry;
use crate::light::{Ball, Lights};
use bodies::AllBodies;
use material::Material;

/// A scene ready to render. Lengths are scene units: the file's, rebased by [`Scene::rebase`].
pub struct Scene {
    geometry: Geometry,
    objects: Vec<ObjectInfo>,
    materials: Vec<Material>,
    bodies: AllBodies,
    lights: Lights,
    accel: Accel,
    /// Surfaces that touch where one lets light pass, if there are any.
    contacts: Option<Box<contact::Contacts>>,
    rebase: Rebase,
    ball: Ball,
    features: Features,
    views: view::Views,
    info: SceneInfo,
    hash: String,
}

/// What a scene needs from the kernels that render it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Features {
    /// Some surface has an alpha mask.
    pub masks: bool,
    /// Some surface blends by alpha.
    pub blends: bool,
    /// Some surface is not there for the camera when seen from behind.
    pub culled: bool,
    /// Some object absorbs light inside.
    pub media: bool,
    /// Some surface lets light straight through.
    pub panes: bool,
    /// Some bodies may lie in others.
    pub nested: bool,
    /// Some material looks textures up.
    pub textures: bool,
    /// Some material bends normals.
    pub normal_maps: bool,
    /// Some mesh has shading normals.
    pub shading_normals: bool,
    /// Some material is a mirror or clear glass.
    pub dirac: bool,
    /// Some material refracts.
    pub refraction: bool,
    /// Some mesh stands at several places.
    pub instances: bool,
    /// Some light has no extent.
    pub dirac_lights: bool,
    /// Some surface that lets light pass touches another.
    pub contacts: bool,
}

impl Features {
    /// Whether edges between vertices may pass surfaces.
    #[inline]
    pub fn content(&self) -> bool {
        self.blends || self.panes || self.nested
    }

    /// The names of those that are there.
    pub fn names(&self) -> Vec<&'static str> {
        [
            ("alpha-mask", self.masks),
            ("alpha-blend", self.blends),
            ("single-sided", self.culled),
            ("absorption", self.media),
            ("panes", self.panes),
            ("nested-bodies", self.nested),
            ("textures", self.textures),
            ("normal-maps", self.normal_maps),
            ("shading-normals", self.shading_normals),
            ("dirac-materials", self.dirac),
            ("refraction", self.refraction),
            ("instances", self.instances),
            ("dirac-lights", self.dirac_lights),
            ("contacts", self.contacts),
        ]
        .into_iter()
        .filter_map(|(name, there)| there.then_some(name))
        .collect()
    }
}

/// What shading needs to know of an object besides its geometry.
#[derive(Debug, Clone, Copy)]
struct ObjectInfo {
    /// Index into [`Scene::materials`].
    material: u32,
    /// Index of the light on the object's first triangle, if its triangles are lights.
    first_light: Option<u32>,
    /// Index of the instance in the file's order.
    instance: u32,
    /// Whether its mesh has vertex colours.
    colors: bool,
    /// The body whose boundary it is, or [`crate::geometry::Bodies::NOBODY`].
    body: u32,
    /// Whether light may pass it straight on, wherever it stands.
    passes: bool,
    /// Whether its surface is the same everywhere, in whatever it stands, and in its own shading frame.
    plain: bool,
}

impl Scene {
    /// The lights and the choice among them.
    #[inline]
    pub fn lights(&self) -> &Lights {
        &self.lights
    }

    /// A ball around all geometry, in scene units.
    #[inline]
    pub fn ball(&self) -> &Ball {
        &self.ball
    }

    /// Its radius.
    pub fn radius(&self) -> f32 {
        self.ball.radius
    }

    /// From the file's coordinates to the scene's.
    pub fn rebase(&self) -> &Rebase {
        &self.rebase
    }

    /// What the scene needs.
    #[inline]
    pub fn features(&self) -> Features {
        self.features
    }

    /// The least slope deviation α of a mirror, gloss or glass that something in the scene has; `None` if all scatter widely.
    pub fn least_slope(&self) -> Option<f64> {
        self.used_materials().filter_map(Material::least_slope).min_by(f64::total_cmp)
    }

    /// Whether something in the scene scatters into more than a mirror's direction.
    pub fn has_wide_lobes(&self) -> bool {
        self.used_materials().any(Material::has_wide_lobes)
    }

    fn used_materials(&self) -> impl Iterator<Item = &Material> {
        self.objects.iter().map(|object| &self.materials[object.material as usize])
    }

    /// Counts, sizes and warnings, for people.
    pub fn info(&self) -> &SceneInfo {
        &self.info
    }

    /// Hash of everything in the description that can change a picture.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// All triangles, in scene units.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// The ray queries themselves, for measurements.
    pub fn accel(&self) -> &Accel {
        &self.accel
    }

    /// This scene with ray queries through what `change` makes of them, for measurements.
    #[must_use]
    pub fn with_accel(self, change: impl FnOnce(Accel) -> Accel) -> Scene {
        Scene { accel: change(self.accel), ..self }
    }

    /// Whose ray queries are used.
    pub fn backend(&self) -> Backend {
        self.accel.backend()
    }
}
