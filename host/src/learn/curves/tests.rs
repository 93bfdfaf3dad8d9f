use super::*;
use crate::learn::td3::curve::to_csv;

fn point(updates: u64, reward: f64, speed_m_s: f64) -> CurvePoint {
    CurvePoint {
        env_steps: if updates == 0 { 0 } else { 1_000 + 10 * updates },
        updates,
        wall_s: updates as f64,
        reward,
        speed_m_s,
        episode_steps: 300.0,
        critic_loss: 0.0,
        actor_loss: 0.0,
        q_mean: 0.0,
    }
}

fn curve(rewards: &[f64]) -> Vec<CurvePoint> {
    let point = |(index, &reward): (usize, &f64)| point(2500 * index as u64, reward, reward / 100.0);
    rewards.iter().enumerate().map(point).collect()
}

fn write(folder: &Path, curve: &[CurvePoint]) {
    std::fs::create_dir_all(folder).unwrap();
    std::fs::write(folder.join(run_folder::LEARNING_CURVE), to_csv(curve)).unwrap();
}

/// A folder as `train --seeds` leaves it, with the best seed's curve above the others.
fn run_of(curves: &[&[f64]]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (seed, rewards) in curves.iter().enumerate() {
        write(&folder.path().join(format!("seed-{seed}")), &curve(rewards));
    }
    write(folder.path(), &curve(curves[0]));
    folder
}

fn read(folder: &Path) -> Result<RunCurves, CurvesError> {
    RunCurves::read(folder, "run".into())
}

#[test]
fn two_seeds_give_their_mean_and_spread() {
    let folder = run_of(&[&[10.0, 40.0, 30.0], &[20.0, 20.0, 50.0]]);

    let run = read(folder.path()).unwrap();

    let means: Vec<f64> = run.rows().iter().map(|row| row.score.reward.mean).collect();
    assert_eq!(means, [15.0, 30.0, 40.0]);
    let row = run.rows()[1];
    assert_eq!((row.updates, row.env_steps, row.seeds), (2500, 26_000, 2));
    let Spread { mean, deviation, min, max } = row.score.speed_m_s;
    assert!((mean - 0.3).abs() < 1e-12 && (deviation - 0.02_f64.sqrt()).abs() < 1e-12, "{mean} {deviation}");
    assert_eq!((min, max), (0.2, 0.4));
    assert_eq!(run.last().reward.mean, 40.0);
    // 40 of the first, 50 of the second.
    assert_eq!(run.best().reward, Spread { mean: 45.0, deviation: 50_f64.sqrt(), min: 40.0, max: 50.0 });
}

#[test]
fn a_single_run_is_a_curve_without_spread() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &curve(&[1.0, 2.0]));

    let run = read(folder.path()).unwrap();

    assert_eq!(run.seeds.len(), 1);
    assert_eq!(run.last().reward, Spread { mean: 2.0, deviation: 0.0, min: 2.0, max: 2.0 });
}

#[test]
fn seeds_are_taken_by_their_numbers_and_other_folders_are_not() {
    let folder = run_of(&[[1.0].as_slice(); 11]);
    write(&folder.path().join("seed-x"), &curve(&[9.0]));
    write(&folder.path().join("seed-02"), &curve(&[9.0]));
    write(&folder.path().join("seed-+3"), &curve(&[9.0]));
    write(&folder.path().join("checkpoint"), &curve(&[9.0]));

    let run = read(folder.path()).unwrap();

    let names: Vec<&str> = run.seeds.iter().map(|seed| seed.name.as_str()).collect();
    assert_eq!(names.len(), 11);
    assert_eq!(names[8..], ["seed-8", "seed-9", "seed-10"]);
}

/// Three evaluations, of which the last is of one seed: the band ends with the second.
#[test]
fn where_one_seed_is_left_nothing_is_shaded() {
    let folder = run_of(&[&[10.0, 20.0, 30.0], &[30.0, 40.0]]);
    let figure = figure(&[read(folder.path()).unwrap()], Band::Deviation).unwrap();

    let bands = |panel: &crate::plot::Panel| -> Vec<f64> {
        let bands = panel.layers.iter().filter(|layer| layer.mark == crate::plot::Mark::Band);
        bands.flat_map(|layer| &layer.points).map(|&(x, _)| x).collect()
    };
    assert_eq!(bands(&figure.panels[0]), [0.0, 2500.0, 2500.0, 0.0]);

    let alone = run_of(&[&[10.0, 20.0, 30.0]]);
    let figure = super::figure(&[read(alone.path()).unwrap()], Band::Deviation).unwrap();
    assert!(bands(&figure.panels[0]).is_empty());
}

