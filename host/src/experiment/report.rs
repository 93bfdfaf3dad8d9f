//! The study as one HTML file, for somebody who has not read the paper.
//!
//! Holds the page: its order, its tables, its look; `words` has the sentences.
//! Nothing is loaded from anywhere, no script runs (the page's own policy forbids
//! it), and whatever comes from files is escaped. Does not depend on how figures
//! are drawn.

mod tables;
pub mod words;

use super::figures::{Drawn, Missing};
use super::method::Method;
use super::study::Study;
use crate::plot::Colour;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::error::Error;

const STYLE: &str = include_str!("report/style.css");
/// What the page may load: nothing but the style within it.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'";
/// The figure that is a table.
const TABLE: &str = "table-2";
/// Of a figure's width, on a phone.
const SMALL: f64 = 0.85;
/// What the paper is called.
const PAPER: &str = "W. Zhu and A. Rosendo, PSTO: Learning Energy-Efficient Locomotion for Quadruped Robots, \
                     Machines 2022, 10, 185";

/// The whole page.
#[must_use]
pub fn html(study: &Study, figures: &[Drawn]) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "PSTO: the comparison of gaits" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { "Which gait walks farthest on its battery?" }
                    p.soft { "The study of the PSTO paper, done again " (words::place(study)) "." }
                    (contents())
                }
                main {
                    (compared(study))
                    (result(study))
                    section aria-labelledby="table-2-heading" {
                        h2 #table-2-heading { "Table 2: the best of each method" }
                        (tables::best(&study.robot, &study.best))
                    }
                    @if !study.energy.is_empty() {
                        section aria-labelledby="why" {
                            h2 #why { "Why: where the energy goes" }
                            @for sentence in words::reasons(&study.robot, &study.energy) { p { (sentence) } }
                            (tables::energy_balance(&study.energy))
                        }
                    }
                    section aria-labelledby="figures" {
                        h2 #figures { "Figures" }
                        // Table 2 stands above as a table that can be read aloud.
                        @for drawn in figures.iter().filter(|d| d.name != TABLE) { (figure(drawn)) }
                    }
                    section aria-labelledby="claims" {
                        h2 #claims { "The paper\u{2019}s claims" }
                        (tables::claims(&study.claims))
                    }
                    section aria-labelledby="conditions" {
                        h2 #conditions { "Every condition" }
                        (tables::left_out(&study.conditions))
                        (tables::conditions(&study.conditions))
                    }
                    section aria-labelledby="gaits" {
                        h2 #gaits { "The gaits" }
                        (tables::gaits(&study.legs))
                    }
                    section aria-labelledby="parameters" {
                        h2 #parameters { "Parameters and seeds" }
                        (tables::parameters(&study.parameters))
                        (tables::descriptions(&study.descriptions))
                    }
                    (missing(study, figures))
                    section aria-labelledby="times" {
                        h2 #times { "Times" }
                        p {
                            "Making the gaits (training, recording, searching): "
                            (duration(study.prepare_wall_s)) ". Trials and figures: "
                            (duration(study.wall_s)) " in the last call."
                        }
                    }
                }
                footer { p { "The paper: " (PAPER) "." } }
            }
        }
    };
    page.into_string()
}

fn contents() -> Markup {
    let places = [
        ("result", "Result"),
        ("table-2-heading", "Table 2"),
        ("figures", "Figures"),
        ("claims", "Claims"),
        ("conditions", "Conditions"),
        ("gaits", "Gaits"),
        ("parameters", "Parameters"),
    ];
    html! {
        nav aria-label="Contents" {
            ul { @for (place, name) in places { li { a href={ "#" (place) } { (name) } } } }
        }
    }
}

fn compared(study: &Study) -> Markup {
    let methods = words::methods(study);
    let names: Vec<String> = methods.iter().map(|method| method.label().to_owned()).collect();
    let counted: usize = study.conditions.iter().map(|condition| condition.n).sum();
    let walked: usize = study.conditions.iter().map(|condition| condition.trials).sum();
    html! {
        section aria-labelledby="compared" {
            h2 #compared { "What was compared, and where" }
            p {
                "A four-legged robot with eight servos walked with gaits of "
                @if methods.len() == 1 { "one method" } @else { (methods.len()) " methods" }
                ": " (words::listed(&names)) ". "
                "Each was tried on legs of " (words::listed(&words::legs(study))) ", at "
                (words::amplifications(study)) " times its swing, in "
                (walked) " trials, of which " (counted) " count. "
                "All were walked " (words::place(study)) "."
            }
            dl.methods {
                @for method in &methods {
                    dt { (swatch(*method)) (method.label()) }
                    dd { (method.spec().explained) }
                }
            }
            p {
                strong { "Cost of transport" }
                " is the energy from the battery, divided by weight and distance: the less, the better. "
                strong { "Amplification" }
                " multiplies how far every joint swings from its centre. "
                "Numbers behind \u{b1} are half a 95 % confidence interval over the trials of a condition."
            }
        }
    }
}

