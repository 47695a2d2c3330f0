# Compiles a project with the address and undefined behaviour sanitizers of gcc or clang. Any project of this repository takes it:
#
#   cmake -S tests/c -B build -DCMAKE_PREFIX_PATH=/where/it/is -DCMAKE_PROJECT_INCLUDE=$PWD/tests/c/sanitizers.cmake
set(CRUMPLE_SANITIZE ON)

# Every program gets its own `dlclose`; sanitizers.c says why.
add_library(crumple_sanitizers OBJECT "${CMAKE_CURRENT_LIST_DIR}/sanitizers.c")
target_compile_options(crumple_sanitizers PRIVATE -std=c11)

# Half the time of -O2 to compile.
set(CMAKE_C_FLAGS_RELWITHDEBINFO "-O1 -g1 -DNDEBUG")
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O1 -g1 -DNDEBUG")
add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
add_link_options(-fsanitize=address,undefined)
link_libraries("$<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:$<TARGET_OBJECTS:crumple_sanitizers>>")
