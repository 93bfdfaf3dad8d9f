//! A new robot from a dozen answers: its drawing and its description.
//!
//! Holds the answers, what each may be, and the two files' text. Does not
//! depend on who asks, or on a disk.

use super::servo_presets::{self, PresetError};
use core::fmt::Write as _;
use thiserror::Error;

/// Mass and size of a servo up to which it is of the 9 g class.
const MICRO_KG: f64 = 0.025;
/// Half the case of a servo of the 9 g class, and of a standard one; the horn is up.
const MICRO_M: [f64; 3] = [0.0115, 0.006, 0.0135];
const STANDARD_M: [f64; 3] = [0.02, 0.01, 0.019];
/// How far a mammal's thighs slope back at neutral.
const THIGH_BACK_DEG: f64 = 30.0;
/// A mammal's knee servo sits so far down its thigh.
const KNEE_SERVO_AT: f64 = 0.75;
/// Largest setpoint that gaits may ask for, unless the servo turns less.
const JOINT_LIMIT_DEG: f64 = 45.0;
/// Controller, driver, current sensor and eight idle servos.
const ELECTRONICS_W: f64 = 0.35;

/// How the servos' horns stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mounting {
    /// Hips turn about the vertical, knees lift: the Ant.
    Sprawling,
    /// Hips and knees both pitch: the Pony.
    Mammal,
}

/// A number that is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Question {
    /// Of its flag.
    pub name: &'static str,
    /// What it is, for a person.
    pub text: &'static str,
    /// Of the number.
    pub unit: &'static str,
    /// Least and most.
    pub range: [f64; 2],
    /// Where nobody says otherwise.
    pub default: f64,
}

/// All numbers, in the order of [`Sketch::numbers`].
pub const QUESTIONS: [Question; 12] = [
    question("thigh-mm", "Thigh, from hip axis to knee axis", "mm", [15.0, 300.0], 55.0),
    question("shin-mm", "Shin, from knee axis to the foot's tip", "mm", [20.0, 400.0], 75.0),
    question("length-mm", "Body, length between front and rear hips", "mm", [40.0, 600.0], 110.0),
    question("width-mm", "Body, width between left and right hips", "mm", [30.0, 400.0], 80.0),
    question("height-mm", "Body, height", "mm", [10.0, 200.0], 40.0),
    question(
        "body-g",
        "Mass of the body with battery and boards, without servos",
        "g",
        [20.0, 8000.0],
        230.0,
    ),
    question("thigh-g", "Mass of a thigh without its servo", "g", [1.0, 1000.0], 14.0),
    question("shin-g", "Mass of a shin with its foot", "g", [1.0, 1000.0], 14.0),
    question("foot-mm", "Radius of a foot", "mm", [2.0, 40.0], 6.0),
    question(
        "slope-deg",
        "Slope of the shins below the horizontal at neutral",
        "degrees",
        [20.0, 85.0],
        60.0,
    ),
    question("supply-v", "Voltage at the servos", "V", [3.0, 12.0], 5.0),
    question("supply-ohm", "Resistance of battery and leads", "ohm", [0.01, 2.0], 0.15),
];

const fn question(
    name: &'static str,
    text: &'static str,
    unit: &'static str,
    range: [f64; 2],
    default: f64,
) -> Question {
    Question { name, text, unit, range, default }
}

/// The answers.
#[derive(Debug, Clone, PartialEq)]
pub struct Sketch {
    /// For people.
    pub name: String,
    /// How the horns stand.
    pub mounting: Mounting,
    /// Name of a preset.
    pub servo: String,
    /// By [`QUESTIONS`].
    pub numbers: [f64; 12],
}

