#include "stylet/scene/document.hpp"

#include "stylet/base/errors.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <set>
#include <utility>

namespace stylet {

namespace {

std::string below(const std::string& path, const std::string& name) {
  return path.empty() ? name : path + "." + name;
}

/// Turns yaml-cpp's tree into ours. Depth and size are bounded: anchors can make a tree endless.
class Reader {
 public:
  explicit Reader(std::string file) : file_(std::move(file)) {}

  Node read(const YAML::Node& from, const std::string& path, int depth) {
    constexpr int deepest = 16;
    constexpr int most = 1'000'000;
    const std::string where = position(from.Mark());
    if (depth > deepest || ++n_nodes_ > most) {
      throw InputError(where + ": key '" + path + "': nested too deeply or too large");
    }
    Node node;
    node.path = path;
    node.where = where;
    if (from.IsScalar()) {
      node.kind = Node::Kind::scalar;
      node.text = from.Scalar();
    } else if (from.IsSequence()) {
      node.kind = Node::Kind::list;
      for (const YAML::Node& item : from) {
        const std::string number = std::to_string(node.children.size());
        node.children.push_back(read(item, below(path, number), depth + 1));
        node.children.back().key = number;
      }
    } else if (from.IsMap()) {
      node.kind = Node::Kind::map;
      read_map(from, node, depth);
    }
    return node;
  }

  [[nodiscard]] std::string position(const YAML::Mark& mark) const {
    if (mark.is_null()) return file_;
    return file_ + ":" + std::to_string(mark.line + 1) + ":" + std::to_string(mark.column + 1);
  }

 private:
  void read_map(const YAML::Node& from, Node& node, int depth) {
    std::set<std::string> names;
    for (const auto& entry : from) {
      const std::string where = position(entry.first.Mark());
      if (!entry.first.IsScalar()) throw InputError(where + ": a key must be a plain word");
      const std::string& name = entry.first.Scalar();
      const std::string path = below(node.path, name);
      if (!names.insert(name).second) {
        Node again = read(entry.second, path, depth + 1);
        again.where = where;
        refuse(again, "once", "is the second one of this key");
      }
      node.children.push_back(read(entry.second, path, depth + 1));
      node.children.back().key = name;
      if (node.children.back().kind != Node::Kind::scalar) node.children.back().where = where;
    }
  }

  std::string file_;
  int n_nodes_ = 0;
};

bool is_plain_list(const Node& node) {
  return std::ranges::all_of(node.children, [](const Node& child) {
    return child.kind == Node::Kind::scalar || child.kind == Node::Kind::null;
  });
}

void emit(YAML::Emitter& out, const Node& node) {
  switch (node.kind) {
    case Node::Kind::null:
      out << YAML::Null;
      break;
    case Node::Kind::scalar:
      out << node.text;
      break;
    case Node::Kind::list:
      if (is_plain_list(node)) out << YAML::Flow;
      out << YAML::BeginSeq;
      for (const Node& child : node.children) emit(out, child);
      out << YAML::EndSeq;
      break;
    case Node::Kind::map:
      out << YAML::BeginMap;
      for (const Node& child : node.children) {
        out << YAML::Key << child.key << YAML::Value;
        emit(out, child);
      }
      out << YAML::EndMap;
      break;
  }
}

}  // namespace

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

Node parse_yaml(const std::string& file_name, const std::string& text) {
  Reader reader(file_name);
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(text);
    if (documents.size() > 1) {
      throw InputError(reader.position(documents[1].Mark()) +
                       ": a second YAML document; allowed: one");
    }
    Node root;
    if (!documents.empty()) root = reader.read(documents[0], {}, 0);
    root.where = file_name + ":1:1";
    return root;
  } catch (const YAML::Exception& error) {
    throw InputError(reader.position(error.mark) + ": not valid YAML: " + error.msg);
  }
}

std::string yaml_text(const Node& document) {
  YAML::Emitter out;
  emit(out, document);
  return std::string(out.c_str()) + "\n";
}

const Node& closest(const Node& document, const std::string& path) {
  // By prefix and not by splitting: names that users choose may contain dots.
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
  constexpr std::size_t longest = 60;
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
        if (text.size() > longest) break;
        if (!text.empty()) text += ", ";
        text += (node.kind == Node::Kind::map ? child.key + ": " : "") + shown(child);
      }
      text = node.kind == Node::Kind::map ? "{" + text + "}" : "[" + text + "]";
      break;
  }
  return text.size() > longest ? text.substr(0, longest) + "..." : text;
}

void refuse(const Node& node, const std::string& allowed, const std::string& reason) {
  throw InputError(node.where + ": key '" + node.path + "': value '" + shown(node) + "'" +
                   (reason.empty() ? "" : " " + reason) + "; allowed: " + allowed);
}

void refuse_missing(const Node& parent, const std::string& path, const std::string& allowed) {
  throw InputError(parent.where + ": key '" + path + "': missing; allowed: " + allowed);
}

}  // namespace stylet
