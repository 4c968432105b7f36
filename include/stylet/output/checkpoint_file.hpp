// A checkpoint on disk: columns of archives in one HDF5 file that is whole or absent, and says so.
//
//   /about   what, when, of which scene and mesh
//   /state   what the next steps hang on (Archive), in the order of the mesh's source
//   /output  how far the files of the run are
//
// The file is made in memory and then written at once, so that a full disk is met outside of HDF5. Behind
// HDF5's own bytes stands the SHA-256 of all before: a torn or changed file is known before HDF5 reads it.
#pragma once

#include "stylet/base/archive.hpp"

#include <mpi.h>

#include <map>
#include <optional>
#include <string>

namespace stylet {

/// Columns by section.
using Checkpoint = std::map<std::string, Archive::Columns>;

/// Of what is in a file; another one is refused.
inline constexpr std::int64_t checkpoint_format = 2;

/// Collective. Rank 0 writes beside `path`, waits for the disk and renames; its columns count. Throws
/// IoError and leaves nothing where that fails. Returns the bytes written.
std::size_t write_checkpoint(MPI_Comm comm, const std::string& path, const Checkpoint& checkpoint);

/// Collective. The same columns on all ranks; none, and why, of what is no whole checkpoint. Throws InputError
/// for one of another format, IoError where reading fails.
[[nodiscard]] std::optional<Checkpoint> read_checkpoint(MPI_Comm comm,
                                                        const std::string& path,
                                                        std::string& fault);

}  // namespace stylet
