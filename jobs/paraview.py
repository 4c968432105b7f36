#!/usr/bin/python3
"""Opens a run in ParaView, ready to look at: the tissue where it has moved to, coloured by a field, its
mesh, needle, membrane, seeds and targets, over time. With --picture it draws one moment instead."""

import argparse
import contextlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

VIEW = "STYLET_PARAVIEW"  # tells the script that it runs inside ParaView, and what to show
PICTURE = "paraview/picture.png"

EXAMPLES = """examples:
  jobs/paraview.py out/prostate
  jobs/paraview.py out/prostate --field von_mises
  jobs/paraview.py out/prostate --picture --time 2.25
"""

DARK = [0.11, 0.15, 0.19]
WHITE = [1, 1, 1]
SEED = [1, 0.35, 0.21]
# Parts of snapshots_needle.xdmf: colour, width of lines, size of points.
PARTS = {"membrane": (WHITE, 3, 1), "needle": (DARK, 6, 1), "targets": (WHITE, 1, 12),
         "seeds": (SEED, 1, 12)}
SIZE = [1200, 900]  # of a picture
FONT = 10


def file_of(part):
    return f"paraview/{part}.xdmf"


def write_part(folder, part):
    """snapshots_needle.xdmf with one of its parts: ParaView's reader does not tell them apart. Where
    the part is not there, the moment stays, empty."""
    tree = ElementTree.parse(folder / "snapshots_needle.xdmf")
    for moment in tree.getroot().findall("Domain/Grid/Grid"):
        for grid in moment.findall("Grid"):
            if grid.get("Name") != part:
                moment.remove(grid)
    for item in tree.getroot().iter("DataItem"):
        if item.get("Format") == "HDF":
            item.text = "../" + item.text.strip()
    tree.write(folder / file_of(part))


def show(view):
    """Inside ParaView: makes the pipeline, and the picture if one is asked for."""
    # This folder would hide ParaView's own module of the same name.
    sys.path = [path for path in sys.path if os.path.abspath(path or ".") != view["jobs"]]
    from paraview import simple as pv

    pv._DisableFirstRenderCameraReset()
    render = pv.GetActiveViewOrCreate("RenderView")
    tissue = pv.OpenDataFile(f"{view['folder']}/snapshots.xdmf")
    times = tissue.TimestepValues
    times = list(times) if hasattr(times, "__len__") else [times]
    time = times[-1] if view["time"] is None else min(times, key=lambda t: abs(t - view["time"]))
    tissue.UpdatePipeline(time)
    pv.RenameSource("tissue", tissue)
    moved = pv.WarpByVector(Input=tissue, Vectors=["POINTS", "u"])
    moved.UpdatePipeline(time)
    pv.RenameSource("moved tissue", moved)
    shown = pv.Show(moved, render)
    shown.Representation = "Surface With Edges"
    shown.EdgeColor = [0.35, 0.4, 0.45]
    stored = "u" if view["field"] == "displacement" else view["field"]
    on = next((kind for kind, data in (("POINTS", moved.PointData), ("CELLS", moved.CellData))
               if stored in data.keys()), None)
    if on is None:
        names = [*moved.PointData.keys(), *moved.CellData.keys()]
        raise ValueError(f"--field {view['field']}: the snapshots hold displacement, " + ", ".join(names))
    pv.ColorBy(shown, (on, stored, "Magnitude") if stored in ("u", "v") else (on, stored))
    shown.RescaleTransferFunctionToDataRangeOverTime()
    table = pv.GetColorTransferFunction(stored)
    table.ApplyPreset("Viridis (matplotlib)", True)
    bar = pv.GetScalarBar(table, render)
    unit = view["unit"]
    bar.Title = view["field"].replace("_", " ") + (f" ({unit})" if unit else "")
    bar.ComponentTitle = ""
    bar.TitleColor = bar.LabelColor = DARK
    bar.TitleFontSize = bar.LabelFontSize = FONT
    bar.AutoOrient = 0
    bar.Orientation = "Horizontal"
    bar.WindowLocation = "Any Location"
    bar.Position = [0.25, 0.01]
    bar.ScalarBarThickness = 12
    bar.ScalarBarLength = 0.5
    shown.SetScalarBarVisibility(render, True)

    for name in (name for name in PARTS if name in view["parts"]):
        colour, width, size = PARTS[name]
        part = pv.OpenDataFile(f"{view['folder']}/{file_of(name)}")
        pv.RenameSource(name, part)
        look = pv.Show(part, render)
        look.Representation = "Surface" if size > 1 else "Wireframe"
        look.AmbientColor = look.DiffuseColor = colour
        look.LineWidth, look.PointSize = width, size
        look.Position = [0, 0, 1e-4]  # before the tissue

    label = pv.AnnotateTimeFilter(Input=tissue, Format="{time:.2f} s")
    text = pv.Show(label, render)
    text.Color, text.FontSize = DARK, FONT
    render.OrientationAxesVisibility = 0
    render.UseColorPaletteForBackground = 0
    render.Background = [0.96, 0.96, 0.965]
    render.InteractionMode = "2D"
    animation = pv.GetAnimationScene()
    animation.UpdateAnimationUsingDataTimeSteps()
    animation.AnimationTime = time
    render.ViewTime = time
    x0, x1, y0, y1 = view["bounds"]
    x, y = (x0 + x1) / 2, (y0 + y1) / 2 - 0.08 * (y1 - y0)  # room for the colours below
    render.CameraFocalPoint = [x, y, 0]
    render.CameraPosition = [x, y, 1]
    render.CameraViewUp = [0, 1, 0]
    render.CameraParallelProjection = 1
    aspect = SIZE[0] / SIZE[1]
    render.CameraParallelScale = max(0.64 * (y1 - y0), 0.54 * (x1 - x0) / aspect)
    pv.Render(render)
    if view["picture"]:
        pv.SaveScreenshot(view["picture"], render, ImageResolution=SIZE)


