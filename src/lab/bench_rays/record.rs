//! Records the rays of a render as they are traced.

use super::recorder::Recorder;
use super::stream::RayStream;
use crate::camera::Camera;
use crate::error::Result;
use crate::film::{Crop, Layout, PassFilm};
use crate::integrator::{self, Execution, MethodConfig, PilotEstimate, RayCounts};
use crate::parallel::{Cancel, pool};
use crate::scene::Scene;
use crate::session::{LoadedScene, RenderSettings};

/// Longer side, in pixels, of the probe picture whose ray count predicts that of a large one.
const PROBE_SIDE: f64 = 64.0;

/// A picture of a scene: the camera and the pixels of `settings`.
pub(super) struct View {
    settings: RenderSettings,
    camera: Camera,
    layout: Layout,
}

impl View {
    /// Creates the view that `settings` describe.
    ///
    /// # Errors
    /// The camera does not exist.
    pub(super) fn new(scene: &Scene, settings: RenderSettings) -> Result<View> {
        let camera = settings.camera_in(scene)?;
        Ok(View { layout: settings.layout(), camera, settings })
    }

    /// Creates the view with fewer pixels if a pass would trace many more than `most` rays.
    ///
    /// # Errors
    /// The camera does not exist.
    pub(super) fn within(scene: &Scene, settings: &RenderSettings, most: u64) -> Result<View> {
        let longer = f64::from(settings.width.max(settings.height));
        let probe = View::new(scene, shrunk(settings, (PROBE_SIDE / longer).min(1.0)))?;
        let each = probe.pass(scene, 0).total() as f64 / probe.layout.pixels() as f64;
        let all = each * settings.layout().pixels() as f64;
        View::new(scene, shrunk(settings, (most as f64 / all).sqrt().min(1.0)))
    }

    /// Width and height in pixels.
    pub(super) fn size(&self) -> [u32; 2] {
        [self.settings.width, self.settings.height]
    }

    /// Returns the execution of passes by `path`, which orders their rays; `None` for other methods.
    pub(super) fn execution(&self, scene: &Scene) -> Option<Execution> {
        let is_path = matches!(self.settings.method, MethodConfig::Path(_));
        is_path.then(|| Execution::chosen(self.settings.execution, scene))
    }

    /// Renders a pass in the current rayon pool and counts its rays.
    pub(super) fn pass(&self, scene: &Scene, pass: u64) -> RayCounts {
        let options = self.settings.options();
        let integrator = integrator::build(scene, self.camera.clone(), &options, &PilotEstimate::default());
        let report = integrator.run_pass(pass, &Cancel::new(), &mut PassFilm::new(&self.layout));
        report.unwrap_or_default().rays
    }
}

/// Records the rays of pass 0. Returns the unchanged stage, the stream with the name `name`, and the ray counts of the
/// pass itself.
///
/// # Errors
/// An internal error if no thread can be started.
pub(super) fn record(stage: LoadedScene, view: &View, name: &str) -> Result<(LoadedScene, RayStream, RayCounts)> {
    let (scene, recorder) = stage.scene.with_accel(Recorder::of);
    let counted = pool(1)?.install(|| view.pass(&scene, 0));
    let (scene, questions) = scene.with_accel(|recording| recorder.end(recording));
    let stream = RayStream { name: name.to_owned(), scene_hash: scene.hash().to_owned(), questions };
    Ok((LoadedScene { scene, ..stage }, stream, counted))
}

/// Scales the sides of the image by `share`, at most 1.
fn shrunk(settings: &RenderSettings, share: f64) -> RenderSettings {
    let side = |pixels: u32| ((f64::from(pixels) * share).round() as u32).max(1);
    let [width, height] = [side(settings.width), side(settings.height)];
    let crop = settings.crop.map(|c| {
        let range = |from: u32, to: u32, most: u32| {
            let first = ((f64::from(from) * share) as u32).min(most - 1);
            (first, (first + side(to - from)).min(most))
        };
        let ((x0, x1), (y0, y1)) = (range(c.x0, c.x1, width), range(c.y0, c.y1, height));
        Crop { x0, y0, x1, y1 }
    });
    RenderSettings { width, height, crop, ..settings.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::RayClass;
    use crate::lab::bench_rays::RayQuery;
    use crate::session::SettingsPatch;

    fn recorded(scene: &str, choices: &SettingsPatch) -> (Vec<RayQuery>, RayCounts) {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{scene}/scene.gltf"));
        let settings = choices.settings(Some(1.0)).unwrap();
        let stage = LoadedScene::open(
            &path,
            crate::session::Overrides::default(),
            &settings.moment(),
            &settings.build_options(1),
        )
        .unwrap();
        let view = View::new(&stage.scene, settings).unwrap();
        let (_, stream, counted) = record(stage, &view, scene).unwrap();
        (stream.questions, counted)
    }

    /// The ray counts of a pass match the queries that its backend receives, class by class, with AOVs too.
    #[test]
    fn pass_report_counts_match_recorded_queries() {
        let small = SettingsPatch { size: Some("24x24".parse().unwrap()), ..SettingsPatch::default() };
        let layers = SettingsPatch { aovs: Some(vec![crate::session::Aov::Albedo]), ..small.clone() };
        for (scene, choices) in [("cornell-box", &small), ("cornell-box", &layers), ("sphere-cap", &small)] {
            let (questions, counted) = recorded(scene, choices);
            let count =
                |is: fn(RayClass) -> bool| questions.iter().filter(|question| is(question.class)).count() as u64;
            let [camera, bounce, shadow] = [
                count(|class| class == RayClass::Camera),
                count(|class| matches!(class, RayClass::Bounce(1..))),
                count(|class| class == RayClass::Shadow),
            ];
            assert_eq!(RayCounts { camera, bounce, shadow }, counted, "{scene}");
            assert!(camera >= 24 * 24 && bounce > 0 && shadow > 0, "{counted:?}");
        }
    }

    #[test]
    fn smaller_pictures_keep_their_window() {
        let crop = Some(Crop { x0: 100, y0: 0, x1: 200, y1: 3 });
        let settings = RenderSettings { crop, ..SettingsPatch::default().settings(Some(2.0)).unwrap() };
        assert_eq!(shrunk(&settings, 1.0), settings);
        let half = shrunk(&settings, 0.5);
        assert_eq!((half.width, half.height, half.crop), (640, 320, Some(Crop { x0: 50, y0: 0, x1: 100, y1: 2 })));
        let least = shrunk(&settings, 1e-9);
        assert_eq!((least.width, least.height, least.crop), (1, 1, Some(Crop { x0: 0, y0: 0, x1: 1, y1: 1 })));
    }
}
