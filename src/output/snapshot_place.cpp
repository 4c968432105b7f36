#include "stylet/output/snapshot_place.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/fingerprint.hpp"
#include "stylet/output/committed_file.hpp"

#include <algorithm>
#include <filesystem>
#include <set>

namespace stylet {

void archive(Archive& archive, SnapshotPlace& place) {
  auto& [n_written, n_meshes, time, mesh_version, connectivity_version, tissue, shape,
         displacement] = place;
  archive("n_written", n_written);
  archive("n_meshes", n_meshes);
  archive("time", time);
  archive("mesh_version", mesh_version);
  archive("connectivity_version", connectivity_version);
  archive("tissue_xdmf", tissue);
  archive("shape_xdmf", shape);
  archive("displacement", displacement);
}

std::string numbered(const std::string& name, int number) {
  constexpr std::size_t digits = 6;
  const std::string text = std::to_string(number);
  return name + '_' + std::string(digits - std::min(digits, text.size()), '0') + text;
}

void require_there(const std::string& path) {
  if (std::filesystem::exists(path)) return;
  throw InputError(path +
                   ": is not there, and the checkpoint goes on with it; put it back, or begin anew "
                   "with --force");
}

std::string displacement_of(const CommittedFile& file, int snapshot) {
  const auto u = read_array(file.open(numbered("step", snapshot) + "/u").get());
  return fingerprint({reinterpret_cast<const char*>(u.data()), u.size() * sizeof(double)});
}

std::vector<std::string> later_than(const SnapshotPlace& place,
                                    const CommittedFile& file,
                                    const std::string& path) {
  const auto names = file.names();
  std::set<std::string> later(names.begin(), names.end());
  bool is_whole = place.n_written > 0;
  const auto take = [&](const char* name, int n) {
    for (int i = 0; i < n; ++i) is_whole = later.erase(numbered(name, i)) == 1 && is_whole;
  };
  take("step", place.n_written);
  take("mesh", place.n_meshes);
  const auto last_time = [&] {
    return number_attribute(file.open(numbered("step", place.n_written - 1)).get(), "time");
  };
  if (is_whole && last_time() == place.time &&
      displacement_of(file, place.n_written - 1) == place.displacement) {
    return {later.begin(), later.end()};
  }
  throw InputError(path +
                   ": has not the snapshots that the checkpoint goes on with: it was replaced; put "
                   "it back, or begin anew with --force");
}

}  // namespace stylet
