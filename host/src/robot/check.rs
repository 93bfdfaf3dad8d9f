//! What a person should know of a robot before it is built or simulated.
//!
//! Holds the findings and their limits: sizes, balance, torques, power, and
//! numbers that are likely in the wrong unit. Pure functions over a [`Robot`]
//! that is within every field's bounds. Does not depend on files or on words
//! for a terminal.

mod parts;

use super::servo_presets::{self, Basis, Stated};
use super::statics::{DIAGONALS, Standing};
use super::{Limbs, Robot};
use serde::Serialize;

/// Nearer to the ground than this is on it, as in the simulation.
const CONTACT_M: f64 = 0.001;
/// Share of its stall torque that a servo holds for long without getting hot.
const LASTING_SHARE: f64 = 0.5;
/// Least distance of the centre of mass from the feet's outline.
const LEAST_MARGIN_M: f64 = 0.005;
/// Least room between torso and ground.
const LEAST_ROOM_M: f64 = 0.005;
/// Robots of eight hobby servos.
const MASS_KG: [f64; 2] = [0.05, 10.0];
/// Thighs and shins of such robots; far beyond, the unit is wrong.
const LIMB_M: [f64; 2] = [0.01, 0.5];
const LIMB_UNIT_M: [f64; 2] = [0.003, 3.0];
/// Hinges that all turn less than this either way were meant in radians.
const LEAST_RANGE_DEG: f64 = 4.0;
/// Pulses that hobby servos understand.
const PULSE_US: [f64; 2] = [400.0, 2600.0];
/// Where a quadrant is looked for: a hip nearer to an axis is on none.
const ON_AXIS_M: f64 = 0.001;
/// How far the preset's voltage may be from the supply's.
const VOLTAGE_SHARE: f64 = 0.1;

const QUADRANTS: [&str; 4] = ["front left", "rear left", "rear right", "front right"];

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mark {
    /// Within its limits.
    Ok,
    /// Good to know.
    Note,
    /// It may work, but look at it.
    Warning,
    /// It is wrong, or cannot work.
    Error,
}

/// What a finding is about. Each occurs once, for whichever part is worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Topic {
    /// All of it.
    Mass,
    /// The longer side of what it covers, seen from above.
    Span,
    /// Of the torso's frame over the ground.
    StandingHeight,
    /// From the torso's lowest point to the ground.
    GroundClearance,
    /// Feet that touch at neutral, and nothing else does.
    GroundContact,
    /// From the centre of mass to the feet's outline, seen from above.
    Balance,
    /// Of a hip, with four feet on the ground.
    HipTorqueOnFour,
    /// Of a knee, with four feet on the ground.
    KneeTorqueOnFour,
    /// Of a hip, with two feet on the ground.
    HipTorqueOnTwo,
    /// Of a knee, with two feet on the ground.
    KneeTorqueOnTwo,
    /// Electrical, to stand on four feet.
    StandingPower,
    /// Electrical, of all servos at their most mechanical power.
    PeakPower,
    /// Voltage of the preset beside the supply's.
    ServoVoltage,
    /// What the word for the servo's torque is worth.
    ServoTorque,
    /// Pulse at an end stop.
    Pulse,
    /// What is tighter than `joint_limit_deg`.
    JointLimit,
    /// Whether each leg is in its quadrant.
    LegOrder,
    /// Hinges whose range is in another unit.
    Range,
    /// Of thighs and shins.
    LimbLength,
    /// Of a part.
    Density,
    /// Radius of gyration of a part, beside its size.
    Inertia,
}

impl Topic {
    /// For a list.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Mass => "mass",
            Self::Span => "span",
            Self::StandingHeight => "standing height",
            Self::GroundClearance => "ground clearance",
            Self::GroundContact => "feet on the ground",
            Self::Balance => "balance",
            Self::HipTorqueOnFour => "hip torque, 4 feet",
            Self::KneeTorqueOnFour => "knee torque, 4 feet",
            Self::HipTorqueOnTwo => "hip torque, 2 feet",
            Self::KneeTorqueOnTwo => "knee torque, 2 feet",
            Self::StandingPower => "power to stand",
            Self::PeakPower => "peak power",
            Self::ServoVoltage => "servo voltage",
            Self::ServoTorque => "servo torque",
            Self::Pulse => "pulse at end stop",
            Self::JointLimit => "joint limit",
            Self::LegOrder => "leg order",
            Self::Range => "joint ranges",
            Self::LimbLength => "limb lengths",
            Self::Density => "density",
            Self::Inertia => "radius of gyration",
        }
    }
}

