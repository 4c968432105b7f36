// The pieces the schema table is made of. A Codec<T> knows how one kind of value is described, read
// and written; a Field binds a codec to a key and to a member of a parameter struct; a block is a
// codec made of fields. A lambda captures only the half of the inner codec that it calls: with both
// halves the table would double in size at every level.
#pragma once

#include "stylet/geometry/components.hpp"
#include "stylet/scene/document.hpp"

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace stylet {

/// Of a number in its SI unit.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_open = false;
  bool max_open = false;
  std::string note = {};  ///< why, where it is not obvious

  [[nodiscard]] bool holds(double value) const {
    return (min_open ? value > min : value >= min) && (max_open ? value < max : value <= max);
  }
};

/// What a user may write at a key: the part of the schema that is plain data.
struct Key {
  enum class Form { value, block, list, named, action };  ///< how a path goes on below the key
  Form form = Form::value;
  std::string name = {};      ///< last part of the path; list and named have one child, the item
  std::string type = {};      ///< such as number, choice, list of points
  std::string unit = {};      ///< SI; empty: none
  std::string allowed = {};   ///< range or choices
  std::string fallback = {};  ///< value if absent
  std::string doc = {};       ///< one line
  bool required = false;
  std::vector<Key> keys = {};
  Range range = {};         ///< of a number
  std::string spells = {};  ///< the key of the same block that this is another way to write
};

/// What may stand at a key, for messages: 'a number with a unit, such as mm, > 0 m'.
[[nodiscard]] std::string offer(const Key& key);

template <class T>
struct Codec {
  Key key;
  std::function<void(const Node&, T&)> read;  ///< throws InputError
  std::function<Node(const T&)> write;
};

inline const Range anything{};
inline const Range positive{.min = 0, .min_open = true};
inline const Range not_negative{.min = 0};

[[nodiscard]] Codec<double> number(const std::string& si_unit, const Range& range);
[[nodiscard]] Codec<double> plain(const Range& range);  ///< dimensionless
/// A plain number is in SI; one with a unit must fit `si_unit`.
[[nodiscard]] Codec<double> number_in_unit_or_plain(const std::string& si_unit);
[[nodiscard]] Codec<int> integer(int min);
[[nodiscard]] Codec<bool> flag();
[[nodiscard]] Codec<std::string> text(const std::string& what);
/// A path as in base/text, kept with quotes only where they are needed.
[[nodiscard]] Codec<std::string> path(const std::string& what);
[[nodiscard]] Codec<std::pair<double, double>> pair(const std::string& si_unit, const Range& range);

[[nodiscard]] Codec<std::array<double, 3>> triple(const std::string& si_unit, const Range& range);

/// How many components a vector has: as the scene, or always two or three.
enum class Extent { plane_or_space, plane, space };
[[nodiscard]] Codec<Components> vector(const std::string& si_unit,
                                       Extent extent = Extent::plane_or_space);

/// Two or three components of which any may be null.
[[nodiscard]] Codec<std::vector<std::optional<double>>> components(const std::string& si_unit);

/// The same value under a plainer type: a struct that has one member to be given.
template <class T, class Inner>
Codec<T> wrap(Inner T::*member, const Codec<Inner>& inner) {
  return {inner.key,
          [member, read = inner.read](const Node& node, T& value) { read(node, value.*member); },
          [member, write = inner.write](const T& value) { return write(value.*member); }};
}

template <class T>  // Vector2 or a point
Codec<T> point(const std::string& si_unit, const Range& range = anything) {
  const auto both = pair(si_unit, range);
  return {both.key,
          [read = both.read](const Node& node, T& value) {
            std::pair<double, double> xy;
            read(node, xy);
            value = {xy.first, xy.second};
          },
          [write = both.write](const T& value) {
            return write({value.x, value.y});
          }};
}

/// A point of space.
[[nodiscard]] Codec<ReferencePlace> place(const std::string& si_unit);

template <class E>
using Choices = std::vector<std::pair<std::string, E>>;

template <class E>
Codec<E> choice(const Choices<E>& choices) {
  Key key{.type = "choice"};
  for (const auto& [name, value] : choices) {
    key.allowed += (key.allowed.empty() ? "" : ", ") + name;
  }
  return {key,
          [=](const Node& node, E& value) {
            for (const auto& [name, chosen] : choices) {
              if (node.kind == Node::Kind::scalar && node.text == name) {
                value = chosen;
                return;
              }
            }
            refuse(node, key.allowed);
          },
          [=](const E& value) {
            for (const auto& [name, chosen] : choices) {
              if (chosen == value) return Node::scalar(name);
            }
            return Node();
          }};
}

/// Refuses everything but a list.
void require_list(const Node& node, const Key& key);

[[nodiscard]] Key list_key(const Key& item);
[[nodiscard]] Key named_key(const std::string& name, const Key& item);

template <class T>
Codec<std::vector<T>> list(const Codec<T>& item) {
  const Key key = list_key(item.key);
  return {key,
          [key, read = item.read](const Node& node, std::vector<T>& values) {
            require_list(node, key);
            values.assign(node.children.size(), T{});
            for (std::size_t i = 0; i < values.size(); ++i) read(node.children[i], values[i]);
          },
          [write = item.write](const std::vector<T>& values) {
            Node node = Node::list();
            for (const T& value : values) node.add(write(value));
            return node;
          }};
}

/// Refuses everything but a map whose keys are names chosen by the user.
void require_named(const Node& node, const Key& key);

/// A map from names that the user chooses to items that keep their name in a member.
template <class T>
Codec<std::vector<T>> named(const std::string& what, std::string T::*name, const Codec<T>& item) {
  const Key key = named_key(what, item.key);
  return {key,
          [key, name, read = item.read](const Node& node, std::vector<T>& values) {
            require_named(node, key);
            values.assign(node.children.size(), T{});
            for (std::size_t i = 0; i < values.size(); ++i) {
              values[i].*name = node.children[i].key;
              read(node.children[i], values[i]);
            }
          },
          [name, write = item.write](const std::vector<T>& values) {
            Node node = Node::map();
            for (const T& value : values) node.add(write(value), value.*name);
            return node;
          }};
}

}  // namespace stylet
