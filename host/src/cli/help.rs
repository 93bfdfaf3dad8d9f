//! What `host --help` prints: the subcommands in groups, and the exit codes.
//!
//! Holds the table of groups, which clap does not have; each subcommand
//! describes itself. Does not depend on what a subcommand does.

use clap::Command;
use std::fmt::Write as _;

/// Every subcommand, in the order in which a gait is made. A new subcommand
/// that is not in here fails a test.
const GROUPS: [(&str, &[&str]); 5] = [
    ("Learn a gait", &["train", "curves", "record", "fit"]),
    ("Search for a gait", &["optimise", "sinusoid"]),
    (
        "Use the robot",
        &["calibrate", "upload-gait", "measure", "walk", "play", "status", "set", "stop", "gaits"],
    ),
    ("Describe a robot, and simulate it", &["robot", "simulate", "twin"]),
    ("Study", &["demo", "experiment", "bench"]),
];

const EXIT_CODES: &str = "\
Exit codes:
    0  done
    1  system error: disk, memory, libtorch
    2  invalid command line
    3  invalid input: a file, a gait outside its limits, a missing column
    4  no robot: no port, no answer, a broken link
    5  the robot refused, or stopped by itself
  130  interrupted; results so far are saved";

/// Columns that every terminal has.
const COLUMNS: usize = 80;

/// `command` with its subcommands listed by group.
pub fn with_groups(command: Command) -> Command {
    let template = format!(
        "{{about}}\n\n{{usage-heading}} {{usage}}\n{groups}\n{heading}Options:{heading:#}\n{{options}}\n\n\
         `host COMMAND --help` explains a command, `host COMMAND -h` lists its options.\n\n{EXIT_CODES}\n",
        heading = command.get_styles().get_header(),
        groups = groups(&command),
    );
    command.help_template(template)
}

fn groups(command: &Command) -> String {
    let (heading, literal) = (command.get_styles().get_header(), command.get_styles().get_literal());
    let width = GROUPS.iter().flat_map(|(_, names)| *names).map(|name| name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for (title, names) in GROUPS {
        // A build without training lacks some.
        let found: Vec<&Command> = names.iter().filter_map(|name| command.find_subcommand(name)).collect();
        if found.is_empty() {
            continue;
        }
        // Writing to a string cannot fail.
        let _ = writeln!(text, "\n{heading}{title}:{heading:#}");
        for subcommand in found {
            let name = subcommand.get_name();
            let about = subcommand.get_about().map(ToString::to_string).unwrap_or_default();
            let about = hanging(&about, width + 4);
            let _ = writeln!(text, "  {literal}{name}{literal:#}{:1$}  {about}", "", width - name.len());
        }
    }
    text
}

/// Lines of words within [`COLUMNS`]; those after the first are indented as the first begins.
fn hanging(text: &str, indent: usize) -> String {
    let (mut lines, mut column) = (String::new(), indent);
    for word in text.split_whitespace() {
        let width = word.chars().count();
        if column > indent && column + 1 + width > COLUMNS {
            let _ = write!(lines, "\n{:indent$}", "");
            column = indent;
        } else if column > indent {
            lines.push(' ');
            column += 1;
        }
        lines.push_str(word);
        column += width;
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn every_subcommand_is_in_one_group() {
        let command = crate::cli::Cli::command();
        for subcommand in command.get_subcommands() {
            let name = subcommand.get_name();
            let count = GROUPS.iter().flat_map(|(_, names)| *names).filter(|listed| **listed == name).count();

            assert_eq!(count, 1, "`{name}` is in {count} groups of `host --help`: see GROUPS in cli/help.rs");
        }
    }

    #[test]
    fn the_overview_fits_a_small_terminal_and_lists_what_there_is() {
        let help = with_groups(crate::cli::Cli::command()).render_help().to_string();

        let widest = help.lines().map(|line| line.chars().count()).max();
        assert!(widest.is_some_and(|widest| widest <= COLUMNS), "{help}");
        assert!(help.contains("\nUse the robot:\n  calibrate    "), "{help}");
        assert!(!help.contains("Commands:"), "{help}");
    }

    #[test]
    fn a_long_description_goes_on_below_its_first_word() {
        let text = hanging(&"words ".repeat(30), 15);

        assert!(
            text.lines().count() > 2 && text.lines().skip(1).all(|line| line.starts_with(&" ".repeat(15)))
        );
        assert!(text.lines().skip(1).all(|line| line.chars().count() <= COLUMNS), "{text}");
        assert_eq!(text.split_whitespace().count(), 30);
    }
}
