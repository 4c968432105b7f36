// What tells two files or texts apart: SHA-256 (FIPS 180-4), as sha256sum prints it.
#pragma once

#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace stylet {

class Fingerprint {
 public:
  Fingerprint();
  Fingerprint(Fingerprint&&) noexcept;
  Fingerprint& operator=(Fingerprint&&) noexcept;
  ~Fingerprint();

  Fingerprint& add(std::string_view bytes);
  /// 64 hexadecimal digits of all bytes so far.
  [[nodiscard]] std::string text() const;

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const noexcept;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

[[nodiscard]] std::string fingerprint(std::string_view bytes);

}  // namespace stylet
