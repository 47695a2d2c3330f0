// The module of Windows, where the library is loaded as it starts, and is not there.
#include "scene.hpp"

int main() {
    setenv("STANDIN_CONTENT", "/nonexistent", 1);
    const StandinThreads threads;
    const Module module;
    const auto log = StandinTakeLog();
    FACT(log.size() == 1 && log[0].Verbosity == StandinVerbosity::Error);
    FACT(said(log, TEXT("the Crumple library cannot be loaded from /nonexistent/Binaries/ThirdParty/CrumpleLibrary/Win64/crumple.dll")));

    const Mesh sheet = make_sheet();
    Scene scene(import(sheet), asset(make_set(sheet)));
    FACT(!scene.crumple->IsWorking() && scene.target->bStandinVisible && !scene.target->bStandinNotifies);
    FACT(scene.crumple->LastError.Contains(TEXT("the Crumple library cannot be loaded from /nonexistent/")));
    FACT(said(StandinTakeLog(), TEXT("Panel: the Crumple library cannot be loaded")));
    FACT(!scene.crumple->SubmitImpulse({0, 0, 0}, {0, 0, -200}));
    TArray<uint8> damage;
    FACT(!scene.crumple->SaveDamage(damage) && !scene.crumple->Repair(0));
    StandinWorld::Frame();
    FACT(!scene.crumple->SceneProxy);
    scene.actor->Destroy();
    return 0;
}
