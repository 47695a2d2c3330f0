// The plugin's Vulkan path: Crumple's kernels in the stand-in's command buffer, on a real device, under the validation layer.
#include "scene.hpp"

#include "CrumpleSceneProxy.h"
#include "CrumpleVulkan.h"
#include "IVulkanDynamicRHI.h"

#include <thread>

/// A device that rounds as IEEE 754 says gives the CPU's bits, and software drivers do.
static bool shows(Oracle& oracle, UCrumpleComponent& component) {
    return oracle.shows(StandinWorld::Draw(component).Bytes, StandinVulkan::IsSoftware());
}

static bool on_gpu(const UCrumpleComponent& component) {
    return component.SceneProxy && static_cast<const FCrumpleSceneProxy*>(component.SceneProxy)->IsOnGPU();
}

static void dents(UStaticMesh* mesh, UCrumpleSet* set) {
    Scene one(mesh, set, {}, true), two(mesh, set, {}, true);
    Oracle first(set->GetBytes(), *mesh), second(set->GetBytes(), *mesh);
    FACT(shows(first, *one.crumple) && shows(second, *two.crumple));
    FACT(on_gpu(*one.crumple) && on_gpu(*two.crumple));

    // Both are hit in one frame: one recording for both.
    one.settle();
    const uint64 before = StandinVulkan::Finished;
    one.collide({20, 10, 2}, {0, 0, -150}, Scene::ball(0.3f, {}));
    two.collide({-20, 10, -2}, {0, 0, 120}, Scene::ball(0.3f, {}));
    StandinWorld::Frame();
    FlushRenderingCommands();
    first.load(*one.crumple);
    second.load(*two.crumple);
    const uint64 recordings = StandinVulkan::Finished - before;
    FACT(recordings == 1 || recordings == 2); // two where the RHI thread was faster than the render thread
    FACT(shows(first, *one.crumple) && shows(second, *two.crumple));

    // Frames without hits record nothing.
    const uint64 quiet = StandinVulkan::Finished;
    for (int frame = 0; frame < 5; ++frame) StandinWorld::Frame();
    FlushRenderingCommands();
    FACT(StandinVulkan::Finished == quiet);

    // Many frames without waiting, three of them in flight.
    for (int frame = 0; frame < 40; ++frame) {
        const FVector place(-40 + 2 * frame, 30 - frame, 0.1 * (-40 + 2 * frame));
        FACT(one.crumple->SubmitImpulse(place, {0, 0, -40}));
        first.hit({float(place.X / 100), float(place.Z / 100), float(place.Y / 100)}, {0, -0.4f, 0});
        StandinWorld::Frame();
    }
    FACT(shows(first, *one.crumple));

    // A proxy made anew, with the old one's frames in flight: another buffer, the same damage.
    FACT(one.crumple->SubmitImpulse({0, 0, 0}, {0, 0, -100}));
    first.hit({0, 0, 0}, {0, -1, 0});
    StandinWorld::Frame();
    one.crumple->MarkRenderStateDirty();
    FACT(shows(first, *one.crumple) && on_gpu(*one.crumple));
    FACT(one.crumple->ResetDamage());
    FACT(crumple_instance_reset_damage(first.context, first.instance) == CRUMPLE_OK);
    FACT(shows(first, *one.crumple));

    // Gone with frames in flight; the other stays as it is.
    FACT(one.crumple->SubmitImpulse({0, 0, 0}, {0, 0, -100}));
    StandinWorld::Frame();
    one.crumple->DestroyComponent();
    one.actor->Destroy();
    StandinWorld::Frame();
    FACT(shows(second, *two.crumple));

    // Gone in the callback of a hit, before its frame was recorded.
    two.crumple->OnDented.StandinAdd([](UCrumpleComponent* by, FVector, float) { by->GetOwner()->Destroy(); });
    two.collide({0, 0, 0}, {0, 0, -100}, Scene::ball(0.3f, {}));
    for (int frame = 0; frame < 4; ++frame) StandinWorld::Frame();
    FlushRenderingCommands();
    FACT(!two.crumple->IsWorking());
}

