//! The defaults that a program's help states, and their comparison with the values that its verbs use.
//!
//! Every option that takes a value and is not required must be part of such a comparison, whether its help
//! states a default or not. The comparison fails if a new option is missing.

use std::collections::BTreeMap;

use clap::{ArgAction, Command};

/// The verbs of a program without sub-verbs, as words of a command line.
pub fn verbs(program: &Command) -> Vec<(String, Command)> {
    let mut program = program.clone();
    program.build();
    leaves("", &program)
}

/// Checks that the table of a guide, whose header begins with "| verb of `PROGRAM`", names each verb of a
/// program, and no other.
///
/// # Panics
/// Panics with the names if it does not.
pub fn assert_listed(guide: &str, name: &str, program: &Command) {
    let header = format!("| verb of `{name}`");
    let table = guide.lines().skip_while(|line| !line.starts_with(&header)).skip(2);
    let rows = table.take_while(|line| line.starts_with('|'));
    let mut listed: Vec<String> =
        rows.flat_map(|row| named_verbs(row.split(" | ").next().unwrap())).collect();
    let mut verbs: Vec<String> = verbs(program).into_iter().map(|(verb, _)| verb).collect();
    listed.sort();
    verbs.sort();
    assert_eq!(listed, verbs, "the guide's table, and the verbs of {name}");
}

/// Returns the verbs of a cell: the words in lower case that each code span begins with. A cell may name the
/// further sub-verbs of its first verb without the verb.
fn named_verbs(cell: &str) -> Vec<String> {
    let is_verb =
        |word: &&str| word.chars().all(|c| c.is_ascii_lowercase() || c == '-') && !word.starts_with('-');
    let codes = cell.split('`').skip(1).step_by(2);
    let names: Vec<Vec<&str>> = codes.map(|code| code.split(' ').take_while(is_verb).collect()).collect();
    let above: &[&str] = match names.first() {
        Some(first) => &first[..first.len().saturating_sub(1)],
        None => &[],
    };
    let full = |name: &[&str]| {
        if name.len() > above.len() { name.join(" ") } else { [above, name].concat().join(" ") }
    };
    names.iter().map(|name| full(name)).collect()
}

fn leaves(above: &str, command: &Command) -> Vec<(String, Command)> {
    let below = command.get_subcommands().filter(|verb| verb.get_name() != "help");
    let found: Vec<_> =
        below.flat_map(|verb| leaves(format!("{above} {}", verb.get_name()).trim(), verb)).collect();
    if found.is_empty() { vec![(above.to_owned(), command.clone())] } else { found }
}

/// Returns the default of each option that takes a value and is not required, as the help of a verb states
/// it. `None` if the help states none. A switch is included if its help states a default.
pub fn stated_defaults(verb: &Command) -> BTreeMap<String, Option<String>> {
    let help = verb.clone().term_width(0).render_long_help().to_string();
    let options = verb.get_arguments().filter(|arg| !arg.is_hide_set() && !arg.is_required_set());
    options
        .filter_map(|arg| {
            let takes_value = matches!(arg.get_action(), ArgAction::Set | ArgAction::Append);
            let name = match arg.get_long() {
                Some(long) => format!("--{long}"),
                None => arg.get_id().to_string(),
            };
            let stated = stated_in(&help, &name);
            (takes_value || stated.is_some()).then_some((name, stated))
        })
        .collect()
}

/// Returns the option that a line of a help text introduces. Such lines are indented by two or six spaces.
/// Descriptions, which may begin with an option too, are indented by more.
fn head(line: &str) -> Option<&str> {
    let text = line.trim_start();
    let is_head = matches!(line.len() - text.len(), 2 | 6) && text.starts_with('-');
    text.split_whitespace().find(|word| is_head && word.starts_with("--"))
}

/// Returns the default that a help text states for an option.
fn stated_in(help: &str, name: &str) -> Option<String> {
    let is_of_option = |line: &&str| head(line).and_then(|head| head.split(['[', '=']).next()) == Some(name);
    let block = help.lines().skip_while(|line| !is_of_option(line)).skip(1);
    let block: Vec<&str> = block.take_while(|line| head(line).is_none()).collect();
    let block = block.join(" ");
    let text = block.split_once("[default")?.1.split_once(']')?.0;
    Some(text.strip_prefix(':').unwrap_or(text).split_whitespace().collect::<Vec<_>>().join(" "))
}

/// Compares the defaults that the help of a verb states with the values that the verb uses. `used` holds
/// options and their values as text; the text is empty if the option has no default.
///
/// # Panics
///
/// Panics if an option is missing on either side, or if a default is not the value that is used.
pub fn assert_defaults(name: &str, verb: &Command, used: &[(&str, String)]) {
    let stated: BTreeMap<_, _> =
        stated_defaults(verb).into_iter().map(|(option, text)| (option, text.unwrap_or_default())).collect();
    let used: BTreeMap<_, _> =
        used.iter().map(|(option, text)| ((*option).to_owned(), text.clone())).collect();
    for (option, text) in &stated {
        let value = used.get(option);
        assert!(
            value.is_some(),
            "{name} {option}: its default ({text:?}) is not compared with the value that is used"
        );
        assert_eq!(value, Some(text), "{name} {option}: its help states another default than is used");
    }
    let unknown: Vec<_> = used.keys().filter(|option| !stated.contains_key(*option)).collect();
    assert!(unknown.is_empty(), "{name}: no such options: {unknown:?}");
}

#[cfg(test)]
mod tests {
    use clap::Arg;

    use super::*;

    #[test]
    fn defaults_are_read_from_the_help() {
        let command = Command::new("program").subcommand(
            Command::new("verb")
                .arg(Arg::new("path").required(true))
                .arg(Arg::new("width").long("width").short('w').default_value("5").help("Width"))
                .arg(
                    Arg::new("wide").long("wide").help("--width is not wide [default: as\nwide as the rest]"),
                )
                .arg(Arg::new("none").long("none").value_name("A[:B]").help("Nothing"))
                .arg(Arg::new("needed").long("needed").required(true))
                .arg(Arg::new("quick").long("quick").action(ArgAction::SetTrue).help("Be quick [default]"))
                .arg(Arg::new("slow").long("slow").action(ArgAction::SetTrue)),
        );
        let [(name, verb)] = &verbs(&command)[..] else { panic!("one verb") };
        assert_eq!(name, "verb");
        let used = [
            ("--width", "5".to_owned()),
            ("--wide", "as wide as the rest".to_owned()),
            ("--none", String::new()),
            ("--quick", String::new()),
        ];
        assert_defaults(name, verb, &used);
        let fails = |used: &[(&str, String)]| {
            let asserts = std::panic::AssertUnwindSafe(|| assert_defaults(name, verb, used));
            std::panic::catch_unwind(asserts).is_err()
        };
        assert!(fails(&used[1..]), "an option that is not compared");
        assert!(fails(&[&used[1..], &[("--width", "1".to_owned())]].concat()), "another value");
        assert!(fails(&[&used[..], &[("--none-such", String::new())]].concat()), "no such option");
    }
}
