//! Techniques of bidirectional path tracing one by one: their weighted images sum to the picture, and without weights
//! all that can make a path find the same light.
//!
//! A connection of two vertices is worth 1 / d² and more, so that where surfaces meet at an edge its value has the tail
//! index 3/2 and no variance. The scenes of the second test therefore have no edges: their walls end before they meet,
//! and bodies stand free and are convex, so that distances between points that see each other are bounded below and
//! every value above. The skewness of a tile's mean is then below 0.1 and Student's t holds its level: of 21,888
//! p-values of matte walls (24 seeds that are not used here, 1024 passes each) 226, 22 and 3 were below 1e-2, 1e-3 and
//! 1e-4, where 219, 22 and 2 are expected.
//!
//! One odd sample is known: the first 2048 passes of seed 8 alone have (0,5) low in one tile (p = 5.6e-7 of 912 tests).
//! All else that was rendered of it, 26,600 passes of seven seeds, has (0,5) there at 974 ± 10 millionths and (3,2) at
//! 968 ± 4. Neither seed nor level was changed for it: the test takes 4096 passes, those included.

use crate::picture::scene;
use crate::references::load;
use etendue::film::{Film, Filter, Layout, Plane};
use etendue::integrator::{
    self, FilmRenderer, Guards, IntegratorConfig, Method, PilotEstimate, TechniqueImage, TechniqueImages,
};
use etendue::parallel::Cancel;
use etendue::sampling::SamplerKind;
use etendue::scene::Scene;
use etendue::scene::description::{Description, Material};
use etendue::spectrum::Spectrum;
use etendue::stats::{Moments, holm, t_test};
use etendue::texture::{Bitmap, Encoding, Texels, Texture, Wrap};
use etendue_testing::deep;
use etendue_testing::studio::{Ball, add_square, camera, matte, metal, with_model};
use glam::{Affine2, DVec3, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// Family-wise level over all tiles, lanes, pairs of techniques and lengths of a scene.
const LEVEL: f64 = 1e-3;

/// Pixels along a side of pictures and of tiles.
const SIDE: usize = 32;
const TILE: usize = 8;

/// Scattering events of the longest paths.
const DEEPEST: u32 = 3;

fn images(scene: &Scene, options: &IntegratorConfig, passes: u64) -> TechniqueImages {
    let (layout, camera) = (layout(), scene.camera(None, SIDE as u32, SIDE as u32).expect("a camera"));
    let found = integrator::technique_images(scene, &camera, options, &layout, 0..passes, DEEPEST, &Cancel::new());
    let found = found.expect("not cancelled");
    assert_eq!(found.report.guards, Guards::default(), "a guard fired");
    found
}

fn layout() -> Layout {
    Layout::new(SIDE as u32, SIDE as u32, None, &[])
}

/// The picture of `bdpt` as it is rendered.
fn picture(scene: &Scene, options: &IntegratorConfig, passes: u64) -> Film {
    let (layout, camera) = (layout(), scene.camera(None, SIDE as u32, SIDE as u32).expect("a camera"));
    let units = integrator::pilot(scene, &camera, options, &layout).units;
    let mut film = Film::new(layout.clone(), options.replicates, options.seed, units);
    let method = integrator::build(scene, camera, options, &PilotEstimate::default());
    FilmRenderer::new(method, &mut film).passes(passes);
    film
}

/// The weighted images of all techniques are the picture of the same passes, taken apart.
///
/// Roundings: in f32 each value is rounded a dozen times at most before and after its pass is added up, and no value is
/// below zero. In units of the film each pass rounds each image once, each sample's value of a technique once, and each
/// splat in each pixel that its filter reaches (nine at most, and as many walks as pixels) once, by less than a unit:
/// on average 1 + 1 + 9 for a pass and an image, once more in the picture; twice that for pixels where more splats
/// fall.
#[test]
fn weighted_images_sum_to_the_picture() {
    let Some(scene) = load("cornell-box") else { return };
    for (sampler, filter) in [(SamplerKind::Sobol, Filter::BlackmanHarris), (SamplerKind::Independent, Filter::Box)] {
        let options = IntegratorConfig {
            seed: 5,
            sampler,
            filter,
            max_depth: Some(DEEPEST),
            ..IntegratorConfig::new(Method::Bdpt, &layout())
        };
        let (whole, parts) = (picture(&scene, &options, 16), images(&scene, &options, 16));
        let units = 2.0 * 2.0 * 11.0 * parts.images.len() as f64 * whole.units().radiance;
        let means: Vec<Vec<f32>> = parts.images.iter().map(|image| image.weighted.mean(Plane::Color)).collect();
        let mut worst: f64 = 0.0;
        for (i, &want) in whole.mean(Plane::Color).iter().enumerate() {
            let (found, want) = (means.iter().map(|mean| f64::from(mean[i])).sum::<f64>(), f64::from(want));
            worst = worst.max((found - want).abs() / want.max(whole.units().radiance));
            assert!(
                (found - want).abs() <= units + 12.0 * f64::from(f32::EPSILON) * want,
                "value {i}: {found}, not {want}"
            );
        }
        println!("{sampler:?}, {filter:?}: the sum of {} images is within {worst:.1e} of the picture", means.len());
    }
}

/// The same images for any number of threads, and whatever passes were rendered before.
#[test]
fn technique_images_do_not_depend_on_threads_or_order() {
    let scene = scene(pavilion(matte(0.6, 0.0)));
    let (layout, options) = (layout(), IntegratorConfig::new(Method::Bdpt, &layout()));
    let camera = scene.camera(None, SIDE as u32, SIDE as u32).expect("a camera");
    let run = |threads: usize, passes: [u64; 4]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let make = || integrator::technique_images(&scene, &camera, &options, &layout, passes, DEEPEST, &Cancel::new());
        pool.install(make).expect("not cancelled")
    };
    let (one, five) = (run(1, [0, 1, 2, 3]), run(5, [3, 1, 0, 2]));
    for (a, b) in one.images.iter().zip(&five.images) {
        assert!(a.weighted == b.weighted && a.unweighted == b.unweighted, "({}, {})", a.s, a.t);
    }
    let cancel = Cancel::new();
    cancel.request();
    assert!(integrator::technique_images(&scene, &camera, &options, &layout, 0..4, DEEPEST, &cancel).is_none());
}

