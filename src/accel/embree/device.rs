//! An Embree device: library state, threads and memory.

use super::error;
use crate::accel::Packet;
use crate::error::{Error, Kind, Result};
use embree4_sys::{
    RTC_VERSION, RTCDevice, RTCDeviceProperty, rtcGetDeviceProperty, rtcNewDevice, rtcReleaseDevice,
    rtcSetDeviceMemoryMonitorFunction,
};
use std::ffi::{CString, c_void};
use std::sync::Arc;
use std::sync::atomic::{AtomicIsize, Ordering};

/// An Embree device. All objects created from it hold a reference to it.
pub struct Device {
    raw: RTCDevice,
    /// Shared with the memory monitor, so that its address is fixed for the lifetime of the device.
    bytes: Arc<AtomicIsize>,
}

// SAFETY: Embree's manual allows calls on one device from any thread; errors are kept per thread, references are
// atomic.
unsafe impl Send for Device {}
// SAFETY: as above; the only other state is an atomic counter.
unsafe impl Sync for Device {}

impl Device {
    /// Creates a device that builds with `threads` threads (0: all available).
    ///
    /// # Errors
    /// Internal errors: the processor is not supported, or the library does not match the bindings.
    pub fn new(threads: usize) -> Result<Self> {
        let config = CString::new(format!("threads={threads}"))
            .map_err(|e| Error::new(Kind::Internal, "Embree's configuration is not a C string").because(e))?;
        // SAFETY: the configuration is a C string that outlives the call.
        let raw = unsafe { rtcNewDevice(config.as_ptr()) };
        if raw.is_null() {
            // SAFETY: null is what Embree asks for when no device could be made.
            unsafe { error::check(raw, "start Embree") }?;
            return Err(Error::new(Kind::Internal, "cannot start Embree: it gives no reason"));
        }
        let device = Device { raw, bytes: Arc::default() };
        // SAFETY: the device is live; its last use of the counter is in `Drop`, before the counter's own.
        unsafe {
            rtcSetDeviceMemoryMonitorFunction(raw, Some(count_bytes), Arc::as_ptr(&device.bytes).cast_mut().cast())
        };
        device.check("watch Embree's memory")?;
        device.check_library()?;
        Ok(device)
    }

    pub(super) fn raw(&self) -> RTCDevice {
        self.raw
    }

    /// Returns the calling thread's error since the last check, if any.
    pub(super) fn check(&self, what: &str) -> Result<()> {
        // SAFETY: the device lives as long as `self`.
        unsafe { error::check(self.raw, what) }
    }

    /// Returns the memory allocated by Embree in bytes.
    pub fn bytes(&self) -> usize {
        self.bytes.load(Ordering::Relaxed).max(0).unsigned_abs()
    }

    /// Returns the version of the library at run time.
    pub fn version(&self) -> String {
        let version = self.property(RTCDeviceProperty::RTC_DEVICE_PROPERTY_VERSION);
        format!("{}.{}.{}", version / 10000, version / 100 % 100, version % 100)
    }

    /// Returns the widths of packets for which the processor has registers, the widest last.
    pub fn packets(&self) -> &'static [Packet] {
        if self.property(RTCDeviceProperty::RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0 {
            &[Packet::Eight, Packet::Sixteen]
        } else if self.property(RTCDeviceProperty::RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0 {
            &[Packet::Eight]
        } else {
            &[]
        }
    }

    fn property(&self, property: RTCDeviceProperty) -> isize {
        // SAFETY: the device lives as long as `self`; an unknown property sets an error code and returns 0.
        unsafe { rtcGetDeviceProperty(self.raw, property) }
    }

    /// Checks build options of the library that the bindings and this backend rely on. The layout of rays and hits is
    /// fixed by the version of the headers, which the bindings assert.
    fn check_library(&self) -> Result<()> {
        let headers = RTC_VERSION as isize;
        let version = self.property(RTCDeviceProperty::RTC_DEVICE_PROPERTY_VERSION);
        let features = [
            (RTCDeviceProperty::RTC_DEVICE_PROPERTY_TRIANGLE_GEOMETRY_SUPPORTED, 1, "without triangles"),
            (RTCDeviceProperty::RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED, 1, "without filter functions"),
            (RTCDeviceProperty::RTC_DEVICE_PROPERTY_BACKFACE_CULLING_ENABLED, 0, "with backface culling"),
        ];
        let wrong = features.into_iter().find(|&(property, wanted, _)| self.property(property) != wanted);
        self.check("query Embree's properties")?;
        let built = self.version();
        match wrong {
            _ if version < headers || version / 10000 != headers / 10000 => Err(Error::new(
                Kind::Internal,
                format!(
                    "the loader found Embree {built}, but this program was built for {RTC_VERSION}: build it again"
                ),
            )),
            Some((_, _, what)) => {
                Err(Error::new(Kind::Internal, format!("the loader found an Embree {built} built {what}")))
            }
            None => Ok(()),
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: this is the reference that `new` got, and it is released once.
        unsafe { rtcReleaseDevice(self.raw) };
    }
}

/// Memory monitor. Embree calls it around its allocations (positive) and deallocations (negative), from any thread.
unsafe extern "C" fn count_bytes(counter: *mut c_void, bytes: isize, _post: bool) -> bool {
    // SAFETY: `Device::new` registered the address of a counter that lives as long as the device.
    let counter = unsafe { &*counter.cast::<AtomicIsize>() };
    counter.fetch_add(bytes, Ordering::Relaxed);
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use embree4_sys::rtcNewGeometry;

    #[test]
    fn the_library_is_at_least_of_the_headers_version() {
        let device = Device::new(1).expect("Embree starts");
        assert!(device.property(RTCDeviceProperty::RTC_DEVICE_PROPERTY_VERSION) >= 40300);
        assert_eq!(device.version().split('.').count(), 3);
    }

    #[test]
    fn an_error_is_reported_once_with_what_was_tried() {
        let device = Device::new(1).expect("Embree starts");
        // SAFETY: the device is live; an unknown geometry type is an error code and a null handle.
        let geometry = unsafe { rtcNewGeometry(device.raw(), embree4_sys::RTCGeometryType(9999)) };
        assert!(geometry.is_null());
        let error = device.check("make a geometry").expect_err("the type does not exist");
        assert_eq!(error.kind, Kind::Internal);
        assert!(error.to_string().starts_with("cannot make a geometry: Embree reports "), "{error}");
        device.check("go on").expect("reading an error clears it");
    }
}
