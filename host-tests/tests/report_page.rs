//! The page as a reader, a browser and a test harness meet it.

use hysteron_host::report::{Axis, Cell, KeyFigure, Page, Plot, Series, Style, Tone};
use roxmltree::{Document, Node};

const STYLES: [Style; 6] = [
    Style::Line,
    Style::Solid,
    Style::Points,
    Style::LinePoints,
    Style::Bars,
    Style::Level,
];

fn volts() -> Axis {
    Axis::linear("Drive", "V")
}

fn micrometres() -> Axis {
    Axis::linear("Displacement", "um")
}

fn page_with(plots: impl IntoIterator<Item = Plot>) -> String {
    let mut page = Page::new("Plots");
    page.section("All", |section| {
        plots.into_iter().for_each(|plot| section.plot(plot))
    });
    page.to_html()
}

/// Every drawing of the page; `svg` elements do not nest here.
fn drawings(html: &str) -> Vec<Document<'_>> {
    let starts = html.match_indices("<svg").map(|(at, _)| &html[at..]);
    let parts = starts.map(|rest| &rest[..rest.find("</svg>").expect("closed") + "</svg>".len()]);
    parts
        .map(|part| Document::parse(part).expect("well-formed"))
        .collect()
}

fn plots(html: &str) -> Vec<Document<'_>> {
    let all = drawings(html).into_iter();
    all.filter(|svg| svg.root_element().attribute("role") == Some("img"))
        .collect()
}

fn series<'a>(plot: &'a Document) -> Vec<Node<'a, 'a>> {
    plot.descendants()
        .filter(|node| node.attribute("data-label").is_some())
        .collect()
}

fn path_of<'a>(series: &Node<'a, 'a>) -> &'a str {
    series
        .first_element_child()
        .and_then(|path| path.attribute("d"))
        .expect("a path")
}

/// Corners of a path of absolute `M` and relative `l`, in pixels.
fn corners(path: &str) -> Vec<(f64, f64)> {
    let mut found = Vec::new();
    for stroke in path.split('M').skip(1) {
        let numbers: Vec<f64> = stroke
            .split([' ', 'l'])
            .map(|number| number.parse().unwrap())
            .collect();
        let (mut x, mut y) = (0.0, 0.0);
        for step in numbers.chunks_exact(2) {
            (x, y) = (x + 0.1 * step[0], y + 0.1 * step[1]);
            found.push((x, y));
        }
    }
    found
}

/// The value at a pixel by the mapping that the drawing states.
fn value_at(plot: &Document, axis: &str, pixel: f64) -> f64 {
    let stated = plot.root_element().attribute(axis).unwrap();
    let (kind, numbers) = stated.split_once(' ').unwrap();
    let n: Vec<f64> = numbers
        .split(' ')
        .map(|number| number.parse().unwrap())
        .collect();
    let part = (pixel - n[2]) / (n[3] - n[2]);
    match kind {
        "log" => n[0] * (n[1] / n[0]).powf(part),
        _ => n[0] + part * (n[1] - n[0]),
    }
}

#[test]
fn hostile_text_stays_text() {
    let evil = r#"<script>alert("1")</script>&amp;<!-- ' -->"#;
    let mut page = Page::new(evil);
    page.lead(evil).verdict(Tone::Bad, evil);
    page.figures([KeyFigure::new(evil, evil, evil, evil).note(evil)]);
    page.section(evil, |section| {
        section.paragraph(evil);
        section.list([evil]);
        section.table([evil], [vec![Cell::from(evil)]]);
        section.plot(
            Plot::new(evil, Axis::linear(evil, evil), Axis::log(evil, evil))
                .caption(evil)
                .series(Series::new(evil, Style::Line, &[1.0, 2.0], &[1.0, 2.0])),
        );
    });
    let html = page.to_html();
    assert_eq!(
        html.matches("<script").count(),
        1,
        "only the page's own script"
    );
    assert!(!html.contains("alert(\"1\")"));
    let plots = plots(&html);
    let plot = &plots[0];
    assert_eq!(plot.root_element().attribute("aria-label"), Some(evil));
    assert_eq!(series(plot)[0].attribute("data-label"), Some(evil));
    let title = format!("{evil} ({evil})");
    assert_eq!(
        plot.descendants()
            .filter(|node| node.is_text() && node.text() == Some(&title))
            .count(),
        2
    );
}

#[test]
fn a_page_asks_for_nothing() {
    let html = page_with(STYLES.map(|style| {
        Plot::new("p", volts(), micrometres()).series(Series::new("s", style, &[1.0], &[2.0]))
    }));
    for request in [
        "http:", "https:", "src=", "href=", "@import", "fetch(", "import ",
    ] {
        assert!(!html.contains(request), "{request} in the page");
    }
    assert_eq!(html.matches("url(").count(), html.matches("url(#").count());
    assert!(html.contains("default-src 'none'"));
}

