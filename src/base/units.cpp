#include "stylet/base/units.hpp"

#include "stylet/base/errors.hpp"
#include "stylet/base/text.hpp"
#include "stylet/base/utf8.hpp"

#include <udunits2.h>

#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <regex>

namespace stylet {

namespace {

template <auto free>
struct Free {
  template <class T>
  void operator()(T* pointer) const {
    free(pointer);
  }
};
using System = std::unique_ptr<ut_system, Free<ut_free_system>>;
using Unit = std::unique_ptr<ut_unit, Free<ut_free>>;
using Converter = std::unique_ptr<cv_converter, Free<cv_free>>;

ut_system* unit_system() {
  static const System system = [] {
    ut_set_error_message_handler(ut_ignore);
    System loaded(ut_read_xml(nullptr));
    if (!loaded) throw IoError("the unit database of udunits2 cannot be read");
    return loaded;
  }();
  return system.get();
}

/// udunits2 also reads numbers, offsets and dates in a unit ('10 kPa' in '60 10 kPa'): only names
/// with exponents, joined by products and quotients, are let through.
bool looks_like_unit(const std::string& unit) {
  static const std::regex pattern(
      R"((1 ?/ ?)?[^ 0-9*/.^()@+-]+(\^?-?[0-9])?( ?[*/. ] ?[^ 0-9*/.^()@+-]+(\^?-?[0-9])?)*)");
  constexpr std::size_t longest = 64;  // std::regex recurses
  return unit.size() < longest && std::regex_match(unit, pattern);
}

Unit parse_unit(const std::string& unit) {
  if (!looks_like_unit(unit)) return nullptr;
  const std::string known = unit == "deg" ? "degree" : unit;  // what udunits2 calls it
  return Unit(ut_parse(unit_system(), known.c_str(), UT_UTF8));
}

/// Same dimension. Not ut_are_convertible, which takes a frequency for a time.
bool same_dimension(const Unit& from, const Unit& to) {
  const Unit ratio(ut_divide(from.get(), to.get()));
  return ratio && ut_is_dimensionless(ratio.get()) != 0;
}

double convert(double value, const Unit& from, const Unit& to) {
  const Converter converter(ut_get_converter(from.get(), to.get()));
  const double factor = cv_convert_double(converter.get(), 1.0);
  // Dividing by the whole number 100 is rounded once, multiplying by 0.01 twice.
  const double divisor = std::round(1 / factor);
  return factor < 1 && std::abs(divisor * factor - 1) < 1e-15 ? value / divisor : value * factor;
}

/// With the minus and the spaces of a keyboard for those of a typesetter.
std::string as_typed(std::string_view text) {
  std::string typed;
  while (!text.empty()) {
    const Glyph glyph = first_glyph(text);
    const char32_t code = glyph.valid ? glyph.code : 0;
    if (is_typographic_space(code)) {
      typed += ' ';
    } else if (code == 0x2212 || (code >= 0x2010 && code <= 0x2013)) {  // minus, hyphens, dashes
      typed += '-';
    } else {
      typed += text.substr(0, glyph.length);
    }
    text.remove_prefix(glyph.length);
  }
  return typed;
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Why a text with a comma in its number is none; empty if there is no such comma.
std::string comma_fault(const std::string& text) {
  const auto comma = text.find(',');
  if (comma == 0 || comma == std::string::npos || comma + 1 == text.size()) return {};
  if (!is_digit(text[comma - 1]) || !is_digit(text[comma + 1])) return {};
  std::string meant = text;
  meant[comma] = '.';
  if (meant.find_first_of(",.", comma + 1) != std::string::npos || text.find('.') < comma) {
    return "has a comma in its number; numbers have a decimal point and nothing between thousands";
  }
  return "has a decimal comma; write " + meant;
}

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\n");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\n") - first + 1);
}

}  // namespace

std::optional<Quantity> split_quantity(const std::string& text) {
  const std::string body = trimmed(as_typed(text));
  const char* first = body.data();
  const char* const last = first + body.size();
  if (body.size() > 1 && body[0] == '+' && body[1] != '-') ++first;  // not known to from_chars
  double number = 0;
  const auto [end, error] = std::from_chars(first, last, number);
  if (error != std::errc() || !std::isfinite(number)) return std::nullopt;
  return Quantity{number, trimmed({end, last})};
}

std::string with_unit(double value, const std::string& unit) {
  return exact(value) + (unit.empty() ? "" : " " + unit);
}

Reading read_plain(const std::string& text) {
  const auto leading = split_quantity(text);
  if (leading && leading->unit.empty()) return {leading->number};
  const std::string comma = comma_fault(text);
  if (!comma.empty()) return {0, comma};
  if (!leading) return {0, "is not a finite number"};
  return {0, "has '" + cut_short(leading->unit, 60) + "' behind its number"};
}

std::optional<double> plain_number(const std::string& text) {
  const Reading reading = read_plain(text);
  return reading.fault.empty() ? std::optional(reading.value) : std::nullopt;
}

Reading read_quantity(const std::string& text, const std::string& si_unit) {
  const auto leading = split_quantity(text);
  if (!leading) return {0, "does not start with a finite number"};
  if (leading->unit.empty()) return {0, "needs a unit, such as " + customary_unit(si_unit)};
  const Unit from = parse_unit(leading->unit);
  if (!from) {
    const std::string comma = comma_fault(text);
    return {0,
            comma.empty() ? "has the unknown unit '" + cut_short(leading->unit, 60) + "'" : comma};
  }
  const Unit to = parse_unit(si_unit);
  if (!to) throw Error(ExitCode::other, "'" + si_unit + "' is not a unit of udunits2");
  if (!same_dimension(from, to)) return {0, "is not convertible to " + si_unit};
  const double value = convert(leading->number, from, to);
  if (!std::isfinite(value)) return {0, "is not a finite number in " + si_unit};
  return {value};
}

double to_si(const std::string& text, const std::string& si_unit) {
  const Reading reading = read_quantity(text, si_unit);
  if (reading.fault.empty()) return reading.value;
  throw InputError("'" + cut_short(text, 60) + "' " + reading.fault);
}

std::string customary_unit(const std::string& si_unit) {
  static const std::map<std::string, std::string> customary = {
      {"m", "mm"}, {"s", "ms"}, {"Pa", "kPa"}, {"m/s", "cm/s"}};
  const auto found = customary.find(si_unit);
  return found == customary.end() ? si_unit : found->second;
}

}  // namespace stylet
