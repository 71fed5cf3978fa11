//! Rays that are difficult for ray tracers, by name: soups, closed bodies with rays at their seams, slivers, scales
//! from 1e-40 to 1e8, offsets, instances, invalid rays.
//!
//! A ray is addressed by its case and index, such as `sphere-edges:1234`, and is the same on every machine. Rays named
//! in a report can be traced again with [`by_name`] and [`HardCase::ray`]. [`categories`] runs all cases on several
//! backends; [`super::equivalence`] compares the answers.
//!
//! To add a case, write a row in the file of its theme: a name, whether each ray must hit, a geometry, and a function
//! that draws a ray. Limits: no motion blur and no filters. Geometries are small (under 40,000 triangles), so that a
//! reference can test all triangles; they do not exercise large trees.

mod bodies;
mod boxes;
mod numbers;
mod odd;
mod placements;
mod shapes;
mod soups;

pub use shapes::{Faces, sphere};

use crate::accel::{Accel, Backend, Build};
use crate::error::Result;
use crate::geometry::{Geometry, Hit, Ray};
use crate::lab::equivalence::{Category, DifferenceCounts};
use crate::named::Named;
use glam::Vec3;
use numbers::Numbers;
use rayon::prelude::*;
use std::ops::Range;

/// Largest number of rays in memory.
const MOST_HELD: u64 = 1 << 20;

/// Draws a ray from random numbers.
type Draw = Box<dyn Fn(&Geometry, &mut Numbers) -> Ray + Send + Sync>;

/// A geometry and a stream of rays that are difficult for it.
pub struct HardCase {
    name: &'static str,
    is_closed: bool,
    geometry: Geometry,
    draw: Draw,
}

impl HardCase {
    fn open(
        name: &'static str,
        geometry: Geometry,
        draw: impl Fn(&Geometry, &mut Numbers) -> Ray + Send + Sync + 'static,
    ) -> Self {
        HardCase { name, is_closed: false, geometry, draw: Box::new(draw) }
    }

    /// Returns a closed case; `draw` must start every ray inside a closed surface.
    fn closed(
        name: &'static str,
        geometry: Geometry,
        draw: impl Fn(&Geometry, &mut Numbers) -> Ray + Send + Sync + 'static,
    ) -> Self {
        HardCase { is_closed: true, ..HardCase::open(name, geometry, draw) }
    }

    /// Returns the name in tables and addresses.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Returns whether every ray starts inside a closed surface, so that a ray without a hit has leaked.
    pub fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// Returns the geometry of the rays.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Returns the ray at an address: a pure function of the case's name and `index`.
    pub fn ray(&self, index: u64) -> Ray {
        (self.draw)(&self.geometry, &mut Numbers::new(self.name, index))
    }

    /// Returns the rays of a range of indices, in order; 48 bytes each.
    pub fn rays(&self, range: Range<u64>) -> Vec<Ray> {
        range.into_par_iter().map(|index| self.ray(index)).collect()
    }

    /// Traces the first `rays` rays with the [`reference`] and each of `subjects`, built with `threads` threads (0: all
    /// available), and compares the answers with the reference. Returns one row for each, the reference first. Memory
    /// does not grow with `rays`. Call it from outside the rayon pool.
    ///
    /// # Errors
    /// As [`Accel::build`].
    pub fn measure(&self, subjects: &[(Backend, Build)], rays: u64, threads: usize) -> Result<Vec<Category>> {
        let build = |&(backend, build): &(Backend, Build)| Accel::build(&self.geometry, backend, build, threads);
        let others = subjects.iter().filter(|&&subject| subject != reference());
        let setups: Vec<_> = std::iter::once(reference()).chain(others.copied()).collect();
        let accels = setups.iter().map(build).collect::<Result<Vec<_>>>()?;
        let mut tallies = vec![DifferenceCounts::default(); accels.len()];
        for start in (0..rays).step_by(MOST_HELD as usize) {
            let asked = self.rays(start..rays.min(start + MOST_HELD));
            for (sum, accel) in tallies.iter_mut().zip(&accels) {
                let tally = DifferenceCounts::of(&self.geometry, &asked, accel, &accels[0], self.is_closed);
                *sum = std::mem::take(sum).plus(tally.moved(start));
            }
        }
        let row = |(setup, tally): (&(Backend, Build), DifferenceCounts)| Category {
            name: self.name.to_owned(),
            backend: title(*setup),
            reference: title(reference()),
            tally,
        };
        Ok(setups.iter().zip(tallies).map(row).collect())
    }
}

/// Returns the reference of comparisons: the robust build of the default backend.
pub fn reference() -> (Backend, Build) {
    (Backend::default(), Build::Robust)
}

/// Returns the label of a backend and its build in tables, such as `embree-fast`.
pub fn title((backend, build): (Backend, Build)) -> String {
    format!("{}-{}", backend.name(), build.name())
}

/// Returns all cases, in the order of reports.
pub fn all() -> Vec<HardCase> {
    [soups::cases(), bodies::cases(), bodies::scales(), boxes::cases(), placements::cases(), odd::cases()]
        .into_iter()
        .flatten()
        .collect()
}

/// Returns the case of the given name, if there is one.
pub fn by_name(name: &str) -> Option<HardCase> {
    all().into_iter().find(|case| case.name == name)
}

/// Returns a random triangle of `object`.
fn some_triangle(geometry: &Geometry, object: u32, numbers: &mut Numbers) -> Hit {
    let count = geometry.mesh_of(object).triangles().len();
    Hit { object, primitive: numbers.below(count) as u32 }
}

/// Returns a random triangle of any object.
fn any_triangle(geometry: &Geometry, numbers: &mut Numbers) -> Hit {
    let object = numbers.below(geometry.objects.len()) as u32;
    some_triangle(geometry, object, numbers)
}

/// Returns a point on an edge of `object`, up to rounding.
fn on_edge(geometry: &Geometry, object: u32, numbers: &mut Numbers) -> Vec3 {
    let [a, b, _] = geometry.triangle(some_triangle(geometry, object, numbers)).vertices;
    a + (b - a) * numbers.unit()
}

/// Returns a ray from `origin` to or through `target`.
fn aimed(origin: Vec3, target: Vec3) -> Ray {
    Ray::new(origin, target - origin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn names_are_distinct_and_an_address_is_one_ray() {
        let cases = all();
        let names: HashSet<_> = cases.iter().map(HardCase::name).collect();
        assert!(names.len() == cases.len() && cases.len() >= 26, "{} names of {} cases", names.len(), cases.len());
        let words = |ray: &Ray| [ray.origin, ray.direction].map(|v| v.to_array().map(f32::to_bits));
        for case in &cases {
            let rays = case.rays(10..14);
            let again = by_name(case.name()).expect("its name").rays(12..13);
            assert_eq!(words(&rays[2]), words(&again[0]), "{}", case.name());
            assert_ne!(words(&rays[2]), words(&rays[3]), "{}", case.name());
        }
    }

    #[test]
    fn rows_count_every_ray_and_the_reference_is_compared_with_itself() {
        let subject = (Backend::Obvhs, Build::Robust);
        let case = by_name("sphere-edges").expect("a case");
        let rows = case.measure(&[subject], 3000, 1).expect("builds");
        assert_eq!(rows[0].backend, title(reference()));
        for row in &rows {
            assert_eq!((row.tally.rays, row.tally.hits, row.tally.leaks), (3000, 3000, 0), "{row:?}");
        }
        assert_eq!((rows[0].tally.ties, rows[0].tally.grazes, rows[0].tally.true_differences), (0, 0, 0));
    }
}
