//! Marks on a drawing, in pixels from its upper left corner.
//!
//! Holds the SVG's words. Does not depend on robots.

use std::fmt::Write as _;

const FONT: &str = "sans-serif";
const LINE_PX: f64 = 1.2;

/// Colours of a solid.
#[derive(Debug, Clone, Copy)]
pub struct Style {
    pub fill: &'static str,
    pub line: &'static str,
}

/// The drawing so far.
pub struct Paper {
    svg: String,
}

/// Text between tags.
fn escaped(text: &str) -> String {
    text.chars()
        .filter(|c| !c.is_control())
        .map(|c| match c {
            '&' => "&amp;".to_owned(),
            '<' => "&lt;".to_owned(),
            '>' => "&gt;".to_owned(),
            _ => c.to_string(),
        })
        .collect()
}

/// A colour `light` times as bright.
fn shaded(colour: &str, light: f64) -> String {
    let channel = |at: usize| u8::from_str_radix(colour.get(at..at + 2).unwrap_or("00"), 16).unwrap_or(0);
    let [r, g, b] = [1, 3, 5].map(|at| (f64::from(channel(at)) * light.clamp(0.0, 1.0)).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

impl Paper {
    pub fn new([width_px, height_px]: [f64; 2], title: &str) -> Self {
        let (width_px, height_px) = (width_px.ceil(), height_px.ceil());
        let mut svg = String::new();
        let _ = writeln!(
            svg,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width_px}\" height=\"{height_px}\" \
             viewBox=\"0 0 {width_px} {height_px}\">\n<title>{}</title>\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>",
            escaped(title)
        );
        Self { svg }
    }

    pub fn finish(mut self) -> String {
        self.svg += "</svg>\n";
        self.svg
    }

    fn line(&mut self, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], more: &str) {
        let _ =
            writeln!(self.svg, "<line x1=\"{x1:.2}\" y1=\"{y1:.2}\" x2=\"{x2:.2}\" y2=\"{y2:.2}\" {more}/>");
    }

    pub fn disc(&mut self, [x, y]: [f64; 2], radius_px: f64, style: Style) {
        let Style { fill, line } = style;
        let _ = writeln!(
            self.svg,
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius_px:.2}\" fill=\"{fill}\" stroke=\"{line}\" \
             stroke-width=\"{LINE_PX}\"/>"
        );
    }

    pub fn stadium(&mut self, [from, to]: [[f64; 2]; 2], radius_px: f64, style: Style) {
        // A round line needs a length: resvg draws none without.
        let to = if (from[0] - to[0]).hypot(from[1] - to[1]) < 0.01 { [from[0] + 0.01, from[1]] } else { to };
        let (outer_px, inner_px) = (2.0 * radius_px + LINE_PX, (2.0 * radius_px - LINE_PX).max(0.6));
        for (colour, width_px) in [(style.line, outer_px), (style.fill, inner_px)] {
            self.line(
                from,
                to,
                &format!("stroke=\"{colour}\" stroke-width=\"{width_px:.2}\" stroke-linecap=\"round\""),
            );
        }
    }

    pub fn polygon(&mut self, corners: &[[f64; 2]], style: Style, light: f64) {
        let points: Vec<String> = corners.iter().map(|[x, y]| format!("{x:.2},{y:.2}")).collect();
        let _ = writeln!(
            self.svg,
            "<polygon points=\"{}\" fill=\"{}\" stroke=\"{}\" stroke-width=\"{LINE_PX}\" stroke-linejoin=\"round\"/>",
            points.join(" "),
            shaded(style.fill, light),
            style.line
        );
    }

    fn any_text(&mut self, [x, y]: [f64; 2], look: &str, colour: &str, text: &str) {
        let text = escaped(text);
        let _ = writeln!(
            self.svg,
            "<text x=\"{x:.2}\" y=\"{y:.2}\" font-family=\"{FONT}\" fill=\"{colour}\" {look}>{text}</text>"
        );
    }

    pub fn text(&mut self, at: [f64; 2], size_px: f64, weight: &str, colour: &str, text: &str) {
        self.any_text(at, &format!("font-size=\"{size_px}\" font-weight=\"{weight}\""), colour, text);
    }

    pub fn middle_text(&mut self, at: [f64; 2], size_px: f64, weight: &str, colour: &str, text: &str) {
        // White around it, so that it is read on whatever it covers.
        let look = format!(
            "font-size=\"{size_px}\" font-weight=\"{weight}\" text-anchor=\"middle\" paint-order=\"stroke\" \
             stroke=\"#ffffff\" stroke-width=\"3\""
        );
        self.any_text(at, &look, colour, text);
    }

    /// An axis along a line, or towards the viewer where the line is short.
    pub fn axis(&mut self, [from, to]: [[f64; 2]; 2], [x, y]: [f64; 2], colour: &str) {
        let ring = |paper: &mut Self, radius_px: f64, fill: &str| {
            let _ = writeln!(
                paper.svg,
                "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius_px}\" fill=\"{fill}\" stroke=\"{colour}\" \
                 stroke-width=\"1.4\"/>"
            );
        };
        if (from[0] - to[0]).hypot(from[1] - to[1]) < 6.0 {
            ring(self, 4.5, "#ffffff");
            ring(self, 0.8, colour);
        } else {
            self.line(
                from,
                to,
                &format!("stroke=\"{colour}\" stroke-width=\"1.6\" stroke-dasharray=\"5 2 1.5 2\""),
            );
            ring(self, 1.8, "#ffffff");
        }
    }

    pub fn centre_of_mass(&mut self, [x, y]: [f64; 2], colour: &str) {
        let _ = writeln!(
            self.svg,
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"7\" fill=\"#ffffff\" stroke=\"{colour}\" stroke-width=\"1.4\"/>\n\
             <path d=\"M{x:.2} {y:.2} v-7 a7 7 0 0 1 7 7 z m0 0 v7 a7 7 0 0 1 -7 -7 z\" fill=\"{colour}\"/>"
        );
    }

    pub fn ground(&mut self, from: [f64; 2], to: [f64; 2]) {
        self.line(from, to, "stroke=\"#4c4c4c\" stroke-width=\"1.6\"");
        let mut x = from[0] + 6.0;
        while x < to[0] {
            self.line([x, from[1]], [x - 6.0, from[1] + 6.0], "stroke=\"#9a9a9a\" stroke-width=\"1\"");
            x += 9.0;
        }
    }

    /// Right and up from a corner.
    pub fn arrows(&mut self, [x, y]: [f64; 2], [right, up]: [&str; 2], colour: &str) {
        let look = format!("stroke=\"{colour}\" stroke-width=\"1.3\"");
        self.line([x, y], [x + 22.0, y], &look);
        self.line([x, y], [x, y - 22.0], &look);
        let _ = writeln!(
            self.svg,
            "<path d=\"M{:.2} {y:.2} l-6 -3 v6 z M{x:.2} {:.2} l-3 6 h6 z\" fill=\"{colour}\"/>",
            x + 27.0,
            y - 27.0
        );
        self.text([x + 31.0, y + 4.0], 11.0, "normal", colour, right);
        self.text([x - 6.0, y - 32.0], 11.0, "normal", colour, up);
    }

    pub fn scale_bar(&mut self, [x, y]: [f64; 2], length_px: f64, text: &str, colour: &str) {
        let look = format!("stroke=\"{colour}\" stroke-width=\"1.6\"");
        self.line([x, y], [x + length_px, y], &look);
        for end in [x, x + length_px] {
            self.line([end, y - 5.0], [end, y + 5.0], &look);
        }
        self.text([x + length_px + 10.0, y + 4.5], 13.0, "normal", colour, text);
    }
}
