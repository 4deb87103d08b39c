#include "support/keyring_writer.h"

#include <algorithm>
#include <random>

#include "base/bytes.h"
#include "networks/knx/secure/crypto.h"
#include "support/xml_text.h"

namespace rubicon::support {

namespace {

namespace secure = networks::knx::secure;
using Attribute = KeyringElement::Attribute;

class KeyringWriter {
 public:
  KeyringWriter(const std::string& password, const std::string& created, unsigned seed)
      : key_(secure::key_of_password(base::as_bytes(password), "1.keyring.ets.knx.org").value()), random_(seed) {
    const auto digest = secure::sha256(base::as_bytes(created)).value();
    std::copy_n(digest.begin(), start_.size(), start_.begin());
  }

  std::string write(KeyringElement root) {
    encrypt(root);
    sign(root);
    sign(base::to_base64(base::as_text(key_.view())));
    const auto digest = secure::sha256(base::as_bytes(signed_)).value();
    root.text("Signature", base::to_base64(base::as_text(ByteView(digest).first(16))));
    root.text("xmlns", "http://knx.org/xml/keyring/1");
    return "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n" + xml(root, "");
  }

 private:
  void encrypt(KeyringElement& element) {
    for (auto& attribute : element.attributes) {
      if (attribute.kind == Attribute::Kind::kKey) attribute.value = encrypted(base::from_hex(attribute.value).value());
      if (attribute.kind == Attribute::Kind::kPassword) attribute.value = encrypted(padded(attribute.value));
    }
    for (auto& child : element.children) encrypt(child);
  }
  Bytes padded(const std::string& text) {
    Bytes out;
    for (int i = 0; i < 8; ++i) out.push_back(static_cast<std::uint8_t>(random_()));
    out.insert(out.end(), text.begin(), text.end());
    const auto block = random_() % 2 == 0 ? std::size_t{16} : std::size_t{32};  // ETS pads to 32
    const auto padding = block - out.size() % block;
    out.insert(out.end(), padding, static_cast<std::uint8_t>(padding));
    return out;
  }
  std::string encrypted(const Bytes& content) {
    return base::to_base64(base::as_text(secure::encrypt_cbc(key_, start_, content).value()));
  }

  void sign(const std::string& text) {
    signed_ += static_cast<char>(text.size() % 256);
    signed_ += text;
  }
  void sign(const KeyringElement& element) {
    signed_ += '\1';
    sign(element.name);
    auto sorted = element.attributes;
    std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
    for (const auto& attribute : sorted) {
      sign(attribute.name);
      sign(attribute.value);
    }
    for (const auto& child : element.children) sign(child);
    signed_ += '\2';
  }

  static std::string xml(const KeyringElement& element, const std::string& indent) {
    std::string out = indent + "<" + element.name;
    for (const auto& attribute : element.attributes)
      out += " " + attribute.name + "=\"" + xml_attribute(attribute.value) + "\"";
    if (element.children.empty()) return out + " />\n";
    out += ">\n";
    for (const auto& child : element.children) out += xml(child, indent + "  ");
    return out + indent + "</" + element.name + ">\n";
  }

  secure::Key key_;
  secure::Block start_{};
  std::mt19937 random_;
  std::string signed_;
};

}  // namespace

std::string write_keyring(const KeyringElement& root, const std::string& password, unsigned seed) {
  std::string created;
  for (const auto& attribute : root.attributes) {
    if (attribute.name == "Created") created = attribute.value;
  }
  return KeyringWriter(password, created, seed).write(root);
}

KeyringElement keyring_root(const std::string& project) {
  return KeyringElement{"Keyring"}
      .text("Project", project)
      .text("CreatedBy", "test")
      .text("Created", "2026-11-20T23:50:00");
}

}  // namespace rubicon::support
