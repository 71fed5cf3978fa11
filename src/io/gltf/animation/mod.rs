//! Nodes at one time of the file's animations: translations, rotations and scales in place of their own [glTF20 §3.11].
//!
//! All animations are played together, since exporters write one for each object; where two move the same part of a node
//! the later one does. Before the first key and after the last one nothing moves. Morph targets are not read, so neither
//! are animations of their weights; KHR_animation_pointer is not read.

mod curve;
mod sampler;

use super::document::{Document, name_or};
use super::notes::Notes;
use crate::error::{Error, Result};
use glam::{DQuat, DVec3};
use sampler::{Moments, Sampler};
use serde::Deserialize;
use std::collections::HashMap;

/// What moves, where it is at the time.
#[derive(Default)]
pub(super) struct Pose {
    nodes: HashMap<usize, Moved>,
    /// The last key's time in seconds; `None` if no node is animated.
    pub(super) end: Option<f64>,
}

/// What stands in place of a node's own translation, rotation and scale.
#[derive(Default)]
pub(super) struct Moved {
    pub(super) translation: Option<DVec3>,
    pub(super) rotation: Option<DQuat>,
    pub(super) scale: Option<DVec3>,
}

#[derive(Deserialize)]
struct Animation {
    name: Option<String>,
    #[serde(default)]
    channels: Vec<Channel>,
    #[serde(default)]
    samplers: Vec<Sampler>,
}

#[derive(Deserialize)]
struct Channel {
    sampler: usize,
    target: Target,
}

#[derive(Deserialize)]
struct Target {
    /// Extensions may have other targets.
    node: Option<usize>,
    path: Property,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Property {
    Own(Part),
    /// Weights of morph targets, and what extensions animate.
    Other(String),
}

/// A part of a node's transform.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Part {
    Translation,
    Rotation,
    Scale,
}

/// The file's animations at a time in seconds.
///
/// # Errors
/// A scene error that names the animation if one is not valid.
pub(super) fn pose(document: &Document, seconds: f64, notes: &mut Notes) -> Result<Pose> {
    let animations = Option::<Vec<Animation>>::deserialize(&document.animations);
    let animations = animations.map_err(|e| Error::scene("the animations are not valid").because(e))?;
    let mut player = Player { document, moments: Moments::at(seconds), pose: Pose::default() };
    for (index, animation) in animations.into_iter().flatten().enumerate() {
        let named = |e: Error| e.context(format!("animation '{}'", name_or(&animation.name, "animation", index)));
        for channel in &animation.channels {
            player.play(channel, &animation.samplers, notes).map_err(named)?;
        }
    }
    Ok(player.pose)
}

impl Pose {
    /// What is moved of a node.
    pub(super) fn of(&self, node: usize) -> Option<&Moved> {
        self.nodes.get(&node)
    }
}

struct Player<'a> {
    document: &'a Document,
    moments: Moments,
    pose: Pose,
}

impl Player<'_> {
    fn play(&mut self, channel: &Channel, samplers: &[Sampler], notes: &mut Notes) -> Result<()> {
        let (node, part) = match (channel.target.node, &channel.target.path) {
            (Some(node), Property::Own(part)) => (node, *part),
            (_, Property::Other(other)) if other == "weights" => {
                notes.add("animations of morph targets are not played: the meshes are shown as modelled");
                return Ok(());
            }
            _ => {
                notes.add("animations of anything but the translation, rotation and scale of nodes are not played");
                return Ok(());
            }
        };
        let source = self.document.root.nodes.get(node);
        let source = source.ok_or_else(|| Error::scene(format!("a channel moves node {node}, which does not exist")))?;
        let name = name_or(&source.name, "node", node);
        if source.matrix.is_some() {
            return Err(Error::scene(format!("it moves node '{name}', which has a matrix, and the two exclude each other")));
        }
        let sampler = samplers.get(channel.sampler);
        let sampler = sampler.ok_or_else(|| Error::scene(format!("there is no sampler {}", channel.sampler)))?;
        self.put(node, part, sampler).map_err(|e| e.context(format!("{} of node '{name}'", part.name())))
    }

    fn put(&mut self, node: usize, part: Part, sampler: &Sampler) -> Result<()> {
        let moment = self.moments.of(self.document, sampler.input)?;
        let moved = self.pose.nodes.entry(node).or_default();
        match part {
            Part::Translation => moved.translation = Some(sampler.vector(self.document, moment)?),
            Part::Rotation => moved.rotation = Some(sampler.rotation(self.document, moment)?),
            Part::Scale => moved.scale = Some(sampler.vector(self.document, moment)?),
        }
        self.pose.end = Some(self.pose.end.map_or(moment.end, |end| end.max(moment.end)));
        Ok(())
    }
}

impl Part {
    fn name(self) -> &'static str {
        match self {
            Part::Translation => "translation",
            Part::Rotation => "rotation",
            Part::Scale => "scale",
        }
    }
}
