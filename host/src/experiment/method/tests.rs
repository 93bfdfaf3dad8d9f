//! The table of methods is consistent.

use super::*;

#[test]
fn names_are_those_of_json_and_of_the_command_line() {
    for method in Method::all() {
        assert_eq!(serde_json::to_value(method).unwrap(), method.name());
        assert_eq!(Method::from_str(method.name(), false), Ok(method));
    }
}

#[test]
fn no_two_methods_share_a_name_a_label_or_a_colour() {
    for (a, b) in Method::all().flat_map(|a| Method::all().map(move |b| (a, b))).filter(|(a, b)| a < b) {
        let (a, b) = (a.spec(), b.spec());
        assert!(a.name != b.name && a.label != b.label && a.gait != b.gait, "{} {}", a.name, b.name);
        assert_ne!(a.colour, b.colour, "{} and {}", a.name, b.name);
        assert_ne!(a.colour, Colour(0, 0, 0), "{}: black is what the authors measured", a.name);
    }
}

#[test]
fn every_method_of_the_paper_has_its_numbers_and_no_other_has() {
    for method in Method::all() {
        assert_eq!(method.spec().paper.is_some(), Method::PAPERS.contains(&method), "{}", method.name());
    }
    assert_eq!(Method::Sinusoid.table_2(crate::robot::LegScale::SHORT), Some((0.764, 0.104)));
    assert_eq!(Method::Sinusoid.table_2(crate::robot::LegScale::new(0.8).unwrap()), None);
}

#[test]
fn one_training_at_most_keeps_its_stride() {
    let keeps =
        |method: &Method| matches!(method.spec().recipe, Some(Recipe::Train { keeps_stride: true, .. }));
    let keeping: Vec<&str> = Method::all().filter(keeps).map(Method::name).collect();

    assert!(keeping.len() <= 1, "{keeping:?} would overwrite each other's stride");
}

/// A method whose gait comes with the program can be made anew, and one that cannot is read
/// from somewhere else.
#[test]
fn every_bundled_method_has_a_recipe_and_no_other_has() {
    for method in Method::all() {
        let is_bundled = Method::bundled().any(|bundled| bundled == method);
        assert_eq!(method.spec().recipe.is_some(), is_bundled, "{}", method.name());
        if let Some(Recipe::With(other)) = method.spec().recipe {
            let keeps = matches!(other.spec().recipe, Some(Recipe::Train { keeps_stride: true, .. }));
            assert!(keeps, "{} is made with {}, which keeps no stride", method.name(), other.name());
        }
    }
}
