//! Lanes against [`Shading`], bit for bit.

use super::*;
use crate::bsdf::{Ggx, MetallicRoughness, Shading, Wall};
use crate::geometry::{Frame, Hit, SurfacePoint};
use crate::sampling::lanes::uniform_sphere;
use crate::sampling::{Address, IndependentSampler, Sampler, Slot};
use crate::transport::TransportMode;
use etendue_lanes::{Array, MOST_LANES, Mask, Native};

const EVENTS: usize = 4096;

/// Random scattering events: normals, known and other directions, numbers. A sixteenth of the known directions grazes.
struct Events {
    /// Shading and geometric normals.
    normals: Vec<[glam::Vec3; 2]>,
    known: Vec<glam::Vec3>,
    others: Vec<glam::Vec3>,
    numbers: Vec<[f32; 3]>,
}

impl Events {
    /// Returns events whose shading normals deviate from the geometric ones by about `bend` radians.
    fn new(bend: f32) -> Self {
        let mut sampler = IndependentSampler::new(Address::new(3));
        let mut direction = |i: usize, slot| -> glam::Vec3 { uniform_sphere(sampler.u2(i as u32, slot)).into() };
        let normals: Vec<_> = (0..EVENTS)
            .map(|i| {
                let ng = direction(i, Slot::Film);
                let bent = if bend > 0.0 { (ng + direction(i, Slot::Event) * bend).normalize() } else { ng };
                [bent, ng]
            })
            .collect();
        let others = (0..EVENTS).map(|i| direction(i, Slot::Direction)).collect();
        let known = (0..EVENTS).map(|i| {
            let (w, [_, n]) = (direction(i, Slot::LightPoint), normals[i]);
            if i % 16 == 0 { (w - n * (w.dot(n) * 0.999_999)).normalize() } else { w }
        });
        let known = known.collect();
        let number = |i: usize| {
            let [u, v] = sampler.u2(i as u32, Slot::Lens);
            [sampler.u1(i as u32, Slot::Lobe), u, v]
        };
        let numbers = (0..EVENTS).map(number).collect();
        Events { normals, known, others, numbers }
    }

    fn point(&self, i: usize) -> SurfacePoint {
        let [n, ng] = self.normals[i];
        SurfacePoint {
            p: glam::Vec3::ZERO,
            error: 0.0,
            ng,
            frame: Frame::around(n),
            barycentric: [0.0; 2],
            hit: Hit { object: 0, primitive: 0 },
            t: 1.0,
            touching: false,
            consistent: true,
        }
    }
}

fn vectors<F: Float>(at: usize, of: impl Fn(usize) -> glam::Vec3) -> Vec3<F> {
    let column = |axis: usize| F::from_fn(|lane| of(at + lane)[axis]);
    Vec3::new(column(0), column(1), column(2))
}

fn bits(v: [f32; 3]) -> [u32; 3] {
    v.map(f32::to_bits)
}

