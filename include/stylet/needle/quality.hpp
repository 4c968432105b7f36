// Qualities of triangles (geometry/triangle.hpp, 1 is best) that edits of the mesh aim at, or refuse.
#pragma once

namespace stylet {

constexpr double good_quality = 0.2;    ///< flips mend the elements around an edit up to here
constexpr double fair_quality = 0.1;    ///< a worse hand-over waits until the tip has come closer
constexpr double least_quality = 0.03;  ///< a worse hand-over is refused
constexpr double quality_floor = 0.02;  ///< of any element: below it the run ends

}  // namespace stylet