#[test]
fn key_figures_can_be_read_back_exactly() {
    let values = [
        0.1 + 0.2,
        4.512_345_678_901_234e-9,
        -1.0 / 3.0,
        7.0,
        6.02e23,
        f64::MIN_POSITIVE,
    ];
    let mut page = Page::new("Figures");
    page.figures(
        values
            .iter()
            .enumerate()
            .map(|(i, &v)| KeyFigure::new(format!("key.{i}"), "x", v, "um/V")),
    );
    let html = page.to_html();
    for (i, value) in values.iter().enumerate() {
        let cell = html
            .split(&format!(
                "id=\"key.{i}\" data-key=\"key.{i}\" data-value=\""
            ))
            .nth(1);
        let text = cell
            .and_then(|rest| rest.split('"').next())
            .expect("the cell");
        assert_eq!(
            text.parse::<f64>().unwrap().to_bits(),
            value.to_bits(),
            "{text}"
        );
    }
    assert_eq!(html.matches("<td>µm/V</td>").count(), values.len());
}

#[test]
fn drawn_points_lie_at_their_values() {
    let x = [0.05, 0.3, 1.0, 40.0, 100.0];
    let y = [6.1, -2.4, 0.0, 9.9, 3.3];
    let html = page_with([Plot::new("p", Axis::log("Frequency", "Hz"), micrometres())
        .series(Series::new("s", Style::LinePoints, &x, &y))
        .series(Series::level("limit", 5.0))]);
    let plots = plots(&html);
    let drawn = series(&plots[0]);
    let points = corners(path_of(&drawn[0]));
    assert_eq!(points.len(), x.len());
    for (i, (px, py)) in points.into_iter().enumerate() {
        // Half a tenth of a pixel of a frame about 900 by 270 pixels in size.
        let (back_x, back_y) = (
            value_at(&plots[0], "data-x", px),
            value_at(&plots[0], "data-y", py),
        );
        assert!((back_x / x[i] - 1.0).abs() < 1e-3, "{back_x} for {}", x[i]);
        assert!((back_y - y[i]).abs() < 5e-3, "{back_y} for {}", y[i]);
    }
    assert_eq!(
        drawn[0].attribute("data-points"),
        Some("0.05,6.1 0.3,-2.4 1,0 40,9.9 100,3.3")
    );
    assert!(
        drawn[1]
            .attribute("data-points")
            .is_some_and(|ends| ends.ends_with(",5"))
    );
    for (_, py) in corners(path_of(&drawn[1])) {
        assert!((value_at(&plots[0], "data-y", py) - 5.0).abs() < 5e-3);
    }
}

#[test]
fn missing_values_interrupt_the_line() {
    let x: Vec<f64> = (0..9).map(f64::from).collect();
    let mut y = x.clone();
    (y[3], y[6]) = (f64::NAN, f64::INFINITY);
    let html = page_with([Plot::new("p", volts(), micrometres()).series(Series::new(
        "s",
        Style::Line,
        &x,
        &y,
    ))]);
    let plots = plots(&html);
    let path = path_of(&series(&plots[0])[0]);
    let strokes: Vec<usize> = path
        .split('M')
        .skip(1)
        .map(|stroke| corners(&format!("M{stroke}")).len())
        .collect();
    assert_eq!(strokes, [3, 2, 2], "{path}");
}

#[test]
fn no_value_breaks_a_drawing() {
    let odd = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        f64::MIN,
        5e-324,
        -0.0,
        0.0,
    ];
    let mut cases: Vec<Vec<f64>> = vec![vec![], odd.to_vec(), vec![3.0], vec![1e6, 1e6 + 1e-9]];
    cases.extend(odd.iter().map(|&value| vec![value]));
    cases.push(odd.iter().flat_map(|&value| [value, 2.0]).collect());
    for log in [false, true] {
        let axis = |unit| {
            if log {
                Axis::log("a", unit)
            } else {
                Axis::linear("a", unit)
            }
        };
        let plots_of_cases = cases.iter().flat_map(|values| {
            let steps: Vec<f64> = (0..values.len()).map(|i| i as f64).collect();
            let mut plot = Plot::new("p", axis("V"), axis("").including(f64::NAN));
            for style in STYLES {
                plot = plot.series(Series::new("s", style, &steps, values));
            }
            let turned = Plot::new("q", axis("V"), axis("")).series(Series::new(
                "s",
                Style::Line,
                values,
                &steps[..values.len() / 2],
            ));
            [plot, turned]
        });
        let html = page_with(plots_of_cases);
        let all = plots(&html);
        assert_eq!(all.len(), 2 * cases.len());
        for node in all.iter().flat_map(Document::descendants) {
            for name in ["d", "x", "y", "transform", "data-x", "data-y"] {
                let value = node.attribute(name).unwrap_or_default();
                assert!(
                    !value.contains("NaN") && !value.contains("inf"),
                    "{name}={value}"
                );
            }
        }
    }
}

