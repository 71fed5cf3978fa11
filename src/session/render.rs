//! The facade: load a [`Scene`], describe a [`Render`], get an [`Image`].
//!
//! ```no_run
//! use etendue::{Method, Render, Scene};
//!
//! fn main() -> etendue::Result<()> {
//!     let scene = Scene::load("scene.gltf")?;
//!     let image = Render::new(&scene).method(Method::Mlt).size(640, 480).spp(64).run()?;
//!     println!("relMSE {}", image.error()?.relmse.value);
//!     image.write("out.exr")?;
//!     Ok(())
//! }
//! ```

use super::{
    LoadedScene, Observer, Outputs, Overrides, PassSelection, Progress, RenderReport, Rendered, Session, SettingsPatch,
    Size,
};
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::film::{Film, ImageError, Plane};
use crate::integrator::{Integrator, IntegratorConfig, Method};
use crate::parallel::{Cancel, cores, pool};
use crate::scene::description::Description;
use crate::scene::{BuildOptions, Scene};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

impl Scene {
    /// Loads and builds the scene in a file, for the default backend and on all threads. It is shared: clones are
    /// cheap, and any number of renders may use it at once. Must be called from outside the rayon pool.
    ///
    /// # Errors
    /// The file cannot be read or is no valid scene.
    pub fn load(path: impl AsRef<Path>) -> Result<Arc<LoadedScene>> {
        SettingsPatch::default().resolve(PassSelection::All)?.load(path.as_ref(), cores()).map(Arc::new)
    }

    /// Builds a scene that was described in code, as [`Scene::load`] does.
    ///
    /// # Errors
    /// The description is invalid.
    pub fn from_description(description: Description) -> Result<Arc<LoadedScene>> {
        let options = BuildOptions { threads: cores(), ..BuildOptions::default() };
        LoadedScene::build(description, Path::new("described"), Overrides::default(), &options).map(Arc::new)
    }
}

/// Builds the caller's own integrator.
type Builder = Box<dyn for<'a> FnOnce(&'a Scene, Camera, &IntegratorConfig) -> Box<dyn Integrator + 'a> + Send>;

