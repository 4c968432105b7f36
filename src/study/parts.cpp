#include "stylet/study/parts.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/output/manifest.hpp"
#include "stylet/petsc/agree.hpp"
#include "stylet/petsc/session.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <string_view>

namespace stylet {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view prefix = "part-";

/// Digits only, above 0.
std::optional<int> number_of(std::string_view text) {
  int number = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failed != std::errc() || end != text.data() + text.size() || number < 1) return std::nullopt;
  return number;
}

std::vector<int> numbers_in(const std::string& folder) {
  std::vector<int> numbers;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    const auto name = entry.path().filename().string();
    if (!name.starts_with(prefix) || !Manifest(entry.path().string()).exists() ||
        !fs::exists(entry.path() / "plan.json")) {
      continue;
    }
    if (const auto number = number_of(name.substr(prefix.size()))) numbers.push_back(*number);
  }
  std::ranges::sort(numbers);
  return numbers;
}

}  // namespace

Part parse_part(const std::string& text) {
  const auto slash = text.find('/');
  if (slash != std::string::npos) {
    const auto number = number_of(std::string_view(text).substr(0, slash));
    const auto of = number_of(std::string_view(text).substr(slash + 1));
    if (number && of && *number <= *of) return {*number, *of};
  }
  throw InputError("--part " + text + ": allowed: K/N with 1 <= K <= N, such as 2/8");
}

bool is_in(const Part& part, int run) {
  return run % part.of == part.number - 1;
}

std::string part_folder(const std::string& folder, const Part& part) {
  return folder + "/" + std::string(prefix) + std::to_string(part.number);
}

std::vector<std::string> parts_in(MPI_Comm comm, const std::string& folder) {
  std::vector<int> numbers;
  if (rank_of(comm) == 0) numbers = numbers_in(folder);
  int count = static_cast<int>(numbers.size());
  MPI_Bcast(&count, 1, MPI_INT, 0, comm);
  numbers.resize(static_cast<std::size_t>(count));
  MPI_Bcast(numbers.data(), count, MPI_INT, 0, comm);
  if (numbers.empty()) {
    throw InputError("--join: " + folder + " has no part-K of a campaign; --part K/N makes them");
  }
  std::vector<std::string> folders;
  for (const int number : numbers) folders.push_back(part_folder(folder, {number, number}));
  return folders;
}

void take_scenes(MPI_Comm comm,
                 const std::string& folder,
                 const std::string& part,
                 const std::vector<std::string>& ids) {
  agree_after(comm, [&] {
    if (rank_of(comm) != 0) return;
    for (const auto& id : ids) {
      const std::string name = "/scenes/" + id + ".yaml";
      if (!fs::exists(part + name)) continue;
      std::error_code failed;
      fs::copy_file(part + name, folder + name, fs::copy_options::overwrite_existing, failed);
      if (failed) throw IoError(folder + name + ": cannot be written: " + failed.message());
    }
  });
}

}  // namespace stylet
