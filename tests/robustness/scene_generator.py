"""Random scenes that are valid: whole schema, magnitudes of soft tissue within a decade or so.

scene_of(seed) is the same on every machine. What stands in a scene is drawn independently, but for
what the schema ties together; forces follow the stiffness so that most needles get in.
"""
import math
import random

DEEPEST = 0.8  # of the way through the tissue: the deepest insertion
WITHIN_FIRST_CUT = 2.5  # elements; a seed half as deep as this may be refused
DENT = 0.4  # F / (E t) over the depth of a seed: more, and the needle may not have cut its way in


# Tables and tests are of these seeds: their scenes stay what they were when keys are added, which have
# draws of their own.
KEPT = 300


class Draw(random.Random):
    def chance(self, share):
        return self.random() < share

    def log(self, low, high):
        return math.exp(self.uniform(math.log(low), math.log(high)))


def length(x):
    return f"{1e3 * x:.12g} mm"


def lengths(point):
    return [length(x) for x in point]


def force(x):
    return f"{x:.5g} N"


class Path:
    """Of a needle: entry on a side of the rectangle, direction, length of tissue ahead."""

    def __init__(self, size, degrees, share):
        self.angle = math.radians(degrees)
        self.d = (math.cos(self.angle), math.sin(self.angle))
        self.size = size
        self.side = ("left", "bottom", "right", "top")[round(degrees / 90) % 4]
        across = 1 if self.side in ("left", "right") else 0
        self.entry = [size[k] if self.side in ("right", "top") else 0 for k in (0, 1)]
        self.entry[across] = share * size[across]
        ends = [((size[k] if self.d[k] > 0 else 0) - self.entry[k]) / self.d[k]
                for k in (0, 1) if abs(self.d[k]) > 1e-9]
        self.through = min(end for end in ends if end > 0)
        self.height = self.d[1] * self.entry[0] - self.d[0] * self.entry[1]

    def at(self, along, across=0.0):
        """A point of the scene, kept inside the tissue."""
        x = (self.entry[0] + along * self.d[0] - across * self.d[1],
             self.entry[1] + along * self.d[1] + across * self.d[0])
        return tuple(min(max(x[k], 0), self.size[k]) for k in (0, 1))


def mesh_of(draw, size, grid):
    columns, rows = grid
    rectangle = {"size": lengths(size), "columns": columns, "rows": rows}
    if draw.chance(0.4):
        rectangle["diagonals"] = draw.choice(["one_way", "alternating"])
    if draw.chance(0.4):
        rectangle |= {"jitter": round(draw.uniform(0.02, 0.25), 3), "seed": draw.randrange(1000)}
    inner = []
    if min(grid) >= 10 and draw.chance(0.6):
        centre = [draw.uniform(0.45, 0.55) * x for x in size]
        extent = [draw.uniform(0.4, 0.7) * x for x in size]
        if draw.chance(0.6):
            inner.append({"name": "gland", "ellipse": {"centre": lengths(centre),
                                                       "size": lengths(extent)}})
        else:
            half = [0.5 * x for x in extent]
            corners = [(-0.7, -1), (0.8, -1), (1, 0.1), (0.3, 1), (-1, 0.6)]
            inner.append({"name": "gland", "polygon": [
                lengths([centre[k] + corner[k] * half[k] for k in (0, 1)]) for corner in corners]})
        rectangle["inner_regions"] = inner
    return {"rectangle": rectangle}


