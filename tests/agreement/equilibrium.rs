//! Random scenes in thermal equilibrium (Kirchhoff's law): what a surface does not scatter it emits, so that radiance
//! is one number everywhere (its square of the index times it inside glass), whatever stands in the room. Exact answers
//! without limit.
//!
//! A scene is a star-shaped room or a uniform sky, and in it up to eight bodies and some sheets: matte, textured,
//! mirrors of any reflectance, glass of any index, clear and tinted windows, half-covered surfaces and lamps;
//! ellipsoids and ragged stars, single and as instances, everything turned, moved and scaled. No surface lies on
//! another: which of two is hit first is not defined then, and where one emits and the other lets light through, the
//! answers of light sampling and of scattered rays do not add up (0.3 % of a room's brightness when two sheets of this
//! generator did).
//!
//! What equilibrium cannot see: whatever keeps it. A wrong distribution of directions that is reciprocal and loses
//! nothing, wrong normals of a Lambertian surface, distances, wrong textures (emission follows them), visibility
//! (everything is as bright as what hides it), depth beyond roulette, and the model's colours. Closed forms and other
//! renderers' images see those. Rough metal and glass lose light between their facets by an amount that depends on the
//! angle, which no material here emits: they are in `rough_bodies.rs`.

use crate::picture::{Block, Picture, Shot, limit, render, scene_under};
use etendue::accel::Backend;
use etendue::integrator::Method;
use etendue::medium::Phase;
use etendue::scene::description::{
    AlphaMode, Description, EnvironmentDescription, Instance, Material, MaterialModel, Volume,
};
use etendue::spectrum::Spectrum;
use etendue::texture::{Bitmap, Encoding, RadianceMap, Texels, Texture, TextureFilter, Wrap};
use etendue_testing::deep;
use etendue_testing::random::Random;
use etendue_testing::studio::{Ball, add, add_square, camera, glass, matte, metal, with_model};
use glam::{Affine2, DAffine3, DMat3, DQuat, DVec3, EulerRot, Vec2, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Roundings of throughputs and film of one sample, a few dozen.
pub(crate) const ROUNDING: f64 = 64.0 * f32::EPSILON as f64;

/// What a scene is made of, and so which methods see all of it with a finite variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    /// Anything in a room.
    Room,
    /// Anything under a sky.
    Sky,
    /// Matte things in a room: nothing that `path-naive` is blind to.
    Matte,
    /// Things that lose nothing under a sky: no emitters, to whose touching edges `path-nee` has an infinite variance.
    Lossless,
    /// Anything in a room, the camera in the middle of a glass ball.
    InGlass,
    /// The same where all glass scatters and absorbs, and emits what it absorbs.
    Milky,
}

pub(crate) const KINDS: [Kind; 5] = [Kind::Room, Kind::Sky, Kind::Matte, Kind::Lossless, Kind::InGlass];

impl Kind {
    fn methods(self) -> &'static [Method] {
        match self {
            Kind::Matte => &[Method::Path, Method::PathNaive],
            Kind::Lossless => &[Method::Path, Method::PathNee],
            Kind::Milky => &[Method::Path, Method::PathNee],
            _ => &[Method::Path],
        }
    }
}

/// A scene in the making.
struct Maker {
    random: Random,
    kind: Kind,
    scene: Description,
    /// Radiance in the camera's medium.
    expected: f64,
}

