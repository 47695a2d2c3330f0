//! Crumple as a Godot extension: a resource that holds examples, and a node that shows a dented mesh.

mod body;
mod compute;
mod divide;
mod node;
mod physics;
mod set;
mod sight;
mod surfaces;
mod tasks;
mod world;

use godot::classes::Engine;
use godot::prelude::*;

struct CrumpleExtension;

// SAFETY: there is no other entry point, and no class does anything unsafe while it is registered.
#[gdextension]
unsafe impl ExtensionLibrary for CrumpleExtension {
    fn on_stage_init(stage: InitStage) {
        if stage == InitStage::MainLoop && Engine::singleton().is_editor_hint() {
            // godot-rust hands in the documentation of the classes at an earlier stage, where Godot 4.6 loses it.
            // SAFETY: this is the main thread, and the engine is ready.
            unsafe { godot::docs::register() };
        }
    }

    fn on_stage_deinit(stage: InitStage) {
        if stage == InitStage::Scene {
            tasks::end();
        }
    }
}
