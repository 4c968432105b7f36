#include "stylet/image/ultrasound.hpp"

#include "stylet/geometry/triangle.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace stylet {

namespace {

std::size_t at(const Picture& frame, int column, int row) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(frame.width) +
         static_cast<std::size_t>(column);
}

// Centre of a pixel.
ReferencePoint place(const Picture& frame, int column, int row) {
  return {frame.origin.x + (column + 0.5) * frame.size.x / frame.width,
          frame.origin.y + (frame.height - row - 0.5) * frame.size.y / frame.height};
}

// All bits of three numbers mixed (the finaliser of MurmurHash3, public domain).
std::uint32_t hashed(std::uint32_t seed, std::uint32_t x, std::uint32_t y) {
  std::uint32_t h = seed * 0x9e3779b1U ^ x * 0x85ebca6bU ^ y * 0xc2b2ae35U;
  for (const std::uint32_t factor : {0x85ebca6bU, 0xc2b2ae35U}) {
    h ^= h >> 16U;
    h *= factor;
    h ^= h >> 13U;
  }
  return h ^ h >> 16U;
}

// Weights of scatterers around a point, from it outwards: the beam is wide across and short along.
struct Grain {
  std::array<int, 10> across;
  std::array<int, 5> along;
};
constexpr Grain fine{{16, 14, 9, 4, 1}, {6, 4, 1}};
constexpr Grain coarse{{32, 31, 28, 23, 17, 11, 7, 4, 2, 1}, {16, 12, 6, 2}};

// Two parts of an echo, in quadrature.
struct Echo {
  std::int64_t re = 0;
  std::int64_t im = 0;
};

// Amplitude of fully developed speckle, of mean square 1: sums of many scatterers of random phase.
std::vector<double> speckle(const Picture& frame, const Grain& grain, std::uint32_t seed) {
  const int margin = static_cast<int>(grain.along.size());
  const int reach = static_cast<int>(grain.across.size());
  std::vector<Echo> rows(static_cast<std::size_t>(frame.width) *
                         static_cast<std::size_t>(frame.height + 2 * margin));
  double squares[2] = {0, 0};
  for (int k = 1 - reach; k < reach; ++k) {
    const double w = grain.across[static_cast<std::size_t>(std::abs(k))];
    squares[0] += w * w;
  }
  for (int k = 1 - margin; k < margin; ++k) {
    const double w = grain.along[static_cast<std::size_t>(std::abs(k))];
    squares[1] += w * w;
  }
  for (int row = 0; row < frame.height + 2 * margin; ++row) {
    for (int column = 0; column < frame.width; ++column) {
      Echo& echo = rows[at(frame, column, row)];
      for (int k = 1 - reach; k < reach; ++k) {
        const std::uint32_t h = hashed(seed, static_cast<std::uint32_t>(column + k + reach),
                                       static_cast<std::uint32_t>(row));
        const int w = grain.across[static_cast<std::size_t>(std::abs(k))];
        echo.re += w * (static_cast<std::int64_t>(h & 0xffffU) - 0x8000);
        echo.im += w * (static_cast<std::int64_t>(h >> 16U) - 0x8000);
      }
    }
  }
  // Of a uniform number of 16 bits, in both parts.
  const double mean_square = 2 * 65536.0 * 65536.0 / 12 * squares[0] * squares[1];
  std::vector<double> amplitude(static_cast<std::size_t>(frame.width) *
                                static_cast<std::size_t>(frame.height));
  for (int row = 0; row < frame.height; ++row) {
    for (int column = 0; column < frame.width; ++column) {
      Echo sum;
      for (int k = 1 - margin; k < margin; ++k) {
        const Echo& echo = rows[at(frame, column, row + margin + k)];
        const int w = grain.along[static_cast<std::size_t>(std::abs(k))];
        sum.re += w * echo.re;
        sum.im += w * echo.im;
      }
      const auto re = static_cast<double>(sum.re);
      const auto im = static_cast<double>(sum.im);
      amplitude[at(frame, column, row)] = std::sqrt((re * re + im * im) / mean_square);
    }
  }
  return amplitude;
}

// Slow differences of echo within a tissue, 0 to 1: values on a grid with smooth ways between them.
double cloud(std::uint32_t seed, double x, double y) {
  const double left = std::floor(x);
  const double low = std::floor(y);
  const auto smooth = [](double s) { return s * s * (3 - 2 * s); };
  const double fx = smooth(x - left);
  const double fy = smooth(y - low);
  const auto value = [&](int i, int j) {
    const auto column = static_cast<std::uint32_t>(static_cast<std::int64_t>(left) + i);
    const auto row = static_cast<std::uint32_t>(static_cast<std::int64_t>(low) + j);
    return (hashed(seed, column, row) >> 8U) / 16777216.0;
  };
  return (1 - fy) * ((1 - fx) * value(0, 0) + fx * value(1, 0)) +
         fy * ((1 - fx) * value(0, 1) + fx * value(1, 1));
}

