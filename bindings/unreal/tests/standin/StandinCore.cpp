#include "StandinEngine.h"

#include <condition_variable>
#include <deque>
#include <fstream>
#include <iterator>
#include <thread>

#include <dlfcn.h>

// Log.
static std::mutex LogMutex;
static std::vector<StandinMessage> Messages;

void StandinLog(int32 Verbosity, const TCHAR* Format, ...)
{
	va_list Arguments;
	va_start(Arguments, Format);
	const FString Made = FString::PrintfV(Format, Arguments);
	va_end(Arguments);
	const std::lock_guard Lock(LogMutex);
	Messages.push_back({Verbosity, *Made});
	if (std::getenv("STANDIN_LOG"))
	{
		std::fprintf(stderr, "LogCrumple: %ls\n", *Made);
	}
}

std::vector<StandinMessage> StandinTakeLog()
{
	const std::lock_guard Lock(LogMutex);
	return std::exchange(Messages, {});
}

// Files, modules.
bool FFileHelper::LoadFileToArray(TArray<uint8>& Result, const TCHAR* Filename)
{
	std::ifstream File(StandinNarrow(Filename), std::ios::binary);
	if (!File)
	{
		return false;
	}
	const std::string Bytes{std::istreambuf_iterator<char>(File), {}};
	Result.SetNum(static_cast<int32>(Bytes.size()));
	FMemory::Memcpy(Result.GetData(), Bytes.data(), Bytes.size());
	return true;
}

FString FPaths::ProjectContentDir()
{
	return FString(StandinWiden(std::getenv("STANDIN_CONTENT") ? std::getenv("STANDIN_CONTENT") : "."));
}

void* FPlatformProcess::GetDllHandle(const TCHAR* Filename)
{
	// The library that the programs are linked with, unless a test sets where to look.
	return dlopen(std::getenv("STANDIN_CONTENT") ? StandinNarrow(Filename).c_str() : STANDIN_LIBRARY, RTLD_NOW);
}

IPluginManager& IPluginManager::Get()
{
	static IPluginManager Manager;
	return Manager;
}

TSharedPtr<IPlugin> IPluginManager::FindPlugin(const FString&)
{
	return MakeShared<IPlugin>();
}

FString IPlugin::GetBaseDir() const
{
	return FPaths::ProjectContentDir();
}

IModuleInterface* FModuleManager::Loaded = nullptr;
std::unique_ptr<IModuleInterface> (*FModuleManager::Make)() = nullptr;
FSimpleMulticastDelegate FCoreDelegates::OnEnginePreExit;

// Threads.
namespace
{
	/** Runs work in the order in which it came. */
	class Thread
	{
	public:
		Thread() : Runner([this] { Run(); }) {}
		~Thread()
		{
			Push(nullptr);
			Runner.join();
		}
		void Push(std::function<void()> Work)
		{
			const std::lock_guard Lock(Mutex);
			Queue.push_back(std::move(Work));
			Changed.notify_all();
		}
		void Drain()
		{
			std::unique_lock Lock(Mutex);
			Changed.wait(Lock, [this] { return Queue.empty() && !bBusy; });
		}

	private:
		void Run()
		{
			std::unique_lock Lock(Mutex);
			for (;;)
			{
				Changed.wait(Lock, [this] { return !Queue.empty(); });
				const std::function<void()> Work = std::move(Queue.front());
				Queue.pop_front();
				if (!Work)
				{
					return;
				}
				bBusy = true;
				Lock.unlock();
				Work();
				Lock.lock();
				bBusy = false;
				Changed.notify_all();
			}
		}
		std::mutex Mutex;
		std::condition_variable Changed;
		std::deque<std::function<void()>> Queue;
		bool bBusy = false;
		std::thread Runner;
	};

	std::unique_ptr<Thread> RenderThread, RHIThread;
	FRHICommandListImmediate CommandList;
	const std::thread::id GameThread = std::this_thread::get_id();

