//! The report as lines of text, at most about 90 columns wide.

use super::report::{Entry, VerifyReport};
use crate::lab::same_mean::{Outcome, PairJudgement, Worst};

impl VerifyReport {
    /// Formats the candidates, the pairs and the verdict.
    pub fn lines(&self) -> Vec<String> {
        let [width, height] = self.size;
        let (replicates, level) = (self.replicates, self.judgement.level);
        let mut lines = vec![format!(
            "{} at {width}x{height}, {replicates} replicates, level {level} for everything together",
            self.scene
        )];
        lines.push(String::new());
        lines.push(format!(
            "{:18} {:>8} {:>9}   {}",
            "candidate", "spp", "seconds", "mean of red, green, blue ± standard error"
        ));
        lines.extend(self.candidates.iter().map(Entry::line));
        lines.extend(self.excluded.iter().flat_map(|e| &e.reasons).map(|reason| format!("left out: {reason}")));
        lines.push(String::new());
        lines.push(format!("{:37} {:>10} {:>9}  {:>8} {:>14}", "", "image mean", "", "tiles", ""));
        lines.push(format!(
            "{:37} {:>10} {:>9}  {:>8} {:>14}",
            "pair", "differs by", "seen from", "different", "seen from"
        ));
        lines.extend(self.judgement.pairs.iter().map(|pair| self.pair_line(pair)));
        lines.push(String::new());
        lines.extend(self.judgement.pairs.iter().filter(|p| p.differs()).map(|pair| self.difference(pair)));
        lines.push(self.verdict());
        lines
    }

    /// Returns the conclusion, which is the last line.
    pub fn verdict(&self) -> String {
        let (count, level) = (self.judgement.pairs.iter().filter(|p| p.differs()).count(), self.judgement.level);
        if self.outcome == Outcome::CannotTell {
            return self.untold();
        }
        if count == 0 {
            let seen = self.judgement.pairs.iter().map(|p| p.detectable).collect::<Option<Vec<_>>>();
            let worth = match seen.map(|s| s.into_iter().fold(0.0, f64::max)) {
                Some(seen) => {
                    format!("errors of {} in the image mean would have been seen nine times of ten", percent(seen))
                }
                None => "but some pairs are too noisy to tell: give them a larger --budget".into(),
            };
            return format!("no difference between {} candidates; {worth}", self.candidates.len());
        }
        let of = self.judgement.pairs.len();
        match &self.odd {
            Some(odd) if odd.from_all => {
                format!("DIFFERENT at level {level}: {count} of {of} pairs; the outlier is {}", odd.who)
            }
            Some(odd) => format!("DIFFERENT at level {level}: {count} of {of} pairs; all of them involve {}", odd.who),
            None => format!("DIFFERENT at level {level}: {count} of {of} pairs"),
        }
    }

    /// Names the candidates whose untrusted errors leave pairs undecided, with the reasons.
    fn untold(&self) -> String {
        let untold: Vec<&PairJudgement> =
            self.judgement.pairs.iter().filter(|p| p.outcome == Outcome::CannotTell).collect();
        let is_part = |i: usize| untold.iter().any(|pair| [pair.a, pair.b].contains(&i));
        let of = |(i, c): (usize, &Entry)| {
            let doubt = c.doubt.filter(|_| is_part(i))?;
            Some(format!("the error of {} is not to be trusted ({doubt})", c.name))
        };
        let who: Vec<String> = self.candidates.iter().enumerate().filter_map(of).collect();
        let (count, all) = (untold.len(), self.judgement.pairs.len());
        format!("cannot tell {count} of {all} pairs: {}; give them a larger --budget", who.join(", "))
    }

    fn names(&self, pair: &PairJudgement) -> String {
        format!("{} - {}", self.candidates[pair.a].name, self.candidates[pair.b].name)
    }

    fn pair_line(&self, pair: &PairJudgement) -> String {
        let tile = match (pair.detectable_tile, pair.detectable_side) {
            (Some(seen), Some(side)) => format!("{} ({side} px)", percent(seen)),
            _ => "too noisy".into(),
        };
        let different = format!("{}/{}", pair.tiles_different, pair.tiles);
        let image = pair.detectable.map_or_else(|| "too noisy".into(), percent);
        let mark = match pair.outcome {
            Outcome::Agree => "",
            Outcome::Differ => "  DIFFERENT",
            Outcome::CannotTell => "  CANNOT TELL",
        };
        format!(
            "{:37} {:>10} {image:>9}  {different:>8} {tile:>14}{mark}",
            self.names(pair),
            signed(pair.image.relative)
        )
    }

    /// Describes position and size of a pair's difference.
    fn difference(&self, pair: &PairJudgement) -> String {
        let significant = |w: &Worst| w.p_value < self.judgement.level;
        let mut parts = Vec::new();
        if significant(&pair.image) {
            parts.push(format!("the image's {}", amount(&pair.image)));
        }
        if let Some(tile) = pair.tile.filter(significant) {
            let a = tile.area;
            let place = format!("pixels {},{} to {},{}", a.x0, a.y0, a.x1 - 1, a.y1 - 1);
            parts.push(format!("{} of {} tiles, most at {place}: {}", pair.tiles_different, pair.tiles, amount(&tile)));
        }
        format!("{}: {}", self.names(pair), parts.join(";\n    "))
    }
}

impl Entry {
    fn line(&self) -> String {
        let mean: Vec<String> =
            self.mean.iter().zip(self.standard_error).map(|(mean, error)| format!("{mean:.5} ± {error:.5}")).collect();
        let guards = match self.guards.nonfinite {
            0 => String::new(),
            n => format!("  ({n} samples not finite)"),
        };
        let doubt = if self.doubt.is_some() { "  (not to be trusted)" } else { "" };
        format!("{:18} {:>8} {:>9.2}   {}{doubt}{guards}", self.name, self.spp, self.seconds, mean.join("  "))
    }
}

/// Formats the channel, the difference, its interval and t.
fn amount(w: &Worst) -> String {
    let channel = ["red", "green", "blue"].get(w.channel).copied().unwrap_or("?");
    let [low, high] = w.interval.map(signed);
    format!("{channel} by {} [{low}, {high}], t {:.1}", signed(w.relative), w.t)
}

/// Formats a fraction in per cent with two or three digits.
fn percent(share: f64) -> String {
    let p = 100.0 * share;
    match p {
        _ if p >= 10.0 => format!("{p:.0} %"),
        _ if p >= 1.0 => format!("{p:.1} %"),
        _ if p >= 0.1 => format!("{p:.2} %"),
        _ => format!("{p:.3} %"),
    }
}

fn signed(share: f64) -> String {
    format!("{}{}", if share < 0.0 { '-' } else { '+' }, percent(share.abs()))
}
