//! Media that scatter, against tables and closed forms.

use crate::picture::{Shot, render, scene};
use etendue::integrator::Method;
use etendue::medium::Phase;
use etendue::scene::description::{
    ColorGrid, DensityGrid, Description, EnvironmentDescription, Material, MaterialModel, Projection, Volume,
};
use etendue::spectrum::Spectrum;
use etendue_testing::deep;
use etendue_testing::studio::{Ball, add_box, add_square, camera, glass, matte, narrow, point_light, with_model};
use glam::{DAffine3, DQuat, DVec3, Vec3};

/// Methods that see what has null boundaries.
const METHODS: [Method; 4] = [Method::PathNaive, Method::Path, Method::PathNee, Method::Bdpt];

/// The boundary of a medium of index `ior` with extinction 1 per metre.
fn filled(ior: f32, albedo: f32, phase: Phase) -> Material {
    with_model(glass(0.0), |m| {
        m.ior = ior;
        m.volume = Some(Volume {
            absorption: Spectrum::splat(1.0 - albedo),
            emission: Spectrum::ZERO,
            scattering: Spectrum::splat(albedo),
            phase,
            density: None,
            albedo: None,
            emission_grid: None,
        });
    })
}

fn sky(scene: &mut Description) {
    scene.environment = Some(EnvironmentDescription::Uniform(Spectrum::ONE));
}

/// A wide slab under a white sky, seen along its normal.
fn slab(albedo: f32, phase: Phase, depth: f32) -> Description {
    let mut scene = Description::default();
    add_box(&mut scene, Vec3::ZERO, Vec3::new(500.0, 0.5 * depth, 500.0), filled(1.0, albedo, phase));
    sky(&mut scene);
    scene.cameras.push(narrow(camera(DVec3::new(0.0, 20.0, 1e-3), DVec3::ZERO), 0.01));
    scene
}

/// What a camera along the normal sees of a slab is, by reciprocity, what the slab reflects and transmits of light
/// along the normal: reflectance, diffuse and direct transmittance by adding and doubling [vandeHulst80].
#[test]
fn slabs_reflect_and_transmit_as_the_tables_say() {
    let g = Phase::HenyeyGreenstein;
    let cases = [
        (0.5, Phase::Isotropic, 1.0, 0.099119, 0.078179),
        (0.8, Phase::Isotropic, 2.0, 0.265939, 0.150614),
        (0.9, Phase::Isotropic, 0.5, 0.169039, 0.158852),
        (0.99, Phase::Isotropic, 5.0, 0.680076, 0.213889),
        (1.0, Phase::Isotropic, 2.0, 0.517514, 0.347149),
        (0.9, g(0.75), 2.0, 0.097395, 0.525622),
        (0.9, g(0.8), 1.0, 0.042355, 0.477497),
        (0.99, g(0.8), 2.0, 0.120111, 0.716535),
        (0.9, g(-0.5), 2.0, 0.462772, 0.140736),
    ];
    let spp = if deep() { 1 << 15 } else { 1 << 10 };
    // Every other one in CI.
    for (albedo, phase, depth, reflected, transmitted) in cases.into_iter().step_by(if deep() { 1 } else { 2 }) {
        for method in METHODS {
            let open = slab(albedo, phase, depth);
            let mut closed = slab(albedo, phase, depth);
            // A black floor hides the sky below.
            add_square(&mut closed, Vec3::NEG_Y * depth, Vec3::X * 900.0, Vec3::NEG_Z * 900.0, matte(0.0, 0.0));
            let direct = f64::from((-depth).exp());
            for (what, description, expected) in
                [("reflectance", closed, reflected), ("all", open, reflected + transmitted + direct)]
            {
                let found = render(&scene(description), Shot::new(method, 8, spp)).overall();
                let error = found.variance.sqrt();
                println!("{albedo} {phase:?} {depth} {method:?} {what}: {:.6} ± {error:.6}, {expected}", found.mean);
                // Six standard errors, the rounding of the tables, and the ends of the slab.
                assert!((found.mean - expected).abs() < 6.0 * error + 2e-6, "{what}: {found:?}, {expected}");
            }
        }
    }
}