	/** No graphics at all: buffers are memory. */
	struct FNullRHI : FDynamicRHI
	{
		struct FBuffer : FRHIBuffer
		{
			std::vector<uint8> Bytes;
		};
		ERHIInterfaceType GetInterfaceType() const override { return ERHIInterfaceType::Null; }
		std::shared_ptr<FRHIBuffer> Make(uint32 Size) override
		{
			auto Made = std::make_shared<FBuffer>();
			Made->Bytes.resize(Size, 0xCD);
			return Made;
		}
		void Write(FRHIBuffer& Buffer, const std::vector<uint8>& Bytes) override
		{
			std::copy(Bytes.begin(), Bytes.end(), static_cast<FBuffer&>(Buffer).Bytes.begin());
		}
		std::vector<uint8> Read(FRHIBuffer& Buffer) override { return static_cast<FBuffer&>(Buffer).Bytes; }
	} NullRHI;
}

FDynamicRHI* GDynamicRHI = &NullRHI;

StandinThreads::StandinThreads()
{
	RHIThread = std::make_unique<Thread>();
	RenderThread = std::make_unique<Thread>();
}

StandinThreads::~StandinThreads()
{
	FlushRenderingCommands();
	RenderThread.reset();
	RHIThread.reset();
}

bool IsInGameThread()
{
	return std::this_thread::get_id() == GameThread;
}

void StandinRenderCommand(std::function<void(FRHICommandListImmediate&)> Command)
{
	RenderThread->Push([Command = std::move(Command)] { Command(CommandList); });
}

void FlushRenderingCommands()
{
	check(IsInGameThread());
	RenderThread->Drain();
	RHIThread->Drain();
}

// Command lists.
void FRHICommandListImmediate::Enqueue(std::function<void()> Work)
{
	RHIThread->Push(std::move(Work));
}

void FRHICommandListImmediate::WriteGPUFence(FRHIGPUFence* Fence)
{
	Enqueue([Fence = Fence->StandinShared()] { Fence->Submission = GDynamicRHI->Current(); });
}

bool FRHIGPUFence::Poll() const
{
	return Submission != 0 && GDynamicRHI->IsDone(Submission);
}

void FRHICommandListImmediate::BlockUntilGPUIdle()
{
	Enqueue(
		[]
		{
			GDynamicRHI->Submit();
			GDynamicRHI->WaitIdle();
		});
	RHIThread->Drain();
}

FGPUFenceRHIRef RHICreateGPUFence(const FName&)
{
	return FGPUFenceRHIRef(std::make_shared<FRHIGPUFence>().get());
}

FBufferRHIRef FRHICommandListBase::CreateBuffer(uint32 Size, EBufferUsageFlags, uint32, ERHIAccess, FRHIResourceCreateInfo&)
{
	const std::shared_ptr<FRHIBuffer> Made = GDynamicRHI->Make(Size);
	Made->Size = Size;
	return FBufferRHIRef(Made.get());
}

FBufferRHIRef FRHICommandListBase::CreateIndexBuffer(uint32, uint32 Size, EBufferUsageFlags Usage, FRHIResourceCreateInfo& Info)
{
	return CreateBuffer(Size, Usage, 0, ERHIAccess::VertexOrIndexBuffer, Info);
}

FShaderResourceViewRHIRef FRHICommandListBase::CreateShaderResourceView(FRHIBuffer* Buffer, FRHIViewDesc::FBufferSRV::FInitializer const& ViewDesc)
{
	const auto Made = std::make_shared<FRHIShaderResourceView>();
	Made->Buffer = Buffer;
	Made->View = ViewDesc;
	return FShaderResourceViewRHIRef(Made.get());
}

void* FRHICommandListBase::LockBuffer(FRHIBuffer* Buffer, uint32 Offset, uint32 Size, EResourceLockMode Mode)
{
	check(Offset == 0 && Size <= Buffer->Size && Mode == RLM_WriteOnly && Buffer->Locked.empty());
	Buffer->Locked.resize(Size);
	return Buffer->Locked.data();
}

void FRHICommandListBase::UnlockBuffer(FRHIBuffer* Buffer)
{
	RHIThread->Push([Held = Buffer->StandinShared(), Bytes = std::exchange(Buffer->Locked, {})] { GDynamicRHI->Write(*Held, Bytes); });
}

