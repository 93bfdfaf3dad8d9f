//! Terms by hand, no term without its places, and the order of summation.

use super::*;

fn walking() -> Observed {
    Observed {
        torso_height_m: 0.15,
        velocity_m_s: [0.12, -0.03],
        yaw_rad: -0.2,
        action: [0.5, -0.5, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0],
        joint_positions: [0.5, -0.5, 0.995, 0.0, 0.0, 0.0, 0.0, -1.01],
        joint_speeds_rad_s: [2.0, -1.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0],
        servo_power_w: 0.6,
        touching_legs: 1,
        fell: false,
    }
}

/// Every weight is 0.
fn nothing() -> RewardConfig {
    RewardConfig { alive: 0.0, forward: 0.0, electricity: 0.0, stall: 0.0, ..without_costs() }
}

fn without_costs() -> RewardConfig {
    RewardConfig { joint_at_limit: 0.0, feet_collision: 0.0, ..RewardConfig::default() }
}

fn term(terms: RewardTerms, name: &str) -> f64 {
    terms.by_name().find(|(term, _)| *term == name).unwrap_or_else(|| panic!("no term {name}")).1
}

fn assert_near(value: f64, expected: f64) {
    assert!((value - expected).abs() < 1e-12, "{value} is not {expected}");
}

#[test]
fn the_papers_five_terms_are_as_worked_out_by_hand() {
    let terms = RewardConfig::default().weigh(&walking());

    assert_near(term(terms, "alive"), 1.0);
    assert_near(term(terms, "forward"), 0.12);
    // |0.5*2| + |0.5*1| + |1*0| + |1*1| = 2.5, by 0.1, over 8, by -2; squares 0.25+0.25+1+1 = 2.5.
    assert_near(term(terms, "electricity"), -2.0 * 0.25 / 8.0);
    assert_near(term(terms, "stall"), -0.1 * 2.5 / 8.0);
    assert_near(term(terms, "joint_at_limit"), -0.2);
    assert_near(term(terms, "feet_collision"), -1.0);
    for ours in ["fall", "drift", "heading"] {
        assert_near(term(terms, ours), 0.0);
    }
    assert_near(terms.sum(), 1.0 + 0.12 - 0.09375 - 0.2 - 1.0);
}

#[test]
fn a_torso_at_five_centimetres_or_less_is_not_alive() {
    let lying = Observed { torso_height_m: 0.05, ..walking() };

    assert_near(term(RewardConfig::default().weigh(&lying), "alive"), -1.0);
}

#[test]
fn electricity_can_be_the_servos_true_power() {
    let config = RewardConfig { electricity_form: Electricity::ServoPower, electricity: -0.5, ..nothing() };

    assert_near(config.weigh(&walking()).sum(), -0.3);
}

#[test]
fn drift_and_heading_cost_either_way() {
    let config = RewardConfig { drift: -1.0, heading: -0.5, ..nothing() };

    assert_near(config.weigh(&walking()).sum(), -0.03 - 0.1);
}

/// Floating-point sums depend on the order, and a trained policy on every bit of them.
#[test]
fn the_order_of_summation_stays() {
    let config = RewardConfig { fall: -5.0, drift: -0.3, heading: -0.2, ..RewardConfig::default() };
    for step in 0..1_000 {
        let wave = |k: usize| (f64::from(step) * 0.37 + k as f64 * 1.91).sin();
        let seen = Observed {
            torso_height_m: 0.05 + 0.04 * wave(1),
            velocity_m_s: [wave(2), wave(3)],
            yaw_rad: wave(4),
            action: std::array::from_fn(|j| wave(5 + j)),
            joint_positions: std::array::from_fn(|j| 1.2 * wave(13 + j)),
            joint_speeds_rad_s: std::array::from_fn(|j| 3.0 * wave(21 + j)),
            servo_power_w: wave(29).abs(),
            touching_legs: step as usize % 3,
            fell: step % 7 == 0,
        };
        let term = |name| term(config.weigh(&seen), name);

        let written_out = (term("alive") + term("fall"))
            + term("forward")
            + (term("electricity") + term("stall"))
            + term("joint_at_limit")
            + term("feet_collision")
            + (term("drift") + term("heading"));
        assert_eq!(config.weigh(&seen).sum().to_bits(), written_out.to_bits(), "step {step}");
    }
}

/// A weight without a row would be read from a file and then do nothing.
#[test]
fn every_weight_of_the_configuration_has_a_row_and_every_row_a_weight_of_its_name() {
    const NO_WEIGHTS: [&str; 2] = ["alive_height_m", "electricity_form"];
    let file = toml::Table::try_from(nothing()).unwrap();
    let weights: Vec<&str> =
        file.keys().map(String::as_str).filter(|name| !NO_WEIGHTS.contains(name)).collect();
    for name in &weights {
        assert!(TERMS.iter().any(|term| term.name == *name), "{name} of RewardConfig has no row in TERMS");
    }
    assert_eq!(weights.len(), TERMS.len(), "a name is in TERMS twice, or without a weight");

    for name in weights {
        let mut file = file.clone();
        file.insert(name.to_owned(), 7.0.into());
        let config: RewardConfig = file.try_into().unwrap();

        for term in &TERMS {
            let expected = if term.name == name { 7.0 } else { 0.0 };
            assert_eq!((term.weight)(&config), expected, "the row {} takes the weight {name}", term.name);
        }
    }
}

/// A part that is not in [`Part::ALL`] would be left out of the sum.
#[test]
fn every_term_is_in_the_sum() {
    for (index, term) in TERMS.iter().enumerate() {
        let mut terms = RewardTerms::default();
        terms.0[index] = 1.0;

        assert_eq!(terms.sum(), 1.0, "{} is not added: its part is not in Part::ALL", term.name);
    }
}

#[test]
fn every_term_is_in_the_papers_preset_and_in_the_documentation() {
    let read = |path: &str| {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
        std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    };
    let preset: toml::Table = read("configs/paper.toml").parse().unwrap();
    let documentation = read("../docs/learning.md");
    for Term { name, .. } in &TERMS {
        assert!(
            preset["env"]["reward"].get(name).is_some(),
            "{name} has no weight in host/configs/paper.toml, [env.reward]"
        );
        assert!(
            documentation.lines().any(|line| line.starts_with(&format!("| `{name}`"))),
            "{name} has no row in docs/learning.md, \"Reward\""
        );
    }
}
