// Viridis (van der Walt and Smith 2015): brightness grows evenly, also for who tells no red from green.
#pragma once

#include <array>
#include <cstdint>

namespace stylet {

/// Red, green, blue at even distances from the smallest to the largest value.
inline constexpr std::array<std::array<std::uint8_t, 3>, 9> viridis{{{68, 1, 84},
                                                                     {71, 45, 123},
                                                                     {59, 82, 139},
                                                                     {44, 114, 142},
                                                                     {33, 145, 140},
                                                                     {40, 174, 128},
                                                                     {94, 201, 98},
                                                                     {173, 220, 48},
                                                                     {253, 231, 37}}};

}  // namespace stylet
