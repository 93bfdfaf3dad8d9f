//! Points of the sweeps, one for each condition, and the trend through them.
//!
//! Holds the choice of conditions (those with a mean) and the least squares;
//! there is no trend through fewer than three different places. Does not depend
//! on how they are drawn.

use crate::experiment::method::Method;
use crate::experiment::summary::{Condition, Mean};
use crate::robot::LegScale;
use nalgebra::{DMatrix, DVector};

/// What an axis may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Of the gait's deviations from their centres.
    Amplification,
    /// Metres a second.
    Speed,
    /// Cost of transport.
    Cost,
}

impl Quantity {
    /// Beside the axis.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Amplification => "amplification (times)",
            Self::Speed => "speed (m/s)",
            Self::Cost => "cost of transport",
        }
    }

    fn of(self, condition: &Condition) -> Option<Mean> {
        match self {
            Self::Amplification => Some(Mean { mean: condition.amplification, ci95: None }),
            Self::Speed => condition.speed_m_s,
            Self::Cost => condition.cost_of_transport,
        }
    }
}

/// A condition's place in a figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Along x.
    pub x: Mean,
    /// Along y.
    pub y: Mean,
}

/// A method's conditions on one pair of legs.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Which method.
    pub method: Method,
    /// In the order of amplifications.
    pub points: Vec<Point>,
    /// Through their means.
    pub trend: Option<Quadratic>,
}

/// Every method that has a mean there, in the order of legends.
#[must_use]
pub fn series(conditions: &[Condition], leg: LegScale, x: Quantity, y: Quantity) -> Vec<Series> {
    let of = |method: Method| {
        let own = in_order(conditions, method, leg);
        let points: Vec<Point> =
            own.iter().filter_map(|c| Some(Point { x: x.of(c)?, y: y.of(c)? })).collect();
        let trend = Quadratic::through(points.iter().map(|point| (point.x.mean, point.y.mean)));
        (!points.is_empty()).then_some(Series { method, points, trend })
    };
    Method::all().filter_map(of).collect()
}

/// A method's conditions on these legs, by amplification.
#[must_use]
pub fn in_order(conditions: &[Condition], method: Method, leg: LegScale) -> Vec<&Condition> {
    let mut own: Vec<&Condition> = conditions.iter().filter(|c| c.method == method && c.leg == leg).collect();
    own.sort_by(|a, b| a.amplification.total_cmp(&b.amplification));
    own
}

/// A polynomial of second order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quadratic {
    /// Of 1, u and u², where u runs from -1 to 1 over the range.
    coefficients: [f64; 3],
    least: f64,
    most: f64,
}

impl Quadratic {
    /// Least squares, every point of the same weight; `None` of fewer than three different x.
    pub fn through(points: impl Iterator<Item = (f64, f64)>) -> Option<Self> {
        let points: Vec<(f64, f64)> = points.filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        let mut places: Vec<f64> = points.iter().map(|&(x, _)| x).collect();
        places.sort_by(f64::total_cmp);
        let (least, most) = (*places.first()?, *places.last()?);
        places.dedup_by(|a, b| (*a - *b).abs() <= 1e-9 * (most - least));
        if places.len() < 3 {
            return None;
        }
        let empty = Self { coefficients: [0.0; 3], least, most };
        let basis =
            DMatrix::from_fn(points.len(), 3, |row, power| empty.scaled(points[row].0).powi(power as i32));
        let values = DVector::from_iterator(points.len(), points.iter().map(|&(_, y)| y));
        let solved = basis.svd(true, true).solve(&values, 1e-12).ok()?;
        let coefficients = [solved[0], solved[1], solved[2]];
        coefficients.iter().all(|c| c.is_finite()).then_some(Self { coefficients, ..empty })
    }

    fn scaled(&self, x: f64) -> f64 {
        (2.0 * x - self.least - self.most) / (self.most - self.least)
    }

    /// Its value.
    #[must_use]
    pub fn at(&self, x: f64) -> f64 {
        let u = self.scaled(x);
        let [constant, linear, square] = self.coefficients;
        constant + u * (linear + u * square)
    }

    /// Over the range of its points and no further.
    #[must_use]
    pub fn drawn(&self, steps: usize) -> Vec<(f64, f64)> {
        let at = |step: usize| {
            let x = self.least + (self.most - self.least) * step as f64 / steps as f64;
            (x, self.at(x))
        };
        (0..=steps).map(at).collect()
    }
}