def tissue_of(draw, regions, is_explicit):
    modulus = draw.log(6e3, 300e3)
    tissue = {"plane": draw.choice(["stress", "stress", "strain"]),
              "thickness": length(draw.choice([0.01, 0.01, draw.log(0.005, 0.02)]))}
    nu = draw.choice([0.3, 0.4, 0.45, 0.49, 0.49, draw.uniform(0, 0.495)])
    if draw.chance(0.2) and not is_explicit:
        nu = 0.499
    density = draw.choice([1000, 1000, 1060, draw.log(300, 3000)])
    if draw.chance(0.15):
        tissue["formulation"] = draw.choice(["p1", "p1_averaged"])
    if draw.chance(0.15):
        tissue["mass"] = "lumped"
    tissue["regions"] = {}
    for i, region in enumerate(regions):
        factor = draw.choice([1, draw.log(0.3, 5)]) if i > 0 else 1
        tissue["regions"][region] = {"youngs_modulus": f"{factor * modulus / 1e3:.5g} kPa",
                                     "poisson_ratio": round(nu, 4),
                                     "density": f"{density:.5g} kg/m^3"}
    by_mass = {"mass_factor": f"{draw.log(5, 300):.4g} 1/s"}
    by_stiffness = {"stiffness_factor": f"{draw.log(0.003, 0.3):.4g} s"}
    damping = draw.choice([by_mass, by_mass, by_mass, by_mass, {}] if is_explicit else
                          [by_stiffness, by_stiffness, by_stiffness, by_mass,
                           by_mass | by_stiffness, {}])
    if damping:
        tissue["damping"] = damping
    return tissue, modulus


def cutting_of(draw, law, modulus, thickness, element):
    # The force that moves the skin by some millimetres (F / (E t) is 2.8 mm in the reference
    # scene), or, now and then, anything.
    cutting_force = (modulus * thickness * draw.log(6e-4, 1e-2) if draw.chance(0.9)
                     else draw.log(0.2, 10))
    cutting = {"cutting_force": force(cutting_force)}
    if law or draw.chance(0.5):
        cutting["law"] = law or "consistent"
    if draw.chance(0.85):
        cutting["tip_length"] = length(element * draw.log(0.4, 8))
    if draw.chance(0.2):
        cutting["sharpness"] = round(draw.uniform(0.5, 1), 2)
    if draw.chance(0.15):
        cutting |= {"stiffness_share": round(draw.uniform(0.1, 1), 2),
                    "reference_youngs_modulus": f"{modulus * draw.log(0.7, 1.5) / 1e3:.5g} kPa"}
    return cutting, cutting_force


def friction_of(draw, cutting_force):
    static = draw.log(20, 350) * cutting_force / 1.7
    stick = draw.log(1e-4, 5e-3)
    return {"static_force": f"{static:.5g} N/m",
            "kinetic_force": f"{draw.uniform(0.4, 1) * static:.5g} N/m",
            "stick_speed": f"{1e3 * stick:.4g} mm/s",
            "slip_speed": f"{1e3 * draw.uniform(1.2, 2) * stick:.4g} mm/s"}


def viscosity_of(draw, friction, speed):
    kinetic = float(friction["kinetic_force"].split()[0])
    return f"{draw.log(0.1, 3) * kinetic / speed:.5g} N s/m^2"


class Motion:
    """Actions of a needle, with what they need elsewhere in the scene."""

    def __init__(self, draw, path, speed, targets):
        self.draw, self.path, self.speed, self.targets = draw, path, speed, targets
        self.actions, self.is_straight = [], True
        self.by_position = abs(path.angle - math.pi) < 1e-12 and draw.chance(0.5)
        self.deepest, self.shallowest = 0, math.inf  # of the way; of the seeds

    def _to(self, verb, depth):
        end = ({"position": length(self.path.entry[0] - depth)} if self.by_position
               else {"depth": length(depth)})
        self.actions.append({verb: {"speed": f"{1e2 * self.speed:.5g} cm/s"} | end})
        self.deepest = max(self.deepest, depth)

    def insert(self, depth):
        self._to("insert", depth)

    def back(self, depth):
        self._to("retract", depth)
        self.is_straight = False

    def implant(self, depth):
        name = f"t{len(self.targets) + 1}"
        self.targets[name] = lengths(self.path.at(depth))
        self.shallowest = min(self.shallowest, depth)
        self.actions.append({"implant": {"target": name}})

    def hold(self):
        self.actions.append({"hold": {"duration": f"{self.draw.log(0.02, 0.5):.3g} s"}})

    def out(self, damped):
        self.actions.append({"retract": {"speed": f"{1e2 * self.speed:.5g} cm/s"}})
        rest = {"speed_tolerance": "1e-6 m/s"} if self.draw.chance(0.2) else None
        self.actions.append({"settle": rest or {}} if damped else
                            {"settle": {"duration": "0.2 s"}})


