//! `host experiment --port` with somebody at the terminal who answers its
//! questions. Linux only: the terminal is.
#![cfg(all(feature = "train", target_os = "linux"))]

mod bench_host;
mod fake_robot;
mod terminal;

use bench_host::Setting;
use fake_robot::Troubles;
use terminal::Terminal;

const BEFORE: &str = "Enter starts the walk, s skips this trial, q quits: ";
const BROKEN_OFF: &str = "n records it as stopped, s skips this trial, q quits: ";
const DISTANCE: &str = "in metres: ";
const AFTER: &str = "r to repeat it: ";

fn experiment(setting: &Setting, more: &[&str]) -> Terminal {
    let args = ["experiment", "--leg=1", "--method=psto", "--amp=1.4,1.6", "--trials=2", "--duration=0.5"];
    let folder = setting.folder.path();
    Terminal::host(folder, &[&args[..], &["--out=study", "--port", &setting.bench.port], more].concat())
}

/// A CSV of positions says nothing of falls: the person is asked.
#[test]
fn with_a_tracker_that_tells_no_tilt_the_person_says_whether_it_fell() {
    let setting = Setting::new(Troubles::default());
    let now = std::time::UNIX_EPOCH.elapsed().unwrap().as_secs_f64();
    let rows: String =
        (0..900).map(|i| f64::from(i) / 10.0).map(|t| format!("{:.3},{:.6},0\n", now + t, 0.3 * t)).collect();
    std::fs::write(setting.folder.path().join("track.csv"), format!("time_s,x_m,y_m\n{rows}")).unwrap();

    let mut terminal = experiment(&setting, &["--tracker=track.csv", "--mass-kg=2"]);
    terminal.after(BEFORE, "\n");
    terminal.after("Enter if it walked well, f if it fell, r to repeat it: ", "f\n");
    terminal.after("Recorded as: fell", "");
    terminal.after(BEFORE, "q\n");
    terminal.end();

    assert_eq!(noted(&setting)[0][3], "fell");
    // As it was weighed.
    let telemetry =
        std::fs::read_to_string(setting.folder.path().join("study/walks/ant-1L/trials.csv")).unwrap();
    let mut rows = csv::Reader::from_reader(telemetry.as_bytes());
    let column = rows.headers().unwrap().iter().position(|name| name == "mass_kg").unwrap();
    assert_eq!(&rows.records().next().unwrap().unwrap()[column], "2");
}

/// Amplification, trial, distance and mark of each that was noted.
fn noted(setting: &Setting) -> Vec<[String; 4]> {
    let mut reader = csv::Reader::from_path(setting.folder.path().join("study/study-trials.csv")).unwrap();
    let column = |name: &str, headers: &csv::StringRecord| headers.iter().position(|h| h == name).unwrap();
    let headers = reader.headers().unwrap().clone();
    let columns = ["amplification", "trial", "distance_m", "mark"].map(|name| column(name, &headers));
    reader.records().map(|record| columns.map(|i| record.as_ref().unwrap()[i].to_owned())).collect()
}

#[test]
fn trials_are_walked_repeated_judged_and_left_out_as_the_person_says_and_offered_again() {
    let setting = Setting::new(Troubles::default());

    let mut today = experiment(&setting, &[]);
    today.after(BEFORE, "\n");
    today.after(DISTANCE, "0.3\n");
    today.after(AFTER, "r\n");
    today.after(BEFORE, "\n");
    today.after(DISTANCE, "far\n");
    today.after("\"far\" is no", "0,25\n");
    today.after(AFTER, "\n");
    today.after("Recorded: 0.500 m/s", "");
    today.after(BEFORE, "s\n");
    today.after(BEFORE, "\n");
    // Typed ahead, Enters are no answers: it would have walked well, and walked again.
    today.after(DISTANCE, "0.2\n\n\n");
    today.after(AFTER, "f\n");
    today.after("Recorded as: fell", "");
    today.after(BEFORE, "perhaps\n");
    today.after("\"perhaps\" is not an answer: press Enter, or type one of s, q", "q\n");
    let (status, said) = today.end();

    assert!(status.success(), "{said}");
    assert!(said.contains("Stopped: the trials so far are in study") && said.contains("to resume"), "{said}");
    let row = |row: [&str; 4]| row.map(str::to_owned);
    assert_eq!(noted(&setting), [row(["1.4", "0", "0.25", ""]), row(["1.6", "0", "0.2", "fell"])]);

    let mut tomorrow = experiment(&setting, &[]);
    tomorrow.after("at 1.4x, legs of 1 L, trial 2; 2 left", "\n");
    tomorrow.after(DISTANCE, "0.1\n");
    tomorrow.after(AFTER, "b\n");
    tomorrow.after("at 1.6x, legs of 1 L, trial 2; 1 left", "s\n");
    let (status, said) = tomorrow.end();

    assert!(status.success(), "{said}");
    assert!(
        said.contains("3 trials in 2 conditions")
            && said.contains("skipped, 1: run the same command")
            && said.contains("report.html"),
        "{said}"
    );
    // What the person saw outweighs what the other trials did.
    assert_eq!(noted(&setting)[2], row(["1.4", "1", "0.1", "backwards"]));
}

#[test]
fn a_trial_that_the_robot_broke_off_is_walked_again_or_noted_as_such() {
    let setting = Setting::new(Troubles { faults_at: Some(10), ..Default::default() });

    let mut terminal = experiment(&setting, &[]);
    terminal.after(BEFORE, "\n");
    terminal.after(BROKEN_OFF, "\n");
    terminal.after(BEFORE, "\n");
    terminal.after(BROKEN_OFF, "n\n");
    terminal.after("Recorded as: stopped", "");
    terminal.after(BEFORE, "\n");
    terminal.after(BROKEN_OFF, "s\n");
    terminal.after(BEFORE, "q\n");
    terminal.end();

    assert_eq!(noted(&setting), [["1.4", "0", "", "stopped"].map(str::to_owned)]);
}

#[test]
fn ctrl_c_is_heard_while_a_question_is_open() {
    let setting = Setting::new(Troubles::default());

    let mut terminal = experiment(&setting, &[]);
    terminal.after(BEFORE, "\x03");
    let (status, said) = terminal.end();

    assert_eq!(status.code(), Some(130), "{said}");
    assert!(said.contains("the trials so far are in study"), "{said}");

    let mut terminal = experiment(&setting, &[]);
    terminal.after(BEFORE, "\n");
    terminal.after(DISTANCE, "\x03");
    let (status, said) = terminal.end();

    assert_eq!(status.code(), Some(130), "{said}");
    assert!(said.contains("the trials so far are in study"), "{said}");
}
