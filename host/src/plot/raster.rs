//! Figures in pixels, for slides and for programs that know no SVG.
//!
//! Holds the font: Noto Sans, built into the program, so that the same figure is
//! the same picture on every machine. Does not depend on what a figure shows.

use super::PlotError;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

/// Whatever family a figure names, this is what it is written in.
const FAMILY: &str = "Noto Sans";

/// The picture as a PNG file, `scale` pixels for one of the drawing.
///
/// # Errors
/// [`PlotError`]
pub fn to_png(svg: &str, scale: f32) -> Result<Vec<u8>, PlotError> {
    let mut options = Options { font_family: FAMILY.into(), ..Options::default() };
    let fonts = options.fontdb_mut();
    fonts.load_font_data(notosans::REGULAR_TTF.to_vec());
    fonts.load_font_data(notosans::BOLD_TTF.to_vec());
    fonts.set_sans_serif_family(FAMILY);
    let tree = Tree::from_str(svg, &options)?;
    let size = tree.size();
    let pixels = |length: f32| (length * scale).ceil() as u32;
    let (width_px, height_px) = (pixels(size.width()), pixels(size.height()));
    let mut picture = Pixmap::new(width_px, height_px).ok_or(PlotError::Size { width_px, height_px })?;
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut picture.as_mut());
    picture.encode_png().map_err(|error| PlotError::Png { reason: error.to_string() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Vec<u8> {
        let svg = format!(
            "<svg width=\"200\" height=\"40\" xmlns=\"http://www.w3.org/2000/svg\">\
             <text x=\"4\" y=\"30\" font-family=\"sans-serif\" font-size=\"20\">{text}</text></svg>"
        );
        to_png(&svg, 2.0).unwrap()
    }

    /// Letters that the font lacks would be left out: the picture would be that of no text.
    #[test]
    fn every_letter_that_figures_use_is_rendered_without_a_font_of_the_machine() {
        let empty = Pixmap::decode_png(&of("")).unwrap();

        assert_eq!((empty.width(), empty.height()), (400, 80));
        for letter in ["W", "\u{b1}", "\u{2212}", "\u{d7}", "\u{b2}", "\u{2026}", "\u{2013}", "\u{2019}"] {
            let shown = Pixmap::decode_png(&of(letter)).unwrap();
            let inked = shown.pixels().iter().filter(|pixel| pixel.alpha() > 128).count();
            assert!(inked > 10, "{letter}: {inked} pixels");
            assert_ne!(of(letter), of("\u{fffe0}"), "{letter} is a box");
        }
    }

    #[test]
    fn a_drawing_that_is_none_is_refused() {
        let error = to_png("<svg", 2.0).unwrap_err();

        assert!(matches!(error, PlotError::Svg(_)), "{error}");
    }
}
