//! Path space: what walks and connections say of a path against what the explicit evaluator finds by definition. No
//! statistics: every identity must hold on every path.

#[path = "../support/deep.rs"]
mod deep;
#[allow(dead_code, reason = "tests/sampling uses what is not used here")]
#[path = "../support/random.rs"]
mod random;
#[allow(dead_code, reason = "tests/agreement uses what is not used here")]
#[path = "../agreement/studio.rs"]
mod studio;

mod edges;
mod identities;
mod made;
mod worlds;
