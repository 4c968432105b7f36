// What a needle is made of between two steps.
#include "stylet/geometry/archive.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/needle/cut_path.hpp"
#include "stylet/needle/embedded_path.hpp"
#include "stylet/needle/needle.hpp"

namespace stylet {

void archive(Archive& archive, CuttingParameters& parameters) {
  auto& [law, force, sharpness, share, reference, tip_length, increment] = parameters;
  archive("law", law);
  archive("cutting_force", force);
  archive("sharpness", sharpness);
  archive("stiffness_share", share);
  archive("reference_youngs_modulus", reference);
  archive("tip_length", tip_length);
  archive("increment", increment);
}

static void archive(Archive& archive, FrictionParameters& parameters) {
  auto& [static_force, kinetic_force, stick_speed, slip_speed, viscous_coefficient] = parameters;
  archive("static_force", static_force);
  archive("kinetic_force", kinetic_force);
  archive("stick_speed", stick_speed);
  archive("slip_speed", slip_speed);
  archive("viscous_coefficient", viscous_coefficient);
}

static void archive(Archive& archive, Action& action) {
  auto& [kind, speed, depth, position, duration, speed_tolerance, target] = action;
  archive("kind", kind);
  archive("speed", speed);
  archive("depth", depth);
  archive("position", position);
  archive("duration", duration);
  archive("speed_tolerance", speed_tolerance);
  archive("target", target);
}

static void archive(Archive& archive, Components& components) {
  auto& [x, y, z] = components;
  archive("x", x);
  archive("y", y);
  archive("z", z);
}

static void archive(Archive& archive, SpaceParameters& parameters) {
  auto& [entry, target, direction, kernel_radius, segment] = parameters;
  archive("entry", entry);
  archive("target", target);
  archive("direction", direction);
  archive("kernel_radius", kernel_radius);
  archive("segment", segment);
}

void archive(Archive& archive, NeedleParameters& parameters) {
  auto& [name, height, diameter, space, cutting, friction, motion] = parameters;
  archive("name", name);
  archive("height", height);
  archive("diameter", diameter);
  archive("space", space);
  archive("cutting", cutting);
  archive("friction", friction);
  archive("motion", motion);
}

void archive(Archive& archive, NeedleCounts& counts) {
  auto& [hand_overs, fallbacks, punctures] = counts;
  archive("hand_overs", hand_overs);
  archive("fallbacks", fallbacks);
  archive("punctures", punctures);
}

void archive(Archive& archive, TipStand& stand) {
  auto& [lag, force, needed, element, at_membrane, since_puncture] = stand;
  archive("lag", lag);
  archive("force", force);
  archive("needed", needed);
  archive("element", element);
  archive("at_membrane", at_membrane);
  archive("since_puncture", since_puncture);
}

static void archive(Archive& archive, EarlierCuts& cuts) {
  auto& [paths, punctures] = cuts;
  archive("paths", paths);
  archive("punctures", punctures);
}

static void archive(Archive& archive, NeedleTissue& tissue) {
  auto& [membrane, surface, puncture_force, region_modulus, earlier] = tissue;
  archive("membrane", membrane);
  archive("puncture_force", puncture_force);
  archive("region_modulus", region_modulus);
  archive("earlier", earlier);
}

static void archive(Archive& archive, ShaftNode& shaft) {
  auto& [node, attached, contact, slip_sign, changes] = shaft;
  archive.node("node", node);
  archive("attached", attached);
  archive("contact", contact);
  archive("slip_sign", slip_sign);
  archive("changes", changes);
}

static void archive(Archive& archive, PointForce& force) {
  auto& [point, along, across, settled_along, settled_across, across_too, settled_across_too] =
      force;
  archive("point", point);
  archive("along", along);
  archive("across", across);
  archive("settled_along", settled_along);
  archive("settled_across", settled_across);
  archive("across_too", across_too);
  archive("settled_across_too", settled_across_too);
}

static void archive(Archive& archive, NeedleStep& step) {
  auto& [h, from, to] = step;
  archive("h", h);
  archive("from", from);
  archive("to", to);
}

void Motion::archive(Archive& archive) {
  archive("at", at_);
  archive("along_sign", along_sign_);
  archive("skin", skin_);
  archive("tip", tip_);
  archive("elapsed", elapsed_);
  archive("h", h_);
  archive("left", left_);
  if (at_ > actions_.size()) throw InputError("an action of a needle's motion is none");
  if (archive.loads()) go_on(false);  // what follows now may be over where the tip stands
}

void Track::archive(Archive& archive) {
  archive("nodes", nodes_);
}

void Skin::archive(Archive& archive) {
  archive.nodes("nodes", nodes_);
  archive("entry", entry_);
}

void ContactWork::archive(Archive& archive) {
  archive("last", last_);
}

// The base of an advance and its end are looked for in every step.
void CutPath::archive(Archive& archive) {
  archive("tissue", tissue_);
  archive("track", track_);
  archive("skin", skin_);
  archive("free", free_);
  archive("membrane", membrane_);
  archive("punctures", punctures_);
  archive("counts", counts_);
  archive("exposed", exposed_);
  archive("advanced", advanced_);
  if (archive.loads()) new_base();
}

// The track, and where the membrane crosses it, are the scene's and the mesh's.
void EmbeddedPath::archive(Archive& archive) {
  archive("tissue", tissue_);
  archive("track", track_);
  archive("free", free_);
  archive("membrane", membrane_);
  archive("punctures", punctures_);
  archive("counts", counts_);
  archive("exposed", exposed_);
  archive("advanced", advanced_);
  double depth = length();
  archive("depth", depth);
  if (!archive.loads()) return;
  new_base();
  base_ = depth;
  stand();
}

// Contacts and the search for the advance begin anew with every step.
void Needle::archive(Archive& archive) {
  archive("path", *path_);
  archive("work", work_);
  archive("tip_along", tip_along_);
  archive("skin_along", skin_along_);
  archive("step", step_);
  archive("phase", phase_);
  archive("tip", tip_);
  archive("pending", pending_);
  archive("last_tip_force", last_tip_force_);
  archive("punctures", punctures_);
  archive("n_points", n_points_);
  archive("puncture_at", puncture_at_);
  archive("deepest_since", deepest_since_);
}

}  // namespace stylet
