//! Instance and material identifiers at pixel centres, seen from the centre of the lens. They are exact, since
//! averaging over samples would mix them.

use crate::camera::Camera;
use crate::film::Layout;
use crate::scene::Scene;
use rayon::prelude::*;

/// Returns instance and material index (from 0; −1 for nothing) at the centre of each pixel of `layout`.
pub fn ids(scene: &Scene, camera: &Camera, layout: &Layout) -> [Vec<f32>; 2] {
    let at = |index: usize| {
        let [x, y] = layout.pixel(index);
        let point = scene.seen(camera.ray([x as f32 + 0.5, y as f32 + 0.5]));
        point.map_or([-1.0; 2], |p| scene.ids(&p).map(|id| id as f32))
    };
    let both: Vec<[f32; 2]> = (0..layout.pixels()).into_par_iter().map(at).collect();
    [0, 1].map(|k| both.iter().map(|ids| ids[k]).collect())
}
