//! Selection of initial chain states among weighted samples.

/// Systematic resampling. Returns `count` indices into `weights`, each with a probability proportional to its weight.
/// The multiplicity of an index differs from its expectation by less than one: positions are equally spaced in the
/// cumulative weights, with a common `offset` in [0, 1). `None` if the weights sum to zero.
///
/// With the mean of `weights` as the weight of each chosen sample, sums over the chosen samples have the expectation of
/// weighted sums over all, for any number of samples.
pub fn stratified(weights: &[f64], count: usize, offset: f64) -> Option<Vec<usize>> {
    let total: f64 = weights.iter().sum();
    if total <= 0.0 {
        return None;
    }
    let spacing = total / count as f64;
    let (mut chosen, mut upto) = (Vec::with_capacity(count), 0.0);
    for (index, &weight) in weights.iter().enumerate().filter(|&(_, &weight)| weight > 0.0) {
        upto += weight;
        while chosen.len() < count && (chosen.len() as f64 + offset) * spacing < upto {
            chosen.push(index);
        }
    }
    // Rounding may place the last position beyond the sum.
    let last = weights.iter().rposition(|&weight| weight > 0.0)?;
    chosen.resize(count, last);
    Some(chosen)
}
