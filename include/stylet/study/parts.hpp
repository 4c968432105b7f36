// A campaign in parts, for the tasks of a job array: each works in a folder of its own, part-K, and the
// parts are joined later.
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

namespace stylet {

/// Every `of`th run, beginning with run number - 1; all runs if `of` is 1.
struct Part {
  int number = 1;
  int of = 1;
};

/// From "K/N". Throws InputError unless 1 <= K <= N.
[[nodiscard]] Part parse_part(const std::string& text);

[[nodiscard]] bool is_in(const Part& part, int run);

[[nodiscard]] std::string part_folder(const std::string& folder, const Part& part);

/// Collective. The folders of the parts that have begun, by number. Throws InputError if there are
/// none.
[[nodiscard]] std::vector<std::string> parts_in(MPI_Comm comm, const std::string& folder);

/// Collective. Copies scenes/<id>.yaml of a part to `folder`; one that the part does not have is left
/// out.
void take_scenes(MPI_Comm comm,
                 const std::string& folder,
                 const std::string& part,
                 const std::vector<std::string>& ids);

}  // namespace stylet
