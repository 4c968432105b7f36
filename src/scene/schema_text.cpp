#include "stylet/scene/schema.hpp"

namespace stylet {

namespace {

void add_rows(const Key& parent, const std::string& path, std::vector<SchemaRow>& rows) {
  for (const Key& key : parent.keys) {
    const std::string key_path = path.empty() ? key.name : path + "." + key.name;
    rows.push_back({key_path, &key});
    if (key.form == Key::Form::list) {
      add_rows(key.keys.front(), key_path + "[]", rows);
    } else if (key.form == Key::Form::named) {
      add_rows(key.keys.front(), key_path + "." + key.keys.front().name, rows);
    } else {
      add_rows(key, key_path, rows);
    }
  }
}

/// 'number in m: > 0 m'.
std::string kind_text(const Key& key) {
  std::string text = key.type;
  if (!key.unit.empty()) text += " in " + key.unit;
  if (!key.allowed.empty()) text += ": " + key.allowed;
  return text;
}

std::string default_text(const Key& key) {
  if (key.required) return "required";
  return key.fallback.empty() ? "none" : key.fallback;
}

}  // namespace

std::vector<SchemaRow> schema_rows() {
  std::vector<SchemaRow> rows;
  add_rows(scene_codec().key, {}, rows);
  return rows;
}

std::string schema_text() {
  std::string text;
  for (const auto& [path, key] : schema_rows()) {
    text += path + "\n    " + key->doc + "\n    " + kind_text(*key) + "; ";
    text += (key->required ? "" : "default: ") + default_text(*key) + "\n";
  }
  return text;
}

std::string schema_markdown() {
  std::string text = "| key | meaning | type and range | default |\n|---|---|---|---|\n";
  for (const auto& [path, key] : schema_rows()) {
    text += "| `" + path + "` | " + key->doc + " | " + kind_text(*key) + " | " +
            default_text(*key) + " |\n";
  }
  return text;
}

}  // namespace stylet
