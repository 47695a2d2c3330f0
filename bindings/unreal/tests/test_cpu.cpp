// The plugin without a graphics device: units, what it refuses, hits to vertices, damage, threads.
#include "scene.hpp"

#include "CrumpleSpace.h"

#include <thread>

static bool is(const CrumpleVec3& v, float x, float y, float z) { return v.x == x && v.y == y && v.z == z; }
static bool is(const FVector& v, double x, double y, double z) { return (v - FVector(x, y, z)).Size() < 1e-9; }

// 1 m is 100 cm, 1 N s is 100 kg cm/s; which axis is which is written out in CrumpleSet.h.
static void units() {
    const FCrumpleSpace y_up(ECrumpleAxes::YUp), z_up(ECrumpleAxes::ZUp), same(ECrumpleAxes::Same);
    FACT(is(y_up.PointToSet({100, 200, 300}), 1, 3, 2));
    FACT(is(z_up.PointToSet({100, 200, 300}), 1, -2, 3));
    FACT(is(same.PointToSet({100, 200, 300}), 1, 2, 3));
    FACT(is(y_up.PointToUnreal({1, 3, 2}), 100, 200, 300));
    FACT(is(z_up.PointToUnreal({1, -2, 3}), 100, 200, 300));
    FACT(is(y_up.ImpulseToSet({50, 0, -250}), 0.5f, -2.5f, 0));
    FACT(is(y_up.DirectionToSet({0, 0, 1}), 0, 1, 0));
    FACT(is(z_up.DirectionToUnreal({0, 1, 0}), 0, -1, 0));
    // glTF and most files are right-handed, Unreal is not.
    FACT(y_up.Handedness() == -1 && z_up.Handedness() == -1 && same.Handedness() == 1);
    for (const FCrumpleSpace& space : {y_up, z_up, same}) {
        const CrumpleVec3 p{0.25f, -4, 1.5f};
        FACT((space.SetToUnreal().TransformPosition(FVector(p.x, p.y, p.z)) - space.PointToUnreal(p)).Size() < 1e-9);
        FACT(std::fabs(space.SetToUnreal().Determinant() - 1e6 * space.Handedness()) < 1e-3);
        const CrumpleVec3 back = space.PointToSet(space.PointToUnreal(p));
        FACT(is(back, p.x, p.y, p.z));
    }
}

static void versions() {
    FACT(CrumpleVersionProblem(CRUMPLE_VERSION).IsEmpty());
    FACT(CrumpleVersionProblem(CRUMPLE_VERSION + 7).IsEmpty()); // patches fit
    const FString other = CrumpleVersionProblem(CRUMPLE_VERSION + 1000);
    char wanted[64];
    std::snprintf(wanted, sizeof wanted, "is of version %d.%d.%d, and", CRUMPLE_VERSION_MAJOR, CRUMPLE_VERSION_MINOR + 1,
                  CRUMPLE_VERSION_PATCH);
    FACT(other.Contains(StandinWiden(wanted).c_str()));
}