/// One line of the list.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// About what.
    pub topic: Topic,
    /// How bad.
    pub mark: Mark,
    /// Of which joint, body or leg, where it is of one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// The number.
    pub value: f64,
    /// Of value and limits; empty for counts.
    pub unit: &'static str,
    /// Least that is good.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
    /// Most that is good.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most: Option<f64>,
    /// What follows and what to do, where it is not good.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub next: Option<String>,
}

impl Finding {
    fn new(topic: Topic, value: f64, unit: &'static str) -> Self {
        Self { topic, mark: Mark::Ok, part: None, value, unit, least: None, most: None, next: None }
    }

    fn of(mut self, part: impl Into<String>) -> Self {
        self.part = Some(part.into());
        self
    }

    fn within(mut self, least: impl Into<Option<f64>>, most: impl Into<Option<f64>>) -> Self {
        (self.least, self.most) = (least.into(), most.into());
        self
    }

    fn is_within(&self) -> bool {
        self.least.is_none_or(|least| self.value >= least) && self.most.is_none_or(|most| self.value <= most)
    }

    /// The mark and advice where the value is beyond its limits.
    fn otherwise(self, mark: Mark, next: impl Into<String>) -> Self {
        if self.is_within() { self } else { self.marked(mark, next) }
    }

    fn marked(mut self, mark: Mark, next: impl Into<String>) -> Self {
        self.mark = mark;
        self.next = Some(next.into());
        self
    }
}

/// What was found of a robot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// All of it.
    pub mass_kg: f64,
    /// What it covers at neutral: length, width and height.
    pub span_m: [f64; 3],
    /// Of the torso's frame.
    pub standing_height_m: f64,
    /// In order of [`Topic`].
    pub findings: Vec<Finding>,
}

impl Check {
    /// How many findings have this mark.
    #[must_use]
    pub fn count(&self, mark: Mark) -> usize {
        self.findings.iter().filter(|finding| finding.mark == mark).count()
    }

    /// The finding of a topic, if there is one.
    #[must_use]
    pub fn finding(&self, topic: Topic) -> Option<&Finding> {
        self.findings.iter().find(|finding| finding.topic == topic)
    }
}

/// Looks at everything.
#[must_use]
pub fn check(robot: &Robot) -> Check {
    let limbs = Limbs::of(robot);
    let standing = Standing::of(&limbs);
    let span_m = parts::span_m(&limbs, &standing);
    let mut findings = sizes(&limbs, &standing, &span_m);
    findings.extend(torques(robot, &standing));
    findings.extend(power(robot, &standing));
    findings.extend(servo(robot));
    findings.push(joint_limit(robot, &limbs));
    findings.push(leg_order(robot, &standing));
    findings.push(ranges(robot, &limbs));
    findings.push(limb_lengths(robot, &limbs));
    findings.push(parts::density(robot, &limbs));
    findings.push(parts::inertia(robot, &limbs));
    Check { mass_kg: limbs.mass_kg(), span_m, standing_height_m: standing.height_m, findings }
}

fn sizes(limbs: &Limbs, standing: &Standing<'_>, span_m: &[f64; 3]) -> Vec<Finding> {
    let mass = Finding::new(Topic::Mass, limbs.mass_kg(), "kg")
        .within(MASS_KG[0], MASS_KG[1])
        .otherwise(Mark::Warning, "eight hobby servos carry other robots; are all masses in kilograms?");
    let span = Finding::new(Topic::Span, span_m[0].max(span_m[1]), "m")
        .within(3.0 * LIMB_M[0], 4.0 * LIMB_M[1])
        .otherwise(Mark::Warning, "are all lengths in metres?");
    let height = Finding::new(Topic::StandingHeight, standing.height_m, "m");
    let lowest_m = limbs.torso.solids.iter().map(|solid| solid.lowest_m(&nalgebra::Isometry3::identity()));
    let room_m = lowest_m.fold(f64::INFINITY, f64::min) + standing.height_m;
    // A torso that touches with nothing has all the room there is.
    let room = Finding::new(
        Topic::GroundClearance,
        if room_m.is_finite() { room_m } else { standing.height_m },
        "m",
    )
    .within(LEAST_ROOM_M, None)
    .otherwise(Mark::Warning, "the torso will drag: lengthen the shins, or steepen them at neutral");
    let margin = Finding::new(Topic::Balance, standing.margin_m(), "m").within(LEAST_MARGIN_M, None);
    let margin = if margin.value < 0.0 {
        margin.marked(Mark::Error, "it tips over at neutral: move the feet or the mass")
    } else {
        margin.otherwise(Mark::Warning, "it nearly tips over at neutral: move the feet or the mass")
    };
    vec![mass, span, height, room, contact(limbs, standing), margin]
}