/// Compares every lane with [`Shading`]; returns the number of doubtful ones.
fn compare<F: Float, M: LaneScatter<F>>(events: &Events, surface: &Surface) -> usize {
    let row = LaneSurface::new(surface).expect("a model with a kernel");
    let mut count = 0;
    for at in (0..EVENTS).step_by(F::LANES) {
        let normals = [0, 1].map(|k| vectors(at, |i| events.normals[i][k]));
        let point = LanePoint::<F>::new(normals, vectors(at, |i| events.known[i]));
        let model = M::new([0, 1, 2].map(|k| F::rows(|_| &row.parameters[k])), &point);
        let scattering = model.scattering(&point, vectors(at, |i| events.others[i]));
        let numbers = [0, 1, 2].map(|k| F::from_fn(|lane| events.numbers[at + lane][k]));
        let sample = model.sampled(&point, numbers);
        let doubtful = point.doubtful | (point.scatters & (scattering.doubtful | sample.doubtful));
        count += doubtful.bits().count_ones() as usize;
        for lane in 0..F::LANES {
            let i = at + lane;
            let set = |mask: F::Mask| mask.bits() >> lane & 1 == 1;
            let surface_point = events.point(i);
            let shading = Shading::new(&surface_point, surface, events.known[i], TransportMode::Radiance);
            assert_eq!(shading.is_some(), set(point.scatters | point.doubtful), "event {i}");
            let Some(shading) = shading.filter(|_| !set(point.doubtful)) else { continue };
            let want = shading.scattering(events.others[i]);
            if !set(scattering.doubtful) {
                assert_eq!(want.is_some(), set(scattering.valid), "event {i}");
                if let Some(want) = want {
                    assert_eq!(bits(want.f_cos.0), bits(scattering.f_cos.lane(lane).0), "event {i}");
                    assert_eq!(want.pdf.value().to_bits(), scattering.pdf.lane(lane).to_bits(), "event {i}");
                }
            }
            let want = shading.sample(events.numbers[i]);
            if !set(sample.doubtful) {
                assert_eq!(want.is_some(), set(sample.valid), "event {i}");
                if let Some(want) = want {
                    assert_eq!(bits(want.direction.to_array()), bits(sample.direction.lane(lane)), "event {i}");
                    assert_eq!(bits(want.weight.0), bits(sample.weight.lane(lane).0), "event {i}");
                    assert_eq!(want.density.value().to_bits(), sample.pdf.lane(lane).to_bits(), "event {i}");
                }
            }
        }
    }
    count
}

fn metal(alpha: f32) -> Surface {
    let (f0, f90) = (Spectrum([0.9, 0.5, 0.2]), Spectrum::ONE);
    Surface::Conductor(Conductor { ggx: Ggx::new(alpha), fresnel: Fresnel::Schlick { f0, f90 } })
}

fn mixture(metallic: f32, roughness: f32) -> Surface {
    let parameters = MetallicRoughness {
        base: Spectrum([0.9, 0.4, 0.0]),
        metallic,
        roughness,
        specular: 0.8,
        specular_color: Spectrum([1.0, 0.9, 0.7]),
        ior: 1.5,
        outside: 1.0,
        transmission: 0.0,
        wall: Wall::Thin,
        metal_f90: Spectrum::ONE,
    };
    parameters.surface()
}

/// One family on all models; `most` is the number of events that may be left to the other code.
fn family<F: Float>(events: &Events, most: usize) {
    let lambert = Surface::Lambert(Lambert { albedo: Spectrum([0.8, 0.3, 0.0]) });
    let mut doubtful = vec![compare::<F, LaneLambert<F>>(events, &lambert)];
    for alpha in [4e-5, 0.01, 0.25, 1.0] {
        doubtful.push(compare::<F, LaneConductor<F>>(events, &metal(alpha)));
    }
    for (metallic, roughness) in [(0.0, 1.0), (0.0, 0.2), (0.5, 0.5), (0.9, 0.05)] {
        doubtful.push(compare::<F, LaneMetalDielectric<F>>(events, &mixture(metallic, roughness)));
    }
    assert!(doubtful.iter().all(|&count| count < most), "{doubtful:?}");
}

/// With one normal a hundredth of the events may be doubtful.
#[test]
fn lanes_scatter_as_shading_does() {
    let flat = Events::new(0.0);
    family::<f32>(&flat, EVENTS / 100);
    family::<Native>(&flat, EVENTS / 100);
    family::<Array<4>>(&flat, EVENTS / 100);
}

/// Normals that differ by a tenth disagree about as many directions.
#[test]
fn lanes_scatter_about_shading_normals_as_shading_does() {
    let bent = Events::new(0.1);
    family::<f32>(&bent, EVENTS / 5);
    family::<Native>(&bent, EVENTS / 5);
}

