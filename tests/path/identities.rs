//! Identities that hold on every path, whichever technique made it.

use crate::made::{Made, Studio, evaluate};
use etendue::bsdf::{Bsdf, Lobes};
use etendue::camera::Camera;
use etendue::path::{FullPath, MisStrategy, PathVertex, Technique, Techniques};
use etendue::sampling::Heuristic;
use etendue::scene::Scene;
use etendue_testing::deep;
use etendue_testing::worlds::{World, all};
use glam::DVec3;
use std::cell::Cell;

const SIDE: u32 = 64;

/// What the fast weights may be off by on nearly every path.
const WEIGHT_ERROR: f64 = 1e-5;

/// Relative error of a product of densities or values along a path, in f32. A direction is a rounding or two off; GGX's
/// (z² + sin²/α²)⁻² multiplies that by 4 / α at most, a cosine by its inverse, and the difference of two points by the
/// inverse of their distance, in a scene of radius 1. At the critical angle, where 1 − F begins as a root, a rounding
/// becomes its own root.
fn product_error(made: &Made, world: &World) -> f64 {
    let alpha = world.alpha;
    let epsilon = f64::from(f32::EPSILON);
    let cosines: f64 = cosines(made, made.path.directions()).map(f64::recip).sum();
    let nodes = made.nodes.windows(2);
    let shortest = nodes.map(|pair| f64::from(pair[0].p().distance(pair[1].p()))).fold(1.0, f64::min);
    let refracting = made.nodes.iter().filter(|n| has(n, Lobes::TRANSMIT.union(Lobes::DIRAC_TRANSMIT)));
    // What edges pass is met at points that are known within some sixteen roundings. What it lets through is a concave
    // function of the cosine that is not below 0 at 0, so that its relative change is at most that of the cosine. All
    // panes are level.
    let edges = (0..made.path.k()).map(|i| made.path.length(i)).fold(1.0, f64::min);
    let grazing = made.path.directions().iter().map(|w| w.y.abs()).fold(1.0, f64::min);
    let passed = if world.scene.features().content() { 16.0 * epsilon / edges / grazing } else { 0.0 };
    // The exponent of a transmittance is off by that of the length of its edge: some sixteen roundings of a place at either
    // end. A phase function changes by 3 / (1 − |g|) times the change of a direction at most.
    let flown = 32.0 * epsilon * world.fog * (made.path.k() as f64 + 1.0 / edges);
    4.0 * epsilon * (made.nodes.len() as f64 * 4.0 / alpha + cosines + shortest.recip())
        + refracting.count() as f64 * epsilon.sqrt()
        + passed
        + flown
}

/// Whether a vertex lies on a surface with any of `lobes`.
fn has(node: &PathVertex, lobes: Lobes) -> bool {
    node.vertex.surface().is_some_and(|at| at.surface.lobes().intersects(lobes))
}

fn weights(techniques: Techniques, heuristic: Heuristic) -> MisStrategy {
    MisStrategy { techniques, heuristic, light_walks: f64::from(SIDE * SIDE) }
}

/// All sets of techniques that a scene may be rendered with, and both heuristics.
fn all_weights() -> Vec<MisStrategy> {
    let sets: [&[Technique]; 6] = [
        &[],
        &[Technique::Splat],
        &[Technique::Connect],
        &[Technique::Hit],
        &[Technique::NextEvent, Technique::Splat],
        &[Technique::Connect, Technique::NextEvent],
    ];
    let of = |set: &&[Technique]| [Heuristic::Balance, Heuristic::Power].map(|h| weights(Techniques::without(set), h));
    sets.iter().flat_map(of).collect()
}

/// Runs `check` on paths of every world and of all weights.
fn each_path(walks: u64, check: impl Fn(&World, &Camera, &MisStrategy, &Made)) {
    let walks = if deep() { 50 * walks } else { walks };
    for world in all() {
        let camera = world.scene.camera(None, SIDE, SIDE).expect("a camera");
        let mut paths = 0u64;
        for (seed, weights) in (0..).zip(all_weights()) {
            let studio = Studio { scene: &world.scene, camera: &camera, weights, side: SIDE };
            for index in 0..walks {
                for made in studio.sample(1000 * walks * seed + index) {
                    if weights.techniques.has(made.s, made.t) {
                        paths += 1;
                        check(&world, &camera, &weights, &made);
                    }
                }
            }
        }
        println!("{}: {paths} paths", world.name);
        assert!(paths > 4 * walks, "{}: {paths} paths only", world.name);
    }
}