/// The same slab as a grid of twice the coefficients and half the density, turned and larger than the slab.
#[test]
fn a_grid_of_one_density_is_a_homogeneous_medium() {
    let (albedo, depth, reflected, transmitted) = (0.9, 1.0f32, 0.267410, 0.223746);
    let mut description = slab(albedo, Phase::Isotropic, depth);
    let place = DAffine3::from_scale_rotation_translation(
        DVec3::new(9e3, 4e3, 7e3),
        DQuat::from_rotation_y(0.4),
        DVec3::new(-4e3, -2e3, -1e3),
    );
    description.densities.push(DensityGrid::new([3, 4, 2], vec![0.5; 24], place).expect("valid"));
    let MaterialModel::MetallicRoughness(model) = &mut description.materials[0].model else { panic!("not glass") };
    model.volume = model.volume.map(|volume| Volume {
        absorption: volume.absorption * 2.0,
        scattering: volume.scattering * 2.0,
        density: Some(0),
        ..volume
    });
    let scene = scene(description);
    let expected = reflected + transmitted + f64::from((-depth).exp());
    for method in METHODS {
        let found = render(&scene, Shot::new(method, 8, if deep() { 1 << 15 } else { 1 << 10 })).overall();
        let error = found.variance.sqrt();
        println!("{method:?}: {:.6} ± {error:.6}, {expected}", found.mean);
        // As for slabs; the depth of a ray has roundings of places in thousands of metres.
        assert!((found.mean - expected).abs() < 6.0 * error + 1e-4, "{method:?}: {found:?}, {expected}");
    }
}

/// The same slab without absorption of its own under a grid of albedos, which is smaller than the slab: beyond it are
/// the albedos of its border.
#[test]
fn a_grid_of_one_albedo_is_absorption() {
    let (albedo, depth, reflected, transmitted) = (0.9f32, 1.0f32, 0.267410, 0.223746);
    let mut description = slab(1.0, Phase::Isotropic, depth);
    description.albedos.push(ColorGrid::albedos([2, 1, 3], vec![[albedo; 3]; 6], DAffine3::IDENTITY).expect("valid"));
    change(&mut description, |volume| Volume { albedo: Some(0), ..volume });
    let scene = scene(description);
    let expected = reflected + transmitted + f64::from((-depth).exp());
    for method in METHODS {
        let found = render(&scene, Shot::new(method, 8, if deep() { 1 << 15 } else { 1 << 10 })).overall();
        let error = found.variance.sqrt();
        println!("{method:?}: {:.6} ± {error:.6}, {expected}", found.mean);
        // As for slabs.
        assert!((found.mean - expected).abs() < 6.0 * error + 2e-6, "{method:?}: {found:?}, {expected}");
    }
}

/// Absorption alone: the transmittance of a density that grows along the view from 1 to 5 is that of its mean.
#[test]
fn a_grid_that_absorbs_transmits_by_its_mean() {
    let mut description = Description::default();
    add_box(&mut description, Vec3::ZERO, Vec3::splat(0.5), filled(1.0, 0.0, Phase::Isotropic));
    sky(&mut description);
    description.cameras.push(narrow(camera(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO), 0.01));
    let place = DAffine3::from_translation(DVec3::splat(-0.5));
    description.densities.push(DensityGrid::new([1, 1, 5], vec![1.0, 2.0, 3.0, 4.0, 5.0], place).expect("valid"));
    let MaterialModel::MetallicRoughness(model) = &mut description.materials[0].model else { panic!("not glass") };
    model.volume = model.volume.map(|volume| Volume { density: Some(0), ..volume });
    let scene = scene(description);
    for method in METHODS {
        let found = render(&scene, Shot::new(method, 8, 16)).overall();
        let expected = (-3.0f64).exp();
        assert!((found.mean - expected).abs() < 1e-5, "{method:?}: {found:?}, {expected}");
    }
}