def motion_of(draw, path, speed, targets, damped, is_last, element):
    depth = path.through * (draw.uniform(0.1, DEEPEST) if draw.chance(0.75)
                            else draw.log(0.02, DEEPEST))
    depth = max(depth, min(WITHIN_FIRST_CUT * element, DEEPEST * path.through))
    motion = Motion(draw, path, speed, targets)
    kind = draw.choice(["plain", "plain", "plain", "hold", "ends", "ends", "way_out", "deeper",
                        "again", "none"])
    if kind == "again":
        motion.insert(0.6 * depth)
        motion.back(0.2 * depth)
    if kind == "deeper":
        motion.insert(0.5 * depth)
        motion.implant(0.5 * depth)
    motion.insert(depth)
    if kind == "hold":
        motion.hold()
    if kind != "none":
        motion.implant(depth)
    if kind == "way_out":
        motion.back(0.4 * depth)
        motion.implant(0.4 * depth)
    if kind not in ("ends", "none") or not is_last:  # the next needle enters when this one is out
        motion.out(damped)
    if kind == "none":
        motion.hold()
    return motion


def membrane_of(draw, path, depth, cutting_force, regions):
    kind = draw.choice(["skin", "under", "inside"] + (["region"] if len(regions) > 1 else []))
    membrane = {"puncture_force": force(cutting_force * draw.log(0.7, 3))}
    if kind == "region":
        return {"region": regions[1]} | membrane
    begin = {"skin": 0, "under": draw.uniform(2e-4, 3e-3), "inside": draw.uniform(0.2, 0.7) * depth}
    half = draw.uniform(0.1, 0.4) * min(path.size)
    near, far = begin[kind], begin[kind] + draw.uniform(0.15, 0.5) * path.through
    corners = [(near, -half), (near, half), (far, half), (far, -half)]
    return {"polygon": [lengths(path.at(*corner)) for corner in corners]} | membrane


def conditions_of(draw, path, modulus, thickness, end):
    """Supports, loads and prescribed curves; the side of the entry stays free of supports."""
    others = [side for side in ("left", "bottom", "right", "top") if side != path.side]
    is_aligned = round(math.degrees(path.angle)) % 90 == 0
    scene = {"supports": {side: "fixed" for side in others}}
    loose = draw.choice(others)
    choice = draw.random()
    if choice < 0.15 and is_aligned:
        scene["supports"][loose] = "roller"
    elif choice < 0.3:
        del scene["supports"][loose]
    elif choice < 0.4:
        del scene["supports"][loose]
        shift = [length(draw.uniform(-1e-3, 1e-3)) for _ in (0, 1)]
        scene["prescribed"] = [{"curve": loose, "displacement": shift,
                                "start": f"{draw.uniform(0, 0.5) * end:.4g} s",
                                "ramp": f"{draw.uniform(0.05, 0.5) * end:.4g} s"}]
    elif choice < 0.5:
        scene["supports"][loose] = "free"
        traction = modulus * thickness * draw.log(1e-4, 5e-3)
        turn = draw.uniform(0, 2 * math.pi)
        scene["loads"] = {"traction": [{
            "curve": loose,
            "force": [f"{traction * f(turn):.4g} N/m" for f in (math.cos, math.sin)],
            "start": f"{draw.choice([0, draw.uniform(0, 0.7) * end]):.4g} s"}]}
    if draw.chance(0.1):
        scene.setdefault("loads", {})["body"] = [{
            "force": ["0 N/m^3", f"{-draw.log(500, 9810):.4g} N/m^3"]}]
    return scene


