//! Prints the tables of errors of the diffusion models as Markdown.

use diffusion::subsurface::Medium;
use diffusion::subsurface::diffusion::{Burley, Dipole, RadialProfile, beam};
use diffusion::subsurface::half_space::{diffuse_albedo, normal_albedo};
use diffusion::subsurface::inversion::{Colour, chiang, kulla_conty, medium_of, single_scattering_albedo};
use diffusion::subsurface::reference::{Bins, Incidence, Reflectance, Walk};

/// Rings from 0.1 to 10 mean free paths, twenty per decade.
const RINGS: Bins = Bins { first: 0.1, last: 10.0, count: 40 };

/// Single-scattering albedos of the tables, and colours.
const ALBEDOS: [f64; 6] = [0.2, 0.5, 0.8, 0.9, 0.95, 0.99];

type Profiles = Vec<Box<dyn RadialProfile>>;

/// Returns the sum over profiles of the light that leaves in ring `i`.
fn ring(profiles: &Profiles, i: usize) -> f64 {
    profiles.iter().map(|p| p.total() * (p.tail(RINGS.edge(i)) - p.tail(RINGS.edge(i + 1)))).sum()
}

/// Returns ∫ |M − R| r dr / ∫ R r dr over the rings, and the same with sign.
fn errors(profiles: &Profiles, found: &Reflectance) -> (f64, f64) {
    let light: f64 = found.rings.iter().map(|r| r.value).sum();
    let differences: Vec<f64> = found.rings.iter().enumerate().map(|(i, r)| ring(profiles, i) - r.value).collect();
    (differences.iter().map(|d| d.abs()).sum::<f64>() / light, differences.iter().sum::<f64>() / light)
}

/// Returns the standard error of a ring relative to its light, averaged like the error of a model.
fn noise(found: &Reflectance) -> f64 {
    let light: f64 = found.rings.iter().map(|r| r.value).sum();
    found.rings.iter().map(|r| r.standard_error).sum::<f64>() / light
}

fn walk(albedos: &[f64], mean_cosine: f64, eta: f64, incidence: Incidence, paths: usize) -> Vec<Reflectance> {
    let albedos = albedos.to_vec();
    Walk { albedos, mean_cosine, eta, depth: f64::INFINITY, incidence, bins: RINGS }.run(paths, 7)
}

/// Returns κ of the medium of extinction 1, the reciprocal of the exact diffusion length: ω atanh(κ) = κ.
fn exact_decay(omega: f64) -> f64 {
    let (mut low, mut high) = (1e-9, 1.0 - 1e-15);
    for _ in 0..200 {
        let k = 0.5 * (low + high);
        if omega * f64::atanh(k) < k { low = k } else { high = k }
    }
    0.5 * (low + high)
}

/// Returns the models of light at normal incidence, with their names.
fn normal_models(medium: &Medium, albedo: f64) -> Vec<(&'static str, Profiles)> {
    let better = || Box::new(Dipole::better(medium));
    vec![
        ("classical dipole", vec![Box::new(Dipole::classical(medium))]),
        ("better dipole", vec![better()]),
        ("better dipole + single", vec![better(), Box::new(beam::single_scattering(medium))]),
        ("photon beam diffusion", vec![Box::new(beam::profile(medium))]),
        ("the same, scaled to the exact total", vec![Box::new(beam::profile(medium).with_total(albedo))]),
        ("Burley, searchlight", vec![Box::new(Burley::searchlight(albedo, 1.0 / medium.reduced().extinction()))]),
    ]
}

/// Returns the models of diffuse light, with their names.
fn diffuse_models(omega: f64) -> Vec<(&'static str, Profiles)> {
    let albedo = diffuse_albedo(omega);
    let grosjean = (3.0 * (1.0 - omega) / (2.0 - omega)).sqrt();
    vec![
        ("classical dipole", vec![Box::new(Dipole::classical(&Medium::isotropic(omega)))]),
        ("Burley, diffuse", vec![Box::new(Burley::diffuse(albedo, 1.0))]),
        ("Burley, dmfp (Grosjean)", vec![Box::new(Burley::diffuse_length(albedo, 1.0 / grosjean))]),
        ("Burley, dmfp (exact)", vec![Box::new(Burley::diffuse_length(albedo, 1.0 / exact_decay(omega)))]),
    ]
}

fn percent(x: f64) -> String {
    format!("{:+.1}", 100.0 * x)
}

fn row(cells: &[String]) {
    println!("| {} |", cells.join(" | "));
}