/// One seed is at its second evaluation, one has not begun, one has a header only.
#[test]
fn a_run_that_goes_on_is_read_as_far_as_it_came() {
    let folder = run_of(&[&[10.0, 20.0, 30.0], &[30.0, 40.0]]);
    std::fs::create_dir(folder.path().join("seed-2")).unwrap();
    write(&folder.path().join("seed-3"), &[]);

    let run = read(folder.path()).unwrap();

    let counts: Vec<usize> = run.rows().iter().map(|row| row.seeds).collect();
    assert_eq!(counts, [2, 2, 1]);
    assert_eq!(run.rows()[2].score.reward.mean, 30.0);
    assert_eq!(run.behind().map(|seed| seed.name.as_str()).collect::<Vec<_>>(), ["seed-1"]);
    assert_eq!(run.without_curve, ["seed-2", "seed-3"]);
    let svg = figure(&[run], Band::Deviation).unwrap().to_svg().unwrap();
    assert!(svg.contains("dashed"));
}

#[test]
fn folders_without_a_curve_and_seeds_of_different_schedules_are_refused() {
    let empty = tempfile::tempdir().unwrap();
    assert!(matches!(read(empty.path()), Err(CurvesError::NoCurve { .. })));
    assert!(matches!(read(&empty.path().join("nowhere")), Err(CurvesError::NoCurve { .. })));
    std::fs::create_dir(empty.path().join("seed-0")).unwrap();
    assert!(matches!(read(empty.path()), Err(CurvesError::NoCurve { .. })));

    let folder = run_of(&[&[1.0, 2.0, 3.0], &[1.0, 2.0]]);
    write(&folder.path().join("seed-1"), &[point(0, 1.0, 0.0), point(3000, 2.0, 0.0)]);
    let refused = read(folder.path()).unwrap_err();
    assert!(
        matches!(refused, CurvesError::Grid { row: 2, updates: 3000, other_updates: 2500, .. }),
        "{refused}"
    );

    std::fs::write(folder.path().join("seed-1").join(run_folder::LEARNING_CURVE), "env_steps\n1\n").unwrap();
    assert!(matches!(read(folder.path()), Err(CurvesError::Curve(CurveError::Csv { .. }))));
}

#[test]
fn a_figure_names_every_run_and_both_scales_and_is_the_same_file_again() {
    let one = run_of(&[&[10.0, 40.0], &[20.0, 20.0]]);
    let other = run_of(&[&[5.0, 6.0, 9.0]]);
    let draw = || {
        let runs = [(&one, "walk, 1 L"), (&other, "paper, 0.6 L")]
            .map(|(folder, label)| RunCurves::read(folder.path(), label.into()).unwrap());
        figure(&runs, Band::Range).unwrap().to_svg().unwrap()
    };

    let svg = draw();

    for text in
        ["walk, 1 L, 2 seeds", "paper, 0.6 L, 1 seed", "forward speed (m/s)", "updates", "control steps"]
    {
        assert!(svg.contains(text), "{text}");
    }
    assert_eq!(svg, draw());
}

#[test]
fn steps_that_grow_otherwise_in_another_run_have_no_axis() {
    let (one, other) = (run_of(&[&[1.0, 2.0, 3.0]]), tempfile::tempdir().unwrap());
    let faster = |updates| CurvePoint { env_steps: 30 * updates, ..point(updates, 1.0, 0.1) };
    write(other.path(), &[faster(0), faster(2500), faster(5000)]);
    let runs = [one.path(), other.path()].map(|folder| read(folder).unwrap());

    let svg = figure(&runs, Band::Deviation).unwrap().to_svg().unwrap();

    assert!(!svg.contains("control steps"));
}

#[test]
fn more_runs_than_colours_are_refused() {
    let folder = run_of(&[&[1.0, 2.0]]);
    let run = read(folder.path()).unwrap();

    assert!(figure(&vec![run.clone(); 7], Band::Deviation).is_ok());
    assert_eq!(figure(&vec![run; 8], Band::Deviation).unwrap_err(), TooManyRuns { runs: 8 });
}
