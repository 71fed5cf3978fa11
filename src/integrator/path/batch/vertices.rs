//! The vertices of one bounce: what each path of a batch meets, the light that it gets there, and where it goes on.
//!
//! Kernels work on groups of lanes. They leave to the code of single paths, lane by lane, what has no kernel: surfaces
//! of other models, culled backs, and directions that rounding moves to the wrong side of a surface.

use super::lane_sets::LaneSets;
use super::lights::LightSamples;
use super::paths::{Paths, Rare, Shadows};
use super::points::{Group, Points, in_lanes};
use super::surfaces::{SurfaceFinder, VaryingSurfaces};
use super::{Batch, BatchedPath};
use crate::bsdf::Shares;
use crate::bsdf::lanes::{LaneConductor, LaneLambert, LaneMetalDielectric, LanePoint, LaneSample, LaneScatter};
use crate::geometry::lanes::offset;
use crate::geometry::{Hit, Hits, SurfacePoint};
use crate::integrator::path::CERTAIN;
use crate::integrator::samples::PassNumbers;
use crate::light::Receivers;
use crate::path::{LONGEST, ROULETTE_FROM, TraceStats, survival_probability};
use crate::sampling::{Sampler, Slot, power};
use crate::scene::Edge;
use crate::spectrum::Spectrum;
use crate::transport::ScatteringOutline;
use etendue_lanes::{Float, Int, Long, MOST_LANES, Mask, ROW, Vec3, for_each_bit};

impl<F: Float> BatchedPath<'_, F> {
    /// Takes the paths of `batch`, whose hits are found, to their next edges, and collects shadow rays. Adds emission
    /// and the environment to the pixels.
    pub(super) fn vertices(&self, batch: &mut Batch, depth: u32, numbers: impl PassNumbers, tally: &mut TraceStats) {
        let Batch { paths, next, shadows, hits, colors, varying, .. } = batch;
        next.rays.set_len(0);
        shadows.rays.set_len(0);
        let mut stage = Stage { all: self, paths, next, shadows, hits, colors, varying, depth, tally };
        for at in (0..paths.len()).step_by(F::LANES) {
            stage.group(at, numbers);
        }
    }
}

/// One bounce of a batch.
struct Stage<'s, 'a, F: Float> {
    all: &'s BatchedPath<'a, F>,
    paths: &'s Paths,
    next: &'s mut Paths,
    shadows: &'s mut Shadows,
    hits: &'s Hits,
    colors: &'s mut [Spectrum],
    varying: &'s mut VaryingSurfaces,
    /// Number of scattering events before this vertex.
    depth: u32,
    tally: &'s mut TraceStats,
}

impl<F: Float> Stage<'_, '_, F> {
    fn group(&mut self, at: usize, numbers: impl PassNumbers) {
        let live = F::first(self.paths.len() - at);
        let missed = F::Int::load(&self.hits.objects, at).equals(F::Int::splat(Hit::NONE.object));
        if (live & missed).any() {
            self.backgrounds(at, live & missed);
        }
        let mut lanes = LaneSets::new::<F>(&self.all.objects.flags, self.hits, at, live & !missed);
        if lanes.met != 0 {
            self.met(at, &mut lanes, numbers);
        }
        for_each_bit(lanes.single, |lane| self.single(at + lane, lanes.met >> lane & 1 == 1, numbers));
    }

    /// The lanes of a group with a kernel for the hit point. Lanes that kernels cannot finish are added to the single
    /// ones.
    #[inline(always)]
    fn met(&mut self, at: usize, lanes: &mut LaneSets, numbers: impl PassNumbers) {
        let group = Group {
            at,
            direction: Vec3::load(&self.paths.rays.direction, at),
            beta: Spectrum::load(&self.paths.beta, at),
            keys: F::Long::load(&self.paths.keys, at),
            pixels: F::Int::load(&self.paths.pixels, at),
        };
        let origin = Vec3::load(&self.paths.rays.origin, at);
        let points = Points::new(&self.all.objects.rows, self.hits, origin, &group, lanes.met);
        self.except(&group, &points, lanes);
        for_each_bit(lanes.lit, |lane| self.emission(at + lane, &points, lane));
        if self.depth >= self.all.tracer.max_depth {
            return;
        }
        let n = if lanes.bent | lanes.varying == 0 { points.ng } else { self.finder(at).resolve(&points, lanes) };
        if lanes.scattering() != 0 {
            self.scatter(&group, &points, n, lanes, numbers);
        }
    }

