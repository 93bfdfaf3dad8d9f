//! Claims over conditions made by hand, so that each verdict is known beforehand.

use super::*;
use crate::experiment::by_hand;
use crate::experiment::summary::best;
use crate::robot::LegScale;

fn condition(method: Method, leg: LegScale, amplification: f64, speed_m_s: f64, cost: f64) -> Condition {
    let [speed_m_s, power_w, cost_of_transport] =
        [speed_m_s, 10.0 * cost * speed_m_s, cost].map(|figure| by_hand::mean(figure, 0.001));
    let setpoint_speed_max_rad_s = Some(1.0);
    let plain = by_hand::condition(method, leg, amplification);
    Condition { speed_m_s, power_w, cost_of_transport, setpoint_speed_max_rad_s, ..plain }
}

/// Speeds from 0.06 to 0.13 m/s. PSTO, `advantage` cheaper than the original, is as
/// much cheaper than the sinusoid from 1.6x on, and as much dearer below.
fn study(advantage: f64) -> Vec<Condition> {
    let mut conditions = Vec::new();
    for leg in paper::LEGS {
        for method in Method::PAPERS {
            for (k, a) in paper::AMPLIFICATIONS.into_iter().enumerate() {
                let speed_m_s = 0.06 + 0.01 * k as f64;
                let cost = match method {
                    Method::Psto => 0.6,
                    Method::Sinusoid if a < MID => 0.6 - advantage,
                    _ => 0.6 + advantage,
                };
                conditions.push(condition(method, leg, a, speed_m_s, cost));
            }
        }
    }
    conditions
}

fn verdict(conditions: &[Condition], beginning: &str) -> Option<bool> {
    let claims = judge(conditions, &best(conditions), &[]);
    let found: Vec<&Claim> = claims.iter().filter(|claim| claim.text.starts_with(beginning)).collect();
    assert_eq!(found.len(), 1, "{beginning}");
    found[0].holds
}

#[test]
fn costs_in_the_papers_order_bear_the_papers_claims_and_in_the_other_order_they_do_not() {
    for (advantage, holds) in [(0.1, Some(true)), (-0.1, Some(false))] {
        let conditions = study(advantage);

        assert_eq!(verdict(&conditions, "With legs of 1 L and 2.0x, PSTO costs less"), holds);
        assert_eq!(verdict(&conditions, "With short legs the sinusoid costs least"), holds);
        assert_eq!(verdict(&conditions, "With short legs PSTO costs least"), holds);
        assert_eq!(verdict(&conditions, "At 2.2x PSTO saves energy"), holds);
        assert_eq!(verdict(&conditions, "At 0.12 m/s and with long legs"), holds);
        assert_eq!(verdict(&conditions, "Above 0.12 m/s PSTO costs less"), holds);
    }
    // Cheaper than the sinusoid in the upper half only.
    assert_eq!(verdict(&study(0.1), "With legs of 1 L, PSTO costs less than both others"), Some(false));
}

/// The same speeds everywhere: nobody is faster, and all stay below the paper's limit.
#[test]
fn equal_speeds_are_no_advantage() {
    let mut conditions = study(0.1);

    assert_eq!(verdict(&conditions, "With legs of 1 L, PSTO reaches the highest speed"), Some(false));
    assert_eq!(verdict(&conditions, "With legs of 1 L, PSTO is fastest at 2.0x"), Some(false));
    // Where 2.0x is the last that was walked, being the fastest says nothing.
    let mut cut = conditions.clone();
    cut.retain(|c| c.amplification < 2.1);
    assert_eq!(verdict(&cut, "With legs of 1 L, PSTO is fastest at 2.0x"), None);
    // One pair of legs says nothing about both.
    let one: Vec<Condition> = conditions.iter().filter(|c| c.leg == LONG).cloned().collect();
    assert_eq!(verdict(&one, "At low speeds the sinusoid costs less"), None);
    assert_eq!(verdict(&conditions, "With legs of 0.6 L, PSTO is fastest at 2.4x"), Some(true));
    assert_eq!(verdict(&conditions, "PSTO's highest speed is the same"), Some(true));
    assert_eq!(verdict(&conditions, "The robot's own limit"), Some(true));

    let at_2_0 = |c: &&mut Condition| {
        (c.method, c.leg) == (Method::Psto, LONG) && (c.amplification - 2.0).abs() < 1e-9
    };
    conditions.iter_mut().find(at_2_0).unwrap().speed_m_s = by_hand::mean(0.2, 0.001);
    assert_eq!(verdict(&conditions, "With legs of 1 L, PSTO reaches the highest speed"), Some(true));
    assert_eq!(verdict(&conditions, "With legs of 1 L, PSTO is fastest at 2.0x"), Some(true));
    assert_eq!(verdict(&conditions, "With legs of 1 L, PSTO's best cost is lower"), Some(false));
    assert_eq!(verdict(&conditions, "PSTO's highest speed is the same"), Some(false));
    assert_eq!(verdict(&conditions, "The robot's own limit"), Some(false));
}

