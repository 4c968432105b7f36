// summary.json, and how an expectation finds its number in it.
#pragma once

#include <mpi.h>
#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <string_view>

namespace stylet {

/// As it stands in the file. A number that is not finite becomes null, because JSON has no text for
/// it.
[[nodiscard]] std::string summary_text(const nlohmann::ordered_json& summary);

/// Collective. Rank 0's value is written, whole or not at all.
void write_summary(MPI_Comm comm, const std::string& path, const nlohmann::ordered_json& summary);

/// The number at a path like `seeds.0.placement_error`; true and false count as 1 and 0. Nothing if
/// there is no such entry or it is no number.
[[nodiscard]] std::optional<double> find_number(const nlohmann::ordered_json& summary,
                                                std::string_view path);

}  // namespace stylet
