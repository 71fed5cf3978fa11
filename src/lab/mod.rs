//! Measurements of the renderer itself: comparison of images and methods, benchmarks of methods and of ray queries,
//! hard cases for intersection, images by technique, error metrics of images, and the HTML pages that show the results.
//! Rendering needs none of it.

pub mod bench_diffusion;
pub mod bench_methods;
pub mod bench_rays;
pub mod compare;
mod conditions;
pub mod equivalence;
pub mod hard_cases;
pub mod html;
pub mod image;
mod report_files;
pub mod same_mean;
pub mod techniques;
pub mod verify;

pub use conditions::Conditions;

/// Returns the distinct `items` in order.
pub(crate) fn unique<T: Copy + PartialEq>(items: &[T]) -> Vec<T> {
    let mut unique: Vec<T> = Vec::new();
    items.iter().for_each(|&item| {
        if !unique.contains(&item) {
            unique.push(item);
        }
    });
    unique
}
