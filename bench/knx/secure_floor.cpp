#include <openssl/evp.h>

#include <array>
#include <memory>
#include <stdexcept>

#include "knx/measurements.h"

namespace rubicon::bench::knx {

namespace {

struct FreeContext {
  void operator()(EVP_CIPHER_CTX* context) const { EVP_CIPHER_CTX_free(context); }
};
using Context = std::unique_ptr<EVP_CIPHER_CTX, FreeContext>;

/// The two passes of a wrapper around a telegram of 23 bytes (knx.md, section 10.2): AES-CBC over 64 bytes, AES-CTR
/// over
/// 39. The key is set once; nothing is checked or copied.
class BareWrapper {
 public:
  BareWrapper() : cbc_(EVP_CIPHER_CTX_new()), ctr_(EVP_CIPHER_CTX_new()) {
    const std::array<std::uint8_t, 16> key{1, 2, 3};
    if (EVP_EncryptInit_ex2(cbc_.get(), EVP_aes_128_cbc(), key.data(), start_.data(), nullptr) != 1 ||
        EVP_EncryptInit_ex2(ctr_.get(), EVP_aes_128_ctr(), key.data(), start_.data(), nullptr) != 1)
      throw std::runtime_error("AES-128");
    EVP_CIPHER_CTX_set_padding(cbc_.get(), 0);
  }
  void run() {
    pass(cbc_.get(), 64);
    pass(ctr_.get(), 39);
  }

 private:
  void pass(EVP_CIPHER_CTX* context, int size) {
    int written = 0;
    if (EVP_EncryptInit_ex2(context, nullptr, nullptr, start_.data(), nullptr) != 1 ||
        EVP_EncryptUpdate(context, frame_.data(), &written, frame_.data(), size) != 1)
      throw std::runtime_error("AES-128");
  }

  Context cbc_, ctr_;
  std::array<std::uint8_t, 16> start_{};
  std::array<std::uint8_t, 64> frame_{};
};

}  // namespace

double floor_wrappers(int telegrams) {
  BareWrapper wrapper;
  const auto start = Clock::now();
  for (int i = 0; i < 4 * telegrams; ++i) wrapper.run();  // request and confirmation, each wrapped and opened
  return telegrams / seconds_since(start);
}

}  // namespace rubicon::bench::knx
