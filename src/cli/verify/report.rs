//! The report, as text for people and as JSON for scripts.

use std::{fmt::Write as _, path::Path};

use sfera::{
    name::shown,
    nearness::{Cause, Verdict},
    spheres::Rgb,
};

use super::{
    guess::{Depth, Fit, Guess, Orientation, Rule},
    judgement::Judgement,
    tally::{Tally, Wrong},
};
use crate::cli::{
    arguments::{Job, Style},
    failure::{Failure, STANDARD_INPUT},
    messages::{print, tell},
    statistics::{Clock, json_of_job},
};

/// Upper bounds of the relative error of the squares in `b^2 - 4ac` that rounding causes:
/// 16 roundings, of vectors that were normalised before.
const DOUBLES: f64 = 16.0 * f64::EPSILON;
const FLOATS: f64 = 16.0 * f32::EPSILON as f64;

/// Everything that was found out.
pub(super) struct Findings<'a> {
    pub(super) job: &'a Job,
    pub(super) spheres: usize,
    pub(super) tally: &'a Tally,
    pub(super) judgement: &'a Judgement,
    pub(super) clock: &'a Clock,
}

/// Prints the findings. Fails if a pixel is wrong.
pub(super) fn report(findings: &Findings<'_>) -> Result<(), Failure> {
    let Findings { job, tally, .. } = findings;
    if job.stats == Some(Style::Json) {
        tell(format_args!("{}", findings.json()));
        return if tally.wrong == 0 {
            Ok(())
        } else {
            Err(Failure::Reported)
        };
    }
    let marks_there = job.diff.as_deref() == Some(Path::new("-"));
    if !job.quiet && !marks_there {
        print(findings.text().as_bytes())?;
    }
    if job.stats.is_some() {
        tell(format_args!("{}", findings.clock.text().trim_end()));
    }
    if tally.wrong == 0 {
        return Ok(());
    }
    Err(Failure::Message(findings.summary()))
}

