//! Report pages in a real browser: Debian's Chromium, headless. Where it is not installed the test says so and passes,
//! unless ETENDUE_BROWSER is set, as it is in continuous integration (`ETENDUE_BROWSER=1 ./setup.sh` installs it). With
//! ETENDUE_SCREENSHOTS=FOLDER it leaves pictures of the page there, and with ETENDUE_PAGE=FILE it takes that page.

#![allow(clippy::unwrap_used)]

mod browser;

use browser::Browser;
use std::path::{Path, PathBuf};
use std::process::Command;

fn browser() -> Option<Browser> {
    let program = browser::installed();
    if program.is_none() {
        assert!(std::env::var_os("ETENDUE_BROWSER").is_none(), "ETENDUE_BROWSER is set and no Chromium is installed");
        eprintln!(
            "\n*** SKIPPED: no Chromium, so pages were not tested: ETENDUE_BROWSER=1 ./setup.sh installs it ***\n"
        );
    }
    program.map(Browser::start)
}

/// A page of two scenes, one with a blind method.
fn page(folder: &Path) -> PathBuf {
    if let Some(page) = std::env::var_os("ETENDUE_PAGE") {
        return std::path::absolute(page).unwrap();
    }
    measured(folder, "methods", "--budget 1ms --reference-budget 1ms --repetitions 2")
}

/// A page of rates, of hits in two scenes and in hard cases, some with addresses.
fn page_of_rays(folder: &Path) -> PathBuf {
    measured(folder, "rays", "--rounds 2 --threads 1,2 --hard-cases --rays-per-case 200")
}

/// The page of a benchmark of two small scenes.
fn measured(folder: &Path, what: &str, options: &str) -> PathBuf {
    let scene = |name: &str| format!("{}/scenes/{name}/scene.gltf", env!("CARGO_MANIFEST_DIR"));
    let ran = Command::new(env!("CARGO_BIN_EXE_etendue"))
        .args(["bench", what, &scene("cornell-box"), &scene("sphere-lamp"), "--backends", "obvhs", "--size", "24x24"])
        .args(options.split(' '))
        .args(["--quiet", "-o"])
        .arg(folder)
        .output()
        .unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    folder.join("index.html")
}

/// From 0, black, to 255.
fn brightness(browser: &mut Browser, what: &str) -> f64 {
    let color = browser.value(&format!("getComputedStyle(document.querySelector('{what}')).backgroundColor"));
    let numbers = color.as_str().unwrap().split(|c: char| !c.is_ascii_digit()).filter_map(|n| n.parse::<f64>().ok());
    numbers.take(3).sum::<f64>() / 3.0
}

fn overflow(browser: &mut Browser) -> i64 {
    browser.value("document.documentElement.scrollWidth - document.documentElement.clientWidth").as_i64().unwrap()
}

#[test]
fn a_report_works_on_desktop_and_phone_by_day_and_night() {
    let Some(mut browser) = browser() else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = page(folder.path());
    works_everywhere(&mut browser, &page, "methods");
}

#[test]
fn a_report_of_rays_works_on_desktop_and_phone_by_day_and_night() {
    let Some(mut browser) = browser() else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = page_of_rays(folder.path());
    works_everywhere(&mut browser, &page, "rays");
    // All values are there: for each scene rates, classes and hits, then the hard cases.
    assert_eq!(browser.value("document.querySelectorAll('table').length"), 2 * 3 + 1);
    let cells = "[...document.querySelectorAll('tr')].every(r => r.cells.length === r.closest('table').tHead.rows[0].cells.length)";
    assert_eq!(browser.value(cells), true, "rows are as long as their heads");
    assert_eq!(browser.value("document.querySelectorAll('svg[role=img]').length"), 2 * 2);
    assert_eq!(browser.value("[...document.querySelectorAll('svg[role=img]')].filter(e => !e.ariaLabel).length"), 0);
}

/// Checks what holds for every page with plots, light and dark, wide and narrow; `name` is that of its pictures.
fn works_everywhere(browser: &mut Browser, page: &Path, name: &str) {
    for (width, scheme) in [(1280, "light"), (390, "light"), (390, "dark"), (1280, "dark")] {
        browser.open(page, width, scheme);
        assert_eq!(overflow(browser), 0, "nothing but tables scrolls sideways at {width}");
        let is_dark = scheme == "dark";
        assert_eq!(brightness(browser, "body") < 64.0, is_dark, "{scheme}");
        // Curves are drawn in the page's colours: a place holder would be almost black.
        let stroke =
            browser.value("getComputedStyle(document.querySelector('svg.plot polyline[stroke^=\"#0A\"]')).stroke");
        let expected = browser.value("getComputedStyle(document.documentElement).getPropertyValue('--h0')");
        let hex = expected.as_str().unwrap().trim().trim_start_matches('#');
        let channel = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16).unwrap();
        assert_eq!(stroke.as_str().unwrap(), format!("rgb({}, {}, {})", channel(0), channel(2), channel(4)));
        let broken = browser.value("[...document.images].filter(i => !i.complete || i.naturalWidth === 0).length");
        assert_eq!(broken, 0, "pictures that do not load");
        if let Some(folder) = std::env::var_os("ETENDUE_SCREENSHOTS") {
            browser.photograph(&Path::new(&folder).join(format!("{name}-{width}-{scheme}.png")));
        }
        let requests = browser.requests();
        let outside: Vec<_> =
            requests.iter().filter(|url| !url.starts_with("data:") && !url.ends_with(".html")).collect();
        assert!(!requests.is_empty() && outside.is_empty(), "{outside:?}");
        assert!(browser.complaints().is_empty(), "{:?}", browser.complaints());
    }
}

#[test]
fn the_slider_moves_by_keys_and_pictures_can_be_chosen() {
    let Some(mut browser) = browser() else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = page(folder.path());
    browser.open(&page, 390, "light");
    let clip = "getComputedStyle(document.querySelectorAll('.compare .stack img')[1]).clipPath";
    assert_eq!(browser.value(clip), "inset(0px 0px 0px 50%)");
    browser.value("document.querySelector('.compare input[type=range]').focus()");
    browser.press("ArrowRight", 39);
    assert_eq!(browser.value(clip), "inset(0px 0px 0px 51%)");
    browser.press("Home", 36);
    assert_eq!(browser.value(clip), "inset(0px 0px 0px 0%)");
    let shown =
        "(([l, r]) => [l.src, r.src, l.alt, r.alt].join('|'))(document.querySelectorAll('.compare .stack img'))";
    let before = browser.value(shown);
    browser.value(
        "(s => { s.selectedIndex = s.options.length - 1; s.dispatchEvent(new Event('change')); })(document.querySelectorAll('.compare select')[1])",
    );
    let after = browser.value(shown);
    assert!(before != after && after.as_str().unwrap().contains("error of"), "{after}");
    // Everything that can be operated or seen has a name.
    let nameless = "[...document.querySelectorAll('input,select')].filter(e => !e.labels.length && !e.ariaLabel).length \
        + [...document.images].filter(e => !e.alt).length + [...document.querySelectorAll('svg[role=img]')].filter(e => !e.ariaLabel).length";
    assert_eq!(browser.value(nameless), 0);
    assert!(browser.complaints().is_empty(), "{:?}", browser.complaints());
}
