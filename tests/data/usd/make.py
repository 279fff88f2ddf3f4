"""Makes the binary layer and the archive of room.usda, in a Python with `usd-core`: make.py in this folder."""

from pathlib import Path

from pxr import Sdf, UsdUtils

folder = Path(__file__).parent
binary = folder / "room.usdc"
# A layer keeps the relative path of its image; a stage would write that of this machine.
assert Sdf.Layer.FindOrOpen(str(folder / "room.usda")).Export(str(binary))
assert UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(binary)), str(folder / "room.usdz"))
