#include "stylet/study/campaign_plan.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/base/units.hpp"
#include "stylet/study/design.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stylet {

namespace {

/// All of a campaign's arithmetic on texts such as '3.2 cm'.
class Planner {
 public:
  Planner(const Campaign& campaign, const Node& scene) : campaign_(campaign), scene_(scene) {}

  CampaignPlan plan() {
    check_keys();
    for (const Variable& v : campaign_.vary) plan_.units.push_back(unit_of(v));
    for (const Variable& v : campaign_.vary) ends_.push_back(ends_of(v));
    make_points();
    make_shifts();
    const auto way = std::ranges::find_if(campaign_.vary, &Variable::on_the_way);
    if (way != campaign_.vary.end()) points_a_run_ = levels(*way).size();
    for (std::size_t first = 0; first < plan_.points.size(); first += points_a_run_) {
      for (std::size_t shift = 0; shift < plan_.shifts.size(); ++shift) add_run(first, shift);
    }
    return plan_;
  }

 private:
  [[noreturn]] void refuse_variable(const std::string& name, const std::string& reason) const {
    throw InputError(campaign_.file + ": key '" + below("vary", name) + "': " + reason);
  }

  [[nodiscard]] double number_in(const std::string& text,
                                 const std::string& unit,
                                 const std::string& name) const {
    try {
      if (!unit.empty()) return to_si(text, unit);  // to any unit
    } catch (const InputError& error) {
      refuse_variable(name, error.what());
    }
    const auto number = plain_number(text);
    if (!number) refuse_variable(name, "'" + text + "' is not a number without unit");
    return *number;
  }

  enum class Use { set, factor, offset, window };
  struct KeyUse {
    std::string name;  ///< of the variable or window
    std::string key;   ///< as the scene writes it
    Use use;
  };

  [[nodiscard]] std::vector<KeyUse> key_uses() const {
    std::vector<KeyUse> uses;
    for (const Variable& v : campaign_.vary) {
      if (!v.key.empty()) uses.push_back({v.name, full(v.key), Use::set});
      for (const Factor& f : v.factor_of) uses.push_back({v.name, full(f.key), Use::factor});
      for (const auto& key : v.offset_of) uses.push_back({v.name, full(key), Use::offset});
    }
    for (const Window& window : campaign_.average) {
      for (const auto& key : window.offset_of)
        uses.push_back({window.name, full(key), Use::window});
    }
    return uses;
  }

  /// Of two that change one key, one would be lost, or the outcome would hang on their order. Only
  /// factors among themselves and offsets among themselves add up; windows come after all of them.
  void check_keys() const {
    const auto uses = key_uses();
    for (std::size_t j = 0; j < uses.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i) {
        const KeyUse& a = uses[i];
        const KeyUse& b = uses[j];
        const bool same = a.key == b.key;
        if (!same && !a.key.starts_with(b.key + ".") && !b.key.starts_with(a.key + ".")) continue;
        const bool adds_up = same && a.name != b.name && a.use == b.use && a.use != Use::set;
        if (adds_up || (same && b.use == Use::window && a.use != Use::window)) continue;
        throw InputError(
            campaign_.file + ": key '" + (b.use == Use::window ? "average." : "vary.") + b.name +
            "': changes '" + b.key + "', and '" + a.name + "' changes " +
            (same ? "it too" : "'" + a.key + "'") +
            "; allowed: one variable a key, but for factors of one key, offsets of one "
            "key, and windows");
      }
    }
    const auto way = std::ranges::find_if(campaign_.vary, &Variable::on_the_way);
    if (way == campaign_.vary.end()) return;
    const std::string key = full(way->key);
    const std::string list = key.substr(0, key.find(".motion.") + std::string(".motion").size());
    for (const KeyUse& other : uses) {
      if (other.key == key || !(other.key + ".").starts_with(list + ".")) continue;
      refuse_variable(way->name, "on_the_way makes many inserts of one, of which '" + other.name +
                                     "' would change the first only: '" + other.key + "'");
    }
  }

