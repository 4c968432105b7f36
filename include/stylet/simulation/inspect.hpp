// What a checkpoint holds, for a reader.
#pragma once

#include <mpi.h>

#include <string>

namespace stylet {

/// Collective. Lines of text. snapshot: a folder that gets snapshots.h5 of this state; empty for none.
/// Throws InputError for what is no whole checkpoint of this format, IoError.
[[nodiscard]] std::string inspect(MPI_Comm comm,
                                  const std::string& checkpoint,
                                  const std::string& snapshot);

}  // namespace stylet
