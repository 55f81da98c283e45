"""Times other programs that find hours of sun beside `adumbra sun-hours`: one scene, one day, the same points.

    python benches/sun_peers.py ADUMBRA box-city-5k.glb

ADUMBRA is the program. The scene has Y up, north at -Z and metres, and stands on flat ground; delft.glb does, too.
What is needed: `pip install numpy pandas pvlib trimesh embreex shapely`. Those below are timed if they are there, and named if absent:

    pip install pybdshadow          shadows of extruded footprints on flat ground; brings geopandas and pyproj
    pip install umep                the shadow generator of UMEP, over a raster of heights
    pip install solweig             the same shadows, written in Rust
    apt install grass-core          r.sun of GRASS GIS, over a raster of heights

Points are the cells of a square grid whose highest surface is the ground. The reference is `sun-hours`, which is exact.
pvlib's suns with Embree's rays check it, and share no code with it. UMEP and solweig get pvlib's suns, too; r.sun and pybdshadow find
their own, and Embree's rays to suncalc's suns, which are those of pybdshadow, show what the suns alone do. Errors are the absolute
differences from the reference, in hours.

Rasters have the highest surface below the middle of each cell, by rays. Footprints are the plans of roofs, the upward triangles of each
connected piece in classes of a metre, each as high as its mean, and courtyards are filled. Both reach as far around the points as the
longest shadow does, and making them is not in the times. Time is by the wall, and of processors for all threads. adumbra and GRASS start
as programs and read their input, and Embree's rays read the scene; their times include it.
"""

from __future__ import annotations

import argparse
import importlib
import resource
import shutil
import subprocess
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass
class Day:
    """A place, and the hours of a day."""

    lat: float
    lon: float
    date: str
    zone: str
    start: int
    end: int

    def suns(self, step: int) -> Any:
        """Return pvlib's table of suns, one at the start of each step, by NREL's algorithm and with the air of a standard atmosphere."""
        pandas, pvlib = importlib.import_module("pandas"), importlib.import_module("pvlib")
        midnight = pandas.Timestamp(self.date, tz=self.zone)
        seconds = np.arange(self.start * 3600, self.end * 3600, step)
        times = pandas.DatetimeIndex([midnight + pandas.Timedelta(int(second), "s") for second in seconds])
        return pvlib.solarposition.get_solarposition(times, self.lat, self.lon, pressure=101325, temperature=15)


@dataclass
class Scene:
    """The input of the peers: the file, a raster of heights around the points, and blocks."""

    path: Path
    cell: float
    heights: Floats  # Rows from north to south, columns from west to east.
    west: float
    north: float  # Northing of the raster's corner, which is -z.
    asked: NDArray[np.bool_]  # The cells that are points.
    blocks: list[tuple[Any, float]]  # Plans by (x, -z), and heights above the ground.
    ground: float
    points: Floats = field(init=False)

    def __post_init__(self) -> None:
        rows, columns = np.nonzero(self.asked)
        x = self.west + (columns + 0.5) * self.cell
        z = -self.north + (rows + 0.5) * self.cell
        self.points = np.stack([x, self.heights[self.asked], z], axis=1)

    @staticmethod
    def load(path: Path, day: Day, side: int, cell: float) -> Scene:
        """Load a scene; the points are in the middle of its plan."""
        trimesh = importlib.import_module("trimesh")
        mesh = trimesh.load(path, force="mesh")
        mesh.merge_vertices(merge_tex=True, merge_norm=True)
        suns = day.suns(600)
        lowest = max(float(suns["apparent_elevation"].min()), 2.0)
        height = float(mesh.bounds[1][1] - mesh.bounds[0][1])
        margin = int(np.ceil(height / np.tan(np.radians(lowest)) / cell)) + 1
        count = side + 2 * margin
        middle = np.round(mesh.bounds.mean(axis=0))
        west, north = middle[0] - count * cell / 2, -middle[2] + count * cell / 2
        columns, rows = np.meshgrid(np.arange(count), np.arange(count))
        above = np.full(count * count, mesh.bounds[1][1] + 1.0)
        origins = np.stack([west + (columns.ravel() + 0.5) * cell, above, -north + (rows.ravel() + 0.5) * cell], axis=1)
        down = np.tile([0.0, -1.0, 0.0], (len(origins), 1))
        found, rays, _ = mesh.ray.intersects_location(origins, down, multiple_hits=False)
        steps, counts = np.unique(np.round(found[:, 1], 1), return_counts=True)
        ground = float(steps[counts.argmax()])
        flat = np.full(count * count, ground)
        flat[rays] = found[:, 1]
        heights = flat.reshape(count, count)
        asked = np.zeros((count, count), dtype=np.bool_)
        inner = slice(margin, margin + side)
        asked[inner, inner] = np.abs(heights[inner, inner] - ground) < 0.1
        edges = (west, -north, west + count * cell, -north + count * cell)
        blocks = list(_blocks(mesh, ground, edges))
        return Scene(path, cell, heights, west, north, asked, blocks, ground)