fn swatch(method: Method) -> Markup {
    let Colour(red, green, blue) = method.spec().colour;
    html! { span.swatch aria-hidden="true" style={ "background:rgb(" (red) "," (green) "," (blue) ")" } {} }
}

fn result(study: &Study) -> Markup {
    let verdicts = words::verdicts(study);
    html! {
        section aria-labelledby="result" {
            h2 #result { "What won, and by how much" }
            @if verdicts.is_empty() { p { "No trial counts: there is nothing to compare." } }
            @for verdict in verdicts {
                div.verdict {
                    h3 { "Legs of " (verdict.leg) }
                    p.lead { (verdict.headline) }
                    @if !verdict.sentences.is_empty() {
                        ul { @for sentence in verdict.sentences { li { (sentence) } } }
                    }
                }
            }
            @if let Some(caveat) = words::caveat(study) { p.note { (caveat) } }
            p.soft {
                "The best amplification of a method was picked after its trials: its interval is that of the \
                 condition, and a little too narrow for the best of several."
            }
        }
    }
}

fn figure(drawn: &Drawn) -> Markup {
    html! {
        figure id=(drawn.name) {
            @match &drawn.svg {
                Ok(svg) => {
                    div.paper.scroll tabindex="0" role="group" aria-label=(drawn.heading) {
                        (inlined(svg, &drawn.heading, &drawn.caption))
                    }
                }
                Err(reason) => p.missing { "Not drawn: " (said(reason)) "." }
            }
            figcaption { strong { (drawn.heading) "." } " " (drawn.caption) }
        }
    }
}

/// A drawing within the page, with a text for those who cannot see it.
fn inlined(svg: &str, heading: &str, caption: &str) -> Markup {
    let label = html! { (heading) ": " (caption) }.into_string();
    let small = width_px(svg)
        .map_or(String::new(), |width_px| format!(" style=\"--small:{:.0}px\"", width_px * SMALL));
    let opened = format!("<svg role=\"img\" aria-label=\"{label}\"{small} ");
    PreEscaped(svg.replacen("<svg ", &opened, 1))
}

fn width_px(svg: &str) -> Option<f64> {
    let (_, rest) = svg.split_once("width=\"")?;
    rest.split_once('"')?.0.parse().ok()
}

fn said(reason: &Missing) -> String {
    let mut text = reason.to_string();
    let mut cause = reason.source();
    while let Some(deeper) = cause {
        let deeper_text = deeper.to_string();
        if !text.contains(&deeper_text) {
            text += &format!(": {deeper_text}");
        }
        cause = deeper.source();
    }
    text
}

/// What was skipped, and which figures could not be drawn.
#[must_use]
pub fn skipped(study: &Study, figures: &[Drawn]) -> Vec<String> {
    let undrawn = figures.iter().filter_map(|drawn| {
        let reason = drawn.svg.as_ref().err()?;
        Some(format!("{}: {}", drawn.heading, said(reason)))
    });
    study.skipped.iter().cloned().chain(undrawn).collect()
}

fn missing(study: &Study, figures: &[Drawn]) -> Markup {
    let all = skipped(study, figures);
    html! {
        section aria-labelledby="skipped" {
            h2 #skipped { "What is missing" }
            @if all.is_empty() { p { "Nothing was skipped." } }
            @else { ul { @for reason in all { li { (reason) } } } }
        }
    }
}

/// "2 min 5 s".
#[must_use]
pub fn duration(seconds: f64) -> String {
    if !(seconds.is_finite() && seconds > 0.0) {
        return "none".into();
    }
    if seconds < 60.0 {
        return format!("{seconds:.1} s");
    }
    let whole = seconds.round() as u64;
    let (hours, minutes, rest) = (whole / 3600, whole / 60 % 60, whole % 60);
    if hours > 0 { format!("{hours} h {minutes} min") } else { format!("{minutes} min {rest} s") }
}

#[cfg(test)]
mod tests;
