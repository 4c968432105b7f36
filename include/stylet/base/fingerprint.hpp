// What tells two files or texts apart: SHA-256 (FIPS 180-4), as sha256sum prints it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace stylet {

class Fingerprint {
 public:
  Fingerprint& add(std::string_view bytes);
  /// 64 hexadecimal digits of all bytes so far.
  [[nodiscard]] std::string text() const;

 private:
  void take(const char* block);

  static constexpr std::size_t block_size = 64;
  std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::string rest_;  ///< bytes that do not fill a block yet
  std::uint64_t n_bytes_ = 0;
};

[[nodiscard]] std::string fingerprint(std::string_view bytes);

}  // namespace stylet
