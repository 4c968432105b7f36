#include "cases.hpp"

#include <algorithm>
#include <random>

namespace stylet::robustness {

namespace {

constexpr double speed = 0.02;  // m/s

Action to_depth(ActionKind kind, double depth) {
  Action a;
  a.kind = kind;
  a.speed = speed;
  a.depth = std::max(depth, 0.0);
  return a;
}
Action insert(double depth) {
  return to_depth(ActionKind::insert, depth);
}
Action retract(double depth) {
  return to_depth(ActionKind::retract, depth);
}

Action plain(ActionKind kind, double duration = 0) {
  Action a;
  a.kind = kind;
  if (kind == ActionKind::retract) a.speed = speed;
  if (duration > 0) a.duration = duration;
  if (kind == ActionKind::implant) a.target = "target";
  return a;
}

std::vector<Action> motion(const Case& what) {
  const double d = what.depth;
  const double e = what.mesh.size;
  const Action out = plain(ActionKind::retract);
  const Action seed = plain(ActionKind::implant);
  const Action rest = plain(ActionKind::settle, 0.1);
  switch (what.motion) {
    case MotionKind::straight:
      return {insert(d), seed, out, rest};
    case MotionKind::reversals:
      return {insert(0.37 * d),
              retract(0.31 * d),
              insert(0.62 * d),
              retract(0.2 * d),
              insert(0.81 * d),
              retract(0.79 * d),
              insert(d),
              seed,
              out,
              rest};
    case MotionKind::shiver: {
      std::vector<Action> actions{insert(0.4 * d)};
      for (int i = 0; i < 6; ++i) {
        const double deepest = 0.4 * d + 0.3 * i * e;
        actions.push_back(retract(deepest - 0.5 * e));
        actions.push_back(insert(deepest + 0.3 * e));
      }
      actions.insert(actions.end(), {seed, out, rest});
      return actions;
    }
    case MotionKind::tiny:
      return {insert(0.01 * e),
              out,
              insert(0.02 * e),
              plain(ActionKind::hold, 0.1),
              insert(0.3 * e),
              out,
              insert(0.5 * d),
              seed,
              out,
              insert(0.6 * d),
              out,
              rest};
    case MotionKind::holds:
      return {insert(0.5 * d),
              plain(ActionKind::hold, 0.2),
              insert(0.52 * d),
              plain(ActionKind::hold, 0.1),
              retract(0.5 * d),
              plain(ActionKind::hold, 0.1),
              insert(d),
              plain(ActionKind::hold, 0.1),
              seed,
              out,
              rest};
    case MotionKind::seeds:
      break;
  }
  return {insert(d), seed, retract(0.7 * d), seed, retract(0.35 * d), seed, insert(1.1 * d), seed,
          out,       rest};
}

}  // namespace

const char* name_of(MotionKind kind) {
  switch (kind) {
    case MotionKind::straight:
      return "straight";
    case MotionKind::reversals:
      return "reversals";
    case MotionKind::shiver:
      return "shiver";
    case MotionKind::tiny:
      return "tiny";
    case MotionKind::holds:
      return "holds";
    case MotionKind::seeds:
      break;
  }
  return "seeds";
}

const char* name_of(TimeMethod method) {
  switch (method) {
    case TimeMethod::implicit_newmark:
      return "implicit";
    case TimeMethod::explicit_newmark:
      return "explicit";
    case TimeMethod::quasi_static:
      break;
  }
  return "quasi-static";
}

Scene scene_of(const Case& what) {
  Scene scene;
  scene.file = what.name;
  scene.mesh = what.mesh.mesh;
  scene.tissue.plane = Plane::stress;
  constexpr double youngs_modulus = 60e3;
  for (const auto& region : what.mesh.regions) {
    const double factor = region == "tissue" ? 1 : what.mesh.contrast;
    scene.tissue.regions.push_back({region, {factor * youngs_modulus, what.poisson_ratio, 1000}});
  }
  const bool is_explicit = what.method == TimeMethod::explicit_newmark;
  if (is_explicit) {
    scene.tissue.mass = MassKind::lumped;
    scene.tissue.damping = RayleighDamping{100, 0};
  } else {
    scene.tissue.damping = RayleighDamping{0, 0.05};
  }
  for (const char* side : {"left", "top", "bottom"}) {
    scene.supports.push_back({side, SupportKind::fixed});
  }
  for (std::size_t i = 0; i < what.heights.size(); ++i) {
    NeedleParameters needle;
    needle.name = "needle" + std::to_string(i + 1);
    needle.height = what.heights[i];
    needle.cutting.law = is_explicit ? CuttingLaw::lagged : what.law;
    needle.cutting.cutting_force = what.cutting_force;
    needle.cutting.tip_length = what.tip_length;
    needle.cutting.increment = 0.25 * what.mesh.size;
    if (what.friction) needle.friction = FrictionParameters{195, 130, 1e-3, 1.5e-3};
    needle.motion = motion(what);
    scene.needles.push_back(needle);
  }
  if (what.membrane) {
    MembraneParameters membrane;
    membrane.region = "inner";
    membrane.puncture_force = 1.5 * what.cutting_force;
    scene.membrane = membrane;
  }
  scene.targets.push_back({"target", {0.035, 0.032}});
  scene.time.method = what.method;
  scene.time.step = what.step;
  scene.output.history = false;
  return scene;
}

namespace {

bool has_region(const NamedMesh& mesh, const std::string& name) {
  return std::ranges::find(mesh.regions, name) != mesh.regions.end();
}

/// Rows of the grid, or 0 for a mesh from a file.
int rows_of(const NamedMesh& mesh) {
  const auto* grid = std::get_if<RectangleMesh>(&mesh.mesh.source);
  return grid != nullptr ? grid->rows : 0;
}

class Cases {
 public:
  void add(Case what) {
    what.name = what.mesh.name;
    cases_.push_back(std::move(what));
  }
  [[nodiscard]] std::vector<Case> take() { return std::move(cases_); }

