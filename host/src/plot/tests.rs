use super::*;

fn figure(points: Vec<(f64, f64)>) -> Figure {
    let heights: Vec<f64> = points.iter().map(|(_, y)| *y).collect();
    Figure {
        title: "A <title> & more\u{7}\u{ffff}".into(),
        legend: vec![Entry { label: "points".into(), marks: vec![(Mark::Line, BLUE)] }],
        columns: 1,
        panel_px: (400, 200),
        panels: vec![Panel {
            title: "panel".into(),
            x: Axis::exact("time (s)", points.iter().map(|(x, _)| *x), 8),
            y: Axis::round("height (m)", heights, 6),
            top: Some(Axis::exact("steps", [0.0, 2500.0], 5)),
            layers: vec![Layer { mark: Mark::Line, colour: BLUE, points }],
            notes: vec![],
        }],
    }
}

/// Well-formed for the XML parser that reads robots' drawings.
#[test]
fn a_figure_is_well_formed_whatever_it_is_called() {
    let svg = figure(vec![(0.0, 1.0), (1.0, 2.0)]).to_svg().unwrap();

    let mut reader = quick_xml::Reader::from_str(&svg);
    let mut texts = String::new();
    loop {
        match reader.read_event().unwrap() {
            quick_xml::events::Event::Eof => break,
            quick_xml::events::Event::Text(text) => texts += &String::from_utf8_lossy(&text),
            _ => {}
        }
    }
    assert!(svg.starts_with("<svg width=\"424\" height="), "{}", &svg[..60]);
    assert!(svg.contains("A &lt;title&gt; &amp; more??"), "{svg}");
    assert!(texts.contains("time (s)") && texts.contains("2,500"), "{texts}");
}

/// 400 pixels hold some fifty letters; where a label says how many seeds, it is at its end.
#[test]
fn a_label_that_is_too_long_for_the_figure_is_shortened_in_the_middle() {
    let mut long = figure(vec![(0.0, 1.0), (1.0, 2.0)]);
    long.legend[0].label = format!("begin {} 3 seeds", "x".repeat(200));

    let svg = long.to_svg().unwrap();

    let label = svg.lines().find(|line| line.contains("begin x")).unwrap();
    assert!(label.ends_with("x 3 seeds") && label.contains('\u{2026}'), "{label}");
    assert!((40..60).contains(&label.chars().count()), "{label}");
}

#[test]
fn numbers_that_are_none_and_panels_without_points_do_not_panic() {
    let refused = figure(vec![(0.0, 1.0), (1.0, f64::NAN)]).to_svg();

    assert!(matches!(refused, Err(PlotError::NotFinite { x: 1.0, .. })), "{refused:?}");
    for points in
        [vec![], vec![(0.0, 0.0)], vec![(0.0, 7.0), (1.0, 7.0)], vec![(0.0, -1e308), (1e-300, 1e308)]]
    {
        figure(points.clone()).to_svg().unwrap_or_else(|error| panic!("{points:?}: {error}"));
    }
}

#[test]
fn axes_begin_and_end_at_round_numbers_that_they_name() {
    let texts = |axis: &Axis| axis.ticks.iter().map(|&tick| axis.text(tick)).collect::<Vec<_>>().join(" ");
    let round = Axis::round("", [-0.13, 0.31], 6);
    let exact = Axis::exact("", [0.0, 1.19], 8);
    let angles = Axis::degrees("", [-28.0, 31.0], 6);
    let large = Axis::exact("", [0.0, 250_000.0], 6);

    assert_eq!(texts(&round), "\u{2212}0.2 \u{2212}0.1 0.0 0.1 0.2 0.3 0.4");
    assert_eq!((texts(&exact).as_str(), exact.most), ("0.0 0.2 0.4 0.6 0.8 1.0", 1.19));
    assert_eq!(texts(&angles), "\u{2212}30 \u{2212}20 \u{2212}10 0 10 20 30 40");
    assert_eq!(texts(&large), "0 50,000 100,000 150,000 200,000 250,000");
}

/// The panel ends at 2: of two strokes across the ends, that beyond it is not drawn.
#[test]
fn a_whisker_that_leaves_the_panel_is_cut_and_has_no_end_there() {
    let strokes = |ends: [(f64, f64); 2]| {
        let mut figure = figure(vec![(0.0, 1.0), (1.0, 2.0)]);
        let points = ends.to_vec();
        figure.panels[0].layers.push(Layer { mark: Mark::Whiskers, colour: BLUE, points });
        figure.to_svg().unwrap().matches("<polyline").count()
    };

    let without = figure(vec![(0.0, 1.0), (1.0, 2.0)]).to_svg().unwrap().matches("<polyline").count();
    assert_eq!(strokes([(0.5, 1.2), (0.5, 1.8)]), without + 3);
    assert_eq!(strokes([(0.5, 1.2), (0.5, 9.0)]), without + 2);
}

/// A label must not hide a result: its ground is drawn before the curve, its text after.
#[test]
fn a_note_is_written_above_the_curves_and_its_ground_lies_below_them() {
    let mut noted = figure(vec![(0.0, 1.0), (1.0, 2.0)]);
    noted.panels[0].layers[0].colour = Colour(1, 2, 3);
    noted.panels[0].notes.push(Note { at: (0.5, 1.5), side: Side::Left, text: "here & <there>".into() });

    let svg = noted.to_svg().unwrap();

    let place = |text: &str| svg.rfind(text).unwrap_or_else(|| panic!("{text}: {svg}"));
    let (ground, curve, text) =
        (place("fill=\"#FFFFFF\""), place("#010203"), place("here &amp; &lt;there&gt;"));
    assert!(ground < curve && curve < text, "{ground} {curve} {text}");
    noted.panels[0].notes[0].at.0 = f64::NAN;
    assert!(matches!(noted.to_svg(), Err(PlotError::NotFinite { .. })));
}

#[test]
fn a_table_keeps_its_rows_and_escapes_its_cells() {
    let table = Table {
        title: "A & B".into(),
        header: vec!["what".into(), "how much".into()],
        words: 1,
        rows: vec![vec!["<one>".into(), "1.0".into()], vec!["two".into(), "2.0".into()]],
        parts: vec![1],
    };

    let svg = table.to_svg().unwrap();

    assert!(svg.contains("A &amp; B") && svg.contains("&lt;one&gt;"), "{svg}");
    // Title, header and cells; above and below the header, between the rows and at the end.
    assert_eq!((svg.matches("<text").count(), svg.matches("<line").count()), (7, 4));
    assert_eq!(svg.matches("text-anchor=\"end\"").count(), 3);
    assert!(to_png(&svg, 2.0).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn notes_at_nearly_the_same_place_are_written_below_each_other() {
    let mut noted = figure(vec![(0.0, 1.0), (1.0, 2.0)]);
    for (text, y) in [("upper", 1.52), ("lower", 1.5), ("between", 1.51)] {
        noted.panels[0].notes.push(Note { at: (0.5, y), side: Side::Right, text: text.into() });
    }

    let svg = noted.to_svg().unwrap();

    // Each text's element begins with its place.
    let down = |text: &str| -> f64 {
        let before = &svg[..svg.find(&format!("\n{text}\n")).unwrap()];
        let element = &before[before.rfind("<text").unwrap()..];
        let from = element.find(" y=\"").unwrap() + 4;
        element[from..].split('"').next().unwrap().parse().unwrap()
    };
    let rows = ["upper", "between", "lower"].map(down);
    assert!(rows.windows(2).all(|pair| pair[1] - pair[0] > 12.0), "{rows:?}");
}
