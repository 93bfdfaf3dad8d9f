//! `host robot new`: a folder from a dozen answers.
//!
//! Holds flags, questions and the folder's place; what an answer may be and
//! the files' text are [`crate::robot::sketch`]'s. The folder appears whole
//! or not at all.

use super::check;
use crate::cli::explain::{failure, failure_with_help};
use crate::cli::{Cause, Failure};
use crate::robot::check::{Mark, check};
use crate::robot::servo_presets::{preset, presets};
use crate::robot::sketch::{Mounting, QUESTIONS, Question, Sketch, check_name, check_number, file_stem};
use crate::robot::{DESCRIPTION, Robot};
use crate::run_folder::{self, FileError};
use clap::ValueEnum;
use std::io::{self, BufRead as _};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Make a robot's folder: asks for lengths, masses, servo and mounting.
///
/// Each answer may be given as a flag and is then not asked for; an empty answer takes the one in
/// brackets, and --yes takes all of those. Lengths are between axes. The folder holds robot.toml
/// and the drawing, and passes `host robot check`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder to make [default: the name, in lower case]
    folder: Option<PathBuf>,
    /// What the robot is called
    #[arg(long)]
    name: Option<String>,
    /// How the horns stand
    #[arg(long, value_enum)]
    mounting: Option<MountingFlag>,
    /// The servos, all eight alike: MG90S, MG996R, DS3218... [default: MG90S]
    #[arg(long, value_name = "MODEL")]
    servo: Option<String>,
    #[command(flatten)]
    numbers: Numbers,
    /// Ask nothing: whatever is not given as a flag is as in the brackets
    #[arg(long)]
    yes: bool,
}

/// One for each of [`QUESTIONS`].
#[derive(Debug, clap::Args)]
struct Numbers {
    /// Thigh, from hip axis to knee axis
    #[arg(long, value_name = "MM")]
    thigh_mm: Option<f64>,
    /// Shin, from knee axis to the foot's tip
    #[arg(long, value_name = "MM")]
    shin_mm: Option<f64>,
    /// Body, length between front and rear hips
    #[arg(long, value_name = "MM")]
    length_mm: Option<f64>,
    /// Body, width between left and right hips
    #[arg(long, value_name = "MM")]
    width_mm: Option<f64>,
    /// Body, height
    #[arg(long, value_name = "MM")]
    height_mm: Option<f64>,
    /// Mass of the body with battery and boards, without servos
    #[arg(long, value_name = "G")]
    body_g: Option<f64>,
    /// Mass of a thigh without its servo
    #[arg(long, value_name = "G")]
    thigh_g: Option<f64>,
    /// Mass of a shin with its foot
    #[arg(long, value_name = "G")]
    shin_g: Option<f64>,
    /// Radius of a foot
    #[arg(long, value_name = "MM")]
    foot_mm: Option<f64>,
    /// Slope of the shins below the horizontal at neutral; sprawling only
    #[arg(long, value_name = "DEG")]
    slope_deg: Option<f64>,
    /// Voltage at the servos
    #[arg(long, value_name = "V")]
    supply_v: Option<f64>,
    /// Resistance of battery and leads
    #[arg(long, value_name = "OHM")]
    supply_ohm: Option<f64>,
}

impl Numbers {
    fn in_order(&self) -> [Option<f64>; 12] {
        let Self { thigh_mm, shin_mm, length_mm, width_mm, height_mm, body_g, .. } = *self;
        let Self { thigh_g, shin_g, foot_mm, slope_deg, supply_v, supply_ohm, .. } = *self;
        [
            thigh_mm, shin_mm, length_mm, width_mm, height_mm, body_g, thigh_g, shin_g, foot_mm, slope_deg,
            supply_v, supply_ohm,
        ]
    }
}

/// How the horns stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MountingFlag {
    /// Hips turn about the vertical, knees lift, like the Ant
    Sprawling,
    /// Hips and knees both pitch, like the Pony
    Mammal,
}

