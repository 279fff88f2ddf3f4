"""Compiled part of the package `lodestar`."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypedDict, final

import numpy as np
import numpy.typing as npt
from typing_extensions import TypeAlias, Unpack

__version__: str

_Path: TypeAlias = str | PathLike[str]
_SceneLike: TypeAlias = Scene | _Path | Mapping[str, Any]
_PictureLike: TypeAlias = Picture | _Path | npt.NDArray[Any]
_Floats: TypeAlias = npt.NDArray[np.float32]
_Doubles: TypeAlias = npt.NDArray[np.float64]
_Counts: TypeAlias = npt.NDArray[np.uint32]
_Tone: TypeAlias = Literal["srgb", "paper", "agx", "filmic", "aces"]

# --- keywords: written from the table of options by tests/test_stubs.py

@final
class _Keywords(TypedDict, total=False):
    scale: float | None
    crop: tuple[int, int, int, int] | None
    rfilter: Literal["box", "tent", "gaussian"] | None
    checkpoint: _Path | None
    checkpoint_every: float | str | None
    noise: float | None
    sampler: Literal["bsdf", "rejection-mix", "rejection", "sphere-inversion", "hemisphere-inversion", "product", "quadtree"] | None
    max_depth: int | None
    rr_depth: int | None
    nee: bool | Literal["on", "off"] | None
    pattern: Literal["independent", "sobol", "blue-noise"] | None
    sample_offset: int | None
    guide_set: Literal["diffuse", "authors", "all"] | None
    learner: Literal["sarsa", "expected-sarsa", "monte-carlo"] | None
    expected_directions: int | None
    mix: Literal["density", "acceptance"] | None
    epsilon: float | None
    bsdf_share: Literal["fixed", "learned"] | None
    light_selection: Literal["power", "learned"] | None
    roulette: Literal["throughput", "contribution"] | None
    map: Literal["equal-area", "cylindrical"] | None
    grid: int | Literal["auto"] | None
    fallback: float | None
    directions: int | None
    normals: int | None
    spp_per_step: int | None
    steps: Literal["growing", "even"] | None
    sample_weights: Literal["even", "growing"] | None
    decay: float | None
    max_tries: int | None
    min_uniform: float | None
    deal_by_speed: bool | None
    slice_ms: float | None
    execution: Literal["auto", "megakernel", "wavefront"] | None
    traversal: Literal["compute", "query", "auto"] | None
    samples_per_dispatch: int | None
    kernel_dir: _Path | None
    validate: bool | None

# --- end of keywords

@final
class _ResumeKeywords(TypedDict, total=False):
    deal_by_speed: bool
    slice_ms: float
    execution: str
    traversal: str
    kernel_dir: _Path
    checkpoint_every: float | str

class Error(Exception): ...

@final
class Scene:
    @property
    def name(self) -> str: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def fingerprint(self) -> str: ...
    @property
    def summary(self) -> dict[str, Any]: ...

@final
class ScalarTransform4f:
    def __new__(cls, matrix: npt.ArrayLike | None = None) -> ScalarTransform4f: ...
    def translate(self, v: npt.ArrayLike) -> ScalarTransform4f: ...
    def scale(self, v: npt.ArrayLike) -> ScalarTransform4f: ...
    def rotate(self, axis: npt.ArrayLike, angle: float) -> ScalarTransform4f: ...
    def look_at(self, origin: npt.ArrayLike, target: npt.ArrayLike, up: npt.ArrayLike) -> ScalarTransform4f: ...
    @property
    def matrix(self) -> _Doubles: ...
    def __matmul__(self, value: ScalarTransform4f, /) -> ScalarTransform4f: ...
    def __rmatmul__(self, value: ScalarTransform4f, /) -> ScalarTransform4f: ...

@final
class Picture:
    @staticmethod
    def read(path: _Path) -> Picture: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def radiance(self) -> _Floats: ...
    @property
    def variance(self) -> _Floats: ...
    @property
    def samples(self) -> _Counts: ...
    @property
    def hits(self) -> _Counts: ...
    @property
    def albedo(self) -> _Floats: ...
    @property
    def normal(self) -> _Floats: ...
    @property
    def depth(self) -> _Floats: ...
    @property
    def alpha(self) -> _Floats: ...
    @property
    def stats(self) -> dict[str, Any] | None: ...
    @property
    def ending(self) -> Literal["samples", "time", "noise", "stopped"] | None: ...
    @property
    def attributes(self) -> dict[str, str]: ...
    def save(self, path: _Path, *, tone: _Tone = "srgb", exposure: float = 0.0, half: bool = False) -> None: ...
    def denoise(
        self,
        *,
        oidn: _Path | None = None,
        device: Literal["cpu", "sycl", "cuda", "hip", "metal"] = "cpu",
    ) -> _Floats: ...
    def png(self, *, tone: _Tone = "srgb", exposure: float = 0.0) -> bytes: ...
    def _repr_png_(self) -> bytes: ...

@final
class Guide:
    @property
    def cells(self) -> _Floats: ...
    @property
    def directions(self) -> _Doubles: ...
    @property
    def radiance(self) -> _Floats: ...
    @property
    def side(self) -> int: ...
    def radiance_at(self, pixel: tuple[int, int]) -> _Floats: ...
    def radiance_at_point(self, position: npt.ArrayLike) -> _Floats: ...
    def surface_at(self, pixel: tuple[int, int]) -> tuple[list[float], list[float]]: ...

@final
class Renderer:
    def __new__(
        cls,
        scene: _SceneLike,
        *,
        camera: str | int | None = None,
        environment: _Path | None = None,
        spp: int | None = None,
        time: float | str | None = None,
        seed: int | None = 0,
        width: int | None = None,
        height: int | None = None,
        device: int | str | Renderer | None = None,
        guide: Guide | _Path | None = None,
        **settings: Unpack[_Keywords],
    ) -> Renderer: ...
    def step(self, samples: int | None = None) -> int: ...
    def run(self, callback: Callable[[Renderer], object] | None = None) -> Picture: ...
    def stop(self) -> None: ...
    def picture(self) -> Picture: ...
    def set_scene(
        self,
        scene: _SceneLike,
        *,
        camera: str | int | None = None,
        environment: _Path | None = None,
    ) -> None: ...
    def set_camera(self, camera: Scene | Mapping[str, Any]) -> None: ...
    def set_size(self, width: int, height: int) -> None: ...
    def checkpoint(self, path: _Path) -> None: ...
    def write_guide(self, path: _Path) -> None: ...
    @property
    def guide(self) -> Guide: ...
    @property
    def samples(self) -> int: ...
    @property
    def seconds(self) -> float: ...
    @property
    def fraction(self) -> float: ...
    @property
    def light_hit_rate(self) -> float: ...
    @property
    def settings(self) -> dict[str, Any]: ...
    @property
    def stats(self) -> dict[str, Any]: ...
    @property
    def device(self) -> str: ...

def load(
    scene: _Path | Mapping[str, Any],
    *,
    camera: str | int | None = None,
    environment: _Path | None = None,
    **defines: object,
) -> Scene: ...
def convert(scene: _Path, output: _Path, *, overwrite: bool = False, **defines: object) -> None: ...
def render(
    scene: _SceneLike,
    *,
    camera: str | int | None = None,
    environment: _Path | None = None,
    spp: int | None = None,
    time: float | str | None = None,
    seed: int | None = 0,
    width: int | None = None,
    height: int | None = None,
    device: int | str | None = None,
    guide: Guide | _Path | None = None,
    callback: Callable[[Renderer], object] | None = None,
    **settings: Unpack[_Keywords],
) -> Picture: ...
def resume(
    checkpoint: _Path,
    *,
    scene: _Path | None = None,
    spp: int | None = None,
    time: float | str | None = None,
    device: int | str | None = None,
    **settings: Unpack[_ResumeKeywords],
) -> Renderer: ...
def compare(picture: _PictureLike, reference: _PictureLike) -> dict[str, float]: ...
def merge(pictures: Sequence[Picture | _Path]) -> Picture: ...
def devices() -> list[dict[str, Any]]: ...
def options() -> list[dict[str, Any]]: ...
def run_command(arguments: Sequence[str | PathLike[str]]) -> int: ...
