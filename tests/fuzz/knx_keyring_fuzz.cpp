#include <algorithm>
#include <cstdlib>

#include "fuzz_target.h"
#include "networks/knx/keyring/keyring.h"

namespace rubicon::fuzz::knx_keyring_fuzz {

/// Input: a keyring. Its signature is replaced by one that fits, so that decryption sees every ciphertext.
FUZZ_TARGET(knx_keyring) {
  using namespace rubicon;
  using namespace rubicon::networks::knx;
  auto file = keyring::parse_keyring({reinterpret_cast<const char*>(data), size});
  if (!file) {
    if (file.error().text.empty()) std::abort();
    return 0;
  }
  const auto cipher = keyring::Cipher::of_key(secure::Key(), file->created);
  if (!cipher) std::abort();
  if (keyring::Keyring::open(*file, *cipher)) std::abort();  // a signature of the key of zeros
  const auto signature = cipher->sign(file->signed_bytes);
  if (!signature) std::abort();
  file->signature.assign(signature->begin(), signature->end());
  const auto ring = keyring::Keyring::open(*file, *cipher);
  if (!ring) return 0;
  for (const auto& one : file->interfaces) {
    (void)ring->tunnel({one.address});
    (void)ring->tunnel({{}, one.host});
  }
  const auto keys = ring->groups();
  if (keys.groups.size() > file->group_keys.size()) std::abort();
  for (const auto& [address, key] : keys.groups) {
    if (!key.key) std::abort();
  }
  return 0;
}

}  // namespace rubicon::fuzz::knx_keyring_fuzz
