#include "stylet/mesh/mesh_data.hpp"

#include "stylet/base/index.hpp"

namespace stylet {

std::string number_in_file(const std::vector<std::int64_t>& numbers, int i) {
  const std::int64_t counted = std::int64_t{i} + 1;
  return std::to_string(numbers.empty() ? counted : numbers[at(i)]);
}

void MeshData::make_stray(const std::map<int, std::string>& fault_of_curve) {
  if (fault_of_curve.empty()) return;
  std::vector<int> new_curve(curve_names.size(), -1);
  std::vector<std::string> kept_names;
  for (std::size_t c = 0; c < curve_names.size(); ++c) {
    if (const auto fault = fault_of_curve.find(static_cast<int>(c));
        fault != fault_of_curve.end()) {
      stray_curves.push_back({curve_names[c], fault->second});
      continue;
    }
    new_curve[c] = static_cast<int>(kept_names.size());
    kept_names.push_back(curve_names[c]);
  }
  curve_names = std::move(kept_names);
  std::size_t kept = 0;
  for (std::size_t f = 0; f < facet_curve.size(); ++f) {
    const int curve = new_curve[at(facet_curve[f])];
    if (curve < 0) continue;
    for (std::size_t k = 0; k < at(dim); ++k) facets[kept * at(dim) + k] = facets[f * at(dim) + k];
    facet_curve[kept] = curve;
    if (!origin.facet_number.empty()) {
      origin.facet_number[kept] = origin.facet_number[f];
      origin.facet_place[kept] = origin.facet_place[f];
    }
    ++kept;
  }
  facets.resize(kept * at(dim));
  facet_curve.resize(kept);
}

}  // namespace stylet
