import os
from collections.abc import Callable, Iterable
from typing import Any, Literal, NamedTuple, TypedDict

import numpy as np
import numpy.typing as npt

__version__: str

_Path = str | os.PathLike[str]
_Bounds = tuple[float, float, float, float]

class Error(RuntimeError): ...
class UsageError(Error, ValueError): ...
class BadDataError(Error, ValueError): ...
class Cancelled(Error): ...

class Heights(NamedTuple):
    metres: npt.NDArray[np.float64]
    level: npt.NDArray[np.int8]
    error_m: npt.NDArray[np.float32]

class Pack:
    @property
    def path(self) -> os.PathLike[str]: ...
    @property
    def info(self) -> dict[str, Any]: ...
    @property
    def tile_size(self) -> int: ...
    @property
    def quantum_m(self) -> float: ...
    @property
    def body(self) -> tuple[str, float, float]: ...
    @property
    def vertical_datum(self) -> str: ...
    @property
    def levels(self) -> tuple[int, int] | None: ...
    @property
    def imagery_levels(self) -> tuple[int, int] | None: ...
    def heights(self, lon: npt.ArrayLike, lat: npt.ArrayLike, *, level: int | None = None) -> Heights: ...
    def tile(
        self, level: int, x: int, y: int, layer: Literal["heights", "imagery"] = "heights"
    ) -> np.ma.MaskedArray[Any, np.dtype[np.float64]] | npt.NDArray[np.uint8]: ...
    def window(
        self, bounds: _Bounds, shape: tuple[int, int], *, level: int | None = None
    ) -> np.ma.MaskedArray[Any, np.dtype[np.float64]]: ...
    def imagery(self, bounds: _Bounds, shape: tuple[int, int], *, level: int | None = None) -> npt.NDArray[np.uint8]: ...

class BakeReport(TypedDict):
    metadata: dict[str, Any]
    within_error_bound: bool
    samples: int
    texels: int
    file_bytes: int
    seconds: float
    threads: int
    resumed: bool

def open(path: _Path) -> Pack: ...
def bake(
    inputs: _Path | Iterable[_Path],
    target: _Path,
    *,
    imagery: _Path | Iterable[_Path] = (),
    level: int | None = None,
    top: int | None = None,
    tile_size: Literal[257, 513] = 513,
    region: _Bounds | None = None,
    max_error_m: float | None = None,
    quantum_m: float | None = None,
    allow_error: bool = False,
    resampling: Literal["smooth", "exact", "cubic", "bilinear", "nearest"] = "smooth",
    void: Literal["fill", "keep"] = "fill",
    datum: Literal["unknown", "egm96", "ellipsoid"] | None = None,
    geoid: _Path | None = None,
    body: str | None = None,
    latitude: str | None = None,
    longitude: str | None = None,
    rqt_tolerance_m: float | None = None,
    texture_format: Literal["bc1", "bc3", "bc7"] = "bc1",
    texture_quality: Literal["fast", "normal", "best"] = "normal",
    imagery_bounds: _Bounds | None = None,
    feather_pixels: float = 0.0,
    memory_mib: int = 1024,
    threads: int = 0,
    resume: bool = False,
    force: bool = False,
    progress: Callable[[str, int, int], bool | None] | None = None,
) -> BakeReport: ...
