#include "stylet/scene/overrides.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/scene/schema.hpp"

#include <algorithm>
#include <span>
#include <sstream>
#include <utility>

namespace stylet {

namespace {

using Parts = std::span<const std::string>;

struct Override {
  std::string where;
  Node value;
};

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> parts;
  std::istringstream stream(path);
  for (std::string part; std::getline(stream, part, '.');) parts.push_back(part);
  return parts;
}

std::string below(const Node& node, const std::string& name) {
  return node.path.empty() ? name : node.path + "." + name;
}

[[noreturn]] void refuse_path(const Node& parent,
                              const Key& key,
                              const std::string& name,
                              const Override& given) {
  std::vector<std::string> names;
  std::ranges::transform(key.keys, std::back_inserter(names), &Key::name);
  std::string suggestion = below(parent, nearest(name, names));
  // The same name in another block is more likely what was meant: 'step' for 'time.step'.
  const auto rows = schema_rows();
  const auto same = std::ranges::find(rows, name, [](const auto& row) { return row.key->name; });
  if (names.empty() || same != rows.end()) {
    suggestion = same != rows.end() ? same->path : parent.path;
  }
  throw InputError(given.where + ": key '" + below(parent, name) + "': unknown key for value '" +
                   shown(given.value) + "', the nearest known key is '" + suggestion + "'" +
                   (names.empty() ? "" : "; allowed: " + join(names)));
}

Node& item(Node& node, const std::string& number, const Override& given) {
  const auto child = std::ranges::find(node.children, number, &Node::key);
  if (node.kind == Node::Kind::list && child != node.children.end()) return *child;
  const std::size_t n_items = node.kind == Node::Kind::list ? node.children.size() : 0;
  throw InputError(given.where + ": key '" + below(node, number) + "': no such item for value '" +
                   shown(given.value) + "'; allowed: one of the " + std::to_string(n_items) +
                   " items of '" + node.path + "', counted from 0");
}

/// The child of that name, made if it is not there.
Node& member(Node& node, const std::string& name, const Override& given) {
  if (node.kind != Node::Kind::map) {
    node.kind = Node::Kind::map;
    node.where = given.where;
  }
  auto child = std::ranges::find(node.children, name, &Node::key);
  if (child == node.children.end()) {
    node.add(Node(), name);
    child = std::prev(node.children.end());
    child->place(below(node, name), given.where);
  }
  return *child;
}

void set(Node& node, const Key& key, Parts parts, const Override& given);

void set_action(Node& node, const Key& key, Parts parts, const Override& given) {
  const auto key_of = [&](const std::string& name) {
    return std::ranges::find(key.keys, name, &Key::name);
  };
  if (node.kind == Node::Kind::scalar) {  // 'implant' is short for 'implant: {}'
    const std::string kind = std::exchange(node.text, {});
    member(node, kind, given);
  }
  const auto named = key_of(parts[0]);
  if (named != key.keys.end()) {
    set(member(node, parts[0], given), *named, parts.subspan(1), given);
    return;
  }
  const auto only = node.children.size() == 1 ? key_of(node.children.front().key) : key.keys.end();
  if (only == key.keys.end()) refuse_path(node, key, parts[0], given);
  set(node.children.front(), *only, parts, given);
}

/// Goes down the document and the schema together and writes the value at the end of the path.
void set(Node& node, const Key& key, Parts parts, const Override& given) {
  if (parts.empty()) {
    const std::string name = node.key;
    const std::string path = node.path;
    node = given.value;
    node.key = name;
    node.place(path, given.where);
    return;
  }
  const std::string& name = parts[0];
  if (key.form == Key::Form::action) return set_action(node, key, parts, given);
  if (key.form == Key::Form::list) {
    return set(item(node, name, given), key.keys.front(), parts.subspan(1), given);
  }
  if (key.form == Key::Form::value && node.kind == Node::Kind::list) {  // one number of a pair
    return set(item(node, name, given), key, parts.subspan(1), given);
  }
  const auto child = key.form == Key::Form::named ? key.keys.begin()
                                                  : std::ranges::find(key.keys, name, &Key::name);
  if (child == key.keys.end()) refuse_path(node, key, name, given);
  if (parts.size() == 1 && given.value.kind == Node::Kind::null) {
    std::erase_if(node.children, [&name](const Node& old) { return old.key == name; });
    return;
  }
  if (given.value.kind == Node::Kind::null && node.find(name) == nullptr) {
    Node absent;  // nothing to take away: looks at the rest of the path only
    absent.place(below(node, name), given.where);
    set(absent, *child, parts.subspan(1), given);
    return;
  }
  set(member(node, name, given), *child, parts.subspan(1), given);
}

}  // namespace

void apply_override(Node& document,
                    const std::string& file_name,
                    const std::string& override_text) {
  const std::string where = file_name + ": override '" + override_text + "'";
  const auto equals = override_text.find('=');
  std::string path = override_text.substr(0, equals);
  path.erase(path.find_last_not_of(' ') + 1);
  const std::vector<std::string> parts = split(path);
  const bool is_blank = equals == std::string::npos ||
                        override_text.find_first_not_of(' ', equals + 1) == std::string::npos;
  if (is_blank || parts.empty()) {
    throw InputError(where + ": allowed: key=value, such as time.step=0.5 ms, or key=null");
  }
  const Override given{where, parse_yaml(where, override_text.substr(equals + 1))};
  set(document, scene_codec().key, parts, given);
}

}  // namespace stylet
