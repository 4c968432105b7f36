#include "stylet/simulation/change.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/base/units.hpp"
#include "stylet/scene/check.hpp"
#include "stylet/scene/schema.hpp"

#include <algorithm>
#include <cmath>

namespace stylet {

namespace {

/// What a change reaches.
enum class Reach { hand, needle, membrane, damping, tissue };

/// The row of the schema that a key has its range from, and the number itself.
struct Place {
  std::string key;
  std::string row;
  Reach reach;
  double value = 0;
  double* at = nullptr;
};

struct Numbers {
  NeedleParameters needle;
  TissueParameters tissue;
  std::optional<MembraneParameters> membrane;
};

void add_needle(NeedleParameters& needle, std::vector<Place>& places) {
  const auto add = [&](const std::string& name, double& number) {
    places.push_back({"needle." + name, "needles[]." + name, Reach::needle, number, &number});
  };
  add("cutting.cutting_force", needle.cutting.cutting_force);
  add("cutting.sharpness", needle.cutting.sharpness);
  if (!needle.friction) return;
  add("friction.static_force", needle.friction->static_force);
  add("friction.kinetic_force", needle.friction->kinetic_force);
}

/// All that may change, in copies of what holds them.
std::vector<Place> places(const Simulation& simulation, Numbers& numbers) {
  const Scene& scene = simulation.scene();
  numbers.tissue = scene.tissue;
  numbers.membrane = scene.membrane;
  std::vector<Place> found;
  const auto add = [&](const std::string& key, const std::string& row, Reach reach,
                       double& number) {
    found.push_back({key, row, reach, number, &number});
  };
  if (const Needle* needle = simulation.needle(); needle != nullptr) {
    numbers.needle = needle->parameters();
    add_needle(numbers.needle, found);
  }
  if (const auto limit = simulation.hand().speed_limit()) {
    found.push_back({"hand.speed_limit", "needles[].motion[].insert.speed", Reach::hand, *limit});
  }
  if (numbers.membrane) {
    add("membrane.puncture_force", "membrane.puncture_force", Reach::membrane,
        numbers.membrane->puncture_force);
  }
  // What a track in space adds in closed form is of the tissue that it was made in.
  const bool has_tracks = scene.dim() == 3 && simulation.pierces();
  for (auto& region : numbers.tissue.regions) {
    if (has_tracks) break;
    add(below("tissue.regions", region.region) + ".youngs_modulus",
        "tissue.regions.REGION.youngs_modulus", Reach::tissue, region.material.youngs_modulus);
  }
  const TimeMethod method = scene.time.method;
  if (method == TimeMethod::quasi_static) return found;  // nothing damps
  if (!numbers.tissue.damping) numbers.tissue.damping.emplace();
  add("tissue.damping.mass_factor", "tissue.damping.mass_factor", Reach::damping,
      numbers.tissue.damping->mass_factor);
  if (method == TimeMethod::explicit_newmark) return found;  // its step would shrink
  add("tissue.damping.stiffness_factor", "tissue.damping.stiffness_factor", Reach::damping,
      numbers.tissue.damping->stiffness_factor);
  return found;
}

const Key& key_of(const std::string& row) {
  static const auto rows = schema_rows();
  return *std::ranges::find(rows, row, &SchemaRow::path)->key;
}

/// Throws InputError where the key is none of them, or the value is not allowed.
std::vector<Place>::const_iterator find_place(const std::vector<Place>& all,
                                              const std::string& key,
                                              double value) {
  const auto found = std::ranges::find(all, key, &Place::key);
  if (found == all.end()) {
    std::vector<std::string> names;
    for (const Place& place : all) names.push_back(place.key);
    throw InputError("key '" + key + "': does not change in mid-run; allowed: " + join(names));
  }
  const Key& row = key_of(found->row);
  if (!std::isfinite(value) || !row.range.holds(value)) {
    throw InputError("key '" + key + "': value '" + with_unit(value, row.unit) +
                     "'; allowed: " + offer(row));
  }
  return found;
}

bool needs_operator(Reach reach, TimeMethod method) {
  return reach == Reach::tissue ||
         (reach == Reach::damping && method == TimeMethod::implicit_newmark);
}

}  // namespace

bool Simulation::change(const std::string& key, double value) {
  Numbers numbers;
  const auto all = places(*this, numbers);
  const auto found = find_place(all, key, value);
  if (found->at != nullptr) *found->at = value;
  switch (found->reach) {
    case Reach::hand:
      hand_->limit_speed(value);
      break;
    case Reach::needle:
      check_needle(scene_, numbers.needle);
      needle_->change(numbers.needle.cutting, numbers.needle.friction,
                      scene_.membrane ? scene_.membrane->puncture_force : 0, region_modulus());
      break;
    case Reach::membrane:
      scene_.membrane = numbers.membrane;
      tell_needle();
      break;
    case Reach::tissue:
      numbers.tissue.damping = scene_.tissue.damping;
      [[fallthrough]];
    case Reach::damping:
      scene_.tissue = numbers.tissue;
      body_.renew_tissue();
      tell_needle();
      break;
  }
  return needs_operator(found->reach, scene_.time.method);
}

void Simulation::tell_needle() {
  if (!needle_) return;
  const NeedleParameters& parameters = needle_->parameters();
  needle_->change(CuttingParameters(parameters.cutting),
                  std::optional<FrictionParameters>(parameters.friction),
                  scene_.membrane ? scene_.membrane->puncture_force : 0, region_modulus());
}

namespace {

std::vector<Changeable> described(const std::vector<Place>& places, TimeMethod method) {
  std::vector<Changeable> list;
  for (const Place& place : places) {
    const Key& row = key_of(place.row);
    Changeable entry;
    entry.key = place.key;
    entry.doc = place.reach == Reach::hand ? "Largest speed of the needle." : row.doc;
    entry.unit = row.unit;
    entry.value = place.value;
    entry.minimum = row.range.min;
    entry.maximum = row.range.max;
    entry.above_minimum = row.range.min_open;
    entry.below_maximum = row.range.max_open;
    entry.new_operator = needs_operator(place.reach, method);
    list.push_back(std::move(entry));
  }
  return list;
}

}  // namespace

std::vector<Changeable> changeable(const Simulation& simulation) {
  Numbers numbers;
  return described(places(simulation, numbers), simulation.scene().time.method);
}

std::vector<Changeable> changeable(NeedleParameters needle) {
  std::vector<Place> places;
  add_needle(needle, places);
  return described(places, {});
}

void change(const Scene& scene, NeedleParameters& needle, const std::string& key, double value) {
  NeedleParameters changed = needle;
  std::vector<Place> places;
  add_needle(changed, places);
  *find_place(places, key, value)->at = value;
  check_needle(scene, changed);
  needle = std::move(changed);
}

}  // namespace stylet