// Objects.
std::vector<std::unique_ptr<UObject>> UObject::StandinAll;
std::vector<UActorComponent*> StandinWorld::All;
const FAttachmentTransformRules FAttachmentTransformRules::SnapToTargetIncludingScale;

UMaterial* UMaterial::GetDefaultMaterial(EMaterialDomain)
{
	static UMaterial Material;
	return &Material;
}

FPrimitiveSceneProxy::FPrimitiveSceneProxy(const UPrimitiveComponent* Component, FName)
	: StandinLocalToWorld(Component->GetRenderMatrix()), StandinLocalBounds(Component->GetLocalBounds())
{
}

FSceneInterface& FPrimitiveSceneProxy::GetScene() const
{
	static FSceneInterface Scene;
	return Scene;
}

static void RemoveProxy(UPrimitiveComponent& Component)
{
	if (FPrimitiveSceneProxy* Proxy = std::exchange(Component.SceneProxy, nullptr))
	{
		StandinRenderCommand([Proxy](FRHICommandListImmediate&) { delete Proxy; });
	}
}

void UActorComponent::DestroyComponent()
{
	if (!bStandinGarbage)
	{
		if (std::exchange(bStandinPlaying, false))
		{
			EndPlay(EEndPlayReason::Destroyed);
		}
		bStandinGarbage = true;
		if (UPrimitiveComponent* Primitive = Cast<UPrimitiveComponent>(this))
		{
			RemoveProxy(*Primitive);
		}
		std::erase(StandinWorld::All, this);
	}
}

bool AActor::Destroy()
{
	for (UActorComponent* Each : Standin)
	{
		Each->DestroyComponent();
	}
	bStandinGarbage = true;
	return true;
}

void StandinWorld::Play(AActor& Actor, UActorComponent& Component)
{
	Actor.Standin.push_back(&Component);
	Component.StandinOwner = &Actor;
	Component.bStandinPlaying = true;
	All.push_back(&Component);
	Component.BeginPlay();
}

void StandinWorld::Frame(float Seconds, bool bSubmit)
{
	++GFrameCounter;
	for (UActorComponent* Each : std::vector(All))
	{
		if (Each->PrimaryComponentTick.bCanEverTick && Each->bStandinPlaying)
		{
			Each->TickComponent(Seconds, LEVELTICK_All, &Each->PrimaryComponentTick);
		}
	}
	for (UActorComponent* Each : All)
	{
		UPrimitiveComponent* Primitive = Cast<UPrimitiveComponent>(Each);
		if (std::exchange(Each->bStandinStateDirty, false) && Primitive)
		{
			RemoveProxy(*Primitive);
			Primitive->SceneProxy = Primitive->CreateSceneProxy();
			Each->bStandinDataDirty = false;
		}
		if (std::exchange(Each->bStandinDataDirty, false))
		{
			Each->SendRenderDynamicData_Concurrent();
		}
	}
	if (bSubmit)
	{
		StandinRenderCommand([](FRHICommandListImmediate& List) { List.Enqueue([] { GDynamicRHI->Submit(); }); });
	}
}

/** The declared attribute of a vertex, as the input assembler fetches it. */
static FVector4f Fetch(const FVertexStreamComponent& Stream, const std::vector<uint8>& Bytes, uint32 Vertex)
{
	float Values[4] = {0, 0, 0, 1};
	const SIZE_T Count = Stream.Type == VET_Float3 ? 3 : 4;
	const SIZE_T At = Stream.StreamOffset + Stream.Offset + SIZE_T(Vertex) * Stream.Stride;
	check(Stream.Type != VET_None && At + Count * sizeof(float) <= Bytes.size());
	std::memcpy(Values, &Bytes[At], Count * sizeof(float));
	return FVector4f(Values[0], Values[1], Values[2], Values[3]);
}

/** What a shader loads from a typed view. */
static FVector4f Load(const FRHIShaderResourceView& View, const std::vector<uint8>& Bytes, uint32 First, uint32 Floats)
{
	check(View.View.Type == FRHIViewDesc::EBufferType::Typed);
	const uint32 Each = View.View.Format == PF_R32_FLOAT ? 1 : 4;
	check(First + Floats / Each <= View.View.Elements);
	float Values[4] = {0, 0, 0, 1};
	std::memcpy(Values, &Bytes.at(View.View.Offset + First * Each * sizeof(float)), Floats * sizeof(float));
	return FVector4f(Values[0], Values[1], Values[2], Values[3]);
}

