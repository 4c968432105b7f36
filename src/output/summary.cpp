#include "stylet/output/summary.hpp"

#include "stylet/base/text.hpp"
#include "stylet/output/folder.hpp"
#include "stylet/petsc/session.hpp"

#include <nlohmann/json.hpp>

#include <charconv>

namespace stylet {

namespace {

using Json = nlohmann::ordered_json;

const Json* entry(const Json& parent, std::string_view name) {
  if (parent.is_object()) {
    const auto found = parent.find(std::string(name));
    return found == parent.end() ? nullptr : &*found;
  }
  if (!parent.is_array()) return nullptr;
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  const bool is_index = error == std::errc() && end == name.data() + name.size();
  return is_index && index < parent.size() ? &parent[index] : nullptr;
}

}  // namespace

std::string summary_text(const Json& summary) {
  // A file name in the scene may hold bytes that are not UTF-8; they must not cost the summary.
  return summary.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void write_summary(MPI_Comm comm, const std::string& path, const Json& summary) {
  write_text_atomically(comm, path, rank_of(comm) == 0 ? summary_text(summary) : std::string());
}

std::optional<double> find_number(const Json& summary, std::string_view path) {
  const Json* here = &summary;
  for (const auto& name : parse_path(path).names) {
    here = here == nullptr ? nullptr : entry(*here, name);
  }
  if (here == nullptr) return std::nullopt;
  if (here->is_boolean()) return here->get<bool>() ? 1.0 : 0.0;
  if (!here->is_number()) return std::nullopt;
  return here->get<double>();
}

}  // namespace stylet