/// Nothing is lost: in a white sky all that scatters without loss is invisible, whatever its boundary.
#[test]
fn media_without_absorption_are_invisible_in_a_white_sky() {
    // Uniform directions never follow smooth glass.
    let seeing = &METHODS[1..];
    let cases = [
        (1.0, Phase::Isotropic, &METHODS[..]),
        (1.0, Phase::HenyeyGreenstein(0.9), &METHODS),
        (1.5, Phase::Rayleigh, seeing),
    ];
    for (ior, phase, methods) in cases {
        let mut description = Description::default();
        Ball::new(3, 1.0).add(&mut description, DVec3::ZERO, filled(ior, 1.0, phase));
        sky(&mut description);
        description.cameras.push(camera(DVec3::new(0.0, 0.5, 3.0), DVec3::ZERO));
        let scene = scene(description);
        for &method in methods {
            let found = render(&scene, Shot::new(method, 16, 64)).overall();
            let error = found.variance.sqrt();
            println!("{ior} {phase:?} {method:?}: {:.6} ± {error:.6}", found.mean);
            assert!((found.mean - 1.0).abs() < 6.0 * error + 1e-5, "{ior} {phase:?} {method:?}: {found:?}");
        }
    }
}

/// Deep slabs are half-spaces: H functions of Chandrasekhar.
#[test]
fn deep_slabs_reflect_as_half_spaces() {
    for (albedo, depth, reflected) in [(0.7, 30.0, 0.208680), (0.95, 36.0, 0.535541)] {
        for method in METHODS {
            let found = render(
                &scene(slab(albedo, Phase::Isotropic, depth)),
                Shot::new(method, 8, if deep() { 1 << 15 } else { 1 << 10 }),
            )
            .overall();
            let error = found.variance.sqrt();
            println!("{albedo} {method:?}: {:.6} ± {error:.6}, {reflected}", found.mean);
            // Six standard errors and the rounding of the table.
            assert!((found.mean - reflected).abs() < 6.0 * error + 2e-6, "{albedo} {method:?}: {found:?}");
        }
    }
}

/// `volume` of the first material.
fn change(scene: &mut Description, to: impl Fn(Volume) -> Volume) {
    let MaterialModel::MetallicRoughness(model) = &mut scene.materials[0].model else { panic!("not glass") };
    model.volume = model.volume.map(to);
}

/// Light of a medium that also absorbs, along a way of depth 1: ε/σ (1 − 1/e), homogeneous and as a grid.
#[test]
fn media_that_emit_and_absorb_glow_by_their_depth() {
    for grid in [false, true] {
        let mut description = Description::default();
        add_box(&mut description, Vec3::ZERO, Vec3::splat(0.5), filled(1.0, 0.0, Phase::Isotropic));
        description.cameras.push(narrow(camera(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO), 0.01));
        let density = grid.then_some(0);
        let place = DAffine3::from_translation(DVec3::splat(-0.5));
        if grid {
            description.densities.push(DensityGrid::new([1, 1, 3], vec![0.0, 2.0, 1.0], place).expect("valid"));
        }
        change(&mut description, |volume| Volume { emission: Spectrum::splat(2.0), density, ..volume });
        let scene = scene(description);
        for method in METHODS.into_iter().chain([Method::Pssmlt]) {
            let found = render(&scene, Shot::new(method, 8, 16)).overall();
            let expected = 2.0 * (1.0 - (-1.0f64).exp());
            assert!((found.mean - expected).abs() < 1e-5, "{grid} {method:?}: {found:?}, {expected}");
        }
    }
}