/// Who touches the ground at neutral.
fn contact(limbs: &Limbs, standing: &Standing<'_>) -> Finding {
    let touches = |solids: &[super::Solid], pose: &nalgebra::Isometry3<f64>| {
        solids.iter().any(|solid| solid.lowest_m(pose) + standing.height_m < CONTACT_M)
    };
    let feet: [bool; 4] = standing.clearances_m().map(|clearance_m| clearance_m < CONTACT_M);
    let count = feet.iter().filter(|foot| **foot).count();
    let finding = Finding::new(Topic::GroundContact, count as f64, "").within(4.0, 4.0);
    if touches(&limbs.torso.solids, &nalgebra::Isometry3::identity()) {
        return finding.of("torso").marked(
            Mark::Error,
            "it lies on its torso at neutral: lengthen the shins, or steepen them (geometry.shin_below_horizontal_deg)",
        );
    }
    let legs = || limbs.legs.iter().enumerate();
    if let Some((leg, _)) = legs().find(|(leg, limb)| touches(&limb.thigh.solids, &standing.thighs[*leg])) {
        return finding
            .of(format!("thigh of leg {}", leg + 1))
            .marked(Mark::Error, "it stands on a thigh, not on its feet: turn the knees' neutral");
    }
    if let Some(leg) = feet.iter().position(|foot| !foot) {
        let clearance_mm = standing.clearances_m()[leg] * 1000.0;
        return finding.of(format!("foot {}", leg + 1)).marked(
            if count < 3 { Mark::Error } else { Mark::Warning },
            format!("it hangs {clearance_mm:.1} mm over the ground: draw all legs of one height"),
        );
    }
    if let Some((leg, _)) = legs().find(|(leg, limb)| touches(&limb.shin.solids, &standing.shins[*leg])) {
        return finding.of(format!("shin of leg {}", leg + 1)).marked(
            Mark::Warning,
            "it reaches the ground beside its foot's ball, which may count as dragging: end the shin 1.5 mm above",
        );
    }
    finding
}

fn torques(robot: &Robot, standing: &Standing<'_>) -> Vec<Finding> {
    let limit_n_m = robot.servo.torque_limit_n_m;
    let names: Vec<&String> = robot.model.hips.iter().chain(&robot.model.knees).collect();
    let of = |topic, forces: &[[f64; 4]], joints: core::ops::Range<usize>| {
        let held = forces.iter().flat_map(|forces_n| {
            let held_n_m = standing.holding_n_m(forces_n);
            joints.clone().map(move |j| (j, held_n_m[j].abs()))
        });
        let (joint, held_n_m) =
            held.fold((joints.start, 0.0), |most, next| if next.1 > most.1 { next } else { most });
        Finding::new(topic, held_n_m, "N m").of(names[joint]).within(None, limit_n_m)
    };
    let shorter = "lighten the robot, shorten the lever from joint to foot, or take stronger servos";
    let judge = |finding: Finding, beyond: Mark, means: &str| {
        let share = finding.value / limit_n_m.max(1e-9);
        if share > 1.0 {
            finding.marked(beyond, format!("{means}: {shorter}"))
        } else if share > LASTING_SHARE {
            let percent = share * 100.0;
            finding.marked(
                Mark::Warning,
                format!("{percent:.0} % of the limit heats a servo that holds it: {shorter}"),
            )
        } else {
            finding
        }
    };
    let four = [standing.on_four_n()];
    let two = DIAGONALS.map(|feet| standing.on_two_n(feet));
    let fails = "the servos cannot carry the robot";
    let sinks = "it cannot stand on two feet by torque alone, and sinks in a trot";
    vec![
        judge(of(Topic::HipTorqueOnFour, &four, 0..4), Mark::Error, fails),
        judge(of(Topic::KneeTorqueOnFour, &four, 4..8), Mark::Error, fails),
        judge(of(Topic::HipTorqueOnTwo, &two, 0..4), Mark::Warning, sinks),
        judge(of(Topic::KneeTorqueOnTwo, &two, 4..8), Mark::Warning, sinks),
    ]
}