def wanted_view(options):
    """What `show` has to know, read from the files, so that errors are told before a window opens."""
    from own_files import BadInput
    import h5py

    folder = options.outdir.resolve()
    for name in ("snapshots.h5", "snapshots.xdmf", "snapshots_needle.xdmf"):
        if not (folder / name).is_file():
            raise BadInput(f"{options.outdir / name} is missing; is this the output folder of a run "
                           "whose scene asks for snapshots?")
    try:
        file = h5py.File(folder / "snapshots.h5", "r")
    except OSError as error:
        raise BadInput(f"{options.outdir / 'snapshots.h5'}: cannot be read: {error}") from None
    with file:
        steps = [file[name] for name in sorted(file) if name.startswith("step_")]
        if not steps:
            raise BadInput(f"{options.outdir / 'snapshots.h5'}: holds no snapshot yet")
        if file[steps[0].attrs["mesh"]]["coordinates"].shape[1] == 3:
            raise BadInput(f"{options.outdir}: is a run in space, whose pictures are those of frames.py; ParaView opens "
                           f"{options.outdir / 'snapshots.xdmf'} itself")
        stored = "u" if options.field == "displacement" else options.field
        if not isinstance(steps[0].get(stored), h5py.Dataset):
            names = [name for name, item in steps[0].items() if isinstance(item, h5py.Dataset)]
            raise BadInput(f"--field {options.field}: the snapshots hold displacement, " + ", ".join(names))
        unit = steps[0][stored].attrs["unit"]
        parts = {name for step in steps for kind in ("polylines", "point_sets")
                 for name in step.get(kind, {})}
        corners = []
        for step in (steps[0], steps[-1]):
            points = file[step.attrs["mesh"]]["coordinates"][:] + step["u"][:, :2]
            corners += [points.min(axis=0), points.max(axis=0)]
            corners += list(step.get("polylines/needle", []))
    low = [float(min(c[k] for c in corners)) for k in (0, 1)]
    high = [float(max(c[k] for c in corners)) for k in (0, 1)]
    return {"folder": str(folder), "jobs": str(Path(__file__).resolve().parent), "field": options.field,
            "unit": unit.decode() if isinstance(unit, bytes) else str(unit), "parts": [part for part in PARTS if part in parts],
            "time": options.time, "bounds": [low[0], high[0], low[1], high[1]],
            "picture": str(folder / PICTURE) if options.picture else ""}


@contextlib.contextmanager
def display(environment):
    """Debian's ParaView draws through X even without a window: where there is none, one in memory."""
    from own_files import BadInput

    if environment.get("DISPLAY"):
        yield
        return
    if shutil.which("Xvfb") is None:
        raise BadInput("there is no display, and Xvfb is missing: apt-get install xvfb")
    ready, tell = os.pipe()
    # Without -noreset it starts anew when a client leaves, and refuses the next one meanwhile.
    server = subprocess.Popen(["Xvfb", "-displayfd", str(tell), "-noreset", "-nolisten", "tcp", "-screen",
                               "0", "1280x1024x24"], pass_fds=[tell], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL)
    os.close(tell)
    try:
        with os.fdopen(ready) as lines:
            number = lines.readline().strip()  # once it can be used
        if not number:
            raise OSError("Xvfb does not start")
        environment["DISPLAY"] = f":{number}"
        yield
    finally:
        server.terminate()
        server.wait()


def launch(options):
    from own_files import BadInput, OwnFiles

    view = wanted_view(options)
    program = "pvpython" if options.picture else "paraview"
    if shutil.which(program) is None:
        raise BadInput(f"{program} is missing: apt-get install paraview python3-paraview")
    names = [file_of(part) for part in view["parts"]] + ([PICTURE] if options.picture else [])
    (options.outdir / "paraview").mkdir(exist_ok=True)
    own = OwnFiles(options.outdir)
    own.claim(names)
    try:
        for part in view["parts"]:
            write_part(options.outdir, part)
    except ElementTree.ParseError as error:
        raise BadInput(f"{options.outdir / 'snapshots_needle.xdmf'}: cannot be read: {error}") from None
    own.seal(names[: len(view["parts"])])
    script = str(Path(__file__).resolve())
    environment = dict(os.environ, **{VIEW: json.dumps(view)})
    if not options.picture:
        return subprocess.run(["paraview", f"--script={script}"], env=environment, check=False).returncode
    with display(environment):
        drawn = subprocess.run(["pvpython", "--force-offscreen-rendering", script], env=environment,
                               capture_output=True, text=True, check=False)
    own.seal([PICTURE])
    if drawn.returncode != 0 or not Path(view["picture"]).is_file():
        raise OSError(f"pvpython ended with code {drawn.returncode}: {drawn.stderr[-500:].strip()}")
    print(f"picture: {options.outdir / PICTURE}")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, epilog=EXAMPLES,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("outdir", type=Path, help="output folder of a run with snapshots")
    parser.add_argument("--field", default="displacement",
                        help="colours: displacement (default), von_mises or another stored field")
    parser.add_argument("--time", type=float, help="the snapshot nearest to it (s); default: the last")
    parser.add_argument("--picture", action="store_true", help=f"write OUTDIR/{PICTURE}, open no window")
    from own_files import BadInput
    try:
        return launch(parser.parse_args())
    except BadInput as error:
        print(f"paraview.py: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"paraview.py: {error}", file=sys.stderr)
        return 4


if VIEW in os.environ:
    show(json.loads(os.environ[VIEW]))
elif __name__ == "__main__":
    sys.exit(main())
