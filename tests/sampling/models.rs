//! Scattering models and directions for the tests.

use etendue::bsdf::{Conductor, Dielectric, Fresnel, Ggx, Lambert, MetallicRoughness, Surface, Thin, Wall};
use etendue::geometry::Local;
use etendue::spectrum::Spectrum;

/// A surface and what to call it in a message.
pub(crate) struct Model {
    pub(crate) name: String,
    pub(crate) surface: Surface,
    /// Refractive index inside over outside.
    pub(crate) eta: f32,
    /// What a diffuse base would scatter without the layer over it: the layer's 1 − E cancels.
    pub(crate) base: f64,
}

/// Parameters of a plain white glTF dielectric, for struct updates.
pub(crate) fn white_plastic(alpha: f32) -> MetallicRoughness {
    MetallicRoughness {
        base: Spectrum::ONE,
        metallic: 0.0,
        roughness: alpha.sqrt(),
        specular: 1.0,
        specular_color: Spectrum::ONE,
        ior: 1.5,
        outside: 1.0,
        transmission: 0.0,
        wall: Wall::Thin,
        metal_f90: Spectrum::ONE,
    }
}

/// Every model at the roughness `alpha`, coloured where it can be.
pub(crate) fn models(alpha: f32) -> Vec<Model> {
    let ggx = Ggx::new(alpha);
    let (gold, ruby) = (Spectrum([0.9, 0.6, 0.3]), Spectrum([0.9, 0.2, 0.4]));
    let schlick = Fresnel::Schlick { f0: gold, f90: Spectrum::ONE };
    let glass = |eta| Surface::Dielectric(Dielectric { ggx, eta, reflect: Spectrum::ONE, transmit: ruby });
    let plastic = MetallicRoughness { base: ruby, ..white_plastic(alpha) };
    let model = |name: &str, surface, eta| Model {
        name: format!("{name}, alpha {alpha}"),
        surface,
        eta,
        base: if matches!(surface, Surface::MetalDielectric(_)) { std::f64::consts::FRAC_1_PI } else { 0.0 },
    };
    vec![
        model("Lambert", Surface::Lambert(Lambert { albedo: ruby }), 1.0),
        model("conductor", Surface::Conductor(Conductor { ggx, fresnel: schlick }), 1.0),
        model("glass", glass(1.5), 1.5),
        model("bubble", glass(0.75), 0.75),
        model("sheet", Surface::Thin(Thin { ggx, fresnel: Fresnel::Dielectric { eta: 1.5 }, transmit: ruby }), 1.0),
        model("plastic", plastic.surface(), 1.0),
        model("half metal", MetallicRoughness { metallic: 0.5, ..plastic }.surface(), 1.0),
        model("half sheet", MetallicRoughness { transmission: 0.5, ..plastic }.surface(), 1.0),
        model("half glass", MetallicRoughness { transmission: 0.5, wall: Wall::Solid, ..plastic }.surface(), 1.5),
    ]
}

/// The unit direction of cosine `cos` (negative: below) at the azimuth `phi`.
pub(crate) fn direction(cos: f32, phi: f32) -> Local {
    let sin = (1.0 - f64::from(cos).powi(2)).sqrt();
    Local::new((sin * f64::from(phi).cos()) as f32, (sin * f64::from(phi).sin()) as f32, cos)
}

/// Maps two random numbers to a direction on the sphere.
pub(crate) fn any_direction(u: [f32; 2]) -> Local {
    direction(2.0 * u[0] - 1.0, std::f32::consts::TAU * u[1])
}
