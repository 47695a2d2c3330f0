"""The wheel contains a shared library and a program, so it is for one platform; any Python of that platform can use it."""

from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.bdist_wheel import bdist_wheel


class Binary(Distribution):
    def has_ext_modules(self) -> bool:
        return True


class PlatformWheel(bdist_wheel):
    def run(self) -> None:
        if not any((Path(__file__).parent / "src/crumple/_bin").glob("*crumple*")):
            raise SystemExit("src/crumple/_bin is empty; `cargo xtask wheel` builds what belongs there and then the wheel")
        super().run()

    def get_tag(self) -> tuple[str, str, str]:
        return "py3", "none", super().get_tag()[2]


setup(distclass=Binary, cmdclass={"bdist_wheel": PlatformWheel})