 private:
  std::vector<Case> cases_;
};

constexpr MotionKind all_motions[] = {MotionKind::straight, MotionKind::reversals,
                                      MotionKind::shiver,   MotionKind::tiny,
                                      MotionKind::holds,    MotionKind::seeds};

/// Every motion at a random height, point and distributed tip in turn.
void add_random(Cases& cases, const NamedMesh& mesh, std::mt19937& random, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < std::size(all_motions); ++i) {
      Case c;
      c.mesh = mesh;
      constexpr double margin = 0.006;
      const double share = static_cast<double>(random()) / static_cast<double>(random.max());
      c.heights = {margin + share * (tissue_height - 2 * margin)};
      c.motion = all_motions[i];
      c.method = (i + static_cast<std::size_t>(round)) % 3 == 1 ? TimeMethod::implicit_newmark
                                                                : TimeMethod::quasi_static;
      c.tip_length = (i / 2 + static_cast<std::size_t>(round)) % 2 == 0 ? 0.006 : 0;
      c.membrane = i % 2 == 1 && has_region(mesh, "inner");
      cases.add(c);
    }
  }
}

/// The needle on a line of nodes, halfway between two, a hair beside one, and next to the skin's
/// corners.
void add_heights(Cases& cases, const NamedMesh& mesh) {
  const int rows = rows_of(mesh);
  if (rows == 0) return;
  const double dy = tissue_height / rows;
  const double line = (rows / 2) * dy;
  for (const double height : {line, line + 0.5 * dy, line + 1e-9, line + 1e-4 * dy, 0.01 * dy,
                              0.3 * dy, 0.5 * dy, 0.8 * dy, 1.2 * dy, tissue_height - 0.6 * dy}) {
    Case c;
    c.mesh = mesh;
    c.heights = {height};
    c.may_be_refused = height == 0.01 * dy;
    cases.add(c);
  }
}

/// Outlines of regions: tangent to the ellipse, through its ends, along the corners of the polygon.
void add_outlines(Cases& cases, const NamedMesh& mesh) {
  if (!has_region(mesh, "inner")) return;
  for (const double height : {0.0172, 0.043, 0.0428, 0.03, 0.02, 0.0201, 0.042, 0.0085}) {
    Case c;
    c.mesh = mesh;
    c.heights = {height};
    c.membrane = true;
    c.depth = 0.06;
    cases.add(c);
  }
}

/// 3 mm apart and less: the second meets what the first one left.
void add_neighbours(Cases& cases, const NamedMesh& mesh) {
  const std::vector<std::vector<double>> rows{{0.03, 0.033, 0.036},
                                              {0.03, 0.0305, 0.0295},
                                              {0.0312, 0.0312},
                                              {0.0273, 0.0303, 0.0288, 0.0318}};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Case c;
    c.mesh = mesh;
    c.heights = rows[i];
    c.motion = i % 2 == 0 ? MotionKind::straight : MotionKind::reversals;
    c.tip_length = i < 2 ? 0.006 : 0;
    cases.add(c);
  }
}

