//! Renders a scene file: `cargo run --release --example render`.

use etendue::{Method, Render, Scene};

fn main() -> etendue::Result<()> {
    let scene = Scene::load("scenes/cornell-box/scene.gltf")?;
    let image = Render::new(&scene).method(Method::Bdpt).size(64, 64).spp(16).run()?;
    let ([width, height], error) = (image.size(), image.error()?.relmse);
    println!("{width}x{height}, relMSE {:.2e}, 95 % interval {:.2e} to {:.2e}", error.value, error.low, error.high);
    image.write(std::env::temp_dir().join("cornell-box.exr"))?;
    Ok(())
}
