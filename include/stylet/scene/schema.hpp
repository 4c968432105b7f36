// The one table of everything a scene may say. Parsing, checking of single values, writing, the
// overrides and the documentation are all read off it.
#pragma once

#include "stylet/scene/codec.hpp"
#include "stylet/scene/scene.hpp"

#include <string>
#include <vector>

namespace stylet {

/// Reads and writes all of a scene but Scene::file.
[[nodiscard]] const Codec<Scene>& scene_codec();

/// One key, flat: needles[].cutting.tip_length.
struct SchemaRow {
  std::string path;
  const Key* key = nullptr;
};
[[nodiscard]] std::vector<SchemaRow> schema_rows();

/// For the terminal.
[[nodiscard]] std::string schema_text();

/// A table for the README.
[[nodiscard]] std::string schema_markdown();

}  // namespace stylet
