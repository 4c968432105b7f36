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
  EXPECT_THAT(refusal("1,5 m", "m"), HasSubstr("unknown unit"));
  EXPECT_THAT(refusal("5 m 3", "m"), HasSubstr("unknown unit"));
  EXPECT_THAT(refusal("5 s since 2000-01-01", "s"), HasSubstr("unknown unit"));
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