    /// Returns a finder of the varying surfaces of a group.
    fn finder(&mut self, at: usize) -> SurfaceFinder<'_, '_> {
        let Stage { all, paths, hits, varying, .. } = self;
        SurfaceFinder { scene: all.tracer.scene, rows: &all.objects.rows, paths, hits, found: varying, at }
    }

    /// Removes the lanes that cannot be finished by kernels or have no point.
    #[inline(always)]
    fn except(&mut self, group: &Group<F>, points: &Points<F>, lanes: &mut LaneSets) {
        let mut removed = lanes.met & !points.valid.bits();
        for_each_bit(removed, |lane| self.background(group.at + lane));
        if self.depth == 0 && lanes.may_be_culled != 0 {
            let back = group.direction.dot(points.ng).above(F::splat(0.0));
            let culled = lanes.may_be_culled & back.bits() & !removed;
            lanes.single |= culled;
            removed |= culled;
        }
        for_each_bit(lanes.met & points.outside.bits() & !removed, |lane| self.judge(group.at + lane));
        lanes.remove(removed);
    }

    /// Light sampling, and the next edge, in the lanes with a model.
    #[inline(always)]
    fn scatter(
        &mut self,
        group: &Group<F>,
        points: &Points<F>,
        n: Vec3<F>,
        lanes: &mut LaneSets,
        numbers: impl PassNumbers,
    ) {
        let point = LanePoint::new([n, points.ng], -group.direction);
        let with_model = F::Mask::from_bits(lanes.scattering());
        let scatters = with_model & point.scatters;
        let mut sampler = numbers.of_keys(group.keys);
        let lights = (self.all.tracer.scene.lights(), &self.all.lights);
        let u = sampler.u2(self.depth, Slot::LightPoint);
        let pick = || sampler.u1(self.depth, Slot::LightPick);
        let outlines = lights.0.is_by_receiver().then(|| self.outlines(group, &point, n, lanes));
        let receivers = Receivers { p: points.p, ng: points.ng, outlines: outlines.as_ref() };
        let choose = || lights.0.choose_lanes(&receivers, scatters, u, pick);
        let chosen = self.tally.selection.time_of(lights.0, choose);
        let light = LightSamples::new(lights, [points.p, points.ng], scatters, chosen);
        let lobe = if lanes.metal_dielectric != 0 { sampler.u1(self.depth, Slot::Lobe) } else { F::splat(0.0) };
        let [u, v] = sampler.u2(self.depth, Slot::Direction);
        let event = Event { group, point: &point, light: &light, u: [lobe, u, v], varying: lanes.varying };
        let outcome = self.outcome(&event, lanes);
        let doubtful = with_model & (point.doubtful | (scatters & outcome.doubtful));
        lanes.single |= doubtful.bits();
        let kept = scatters & !doubtful;
        self.shadow(group, points, &light, &outcome, kept);
        let alive = self.depart(group, points, &outcome.sample, kept & outcome.sample.valid, sampler);
        if let Some(outlines) = &outlines {
            self.keep_outlines(outlines, alive);
        }
    }

    /// Returns the outlines of scattering of a group with the shading normals `n`.
    #[inline(never)]
    fn outlines(
        &self,
        group: &Group<F>,
        point: &LanePoint<F>,
        n: Vec3<F>,
        lanes: &LaneSets,
    ) -> [ScatteringOutline; MOST_LANES] {
        let mut outlines = [ScatteringOutline::UNKNOWN; MOST_LANES];
        let mut add = |bits: u32, Shares { diffuse, glossy, alpha2 }: Shares<F>| {
            for_each_bit(bits, |lane| {
                outlines[lane] = ScatteringOutline {
                    n: n.lane(lane).into(),
                    wo: (-group.direction).lane(lane).into(),
                    diffuse: diffuse.lane(lane),
                    glossy: glossy.lane(lane),
                    alpha2: alpha2.lane(lane),
                    transmits: false,
                };
            });
        };
        let columns = |bits: u32| self.columns(group.at, bits, lanes.varying);
        if lanes.lambert != 0 {
            add(lanes.lambert, LaneLambert::new(columns(lanes.lambert), point).shares());
        }
        if lanes.conductor != 0 {
            add(lanes.conductor, LaneConductor::new(columns(lanes.conductor), point).shares());
        }
        if lanes.metal_dielectric != 0 {
            add(lanes.metal_dielectric, LaneMetalDielectric::new(columns(lanes.metal_dielectric), point).shares());
        }
        outlines
    }

