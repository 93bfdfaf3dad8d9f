//! Pictures of a searched gait: over amplitudes, and cost against speed.
//!
//! Holds their contents. What was measured on the authors' robot and what is
//! predicted here look different. Does not depend on how figures are drawn, which
//! is `crate::plot`'s.

use super::report::{AtAmplitude, OverDraws, Quantiles};
use crate::paper;
use crate::plot::{Axis, BLUE, Colour, Entry, Figure, Layer, Mark, Panel, VERMILION};
use crate::robot::{LegScale, Robot};

/// Name of the robot that the authors measured.
const ANT: &str = "Ant";
/// Black: measured, not predicted.
const MEASURED: Colour = Colour(0, 0, 0);
/// Light blue: how far the robots differ.
const BARS: Colour = Colour(86, 180, 233);
const PANEL_PX: (u32, u32) = (820, 320);

/// The best of each method on the authors' robot: speed and cost of transport, not
/// always at the same amplitude.
///
/// # Source
/// Paper, Table 2: original, sinusoid, PSTO.
#[must_use]
pub fn measured(robot: &Robot) -> Option<[(f64, f64); 3]> {
    // Points of another robot are not comparable.
    let own = |&leg: &LegScale| robot.name == ANT && robot.geometry.leg_scale == leg;
    let column = paper::LEGS.iter().position(own)?;
    Some([paper::ORIGINAL, paper::SINUSOID, paper::PSTO].map(|printed| {
        let (cost, speed_m_s) = printed.table_2[column];
        (speed_m_s, cost)
    }))
}

/// Cost of transport and speed from half the gait's stroke to one and a half.
#[must_use]
pub fn of_amplitudes(amplitudes: &[AtAmplitude]) -> Figure {
    let x = Axis::exact("amplitude", amplitudes.iter().map(|at| at.amplitude), 11);
    let panel = |title: &str, label: &str, of: fn(&OverDraws) -> &Quantiles| {
        let at = |pick: fn(&Quantiles) -> f64, only_safe: bool| -> Vec<(f64, f64)> {
            let shown = amplitudes.iter().filter(|at| at.safe || !only_safe);
            shown.map(|at| (at.amplitude, pick(of(&at.walks)))).filter(|(_, y)| y.is_finite()).collect()
        };
        let finite = |at: &&AtAmplitude| of(&at.walks).p90.is_finite() && of(&at.walks).p10.is_finite();
        let edges =
            amplitudes.iter().filter(finite).map(|at| (at.amplitude, of(&at.walks).p10, of(&at.walks).p90));
        let layers = vec![
            Layer::band(BLUE, edges),
            Layer { mark: Mark::Line, colour: BLUE, points: at(|q| q.median, false) },
            Layer { mark: Mark::Dots, colour: VERMILION, points: at(|q| q.median, true) },
        ];
        let heights: Vec<f64> = layers.iter().flat_map(|layer| &layer.points).map(|&(_, y)| y).collect();
        Panel {
            title: title.into(),
            x: x.clone(),
            y: Axis::round(label, heights, 6),
            top: None,
            layers,
            notes: vec![],
        }
    };
    Figure {
        title: "A searched gait over amplitudes, predicted".into(),
        legend: vec![
            Entry { label: "median over robots".into(), marks: vec![(Mark::Line, BLUE)] },
            Entry { label: "10 to 90 %".into(), marks: vec![(Mark::Band, BLUE)] },
            Entry { label: "bounds kept, none fell or dragged".into(), marks: vec![(Mark::Dots, VERMILION)] },
        ],
        columns: 1,
        panel_px: PANEL_PX,
        panels: vec![
            panel("Cost of transport", "cost of transport", |walks| &walks.cost_of_transport),
            panel("Speed", "speed (m/s)", |walks| &walks.speed_m_s),
        ],
    }
}

