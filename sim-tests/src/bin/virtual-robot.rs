//! The virtual robot on a pseudo-terminal, in real time.
//!
//! Holds the pacing by the wall clock, the files of ground truth and pulses, and
//! the EEPROM between runs. Does not depend on the host's commands. Its first
//! line of output is the port. Ends on Ctrl-C, on SIGTERM, after `--max-seconds`,
//! or when the firmware crashes. Longer than most files: a program and its files in one place.

use clap::Parser;
use host::robot::{LegScale, Robot};
use host::run_folder;
use miette::{IntoDiagnostic as _, Result, WrapErr as _, miette};
use sim_tests::body::JOINT_COUNT;
use sim_tests::calibrated::{calibration_in, holds_calibration, with_calibration};
use sim_tests::firmware_image::FirmwareImage;
use sim_tests::nano::{CLOCK_HZ, EEPROM_LEN};
use sim_tests::pty::Pty;
use sim_tests::virtual_robot::VirtualRobot;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Behind the wall clock by more than this, lost time is given up.
const MAX_LAG: Duration = Duration::from_millis(200);
/// Bytes that may wait on the line before the port stops taking more.
const LINE_ROOM: usize = 512;
/// How often a changed EEPROM is written to its file.
const EEPROM_CHECK: Duration = Duration::from_secs(1);

/// The robot, its firmware included, on a pseudo-terminal in real time.
#[derive(Debug, Parser)]
#[command(version)]
struct Args {
    /// Make a symbolic link to the port here
    #[arg(long, value_name = "PATH")]
    link: Option<PathBuf>,
    /// Write ground truth here: one JSON object a line, 60 a second
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Write every change of the servo pulses here: one JSON object a line
    #[arg(long, value_name = "FILE")]
    pulses: Option<PathBuf>,
    /// Do not reset the Nano when DTR rises as the port is opened
    #[arg(long)]
    no_reset_on_open: bool,
    /// How long the bootloader holds the Nano after a reset
    #[arg(long, value_name = "MS", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(..=60_000))]
    boot_delay_ms: u64,
    /// Keep the EEPROM's contents here between runs
    #[arg(long, value_name = "FILE")]
    eeprom: Option<PathBuf>,
    /// Start with a fresh board: without it, the robot is calibrated as its description says,
    /// unless the file of --eeprom holds a calibration
    #[arg(long)]
    uncalibrated: bool,
    /// The firmware image
    #[arg(long, value_name = "FILE")]
    elf: Option<PathBuf>,
    /// The robot's folder, if it is not the Ant
    #[arg(long, value_name = "FOLDER", conflicts_with = "leg")]
    robot: Option<PathBuf>,
    /// The Ant with shins of this many times 23 cm
    #[arg(long, value_name = "SCALE", default_value = "1")]
    leg: LegScale,
    /// Put the robot down a little differently; the same seed, the same way
    #[arg(long)]
    seed: Option<u64>,
    /// End after so many emulated seconds
    #[arg(long, value_name = "S", value_parser = seconds)]
    max_seconds: Option<f64>,
}

/// A time that can pass.
fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|error| format!("{error}"))?;
    if seconds > 0.0 { Ok(seconds) } else { Err("it must be above 0".to_owned()) }
}

