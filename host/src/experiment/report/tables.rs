//! The tables of the report.
//!
//! Holds their columns. Each has headers that a screen reader can follow, and
//! scrolls sideways where the screen is narrow. Does not depend on the rest of
//! the page.

use super::duration;
use crate::experiment::energy_balance::EnergyBalance;
use crate::experiment::figures::best::{HEADER, NOTHING, rows};
use crate::experiment::study::{Claim, LegStudy, Parameter};
use crate::experiment::summary::{Best, Condition, Mean};
use maud::{Markup, html};

/// A table that may be wider than the screen.
fn scrolled(label: &str, table: &Markup) -> Markup {
    html! { div.scroll tabindex="0" role="group" aria-label=(label) { (table) } }
}

fn head(columns: &[(&str, bool)]) -> Markup {
    html! {
        thead {
            tr { @for (name, is_number) in columns { th scope="col" class=[is_number.then_some("number")] { (name) } } }
        }
    }
}

/// Table 2, the paper's numbers beside ours.
pub fn best(robot: &str, best: &[Best]) -> Markup {
    let columns: Vec<(&str, bool)> =
        HEADER.iter().enumerate().map(|(index, name)| (*name, index >= 2)).collect();
    let strong = |text: &str, is_best: bool| html! { @if is_best { strong { (text) } } @else { (text) } };
    let table = html! {
        table #table-2 {
            caption {
                span {
                    "The least cost of transport and the highest speed, each with the amplification it was \
                     reached at; the best on each pair of legs is bold."
                }
            }
            (head(&columns))
            tbody {
                @for row in rows(robot, best) {
                    tr class=[row.first.then_some("first")] {
                        td.leg { (row.leg) }
                        th scope="row" { (row.method) }
                        td.number { (strong(&row.cost, row.is_least)) }
                        td.number { (row.paper_cost) }
                        td.number { (strong(&row.speed, row.is_fastest)) }
                        td.number { (row.paper_speed) }
                    }
                }
            }
        }
    };
    scrolled("Table 2", &table)
}

/// Section 3, claim by claim.
pub fn claims(claims: &[Claim]) -> Markup {
    if claims.is_empty() {
        return html! { p { "No claim was judged." } };
    }
    let count = |verdict: Option<bool>| claims.iter().filter(|claim| claim.holds == verdict).count();
    let table = html! {
        table {
            (head(&[("the paper says", false), ("here it", false), ("because", false)]))
            tbody {
                @for claim in claims {
                    tr {
                        td.wide { (claim.text) }
                        td {
                            @match claim.holds {
                                Some(true) => span.holds { "\u{2713} holds" }
                                Some(false) => span.fails { "\u{2717} does not hold" }
                                None => span.open { "? not judged" }
                            }
                        }
                        td.wide { (claim.evidence) }
                    }
                }
            }
        }
    };
    html! {
        p {
            "Claims that hold here: " (count(Some(true))) "; that do not hold: " (count(Some(false)))
            "; that could not be judged: " (count(None)) ". Percentages in brackets are the paper\u{2019}s words; those \
            that follow from its Table 2 may differ. Slow speeds are the lower half of those that both walk; methods \
            are compared at 21 of them, evenly spaced."
        }
        (scrolled("The paper\u{2019}s claims", &table))
    }
}

/// Where the energy goes, as parts of the cost of transport.
pub fn energy_balance(balances: &[EnergyBalance]) -> Markup {
    let table = html! {
        table {
            caption { span {
                "Parts of the cost of transport of each method where it is cheapest, from a walk of the simulated robot \
                 in which every joule is followed."
            } }
            (head(&[
                ("legs", true), ("method", false), ("at", true), ("electronics", true), ("slipping soles", true),
                ("braking", true), ("landing feet", true), ("rest", true), ("all", true),
            ]))
            tbody {
                @for of in balances {
                    tr {
                        td.number { (of.leg) }
                        th scope="row" { (of.method.label()) }
                        td.number { (format!("{:?}\u{d7}", of.amplification)) }
                        @for (_, part) in of.parts() { td.number { (format!("{part:.3}")) } }
                        td.number { (format!("{:.3}", of.total())) }
                    }
                }
            }
        }
    };
    scrolled("Where the energy goes", &table)
}

/// What is in no mean, and why.
pub fn left_out(conditions: &[Condition]) -> Markup {
    let marked: Vec<&Condition> = conditions.iter().filter(|c| !c.marks.is_empty()).collect();
    let not_run: Vec<&Condition> = conditions.iter().filter(|c| c.not_run.is_some()).collect();
    html! {
        h3 { "Trials that do not count" }
        @if marked.is_empty() { p { "Every trial counts." } }
        @else {
            ul {
                @for condition in marked {
                    li { (name(condition)) ": " (marks(condition)) ", of " (condition.trials) " trials" }
                }
            }
        }
        h3 { "Conditions that were not run" }
        @if not_run.is_empty() { p { "Every condition was run." } }
        @else {
            ul {
                @for condition in not_run {
                    li { (name(condition)) ": " (condition.not_run.as_deref().unwrap_or_default()) }
                }
            }
        }
    }
}

