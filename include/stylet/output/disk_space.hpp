// Finds out that a disk is full before a parallel library meets it.
#pragma once

#include <cstdint>
#include <string>

namespace stylet {

/// Makes room for `bytes` more behind the end of an existing file, or throws an IoError and leaves
/// the file as it was. File systems that cannot reserve are asked for their free space instead.
/// Not collective.
void reserve_space(const std::string& path, std::uint64_t bytes);

}  // namespace stylet
