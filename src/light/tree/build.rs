//! Construction of light trees: groups of lights are split where the cost of the parts is least, until a node has eight.

use super::node::{LEAF, Node, WIDTH};
use super::reach::Reach;
use glam::Vec3;

/// Bins along each axis.
const BINS: usize = 12;

/// Number of lights from which the subtrees of a node are built in parallel.
const PARALLEL: usize = 4096;

/// A light and its bounds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item {
    pub(super) light: u32,
    pub(super) reach: Reach,
}

impl Item {
    fn centre(&self) -> Vec3 {
        self.reach.bounds.center()
    }
}

/// Returns the nodes of a tree over `items`, of which there is at least one, the root first. Intensities are in units of
/// `unit`. Numbers are of the nodes in the list.
pub(super) fn grow(items: &mut [Item], unit: f64) -> Vec<Node> {
    let parts = parts(items);
    let whole = items.len();
    let mut rest = items;
    let mut groups = Vec::with_capacity(parts.len());
    for size in parts {
        let (group, others) = rest.split_at_mut(size);
        groups.push(group);
        rest = others;
    }
    let bounds = groups.iter().map(|group| union(group)).collect::<Vec<_>>();
    let subtree = |group: &mut [Item]| if group.len() > 1 { grow(group, unit) } else { Vec::new() };
    let leaves: Vec<u32> = groups.iter().map(|group| group[0].light | LEAF).collect();
    let subtrees: Vec<Vec<Node>> = if whole >= PARALLEL {
        use rayon::prelude::*;
        groups.into_par_iter().map(subtree).collect()
    } else {
        groups.into_iter().map(subtree).collect()
    };
    joined(subtrees, &leaves, &bounds, unit)
}

/// Returns a node above `subtrees`, and their nodes. An empty one stands for the leaf at its place.
fn joined(subtrees: Vec<Vec<Node>>, leaves: &[u32], bounds: &[Reach], unit: f64) -> Vec<Node> {
    let mut next = 1;
    let place = |(subtree, &leaf): (&Vec<Node>, &u32)| {
        let child = if subtree.is_empty() { leaf } else { next };
        next += subtree.len() as u32;
        child
    };
    let children: Vec<u32> = subtrees.iter().zip(leaves).map(place).collect();
    let children: Vec<(u32, Reach)> = children.into_iter().zip(bounds.iter().copied()).collect();
    let mut nodes = Vec::with_capacity(next as usize);
    nodes.push(Node::new(&children, unit));
    for (slot, (subtree, (first, _))) in subtrees.into_iter().zip(children).enumerate() {
        let begin = nodes.len();
        nodes.extend(subtree.into_iter().map(|node| node.renumbered(first)));
        if let Some(root) = nodes.get_mut(begin) {
            root.parent = (0, slot as u32);
        }
    }
    nodes
}

/// Orders `items` into at most eight groups, and returns their sizes.
fn parts(items: &mut [Item]) -> Vec<usize> {
    let mut sizes = vec![(items.len(), union(items).cost())];
    while sizes.len() < WIDTH.min(items.len()) {
        // Lights that cannot be told apart have no cost; they are halved last.
        let splittable = sizes.iter().enumerate().filter(|(_, (size, _))| *size > 1);
        let largest = splittable.max_by(|(_, a), (_, b)| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let Some((place, &(size, _))) = largest else { break };
        let start: usize = sizes[..place].iter().map(|(size, _)| size).sum();
        let group = &mut items[start..start + size];
        let first = split(group);
        let (a, b) = group.split_at(first);
        sizes.splice(place..=place, [(a.len(), union(a).cost()), (b.len(), union(b).cost())]);
    }
    sizes.into_iter().map(|(size, _)| size).collect()
}

fn union(items: &[Item]) -> Reach {
    items.iter().fold(Reach::NOTHING, |all, item| all.union(&item.reach))
}

/// Orders `items`, at least two, into two groups, and returns the size of the first.
fn split(items: &mut [Item]) -> usize {
    let (low, high) = items.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), item| {
        (low.min(item.centre()), high.max(item.centre()))
    });
    let extent = high - low;
    let longest = extent.max_element();
    let best = (0..3)
        .filter(|&axis| extent[axis] > 0.0)
        .filter_map(|axis| {
            let bin = bins(axis, low, extent);
            let (cost, last) = cheapest(items, &bin)?;
            // Thin boxes are not split across their short sides [ContyKulla18 §4.4].
            Some((cost * f64::from(longest / extent[axis]), axis, last))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, axis, last)) = best else { return items.len() / 2 };
    let bin = bins(axis, low, extent);
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
fn bins(axis: usize, low: Vec3, extent: Vec3) -> impl Fn(&Item) -> usize {
    let scale = BINS as f32 / extent[axis];
    move |item| (((item.centre()[axis] - low[axis]) * scale) as usize).min(BINS - 1)
}

/// Returns the least cost of two groups of bins, neither empty, and the last bin of the first one.
fn cheapest(items: &[Item], bin: &impl Fn(&Item) -> usize) -> Option<(f64, usize)> {
    let mut bounds = [Reach::NOTHING; BINS];
    items.iter().for_each(|item| bounds[bin(item)] = bounds[bin(item)].union(&item.reach));
    let mut above = [Reach::NOTHING; BINS];
    for i in (0..BINS - 1).rev() {
        above[i] = above[i + 1].union(&bounds[i + 1]);
    }
    let mut below = Reach::NOTHING;
    let costs = (0..BINS - 1).filter_map(|last| {
        below = below.union(&bounds[last]);
        let both = !below.bounds.is_empty() && !above[last].bounds.is_empty();
        both.then(|| (below.cost() + above[last].cost(), last))
    });
    costs.min_by(|a, b| a.0.total_cmp(&b.0))
}
