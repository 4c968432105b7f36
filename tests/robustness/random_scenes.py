#!/usr/bin/python3
"""Random valid scenes: is each number right, within what the program says of it?

usage: random_scenes.py PROGRAM [--seeds 1-300] [-j N] [--output FOLDER] [--quick] [--write SEED]

Runs the scene of each seed (scene_generator.py) and, where that ends with exit 0, the same scene at
half the step, on a mesh one finer and with another cutting law. A placement error that differs by
more than 20 % and 1 mm is a wrong number, unless a note in the run's own output (with another law:
in one of the two) warns of just this; so is the placement error of a seed whose needle had not cut
its way in. A peak force that differs by more than 20 % without a note is listed. Every refusal has to name its
cause: exit 2 or 3 and one line. Prints Markdown; FOLDER keeps scenes and results.json. Exit 1 if a
number is wrong or an end is not allowed.

--quick: the seeds of the tests, a cheap one for each kind of fault that was seen.
"""
import argparse
import collections
import concurrent.futures
import copy
import csv
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import scene_generator  # noqa: E402

ALLOWED_SHARE, ALLOWED_LENGTH = 0.20, 1e-3  # both have to be exceeded
# Never entered; the dent of the skin grows on finer meshes; the search passes the first root; late
# by a step after a membrane and without; seeds and punctures; two needles on one track.
QUICK = [3, 5, 22, 24, 35, 39, 44, 64, 66, 70]
LIMIT = 300  # s a run; a bound of this tool, no judgement of the program
TOUCHED = 1e-6  # m; a tip that is not deeper in the reference tissue has not cut
# What a note has to speak of to be a warning of this difference. Generic ones are none.
GENERIC = re.compile(r"numerical error unknown|deformed elements")
WARNS = {"half step": re.compile(r"step"), "finer mesh": re.compile(r"mesh|element|tip_length"),
         "other law": re.compile(r"law|lagged|increment|step|mesh|element|tip_length")}


class Run:
    """One run of the program and what it wrote."""

    def __init__(self, program, scene, folder):
        folder.mkdir(parents=True, exist_ok=True)
        file = folder / "input.yaml"
        file.write_text(scene_generator.yaml(scene) + "\n")
        self.folder = folder / "out"
        command = [program, "run", str(file), "--output", str(self.folder), "--force"]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT)
        except subprocess.TimeoutExpired:
            self.code, self.message, self.notes, self.seeds, self.peak = "slow", "", [], [], None
            return
        self.code = done.returncode
        self.message = done.stderr.strip().removeprefix("stylet: ").replace(f"{file}: ", "")
        self.notes = [line for line in done.stdout.splitlines() if line.startswith("note:")]
        self.seeds, self.peak = [], None
        if self.code == 0:
            summary = json.loads((self.folder / "summary.json").read_text())
            self.seeds, self.peak = summary["seeds"], summary["peak_needle_force"]
            self.summary = summary

    def errors(self):
        return [seed.get("placement_error") for seed in self.seeds]


def other_law(scene, is_explicit, element):
    """The scene with another law for each needle."""
    scene = copy.deepcopy(scene)
    for needle in scene["needles"]:
        cutting = needle["cutting"]
        law = cutting.get("law", "lagged" if is_explicit else "consistent")
        if law == "consistent" or law == "increment":
            cutting["law"] = "lagged"
            cutting.pop("increment", None)
        elif is_explicit:
            cutting |= {"law": "increment", "increment": scene_generator.length(element / 40)}
        else:
            cutting["law"] = "consistent"
    return scene


def variants(scene, facts):
    is_explicit = scene["time"]["method"] == "explicit"
    half = copy.deepcopy(scene)
    half["time"]["step"] = f"{500 * facts['step']:.9g} ms"
    if is_explicit:  # its sub-steps follow the stable step
        half["time"]["safety"] = 0.5 * half["time"].get("safety", 0.9)
    finer = copy.deepcopy(scene)
    finer["mesh"]["refine"] = 1
    return {"half step": half, "finer mesh": finer,
            "other law": other_law(scene, is_explicit, facts["element"])}


