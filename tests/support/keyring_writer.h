#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace rubicon::support {

/// An element of a keyring with its values in clear.
struct KeyringElement {
  struct Attribute {
    enum class Kind : std::uint8_t { kText, kKey, kPassword };
    std::string name, value;  ///< a key as hex digits
    Kind kind = Kind::kText;
  };

  std::string name;
  std::vector<Attribute> attributes{};
  std::vector<KeyringElement> children{};

  KeyringElement& text(std::string attribute, std::string value) {
    attributes.push_back({std::move(attribute), std::move(value), Attribute::Kind::kText});
    return *this;
  }
  KeyringElement& key(std::string attribute, std::string hex) {
    attributes.push_back({std::move(attribute), std::move(hex), Attribute::Kind::kKey});
    return *this;
  }
  KeyringElement& password(std::string attribute, std::string value) {
    attributes.push_back({std::move(attribute), std::move(value), Attribute::Kind::kPassword});
    return *this;
  }
  KeyringElement& add(KeyringElement child) {
    children.push_back(std::move(child));
    return *this;
  }
};

/// The keyring of a project as XML, encrypted and signed with the password (knx.md, section 12): the inverse of reading
/// one. The root must be `Keyring` with the attribute Created. `seed`: of the random bytes before passwords.
std::string write_keyring(const KeyringElement& root, const std::string& password, unsigned seed = 1);

/// A root element with these attributes.
KeyringElement keyring_root(const std::string& project = "House");

}  // namespace rubicon::support