/// What is drawn is the static mesh, moved as the vertices are.
static void draws_as(const StandinDrawn& drawn, const Scene& scene) {
    const auto& lod = scene.target->StandinMesh->Standin->LODResources[0];
    const auto& basis = lod.VertexBuffers.StaticMeshVertexBuffer;
    const FMatrix to_world = scene.target->StandinTransform.ToMatrixWithScale();
    const double hand = to_world.Determinant() < 0 ? -1 : 1;
    const uint32 count = lod.VertexBuffers.PositionVertexBuffer.GetNumVertices();
    FACT(drawn.Vertices.size() == count);
    for (uint32 v = 0; v < count; ++v) {
        const FVector4f n = basis.VertexTangentZ(v), t = basis.VertexTangentX(v);
        const FVector normal = to_world.TransformVector(FVector(n.X, n.Y, n.Z)).GetSafeNormal();
        const FVector tangent = to_world.TransformVector(FVector(t.X, t.Y, t.Z)).GetSafeNormal();
        const StandinVertex& seen = drawn.Vertices[v];
        const FVector at = to_world.TransformPosition(FVector(lod.VertexBuffers.PositionVertexBuffer.VertexPosition(v)));
        FACT((seen.Position - at).Size() < 1e-3);
        FACT((seen.Normal - normal).Size() < 1e-5 && (seen.Tangent - tangent).Size() < 1e-5);
        FACT((seen.Bitangent - FVector::CrossProduct(normal, tangent) * (n.W * hand)).Size() < 1e-5);
        FACT(drawn.TexCoords->GetVertexUV(v, 0).X == float(v) && drawn.TexCoords->GetVertexUV(v, 1).Y == float(v));
    }
    const auto& indices = lod.IndexBuffer.Standin;
    FACT(drawn.Triangles.size() * 3 == size_t(indices.Num()));
    for (size_t t = 0; t < drawn.Triangles.size(); ++t) {
        const uint32* corner = drawn.Triangles[t].Corner;
        const int32 first = int32(3 * t), turned = hand < 0 ? 1 : 0;
        const uint32 wanted[3] = {indices[first], indices[first + 1 + turned], indices[first + 2 - turned]};
        FACT(corner[0] == wanted[0] && corner[1] == wanted[1] && corner[2] == wanted[2]);
        FACT(drawn.Triangles[t].Material == scene.target->GetMaterial(t < drawn.Triangles.size() / 2 ? 0 : 1)->GetRenderProxy());
    }
}