/// An answer that cannot be.
#[derive(Debug, Error, PartialEq)]
pub enum SketchError {
    /// Beyond its question's range.
    #[error("{text} is {value} {unit}, but must be within {least} to {most} {unit}")]
    Range {
        /// The question.
        text: &'static str,
        /// The answer.
        value: f64,
        /// Of both.
        unit: &'static str,
        /// Least.
        least: f64,
        /// Most.
        most: f64,
    },
    /// The name is for people and for a file.
    #[error("the name is {name:?}; give 1 to {most} letters, digits, spaces, hyphens or underscores", most = NAME_LETTERS)]
    Name {
        /// The answer.
        name: String,
    },
    /// No servo of that name or for that voltage.
    #[error(transparent)]
    Servo(#[from] PresetError),
    /// A foot below its hip is not within reach.
    #[error(
        "a mammal's shin of {shin_mm} mm cannot bring the foot below its hip under a thigh of {thigh_mm} mm: \
         make the shin longer than {least_mm:.0} mm"
    )]
    Shin {
        /// Knee to tip.
        shin_mm: f64,
        /// Hip to knee.
        thigh_mm: f64,
        /// Least shin.
        least_mm: f64,
    },
    /// A ball larger than its shin.
    #[error("the foot's radius is {foot_mm} mm, but must be at most a quarter of the shin's {shin_mm} mm")]
    Foot {
        /// Radius.
        foot_mm: f64,
        /// Knee to tip.
        shin_mm: f64,
    },
}

/// Longest name.
const NAME_LETTERS: usize = 32;

/// Refuses a number beyond its question's range.
///
/// # Errors
/// [`SketchError::Range`]
pub fn check_number(question: &Question, value: f64) -> Result<(), SketchError> {
    let Question { text, unit, range: [least, most], .. } = *question;
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(SketchError::Range { text, value, unit, least, most })
    }
}

/// Refuses a name that is no name for people, or makes no file name.
///
/// # Errors
/// [`SketchError::Name`]
pub fn check_name(name: &str) -> Result<(), SketchError> {
    let fits = (1..=NAME_LETTERS).contains(&name.chars().count())
        && name.chars().any(|c| c.is_ascii_alphanumeric())
        && name.chars().all(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(&c));
    if fits { Ok(()) } else { Err(SketchError::Name { name: name.to_owned() }) }
}

/// A name in lower case without spaces, for files.
#[must_use]
pub fn file_stem(name: &str) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    let stem: String = name.trim().chars().map(letter).collect();
    stem.split('-').filter(|word| !word.is_empty()).collect::<Vec<_>>().join("-")
}

/// A robot's two files.
#[derive(Debug, Clone, PartialEq)]
pub struct Files {
    /// Text of `robot.toml`.
    pub description: String,
    /// Name of the drawing beside it.
    pub model_file: String,
    /// Its text, MJCF.
    pub model: String,
}

/// Numbers by name, in metres and kilograms.
struct Sizes {
    thigh_m: f64,
    shin_m: f64,
    half_m: [f64; 3],
    body_kg: f64,
    thigh_kg: f64,
    shin_kg: f64,
    foot_m: f64,
    slope_deg: f64,
    servo_kg: f64,
}

impl Default for Sketch {
    fn default() -> Self {
        Self {
            name: "My robot".to_owned(),
            mounting: Mounting::Sprawling,
            servo: "MG90S".to_owned(),
            numbers: QUESTIONS.map(|question| question.default),
        }
    }
}

impl Sketch {
    /// Refuses answers that do not fit their questions or each other.
    ///
    /// # Errors
    /// [`SketchError`] for the first.
    pub fn check(&self) -> Result<(), SketchError> {
        check_name(&self.name)?;
        for (question, value) in QUESTIONS.iter().zip(self.numbers) {
            check_number(question, value)?;
        }
        let [thigh_mm, shin_mm, .., foot_mm, _, voltage_v, _] = self.numbers;
        servo_presets::preset(&self.servo)?.at(voltage_v)?;
        if foot_mm > shin_mm / 4.0 {
            return Err(SketchError::Foot { foot_mm, shin_mm });
        }
        let least_mm = thigh_mm * THIGH_BACK_DEG.to_radians().sin() / 0.95;
        if self.mounting == Mounting::Mammal && shin_mm < least_mm {
            return Err(SketchError::Shin { shin_mm, thigh_mm, least_mm });
        }
        Ok(())
    }

    fn sizes(&self, servo_kg: f64) -> Sizes {
        let [thigh, shin, length, width, height, body, thigh_g, shin_g, foot, slope_deg, ..] = self.numbers;
        Sizes {
            thigh_m: thigh / 1000.0,
            shin_m: shin / 1000.0,
            half_m: [length, width, height].map(|size| size / 2000.0),
            body_kg: body / 1000.0,
            thigh_kg: thigh_g / 1000.0,
            shin_kg: shin_g / 1000.0,
            foot_m: foot / 1000.0,
            slope_deg,
            servo_kg,
        }
    }