fn name(condition: &Condition) -> String {
    let Condition { method, leg, amplification, .. } = condition;
    format!("{}, {leg}, {amplification:?}\u{d7}", method.label())
}

/// "2 fell, 1 reversed".
fn marks(condition: &Condition) -> String {
    let mut counted: Vec<(&str, usize)> = Vec::new();
    for text in condition.marks.iter().map(|mark| mark.text()) {
        match counted.iter_mut().find(|(other, _)| *other == text) {
            Some((_, count)) => *count += 1,
            None => counted.push((text, 1)),
        }
    }
    counted.iter().map(|(text, count)| format!("{count} {text}")).collect::<Vec<_>>().join(", ")
}

/// Every condition with its means.
pub fn conditions(conditions: &[Condition]) -> Markup {
    let shown = |mean: Option<Mean>| mean.map_or(NOTHING.into(), |mean| mean.text(3));
    let table = html! {
        table {
            caption { span { "Means over the trials that count, with 95 % intervals." } }
            (head(&[
                ("method", false), ("legs", true), ("amplification", true), ("trials", true), ("count", true),
                ("speed (m/s)", true), ("power (W)", true), ("cost of transport", true),
                ("fastest setpoint (rad/s)", true),
            ]))
            tbody {
                @for condition in conditions {
                    tr {
                        th scope="row" { (condition.method.label()) }
                        td.number { (condition.leg) }
                        td.number { (format!("{:.1}", condition.amplification)) }
                        td.number { (condition.trials) }
                        td.number { (condition.n) }
                        @if condition.not_run.is_some() {
                            td.number colspan="3" { "not run" }
                        } @else {
                            td.number { (shown(condition.speed_m_s)) }
                            td.number { (shown(condition.power_w)) }
                            td.number { (shown(condition.cost_of_transport)) }
                        }
                        td.number {
                            (condition.setpoint_speed_max_rad_s.map_or(NOTHING.into(), |s| format!("{s:.2}")))
                        }
                    }
                }
            }
        }
    };
    html! { h3 { "Means" } (scrolled("Every condition", &table)) }
}

/// Where the gaits come from.
pub fn gaits(legs: &[LegStudy]) -> Markup {
    if legs.iter().all(|leg| leg.gaits.is_empty()) {
        return html! { p { "No gait is described." } };
    }
    let table = html! {
        table {
            caption { span { "Each with the command and the seed that made it, and the SHA-256 of the table that is played." } }
            (head(&[
                ("legs", true), ("method", false), ("stride (s)", true), ("seed", true), ("simulated for it (s)", true),
                ("made by", false), ("SHA-256", false), ("made in this study", true),
            ]))
            tbody {
                @for (leg, gait) in legs.iter().flat_map(|leg| leg.gaits.iter().map(move |gait| (leg, gait))) {
                    tr {
                        td.number { (leg.leg) }
                        th scope="row" { (gait.method.label()) }
                        td.number { (format!("{:.3}", gait.period_s)) }
                        td.number { (gait.seed.map_or(NOTHING.into(), |seed| seed.to_string())) }
                        td.number { (gait.simulated_s.map_or(NOTHING.into(), |seconds| format!("{seconds:.0}"))) }
                        td.wide {
                            code { (gait.command) }
                            @if let Some(remark) = &gait.remark { br; (remark) "." }
                        }
                        td.wide { code { (gait.gait_sha256) } }
                        td.number { (gait.prepare_wall_s.map_or("no: before".into(), duration)) }
                    }
                }
            }
        }
    };
    scrolled("The gaits", &table)
}

/// Robots and presets, folded up: every number of them.
pub fn descriptions(descriptions: &[Parameter]) -> Markup {
    html! {
        @for description in descriptions {
            details {
                summary { (description.name) }
                pre { code { (description.value) } }
            }
        }
    }
}

/// Everything that was chosen.
pub fn parameters(parameters: &[Parameter]) -> Markup {
    if parameters.is_empty() {
        return html! { p { "None is stated." } };
    }
    let table = html! {
        table {
            (head(&[("parameter", false), ("value", false)]))
            tbody {
                @for parameter in parameters {
                    tr { th scope="row" { (parameter.name) } td { code { (parameter.value) } } }
                }
            }
        }
    };
    scrolled("Parameters", &table)
}
