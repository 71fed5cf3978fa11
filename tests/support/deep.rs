//! Everyday tests and the long versions.

/// Whether the long versions run: `ETENDUE_TEST_DEEP=1`.
pub(crate) fn deep() -> bool {
    std::env::var_os("ETENDUE_TEST_DEEP").is_some_and(|v| v != "0")
}