static void draws_and_dents(UStaticMesh* mesh, UCrumpleSet* set) {
    FTransform transform;
    transform.Scale = {2, 2, 2};
    transform.Translation = {1000, -50, 30};
    transform.Yaw = 0.7;
    Scene scene(mesh, set, transform);
    FACT(scene.crumple->IsWorking() && scene.crumple->LastError.IsEmpty());
    FACT(!scene.target->bStandinVisible && scene.target->bStandinNotifies);
    const StandinDrawn rest = StandinWorld::Draw(*scene.crumple);
    draws_as(rest, scene);
    Oracle oracle(set->GetBytes(), *mesh);
    FACT(oracle.shows(rest.Bytes));
    const FBoxSphereBounds local = scene.crumple->GetLocalBounds(), world = scene.crumple->Bounds;
    const FBoxSphereBounds drawn = local.TransformBy(scene.crumple->GetRenderMatrix());
    FACT((drawn.Origin - world.Origin).Size() < 1e-3 && (drawn.BoxExtent - world.BoxExtent).Size() < 1e-3);

    std::vector<float> depths;
    scene.crumple->OnDented.StandinAdd([&](UCrumpleComponent* by, FVector, float depth) {
        FACT(by == scene.crumple);
        depths.push_back(depth);
    });
    scene.settle();
    // 150 kg cm/s = 1.5 N s, by 0.3 kg, so 5 m/s, on the place 20 cm along x and 10 cm along y of the mesh: the file's (0.2, 0.02, 0.1). The
    // actor is twice as large as its mesh. The impulse and the normal may be those of either body.
    const FMatrix to_world = transform.ToMatrixWithScale();
    UPrimitiveComponent* ball = Scene::ball(0.3f, {});
    scene.collide(to_world.TransformPosition({20, 10, 2}), {0, 0, 150}, ball, {0, 0, -1});
    FACT(depths.empty()); // the step has not ended
    StandinWorld::Frame();
    FACT(depths.size() == 1 && std::fabs(depths[0] - 1.5f) < 0.05f); // 1.5 N s * 20 mm / N s = 30 mm, 15 of the mesh
    const StandinDrawn dented = StandinWorld::Draw(*scene.crumple);
    oracle.load(*scene.crumple);
    FACT(oracle.shows(dented.Bytes));
    double most = 0;
    for (size_t v = 0; v < rest.Vertices.size(); ++v) most = std::max(most, (rest.Vertices[v].Position - dented.Vertices[v].Position).Z);
    FACT(most > 2.7 && most < 3.3);

    // What the ball does in the next steps, it does at the speed that it had after the step before: resting dents nothing.
    for (int step = 0; step < 100; ++step) {
        scene.collide(to_world.TransformPosition({20, 10, 2}), {0, 0, -50}, ball);
        StandinWorld::Frame();
    }
    FACT(depths.size() == 1 && StandinWorld::Draw(*scene.crumple).Bytes == dented.Bytes);
    // It is still coming after a step: the dent grows, and is one.
    for (int step = 0; step < 8; ++step) StandinWorld::Frame();
    ball->StandinVelocity = {0, 0, -400};
    for (int step = 0; step < 2; ++step) {
        scene.collide(to_world.TransformPosition({-20, 10, -2}), {0, 0, -60}, ball);
        StandinWorld::Frame();
    }
    FACT(depths.size() == 3);
    CrumpleInstanceInfo info;
    FACT(crumple_instance_get_info(scene.crumple->GetBody()->Shape->Context->Get(), scene.crumple->GetBody()->Get(), &info) == CRUMPLE_OK);
    FACT(info.mark_count == 2);
    // Weaker by a factor; gone at 0.
    scene.crumple->Gain = 0;
    scene.collide(to_world.TransformPosition({0, 0, 0}), {0, 0, -200});
    StandinWorld::Frame();
    scene.crumple->Gain = 1;
    FACT(depths.size() == 3);
    StandinWorld::Draw(*scene.crumple);
    oracle.load(*scene.crumple);

    // From Blueprint, in world space: turned by the actor's yaw, which the file does not know.
    const double c = std::cos(0.7), s = std::sin(0.7);
    FACT(scene.crumple->SubmitImpulse(to_world.TransformPosition({-30, 0, -3}), {50 * c, 50 * s, -100}));
    oracle.hit({-0.3f, -0.03f, 0}, {0.5f, -1, 0});
    FACT(oracle.shows(StandinWorld::Draw(*scene.crumple).Bytes));

    // A proxy made anew shows what was there.
    scene.crumple->MarkRenderStateDirty();
    FACT(oracle.shows(StandinWorld::Draw(*scene.crumple).Bytes));

    // Swept movement is no hit, nor is a body's weight when it begins to rest: 100 kg do 1633 kg cm/s in a step of 1/60 s.
    scene.collide(to_world.TransformPosition({20, 10, 2}), {0, 0, 0});
    scene.target->StandinMass = 100;
    scene.collide(to_world.TransformPosition({20, 10, 2}), {0, 0, -1700});
    StandinWorld::Frame();
    scene.target->StandinMass = 0;
    FACT(oracle.shows(StandinWorld::Draw(*scene.crumple).Bytes));

    scene.crumple->DestroyComponent();
    FACT(scene.target->bStandinVisible && scene.target->OnComponentHit.StandinNum() == 0);
    scene.actor->Destroy();
}

/// Both components of a pair tell of it: each is hit once, with the whole impulse. Their fronts face each other.
static void two_bodies(UStaticMesh* mesh, UCrumpleSet* set) {
    FTransform turned;
    turned.Scale = {1, 1, -1};
    Scene below(mesh, set), above(mesh, set, turned);
    below.target->StandinMass = above.target->StandinMass = 0.4f;
    std::vector<float> depths;
    for (Scene* each : {&below, &above})
        each->crumple->OnDented.StandinAdd([&](UCrumpleComponent*, FVector, float depth) { depths.push_back(depth); });
    below.settle();
    below.collide({0, 0, 0}, {0, 0, -100}, above.target, {0, 0, 1});
    above.collide({0, 0, 0}, {0, 0, 100}, below.target, {0, 0, 1});
    StandinWorld::Frame();
    FACT(depths.size() == 2 && std::fabs(depths[0] - 2) < 0.05f && depths[0] == depths[1]);
    below.actor->Destroy();
    above.actor->Destroy();
}