fn power(robot: &Robot, standing: &Standing<'_>) -> Vec<Finding> {
    let (power, servo, supply) = (&robot.power, &robot.servo, &robot.supply);
    // Behind its resistance a supply gives most at half its voltage.
    let most_w =
        (supply.resistance_ohm > 0.0).then(|| supply.nominal_v.powi(2) / (4.0 * supply.resistance_ohm));
    let held_n_m =
        standing.holding_n_m(&standing.on_four_n()).map(|held_n_m| held_n_m.min(servo.torque_limit_n_m));
    let heat_w: f64 = held_n_m.iter().map(|held_n_m| power.heat_w_per_n2_m2 * held_n_m.powi(2)).sum();
    // A motor's mechanical power is greatest at half torque and half speed.
    let half_n_m = servo.torque_limit_n_m / 2.0;
    let work_w = half_n_m * servo.top_speed_rad_s() / 2.0 / power.efficiency;
    let peak_w = power.electronics_w + 8.0 * (work_w + power.heat_w_per_n2_m2 * half_n_m.powi(2));
    let why = "lower supply.resistance_ohm with thicker leads or a stronger battery";
    vec![
        Finding::new(Topic::StandingPower, power.electronics_w + heat_w, "W")
            .within(None, most_w)
            .otherwise(Mark::Error, format!("the supply cannot give that: {why}")),
        Finding::new(Topic::PeakPower, peak_w, "W")
            .within(None, most_w)
            .otherwise(Mark::Warning, format!("all servos at once pull the supply down: {why}")),
    ]
}

fn servo(robot: &Robot) -> Vec<Finding> {
    let servo = &robot.servo;
    let mut findings = Vec::new();
    if let Some((name, voltage_v)) = servo.model.as_deref().zip(servo.voltage_v) {
        let nominal_v = robot.supply.nominal_v;
        findings.push(
            Finding::new(Topic::ServoVoltage, voltage_v, "V")
                .within(nominal_v * (1.0 - VOLTAGE_SHARE), nominal_v * (1.0 + VOLTAGE_SHARE))
                .otherwise(
                    Mark::Warning,
                    "supply.nominal_v is another: give servo.voltage_v what the servos get",
                ),
        );
        if let Ok(preset) = servo_presets::preset(name) {
            let finding = Finding::new(Topic::ServoTorque, servo.torque_limit_n_m, "N m").of(&preset.name);
            let source = preset.sources.iter().find(|source| source.of.contains(&Stated::Torque));
            findings.push(match source {
                Some(source) if source.basis == Basis::Claim => finding.marked(
                    Mark::Note,
                    format!(
                        "its seller's claim ({}): hang a weight on a horn to know yours",
                        source.document
                    ),
                ),
                _ => finding,
            });
        }
    }
    let ends =
        [-1.0, 1.0].map(|sign| servo.neutral_pulse_us + sign * servo.end_stop_deg * servo.pulse_us_per_deg);
    let middle_us = f64::midpoint(PULSE_US[0], PULSE_US[1]);
    let worst = if (ends[0] - middle_us).abs() > (ends[1] - middle_us).abs() { ends[0] } else { ends[1] };
    findings.push(Finding::new(Topic::Pulse, worst, "us").within(PULSE_US[0], PULSE_US[1]).otherwise(
        Mark::Warning,
        "few servos follow such a pulse: check servo.neutral_pulse_us, pulse_us_per_deg and end_stop_deg",
    ));
    findings
}

fn joint_limit(robot: &Robot, limbs: &Limbs) -> Finding {
    let names = robot.model.hips.iter().chain(&robot.model.knees);
    let either_way = limbs.stops_rad(robot).map(|[low, high]| (-low).min(high).to_degrees());
    // Rounded, so that what is equal in degrees is equal.
    let either_way = either_way.map(|deg| (deg * 1e4).round() / 1e4);
    let (name, least_deg) =
        names.zip(either_way).fold((&robot.model.hips[0], f64::INFINITY), |least, next| {
            if next.1 < least.1 { next } else { least }
        });
    let limit_deg = robot.joint_limit_deg;
    let finding = Finding::new(Topic::JointLimit, limit_deg, "deg").within(None, least_deg);
    if finding.is_within() {
        return finding;
    }
    let next = format!(
        "{name} turns only {least_deg:.1} degrees one way, by its drawn range or servo.end_stop_deg: that stops it first"
    );
    finding.of(name).marked(Mark::Note, next)
}

