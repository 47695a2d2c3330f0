#pragma once

#include "Misc/EngineVersionComparison.h"

/** Whether the engine is of version 5.Minor or later. */
#define CRUMPLE_ENGINE_AT_LEAST(Minor) (!UE_VERSION_OLDER_THAN(5, Minor, 0))
