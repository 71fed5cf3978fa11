//! One error for the whole program. Its kind is the exit class, its text one clear sentence with path and cause.

use std::path::Path;

/// What went wrong, by what the caller (a person, a script, a farm) should do about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A defect of étendue itself: exit code 1.
    Internal,
    /// The command line or a configuration file is wrong: exit code 2.
    Usage,
    /// The scene or one of its assets is invalid; trying again will not help: exit code 3.
    Scene,
    /// An output cannot be written; trying again may help: exit code 4.
    Output,
    /// The error target was not reached and `--require-target` was given: exit code 5.
    TargetMissed,
    /// Samples were not finite and `--fail-on-nonfinite` was given: exit code 6.
    NonFinite,
    /// Images that were compared, or methods that should agree, differ beyond their errors: exit code 7.
    Differ,
    /// The memory budget does not suffice: exit code 33.
    Memory,
    /// Stopped by a signal; running again resumes from the film, if there was one to save: exit code 75.
    Interrupted,
}

impl Kind {
    /// The process exit code of this class.
    pub fn exit_code(self) -> u8 {
        match self {
            Kind::Internal => 1,
            Kind::Usage => 2,
            Kind::Scene => 3,
            Kind::Output => 4,
            Kind::TargetMissed => 5,
            Kind::NonFinite => 6,
            Kind::Differ => 7,
            Kind::Memory => 33,
            Kind::Interrupted => 75,
        }
    }
}

/// An error with its exit class and a sentence for the user; the cause, if any, is the standard `source`.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct Error {
    /// The exit class.
    pub kind: Kind,
    message: String,
    source: Option<Box<dyn std::error::Error + Send + Sync>>,
}

/// `Result` with [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// An error of `kind` told by `message`.
    pub fn new(kind: Kind, message: impl Into<String>) -> Self {
        Error { kind, message: message.into(), source: None }
    }

    /// An invalid scene or asset (exit code 3).
    pub fn scene(message: impl Into<String>) -> Self {
        Error::new(Kind::Scene, message)
    }

    /// A wrong command line or configuration (exit code 2).
    pub fn usage(message: impl Into<String>) -> Self {
        Error::new(Kind::Usage, message)
    }

    /// An input file that cannot be read (exit code 3).
    pub fn read(path: &Path, cause: impl std::error::Error + Send + Sync + 'static) -> Self {
        Error::new(Kind::Scene, format!("cannot read {}", path.display())).because(cause)
    }

    /// An output file that cannot be written (exit code 4).
    pub fn write(path: &Path, cause: impl std::error::Error + Send + Sync + 'static) -> Self {
        Error::new(Kind::Output, format!("cannot write {}", path.display())).because(cause)
    }

    /// The same error with its cause.
    pub fn because(mut self, cause: impl std::error::Error + Send + Sync + 'static) -> Self {
        self.source = Some(Box::new(cause));
        self
    }

    /// The same error, its sentence preceded by `what`: "what: sentence".
    pub fn context(mut self, what: impl std::fmt::Display) -> Self {
        self.message = format!("{what}: {}", self.message);
        self
    }

    /// The sentence and its chain of causes on one line: names from files may hold line breaks and terminal codes, which
    /// become spaces.
    pub fn chain(&self) -> String {
        let mut line = self.message.clone();
        let mut cause = std::error::Error::source(self);
        while let Some(c) = cause {
            line.push_str(&format!(": {c}"));
            cause = c.source();
        }
        line.replace(char::is_control, " ")
    }
}
