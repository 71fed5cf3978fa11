//! Renders with an integrator of its own: `cargo run --release --example own_integrator`. The same session runs it: its
//! films, error bars and images are those of every method.

use etendue::camera::Camera;
use etendue::film::PassFilm;
use etendue::geometry::{Frame, Local};
use etendue::integrator::{Integrator, PassReport, RayCounts};
use etendue::parallel::Cancel;
use etendue::sampling::{Address, IndependentSampler, Sampler, Slot, warp};
use etendue::{Render, Scene};
use rayon::prelude::*;

/// Ambient occlusion: the fraction of cosine-distributed directions from the first hit that leave the scene.
struct AmbientOcclusion<'a> {
    scene: &'a Scene,
    camera: Camera,
    seed: u64,
}

impl AmbientOcclusion<'_> {
    fn sample(&self, pixel: [u32; 2], sampler: &mut impl Sampler) -> f32 {
        let [x, y] = sampler.u2(0, Slot::Film);
        let lens = self.camera.sample_lens(|| sampler.u2(0, Slot::Lens));
        let ray = self.camera.sample_ray([pixel[0] as f32 + x, pixel[1] as f32 + y], lens, 0.0).ray;
        let Some(point) = self.scene.seen(ray) else { return 1.0 };
        let normal = if ray.direction.dot(point.ng) < 0.0 { point.ng } else { -point.ng };
        let [x, y, z] = warp::cosine_hemisphere(sampler.u2(1, Slot::Direction)).to_array();
        let direction = Frame::around(normal).to_world(Local::new(x, y, z));
        let is_open = self.scene.intersect(&point.spawn(direction)).is_none();
        f32::from(u8::from(is_open))
    }
}

impl Integrator for AmbientOcclusion<'_> {
    fn run_pass(&self, pass: u64, cancel: &Cancel, out: &mut PassFilm) -> Option<PassReport> {
        let layout = out.layout().clone();
        let channels = layout.channels();
        out.par_chunks(64).for_each(|(first, values)| {
            for (i, value) in values.chunks_exact_mut(channels).enumerate() {
                let pixel = layout.pixel(first + i);
                let address = Address::new(self.seed).with(pass).with(u64::from(pixel[1])).with(u64::from(pixel[0]));
                value[..3].fill(self.sample(pixel, &mut IndependentSampler::new(address)));
            }
        });
        let camera = layout.pixels() as u64;
        let rays = RayCounts { camera, bounce: camera, shadow: 0 };
        (!cancel.requested()).then(|| PassReport { rays, ..PassReport::default() })
    }
}

fn main() -> etendue::Result<()> {
    let scene = Scene::load("scenes/cornell-box/scene.gltf")?;
    let render = Render::new(&scene).size(64, 64).spp(16);
    let image =
        render.integrator(|scene, camera, options| Box::new(AmbientOcclusion { scene, camera, seed: options.seed }));
    let image = image.run()?;
    println!("mean {:.4} ± {:.4}", image.error()?.mean, image.error()?.mean_standard_error);
    Ok(())
}
