//! Reconstructs the path of a technique of a seed sample: replays its subpaths with the same random numbers and stores
//! all vertices.

use super::super::ChainContext;
use super::extend::SubpathBuffer;
use super::state::Proposal;
use crate::bsdf::Lobes;
use crate::path::{Arrival, Emitter, MisStrategy, PathVertex, Subpath, TraceStats};
use crate::sampling::{Address, Heuristic, IndependentSampler, Sampler, Slot};
use glam::DVec3;

/// A replayed subpath, and whether it left the scene.
struct SubpathEnd {
    part: SubpathBuffer,
    leaves: bool,
}

/// Replays the first `count` vertices of a subpath, without scattering at the last.
fn walk(
    common: &ChainContext,
    mut path: Subpath,
    sampler: &mut IndependentSampler,
    count: usize,
    tally: &mut TraceStats,
    from_camera: bool,
) -> Option<SubpathEnd> {
    let mut part = SubpathBuffer::default();
    for i in 1..=count {
        let w = path.walk.ray.direction.as_dvec3();
        part.directions.push(if from_camera { -w } else { w });
        let Arrival::Vertex(vertex) = path.arrive(&common.camera, sampler, tally) else {
            return (i == count).then_some(SubpathEnd { part, leaves: true });
        };
        let lobe = if i == count { Lobes::SMOOTH } else { path.go_on(&vertex, &vertex.scatterer()?, sampler, tally)? };
        part.nodes.push(PathVertex::new(&vertex, lobe)?);
    }
    Some(SubpathEnd { part, leaves: false })
}

/// Returns the path of `s` light and `t` camera vertices of the sample at `address`.
pub(super) fn path(
    common: &ChainContext,
    [s, t]: [usize; 2],
    address: Address,
    tally: &mut TraceStats,
) -> Option<Proposal> {
    // The MIS weights are unused.
    let weights = MisStrategy {
        techniques: common.options.method.bdpt().techniques,
        heuristic: Heuristic::Balance,
        light_walks: 1.0,
    };
    let [mut camera, mut light] = [0, 1].map(|stream| IndependentSampler::new(address.with(stream)));
    let sample = common.camera_sample(&mut camera);
    let path = Subpath::from_camera(common.scene, &weights, &sample);
    let SubpathEnd { part: mut from_camera, leaves } = walk(common, path, &mut camera, t - 1, tally, true)?;
    from_camera.lens = sample.lens;
    match s {
        0 => {
            let (emitter, w) = from_camera.found_light(common.scene, !leaves)?;
            Proposal::join(common, emitter, SubpathBuffer::default(), w, from_camera)
        }
        1 if !leaves => {
            let (z, bounce) = (from_camera.nodes.last()?.vertex.context()?, t as u32 - 2);
            let u = camera.u2(bounce, Slot::LightPoint);
            let (emitter, w) = Emitter::chosen(common.scene, &z, u, || camera.u1(bounce, Slot::LightPick))?;
            Proposal::join(common, emitter, SubpathBuffer::default(), w, from_camera)
        }
        _ if !leaves => {
            let (path, emitter) = Subpath::from_light(common.scene, &weights, &mut light)?;
            let SubpathEnd { part: from_light, leaves } = walk(common, path, &mut light, s - 1, tally, false)?;
            let y = from_light.nodes.last()?.p().as_dvec3();
            let across = match from_camera.nodes.last() {
                Some(z) => (z.p().as_dvec3() - y).try_normalize()?,
                None => {
                    // The number of the vertex in its subpath is the bounce of its random numbers.
                    from_camera.lens = common.camera.sample_lens(|| light.u2(s as u32 - 1, Slot::Lens));
                    DVec3::ZERO
                }
            };
            if leaves { None } else { Proposal::join(common, emitter, from_light, across, from_camera) }
        }
        _ => None,
    }
}
