//! Which files a render leaves behind.

use super::Selection;
use crate::error::{Error, Result};
use crate::io::atomic::target;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// The files to write.
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
    /// The files that `-o PATH` stands for.
    ///
    /// # Errors
    /// An ending that is not `.exr`, `.png` or `.film`.
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

    /// What a run over `selection` of the picture `name` writes when nothing was asked for.
    pub fn default_for(name: &OsStr, selection: Selection) -> Outputs {
        let with = |ending: String| Some([name, OsStr::new(&ending)].into_iter().collect::<OsString>().into());
        match selection {
            Selection::All => Outputs { exr: with(".exr".into()), ..Outputs::default() },
            Selection::Shard { .. } | Selection::Range { .. } => {
                let part = part_name(selection);
                Outputs { film: with(format!(".{part}.film")), ..Outputs::default() }
            }
        }
    }

    /// The same with a PNG beside the EXR or the film.
    pub fn with_png(mut self) -> Self {
        self.png = self.png.or_else(|| Some(self.exr.as_ref().or(self.film.as_ref())?.with_extension("png")));
        self
    }

    /// The same with the film at `path`, or beside the image where a part of a picture is rendered: a part is worth
    /// little without its film.
    pub fn with_film(mut self, path: Option<PathBuf>, selection: Selection) -> Self {
        self.film = match selection {
            Selection::All => path.or(self.film),
            _ => path.or_else(|| self.checkpoint()),
        };
        self
    }

    /// Where the film goes if the render is stopped: the film itself, else beside the image.
    pub fn checkpoint(&self) -> Option<PathBuf> {
        self.film.clone().or_else(|| Some(self.image()?.with_extension("film")))
    }

    /// The image that a person would look at first.
    pub fn image(&self) -> Option<&Path> {
        self.exr.as_deref().or(self.png.as_deref())
    }

    /// All the files.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        [&self.exr, &self.png, &self.film].into_iter().filter_map(|p| p.as_deref())
    }
}

/// A part of a picture in a file name: `shard-0-of-4`, `passes-8-15`.
fn part_name(selection: Selection) -> String {
    match selection {
        Selection::All => "all".into(),
        Selection::Shard { index, count } => format!("shard-{index}-of-{count}"),
        Selection::Range { start, end } => format!("passes-{start}-{}", end - 1),
    }
}

/// The picture's name for a scene file, bytes as they are: its stem, or its folder's name if it is just called `scene`.
pub fn picture_name(scene: &Path) -> OsString {
    let stem = scene.file_stem().map_or_else(|| "image".into(), OsStr::to_owned);
    if stem != "scene" {
        return stem;
    }
    std::path::absolute(scene).ok().and_then(|p| p.parent()?.file_name().map(OsStr::to_owned)).unwrap_or(stem)
}

/// Makes sure that a file can be written at `path`, without touching one that is there.
///
/// # Errors
/// Says why not.
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
        let shard: Selection = "1/4".parse().unwrap();
        assert_eq!(Outputs::default_for(OsStr::new("cup"), shard).film, Some("cup.shard-1-of-4.film".into()));
        let image = Outputs::of(Path::new("x.exr")).unwrap();
        assert_eq!(image.clone().with_film(None, shard).film, Some("x.film".into()));
        assert_eq!(image.clone().with_film(None, Selection::All).film, None);
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