    /// Appends the outlines of the `alive` lanes, which were the last to be appended to the next paths.
    fn keep_outlines(&mut self, outlines: &[ScatteringOutline; MOST_LANES], alive: F::Mask) {
        let next = &mut *self.next;
        let mut at = next.len() - alive.bits().count_ones() as usize;
        for_each_bit(alive.bits(), |lane| {
            next.outlines[at] = outlines[lane];
            at += 1;
        });
    }

    /// Returns the parameters of the surfaces in the given lanes of a group, as columns.
    #[inline(always)]
    fn columns(&self, at: usize, lanes: u32, varying: u32) -> [[F; ROW]; 3] {
        let parameters = in_lanes(lanes, |lane| {
            if varying >> lane & 1 == 1 {
                &self.varying.parameters[lane]
            } else {
                &self.all.objects.rows[self.hits.objects[at + lane] as usize].parameters
            }
        });
        [
            F::rows(|lane| &parameters[lane][0]),
            F::rows(|lane| &parameters[lane][1]),
            F::rows(|lane| &parameters[lane][2]),
        ]
    }

    /// Scattering by all models of a group.
    #[inline(always)]
    fn outcome(&self, event: &Event<F>, lanes: &LaneSets) -> Outcome<F> {
        let mut outcome = None;
        let mut add = |bits: u32, of: Outcome<F>| {
            let merged = outcome.map_or(of, |before: Outcome<F>| before.merged(F::Mask::from_bits(bits), of));
            outcome = Some(merged);
        };
        if lanes.lambert != 0 {
            add(lanes.lambert, self.model::<LaneLambert<F>>(event, lanes.lambert));
        }
        if lanes.conductor != 0 {
            add(lanes.conductor, self.model::<LaneConductor<F>>(event, lanes.conductor));
        }
        if lanes.metal_dielectric != 0 {
            add(lanes.metal_dielectric, self.model::<LaneMetalDielectric<F>>(event, lanes.metal_dielectric));
        }
        match outcome {
            Some(outcome) => outcome,
            None => unreachable!("a group is scattered only if a lane has a model"),
        }
    }

    /// Scattering by one model in the given lanes; the others get any values.
    #[inline(always)]
    fn model<M: LaneScatter<F>>(&self, event: &Event<F>, lanes: u32) -> Outcome<F> {
        let Event { group, point, light, u, varying } = *event;
        let model = M::new(self.columns(group.at, lanes, varying), point);
        let (scattering, sample) = (model.scattering(point, light.wi), model.sampled(point, u));
        let one = F::splat(1.0);
        let weight = F::select(light.dirac, one, power(light.density, scattering.pdf)) / light.density;
        Outcome {
            light: group.beta * scattering.f_cos * light.radiance * weight,
            lit: light.valid & scattering.valid,
            sample,
            doubtful: (light.valid & scattering.doubtful) | sample.doubtful,
        }
    }

    /// Collects the shadow rays of the `kept` lanes.
    #[inline(always)]
    fn shadow(
        &mut self,
        group: &Group<F>,
        points: &Points<F>,
        light: &LightSamples<F>,
        outcome: &Outcome<F>,
        kept: F::Mask,
    ) {
        let mask = kept & outcome.lit;
        let rays = light.rays(points.p, points.error, points.ng);
        let shadows = &mut *self.shadows;
        let at = shadows.rays.len();
        rays.origin.pack(mask, &mut shadows.rays.origin, at);
        rays.direction.pack(mask, &mut shadows.rays.direction, at);
        rays.t_max.pack(mask, &mut shadows.rays.t_max, at);
        outcome.light.pack(mask, &mut shadows.light, at);
        group.pixels.pack(mask, &mut shadows.pixels, at);
        shadows.rays.set_len(at + mask.bits().count_ones() as usize);
    }

