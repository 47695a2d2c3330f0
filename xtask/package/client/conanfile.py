"""Tests the Conan package: `conan create . --test-folder xtask/package/client`."""

from conan import ConanFile
from conan.tools.cmake import CMake, cmake_layout


class Client(ConanFile):
    settings = "os", "arch", "compiler", "build_type"
    generators = "CMakeToolchain", "CMakeDeps"

    def requirements(self):
        self.requires(self.tested_reference_str)

    def layout(self):
        cmake_layout(self)

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def test(self):
        CMake(self).ctest()
