//! Names of the diffusion models, and their profiles in one form.

use super::totals::diffuse_total;
use super::{Burley, Dipole, MediumLane, RadialProfile, Tabulated, photon_beam, single_scattering};

/// A diffusion model. Each is an approximation: see the head of the module for its errors.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    serde::Serialize,
    serde::Deserialize,
    strum::VariantArray,
    strum::IntoStaticStr,
    strum::EnumMessage,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum DiffusionModel {
    /// Jensen's dipole: a source below the surface and its mirror image; too dark, and wrong near the entry.
    Dipole,
    /// d'Eon's better dipole with exact single scattering; too bright in media that hardly absorb.
    BetterDipole,
    /// Photon beam diffusion with the exact total: the smallest errors behind a boundary that refracts.
    PhotonBeam,
    /// Normalized diffusion of Christensen and Burley with the exact total: right where indices match.
    Burley,
}

impl DiffusionModel {
    /// Returns the profile of `medium`, as a table. Its total is below 2e-4 from the model's. The tables of
    /// [`DiffusionModel::PhotonBeam`] and of [`DiffusionModel::BetterDipole`] take some ten milliseconds.
    ///
    /// # Panics
    /// Unless `medium` is in the ranges its fields state, with positive extinction.
    pub fn profile(self, medium: &MediumLane) -> Tabulated {
        let (reduced, lit) = (medium.reduced(), medium.lit());
        let decay = (3.0 * reduced.absorption * reduced.extinction()).sqrt();
        let tabulate = |value: &dyn Fn(f64) -> f64| Tabulated::of_medium(medium, decay, value);
        match self {
            DiffusionModel::Dipole => {
                let dipole = Dipole::classical(&lit);
                tabulate(&|r| dipole.value(r))
            }
            DiffusionModel::BetterDipole => {
                let (often, once) = (Dipole::better(&lit), single_scattering(&lit));
                tabulate(&|r| often.value(r) + once.value(r))
            }
            DiffusionModel::PhotonBeam => photon_beam(medium).with_total(diffuse_total(medium)),
            DiffusionModel::Burley => {
                let total = diffuse_total(medium);
                let profile = Burley::diffuse(total, 1.0 / reduced.extinction());
                tabulate(&|r| profile.density(r)).with_total(total)
            }
        }
    }
}
