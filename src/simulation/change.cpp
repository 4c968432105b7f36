#include "stylet/simulation/change.hpp"

#include "stylet/base/errors.hpp"

namespace stylet {

bool Simulation::change(const std::string& key, double /*value*/) {
  throw InputError("key '" + key + "': does not change in mid-run");
}

std::vector<Changeable> changeable(const Simulation& /*simulation*/) {
  return {};
}

}  // namespace stylet
