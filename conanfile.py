"""Conan recipe: `conan create .` builds Crumple by CMakeLists.txt and needs Rust's cargo in PATH."""

import re
from pathlib import Path

from conan import ConanFile
from conan.tools.cmake import CMake, cmake_layout


class Crumple(ConanFile):
    name = "crumple"
    description = "Example-based dents for games and films: impulses in, deformed vertices out"
    license = "MIT OR Apache-2.0"
    settings = "os", "arch", "compiler", "build_type"
    generators = "CMakeToolchain"
    # Cargo reads the manifests of the whole workspace.
    exports_sources = (
        "CMakeLists.txt", "Cargo.*", "build.rs", "build/*", "cmake/*", "include/*", "src/*", "LICENSE-*", "README.md",
        "lab/Cargo.toml", "lab/src/*", "lab/tests/*", "xtask/Cargo.toml", "xtask/src/*",
    )

    def set_version(self):
        manifest = Path(self.recipe_folder, "Cargo.toml").read_text()
        self.version = re.search(r'^version = "(.+)"', manifest, re.M).group(1)

    def layout(self):
        cmake_layout(self)

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()

    def package_info(self):
        # Programs use the package that Crumple installs: find_package(Crumple), Crumple::crumple or Crumple::crumple_static.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = ["lib/cmake/Crumple"]
