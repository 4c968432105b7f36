#include "stylet/scene/codec.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/base/units.hpp"
#include "stylet/base/utf8.hpp"
#include "stylet/scene/block.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace stylet {

namespace {

std::string range_text(const Range& range, const std::string& unit) {
  std::string text;
  if (std::isfinite(range.min)) {
    text = (range.min_open ? "> " : ">= ") + with_unit(range.min, unit);
  }
  if (std::isfinite(range.max)) {
    text += text.empty() ? "" : " and ";
    text += (range.max_open ? "< " : "<= ") + with_unit(range.max, unit);
  }
  return text + (range.note.empty() ? "" : " (" + range.note + ")");
}

double read_number(const Node& node, const Key& key) {
  if (node.kind != Node::Kind::scalar) refuse(node, offer(key));
  const Reading reading =
      key.unit.empty() ? read_plain(node.text) : read_quantity(node.text, key.unit);
  if (!reading.fault.empty()) refuse(node, offer(key), reading.fault);
  const double value = reading.value;
  if (!key.range.holds(value)) refuse(node, offer(key));
  return value;
}

/// A non-breaking space at either end of a name comes from a word processor.
void require_no_outer_space(const Node& node, const std::string& allowed) {
  std::size_t last = node.text.size() - 1;
  while (last > 0 && (static_cast<unsigned char>(node.text[last]) & 0xC0U) == 0x80U) --last;
  for (const std::size_t at : {std::size_t{0}, last}) {
    const Glyph glyph = first_glyph(std::string_view(node.text).substr(at));
    if (is_typographic_space(glyph.code)) refuse(node, allowed, "has a " + named(glyph));
  }
}

/// '[0,5 mm, 1 cm]' has three items.
std::string comma_hint(const Node& list) {
  const bool bare = std::ranges::any_of(list.children, [](const Node& child) {
    return child.kind == Node::Kind::scalar && plain_number(child.text);
  });
  return bare ? "has a number without a unit: is it a decimal comma? Write a point" : "";
}

}  // namespace

std::string offer(const Key& key) {
  if (key.type == "choice" || key.type == "flag" || key.type == "text") return key.allowed;
  std::string text = "a " + key.type;
  if (key.form == Key::Form::value && key.type != "integer") {
    text +=
        key.unit.empty() ? " without a unit" : " with a unit, such as " + customary_unit(key.unit);
  }
  return text + (key.allowed.empty() ? "" : ", " + key.allowed);
}

Codec<double> number(const std::string& si_unit, const Range& range) {
  const Key key{
      .type = "number", .unit = si_unit, .allowed = range_text(range, si_unit), .range = range};
  return {key, [=](const Node& node, double& value) { value = read_number(node, key); },
          [=](const double& value) { return Node::scalar(with_unit(value, si_unit)); }};
}

Codec<double> plain(const Range& range) {
  return number({}, range);
}

Codec<double> number_in_unit_or_plain(const std::string& si_unit) {
  const Codec<double> in_unit = number(si_unit, anything);
  const Key key{.type = "number", .allowed = "in SI, or with a unit of the quantity"};
  const auto read = [in_unit](const Node& node, double& value) {
    const auto plain = node.kind == Node::Kind::scalar ? plain_number(node.text) : std::nullopt;
    if (!plain) return in_unit.read(node, value);
    value = *plain;
  };
  return {key, read, in_unit.write};
}

Codec<int> integer(int min) {
  const Key key{.type = "integer", .allowed = ">= " + std::to_string(min)};
  const auto read = [=](const Node& node, int& value) {
    const char* last = node.text.data() + node.text.size();
    int number = 0;
    const auto [end, error] = std::from_chars(node.text.data(), last, number);
    const bool whole = node.kind == Node::Kind::scalar && error == std::errc() && end == last;
    if (!whole || number < min) refuse(node, "a whole number " + key.allowed);
    value = number;
  };
  return {key, read, [](const int& value) { return Node::scalar(std::to_string(value)); }};
}

Codec<bool> flag() {
  Codec<bool> codec = choice<bool>({{"true", true}, {"false", false}});
  codec.key.type = "flag";
  return codec;
}

Codec<std::string> text(const std::string& what) {
  const auto read = [what](const Node& node, std::string& value) {
    if (node.kind != Node::Kind::scalar || node.text.empty()) refuse(node, what);
    require_no_outer_space(node, what);
    value = node.text;
  };
  return {Key{.type = "text", .allowed = what}, read,
          [](const std::string& value) { return Node::scalar(value); }};
}

