//! Recorded rays in trace order, and the groups for which rates and hits are reported.

use super::batch::Batch;
use crate::accel::RayClass;
use crate::geometry::Ray;
use crate::lab::bench_rays::RayQuery;

/// Groups in tables. Bounces from depth 4 on form one group.
const GROUPS: [&str; 6] = ["camera", "bounce-1", "bounce-2", "bounce-3", "bounce-4+", "shadow"];

/// Depth of the first bounce in the last group.
const DEEP: u32 = 4;

/// Rays of a scene.
#[derive(Debug, Clone)]
pub struct RayStream {
    /// Name in addresses.
    pub name: String,
    /// Hash of the scene in which they were traced.
    pub scene_hash: String,
    /// The rays in trace order.
    pub questions: Vec<RayQuery>,
}

/// Rays of one group of classes, or all rays of a stream.
pub(super) struct Group {
    pub(super) name: &'static str,
    /// Rays in stream order. They are contiguous copies: with one ray in five picked from the stream, each would take
    /// longer to fetch from memory than to trace.
    pub(super) questions: Vec<RayQuery>,
    /// The same rays in batches.
    pub(super) batches: Vec<Batch>,
}

impl Group {
    /// Returns the group of `questions`.
    pub(super) fn new(name: &'static str, questions: Vec<RayQuery>) -> Group {
        Group { name, batches: Batch::of(&questions), questions }
    }

    /// Returns its rays.
    pub(super) fn rays(&self) -> Vec<Ray> {
        self.questions.iter().map(|question| question.ray).collect()
    }
}

impl RayStream {
    /// Returns the groups that have rays.
    pub(super) fn groups(&self) -> Vec<Group> {
        let mut groups = GROUPS.map(|name| (name, Vec::new()));
        for &question in &self.questions {
            groups[group_of(question.class)].1.push(question);
        }
        let groups = groups.into_iter().filter(|(_, questions)| !questions.is_empty());
        groups.map(|(name, questions)| Group::new(name, questions)).collect()
    }
}

fn group_of(class: RayClass) -> usize {
    match class {
        RayClass::Camera => 0,
        RayClass::Bounce(depth) => depth.clamp(1, DEEP) as usize,
        RayClass::Shadow => GROUPS.len() - 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::bench_rays::Query;
    use glam::Vec3;

    #[test]
    fn every_ray_is_in_one_group_in_order() {
        let classes = [0, 4, 1, 9, 2, 3, 0].map(|d| if d == 0 { RayClass::Camera } else { RayClass::Bounce(d) });
        let ask = |(i, class)| RayQuery { ray: Ray::new(Vec3::X * i as f32, Vec3::Z), query: Query::Closest, class };
        let questions = classes.into_iter().chain([RayClass::Shadow]).enumerate().map(ask).collect();
        let stream = RayStream { name: "a".into(), scene_hash: String::new(), questions };
        let groups = stream.groups();
        let places = |group: &Group| group.rays().iter().map(|ray| ray.origin.x as u32).collect();
        let found: Vec<(&str, Vec<u32>)> = groups.iter().map(|group| (group.name, places(group))).collect();
        assert_eq!(
            found,
            [
                ("camera", vec![0, 6]),
                ("bounce-1", vec![2]),
                ("bounce-2", vec![4]),
                ("bounce-3", vec![5]),
                ("bounce-4+", vec![1, 3]),
                ("shadow", vec![7])
            ]
        );
    }
}
