use super::*;

const HEADER: &str = "time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4";

fn read(text: &str, columns: Option<&str>) -> Result<Trajectory, TrajectoryError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walk.csv");
    std::fs::write(&path, text).unwrap();
    let columns: Option<Vec<String>> = columns.map(|c| c.split(',').map(str::to_owned).collect());
    Trajectory::read(&path, columns.as_deref())
}

#[test]
fn our_own_file_is_recognised_as_a_stride() {
    let trajectory = read(&format!("{HEADER}\n0,1,2,3,4,5,6,7,8\n0.5,1,2,3,4,5,6,7,9\n"), None).unwrap();

    assert!(trajectory.is_own_stride);
    assert_eq!(trajectory.actions[1], [1., 2., 3., 4., 5., 6., 7., 9.]);
    assert_eq!(trajectory.interval_s(0, 2).unwrap(), Some(0.5));
}

#[test]
fn columns_in_any_order_under_the_papers_names_find_their_joints() {
    let text = "hip4,ank4,hip1,ank1,hip2,ank2,hip3,ank3,comment\n4,8,1,5,2,6,3,7,0\n";

    let trajectory = read(text, None).unwrap();

    assert!(!trajectory.is_own_stride);
    assert_eq!(trajectory.actions, [[1., 2., 3., 4., 5., 6., 7., 8.]]);
    assert_eq!(trajectory.times_s, None);
}

#[test]
fn a_file_without_a_header_is_read_by_the_columns_given() {
    let columns = Some("-,knee4,hip1,hip2,hip3,hip4,knee1,knee2,knee3");

    let trajectory = read("99,8,1,2,3,4,5,6,7\n", columns).unwrap();

    assert_eq!(trajectory.actions, [[1., 2., 3., 4., 5., 6., 7., 8.]]);
}

#[test]
fn each_hole_in_a_file_is_named() {
    let row = "0,1,2,3,4,5,6,7,8";
    let cases = [
        (String::new(), "has no rows"),
        (format!("{HEADER}\n"), "has no rows"),
        (format!("{row}\n"), "has no header: its first line is \"0,1,2,3,4,5,6,7,8\""),
        (format!("{HEADER}\n{row}\n0.1,1,2,NaN,4,5,6,7,8\n"), "line 3: hip3 is \"NaN\""),
        (format!("{HEADER}\n{row}\n0.1,1,2,3,4,5,6,7,-inf\n"), "line 3: knee4 is \"-inf\""),
        (format!("{HEADER}\n0,1,2,3,4,5,six,7,8\n"), "line 2: knee2 is \"six\""),
        (format!("{HEADER}\n0,1,2,3,4,5,6,7\n"), "line 2: 8 values where there are 9 columns"),
        (format!("{},ank4\n{row},9\n", HEADER), "has knee4 twice: columns 9 and 10"),
        ("hip1,hip2,hip3,hip4,knee1,knee2\n1,2,3,4,5,6\n".into(), "6 of 8 joints: knee3, knee4 missing"),
    ];
    for (text, expected) in cases {
        let message = read(&text, None).unwrap_err().to_string();

        assert!(message.contains(expected), "{text:?}: {message}");
    }
}

#[test]
fn a_wrong_joint_count_in_the_given_columns_is_refused() {
    let message =
        read("1,2,3,4,5,6,7\n", Some("hip1,hip2,hip3,hip4,knee1,knee2,knee3")).unwrap_err().to_string();

    assert!(message.contains("7 of 8 joints: knee4 missing"), "{message}");
}

#[test]
fn an_unknown_name_in_the_given_columns_is_refused() {
    let message = read("1,2\n", Some("hip1,tail")).unwrap_err().to_string();

    assert!(message.contains("\"tail\" is neither a joint"), "{message}");
}

#[test]
fn time_that_jumps_is_refused_with_its_line() {
    let rows: String = [0.0, 0.1, 0.2, 0.6, 0.7].iter().map(|t| format!("{t},1,2,3,4,5,6,7,8\n")).collect();
    let trajectory = read(&format!("{HEADER}\n{rows}"), None).unwrap();

    let message = trajectory.interval_s(0, 5).unwrap_err().to_string();

    assert!(message.starts_with("line 5: time_s goes from 0.2 to 0.6"), "{message}");
    assert_eq!(trajectory.interval_s(0, 3).unwrap(), Some(0.1));
}

#[test]
fn rows_beyond_the_end_are_refused() {
    let trajectory = read(&format!("{HEADER}\n0,1,2,3,4,5,6,7,8\n"), None).unwrap();

    let message = trajectory.rows(0, 27).unwrap_err().to_string();

    assert_eq!(message, "rows 0..27 are not in the file, which has rows 0..1");
}
