//! Three views of a robot at neutral, as a drawing: top, side and front.
//!
//! Holds the projection, what hides what, and the SVG. Draws what touches
//! the ground, a line along each limb where nothing does, joint axes, feet, the
//! centre of mass, the ground and a scale bar. Does not depend on files.

mod paper;

use super::check::Check;
use super::statics::Standing;
use super::{Limbs, Robot, Shape, Solid};
use core::f64::consts::TAU;
use nalgebra::{Isometry3, Point2, Point3, Vector2, Vector3};
use paper::{Paper, Style};

/// Between views and around them.
const GAP_PX: f64 = 56.0;
/// Most that the two longer sides may take.
const WIDTH_PX: f64 = 860.0;
const HEIGHT_PX: f64 = 640.0;
/// Narrowest column for words.
const WORDS_PX: f64 = 250.0;
/// Corners of a circle that is seen from the side.
const CORNERS: usize = 48;
/// Between feet that are labelled together.
const NEAR_PX: f64 = 14.0;

const TORSO: Style = Style { fill: "#b9c6d3", line: "#3c4c5c" };
const THIGH: Style = Style { fill: "#f2b872", line: "#8a5312" };
const SHIN: Style = Style { fill: "#8fc1e3", line: "#1c5a86" };
const FOOT: Style = Style { fill: "#30363d", line: "#14171a" };
const BONE: Style = Style { fill: "#c9ced4", line: "#8b939c" };
const AXIS: &str = "#c8321f";
const INK: &str = "#262626";
const FAINT: &str = "#8b939c";

/// From where the robot is looked at.
struct View {
    title: &'static str,
    right: Vector3<f64>,
    up: Vector3<f64>,
    /// What the arrows along right and up say.
    words: [&'static str; 2],
}

const VIEWS: [View; 3] = [
    View {
        title: "top",
        right: Vector3::new(1.0, 0.0, 0.0),
        up: Vector3::new(0.0, 1.0, 0.0),
        words: ["x forward", "y left"],
    },
    View {
        title: "side, from its right",
        right: Vector3::new(1.0, 0.0, 0.0),
        up: Vector3::new(0.0, 0.0, 1.0),
        words: ["x forward", "z up"],
    },
    View {
        title: "front",
        right: Vector3::new(0.0, 1.0, 0.0),
        up: Vector3::new(0.0, 0.0, 1.0),
        words: ["y left", "z up"],
    },
];

/// Something to draw, in a view's plane.
enum Outline {
    Disc {
        middle: Point2<f64>,
        radius_m: f64,
    },
    Stadium {
        ends: [Point2<f64>; 2],
        radius_m: f64,
    },
    /// Corners in order; `light` is how bright its side is, from 0 to 1.
    Polygon {
        corners: Vec<Point2<f64>>,
        light: f64,
    },
}

struct Drawn {
    /// Towards the viewer.
    depth_m: f64,
    style: Style,
    outline: Outline,
}

impl View {
    fn flat(&self, point: &Point3<f64>) -> Point2<f64> {
        Point2::new(self.right.dot(&point.coords), self.up.dot(&point.coords))
    }

    fn toward(&self) -> Vector3<f64> {
        self.right.cross(&self.up)
    }

    fn depth_m(&self, point: &Point3<f64>) -> f64 {
        self.toward().dot(&point.coords)
    }

