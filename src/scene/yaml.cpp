// YAML to and from the tree of document.hpp; the only file that knows yaml-cpp.
#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/base/utf8.hpp"
#include "stylet/scene/document.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

namespace stylet {

namespace {

/// Builds our tree from the events of yaml-cpp's parser. Depth and memory are bounded: anchors make
/// a small text a large tree, and a long key stands in the path of everything below it.
class Builder : public YAML::EventHandler {
 public:
  explicit Builder(std::string file) : file_(std::move(file)) {}

  [[nodiscard]] std::string position(const YAML::Mark& mark) const {
    if (mark.is_null()) return file_;
    return file_ + ":" + std::to_string(mark.line + 1) + ":" + std::to_string(mark.column + 1);
  }

  [[nodiscard]] Node take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark& mark) override {
    // A stray closing bracket or comma ends a document too; without this it would go on for ever.
    if (started_) {
      throw InputError(position(mark) +
                       ": a second YAML document, or text behind the end of the first; allowed: "
                       "one document");
    }
    started_ = true;
  }
  void OnDocumentEnd() override {
    if (!complex_key_.empty()) throw InputError(complex_key_ + ": a key must be a plain word");
  }

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { add(begun(mark), anchor); }

  void OnScalar(const YAML::Mark& mark,
                const std::string& /*tag*/,
                YAML::anchor_t anchor,
                const std::string& value) override {
    refuse_hidden(mark, value);
    if (is_key_next()) {
      begin_key(mark, value);
      return;
    }
    Node node = begun(mark);
    node.kind = Node::Kind::scalar;
    node.text = value;
    add(std::move(node), anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchored_.find(anchor);
    if (found == anchored_.end()) {
      throw InputError(position(mark) + ": nested too deeply: an anchor that is inside itself");
    }
    note_complex_key(mark);
    Node node = found->second;
    move_below(node, path_of_next());
    add(std::move(node), YAML::NullAnchor);
  }

  void OnSequenceStart(const YAML::Mark& mark,
                       const std::string& /*tag*/,
                       YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    open(mark, anchor, Node::Kind::list);
  }
  void OnSequenceEnd() override { close(); }

  void OnMapStart(const YAML::Mark& mark,
                  const std::string& /*tag*/,
                  YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    open(mark, anchor, Node::Kind::map);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    Node node;
    YAML::anchor_t anchor;
    std::optional<std::string> key;  ///< of a map: what the next value belongs to
    std::string key_where;
    std::set<std::string> seen = {};
  };

  [[nodiscard]] bool is_key_next() const {
    return !open_.empty() && open_.back().node.kind == Node::Kind::map && !open_.back().key;
  }

  /// Thrown at the end only: an unclosed bracket looks like such a key until the parser misses its end.
  void note_complex_key(const YAML::Mark& mark) {
    if (is_key_next() && complex_key_.empty()) complex_key_ = position(mark);
  }

  void begin_key(const YAML::Mark& mark, const std::string& key) {
    const std::string where = position(mark);
    for (std::string_view rest = key; !rest.empty();) {
      const Glyph glyph = first_glyph(rest);
      if (is_typographic_space(glyph.code)) {
        throw InputError(where + ": key '" + cut_short(key, longest_shown) + "' has a " +
                         named(glyph) + ", which YAML does not take for a space");
      }
      rest.remove_prefix(glyph.length);
    }
    open_.back().key = key;
    open_.back().key_where = where;
  }

  void refuse_hidden(const YAML::Mark& mark, const std::string& value) const {
    for (std::string_view rest = value; !rest.empty();) {
      const Glyph glyph = first_glyph(rest);
      if (is_control(glyph.code) || is_invisible(glyph.code)) {
        throw InputError(position(mark) + ": '" + cut_short(value, longest_shown) +
                         "' has an invisible character, " + named(glyph));
      }
      rest.remove_prefix(glyph.length);
    }
    constexpr const char* quotes[][2] = {{"“", "”"}, {"„", "“"}, {"”", "”"}, {"‘", "’"},
                                         {"’", "’"}, {"«", "»"}, {"»", "«"}};
    for (const auto& [left, right] : quotes) {
      if (!value.starts_with(left) || !value.ends_with(right) || value.size() < 4) continue;
      throw InputError(position(mark) + ": " + cut_short(value, longest_shown) +
                       ": typographic quotes are part of the text for YAML; write \"...\"");
    }
  }

  [[nodiscard]] std::string path_of_next() const {
    if (open_.empty()) return {};
    const Open& parent = open_.back();
    return below(parent.node.path,
                 parent.key ? *parent.key : std::to_string(parent.node.children.size()));
  }

  [[nodiscard]] Node begun(const YAML::Mark& mark) {
    note_complex_key(mark);
    Node node;
    node.path = path_of_next();
    node.where = position(mark);
    return node;
  }

  void open(const YAML::Mark& mark, YAML::anchor_t anchor, Node::Kind kind) {
    constexpr std::size_t deepest = 16;
    Node node = begun(mark);
    if (open_.size() > deepest) fail_as_too_large(node);
    node.kind = kind;
    open_.push_back({std::move(node), anchor, {}, {}});
  }

  void close() {
    Open done = std::move(open_.back());
    open_.pop_back();
    add(std::move(done.node), done.anchor);
  }

  void add(Node node, YAML::anchor_t anchor) {
    if (open_.empty()) {
      root_ = std::move(node);
      return;
    }
    Open& parent = open_.back();
    if (is_key_next()) {
      parent.key = "?";
      return;
    }
    if (parent.node.kind == Node::Kind::map) {
      node.key = *std::exchange(parent.key, std::nullopt);
      // A block is where its key is.
      const bool second = !parent.seen.insert(node.key).second;
      if (second || node.kind != Node::Kind::scalar) node.where = parent.key_where;
      if (second) refuse(node, "once", "is the second one of this key");
    } else {
      node.key = std::to_string(parent.node.children.size());
    }
    count(node);
    if (anchor != YAML::NullAnchor) {
      anchored_[anchor] = node;
      count_all(node);
    }
    parent.node.children.push_back(std::move(node));
  }

  void count(const Node& node) {
    constexpr std::size_t most = 128 << 20;
    n_bytes_ +=
        sizeof(Node) + node.key.size() + node.text.size() + node.path.size() + node.where.size();
    if (n_bytes_ > most) fail_as_too_large(node);
  }

  void count_all(const Node& node) {
    count(node);
    for (const Node& child : node.children) count_all(child);
  }

  void move_below(Node& node, const std::string& path) {
    node.path = path;
    count(node);
    for (Node& child : node.children) move_below(child, below(path, child.key));
  }

  [[noreturn]] static void fail_as_too_large(const Node& node) {
    throw InputError(node.where + ": key '" + cut_short(node.path, longest_path) +
                     "': nested too deeply or too large");
  }

  std::string file_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, Node> anchored_;
  Node root_;
  std::string complex_key_;  ///< where the first one is
  std::size_t n_bytes_ = 0;
  bool started_ = false;
};

/// What the eye takes for YAML and the parser does not, on the line of an error or just before it.
std::string likely_cause(std::string_view text, int line) {
  int number = 1;
  std::string cause;
  while (!text.empty() && number <= line) {
    const std::string_view content = text.substr(0, text.find('\n'));
    const auto first = content.find_first_not_of(' ');
    if (first != std::string_view::npos && content[first] == '\t') {
      cause = "; line " + std::to_string(number) + " begins with a tab: indent with spaces";
    }
    for (std::string_view rest = content; !rest.empty() && rest[0] != '#';) {
      const Glyph glyph = first_glyph(rest);
      if (is_typographic_space(glyph.code) || is_invisible(glyph.code)) {
        cause = "; line " + std::to_string(number) + " has a " + named(glyph) +
                ", which YAML does not take for a space";
      }
      rest.remove_prefix(glyph.length);
    }
    if (content.size() == text.size()) break;
    text.remove_prefix(content.size() + 1);
    ++number;
  }
  return cause;
}

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

Node parse_yaml(const std::string& file_name, const std::string& text) {
  const std::string_view body = without_byte_order_mark(text);
  if (const auto fault = fault_of_text(body)) {
    throw InputError(file_name + ":" + std::to_string(fault->line) + ":" +
                     std::to_string(fault->column) + ": " + fault->what);
  }
  Builder builder(file_name);
  try {
    std::istringstream stream{std::string(body)};
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    throw InputError(builder.position(error.mark) + ": not valid YAML: " + error.msg +
                     likely_cause(body, error.mark.line + 1));
  }
  Node root = builder.take();
  root.where = file_name + ":1:1";
  return root;
}

std::string yaml_line(const Node& document) {
  YAML::Emitter out;
  out.SetMapFormat(YAML::Flow);
  out.SetSeqFormat(YAML::Flow);
  emit(out, document);
  return out.c_str();
}

std::string yaml_text(const Node& document) {
  YAML::Emitter out;
  emit(out, document);
  return std::string(out.c_str()) + "\n";
}

}  // namespace stylet
