// How the tissue follows its mesh where a needle rewrites it.
#include "stylet/base/errors.hpp"
#include "stylet/base/sorted.hpp"
#include "stylet/needle/local_mesh.hpp"
#include "stylet/needle/quality.hpp"
#include "stylet/petsc/log.hpp"
#include "stylet/simulation/body.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace stylet {

// The mesh alone; returns the cells that changed, ascending.
std::vector<int> Body::rewrite(const NeedleEdits& edits, const Track* repaired) {
  Mesh& mesh = numbered_.mesh;
  std::vector<int> touched = stylet::rewrite(mesh, edits);
  rewrites_.edge_flips += static_cast<long long>(edits.flips.size());
  if (repaired != nullptr) {
    rewrites_.edge_flips +=
        static_cast<long long>(repair(mesh, *repaired, touched, good_quality).size());
  }
  sort_unique(touched);
  const double worst = mesh.worst_quality(touched);
  rewrites_.worst_quality = std::min(rewrites_.worst_quality, worst);
  if (worst < quality_floor) {
    throw NumericalError("the needle would leave an element of quality " + std::to_string(worst) +
                         " (at least " + std::to_string(quality_floor) +
                         " is needed); refine the mesh or move the needle");
  }
  return touched;
}

void Body::apply(const NeedleEdits& edits, const Track* repaired) {
  static const LogEvent event("StyletEdit");
  const LogScope scope(event);
  const auto touched = rewrite(edits, repaired);
  rewritten(touched, edits.moves);
}

// Operator, state, load, energy and the points that ride along follow the mesh.
void Body::rewritten(std::span<const int> touched, std::span<const NodeEdit> moves) {
  const auto rows = tissue_->rows_of(mesh(), touched);
  integrator_->complete_at(rows);
  const double before = ledger_.within(*tissue_, rows, state_);
  for (const auto& move : moves) {
    const auto set = [&](Vec vector, Vector2 value) {
      set_owned(vector, 2 * move.node, value.x);
      set_owned(vector, 2 * move.node + 1, value.y);
    };
    set(state_.u.get(), move.state.u);
    set(state_.v.get(), move.state.v);
    set(state_.a.get(), move.state.a);
  }
  if (tissue_->update(mesh(), touched)) ++rewrites_.pattern_rebuilds;
  const auto on_skin = [&](const NodeEdit& move) { return mesh().on_boundary(move.node); };
  if (conditions_.has_body_force() || std::ranges::any_of(moves, on_skin)) update_load(load_time_);
  integrator_->touched(mesh(), touched);
  ledger_.edited(ledger_.within(*tissue_, rows, state_) - before);
  relocate(mesh(), touched, riders_);
}

void Body::put_mesh_back() {
  std::vector<NodeEdit> moves;
  std::vector<EmbeddedPoint> places;
  std::vector<int> near;
  for (int node = 0; node < mesh().n_nodes(); ++node) {
    const auto at = 2 * static_cast<std::size_t>(node);
    const ReferencePoint x{source_.coordinates[at], source_.coordinates[at + 1]};
    if (mesh().point(node) == x) continue;
    near.push_back(mesh().cells_around(node).front());
    places.push_back({x, near.back(), {}});
    moves.push_back({node, x, {}});
  }
  relocate(mesh(), near, places);
  std::vector<int> corners;
  for (const auto& place : places) {
    const auto cell = mesh().cell(place.cell);
    corners.insert(corners.end(), cell.begin(), cell.end());
  }
  sort_unique(corners);
  const NeedleView start = view(corners);
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const auto cell = mesh().cell(places[i].cell);
    for (std::size_t k = 0; k < 3; ++k) {
      const NodeState& corner = start.at(cell[k]);
      const double weight = places[i].weights[k];
      moves[i].state.u = moves[i].state.u + weight * corner.u;
      moves[i].state.v = moves[i].state.v + weight * corner.v;
      moves[i].state.a = moves[i].state.a + weight * corner.a;
    }
  }
  const auto touched = numbered_.mesh.put_back(source_);
  if (touched.empty()) return;
  rewritten(touched, moves);
}

}  // namespace stylet
