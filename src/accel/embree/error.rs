//! Conversion of Embree's error codes. Codes are kept per thread and device until read. They are read after each set-up
//! call, and never after a query, which sets none.

use crate::error::{Error, Kind, Result};
use embree4_sys::{RTCDevice, RTCError, rtcGetDeviceError};

/// Takes the calling thread's error of `device`; a null device gives the cause of a failed device creation.
///
/// # Safety
/// `device` is null or a live device.
pub(super) unsafe fn check(device: RTCDevice, what: &str) -> Result<()> {
    // SAFETY: the caller's promise is the one that Embree asks for.
    match unsafe { rtcGetDeviceError(device) } {
        RTCError::RTC_ERROR_NONE => Ok(()),
        code => Err(of(code, what)),
    }
}

/// Returns the error for `code`: "cannot `what`: Embree reports …".
pub(super) fn of(code: RTCError, what: &str) -> Error {
    let (kind, cause) = match code {
        RTCError::RTC_ERROR_OUT_OF_MEMORY => (Kind::Memory, "too little memory".into()),
        RTCError::RTC_ERROR_UNSUPPORTED_CPU => (Kind::Internal, "a processor without the instructions it needs".into()),
        RTCError::RTC_ERROR_INVALID_ARGUMENT => (Kind::Internal, "an invalid argument".into()),
        RTCError::RTC_ERROR_INVALID_OPERATION => (Kind::Internal, "an invalid operation".into()),
        RTCError::RTC_ERROR_CANCELLED => (Kind::Internal, "a cancelled operation".into()),
        RTCError(code) => (Kind::Internal, format!("error {code}")),
    };
    Error::new(kind, format!("cannot {what}: Embree reports {cause}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lack_of_memory_has_its_own_exit_class() {
        let error = of(RTCError::RTC_ERROR_OUT_OF_MEMORY, "build");
        assert_eq!(
            (error.kind, error.to_string().as_str()),
            (Kind::Memory, "cannot build: Embree reports too little memory")
        );
    }

    #[test]
    fn a_code_of_a_later_version_is_named_by_its_number() {
        let error = of(RTCError(99), "build");
        assert_eq!((error.kind, error.to_string().as_str()), (Kind::Internal, "cannot build: Embree reports error 99"));
    }
}
