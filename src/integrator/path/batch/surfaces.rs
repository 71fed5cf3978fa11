//! Surfaces and shading normals that vary from point to point.
//!
//! Textures of colour, roughness and metalness have kernels: the texels of all lanes are asked for before the first is
//! read, and models are chosen over lanes. Other surfaces are made by [`Scene::surface`], lane by lane.

use super::lane_sets::LaneSets;
use super::objects::ObjectRow;
use super::paths::Paths;
use super::points::{Points, in_lanes};
use crate::bsdf::Surface;
use crate::bsdf::lanes::{LaneMetallicRoughness, LaneModel, LaneSurface, Parameters};
use crate::geometry::{Bodies, Frame, Hits, SurfacePoint};
use crate::scene::Scene;
use crate::texture::Footprint;
use etendue_lanes::{Float, MOST_LANES, Mask, ROW, Vec3, for_each_bit};

/// Varying surfaces of a group, by lane.
pub(super) struct VaryingSurfaces {
    /// Parameters of their models.
    pub(super) parameters: [Parameters; MOST_LANES],
    /// What lookups of colour, of roughness and metalness, and of the normal read.
    footprints: [[Footprint; 3]; MOST_LANES],
    /// Values of both textures.
    values: [[f32; ROW]; MOST_LANES],
}

impl VaryingSurfaces {
    pub(super) fn new() -> Self {
        VaryingSurfaces {
            parameters: [Parameters::default(); MOST_LANES],
            footprints: [[Footprint::default(); 3]; MOST_LANES],
            values: [[0.0; ROW]; MOST_LANES],
        }
    }
}

/// Finds the surfaces of a group.
pub(super) struct SurfaceFinder<'s, 'a> {
    pub(super) scene: &'s Scene,
    pub(super) rows: &'s [ObjectRow<'a>],
    pub(super) paths: &'s Paths,
    pub(super) hits: &'s Hits,
    pub(super) found: &'s mut VaryingSurfaces,
    /// Number of the first path.
    pub(super) at: usize,
}

impl SurfaceFinder<'_, '_> {
    /// Finds the varying surfaces of a group, and returns its shading normals.
    #[inline(never)]
    pub(super) fn resolve<F: Float>(&mut self, points: &Points<F>, lanes: &mut LaneSets) -> Vec3<F> {
        let [textured, mapped] = self.prefetch(points, lanes.varying);
        let mut normals = [glam::Vec3::ZERO; MOST_LANES];
        for (lane, ng) in normals.iter_mut().enumerate().take(F::LANES) {
            *ng = points.ng.lane(lane).into();
        }
        for_each_bit(lanes.bent, |lane| {
            let (geometry, hit) = (self.scene.geometry(), self.hits.hit(self.at + lane));
            normals[lane] = SurfacePoint::shading_normal(geometry, hit, points.weights(lane), normals[lane]);
        });
        for_each_bit(lanes.varying & !textured, |lane| {
            normals[lane] = self.find(self.point(lane, points, normals[lane]), lane, lanes);
        });
        if textured != 0 {
            for_each_bit(textured, |lane| self.look_up(lane));
            self.choose::<F>(textured, lanes);
            for_each_bit(mapped, |lane| normals[lane] = self.bent(lane, points, normals[lane]));
        }
        let column = |axis: usize| F::from_fn(|lane| normals[lane][axis]);
        Vec3::new(column(0), column(1), column(2))
    }

