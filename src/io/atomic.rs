//! Whole files or none: every output goes through here, so a kill at any time leaves the old file whole.

use crate::error::{Error, Kind, Result};
use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;

/// Writes a file by `fill` under a temporary name in the same folder, syncs it, renames it to `path` and syncs the folder.
/// A symbolic link at `path` is replaced, not followed.
///
/// # Errors
/// [`Kind::Output`] with the path if a step fails; the temporary file is then removed and an old file at `path` untouched.
pub fn write_atomically(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> Result<()> {
    if path.file_name().is_none() {
        return Err(Error::new(Kind::Output, format!("cannot write {}: it names no file", path.display())));
    }
    replace(path, fill).map_err(|cause| Error::write(path, cause))
}

fn replace(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    // Given a mode, the umask applies as to any other new file; without one, temporary files are private.
    let create = |name: &Path| OpenOptions::new().read(true).write(true).create_new(true).open(name);
    let mut temporary = tempfile::Builder::new().prefix(".etendue-").suffix(".tmp").make_in(folder, create)?;
    fill(temporary.as_file_mut())?;
    temporary.as_file().sync_all()?;
    temporary.persist(path)?;
    sync_folder(folder)
}

#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    match File::open(folder)?.sync_all() {
        // Some network file systems cannot sync a folder; the rename is then as durable as it gets.
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
    fn says_where_it_cannot_write() {
        let missing = write_atomically(Path::new("no/such/folder/a.bin"), |_| Ok(())).unwrap_err();
        assert!(missing.kind == Kind::Output && missing.chain().contains("no/such/folder/a.bin"), "{}", missing.chain());
        assert_eq!(write_atomically(Path::new("/"), |_| Ok(())).unwrap_err().kind, Kind::Output);
    }

    #[cfg(unix)]
    #[test]
    fn has_the_mode_of_an_ordinary_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, ordinary) = (folder.path().join("a"), folder.path().join("b"));
        write_atomically(&ours, |_| Ok(())).unwrap();
        fs::write(&ordinary, "").unwrap();
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&ordinary));
    }
}
