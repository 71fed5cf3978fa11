//! The choice of the acceleration backend.

use crate::run::{Place, cornell};

#[test]
fn obvhs_renders_the_same_pixels_on_any_number_of_threads() {
    let place = Place::new();
    let line = |threads| format!("render {} --backend obvhs --spp 8 --threads {threads} -o x.exr", cornell());
    assert_eq!(place.pixels(&line(1)), place.pixels(&line(5)));
}

#[cfg(feature = "embree")]
#[test]
fn films_of_different_backends_do_not_mix() {
    let place = Place::new();
    for (shard, backend) in [(0, "embree"), (1, "obvhs")] {
        place.report(&format!("render {} --spp 8 --backend {backend} --shard {shard}/2 -o {shard}.film", cornell()));
    }
    place.run("merge 0.film 1.film -o x.exr").fails(2, "backend");
}

#[cfg(not(feature = "embree"))]
#[test]
fn a_backend_that_is_not_there_is_an_error_of_usage() {
    Place::new().run(&format!("render {} --backend embree -o x.exr", cornell())).fails(2, "--backend obvhs");
}
