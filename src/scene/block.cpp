#include "stylet/scene/block.hpp"

#include "stylet/base/text.hpp"

#include <algorithm>

namespace stylet {

namespace {

std::vector<std::string> names_of(const Key& block) {
  std::vector<std::string> names;
  std::ranges::transform(block.keys, std::back_inserter(names), &Key::name);
  return names;
}

void require_known(const Node& child, const Key& block) {
  const std::vector<std::string> names = names_of(block);
  if (std::ranges::find(names, child.key) != names.end()) return;
  const bool is_number = !child.key.empty() && child.key[0] >= '0' && child.key[0] <= '9';
  if (is_number && child.kind == Node::Kind::null) {  // the end of '{step: 0,5 ms}'
    refuse(child, join(names), "is given to a number: is it a decimal comma? Write a point");
  }
  refuse(
      child, join(names),
      "is given to an unknown key, the nearest known key is '" + nearest(child.key, names) + "'");
}

}  // namespace

Key described(Key key, const std::string& name, const std::string& doc) {
  key.name = name;
  key.doc = doc;
  return key;
}

std::optional<Node> unless_empty(Node node) {
  if (node.text.empty() && node.children.empty()) return std::nullopt;
  return node;
}

Key list_key(const Key& item) {
  Key key{.form = Key::Form::list, .unit = item.unit, .allowed = item.allowed, .keys = {item}};
  key.type = "list of " + item.type + "s";
  return key;
}

Key named_key(const std::string& name, const Key& item) {
  Key key{.form = Key::Form::named, .unit = item.unit, .allowed = item.allowed, .keys = {item}};
  key.type = "a " + item.type + " for each " + name;
  key.keys.front().name = name;
  return key;
}

void require_list(const Node& node, const Key& key) {
  if (node.kind != Node::Kind::list) refuse(node, "a " + key.type);
}

void require_named(const Node& node, const Key& key) {
  if (node.kind != Node::Kind::map) refuse(node, key.type + ", as 'name: value'");
  for (const Node& child : node.children) {
    if (child.key.empty()) refuse(child, "a name that is not empty");
  }
}

void require_block(const Node& node, const Key& key) {
  if (node.kind != Node::Kind::map) refuse(node, "a block of " + join(names_of(key)));
  for (const Node& child : node.children) require_known(child, key);
  for (const Key& wanted : key.keys) {
    std::string offers = offer(wanted);
    bool is_given = node.find(wanted.name) != nullptr;
    for (const Key& spelling : key.keys) {
      if (spelling.spells != wanted.name) continue;
      offers += ", or " + spelling.name;
      const Node* other = node.find(spelling.name);
      if (is_given && other) refuse(*other, "one of " + wanted.name + " and " + spelling.name);
      is_given |= other != nullptr;
    }
    if (wanted.required && !is_given) {
      refuse_missing(node, below(node.path, wanted.name), offers);
    }
  }
}

void require_exclusive(const Node& node, const Exclusive& exclusive) {
  const auto n_given = std::ranges::count_if(
      exclusive.names, [&node](const std::string& name) { return node.find(name) != nullptr; });
  if (n_given > 1 || (n_given == 0 && exclusive.needed && !exclusive.names.empty())) {
    const std::string amount = exclusive.needed ? "exactly" : "at most";
    refuse(node, amount + " one of " + join(exclusive.names));
  }
}

}  // namespace stylet
