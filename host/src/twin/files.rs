//! Tables that a robot played and trials that it walked, as the authors' files hold them.
//!
//! Holds both formats. Columns are found by name, so others beside them do no
//! harm; `ank` is the paper's name for a knee. Impossible rows are refused.

use super::TwinError;
use crate::robot::{LegScale, Robot};
use crate::run_folder::FileError;
use protocol::{JOINT_COUNT, LEG_COUNT};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

/// One tick of the authors' tables as a pulse: 1/60 s over 4096, at their prescaler.
const TICK_US: f64 = 4.08;
/// Ticks that a 12-bit pulse counter can hold.
const TICKS: (f64, f64) = (0.0, 4095.0);

/// A method at an amplification; sorts by both.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Gait {
    /// Such as `psto`.
    pub method: String,
    /// In thousandths, so that 1 and 1.0 are the same.
    amplification_milli: i64,
}

impl Gait {
    /// A method at an amplification, which is kept to three decimals.
    #[must_use]
    pub fn new(method: &str, amplification: f64) -> Self {
        Self { method: method.to_owned(), amplification_milli: (1000.0 * amplification).round() as i64 }
    }

    /// Multiple of the table's stroke.
    #[must_use]
    pub fn amplification(&self) -> f64 {
        self.amplification_milli as f64 / 1000.0
    }
}

impl fmt::Display for Gait {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}x", self.method, self.amplification())
    }
}

/// What a robot played.
#[derive(Debug, Clone, PartialEq)]
pub struct Tables {
    tables: BTreeMap<Gait, Vec<[f64; JOINT_COUNT]>>,
}

/// The trials of one gait.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Speed, power and cost of transport of each trial.
    pub trials: Vec<[f64; 3]>,
    /// Mean of the trials' lengths, where the file tells them.
    pub duration_s: Option<f64>,
}

impl Measured {
    /// Mean over the trials of speed, power and cost of transport.
    #[must_use]
    pub fn mean(&self) -> [f64; 3] {
        let count = self.trials.len().max(1) as f64;
        core::array::from_fn(|k| self.trials.iter().map(|trial| trial[k]).sum::<f64>() / count)
    }
}

/// What a robot did with one length of legs.
#[derive(Debug, Clone, PartialEq)]
pub struct Trials {
    /// By gait.
    pub measured: BTreeMap<Gait, Measured>,
    /// The weight that the costs of transport were computed with.
    pub weight_n: f64,
}

/// A file's rows, and where its columns are.
struct Sheet {
    path: PathBuf,
    header: csv::StringRecord,
    rows: Vec<(u64, csv::StringRecord)>,
}

impl Sheet {
    fn read(path: &Path) -> Result<Self, TwinError> {
        let file = std::fs::File::open(path).map_err(FileError::on("read", path))?;
        let on_csv = |source| TwinError::Csv { path: path.to_owned(), source };
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
        let header = reader.headers().map_err(on_csv)?.clone();
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(on_csv)?;
            rows.push((record.position().map_or(0, csv::Position::line), record));
        }
        Ok(Self { path: path.to_owned(), header, rows })
    }

    /// Where the first of these names stands.
    fn find(&self, names: &[String]) -> Option<usize> {
        self.header.iter().position(|have| names.iter().any(|name| name == have))
    }

    fn column(&self, names: &[String]) -> Result<usize, TwinError> {
        self.find(names).ok_or_else(|| TwinError::Column {
            path: self.path.clone(),
            column: names[0].clone(),
            has: self.header.iter().collect::<Vec<_>>().join(", "),
        })
    }

    fn number(&self, line: u64, record: &csv::StringRecord, column: usize) -> Result<f64, TwinError> {
        let text = record.get(column).unwrap_or_default();
        text.parse().map_err(|_| TwinError::NoNumber {
            path: self.path.clone(),
            line,
            column: self.header.get(column).unwrap_or_default().to_owned(),
            text: text.to_owned(),
        })
    }

    fn within(
        &self,
        line: u64,
        column: &'static str,
        value: f64,
        (min, max): (f64, f64),
    ) -> Result<f64, TwinError> {
        if (min..=max).contains(&value) {
            Ok(value)
        } else {
            Err(TwinError::OutOfRange { path: self.path.clone(), line, column, value, min, max })
        }
    }
}