impl MountingFlag {
    fn of(text: &str) -> Result<Self, NewError> {
        let text = text.to_lowercase();
        let starts = |name: &str| !text.is_empty() && name.starts_with(&text);
        match (starts("sprawling"), starts("mammal")) {
            (true, _) => Ok(Self::Sprawling),
            (_, true) => Ok(Self::Mammal),
            _ => Err(NewError::Mounting { text }),
        }
    }

    fn to_sketch(self) -> Mounting {
        match self {
            Self::Sprawling => Mounting::Sprawling,
            Self::Mammal => Mounting::Mammal,
        }
    }
}

#[derive(Debug, Error)]
enum NewError {
    #[error("{} is there already: name another folder", .path.display())]
    Taken { path: PathBuf },
    #[error("the mounting is {text:?}; answer sprawling or mammal")]
    Mounting { text: String },
    #[error("{text:?} is not a number")]
    Number { text: String },
    #[error("the input ended before this was answered: {question}; nothing was written")]
    Ended { question: String },
    #[error("{name} would have {errors}; nothing was written")]
    Unfit { name: String, errors: String },
}

/// Asks for what no flag gives.
struct Asker {
    asks: bool,
}

impl Asker {
    /// The answer to a question that `read` accepts; asked again until it does.
    fn ask<T>(
        &self,
        question: &str,
        default: &str,
        read: impl Fn(&str) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        if !self.asks {
            return read(default);
        }
        loop {
            eprint!("{question} [{default}]: ");
            let mut line = String::new();
            let ended = || {
                let error = NewError::Ended { question: question.to_owned() };
                failure_with_help(
                    Cause::Usage,
                    error,
                    "give the rest as flags, or --yes for what is in the brackets",
                )
            };
            match io::stdin().lock().read_line(&mut line) {
                Ok(bytes) if bytes > 0 => {}
                _ => return Err(ended()),
            }
            let answer = line.trim();
            match read(if answer.is_empty() { default } else { answer }) {
                Ok(value) => return Ok(value),
                Err(refused) => eprintln!("  {}", refused.report),
            }
        }
    }
}

fn usage(error: impl std::error::Error + Send + Sync + 'static) -> Failure {
    failure(Cause::Usage, error)
}

pub fn run(args: Args) -> Result<(), Failure> {
    // Flags first: a bad one is refused before anything is asked.
    let given = args.numbers.in_order();
    for (question, value) in QUESTIONS.iter().zip(given) {
        value.map_or(Ok(()), |value| check_number(question, value)).map_err(usage)?;
    }
    args.name.as_deref().map_or(Ok(()), check_name).map_err(usage)?;
    args.servo.as_deref().map(preset).transpose().map_err(usage)?;
    args.folder.as_deref().map_or(Ok(()), check_free)?;

    let sketch = answers(&args, given)?;
    let folder = args.folder.unwrap_or_else(|| PathBuf::from(file_stem(&sketch.name)));
    check_free(&folder)?;
    write(&sketch, &folder)?;
    println!("\nNext: cargo run -p host -- robot check {}", folder.display());
    Ok(())
}

