//! TEMP
/// TEMP
#[derive(Debug, Clone)]
pub struct Camera;