    fn solid(&self, solid: &Solid, part: &Isometry3<f64>, style: Style, drawn: &mut Vec<Drawn>) {
        let pose = part * solid.pose;
        let at = |x: f64, y: f64, z: f64| pose * Point3::new(x, y, z);
        let middle = at(0.0, 0.0, 0.0);
        let depth_m = self.depth_m(&middle);
        match solid.shape {
            Shape::Ball { radius_m } => {
                drawn.push(Drawn {
                    depth_m,
                    style,
                    outline: Outline::Disc { middle: self.flat(&middle), radius_m },
                });
            }
            Shape::Capsule { half_m, radius_m } => {
                let ends = [-half_m, half_m].map(|z| self.flat(&at(0.0, 0.0, z)));
                drawn.push(Drawn { depth_m, style, outline: Outline::Stadium { ends, radius_m } });
            }
            Shape::Cylinder { half_m, radius_m } => {
                let rims = [-half_m, half_m].into_iter().flat_map(|z| {
                    (0..CORNERS).map(move |k| {
                        let angle = TAU * k as f64 / CORNERS as f64;
                        (radius_m * angle.cos(), radius_m * angle.sin(), z)
                    })
                });
                let corners = convex(rims.map(|(x, y, z)| self.flat(&at(x, y, z))).collect());
                drawn.push(Drawn { depth_m, style, outline: Outline::Polygon { corners, light: 1.0 } });
            }
            Shape::Cuboid { half_m } => {
                for axis in 0..3 {
                    for sign in [-1.0, 1.0] {
                        let normal = pose.rotation * Vector3::ith(axis, sign);
                        let facing = normal.dot(&self.toward());
                        // The three sides that are seen never hide each other.
                        if facing < 1e-6 {
                            continue;
                        }
                        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
                        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(u, v)| {
                            let mut corner = Vector3::ith(axis, sign * half_m[axis]);
                            (corner[b], corner[c]) = (u * half_m[b], v * half_m[c]);
                            self.flat(&(pose * Point3::from(corner)))
                        });
                        let outline =
                            Outline::Polygon { corners: corners.to_vec(), light: 0.7 + 0.3 * facing };
                        drawn.push(Drawn { depth_m, style, outline });
                    }
                }
            }
        }
    }

    /// A limb's middle line, where it may have nothing to touch with.
    fn bone(&self, ends: [Point3<f64>; 2], radius_m: f64, drawn: &mut Vec<Drawn>) {
        let depth_m = f64::midpoint(self.depth_m(&ends[0]), self.depth_m(&ends[1]));
        // A little behind the solids of the same limb.
        let outline = Outline::Stadium { ends: ends.map(|end| self.flat(&end)), radius_m };
        drawn.push(Drawn { depth_m: depth_m - radius_m, style: BONE, outline });
    }

    /// All solids, the farthest first.
    fn drawn(&self, limbs: &Limbs, standing: &Standing<'_>) -> Vec<Drawn> {
        let mut drawn = Vec::new();
        for solid in &limbs.torso.solids {
            self.solid(solid, &Isometry3::identity(), TORSO, &mut drawn);
        }
        for (leg, limb) in limbs.legs.iter().enumerate() {
            let (hip_m, knee_m, foot_m) =
                (standing.joints[leg].0, standing.joints[4 + leg].0, standing.feet_m[leg]);
            let thin_m = limbs.foot_radius_m / 3.0;
            self.bone([hip_m, knee_m], thin_m, &mut drawn);
            self.bone([knee_m, foot_m], thin_m, &mut drawn);
            limb.thigh
                .solids
                .iter()
                .for_each(|solid| self.solid(solid, &standing.thighs[leg], THIGH, &mut drawn));
            limb.shin
                .solids
                .iter()
                .for_each(|solid| self.solid(solid, &standing.shins[leg], SHIN, &mut drawn));
            let outline = Outline::Disc { middle: self.flat(&foot_m), radius_m: limbs.foot_radius_m };
            drawn.push(Drawn { depth_m: self.depth_m(&foot_m), style: FOOT, outline });
        }
        drawn.sort_by(|a, b| a.depth_m.total_cmp(&b.depth_m));
        drawn
    }
}

impl Outline {
    /// Lowest and highest point of its box.
    fn bounds(&self) -> [Vector2<f64>; 2] {
        let of = |points: &[Point2<f64>], radius_m: f64| {
            let low = points.iter().fold(Vector2::repeat(f64::INFINITY), |low, p| low.inf(&p.coords));
            let high = points.iter().fold(Vector2::repeat(f64::NEG_INFINITY), |high, p| high.sup(&p.coords));
            [low.add_scalar(-radius_m), high.add_scalar(radius_m)]
        };
        match self {
            Self::Disc { middle, radius_m } => of(&[*middle], *radius_m),
            Self::Stadium { ends, radius_m } => of(ends, *radius_m),
            Self::Polygon { corners, .. } => of(corners, 0.0),
        }
    }
}

