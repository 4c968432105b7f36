// A YAML document as a plain tree whose nodes know their path and where they were written, so that
// every message can say so.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace stylet {

// In messages, bytes.
inline constexpr std::size_t longest_shown = 60;
inline constexpr std::size_t longest_path = 200;

struct Node {
  enum class Kind { null, scalar, list, map };
  Kind kind = Kind::null;
  std::string key;             ///< its name in the map above, or its number in the list above
  std::string text;            ///< of a scalar
  std::vector<Node> children;  ///< of a list or a map, in file order
  std::string path;   ///< such as needles.0.cutting.tip_length (base/text); empty at the top
  std::string where;  ///< file:line:column, or the override that wrote it

  [[nodiscard]] static Node scalar(std::string text);
  [[nodiscard]] static Node list();
  [[nodiscard]] static Node map();
  [[nodiscard]] const Node* find(const std::string& name) const;  ///< a child of a map, or null
  void add(Node child, std::string name = {});
  void place(const std::string& new_path, const std::string& new_where);  ///< the whole subtree
};

/// Throws InputError: not UTF-8, not YAML, more than one document, a key twice in a map, characters
/// that cannot be seen, a tree too deep or too large.
[[nodiscard]] Node parse_yaml(const std::string& file_name, const std::string& text);

/// YAML text that parses to the same tree.
[[nodiscard]] std::string yaml_text(const Node& document);

/// The same on one line, without its end.
[[nodiscard]] std::string yaml_line(const Node& document);

/// The deepest node on the way to `path`; its own path is shorter if that key was not written.
[[nodiscard]] const Node& closest(const Node& document, const std::string& path);

/// The value on one line, cut short if it is long.
[[nodiscard]] std::string shown(const Node& node);

/// Throws InputError `where: key 'path': value 'shown'[ reason]; allowed: ...`.
[[noreturn]] void refuse(const Node& node,
                         const std::string& allowed,
                         const std::string& reason = {});

/// Throws InputError for a key below `parent` that is not there and has to be.
[[noreturn]] void refuse_missing(const Node& parent,
                                 const std::string& path,
                                 const std::string& allowed);

}  // namespace stylet
