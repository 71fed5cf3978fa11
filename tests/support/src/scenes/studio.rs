//! Parts of scenes for tests: materials, meshes, cameras, lights.

use etendue::scene::description::{
    CameraDescription, Description, Instance, Material, MaterialModel, Mesh, MetalFresnel, MetallicRoughnessMaterial,
    Primitive, Projection, PunctualKind, PunctualLight, Volume,
};
use etendue::spectrum::Spectrum;
use glam::{DAffine3, DVec3, Vec3};
use std::collections::HashMap;

/// `material` with changed parameters of its metallic-roughness model.
///
/// # Panics
/// If it has another model.
pub fn with_model(mut material: Material, change: impl FnOnce(&mut MetallicRoughnessMaterial)) -> Material {
    let MaterialModel::MetallicRoughness(model) = &mut material.model else { panic!("another model") };
    change(model);
    material
}

/// A Lambertian material.
pub fn matte(reflectance: f32, emission: f32) -> Material {
    Material {
        emission: Spectrum::splat(emission),
        double_sided: true,
        ..with_model(Material::default(), |m| {
            m.base_color = Spectrum::splat(reflectance);
            m.metallic = 0.0;
            m.specular = 0.0;
        })
    }
}

/// Adds a mesh of one material.
pub fn add(scene: &mut Description, positions: Vec<Vec3>, triangles: Vec<[u32; 3]>, material: Material) {
    let (mesh, id) = (scene.meshes.len(), scene.materials.len());
    let primitive = Primitive { positions, triangles, material: id, ..Primitive::default() };
    scene.meshes.push(Mesh { name: format!("mesh {mesh}"), primitives: vec![primitive] });
    scene.instances.push(Instance { name: format!("node {mesh}"), mesh, transform: DAffine3::IDENTITY });
    scene.materials.push(material);
}

/// Adds the square with centre `c` spanned by the half edges `u` and `v`; its front is the side of u × v.
pub fn add_square(scene: &mut Description, c: Vec3, u: Vec3, v: Vec3, material: Material) {
    let corners = vec![c - u - v, c + u - v, c + u + v, c - u + v];
    add(scene, corners, vec![[0, 1, 2], [0, 2, 3]], material);
}

/// Adds the closed box around `centre` with the half sides `half`, fronts outward.
pub fn add_box(scene: &mut Description, centre: Vec3, half: Vec3, material: Material) {
    const FACES: [[u32; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let side = |corner: u32, axis: u32| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
    let corners = (0..8).map(|c| centre + half * Vec3::new(side(c, 0), side(c, 1), side(c, 2))).collect();
    let triangles = FACES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    add(scene, corners, triangles, material);
}

/// Adds the six inner walls of the cube from −1 to 1, all of one material.
pub fn add_room(scene: &mut Description, material: &Material) {
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut n = [0.0; 3];
            n[axis] = side;
            let (n, u) = (Vec3::from(n), Vec3::from([n[2].abs(), n[0].abs(), n[1].abs()]));
            add_square(scene, n, u, n.cross(u) * -1.0, material.clone());
        }
    }
}

/// A pinhole camera at `eye` that looks at `target`, with a field of view of 60 degrees.
pub fn camera(eye: DVec3, target: DVec3) -> CameraDescription {
    let backward = (eye - target).normalize();
    let up = if backward.y.abs() > 0.9 { DVec3::Z } else { DVec3::Y };
    let right = up.cross(backward).normalize();
    let transform = DAffine3::from_cols(right, backward.cross(right), backward, eye);
    let projection = Projection::Perspective { yfov: 60f64.to_radians(), aspect: None };
    CameraDescription { name: "camera".into(), projection, transform, lens: None }
}

/// A point light.
pub fn point_light(position: DVec3, intensity: f32) -> PunctualLight {
    PunctualLight {
        name: "point".into(),
        kind: PunctualKind::Point,
        intensity: Spectrum::splat(intensity),
        transform: DAffine3::from_translation(position),
    }
}

/// `camera` with a vertical field of view of `yfov` radians.
pub fn narrow(camera: CameraDescription, yfov: f64) -> CameraDescription {
    CameraDescription { projection: Projection::Perspective { yfov, aspect: None }, ..camera }
}

/// A perfect reflector of `reflectance` at every angle, of perceptual roughness `roughness` (α is its square).
pub fn metal(reflectance: f32, roughness: f32) -> Material {
    let base = matte(reflectance, 0.0);
    with_model(base, |m| {
        m.metallic = 1.0;
        m.specular = 1.0;
        m.roughness = roughness;
        m.metal_fresnel = MetalFresnel::Constant;
    })
}

/// Clear solid glass of index 1.5 and perceptual roughness `roughness`.
pub fn glass(roughness: f32) -> Material {
    let volume = Some(Volume::CLEAR);
    with_model(matte(1.0, 0.0), |m| {
        m.specular = 1.0;
        m.transmission = 1.0;
        m.roughness = roughness;
        m.volume = volume;
    })
}

/// A polyhedron inscribed in a sphere around the origin, fronts outward.
pub struct Ball {
    /// Vertices.
    pub positions: Vec<Vec3>,
    /// Indices of vertices, anticlockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Ball {
    /// An octahedron whose faces are split in four `levels` times, in a sphere of `radius`.
    pub fn new(levels: u32, radius: f32) -> Self {
        let mut positions = vec![Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
        let mut triangles: Vec<[u32; 3]> =
            vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
        for _ in 0..levels {
            triangles = split(&mut positions, &triangles);
        }
        positions.iter_mut().for_each(|p| *p *= radius);
        Ball { positions, triangles }
    }

    fn corners(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        self.triangles.iter().map(|t| t.map(|i| self.positions[i as usize].as_dvec3()))
    }

    /// The radius of the largest sphere around the origin inside it.
    pub fn inner_radius(&self) -> f64 {
        self.corners().map(|[a, b, c]| a.dot((b - a).cross(c - a).normalize())).fold(f64::INFINITY, f64::min)
    }

    /// Its surface.
    pub fn area(&self) -> f64 {
        self.corners().map(|[a, b, c]| (b - a).cross(c - a).length() * 0.5).sum()
    }

    /// Adds it to `scene` around `centre`.
    pub fn add(self, scene: &mut Description, centre: DVec3, material: Material) {
        add(scene, self.positions, self.triangles, material);
        scene.instances.last_mut().expect("just added").transform = DAffine3::from_translation(centre);
    }
}

/// Each triangle in four, new vertices on the unit sphere.
fn split(positions: &mut Vec<Vec3>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            positions.push((positions[a as usize] + positions[b as usize]).normalize());
            positions.len() as u32 - 1
        })
    };
    let quarters = |&[a, b, c]: &[u32; 3]| {
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    };
    triangles.iter().flat_map(quarters).collect()
}