/// The convex outline of points, counter-clockwise (Andrew's chain).
fn convex(mut points: Vec<Point2<f64>>) -> Vec<Point2<f64>> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let turns_left = |a: &Point2<f64>, b: &Point2<f64>, c: &Point2<f64>| (b - a).perp(&(c - a)) > 0.0;
    let half = |points: &mut dyn Iterator<Item = &Point2<f64>>| {
        let mut chain: Vec<Point2<f64>> = Vec::new();
        for point in points {
            while chain.len() > 1 && !turns_left(&chain[chain.len() - 2], &chain[chain.len() - 1], point) {
                chain.pop();
            }
            chain.push(*point);
        }
        chain.pop();
        chain
    };
    let mut outline = half(&mut points.iter());
    outline.extend(half(&mut points.iter().rev()));
    outline
}

/// The drawing.
#[must_use]
pub fn to_svg(robot: &Robot, found: &Check) -> String {
    let limbs = Limbs::of(robot);
    let standing = Standing::of(&limbs);
    let drawn = VIEWS.each_ref().map(|view| view.drawn(&limbs, &standing));
    // Boxes around the views; the ground belongs to those that see it.
    let mut boxes = [[Vector2::repeat(f64::INFINITY), Vector2::repeat(f64::NEG_INFINITY)]; 3];
    for (view, (bound, drawn)) in core::iter::zip(&mut boxes, &drawn).enumerate() {
        for [low, high] in drawn.iter().map(|drawn| drawn.outline.bounds()) {
            *bound = [bound[0].inf(&low), bound[1].sup(&high)];
        }
        if view > 0 {
            bound[0].y = bound[0].y.min(-standing.height_m);
        }
    }
    let [top, _, front] = boxes.map(|[low, high]| high - low);
    let scale = (WIDTH_PX / (top.x + front.x)).min(HEIGHT_PX / (top.y + front.y));
    let column_px = (front.x * scale).max(WORDS_PX);
    let size_px = [top.x * scale + column_px + 3.0 * GAP_PX, (top.y + front.y) * scale + 3.0 * GAP_PX];
    let mut paper = Paper::new(size_px, &format!("{}: three views", robot.name));
    let right_px = 2.0 * GAP_PX + top.x * scale;
    let lower_px = 2.0 * GAP_PX + top.y * scale;
    let corners =
        [[GAP_PX, GAP_PX], [GAP_PX, lower_px], [right_px + (column_px - front.x * scale) / 2.0, lower_px]];
    for (k, view) in VIEWS.iter().enumerate() {
        let [low, high] = boxes[k];
        let at = |point: Point2<f64>| {
            [corners[k][0] + (point.x - low.x) * scale, corners[k][1] + (high.y - point.y) * scale]
        };
        paper.text([at(Point2::new(low.x, 0.0))[0], corners[k][1] - 22.0], 14.0, "bold", INK, view.title);
        if k > 0 {
            let ground = |x: f64| at(Point2::new(x, -standing.height_m));
            let past_m = 14.0 / scale;
            paper.ground(ground(low.x - past_m), ground(high.x + past_m));
        }
        for Drawn { style, outline, .. } in &drawn[k] {
            match outline {
                Outline::Disc { middle, radius_m } => paper.disc(at(*middle), radius_m * scale, *style),
                Outline::Stadium { ends, radius_m } => paper.stadium(ends.map(at), radius_m * scale, *style),
                Outline::Polygon { corners, light } => {
                    paper.polygon(
                        &corners.iter().map(|corner| at(*corner)).collect::<Vec<_>>(),
                        *style,
                        *light,
                    );
                }
            }
        }
        for (pivot_m, axis) in standing.joints {
            let half_m = 0.35 * limbs.foot_radius_m + 9.0 / scale;
            let ends = [-half_m, half_m].map(|along| at(view.flat(&(pivot_m + axis * along))));
            paper.axis(ends, at(view.flat(&pivot_m)), AXIS);
        }
        paper.centre_of_mass(at(view.flat(&standing.centre_m)), INK);
        labels(
            &mut paper,
            standing.feet_m.map(|foot_m| at(view.flat(&foot_m))),
            k == 0,
            limbs.foot_radius_m * scale,
        );
        paper.arrows(
            [
                corners[k][0] - 30.0,
                corners[k][1] + (high.y - low.y) * scale + if k == 0 { 24.0 } else { 34.0 },
            ],
            view.words,
            FAINT,
        );
    }
    words(&mut paper, [right_px, GAP_PX], robot, found, scale);
    paper.finish()
}