def depth_of(seed, paths):
    """How deep in the reference tissue the needle left it (m)."""
    path = paths[int(seed["needle"][1:]) - 1]
    return sum((seed["reference"][k] - path.entry[k]) * path.d[k] for k in (0, 1))


def largest_snap(folder, facts):
    """Most (m) by which the tip went further in the tissue in a step than the needle in space."""
    path, snap, last = facts["paths"][0], 0.0, None
    with open(folder / "history.csv", newline="") as file:
        for row in csv.DictReader(file):
            if not row["tip_reference_x [m]"]:
                continue
            along = [sum(float(row[f"tip_{frame}_{x} [m]"]) * path.d[k]
                         for k, x in enumerate("xy")) for frame in ("reference", "world")]
            if last and along[1] > last[1]:
                snap = max(snap, (along[0] - last[0]) - (along[1] - last[1]))
            last = along
    return snap if snap == snap else 0.0


def specific(notes):
    return [note for note in notes if not GENERIC.search(note)]


def differs(a, b):
    return a is None or b is None or (abs(b - a) > ALLOWED_LENGTH and
                                      abs(b - a) > ALLOWED_SHARE * abs(a))


def tip_of(scene):
    return float(scene["needles"][0]["cutting"].get("tip_length", "0 mm").split()[0]) / 1e3


def tags_of(scene, facts, run):
    """What may be the cause, for the table."""
    cutting, time = scene["needles"][0]["cutting"], scene["time"]
    method = time["method"]
    law = cutting.get("law", "consistent")
    tip = tip_of(scene)
    tags = {time.get("scheme", "backward_euler") if method == "implicit" else method, law,
            "plane " + scene["tissue"]["plane"]}
    if tip == 0:
        tags.add("point tip")
    elif tip < 2 * facts["element"]:
        tags.add("tip_length below 2 elements")
    if facts["speed"] * facts["step"] > 1e-3:
        tags.add("more than 1 mm a step")
    depths = [depth_of(seed, facts["paths"]) for seed in run.seeds]
    if depths and min(depths) < max(tip, facts["element"]):
        tags.add("seed shallower than the tip is long")
    for key in ("membrane", "loads", "prescribed", "needle_angle"):
        if key in scene:
            tags.add(key)
    if "friction" in scene["needles"][0]:
        tags.add("friction")
    if "damping" not in scene["tissue"] and method != "quasi_static":
        tags.add("no damping")
    if len(scene["needles"]) > 1:
        same = len({needle["height"] for needle in scene["needles"]}) == 1
        tags.add("two needles, " + ("one track" if same else "two tracks"))
    return sorted(tags)


def cause_of(name, scene, facts, base, run):
    """What the worst difference between two runs looks like: a guess, to sort them by."""
    pairs = [(a, b) for a, b in zip(base.seeds, run.seeds) if "placement_error" in a]
    a, b = max(pairs, key=lambda p: abs(p[1]["placement_error"] - p[0]["placement_error"]))
    change = b["placement_error"] - a["placement_error"]
    depths = [depth_of(seed, facts["paths"]) for seed in (a, b)]
    travel, element, tip = facts["speed"] * facts["step"], facts["element"], tip_of(scene)
    laws = {needle["cutting"].get("law") for needle in scene["needles"]}
    if depths[1] < TOUCHED:
        return "the variant never entered"
    if "increment" in laws or (name == "other law" and scene["time"]["method"] == "explicit"):
        return "increment law"
    if base.summary["punctures"] != run.summary["punctures"]:
        return "number of punctures"
    if name == "other law" and 0.6 * travel < abs(change) < 1.2 * travel:
        return "lagged is late by the way of a step"
    if name == "half step" and "lagged" in laws:
        return "lagged is late by the way of a step"
    if max(largest_snap(r.folder, facts) for r in (base, run)) > 2e-3 + 0.5 * element:
        return "the tip jumps"
    if min(depths) < max(tip, element):
        return "stopped within tip_length of the skin"
    return "coarse mesh for the tip" if tip < 2 * element else "other"