impl Findings<'_> {
    fn name(&self) -> String {
        if self.job.image == Path::new("-") {
            STANDARD_INPUT.into()
        } else {
            shown(&self.job.image)
        }
    }

    fn per_million(&self) -> f64 {
        self.tally.wrong as f64 / self.job.pixels() as f64 * 1e6
    }

    /// One line.
    fn summary(&self) -> String {
        let tally = self.tally;
        let mut summary = format!(
            "{}: {} of {} pixels differ, {} per million, in {} of {} rows: {}",
            self.name(),
            tally.wrong,
            self.job.pixels(),
            short(self.per_million()),
            tally.rows.rows,
            self.job.rows().len(),
            tally.rows.words(),
        );
        if let Some(conclusion) = self.conclusion() {
            summary += "; ";
            summary += &conclusion;
        }
        summary
    }

    /// The explanation, if there is one.
    fn conclusion(&self) -> Option<String> {
        if let Some(fit) = &self.judgement.fit {
            return Some(format!("the picture fits if {}", words(fit.guess)));
        }
        self.judgement.worst?;
        let rounding = self.judgement.rounding;
        let kind = if rounding <= DOUBLES {
            "doubles"
        } else if rounding <= FLOATS {
            "floats"
        } else {
            return Some("this is more than rounding".to_owned());
        };
        Some(format!(
            "this is rounding in {kind}: an error of {} in the squares of the textbook formula \
             explains every pixel examined",
            short(rounding)
        ))
    }

    fn text(&self) -> String {
        if self.tally.wrong == 0 {
            return format!(
                "{}: all {} pixels are right\n",
                self.name(),
                self.job.pixels()
            );
        }
        let mut text = format!(
            "{:>10} {:>10}  {:<11}  {:<11}\n",
            "column", "row", "found", "right"
        );
        let verdicts = self.judgement.first.iter().map(Some);
        let verdicts = verdicts.chain(std::iter::repeat(None));
        for (wrong, verdict) in self.tally.first.iter().zip(verdicts) {
            self.line(&mut text, wrong, verdict);
        }
        if self.tally.wrong > self.tally.first.len() as u64 {
            text += "       ...\n";
        }
        if let Some((wrong, verdict)) = &self.judgement.worst {
            let _ = writeln!(text, "the worst of {} examined:", self.judgement.looked_at);
            self.line(&mut text, wrong, Some(verdict));
        }
        if let Some(Fit { guess, wrong, of }) = self.judgement.fit {
            let _ = writeln!(
                text,
                "the picture fits if {}: then {wrong} of {of} pixels differ",
                words(guess)
            );
        }
        text
    }

    fn line(&self, text: &mut String, wrong: &Wrong, verdict: Option<&Verdict>) {
        let (column, row) = wrong.pixel;
        let colour = |[red, green, blue]: Rgb| format!("{red:>3} {green:>3} {blue:>3}");
        let _ = write!(
            text,
            "{column:>10} {row:>10}  {}  {}",
            colour(wrong.found),
            colour(wrong.right)
        );
        if let Some(verdict) = verdict {
            let seen = verdict
                .seen
                .map_or_else(|| "the background".to_owned(), |sphere| self.sphere(sphere));
            let _ = write!(text, "  {seen}; {}", self.cause(verdict.cause));
        }
        text.push('\n');
    }

    fn cause(&self, cause: Option<Cause>) -> String {
        match cause {
            None => "nothing of the colour found is near".to_owned(),
            Some(Cause::Outline { sphere, pixels }) => format!(
                "{} pixels to the outline of {}",
                short(pixels),
                self.sphere(sphere)
            ),
            Some(Cause::Tie { sphere, gap }) => format!(
                "{} is farther by {} of the distance",
                self.sphere(sphere),
                short(gap)
            ),
        }
    }

    fn sphere(&self, sphere: usize) -> String {
        match self.judgement.line(sphere) {
            Some(line) => format!("sphere {} (line {line})", sphere + 1),
            None => format!("sphere {}", sphere + 1),
        }
    }

    fn json(&self) -> String {
        let (job, tally, judgement) = (self.job, self.tally, self.judgement);
        let (shown_ranges, all) = tally.rows.shown();
        let shown_ranges: Vec<String> = shown_ranges
            .iter()
            .map(|rows| format!("[{},{}]", rows.start, rows.end))
            .collect();
        let verdicts = judgement.first.iter().map(Some);
        let verdicts = verdicts.chain(std::iter::repeat(None));
        let first: Vec<String> = tally
            .first
            .iter()
            .zip(verdicts)
            .map(|(wrong, verdict)| self.json_pixel(wrong, verdict))
            .collect();
        let worst = judgement
            .worst
            .as_ref()
            .map_or("null".to_owned(), |(wrong, verdict)| {
                self.json_pixel(wrong, Some(verdict))
            });
        format!(
            "{{\"image\":{},{},\"pixels\":{},\"wrong\":{},\"wrong_per_million\":{},\"wrong_rows\":{},\"wrong_row_ranges\":[{}],\
             \"all_ranges\":{all},\"first\":[{}],\"worst\":{worst},\"looked_at\":{},\"rounding\":{},\"fit\":{},\
             \"conclusion\":{},\"milliseconds\":{{{}}}}}",
            json_string(&self.name()),
            json_of_job(job, self.spheres),
            job.pixels(),
            tally.wrong,
            self.per_million(),
            tally.rows.rows,
            shown_ranges.join(","),
            first.join(","),
            judgement.looked_at,
            json_number(judgement.rounding),
            judgement.fit.as_ref().map_or("null".to_owned(), json_fit),
            self.conclusion()
                .map_or("null".to_owned(), |words| json_string(&words)),
            self.clock.json(),
        )
    }

    fn json_pixel(&self, wrong: &Wrong, verdict: Option<&Verdict>) -> String {
        let (column, row) = wrong.pixel;
        let mut json = format!(
            "{{\"column\":{column},\"row\":{row},\"found\":{:?},\"right\":{:?}",
            wrong.found, wrong.right
        );
        if let Some(verdict) = verdict {
            let seen = verdict
                .seen
                .map_or("null".to_owned(), |sphere| self.json_sphere(sphere));
            let cause = verdict.cause.map_or("null".to_owned(), |cause| {
                let (kind, unit) = match cause {
                    Cause::Outline { .. } => ("outline", "pixels"),
                    Cause::Tie { .. } => ("tie", "gap"),
                };
                format!(
                    "{{\"kind\":\"{kind}\",\"sphere\":{},\"{unit}\":{}}}",
                    self.json_sphere(cause.sphere()),
                    json_number(cause.distance())
                )
            });
            let rounding = json_number(verdict.rounding);
            let _ = write!(
                json,
                ",\"sphere\":{seen},\"near\":{cause},\"rounding\":{rounding}"
            );
        }
        json.push('}');
        json
    }

    fn json_sphere(&self, sphere: usize) -> String {
        let line = self.judgement.line(sphere);
        format!(
            "{{\"number\":{},\"line\":{}}}",
            sphere + 1,
            line.map_or("null".to_owned(), |line| line.to_string())
        )
    }
}

