//! The scene as seen by integrators: geometry behind a backend, materials, lights. It answers ray queries, evaluates
//! surfaces and emission, and computes the transmittance between two points.

mod assemble;
mod bodies;
mod build;
mod coincident;
mod contact;
pub mod description;
mod edge;
mod enclosure;
mod extent;
mod focus;
mod info;
mod interior;
mod lights;
mod material;
mod query;
mod rebase;
mod surroundings;
mod touching;
mod usage;
mod view;

pub use bodies::Solid;
pub use build::BuildOptions;
pub use edge::{Edge, EdgeEnd, EdgeThroughput, Passage};
pub use info::SceneInfo;
pub use material::TexturedSurface;
pub use rebase::Rebase;

use crate::accel::{Accel, Backend};
use crate::geometry::{Bodies, Geometry};
use crate::light::{BoundingSphere, Lights};
use bodies::AllBodies;
use material::Material;

/// A scene ready to render. Lengths are in scene units: those of the file, rebased by [`Scene::rebase`].
pub struct Scene {
    geometry: Geometry,
    objects: Vec<ObjectInfo>,
    materials: Vec<Material>,
    bodies: AllBodies,
    lights: Lights,
    /// Bodies that contain each light; `None` if they differ over the light. Empty for a scene without bodies.
    light_media: Vec<Option<Bodies>>,
    accel: Accel,
    /// Touching surfaces of which one transmits light, if there are any.
    contacts: Option<Box<contact::Contacts>>,
    rebase: Rebase,
    ball: BoundingSphere,
    features: Features,
    views: view::Views,
    /// Names of the instances in file order.
    names: Vec<String>,
    info: SceneInfo,
    hash: String,
}

/// Features of the scene. Some select code of the renderer. All are named in reports and by `etendue info`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Features {
    /// Some surface has an alpha mask.
    pub masks: bool,
    /// Some surface blends by alpha.
    pub blends: bool,
    /// Some surface is culled for the camera when seen from behind.
    pub culled: bool,
    /// Some object has an interior that absorbs, scatters or emits.
    pub media: bool,
    /// Some object has an interior that scatters.
    pub scattering: bool,
    /// Some object has an interior that emits.
    pub emission: bool,
    /// Some surface transmits light straight through.
    pub panes: bool,
    /// Some bodies may contain others.
    pub nested: bool,
    /// Some material has textures.
    pub textures: bool,
    /// Some material has a normal map.
    pub normal_maps: bool,
    /// Some mesh has shading normals.
    pub shading_normals: bool,
    /// Some material is a mirror or clear glass.
    pub dirac: bool,
    /// Some material refracts.
    pub refraction: bool,
    /// Some mesh has several instances.
    pub instances: bool,
    /// Some light is a Dirac light (a light without extent).
    pub dirac_lights: bool,
    /// Some light falls off like 1/d² around a point: see [`Light::pivot`](crate::light::Light::pivot).
    pub small_lights: bool,
    /// Some surface that transmits light touches another.
    pub contacts: bool,
}

impl Features {
    /// Returns whether edges between vertices may pass through surfaces.
    #[inline]
    pub fn content(&self) -> bool {
        self.blends || self.panes || self.nested
    }

    /// Returns whether walks fly through media, and do not merely cross them.
    #[inline]
    pub fn flights(&self) -> bool {
        self.scattering || self.emission
    }

    /// Returns the names of the features that are present.
    pub fn names(&self) -> Vec<&'static str> {
        [
            ("alpha-mask", self.masks),
            ("alpha-blend", self.blends),
            ("single-sided", self.culled),
            ("media", self.media),
            ("scattering-media", self.scattering),
            ("emitting-media", self.emission),
            ("panes", self.panes),
            ("nested-bodies", self.nested),
            ("textures", self.textures),
            ("normal-maps", self.normal_maps),
            ("shading-normals", self.shading_normals),
            ("dirac-materials", self.dirac),
            ("refraction", self.refraction),
            ("instances", self.instances),
            ("dirac-lights", self.dirac_lights),
            ("small-lights", self.small_lights),
            ("contacts", self.contacts),
        ]
        .into_iter()
        .filter_map(|(name, there)| there.then_some(name))
        .collect()
    }
}

/// Shading data of an object besides its geometry.
#[derive(Debug, Clone, Copy)]
struct ObjectInfo {
    /// Index into [`Scene::materials`].
    material: u32,
    /// Index of the light on the object's first triangle, if its triangles emit.
    first_light: Option<u32>,
    /// Index of the instance in the file's order.
    instance: u32,
    /// Whether the mesh has vertex colours.
    colors: bool,
    /// The body that it bounds, or [`crate::geometry::Bodies::NOBODY`].
    body: u32,
    /// Whether light may pass straight through it, whatever the medium around it.
    passes: bool,
    /// Whether its surface is constant, independent of the medium around it, and in its own shading frame.
    plain: bool,
}

impl Scene {
    /// Returns the lights and their selection distribution.
    #[inline]
    pub fn lights(&self) -> &Lights {
        &self.lights
    }

    /// Returns the bounding sphere of all geometry, in scene units.
    #[inline]
    pub fn ball(&self) -> &BoundingSphere {
        &self.ball
    }

    /// Returns the radius of the bounding sphere.
    pub fn radius(&self) -> f32 {
        self.ball.radius
    }

    /// Returns the transform from file to scene coordinates.
    pub fn rebase(&self) -> &Rebase {
        &self.rebase
    }

    /// Returns the features of the scene.
    #[inline]
    pub fn features(&self) -> Features {
        self.features
    }

    /// Returns the least slope deviation α of all mirrors, glossy surfaces and glasses in the scene; `None` if all
    /// surfaces scatter widely.
    pub fn least_slope(&self) -> Option<f64> {
        self.used_materials().filter_map(Material::least_slope).min_by(f64::total_cmp)
    }

    /// Returns whether any surface of the scene has a lobe wider than a mirror's.
    pub fn has_wide_lobes(&self) -> bool {
        self.used_materials().any(Material::has_wide_lobes)
    }

    fn used_materials(&self) -> impl Iterator<Item = &Material> {
        self.objects.iter().map(|object| &self.materials[object.material as usize])
    }

    /// Returns counts, sizes and warnings for reports.
    pub fn info(&self) -> &SceneInfo {
        &self.info
    }

    /// Returns a hash of everything in the description that can affect an image.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// Returns all triangles, in scene units.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Returns the intersection backend, for measurements.
    pub fn accel(&self) -> &Accel {
        &self.accel
    }

    /// Returns this scene with its intersection backend replaced by the first result of `change`, and the second, for
    /// measurements.
    #[must_use]
    pub fn with_accel<T>(self, change: impl FnOnce(Accel) -> (Accel, T)) -> (Scene, T) {
        let (accel, result) = change(self.accel);
        (Scene { accel, ..self }, result)
    }

    /// Returns the type of the intersection backend in use.
    pub fn backend(&self) -> Backend {
        self.accel.backend()
    }
}