  /// A key as the scene writes it.
  [[nodiscard]] std::string full(const std::string& key) const {
    if (closest(scene_, key).path == key) return key;
    const Node* node = through_action(key);
    return node != nullptr ? node->path : key;
  }

  /// The value of a key as the scene writes it.
  [[nodiscard]] const Node& written(const std::string& key, const std::string& name) const {
    const Node* node = &closest(scene_, key);
    if (node->path != key) node = through_action(key);
    if (node == nullptr) {
      refuse_variable(name, "the scene does not write '" + key +
                                "', so nothing can be relative to its value: give it in the scene "
                                "or with `set`");
    }
    return *node;
  }

  // needles.0.motion.0.speed is short for needles.0.motion.0.insert.speed, as in overrides.
  [[nodiscard]] const Node* through_action(const std::string& key) const {
    const Node& item = closest(scene_, key);
    if (item.children.size() != 1) return nullptr;
    const std::string rest = key.substr(item.path.size());
    const std::string full = item.children.front().path + rest;
    const Node& found = closest(scene_, full);
    return found.path == full ? &found : nullptr;
  }

  [[nodiscard]] std::string unit_of(const Variable& v) const {
    const std::string& first = v.from.empty() ? v.values.front() : v.from;
    const bool may_be_text = v.from.empty() && v.factor_of.empty() && v.offset_of.empty();
    const auto quantity = split_quantity(first);
    if (!quantity && may_be_text) return {};
    if (!quantity) refuse_variable(v.name, "'" + first + "' does not start with a number");
    if (may_be_text && !read_quantity(first, quantity->unit).fault.empty()) return {};  // '2.msh'
    return quantity->unit;
  }

  /// Of the range, in the unit of the variable; nothing of one with values.
  [[nodiscard]] std::pair<double, double> ends_of(const Variable& v) const {
    if (v.from.empty()) return {};
    const auto& unit = plan_.units[index_of(v)];
    const double from = number_in(v.from, unit, v.name);
    const double to = number_in(v.to, unit, v.name);
    if (v.scale == Scale::logarithmic && (from <= 0 || to <= 0)) {
      refuse_variable(v.name, "a log scale needs positive ends");
    }
    return {from, to};
  }

  /// Position 0 to 1 in the range of a variable.
  [[nodiscard]] std::string between(const Variable& v, double share) const {
    const auto& unit = plan_.units[index_of(v)];
    const auto [from, to] = ends_[index_of(v)];
    if (v.scale == Scale::linear) return with_unit(from + share * (to - from), unit);
    return with_unit(from * std::pow(to / from, share), unit);
  }

  [[nodiscard]] std::size_t index_of(const Variable& v) const {
    return static_cast<std::size_t>(&v - campaign_.vary.data());
  }

  [[nodiscard]] std::vector<std::string> levels(const Variable& v) const {
    if (!v.values.empty()) return v.values;
    std::vector<std::string> texts;
    for (int i = 0; i < v.count; ++i) texts.push_back(between(v, double(i) / (v.count - 1)));
    return texts;
  }

  /// What leaves the scene as it is.
  [[nodiscard]] std::string base_value(const Variable& v) const {
    if (!v.factor_of.empty()) return "1";
    if (!v.offset_of.empty()) return with_unit(0, plan_.units[index_of(v)]);
    return text_of(written(v.key, v.name));
  }

  /// As an override takes it.
  [[nodiscard]] static std::string text_of(const Node& node) {
    if (node.kind == Node::Kind::scalar) return node.text;
    if (node.kind == Node::Kind::null) return "null";
    std::string text = yaml_text(node);
    text.pop_back();  // the end of the line
    return text.find('\n') == std::string::npos ? text : "\n" + text;
  }

