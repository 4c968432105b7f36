"""The band that converge prints for a needle in space holds the answer of the axisymmetric computation
(needle_in_space_test.cpp) on every mesh, and its parts are there.

usage: kernel_band.py STYLET MESH
"""

import json
import pathlib
import subprocess
import sys
import tempfile

SCENE = """
mesh: {{file: {mesh}, scale: 0.001}}
tissue:
  formulation: p1_averaged
  regions: {{tissue: {{youngs_modulus: 60 kPa, poisson_ratio: 0.45, density: 1000 kg/m^3}}}}
supports: {{side: fixed, bottom: fixed}}
needles:
  - entry: [0 mm, 0 mm, 60 mm]
    direction: [0, 0, -1]
    kernel_radius: 10 mm
    cutting: {{cutting_force: 1.7 N, tip_length: 6 mm}}
    friction:
      {{static_force: 195 N/m, kinetic_force: 130 N/m, stick_speed: 0.5 mm/s, slip_speed: 1 mm/s}}
    motion: [insert: {{speed: 5 mm/s, depth: 39.493 mm}}, implant]
targets: {{t: [0 mm, 0 mm, 25 mm]}}
time: {{method: quasi_static, step: 200 ms}}
"""
KNOWN = 4.493e-3  # m, at 35 mm, which the tip has then cut
QUANTITY = "seeds.0.tip_displacement"


def main():
    stylet, mesh = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        scene = pathlib.Path(folder) / "scene.yaml"
        scene.write_text(SCENE.format(mesh=pathlib.Path(mesh).resolve()))
        subprocess.run([stylet, "converge", scene, "--mesh-levels", "2", "--step-levels", "1",
                        "--output", f"{folder}/out", "--store", "--no-picture", "--quiet"], check=True)
        study = json.loads((scene.parent / "out/convergence.json").read_text())["quantities"][QUANTITY]
        own, narrow = study["kernel"]["levels"]
        assert abs(narrow["kernel"] - 0.5**0.5) < 1e-12
        # The error goes with the radius squared: twice what halving its square takes away, and a quarter more.
        assert abs(own["uncertainty"] / abs(narrow["value"] - own["value"]) - 2.5) < 1e-9
        for level in study["mesh"]["levels"]:
            band = (level["uncertainty"]**2 + own["uncertainty"]**2)**0.5
            print(f"{1e3 * level['value']:.4f} ± {1e3 * band:.4f} mm on {level['n_tetrahedra']} tetrahedra")
            assert abs(level["value"] - KNOWN) < band
            assert band < 0.25 * KNOWN
        told = subprocess.run([stylet, "run", scene, "--output", f"{folder}/run"], check=True,
                              capture_output=True, text=True).stdout
        assert ", kernel " in told, told
        # The seed is 4.5 mm ahead of its place, the mesh around it less than 1: that is no answer.
        assert "where seeds are is not told" in told, told
        assert "placement error of" not in told, told
        summary = json.loads((pathlib.Path(folder) / "run/summary.json").read_text())
        assert not {"world", "placement_error"} & set(summary["seeds"][0]), summary["seeds"]
        waits = "needles.0.motion=[insert: {speed: 5 mm/s, depth: 39.493 mm}, implant, settle: {duration: 1 s}]"
        refused = subprocess.run([stylet, "tradeoff", scene, "--set", waits, "--output", f"{folder}/tradeoff"],
                                 check=False, capture_output=True, text=True)
        assert refused.returncode == 2 and "a retract all the way out" in refused.stderr, refused.stderr


main()