impl Maker {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.random.f64()
    }

    fn one_of(&mut self, n: u32) -> u32 {
        (self.random.f64() * f64::from(n)) as u32
    }

    fn colour(&mut self, high: f64) -> Spectrum {
        Spectrum(std::array::from_fn(|_| self.between(0.0, high) as f32))
    }

    fn turn(&mut self) -> DQuat {
        let [a, b, c] = [PI, 0.5 * PI, PI].map(|limit| self.between(-limit, limit));
        DQuat::from_euler(EulerRot::ZXZ, a, b, c)
    }

    /// A material that emits what it does not scatter.
    fn material(&mut self) -> Material {
        let kinds: &[u32] = match self.kind {
            Kind::Matte => &[0, 1, 2, 2, 3],
            Kind::Lossless => &[4, 5, 6, 7, 10, 10],
            _ => &[0, 1, 2, 2, 2, 3, 4, 5, 6, 7, 8, 9, 10],
        };
        match kinds[self.one_of(kinds.len() as u32) as usize] {
            0 => complemented(matte(0.0, 0.0), self.colour(0.9)),
            1 => self.textured(),
            2 => {
                Material { alpha_mode: AlphaMode::Blend, alpha: 0.6, ..complemented(matte(0.0, 0.0), self.colour(0.9)) }
            }
            3 => Material { emission: Spectrum::ONE, double_sided: true, ..matte(0.0, 0.0) },
            4 => metal(1.0, 0.0),
            5 => with_model(glass(0.0), |m| m.ior = self.between(1.1, 2.4) as f32),
            6 => with_model(matte(1.0, 0.0), |m| {
                m.specular = 1.0;
                m.transmission = 1.0;
                m.roughness = 0.0;
                m.ior = self.between(1.0, 2.0) as f32;
            }),
            // an index of 1 bends nothing, however rough the surface is
            7 => with_model(glass(0.7), |m| m.ior = 1.0),
            8 => complemented(metal(0.0, 0.0), self.colour(0.95)),
            9 => complemented(
                with_model(matte(0.0, 0.0), |m| {
                    m.transmission = 1.0;
                    m.roughness = 0.0;
                }),
                self.colour(1.0),
            ),
            _ => matte(1.0, 0.0),
        }
    }

    /// Reflectance by a random picture and emission by its negative.
    fn textured(&mut self) -> Material {
        let texels: Vec<[u8; 4]> = (0..48).map(|_| std::array::from_fn(|_| self.between(0.0, 230.0) as u8)).collect();
        let negative = texels.iter().map(|t| t.map(|x| 255 - x)).collect();
        let [base, emission] = [texels, negative].map(|texels| {
            Some(Texture {
                image: Arc::new(Bitmap::new(8, 6, Texels::Rgba8(texels.into()))),
                encoding: Encoding::Linear,
                wrap: [Wrap::Repeat, Wrap::Mirror],
                filter: TextureFilter::Linear,
                uv_set: 0,
                transform: Affine2::from_scale(Vec2::new(1.5, 0.7)),
            })
        });
        Material { emission_texture: emission, ..with_model(matte(1.0, 1.0), |m| m.base_color_texture = base) }
    }

    /// Texture coordinates for what was added last.
    fn lay_texture(&mut self) {
        let primitive = &mut self.scene.meshes.last_mut().expect("just added").primitives[0];
        let uvs = (0..primitive.positions.len()).map(|_| Vec2::new(self.random.f32(), self.random.f32())).collect();
        primitive.uvs[0] = Some(uvs);
    }

    /// The walls: a star around the origin whose rays reach from 0.9 to 1.6.
    fn room(&mut self) {
        let mut walls = Ball::new(2, 1.0);
        walls.positions.iter_mut().for_each(|p| *p *= self.random.f32().mul_add(0.6, 1.0));
        // One material for each eighth of it.
        let Ball { positions, triangles } = walls;
        for octant in triangles.chunks(triangles.len().div_ceil(8)) {
            let material =
                if self.one_of(2) == 0 { self.textured() } else { complemented(matte(0.0, 0.0), self.colour(0.8)) };
            add(&mut self.scene, positions.clone(), octant.to_vec(), material);
            self.lay_texture();
        }
    }

    fn sky(&mut self) {
        let map = || Arc::new(RadianceMap::new(8, 4, vec![[2.0; 3]; 32]));
        let turned = self.between(0.0, 360.0);
        let constant = EnvironmentDescription::Map { map: map(), scale: 0.5, rotation: turned };
        self.scene.environment =
            Some(if self.one_of(2) == 0 { constant } else { EnvironmentDescription::Uniform(Spectrum::ONE) });
    }

    /// An ellipsoid or a ragged star in a ball of 0.26 around `centre`.
    fn body(&mut self, centre: DVec3) {
        let level = self.one_of(3);
        let mut body = Ball::new(level, 1.0);
        if self.one_of(2) == 0 {
            body.positions.iter_mut().for_each(|p| *p *= self.random.f32().mul_add(0.5, 0.5));
        }
        let material = self.material();
        body.add(&mut self.scene, centre, material);
        self.lay_texture();
        let transform = self.placed(centre);
        self.scene.instances.last_mut().expect("just added").transform = transform;
    }

    fn placed(&mut self, centre: DVec3) -> DAffine3 {
        let scale = DVec3::from([(); 3].map(|()| self.between(0.1, 0.26)));
        DAffine3::from_mat3_translation(DMat3::from_quat(self.turn()) * DMat3::from_diagonal(scale), centre)
    }

    /// Another instance of the last body.
    fn again(&mut self, centre: DVec3) {
        let mesh = self.scene.instances.last().expect("a body").mesh;
        let transform = self.placed(centre);
        self.scene.instances.push(Instance { name: "again".into(), mesh, transform });
    }

    fn bodies(&mut self) {
        let walls = self.scene.meshes.len();
        for corner in 0..8u8 {
            let centre = DVec3::from([0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -0.33 } else { 0.33 }));
            match self.one_of(6) {
                0 => {}
                1 if self.scene.meshes.len() > walls => self.again(centre),
                _ => self.body(centre),
            }
        }
    }

    /// A square between the bodies and the walls, at `height` from the middle; sheets are no closed bodies, so not of
    /// glass.
    fn sheet(&mut self, height: f32) {
        let material = self.material();
        if matches!(&material.model, MaterialModel::MetallicRoughness(model) if model.volume.is_some()) {
            return;
        }
        let (x, z) = (self.between(0.1, 0.4) as f32, self.between(0.1, 0.4) as f32);
        add_square(&mut self.scene, Vec3::Y * height, Vec3::X * x, Vec3::Z * z, material);
        self.lay_texture();
    }

    /// The eye near the middle, in a ball of glass where the kind says so.
    fn eye(&mut self) {
        let eye = DVec3::from([(); 3].map(|()| self.between(-0.03, 0.03)));
        let target = eye + self.turn() * DVec3::Z;
        self.scene.cameras.push(camera(eye, target));
        if matches!(self.kind, Kind::InGlass | Kind::Milky) {
            let index = self.between(1.2, 2.0) as f32;
            Ball::new(3, 0.2).add(&mut self.scene, DVec3::ZERO, with_model(glass(0.0), |m| m.ior = index));
            self.expected *= f64::from(index).powi(2);
        }
    }

    /// Moves, turns and scales everything.
    fn carry_off(&mut self) {
        let scale = 10f64.powf(self.between(-3.0, 3.0));
        let to = DVec3::from([(); 3].map(|()| scale * self.between(-10.0, 10.0)));
        let by = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), self.turn(), to);
        self.scene.instances.iter_mut().for_each(|i| i.transform = by * i.transform);
        self.scene.cameras.iter_mut().for_each(|c| c.transform = by * c.transform);
        if self.kind == Kind::Milky {
            self.fill(scale as f32);
        }
    }

    /// Fills all glass with media of a mean free path of a few centimetres and more, in a room of `scale`.
    fn fill(&mut self, scale: f32) {
        for i in 0..self.scene.materials.len() {
            let scattering = self.colour(20.0) / scale;
            let g = self.between(-0.9, 0.9) as f32;
            let phase = [Phase::Isotropic, Phase::Rayleigh, Phase::HenyeyGreenstein(g), Phase::Mixture([g, -g], 0.3)];
            let phase = phase[self.one_of(4) as usize];
            let absorption = self.colour(5.0) / scale;
            let MaterialModel::MetallicRoughness(model) = &mut self.scene.materials[i].model else { continue };
            let emission = absorption * model.ior * model.ior;
            model.volume = model.volume.map(|volume| Volume { absorption, scattering, emission, phase, ..volume });
        }
    }
}