def _blocks(mesh: Any, ground: float, edges: tuple[float, float, float, float]) -> Iterator[tuple[Any, float]]:
    """Yield plans and heights of roofs within edges (west, the least z, and their opposites), in classes of a metre."""
    shapely, graph = importlib.import_module("shapely"), importlib.import_module("trimesh.graph")
    x, z = mesh.triangles[:, :, 0], mesh.triangles[:, :, 2]
    inside = (x.max(axis=1) > edges[0]) & (x.min(axis=1) < edges[2]) & (z.max(axis=1) > edges[1]) & (z.min(axis=1) < edges[3])
    heights = mesh.triangles_center[:, 1] - ground
    roofs = np.flatnonzero(inside & (mesh.face_normals[:, 1] > 0.05) & (mesh.triangles[:, :, 1].min(axis=1) > ground + 0.5))
    pieces = graph.connected_component_labels(mesh.face_adjacency, node_count=len(mesh.faces))[roofs]
    classes = np.stack([pieces, np.floor(heights[roofs])], axis=1)
    _, labels = np.unique(classes, axis=0, return_inverse=True)
    for label in range(labels.max() + 1):
        faces = roofs[labels == label]
        plan = shapely.union_all(shapely.polygons(mesh.triangles[faces][:, :, [0, 2]] * [1, -1]), grid_size=0.001)
        for part in shapely.get_parts(plan):
            yield shapely.Polygon(part.exterior), float(np.average(heights[faces], weights=mesh.area_faces[faces]))


Hours = Callable[[Scene, Day, int], Floats]


@dataclass
class Peer:
    """A program to time. It finds hours of the points, or NaN where the hours are not those of the day."""

    name: str
    hours: Hours
    step: int
    modules: tuple[str, ...] = ()
    program: str = ""

    def absent(self) -> str:
        """Import the modules that the peer needs. Return a message if one or its program is missing, or an empty text."""
        for name in self.modules:
            try:
                importlib.import_module(name)
            except ImportError as error:
                return f"{self.name}: absent ({error})"
        return f"{self.name}: absent (no program {self.program})" if self.program and not shutil.which(self.program) else ""


def adumbra(program: Path) -> Hours:
    """Return the hours by `adumbra sun-hours`."""

    def hours(scene: Scene, day: Day, _: int) -> Floats:
        with tempfile.TemporaryDirectory() as folder:
            table, out = Path(folder) / "points.csv", Path(folder) / "hours.csv"
            upright = np.hstack([scene.points, np.tile([0, 1, 0], (len(scene.points), 1))])
            np.savetxt(table, upright, fmt="%.6g", delimiter=",", header="x,y,z,nx,ny,nz", comments="")
            when = ["--date", day.date, "--from", str(day.start), "--to", str(day.end), "--tz", day.zone]
            where = ["--points", str(table), "--lat", str(day.lat), "--lon", str(day.lon)]
            command = [str(program), "sun-hours", str(scene.path), *where, *when, "--progress", "none", "-o", str(out)]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            found: Floats = np.loadtxt(out, delimiter=",", skiprows=1, usecols=(0, 1, 2, 6))
        assert np.allclose(found[:, [0, 2]], scene.points[:, [0, 2]], atol=0.01)
        return found[:, 3]

    return hours


