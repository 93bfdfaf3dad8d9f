//! `host gaits`: lists the gaits that the robot stores; selects or erases one.
//!
//! Holds the search by name: the robot itself numbers its places. Does not depend on
//! what is in a gait.

use super::explain::failure_with_help;
use super::reach::{Port, unreachable_robot};
use super::{Cause, Failure};
use crate::device::link::LinkError;
use crate::device::link::ports::SerialLink;
use crate::gait::gait_file::limits::as_typed;
use protocol::command::StoredGait;
use protocol::{Command, GAIT_SLOTS, Reply};
use serde_json::json;
use thiserror::Error;

/// List the gaits that the robot stores; select or erase one.
///
/// `host upload-gait` stores a gait under its name: a gait of the same name is
/// replaced, another takes a free place.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    port: Port,
    /// Play this gait, now and after every start
    #[arg(long, value_name = "NAME", conflicts_with = "erase")]
    select: Option<String>,
    /// Erase this gait
    #[arg(long, value_name = "NAME")]
    erase: Option<String>,
    /// Print the list as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Error)]
#[error("the robot stores no gait {name:?}; it has {}", list(.stored))]
struct NoSuchGait {
    name: String,
    stored: Vec<String>,
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none".into() } else { names.join(", ") }
}

/// A place and what is in it.
type Place = (u8, Option<StoredGait>);

pub fn run(args: Args) -> Result<(), Failure> {
    let mut link = args.port.connect()?;
    if let Some(name) = &args.select {
        let slot = find(&stored(&mut link).map_err(unreachable_robot)?, name)?;
        link.order(Command::SelectGait { slot }).map_err(unreachable_robot)?;
    }
    if let Some(name) = &args.erase {
        let slot = find(&stored(&mut link).map_err(unreachable_robot)?, name)?;
        link.order(Command::EraseGait { slot }).map_err(unreachable_robot)?;
    }
    let places = stored(&mut link).map_err(unreachable_robot)?;
    let active = link.status().map_err(unreachable_robot)?.gait;
    let active = active.as_ref().map_or("", |gait| gait.name.as_str());
    if args.json {
        let gaits: Vec<_> = places
            .iter()
            .filter_map(|(slot, gait)| {
                let gait = gait.as_ref()?;
                Some(json!({
                    "slot": slot,
                    "name": gait.name.as_str(),
                    "amplitude": as_typed(gait.amplitude),
                    "at_start": gait.at_start,
                    "active": gait.name.as_str() == active,
                }))
            })
            .collect();
        println!("{:#}", json!({ "places": places.len(), "active": active, "gaits": gaits }));
    } else {
        print(&places, active);
    }
    Ok(())
}

fn print(places: &[Place], active: &str) {
    for (slot, gait) in places {
        let place = slot + 1;
        match gait {
            Some(gait) => {
                let name = gait.name.as_str();
                let at_start = if gait.at_start { ", played after every start" } else { "" };
                let now = if name == active { ", active now" } else { "" };
                println!("{place}  {name:16}  {}x{at_start}{now}", as_typed(gait.amplitude));
            }
            None => println!("{place}  free"),
        }
    }
    let stores = |name: &str| places.iter().flat_map(|(_, gait)| gait).any(|gait| gait.name.as_str() == name);
    if !active.is_empty() && !stores(active) {
        println!("active now: \"{active}\", which is not stored");
    }
}

fn stored(link: &mut SerialLink) -> Result<Vec<Place>, LinkError> {
    let slots = link.hello().map_or(GAIT_SLOTS, |hello| hello.limits.gait_slots);
    (0..slots)
        .map(|slot| match link.request(Command::StoredGait { slot })? {
            Reply::Stored(gait) => Ok((slot, gait)),
            _ => Err(LinkError::WrongReply { command: "tell which gaits it stores" }),
        })
        .collect()
}

fn find(places: &[Place], name: &str) -> Result<u8, Failure> {
    let names: Vec<_> =
        places.iter().flat_map(|(_, gait)| gait).map(|gait| gait.name.as_str().to_owned()).collect();
    let has_name = |(_, gait): &&Place| gait.is_some_and(|gait| gait.name.as_str() == name);
    places.iter().find(has_name).map(|(slot, _)| *slot).ok_or_else(|| {
        let help = match names.first() {
            Some(first) => format!("write its name as it is stored, such as '{first}'"),
            None => "store one first: host upload-gait --amp 2.2".to_owned(),
        };
        failure_with_help(Cause::Robot, NoSuchGait { name: name.into(), stored: names.clone() }, help)
    })
}
