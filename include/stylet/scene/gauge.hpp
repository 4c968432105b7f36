// Outer diameters of hypodermic needles by their gauge.
//
// The gauges are those of ISO 9626:2016, designated metric sizes 3.4 mm (10) to 0.18 mm (34), which allows a range
// of outer diameters for each; the nominal ones here are those of needle wire gauge, derived from the Birmingham
// wire gauge, to 0.001 inch or finer.
#pragma once

#include <array>

namespace stylet {

struct NeedleGauge {
  int gauge = 0;
  double diameter = 0;  ///< mm
};

inline constexpr std::array<NeedleGauge, 25> needle_gauges = {
    {{10, 3.404},  {11, 3.048},  {12, 2.769},  {13, 2.413},  {14, 2.108},
     {15, 1.829},  {16, 1.651},  {17, 1.473},  {18, 1.270},  {19, 1.067},
     {20, 0.9081}, {21, 0.8192}, {22, 0.7176}, {23, 0.6414}, {24, 0.5652},
     {25, 0.5144}, {26, 0.4636}, {27, 0.4128}, {28, 0.3620}, {29, 0.3366},
     {30, 0.3112}, {31, 0.2604}, {32, 0.2350}, {33, 0.2096}, {34, 0.1842}}};

}  // namespace stylet