/// A grid of emission in a medium that absorbs, whose density another grid varies: the integral along the view, with
/// the emission linear between the centres of its cells and 0 beyond its box.
#[test]
fn grids_of_emission_glow_by_their_integral() {
    let glow = [0.5, 4.0, 0.0, 2.0f32];
    let mut description = Description::default();
    add_box(&mut description, Vec3::ZERO, Vec3::splat(0.5), filled(1.0, 0.0, Phase::Isotropic));
    description.cameras.push(narrow(camera(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO), 0.01));
    let place = DAffine3::from_translation(DVec3::splat(-0.5));
    description.densities.push(DensityGrid::new([1, 1, 3], vec![0.0, 2.0, 1.0], place).expect("valid"));
    // Four tenths of the box, in its middle.
    let part = DAffine3::from_scale_rotation_translation(
        DVec3::new(2.0, 2.0, 0.4),
        DQuat::IDENTITY,
        DVec3::new(-1.0, -1.0, -0.2),
    );
    let values = glow.iter().map(|&x| [x, 2.0 * x, 0.25 * x]).collect();
    description.emissions.push(ColorGrid::emission([1, 1, 4], values, part).expect("valid"));
    change(&mut description, |volume| Volume {
        absorption: Spectrum([1.0, 4.0, 0.0]),
        emission: Spectrum::splat(2.0),
        density: Some(0),
        emission_grid: Some(0),
        ..volume
    });
    let linear = |values: &[f32], x: f64| {
        let x = (x * values.len() as f64 - 0.5).clamp(0.0, (values.len() - 1) as f64);
        let (low, share) = (x as usize, x.fract());
        let high = (low + 1).min(values.len() - 1);
        f64::from(values[low]) * (1.0 - share) + f64::from(values[high]) * share
    };
    let expected = |sigma: f64| {
        let steps = 100_000;
        let (mut depth, mut sum) = (0.0, 0.0);
        for k in 0..steps {
            let t = (f64::from(k) + 0.5) / f64::from(steps);
            // From the near face at z = 0.5 on; cells are counted from below.
            let density = linear(&[0.0, 2.0, 1.0], 1.0 - t);
            let inside = (0.3..0.7).contains(&t);
            let half = 0.5 * sigma * density / f64::from(steps);
            depth += half;
            if inside {
                sum += f64::exp(-depth) * density * linear(&glow, (0.7 - t) / 0.4) * 2.0 / f64::from(steps);
            }
            depth += half;
        }
        sum
    };
    let scene = scene(description);
    for method in METHODS.into_iter().chain([Method::Pssmlt, Method::Mmlt]) {
        let found = render(&scene, Shot::new(method, 8, if deep() { 1 << 14 } else { 512 })).blocks(1);
        for (lane, (factor, sigma)) in [(1.0, 1.0), (2.0, 4.0), (0.25, 0.0f64)].into_iter().enumerate() {
            let (error, expected) = (found[lane].variance.sqrt(), factor * expected(sigma));
            println!("{method:?} lane {lane}: {:.6} ± {error:.6}, {expected:.6}", found[lane].mean);
            // Six standard errors, and roundings.
            assert!((found[lane].mean - expected).abs() < 6.0 * error + 1e-4 * expected, "{method:?} {lane}");
        }
    }
}

/// Light of a medium behind another that absorbs, exp(−1) ε, and behind one that scatters, which is the same without
/// the light that has scattered.
#[test]
fn media_that_emit_are_seen_through_others() {
    for albedo in [0.0, 1.0] {
        let mut description = Description::default();
        let front = Material { priority: 1, ..filled(1.0, albedo, Phase::Isotropic) };
        add_box(&mut description, Vec3::Z, Vec3::splat(0.5), front);
        let behind = with_model(filled(1.0, 0.0, Phase::Isotropic), |m| {
            m.volume =
                m.volume.map(|v| Volume { absorption: Spectrum::ZERO, emission: Spectrum([1.0, 2.0, 4.0]), ..v });
        });
        add_box(&mut description, Vec3::ZERO, Vec3::splat(0.5), behind);
        description.cameras.push(narrow(camera(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO), 0.01));
        let scene = scene(description);
        for method in METHODS {
            let found = render(&scene, Shot { depth: Some(0), ..Shot::new(method, 8, 1024) });
            for (lane, emission) in [1.0f64, 2.0, 4.0].into_iter().enumerate() {
                let estimate = found.blocks(1)[lane];
                let (error, expected) = (estimate.variance.sqrt(), emission * (-1.0f64).exp());
                println!("{albedo} {method:?} lane {lane}: {:.6} ± {error:.6}, {expected:.6}", estimate.mean);
                // Six standard errors and roundings.
                assert!((estimate.mean - expected).abs() < 6.0 * error + 1e-5, "{albedo} {method:?} {lane}");
            }
        }
    }
}

