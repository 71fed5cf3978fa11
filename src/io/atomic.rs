//! Atomic file writes. Every output goes through here, so that a kill at any time leaves the old file intact.

use crate::error::{Error, Kind, Result};
use std::fs::{File, OpenOptions};
use std::io::{self, Seek};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, TempPath};

const PREFIX: &str = ".etendue-";
const SUFFIX: &str = ".tmp";

/// Writes a file by `fill` without a name, or under a temporary name in the same folder, syncs it, renames it to `path`
/// and syncs the folder. A symbolic link at `path` is kept, and its target is written, whether or not it exists.
///
/// # Errors
/// [`Kind::Output`] with the path if a step fails. The temporary file is then removed, and an old file at `path` is
/// left untouched.
pub fn write_atomically(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> Result<()> {
    if path.file_name().is_none() {
        return Err(Error::new(Kind::Output, format!("cannot write {}: it names no file", path.display())));
    }
    target(path).and_then(|path| replace(&path, fill)).map_err(|cause| Error::write(path, cause))
}

/// Maximum number of symbolic links in a path, as in Linux.
const MOST_LINKS: usize = 40;

/// Resolves all symbolic links at `path`, even if the final target does not exist.
///
/// # Errors
/// The links form a cycle or are too many.
pub fn target(path: &Path) -> io::Result<PathBuf> {
    let mut place = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        match std::fs::read_link(&place) {
            Ok(to) => place = place.parent().unwrap_or(Path::new("")).join(to),
            // Not a link, or not there.
            Err(_) => return Ok(place),
        }
    }
    Err(io::Error::other("too many levels of symbolic links"))
}

fn replace(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let temporary = match unnamed::create(folder) {
        Some(mut file) => {
            fill(&mut file)?;
            file.sync_all()?;
            name(file, folder)?
        }
        None => {
            let mut temporary = create(folder)?;
            fill(temporary.as_file_mut())?;
            temporary.as_file().sync_all()?;
            temporary.into_temp_path()
        }
    };
    temporary.persist(path)?;
    sync_folder(folder)
}

/// Creates a file under a temporary name, with the mode of any other new file.
fn create(folder: &Path) -> io::Result<NamedTempFile> {
    // With an explicit creation mode the umask applies. By default, temporary files are private.
    let create = |name: &Path| OpenOptions::new().read(true).write(true).create_new(true).open(name);
    tempfile::Builder::new().prefix(PREFIX).suffix(SUFFIX).make_in(folder, create)
}

/// Links an unnamed file to a temporary name.
fn name(mut file: File, folder: &Path) -> io::Result<TempPath> {
    let linked =
        tempfile::Builder::new().prefix(PREFIX).suffix(SUFFIX).make_in(folder, |name| unnamed::link(&file, name));
    if let Ok(linked) = linked {
        return Ok(linked.into_temp_path());
    }
    // Some file systems support unnamed files but cannot link them.
    let mut copy = create(folder)?;
    file.rewind()?;
    io::copy(&mut file, copy.as_file_mut())?;
    copy.as_file().sync_all()?;
    Ok(copy.into_temp_path())
}

/// Unnamed files, of which a kill leaves no trace.
#[cfg(target_os = "linux")]
mod unnamed {
    use rustix::fs::{AtFlags, CWD, Mode, OFlags, linkat, open};
    use std::fs::File;
    use std::io;
    use std::os::fd::AsRawFd;
    use std::path::Path;

    /// Creates an unnamed file in `folder`; `None` if its file system does not support this.
    pub(super) fn create(folder: &Path) -> Option<File> {
        let mode = Mode::from_raw_mode(0o666);
        open(folder, OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC, mode).ok().map(File::from)
    }

    /// Links the file to `name`.
    pub(super) fn link(file: &File, name: &Path) -> io::Result<()> {
        Ok(linkat(CWD, format!("/proc/self/fd/{}", file.as_raw_fd()), CWD, name, AtFlags::SYMLINK_FOLLOW)?)
    }
}