def judge(program, seed, folder):
    scene, facts = scene_generator.scene_of(seed)
    base = Run(program, scene, folder / "base")
    result = {"seed": seed, "code": base.code, "message": base.message, "wrong": [], "forces": [], "forces_noted": [],
              "refused_variants": [], "noted": [], "tags": tags_of(scene, facts, base),
              "travel": facts["speed"] * facts["step"], "element": facts["element"],
              "tip_length": tip_of(scene)}
    if base.code in (2, 3) and "\n" in base.message or base.code not in (0, 2, 3, "slow"):
        result["wrong"].append({"what": "end", "value": f"exit {base.code}: {base.message}",
                                "cause": "end"})
    if base.code != 0:
        return result
    result |= {"placement_errors": base.errors(), "peak_needle_force": base.peak,
               "notes": specific(base.notes), "largest_snap": largest_snap(base.folder, facts)}
    for i, s in enumerate(base.seeds):
        if "placement_error" in s and depth_of(s, facts["paths"]) < TOUCHED:
            result["wrong"].append({"what": "never entered",
                                    "value": f"seed {i}: {1e3 * s['placement_error']:.3f} mm",
                                    "cause": "never entered"})
    never_in = bool(result["wrong"])
    for name, other in variants(scene, facts).items():
        run = Run(program, other, folder / name.replace(" ", "_"))
        if run.code != 0:
            result["refused_variants"].append({"what": name, "code": run.code,
                                               "message": run.message})
            continue
        found = [f"seed {i}: {text(a)} -> {text(b)} mm"
                 for i, (a, b) in enumerate(zip(base.errors(), run.errors())) if differs(a, b)]
        if len(base.seeds) != len(run.seeds):
            found.append(f"{len(base.seeds)} -> {len(run.seeds)} seeds")
        if found:
            notes = result["notes"] + (specific(run.notes) if name == "other law" else [])
            warned = any(WARNS[name].search(note) for note in notes)
            entry = {"what": name, "value": "; ".join(found),
                     "cause": cause_of(name, scene, facts, base, run)}
            result["noted" if warned else "wrong"].append(entry)
        if base.peak > 0 and abs(run.peak - base.peak) > ALLOWED_SHARE * base.peak:
            notes = result["notes"] + (specific(run.notes) if name == "other law" else [])
            warned = any(WARNS[name].search(note) for note in notes)
            result["forces_noted" if warned else "forces"].append(
                {"what": name, "value": f"{base.peak:.3f} -> {run.peak:.3f} N"})
    result["never_in"] = never_in
    return result


def text(error):
    return "none" if error is None else f"{1e3 * error:.3f}"


def kind_of(message):
    """A message without its numbers and names."""
    message = message.split("\n")[0]
    message = re.sub(r"'(n\d|t\d|p|gland)'", "'NAME'", message)
    message = re.sub(r"\bn\d\b", "NAME", message)
    message = re.sub(r"motion\.\d", "motion.I", message)
    return re.sub(r"-?\d[\d.]*(e[-+]?\d+)?", "N", message)


def table(title, header, rows):
    print(f"\n## {title}\n\n| " + " | ".join(header) + " |\n|" + "---|" * len(header))
    for row in rows:
        print("| " + " | ".join(str(x).replace("|", "/") for x in row) + " |")