def trace(scene: Scene, suns: Floats, step: int) -> Floats:
    """Read the scene, and return the hours by Embree's rays to suns (elevation and azimuth, radians)."""
    mesh = importlib.import_module("trimesh").load(scene.path, force="mesh")
    origins = scene.points + [0, 0.01, 0]
    lit = np.zeros(len(origins))
    for elevation, azimuth in suns:
        if elevation > 0:
            level = np.cos(elevation)
            sun = [level * np.sin(azimuth), np.sin(elevation), -level * np.cos(azimuth)]
            lit += ~mesh.ray.intersects_any(origins, np.tile(sun, (len(origins), 1)))
    return lit * step / 3600


def rays(scene: Scene, day: Day, step: int) -> Floats:
    """Return the hours by rays to pvlib's suns."""
    return trace(scene, np.radians(day.suns(step)[["apparent_elevation", "azimuth"]].to_numpy()), step)


def rays_of_suncalc(scene: Scene, day: Day, step: int) -> Floats:
    """Return the hours by rays to the suns of suncalc, which pybdshadow uses."""
    position = importlib.import_module("suncalc").get_position
    found = [position(moment, day.lon, day.lat) for moment in day.suns(step).index.tz_convert("UTC").tz_localize(None)]
    return trace(scene, np.array([[sun["altitude"], sun["azimuth"] + np.pi] for sun in found]), step)


def by_raster(shadows: Callable[[NDArray[np.float32], float, float, float], NDArray[Any]]) -> Hours:
    """Return the hours by a function of heights, azimuth, elevation and cell that is 1 in the sun."""

    def hours(scene: Scene, day: Day, step: int) -> Floats:
        heights = (scene.heights - scene.ground).astype(np.float32)
        lit = np.zeros(heights.shape)
        for elevation, azimuth in day.suns(step)[["apparent_elevation", "azimuth"]].to_numpy():
            if elevation > 0:
                lit += shadows(heights, azimuth, elevation, scene.cell) > 0.5
        return lit[scene.asked] * step / 3600

    return hours


def umep(scene: Scene, day: Day, step: int) -> Floats:
    """Return the hours by UMEP's shadow generator."""
    shadow = importlib.import_module("umep.util.shadowingfunctions").shadowingfunctionglobalradiation
    return by_raster(lambda heights, azimuth, elevation, cell: shadow(heights, azimuth, elevation, 1 / cell, 1))(scene, day, step)


def solweig(scene: Scene, day: Day, step: int) -> Floats:
    """Return the hours by the shadows of solweig, on the processor."""
    shadowing = importlib.import_module("solweig.rustalgos").shadowing
    shadowing.disable_gpu()
    highest = float(scene.heights.max()) - scene.ground

    def shadow(heights: NDArray[np.float32], azimuth: float, elevation: float, cell: float) -> NDArray[Any]:
        found: NDArray[Any] = shadowing.calculate_shadows_wall_ht_25(azimuth, elevation, cell, highest, heights).bldg_sh
        return found

    return by_raster(shadow)(scene, day, step)


def local(day: Day) -> str:
    """Return a map projection centred on the place, with true north."""
    return f"+proj=tmerc +lat_0={day.lat} +lon_0={day.lon} +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs"


