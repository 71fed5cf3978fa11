//! Construction of light trees: groups of lights are split where the cost of the parts is least, until a node has eight.

use super::node::{LEAF, Node, WIDTH};
use super::reach::{Cone, Reach};
use crate::geometry::Bounds;
use glam::{DVec3, Vec3};

/// Bins along each axis.
const BINS: usize = 12;

/// Number of lights from which the subtrees of a node are built in parallel.
const PARALLEL: usize = 4096;

/// How many times as uncertain as light of one direction that of all directions is: the ratio of the solid angles of
/// [ContyKulla18 §4.4].
const ALL_DIRECTIONS: f64 = 4.0;

/// A light as construction sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item {
    light: u32,
    summary: Summary,
}

impl Item {
    pub(super) fn new(light: u32, reach: &Reach) -> Self {
        let one_way = !reach.two_sided && reach.normals.angle < Cone::ALL.angle;
        let axis = if one_way { reach.normals.axis * reach.intensity } else { DVec3::ZERO };
        Item { light, summary: Summary { bounds: reach.bounds, axis, intensity: reach.intensity } }
    }

    fn centre(&self) -> Vec3 {
        self.summary.bounds.center()
    }
}

/// What the cost of a group depends on. It is cheaper to join than [`Reach`].
#[derive(Debug, Clone, Copy)]
struct Summary {
    bounds: Bounds,
    /// Sum of the axes of lights that shine to one side, weighted by intensity.
    axis: DVec3,
    intensity: f64,
}

impl Summary {
    const NOTHING: Summary = Summary { bounds: Bounds::EMPTY, axis: DVec3::ZERO, intensity: 0.0 };

    fn of(items: &[Item]) -> Summary {
        items.iter().fold(Summary::NOTHING, |all, item| all.union(&item.summary))
    }

    fn union(&self, other: &Summary) -> Summary {
        Summary {
            bounds: self.bounds.union(other.bounds),
            axis: self.axis + other.axis,
            intensity: self.intensity + other.intensity,
        }
    }

    /// Returns an estimate of how uncertain the light of a group is: its intensity times the square of its size times the
    /// solid angle of its directions.
    fn cost(&self) -> f64 {
        let size2 = f64::from((self.bounds.max - self.bounds.min).max(Vec3::ZERO).length_squared());
        let aligned = self.axis.length() / self.intensity.max(f64::MIN_POSITIVE);
        // The mean of a cap of directions is (1 + cos) / 2 long: 1/2 for half a sphere, which is nearly as uncertain as
        // all of it. The root is within a tenth of the solid angle for caps of 30 and 60 degrees.
        let directions = 1.0 + (ALL_DIRECTIONS - 1.0) * (2.0 * (1.0 - aligned)).clamp(0.0, 1.0).sqrt();
        self.intensity * size2 * directions
    }
}

/// Nodes, the root first, and the bounds of all of their lights.
pub(super) struct Subtree {
    pub(super) nodes: Vec<Node>,
    reach: Reach,
}

/// Returns a tree over `items`, of which there is at least one. `reach` returns the bounds of a light; intensities are
/// in units of `unit`. Numbers are of the nodes in the list.
pub(super) fn grow(items: &mut [Item], reach: &(impl Fn(u32) -> Reach + Sync), unit: f64) -> Subtree {
    let (sizes, whole) = (sizes(items), items.len());
    let mut rest = items;
    let mut groups = Vec::with_capacity(sizes.len());
    for size in sizes {
        let (group, others) = rest.split_at_mut(size);
        groups.push(group);
        rest = others;
    }
    let child = |group: &mut [Item]| match group {
        [item] => Child::Light(item.light, reach(item.light)),
        _ => Child::Subtree(grow(group, reach, unit)),
    };
    let children: Vec<Child> = if whole >= PARALLEL {
        use rayon::prelude::*;
        groups.into_par_iter().map(child).collect()
    } else {
        groups.into_iter().map(child).collect()
    };
    joined(children, unit)
}

enum Child {
    Light(u32, Reach),
    Subtree(Subtree),
}

