//! The path that a technique of a seed sample makes: its walks again, with the same numbers, and all of their vertices kept.

use super::super::Common;
use super::extend::Part;
use super::state::Draft;
use crate::bsdf::Lobes;
use crate::path::{Arrival, Emitter, Node, Subpath, Tally, Weights};
use crate::sampling::{Address, Heuristic, Independent, Sampler, Slot};

/// What a walk came to: its vertices, and the direction in which it left the scene, if it did.
struct Walked {
    part: Part,
    leaves: bool,
}

/// The first `count` vertices of a walk. The last is not left.
fn walk(
    common: &Common,
    mut path: Subpath,
    sampler: &mut Independent,
    count: usize,
    tally: &mut Tally,
    from_camera: bool,
) -> Option<Walked> {
    let mut part = Part::default();
    for i in 1..=count {
        let w = path.walk.ray.direction.as_dvec3();
        part.directions.push(if from_camera { -w } else { w });
        let Arrival::Surface(vertex) = path.arrive(&common.camera, sampler, tally) else {
            return (i == count).then_some(Walked { part, leaves: true });
        };
        let lobe = if i == count { Lobes::SMOOTH } else { path.go_on(&vertex, &vertex.shading()?, sampler, tally)? };
        part.nodes.push(Node::new(&vertex, lobe));
    }
    Some(Walked { part, leaves: false })
}

/// The path of `s` vertices from the light and `t` from the camera of the sample at `address`.
pub(super) fn path(common: &Common, [s, t]: [usize; 2], address: Address, tally: &mut Tally) -> Option<Draft> {
    // No weights are asked for.
    let weights = Weights { techniques: common.options.techniques, heuristic: Heuristic::Balance, light_walks: 1.0 };
    let [mut camera, mut light] = [0, 1].map(|stream| Independent::new(address.with(stream)));
    let film = common.region.at(camera.u2(0, Slot::Aux));
    let path = Subpath::from_camera(common.scene, &weights, common.camera.ray(film));
    let Walked { part: mut from_camera, leaves } = walk(common, path, &mut camera, t - 1, tally, true)?;
    match s {
        0 => {
            let (emitter, w) = from_camera.found_light(common.scene, !leaves)?;
            Some(Part::join(emitter, Part::default(), w, from_camera))
        }
        1 if !leaves => {
            let (z, bounce) = (&from_camera.nodes.last()?.point, t as u32 - 2);
            let (pick, u) = (camera.u1(bounce, Slot::LightPick), camera.u2(bounce, Slot::LightPoint));
            let (emitter, w) = Emitter::chosen(common.scene, z, pick, u)?;
            Some(Part::join(emitter, Part::default(), w, from_camera))
        }
        _ if !leaves => {
            let (path, emitter) = Subpath::from_light(common.scene, &weights, &mut light)?;
            let Walked { part: from_light, leaves } = walk(common, path, &mut light, s - 1, tally, false)?;
            let y = from_light.nodes.last()?.point;
            let across = match from_camera.nodes.last() {
                Some(z) => (z.point.p.as_dvec3() - y.p.as_dvec3()).try_normalize()?,
                None => common.camera.seen(y.p)?.toward.as_dvec3(),
            };
            (!leaves).then(|| Part::join(emitter, from_light, across, from_camera))
        }
        _ => None,
    }
}