void add_variants(Cases& cases, const NamedMesh& mesh) {
  Case base;
  base.mesh = mesh;
  base.heights = {0.0317};
  {  // several hand-overs in one step
    Case c = base;
    c.step = 0.2;
    cases.add(c);
    c.step = 0.5;
    c.tip_length = 0.006;
    c.motion = MotionKind::reversals;
    cases.add(c);
  }
  for (const CuttingLaw law : {CuttingLaw::lagged, CuttingLaw::increment}) {
    Case c = base;
    c.law = law;
    c.motion = MotionKind::reversals;
    cases.add(c);
  }
  for (const double force : {0.3, 5.0}) {
    Case c = base;
    c.cutting_force = force;
    c.depth = 0.06;
    cases.add(c);
  }
  {
    Case c = base;
    c.friction = false;
    c.motion = MotionKind::holds;
    c.method = TimeMethod::implicit_newmark;
    cases.add(c);
    c.friction = true;
    c.poisson_ratio = 0.49;
    c.tip_length = 0.006;
    c.motion = MotionKind::shiver;
    cases.add(c);
  }
}

void add_explicit(Cases& cases, const NamedMesh& mesh, double tip_length) {
  Case c;
  c.mesh = mesh;
  c.heights = {0.0287};
  c.method = TimeMethod::explicit_newmark;
  c.tip_length = tip_length;
  c.motion = MotionKind::reversals;
  c.depth = 0.03;
  cases.add(c);
}

}  // namespace

std::vector<Case> random_cases(const std::vector<NamedMesh>& meshes, int n, unsigned seed) {
  Cases cases;
  std::mt19937 random(seed);
  const auto share = [&] {
    return static_cast<double>(random()) / static_cast<double>(random.max());
  };
  const auto one_of = [&](auto... values) {
    const std::common_type_t<decltype(values)...> list[] = {values...};
    return list[random() % sizeof...(values)];
  };
  while (n > 0) {
    Case c;
    c.mesh = meshes[random() % meshes.size()];
    if (c.mesh.size < 1.5e-3) continue;
    --n;
    double height = 0.002 + 0.056 * share();
    const int needles = one_of(1, 1, 1, 2, 3, 5);
    for (int i = 0; i < needles; ++i) {
      c.heights.push_back(height);
      // The next one beside it, on the same line or somewhere.
      height = one_of(height, height + 0.006 * (share() - 0.5), 0.002 + 0.056 * share());
      height = std::clamp(height, 0.001, 0.059);
    }
    c.motion = all_motions[random() % std::size(all_motions)];
    c.method =
        one_of(TimeMethod::quasi_static, TimeMethod::quasi_static, TimeMethod::implicit_newmark);
    c.tip_length = one_of(0.0, 0.002, 0.006, 0.015);
    c.law = one_of(CuttingLaw::consistent, CuttingLaw::consistent, CuttingLaw::lagged,
                   CuttingLaw::increment);
    c.friction = random() % 4 != 0;
    c.membrane = has_region(c.mesh, "inner") && random() % 2 == 0;
    c.step = one_of(0.01, 0.04, 0.15, 0.6);
    c.depth = 0.01 + 0.055 * share();
    c.cutting_force = one_of(0.1, 0.5, 1.7, 4.0, 8.0);
    c.poisson_ratio = one_of(0.3, 0.45, 0.495);
    c.may_be_refused = true;  // nobody has looked at it before
    cases.add(c);
  }
  return cases.take();
}

std::vector<Case> quick_cases(const std::vector<NamedMesh>& meshes) {
  Cases cases;
  std::mt19937 random(1);
  for (std::size_t i = 0; i < 6 && i < meshes.size(); ++i) {
    add_random(cases, meshes[i], random, 1);
    add_outlines(cases, meshes[i]);
  }
  add_heights(cases, meshes[0]);
  add_neighbours(cases, meshes[2]);
  add_variants(cases, meshes[3]);
  return cases.take();
}

std::vector<Case> full_cases(const std::vector<NamedMesh>& meshes) {
  Cases cases;
  std::mt19937 random(2003);
  for (const auto& mesh : meshes) {
    const bool small = mesh.size > 0.0024;
    const bool large = mesh.size < 0.0012;
    add_random(cases, mesh, random, small ? 3 : 1);
    if (!large) add_heights(cases, mesh);
    if (!large) add_outlines(cases, mesh);
    if (!large) add_neighbours(cases, mesh);
    if (!large) add_variants(cases, mesh);
  }
  add_explicit(cases, meshes[2], 0.006);
  add_explicit(cases, meshes[4], 0.006);
  add_explicit(cases, meshes[5], 0);
  return cases.take();
}

}  // namespace stylet::robustness
