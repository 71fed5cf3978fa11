//! TEMP stand-in until the scene is merged.
#![allow(missing_docs)]
pub mod description;
use crate::accel::Build;
use crate::camera::Camera;
use crate::error::{Error, Result};
use description::Description;
#[derive(Debug)]
pub struct Scene(Description);
#[derive(Debug)]
pub struct BuildOptions {
    pub build: Build,
    pub threads: usize,
}
#[derive(Debug, Clone, Default, serde::Serialize)]
pub struct SceneInfo {
    pub triangles: u64,
    pub instances: u64,
    pub meshes: u64,
    pub materials: u64,
    pub lights: u64,
    pub textures: u64,
    pub texture_bytes: u64,
    pub geometry_bytes: u64,
    pub accel_bytes: u64,
    pub features: Vec<String>,
    pub ignored: Vec<String>,
    pub warnings: Vec<String>,
    pub centre: [f64; 3],
    pub scale: f64,
}
impl Scene {
    pub fn build(description: Description, _: &BuildOptions) -> Result<Scene> {
        Ok(Scene(description))
    }
    pub fn camera(&self, selector: Option<&str>, _: u32, _: u32) -> Result<Camera> {
        match selector {
            None | Some("0") => Ok(Camera),
            Some(other) => Err(Error::scene(format!("no camera {other}"))),
        }
    }
    pub fn cameras(&self) -> Vec<String> {
        vec!["camera".into()]
    }
    pub fn aspect(&self, _: Option<&str>) -> Option<f64> {
        None
    }
    pub fn info(&self) -> SceneInfo {
        SceneInfo { ignored: self.0.ignored.clone(), ..Default::default() }
    }
    pub fn blind_spots(&self, method: impl Copy) -> Vec<String> {
        let _ = method;
        vec![]
    }
    pub fn hash(&self) -> String {
        "TEMP".into()
    }
}