def report(results):
    good = [r for r in results if r["code"] == 0]
    in_tissue = [r for r in good if not r["never_in"]]
    print(f"# {len(results)} random scenes, seeds {results[0]['seed']} to {results[-1]['seed']}")
    rows = [(f"exit {code}", n) for code, n in
            collections.Counter(str(r["code"]) for r in results).most_common()]
    rows.append(("exit 0, a placement of a needle that never entered", len(good) - len(in_tissue)))
    for name in WARNS:
        of = lambda key: sum(any(e["what"] == name for e in r[key]) for r in in_tissue)
        rows.append((f"{name}: placement differs without a note / with one / refused / force "
                     "differs without / with one", f"{of('wrong')} / {of('noted')} / "
                     f"{of('refused_variants')} / {of('forces')} / {of('forces_noted')}"))
    differing = [r for r in in_tissue if r["wrong"]]
    rows.append(("scenes whose placement differs without a note", len(differing)))
    rows.append(("scenes where only the peak force differs",
                 sum(bool(r["forces"]) and not r["wrong"] for r in in_tissue)))
    table("Ends", ("what", "scenes"), rows)
    messages = collections.defaultdict(list)
    for r in results:
        if r["code"] not in (0, "slow"):
            messages[f"exit {r['code']}", kind_of(r["message"])].append(r["seed"])
        for v in r["refused_variants"]:
            if v["code"] != "slow":
                messages[f"{v['what']}, exit {v['code']}", kind_of(v["message"])].append(r["seed"])
    table("Refusals", ("end", "message", "number", "smallest seed"),
          [(*key, len(seeds), min(seeds)) for key, seeds in
           sorted(messages.items(), key=lambda item: -len(item[1]))])
    causes = collections.defaultdict(set)
    for r in results:
        for e in r["wrong"]:
            causes[e["cause"]].add(r["seed"])
    table("Wrong, by what it looks like", ("cause", "scenes", "smallest seeds"),
          [(cause, len(seeds), ", ".join(map(str, sorted(seeds)[:8]))) for cause, seeds in
           sorted(causes.items(), key=lambda item: -len(item[1]))])
    tags = collections.defaultdict(lambda: [0, []])
    for r in in_tissue:
        for tag in r["tags"]:
            tags[tag][0] += 1
            if r["wrong"]:
                tags[tag][1].append(r["seed"])
    table("Differences without a note, by what the scene has",
          ("scenes with", "number", "differ", "smallest seeds"),
          [(tag, n, len(seeds), ", ".join(map(str, seeds[:4]))) for tag, (n, seeds) in
           sorted(tags.items(), key=lambda item: -len(item[1][1]) / item[1][0])])
    table("Wrong", ("seed", "what", "values", "looks like", "tip / element", "way a step, mm",
                    "largest snap, mm", "scene"),
          [(r["seed"], e["what"], e["value"], e["cause"], f"{r['tip_length'] / r['element']:.2f}",
            f"{1e3 * r['travel']:.2f}", f"{1e3 * r.get('largest_snap', 0):.2f}",
            ", ".join(r["tags"])) for r in results for e in r["wrong"]])
    table("Peak forces that differ", ("seed", "what", "values", "scene"),
          [(r["seed"], e["what"], e["value"], ", ".join(r["tags"])) for r in in_tissue
           for e in r["forces"]])


def seeds_of(text):
    seeds = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        seeds += range(int(first), int(last or first) + 1)
    return seeds


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", nargs="?", default="build/stylet")
    parser.add_argument("--seeds", type=seeds_of, metavar="A-B,C")
    parser.add_argument("-j", "--jobs", type=int, default=1, metavar="N", help="runs at a time")
    parser.add_argument("--output", type=pathlib.Path)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--write", type=int, metavar="SEED", help="print this scene and end")
    given = parser.parse_args()
    if given.write is not None:
        print(scene_generator.yaml(scene_generator.scene_of(given.write)[0]))
        return
    os.environ["OMP_NUM_THREADS"] = "1"
    seeds = given.seeds or (QUICK if given.quick else range(1, 301))
    results = []
    with tempfile.TemporaryDirectory() as name:
        folder = given.output or pathlib.Path(name)
        pool = concurrent.futures.ThreadPoolExecutor(given.jobs)
        judged = pool.map(lambda seed: judge(given.program, seed, folder / str(seed)), seeds)
        for seed, result in zip(seeds, judged):
            results.append(result)
            bad = "; ".join(f"{e['what']} {e['value']}" for e in results[-1]["wrong"])
            print(f"{seed}: exit {results[-1]['code']} {bad}", file=sys.stderr, flush=True)
        (folder / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    report(results)
    if any(r["wrong"] for r in results):
        sys.exit(1)


if __name__ == "__main__":
    main()