def add_band(draw, scene, path, grid, modulus, thickness):
    """A loaded curve inside the tissue, along the lowest inner line of the grid."""
    rectangle = scene["mesh"]["rectangle"]
    if path.side not in ("left", "right") or min(grid) < 8 or not draw.chance(0.3):
        return
    if "jitter" in rectangle or "inner_regions" in rectangle:
        return  # they move the lines of the grid
    y = path.size[1] / grid[1]
    ends = [lengths((k * path.size[0] / grid[0], y)) for k in (2, grid[0] - 2)]
    rectangle["curves"] = [{"name": "band", "points": ends}]
    pull = modulus * thickness * draw.log(1e-4, 2e-3)
    scene.setdefault("loads", {}).setdefault("traction", []).append(
        {"curve": "band", "force": ["0 N/m", f"{pull:.4g} N/m"]})


def time_of(draw, method, inserting):
    """inserting: shortest way of a needle (s)."""
    steps = draw.log(8, 400)
    time = {"method": method, "step": f"{1e3 * inserting / steps:.5g} ms"}
    if method == "implicit" and draw.chance(0.6):
        time["scheme"] = draw.choice(["backward_euler", "generalised_alpha",
                                      "average_acceleration"])
        if time["scheme"] == "generalised_alpha" and draw.chance(0.6):
            time["rho_infinity"] = draw.choice([0, 0.3, 0.5, 0.8, 0.9, 1])
    if method == "explicit" and draw.chance(0.3):
        time["safety"] = round(draw.uniform(0.5, 0.95), 2)
    return time, inserting / steps


def ends_at_rest(scene, last):
    """Whether the seeds come to rest where nothing but the tissue holds them."""
    end = last.actions[-1]
    return (not {"loads", "prescribed"} & set(scene) and
            ("implant" in end or "duration" not in end.get("settle", {"duration": "of a hold"})))


def let_in(draw, scene, motions, stiffness):
    """Weakens forces that would keep a needle out of the tissue in which it is to leave a seed."""
    cuttings = [needle["cutting"] for needle in scene["needles"]]
    # The force that a share of another modulus may add is less than this.
    needed = 1.5 * max(float(c["cutting_force"].split()[0]) / c.get("sharpness", 1)
                       for c in cuttings)
    holders = [(c, "cutting_force") for c in cuttings]
    holders += [(needle["friction"], key) for needle in scene["needles"]
                for key in ("static_force", "kinetic_force", "viscous_coefficient")
                if key in needle.get("friction", {})]
    if "membrane" in scene:
        holders.append((scene["membrane"], "puncture_force"))
        needed = max(needed, float(scene["membrane"]["puncture_force"].split()[0]))
    allowed = DENT * stiffness * min(motion.shallowest for motion in motions)
    if needed <= allowed:
        return
    factor = draw.uniform(0.3, 1) * allowed / needed
    for holder, key in holders:
        value, unit = holder[key].split(maxsplit=1)
        holder[key] = f"{factor * float(value):.5g} {unit}"