/// Numbers beside the feet; one for those that hide each other.
fn labels(paper: &mut Paper, feet: [[f64; 2]; 4], outwards: bool, radius_px: f64) {
    let mut done = [false; 4];
    let middle = feet.iter().fold([0.0; 2], |sum, foot| [sum[0] + foot[0] / 4.0, sum[1] + foot[1] / 4.0]);
    for leg in 0..4 {
        let near: Vec<usize> = (leg..4)
            .filter(|other| {
                !done[*other]
                    && (feet[*other][0] - feet[leg][0]).hypot(feet[*other][1] - feet[leg][1]) < NEAR_PX
            })
            .collect();
        if done[leg] {
            continue;
        }
        near.iter().for_each(|other| done[*other] = true);
        let text: Vec<String> = near.iter().map(|leg| (leg + 1).to_string()).collect();
        let [x, y] = feet[leg];
        let side = |at: f64, middle: f64| if at < middle { -1.0 } else { 1.0 };
        let away_px = radius_px + 9.0;
        let place = if outwards {
            [x + side(x, middle[0]) * away_px * 0.8, y + side(y, middle[1]) * away_px * 0.8 + 4.5]
        } else {
            [x, y + radius_px + 18.0]
        };
        paper.middle_text(place, 13.0, "bold", INK, &text.join(", "));
    }
}

/// Name, sizes, scale bar and what the marks mean.
fn words(paper: &mut Paper, [x, y]: [f64; 2], robot: &Robot, found: &Check, scale: f64) {
    let [length_m, width_m, _] = found.span_m;
    paper.text([x, y - 14.0], 20.0, "bold", INK, &robot.name);
    let facts = [
        format!("{:.0} g", found.mass_kg * 1000.0),
        format!("covers {:.0} x {:.0} mm at neutral", length_m * 1000.0, width_m * 1000.0),
        format!("torso frame {:.0} mm over the ground", found.standing_height_m * 1000.0),
    ];
    for (k, fact) in facts.iter().enumerate() {
        paper.text([x, y + 10.0 + 19.0 * k as f64], 13.0, "normal", INK, fact);
    }
    let bar_mm = round_length_mm(110.0 / scale * 1000.0);
    paper.scale_bar([x, y + 82.0], bar_mm / 1000.0 * scale, &format!("{bar_mm} mm"), INK);
    let mut row = y + 122.0;
    for (style, text) in [(TORSO, "torso"), (THIGH, "thighs"), (SHIN, "shins"), (FOOT, "feet, legs 1 to 4")] {
        paper.disc([x + 8.0, row - 4.5], 6.5, style);
        paper.text([x + 26.0, row], 13.0, "normal", INK, text);
        row += 20.0;
    }
    paper.axis([[x, row - 4.5], [x + 16.0, row - 4.5]], [x + 8.0, row - 4.5], AXIS);
    paper.text([x + 26.0, row], 13.0, "normal", INK, "joint axes");
    paper.centre_of_mass([x + 8.0, row + 15.5], INK);
    paper.text([x + 26.0, row + 20.0], 13.0, "normal", INK, "centre of mass");
}

/// 1, 2 or 5 times a power of ten, at most this long.
fn round_length_mm(most_mm: f64) -> f64 {
    let power = 10.0_f64.powf(most_mm.max(1e-3).log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|step| step * power).find(|length| *length <= most_mm).unwrap_or(power)
}

#[cfg(test)]
mod tests;
