//! Rapier, a real engine: what its contacts leave, and what lands on colliders that follow.

#[path = "../../src/peers/rapier_contacts.rs"]
mod rapier_contacts;
#[path = "../../../tests/scenes/mod.rs"]
mod scenes;

mod collider;
mod contacts;
