// The folder of a run, and text files that are either whole or absent.
#pragma once

#include <mpi.h>

#include <string>

namespace stylet {

/// Collective. Creates the folder and its parents. A folder that holds anything is refused with an
/// InputError unless `force`, which removes the files this program writes and nothing else.
void prepare_folder(MPI_Comm comm, const std::string& path, bool force);

/// yes: survives a power failure, at the price of waiting for the disk. no: survives the death of
/// the program.
enum class Durable { yes, no };

/// Collective. Rank 0 writes `text` to path.tmp and renames it, so that a killed run or a full disk
/// leaves the old file. `text` of the other ranks is not used. All ranks throw exit code `io`.
void write_text_atomically(MPI_Comm comm,
                           const std::string& path,
                           const std::string& text,
                           Durable durable = Durable::yes);

}  // namespace stylet
