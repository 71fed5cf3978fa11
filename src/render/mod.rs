//! (in work)

pub mod film_file;