fn named(name: &str) -> Vec<String> {
    vec![name.to_owned()]
}

/// The trials' own weight may differ by this factor from the robot's: legs and batteries change.
const MOST_WEIGHTS: f64 = 3.0;

/// Amplifications that anybody would try.
const AMPLIFICATIONS: (f64, f64) = (0.001, 100.0);

impl Tables {
    /// Reads `method, amplification, sample, hip1..hip4, ank1..ank4` (or `knee1..knee4`), in ticks.
    ///
    /// # Errors
    /// [`TwinError`] naming the file, the line and the column.
    pub fn read(path: &Path) -> Result<Self, TwinError> {
        let sheet = Sheet::read(path)?;
        let [method, amplification, sample] = ["method", "amplification", "sample"];
        let (method, amplification, sample) = (
            sheet.column(&named(method))?,
            sheet.column(&named(amplification))?,
            sheet.column(&named(sample))?,
        );
        let mut joints = [0; JOINT_COUNT];
        for (j, column) in joints.iter_mut().enumerate() {
            let leg = j % LEG_COUNT + 1;
            let names: &[&str] = if j < LEG_COUNT { &["hip"] } else { &["ank", "knee"] };
            *column = sheet.column(&names.iter().map(|name| format!("{name}{leg}")).collect::<Vec<_>>())?;
        }
        let mut tables: BTreeMap<Gait, Vec<[f64; JOINT_COUNT]>> = BTreeMap::new();
        for (line, record) in &sheet.rows {
            let at = sheet.number(*line, record, amplification)?;
            sheet.within(*line, "amplification", at, AMPLIFICATIONS)?;
            let gait = Gait::new(record.get(method).unwrap_or_default(), at);
            let number = sheet.number(*line, record, sample)?;
            let mut ticks = [0.0; JOINT_COUNT];
            for (tick, column) in ticks.iter_mut().zip(joints) {
                *tick = sheet.within(*line, "a joint", sheet.number(*line, record, column)?, TICKS)?;
            }
            let text = gait.to_string();
            let table = tables.entry(gait).or_default();
            if number != table.len() as f64 {
                let (path, next) = (sheet.path.clone(), table.len());
                return Err(TwinError::Sample { path, line: *line, gait: text, value: number, next });
            }
            table.push(ticks);
        }
        Ok(Self { tables })
    }

    /// Joint angles in radians, a row a sample.
    ///
    /// # Errors
    /// [`TwinError::NoTable`] unless there is one of that gait.
    pub fn angles_rad(&self, gait: &Gait, robot: &Robot) -> Result<Vec<[f64; JOINT_COUNT]>, TwinError> {
        let table = self.tables.get(gait).ok_or_else(|| TwinError::NoTable {
            gait: gait.to_string(),
            has: self.tables.keys().map(Gait::to_string).collect::<Vec<_>>().join(", "),
        })?;
        let servo = &robot.servo;
        let angle_rad =
            |ticks: f64| ((ticks * TICK_US - servo.neutral_pulse_us) / servo.pulse_us_per_deg).to_radians();
        Ok(table.iter().map(|row| row.map(angle_rad)).collect())
    }
}