fn coloured(r: f32, g: f32, b: f32) -> Material {
    Material { double_sided: false, ..with_model(matte(0.0, 0.0), |m| m.base_color = Spectrum([r, g, b])) }
}

/// A room of six walls that end before they meet, the upper one a lamp that also reflects, and a body of `ball`
/// material in it.
fn pavilion(body: Material) -> Description {
    const HALF: f32 = 0.7;
    let mut room = Description::default();
    let lamp = Material { emission: Spectrum([1.0, 0.9, 0.7]), ..coloured(0.4, 0.4, 0.4) };
    let (red, blue, grey) = (coloured(0.7, 0.2, 0.2), coloured(0.2, 0.3, 0.8), coloured(0.6, 0.6, 0.6));
    let walls = [
        (Vec3::X, blue),
        (Vec3::NEG_X, red),
        (Vec3::Y, lamp),
        (Vec3::NEG_Y, grey.clone()),
        (Vec3::Z, grey.clone()),
        (Vec3::NEG_Z, grey),
    ];
    for (n, material) in walls {
        let u = Vec3::from([n.z.abs(), n.x.abs(), n.y.abs()]);
        add_square(&mut room, n, u * HALF, u.cross(n) * HALF, material);
    }
    Ball::new(3, 0.35).add(&mut room, DVec3::new(0.15, -0.2, -0.25), body);
    room.cameras.push(camera(DVec3::new(0.05, 0.02, 0.9), DVec3::new(0.0, -0.05, -1.0)));
    room
}

/// Its normals are those of the sphere.
fn rounded(mut room: Description) -> Description {
    let ball = room.meshes.last_mut().expect("the ball");
    let primitive = &mut ball.primitives[0];
    primitive.normals = Some(primitive.positions.iter().map(|p| p.normalize()).collect());
    room
}

/// The floor's normals lean to one side.
fn leaning(mut room: Description) -> Description {
    let texels = Texels::Rgba8(vec![[176, 150, 230, 255]].into());
    let map = Texture {
        image: Arc::new(Bitmap::new(1, 1, texels)),
        encoding: Encoding::Linear,
        wrap: [Wrap::Clamp; 2],
        filter: etendue::texture::TextureFilter::Nearest,
        uv_set: 0,
        transform: Affine2::IDENTITY,
    };
    room.materials[3].normal_texture = Some((map, 1.0));
    let floor = &mut room.meshes[3].primitives[0];
    floor.uvs[0] = Some([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].map(Vec2::from).to_vec());
    floor.normals = Some(vec![Vec3::Y; 4]);
    floor.tangents = Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4]);
    room
}

/// Tiles of the unweighted image of a technique, by replicate: means of each lane.
struct Tiles {
    name: String,
    events: usize,
    replicates: Vec<Vec<f64>>,
}

impl Tiles {
    fn of(image: &TechniqueImage) -> Self {
        let film = &image.unweighted;
        let replicates = (0..film.replicates()).map(|r| tiles(&film.mean_of(r))).collect();
        Tiles { name: format!("({},{})", image.s, image.t), events: image.events(), replicates }
    }