/// `material` of this colour, emitting the rest of white.
fn complemented(material: Material, colour: Spectrum) -> Material {
    Material { emission: Spectrum::ONE - colour, ..with_model(material, |m| m.base_color = colour) }
}

/// A scene of `kind` and its camera's radiance.
pub(crate) fn equilibrium(kind: Kind, seed: u64) -> (Description, f64) {
    let mut maker = Maker { random: Random::new(seed), kind, scene: Description::default(), expected: 1.0 };
    if matches!(kind, Kind::Sky | Kind::Lossless) {
        maker.sky()
    } else {
        maker.room()
    }
    maker.bodies();
    [0.62, -0.62].into_iter().for_each(|height| maker.sheet(height));
    maker.eye();
    maker.carry_off();
    (maker.scene, maker.expected)
}

/// Tests of one picture: four blocks in three lanes, and the mean.
const TESTS: usize = 13;

/// How far a sample is from the mean at most, over the mean (hardly ever more).
const REACH: f64 = 2.0;

/// Whether the lanes of 2 × 2 blocks of pixels and the image mean of `spp` samples a pixel are `expected`, all within
/// `limit` standard errors, the rounding, and Bernstein's term for what is not normal, limit² b / 3n: in a scene that
/// loses nothing nearly every sample is exact, and the few that are not say little about their variance.
fn verdict(picture: &Picture, spp: u64, expected: f64, limit: f64) -> Result<(), String> {
    let pixels = (picture.side * picture.side) as f64;
    let off = |b: Block, pixels: f64| {
        let rare = limit * limit * REACH / (3.0 * pixels * spp as f64);
        ((b.mean - expected).abs() - expected * (ROUNDING + rare)) / b.variance.sqrt().max(f64::MIN_POSITIVE)
    };
    let blocks = picture.blocks(2).into_iter().map(|b| off(b, 0.25 * pixels));
    let worst = blocks.fold(off(picture.overall(), pixels), f64::max);
    if worst < limit { Ok(()) } else { Err(format!("z {worst:.2} > {limit:.2}")) }
}

