// How much memory there is.
#pragma once

namespace stylet {

/// Bytes that processes here may use together: of the machine with its swap space, or less where a
/// control group or a limit of this process allows less. Infinite where the system does not say.
[[nodiscard]] double memory_here();

}  // namespace stylet
