//! What real graphics cards are to reach, and what is to hold everywhere. Each aim stands beside a figure of its own.

use crate::bench::report::Aim;

/// An aim, as rows name it.
#[derive(Debug)]
pub struct Goal {
    pub name: &'static str,
    pub aim: Aim,
    /// Judged on software drivers too: what it asks for does not depend on the device.
    pub everywhere: bool,
    pub about: &'static str,
}

const fn of_cards(name: &'static str, aim: Aim, about: &'static str) -> Goal {
    Goal { name, aim, everywhere: false, about }
}

const fn of_all(name: &'static str, aim: Aim, about: &'static str) -> Goal {
    Goal { name, aim, everywhere: true, about }
}

pub const GOALS: &[Goal] = &[
    of_cards("bandwidth", Aim::AtLeast(0.85), "share of the copy's bandwidth: one mark, most vertices"),
    of_all(
        "classic",
        Aim::AtMost(2.5),
        "times as long as the classic kernel with one example: one mark, most vertices",
    ),
    of_all("ten", Aim::AtMost(2.5), "times as long as the classic kernel with one example: ten marks"),
    of_cards("instances", Aim::AtMost(1.3), "100 of 1000 instances, against the same vertices in one"),
    of_all("record one", Aim::Value(5.0), "recording one instance, on the CPU"),
    of_all("record many", Aim::Value(400.0), "recording 1000 instances that all changed, on the CPU"),
    of_all("library", Aim::Value(1.6), "the stripped slim library"),
];

/// The aim of that name.
///
/// # Panics
/// Where there is none.
pub fn goal(name: &str) -> &'static Goal {
    GOALS.iter().find(|g| g.name == name).unwrap_or_else(|| panic!("there is no aim {name:?}"))
}