/// With long legs the sinusoid is cheaper up to 0.09 m/s, with short ones up to 0.07.
#[test]
fn the_crossing_is_where_psto_stays_cheaper() {
    let mut conditions = study(0.1);
    for condition in &mut conditions {
        if (condition.method, condition.leg) == (Method::Sinusoid, SHORT) && condition.amplification > 1.3 {
            condition.cost_of_transport = by_hand::mean(0.7, 0.001);
        }
    }

    assert_eq!(verdict(&conditions, "PSTO becomes cheaper than the sinusoid at a lower speed"), Some(true));
    assert_eq!(verdict(&conditions, "At low speeds the sinusoid costs less"), Some(false));
}

#[test]
fn what_was_not_run_is_not_judged_and_named() {
    let mut conditions = study(0.1);
    conditions.retain(|c| c.method != Method::Sinusoid);
    for condition in &mut conditions {
        if condition.method == Method::Original && condition.amplification > 2.1 {
            condition.not_run = Some("beyond".into());
            condition.cost_of_transport = None;
        }
    }

    assert_eq!(verdict(&conditions, "With short legs the sinusoid costs least"), None);
    assert_eq!(verdict(&conditions, "Learning: longer legs"), None);
    assert_eq!(verdict(&conditions, "At 2.2x PSTO saves energy"), None);
    assert_eq!(verdict(&conditions, "The original, and not PSTO, leaves"), Some(true));
    let none: Vec<Condition> = Vec::new();
    assert!(judge(&none, &[], &[]).iter().all(|claim| claim.holds.is_none()));
}

/// Of eight amplifications one says nothing of all, nor of the best.
#[test]
fn a_few_amplifications_bear_no_claim_about_all_of_them() {
    let mut conditions = study(0.1);
    conditions.retain(|c| (c.amplification - 2.0).abs() < 1e-9);

    assert_eq!(verdict(&conditions, "With legs of 1 L and 2.0x, PSTO costs less"), Some(true));
    assert_eq!(verdict(&conditions, "With legs of 1 L, PSTO costs less than both others at every"), None);
    assert_eq!(verdict(&conditions, "With legs of 1 L, PSTO reaches the highest speed"), None);
    assert_eq!(verdict(&conditions, "With legs of 1 L, PSTO's best cost is lower"), None);
}

#[test]
fn a_condition_that_mostly_fell_bears_no_claim_and_one_trial_has_no_interval() {
    let mut conditions = study(0.1);
    let is = |c: &&mut Condition| {
        (c.method, c.leg) == (Method::Psto, LONG) && (c.amplification - 2.0).abs() < 1e-9
    };
    let psto = conditions.iter_mut().find(is).unwrap();
    psto.cost_of_transport.as_mut().unwrap().ci95 = None;

    let text = "With legs of 1 L and 2.0x, PSTO costs less";
    let claims = judge(&conditions, &best(&conditions), &[]);
    let claim = claims.iter().find(|claim| claim.text.starts_with(text)).unwrap();
    assert!(claim.evidence.contains("(from one trial: no interval)"), "{}", claim.evidence);
    let psto = conditions.iter_mut().find(is).unwrap();
    (psto.n, psto.trials, psto.falls) = (1, 3, 2);
    assert_eq!(verdict(&conditions, text), None);
}