    /// Returns the object in `lane`.
    #[inline(always)]
    fn object(&self, lane: usize) -> &ObjectRow<'_> {
        &self.rows[self.hits.objects[self.at + lane] as usize]
    }

    /// Returns the point of a lane with the shading normal `n`.
    fn point<F: Float>(&self, lane: usize, points: &Points<F>, n: glam::Vec3) -> SurfacePoint {
        SurfacePoint {
            p: points.p.lane(lane).into(),
            error: points.error.lane(lane),
            ng: points.ng.lane(lane).into(),
            frame: Frame::around(n),
            barycentric: points.weights(lane),
            hit: self.hits.hit(self.at + lane),
            t: 0.0,
            touching: false,
            consistent: true,
        }
    }

    /// Finds the varying surface at `point` in `lane`, and returns the shading normal.
    fn find(&mut self, mut point: SurfacePoint, lane: usize, lanes: &mut LaneSets) -> glam::Vec3 {
        let bodies = self.paths.rare.get(self.at + lane).map_or(Bodies::NONE, |rare| rare.state.bodies);
        let surface = self.scene.surface(&mut point, bodies);
        match LaneSurface::new(&surface) {
            Some(LaneSurface { model, parameters }) => {
                lanes.add(model, 1 << lane);
                self.found.parameters[lane] = parameters;
            }
            None if matches!(*surface, Surface::Black) => {}
            None => lanes.single |= 1 << lane,
        }
        point.frame.n
    }

    /// Returns which of the given lanes have textured surfaces, and which of these a normal map. Asks for their texels.
    fn prefetch<F: Float>(&mut self, points: &Points<F>, lanes: u32) -> [u32; 2] {
        let geometry = self.scene.geometry();
        let (mut textured, mut mapped) = (0, 0);
        for_each_bit(lanes, |lane| {
            let (hit, barycentric) = (self.hits.hit(self.at + lane), points.weights(lane));
            let Some(surface) = &self.rows[hit.object as usize].textured else { return };
            textured |= 1 << lane;
            mapped |= u32::from(surface.textures[2].is_some()) << lane;
            let mut footprint = Footprint::default();
            for (slot, texture) in surface.textures.into_iter().enumerate() {
                let Some(texture) = texture else { continue };
                if !surface.follows[slot] {
                    footprint = texture.footprint(geometry.uv(hit, barycentric, texture.uv_set));
                }
                texture.prefetch(footprint);
                self.found.footprints[lane][slot] = footprint;
            }
        });
        [textured, mapped]
    }

    /// Returns the value of texture number `slot` in a lane, 1 where there is none.
    #[inline(always)]
    fn value(&self, lane: usize, slot: usize) -> [f32; 4] {
        let texture = self.object(lane).textured.as_ref().and_then(|surface| surface.textures[slot]);
        texture.map_or([1.0; 4], |texture| texture.value(self.found.footprints[lane][slot]))
    }

    /// Reads colour, roughness and metalness of a lane.
    fn look_up(&mut self, lane: usize) {
        let ([a, b, c, d], [e, f, g, h]) = (self.value(lane, 0), self.value(lane, 1));
        self.found.values[lane] = [a, b, c, d, e, f, g, h];
    }

    /// Returns the normal `n` of a lane as its normal map bends it.
    fn bent<F: Float>(&self, lane: usize, points: &Points<F>, n: glam::Vec3) -> glam::Vec3 {
        let mut point = self.point(lane, points, n);
        self.scene.bend(&mut point, self.value(lane, 2));
        point.frame.n
    }

    /// Chooses the models of the `textured` lanes.
    fn choose<F: Float>(&mut self, textured: u32, lanes: &mut LaneSets) {
        let rows = in_lanes(textured, |lane| &self.object(lane).parameters);
        let values = in_lanes(textured, |lane| &self.found.values[lane]);
        let factors = [F::rows(|lane| &rows[lane][0]), F::rows(|lane| &rows[lane][1])];
        let chosen = LaneMetallicRoughness::<F>::new(factors, F::rows(|lane| values[lane]));
        lanes.add(LaneModel::Lambert, chosen.lambert.bits() & textured);
        lanes.add(LaneModel::Conductor, chosen.conductor.bits() & textured);
        lanes.add(LaneModel::MetalDielectric, chosen.metal_dielectric.bits() & textured);
        lanes.single |= chosen.mirror.bits() & textured;
        chosen.store(textured, &mut self.found.parameters);
    }
}