impl Trials {
    /// Reads `leg_length, method, amplification, power_w, speed_m_s, cost_of_transport`,
    /// and `duration_s` where there is such a column, of the trials with this leg.
    ///
    /// # Errors
    /// [`TwinError`] naming the file, the line and the column.
    pub fn read(path: &Path, leg: LegScale) -> Result<Self, TwinError> {
        let sheet = Sheet::read(path)?;
        let column = |name: &str| sheet.column(&named(name));
        let (leg_length, method, amplification) =
            (column("leg_length")?, column("method")?, column("amplification")?);
        let (speed, power, cost) = (column("speed_m_s")?, column("power_w")?, column("cost_of_transport")?);
        let duration = sheet.find(&named("duration_s"));
        let mut measured: BTreeMap<Gait, Measured> = BTreeMap::new();
        let mut durations: BTreeMap<Gait, Vec<f64>> = BTreeMap::new();
        let mut weights_n = Vec::new();
        let mut legs: Vec<String> = Vec::new();
        for (line, record) in &sheet.rows {
            let number = |column| sheet.number(*line, record, column);
            let length = number(leg_length)?;
            if LegScale::new(length) != Ok(leg) {
                legs.push(length.to_string());
                continue;
            }
            let at = sheet.within(*line, "amplification", number(amplification)?, AMPLIFICATIONS)?;
            let speed_m_s = sheet.within(*line, "speed_m_s", number(speed)?, (1e-4, 10.0))?;
            let power_w = sheet.within(*line, "power_w", number(power)?, (1e-3, 1e3))?;
            let cost = sheet.within(*line, "cost_of_transport", number(cost)?, (1e-3, 1e4))?;
            let gait = Gait::new(record.get(method).unwrap_or_default(), at);
            if let Some(column) = duration {
                let duration_s = sheet.within(*line, "duration_s", number(column)?, (1.0, 600.0))?;
                durations.entry(gait.clone()).or_default().push(duration_s);
            }
            weights_n.push(power_w / (speed_m_s * cost));
            let of_gait = measured.entry(gait).or_insert(Measured { trials: Vec::new(), duration_s: None });
            of_gait.trials.push([speed_m_s, power_w, cost]);
        }
        legs.sort();
        legs.dedup();
        weights_n.sort_by(f64::total_cmp);
        let Some(&weight_n) = weights_n.get(weights_n.len() / 2) else {
            let has = if legs.is_empty() { "none at all".to_owned() } else { legs.join(", ") };
            return Err(TwinError::Leg { path: path.to_owned(), leg, has });
        };
        for (gait, of_gait) in durations {
            let mean_s = of_gait.iter().sum::<f64>() / of_gait.len() as f64;
            if let Some(measured) = measured.get_mut(&gait) {
                measured.duration_s = Some(mean_s);
            }
        }
        Ok(Self { measured, weight_n })
    }

    /// Refuses trials whose numbers make another weight than the robot's: power, speed or
    /// mass in another unit.
    ///
    /// # Errors
    /// [`TwinError::Weight`].
    pub fn check_weight(&self, path: &Path, robot_n: f64) -> Result<(), TwinError> {
        let ratio = self.weight_n / robot_n;
        if (1.0 / MOST_WEIGHTS..=MOST_WEIGHTS).contains(&ratio) {
            return Ok(());
        }
        // Power is the numerator and speed the denominator.
        let likely = [
            (1000.0, "power_w in watts, or in milliwatts"),
            (0.01, "speed_m_s in m/s, or in cm/s"),
            (0.001, "speed_m_s in m/s, or in mm/s"),
        ];
        let off = |of: f64| (ratio / of).ln().abs();
        let nearest = likely.into_iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0)));
        let question = match nearest.filter(|(of, _)| off(*of) < MOST_WEIGHTS.ln()) {
            Some((_, question)) => format!("is {question}?"),
            None => "is power_w in watts, speed_m_s in m/s, and is it this robot?".to_owned(),
        };
        Err(TwinError::Weight { path: path.to_owned(), trials_n: self.weight_n, robot_n, question })
    }

    /// Those of these methods; all if none is named.
    ///
    /// # Errors
    /// [`TwinError::Method`] for a method that has no trial.
    pub fn of(&self, methods: &[String]) -> Result<Self, TwinError> {
        if let Some(method) =
            methods.iter().find(|method| !self.measured.keys().any(|gait| gait.method == **method))
        {
            let mut has: Vec<_> = self.measured.keys().map(|gait| gait.method.clone()).collect();
            has.dedup();
            return Err(TwinError::Method { method: method.clone(), has: has.join(", ") });
        }
        let wanted = |gait: &Gait| methods.is_empty() || methods.contains(&gait.method);
        let measured = self.measured.iter().filter(|(gait, _)| wanted(gait));
        Ok(Self {
            measured: measured.map(|(gait, of_gait)| (gait.clone(), of_gait.clone())).collect(),
            weight_n: self.weight_n,
        })
    }
}
