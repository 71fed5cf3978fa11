//! Recorded rays in the order they were traced, and the groups that rates and hits are told for.

use crate::accel::{Question, RayClass};
use crate::geometry::Ray;

/// The groups of tables; bounces of a depth and more are one.
const GROUPS: [&str; 6] = ["camera", "bounce-1", "bounce-2", "bounce-3", "bounce-4+", "shadow"];

/// The first bounce of the last group of bounces.
const DEEP: u32 = 4;

/// Rays of a scene.
#[derive(Debug, Clone)]
pub struct Stream {
    /// What it is called in addresses.
    pub name: String,
    /// Hash of the scene that they were traced in.
    pub scene_hash: String,
    /// The rays in order.
    pub questions: Vec<Question>,
}

/// Rays of one group of classes.
pub(super) struct Group {
    pub(super) name: &'static str,
    /// In the order of the stream. Copies, side by side: picked from the stream, one in five, each would wait for memory longer
    /// than for its answer.
    pub(super) questions: Vec<Question>,
}

impl Group {
    /// Its rays.
    pub(super) fn rays(&self) -> Vec<Ray> {
        self.questions.iter().map(|question| question.ray).collect()
    }
}

impl Stream {
    /// The groups that have rays.
    pub(super) fn groups(&self) -> Vec<Group> {
        let mut groups: Vec<Group> = GROUPS.iter().map(|&name| Group { name, questions: Vec::new() }).collect();
        for &question in &self.questions {
            groups[group_of(question.class)].questions.push(question);
        }
        groups.retain(|group| !group.questions.is_empty());
        groups
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
    use crate::accel::Query;
    use glam::Vec3;

    #[test]
    fn every_ray_is_in_one_group_in_order() {
        let classes = [0, 4, 1, 9, 2, 3, 0].map(|d| if d == 0 { RayClass::Camera } else { RayClass::Bounce(d) });
        let ask = |(i, class)| Question { ray: Ray::new(Vec3::X * i as f32, Vec3::Z), query: Query::Closest, class };
        let questions = classes.into_iter().chain([RayClass::Shadow]).enumerate().map(ask).collect();
        let stream = Stream { name: "a".into(), scene_hash: String::new(), questions };
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