/// Path lengths do not depend on what scatters [Blanco03]: a medium without absorption emits ε V into parallel rays.
/// With an index η paths are η² times as long, and the radiance is η² times less outside.
#[test]
fn the_mean_path_length_in_a_body_is_invariant() {
    let cases = [
        (1.0, 0.0, Phase::Isotropic, &METHODS[..]),
        (1.0, 4.0, Phase::Isotropic, &METHODS),
        (1.0, 9.0, Phase::HenyeyGreenstein(0.8), &METHODS),
        (1.5, 3.0, Phase::Isotropic, &METHODS[1..]),
    ];
    for (index, scattering, phase, methods) in cases {
        let ball = Ball::new(5, 0.9);
        let corner = |i: u32| ball.positions[i as usize].as_dvec3();
        let cone = |t: &[u32; 3]| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0;
        let volume: f64 = ball.triangles.iter().map(cone).sum();
        let mut description = Description::default();
        ball.add(&mut description, DVec3::ZERO, filled(index, 1.0, phase));
        let (emission, scattering) = (Spectrum([1.0, 0.5, 2.0]), Spectrum::splat(scattering));
        change(&mut description, |volume| Volume { emission, scattering, ..volume });
        let projection = Projection::Orthographic { xmag: 1.0, ymag: 1.0 };
        description.cameras.push(etendue::scene::description::CameraDescription {
            projection,
            ..camera(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO)
        });
        let scene = scene(description);
        // A view of four square metres; the mean of the lanes of ε is 7/6.
        let expected = volume / 4.0 * 7.0 / 6.0;
        for &method in methods {
            let found = render(&scene, Shot::new(method, 16, if deep() { 1 << 14 } else { 1 << 9 })).overall();
            let error = found.variance.sqrt();
            println!("{index} {scattering:?} {method:?}: {:.6} ± {error:.6}, {expected:.6}", found.mean);
            // Facets of the ball are two degrees wide, so that not all directions are alike: their squares.
            assert!(
                (found.mean / expected - 1.0).abs() < 6.0 * error / expected + 1e-3,
                "{index} {method:?}: {found:?}"
            );
        }
    }
}

/// A medium around everything includes cameras and lamps: the way from a bright wall to a camera in front of it.
#[test]
fn a_medium_around_the_scene_is_around_the_camera() {
    let mut description = Description::default();
    add_square(&mut description, Vec3::NEG_Z * 2.0, Vec3::X, Vec3::Y, matte(0.0, 1.0));
    description.cameras.push(narrow(camera(DVec3::new(0.0, 0.0, 1.0), DVec3::ZERO), 0.01));
    description.media.push(Volume { absorption: Spectrum([0.2, 0.5, 1.0]), ..Volume::CLEAR });
    // A second one, within the box of its density, takes precedence where it is.
    let place = DAffine3::from_scale_rotation_translation(
        DVec3::new(-0.5, 1.0, 1.0),
        DQuat::IDENTITY,
        DVec3::new(0.25, -0.5, -1.0),
    );
    description.densities.push(DensityGrid::new([1, 1, 1], vec![0.25], place).expect("valid"));
    description.media.push(Volume { absorption: Spectrum::splat(4.0), density: Some(0), ..Volume::CLEAR });
    let scene = scene(description);
    for method in METHODS {
        let found = render(&scene, Shot::new(method, 8, 16));
        for (lane, sigma) in [0.2f64, 0.5, 1.0].into_iter().enumerate() {
            let (mean, expected) = (found.blocks(1)[lane].mean, (-2.0 * sigma - 1.0).exp());
            assert!((mean - expected).abs() < 1e-5, "{method:?}: {mean}, {expected}");
        }
    }
}