    /// Two-sided p-values of equal means, tile by tile, this one being `brighter`. Replicates are independent, but
    /// techniques share the walks of a replicate, so that it is their differences that are put to Student's test.
    fn p_values<'a>(&'a self, other: &'a Tiles, brighter: f64) -> impl Iterator<Item = f64> + 'a {
        (0..self.replicates[0].len()).map(move |tile| {
            let pairs = self.replicates.iter().zip(&other.replicates);
            let differences: Moments = pairs.map(|(a, b)| brighter * a[tile] - b[tile]).collect();
            t_test(&differences.estimate().expect("replicates"), 0.0).p_value
        })
    }
}

/// Means of the tiles of a picture, lanes apart.
fn tiles(values: &[f64]) -> Vec<f64> {
    const ACROSS: usize = SIDE / TILE;
    let mut means = vec![0.0; ACROSS * ACROSS * 3];
    for (i, value) in values.iter().enumerate() {
        let (pixel, lane) = (i / 3, i % 3);
        let tile = pixel / SIDE / TILE * ACROSS + pixel % SIDE / TILE;
        means[tile * 3 + lane] += value / (TILE * TILE) as f64;
    }
    means
}

/// Pairs of techniques for the same paths.
fn pairs(all: &[Tiles]) -> impl Iterator<Item = (usize, usize)> + '_ {
    let later = |a: usize| (a + 1..all.len()).map(move |b| (a, b));
    (0..all.len()).flat_map(later).filter(|&(a, b)| all[a].events == all[b].events)
}

/// Holm's p-value of the worst pair with its name, technique `planted` being too bright by `share`.
fn worst(all: &[Tiles], planted: usize, share: f64) -> (f64, String) {
    let brighter = |a: usize, b: usize| {
        if planted == a {
            1.0 + share
        } else if planted == b {
            1.0 / (1.0 + share)
        } else {
            1.0
        }
    };
    let (mut names, mut p) = (Vec::new(), Vec::new());
    for (a, b) in pairs(all) {
        let found: Vec<f64> = all[a].p_values(&all[b], brighter(a, b)).collect();
        names.extend((0..found.len()).map(|tile| format!("{} and {}, value {tile}", all[a].name, all[b].name)));
        p.extend(found);
    }
    let adjusted = holm(&p);
    let at =
        (0..p.len()).min_by(|&a, &b| adjusted[a].total_cmp(&adjusted[b]).then(p[a].total_cmp(&p[b]))).expect("pairs");
    (adjusted[at], format!("{}: p {:.1e} of {} tests", names[at], p[at], p.len()))
}

/// All techniques of a length find the same light, and one that finds the share `sees` more is convicted.
fn judge(name: &str, room: Description, sees: f64) {
    let passes = if deep() { 1 << 16 } else { 1 << 12 };
    let options = IntegratorConfig {
        seed: 8,
        sampler: SamplerKind::Independent,
        filter: Filter::Box,
        replicates: 64,
        ..IntegratorConfig::new(Method::Bdpt, &layout())
    };
    let found = images(&scene(room), &options, passes);
    let all: Vec<Tiles> = found.images.iter().map(Tiles::of).collect();
    assert_eq!(pairs(&all).count(), 3 + 6 + 10, "a technique is missing");
    let (p, what) = worst(&all, usize::MAX, 0.0);
    println!("{name}: {p:.2}; {what}");
    assert!(p > LEVEL, "{name}: {what}");
    for (at, technique) in all.iter().enumerate().filter(|(_, t)| t.events > 0) {
        let (p, what) = worst(&all, at, sees);
        println!("  {} with {sees} more: {p:.1e}; {what}", technique.name);
        assert!(p < LEVEL, "{name}: {} times {} is not convicted", technique.name, 1.0 + sees);
    }
}

#[test]
fn techniques_agree_on_matte_walls() {
    judge("matte", pavilion(matte(0.6, 0.0)), 0.1);
}

#[test]
fn techniques_agree_on_gloss() {
    let mut room = pavilion(metal(0.8, 0.6));
    room.materials[0] = Material { double_sided: false, ..metal(0.7, 0.6) };
    room.materials[3] = with_model(coloured(0.5, 0.5, 0.5), |m| {
        m.specular = 1.0;
        m.roughness = 0.5;
    });
    judge("gloss", room, 0.1);
}

#[test]
fn techniques_agree_on_bent_normals() {
    let mut room = leaning(rounded(pavilion(matte(0.6, 0.0))));
    room.materials[1] = Material { double_sided: false, ..metal(0.7, 0.6) };
    judge("bent normals", room, 0.1);
}
