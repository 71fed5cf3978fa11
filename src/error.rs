//! One error for the whole program. Its kind is the exit class, its text one clear sentence with path and cause.

use std::path::Path;

/// Error class, by the action expected from the caller (a person, a script, a render farm).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Internal defect of étendue: exit code 1.
    Internal,
    /// Invalid command line or configuration file: exit code 2.
    Usage,
    /// Invalid scene or asset; a retry will not help: exit code 3.
    Scene,
    /// Output that cannot be written; a retry may help: exit code 4.
    Output,
    /// Error target not reached while `--require-target` was given: exit code 5.
    TargetMissed,
    /// Non-finite samples while `--fail-on-nonfinite` was given: exit code 6.
    NonFinite,
    /// Compared images, or methods that should agree, differ by more than their errors: exit code 7.
    Differ,
    /// Insufficient memory budget: exit code 33.
    Memory,
    /// Stopped by a signal; a new run resumes from the saved film, if there is one: exit code 75.
    Interrupted,
}

impl Kind {
    /// Returns the process exit code of this class.
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

/// An error with its exit class and a message for the user. The cause, if any, is the standard `source`.
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
    /// Returns an error of class `kind` with the given `message`.
    pub fn new(kind: Kind, message: impl Into<String>) -> Self {
        Error { kind, message: message.into(), source: None }
    }

    /// Returns an error for an invalid scene or asset (exit code 3).
    pub fn scene(message: impl Into<String>) -> Self {
        Error::new(Kind::Scene, message)
    }

    /// Returns an error for an invalid command line or configuration (exit code 2).
    pub fn usage(message: impl Into<String>) -> Self {
        Error::new(Kind::Usage, message)
    }

    /// Returns an error for an input file that cannot be read (exit code 3).
    pub fn read(path: &Path, cause: impl std::error::Error + Send + Sync + 'static) -> Self {
        Error::new(Kind::Scene, format!("cannot read {}", path.display())).because(cause)
    }

    /// Returns an error for an output file that cannot be written (exit code 4).
    pub fn write(path: &Path, cause: impl std::error::Error + Send + Sync + 'static) -> Self {
        Error::new(Kind::Output, format!("cannot write {}", path.display())).because(cause)
    }

    /// Attaches the cause.
    pub fn because(mut self, cause: impl std::error::Error + Send + Sync + 'static) -> Self {
        self.source = Some(Box::new(cause));
        self
    }

    /// Prefixes the message with `what`: "what: message".
    pub fn context(mut self, what: impl std::fmt::Display) -> Self {
        self.message = format!("{what}: {}", self.message);
        self
    }

    /// Returns the message and its chain of causes on one line. Control characters become spaces, since names from
    /// files may contain line breaks and terminal codes.
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