/// What flags and answers say together.
fn answers(args: &Args, given: [Option<f64>; 12]) -> Result<Sketch, Failure> {
    let asker = Asker { asks: !args.yes };
    let fallback = Sketch::default();
    let name = match &args.name {
        Some(name) => name.clone(),
        None => asker
            .ask("Name", &fallback.name, |text| check_name(text).map(|()| text.to_owned()).map_err(usage))?,
    };
    let mounting = match args.mounting {
        Some(mounting) => mounting,
        None => asker.ask(
            "How the horns stand: sprawling (hips turn about the vertical, as the Ant's) or mammal (hips pitch, as \
             the Pony's)",
            "sprawling",
            |text| MountingFlag::of(text).map_err(usage),
        )?,
    };
    let servo = match &args.servo {
        Some(servo) => servo.clone(),
        None => {
            let names: Vec<&str> = presets().iter().map(|preset| preset.name.as_str()).collect();
            let question = format!("Servo, one of {}", names.join(", "));
            asker.ask(&question, &fallback.servo, |text| {
                preset(text).map(|preset| preset.name.clone()).map_err(usage)
            })?
        }
    };
    let mut numbers = fallback.numbers;
    for (k, question) in QUESTIONS.iter().enumerate() {
        let is_slope = question.name == "slope-deg";
        numbers[k] = match given[k] {
            Some(value) => value,
            // A mammal's shins slope as its feet come below its hips.
            None if is_slope && mounting == MountingFlag::Mammal => question.default,
            None => ask_number(&asker, question, &servo)?,
        };
    }
    let sketch = Sketch { name, mounting: mounting.to_sketch(), servo, numbers };
    sketch.check().map_err(usage)?;
    Ok(sketch)
}

fn ask_number(asker: &Asker, question: &Question, servo: &str) -> Result<f64, Failure> {
    // The servo's own voltages decide what is usual.
    let default = match preset(servo) {
        Ok(preset) if question.name == "supply-v" => {
            let [least_v, most_v] = preset.voltages_v();
            question.default.clamp(least_v, most_v.max(question.default))
        }
        _ => question.default,
    };
    let text = format!("{}, in {}", question.text, question.unit);
    asker.ask(&text, &default.to_string(), |text| {
        let value: f64 = text.parse().map_err(|_| usage(NewError::Number { text: text.to_owned() }))?;
        check_number(question, value).map_err(usage)?;
        if question.name == "supply-v" {
            preset(servo).and_then(|preset| preset.at(value)).map_err(usage)?;
        }
        Ok(value)
    })
}

fn check_free(folder: &Path) -> Result<(), Failure> {
    let error = NewError::Taken { path: folder.to_owned() };
    if folder.exists() { Err(failure(Cause::Usage, error)) } else { Ok(()) }
}

/// Writes the folder, whole and checked.
fn write(sketch: &Sketch, folder: &Path) -> Result<(), Failure> {
    let machine = |error: FileError| failure(Cause::Machine, error);
    let files = sketch.files().map_err(usage)?;
    let parent = folder.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(parent).map_err(FileError::on("create", parent)).map_err(machine)?;
    // Beside its place, so that a rename puts it there at once.
    let staged = tempfile::Builder::new()
        .prefix(".robot-")
        .tempdir_in(parent)
        .map_err(FileError::on("create", folder))
        .map_err(machine)?;
    run_folder::write(&staged.path().join(&files.model_file), files.model.as_bytes()).map_err(machine)?;
    run_folder::write(&staged.path().join(DESCRIPTION), files.description.as_bytes()).map_err(machine)?;
    let robot = Robot::load(staged.path()).map_err(|error| failure(Cause::Input, error))?;
    let found = check(&robot);
    check::print(&robot, &found);
    let errors = found.count(Mark::Error);
    if errors > 0 {
        let error = NewError::Unfit { name: sketch.name.clone(), errors: check::counted(errors, "error") };
        let help = "the lines marked ERROR say why: give other lengths, masses or servos";
        return Err(failure_with_help(Cause::Input, error, help));
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        // Temporary folders are private; this one is to stay.
        std::fs::set_permissions(staged.path(), std::fs::Permissions::from_mode(0o755))
            .map_err(FileError::on("create", folder))
            .map_err(machine)?;
    }
    std::fs::rename(staged.path(), folder).map_err(FileError::on("create", folder)).map_err(machine)?;
    // It has gone to its place: there is nothing left to remove.
    let _ = staged.keep();
    println!("\n{}: {DESCRIPTION} and {}", folder.display(), files.model_file);
    Ok(())
}