/// Every kind several times, every method that sees all of it, every backend. Planted: 5 % more, in the deep test 2 %.
#[test]
fn random_scenes_in_equilibrium_are_one_brightness() {
    let (rounds, spp, planted) = if deep() { (20, 512, 1.02) } else { (3, 64, 1.05) };
    let shots: Vec<(Kind, u64, Method, Backend)> = (0..rounds)
        .flat_map(|round| KINDS.into_iter().chain([Kind::Milky]).map(move |kind| (kind, round)))
        .flat_map(|(kind, round)| kind.methods().iter().map(move |&method| (kind, round, method)))
        .flat_map(|(kind, round, method)| Backend::AVAILABLE.iter().map(move |&backend| (kind, round, method, backend)))
        .collect();
    let limit = limit(TESTS * shots.len());
    for (kind, round, method, backend) in shots {
        let (description, expected) = equilibrium(kind, round * 10 + kind as u64);
        let what = format!("{kind:?} {round}, {method:?}, {backend:?}");
        let spp = if method == Method::PathNaive { 4 * spp } else { spp };
        let scene = scene_under(backend, description);
        // Every triangle of a room's walls is a light.
        assert!(scene.info().light_tree_bytes > 0 || matches!(kind, Kind::Sky | Kind::Lossless), "{what}: no tree");
        let picture = render(&scene, Shot::new(method, 16, spp));
        let overall = picture.overall();
        println!("{what}: {:.4} of {expected:.4}, standard error {:.1e}", overall.mean, overall.variance.sqrt());
        verdict(&picture, spp, expected, limit)
            .unwrap_or_else(|e| panic!("{what}: {} of {expected}, {e}", overall.mean));
        assert!(
            verdict(&picture.times(planted), spp, expected, limit).is_err(),
            "{what}: {planted} times as bright is not convicted"
        );
    }
}

/// Emission of one material without its share: the room is convicted.
#[test]
fn a_wall_out_of_equilibrium_is_convicted() {
    let (mut description, expected) = equilibrium(Kind::Room, 0);
    description.materials[0].emission *= 0.5;
    description.materials[1].emission *= 0.5;
    let picture = render(&scene_under(Backend::default(), description), Shot::new(Method::Path, 16, 64));
    assert!(verdict(&picture, 64, expected, limit(TESTS)).is_err(), "{}", picture.overall().mean);
}