/// Other systems have no unnamed files.
#[cfg(not(target_os = "linux"))]
mod unnamed {
    use std::fs::File;
    use std::io;
    use std::path::Path;

    pub(super) fn create(_folder: &Path) -> Option<File> {
        None
    }

    pub(super) fn link(_file: &File, _name: &Path) -> io::Result<()> {
        Err(io::ErrorKind::Unsupported.into())
    }
}

#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    match File::open(folder)?.sync_all() {
        // Some network file systems cannot sync a folder. The rename is then as durable as possible.
        Err(e) if matches!(e.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => Ok(()),
        synced => synced,
    }
}

#[cfg(not(unix))]
fn sync_folder(_folder: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::io::Write;

    #[test]
    fn replaces_whole_files_and_leaves_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        write_atomically(&path, |f| f.write_all(b"old")).unwrap();
        let failed = write_atomically(&path, |f| f.write_all(b"ne").and(Err(io::Error::other("disk on fire"))));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        let error = failed.unwrap_err();
        assert_eq!(error.kind, Kind::Output);
        assert!(error.chain().contains("a.bin") && error.chain().contains("disk on fire"), "{}", error.chain());
        write_atomically(&path, |f| f.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn error_names_the_unwritable_path() {
        let missing = write_atomically(Path::new("no/such/folder/a.bin"), |_| Ok(())).unwrap_err();
        assert!(
            missing.kind == Kind::Output && missing.chain().contains("no/such/folder/a.bin"),
            "{}",
            missing.chain()
        );
        assert_eq!(write_atomically(Path::new("/"), |_| Ok(())).unwrap_err().kind, Kind::Output);
    }

    /// During writing the folder contains nothing that a kill could leave behind; without unnamed files, one temporary
    /// name.
    #[test]
    fn file_has_no_name_until_it_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        let count = || fs::read_dir(folder.path()).unwrap().count();
        let expected = usize::from(unnamed::create(folder.path()).is_none());
        write_atomically(&path, |f| f.write_all(b"new").map(|()| assert_eq!(count(), expected))).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }

    /// A removed file cannot be linked again.
    #[test]
    fn unlinkable_temporary_file_is_copied() {
        let folder = tempfile::tempdir().unwrap();
        let mut removed = create(folder.path()).unwrap();
        removed.write_all(b"all of it").unwrap();
        let named = name(removed.into_file(), folder.path()).unwrap();
        assert_eq!(fs::read(&named).unwrap(), b"all of it");
    }

    #[cfg(unix)]
    #[test]
    fn symlinks_are_kept_and_their_targets_written() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("store")).unwrap();
        fs::write(at("store/old"), "old").unwrap();
        // Relative and through another link; to a missing file; in a cycle.
        symlink("store/old", at("inner")).unwrap();
        symlink("inner", at("outer")).unwrap();
        symlink(at("store/new"), at("dangling")).unwrap();
        symlink("circle", at("circle")).unwrap();
        for (link, file) in [("outer", "store/old"), ("dangling", "store/new")] {
            write_atomically(&at(link), |f| f.write_all(b"written")).unwrap();
            assert!(
                fs::symlink_metadata(at(link)).unwrap().is_symlink()
                    && !fs::symlink_metadata(at(file)).unwrap().is_symlink()
            );
            assert_eq!(fs::read(at(file)).unwrap(), b"written");
        }
        let circle = write_atomically(&at("circle"), |_| Ok(())).unwrap_err();
        assert!(circle.kind == Kind::Output && circle.chain().contains("too many levels"), "{}", circle.chain());
    }

    #[cfg(unix)]
    #[test]
    fn file_mode_follows_the_umask() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, ordinary) = (folder.path().join("a"), folder.path().join("b"));
        write_atomically(&ours, |_| Ok(())).unwrap();
        fs::write(&ordinary, "").unwrap();
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&ordinary));
    }
}
