//! Crumple as a Godot extension: a resource that holds examples, and a node that shows a dented mesh.

mod body;
mod encode;
mod node;
mod physics;
mod set;
mod share;
mod surfaces;
mod tasks;
mod touches;
mod world;

use godot::prelude::*;

struct CrumpleExtension;

// SAFETY: there is no other entry point, and no class does anything unsafe while it is registered.
#[gdextension]
unsafe impl ExtensionLibrary for CrumpleExtension {
    fn on_stage_deinit(stage: InitStage) {
        if stage == InitStage::Scene {
            tasks::end();
        }
    }
}
