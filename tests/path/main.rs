//! Path space: what walks and connections say of a path against what the explicit evaluator finds by definition. No
//! statistics: every identity must hold on every path.

mod edges;
mod identities;
mod made;