/// The lowest of ten, of 10 kg each, bears as much in a step of 1/60 s as if it alone came at 1.6 m/s.
static void a_stack_that_stands(UStaticMesh* mesh, UCrumpleSet* set) {
    Scene scene(mesh, set);
    UPrimitiveComponent* lowest = Scene::ball(10, {});
    int dents = 0;
    scene.crumple->OnDented.StandinAdd([&](UCrumpleComponent*, FVector, float) { ++dents; });
    const auto stands = [&] {
        scene.collide({0, 0, 0}, {0, 0, 1635}, lowest);
        StandinWorld::Frame();
    };
    for (int step = 0; step < 30; ++step) stands();
    FACT(dents == 0);
    // Unreal tells nothing of bodies that sleep.
    lowest->bStandinAsleep = true;
    for (int step = 0; step < 60; ++step) StandinWorld::Frame();
    lowest->bStandinAsleep = false;
    for (int step = 0; step < 3; ++step) stands();
    FACT(dents == 0);
    // Once they separated, the same impulse is that of a blow.
    for (int step = 0; step < 30; ++step) StandinWorld::Frame();
    stands();
    FACT(dents == 1);
    scene.actor->Destroy();
}

static void a_mirrored_actor(UStaticMesh* mesh, UCrumpleSet* set) {
    FTransform transform;
    transform.Scale = {-1, 1, 1};
    Scene scene(mesh, set, transform);
    draws_as(StandinWorld::Draw(*scene.crumple), scene);
    scene.actor->Destroy();
}

static void damage(UStaticMesh* mesh, UCrumpleSet* set) {
    Scene one(mesh, set), two(mesh, set);
    FACT(one.crumple->GetBody()->Shape->Set.index == two.crumple->GetBody()->Shape->Set.index); // shared
    const std::vector<uint8> rest = StandinWorld::Draw(*one.crumple).Bytes;
    FACT(one.crumple->SubmitImpulse({10, 10, 1}, {0, 0, -200}));
    const std::vector<uint8> dented = StandinWorld::Draw(*one.crumple).Bytes;
    FACT(dented != rest && StandinWorld::Draw(*two.crumple).Bytes == rest);
    TArray<uint8> bytes;
    FACT(one.crumple->SaveDamage(bytes) && bytes.Num() > 32);
    FACT(two.crumple->LoadDamage(bytes) && StandinWorld::Draw(*two.crumple).Bytes == dented);
    FACT(one.crumple->Repair(0.5f));
    const std::vector<uint8> half = StandinWorld::Draw(*one.crumple).Bytes;
    FACT(half != dented && half != rest);
    FACT(one.crumple->ResetDamage() && StandinWorld::Draw(*one.crumple).Bytes == rest);

    StandinTakeLog();
    FACT(!two.crumple->Repair(1.5f) && two.crumple->LastError.Contains(TEXT("CRUMPLE_ERROR_INVALID_ARGUMENT")));
    bytes.SetNum(bytes.Num() - 1);
    FACT(!two.crumple->LoadDamage(bytes) && two.crumple->LastError.Contains(TEXT("CRUMPLE_ERROR_DAMAGE_MISMATCH")));
    FACT(!two.crumple->SubmitImpulse({0, 0, 5000}, {0, 0, -200}) && two.crumple->LastError.Contains(TEXT("CRUMPLE_ERROR_CONTACT_TOO_FAR")));
    FACT(said(StandinTakeLog(), TEXT("Panel: crumple_instance_submit_hit")));
    FACT(StandinWorld::Draw(*two.crumple).Bytes == dented);
    one.actor->Destroy();
    FACT(StandinWorld::Draw(*two.crumple).Bytes == dented);
    two.actor->Destroy();
    FACT(!two.crumple->SubmitImpulse({0, 0, 0}, {0, 0, -200}));
}

