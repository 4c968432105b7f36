// Changes to a scene from the command line: time.step=0.5 ms.
#pragma once

#include "stylet/scene/document.hpp"

#include <string>

namespace stylet {

/// Applies one `key=value`; the value is YAML, null removes the key. The name of the action may be
/// left out: needles.0.motion.1.depth=4 cm. Names with dots stand in double quotes:
/// tissue.regions."lobe.left".density=1 g/cm^3. Throws InputError if the schema has no such key.
void apply_override(Node& document, const std::string& file_name, const std::string& override_text);

}  // namespace stylet