def grass(scene: Scene, day: Day, lines: list[str]) -> Floats:
    """Run lines in GRASS GIS on the map `heights`, and return the map `out` at the points."""
    rows, columns = scene.heights.shape
    south, east = scene.north - rows * scene.cell, scene.west + columns * scene.cell
    edges = f"north={scene.north} south={south} west={scene.west} east={east} rows={rows} cols={columns}"
    with tempfile.TemporaryDirectory() as folder:
        heights, out, job = (Path(folder) / name for name in ("heights.bin", "out.bin", "job.sh"))
        (scene.heights - scene.ground).astype("<f4").tofile(heights)
        first = ["set -e", f"r.in.bin -f input={heights} output=heights bytes=4 {edges}", "g.region raster=heights"]
        job.write_text("\n".join([*first, *lines, f"r.out.bin -f input=out output={out} bytes=4", ""]))

        def run(*arguments: str) -> None:
            subprocess.run(["grass", *arguments], check=True, capture_output=True)

        run("-e", "-c", "XY", f"{folder}/plane")
        run(f"{folder}/plane/PERMANENT", "--exec", "g.proj", "-c", f"proj4={local(day)}", "location=place")
        run(f"{folder}/place/PERMANENT", "--exec", "sh", str(job))
        found = np.fromfile(out, "<f4").reshape(rows, columns)
    return found[scene.asked].astype(np.float64)


def r_sun(scene: Scene, day: Day, step: int) -> Floats:
    """Return the hours by r.sun, which is run for each instant in solar time; the ground counts as level."""
    suns = day.suns(step)
    suns = suns[suns["apparent_elevation"] > 0]
    utc = suns.index.tz_convert("UTC")
    minutes = utc.hour * 60 + utc.minute + utc.second / 60 + 4 * day.lon + suns["equation_of_time"]
    day_of_year = suns.index[0].day_of_year
    lines = [f"r.sun elevation=heights day={day_of_year} time={at / 60 % 24:.5f} beam_rad=beam{sun}" for sun, at in enumerate(minutes)]
    lit = " + ".join(f"if(isnull(beam{sun}), 0, beam{sun} > 0)" for sun in range(len(suns)))
    return grass(scene, day, [*lines, f"r.mapcalc 'out = {lit}'"]) * step / 3600


def r_sun_day(scene: Scene, day: Day, step: int) -> Floats:
    """Run r.sun for the hours from sunrise to sunset, the only span that it sums by itself."""
    day_of_year = day.suns(step).index[0].day_of_year
    return grass(scene, day, [f"r.sun elevation=heights day={day_of_year} step={step / 3600:.6f} insol_time=out"]) * np.nan


def pybdshadow(scene: Scene, day: Day, step: int) -> Floats:
    """Return the hours by pybdshadow: points outside the shadows of all blocks."""
    shadow = importlib.import_module("pybdshadow").bdshadow_sunlight
    geopandas, pyproj, shapely = (importlib.import_module(name) for name in ("geopandas", "pyproj", "shapely"))
    blocks = {"building_id": range(len(scene.blocks)), "height": [height for _, height in scene.blocks]}
    frame = geopandas.GeoDataFrame(blocks, geometry=[plan for plan, _ in scene.blocks], crs=local(day)).to_crs("EPSG:4326")
    transform = pyproj.Transformer.from_crs(local(day), "EPSG:4326", always_xy=True).transform
    points = shapely.points(*transform(scene.points[:, 0], -scene.points[:, 2]))
    suns = day.suns(step)
    lit = np.zeros(len(points))
    for moment in suns.index[suns["apparent_elevation"] > 0].tz_convert("UTC").tz_localize(None):
        tree = shapely.STRtree(shadow(frame, moment).geometry.to_numpy())
        dark = np.zeros(len(points), dtype=np.bool_)
        dark[tree.query(points, predicate="intersects")[0]] = True
        lit += ~dark
    return lit * step / 3600