#[test]
fn mis_weights_sum_to_one_and_recursion_matches_definition() {
    let (worst, count, beyond) = (Cell::new(0.0f64), Cell::new(0u64), Cell::new(0u64));
    each_path(200, |world, _, weights, made| {
        let (_, densities) = evaluate(&world.scene, &made.path, weights);
        let sum: f64 = (0..=made.path.k()).map(|s| densities.weight(weights, s)).sum();
        // a dozen terms in f64
        assert!((sum - 1.0).abs() < 1e-10, "{} ({}, {}): weights sum to {sum}", world.name, made.s, made.t);
        let defined = densities.weight(weights, made.s);
        let off = (made.weight - defined).abs();
        worst.set(worst.get().max(off));
        count.set(count.get() + 1);
        beyond.set(beyond.get() + u64::from(off > WEIGHT_ERROR));
        // A weight changes by a quarter of the relative change of the ratio, which the power heuristic squares.
        assert!(
            off < product_error(made, world),
            "{} ({}, {}) {weights:?}: {} fast, {defined} by definition; {:?}",
            world.name,
            made.s,
            made.t,
            made.weight,
            densities
        );
    });
    let (count, beyond) = (count.get(), beyond.get());
    println!("errors of weights: {:.1e} at most, {beyond} of {count} above {WEIGHT_ERROR:e}", worst.get());
    assert!(
        beyond as f64 <= 1e-3 * count as f64,
        "{beyond} of {count} paths have weights off by more than {WEIGHT_ERROR:e}"
    );
}

/// f(x̄) / p_{s,t} is what the technique found: so f does not depend on which it was, and the walk's densities are the
/// evaluator's. What rough glass lets through at its critical angle comes out of nothing with a relative error without
/// bound: such paths are counted.
#[test]
fn technique_contribution_is_integrand_over_density() {
    let (worst, count, critical) = (Cell::new(0.0f64), Cell::new(0u64), Cell::new(0u64));
    each_path(200, |world, _, weights, made| {
        let off = value_off(&world.scene, weights, made);
        let is_rough_glass = made.nodes.iter().any(|n| has(n, Lobes::TRANSMIT));
        count.set(count.get() + 1);
        if off < product_error(made, world) {
            worst.set(worst.get().max(off));
        } else if is_rough_glass {
            critical.set(critical.get() + 1);
        } else {
            panic!("{} ({}, {}): {:?} found, off by {off:e}", world.name, made.s, made.t, made.value);
        }
    });
    let (count, critical) = (count.get(), critical.get());
    println!("errors of values: {:.1e} at most but for {critical} of {count}", worst.get());
    assert!(critical as f64 <= 1e-3 * count as f64, "{critical} of {count} paths are off");
}

/// The largest relative error over the lanes.
fn value_off(scene: &Scene, weights: &MisStrategy, made: &Made) -> f64 {
    let (f, densities) = evaluate(scene, &made.path, weights);
    let log = densities.log[made.s].unwrap_or_else(|| panic!("({}, {}) cannot be", made.s, made.t));
    // A splat is found per walk; the density counts all walks.
    let walks = if made.t == 1 { weights.light_walks } else { 1.0 };
    let lane_off = |lane: usize| {
        let (found, want) = (f64::from(made.value.0[lane]), f.0[lane] * walks * (-log).exp());
        if want.abs() < f64::from(f32::MIN_POSITIVE) { 0.0 } else { (found - want).abs() / want.abs() }
    };
    (0..3).map(lane_off).fold(0.0, f64::max)
}

/// Directions that are derived again from positions give the same weights but for what a change of direction does: a
/// density changes by up to 4 / α times it over a cosine, and a weight by a quarter of that of each ratio for each
/// power of it.
#[test]
fn mis_weights_recomputed_from_positions_match() {
    let worst = Cell::new(0.0f64);
    each_path(50, |world, camera, weights, made| {
        if made.nodes.iter().any(|node| node.lobe.intersects(Lobes::DIRAC)) {
            return; // a direction from positions is not the component's
        }
        let kept = made.path.directions();
        let eye = *made.path.eye();
        let straight = FullPath::straight(&made.emitter, &made.nodes, &eye.eye, kept[0]);
        let turned = kept.iter().zip(&straight).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
        let grazing = cosines(made, &straight).fold(1.0, f64::min);
        let again = FullPath::new(&world.scene, camera, eye, made.emitter, made.nodes.clone(), straight);
        let [a, b] = [&made.path, &again].map(|path| evaluate(&world.scene, path, weights).1.weight(weights, made.s));
        let bound = 1e-10 + 8.0 * made.path.k() as f64 * turned * (1.0 / world.alpha + 1.0 / grazing + world.fog);
        worst.set(worst.get().max((a - b).abs()));
        assert!((a - b).abs() < bound, "{} ({}, {}): {a} and {b}, bound {bound:e}", world.name, made.s, made.t);
    });
    println!("largest change of a weight: {:.1e}", worst.get());
}

/// Cosines of both directions at every vertex, to either normal.
fn cosines<'a>(made: &'a Made, directions: &'a [DVec3]) -> impl Iterator<Item = f64> + 'a {
    let on_surfaces = made.nodes.iter().enumerate().filter_map(|(i, node)| Some((i, node.vertex.surface()?)));
    on_surfaces.flat_map(move |(i, at)| {
        let normals = [at.point.ng, at.point.frame.n];
        normals.into_iter().flat_map(move |n| [directions[i], directions[i + 1]].map(|w| w.dot(n.as_dvec3()).abs()))
    })
}

#[test]
fn path_vertices_lie_on_their_surfaces() {
    each_path(50, |world, _, _, made| {
        made.path.verify().unwrap_or_else(|e| panic!("{} ({}, {}): {e}", world.name, made.s, made.t));
    });
}
