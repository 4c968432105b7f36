#include "stylet/scene/schema_needle.hpp"

#include "stylet/scene/block.hpp"
#include "stylet/scene/gauge.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stylet {

namespace {

Codec<double> gauge() {
  constexpr double millimetres = 1000;  // a metre
  Choices<double> choices;
  for (const NeedleGauge& each : needle_gauges) {
    choices.emplace_back(std::to_string(each.gauge), each.diameter / millimetres);
  }
  return choice(choices);
}

/// The force of a crack that grows: its energy for a length of path.
Codec<double> fracture() {
  struct Crack {
    double toughness = 0;  // J/m^2
    double width = 0;      // m
  };
  const auto crack = block<Crack>(
      {field("toughness", &Crack::toughness, number("J/m^2", positive),
             "Energy that a new crack takes, for its area.")
           .required(),
       field("width", &Crack::width, number("m", positive), "Of the crack, across the path.")
           .required()});
  return {crack.key,
          [read = crack.read](const Node& node, double& force) {
            Crack given;
            read(node, given);
            force = given.toughness * given.width;
            if (!(force > 0 && std::isfinite(force))) {
              refuse(
                  node,
                  "toughness and width whose product is a force above 0 N that a number can hold");
            }
          },
          [](const double&) { return Node(); }};
}

Codec<CuttingParameters> cutting() {
  using C = CuttingParameters;
  const Choices<CuttingLaw> laws = {{"consistent", CuttingLaw::consistent},
                                    {"lagged", CuttingLaw::lagged},
                                    {"increment", CuttingLaw::increment}};
  const Range share{.min = 0, .max = 1};
  return block<C>(
      {field("law", &C::law, choice(laws), "How the advance of the tip follows from its force.")
           .otherwise("lagged if time.method is explicit, else consistent"),
       field("cutting_force", &C::cutting_force, number("N", positive),
             "Tip force at which tissue is cut, for sharpness 1.")
           .required(),
       field("fracture", &C::cutting_force, fracture(),
             "The cutting force as toughness times width of the crack.")
           .spelling_of("cutting_force"),
       field("sharpness", &C::sharpness, plain({.min = 0, .max = 1, .min_open = true}),
             "Divides the cutting force; 1 is the sharpest."),
       field("stiffness_share", &C::stiffness_share, plain(share),
             "Share of the cutting force that grows with Young's modulus."),
       field("reference_youngs_modulus", &C::reference_youngs_modulus, number("Pa", not_negative),
             "Young's modulus at which that share is as given."),
       field("tip_length", &C::tip_length, number("m", not_negative),
             "Length over which the tip force is spread: along the path, and along the skin as far "
             "as the tip is not in yet; at most the way through the tissue; 0: a point, and the "
             "answer depends on the mesh."),
       field("increment", &C::increment, number("m", not_negative),
             "Length of one cut of the increment law.")});
}

/// Friction of a shaft, whose size turns stresses into forces per metre.
struct Shaft {
  FrictionParameters friction;
  double circumference = 0;  // m; 0 in the plane
};

Field<Shaft> of_friction(const char* name,
                         double FrictionParameters::*member,
                         const char* unit,
                         const Range& range,
                         const char* doc) {
  const Field<FrictionParameters> inner = field(name, member, number(unit, range), doc);
  return {inner.key,
          [read = inner.read](const Node& node, Shaft& shaft) { read(node, shaft.friction); },
          [write = inner.write](const Shaft& shaft) { return write(shaft.friction); }};
}

Field<Shaft> of_surface(const char* name,
                        const std::string& per_metre,
                        double FrictionParameters::*member,
                        const char* unit,
                        const char* doc) {
  const auto stress = number(unit, not_negative);
  const auto read = [=, read = stress.read](const Node& node, Shaft& shaft) {
    if (shaft.circumference == 0) {
      refuse(node, per_metre + ": only a needle in space, with entry, has a surface for a stress");
    }
    double value = 0;
    read(node, value);
    shaft.friction.*member = value * shaft.circumference;
    if (!std::isfinite(shaft.friction.*member)) {
      refuse(node, "a stress that a number can hold times the circumference of the shaft");
    }
  };
  return Field<Shaft>{described(stress.key, name, doc), read, {}}.spelling_of(per_metre);
}

Codec<Shaft> friction() {
  using F = FrictionParameters;
  return block<Shaft>(
      {of_friction("static_force", &F::static_force, "N/m", not_negative,
                   "Per metre of shaft, largest force that holds.")
           .required(),
       of_surface("static_stress", "static_force", &F::static_force, "Pa",
                  "In space: the same per area of the shaft's surface, pi diameter a metre."),
       of_friction("kinetic_force", &F::kinetic_force, "N/m", not_negative,
                   "Per metre of shaft, while tissue slides.")
           .required(),
       of_surface("kinetic_stress", "kinetic_force", &F::kinetic_force, "Pa",
                  "In space: the same per area of the shaft's surface."),
       of_friction("stick_speed", &F::stick_speed, "m/s", not_negative,
                   "Tissue that slides more slowly sticks again.")
           .required(),
       of_friction("slip_speed", &F::slip_speed, "m/s", positive,
                   "Tissue that slides faster is sliding; above stick_speed.")
           .required(),
       of_friction("viscous_coefficient", &F::viscous_coefficient, "N s/m^2", not_negative,
                   "Per metre of shaft, what the force of sliding tissue grows by with its speed.")
           .written_if([](const Shaft& shaft) { return shaft.friction.viscous_coefficient > 0; })
           .otherwise("0 N s/m^2"),
       of_surface("viscous_stress_coefficient", "viscous_coefficient", &F::viscous_coefficient,
                  "Pa s/m", "In space: the same per area of the shaft's surface.")});
}

/// Behind diameter and entry in the list of fields, since it reads what they gave.
Field<NeedleParameters> friction_field() {
  const Codec<Shaft> shaft = friction();
  return {described(shaft.key, "friction", "Friction along the shaft; without it there is none."),
          [read = shaft.read](const Node& node, NeedleParameters& needle) {
            Shaft given;
            if (needle.space.entry) given.circumference = std::numbers::pi * needle.diameter;
            read(node, given);
            needle.friction = given.friction;
          },
          [write = shaft.write](const NeedleParameters& needle) -> std::optional<Node> {
            if (!needle.friction) return std::nullopt;
            return write({*needle.friction, 0});
          }};
}

struct ActionEntry {
  std::string name;
  ActionKind kind;
  Codec<Action> codec;
  std::string doc;
};

std::vector<ActionEntry> action_entries() {
  using A = Action;
  const auto speed =
      field("speed", &A::speed, number("m/s", positive), "Speed of the needle.").required();
  const auto depth = field("depth", &A::depth, number("m", not_negative),
                           "Where the tip stops, behind the entry point.");
  const auto position =
      field("position", &A::position, number("m", anything),
            "Where the tip stops, as its coordinate along the axis, which grows against "
            "the advance.");
  const auto duration =
      field("duration", &A::duration, number("s", positive), "How long it takes.");
  const auto target = field("target", &A::target, text("a target"), "Where the seed should be.")
                          .otherwise("the target, if there is only one");
  const auto tolerance = field("speed_tolerance", &A::speed_tolerance, number("m/s", positive),
                               "Ends when all tissue is slower.")
                             .written_if([](const A& action) { return !action.duration; });
  return {{"insert", ActionKind::insert,
           block<A>({speed, depth, position}, {{"depth", "position"}}), "Push the needle in."},
          {"hold", ActionKind::hold, block<A>({duration.required()}), "Keep the needle still."},
          {"implant", ActionKind::implant, block<A>({target}), "Leave a seed at the tip."},
          {"retract", ActionKind::retract,
           block<A>({speed, depth, position}, {{"depth", "position"}, false}),
           "Pull the needle back, all the way out if no end is given."},
          {"settle", ActionKind::settle,
           block<A>({duration, tolerance}, {{"duration", "speed_tolerance"}, false}),
           "Wait until the tissue is still, or for a time."}};
}

/// A map with one key, the kind; 'implant' alone is short for 'implant: {}'.
Codec<Action> action() {
  const auto entries = action_entries();
  Key key{.form = Key::Form::action, .type = "action"};
  for (const ActionEntry& entry : entries) {
    key.keys.push_back(described(entry.codec.key, entry.name, entry.doc));
    key.allowed += (key.allowed.empty() ? "" : ", ") + entry.name;
  }
  const auto read = [=](const Node& node, Action& value) {
    const bool bare = node.kind == Node::Kind::scalar;
    if (!bare && (node.kind != Node::Kind::map || node.children.size() != 1)) {
      refuse(node, "one of " + key.allowed);
    }
    const Node& child = bare ? node : node.children.front();
    const auto entry = std::ranges::find(entries, bare ? node.text : child.key, &ActionEntry::name);
    if (entry == entries.end()) refuse(child, "one of " + key.allowed);
    Node given = child;
    if (bare || given.kind == Node::Kind::null) given.kind = Node::Kind::map;
    value.kind = entry->kind;
    entry->codec.read(given, value);
  };
  const auto write = [=](const Action& value) {
    const auto entry = std::ranges::find(entries, value.kind, &ActionEntry::kind);
    Node node = Node::map();
    node.add(entry->codec.write(value), entry->name);
    return node;
  };
  return {key, read, write};
}

std::vector<Field<NeedleParameters>> held_fields() {
  using N = NeedleParameters;
  using S = SpaceParameters;
  const auto in_space = [](const N& needle) { return needle.space.entry.has_value(); };
  const auto in_plane = [](const N& needle) { return !needle.space.entry.has_value(); };
  const auto space = [](const char* name, auto member, auto codec, const char* doc) -> Field<N> {
    const Field<S> inner = field(name, member, codec, doc);
    return {inner.key,
            [read = inner.read](const Node& node, N& needle) { read(node, needle.space); },
            [write = inner.write](const N& needle) { return write(needle.space); }};
  };
  return {
      field("name", &N::name, text("a name"), "For messages and output.")
          .otherwise("needle1, needle2, ..."),
      field("height", &N::height, number("m", anything),
            "In the plane: coordinate of the axis across the needle.")
          .written_if(in_plane)
          .otherwise("required in the plane, not allowed in space"),
      space("entry", &S::entry, vector("m", Extent::space),
            "In space: a point of the axis, on the skin or in front of it.")
          .otherwise("required in space, not allowed in the plane"),
      space("target", &S::target, vector("m", Extent::space),
            "In space: a point that the axis leads to; or direction."),
      space("direction", &S::direction, vector("", Extent::space),
            "In space: of the insertion, of any length; or target."),
      field("diameter", &N::diameter, number("m", positive),
            "Of the shaft. In the plane: what lies within half of it of an earlier needle's path "
            "is cut already."),
      field("gauge", &N::diameter, gauge(),
            "The diameter as the gauge of a hypodermic needle; 18 is 1.27 mm.")
          .spelling_of("diameter"),
      space("kernel_radius", &S::kernel_radius, number("m", positive),
            "In space: of the disc over which the mesh gets the needle's force; what lies "
            "between it and the shaft is added in closed form. About two edges of the coarsest "
            "mesh, and less than the distance to stiffer or softer tissue beside the needle.")
          .written_if(in_space)
          .otherwise("required in space, not allowed in the plane"),
      space("segment", &S::segment, number("m", positive),
            "In space: length of the pieces of the needle's way.")
          .written_if(in_space)
          .otherwise("0.5 mm"),
      field("cutting", &N::cutting, cutting(), "How the tip cuts tissue.").required(),
      friction_field()};
}

}  // namespace

Codec<NeedleParameters> held_needle_codec() {
  return block<NeedleParameters>(held_fields());
}

Codec<NeedleParameters> needle_codec() {
  auto fields = held_fields();
  fields.push_back(
      field("motion", &NeedleParameters::motion, list(action()), "What the needle does, in order.")
          .required());
  return block<NeedleParameters>(fields);
}

Codec<MembraneParameters> membrane_codec() {
  using M = MembraneParameters;
  return block<M>({field("region", &M::region, text("a region"), "Region whose outline it is.")
                       .written_if([](const M& given) { return !given.region.empty(); }),
                   field("surface", &M::surface, text("a surface"), "Closed surface, in space.")
                       .written_if([](const M& given) { return !given.surface.empty(); }),
                   field("polygon", &M::polygon, list(point<ReferencePoint>("m")), "Its corners.")
                       .written_if([](const M& given) {
                         // Otherwise filled in from the region.
                         return given.region.empty() && given.surface.empty();
                       }),
                   field("puncture_force", &M::puncture_force, number("N", positive),
                         "Tip force at which it is punctured.")
                       .required()},
                  {{"region", "surface", "polygon"}});
}

}  // namespace stylet
