//! Output files of a render.

use super::PassSelection;
use crate::error::{Error, Result};
use crate::io::atomic::target;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// Paths of the output files.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Outputs {
    /// The EXR image.
    pub exr: Option<PathBuf>,
    /// The PNG image.
    pub png: Option<PathBuf>,
    /// The film.
    pub film: Option<PathBuf>,
}

impl Outputs {
    /// Returns the files that `-o PATH` stands for.
    ///
    /// # Errors
    /// The ending is not `.exr`, `.png` or `.film`.
    pub fn of(path: &Path) -> Result<Outputs> {
        let path = path.to_owned();
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        match ending.as_str() {
            "exr" => Ok(Outputs { exr: Some(path), ..Outputs::default() }),
            "png" => Ok(Outputs { png: Some(path), ..Outputs::default() }),
            "film" => Ok(Outputs { film: Some(path), ..Outputs::default() }),
            _ => Err(Error::usage(format!("{}: the output must end in .exr, .png or .film", path.display()))),
        }
    }

    /// Returns the default outputs of a run over `selection` of the picture `name`.
    pub fn default_for(name: &OsStr, selection: PassSelection) -> Outputs {
        let with = |ending: String| Some([name, OsStr::new(&ending)].into_iter().collect::<OsString>().into());
        match selection {
            PassSelection::All => Outputs { exr: with(".exr".into()), ..Outputs::default() },
            PassSelection::Shard { .. } | PassSelection::Range { .. } => {
                let part = part_name(selection);
                Outputs { film: with(format!(".{part}.film")), ..Outputs::default() }
            }
        }
    }

    /// Adds a PNG beside the EXR or the film.
    pub fn with_png(mut self) -> Self {
        self.png = self.png.or_else(|| Some(self.exr.as_ref().or(self.film.as_ref())?.with_extension("png")));
        self
    }

    /// Adds the film at `path`. For a part of a picture the film defaults to a file beside the image, since a part
    /// without its film cannot be merged.
    pub fn with_film(mut self, path: Option<PathBuf>, selection: PassSelection) -> Self {
        self.film = match selection {
            PassSelection::All => path.or(self.film),
            _ => path.or_else(|| self.checkpoint()),
        };
        self
    }

    /// Returns the path of the film that is saved if the render is stopped: the film output, else beside the image.
    pub fn checkpoint(&self) -> Option<PathBuf> {
        self.film.clone().or_else(|| Some(self.image()?.with_extension("film")))
    }

    /// Returns the primary image.
    pub fn image(&self) -> Option<&Path> {
        self.exr.as_deref().or(self.png.as_deref())
    }

    /// Returns all paths.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        [&self.exr, &self.png, &self.film].into_iter().filter_map(|p| p.as_deref())
    }
}

/// Name of a part of a picture in file names: `shard-0-of-4`, `passes-8-15`.
fn part_name(selection: PassSelection) -> String {
    match selection {
        PassSelection::All => "all".into(),
        PassSelection::Shard { index, count } => format!("shard-{index}-of-{count}"),
        PassSelection::Range { start, end } => format!("passes-{start}-{}", end - 1),
    }
}

/// Returns the picture's name for a scene file, as raw bytes of the platform: its stem, or its folder's name if the
/// stem is `scene`.
pub fn picture_name(scene: &Path) -> OsString {
    let stem = scene.file_stem().map_or_else(|| "image".into(), OsStr::to_owned);
    if stem != "scene" {
        return stem;
    }
    std::path::absolute(scene).ok().and_then(|p| p.parent()?.file_name().map(OsStr::to_owned)).unwrap_or(stem)
}

/// Checks that a file can be written at `path`, without touching an existing one.
///
/// # Errors
/// The reason why it cannot be written.
pub fn writable(path: &Path) -> Result<()> {
    if path.is_dir() {
        return Err(Error::new(crate::error::Kind::Output, format!("cannot write {}: it is a folder", path.display())));
    }
    let target = target(path).map_err(|cause| Error::write(path, cause))?;
    tempfile::tempfile_in(folder(&target)).map(drop).map_err(|cause| Error::write(path, cause))
}

/// The folder that a file is in.
fn folder(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_decide_what_is_written() {
        assert_eq!(Outputs::of(Path::new("a.exr")).unwrap().exr, Some("a.exr".into()));
        assert_eq!(Outputs::of(Path::new("a.b.PNG")).unwrap().png, Some("a.b.PNG".into()));
        assert_eq!(Outputs::of(Path::new("a.film")).unwrap().film, Some("a.film".into()));
        for wrong in ["a", "a.jpg", "exr", ".exr"] {
            assert!(Outputs::of(Path::new(wrong)).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_part_of_a_picture_keeps_its_film() {
        let shard: PassSelection = "1/4".parse().unwrap();
        assert_eq!(Outputs::default_for(OsStr::new("cup"), shard).film, Some("cup.shard-1-of-4.film".into()));
        let image = Outputs::of(Path::new("x.exr")).unwrap();
        assert_eq!(image.clone().with_film(None, shard).film, Some("x.film".into()));
        assert_eq!(image.clone().with_film(None, PassSelection::All).film, None);
        assert_eq!(image.clone().checkpoint(), Some("x.film".into()));
        assert_eq!(image.with_png().png, Some("x.png".into()));
    }

    #[test]
    fn scenes_called_scene_are_named_by_their_folder() {
        assert_eq!(picture_name(Path::new("a/cup.glb")), "cup");
        assert_eq!(picture_name(Path::new("a/cup/scene.gltf")), "cup");
    }

    #[test]
    fn unwritable_places_are_known_beforehand() {
        let folder = tempfile::tempdir().unwrap();
        assert!(writable(&folder.path().join("x.exr")).is_ok());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        for wrong in [folder.path().to_owned(), folder.path().join("none/x.exr"), "/dev/null/x.exr".into()] {
            assert_eq!(writable(&wrong).unwrap_err().kind, crate::error::Kind::Output, "{}", wrong.display());
        }
    }
}