    /// The robot's files.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn files(&self) -> Result<Files, SketchError> {
        self.check()?;
        let preset = servo_presets::preset(&self.servo)?;
        // Two presets have no mass: those are standard servos.
        let servo_kg = preset.mass_kg().unwrap_or(0.06);
        let model_file = format!("{}.xml", file_stem(&self.name));
        Ok(Files {
            description: self.description(preset, &model_file)?,
            model: self.model(&self.sizes(servo_kg)),
            model_file,
        })
    }

    fn description(&self, preset: &servo_presets::Preset, model_file: &str) -> Result<String, SketchError> {
        let [.., voltage_v, resistance_ohm] = self.numbers;
        let servo = preset.at(voltage_v)?.servo;
        let limit_deg = JOINT_LIMIT_DEG.min(servo.end_stop_deg);
        let name = toml::Value::String(self.name.clone());
        let (model, maker) = (&preset.name, &preset.maker);
        let listed =
            |part: &str| (1..=4).map(|leg| format!("\"{part}{leg}\"")).collect::<Vec<_>>().join(", ");
        let (hips, knees, shins, thighs) = (listed("hip"), listed("knee"), listed("shin"), listed("thigh"));
        Ok(format!(
            "# Drawn by `host robot new`. Lengths and masses are in {model_file}: correct them there.\n\
             name = {name}\n\
             joint_limit_deg = {limit_deg:?}          # largest setpoint from neutral that gaits may ask for\n\
             \n\
             [model]\n\
             file = \"{model_file}\"\n\
             torso = \"torso\"\n\
             # Legs 1 to 4: front left, rear left, rear right, front right.\n\
             hips = [{hips}]\n\
             knees = [{knees}]\n\
             feet = [{shins}]\n\
             scaled = [{thighs}, {shins}]    # what geometry.leg_scale draws out\n\
             \n\
             [servo]                         # {maker} {model}; any number given here overrides the preset's\n\
             model = \"{model}\"\n\
             voltage_v = {voltage_v:?}                 # at the servos\n\
             # neutral_pulse_us = {neutral:.1}     # `host calibrate` finds each servo's own\n\
             # pulse_us_per_deg = {scale:.3}\n\
             # torque_limit_n_m = {torque:.3}      # stall torque; claims are high\n\
             # no_load_speed_rad_s = {speed:.2}\n\
             # end_stop_deg = {stop:.1}\n\
             \n\
             [ground]\n\
             friction = 0.6                  # rubber on wood 0.6 to 0.9, hard plastic 0.3\n\
             \n\
             [power]\n\
             electronics_w = {ELECTRONICS_W}            # while nothing moves\n\
             efficiency = 0.5                # of gears and bridge: 0.4 to 0.7 is usual\n\
             \n\
             [supply]\n\
             nominal_v = {voltage_v:?}\n\
             resistance_ohm = {resistance_ohm:?}           # battery and leads\n",
            neutral = servo.neutral_pulse_us,
            scale = servo.pulse_us_per_deg,
            torque = servo.torque_limit_n_m,
            speed = servo.no_load_speed_rad_s,
            stop = servo.end_stop_deg,
        ))
    }

    fn model(&self, sizes: &Sizes) -> String {
        let Sizes {
            thigh_m, shin_m, half_m: [x, y, z], body_kg, thigh_kg, shin_kg, foot_m, servo_kg, ..
        } = *sizes;
        let case = if servo_kg <= MICRO_KG { MICRO_M } else { STANDARD_M };
        let case_text = case.map(|half| half.to_string()).join(" ");
        // A shin ends well above its foot's tip, so that the ball alone stands on the ground.
        let (rod_m, foot_kg) = (0.6 * foot_m, 0.15 * shin_kg);
        let shin_rod_kg = shin_kg - foot_kg;
        let about = match self.mounting {
            Mounting::Sprawling => {
                "Hips turn about the vertical: a positive hip turns its leg counter-clockwise, seen from above.\n    \
                 Knees lift: a positive knee lowers its foot."
            }
            Mounting::Mammal => {
                "Hips and knees pitch: a positive hip takes the foot back, a positive knee folds the leg."
            }
        };
        let name = &self.name;
        let mut text = format!(
            "<mujoco model=\"{name}\">\n  <!--\n    Drawn by `host robot new`. Metres, kilograms, degrees; x forward, y left, z up.\n    \
             As drawn is neutral. {about}\n  -->\n  <compiler angle=\"degree\"/>\n  <default>\n    \
             <default class=\"servo\"><geom type=\"box\" size=\"{case_text}\" mass=\"{servo_kg}\"/></default>\n    \
             <default class=\"thigh\"><geom type=\"capsule\" size=\"{rod_m:.5}\" mass=\"{thigh_kg}\"/></default>\n    \
             <default class=\"shin\"><geom type=\"capsule\" size=\"{rod_m:.5}\" mass=\"{shin_rod_kg:.6}\"/></default>\n    \
             <default class=\"foot\"><geom type=\"sphere\" size=\"{foot_m}\" mass=\"{foot_kg:.6}\"/></default>\n  \
             </default>\n  <worldbody>\n    <body name=\"torso\">\n      <freejoint/>\n      \
             <geom type=\"box\" size=\"{x} {y} {z}\" mass=\"{body_kg}\"/>\n"
        );
        for leg in 1..=4 {
            let (front, left) =
                (if leg == 1 || leg == 4 { 1.0 } else { -1.0 }, if leg <= 2 { 1.0 } else { -1.0 });
            let hip = format!("{} {} 0", front * x, left * y);
            let shin_end_m = shin_m - 2.0 * foot_m;
            let ball_m = shin_m - foot_m;
            let (thigh_turn, hip_axis, thigh_end, knee_servo, knee_at, knee_turn, knee_axis, shin_end, ball) =
                match self.mounting {
                    Mounting::Sprawling => (
                        format!("0 0 {}", 90 * leg - 45),
                        "0 0 1",
                        format!("{thigh_m} 0 0"),
                        format!("{thigh_m} 0 0"),
                        format!("{thigh_m} 0 0"),
                        format!("0 {} 0", sizes.slope_deg),
                        "0 1 0",
                        format!("{shin_end_m:.5} 0 0"),
                        format!("{ball_m:.5} 0 0"),
                    ),
                    Mounting::Mammal => {
                        // The foot's middle is to stand below its hip.
                        let forward = (thigh_m * THIGH_BACK_DEG.to_radians().sin() / ball_m).min(1.0).asin();
                        (
                            format!("0 {THIGH_BACK_DEG} 0"),
                            "0 1 0",
                            format!("0 0 {}", -thigh_m),
                            format!("0 0 {:.5}", -KNEE_SERVO_AT * thigh_m),
                            format!("0 0 {}", -thigh_m),
                            format!("0 {:.4} 0", -THIGH_BACK_DEG - forward.to_degrees()),
                            "0 -1 0",
                            format!("0 0 {:.5}", -shin_end_m),
                            format!("0 0 {:.5}", -ball_m),
                        )
                    }
                };
            // Strings take whatever is written to them.
            let _ = write!(
                text,
                "\n      <body name=\"servo_hip{leg}\" pos=\"{hip}\">\n        <geom class=\"servo\"/>\n      </body>\n      \
                 <body name=\"thigh{leg}\" pos=\"{hip}\" euler=\"{thigh_turn}\">\n        \
                 <joint name=\"hip{leg}\" axis=\"{hip_axis}\"/>\n        \
                 <geom class=\"thigh\" fromto=\"0 0 0 {thigh_end}\"/>\n        \
                 <body name=\"servo_knee{leg}\" pos=\"{knee_servo}\">\n          <geom class=\"servo\"/>\n        </body>\n        \
                 <body name=\"shin{leg}\" pos=\"{knee_at}\" euler=\"{knee_turn}\">\n          \
                 <joint name=\"knee{leg}\" axis=\"{knee_axis}\"/>\n          \
                 <geom class=\"shin\" fromto=\"0 0 0 {shin_end}\"/>\n          \
                 <geom class=\"foot\" pos=\"{ball}\"/>\n        </body>\n      </body>\n"
            );
        }
        text + "    </body>\n  </worldbody>\n</mujoco>\n"
    }
}

#[cfg(test)]
mod tests;