/// Gaits searched for different speeds, and what the authors measured.
#[must_use]
pub fn of_front(robot: &Robot, front: &[OverDraws]) -> Figure {
    let walks: Vec<&OverDraws> =
        front.iter().filter(|walks| walks.cost_of_transport.p90.is_finite()).collect();
    let place = |walks: &&OverDraws| (walks.speed_m_s.median, walks.cost_of_transport.median);
    let ours: Vec<(f64, f64)> = walks.iter().map(place).collect();
    // The later hides the earlier: bars first.
    let mut layers = vec![Layer { mark: Mark::Dashes, colour: BARS, points: ours.clone() }];
    for walks in walks {
        let ((x, y), speed, cost) = (place(&walks), &walks.speed_m_s, &walks.cost_of_transport);
        for points in [[(x, cost.p10), (x, cost.p90)], [(speed.p10, y), (speed.p90, y)]] {
            layers.push(Layer { mark: Mark::Line, colour: BARS, points: points.to_vec() });
        }
    }
    let theirs = measured(robot).map_or_else(Vec::new, |points| points.to_vec());
    layers.push(Layer { mark: Mark::Dots, colour: BLUE, points: ours });
    layers.push(Layer { mark: Mark::Dots, colour: MEASURED, points: theirs.clone() });
    let points = || layers.iter().flat_map(|layer| &layer.points);
    let x = Axis::round("speed (m/s)", points().map(|p| p.0).chain([0.0]).collect::<Vec<_>>(), 8);
    let y = Axis::round("cost of transport", points().map(|p| p.1).chain([0.0]).collect::<Vec<_>>(), 8);
    let mut legend = vec![
        Entry {
            label: "predicted, searched gaits: median".into(),
            marks: vec![(Mark::Dashes, BARS), (Mark::Dots, BLUE)],
        },
        Entry { label: "10 to 90 % of the robots".into(), marks: vec![(Mark::Line, BARS)] },
    ];
    if !theirs.is_empty() {
        let label = "measured by the authors: original, sinusoid, PSTO at their best";
        legend.push(Entry { label: label.into(), marks: vec![(Mark::Dots, MEASURED)] });
    }
    let title =
        format!("{}: cost of transport against speed, legs of {}", robot.name, robot.geometry.leg_scale);
    let panel = Panel { title: String::new(), x, y, top: None, layers, notes: vec![] };
    Figure { title, legend, columns: 1, panel_px: (820, 480), panels: vec![panel] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walks(speed_m_s: f64, cost: f64) -> OverDraws {
        let about = |median: f64| Quantiles { p10: 0.9 * median, median, p90: 1.1 * median };
        OverDraws {
            draws: 8,
            cost_of_transport: about(cost),
            speed_m_s: about(speed_m_s),
            forward_m: about(12.0 * speed_m_s),
            sideways_m: about(0.0),
            power_w: about(1.0),
            yaw_deg: about(1.0),
            tilt_deg: about(1.0),
            strained_share: about(0.0),
            fell: 0,
            dragged: 0,
            slower_servos: 0,
        }
    }

    #[test]
    fn the_front_shows_what_was_measured_as_measured() {
        let front = [walks(0.1, 0.4), walks(0.2, 0.3)];

        let ant = Robot::ant(LegScale::LONG).expect("the Ant");
        let svg = of_front(&ant, &front).to_svg().expect("drawn");
        let other = Robot { name: "Pony".into(), ..ant };
        let unknown = of_front(&other, &front).to_svg().expect("drawn");

        assert!(svg.contains("measured by the authors") && svg.contains("predicted"));
        assert!(!unknown.contains("measured by the authors"));
    }

    #[test]
    fn a_gait_that_stands_at_some_amplitudes_is_drawn_where_it_walks() {
        let at = |amplitude, walks, safe| AtAmplitude { amplitude, setpoint_speed_rad_s: 1.0, safe, walks };
        let mut standing = walks(0.0, 1.0);
        standing.cost_of_transport = Quantiles { p10: 5.0, median: f64::INFINITY, p90: f64::INFINITY };

        let figure = of_amplitudes(&[at(0.5, standing, false), at(1.0, walks(0.2, 0.3), true)]);

        assert!(figure.to_svg().is_ok());
    }
}
