// Finds out that a disk is full before a parallel library meets it.
#pragma once

#include <cstdint>
#include <string>

namespace stylet {

/// Makes room for `bytes` more behind the end of an existing file, or throws an IoError and leaves
/// the file as it was. File systems that cannot reserve are asked for their free space instead.
/// Not collective.
void reserve_space(const std::string& path, std::uint64_t bytes);

/// Throws an IoError in the name of `path` unless a file `draft` of so many bytes can be made; removes
/// it again. Not collective.
void require_room(const std::string& draft, const std::string& path, std::uint64_t bytes);

}  // namespace stylet