/// All models that textures make of one surface, among them both ends of each choice, by the lanes and one by one.
fn chosen<F: Float>() {
    let mut sampler = IndependentSampler::new(Address::new(5));
    let ends = [0.0, 1.0, 0.004, 0.5];
    for i in 0..EVENTS as u32 / 8 {
        let mut number = |lane: usize, slot| {
            let [pick, u] = sampler.u2(i * MOST_LANES as u32 + lane as u32, slot);
            ends.get((pick * 8.0) as usize).copied().unwrap_or(u)
        };
        let values: Vec<[f32; ROW]> = (0..F::LANES)
            .map(|lane| {
                let black = lane % 5 == 4;
                let [r, g, b, rough, metal] =
                    [Slot::Film, Slot::Lens, Slot::Lobe, Slot::Direction, Slot::Event].map(|slot| number(lane, slot));
                let tint = |x: f32| if black { 0.0 } else { x };
                [tint(r), tint(g), tint(b), 1.0, 0.3, rough, metal, 1.0]
            })
            .collect();
        let whole = MetallicRoughness {
            base: Spectrum([0.9, 0.4, 1.0]),
            metallic: 1.0,
            roughness: 1.0,
            specular: number(0, Slot::LightPick),
            specular_color: Spectrum([1.0, number(0, Slot::LightPoint), 0.7]),
            ior: 1.5,
            outside: 1.0,
            transmission: 0.0,
            wall: Wall::Thin,
            metal_f90: Spectrum::ONE,
        };
        let factors = whole.factors();
        let lanes =
            LaneMetallicRoughness::<F>::new([0, 1].map(|k| F::rows(|_| &factors[k])), F::rows(|lane| &values[lane]));
        let mut rows = [Parameters::default(); MOST_LANES];
        lanes.store(u32::MAX, &mut rows);
        for (lane, [r, g, b, _, _, rough, metal, _]) in values.into_iter().enumerate() {
            let base = whole.base * Spectrum([r, g, b]);
            let surface = MetallicRoughness { base, metallic: metal, roughness: rough, ..whole }.surface();
            let set = |mask: F::Mask| mask.bits() >> lane & 1 == 1;
            let found = [
                (lanes.lambert, LaneModel::Lambert),
                (lanes.conductor, LaneModel::Conductor),
                (lanes.metal_dielectric, LaneModel::MetalDielectric),
            ];
            let found = found.into_iter().filter(|(mask, _)| set(*mask)).map(|(_, model)| model);
            let want = LaneSurface::new(&surface);
            assert_eq!(found.collect::<Vec<_>>(), want.iter().map(|row| row.model).collect::<Vec<_>>(), "{surface:?}");
            assert_eq!(set(lanes.mirror), want.is_none() && !matches!(surface, Surface::Black), "{surface:?}");
            let Some(want) = want else { continue };
            // What each model reads.
            let read = match want.model {
                LaneModel::Lambert => 3,
                LaneModel::Conductor => 7,
                LaneModel::MetalDielectric => 3 * ROW,
            };
            let bits = |rows: &Parameters| rows.as_flattened()[..read].iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&rows[lane]), bits(&want.parameters), "{surface:?}");
        }
    }
}

#[test]
fn lanes_choose_the_models_of_textured_surfaces() {
    chosen::<f32>();
    chosen::<Native>();
    chosen::<Array<4>>();
}

#[test]
fn models_without_a_kernel_have_no_parameters() {
    let mirror = Conductor { ggx: Ggx::new(0.0), fresnel: Fresnel::Schlick { f0: Spectrum::ONE, f90: Spectrum::ONE } };
    let exact = Conductor { ggx: Ggx::new(0.5), fresnel: Fresnel::Dielectric { eta: 1.5 } };
    let clear = mixture(0.5, 0.0);
    for surface in [Surface::Black, Surface::Conductor(mirror), Surface::Conductor(exact), clear] {
        assert!(LaneSurface::new(&surface).is_none());
    }
}
