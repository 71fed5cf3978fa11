//! Connections between two subpaths, and between a subpath and an endpoint: their contribution and MIS weight.
//! Visibility is tested last, since it traces a ray.

use super::mis::{FlightPdfs, MisStrategy};
use super::{Scatterer, SubpathVertex, Vertex};
use crate::bsdf::Scattering;
use crate::camera::{Camera, LensPoint};
use crate::light::{ChosenLight, EmitterPoint};
use crate::sampling::{Density, Sampler, Slot};
use crate::scene::{Edge, EdgeEnd, Scene};
use crate::spectrum::Spectrum;
use glam::Vec3;

/// Contribution of a technique before the visibility test.
#[derive(Clone, Copy)]
pub struct Connection<'v> {
    /// f(x̄) divided by the density of the technique, without the transmittance of the segment.
    pub value: Spectrum,
    /// Density ratios of the techniques that walk along the edge instead, to its end and to its start: see
    /// [`MisStrategy::connection`].
    others: [f64; 2],
    /// MIS weight without media that scatter.
    pub clear_weight: f64,
    /// Probability that both subpaths survived roulette. `value` is already divided by it.
    pub survival: f32,
    /// Vertex at which the edge begins.
    from: &'v Vertex<'v>,
    /// Unit direction of the edge.
    wi: Vec3,
    end: EdgeEnd<'v>,
}

impl Connection<'_> {
    /// Returns it after roulette that kept it with probability `q`.
    #[inline]
    pub fn survived(self, q: f32) -> Self {
        Connection { value: self.value / q, survival: self.survival * q, ..self }
    }

    /// Returns the MIS weight of the technique if the media on the edge that scatter have the transmittance `flight`.
    #[inline]
    pub fn weight(&self, weights: &MisStrategy, flight: Spectrum) -> f64 {
        if flight == Spectrum::ONE {
            return self.clear_weight;
        }
        let end = if let EdgeEnd::Medium(_, extinction) = self.end { extinction } else { Spectrum::ONE };
        weights.connection(self.others, FlightPdfs::new(flight, self.from.extinction(), end))
    }

    /// Returns the edge to test for visibility. It is made on demand, since roulette drops many connections.
    #[inline]
    pub fn edge(&self, scene: &Scene) -> Option<Edge> {
        self.from.edge_to(scene, self.wi, self.end)
    }
}

/// A connection to the camera.
#[derive(Clone, Copy)]
pub struct Splat<'v> {
    /// Contribution per pixel of film area and light subpath.
    pub connection: Connection<'v>,
    /// Raster position, in pixels.
    pub film: [f32; 2],
}

/// Next-event estimation at the vertex `z` of a camera subpath.
pub fn next_event<'v>(
    scene: &Scene,
    weights: &MisStrategy,
    z: &'v SubpathVertex,
    scatterer: &Scatterer,
    sampler: &mut impl Sampler,
) -> Option<Connection<'v>> {
    let bounce = z.sums.index - 1;
    let receiver = z.vertex.context()?;
    let u = sampler.u2(bounce, Slot::LightPoint);
    let chosen = scene.lights().choose(&receiver, u, || sampler.u1(bounce, Slot::LightPick));
    let ChosenLight { index, pmf, u } = chosen?;
    let light = &scene.lights().all()[index];
    let sample = light.sample_li(&receiver, u)?;
    let Scattering { f_cos, pdf } = scatterer.scattering(sample.wi)?;
    let pmf = f64::from(pmf.value());
    let emission = light.ray_density(scene.ball(), -sample.wi);
    let ratio = f64::from(scene.lights().emitter_pmf(index).value()) / pmf;
    let ratio = ratio / light.end_pdf_ratio(&receiver, &sample.end, sample.wi);
    let d2 = match sample.end {
        EmitterPoint::Surface { p, .. } | EmitterPoint::Point(p) => f64::from(p.distance_squared(receiver.p)),
        EmitterPoint::Distant => 1.0,
    };
    let made = ratio * emission * f64::from(z.vertex.cos(sample.wi)) / d2;
    let hit = match sample.density {
        Density::Smooth(toward) => f64::from(pdf.value()) / (pmf * f64::from(toward.value())),
        Density::Delta(_) => 0.0,
    };
    let reverse = f64::from(scatterer.reverse_pdf(sample.wi).value());
    let others = [weights.instead_of_sample(hit), weights.earlier(&z.sums, made, reverse)];
    Some(Connection {
        value: z.beta * f_cos * sample.radiance / (pmf as f32 * sample.density.value()),
        others,
        clear_weight: weights.connection(others, FlightPdfs::CERTAIN),
        survival: z.survival,
        from: &z.vertex,
        wi: sample.wi,
        end: EdgeEnd::Light(sample.end),
    })
}

/// Connects the vertex `y` of a light subpath to the vertex `z` of a camera subpath.
#[inline]
pub fn connect<'v>(
    weights: &MisStrategy,
    y: &'v SubpathVertex,
    z: &'v SubpathVertex,
    z_scatterer: &Scatterer,
) -> Option<Connection<'v>> {
    let to = y.vertex.p()? - z.vertex.p()?;
    let d2 = to.length_squared();
    let wi = to / d2.sqrt();
    // Borrowed, not moved out of the options: a copy of what was just written stalls.
    let Some(at_z) = &z_scatterer.scattering(wi) else { return None };
    let Some((at_y, y_reverse)) = &y.scattering(-wi) else { return None };
    if d2 <= 0.0 {
        return None;
    }
    let per_area = |pdf: f32, at: &Vertex| f64::from(pdf) * f64::from(at.cos(wi)) / f64::from(d2);
    let light = weights.earlier(&y.sums, per_area(at_z.pdf.value(), &y.vertex), *y_reverse);
    let camera =
        weights.earlier(&z.sums, per_area(at_y.pdf.value(), &z.vertex), f64::from(z_scatterer.reverse_pdf(wi).value()));
    let value = y.beta * at_y.f_cos * at_z.f_cos * z.beta / d2;
    let (others, survival) = ([light, camera], y.survival * z.survival);
    let clear_weight = weights.connection(others, FlightPdfs::CERTAIN);
    Some(Connection { value, others, clear_weight, survival, from: &z.vertex, wi, end: y.vertex.as_end() })
}

/// Connects the vertex `y` of a light subpath to the point `lens` of the camera's lens; `None` if `y` is outside the
/// field of view or culled.
pub fn splat<'v>(
    scene: &Scene,
    weights: &MisStrategy,
    camera: &Camera,
    lens: LensPoint,
    y: &'v SubpathVertex,
) -> Option<Splat<'v>> {
    let seen = camera.sample_wi(y.vertex.p()?, lens)?;
    if y.vertex.surface().is_some_and(|at| scene.culled(&at.point, -seen.wi)) {
        return None;
    }
    let Some((at_y, reverse)) = &y.scattering(seen.wi) else { return None };
    // The density of the point of the lens is a factor of We and of every technique.
    let density = f64::from(seen.importance) * f64::from(y.vertex.cos(seen.wi));
    let value = y.beta * at_y.f_cos * seen.importance;
    let others = [0.0, weights.instead_of_splat(&y.sums, density, *reverse)];
    let end = EdgeEnd::Camera(seen.eye);
    let clear_weight = weights.connection(others, FlightPdfs::CERTAIN);
    let connection =
        Connection { value, others, clear_weight, survival: y.survival, from: &y.vertex, wi: seen.wi, end };
    Some(Splat { connection, film: seen.film })
}