static void gone_in_a_callback(UStaticMesh* mesh, UCrumpleSet* set) {
    Scene scene(mesh, set);
    StandinWorld::Draw(*scene.crumple);
    const TSharedPtr<FCrumpleBody> body = scene.crumple->GetBody();
    int calls = 0;
    scene.crumple->OnDented.StandinAdd([&](UCrumpleComponent* by, FVector, float) {
        ++calls;
        by->DestroyComponent();
    });
    scene.settle();
    scene.collide({0, 0, 0}, {0, 0, -200}, Scene::ball(0.4f, {}));
    StandinWorld::Frame();
    scene.collide({0, 0, 0}, {0, 0, -200}, Scene::ball(0.4f, {})); // nobody listens any more
    StandinWorld::Frame();
    FACT(calls == 1 && !scene.crumple->IsWorking() && scene.target->bStandinVisible);
    CrumpleHitResult told;
    FString error;
    FACT(!body->Submit({}, {}, told, error) && error == FString(TEXT("the body is gone")));
    FlushRenderingCommands();
    scene.actor->Destroy();
    for (const StandinMessage& each : StandinTakeLog()) FACT(each.Verbosity >= StandinVerbosity::Log);
}

/// Physics threads hit while the game thread plays frames. The order of hits does not matter, so the damage is known.
static void hits_from_threads(UStaticMesh* mesh, UCrumpleSet* set) {
    Scene scene(mesh, set);
    const auto submit = scene.crumple->MakeSubmitter();
    constexpr int threads = 4, hits = 12;
    const auto place = [](int t, int h) { return FVector(-40 + 20 * t, -45 + 7 * h, 0.1 * (-40 + 20 * t)); };
    std::atomic<int> done{0};
    std::vector<std::thread> physics;
    for (int t = 0; t < threads; ++t)
        physics.emplace_back([&, t] {
            for (int h = 0; h < hits; ++h)
                if (submit(place(t, h), {0, 0, -100})) ++done;
        });
    for (int frame = 0; frame < 30; ++frame) StandinWorld::Frame();
    for (std::thread& each : physics) each.join();
    FACT(done == threads * hits);
    Oracle oracle(set->GetBytes(), *mesh);
    for (int t = 0; t < threads; ++t)
        for (int h = 0; h < hits; ++h) {
            const FVector p = place(t, h);
            oracle.hit({float(p.X / 100), float(p.Z / 100), float(p.Y / 100)}, {0, -1, 0});
        }
    FACT(oracle.shows(StandinWorld::Draw(*scene.crumple).Bytes));

    // The component goes while they hit: they are told so, and nothing is touched.
    physics.clear();
    physics.emplace_back([&] {
        while (submit({0, 0, 0}, {0, 0, -10})) std::this_thread::yield();
    });
    scene.actor->Destroy();
    physics[0].join();
    FACT(!submit({0, 0, 0}, {0, 0, -10}));
}

static void what_does_not_fit(UStaticMesh* mesh, UCrumpleSet* set, const Mesh& sheet) {
    const auto refused = [&](UStaticMesh* with, UCrumpleSet* by, const TCHAR* why) {
        Scene scene(with, by);
        StandinWorld::Frame();
        FACT(!scene.crumple->IsWorking() && scene.target->bStandinVisible && !scene.crumple->SceneProxy);
        const bool told = scene.crumple->LastError.Contains(why);
        if (!told) std::fprintf(stderr, "%ls\n", *scene.crumple->LastError);
        FACT(told && said(StandinTakeLog(), why));
        scene.actor->Destroy();
    };
    refused(nullptr, set, TEXT("the static mesh component has no static mesh"));
    refused(mesh, nullptr, TEXT("choose a Set"));
    refused(mesh, asset({}), TEXT("SheetSet is empty: choose its File and press Import"));
    refused(mesh, asset({1, 2, 3, 4, 5}), TEXT("SheetSet: crumple_example_set_load_baked_memory"));
    TArray<uint8> cut = set->GetBytes();
    cut.SetNum(cut.Num() / 2);
    refused(mesh, asset(cut), TEXT("CRUMPLE_ERROR_FORMAT"));

    UCrumpleSet* turned = asset(set->GetBytes());
    turned->Axes = ECrumpleAxes::ZUp;
    refused(mesh, turned, TEXT("; set Axes to YUp"));
    Mesh other = sheet;
    for (CrumpleVec3& p : other.positions) p.y += 0.2f * p.x * p.x;
    refused(import(other), set, TEXT("Sheet does not lie on the set's surface, up to 0.014 m; with axes YUp vertex "));

    mesh->bAllowCPUAccess = false;
    refused(mesh, set, TEXT("Sheet: tick Allow CPU Access"));
    mesh->bAllowCPUAccess = true;
    UStaticMesh* empty = NewObject<UStaticMesh>();
    refused(empty, set, TEXT("has no render data"));

    AActor* actor = NewObject<AActor>();
    UCrumpleComponent* alone = NewObject<UCrumpleComponent>();
    alone->Set = set;
    StandinWorld::Play(*actor, *alone);
    FACT(alone->LastError == FString(TEXT("the actor has no static mesh component to dent")));
    actor->Destroy();

    actor = NewObject<AActor>();
    UStaticMeshComponent* below = NewObject<UStaticMeshComponent>();
    UCrumpleComponent* root = NewObject<UCrumpleComponent>();
    below->StandinMesh = mesh;
    below->StandinParent = root;
    root->Set = set;
    StandinWorld::Play(*actor, *below);
    StandinWorld::Play(*actor, *root);
    FACT(!root->IsWorking() && below->bStandinVisible);
    FACT(root->LastError == FString(TEXT("the component must not be above the static mesh component; put it below")));
    actor->Destroy();
    FACT(!UCrumpleSet::LoadCrumpleSet(TEXT("/nonexistent.glb")) && said(StandinTakeLog(), TEXT("/nonexistent.glb cannot be read")));
}

