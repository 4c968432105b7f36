// Numbers with units, by way of udunits2: '60 kPa', '2 cm/s', '4.2e-3 m'.
#pragma once

#include <optional>
#include <string>

namespace stylet {

/// A finite number that is the whole of `text`; none otherwise.
[[nodiscard]] std::optional<double> plain_number(const std::string& text);

/// A number and the unit as written behind it, which may be empty.
struct Quantity {
  double number = 0;
  std::string unit;
};

/// None if the text does not start with a finite number. The unit is not looked at.
[[nodiscard]] std::optional<Quantity> split_quantity(const std::string& text);

/// The number of `text` in `si_unit`. Throws InputError, whose message starts with the text in
/// quotes: no unit, unknown unit, another dimension, not a finite number, trailing rubbish.
/// '3.2 cm' and '0.032 m' give the same bits.
[[nodiscard]] double to_si(const std::string& text, const std::string& si_unit);

/// A unit that users of a quantity in `si_unit` like to write: mm for m.
[[nodiscard]] std::string customary_unit(const std::string& si_unit);

}  // namespace stylet
