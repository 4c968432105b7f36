// Numbers with units, by way of udunits2: '60 kPa', '2 cm/s', '4.2e-3 m'.
#pragma once

#include <optional>
#include <string>

namespace stylet {

/// A value, or why there is none; exactly one of the two.
struct Reading {
  double value = 0;
  std::string fault = {};  ///< such as "needs a unit, such as mm"
};

/// The number of `text` in `si_unit`; refused: no unit, unknown unit, another dimension, not a finite
/// number, trailing rubbish. '3.2 cm' and '0.032 m' give the same bits. A typographic minus and
/// non-breaking spaces are what they look like; a decimal comma is refused by its name.
[[nodiscard]] Reading read_quantity(const std::string& text, const std::string& si_unit);

/// '3.2 cm', exactly; without a unit the number alone.
[[nodiscard]] std::string with_unit(double value, const std::string& unit);

/// A finite number that is the whole of `text`.
[[nodiscard]] Reading read_plain(const std::string& text);
[[nodiscard]] std::optional<double> plain_number(const std::string& text);

/// As read_quantity. Throws InputError, whose message starts with the text in quotes.
[[nodiscard]] double to_si(const std::string& text, const std::string& si_unit);

/// A number and the unit as written behind it, which may be empty.
struct Quantity {
  double number = 0;
  std::string unit;
};

/// None if the text does not start with a finite number. The unit is not looked at.
[[nodiscard]] std::optional<Quantity> split_quantity(const std::string& text);

/// A unit that users of a quantity in `si_unit` like to write: mm for m.
[[nodiscard]] std::string customary_unit(const std::string& si_unit);

}  // namespace stylet
