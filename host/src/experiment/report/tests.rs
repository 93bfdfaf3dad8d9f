use super::words::{sure, verdicts};
use super::*;
use crate::experiment::materials::GaitNote;
use crate::experiment::study::{Claim, LegStudy, Parameter, Venue};
use crate::experiment::summary::{Condition, Mean};
use crate::experiment::trial::Mark;
use crate::experiment::{by_hand, figures};
use crate::robot::LegScale;

fn condition(method: Method, amplification: f64, cost: f64, speed_m_s: f64, half: f64) -> Condition {
    let [speed_m_s, power_w, cost_of_transport] =
        [speed_m_s, 0.8, cost].map(|figure| by_hand::mean(figure, half));
    Condition {
        speed_m_s,
        power_w,
        cost_of_transport,
        ..by_hand::condition(method, LegScale::LONG, amplification)
    }
}

fn study(conditions: Vec<Condition>) -> Study {
    by_hand::study(&[], conditions)
}

/// Another robot is not the authors', and the paper's lengths are not its own.
#[test]
fn a_study_of_another_robot_speaks_of_that_robot() {
    let ants = study(vec![condition(Method::Psto, 1.4, 0.6, 0.1, 0.01)]);
    let ponys = Study { robot: "Pony".into(), ..ants.clone() };
    let said = |study: &Study| {
        format!("{} {:?} {:?}", words::place(study), words::legs(study), words::caveat(study))
    };

    assert!(said(&ants).contains("authors") && said(&ants).contains("(23 cm)"), "{}", said(&ants));
    for theirs in ["authors", "23 cm", "1 L"] {
        assert!(!said(&ponys).contains(theirs), "{}", said(&ponys));
    }
    assert!(words::place(&ponys).ends_with("a simulation of Pony"));
}

/// 0.6 of PSTO beside 0.5 of the sinusoid: 20 % of 0.5 more; the paper has 0.595 and 0.639, 6.9 % less.
#[test]
fn a_psto_that_loses_is_said_to_lose_and_by_how_much() {
    let lost = study(vec![
        condition(Method::Psto, 2.0, 0.6, 0.12, 0.01),
        condition(Method::Sinusoid, 1.8, 0.5, 0.13, 0.02),
    ]);

    let verdict = &verdicts(&lost)[0];

    assert_eq!(
        verdict.headline,
        "The sinusoid gait has the lowest cost of transport, 0.500 \u{b1} 0.020 at 1.8\u{d7}. PSTO does not beat \
         the sinusoid in cost of transport: 0.600 \u{b1} 0.010 at 2.0\u{d7} against 0.500 \u{b1} 0.020 at \
         1.8\u{d7}, 20.0\u{a0}% higher; the 95\u{a0}% intervals do not overlap. In the paper it is 6.9\u{a0}% lower."
    );
    assert!(verdict.sentences.iter().any(|s| s.starts_with("PSTO does not beat the sinusoid in speed")));
}

#[test]
fn a_gait_of_the_users_own_is_called_your_gait() {
    let own = study(vec![
        condition(Method::Yours, 2.0, 0.4, 0.12, 0.01),
        condition(Method::Searched, 1.8, 0.5, 0.13, 0.02),
    ]);

    let verdict = &verdicts(&own)[0];

    assert!(
        verdict.headline.starts_with("Your gait has the lowest cost of transport"),
        "{}",
        verdict.headline
    );
    let said = verdict.sentences.join("\n");
    assert!(said.contains("that of your gait is 20.0\u{a0}% lower"), "{said}");
    assert!(said.contains("The searched gait has the second best cost of transport"), "{said}");
}

#[test]
fn a_difference_within_the_intervals_may_be_chance() {
    let of = |mean, ci95| Mean { mean, ci95 };

    assert!(sure(of(0.5, Some(0.06)), of(0.6, Some(0.05))).contains("overlap, so this may be chance"));
    assert!(sure(of(0.5, Some(0.04)), of(0.6, Some(0.05))).contains("do not overlap"));
    assert!(sure(of(0.5, None), of(0.6, Some(0.05))).contains("no interval"));
    let near = study(vec![
        condition(Method::Psto, 2.0, 0.5, 0.14, 0.03),
        condition(Method::Sinusoid, 1.8, 0.55, 0.1, 0.03),
    ]);
    let verdict = &verdicts(&near)[0];
    assert!(verdict.headline.contains("PSTO is ahead of the sinusoid in cost"), "{}", verdict.headline);
}

