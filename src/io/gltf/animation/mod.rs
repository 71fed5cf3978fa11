//! Nodes at one time of the file's animations: translations, rotations and scales in place of their own [glTF20 §3.11].
//!
//! One animation is played if it was chosen. Else all are together, since exporters write one for each object; where two move the
//! same part of a node the later one does, which is noted. Before the first key and after the last one nothing moves. Morph targets are not read, so neither
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
#[derive(Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Part {
    Translation,
    Rotation,
    Scale,
}

/// Names of the file's animations in their order, made up where they have none.
pub(super) fn names(document: &Document) -> Vec<String> {
    let animations = document.animations.as_array().into_iter().flatten();
    let name = |a: &serde_json::Value| a["name"].as_str().map(str::to_owned);
    animations.enumerate().map(|(index, animation)| name_or(&name(animation), "animation", index)).collect()
}

/// The file's animations at a time in seconds, or the one with the name or number `only`.
///
/// # Errors
/// A scene error that names the animation if one is not valid; a usage error that names all if there is no such one.
pub(super) fn pose(document: &Document, seconds: f64, only: Option<&str>, notes: &mut Notes) -> Result<Pose> {
    let only = only.map(|wanted| choose(&names(document), wanted)).transpose()?;
    let animations = Option::<Vec<Animation>>::deserialize(&document.animations);
    let animations = animations.map_err(|e| Error::scene("the animations are not valid").because(e))?;
    let (moments, moved_by) = (Moments::at(seconds), HashMap::new());
    let mut player = Player { document, moments, pose: Pose::default(), moved_by, conflict: None };
    for (index, animation) in animations.into_iter().flatten().enumerate().filter(|(i, _)| only.is_none_or(|only| only == *i)) {
        let name = name_or(&animation.name, "animation", index);
        for channel in &animation.channels {
            player.play(channel, &animation.samplers, &name, notes).map_err(|e| e.context(format!("animation '{name}'")))?;
        }
    }
    player.conflict.into_iter().for_each(|conflict| notes.add(conflict));
    Ok(player.pose)
}

/// The place of the animation that is called `wanted`, else of that number.
fn choose(names: &[String], wanted: &str) -> Result<usize> {
    let by_number = || wanted.parse().ok().filter(|&i: &usize| i < names.len());
    names.iter().position(|name| name == wanted).or_else(by_number).ok_or_else(|| {
        let all: Vec<String> = names.iter().enumerate().map(|(i, name)| format!("{i} '{name}'")).collect();
        let has = if all.is_empty() { "none".to_owned() } else { all.join(", ") };
        Error::usage(format!("no animation '{wanted}' in the scene, which has {has}"))
    })
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
    /// Which animation moves each part of each node.
    moved_by: HashMap<(usize, Part), String>,
    /// What is said where two move the same.
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
        let source = source.ok_or_else(|| Error::scene(format!("a channel moves node {node}, which does not exist")))?;
        let name = name_or(&source.name, "node", node);
        if source.matrix.is_some() {
            return Err(Error::scene(format!("it moves node '{name}', which has a matrix, and the two exclude each other")));
        }
        let sampler = samplers.get(channel.sampler);
        let sampler = sampler.ok_or_else(|| Error::scene(format!("there is no sampler {}", channel.sampler)))?;
        if let Some(earlier) = self.moved_by.insert((node, part), animation.to_owned()) {
            let what = format!("animations '{earlier}' and '{animation}' both move the {} of node '{name}'", part.name());
            self.conflict.get_or_insert_with(|| format!("{what}, where the later one is played: --animation plays one alone"));
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
