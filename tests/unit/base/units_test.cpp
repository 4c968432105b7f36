#include "stylet/base/units.hpp"

#include "stylet/base/errors.hpp"

#include <gmock/gmock.h>

#include <string>

namespace stylet {
namespace {

using testing::HasSubstr;

std::string refusal(const std::string& text, const std::string& unit) {
  try {
    const double value = to_si(text, unit);
    return "accepted as " + std::to_string(value);
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(Units, ConvertsToTheSameBitsAsTheSiNumber) {
  EXPECT_EQ(to_si("60 kPa", "Pa"), 60000.0);
  EXPECT_EQ(to_si("2 cm/s", "m/s"), 0.02);
  EXPECT_EQ(to_si("195 N/m", "N/m"), 195.0);
  EXPECT_EQ(to_si("0.05 s", "s"), 0.05);
  EXPECT_EQ(to_si("1000 kg/m^3", "kg/m^3"), 1000.0);
  EXPECT_EQ(to_si("4.2e-3 m", "m"), 4.2e-3);
  EXPECT_EQ(to_si("3.2 cm", "m"), 0.032);
  EXPECT_EQ(to_si("0.7 mm", "m"), 0.0007);
  EXPECT_EQ(to_si("50ms", "s"), 0.05);
  EXPECT_EQ(to_si("10 1/s", "1/s"), 10.0);
  EXPECT_EQ(to_si("10 s^-1", "1/s"), 10.0);
  EXPECT_EQ(to_si("7 kN/m^3", "N/m^3"), 7000.0);
  EXPECT_EQ(to_si("-1.5 µm", "m"), -1.5e-6);
  EXPECT_EQ(to_si(" +1 min ", "s"), 60.0);
}

TEST(Units, RefusesWithAReason) {
  EXPECT_EQ(refusal("60", "m"), "'60' needs a unit, such as mm");
  EXPECT_EQ(refusal("0", "Pa"), "'0' needs a unit, such as kPa");
  EXPECT_EQ(refusal("60 kPa", "m"), "'60 kPa' is not convertible to m");
  EXPECT_THAT(refusal("60 furlongish", "m"), HasSubstr("unknown unit 'furlongish'"));
  EXPECT_THAT(refusal("60 kPa foo", "Pa"), HasSubstr("unknown unit 'kPa foo'"));
  EXPECT_THAT(refusal("kPa", "Pa"), HasSubstr("does not start with a finite number"));
  EXPECT_THAT(refusal("", "Pa"), HasSubstr("does not start with a finite number"));
  EXPECT_THAT(refusal("nan m", "m"), HasSubstr("finite"));
  EXPECT_THAT(refusal("inf m", "m"), HasSubstr("finite"));
  EXPECT_THAT(refusal("1e999 m", "m"), HasSubstr("finite"));
  EXPECT_THAT(refusal("1e308 km", "m"), HasSubstr("finite"));
}

TEST(Units, DoesNotReadASecondNumberAsPartOfTheUnit) {
  EXPECT_THAT(refusal("60 10 kPa", "Pa"), HasSubstr("unknown unit"));
  EXPECT_THAT(refusal("1.5.2 m", "m"), HasSubstr("unknown unit"));
  EXPECT_THAT(refusal("5 m 3", "m"), HasSubstr("unknown unit"));
  EXPECT_THAT(refusal("5 s since 2000-01-01", "s"), HasSubstr("unknown unit"));
}

TEST(Units, CommasInNumbersAreNamed) {
  EXPECT_EQ(refusal("1,5 m", "m"), "'1,5 m' has a decimal comma; write 1.5 m");
  EXPECT_EQ(read_plain("-0,49").fault, "has a decimal comma; write -0.49");
  EXPECT_THAT(refusal("1,000.5 m", "m"), HasSubstr("nothing between thousands"));
  EXPECT_THAT(refusal("1.000,5 m", "m"), HasSubstr("nothing between thousands"));
  EXPECT_THAT(refusal(",5 m", "m"), HasSubstr("does not start with a finite number"));
  EXPECT_THAT(refusal("5, m", "m"), HasSubstr("unknown unit"));
}

TEST(Units, WhatTypesettersWriteIsRead) {
  EXPECT_EQ(to_si("\u22123.2 cm", "m"), -0.032);      // minus
  EXPECT_EQ(to_si("3.2e\u22121\u00A0m", "m"), 0.32);  // and non-breaking space
  EXPECT_EQ(to_si("\u201332\u202Fmm", "m"), -0.032);  // dash and narrow space
  EXPECT_EQ(plain_number("\u22120.5"), -0.5);
  EXPECT_EQ(to_si("7 \u03BCm", "m"), 7e-6);  // Greek letter
  EXPECT_THAT(refusal("1\u20132 m", "m"), HasSubstr("unknown unit '-2 m'"));
}

TEST(Units, DegreesHaveTheirShortName) {
  EXPECT_DOUBLE_EQ(to_si("30 deg", "rad"), 0.52359877559829882);
  EXPECT_EQ(to_si("30 deg", "rad"), to_si("30 degrees", "rad"));
  EXPECT_EQ(to_si("30\u00B0", "rad"), to_si("30 degree", "rad"));
  EXPECT_EQ(refusal("30 deg", "m"), "'30 deg' is not convertible to m");
}

TEST(Units, NullCharactersDoNotEndTheNumber) {
  using namespace std::string_literals;
  EXPECT_EQ(refusal("1\0.7 N"s, "N"), "'1<U+0000>.7 N' has the unknown unit '<U+0000>.7 N'");
  EXPECT_FALSE(plain_number("1\0"s));
}

TEST(Units, DoesNotTakeAFrequencyForATime) {
  EXPECT_EQ(refusal("5 Hz", "s"), "'5 Hz' is not convertible to s");
}

TEST(Units, PlainNumbersHaveNoUnit) {
  EXPECT_EQ(plain_number("0.49"), 0.49);
  EXPECT_EQ(plain_number("-1e-3"), -1e-3);
  EXPECT_FALSE(plain_number("0.49 m"));
  EXPECT_FALSE(plain_number("nan"));
  EXPECT_FALSE(plain_number(""));
  EXPECT_FALSE(plain_number("+-1"));
}

}  // namespace
}  // namespace stylet
