//! Node transforms at one time of the file's animations. Animated translations, rotations and scales replace the node's
//! own [glTF20 §3.11].
//!
//! If an animation was chosen, only this one is played. Otherwise all are played together, since exporters write one
//! per object. If two animate the same property of a node, the later one wins, and a note says so. Before the first key
//! and after the last one the pose is held. Morph targets are not read, and neither are animations of their weights.
//! KHR_animation_pointer is not read.

mod curve;
mod sampler;

use super::document::{Document, name_or};
use super::notes::Notes;
use crate::error::{Error, Result};
use glam::{DQuat, DVec3};
use sampler::{Moments, Sampler};
use serde::Deserialize;
use std::collections::HashMap;

/// Transforms of the animated nodes at the time.
#[derive(Default)]
pub(super) struct Pose {
    nodes: HashMap<usize, Moved>,
    /// Time of the last key in seconds; `None` if no node is animated.
    pub(super) end: Option<f64>,
}

/// Values that replace a node's own translation, rotation and scale.
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
    /// Absent if an extension defines another target.
    node: Option<usize>,
    path: Property,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Property {
    Own(Part),
    /// Weights of morph targets, and properties animated by extensions.
    Other(String),
}

/// A property of a node's transform.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Part {
    Translation,
    Rotation,
    Scale,
}

/// Returns the names of the file's animations in order, with generated names for unnamed ones.
pub(super) fn names(document: &Document) -> Vec<String> {
    let animations = document.animations.as_array().into_iter().flatten();
    let name = |a: &serde_json::Value| a["name"].as_str().map(str::to_owned);
    animations.enumerate().map(|(index, animation)| name_or(&name(animation), "animation", index)).collect()
}

/// Evaluates the file's animations at a time in seconds, or the one with the name or number `only`.
///
/// # Errors
/// A scene error that names the animation if it is not valid. A usage error that lists all animations if there is no
/// such one.
pub(super) fn pose(document: &Document, seconds: f64, only: Option<&str>, notes: &mut Notes) -> Result<Pose> {
    let only = only.map(|wanted| choose(&names(document), wanted)).transpose()?;
    let animations = Option::<Vec<Animation>>::deserialize(&document.animations);
    let animations = animations.map_err(|e| Error::scene("the animations are not valid").because(e))?;
    let (moments, moved_by) = (Moments::at(seconds), HashMap::new());
    let mut player = Player { document, moments, pose: Pose::default(), moved_by, conflict: None };
    for (index, animation) in
        animations.into_iter().flatten().enumerate().filter(|(i, _)| only.is_none_or(|only| only == *i))
    {
        let name = name_or(&animation.name, "animation", index);
        for channel in &animation.channels {
            player
                .play(channel, &animation.samplers, &name, notes)
                .map_err(|e| e.context(format!("animation '{name}'")))?;
        }
    }
    player.conflict.into_iter().for_each(|conflict| notes.add(conflict));
    Ok(player.pose)
}

/// Returns the index of the animation with the name `wanted`, else with that number.
fn choose(names: &[String], wanted: &str) -> Result<usize> {
    let by_number = || wanted.parse().ok().filter(|&i: &usize| i < names.len());
    names.iter().position(|name| name == wanted).or_else(by_number).ok_or_else(|| {
        let all: Vec<String> = names.iter().enumerate().map(|(i, name)| format!("{i} '{name}'")).collect();
        let has = if all.is_empty() { "none".to_owned() } else { all.join(", ") };
        Error::usage(format!("no animation '{wanted}' in the scene, which has {has}"))
    })
}

impl Pose {
    /// Returns the animated values of a node.
    pub(super) fn of(&self, node: usize) -> Option<&Moved> {
        self.nodes.get(&node)
    }
}

struct Player<'a> {
    document: &'a Document,
    moments: Moments,
    pose: Pose,
    /// The animation of each property of each node.
    moved_by: HashMap<(usize, Part), String>,
    /// Note about two animations of the same property.
    conflict: Option<String>,
}

impl Player<'_> {
    fn play(&mut self, channel: &Channel, samplers: &[Sampler], animation: &str, notes: &mut Notes) -> Result<()> {
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
        let source =
            source.ok_or_else(|| Error::scene(format!("a channel moves node {node}, which does not exist")))?;
        let name = name_or(&source.name, "node", node);
        if source.matrix.is_some() {
            return Err(Error::scene(format!(
                "it moves node '{name}', which has a matrix, and the two exclude each other"
            )));
        }
        let sampler = samplers.get(channel.sampler);
        let sampler = sampler.ok_or_else(|| Error::scene(format!("there is no sampler {}", channel.sampler)))?;
        if let Some(earlier) = self.moved_by.insert((node, part), animation.to_owned()) {
            let what =
                format!("animations '{earlier}' and '{animation}' both move the {} of node '{name}'", part.name());
            self.conflict
                .get_or_insert_with(|| format!("{what}, where the later one is played: --animation plays one alone"));
        }
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
