// Materials of the tissue's cells: by region, mixed where edits took cells across boundaries, and
// changed in mid-run.
#include "stylet/base/errors.hpp"
#include "stylet/fem/material.hpp"
#include "stylet/fem/tissue_operator.hpp"

#include <utility>

namespace stylet {

void TissueOperator::take_materials(const Mesh& mesh) {
  std::vector<bool> given(mesh.data().region_names.size(), false);
  std::vector<CellMaterial> by_region(given.size());
  bool uniform = true;
  for (const auto& [region, elastic] : parameters_.regions) {
    const auto index = static_cast<std::size_t>(mesh.region_index(region));
    by_region[index] = {moduli_of(elastic, parameters_.plane), elastic.density};
    given[index] = true;
    const auto& first = parameters_.regions.front().material;
    uniform = uniform && elastic.youngs_modulus == first.youngs_modulus &&
              elastic.poisson_ratio == first.poisson_ratio && elastic.density == first.density;
  }
  for (std::size_t r = 0; r < given.size(); ++r) {
    if (!given[r]) {
      throw InputError(mesh.data().source + ": region '" + mesh.data().region_names[r] +
                       "' of the mesh has no material in tissue.regions");
    }
  }
  by_region_ = std::move(by_region);
  uniform_ = uniform;
}

TissueOperator::CellMaterial TissueOperator::material(int cell) const {
  if (const auto mixed = mixed_.find(cell); mixed != mixed_.end()) return mixed->second;
  return by_region_[static_cast<std::size_t>(cell_region_[static_cast<std::size_t>(cell)])];
}

Moduli TissueOperator::moduli(int cell) const {
  return material(cell).moduli;
}
double TissueOperator::density(int cell) const {
  return material(cell).density;
}

void TissueOperator::remix(const Mesh& mesh, std::span<const int> cells) {
  if (!region_map_) return;
  rewritten_.insert(cells.begin(), cells.end());
  if (uniform_) return;
  for (const int cell : cells) {
    CellMaterial mean{};
    for (const auto& [region, share] : region_map_->shares(mesh, cell)) {
      const auto& part = by_region_[static_cast<std::size_t>(region)];
      mean.moduli.lambda += share * part.moduli.lambda;
      mean.moduli.mu += share * part.moduli.mu;
      mean.density += share * part.density;
    }
    mixed_[cell] = mean;
  }
}

void TissueOperator::change(const Mesh& mesh, const TissueParameters& parameters) {
  const TissueParameters before = std::exchange(parameters_, parameters);
  try {
    take_materials(mesh);
  } catch (const InputError&) {
    parameters_ = before;
    throw;
  }
  mixed_.clear();
  remix(mesh, std::vector<int>(rewritten_.begin(), rewritten_.end()));
  fill_all(mesh);
}

void TissueOperator::renew(const Mesh& mesh,
                           const TissueParameters& parameters,
                           std::span<const int> rewritten,
                           std::function<bool(int)> needs_flips) {
  parameters_ = parameters;
  needs_flips_ = std::move(needs_flips);
  take_materials(mesh);
  mixed_.clear();
  rewritten_.clear();
  remix(mesh, rewritten);
  columns_of_.reset();
  tangent_ = {};
  tangent_combination_ = {};
  make_pattern(mesh);
}

}  // namespace stylet
