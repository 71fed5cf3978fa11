//! Report pages: one self-contained HTML file that works from `file://`, on phones and in dark mode. Callers compose
//! the parts (boxes of facts, tables, plots, picture comparisons); [`Page`] is the frame around them.
//!
//! A page loads nothing: its content security policy forbids external resources. Without scripts everything but the
//! slider works.

mod picture;
mod plot;

pub use picture::{FigurePicture, MOST_SIDE, compare, gallery, ramp, reduced};
pub use plot::{Plot, Series, key};

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// A page under construction.
pub struct Page {
    title: String,
    body: Vec<Markup>,
}

const CSS: &str = include_str!("html/page.css");
const SCRIPT: &str = include_str!("html/page.js");
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

impl Page {
    /// Creates a page with a title and a lead paragraph.
    pub fn new(title: &str, lead: &str) -> Page {
        Page { title: title.into(), body: vec![html! { h1 { (title) } p { (lead) } }] }
    }

    /// Adds a section.
    pub fn section(&mut self, heading: &str, content: &Markup) {
        self.body.push(html! { section { h2 { (heading) } (content) } });
    }

    /// Returns the whole file.
    pub fn html(&self) -> String {
        let style = format!("{CSS}{}", plot::css());
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    meta http-equiv="Content-Security-Policy" content=(POLICY);
                    link rel="icon" href="data:,";
                    title { (self.title) }
                    style { (PreEscaped(style)) }
                }
                body {
                    main { @for part in &self.body { (part) } }
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        };
        page.into_string()
    }
}

/// Formats a box of names and values: a machine, a reference, settings.
pub fn facts<'a>(rows: impl IntoIterator<Item = (&'a str, String)>) -> Markup {
    html! { dl.facts { @for (name, value) in rows { dt { (name) } dd { (value) } } } }
}

/// Formats a table that scrolls on its own where the page is narrow. The first cell of each row is its heading.
pub fn table(caption: &str, head: &[String], rows: &[Vec<String>]) -> Markup {
    html! {
        p.caption { (caption) }
        div.scroll role="region" aria-label=(caption) tabindex="0" {
            table aria-label=(caption) {
                thead { tr { @for cell in head { th scope="col" { (cell) } } } }
                tbody {
                    @for row in rows {
                        tr {
                            @for (at, cell) in row.iter().enumerate() {
                                @if at == 0 { th scope="row" { (cell) } } @else { td { (cell) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_from_outside_cannot_become_markup() {
        let evil = "<script>alert(1)</script>\"&";
        let mut page = Page::new(evil, evil);
        page.section(evil, &facts([(evil, evil.to_string())]));
        page.section("t", &table(evil, &[evil.into()], &[vec![evil.into(), evil.into()]]));
        let series =
            [Series { label: evil.into(), hue: 0, dash: 0, curve: vec![[1.0, 2.0], [2.0, 1.0]], band: Vec::new() }];
        let plot = Plot { title: evil, x: evil, y: evil, series: &series, guide: None };
        page.section("p", &plot.draw());
        page.section("k", &key(&series));
        let picture = FigurePicture::of_bytes(evil, 1, 1, &[0, 0, 0]).unwrap();
        page.section("c", &compare("x", &[picture.clone(), picture]));
        let text = page.html();
        assert!(!text.contains("<script>alert"), "{text}");
        assert_eq!(text.matches("<script").count(), 1);
    }
}
