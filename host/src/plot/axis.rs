//! Where an axis begins and ends, and what is written along it.
//!
//! Holds the choice of round numbers and their text. Does not depend on drawing.

/// Steps between labels, times a power of ten.
const DECIMAL: [f64; 3] = [1.0, 2.0, 5.0];
/// Steps between labels of angles; quarters of a right angle come first where they fit.
const DEGREES: [f64; 7] = [1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0];

/// A range, and the labels along it.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// What is measured, with its unit.
    pub label: String,
    /// Where it begins.
    pub least: f64,
    /// Where it ends; more than `least`.
    pub most: f64,
    /// Where numbers stand.
    pub ticks: Vec<f64>,
    /// Digits after the point that tell neighbouring ticks apart.
    decimals: usize,
    /// What stands at the ticks instead of numbers.
    names: Vec<String>,
}

impl Axis {
    /// From the first to the last of `values`, to the point.
    pub fn exact(label: &str, values: impl IntoIterator<Item = f64>, most_ticks: usize) -> Self {
        let (least, most) = range(values);
        Self::new(label, (least, most), decimal_step(most - least, most_ticks))
    }

    /// All of `values` and some air: it begins and ends at a label.
    pub fn round(label: &str, values: impl IntoIterator<Item = f64>, most_ticks: usize) -> Self {
        let (least, most) = range(values);
        Self::widened(label, (least, most), decimal_step(most - least, most_ticks))
    }

    /// The same for angles.
    pub fn degrees(label: &str, values: impl IntoIterator<Item = f64>, most_ticks: usize) -> Self {
        let (least, most) = range(values);
        let steps = (most - least) / most_ticks as f64;
        let step = DEGREES.into_iter().find(|&step| step >= steps);
        let step = step.filter(|&step| step > 1.0).unwrap_or_else(|| decimal_step(most - least, most_ticks));
        Self::widened(label, (least, most), step)
    }

    /// Things instead of numbers: the first at 1, the second at 2.
    pub fn named(names: impl IntoIterator<Item = String>) -> Self {
        let names: Vec<String> = names.into_iter().collect();
        let count = names.len();
        let ticks = (1..=count).map(|place| place as f64).collect();
        let most = count.max(1) as f64 + 0.5;
        Self { label: String::new(), least: 0.5, most, ticks, decimals: 0, names }
    }

    fn widened(label: &str, (least, most): (f64, f64), step: f64) -> Self {
        // For a hair beyond a label, half a pixel, there is no further one.
        let out = |value: f64| (value / step - 0.02).ceil() * step;
        Self::new(label, (-out(-least), out(most)), step)
    }

    fn new(label: &str, (least, most): (f64, f64), step: f64) -> Self {
        let first = (least / step - 1e-9).ceil();
        let last = (most / step + 1e-9).floor();
        let ticks = (0..=(last - first).max(0.0) as u32).map(|i| (first + f64::from(i)) * step);
        let decimals = (-(step.log10() + 1e-9).floor()).clamp(0.0, 9.0) as usize;
        Self { label: label.into(), least, most, ticks: ticks.collect(), decimals, names: Vec::new() }
    }

    /// A tick's text: thousands with commas, a minus as wide as a plus.
    #[must_use]
    pub fn text(&self, tick: f64) -> String {
        let name = self.ticks.iter().position(|&other| other == tick).and_then(|place| self.names.get(place));
        if let Some(name) = name {
            return name.clone();
        }
        // Rounded here, plus zero: there is no -0.
        let scale = 10_f64.powi(self.decimals as i32);
        let tick = (tick * scale).round() / scale + 0.0;
        let number = format!("{:.*}", self.decimals, tick.abs());
        let (whole, rest) = number.split_at(number.find('.').unwrap_or(number.len()));
        let mut text = String::from(if tick < 0.0 { "\u{2212}" } else { "" });
        for (index, digit) in whole.chars().enumerate() {
            if index > 0 && (whole.len() - index).is_multiple_of(3) {
                text.push(',');
            }
            text.push(digit);
        }
        text + rest
    }
}

/// The least and the most, apart from each other whatever there is.
fn range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let finite = values.into_iter().filter(|value| value.is_finite());
    let (least, most) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), value| (l.min(value), m.max(value)));
    if least > most {
        return (0.0, 1.0);
    }
    let too_near = (most - least) <= 1e-6 * least.abs().max(most.abs()).max(1e-3);
    let air = 0.5 * least.abs().max(1e-3);
    if too_near { (least - air, most + air) } else { (least, most) }
}

/// The least round step that gives at most so many labels.
fn decimal_step(span: f64, most_ticks: usize) -> f64 {
    let least = span / most_ticks.max(1) as f64;
    let power = 10_f64.powf(least.log10().floor());
    let steps = DECIMAL.into_iter().map(|step| step * power);
    steps.into_iter().find(|&step| step >= least * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}