#[test]
fn bars_rise_from_zero_in_proportion() {
    let html = page_with([Plot::new("p", volts(), micrometres()).series(Series::new(
        "w",
        Style::Bars,
        &[0.0, 4.0, 9.0],
        &[8.0, 4.0, -2.0],
    ))]);
    let plots = plots(&html);
    let heights: Vec<f64> = path_of(&series(&plots[0])[0])
        .split('M')
        .skip(1)
        .map(|bar| {
            // M left base V tip h width V base z
            let mut parts = bar.split(['V', 'h']);
            let base: f64 = parts
                .next()
                .unwrap()
                .split(' ')
                .nth(1)
                .unwrap()
                .parse()
                .unwrap();
            base - parts.next().unwrap().parse::<f64>().unwrap()
        })
        .collect();
    assert_eq!(heights.len(), 3);
    assert!((heights[0] / heights[1] - 2.0).abs() < 0.01, "{heights:?}");
    assert!((heights[1] / heights[2] + 2.0).abs() < 0.01, "{heights:?}");
}

#[test]
fn long_records_make_a_small_page() {
    let samples = 100_000;
    // Hash of the index: noise that no method of thinning can compress.
    let noise = |i: usize| (i.wrapping_mul(2_654_435_761) % 65_536) as f64 / 65_536.0;
    let time: Vec<f64> = (0..samples).map(|i| i as f64 * 1e-4).collect();
    let rough: Vec<f64> = (0..samples).map(noise).collect();
    let drive: Vec<f64> = time.iter().map(|t| 50.0 + 50.0 * (7.0 * t).sin()).collect();
    let swing: Vec<f64> = drive
        .iter()
        .zip(&rough)
        .map(|(u, e)| 0.15 * u + e)
        .collect();
    let html = page_with((0..10).map(|k| {
        let (x, style) = if k % 2 == 0 {
            (&time, Style::Solid)
        } else {
            (&drive, Style::Points)
        };
        Plot::new("p", volts(), micrometres())
            .series(Series::new("a", Style::Line, x, &swing))
            .series(Series::new("b", style, x, &rough))
    }));
    assert!(html.len() < 2_000_000, "{} bytes", html.len());
    assert!(
        html.contains("of 100000"),
        "the page says that it shows a part"
    );
}

#[test]
fn a_million_points_cost_as_much_as_any_long_series() {
    let x: Vec<f64> = (0..1_000_000).map(f64::from).collect();
    let mut y: Vec<f64> = x.iter().map(|i| (i * 0.7).sin()).collect();
    y[654_321] = 9.0;
    let html = page_with([Plot::new("p", Axis::linear("Time", "s"), micrometres())
        .series(Series::new("s", Style::Line, &x, &y))]);
    assert!(html.len() < 80_000, "{} bytes", html.len());
    let plots = plots(&html);
    let points = corners(path_of(&series(&plots[0])[0]));
    let peak = points
        .iter()
        .copied()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap();
    assert!((value_at(&plots[0], "data-y", peak.1) - 9.0).abs() < 0.01);
    assert!((value_at(&plots[0], "data-x", peak.0) - 654_321.0).abs() < 100.0);
}

#[test]
fn drawings_speak_to_those_who_cannot_see_them() {
    let html = page_with([Plot::new("Loop", volts(), micrometres())
        .caption("Measured against model.")
        .series(Series::new(
            "measured",
            Style::Line,
            &[0.0, 100.0],
            &[0.0, 15.0],
        ))]);
    let all = drawings(&html);
    assert_eq!(all.len(), 3, "markers, swatch, plot");
    for svg in &all {
        let root = svg.root_element();
        match root.attribute("role") {
            Some(role) => {
                assert_eq!((role, root.attribute("aria-label")), ("img", Some("Loop")));
                let id = root.attribute("aria-describedby").unwrap();
                let found = svg
                    .descendants()
                    .find(|node| node.attribute("id") == Some(id));
                let text = found.and_then(|node| node.text()).unwrap();
                for part in ["Measured against model.", "Drive", "µm", "measured"] {
                    assert!(text.contains(part), "{part} is missing in {text}");
                }
            }
            None => assert_eq!(root.attribute("aria-hidden"), Some("true")),
        }
    }
}

/// Contrast with white after WCAG 2.1: (1 + 0.05) / (relative luminance + 0.05).
fn contrast_with_white(hex: &str) -> f64 {
    let channel = |i: usize| {
        let c = f64::from(u8::from_str_radix(&hex[i..i + 2], 16).unwrap()) / 255.0;
        if c <= 0.040_45 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    };
    1.05 / (0.2126 * channel(0) + 0.7152 * channel(2) + 0.0722 * channel(4) + 0.05)
}

#[test]
fn text_and_series_stand_out_from_the_paper() {
    assert!(
        (contrast_with_white("767676") - 4.54).abs() < 0.01,
        "the example of the standard"
    );
    let html = Page::new("Colours").to_html();
    let names = ["--ink:", "--soft:", "--tone:", "--c:"];
    let colours: Vec<&str> = names
        .iter()
        .flat_map(|name| html.split(*name).skip(1))
        .map(|rest| &rest[2..8])
        .collect();
    assert_eq!(colours.len(), 2 + 3 + 7);
    for colour in colours {
        assert!(contrast_with_white(colour) >= 4.5, "#{colour}");
    }
}
