#include "stylet/study/campaign.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/scene/block.hpp"

#include <algorithm>

namespace stylet {

namespace {

const Choices<Design>& designs() {
  static const Choices<Design> choices = {{"one_at_a_time", Design::one_at_a_time},
                                          {"grid", Design::grid},
                                          {"random", Design::random},
                                          {"latin_hypercube", Design::latin_hypercube},
                                          {"morris", Design::morris},
                                          {"sobol", Design::sobol}};
  return choices;
}

Codec<Variable> variable() {
  using V = Variable;
  const Choices<Scale> scales = {{"linear", Scale::linear}, {"log", Scale::logarithmic}};
  const auto factor = wrap(&Factor::power, plain(anything));
  return block<V>(
      {field("key", &V::key, path("a key of the scene"), "Key that takes the value."),
       field("factor_of", &V::factor_of, named("KEY", &Factor::key, factor),
             "Keys that are multiplied by the value to a power: 1, -1 ..."),
       field("offset_of", &V::offset_of, list(path("a key of the scene")),
             "Keys to which the value is added."),
       field("values", &V::values, list(text("a value")), "The values."),
       field("from", &V::from, text("a value"), "Start of a range."),
       field("to", &V::to, text("a value"), "End of a range."),
       field("count", &V::count, integer(2), "Values in the range, ends included.")
           .otherwise("needed for from and to, unless values are sampled"),
       field("scale", &V::scale, choice(scales), "How the range is divided or sampled."),
       field("on_the_way", &V::on_the_way, flag(),
             "All values in one run, as seeds left along one insertion; `key` is the position or "
             "depth of an insert, and the design a grid.")},
      {{"key", "factor_of", "offset_of"}});
}

Codec<Campaign> codec() {
  using C = Campaign;
  const auto window = block<Window>(
      {field("offset_of", &Window::offset_of, list(path("a key of the scene")),
             "Keys that are shifted together.")
           .required(),
       field("width", &Window::width, text("a length"), "From the first to the last shift.")
           .required(),
       field("count", &Window::count, integer(2), "Shifts, evenly spaced around 0.").required()});
  return block<C>(
      {field("title", &C::title, text("a line"), "For pictures."),
       field("scene", &C::scene, text("a file name"), "Scene, relative to the campaign's folder.")
           .required(),
       field("set", &C::set, list(text("key=value")), "Changes of the scene for all runs."),
       field("vary", &C::vary, named("VARIABLE", &Variable::name, variable()), "What varies.")
           .required(),
       field("design", &C::design, choice(designs()), "Which combinations are run."),
       field("samples", &C::samples, integer(1),
             "random, latin_hypercube: runs; morris: trajectories; sobol: N of N (d + 2) runs.")
           .otherwise("needed where values are sampled"),
       field("seed", &C::seed, integer(0), "Of the random numbers."),
       field("outputs", &C::outputs, list(path("a path in summary.json")), "What is tabulated.")
           .required(),
       field("average", &C::average, named("WINDOW", &Window::name, window),
             "Shifts over which every output is averaged.")});
}

/// Points of the design times shifts of the windows; as a number that does not overflow.
double n_rows(const Campaign& campaign) {
  const auto n_levels = [](const Variable& v) {
    return v.values.empty() ? static_cast<double>(v.count) : static_cast<double>(v.values.size());
  };
  const auto d = static_cast<double>(campaign.vary.size());
  double rows = campaign.samples;
  if (campaign.design == Design::morris) rows *= d + 1;
  if (campaign.design == Design::sobol) rows *= d + 2;
  if (!is_sampled(campaign.design)) rows = 1;
  for (const Variable& v : campaign.vary) {
    if (campaign.design == Design::one_at_a_time) rows += n_levels(v);
    if (campaign.design == Design::grid) rows *= n_levels(v);
  }
  for (const Window& window : campaign.average) rows *= window.count;
  return rows;
}

void check_rules(const Campaign& campaign, const Node& document) {
  const auto refuse_key = [&](const std::string& path, const std::string& allowed,
                              const std::string& reason) {
    const Node& node = closest(document, path);
    if (node.path == path) refuse(node, allowed, reason);
    refuse_missing(node, path, allowed);
  };
  const bool sampled = is_sampled(campaign.design);
  const std::string design = name_of(campaign.design);
  if (campaign.vary.empty()) refuse_key("vary", "at least one variable", "is empty");
  if (campaign.outputs.empty()) refuse_key("outputs", "at least one path", "is empty");
  if (sampled && campaign.samples == 0) refuse_key("samples", "a number for design " + design, {});
  for (const Variable& v : campaign.vary) {
    const std::string at = below("vary", v.name);
    if (v.values.empty() == v.from.empty()) {
      refuse_key(at, "either values, or from and to", v.values.empty() ? "has none" : "has both");
    }
    if (!v.from.empty() && v.to.empty()) refuse_key(at + ".to", "the end of the range", {});
    if (sampled && v.from.empty()) {
      refuse_key(at + ".values", "from and to, because design " + design + " draws values", {});
    }
    if (!sampled && !v.from.empty() && v.count == 0) {
      refuse_key(at + ".count", "how many values the range has", {});
    }
    if (v.on_the_way && (campaign.design != Design::grid || v.key.empty())) {
      refuse_key(at + ".on_the_way", "only in design grid and with `key`", {});
    }
  }
  if (std::ranges::count_if(campaign.vary, &Variable::on_the_way) > 1) {
    refuse_key("vary", "one variable with on_the_way", "has several");
  }
  constexpr int most_rows = 100'000;  // all of them are planned before the first is run
  if (const double rows = n_rows(campaign); rows > most_rows) {
    refuse_key(sampled ? "samples" : "vary", "at most " + std::to_string(most_rows) + " in all",
               "makes " + exact(rows) + " points, shifts counted");
  }
}

}  // namespace

const char* name_of(Design design) {
  const auto found = std::ranges::find(designs(), design, &Choices<Design>::value_type::second);
  return found->first.c_str();
}

bool is_sampled(Design design) {
  return design != Design::one_at_a_time && design != Design::grid;
}

const Codec<Campaign>& campaign_codec() {
  static const Codec<Campaign> table = codec();
  return table;
}

Campaign load_campaign(const std::string& file_name,
                       const std::string& text,
                       const std::vector<std::string>& set) {
  const Node document = parse_yaml(file_name, text);
  Campaign campaign;
  campaign.file = file_name;
  campaign_codec().read(document, campaign);
  for (Variable& v : campaign.vary) {
    for (Factor& factor : v.factor_of) factor.key = plain_path(factor.key);
  }
  check_rules(campaign, document);
  campaign.set.insert(campaign.set.end(), set.begin(), set.end());
  return campaign;
}

}  // namespace stylet
