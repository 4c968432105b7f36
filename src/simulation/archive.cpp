// What a simulation is made of between two steps.
#include "stylet/geometry/archive.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/petsc/archive.hpp"
#include "stylet/simulation/recorded.hpp"
#include "stylet/simulation/recorder.hpp"
#include "stylet/simulation/simulation.hpp"

namespace stylet {

void archive(Archive& archive, MeshRewrites& rewrites) {
  auto& [edge_flips, pattern_rebuilds, worst_quality] = rewrites;
  archive("edge_flips", edge_flips);
  archive("pattern_rebuilds", pattern_rebuilds);
  archive("worst_quality", worst_quality);
}

static void archive(Archive& archive, Energies& energies) {
  auto& [kinetic, strain, dissipated, external, edits] = energies;
  archive("kinetic", kinetic);
  archive("strain", strain);
  archive("dissipated", dissipated);
  archive("external", external);
  archive("edits", edits);
}

static void archive(Archive& archive, Riders& riders) {
  auto& [first, size] = riders;
  archive("first", first);
  archive("size", size);
}

static void archive(Archive& archive, Seed& seed) {
  auto& [needle, target, time, displacement, place, tip, cutting, turned_over] = seed;
  archive("needle", needle);
  archive("target", target);
  archive("time", time);
  archive("displacement", displacement);
  archive("place", place);
  archive("tip", tip);
  archive("cutting", cutting);
  archive("turned_over", turned_over);
}

static void archive(Archive& archive, StrainPeak& peak) {
  auto& [value, time, place] = peak;
  archive("value", value);
  archive("time", time);
  archive("place", place);
}

static void archive(Archive& archive, LargestStrain& largest) {
  auto& [anywhere, widespread] = largest;
  archive("anywhere", anywhere);
  archive("widespread", widespread);
}

static void archive(Archive& archive, TurnedOver& seen) {
  auto& [triangles, area, time, first, place] = seen;
  archive("triangles", triangles);
  archive("area", area);
  archive("time", time);
  archive("first", first);
  archive("place", place);
}

static void archive(Archive& archive, Pushing& pushing) {
  auto& [needle, duration, shortest, furthest] = pushing;
  archive("needle", needle);
  archive("duration", duration);
  archive("shortest", shortest);
  archive("furthest", furthest);
}

static void archive(Archive& archive, RunCounts& counts) {
  auto& [steps, sub_steps, passes, iterations, edge_flips, pattern_rebuilds, worst_quality,
         stable_step, peak_needle_force, tip_excess, largest_aside, needle] = counts;
  archive("steps", steps);
  archive("sub_steps", sub_steps);
  archive("passes", passes);
  archive("iterations", iterations);
  archive("edge_flips", edge_flips);
  archive("pattern_rebuilds", pattern_rebuilds);
  archive("worst_quality", worst_quality);
  archive("stable_step", stable_step);
  archive("peak_needle_force", peak_needle_force);
  archive("tip_excess", tip_excess);
  archive("largest_aside", largest_aside);
  archive("needle", needle);
}

void EnergyLedger::archive(Archive& archive) {
  archive("swing", swing_);
  archive("swing_time", swing_time_);
  archive("unchecked", unchecked_);
  archive("checks", checks_);
  archive("largest", largest_);
  archive("worst_excess", worst_excess_);
  archive("energies", energies_);
}

void Settling::archive(Archive& archive) {
  archive("block", block_);
  archive("step", step_);
  archive("first_half", first_half_);
  archive("second_half", second_half_);
  archive("hopeless_blocks", hopeless_blocks_);
}

void Schedule::archive(Archive& archive) {
  double duration = duration_;
  archive("n_entered", n_entered_);
  archive("last_seed_left", last_seed_left_);
  archive("duration", duration);
  if (archive.loads() && n_entered_ > 0) motion_ = Motion(needles_.at(n_entered_ - 1).motion);
  const bool waits = archive.loads() && n_entered_ == 0 && !needles_.empty();
  Motion clock({Action{}});  // of a scene without needles that has gone before
  archive("motion", waits ? clock : motion_);
  // The end may be another one now.
  if (!until_implanted_) last_seed_left_ = false;
  const bool no_more = n_entered_ == needles_.size() && n_entered_ > 0 && !motion_.will_implant();
  const bool implants = !motion_.finished() && motion_.action().kind == ActionKind::implant;
  if (archive.loads() && until_implanted_ && no_more && !implants && !last_seed_left_) {
    throw InputError(
        "key 'time.until': is implanted, and the state is one after the last seed was left; begin "
        "anew with --force, or leave it as it was");
  }
  // More needles or seeds may follow now.
  if (archive.loads()) last_seed_left_ = last_seed_left_ && no_more && !implants;
  if (needles_.empty() && duration != duration_) motion_.change_end(duration);
  archive("settling", settling_);
  archive("ended", ended_);
}

void LiveHand::Ordered::archive(Archive& archive) {
  archive("kind", kind);
  archive("needle", needle);
  archive("target", target);
  archive("key", key);
  archive("value", value);
}

void LiveHand::archive(Archive& archive) {
  std::vector<Ordered> orders(orders_.begin(), orders_.end());
  archive("orders", orders);
  orders_.assign(orders.begin(), orders.end());
  archive("speed", speed_);
  archive("most", most_);
  archive("tip", tip_);
  archive("ended", ended_);
  archive("n_entered", n_entered_);
}

// The rows are read again from their file.
void Recorded::archive(Archive& archive) {
  const std::string here = fingerprint_of(rows_);
  std::string stored = here;
  archive("rows", stored);
  archive("at", at_);
  archive("elapsed", elapsed_);
  archive("tip", tip_);
  archive("ended", ended_);
  if (stored == here && at_ <= rows_.size()) return;
  throw InputError(
      "key 'procedure.file': its rows are not those when the state was stored; put the file back, "
      "or begin anew with --force");
}

static void archive(Archive& archive, RayleighDamping& damping) {
  auto& [mass_factor, stiffness_factor] = damping;
  archive("mass_factor", mass_factor);
  archive("stiffness_factor", stiffness_factor);
}

// Numbers that Simulation::change sets; the needle has its own.
static void archive_changes(Archive& archive, Scene& scene) {
  for (auto& region : scene.tissue.regions) {
    archive("youngs_modulus", region.material.youngs_modulus);
  }
  archive("damping", scene.tissue.damping);
  if (scene.membrane) archive("puncture_force", scene.membrane->puncture_force);
}

void Simulation::archive(Archive& archive) {
  archive_changes(archive, scene_);
  archive("body", body_);
  bool in = needle_.has_value();
  archive("has_needle", in);
  if (in) {
    NeedleParameters parameters = archive.loads() ? NeedleParameters{} : needle_->parameters();
    archive("parameters", parameters);
    if (archive.loads()) {
      make_needle(parameters, {});
    }
    archive("needle", *needle_);
  } else {
    needle_.reset();
  }
  archive("hand", *hand_);
  archive("seeds", seeds_);
  archive("counts", counts_);
  archive("earlier_needles", earlier_needles_);
  archive("largest_tip_force", largest_tip_force_);
  archive("last_friction", last_friction_);
  archive("next_strain", next_strain_);
  archive("largest_strain", largest_strain_);
  archive("turned_over", turned_over_);
  archive("turned_over_now", turned_over_now_);
  archive("since_entered", since_entered_);
  archive("entered", entered_);
  archive("pushings", pushings_);
  archive("started", started_);
  // Whether it is done is for the hand to say: the end may be another one now.
  if (archive.loads()) done_ = false;
}

void RecorderPlace::archive(Archive& archive) {
  archive("history", history);
  archive("snapshots", snapshots);
}

Archive::Columns Simulation::store() {
  SourceOrder order;
  order.dim = mesh().dim();
  order.nodes.resize(numbered().new_of_old_node.size());
  for (std::size_t i = 0; i < order.nodes.size(); ++i) {
    order.nodes[static_cast<std::size_t>(numbered().new_of_old_node[i])] = static_cast<int>(i);
  }
  order.cells = numbered().old_cell_of_new;
  Archive stored(std::move(order));
  archive(stored);
  return stored.columns();
}

void Simulation::restore(Archive::Columns columns) {
  SourceOrder order;
  order.dim = mesh().dim();
  order.nodes = numbered().new_of_old_node;
  order.cells.resize(numbered().old_cell_of_new.size());
  for (std::size_t i = 0; i < order.cells.size(); ++i) {
    order.cells[static_cast<std::size_t>(numbered().old_cell_of_new[i])] = static_cast<int>(i);
  }
  Archive stored(std::move(order), std::move(columns));
  archive(stored);
  stored.finish();
}

}  // namespace stylet