fn leg_order(robot: &Robot, standing: &Standing<'_>) -> Finding {
    let finding = Finding::new(Topic::LegOrder, 4.0, "").within(4.0, 4.0);
    let place = |leg: usize| {
        let (hip, foot) = (standing.joints[leg].0, standing.feet_m[leg]);
        // A hip in the middle says nothing of its side; its foot does.
        let of = |hip: f64, foot: f64| if hip.abs() < ON_AXIS_M { foot } else { hip };
        [of(hip.x, foot.x), of(hip.y, foot.y)]
    };
    let quadrant = |[x, y]: [f64; 2]| match (x >= 0.0, y >= 0.0) {
        (true, true) => 0,
        (false, true) => 1,
        (false, false) => 2,
        (true, false) => 3,
    };
    let wrong: Vec<usize> = (0..4).filter(|leg| quadrant(place(*leg)) != *leg).collect();
    let Some(&leg) = wrong.first() else { return finding };
    let at = standing.joints[leg].0;
    let next = format!(
        "leg {}, {}, sits at x {:.3}, y {:.3}: {}, but leg {} is {}; order hips, knees and feet \
         counter-clockwise from front left",
        leg + 1,
        robot.model.hips[leg],
        at.x,
        at.y,
        QUADRANTS[quadrant(place(leg))],
        leg + 1,
        QUADRANTS[leg]
    );
    Finding { value: (4 - wrong.len()) as f64, ..finding }
        .of(&robot.model.hips[leg])
        .marked(Mark::Error, next)
}

fn ranges(robot: &Robot, limbs: &Limbs) -> Finding {
    let names = robot.model.hips.iter().chain(&robot.model.knees);
    let hinges = limbs.legs.iter().map(|leg| &leg.hip).chain(limbs.legs.iter().map(|leg| &leg.knee));
    let drawn: Vec<(&String, f64)> = names
        .zip(hinges)
        .filter_map(|(name, hinge)| hinge.range_rad.map(|[low, high]| (name, (high - low).to_degrees())))
        .collect();
    let widest = drawn.iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a });
    let Some((name, widest_deg)) = widest else {
        return Finding::new(Topic::Range, 2.0 * robot.servo.end_stop_deg, "deg");
    };
    let finding = Finding::new(Topic::Range, widest_deg, "deg").of(name).within(2.0 * LEAST_RANGE_DEG, 361.0);
    // A little more than a turn is one, rounded.
    if widest_deg > 361.0 {
        let turns = widest_deg / 360.0;
        return finding
            .marked(Mark::Error, format!("that is {turns:.0} turns: URDF limits are radians, not degrees"));
    }
    finding.otherwise(
        Mark::Warning,
        "no joint turns farther: MJCF ranges are degrees unless the file says <compiler angle=\"radian\"/>",
    )
}

fn limb_lengths(robot: &Robot, limbs: &Limbs) -> Finding {
    let lengths = limbs.legs.iter().enumerate().flat_map(|(leg, limb)| {
        let hip_m = limb.hip.in_child.translation.vector;
        let thigh_m = (limb.knee.in_parent.translation.vector - hip_m).norm();
        let shin_m =
            (limb.foot_m.coords - limb.knee.in_child.translation.vector).norm() + limbs.foot_radius_m;
        [
            (format!("thigh of {}", robot.model.hips[leg]), thigh_m),
            (format!("shin of {}", robot.model.knees[leg]), shin_m),
        ]
    });
    let far = |length_m: f64| (length_m / (LIMB_M[0] * LIMB_M[1]).sqrt()).ln().abs();
    let worst = lengths.reduce(|a, b| if far(b.1) > far(a.1) { b } else { a });
    let (part, length_m) = worst.unwrap_or_default();
    let finding = Finding::new(Topic::LimbLength, length_m, "m").of(part).within(LIMB_M[0], LIMB_M[1]);
    let unit = !(LIMB_UNIT_M[0]..=LIMB_UNIT_M[1]).contains(&length_m);
    let mark = if unit { Mark::Error } else { Mark::Warning };
    finding.otherwise(mark, "are all lengths of the drawing in metres, and is geometry.leg_scale right?")
}

#[cfg(test)]
mod tests;