fn main() -> Result<()> {
    let args = Args::parse();
    let stop = Arc::new(AtomicBool::new(false));
    let stopper = Arc::clone(&stop);
    ctrlc::set_handler(move || stopper.store(true, Ordering::Relaxed))
        .into_diagnostic()
        .wrap_err("cannot listen for Ctrl-C")?;

    let description = match &args.robot {
        Some(path) => Robot::load(path).into_diagnostic()?,
        None => Robot::ant(args.leg).into_diagnostic()?,
    };
    let elf = args.elf.clone().unwrap_or_else(FirmwareImage::default_path);
    let image = FirmwareImage::load(&elf).into_diagnostic()?;
    let build = if args.uncalibrated { VirtualRobot::uncalibrated } else { VirtualRobot::new };
    let mut robot = build(&image, &description, args.seed).into_diagnostic()?;
    let mut eeprom = args.eeprom.as_deref().map(|path| EepromFile::load(path, &mut robot)).transpose()?;
    let mut records = Records::create(&args)?;
    let mut port = Pty::new().into_diagnostic()?;
    if let Some(link) = &args.link {
        port.link(link).into_diagnostic()?;
    }
    // Scripts wait for this line; a full pipe or a closed one is their affair.
    let mut out = std::io::stdout();
    let _ = writeln!(out, "{}", port.path().display()).and_then(|()| out.flush());

    let outcome = run(&args, &stop, &mut robot, &mut port, &mut records, eeprom.as_mut());
    if let Some(eeprom) = &mut eeprom {
        eeprom.save(&robot)?;
    }
    records.flush()?;
    if port.dropped() > 0 {
        eprintln!("{} bytes were lost because the host did not read them", port.dropped());
    }
    outcome
}

fn run(
    args: &Args,
    stop: &AtomicBool,
    robot: &mut VirtualRobot,
    port: &mut Pty,
    records: &mut Records,
    mut eeprom: Option<&mut EepromFile>,
) -> Result<()> {
    let last_cycle = args.max_seconds.map_or(u64::MAX, |s| (s * CLOCK_HZ as f64) as u64);
    let bootloader_cycles = args.boot_delay_ms * (CLOCK_HZ / 1000);
    let mut clock = Clock::start();
    let mut eeprom_checked = Instant::now();

    while !stop.load(Ordering::Relaxed) && robot.now() < last_cycle {
        let room = LINE_ROOM.saturating_sub(robot.nano().unsent());
        let happened = port.look(room.max(1)).into_diagnostic()?;
        if happened.dtr_rose && !args.no_reset_on_open {
            robot.nano_mut().reset(bootloader_cycles);
        }
        robot.nano_mut().send(&happened.bytes);
        robot.run_until(clock.due_cycle().min(last_cycle)).into_diagnostic()?;
        let heard: Vec<u8> = robot.nano_mut().receive().into_iter().map(|(_, byte)| byte).collect();
        port.send(&heard).into_diagnostic()?;
        records.write(robot, &clock)?;
        if let Some(eeprom) = eeprom.as_deref_mut().filter(|_| eeprom_checked.elapsed() > EEPROM_CHECK) {
            eeprom.save(robot)?;
            eeprom_checked = Instant::now();
        }
    }
    if clock.given_up > Duration::ZERO {
        eprintln!(
            "the robot ran {:.2} s late: this machine is too busy for real time",
            clock.given_up.as_secs_f64()
        );
    }
    Ok(())
}

/// Emulated time by the wall clock.
struct Clock {
    zero: Instant,
    zero_unix_s: f64,
    given_up: Duration,
    last: Duration,
}

impl Clock {
    fn start() -> Self {
        let zero_unix_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |d| d.as_secs_f64());
        Self { zero: Instant::now(), zero_unix_s, given_up: Duration::ZERO, last: Duration::ZERO }
    }

    /// What time it is outside when it is `time_s` in the robot. It never goes
    /// back, however unevenly this process gets to run.
    fn unix_s(&self, time_s: f64) -> f64 {
        self.zero_unix_s + self.given_up.as_secs_f64() + time_s
    }

    /// Where the robot should be by now. Time that a suspended process missed
    /// is not made up for: servos would jump.
    fn due_cycle(&mut self) -> u64 {
        let elapsed = self.zero.elapsed().saturating_sub(self.given_up);
        let late = elapsed.saturating_sub(self.last);
        if late > MAX_LAG {
            self.given_up += late - MAX_LAG;
        }
        self.last = self.zero.elapsed().saturating_sub(self.given_up);
        (self.last.as_nanos() * u128::from(CLOCK_HZ) / 1_000_000_000) as u64
    }
}

