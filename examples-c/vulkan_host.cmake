# Helpers for the programs that need Vulkan, here and in tests/c. Call find_package(Vulkan) first.

set(CRUMPLE_VULKAN_DRIVERS "" CACHE STRING
    "Manifests (JSON files) of Vulkan drivers: programs run on each, which must be there. Empty: on what the system has, if any")
option(CRUMPLE_VULKAN_VALIDATION "Run on CRUMPLE_VULKAN_DRIVERS under the Khronos validation layer" ON)

add_library(vulkan_host STATIC "${CMAKE_CURRENT_LIST_DIR}/vulkan_host.c")
target_include_directories(vulkan_host PUBLIC "${CMAKE_CURRENT_LIST_DIR}")
target_link_libraries(vulkan_host PUBLIC Vulkan::Vulkan)

# vulkan_test(NAME COMMAND ARGUMENTS…) adds a test for each driver. {driver} in an argument becomes the driver's name.
# COST makes ctest --parallel start these long tests first.
function(vulkan_test name)
  set(validation 0)
  if(CRUMPLE_VULKAN_VALIDATION)
    set(validation 1)
  endif()
  if(NOT CRUMPLE_VULKAN_DRIVERS)
    string(REPLACE "{driver}" "system" command "${ARGN}")
    add_test(NAME ${name} COMMAND ${command})
    set_tests_properties(${name} PROPERTIES TIMEOUT 600 COST 100 LABELS vulkan SKIP_RETURN_CODE 77)
  endif()
  foreach(manifest IN LISTS CRUMPLE_VULKAN_DRIVERS)
    get_filename_component(driver "${manifest}" NAME_WE)
    string(REPLACE "{driver}" "${driver}" command "${ARGN}")
    add_test(NAME ${name}_${driver} COMMAND ${command})
    set(environment "VK_DRIVER_FILES=${manifest}" CRUMPLE_REQUIRE_GPU=1 CRUMPLE_VALIDATION=${validation}
                    VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT)
    set_tests_properties(${name}_${driver} PROPERTIES TIMEOUT 600 COST 100 LABELS vulkan ENVIRONMENT "${environment}")
  endforeach()
endfunction()