    /// Sends the `kept` lanes on along the sampled directions, and returns those that roulette lets live.
    #[inline(always)]
    fn depart(
        &mut self,
        group: &Group<F>,
        points: &Points<F>,
        sample: &LaneSample<F>,
        kept: F::Mask,
        mut sampler: impl Sampler<F>,
    ) -> F::Mask {
        let mut beta = group.beta * sample.weight;
        let depth = self.depth + 1;
        let mut alive = kept;
        if depth >= LONGEST {
            self.tally.overlong += u64::from(kept.bits().count_ones());
            return F::first(0);
        }
        if depth < ROULETTE_FROM {
            alive = alive & beta.is_lit();
        } else {
            let q = survival_probability(beta, self.scales(group.at), depth);
            let risky = q.below(F::splat(1.0));
            if risky.any() {
                let u = sampler.u1(depth, Slot::Roulette);
                alive = alive & (!risky | u.below(q));
                beta = Spectrum::select(risky, beta * q.recip(), beta);
            }
        }
        self.pack(group, points, sample, beta, alive);
        alive
    }

    /// Returns the factors of roulette of a group.
    #[inline(always)]
    fn scales(&self, at: usize) -> F {
        if self.paths.rare.is_empty() { F::splat(1.0) } else { F::from_fn(|lane| self.paths.rare[at + lane].scale) }
    }

    /// Appends the `alive` lanes to the next paths.
    #[inline(always)]
    fn pack(
        &mut self,
        group: &Group<F>,
        points: &Points<F>,
        sample: &LaneSample<F>,
        beta: Spectrum<F>,
        alive: F::Mask,
    ) {
        let next = &mut *self.next;
        let at = next.len();
        let origin = offset(points.p, points.error, points.ng, sample.direction);
        origin.pack(alive, &mut next.rays.origin, at);
        sample.direction.pack(alive, &mut next.rays.direction, at);
        F::splat(f32::INFINITY).store(&mut next.rays.t_max, at);
        beta.pack(alive, &mut next.beta, at);
        sample.pdf.pack(alive, &mut next.pdf, at);
        points.p.pack(alive, &mut next.from, at);
        points.ng.pack(alive, &mut next.from_ng, at);
        group.keys.pack(alive, &mut next.keys, at);
        group.pixels.pack(alive, &mut next.pixels, at);
        let mut end = at;
        if self.paths.rare.is_empty() {
            end += alive.bits().count_ones() as usize;
        } else {
            for_each_bit(alive.bits(), |lane| {
                let Rare { scale, state, .. } = self.paths.rare[group.at + lane];
                next.rare[end] = Rare { scale, state, ..Rare::NONE };
                end += 1;
            });
        }
        next.rays.set_len(end);
    }

    /// Adds the environment to the pixels of the `missed` lanes, whose paths leave the scene.
    fn backgrounds(&mut self, at: usize, missed: F::Mask) {
        let lights = self.all.tracer.scene.lights();
        let Some((index, environment)) = lights.environment() else { return };
        if self.depth == 0 && self.all.tracer.transparent {
            return;
        }
        let (radiance, pdf) = environment.along_lanes(Vec3::load(&self.paths.rays.direction, at));
        let mut light = Spectrum::<F>::load(&self.paths.beta, at) * radiance;
        if self.depth > 0 {
            let pmf = || lights.pmf_lanes(&self.paths.receivers::<F>(at), missed, index);
            let pmf = self.tally.selection.time_of(lights, pmf);
            let weight = power(F::load(&self.paths.pdf, at), pmf * pdf);
            light = light * F::select(self.dirac(at), F::splat(1.0), weight);
        }
        for_each_bit(missed.bits(), |lane| {
            self.colors[self.paths.pixels[at + lane] as usize] += light.lane(lane);
        });
    }

    /// Returns the lanes of a group whose directions are Dirac ones.
    #[inline(always)]
    fn dirac(&self, at: usize) -> F::Mask {
        if self.paths.rare.is_empty() {
            return F::first(0);
        }
        let bit = |lane: usize| u32::from(self.paths.rare[at + lane].delta) << lane;
        F::Mask::from_bits((0..F::LANES).fold(0, |bits, lane| bits | bit(lane)))
    }

