//! Names of a front's gaits: all different, whatever the speeds and the legs.

use protocol::Name;

/// `prefix` and each speed, with a letter where that is taken; the prefix gives way to 16 characters.
pub fn distinct(prefix: &str, speeds_m_s: &[f64]) -> Vec<String> {
    let mut names: Vec<String> = Vec::with_capacity(speeds_m_s.len());
    for speed_m_s in speeds_m_s {
        let letters = core::iter::once(String::new()).chain(('b'..='z').map(String::from));
        let all = letters.map(|letter| {
            let end = format!("-{speed_m_s:.2}{letter}");
            let room = Name::CAPACITY.saturating_sub(end.len());
            prefix.chars().take(room).collect::<String>() + &end
        });
        names.extend(all.into_iter().find(|name| !names.contains(name)));
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_fit_a_robot_and_are_never_alike() {
        let names = distinct("opt-1L", &[0.25, 0.31, 0.312]);
        assert_eq!(names, ["opt-1L-0.25", "opt-1L-0.31", "opt-1L-0.31b"]);

        let names = distinct("opt-0.6123456789L", &[0.012, 0.014, 0.016]);
        assert_eq!(names, ["opt-0.61234-0.01", "opt-0.6123-0.01b", "opt-0.61234-0.02"]);
        assert!(names.iter().all(|name| Name::new(name).is_some()));
    }
}