/// A lamp in fog and its light that scatters once, against the integral along the view, far from it and beside it. By
/// flights alone the standard error beside the lamp is ten times as large.
#[test]
fn light_of_a_point_that_scatters_once_is_its_integral() {
    for (lamp, most) in [(DVec3::new(0.3, 0.8, 0.0), 2e-3), (DVec3::new(0.02, 0.0, -0.5), 2e-3)] {
        let phase = Phase::HenyeyGreenstein(0.4);
        let mut description = Description::default();
        add_box(&mut description, Vec3::ZERO, Vec3::splat(2.0), filled(1.0, 0.7, phase));
        description.lights.push(point_light(lamp, 3.0));
        let eye = DVec3::new(0.0, 0.0, 1.0);
        description.cameras.push(narrow(camera(eye, DVec3::ZERO), 1e-4));
        let scene = scene(description);
        let steps = 200_000;
        let length = 3.0;
        let at = |k: i32| {
            let t = length * (f64::from(k) + 0.5) / f64::from(steps);
            let p = eye + DVec3::NEG_Z * t;
            let to = lamp - p;
            let (d, cos) = (to.length(), -(to.normalize().dot(DVec3::Z)));
            let g = 0.4f64;
            let value = (1.0 - g * g) / (4.0 * std::f64::consts::PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5));
            0.7 * 3.0 * value * (-t - d).exp() / (d * d)
        };
        let expected: f64 = (0..steps).map(at).sum::<f64>() * length / f64::from(steps);
        for method in [Method::Path, Method::PathNee, Method::Bdpt] {
            let shot = Shot { depth: Some(1), ..Shot::new(method, 8, 4096) };
            let found = render(&scene, shot).overall();
            let error = found.variance.sqrt();
            println!("{lamp} {method:?}: {:.6} ± {error:.6}, {expected:.6}", found.mean);
            // The midpoint rule beside the lamp, and the width of the view: 1e-4.
            assert!(
                (found.mean / expected - 1.0).abs() < 6.0 * error / expected + 1e-4,
                "{method:?}: {found:?} {expected}"
            );
            assert!(method == Method::Bdpt || error < most * expected, "{method:?}: {error} {expected}");
        }
    }
}

/// The same beside small lamps, at whose distance a direction by chance seldom or often hits them. A strong lamp that
/// shines away takes nearly all light samples in the last case, so that hits and equiangular samples share the light.
#[test]
fn light_of_a_small_lamp_that_scatters_once_is_its_integral() {
    for (beside, edge, other, most) in [(0.02, 0.004, 0.0, 3e-3), (0.03, 0.05, 0.0, 3e-3), (0.03, 0.05, 0.8, 1.0)] {
        let phase = Phase::HenyeyGreenstein(0.4);
        let mut description = Description::default();
        add_box(&mut description, Vec3::ZERO, Vec3::splat(2.0), filled(1.0, 0.7, phase));
        let middle = DVec3::new(beside, 0.0, -0.5);
        // It faces the view.
        let half = 0.5 * edge as f32;
        let lamp = Material { double_sided: false, ..matte(0.0, 40.0) };
        add_square(&mut description, middle.as_vec3(), Vec3::Z * half, Vec3::Y * half, lamp.clone());
        if other > 0.0 {
            let half = 0.5 * other;
            add_square(&mut description, Vec3::NEG_Y * 1.9, Vec3::X * half, Vec3::Z * half, lamp);
        }
        let eye = DVec3::new(0.0, 0.0, 1.0);
        description.cameras.push(narrow(camera(eye, DVec3::ZERO), 1e-4));
        let scene = scene(description);
        let (steps, cells, length) = (20_000, 16, 3.0);
        let (step, cell) = (length / f64::from(steps), edge / f64::from(cells));
        let part = |k: i32| (f64::from(k) + 0.5) * cell - 0.5 * edge;
        let mut expected = 0.0;
        for k in 0..steps {
            let t = step * (f64::from(k) + 0.5);
            let p = eye + DVec3::NEG_Z * t;
            for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
                let to = middle + DVec3::new(0.0, part(i), part(j)) - p;
                let (d, g) = (to.length(), 0.4f64);
                let (cos, turn) = (to.x / d, -to.z / d);
                let value = (1.0 - g * g) / (4.0 * std::f64::consts::PI * (1.0 + g * g - 2.0 * g * turn).powf(1.5));
                expected += 0.7 * 40.0 * value * (-t - d).exp() * cos / (d * d) * step * cell * cell;
            }
        }
        for method in [Method::Path, Method::PathNee, Method::Bdpt] {
            let shot = Shot { depth: Some(1), ..Shot::new(method, 8, if deep() { 1 << 16 } else { 4096 }) };
            let found = render(&scene, shot).overall();
            let error = found.variance.sqrt();
            println!("{beside} {edge} {other} {method:?}: {:.6} ± {error:.6}, {expected:.6}", found.mean);
            // The midpoint rule over the lamp, a sixteenth of its distance at most, and the width of the view.
            assert!(
                (found.mean / expected - 1.0).abs() < 6.0 * error / expected + 1e-3,
                "{method:?}: {found:?} {expected}"
            );
            assert!(method == Method::Bdpt || error < most * expected, "{method:?}: {error} {expected}");
        }
    }
}