    /// Adds the environment to the pixel of path number `at`, which leaves the scene.
    fn background(&mut self, at: usize) {
        let walk = self.paths.walk(self.all.tracer.scene, at, self.depth);
        self.colors[self.paths.pixels[at] as usize] += self.all.tracer.background(&walk, CERTAIN, self.tally);
    }

    /// Adds the emission of the triangle that path number `at` meets, in `lane` of `points`.
    fn emission(&mut self, at: usize, points: &Points<F>, lane: usize) {
        let walk = self.paths.walk(self.all.tracer.scene, at, self.depth);
        let barycentric = points.weights(lane);
        let light = self.all.tracer.emitted(
            &walk,
            self.hits.hit(at),
            points.p.lane(lane).into(),
            barycentric,
            CERTAIN,
            self.tally,
        );
        self.colors[self.paths.pixels[at] as usize] += light;
    }

    /// Counts the hit of path number `at` if it is not consistent with its triangle.
    #[cold]
    fn judge(&mut self, at: usize) {
        let triangle = self.all.tracer.scene.geometry().triangle(self.hits.hit(at));
        let is_bad = triangle.meet(&self.paths.rays.ray(at)).is_some_and(|meet| !meet.consistent);
        self.tally.bad_hits += u64::from(is_bad);
    }

    /// Takes path number `at` to its next edge by the code of single paths. If it `has_met` its surface, it has got the
    /// emission.
    fn single(&mut self, at: usize, has_met: bool, numbers: impl PassNumbers) {
        let (tracer, key, pixel) = (&self.all.tracer, self.paths.keys[at], self.paths.pixels[at]);
        let scene = tracer.scene;
        let mut walk = self.paths.walk(scene, at, self.depth);
        let sampler = &mut numbers.of_keys(key);
        let mut point = SurfacePoint::new(scene.geometry(), self.hits.hit(at), &walk.ray);
        if !has_met {
            point = walk.arrived(point, sampler, self.tally);
            self.colors[pixel as usize] += match &point {
                Some(point) => tracer.emitted(&walk, point.hit, point.p, point.barycentric, CERTAIN, self.tally),
                None => tracer.background(&walk, CERTAIN, self.tally),
            };
        }
        let Some(point) = &mut point.filter(|_| walk.depth < tracer.max_depth) else { return };
        let shadows = &mut *self.shadows;
        let push = |edge: &Edge, light, _: &mut _| shadows.push(edge.ray(), light, pixel);
        if tracer.leave(&mut walk, point, sampler, self.tally, push) {
            self.next.push(&walk, key, pixel);
        }
    }
}

/// A scattering event in each lane of a group.
#[derive(Clone, Copy)]
struct Event<'e, F: Float> {
    group: &'e Group<F>,
    point: &'e LanePoint<F>,
    light: &'e LightSamples<F>,
    /// Numbers of the lobe and of the direction.
    u: [F; 3],
    /// Lanes whose parameters vary.
    varying: u32,
}

/// What comes of a scattering event.
#[derive(Clone, Copy)]
struct Outcome<F: Float> {
    /// Contribution of the light sample if nothing blocks it.
    light: Spectrum<F>,
    /// Lanes in which there is one.
    lit: F::Mask,
    sample: LaneSample<F>,
    /// Lanes that the kernel does not answer.
    doubtful: F::Mask,
}

impl<F: Float> Outcome<F> {
    /// Returns `other` in the lanes of `mask`, else this one.
    #[inline(always)]
    fn merged(self, mask: F::Mask, other: Self) -> Self {
        let (x, y) = (&self.sample, &other.sample);
        Outcome {
            light: Spectrum::select(mask, other.light, self.light),
            lit: mask.select(other.lit, self.lit),
            sample: LaneSample {
                direction: Vec3::select(mask, y.direction, x.direction),
                weight: Spectrum::select(mask, y.weight, x.weight),
                pdf: F::select(mask, y.pdf, x.pdf),
                valid: mask.select(y.valid, x.valid),
                doubtful: mask.select(y.doubtful, x.doubtful),
            },
            doubtful: mask.select(other.doubtful, self.doubtful),
        }
    }
}