/// A function that is called after each pass, and may end the render.
type Watcher = Box<dyn FnMut(&Progress<'_>) -> ControlFlow<()> + Send>;

/// A render of a scene: choices, then [`Render::run`]. Without choices it is what `etendue render` does without flags.
pub struct Render {
    scene: Arc<LoadedScene>,
    patch: SettingsPatch,
    threads: Option<usize>,
    watcher: Option<Watcher>,
    integrator: Option<Builder>,
}

impl Render {
    /// Begins a render of `scene`.
    pub fn new(scene: &Arc<LoadedScene>) -> Self {
        let (scene, patch) = (Arc::clone(scene), SettingsPatch::default());
        Render { scene, patch, threads: None, watcher: None, integrator: None }
    }

    /// Chooses the method.
    pub fn method(self, method: Method) -> Self {
        self.with(|patch| patch.method = Some(method))
    }

    /// Chooses the image size in pixels.
    pub fn size(self, width: u32, height: u32) -> Self {
        self.with(|patch| patch.size = Some(Size { width, height: Some(height) }))
    }

    /// Chooses the samples per pixel, rounded up to the replicates times a power of two.
    pub fn spp(self, spp: u32) -> Self {
        self.with(|patch| patch.spp = Some(spp))
    }

    /// Limits the rendering time.
    pub fn time(self, time: Duration) -> Self {
        self.with(|patch| patch.time = Some(super::Budget(time)))
    }

    /// Ends the render once relMSE is below `relmse` with 95 % confidence.
    pub fn target_error(self, relmse: f64) -> Self {
        self.with(|patch| patch.target_error = Some(relmse))
    }

    /// Chooses the camera, by name or number.
    pub fn camera(self, camera: &str) -> Self {
        self.with(|patch| patch.camera = Some(camera.to_owned()))
    }

    /// Chooses the seed of all random numbers.
    pub fn seed(self, seed: u64) -> Self {
        self.with(|patch| patch.seed = Some(seed))
    }

    /// Replaces these choices by those of `patch`, where it has any. A choice of backend, animation or environment has
    /// no effect here, since the scene is built.
    pub fn settings(self, patch: SettingsPatch) -> Self {
        Render { patch: patch.or(self.patch), ..self }
    }

    /// Renders in a pool of its own, of that many threads, in place of the caller's rayon pool.
    pub fn threads(self, threads: usize) -> Self {
        Render { threads: Some(threads), ..self }
    }

    /// Calls `watcher` after each pass. `ControlFlow::Break` ends the render; the image then has the passes so far.
    pub fn watch(self, watcher: impl FnMut(&Progress<'_>) -> ControlFlow<()> + Send + 'static) -> Self {
        Render { watcher: Some(Box::new(watcher)), ..self }
    }

    /// Renders by an integrator of the caller's own, in place of the method's. The method still decides the pilot and
    /// which units of the image count as independent.
    pub fn integrator(
        self,
        build: impl for<'a> FnOnce(&'a Scene, Camera, &IntegratorConfig) -> Box<dyn Integrator + 'a> + Send + 'static,
    ) -> Self {
        Render { integrator: Some(Box::new(build)), ..self }
    }

    /// Renders the image.
    ///
    /// # Errors
    /// A choice is out of range, the method refuses the scene, or memory does not suffice.
    pub fn run(self) -> Result<Image> {
        let Render { scene, patch, threads, watcher, integrator } = self;
        let work = || render(&scene, &patch, watcher, integrator);
        match threads {
            Some(threads) => pool(threads)?.install(work),
            None => work(),
        }
    }

    fn with(mut self, change: impl FnOnce(&mut SettingsPatch)) -> Self {
        change(&mut self.patch);
        self
    }
}

fn render(
    scene: &LoadedScene,
    patch: &SettingsPatch,
    watcher: Option<Watcher>,
    integrator: Option<Builder>,
) -> Result<Image> {
    let job = patch.resolve(PassSelection::All)?.fitted(scene)?;
    let mut session = Session::begin(scene, job.provenance(scene))?;
    let cancel = Cancel::new();
    let mut observer = Watched { watcher, cancel: cancel.clone() };
    match integrator {
        Some(build) => {
            session.run_with(&cancel, &mut observer, None, |scene, camera, options, _| build(scene, camera, options))?
        }
        None => session.run(&cancel, &mut observer, None)?,
    };
    Ok(Image(session.end()?))
}

struct Watched {
    watcher: Option<Watcher>,
    cancel: Cancel,
}

impl Observer for Watched {
    fn pass(&mut self, progress: &Progress<'_>) {
        if self.watcher.as_mut().is_some_and(|watcher| watcher(progress).is_break()) {
            self.cancel.request();
        }
    }

    fn unsaved(&mut self, _: &Error) {}
}

/// A rendered image with its film.
pub struct Image(Rendered);

impl Image {
    /// Returns width and height of the rendered window in pixels.
    pub fn size(&self) -> [u32; 2] {
        let crop = self.film().layout().crop;
        [crop.x1 - crop.x0, crop.y1 - crop.y0]
    }

    /// Returns linear Rec. 709 radiance, three values a pixel, row by row from the top left.
    pub fn rgb(&self) -> Vec<f32> {
        self.film().mean(Plane::Color)
    }

    /// Returns the standard error of [`Image::rgb`]; `None` without replicates.
    pub fn standard_error(&self) -> Option<Vec<f32>> {
        self.film().standard_error()
    }

    /// Returns the error of the image.
    ///
    /// # Errors
    /// A usage error if the image has no replicates to measure the error between.
    pub fn error(&self) -> Result<ImageError> {
        let unknown = || Error::usage("the error is unknown: it is measured between two replicates or more");
        self.0.provenance.error_of(self.film()).ok_or_else(unknown)
    }

    /// Returns the film: sums that can be saved, continued and merged.
    pub fn film(&self) -> &Film {
        &self.0.film
    }

    /// Writes an EXR or PNG image, or a film, by the ending of `path`. Returns the report.
    ///
    /// # Errors
    /// The ending is another one, or the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<RenderReport> {
        self.0.write(&Outputs::of(path.as_ref())?)
    }
}
