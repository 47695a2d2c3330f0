// Stand-ins for what the plugin uses of Unreal's Core and CoreUObject: names and signatures after Epic's public API reference
// (dev.epicgames.com, API/Runtime/Core and CoreUObject, 5.3 to 5.5), bodies of our own that do just enough to run the plugin's code.
// This is no Unreal: what compiles and runs here was never compiled or run there.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

using int32 = std::int32_t;
using uint8 = std::uint8_t;
using uint32 = std::uint32_t;
using uint64 = std::uint64_t;
using SIZE_T = std::size_t;
using TCHAR = wchar_t;

#define TEXT(Literal) L##Literal
#define MAX_uint64 UINT64_MAX
#define CRUMPLE_API
#ifndef WITH_EDITOR
#define WITH_EDITOR 0
#endif

// What Unreal's header tool reads.
#define UCLASS(...)
#define UENUM(...)
#define UPROPERTY(...)
#define UFUNCTION(...)

#define check(Condition) \
	do \
	{ \
		if (!(Condition)) \
		{ \
			std::fprintf(stderr, "%s:%d: check(%s)\n", __FILE__, __LINE__, #Condition); \
			std::abort(); \
		} \
	} while (false)

template <typename T>
using TFunction = std::function<T>;

enum EForceInit
{
	ForceInit
};

template <typename T>
std::remove_reference_t<T>&& MoveTemp(T&& Value)
{
	return static_cast<std::remove_reference_t<T>&&>(Value);
}

template <typename T>
void Swap(T& A, T& B)
{
	std::swap(A, B);
}

template <typename T>
struct TNumericLimits
{
	static constexpr T Max() { return std::numeric_limits<T>::max(); }
};

inline uint64 GFrameCounter = 0;

struct FMath
{
	template <typename T>
	static T Min(T A, T B) { return A < B ? A : B; }
	template <typename T>
	static T Max(T A, T B) { return A < B ? B : A; }
	static float Sqrt(float Value) { return std::sqrt(Value); }
	static double Sqrt(double Value) { return std::sqrt(Value); }
	template <typename T>
	static T Square(T Value) { return Value * Value; }
};

struct FMemory
{
	static void* Memcpy(void* To, const void* From, SIZE_T Size) { return Size ? std::memcpy(To, From, Size) : To; }
	static int32 Memcmp(const void* A, const void* B, SIZE_T Size) { return std::memcmp(A, B, Size); }
};

template <typename T>
class TArray
{
public:
	TArray() = default;
	TArray(std::initializer_list<T> Values) : All(Values) {}

	int32 Num() const { return static_cast<int32>(All.size()); }
	T* GetData() { return All.data(); }
	const T* GetData() const { return All.data(); }
	T& operator[](int32 Index) { return All.at(static_cast<SIZE_T>(Index)); }
	const T& operator[](int32 Index) const { return All.at(static_cast<SIZE_T>(Index)); }
	int32 Add(T Value)
	{
		All.push_back(std::move(Value));
		return Num() - 1;
	}
	T Pop()
	{
		T Last = std::move(All.back());
		All.pop_back();
		return Last;
	}
	void Empty() { All.clear(); }
	void SetNum(int32 Count) { All.resize(static_cast<SIZE_T>(Count)); }
	void SetNumZeroed(int32 Count) { All.assign(static_cast<SIZE_T>(Count), T{}); }
	void SetNumUninitialized(int32 Count) { All.resize(static_cast<SIZE_T>(Count)); }
	void RemoveAt(int32 Index) { All.erase(All.begin() + Index); }
	template <typename PredicateType>
	int32 RemoveAll(PredicateType Predicate)
	{
		const int32 Before = Num();
		// Each element is asked once, in order.
		std::vector<T> Kept;
		for (T& Each : All)
		{
			if (!Predicate(Each))
			{
				Kept.push_back(std::move(Each));
			}
		}
		All = std::move(Kept);
		return Before - Num();
	}
	template <typename PredicateType>
	T* FindByPredicate(PredicateType Predicate)
	{
		const auto Found = std::find_if(All.begin(), All.end(), Predicate);
		return Found == All.end() ? nullptr : &*Found;
	}
	bool operator==(const TArray& Other) const { return All == Other.All; }
	auto begin() { return All.begin(); }
	auto end() { return All.end(); }
	auto begin() const { return All.begin(); }
	auto end() const { return All.end(); }

private:
	std::vector<T> All;
};

class FString
{
public:
	FString() = default;
	FString(const TCHAR* Value) : Text(Value) {}
	FString(std::wstring Value) : Text(std::move(Value)) {}
	const TCHAR* operator*() const { return Text.c_str(); }
	bool IsEmpty() const { return Text.empty(); }
	FString& operator+=(const FString& Other)
	{
		Text += Other.Text;
		return *this;
	}
	bool operator==(const FString& Other) const { return Text == Other.Text; }
	bool Contains(const TCHAR* Part) const { return Text.find(Part) != std::wstring::npos; }
	static FString Printf(const TCHAR* Format, ...);
	static FString PrintfV(const TCHAR* Format, va_list Arguments);

private:
	std::wstring Text;
};

/** "%s" is a TCHAR string there and a char string in C. */
inline FString FString::PrintfV(const TCHAR* Format, va_list Arguments)
{
	std::wstring Wide;
	for (const TCHAR* At = Format; *At; ++At)
	{
		Wide += *At;
		if (*At == L'%' && At[1] == L's')
		{
			Wide += L'l';
		}
	}
	wchar_t Made[4096];
	const int Length = std::vswprintf(Made, 4096, Wide.c_str(), Arguments);
	check(Length >= 0);
	return FString(Made);
}

inline FString FString::Printf(const TCHAR* Format, ...)
{
	va_list Arguments;
	va_start(Arguments, Format);
	FString Made = PrintfV(Format, Arguments);
	va_end(Arguments);
	return Made;
}

/** ASCII is enough for what is said here. */
inline std::wstring StandinWiden(const char* Text) { return std::wstring(Text, Text + std::strlen(Text)); }
inline std::string StandinNarrow(const TCHAR* Text)
{
	std::string Made;
	for (; *Text; ++Text)
	{
		Made += static_cast<char>(*Text);
	}
	return Made;
}
#define UTF8_TO_TCHAR(Text) StandinWiden(Text).c_str()
#define TCHAR_TO_UTF8(Text) StandinNarrow(Text).c_str()

class FName
{
public:
	FName() = default;
	FName(const TCHAR*) {}
	FName(const char*) {}
};
inline const FName NAME_None;

// Log: kept for the tests to look at.
struct StandinMessage
{
	int32 Verbosity;
	std::wstring Text;
};
namespace StandinVerbosity
{
	enum
	{
		Error = 2,
		Warning = 3,
		Display = 4,
		Log = 5
	};
}
void StandinLog(int32 Verbosity, const TCHAR* Format, ...);
/** All that was said since the last call. */
std::vector<StandinMessage> StandinTakeLog();
#define DECLARE_LOG_CATEGORY_EXTERN(Name, Default, Compiled) extern const int Standin##Name
#define DEFINE_LOG_CATEGORY(Name) const int Standin##Name = 0
#define UE_LOG(Category, Verbosity, Format, ...) \
	((void)Standin##Category, StandinLog(StandinVerbosity::Verbosity, Format __VA_OPT__(, ) __VA_ARGS__))

// Smart pointers.
template <typename T>
class TSharedRef;
template <typename T>
class TSharedPtr
{
public:
	TSharedPtr(std::nullptr_t = nullptr) {}
	TSharedPtr(std::shared_ptr<T> From) : Held(std::move(From)) {}
	TSharedPtr(const TSharedRef<T>& From);
	bool IsValid() const { return Held != nullptr; }
	explicit operator bool() const { return IsValid(); }
	T* operator->() const { return Held.get(); }
	T& operator*() const { return *Held; }
	T* Get() const { return Held.get(); }
	void Reset() { Held.reset(); }
	TSharedRef<T> ToSharedRef() const;
	std::shared_ptr<T> Held;
};
template <typename T>
class TSharedRef
{
public:
	explicit TSharedRef(std::shared_ptr<T> From) : Held(std::move(From)) { check(Held); }
	T* operator->() const { return Held.get(); }
	T& operator*() const { return *Held; }
	T& Get() const { return *Held; }
	std::shared_ptr<T> Held;
};
template <typename T>
TSharedPtr<T>::TSharedPtr(const TSharedRef<T>& From) : Held(From.Held)
{
}
template <typename T>
TSharedRef<T> TSharedPtr<T>::ToSharedRef() const
{
	return TSharedRef<T>(Held);
}
template <typename T>
class TWeakPtr
{
public:
	TWeakPtr(const TSharedPtr<T>& From) : Held(From.Held) {}
	bool IsValid() const { return !Held.expired(); }
	TSharedPtr<T> Pin() const { return TSharedPtr<T>(Held.lock()); }

private:
	std::weak_ptr<T> Held;
};
template <typename T>
class TSharedFromThis : public std::enable_shared_from_this<T>
{
public:
	TSharedRef<T> AsShared() { return TSharedRef<T>(this->shared_from_this()); }
};
template <typename T>
TSharedPtr<T> MakeShareable(T* Pointer)
{
	return TSharedPtr<T>(std::shared_ptr<T>(Pointer));
}
template <typename T, typename... ArgTypes>
TSharedRef<T> MakeShared(ArgTypes&&... Args)
{
	return TSharedRef<T>(std::make_shared<T>(std::forward<ArgTypes>(Args)...));
}
template <typename T>
class TUniquePtr : public std::unique_ptr<T>
{
public:
	using std::unique_ptr<T>::unique_ptr;
	TUniquePtr() = default;
	TUniquePtr(std::unique_ptr<T>&& From) : std::unique_ptr<T>(std::move(From)) {}
	bool IsValid() const { return this->get() != nullptr; }
	void Reset() { this->reset(); }
};
template <typename T, typename... ArgTypes>
TUniquePtr<T> MakeUnique(ArgTypes&&... Args)
{
	return TUniquePtr<T>(std::make_unique<T>(std::forward<ArgTypes>(Args)...));
}

// Locks. Unreal's critical section may be entered again by its thread.
using FCriticalSection = std::recursive_mutex;
class FScopeLock
{
public:
	explicit FScopeLock(FCriticalSection* Section) : Held(*Section) {}

private:
	std::lock_guard<FCriticalSection> Held;
};
using FRWLock = std::shared_mutex;
class FReadScopeLock
{
public:
	explicit FReadScopeLock(FRWLock& Lock) : Held(Lock) {}

private:
	std::shared_lock<FRWLock> Held;
};
class FWriteScopeLock
{
public:
	explicit FWriteScopeLock(FRWLock& Lock) : Held(Lock) {}

private:
	std::unique_lock<FRWLock> Held;
};

// Geometry.
template <typename T>
struct TStandinVector
{
	T X = 0, Y = 0, Z = 0;
	TStandinVector() = default;
	TStandinVector(T InX, T InY, T InZ) : X(InX), Y(InY), Z(InZ) {}
	template <typename U>
	explicit TStandinVector(const TStandinVector<U>& Other) : X(T(Other.X)), Y(T(Other.Y)), Z(T(Other.Z))
	{
	}
	T Size() const { return std::sqrt(X * X + Y * Y + Z * Z); }
	bool IsNearlyZero() const { return Size() < T(1e-4); }
	TStandinVector GetSafeNormal() const
	{
		const T Length = Size();
		return Length * Length < T(1e-8) ? TStandinVector() : TStandinVector(X / Length, Y / Length, Z / Length);
	}
	TStandinVector operator-(const TStandinVector& B) const { return {X - B.X, Y - B.Y, Z - B.Z}; }
	TStandinVector operator+(const TStandinVector& B) const { return {X + B.X, Y + B.Y, Z + B.Z}; }
	TStandinVector operator*(T Factor) const { return {X * Factor, Y * Factor, Z * Factor}; }
	static TStandinVector CrossProduct(const TStandinVector& A, const TStandinVector& B)
	{
		return {A.Y * B.Z - A.Z * B.Y, A.Z * B.X - A.X * B.Z, A.X * B.Y - A.Y * B.X};
	}
	static T DotProduct(const TStandinVector& A, const TStandinVector& B) { return A.X * B.X + A.Y * B.Y + A.Z * B.Z; }
	static T DistSquared(const TStandinVector& A, const TStandinVector& B) { return DotProduct(A - B, A - B); }
	static const TStandinVector ZeroVector;
};
template <typename T>
inline const TStandinVector<T> TStandinVector<T>::ZeroVector;
using FVector = TStandinVector<double>;
using FVector3f = TStandinVector<float>;
struct FVector2f
{
	float X = 0, Y = 0;
	FVector2f() = default;
	FVector2f(float InX, float InY) : X(InX), Y(InY) {}
};
struct FVector4f
{
	float X = 0, Y = 0, Z = 0, W = 0;
	FVector4f() = default;
	FVector4f(float InX, float InY, float InZ, float InW) : X(InX), Y(InY), Z(InZ), W(InW) {}
};
struct FColor
{
	uint8 R = 0, G = 0, B = 0, A = 0;
	static const FColor White;
};
inline const FColor FColor::White{255, 255, 255, 255};

/** For row vectors: [X Y Z 1] * M. */
struct FMatrix
{
	double M[4][4];
	explicit FMatrix(EForceInit) : M{} {}
	FMatrix operator*(const FMatrix& Other) const
	{
		FMatrix Made(ForceInit);
		for (int Row = 0; Row < 4; ++Row)
			for (int Column = 0; Column < 4; ++Column)
				for (int Each = 0; Each < 4; ++Each) Made.M[Row][Column] += M[Row][Each] * Other.M[Each][Column];
		return Made;
	}
	FVector Transform(const FVector& V, double W) const
	{
		double Out[3];
		for (int Column = 0; Column < 3; ++Column)
			Out[Column] = V.X * M[0][Column] + V.Y * M[1][Column] + V.Z * M[2][Column] + W * M[3][Column];
		return {Out[0], Out[1], Out[2]};
	}
	FVector TransformPosition(const FVector& V) const { return Transform(V, 1); }
	FVector TransformVector(const FVector& V) const { return Transform(V, 0); }
	double Determinant() const
	{
		const auto Row = [&](int R) { return FVector(M[R][0], M[R][1], M[R][2]); };
		return FVector::DotProduct(FVector::CrossProduct(Row(0), Row(1)), Row(2));
	}
};

/** Scale, then a turn about Z, then translation: what the tests need of a quaternion. */
struct FTransform
{
	FVector Scale{1, 1, 1}, Translation;
	double Yaw = 0;  // radians
	FMatrix ToMatrixWithScale() const
	{
		FMatrix Made(ForceInit);
		const double C = std::cos(Yaw), S = std::sin(Yaw);
		Made.M[0][0] = Scale.X * C, Made.M[0][1] = Scale.X * S;
		Made.M[1][0] = -Scale.Y * S, Made.M[1][1] = Scale.Y * C;
		Made.M[2][2] = Scale.Z, Made.M[3][3] = 1;
		Made.M[3][0] = Translation.X, Made.M[3][1] = Translation.Y, Made.M[3][2] = Translation.Z;
		return Made;
	}
	FVector Unturn(const FVector& V) const
	{
		const double C = std::cos(Yaw), S = std::sin(Yaw);
		return {V.X * C + V.Y * S, -V.X * S + V.Y * C, V.Z};
	}
	FVector InverseTransformPosition(const FVector& V) const
	{
		const FVector Turned = Unturn(V - Translation);
		return {Turned.X / Scale.X, Turned.Y / Scale.Y, Turned.Z / Scale.Z};
	}
	FVector InverseTransformVectorNoScale(const FVector& V) const { return Unturn(V); }
};
struct FBox
{
	FVector Min, Max;
	bool bValid = false;
	explicit FBox(EForceInit) {}
	FBox(const FVector& InMin, const FVector& InMax) : Min(InMin), Max(InMax), bValid(true) {}
	FBox& operator+=(const FVector& P)
	{
		Min = bValid ? FVector(std::min(Min.X, P.X), std::min(Min.Y, P.Y), std::min(Min.Z, P.Z)) : P;
		Max = bValid ? FVector(std::max(Max.X, P.X), std::max(Max.Y, P.Y), std::max(Max.Z, P.Z)) : P;
		bValid = true;
		return *this;
	}
};
struct FBoxSphereBounds
{
	FVector Origin, BoxExtent;
	FBoxSphereBounds() = default;
	explicit FBoxSphereBounds(const FBox& Box) : Origin((Box.Min + Box.Max) * 0.5), BoxExtent((Box.Max - Box.Min) * 0.5) {}
	FBoxSphereBounds TransformBy(const FMatrix& Matrix) const
	{
		FBox Box(ForceInit);
		for (int Corner = 0; Corner < 8; ++Corner)
			Box += Matrix.TransformPosition(Origin + FVector(Corner & 1 ? BoxExtent.X : -BoxExtent.X, Corner & 2 ? BoxExtent.Y : -BoxExtent.Y,
																Corner & 4 ? BoxExtent.Z : -BoxExtent.Z));
		return FBoxSphereBounds(Box);
	}
	FBoxSphereBounds TransformBy(const FTransform& Transform) const { return TransformBy(Transform.ToMatrixWithScale()); }
};

// Files, processes, modules.
struct FFileHelper
{
	static bool LoadFileToArray(TArray<uint8>& Result, const TCHAR* Filename);
};
struct FPaths
{
	static bool IsRelative(const FString& Path) { return (*Path)[0] != L'/'; }
	static FString ProjectContentDir();
	static FString Combine(const FString& A, const FString& B) { return FString::Printf(TEXT("%s/%s"), *A, *B); }
	static FString Combine(const FString& A, const TCHAR* B) { return Combine(A, FString(B)); }
};
struct FPlatformProcess
{
	static void* GetDllHandle(const TCHAR* Filename);
};
struct IPlugin
{
	FString GetBaseDir() const;
};
struct IPluginManager
{
	static IPluginManager& Get();
	TSharedPtr<IPlugin> FindPlugin(const FString& Name);
};
struct IModuleInterface
{
	virtual ~IModuleInterface() = default;
	virtual void StartupModule() {}
	virtual void ShutdownModule() {}
};
struct FModuleManager
{
	template <typename T>
	static T& LoadModuleChecked(const FName&)
	{
		return static_cast<T&>(*Loaded);
	}
	static IModuleInterface* Loaded;
	static std::unique_ptr<IModuleInterface> (*Make)();
};
#define IMPLEMENT_MODULE(Type, Name) \
	static const bool bStandin##Name = \
		(FModuleManager::Make = []() -> std::unique_ptr<IModuleInterface> { return std::make_unique<Type>(); }, true);
using FDelegateHandle = int32;
struct FSimpleMulticastDelegate
{
	template <typename T>
	FDelegateHandle AddRaw(T* Object, void (T::*Function)())
	{
		All.push_back({++Newest, [=] { (Object->*Function)(); }});
		return Newest;
	}
	bool Remove(FDelegateHandle Handle) { return std::erase_if(All, [=](const auto& Each) { return Each.first == Handle; }) > 0; }
	void Broadcast() const
	{
		for (const auto& Each : All) Each.second();
	}

private:
	std::vector<std::pair<FDelegateHandle, std::function<void()>>> All;
	FDelegateHandle Newest = 0;
};
struct FCoreDelegates
{
	static FSimpleMulticastDelegate OnEnginePreExit;
};
#define UE_VERSION_OLDER_THAN(Major, Minor, Patch) (5 < (Major) || (5 == (Major) && STANDIN_ENGINE_MINOR < (Minor)))
