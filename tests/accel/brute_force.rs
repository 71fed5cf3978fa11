//! Every triangle against a ray in f64, and which answers of a backend that works in f32 are right.
//!
//! A backend sees a ray that is displaced by at most `displacement`. A triangle that the ray passes *clearly*, farther
//! than that inside every edge, must be hit; one that it misses clearly must not be. Between them lie grazes, where
//! either answer is right, and two hits whose distance is within the error of both are a tie.

use etendue::geometry::{Geometry, Hit, Ray};
use glam::{DAffine3, DMat3, DVec3, Vec3};

/// Half an ulp of 1 in f32: one rounding.
const ROUNDING: f64 = f32::EPSILON as f64 * 0.5;

/// A triangle that a ray passes, or grazes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    pub(crate) hit: Hit,
    pub(crate) t: f64,
    /// How far `t` may be off in a backend.
    pub(crate) t_error: f64,
    /// Whether a backend has to find it.
    pub(crate) clear: bool,
}

struct Placed {
    hit: Hit,
    vertices: [DVec3; 3],
    /// Condition of the placement and length of its translation; 1 and 0 for none.
    condition: f64,
    translation: f64,
}

pub(crate) struct BruteForce(Vec<Placed>);

impl BruteForce {
    pub(crate) fn new(geometry: &Geometry) -> Self {
        let mut triangles = Vec::new();
        for (object, o) in (0..).zip(&geometry.objects) {
            let mesh = geometry.mesh_of(object);
            let m = o.placement.map_or(DAffine3::IDENTITY, |m| m.as_daffine3());
            for (primitive, corners) in (0..).zip(mesh.triangles()) {
                let vertices = corners.map(|i| m.transform_point3(mesh.positions()[i as usize].as_dvec3()));
                let hit = Hit { object, primitive };
                let condition = o.placement.map_or(0.0, |_| norm(m.matrix3) * norm(m.matrix3.inverse()));
                triangles.push(Placed { hit, vertices, condition, translation: m.translation.length() });
            }
        }
        BruteForce(triangles)
    }

    /// All triangles that `ray` passes or grazes and that `accepts` lets through, in no order.
    pub(crate) fn candidates(&self, ray: &Ray, accepts: impl Fn(Hit) -> bool) -> Vec<Candidate> {
        self.0.iter().filter(|placed| accepts(placed.hit)).filter_map(|placed| placed.meet(ray)).collect()
    }
}

/// The Frobenius norm, which is not below the spectral one.
fn norm(m: DMat3) -> f64 {
    m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt()
}

impl Placed {
    fn meet(&self, ray: &Ray) -> Option<Candidate> {
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3().normalize());
        let [a, b, c] = self.vertices;
        let n = (b - a).cross(c - a).normalize();
        let facing = n.dot(d);
        let t = n.dot(a - o) / facing;
        // Signed distances of the ray's line to those of the edges, positive inside, each with its error.
        let (mut inside, mut clear) = (t.is_finite(), true);
        let mut worst = 0.0f64;
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let across = (q - p) - d * (q - p).dot(d);
            let distance = d.dot((q - p).cross(o - p)) / across.length() * facing.signum();
            let error = self.displacement(o) * (q - p).length() / across.length();
            inside &= distance >= -error;
            clear &= distance > error;
            worst = worst.max(error);
        }
        let length = f64::from(ray.direction.length());
        let (t, t_error) = (t / length, worst / facing.abs() / length);
        let (t_min, t_max) = (f64::from(ray.t_min), f64::from(ray.t_max));
        clear &= t - t_error > t_min && t + t_error < t_max;
        inside &= t + t_error >= t_min && t - t_error <= t_max;
        inside.then_some(Candidate { hit: self.hit, t, t_error, clear })
    }

    /// How far from the true ray the one is that a backend effectively tests.
    ///
    /// It subtracts the origin from the vertices (one rounding of the distance to them, which displaces them) and forms
    /// edge functions of products (up to 7 more, relative to the same distance). A ray in object space went through an
    /// inverse of relative error κ times about 8 roundings and through 8 roundings of its own terms, which the
    /// placement magnifies by κ.
    fn displacement(&self, origin: DVec3) -> f64 {
        let reach = self.vertices.iter().map(|&v| (v - origin).length()).fold(0.0, f64::max);
        let k = self.condition;
        8.0 * ROUNDING * reach + (8.0 * k * k + 8.0 * k) * ROUNDING * (origin.length() + self.translation + reach)
    }
}

/// Why `answer` is wrong for a ray with these candidates; `None` if it is right.
pub(crate) fn fault(answer: Option<Hit>, candidates: &[Candidate]) -> Option<String> {
    let mut limit = f64::INFINITY;
    if let Some(hit) = answer {
        match candidates.iter().find(|candidate| candidate.hit == hit) {
            None => return Some(format!("{hit:?} is not on the ray")),
            Some(found) => limit = found.t - found.t_error,
        }
    }
    let missed = candidates.iter().find(|candidate| candidate.clear && candidate.t + candidate.t_error < limit);
    missed.map(|missed| format!("{missed:?} is nearer than {answer:?}"))
}

/// The nearest candidate, whether a backend has to find it or not.
pub(crate) fn nearest(candidates: &[Candidate]) -> Option<Hit> {
    candidates.iter().min_by(|a, b| a.t.total_cmp(&b.t)).map(|candidate| candidate.hit)
}

#[test]
fn brute_force_comparison_detects_wrong_hits() {
    let geometry = super::scenes::scene_of(vec![super::scenes::triangle()], vec![(0, None, false)]);
    let brute = BruteForce::new(&geometry);
    let hit = Hit { object: 0, primitive: 0 };
    let through = brute.candidates(&Ray::new(Vec3::new(0.2, 0.2, 1.0), -Vec3::Z), |_| true);
    assert!(fault(Some(hit), &through).is_none());
    assert!(fault(None, &through).is_some(), "a miss of a clear hit");
    let beside = brute.candidates(&Ray::new(Vec3::new(0.2, -1e-5, 1.0), -Vec3::Z), |_| true);
    assert!(fault(Some(hit), &beside).is_some(), "a hit of a clear miss");
    let edge = brute.candidates(&Ray::new(Vec3::new(0.2, 0.0, 1.0), -Vec3::Z), |_| true);
    assert!(fault(Some(hit), &edge).is_none() && fault(None, &edge).is_none(), "a graze is either");
    let rejected = brute.candidates(&Ray::new(Vec3::new(0.2, 0.2, 1.0), -Vec3::Z), |_| false);
    assert!(fault(None, &rejected).is_none() && fault(Some(hit), &rejected).is_some());
}