/// The files that grow while the robot runs.
struct Records {
    truth: Option<(PathBuf, BufWriter<File>)>,
    pulses: Option<(PathBuf, BufWriter<File>)>,
}

impl Records {
    fn create(args: &Args) -> Result<Self> {
        let create = |path: &PathBuf| -> Result<_> {
            let file = File::create(path)
                .into_diagnostic()
                .wrap_err_with(|| format!("cannot create {}: does its folder exist?", path.display()))?;
            Ok((path.clone(), BufWriter::new(file)))
        };
        Ok(Self {
            truth: args.truth.as_ref().map(create).transpose()?,
            pulses: args.pulses.as_ref().map(create).transpose()?,
        })
    }

    /// Appends what happened since the last time, whole lines only.
    fn write(&mut self, robot: &mut VirtualRobot, clock: &Clock) -> Result<()> {
        let unix = |time_s: f64| clock.unix_s(time_s);
        let truth = robot.take_truth();
        append(
            &mut self.truth,
            truth.iter().map(|sample| TruthLine { unix_time_s: unix(sample.time_s), truth: sample }),
        )?;
        let bursts = robot.take_bursts();
        append(
            &mut self.pulses,
            bursts.iter().map(|burst| PulseLine {
                unix_time_s: unix(burst.stop_s),
                time_s: burst.stop_s,
                counts: std::array::from_fn(|joint| burst.counts[joint]),
            }),
        )
    }

    fn flush(&mut self) -> Result<()> {
        append(&mut self.truth, std::iter::empty::<()>())?;
        append(&mut self.pulses, std::iter::empty::<()>())
    }
}

fn append<T: serde::Serialize>(
    file: &mut Option<(PathBuf, BufWriter<File>)>,
    lines: impl Iterator<Item = T>,
) -> Result<()> {
    let Some((path, file)) = file else { return Ok(()) };
    let write = || -> std::io::Result<()> {
        for line in lines {
            serde_json::to_writer(&mut *file, &line)?;
            file.write_all(b"\n")?;
        }
        file.flush()
    };
    write().into_diagnostic().wrap_err_with(|| format!("cannot write {}: is the disk full?", path.display()))
}

/// A line of ground truth.
#[derive(serde::Serialize)]
struct TruthLine<'t> {
    unix_time_s: f64,
    #[serde(flatten)]
    truth: &'t sim_tests::virtual_robot::Truth,
}

/// A line of servo pulses, in counts of the servo driver; null is no pulse.
#[derive(serde::Serialize)]
struct PulseLine {
    unix_time_s: f64,
    time_s: f64,
    counts: [Option<u16>; JOINT_COUNT],
}

/// The EEPROM between runs.
struct EepromFile {
    path: PathBuf,
    saved: [u8; EEPROM_LEN],
}

impl EepromFile {
    fn load(path: &Path, robot: &mut VirtualRobot) -> Result<Self> {
        let mut saved = [0xFF; EEPROM_LEN];
        match std::fs::read(path) {
            Ok(bytes) => {
                saved = bytes.as_slice().try_into().map_err(|_| {
                    miette!(
                        "{} holds {} bytes, but an EEPROM has {EEPROM_LEN}: name another file with --eeprom",
                        path.display(),
                        bytes.len()
                    )
                })?;
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            Err(error) => {
                return Err(error)
                    .into_diagnostic()
                    .wrap_err_with(|| format!("cannot read {}", path.display()));
            }
        }
        // A calibration in the file is newer than the description's.
        let described = calibration_in(&robot.nano().eeprom());
        let contents = match described {
            Some(record) if !holds_calibration(&saved) => with_calibration(&saved, &record),
            _ => saved,
        };
        robot.nano_mut().set_eeprom(&contents);
        Ok(Self { path: path.to_owned(), saved })
    }

    fn save(&mut self, robot: &VirtualRobot) -> Result<()> {
        let contents = robot.nano().eeprom();
        if contents != self.saved {
            run_folder::write(&self.path, &contents).into_diagnostic()?;
            self.saved = contents;
        }
        Ok(())
    }
}
