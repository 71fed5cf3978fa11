//! Rates of convergence: the slope of a line in logarithms.

/// Least-squares slope of ln y over ln x.
pub fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (x.ln(), y.ln())).collect();
    let (mx, my) = (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let products: f64 = logs.iter().map(|(x, y)| (x - mx) * (y - my)).sum();
    products / logs.iter().map(|(x, _)| (x - mx).powi(2)).sum::<f64>()
}

#[test]
fn the_slope_of_a_power_is_its_exponent() {
    let points: Vec<(f64, f64)> = (1..9).map(|k| f64::from(1 << k)).map(|x| (x, 3.0 * x.powf(-1.5))).collect();
    assert!((slope(&points) + 1.5).abs() < 1e-12); // f64 sums
}
