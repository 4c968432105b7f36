#include "stylet/scene/document.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/base/utf8.hpp"

#include <algorithm>
#include <utility>

namespace stylet {

Node Node::scalar(std::string text) {
  Node node;
  node.kind = Kind::scalar;
  node.text = std::move(text);
  return node;
}

Node Node::list() {
  Node node;
  node.kind = Kind::list;
  return node;
}

Node Node::map() {
  Node node;
  node.kind = Kind::map;
  return node;
}

const Node* Node::find(const std::string& name) const {
  const auto found = std::ranges::find(children, name, &Node::key);
  return kind == Kind::map && found != children.end() ? &*found : nullptr;
}

void Node::add(Node child, std::string name) {
  child.key = kind == Kind::list ? std::to_string(children.size()) : std::move(name);
  children.push_back(std::move(child));
}

void Node::place(const std::string& new_path, const std::string& new_where) {
  path = new_path;
  where = new_where;
  for (Node& child : children) child.place(below(path, child.key), where);
}

const Node& closest(const Node& document, const std::string& path) {
  const auto leads_there = [&path](const Node& child) {
    return path == child.path || path.starts_with(child.path + ".");
  };
  const Node* node = &document;
  for (;;) {
    const auto next = std::ranges::find_if(node->children, leads_there);
    if (next == node->children.end()) return *node;
    node = &*next;
  }
}

std::string shown(const Node& node) {
  std::string text;
  switch (node.kind) {
    case Node::Kind::null:
      return "null";
    case Node::Kind::scalar:
      text = node.text;
      break;
    case Node::Kind::list:
    case Node::Kind::map:
      for (const Node& child : node.children) {
        if (text.size() > longest_shown) break;
        if (!text.empty()) text += ", ";
        text += (node.kind == Node::Kind::map ? cut_short(child.key, longest_shown) + ": " : "") +
                shown(child);
      }
      text = node.kind == Node::Kind::map ? "{" + text + "}" : "[" + text + "]";
      break;
  }
  return cut_short(text, longest_shown);
}

void refuse(const Node& node, const std::string& allowed, const std::string& reason) {
  throw InputError(node.where + ": key '" + cut_short(node.path, longest_path) + "': value '" +
                   shown(node) + "'" + (reason.empty() ? "" : " " + reason) +
                   "; allowed: " + allowed);
}

void refuse_missing(const Node& parent, const std::string& path, const std::string& allowed) {
  throw InputError(parent.where + ": key '" + cut_short(path, longest_path) +
                   "': missing; allowed: " + allowed);
}

}  // namespace stylet
