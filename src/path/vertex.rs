//! Vertices of paths. What depends on the kind of a vertex is asked of it: C(x), the context of light samples,
//! scattering, and the edges that leave it.

use super::mis::EdgeOrigin;
use super::scatterer::PhaseAt;
use super::{MediumPoint, Scatterer};
use crate::bsdf::{Bsdf, Lobes, Shading, Surface};
use crate::camera::CameraPoint;
use crate::geometry::{Ray, RayState, SurfacePoint};
use crate::light::{EmitterPoint, LightSampleContext};
use crate::scene::{Edge, EdgeEnd, Scene};
use crate::spectrum::Spectrum;
use crate::transport::TransportMode;
use glam::Vec3;
use std::borrow::Cow;

/// Vertex of a path.
#[allow(clippy::large_enum_variant)] // nearly all vertices lie on surfaces
#[derive(Clone)]
pub enum Vertex<'a> {
    /// At the camera.
    Camera(CameraPoint),
    /// At a light.
    Light(EmitterPoint),
    /// On a surface.
    Surface(SurfaceVertex<'a>),
    /// In a medium.
    Medium(MediumPoint),
}

/// A vertex on a surface.
#[derive(Clone)]
pub struct SurfaceVertex<'a> {
    /// Surface point.
    pub point: SurfacePoint,
    /// Scattering model.
    pub surface: Cow<'a, Surface>,
    /// State in which a walk arrives.
    pub state: RayState,
}

impl Vertex<'_> {
    /// Returns C(x) for the unit direction `w`: |w·ng| on a surface, 1 in space. The camera's cosine is part of We.
    #[inline]
    pub fn cos(&self, w: Vec3) -> f32 {
        match self {
            Vertex::Surface(vertex) => vertex.point.cos(w),
            Vertex::Light(EmitterPoint::Surface { ng, .. }) => w.dot(*ng).abs(),
            Vertex::Camera(_) | Vertex::Medium(_) | Vertex::Light(EmitterPoint::Point(_) | EmitterPoint::Distant) => {
                1.0
            }
        }
    }

    /// Returns its position; `None` at infinity.
    #[inline]
    pub fn p(&self) -> Option<Vec3> {
        match self {
            Vertex::Surface(vertex) => Some(vertex.point.p),
            Vertex::Camera(eye) => Some(eye.p),
            Vertex::Light(EmitterPoint::Surface { p, .. } | EmitterPoint::Point(p)) => Some(*p),
            Vertex::Light(EmitterPoint::Distant) => None,
            Vertex::Medium(point) => Some(point.p),
        }
    }

    /// Returns its surface, if it scatters on one.
    #[inline]
    pub fn surface(&self) -> Option<&SurfaceVertex<'_>> {
        match self {
            Vertex::Surface(vertex) => Some(vertex),
            Vertex::Camera(_) | Vertex::Light(_) | Vertex::Medium(_) => None,
        }
    }

    /// Returns it as the receiver of light samples; `None` for an endpoint.
    #[inline]
    pub fn context(&self) -> Option<LightSampleContext> {
        match self {
            Vertex::Surface(vertex) => Some(LightSampleContext::from(&vertex.point)),
            Vertex::Medium(point) => Some(LightSampleContext::from(point)),
            Vertex::Camera(_) | Vertex::Light(_) => None,
        }
    }

    /// Returns its scattering for the direction `known`; `None` if nothing scatters, as where `known` lies on different
    /// sides of the shading and geometric normals of a surface.
    #[inline]
    pub fn scatterer(&self, known: Vec3, mode: TransportMode) -> Option<Scatterer<'_>> {
        match self {
            Vertex::Surface(SurfaceVertex { point, surface, .. }) => {
                Shading::new(point, surface, known, mode).map(Scatterer::Surface)
            }
            Vertex::Medium(point) => Some(Scatterer::Medium(PhaseAt::new(point, known))),
            Vertex::Camera(_) | Vertex::Light(_) => None,
        }
    }

    /// Whether it scatters smoothly, so that connections can carry light.
    #[inline]
    pub fn is_connectible(&self) -> bool {
        match self {
            Vertex::Surface(vertex) => vertex.surface.lobes().intersects(Lobes::SMOOTH),
            Vertex::Medium(_) => true,
            Vertex::Camera(_) | Vertex::Light(_) => false,
        }
    }

    /// Returns σt if it lies in a medium, else 1: see [`density`](crate::medium::density).
    #[inline]
    pub fn extinction(&self) -> Spectrum {
        if let Vertex::Medium(point) = self { point.extinction } else { Spectrum::ONE }
    }

    /// Returns the edge in the unit direction `w` to `end`; `None` from an endpoint, since connections begin where
    /// light scatters.
    #[inline]
    pub fn edge_to(&self, scene: &Scene, w: Vec3, end: EdgeEnd) -> Option<Edge> {
        match self {
            Vertex::Surface(SurfaceVertex { point, state, .. }) => Some(Edge::new(scene, point, *state, w, end)),
            Vertex::Medium(point) => Some(Edge::from_medium(point.p, point.state, w, end)),
            Vertex::Camera(_) | Vertex::Light(_) => None,
        }
    }

    /// Returns a ray that leaves it in the unit direction `w`; `None` from an endpoint.
    pub fn spawn(&self, scene: &Scene, w: Vec3) -> Option<Ray> {
        match self {
            Vertex::Surface(SurfaceVertex { point, state, .. }) => {
                Some(point.spawn(w).carrying(scene.state_toward(point, *state, w)))
            }
            Vertex::Medium(point) => Some(Ray::new(point.p, w).carrying(point.state)),
            Vertex::Camera(_) | Vertex::Light(_) => None,
        }
    }

    /// Returns it as the far end of an edge.
    #[inline]
    pub fn as_end(&self) -> EdgeEnd<'_> {
        match self {
            Vertex::Camera(eye) => EdgeEnd::Camera(*eye),
            Vertex::Light(end) => EdgeEnd::Light(*end),
            Vertex::Surface(vertex) => EdgeEnd::Surface(&vertex.point),
            Vertex::Medium(point) => EdgeEnd::Medium(point.p, point.extinction),
        }
    }

    /// Returns it as the origin of an edge of a subpath.
    #[inline]
    pub(super) fn origin(&self) -> EdgeOrigin {
        match self {
            Vertex::Surface(SurfaceVertex { point: SurfacePoint { p, ng, .. }, .. })
            | Vertex::Light(EmitterPoint::Surface { p, ng, .. }) => EdgeOrigin::Surface { p: *p, ng: *ng },
            Vertex::Light(EmitterPoint::Point(p)) => EdgeOrigin::Point(*p),
            Vertex::Camera(_) | Vertex::Light(EmitterPoint::Distant) => EdgeOrigin::Distant,
            Vertex::Medium(MediumPoint { p, extinction, .. }) => EdgeOrigin::Medium { p: *p, extinction: *extinction },
        }
    }
}
