// The part of the schema table about the needle and the membrane.
#pragma once

#include "stylet/needle/parameters.hpp"
#include "stylet/scene/codec.hpp"

namespace stylet {

[[nodiscard]] Codec<NeedleParameters> needle_codec();
/// Of one that a hand enters: without motion.
[[nodiscard]] Codec<NeedleParameters> held_needle_codec();
[[nodiscard]] Codec<MembraneParameters> membrane_codec();

}  // namespace stylet