Codec<std::string> path(const std::string& what) {
  Codec<std::string> codec = text(what);
  codec.read = [what, read = codec.read](const Node& node, std::string& value) {
    read(node, value);
    try {
      value = plain_path(value);
    } catch (const InputError&) {
      refuse(node, what, "has a quote that is not closed");
    }
  };
  return codec;
}

Codec<std::pair<double, double>> pair(const std::string& si_unit, const Range& range) {
  const Codec<double> item = number(si_unit, range);
  Key key = item.key;
  key.type = "pair";
  const auto read = [=](const Node& node, std::pair<double, double>& value) {
    if (node.kind != Node::Kind::list || node.children.size() != 2) {
      refuse(node, "[x, y], each " + offer(item.key), comma_hint(node));
    }
    item.read(node.children[0], value.first);
    item.read(node.children[1], value.second);
  };
  const auto write = [=](const std::pair<double, double>& value) {
    Node node = Node::list();
    node.add(item.write(value.first));
    node.add(item.write(value.second));
    return node;
  };
  return {key, read, write};
}

Codec<std::array<double, 3>> triple(const std::string& si_unit, const Range& range) {
  const Codec<double> item = number(si_unit, range);
  Key key = item.key;
  key.type = "triple";
  const auto read = [=](const Node& node, std::array<double, 3>& value) {
    if (node.kind != Node::Kind::list || node.children.size() != 3) {
      refuse(node, "[x, y, z], each " + offer(item.key), comma_hint(node));
    }
    for (std::size_t i = 0; i < 3; ++i) item.read(node.children[i], value[i]);
  };
  const auto write = [=](const std::array<double, 3>& value) {
    Node node = Node::list();
    for (const double component : value) node.add(item.write(component));
    return node;
  };
  return {key, read, write};
}

Codec<Components> vector(const std::string& si_unit, Extent extent) {
  const auto two = pair(si_unit, anything);
  const auto three = triple(si_unit, anything);
  Key key = extent == Extent::space ? three.key : two.key;
  if (extent == Extent::plane_or_space) key.type = "pair or triple";
  const auto read = [=](const Node& node, Components& value) {
    const bool has_z = node.kind == Node::Kind::list && node.children.size() == 3;
    if (extent == Extent::space || (has_z && extent == Extent::plane_or_space)) {
      std::array<double, 3> xyz{};
      three.read(node, xyz);
      value = {xyz[0], xyz[1], xyz[2]};
    } else {
      std::pair<double, double> xy;
      two.read(node, xy);
      value = {xy.first, xy.second};
    }
  };
  const auto write = [=](const Components& value) {
    return value.z ? three.write({value.x, value.y, *value.z}) : two.write({value.x, value.y});
  };
  return {key, read, write};
}

Codec<ReferencePlace> place(const std::string& si_unit) {
  const auto three = triple(si_unit, anything);
  return {three.key,
          [read = three.read](const Node& node, ReferencePlace& value) {
            std::array<double, 3> xyz{};
            read(node, xyz);
            value = {xyz[0], xyz[1], xyz[2]};
          },
          [write = three.write](const ReferencePlace& value) {
            return write({value.x, value.y, value.z});
          }};
}

Codec<std::vector<std::optional<double>>> components(const std::string& si_unit) {
  using Values = std::vector<std::optional<double>>;
  const Codec<double> item = number(si_unit, anything);
  const Key key{
      .type = "pair or triple", .unit = si_unit, .allowed = "null leaves a component free"};
  const auto read = [=](const Node& node, Values& value) {
    const std::size_t n = node.children.size();
    if (node.kind != Node::Kind::list || (n != 2 && n != 3)) {
      refuse(node, "[x, y], each null or " + offer(item.key), comma_hint(node));
    }
    value.assign(n, std::nullopt);
    for (std::size_t i = 0; i < n; ++i) {
      if (node.children[i].kind != Node::Kind::null) {
        item.read(node.children[i], value[i].emplace());
      }
    }
  };
  const auto write = [=](const Values& value) {
    Node node = Node::list();
    for (const auto& component : value) node.add(component ? item.write(*component) : Node());
    return node;
  };
  return {key, read, write};
}

}  // namespace stylet