fn json_fit(fit: &Fit) -> String {
    let Guess {
        orientation,
        columns,
        rows,
        depth,
    } = fit.guess;
    let orientation = match orientation {
        Orientation::Right => "right",
        Orientation::UpsideDown => "upside down",
        Orientation::Mirrored => "mirrored",
        Orientation::Turned => "turned",
    };
    let depth = match depth {
        Depth::Nearest => "nearest",
        Depth::EitherSide => "either side",
        Depth::Least => "least",
        Depth::Outside => "outside",
    };
    format!(
        "{{\"orientation\":\"{orientation}\",\"columns\":\"{}\",\"rows\":\"{}\",\"depth\":\"{depth}\",\"wrong\":{},\"of\":{}}}",
        formula(columns, 'i', 'W'),
        formula(rows, 'j', 'H'),
        fit.wrong,
        fit.of
    )
}

/// How a guess differs from the right picture.
fn words(guess: Guess) -> String {
    let orientation = match guess.orientation {
        Orientation::Right => None,
        Orientation::UpsideDown => Some("it is upside down (row 0 is the edge of +y)"),
        Orientation::Mirrored => Some("it is mirrored, left for right"),
        Orientation::Turned => Some("it is upside down and mirrored"),
    };
    let rules = (guess.columns != Rule::Edges || guess.rows != Rule::Edges).then(|| {
        format!(
            "its rays go through {} and {} of the viewport instead of {} and {}",
            formula(guess.columns, 'i', 'W'),
            formula(guess.rows, 'j', 'H'),
            formula(Rule::Edges, 'i', 'W'),
            formula(Rule::Edges, 'j', 'H'),
        )
    });
    let depth = match guess.depth {
        Depth::Nearest => None,
        Depth::EitherSide => Some("spheres behind the camera are seen too (t < 0 is taken)"),
        Depth::Least => Some(
            "spheres behind the camera hide those in front of it (the least t is taken, even if t < 0)",
        ),
        Depth::Outside => Some("spheres that contain the camera are not seen from inside"),
    };
    let words = [orientation, rules.as_deref(), depth];
    let words: Vec<&str> = words.into_iter().flatten().collect();
    words.join(", and ")
}

/// The place where pixel `i` of `n` looks through the viewport, as a fraction of its side.
fn formula(rule: Rule, i: char, n: char) -> String {
    match rule {
        Rule::Edges => format!("{i}/({n}-1)"),
        Rule::Centres => format!("({i}+1/2)/{n}"),
        Rule::Low => format!("{i}/{n}"),
        Rule::High => format!("({i}+1)/{n}"),
        Rule::HalfBefore => format!("({i}-1/2)/({n}-1)"),
        Rule::HalfAfter => format!("({i}+1/2)/({n}-1)"),
    }
}

/// A number in few digits.
fn short(number: f64) -> String {
    if number != 0.0 && !(1e-3..1e6).contains(&number) {
        return format!("{number:.1e}");
    }
    let digits = format!("{number:.3}");
    digits
        .trim_end_matches('0')
        .trim_end_matches('.')
        .to_owned()
}

fn json_number(number: f64) -> String {
    if number.is_finite() {
        format!("{number:e}")
    } else {
        "null".to_owned()
    }
}

fn json_string(text: &str) -> String {
    let mut json = String::from('"');
    for character in text.chars() {
        match character {
            '"' | '\\' => json.extend(['\\', character]),
            '\u{20}'.. => json.push(character),
            _ => {
                let _ = write!(json, "\\u{:04x}", u32::from(character));
            }
        }
    }
    json.push('"');
    json
}