def processor() -> float:
    """Return the processor time of this process and of those it has waited for."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


@contextmanager
def timed(spent: list[float]) -> Iterator[None]:
    """Append the wall time and the processor time, in seconds."""
    wall, work = time.perf_counter(), processor()
    yield
    spent += [time.perf_counter() - wall, processor() - work]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--lat", type=float, default=48.0)
    parser.add_argument("--lon", type=float, default=11.0)
    parser.add_argument("--date", default="2026-03-20")
    parser.add_argument("--tz", default="+01:00")
    parser.add_argument("--from", type=int, default=8, dest="start")
    parser.add_argument("--to", type=int, default=17)
    parser.add_argument("--side", type=int, default=200, help="cells on a side of the square of points")
    parser.add_argument("--cell", type=float, default=1.0, help="side of a cell, metres")
    parser.add_argument("--step", type=int, default=60, help="seconds between suns")
    parser.add_argument("--slow-step", type=int, default=600, help="seconds between suns for slow peers")
    parser.add_argument("--only", nargs="+", help="time only peers whose names contain one of these")
    options = parser.parse_args()
    warnings.filterwarnings("ignore", "CRS not set")  # By pybdshadow, for each sun.
    day = Day(options.lat, options.lon, options.date, options.tz, options.start, options.to)
    spent: list[float] = []
    with timed(spent):
        scene = Scene.load(options.scene, day, options.side, options.cell)
    size = f"{scene.heights.shape[0]} x {scene.heights.shape[1]} cells of {options.cell:g} m"
    print(f"{options.scene.name}: {len(scene.points)} points, {size}, {len(scene.blocks)} blocks, made in {spent[0]:.1f} s\n")
    if not len(scene.points):
        raise SystemExit("no cell of the square is on the ground: try a larger --side")
    fine, slow = options.step, options.slow_step
    embree, umeps, blocks = ("trimesh", "embreex"), ("umep.util.shadowingfunctions",), ("pybdshadow", "geopandas", "pyproj")
    peers = [
        Peer("adumbra (the reference)", adumbra(options.program), fine),
        Peer("pvlib, trimesh and Embree", rays, fine, embree),
        Peer("pvlib, trimesh and Embree", rays, slow, embree),
        Peer("suncalc, trimesh and Embree", rays_of_suncalc, slow, (*embree, "suncalc")),
        Peer("solweig", solweig, fine, ("solweig.rustalgos",)),
        Peer("solweig", solweig, slow, ("solweig.rustalgos",)),
        Peer("UMEP", umep, fine, umeps),
        Peer("UMEP", umep, slow, umeps),
        Peer("r.sun", r_sun, slow, program="grass"),
        Peer("r.sun, sunrise to sunset", r_sun_day, slow, program="grass"),
        Peer("pybdshadow", pybdshadow, slow, blocks),
    ]
    print("| program | step, s | s | processor s | ns a point and sun | mean error, h | 99th percentile, h | points that differ |")
    print("|---|---|---|---|---|---|---|---|", flush=True)
    absent: list[str] = []
    reference: Floats | None = None
    for peer in peers:
        if options.only and reference is not None and not any(part in peer.name for part in options.only):
            continue
        if missing := peer.absent():
            absent += [missing] if missing not in absent else []
            continue
        spent = []
        with timed(spent):
            found = peer.hours(scene, day, peer.step)
        reference = found if reference is None else reference
        off = np.abs(found - reference)
        errors = (
            "not the same hours | | "
            if np.isnan(off).any()
            else f"{off.mean():.4f} | {np.percentile(off, 99):.3f} | {np.count_nonzero(off > 0.001)}"
        )
        each = 1e9 * spent[1] * peer.step / ((day.end - day.start) * 3600 * len(found))
        print(f"| {peer.name} | {peer.step} | {spent[0]:.2f} | {spent[1]:.2f} | {each:.0f} | {errors} |", flush=True)
    print(*["", *absent], sep="\n")


if __name__ == "__main__":
    main()
