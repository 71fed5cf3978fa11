//! Running the binary in a folder of its own.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

/// Whether this is the copy of the repository that tests/kill_matrix makes, whose binary has mutations.
pub(crate) fn is_mutable() -> bool {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src/mutant.rs").exists()
}

/// A folder that goes away, and the binary in it.
pub(crate) struct Place(tempfile::TempDir);

impl Place {
    pub(crate) fn new() -> Self {
        Place(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_etendue"));
        command.current_dir(self.0.path()).args(line.split_whitespace());
        command.env_remove("SLURM_CPUS_PER_TASK").env_remove("CUE_THREADS");
        command
    }

    pub(crate) fn run(&self, line: &str) -> Ran {
        Ran(self.command(line).output().unwrap())
    }

    /// Runs with a mutation on, in the copy that tests/kill_matrix makes.
    pub(crate) fn run_mutant(&self, name: &str, line: &str) -> Ran {
        Ran(self.command(line).env("ETENDUE_MUTANT", name).output().unwrap())
    }

    pub(crate) fn start(&self, line: &str) -> Child {
        self.command(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// Runs, demands success, and returns the report.
    pub(crate) fn report(&self, line: &str) -> serde_json::Value {
        let ran = self.run(&format!("{line} --json"));
        assert_eq!(ran.code(), 0, "{}", ran.stderr());
        serde_json::from_str(&ran.stdout()).unwrap()
    }

    /// The hash of the pixels that a command line gives.
    pub(crate) fn pixels(&self, line: &str) -> String {
        self.report(line)["pixel_hash"].as_str().unwrap().to_owned()
    }
}

/// What came of a run.
pub(crate) struct Ran(pub(crate) Output);

impl Ran {
    pub(crate) fn code(&self) -> i32 {
        self.0.status.code().unwrap()
    }

    pub(crate) fn stdout(&self) -> String {
        String::from_utf8(self.0.stdout.clone()).unwrap()
    }

    pub(crate) fn stderr(&self) -> String {
        String::from_utf8(self.0.stderr.clone()).unwrap()
    }

    /// Demands this exit code and an error that says `what` in one line.
    pub(crate) fn fails(&self, code: i32, what: &str) {
        assert_eq!(self.code(), code, "{}", self.stderr());
        let stderr = self.stderr();
        let error = stderr.lines().find(|l| l.starts_with("etendue: error: ")).expect("an error line");
        assert!(error.contains(what), "{error}");
    }
}

/// The Cornell box's file.
pub(crate) fn cornell_file() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box/scene.gltf").display().to_string()
}

/// The Cornell box, small enough for a test.
pub(crate) fn cornell() -> String {
    format!("{} --size 32x32", cornell_file())
}