/// Less at 1.0 by 0.2, within the intervals at 1.2, more at 1.4; 1.6 has no rival.
#[test]
fn the_amplifications_at_which_psto_leads_are_named() {
    let psto = [(1.0, 0.5), (1.2, 0.71), (1.4, 0.9), (1.6, 0.4)];
    let sinusoid = [(1.0, 0.7), (1.2, 0.7), (1.4, 0.7)];
    let of = |method, at: &[(f64, f64)]| -> Vec<Condition> {
        at.iter().map(|&(times, cost)| condition(method, times, cost, 0.1, 0.01)).collect()
    };
    let all = study([of(Method::Psto, &psto), of(Method::Sinusoid, &sinusoid)].concat());

    let said = verdicts(&all)[0].sentences.join("\n");

    let expected = "At the same amplification PSTO costs, beside the sinusoid, less at 1.0\u{d7}; more at \
                    1.4\u{d7}; neither more nor less beyond the intervals at 1.2\u{d7}.";
    assert!(said.contains(expected), "{said}");
}

#[test]
fn whatever_comes_from_a_file_is_escaped() {
    let evil = "<script>alert(\"1\")</script>&'";
    let mut study = study(vec![condition(Method::Psto, 2.0, 0.6, 0.15, 0.01)]);
    study.conditions[0].not_run = Some(evil.into());
    study.conditions[0].marks = vec![Mark::Fell, Mark::Fell, Mark::Reversed];
    study.claims = vec![Claim { text: evil.into(), holds: None, evidence: evil.into() }];
    study.parameters = vec![Parameter { name: evil.into(), value: evil.into() }];
    study.skipped = vec![evil.into()];
    let gait = GaitNote {
        method: Method::Psto,
        command: evil.into(),
        seed: Some(3),
        simulated_s: Some(151_000.0),
        period_s: 1.5,
        gait_sha256: evil.into(),
        prepare_wall_s: Some(61.0),
        remark: Some("27 of 62 rows".into()),
    };
    study.legs = vec![LegStudy { leg: LegScale::LONG, gaits: vec![gait], learning: None, stride: None }];
    let mut figures = figures::all(&study);
    figures[0].caption = evil.into();
    figures[4].caption = evil.into();

    let page = html(&study, &figures);

    assert!(!page.contains("<script"), "{page}");
    assert!(page.matches("&lt;script&gt;alert(&quot;1&quot;)").count() >= 9, "{page}");
    assert!(page.contains("2 fell, 1 reversed, of 3 trials"));
    assert!(page.contains("1 min 1 s") && page.contains("2 min 5 s"));
    assert!(page.contains("faster than that: for them it extrapolates"));
}

#[test]
fn a_page_has_every_figure_or_the_reason_and_loads_nothing() {
    let study = study(vec![condition(Method::Psto, 2.0, 0.6, 0.12, 0.01)]);
    let figures = figures::all(&study);

    let page = html(&study, &figures);

    for drawn in &figures {
        let is_table = drawn.name == "table-2";
        let element = if is_table { "table" } else { "figure" };
        assert!(page.contains(&format!("<{element} id=\"{}\">", drawn.name)), "{}", drawn.name);
    }
    assert!(page.contains("no learning curve came with the policies"));
    assert!(page.contains("predictions, not measurements"));
    let own = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!own.contains("http://") && !own.contains("https://") && !own.contains("url("));
    let robots = html(&Study { venue: Venue::Robot, ..study }, &figures);
    assert!(!robots.contains("predictions, not measurements"));
}

#[test]
fn a_study_of_nothing_has_a_page() {
    let nothing = study(vec![]);

    let page = html(&nothing, &figures::all(&nothing));

    assert!(page.contains("there is nothing to compare"));
}