def scene_of(seed):
    draw = Draw(f"stylet {seed}")
    method = draw.choice(["implicit"] * 5 + ["quasi_static"] * 3 + ["explicit"])
    size = (round(draw.uniform(0.04, 0.12), 4), round(draw.uniform(0.03, 0.1), 4))
    # Explicit ones follow the stable step: small meshes and quick needles keep them short.
    triangles = draw.log(100, 600 if method == "explicit" else 2000)
    element = math.sqrt(2 * size[0] * size[1] / triangles)
    grid = tuple(max(4, round(x / element)) for x in size)
    element = max(x / n for x, n in zip(size, grid))
    degrees = 180 if draw.chance(0.75) else draw.choice([0, 90, 270, 180 + draw.uniform(-20, 20)])
    scene = {"mesh": mesh_of(draw, size, grid)}
    regions = ["tissue"] + [r["name"] for r in scene["mesh"]["rectangle"].get("inner_regions", [])]
    tissue, modulus = tissue_of(draw, regions, method == "explicit")
    scene["tissue"] = tissue
    thickness = 1e-3 * float(tissue["thickness"].split()[0])
    damped = method == "quasi_static" or (method == "implicit" and "damping" in tissue)

    shares = [draw.uniform(0.3, 0.7)]
    if draw.chance(0.2):
        shares.append(shares[0] if draw.chance(0.3) else draw.uniform(0.2, 0.8))
    law = draw.choice(["lagged", "lagged", "increment"] if method == "explicit" else
                      ["", "", "", "", "lagged", "increment"])
    speed = draw.log(0.02 if method == "explicit" else 0.004, 0.1)
    cutting, cutting_force = cutting_of(draw, law, modulus, thickness, element)
    friction = friction_of(draw, cutting_force) if draw.chance(0.6) else None
    later = Draw(f"stylet viscosity {seed}")
    if friction and seed > KEPT and later.chance(0.4):
        friction["viscous_coefficient"] = viscosity_of(later, friction, speed)
    needles, targets, paths, motions = [], {}, [], []
    for i, share in enumerate(shares):
        paths.append(Path(size, degrees, share))
        motions.append(motion_of(draw, paths[-1], speed, targets, damped, i + 1 == len(shares),
                                 element))
        needles.append({"name": f"n{i + 1}", "height": length(paths[-1].height),
                        "cutting": dict(cutting)})
        if "tip_length" in cutting:  # longer than its way, a tip is refused
            tip = min(1e-3 * float(cutting["tip_length"].split()[0]), 0.99 * paths[-1].through)
            needles[-1]["cutting"]["tip_length"] = length(tip)
        if i > 0 and draw.chance(0.4):
            needles[-1]["cutting"]["cutting_force"] = force(draw.uniform(0.7, 1.3) * cutting_force)
        if friction:
            needles[-1]["friction"] = dict(friction)
        needles[-1]["motion"] = motions[-1].actions
    inserting = min(m.deepest for m in motions) / speed
    time, step = time_of(draw, method, inserting)
    if law == "increment":
        least = speed * step if method != "explicit" else element / 40
        for needle in needles:
            needle["cutting"]["increment"] = length(least * draw.uniform(1.05, 2))
    scene |= conditions_of(draw, paths[0], modulus, thickness, inserting)
    add_band(draw, scene, paths[0], grid, modulus, thickness)
    if draw.chance(0.35):
        scene["membrane"] = membrane_of(draw, paths[0], motions[0].deepest, cutting_force, regions)
    if degrees != 180:
        scene["needle_angle"] = f"{math.radians(degrees):.15g} rad"
    scene["needles"] = needles
    if targets:
        scene["targets"] = targets
    if draw.chance(0.1):
        scene["probes"] = {"p": lengths((0.5 * size[0], 0.5 * size[1]))}
    if (targets and all(m.is_straight for m in motions) and ends_at_rest(scene, motions[-1])
            and draw.chance(0.5)):
        time["until"] = "implanted"
    scene["time"] = time
    let_in(draw, scene, motions, modulus * thickness)
    return scene, {"paths": paths, "element": element, "step": step, "speed": speed,
                   "inserting": inserting}


def yaml(value, indent=0):
    """Block style, lists of plain values in flow style."""
    pad = "  " * indent
    lines = []
    for key, item in value.items():
        if item == {}:
            lines.append(f"{pad}{key}: {{}}")
        elif isinstance(item, dict):
            lines += [f"{pad}{key}:", yaml(item, indent + 1)]
        elif isinstance(item, list) and any(isinstance(x, dict) for x in item):
            lines.append(f"{pad}{key}:")
            for x in item:
                text = yaml(x, indent + 2) if isinstance(x, dict) else f"{pad}    {x}"
                lines.append(f"{pad}  - " + text[len(pad) + 4:])
        elif isinstance(item, list):
            lines.append(f"{pad}{key}: " + str(item).replace("'", ""))
        else:
            lines.append(f"{pad}{key}: {item}")
    return "\n".join(lines)
