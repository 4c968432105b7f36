#include "stylet/base/fingerprint.hpp"

#include "stylet/base/errors.hpp"

#include <array>
#include <new>
#include <openssl/evp.h>

namespace stylet {

namespace {

void check_digest(int done) {
  if (done != 1) throw Error(ExitCode::other, "OpenSSL has no SHA-256");
}

evp_md_ctx_st* new_context() {
  auto* context = ::EVP_MD_CTX_new();
  if (context == nullptr) throw std::bad_alloc();
  return context;
}

}  // namespace

void Fingerprint::Free::operator()(evp_md_ctx_st* context) const noexcept {
  ::EVP_MD_CTX_free(context);
}

Fingerprint::Fingerprint() : context_(new_context()) {
  check_digest(::EVP_DigestInit_ex(context_.get(), ::EVP_sha256(), nullptr));
}

Fingerprint::Fingerprint(Fingerprint&&) noexcept = default;
Fingerprint& Fingerprint::operator=(Fingerprint&&) noexcept = default;
Fingerprint::~Fingerprint() = default;

Fingerprint& Fingerprint::add(std::string_view bytes) {
  check_digest(::EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()));
  return *this;
}

std::string Fingerprint::text() const {
  const std::unique_ptr<evp_md_ctx_st, Free> end(new_context());  // more may be added to ours
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
  unsigned int n_bytes = 0;
  check_digest(::EVP_MD_CTX_copy_ex(end.get(), context_.get()));
  check_digest(::EVP_DigestFinal_ex(end.get(), bytes.data(), &n_bytes));
  std::string digits;
  for (unsigned int i = 0; i < n_bytes; ++i) {
    digits += "0123456789abcdef"[bytes[i] >> 4];
    digits += "0123456789abcdef"[bytes[i] & 0xf];
  }
  return digits;
}

std::string fingerprint(std::string_view bytes) {
  return Fingerprint().add(bytes).text();
}

}  // namespace stylet
