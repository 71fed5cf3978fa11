//! What kernels know of the objects of a scene.

use crate::bsdf::Surface;
use crate::bsdf::lanes::{LaneModel, LaneSurface, Parameters};
use crate::scene::{Scene, TexturedSurface};
use crate::texture::Texture;

/// What happens at hits of an object, a bit each.
pub(super) mod flags {
    /// The kernel of Lambert's model scatters, with constant parameters.
    pub(crate) const LAMBERT: u8 = 1;
    /// So does that of conductors.
    pub(crate) const CONDUCTOR: u8 = 2;
    /// So does that of mixtures of metal and dielectric.
    pub(crate) const METAL_DIELECTRIC: u8 = 4;
    /// The kernel scatters of the model that textures and vertex colours make of the surface at each point.
    pub(crate) const VARYING: u8 = 8;
    /// All is done by the code of single paths. No other bit is set.
    pub(crate) const SINGLE: u8 = 16;
    /// Triangles emit.
    pub(crate) const EMITS: u8 = 32;
    /// The camera does not see the back.
    pub(crate) const MAY_BE_CULLED: u8 = 64;
    /// There are shading normals.
    pub(crate) const HAS_NORMALS: u8 = 128;
}

/// All objects.
pub(super) struct Objects<'a> {
    /// Their [`flags`], and none for what is not an object.
    pub(super) flags: Vec<u8>,
    /// Data of kernels.
    pub(super) rows: Vec<ObjectRow<'a>>,
}

/// An object.
#[derive(Debug, Clone, Copy)]
pub(super) struct ObjectRow<'a> {
    /// Parameters of a constant surface, or factors of a textured one.
    pub(super) parameters: Parameters,
    /// The surface, if it is textured and nothing else makes it vary.
    pub(super) textured: Option<TexturedRow<'a>>,
    /// Coordinates of its triangles.
    pub(super) corners: &'a [[f32; 9]],
}

/// Textures of an object.
#[derive(Debug, Clone, Copy)]
pub(super) struct TexturedRow<'a> {
    /// Those of colour, of roughness and metalness, and of the normal.
    pub(super) textures: [Option<&'a Texture>; 3],
    /// Whether each reads the same places of its image as the one before.
    pub(super) follows: [bool; 3],
}

impl<'a> TexturedRow<'a> {
    fn new(surface: &TexturedSurface<'a>) -> Self {
        let textures = [surface.base_color, surface.metallic_roughness, surface.normal];
        let (mut follows, mut before) = ([false; 3], None::<&Texture>);
        for (follows, texture) in follows.iter_mut().zip(textures) {
            *follows = texture.zip(before).is_some_and(|(texture, before)| texture.reads_like(before));
            before = texture.or(before);
        }
        TexturedRow { textures, follows }
    }
}

impl<'a> Objects<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        let objects = 0..scene.geometry().objects.len();
        let (mut flags, rows): (Vec<u8>, _) = objects.map(|object| row(scene, object)).unzip();
        flags.push(0);
        Objects { flags, rows }
    }

    /// Whether paths may have [`super::paths::Rare`] state.
    pub(super) fn has_rare(&self) -> bool {
        self.flags.iter().any(|flags| flags & (flags::SINGLE | flags::VARYING) != 0)
    }
}

fn row(scene: &Scene, object: usize) -> (u8, ObjectRow<'_>) {
    let surface = scene.constant_surface(object);
    let kernel = surface.and_then(LaneSurface::new);
    let mesh = scene.geometry().mesh_of(object as u32);
    let set = |flag: u8, is_set: bool| if is_set { flag } else { 0 };
    let others = set(flags::EMITS, scene.emits(object))
        | set(flags::MAY_BE_CULLED, scene.may_be_culled(object))
        | set(flags::HAS_NORMALS, mesh.attributes().normals.is_some());
    let has_kernels = scene.geometry().objects[object].placement.is_none() && !scene.transmits(object);
    let flags = match (surface, &kernel) {
        (_, Some(kernel)) if has_kernels => others | of_model(kernel.model),
        (Some(Surface::Black), _) if has_kernels => others,
        (None, _) if has_kernels => others | flags::VARYING,
        _ => flags::SINGLE,
    };
    let textured = scene.textured_surface(object).filter(|_| flags & flags::VARYING != 0);
    let factors = textured.map(|surface| surface.factors.factors());
    let parameters = kernel.map(|row| row.parameters).or(factors).unwrap_or_default();
    let textured = textured.as_ref().map(TexturedRow::new);
    (flags, ObjectRow { parameters, textured, corners: mesh.corner_rows() })
}

fn of_model(model: LaneModel) -> u8 {
    match model {
        LaneModel::Lambert => flags::LAMBERT,
        LaneModel::Conductor => flags::CONDUCTOR,
        LaneModel::MetalDielectric => flags::METAL_DIELECTRIC,
    }
}