fn header(first: &[&str], models: &[(&'static str, Profiles)], last: &[&str]) {
    let names = models.iter().map(|m| m.0);
    let cells: Vec<String> = first.iter().copied().chain(names).chain(last.iter().copied()).map(String::from).collect();
    row(&cells);
    println!("|{}", "---|".repeat(cells.len()));
}

/// Prints totals and profile errors at normal incidence, for media by their single-scattering albedos.
///
/// `medium` gives the medium of reduced extinction 1. The exact total is the walk's one unless the medium is isotropic
/// and index-matched.
fn normal_tables(media: &[(f64, f64)], found: &[Reflectance], label: &str, medium: &dyn Fn(f64) -> Medium) {
    let known = medium(0.5) == Medium::isotropic(0.5);
    let reference = |i: usize| if known { normal_albedo(media[i].1) } else { found[i].total.value };
    println!("Error of the total, %. The walk is given with its standard error.\n");
    header(&[label, "ω", "exact", "walk"], &normal_models(&medium(0.5), 0.5), &[]);
    for (i, &(shown, omega)) in media.iter().enumerate() {
        let exact = if known { format!("{:.6}", reference(i)) } else { "—".into() };
        let total = found[i].total;
        let mut cells = vec![format!("{shown}"), format!("{omega:.6}"), exact];
        cells.push(format!("{:.5} ± {:.5}", total.value, total.standard_error));
        for (_, model) in normal_models(&medium(omega), reference(i)) {
            cells.push(percent(model.iter().map(|p| p.total()).sum::<f64>() / reference(i) - 1.0));
        }
        row(&cells);
    }
    println!("\nMean error of the profile over 0.1 to 10 mean free paths, % (in brackets the mean with sign).\n");
    header(&[label, "ω"], &normal_models(&medium(0.5), 0.5), &["noise of the walk"]);
    for (i, &(shown, omega)) in media.iter().enumerate() {
        let mut cells = vec![format!("{shown}"), format!("{omega:.6}")];
        for (_, model) in normal_models(&medium(omega), reference(i)) {
            let (absolute, signed) = errors(&model, &found[i]);
            cells.push(format!("{:.1} ({})", 100.0 * absolute, percent(signed)));
        }
        cells.push(format!("{:.2}", 100.0 * noise(&found[i])));
        row(&cells);
    }
    println!();
}

/// Prints totals and profile errors under diffuse light.
fn diffuse_table(media: &[(f64, f64)], found: &[Reflectance], label: &str) {
    println!("Mean error of the profile over 0.1 to 10 mean free paths, % (in brackets the error of the total).\n");
    header(&[label, "ω", "exact total", "walk"], &diffuse_models(0.5), &["noise of the walk"]);
    for (i, &(shown, omega)) in media.iter().enumerate() {
        let exact = diffuse_albedo(omega);
        let total = found[i].total;
        let mut cells = vec![format!("{shown}"), format!("{omega:.6}"), format!("{exact:.6}")];
        cells.push(format!("{:.5} ± {:.5}", total.value, total.standard_error));
        for (_, model) in diffuse_models(omega) {
            let total: f64 = model.iter().map(|p| p.total()).sum();
            cells.push(format!("{:.1} ({})", 100.0 * errors(&model, &found[i]).0, percent(total / exact - 1.0)));
        }
        cells.push(format!("{:.2}", 100.0 * noise(&found[i])));
        row(&cells);
    }
    println!();
}

/// Prints the walk's profile, as reference for other programs.
fn reference_table(found: &[Reflectance]) {
    println!("R(r) of the walk, the mean over a ring of a twentieth of a decade, with its standard error in %.\n");
    println!("| ring | {} |", ALBEDOS.map(|a| format!("ω = {a}")).join(" | "));
    println!("|---|{}", "---|".repeat(ALBEDOS.len()));
    for i in (0..RINGS.count).step_by(3) {
        let (inner, outer) = (RINGS.edge(i), RINGS.edge(i + 1));
        let area = std::f64::consts::PI * (outer * outer - inner * inner);
        let cells = found.iter().map(|f| {
            let e = f.rings[i];
            format!("{:.4e} ± {:.2}", e.value / area, 100.0 * e.standard_error / e.value)
        });
        println!("| {inner:.4}–{outer:.4} | {} |", cells.collect::<Vec<_>>().join(" | "));
    }
    println!();
}

fn inversion_table() {
    println!("| A | ω, diffuse | étendue | Kulla–Conty | Chiang | ω, normal | étendue |");
    println!("|---|---|---|---|---|---|---|");
    let exact = |a: f64, f: &dyn Fn(f64) -> f64| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if f(middle) < a { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    };
    for a in [0.01, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99] {
        let diffuse = |omega: f64| format!("{:+.4}", 100.0 * (diffuse_albedo(omega) / a - 1.0));
        let normal = single_scattering_albedo(a, Colour::Normal);
        row(&[
            format!("{a}"),
            format!("{:.8}", exact(a, &diffuse_albedo)),
            diffuse(single_scattering_albedo(a, Colour::Diffuse)),
            diffuse(kulla_conty(a)),
            diffuse(chiang(a)),
            format!("{:.8}", exact(a, &normal_albedo)),
            format!("{:+.4}", 100.0 * (normal_albedo(normal) / a - 1.0)),
        ]);
    }
    println!();
}

fn similarity_table(paths: usize) {
    println!("| colour | g = −0.5 | 0.3 | 0.6 | 0.8 | 0.9 |");
    println!("|---|---|---|---|---|---|");
    for colour in [Colour::Diffuse, Colour::Normal] {
        let incidence = if colour == Colour::Diffuse { Incidence::Diffuse } else { Incidence::Normal };
        for a in [0.1, 0.3, 0.5, 0.8, 0.95] {
            let mut cells = vec![format!("{colour:?} {a}")];
            for g in [-0.5, 0.3, 0.6, 0.8, 0.9] {
                let omega = medium_of(a, 1.0, g, colour).albedo();
                let count = (paths as f64 * (1.0 - a)) as usize;
                let total = walk(&[omega], g, 1.0, incidence, count)[0].total;
                cells.push(format!("{} ± {:.1}", percent(total.value / a - 1.0), 100.0 * total.standard_error / a));
            }
            row(&cells);
        }
    }
    println!();
}

/// Prints the tables of anisotropic scattering. Its reduced albedos are [`ALBEDOS`], and lengths are in reduced mean free
/// paths.
fn anisotropic_tables(mean_cosine: f64, paths: usize) {
    let medium = |omega: f64| {
        let scattering = omega / (1.0 - mean_cosine);
        Medium { absorption: 1.0 - omega, scattering, mean_cosine, eta: 1.0 }
    };
    let found: Vec<Reflectance> = ALBEDOS
        .iter()
        .flat_map(|&omega| {
            let m = medium(omega);
            let (unit, albedos) = (m.extinction(), vec![m.albedo()]);
            let bins = Bins { first: RINGS.first * unit, last: RINGS.last * unit, ..RINGS };
            let incidence = Incidence::Normal;
            Walk { albedos, mean_cosine, eta: 1.0, depth: f64::INFINITY, incidence, bins }.run(paths, 7)
        })
        .collect();
    normal_tables(&ALBEDOS.map(|a| (a, a)), &found, "reduced albedo", &medium);
}

/// Prints the sections of which the names are given, all by default, with a factor for the number of paths before them.
fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let scale: f64 = arguments.first().and_then(|s| s.parse().ok()).unwrap_or(1.0);
    let paths = |n: f64| (n * scale) as usize;
    let wanted = |name: &str| arguments.len() < 2 || arguments[1..].iter().any(|a| a == name);
    let media = ALBEDOS.map(|a| (a, a));
    let colours = ALBEDOS.map(|a| (a, single_scattering_albedo(a, Colour::Diffuse)));
    let walk_colours = |incidence| {
        let omegas = colours.map(|c| c.1);
        let mut found = walk(&omegas[..5], 0.0, 1.0, incidence, paths(2e6));
        found.extend(walk(&omegas[5..], 0.0, 1.0, incidence, paths(3e5)));
        found
    };
    if wanted("normal") {
        println!("## Normal incidence, index-matched, by single-scattering albedo\n");
        let found = walk(&ALBEDOS, 0.0, 1.0, Incidence::Normal, paths(4e6));
        normal_tables(&media, &found, "albedo", &Medium::isotropic);
        reference_table(&found);
    }
    if wanted("colour") {
        println!("## Normal incidence, index-matched, by colour (reflectance of diffuse light)\n");
        normal_tables(&colours, &walk_colours(Incidence::Normal), "colour", &Medium::isotropic);
    }
    if wanted("index") {
        println!("## Normal incidence, index 1.4, by single-scattering albedo\n");
        let found = walk(&ALBEDOS, 0.0, 1.4, Incidence::Normal, paths(2e6));
        normal_tables(&media, &found, "albedo", &|omega| Medium { eta: 1.4, ..Medium::isotropic(omega) });
    }
    if wanted("anisotropic") {
        println!("## Normal incidence, index-matched, g = 0.8, by reduced albedo\n");
        anisotropic_tables(0.8, paths(4e5));
    }
    if wanted("diffuse") {
        println!("## Diffuse light, index-matched, by single-scattering albedo\n");
        diffuse_table(&media, &walk(&ALBEDOS, 0.0, 1.0, Incidence::Diffuse, paths(2e6)), "albedo");
        println!("## Diffuse light, index-matched, by colour\n");
        diffuse_table(&colours, &walk_colours(Incidence::Diffuse), "colour");
    }
    if wanted("inversion") {
        println!("## Inversion: error of the reflectance, %\n");
        inversion_table();
    }
    if wanted("similarity") {
        println!("## Similarity: error of the reflectance for anisotropic scattering, %\n");
        similarity_table(paths(1e6));
    }
}