// Echo of the capsule around each pixel, strongest where the beam, which runs up, meets it squarely.
std::vector<double> capsule_echo(const Picture& frame, std::span<const ReferencePoint> capsule) {
  std::vector<double> echo(static_cast<std::size_t>(frame.width) *
                           static_cast<std::size_t>(frame.height));
  constexpr double width = 0.7e-3;  // m, half
  for (std::size_t i = 0; i < capsule.size(); ++i) {
    const ReferencePoint a = capsule[i];
    const Vector2 edge = capsule[(i + 1) % capsule.size()] - a;
    const double square = dot(edge, edge);
    if (square == 0) continue;
    const double facing = 0.35 + 0.65 * edge.x * edge.x / square;
    const double px = frame.size.x / frame.width;
    const double py = frame.size.y / frame.height;
    const ReferencePoint b = a + edge;
    const auto column_of = [&](double x) {
      return std::clamp(static_cast<int>((x - frame.origin.x) / px), 0, frame.width - 1);
    };
    const auto row_of = [&](double y) {
      return std::clamp(frame.height - 1 - static_cast<int>((y - frame.origin.y) / py), 0,
                        frame.height - 1);
    };
    for (int row = row_of(std::max(a.y, b.y) + width); row <= row_of(std::min(a.y, b.y) - width);
         ++row) {
      for (int column = column_of(std::min(a.x, b.x) - width);
           column <= column_of(std::max(a.x, b.x) + width); ++column) {
        const Vector2 from = place(frame, column, row) - a;
        const Vector2 away = from - std::clamp(dot(from, edge) / square, 0.0, 1.0) * edge;
        const double d = std::sqrt(dot(away, away)) / width;
        if (d >= 1) continue;
        double& here = echo[at(frame, column, row)];
        here = std::max(here, facing * (1 - d) * (1 - d));
      }
    }
  }
  return echo;
}

}  // namespace

void cover(Echoes& echoes, ReferencePoint a, ReferencePoint b, ReferencePoint c, int region) {
  const Picture& frame = echoes.frame;
  const double px = frame.size.x / frame.width;
  const double py = frame.size.y / frame.height;
  const auto [left, right] = std::minmax({a.x, b.x, c.x});
  const auto [low, high] = std::minmax({a.y, b.y, c.y});
  const auto clamped = [](double value, int size) {
    return std::clamp(static_cast<int>(value), 0, size - 1);
  };
  const int first = clamped((left - frame.origin.x) / px, frame.width);
  const int last = clamped((right - frame.origin.x) / px, frame.width);
  const int bottom = frame.height - 1 - clamped((low - frame.origin.y) / py, frame.height);
  const int top = frame.height - 1 - clamped((high - frame.origin.y) / py, frame.height);
  constexpr double round_off = 1e-9;
  for (int row = top; row <= bottom; ++row) {
    for (int column = first; column <= last; ++column) {
      const auto weights = barycentric(a, b, c, place(frame, column, row));
      if (*std::ranges::min_element(weights) < -round_off) continue;
      echoes.region[at(frame, column, row)] = region;
    }
  }
}

Picture ultrasound(const Echoes& echoes, std::uint32_t seed, double attenuation) {
  Picture picture = echoes.frame;
  picture.channels = 1;
  picture.bytes.assign(echoes.region.size(), 0);
  const auto fine_grain = speckle(picture, fine, seed);
  const auto coarse_grain = speckle(picture, coarse, seed + 1);
  const auto capsule = capsule_echo(picture, echoes.capsule);
  const double step = picture.size.y / picture.height;
  double gain = 1;
  for (int row = picture.height - 1; row >= 0; --row) {
    gain *= 1 - std::min(0.5, attenuation * step);
    for (int column = 0; column < picture.width; ++column) {
      const std::size_t i = at(picture, column, row);
      const int region = echoes.region[i];
      if (region == Echoes::nothing) continue;
      const ReferencePoint x = place(picture, column, row);
      const bool inside = !echoes.capsule.empty() &&
                          inside_polygon(std::span<const ReferencePoint>(echoes.capsule), x);
      constexpr double lump = 7e-3;  // m
      const double slow =
          cloud(seed + 2 + static_cast<std::uint32_t>(region), x.x / lump, x.y / lump);
      // A gland is darker and of finer grain than what is around it; further regions differ a little.
      const double tone = (inside ? 0.30 : 0.62) * (1 + 0.15 * (region % 3));
      const double grain = inside ? fine_grain[i] : coarse_grain[i];
      const double echo =
          gain * (tone * (0.45 + 1.1 * slow) * grain + 2.2 * capsule[i] * (0.5 + grain));
      // Amplitudes are shown compressed.
      picture.bytes[i] =
          static_cast<std::uint8_t>(std::min(255.0, std::floor(150 * std::sqrt(echo))));
    }
  }
  return picture;
}

}  // namespace stylet