static void hits_from_threads(UStaticMesh* mesh, UCrumpleSet* set) {
    Scene scene(mesh, set, {}, true);
    Oracle oracle(set->GetBytes(), *mesh);
    const auto submit = scene.crumple->MakeSubmitter();
    std::vector<std::thread> physics;
    for (int t = 0; t < 3; ++t)
        physics.emplace_back([&, t] {
            for (int h = 0; h < 15; ++h) FACT(submit(FVector(-20 + 20 * t, -42 + 6 * h, 0.1 * (-20 + 20 * t)), {0, 0, -80}));
        });
    for (int frame = 0; frame < 20; ++frame) StandinWorld::Frame();
    for (std::thread& each : physics) each.join();
    for (int t = 0; t < 3; ++t)
        for (int h = 0; h < 15; ++h) {
            const double x = -20 + 20 * t, y = -42 + 6 * h;
            oracle.hit({float(x / 100), float(0.1 * x / 100), float(y / 100)}, {0, -0.8f, 0});
        }
    FACT(shows(oracle, *scene.crumple));
    scene.actor->Destroy();
}

static void a_hood(const char* path) {
    UCrumpleSet* set = UCrumpleSet::LoadCrumpleSet(FString(StandinWiden(path)));
    FACT(set);
    const Hood hood(set->GetBytes());
    UStaticMesh* mesh = import(hood.mesh);
    Scene scene(mesh, set, {}, true);
    Oracle oracle(set->GetBytes(), *mesh);
    FACT(shows(oracle, *scene.crumple) && on_gpu(*scene.crumple));
    for (size_t v : {hood.mesh.positions.size() / 2, hood.mesh.positions.size() / 3}) {
        const FVector3f at = to_unreal(hood.mesh.positions[v], 100);
        FACT(scene.crumple->SubmitImpulse(FVector(at), {0, 0, -100}));
        oracle.hit({float(double(at.X) / 100), float(double(at.Z) / 100), float(double(at.Y) / 100)}, {0, -1, 0});
    }
    FACT(shows(oracle, *scene.crumple));
    scene.actor->Destroy();
}

/// Where the RHI does not tell where a buffer lies, the CPU does the work, through the same buffer.
static void without_a_place(UStaticMesh* mesh, UCrumpleSet* set) {
    StandinVulkan::bTells = false;
    StandinTakeLog();
    Scene scene(mesh, set, {}, true);
    Oracle oracle(set->GetBytes(), *mesh);
    FACT(scene.crumple->SubmitImpulse({10, 0, 1}, {0, 0, -100}));
    oracle.hit({0.1f, 0.01f, 0}, {0, -1, 0});
    FACT(oracle.shows(StandinWorld::Draw(*scene.crumple).Bytes) && !on_gpu(*scene.crumple));
    FACT(said(StandinTakeLog(), TEXT("made on the CPU: the RHI does not tell where the vertex buffer lies")));
    scene.actor->Destroy();
    StandinVulkan::bTells = true;
}

int main(int, char** arguments) {
    const StandinThreads threads;
    const StandinVulkan vulkan;
    const Mesh sheet = make_sheet();
    UStaticMesh* mesh = import(sheet);
    UCrumpleSet* set = asset(make_set(sheet));
    {
        const Module module;
        dents(mesh, set);
        hits_from_threads(mesh, set);
        a_hood(arguments[1]);
        without_a_place(mesh, set);
        FlushRenderingCommands();
        for (const StandinMessage& each : StandinTakeLog()) FACT(each.Verbosity >= StandinVerbosity::Log);

        // The engine exits while a body plays and its frames are in flight, and later unloads the module.
        Scene last(mesh, set, {}, true);
        for (int frame = 0; frame < 3; ++frame) {
            FACT(last.crumple->SubmitImpulse({0, 0, 0}, {0, 0, -100}));
            StandinWorld::Frame();
        }
        FCoreDelegates::OnEnginePreExit.Broadcast();
        FACT(last.crumple->SubmitImpulse({0, 0, 0}, {0, 0, -100}));
        for (int frame = 0; frame < 3; ++frame) StandinWorld::Frame();
        last.actor->Destroy();
        FlushRenderingCommands();
    }
    {
        // Loaded again, as an editor does.
        const Module module;
        Scene again(mesh, set, {}, true);
        Oracle oracle(set->GetBytes(), *mesh);
        FACT(shows(oracle, *again.crumple) && on_gpu(*again.crumple));
        again.actor->Destroy();
        FlushRenderingCommands();
        // This time nobody told it that the engine exits.
    }
    FlushRenderingCommands();
    FACT(StandinVulkan::SpareIsUntouched());
    for (const StandinMessage& each : StandinTakeLog()) FACT(each.Verbosity >= StandinVerbosity::Log);
    std::printf("the plugin's Vulkan path: as crumple_context_deform() writes it\n");
    return 0;
}