static bool Same(const FVector4f& A, const FVector4f& B)
{
	return std::memcmp(&A, &B, sizeof A) == 0;
}

StandinDrawn StandinWorld::Draw(UPrimitiveComponent& Component)
{
	StandinDrawn Drawn;
	// In one command buffer, so that the validation layer sees what is written and read.
	Frame(0, false);
	FPrimitiveSceneProxy* Proxy = Component.SceneProxy;
	if (!Proxy)
	{
		return Drawn;
	}
	FMeshElementCollector Collector;
	std::vector<uint8> Indices;
	StandinRenderCommand(
		[&](FRHICommandListImmediate& List)
		{
			const FSceneView View;
			check(Proxy->GetViewRelevance(&View).bDynamicRelevance);
			Proxy->GetDynamicMeshElements({&View}, FSceneViewFamily(), 1, Collector);
			check(!Collector.StandinAdded.empty());
			List.Enqueue(
				[&]
				{
					const FMeshBatch& First = *Collector.StandinAdded[0];
					const auto& Data = static_cast<const FLocalVertexFactory*>(First.VertexFactory)->StandinData;
					Drawn.Bytes = GDynamicRHI->Read(*Data.PositionComponent.VertexBuffer->VertexBufferRHI);
					Indices = GDynamicRHI->Read(*First.Elements[0].IndexBuffer->IndexBufferRHI);
				});
		});
	FlushRenderingCommands();
	const FMatrix& LocalToWorld = Proxy->StandinLocalToWorld;
	const double Determinant = LocalToWorld.Determinant() < 0 ? -1 : 1;
	const auto& Data = static_cast<const FLocalVertexFactory*>(Collector.StandinAdded[0]->VertexFactory)->StandinData;
	Drawn.TexCoords = Data.StandinTexCoords;
	for (uint32 Vertex = 0; Vertex <= Collector.StandinAdded[0]->Elements[0].MaxVertexIndex; ++Vertex)
	{
		const FVector4f P = Fetch(Data.PositionComponent, Drawn.Bytes, Vertex), T = Fetch(Data.TangentBasisComponents[0], Drawn.Bytes, Vertex),
						N = Fetch(Data.TangentBasisComponents[1], Drawn.Bytes, Vertex);
		// Shaders that fetch by themselves see the same.
		check(Same(P, Load(*Data.PositionComponentSRV, Drawn.Bytes, 3 * Vertex, 3)));
		check(Same(T, Load(*Data.TangentsSRV, Drawn.Bytes, 2 * Vertex, 4)) && Same(N, Load(*Data.TangentsSRV, Drawn.Bytes, 2 * Vertex + 1, 4)));
		StandinVertex Made;
		Made.Position = LocalToWorld.TransformPosition(FVector(P.X, P.Y, P.Z));
		Made.Normal = LocalToWorld.TransformVector(FVector(N.X, N.Y, N.Z)).GetSafeNormal();
		Made.Tangent = LocalToWorld.TransformVector(FVector(T.X, T.Y, T.Z)).GetSafeNormal();
		Made.Bitangent = FVector::CrossProduct(Made.Normal, Made.Tangent) * (N.W * Determinant);
		Drawn.Vertices.push_back(Made);
	}
	for (const FMeshBatch* Batch : Collector.StandinAdded)
	{
		const FMeshBatchElement& Element = Batch->Elements[0];
		for (uint32 Triangle = 0; Triangle < Element.NumPrimitives; ++Triangle)
		{
			StandinDrawn::FTriangle Made;
			Made.Material = Batch->MaterialRenderProxy;
			std::memcpy(Made.Corner, &Indices.at((Element.FirstIndex + 3 * Triangle) * sizeof(uint32)), sizeof Made.Corner);
			if (Batch->ReverseCulling)
			{
				std::swap(Made.Corner[1], Made.Corner[2]);
			}
			Drawn.Triangles.push_back(Made);
		}
	}
	return Drawn;
}