static void a_hood(const char* path) {
    UCrumpleSet* set = UCrumpleSet::LoadCrumpleSet(FString(StandinWiden(path)));
    FACT(set && set->GetBytes().Num() > 0);
    const Hood hood(set->GetBytes());
    UStaticMesh* mesh = import(hood.mesh);
    Scene scene(mesh, set);
    if (!scene.crumple->IsWorking()) std::fprintf(stderr, "%ls\n", *scene.crumple->LastError);
    FACT(scene.crumple->IsWorking());
    Oracle oracle(set->GetBytes(), *mesh);
    FACT(oracle.shows(StandinWorld::Draw(*scene.crumple).Bytes));
    const CrumpleVec3 p = hood.mesh.positions[hood.mesh.positions.size() / 2];
    const FVector3f at = to_unreal(p, 100);
    FACT(scene.crumple->SubmitImpulse(FVector(at), {0, 0, -100}));
    oracle.hit({float(double(at.X) / 100), float(double(at.Z) / 100), float(double(at.Y) / 100)}, {0, -1, 0});
    FACT(oracle.shows(StandinWorld::Draw(*scene.crumple).Bytes));
    scene.actor->Destroy();
}

int main(int count, char** arguments) {
    units();
    versions();
    const StandinThreads threads;
    {
        const Module module;
        const Mesh sheet = make_sheet();
        UStaticMesh* mesh = import(sheet);
        UCrumpleSet* set = asset(make_set(sheet));
        draws_and_dents(mesh, set);
        // Without a device the CPU does it, and nobody is told twice.
        two_bodies(mesh, set);
        a_stack_that_stands(mesh, set);
        a_mirrored_actor(mesh, set);
        damage(mesh, set);
        gone_in_a_callback(mesh, set);
        hits_from_threads(mesh, set);
        what_does_not_fit(mesh, set, sheet);
        if (count > 1) a_hood(arguments[1]);
        // A game that asks for the GPU and has none.
        StandinTakeLog();
        Scene one(mesh, set, {}, true), two(mesh, set, {}, true);
        StandinWorld::Draw(*one.crumple);
        StandinWorld::Draw(*two.crumple);
        int told = 0;
        for (const StandinMessage& each : StandinTakeLog()) told += each.Text.find(L"Dents are made on the CPU") == 0;
        FACT(told == 1);
        // The level ends with both in it.
        FCoreDelegates::OnEnginePreExit.Broadcast();
        one.actor->Destroy();
        two.actor->Destroy();
        FlushRenderingCommands();
    }
    std::printf("the plugin's CPU path: as crumple_context_deform() writes it, to the bit\n");
    return 0;
}
