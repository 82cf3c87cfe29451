"""Makes the wheel that `pip install .` installs: builds the module by CMake, and packs it with what it loads.

This is a build backend of PEP 517 without dependencies: `pip install .` needs no network."""

import base64
import hashlib
import pathlib
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]


def version() -> str:
    text = (ROOT / "CMakeLists.txt").read_text()
    return text.split("project(cairn VERSION ", 1)[1].split()[0]


def metadata() -> str:
    return (f"Metadata-Version: 2.1\nName: cairn\nVersion: {version()}\n"
            "Summary: Terrain packs: heights and imagery as numpy arrays, and bakes\n"
            "Requires-Python: >=3.11\nRequires-Dist: numpy\n")


def tag() -> str:
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def run(*command):
    if subprocess.run([str(part) for part in command]).returncode:
        sys.exit(f"build_wheel: {command[0]} {command[1]} failed")


def build(folder: pathlib.Path) -> pathlib.Path:
    """Returns the folder with the package, built and stripped."""
    run("cmake", "-S", ROOT, "-B", folder / "build", "-DCMAKE_BUILD_TYPE=Release", "-DCAIRN_PYTHON=ON",
        "-DCAIRN_VIEWER=OFF", "-DCAIRN_TESTS=OFF", "-DCAIRN_GDAL_DRIVER=OFF", f"-DPython3_EXECUTABLE={sys.executable}")
    run("cmake", "--build", folder / "build", "--parallel", "--target", "cairn_python")
    run("cmake", "--install", folder / "build", "--component", "wheel", "--prefix", folder / "wheel", "--strip")
    return folder / "wheel"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    name = f"cairn-{version()}-{tag()}.whl"
    info = f"cairn-{version()}.dist-info"
    with tempfile.TemporaryDirectory() as folder:
        package = build(pathlib.Path(folder))
        files = {str(path.relative_to(package)): path.read_bytes() for path in sorted(package.rglob("*")) if path.is_file()}
    if not any(file.startswith("cairn/_cairn") for file in files):
        sys.exit("build_wheel: expected pybind11 (pybind11-dev), Python's headers and numpy, found not all of them")
    files[f"{info}/METADATA"] = metadata().encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: cairn\nRoot-Is-Purelib: false\nTag: {tag()}\n".encode()
    record = ""
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for file, data in files.items():
            wheel.writestr(file, data)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record += f"{file},sha256={digest},{len(data)}\n"
        wheel.writestr(f"{info}/RECORD", record + f"{info}/RECORD,,\n")
    return name
