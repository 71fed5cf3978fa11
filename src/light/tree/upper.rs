//! The light tree as a hierarchy of groups with upper bounds, for cuts of a bounded error.

use super::LightTree;
use super::node::LEAF;
use crate::light::LightSampleContext;

/// A group of lights: all below a node, or one light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LightGroup(u32);

impl LightGroup {
    /// All lights of a tree.
    pub const ALL: LightGroup = LightGroup(0);

    /// Returns the light, if it is a single one.
    pub fn light(self) -> Option<usize> {
        (self.0 & LEAF != 0).then_some((self.0 & !LEAF) as usize)
    }
}

impl LightTree {
    /// Returns the parts of `group` that can reach the receiver `at`, each with an upper bound of cos (`diffuse` cos_x +
    /// `glossy`) / d² over all its lights: cos is the cosine to a light's normal, cos_x that to the receiver's.
    ///
    /// # Panics
    /// `group` is a single light.
    pub fn parts(
        &self,
        group: LightGroup,
        at: &LightSampleContext,
        diffuse_glossy: [f32; 2],
    ) -> impl Iterator<Item = (LightGroup, f32)> {
        let node = &self.nodes[group.0 as usize];
        let parts = node.children.into_iter().zip(node.upper(at, diffuse_glossy));
        parts.filter(|part| part.1 > 0.0).map(|(id, upper)| (LightGroup(id), upper))
    }

    /// Joins the values of the lights of each node by `join`, from its parts to the whole. The value of a
    /// [`LightGroup`] of several lights is at its place.
    pub fn joined<T: Copy>(&self, light: impl Fn(usize) -> T, join: impl Fn(T, T) -> T) -> GroupValues<T> {
        let mut values: Vec<Option<T>> = vec![None; self.nodes.len()];
        // Parts follow their node.
        for id in (0..self.nodes.len()).rev() {
            let parts = self.nodes[id].occupied().map(|part| match LightGroup(part).light() {
                Some(number) => light(number),
                None => values[part as usize].expect("a node has parts"),
            });
            values[id] = parts.reduce(&join);
        }
        GroupValues(values.into_iter().flatten().collect())
    }
}

/// A value of each group of several lights.
#[derive(Debug)]
pub struct GroupValues<T>(Vec<T>);

impl<T: Copy> GroupValues<T> {
    /// Returns the value of `group`, or that of its light by `light`.
    pub fn of(&self, group: LightGroup, light: impl FnOnce(usize) -> T) -> T {
        group.light().map_or_else(|| self.0[group.0 as usize], light)
    }
}