/// Returns the tree with a root above `children`.
fn joined(children: Vec<Child>, unit: f64) -> Subtree {
    let mut next = 1;
    let mut place = |child: &Child| match child {
        Child::Light(light, reach) => (light | LEAF, *reach),
        Child::Subtree(subtree) => {
            next += subtree.nodes.len() as u32;
            (next - subtree.nodes.len() as u32, subtree.reach)
        }
    };
    let rows: Vec<(u32, Reach)> = children.iter().map(&mut place).collect();
    let mut nodes = Vec::with_capacity(next as usize);
    nodes.push(Node::new(&rows, unit));
    for (slot, (child, (first, _))) in children.into_iter().zip(&rows).enumerate() {
        let Child::Subtree(subtree) = child else { continue };
        let begin = nodes.len();
        nodes.extend(subtree.nodes.into_iter().map(|node| node.renumbered(*first)));
        if let Some(root) = nodes.get_mut(begin) {
            root.parent = (0, slot as u32);
        }
    }
    let parts: Vec<Reach> = rows.into_iter().map(|(_, reach)| reach).collect();
    Subtree { nodes, reach: Reach::around(&parts) }
}

/// Orders `items` into at most eight groups, and returns their sizes.
fn sizes(items: &mut [Item]) -> Vec<usize> {
    let mut groups = vec![(items.len(), Summary::of(items).cost())];
    while groups.len() < WIDTH.min(items.len()) {
        let splittable = groups.iter().enumerate().filter(|(_, (size, _))| *size > 1);
        // Lights that cannot be told apart have no cost; they are halved last.
        let largest = splittable.max_by(|(_, a), (_, b)| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let Some((place, &(size, _))) = largest else { break };
        let start: usize = groups[..place].iter().map(|(size, _)| size).sum();
        let group = &mut items[start..start + size];
        let first = split(group);
        let (a, b) = group.split_at(first);
        groups.splice(place..=place, [(a.len(), Summary::of(a).cost()), (b.len(), Summary::of(b).cost())]);
    }
    groups.into_iter().map(|(size, _)| size).collect()
}

/// Orders `items`, at least two, into two groups, and returns the size of the first.
fn split(items: &mut [Item]) -> usize {
    let centres = Bounds::around(items.iter().map(Item::centre));
    let best = (0..3).filter(|&axis| centres.max[axis] > centres.min[axis]).filter_map(|axis| {
        let (cost, last) = cheapest(items, &bins(axis, &centres))?;
        Some((cost, axis, last))
    });
    let Some((_, axis, last)) = best.min_by(|a, b| a.0.total_cmp(&b.0)) else { return items.len() / 2 };
    let bin = bins(axis, &centres);
    let mut first = 0;
    for i in 0..items.len() {
        if bin(&items[i]) <= last {
            items.swap(i, first);
            first += 1;
        }
    }
    first
}

/// Returns the function that finds the bin of a light along `axis`.
fn bins(axis: usize, centres: &Bounds) -> impl Fn(&Item) -> usize {
    let low = centres.min[axis];
    let scale = BINS as f32 / (centres.max[axis] - low);
    move |item| (((item.centre()[axis] - low) * scale) as usize).min(BINS - 1)
}

/// Returns the least cost of two groups of bins, neither empty, and the last bin of the first one.
fn cheapest(items: &[Item], bin: &impl Fn(&Item) -> usize) -> Option<(f64, usize)> {
    let mut of = [Summary::NOTHING; BINS];
    for item in items {
        let bin = &mut of[bin(item)];
        *bin = bin.union(&item.summary);
    }
    let mut above = [Summary::NOTHING; BINS];
    for i in (0..BINS - 1).rev() {
        above[i] = above[i + 1].union(&of[i + 1]);
    }
    let mut below = Summary::NOTHING;
    let costs = (0..BINS - 1).filter_map(|last| {
        below = below.union(&of[last]);
        let both = !below.bounds.is_empty() && !above[last].bounds.is_empty();
        both.then(|| (below.cost() + above[last].cost(), last))
    });
    costs.min_by(|a, b| a.0.total_cmp(&b.0))
}