  void make_points() {
    const auto& vary = campaign_.vary;
    if (is_sampled(campaign_.design)) {
      for (const auto& unit_point :
           sample(campaign_.design, campaign_.samples, vary.size(), campaign_.seed)) {
        CampaignPoint point;
        for (const Variable& v : vary) point.values.push_back(between(v, unit_point[index_of(v)]));
        plan_.points.push_back(std::move(point));
      }
      return;
    }
    if (campaign_.design == Design::one_at_a_time) {
      CampaignPoint base;
      for (const Variable& v : vary) base.values.push_back(base_value(v));
      plan_.points.push_back(base);
      for (const Variable& v : vary) {
        for (const auto& value : levels(v)) {
          CampaignPoint point = base;
          point.values[index_of(v)] = value;
          plan_.points.push_back(std::move(point));
        }
      }
      return;
    }
    // A grid: the variable that is taken on the way changes fastest, then the last one.
    std::vector<std::size_t> order(vary.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_partition(order.begin(), order.end(),
                          [&](std::size_t i) { return !vary[i].on_the_way; });
    plan_.points.push_back({std::vector<std::string>(vary.size())});
    for (const std::size_t i : order) {
      auto texts = levels(vary[i]);
      if (vary[i].on_the_way) sort_by_depth(vary[i], texts);
      std::vector<CampaignPoint> finer;
      for (const auto& point : plan_.points) {
        for (const auto& text : texts) {
          finer.push_back(point);
          finer.back().values[i] = text;
        }
      }
      plan_.points = std::move(finer);
    }
  }

  void sort_by_depth(const Variable& v, std::vector<std::string>& texts) const {
    const auto& unit = plan_.units[index_of(v)];
    std::vector<std::pair<double, std::string>> by_value;
    for (auto& text : texts) by_value.emplace_back(number_in(text, unit, v.name), std::move(text));
    std::ranges::stable_sort(by_value, {}, &std::pair<double, std::string>::first);
    std::ranges::transform(by_value, texts.begin(), &std::pair<double, std::string>::second);
    if (v.key.ends_with(".position")) std::ranges::reverse(texts);  // needles advance towards -x
  }

  void make_shifts() {
    plan_.shifts.assign(1, {});
    for (const Window& window : campaign_.average) {
      const auto width = split_quantity(window.width);
      if (!width)
        throw InputError(campaign_.file + ": key '" + below("average", window.name) + ".width': '" +
                         window.width + "' does not start with a number");
      std::vector<std::vector<std::string>> finer;
      for (const auto& shift : plan_.shifts) {
        for (int i = 0; i < window.count; ++i) {
          finer.push_back(shift);
          finer.back().push_back(
              with_unit(width->number * (double(i) / (window.count - 1) - 0.5), width->unit));
        }
      }
      plan_.shifts = std::move(finer);
    }
  }

  /// Text of a key that was `text`, shifted.
  [[nodiscard]] std::string shifted(const std::string& text,
                                    const std::string& by,
                                    const std::string& name) const {
    const auto base = split_quantity(text);
    if (!base) refuse_variable(name, "'" + text + "' does not start with a number");
    return with_unit(base->number + number_in(by, base->unit, name), base->unit);
  }

  void add_run(std::size_t first, std::size_t shift) {
    PlannedRun run;
    run.shift = shift;
    // The values of keys as they stand after the changes so far, since windows shift those.
    std::vector<std::pair<std::string, std::string>> changes;
    const auto value_of = [&](const std::string& given, const std::string& name) {
      const std::string key = full(given);
      const auto changed =
          std::ranges::find(changes, key, &std::pair<std::string, std::string>::first);
      return changed != changes.end() ? changed->second : text_of(written(key, name));
    };
    const auto change = [&](const std::string& given, const std::string& text) {
      const std::string key = full(given);
      std::erase_if(changes, [&](const auto& old) { return old.first == key; });
      changes.emplace_back(key, text);
    };
    const Variable* way = nullptr;
    const CampaignPoint& point = plan_.points[first];
    for (const Variable& v : campaign_.vary) {
      const std::string& value = point.values[index_of(v)];
      if (v.on_the_way) {
        way = &v;
      } else if (!v.key.empty()) {
        change(v.key, value);
      }
      for (const Factor& factor : v.factor_of) {
        const auto base = split_quantity(value_of(factor.key, v.name));
        if (!base) refuse_variable(v.name, "'" + factor.key + "' is not a number");
        const double times = std::pow(number_in(value, {}, v.name), factor.power);
        change(factor.key, with_unit(base->number * times, base->unit));
      }
      for (const auto& key : v.offset_of) {
        change(key, shifted(value_of(key, v.name), value, v.name));
      }
    }
    for (std::size_t w = 0; w < campaign_.average.size(); ++w) {
      const Window& window = campaign_.average[w];
      for (const auto& key : window.offset_of) {
        change(key, shifted(value_of(key, window.name), plan_.shifts[shift][w], window.name));
      }
    }
    for (const auto& [key, text] : changes) run.overrides.push_back(key + "=" + text);
    for (std::size_t i = 0; i < points_a_run_; ++i) {
      run.points.push_back(first + i);
      run.outputs.push_back(campaign_.outputs);
    }
    if (way != nullptr) leave_seeds_on_the_way(*way, run);
    plan_.runs.push_back(std::move(run));
  }

  [[nodiscard]] static bool is_implant(const Node& action) {
    return action.text == "implant" ||
           (action.children.size() == 1 && action.children.front().key == "implant");
  }

  /// Over all needles, in the order in which they act.
  [[nodiscard]] std::size_t implants_before(const std::string& list_path, std::size_t at) const {
    std::size_t n = 0;
    for (const Node& needle : scene_.find("needles")->children) {
      const Node* motion = needle.find("motion");
      if (motion == nullptr) continue;
      const bool own = motion->path == list_path;
      const std::size_t end = own ? at : motion->children.size();
      for (std::size_t i = 0; i < end; ++i) n += is_implant(motion->children[i]) ? 1 : 0;
      if (own) break;
    }
    return n;
  }

  // insert to v1, implant, insert to v2, implant ... : exact, because seeds are fixed in the tissue and
  // linear tissue returns to rest (src/MODEL.md, section 9).
  void leave_seeds_on_the_way(const Variable& v, PlannedRun& run) const {
    const Node& end = written(v.key, v.name);
    const std::string action_path = end.path.substr(0, end.path.rfind(".insert."));
    const auto dot = action_path.rfind('.');
    const std::string list_path = action_path.substr(0, dot);
    const Node& motion = closest(scene_, list_path);
    const auto at = action_path != end.path ? std::stoul(action_path.substr(dot + 1)) : 0;
    if (action_path == end.path || at + 1 >= motion.children.size() ||
        !is_implant(motion.children[at + 1])) {
      refuse_variable(v.name,
                      "on_the_way needs the position or depth of an insert that is followed "
                      "by an implant; '" +
                          v.key + "' is none");
    }
    const std::size_t seed = implants_before(list_path, at + 1);
    Node changed = Node::list();
    for (std::size_t i = 0; i < motion.children.size(); ++i) {
      if (i == at + 1) continue;
      if (i != at) {
        changed.add(motion.children[i]);
        continue;
      }
      for (const std::size_t point : run.points) {
        Node insert = motion.children[at];
        for (Node& child : insert.children.front().children) {
          if (child.path == end.path) child.text = plan_.points[point].values[index_of(v)];
        }
        changed.add(insert);
        changed.add(motion.children[at + 1]);
      }
    }
    run.overrides.insert(run.overrides.begin(), list_path + "=\n" + yaml_text(changed));
    const std::string own = "seeds." + std::to_string(seed) + ".";
    for (std::size_t i = 0; i < run.points.size(); ++i) {
      for (std::string& output : run.outputs[i]) {
        if (!output.starts_with(own)) {
          refuse_variable(v.name,
                          "on_the_way gives outputs of '" + own + "' only, not '" + output + "'");
        }
        output = "seeds." + std::to_string(seed + i) + "." + output.substr(own.size());
      }
    }
  }

  const Campaign& campaign_;
  const Node& scene_;
  CampaignPlan plan_;
  std::vector<std::pair<double, double>> ends_;  ///< one a variable
  std::size_t points_a_run_ = 1;                 ///< more if a variable is taken on the way
};

}  // namespace

CampaignPlan plan_runs(const Campaign& campaign, const Node& scene) {
  return Planner(campaign, scene).plan();
}

}  // namespace stylet
